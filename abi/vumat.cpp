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

// An array (nblock, components) as Fortran stores it; point and component count from 0.
template <class N>
struct Array {
  N* data;
  std::ptrdiff_t nblock;
  N& operator()(int point, int component) const { return data[point + nblock * component]; }
};

// The arguments that are used.
struct Block {
  int size, ndir, nshr, nstatev, nprops;
  double dt;
  const Number *props, *density;
  Array<const Number> strain_inc, stretch_old, stress_old, state_old;
  const Number *energy_old, *dissipation_old;
  Array<const Number> stretch;
  Array<Number> stress, state;
  Number *energy, *dissipation;
};

void report(const char* text) {
  abi::report("VUMAT", text, MYOGROWTH_FORTRAN(xplb_abqerr, XPLB_ABQERR),
              MYOGROWTH_FORTRAN(xplb_exit, XPLB_EXIT));
}

bool find_fault(const Block& b, abi::Properties& properties, abi::Text& text) {
  if (b.ndir != 3 || b.nshr != 3) {
    return abi::tell(text,
                     "NDIR, NSHR = %d, %d: this version has 3, 3 alone (solid elements: C3D8R, C3D10M, ...).",
                     b.ndir, b.nshr);
  }
  return abi::find_room_fault("NSTATEV", b.nstatev, text) ||
         abi::find_props_fault(b.props, b.nprops, properties, text) ||
         abi::find_hybrid_fault("Abaqus/Explicit", properties, text) ||
         abi::find_stretch_fault("NSTATEV", b.nstatev, properties, text);
}

// State and energies as they were: Abaqus wants every entry written, ours or not.
void keep_state(const Block& b) {
  for (int i = 0; i < b.nstatev; ++i) {
    for (int k = 0; k < b.size; ++k) b.state(k, i) = b.state_old(k, i);
  }
  for (int k = 0; k < b.size; ++k) b.energy[k] = b.energy_old[k];
  for (int k = 0; k < b.size; ++k) b.dissipation[k] = b.dissipation_old[k];
}

// Stress and energy of a point that has no result: NaN, so that no host can continue silently.
void refuse(const Block& b, int k) {
  const Number nan = std::numeric_limits<Number>::quiet_NaN();
  for (int i = 0; i < b.ndir + b.nshr; ++i) b.stress(k, i) = nan;
  b.energy[k] = nan;
}

// Abaqus's data check: made-up strain increments, from which it takes the initial wave speeds. Time does not
// pass and STRETCH need not belong to them: Hooke's law, to which eq. 3 comes down at small strain.
void check_data(const Block& b, const FibreGrowth<double>& material, int k) {
  const auto strain = [&](int i) { return static_cast<double>(b.strain_inc(k, i)); };
  const double pressure = material.c1 * (strain(0) + strain(1) + strain(2));
  for (int i = 0; i < 6; ++i) {
    const double increment = 2 * material.c2 * strain(i) + (i < 3 ? pressure : 0);
    b.stress(k, i) = static_cast<Number>(b.stress_old(k, i) + increment);
  }
}

// Components 11 22 33 12 23 31 as F, column by column.
void read_symmetric(const Array<const Number>& s, int k, double F[9]) {
  const int component[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};
  for (int i = 0; i < 9; ++i) F[i] = s(k, component[i]);
}

// What the step of point k starts from. True, and the text, if that is not allowed.
bool find_start_fault(const Block& b, const abi::Properties& properties, int k, abi::Start& start,
                      abi::Text& text) {
  double state[abi::n_kept];
  for (int i = 0; i < abi::n_kept; ++i) state[i] = i < b.nstatev ? b.state_old(k, i) : 0;
  return abi::find_start(state, b.nstatev, properties, start, text) != UpdateStatus::ok;
}

// Writes a result; false, and nothing is written, if it is beyond the range of Abaqus's numbers.
bool write(const Block& b, int k, const double (&sigma)[6], const double (&state)[abi::n_kept], double psi) {
  // Energy is asked for per unit mass, and the density is that of the middle of the step.
  double U_old[9];
  read_symmetric(b.stretch_old, k, U_old);
  const double J_mid = (determinant(U_old) + state[3]) / 2;
  const Number energy = static_cast<Number>(psi / (b.density[k] * J_mid));
  bool finite = is_finite(energy);
  for (double x : sigma) finite = finite && is_finite(static_cast<Number>(x));
  for (double x : state) finite = finite && is_finite(static_cast<Number>(x));
  if (!finite) return false;
  const int kernel_index[6] = {0, 1, 2, 3, 5, 4};  // the kernel's order is 11 22 33 12 13 23
  for (int i = 0; i < 6; ++i) b.stress(k, i) = static_cast<Number>(sigma[kernel_index[i]]);
  for (int i = 0; i < abi::kept_entries(b.nstatev); ++i) b.state(k, i) = static_cast<Number>(state[i]);
  b.energy[k] = energy;
  return true;
}

// The update of a point that packs do not take. False, and the text if it is a fault, if there is no result.
bool update(const Block& b, const abi::Properties& properties, int k, abi::Text& text) {
  double U[9], sigma[6], state[abi::n_kept];
  abi::Start start;
  if (find_start_fault(b, properties, k, start, text)) return false;
  read_symmetric(b.stretch, k, U);
  PointUpdate<double> u;
  if (update_point(properties.material, U, start.n0, start.G, start.lambda, b.dt, u) != UpdateStatus::ok)
    return false;
  cauchy_from_kirchhoff(u.J, u.tau, sigma);
  abi::state_of(u, state);
  return write(b, k, sigma, state, u.psi);
}

void update_block(const Block& b, bool is_data_check) {
  keep_state(b);
  abi::Properties properties;
  abi::Text text;
  if (find_fault(b, properties, text)) {
    for (int k = 0; k < b.size; ++k) refuse(b, k);
    report(text);
    return;
  }
  if (is_data_check) {
    for (int k = 0; k < b.size; ++k) check_data(b, properties.material, k);
    return;
  }
  bool reported = false;  // one message a call
  const int cauchy = 0;
  abi::update_many(
      properties.material, b.dt, b.size, cauchy, false,
      [&](int k, double(&U)[9], abi::Start& start) {
        read_symmetric(b.stretch, k, U);
        return !find_start_fault(b, properties, k, start, text);
      },
      [&](int k, const abi::BlockResult& r) {
        double sigma[6], state[abi::n_kept];
        r.gather<6>(r.block.stress, sigma);
        r.state(state);
        return write(b, k, sigma, state, r.psi());
      },
      [&](int k) {
        text[0] = '\0';
        if (update(b, properties, k, text)) return;
        refuse(b, k);
        if (text[0] && !reported) report(text);
        reported = reported || text[0];
      });
}

}  // namespace

extern "C" {
/// What Abaqus/Explicit calls. Newer versions pass arrays whose first entry is what was once a number:
/// NBLOCK, and DT.
void MYOGROWTH_FORTRAN(vumat, VUMAT)(
    const int* nblock, const int* ndir, const int* nshr, const int* nstatev, const int* /*nfieldv*/,
    const int* nprops, const int* /*lanneal*/, const Number* stepTime, const Number* totalTime,
    const Number* dt, const char* /*cmname*/, const Number* /*coordMp*/, const Number* /*charLength*/,
    const Number* props, const Number* density, const Number* strainInc, const Number* /*relSpinInc*/,
    const Number* /*tempOld*/, const Number* stretchOld, const Number* /*defgradOld*/,
    const Number* /*fieldOld*/, const Number* stressOld, const Number* stateOld, const Number* enerInternOld,
    const Number* enerInelasOld, const Number* /*tempNew*/, const Number* stretchNew,
    const Number* /*defgradNew*/, const Number* /*fieldNew*/, Number* stressNew, Number* stateNew,
    Number* enerInternNew, Number* enerInelasNew) {
  const int n = *nblock;
  const Block block{n,
                    *ndir,
                    *nshr,
                    *nstatev,
                    *nprops,
                    *dt,
                    props,
                    density,
                    {strainInc, n},
                    {stretchOld, n},
                    {stressOld, n},
                    {stateOld, n},
                    enerInternOld,
                    enerInelasOld,
                    {stretchNew, n},
                    {stressNew, n},
                    {stateNew, n},
                    enerInternNew,
                    enerInelasNew};
  update_block(block, *stepTime == 0 && *totalTime == 0);
}
/// The same routine under a name of its own, for a user's VUMAT that dispatches between materials.
MYOGROWTH_SECOND_NAME(Vumat, MYOGROWTH_FORTRAN(myogrowth_vumat, MYOGROWTH_VUMAT),
                      MYOGROWTH_FORTRAN(vumat, VUMAT));
}
