/// @file
/// Conversions between the measures that hosts ask for, each formula once.
///
/// The law gives the Kirchhoff stress tau and the spatial modulus c of its Jaumann rate (kernel.hpp, also for
/// the layouts used here). From these two follow:
///
///   Abaqus:          sigma = tau/J,             DDSDDE = c/J
///   Truesdell (Lie): C = c - (I∘tau + tau∘I),   (I∘tau + tau∘I):D = tau D + D tau
///   first Piola:     P = tau F^-T,              dP_iJ/dF_kL = F^-1_Jj F^-1_Ll (C_ijkl + delta_ik tau_jl)
///   second Piola:    S = F^-1 tau F^-T,         dS_IJ/dE_KL = F^-1_Ii F^-1_Jj F^-1_Kk F^-1_Ll C_ijkl
///
/// (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, ch. 5-6; Abaqus Theory Guide.)
#ifndef MYOGROWTH_MEASURES_HPP
#define MYOGROWTH_MEASURES_HPP

#include "scalar.hpp"

namespace myogrowth {

/// Place of component ij of a symmetric tensor among its six: 11 22 33 12 13 23.
constexpr int symmetric_index(int i, int j) { return i == j ? i : i + j + 2; }
/// Row of component a of the six.
constexpr int symmetric_row(int a) { return a < 3 ? a : a == 5 ? 1 : 0; }
/// Column of component a of the six.
constexpr int symmetric_column(int a) { return a < 3 ? a : a == 3 ? 1 : 2; }

/// Cofactors[9] of F[9]; returns det F.
template <class T>
MYOGROWTH_FUNCTION T cofactors(const T F[9], T cofactor[9]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
      cofactor[i + 3 * j] = F[p + 3 * r] * F[q + 3 * s] - F[p + 3 * s] * F[q + 3 * r];
    }
  }
  return F[0] * cofactor[0] + F[3] * cofactor[3] + F[6] * cofactor[6];
}

/// det F[9], and 0 where it is no more than what rounding leaves of its terms, and the rounding of F's
/// entries makes of a singular F: 4 units in the last place of the sum of the terms' sizes each. NaN or
/// infinite where F, or a product of three entries, is.
template <class T>
MYOGROWTH_FUNCTION T determinant(const T F[9]) {
  using V = Real<T>;
  const auto size = [F](int i) { return value(F[i]) < 0 ? -value(F[i]) : value(F[i]); };
  const V terms = size(0) * (size(4) * size(8) + size(5) * size(7)) +
                  size(3) * (size(1) * size(8) + size(2) * size(7)) +
                  size(6) * (size(1) * size(5) + size(2) * size(4));
  if (!is_finite(terms)) return T(terms);
  T cofactor[9];
  const T det = cofactors(F, cofactor);
  const V rounding = 8 * last_place<V>() * terms;
  return -rounding <= value(det) && value(det) <= rounding ? T(V(0)) : det;
}

/// Inverse[9] of F[9], by cofactors.
template <class T>
MYOGROWTH_FUNCTION void inverse(const T F[9], T inv[9]) {
  T cofactor[9];
  const T det = cofactors(F, cofactor);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) inv[i + 3 * j] = cofactor[j + 3 * i] / det;
  }
}

/// y[9] = A symmetric B^T for A, B[9] and symmetric s[6].
template <class T>
MYOGROWTH_FUNCTION void push(const T A[9], const T s[6], const T B[9], T y[9]) {
  for (int i = 0; i < 3; ++i) {
    T row[3];
    for (int l = 0; l < 3; ++l) {
      row[l] = A[i] * s[symmetric_index(0, l)] + A[i + 3] * s[symmetric_index(1, l)] +
               A[i + 6] * s[symmetric_index(2, l)];
    }
    for (int j = 0; j < 3; ++j) y[i + 3 * j] = row[0] * B[j] + row[1] * B[j + 3] + row[2] * B[j + 6];
  }
}

/// y[6] = A s A^T for A[9] and symmetric s[6].
template <class T>
MYOGROWTH_FUNCTION void push_symmetric(const T A[9], const T s[6], T y[6]) {
  T full[9];
  push(A, s, A, full);
  for (int a = 0; a < 6; ++a) y[a] = full[symmetric_row(a) + 3 * symmetric_column(a)];
}

/// y_abcd = A_ai A_bj A_ck A_dl x_ijkl for A[9] and x[36] with both minor symmetries.
template <class T>
MYOGROWTH_FUNCTION void push_modulus(const T A[9], const T x[36], T y[36]) {
  T half[36];  // rows pushed
  for (int col = 0; col < 6; ++col) push_symmetric(A, x + 6 * col, half + 6 * col);
  for (int row = 0; row < 6; ++row) {
    T in[6], out[6];
    for (int col = 0; col < 6; ++col) in[col] = half[row + 6 * col];
    push_symmetric(A, in, out);
    for (int col = 0; col < 6; ++col) y[row + 6 * col] = out[col];
  }
}

/// t[36] = sign * (I∘tau + tau∘I), added to c[36]: what the Jaumann modulus is more than Truesdell's.
template <class T>
MYOGROWTH_FUNCTION void add_rate_terms(const T tau[6], int sign, const T c[36], T t[36]) {
  using V = Real<T>;
  const V half = V(sign) / V(2);
  for (int col = 0; col < 6; ++col) {
    const int k = symmetric_row(col), l = symmetric_column(col);
    for (int row = 0; row < 6; ++row) {
      const int i = symmetric_row(row), j = symmetric_column(row);
      T sum(0);
      if (i == k) sum = sum + tau[symmetric_index(j, l)];
      if (i == l) sum = sum + tau[symmetric_index(j, k)];
      if (j == k) sum = sum + tau[symmetric_index(i, l)];
      if (j == l) sum = sum + tau[symmetric_index(i, k)];
      t[row + 6 * col] = c[row + 6 * col] + half * sum;
    }
  }
}

/// Truesdell modulus C[36] (of the Lie derivative of tau) from the Jaumann modulus c[36].
template <class T>
MYOGROWTH_FUNCTION void truesdell_from_jaumann(const T tau[6], const T c[36], T C[36]) {
  add_rate_terms(tau, -1, c, C);
}

/// Cauchy stress sigma[6] = tau/J.
template <class T>
MYOGROWTH_FUNCTION void cauchy_from_kirchhoff(const T& J, const T tau[6], T sigma[6]) {
  const T per_J = Real<T>(1) / J;
  for (int i = 0; i < 6; ++i) sigma[i] = tau[i] * per_J;
}

/// First Piola-Kirchhoff stress P[9] = tau F^-T.
template <class T>
MYOGROWTH_FUNCTION void first_piola_from_kirchhoff(const T F[9], const T tau[6], T P[9]) {
  const T identity[9] = {T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)};
  T inv[9];
  inverse(F, inv);
  push(identity, tau, inv, P);
}

/// dP_dF[81], where entry (i + 3J) + 9 (k + 3L) is dP_iJ/dF_kL.
template <class T>
MYOGROWTH_FUNCTION void dP_dF_from_jaumann(const T F[9], const T tau[6], const T c[36], T dP_dF[81]) {
  const T identity[9] = {T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)};
  T inv[9], P[9], C[36];
  inverse(F, inv);
  push(identity, tau, inv, P);
  truesdell_from_jaumann(tau, c, C);
  // half_iJkl = F^-1_Jj (C_ijkl + delta_ik tau_jl), where F^-1_Jj tau_jl = P_lJ
  T half[81];
  for (int l = 0; l < 3; ++l) {
    for (int k = 0; k < 3; ++k) {
      T* column = half + 9 * (k + 3 * l);
      push(identity, C + 6 * symmetric_index(k, l), inv, column);
      for (int J = 0; J < 3; ++J) column[k + 3 * J] = column[k + 3 * J] + P[l + 3 * J];
    }
  }
  for (int L = 0; L < 3; ++L) {
    for (int k = 0; k < 3; ++k) {
      for (int row = 0; row < 9; ++row) {
        dP_dF[row + 9 * (k + 3 * L)] = inv[L] * half[row + 9 * k] + inv[L + 3] * half[row + 9 * (k + 3)] +
                                       inv[L + 6] * half[row + 9 * (k + 6)];
      }
    }
  }
}

/// dtau_dF[54], where entry a + 6 (k + 3L) is dtau_a/dF_kL, by the product rule on tau = P F^T.
template <class T>
MYOGROWTH_FUNCTION void dtau_dF_from_dP_dF(const T F[9], const T P[9], const T dP_dF[81], T dtau_dF[54]) {
  for (int column = 0; column < 9; ++column) {
    const int k = column % 3, L = column / 3;
    for (int a = 0; a < 6; ++a) {
      const int i = symmetric_row(a), j = symmetric_column(a);
      T sum = j == k ? P[i + 3 * L] : T(0);
      for (int J = 0; J < 3; ++J) sum = sum + dP_dF[(i + 3 * J) + 9 * column] * F[j + 3 * J];
      dtau_dF[a + 6 * column] = sum;
    }
  }
}

/// dsigma_dF[54] = (dtau_dF - tau⊗F^-T)/J, in the layout of dtau_dF[54].
template <class T>
MYOGROWTH_FUNCTION void dsigma_dF_from_dtau_dF(const T F[9], const T& J, const T tau[6], const T dtau_dF[54],
                                               T dsigma_dF[54]) {
  T inv[9];
  inverse(F, inv);
  for (int column = 0; column < 9; ++column) {
    const int k = column % 3, L = column / 3;
    for (int a = 0; a < 6; ++a) {
      const int entry = a + 6 * column;
      dsigma_dF[entry] = (dtau_dF[entry] - tau[a] * inv[L + 3 * k]) / J;
    }
  }
}

/// Second Piola-Kirchhoff stress S[6] = F^-1 tau F^-T.
template <class T>
MYOGROWTH_FUNCTION void second_piola_from_kirchhoff(const T F[9], const T tau[6], T S[6]) {
  T inv[9];
  inverse(F, inv);
  push_symmetric(inv, tau, S);
}

/// dS_dE[36] (columns: engineering shear 2E).
template <class T>
MYOGROWTH_FUNCTION void dS_dE_from_jaumann(const T F[9], const T tau[6], const T c[36], T dS_dE[36]) {
  T inv[9], C[36];
  inverse(F, inv);
  truesdell_from_jaumann(tau, c, C);
  push_modulus(inv, C, dS_dE);
}

}  // namespace myogrowth

#endif
