! Files: read as a whole, line by line; written line by line. C's stdio does it, since gfortran's FLUSH and CLOSE
! return 0 where the disk is full, and its OPEN and READ take a folder for an empty file.
module files
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: output_unit
  use run_end, only: end_run
  use text, only: escaped, str, stop_run, status_input, status_output
  implicit none
  private
  public :: text_file, output_file, read_file, create_file, remove_file, is_same_file, make_folder, absolute, start_output, say

  type :: text_file
    character(len=:), allocatable :: name, text
    integer :: next = 1    ! where the next line begins
    integer :: number = 0  ! of the line that was read last
  contains
    procedure :: read_line, stop_at
  end type text_file

  type :: output_file
    character(len=:), allocatable :: name
    type(c_ptr) :: stream = c_null_ptr  ! null: closed
  contains
    procedure :: put, close => close_file
  end type output_file

  type(output_file), save :: screen

  interface
    function c_fopen(name, mode) bind(c, name='fopen') result(stream)
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: name(*), mode(*)
      type(c_ptr) :: stream
    end function c_fopen
    function c_fdopen(descriptor, mode) bind(c, name='fdopen') result(stream)
      import :: c_char, c_int, c_ptr
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: mode(*)
      type(c_ptr) :: stream
    end function c_fdopen
    function c_fread(buffer, size, n, stream) bind(c, name='fread') result(got)
      import :: c_char, c_ptr, c_size_t
      character(kind=c_char), intent(inout) :: buffer(*)
      integer(c_size_t), value :: size, n
      type(c_ptr), value :: stream
      integer(c_size_t) :: got
    end function c_fread
    function c_fputs(text, stream) bind(c, name='fputs') result(status)
      import :: c_char, c_int, c_ptr
      character(kind=c_char), intent(in) :: text(*)
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_fputs
    function c_fflush(stream) bind(c, name='fflush') result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_fflush
    function c_ferror(stream) bind(c, name='ferror') result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_ferror
    function c_fclose(stream) bind(c, name='fclose') result(status)
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_fclose
    function c_getcwd(buffer, size) bind(c, name='getcwd') result(address)
      import :: c_char, c_ptr, c_size_t
      character(kind=c_char), intent(inout) :: buffer(*)
      integer(c_size_t), value :: size
      type(c_ptr) :: address
    end function c_getcwd
    function c_mkdir(path, mode) bind(c, name='mkdir') result(status)  ! mode_t is an int or shorter
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
      integer(c_int) :: status
    end function c_mkdir
    function c_remove(path) bind(c, name='remove') result(status)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int) :: status
    end function c_remove
    function c_signal(number, handler) bind(c, name='signal') result(before)
      import :: c_funptr, c_int
      integer(c_int), value :: number
      type(c_funptr), value :: handler
      type(c_funptr) :: before
    end function c_signal
    function c_fileno(stream) bind(c, name='fileno') result(descriptor)
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
      integer(c_int) :: descriptor
    end function c_fileno
    subroutine c_perror(text) bind(c, name='perror')
      import :: c_char
      character(kind=c_char), intent(in) :: text(*)
    end subroutine c_perror
  end interface

contains

  ! The whole file, without a UTF-8 byte-order mark.
  function read_file(name) result(file)
    character(len=*), intent(in) :: name
    type(text_file) :: file
    integer, parameter :: most = 2**28  ! also ends the reading of a device that has no end
    character(len=:), allocatable :: buffer
    type(c_ptr) :: stream
    integer :: length, got

    file%name = name
    stream = c_fopen(name//c_null_char, 'r'//c_null_char)
    if (.not. c_associated(stream)) call stop_with_reason(status_input, name//': cannot be opened')
    allocate (character(len=2**16) :: buffer)
    length = 0
    do
      if (length == len(buffer)) buffer = buffer//buffer
      got = int(c_fread(buffer(length + 1:), 1_c_size_t, int(len(buffer) - length, c_size_t), stream))
      if (got == 0) exit
      length = length + got
      if (length == most) call stop_run(status_input, name//': larger than '//str(most/2**20)//' MiB')
    end do
    if (c_ferror(stream) /= 0) call stop_with_reason(status_input, name//': cannot be read')
    if (c_fclose(stream) /= 0) call stop_with_reason(status_input, name//': cannot be read')
    file%text = buffer(:length)
    if (length >= 3) then
      if (file%text(:3) == char(239)//char(187)//char(191)) file%next = 4
    end if
    if (length >= 2) then
      if (file%text(:2) == char(255)//char(254) .or. file%text(:2) == char(254)//char(255)) then
        call stop_run(status_input, name//': is in UTF-16; save it as UTF-8 or ASCII')
      end if
    end if
  end function read_file

  ! The next line, which LF, CR LF, CR or the end of the file ends; false where there is none.
  logical function read_line(file, line)
    class(text_file), intent(inout) :: file
    character(len=:), allocatable, intent(out) :: line
    character(len=2), parameter :: ends = achar(13)//achar(10)
    integer :: finish

    line = ''
    read_line = file%next <= len(file%text)
    if (.not. read_line) return
    finish = scan(file%text(file%next:), ends)
    finish = merge(len(file%text) + 1, file%next + finish - 1, finish == 0)
    line = file%text(file%next:finish - 1)
    file%next = finish + 1
    if (finish < len(file%text)) then
      if (file%text(finish:finish + 1) == ends) file%next = finish + 2
    end if
    file%number = file%number + 1
  end function read_line

  ! Ends the run with FILE:LINE: and what is wrong in the line that was read last.
  subroutine stop_at(file, what)
    class(text_file), intent(in) :: file
    character(len=*), intent(in) :: what

    call stop_run(status_input, file%name//':'//str(file%number)//': '//what)
  end subroutine stop_at

  ! Makes a folder and those above it, as far as they are missing.
  subroutine make_folder(folder)
    character(len=*), intent(in) :: folder
    integer(c_int), parameter :: everyone = int(o'777', c_int)
    logical :: there
    integer :: i

    do i = 2, len(folder) + 1
      if (index(folder(i:)//'/', '/') /= 1) cycle
      if (c_mkdir(folder(:i - 1)//c_null_char, everyone) == 0) cycle
      inquire (file=folder(:i - 1)//'/.', exist=there)
      if (there) cycle
      if (c_mkdir(folder(:i - 1)//c_null_char, everyone) == 0) cycle  ! again, for its reason
      call stop_with_reason(status_output, folder(:i - 1)//': cannot be made')
    end do
  end subroutine make_folder

  ! Removes the file of an earlier run, if there is one, so that it is not taken for one of this run.
  subroutine remove_file(name)
    character(len=*), intent(in) :: name
    logical :: there

    inquire (file=name, exist=there)
    if (.not. there) return
    if (c_remove(name//c_null_char) /= 0) call stop_with_reason(status_output, name//': cannot be removed')
  end subroutine remove_file

  ! Whether two names are those of one file, by links as well: the runtime compares device and inode with those of
  ! the files that are open. A pipe, whose size is 0, is not opened again: that would wait for another writer.
  logical function is_same_file(name, other)
    character(len=*), intent(in) :: name, other
    integer :: unit, status, bytes

    is_same_file = .false.
    inquire (file=name, size=bytes)
    if (bytes <= 0) return
    open (newunit=unit, file=name, status='old', action='read', iostat=status)
    if (status /= 0) return
    inquire (file=other, opened=is_same_file)
    close (unit)
  end function is_same_file

  ! A new file with its first line. What was there under that name is lost.
  subroutine create_file(name, first_line, file)
    character(len=*), intent(in) :: name, first_line
    type(output_file), intent(out) :: file

    file%name = name
    file%stream = c_fopen(name//c_null_char, 'w'//c_null_char)
    if (.not. c_associated(file%stream)) call stop_with_reason(status_output, name//': cannot be written')
    call file%put(first_line)
  end subroutine create_file

  ! Appends a line and hands it to the system, so that a full disk shows at once, and that the lines are there if
  ! a UMAT brings the program down. Nothing is done with a closed file.
  subroutine put(file, line)
    class(output_file), intent(in) :: file
    character(len=*), intent(in) :: line
    integer(c_int) :: status

    if (.not. c_associated(file%stream)) return
    status = c_fputs(line//c_new_line//c_null_char, file%stream)
    if (status >= 0) status = c_fflush(file%stream)
    if (status < 0) call stop_with_reason(status_output, file%name//': cannot be written')
  end subroutine put

  subroutine close_file(file)
    class(output_file), intent(inout) :: file
    integer(c_int) :: status

    if (.not. c_associated(file%stream)) return
    status = c_fclose(file%stream)
    file%stream = c_null_ptr
    if (status /= 0) call stop_with_reason(status_output, file%name//': cannot be written')
  end subroutine close_file

  ! Comes before any file is opened: a file would take the place of a standard stream that is closed, and get what is
  ! printed. quiet: `say` says nothing, and standard output may be closed.
  subroutine start_output(quiet)
    logical, intent(in) :: quiet
    integer(c_int), parameter :: sigxfsz = 25
    type(c_funptr) :: ignore, before
    type(c_ptr) :: unused
    integer(c_int) :: status

    ! A file that reaches the size limit (ulimit -f) is an error of the write like a full disk, not the program's end.
    ignore = transfer(1_c_intptr_t, c_null_funptr)  ! SIG_IGN
    before = c_signal(sigxfsz, ignore)
    if (.not. quiet) then
      screen%name = 'standard output'
      screen%stream = c_fdopen(1_c_int, 'w'//c_null_char)
      if (.not. c_associated(screen%stream)) call stop_with_reason(status_output, screen%name//': cannot be written')
    end if
    do
      unused = c_fopen('/dev/null'//c_null_char, 'r+'//c_null_char)
      if (.not. c_associated(unused)) exit
      if (c_fileno(unused) <= 2) cycle
      status = c_fclose(unused)
      exit
    end do
  end subroutine start_output

  ! A name from the root.
  function absolute(name) result(path)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: path
    character(len=4096) :: buffer

    path = name
    if (index(name, '/') == 1) return
    buffer = ''
    if (.not. c_associated(c_getcwd(buffer, len(buffer, c_size_t)))) call stop_with_reason(status_input, 'this folder')
    path = buffer(:index(buffer, c_null_char) - 1)
    if (name /= '.') path = path//'/'//name
  end function absolute

  subroutine say(line)
    character(len=*), intent(in) :: line

    flush (output_unit)  ! what a UMAT printed comes first
    call screen%put(line)
  end subroutine say

  ! Ends the run with what failed and the system's reason for it.
  subroutine stop_with_reason(status, what)
    integer, intent(in) :: status
    character(len=*), intent(in) :: what

    call c_perror(escaped(what, 255)//c_null_char)
    call end_run(status)
  end subroutine stop_with_reason

end module files
