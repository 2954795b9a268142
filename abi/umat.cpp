// Abaqus/Standard UMAT of stretch-driven muscle growth: unpack, update, pack, report. docs/manual.md has
// PROPS and STATEV.
//
// Nothing is remembered between calls (save, where dump.hpp is on, how many it has written), nothing throws,
// and CMNAME (whose hidden length some hosts leave out), NOEL, NPT, COORDS, LAYER and KSPT, which many hosts
// do not fill, are never read.
#include <algorithm>
#include <cmath>
#include <limits>
#include <myogrowth/kernel.hpp>
#include <myogrowth/left_stretch.hpp>
#include <myogrowth/mixed_volume.hpp>
#include <myogrowth/stress_states.hpp>

#include "dump.hpp"
#include "fortran_name.hpp"
#include "point.hpp"

// Abaqus's message and exit utilities.
extern "C" {
MYOGROWTH_IF_THERE myogrowth::abi::HostMessage MYOGROWTH_FORTRAN(stdb_abqerr, STDB_ABQERR);
MYOGROWTH_IF_THERE myogrowth::abi::HostExit MYOGROWTH_FORTRAN(xit, XIT);
}

namespace {

using namespace myogrowth;

// What a call that gave no result returns: NaN, so that a host that ignores PNEWDT cannot continue silently.
// K_and_dK_dJ: of a mixed element, else null.
void refuse(double* stress, double* ddsdde, double* sse, int ntens, double* K_and_dK_dJ, double& pnewdt) {
  if (ntens < 0) ntens = 0;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  *sse = nan;
  for (int i = 0; i < 2 && K_and_dK_dJ; ++i) K_and_dK_dJ[i] = nan;
  for (int i = 0; i < ntens; ++i) stress[i] = nan;
  for (int i = 0; i < ntens * ntens; ++i) ddsdde[i] = nan;
  if (!(pnewdt <= abi::cut_back)) pnewdt = abi::cut_back;
}

// True, and the text, if the arguments are not as they must be.
bool find_fault(int ntens, int ndi, int nshr, int nstatv, const double* statev, const double* props,
                int nprops, abi::Properties& properties, abi::Text& text) {
  if (abi::find_family_fault(ntens, ndi, nshr, text)) return true;
  return abi::find_props_fault(props, nprops, properties, text) ||
         (ntens == 3 && abi::find_hybrid_fault("plane stress", properties, text)) ||
         abi::find_room_fault("NSTATV", nstatv, text) ||
         abi::find_stretch_fault("NSTATV", nstatv, properties, text) ||
         abi::find_state_fault(statev, nstatv, properties, text) ||
         abi::find_fibre_fault(statev, nstatv, properties.n0, text);
}

// Of DFGRD1, what the element type has: F_33 is not given in plane stress, and all is zero in some hosts
// without NLGEOM.
MYOGROWTH_APART void take_deformation(const double* dfgrd1, int ntens, double F[9]) {
  const bool solid = ntens == 6;
  const bool given[9] = {true, true, solid, true, true, solid, solid, solid, ntens != 3};
  for (int i = 0; i < 9; ++i) F[i] = given[i] ? dfgrd1[i] : i == 8 ? 1 : 0;
  if (F[0] != 0) return;
  bool all_zero = true;
  for (int i = 0; i < 9; ++i) all_zero = all_zero && (!given[i] || F[i] == 0);
  for (int i = 0; i < 9 && all_zero; ++i) F[i] = i % 4 == 0 ? 1 : 0;
}

// The first n components of tau and of c, whose columns are `rows` long, times 1/J. False if one is not
// finite.
template <int n>
bool pack(const double* tau, const double* c, int rows, double per_J, double* stress, double* ddsdde) {
  for (int j = 0; j < n; ++j) {
    stress[j] = tau[j] * per_J;
    for (int i = 0; i < n; ++i) ddsdde[i + n * j] = c[i + rows * j] * per_J;
  }
  return are_finite(stress, n) && are_finite(ddsdde, n * n);
}

// Whether stress and tangent of a solid are finite: by their sum, which costs less than to look at each.
bool are_finite_in_sum(const double* stress, const double* ddsdde) {
  const auto sum = [](const double* x) { return (x[0] + x[1] + x[2]) + (x[3] + x[4] + x[5]); };
  double all = sum(stress);
  for (int j = 0; j < 6; ++j) all += sum(ddsdde + 6 * j);
  return is_finite(all) || (are_finite(stress, 6) && are_finite(ddsdde, 36));
}

void update_state(double* stress, double* statev, double* ddsdde, double* sse, double* rpl, double* ddsddt,
                  double* drplde, double* drpldt, double dtime, int ntens, int ndi, int nshr, int nstatv,
                  const double* props, int nprops, double* pnewdt, const double* dfgrd1) {
  *rpl = *drpldt = 0;
  if (ntens == 6) {
    std::fill_n(ddsddt, 6, 0.0);
    std::fill_n(drplde, 6, 0.0);
  } else {
    for (int i = 0; i < ntens; ++i) ddsddt[i] = drplde[i] = 0;
  }

  double* J_hat = nullptr;                    // STRESS(NTENS+1), in a mixed element
  const auto fail = [&](const char* fault) {  // STATEV is still as it came in, wherever this is called
    abi::dump({ntens, ndi, nshr, nstatv, nprops, statev, props, dfgrd1, dtime, *pnewdt, J_hat}, fault);
    refuse(stress, ddsdde, sse, ntens, J_hat ? J_hat + 1 : nullptr, *pnewdt);
  };

  abi::Properties properties;
  abi::Text text;
  if (find_fault(ntens, ndi, nshr, nstatv, statev, props, nprops, properties, text)) {
    fail(text);
    abi::report("UMAT", text, MYOGROWTH_FORTRAN(stdb_abqerr, STDB_ABQERR), MYOGROWTH_FORTRAN(xit, XIT));
    return;
  }

  if (properties.hybrid) J_hat = stress + ntens;

  double taken[9];
  const double* F = dfgrd1;
  if (ntens != 6 || F[0] == 0 || properties.local_basis) {
    take_deformation(dfgrd1, ntens, taken);
    F = taken;
    if (properties.local_basis && !left_stretch(taken, taken)) {  // det F <= 0, or not finite
      fail("inverted or not finite: F must be finite and det F > 0");
      return;
    }
  }

  PointUpdate<double> u;
  const double G_n = abi::number_at_start(statev), lambda_n = abi::stretch_at_start(statev, nstatv);
  double thickness = nstatv > abi::thickness_entry ? statev[abi::thickness_entry] : 0;
  double c[36];
  bool finite = true;
  if (ntens == 3) {
    const double in_plane[4] = {F[0], F[1], F[3], F[4]};
    plane_stress(properties.material, in_plane, properties.n0, G_n, lambda_n, dtime, thickness, u, c);
    if (u.status == UpdateStatus::ok) {
      const double plane[3] = {u.tau[0], u.tau[1], u.tau[3]};
      finite = pack<3>(plane, c, 3, 1 / u.J, stress, ddsdde);
    }
  } else if (J_hat) {
    // STRESS goes on: after J^, which is given, K = J d2U/dJ^2 and dK/dJ^ to be returned.
    MixedVolume<double> volume{1, std::numeric_limits<double>::quiet_NaN()};
    update_mixed(properties.material, F, properties.n0, G_n, lambda_n, dtime, *J_hat, u, c, volume);
    double* extra = J_hat + 1;
    extra[0] = volume.K;
    extra[1] = mixed_dK_dJ(properties.material, F, properties.n0, G_n, lambda_n, dtime, *J_hat);
    finite = (ntens == 6 ? pack<6>(u.tau, c, 6, 1 / volume.J, stress, ddsdde)
                         : pack<4>(u.tau, c, 6, 1 / volume.J, stress, ddsdde)) &&
             are_finite(extra, 2);
  } else if (update_point(properties.material, F, properties.n0, G_n, lambda_n, dtime, u) ==
             UpdateStatus::ok) {
    const double per_J = 1 / u.J;
    if (ntens == 6) {
      spatial_modulus(u, ddsdde, per_J);
      for (int i = 0; i < 6; ++i) stress[i] = u.tau[i] * per_J;
      finite = are_finite_in_sum(stress, ddsdde);
    } else {
      spatial_modulus(u, c, per_J);
      for (int i = 0; i < 6; ++i) u.tau[i] *= per_J;
      finite = pack<4>(u.tau, c, 6, 1, stress, ddsdde);
    }
  }
  if (u.status != UpdateStatus::ok || !finite) {
    fail(abi::text(u.status != UpdateStatus::ok ? u.status : UpdateStatus::not_finite));
    return;
  }
  if (properties.tolerance > 0) {
    const double advice = abi::advised_factor(properties, G_n, lambda_n, u.lambda, dtime);
    if (!(*pnewdt <= advice)) *pnewdt = advice;
  }
  *sse = u.psi;
  abi::write_state(u, statev, nstatv);
  if (ntens == 3 && nstatv > abi::thickness_entry) statev[abi::thickness_entry] = thickness;
}

}  // namespace

// The arguments of Abaqus/Standard's UMAT, in its order; see the Abaqus User Subroutines Guide.
#define MYOGROWTH_UMAT_ARGUMENTS                                                                        \
  double *stress, double *statev, double *ddsdde, double *sse, double * /*spd*/, double * /*scd*/,      \
      double *rpl, double *ddsddt, double *drplde, double *drpldt, const double * /*stran*/,            \
      const double * /*dstran*/, const double * /*time*/, const double *dtime, const double * /*temp*/, \
      const double * /*dtemp*/, const double * /*predef*/, const double * /*dpred*/,                    \
      const char * /*cmname*/, const int *ndi, const int *nshr, const int *ntens, const int *nstatv,    \
      const double *props, const int *nprops, const double * /*coords*/, const double * /*drot*/,       \
      double *pnewdt, const double * /*celent*/, const double * /*dfgrd0*/, const double *dfgrd1,       \
      const int * /*noel*/, const int * /*npt*/, const int * /*layer*/, const int * /*kspt*/,           \
      const int * /*kstep*/, const int * /*kinc*/
#define MYOGROWTH_UMAT_CALL                                                                           \
  update_state(stress, statev, ddsdde, sse, rpl, ddsddt, drplde, drpldt, *dtime, *ntens, *ndi, *nshr, \
               *nstatv, props, *nprops, pnewdt, dfgrd1)

extern "C" {
/// What Abaqus and its kin call.
void MYOGROWTH_FORTRAN(umat, UMAT)(MYOGROWTH_UMAT_ARGUMENTS) { MYOGROWTH_UMAT_CALL; }
/// The same routine under a name of its own, for a user's UMAT that dispatches between materials.
void MYOGROWTH_FORTRAN(myogrowth_umat, MYOGROWTH_UMAT)(MYOGROWTH_UMAT_ARGUMENTS) { MYOGROWTH_UMAT_CALL; }
#if defined(MYOGROWTH_SINGLE_FILE) && !defined(MYOGROWTH_INSIDE_ABAQUS)
/// For hosts that look for the name without an underscore, as Abaqus 2024 does in C++ sources.
void umat(MYOGROWTH_UMAT_ARGUMENTS) { MYOGROWTH_UMAT_CALL; }
#endif
}
