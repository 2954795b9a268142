// The packs' functions against long double, for every width; and that lanes know nothing of each other.
#include <gtest/gtest.h>
#include <myogrowth/many/pack.hpp>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "../support/samples.hpp"

using namespace myogrowth::simd;

namespace {

template <class V>
V unit_in_last_place(long double x) {
  const int exponent = std::max(std::ilogb(x), std::numeric_limits<V>::min_exponent - 1);
  return static_cast<V>(std::ldexp(1.0L, exponent - std::numeric_limits<V>::digits + 1));
}
template <class V>
double ulps(V x, long double exact) {
  if (!(x - x == 0)) return std::numeric_limits<double>::infinity();
  return static_cast<double>(std::abs(x - exact) / unit_in_last_place<V>(exact));
}

template <class V_, int N_>
struct Lanes {
  using V = V_;
  static constexpr int N = N_;
};
template <class L>
class Simd : public testing::Test {
 public:
  using V = typename L::V;
  static constexpr int N = L::N;
  using P = Pack<V, N>;
  static constexpr bool is_double = sizeof(V) == 8;
  samples::Random r{11};

  /// Any sign, |x| log-uniform.
  V wide(double least, double most) {
    const double x = r.log_uniform(least, most);
    return static_cast<V>(r.chance(0.5) ? x : -x);
  }
  /// The largest error of f(pack), in ulps times what `per` says, over packs of what x() gives.
  template <class X, class F, class Exact, class Per>
  double worst(X x, F f, Exact exact, Per per) {
    double worst = 0;
    for (int sample = 0; sample < 20000 / N; ++sample) {
      V in[N], out[N];
      for (V& entry : in) entry = x();
      f(P::load(in)).store(out);
      for (int i = 0; i < N; ++i) {
        const double error = ulps(out[i], exact(static_cast<long double>(in[i]))) / per(in[i]);
        if (error > worst) worst = error;
      }
    }
    this->RecordProperty("worst", std::to_string(worst));
    return worst;
  }
  /// The largest error in ulps over the whole of [low, high], 0 < low: so many numbers that are evenly spaced
  /// among all that the format has there, both ends included; with the other sign if `negative`.
  template <class F, class Exact>
  double worst_between(double low, double high, bool negative, F f, Exact exact) {
    using Bits = std::conditional_t<is_double, std::uint64_t, std::uint32_t>;
    const auto bits_of = [](double x) {
      const V v = static_cast<V>(x);
      Bits bits;
      std::memcpy(&bits, &v, sizeof v);
      return bits;
    };
    constexpr Bits count = 60000 / N * N;
    const Bits first = bits_of(low), step = (bits_of(high) - first) / (count - 1),
               rest = (bits_of(high) - first) % (count - 1);
    Bits i = 0;
    const auto next = [&] {
      const Bits bits = first + i * step + std::min(i, rest);
      i = (i + 1) % count;
      V v;
      std::memcpy(&v, &bits, sizeof v);
      return negative ? -v : v;
    };
    double largest = 0;
    for (Bits n = 0; n < count; n += 20000 / N * N) largest = std::max(largest, worst(next, f, exact));
    return largest;
  }
  template <class X, class F, class Exact>
  double worst(X x, F f, Exact exact) {
    return worst(x, f, exact, [](V) { return 1.0; });
  }
};
#ifdef MYOGROWTH_TEST_FEW_CONFIGS
using Widths = testing::Types<Lanes<double, 2>, Lanes<float, 8>>;  // one register, two
#else
using Widths = testing::Types<Lanes<double, 2>, Lanes<double, 4>, Lanes<double, 8>, Lanes<double, 16>,
                              Lanes<float, 4>, Lanes<float, 8>, Lanes<float, 16>, Lanes<float, 32>>;
#endif
TYPED_TEST_SUITE(Simd, Widths, );

#define MYOGROWTH_NAMES                       \
  using Test = TestFixture;                   \
  using V = typename Test::V;                 \
  using P = typename Test::P;                 \
  [[maybe_unused]] constexpr int N = Test::N; \
  [[maybe_unused]] constexpr bool is_double = Test::is_double

// The errors and ranges that pack.hpp's comments state.
TYPED_TEST(Simd, MaxErrorsInTheirValidRanges) {
  MYOGROWTH_NAMES;
  using Limits = std::numeric_limits<V>;
  const double tiny = static_cast<double>(Limits::min()), most = 0.7 * static_cast<double>(Limits::max());
  const double to_1 = 1 - static_cast<double>(Limits::epsilon()) / 2;
  const auto log1p_ = [](const P& x) { return log1p(x); };
  const auto log_ = [](const P& x) { return log(x); };
  const auto exp_ = [](const P& x) { return exp(x); };
  const auto expm1_ = [](const P& x) { return expm1(x); };
  const auto print = [&](const char* name, double error) {
    this->RecordProperty(name, std::to_string(error));
    return error;
  };
  EXPECT_LE(print("log", this->worst_between(tiny, most, false, log_, [](long double x) { return logl(x); })),
            1);
  EXPECT_LE(
      print("log1p", this->worst_between(tiny, most, false, log1p_, [](long double x) { return log1pl(x); })),
      1);
  EXPECT_LE(print("log1p_n",
                  this->worst_between(tiny, to_1, true, log1p_, [](long double x) { return log1pl(x); })),
            1);
  const double low = is_double ? 708 : 87, high = is_double ? 709 : 88;
  EXPECT_LE(print("exp", this->worst_between(tiny, high, false, exp_, [](long double x) { return expl(x); })),
            1);
  EXPECT_LE(print("exp_n", this->worst_between(tiny, low, true, exp_, [](long double x) { return expl(x); })),
            1);
  EXPECT_LE(
      print("expm1", this->worst_between(tiny, high, false, expm1_, [](long double x) { return expm1l(x); })),
      2.5);
  EXPECT_LE(
      print("expm1_n", this->worst_between(tiny, low, true, expm1_, [](long double x) { return expm1l(x); })),
      2.5);
}

TYPED_TEST(Simd, Log1p) {
  MYOGROWTH_NAMES;
  const auto f = [](const P& x) { return log1p(x); };
  const auto exact = [](long double x) { return log1pl(x); };
  auto& r = this->r;
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(-0.99, 3)); }, f, exact), 1.5);
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(-0.3, 0.45)); }, f, exact), 1.5);
  EXPECT_LE(
      this->worst([&] { return static_cast<V>(-1 + r.log_uniform(is_double ? 1e-15 : 1e-6, 1)); }, f, exact),
      1.5);
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.log_uniform(1, is_double ? 1e300 : 1e37)); }, f, exact),
            1.5);
  EXPECT_LE(this->worst([&] { return this->wide(is_double ? 1e-300 : 1e-36, 0.5); }, f, exact), 1.5);
  // Results about and below the smallest normal number; the last of these are subnormal.
  EXPECT_LE(this->worst([&] { return this->wide(is_double ? 1e-320 : 1e-43, is_double ? 1e-300 : 1e-36); }, f,
                        exact),
            1.5);
  EXPECT_EQ(log1p(P(V(0)))[0], 0);

  // The law's own: with the series alone within its range, and the scalar's, which has the same.
  const auto ours = [](const P& x) { return ln_1_plus(x, x, P(V(1))); };
  const auto scalar = [](P x) {
    for (int i = 0; i < N; ++i) x.set(i, myogrowth::ln_1_plus(x[i], x[i], V(1)));
    return x;
  };
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(-0.9, 2)); }, ours, exact), 1.5);
  EXPECT_LE(this->worst([&] { return this->wide(is_double ? 1e-300 : 1e-36, 0.25); }, ours, exact), 1.5);
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(-0.9, 2)); }, scalar, exact), 1);
  EXPECT_LE(this->worst([&] { return this->wide(is_double ? 1e-300 : 1e-36, 0.25); }, scalar, exact), 1);
}

TYPED_TEST(Simd, Log) {
  MYOGROWTH_NAMES;
  const auto f = [](const P& x) { return log(x); };
  const auto exact = [](long double x) { return logl(x); };
  auto& r = this->r;
  const double least = static_cast<double>(std::numeric_limits<V>::min()), most = is_double ? 1e308 : 2e38;
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.log_uniform(least * 1.001, most)); }, f, exact), 1.5);
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(0.5, 2)); }, f, exact), 1.5);
  EXPECT_LE(
      this->worst([&] { return static_cast<V>(1 + this->wide(is_double ? 1e-15 : 1e-6, 0.3)); }, f, exact),
      1.5);
  EXPECT_EQ(log(P(V(1)))[0], 0);
}

TYPED_TEST(Simd, Exp) {
  MYOGROWTH_NAMES;
  const auto f = [](const P& x) { return exp(x); };
  const auto exact = [](long double x) { return expl(x); };
  auto& r = this->r;
  const double low = is_double ? -708 : -87, high = is_double ? 709 : 88;
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(low, high)); }, f, exact), 1.5);
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(-1, 1)); }, f, exact), 1.5);
  EXPECT_LE(this->worst([&] { return this->wide(1e-30, 1); }, f, exact), 1.5);
  EXPECT_EQ(exp(P(V(0)))[0], 1);
  const V infinity = std::numeric_limits<V>::infinity();
  for (V x : {static_cast<V>(low * 1.01), static_cast<V>(low * 100), -infinity})
    EXPECT_EQ(exp(P(x))[0], 0) << x;
  for (V x : {static_cast<V>(high * 1.01), static_cast<V>(high * 100), infinity}) {
    EXPECT_GT(exp(P(x))[0], std::numeric_limits<V>::max() / 8) << x;
  }
}

TYPED_TEST(Simd, Pow) {
  MYOGROWTH_NAMES;
  auto& r = this->r;
  for (double exponent : {0.2, 1.0 / 3, 0.5, 1.0, 1.7, 2.7, 19.0, 20.0, -1.3}) {
    const V e = static_cast<V>(exponent);
    const double decades = (is_double ? 300 : 36) / std::max(1.0, std::abs(exponent));
    const auto f = [&](const P& x) { return pow(x, e); };
    const auto exact = [&](long double x) { return powl(x, e); };
    // Its bound is of the relative error: ulps are up to twice as fine.
    const auto per = [&](V x) {
      const long double y = exact(x);
      return (2 + std::abs(static_cast<double>(e) * std::log(static_cast<double>(x)))) *
             static_cast<double>(std::numeric_limits<V>::epsilon() * y / unit_in_last_place<V>(y));
    };
    const auto wide = [&] { return static_cast<V>(std::pow(10, r.uniform(-decades, decades))); };
    EXPECT_LE(this->worst(wide, f, exact, per), 1) << exponent;
    EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(0.05, 1)); }, f, exact, per), 1) << exponent;
  }
  EXPECT_EQ(pow(P(V(0)), V(2.5))[0], 0);
  EXPECT_EQ(pow(P(V(0)), V(0))[0], 1);
  EXPECT_EQ(pow(P(V(1)), V(2.7))[0], 1);
}

TYPED_TEST(Simd, DivisionAndSquareRoot) {
  MYOGROWTH_NAMES;
  auto& r = this->r;
  double worst = 0, worst_given = 0, worst_rough = 0, worst_near = 0;
  for (int sample = 0; sample < 100000 / N; ++sample) {
    V a[N], b[N], divided[N], given[N], rough[N], near_by[N];
    for (int i = 0; i < N; ++i) {
      const bool near = r.chance(0.5);  // the quotient itself and what corrects it stay in the normal range
      a[i] = this->wide(near ? 0.5 : is_double ? 1e-130 : 1e-14, near ? 2 : is_double ? 1e130 : 1e14);
      b[i] = this->wide(near ? 0.5 : is_double ? 1e-150 : 1e-16, near ? 2 : is_double ? 1e150 : 1e16);
    }
    (P::load(a) / P::load(b)).store(divided);
    quotient(P::load(a), P::load(b), P(V(1)) / P::load(b)).store(given);
    rough_quotient(P::load(a), P::load(b)).store(rough);
    near_quotient(P::load(a), P::load(b)).store(near_by);
    for (int i = 0; i < N; ++i) {
      const long double exact = static_cast<long double>(a[i]) / b[i];
      worst = std::max(worst, ulps(divided[i], exact));
      worst_given = std::max(worst_given, ulps(given[i], exact));
      worst_rough = std::max(worst_rough, std::abs(static_cast<double>(rough[i] / exact - 1)));
      worst_near = std::max(worst_near, std::abs(static_cast<double>(near_by[i] / exact - 1)));
    }
  }
  this->RecordProperty("worst_quotient", std::to_string(worst));
  EXPECT_LE(worst, 1);
  EXPECT_LE(worst_given, 1);
  EXPECT_LE(worst_rough, is_double ? 1e-8 : 1e-4);
  EXPECT_LE(worst_near, is_double ? 1e-12 : 3e-7);
  const double least = static_cast<double>(std::numeric_limits<V>::min() / std::numeric_limits<V>::epsilon());
  const auto root = [](const P& x) { return sqrt(x); };
  const auto exact = [](long double x) { return sqrtl(x); };
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.log_uniform(least, is_double ? 1e308 : 3e38)); }, root,
                        exact),
            1);
  EXPECT_LE(this->worst([&] { return static_cast<V>(r.uniform(0.2, 5)); }, root, exact), 1);
}

TYPED_TEST(Simd, MasksAndSelection) {
  MYOGROWTH_NAMES;
  const V nan = std::numeric_limits<V>::quiet_NaN();
  const V choices[] = {V(-1), V(0), V(1), V(2), nan};
  for (int sample = 0; sample < 500; ++sample) {
    V a[N], b[N], chosen[N];
    for (V& x : a) x = this->r.pick(choices);
    for (V& x : b) x = this->r.pick(choices);
    const P pa = P::load(a), pb = P::load(b);
    unsigned less = 0, not_less = 0, equal = 0, either = 0, both = 0;
    for (int i = 0; i < N; ++i) {
      less |= (a[i] < b[i] ? 1u : 0u) << i;
      not_less |= (a[i] < b[i] ? 0u : 1u) << i;
      equal |= (a[i] == b[i] ? 1u : 0u) << i;
      either |= (a[i] <= b[i] ? 1u : 0u) << i;
      both |= (a[i] >= b[i] && a[i] <= b[i] ? 1u : 0u) << i;
    }
    EXPECT_EQ(bits(pa < pb), less);
    EXPECT_EQ(bits(pb > pa), less);
    EXPECT_EQ(bits(!(pa < pb)), not_less);
    EXPECT_EQ(bits(pa == pb), equal);
    EXPECT_EQ(bits(pa <= pb), either);
    EXPECT_EQ(bits((pa < pb) | (pa == pb)), either);
    EXPECT_EQ(bits((pa >= pb) & (pa <= pb)), both);
    EXPECT_EQ(any(pa < pb), less != 0);
    EXPECT_EQ(any(pa == pb), equal != 0);
    select(pa < pb, pa, pb).store(chosen);
    V smaller[N], larger[N], size[N];
    minimum(pa, pb).store(smaller);
    maximum(pa, pb).store(larger);
    abs(-pa).store(size);
    for (int i = 0; i < N; ++i) {
      const auto same = [](V x, V y) { return x == y || (x != x && y != y); };
      EXPECT_TRUE(same(smaller[i], a[i] < b[i] ? a[i] : b[i]));
      EXPECT_TRUE(same(larger[i], a[i] > b[i] ? a[i] : b[i]));
      EXPECT_TRUE(same(size[i], std::abs(a[i])) && !std::signbit(size[i]));
    }
    const V* from[] = {b, a};
    for (int i = 0; i < N; ++i)  // a NaN as well comes through as it is
      EXPECT_EQ(std::memcmp(&chosen[i], &from[less >> i & 1][i], sizeof(V)), 0);
  }
  for (int lane = 0; lane < N; ++lane) {
    P p(V(0));
    p.set(lane, V(1));
    EXPECT_EQ(p[lane], 1);
    EXPECT_EQ(bits(p > P(V(0))), 1u << lane);
    EXPECT_TRUE(any(p > P(V(0))));
  }
  EXPECT_EQ(bits(!(P(V(0)) < P(V(1)))), 0u);
}

// A wider pack is its registers; a lane's bits do not depend on its place or its neighbours, NaN included.
TYPED_TEST(Simd, LanesAndPartsKnowNothingOfEachOther) {
  MYOGROWTH_NAMES;
  using Part = Pack<V, P::width>;
  const V nan = std::numeric_limits<V>::quiet_NaN();
  constexpr int functions = 16;
  const auto all = [](const auto& x, const auto& y, V* out) {
    using Q = std::decay_t<decltype(x)>;
    const int n = sizeof(Q) / sizeof(V);
    const Q results[] = {x / y,
                         rough_quotient(x, y),
                         near_quotient(x, y),
                         sqrt(y),
                         log1p(x),
                         ln_1_plus(x, x, Q(V(1))),
                         log(y),
                         exp(x),
                         pow(y, V(2.7)),
                         x + y,
                         x * y,
                         multiply_add(x, y, x),
                         quotient(x, y, Q(V(1)) / y),
                         minimum(x, y),
                         maximum(x, y),
                         abs(x)};
    for (int k = 0; k < functions; ++k) results[k].store(out + k * n);
  };
  for (int sample = 0; sample < 500; ++sample) {
    V x[N], y[N];
    for (V& entry : x) entry = this->r.chance(0.05) ? nan : static_cast<V>(this->r.uniform(-0.9, 5));
    for (V& entry : y) entry = this->r.chance(0.05) ? nan : static_cast<V>(this->r.log_uniform(1e-6, 1e6));
    V whole[functions * N];
    all(P::load(x), P::load(y), whole);
    for (int k = 0; k < P::parts; ++k) {
      V part[functions * P::width];
      all(Part::load(x + k * P::width), Part::load(y + k * P::width), part);
      for (int f = 0; f < functions; ++f) {
        for (int i = 0; i < P::width; ++i) {
          const V a = whole[f * N + k * P::width + i], b = part[f * P::width + i];
          EXPECT_TRUE(std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b)) << f;
        }
      }
    }
    const int lane = static_cast<int>(this->r.bits() % static_cast<unsigned>(N));
    V alone[functions * N];
    all(P(x[lane]), P(y[lane]), alone);
    for (int f = 0; f < functions; ++f) {
      const V a = whole[f * N + lane], b = alone[f * N];
      EXPECT_TRUE(std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b)) << f;
    }
  }
}

}  // namespace
