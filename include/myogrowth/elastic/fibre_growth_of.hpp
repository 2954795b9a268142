/// @file
/// Growth along the fibre with any elastic law, passive or active.
///
///     FibreGrowthOf<Blemker<>> muscle;   // or Roehrle, Ehret, NeoHookean, or a law of your own
///     auto step = update(muscle, F, state, dt, activation);   // material.hpp has the rest
///
/// An elastic law sees F_e = F F_g^-1 and n0 only, so its stretch is lambda_e = lambda/G and its optimum
/// stays where it is: growth shifts the force-length curve of the whole muscle. Eq. 4 needs lambda only, so
/// its step is that of FibreGrowth, whatever the law. With tau(F_e) and c of the law (response.hpp):
///
///   dF_e = L F_e dG at fixed F,  L = -(1/G) f⊗F_e^-T n0,  f = F_e n0
///   dtau/dG = c:sym(L) + W tau - tau W,  W = skew(L)
///   J DDSDDE = c + (dG/dlambda / lambda) dtau/dG ⊗ (F n0 ⊗ F n0)
///
/// For EnergyPer::grown_volume psi, tau and c are G times larger, and dtau/dG has tau/G more. docs/theory.md
/// derives this. FibreGrowth is the closed form for the neo-Hookean law, and much faster.
#ifndef MYOGROWTH_ELASTIC_FIBRE_GROWTH_OF_HPP
#define MYOGROWTH_ELASTIC_FIBRE_GROWTH_OF_HPP

#include "from_energy.hpp"

namespace myogrowth {

/// The material. Defaults of growth: the paper's Table 1 (days).
template <class Elastic, class P = double>
struct FibreGrowthOf {
  Elastic elastic;         ///< the elastic law
  GrowthRate<P> growth;    ///< eq. 4
  RemovalRate<P> removal;  ///< off unless removal.tau_rev > 0
  /// The volume that the law's energy and stress are counted per.
  EnergyPer energy = EnergyPer::reference_volume;
  /// How eq. 4 is integrated.
  TimeIntegration integration = TimeIntegration::backward_euler;
};

/// Result of update_point with any law: PointUpdate, whose c1 and c2 are NaN here, and the law's modulus.
template <class T>
struct ElasticPointUpdate : PointUpdate<T> {
  T elastic[36];  ///< Jaumann modulus of tau at fixed growth [stress]
};

/// What update_point of a material fills, for its type only.
template <class T, class Elastic, class P>
ElasticPointUpdate<T> point_of(const FibreGrowthOf<Elastic, P>&);

/// As update_point of FibreGrowth. activation: from 0 to 1, constant over the step.
template <class T, class Elastic, class P>
UpdateStatus update_point(const FibreGrowthOf<Elastic, P>& material, const T F[9], const T n0[3],
                          const T& G_n, const T& lambda_n, const P& dt, ElasticPointUpdate<T>& out,
                          const T& activation = T(Real<T>(0))) {
  using V = Real<T>;
  const T nan(std::numeric_limits<V>::quiet_NaN());
  // Checks, kinematics and eq. 4 are those of FibreGrowth; its stress is replaced.
  const FibreGrowth<P> growth{
      P(1), P(1), material.growth, material.removal, EnergyPer::reference_volume, material.integration};
  PointUpdate<T>& base = out;
  const auto fail = [&](UpdateStatus status) {
    for (T& x : out.elastic) x = nan;
    return detail::fail(status, G_n, base);
  };
  if (!is_finite(activation)) return fail(UpdateStatus::not_finite);
  const UpdateStatus status = update_point(growth, F, n0, G_n, lambda_n, dt, base);
  if (status != UpdateStatus::ok) return fail(status);
  out.c1 = out.c2 = nan;

  const T* n = out.n0;
  const T& G = out.G;
  const T per_G = V(1) / G, shortening = (V(1) - G) * per_G;  // 1/G - 1
  T Fe[9], cofactor[9], f[3], normal[3], symmetric[6];
  for (int i = 0; i < 9; ++i) Fe[i] = F[i] + shortening * out.f[i % 3] * n[i / 3];
  ElasticResponse<T> law;
  evaluate(material.elastic, Fe, n, activation, law);

  // dtau/dG: c:sym(L) + W tau - tau W.
  (void)cofactors(Fe, cofactor);
  for (int i = 0; i < 3; ++i) {
    f[i] = out.f[i] * per_G;
    normal[i] = (cofactor[i] * n[0] + cofactor[i + 3] * n[1] + cofactor[i + 6] * n[2]) /
                (-out.Je * G);  // -(1/G) F_e^-T n0
  }
  symmetric_dyad(f, normal, symmetric);
  const bool grown = material.energy == EnergyPer::grown_volume;
  const T scale = grown ? G : T(V(1));
  for (int a = 0; a < 6; ++a) {
    const int i = symmetric_row(a), j = symmetric_column(a);
    T rate(V(0));
    for (int k = 0; k < 6; ++k)
      rate = rate + law.c[a + 6 * k] * (k < 3 ? T(symmetric[k] / V(2)) : symmetric[k]);
    for (int k = 0; k < 3; ++k) {
      const T W_ik = f[i] * normal[k] - f[k] * normal[i], W_kj = f[k] * normal[j] - f[j] * normal[k];
      rate = rate + (W_ik * law.tau[symmetric_index(k, j)] - law.tau[symmetric_index(i, k)] * W_kj) / V(2);
    }
    out.dtau_dG[a] = grown ? T(law.tau[a] + G * rate) : rate;
    out.tau[a] = scale * law.tau[a];
  }
  for (int i = 0; i < 36; ++i) out.elastic[i] = scale * law.c[i];
  out.psi = scale * law.psi;
  const bool finite = are_finite(out.tau, 6) && are_finite(out.dtau_dG, 6) && are_finite(out.elastic, 36) &&
                      is_finite(out.psi);
  if (!finite) return fail(UpdateStatus::not_finite);
  return out.status;
}

/// As that of PointUpdate: the modulus of the Jaumann rate times a factor, consistent with the discrete
/// update.
template <class T, class Array>
MYOGROWTH_FUNCTION void spatial_modulus(const ElasticPointUpdate<T>& u, Array&& c,
                                        const T& factor = T(Real<T>(1))) {
  const bool grows = !is_zero(u.dG_dlambda);
  const T weight = grows ? T(u.dG_dlambda / u.lambda) : T(Real<T>(0));
  for (int j = 0; j < 6; ++j) {
    const T ff = weight * u.f[symmetric_row(j)] * u.f[symmetric_column(j)];
    for (int i = 0; i < 6; ++i) {
      const T elastic = u.elastic[i + 6 * j];
      c[i + 6 * j] = factor * (grows ? T(elastic + u.dtau_dG[i] * ff) : elastic);
    }
  }
}

}  // namespace myogrowth

#endif
