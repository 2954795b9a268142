// The routine of a device's thread (many/views.hpp, examples/cuda) on the host. It gives the same numbers as
// update_point and the batch; the example's comparison detects differences; the error of single precision.
#include <gtest/gtest.h>
#include <myogrowth/many/batch.hpp>

#include <algorithm>
#include <limits>

#include "many_points.hpp"

using namespace many_points;

namespace {

constexpr std::size_t n = 5003;

template <Tangent tangent, class V>
Results<V> stepped(const FibreGrowth<V>& muscle, const Inputs<V>& in) {
  Results<V> out(in.G_n.size(), tangent);
  const Arrays<V> a = arrays(in, out);
  for (std::ptrdiff_t i = 0; i < a.n; ++i) EXPECT_EQ(step<tangent>(muscle, a, i), UpdateStatus::ok) << i;
  return out;
}

template <class V>
class ManyPoints : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(ManyPoints, Precisions, );

TYPED_TEST(ManyPoints, TheSameBitsAsUpdatePoint) {
  using V = TypeParam;
  const FibreGrowth<V> muscle;
  const Inputs<V> in(n);
  const Results<V> full = stepped<Tangent::full>(muscle, in), compact = stepped<Tangent::compact>(muscle, in);
  std::size_t grow = 0;
  for (std::size_t i = 0; i < n; ++i) {
    V F[9], n0[3], stress[6], ddsdde[36];
    for (std::size_t c = 0; c < 9; ++c) F[c] = in.F[c * n + i];
    for (std::size_t c = 0; c < 3; ++c) n0[c] = in.n0[c * n + i];
    PointUpdate<V> u;
    ASSERT_EQ(update_point(muscle, F, n0, in.G_n[i], in.dt[0], u), UpdateStatus::ok);
    cauchy_from_kirchhoff(u.J, u.tau, stress);
    spatial_modulus(u, ddsdde, V(1) / u.J);
    grow += u.G > in.G_n[i];
    ASSERT_EQ(full.G[i], u.G);
    ASSERT_EQ(compact.G[i], u.G);
    for (std::size_t c = 0; c < 6; ++c) ASSERT_EQ(full.stress[c * n + i], stress[c]);
    for (std::size_t c = 0; c < 6; ++c) ASSERT_EQ(compact.stress[c * n + i], stress[c]);
    for (std::size_t c = 0; c < 36; ++c) ASSERT_EQ(full.tangent[c * n + i], ddsdde[c]);
    const V seven[7] = {u.f[0], u.f[1], u.f[2], u.dG_dlambda / u.lambda, u.tau[0] - u.c2 * u.be[0], u.G, u.J};
    for (std::size_t c = 0; c < 7; ++c) ASSERT_EQ(compact.tangent[c * n + i], seven[c]);
  }
  EXPECT_GT(grow, n / 2);  // and some do not
  EXPECT_LT(grow, n * 9 / 10);
}

TYPED_TEST(ManyPoints, AgreeWithTheBatch) {
  using V = TypeParam;
  const FibreGrowth<V> muscle;
  const Inputs<V> in(n);
  const Results<V> one_by_one = stepped<Tangent::full>(muscle, in);
  Results<V> batch(n, Tangent::full);
  const Arrays<V> a = arrays(in, batch);
  using batch::soa;
  const std::ptrdiff_t failed = update_batch(
      muscle, a.n, batch::Input{soa(a.F, a.n), soa(a.n0, a.n), soa(a.G_n, a.n), batch::shared(a.dt)},
      batch::Output{soa(a.stress, a.n), soa(a.G, a.n), soa(a.tangent, a.n)});
  EXPECT_EQ(failed, 0);
  const double rounding = 64 * static_cast<double>(std::numeric_limits<V>::epsilon());
  const Differences d = largest_differences<Tangent::full>(muscle, batch, one_by_one);
  EXPECT_LE(d.G, rounding);
  EXPECT_LE(d.stress, rounding);
  EXPECT_LE(d.tangent, rounding);
}

TYPED_TEST(ManyPoints, TheComparisonSeesEveryEntry) {
  using V = TypeParam;
  const FibreGrowth<V> muscle;
  const Inputs<V> in(50);
  const Results<V> good = stepped<Tangent::full>(muscle, in);
  const auto differences = [&](const Results<V>& r) {
    return largest_differences<Tangent::full>(muscle, r, good);
  };
  EXPECT_EQ(differences(good).G + differences(good).stress + differences(good).tangent, 0);
  const V less(V(1) - V(1e-3)), nan = std::numeric_limits<V>::quiet_NaN();
  for (std::size_t i = 0; i < 50; ++i) {
    Results<V> bad = good;
    bad.G[i] *= less;
    EXPECT_GT(differences(bad).G, 9e-4);
    bad.G[i] = nan;
    EXPECT_EQ(differences(bad).G, HUGE_VAL);
  }
  for (std::size_t k = 0; k < good.stress.size(); ++k) {
    Results<V> bad = good;
    bad.stress[k] += V(0.1);
    EXPECT_GT(differences(bad).stress, 1e-3);
    bad.stress[k] = nan;
    EXPECT_EQ(differences(bad).stress, HUGE_VAL);
  }
  for (std::size_t k = 0; k < good.tangent.size(); ++k) {
    Results<V> bad = good;
    bad.tangent[k] += V(0.1);
    EXPECT_GT(differences(bad).tangent, 1e-3);
    bad.tangent[k] = nan;
    EXPECT_EQ(differences(bad).tangent, HUGE_VAL);
  }
  const Results<V> seven = stepped<Tangent::compact>(muscle, in);
  Results<V> bad = seven;
  bad.tangent[3 * 50 + 7] += V(0.1);  // the weight of the seventh point's growth
  EXPECT_GT(largest_differences<Tangent::compact>(muscle, bad, seven).tangent, 1e-3);
}

// Relative errors of single precision, from the same inputs; docs/gpu.md has the figures.
TEST(SinglePrecision, GoodToItsRounding) {
  const FibreGrowth<float> muscle;
  const FibreGrowth<double> muscle_in_double;
  const std::size_t many = 100000;
  const Inputs<float> in(many);
  Inputs<double> same(many);
  std::copy(in.F.begin(), in.F.end(), same.F.begin());
  std::copy(in.n0.begin(), in.n0.end(), same.n0.begin());
  std::copy(in.G_n.begin(), in.G_n.end(), same.G_n.begin());
  std::copy(in.dt.begin(), in.dt.end(), same.dt.begin());
  // (Table 1's numbers are not exact in float: the rounding of the material is part of the error.)
  const Results<float> single = stepped<Tangent::full>(muscle, in);
  const Results<double> exact = stepped<Tangent::full>(muscle_in_double, same);
  Results<double> lifted(many, Tangent::full);
  std::copy(single.stress.begin(), single.stress.end(), lifted.stress.begin());
  std::copy(single.G.begin(), single.G.end(), lifted.G.begin());
  std::copy(single.tangent.begin(), single.tangent.end(), lifted.tangent.begin());
  const Differences d = largest_differences<Tangent::full>(muscle_in_double, lifted, exact);
  std::printf("largest errors of single precision: G %.1e, stress %.1e, DDSDDE %.1e\n", d.G, d.stress,
              d.tangent);
  EXPECT_LE(d.G, 5e-7);
  EXPECT_LE(d.stress, 1e-6);
  EXPECT_LE(d.tangent, 2e-6);
}

}  // namespace
