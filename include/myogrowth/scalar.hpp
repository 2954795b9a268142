/// @file
/// What the law asks of its number type.
///
/// Every formula of myogrowth is a template over its scalar: float, double, long double, std::complex<double>
/// (complex-step derivatives) or a forward dual number. A scalar of your own needs + - * / with itself and
/// with the real type under it, `sqrt`, `log1p`, `pow(x, exponent)`, and `value(x)`, found by
/// argument-dependent look-up; the laws of elastic/ also need `exp`, `expm1` and `log`. `value` gives the
/// real number that decides: all comparisons and the local iteration see only it, so that a derivative
/// carried beside it can never change the path taken.
#ifndef MYOGROWTH_SCALAR_HPP
#define MYOGROWTH_SCALAR_HPP

#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

/// Every function of the law that is not constexpr: where a compiler for graphics processors reads it, it is
/// code for host and device (docs/gpu.md; nvcc needs --expt-relaxed-constexpr as well).
#if defined(__CUDACC__) || defined(__HIPCC__)
#define MYOGROWTH_FUNCTION __host__ __device__
#else
#define MYOGROWTH_FUNCTION
#endif
/// Inlines all that a function calls. (Not with the sanitizers: compilers then take many minutes for packs.)
/// A GPU's compiler has no such attribute: there the function itself is inlined, since a call would put its
/// arguments and results on the stack.
#if defined(__CUDACC__)
#define MYOGROWTH_FLAT __forceinline__
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MYOGROWTH_FLAT
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MYOGROWTH_FLAT
#endif
#endif
#if !defined(MYOGROWTH_FLAT) && defined(__GNUC__)
#define MYOGROWTH_FLAT __attribute__((flatten))
#elif !defined(MYOGROWTH_FLAT)
#define MYOGROWTH_FLAT
#endif
/// Hides from the compiler where the number x comes from, at no cost. With -ffast-math it would assume that x
/// is not NaN, and that (1 + x) - 1 is x.
#if defined(__GNUC__) && !defined(__CUDACC__) && !defined(__HIPCC__)
#define MYOGROWTH_OPAQUE_INTEGER(x) __asm__("" : "+r"(x))
#if defined(__SSE2__) && defined(__x86_64__)
#define MYOGROWTH_OPAQUE(x) __asm__("" : "+x"(x))
#elif defined(__aarch64__)
#define MYOGROWTH_OPAQUE(x) __asm__("" : "+w"(x))
#else
#define MYOGROWTH_OPAQUE(x) __asm__("" : "+m"(x))
#endif
#else
#define MYOGROWTH_OPAQUE_INTEGER(x)
/// MYOGROWTH_OPAQUE_INTEGER for a floating-point number.
#define MYOGROWTH_OPAQUE(x)
#endif
/// What is rarely called: kept out of the code around it. (On a GPU a call would push all out of registers.)
#if defined(__GNUC__) && !defined(__CUDACC__)
#define MYOGROWTH_NOINLINE __attribute__((noinline))
#else
#define MYOGROWTH_NOINLINE
#endif

namespace myogrowth {

using std::abs;
using std::exp;
using std::expm1;
using std::log;
using std::log1p;
using std::pow;
using std::sqrt;

/// std::complex, also where C's <complex.h> has made a macro of the word.
#pragma push_macro("complex")
#undef complex
template <class R>
using ComplexOf = std::complex<R>;
#pragma pop_macro("complex")

/// The real number that decides: a number itself, the real part of a complex one.
/// @{
constexpr float value(float x) { return x; }
constexpr double value(double x) { return x; }
constexpr long double value(long double x) { return x; }
template <class R>
constexpr R value(const ComplexOf<R>& z) {
  return z.real();
}
/// @}

/// The real type under a scalar: double for double, std::complex<double> and a dual number over double.
template <class T>
using Real = std::decay_t<decltype(value(std::declval<const T&>()))>;

/// The scalar that a product of an A and a B gives, e.g. complex for (double, complex).
template <class A, class B>
using Product = std::decay_t<decltype(std::declval<const A&>() * std::declval<const B&>())>;

/// ln(1 + z), accurate for small |z| in both parts; the standard library has it for real numbers only.
template <class R>
ComplexOf<R> log1p(const ComplexOf<R>& z) {
  const R x = z.real(), y = z.imag();
  return {log1p(x * (2 + x) + y * y) / 2, std::atan2(y, 1 + x)};
}

/// e^z - 1, likewise.
template <class R>
ComplexOf<R> expm1(const ComplexOf<R>& z) {
  const R x = z.real(), y = z.imag(), half_sine = std::sin(y / 2);
  return {expm1(x) * std::cos(y) - 2 * half_sine * half_sine, exp(x) * std::sin(y)};
}

/// ln(1 + f) = 2 artanh(s), s = f/(2 + f), for 1 + f from sqrt(1/2) to sqrt(2): with z = s^2 and h = f^2/2 it
/// is f - (h - s (h + z Q(z))). Q by Chebyshev interpolation, error 3e-16; these are its coefficients.
struct LogarithmSeries {
  /// @cond
  static constexpr double q6 = 0.14616585424888621989, q5 = 0.15331710618210771568,
                          q4 = 0.18182889455674946039, q3 = 0.22222211130259877029,
                          q2 = 0.28571428626003268742, q1 = 0.39999999999899443233,
                          q0 = 0.66666666666666696883;
  /// @endcond
};

/// ln(1 + d/G) for x = d/G. For doubles by the series that packs have as well (many/pack.hpp).
/// @{
template <class T>
MYOGROWTH_FUNCTION T ln_1_plus(const T& x, const T&, const T&) {
  return log1p(x);
}
MYOGROWTH_FUNCTION inline double ln_1_plus(double x, double d, double G) {
  if (!(x > -0.29 && x < 0.41)) return log1p(x);
  using Q = LogarithmSeries;
  const double s = d / (G + G + d), z = s * s, z2 = z * z, half_square = 0.5 * x * x;
  const double sum =
      ((Q::q0 + Q::q1 * z) + z2 * (Q::q2 + Q::q3 * z)) + z2 * z2 * ((Q::q4 + Q::q5 * z) + z2 * Q::q6);
  return x - (half_square - s * (half_square + z * sum));
}
/// @}

/// a/b, given 1/b, which packs make use of (many/pack.hpp).
template <class T>
MYOGROWTH_FUNCTION T quotient(const T& a, const T& b, const T&) {
  return a / b;
}

/// The number of an array's entries, as arrays want it.
constexpr std::size_t entries(std::ptrdiff_t n) { return static_cast<std::size_t>(n); }

/// What one text for numbers and packs needs: for a number, all of it is about its one lane.
/// @{

/// What comparisons are made of: the value of a number, a pack as it is.
template <class T>
MYOGROWTH_FUNCTION constexpr Real<T> deciding(const T& x) {
  return value(x);
}
/// The answers of a comparison: bool for a number, one for each lane of a pack.
template <class T>
using LaneMask =
    std::decay_t<decltype(deciding(std::declval<const T&>()) < deciding(std::declval<const T&>()))>;
/// a where the mask is true, else b.
template <class T>
MYOGROWTH_FUNCTION constexpr T select(bool mask, const T& a, const T& b) {
  return mask ? a : b;
}
/// Whether the mask is true in any lane.
MYOGROWTH_FUNCTION constexpr bool any(bool mask) { return mask; }
/// The smaller and the larger; b where either is NaN.
template <class T>
MYOGROWTH_FUNCTION constexpr T minimum(const T& a, const T& b) {
  return value(a) < value(b) ? a : b;
}
template <class T>
MYOGROWTH_FUNCTION constexpr T maximum(const T& a, const T& b) {
  return value(a) > value(b) ? a : b;
}
/// a/b to 12 and to 8 digits, where that is faster; for numbers it is not.
template <class T>
MYOGROWTH_FUNCTION constexpr T near_quotient(const T& a, const T& b) {
  return a / b;
}
template <class T>
MYOGROWTH_FUNCTION constexpr T rough_quotient(const T& a, const T& b) {
  return a / b;
}
/// Whether x is too small for a pack's fast divisions; numbers have none.
template <class T>
MYOGROWTH_FUNCTION constexpr bool beyond_reciprocals(const T&) {
  return false;
}
/// @}

/// The step from 1 to the next number, as far as a number has digits: what tolerances are made of. (`epsilon`
/// of a long double made of two doubles, as on ppc64le, is the smallest number of all.)
/// @{
template <class V>
constexpr V last_place() {
  return std::numeric_limits<V>::epsilon();
}
template <>
constexpr long double last_place<long double>() {
  using Limits = std::numeric_limits<long double>;
  constexpr long double of_double = static_cast<long double>(last_place<double>());
  return Limits::digits == 106 ? of_double * of_double / 2 : Limits::epsilon();
}
/// @}

/// x as it has been rounded: with -ffast-math a compiler would put (x - 1) + 1 as x. A scalar of one's own
/// does not need it.
/// @{
template <class T>
MYOGROWTH_FUNCTION T rounded(T x) {
  return x;
}
MYOGROWTH_FUNCTION inline double rounded(double x) {
  MYOGROWTH_OPAQUE(x);
  return x;
}
MYOGROWTH_FUNCTION inline float rounded(float x) {
  MYOGROWTH_OPAQUE(x);
  return x;
}
/// @}

namespace detail {

/// Of a float or a double.
template <class V, class Bits = std::conditional_t<sizeof(V) == sizeof(float), std::uint32_t, std::uint64_t>>
MYOGROWTH_FUNCTION Bits bits_of(V x) {
  Bits bits;
  std::memcpy(&bits, &x, sizeof bits);
  MYOGROWTH_OPAQUE_INTEGER(bits);
  return bits;
}
/// The exponent of NaN and infinity has all bits set.
template <class V, class Bits = decltype(bits_of(V()))>
MYOGROWTH_FUNCTION bool is_finite_by_bits(V x) {
  constexpr Bits exponent = (~Bits(0) >> 1) & (~Bits(0) << (std::numeric_limits<V>::digits - 1));
  return (bits_of(x) & exponent) != exponent;
}
template <class V>
MYOGROWTH_FUNCTION bool is_finite_real(const V& x) {  // a user's number type
  return x - x == 0;
}
MYOGROWTH_FUNCTION inline bool is_finite_real(double x) { return is_finite_by_bits(x); }
MYOGROWTH_FUNCTION inline bool is_finite_real(float x) { return is_finite_by_bits(x); }
inline bool is_finite_real(long double x) {  // whatever its format, this is within the range of double
  return is_finite_real(static_cast<double>(x * (std::numeric_limits<long double>::min)()));
}

}  // namespace detail

/// True for ordinary numbers, false for NaN and infinity. By the bits: compilers with -ffast-math take every
/// comparison for one of ordinary numbers.
template <class T>
MYOGROWTH_FUNCTION bool is_finite(const T& x) {
  return detail::is_finite_real(value(x));
}

/// Whether n numbers all are.
template <class T>
MYOGROWTH_FUNCTION bool are_finite(const T* x, int n) {
  Real<T> sum(0);
  for (int i = 0; i < n; ++i) sum += value(x[i]);
  if (is_finite(sum)) return true;  // else one is not, or only the sum overflowed
  for (int i = 0; i < n; ++i) {
    if (!is_finite(x[i])) return false;
  }
  return true;
}

/// Whether a term with this factor can be left out; not if it is NaN.
template <class T>
MYOGROWTH_FUNCTION bool is_zero(const T& x) {
  return value(x) == 0;
}
/// By the bits, which -ffast-math leaves as they are.
MYOGROWTH_FUNCTION inline bool is_zero(double x) { return detail::bits_of(x) << 1 == 0; }
/// The same.
MYOGROWTH_FUNCTION inline bool is_zero(float x) { return detail::bits_of(x) << 1 == 0; }

/// An exponent, looked at once: 0, 1/2, 1, ... 17/2 need multiplications and at most one square root.
/// P: a real number, or a scalar that carries derivatives with respect to the exponent.
template <class P>
class Exponent {
 public:
  /// Looks at it.
  MYOGROWTH_FUNCTION explicit Exponent(const P& exponent) : exponent_(exponent), whole_(-1), half_(false) {
    look(std::is_floating_point<P>());
  }

  /// x^exponent for x >= 0.
  template <class T>
  MYOGROWTH_FUNCTION T operator()(const T& x) const {
    if (whole_ < 0) return pow(x, exponent_);
    const T product = whole_ == 2 ? T(x * x) : to_whole(x);
    return half_ ? T(product * sqrt(x)) : product;
  }

 private:
  template <class T>
  MYOGROWTH_FUNCTION T to_whole(const T& x) const {
    if (whole_ == 0) return T(Real<T>(1));
    if (whole_ == 1) return x;
    const T x2 = x * x, x4 = x2 * x2;
    T product = whole_ < 4 ? x2 : whole_ < 8 ? x4 : T(x4 * x4);
    if (whole_ & 1) product = product * x;
    if (whole_ > 4 && whole_ & 2) product = product * x2;
    return product;
  }
  MYOGROWTH_FUNCTION void look(std::true_type) {
    if (!(exponent_ >= 0 && exponent_ < 9)) return;
    const int whole = static_cast<int>(exponent_);
    const P rest = exponent_ - static_cast<P>(whole);
    half_ = rest == P(0.5);
    if (rest == 0 || half_) whole_ = whole;
  }
  MYOGROWTH_FUNCTION void look(std::false_type) {}

  P exponent_;
  int whole_;  // -1: by pow
  bool half_;
};

/// x^exponent for x >= 0.
template <class T, class P>
MYOGROWTH_FUNCTION T power(const T& x, const P& exponent) {
  return Exponent<P>(exponent)(x);
}

}  // namespace myogrowth

#endif
