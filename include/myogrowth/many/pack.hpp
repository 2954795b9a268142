/// @file
/// A vector of numbers as a scalar: what the law asks of its number type (scalar.hpp), lane by lane.
///
/// Pack<V, N> is N lanes of float or double in one SIMD register of whatever the compiler targets, by the
/// vector extensions of g++ and clang. Every operation treats each lane on its own, so a lane's result
/// depends neither on its place nor on its neighbours. Comparisons give a mask for `select` and `any`;
/// `value` names the type alone, since many lanes have no one value to branch on.
#ifndef MYOGROWTH_MANY_PACK_HPP
#define MYOGROWTH_MANY_PACK_HPP

#include <cstdint>
#include <limits>

#include "../scalar.hpp"

#if defined(__AVX512F__) || defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

/// MYOGROWTH_OPAQUE for a register of a mask.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define MYOGROWTH_OPAQUE_MASK(x)  \
  do {                            \
    if constexpr (sizeof(x) <= 2) \
      __asm__("" : "+k"(x));      \
    else                          \
      MYOGROWTH_OPAQUE(x);        \
  } while (false)
#else
#define MYOGROWTH_OPAQUE_MASK(x) MYOGROWTH_OPAQUE(x)
#endif

// Of registers, g++ and clang have no other cast.
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif

namespace myogrowth {
namespace simd {

/// Registers of N lanes of V (`InMemory`: wherever V may lie), of N integers of the same size, and the
/// constants of V's format. (g++ 12 takes vector_size with sizes that depend on a template for scalars, hence
/// the list.)
template <class V, int N>
struct Register;
/// @cond
#define MYOGROWTH_REGISTER(V, Integer, N)                                                          \
  template <>                                                                                      \
  struct Register<V, N> {                                                                          \
    typedef V Lanes __attribute__((vector_size(sizeof(V) * N)));                                   \
    typedef V InMemory __attribute__((vector_size(sizeof(V) * N), aligned(sizeof(V)), may_alias)); \
    typedef Integer Integers __attribute__((vector_size(sizeof(V) * N)));                          \
    using Unsigned = std::make_unsigned_t<Integer>;                                                \
    typedef Unsigned Bits __attribute__((vector_size(sizeof(V) * N)));                             \
  };
MYOGROWTH_REGISTER(double, std::int64_t, 2)
MYOGROWTH_REGISTER(double, std::int64_t, 4)
MYOGROWTH_REGISTER(double, std::int64_t, 8)
MYOGROWTH_REGISTER(float, std::int32_t, 4)
MYOGROWTH_REGISTER(float, std::int32_t, 8)
MYOGROWTH_REGISTER(float, std::int32_t, 16)
#undef MYOGROWTH_REGISTER
/// @endcond

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

/// Lets what was streamed be seen before what is written from here on.
inline void fence() {
#if defined(__SSE2__)
  _mm_sfence();
#endif
}

/// True or false in every lane of a register: all bits of an integer of V's size; with AVX-512 one bit, in a
/// mask register. (g++ 12 takes vectors of such integers apart, bit by bit, when they meet.)
template <class V, int width>
struct MaskRegister {
  using Type = typename Register<V, width>::Integers;  ///< the bits
};
/// @cond
#if defined(__AVX512F__) && defined(__AVX512DQ__)
template <>
struct MaskRegister<double, 8> {
  using Type = __mmask8;
};
template <>
struct MaskRegister<float, 16> {
  using Type = __mmask16;
};
#endif
/// @endcond

/// True or false in every lane.
template <class V, int N>
struct Mask {
  static constexpr int width = N < native_lanes<V> ? N : native_lanes<V>;  ///< lanes of a register
  static constexpr int parts = N / width;                                  ///< registers
  using Type = typename MaskRegister<V, width>::Type;                      ///< a register's
  Type v[entries(parts)];                                                  ///< of the registers
};

// What a target with mask registers has and the vector extensions have not: comparisons and the choice.
namespace detail {

enum class Relation { less, less_or_equal, equal };
template <Relation relation, class Type, class L, class V>
Type compare(const L& a, const L& b, V) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  constexpr int code = relation == Relation::less            ? _CMP_LT_OQ
                       : relation == Relation::less_or_equal ? _CMP_LE_OQ
                                                             : _CMP_EQ_OQ;
  if constexpr (sizeof(L) == 64 && sizeof(V) == 8)
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, code);
  else if constexpr (sizeof(L) == 64)
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, code);
  else
#endif
      if constexpr (relation == Relation::less)
    return a < b;
  else if constexpr (relation == Relation::less_or_equal)
    return a <= b;
  else
    return a == b;
}
template <class Type, class L, class V>
L choose(const Type& mask, const L& a, const L& b, V) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(L) == 64 && sizeof(V) == 8)
    return (L)_mm512_mask_blend_pd(mask, (__m512d)b, (__m512d)a);
  else if constexpr (sizeof(L) == 64)
    return (L)_mm512_mask_blend_ps(mask, (__m512)b, (__m512)a);
  else
#endif
    return mask ? a : b;
}
template <class L, class V>
L smaller(const L& a, const L& b, V) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(L) == 64 && sizeof(V) == 8)
    return (L)_mm512_maskz_min_pd(0xff, (__m512d)a, (__m512d)b);
  else if constexpr (sizeof(L) == 64)
    return (L)_mm512_maskz_min_ps(0xffff, (__m512)a, (__m512)b);
  else
#endif
    return a < b ? a : b;
}
template <class L, class V>
L larger(const L& a, const L& b, V) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(L) == 64 && sizeof(V) == 8)
    return (L)_mm512_maskz_max_pd(0xff, (__m512d)a, (__m512d)b);
  else if constexpr (sizeof(L) == 64)
    return (L)_mm512_maskz_max_ps(0xffff, (__m512)a, (__m512)b);
  else
#endif
    return a > b ? a : b;
}

}  // namespace detail

/// N lanes of V, in one register or in several side by side, whose operations hide each other's latency.
template <class V, int N>
struct Pack {
  static constexpr int width = N < native_lanes<V> ? N : native_lanes<V>;  ///< lanes of a register
  static constexpr int parts = N / width;                                  ///< registers
  using Lanes = typename Register<V, width>::Lanes;                        ///< a register
  using InMemory = typename Register<V, width>::InMemory;                  ///< the same, wherever it lies
  Lanes v[entries(parts)];                                                 ///< the registers

  Pack() = default;
  /// The same in every lane.
  Pack(V x) {
    for (Lanes& part : v) part = x - Lanes{};  // (0 + x is not -0 for -0, and so an addition)
  }

  /// From N numbers one after the other.
  static Pack load(const V* from) {
    Pack p;
    for (int k = 0; k < parts; ++k) p.v[k] = *reinterpret_cast<const InMemory*>(from + k * width);
    return p;
  }
  /// To N numbers one after the other.
  void store(V* to) const {
    for (int k = 0; k < parts; ++k) *reinterpret_cast<InMemory*>(to + k * width) = v[k];
  }
  /// To a multiple of a register's size, past the caches where the target can; fence() before others read it.
  /// (Whole cache lines, 64 bytes, or it is slow.)
  void stream(V* to) const {
#if defined(__SSE2__)
    for (int k = 0; k < parts; ++k) {
      void* const at = to + k * width;
#if defined(__AVX512F__) && defined(__AVX512DQ__)
      if constexpr (sizeof v[0] == 64) _mm512_stream_si512(static_cast<__m512i*>(at), (__m512i)v[k]);
#endif
#if defined(__AVX__)
      if constexpr (sizeof v[0] == 32) _mm256_stream_si256(static_cast<__m256i*>(at), (__m256i)v[k]);
#endif
      if constexpr (sizeof v[0] == 16) _mm_stream_si128(static_cast<__m128i*>(at), (__m128i)v[k]);
    }
#else
    store(to);
#endif
  }
  /// One lane.
  V operator[](int lane) const { return v[lane / width][lane % width]; }
  /// Sets one lane.
  void set(int lane, V x) { v[lane / width][lane % width] = x; }
  /// One of its registers.
  Pack<V, width> part(int k) const {
    Pack<V, width> p;
    p.v[0] = v[k];
    return p;
  }

  /// Lane by lane.
  /// @{
  friend Pack operator+(const Pack& a, const Pack& b) {
    Pack c;
    for (int k = 0; k < parts; ++k) c.v[k] = a.v[k] + b.v[k];
    return c;
  }
  friend Pack operator-(const Pack& a, const Pack& b) {
    Pack c;
    for (int k = 0; k < parts; ++k) c.v[k] = a.v[k] - b.v[k];
    return c;
  }
  friend Pack operator*(const Pack& a, const Pack& b) {
    Pack c;
    for (int k = 0; k < parts; ++k) c.v[k] = a.v[k] * b.v[k];
    return c;
  }
  friend Pack operator/(const Pack& a, const Pack& b) {
    Pack c;
    for (int k = 0; k < parts; ++k) c.v[k] = divide(a.part(k), b.part(k));
    return c;
  }
  friend Pack operator-(const Pack& a) {
    Pack c;
    for (int k = 0; k < parts; ++k) c.v[k] = -a.v[k];
    return c;
  }
  friend Mask<V, N> operator<(const Pack& a, const Pack& b) { return compare<detail::Relation::less>(a, b); }
  friend Mask<V, N> operator<=(const Pack& a, const Pack& b) {
    return compare<detail::Relation::less_or_equal>(a, b);
  }
  friend Mask<V, N> operator==(const Pack& a, const Pack& b) {
    return compare<detail::Relation::equal>(a, b);
  }
  friend Mask<V, N> operator>(const Pack& a, const Pack& b) { return b < a; }
  friend Mask<V, N> operator>=(const Pack& a, const Pack& b) { return b <= a; }
  /// @}

 private:
  template <detail::Relation relation>
  static Mask<V, N> compare(const Pack& a, const Pack& b) {
    Mask<V, N> m;
    for (int k = 0; k < parts; ++k)
      m.v[k] = detail::compare<relation, typename Mask<V, N>::Type>(a.v[k], b.v[k], V());
    return m;
  }
};

/// Lane by lane.
/// @{
template <class V, int N>
Mask<V, N> operator&(const Mask<V, N>& a, const Mask<V, N>& b) {
  Mask<V, N> m;
  for (int k = 0; k < m.parts; ++k) m.v[k] = static_cast<typename Mask<V, N>::Type>(a.v[k] & b.v[k]);
  return m;
}
template <class V, int N>
Mask<V, N> operator|(const Mask<V, N>& a, const Mask<V, N>& b) {
  Mask<V, N> m;
  for (int k = 0; k < m.parts; ++k) m.v[k] = static_cast<typename Mask<V, N>::Type>(a.v[k] | b.v[k]);
  return m;
}
template <class V, int N>
Mask<V, N> operator!(const Mask<V, N>& a) {
  Mask<V, N> m;
  for (int k = 0; k < m.parts; ++k) m.v[k] = static_cast<typename Mask<V, N>::Type>(~a.v[k]);
  return m;
}
/// @}

/// a where the mask is true, else b.
template <class V, int N>
Pack<V, N> select(const Mask<V, N>& mask, const Pack<V, N>& a, const Pack<V, N>& b) {
  Pack<V, N> c;
  for (int k = 0; k < c.parts; ++k) c.v[k] = detail::choose(mask.v[k], a.v[k], b.v[k], V());
  return c;
}

/// The smaller and the larger; b where either is NaN.
/// @{
template <class V, int N>
Pack<V, N> minimum(const Pack<V, N>& a, const Pack<V, N>& b) {
  Pack<V, N> c;
  for (int k = 0; k < c.parts; ++k) c.v[k] = detail::smaller(a.v[k], b.v[k], V());
  return c;
}
template <class V, int N>
Pack<V, N> maximum(const Pack<V, N>& a, const Pack<V, N>& b) {
  Pack<V, N> c;
  for (int k = 0; k < c.parts; ++k) c.v[k] = detail::larger(a.v[k], b.v[k], V());
  return c;
}
/// @}

/// The number without its sign.
template <class V, int N>
Pack<V, N> abs(const Pack<V, N>& a) {
  using Bits = typename Register<V, Pack<V, N>::width>::Bits;
  using Unsigned = typename Register<V, Pack<V, N>::width>::Unsigned;
  Pack<V, N> b;
  for (int k = 0; k < b.parts; ++k)
    b.v[k] = (typename Pack<V, N>::Lanes)((Bits)a.v[k] & static_cast<Unsigned>(~Unsigned(0) >> 1));
  return b;
}

/// The mask as it is. With -ffast-math a compiler would put !(a < b) as a >= b, which NaN does not pass.
template <class V, int N>
Mask<V, N> opaque(Mask<V, N> mask) {
  for (auto& part : mask.v) MYOGROWTH_OPAQUE_MASK(part);
  return mask;
}
/// As for plain numbers (scalar.hpp).
template <class V, int N>
Pack<V, N> rounded(Pack<V, N> a) {
  for (auto& part : a.v) MYOGROWTH_OPAQUE(part);
  return a;
}
/// Where a number is ordinary, not NaN or infinite.
template <class V, int N>
Mask<V, N> is_finite(const Pack<V, N>& a) {
  return opaque(abs(rounded(a)) <= Pack<V, N>((std::numeric_limits<V>::max)()));
}

// The few operations that a target has and the vector extensions have not, for one register.
// (AVX-512's are masked with all lanes on: g++ 12 warns of the unmasked forms in its own header.)
namespace detail {

#if defined(__AVX512F__) && defined(__AVX512DQ__)
inline unsigned sign_bits(__mmask8 mask, std::integral_constant<int, 1>, double) { return mask; }
inline unsigned sign_bits(__mmask16 mask, std::integral_constant<int, 2>, float) { return mask; }
// 0 for 0, so that nothing below is 0 times infinity.
template <class L>
L rough_reciprocal_root(const L& v, double) {
  return (L)_mm512_maskz_rsqrt14_pd(_mm512_cmp_pd_mask((__m512d)v, _mm512_setzero_pd(), _CMP_NEQ_UQ),
                                    (__m512d)v);
}
template <class L>
L rough_reciprocal_root(const L& v, float) {
  return (L)_mm512_maskz_rsqrt14_ps(_mm512_cmp_ps_mask((__m512)v, _mm512_setzero_ps(), _CMP_NEQ_UQ),
                                    (__m512)v);
}
template <class L>
L rough_reciprocal(const L& v, double) {
  return (L)_mm512_maskz_rcp14_pd(0xff, (__m512d)v);
}
template <class L>
L rough_reciprocal(const L& v, float) {
  return (L)_mm512_maskz_rcp14_ps(0xffff, (__m512)v);
}
template <class L>
L fused(const L& a, const L& b, const L& c, double) {
  return (L)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
}
template <class L>
L fused(const L& a, const L& b, const L& c, float) {
  return (L)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
}
template <class L>
L fused_minus(const L& a, const L& b, const L& c, double) {  // c - a b
  return (L)_mm512_fnmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
}
template <class L>
L fused_minus(const L& a, const L& b, const L& c, float) {
  return (L)_mm512_fnmadd_ps((__m512)a, (__m512)b, (__m512)c);
}
// As divide() below, for the same reason; the root of 0 is 0.
template <class L, class V>
L square_root(const L& x, std::integral_constant<int, 64>, V) {
  const L one = L{} + V(1), half = L{} + V(0.5), three_eighths = L{} + V(0.375);
  const L y = rough_reciprocal_root(x, V());
  const L e = fused_minus(L(x * y), y, one, V());
  const L better = fused(L(y * e), sizeof(V) == 8 ? fused(e, three_eighths, half, V()) : half, y, V());
  const L root = x * better;
  return fused(fused_minus(root, root, x, V()), L(better * half), root, V());
}
#endif
#if defined(__AVX__)
template <class L>
unsigned sign_bits(const L& v, std::integral_constant<int, 32>, double) {
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)v));
}
template <class L>
unsigned sign_bits(const L& v, std::integral_constant<int, 32>, float) {
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)v));
}
template <class L>
L square_root(const L& v, std::integral_constant<int, 32>, double) {
  return (L)_mm256_sqrt_pd((__m256d)v);
}
template <class L>
L square_root(const L& v, std::integral_constant<int, 32>, float) {
  return (L)_mm256_sqrt_ps((__m256)v);
}
#endif
#if defined(__SSE2__)
template <class L>
unsigned sign_bits(const L& v, std::integral_constant<int, 16>, double) {
  return static_cast<unsigned>(_mm_movemask_pd((__m128d)v));
}
template <class L>
unsigned sign_bits(const L& v, std::integral_constant<int, 16>, float) {
  return static_cast<unsigned>(_mm_movemask_ps((__m128)v));
}
template <class L>
L square_root(const L& v, std::integral_constant<int, 16>, double) {
  return (L)_mm_sqrt_pd((__m128d)v);
}
template <class L>
L square_root(const L& v, std::integral_constant<int, 16>, float) {
  return (L)_mm_sqrt_ps((__m128)v);
}
#else
template <class L, class V>
unsigned sign_bits(const L& v, std::integral_constant<int, 16>, V) {
  unsigned all = 0;
  for (int i = 0; i < static_cast<int>(sizeof(L) / sizeof(V)); ++i) all |= (v[i] < 0 ? 1u : 0u) << i;
  return all;
}
#if defined(__aarch64__)
template <class L>
L square_root(const L& v, std::integral_constant<int, 16>, double) {
  return (L)vsqrtq_f64((float64x2_t)v);
}
template <class L>
L square_root(const L& v, std::integral_constant<int, 16>, float) {
  return (L)vsqrtq_f32((float32x4_t)v);
}
#else
template <class L, class V>
L square_root(L v, std::integral_constant<int, 16>, V) {
  for (int i = 0; i < static_cast<int>(sizeof(L) / sizeof(V)); ++i) v[i] = std::sqrt(v[i]);
  return v;
}
#endif
#endif

}  // namespace detail

/// One bit a lane.
template <class V, int N>
unsigned bits(const Mask<V, N>& mask) {
  unsigned all = 0;
  for (int k = 0; k < mask.parts; ++k) {
    all |= detail::sign_bits(mask.v[k], std::integral_constant<int, sizeof mask.v[0]>(), V())
           << k * mask.width;
  }
  return all;
}
/// Whether the mask is true in any lane.
template <class V, int N>
bool any(Mask<V, N> mask) {
  for (int k = 1; k < mask.parts; ++k)
    mask.v[0] = static_cast<typename Mask<V, N>::Type>(mask.v[0] | mask.v[k]);
  return detail::sign_bits(mask.v[0], std::integral_constant<int, sizeof mask.v[0]>(), V()) != 0;
}

namespace detail {

// Said to the compiler and not left to it: in a sum of two products it may fuse either, once so and once so.
template <class L>
L fused_if_it_can(const L& a, const L& b, const L& c, double) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(L) == 64) return fused(a, b, c, double());
#endif
#if defined(__FMA__)
  if constexpr (sizeof(L) == 32) return (L)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
  if constexpr (sizeof(L) == 16) return (L)_mm_fmadd_pd((__m128d)a, (__m128d)b, (__m128d)c);
#elif defined(__aarch64__)
  if constexpr (sizeof(L) == 16) return (L)vfmaq_f64((float64x2_t)c, (float64x2_t)a, (float64x2_t)b);
#endif
  return a * b + c;
}
template <class L>
L fused_if_it_can(const L& a, const L& b, const L& c, float) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof(L) == 64) return fused(a, b, c, float());
#endif
#if defined(__FMA__)
  if constexpr (sizeof(L) == 32) return (L)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
  if constexpr (sizeof(L) == 16) return (L)_mm_fmadd_ps((__m128)a, (__m128)b, (__m128)c);
#elif defined(__aarch64__)
  if constexpr (sizeof(L) == 16) return (L)vfmaq_f32((float32x4_t)c, (float32x4_t)a, (float32x4_t)b);
#endif
  return a * b + c;
}

}  // namespace detail

/// a b + c, in one rounding where the target has that.
template <class V, int N>
Pack<V, N> multiply_add(const Pack<V, N>& a, const Pack<V, N>& b, const Pack<V, N>& c) {
  Pack<V, N> d;
  for (int k = 0; k < d.parts; ++k) d.v[k] = detail::fused_if_it_can(a.v[k], b.v[k], c.v[k], V());
  return d;
}

/// a/b in one register, correctly rounded up to an ulp. AVX-512's division takes as long as thirty
/// multiplications, so there it is an approximate reciprocal, a step of Halley's method and a correction of
/// the quotient; a divisor of 0, infinity or beyond the reciprocal's range gives NaN or infinity.
template <class V, int N>
typename Pack<V, N>::Lanes divide(const Pack<V, N>& a, const Pack<V, N>& b) {
  static_assert(Pack<V, N>::parts == 1, "one register");
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof a.v[0] == 64) {
    using L = typename Pack<V, N>::Lanes;
    using detail::fused;
    using detail::fused_minus;
    const L one = Pack<V, N>(V(1)).v[0];
    L r = detail::rough_reciprocal(b.v[0], V());  // good to 14 bits
    const L e = fused_minus(b.v[0], r, one, V());
    r = sizeof(V) == 8 ? fused(r, fused(e, e, e, V()), r, V()) : fused(r, e, r, V());  // to 42, 28
    const L quotient = a.v[0] * r;
    return fused(fused_minus(b.v[0], quotient, a.v[0], V()), r, quotient, V());
  }
#endif
  return a.v[0] / b.v[0];
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

/// a/b to 12 digits (7 for float), where the target has that for less.
template <class V, int N>
Pack<V, N> near_quotient(const Pack<V, N>& a, const Pack<V, N>& b) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof a.v[0] == 64) {
    using detail::fused;
    const auto one = Pack<V, N>(V(1)).v[0];
    Pack<V, N> c;
    for (int k = 0; k < c.parts; ++k) {
      const auto r = detail::rough_reciprocal(b.v[k], V());  // good to 14 bits
      const auto e = detail::fused_minus(b.v[k], r, one, V()), ar = a.v[k] * r;
      c.v[k] = sizeof(V) == 8 ? fused(ar, fused(e, e, e, V()), ar, V()) : fused(ar, e, ar, V());  // to 42, 28
    }
    return c;
  }
#endif
  return a / b;
}

/// a/b to 8 digits (4 for float), where the target has that for less.
template <class V, int N>
Pack<V, N> rough_quotient(const Pack<V, N>& a, const Pack<V, N>& b) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (sizeof a.v[0] == 64) {
    const auto one = Pack<V, N>(V(1)).v[0];
    Pack<V, N> c;
    for (int k = 0; k < c.parts; ++k) {
      const auto r = detail::rough_reciprocal(b.v[k], V());
      const auto ar = a.v[k] * r;
      c.v[k] = sizeof(V) == 8 ? detail::fused(ar, detail::fused_minus(b.v[k], r, one, V()), ar, V()) : ar;
    }
    return c;
  }
#endif
  return a / b;
}

/// Square root of every lane, rounded correctly.
template <class V, int N>
Pack<V, N> sqrt(const Pack<V, N>& x) {
  Pack<V, N> y;
  for (int k = 0; k < y.parts; ++k)
    y.v[k] = detail::square_root(x.v[k], std::integral_constant<int, sizeof x.v[0]>(), V());
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

/// Q(z) of LogarithmSeries.
template <class P>
P logarithm_series(const P& z) {
  using Q = LogarithmSeries;
  static constexpr double coefficients[] = {Q::q6, Q::q5, Q::q4, Q::q3, Q::q2, Q::q1, Q::q0};
  return horner(z, coefficients, 7);
}

/// ln(u + error) for u normal and > 0, |error| below u's rounding; one register.
template <class V, int N>
typename Pack<V, N>::Lanes log_of_sum(const Pack<V, N>& u, const Pack<V, N>& error) {
  using P = Pack<V, N>;
  using Lanes = typename P::Lanes;
  using F = Format<V>;
  using Bits = typename Register<V, N>::Bits;
  using Unsigned = typename Register<V, N>::Unsigned;
  const auto number = [](const Bits& b) {
    P p;
    p.v[0] = (Lanes)b;
    return p;
  };
  // u = 2^k m, m in [sqrt(1/2), sqrt(2))
  const Bits u_bits = (Bits)u.v[0];
  const Bits exponent = (u_bits + (F::one - F::sqrt_half)) >> F::digits;  // k + bias
  const P m = number(u_bits - ((exponent - static_cast<Unsigned>(F::bias)) << F::digits));
  const P k = rounded(P(rounded(P(number(exponent | F::magic) - number(Bits{} + F::magic))) - P(V(F::bias))));
  const P per_2k = number((static_cast<Unsigned>(2 * F::bias) - exponent) << F::digits);
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
  using Lanes = typename P::Lanes;
  using F = Format<V>;
  using Bits = typename Register<V, N>::Bits;
  const P low(F::least_exponent), high(F::most_exponent);
  const P y = select(x < low, low, select(x > high, high, x));
  // Round to the nearest integer by adding a number whose last digit is 1.
  P shift;
  shift.v[0] = (Lanes)(Bits{} + F::magic);
  shift = shift * P(V(1.5));
  P shifted = multiply_add(y, P(static_cast<V>(1.4426950408889634)), shift);
  MYOGROWTH_OPAQUE(shifted.v[0]);
  const P k = shifted - shift;
  const P r = multiply_add(k, P(-F::ln2_low), multiply_add(k, P(-F::ln2_high), y));
  static constexpr double E[] = {2.5100385495510319078e-8,  2.7620088445409748161e-7,
                                 2.7557268459997064772e-6,  0.000024801521295954375131,
                                 0.00019841269863053616878, 0.0013888888917213716901,
                                 0.0083333333333300618325,  0.041666666666624127873,
                                 0.16666666666666667453,    0.50000000000000010221};
  const P one(V(1)), e_less_1 = multiply_add(r * r, horner(r, E, 10), r);
  P two_k;
  two_k.v[0] = (Lanes)(((Bits)shifted.v[0] << F::digits) + F::one);
  if (less_one) return select(x < low, -one, multiply_add(e_less_1, two_k, two_k - one)).v[0];
  return select(x < low, P(V(0)), (one + e_less_1) * two_k).v[0];
}

}  // namespace detail

/// ln(1 + x); x > -1 and 1 + x normal, else NaN or some finite number is what comes.
template <class V, int N>
Pack<V, N> log1p(const Pack<V, N>& x) {
  using P = Pack<V, N>;
  const P one(V(1));
  const P u = rounded(P(one + x));
  // What rounding took from the larger of the two.
  const P error = select(x < one, x - rounded(P(u - one)), one - rounded(P(u - x)));
  P y;
  for (int k = 0; k < y.parts; ++k) y.v[k] = detail::log_of_sum(u.part(k), error.part(k));
  return y;
}

/// ln(x), x normal and > 0, below 0.7 of the largest number.
template <class V, int N>
Pack<V, N> log(const Pack<V, N>& x) {
  Pack<V, N> y;
  const auto exact = Pack<V, N>(V(0)).part(0);
  for (int k = 0; k < y.parts; ++k) y.v[k] = detail::log_of_sum(x.part(k), exact);
  return y;
}

/// e^x; 0 where that is below the normal range, and no more than the largest power of 2 above it.
template <class V, int N>
Pack<V, N> exp(const Pack<V, N>& x) {
  Pack<V, N> y;
  for (int k = 0; k < y.parts; ++k) y.v[k] = detail::exponential<false>(x.part(k));
  return y;
}

/// e^x - 1, with all digits also near 0; -1 where e^x is below the normal range.
template <class V, int N>
Pack<V, N> expm1(const Pack<V, N>& x) {
  Pack<V, N> y;
  for (int k = 0; k < y.parts; ++k) y.v[k] = detail::exponential<true>(x.part(k));
  return y;
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

/// ln(1 + d/G) for x = d/G, by the series alone where that is enough (scalar.hpp).
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
