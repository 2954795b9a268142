/// @file
/// A vector of numbers as a scalar: what the law asks of its number type (scalar.hpp), lane by lane.
///
/// Pack<V, N> is N lanes of float or double in one SIMD register of whatever the compiler targets, by the
/// vector extensions of g++ and clang. Every operation treats each lane on its own, so a lane's result
/// depends neither on its place nor on its neighbours. Comparisons give a mask for `select` and `any`;
/// `value` names the type alone, since many lanes have no one value to branch on.
#ifndef MYOGROWTH_SIMD_HPP
#define MYOGROWTH_SIMD_HPP

#include <cstdint>
#include <cstring>

#include "scalar.hpp"

#if defined(__AVX512F__) || defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace myogrowth {
namespace simd {

/// Registers of N lanes of V, of N integers of the same size, and the constants of V's format. (g++ 12 takes
/// vector_size with sizes that depend on a template for scalars, hence the list.)
template <class V, int N>
struct Register;
#define MYOGROWTH_REGISTER(V, Integer, N)                                 \
  template <>                                                             \
  struct Register<V, N> {                                                 \
    typedef V Lanes __attribute__((vector_size(sizeof(V) * N)));          \
    typedef Integer Integers __attribute__((vector_size(sizeof(V) * N))); \
    using Unsigned = std::make_unsigned_t<Integer>;                       \
    typedef Unsigned Bits __attribute__((vector_size(sizeof(V) * N)));    \
  };
MYOGROWTH_REGISTER(double, std::int64_t, 2)
MYOGROWTH_REGISTER(double, std::int64_t, 4)
MYOGROWTH_REGISTER(double, std::int64_t, 8)
MYOGROWTH_REGISTER(float, std::int32_t, 4)
MYOGROWTH_REGISTER(float, std::int32_t, 8)
MYOGROWTH_REGISTER(float, std::int32_t, 16)
#undef MYOGROWTH_REGISTER

/// Bytes of the widest register that the compiler may use here.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
constexpr int register_bytes = 64;
#elif defined(__AVX2__)
constexpr int register_bytes = 32;
#else
constexpr int register_bytes = 16;
#endif
/// How many lanes of V that is.
template <class V>
constexpr int native_lanes = register_bytes / static_cast<int>(sizeof(V));

/// True or false in every lane: all bits of an integer of V's size.
template <class V, int N>
struct Mask {
  typename Register<V, N>::Integers v;
};

/// N lanes of V.
template <class V, int N>
struct Pack {
  using Lanes = typename Register<V, N>::Lanes;
  Lanes v;

  Pack() = default;
  Pack(Lanes lanes) : v(lanes) {}
  /// The same in every lane.
  Pack(V x) : v(Lanes{} + x) {}

  /// From and to N numbers one after the other.
  static Pack load(const V* from) {
    Pack p;
    std::memcpy(&p.v, from, sizeof p.v);
    return p;
  }
  void store(V* to) const { std::memcpy(to, &v, sizeof v); }
  V operator[](int lane) const { return v[lane]; }
  void set(int lane, V x) { v[lane] = x; }

  friend Pack operator+(const Pack& a, const Pack& b) { return Pack(Lanes(a.v + b.v)); }
  friend Pack operator-(const Pack& a, const Pack& b) { return Pack(Lanes(a.v - b.v)); }
  friend Pack operator*(const Pack& a, const Pack& b) { return Pack(Lanes(a.v * b.v)); }
  friend Pack operator/(const Pack& a, const Pack& b) { return divide(a, b); }
  friend Pack operator-(const Pack& a) { return Pack(Lanes(-a.v)); }
  friend Mask<V, N> operator<(const Pack& a, const Pack& b) { return {a.v < b.v}; }
  friend Mask<V, N> operator>(const Pack& a, const Pack& b) { return {a.v > b.v}; }
  friend Mask<V, N> operator<=(const Pack& a, const Pack& b) { return {a.v <= b.v}; }
  friend Mask<V, N> operator>=(const Pack& a, const Pack& b) { return {a.v >= b.v}; }
  friend Mask<V, N> operator==(const Pack& a, const Pack& b) { return {a.v == b.v}; }
};

template <class V, int N>
Mask<V, N> operator&(const Mask<V, N>& a, const Mask<V, N>& b) {
  return {a.v & b.v};
}
template <class V, int N>
Mask<V, N> operator|(const Mask<V, N>& a, const Mask<V, N>& b) {
  return {a.v | b.v};
}
template <class V, int N>
Mask<V, N> operator!(const Mask<V, N>& a) {
  return {~a.v};
}

/// a where the mask is true, else b.
template <class V, int N>
Pack<V, N> select(const Mask<V, N>& mask, const Pack<V, N>& a, const Pack<V, N>& b) {
  return Pack<V, N>(mask.v ? a.v : b.v);
}

/// One bit a lane.
template <class V, int N>
unsigned bits(const Mask<V, N>& mask) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof mask.v == 64 && sizeof(V) == 8) return _mm512_movepi64_mask((__m512i)mask.v);
  if constexpr (sizeof mask.v == 64 && sizeof(V) == 4) return _mm512_movepi32_mask((__m512i)mask.v);
#endif
#if defined(__AVX__)
  if constexpr (sizeof mask.v == 32 && sizeof(V) == 8)
    return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask.v));
  if constexpr (sizeof mask.v == 32 && sizeof(V) == 4)
    return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask.v));
#endif
#if defined(__SSE2__)
  if constexpr (sizeof mask.v == 16 && sizeof(V) == 8)
    return static_cast<unsigned>(_mm_movemask_pd((__m128d)mask.v));
  if constexpr (sizeof mask.v == 16 && sizeof(V) == 4)
    return static_cast<unsigned>(_mm_movemask_ps((__m128)mask.v));
#endif
  unsigned all = 0;
  for (int i = 0; i < N; ++i) all |= (mask.v[i] != 0 ? 1u : 0u) << i;
  return all;
}
/// Whether the mask is true in any lane.
template <class V, int N>
bool any(const Mask<V, N>& mask) {
  return bits(mask) != 0;
}

/// a b + c, in one rounding where the target has that.
template <class V, int N>
Pack<V, N> multiply_add(const Pack<V, N>& a, const Pack<V, N>& b, const Pack<V, N>& c) {
#if defined(__AVX512F__)
  if constexpr (sizeof a.v == 64 && sizeof(V) == 8)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm512_fmadd_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
  if constexpr (sizeof a.v == 64 && sizeof(V) == 4)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm512_fmadd_ps((__m512)a.v, (__m512)b.v, (__m512)c.v));
#endif
  return a * b + c;
}

/// a/b, correctly rounded up to an ulp. AVX-512's division takes as long as thirty multiplications, so there
/// it is an approximate reciprocal, two Newton steps and a correction of the quotient; a divisor of 0,
/// infinity or beyond the reciprocal's range gives NaN or infinity.
template <class V, int N>
Pack<V, N> divide(const Pack<V, N>& a, const Pack<V, N>& b) {
#if defined(__AVX512F__)
  if constexpr (sizeof a.v == 64) {
    using P = Pack<V, N>;
    P r;
    // (Masked with all lanes on: g++ 12 warns of the unmasked forms in its own header.)
    // (Masked with all lanes on: g++ 12 warns of the unmasked forms in its own header.)
    if constexpr (sizeof(V) == 8)
      r.v = (typename P::Lanes)_mm512_maskz_rcp14_pd(0xff, (__m512d)b.v);
    else
      r.v = (typename P::Lanes)_mm512_maskz_rcp14_ps(0xffff, (__m512)b.v);
    const P one(V(1));
    r = multiply_add(r, multiply_add(-b, r, one), r);
    if constexpr (sizeof(V) == 8) r = multiply_add(r, multiply_add(-b, r, one), r);
    const P quotient = a * r;
    return multiply_add(r, multiply_add(-b, quotient, a), quotient);
  }
#endif
  return Pack<V, N>(typename Pack<V, N>::Lanes(a.v / b.v));
}

template <class V, int N>
Pack<V, N> sqrt(const Pack<V, N>& x) {
#if defined(__AVX512F__)
  if constexpr (sizeof x.v == 64 && sizeof(V) == 8)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm512_maskz_sqrt_pd(0xff, (__m512d)x.v));
  if constexpr (sizeof x.v == 64 && sizeof(V) == 4)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm512_maskz_sqrt_ps(0xffff, (__m512)x.v));
#endif
#if defined(__AVX__)
  if constexpr (sizeof x.v == 32 && sizeof(V) == 8)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm256_sqrt_pd((__m256d)x.v));
  if constexpr (sizeof x.v == 32 && sizeof(V) == 4)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm256_sqrt_ps((__m256)x.v));
#endif
#if defined(__SSE2__)
  if constexpr (sizeof x.v == 16 && sizeof(V) == 8)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm_sqrt_pd((__m128d)x.v));
  if constexpr (sizeof x.v == 16 && sizeof(V) == 4)
    return Pack<V, N>((typename Pack<V, N>::Lanes)_mm_sqrt_ps((__m128)x.v));
#elif defined(__aarch64__)
  if constexpr (sizeof x.v == 16 && sizeof(V) == 8)
    return Pack<V, N>((typename Pack<V, N>::Lanes)vsqrtq_f64((float64x2_t)x.v));
  if constexpr (sizeof x.v == 16 && sizeof(V) == 4)
    return Pack<V, N>((typename Pack<V, N>::Lanes)vsqrtq_f32((float32x4_t)x.v));
#endif
  Pack<V, N> y;
  for (int i = 0; i < N; ++i) y.v[i] = std::sqrt(x.v[i]);
  return y;
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

template <class P>
P horner(const P& x, const double* c, int n) {
  using V = Real<P>;
  P sum(static_cast<V>(c[0]));
  for (int i = 1; i < n; ++i) sum = multiply_add(sum, x, P(static_cast<V>(c[i])));
  return sum;
}

/// ln(u + error) for u normal and > 0, |error| below u's rounding.
template <class V, int N>
Pack<V, N> log_of_sum(const Pack<V, N>& u, const Pack<V, N>& error) {
  using P = Pack<V, N>;
  using R = Register<V, N>;
  using F = Format<V>;
  using Bits = typename R::Bits;
  // u = 2^k m, m in [sqrt(1/2), sqrt(2))
  const Bits u_bits = (Bits)u.v;
  const Bits exponent = (u_bits + (F::one - F::sqrt_half)) >> F::digits;  // k + bias
  const Bits m_bits = u_bits - ((exponent - static_cast<typename R::Unsigned>(F::bias)) << F::digits);
  const P k = P((typename P::Lanes)(Bits)(exponent | F::magic)) -
              P((typename P::Lanes)(Bits)(Bits{} + F::magic)) - P(V(F::bias));
  const P per_2k =
      P((typename P::Lanes)(Bits)((static_cast<typename R::Unsigned>(2 * F::bias) - exponent) << F::digits));
  const P f = (P((typename P::Lanes)m_bits) - P(V(1))) + error * per_2k;
  // ln(1 + f) = 2 artanh(s) = f - (f^2/2 - s (f^2/2 + z Q(z))); Q by Chebyshev interpolation, error 3e-16
  static constexpr double Q[] = {0.14616585424888621989, 0.15331710618210771568, 0.18182889455674946039,
                                 0.22222211130259877029, 0.28571428626003268742, 0.39999999999899443233,
                                 0.66666666666666696883};
  const P s = f / (P(V(2)) + f);
  const P z = s * s;
  const P half_square = P(V(0.5)) * f * f;
  const P r = z * horner(z, Q, 7);
  const P small = half_square - (s * (half_square + r) + k * P(F::ln2_low));
  return k * P(F::ln2_high) - (small - f);
}

}  // namespace detail

/// ln(1 + x); x > -1 and 1 + x normal, else NaN or some finite number is what comes.
template <class V, int N>
Pack<V, N> log1p(const Pack<V, N>& x) {
  using P = Pack<V, N>;
  const P one(V(1));
  const P u = one + x;
  // What rounding took from the larger of the two.
  const P error = select(x < one, x - (u - one), one - (u - x));
  return detail::log_of_sum(u, error);
}

/// ln(x), x normal and > 0.
template <class V, int N>
Pack<V, N> log(const Pack<V, N>& x) {
  return detail::log_of_sum(x, Pack<V, N>(V(0)));
}

/// e^x; 0 where that is below the normal range, and no more than the largest power of 2 above it.
template <class V, int N>
Pack<V, N> exp(const Pack<V, N>& x) {
  using P = Pack<V, N>;
  using F = detail::Format<V>;
  using Bits = typename Register<V, N>::Bits;
  const P low(F::least_exponent), high(F::most_exponent);
  const P y = select(x < low, low, select(x > high, high, x));
  // Round to the nearest integer by adding a number whose last digit is 1.
  const P shift = P((typename P::Lanes)(Bits)(Bits{} + F::magic)) * P(V(1.5));
  const P shifted = multiply_add(y, P(static_cast<V>(1.4426950408889634)), shift);
  const P k = shifted - shift;
  const P r = multiply_add(k, P(-F::ln2_low), multiply_add(k, P(-F::ln2_high), y));
  static constexpr double E[] = {2.5100385495510319078e-8,  2.7620088445409748161e-7,
                                 2.7557268459997064772e-6,  0.000024801521295954375131,
                                 0.00019841269863053616878, 0.0013888888917213716901,
                                 0.0083333333333300618325,  0.041666666666624127873,
                                 0.16666666666666667453,    0.50000000000000010221};
  const P e = P(V(1)) + multiply_add(r * r, detail::horner(r, E, 10), r);
  const P two_k((typename P::Lanes)(Bits)(((Bits)shifted.v << F::digits) + F::one));
  return select(x < low, P(V(0)), e * two_k);
}

/// x^exponent for x >= 0 by logarithm and exponential; the relative error grows like |exponent ln x|.
template <class V, int N>
Pack<V, N> pow(const Pack<V, N>& x, V exponent) {
  using P = Pack<V, N>;
  const P zero(V(0)), one(V(1));
  if (exponent == 0) return one;
  const auto positive = x > zero;
  return select(positive, exp(log(select(positive, x, one)) * P(exponent)), zero);
}

/// Whether nothing is carried in any lane.
template <class V, int N>
bool is_zero(const Pack<V, N>& x) {
  return !any(!(x == Pack<V, N>(V(0))));
}

/// The number type under a pack. Not defined: a pack has no one value.
template <class V, int N>
V value(const Pack<V, N>&);

}  // namespace simd
}  // namespace myogrowth

#endif
