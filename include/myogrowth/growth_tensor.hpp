/// @file
/// Growth kinematics, F = F_e F_g, as the paper writes them (eqs 1 and 2): the readable definition.
/// n0 is a unit vector throughout; kernel.hpp computes the same without a single product of matrices.
#ifndef MYOGROWTH_GROWTH_TENSOR_HPP
#define MYOGROWTH_GROWTH_TENSOR_HPP

#include "tensor.hpp"

namespace myogrowth {

/// Growth tensor F_g = I + (G - 1) n0⊗n0: sarcomeres are added in series, only along the fibre.
template <class T>
Mat3<T> growth_tensor(const Vec3<T>& n0, const T& G) {
  return Mat3<T>::Identity() + (G - Real<T>(1)) * n0 * n0.transpose();
}

/// F_g^-1 = I + (1/G - 1) n0⊗n0.
template <class T>
Mat3<T> inverse_growth_tensor(const Vec3<T>& n0, const T& G) {
  return Mat3<T>::Identity() + (Real<T>(1) / G - Real<T>(1)) * n0 * n0.transpose();
}

/// Elastic part of the deformation gradient, F_e = F F_g^-1.
template <class T>
Mat3<T> elastic_part(const Mat3<T>& F, const Vec3<T>& n0, const T& G) {
  return F * inverse_growth_tensor(n0, G);
}

/// Right Cauchy-Green tensor C = F^T F; of F_e it is C_e.
template <class T>
Mat3<T> right_cauchy_green(const Mat3<T>& F) {
  return F.transpose() * F;
}

/// Left Cauchy-Green tensor b = F F^T; of F_e it is b_e.
template <class T>
Mat3<T> left_cauchy_green(const Mat3<T>& F) {
  return F * F.transpose();
}

/// Total fibre stretch lambda = |F n0| = sqrt(n0·C n0).
template <class T>
T fibre_stretch(const Mat3<T>& F, const Vec3<T>& n0) {
  const Vec3<T> f = F * n0;
  return sqrt(T(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
}

}  // namespace myogrowth

#endif
