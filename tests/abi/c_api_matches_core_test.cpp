// The C API is the C++ core, bit for bit.
#include <gtest/gtest.h>
#include <myogrowth.h>

#include <myogrowth/left_stretch.hpp>

#include "../support/samples.hpp"

using namespace myogrowth;
using samples::Kind;

namespace {

struct Result {
  int status;
  double state[9], energy;
  Eigen::VectorXd stress;
  Eigen::MatrixXd tangent;
};

Result run(const samples::Point& p, int measure, bool local_basis = false) {
  const auto& g = p.muscle.growth;
  const double grown = p.muscle.energy == EnergyPer::grown_volume;
  const double props[] = {p.muscle.c1,   p.muscle.c2,         g.growth_time, g.gamma,
                          g.G_max,       g.lambda_crit,       p.state.n0[0], p.state.n0[1],
                          p.state.n0[2], double(local_basis), grown};
  const int n = myogrowth_stress_size(measure);
  Result r{-1, {p.state.G}, 0, Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  r.status = myogrowth_update(props, 11, p.F.data(), r.state, r.state, 9, p.dt, measure, r.stress.data(),
                              r.tangent.data(), &r.energy, nullptr, 0);
  return r;
}

samples::Point point(samples::Random& r) {
  samples::Point p = samples::point(r, r.chance(0.5) ? Kind::growing : Kind::any);
  p.muscle.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
  return p;
}

TEST(CApi, IsTheCoreBitForBit) {
  samples::Random r(61);
  for (int i = 0; i < 2000; ++i) {
    const samples::Point p = point(r);
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    const Mat3<double> P = u.first_piola();
    const Result cauchy = run(p, MYOGROWTH_CAUCHY), first = run(p, MYOGROWTH_FIRST_PIOLA),
                 second = run(p, MYOGROWTH_SECOND_PIOLA);
    EXPECT_EQ(cauchy.stress, to_six(u.cauchy()));
    EXPECT_EQ(cauchy.tangent, u.ddsdde());
    EXPECT_EQ(first.stress, Eigen::Map<const Eigen::VectorXd>(P.data(), 9));
    EXPECT_EQ(first.tangent, u.dP_dF());
    EXPECT_EQ(second.stress, to_six(u.second_piola()));
    EXPECT_EQ(second.tangent, u.dS_dE());
    for (const Result* c : {&cauchy, &first, &second}) {
      EXPECT_EQ(c->status, MYOGROWTH_OK);
      EXPECT_EQ(c->energy, u.point.psi);
      const double state[9] = {u.state.G,     u.point.lambda_e, u.point.lambda, u.point.J, u.point.Je,
                               u.point.n0[0], u.point.n0[1],    u.point.n0[2],  0};
      for (int k = 0; k < 9; ++k) EXPECT_EQ(c->state[k], state[k]) << k;
    }
  }
}

TEST(CApi, TakesTheLeftStretchInALocalBasis) {
  samples::Random r(62);
  for (int i = 0; i < 200; ++i) {
    samples::Point p = point(r);
    const Result local = run(p, MYOGROWTH_CAUCHY, true);
    ASSERT_TRUE(left_stretch(p.F.data(), p.F.data()));
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    EXPECT_EQ(local.stress, to_six(u.cauchy()));
    EXPECT_EQ(local.tangent, u.ddsdde());
    EXPECT_EQ(local.state[0], u.state.G);
  }
}

}  // namespace
