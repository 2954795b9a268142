/// @file
/// A vector of numbers as a scalar: what the law asks of its number type (scalar.hpp), lane by lane.
///
/// Pack<V, N> is N lanes of float or double in SIMD registers of whatever the compiler targets
/// (register.hpp). Every operation treats each lane on its own, so a lane's result
/// depends neither on its place nor on its neighbours. Comparisons give a mask for `select` and `any`;
/// `value` names the type only, since many lanes have no one value to branch on.
#ifndef MYOGROWTH_MANY_PACK_HPP
#define MYOGROWTH_MANY_PACK_HPP

#include <cstddef>
#include <limits>

#include "register.hpp"

// Between register types g++ and clang have no other cast.
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif

namespace myogrowth {
namespace simd {

/// N lanes in one register, or in several side by side, whose operations hide each other's latency.
template <class V, int N>
struct Split {
  static constexpr int width = N < native_lanes<V> ? N : native_lanes<V>;  ///< lanes of a register
  static constexpr int parts = N / width;                                  ///< registers
};

/// The operations of these registers.
template <class V, int N>
using Best = Target<V, Split<V, N>::width>;

/// True or false in every lane.
template <class V, int N>
struct Mask : Split<V, N> {
  using Type = typename Best<V, N>::M;  ///< a register's
  Type v[entries(Mask::parts)];         ///< of the registers
  /// Every register k as f(k) says.
  template <class F>
  static Mask of(const F& f) {
    Mask m;
    for (int k = 0; k < Mask::parts; ++k) m.v[k] = static_cast<Type>(f(k));
    return m;
  }

  /// Lane by lane.
  /// @{
  friend Mask operator&(const Mask& a, const Mask& b) {
    return of([&](int k) { return a.v[k] & b.v[k]; });
  }
  friend Mask operator|(const Mask& a, const Mask& b) {
    return of([&](int k) { return a.v[k] | b.v[k]; });
  }
  friend Mask operator!(const Mask& a) {
    return of([&](int k) { return ~a.v[k]; });
  }
  /// @}
};

/// N lanes of V.
template <class V, int N>
struct Pack : Split<V, N> {
  using Split<V, N>::width;
  using Split<V, N>::parts;
  using Lanes = typename Register<V, width>::Lanes;        ///< a register
  using InMemory = typename Register<V, width>::InMemory;  ///< the same, wherever it lies
  using Bits = typename Register<V, width>::Bits;          ///< the same as integers
  using M = Mask<V, N>;                                    ///< what comparisons give
  Lanes v[entries(parts)];                                 ///< the registers

  Pack() = default;
  /// The same in every lane.
  Pack(V x) {
    for (Lanes& part : v) part = x - Lanes{};  // (0 + x is not -0 for -0, and so an addition)
  }
  /// Every register k as f(k) says.
  template <class F>
  static Pack of(const F& f) {
    Pack p;
    for (int k = 0; k < parts; ++k) p.v[k] = f(k);
    return p;
  }
  /// From N numbers one after the other.
  static Pack load(const V* from) {
    return of([&](int k) { return *reinterpret_cast<const InMemory*>(from + k * width); });
  }
  /// To N numbers one after the other.
  void store(V* to) const {
    for (int k = 0; k < parts; ++k) *reinterpret_cast<InMemory*>(to + k * width) = v[k];
  }
  /// To a multiple of a register's size, past the caches where the target can; fence() before others read it.
  /// (Whole cache lines, 64 bytes, or it is slow.)
  void stream(V* to) const {
    for (int k = 0; k < parts; ++k) Best<V, N>::stream(to + k * width, v[k]);
  }
  /// One of its registers.
  Pack<V, width> part(int k) const {
    Pack<V, width> p;
    p.v[0] = v[k];
    return p;
  }
  /// One lane.
  V operator[](int lane) const { return v[lane / width][lane % width]; }
  /// Sets one lane.
  void set(int lane, V x) { v[lane / width][lane % width] = x; }

  // Lane by lane. (Doxygen does not read the macro.)
  /// @cond
#define MYOGROWTH_OPERATOR(Result, op, of_register)         \
  friend Result operator op(const Pack& a, const Pack& b) { \
    return Result::of([&](int k) { return of_register; });  \
  }
  MYOGROWTH_OPERATOR(Pack, +, a.v[k] + b.v[k])
  MYOGROWTH_OPERATOR(Pack, -, a.v[k] - b.v[k])
  MYOGROWTH_OPERATOR(Pack, *, a.v[k] * b.v[k])
  MYOGROWTH_OPERATOR(Pack, /, (divide<Best<V, N>, Accuracy::full>(a.v[k], b.v[k])))
  MYOGROWTH_OPERATOR(M, <, (Best<V, N>::less(a.v[k], b.v[k])))
  MYOGROWTH_OPERATOR(M, <=, (Best<V, N>::less_or_equal(a.v[k], b.v[k])))
  MYOGROWTH_OPERATOR(M, ==, (Best<V, N>::equal(a.v[k], b.v[k])))
#undef MYOGROWTH_OPERATOR
  friend M operator>(const Pack& a, const Pack& b) { return b < a; }
  friend M operator>=(const Pack& a, const Pack& b) { return b <= a; }
  friend Pack operator-(const Pack& a) {
    return of([&](int k) { return -a.v[k]; });
  }
  /// @endcond
};

/// a where the mask is true, else b.
template <class V, int N>
Pack<V, N> select(const Mask<V, N>& mask, const Pack<V, N>& a, const Pack<V, N>& b) {
  return Pack<V, N>::of([&](int k) { return Best<V, N>::choose(mask.v[k], a.v[k], b.v[k]); });
}
/// The smaller and the larger; b where either is NaN.
/// @{
template <class V, int N>
Pack<V, N> minimum(const Pack<V, N>& a, const Pack<V, N>& b) {
  return Pack<V, N>::of([&](int k) { return Best<V, N>::smaller(a.v[k], b.v[k]); });
}
template <class V, int N>
Pack<V, N> maximum(const Pack<V, N>& a, const Pack<V, N>& b) {
  return Pack<V, N>::of([&](int k) { return Best<V, N>::larger(a.v[k], b.v[k]); });
}
/// @}
/// The number without its sign.
template <class V, int N>
Pack<V, N> abs(const Pack<V, N>& a) {
  using Bits = typename Pack<V, N>::Bits;
  using Unsigned = typename Register<V, Pack<V, N>::width>::Unsigned;
  const Unsigned all_but_sign = static_cast<Unsigned>(~Unsigned(0) >> 1);
  return Pack<V, N>::of([&](int k) { return (typename Pack<V, N>::Lanes)((Bits)a.v[k] & all_but_sign); });
}
/// Square root of every lane, rounded correctly; within an ulp with AVX-512.
template <class V, int N>
Pack<V, N> sqrt(const Pack<V, N>& x) {
  return Pack<V, N>::of([&](int k) { return Best<V, N>::square_root(x.v[k]); });
}
/// a b + c, in one rounding where the target has that.
template <class V, int N>
Pack<V, N> multiply_add(const Pack<V, N>& a, const Pack<V, N>& b, const Pack<V, N>& c) {
  return Pack<V, N>::of([&](int k) { return Best<V, N>::fused(a.v[k], b.v[k], c.v[k]); });
}

/// The mask as it is. With -ffast-math a compiler would put !(a < b) as a >= b, which NaN does not pass.
template <class V, int N>
Mask<V, N> opaque(Mask<V, N> mask) {
  for (auto& part : mask.v) Best<V, N>::hide(part);
  return mask;
}
/// As for plain numbers (scalar.hpp). Only where a compiler needs it: it costs the batch 5 % with AVX2.
template <class V, int N>
Pack<V, N> rounded(Pack<V, N> a) {
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__clang__)
  for (auto& part : a.v) MYOGROWTH_OPAQUE(part);
#endif
  return a;
}
/// Where a number is ordinary, not NaN or infinite.
template <class V, int N>
Mask<V, N> is_finite(const Pack<V, N>& a) {
  return opaque(abs(rounded(a)) <= Pack<V, N>((std::numeric_limits<V>::max)()));
}
/// One bit a lane.
template <class V, int N>
unsigned bits(const Mask<V, N>& mask) {
  unsigned all = 0;
  for (int k = 0; k < mask.parts; ++k) all |= Best<V, N>::bits(mask.v[k]) << k * mask.width;
  return all;
}
/// Whether the mask is true in any lane.
template <class V, int N>
bool any(Mask<V, N> mask) {
  using Type = typename Mask<V, N>::Type;
  for (int k = 1; k < mask.parts; ++k) mask.v[0] = static_cast<Type>(mask.v[0] | mask.v[k]);
  return Best<V, N>::bits(mask.v[0]) != 0;
}

/// a/b to 12 digits (7 for float), where the target has that for less.
template <class V, int N>
Pack<V, N> near_quotient(const Pack<V, N>& a, const Pack<V, N>& b) {
  return Pack<V, N>::of([&](int k) { return divide<Best<V, N>, Accuracy::near_by>(a.v[k], b.v[k]); });
}
/// a/b to 8 digits (4 for float), where the target has that for less.
template <class V, int N>
Pack<V, N> rough_quotient(const Pack<V, N>& a, const Pack<V, N>& b) {
  return Pack<V, N>::of([&](int k) { return divide<Best<V, N>, Accuracy::rough>(a.v[k], b.v[k]); });
}
/// a/b, given per_b = 1/b: correctly rounded up to an ulp, where the target has fused operations for that.
template <class V, int N>
Pack<V, N> quotient(const Pack<V, N>& a, const Pack<V, N>& b, const Pack<V, N>& per_b) {
#if defined(__FMA__) || defined(__aarch64__)
  const Pack<V, N> q = a * per_b;
  return multiply_add(multiply_add(-b, q, a), per_b, q);
#else
  (void)per_b;
  return a / b;
#endif
}

namespace detail {

template <class V>
struct Format;
template <>
struct Format<double> {
  static constexpr int digits = 52, bias = 1023;
  static constexpr std::uint64_t one = 0x3ff0000000000000u, sqrt_half = 0x3fe6a09e667f3bcdu;
  static constexpr std::uint64_t magic = 0x4330000000000000u;  // 2^52: below it the digits are an integer
  static constexpr double ln2_high = 0.6931467056274414, ln2_low = 4.7493250390316723212e-7;
  static constexpr double least_exponent = -708, most_exponent = 709;
};
template <>
struct Format<float> {
  static constexpr int digits = 23, bias = 127;
  static constexpr std::uint32_t one = 0x3f800000u, sqrt_half = 0x3f3504f3u;
  static constexpr std::uint32_t magic = 0x4b000000u;
  static constexpr float ln2_high = 0.693359375f, ln2_low = -2.12194440e-4f;
  static constexpr float least_exponent = -87, most_exponent = 88;
};

/// The lanes 0, 2, ... of two registers by turns.
template <class L>
L evens(const L& a, const L& b) {
  if constexpr (sizeof a == 64) return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  if constexpr (sizeof a == 32) return __builtin_shufflevector(a, b, 0, 4, 2, 6);
  if constexpr (sizeof a == 16) return __builtin_shufflevector(a, b, 0, 2);
}
/// The lanes 1, 3, ... of two registers by turns.
template <class L>
L odds(const L& a, const L& b) {
  if constexpr (sizeof a == 64) return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  if constexpr (sizeof a == 32) return __builtin_shufflevector(a, b, 1, 5, 3, 7);
  if constexpr (sizeof a == 16) return __builtin_shufflevector(a, b, 1, 3);
}

template <class P>
P horner(const P& x, const double* c, int n) {
  using V = Real<P>;
  P sum(static_cast<V>(c[0]));
  for (int i = 1; i < n; ++i) sum = multiply_add(sum, x, P(static_cast<V>(c[i])));
  return sum;
}

/// Q(z) of LogarithmSeries.
template <class P>
P logarithm_series(const P& z) {
  using Q = LogarithmSeries;
  static constexpr double coefficients[] = {Q::q6, Q::q5, Q::q4, Q::q3, Q::q2, Q::q1, Q::q0};
  return horner(z, coefficients, 7);
}

/// The number with these bits, in one register.
template <class P>
P number(const typename P::Bits& bits) {
  P p;
  p.v[0] = (typename P::Lanes)bits;
  return p;
}

/// ln(u + error) for u normal and > 0, |error| below u's rounding; one register.
template <class V, int N>
typename Pack<V, N>::Lanes log_of_sum(const Pack<V, N>& u, const Pack<V, N>& error) {
  using P = Pack<V, N>;
  using F = Format<V>;
  using Bits = typename P::Bits;
  using Unsigned = typename Register<V, N>::Unsigned;
  // u = 2^k m, m in [sqrt(1/2), sqrt(2))
  const Bits u_bits = (Bits)u.v[0];
  const Bits exponent = (u_bits + (F::one - F::sqrt_half)) >> F::digits;  // k + bias
  const P m = number<P>(u_bits - ((exponent - static_cast<Unsigned>(F::bias)) << F::digits));
  const P shifted = number<P>(exponent | F::magic) - number<P>(Bits{} + F::magic);
  const P k = rounded(P(rounded(shifted) - P(V(F::bias))));
  const P per_2k = number<P>((static_cast<Unsigned>(2 * F::bias) - exponent) << F::digits);
  const P f = rounded(P(m - P(V(1)))) + error * per_2k;
  const P s = f / (P(V(2)) + f);
  const P z = s * s;
  const P half_square = P(V(0.5)) * f * f;
  const P r = z * logarithm_series(z);
  const P rest = half_square - (s * (half_square + r) + k * P(F::ln2_low));
  return (k * P(F::ln2_high) - (rest - f)).v[0];
}

/// e^x, or e^x - 1; one register.
template <bool less_one, class V, int N>
typename Pack<V, N>::Lanes exponential(const Pack<V, N>& x) {
  using P = Pack<V, N>;
  using F = Format<V>;
  using Bits = typename P::Bits;
  const P low(F::least_exponent), high(F::most_exponent);
  const P y = select(x < low, low, select(x > high, high, x));
  // Round to the nearest integer by adding a number whose last digit is 1.
  const P shift = number<P>(Bits{} + F::magic) * P(V(1.5));
  const P shifted = rounded(multiply_add(y, P(static_cast<V>(1.4426950408889634)), shift));
  const P k = shifted - shift;
  const P r = multiply_add(k, P(-F::ln2_low), multiply_add(k, P(-F::ln2_high), y));
  static constexpr double E[] = {2.5100385495510319078e-8,  2.7620088445409748161e-7,
                                 2.7557268459997064772e-6,  0.000024801521295954375131,
                                 0.00019841269863053616878, 0.0013888888917213716901,
                                 0.0083333333333300618325,  0.041666666666624127873,
                                 0.16666666666666667453,    0.50000000000000010221};
  const P one(V(1)), e_less_1 = multiply_add(r * r, horner(r, E, 10), r);
  const P two_k = number<P>(((Bits)shifted.v[0] << F::digits) + F::one);
  if (less_one) return select(x < low, -one, multiply_add(e_less_1, two_k, two_k - one)).v[0];
  return select(x < low, P(V(0)), (one + e_less_1) * two_k).v[0];
}

}  // namespace detail

/// ln(1 + x). Max error 1 ulp; valid range: x > -1 and 1 + x normal, below 0.7 of the largest number.
/// Elsewhere NaN or any number.
template <class V, int N>
Pack<V, N> log1p(const Pack<V, N>& x) {
  using P = Pack<V, N>;
  const P one(V(1));
  const P u = rounded(P(one + x));
  // What rounding took from the larger of the two.
  const P error = select(x < one, x - rounded(P(u - one)), one - rounded(P(u - x)));
  return P::of([&](int k) { return detail::log_of_sum(u.part(k), error.part(k)); });
}
/// ln(x). Max error 1 ulp; valid range: x > 0 normal, below 0.7 of the largest number. Elsewhere NaN or
/// any number.
template <class V, int N>
Pack<V, N> log(const Pack<V, N>& x) {
  const auto exact = Pack<V, N>(V(0)).part(0);
  return Pack<V, N>::of([&](int k) { return detail::log_of_sum(x.part(k), exact); });
}
/// e^x. Max error 1 ulp; valid range: all numbers. Where e^x is below the normal range it is 0; above x
/// = 709 (88 for float) it stays as it is there.
template <class V, int N>
Pack<V, N> exp(const Pack<V, N>& x) {
  return Pack<V, N>::of([&](int k) { return detail::exponential<false>(x.part(k)); });
}
/// e^x - 1. Max error 2.5 ulp; valid range: all numbers. -1 where e^x is below the normal range; large x
/// as exp.
template <class V, int N>
Pack<V, N> expm1(const Pack<V, N>& x) {
  return Pack<V, N>::of([&](int k) { return detail::exponential<true>(x.part(k)); });
}
/// x^exponent, by logarithm and exponential. Max error 2 + |exponent ln x| times epsilon, relative; valid
/// range: x = 0 and normal x > 0 below 0.7 of the largest number, results in the normal range.
template <class V, int N>
Pack<V, N> pow(const Pack<V, N>& x, V exponent) {
  using P = Pack<V, N>;
  const P zero(V(0)), one(V(1));
  if (exponent == 0) return one;
  const auto positive = x > zero;
  return select(positive, exp(log(select(positive, x, one)) * P(exponent)), zero);
}
/// ln(1 + d/G) for x = d/G, by the series only where that is enough (scalar.hpp). Max error 1.5 ulp; valid
/// range as log1p's.
template <class V, int N>
Pack<V, N> ln_1_plus(const Pack<V, N>& x, const Pack<V, N>& d, const Pack<V, N>& G) {
  using P = Pack<V, N>;
  const P s = d / (G + G + d), z = s * s, half_square = P(V(0.5)) * x * x;
  const P correction =
      multiply_add(-s, multiply_add(z, detail::logarithm_series(z), half_square), half_square);
  const P y = x - correction;
  const auto outside = !((x > P(V(-0.29))) & (x < P(V(0.41))));
  return any(outside) ? select(outside, log1p(x), y) : y;
}

/// Whether a register of such packs can be turned, from numbers that lie side by side and to them.
template <class V, int N>
constexpr bool turns = sizeof(V) == 8 && N == native_lanes<V>;
/// Four numbers side by side at from + i * step to lane i of four packs of one register.
template <class V, int N, class From>
void load_side_by_side(Pack<V, N> (&p)[4], const From* from, std::ptrdiff_t step) {
  static_assert(turns<V, N>, "has no such registers");
  using L = typename Pack<V, N>::Lanes;
  if constexpr (N == 2) {
    for (int c = 0; c < 4; c += 2) {
      const L a = Pack<V, N>::load(from + c).v[0], b = Pack<V, N>::load(from + c + step).v[0];
      p[c].v[0] = __builtin_shufflevector(a, b, 0, 2);
      p[c + 1].v[0] = __builtin_shufflevector(a, b, 1, 3);
    }
  } else {
    const auto four = [&](int i) {
      return *reinterpret_cast<const typename Register<V, 4>::InMemory*>(from + i * step);
    };
    const auto point = [&](int i) -> L {
      if constexpr (N == 8) {
        return __builtin_shufflevector(four(i), four(i + 4), 0, 1, 2, 3, 4, 5, 6, 7);
      } else {
        return four(i);
      }
    };
    const auto two = [&](const L& ab, const L& cd, int c) {
      if constexpr (N == 8) {
        p[c].v[0] = __builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13);
        p[c + 2].v[0] = __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15);
      } else {
        p[c].v[0] = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
        p[c + 2].v[0] = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
      }
    };
    const L a = point(0), b = point(1), c = point(2), d = point(3);
    two(detail::evens(a, b), detail::evens(c, d), 0);
    two(detail::odds(a, b), detail::odds(c, d), 1);
  }
}
/// And back.
template <class V, int N>
void store_side_by_side(const Pack<V, N> (&p)[4], V* to, std::ptrdiff_t step) {
  static_assert(turns<V, N>, "has no such registers");
  using L = typename Pack<V, N>::Lanes;
  const L &a = p[0].v[0], &b = p[1].v[0], &c = p[2].v[0], &d = p[3].v[0];
  const auto store = [&](std::ptrdiff_t at, const auto& lanes) {
    *reinterpret_cast<typename Register<V, sizeof lanes / sizeof(V)>::InMemory*>(to + at) = lanes;
  };
  const auto two = [&](const L& ab, const L& cd, int i) {
    if constexpr (N == 8) {
      const L first = __builtin_shufflevector(ab, cd, 0, 1, 8, 9, 2, 3, 10, 11);
      const L last = __builtin_shufflevector(ab, cd, 4, 5, 12, 13, 6, 7, 14, 15);
      store(i * step, __builtin_shufflevector(first, first, 0, 1, 2, 3));
      store((i + 2) * step, __builtin_shufflevector(first, first, 4, 5, 6, 7));
      store((i + 4) * step, __builtin_shufflevector(last, last, 0, 1, 2, 3));
      store((i + 6) * step, __builtin_shufflevector(last, last, 4, 5, 6, 7));
    } else if constexpr (N == 4) {
      store(i * step, __builtin_shufflevector(ab, cd, 0, 1, 4, 5));
      store((i + 2) * step, __builtin_shufflevector(ab, cd, 2, 3, 6, 7));
    } else {
      store(i * step, ab);
      store(i * step + 2, cd);
    }
  };
  two(detail::evens(a, b), detail::evens(c, d), 0);
  two(detail::odds(a, b), detail::odds(c, d), 1);
}

/// Whether a term with this factor can be left out: packs never look. Both ways would end in the same stores,
/// which g++ then puts off until all that is stored has gone through the stack.
template <class V, int N>
constexpr bool is_zero(const Pack<V, N>&) {
  return false;
}

/// The number type under a pack. Not defined: a pack has no one value.
template <class V, int N>
V value(const Pack<V, N>&);
/// What comparisons are made of: the pack as it is.
template <class V, int N>
const Pack<V, N>& deciding(const Pack<V, N>& x) {
  return x;
}
/// Where x > 0 is so small that the fast division by 1/x has left its range.
template <class V, int N>
Mask<V, N> beyond_reciprocals(const Pack<V, N>& x) {
  constexpr V epsilon = last_place<V>();
  return !(x > Pack<V, N>(1 / ((std::numeric_limits<V>::max)() * epsilon * epsilon)));
}

}  // namespace simd
}  // namespace myogrowth

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#endif
