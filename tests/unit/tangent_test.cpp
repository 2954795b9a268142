// Every tangent compared with derivatives of the discrete update: complex step, dual number, central
// difference.
#include <gtest/gtest.h>
#include <myogrowth/material.hpp>

#include "../support/dual.hpp"
#include "../support/larger.hpp"
#include "../support/moduli.hpp"
#include "../support/samples.hpp"

using namespace myogrowth;
using Complex = std::complex<double>;
using samples::Kind;
using samples::Point;

namespace {

template <class A, class B>
double error(const Eigen::MatrixBase<A>& expected, const Eigen::MatrixBase<B>& x) {
  return (x - expected).norm() / expected.norm();
}

Update<Complex> complex_update(const Point& p, const Mat3<Complex>& F) {
  State<Complex> state;
  state.G = p.state.G;
  state.lambda = p.state.lambda;
  state.n0 = p.state.n0.cast<Complex>();
  return update(p.muscle, F, state, p.dt);
}

/// F + i h dF.
Mat3<Complex> step(const Point& p, const Mat3<double>& dF, double h) {
  return p.F.cast<Complex>() + Complex(0, h) * dF.cast<Complex>();
}

/// The symmetric tensor that column `col` of an Abaqus tangent belongs to.
Mat3<double> unit_strain(int col) {
  Vec6<double> six = Vec6<double>::Zero();
  six[col] = col < 3 ? 1 : 0.5;
  return from_six(six);
}

struct Tangents {
  Mat6<double> ddsdde, dS_dE;
  Mat9<double> dP_dF;
  Mat3<double> P;  // dpsi/dF at fixed G
};

Tangents by_complex_step(const Point& p) {
  const double h = 1e-40;
  Tangents t;
  const double J = p.F.determinant();
  for (int col = 0; col < 6; ++col) {
    const Mat3<double> D = unit_strain(col);
    t.ddsdde.col(col) =
        to_six(Mat3<double>(complex_update(p, step(p, D * p.F, h)).kirchhoff().imag() / (h * J)));
    const Mat3<double> dF = p.F.transpose().inverse() * D;
    t.dS_dE.col(col) = to_six(Mat3<double>(complex_update(p, step(p, dF, h)).second_piola().imag() / h));
  }
  for (int col = 0; col < 9; ++col) {
    Mat3<double> dF = Mat3<double>::Zero();
    dF(col) = 1;
    const Mat3<double> dP = complex_update(p, step(p, dF, h)).first_piola().imag() / h;
    for (int row = 0; row < 9; ++row) t.dP_dF(row, col) = dP(row);
  }
  return t;
}

class Tangent : public testing::TestWithParam<std::tuple<Kind, EnergyPer>> {};

TEST_P(Tangent, IsTheComplexStepOfTheDiscreteUpdate) {
  const auto [kind, energy] = GetParam();
  samples::Random r(21);
  double worst = 0, largest_unsymmetry = 0;
  for (int i = 0; i < 300; ++i) {
    Point p = samples::point(r, kind);
    p.muscle.energy = energy;
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    const Tangents t = by_complex_step(p);
    worst =
        std::max({worst, error(t.ddsdde, u.ddsdde()), error(t.dP_dF, u.dP_dF()), error(t.dS_dE, u.dS_dE())});
    largest_unsymmetry = larger(largest_unsymmetry, error(u.ddsdde(), u.ddsdde().transpose()));
  }
  EXPECT_LE(worst, 1e-12);
  if (kind == Kind::growing) {
    EXPECT_GT(largest_unsymmetry, 0.05);  // the growth term was large enough to be tested
  }
}

TEST_P(Tangent, IsTheCentralDifferenceOfTheDiscreteUpdate) {
  const auto [kind, energy] = GetParam();
  samples::Random r(22);
  for (int i = 0; i < 100; ++i) {
    Point p = samples::point(r, kind, 10);
    p.muscle.energy = energy;
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    const double h = 2e-6;
    Mat6<double> difference;
    for (int col = 0; col < 6; ++col) {
      const Mat3<double> dF = h * unit_strain(col) * p.F;
      const Mat3<double> d = update(p.muscle, p.F + dF, p.state, p.dt).kirchhoff() -
                             update(p.muscle, p.F - dF, p.state, p.dt).kirchhoff();
      difference.col(col) = to_six(Mat3<double>(d / (2 * h * u.point.J)));
    }
    EXPECT_LE(error(difference, u.ddsdde()), 2e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Tangent,
                         testing::Combine(testing::Values(Kind::growing, Kind::below_threshold,
                                                          Kind::saturated, Kind::elastic_step, Kind::any),
                                          testing::Values(EnergyPer::reference_volume,
                                                          EnergyPer::grown_volume)));

// The options that change G: removal, and the second-order step from its own start stretch.
TEST(Tangent, OfRemovalAndOfTheMidpointFlow) {
  samples::Random r(27);
  double worst = 0;
  int grew = 0, shrank = 0;
  for (int i = 0; i < 300; ++i) {
    Point p = samples::point(r, Kind::growing, 100);
    const double lambda = update(p.muscle, p.F, p.state, 0).point.lambda;
    p.muscle.integration = i % 3 == 0 ? TimeIntegration::backward_euler : TimeIntegration::midpoint_flow;
    p.state.lambda = lambda * r.uniform(0.9, 1.1);
    if (i % 2 == 0) {  // the thresholds above, so that it shrinks
      p.muscle.growth.lambda_crit = 3 * lambda;
      p.muscle.removal = {r.uniform(0.1, 3), r.uniform(0.5, 4), r.uniform(0.1, 0.9),
                          lambda / p.state.G * r.uniform(1.2, 2)};
    }
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    ASSERT_TRUE(u.ok());
    grew += u.state.G > p.state.G;
    shrank += u.state.G < p.state.G;
    const Tangents t = by_complex_step(p);
    worst =
        std::max({worst, error(t.ddsdde, u.ddsdde()), error(t.dP_dF, u.dP_dF()), error(t.dS_dE, u.dS_dE())});
    // and by differences, which do not depend on how the derivative of G is computed
    const double h = 2e-6;
    for (int col = 0; col < 6; ++col) {
      const Mat3<double> dF = h * unit_strain(col) * p.F;
      const Mat3<double> d = update(p.muscle, p.F + dF, p.state, p.dt).kirchhoff() -
                             update(p.muscle, p.F - dF, p.state, p.dt).kirchhoff();
      EXPECT_LE((to_six(Mat3<double>(d / (2 * h))) - u.jaumann_modulus().col(col)).norm(),
                1e-6 * u.jaumann_modulus().norm())
          << i;
    }
  }
  EXPECT_LE(worst, 1e-12);
  EXPECT_GT(grew, 100);
  EXPECT_GT(shrank, 100);
}

// At the threshold the update is not differentiable: the tangent is the derivative from below, without
// growth.
TEST(Tangent, AtTheThresholdIsTheOneWithoutGrowth) {
  samples::Random r(23);
  for (int i = 0; i < 100; ++i) {
    Point p = samples::point(r, Kind::growing);
    p.state.G = 1;
    p.muscle.growth.lambda_crit = update(p.muscle, p.F, p.state, 0).point.lambda;
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    EXPECT_EQ(u.state.G, 1);
    EXPECT_EQ(u.ddsdde(), update(p.muscle, p.F, p.state, 0).ddsdde());
    // One-sided differences: along a shortening the tangent above, along a lengthening a growing one.
    const Mat3<double> f = p.F * p.state.n0.normalized() * (p.F * p.state.n0.normalized()).transpose();
    const Mat3<double> D = f / f.norm();
    Vec6<double> engineering = to_six(D);
    engineering.tail<3>() *= 2;
    const double h = 1e-7;
    const Vec6<double> down = to_six(
        Mat3<double>((u.kirchhoff() - update(p.muscle, p.F - h * D * p.F, p.state, p.dt).kirchhoff()) / h));
    EXPECT_LE(error(down, u.jaumann_modulus() * engineering), 1e-5);
    const auto up = update(p.muscle, p.F + h * D * p.F, p.state, p.dt);
    EXPECT_GT(up.state.G, 1);
  }
}

TEST(Tangent, DualNumbersGiveTheSameColumns) {
  using dual::Dual;
  samples::Random r(24);
  for (int i = 0; i < 50; ++i) {
    const Point p = samples::point(r, Kind::growing);
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    for (int col = 0; col < 6; ++col) {
      const Mat3<double> dF = unit_strain(col) * p.F;
      Mat3<Dual> F;
      State<Dual> state;
      state.G = p.state.G;
      for (int k = 0; k < 9; ++k) F(k) = Dual(p.F(k), dF(k));
      for (int k = 0; k < 3; ++k) state.n0[k] = p.state.n0[k];
      const Mat3<Dual> tau = update(p.muscle, F, state, p.dt).kirchhoff();
      for (int row = 0; row < 6; ++row) {
        EXPECT_NEAR(tau(symmetric_row(row), symmetric_column(row)).d, u.jaumann_modulus()(row, col),
                    1e-12 * u.jaumann_modulus().norm());
      }
    }
  }
}

// P = dpsi/dF at fixed G, in both conventions: psi is per unit reference volume.
TEST(Tangent, StressIsTheGradientOfTheEnergy) {
  samples::Random r(25);
  for (int i = 0; i < 200; ++i) {
    Point p = samples::point(r, Kind::any);
    p.muscle.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
    p.dt = 0;
    const Mat3<double> P = update(p.muscle, p.F, p.state, 0).first_piola();
    for (int k = 0; k < 9; ++k) {
      Mat3<double> dF = Mat3<double>::Zero();
      dF(k) = 1;
      EXPECT_NEAR(complex_update(p, step(p, dF, 1e-40)).point.psi.imag() / 1e-40, P(k),
                  1e-12 * (1 + P.norm()));
    }
  }
}

// Back from each measure to the Kirchhoff stress and its Jaumann modulus, by other formulas.
TEST(Measures, RoundTrips) {
  samples::Random r(26);
  for (int i = 0; i < 200; ++i) {
    const Point p = samples::point(r, Kind::any);
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    const Mat3<double> F = u.F, tau = u.kirchhoff();
    const Mat6<double> c = u.jaumann_modulus();
    EXPECT_LE(error(tau, u.point.J * u.cauchy()), 1e-15);
    EXPECT_LE(error(c, u.point.J * u.ddsdde()), 1e-15);

    EXPECT_LE(error(tau, u.first_piola() * F.transpose()), 1e-11);
    // c_ijkm = sym_km [F_jJ dP_iJ/dF_kL F_mL + tau_im delta_jk]
    const Mat9<double> dP_dF = u.dP_dF();
    const auto spatial = [&](int row, int j, int k, int m) {
      double sum = j == k ? tau(row, m) : 0;
      for (int J = 0; J < 3; ++J) {
        for (int L = 0; L < 3; ++L) sum += F(j, J) * dP_dF(row + 3 * J, k + 3 * L) * F(m, L);
      }
      return sum;
    };
    Mat6<double> c_back;
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b < 6; ++b) {
        const int row = symmetric_row(a), j = symmetric_column(a), k = symmetric_row(b),
                  m = symmetric_column(b);
        c_back(a, b) = (spatial(row, j, k, m) + spatial(row, j, m, k)) / 2;
      }
    }
    EXPECT_LE(error(c, c_back), 1e-11);

    EXPECT_LE(error(tau, F * u.second_piola() * F.transpose()), 1e-11);
    // (F goes in four times there and four times back: rounding grows with its condition number to the
    // fourth.)
    const double condition = F.norm() * F.inverse().norm() / 3;
    EXPECT_LE(error(c, moduli::jaumann_from_dS_dE(F, tau, u.dS_dE())),
              16 * std::numeric_limits<double>::epsilon() * std::pow(condition, 4));

    EXPECT_LE(error(u.first_piola(), F * u.second_piola()), 1e-11);
    EXPECT_LE((u.first_piola() * F.transpose() - F * u.first_piola().transpose()).norm(), 1e-12 * tau.norm());
  }
}

}  // namespace
