// The batch against update_point; that a point's bits are its own; that nothing else is touched.
#include <gtest/gtest.h>
#include <myogrowth/many/batch.hpp>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "../support/larger.hpp"
#include "../support/samples.hpp"

using namespace myogrowth;
using samples::Kind;

namespace {

template <class V>
struct Point {
  V F[9], n0[3], G, dt, lambda;
};
/// All that can come out of one; 0 where it was not asked for.
template <class V>
struct Result {
  V stress[9], G, tangent[81], scalars[5];
};

enum class Layout { soa, aos, aosoa };

/// The numbers of n points in a layout, among others that nobody may touch; to the end of the memory, so that
/// the address sanitizer sees reads beyond.
template <Layout layout, int components, class V>
struct Array {
  static constexpr int block = 16 * 8 / sizeof(V);
  static constexpr V guard = V(-77);
  std::ptrdiff_t n, margin;
  std::vector<V> data;

  explicit Array(std::ptrdiff_t n_, std::ptrdiff_t margin_ = 40)
      : n(n_),
        margin(margin_),
        data(static_cast<std::size_t>(
                 (layout == Layout::aosoa ? (n + block - 1) / block * block : n) * components + 2 * margin),
             guard) {}
  auto view() {
    V* const from = data.data() + margin;
    if constexpr (layout == Layout::soa) return batch::soa(from, n);
    if constexpr (layout == Layout::aos) return batch::aos<components>(from);
    if constexpr (layout == Layout::aosoa) return batch::aosoa<components, block>(from);
  }
  /// Where it should be, without the library's help.
  V& operator()(int c, std::ptrdiff_t i) {
    const std::ptrdiff_t at = layout == Layout::soa ? c * n + i
                              : layout == Layout::aos
                                  ? i * components + c
                                  : i / block * block * components + c * block + i % block;
    return data[static_cast<std::size_t>(margin + at)];
  }
  /// How many numbers a point were written over (no result is the guard's value).
  double written() const {
    return static_cast<double>(static_cast<std::ptrdiff_t>(data.size()) -
                               std::count(data.begin(), data.end(), guard)) /
           static_cast<double>(n);
  }
};

template <class V_, Tangent tangent_, Measure measure_, Layout layout_, bool lean_>
struct Config {
  using V = V_;
  static constexpr Tangent tangent = tangent_;
  static constexpr Measure measure = measure_;
  static constexpr Layout layout = layout_;
  static constexpr bool lean = lean_;  ///< n0 and dt shared by all points, no lambda_n, no scalars
  static constexpr int n_stress = measure == Measure::first_piola ? 9 : 6;
  static constexpr int n_tangent = tangent == Tangent::none          ? 0
                                   : tangent == Tangent::compact     ? 7
                                   : measure == Measure::first_piola ? 81
                                                                     : 36;
};

/// What update_batch returns; G goes where it came from if in_place.
template <class C, class Muscle, class V = typename C::V>
std::ptrdiff_t run(const Muscle& muscle, const std::vector<Point<V>>& points, std::vector<Result<V>>& results,
                   bool in_place = false) {
  const auto n = static_cast<std::ptrdiff_t>(points.size());
  constexpr Layout layout = C::layout;
  Array<layout, 9, V> F(n, 0);
  Array<layout, 3, V> n0(n, 0);
  Array<layout, 1, V> G(n, in_place ? 40 : 0), dt(n, 0), lambda(n, 0), G_out(n);
  Array<layout, C::n_stress, V> stress(n);
  Array<layout, C::n_tangent == 0 ? 1 : C::n_tangent, V> tangent(n);
  Array<layout, 5, V> scalars(n);
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Point<V>& p = points[static_cast<std::size_t>(i)];
    for (int c = 0; c < 9; ++c) F(c, i) = p.F[c];
    for (int c = 0; c < 3; ++c) n0(c, i) = p.n0[c];
    G(0, i) = p.G, dt(0, i) = p.dt, lambda(0, i) = p.lambda;
  }
  const auto G_to = in_place ? G.view() : G_out.view();
  std::ptrdiff_t failed;
  if constexpr (C::lean) {
    Point<V> first = n > 0 ? points[0] : Point<V>();
    const batch::Input in{F.view(), batch::shared(first.n0), G.view(), batch::shared(&first.dt)};
    if constexpr (C::tangent == Tangent::none) {
      failed = update_batch<C::tangent, C::measure>(muscle, n, in, batch::Output{stress.view(), G_to});
    } else {
      failed = update_batch<C::tangent, C::measure>(muscle, n, in,
                                                    batch::Output{stress.view(), G_to, tangent.view()});
    }
  } else {
    const batch::Input<decltype(F.view()), decltype(n0.view()), decltype(G.view()), decltype(dt.view()),
                       decltype(lambda.view())>
        in{F.view(), n0.view(), G.view(), dt.view(), lambda.view()};
    const batch::Output<decltype(stress.view()), decltype(G.view()), decltype(tangent.view()),
                        decltype(scalars.view())>
        out{stress.view(), G_to, tangent.view(), scalars.view()};
    failed = update_batch<C::tangent, C::measure>(muscle, n, in, out);
  }
  if (n > 0) {  // with what is read below: nothing else was
    EXPECT_EQ(stress.written(), C::n_stress);
    EXPECT_EQ(tangent.written(), C::n_tangent);
    EXPECT_EQ(scalars.written(), C::lean ? 0 : 5);
    EXPECT_EQ(G_out.written(), in_place ? 0 : 1);
    EXPECT_EQ(G.written(), 1);
  }
  results.assign(points.size(), Result<V>());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    Result<V>& r = results[static_cast<std::size_t>(i)];
    for (int c = 0; c < C::n_stress; ++c) r.stress[c] = stress(c, i);
    for (int c = 0; c < C::n_tangent; ++c) r.tangent[c] = tangent(c, i);
    for (int c = 0; c < 5 && !C::lean; ++c) r.scalars[c] = scalars(c, i);
    r.G = in_place ? G(0, i) : G_out(0, i);
  }
  return failed;
}

/// The same point by point, and the sizes that errors of stress and tangent are measured by.
struct Expected {
  Update<> u;
  Result<double> result;
  double lost;                       ///< >= 1: what cancels in det F - 1
  double stress_size, tangent_size;  ///< c1 + 2 c2 |b_e| in the measure, times that
};
template <class C>
Expected expected(const FibreGrowth<>& muscle, const Point<double>& p) {
  Expected e{};
  State<> state;
  state.G = p.G;
  state.lambda = C::lean ? 1 : p.lambda;
  state.n0 = Eigen::Map<const Vec3<double>>(p.n0);
  const Mat3<double> F = Eigen::Map<const Mat3<double>>(p.F);
  e.u = update(muscle, F, state, p.dt);
  e.result.G = e.u.point.G;
  const double scalars[] = {e.u.point.lambda_e, e.u.point.lambda, e.u.point.J, e.u.point.Je, e.u.point.psi};
  for (int c = 0; c < 5 && !C::lean; ++c) e.result.scalars[c] = scalars[c];
  const double* be = e.u.point.be;
  const double stiffness = e.u.point.c1 + 2 * e.u.point.c2 * std::max(1.0, be[0] + be[1] + be[2]);
  const double per_F = F.inverse().norm(), per_J = 1 / e.u.point.J;
  // det F - 1 cancels where F is far from I and J is small, differently with every choice of fused
  // operations.
  const double lost = e.lost = std::max(1.0, std::pow(1 + F.norm(), 3) / e.u.point.J / 64);
  constexpr int pulls = C::measure == Measure::cauchy ? 0 : C::measure == Measure::first_piola ? 1 : 2;
  e.stress_size = lost * stiffness * (pulls == 0 ? per_J : std::pow(per_F, pulls));
  e.tangent_size = lost * stiffness * (pulls == 0 ? per_J : std::pow(per_F, 2 * pulls));
  const auto copy = [](const auto& from, double* to) {
    std::copy(from.data(), from.data() + from.size(), to);
  };
  if constexpr (C::measure == Measure::cauchy) copy(to_six(e.u.cauchy()), e.result.stress);
  if constexpr (C::measure == Measure::first_piola) copy(e.u.first_piola(), e.result.stress);
  if constexpr (C::measure == Measure::second_piola) copy(to_six(e.u.second_piola()), e.result.stress);
  if constexpr (C::tangent != Tangent::none) {
    if constexpr (C::measure == Measure::cauchy) copy(e.u.ddsdde(), e.result.tangent);
    if constexpr (C::measure == Measure::first_piola) copy(e.u.dP_dF(), e.result.tangent);
    if constexpr (C::measure == Measure::second_piola) copy(e.u.dS_dE(), e.result.tangent);
  }
  return e;
}

double norm(const double* x, int n) { return Eigen::Map<const Eigen::VectorXd>(x, n).norm(); }
double distance(const double* x, const double* y, int n) {
  return (Eigen::Map<const Eigen::VectorXd>(x, n) - Eigen::Map<const Eigen::VectorXd>(y, n)).norm();
}

/// The material of a sample, with what `options` and gamma say.
FibreGrowth<> material(samples::Random& r, double gamma, unsigned options) {
  FibreGrowth<> m = samples::point(r, Kind::any).muscle;
  m.growth.gamma = gamma;
  if (options & 1) m.energy = EnergyPer::grown_volume;
  if (options & 2) m.integration = TimeIntegration::midpoint_flow;
  if (options & 4)
    m.removal = {m.growth.tau * r.uniform(0.5, 2), r.pick({0.5, 1.0, 2.0, 3.3}), r.uniform(0.4, 0.9),
                 m.growth.lambda_crit * r.uniform(0.8, 1)};
  return m;
}

/// A point of a kind for that material: samples::point brought to its threshold and G_max by a change of
/// size. `any` comes as it is, or near G_max, near the threshold, or at small strain.
Point<double> point(samples::Random& r, const FibreGrowth<>& m, Kind kind, double largest_dt = 1e6) {
  const samples::Point s = samples::point(r, kind, largest_dt);
  const auto& g = m.growth;
  const auto& sg = s.muscle.growth;
  const int special = kind == Kind::any ? static_cast<int>(r.bits() % 6) : 0;
  Point<double> p;
  p.G = kind == Kind::saturated ? g.G_max * s.state.G / sg.G_max
                                : 1 + (g.G_max - 1) * (s.state.G - 1) / (sg.G_max - 1);
  if (special == 1) p.G = g.G_max - (g.G_max - 1) * r.log_uniform(1e-14, 1e-2);
  p.dt = s.dt / sg.tau * g.tau;
  const double lambda = (s.F * s.state.n0.normalized()).norm();
  double ratio = lambda / (s.state.G * sg.lambda_crit);
  if (special == 2) ratio = 1 + (r.chance(0.5) ? 1 : -1) * r.log_uniform(1e-11, 1e-2);
  Mat3<double> F = s.F * (ratio * g.lambda_crit * p.G / lambda);
  if (special == 3) F = samples::deformation(r, r.log_uniform(1e-9, 1e-2));
  for (int c = 0; c < 9; ++c) p.F[c] = F(c);
  for (int c = 0; c < 3; ++c) p.n0[c] = s.state.n0[c];
  p.lambda = (F * s.state.n0.normalized()).norm() * r.uniform(0.8, 1.25);
  return p;
}

/// n points of one kind, or of all kinds mixed; with one n0 and dt if they are to share it.
std::vector<Point<double>> some_points(samples::Random& r, const FibreGrowth<>& m, int n, bool mixed,
                                       Kind kind, bool share) {
  const Kind kinds[] = {Kind::growing,   Kind::growing,      Kind::below_threshold,
                        Kind::saturated, Kind::elastic_step, Kind::any};
  std::vector<Point<double>> points;
  for (int i = 0; i < n; ++i) {
    points.push_back(point(r, m, mixed ? r.pick(kinds) : kind));
    if (share) std::copy(points[0].n0, points[0].n0 + 3, points[static_cast<std::size_t>(i)].n0);
    if (share) points.back().dt = points[0].dt;
  }
  return points;
}

/// Points that have no result (or, the last ones, that only the scalar routine takes).
std::vector<Point<double>> spoiled(const Point<double>& good) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  std::vector<Point<double>> points(20, good);
  for (int c = 0; c < 9; ++c) points[0].F[c] *= -1;
  for (int c = 0; c < 3; ++c) points[1].F[3 + c] = points[1].F[c];
  for (int c = 0; c < 9; ++c) points[2].F[c] = 0;
  points[3].F[5] = nan;
  points[4].F[0] = inf;
  for (int c = 0; c < 9; ++c) points[5].F[c] *= 1e200;
  points[6].dt = nan;
  points[7].dt = inf;
  for (int c = 0; c < 3; ++c) points[8].n0[c] = 0;
  points[9].n0[1] = nan;
  points[10].n0[2] = inf;
  points[11].G = 0;
  points[12].G = -1;
  points[13].G = nan;
  points[14].G = inf;
  for (int c = 0; c < 3; ++c) points[15].n0[c] *= 1e-250;
  for (int c = 0; c < 3; ++c) points[16].n0[c] *= 1e250;
  points[17].dt = -1;
  points[18].dt = 1e308;
  for (int c = 0; c < 9; ++c) points[19].F[c] = c % 4 == 0 ? 0x1p-17 : 0;  // J_e - 1 rounds to -1
  points[19].G = 16;
  return points;
}

template <class V>
bool same_bits(const Result<V>& a, const Result<V>& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

constexpr Layout soa = Layout::soa, aos = Layout::aos, aosoa = Layout::aosoa;
constexpr Tangent none = Tangent::none, full = Tangent::full, compact = Tangent::compact;
#ifdef MYOGROWTH_TEST_FEW_CONFIGS  // compiling them all takes minutes
using Configs = testing::Types<Config<double, full, Measure::cauchy, soa, false>>;
using FloatConfigs = testing::Types<Config<float, full, Measure::cauchy, aosoa, false>>;
#else
using Configs = testing::Types<
    Config<double, none, Measure::cauchy, soa, true>, Config<double, full, Measure::cauchy, soa, false>,
    Config<double, full, Measure::cauchy, aosoa, true>, Config<double, compact, Measure::cauchy, aos, false>,
    Config<double, none, Measure::first_piola, aos, false>,
    Config<double, full, Measure::first_piola, aosoa, false>,
    Config<double, none, Measure::second_piola, aosoa, false>,
    Config<double, full, Measure::second_piola, soa, true>>;
using FloatConfigs = testing::Types<Config<float, full, Measure::cauchy, aosoa, false>,
                                    Config<float, none, Measure::cauchy, soa, true>>;
#endif
template <class C>
class Batch : public testing::Test {};
TYPED_TEST_SUITE(Batch, Configs, );

TYPED_TEST(Batch, AgreesWithTheUpdateOfEveryPoint) {
  using C = TypeParam;
  samples::Random r(21);
  constexpr double eps = std::numeric_limits<double>::epsilon();
  double worst_G = 0, worst_stress = 0, worst_own_stress = 0, worst_tangent = 0, worst_scalar = 0;
  for (double gamma : {0.5, 1.0, 1.5, 2.0, 2.5, 3.7, 20.0}) {
    for (unsigned sample = 0; sample < 8 * 6; ++sample) {
      const FibreGrowth<> m = material(r, gamma, sample / 6);
      const Kind kinds[] = {Kind::any,       Kind::growing,      Kind::below_threshold,
                            Kind::saturated, Kind::elastic_step, Kind::any};
      const auto points = some_points(r, m, 53, sample % 6 == 0, kinds[sample % 6], C::lean);
      std::vector<Result<double>> results;
      ASSERT_EQ((run<C>(m, points, results)), 0);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Expected e = expected<C>(m, points[i]);
        Result<double> x = results[i];
        if (C::tangent == Tangent::compact) {
          const double* t = x.tangent;
          const CompactTangent<double> seven{{t[0], t[1], t[2]}, t[3], t[4], t[5], t[6]};
          double ddsdde[36];
          seven.expand(m, x.stress, ddsdde);
          std::copy(ddsdde, ddsdde + 36, x.tangent);
        }
        const double G = std::abs(x.G / e.result.G - 1) / eps;
        const double stress = distance(x.stress, e.result.stress, 9), size = norm(e.result.stress, 9);
        const double tangent = distance(x.tangent, e.result.tangent, 81);
        worst_G = larger(worst_G, G);
        worst_stress = larger(worst_stress, stress / (size + e.stress_size));
        if (e.lost == 1 && size > 0.1 * e.stress_size)
          worst_own_stress = larger(worst_own_stress, stress / size);
        worst_tangent = larger(worst_tangent, tangent / e.tangent_size);
        for (int c = 0; c < 5; ++c) {
          const double scale = c < 4 ? std::abs(e.result.scalars[c]) : e.u.point.c1 + e.u.point.c2;
          const double error = std::abs(x.scalars[c] - e.result.scalars[c]) / (scale + 1e-300);
          worst_scalar = larger(worst_scalar, error);
        }
        ASSERT_LE(G, 4) << gamma << " " << sample << " " << i;
        // Stresses near zero are differences of numbers of the stiffness's size.
        ASSERT_LE(stress, 1e-13 * (size + e.stress_size)) << gamma << " " << sample << " " << i;
        ASSERT_LE(tangent, 1e-13 * e.tangent_size) << gamma << " " << sample << " " << i;
      }
    }
  }
  this->RecordProperty("worst_G", std::to_string(worst_G));
  this->RecordProperty("worst_stress_e15", std::to_string(worst_stress * 1e15));
  this->RecordProperty("worst_own_stress_e15", std::to_string(worst_own_stress * 1e15));
  this->RecordProperty("worst_tangent_e15", std::to_string(worst_tangent * 1e15));
  this->RecordProperty("worst_scalar_e15", std::to_string(worst_scalar * 1e15));
  EXPECT_LE(worst_own_stress, 1e-13);
  EXPECT_LE(worst_scalar, 1e-12);
}

TYPED_TEST(Batch, APointsBitsAreItsOwn) {
  using C = TypeParam;
  samples::Random r(22);
  for (unsigned sample = 0; sample < 16; ++sample) {
    const FibreGrowth<> m = material(r, r.pick({0.5, 1.0, 1.5, 2.0, 2.0, 3.7}), sample < 8 ? 0 : sample);
    auto pool = some_points(r, m, 60, true, Kind::any, C::lean);
    for (Point<double> p : spoiled(pool[0])) {
      if (C::lean) std::copy(pool[0].n0, pool[0].n0 + 3, p.n0);
      if (C::lean) p.dt = pool[0].dt;
      pool.push_back(p);
    }
    Point<double> undeformed = pool[1];  // the signs of zeros are bits as well
    for (int c = 0; c < 9; ++c) undeformed.F[c] = c % 4 == 0 ? 1.01 : -0.0;
    pool.push_back(undeformed);
    std::vector<Result<double>> alone, results;
    std::vector<int> fails;
    for (const Point<double>& p : pool) {
      fails.push_back(static_cast<int>(run<C>(m, {p}, results)));
      alone.push_back(results[0]);
    }
    for (std::size_t n = 1; n <= 70; ++n) {
      std::vector<Point<double>> points;
      std::vector<std::size_t> which;
      std::ptrdiff_t expected_fails = 0;
      for (std::size_t i = 0; i < n; ++i) {
        // Sometimes all neighbours are of the sound kind, sometimes many are not.
        which.push_back(r.bits() % (n % 3 == 0 ? 60 : pool.size()));
        points.push_back(pool[which.back()]);
        expected_fails += fails[which.back()];
      }
      for (bool in_place : {false, true}) {
        ASSERT_EQ((run<C>(m, points, results, in_place)), expected_fails);
        for (std::size_t i = 0; i < n; ++i) {
          ASSERT_TRUE(same_bits(results[i], alone[which[i]]))
              << "point " << which[i] << " at " << i << " of " << n << " sample " << sample;
        }
      }
    }
  }
}

TYPED_TEST(Batch, PointsOfManyMaterialsAreThoseOfEach) {
  using C = TypeParam;
  samples::Random r(25);
  const std::vector<FibreGrowth<>> materials = {material(r, 2, 0), material(r, 2.5, 1), material(r, 0.7, 2)};
  for (std::size_t n : {0u, 1u, 16u, 33u, 100u}) {
    auto points = some_points(r, materials[0], static_cast<int>(n), true, Kind::any, C::lean);
    if (n > 20) points[7].G = -1;
    std::vector<unsigned char> index;
    while (index.size() < n) {  // runs of 1 to 40
      const auto which = static_cast<unsigned char>(r.bits() % materials.size());
      index.insert(index.end(), std::min(n - index.size(), 1 + r.bits() % 40), which);
    }
    std::vector<Result<double>> results, of_one;
    const batch::Materials<double, unsigned char> view{materials.data(), index.data()};
    const std::ptrdiff_t failed = run<C>(view, points, results);
    EXPECT_EQ(failed, n > 20);
    for (std::size_t m = 0; m < materials.size(); ++m) {
      run<C>(materials[m], points, of_one);
      for (std::size_t i = 0; i < n; ++i) {
        if (index[i] != m) continue;
        EXPECT_TRUE(same_bits(results[i], of_one[i])) << i << " of " << n;
      }
    }
  }
}

TYPED_TEST(Batch, PointsWithoutAResultAreCountedAndNothingElseIsTouched) {
  using C = TypeParam;
  samples::Random r(23);
  for (double gamma : {0.5, 2.0, 2.3}) {
    FibreGrowth<> m = material(r, gamma, 0);
    m.growth.tau = 0.1;  // the longest step is then more than the largest number of them
    const Point<double> good = point(r, m, Kind::growing, 10);
    std::vector<Result<double>> results;
    for (const Point<double>& bad : spoiled(good)) {
      const Expected e = expected<C>(m, bad);
      for (std::size_t place : {0u, 7u, 36u}) {
        std::vector<Point<double>> points(37, good);
        points[place] = bad;
        if (C::lean) {  // all of its n0 and dt
          for (Point<double>& p : points) {
            std::copy(bad.n0, bad.n0 + 3, p.n0);
            p.dt = bad.dt;
          }
        }
        std::ptrdiff_t fails = 0;
        for (const Point<double>& p : points) fails += !expected<C>(m, p).u.ok();
        EXPECT_EQ((run<C>(m, points, results)), fails);
        const Result<double>& x = results[place];
        if (e.u.ok()) {
          EXPECT_NEAR(x.G, e.result.G, 1e-14);
          continue;
        }
        EXPECT_EQ(std::memcmp(&x.G, &bad.G, sizeof x.G), 0);
        for (int c = 0; c < C::n_stress; ++c) EXPECT_TRUE(std::isnan(x.stress[c]));
        for (int c = 0; c < C::n_tangent; ++c) EXPECT_TRUE(std::isnan(x.tangent[c])) << c;
        for (int c = 0; c < 5 && !C::lean; ++c) EXPECT_TRUE(std::isnan(x.scalars[c]));
      }
    }
    EXPECT_EQ((run<C>(m, {}, results)), 0);
  }
}

TEST(BatchStreamed, IsTheSame) {
  samples::Random r(26);
  const FibreGrowth<> m = material(r, 2, 0);
  constexpr std::ptrdiff_t n = 53, whole = 64;  // the last block is not full, and one point has no result
  auto points = some_points(r, m, n, true, Kind::any, false);
  points[20].G = -1;
  struct alignas(64) Numbers {
    double F[9 * whole], n0[3 * whole], G[whole], dt[whole];
    double stress[2][6 * whole], G_end[2][whole], tangent[2][36 * whole];
  };
  const auto memory = std::make_unique<Numbers>();
  Numbers& x = *memory;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Point<double>& p = points[static_cast<std::size_t>(i)];
    const std::ptrdiff_t block = i / 16, lane = i % 16;
    for (int c = 0; c < 9; ++c) x.F[(block * 9 + c) * 16 + lane] = p.F[c];
    for (int c = 0; c < 3; ++c) x.n0[(block * 3 + c) * 16 + lane] = p.n0[c];
    x.G[i] = p.G, x.dt[i] = p.dt;
  }
  using batch::aosoa;
  using batch::streamed;
  const batch::Input in{aosoa<9>(x.F), aosoa<3>(x.n0), aosoa<1>(x.G), aosoa<1>(x.dt)};
  const batch::Output cached{aosoa<6>(x.stress[0]), aosoa<1>(x.G_end[0]), aosoa<36>(x.tangent[0])};
  const batch::Output past{streamed<6>(x.stress[1]), streamed<1>(x.G_end[1]), streamed<36>(x.tangent[1])};
  // By packs as wide: contraction need not round those of another width in the same places.
  constexpr int lanes = batch::detail::lanes<double, 0, full, std::decay_t<decltype(past)>>;
  EXPECT_EQ((update_batch<full, Measure::cauchy, lanes>(m, n, in, cached)), 1);
  EXPECT_EQ(update_batch<full>(m, n, in, past), 1);
  EXPECT_EQ(std::memcmp(x.stress[0], x.stress[1], sizeof x.stress[0]), 0);
  EXPECT_EQ(std::memcmp(x.G_end[0], x.G_end[1], sizeof x.G_end[0]), 0);
  EXPECT_EQ(std::memcmp(x.tangent[0], x.tangent[1], sizeof x.tangent[0]), 0);
}

// Exponents so large that k_g(G_n) is below all numbers: nothing moves, and nothing is at its end.
TEST(BatchOfLargeExponents, IsTheUpdateOfEveryPoint) {
  constexpr std::ptrdiff_t n = 9;
  for (const double gamma : {50., 100., 300., 1e3, 1e5, 1e169}) {
    for (const bool is_removal : {false, true}) {
      FibreGrowth<> m;
      m.integration = TimeIntegration::midpoint_flow;
      if (is_removal) m.removal = {1.1, gamma, 0.5, 1.005};
      if (!is_removal) m.growth.gamma = gamma;
      double F[9 * n] = {}, n0[3 * n] = {}, G[n], G_end[n], stress[6 * n];
      const double dt = 480;
      for (std::ptrdiff_t i = 0; i < n; ++i) {
        F[i] = 1 + (is_removal ? -0.02 : 0.02) * static_cast<double>(i), F[4 * n + i] = F[8 * n + i] = 1;
        n0[i] = 1, G[i] = 1 + 0.01 * static_cast<double>(i % 3);
      }
      const batch::Input in{batch::soa(F, n), batch::soa(n0, n), batch::soa(G, n), batch::shared(&dt),
                            batch::soa(F, n)};  // F_11 is the stretch
      const batch::Output out{batch::soa(stress, n), batch::soa(G_end, n)};
      EXPECT_EQ(update_batch<none>(m, n, in, out), 0);
      for (std::ptrdiff_t i = 0; i < n; ++i) {
        const double F_i[9] = {F[i], 0, 0, 0, 1, 0, 0, 0, 1}, n0_i[3] = {1, 0, 0};
        PointUpdate<double> u;
        ASSERT_EQ(update_point(m, F_i, n0_i, G[i], F[i], dt, u), UpdateStatus::ok);
        EXPECT_NEAR(G_end[i], u.G, 1e-13) << gamma << is_removal << i;
      }
    }
  }
}

template <class C>
class BatchFloat : public testing::Test {};
TYPED_TEST_SUITE(BatchFloat, FloatConfigs, );

TYPED_TEST(BatchFloat, AgreesWithDouble) {
  using C = TypeParam;
  samples::Random r(24);
  double worst_G = 0, worst_stress = 0, worst_tangent = 0;
  for (double gamma : {0.5, 1.0, 1.5, 2.0, 2.5, 3.7, 20.0}) {
    for (unsigned options = 0; options < 8; ++options) {
      // The same material and points for both: rounded to float before.
      FibreGrowth<float> f;
      FibreGrowth<> m = material(r, gamma, options);
      const auto round = [](double& x, float& y) { x = y = static_cast<float>(x); };
      round(m.c1, f.c1), round(m.c2, f.c2);
      round(m.growth.tau, f.growth.tau), round(m.growth.gamma, f.growth.gamma);
      round(m.growth.G_max, f.growth.G_max), round(m.growth.lambda_crit, f.growth.lambda_crit);
      round(m.removal.tau_rev, f.removal.tau_rev), round(m.removal.gamma_rev, f.removal.gamma_rev);
      round(m.removal.G_min, f.removal.G_min), round(m.removal.lambda_crit_rev, f.removal.lambda_crit_rev);
      f.energy = m.energy, f.integration = m.integration;
      std::vector<Point<double>> points;
      std::vector<Point<float>> rounded;
      const Kind kinds[] = {Kind::growing, Kind::below_threshold, Kind::saturated, Kind::elastic_step};
      for (int i = 0; i < 150; ++i) {
        Point<double> p = point(r, m, r.pick(kinds), 100);
        if (C::lean && i > 0) std::copy(points[0].n0, points[0].n0 + 3, p.n0);
        if (C::lean && i > 0) p.dt = points[0].dt;
        Point<float> q;
        for (int c = 0; c < 9; ++c) round(p.F[c], q.F[c]);
        for (int c = 0; c < 3; ++c) round(p.n0[c], q.n0[c]);
        round(p.G, q.G), round(p.dt, q.dt), round(p.lambda, q.lambda);
        points.push_back(p);
        rounded.push_back(q);
      }
      std::vector<Result<float>> results;
      ASSERT_EQ((run<C>(f, rounded, results)), 0);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Expected e = expected<C>(m, points[i]);
        Result<double> x{};
        std::copy(results[i].stress, results[i].stress + 9, x.stress);
        std::copy(results[i].tangent, results[i].tangent + 81, x.tangent);
        worst_G = larger(worst_G, std::abs(static_cast<double>(results[i].G) / e.result.G - 1));
        worst_stress = larger(worst_stress, distance(x.stress, e.result.stress, 9) / e.stress_size);
        worst_tangent = larger(worst_tangent, distance(x.tangent, e.result.tangent, 81) / e.tangent_size);
      }
    }
  }
  this->RecordProperty("worst_G_e7", std::to_string(worst_G * 1e7));
  this->RecordProperty("worst_stress_e7", std::to_string(worst_stress * 1e7));
  this->RecordProperty("worst_tangent_e7", std::to_string(worst_tangent * 1e7));
  EXPECT_LE(worst_G, 1e-6);
  EXPECT_LE(worst_stress, 1e-4);
  EXPECT_LE(worst_tangent, 1e-4);
}

}  // namespace
