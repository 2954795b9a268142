// A host of the UMAT: all its 37 arguments, filled as Abaqus/Standard fills them.
#ifndef MYOGROWTH_TESTS_UMAT_HOST_HPP
#define MYOGROWTH_TESTS_UMAT_HOST_HPP

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "../../abi/abaqus.h"

namespace host {

constexpr double untouched = -777;
constexpr int of_family = -1000;  ///< NDI, NSHR: as NTENS has them

/// One call's arguments and what came back. What the UMAT promises not to read is not there to be read.
struct Call {
  std::vector<double> props = {16, 4, 0.5, 2, 1.1, 1.01};
  std::vector<double> statev = std::vector<double>(8, 0.0);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  double dtime = 0.1, pnewdt = 1;
  int ntens = 6, ndi = of_family, nshr = of_family;
  double predef = 0, dpred = 0;  // field variable 1, and its increment
  double J_hat = 1;              // STRESS(NTENS+1) of a mixed element

  Eigen::Matrix<double, 6, 1> stress = Eigen::Matrix<double, 6, 1>::Constant(untouched);
  Eigen::Matrix<double, 6, 6> ddsdde = Eigen::Matrix<double, 6, 6>::Constant(untouched);
  double sse = untouched, spd = untouched, scd = untouched, rpl = untouched, drpldt = untouched;
  Eigen::Matrix<double, 6, 1> ddsddt = stress, drplde = stress;
  double K = untouched, dK_dJ = untouched;  // STRESS(NTENS+2) and STRESS(NTENS+3) of a mixed element

  bool is_hybrid() const { return props.size() > 17 && props[17] == 1; }

  int n_shear() const { return nshr != of_family ? nshr : ntens == 6 ? 3 : 1; }
  int n_direct() const { return ndi != of_family ? ndi : ntens - n_shear(); }

  Call& run(Umat* umat = MYOGROWTH_FORTRAN(umat, UMAT)) {
    const int n_direct = this->n_direct(), n_shear = this->n_shear(), kstep = 1, kinc = 1;
    const int nprops = static_cast<int>(props.size()), nstatv = static_cast<int>(statev.size());
    const double six[6] = {}, time[2] = {}, temp = 0, celent = 1;
    const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
    const bool longer = is_hybrid() && ntens >= 0 && ntens <= 6;  // STRESS is, by three entries
    double given[9] = {stress[0], stress[1], stress[2], stress[3], stress[4], stress[5]};
    double* extra = given + (longer ? ntens : 6);
    if (longer) extra[0] = J_hat, extra[1] = K, extra[2] = dK_dJ;
    umat(longer ? given : stress.data(), statev.data(), ddsdde.data(), &sse, &spd, &scd, &rpl, ddsddt.data(),
         drplde.data(), &drpldt, six, six, time, &dtime, &temp, &temp, &predef, &dpred, nullptr, &n_direct,
         &n_shear, &ntens, &nstatv, props.data(), &nprops, nullptr, one.data(), &pnewdt, &celent, one.data(),
         F.data(), nullptr, nullptr, nullptr, nullptr, &kstep, &kinc);
    if (longer) {
      for (int i = 0; i < ntens; ++i) stress[i] = given[i];
      J_hat = extra[0], K = extra[1], dK_dJ = extra[2];
    }
    return *this;
  }
};

}  // namespace host

#endif
