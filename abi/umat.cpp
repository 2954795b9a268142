// Abaqus/Standard UMAT of stretch-driven muscle growth: unpack, update, pack, report. docs/manual.md has
// PROPS and STATEV.
//
// Nothing is remembered between calls, nothing throws, and CMNAME (whose hidden length some hosts leave out),
// NOEL, NPT, COORDS, LAYER and KSPT, which many hosts do not fill, are never read.
#include <cstdio>
#include <limits>
#include <myogrowth/kernel.hpp>
#include <myogrowth/left_stretch.hpp>
#include <myogrowth/stress_states.hpp>

#include "properties.hpp"

// Abaqus's message and exit utilities. No other host has them, so they are looked for, not linked.
extern "C" {
__attribute__((weak)) void stdb_abqerr_(const int* lop, const char* text, const int* ints,
                                        const double* reals, const char* chars, std::size_t text_length,
                                        std::size_t chars_length);
__attribute__((weak)) void xit_();
}

namespace {

using namespace myogrowth;

constexpr double cut_back = 0.25;  // factor on the time increment when a step cannot be taken

// STRESS, DDSDDE and PNEWDT of a call that gave no result: no host can go on with them unawares.
void refuse(double* stress, double* ddsdde, int ntens, double& pnewdt) {
  if (ntens < 0) ntens = 0;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < ntens; ++i) stress[i] = nan;
  for (int i = 0; i < ntens * ntens; ++i) ddsdde[i] = nan;
  if (!(pnewdt <= cut_back)) pnewdt = cut_back;
}

void report(const char* text) {
  const int error = -2, no_int = 0;
  const double no_real = 0;
  char line[512];
  const int written = std::snprintf(line, sizeof line, "myogrowth UMAT: %s", text);
  const int length = written < static_cast<int>(sizeof line) ? written : static_cast<int>(sizeof line) - 1;
  if (stdb_abqerr_) {
    stdb_abqerr_(&error, line, &no_int, &no_real, "        ", static_cast<std::size_t>(length), 8);
  } else {
    std::fprintf(stderr, "%s\n", line);
  }
  if (xit_) xit_();
}

// The fibre is kept whole or not at all.
bool keeps_fibre(int nstatv) { return nstatv >= abi::fibre_entry + 3; }

// Writes what is wrong with the arguments into text; false if nothing is.
bool find_fault(int ntens, int nstatv, const double* statev, const double* props, int nprops,
                abi::Properties& properties, char (&text)[400]) {
  const auto fault = [&text](auto... arguments) {
    std::snprintf(text, sizeof text, arguments...);
    return true;
  };
  if (ntens != 6 && ntens != 4 && ntens != 3) {
    return fault(
        "NTENS = %d: must be 6 (solids), 4 (plane strain, axisymmetric) or 3 (plane stress, membranes, "
        "shells).",
        ntens);
  }
  if (nprops < abi::n_props_required) {
    return fault("NPROPS = %d: at least %d constants are needed: c1, c2, tau, gamma, G_max, lambda_crit.",
                 nprops, abi::n_props_required);
  }
  if (nstatv < abi::n_statev_required) {
    return fault("NSTATV = %d: at least %d is needed, to remember G (*DEPVAR; %d keeps all).", nstatv,
                 abi::n_statev_required, abi::n_statev);
  }
  const int bad = abi::read(props, nprops, properties);
  if (bad >= abi::n_props) {
    return fault("PROPS(%d) = %.9g: this version knows %d constants; further ones must be 0.", bad + 1,
                 props[bad], abi::n_props);
  }
  if (bad >= 0) {
    const abi::Property& p = abi::property(bad);
    return fault("PROPS(%d) = %.9g: %s, %s, must be finite and %s.", bad + 1, props[bad], p.symbol, p.meaning,
                 abi::text(p.allowed));
  }
  if (!is_finite(statev[0]) || statev[0] < 0) {
    return fault(
        "STATEV(1) = %.9g on entry: G, the sarcomere number, must be > 0, or 0 where nothing is known yet.",
        statev[0]);
  }
  if (keeps_fibre(nstatv)) {
    for (int i = abi::fibre_entry; i < abi::fibre_entry + 3; ++i) {
      if (!is_finite(statev[i])) {
        return fault("STATEV(%d) = %.9g on entry: the fibre direction must be finite.", i + 1, statev[i]);
      }
    }
    const double* n0 = statev + abi::fibre_entry;
    for (int i = 0; i < 3 && (n0[0] != 0 || n0[1] != 0 || n0[2] != 0); ++i) properties.n0[i] = n0[i];
  }
  if (properties.n0[0] == 0 && properties.n0[1] == 0 && properties.n0[2] == 0) {
    return fault(
        "%s",
        "PROPS(7:9) = 0, 0, 0: n0, the fibre direction, must have a length > 0 (or give it in STATEV(6:8)).");
  }
  return false;
}

void umat(double* stress, double* statev, double* ddsdde, double* sse, double* rpl, double* ddsddt,
          double* drplde, double* drpldt, double dtime, int ntens, int nstatv, const double* props,
          int nprops, double* pnewdt, const double* dfgrd1) {
  *rpl = *drpldt = 0;
  for (int i = 0; i < ntens; ++i) ddsddt[i] = drplde[i] = 0;

  abi::Properties properties;
  char text[400];
  if (find_fault(ntens, nstatv, statev, props, nprops, properties, text)) {
    refuse(stress, ddsdde, ntens, *pnewdt);
    report(text);
    return;
  }

  // Of DFGRD1, what the element type has: F_33 is not given in plane stress, and all is zero in some hosts
  // without NLGEOM.
  const bool plane_stress_state = ntens == 3;
  double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const bool given[9] = {true, true, ntens == 6, true, true, ntens == 6, ntens == 6, ntens == 6, ntens != 3};
  bool all_zero = true;
  for (int i = 0; i < 9; ++i) all_zero = all_zero && (!given[i] || dfgrd1[i] == 0);
  for (int i = 0; i < 9; ++i) F[i] = given[i] && !all_zero ? dfgrd1[i] : F[i];
  if (properties.local_basis) left_stretch(F, F);  // an F that has none is refused below

  PointUpdate<double> u;
  const double G_n = statev[0] == 0 ? 1 : statev[0];
  double c[36], thickness = nstatv > abi::thickness_entry ? statev[abi::thickness_entry] : 0;
  if (plane_stress_state) {
    const double in_plane[4] = {F[0], F[1], F[3], F[4]};
    plane_stress(properties.material, in_plane, properties.n0, G_n, dtime, thickness, u, c);
  } else if (update_point(properties.material, F, properties.n0, G_n, dtime, u) == Status::ok) {
    spatial_modulus(u, c);
  }
  if (u.status != Status::ok) {
    refuse(stress, ddsdde, ntens, *pnewdt);
    return;
  }

  const int component[6] = {0, 1, plane_stress_state ? 3 : 2, 3, 4, 5};  // of the law, for each of the host's
  const int modulus_size = plane_stress_state ? 3 : 6;
  const double per_J = 1 / u.J;
  for (int j = 0; j < ntens; ++j) {
    stress[j] = u.tau[component[j]] * per_J;
    for (int i = 0; i < ntens; ++i) ddsdde[i + ntens * j] = c[i + modulus_size * j] * per_J;
  }
  *sse = u.psi;
  const double scalars[5] = {u.G, u.lambda_e, u.lambda, u.J, u.Je};
  for (int i = 0; i < 5 && i < nstatv; ++i) statev[i] = scalars[i];
  for (int i = 0; i < 3 && keeps_fibre(nstatv); ++i) statev[abi::fibre_entry + i] = u.n0[i];
  if (plane_stress_state && nstatv > abi::thickness_entry) statev[abi::thickness_entry] = thickness;
}

}  // namespace

// The arguments of Abaqus/Standard's UMAT, in its order; see the Abaqus User Subroutines Guide.
#define MYOGROWTH_UMAT_ARGUMENTS                                                                        \
  double *stress, double *statev, double *ddsdde, double *sse, double * /*spd*/, double * /*scd*/,      \
      double *rpl, double *ddsddt, double *drplde, double *drpldt, const double * /*stran*/,            \
      const double * /*dstran*/, const double * /*time*/, const double *dtime, const double * /*temp*/, \
      const double * /*dtemp*/, const double * /*predef*/, const double * /*dpred*/,                    \
      const char * /*cmname*/, const int * /*ndi*/, const int * /*nshr*/, const int *ntens,             \
      const int *nstatv, const double *props, const int *nprops, const double * /*coords*/,             \
      const double * /*drot*/, double *pnewdt, const double * /*celent*/, const double * /*dfgrd0*/,    \
      const double *dfgrd1, const int * /*noel*/, const int * /*npt*/, const int * /*layer*/,           \
      const int * /*kspt*/, const int * /*kstep*/, const int * /*kinc*/
#define MYOGROWTH_UMAT_CALL                                                                               \
  umat(stress, statev, ddsdde, sse, rpl, ddsddt, drplde, drpldt, *dtime, *ntens, *nstatv, props, *nprops, \
       pnewdt, dfgrd1)

extern "C" {
/// What Abaqus and its kin call.
void umat_(MYOGROWTH_UMAT_ARGUMENTS) { MYOGROWTH_UMAT_CALL; }
/// The same routine under a name of its own, for a user's UMAT that dispatches between materials.
void myogrowth_umat_(MYOGROWTH_UMAT_ARGUMENTS) { MYOGROWTH_UMAT_CALL; }
}
