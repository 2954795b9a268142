// Growth laws of one's own: the paper's law compared with update(), isotropic growth compared with
// differences, the limits of growth.
#include <gtest/gtest.h>

#include <myogrowth/more/growth_law.hpp>

#include "../support/samples.hpp"

using namespace myogrowth;

namespace {

// Eqs 2 and 4 as a law.
struct AlongTheFibre {
  GrowthRate<> growth;
  double limit() const { return growth.G_max; }
  template <class T>
  Mat3<T> growth_tensor(const T& g, const Vec3<T>& n0) const {
    return myogrowth::growth_tensor(n0, g);
  }
  template <class T>
  T rate(const T& g, const Mat3<T>& Fe, const Vec3<T>& n0) const {
    return growth.adaptation(g) * growth.criterion(fibre_stretch(Fe, n0));
  }
};

// Growth in all directions under a mean elastic stretch above a threshold.
struct Isotropic {
  double limit() const { return 1.5; }
  template <class T>
  Mat3<T> growth_tensor(const T& g, const Vec3<T>&) const {
    return T(pow(g, 1. / 3)) * Mat3<T>::Identity();
  }
  template <class T>
  T rate(const T& g, const Mat3<T>& Fe, const Vec3<T>&) const {
    const T over = T(Fe.determinant()) - 1.02;
    return value(over) > 0 ? T((1.5 - g) / 0.5 * over) : T(0);
  }
};

// Growth at one rate, at the limit too.
struct Steady : Isotropic {
  template <class T>
  T rate(const T&, const Mat3<T>&, const Vec3<T>&) const {
    return T(2);
  }
};

const Vec3<double> n0 = Vec3<double>(2, 1, -2) / 3;
const Mat3<double> stretched = (Mat3<double>() << 1.1, 0.1, 0, -0.05, 1.05, 0.02, 0, 0.1, 0.98).finished();

TEST(GrowthLaw, ThePapersLawIsThatOfUpdate) {
  samples::Random r(7);
  for (int i = 0; i < 200; ++i) {
    samples::Point p = samples::point(r, samples::Kind::growing);
    p.state.n0.normalize();
    const auto expected = update(p.muscle, p.F, p.state, p.dt);
    const LawUpdate u = update(AlongTheFibre{p.muscle.growth}, NeoHookean<>{p.muscle.c1, p.muscle.c2}, p.F,
                               p.state.n0, p.state.G, p.dt);
    ASSERT_TRUE(u.ok());
    EXPECT_NEAR(u.g, expected.state.G, 1e-14 * u.g);
    EXPECT_LE((u.P - expected.first_piola()).norm(), 1e-12 * expected.first_piola().norm() + 1e-13);
    EXPECT_LE((u.dP_dF - expected.dP_dF()).norm(), 1e-10 * expected.dP_dF().norm());
  }
}

TEST(GrowthLaw, IsotropicByDifferences) {
  const Isotropic law;
  const NeoHookean<> elasticity;
  const double dt = 0.5, g_n = 1.01, h = 1e-6;
  const LawUpdate u = update(law, elasticity, stretched, n0, g_n, dt);
  ASSERT_GT(u.g, g_n);
  const Mat3<double> Fe = stretched / std::cbrt(u.g);
  EXPECT_NEAR(u.g - g_n - dt * (1.5 - u.g) / 0.5 * (Fe.determinant() - 1.02), 0, 1e-15);
  EXPECT_LE((u.P * stretched.transpose() - elasticity.kirchhoff<double>(Fe * Fe.transpose())).norm(), 1e-13);
  for (int k = 0; k < 9; ++k) {
    Mat3<double> plus = stretched, minus = stretched;
    plus.data()[k] += h;
    minus.data()[k] -= h;
    const LawUpdate a = update(law, elasticity, plus, n0, g_n, dt),
                    b = update(law, elasticity, minus, n0, g_n, dt);
    EXPECT_NEAR(u.dg_dF.data()[k], (a.g - b.g) / (2 * h), 1e-9);
    for (int i = 0; i < 9; ++i) {
      EXPECT_NEAR(u.dP_dF(i, k), (a.P.data()[i] - b.P.data()[i]) / (2 * h), 1e-7);
    }
  }
}

TEST(GrowthLaw, TheEndsOfTheWay) {
  const Isotropic law;
  const NeoHookean<> elasticity;
  for (double dt : {0.0, -1.0}) EXPECT_EQ(update(law, elasticity, stretched, n0, 1.01, dt).g, 1.01);
  const LawUpdate rest = update(law, elasticity, Mat3<double>::Identity(), n0, 1, 10);  // below the threshold
  EXPECT_EQ(rest.g, 1);
  EXPECT_EQ(rest.dg_dF.norm(), 0);
  EXPECT_EQ(update(law, elasticity, 2 * stretched, n0, 1.6, 1).g, 1.6);  // beyond its limit
  EXPECT_NEAR(update(law, elasticity, 2 * stretched, n0, 1, 1e12).g, 1.5, 1e-9);
  AlongTheFibre linear;
  linear.growth.gamma = 0;  // its rate is not zero at the limit: growth ends there
  const LawUpdate full = update(linear, elasticity, 1.5 * Mat3<double>::Identity(), n0, 1, 100);
  EXPECT_EQ(full.g, 1.1);
  EXPECT_EQ(full.dg_dF.norm(), 0);
  EXPECT_TRUE(full.ok());
  EXPECT_NEAR(update(Steady(), elasticity, stretched, n0, 1, 0.2).g, 1.4, 1e-15);
  const LawUpdate cut =
      update(Steady(), elasticity, stretched, n0, 1, 0.3);  // 1.6, were it not for the limit
  const LawUpdate held = update(Steady(), elasticity, stretched, n0, 1.5, 0);
  EXPECT_EQ(cut.g, 1.5);
  EXPECT_EQ(cut.P, held.P);
  EXPECT_EQ(cut.dP_dF, held.dP_dF);
}

// A law whose derivative is not that of its rate: Newton's steps are then 10,000 times too short.
struct WrongDerivative {
  double limit() const { return 1.5; }
  template <class T>
  Mat3<T> growth_tensor(const T& g, const Vec3<T>& n0) const {
    return myogrowth::growth_tensor(n0, g);
  }
  template <class T>
  T rate(const T& g, const Mat3<T>&, const Vec3<T>&) const {
    const double exact = 1.5 - value(g);
    return T(exact) - T(1e4) * (g - T(value(g)));
  }
};

TEST(GrowthLaw, SaysThatItHasNotConverged) {
  const LawUpdate u = update(WrongDerivative(), NeoHookean<>(), stretched, n0, 1.2, 1);
  EXPECT_EQ(u.status, UpdateStatus::not_converged);
  EXPECT_FALSE(u.ok());
  EXPECT_EQ(u.g, 1.2);
  EXPECT_TRUE(std::isnan(u.P.norm()) && std::isnan(u.dP_dF.norm()));
}

TEST(GrowthLaw, NoResult) {
  const Isotropic law;
  const NeoHookean<> elasticity;
  const LawUpdate inverted = update(law, elasticity, -Mat3<double>::Identity(), n0, 1.2, 1);
  EXPECT_EQ(inverted.status, UpdateStatus::inverted);
  EXPECT_EQ(inverted.g, 1.2);
  EXPECT_TRUE(std::isnan(inverted.P.norm()) && std::isnan(inverted.dP_dF.norm()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(update(law, elasticity, Mat3<double>::Constant(nan), n0, 1, 1).status, UpdateStatus::not_finite);
  EXPECT_EQ(update(law, elasticity, stretched, n0, nan, 1).status, UpdateStatus::not_finite);
  EXPECT_EQ(update(law, elasticity, stretched, n0, 1, nan).status, UpdateStatus::not_finite);
  EXPECT_EQ(update(law, elasticity, 1e200 * stretched, n0, 1, 1).status, UpdateStatus::not_finite);
}

}  // namespace
