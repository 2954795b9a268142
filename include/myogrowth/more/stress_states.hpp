/// @file
/// The update under a stress that is prescribed to vanish: plane stress and uniaxial stress.
///
/// Wrappers over update_point: they look for the stretch that frees the stress. With FibreGrowth that stress
/// grows monotonely in ln(stretch) (docs/theory.md), so a bracketed Newton method finds the one root from any
/// start. With other elastic laws (FibreGrowthOf) there may be several roots, or none: what is found is a
/// root where the stress changes its sign, or the status says that none was.
///
/// Material and Point: FibreGrowth and PointUpdate, or FibreGrowthOf and ElasticPointUpdate, which take the
/// activation as their last argument.
#ifndef MYOGROWTH_MORE_STRESS_STATES_HPP
#define MYOGROWTH_MORE_STRESS_STATES_HPP

#include "../kernel.hpp"

namespace myogrowth {

namespace detail {

/// Finds the stretch x > 0 at which a stress vanishes that grows with it, starting from x, or from
/// second_start() where a stiff law has no result at x.
/// evaluate(x, stress, slope) gives the stress and its derivative with respect to ln x. On return the last
/// evaluation was made at the stretch found; not_converged if 200 do not find it. Newton's method, halving
/// the bracket where that does not do better: the stress has a kink where growth sets in, and is almost flat
/// while growth takes up all of the stretch. Where there is no bracket yet and Newton's steps stay small, as
/// with a stress like x^-n, they are doubled.
template <class T, class Evaluate, class SecondStart>
MYOGROWTH_FUNCTION UpdateStatus free_stretch(T& x, const Evaluate& evaluate,
                                             const SecondStart& second_start) {
  using V = Real<T>;
  // Quadratic convergence: after a step of this size rounding is left, and derivatives lag one step behind.
  const V negligible = sqrt(last_place<V>());
  int steps_left = std::is_same<T, V>::value ? 1 : 2;
  V low(0), high(0), last_size(1), last_good(0);  // 0: not known yet
  V last_newton(0), stride(0), widening(0);
  bool is_stiff = false;
  UpdateStatus failure = UpdateStatus::not_converged;
  for (int iteration = 0; iteration < 200; ++iteration) {
    T stress, slope;
    const UpdateStatus status = evaluate(x, stress, slope);
    if (status == UpdateStatus::not_finite && steps_left > 0 && widening <= V(1)) {
      // A stiff law left the range of the scalar: back towards where there was a result. Where there was none
      // yet, from the second start on to larger stretches.
      failure = status;
      if (last_good > 0) {
        x = T(sqrt(value(x)) * sqrt(last_good));
      } else {
        x = widening > 0 ? T(x * (V(1) + widening)) : second_start();
        widening = widening > 0 ? 2 * widening : V(1) / 64;
      }
      last_size = V(1);
      continue;
    }
    if (status != UpdateStatus::ok || steps_left == 0) return status;
    last_good = value(x);
    widening = V(0);
    (value(stress) > 0 ? high : low) = value(x);
    const T step = -stress / slope;
    const V size = value(step) < 0 ? -value(step) : value(step);
    if (size <= negligible) {
      // The error that is left: the step squared times a factor, which the last two steps tell; else 1e6. A
      // stiff law needs one step more.
      const V curvature = last_newton > 0 ? size / (last_newton * last_newton) : V(1e6);
      if (!is_stiff && curvature * size * size > last_place<V>() / 4) {
        is_stiff = true;
      } else {
        --steps_left;
      }
      x = x + x * step;  // (not x (1 + step), whose rounding a stiff law shows)
      continue;
    }
    const T next = x * (V(1) + step);
    const bool inside = value(next) > low && (value(next) < high || high == 0);
    const bool bracketed = low > 0 && high > 0;
    const bool slow = !bracketed && last_newton > 0 && size > last_newton / 2;
    stride = slow ? 2 * (size > stride ? size : stride) : V(0);
    if (stride > 1) stride = V(1);
    last_newton = size;
    if (value(slope) > 0 && inside && size <= (bracketed ? last_size / 2 : V(1))) {
      x = !(stride > size) ? next : value(step) > 0 ? T(x * (V(1) + stride)) : T(x / (V(1) + stride));
      last_size = size;
    } else {
      const V middle = bracketed ? sqrt(low) * sqrt(high) : high == 0 ? low * 2 : high / 2;
      last_size = bracketed ? high / low - 1 : V(1);
      last_newton = V(0);
      x = T(middle);
    }
  }
  return failure;
}
template <class T, class Evaluate>
MYOGROWTH_FUNCTION UpdateStatus free_stretch(T& x, const Evaluate& evaluate) {
  return free_stretch(x, evaluate, [] { return T(Real<T>(1)); });
}

}  // namespace detail

/// Plane stress in the 1-2 plane (membranes, shells): F is known only in the plane, and the thickness
/// stretch F_33 is the one at which tau_33 = 0. The fibre n0[3] lies in the plane or is normal to it; for an
/// oblique one the transverse shear stresses do not vanish and are left out, as plane stress does.
///
/// F[4]: F_11, F_21, F_12, F_22. thickness: in, a start for F_33 (<= 0: none); out, F_33. u: the update at
/// that F. c[9]: condensed modulus of the Jaumann rate of tau, rows and columns 11 22 12, column-major,
/// engineering shear.
template <class Material, class T, class P, class Point, class... Activation>
MYOGROWTH_FUNCTION UpdateStatus plane_stress(const Material& material, const T F[4], const T n0[3],
                                             const T& G_n, const T& lambda_n, const P& dt, T& thickness,
                                             Point& u, T c[9], const Activation&... activation) {
  using V = Real<T>;
  const T zero(0);
  T full[36];
  const auto modulus = [&](int row, int column) { return full[row + 6 * column]; };
  T x = value(thickness) > 0 && is_finite(thickness) ? thickness : T(V(1));
  // No change of the elastic volume.
  const auto isochoric = [&] { return T(G_n / (F[0] * F[3] - F[1] * F[2])); };
  const auto evaluate = [&](const T& F33, T& stress, T& slope) {
    const T F3[9] = {F[0], F[1], zero, F[2], F[3], zero, zero, zero, F33};
    const UpdateStatus made = update_point(material, F3, n0, G_n, lambda_n, dt, u, activation...);
    spatial_modulus(u, full);
    stress = u.tau[2];
    slope = modulus(2, 2);
    return made;
  };
  const UpdateStatus status = detail::free_stretch(x, evaluate, isochoric);
  if (status != UpdateStatus::ok) {
    detail::fail(status, G_n, u);
    for (int i = 0; i < 9; ++i) c[i] = u.tau[0];  // NaN
    return status;
  }
  thickness = x;
  const int in_plane[3] = {0, 1, 3};
  for (int col = 0; col < 3; ++col) {
    for (int row = 0; row < 3; ++row) {
      const int i = in_plane[row], j = in_plane[col];
      c[row + 3 * col] = modulus(i, j) - modulus(i, 2) * modulus(2, j) / modulus(2, 2);
    }
  }
  return status;
}

/// Uniaxial stress along the fibre, as in a strip that is pulled with its sides free: the axial stretch is
/// known, and the lateral stretch is the one at which tau_22 = tau_33 = 0.
///
/// lateral: in, a start (<= 0: none); out, the lateral stretch. u: the update at F = diag(stretch, lateral,
/// lateral) with the fibre along 1, so that the axial force per reference area is u.tau[0]/stretch. slope:
/// dtau_11/dln(stretch) at free sides, growth included [stress].
template <class Material, class T, class P, class Point, class... Activation>
MYOGROWTH_FUNCTION UpdateStatus uniaxial_stress(const Material& material, const T& stretch, const T& G_n,
                                                const T& lambda_n, const P& dt, T& lateral, Point& u,
                                                T& slope, const Activation&... activation) {
  using V = Real<T>;
  const T zero(0), n0[3] = {T(V(1)), zero, zero};
  T c[36];
  const auto modulus = [&](int row, int column) { return c[row + 6 * column]; };
  T x = value(lateral) > 0 && is_finite(lateral) ? lateral : T(V(1));
  const auto isochoric = [&] { return T(sqrt(T(G_n / stretch))); };
  const auto evaluate = [&](const T& side, T& stress, T& dstress) {
    const T F[9] = {stretch, zero, zero, zero, side, zero, zero, zero, side};
    const UpdateStatus made = update_point(material, F, n0, G_n, lambda_n, dt, u, activation...);
    spatial_modulus(u, c);
    stress = u.tau[1];
    dstress = modulus(1, 1) + modulus(1, 2);
    return made;
  };
  const UpdateStatus status = detail::free_stretch(x, evaluate, isochoric);
  if (status != UpdateStatus::ok) {
    detail::fail(status, G_n, u);
    slope = u.tau[0];  // NaN
    return status;
  }
  lateral = x;
  slope = modulus(0, 0) - (modulus(0, 1) + modulus(0, 2)) * modulus(1, 0) / (modulus(1, 1) + modulus(1, 2));
  return status;
}

}  // namespace myogrowth

#endif
