! The Abaqus/Standard UMAT: its argument list, the routine this program is linked with, and one from a file; with the
! other user routines of that file which a UMAT relies on.
module umat_interface
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: dp => real64
  implicit none
  private
  public :: umat_routine, umat, umat_library, load_umat

  abstract interface
    ! KSTEP is passed as Abaqus now has it, JSTEP(4); a UMAT that declares it a scalar sees its first entry.
    subroutine umat_routine(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, &
                            dstran, time, dtime, temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, &
                            nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, &
                            layer, kspt, jstep, kinc)
      import :: dp
      integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
      character(len=80), intent(in) :: cmname
      real(dp), intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens)
      real(dp), intent(inout) :: sse, spd, scd, rpl, ddsddt(ntens), drplde(ntens), drpldt, pnewdt
      real(dp), intent(in) :: stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1)
      real(dp), intent(in) :: props(nprops), coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
    end subroutine umat_routine
    subroutine uexternaldb_routine(lop, lrestart, time, dtime, kstep, kinc)
      import :: dp
      integer, intent(in) :: lop, lrestart, kstep, kinc
      real(dp), intent(in) :: time(2), dtime
    end subroutine uexternaldb_routine
    subroutine sdvini_routine(statev, coords, nstatv, ncrds, noel, npt, layer, kspt)
      import :: dp
      integer, intent(in) :: nstatv, ncrds, noel, npt, layer, kspt
      real(dp), intent(inout) :: statev(nstatv)
      real(dp), intent(in) :: coords(ncrds)
    end subroutine sdvini_routine
    subroutine job_routine(folder, name)
      character(len=*), intent(in) :: folder, name
    end subroutine job_routine
  end interface

  procedure(umat_routine) :: umat

  type :: umat_library
    procedure(umat_routine), pointer, nopass :: umat => null()
    procedure(uexternaldb_routine), pointer, nopass :: uexternaldb => null()  ! null where there is none
    procedure(sdvini_routine), pointer, nopass :: sdvini => null()            ! likewise
    logical :: is_ours = .true.  ! myogrowth's UMAT: its first five STATEV have names, and a call without time is allowed
    character(len=:), allocatable :: not_called  ! other user routines in the file
  end type umat_library

  interface
    function dlopen(file, mode) bind(c) result(handle)
      import :: c_char, c_int, c_ptr
      character(kind=c_char), intent(in) :: file(*)
      integer(c_int), value :: mode
      type(c_ptr) :: handle
    end function dlopen
    function dlsym(handle, symbol) bind(c) result(address)
      import :: c_char, c_ptr, c_funptr
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: symbol(*)
      type(c_funptr) :: address
    end function dlsym
    function dlerror() bind(c) result(text)
      import :: c_ptr
      type(c_ptr) :: text
    end function dlerror
    function strlen(text) bind(c) result(length)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: length
    end function strlen
  end interface

contains

  ! The UMAT of a shared library, which stays open until the program ends. Before it comes the library of Abaqus's
  ! utilities (umat/utilities.f90), which is told the folder of the results and the name of the case. On failure
  ! library%umat is null and `message` says why.
  subroutine load_umat(file, folder, name, library, message)
    character(len=*), intent(in) :: file, folder, name
    type(umat_library), intent(inout) :: library
    character(len=:), allocatable, intent(out) :: message
    character(len=*), parameter :: utilities = 'libmyogrowth_abaqus.so'
    character(len=18), parameter :: others(19) = [character(len=18) :: 'usdfld', 'uvarm', 'uexpan', 'hetval', 'disp', &
                                                  'dload', 'orient', 'umatht', 'sigini', 'uhard', 'creep', 'urdfil', &
                                                  'uel', 'vumat', 'uhyper', 'uanisohyper_inv', 'uanisohyper_strain', &
                                                  'umullins', 'utrs']
    integer(c_int), parameter :: rtld_now = 2, rtld_deepbind = 8, rtld_global = 256
    procedure(job_routine), pointer :: set_job
    type(c_ptr) :: handle
    type(c_funptr) :: address
    integer(c_int) :: own_names_first
    integer :: i

    library%umat => null()
    handle = dlopen(utilities//c_null_char, ior(rtld_now, rtld_global))
    if (.not. c_associated(handle)) then
      message = last_error()
      return
    end if
    call c_f_procpointer(dlsym(handle, 'myogrowth_abaqus_job_'//c_null_char), set_job)
    call set_job(folder, name)

    ! What a UMAT defines itself (a SPRIND, a DGESV of its own) is what it calls. The address sanitizer allows no
    ! library this.
    own_names_first = merge(0, rtld_deepbind, c_associated(dlsym(c_null_ptr, '__asan_init'//c_null_char)))
    if (index(file, '/') > 0) then
      handle = dlopen(file//c_null_char, ior(rtld_now, own_names_first))
    else  ! a bare name would be looked for only in the system's folders
      handle = dlopen('./'//file//c_null_char, ior(rtld_now, own_names_first))
    end if
    if (.not. c_associated(handle)) then
      message = last_error()
      if (index(message, 'undefined symbol') > 0) then
        message = message//' (neither in it nor among the utilities of Abaqus''s that the driver has: docs/hosts.md)'
      end if
      return
    end if
    library%not_called = ''
    do i = 1, size(others)
      if (c_associated(entry_of(handle, trim(others(i))))) then
        library%not_called = library%not_called//' '//upper(trim(others(i)))
      end if
    end do
    address = entry_of(handle, 'umat')
    if (.not. c_associated(address)) then
      message = 'it has none of the symbols umat_, umat, UMAT and UMAT_'
      if (library%not_called /= '') message = message//'; it has, and this driver does not call,'//library%not_called
      return
    end if
    call c_f_procpointer(address, library%umat)
    library%is_ours = c_associated(dlsym(handle, 'myogrowth_umat_'//c_null_char))
    address = entry_of(handle, 'uexternaldb')
    if (c_associated(address)) call c_f_procpointer(address, library%uexternaldb)
    address = entry_of(handle, 'sdvini')
    if (c_associated(address)) call c_f_procpointer(address, library%sdvini)
    message = ''
  end subroutine load_umat

  ! A Fortran routine by the names that compilers give it on Linux and Windows. Null where there is none.
  function entry_of(handle, name) result(address)
    type(c_ptr), intent(in) :: handle
    character(len=*), intent(in) :: name
    type(c_funptr) :: address

    address = dlsym(handle, name//'_'//c_null_char)
    if (.not. c_associated(address)) address = dlsym(handle, name//c_null_char)
    if (.not. c_associated(address)) address = dlsym(handle, trim(upper(name))//c_null_char)
    if (.not. c_associated(address)) address = dlsym(handle, trim(upper(name))//'_'//c_null_char)
  end function entry_of

  pure function upper(text) result(large)
    character(len=*), intent(in) :: text
    character(len=len(text)) :: large
    integer :: i

    large = text
    do i = 1, len(text)
      if (text(i:i) >= 'a' .and. text(i:i) <= 'z') large(i:i) = achar(iachar(text(i:i)) - 32)
    end do
  end function upper

  function last_error() result(message)
    character(len=:), allocatable :: message
    character(kind=c_char), pointer :: text(:)
    type(c_ptr) :: address
    integer :: i

    message = 'unknown error'
    address = dlerror()
    if (.not. c_associated(address)) return
    call c_f_pointer(address, text, [strlen(address)])
    message = repeat(' ', size(text))
    do i = 1, size(text)
      message(i:i) = text(i)
    end do
  end function last_error

end module umat_interface
