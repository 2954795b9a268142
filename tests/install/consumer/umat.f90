! The same step through the UMAT, from a Fortran program that is linked with it.
program step
  use, intrinsic :: iso_fortran_env, only: dp => real64
  implicit none
  real(dp) :: stress(6), statev(8), ddsdde(6, 6), sse, spd, scd, rpl, ddsddt(6), drplde(6), drpldt, pnewdt
  real(dp), parameter :: zero(6) = 0, identity(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
  real(dp), parameter :: props(6) = [16.0_dp, 4.0_dp, 0.5_dp, 2.0_dp, 1.1_dp, 1.01_dp]
  real(dp) :: f(3, 3)
  external :: umat

  f = identity
  f(1, 1) = 1.2_dp
  f(2, 2) = 0.95_dp
  f(3, 3) = 0.95_dp
  stress = 0
  statev = 0
  pnewdt = 1
  call umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, zero, zero, zero(1:2), 0.1_dp, &
            0.0_dp, 0.0_dp, zero(1:1), zero(1:1), repeat(' ', 80), 3, 3, 6, 8, props, 6, zero(1:3), identity, &
            pnewdt, 1.0_dp, identity, f, 1, 1, 1, 1, [1, 0, 0, 0], 1)
  print '(es24.17, 1x, es24.17)', statev(1), stress(1)
end program step
