! Words and numbers as text, text as numbers, and the end of a run that cannot continue.
module text
  use, intrinsic :: iso_fortran_env, only: dp => real64, error_unit
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use run_end, only: end_run
  implicit none
  private
  public :: lower, str, exact, visible, escaped, read_number, note, stop_run, status_input, status_run, status_output

  integer, parameter :: status_input = 1   ! exit status: something in the input is wrong
  integer, parameter :: status_run = 2     ! exit status: the input is right, the run could not be finished
  integer, parameter :: status_output = 3  ! exit status: a result could not be written

  interface str
    module procedure str_integer, str_real
  end interface str

contains

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

  ! All digits where six are not enough, for numbers that are compared.
  function exact(x) result(text)
    real(dp), intent(in) :: x
    character(len=:), allocatable :: text
    character(len=24) :: buffer
    real(dp) :: shown

    text = str(x)
    read (text, *) shown
    if (abs(shown - x) > 0) then
      write (buffer, '(es24.16e3)') x
      text = trim(adjustl(buffer))
    end if
  end function exact

  ! What a file or a user gave, as a message shows it: one line of ASCII, of limited length.
  function visible(text) result(shown)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: shown
    integer, parameter :: most = 100, start = 80

    if (len(text) > most) then
      shown = escaped(text(:start), 127)//' ... ('//str(len(text))//' characters)'
    else
      shown = escaped(text, 127)
    end if
  end function visible

  ! The text with control characters, and all above `last`, as \xNN.
  pure function escaped(text, last) result(shown)
    character(len=*), intent(in) :: text
    integer, intent(in) :: last
    character(len=:), allocatable :: shown
    character(len=16), parameter :: digits = '0123456789ABCDEF'
    integer :: i, code

    shown = ''
    do i = 1, len(text)
      code = iachar(text(i:i))
      if (code < 32 .or. code == 127 .or. code > last) then
        shown = shown//'\x'//digits(code/16 + 1:code/16 + 1)//digits(modulo(code, 16) + 1:modulo(code, 16) + 1)
      else
        shown = shown//text(i:i)
      end if
    end do
  end function escaped

  ! The number that a word is, to the last bit. `fault` is empty, or says what is wrong with the word. NaN and
  ! infinities are numbers only where `any_value` says so.
  subroutine read_number(word, any_value, x, fault)
    character(len=*), intent(in) :: word
    logical, intent(in) :: any_value
    real(dp), intent(out) :: x
    character(len=:), allocatable, intent(out) :: fault
    logical :: is_named
    integer :: status, mantissa

    x = 0
    fault = ''
    is_named = any(lower(word(verify(word//'.', '+-'):)) == [character(len=8) :: 'nan', 'inf', 'infinity'])
    if (len(word) == 0) then
      fault = 'a number is missing'
    else if (is_named .and. .not. any_value) then
      fault = '"'//visible(word)//'" must be a finite number'
    else if (.not. (is_named .or. is_decimal(word))) then
      fault = '"'//visible(word)//'" is not a number'
      if (index(word, ';') > 0) fault = fault//': numbers are separated by commas, not by semicolons'
      if (index(word, achar(9)) > 0) fault = fault//': numbers are separated by commas, not by tabs'
    else
      read (word, *, iostat=status) x
      mantissa = scan(lower(word)//'e', 'ed') - 1
      if (status /= 0 .or. (.not. (is_named .or. ieee_is_finite(x))) .or. &
          (.not. is_named .and. .not. abs(x) > 0 .and. scan(word(:mantissa), '123456789') > 0)) then
        fault = '"'//visible(word)//'" is beyond the range of double precision'
      end if
    end if
  end subroutine read_number

  ! [+-] digits [. digits] [(e|d) [+-] digits]. Fortran's own reading accepts more: 1+5, 2*3, 1/2, 1;2.
  pure logical function is_decimal(word)
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: rest
    integer :: before, after

    rest = lower(word)//' '
    if (scan(rest(1:1), '+-') == 1) rest = rest(2:)
    call skip_digits(rest, before)
    after = 0
    if (rest(1:1) == '.') then
      rest = rest(2:)
      call skip_digits(rest, after)
    end if
    is_decimal = before + after > 0
    if (scan(rest(1:1), 'ed') == 1) then
      rest = rest(2:)
      if (scan(rest(1:1), '+-') == 1) rest = rest(2:)
      call skip_digits(rest, after)
      is_decimal = is_decimal .and. after > 0
    end if
    is_decimal = is_decimal .and. rest == ''
  end function is_decimal

  pure subroutine skip_digits(rest, n)
    character(len=:), allocatable, intent(inout) :: rest
    integer, intent(out) :: n

    n = verify(rest, '0123456789') - 1
    rest = rest(n + 1:)
  end subroutine skip_digits

  ! What is given and not used, on standard error.
  subroutine note(message)
    character(len=*), intent(in) :: message

    write (error_unit, '(a)') 'note: '//escaped(message, 255)
  end subroutine note

  ! The message may hold names of files, in any encoding: only what would break its line is escaped.
  subroutine stop_run(status, message)
    integer, intent(in) :: status
    character(len=*), intent(in) :: message

    write (error_unit, '(a)') escaped(message, 255)
    call end_run(status)
  end subroutine stop_run

end module text
