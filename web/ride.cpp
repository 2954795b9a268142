// The fastest admissible protocol of examples/protocols/ride.hpp, for WebAssembly: the closed form stands
// once.
#include "../examples/protocols/ride.hpp"

namespace {

// growth: tau, gamma, G_max, lambda_crit.
myogrowth::GrowthRate<> growth_of(const double* growth) {
  return {growth[0], growth[1], growth[2], growth[3]};
}

}  // namespace

extern "C" {

/// G on day t of the ride at this limit of lambda_e.
double ride_G(const double* growth, double limit, double t) {
  const myogrowth::GrowthRate<> rate = growth_of(growth);
  return study::Ride{rate, limit}.G(t);
}

/// Day on which the ride reaches the stretch; infinite: never.
double ride_day(const double* growth, double limit, double stretch) {
  const myogrowth::GrowthRate<> rate = growth_of(growth);
  return study::Ride{rate, limit}.day(stretch);
}
}
