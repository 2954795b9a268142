#include <gtest/gtest.h>

#include <cfenv>
#include <myogrowth/growth_flow.hpp>

#include "../support/larger.hpp"
#include "../support/samples.hpp"

using namespace myogrowth;
using Complex = std::complex<double>;

namespace {

const GrowthRate<> paper{0.5, 2, 1.1, 1.01};
const RemovalRate<> off;

/// The flow in long double by the classical Runge-Kutta method, in steps far below its error.
long double runge_kutta(const GrowthRate<>& p, const RemovalRate<>& down, long double G, long double lambda,
                        long double dt, int n = 20000) {
  const GrowthRate<long double> up{p.tau, p.gamma, p.G_max, p.lambda_crit};
  const auto rate = [&](long double g) -> long double {
    if (lambda > up.lambda_crit * g) return up.rate(g, lambda);
    if (down.tau_rev == 0 || lambda >= down.lambda_crit_rev * g || g <= down.G_min) return 0;
    const long double x = (g - down.G_min) / (up.G_max - down.G_min);
    return std::pow(x, static_cast<long double>(down.gamma_rev)) / down.tau_rev *
           (lambda / g - down.lambda_crit_rev);
  };
  const long double h = dt / n;
  for (int i = 0; i < n; ++i) {
    const long double a = rate(G), b = rate(G + h / 2 * a), c = rate(G + h / 2 * b), d = rate(G + h * c);
    G += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return G;
}

TEST(GrowthFlow, ReferenceValuesOfHeldStretch) {
  const double t_per_tau[] = {0.5, 1, 2, 5, 12, 28, 84};
  const double G[] = {1.026779, 1.038940, 1.051339, 1.065455, 1.075383, 1.081909, 1.086864};
  for (int i = 0; i < 7; ++i)
    EXPECT_NEAR(flow_growth(paper, off, 1.0, 1.1, t_per_tau[i] * 0.5).G, G[i], 6e-7);
}

TEST(GrowthFlow, IsTheFlow) {
  samples::Random r(71);
  double worst = 0;
  int compared = 0;
  for (int i = 0; i < 150; ++i) {
    const double gammas[] = {0, 0.5, 1, 1.7, 2, 2.5, 3, 4, 6};
    const GrowthRate<> up{0.5, r.pick(gammas), 1 + r.log_uniform(0.02, 2), 1.01};
    const RemovalRate<> down{0.7, r.pick(gammas), r.uniform(0.2, 0.9), r.uniform(0.8, 1.01)};
    const double G = r.uniform(0.95, 1) * up.G_max, lambda = G * r.uniform(0.6, 1.5),
                 dt = 0.5 * r.log_uniform(1e-4, 1);
    const auto s = flow_growth(up, down, G, lambda, dt);
    // With gamma < 1 it gets to the end in a finite time, near which Runge-Kutta loses its order.
    if (up.G_max - s.G < 1e-2 || s.G - down.G_min < 1e-2) continue;
    ++compared;
    worst = larger(worst, std::abs(static_cast<double>(s.G - runge_kutta(up, down, G, lambda, dt))));
  }
  EXPECT_LE(worst, 1e-13);
  EXPECT_GT(compared, 60);
  std::printf("worst difference to Runge-Kutta: %.1e\n", worst);
}

// A group: two steps are one of the sum, to rounding, for any length.
TEST(GrowthFlow, TwoStepsAreOne) {
  samples::Random r(72);
  for (int i = 0; i < 2000; ++i) {
    const GrowthRate<> up{0.5, r.uniform(0, 5), 1 + r.log_uniform(0.01, 5), r.uniform(0.9, 1.1)};
    const RemovalRate<> down{0.5, r.uniform(0, 5), r.uniform(0.1, 0.9), r.uniform(0.7, 0.9)};
    const double G = r.uniform(0.9, 1.1), lambda = r.uniform(0.3, 1.6);
    const double dt1 = r.log_uniform(1e-6, 1e4), dt2 = r.log_uniform(1e-6, 1e4);
    const auto one = flow_growth(up, down, G, lambda, dt1);
    const auto two = flow_growth(up, down, one.G, lambda, dt2),
               both = flow_growth(up, down, G, lambda, dt1 + dt2);
    EXPECT_NEAR(two.G, both.G, 2e-14 * both.G);
  }
}

TEST(GrowthFlow, AGrowthNumberBeyondAllNumbersEndsTheWay) {
  const RemovalRate<> none;
  GrowthRate<> thin{0.5, 150, 1.00003, 1.01};  // k_g(0.76) is 8,000^150
  EXPECT_EQ(flow_growth(thin, none, 0.76, 2.0, 1e-8).G, thin.G_max);
  EXPECT_EQ(flow_growth(thin, none, 0.76, 2.0, 1e-8).dG_dlambda, 0);
  EXPECT_DOUBLE_EQ(flow_growth(thin, none, 0.76, 0.9, 1e-8).G, 0.9 / thin.lambda_crit);
  EXPECT_DOUBLE_EQ(flow_growth(thin, none, 0.76, 0.9, 1e-8).dG_dlambda, 1 / thin.lambda_crit);
  const double forever = std::numeric_limits<double>::infinity();
  EXPECT_EQ(flow_growth(GrowthRate<>(), none, 1.0, 2.0, forever).G, GrowthRate<>().G_max);
}

// Where the limits meet to rounding, lambda - lambda_crit G_max may come out below zero: the way must still
// end, in panels that are few, and without an overflow.
TEST(GrowthFlow, EndsWhereTheLimitsMeetToRounding) {
  samples::Random r(74);
  int below = 0;
  for (int i = 0; i < 20000; ++i) {
    GrowthRate<> up{r.log_uniform(0.01, 10), r.uniform(0, 0.5), 1 + r.log_uniform(1e-3, 2),
                    r.uniform(0.9, 1.1)};
    const double lambda = up.lambda_crit * up.G_max * (1 + (r.uniform() - 0.5) * 4e-16);
    if (up.G_max > lambda / up.lambda_crit || lambda >= up.lambda_crit * up.G_max) continue;
    ++below;
    std::feclearexcept(FE_ALL_EXCEPT);
    const auto s = flow_growth(up, RemovalRate<>(), 1.0, lambda, 1e15);
    EXPECT_FALSE(std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW));
    EXPECT_LE(s.iterations, 260) << i;
    EXPECT_NEAR(s.G, up.G_max, 1e-8);
  }
  EXPECT_GT(below, 100);
}

TEST(GrowthFlow, SlopeAndBounds) {
  samples::Random r(73);
  for (int i = 0; i < 3000; ++i) {
    const GrowthRate<> up{0.5, r.uniform(0, 5), 1 + r.log_uniform(0.01, 5), r.uniform(0.9, 1.1)};
    const RemovalRate<> down{r.chance(0.5) ? 0.5 : 0, r.uniform(0, 5), r.uniform(0.1, 0.9),
                             r.uniform(0.7, 0.9)};
    const double G = r.uniform(0.9, 1.1), lambda = r.uniform(0.3, 1.6);
    const double dt = i % 3 == 0 ? r.log_uniform(1e-12, 1e300) : r.log_uniform(1e-4, 1e2);
    const auto s = flow_growth(up, down, G, lambda, dt);
    const double upper = std::max(G, std::min(up.G_max, lambda / up.lambda_crit));
    const double lower = std::min(G, std::max(down.G_min, lambda / down.lambda_crit_rev));
    ASSERT_TRUE(s.G >= lower && s.G <= upper);
    ASSERT_TRUE(s.dG_dlambda >= 0 && std::isfinite(s.dG_dlambda));
    EXPECT_LE(s.iterations, 260);
    if (s.G == up.G_max || s.G == down.G_min || dt > 1e2) continue;
    const double h = 1e-6;
    const double difference =
        (flow_growth(up, down, G, lambda + h, dt).G - flow_growth(up, down, G, lambda - h, dt).G) / (2 * h);
    const bool kink = std::abs(lambda - up.lambda_crit * G) < 2 * h ||
                      std::abs(lambda - down.lambda_crit_rev * G) < 2 * h ||
                      std::abs(lambda - up.lambda_crit * up.G_max) < 1e-3 ||
                      std::abs(lambda - down.lambda_crit_rev * down.G_min) < 1e-3;
    if (!kink && up.G_max - s.G > 1e-4 && s.G - down.G_min > 1e-4) {
      EXPECT_NEAR(s.dG_dlambda, difference, 2e-7) << i;
    }
    EXPECT_DOUBLE_EQ(flow_growth(up, down, Complex(G), Complex(lambda, 1e-30), dt).G.imag() / 1e-30,
                     s.dG_dlambda);
  }
}

}  // namespace
