/// @file
/// Neo-Hookean elasticity of the grown muscle as the paper writes it (eq. 3): the readable definition.
///
///   psi = c1/2 ln^2(J_e) + c2/2 (C_e:I - 3 - 2 ln J_e),   S_e = 2 dpsi/dC_e,   L_e = 4 d^2psi/dC_e^2,
///   S = F_g^-1 S_e F_g^-T,   tau = F S F^T
///
/// All per unit reference volume; for EnergyPer::grown_volume psi, S, L and tau are G times larger.
#ifndef MYOGROWTH_ELASTIC_NEO_HOOKEAN_HPP
#define MYOGROWTH_ELASTIC_NEO_HOOKEAN_HPP

#include "../growth_tensor.hpp"
#include "response.hpp"

namespace myogrowth {

/// The elastic law, a function of only the elastic deformation.
template <class P = double>
struct NeoHookean {
  P c1 = P(16);  ///< first Lamé constant [stress]
  P c2 = P(4);   ///< second Lamé constant [stress]

  /// Energy psi(C_e) [stress].
  template <class T>
  T psi(const Mat3<T>& Ce) const {
    const T ln_Je = log(T(Ce.determinant())) / Real<T>(2);
    return (c1 * ln_Je * ln_Je + c2 * (Ce.trace() - Real<T>(3) - Real<T>(2) * ln_Je)) / Real<T>(2);
  }

  /// S_e = 2 dpsi/dC_e = c1 ln(J_e) C_e^-1 + c2 (I - C_e^-1) [stress].
  template <class T>
  Mat3<T> S(const Mat3<T>& Ce) const {
    const T ln_Je = log(T(Ce.determinant())) / Real<T>(2);
    const Mat3<T> inverse_Ce = Ce.inverse();
    return T(c1 * ln_Je) * inverse_Ce + T(c2) * (Mat3<T>::Identity() - inverse_Ce);
  }

  /// L_e = 4 d^2psi/dC_e^2 = c1 C_e^-1⊗C_e^-1 + 2 (c2 - c1 ln J_e) C_e^-1 ⊙ C_e^-1 [stress].
  template <class T>
  Mat6<T> L(const Mat3<T>& Ce) const {
    const T ln_Je = log(T(Ce.determinant())) / Real<T>(2);
    const Mat3<T> inverse_Ce = Ce.inverse();
    return T(c1) * dyad(inverse_Ce, inverse_Ce) +
           T(Real<T>(2) * (c2 - c1 * ln_Je)) * symmetric_product(inverse_Ce, inverse_Ce);
  }

  /// Kirchhoff stress tau = F_e S_e F_e^T = c1 ln(J_e) I + c2 (b_e - I) [stress].
  template <class T>
  Mat3<T> kirchhoff(const Mat3<T>& be) const {
    const T ln_Je = log(T(be.determinant())) / Real<T>(2);
    return T(c1 * ln_Je) * Mat3<T>::Identity() + T(c2) * (be - Mat3<T>::Identity());
  }

  /// Spatial modulus of the Jaumann rate of tau at fixed growth, c1 I⊗I + c2 (I∘b_e + b_e∘I) [stress].
  template <class T>
  Mat6<T> spatial_modulus(const Mat3<T>& be) const {
    const Mat3<T> identity = Mat3<T>::Identity();
    return T(c1) * dyad(identity, identity) + T(Real<T>(2) * c2) * symmetric_product(identity, be);
  }

  /// The law as the others are given (response.hpp). It has no fibre, and nothing that could be active.
  template <class T>
  void evaluate(const T Fe[9], const T n0[3], const T&, ElasticResponse<T>& out) const {
    const ElasticDeformation<T> e = elastic_deformation(Fe, n0);
    T identity[6], b[6];
    for (int i = 0; i < 6; ++i) {
      identity[i] = T(Real<T>(i < 3 ? 1 : 0));
      b[i] = c2 * (identity[i] + e.B[i]);
      out.tau[i] = c1 * e.ln_J * identity[i] + c2 * e.B[i];
    }
    for (T& x : out.c) x = T(Real<T>(0));
    add_dyad(T(c1), identity, identity, out.c);
    add_rate(b, out.c);
    out.psi = (c1 * e.ln_J * e.ln_J + c2 * (e.B[0] + e.B[1] + e.B[2] - Real<T>(2) * e.ln_J)) / Real<T>(2);
  }
};

/// Second Piola-Kirchhoff stress of the grown muscle, S = F_g^-1 S_e F_g^-T [stress].
template <class T, class P>
Mat3<T> second_piola(const NeoHookean<P>& law, const Mat3<T>& F, const Vec3<T>& n0, const T& G) {
  const Mat3<T> A = inverse_growth_tensor(n0, G);
  const Mat3<T> Ce = right_cauchy_green(elastic_part(F, n0, G));
  return A * law.S(Ce) * A.transpose();
}

}  // namespace myogrowth

#endif
