// -ffast-math, under which a compiler takes NaN and infinity for impossible: whatever comes in, the routines
// end, give the status that they give without it, and the same numbers to rounding.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "steps.hpp"

namespace {

using Step = steps::Output(const steps::Input&);

void expect_same(Step* plain, Step* fast, const steps::Input& in, const char* what, double x) {
  const steps::Output expected = plain(in), got = fast(in);
  ASSERT_EQ(got.status, expected.status) << what << " = " << x;
  double size = 0;
  for (double y : expected.numbers) size = std::fmax(size, std::isfinite(y) ? std::fabs(y) : 0);
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(std::isfinite(got.numbers[i]), std::isfinite(expected.numbers[i]))
        << what << " = " << x << ", number " << i;
    if (std::isfinite(expected.numbers[i])) {
      ASSERT_NEAR(got.numbers[i], expected.numbers[i], 1e-12 * size)
          << what << " = " << x << ", number " << i;
    }
  }
}

void expect_same_for_hostile(steps::Input in) {
  using Limits = std::numeric_limits<double>;
  const double hostile[] = {
      Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), 0, -1, 1e-3, 1, 30, 1e10, 1e160, 1e308};
  const auto both = [&](double& entry, const char* name) {
    const double kept = entry;
    for (double x : hostile) {
      entry = x;
      expect_same(steps::by_update, steps::by_update_fast, in, name, x);
      expect_same(steps::by_batch, steps::by_batch_fast, in, name, x);
      ASSERT_EQ(steps::by_batch(in).status != 0, steps::by_update(in).status != 0) << name << " = " << x;
    }
    entry = kept;
  };
  for (double& x : in.F) both(x, "an entry of F");
  for (double& x : in.n0) both(x, "an entry of n0");
  both(in.G, "G");
  both(in.lambda, "lambda_n");
  both(in.dt, "dt");
}

}  // namespace

TEST(FastMath, HostileInputGivesTheStatusAndTheNumbersOfOrdinaryOptions) {
  for (double gamma : {0.0, 0.5, 1.0, 2.0, 2.5, 2.7, 300.0}) {
    for (bool second_order : {false, true}) {
      for (double tau_rev : {0.0, 1.0}) {
        steps::Input in;
        in.gamma = gamma;
        in.second_order = second_order;
        in.tau_rev = tau_rev;
        expect_same_for_hostile(in);
        in.G = 1.09, in.F[0] = 0.7;  // removal
        expect_same_for_hostile(in);
      }
    }
  }
}

TEST(FastMath, SmallStrainsKeepTheirDigits) {
  for (double e : {1e-3, 1e-6, 1e-9}) {
    steps::Input in;
    const double F[9] = {1 + e, 0, 0, e / 2, 1, 0, 0, 0, 1 - e / 3};
    for (int i = 0; i < 9; ++i) in.F[i] = F[i];
    const steps::Output expected = steps::by_update(in), got = steps::by_update_fast(in),
                        packs = steps::by_batch_fast(in);
    for (int i = 36; i < 45; ++i)
      EXPECT_NEAR(got.numbers[i], expected.numbers[i], 1e-14 * std::fabs(expected.numbers[36])) << i;
    EXPECT_NEAR(packs.numbers[36], expected.numbers[36], 1e-14 * std::fabs(expected.numbers[36]));
  }
}
