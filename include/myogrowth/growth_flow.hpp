/// @file
/// The exact flow of the growth law (paper, eq. 4) at a stretch that is held: the second-order time step.
///
/// With the stretch held, eq. 4 is autonomous, and the time to get from G_n to G is an integral. Let u be the
/// distance from G to where growth ends, min(G_max, lambda/lambda_crit), and w = ln(u_n/u):
///
///   dt k_g(G_n) = Int_0^w g u / (kappa q) dw',   kappa = (room/room_n)^gamma,   q = lambda - lambda_crit g
///
/// In w the integrand is smooth and grows at most like exp(gamma w), whatever dt: ten Gauss points a panel
/// give it to rounding, and the w at which it reaches the left side is found by Newton's method. G stays
/// within the bounds of the backward-Euler step by construction, for any dt. Taken at the stretch of the
/// middle of the step, the flow is of second order (docs/theory.md).
#ifndef MYOGROWTH_GROWTH_FLOW_HPP
#define MYOGROWTH_GROWTH_FLOW_HPP

#include "growth_step.hpp"

// The masks of numbers are bool; & and | serve them and the masks of packs.
#if defined(__clang__)
#pragma clang diagnostic push
#if __has_warning("-Wbitwise-instead-of-logical")
#pragma clang diagnostic ignored "-Wbitwise-instead-of-logical"
#endif
#endif

namespace myogrowth {
namespace detail {

/// The ten-point Gauss-Legendre rule: points +-point[i] with weight[i], on [-1, 1] (Abramowitz and Stegun,
/// table 25.4).
template <class V>
struct GaussRule {
  V point[5], weight[5];
};
template <class V>
MYOGROWTH_FUNCTION constexpr GaussRule<V> gauss_rule() {
  return {{V(0.14887433898163121088482600112972L), V(0.43339539412924719079926594316579L),
           V(0.67940956829902440623432736511487L), V(0.86506336668898451073209668842349L),
           V(0.97390652851717172007796401208445L)},
          {V(0.29552422471475287017389299465132L), V(0.26926671930999635509122692156947L),
           V(0.21908636251598204399553493422816L), V(0.14945134915058059314586339765770L),
           V(0.06667134430868813759356880989333L)}};
}

/// How long a panel is: short against the growth of the integrands for gamma <= 100, and bounded below, so
/// that the number of panels is bounded.
template <class V>
MYOGROWTH_FUNCTION V flow_panel(V gamma) {
  return 4 / (4 + (gamma < 100 ? gamma : V(100)));
}

/// The flow from G_n towards its end, in the lanes that move.
template <class T, class V, int sign>
struct Flow {
  Branch<V, sign> b;
  T G_n, lambda, end, per_r, u_n, room_end, q_end;
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
    room_end = select(moves & !at_limit, b.ahead(limit, end), zero);
    q_end = select(at_limit, b.ahead(lambda, T(T(b.crit) * limit)), zero);
    a = select(moves, dt, zero) * T(b.per_time) * b.to_gamma(T(r * T(b.per_width)));
  }

  /// Where it is at w.
  struct At {
    T kappa, q, g, u;
    /// dw over da.
    MYOGROWTH_FUNCTION T speed() const { return kappa * q / (g * u); }
  };
  MYOGROWTH_FUNCTION At at(const T& w) const {
    const T u = u_n * exp(T(-w));
    return {b.to_gamma(T((room_end + u) * per_r)), q_end + T(b.crit) * u, b.on(end, T(-u)), u};
  }

  /// Integrals over a part from w on of g u/(kappa q), the time, and of g u/(kappa q^2), from which
  /// dG/dlambda comes.
  struct Integrals {
    T time, sensitivity;
  };
  MYOGROWTH_FUNCTION Integrals integrate(const T& w, const T& part) const {
    const GaussRule<V> rule = gauss_rule<V>();
    const T half = part * T(V(0.5)), middle = w + half;
    Integrals sum{T(V(0)), T(V(0))};
    for (int i = 0; i < 10; ++i) {
      const At there = at(middle + half * T(i < 5 ? rule.point[i] : -rule.point[i - 5]));
      const T per_kappa_q = T(V(1)) / (there.kappa * there.q), per_q = rounded(T(there.kappa * per_kappa_q));
      const T f = T(rule.weight[i % 5]) * there.g * there.u * per_kappa_q;
      sum.time = sum.time + f;
      sum.sensitivity = sum.sensitivity + f * per_q;
    }
    return {sum.time * half, sum.sensitivity * half};
  }
};

/// How g the flow has come: the whole panels behind it, and its part of the panel that it ends in.
template <class T>
struct FlowProgress {
  T w, to_go, sensitivity;  ///< at the beginning of that panel: w, what is left of a, the integral so g
  T part;
  LaneMask<T> ended;  ///< what is left of the way is below rounding: the end is reached
  LaneMask<T> left;   ///< lanes of a pack that take too many panels
};

/// Passes whole panels in the lanes `beyond`, until each is in the panel that it ends in.
template <class T, class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE FlowProgress<T> pass_panels(const Flow<T, V, sign>& flow, T panel,
                                                                  FlowProgress<T> p, LaneMask<T> beyond,
                                                                  int most, int& iterations) {
  const T below_rounding = log(T(flow.u_n / (flow.end * T(last_place<V>() / 8)))) + panel;
  const T w_end = minimum(below_rounding, T(2 * log((std::numeric_limits<V>::max)())));  // for an end near 0
  for (int i = 0; i < most && any(beyond); ++i) {
    ++iterations;
    const auto whole = flow.integrate(p.w, panel);
    const LaneMask<T> is_number = whole.time >= T(V(0)), passes = beyond & (whole.time < p.to_go);
    const LaneMask<T> stops = beyond & is_number & !passes;
    p.part = select(stops, T(panel * (p.to_go / rounded(select(stops, whole.time, panel)))), p.part);
    p.to_go = select(passes, T(p.to_go - whole.time), p.to_go);
    p.sensitivity = select(passes, T(p.sensitivity + whole.sensitivity), p.sensitivity);
    p.w = select(passes, T(p.w + panel), p.w);
    const LaneMask<T> at_end = !(is_number & (p.w < w_end));  // not a number: out of range, at the end
    p.ended = p.ended | (beyond & at_end);
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

/// A number that Newton's method left: the panel it ends in, and there Newton's method in a bracket.
/// @{
template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE void find_in_bracket(const Flow<V, V, sign>& flow, V panel,
                                                           FlowProgress<V>& p, int& iterations) {
  constexpr int most_panels = 100000;  // more than w_end has
  p.left = false;
  if (!is_finite(flow.a)) p.ended = true;  // (dt, or a gamma so large that k_g(G_n) is beyond all numbers)
  if (!p.ended) p = pass_panels(flow, panel, p, true, most_panels, iterations);
  if (p.ended) return;
  const V start = p.sensitivity;
  V low = 0, high = panel;
  for (int i = 0; i < 100; ++i) {
    ++iterations;
    const auto some = flow.integrate(p.w, p.part);
    const V step = (p.to_go - some.time) * flow.at(p.w + p.part).speed();
    (step > 0 ? low : high) = p.part;
    V next = p.part + step;
    if (!(next > low && next < high)) next = (low + high) / 2;
    const V moved = abs(V(next - p.part));
    p.part = next;
    p.sensitivity = start + some.sensitivity;
    if (moved <= 4 * last_place<V>() * (p.w + p.part)) break;
  }
  p.sensitivity = start + flow.integrate(p.w, p.part).sensitivity;
  if (!is_finite(p.sensitivity)) p.ended = true;  // so near the end that 1/kappa is beyond all numbers
}
template <class T, class V, int sign>
MYOGROWTH_FUNCTION void go_on(const Flow<T, V, sign>& flow, const T& panel, FlowProgress<T>& p,
                              int& iterations, std::true_type) {
  if (p.left) find_in_bracket(flow, panel, p, iterations);
}
template <class T, class V, int sign>
MYOGROWTH_FUNCTION void go_on(const Flow<T, V, sign>&, const T&, FlowProgress<T>&, int&, std::false_type) {}
/// @}

template <class T, class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE FlowResult<T> follow(Branch<V, sign> b, LaneMask<T> moves, T G_n,
                                                           T lambda, T dt) {
  moves = moves & b.precedes(G_n, b.end(lambda));  // but for rounding, all that are asked for
  constexpr V epsilon = last_place<V>();
  constexpr bool is_number = std::is_same<T, V>::value;
  constexpr int most_panels = is_number ? 100000 : 16;
  const T zero(V(0)), one(V(1)), panel(flow_panel(b.gamma)), gamma(b.gamma), crit(b.crit);
  const Flow<T, V, sign> flow(b, moves, G_n, lambda, dt);

  // A step that ends in the first panel, as most do, starts from the series of the time to second order in w.
  const T relative = flow.u_n / G_n, q_n = flow.q_end + crit * flow.u_n;
  const T to_first_order = flow.a * q_n / (G_n * flow.u_n);
  const T growth = T(V(sign)) * relative + gamma * flow.u_n * flow.per_r + crit * flow.u_n / q_n - one;
  const T divisor = one + growth * to_first_order * T(V(0.5));
  const T series =
      select(divisor > zero, to_first_order, panel) / rounded(select(divisor > zero, divisor, one));
  const LaneMask<T> none = one < zero;
  const LaneMask<T> beyond = moves & !((zero <= series) & (series < panel * T(V(0.9))));
  FlowProgress<T> p{zero, flow.a, zero, select(beyond, panel, series), none, none};
  int iterations = 0;
  if (any(beyond)) p = pass_panels(flow, panel, p, beyond, most_panels, iterations);

  // Newton's method for the part of the panel.
  const T before = p.sensitivity, curvature = relative + (gamma + T(V(4)));
  LaneMask<T> active = moves & !p.ended & !p.left;
  for (int i = 0; i < 8 && any(active); ++i) {
    ++iterations;
    const auto some = flow.integrate(p.w, p.part);
    const auto here = flow.at(p.w + p.part);
    const T speed = here.speed(), step = (p.to_go - some.time) * speed, next = p.part + step;
    const LaneMask<T> inside = (zero <= next) & (next <= panel);
    const LaneMask<T> last = curvature * step * step < T(epsilon / 4) * (p.w + next);
    p.part = select(active & inside, next, p.part);
    p.sensitivity =
        select(active, T(before + some.sensitivity + (p.to_go - some.time) / here.q), p.sensitivity);
    p.left = p.left | (active & !inside);
    active = active & inside & !last;
  }
  p.left = p.left | active;
  p.sensitivity = select(p.left, before, p.sensitivity);
  go_on(flow, panel, p, iterations, std::is_same<T, V>());

  const T w = p.w + select(p.left | p.ended, zero, p.part);
  const auto last = flow.at(w);
  const T speed = last.kappa * last.q / last.g;
  const T G = b.on(G_n, T(-flow.u_n * expm1(T(-w))));
  const T crossed = select(flow.q_end > zero, zero, T(one / crit));  // dG/dlambda at the end
  return {select(p.ended, flow.end, select(moves, b.last(b.first(G, flow.end), G_n), G_n)),
          select(p.ended, crossed, select(moves, T(speed * p.sensitivity), zero)),
          select(p.ended, zero, T(speed * G_n / q_n)), p.left, iterations};
}

/// A number of the scalar's own kind from a value and its derivatives.
/// @{
template <class T, class V>
MYOGROWTH_FUNCTION T carried(const FlowResult<V>& r, const T& G_n, const T& lambda, std::false_type) {
  return T(r.G) + r.dG_dlambda * (lambda - value(lambda)) + r.dG_dG_n * (G_n - value(G_n));
}
template <class T, class V>
MYOGROWTH_FUNCTION T carried(const FlowResult<V>& r, const T&, const T&, std::true_type) {
  return r.G;
}
/// @}

template <class T, class V, int sign>
MYOGROWTH_FUNCTION GrowthStep<T> flow_of(const Branch<V, sign>& b, const T& G_n, const T& lambda, V dt) {
  const FlowResult<V> r = follow<V>(b, true, value(G_n), value(lambda), dt);
  return {carried(r, G_n, lambda, std::is_same<T, V>()), T(r.dG_dlambda), r.iterations};
}

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

#if defined(__clang__)
#pragma clang diagnostic pop
#endif

#endif
