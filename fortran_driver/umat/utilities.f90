! What Abaqus/Standard offers to a UMAT, under Abaqus's names and by its conventions (User Subroutines Guide, "Utility
! routines"): components 11 22 33 12 13 23, of which NDI are direct and NSHR shear; LSTR = 1 a stress, 2 a strain
! with engineering shears. The driver loads this library before somebody else's UMAT.
module myogrowth_abaqus
  use, intrinsic :: iso_fortran_env, only: dp => real64, error_unit
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use lapack, only: dsyev
  implicit none
  private
  public :: full, components, principal, give, say_and_stop, dp, job_folder, job_name

  character(len=:), allocatable :: job_folder, job_name

contains

  ! The tensor; the components that are not given are zero.
  function full(s, lstr, ndi, nshr) result(a)
    integer, intent(in) :: lstr, ndi, nshr
    real(dp), intent(in) :: s(*)
    real(dp) :: a(3, 3)
    integer :: i, place(2)

    call check(lstr, ndi, nshr)
    a = 0
    do i = 1, ndi
      a(i, i) = s(i)
    end do
    do i = 1, nshr
      place = shear_place(i)
      a(place(1), place(2)) = s(ndi + i)/lstr  ! a strain's shear is twice its entry
      a(place(2), place(1)) = a(place(1), place(2))
    end do
  end function full

  subroutine components(a, lstr, ndi, nshr, s)
    real(dp), intent(in) :: a(3, 3)
    integer, intent(in) :: lstr, ndi, nshr
    real(dp), intent(inout) :: s(*)
    integer :: i, place(2)

    do i = 1, ndi
      s(i) = a(i, i)
    end do
    do i = 1, nshr
      place = shear_place(i)
      s(ndi + i) = lstr*a(place(1), place(2))
    end do
  end subroutine components

  ! Principal values in ascending order, and their directions as columns, right-handed. (Abaqus says nothing of the
  ! order, and UMATs must not rely on it.)
  subroutine principal(s, lstr, ndi, nshr, values, directions)
    real(dp), intent(in) :: s(*)
    integer, intent(in) :: lstr, ndi, nshr
    real(dp), intent(out) :: values(3), directions(3, 3)
    real(dp) :: work(32)
    integer :: info

    associate (a => directions)
      a = full(s, lstr, ndi, nshr)
      call dsyev('V', 'U', 3, a, 3, values, work, size(work), info)
      if (dot_product(cshift(a(:, 1), 1)*cshift(a(:, 2), 2) - cshift(a(:, 1), 2)*cshift(a(:, 2), 1), a(:, 3)) < 0) then
        a(:, 3) = -a(:, 3)
      end if
      if (info /= 0) then  ! of what is no number
        values = ieee_value(1.0_dp, ieee_quiet_nan)
        a = values(1)
      end if
    end associate
  end subroutine principal

  ! Row and column of a shear component.
  pure function shear_place(shear) result(place)
    integer, intent(in) :: shear
    integer :: place(2)
    integer, parameter :: rows(3) = [1, 1, 2], columns(3) = [2, 3, 3]

    place = [rows(shear), columns(shear)]
  end function shear_place

  subroutine check(lstr, ndi, nshr)
    integer, intent(in) :: lstr, ndi, nshr
    character(len=120) :: text

    if (any(lstr == [1, 2]) .and. ndi >= 1 .and. ndi <= 3 .and. nshr >= 0 .and. nshr <= 3) return
    write (text, '(a, 3(a, i0))') 'SPRIND, SPRINC, SINV or ROTSIG is called with', ' LSTR = ', lstr, ', NDI = ', ndi, &
      ', NSHR = ', nshr
    call say_and_stop(trim(text)//'; allowed are 1 and 2, 1 to 3, 0 to 3')
  end subroutine check

  subroutine give(routine, text, variable, length)
    character(len=*), intent(in) :: routine, text
    character(len=*), intent(out) :: variable
    integer, intent(out) :: length

    variable = text
    length = len(text)
    if (length > len(variable)) call say_and_stop(routine//' has no room for '//text)
  end subroutine give

  subroutine say_and_stop(text)
    character(len=*), intent(in) :: text

    write (error_unit, '(a)') 'UMAT: '//text
    stop 2, quiet=.true.
  end subroutine say_and_stop

end module myogrowth_abaqus

! Called by the driver before the run: the folder of the results and the name of the case.
subroutine myogrowth_abaqus_job(folder, name)
  use myogrowth_abaqus, only: job_folder, job_name
  implicit none
  character(len=*), intent(in) :: folder, name

  job_folder = folder
  job_name = name
end subroutine myogrowth_abaqus_job

! AN(k, :) belongs to PS(k).
subroutine sprind(s, ps, an, lstr, ndi, nshr)
  use myogrowth_abaqus, only: dp, principal
  implicit none
  integer, intent(in) :: lstr, ndi, nshr
  real(dp), intent(in) :: s(*)
  real(dp), intent(out) :: ps(3), an(3, 3)
  real(dp) :: directions(3, 3)

  call principal(s, lstr, ndi, nshr, ps, directions)
  an = transpose(directions)
end subroutine sprind

subroutine sprinc(s, ps, lstr, ndi, nshr)
  use myogrowth_abaqus, only: dp, principal
  implicit none
  integer, intent(in) :: lstr, ndi, nshr
  real(dp), intent(in) :: s(*)
  real(dp), intent(out) :: ps(3)
  real(dp) :: directions(3, 3)

  call principal(s, lstr, ndi, nshr, ps, directions)
end subroutine sprinc

! A third of the trace, and the Mises stress.
subroutine sinv(stress, sinv1, sinv2, ndi, nshr)
  use myogrowth_abaqus, only: dp, full
  implicit none
  integer, intent(in) :: ndi, nshr
  real(dp), intent(in) :: stress(*)
  real(dp), intent(out) :: sinv1, sinv2
  real(dp) :: a(3, 3)
  integer :: i

  a = full(stress, 1, ndi, nshr)
  sinv1 = (a(1, 1) + a(2, 2) + a(3, 3))/3
  do i = 1, 3
    a(i, i) = a(i, i) - sinv1
  end do
  sinv2 = sqrt(1.5_dp)*norm2(a)
end subroutine sinv

! SPRIME = R S R^T.
subroutine rotsig(s, r, sprime, lstr, ndi, nshr)
  use myogrowth_abaqus, only: dp, full, components
  implicit none
  integer, intent(in) :: lstr, ndi, nshr
  real(dp), intent(in) :: s(*), r(3, 3)
  real(dp), intent(inout) :: sprime(*)  ! may be S itself

  call components(matmul(r, matmul(full(s, lstr, ndi, nshr), transpose(r))), lstr, ndi, nshr, sprime)
end subroutine rotsig

subroutine getoutdir(folder, length)
  use myogrowth_abaqus, only: job_folder, give
  implicit none
  character(len=*), intent(out) :: folder
  integer, intent(out) :: length

  call give('GETOUTDIR', job_folder, folder, length)
end subroutine getoutdir

subroutine getjobname(name, length)
  use myogrowth_abaqus, only: job_name, give
  implicit none
  character(len=*), intent(out) :: name
  integer, intent(out) :: length

  call give('GETJOBNAME', job_name, name, length)
end subroutine getjobname

! One process, one thread.
subroutine getrank(rank)
  implicit none
  integer, intent(out) :: rank

  rank = 0
end subroutine getrank

subroutine getnumcpus(processes)
  implicit none
  integer, intent(out) :: processes

  processes = 1
end subroutine getnumcpus

integer function getnumthreads()
  implicit none

  getnumthreads = 1
end function getnumthreads

integer function get_thread_id()
  implicit none

  get_thread_id = 0
end function get_thread_id

! Nothing is to be locked.
subroutine mutexinit(id)
  implicit none
  integer, intent(in) :: id

  if (id < 0) return
end subroutine mutexinit

subroutine mutexlock(id)
  implicit none
  integer, intent(in) :: id

  if (id < 0) return
end subroutine mutexlock

subroutine mutexunlock(id)
  implicit none
  integer, intent(in) :: id

  if (id < 0) return
end subroutine mutexunlock

! What a host has computed at the point. UVARM and USDFLD ask for it, which a UMAT's file may contain and the driver does
! not call; a UMAT that asks gets no answer.
subroutine getvrm()
  use myogrowth_abaqus, only: say_and_stop
  implicit none

  call say_and_stop('calls GETVRM, and the driver has no such results to give')
end subroutine getvrm

subroutine xit()
  use myogrowth_abaqus, only: say_and_stop
  implicit none

  call say_and_stop('calls XIT')
end subroutine xit

! A message with %I, %R and %S in it for the next entry of INTV, REALV and CHARV. LOP: 1 information, -1 warning, -2
! error, -3 error and the end of the run.
subroutine stdb_abqerr(lop, string, intv, realv, charv)
  use myogrowth_abaqus, only: dp
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  integer, intent(in) :: lop, intv(*)
  character(len=*), intent(in) :: string
  real(dp), intent(in) :: realv(*)
  character(len=8), intent(in) :: charv(*)
  character(len=:), allocatable :: line
  character(len=32) :: value
  integer :: i, next(3), kind

  line = ''
  next = 0
  i = 1
  do while (i <= len_trim(string))
    kind = 0
    if (string(i:i) == '%' .and. i < len(string)) kind = (index('IiRrSs', string(i + 1:i + 1)) + 1)/2
    if (kind == 0) then
      line = line//string(i:i)
      i = i + 1
      cycle
    end if
    next(kind) = next(kind) + 1
    select case (kind)
    case (1)
      write (value, '(i0)') intv(next(1))
    case (2)
      write (value, '(es15.7e3)') realv(next(2))
    case (3)
      value = charv(next(3))
    end select
    line = line//trim(adjustl(value))
    i = i + 2
  end do
  select case (lop)
  case (1)
    line = 'note: '//line
  case (-1)
    line = 'warning: '//line
  case default
    line = 'error: '//line
  end select
  write (error_unit, '(a)') 'UMAT: '//line
  if (lop <= -3) stop 2, quiet=.true.
end subroutine stdb_abqerr
