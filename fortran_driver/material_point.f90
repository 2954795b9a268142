! One material point as an implicit finite-strain host keeps it, and its update by the UMAT.
module material_point
  use, intrinsic :: iso_fortran_env, only: dp => real64, int64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use input, only: table_value
  use text, only: note, str, stop_run, status_input
  use umat_interface, only: umat_library
  implicit none
  private
  public :: determinant, material, point, increment, new_point, update, external_call, tensor, ntens, identity
  public :: analysis_begins, increment_begins, increment_ends, analysis_ends

  integer, parameter :: ntens = 6
  real(dp), parameter :: identity(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1]*1.0_dp, [3, 3])

  type :: material
    type(umat_library) :: library
    character(len=80) :: cmname
    real(dp), allocatable :: props(:), statev_initial(:)  ! have NPROPS and NSTATV entries
    real(dp), allocatable :: field_time(:), field_value(:)  ! field variable 1 over time
  end type material

  integer, parameter :: analysis_begins = 0, increment_begins = 1, increment_ends = 2, analysis_ends = 3  ! LOP

  ! What follows PROPS and STATEV in memory: not a number to a UMAT that reads beyond their ends, and what one that
  ! writes there is found by. A signalling NaN, which arithmetic changes: mark + 1 is written as another one. That one
  ! keeps the lower bits, which tell where a result that is not a number comes from.
  integer, parameter :: n_beyond = 1000, kept_bits = 48
  integer(int64), parameter :: statev_mark = int(z'7FF4C0FFEE000001', int64)
  integer(int64), parameter :: props_mark = int(z'7FF4C0FFEE000002', int64)

  type :: point
    integer :: number = 1
    real(dp) :: stress(ntens) = 0       ! Cauchy stress, 11 22 33 12 13 23
    real(dp) :: strain(ntens) = 0       ! logarithmic strain to second order in the increments
    real(dp) :: energy(3) = 0           ! SSE, SPD, SCD
    real(dp) :: F(3, 3) = identity
    real(dp), allocatable :: statev(:)
  end type point

  type :: increment
    real(dp) :: time = 0   ! at the beginning
    real(dp) :: dtime = 0
    integer :: number = 1
  end type increment

contains

  function new_point(m, number, coords) result(p)
    type(material), intent(in) :: m
    integer, intent(in) :: number
    real(dp), intent(in) :: coords(3)
    type(point) :: p
    real(dp), allocatable :: statev(:)

    p%number = number
    allocate (p%statev, source=m%statev_initial)
    if (.not. associated(m%library%sdvini)) return
    statev = marked(p%statev, statev_mark)
    call m%library%sdvini(statev, coords, size(p%statev), 3, 1, number, 1, 1)
    call take_statev('SDVINI', statev, p%statev)
  end function new_point

  function marked(values, mark) result(longer)
    real(dp), intent(in) :: values(:)
    integer(int64), intent(in) :: mark
    real(dp) :: longer(size(values) + n_beyond)

    longer(:size(values)) = values
    longer(size(values) + 1:) = transfer(mark, 1.0_dp)
  end function marked

  subroutine take_statev(routine, longer, statev)
    character(len=*), intent(in) :: routine
    real(dp), intent(in) :: longer(:)
    real(dp), intent(out) :: statev(:)
    integer :: n, beyond

    n = size(statev)
    beyond = findloc(transfer(longer(n + 1:), [statev_mark]) /= statev_mark, .true., 1, back=.true.)
    if (beyond > 0) call stop_run(status_input, 'the '//routine//' writes to STATEV('//str(n + beyond)// &
                                  '), and there are nstatv = '//str(n))
    statev = longer(:n)
  end subroutine take_statev

  ! Says, once, that results come from what the UMAT read beyond the end of PROPS or STATEV.
  subroutine tell_read_beyond(results, m)
    real(dp), intent(in) :: results(:)
    type(material), intent(in) :: m
    logical, save :: told = .false.

    if (told .or. .not. any(ieee_is_nan(results))) return
    call tell(props_mark, 'PROPS', size(m%props), 'needs more props')
    call tell(statev_mark, 'STATEV', size(m%statev_initial), 'needs a larger nstatv')

  contains

    subroutine tell(mark, name, n, why)
      integer(int64), intent(in) :: mark
      character(len=*), intent(in) :: name, why
      integer, intent(in) :: n

      if (all(ibits(transfer(results, [mark]), 0, kept_bits) /= ibits(mark, 0, kept_bits))) return
      call note('the UMAT computes with entries beyond '//name//'('//str(n)//'): &material '//why)
      told = .true.
    end subroutine tell

  end subroutine tell_read_beyond

  ! The UMAT's UEXTERNALDB, if it has one, as Abaqus calls it: at the beginning of an increment with the time there, at
  ! its end with the time then.
  subroutine external_call(m, lop, time, inc)
    type(material), intent(in) :: m
    integer, intent(in) :: lop
    real(dp), intent(in) :: time
    type(increment), intent(in) :: inc

    if (associated(m%library%uexternaldb)) call m%library%uexternaldb(lop, 0, [time, time], inc%dtime, 1, inc%number)
  end subroutine external_call

  ! The point at the end of an increment in which the deformation gradient becomes F. pnewdt < 1: the UMAT
  ! wants a shorter increment, and `new` must not be used.
  subroutine update(m, old, inc, F, coords, length, new, ddsdde, pnewdt)
    type(material), intent(in) :: m
    type(point), intent(in) :: old
    type(increment), intent(in) :: inc
    real(dp), intent(in) :: F(3, 3), coords(3), length
    type(point), intent(inout) :: new
    real(dp), intent(out) :: ddsdde(ntens, ntens), pnewdt
    real(dp) :: statev(size(m%statev_initial) + n_beyond)
    real(dp) :: stress(ntens + 3), dstran(ntens), drot(3, 3), rpl, ddsddt(ntens), drplde(ntens), drpldt
    real(dp) :: predef, dpred

    new = old
    predef = table_value(m%field_time, m%field_value, inc%time)
    dpred = table_value(m%field_time, m%field_value, inc%time + inc%dtime) - predef
    call hughes_winget(old%F, F, dstran, drot)
    new%stress = components(rotated(tensor(old%stress), drot), 1.0_dp)
    new%strain = components(rotated(strain_tensor(old%strain), drot), 2.0_dp)
    ddsdde = 0
    rpl = 0
    ddsddt = 0
    drplde = 0
    drpldt = 0
    pnewdt = 1
    ! The element is no mixed one. A UMAT that takes it for one (PROPS(18) = 1) finds STRESS longer and its volume
    ! ratio that of F, and the answer is the ordinary one.
    stress = [new%stress, determinant(F), 0.0_dp, 0.0_dp]
    statev = marked(new%statev, statev_mark)
    call m%library%umat(stress, statev, ddsdde, new%energy(1), new%energy(2), new%energy(3), rpl, ddsddt, &
                drplde, drpldt, new%strain, dstran, [inc%time, inc%time], inc%dtime, 0.0_dp, 0.0_dp, &
                [predef], [dpred], m%cmname, 3, 3, ntens, size(new%statev), marked(m%props, props_mark), &
                size(m%props), &
                coords, drot, pnewdt, length, old%F, F, 1, old%number, 1, 1, [1, 1, 1, 0], inc%number)
    call take_statev('UMAT', statev, new%statev)
    if (.not. m%library%is_ours) call tell_read_beyond([stress(:ntens), new%statev, ddsdde], m)
    new%stress = stress(:ntens)
    new%strain = new%strain + dstran
    new%F = F
  end subroutine update

  ! Strain increment and rotation of Hughes and Winget, from the displacement gradient at mid-increment: what
  ! Abaqus hands to a UMAT, and by which it turns the old stress. Not a number for a half turn in one
  ! increment, which only a UMAT that does not depend on F only would notice.
  subroutine hughes_winget(F0, F1, dstran, drot)
    real(dp), intent(in) :: F0(3, 3), F1(3, 3)
    real(dp), intent(out) :: dstran(ntens), drot(3, 3)
    real(dp) :: gradient(3, 3), half_spin(3, 3), inverted(3, 3)

    inverted = inverse(F1 + F0)
    gradient = 2*matmul(F1 - F0, inverted)
    half_spin = (gradient - transpose(gradient))/4
    dstran = components((gradient + transpose(gradient))/2, 2.0_dp)
    inverted = inverse(identity - half_spin)
    drot = matmul(inverted, identity + half_spin)
  end subroutine hughes_winget

  pure function rotated(a, R) result(b)
    real(dp), intent(in) :: a(3, 3), R(3, 3)
    real(dp) :: b(3, 3)

    b = matmul(R, matmul(a, transpose(R)))
  end function rotated

  pure function tensor(v) result(a)
    real(dp), intent(in) :: v(ntens)
    real(dp) :: a(3, 3)

    a = reshape([v(1), v(4), v(5), v(4), v(2), v(6), v(5), v(6), v(3)], [3, 3])
  end function tensor

  ! From engineering shears.
  pure function strain_tensor(v) result(a)
    real(dp), intent(in) :: v(ntens)
    real(dp) :: a(3, 3)

    a = tensor([v(1:3), v(4:6)/2])
  end function strain_tensor

  ! shear_factor: 1 for a stress, 2 for engineering shears.
  pure function components(a, shear_factor) result(v)
    real(dp), intent(in) :: a(3, 3), shear_factor
    real(dp) :: v(ntens)

    v = [a(1, 1), a(2, 2), a(3, 3), shear_factor*[a(1, 2), a(1, 3), a(2, 3)]]
  end function components

  pure function inverse(a) result(b)
    real(dp), intent(in) :: a(3, 3)
    real(dp) :: b(3, 3)
    integer :: i, j, k

    do i = 1, 3
      j = modulo(i, 3) + 1
      k = modulo(j, 3) + 1
      b(i, :) = cross(a(:, j), a(:, k))
    end do
    b = b/dot_product(b(1, :), a(:, 1))
  end function inverse

  pure function cross(a, b) result(c)
    real(dp), intent(in) :: a(3), b(3)
    real(dp) :: c(3)

    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  ! Zero where it is no more than the rounding of its six terms: a singular matrix is seldom exactly singular. Not
  ! finite where a term is not.
  pure real(dp) function determinant(a)
    real(dp), intent(in) :: a(3, 3)
    real(dp) :: term(6), size_of_terms

    term = [a(1, 1)*a(2, 2)*a(3, 3), a(1, 2)*a(2, 3)*a(3, 1), a(1, 3)*a(2, 1)*a(3, 2), &
            -a(1, 3)*a(2, 2)*a(3, 1), -a(1, 1)*a(2, 3)*a(3, 2), -a(1, 2)*a(2, 1)*a(3, 3)]
    determinant = sum(term)
    size_of_terms = sum(abs(term))
    if (size_of_terms > huge(determinant)) return
    if (abs(determinant) <= 4*epsilon(determinant)*size_of_terms) determinant = 0
  end function determinant

end module material_point
