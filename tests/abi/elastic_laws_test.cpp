// The elastic laws of PROPS(19:31) through the UMAT: the results of the library, in every element family; and
// every entry that is wrong is named.
#include "../../abi/elastic_laws.hpp"

#include <gtest/gtest.h>

#include <myogrowth/material.hpp>
#include <myogrowth/more/stress_states.hpp>
#include <string>

#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using namespace myogrowth;

namespace {

namespace abi = myogrowth::abi;  // <cxxabi.h> has an abi too
using Props = std::vector<double>;

const double nan = std::numeric_limits<double>::quiet_NaN();

// PROPS of a law with the published parameters, an oblique fibre, and growth as in Table 1.
Props props_of(int law, double activation) {
  Props p(20, 0.0);
  const double growth[] = {0.5, 2, 1.1, 1.01, 1, 0.5, -0.3};
  for (int i = 0; i < 7; ++i) p[static_cast<std::size_t>(i + 2)] = growth[i];
  p[18] = law;
  p[19] = activation;
  return p;
}

// The same in the library's own terms, without the table.
template <class Law>
FibreGrowthOf<Law> muscle_of(const Law& law) {
  return {law, {0.5, 2, 1.1, 1.01}, {}, {}, {}};
}

template <class Law>
void expect_the_library(int number, const Law& law, Props extra = {}, double energy = 0) {
  samples::Random r(31);
  for (int i = 0; i < 20; ++i) {
    const double activation = i % 4 == 0 ? 0 : r.uniform();
    host::Call c;
    c.props = props_of(number, activation);
    c.props[10] = energy;
    c.props.insert(c.props.end(), extra.begin(), extra.end());
    c.F = samples::rotation(r) * samples::deformation(r, 0.15);
    FibreGrowthOf<Law> muscle = muscle_of(law);
    if (energy == 1) muscle.energy = EnergyPer::grown_volume;
    State<> state;
    state.n0 = {1, 0.5, -0.3};
    const auto u = update(muscle, c.F, state, 0.1, activation);
    ASSERT_TRUE(u.ok());
    c.run();
    const Vec6<double> sigma = to_six(u.cauchy());
    EXPECT_LE((c.stress - sigma).norm(), 1e-14 * (sigma.norm() + 1));
    EXPECT_LE((c.ddsdde - u.ddsdde()).norm(), 1e-14 * u.ddsdde().norm());
    EXPECT_EQ(c.statev[0], u.state.G);
    EXPECT_EQ(c.statev[1], u.point.lambda_e);
    EXPECT_EQ(c.sse, u.point.psi);
    EXPECT_EQ(c.pnewdt, 1);

    host::Call flat;  // plane strain
    flat.ntens = 4;
    flat.props = c.props;
    flat.F.topLeftCorner<2, 2>() = samples::deformation(r, 0.15).topLeftCorner<2, 2>();
    const auto v = update(muscle, flat.F, state, 0.1, activation);
    flat.run();
    for (int k = 0; k < 4; ++k)
      EXPECT_NEAR(flat.stress[k], to_six(v.cauchy())[k], 1e-13 * (1 + v.cauchy().norm()));
  }
}

TEST(ElasticLaws, AreTheLibrarysThroughTheUmat) {
  expect_the_library(1, Roehrle<>());
  expect_the_library(2, Blemker<>());
  expect_the_library(3, Ehret<>());
  expect_the_library(1, Roehrle<>{5, 6, 70, 80, 90, 1.2, 0.06, 5}, {5, 6, 70, 80, 90, 1.2, 0.06, 5}, 1);
  expect_the_library(2, Blemker<>{1, 2, 300, 40, 1.3, 0.06, 5, 1.03, true, 500, 20},
                     {1, 2, 300, 40, 1.3, 0.06, 5, 1.03, 1, 500, 20});
  expect_the_library(3, Ehret<>{10, 2, 0.5, 20, 0.5, 50, 0.7, 1.3}, {10, 2, 0.5, 20, 0.5, 50, 0.7, 1.3});
}

TEST(ElasticLaws, TableAndStructsHaveTheSameDefaults) {
  const auto defaults = [](abi::Law law) {
    Props p;
    for (int i = 0; i < abi::parameters_of(law).size; ++i)
      p.push_back(abi::parameters_of(law).entry[i].initial);
    return p;
  };
  const Roehrle<> a = abi::roehrle_of(defaults(abi::Law::roehrle).data()), A;
  EXPECT_EQ(Props({a.c10, a.c01, a.kappa, a.sigma_p, a.sigma_a, a.lambda_opt, a.g1, a.g2}),
            Props({A.c10, A.c01, A.kappa, A.sigma_p, A.sigma_a, A.lambda_opt, A.g1, A.g2}));
  const Blemker<> b = abi::blemker_of(defaults(abi::Law::blemker).data()), B;
  EXPECT_EQ(Props({b.G1, b.G2, b.kappa, b.sigma_max, b.lambda_opt, b.P1, b.P2, b.lambda_star, b.L1, b.L2}),
            Props({B.G1, B.G2, B.kappa, B.sigma_max, B.lambda_opt, B.P1, B.P2, B.lambda_star, B.L1, B.L2}));
  EXPECT_FALSE(b.tendon);
  const Ehret<> e = abi::ehret_of(defaults(abi::Law::ehret).data()), E;
  EXPECT_EQ(Props({e.alpha, e.beta, e.gamma, e.kappa, e.w0, e.P_opt, e.lambda_min, e.lambda_opt}),
            Props({E.alpha, E.beta, E.gamma, E.kappa, E.w0, E.P_opt, E.lambda_min, E.lambda_opt}));
}

// The Cauchy stress of law 3 along the fibre where the sides of a cube are free, by calls of the UMAT.
double stress_with_free_sides(Props props, double stretch) {
  props[6] = 1, props[7] = props[8] = 0;
  double low = 0.9, high = 2;
  host::Call c;
  for (int i = 0; i < 60; ++i) {
    const double side = (low + high) / 2;
    c = host::Call();
    c.props = props;
    c.predef = 0.3341 / 2;  // read where PROPS(20) = -1
    c.F = Eigen::Vector3d(stretch, side, side).asDiagonal();
    c.run();
    (c.stress[1] > 0 ? high : low) = side;
  }
  return c.stress[0];
}

// The values of 4C's own regression tests of law 3 (MAT_Muscle_Combo): passive, the fibre compressed to a
// half; and active, free on all sides.
TEST(ElasticLaws, PassiveCubeOf4C) {
  Props props = props_of(3, 0);
  for (const double x : {15.0, 1.0, 5.0, 100.0, 0.8}) props.push_back(x);
  EXPECT_NEAR(stress_with_free_sides(props, 0.5), -25.913195669478583, 1e-12);
}
TEST(ElasticLaws, FreeContractionOf4C) {
  for (const double activation : {0.3341 / 2, -1.0}) {
    double low = 0.6, high = 0.8;
    for (int i = 0; i < 60; ++i) {
      const double stretch = (low + high) / 2;
      (stress_with_free_sides(props_of(3, activation), stretch) > 0 ? high : low) = stretch;
    }
    EXPECT_NEAR(low - 1, -0.31358536573847257, 1e-9);
  }
}

TEST(ElasticLaws, TheActivationMayBeAFieldVariable) {
  for (int law = 1; law <= 3; ++law) {
    host::Call number, field;
    number.F(0, 0) = field.F(0, 0) = 1.2;
    number.props = props_of(law, 0.75);
    field.props = props_of(law, -1);
    field.predef = 0.5, field.dpred = 0.25;
    number.run(), field.run();
    EXPECT_EQ(number.stress, field.stress);
    EXPECT_EQ(number.ddsdde, field.ddsdde);
    host::Call passive;
    passive.F(0, 0) = 1.2;
    passive.props = props_of(law, 0);
    EXPECT_GT(field.stress[0], passive.run().stress[0] + 1);  // it is active
    field.predef = 1, field.dpred = 1e-12;                    // a host's rounding
    EXPECT_EQ(field.run().pnewdt, 1);
    field.dpred = 1e-3;
    EXPECT_EQ(field.run().pnewdt, 0.25);
    EXPECT_TRUE(std::isnan(field.stress.norm()));
  }
}

TEST(ElasticLaws, PlaneStressAndMixedElements) {
  for (int law = 1; law <= 3; ++law) {
    host::Call shell;
    shell.ntens = 3;
    shell.statev.assign(9, 0.0);
    shell.props = props_of(law, 0.3);
    shell.props[8] = 0;  // the fibre in the plane
    shell.F << 1.05, 0.02, 0, -0.01, 1.02, 0, 0, 0, 1;
    shell.run();
    ASSERT_EQ(shell.pnewdt, 1);
    host::Call solid;
    solid.props = shell.props;
    solid.F = shell.F;
    solid.F(2, 2) = shell.statev[8];
    solid.run();
    EXPECT_LE(std::abs(solid.stress[2]), 1e-11 * solid.ddsdde.norm());
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(shell.stress[k], solid.stress[k], 1e-10 * solid.ddsdde.norm());

    host::Call mixed;
    mixed.props = solid.props;
    mixed.props[17] = 1;
    mixed.F = solid.F;
    mixed.J_hat = solid.F.determinant();
    mixed.run();
    ASSERT_EQ(mixed.pnewdt, 1);
    EXPECT_LE((mixed.stress - solid.stress).norm(), 1e-11 * solid.ddsdde.norm());
    EXPECT_TRUE(is_finite(mixed.K) && is_finite(mixed.dK_dJ));
  }
}

// With 0 or without an entry all is as ever.
TEST(ElasticLaws, NoneIsTheNeoHookeanLaw) {
  host::Call before, after;
  before.F(0, 0) = after.F(0, 0) = 1.1;
  after.props.resize(31, 0.0);
  after.props[6] = 1;
  before.run(), after.run();
  EXPECT_EQ(before.stress, after.stress);
  EXPECT_EQ(before.ddsdde, after.ddsdde);
}

TEST(ElasticLaws, WhatIsWrongIsNamed) {
  struct Bad {
    int law;
    std::size_t entry;  // of PROPS, from 1
    double value;
    const char* text;
  };
  const Bad bad[] = {
      {4, 19, 4,
       "PROPS(19) = 4: elastic law, must be 0 (neo-Hookean), 1 (Roehrle), 2 (Blemker) or 3 (Ehret)."},
      {1, 19, nan, "PROPS(19) = nan: elastic law, must be 0 (neo-Hookean), 1"},
      {1, 1, 16, "PROPS(1) = 16: c1 is a constant of elastic law 0, must be 0 with PROPS(19) = 1."},
      {2, 2, 4, "PROPS(2) = 4: c2 is a constant of elastic law 0"},
      {1, 5, 0.9, "PROPS(5) = 0.9: G_max, largest"},
      {1, 20, 1.5, "PROPS(20) = 1.5: activation, must be >= 0 and <= 1, or -1 for field variable 1."},
      {1, 20, nan, "PROPS(20) = nan: activation"},
      {1, 21, 0, "PROPS(21) = 0: c10, matrix, must be finite and > 0."},
      {1, 28, -1, "PROPS(28) = -1: g2, passive curve, exponent, must be finite and > 0."},
      {1, 29, 1,
       "PROPS(29) = 1: elastic law 1 (Roehrle) has 8 parameters, PROPS(21:28); further ones must be 0."},
      {2, 28, 1, "PROPS(28) = 1: lambda_star"},
      {2, 29, 0.5,
       "PROPS(29) = 0.5: tendon, 0: muscle, 1: tendon or aponeurosis, never active, must be finite and 0 or "
       "1."},
      {3, 25, 1.1, "PROPS(25) = 1.1: w0, weight of the isotropic part, must be finite and >= 0 and <= 1."},
      {3, 28, 0.5, "PROPS(28) = 0.5: lambda_opt, optimum elastic stretch, must be finite and > lambda_min."},
  };
  for (const Bad& b : bad) {
    Props p = props_of(b.law, 0.5);
    for (int i = 0; b.law <= 3 && i < abi::parameters_of(static_cast<abi::Law>(b.law)).size; ++i)
      p.push_back(abi::parameters_of(static_cast<abi::Law>(b.law)).entry[i].initial);
    p.resize(std::max<std::size_t>(p.size(), 29), 0.0);
    p[b.entry - 1] = b.value;
    abi::Properties properties;
    abi::LawChoice choice{};
    abi::Text text = "";
    EXPECT_TRUE(abi::find_law_fault(p.data(), static_cast<int>(p.size()), true, properties, choice, text));
    EXPECT_EQ(std::string(text).substr(0, std::strlen(b.text)), b.text);
    host::Call c;
    c.props = p;
    c.run();
    EXPECT_EQ(c.pnewdt, 0.25) << b.text;
    EXPECT_TRUE(std::isnan(c.stress.norm()) && std::isnan(c.ddsdde.norm()));
    EXPECT_EQ(c.statev[0], 0);
  }
}

TEST(ElasticLaws, Law0HasNoFurtherConstants) {
  abi::Properties properties;
  abi::LawChoice choice;
  abi::Text text;
  Props p = props_of(0, 0.5);
  p[0] = 16, p[1] = 4;
  EXPECT_TRUE(abi::find_muscle_fault(p.data(), static_cast<int>(p.size()), true, properties, choice, text));
  EXPECT_EQ(std::string(text), "PROPS(20) = 0.5: elastic law 0 has 18 constants; further ones must be 0.");
}

}  // namespace
