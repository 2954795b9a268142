// Abaqus/Explicit VUMAT of stretch-driven muscle growth: gather a point, update, scatter. PROPS and STATEV
// are the UMAT's; docs/manual.md has them.
//
// VUMAT lives in a basis that turns with the material and wants R^T sigma R, where F = R U. The law is
// objective and n0 is a reference direction, so that is the law at F := U; DEFGRAD is not needed, nor is
// PROPS(10). Nothing is remembered between calls and nothing throws; arrays that some hosts do not fill are
// never read.
//
// Abaqus passes reals of the precision it runs in. MYOGROWTH_VUMAT_SINGLE makes the arguments float; the
// update is in double in either build. But a float G does not grow by less than 6e-8 a step: explicit steps
// so short against the time constant need Abaqus's double precision.
#include <limits>
#include <myogrowth/kernel.hpp>
#include <myogrowth/measures.hpp>

#include "faults.hpp"
#include "fortran_name.hpp"

// Abaqus/Explicit's message and exit utilities.
extern "C" {
MYOGROWTH_IF_THERE myogrowth::abi::HostMessage MYOGROWTH_FORTRAN(xplb_abqerr, XPLB_ABQERR);
MYOGROWTH_IF_THERE myogrowth::abi::HostExit MYOGROWTH_FORTRAN(xplb_exit, XPLB_EXIT);
}

namespace {

using namespace myogrowth;

#ifdef MYOGROWTH_VUMAT_SINGLE
using Number = float;
#else
using Number = double;
#endif

// An array (nblock, components) as Fortran stores it; point and component count from 0.
template <class N>
struct Array {
  N* data;
  std::ptrdiff_t nblock;
  N& operator()(int point, int component) const { return data[point + nblock * component]; }
};
using In = Array<const Number>;
using Out = Array<Number>;

// What is used of the arguments.
struct Block {
  int size, ndir, nshr, nstatev, nprops;
  double step_time, total_time, dt;
  const Number* props;
  const Number* density;
  In strain_inc, stretch_old, stress_old, state_old;
  const Number *ener_intern_old, *ener_inelas_old;
  In stretch;
  Out stress, state;
  Number *ener_intern, *ener_inelas;
};

// Entries of the state that are read and written. The last, a thickness stretch, is not for solids.
constexpr int n_state = abi::fibre_entry + 3;

// VUMAT's order is 11 22 33 12 23 31, the kernel's 11 22 33 12 13 23.
constexpr int kernel_index(int component) { return component < 4 ? component : 9 - component; }

double det_of_symmetric(const In& U, int k) {
  const double a = U(k, 0), b = U(k, 1), c = U(k, 2), ab = U(k, 3), bc = U(k, 4), ca = U(k, 5);
  return a * (b * c - bc * bc) - ab * (ab * c - bc * ca) + ca * (ab * bc - b * ca);
}

// State and energies as they were: Abaqus wants every entry written, ours or not.
void keep_state(const Block& b) {
  for (int i = 0; i < b.nstatev; ++i) {
    for (int k = 0; k < b.size; ++k) b.state(k, i) = b.state_old(k, i);
  }
  for (int k = 0; k < b.size; ++k) b.ener_intern[k] = b.ener_intern_old[k];
  for (int k = 0; k < b.size; ++k) b.ener_inelas[k] = b.ener_inelas_old[k];
}

// The stress of a point that gave no result: no host can go on with it unawares.
void refuse(const Block& b, int k) {
  for (int i = 0; i < b.ndir + b.nshr; ++i) b.stress(k, i) = std::numeric_limits<Number>::quiet_NaN();
}

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

// Hooke's law, to which eq. 3 comes down at small strain.
void linear_elastic(const Block& b, const FibreGrowth<double>& material, int k) {
  const double pressure =
      material.c1 * (double(b.strain_inc(k, 0)) + b.strain_inc(k, 1) + b.strain_inc(k, 2));
  for (int i = 0; i < 6; ++i) {
    const double increment = 2 * material.c2 * b.strain_inc(k, i) + (i < 3 ? pressure : 0);
    b.stress(k, i) = static_cast<Number>(b.stress_old(k, i) + increment);
  }
}

// Point k of the block from the sarcomere number G_n. False if the step cannot be taken.
bool update(const Block& b, const FibreGrowth<double>& material, double G_n, double lambda_n,
            const double n0[3], int k) {
  const double U12 = b.stretch(k, 3), U23 = b.stretch(k, 4), U31 = b.stretch(k, 5);
  const double U[9] = {b.stretch(k, 0), U12, U31, U12, b.stretch(k, 1), U23, U31, U23, b.stretch(k, 2)};
  PointUpdate<double> u;
  if (update_point(material, U, n0, G_n, lambda_n, b.dt, u) != Status::ok) return false;

  double sigma[6];
  cauchy_from_kirchhoff(u.J, u.tau, sigma);
  // Energy is asked for per unit mass, and the density is that of the middle of the step.
  const double J_mid = (det_of_symmetric(b.stretch_old, k) + u.J) / 2;
  const Number energy = static_cast<Number>(u.psi / (b.density[k] * J_mid));
  bool finite = is_finite(energy);
  for (double s : sigma) finite = finite && is_finite(static_cast<Number>(s));
  if (!finite) return false;

  for (int i = 0; i < 6; ++i) b.stress(k, i) = static_cast<Number>(sigma[kernel_index(i)]);
  b.ener_intern[k] = energy;
  const double state[n_state] = {u.G, u.lambda_e, u.lambda, u.J, u.Je, u.n0[0], u.n0[1], u.n0[2]};
  const int room = abi::keeps_fibre(b.nstatev) ? n_state : abi::fibre_entry;
  for (int i = 0; i < room && i < b.nstatev; ++i) b.state(k, i) = static_cast<Number>(state[i]);
  return true;
}

void update_block(const Block& b) {
  keep_state(b);

  abi::Properties properties;
  abi::Text text;
  if (find_fault(b, properties, text)) {
    for (int k = 0; k < b.size; ++k) refuse(b, k);
    report(text);
    return;
  }

  // Abaqus's data check: made-up strain increments, from which it takes the initial wave speeds. Time does
  // not pass and STRETCH need not belong to them.
  if (b.step_time == 0 && b.total_time == 0) {
    for (int k = 0; k < b.size; ++k) linear_elastic(b, properties.material, k);
    return;
  }

  bool reported = false;  // one message a call
  for (int k = 0; k < b.size; ++k) {
    double state[n_state];
    for (int i = 0; i < n_state; ++i) state[i] = i < b.nstatev ? b.state_old(k, i) : 0;
    double n0[3] = {properties.n0[0], properties.n0[1], properties.n0[2]};
    const bool faulty = abi::find_state_fault(state, b.nstatev, n0, text);
    if (faulty && !reported) report(text);
    reported = reported || faulty;
    const double G_n = state[0] == 0 ? 1 : state[0];
    if (faulty || !update(b, properties.material, G_n, abi::stretch_at_start(state, b.nstatev), n0, k))
      refuse(b, k);
  }
}

}  // namespace

// The arguments of Abaqus/Explicit's VUMAT, in its order; see the Abaqus User Subroutines Guide. Newer
// versions pass arrays whose first entry is what was once a number: NBLOCK, and DT.
#define MYOGROWTH_VUMAT_ARGUMENTS                                                                           \
  const int *nblock, const int *ndir, const int *nshr, const int *nstatev, const int * /*nfieldv*/,         \
      const int *nprops, const int * /*lanneal*/, const Number *stepTime, const Number *totalTime,          \
      const Number *dt, const char * /*cmname*/, const Number * /*coordMp*/, const Number * /*charLength*/, \
      const Number *props, const Number *density, const Number *strainInc, const Number * /*relSpinInc*/,   \
      const Number * /*tempOld*/, const Number *stretchOld, const Number * /*defgradOld*/,                  \
      const Number * /*fieldOld*/, const Number *stressOld, const Number *stateOld,                         \
      const Number *enerInternOld, const Number *enerInelasOld, const Number * /*tempNew*/,                 \
      const Number *stretchNew, const Number * /*defgradNew*/, const Number * /*fieldNew*/,                 \
      Number *stressNew, Number *stateNew, Number *enerInternNew, Number *enerInelasNew
#define MYOGROWTH_VUMAT_CALL            \
  const int n = *nblock;                \
  update_block(Block{n,                 \
                     *ndir,             \
                     *nshr,             \
                     *nstatev,          \
                     *nprops,           \
                     *stepTime,         \
                     *totalTime,        \
                     *dt,               \
                     props,             \
                     density,           \
                     In{strainInc, n},  \
                     In{stretchOld, n}, \
                     In{stressOld, n},  \
                     In{stateOld, n},   \
                     enerInternOld,     \
                     enerInelasOld,     \
                     In{stretchNew, n}, \
                     Out{stressNew, n}, \
                     Out{stateNew, n},  \
                     enerInternNew,     \
                     enerInelasNew})

extern "C" {
/// What Abaqus/Explicit calls.
void MYOGROWTH_FORTRAN(vumat, VUMAT)(MYOGROWTH_VUMAT_ARGUMENTS) { MYOGROWTH_VUMAT_CALL; }
/// The same routine under a name of its own, for a user's VUMAT that dispatches between materials.
void MYOGROWTH_FORTRAN(myogrowth_vumat, MYOGROWTH_VUMAT)(MYOGROWTH_VUMAT_ARGUMENTS) { MYOGROWTH_VUMAT_CALL; }
}
