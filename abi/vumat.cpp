// Abaqus/Explicit VUMAT of stretch-driven muscle growth: check, update the block, write. abaqus.h has the
// arguments; PROPS and STATEV are the UMAT's, docs/manual.md.
//
// VUMAT lives in a basis that turns with the material and wants R^T sigma R, where F = R U. The law is
// objective and n0 is a reference direction, so that is the law at F := U; neither F nor PROPS(10) is needed.
// Nothing is remembered between calls, nothing throws, and arrays that some hosts do not fill are never read.
//
// Abaqus passes reals of the precision it runs in (MYOGROWTH_VUMAT_SINGLE: float); the update is in double.
// But a float G does not grow by less than 6e-8 a step: explicit steps so short against the time constant
// need Abaqus's double precision.
#include <limits>
#include <myogrowth/measures.hpp>

#include "abaqus.h"
#include "many.hpp"

// Abaqus/Explicit's message and exit utilities.
extern "C" {
MYOGROWTH_IF_THERE HostMessage MYOGROWTH_FORTRAN(xplb_abqerr, XPLB_ABQERR);
MYOGROWTH_IF_THERE HostExit MYOGROWTH_FORTRAN(xplb_exit, XPLB_EXIT);
}

namespace {

using namespace myogrowth;
using Number = VumatReal;

// The arguments that are used. at(point, component), both from 0, is the place in an array (nblock,
// components).
struct Block {
  int size, ndir, nshr, nstatev, nprops;
  bool has_fields;
  double dt;
  const Number *field, *props, *density, *strain_inc, *stretch_old, *stress_old, *state_old, *energy_old,
      *dissipation_old, *stretch;
  Number *stress, *state, *energy, *dissipation;
  std::ptrdiff_t at(int point, int component) const {
    return point + static_cast<std::ptrdiff_t>(size) * component;
  }
  double old_state(int k, int entry) const {
    return entry < nstatev ? static_cast<double>(state_old[at(k, entry)]) : 0;
  }
};

void report(const char* text) {
  abi::report("VUMAT", text, MYOGROWTH_UTILITY(xplb_abqerr, XPLB_ABQERR),
              MYOGROWTH_UTILITY(xplb_exit, XPLB_EXIT));
}

bool find_fault(const Block& b, abi::Common& common, abi::Text& text) {
  if (b.ndir != 3 || b.nshr != 3) {
    return abi::tell(text,
                     "NDIR, NSHR = %d, %d: this version has 3, 3 only (solid elements: C3D8R, C3D10M, ...).",
                     b.ndir, b.nshr);
  }
  return abi::find_call_fault("Abaqus/Explicit", "NSTATEV", b.props, b.nprops, b.has_fields, b.nstatev,
                              common.properties, common.law, text);
}

constexpr int place[6] = {0, 1, 2, 3, 5, 4};  // of our components, 11 22 33 12 13 23, among VUMAT's

// State and energies as they were: Abaqus wants every entry written, ours or not.
void keep_state(const Block& b) {
  for (std::ptrdiff_t i = 0; i < b.at(0, b.nstatev); ++i) b.state[i] = b.state_old[i];
  for (int k = 0; k < b.size; ++k) b.energy[k] = b.energy_old[k];
  for (int k = 0; k < b.size; ++k) b.dissipation[k] = b.dissipation_old[k];
}

// Stress and energy of a point that has no result: NaN, so that no host can continue silently.
void refuse(const Block& b, int k) {
  const Number nan = std::numeric_limits<Number>::quiet_NaN();
  for (int i = 0; i < b.ndir + b.nshr; ++i) b.stress[b.at(k, i)] = nan;
  b.energy[k] = nan;
}

// Abaqus's data check: made-up strain increments, from which it takes the initial wave speeds. Time does not
// pass and STRETCH need not belong to them: Hooke's law with the moduli of the undeformed muscle.
void check_data(const Block& b, const abi::Common& common, int k) {
  double c[36], n0[3] = {1, 0, 0}, state[abi::n_kept];
  for (int i = 0; i < abi::n_kept; ++i) state[i] = b.old_state(k, i);
  abi::Start start;
  abi::Text text;
  if (abi::find_start(state, b.nstatev, common.properties, start, text) == UpdateStatus::ok) {
    for (int i = 0; i < 3; ++i) n0[i] = start.n0[i];
  }
  const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, one = 1, no_time = 0;
  abi::with_material(common.properties.material, common.law,
                     [&](auto& u, const auto& material, const auto&... a) {
                       update_point(material, identity, n0, one, one, no_time, u, a...);
                       spatial_modulus(u, c);
                       return u.status;
                     });
  for (int i = 0; i < 6; ++i) {
    double increment = 0;
    for (int j = 0; j < 6; ++j) {
      const double strain = b.strain_inc[b.at(k, place[j])];
      increment += c[i + 6 * j] * (j < 3 ? strain : 2 * strain);
    }
    const std::ptrdiff_t at = b.at(k, place[i]);
    b.stress[at] = static_cast<Number>(b.stress_old[at] + increment);
  }
}

// Where U has the components of F, column by column, among its own, 11 22 33 12 23 31.
constexpr int component_of_U[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};
void read_stretch(const Block& b, const Number* stretch, int k, double F[9]) {
  for (int i = 0; i < 9; ++i) F[i] = stretch[b.at(k, component_of_U[i])];
}

// Writes a result; false, and nothing is written, if it is beyond the range of Abaqus's numbers.
bool write(const Block& b, int k, const abi::Result& r) {
  // Energy is asked for per unit mass, and the density is that of the middle of the step.
  double U_old[9];
  read_stretch(b, b.stretch_old, k, U_old);
  const double J_mid = (determinant(U_old) + r[abi::row_of_state(3)]) / 2;
  const Number energy = static_cast<Number>(r[myogrowth_row_psi] / (b.density[k] * J_mid));
  Number stress[6], state[abi::n_kept];
  for (int i = 0; i < 6; ++i)
    stress[i] = static_cast<Number>(r[myogrowth_row_stress + i * myogrowth_block_points]);
  for (int i = 0; i < abi::n_kept; ++i) state[i] = static_cast<Number>(r[abi::row_of_state(i)]);
  if (!(is_finite(energy) && are_finite(stress, 6) && are_finite(state, abi::n_kept))) return false;
  for (int i = 0; i < 6; ++i) b.stress[b.at(k, place[i])] = stress[i];
  for (int i = 0; i < abi::kept_entries(b.nstatev); ++i) b.state[b.at(k, i)] = state[i];
  b.energy[k] = energy;
  return true;
}

// The points, for abi::update_many.
struct Points {
  const Block& b;
  const abi::Common& common;
  bool& reported;  // one message a call

  void load(int i, int count, MyogrowthBlock& block) const {
    constexpr int size = myogrowth_block_points;
    const bool has_fibre = abi::keeps_fibre(b.nstatev);
    for (int k = 0; k < count; ++k) {
      for (int c = 0; c < 9; ++c)
        block.number[myogrowth_row_F + c * size + k] = b.stretch[b.at(i + k, component_of_U[c])];
      for (int c = 0; c < 3; ++c)
        block.number[myogrowth_row_n0 + c * size + k] =
            has_fibre ? b.old_state(i + k, abi::fibre_entry + c) : 0;
      block.number[myogrowth_row_G + k] = b.old_state(i + k, 0);
      block.number[myogrowth_row_lambda + k] = b.old_state(i + k, abi::stretch_entry);
    }
  }
  bool take(int k, const abi::Result& r) const { return write(b, k, r); }
  void describe(MyogrowthBlock&) const {}
  void finish(int, int) const {}
  UpdateStatus one(int k, abi::Text& text) const {
    double U[9], state[abi::n_kept];
    read_stretch(b, b.stretch, k, U);
    for (int i = 0; i < abi::n_kept; ++i) state[i] = b.old_state(k, i);
    return abi::update_alone(common, U, state, common.law.by_field ? b.field[k] : Number(0), text,
                             [&](const abi::Result& r) { return take(k, r); });
  }
  void refuse(int k, UpdateStatus, const abi::Text& fault) const {
    ::refuse(b, k);
    if (fault[0] && !reported) report(fault);
    reported = reported || fault[0];
  }
};

void update(const Block& b, bool is_data_check) {
  keep_state(b);
  const int cauchy = 0;
  abi::Common common{{}, b.nstatev, b.dt, cauchy, false, {}};
  abi::Text text;
  if (find_fault(b, common, text)) {
    for (int k = 0; k < b.size; ++k) refuse(b, k);
    report(text);
    return;
  }
  if (is_data_check) {
    for (int k = 0; k < b.size; ++k) check_data(b, common, k);
    return;
  }
  common.properties.local_basis = false;  // U is in the basis that turns with the material as it is
  bool reported = false;
  Points points{b, common, reported};
  abi::update_many(common, 0, b.size, points);
}

}  // namespace

extern "C" {
/// What Abaqus/Explicit calls. Newer versions pass arrays whose first entry is what was once a number:
/// NBLOCK, and DT.
void MYOGROWTH_FORTRAN(vumat, VUMAT)(
    const int* nblock, const int* ndir, const int* nshr, const int* nstatev, const int* nfieldv,
    const int* nprops, const int* /*lanneal*/, const Number* stepTime, const Number* totalTime,
    const Number* dt, const char* /*cmname*/, const Number* /*coordMp*/, const Number* /*charLength*/,
    const Number* props, const Number* density, const Number* strainInc, const Number* /*relSpinInc*/,
    const Number* /*tempOld*/, const Number* stretchOld, const Number* /*defgradOld*/,
    const Number* /*fieldOld*/, const Number* stressOld, const Number* stateOld, const Number* enerInternOld,
    const Number* enerInelasOld, const Number* /*tempNew*/, const Number* stretchNew,
    const Number* /*defgradNew*/, const Number* fieldNew, Number* stressNew, Number* stateNew,
    Number* enerInternNew, Number* enerInelasNew) {
  const Block block{
      *nblock,   *ndir,         *nshr,         *nstatev,      *nprops,    nfieldv && *nfieldv > 0,
      *dt,       fieldNew,      props,         density,       strainInc,  stretchOld,
      stressOld, stateOld,      enerInternOld, enerInelasOld, stretchNew, stressNew,
      stateNew,  enerInternNew, enerInelasNew};
  update(block, *stepTime == 0 && *totalTime == 0);
}
/// The same routine under a name of its own, for a user's VUMAT that dispatches between materials.
MYOGROWTH_SECOND_NAME(Vumat, MYOGROWTH_FORTRAN(myogrowth_vumat, MYOGROWTH_VUMAT),
                      MYOGROWTH_FORTRAN(vumat, VUMAT));
}
