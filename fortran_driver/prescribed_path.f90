! One material point led along a path of deformation gradients from a file: one UMAT call per row.
module prescribed_path
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use material_point, only: material, point, increment, new_point, update
  use output, only: report, open_csv, csv
  use text, only: read_line, str, stop_run, status_input, status_run
  implicit none
  private
  public :: run_path

  character(len=*), parameter :: header = 'time,F11,F12,F13,F21,F22,F23,F31,F32,F33'

contains

  subroutine run_path(file, m, folder, r)
    character(len=*), intent(in) :: file, folder
    type(material), intent(in) :: m
    type(report), intent(inout) :: r
    character(len=:), allocatable :: line, columns
    type(point) :: now, next
    real(dp) :: value(10), ddsdde(6, 6), time, pnewdt
    character(len=256) :: message
    integer :: unit, moduli, status, number, rows, i, j

    open (newunit=unit, file=file, status='old', action='read', iostat=status, iomsg=message)
    if (status /= 0) call stop_run(status_input, file//': cannot be opened: '//trim(message))
    columns = 'time'
    do i = 1, 6
      do j = 1, 6
        columns = columns//',D'//str(i)//str(j)
      end do
    end do
    call open_csv(folder, 'ddsdde.csv', columns, moduli)

    now = new_point(m, 1)  ! undeformed before the first row
    next = now
    time = 0
    number = 0
    rows = -1  ! the header is none
    do
      call read_line(unit, line, status)
      if (status /= 0) exit
      number = number + 1
      line = trim(adjustl(line))
      if (len(line) == 0) cycle
      if (line(1:1) == '#') cycle
      rows = rows + 1
      if (rows == 0) then
        if (line /= header) call wrong('the header must be '//header//', found '//line)
        cycle
      end if
      call read_numbers()
      if (rows == 1) time = value(1)
      if (rows > 1 .and. .not. value(1) > time) then
        call wrong('time = '//str(value(1))//': must be greater than that of the row before, '//str(time))
      end if

      call update(m, now, increment(time, value(1) - time, rows), transpose(reshape(value(2:), [3, 3])), &
                  [0.0_dp, 0.0_dp, 0.0_dp], 1.0_dp, next, ddsdde, pnewdt)
      if (.not. pnewdt >= 1) then
        call stop_here('the UMAT asks for PNEWDT = '//str(pnewdt))
      else if (.not. (all(ieee_is_finite(next%stress)) .and. all(ieee_is_finite(ddsdde)))) then
        call stop_here('the UMAT returned a stress or a tangent that is not a number')
      end if
      now = next
      time = value(1)
      call r%row(time, [now], 0.0_dp, 1, last=.false.)
      write (moduli, '(a)') csv([time, transpose(ddsdde)])
    end do
    close (unit)
    close (moduli)
    if (rows < 1) call stop_run(status_input, file//': has no row; expected '//header//' and rows of numbers')
    call r%say(str(rows)//' rows')
  contains

    subroutine read_numbers()
      character(len=:), allocatable :: rest
      integer :: k, comma

      rest = line//','
      do k = 1, 10
        comma = index(rest, ',')
        if (comma == 0) call wrong('10 numbers are expected, found '//str(k - 1))
        read (rest(:comma - 1), *, iostat=status) value(k)
        if (status /= 0 .or. verify(trim(adjustl(rest(:comma - 1))), '+-.0123456789eEdD') > 0) then
          call wrong('number '//str(k)//' of the row: "'//rest(:comma - 1)//'" is not a number')
        end if
        rest = rest(comma + 1:)
      end do
      if (len(rest) > 0) call wrong('10 numbers are expected, found more')
      if (.not. all(ieee_is_finite(value))) call wrong('every number must be finite')
    end subroutine read_numbers

    subroutine wrong(what)
      character(len=*), intent(in) :: what

      call stop_run(status_input, file//':'//str(number)//': '//what)
    end subroutine wrong

    subroutine stop_here(what)
      character(len=*), intent(in) :: what

      call stop_run(status_run, file//':'//str(number)//': row '//str(rows)//', time '//str(value(1))// &
                    ': '//what//'. history.csv has the rows before.')
    end subroutine stop_here

  end subroutine run_path

end module prescribed_path
