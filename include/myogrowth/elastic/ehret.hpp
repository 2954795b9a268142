/// @file
/// Law 3: Ehret, Böl and Itskov 2011 with the active stress of Weickenmeier, Itskov, Mazza and Jabareen 2014,
/// as 4C's MAT_Muscle_Combo has it.
///
///   L = w0/3 I + (1-w0) n0⊗n0,  I = C:(L + wa n0⊗n0),  J~ = det C (C^-1:L)
///   S = gamma/2 [ e^{alpha (I-1)} (L + wa n0⊗n0) - e^{beta (J~-1)} det C C^-1 L C^-1
///                 + (J~ e^{beta (J~-1)} - det C^-kappa) C^-1 + (eta/2) n0⊗n0 ]
///   wa(lambda) = ln(1 + (4 alpha/gamma) P e^{alpha (1-Ip)})/(alpha lambda^2)
///   eta(lambda) = e^{alpha (Ip + wa lambda^2 - 1)} lambda dwa/dlambda
///   Ip = w0/3 (lambda^2 + 2/lambda) + (1-w0) lambda^2
///   P = P_opt a (lambda_opt-lambda_min) (e^{1/2} - e^p)
///   p = (1 - ((lambda-lambda_min)/(lambda_opt-lambda_min))^2)/2
///
/// C, lambda: those of F_e; P = 0 for lambda <= lambda_min. With a > 0 there is no energy, since eta takes I
/// in its uniaxial form, and the modulus is unsymmetric also without growth.
#ifndef MYOGROWTH_ELASTIC_EHRET_HPP
#define MYOGROWTH_ELASTIC_EHRET_HPP

#include "response.hpp"

namespace myogrowth {

/// The elastic law; defaults in kPa.
template <class P = double>
struct Ehret {
  P alpha = P(19.69);       ///< > 0 [-]
  P beta = P(1.19);         ///< > 0 [-]
  P gamma = P(0.1599);      ///< > 0 [stress]
  P kappa = P(100);         ///< resistance to volume change, > 0 [-]
  P w0 = P(0.7388);         ///< weight of the isotropic part, 0 to 1 [-]
  P P_opt = P(73.52);       ///< active stress, >= 0 [stress]
  P lambda_min = P(0.682);  ///< elastic stretch below which there is no active stress, > 0 [-]
  P lambda_opt = P(1.192);  ///< that of the largest active stress, > lambda_min [-]

  /// Energy, stress and modulus (response.hpp); activation from 0 to 1. psi is what the passive law stores.
  template <class T>
  MYOGROWTH_FUNCTION void evaluate(const T Fe[9], const T n0[3], const T& activation,
                                   ElasticResponse<T>& out) const {
    using V = Real<T>;
    const V zero(0), one(1), two(2);
    const ElasticDeformation<T> e = elastic_deformation(Fe, n0);

    // h = f - n0 and k = cof(F_e) n0 - n0, from H = F_e - I.
    T H[9], cofactor[9], h[3], k[3];
    for (int i = 0; i < 9; ++i) H[i] = Fe[i] - V(i % 4 == 0 ? 1 : 0);
    cofactors(H, cofactor);
    const T trace_H = H[0] + H[4] + H[8];
    for (int i = 0; i < 3; ++i) {
      h[i] = H[i] * n0[0] + H[i + 3] * n0[1] + H[i + 6] * n0[2];
      k[i] = trace_H * n0[i] - (H[3 * i] * n0[0] + H[3 * i + 1] * n0[1] + H[3 * i + 2] * n0[2]) +
             (cofactor[i] * n0[0] + cofactor[i + 3] * n0[1] + cofactor[i + 6] * n0[2]);
    }
    // Lf = F L F^T, La = det C F^-T L F^-1, and what they are more than L.
    const P isotropic = w0 / V(3), along = V(1) - w0;
    const T trace_B = e.B[0] + e.B[1] + e.B[2];
    T ff[6], Lf[6], La[6], Lf_minus_L[6], La_minus_L[6], unit[6];
    T passive(zero), J_tilde_minus_1(zero);  // C:L - 1, J~ - 1
    for (int c = 0; c < 6; ++c) {
      const int i = symmetric_row(c), j = symmetric_column(c), p = (i + 1) % 3, q = (i + 2) % 3,
                r = (j + 1) % 3, s = (j + 2) % 3;
      unit[c] = T(V(c < 3 ? 1 : 0));
      ff[c] = e.f[i] * e.f[j];
      const T nn = n0[i] * n0[j];
      const T cof_B = e.B[symmetric_index(p, r)] * e.B[symmetric_index(q, s)] -
                      e.B[symmetric_index(p, s)] * e.B[symmetric_index(q, r)];
      Lf_minus_L[c] = isotropic * e.B[c] + along * (h[i] * n0[j] + n0[i] * h[j] + h[i] * h[j]);
      La_minus_L[c] = isotropic * (trace_B * unit[c] - e.B[c] + cof_B) +
                      along * (k[i] * n0[j] + n0[i] * k[j] + k[i] * k[j]);
      Lf[c] = isotropic * unit[c] + along * nn + Lf_minus_L[c];
      La[c] = isotropic * unit[c] + along * nn + La_minus_L[c];
      if (c < 3) passive = passive + Lf_minus_L[c], J_tilde_minus_1 = J_tilde_minus_1 + La_minus_L[c];
    }

    // The active weight, of the fibre stretch only.
    T wa(zero), dwa(zero), eta(zero), deta(zero);
    if (value(e.lambda) > value(lambda_min) && value(activation) != zero)
      activate(e.lambda, activation, wa, dwa, eta, deta);

    const T x = alpha * (passive + wa * e.lambda * e.lambda), y = beta * J_tilde_minus_1;
    const T ex_minus_1 = expm1(x), ey_minus_1 = expm1(y), ex = one + ex_minus_1, ey = one + ey_minus_1;
    const T compression_minus_1 = expm1(T(-two * kappa * e.ln_J)), J_tilde = one + J_tilde_minus_1;
    const T half_gamma = T(gamma) / two;
    const T pressure = J_tilde_minus_1 * ey + ey_minus_1 - compression_minus_1;
    T A[6], K[6], R[6], rate[6];
    for (int c = 0; c < 6; ++c) {
      A[c] = Lf[c] + wa * ff[c];
      K[c] = A[c] + e.lambda * dwa / two * ff[c];  // dI = 2 K:D
      R[c] = J_tilde * unit[c] - La[c];            // dJ~ = 2 R:D
      const T fibre = (ex * wa + eta / two) * ff[c];
      out.tau[c] = half_gamma * (ex_minus_1 * Lf[c] + Lf_minus_L[c] + fibre - ey_minus_1 * La[c] -
                                 La_minus_L[c] + pressure * unit[c]);
      rate[c] = half_gamma * (ex * Lf[c] + fibre + ey * La[c]);
    }
    for (T& z : out.c) z = T(zero);
    add_dyad(T(half_gamma * two * alpha * ex), A, K, out.c);
    add_dyad(T(half_gamma * (ex * dwa + deta / two) / e.lambda), ff, ff, out.c);
    add_dyad(T(-half_gamma * two * beta * ey), La, R, out.c);
    add_dyad(T(-half_gamma * two * ey), La, unit, out.c);
    add_dyad(T(half_gamma * two * ey * (one + beta * J_tilde)), unit, R, out.c);
    add_dyad(T(half_gamma * two * kappa * (one + compression_minus_1)), unit, unit, out.c);
    add_rate(rate, out.c);
    out.psi = half_gamma / two *
              (expm1(T(alpha * passive)) / alpha + ey_minus_1 / beta + compression_minus_1 / kappa);
  }

 private:
  /// wa, dwa/dlambda, eta and deta/dlambda for l = lambda > lambda_min.
  template <class T>
  MYOGROWTH_FUNCTION void activate(const T& l, const T& activation, T& wa, T& dwa, T& eta, T& deta) const {
    using V = Real<T>;
    const V one(1), two(2);
    const P isotropic = w0 / V(3), along = V(1) - w0;
    const T l2 = l * l, l3 = l2 * l;
    const T Ip = isotropic * (l2 + two / l) + along * l2;
    const T dIp = isotropic * two * (l - one / l2) + along * two * l;
    const T ddIp = isotropic * two * (one + two / l3) + T(along * two);
    const T width = T(lambda_opt) - T(lambda_min), s = (l - lambda_min) / width;
    const T ep = exp(T((one - s * s) / two)), most = exp(T(one / two));
    const T scale = activation * P_opt;
    const T p = scale * width * (most - ep), dp = scale * s * ep, ddp = scale * (one - s * s) * ep / width;
    const T decay = V(4) * alpha / gamma * exp(T(alpha * (one - Ip)));
    const T inner = dp - alpha * p * dIp;
    const T q = decay * p, dq = decay * inner;
    const T ddq = decay * (ddp - alpha * (dp * dIp + p * ddIp) - alpha * dIp * inner);
    const T u = log1p(q), du = dq / (one + q), ddu = ddq / (one + q) - du * du;
    wa = u / (alpha * l2);
    dwa = (du - two * u / l) / (alpha * l2);
    const T ddwa = (ddu - V(4) * du / l + V(6) * u / l2) / (alpha * l2);
    const T X = exp(T(alpha * (Ip - one))) * (one + q);
    eta = X * l * dwa;
    deta = X * ((alpha * dIp + du) * l * dwa + dwa + l * ddwa);
  }
};

}  // namespace myogrowth

#endif
