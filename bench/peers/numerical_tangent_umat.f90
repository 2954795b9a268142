! The UMAT that most authors start with: only the stress is written, and the tangent comes from forward differences of
! it, seven evaluations per call (Sun, Chaikof and Levenston 2008, after Miehe 1996): dF = eps/2 (e_k⊗e_l + e_l⊗e_k) F.
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
  double precision, parameter :: eps = 1.d-8
  double precision :: tau(3, 3), tau_eps(3, 3), f_eps(3, 3), g, lam, detf, detfe, psi, unused(5)
  integer :: a, b, j, k, l

  call kirchhoff(props, nprops, statev(6), statev(1), dfgrd1, dtime, tau, g, lam, detf, detfe, psi)
  do b = 1, 6
    k = ii(b)
    l = jj(b)
    f_eps = dfgrd1
    do j = 1, 3
      f_eps(k, j) = f_eps(k, j) + 0.5d0*eps*dfgrd1(l, j)
      f_eps(l, j) = f_eps(l, j) + 0.5d0*eps*dfgrd1(k, j)
    end do
    call kirchhoff(props, nprops, statev(6), statev(1), f_eps, dtime, tau_eps, unused(1), unused(2), unused(3), &
                   unused(4), unused(5))
    do a = 1, 6
      ddsdde(a, b) = (tau_eps(ii(a), jj(a)) - tau(ii(a), jj(a)))/(eps*detf)
    end do
  end do

  do a = 1, 6
    stress(a) = tau(ii(a), jj(a))/detf
  end do
  sse = psi
  statev(1) = g
  statev(2) = lam/g
  statev(3) = lam
  statev(4) = detf
  statev(5) = detfe
end subroutine umat

! Kirchhoff stress at the end of a step to the deformation gradient fgrad.
subroutine kirchhoff(props, nprops, n0, gn, fgrad, dt, tau, g, lam, detf, detfe, psi)
  implicit none
  integer :: nprops, i, j
  double precision :: props(nprops), n0(3), gn, fgrad(3, 3), dt, tau(3, 3), g, lam, detf, detfe, psi
  double precision :: c1, c2, f(3), fg(3, 3), fgi(3, 3), fe(3, 3), be(3, 3), xi(3, 3), dgdlam, lnje

  c1 = props(1)
  c2 = props(2)
  do i = 1, 3
    f(i) = 0.d0
    do j = 1, 3
      f(i) = f(i) + fgrad(i, j)*n0(j)
    end do
  end do
  lam = sqrt(f(1)**2 + f(2)**2 + f(3)**2)
  call local_newton(props, nprops, gn, lam, dt, g, dgdlam)

  call identity(xi)
  do j = 1, 3
    do i = 1, 3
      fg(i, j) = xi(i, j) + (g - 1.d0)*n0(i)*n0(j)
    end do
  end do
  call inverse33(fg, fgi)
  call matmul33(fgrad, fgi, fe)
  call matmul33_transposed(fe, fe, be)
  call determinant(fgrad, detf)
  call determinant(fe, detfe)
  lnje = log(detfe)
  do j = 1, 3
    do i = 1, 3
      tau(i, j) = c1*lnje*xi(i, j) + c2*(be(i, j) - xi(i, j))
    end do
  end do
  psi = 0.5d0*c1*lnje**2 + 0.5d0*c2*(be(1, 1) + be(2, 2) + be(3, 3) - 3.d0 - 2.d0*lnje)
end subroutine kirchhoff

include 'helpers.f90'
