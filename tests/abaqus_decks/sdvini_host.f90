! A host for sdvini_fibre.f, in Abaqus's place: sdvini_host NSTATV LOP ELEMENT ... calls UEXTERNALDB with LOP (none if
! negative), then SDVINI for each element, and prints what it gave.
program sdvini_host
  implicit none
  double precision, allocatable :: statev(:)
  double precision :: time(2) = 0, coords(3) = 0
  integer :: i
  allocate (statev(argument(1)))
  if (argument(2) >= 0) call uexternaldb(argument(2), 0, time, 0d0, 0, 0)
  do i = 3, command_argument_count()
    statev = -1  ! nothing may be left of this
    call sdvini(statev, coords, size(statev), 3, argument(i), 1, 1, 1)
    print '(i0, *(1x, es23.16))', argument(i), statev
  end do

contains

  integer function argument(i)
    integer, intent(in) :: i
    character(len=20) :: text
    call get_command_argument(i, text)
    read (text, *) argument
  end function argument
end program sdvini_host

subroutine getoutdir(folder, length)
  implicit none
  character(len=256) :: folder
  integer :: length
  folder = '.'
  length = 1
end subroutine getoutdir

subroutine stdb_abqerr(lop, text, ints, reals, chars)
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  integer :: lop, ints(*)
  character(len=*) :: text
  double precision :: reals(*)
  character(len=8) :: chars(*)
  write (error_unit, '(i0, 1x, a)') lop, text
end subroutine stdb_abqerr

subroutine xit
  implicit none
  stop 3
end subroutine xit
