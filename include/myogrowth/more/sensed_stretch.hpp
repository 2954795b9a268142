/// @file
/// Growth that follows a sensed stretch: an extension of eq. 4 for doses of stretch (docs/evidence.md).
///
///   dG/dt = k_g(G) f(s - lambda_crit)  or  -k_rev(G) f(lambda_crit_rev - s),   f(x) = <x>/(1 + <x>/x_half)
///   ds/dt = (lambda_e - s)/tau_rise where lambda_e > s, else (lambda_e - s)/tau_fall
///
/// A short stretch is remembered for tau_fall, and one much shorter than tau_rise is not noticed. With the
/// defaults s is lambda_e and f is linear: eq. 4 with removal.
///
/// One step, backward Euler in G; the way of s to the lambda_e at the end of the step is exact:
///
///   R(G) = G - G_n - dt rate(G, s(G)) = 0,   s(G) = lambda/G + exp(-dt/tau_s) (s_n - lambda/G)
///
/// s falls as G grows, and so does the rate: R' >= 1, and there is exactly one root for any dt (theory.md).
#ifndef MYOGROWTH_MORE_SENSED_STRETCH_HPP
#define MYOGROWTH_MORE_SENSED_STRETCH_HPP

#include "../kernel.hpp"

namespace myogrowth {

/// The law. P: a real number.
template <class P = double>
struct SensedStretch {
  GrowthRate<P> growth;    ///< eq. 4
  RemovalRate<P> removal;  ///< off unless removal.tau_rev > 0
  P tau_rise = P(0);       ///< >= 0: time constant of s where the stretch is above it [time]; 0: at once
  P tau_fall = P(0);       ///< >= 0: where it is below [time]
  P per_x_half = P(0);     ///< >= 0: 1/x_half; at x_half over a threshold f is half of x; 0: f = x [-]
};

/// What a point remembers.
template <class T = double>
struct SensedState {
  T G = T(1);       ///< relative serial sarcomere number [-]
  T sensed = T(1);  ///< s [-]
};

/// Result of one step.
template <class T>
struct SensedStep {
  SensedState<T> state;  ///< at the end of the step
  T dG_dlambda;          ///< derivative of G with respect to the stretch at the end [-]
  int iterations;        ///< of the local solve; 0: nothing grew
};

namespace detail {

/// dG/dt at a G, its derivatives, and s there.
template <class T>
struct SensedRate {
  T s, rate, drate_dG, drate_dlambda;
};
template <class T, class P>
MYOGROWTH_FUNCTION SensedRate<T> sensed_rate(const SensedStretch<P>& law, const SensedState<T>& before,
                                             const T& G, const T& lambda, const P& dt) {
  const P one(1);
  const T lambda_e = lambda / G;
  const P time = value(lambda_e) > value(before.sensed) ? law.tau_rise : law.tau_fall;
  const P kept = time > P(0) ? P(exp(P(-dt / time))) : P(0);
  const T s = lambda_e + kept * (before.sensed - lambda_e), ds_dlambda = (one - kept) / G;
  const T up = s - law.growth.lambda_crit, down = law.removal.lambda_crit_rev - s;
  const bool grows = value(up) > P(0) && value(G) < law.growth.G_max;
  const bool shrinks = law.removal.tau_rev > P(0) && value(down) > P(0) && value(G) > law.removal.G_min;
  if (!grows && !shrinks) return {s, T(P(0)), T(P(0)), T(P(0))};
  T k, dk;  // k_g or -k_rev, and its derivative
  if (grows) {
    k = law.growth.adaptation(G);
    dk = law.growth.dadaptation_dG(G);
  } else {
    const T to_limit = G - law.removal.G_min;
    k = power(T(to_limit / (law.growth.G_max - law.removal.G_min)), law.removal.gamma_rev) /
        -law.removal.tau_rev;
    dk = law.removal.gamma_rev * k / to_limit;
  }
  const T x = grows ? up : down, part = one / (one + law.per_x_half * x), f = x * part;
  const T k_slope = (grows ? k : T(-k)) * part * part;  // k df/ds
  const T drate_dlambda = k_slope * ds_dlambda;
  return {s, k * f, dk * f - drate_dlambda * lambda_e, drate_dlambda};
}

}  // namespace detail

/// One step of length dt [time] under the total stretch lambda at its end. G stays between G_min and G_max,
/// or where it was beyond them. T may carry derivatives with respect to `before` and lambda.
template <class T, class P>
MYOGROWTH_FUNCTION SensedStep<T> solve_growth(const SensedStretch<P>& law, const SensedState<T>& before,
                                              const T& lambda, const P& dt) {
  using std::abs;
  const P G_n = value(before.G), stretch = value(lambda);
  const SensedState<P> start{G_n, value(before.sensed)};
  const P first = dt > P(0) ? detail::sensed_rate(law, start, G_n, stretch, dt).rate : P(0);
  T G = before.G;
  P slope(0);  // 0: G does not follow the stretch
  int iterations = 0;
  if (!(first == P(0))) {
    // The rate falls on the way, so the explicit step is the farthest.
    const P limit = first > P(0) ? law.growth.G_max : law.removal.G_min, far = G_n + dt * first;
    P low = first > P(0) ? G_n : maximum(far, limit), high = first > P(0) ? minimum(far, limit) : G_n;
    P g = G_n, step = high - low;
    const P rounding = 2 * last_place<P>();
    while (abs(step) > rounding * g && high - low > rounding * g) {  // it ends: by halving from 100 on
      ++iterations;
      const detail::SensedRate<P> at = detail::sensed_rate(law, start, g, stretch, dt);
      const P R = g - G_n - dt * at.rate;
      (R < P(0) ? low : high) = g;
      P next = g - R / (P(1) - dt * at.drate_dG);
      const bool is_good = low <= next && next <= high && abs(next - g) <= abs(step) / 2 && iterations < 100;
      if (!is_good) next = low + (high - low) / 2;
      step = next - g;
      g = next;
    }
    if (abs(limit - g) <= 4 * rounding * g) {
      G = T(limit);
    } else {
      // The implicit function theorem, for all derivatives that T carries.
      slope = P(1) - dt * detail::sensed_rate(law, start, g, stretch, dt).drate_dG;
      const T R = g - before.G - dt * detail::sensed_rate(law, before, T(g), lambda, dt).rate;
      G = T(g) - (R - value(R)) / slope;
    }
  }
  const detail::SensedRate<T> end = detail::sensed_rate(law, before, G, lambda, dt > P(0) ? dt : P(0));
  const T dG_dlambda = slope > P(0) ? T(dt * end.drate_dlambda / (P(1) - dt * end.drate_dG)) : T(P(0));
  return {{G, dt > P(0) ? end.s : before.sensed}, dG_dlambda, iterations};
}

/// update_point with this law: F[9], n0[3], out and the activation as there. material: FibreGrowth or
/// FibreGrowthOf, of which the elastic law is used. after: the state at the end; `before` if there is no
/// result.
template <class Material, class T, class P, class Point, class... Activation>
MYOGROWTH_FUNCTION UpdateStatus update_sensed(const SensedStretch<P>& law, const Material& material,
                                              const T F[9], const T n0[3], const SensedState<T>& before,
                                              const P& dt, Point& out, SensedState<T>& after,
                                              const Activation&... activation) {
  const P none(0);
  after = before;
  const bool known = is_finite(before.sensed) && is_finite(dt);
  if (!known) return detail::fail(UpdateStatus::not_finite, before.G, out);
  // An elastic step for the stretch, and another one with what has grown.
  update_point(material, F, n0, before.G, T(P(1)), none, out, activation...);
  if (out.status != UpdateStatus::ok) return out.status;
  const SensedStep<T> step = solve_growth(law, before, out.lambda, dt);
  update_point(material, F, n0, step.state.G, T(P(1)), none, out, activation...);
  if (out.status != UpdateStatus::ok) return out.status;
  out.dG_dlambda = step.dG_dlambda;
  out.iterations = step.iterations;
  after = step.state;
  return out.status;
}

}  // namespace myogrowth

#endif
