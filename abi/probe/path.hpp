/// @file
/// The path that the probe's element is led along, and the law that it has on the way (docs/probe.md).
#ifndef MYOGROWTH_ABI_PROBE_PATH_HPP
#define MYOGROWTH_ABI_PROBE_PATH_HPP

#include <cmath>

namespace probe {

/// std::complex would bring libgcc_s.
struct Complex {
  double re, im;
};
inline Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
inline Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
inline Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
inline Complex operator*(double k, Complex a) { return {k * a.re, k * a.im}; }
inline Complex conj(Complex a) { return {a.re, -a.im}; }
inline Complex polar(double size, double angle) { return {size * std::cos(angle), size * std::sin(angle)}; }
inline double abs(Complex a) { return std::hypot(a.re, a.im); }
inline double arg(Complex a) { return std::atan2(a.im, a.re); }

// To t = 2: only F11 is prescribed, 1e-4 up and down, F22 and F33 are free, so that the host has to solve
// with DDSDDE. To t = 4: stretch and shear. To t = 10: a rigid rotation of 90 degrees about axis 3, in
// unequal parts. F33 grows all the way from t = 2; no turn of the basis about axis 3 and no transposition
// changes it: it is the clock.

constexpr double free_until = 2, sheared_at = 4, path_end = 10, f33_rate = 0.05;
constexpr double turned_by[] = {0, 10, 35, 45, 65, 70, 90};  // degrees at t = 4, 5, ...

/// A matrix in the plane as a map of complex numbers: F x = p x + q conj(x). To turn it from the left is to
/// multiply p and q by exp(i angle), to transpose it is to conjugate p; U of the polar decomposition has p >
/// 0.
struct Planar {
  Complex p, q;
};

inline Planar planar(double f11, double f21, double f12, double f22) {
  return {{(f11 + f22) / 2, (f21 - f12) / 2}, {(f11 - f22) / 2, (f21 + f12) / 2}};
}

inline Planar knot(int t) {
  if (t <= 2) return planar(1, 0, 0, 1);
  if (t == 3) return planar(1.1, 0, 0.15, 0.95);
  const Planar sheared = planar(1.2, 0, 0.3, 0.9);
  const Complex turn = polar(1, turned_by[t < 10 ? t - 4 : 6] * std::acos(-1.0) / 180);
  return {turn * sheared.p, turn * sheared.q};
}

/// F in the plane at t, in fixed axes: displacements are linear in time between whole t.
inline Planar expected(double t) {
  const int from = t < 2 ? 2 : t < 9 ? static_cast<int>(t) : 9;
  const Planar a = knot(from), b = knot(from + 1);
  const double s = t - from;
  return {a.p + s * (b.p - a.p), a.q + s * (b.q - a.q)};
}

inline double clock_of(const double* F) { return free_until + (F[8] - 1) / f33_rate; }

/// d sigma / d eps in units of PROPS(1): unsymmetric, its symmetric part positive definite. 22 and 33 meet no
/// shear, so the free strains stay uniform.
constexpr double modulus[6][6] = {{3, 1.5, 0.7, 0, 0, 0}, {0.5, 3, 1.6, 0, 0, 0}, {1.3, 0.4, 3, 0, 0, 0},
                                  {0, 0, 0, 1, 0, 0},     {0, 0, 0, 0, 1, 0},     {0, 0, 0, 0, 0, 1}};
/// Stress on the prescribed part of the path, in the same units.
constexpr double held_stress[6] = {0.02, -0.01, 0.005, 0.012, 0, 0};

}  // namespace probe

#endif
