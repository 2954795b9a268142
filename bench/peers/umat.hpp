// The UMAT around a peer in C++, which includes this and writes `update`.
#ifndef MYOGROWTH_BENCH_PEERS_UMAT_HPP
#define MYOGROWTH_BENCH_PEERS_UMAT_HPP

#include "../../abi/abaqus.h"

/// Stress[6] (Cauchy), ddsdde[36], energy and STATEV at the end of a step to F[9].
static void update(const double* props, double dtime, const double* F, double* statev, double* stress,
                   double* ddsdde, double& sse);

extern "C" void umat_(double* stress, double* statev, double* ddsdde, double* sse, double*, double*, double*,
                      double*, double*, double*, const double*, const double*, const double*,
                      const double* dtime, const double*, const double*, const double*, const double*,
                      const char*, const int*, const int*, const int*, const int*, const double* props,
                      const int*, const double*, const double*, double*, const double*, const double*,
                      const double* dfgrd1, const int*, const int*, const int*, const int*, const int*,
                      const int*) {
  update(props, *dtime, dfgrd1, statev, stress, ddsdde, *sse);
}

#endif
