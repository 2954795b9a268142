/// @file
/// The update for mixed (hybrid) elements, whose volume ratio is a field of its own.
///
/// Such an element finds the volume ratio J^ apart from the displacements, which cannot lock then, and ties
/// it to J = det F by a pressure. The law is evaluated at F^ = (J^/J)^(1/3) F: the shape of F, the volume of
/// J^. With tau^ and c^, Kirchhoff stress and Jaumann modulus at F^, and m^ = tr(tau^)/3 = J^ dpsi/dJ^:
///
///   sigma = (tau^ - m^ I)/J + m^/J^ I                    deviator per actual, mean per independent volume
///   DDSDDE = (1/J) d(J sigma)/d(strain) at fixed J^/J
///   K = J d(m^/J^)/dJ^ at fixed shape = J (I:c^:I/9 - m^)/J^^2   (J d^2U/dJ^^2 of Abaqus's hybrid UMATs)
///
/// Where J^ = J all this is the ordinary update. (Simo and Hughes, Computational Inelasticity, ch. 9.)
#ifndef MYOGROWTH_MORE_MIXED_VOLUME_HPP
#define MYOGROWTH_MORE_MIXED_VOLUME_HPP

#include "../kernel.hpp"

namespace myogrowth {

/// What update_point of a material fills, for its type only.
template <class T, class P>
PointUpdate<T> point_of(const FibreGrowth<P>&);

/// What mixed elements need besides stress and tangent.
template <class T>
struct MixedVolume {
  T J;  ///< det F [-]
  T K;  ///< J d(mean stress)/dJ^ [stress]
};

/// update_point for a mixed element with the volume ratio J_hat > 0; arguments and status as there (Material
/// and Point: stress_states.hpp).
/// out: the law at F^ (its J is J^), but for tau = J sigma. c[36]: J DDSDDE.
template <class Material, class T, class P, class Point, class... Activation>
MYOGROWTH_FUNCTION UpdateStatus update_mixed(const Material& material, const T F[9], const T n0[3],
                                             const T& G_n, const T& lambda_n, const P& dt, const T& J_hat,
                                             Point& out, T c[36], MixedVolume<T>& volume,
                                             const Activation&... activation) {
  using V = Real<T>;
  const T J = determinant(F);
  if (!is_finite(J) || !is_finite(J_hat)) return detail::fail(UpdateStatus::not_finite, G_n, out);
  if (!(value(J) > 0 && value(J_hat) > 0)) return detail::fail(UpdateStatus::inverted, G_n, out);
  const T scale = pow(T(J_hat / J), V(1) / V(3));
  T F_hat[9];
  for (int i = 0; i < 9; ++i) F_hat[i] = scale * F[i];
  if (update_point(material, F_hat, n0, G_n, lambda_n, dt, out, activation...) != UpdateStatus::ok)
    return out.status;
  spatial_modulus(out, c);

  const T ratio_minus_1 = (J - J_hat) / J_hat;  // the mean stress counts J/J^ times
  const T mean = (out.tau[0] + out.tau[1] + out.tau[2]) / V(3);
  T bulk(0);  // I:c^:I/9
  for (int j = 0; j < 6; ++j) {
    T* column = c + 6 * j;
    const T mean_row = (column[0] + column[1] + column[2]) / V(3);
    if (j < 3) bulk = bulk + mean_row / V(3);
    for (int i = 0; i < 3; ++i) column[i] = column[i] + mean_row * ratio_minus_1;
  }
  for (int i = 0; i < 3; ++i) out.tau[i] = out.tau[i] + mean * ratio_minus_1;
  volume.J = J;
  volume.K = J * (bulk - mean) / (J_hat * J_hat);
  return out.status;
}

/// dK/dJ^ [stress] of the same step, by central difference, good to 1e-9: it takes part in the host's Newton
/// steps only. NaN where K is not defined on both sides.
template <class Material, class V, class... Activation>
MYOGROWTH_FUNCTION V mixed_dK_dJ(const Material& material, const V F[9], const V n0[3], V G_n, V lambda_n,
                                 V dt, V J_hat, const Activation&... activation) {
  V c[36], difference(0);
  decltype(point_of<V>(material)) u;
  const V width = J_hat / V(1 << 17);
  for (int side : {-1, 1}) {
    MixedVolume<V> volume{V(0), std::numeric_limits<V>::quiet_NaN()};
    update_mixed(material, F, n0, G_n, lambda_n, dt, J_hat + side * width, u, c, volume, activation...);
    difference = difference + side * volume.K;
  }
  return difference / (width + width);
}

}  // namespace myogrowth

#endif
