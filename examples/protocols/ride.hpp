/// @file
/// The fastest admissible protocol in closed form, for ./run protocol --design and for the page of web/.
/// docs/studies.md has the proof.
#ifndef MYOGROWTH_EXAMPLES_RIDE_HPP
#define MYOGROWTH_EXAMPLES_RIDE_HPP

#include <cmath>
#include <limits>
#include <myogrowth/growth_rate.hpp>

namespace study {

/// With lambda_e held at its limit m the right side of eq. 4 is a function of G only. In x = (G_max -
/// G)/(G_max - 1) it reads dx/dt = -s x^gamma, s = (m - lambda_crit)/(tau (G_max - 1)), x(0) = 1.
struct Ride {
  const myogrowth::GrowthRate<>& growth;
  double limit;

  double s() const { return (limit - growth.lambda_crit) / (growth.tau * (growth.G_max - 1)); }
  /// G on day t: 1 + (G_max - 1) (1 - x), so that nothing cancels where G_max is large.
  double G(double t) const {
    const double g = growth.gamma - 1, st = s() * t;
    double log_x;
    if (std::abs(g) < 1e-9) {
      log_x = -st;
    } else {
      // For gamma < 1 growth ends where x reaches 0.
      log_x = g * st > -1 ? -std::log1p(g * st) / g : -std::numeric_limits<double>::infinity();
    }
    return 1 - (growth.G_max - 1) * std::expm1(log_x);
  }
  /// Day on which the stretch is reached; infinite: never.
  double day(double stretch) const {
    if (stretch <= limit) return 0;
    const double less = (stretch / limit - 1) / (growth.G_max - 1), g = growth.gamma - 1;  // 1 - x
    if (less > 1 || (less == 1 && g >= 0)) return std::numeric_limits<double>::infinity();
    const double log_x = std::log1p(-less);
    return std::abs(g) < 1e-9 ? -log_x / s() : std::expm1(-g * log_x) / (g * s());
  }
};

}  // namespace study

#endif
