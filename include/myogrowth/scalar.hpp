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

namespace myogrowth {

using std::exp;
using std::expm1;
using std::log;
using std::log1p;
using std::pow;
using std::sqrt;

constexpr float value(float x) { return x; }
constexpr double value(double x) { return x; }
constexpr long double value(long double x) { return x; }
template <class R>
constexpr R value(const std::complex<R>& z) {
  return z.real();
}

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
bool is_finite(const T& x) {
  return value(x) - value(x) == 0;
}

/// Whether a term with this factor can be left out.
template <class T>
bool is_zero(const T& x) {
  return value(x) == 0;
}

namespace detail {

template <class T, class P>
T power_of(const T& x, const P& exponent, std::false_type) {
  return pow(x, exponent);  // an exponent that carries derivatives of its own
}

template <class T, class P>
T power_of(const T& x, const P& exponent, std::true_type) {
  const int whole = exponent >= 0 && exponent < 9 ? static_cast<int>(exponent) : 0;
  const P rest = exponent - static_cast<P>(whole);
  if (rest != 0 && rest != P(0.5)) return pow(x, exponent);
  T product = rest == 0 ? T(P(1)) : T(sqrt(x));
  for (int i = 0; i < whole; ++i) product = product * x;
  return product;
}

}  // namespace detail

/// x^exponent for x >= 0; by multiplication and at most one square root for 0, 1/2, 1, ... 17/2.
template <class T, class P>
T power(const T& x, const P& exponent) {
  return detail::power_of(x, exponent, std::is_floating_point<P>());
}

}  // namespace myogrowth

#endif
