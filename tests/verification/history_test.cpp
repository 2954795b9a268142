// Six weeks of the paper's muscle compared with the exact solution of eq. 4: values, bounds and order of
// convergence.
#include <gtest/gtest.h>

#include <boost/math/tools/roots.hpp>
#include <functional>
#include <myogrowth/material.hpp>

#include "../support/larger.hpp"

using namespace myogrowth;

namespace {

const GrowthRate<> paper{0.5, 2, 1.1, 1.01};

/// G(t) for a stretch held from t = 0, from the closed form of t(G) for gamma = 2 (docs/theory.md).
double exact_held(const GrowthRate<>& r, double lambda, double t, double G_0 = 1) {
  const double b = lambda - r.lambda_crit * r.G_max;
  const auto time = [&](double G) {
    const auto primitive = [&](double g) {
      return lambda / (b * b) * std::log(r.G_max - g) + r.G_max / b / (r.G_max - g) -
             lambda / (b * b) * std::log(std::abs(lambda - r.lambda_crit * g));
    };
    return (r.G_max - 1) * (r.G_max - 1) * (primitive(G) - primitive(G_0)) * r.tau;
  };
  const double end = std::min(r.G_max, lambda / r.lambda_crit);
  std::uintmax_t most = 200;
  const auto bracket =
      boost::math::tools::toms748_solve([&](double G) { return time(G) - t; }, G_0, end - 1e-12,
                                        boost::math::tools::eps_tolerance<double>(50), most);
  return (bracket.first + bracket.second) / 2;
}

/// G(t) under any smooth stretch history from t_0, by the classical Runge-Kutta method with very short steps.
double exact_flow(const GrowthRate<>& r, const std::function<double(double)>& stretch, double t_0, double t_1,
                  double G) {
  const int n = 20000;
  const double h = (t_1 - t_0) / n;
  for (int i = 0; i < n; ++i) {
    const double t = t_0 + i * h;
    const auto rate = [&](double time, double g) { return r.rate(g, stretch(time)); };
    const double k1 = rate(t, G), k2 = rate(t + h / 2, G + h / 2 * k1), k3 = rate(t + h / 2, G + h / 2 * k2);
    G += h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(t + h, G + h * k3));
  }
  return G;
}

/// The library's G at time `end` in n steps under a stretch history.
double stepped(const GrowthRate<>& rate, const std::function<double(double)>& stretch, double end, int n,
               TimeIntegration how = TimeIntegration::backward_euler) {
  FibreGrowth<> muscle;
  muscle.growth = rate;
  muscle.integration = how;
  State<> state;
  state.lambda = stretch(0);
  for (int i = 1; i <= n; ++i) {
    Mat3<double> F = Mat3<double>::Identity();
    F(0, 0) = stretch(end * i / n);
    const auto u = update(muscle, F, state, end / n);
    EXPECT_TRUE(u.ok());
    state = u.state;
  }
  return state.G;
}

const auto held = [](double) { return 1.1; };
const auto ramped = [](double t) { return t < 1 ? 1 + 0.1 * t : 1.1; };  // over one day, tau = 0.5 day

TEST(History, ExactSolutionsAgreeWithEachOther) {
  for (double t : {0.25, 1.0, 14.0, 42.0}) {
    EXPECT_NEAR(exact_held(paper, 1.1, t), exact_flow(paper, held, 0, t, 1), 2e-12) << t;
  }
}

TEST(History, HeldStretchReferenceValues) {
  const double t_per_tau[] = {0.5, 1, 2, 5, 12, 28, 84};
  const double G[] = {1.026779, 1.038940, 1.051339, 1.065455, 1.075383, 1.081909, 1.086864};
  double worst = 0;
  for (int i = 0; i < 7; ++i) {
    const double t = t_per_tau[i] * 0.5;
    EXPECT_NEAR(exact_held(paper, 1.1, t), G[i], 6e-7);
    // Two Richardson steps on backward Euler.
    const int n = 2000;
    const double a = stepped(paper, held, t, n), b = stepped(paper, held, t, 2 * n),
                 c = stepped(paper, held, t, 4 * n);
    const double ab = 2 * b - a, bc = 2 * c - b;
    EXPECT_NEAR((4 * bc - ab) / 3, exact_held(paper, 1.1, t), 1e-8);
    EXPECT_NEAR((4 * bc - ab) / 3, G[i], 1e-6);
    worst = larger(worst, std::abs((4 * bc - ab) / 3 - exact_held(paper, 1.1, t)));
  }
  std::printf("extrapolated G off by %.1e at most\n", worst);
}

TEST(History, RampThenHoldReferenceValues) {
  const double t_per_tau[] = {2, 4, 8, 12, 28, 84};
  const double lambda_e[] = {1.06301, 1.04078, 1.02867, 1.02386, 1.01698, 1.01213};
  const double G_peak = exact_flow(paper, ramped, 0.1, 1, 1);  // lambda_crit is passed at t = 0.1
  for (int i = 0; i < 6; ++i) {
    const double t = t_per_tau[i] * 0.5;
    const double exact = 1.1 / exact_held(paper, 1.1, t - 1, G_peak);
    EXPECT_NEAR(exact, lambda_e[i], 6e-6);
    EXPECT_NEAR(1.1 / stepped(paper, ramped, t, static_cast<int>(t / 0.001)), exact, 5e-5);
  }
}

/// The smallest and largest order of convergence in a test, for its report.
struct Orders {
  double least = 10, most = 0;
  void add(double order) { least = std::min(least, order), most = larger(most, order); }
  ~Orders() { std::printf("orders %.3f to %.3f\n", least, most); }
};

TEST(History, BackwardEulerConvergesWithOrderOne) {
  Orders orders;
  for (double gamma : {0.5, 1.0, 2.0, 2.5}) {
    GrowthRate<> rate = paper;
    rate.gamma = gamma;
    const double exact = exact_flow(rate, held, 0, 1, 1);
    for (int n : {200, 400, 800, 1600}) {
      const double order =
          std::log2((exact - stepped(rate, held, 1, n)) / (exact - stepped(rate, held, 1, 2 * n)));
      orders.add(order);
      EXPECT_NEAR(order, 1, 0.05) << "gamma " << gamma << ", steps " << n;
    }
    EXPECT_LT(stepped(rate, held, 1, 100), exact);  // it underestimates growth at held stretch
  }
}

TEST(History, MidpointFlowConvergesWithOrderTwo) {
  // A stretch that changes all the time; for a held stretch the flow is exact.
  Orders orders;
  const auto moving = [](double t) { return 1.08 + 0.03 * std::sin(3 * t); };
  for (double gamma : {0.5, 1.0, 2.0, 2.5}) {
    GrowthRate<> rate = paper;
    rate.gamma = gamma;
    const double exact = exact_flow(rate, moving, 0, 1, 1);
    for (int n : {20, 40, 80}) {
      const double coarse = stepped(rate, moving, 1, n, TimeIntegration::midpoint_flow) - exact;
      const double fine = stepped(rate, moving, 1, 2 * n, TimeIntegration::midpoint_flow) - exact;
      orders.add(std::log2(coarse / fine));
      EXPECT_NEAR(std::log2(coarse / fine), 2, 0.05) << "gamma " << gamma << ", steps " << n;
    }
    EXPECT_NEAR(stepped(rate, held, 1, 7, TimeIntegration::midpoint_flow), exact_flow(rate, held, 0, 1, 1),
                1e-12);
  }
}

// Cat soleus held short loses sarcomeres: down to lambda/lambda_crit_rev, or to G_min.
TEST(History, RemovalEndsAtItsThresholdOrAtGMin) {
  FibreGrowth<> muscle;
  muscle.removal = {1, 2, 0.5, 0.99};
  for (auto [stretch, end] : {std::pair(0.8, 0.8 / 0.99), std::pair(0.4, 0.5)}) {
    for (TimeIntegration how : {TimeIntegration::backward_euler, TimeIntegration::midpoint_flow}) {
      muscle.integration = how;
      State<> state;
      state.lambda = stretch;
      for (int i = 0; i < 400; ++i) {
        Mat3<double> F = Mat3<double>::Identity();
        F(0, 0) = stretch;
        const auto u = update(muscle, F, state, 1000.0);
        ASSERT_LE(u.state.G, state.G);
        state = u.state;
      }
      EXPECT_NEAR(state.G, end, 1e-4);
      EXPECT_GE(state.G, end * (1 - 1e-15));
    }
  }
}

TEST(History, GrowthEndsAtTheThresholdOrAtGMax) {
  EXPECT_NEAR(stepped(paper, held, 5000, 5000), 1.1 / 1.01, 1e-4);
  EXPECT_LE(stepped(paper, held, 5e9, 5000), 1.1 / 1.01 * (1 + 1e-15));
  EXPECT_NEAR(stepped(
                  paper, [](double) { return 1.2; }, 5e9, 100),
              1.1, 1e-5);
  GrowthRate<> linear = paper;
  linear.gamma = 0;
  EXPECT_EQ(stepped(
                linear, [](double) { return 1.2; }, 5, 50),
            1.1);
}

}  // namespace
