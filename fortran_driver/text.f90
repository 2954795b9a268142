! Lines, words and numbers as text, and the end of a run that cannot go on.
module text
  use, intrinsic :: iso_fortran_env, only: dp => real64, error_unit, iostat_eor
  implicit none
  private
  public :: string, read_line, lower, str, stop_run, status_input, status_run

  integer, parameter :: status_input = 1  ! exit status: something in the input is wrong
  integer, parameter :: status_run = 2    ! exit status: the input is right, the run could not be finished

  type :: string  ! an element of an array of texts of different length
    character(len=:), allocatable :: s
  end type string

  interface str
    module procedure str_integer, str_real
  end interface str

contains

  ! The next line, of any length, without carriage return and trailing blanks; status /= 0 at the end of the
  ! file.
  subroutine read_line(unit, line, status)
    integer, intent(in) :: unit
    character(len=:), allocatable, intent(out) :: line
    integer, intent(out) :: status
    character(len=512) :: part
    integer :: length

    line = ''
    do
      read (unit, '(a)', advance='no', iostat=status, size=length) part
      if (status /= 0 .and. status /= iostat_eor) then
        if (len(line) > 0) status = 0  ! the last line may lack its end
        exit
      end if
      line = line//part(:length)
      if (status == iostat_eor) then
        status = 0
        exit
      end if
    end do
    length = len(line)
    if (length > 0) then
      if (line(length:) == achar(13)) length = length - 1
    end if
    line = trim(line(:length))
  end subroutine read_line

  pure function lower(text) result(small)
    character(len=*), intent(in) :: text
    character(len=len(text)) :: small
    integer :: i

    small = text
    do i = 1, len(text)
      if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') small(i:i) = achar(iachar(text(i:i)) + 32)
    end do
  end function lower

  function str_integer(i) result(text)
    integer, intent(in) :: i
    character(len=:), allocatable :: text
    character(len=20) :: buffer

    write (buffer, '(i0)') i
    text = trim(buffer)
  end function str_integer

  ! Six digits, for messages.
  function str_real(x) result(text)
    real(dp), intent(in) :: x
    character(len=:), allocatable :: text
    character(len=24) :: buffer

    if (abs(x) >= 1.0e-3_dp .and. abs(x) < 1.0e6_dp) then
      write (buffer, '(f0.6)') x
      text = trim(buffer)
      text = text(:verify(text, '0', back=.true.))
      if (text(len(text):) == '.') text = text(:len(text) - 1)
      if (text(1:1) == '.') text = '0'//text
      if (len(text) > 1) then
        if (text(1:2) == '-.') text = '-0'//text(2:)
      end if
    else if (abs(x) > 0) then
      write (buffer, '(es12.5)') x
      text = trim(adjustl(buffer))
    else if (x < 1) then
      text = '0'
    else
      text = 'NaN'
    end if
  end function str_real

  subroutine stop_run(status, message)
    integer, intent(in) :: status
    character(len=*), intent(in) :: message

    write (error_unit, '(a)') message
    if (status == status_input) stop status_input, quiet=.true.
    stop status_run, quiet=.true.
  end subroutine stop_run

end module text
