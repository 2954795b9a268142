// The table of parameters as programs use it that have no PROPS: studies, the MPI example, Python.
#include "../../abi/faults.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

using namespace myogrowth;

namespace {

namespace abi = myogrowth::abi;  // <cxxabi.h> has an abi too

const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

TEST(Properties, SymbolsAreFound) {
  for (int i = 0; i < abi::n_props; ++i) EXPECT_EQ(abi::find_property(abi::property(i).symbol), i);
  for (const char* none : {"", "c", "c11", "C1", "lambda_rev", "n0"}) EXPECT_EQ(abi::find_property(none), -1);
}

TEST(Properties, TheParametersOfAMaterialAreThoseOfItsProps) {
  FibreGrowth<double> m;
  const int entries[] = {0, 1, 2, 3, 4, 5, 13, 14, 15, 16};
  for (int i : entries) *abi::parameter(m, i) = i + 1;
  for (int i : {-1, 6, 7, 8, 9, 10, 11, 12, 17, 18}) EXPECT_EQ(abi::parameter(m, i), nullptr) << i;
  m.energy = EnergyPer::grown_volume;
  m.integration = TimeIntegration::midpoint_flow;
  double p[abi::n_props];
  abi::write(m, p);
  for (int i : entries) EXPECT_EQ(p[i], i + 1);
  p[15] = 0.5, p[16] = 1;  // allowed, so that it can be read back
  abi::Properties back;
  ASSERT_EQ(abi::read(p, back), -1);
  EXPECT_EQ(back.material.c2, 2);
  EXPECT_EQ(back.material.growth.gamma, 4);
  EXPECT_EQ(back.material.removal.tau_rev, 14);
  EXPECT_EQ(back.material.removal.lambda_crit_rev, 1);
  EXPECT_EQ(back.material.energy, EnergyPer::grown_volume);
  EXPECT_EQ(back.material.integration, TimeIntegration::midpoint_flow);
}

// A value that is not allowed is named in the same words, whether it is checked by itself or with the others.
TEST(Properties, BadValuesAreNamedBySymbol) {
  struct Bad {
    const char* symbol;
    double value;
    const char* text;
  };
  const Bad bad[] = {
      {"c1", -100, "c1 = -100: first Lame constant, must be finite and > -2/3 c2 (positive bulk modulus)."},
      {"c2", 0, "c2 = 0: second Lame constant (shear modulus), must be finite and > 0."},
      {"tau", nan, "tau = nan: time constant of growth, must be finite and > 0."},
      {"gamma", -1, "gamma = -1: shape exponent of the adaptation function, must be finite and >= 0."},
      {"G_max", 1, "G_max = 1: largest relative serial sarcomere number, must be finite and > 1."},
      {"lambda_crit", inf,
       "lambda_crit = inf: elastic fibre stretch above which sarcomeres are added, must "
       "be finite and > 0."},
      {"G_min", 1,
       "G_min = 1: smallest relative serial sarcomere number; required if tau_rev > 0, must be "
       "finite and > 0 and < 1."},
      {"lambda_crit_rev", 1.02,
       "lambda_crit_rev = 1.02: elastic fibre stretch below which sarcomeres are "
       "removed; required if tau_rev > 0, must be finite and > 0 and <= lambda_crit."},
  };
  FibreGrowth<double> good;
  good.removal = RemovalRate<double>{1, 2, 0.5, 1};
  abi::Text text = "";
  EXPECT_FALSE(abi::find_material_fault(good, text));
  for (const Bad& b : bad) {
    const int i = abi::find_property(b.symbol);
    EXPECT_TRUE(abi::find_value_fault(good, i, b.value, text)) << b.symbol;
    EXPECT_EQ(text, std::string(b.text));
    EXPECT_FALSE(abi::find_value_fault(good, i, *abi::parameter(good, i), text)) << b.symbol;
    FibreGrowth<double> m = good;
    *abi::parameter(m, i) = b.value;
    text[0] = '\0';
    EXPECT_TRUE(abi::find_material_fault(m, text)) << b.symbol;
    EXPECT_EQ(text, std::string(b.text));
  }
  good.removal = RemovalRate<double>{0, -1, 7, 1.5};  // off: need only be finite
  EXPECT_FALSE(abi::find_material_fault(good, text));
  EXPECT_TRUE(abi::find_value_fault(good, 15, 7, text));  // but a value that somebody gives is
  EXPECT_TRUE(abi::tell_bad_entry(7, inf, text));         // what may be anything must be finite, once
  EXPECT_EQ(text, std::string("n0_2 = inf: (second component), must be finite."));
}

}  // namespace
