// Many cycles in jumps against every cycle computed, and the order of a jump.
#include <gtest/gtest.h>

#include "../../examples/common/cycles.hpp"

using namespace study;

namespace {

const myogrowth::GrowthRate<> growth{0.5, 2, 1.6, 1.01};

double all_cycles(const myogrowth::RemovalRate<>& removal, const Cycle& c, long n) {
  double G = 1;
  for (long i = 0; i < n; ++i) G = one_cycle(growth, removal, c, G);
  return G;
}

TEST(Cycles, JumpsAreAsExactAsAsked) {
  for (const myogrowth::RemovalRate<>& removal :
       {myogrowth::RemovalRate<>{}, {0.5, 2, 0.5, 1}, {25, 2, 0.5, 1}, {500, 0, 0.5, 0.99}}) {
    for (const Cycle& c :
         {Cycle{1.1, 0.05, 1, 1}, {1.3, 1, 1, 1}, {1.05, 0.5, 0.8, 1}, {1.2, 0.25, 0.9, 2}}) {
      const double exact = all_cycles(removal, c, 3000);
      for (double tolerance : {1e-3, 1e-5, 1e-7}) {
        const Cycles jumped = many_cycles(growth, removal, c, 1, 3000, tolerance);
        EXPECT_NEAR(jumped.G, exact, tolerance) << removal.tau_rev << " " << c.stretch;
        if (tolerance == 1e-3) {
          EXPECT_LT(jumped.evaluated, 1500);
        }
      }
    }
  }
}

TEST(Cycles, FewCyclesAreComputedOneByOne) {
  const myogrowth::RemovalRate<> removal{25, 2, 0.5, 1};
  const Cycle c{1.3, 6, 0.9, 1};
  EXPECT_EQ(many_cycles(growth, removal, c, 1, 0, 1e-6).G, 1);
  EXPECT_EQ(many_cycles(growth, removal, c, 1, 1, 1e-6).G, one_cycle(growth, removal, c, 1));
  EXPECT_NEAR(many_cycles(growth, removal, c, 1, 7, 1e-9).G, all_cycles(removal, c, 7), 1e-9);
}

}  // namespace
