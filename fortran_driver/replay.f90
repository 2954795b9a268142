! One call of the UMAT again, with the arguments that it wrote down where it gave no result (abi/dump.hpp).
module replay
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use files, only: say
  use material_point, only: determinant, identity
  use namelist_file, only: group, read_groups, most_values
  use text, only: str, visible, stop_run, status_input
  use umat_interface, only: umat_routine
  implicit none
  private
  public :: run_replay

  character(len=*), parameter :: known(14) = [character(len=6) :: 'fault', 'ntens', 'dtime', 'pnewdt', 'dfgrd1', &
    'jhat', 'predef', 'dpred', 'nprops', 'props', 'nstatv', 'statev', 'ndi', 'nshr']

  type :: umat_call
    character(len=:), allocatable :: fault  ! what the UMAT said when it wrote the file
    integer :: ntens, ndi, nshr, nprops, nstatv
    real(dp) :: dtime, pnewdt, F(3, 3)
    real(dp) :: J_hat = 1  ! of a mixed element: STRESS(NTENS+1)
    real(dp) :: predef = 0, dpred = 0  ! field variable 1 and its increment
    real(dp), allocatable :: props(:), statev(:)
  end type umat_call

contains

  subroutine run_replay(file, umat)
    character(len=*), intent(in) :: file
    procedure(umat_routine), pointer, intent(in) :: umat
    type(umat_call) :: c
    real(dp), allocatable :: stress(:), ddsdde(:, :), ddsddt(:), drplde(:), zero(:)
    real(dp) :: energy(3), rpl, drpldt, pnewdt
    character(len=80) :: cmname
    integer :: n, i

    call read_call(file, c)
    n = max(c%ntens, 0)
    allocate (stress(n + 3), source=0.0_dp)
    stress(n + 1) = c%J_hat
    allocate (ddsdde(n, n), source=0.0_dp)
    allocate (ddsddt, drplde, zero, source=stress(:n))
    energy = 0
    rpl = 0
    drpldt = 0
    pnewdt = c%pnewdt
    cmname = 'MYOGROWTH'
    call umat(stress, c%statev, ddsdde, energy(1), energy(2), energy(3), rpl, ddsddt, drplde, drpldt, zero, &
              zero, [0.0_dp, 0.0_dp], c%dtime, 0.0_dp, 0.0_dp, [c%predef], [c%dpred], cmname, c%ndi, &
              c%nshr, c%ntens, c%nstatv, c%props, c%nprops, [0.0_dp, 0.0_dp, 0.0_dp], identity, pnewdt, 1.0_dp, &
              identity, c%F, 1, 1, 1, 1, [1, 1, 1, 0], 1)

    call show('STRESS', stress(:n))
    do i = 1, n
      call show('DDSDDE('//str(i)//',:)', ddsdde(i, :))
    end do
    if (any(abs(stress(n + 2:)) > 0) .or. .not. all(ieee_is_finite(stress))) call show('mixed', stress(n + 1:))
    call show('STATEV', c%statev)
    call show('PNEWDT', [pnewdt])
    if (n > 0 .and. all(ieee_is_finite(stress)) .and. all(ieee_is_finite(ddsdde))) then
      call say('verdict: a result')
    else
      call say('verdict: refused; '//reason(c))
    end if
    if (c%fault /= '') call say('when written: '//visible(c%fault))
  end subroutine run_replay

  subroutine show(name, values)
    character(len=*), intent(in) :: name
    real(dp), intent(in) :: values(:)

    character(len=11 + 25*size(values)) :: line

    write (line, '(a, t12, *(es25.16e3))') name, values
    call say(trim(line))
  end subroutine show

  ! Of a bad entry of PROPS or STATEV the UMAT itself has spoken, of DFGRD1 and DTIME it does not.
  function reason(c) result(text)
    type(umat_call), intent(in) :: c
    character(len=:), allocatable :: text
    real(dp) :: F(3, 3), J

    F = c%F
    if (c%ntens < 6) then  ! what is given of it
      F(:, 3) = [0.0_dp, 0.0_dp, merge(F(3, 3), 1.0_dp, c%ntens == 4)]
      F(3, :2) = 0
    end if
    J = determinant(F)
    if (.not. ieee_is_finite(c%dtime)) then
      text = 'DTIME is not finite'
    else if (.not. ieee_is_finite(J)) then
      text = 'DFGRD1 or its determinant is not finite'
    else if (J <= 0 .and. any(abs(c%F) > 0)) then
      text = 'det DFGRD1 = '//str(J)//' is not > 0'
    else
      text = 'DFGRD1 and DTIME are in order: see the message of the UMAT, or, if there is none, a result was '// &
             'beyond the range of numbers'
    end if
  end function reason

  subroutine read_call(file, c)
    character(len=*), intent(in) :: file
    type(umat_call), intent(out) :: c
    type(group), allocatable :: groups(:)
    real(dp), allocatable :: nine(:)

    call read_groups(file, groups)
    if (size(groups) /= 1) then
      call stop_run(status_input, file//': one group, &point, is expected, found '//str(size(groups)))
    end if
    associate (g => groups(1))
      if (g%name /= 'point') call g%fail_at(g%line, 'unknown group; known: &point')
      call g%check_names(known)
      c%fault = ''
      call g%quoted('fault', c%fault)
      c%ntens = whole(g, 'ntens')
      c%nshr = merge(3, 1, c%ntens == 6)  ! where the file does not say: those of the element family
      if (g%has('nshr')) c%nshr = whole(g, 'nshr')
      c%ndi = c%ntens - c%nshr
      if (g%has('ndi')) c%ndi = whole(g, 'ndi')
      c%nprops = whole(g, 'nprops')
      c%nstatv = whole(g, 'nstatv')
      c%dtime = one(g, 'dtime')
      c%pnewdt = one(g, 'pnewdt')
      nine = numbers(g, 'dfgrd1', 9)
      c%F = transpose(reshape(nine, [3, 3]))
      if (g%has('jhat')) c%J_hat = one(g, 'jhat')
      if (g%has('predef')) c%predef = one(g, 'predef')
      if (g%has('dpred')) c%dpred = one(g, 'dpred')
      c%props = numbers(g, 'props', c%nprops)
      c%statev = numbers(g, 'statev', c%nstatv)
    end associate
  end subroutine read_call

  integer function whole(g, name) result(i)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name
    real(dp) :: x

    x = one(g, name)
    if (.not. (x >= -huge(i) .and. x <= most_values)) call g%fail(name, 'must be at most '//str(most_values))
    i = nint(x)
    if (abs(x - i) > 0) call g%fail(name, 'must be a whole number')
  end function whole

  real(dp) function one(g, name)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name

    associate (x => numbers(g, name, 1))
      one = x(1)
    end associate
  end function one

  ! The n numbers of an entry, NaN and infinities too; a UMAT may have been called with n < 0, which means none.
  function numbers(g, name, n) result(x)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name
    integer, intent(in) :: n
    real(dp), allocatable :: x(:)

    allocate (x(0))
    if (n > 0 .and. .not. g%has(name)) call g%fail(name, 'is missing')
    call g%numbers(name, x, exact=.true.)
    if (size(x) /= max(n, 0)) then
      call g%fail(name, 'the number of values must be '//str(max(n, 0))//', is '//str(size(x)))
    end if
  end function numbers

end module replay
