// With ROOM=36 it must not compile: dP/dF has 81 components.
#include <myogrowth/many/views.hpp>

using namespace myogrowth;
using namespace myogrowth::batch;

UpdateStatus update(const double* F, const double* n0, const double* dt, double* G, double* P,
                    double* dP_dF) {
  return update_one<Tangent::full, Measure::first_piola>(FibreGrowth<double>(), 0,
                                                         Input{aos<9>(F), shared(n0), aos<1>(G), shared(dt)},
                                                         Output{aos<9>(P), aos<1>(G), aosoa<ROOM>(dP_dF)});
}
