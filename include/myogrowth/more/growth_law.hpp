/// @file
/// Growth laws of your own: two formulas, growth tensor and rate, give the step and its exact tangent.
///
///     struct Isotropic {                     // one growth variable, g
///       double limit() const { return 1.5; }  // where growth ends
///       template <class T>
///       Mat3<T> growth_tensor(const T& g, const Vec3<T>& n0) const {
///         return pow(g, 1. / 3) * Mat3<T>::Identity();
///       }
///       template <class T>
///       T rate(const T& g, const Mat3<T>& Fe, const Vec3<T>& n0) const;  // dg/dt [1/time]
///     };
///     auto step = update(Isotropic(), NeoHookean<>(), F, n0, g_n, dt);
///     step.g, step.P, step.dP_dF;
///
/// With F = F_e F_g, F_g = F_g(g) (eqs 1, 2) and the elasticity of eq. 3, counted per reference volume:
///
///   R(g) = g - g_n - dt rate(g, F_e, n0) = 0                 backward Euler
///   dg/dF = -(dR/dF) / (dR/dg),   dP/dF = dP/dF|g + dP/dg dg/dF
///
/// All derivatives are complex steps, exact to rounding. This is the way to try a law out; one that is to be
/// fast gets a closed form, as kernel.hpp is for growth along the fibre. CONTRIBUTING.md has a worked
/// example.
#ifndef MYOGROWTH_MORE_GROWTH_LAW_HPP
#define MYOGROWTH_MORE_GROWTH_LAW_HPP

#include "../elastic/neo_hookean.hpp"
#include "../kernel.hpp"

namespace myogrowth {

/// Result of a step of a growth law.
struct LawUpdate {
  UpdateStatus status;  ///< ok; or inverted, not_finite or not_converged: then g is g_n and all else NaN
  double g;             ///< growth variable at the end of the step
  Mat3<double> dg_dF;   ///< its derivative, that of this discrete step
  Mat3<double> P;       ///< first Piola-Kirchhoff stress [stress]
  Mat9<double> dP_dF;   ///< dP_iJ/dF_kL at (i + 3J, k + 3L) [stress]

  /// Whether there is a result.
  bool ok() const { return status == UpdateStatus::ok; }
};

namespace detail {

template <class Law, class T>
Mat3<T> elastic_part_of(const Law& law, const Mat3<T>& F, const Vec3<T>& n0, const T& g) {
  return F * law.growth_tensor(g, n0).inverse();
}

template <class Law, class T>
T law_residual(const Law& law, const Mat3<T>& F, const Vec3<T>& n0, const T& g, double g_n, double dt) {
  return g - g_n - dt * T(law.rate(g, elastic_part_of(law, F, n0, g), n0));
}

template <class Law, class T>
Mat3<T> law_stress(const Law& law, const NeoHookean<>& elasticity, const Mat3<T>& F, const Vec3<T>& n0,
                   const T& g) {
  const Vec6<T> tau = to_six(elasticity.kirchhoff(left_cauchy_green(elastic_part_of(law, F, n0, g))));
  Mat3<T> P;
  first_piola_from_kirchhoff(F.data(), tau.data(), P.data());
  return P;
}

}  // namespace detail

/// One step of length dt [time] to F (3x3) from g_n, with the unit fibre n0. dt <= 0 is an elastic step.
///
/// Law: as above; where it grows, its rate at fixed F falls with g and is zero or positive at limit(). Then
/// the step has one root in [g_n, limit()], and Newton's method, kept in that bracket, cannot miss it.
template <class Law>
LawUpdate update(const Law& law, const NeoHookean<>& elasticity, const Mat3<double>& F,
                 const Vec3<double>& n0, double g_n, double dt) {
  using ComplexNumber = ComplexOf<double>;
  constexpr double h = 1e-30, nan = std::numeric_limits<double>::quiet_NaN();
  const Mat3<ComplexNumber> F_c = F.cast<ComplexNumber>();
  const Vec3<ComplexNumber> n0_c = n0.cast<ComplexNumber>();
  LawUpdate u{UpdateStatus::ok, g_n, Mat3<double>::Zero(), Mat3<double>::Constant(nan),
              Mat9<double>::Constant(nan)};
  const auto fail = [&](UpdateStatus status) {
    return LawUpdate{status, g_n, Mat3<double>::Constant(nan), Mat3<double>::Constant(nan),
                     Mat9<double>::Constant(nan)};
  };
  const double J = determinant(F.data());
  if (!is_finite(J) || !is_finite(g_n) || !is_finite(dt)) return fail(UpdateStatus::not_finite);
  if (!(J > 0)) return fail(UpdateStatus::inverted);

  const auto residual = [&](double g) {
    return detail::law_residual(law, F_c, n0_c, ComplexNumber(g, h), g_n, dt);
  };
  double low = g_n, high = law.limit(), slope = 0;  // 0: does not follow F
  if (dt > 0 && low < high && residual(low).real() < 0) {
    if (residual(high).real() < 0) {
      u.g = high;
    } else {
      double g = low, step = high - low;
      const auto is_rounding = [](double x, double g_) {
        return std::abs(x) <= 4 * last_place<double>() * g_;
      };
      for (int i = 0; !is_rounding(step, g) && !is_rounding(high - low, g); ++i) {
        if (i == 200) return fail(UpdateStatus::not_converged);
        const ComplexNumber R = residual(g);
        (R.real() < 0 ? low : high) = g;
        double next = g - R.real() * h / R.imag();
        // (Not back to an end: where rounding decides, both would take turns.)
        if (!(next == g || (low < next && next < high))) next = (low + high) / 2;
        step = next - g;
        g = next;
      }
      // A rate that jumps to zero at the limit ends there.
      const bool ended = law.limit() - g <= 8 * last_place<double>() * g;
      u.g = ended ? law.limit() : g;
      slope = ended ? 0 : residual(g).imag() / h;
    }
  }

  for (int l = 0; l < 3; ++l) {
    for (int k = 0; k < 3; ++k) {
      Mat3<ComplexNumber> F_h = F_c;
      F_h(k, l) += ComplexNumber(0, h);
      ComplexNumber g(u.g);
      if (slope != 0) {
        u.dg_dF(k, l) = -detail::law_residual(law, F_h, n0_c, g, g_n, dt).imag() / h / slope;
        g += ComplexNumber(0, h * u.dg_dF(k, l));
      }
      const Mat3<ComplexNumber> P = detail::law_stress(law, elasticity, F_h, n0_c, g);
      for (int i = 0; i < 9; ++i) u.dP_dF(i, k + 3 * l) = P.data()[i].imag() / h;
      u.P = P.real();
    }
  }
  return are_finite(u.dP_dF.data(), 81) && are_finite(u.P.data(), 9) ? u : fail(UpdateStatus::not_finite);
}

}  // namespace myogrowth

#endif
