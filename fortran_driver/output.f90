! The files history.csv, newton.log and ddsdde.csv, and the table on the screen.
module output
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: dp => real64, output_unit
  use material_point, only: point, ntens
  use text, only: str, stop_run, status_input
  implicit none
  private
  public :: report, open_report, open_csv, csv

  type :: report
    logical :: quiet = .false.
    integer :: history = 0, log = 0           ! units; log = 0: none is kept
    real(dp) :: print_every = 0, next_print = -huge(1.0_dp)
  contains
    procedure :: row, iteration, say
  end type report

  interface
    function mkdir(path, mode) bind(c) result(status)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
      integer(c_int) :: status
    end function mkdir
  end interface

contains

  subroutine open_report(folder, quiet, keep_log, print_every, r)
    character(len=*), intent(in) :: folder
    logical, intent(in) :: quiet, keep_log
    real(dp), intent(in) :: print_every
    type(report), intent(out) :: r

    r%quiet = quiet
    r%print_every = print_every
    call open_csv(folder, 'history.csv', &
                  'time,G,lambda_e,lambda,J,Je,s11,s22,s33,s12,s13,s23,reaction,iterations', r%history)
    if (keep_log) then
      call open_csv(folder, 'newton.log', 'increment,time,dt,iteration,residual,correction', r%log)
    end if
  end subroutine open_report

  ! A new file in a folder, which is made if it is missing, with its first line.
  subroutine open_csv(folder, name, header, unit)
    character(len=*), intent(in) :: folder, name, header
    integer, intent(out) :: unit
    integer(c_int), parameter :: everyone = int(o'777', c_int)
    character(len=256) :: message
    integer :: i, status

    do i = 2, len(folder) + 1  ! a folder that exists, or cannot be made, shows when the file is opened
      if (index(folder(i:)//'/', '/') == 1) status = mkdir(folder(:i - 1)//c_null_char, everyone)
    end do
    open (newunit=unit, file=folder//'/'//name, status='replace', action='write', iostat=status, &
          iomsg=message)
    if (status /= 0) call stop_run(status_input, folder//'/'//name//': cannot be written: '//trim(message))
    write (unit, '(a)') header
  end subroutine open_csv

  ! One row of the history, the points averaged: they have equal reference volumes.
  subroutine row(r, time, points, reaction, iterations, last)
    class(report), intent(inout) :: r
    real(dp), intent(in) :: time, reaction
    type(point), intent(in) :: points(:)
    integer, intent(in) :: iterations
    logical, intent(in) :: last
    real(dp) :: state(5), stress(ntens)
    integer :: p, n

    state = 0
    stress = 0
    do p = 1, size(points)
      n = min(5, size(points(p)%statev))
      state(:n) = state(:n) + points(p)%statev(:n)/size(points)
      stress = stress + points(p)%stress/size(points)
    end do
    write (r%history, '(a)') csv([time, state, stress, reaction])//','//str(iterations)
    flush (r%history)  ! a UMAT may bring the program down
    if (r%quiet .or. (time < r%next_print .and. .not. last)) return
    if (r%next_print <= -huge(time)) then
      call r%say('        time           G    lambda_e      lambda           J           s11'// &
                 '      reaction  iterations')
    end if
    write (output_unit, '(f12.5, 4f12.6, 2es14.5, i12)') time, state(1:4), stress(1), reaction, iterations
    r%next_print = time + r%print_every*(1 - 1.0e-6_dp)
  end subroutine row

  subroutine iteration(r, increment, time, dt, number, residual, correction)
    class(report), intent(in) :: r
    integer, intent(in) :: increment, number
    real(dp), intent(in) :: time, dt, residual, correction

    if (r%log == 0) return
    write (r%log, '(a)') str(increment)//','//csv([time, dt])//','//str(number)//','// &
      csv([residual, correction])
  end subroutine iteration

  subroutine say(r, line)
    class(report), intent(in) :: r
    character(len=*), intent(in) :: line

    if (.not. r%quiet) write (output_unit, '(a)') line
  end subroutine say

  ! Every digit of every value, comma-separated, without blanks.
  function csv(values) result(line)
    real(dp), intent(in) :: values(:)
    character(len=:), allocatable :: line
    character(len=25) :: one
    integer :: i

    line = ''
    do i = 1, size(values)
      write (one, '(es25.16e3)') values(i)
      if (i > 1) line = line//','
      line = line//trim(adjustl(one))
    end do
  end function csv

end module output
