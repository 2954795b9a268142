// The laws beside the paper's, sensed_stretch.hpp and cross_fibre_growth.hpp: their roots, bounds and
// tangents.
#include <gtest/gtest.h>

#include <myogrowth/material.hpp>
#include <myogrowth/more/cross_fibre_growth.hpp>
#include <myogrowth/more/sensed_stretch.hpp>

#include "../support/samples.hpp"

using namespace myogrowth;
using Complex = std::complex<double>;

namespace {

SensedStretch<> random_law(samples::Random& r) {
  const double gammas[] = {0, 0.3, 1, 2, 5.7};
  const auto some = [&](double least, double most) {
    return r.uniform(0, 1) < 0.3 ? 0.0 : r.log_uniform(least, most);
  };
  const double crit = r.uniform(0.95, 1.1);
  return {{r.log_uniform(0.01, 10), r.pick(gammas), r.uniform(1.1, 3), crit},
          {some(0.01, 10), r.pick(gammas), r.uniform(0.2, 0.8), crit - some(1e-3, 0.1)},
          some(1e-3, 10),
          some(1e-3, 10),
          some(0.1, 10)};
}

TEST(SensedStretch, WithoutTimeConstantsItIsThePapersLaw) {
  samples::Random r(31);
  for (int i = 0; i < 2000; ++i) {
    SensedStretch<> law = random_law(r);
    law.tau_rise = law.tau_fall = law.per_x_half = 0;
    const double G_n = r.uniform(0.85, 1.08), lambda = r.uniform(0.6, 1.7), dt = r.log_uniform(1e-6, 1e6);
    const auto expected = solve_growth(law.growth, law.removal, G_n, lambda, dt);
    const auto step = solve_growth(law, SensedState<>{G_n, 1}, lambda, dt);
    EXPECT_NEAR(step.state.G, expected.G, 4e-15 * expected.G) << i;
    EXPECT_NEAR(step.dG_dlambda, expected.dG_dlambda, 1e-6 + 1e-6 * expected.dG_dlambda) << i;
    EXPECT_NEAR(step.state.sensed, lambda / step.state.G, 1e-15);
  }
}

// The equation of the step as the header writes it, without a word of its code.
long double residual(const SensedStretch<>& law, const SensedState<>& before, long double G,
                     long double lambda, double dt) {
  const long double lambda_e = lambda / G, time = lambda_e > before.sensed ? law.tau_rise : law.tau_fall;
  const long double s = lambda_e + (time > 0 ? std::exp(-dt / time) : 0) * (before.sensed - lambda_e);
  const auto f = [&](long double x) { return x > 0 ? x / (1 + law.per_x_half * x) : 0; };
  const GrowthRate<>& a = law.growth;
  const RemovalRate<>& b = law.removal;
  const long double up =
                        std::pow(std::max((a.G_max - G) / (a.G_max - 1), 0.0L), (long double)a.gamma) / a.tau,
                    down = std::pow(std::max((G - b.G_min) / (a.G_max - b.G_min), 0.0L),
                                    (long double)b.gamma_rev);
  const long double removed = b.tau_rev > 0 ? down / b.tau_rev * f(b.lambda_crit_rev - s) : 0;
  return G - before.G - dt * (up * f(s - a.lambda_crit) - removed);
}

TEST(SensedStretch, OneRootInTheBracketForAnyStep) {
  samples::Random r(32);
  int grew = 0, shrank = 0, most = 0;
  for (int i = 0; i < 20000; ++i) {
    const SensedStretch<> law = random_law(r);
    const SensedState<> before{r.uniform(0.85, 1.08), r.uniform(0.6, 1.6)};
    const double lambda = r.uniform(0.4, 2.5), dt = r.log_uniform(1e-9, 1e9);
    const auto step = solve_growth(law, before, lambda, dt);
    const double G = step.state.G, width = 1e-14;
    most = std::max(most, step.iterations);
    grew += G > before.G;
    shrank += G < before.G;
    ASSERT_TRUE(law.removal.G_min <= G && G <= law.growth.G_max) << i;
    ASSERT_TRUE(step.dG_dlambda >= 0 && std::isfinite(step.dG_dlambda)) << i;
    // The residual rises with G, so it changes its sign here and nowhere else.
    if (G < law.growth.G_max * (1 - width)) {
      ASSERT_GE(residual(law, before, G * (1 + width), lambda, dt), 0) << i;
    }
    if (G > law.removal.G_min * (1 + width)) {
      ASSERT_LE(residual(law, before, G * (1 - width), lambda, dt), 0) << i;
    }
  }
  EXPECT_GT(grew, 5000);
  EXPECT_GT(shrank, 2000);
  EXPECT_LE(most, 164);
}

TEST(SensedStretch, BracketsAsWideAsNumbersReach) {
  for (double G_max : {1e3, 1e60, 1e300}) {
    for (double dt : {1e-3, 1e3, 1e100, 1e300}) {
      const SensedStretch<> law{{0.5, 2, G_max, 1.01}, {}, 0.1, 0.5, 0};
      const double lambda = 1e150;
      const auto step = solve_growth(law, SensedState<>{1, 1}, lambda, dt);
      const double G = step.state.G;
      ASSERT_TRUE(1 <= G && G <= G_max) << G_max << " " << dt;
      ASSERT_TRUE(std::isfinite(step.dG_dlambda)) << G_max << " " << dt;
      EXPECT_LE(residual(law, {1, 1}, G * (1 - 1e-14L), lambda, dt), 0) << G_max << " " << dt;
      if (G < G_max) {
        EXPECT_GE(residual(law, {1, 1}, G * (1 + 1e-14L), lambda, dt), 0) << G_max << " " << dt;
      }
    }
  }
}

TEST(SensedStretch, TheTangentIsThatOfTheStep) {
  samples::Random r(33);
  const double h = 1e-6;
  int moved = 0;
  for (int i = 0; i < 300; ++i) {
    SensedStretch<> law = random_law(r);
    const double dt = r.log_uniform(1e-2, 10);
    const FibreGrowth<> muscle;
    const samples::Point p = samples::point(r, samples::Kind::growing);
    const SensedState<> before{1, r.uniform(0.9, 1.2)};
    const double factor = r.uniform(0.85, 1.2);
    const auto run = [&](auto F, const auto& state) {
      using T = typename decltype(F)::Scalar;
      const Vec3<T> n0 = p.state.n0.template cast<T>();
      Update<T> u;
      SensedState<T> after;
      u.F = F;
      EXPECT_EQ(update_sensed(law, muscle, u.F.data(), n0.data(), state, dt, u.point, after),
                UpdateStatus::ok);
      return std::make_pair(u, after);
    };
    const Mat3<double> F = factor * p.F;
    const auto [u, after] = run(F, before);
    moved += u.point.dG_dlambda > 0;
    const Mat9<double> exact = u.dP_dF();
    const SensedState<Complex> before_c{Complex(before.G), Complex(before.sensed)};
    for (int k = 0; k < 9; ++k) {
      Mat3<Complex> F_c = F.cast<Complex>();
      F_c.data()[k] += Complex(0, 1e-30);
      const auto by_complex_step = run(F_c, before_c);
      Mat3<double> plus = F, minus = F;
      plus.data()[k] += h;
      minus.data()[k] -= h;
      const auto a = run(plus, before), b = run(minus, before);
      const Mat3<Complex> P = by_complex_step.first.first_piola();
      const Mat3<double> P_a = a.first.first_piola(), P_b = b.first.first_piola();
      const double scale = exact.cwiseAbs().maxCoeff();
      for (int j = 0; j < 9; ++j) {
        EXPECT_NEAR(P.data()[j].imag() / 1e-30, exact(j, k), 1e-12 * scale) << i;
        // (No derivative at a threshold: where one lies between the two, the differences are not equal.)
        const double forward = P_a.data()[j] - u.first_piola().data()[j];
        const double backward = u.first_piola().data()[j] - P_b.data()[j];
        if (std::abs(forward - backward) < 1e-9 * scale) {
          EXPECT_NEAR((forward + backward) / (2 * h), exact(j, k), 1e-6 * scale) << i;
        }
      }
      EXPECT_NEAR(by_complex_step.second.sensed.imag() / 1e-30, (a.second.sensed - b.second.sensed) / (2 * h),
                  1e-4)
          << i;
    }
  }
  EXPECT_GT(moved, 100);
}

TEST(SensedStretch, ItRemembersAndForgetsExponentially) {
  const SensedStretch<> law{{0.5, 2, 1.1, 2}, {}, 0.3, 0.7, 0};  // the threshold is out of reach
  SensedState<> now;
  for (int i = 0; i < 10; ++i) now = solve_growth(law, now, 1.2, 0.1).state;
  EXPECT_NEAR(now.sensed, 1.2 - 0.2 * std::exp(-1 / 0.3), 1e-14);
  const double high = now.sensed;
  for (int i = 0; i < 10; ++i) now = solve_growth(law, now, 0.9, 0.2).state;
  EXPECT_NEAR(now.sensed, 0.9 + (high - 0.9) * std::exp(-2 / 0.7), 1e-14);
  EXPECT_EQ(now.G, 1);
  EXPECT_EQ(solve_growth(law, now, 1.5, 0.0).state.sensed, now.sensed);
}

TEST(SensedStretch, NoResultLeavesTheStateAsItIs) {
  const FibreGrowth<> muscle;
  const SensedStretch<> law;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Mat3<double> good = 1.2 * Mat3<double>::Identity(), inverted = -good;
  const Vec3<double> n0 = Vec3<double>::UnitX();
  PointUpdate<double> u;
  SensedState<> after;
  const auto with = [&](const Mat3<double>& F, SensedState<> before, double dt) {
    const auto status = update_sensed(law, muscle, F.data(), n0.data(), before, dt, u, after);
    EXPECT_EQ(after.G, before.G);
    EXPECT_TRUE(std::isnan(u.tau[0]));
    return status;
  };
  EXPECT_EQ(with(inverted, {1, 1}, 1), UpdateStatus::inverted);
  EXPECT_EQ(with(good, {1, nan}, 1), UpdateStatus::not_finite);
  EXPECT_EQ(with(good, {-1, 1}, 1), UpdateStatus::bad_state);
  EXPECT_EQ(with(good, {1, 1}, nan), UpdateStatus::not_finite);
  EXPECT_EQ(with(good, {1, 1}, std::numeric_limits<double>::infinity()), UpdateStatus::not_finite);
}

// The step of CrossFibreGrowth in the closed form of docs/theory.md: nothing of the law's code.
template <class T>
struct ClosedForm {
  double c1, c2, tau, gamma, most, crit, g_n, dt;
  T J, lambda, Ftn;  // Ftn: |F^T n|^2
  T tension(const T& g) const {
    return c1 * log(T(J / g)) + c2 * (lambda * lambda - 1. + (Ftn - lambda * lambda) / g);
  }
  T residual(const T& g) const {
    return g - g_n - dt / tau * pow(T((most - g) / (most - 1)), gamma) * (tension(g) / crit - 1.);
  }
};
template <class T>
ClosedForm<T> closed_form(const CrossFibreGrowth& law, const Mat3<T>& F, const Vec3<double>& n0, double g_n,
                          double dt) {
  const Vec3<T> f = F * n0.cast<T>();
  const T square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
  const Vec3<T> back = F.transpose() * f;
  const T along = (back[0] * back[0] + back[1] * back[1] + back[2] * back[2]) / square;
  return {law.muscle.c1,
          law.muscle.c2,
          law.capacity.tau,
          law.capacity.gamma,
          law.capacity.G_max,
          law.tension_crit,
          g_n,
          dt,
          T(F.determinant()),
          T(sqrt(square)),
          along};
}

TEST(CrossFibreGrowth, OneRootAndTheTangentOfTheClosedForm) {
  samples::Random r(34);
  int grew = 0;
  for (int i = 0; i < 300; ++i) {
    const samples::Point p = samples::point(r, samples::Kind::growing);
    CrossFibreGrowth law;
    law.tension_crit = r.uniform(0.2, 2);
    const Vec3<double> n0 = p.state.n0.normalized();
    const double g_n = r.uniform(1, 1.3), dt = r.log_uniform(1e-2, 1e4);
    const LawUpdate u = update(law, NeoHookean<>(), p.F, n0, g_n, dt);
    ASSERT_TRUE(u.ok());
    const auto exact = closed_form<double>(law, p.F, n0, g_n, dt);
    double last = exact.tension(g_n);
    for (int k = 1; k <= 20; ++k) {  // it falls with g, so that the root is the only one
      const double next = exact.tension(g_n + 0.02 * k);
      EXPECT_LT(next, last);
      last = next;
    }
    if (!(exact.tension(g_n) > law.tension_crit)) {
      EXPECT_EQ(u.g, g_n);
      continue;
    }
    ++grew;
    double low = g_n, high = law.limit();
    for (int k = 0; k < 100; ++k) {
      const double middle = (low + high) / 2;
      (exact.residual(middle) < 0 ? low : high) = middle;
    }
    ASSERT_NEAR(u.g, low, 1e-13) << i;
    ASSERT_GT(exact.tension(u.g), law.tension_crit * (1 - 1e-9));  // it does not overshoot the equilibrium
    const double h = 1e-30, width = 1e-7;
    const double slope = (exact.residual(low + width) - exact.residual(low - width)) / (2 * width);
    for (int k = 0; k < 9; ++k) {
      Mat3<Complex> F = p.F.cast<Complex>();
      F.data()[k] += Complex(0, h);
      const double dR = closed_form<Complex>(law, F, n0, g_n, dt).residual(Complex(low)).imag() / h;
      EXPECT_NEAR(u.dg_dF.data()[k], -dR / slope, 1e-6 * (1 + std::abs(dR / slope))) << i;
    }
    for (int k = 0; k < 9; ++k) {
      Mat3<double> plus = p.F, minus = p.F;
      plus.data()[k] += 1e-6;
      minus.data()[k] -= 1e-6;
      const LawUpdate a = update(law, NeoHookean<>(), plus, n0, g_n, dt);
      const LawUpdate b = update(law, NeoHookean<>(), minus, n0, g_n, dt);
      for (int j = 0; j < 9; ++j)
        EXPECT_NEAR((a.P.data()[j] - b.P.data()[j]) / 2e-6, u.dP_dF(j, k), 1e-6 * u.dP_dF.norm()) << i;
    }
  }
  EXPECT_GT(grew, 100);
}

TEST(CrossFibreGrowth, UnderALoadThatStays) {
  const CrossFibreGrowth law;
  // Ten thousand explicit steps of dg/dt = k_g(g) (s/g - 1), of second order.
  double g = 1;
  const double s = 1.3, dt = 1e-2;
  const auto rate = [&](double x) { return law.capacity.adaptation(x) * (s / x - 1); };
  for (int i = 0; i < 10000; ++i) g += dt * rate(g + dt / 2 * rate(g));
  EXPECT_NEAR(law.at_constant_load(1, s, 100), g, 1e-8);
  EXPECT_EQ(law.at_constant_load(1, 0.9, 100), 1);
  EXPECT_NEAR(law.at_constant_load(1, 1.2, 1e9), 1.2, 1e-9);
  EXPECT_NEAR(law.at_constant_load(1, 9, 1e9), 1.5, 1e-3);
}

}  // namespace
