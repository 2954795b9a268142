/// @file
/// One SIMD register: what the vector extensions of g++ and clang have not, by the intrinsics of the
/// instruction set.
#ifndef MYOGROWTH_MANY_REGISTER_HPP
#define MYOGROWTH_MANY_REGISTER_HPP

#include <cstdint>

#include "../scalar.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

// Between register types g++ and clang have no other cast.
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif

namespace myogrowth {
namespace simd {

/// Registers of N lanes of V (`InMemory`: wherever V may lie), and of N integers of the same size. (g++ 12
/// takes vector_size with sizes that depend on a template for scalars, hence the list.)
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

/// What the vector extensions do not have, for a register of N lanes of V: here for every target, below by
/// the intrinsics of an instruction set.
template <class V, int N>
struct Portable {
  using L = typename Register<V, N>::Lanes;     ///< the register
  using M = typename Register<V, N>::Integers;  ///< true (all bits set) or false for every lane
  static constexpr bool approximates = false;   ///< has fast approximations of 1/x and 1/sqrt(x)
  /// a b + c. Where the target fuses, it is written so: in a sum of two products the compiler may contract
  /// either, and results would differ between builds.
  static L fused(const L& a, const L& b, const L& c) { return a * b + c; }
  /// Rounded correctly.
  static L square_root(L x) {
    for (int i = 0; i < N; ++i) x[i] = std::sqrt(x[i]);
    return x;
  }
  /// One bit a lane.
  static unsigned bits(const M& m) {
    unsigned all = 0;
    for (int i = 0; i < N; ++i) all |= (m[i] != 0 ? 1u : 0u) << i;
    return all;
  }
  /// To a multiple of a register's size, past the caches where the target can.
  static void stream(V* to, const L& x) { *reinterpret_cast<typename Register<V, N>::InMemory*>(to) = x; }
  /// Comparisons and what is made of them.
  /// @{
  static M less(const L& a, const L& b) { return a < b; }
  static M less_or_equal(const L& a, const L& b) { return a <= b; }
  static M equal(const L& a, const L& b) { return a == b; }
  static L choose(const M& m, const L& a, const L& b) { return m ? a : b; }
  static L smaller(const L& a, const L& b) { return a < b ? a : b; }
  static L larger(const L& a, const L& b) { return a > b ? a : b; }
  static void hide(M& m) { MYOGROWTH_OPAQUE(m); }
  /// @}
};
/// The best of this target.
template <class V, int N>
struct Target : Portable<V, N> {};

/// How exact a quotient is: correct up to an ulp, to 12 digits, to 8 (7 and 4 of a float).
enum class Accuracy { full, near_by, rough };

/// a/b in the registers of a target T.
template <class T, Accuracy accuracy, class L>
L divide(const L& a, const L& b) {
  if constexpr (!T::approximates) {
    return a / b;
  } else {
    using V = std::decay_t<decltype(a[0])>;
    constexpr bool is_double = sizeof(V) == 8;
    const L r = T::near_reciprocal(b), e = T::fused_minus(b, r, L{} + V(1));  // 1/b = r (1 + e + e^2 + ...)
    const L ar = a * r;
    if (accuracy == Accuracy::rough) return is_double ? T::fused(ar, e, ar) : ar;
    const L rest = is_double ? T::fused(e, e, e) : e;  // r is good to 14 bits, r (1 + rest) to 42 (float: 28)
    if (accuracy == Accuracy::near_by) return T::fused(ar, rest, ar);
    const L per_b = T::fused(r, rest, r), quotient = a * per_b;
    return T::fused(T::fused_minus(b, quotient, a), per_b, quotient);
  }
}

/// The square root in the same way; that of 0 is 0.
template <class T, class L>
L root_by_approximation(const L& x) {
  using V = std::decay_t<decltype(x[0])>;
  const L one = L{} + V(1), half = L{} + V(0.5), three_eighths = L{} + V(0.375);
  const L y = T::near_reciprocal_root(x), e = T::fused_minus(x * y, y, one);
  const L better = T::fused(y * e, sizeof(V) == 8 ? T::fused(e, three_eighths, half) : half, y);
  const L root = x * better;
  return T::fused(T::fused_minus(root, root, x), better * half, root);
}

/// @cond
#if defined(__FMA__)
#define MYOGROWTH_FUSED(prefix, suffix) \
  static L fused(const L& a, const L& b, const L& c) { return prefix##_fmadd_##suffix(a, b, c); }
#else
#define MYOGROWTH_FUSED(prefix, suffix)
#endif
#define MYOGROWTH_SSE_AVX(V, N, prefix, suffix)                                                          \
  template <>                                                                                            \
  struct Target<V, N> : Portable<V, N> {                                                                 \
    static L square_root(const L& x) { return prefix##_sqrt_##suffix(x); }                               \
    static unsigned bits(const M& m) { return static_cast<unsigned>(prefix##_movemask_##suffix((L)m)); } \
    static void stream(V* to, const L& x) { prefix##_stream_##suffix(to, x); }                           \
    MYOGROWTH_FUSED(prefix, suffix)                                                                      \
  };
#if defined(__SSE2__)
MYOGROWTH_SSE_AVX(double, 2, _mm, pd)
MYOGROWTH_SSE_AVX(float, 4, _mm, ps)
#endif
#if defined(__AVX2__)
MYOGROWTH_SSE_AVX(double, 4, _mm256, pd)
MYOGROWTH_SSE_AVX(float, 8, _mm256, ps)
#endif
#undef MYOGROWTH_SSE_AVX

// AVX-512: masks are registers of their own, with one bit a lane (g++ 12 takes vectors of integers apart, bit
// by bit, when they meet). Masked intrinsics with all lanes on, where g++ 12 warns of the others in its own
// header. The approximate root is 0 for 0, so that nothing made of it is 0 times infinity.
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define MYOGROWTH_AVX512(V, N, suffix, Mask)                                                                \
  template <>                                                                                               \
  struct Target<V, N> : Portable<V, N> {                                                                    \
    using M = Mask;                                                                                         \
    static constexpr bool approximates = true;                                                              \
    static constexpr M every = static_cast<M>(~0u);                                                         \
    MYOGROWTH_FUSED(_mm512, suffix)                                                                         \
    static L fused_minus(const L& a, const L& b, const L& c) { return _mm512_fnmadd_##suffix(a, b, c); }    \
    static L near_reciprocal(const L& x) { return _mm512_maskz_rcp14_##suffix(every, x); }                  \
    static L near_reciprocal_root(const L& x) {                                                             \
      return _mm512_maskz_rsqrt14_##suffix(_mm512_cmp_##suffix##_mask(x, L{}, _CMP_NEQ_UQ), x);             \
    }                                                                                                       \
    static L square_root(const L& x) { return root_by_approximation<Target>(x); }                           \
    static unsigned bits(M m) { return m; }                                                                 \
    static void stream(V* to, const L& x) { _mm512_stream_##suffix(to, x); }                                \
    static M less(const L& a, const L& b) { return _mm512_cmp_##suffix##_mask(a, b, _CMP_LT_OQ); }          \
    static M less_or_equal(const L& a, const L& b) { return _mm512_cmp_##suffix##_mask(a, b, _CMP_LE_OQ); } \
    static M equal(const L& a, const L& b) { return _mm512_cmp_##suffix##_mask(a, b, _CMP_EQ_OQ); }         \
    static L choose(M m, const L& a, const L& b) { return _mm512_mask_blend_##suffix(m, b, a); }            \
    static L smaller(const L& a, const L& b) { return _mm512_maskz_min_##suffix(every, a, b); }             \
    static L larger(const L& a, const L& b) { return _mm512_maskz_max_##suffix(every, a, b); }              \
    static void hide(M& m) { __asm__("" : "+k"(m)); }                                                       \
  };
MYOGROWTH_AVX512(double, 8, pd, __mmask8)
MYOGROWTH_AVX512(float, 16, ps, __mmask16)
#undef MYOGROWTH_AVX512
#endif
#undef MYOGROWTH_FUSED

#if defined(__aarch64__)
#define MYOGROWTH_NEON(V, N, suffix)                                                       \
  template <>                                                                              \
  struct Target<V, N> : Portable<V, N> {                                                   \
    static L square_root(const L& x) { return vsqrtq_##suffix(x); }                        \
    static L fused(const L& a, const L& b, const L& c) { return vfmaq_##suffix(c, a, b); } \
  };
MYOGROWTH_NEON(double, 2, f64)
MYOGROWTH_NEON(float, 4, f32)
#undef MYOGROWTH_NEON
#endif
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

}  // namespace simd
}  // namespace myogrowth

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#endif
