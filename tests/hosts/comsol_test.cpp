// COMSOL's external material of the type "General stress-deformation relation", called as its documentation
// says: F and the Jacobian row by row, S as xx yy zz yz xz xy; states come as at the beginning of the step in
// every iteration, and the last that came back are kept when the step has converged; after it points are
// evaluated once more at the same time.
#include <gtest/gtest.h>

#include <cmath>
#include <myogrowth/elastic/roehrle.hpp>
#include <vector>

#include "../support/larger.hpp"
#include "../support/samples.hpp"

extern "C" int eval(double[3][3], double[3][3], double*, double*, double*, double*, double[6], double[6][9],
                    int*, double*, int*, double*);

namespace {

struct Comsol {
  std::vector<double> parameters = {0, 16, 4, 0.5, 2, 1.1, 1.01, 0.6, 0.48, 0.64},
                      kept = std::vector<double>(9, 0.0), states;
  double S[6], jacobian[6][9];

  int evaluate(const Eigen::Matrix3d& F, double t) {
    double old[3][3] = {}, now[3][3], temperature = 0, system[9] = {}, delta = 0;
    for (int i = 0; i < 9; ++i) now[i / 3][i % 3] = F(i / 3, i % 3);
    parameters[0] = t;
    states = kept;
    int n_parameters = static_cast<int>(parameters.size()), n_states = static_cast<int>(states.size());
    return eval(old, now, &temperature, &temperature, system, &delta, S, jacobian, &n_parameters,
                parameters.data(), &n_states, states.data());
  }
};

Eigen::Matrix3d on_path(double t) {
  Eigen::Matrix3d F = Eigen::Vector3d(1 + 0.15 * t, 1 - 0.04 * t, 1 + 0.02 * t).asDiagonal();
  F(0, 1) = 0.1 * t, F(2, 0) = -0.05 * t;
  return F;
}

TEST(Comsol, StressStatesAndJacobian) {
  Comsol comsol;
  myogrowth::State<> exact;
  exact.n0 = {0.6, 0.48, 0.64};
  const int r[6] = {0, 1, 2, 1, 0, 0}, c[6] = {0, 1, 2, 2, 2, 1};
  double t = 0, worst = 0;
  for (const double dt : {0.1, 0.3, 0.05, 0.2, 0.4}) {
    t += dt;
    const Eigen::Matrix3d F = on_path(t);
    ASSERT_EQ(comsol.evaluate(0.5 * (F + on_path(t - dt)), t), 0);  // an iteration
    const auto u = myogrowth::update(myogrowth::FibreGrowth<>(), F, exact, dt);
    const auto second_piola = [&](int k, int l, double h) {
      Eigen::Matrix3d side = F;
      side(k, l) += h;
      return myogrowth::update(myogrowth::FibreGrowth<>(), side, exact, dt).second_piola();
    };
    ASSERT_EQ(comsol.evaluate(F, t), 0);
    for (int a = 0; a < 6; ++a) {
      EXPECT_NEAR(comsol.S[a], u.second_piola()(r[a], c[a]), 1e-13);
      for (int kl = 0; kl < 9; ++kl) {
        const double h = 1e-5, slope = (second_piola(kl / 3, kl % 3, h) - second_piola(kl / 3, kl % 3, -h))(
                                           r[a], c[a]) /
                                       (2 * h);
        worst = larger(worst, std::abs(comsol.jacobian[a][kl] - slope));
      }
    }
    exact = u.state;
    comsol.kept = comsol.states;
    EXPECT_EQ(comsol.kept[0], exact.G);
    EXPECT_EQ(comsol.kept[8], t);
    ASSERT_EQ(comsol.evaluate(F, t), 0);  // for the results: no time passes
    EXPECT_EQ(comsol.states[0], exact.G);
  }
  EXPECT_GT(exact.G, 1.01);
  EXPECT_LT(worst, 1e-7);
  std::printf("dS/dF against differences: %.1e\n", worst);
}

TEST(Comsol, AnActiveElasticLaw) {
  Comsol comsol;
  comsol.parameters[1] = comsol.parameters[2] = 0;  // of law 0
  comsol.parameters.resize(21);
  comsol.parameters[19] = 1;  // PROPS(19): Roehrle
  comsol.parameters[20] = 0.2;
  myogrowth::State<> state;
  state.n0 = {0.6, 0.48, 0.64};
  const double t = 0.5, activation = 0.2;
  const auto u =
      myogrowth::update(myogrowth::FibreGrowthOf<myogrowth::Roehrle<>>(), on_path(t), state, t, activation);
  ASSERT_EQ(comsol.evaluate(on_path(t), t), 0);
  EXPECT_GT(u.state.G, 1.005);
  EXPECT_EQ(comsol.states[0], u.state.G);
  const int r[6] = {0, 1, 2, 1, 0, 0}, c[6] = {0, 1, 2, 2, 2, 1};
  for (int a = 0; a < 6; ++a)
    EXPECT_NEAR(comsol.S[a], u.second_piola()(r[a], c[a]), 1e-12 * u.second_piola().norm());
}

TEST(Comsol, WhatIsNotAllowedIsRefusedAndStatesStay) {
  Comsol comsol;
  const auto refuses = [&](const char* text, const Eigen::Matrix3d& F, double t) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(comsol.evaluate(F, t), 1);
    EXPECT_EQ(comsol.states, comsol.kept);
    EXPECT_NE(testing::internal::GetCapturedStderr().find(text), std::string::npos) << text;
  };
  refuses("t is before the time of the states", on_path(0), -1);
  refuses("", -on_path(0), 1);
  comsol.parameters[5] = 0.5;
  refuses("PROPS(5)", on_path(0), 1);
  comsol.parameters.resize(6);
  refuses("at least 6 of PROPS are needed, is 6", on_path(0), 1);
  comsol = Comsol();
  comsol.kept.resize(8);
  refuses("states: 9 are needed, is 8", on_path(0), 1);
}

}  // namespace
