// Muscle and tendon in series: the coupling holds, the steps are of second order, the limits are those known.
#include <gtest/gtest.h>

#include "../../examples/common/muscle_tendon.hpp"

using namespace study;
using myogrowth::UpdateStatus;

namespace {

myogrowth::FibreGrowth<> muscle_with_removal() {
  myogrowth::FibreGrowth<> m;
  m.growth = {1, 2, 1.6, 1.05};
  m.removal = {1, 0, 0.5, 1.05};
  m.integration = myogrowth::TimeIntegration::midpoint_flow;
  return m;
}

MuscleTendon after(const Tendon& t, int steps, double days, double force = 0) {
  const auto m = muscle_with_removal();
  MuscleTendon now;
  for (int i = 1; i <= steps; ++i) {
    const double time = days * i / steps;
    const auto status = force > 0 ? step_to_force(m, t, force * time, days / steps, now)
                                  : step_to_length(m, t, 1 + 0.3 * time / days, days / steps, now);
    EXPECT_EQ(status, UpdateStatus::ok);
  }
  return now;
}

TEST(MuscleTendon, StepsAreOfSecondOrder) {
  const Tendon tendon{1.02, 20, 10};
  for (double force : {0.0, 0.2}) {
    const MuscleTendon exact = after(tendon, 4096, 3, force);
    double last_G = 0, last_creep = 0;
    for (int steps : {16, 32, 64, 128}) {
      const MuscleTendon now = after(tendon, steps, 3, force);
      const double G = std::abs(now.G - exact.G), creep = std::abs(now.creep - exact.creep);
      if (last_G > 0) {
        EXPECT_GT(last_G / G, 3.2) << steps;
        EXPECT_LT(last_G / G, 5) << steps;
      }
      if (force > 0) {
        EXPECT_LT(creep, 1e-10);  // the force is linear in time: the trapezoidal rule is exact
      } else if (last_G > 0) {
        EXPECT_GT(last_creep / creep, 3.2) << steps;
        EXPECT_LT(last_creep / creep, 5) << steps;
      }
      last_G = G;
      last_creep = creep;
    }
    EXPECT_GT(exact.creep, 1.02);
  }
}

TEST(MuscleTendon, LengthAndForceAreHeldAtOnce) {
  const Tendon tendon{0.7, 15, 4};
  const auto m = muscle_with_removal();
  for (double dt : {0.0, 1e-6, 0.1, 10.0, 1e6}) {
    for (double length : {0.6, 1.0, 1.3, 5.0}) {
      MuscleTendon now{1.1, 1.1, 0.95, 1.01, 0};
      ASSERT_EQ(step_to_length(m, tendon, length, dt, now), UpdateStatus::ok) << dt << " " << length;
      // In a million days the length rises a million times as fast as the stretch, which is found to
      // rounding.
      EXPECT_NEAR(length_of(tendon, now), length, (dt > 100 ? 1e-4 : 1e-10) * length) << dt;
      // The force is that of the library at this stretch.
      MuscleTendon again{1.1, 1.1, 0.95, 1.01, 0};
      ASSERT_EQ(step_to_force(m, tendon, now.force, dt, again), UpdateStatus::ok);
      EXPECT_NEAR(again.stretch, now.stretch, 1e-7 * now.stretch);
      EXPECT_NEAR(again.force, now.force, 1e-10 + 1e-10 * std::abs(now.force));
    }
  }
}

TEST(MuscleTendon, WithoutATendonTheLengthIsTheStretch) {
  const auto m = muscle_with_removal();
  MuscleTendon now, stiff;
  for (int i = 1; i <= 50; ++i) {
    ASSERT_EQ(step_to_length(m, {}, 1 + 0.006 * i, 0.1, now), UpdateStatus::ok);
    ASSERT_EQ(step_to_length(m, {1, 1e9, 0}, 1 + 0.006 * i, 0.1, stiff), UpdateStatus::ok);
  }
  EXPECT_EQ(now.stretch, 1.3);
  EXPECT_EQ(now.tendon({}), 1);
  EXPECT_NEAR(stiff.stretch, 1.3, 1e-8);
  EXPECT_NEAR(stiff.G, now.G, 1e-8);
}

/// With the threshold of removal at 1 the force ends before any sarcomere is lost (docs/evidence.md).
TEST(MuscleTendon, ATendonTakesGrowthBackOnlyUnderTension) {
  auto m = muscle_with_removal();
  for (double threshold : {1.0, 1.05}) {
    m.growth.lambda_crit = m.removal.lambda_crit_rev = threshold;
    if (threshold == 1.0) m.growth.lambda_crit = 1.01;
    MuscleTendon now;
    double most = 1;
    for (int i = 0; i < 4000; ++i) {
      ASSERT_EQ(step_to_length(m, {1, 1e4, 1}, 1.3, 0.05, now), UpdateStatus::ok);
      most = std::max(most, now.G);
    }
    if (threshold == 1.0) {
      EXPECT_GT(now.G, most - 1e-9);
    } else {
      EXPECT_LT(now.G, most - 0.1);
    }
  }
}

TEST(MuscleTendon, NoResultLeavesTheStateAsItIs) {
  MuscleTendon now;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(step_to_length(muscle_with_removal(), {1, 10, 1}, nan, 0.1, now), UpdateStatus::ok);
  EXPECT_NE(step_to_force(muscle_with_removal(), {1, 10, 1}, nan, 0.1, now), UpdateStatus::ok);
  EXPECT_EQ(now.stretch, 1);
  EXPECT_EQ(now.G, 1);
}

}  // namespace
