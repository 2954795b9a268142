// Fourth-order moduli as the paper has them: what the kernel's closed forms are compared with.
#ifndef MYOGROWTH_TESTS_MODULI_HPP
#define MYOGROWTH_TESTS_MODULI_HPP

#include <myogrowth/elastic/neo_hookean.hpp>

namespace moduli {

using namespace myogrowth;

/// Y_abcd = A_ai A_bj A_ck A_dl X_ijkl.
inline Mat6<double> push_forward(const Mat3<double>& A, const Mat6<double>& X) {
  Mat6<double> Y;
  push_modulus(A.data(), X.data(), Y.data());
  return Y;
}

/// Jaumann modulus from dS/dE.
inline Mat6<double> jaumann_from_dS_dE(const Mat3<double>& F, const Mat3<double>& tau,
                                       const Mat6<double>& dS_dE) {
  Mat6<double> c;
  add_rate_terms(to_six(tau).data(), +1, push_forward(F, dS_dE).data(), c.data());
  return c;
}

/// dS/dE of the growing muscle, F_g^-1 ... L_e ... F_g^-T + 2 dS/dG ⊗ dG/dC with
/// dG/dC = dG/dlambda n0⊗n0/(2 lambda) (docs/theory.md).
inline Mat6<double> consistent_modulus(const NeoHookean<>& law, const Mat3<double>& F, const Vec3<double>& n0,
                                       double G, double dG_dlambda) {
  using Complex = std::complex<double>;
  constexpr double h = 1e-30;
  const Mat3<Complex> S =
      second_piola(law, Mat3<Complex>(F.cast<Complex>()), Vec3<Complex>(n0.cast<Complex>()), Complex(G, h));
  const Mat3<double> dS_dG = S.imag() / h, n0n0 = n0 * n0.transpose(),
                     Ce = right_cauchy_green(elastic_part(F, n0, G));
  return push_forward(inverse_growth_tensor(n0, G), law.L(Ce)) +
         dG_dlambda / fibre_stretch(F, n0) * dyad(dS_dG, n0n0);
}

}  // namespace moduli

#endif
