! One call of the UMAT again, with the arguments that it wrote down where it gave no result (abi/dump.hpp).
module replay
  use, intrinsic :: iso_fortran_env, only: dp => real64, output_unit
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use material_point, only: determinant, identity
  use namelist_file, only: group, read_groups
  use text, only: str, stop_run, status_input
  use umat_interface, only: umat_routine
  implicit none
  private
  public :: run_replay

  character(len=*), parameter :: known(12) = [character(len=12) :: 'fault:', 'ntens:', 'dtime:', 'pnewdt:', &
    'dfgrd1:', 'jhat:', 'nprops:', 'props:', 'nstatv:', 'statev:', 'ndi:', 'nshr:']
  integer, parameter :: most = 1000  ! components and entries

  type :: umat_call
    character(len=400) :: fault = ''  ! what the UMAT said when it wrote the file
    integer :: ntens, ndi, nshr, nprops, nstatv
    real(dp) :: dtime, pnewdt, F(3, 3)
    real(dp) :: J_hat = 1  ! of a mixed element: STRESS(NTENS+1)
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
              zero, [0.0_dp, 0.0_dp], c%dtime, 0.0_dp, 0.0_dp, [0.0_dp], [0.0_dp], cmname, c%ndi, &
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
      write (output_unit, '(a)') 'verdict: a result'
    else
      write (output_unit, '(a)') 'verdict: refused; '//reason(c)
    end if
    if (c%fault /= '') write (output_unit, '(a)') 'when written: '//trim(c%fault)
  end subroutine run_replay

  subroutine show(name, values)
    character(len=*), intent(in) :: name
    real(dp), intent(in) :: values(:)

    write (output_unit, '(a, t12, *(es25.16e3))') name, values
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
    real(dp) :: one(1), nine(9)
    character(len=:), allocatable :: record
    integer :: i, status

    call read_groups(file, groups)
    if (size(groups) /= 1) then
      call stop_run(status_input, file//': one group, &point, is expected, found '//str(size(groups)))
    end if
    associate (g => groups(1))
      if (g%name /= 'point') call g%fail_at(g%line, 'unknown group; known: &point')
      do i = 1, size(g%item)
        record = g%record(i, known)  ! ends the run if that name is unknown
        if (g%item(i)%name == 'fault') read (g%item(i)%values, *, iostat=status) c%fault
      end do
      c%ntens = whole(g, 'ntens')
      c%nshr = merge(3, 1, c%ntens == 6)  ! where the file does not say: those of the element family
      if (any([(g%item(i)%name == 'nshr', i=1, size(g%item))])) c%nshr = whole(g, 'nshr')
      c%ndi = c%ntens - c%nshr
      if (any([(g%item(i)%name == 'ndi', i=1, size(g%item))])) c%ndi = whole(g, 'ndi')
      c%nprops = whole(g, 'nprops')
      c%nstatv = whole(g, 'nstatv')
      call read_numbers(g, 'dtime', one)
      c%dtime = one(1)
      call read_numbers(g, 'pnewdt', one)
      c%pnewdt = one(1)
      call read_numbers(g, 'dfgrd1', nine)
      c%F = transpose(reshape(nine, [3, 3]))
      allocate (c%props(max(c%nprops, 0)), c%statev(max(c%nstatv, 0)))
      if (any([(g%item(i)%name == 'jhat', i=1, size(g%item))])) then
        call read_numbers(g, 'jhat', one)
        c%J_hat = one(1)
      end if
      call read_numbers(g, 'props', c%props)
      call read_numbers(g, 'statev', c%statev)
    end associate
  end subroutine read_call

  integer function whole(g, name)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name
    real(dp) :: x(1)

    call read_numbers(g, name, x)
    if (.not. (x(1) >= -huge(whole) - 1.0_dp .and. x(1) <= most)) call g%fail(name, 'must be at most '//str(most))
    whole = nint(x(1))
    if (abs(x(1) - whole) > 0) call g%fail(name, 'must be a whole number')
  end function whole

  ! As many numbers as x has entries, NaN and infinities too; to the bit, so one by one, not by a namelist.
  subroutine read_numbers(g, name, x)
    type(group), intent(in) :: g
    character(len=*), intent(in) :: name
    real(dp), intent(out) :: x(:)
    character(len=:), allocatable :: rest
    integer :: i, found, finish, status

    rest = ''
    found = 0
    do i = 1, size(g%item)
      if (g%item(i)%name /= name) cycle
      rest = g%item(i)%values
      found = i
    end do
    if (found == 0 .and. size(x) > 0) call g%fail(name, 'is missing')
    found = 0
    do
      rest = rest(verify(rest//'.', ' ,'):)
      if (rest == '') exit
      finish = scan(rest//' ', ' ,') - 1
      found = found + 1
      if (found <= size(x)) then
        read (rest(:finish), *, iostat=status) x(found)
        if (status /= 0 .or. index(rest(:finish), '*') > 0) then
          call g%fail(name, '"'//rest(:finish)//'" is not a number')
        end if
      end if
      rest = rest(finish + 1:)
    end do
    if (found /= size(x)) call g%fail(name, 'the number of values must be '//str(size(x))//', is '//str(found))
  end subroutine read_numbers

end module replay
