/// @file
/// One backward-Euler step of the growth law (paper, eq. 4): G and dG/dlambda. It cannot fail.
///
///   R(G) = G - G_n - dt k_g(G) (lambda/G - lambda_crit) = 0
///
/// If lambda <= lambda_crit G_n, or G_n >= G_max, or dt <= 0, nothing grows. Otherwise the bracket
/// [G_n, min(G_max, lambda/lambda_crit)] holds exactly one root for any dt, because k_g and the criterion are
/// positive and decreasing there, so that R' >= 1. Removal is the mirror image, from G_n down to
/// max(G_min, lambda/lambda_crit_rev). The code has both, by a sign.
///
/// The unknown is the part y of the way to the limit (G_max or G_min) that the step goes: G = G_n + sign r y,
/// r = |limit - G_n|. With the growth number a = dt k_g(G_n), R G/r^2 = 0 is
///
///   E (alpha + sign y) y = A (1 - y)^gamma (Q - crit y)
///
///   alpha = G_n/r,  Q = |lambda - crit G_n|/r,  (A, E) = (a/r, 1), and (1/r, 1/a) where a > 1
///
/// so that nothing overflows for any dt. Two steps of order four from y = 0 solve it in most cases. Newton's
/// method does the rest: for gamma >= 1 it climbs to the root from one side; for 0 < gamma < 1 it does so in
/// the variable (1 - y)^gamma; for gamma = 0 the equation is quadratic (docs/theory.md has the proofs).
///
/// One text serves numbers and SIMD packs (many/pack.hpp), whose comparisons give one answer a lane: & and |
/// combine the answers of both.
#ifndef MYOGROWTH_GROWTH_STEP_HPP
#define MYOGROWTH_GROWTH_STEP_HPP

#include <limits>

#include "growth_rate.hpp"

namespace myogrowth {

/// Result of one time step of eq. 4.
template <class T>
struct GrowthStep {
  T G;             ///< sarcomere number at the end of the step [-]
  T dG_dlambda;    ///< its derivative with respect to the total stretch at the end, at fixed G_n and dt [-]
  int iterations;  ///< iterations of the local solve; 0: nothing grew
};

namespace detail {

/// The parameters of growth (sign 1) or of removal (-1), and the quotients that all points share.
template <class P, int sign>
struct Branch {
  P limit, gamma, crit;             ///< G_max or G_min, and the exponent and threshold that go with it
  P per_time, per_width, per_crit;  ///< 1/tau or 1/tau_rev; 1/|limit - where the capacity is 1|; 1/crit
  Exponent<P> to_gamma;

  MYOGROWTH_FUNCTION Branch(const P& limit_, const P& gamma_, const P& crit_, const P& width, const P& time)
      : limit(limit_),
        gamma(gamma_),
        crit(crit_),
        per_time(P(1) / time),
        per_width(P(1) / width),
        per_crit(P(1) / crit_),
        to_gamma(gamma_) {}

  /// The values of one that carries derivatives.
  template <class Q>
  MYOGROWTH_FUNCTION explicit Branch(const Branch<Q, sign>& b)
      : limit(value(b.limit)),
        gamma(value(b.gamma)),
        crit(value(b.crit)),
        per_time(value(b.per_time)),
        per_width(value(b.per_width)),
        per_crit(value(b.per_crit)),
        to_gamma(gamma) {}

  /// sign (a - b): how far a is ahead of b on the way to the limit.
  template <class T>
  MYOGROWTH_FUNCTION static T ahead(const T& a, const T& b) {
    return sign > 0 ? T(a - b) : T(b - a);
  }
  /// a + sign y: where one is on this way who goes on by y from a.
  template <class T>
  MYOGROWTH_FUNCTION static T on(const T& a, const T& y) {
    return sign > 0 ? T(a + y) : T(a - y);
  }
  /// Whether a comes before b on this way.
  template <class T>
  MYOGROWTH_FUNCTION static auto precedes(const T& a, const T& b) {
    return sign > 0 ? a < b : b < a;
  }
  /// The first of two on this way.
  template <class T>
  MYOGROWTH_FUNCTION static T first(const T& a, const T& b) {
    return sign > 0 ? minimum(a, b) : maximum(a, b);
  }
  /// The last of two on this way.
  template <class T>
  MYOGROWTH_FUNCTION static T last(const T& a, const T& b) {
    return sign > 0 ? maximum(a, b) : minimum(a, b);
  }
  /// Where growth ends under a stretch: the limit, or where lambda_e has come to its threshold.
  template <class T>
  MYOGROWTH_FUNCTION T end(const T& lambda) const {
    return first(quotient(lambda, T(crit), T(per_crit)), T(limit));
  }
};

template <class P>
MYOGROWTH_FUNCTION Branch<P, 1> branch_of(const GrowthRate<P>& growth) {
  return {growth.G_max, growth.gamma, growth.lambda_crit, growth.G_max - P(1), growth.tau};
}
template <class P>
MYOGROWTH_FUNCTION Branch<P, -1> branch_of(const GrowthRate<P>& growth, const RemovalRate<P>& removal) {
  return {removal.G_min, removal.gamma_rev, removal.lambda_crit_rev, growth.G_max - removal.G_min,
          removal.tau_rev};
}

/// Where the muscle grows, and where sarcomeres are removed, under the stretch lambda. T: a plain number or a
/// pack.
/// @{
template <class T, class P>
MYOGROWTH_FUNCTION LaneMask<T> grows(const GrowthRate<P>& growth, const T& G_n, const T& lambda,
                                     const T& dt) {
  const T zero(Real<T>(0)), crit(value(growth.lambda_crit)), limit(value(growth.G_max));
  return (dt > zero) & (lambda > crit * G_n) & (G_n < limit);
}
template <class T, class P>
MYOGROWTH_FUNCTION LaneMask<T> shrinks(const RemovalRate<P>& removal, const T& G_n, const T& lambda,
                                       const T& dt) {
  const T zero(Real<T>(0)), tau(value(removal.tau_rev)), crit(value(removal.lambda_crit_rev)),
      limit(value(removal.G_min));
  return (tau > zero) & (dt > zero) & (lambda < crit * G_n) & (G_n > limit);
}
/// @}

/// The equation of a step in y (above). A lane that does not move has A = 0, and y = 0.
template <class T, class P, int sign>
struct StepEquation {
  const Branch<P, sign>& b;
  T G_n, lambda;
  T r, per_r, alpha, Q, A, E;
  LaneMask<T> out_of_range;  ///< lanes of a pack whose 1/a its fast division cannot take

  MYOGROWTH_FUNCTION StepEquation(const Branch<P, sign>& branch, const LaneMask<T>& moves, const T& G_n_,
                                  const T& lambda_, const T& dt)
      : b(branch),
        G_n(G_n_),
        lambda(lambda_),
        r(rounded(select(moves, b.ahead(T(b.limit), G_n), T(Real<T>(1))))),
        per_r(T(Real<T>(1)) / r),
        alpha(G_n * per_r),
        Q(b.ahead(lambda, T(T(b.crit) * G_n)) * per_r),
        A(select(moves, dt, T(Real<T>(0))) * T(b.per_time) * b.to_gamma(T(r * T(b.per_width)))),
        E(Real<T>(1)),
        out_of_range(deciding(E) < deciding(E)) {
    const T a = A, one = E;  // the growth number
    A = a * per_r;
    const auto steep = deciding(a) > deciding(one);
    if (any(steep)) {
      E = one / rounded(select(steep, a, one));
      A = select(steep, per_r, A);
      out_of_range = beyond_reciprocals(E);
    }
  }

  /// The two sides of the equation at a G, and what its derivative is made of.
  struct Sides {
    T x, y, g;      ///< |limit - G|/r, |G - G_n|/r and G/r
    T k, rhs, lhs;  ///< A x^gamma; right side; left side
  };
  MYOGROWTH_FUNCTION Sides sides(const T& x, const T& y, const T& g, const T& q) const {
    const T k = A * b.to_gamma(x);
    return {x, y, g, k, k * q, E * g * y};
  }
  /// By y, which has more digits where the step is short; `x` as it is to be taken.
  MYOGROWTH_FUNCTION Sides sides_at_y(const T& y, const T& x) const {
    return sides(x, y, b.on(alpha, y), T(Q - T(b.crit) * y));
  }
  /// By G, which has more digits near the limit.
  MYOGROWTH_FUNCTION Sides sides_at_G(const T& G) const {
    const T x = b.ahead(T(b.limit), G) * per_r, q = b.ahead(lambda, T(T(b.crit) * G)) * per_r;
    return sides(maximum(x, T(P(0))), T(b.ahead(G, G_n) * per_r), T(G * per_r), q);
  }

  /// x times the derivative of (left - right) at the root, where both are `side`.
  MYOGROWTH_FUNCTION T slope_times_x(const Sides& s, const T& side) const {
    return (E * b.on(s.g, s.y) + s.k * T(b.crit)) * s.x + T(b.gamma) * side;
  }
  /// dG/dlambda at the root, by the implicit function theorem; 0 where G is not free to change.
  MYOGROWTH_FUNCTION T dG_dlambda(const Sides& s, const LaneMask<T>& is_free) const {
    const T zero(Real<T>(0)), tiny((std::numeric_limits<Real<T>>::min)());
    const T derivative = s.k * s.x / maximum(slope_times_x(s, s.lhs), tiny);
    // (Its bound, where k x has lost its digits.)
    return select(is_free, sign > 0 ? minimum(derivative, T(b.per_crit)) : derivative, zero);
  }

  /// y at the end of the bracket.
  MYOGROWTH_FUNCTION T part_of(const T& end) const {
    return select(end == T(b.limit), T(P(1)), T(b.ahead(end, G_n) * per_r));
  }
  /// Whether an explicit step would leave the bracket.
  MYOGROWTH_FUNCTION LaneMask<T> leaves_bracket(const T& y_end) const { return A * Q > E * alpha * y_end; }

  /// A step to the root by Householder's method of order four, as numerator and denominator.
  ///
  /// At y + x t, (1 - y)^gamma is x^gamma (1 - t)^gamma, whose derivatives need no division, and left - right
  /// is
  ///
  ///   -f + b t + a2 t^2 + a3 t^3 + ...
  struct Fraction {
    T over, under;
  };
  MYOGROWTH_FUNCTION Fraction fourth_order_step(const T& rhs, const T& kc, const T& lhs, const T& rate,
                                                const T& curvature) const {
    const P c = b.gamma;
    const T g1(c), g2(c * (c - 1) / 2), g3(c * (c - 1) * (c - 2) * P(1.0 / 6));
    const T f = rhs - lhs, slope = (rate + kc) + g1 * rhs;
    const T a2 = b.ahead(curvature, T(P(0))) - g1 * kc - g2 * rhs, a3 = g2 * kc + g3 * rhs;
    const T square = slope * slope;
    return {f * (square + a2 * f), slope * square + f * ((a2 + a2) * slope + a3 * f)};
  }

  /// A start before the root that is far better than G_n when the step is long: its distance u from the end
  /// of the bracket, in y. At the root the right side is at most `bound`, which limits u in three ways: by
  /// what is left of its two factors at the end itself, and by their product.
  MYOGROWTH_FUNCTION T long_step_start(const T& end, const T& y_end, const LaneMask<T>& is_long) const {
    const T zero(P(0)), one(P(1)), crit(b.crit), limit(b.limit);
    const T bound = E * (sign > 0 ? T(alpha + y_end) : alpha) * y_end / rounded(select(is_long, A, one));
    const auto at_limit = end == limit;
    const T q_end = select(at_limit, T(b.ahead(lambda, T(crit * limit)) * per_r), zero);
    const T k_end = b.to_gamma(select(is_long, T(b.ahead(limit, end) * per_r), one));
    // Each bound counts only where it is below 1: so no power overflows.
    T u = y_end;
    const auto tighten = [&](const T& over, const T& under, P exponent) {
      const LaneMask<T> there = is_long & (under > over);
      const T part = select(there, over, one) / rounded(select(there, under, one));
      u = minimum(u, exponent == 1 ? part : T(pow(part, exponent)));
    };
    tighten(bound, q_end, 1 / b.gamma);
    tighten(bound, T(crit * k_end), 1);
    tighten(bound, crit, 1 / (b.gamma + 1));
    return u * T(1 + 64 * last_place<P>());  // before the root in spite of rounding
  }

  /// gamma = 0: the equation is quadratic in y, and in G/r, which has more digits where much is removed.
  struct QuadraticRoot {
    T y, g;
  };
  MYOGROWTH_FUNCTION QuadraticRoot root_of_quadratic() const {
    const T Ac = A * T(b.crit), Ea = E * alpha, difference = Ac - Ea, two(P(2));
    const T product = two * A * (lambda * per_r);
    const T root = sqrt(T(difference * difference + two * E * product));
    const T sum = abs(difference) + root;
    const auto is_steep = difference > T(P(0));
    return {two * A * Q / (Ea + Ac + root), select(is_steep, product, sum) / select(is_steep, sum, two * E)};
  }
};

/// Below this alpha the powers of it that a step multiplies may leave the range.
template <class V>
MYOGROWTH_FUNCTION constexpr V least_alpha() {
  return sizeof(V) < sizeof(double) ? V(1e-3) : V(1e-60);
}

/// The step in y that a Newton step in z = (1 - y)^gamma is, given the Newton step in y.
template <class T, class V>
MYOGROWTH_FUNCTION T step_of_power(const T& step, const T& x, V gamma) {
  return -x * expm1(T(log1p(T(T(-gamma) * step / x)) / T(gamma)));
}

/// One step in the lanes that move: G and dG/dlambda.
template <class T>
struct SolvedStep {
  T x, y;  ///< what is left of the way to the limit, and what has been gone of it [-]
  T G, dG_dlambda;
  LaneMask<T> left;  ///< lanes without a result, in packs
  int iterations;
};

/// What Newton's method found.
template <class T>
struct StepRoot {
  T G;
  LaneMask<T> left;  ///< the lanes without a result: they need bisection
  int iterations;
};

/// Newton's method for the lanes `active`, in G for gamma >= 1 and in |limit - G|^gamma for 0 < gamma < 1.
/// The iterates go towards the root from G_n's side; from a start behind the root the first step leads before
/// it. (For removal with 0 < gamma < 1 of more than half of G_n a step may pass the root, and bisection takes
/// over.)
template <class T, class V, int sign>
MYOGROWTH_FUNCTION StepRoot<T> newton(const StepEquation<T, V, sign>& eq, const T& end, const T& start,
                                      LaneMask<T> active) {
  constexpr V epsilon = last_place<V>();
  constexpr int patience = 64;  // three times what gamma = 20 takes
  const Branch<V, sign>& b = eq.b;
  const T zero(V(0)), one(V(1)), gamma_plus_1(b.gamma + 1), smallest(least_alpha<V>());
  const LaneMask<T> none = one < zero, lost = active & !(eq.alpha > smallest);
  const T y_end = eq.part_of(end);
  LaneMask<T> is_long = eq.leaves_bracket(y_end);
  is_long = active & is_long;
  const LaneMask<T> has_start = b.precedes(eq.G_n, start), before_end = b.precedes(start, end);
  LaneMask<T> may_be_behind = has_start & before_end & !is_long, moved = none;
  StepRoot<T> root{select(may_be_behind, start, eq.G_n), lost, 0};
  T& G = root.G;
  if (any(is_long)) {
    const T u = eq.long_step_start(end, y_end, is_long);
    G = select(is_long, b.last(b.on(end, T(-eq.r * u)), eq.G_n), G);
  }
  active = active & !lost;
  for (; root.iterations < patience && any(active); ++root.iterations) {
    const auto s = eq.sides_at_G(select(active, G, eq.G_n));
    const T residual = (s.rhs - s.lhs) * s.x, slope = eq.slope_times_x(s, s.rhs);
    // For growth R is concave over G, which is the equation over G/r; for removal the equation itself.
    const T over = sign > 0 ? T(residual * s.g) : residual;
    const T under = sign > 0 ? T(slope * s.g + residual) : slope;
    const auto divides = active & (under > zero);  // zero: at the limit, or below all numbers
    T step = rough_quotient(select(divides, over, zero), rounded(select(divides, under, one)));
    if (b.gamma < 1) step = step_of_power(step, select(divides, s.x, one), b.gamma);
    const T next = b.on(G, T(eq.r * step)), g = next * eq.per_r;
    const auto onward = b.precedes(G, next), within = b.precedes(next, end);
    const auto passed = moved & (-step > T(16 * epsilon) * s.g);  // else backward by rounding only
    root.left = root.left | (active & passed);
    if (sign < 0) root.left = root.left | (active & (b.ahead(next, end) > T(64 * epsilon) * G));
    const auto goes = active & (onward | may_be_behind);
    // What Newton's method leaves is step^2 R''/(2 R'), and R''/R' is at most 2 gamma/x + 2/g (a little
    // more for gamma < 1): the last step leaves less than half of G's last place.
    const auto last = step * step * (gamma_plus_1 * g + s.x) < T(epsilon / 4) * g * g * s.x;
    G = select(goes, b.last(b.first(next, end), eq.G_n), G);
    active = goes & within & !last;
    moved = onward;
    may_be_behind = none;
  }
  root.left = root.left | active;
  return root;
}

/// The lanes that Newton's method left: a pack leaves them to its caller. A number goes on by halving the
/// bracket down to rounding: for parameters so far out (gamma in the hundreds, G_max beyond 1e60) that
/// Newton's method would take long or lose its digits.
/// @{
template <class T, class V, int sign>
MYOGROWTH_FUNCTION void bisect(const StepEquation<T, V, sign>&, const T&, StepRoot<T>&) {}
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE void bisect(const StepEquation<V, V, sign>& eq, V end,
                                                  StepRoot<V>& root) {
  root.left = false;
  V& G = root.G = eq.G_n;
  constexpr int most = 200;  // 12 geometric means bring any two numbers near, 64 halvings to rounding
  for (int i = 0; i < most; ++i) {
    ++root.iterations;
    const bool near_by = end <= 4 * G && G <= 4 * end;
    const V middle = near_by ? G + (end - G) / 2 : sqrt(G) * sqrt(end);
    if (!(eq.b.precedes(G, middle) && eq.b.precedes(middle, end))) break;
    const auto s = eq.sides_at_G(middle);
    (s.rhs > s.lhs ? G : end) = middle;
  }
}
/// @}

/// Goes on in the lanes where few_steps has not led to the root.
///
/// It takes its arguments by value and makes the equation again: so the caller, which rarely comes here,
/// keeps nothing in memory for it.
template <class T, class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE SolvedStep<T> solve_further(Branch<V, sign> b, LaneMask<T> moves, T G_n,
                                                                  T lambda, T dt, SolvedStep<T> found) {
  const StepEquation<T, V, sign> eq(b, moves, G_n, lambda, dt);
  const T end = b.end(lambda);
  const LaneMask<T> active = found.left & !eq.out_of_range;
  StepRoot<T> root = newton(eq, end, found.G, active);
  if (std::is_same<T, V>::value && any(root.left)) bisect(eq, end, root);
  const T G = select(active, b.last(b.first(root.G, end), G_n), G_n);
  const auto s = eq.sides_at_G(G);
  const T dG_dlambda = eq.dG_dlambda(s, b.precedes(G, T(b.limit)));
  const LaneMask<T> left = (found.left & eq.out_of_range) | root.left;
  return {select(active, s.x, found.x),
          select(active, s.y, found.y),
          select(active, G, found.G),
          select(active, dG_dlambda, found.dG_dlambda),
          left,
          found.iterations + root.iterations};
}

/// What one or two steps of order four give, or the quadratic equation of gamma = 0. The lanes `left` are not
/// at the root.
template <class T, class V, int sign>
MYOGROWTH_FUNCTION SolvedStep<T> few_steps(const Branch<V, sign>& b, const LaneMask<T>& moves, const T& G_n,
                                           const T& lambda, const T& dt) {
  const T zero(V(0)), one(V(1)), limit(b.limit), crit(b.crit);
  constexpr V epsilon = last_place<V>();
  const StepEquation<T, V, sign> eq(b, moves, G_n, lambda, dt);
  const T end = b.end(lambda), nan(std::numeric_limits<V>::quiet_NaN());
  constexpr bool is_number = std::is_same<T, V>::value;
  // (A time or a gamma so far out that the growth number is 0 times infinity.)
  if (is_number && any(!is_finite(eq.A))) return {nan, nan, nan, nan, !moves, 0};
  // If an explicit step would leave the bracket, steps from y = 0 do not converge. (Packs ask later, if at
  // all.)
  const bool is_long = is_number && any(eq.leaves_bracket(eq.part_of(end)));
  LaneMask<T> solved = !moves;
  T y = zero, G = G_n;
  int iterations = 0;
  if (b.gamma >= 1 && !is_long) {
    iterations = 1;
    const auto from_0 = eq.fourth_order_step(T(eq.A * eq.Q), T(eq.A * crit), zero, T(eq.E * eq.alpha), eq.E);
    y = rough_quotient(from_0.over, from_0.under);
    // Growth goes on in y; removal in G, which may be far below G_n, where y has too few digits for it.
    const T nearest(epsilon), G_1 = b.first(b.on(G_n, T(eq.r * y)), b.on(limit, T(-eq.r * nearest)));
    const auto s = sign > 0 ? eq.sides_at_y(y, maximum(T(one - y), nearest)) : eq.sides_at_G(G_1);
    const auto more = eq.fourth_order_step(s.rhs, T(s.k * crit * s.x), s.lhs, T(eq.E * b.on(s.g, s.y) * s.x),
                                           T(eq.E * (s.x * s.x)));
    // (Products below all numbers say nothing.)
    const LaneMask<T> is_valid = more.under > T((std::numeric_limits<V>::min)() / epsilon);
    const T step = near_quotient(T(s.x * more.over), rounded(select(is_valid, more.under, one)));
    y = s.y + step;
    G = sign > 0 ? b.on(G_n, T(eq.r * y)) : b.on(G_1, T(eq.r * step));
    // What such a step leaves is well below C^3 step^4, C = (1 + gamma)/x + 1/g: less than G's last place
    // is left. It may be far off, but growth has only one root with y < 1 and g > 0; removal has one in
    // the bracket.
    const T g = b.on(s.g, step), unit = g * s.x;
    const T C_step = step * (T(1 + b.gamma) * g + s.x);
    const auto leaves_rounding =
        C_step * C_step * abs(T(C_step * step)) < T(epsilon) * g * (unit * unit * unit);
    solved = solved | (is_valid & leaves_rounding);
    if (sign < 0) solved = solved & ((y <= eq.part_of(end)) | (!moves));
  } else if (!(b.gamma > epsilon)) {  // k is constant to rounding
    iterations = 1;
    const auto root = eq.root_of_quadratic();
    y = root.y;
    G = sign > 0 ? b.on(G_n, T(eq.r * y)) : T(eq.r * root.g);
    solved = solved | (y >= zero);
  }
  const T x = sign > 0 ? T(one - y) : T(b.ahead(limit, G) * eq.per_r);
  G = b.last(b.first(G, end), G_n);
  const auto s = eq.sides(maximum(x, zero), y, T(G * eq.per_r), zero);
  // (Lanes that do not move are solved.)
  const LaneMask<T> left = (!solved) | (moves & eq.out_of_range);
  return {s.x, y, G, eq.dG_dlambda(s, b.precedes(G, limit)), left, iterations};
}

/// The step in the lanes that move.
template <class T, class V, int sign>
MYOGROWTH_FUNCTION SolvedStep<T> backward_euler(const Branch<V, sign>& b, const LaneMask<T>& moves,
                                                const T& G_n, const T& lambda, const T& dt) {
  SolvedStep<T> step = few_steps(b, moves, G_n, lambda, dt);
  if (any(step.left)) {
    // The call returns in memory. Its result is copied, so that `step` itself stays in registers.
    const SolvedStep<T> further = solve_further(b, moves, G_n, lambda, dt, step);
    step = further;
  }
  return step;
}

/// The step of a number, or of one that carries derivatives.
/// @{
template <class V, int sign>
MYOGROWTH_FUNCTION GrowthStep<V> step_of(const Branch<V, sign>& b, const V& G_n, const V& lambda, const V& dt,
                                         std::true_type) {
  const SolvedStep<V> s = backward_euler(b, true, G_n, lambda, dt);
  return {s.G, s.dG_dlambda, s.iterations};
}
/// By the implicit function theorem: one Newton step from the root of the values, of which only the
/// derivatives are taken.
template <class T, class P, int sign>
MYOGROWTH_FUNCTION GrowthStep<T> step_of(const Branch<P, sign>& b, const T& G_n, const T& lambda, const T& dt,
                                         std::false_type) {
  using V = Real<T>;
  const SolvedStep<V> values = backward_euler(Branch<V, sign>(b), true, value(G_n), value(lambda), value(dt));
  if (!is_finite(values.G)) return {T(values.G), T(values.G), 0};
  // (x may be 0 where G is not yet the limit to its last digit: 0^gamma has no derivative.)
  if (!b.precedes(values.G, V(value(b.limit))) || !(values.x > 0))
    return {T(b.limit) + T(values.G - value(b.limit)), T(V(0)), values.iterations};
  const StepEquation<T, P, sign> eq(b, true, G_n, lambda, dt);
  const T x(values.x), y(values.y);
  auto s = eq.sides_at_y(y, x);
  T step = (s.rhs - s.lhs) * s.x / eq.slope_times_x(s, s.lhs);
  step = step - T(value(step));
  const T y_end = y + step, G = b.on(G_n, T(eq.r * y_end));
  s = eq.sides_at_y(y_end, T(x - step));
  return {G + T(values.G - value(G)), eq.dG_dlambda(s, true), values.iterations};
}
/// @}

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
  const std::is_same<T, V> is_number{};
  const V G = value(G_n), stretch = value(lambda), time = value(dt);
  if (detail::grows(growth, G, stretch, time)) {
    return detail::step_of(detail::branch_of(growth), G_n, lambda, T(dt), is_number);
  }
  if (detail::shrinks(removal, G, stretch, time)) {
    return detail::step_of(detail::branch_of(growth, removal), G_n, lambda, T(dt), is_number);
  }
  return {G_n, T(V(0)), 0};
}

/// The same without removal.
template <class T, class P>
MYOGROWTH_FUNCTION GrowthStep<T> solve_growth(const GrowthRate<P>& growth, const T& G_n, const T& lambda,
                                              const std::common_type_t<P>& dt) {
  return solve_growth(growth, RemovalRate<P>(), G_n, lambda, dt);
}

}  // namespace myogrowth

#endif
