// A number that counts its operations: the kernel, run with it, gives the flops of a point.
#ifndef MYOGROWTH_BENCH_FLOPS_HPP
#define MYOGROWTH_BENCH_FLOPS_HPP

#include <cmath>
#include <limits>
#include <type_traits>

namespace bench {

struct Counted {
  static inline long flops = 0;      ///< + - * / and square roots
  static inline long functions = 0;  ///< logarithms and powers that do not consist of these

  double x = 0;
  constexpr Counted() = default;
  template <class R, class = std::enable_if_t<std::is_arithmetic<R>::value>>
  constexpr Counted(R number) : x(static_cast<double>(number)) {}  // NOLINT: constants convert silently

  explicit constexpr operator int() const { return static_cast<int>(x); }

  friend constexpr Counted operator-(Counted a) { return -a.x; }
  friend constexpr Counted operator+(Counted a, Counted b) { return flop(a.x + b.x); }
  friend constexpr Counted operator-(Counted a, Counted b) { return flop(a.x - b.x); }
  friend constexpr Counted operator*(Counted a, Counted b) { return flop(a.x * b.x); }
  friend constexpr Counted operator/(Counted a, Counted b) { return flop(a.x / b.x); }
  friend constexpr Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
  friend constexpr Counted& operator-=(Counted& a, Counted b) { return a = a - b; }
  friend constexpr Counted& operator*=(Counted& a, Counted b) { return a = a * b; }
  friend constexpr Counted& operator/=(Counted& a, Counted b) { return a = a / b; }
  friend constexpr bool operator<(Counted a, Counted b) { return a.x < b.x; }
  friend constexpr bool operator>(Counted a, Counted b) { return a.x > b.x; }
  friend constexpr bool operator<=(Counted a, Counted b) { return a.x <= b.x; }
  friend constexpr bool operator>=(Counted a, Counted b) { return a.x >= b.x; }
  friend constexpr bool operator==(Counted a, Counted b) { return a.x == b.x; }
  friend constexpr bool operator!=(Counted a, Counted b) { return a.x != b.x; }
  friend constexpr Counted value(Counted a) { return a; }
  friend Counted abs(Counted a) { return std::abs(a.x); }
  friend Counted frexp(Counted a, int* exponent) { return std::frexp(a.x, exponent); }
  friend Counted ldexp(Counted a, int exponent) { return std::ldexp(a.x, exponent); }
  friend Counted sqrt(Counted a) { return flop(std::sqrt(a.x)); }
  friend Counted log1p(Counted a) { return function(std::log1p(a.x)); }
  friend Counted log(Counted a) { return function(std::log(a.x)); }
  friend Counted exp(Counted a) { return function(std::exp(a.x)); }
  friend Counted expm1(Counted a) { return function(std::expm1(a.x)); }
  /// As in myogrowth::power for plain numbers: multiples of one half by multiplication and square root.
  friend Counted pow(Counted a, Counted b) {
    const double twice = 2 * b.x;
    if (!(twice >= 0 && twice < 18 && twice == std::floor(twice))) return function(std::pow(a.x, b.x));
    flops += static_cast<long>(std::floor(b.x)) + (std::floor(b.x) < b.x ? 1 : 0);
    return std::pow(a.x, b.x);
  }

 private:
  static constexpr Counted flop(double x) {
    if (!__builtin_is_constant_evaluated()) ++flops;  // the kernel's constants cost nothing
    return x;
  }
  static Counted function(double x) { return ++functions, x; }
};

}  // namespace bench

template <>
struct std::numeric_limits<bench::Counted> : std::numeric_limits<double> {};

#endif
