/// @file
/// The left stretch tensor V = sqrt(F F^T), for hosts that give F in a basis that turns with the material.
#ifndef MYOGROWTH_MORE_LEFT_STRETCH_HPP
#define MYOGROWTH_MORE_LEFT_STRETCH_HPP

#include <limits>

#include "../measures.hpp"

namespace myogrowth {

/// V[9] with V V = F F^T, symmetric and positive definite; V may be F. False, and V untouched, if F has none:
/// det F <= 0, or not finite.
///
/// The rotation R of F = V R comes from Newton's method for the polar decomposition (Higham 1986),
/// X <- (X + X^-T)/2 with scaling: equal stretches are no trouble to it, and it carries derivatives.
template <class T>
MYOGROWTH_FUNCTION bool left_stretch(const T F[9], T V[9]) {
  using R = Real<T>;
  const R one(1);
  T X[9], inv[9];
  R size(0);
  for (int i = 0; i < 9; ++i) {
    X[i] = F[i];
    size = size + value(F[i]) * value(F[i]);
  }
  const T det = determinant(F);
  if (!is_finite(size) || !is_finite(det) || !(value(det) > 0)) return false;

  // With scaling it takes a few steps; the bound is for F that are singular to rounding.
  bool last = false;
  for (int iteration = 0; iteration < 40; ++iteration) {
    inverse(X, inv);
    R x_size(0), inv_size(0), change(0);
    for (int i = 0; i < 9; ++i) {
      x_size += value(X[i]) * value(X[i]);
      inv_size += value(inv[i]) * value(inv[i]);
    }
    R scale = sqrt(sqrt(inv_size / x_size));
    if (scale > R(0.9) && scale < R(1.1)) scale = one;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const T next = (scale * X[i + 3 * j] + inv[j + 3 * i] / scale) / R(2);
        const R difference = value(next) - value(X[i + 3 * j]);
        change += difference * difference;
        X[i + 3 * j] = next;
      }
    }
    if (!is_finite(change)) return false;
    if (last) break;
    last = change < R(64) * last_place<R>();  // then the next step is exact to rounding
  }
  T full[9];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) full[i + 3 * j] = F[i] * X[j] + F[i + 3] * X[j + 3] + F[i + 6] * X[j + 6];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) V[i + 3 * j] = (full[i + 3 * j] + full[j + 3 * i]) / R(2);
  }
  return true;
}

}  // namespace myogrowth

#endif
