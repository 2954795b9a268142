! Routines of the Fortran UMATs in this folder. They are included, so that each UMAT is one file for the compiler.

! One backward-Euler step of the growth law, with the consistent derivative dG/dlambda.
subroutine local_newton(props, nprops, gn, lam, dt, g, dgdlam)
  implicit none
  integer :: nprops, iter
  double precision :: props(nprops), gn, lam, dt, g, dgdlam, tau, gam, gmax, lcrit, kg, phi, dkg, dphi, res, dres
  double precision, parameter :: tol = 1.d-13
  integer, parameter :: max_iter = 50

  tau = props(3)
  gam = props(4)
  gmax = props(5)
  lcrit = props(6)
  g = gn
  dgdlam = 0.d0
  if (lam/gn <= lcrit .or. gn >= gmax) return
  do iter = 1, max_iter
    kg = ((gmax - g)/(gmax - 1.d0))**gam/tau
    phi = lam/g - lcrit
    dkg = -gam*kg/(gmax - g)
    dphi = -lam/g**2
    res = g - gn - dt*kg*phi
    dres = 1.d0 - dt*(dkg*phi + kg*dphi)
    g = g - res/dres
    if (abs(res) < tol) exit
  end do
  dgdlam = dt*kg/g/dres
end subroutine local_newton

subroutine identity(a)
  implicit none
  double precision :: a(3, 3)
  integer :: i

  a = 0.d0
  do i = 1, 3
    a(i, i) = 1.d0
  end do
end subroutine identity

! c = a b
subroutine matmul33(a, b, c)
  implicit none
  double precision :: a(3, 3), b(3, 3), c(3, 3)
  integer :: i, j, k

  do j = 1, 3
    do i = 1, 3
      c(i, j) = 0.d0
      do k = 1, 3
        c(i, j) = c(i, j) + a(i, k)*b(k, j)
      end do
    end do
  end do
end subroutine matmul33

! c = a b^T
subroutine matmul33_transposed(a, b, c)
  implicit none
  double precision :: a(3, 3), b(3, 3), c(3, 3)
  integer :: i, j, k

  do j = 1, 3
    do i = 1, 3
      c(i, j) = 0.d0
      do k = 1, 3
        c(i, j) = c(i, j) + a(i, k)*b(j, k)
      end do
    end do
  end do
end subroutine matmul33_transposed

subroutine determinant(a, det)
  implicit none
  double precision :: a(3, 3), det

  det = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) &
        + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
end subroutine determinant

! b = a^-1
subroutine inverse33(a, b)
  implicit none
  double precision :: a(3, 3), b(3, 3), det

  call determinant(a, det)
  b(1, 1) = (a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2))/det
  b(1, 2) = (a(1, 3)*a(3, 2) - a(1, 2)*a(3, 3))/det
  b(1, 3) = (a(1, 2)*a(2, 3) - a(1, 3)*a(2, 2))/det
  b(2, 1) = (a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3))/det
  b(2, 2) = (a(1, 1)*a(3, 3) - a(1, 3)*a(3, 1))/det
  b(2, 3) = (a(1, 3)*a(2, 1) - a(1, 1)*a(2, 3))/det
  b(3, 1) = (a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))/det
  b(3, 2) = (a(1, 2)*a(3, 1) - a(1, 1)*a(3, 2))/det
  b(3, 3) = (a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1))/det
end subroutine inverse33
