! One material point led along a path of deformation gradients from a file: one UMAT call per row.
module prescribed_path
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use files, only: text_file, read_file
  use input, only: most_time
  use material_point, only: material, point, increment, new_point, update, external_call, determinant, identity, &
                            increment_begins, increment_ends
  use output, only: report
  use text, only: exact, read_number, str, visible, stop_run, status_input, status_run
  implicit none
  private
  public :: path, read_path, run_path

  character(len=4), parameter :: column(10) = [character(len=4) :: 'time', 'F11', 'F12', 'F13', 'F21', 'F22', &
    'F23', 'F31', 'F32', 'F33']
  character(len=*), parameter :: header = 'time,F11,F12,F13,F21,F22,F23,F31,F32,F33'

  type :: path
    character(len=:), allocatable :: name
    integer, allocatable :: line(:)        ! of each row in the file
    real(dp), allocatable :: value(:, :)   ! (10, rows)
  end type path

contains

  ! All rows, checked before the first is run.
  function read_path(name) result(p)
    character(len=*), intent(in) :: name
    type(path) :: p
    type(text_file) :: file
    character(len=:), allocatable :: line
    integer, allocatable :: longer_line(:)
    real(dp), allocatable :: longer_value(:, :)
    integer :: rows

    file = read_file(name)
    p%name = name
    allocate (p%line(64), p%value(10, 64))
    rows = -1  ! the header is none
    do while (file%read_line(line))
      line = without_separators(line)
      if (len(line) == 0) cycle
      if (line(1:1) == '#') cycle
      rows = rows + 1
      if (rows == 0) then
        call check_header(file, line)
        cycle
      end if
      if (rows > size(p%line)) then
        allocate (longer_line(2*rows), longer_value(10, 2*rows))
        longer_line(:rows - 1) = p%line
        longer_value(:, :rows - 1) = p%value
        call move_alloc(longer_line, p%line)
        call move_alloc(longer_value, p%value)
      end if
      p%line(rows) = file%number
      call read_row(file, line, p%value(:, rows))
      if (rows > 1) then
        if (.not. p%value(1, rows) > p%value(1, rows - 1)) then
          call file%stop_at('time = '//exact(p%value(1, rows))//': must be greater than that of the row before, '// &
                            exact(p%value(1, rows - 1)))
        end if
      end if
    end do
    if (rows < 1) call stop_run(status_input, name//': has no row; expected '//header//' and rows of numbers')
    p%line = p%line(:rows)
    p%value = p%value(:, :rows)
  end function read_path

  ! Blanks and tabs at the ends of a line say nothing, nor do the commas of a spreadsheet's empty columns at its end.
  function without_separators(line) result(rest)
    character(len=*), intent(in) :: line
    character(len=:), allocatable :: rest
    integer :: start, finish

    start = max(1, verify(line, ' '//achar(9)))
    finish = verify(line, ' ,'//achar(9), back=.true.)
    rest = line(start:finish)
  end function without_separators

  subroutine check_header(file, line)
    type(text_file), intent(in) :: file
    character(len=*), intent(in) :: line
    character(len=:), allocatable :: names, hint
    integer :: i

    names = ''
    do i = 1, min(len(line), 1000)
      if (line(i:i) /= ' ') names = names//line(i:i)
    end do
    if (names == header) return
    hint = ''
    if (index(line, ';') > 0) hint = ' (separated by commas, not by semicolons)'
    if (index(line, achar(9)) > 0) hint = ' (separated by commas, not by tabs)'
    call file%stop_at('the header must be '//header//hint//', found '//visible(line))
  end subroutine check_header

  subroutine read_row(file, line, value)
    type(text_file), intent(in) :: file
    character(len=*), intent(in) :: line
    real(dp), intent(out) :: value(10)
    character(len=:), allocatable :: rest, fault, hint
    integer :: k, comma, n

    rest = line//','
    n = 0
    do k = 1, len(rest)
      if (rest(k:k) == ',') n = n + 1
    end do
    do k = 1, min(n, size(value))
      comma = index(rest, ',')
      call read_number(trim(adjustl(rest(:comma - 1))), .false., value(k), fault)
      if (fault /= '') call file%stop_at('column '//str(k)//', '//trim(column(k))//': '//fault)
      rest = rest(comma + 1:)
    end do
    if (n /= size(value)) then
      hint = ''
      if (n > size(value)) hint = ' (a number has a decimal point, not a comma)'
      call file%stop_at('10 numbers are expected, found '//str(n)//hint//': '//visible(line))
    end if
    if (abs(value(1)) > most_time) call file%stop_at('time = '//str(value(1))//': must be -1e12 to 1e12')
    if (.not. any(abs(value(2:)) > 0)) call file%stop_at('F is zero in all nine entries, and det F must be > 0')
  end subroutine read_row

  subroutine run_path(p, m, r)
    type(path), intent(in) :: p
    type(material), intent(in) :: m
    type(report), intent(inout) :: r
    type(point) :: now, next
    type(increment) :: inc
    real(dp) :: ddsdde(6, 6), F(3, 3), time, pnewdt
    integer :: i

    now = new_point(m, 1, [0.0_dp, 0.0_dp, 0.0_dp])
    next = now
    time = p%value(1, 1)
    if (m%library%is_ours) then
      call update(m, now, increment(time, 0.0_dp, 1), identity, [0.0_dp, 0.0_dp, 0.0_dp], 1.0_dp, next, ddsdde, pnewdt)
      if (.not. pnewdt >= 1) then
        call stop_run(status_input, p%name//': PROPS or STATEV cannot be used: before the first row, at F = 1 and '// &
                      'without time, the UMAT asks for PNEWDT = '//str(pnewdt))
      end if
    end if

    do i = 1, size(p%line)
      F = transpose(reshape(p%value(2:, i), [3, 3]))
      if (i == 1 .and. .not. m%library%is_ours .and. all(abs(F - identity) <= 0)) then
        call r%row(time, [now], 0.0_dp, 0, last=.false.)  ! where the path begins: no call without time, see solver.f90
        cycle
      end if
      inc = increment(time, p%value(1, i) - time, i)
      call external_call(m, increment_begins, time, inc)
      call update(m, now, inc, F, [0.0_dp, 0.0_dp, 0.0_dp], 1.0_dp, next, ddsdde, pnewdt)
      if (.not. determinant(F) > 0) then
        call stop_here('det F = '//str(determinant(F))//': must be > 0')
      else if (.not. pnewdt >= 1) then
        call stop_here('the UMAT asks for PNEWDT = '//str(pnewdt)//' at det F = '//str(determinant(F)))
      else if (.not. (all(ieee_is_finite(next%stress)) .and. all(ieee_is_finite(ddsdde)))) then
        call stop_here('the UMAT returned a stress or a tangent that is not a number'// &
                       trim(merge(', called with DTIME = 0 as the first row is', repeat(' ', 43), i == 1)))
      end if
      now = next
      time = p%value(1, i)
      call external_call(m, increment_ends, time, inc)
      call r%row(time, [now], 0.0_dp, 1, last=.false.)
      call r%tangent(time, ddsdde)
    end do
    call r%tell(str(size(p%line))//' rows')

  contains

    subroutine stop_here(what)
      character(len=*), intent(in) :: what

      call stop_run(status_run, p%name//':'//str(p%line(i))//': row '//str(i)//', time '//str(p%value(1, i))// &
                    ': '//what//'. history.csv has the rows before.')
    end subroutine stop_here

  end subroutine run_path

end module prescribed_path
