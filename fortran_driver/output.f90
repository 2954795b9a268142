! The files history.csv, newton.log and ddsdde.csv, and the table on the screen.
module output
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use files, only: output_file, create_file, is_same_file, make_folder, remove_file, say
  use input, only: name_length
  use material_point, only: point, ntens
  use run_end, only: time_reached
  use text, only: note, status_input, stop_run, str
  implicit none
  private
  public :: report, open_report, csv

  type :: report
    type(output_file) :: history, log, moduli  ! log and moduli: closed if they are not kept
    logical :: quiet = .false.
    real(dp) :: print_every = 0, next_print = -huge(1.0_dp)
    character(len=name_length), allocatable :: states(:)  ! the columns of the first STATEV
    logical :: told = .false.                             ! that one is not a number
  contains
    procedure :: row, iteration, tangent, tell, close => close_report
  end type report

contains

  ! The folder is made and the files are created before the first step, so that a run that cannot write them does
  ! not start. Files of an earlier run are removed. `inputs`: what the run reads must not be one of them.
  subroutine open_report(folder, inputs, states, quiet, keep_log, keep_moduli, print_every, r)
    character(len=*), intent(in) :: folder, inputs(:), states(:)
    logical, intent(in) :: quiet, keep_log, keep_moduli
    real(dp), intent(in) :: print_every
    type(report), intent(out) :: r
    character(len=11), parameter :: names(3) = [character(len=11) :: 'history.csv', 'newton.log', 'ddsdde.csv']
    character(len=:), allocatable :: columns
    integer :: i, j

    r%quiet = quiet
    r%states = states
    r%print_every = print_every
    do i = 1, size(inputs)
      do j = 1, size(names)
        if (inputs(i) == '') cycle
        if (is_same_file(trim(inputs(i)), folder//'/'//trim(names(j)))) then
          call stop_run(status_input, trim(inputs(i))//': is read, and would be written over as '//folder//'/'// &
                        trim(names(j)))
        end if
      end do
    end do
    call make_folder(folder)
    if (.not. keep_log) call remove_file(folder//'/newton.log')
    if (.not. keep_moduli) call remove_file(folder//'/ddsdde.csv')
    columns = 'time'
    do i = 1, size(states)
      columns = columns//','//trim(states(i))
    end do
    call create_file(folder//'/history.csv', columns//',s11,s22,s33,s12,s13,s23,reaction,iterations', r%history)
    if (keep_log) then
      call create_file(folder//'/newton.log', 'increment,time,dt,iteration,residual,correction', r%log)
    end if
    if (keep_moduli) then
      columns = 'time'
      do i = 1, ntens
        do j = 1, ntens
          columns = columns//',D'//str(i)//str(j)
        end do
      end do
      call create_file(folder//'/ddsdde.csv', columns, r%moduli)
    end if
  end subroutine open_report

  ! One row of the history, the points averaged: they have equal reference volumes.
  subroutine row(r, time, points, reaction, iterations, last)
    class(report), intent(inout) :: r
    real(dp), intent(in) :: time, reaction
    type(point), intent(in) :: points(:)
    integer, intent(in) :: iterations
    logical, intent(in) :: last
    real(dp) :: state(size(r%states)), stress(ntens)
    character(len=:), allocatable :: line
    character(len=12) :: count
    integer :: p, n

    state = 0
    stress = 0
    do p = 1, size(points)
      n = min(size(state), size(points(p)%statev))
      state(:n) = state(:n) + points(p)%statev(:n)/size(points)
      stress = stress + points(p)%stress/size(points)
    end do
    call r%history%put(csv([time, state, stress, reaction])//','//str(iterations))
    time_reached = time
    if (.not. (r%told .or. all(ieee_is_finite([state, stress])))) then
      n = findloc(ieee_is_finite([state, stress]), .false., 1)
      line = 'the stress'
      if (n <= size(state)) line = 'STATEV('//str(n)//'), '//trim(r%states(n))//','
      call note(line//' is not a number at time '//str(time)//', and in later rows where history.csv says so')
      r%told = .true.
    end if
    if (r%quiet .or. (time < r%next_print .and. .not. last)) return
    if (r%next_print <= -huge(time)) then
      line = '        time'
      do n = 1, min(4, size(state))
        line = line//' '//adjustr(r%states(n)(:11))
      end do
      call r%tell(line//'           s11      reaction  iterations')
    end if
    write (count, '(i12)') iterations
    line = column(time, '(f12.5)')
    do n = 1, min(4, size(state))
      line = line//column(state(n), '(f12.6)')
    end do
    call r%tell(line//column(stress(1), '(es14.5)')//column(reaction, '(es14.5)')//count)
    r%next_print = time + r%print_every*(1 - 1.0e-6_dp)
  end subroutine row

  subroutine iteration(r, increment, time, dt, number, residual, correction)
    class(report), intent(in) :: r
    integer, intent(in) :: increment, number
    real(dp), intent(in) :: time, dt, residual, correction

    call r%log%put(str(increment)//','//csv([time, dt])//','//str(number)//','//csv([residual, correction]))
  end subroutine iteration

  subroutine tangent(r, time, ddsdde)
    class(report), intent(in) :: r
    real(dp), intent(in) :: time, ddsdde(ntens, ntens)

    call r%moduli%put(csv([time, transpose(ddsdde)]))
  end subroutine tangent

  subroutine tell(r, line)
    class(report), intent(in) :: r
    character(len=*), intent(in) :: line

    if (.not. r%quiet) call say(line)
  end subroutine tell

  subroutine close_report(r)
    class(report), intent(inout) :: r

    call r%history%close()
    call r%log%close()
    call r%moduli%close()
  end subroutine close_report

  ! A number in a column of the screen, in powers of ten where the column is too narrow for it.
  function column(x, form) result(text)
    real(dp), intent(in) :: x
    character(len=*), intent(in) :: form
    character(len=:), allocatable :: text
    character(len=14) :: buffer

    write (buffer, form) x
    text = buffer(:merge(14, 12, form(2:3) == 'es'))
    if (text(1:1) == ' ') return
    write (text, '(1x, es11.3e3)') x
  end function column

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
