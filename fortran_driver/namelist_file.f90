! A file of namelist groups, taken apart into assignments whose values know their line and column. The compiler's
! own reading of namelists names neither, and takes 0;5 for 0, fast for .false. and the last of two assignments.
module namelist_file
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use files, only: text_file, read_file
  use text, only: lower, str, visible, read_number, stop_run, status_input
  implicit none
  private
  public :: group, read_groups, most_values

  integer, parameter :: most_values = 1000  ! of one variable

  type :: word
    character(len=:), allocatable :: text  ! empty between two commas
    integer :: line, column
  end type word

  ! NAME = VALUES or NAME(FIRST) = VALUES
  type :: assignment
    character(len=:), allocatable :: name    ! lower case
    integer :: first = 0                     ! the subscript; 0: none
    integer :: line
    character(len=:), allocatable :: values  ! as in the file, for messages
    type(word), allocatable :: word(:)
    logical :: after_comma = .true.          ! or after the = sign: the next comma has no value before it
  end type assignment

  type :: group
    character(len=:), allocatable :: file, name
    integer :: line
    type(assignment), allocatable :: item(:)
  contains
    procedure :: check_names, numbers, number, whole, flag, quoted, texts, has, fail, fail_at
  end type group

contains

  subroutine read_groups(name, groups)
    character(len=*), intent(in) :: name
    type(group), allocatable, intent(out) :: groups(:)
    integer, parameter :: most_groups = 1000
    character(len=:), allocatable :: raw, line, hidden
    type(text_file) :: file
    type(group) :: g
    integer :: start, finish
    logical :: inside

    file = read_file(name)
    allocate (groups(0))
    inside = .false.
    do while (file%read_line(raw))
      call prepare(file, raw, line, hidden)
      start = verify(hidden, ' ')
      if (start == 0) cycle
      if (hidden(start:start) == '&') then
        if (inside) call g%fail_at(g%line, 'is not closed by / before line '//str(file%number))
        if (size(groups) == most_groups) call file%stop_at('more than '//str(most_groups)//' groups')
        inside = .true.
        finish = start + scan(hidden(start:)//' ', ' /') - 1
        g%file = name
        g%name = lower(line(start + 1:finish - 1))
        g%line = file%number
        if (allocated(g%item)) deallocate (g%item)
        allocate (g%item(0))
        start = finish
      else if (.not. inside) then
        call file%stop_at('"'//visible(trim(line(start:)))//'": text outside a group; a group is &NAME ... /')
      end if
      finish = index(hidden(start:)//'/', '/') + start - 1
      call add(g, line(:finish - 1), hidden(:finish - 1), start, file%number)
      if (finish > len(line)) cycle
      start = finish + verify(hidden(finish + 1:)//'.', ' ')
      if (start <= len(line)) then
        call g%fail_at(file%number, 'text after the closing /: "'//visible(trim(line(start:)))// &
                       '" (a / inside a text needs quotes)')
      end if
      groups = [groups, g]
      inside = .false.
    end do
    if (inside) call g%fail_at(g%line, 'is not closed by / before the end of the file')
    if (size(groups) == 0) call stop_run(status_input, name//': has no group; a group is &NAME ... /')
  end subroutine read_groups

  ! line: the line without comment, and without tabs outside quotes. hidden: the same with quotation marks for all
  ! that is in quotes, so that searches see only syntax.
  subroutine prepare(file, raw, line, hidden)
    type(text_file), intent(in) :: file
    character(len=*), intent(in) :: raw
    character(len=:), allocatable, intent(out) :: line, hidden
    character :: quote
    integer :: i

    if (index(raw, achar(0)) > 0) call file%stop_at('has a character of value 0, which ends texts: expected a text file')
    line = raw
    hidden = raw
    quote = ' '
    do i = 1, len(raw)
      if (quote /= ' ') then
        if (raw(i:i) == quote) quote = ' '
        hidden(i:i) = '"'
      else if (raw(i:i) == '"' .or. raw(i:i) == "'") then
        quote = raw(i:i)
        hidden(i:i) = '"'
      else if (raw(i:i) == '!') then
        line = line(:i - 1)
        hidden = hidden(:i - 1)
        exit
      else if (raw(i:i) == achar(9)) then
        line(i:i) = ' '
        hidden(i:i) = ' '
      end if
    end do
    if (quote /= ' ') call file%stop_at(visible(trim(adjustl(raw)))//': a quote is not closed')
  end subroutine prepare

  ! Appends the assignments in line(start:); what precedes the first continues the one before.
  subroutine add(g, line, hidden, start, number)
    type(group), intent(inout) :: g
    character(len=*), intent(in) :: line, hidden
    integer, intent(in) :: start, number
    integer, parameter :: most_items = 2*most_values
    type(assignment) :: new
    type(word) :: no_words(0)
    integer :: here, equals, name

    here = start
    do
      equals = index(hidden(here:), '=') + here - 1
      name = len(line) + 1
      if (equals >= here) name = name_start(hidden(:equals - 1), here)
      call add_values(name - 1)
      if (equals < here) exit
      if (size(g%item) == most_items) call g%fail_at(number, 'more than '//str(most_items)//' assignments')
      new%first = 0
      new%line = number
      new%values = ''
      new%word = no_words
      call take_name(trim(adjustl(hidden(name:equals - 1))))
      g%item = [g%item, new]
      here = equals + 1
    end do

  contains

    ! The values in line(here:last).
    subroutine add_values(last)
      integer, intent(in) :: last
      type(word) :: new_word
      integer :: finish

      here = here + verify(hidden(here:last)//'.', ' ') - 1
      if (here > last) return
      if (size(g%item) == 0) then
        call g%fail_at(number, '"'//visible(trim(line(here:last)))//'": must be NAME = VALUE')
      end if
      associate (now => g%item(size(g%item)))
        if (now%values /= '') now%values = now%values//' '
        now%values = now%values//trim(line(here:last))
        do while (here <= last)
          finish = here + scan(hidden(here:last)//',', ' ,') - 1
          if (finish > here .or. now%after_comma) then
            if (size(now%word) == most_values) then
              call g%fail_at(number, now%name//': at most '//str(most_values)//' values')
            end if
            new_word%text = line(here:finish - 1)
            new_word%line = number
            new_word%column = here
            now%word = [now%word, new_word]
            now%after_comma = .false.
          end if
          here = finish + verify(hidden(finish:last)//'.', ' ') - 1
          if (here > last) exit
          if (hidden(here:here) == ',') then
            now%after_comma = .true.
            here = here + verify(hidden(here + 1:last)//'.', ' ')
          end if
        end do
      end associate
    end subroutine add_values

    ! NAME or NAME(FIRST)
    subroutine take_name(text)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: subscript
      integer :: bracket, status

      bracket = index(text//'(', '(')
      new%name = lower(trim(text(:bracket - 1)))
      if (new%name == '') call g%fail_at(number, '"'//visible(trim(line(start:)))//'": must be NAME = VALUE')
      if (bracket > len(text)) return
      subscript = trim(adjustl(text(bracket + 1:len(text) - 1)))
      status = 1
      if (verify(subscript, '0123456789') == 0) read (subscript, *, iostat=status) new%first
      if (status /= 0 .or. new%first < 1 .or. new%first > most_values) then
        call g%fail_at(number, new%name//'('//visible(subscript)//'): a subscript is one whole number from 1 to '// &
                       str(most_values))
      end if
    end subroutine take_name

  end subroutine add

  ! Where NAME or NAME(FIRST) at the end of the text begins, not before `least`.
  pure integer function name_start(text, least) result(start)
    character(len=*), intent(in) :: text
    integer, intent(in) :: least
    integer :: finish

    finish = len_trim(text)
    if (index(text, ')', back=.true.) == finish) finish = len_trim(text(:index(text, '(', back=.true.) - 1))
    start = max(least, scan(text(:finish), ' ,"', back=.true.) + 1)
  end function name_start

  ! Ends the run if a variable is none of `known`, or if one is given twice as a whole.
  subroutine check_names(g, known)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: known(:)
    character(len=:), allocatable :: list
    integer :: i, k

    list = ''
    do k = 1, size(known)
      list = list//' '//trim(known(k))
    end do
    do i = 1, size(g%item)
      associate (a => g%item(i))
        if (.not. any(known == a%name)) then
          call g%fail_at(a%line, 'unknown variable "'//visible(a%name)//'"; known:'//list)
        end if
        do k = 1, i - 1
          if (g%item(k)%name /= a%name .or. (g%item(k)%first > 0 .and. a%first > 0)) cycle
          call g%fail_at(a%line, a%name//': given already in line '//str(g%item(k)%line))
        end do
      end associate
    end do
  end subroutine check_names

  logical function has(g, name)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    integer :: i

    has = any([(g%item(i)%name == name, i=1, size(g%item))])
  end function has

  ! All values of an array; x stays as it is if there are none. exact: in a file that a program wrote, NaN and
  ! infinities are values, and 3*1.0 is none; else it is three.
  subroutine numbers(g, name, x, exact)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    real(dp), allocatable, intent(inout) :: x(:)
    logical, intent(in), optional :: exact
    real(dp) :: value(most_values), one
    logical :: given(most_values), any_value
    character(len=:), allocatable :: fault
    integer :: i, k, n, star, times, place

    if (.not. g%has(name)) return
    any_value = .false.
    if (present(exact)) any_value = exact
    given = .false.
    n = 0
    do i = 1, size(g%item)
      if (g%item(i)%name /= name) cycle
      place = max(1, g%item(i)%first)
      do k = 1, size(g%item(i)%word)
        associate (w => g%item(i)%word(k))
          star = index(w%text, '*')
          times = 1
          if (star > 0 .and. .not. any_value) times = count_of(w%text(:star - 1))
          if (times < 1 .or. any_value) star = 0  ! it is no repeat count
          call read_number(w%text(star + 1:), any_value, one, fault)
          if (fault /= '') then
            call g%fail(name, fault//' (value '//str(place)//', column '//str(w%column)//')', w%line)
          end if
          if (times > most_values - place + 1) call g%fail(name, 'at most '//str(most_values)//' numbers', w%line)
          if (any(given(place:place + times - 1))) call g%fail(name, 'value '//str(place)//' is given twice', w%line)
          value(place:place + times - 1) = one
          given(place:place + times - 1) = .true.
          place = place + times
          n = max(n, place - 1)
        end associate
      end do
    end do
    if (.not. all(given(:n))) call g%fail(name, 'value '//str(findloc(given, .false., 1))//' is missing')
    x = value(:n)
  end subroutine numbers

  ! A repeat count; 0 if the text is none.
  integer function count_of(text) result(times)
    character(len=*), intent(in) :: text
    integer :: status

    times = 0
    if (len(text) == 0 .or. verify(text, '0123456789') > 0) return
    read (text, *, iostat=status) times
    if (status /= 0) times = huge(times)
  end function count_of

  ! The only value of a variable, `what` in messages.
  function only_word(g, name, what) result(text)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name, what
    character(len=:), allocatable :: text
    integer :: i

    i = findloc([(g%item(i)%name == name, i=1, size(g%item))], .true., 1)
    associate (a => g%item(i))
      if (a%first > 0) call g%fail(name, 'takes no subscript; must be '//what)
      if (size(a%word) /= 1) then
        call g%fail(name, 'must be '//what//', found '//str(size(a%word))// &
                    trim(merge(' (a number has a decimal point, not a comma)', repeat(' ', 44), &
                               index(a%values, ',') > 0 .and. index(a%values, '"') + index(a%values, "'") == 0)))
      end if
      text = a%word(1)%text
    end associate
  end function only_word

  ! One number; x stays as it is if the variable is not given. So do the others.
  subroutine number(g, name, x)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    real(dp), intent(inout) :: x
    character(len=:), allocatable :: fault

    if (.not. g%has(name)) return
    call read_number(only_word(g, name, 'one number'), .false., x, fault)
    if (fault /= '') call g%fail(name, 'must be one number; '//fault)
  end subroutine number

  subroutine whole(g, name, least, most, i)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    integer, intent(in) :: least, most
    integer, intent(inout) :: i
    character(len=:), allocatable :: text, fault
    real(dp) :: x

    if (.not. g%has(name)) return
    text = only_word(g, name, 'one whole number')
    call read_number(text, .false., x, fault)
    if (fault /= '' .or. scan(lower(text), '.ed') > 0) call g%fail(name, 'must be one whole number')
    if (x < least) call g%fail(name, 'must be >= '//str(least))
    if (x > most) call g%fail(name, 'must be <= '//str(most))
    i = nint(x)
  end subroutine whole

  subroutine flag(g, name, l)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    logical, intent(inout) :: l

    if (.not. g%has(name)) return
    select case (lower(only_word(g, name, '.true. or .false.')))
    case ('.true.', 'true', '.t.', 't')
      l = .true.
    case ('.false.', 'false', '.f.', 'f')
      l = .false.
    case default
      call g%fail(name, 'must be .true. or .false.')
    end select
  end subroutine flag

  ! A text in quotes, without them; two quotes in it stand for one.
  subroutine quoted(g, name, text)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    character(len=:), allocatable, intent(inout) :: text
    logical :: is_text

    if (.not. g%has(name)) return
    call unquote(only_word(g, name, 'one text in quotes'), text, is_text)
    if (.not. is_text) call g%fail(name, 'must be one text in quotes')
  end subroutine quoted

  ! Texts in quotes; one that is too long for `list` is an error.
  subroutine texts(g, name, list)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name
    character(len=*), allocatable, intent(inout) :: list(:)
    character(len=:), allocatable :: text
    logical :: is_text
    integer :: i, k

    if (.not. g%has(name)) return
    i = findloc([(g%item(i)%name == name, i=1, size(g%item))], .true., 1)
    associate (a => g%item(i))
      if (a%first > 0) call g%fail(name, 'takes no subscript; must be texts in quotes')
      deallocate (list)
      allocate (list(size(a%word)))
      do k = 1, size(list)
        call unquote(a%word(k)%text, text, is_text)
        if (.not. is_text) call g%fail(name, 'value '//str(k)//' must be a text in quotes', a%word(k)%line)
        if (len(text) > len(list)) then
          call g%fail(name, 'value '//str(k)//' has more than '//str(len(list))//' characters', a%word(k)%line)
        end if
        list(k) = text
      end do
    end associate
  end subroutine texts

  pure subroutine unquote(word, text, is_text)
    character(len=*), intent(in) :: word
    character(len=:), allocatable, intent(inout) :: text
    logical, intent(out) :: is_text
    character(len=:), allocatable :: found
    character :: quote
    integer :: i, n

    found = word//' '
    quote = found(1:1)
    is_text = scan(quote, '''"') == 1
    if (.not. is_text) return
    text = found
    n = 0
    i = 2
    do
      if (found(i:i) == quote) then
        if (found(i + 1:i + 1) /= quote) exit
        i = i + 1
      end if
      n = n + 1
      text(n:n) = found(i:i)
      i = i + 1
    end do
    text = text(:n)
    is_text = i + 1 == len(found)
  end subroutine unquote

  ! Ends the run: FILE:LINE: &GROUP: NAME = what was found: what is wrong.
  subroutine fail(g, name, what, line)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name, what
    integer, intent(in), optional :: line  ! else that of the assignment
    integer :: i, at

    do i = size(g%item), 1, -1
      if (g%item(i)%name /= name) cycle
      associate (found => g%item(i)%values)
        at = g%item(i)%line
        if (present(line)) at = line
        call g%fail_at(at, name//' = '//visible(found(:verify(found, ' ,', back=.true.)))//': '//what)
      end associate
    end do
    call g%fail_at(g%line, name//': '//what)
  end subroutine fail

  subroutine fail_at(g, line, what)
    class(group), intent(in) :: g
    integer, intent(in) :: line
    character(len=*), intent(in) :: what

    call stop_run(status_input, g%file//':'//str(line)//': &'//visible(g%name)//': '//what)
  end subroutine fail_at

end module namelist_file
