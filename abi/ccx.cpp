// The law for CalculiX, libMYOGROWTH.so, for a ccx that can load libraries (examples/calculix):
//
//   *MATERIAL, NAME=@ABAQUS_MYOGROWTH_CCX     CalculiX's interface for Abaqus UMATs of small strain
//   *MATERIAL, NAME=@MYOGROWTH_NATIVE         CalculiX's own interface
//
// Both take the second Piola-Kirchhoff stress S and dS/dE as they come, at any strain; CalculiX keeps the
// symmetric part of dS/dE. (Its other Abaqus interface, @ABAQUSNL_, loses the factor J and the rotation.)
// PROPS and STATEV are the UMAT's, docs/manual.md; elastic laws have an order of their own, docs/laws.md. Of
// the arguments only those are read that CalculiX fills.
//
// *INITIAL CONDITIONS of CalculiX 2.20 reads six state variables at most, and one point per card; so a fibre
// may also come in STATEV(2:4), which STATEV(5) = -1 says (Je is never negative):
//
//   *INITIAL CONDITIONS, TYPE=SOLUTION
//   element, point, G or 0, n0_1, n0_2, n0_3, -1.
#include <atomic>
#include <cstdlib>
#include <limits>

#include "many.hpp"

namespace {

using namespace myogrowth;

constexpr int n_all_props = abi::first_law_parameter + abi::most_law_parameters;  // of PROPS, at most

// CalculiX has no way to be told of bad input, so the job is ended as CalculiX ends it: with its status,
// once, though its threads may all find the same fault.
[[noreturn]] void end_job(const char* text, const char* note = "") {
  static std::atomic_flag told = ATOMIC_FLAG_INIT;
  while (told.test_and_set()) {  // another thread is about to end the process
  }
  std::fflush(nullptr);
  std::printf("\n *ERROR in myogrowth: %s%s\n\n", text, note);
  std::fflush(nullptr);
  std::_Exit(201);
}

// ccx 2.20 copies all constants of a deck into an array of 21, without a word where there are more.
void warn_of_constants(int nprops) {
  constexpr int room = 21;
  static std::atomic_flag told = ATOMIC_FLAG_INIT;
  if (nprops <= room || told.test_and_set()) return;
  std::printf(
      "\n *WARNING in myogrowth: CONSTANTS = %d: CalculiX has room for %d, and more overwrite its numbers "
      "(docs/laws.md).\n\n",
      nprops, room);
  std::fflush(stdout);
}

// Puts a fibre that came in STATEV(2:4) where the UMAT has it.
void move_fibre(double* statev, int nstatev) {
  if (nstatev < 5 || !(statev[4] < 0)) return;
  if (!abi::keeps_fibre(nstatev))
    end_job("STATEV(5) = -1, a fibre in STATEV(2:4): *DEPVAR must be at least 8.");
  for (int i = 0; i < 3; ++i) statev[abi::fibre_entry + i] = statev[1 + i];
  for (int i = 1; i < 5; ++i) statev[i] = 0;
}

// PROPS in the UMAT's order, if they come in the short order that fits an elastic law into the 21 constants
// that CalculiX passes: activation, -law, PROPS(3:9), the law's parameters, PROPS(11:). False if they do not.
bool put_in_order(const double* given, int n, double (&props)[n_all_props]) {
  if (n < abi::n_props_required || !(given[1] == -1 || given[1] == -2 || given[1] == -3)) return false;
  const double law = -given[1];
  int next = 2;
  const auto take = [&](double initial) { return next < n ? given[next++] : initial; };
  for (double& x : props) x = 0;
  for (int i = 2; i < abi::n_props_plain; ++i) props[i] = take(abi::property(i).initial);
  props[abi::law_entry] = law;
  props[abi::activation_entry] = given[0];
  const abi::LawParameters& table = abi::parameters_of(static_cast<abi::Law>(static_cast<int>(law)));
  for (int i = 0; i < table.size; ++i) props[abi::first_law_parameter + i] = take(table.entry[i].initial);
  for (int i = abi::energy_entry; i < abi::hybrid_entry; ++i) props[i] = take(abi::property(i).initial);
  for (; next < n; ++next) {
    if (given[next] != 0) end_job("There are more constants than CalculiX's order for elastic laws has.");
  }
  return true;
}

// One step at one point. `statev` comes in as at the beginning of the increment. pnewdt of CalculiX: -1
// unless the increment is to be repeated, pnewdt times as long.
void update(const double* F, double dtime, const double* props, int nprops, double* statev, int nstatev,
            double S[6], double dS_dE[36], double& pnewdt) {
  warn_of_constants(nprops);
  move_fibre(statev, nstatev);
  const int second_piola = 2;
  abi::Common common{{}, nstatev, dtime, second_piola, true, {}};
  const abi::Properties& p = common.properties;
  abi::Text text;
  double in_order[n_all_props];
  const bool is_short = put_in_order(props, nprops, in_order);
  if (abi::find_call_fault("CalculiX", "*DEPVAR", is_short ? in_order : props,
                           is_short ? n_all_props : nprops, false, nstatev, common.properties, common.law,
                           text))
    end_job(text, is_short ? " (Its place in the UMAT's order; docs/laws.md has CalculiX's short one.)" : "");
  if (p.local_basis) {
    end_job(
        "PROPS(10) = 1: CalculiX gives F in fixed axes, so frame must be 0, and the section have no "
        "*ORIENTATION.");
  }
  double factor = 1;
  const double G_n = abi::number_at_start(statev), lambda_n = abi::stretch_at_start(statev, nstatev);
  const auto write = [&](const abi::Result& r) {
    for (int i = 0; i < 6; ++i) S[i] = r[myogrowth_row_stress + i * myogrowth_block_points];
    for (int i = 0; i < 36; ++i) dS_dE[i] = r[myogrowth_row_tangent + i * myogrowth_block_points];
    const double lambda = r[abi::row_of_state(abi::stretch_entry)];
    if (p.tolerance > 0) factor = abi::advised_factor(p, G_n, lambda_n, lambda, dtime);
    for (int i = 0; i < abi::kept_entries(nstatev); ++i) statev[i] = r[abi::row_of_state(i)];
    return true;
  };
  const double no_field = 0;  // PROPS(20) = -1 is refused
  if (abi::update_alone(common, abi::or_identity(F), statev, no_field, text, write) != UpdateStatus::ok) {
    if (text[0]) end_job(text);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < 6; ++i) S[i] = nan;
    for (int i = 0; i < 36; ++i) dS_dE[i] = nan;
    factor = abi::cut_back;
  }
  if (factor < 1 && !(pnewdt > 0 && pnewdt <= factor)) pnewdt = factor;
}

}  // namespace

extern "C" {

/// `@ABAQUS_MYOGROWTH_CCX`: the arguments of Abaqus's UMAT. STRESS[6]: S; DDSDDE[36]: dS/dE; both 11 22 33 12
/// 13 23.
void CCX(double* stress, double* statev, double* ddsdde, double* /*sse*/, double* /*spd*/, double* /*scd*/,
         double* /*rpl*/, double* /*ddsddt*/, double* /*drplde*/, double* /*drpldt*/, const double* /*stran*/,
         const double* /*dstran*/, const double* /*time*/, const double* dtime, const double* /*temp*/,
         const double* /*dtemp*/, const double* /*predef*/, const double* /*dpred*/, const char* /*cmname*/,
         const int* /*ndi*/, const int* /*nshr*/, const int* /*ntens*/, const int* nstatv,
         const double* props, const int* nprops, const double* /*coords*/, const double* /*drot*/,
         double* pnewdt, const double* /*celent*/, const double* /*dfgrd0*/, const double* dfgrd1,
         const int* /*noel*/, const int* /*npt*/, const int* /*layer*/, const int* /*kspt*/,
         const int* /*jstep*/, const int* /*kinc*/, int /*length of cmname*/) {
  update(dfgrd1, *dtime, props, *nprops, statev, *nstatv, stress, ddsdde, *pnewdt);
}

/// `@MYOGROWTH_NATIVE`: the arguments of CalculiX's own umat_user. xstateini and xstate are those of all
/// elements, (nstate, mi[0], elements); stre[6]: S; stiff[21]: the upper triangle of dS/dE, column by column.
/// An elastic iteration (ielas = 1) is not treated apart: the consistent tangent serves it as well.
void NATIVE(const char* /*amat*/, const int* iel, const int* iint, const int* kode, const double* elconloc,
            const double* /*emec*/, const double* /*emec0*/, const double* /*beta*/, const double* /*xokl*/,
            const double* /*voj*/, const double* xkl, const double* /*vj*/, const int* /*ithermal*/,
            const double* /*t1l*/, const double* dtime, const double* /*time*/, const double* /*ttime*/,
            const int* icmd, const int* /*ielas*/, const int* mi, const int* nstate, const double* xstateini,
            double* xstate, double* stre, double* stiff, const int* /*iorien*/, const double* /*pgauss*/,
            const double* /*orab*/, double* pnewdt, const int* /*ipkon*/, int /*length of amat*/) {
  const std::ptrdiff_t point = *iint - 1 + static_cast<std::ptrdiff_t>(mi[0]) * (*iel - 1);
  double* statev = xstate + *nstate * point;
  for (int i = 0; i < *nstate; ++i) statev[i] = xstateini[*nstate * point + i];
  double dS_dE[36];
  const int stress_only = 3;
  update(xkl, *dtime, elconloc, -*kode - 100, statev, *nstate, stre, dS_dE, *pnewdt);
  if (*icmd == stress_only) return;
  for (int col = 0, k = 0; col < 6; ++col) {
    for (int row = 0; row <= col; ++row, ++k) stiff[k] = (dS_dE[row + 6 * col] + dS_dE[col + 6 * row]) / 2;
  }
}
}
