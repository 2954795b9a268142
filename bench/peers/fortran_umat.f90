! The same law as a UMAT in the customary style: arrays, helper routines for 3x3 algebra, a local Newton iteration
! for G, the consistent tangent in closed form by loops over the components. Complete; neither tuned nor slowed down.
! The fibre is STATEV(6:8), of unit length; PROPS are those of libmyogrowth_umat.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
                temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, &
                pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  character(len=80) :: cmname
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), &
    drplde(ntens), drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1), &
    props(nprops), coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)

  integer, parameter :: ii(6) = (/1, 2, 3, 1, 1, 2/), jj(6) = (/1, 2, 3, 2, 3, 3/)
  double precision :: c1, c2, n0(3), f(3), fe(3, 3), fg(3, 3), fgi(3, 3), be(3, 3), tau(3, 3), dtau(3, 3), xi(3, 3)
  double precision :: lam, g, gn, dgdlam, detf, detfe, lnje, c, weight
  integer :: a, b, i, j, k, l

  c1 = props(1)
  c2 = props(2)
  gn = statev(1)
  n0 = statev(6:8)

  ! fibre stretch and growth
  do i = 1, 3
    f(i) = 0.d0
    do j = 1, 3
      f(i) = f(i) + dfgrd1(i, j)*n0(j)
    end do
  end do
  lam = sqrt(f(1)**2 + f(2)**2 + f(3)**2)
  call local_newton(props, nprops, gn, lam, dtime, g, dgdlam)

  ! elastic part of the deformation gradient, its left Cauchy-Green tensor and volume ratio
  call identity(xi)
  do j = 1, 3
    do i = 1, 3
      fg(i, j) = xi(i, j) + (g - 1.d0)*n0(i)*n0(j)
    end do
  end do
  call inverse33(fg, fgi)
  call matmul33(dfgrd1, fgi, fe)
  call matmul33_transposed(fe, fe, be)
  call determinant(dfgrd1, detf)
  call determinant(fe, detfe)
  lnje = log(detfe)

  ! Kirchhoff stress and its derivative with respect to G
  do j = 1, 3
    do i = 1, 3
      tau(i, j) = c1*lnje*xi(i, j) + c2*(be(i, j) - xi(i, j))
      dtau(i, j) = -c1/g*xi(i, j) - 2.d0*c2/g**3*f(i)*f(j)
    end do
  end do

  ! Cauchy stress, and the modulus of the Jaumann rate over J
  weight = dgdlam/lam
  do b = 1, 6
    k = ii(b)
    l = jj(b)
    stress(b) = tau(k, l)/detf
    do a = 1, 6
      i = ii(a)
      j = jj(a)
      c = c1*xi(i, j)*xi(k, l) + (c2 - c1*lnje)*(xi(i, k)*xi(j, l) + xi(i, l)*xi(j, k)) &
          + 0.5d0*(xi(i, k)*tau(j, l) + xi(i, l)*tau(j, k) + tau(i, k)*xi(j, l) + tau(i, l)*xi(j, k)) &
          + dtau(i, j)*weight*f(k)*f(l)
      ddsdde(a, b) = c/detf
    end do
  end do

  sse = 0.5d0*c1*lnje**2 + 0.5d0*c2*(be(1, 1) + be(2, 2) + be(3, 3) - 3.d0 - 2.d0*lnje)
  statev(1) = g
  statev(2) = lam/g
  statev(3) = lam
  statev(4) = detf
  statev(5) = detfe
end subroutine umat

include 'helpers.f90'
