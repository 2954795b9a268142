// A forward dual number with one direction, as an example of a user's own scalar type.
#ifndef MYOGROWTH_TESTS_DUAL_HPP
#define MYOGROWTH_TESTS_DUAL_HPP

#include <Eigen/Core>
#include <cmath>

namespace dual {

struct Dual {
  double v = 0, d = 0;  // value and derivative
  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT: constants convert implicitly, as with any number
  Dual(double value, double derivative) : v(value), d(derivative) {}
};

inline Dual operator+(Dual a, Dual b) { return {a.v + b.v, a.d + b.d}; }
inline Dual operator-(Dual a, Dual b) { return {a.v - b.v, a.d - b.d}; }
inline Dual operator-(Dual a) { return {-a.v, -a.d}; }
inline Dual operator*(Dual a, Dual b) { return {a.v * b.v, a.d * b.v + a.v * b.d}; }
inline Dual operator/(Dual a, Dual b) { return {a.v / b.v, (a.d - a.v / b.v * b.d) / b.v}; }
inline Dual& operator+=(Dual& a, Dual b) { return a = a + b; }
inline Dual& operator*=(Dual& a, Dual b) { return a = a * b; }
inline Dual sqrt(Dual a) { return {std::sqrt(a.v), a.d / (2 * std::sqrt(a.v))}; }
inline Dual log(Dual a) { return {std::log(a.v), a.d / a.v}; }
inline Dual log1p(Dual a) { return {std::log1p(a.v), a.d / (1 + a.v)}; }
inline Dual pow(Dual a, Dual b) {
  const double p = std::pow(a.v, b.v);
  return {p, b.v * std::pow(a.v, b.v - 1) * a.d + (b.d == 0 ? 0 : p * std::log(a.v) * b.d)};
}
inline double value(Dual a) { return a.v; }

}  // namespace dual

namespace Eigen {
template <>
struct NumTraits<dual::Dual> : NumTraits<double> {
  using Real = dual::Dual;
  using NonInteger = dual::Dual;
  using Nested = dual::Dual;
  enum { IsComplex = 0, RequireInitialization = 1 };
};
}  // namespace Eigen

#endif
