! A file of namelist groups taken apart into assignments that know their line, since the compiler's own
! namelist messages do not: each assignment is then read by itself.
module namelist_file
  use text, only: string, read_line, lower, str, stop_run, status_input
  implicit none
  private
  public :: group, assignment, read_groups

  type :: assignment
    character(len=:), allocatable :: name   ! lower case, without subscript
    character(len=:), allocatable :: text   ! as in the file, comments removed: NAME = VALUES
    character(len=:), allocatable :: values
    integer :: line
  end type assignment

  type :: group
    character(len=:), allocatable :: file, name
    integer :: line
    type(assignment), allocatable :: item(:)
  contains
    procedure :: record, check_read, fail, fail_at
  end type group

contains

  subroutine read_groups(file, groups)
    character(len=*), intent(in) :: file
    type(group), allocatable, intent(out) :: groups(:)
    character(len=:), allocatable :: raw, line
    type(assignment) :: no_items(0)
    type(group) :: g
    character(len=256) :: message
    integer :: unit, status, number, finish
    logical :: inside

    open (newunit=unit, file=file, status='old', action='read', iostat=status, iomsg=message)
    if (status /= 0) call stop_run(status_input, file//': cannot be opened: '//trim(message))
    allocate (groups(0))
    inside = .false.
    number = 0
    do
      call read_line(unit, raw, status)
      if (status /= 0) exit
      number = number + 1
      line = content(raw, file, number)
      if (len(line) == 0) cycle
      if (line(1:1) == '&') then
        if (inside) call g%fail_at(g%line, 'is not closed by / before line '//str(number))
        inside = .true.
        finish = scan(line//' ', ' /') - 1
        g%file = file
        g%name = lower(line(2:finish))
        g%line = number
        g%item = no_items
        line = adjustl(line(finish + 1:))
      else if (.not. inside) then
        call stop_run(status_input, file//':'//str(number)//': "'//trim(line)// &
                      '": text outside a group; a group is &NAME ... /')
      end if
      finish = scan(masked(line), '/')
      if (finish == 0) then
        call add(g, trim(line), number)
        cycle
      end if
      call add(g, line(:finish - 1), number)
      if (len_trim(line(finish + 1:)) > 0) then
        call g%fail_at(number, 'text after the closing /: "'//trim(adjustl(line(finish + 1:)))// &
                       '" (a / inside a text needs quotes)')
      end if
      groups = [groups, g]
      inside = .false.
    end do
    close (unit)
    if (inside) call g%fail_at(g%line, 'is not closed by / before the end of the file')
  end subroutine read_groups

  ! Appends the assignments in one line of a group; what precedes the first continues the line before.
  subroutine add(g, line, number)
    type(group), intent(inout) :: g
    character(len=*), intent(in) :: line
    integer, intent(in) :: number
    character(len=:), allocatable :: hidden, head
    type(assignment) :: next_item
    integer :: start, finish, equals, next

    hidden = masked(line)
    equals = scan(hidden, '=')
    start = len(line) + 1
    if (equals > 0) start = name_start(hidden, equals)
    head = trim(adjustl(line(:start - 1)))
    if (len(head) > 0) then
      if (size(g%item) == 0) call g%fail_at(number, '"'//head//'": must be NAME = VALUE')
      associate (last => g%item(size(g%item)))
        last%text = last%text//' '//head
        last%values = last%values//' '//head
      end associate
    end if
    do while (equals > 0)
      if (start == equals) call g%fail_at(number, '"'//line//'": must be NAME = VALUE')
      next = scan(hidden(equals + 1:), '=')
      finish = len(line)
      if (next > 0) then
        next = equals + next
        finish = name_start(hidden, next) - 1
      end if
      next_item%name = lower(trim(hidden(start:start + scan(hidden(start:equals), ' (=') - 2)))
      next_item%text = line(start:finish)
      next_item%values = trim(adjustl(line(equals + 1:finish)))
      next_item%line = number
      g%item = [g%item, next_item]
      equals = next
      start = finish + 1
    end do
  end subroutine add

  ! Where the NAME or NAME(SUBSCRIPT) before the = sign begins.
  pure function name_start(line, equals) result(start)
    character(len=*), intent(in) :: line
    integer, intent(in) :: equals
    integer :: start, finish

    finish = len_trim(line(:equals - 1))
    start = finish + 1
    if (finish == 0) then
      start = equals
      return
    end if
    if (line(finish:finish) == ')') start = max(1, scan(line(:finish), '(', back=.true.))
    do while (start > 1)
      if (scan(lower(line(start - 1:start - 1)), 'abcdefghijklmnopqrstuvwxyz0123456789_') == 0) exit
      start = start - 1
    end do
    if (start > finish) start = equals
  end function name_start

  ! The line with all that is in quotes made into quotation marks, so that searches see only syntax.
  pure function masked(line) result(hidden)
    character(len=*), intent(in) :: line
    character(len=len(line)) :: hidden
    character :: quote

    call mask(line, hidden, quote)
  end function masked

  ! quote: the one still open at the end of the line, blank if there is none.
  pure subroutine mask(line, hidden, quote)
    character(len=*), intent(in) :: line
    character(len=len(line)), intent(out) :: hidden
    character, intent(out) :: quote
    integer :: i

    hidden = line
    quote = ' '
    do i = 1, len(line)
      if (quote /= ' ') then
        hidden(i:i) = '"'
        if (line(i:i) == quote) quote = ' '
      else if (line(i:i) == '"' .or. line(i:i) == "'") then
        hidden(i:i) = '"'
        quote = line(i:i)
      end if
    end do
  end subroutine mask

  ! The line without comment, tabs and blanks at its ends.
  function content(raw, file, number) result(line)
    character(len=*), intent(in) :: raw, file
    integer, intent(in) :: number
    character(len=:), allocatable :: line
    character(len=len(raw)) :: plain, hidden
    character :: quote
    integer :: i, finish

    do i = 1, len(raw)
      plain(i:i) = merge(' ', raw(i:i), raw(i:i) == achar(9))
    end do
    call mask(plain, hidden, quote)
    finish = scan(hidden//'!', '!') - 1
    line = trim(adjustl(plain(:finish)))
    call mask(plain(:finish), hidden(:finish), quote)
    if (quote /= ' ') then
      call stop_run(status_input, file//':'//str(number)//': '//line//': a quote is not closed')
    end if
  end function content

  ! Assignment i as a namelist record of its own. `known` has an entry 'name: what it takes' per variable.
  function record(g, i, known)
    class(group), intent(in) :: g
    integer, intent(in) :: i
    character(len=*), intent(in) :: known(:)
    character(len=:), allocatable :: record, list
    integer :: k

    list = ''
    do k = 1, size(known)
      if (index(known(k), g%item(i)%name//':') == 1) exit
      list = list//' '//known(k)(:index(known(k), ':') - 1)
    end do
    if (k > size(known)) then
      call g%fail_at(g%item(i)%line, 'unknown variable "'//g%item(i)%name//'"; known:'//list)
    end if
    record = '&'//g%name//' '//g%item(i)%text//' /'
  end function record

  ! Ends the run if reading that record went wrong (status /= 0).
  subroutine check_read(g, i, status, known)
    class(group), intent(in) :: g
    integer, intent(in) :: i, status
    character(len=*), intent(in) :: known(:)
    integer :: k

    do k = 1, size(known)
      if (status /= 0 .and. index(known(k), g%item(i)%name//':') == 1) then
        call g%fail(g%item(i)%name, 'must be'//trim(known(k)(index(known(k), ':') + 1:)))
      end if
    end do
  end subroutine check_read

  ! Ends the run: FILE:LINE: &GROUP: NAME = what was found: what is wrong.
  subroutine fail(g, name, what)
    class(group), intent(in) :: g
    character(len=*), intent(in) :: name, what
    integer :: i, length

    do i = size(g%item), 1, -1
      if (g%item(i)%name /= name) cycle
      associate (found => g%item(i)%values)
        length = len(found)
        if (scan(found, ',', back=.true.) == length) length = length - 1
        call g%fail_at(g%item(i)%line, name//' = '//found(:length)//': '//what)
      end associate
    end do
    call g%fail_at(g%line, name//': '//what)
  end subroutine fail

  subroutine fail_at(g, line, what)
    class(group), intent(in) :: g
    integer, intent(in) :: line
    character(len=*), intent(in) :: what

    call stop_run(status_input, g%file//':'//str(line)//': &'//g%name//': '//what)
  end subroutine fail_at

end module namelist_file
