/// @file
/// The exact flow of the growth law (paper, eq. 4) at a stretch that is held: the second-order time step.
///
/// With the stretch held, eq. 4 is autonomous, and the time to get from G_n to G is an integral. Let u be the
/// distance from G to where growth ends, min(G_max, lambda/lambda_crit), and w = ln(u_n/u):
///
///   dt k_g(G_n) = Int_0^w g u / (kappa q) dw',   kappa = (room/room_n)^gamma,   q = lambda - lambda_crit g
///
/// In w the integrand is smooth and grows at most like exp(gamma w), whatever dt: a few Gauss points a panel
/// give it to rounding, and the w at which it reaches the left side is found by a bracketed Newton method. G
/// stays within the bounds of the backward-Euler step by construction, for any dt. Taken at the stretch of
/// the middle of the step, the flow is of second order (docs/theory.md).
#ifndef MYOGROWTH_GROWTH_FLOW_HPP
#define MYOGROWTH_GROWTH_FLOW_HPP

#include "growth_solve.hpp"

namespace myogrowth {
namespace detail {

/// What the flow needs of the step's equation: where it is at w, and the integrands there.
template <class V, int sign>
struct Flow {
  BracketedEquation<V, sign> eq;
  V u_n, room_end, q_end;

  MYOGROWTH_FUNCTION explicit Flow(const BracketedEquation<V, sign>& equation)
      : eq(equation),
        u_n(sign * (eq.end - eq.G_n)),
        room_end(eq.end == eq.limit ? V(0) : eq.room(eq.end)),
        q_end(eq.end == eq.limit ? eq.q(eq.lambda, eq.end) : V(0)) {}

  struct At {
    V kappa, q, g, u;
  };
  MYOGROWTH_FUNCTION At at(V w) const {
    const V u = u_n * exp(-w);
    return {eq.to_gamma(V((room_end + u) * eq.per_room)), q_end + eq.crit * u, eq.end - sign * u, u};
  }
};

/// Integrals from w_0 to w_1 of g u/(kappa q), the time, and of g u/(kappa q^2), from which dG/dlambda comes.
template <class V>
struct FlowIntegrals {
  V time, sensitivity;
};

/// The ten-point Gauss-Legendre rule: points +-point[i] with weight[i], on [-1, 1].
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

/// How long a panel is: short against the growth of the integrands, as far as anybody's gamma goes, so that
/// the number of panels is bounded.
template <class V>
MYOGROWTH_FUNCTION V flow_panel(V gamma) {
  return 4 / (4 + (gamma < 100 ? gamma : V(100)));
}

template <class V, int sign>
MYOGROWTH_FUNCTION FlowIntegrals<V> integrate(const Flow<V, sign>& flow, V w_0, V w_1) {
  const GaussRule<V> rule = gauss_rule<V>();
  const V middle = (w_0 + w_1) / 2, half = (w_1 - w_0) / 2;
  FlowIntegrals<V> sum{0, 0};
  for (int i = 0; i < 10; ++i) {
    const typename Flow<V, sign>::At at = flow.at(middle + (i < 5 ? half : -half) * rule.point[i % 5]);
    const V f = rule.weight[i % 5] * at.g * at.u / (at.kappa * at.q);
    sum.time += f;
    sum.sensitivity += f / at.q;
  }
  return {sum.time * half, sum.sensitivity * half};
}

/// G after the growth number a = dt k_g(G_n), with dG/dlambda and dG/dG_n.
template <class V>
struct FlowResult {
  V G, dG_dlambda, dG_dG_n;
  int iterations;
};

template <class V, int sign>
MYOGROWTH_FUNCTION MYOGROWTH_APART FlowResult<V> follow(const Flow<V, sign>& flow, V a) {
  const BracketedEquation<V, sign>& eq = flow.eq;
  const V panel = flow_panel(eq.gamma);
  int iterations = 0;
  const FlowResult<V> ended{eq.end, flow.q_end > 0 ? V(0) : 1 / eq.crit, V(0), iterations};
  if (!is_finite(a) || !(flow.u_n > 0))
    return ended;  // (dt, or a gamma so large that k_g(G_n) is beyond all numbers)
  const auto arrive = [&](V w, V sensitivity) -> FlowResult<V> {
    const typename Flow<V, sign>::At at = flow.at(w);
    const V speed = at.kappa * at.q / at.g;
    const V G = eq.G_n - sign * flow.u_n * expm1(-w);
    return {G, speed * sensitivity, speed * eq.G_n / eq.q(eq.lambda, eq.G_n), iterations};
  };

  // A step that ends in the first panel, as most do: from the series of the time to second order in w, by
  // Newton's method.
  const V relative = flow.u_n / eq.G_n, q_n = eq.q(eq.lambda, eq.G_n);
  const V ahead = a * q_n / (eq.G_n * flow.u_n);
  const V growth = sign * relative + eq.gamma * flow.u_n * eq.per_room + eq.crit * flow.u_n / q_n - 1;
  const V divisor = 1 + growth * ahead / 2;
  V part = divisor > 0 ? ahead / divisor : panel;
  for (int i = 0; i < 8 && part > 0 && part < panel; ++i) {
    ++iterations;
    const FlowIntegrals<V> some = integrate(flow, V(0), part);
    const typename Flow<V, sign>::At at = flow.at(part);
    const V speed = at.kappa * at.q / (at.g * at.u), step = (a - some.time) * speed;
    part += step;
    const bool is_last = (relative + eq.gamma + 4) * step * step < last_place<V>() / 4 * part;
    if (is_last && part <= panel) return arrive(part, some.sensitivity + step / (speed * at.q));
  }

  // Where what is left of the way is below rounding, the end is reached.
  const V below_rounding = log(flow.u_n / (last_place<V>() * eq.end / 8)) + panel;
  const V most = 2 * log((std::numeric_limits<V>::max)());  // for an end so near 0 that its rounding is 0
  const V w_end = below_rounding < most ? below_rounding : most;
  V w = 0, time = 0, sensitivity = 0;
  constexpr int most_panels = 64 * std::numeric_limits<V>::max_exponent;  // of the shortest, up to `most`
  for (int panels = 0; panels < most_panels && w < w_end; ++panels) {
    ++iterations;
    const FlowIntegrals<V> whole = integrate(flow, w, w + panel);
    if (!(whole.time >= 0)) break;  // not a number: out of range, at the end
    if (!(whole.time >= a - time)) {
      time += whole.time;
      sensitivity += whole.sensitivity;
      w += panel;
      continue;
    }
    // In this panel: Newton's method for its part, bracketed.
    V low = 0, high = panel;
    part = panel * ((a - time) / whole.time);
    for (int i = 0; i < 100; ++i) {
      ++iterations;
      const FlowIntegrals<V> some = integrate(flow, w, w + part);
      const typename Flow<V, sign>::At at = flow.at(w + part);
      const V step = (a - time - some.time) * at.kappa * at.q / (at.g * at.u);
      (step > 0 ? low : high) = part;
      V next = part + step;
      if (!(next > low && next < high)) next = (low + high) / 2;
      const V moved = next > part ? next - part : part - next;
      part = next;
      if (moved <= 4 * last_place<V>() * (w + part)) break;
    }
    return arrive(w + part, sensitivity + integrate(flow, w, w + part).sensitivity);
  }
  FlowResult<V> result = ended;
  result.iterations = iterations;
  return result;
}

/// A number of the scalar's own kind from a value and its derivatives.
template <class T, class V>
MYOGROWTH_FUNCTION T carried(const FlowResult<V>& r, const T& G_n, const T& lambda, std::false_type) {
  return T(r.G) + r.dG_dlambda * (lambda - value(lambda)) + r.dG_dG_n * (G_n - value(G_n));
}
template <class T, class V>
MYOGROWTH_FUNCTION T carried(const FlowResult<V>& r, const T&, const T&, std::true_type) {
  return r.G;
}

template <class T, int sign>
MYOGROWTH_FUNCTION GrowthStep<T> follow(const GrowthEquation<Real<T>, sign>& equation, const T& G_n,
                                        const T& lambda) {
  using V = Real<T>;
  const BracketedEquation<V, sign> eq(equation, value(G_n), value(lambda));
  if (!(eq.A > 0)) {  // as in solve()
    return {eq.A == 0 ? G_n : T(std::numeric_limits<V>::quiet_NaN()), T(0), 0};
  }
  FlowResult<V> r = follow(Flow<V, sign>(eq), V(eq.A / eq.E));
  if (!eq.before(eq.G_n, r.G)) r.G = eq.G_n;
  if (!eq.before(r.G, eq.end)) r.G = eq.end;
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
  const V G = value(G_n), stretch = value(lambda);
  if (dt > 0 && stretch > growth.lambda_crit * G && G < growth.G_max) {
    return detail::follow(detail::equation_of(growth, dt, G), G_n, lambda);
  }
  if (dt > 0 && removal.removal_time > 0 && stretch < removal.lambda_crit * G && G > removal.G_min) {
    return detail::follow(detail::equation_of(growth, removal, dt, G), G_n, lambda);
  }
  return {G_n, T(0), 0};
}

/// How the error of one time step in G is estimated, for hosts that choose their steps by it [-]: backward
/// Euler against the flow at mid-step (an error of order dt^2), the latter against the mean of the flows at
/// the stretches of both ends (of the order of the stretch's change in dt, squared).
/// @{
template <class V>
MYOGROWTH_FUNCTION V time_error_of_backward_euler(const GrowthRate<V>& growth, const RemovalRate<V>& removal,
                                                  V G_n, V lambda_n, V lambda, V dt) {
  const V difference = solve_growth(growth, removal, G_n, lambda, dt).G -
                       flow_growth(growth, removal, G_n, (lambda_n + lambda) / 2, dt).G;
  return difference < 0 ? -difference : difference;
}
template <class V>
MYOGROWTH_FUNCTION V time_error_of_midpoint_flow(const GrowthRate<V>& growth, const RemovalRate<V>& removal,
                                                 V G_n, V lambda_n, V lambda, V dt) {
  const V difference =
      flow_growth(growth, removal, G_n, (lambda_n + lambda) / 2, dt).G -
      (flow_growth(growth, removal, G_n, lambda_n, dt).G + flow_growth(growth, removal, G_n, lambda, dt).G) /
          2;
  return difference < 0 ? -difference : difference;
}
/// @}

}  // namespace myogrowth

#endif
