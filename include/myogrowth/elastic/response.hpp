/// @file
/// What an elastic law is to the rest of the library, and the tensors that the laws of this folder are made
/// of.
///
/// A law is one struct with its parameters and one function,
///
///     template <class T>
///     void evaluate(const T Fe[9], const T n0[3], const T& activation, ElasticResponse<T>& out) const;
///
/// where n0 is a unit vector. It must be objective; that is all that growth asks of it (fibre_growth_of.hpp).
/// A law that is given by its energy only has psi(Fe, n0, activation) instead (from_energy.hpp).
///
/// Names below: M = f⊗f/|f|^2 with f = F_e n0, Q = I - M, and (I∘A + A∘I):D = A D + D A.
#ifndef MYOGROWTH_ELASTIC_RESPONSE_HPP
#define MYOGROWTH_ELASTIC_RESPONSE_HPP

#include "../kernel.hpp"

namespace myogrowth {

/// What an elastic law gives at one deformation F_e.
template <class T>
struct ElasticResponse {
  T psi;     ///< energy [stress]
  T tau[6];  ///< Kirchhoff stress F_e S_e F_e^T [stress]
  T c[36];   ///< modulus of its Jaumann rate: dtau = c:D for dF_e = D F_e, D symmetric [stress]
};

/// The elastic deformation as the laws need it; small strains keep their digits.
template <class T>
struct ElasticDeformation {
  T J_minus_1;  ///< det F_e - 1 [-]
  T ln_J;       ///< ln(det F_e) [-]
  T B[6];       ///< F_e F_e^T - I [-]
  T f[3];       ///< F_e n0 [-]
  T lambda;     ///< its length, the elastic fibre stretch [-]
};

/// Makes it, for det F_e > 0.
template <class T>
MYOGROWTH_FUNCTION ElasticDeformation<T> elastic_deformation(const T Fe[9], const T n0[3]) {
  using V = Real<T>;
  detail::Deformation<T> d;
  detail::deform(Fe, n0, d);
  ElasticDeformation<T> e;
  for (int i = 0; i < 6; ++i) e.B[i] = d.b_minus_I[i];
  for (int i = 0; i < 3; ++i) e.f[i] = d.f[i];
  e.lambda = d.lambda;
  e.J_minus_1 = d.J_minus_1;
  if (detail::is_accurate(d)) {
    e.ln_J = log1p(d.J_minus_1);
  } else {
    T J;
    (void)detail::examine(Fe, e.f, J, e.lambda);
    e.J_minus_1 = J - V(1);
    e.ln_J = detail::logarithm(J);
  }
  return e;
}

/// The invariants of C_e = F_e^T F_e and n0, for energies that are written in them.
template <class T>
struct Invariants {
  T I1;  ///< tr C_e [-]
  T I2;  ///< (I1^2 - tr C_e^2)/2 [-]
  T J;   ///< det F_e [-]
  T I4;  ///< n0·C_e n0, the squared fibre stretch [-]
  T I5;  ///< n0·C_e^2 n0 [-]
};

/// Makes them.
template <class T>
MYOGROWTH_FUNCTION Invariants<T> invariants(const T Fe[9], const T n0[3]) {
  using V = Real<T>;
  T C[9], Cn[3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      C[i + 3 * j] = Fe[3 * i] * Fe[3 * j] + Fe[3 * i + 1] * Fe[3 * j + 1] + Fe[3 * i + 2] * Fe[3 * j + 2];
  }
  for (int i = 0; i < 3; ++i) Cn[i] = C[i] * n0[0] + C[i + 3] * n0[1] + C[i + 6] * n0[2];
  T square(V(0));
  for (int i = 0; i < 9; ++i) square = square + C[i] * C[i];
  Invariants<T> in;
  in.I1 = C[0] + C[4] + C[8];
  in.I2 = (in.I1 * in.I1 - square) / V(2);
  in.J = determinant(Fe);
  in.I4 = Cn[0] * n0[0] + Cn[1] * n0[1] + Cn[2] * n0[2];
  in.I5 = Cn[0] * Cn[0] + Cn[1] * Cn[1] + Cn[2] * Cn[2];
  return in;
}

/// a⊗b + b⊗a, the six components.
template <class T>
MYOGROWTH_FUNCTION void symmetric_dyad(const T a[3], const T b[3], T s[6]) {
  for (int k = 0; k < 6; ++k) {
    const int i = symmetric_row(k), j = symmetric_column(k);
    s[k] = a[i] * b[j] + b[i] * a[j];
  }
}

/// c = c + weight A⊗B.
template <class T>
MYOGROWTH_FUNCTION void add_dyad(const T& weight, const T A[6], const T B[6], T c[36]) {
  for (int j = 0; j < 6; ++j) {
    const T w = weight * B[j];
    for (int i = 0; i < 6; ++i) c[i + 6 * j] = c[i + 6 * j] + w * A[i];
  }
}

/// c = c + (I∘A + A∘I), the rate of what turns and stretches with the material on both sides.
template <class T>
MYOGROWTH_FUNCTION void add_rate(const T A[6], T c[36]) {
  add_rate_terms(A, +1, c, c);
}

/// c:D = c:D + weight A D A.
template <class T>
MYOGROWTH_FUNCTION void add_sandwich(const T& weight, const T A[6], T c[36]) {
  const T half = weight / Real<T>(2);
  for (int col = 0; col < 6; ++col) {
    const int k = symmetric_row(col), l = symmetric_column(col);
    for (int row = 0; row < 6; ++row) {
      const int i = symmetric_row(row), j = symmetric_column(row);
      c[row + 6 * col] = c[row + 6 * col] + half * (A[symmetric_index(i, k)] * A[symmetric_index(j, l)] +
                                                    A[symmetric_index(i, l)] * A[symmetric_index(j, k)]);
    }
  }
}

/// c:D = c:D + m⊗(A D m) + (A D m)⊗m for a unit vector m and A with A m = 0. With A = Q it is the rate of
/// m⊗m where m is the direction of f.
template <class T>
MYOGROWTH_FUNCTION void add_turning(const T m[3], const T A[6], T c[36]) {
  for (int col = 0; col < 6; ++col) {
    const int k = symmetric_row(col), l = symmetric_column(col);
    T r[3], s[6];
    for (int i = 0; i < 3; ++i) {
      r[i] = (A[symmetric_index(i, k)] * m[l] + A[symmetric_index(i, l)] * m[k]) / Real<T>(2);
    }
    symmetric_dyad(m, r, s);
    for (int row = 0; row < 6; ++row) c[row + 6 * col] = c[row + 6 * col] + s[row];
  }
}

}  // namespace myogrowth

#endif
