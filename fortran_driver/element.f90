! The 8-node brick with full 2x2x2 integration: finite-strain internal forces and their exact tangent.
module element
  use, intrinsic :: iso_fortran_env, only: dp => real64
  use material_point, only: material, point, increment, update, tensor, identity
  use text, only: str
  implicit none
  private
  public :: brick, new_brick, assemble, corner, n_nodes, n_points, n_dofs

  integer, parameter :: n_nodes = 8, n_points = 8, n_dofs = 24  ! dof 3 (node - 1) + direction
  ! Corners in Abaqus's node order; the integration points follow theirs, x fastest.
  real(dp), parameter :: corner(3, n_nodes) = reshape( &
    [-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1]*1.0_dp, [3, n_nodes])
  ! The place of 11 22 33 12 13 23 in a symmetric tensor.
  integer, parameter :: voigt(3, 3) = reshape([1, 4, 5, 4, 2, 6, 5, 6, 3], [3, 3])

  type :: brick
    real(dp) :: size(3)                       ! edge lengths along x, y, z
    logical :: symmetrise = .false.           ! use the symmetric part of DDSDDE, as hosts without UNSYMM do
    real(dp) :: X(3, n_nodes)                 ! reference coordinates, one corner in the origin
    real(dp) :: N(n_nodes, n_points)          ! shape functions
    real(dp) :: dN_dX(3, n_nodes, n_points)
    real(dp) :: weight                        ! reference volume of an integration point
  end type brick

contains

  function new_brick(size, symmetrise) result(b)
    real(dp), intent(in) :: size(3)
    logical, intent(in) :: symmetrise
    type(brick) :: b
    real(dp) :: factor(3)
    integer :: a, p

    b%size = size
    b%symmetrise = symmetrise
    b%weight = product(size)/n_points
    do a = 1, n_nodes
      b%X(:, a) = (corner(:, a) + 1)/2*size
    end do
    do p = 1, n_points
      do a = 1, n_nodes
        factor = (1 + corner(:, a)*integration_point(p))/2
        b%N(a, p) = product(factor)
        b%dN_dX(:, a, p) = corner(:, a)/size*[factor(2)*factor(3), factor(1)*factor(3), factor(1)*factor(2)]
      end do
    end do
  end function new_brick

  pure function integration_point(p) result(xi)
    integer, intent(in) :: p
    real(dp) :: xi(3)

    xi = (2*[modulo(p - 1, 2), modulo((p - 1)/2, 2), (p - 1)/4] - 1)/sqrt(3.0_dp)
  end function integration_point

  ! Internal forces f and tangent K at the displacements u, the points going from `old` to `new`.
  !
  !   f_ai    = sum of  s_ij dN_a/dx_j dv
  !   K_ai,bk = sum of  dN_a/dx_j [ c_ijkl - (d_ik s_jl + d_il s_jk + d_jk s_il + d_jl s_ik)/2 + d_ik s_jl ]
  !             dN_b/dx_l dv
  !
  ! with s the Cauchy stress and c = DDSDDE, which is (1/J) d(J s) under the Jaumann rate: the terms in s are
  ! what is left of that rate when the stress is pulled to a fixed area.
  !
  ! pnewdt < 1 says that the increment must be abandoned, `reason` why.
  subroutine assemble(b, m, old, inc, u, new, f, K, pnewdt, reason)
    type(brick), intent(in) :: b
    type(material), intent(in) :: m
    type(point), intent(in) :: old(n_points)
    type(increment), intent(in) :: inc
    real(dp), intent(in) :: u(n_dofs)
    type(point), intent(inout) :: new(n_points)
    real(dp), intent(out) :: f(n_dofs), K(n_dofs, n_dofs), pnewdt
    character(len=:), allocatable, intent(inout) :: reason
    real(dp), parameter :: shorter = 0.25_dp  ! for an increment that turns the element inside out
    real(dp) :: disp(3, n_nodes), deformation(3, 3), inverse_t(3, 3), J, s(3, 3), ddsdde(6, 6), asked
    real(dp) :: gradient(9, n_dofs), modulus(9, 9)  ! du_k/dx_l is entry k + 3 (l - 1)
    integer :: p, a, i

    disp = reshape(u, [3, n_nodes])
    f = 0
    K = 0
    pnewdt = 1
    do p = 1, n_points
      deformation = identity + matmul(disp, transpose(b%dN_dX(:, :, p)))
      call update(m, old(p), inc, deformation, matmul(b%X + disp, b%N(:, p)), product(b%size)**(1/3.0_dp), &
                  new(p), ddsdde, asked)
      call cofactor(deformation, inverse_t, J)
      if (.not. asked >= 1) then
        pnewdt = 0  ! for one that is not a number
        if (asked > 0) pnewdt = asked
        reason = 'the UMAT asks for PNEWDT = '//str(asked)//' at integration point '//str(p)
        return
      else if (.not. J > 0) then
        pnewdt = shorter
        reason = 'det F = '//str(J)//' at integration point '//str(p)
        return
      end if

      inverse_t = inverse_t/J
      if (b%symmetrise) ddsdde = (ddsdde + transpose(ddsdde))/2
      s = tensor(new(p)%stress)
      modulus = nominal_modulus(ddsdde, s)
      gradient = 0
      do a = 1, n_nodes
        do i = 1, 3
          gradient(i::3, 3*(a - 1) + i) = matmul(inverse_t, b%dN_dX(:, a, p))
        end do
      end do
      f = f + matmul(reshape(s, [9]), gradient)*(J*b%weight)
      K = K + matmul(transpose(gradient), matmul(modulus, gradient))*(J*b%weight)
    end do
  end subroutine assemble

  ! The bracket in K, with row i + 3 (j - 1) and column k + 3 (l - 1).
  pure function nominal_modulus(c, s) result(modulus)
    real(dp), intent(in) :: c(6, 6), s(3, 3)
    real(dp) :: modulus(9, 9)
    integer :: i, j, k, l

    do l = 1, 3
      do k = 1, 3
        do j = 1, 3
          do i = 1, 3
            modulus(i + 3*(j - 1), k + 3*(l - 1)) = c(voigt(i, j), voigt(k, l)) &
              - (identity(i, k)*s(j, l) + identity(i, l)*s(j, k) + identity(j, k)*s(i, l) &
                 + identity(j, l)*s(i, k))/2 + identity(i, k)*s(j, l)
          end do
        end do
      end do
    end do
  end function nominal_modulus

  ! J F^-T and J.
  pure subroutine cofactor(F, c, J)
    real(dp), intent(in) :: F(3, 3)
    real(dp), intent(out) :: c(3, 3), J
    integer :: i, n, m

    do i = 1, 3
      n = modulo(i, 3) + 1
      m = modulo(n, 3) + 1
      c(:, i) = [F(2, n)*F(3, m) - F(3, n)*F(2, m), F(3, n)*F(1, m) - F(1, n)*F(3, m), &
                 F(1, n)*F(2, m) - F(2, n)*F(1, m)]
    end do
    J = dot_product(c(:, 1), F(:, 1))
  end subroutine cofactor

end module element
