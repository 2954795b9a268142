/// @file
/// What the law asks of its number type.
///
/// Every formula of myogrowth is a template over its scalar: float, double, long double, std::complex<double>
/// (complex-step derivatives) or a forward dual number. A scalar of your own needs + - * / with itself and
/// with the real type under it, `sqrt`, `log1p`, `pow(x, exponent)`, and `value(x)`, found by
/// argument-dependent look-up. `value` gives the real number that decides: all comparisons and the local
/// iteration see it alone, so that a derivative carried beside it can never change the path taken.
#ifndef MYOGROWTH_SCALAR_HPP
#define MYOGROWTH_SCALAR_HPP

#include <cmath>
#include <complex>
#include <type_traits>
#include <utility>

/// Every function of the law that is not constexpr: where a compiler for graphics processors reads it, it is
/// code for host and device (docs/gpu.md; nvcc needs --expt-relaxed-constexpr as well).
#if defined(__CUDACC__) || defined(__HIPCC__)
#define MYOGROWTH_FUNCTION __host__ __device__
#else
#define MYOGROWTH_FUNCTION
#endif

namespace myogrowth {

using std::exp;
using std::expm1;
using std::log;
using std::log1p;
using std::pow;
using std::sqrt;

/// The real number that decides: a number itself, the real part of a complex one.
/// @{
constexpr float value(float x) { return x; }
constexpr double value(double x) { return x; }
constexpr long double value(long double x) { return x; }
template <class R>
constexpr R value(const std::complex<R>& z) {
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
std::complex<R> log1p(const std::complex<R>& z) {
  const R x = z.real(), y = z.imag();
  return {log1p(x * (2 + x) + y * y) / 2, std::atan2(y, 1 + x)};
}

/// True for ordinary numbers, false for NaN and infinity.
template <class T>
MYOGROWTH_FUNCTION bool is_finite(const T& x) {
  return value(x) - value(x) == 0;
}

/// Whether n numbers all are.
template <class T>
MYOGROWTH_FUNCTION bool are_finite(const T* x, int n) {
  Real<T> sum(0);
  for (int i = 0; i < n; ++i) sum += value(x[i]);
  if (is_finite(sum)) return true;  // else one is not, or the sum alone overflowed
  for (int i = 0; i < n; ++i) {
    if (!is_finite(x[i])) return false;
  }
  return true;
}

/// Whether a term with this factor can be left out.
template <class T>
MYOGROWTH_FUNCTION bool is_zero(const T& x) {
  return value(x) == 0;
}

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
    if (whole_ == 0) return half_ ? T(sqrt(x)) : T(Real<T>(1));
    T product = x;
    if (whole_ > 1) {
      const T x2 = x * x, x4 = x2 * x2;
      product = whole_ < 4 ? x2 : whole_ < 8 ? x4 : T(x4 * x4);
      if (whole_ & 1) product = product * x;
      if (whole_ > 4 && whole_ & 2) product = product * x2;
    }
    if (half_) product = product * sqrt(x);
    return product;
  }

 private:
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
