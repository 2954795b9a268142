/// @file
/// One backward-Euler step of the growth law (paper, eq. 4): G and dG/dlambda. It cannot fail.
///
///   R(G) = G - G_n - dt k_g(G) (lambda/G - lambda_crit) = 0
///
/// If lambda <= lambda_crit G_n, or G_n >= G_max, or dt <= 0, nothing grows. Otherwise the bracket
/// [G_n, min(G_max, lambda/lambda_crit)] holds exactly one root for any dt, because k_g and the criterion are
/// positive and decreasing there, so that R' >= 1. For gamma >= 1, R is concave and Newton's method climbs to
/// the root from the left without ever passing it; for 0 < gamma < 1 the same holds in the variable k_g, from
/// the other side; for gamma = 0 the equation is quadratic (docs/theory.md has the proofs).
#ifndef MYOGROWTH_GROWTH_SOLVE_HPP
#define MYOGROWTH_GROWTH_SOLVE_HPP

#include <limits>

#include "growth_rate.hpp"

namespace myogrowth {

/// Result of one time step of eq. 4.
template <class T>
struct GrowthStep {
  T G;             ///< sarcomere number at the end of the step [-]
  T dG_dlambda;    ///< its derivative with respect to the total stretch at the end, at fixed G_n and dt [-]
  int iterations;  ///< Newton steps taken; 0: nothing grew
};

namespace detail {

/// The step's equation without fractions, E G (G - G_n) = k(G) q(G), scaled by the growth number
/// a = dt k_g(G_n) so that nothing overflows for any dt: (A, E) = (a, 1) for a <= 1 and (1, 1/a) beyond.
template <class P>
struct GrowthEquation {
  P G_max, gamma, lambda_crit;
  P A, E;
  Real<P> room_n;  ///< G_max - G_n, the unit in which what is left to grow is measured

  GrowthEquation(const GrowthRate<P>& rate, const P& dt, Real<P> G_n)
      : G_max(rate.G_max),
        gamma(rate.gamma),
        lambda_crit(rate.lambda_crit),
        A(1),
        E(1),
        room_n(value(rate.G_max) - G_n) {
    const P a = dt / rate.growth_time * power(P(room_n / (rate.G_max - P(1))), rate.gamma);
    (value(a) > 1 ? E : A) = value(a) > 1 ? P(P(1) / a) : a;
  }

  template <class T>
  T k(const T& G) const {
    return A * power(T((G_max - G) / room_n), gamma);
  }
  template <class T>
  T q(const T& lambda, const T& G) const {
    return lambda - lambda_crit * G;
  }
  /// Derivative of E G (G - G_n) - k q at the root. As k q = E G (G - G_n) there, nothing cancels in it.
  template <class T>
  T slope(const T& G, const T& G_n, const T& k) const {
    const T grown = E * (G - G_n);
    return grown + E * G + gamma * grown * G / (G_max - G) + k * lambda_crit;
  }
};

/// The same equation on plain numbers, with the bracket of its root.
template <class V>
struct BracketedEquation : GrowthEquation<V> {
  V lambda, G_n, end;

  BracketedEquation(const GrowthRate<V>& rate, V dt, V G_n_, V lambda_)
      : GrowthEquation<V>(rate, dt, G_n_), lambda(lambda_), G_n(G_n_), end(lambda_ / rate.lambda_crit) {
    if (!(end < rate.G_max)) end = rate.G_max;
  }
};

/// Whether rounding is all that is left after this step. Newton's method leaves step^2 R''/(2 R'), and R''/R'
/// is at most 2 gamma/(G_max - G) + 2/G: the two bounds below make that about rounding.
template <class V>
bool is_last_step(V step, V G, V room, V gamma) {
  constexpr V of_room = V(1) / static_cast<V>(1ll << ((std::numeric_limits<V>::digits - 1) / 3));
  constexpr V of_G = std::numeric_limits<V>::epsilon() / of_room;
  return step <= of_G * G && step * (1 + gamma) <= 2 * of_room * room;
}

/// A lower bound of the root that is far better than G_n when the step is long. At the root k q is at most
/// `bound`, which limits the distance u from the end of the bracket in three ways: by what is left of q or of
/// k at the end itself, and by their product.
template <class V>
V long_step_start(const BracketedEquation<V>& eq) {
  const V bound = eq.E * eq.end * (eq.end - eq.G_n) / eq.A;
  const V q_end = eq.q(eq.lambda, eq.end);
  const V k_end = eq.k(eq.end) / eq.A;
  V u = eq.end - eq.G_n;
  const auto tighten = [&u](V candidate) {
    if (candidate < u) u = candidate;
  };
  if (q_end > 0) tighten(eq.room_n * pow(bound / q_end, 1 / eq.gamma));
  if (k_end > 0) tighten(bound / (eq.lambda_crit * k_end));
  tighten(eq.room_n * pow(bound / (eq.lambda_crit * eq.room_n), 1 / (eq.gamma + 1)));
  // A hair more keeps it a lower bound in spite of rounding.
  const V start = eq.end - u * (1 + 64 * std::numeric_limits<V>::epsilon());
  return start > eq.G_n ? start : eq.G_n;
}

/// gamma = 0: the equation is quadratic in G.
template <class V>
V root_of_quadratic(const BracketedEquation<V>& eq) {
  const V b = eq.A * eq.lambda_crit - eq.E * eq.G_n;
  const V c = eq.A * eq.lambda;
  const V root = sqrt(b * b + 4 * eq.E * c);
  return b > 0 ? 2 * c / (b + root) : (root - b) / (2 * eq.E);
}

/// Halves [G, end], which holds the root, down to rounding: for parameters so far out (gamma in the hundreds)
/// that Newton's method would take its time.
template <class V>
V bisect(const BracketedEquation<V>& eq, V G, V end, int& iterations) {
  for (;;) {
    ++iterations;
    const V middle = end > 4 * G ? sqrt(G) * sqrt(end) : G + (end - G) / 2;
    if (!(middle > G && middle < end)) return G;
    const bool is_left = eq.k(middle) * eq.q(eq.lambda, middle) > eq.E * middle * (middle - eq.G_n);
    (is_left ? G : end) = middle;
  }
}

/// Newton's method in G for gamma >= 1 and in k for 0 < gamma < 1, either monotone from the left. A Newton
/// step in k is one in G with the room left, room^gamma being proportional to k, shortened by its own factor.
template <class V>
V newton(const BracketedEquation<V>& eq, V G, int& iterations) {
  constexpr int patience = 64;  // three times what gamma = 20 takes
  const V per_room = 1 / eq.room_n;
  while (iterations < patience) {
    ++iterations;
    const V room = eq.G_max - G;
    const V x = room * per_room;
    const V k_over_x = eq.A * power(x, eq.gamma - 1);
    const V k = k_over_x * x, minus_dk = eq.gamma * k_over_x * per_room, q = eq.q(eq.lambda, G);
    const V EG = eq.E * G;
    V step = G * (k * q - EG * (G - eq.G_n)) / (EG * G + G * minus_dk * q + k * eq.lambda);
    if (eq.gamma < 1) step = -room * expm1(log1p(-eq.gamma * step / room) / eq.gamma);
    const V next = G + step;
    if (!(next > G)) return G;  // at rounding level
    if (!(next < eq.end)) return eq.end;
    if (is_last_step(step, next, room, eq.gamma)) return next;
    G = next;
  }
  return bisect(eq, G, eq.end, iterations);
}

template <class V>
V growth_root(const BracketedEquation<V>& eq, int& iterations) {
  if (!(eq.gamma > std::numeric_limits<V>::epsilon())) {  // k_g is constant to rounding
    iterations = 1;
    return root_of_quadratic(eq);
  }
  // If an explicit step would leave the bracket, Newton from G_n would crawl: k falls by e a step.
  const bool is_long = eq.A * eq.q(eq.lambda, eq.G_n) > eq.E * eq.G_n * (eq.end - eq.G_n);
  const V start = is_long ? long_step_start(eq) : eq.G_n;
  return newton(eq, start, iterations);
}

/// Gives the converged value the derivatives that the scalar carries, by the implicit function theorem: one
/// Newton step in T, whose value is nil and whose derivatives are those of the root.
template <class T, class P, class V>
T with_derivatives(const GrowthEquation<P>& eq, const T& G_n, const T& lambda, V G_end, std::false_type) {
  const T G(G_end);
  const T k = eq.k(G);
  return G - (eq.E * G * (G - G_n) - k * eq.q(lambda, G)) / eq.slope(G, G_n, k);
}

template <class T, class P>
T with_derivatives(const GrowthEquation<P>&, const T&, const T&, T G_end, std::true_type) {
  return G_end;  // a plain number carries none
}

}  // namespace detail

/// Solves R(G) = 0 (above) for one step of length dt [time] under the total stretch lambda at its end.
///
/// Works for every G_n > 0, lambda > 0 and dt, also infinite. G never leaves the bracket above.
/// dG/dlambda is the exact derivative of this discrete update, from the implicit function theorem at the
/// converged G; it lies in [0, 1/lambda_crit], and is 0 at the threshold and at G_max.
template <class T, class P>
GrowthStep<T> solve_growth(const GrowthRate<P>& rate, const T& G_n, const T& lambda,
                           const std::common_type_t<P>& dt) {
  using V = Real<T>;
  const GrowthRate<V> r{value(rate.growth_time), value(rate.gamma), value(rate.G_max),
                        value(rate.lambda_crit)};
  const GrowthStep<T> none{G_n, T(0), 0};
  const bool grows = value(dt) > 0 && value(lambda) > r.lambda_crit * value(G_n) && value(G_n) < r.G_max;
  if (!grows) return none;
  const detail::BracketedEquation<V> eq(r, value(dt), value(G_n), value(lambda));
  if (!(eq.A > 0)) return none;  // dt k_g(G_n) is below the smallest number

  int iterations = 0;
  V G = detail::growth_root(eq, iterations);
  if (!(G > eq.G_n)) G = eq.G_n;
  if (!(G < eq.end)) G = eq.end;
  if (!(G < r.G_max)) return {T(rate.G_max), T(0), iterations};  // saturated

  const detail::GrowthEquation<P> lifted(rate, dt, eq.G_n);
  const T G_end = detail::with_derivatives(lifted, G_n, lambda, G, std::is_same<T, V>());
  const T k = lifted.k(G_end);
  const T slope = lifted.slope(G_end, G_n, k);
  return {G_end, value(slope) > 0 ? T(k / slope) : T(0), iterations};
}

}  // namespace myogrowth

#endif
