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

#include "block.hpp"
#include "fortran_name.hpp"
#include "point.hpp"

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

// Stress and energy of a point that gave no result: NaN, so that no host can continue silently.
void refuse(const Block& b, int k) {
  const Number nan = std::numeric_limits<Number>::quiet_NaN();
  for (int i = 0; i < b.ndir + b.nshr; ++i) b.stress(k, i) = nan;
  b.ener_intern[k] = nan;
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

// What the law gives for a point.
struct Result {
  double sigma[6], state[n_state], psi;
};

// Puts a result where Abaqus wants it. False, and nothing is written, if it is beyond the range of its
// numbers.
bool write(const Block& b, int k, const Result& r) {
  // Energy is asked for per unit mass, and the density is that of the middle of the step.
  const double J_mid = (det_of_symmetric(b.stretch_old, k) + r.state[3]) / 2;
  const Number energy = static_cast<Number>(r.psi / (b.density[k] * J_mid));
  bool finite = is_finite(energy);
  for (double s : r.sigma) finite = finite && is_finite(static_cast<Number>(s));
  for (double s : r.state) finite = finite && is_finite(static_cast<Number>(s));
  if (!finite) return false;

  for (int i = 0; i < 6; ++i) b.stress(k, i) = static_cast<Number>(r.sigma[kernel_index(i)]);
  b.ener_intern[k] = energy;
  const int room = abi::keeps_fibre(b.nstatev) ? n_state : abi::fibre_entry;
  for (int i = 0; i < room && i < b.nstatev; ++i) b.state(k, i) = static_cast<Number>(r.state[i]);
  return true;
}

// U of point k, column by column.
void read_stretch(const Block& b, int k, double U[9]) {
  const int component[9] = {0, 3, 5, 3, 1, 4, 5, 4, 2};
  for (int i = 0; i < 9; ++i) U[i] = b.stretch(k, component[i]);
}

// Point k alone, from the sarcomere number G_n. False if the step cannot be taken.
bool update(const Block& b, const FibreGrowth<double>& material, double G_n, double lambda_n,
            const double n0[3], int k) {
  double U[9];
  read_stretch(b, k, U);
  PointUpdate<double> u;
  if (update_point(material, U, n0, G_n, lambda_n, b.dt, u) != Status::ok) return false;
  Result r{{}, {u.G, u.lambda_e, u.lambda, u.J, u.Je, u.n0[0], u.n0[1], u.n0[2]}, u.psi};
  cauchy_from_kirchhoff(u.J, u.tau, r.sigma);
  return write(b, k, r);
}

// Points start to start + count, at most as many as a block of the batch has.
void update_many(const Block& b, const abi::Properties& properties, int start, int count, bool& reported) {
  constexpr int stride = myogrowth_block_points;
  MyogrowthBlock block;
  block.dt = b.dt;
  bool can[stride], faulty[stride];
  const bool material_can = abi::packs_can(properties.material, b.dt);
  for (int j = 0; j < count; ++j) {
    const int k = start + j;
    double state[n_state], n0[3] = {properties.n0[0], properties.n0[1], properties.n0[2]},
                           unit[3] = {1, 0, 0}, U[9];
    for (int i = 0; i < n_state; ++i) state[i] = i < b.nstatev ? b.state_old(k, i) : 0;
    abi::Text text;
    faulty[j] = abi::find_state_fault(state, b.nstatev, properties, text) ||
                abi::find_fibre_fault(state, b.nstatev, n0, text);
    if (faulty[j] && !reported) report(text);
    reported = reported || faulty[j];
    read_stretch(b, k, U);
    can[j] =
        !faulty[j] && material_can && normalise(n0, unit) && abi::packs_can(U, abi::number_at_start(state));
    for (int i = 0; i < 9; ++i) block.F[j + stride * i] = can[j] ? U[i] : i % 4 == 0 ? 1 : 0;
    for (int i = 0; i < 3; ++i) block.n0[j + stride * i] = can[j] ? unit[i] : n0[i];
    block.G[j] = faulty[j] ? 1 : abi::number_at_start(state);
    block.lambda[j] = faulty[j] ? 1 : abi::stretch_at_start(state, b.nstatev);
  }
  const MyogrowthBlockMaterial material = abi::block_material(properties.material);
  const int cauchy = 0, no_tangent = 0;
  abi::update_block()(&material, count, cauchy, no_tangent, &block);
  for (int j = 0; j < count; ++j) {
    const auto of = [j](const double* x, int i) { return x[j + stride * i]; };
    bool done = false;
    if (can[j] && block.check[j] == 0) {
      Result r{{}, {block.G_end[j]}, of(block.scalars, 4)};
      for (int i = 0; i < 6; ++i) r.sigma[i] = of(block.stress, i);
      for (int i = 0; i < 4; ++i) r.state[1 + i] = of(block.scalars, i);
      for (int i = 0; i < 3; ++i) r.state[abi::fibre_entry + i] = of(block.n0, i);
      done = write(b, start + j, r);
    } else if (!faulty[j]) {
      const double n0[3] = {of(block.n0, 0), of(block.n0, 1), of(block.n0, 2)};
      done = update(b, properties.material, block.G[j], block.lambda[j], n0, start + j);
    }
    if (!done) refuse(b, start + j);
  }
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
  for (int start = 0; start < b.size; start += myogrowth_block_points) {
    const int left = b.size - start;
    update_many(b, properties, start, left < myogrowth_block_points ? left : myogrowth_block_points,
                reported);
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
