/// @file
/// Law 1: transversely isotropic muscle with active fibres (Röhrle, Davidson and Pullan 2012; the parameters
/// are those of Devold et al. 2025).
///
///   tau = c10 (b_e - I) + c01 (I1 b_e - b_e^2 - 2 I) + kappa ln(J_e) I + t M,   M = f⊗f/lambda_e^2
///   t   = sigma_p f_p(l) + a sigma_a f_a(l),   l = lambda_e/lambda_opt            (fibre_curves.hpp)
///
/// Stretch and invariants are those of the whole C_e, not of its isochoric part, so that with c01 = sigma_p =
/// sigma_a = 0 it is eq. 3 of the paper with c2 = c10, c1 = kappa.
#ifndef MYOGROWTH_ELASTIC_ROEHRLE_HPP
#define MYOGROWTH_ELASTIC_ROEHRLE_HPP

#include "fibre_curves.hpp"
#include "response.hpp"

namespace myogrowth {

/// The elastic law; defaults in kPa.
template <class P = double>
struct Roehrle {
  P c10 = P(10);          ///< matrix, >= 0 with c10 + c01 > 0 [stress]
  P c01 = P(10);          ///< matrix, >= 0 [stress]
  P kappa = P(1000);      ///< resistance to volume change, > 0; not published: nearly incompressible [stress]
  P sigma_p = P(300);     ///< largest passive fibre stress is sigma_p f_p, >= 0 [stress]
  P sigma_a = P(300);     ///< active fibre stress at the optimum, >= 0 [stress]
  P lambda_opt = P(1.4);  ///< elastic stretch at which the active stress is largest, > 0 [-]
  P g1 = P(0.05);         ///< passive curve, >= 0 [-]
  P g2 = P(6.6);          ///< passive curve, > 0 [-]

  static constexpr double end_of_exponential = 1.4;  ///< of the passive curve: l

  /// Energy of the fibres [stress], for l = lambda_e/lambda_opt.
  template <class T>
  MYOGROWTH_FUNCTION T fibre_energy(const T& l, const T& activation) const {
    return sigma_p * passive_areas(l, g1, g2, P(end_of_exponential)).area_per_l +
           activation * sigma_a * active_areas(l).area_per_l;
  }
  /// Stress of the fibres and its slope in l [stress]. T may be a pack.
  template <class T>
  MYOGROWTH_FUNCTION Curve<T> fibre_stress(const T& l, const T& activation) const {
    const Curve<T> fp = passive_curve(l, g1, g2, P(end_of_exponential)), fa = active_curve(l);
    return {sigma_p * fp.f + activation * sigma_a * fa.f, sigma_p * fp.df + activation * sigma_a * fa.df};
  }

  /// Energy, stress and modulus (response.hpp); activation from 0 to 1. The active energy, at fixed
  /// activation, counts from l = 0.4, where there is no force.
  template <class T>
  MYOGROWTH_FUNCTION void evaluate(const T Fe[9], const T n0[3], const T& activation,
                                   ElasticResponse<T>& out) const {
    using V = Real<T>;
    const V two(2);
    const ElasticDeformation<T> e = elastic_deformation(Fe, n0);
    const T* B = e.B;
    const T trace = B[0] + B[1] + B[2], pressure = kappa * e.ln_J;
    const T l = e.lambda / lambda_opt;
    const Curve<T> fibres = fibre_stress(l, activation);
    const T t = fibres.f, dt_dl = fibres.df;

    T b[6], fixed[6], fibre[6], unit[6];
    T square(V(0));  // B:B
    for (int k = 0; k < 6; ++k) {
      const int i = symmetric_row(k), j = symmetric_column(k);
      const V delta(k < 3 ? 1 : 0);
      T BB(V(0));
      for (int m = 0; m < 3; ++m) BB = BB + B[symmetric_index(i, m)] * B[symmetric_index(j, m)];
      square = square + V(k < 3 ? 1 : 2) * B[k] * B[k];
      b[k] = delta + B[k];
      unit[k] = T(delta);
      fibre[k] = (e.f[i] / e.lambda) * (e.f[j] / e.lambda);
      // I1 b - b^2 - 2 I = B + tr(B) I + tr(B) B - B^2, small where B is.
      const T mooney = B[k] + trace * (delta + B[k]) - BB;
      out.tau[k] = c10 * B[k] + c01 * mooney + pressure * delta + t * fibre[k];
      fixed[k] = c10 * b[k] + c01 * (mooney + two * delta) + t * fibre[k];
    }
    for (T& x : out.c) x = T(V(0));
    add_dyad(T(kappa), unit, unit, out.c);
    add_dyad(T(two * c01), b, b, out.c);
    add_sandwich(T(-two * c01), b, out.c);
    add_dyad(T(l * dt_dl - two * t), fibre, fibre, out.c);
    add_rate(fixed, out.c);

    // I2 - 3 = 2 tr(B) + (tr(B)^2 - B:B)/2
    const T I2_minus_3 = two * trace + (trace * trace - square) / two;
    out.psi =
        (c10 * (trace - two * e.ln_J) + c01 * (I2_minus_3 - two * two * e.ln_J) + pressure * e.ln_J) / two +
        fibre_energy(l, activation);
  }
};

}  // namespace myogrowth

#endif
