/// @file
/// One backward-Euler step of the growth law (paper, eq. 4): G and dG/dlambda. It cannot fail.
///
///   R(G) = G - G_n - dt k_g(G) (lambda/G - lambda_crit) = 0
///
/// If lambda <= lambda_crit G_n, or G_n >= G_max, or dt <= 0, nothing grows. Otherwise the bracket
/// [G_n, min(G_max, lambda/lambda_crit)] holds exactly one root for any dt, because k_g and the criterion are
/// positive and decreasing there, so that R' >= 1. For gamma >= 1, R is concave and Newton's method climbs to
/// the root from the left without ever passing it (unless the step is long, it has little to do after two
/// steps of higher order); for 0 < gamma < 1 the same holds in the variable k_g, from the other side; for
/// gamma = 0 the equation is quadratic (docs/theory.md has the proofs).
///
/// Removal is the mirror image, from G_n down to max(G_min, lambda/lambda_rev); the code has both, by a sign.
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

/// The step's equation without fractions, E sign G (G - G_n) = k(G) q(G), q = sign (lambda - crit G), for
/// growth (sign = 1) and removal (-1). It is scaled by the growth number a = dt k_g(G_n) so that nothing
/// overflows for any dt: (A, E) = (a, 1) for a <= 1 and (1, 1/a) beyond.
template <class P, int sign>
struct GrowthEquation {
  P limit, gamma, crit;  ///< G_max or G_min, and the exponent and threshold that go with it
  P A, E;
  Exponent<P> to_gamma;
  Real<P> room_n;    ///< sign (limit - G_n), the unit in which what is left of the way is measured
  Real<P> per_room;  ///< 1/room_n

  /// growth_time: tau or tau_rev. width: limit's distance from where the capacity is 1.
  MYOGROWTH_FUNCTION GrowthEquation(const P& limit_, const P& gamma_, const P& crit_, const P& width,
                                    const P& dt, const P& growth_time, Real<P> G_n)
      : limit(limit_),
        gamma(gamma_),
        crit(crit_),
        A(1),
        E(1),
        to_gamma(gamma_),
        room_n(sign > 0 ? value(limit_) - G_n : G_n - value(limit_)),
        per_room(1 / room_n) {
    const P a = dt / growth_time * to_gamma(P(room_n / width));
    if (value(a) > 1) {
      E = P(1) / a;
    } else {
      A = a;
    }
  }

  /// The values of one that carries derivatives.
  template <class Q>
  MYOGROWTH_FUNCTION explicit GrowthEquation(const GrowthEquation<Q, sign>& lifted)
      : limit(value(lifted.limit)),
        gamma(value(lifted.gamma)),
        crit(value(lifted.crit)),
        A(value(lifted.A)),
        E(value(lifted.E)),
        to_gamma(value(lifted.gamma)),
        room_n(lifted.room_n),
        per_room(lifted.per_room) {}

  template <class T>
  MYOGROWTH_FUNCTION T room(const T& G) const {
    return sign > 0 ? T(limit - G) : T(G - limit);
  }
  template <class T>
  MYOGROWTH_FUNCTION T k(const T& G) const {
    return A * to_gamma(T(room(G) * per_room));
  }
  template <class T>
  MYOGROWTH_FUNCTION T q(const T& lambda, const T& G) const {
    return sign > 0 ? T(lambda - crit * G) : T(crit * G - lambda);
  }
  /// E sign G (G - G_n): what has been done of the way.
  template <class T>
  MYOGROWTH_FUNCTION T done(const T& G, const T& G_n) const {
    return sign > 0 ? T(E * G * (G - G_n)) : T(E * G * (G_n - G));
  }
  /// room times sign times the derivative of done - k q at the root. As k q = done there, nothing cancels.
  template <class T>
  MYOGROWTH_FUNCTION T room_times_slope(const T& G, const T& G_n, const T& k) const {
    return (E * (G + G - G_n) + k * crit) * room(G) + gamma * done(G, G_n);
  }
};

/// The equation of growth, and of removal.
template <class P>
MYOGROWTH_FUNCTION GrowthEquation<P, 1> equation_of(const GrowthRate<P>& growth, const P& dt, Real<P> G_n) {
  return {growth.G_max, growth.gamma, growth.lambda_crit, growth.G_max - P(1), dt, growth.growth_time, G_n};
}
template <class P>
MYOGROWTH_FUNCTION GrowthEquation<P, -1> equation_of(const GrowthRate<P>& growth,
                                                     const RemovalRate<P>& removal, const P& dt,
                                                     Real<P> G_n) {
  return {removal.G_min,
          removal.gamma,
          removal.lambda_crit,
          growth.G_max - removal.G_min,
          dt,
          removal.removal_time,
          G_n};
}

/// The same equation on plain numbers, with the bracket of its root, from G_n to end.
template <class V, int sign>
struct BracketedEquation : GrowthEquation<V, sign> {
  V lambda, G_n, end;

  MYOGROWTH_FUNCTION BracketedEquation(const GrowthEquation<V, sign>& equation, V G_n_, V lambda_)
      : GrowthEquation<V, sign>(equation), lambda(lambda_), G_n(G_n_), end(lambda_ / equation.crit) {
    if (!before(end, this->limit)) end = this->limit;
  }

  /// Whether x comes before y on the way from G_n to end.
  MYOGROWTH_FUNCTION static bool before(V x, V y) { return sign > 0 ? x < y : x > y; }
  /// k q - done: positive before the root.
  MYOGROWTH_FUNCTION V to_do(V G) const { return this->k(G) * this->q(lambda, G) - this->done(G, G_n); }
};

/// Whether rounding is all that is left after this step. Newton's method leaves step^2 R''/(2 R'), and R''/R'
/// is at most 2 gamma/room + 2/G (a little more in k, for gamma < 1): less than half of G's last place is
/// left.
template <class V>
MYOGROWTH_FUNCTION bool is_last_step(V step, V G, V room, V gamma) {
  return step * step * ((1 + gamma) * G + room) < last_place<V>() / 4 * G * G * room;
}

/// What is left of the way to the root, sign (root - G), by Householder's method of order four, from either
/// side. At G + sign x t, x = room(G)/room_n, k is k(G) (1 - t/room_n)^gamma, whose derivatives need no
/// division, and done - k q is
///
///   -f + b t + a2 t^2 + a3 t^3 + ...
template <class V, int sign>
MYOGROWTH_FUNCTION V fourth_order_step(const BracketedEquation<V, sign>& eq, V G, V x, V k) {
  const V g1 = eq.gamma * eq.per_room, g2 = g1 * (g1 - eq.per_room) / 2,
          g3 = g2 * (g1 - 2 * eq.per_room) * V(1.0 / 3);
  const V kq = k * eq.q(eq.lambda, G), kc = k * eq.crit * x;
  const V f = kq - eq.done(G, eq.G_n);
  const V b = (kc + eq.E * (G + G - eq.G_n) * x) + g1 * kq;
  const V a2 = (sign * eq.E * (x * x) - g1 * kc) - g2 * kq, a3 = g2 * kc + g3 * kq;
  return x * f * (b * b + a2 * f) / (b * b * b + f * ((a2 + a2) * b + a3 * f));
}

/// Whether rounding is all that is left after such a step: what it leaves is well below C^3 step^4 where
/// Newton's method leaves no more than C step^2, C = (1 + gamma)/room + 1/G.
template <class V>
MYOGROWTH_FUNCTION bool is_last_fourth_order_step(V step, V G, V room, V gamma) {
  const V unit = G * room, s = step * ((1 + gamma) * G + room);
  return s * s * (s * step) < last_place<V>() * G * (unit * unit * unit);
}

/// A start before the root that is far better than G_n when the step is long. At the root k q is at most
/// `bound`, which limits the distance u from the end of the bracket in three ways: by what is left of q or of
/// k at the end itself, and by their product.
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_APART V long_step_start(const BracketedEquation<V, sign>& eq) {
  const V way = sign * (eq.end - eq.G_n);
  const V bound = eq.E * (sign > 0 ? eq.end : eq.G_n) * way / eq.A;
  const V q_end = eq.q(eq.lambda, eq.end);
  const V k_end = eq.k(eq.end) / eq.A;
  V u = way;
  const auto tighten = [&u](V candidate) {
    if (candidate < u) u = candidate;
  };
  // Only where the quotient is below 1: the others do not limit u, and might overflow.
  if (bound < q_end) tighten(eq.room_n * pow(bound / q_end, 1 / eq.gamma));
  if (bound < eq.crit * k_end * u) tighten(bound / (eq.crit * k_end));
  if (bound < eq.crit * eq.room_n)
    tighten(eq.room_n * pow(bound / (eq.crit * eq.room_n), 1 / (eq.gamma + 1)));
  // A hair more keeps it before the root in spite of rounding.
  const V start = eq.end - sign * u * (1 + 64 * last_place<V>());
  return eq.before(eq.G_n, start) ? start : eq.G_n;
}

/// gamma = 0: the equation is quadratic in G, and the same for either sign.
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_APART V root_of_quadratic(const BracketedEquation<V, sign>& eq) {
  const V b = eq.A * eq.crit - eq.E * eq.G_n;
  const V c = eq.A * eq.lambda;
  const V root = sqrt(b * b + 4 * eq.E * c);
  return b > 0 ? 2 * c / (b + root) : (root - b) / (2 * eq.E);
}

/// Halves the way from G, before the root, to end, behind it, down to rounding: for parameters so far out
/// (gamma in the hundreds) that Newton's method would take its time.
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_APART V bisect(const BracketedEquation<V, sign>& eq, V G, V end,
                                            int& iterations) {
  constexpr int most =
      20 + std::numeric_limits<V>::digits;  // from the whole range to a factor of 4, and to rounding
  for (int i = 0; i < most; ++i) {
    ++iterations;
    const bool is_wide = end > 4 * G || G > 4 * end;
    const V middle = is_wide ? sqrt(G) * sqrt(end) : G + (end - G) / 2;
    if (!(eq.before(G, middle) && eq.before(middle, end))) break;
    (eq.to_do(middle) > 0 ? G : end) = middle;
  }
  return G;
}

/// Newton's method in G for gamma >= 1 and in k for 0 < gamma < 1, monotone from G_n's side; if the start may
/// lie behind the root, the first step leads there. A Newton step in k is one in G with the room left,
/// room^gamma being proportional to k, shortened by its own factor. (For removal with 0 < gamma < 1 of more
/// than half of G_n the step may pass the root, and bisection takes over.)
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_APART V newton(const BracketedEquation<V, sign>& eq, V G, bool may_be_behind,
                                            int& iterations) {
  constexpr int patience = 64;  // three times what gamma = 20 takes
  const V gamma_per_room = eq.gamma * eq.per_room;
  V last = G;
  for (; iterations < patience; may_be_behind = false) {
    ++iterations;
    const V room = eq.room(G);
    if (!(room > 0)) return G;  // at the limit, where all below is 0
    const V x = room * eq.per_room;
    const V k = eq.A * eq.to_gamma(x), kq = k * eq.q(eq.lambda, G);
    // Both times x: no division for k' = gamma k/room.
    const V to_do = (kq - eq.done(G, eq.G_n)) * x;
    const V slope = (eq.E * (G + G - eq.G_n) + k * eq.crit) * x + gamma_per_room * kq;
    // Growth has a concave R, the equation over G; removal a convex equation as it stands.
    const V divisor = sign > 0 ? slope * G + to_do : slope;
    if (divisor == 0) break;  // both are below the smallest number
    V step = (sign > 0 ? to_do * G : to_do) / divisor;
    if (eq.gamma < 1) {
      const V of_room = eq.gamma * step / room;
      step = of_room < 1 ? -room * expm1(log1p(-of_room) / eq.gamma) : room;
    }
    const V next = G + sign * step;
    if (may_be_behind && eq.before(next, G)) {
      if (is_last_step(step, next, room, eq.gamma)) return next;
      last = G = eq.before(eq.G_n, next) ? next : eq.G_n;
      continue;
    }
    if (!eq.before(G, next)) {
      const bool passed = -step > 16 * last_place<V>() * G && eq.before(last, G);
      return passed ? bisect(eq, last, G, iterations) : G;  // else at rounding level
    }
    if (!eq.before(next, eq.end)) return sign > 0 ? eq.end : bisect(eq, G, eq.end, iterations);
    if (is_last_step(step, next, room, eq.gamma)) return next;
    last = G;
    G = next;
  }
  return bisect(eq, G, eq.end, iterations);
}

template <class V, int sign>
MYOGROWTH_FUNCTION V growth_root(const BracketedEquation<V, sign>& eq, int& iterations) {
  if (!(eq.gamma > last_place<V>())) {  // k is constant to rounding
    iterations = 1;
    return root_of_quadratic(eq);
  }
  // If an explicit step would leave the bracket, Newton from G_n would crawl: k falls by e a step.
  const bool is_long = eq.A * eq.q(eq.lambda, eq.G_n) > eq.E * eq.G_n * sign * (eq.end - eq.G_n);
  if (is_long || eq.gamma < 1) return newton(eq, is_long ? long_step_start(eq) : eq.G_n, false, iterations);
  // Else two steps of higher order are mostly all it takes; what they leave is Newton's.
  V G = eq.G_n + sign * fourth_order_step(eq, eq.G_n, V(1), eq.A);
  if (!(eq.before(eq.G_n, G) && eq.before(G, eq.end))) G = eq.G_n;
  const V room = eq.room(G), x = room * eq.per_room,
          step = fourth_order_step(eq, G, x, eq.A * eq.to_gamma(x));
  const V next = G + sign * step;
  iterations = 1;
  if (is_last_fourth_order_step(step, next, room, eq.gamma)) return next;
  if (eq.before(eq.G_n, next) && eq.before(next, eq.end)) G = next;
  return newton(eq, G, true, iterations);
}

/// Gives the converged value the derivatives that the scalar carries, by the implicit function theorem: one
/// Newton step in T, whose value is nil and whose derivatives are those of the root.
template <class T, class P, int sign, class V>
MYOGROWTH_FUNCTION T with_derivatives(const GrowthEquation<P, sign>& eq, const T& G_n, const T& lambda,
                                      V G_end, std::false_type) {
  const T G(G_end);
  const T k = eq.k(G);
  const T correction = (eq.done(G, G_n) - k * eq.q(lambda, G)) * eq.room(G) / eq.room_times_slope(G, G_n, k);
  return sign > 0 ? T(G - correction) : T(G + correction);
}

template <class T, class P, int sign>
MYOGROWTH_FUNCTION T with_derivatives(const GrowthEquation<P, sign>&, const T&, const T&, T G_end,
                                      std::true_type) {
  return G_end;  // a plain number carries none
}

/// The step that either equation makes.
template <class T, class P, int sign>
MYOGROWTH_FUNCTION GrowthStep<T> solve(const GrowthEquation<P, sign>& lifted, const T& G_n, const T& lambda) {
  using V = Real<T>;
  const BracketedEquation<V, sign> eq(GrowthEquation<V, sign>(lifted), value(G_n), value(lambda));
  if (!(eq.A > 0)) {  // dt k is below the smallest number, or a parameter is not allowed
    return {eq.A == 0 ? G_n : T(std::numeric_limits<V>::quiet_NaN()), T(0), 0};
  }

  int iterations = 0;
  V G = growth_root(eq, iterations);
  if (!eq.before(eq.G_n, G)) G = eq.G_n;
  if (!eq.before(G, eq.end)) G = eq.end;
  if (!eq.before(G, eq.limit)) return {T(lifted.limit), T(0), iterations};  // saturated

  const T G_end = with_derivatives(lifted, G_n, lambda, G, std::is_same<T, V>());
  const T k = lifted.k(G_end);
  const T slope = lifted.room_times_slope(G_end, G_n, k);
  T dG_dlambda = value(slope) > 0 ? T(k * lifted.room(G_end) / slope) : T(0);
  // Its bound, where k times the room is so small that it has lost its digits.
  if (sign > 0 && value(dG_dlambda) * eq.crit > 1) dG_dlambda = T(1 / eq.crit);
  return {G_end, dG_dlambda, iterations};
}

}  // namespace detail

/// Solves R(G) = 0 (above) for one step of length dt [time] under the total stretch lambda at its end; with
/// removal as well, if it is on.
///
/// Works for every G_n > 0, lambda > 0 and dt, also infinite. G never leaves the bracket above.
/// dG/dlambda is the exact derivative of this discrete update, from the implicit function theorem at the
/// converged G; it is 0 at the thresholds, at G_max and at G_min, and for growth lies in [0, 1/lambda_crit].
template <class T, class P>
MYOGROWTH_FUNCTION GrowthStep<T> solve_growth(const GrowthRate<P>& growth, const RemovalRate<P>& removal,
                                              const T& G_n, const T& lambda,
                                              const std::common_type_t<P>& dt) {
  using V = Real<T>;
  const V G = value(G_n), stretch = value(lambda);
  if (!(value(dt) > 0)) return {G_n, T(0), 0};
  if (stretch > value(growth.lambda_crit) * G && G < value(growth.G_max)) {
    return detail::solve(detail::equation_of(growth, dt, G), G_n, lambda);
  }
  if (value(removal.removal_time) > 0 && stretch < value(removal.lambda_crit) * G &&
      G > value(removal.G_min)) {
    return detail::solve(detail::equation_of(growth, removal, dt, G), G_n, lambda);
  }
  return {G_n, T(0), 0};
}

/// The same without removal.
template <class T, class P>
MYOGROWTH_FUNCTION GrowthStep<T> solve_growth(const GrowthRate<P>& growth, const T& G_n, const T& lambda,
                                              const std::common_type_t<P>& dt) {
  return solve_growth(growth, RemovalRate<P>(), G_n, lambda, dt);
}

}  // namespace myogrowth

#endif
