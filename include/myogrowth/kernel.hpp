/// @file
/// The whole update of one material point in closed form, on plain numbers: growth, stress and tangent.
///
/// Second-order tensors that need not be symmetric (F, P) are 9 numbers, column by column; symmetric ones are
/// 6, in the order 11 22 33 12 13 23; fourth-order ones with both minor symmetries are 6 x 6, column by
/// column, where a column belongs to an engineering shear. These are the layouts of Fortran and of Abaqus.
///
/// Nothing here is inverted or multiplied out: with f = F n0,
///
///   b_e = F F^T + (1/G^2 - 1) f⊗f,  J_e = J/G                                               (eqs 1, 2)
///   tau = c1 ln(J_e) I + c2 (b_e - I)                                                         (eq. 3)
///   J DDSDDE = c1 I⊗I + c2 (I∘b_e + b_e∘I) + (dG/dlambda / lambda) dtau/dG ⊗ (f⊗f)
///
/// where (I∘b + b∘I):D = b D + D b. The forms keep their accuracy at small strain: they start from H = F - I.
/// material.hpp is the same with Eigen types; growth_tensor.hpp and neo_hookean.hpp are the definitions it is
/// held to.
#ifndef MYOGROWTH_KERNEL_HPP
#define MYOGROWTH_KERNEL_HPP

#include "growth_flow.hpp"
#include "measures.hpp"

namespace myogrowth {

/// The volume that the energy psi of eq. 3 is counted per. The literature has both (docs/theory.md).
enum class EnergyPer {
  reference_volume,  ///< the paper's own formulas; the default
  grown_volume       ///< psi and every stress are G times larger
};

/// How eq. 4 is integrated over a time step.
enum class TimeIntegration {
  backward_euler,  ///< first order; the default
  midpoint_flow    ///< second order: the exact flow at the stretch in the middle of the step
};

/// The material: neo-Hookean elasticity of the grown muscle, growth along the fibre. Defaults: the paper's
/// Table 1 (kPa, days). P as in GrowthRate.
template <class P = double>
struct FibreGrowth {
  P c1 = P(16);            ///< first Lamé constant, c1 + 2/3 c2 > 0 [stress]
  P c2 = P(4);             ///< second Lamé constant, > 0 [stress]
  GrowthRate<P> growth;    ///< eq. 4
  RemovalRate<P> removal;  ///< off unless removal.tau_rev > 0
  /// What psi is counted per.
  EnergyPer energy = EnergyPer::reference_volume;
  /// How eq. 4 is integrated.
  TimeIntegration integration = TimeIntegration::backward_euler;
};

/// What became of an update. Everything but ok leaves the state as it was and the stresses NaN.
enum class UpdateStatus {
  ok = 0,
  not_finite,        ///< NaN or infinity in F, n0, G or dt, or a result beyond the range of the scalar
  inverted,          ///< det F <= 0
  no_fibre,          ///< n0 has no direction: its length is zero
  bad_state,         ///< G <= 0; or lambda_n <= 0 in the midpoint flow
  not_converged = 7  ///< a stretch or growth variable was not found in 200 iterations (5, 6: myogrowth.h's)
};

/// Result of update_point.
template <class T>
struct PointUpdate {
  UpdateStatus status;  ///< whether there is a result
  int iterations;       ///< Newton steps of the growth equation
  T G;                  ///< sarcomere number at the end of the step [-]
  T dG_dlambda;         ///< consistent derivative of G with respect to lambda [-]
  T lambda;             ///< total fibre stretch [-]
  T lambda_e;           ///< elastic fibre stretch, lambda/G [-]
  T J;                  ///< det F [-]
  T Je;                 ///< det F_e = J/G [-]
  T psi;                ///< energy per unit reference volume [stress]
  T c1;                 ///< first Lamé constant used, G times the material's for grown_volume [stress]
  T c2;                 ///< second Lamé constant used [stress]
  T n0[3];              ///< unit fibre direction that was used [-]
  T f[3];               ///< deformed fibre F n0 [-]
  T be[6];              ///< elastic left Cauchy-Green tensor [-]
  T tau[6];             ///< Kirchhoff stress [stress]
  T dtau_dG[6];         ///< its derivative with respect to G at fixed F [stress]
};

namespace detail {

/// normalise() where the square of the length is out of range.
template <class T>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE bool normalise_scaled(const T n0[3], T unit[3]) {
  Real<T> largest(0);
  for (int i = 0; i < 3; ++i) {
    if (!is_finite(n0[i])) return false;
    const Real<T> length = value(n0[i]) < 0 ? -value(n0[i]) : value(n0[i]);
    if (length > largest) largest = length;
  }
  if (!(largest > 0)) return false;
  for (int i = 0; i < 3; ++i) unit[i] = n0[i] / largest;
  const T per_length = Real<T>(1) / sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2]);
  for (int i = 0; i < 3; ++i) unit[i] = unit[i] * per_length;
  return true;
}

}  // namespace detail

/// Makes n0 of any length a unit vector. False if it has no direction (zero, NaN or infinite).
/// A vector that is of unit length to rounding comes back bit for bit.
template <class T>
MYOGROWTH_FUNCTION bool normalise(const T n0[3], T unit[3]) {
  using V = Real<T>;
  using Limits = std::numeric_limits<V>;
  constexpr V least = (Limits::min)() / last_place<V>(), most = (Limits::max)();
  const T square = n0[0] * n0[0] + n0[1] * n0[1] + n0[2] * n0[2];
  const V size = value(square);
  if (!(size > least && size <= most)) {
    return detail::normalise_scaled(n0, unit);
  }
  constexpr V rounding = 4 * last_place<V>();
  const bool is_unit = std::is_same<T, V>::value && -rounding <= size - 1 && size - 1 <= rounding;
  if (is_unit) {
    for (int i = 0; i < 3; ++i) unit[i] = n0[i];
    return true;
  }
  const T per_length = V(1) / sqrt(square);
  for (int i = 0; i < 3; ++i) unit[i] = n0[i] * per_length;
  return true;
}

namespace detail {

template <class T>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE UpdateStatus fail(UpdateStatus status, const T& G_n,
                                                        PointUpdate<T>& out) {
  const T nan(std::numeric_limits<Real<T>>::quiet_NaN());
  out.status = status;
  out.iterations = 0;
  out.G = G_n;
  out.dG_dlambda = out.lambda = out.lambda_e = out.J = out.Je = out.psi = out.c1 = out.c2 = nan;
  for (int i = 0; i < 3; ++i) out.n0[i] = out.f[i] = nan;
  for (int i = 0; i < 6; ++i) out.be[i] = out.tau[i] = out.dtau_dG[i] = nan;
  return status;
}

/// The time step of eq. 4 that the material asks for, from the stretch lambda_n to lambda.
template <class T, class P>
MYOGROWTH_FUNCTION GrowthStep<T> grow(const FibreGrowth<P>& material, const T& G_n, const T& lambda_n,
                                      const T& lambda, const P& dt, std::true_type) {
  using V = Real<T>;
  if (material.integration == TimeIntegration::backward_euler) {
    return solve_growth(material.growth, material.removal, G_n, lambda, dt);
  }
  GrowthStep<T> step = flow_growth(material.growth, material.removal, G_n, T((lambda_n + lambda) / V(2)), dt);
  step.dG_dlambda = step.dG_dlambda / V(2);
  return step;
}

/// The flow does not carry derivatives with respect to parameters: it is not a number for them.
template <class T, class P>
MYOGROWTH_FUNCTION GrowthStep<T> grow(const FibreGrowth<P>& material, const T& G_n, const T&, const T& lambda,
                                      const P& dt, std::false_type) {
  const bool can = material.integration == TimeIntegration::backward_euler;
  const T nan(std::numeric_limits<Real<T>>::quiet_NaN());
  return can ? solve_growth(material.growth, material.removal, G_n, lambda, dt) : GrowthStep<T>{nan, nan, 0};
}

/// What the law needs of F. From H = F - I, so that small strains keep their digits.
template <class T>
struct Deformation {
  T J_minus_1;
  T b_minus_I[6];  ///< F F^T - I
  T f[3], lambda;  ///< F n and its length
};

template <class T>
MYOGROWTH_FUNCTION void deform(const T F[9], const T n[3], Deformation<T>& d) {
  const Real<T> one(1);
  const T H11 = rounded(T(F[0] - one)), H21 = F[1], H31 = F[2];
  const T H12 = F[3], H22 = rounded(T(F[4] - one)), H32 = F[5];
  const T H13 = F[6], H23 = F[7], H33 = rounded(T(F[8] - one));
  const T minor11 = H22 * H33 - H23 * H32;
  d.J_minus_1 = (H11 + H22 + H33) + (H11 * H22 - H12 * H21 + H11 * H33 - H13 * H31 + minor11) +
                (H11 * minor11 - H12 * (H21 * H33 - H23 * H31) + H13 * (H21 * H32 - H22 * H31));
  d.b_minus_I[0] = H11 + H11 + (H11 * H11 + H12 * H12 + H13 * H13);
  d.b_minus_I[1] = H22 + H22 + (H21 * H21 + H22 * H22 + H23 * H23);
  d.b_minus_I[2] = H33 + H33 + (H31 * H31 + H32 * H32 + H33 * H33);
  d.b_minus_I[3] = H12 + H21 + (H11 * H21 + H12 * H22 + H13 * H23);
  d.b_minus_I[4] = H13 + H31 + (H11 * H31 + H12 * H32 + H13 * H33);
  d.b_minus_I[5] = H23 + H32 + (H21 * H31 + H22 * H32 + H23 * H33);
  for (int i = 0; i < 3; ++i) d.f[i] = F[i] * n[0] + F[i + 3] * n[1] + F[i + 6] * n[2];
  d.lambda = sqrt(d.f[0] * d.f[0] + d.f[1] * d.f[1] + d.f[2] * d.f[2]);
}

/// What det F - 1 must exceed for deform() to give it, b_minus_I being F F^T - I: det F is then not a
/// difference of terms so large that they have lost its digits. (The sizes of the terms of deform()'s sum are
/// together no more than (|F| + sqrt(3))^3 / 4, and |F|^2 = tr(F F^T).)
template <class T>
MYOGROWTH_FUNCTION T least_J_minus_1(const T& b11_minus_1, const T& b22_minus_1, const T& b33_minus_1) {
  const T size = (b11_minus_1 + b22_minus_1) + (b33_minus_1 + Real<T>(6));
  return size * size * (Real<T>(1) / Real<T>(4096)) - Real<T>(1);
}

template <class T>
MYOGROWTH_FUNCTION bool is_accurate(const Deformation<T>& d) {
  return value(d.J_minus_1) >
         least_J_minus_1(value(d.b_minus_I[0]), value(d.b_minus_I[1]), value(d.b_minus_I[2]));
}

/// det F where deform() does not give it, and the fibre stretch, the length of f, where its square is below
/// the range; and whether there is a result with them. F is so small, so large or so close to singular that
/// its digits count, not those of F - I.
template <class T>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE UpdateStatus examine(const T F[9], const T f[3], T& J, T& lambda) {
  using V = Real<T>;
  J = determinant(F);
  if (!is_finite(J)) return UpdateStatus::not_finite;
  if (!(value(J) > 0)) return UpdateStatus::inverted;
  if (value(lambda) * value(lambda) > (std::numeric_limits<V>::min)() / last_place<V>())
    return UpdateStatus::ok;
  T unit[3];
  if (!normalise(f, unit)) return UpdateStatus::not_finite;
  lambda = f[0] * unit[0] + f[1] * unit[1] + f[2] * unit[2];
  return UpdateStatus::ok;
}

/// ln(x) for x that may be tiny, by what is asked of a scalar.
template <class T>
MYOGROWTH_FUNCTION MYOGROWTH_NOINLINE T logarithm(const T& x) {
  using V = Real<T>;
  using std::frexp;
  using std::ldexp;
  int exponent;
  (void)frexp(value(x), &exponent);
  const T mantissa = x * ldexp(V(1), -exponent);  // in [1/2, 1)
  return log1p(T(mantissa - V(1))) + V(exponent) * V(0.69314718055994530941723212145817657L);
}

/// ln(J_e); per_G = 1/G.
template <class T>
MYOGROWTH_FUNCTION T logarithm_of_Je(const T& J_minus_1, const T& G, const T& per_G) {
  const T J_minus_G = rounded(J_minus_1) - rounded(T(G - Real<T>(1)));
  return ln_1_plus(T(J_minus_G * per_G), J_minus_G, G);
}

/// All that follows from the deformation, det F (out.J) and the grown state, without a branch on them.
template <class T, class P>
MYOGROWTH_FUNCTION void stress(const FibreGrowth<P>& material, const Deformation<T>& d, const T& G,
                               const T& per_G, const T& ln_Je, PointUpdate<T>& out) {
  using V = Real<T>;
  const V one(1);
  const bool grown = material.energy == EnergyPer::grown_volume;
  const T G_minus_1 = rounded(T(G - one));
  out.G = G;
  out.lambda_e = d.lambda * per_G;
  out.Je = out.J * per_G;
  out.c1 = grown ? T(G * material.c1) : T(material.c1);
  out.c2 = grown ? T(G * material.c2) : T(material.c2);
  const T pressure = out.c1 * ln_Je;
  // b_e - I = (F F^T - I) - (G^2 - 1) fe⊗fe, the square written as in F F^T: F = F_g is exactly stress-free.
  const T square_minus_1 = G_minus_1 + G_minus_1 + G_minus_1 * G_minus_1;
  const T fe[3] = {quotient(d.f[0], G, per_G), quotient(d.f[1], G, per_G), quotient(d.f[2], G, per_G)};
  const T fefe[6] = {fe[0] * fe[0], fe[1] * fe[1], fe[2] * fe[2],
                     fe[0] * fe[1], fe[0] * fe[2], fe[1] * fe[2]};
  // dtau/dG at fixed F = -c1/G I - 2 c2/G fe⊗fe, and for grown_volume, where tau = G tau_ref, + tau/G.
  const T dtau_I = -out.c1 * per_G, dtau_fe = -(out.c2 + out.c2) * per_G;
  T trace(V(0));
  for (int i = 0; i < 6; ++i) {
    const T be_minus_I = d.b_minus_I[i] - square_minus_1 * fefe[i];
    out.be[i] = i < 3 ? T(one + be_minus_I) : be_minus_I;
    out.tau[i] = i < 3 ? T(pressure + out.c2 * be_minus_I) : T(out.c2 * be_minus_I);
    out.dtau_dG[i] = i < 3 ? T(dtau_I + dtau_fe * fefe[i]) : T(dtau_fe * fefe[i]);
    if (i < 3) trace = trace + be_minus_I;
  }
  if (grown) {  // separate loop: a branch inside prevents unrolling
    for (int i = 0; i < 6; ++i) out.dtau_dG[i] = out.dtau_dG[i] + out.tau[i] * per_G;
  }
  out.psi = (pressure * ln_Je + out.c2 * (trace - (ln_Je + ln_Je))) / V(2);
}

}  // namespace detail

/// One step of length dt [time] to the deformation gradient F[9], from the sarcomere number G_n, with the
/// fibre n0[3] of any length > 0. Same input, same output; nothing is remembered. dt <= 0 is an elastic step.
/// lambda_n: total fibre stretch at the beginning of the step, 1 if nothing has been deformed yet; only the
/// midpoint flow uses it (with parameters that are plain numbers).
template <class T, class P>
MYOGROWTH_FUNCTION MYOGROWTH_FLAT UpdateStatus update_point(const FibreGrowth<P>& material, const T F[9],
                                                            const T n0[3], const T& G_n, const T& lambda_n,
                                                            const P& dt, PointUpdate<T>& out) {
  using V = Real<T>;
  if (!is_finite(G_n) || !is_finite(dt)) return detail::fail(UpdateStatus::not_finite, G_n, out);
  if (!(value(G_n) > 0)) return detail::fail(UpdateStatus::bad_state, G_n, out);
  if (material.integration == TimeIntegration::midpoint_flow &&
      !(is_finite(lambda_n) && value(lambda_n) > 0)) {
    return detail::fail(is_finite(lambda_n) ? UpdateStatus::bad_state : UpdateStatus::not_finite, G_n, out);
  }
  const T* n = out.n0;
  if (!normalise(n0, out.n0)) {
    const bool finite = is_finite(n0[0]) && is_finite(n0[1]) && is_finite(n0[2]);
    return detail::fail(finite ? UpdateStatus::no_fibre : UpdateStatus::not_finite, G_n, out);
  }

  detail::Deformation<T> d;
  detail::deform(F, n, d);
  out.J = V(1) + d.J_minus_1;
  const bool is_accurate = detail::is_accurate(d);
  out.lambda = d.lambda;
  for (int i = 0; i < 3; ++i) out.f[i] = d.f[i];
  if (!is_accurate) {
    const UpdateStatus status = detail::examine(F, out.f, out.J, out.lambda);
    if (status != UpdateStatus::ok) return detail::fail(status, G_n, out);
    d.lambda = out.lambda;
  }

  const GrowthStep<T> step = detail::grow(material, G_n, lambda_n, out.lambda, dt, std::is_same<P, V>());
  out.dG_dlambda = step.dG_dlambda;
  out.iterations = step.iterations;
  const T per_G = V(1) / step.G;
  const T ln_Je =
      is_accurate ? detail::logarithm_of_Je(d.J_minus_1, step.G, per_G) : detail::logarithm(T(out.J * per_G));
  detail::stress(material, d, step.G, per_G, ln_Je, out);

  V sums[3] = {};  // (in three parts that do not wait for each other)
  for (int i = 0; i < 6; ++i) sums[i % 3] += value(out.tau[i]) + value(out.dtau_dG[i]);
  const V sum = (sums[0] + sums[1]) + (sums[2] + (value(out.psi) + value(out.lambda_e)));
  if (!is_finite(sum) && !(are_finite(out.tau, 6) && are_finite(out.dtau_dG, 6) && is_finite(out.psi) &&
                           is_finite(out.lambda_e)))
    return detail::fail(UpdateStatus::not_finite, G_n, out);
  out.status = UpdateStatus::ok;
  return out.status;
}

/// The same from the undeformed fibre, or with backward Euler, which does not ask where the step comes from.
template <class T, class P>
MYOGROWTH_FUNCTION UpdateStatus update_point(const FibreGrowth<P>& material, const T F[9], const T n0[3],
                                             const T& G_n, const P& dt, PointUpdate<T>& out) {
  return update_point(material, F, n0, G_n, T(Real<T>(1)), dt, out);
}

/// Spatial modulus c[36] of the Jaumann rate of the Kirchhoff stress, times a factor; with the factor 1/J it
/// is Abaqus's DDSDDE. Consistent with the discrete update: d tau = c:D for a symmetric increment dF = D F.
/// Unsymmetric where the muscle grows. Array: T[36], or what takes c[i] = T.
template <class T, class Array>
MYOGROWTH_FUNCTION void spatial_modulus(const PointUpdate<T>& u, Array&& c, const T& factor = T(Real<T>(1))) {
  using V = Real<T>;
  const T c1 = factor * u.c1, c2 = factor * u.c2, half_c2 = c2 / V(2), zero(0), two(V(2));
  const T b1 = c2 * u.be[0], b2 = c2 * u.be[1], b3 = c2 * u.be[2];
  const T b12 = c2 * u.be[3], b13 = c2 * u.be[4], b23 = c2 * u.be[5];
  const T h1 = half_c2 * u.be[0], h2 = half_c2 * u.be[1], h3 = half_c2 * u.be[2];
  const T h12 = half_c2 * u.be[3], h13 = half_c2 * u.be[4], h23 = half_c2 * u.be[5];
  const T* g = u.dtau_dG;
  const bool grows = !is_zero(u.dG_dlambda);
  const T weight = grows ? T((factor / u.lambda) * u.dG_dlambda) : zero;  // (what is known last comes last)
  // Column j, the elastic part given: what growth adds is dtau/dG times (f⊗f)_j.
  const auto column = [&](int j, const T& e1, const T& e2, const T& e3, const T& e4, const T& e5,
                          const T& e6) {
    if (grows) {
      const T w = weight * u.f[symmetric_row(j)] * u.f[symmetric_column(j)];
      c[6 * j] = e1 + g[0] * w, c[6 * j + 1] = e2 + g[1] * w, c[6 * j + 2] = e3 + g[2] * w;
      c[6 * j + 3] = e4 + g[3] * w, c[6 * j + 4] = e5 + g[4] * w, c[6 * j + 5] = e6 + g[5] * w;
    } else {
      c[6 * j] = e1, c[6 * j + 1] = e2, c[6 * j + 2] = e3, c[6 * j + 3] = e4, c[6 * j + 4] = e5,
            c[6 * j + 5] = e6;
    }
  };
  // clang-format off
  column(0, c1 + two * b1, c1,            c1,            b12,     b13,     zero);
  column(1, c1,            c1 + two * b2, c1,            b12,     zero,    b23);
  column(2, c1,            c1,            c1 + two * b3, zero,    b13,     b23);
  column(3, b12,          b12,          zero,         h1 + h2, h23,     h13);
  column(4, b13,          zero,         b13,          h23,     h1 + h3, h12);
  column(5, zero,         b23,          b23,          h13,     h12,     h2 + h3);
  // clang-format on
}

}  // namespace myogrowth

#endif
