/// @file
/// The exact flow of the growth law (paper, eq. 4) at a stretch that is held: the second-order time step.
///
/// With the stretch held, eq. 4 is autonomous, and the time to get from G_n to G is an integral. Let u be the
/// distance from G to where growth ends, min(G_max, lambda/lambda_crit):
///
///   dt k_g(G_n) = Int_u^u_n g / (kappa q) du'
///   kappa = (|limit - g|/|limit - G_n|)^gamma,   q = lambda - lambda_crit g
///
/// The integrand has its poles at u = 0 or beyond. So ten Gauss points give it to rounding on panels that go
/// a fixed part of what is left of u, whatever dt, and the u at which it reaches the left side is found by
/// Newton's method. G stays within the bounds of the backward-Euler step by construction, for any dt. Taken
/// at the stretch of the middle of the step, the flow is of second order (docs/theory.md).
#ifndef MYOGROWTH_GROWTH_FLOW_HPP
#define MYOGROWTH_GROWTH_FLOW_HPP

#include "growth_step.hpp"

namespace myogrowth {
namespace detail {

/// Half of a Gauss-Legendre rule of 2 n points: +-point[i] with weight[i], on [-1, 1] (Abramowitz and Stegun,
/// table 25.4).
template <class V, int n>
struct GaussRule {
  V point[entries(n)], weight[entries(n)];
};
template <class V>
MYOGROWTH_FUNCTION constexpr GaussRule<V, 5> gauss_rule() {
  return {{V(0.14887433898163121088482600112972L), V(0.43339539412924719079926594316579L),
           V(0.67940956829902440623432736511487L), V(0.86506336668898451073209668842349L),
           V(0.97390652851717172007796401208445L)},
          {V(0.29552422471475287017389299465132L), V(0.26926671930999635509122692156947L),
           V(0.21908636251598204399553493422816L), V(0.14945134915058059314586339765770L),
           V(0.06667134430868813759356880989333L)}};
}
/// Of four points, for a start.
template <class V>
MYOGROWTH_FUNCTION constexpr GaussRule<V, 2> rough_gauss_rule() {
  return {{V(0.33998104358485626480266575910324L), V(0.86113631159405257522394648889281L)},
          {V(0.65214515486254614262693605077800L), V(0.34785484513745385737306394922200L)}};
}

/// The part of u that a panel goes: for gamma <= 100 ten points then leave 3e-17 of the integrals at most
/// (relative; where the poles are at u = 0).
template <class V>
MYOGROWTH_FUNCTION V flow_panel(V gamma) {
  return V(1.6) / (4 + (gamma < 100 ? gamma : V(100)));
}

/// The flow from G_n towards its end, in the lanes that move.
template <class T, class V, int sign>
struct Flow {
  Branch<V, sign> b;
  T G_n, lambda, end, per_r, u_n, to_limit_end, q_end;
  T a;  ///< growth number, dt k_g(G_n)

  MYOGROWTH_FUNCTION Flow(const Branch<V, sign>& branch, const LaneMask<T>& moves, const T& G_n_,
                          const T& lambda_, const T& dt)
      : b(branch), G_n(G_n_), lambda(lambda_) {
    const T zero(V(0)), one(V(1)), limit(b.limit);
    const T r = rounded(select(moves, b.ahead(limit, G_n), one));
    per_r = one / r;
    // A lane that does not move has an end at half of G_n from it, and stays where it is since a = 0.
    end = select(moves, b.end(lambda), b.on(G_n, T(G_n * T(V(0.5)))));
    u_n = b.ahead(end, G_n);
    const LaneMask<T> at_limit = moves & (end == limit);
    to_limit_end = select(moves & !at_limit, b.ahead(limit, end), zero);
    // (Where both limits meet, rounding may leave less than zero.)
    q_end = select(at_limit, maximum(b.ahead(lambda, T(T(b.crit) * limit)), zero), zero);
    a = select(moves, dt, zero) * T(b.per_time) * b.to_gamma(T(r * T(b.per_width)));
  }

  /// Where it is at u.
  struct At {
    T to_limit, kappa, q, g;
    /// Distance over time.
    MYOGROWTH_FUNCTION T speed() const { return kappa * q / g; }
  };
  MYOGROWTH_FUNCTION At at(const T& u) const {
    const T to_limit = to_limit_end + u;
    return {to_limit, b.to_gamma(T(to_limit * per_r)), q_end + T(b.crit) * u, b.on(end, T(-u))};
  }

  /// Integrals from u on over a distance y: of g/(kappa q), the time, and of g/(kappa q^2), from which
  /// dG/dlambda comes.
  struct Integrals {
    T time, sensitivity;
  };
  template <int n>
  MYOGROWTH_FUNCTION Integrals integrate(const GaussRule<V, n>& rule, const T& u, const T& y) const {
    const T half = y * T(V(0.5)), middle = u - half;
    Integrals sum{T(V(0)), T(V(0))};
    for (int i = 0; i < 2 * n; ++i) {
      const At there = at(middle + half * T(i < n ? rule.point[i] : -rule.point[i - n]));
      const T per_kappa_q = T(V(1)) / (there.kappa * there.q), per_q = rounded(T(there.kappa * per_kappa_q));
      const T f = T(rule.weight[i % n]) * there.g * per_kappa_q;
      sum.time = sum.time + f;
      sum.sensitivity = sum.sensitivity + f * half * per_q;  // (f per_q itself may be beyond all numbers)
    }
    return {sum.time * half, sum.sensitivity};
  }

  /// How far it goes from u on in a time, by the series of the time to third order in the distance, as a
  /// quotient. At most `most`.
  MYOGROWTH_FUNCTION T distance(const T& u, const T& time, const T& most) const {
    const At here = at(u);
    const T zero(V(0)), one(V(1)), gamma(b.gamma);
    const T per_to_limit = one / here.to_limit, per_q = T(b.crit) / here.q, per_g = one / here.g;
    const T l =
        T(V(sign)) * per_g + gamma * per_to_limit + per_q;  // (ln dtime/ddistance)', and its derivative
    const T dl = gamma * per_to_limit * per_to_limit + per_q * per_q - per_g * per_g;
    const T first = time * (here.kappa * here.q * per_g);
    const T divisor = one + first * (l * T(V(0.5)) + first * (dl * T(V(1) / 6) - l * l * T(V(1) / 12)));
    const LaneMask<T> is_valid = divisor > zero;
    return minimum(T(select(is_valid, first, most) / rounded(select(is_valid, divisor, one))), most);
  }
};

/// How far the flow has come: the whole panels behind it, and its distance in the panel that it ends in.
template <class T>
struct FlowProgress {
  T u, to_go, sensitivity;  ///< at the beginning of that panel: u, what is left of a, the integral so far
  T y;                      ///< distance in that panel
  LaneMask<T> ended;        ///< what is left of the way is below rounding: the end is reached
  LaneMask<T> left;         ///< lanes of a pack that take too many panels
};

/// Passes whole panels in the lanes `beyond`, until each is in the panel that it ends in.
template <class T, class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE FlowProgress<T> pass_panels(const Flow<T, V, sign>& flow, V panel,
                                                                  FlowProgress<T> p, LaneMask<T> beyond,
                                                                  int most, int& iterations) {
  const V rest = 1 - panel;
  const T u_end = maximum(T(flow.end * T(last_place<V>() / 8 * rest)), T((std::numeric_limits<V>::min)()));
  for (int i = 0; i < most && any(beyond); ++i) {
    ++iterations;
    const T y = p.u * T(panel);
    const auto whole = flow.integrate(gauss_rule<V>(), p.u, y);
    const LaneMask<T> is_number = whole.time >= T(V(0)), passes = beyond & (whole.time < p.to_go);
    const LaneMask<T> stops = beyond & is_number & !passes;
    p.y = select(stops, T(y * (p.to_go / rounded(select(stops, whole.time, y)))), p.y);
    p.to_go = select(passes, T(p.to_go - whole.time), p.to_go);
    p.sensitivity = select(passes, T(p.sensitivity + whole.sensitivity), p.sensitivity);
    p.u = select(passes, T(p.u * T(rest)), p.u);
    // Not a number: out of range. A number is at the end then; a lane of a pack, whose divisions have a
    // smaller range, need not be.
    const LaneMask<T> at_end = is_number & !(p.u > u_end), out_of_range = !is_number;
    p.ended = p.ended | (beyond & (std::is_same<T, V>::value ? at_end | out_of_range : at_end));
    if (!std::is_same<T, V>::value) p.left = p.left | (beyond & out_of_range);
    beyond = passes & !at_end;
  }
  p.left = p.left | beyond;
  return p;
}

/// G after the time a, with dG/dlambda and dG/dG_n.
template <class T>
struct FlowResult {
  T G, dG_dlambda, dG_dG_n;
  LaneMask<T> left;  ///< lanes without a result, in packs
  int iterations;
};

/// The lanes that Newton's method left: a pack leaves them to its caller. A number goes on to the panel it
/// ends in, and there by Newton's method in a bracket.
/// @{
template <class T, class V, int sign>
MYOGROWTH_FUNCTION void find_in_bracket(const Flow<T, V, sign>&, V, FlowProgress<T>&, int&) {}
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE void find_in_bracket(const Flow<V, V, sign>& flow, V panel,
                                                           FlowProgress<V>& p, int& iterations) {
  constexpr int most_panels = 200000;  // more than there are
  p.left = false;
  if (!is_finite(flow.a)) p.ended = true;  // (dt, or a gamma so large that k_g(G_n) is infinite)
  if (!p.ended) p = pass_panels(flow, panel, p, true, most_panels, iterations);
  if (p.ended) return;
  const V start = p.sensitivity;
  V low = 0, high = p.u * panel;
  for (int i = 0; i < 100; ++i) {
    ++iterations;
    const auto some = flow.integrate(gauss_rule<V>(), p.u, p.y);
    const V step = (p.to_go - some.time) * flow.at(p.u - p.y).speed();
    (step > 0 ? low : high) = p.y;
    V next = p.y + step;
    if (!(next > low && next < high)) next = (low + high) / 2;
    const V moved = abs(V(next - p.y));
    p.y = next;
    if (moved <= 4 * last_place<V>() * (p.u < flow.u_n ? p.u : p.y)) break;
  }
  p.sensitivity = start + flow.integrate(gauss_rule<V>(), p.u, p.y).sensitivity;
  if (!is_finite(p.sensitivity)) p.ended = true;  // so near the end that 1/kappa is infinite
}
/// @}

template <class T, class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE FlowResult<T> follow(Branch<V, sign> b, LaneMask<T> moves, T G_n,
                                                           T lambda, T dt) {
  moves = moves & b.precedes(G_n, b.end(lambda));  // but for rounding, all that are asked for
  constexpr V epsilon = last_place<V>();
  constexpr bool is_number = std::is_same<T, V>::value;
  constexpr int most_panels = is_number ? 200000 : 32;
  const V panel = flow_panel(b.gamma);
  const T zero(V(0)), one(V(1)), gamma(b.gamma), crit(b.crit);
  const Flow<T, V, sign> flow(b, moves, G_n, lambda, dt);

  // A step that ends in the first panel, as most do, starts from the series.
  const T whole = flow.u_n * T(panel), series = flow.distance(flow.u_n, flow.a, whole);
  const LaneMask<T> none = one < zero, beyond = moves & !((zero <= series) & (series < whole * T(V(0.9))));
  FlowProgress<T> p{flow.u_n, flow.a, zero, select(beyond, whole, series), none, none};
  int iterations = 0;
  if (any(beyond)) {
    p = pass_panels(flow, panel, p, beyond, most_panels, iterations);
    // Where there is nothing more to find, what follows must not leave the way, nor its range.
    p.u = select(p.ended, flow.u_n, p.u);
    p.y = select(p.ended | p.left, zero, p.y);
  }
  LaneMask<T> active = moves & !p.ended & !p.left;

  // Then by an integral with few points: what it leaves is so little that Newton's method mostly takes one
  // step.
  const T rough = flow.integrate(rough_gauss_rule<V>(), p.u, p.y).time;
  const T in_panel = p.u * T(panel), per_u = one / p.u, before = p.sensitivity;
  const T better = p.y + flow.distance(T(p.u - p.y), select(active, T(p.to_go - rough), zero), in_panel);
  p.y = minimum(maximum(better, zero), in_panel);
  const T curvature = p.u / G_n + (gamma + T(V(4)));
  for (int i = 0; i < 8 && any(active); ++i) {
    ++iterations;
    const auto some = flow.integrate(gauss_rule<V>(), p.u, p.y);
    const auto here = flow.at(p.u - p.y);
    const T step = (p.to_go - some.time) * here.speed(), next = p.y + step;
    const LaneMask<T> inside = (zero <= next) & (next <= in_panel);
    const T part = step * per_u;
    const LaneMask<T> last = curvature * part * part * flow.u_n < T(epsilon / 4) * (flow.u_n - p.u + next);
    p.y = select(active & inside, next, p.y);
    p.sensitivity =
        select(active, T(before + some.sensitivity + (p.to_go - some.time) / here.q), p.sensitivity);
    p.left = p.left | (active & !inside);
    active = active & inside & !last;
  }
  p.left = p.left | active;
  p.sensitivity = select(p.left, before, p.sensitivity);
  if (is_number && any(p.left)) find_in_bracket(flow, panel, p, iterations);

  const T y = select(p.left | p.ended, zero, p.y);
  const T u = p.u - y;
  const auto last = flow.at(u);
  const T speed = last.speed(), q_n = flow.q_end + crit * flow.u_n;
  // From the nearer end of the way, which leaves more digits.
  const T G = select(u + u < flow.u_n, b.on(flow.end, T(-u)), b.on(G_n, T((flow.u_n - p.u) + y)));
  const T crossed = select(flow.q_end > zero, zero, T(one / crit));  // dG/dlambda at the end
  return {select(p.ended, flow.end, select(moves, b.last(b.first(G, flow.end), G_n), G_n)),
          select(p.ended, crossed, select(moves, T(speed * p.sensitivity), zero)),
          select(p.ended, zero, T(speed * G_n / q_n)), p.left, iterations};
}

/// The flow of a number, or of one that carries derivatives.
/// @{
template <class V, int sign>
MYOGROWTH_FUNCTION GrowthStep<V> flow_of(const Branch<V, sign>& b, const V& G_n, const V& lambda, V dt) {
  const FlowResult<V> r = follow<V>(b, true, G_n, lambda, dt);
  return {r.G, r.dG_dlambda, r.iterations};
}
template <class T, class V, int sign>
MYOGROWTH_FUNCTION GrowthStep<T> flow_of(const Branch<V, sign>& b, const T& G_n, const T& lambda, V dt) {
  const FlowResult<V> r = follow<V>(b, true, value(G_n), value(lambda), dt);
  const T G = T(r.G) + r.dG_dlambda * (lambda - value(lambda)) + r.dG_dG_n * (G_n - value(G_n));
  return {G, T(r.dG_dlambda), r.iterations};
}
/// @}

}  // namespace detail

/// One step of length dt [time] by the exact flow of eq. 4 at the stretch lambda, held, growth and removal.
///
/// The bounds are those of solve_growth, and so is what dG_dlambda means, with respect to the stretch given
/// here. T may carry derivatives with respect to lambda and G_n; the parameters are plain numbers.
template <class T, class V>
MYOGROWTH_FUNCTION GrowthStep<T> flow_growth(const GrowthRate<V>& growth, const RemovalRate<V>& removal,
                                             const T& G_n, const T& lambda, const std::common_type_t<V>& dt) {
  static_assert(std::is_same<V, Real<T>>::value, "the flow takes parameters that are plain numbers");
  const V G = value(G_n), stretch = value(lambda), time = dt;
  if (detail::grows(growth, G, stretch, time)) {
    return detail::flow_of(detail::branch_of(growth), G_n, lambda, time);
  }
  if (detail::shrinks(removal, G, stretch, time)) {
    return detail::flow_of(detail::branch_of(growth, removal), G_n, lambda, time);
  }
  return {G_n, T(V(0)), 0};
}

/// How the error of one time step in G is estimated, for hosts that choose their steps by it [-]: backward
/// Euler against the flow at mid-step (an error of order dt^2), the latter against the mean of the flows at
/// the stretches of both ends (of the order of the stretch's change in dt, squared). No error: NaN in, NaN
/// out.
/// @{
template <class V>
MYOGROWTH_FUNCTION V time_error_of_backward_euler(const GrowthRate<V>& growth, const RemovalRate<V>& removal,
                                                  V G_n, V lambda_n, V lambda, V dt) {
  return abs(V(solve_growth(growth, removal, G_n, lambda, dt).G -
               flow_growth(growth, removal, G_n, (lambda_n + lambda) / 2, dt).G));
}
template <class V>
MYOGROWTH_FUNCTION V time_error_of_midpoint_flow(const GrowthRate<V>& growth, const RemovalRate<V>& removal,
                                                 V G_n, V lambda_n, V lambda, V dt) {
  const V ends =
      flow_growth(growth, removal, G_n, lambda_n, dt).G + flow_growth(growth, removal, G_n, lambda, dt).G;
  return abs(V(flow_growth(growth, removal, G_n, (lambda_n + lambda) / 2, dt).G - ends / 2));
}
/// @}

}  // namespace myogrowth

#endif
