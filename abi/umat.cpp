// Abaqus/Standard UMAT of stretch-driven muscle growth: check, update, write. abaqus.h has the arguments,
// docs/manual.md PROPS and STATEV.
//
// Nothing is remembered between calls (except, where dump.hpp is on, how many it has written), nothing
// throws, and what many hosts do not fill is never read: CMNAME, whose hidden length some hosts leave out,
// NOEL, NPT, COORDS, LAYER and KSPT.
#include <cmath>
#include <myogrowth/more/left_stretch.hpp>

#include "abaqus.h"
#include "dump.hpp"
#include "elastic_laws.hpp"
#include "element_family.hpp"

// Abaqus's message and exit utilities.
extern "C" {
MYOGROWTH_IF_THERE HostMessage MYOGROWTH_FORTRAN(stdb_abqerr, STDB_ABQERR);
MYOGROWTH_IF_THERE HostExit MYOGROWTH_FORTRAN(xit, XIT);
}

namespace {

using namespace myogrowth;

// Elmer's axisymmetric elements have their shear in the 1-3 plane, for which NTENS = 4 has no component.
// (What rounding leaves there is no shear.)
bool find_order_fault(int ntens, const double* F, abi::Text& text) {
  const double rounding = 1e-12 * std::fabs(F[0]);
  if (ntens != 4 || F[3] != 0 || F[1] != 0) return false;
  if (!(std::fabs(F[6]) > rounding) && !(std::fabs(F[2]) > rounding)) return false;
  return abi::tell(
      text,
      "DFGRD1(1,3) = %.9g, DFGRD1(3,1) = %.9g, and no shear in the 1-2 plane: with NTENS = 4 the "
      "order must be r, z, theta, not r, theta, z as in Elmer's axisymmetric elements.",
      F[6], F[2]);
}

// find_props: reads PROPS.
template <class FindPropsFault>
bool find_fault(int ntens, int ndi, int nshr, int nstatv, const double* statev, const double* dfgrd1,
                abi::Properties& properties, abi::Start& start, abi::Text& text,
                const FindPropsFault& find_props_fault) {
  return abi::find_family_fault(ntens, ndi, nshr, text) || find_order_fault(ntens, dfgrd1, text) ||
         find_props_fault() || (ntens == 3 && abi::find_hybrid_fault("plane stress", properties, text)) ||
         abi::find_room_fault("NSTATV", nstatv, text) ||
         abi::find_stretch_fault("NSTATV", nstatv, properties, text) ||
         abi::find_start(statev, nstatv, properties, start, text) != UpdateStatus::ok;
}

// The results of a call that has none: NaN, so that a host that ignores PNEWDT cannot continue silently.
// NTENS may be what no array has. J_hat: STRESS(NTENS+1:NTENS+3) of a mixed element, else null.
void refuse(int ntens, double* stress, double* ddsdde, double* sse, double* J_hat, double* pnewdt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const int n = ntens < 0 ? 0 : ntens < 6 ? ntens : 6;
  for (int i = 0; i < n; ++i) stress[i] = nan;
  for (int i = 0; i < n * n; ++i) ddsdde[i] = nan;
  if (J_hat) J_hat[1] = J_hat[2] = nan;
  *sse = nan;
  abi::lower(*pnewdt, abi::cut_back);
}

// The arguments of a call, named as in abaqus.h.
struct Call {
  double *stress, *statev, *ddsdde, *sse;
  const double *dtime, *predef, *dpred, *props, *dfgrd1;
  const int *ndi, *nshr, *ntens, *nstatv, *nprops;
  double* pnewdt;
};

// The end of a call that has no result. J_hat: as above.
MYOGROWTH_NOINLINE void fail(Call c, double* J_hat, const char* fault) {
  const bool reads_field = abi::reads_field(c.props, *c.nprops);
  abi::dump({*c.ntens, *c.ndi, *c.nshr, *c.nstatv, *c.nprops, c.statev, c.props, c.dfgrd1, *c.dtime,
             *c.pnewdt, J_hat, reads_field ? c.predef : nullptr, reads_field ? c.dpred : nullptr},
            fault);
  refuse(*c.ntens, c.stress, c.ddsdde, c.sse, J_hat, c.pnewdt);
}

// The step of a material, from PROPS and STATEV that have been checked. call(): the arguments, which are
// fetched only where they are needed.
template <class Point, class GetCall, class Material, class... Activation>
void update(const GetCall& call, const abi::Properties& properties, const abi::Start& start,
            const Material& material, const Activation&... a) {
  const int ntens = *call().ntens, nstatv = *call().nstatv;
  double *J_hat = properties.hybrid ? call().stress + ntens : nullptr, *stress = call().stress,
         *ddsdde = call().ddsdde;

  // The deformation gradient, in fixed axes or as the left stretch in a basis that turns with the material.
  double F[9];
  const bool as_given = ntens == 6 && call().dfgrd1[0] != 0 && !properties.local_basis;
  if (!as_given) abi::take_deformation(call().dfgrd1, ntens, F);
  if (properties.local_basis && !left_stretch(F, F)) {
    fail(call(), J_hat, "inverted or not finite: F must be finite and det F > 0");
    return;
  }

  // Update.
  const abi::Step<Material> step{material, as_given ? call().dfgrd1 : F, start, *call().dtime};
  const bool keeps_thickness = ntens == 3 && nstatv > abi::thickness_entry;
  double thickness = keeps_thickness ? call().statev[abi::thickness_entry] : 0;
  Point u;
  const UpdateStatus status = J_hat        ? update_mixed_element(step, ntens, J_hat, u, stress, ddsdde, a...)
                              : ntens == 6 ? update_solid(step, u, stress, ddsdde, a...)
                              : ntens == 4 ? update_plane_strain(step, u, stress, ddsdde, a...)
                                           : update_plane_stress(step, thickness, u, stress, ddsdde, a...);
  if (status != UpdateStatus::ok) {
    fail(call(), J_hat, abi::text(status));
    return;
  }

  // Write.
  *call().sse = u.psi;
  if (properties.tolerance > 0)
    abi::lower(*call().pnewdt,
               abi::advised_factor(properties, start.G, start.lambda, u.lambda, *call().dtime));
  abi::write_state(u, call().statev, nstatv);
  if (keeps_thickness) call().statev[abi::thickness_entry] = thickness;
}

// A call whose PROPS ask for an elastic law other than eq. 3. False, and the text, if something is not
// allowed.
MYOGROWTH_NOINLINE bool update_with_law(Call c, abi::Text& text) {
  abi::Properties properties;
  abi::Start start;
  abi::LawChoice choice{};
  const auto find_law_fault = [&] {
    return abi::find_law_fault(c.props, *c.nprops, true, properties, choice, text) ||
           (choice.by_field && abi::find_field_fault(*c.predef + *c.dpred, choice, text));
  };
  if (find_fault(*c.ntens, *c.ndi, *c.nshr, *c.nstatv, c.statev, c.dfgrd1, properties, start, text,
                 find_law_fault))
    return false;
  // (Not with_material: a second copy of eq. 3's code would keep the first from being inlined.)
  abi::with_other_law(properties.material, choice, [&](auto& u, const auto& material, double activation) {
    update<std::decay_t<decltype(u)>>([&] { return c; }, properties, start, material, activation);
    return UpdateStatus::ok;
  });
  return true;
}

}  // namespace

extern "C" {

/// What Abaqus and its kin call.
void MYOGROWTH_FORTRAN(umat, UMAT)(double* stress, double* statev, double* ddsdde, double* sse,
                                   double* /*spd*/, double* /*scd*/, double* rpl, double* ddsddt,
                                   double* drplde, double* drpldt, const double* /*stran*/,
                                   const double* /*dstran*/, const double* /*time*/, const double* dtime,
                                   const double* /*temp*/, const double* /*dtemp*/, const double* predef,
                                   const double* dpred, const char* /*cmname*/, const int* ndi,
                                   const int* nshr, const int* ntens, const int* nstatv, const double* props,
                                   const int* nprops, const double* /*coords*/, const double* /*drot*/,
                                   double* pnewdt, const double* /*celent*/, const double* /*dfgrd0*/,
                                   const double* dfgrd1, const int* /*noel*/, const int* /*npt*/,
                                   const int* /*layer*/, const int* /*kspt*/, const int* /*kstep*/,
                                   const int* /*kinc*/) {
  *rpl = *drpldt = 0;
  for (int i = 0, n = *ntens; i < n && i < 6; ++i) ddsddt[i] = drplde[i] = 0;

  // Check. STATEV is as it came in wherever there is no result.
  const auto call = [&] {
    return Call{stress, statev, ddsdde, sse,   dtime,  predef, dpred, props,
                dfgrd1, ndi,    nshr,   ntens, nstatv, nprops, pnewdt};
  };
  abi::Properties properties;
  abi::Start start;
  abi::Text text;
  const auto find_props_fault = [&] { return abi::find_props_fault(props, *nprops, properties, text); };
  if (find_fault(*ntens, *ndi, *nshr, *nstatv, statev, dfgrd1, properties, start, text, find_props_fault)) {
    if (abi::asks_for_law(props, *nprops) && update_with_law(call(), text)) return;
    fail(call(), nullptr, text);
    abi::report("UMAT", text, MYOGROWTH_UTILITY(stdb_abqerr, STDB_ABQERR), MYOGROWTH_UTILITY(xit, XIT));
    return;
  }
  update<PointUpdate<double>>(call, properties, start, properties.material);
}

/// The same routine under a name of its own, for a user's UMAT that dispatches between materials.
MYOGROWTH_SECOND_NAME(Umat, MYOGROWTH_FORTRAN(myogrowth_umat, MYOGROWTH_UMAT), MYOGROWTH_FORTRAN(umat, UMAT));
#if defined(MYOGROWTH_SINGLE_FILE) && !defined(MYOGROWTH_INSIDE_ABAQUS)
/// For hosts that look for the name without an underscore, as Abaqus 2024 does in C++ sources.
MYOGROWTH_SECOND_NAME(Umat, umat, MYOGROWTH_FORTRAN(umat, UMAT));
#endif
}
