#include <gtest/gtest.h>
#include <myogrowth/growth_step.hpp>

#include "../support/dual.hpp"
#include "../support/larger.hpp"
#include "../support/reference.hpp"

using namespace myogrowth;
using Complex = std::complex<double>;

namespace {

const GrowthRate<> paper{0.5, 2, 1.1, 1.01};

TEST(GrowthSolve, ReferenceValuesOfOneStep) {
  const double dts[] = {0.01, 0.1, 0.5, 1, 5, 50};
  const double Gs[] = {1.00170307, 1.01194367, 1.02931485, 1.03807714, 1.05695050, 1.07559389};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(solve_growth(paper, 1.0, 1.1, dts[i]).G, Gs[i], 5e-9) << dts[i];
}

TEST(GrowthSolve, NothingGrows) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  struct {
    double G_n, lambda, dt;
  } const cases[] = {{1, 1.01, 1}, {1, 0.7, 1}, {1, 1.1, 0},   {1, 1.1, -1},  {1.1, 1.3, 1},
                     {1.2, 2, 1},  {1, nan, 1}, {1, 1.1, nan}, {1, 1.1, -inf}};
  for (const auto& c : cases) {
    const auto s = solve_growth(paper, c.G_n, c.lambda, c.dt);
    EXPECT_EQ(s.G, c.G_n);
    EXPECT_EQ(s.dG_dlambda, 0);
    EXPECT_EQ(s.iterations, 0);
  }
}

TEST(GrowthSolve, AnInfiniteStepReachesTheEndOfTheBracket) {
  const double inf = std::numeric_limits<double>::infinity();
  for (double gamma : {0.0, 0.5, 1.0, 2.0, 4.0}) {
    const GrowthRate<> rate{0.5, gamma, 1.1, 1.01};
    EXPECT_DOUBLE_EQ(solve_growth(rate, 1.0, 1.05, inf).G, 1.05 / 1.01);
    EXPECT_NEAR(solve_growth(rate, 1.0, 1.05, inf).dG_dlambda, 1 / 1.01, 1e-12);
    EXPECT_EQ(solve_growth(rate, 1.0, 1.5, inf).G, 1.1);
    EXPECT_EQ(solve_growth(rate, 1.0, 1.5, inf).dG_dlambda, 0);
  }
}

TEST(GrowthSolve, GammaZeroIsTheQuadraticAndClampsAtGMax) {
  const GrowthRate<> rate{0.5, 0, 1.1, 1.01};
  // G^2 + (a 1.01 - 1) G - a 1.05 = 0 with a = 0.2
  EXPECT_DOUBLE_EQ(solve_growth(rate, 1.0, 1.05, 0.1).G, (0.798 + std::sqrt(0.798 * 0.798 + 0.84)) / 2);
  EXPECT_EQ(solve_growth(rate, 1.0, 3.0, 10.0).G, 1.1);
}

// An ulp from G_max, where k times the room left is a subnormal number.
TEST(GrowthSolve, TheSlopeKeepsItsBoundWhereProductsUnderflow) {
  const GrowthRate<> rate{0.035049385583125786, 20, 1.0026536616013619, 0.54234186171403787};
  const auto s = solve_growth(rate, 0.50005791548685197, 0.54378105348727945, 7.3520319455916534e+271);
  EXPECT_EQ(s.G, 0.54378105348727945 / rate.lambda_crit);
  EXPECT_GE(s.dG_dlambda, 0);
  EXPECT_LE(s.dG_dlambda, 1 / rate.lambda_crit);
}

// The step's value and slope against bracketing in 50 digits, where it is hard: near G_max, near the
// threshold, near lambda = lambda_crit G_max, where both limits meet, and for steps of any length.
TEST(GrowthSolve, HardStepsAgainstFiftyDigits) {
  using reference::Real;
  samples::Random r(7);
  const double gammas[] = {0, 0.05, 0.5, 0.9, 1, 1.3, 1.5, 2, 2.5, 3, 4, 5};
  double worst_G = 0, worst_slope = 0;
  for (int i = 0; i < 1200; ++i) {
    const GrowthRate<> rate{0.5, r.pick(gammas), 1 + r.log_uniform(1e-3, 5), r.uniform(0.8, 1.2)};
    const double width = rate.G_max - 1;
    const double G_n = r.chance(0.5) ? 1 + width * r.uniform() : rate.G_max - width * r.log_uniform(1e-6, 1);
    const double lambda =
        r.chance(0.5) ? rate.lambda_crit * G_n * (1 + r.log_uniform(1e-6, 1))
                      : rate.lambda_crit * rate.G_max * (1 + r.uniform(-1, 1) * r.log_uniform(1e-8, 0.1));
    if (lambda <= rate.lambda_crit * G_n) continue;
    const double dt = 0.5 * r.log_uniform(1e-8, 1e8);
    const auto s = solve_growth(rate, G_n, lambda, dt);
    const Real h("1e-22"), exact = reference::grow(rate, G_n, lambda, dt);
    const Real slope =
        (reference::grow(rate, G_n, lambda + h, dt) - reference::grow(rate, G_n, lambda - h, dt)) / (2 * h);
    worst_G = larger(worst_G, std::abs(static_cast<double>(s.G / exact - 1)));
    if (dt <= 0.5e4 && (rate.gamma == 0 || rate.gamma >= 0.5)) {
      worst_slope = larger(worst_slope, std::abs(static_cast<double>(s.dG_dlambda - slope)));
    }
  }
  EXPECT_LE(worst_G, 2e-15);
  // Where both limits meet, the slope turns from 0 to 1/lambda_crit within a stretch so short that half a
  // unit in the last place of lambda moves it by 1e-10; elsewhere it is good to 1e-13 (see
  // accuracy_test.cpp).
  EXPECT_LE(worst_slope, 1e-9);
  std::printf("worst error: G %.1e, dG/dlambda %.1e\n", worst_G, worst_slope);
}

// The same for removal: near G_min, near its threshold, where both meet, steps of any length.
TEST(GrowthSolve, HardRemovalAgainstFiftyDigits) {
  using reference::Real;
  samples::Random r(8);
  const double gammas[] = {0, 0.05, 0.5, 0.9, 1, 1.3, 1.5, 2, 2.5, 3, 4, 5};
  double worst_G = 0, worst_slope = 0;
  int removed = 0;
  for (int i = 0; i < 1200; ++i) {
    const GrowthRate<> growth{0.5, 2, 1 + r.log_uniform(1e-2, 3), 1.2};
    const RemovalRate<> rate{0.5, r.pick(gammas), r.uniform(0.1, 0.95), r.uniform(0.8, 1.2)};
    const double width = growth.G_max - rate.G_min;
    const double G_n = rate.G_min + width * (r.chance(0.5) ? r.uniform() : r.log_uniform(1e-5, 1));
    const double lambda =
        r.chance(0.5) ? rate.lambda_crit_rev * G_n * (1 - r.log_uniform(1e-6, 0.9))
                      : rate.lambda_crit_rev * rate.G_min * (1 + r.uniform(-1, 1) * r.log_uniform(1e-6, 0.1));
    if (lambda >= rate.lambda_crit_rev * G_n) continue;
    const double dt = 0.5 * r.log_uniform(1e-8, 1e8);
    const auto s = solve_growth(growth, rate, G_n, lambda, dt);
    const Real h("1e-22"), exact = reference::shrink(growth, rate, G_n, lambda, dt);
    const Real slope = (reference::shrink(growth, rate, G_n, lambda + h, dt) -
                        reference::shrink(growth, rate, G_n, lambda - h, dt)) /
                       (2 * h);
    removed += s.G < G_n;
    worst_G = larger(worst_G, std::abs(static_cast<double>(s.G / exact - 1)));
    if (dt <= 0.5e4 && (rate.gamma_rev == 0 || rate.gamma_rev >= 0.5)) {
      worst_slope = larger(worst_slope, std::abs(static_cast<double>(s.dG_dlambda - slope)));
    }
  }
  EXPECT_GT(removed, 900);
  EXPECT_LE(worst_G, 4e-15);
  EXPECT_LE(worst_slope, 1e-8);
  std::printf("worst error: G %.1e, dG/dlambda %.1e\n", worst_G, worst_slope);
}

TEST(GrowthSolve, BetweenTheThresholdsNothingHappens) {
  const RemovalRate<> removal{0.5, 2, 0.8, 0.97};
  for (double lambda : {0.97, 0.99, 1.01}) EXPECT_EQ(solve_growth(paper, removal, 1.0, lambda, 10.0).G, 1);
  EXPECT_LT(solve_growth(paper, removal, 1.0, 0.9, 10.0).G, 1);
  EXPECT_GT(solve_growth(paper, removal, 1.0, 1.1, 10.0).G, 1);
  EXPECT_EQ(solve_growth(paper, removal, 1.0, 1.1, 10.0).G, solve_growth(paper, 1.0, 1.1, 10.0).G);
  EXPECT_EQ(solve_growth(paper, 1.0, 0.9, 10.0).G, 1);  // off by default
}

TEST(GrowthSolve, DerivativesWithRespectToEverything) {
  using dual::Dual;
  samples::Random r(11);
  for (int i = 0; i < 200; ++i) {
    // tau, gamma, G_max, lambda_crit, G_n, lambda, dt
    double q[7] = {r.uniform(0.2, 2),       r.uniform(0.3, 4),  r.uniform(1.05, 2),
                   r.uniform(0.9, 1.05),    r.uniform(1, 1.04), 0,
                   r.log_uniform(1e-3, 100)};
    q[5] = q[3] * q[4] * r.uniform(1.02, 1.5);
    for (int k = 0; k < 7; ++k) {
      Dual x[7];
      for (int j = 0; j < 7; ++j) x[j] = Dual(q[j], j == k ? 1 : 0);
      const Dual G = solve_growth(GrowthRate<Dual>{x[0], x[1], x[2], x[3]}, x[4], x[5], x[6]).G;
      const auto plain = [&](double sign) {
        long double y[7];
        for (int j = 0; j < 7; ++j) y[j] = q[j] + (j == k ? sign * 1e-6L : 0);
        return solve_growth(GrowthRate<long double>{y[0], y[1], y[2], y[3]}, y[4], y[5], y[6]).G;
      };
      EXPECT_NEAR(G.d, static_cast<double>((plain(1) - plain(-1)) / 2e-6L), 1e-8 * (1 + std::abs(G.d)))
          << i << ' ' << k;
    }
    const auto rate = GrowthRate<>{q[0], q[1], q[2], q[3]};
    const auto step = solve_growth(rate, q[4], q[5], q[6]);
    EXPECT_DOUBLE_EQ(solve_growth(rate, Complex(q[4]), Complex(q[5], 1e-30), q[6]).G.imag() / 1e-30,
                     step.dG_dlambda);
  }
}

TEST(GrowthSolve, DerivativesWhereTheLimitIsReachedToRounding) {
  // Here G is a few last places above G_min, and (G - G_min)/r is 0: 0^gamma_rev has no derivative.
  const double G_min[] = {0.64538092795390034, 0.23418644284554674, 0.76624236682727642};
  const double crit[] = {0.90172602081386588, 0.93801245847287118, 0.94930322462803651};
  const double G_n[] = {0.6453809279544328, 0.23418644284554732, 0.76624236682727742};
  for (int i = 0; i < 3; ++i) {
    for (double gamma_rev : {0.0, 1e-20, 0.5}) {
      for (int which = 0; which < 6; ++which) {
        const double h = 1e-30;
        const auto seeded = [&](double x, int k) { return Complex(x, k == which ? h : 0); };
        const GrowthRate<Complex> growth{0.5, 2, 1.5, 1.01};
        const RemovalRate<Complex> removal{seeded(0.02, 0), seeded(gamma_rev, 1), seeded(G_min[i], 2),
                                           seeded(crit[i], 3)};
        const auto step =
            solve_growth(growth, removal, seeded(G_n[i], 4), seeded(G_min[i] * crit[i], 5), Complex(200));
        EXPECT_TRUE(std::isfinite(step.G.real()) && std::isfinite(step.G.imag())) << i << " " << which;
        EXPECT_TRUE(std::isfinite(step.dG_dlambda.real())) << i << " " << which;
        const auto number =
            solve_growth(GrowthRate<>{0.5, 2, 1.5, 1.01}, RemovalRate<>{0.02, gamma_rev, G_min[i], crit[i]},
                         G_n[i], G_min[i] * crit[i], 200.0);
        EXPECT_EQ(step.G.real(), number.G);
      }
    }
  }
}

TEST(GrowthSolve, NoGammaTakesMoreThanABoundedNumberOfIterations) {
  samples::Random r(12);
  for (double gamma : {50.0, 100.0, 1e3, 1e6, 1e9, 1e15, 1e300}) {
    for (int i = 0; i < 300; ++i) {
      const GrowthRate<> rate{0.5, gamma, 1 + r.log_uniform(1e-6, 1e300), r.log_uniform(1e-3, 1e3)};
      const double lambda = rate.lambda_crit * r.log_uniform(1.0001, 1e10);
      const auto s = solve_growth(rate, 1.0, lambda, r.log_uniform(1e-12, 1e300));
      EXPECT_LE(s.iterations, 160);
      EXPECT_TRUE(s.G >= 1 && s.G <= std::min(rate.G_max, lambda / rate.lambda_crit));
      EXPECT_TRUE(std::isfinite(s.dG_dlambda));
    }
  }
}

TEST(GrowthSolve, SinglePrecision) {
  const GrowthRate<float> rate{0.5f, 2.f, 1.1f, 1.01f};
  EXPECT_NEAR(solve_growth(rate, 1.f, 1.1f, 0.5f).G, 1.02931485f, 2e-7f);
}

}  // namespace
