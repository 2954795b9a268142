// The library compared with an independent evaluation in 50 digits: random oblique fibres, F up to 60 % off
// identity, large rotations, dt up to 10,000 tau, gamma 0.5 to 4, both energy conventions. The tangents are
// compared with central differences of the reference's own discrete update.
#include <gtest/gtest.h>

#include "../support/reference.hpp"

using namespace myogrowth;
using samples::Kind;

namespace {

double error(const reference::Real& exact, double x) {
  return static_cast<double>(abs(reference::Real(x) - exact) / abs(exact));
}
template <class A, class B>
double error(const Eigen::MatrixBase<A>& exact, const Eigen::MatrixBase<B>& x) {
  return (x - exact).norm() / exact.norm();
}

struct Worst {
  double G = 0, lambda_e = 0, stress = 0, ddsdde = 0, dP_dF = 0, dS_dE = 0, psi = 0;
};

Worst worst_of(Kind kind, EnergyPer energy, int n, std::uint64_t seed) {
  samples::Random r(seed);
  Worst w;
  for (int i = 0; i < n; ++i) {
    samples::Point p = samples::point(r, kind);
    p.muscle.energy = energy;
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    EXPECT_TRUE(u.ok());
    const reference::Matrix F = reference::exact(p.F);
    const reference::Result exact = reference::update(p, F);
    w.G = std::max(w.G, error(exact.G, u.state.G));
    w.lambda_e = std::max(w.lambda_e, error(exact.lambda_e, u.point.lambda_e));
    w.psi = std::max(w.psi, error(exact.psi, u.point.psi));
    w.stress = std::max(w.stress, error(reference::rounded(exact.tau), u.kirchhoff()));
    w.ddsdde = std::max(w.ddsdde, error(reference::ddsdde(p), u.ddsdde()));
    w.dP_dF = std::max(w.dP_dF, error(reference::dP_dF(p), u.dP_dF()));
    w.dS_dE = std::max(w.dS_dE, error(reference::dS_dE(p), u.dS_dE()));
  }
  return w;
}

class Accuracy : public testing::TestWithParam<std::tuple<Kind, EnergyPer>> {};

TEST_P(Accuracy, AgainstFiftyDigits) {
  const auto [kind, energy] = GetParam();
  const Worst w = worst_of(kind, energy, 300, 20261122);
  EXPECT_LE(w.G, 1e-13);
  EXPECT_LE(w.lambda_e, 1e-13);
  EXPECT_LE(w.psi, 1e-12);
  EXPECT_LE(w.stress, 1e-12);
  EXPECT_LE(w.ddsdde, 1e-11);
  EXPECT_LE(w.dP_dF, 1e-11);
  EXPECT_LE(w.dS_dE, 1e-11);
  std::printf(
      "worst relative error: G %.1e  lambda_e %.1e  psi %.1e  stress %.1e  DDSDDE %.1e  dP/dF %.1e  dS/dE "
      "%.1e\n",
      w.G, w.lambda_e, w.psi, w.stress, w.ddsdde, w.dP_dF, w.dS_dE);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Accuracy,
                         testing::Combine(testing::Values(Kind::growing, Kind::below_threshold,
                                                          Kind::saturated, Kind::elastic_step, Kind::any),
                                          testing::Values(EnergyPer::reference_volume,
                                                          EnergyPer::grown_volume)));

}  // namespace
