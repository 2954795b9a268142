/// @file
/// What every host's routine does around the law at one point: advice on the step, and the state to remember.
#ifndef MYOGROWTH_ABI_POINT_HPP
#define MYOGROWTH_ABI_POINT_HPP

#include <cmath>

#include <myogrowth/measures.hpp>

#include "faults.hpp"

namespace myogrowth {
namespace abi {

constexpr double cut_back = 0.25;  ///< factor on the time increment when a step cannot be taken

/// Lowers the factor on the time increment; a NaN there is replaced.
inline void lower(double& factor, double to) {
  if (!(factor <= to)) factor = to;
}

/// Why a point has no result: names the entry of F, or dt, if it is that, and its value.
inline void tell_why(UpdateStatus status, const double F[9], double dt, Text& text) {
  if (status == UpdateStatus::inverted) {
    const double det = determinant(F);
    if (det <= 0) {  // else it is 0 to rounding
      tell(text, "inverted: det F = %.9g: must be > 0.", det);
      return;
    }
  }
  if (status == UpdateStatus::not_finite) {
    for (int i = 0; i < 9; ++i) {
      if (is_finite(F[i])) continue;
      tell(text, "not finite: F%d%d = %.9g: must be finite.", i % 3 + 1, i / 3 + 1, F[i]);
      return;
    }
    if (is_finite(dt)) {
      tell(text, "not finite: a result is beyond the range of double.");
    } else {
      tell(text, "not finite: dt = %.9g: must be finite.", dt);
    }
    return;
  }
  tell(text, "%s.", abi::text(status));
}

/// The sarcomere number a step starts from; a STATEV that knows nothing yet starts with 1.
inline double number_at_start(const double* statev) { return statev[0] == 0 ? 1 : statev[0]; }

/// What a step starts from: fibre, sarcomere number, fibre stretch.
struct Start {
  double n0[3], G, lambda;
};

/// Takes it from PROPS and STATEV. bad_state or no_fibre, and the text, if an entry of STATEV is not allowed,
/// or neither has a fibre.
inline UpdateStatus find_start(const double* statev, int nstatev, const Properties& properties, Start& start,
                               Text& text) {
  if (find_state_fault(statev, nstatev, properties, text)) return UpdateStatus::bad_state;
  for (int i = 0; i < 3; ++i) start.n0[i] = properties.n0[i];
  if (find_fibre_fault(statev, nstatev, start.n0, text)) return UpdateStatus::no_fibre;
  start.G = number_at_start(statev);
  start.lambda = stretch_at_start(statev, nstatev);
  return UpdateStatus::ok;
}

/// The factor on the time increment at which the time error of G meets its tolerance, with some safety. Above
/// 1 it is leave to enlarge. Below 1 costs the increment, so a step that meets the tolerance has at least 1.
inline double advised_factor(const Properties& p, double G_n, double lambda_n, double lambda, double dtime) {
  const double safety = 0.9, least = 0.25, most = 2;
  const FibreGrowth<double>& m = p.material;
  const bool first_order = m.integration == TimeIntegration::backward_euler;
  const double error = first_order
                           ? time_error_of_backward_euler(m.growth, m.removal, G_n, lambda_n, lambda, dtime)
                           : time_error_of_midpoint_flow(m.growth, m.removal, G_n, lambda_n, lambda, dtime);
  // Both errors are of second order in the step. Where the error is so small that `most` is advised, it may
  // be 0.
  if (!(error > p.tolerance * (safety * safety / (most * most)))) return most;
  const double factor = safety * std::sqrt(p.tolerance / error);
  if (error <= p.tolerance && factor < 1) return 1;
  return factor < least ? least : factor;
}

/// Stress, and the tangent unless it is null, in the measure asked for: 0 Cauchy, 6 and 36; 1 first
/// Piola-Kirchhoff, 9 and 81; 2 second, 6 and 36. Layouts as in measures.hpp.
/// Point: what update_point of the material gives.
template <class Point>
void convert(int measure, const double F[9], const Point& u, double* stress, double* tangent) {
  double c[36];
  if (tangent && measure != 0) spatial_modulus(u, c);
  if (measure == 0) {
    cauchy_from_kirchhoff(u.J, u.tau, stress);
    if (tangent) spatial_modulus(u, tangent, 1 / u.J);
  } else if (measure == 1) {
    first_piola_from_kirchhoff(F, u.tau, stress);
    if (tangent) dP_dF_from_jaumann(F, u.tau, c, tangent);
  } else {
    second_piola_from_kirchhoff(F, u.tau, stress);
    if (tangent) dS_dE_from_jaumann(F, u.tau, c, tangent);
  }
}

/// F[9], or the identity where all is zero, as in hosts without NLGEOM.
inline const double* or_identity(const double F[9]) {
  static constexpr double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int i = 0; i < 9; ++i) {
    if (F[i] != 0) return F;
  }
  return identity;
}

constexpr int n_kept = fibre_entry + 3;  ///< entries of STATEV that a step leaves, but for the thickness

/// These entries of STATEV at the end of a step.
inline void state_of(const PointUpdate<double>& u, double* state) {
  const double scalars[fibre_entry] = {u.G, u.lambda_e, u.lambda, u.J, u.Je};
  for (int i = 0; i < fibre_entry; ++i) state[i] = scalars[i];
  for (int i = 0; i < 3; ++i) state[fibre_entry + i] = u.n0[i];
}

/// How many of them a STATEV of that length keeps.
inline int kept_entries(int nstatev) {
  return keeps_fibre(nstatev) ? n_kept : nstatev < fibre_entry ? nstatev : fibre_entry;
}

/// Writes them as far as there is room.
inline void write_state(const PointUpdate<double>& u, double* statev, int nstatev) {
  if (keeps_fibre(nstatev)) return state_of(u, statev);
  double state[n_kept];
  state_of(u, state);
  for (int i = 0; i < kept_entries(nstatev); ++i) statev[i] = state[i];
}

}  // namespace abi
}  // namespace myogrowth

#endif
