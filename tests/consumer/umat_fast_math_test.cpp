// The UMAT in one file, compiled with -Ofast: hostile input is refused, with the step cut and NaN for the
// result.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "../support/umat_host.hpp"

namespace {

host::Call ordinary(int ntens) {
  host::Call call;
  call.ntens = ntens;
  call.F << 1.2, 0.02, 0, 0.01, 0.95, 0, 0, 0, 0.95;
  call.props.resize(13);
  call.props[6] = 1;
  call.props[12] = 1e-3;  // advice on the step
  call.statev[0] = 1.02;
  return call;
}

}  // namespace

TEST(UmatWithFastMath, RefusesWhatIsNotFinite) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (int ntens : {6, 4, 3}) {
    host::Call call = ordinary(ntens);
    call.run();
    ASSERT_TRUE(std::isfinite(call.stress[0]) && std::isfinite(call.ddsdde.data()[0]));
    for (double order : {0.0, 1.0}) {
      for (double x : {nan, inf, -inf}) {
        const auto refused = [&](const auto& spoil, const char* what) {
          host::Call bad = ordinary(ntens);
          bad.props[11] = order;
          spoil(bad);
          const auto statev = bad.statev;
          bad.run();
          EXPECT_TRUE(std::isnan(bad.stress[0])) << what << " = " << x << ", NTENS = " << ntens;
          EXPECT_TRUE(std::isnan(bad.ddsdde.data()[0])) << what << " = " << x;
          EXPECT_LE(bad.pnewdt, 0.25) << what << " = " << x;
          for (std::size_t i = 1; i < statev.size(); ++i) EXPECT_EQ(bad.statev[i], statev[i]) << what;
        };
        for (int i : {0, 1, 3, 4}) refused([&](host::Call& c) { c.F.data()[i] = x; }, "DFGRD1");
        for (std::size_t i = 0; i < 13; ++i) refused([&](host::Call& c) { c.props[i] = x; }, "PROPS");
        refused([&](host::Call& c) { c.statev[0] = x; }, "STATEV(1)");
        refused([&](host::Call& c) { c.dtime = x; }, "DTIME");
      }
    }
  }
}

TEST(UmatWithFastMath, RefusesSingularDeformations) {
  host::Call call = ordinary(6);
  call.F << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9;
  call.run();
  EXPECT_TRUE(std::isnan(call.stress[0]));
}
