! The Abaqus/Standard UMAT: its argument list, the routine this program is linked with, and one from a file.
module umat_interface
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: dp => real64
  implicit none
  private
  public :: umat_routine, umat, load_umat

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
  end interface

  procedure(umat_routine) :: umat

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

  ! The routine umat_ of a shared library. The library stays open until the program ends. On failure `routine`
  ! is null and `message` is the system's own text.
  subroutine load_umat(file, routine, message)
    character(len=*), intent(in) :: file
    procedure(umat_routine), pointer, intent(out) :: routine
    character(len=:), allocatable, intent(out) :: message
    integer(c_int), parameter :: rtld_now = 2
    type(c_ptr) :: handle
    type(c_funptr) :: address

    routine => null()
    message = ''
    if (index(file, '/') > 0) then
      handle = dlopen(file//c_null_char, rtld_now)
    else  ! a bare name would be looked for only in the system's folders
      handle = dlopen('./'//file//c_null_char, rtld_now)
    end if
    if (.not. c_associated(handle)) then
      message = last_error()
      return
    end if
    address = dlsym(handle, 'umat_'//c_null_char)
    if (c_associated(address)) then
      call c_f_procpointer(address, routine)
    else
      message = last_error()
    end if
  end subroutine load_umat

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
