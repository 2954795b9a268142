/// @file
/// Law 2: Blemker, Pinsky and Delp 2005, muscle or tendon, decoupled into isochoric part and volume.
///
///   W = G1 B1^2 + G2 B2^2 + W3(lambda, a) + kappa/2 ln^2(J_e)
///   B1^2 = I5/I4^2 - 1 (shear along the fibre),  cosh(B2) = (I1 I4 - I5)/(2 sqrt(I4)) (across it)
///   muscle: lambda dW3/dlambda = sigma_max l (f_p(l) + a f_a(l)),  l = lambda/lambda_opt
///   tendon: lambda dW3/dlambda = L1 (e^{L2 (lambda-1)} - 1), its tangent line beyond lambda_star
///
/// I1, I4, I5 and lambda = sqrt(I4) are those of J_e^-2/3 C_e. The optimum stretch normalises both curves, as
/// in FEBio; 4C normalises the passive one by 1. With m the direction of f, M = m⊗m, Q = I - M, v = Q b_e m,
/// d the deviator of b_e in the plane across m, and delta = J_e/lambda_e:
///
///   tau = 2 G1/lambda_e^2 (v⊗m + m⊗v) + G2 g' d/delta + t (M - I/3) + kappa ln(J_e) I
///
/// where g = B2^2 as a function of cosh(B2); its slope at rest comes from the series.
#ifndef MYOGROWTH_ELASTIC_BLEMKER_HPP
#define MYOGROWTH_ELASTIC_BLEMKER_HPP

#include "fibre_curves.hpp"
#include "response.hpp"

namespace myogrowth {

namespace detail {

/// g(1 + x) = acosh^2(1 + x) and two derivatives, for x >= 0.
template <class T>
MYOGROWTH_FUNCTION void squared_acosh(const T& x, T& g, T& dg, T& ddg) {
  using V = Real<T>;
  const V one(1), two(2);
  if (value(x) < V(0.25)) {  // g = 2 sum (-1)^(n+1) (2x)^n / (n^2 (2n over n)); the terms fall by x/2
    g = dg = ddg = T(V(0));
    V coefficient(2);                    // of x^n
    T powers[3] = {x, T(one), T(V(0))};  // x^n, x^(n-1), x^(n-2)
    for (int n = 1; n <= 18; ++n) {
      const V k = V(n);
      g = g + coefficient * powers[0];
      dg = dg + k * coefficient * powers[1];
      ddg = ddg + k * (k - one) * coefficient * powers[2];
      coefficient = -coefficient * k * k / ((k + one) * (two * k + one));
      powers[2] = powers[1];
      powers[1] = powers[0];
      powers[0] = powers[0] * x;
    }
    return;
  }
  const T root = sqrt(T(x * (x + two)));
  const T B2 = log1p(T(x + root));
  g = B2 * B2;
  dg = two * B2 / root;
  ddg = (two - (one + x) * dg) / (x * (x + two));
}

}  // namespace detail

/// The elastic law; defaults in kPa.
template <class P = double>
struct Blemker {
  P G1 = P(0.5);           ///< shear along the fibre, > 0; tendon: 50 [stress]
  P G2 = P(0.5);           ///< shear across the fibre, > 0; tendon: 50 [stress]
  P kappa = P(1000);       ///< resistance to volume change, > 0; our choice: nearly incompressible [stress]
  P sigma_max = P(300);    ///< largest isometric stress, >= 0; not read for a tendon [stress]
  P lambda_opt = P(1.4);   ///< stretch at which the active stress is largest, > 0; not read for a tendon [-]
  P P1 = P(0.05);          ///< passive muscle, >= 0 [-]
  P P2 = P(6.6);           ///< passive muscle, > 0 [-]
  P lambda_star = P(1.4);  ///< where the exponential ends, > 1: l of muscle; tendon: lambda, 1.03 [-]
  bool tendon = false;     ///< tendon or aponeurosis: never active
  P L1 = P(2700);          ///< tendon, >= 0 [stress]
  P L2 = P(46.4);          ///< tendon, > 0 [-]

  /// Tendon and aponeurosis, as published.
  static Blemker of_tendon() {
    Blemker law;
    law.G1 = law.G2 = P(50);
    law.lambda_star = P(1.03);
    law.tendon = true;
    return law;
  }

  /// Energy, stress and modulus (response.hpp); activation from 0 to 1. The active energy, at fixed
  /// activation, counts from l = 0.4, where there is no force.
  template <class T>
  MYOGROWTH_FUNCTION void evaluate(const T Fe[9], const T n0[3], const T& activation,
                                   ElasticResponse<T>& out) const {
    using V = Real<T>;
    const V one(1), two(2);
    const ElasticDeformation<T> e = elastic_deformation(Fe, n0);
    const T per_square = one / (e.lambda * e.lambda);

    // Along m and across it.
    T m[3], Bm[3], v[3], CM[6], M[6], Q[6], across[6], S[6];
    for (int i = 0; i < 3; ++i) m[i] = e.f[i] / e.lambda;
    for (int i = 0; i < 3; ++i) {
      Bm[i] = e.B[symmetric_index(i, 0)] * m[0] + e.B[symmetric_index(i, 1)] * m[1] +
              e.B[symmetric_index(i, 2)] * m[2];
    }
    const T mBm = m[0] * Bm[0] + m[1] * Bm[1] + m[2] * Bm[2];
    for (int i = 0; i < 3; ++i) v[i] = Bm[i] - mBm * m[i];
    symmetric_dyad(m, v, S);
    const T half_trace = (e.B[0] + e.B[1] + e.B[2] - mBm) / two;  // of Q B Q
    T d[6], dd(V(0));
    for (int k = 0; k < 6; ++k) {
      M[k] = m[symmetric_row(k)] * m[symmetric_column(k)];
      Q[k] = V(k < 3 ? 1 : 0) - M[k];
      CM[k] = M[k] - V(k < 3 ? 1 : 0) / V(3);
      d[k] = e.B[k] - S[k] - mBm * M[k] - half_trace * Q[k];
      across[k] = d[k] + (one + half_trace) * Q[k];  // Q b Q
      dd = dd + V(k < 3 ? 1 : 2) * d[k] * d[k];
    }
    const T delta = (one + e.J_minus_1) / e.lambda;
    const T omega = (one + half_trace) / delta;              // cosh(B2)
    const T x = dd / (two * delta * delta * (omega + one));  // omega - 1, from omega^2 - 1 = d:d/(2 delta^2)
    T g, dg, ddg;
    detail::squared_acosh(x, g, dg, ddg);

    // The fibre: t = lambda dW3/dlambda, dt = lambda dt/dlambda.
    const T stretch = e.lambda * exp(T(e.ln_J / V(-3)));
    T t, dt, W3;
    if (tendon) {
      const Curve<T> c = passive_curve(stretch, L1, L2, lambda_star);
      t = c.f, dt = stretch * c.df, W3 = passive_areas(stretch, L1, L2, lambda_star).area_per_l;
    } else {
      const T l = stretch / lambda_opt;
      const Curve<T> fp = passive_curve(l, P1, P2, lambda_star), fa = active_curve(l);
      const T f = fp.f + activation * fa.f, df = fp.df + activation * fa.df;
      t = sigma_max * l * f;
      dt = sigma_max * l * (f + l * df);
      W3 = sigma_max * (passive_areas(l, P1, P2, lambda_star).area + activation * active_areas(l).area);
    }

    const T along = two * G1 * per_square, slope = G2 * dg / delta, plane = G2 * dg * omega;
    T rate[6], turning[6], unit[6];
    for (int k = 0; k < 6; ++k) {
      unit[k] = T(V(k < 3 ? 1 : 0));
      out.tau[k] = along * S[k] + slope * d[k] + t * CM[k] + kappa * e.ln_J * unit[k];
      rate[k] = along * S[k] + slope * d[k] + plane * Q[k];
      turning[k] = two * along * across[k] - two * slope * d[k] + (t - plane) * Q[k];
    }
    for (T& y : out.c) y = T(V(0));
    add_dyad(T(kappa), unit, unit, out.c);
    add_dyad(dt, CM, CM, out.c);
    add_dyad(T(-two * along), M, S, out.c);
    add_dyad(T(-two * along), S, M, out.c);
    add_dyad(T(G2 * ddg / (delta * delta)), d, d, out.c);
    add_dyad(T(-slope), d, Q, out.c);
    add_dyad(T(-slope), Q, d, out.c);
    add_dyad(T(-plane), Q, Q, out.c);
    add_rate(rate, out.c);
    add_turning(m, turning, out.c);

    // B1^2 = |C n0 - lambda^2 n0|^2/lambda^4, which is never negative.
    T B1_squared(V(0));
    for (int i = 0; i < 3; ++i) {
      const T Cn = Fe[3 * i] * e.f[0] + Fe[3 * i + 1] * e.f[1] + Fe[3 * i + 2] * e.f[2];
      const T shear = Cn * per_square - n0[i];
      B1_squared = B1_squared + shear * shear;
    }
    out.psi = G1 * B1_squared + G2 * g + W3 + kappa * e.ln_J * e.ln_J / two;
  }
};

}  // namespace myogrowth

#endif
