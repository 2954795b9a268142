! Somebody else's UMAT, for the tests: linear elasticity in rate form, and a limit on the time increment.
! PROPS: Young's modulus, Poisson's ratio, largest DTIME (0: any).
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
                dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, &
                dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
  character(len=80) :: cmname
  double precision :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), &
    drplde(ntens), drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1), &
    props(nprops), coords(3), drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  double precision :: mu, lambda
  integer :: i

  if (props(3) > 0 .and. dtime > props(3)*1.000001d0) then
    pnewdt = 0.4d0
    return
  end if
  mu = props(1)/(2*(1 + props(2)))
  lambda = props(1)*props(2)/((1 + props(2))*(1 - 2*props(2)))
  ddsdde = 0
  ddsdde(1:3, 1:3) = lambda
  do i = 1, 3
    ddsdde(i, i) = lambda + 2*mu
    ddsdde(i + 3, i + 3) = mu
  end do
  stress = stress + matmul(ddsdde, dstran)
end subroutine umat
