/// @file
/// What every host's routine does around the law at one point: advice on the step, and the state to remember.
#ifndef MYOGROWTH_ABI_POINT_HPP
#define MYOGROWTH_ABI_POINT_HPP

#include <cmath>

#include "faults.hpp"

namespace myogrowth {
namespace abi {

constexpr double cut_back = 0.25;  ///< factor on the time increment when a step cannot be taken

/// The sarcomere number a step starts from; a STATEV that knows nothing yet starts with 1.
inline double number_at_start(const double* statev) { return statev[0] == 0 ? 1 : statev[0]; }

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

/// STATEV(1:8) at the end of a step, as far as there is room.
inline void write_state(const PointUpdate<double>& u, double* statev, int nstatev) {
  const double scalars[5] = {u.G, u.lambda_e, u.lambda, u.J, u.Je};
  const bool all = keeps_fibre(nstatev);
  for (int i = 0; i < 5 && (all || i < nstatev); ++i) statev[i] = scalars[i];
  for (int i = 0; i < 3 && all; ++i) statev[fibre_entry + i] = u.n0[i];
}

}  // namespace abi
}  // namespace myogrowth

#endif
