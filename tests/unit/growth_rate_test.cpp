#include <gtest/gtest.h>
#include <myogrowth/growth_rate.hpp>

#include "../support/dual.hpp"

using myogrowth::GrowthRate;
using Complex = std::complex<double>;

namespace {

TEST(Scalar, PowerByMultiplicationIsPower) {
  for (double exponent : {0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 8.5, 9.0, 0.3, 2.7, -1.0}) {
    for (double x : {1e-9, 0.02, 0.7, 1.0, 3.0}) {
      EXPECT_NEAR(myogrowth::power(x, exponent) / std::pow(x, exponent), 1, 4e-15) << x << '^' << exponent;
    }
  }
  EXPECT_EQ(myogrowth::power(0.0, 0.0), 1.0);
}

TEST(Scalar, ComplexLog1pKeepsBothParts) {
  EXPECT_DOUBLE_EQ(myogrowth::log1p(Complex(1e-17, 0)).real(), 1e-17);
  EXPECT_DOUBLE_EQ(myogrowth::log1p(Complex(0.5, 1e-30)).imag(), 1e-30 / 1.5);
  const Complex z(-0.9, 0.3);
  EXPECT_NEAR(std::abs(myogrowth::log1p(z) - std::log(1.0 + z)), 0, 1e-15);
}

TEST(GrowthRate, PaperEquation4) {
  const GrowthRate<> rate{0.5, 2, 1.1, 1.01};
  EXPECT_DOUBLE_EQ(rate.capacity(1.0), 1);
  EXPECT_DOUBLE_EQ(rate.adaptation(1.0), 2);
  EXPECT_NEAR(rate.adaptation(1.05), 0.5, 1e-14);  // half the distance to the limit, squared, over 0.5
  EXPECT_NEAR(rate.criterion(1.06), 0.05, 1e-15);
  EXPECT_NEAR(rate.rate(1.05, 1.05 * 1.06), 0.025, 1e-14);
}

TEST(GrowthRate, NothingAtAndBeyondTheLimits) {
  const GrowthRate<> rate{0.5, 2, 1.1, 1.01};
  for (double G : {1.1, 1.2, 5.0}) {  // gamma = 2 is even: the formula itself is positive again beyond G_max
    EXPECT_EQ(rate.capacity(G), 0);
    EXPECT_EQ(rate.dcapacity_dG(G), 0);
  }
  EXPECT_EQ(rate.criterion(1.01), 0);
  EXPECT_EQ(rate.criterion(0.5), 0);
}

TEST(GrowthRate, DerivativesByComplexStep) {
  for (double gamma : {0.0, 0.5, 1.0, 2.0, 2.5, 3.7}) {
    const GrowthRate<> rate{0.5, gamma, 1.3, 1.01};
    for (double G : {0.9, 1.0, 1.1, 1.29}) {
      const double h = 1e-30;
      EXPECT_NEAR(rate.capacity(Complex(G, h)).imag() / h, rate.dcapacity_dG(G), 1e-13);
      EXPECT_NEAR(rate.adaptation(Complex(G, h)).imag() / h, rate.dadaptation_dG(G), 1e-13);
      EXPECT_EQ(rate.criterion(Complex(1.2, h)).imag() / h, 1);
    }
  }
}

TEST(GrowthRate, ParametersMayCarryDerivatives) {
  using dual::Dual;
  const double G = 1.06, lambda = 1.1, x = (1.1 - G) / 0.1;
  const GrowthRate<Dual> rate{Dual(0.5), Dual(2, 1), Dual(1.1), Dual(1.01)};  // d/dgamma
  const double plain = GrowthRate<>{0.5, 2, 1.1, 1.01}.rate(G, lambda);
  const Dual with = rate.rate(Dual(G), Dual(lambda));
  EXPECT_NEAR(with.v, plain, 1e-15);
  EXPECT_NEAR(with.d, plain * std::log(x), 1e-14);
}

}  // namespace
