// A UMAT that is no material: it watches what the host does with a UMAT, on one element that is led along a
// path known here, and writes a verdict to myogrowth_probe.txt. docs/probe.md has the path and how to run it.
//
// The element's state is uniform, so all its points see and return the same: successive calls with the same
// arguments are one evaluation, of which the first call is looked at, and no point has to be told from
// another. What is remembered is static: one job of one element in one thread.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <myogrowth/version.hpp>

#include "../abaqus.h"
#include "observe.hpp"

namespace {

using namespace probe;

const char *const ok = "[ok]", *const harmless = "[harmless]", *const wrong = "[WRONG]",
                  *const unknown = "[?]";

// A line of the verdict for some hypotheses. A %g in the text is for the number that goes with it.
struct Sentence {
  Set of;
  const char *mark, *text;
};

// Says the first one of whose hypotheses one is left; the last is for none of them.
template <int n>
void say(std::FILE* f, const char* name, Set left, const Sentence (&sentences)[n], double number = 0) {
  int i = 0;
  while (i < n - 1 && !(left & sentences[i].of)) ++i;
  std::fprintf(f, "%-10s %-8s ", sentences[i].mark, name);
  std::fprintf(f, sentences[i].text, number);
  std::fputc('\n', f);
}

double degrees(double a) { return a * 180 / std::acos(-1.0); }

void write_frame(std::FILE* f) {
  const bool fixed_angle = watch.angle_spread < 1e-3, fixed_offset = watch.offset_spread < 1e-3;
  const Set if_angle = fixed_angle ? all : 0, if_offset = fixed_offset ? all : 0;
  say(f, "DFGRD1", watch.frame,
      {{watch.no_deformation ? all : 0, wrong,
        "stays without deformation. Switch on NLGEOM (finite strains)."},
       {unseen, unknown, "cannot be told here: the rotation has not been reached."},
       {fixed, ok, "is F in fixed axes, column by column. PROPS(10) = 0."},
       {fixed_transposed, wrong,
        "is transposed (row by row), in fixed axes. No PROPS flag mends it: transpose it."},
       {abaqus_local & if_angle, ok,
        "is F in fixed axes turned by %.2f degrees about axis 3. PROPS(10) = 0, n0 in these axes."},
       {abaqus_local & if_offset, ok, "is (RQ)^T F (RQ): its basis turns with the material. PROPS(10) = 1."},
       {abaqus_local, wrong, "is A^T F A, A neither fixed nor turning with R. No PROPS flag fits."},
       {abaqus_local_transposed & if_angle, wrong,
        "is F transposed (mend this first) in fixed axes turned by %.2f degrees about axis 3. PROPS(10) = 0, "
        "n0 in these axes."},
       {abaqus_local_transposed & if_offset, wrong,
        "is (RQ)^T F (RQ) transposed (mend this first): its basis turns with the material. PROPS(10) = 1."},
       {abaqus_local_transposed, wrong,
        "is A^T F A transposed, A neither fixed nor turning with R. No PROPS flag fits."},
       {classical_local, ok,
        "is R^T F, the right stretch: its basis turns with the material. PROPS(10) = 1. (It is symmetric: "
        "whether it is transposed makes no difference and cannot be told here.)"},
       {other_local, wrong,
        "is A^T F, where A turns but is not R of the polar decomposition. PROPS(10) = 1 is an approximation "
        "for small shear."},
       {other_local_transposed, wrong,
        "is A^T F, transposed, where A turns but is not R of the polar decomposition. PROPS(10) = 1 is an "
        "approximation for small shear."},
       {0, unknown,
        "cannot be told here: it is no known form of the prescribed F. Is the path the one of "
        "docs/probe.md?"}},
      degrees(watch.angle));
  if (watch.no_deformation || watch.frame & unseen) return;
  if (watch.frame == 0) {
    const double* F = watch.F_last;
    std::fprintf(f, "           The last one, by rows: %.6f %.6f %.6f / %.6f %.6f %.6f / %.6f %.6f %.6f\n",
                 F[0], F[3], F[6], F[1], F[4], F[7], F[2], F[5], F[8]);
  }
  const bool local = watch.frame & (abaqus_local | abaqus_local_transposed | classical_local) &&
                     !(watch.frame & (fixed | fixed_transposed));
  if (local && !fixed_angle && fixed_offset && std::abs(watch.offset_first) > 1e-3) {
    std::fprintf(
        f,
        "           Against R it is turned by %.2f degrees: the Q of a local orientation; without one, "
        "a rotation other than R, and PROPS(10) = 1 is an approximation for small shear.\n",
        degrees(watch.offset_first));
  }
}

void write_stress(std::FILE* f) {
  say(f, "STRESS", watch.stress,
      {{unseen, unknown, "on entry: cannot be told here: the rotation has not been reached."},
       {as_returned, ok, "on entry is what was returned."},
       {turned_before, ok,
        "on entry is what was returned, turned by the rotation of the coming increment, as Abaqus "
        "documents."},
       {turned_after | turned_twice, wrong,
        "is turned by the rotation of the increment after the call. Ours is the final Cauchy stress: "
        "have the host not turn it. No PROPS flag mends it."},
       {zero, harmless, "on entry is zero. The UMAT does not read it."},
       {turned_back, wrong,
        "on entry is R^T sigma R. Likely the host takes what is returned as another measure than Cauchy "
        "stress in the axes of DFGRD1."},
       {second_piola, harmless,
        "on entry is second Piola-Kirchhoff stress of what was returned. The UMAT does not read it."},
       {scaled, harmless, "on entry is %.6f times what was returned. The UMAT does not read it."},
       {0, harmless, "on entry is no form of what was returned (garbage). The UMAT does not read it."}},
      watch.scale);
}

void write_tangent(std::FILE* f) {
  int votes = 0, best = 0;
  for (int use = 0; use < n_uses; ++use) {
    votes += watch.uses[use];
    if (watch.uses[use] > watch.uses[best]) best = use;
  }
  const bool decided = votes > 0 && votes == watch.uses[best];
  say(f, "DDSDDE",
      decided             ? 1u << best
      : watch.solves == 0 ? unseen
                          : 0,
      {{unseen, unknown, "cannot be told here: the host has not solved for the free strains (t = 0 to 2)."},
       {1u << as_given, ok, "is used as given, unsymmetric: keep UNSYMM, or what the host calls it."},
       {1u << transposed, wrong,
        "is used transposed: right results, slow convergence. Transpose it in between, if the host has no "
        "switch."},
       {1u << symmetrised, wrong,
        "is used symmetrised: right results, slower convergence. Ask for the unsymmetric solver (Abaqus: "
        "UNSYMM)."},
       {1u << upper, wrong,
        "is used by its upper triangle only: right results, slower convergence. Ask for the unsymmetric "
        "solver."},
       {1u << lower, wrong,
        "is used by its lower triangle only: right results, slower convergence. Ask for the unsymmetric "
        "solver."},
       {0, unknown, "cannot be told here: no Newton step with it explains how the free strains moved."}});
}

void write_state(std::FILE* f) {
  say(f, "STATEV", watch.state & state_kept ? watch.state : watch.state & ~state_restored,
      {{state_strange, wrong, "on entry has numbers that were not returned. Growth cannot work."},
       {state_lost, wrong, "is lost between calls. Growth cannot work."},
       {state_not_restored, wrong,
        "on entry is that of the last call, not of the last increment: growth would go on with every "
        "iteration."},
       {state_restored, ok, "is kept, and restored to the last increment's end before every iteration."},
       {state_kept, unknown,
        "is kept between increments; whether it is restored between iterations cannot be told here."},
       {0, unknown, "cannot be told here: no increment has ended."}});
  say(f, "STATEV", watch.first_state == 0,
      {{1, ok, "is 0 at first."},
       {0, wrong, "is %g at first. The UMAT takes 0 as not initialised: set it to 0 or to G."}},
      watch.first_state);
}

void write_pnewdt(std::FILE* f) {
  const bool always_one_kind = (watch.pnewdt & (watch.pnewdt - 1)) == 0;
  say(f, "PNEWDT", always_one_kind ? watch.pnewdt : pnewdt_other,
      {{pnewdt_one, ok, "is 1 on entry."},
       {pnewdt_huge, harmless, "is huge on entry (%.3g). The UMAT only lowers it."},
       {pnewdt_negative, wrong,
        "is %g on entry. The UMAT leaves what is below 0.25, so a step that it refuses is not cut back by "
        "PNEWDT; STRESS is NaN then. No PROPS flag mends it: take small increments."},
       {0, harmless, "is not 1 throughout on entry, %g in the last call. The UMAT only lowers it."}},
      watch.pnewdt_last);
}

void write_times(std::FILE* f) {
  say(f, "TIME", watch.time,
      {{unseen, unknown, "cannot be told here yet."},
       {time_of_start, ok, "is that of the start of the increment, as in Abaqus. The UMAT does not read it."},
       {time_of_end, harmless, "is that of the end of the increment. The UMAT does not read it."},
       {0, harmless,
        "TIME(2) is neither that of the start nor of the end of the increment. The UMAT does not read it."}});
  say(f, "DTIME", watch.dtime,
      {{unseen, unknown, "cannot be told here yet."},
       {dtime_right, ok, "is the length of the increment."},
       {0, wrong, "is not the length of the increment: growth would be wrong."}});
}

void write_strain(std::FILE* f) {
  say(f, "DSTRAN", watch.strain,
      {{unseen, unknown, "cannot be told here."},
       {strain_zero, harmless, "is zero. The UMAT does not read it."},
       {strain_small, harmless, "is small strain. The UMAT does not read it."},
       {strain_rate, ok,
        "is the strain of the increment, logarithmic or by Hughes-Winget. The UMAT does not read it."},
       {0, harmless, "is no measure known here, or in another basis. The UMAT does not read it."}});
  say(f, "ORDER",
      watch.shear_place == 3  ? 1
      : watch.shear_place > 3 ? 2
                              : 0,
      {{1, ok, "12 is the fourth component of strain; the order of 13 and 23 cannot be told here."},
       {2, wrong, "12 is component %g of strain, not 4: 11 22 33 12 13 23 is needed."},
       {0, unknown, "of the components: cannot be told here."}},
      watch.shear_place + 1);
}

void write_verdict(std::FILE* f) {
  const bool solid = watch.ntens == 6 && watch.ndi == 3 && watch.nshr == 3;
  std::fprintf(f, "myogrowth %d.%d.%d probe: what this host does with a UMAT\n", MYOGROWTH_VERSION_MAJOR,
               MYOGROWTH_VERSION_MINOR, MYOGROWTH_VERSION_PATCH);
  std::fprintf(f, "Seen so far: %d evaluations, %d increments, the path to t = %.3f of %g.\n\n",
               watch.evaluations, watch.increments, watch.now.t > 0 ? watch.now.t : 0.0, path_end);
  std::fprintf(f, "%-10s %-8s = %d, NDI = %d, NSHR = %d%s\n", solid ? ok : wrong, "NTENS", watch.ntens,
               watch.ndi, watch.nshr,
               solid ? "." : ": the probe needs a solid element, 6, 3, 3; nothing else is judged.");
  if (!solid) return;
  write_frame(f);
  write_stress(f);
  write_tangent(f);
  write_state(f);
  write_pnewdt(f);
  write_times(f);
  write_strain(f);
  std::fprintf(
      f,
      "\nCannot be told here: whether the host turns or converts STRESS for its own use and hands it back "
      "unchanged.\n");
}

// Writes the report anew, so that a crash of the host loses nothing.
void write_report() {
  const char* const name = "myogrowth_probe.txt";
  std::FILE* file = std::fopen(name, "w");
  bool written = false;
  if (file) {
    write_verdict(file);
    const bool whole = std::ferror(file) == 0;
    written = std::fclose(file) == 0 && whole;
  }
  if (written || watch.told_of_file) return;
  watch.told_of_file = true;
  std::fprintf(stderr, "myogrowth probe: %s cannot be written in the host's folder: %s.\n", name,
               std::strerror(errno));
}

}  // namespace

/// What a host calls as its UMAT.
extern "C" void MYOGROWTH_FORTRAN(umat, UMAT)(
    double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd, double* rpl,
    double* ddsddt, double* drplde, double* drpldt, const double* stran, const double* dstran,
    const double* time, const double* dtime, const double* /*temp*/, const double* /*dtemp*/,
    const double* /*predef*/, const double* /*dpred*/, const char* /*cmname*/, const int* ndi,
    const int* nshr, const int* ntens, const int* nstatv, const double* props, const int* nprops,
    const double* /*coords*/, const double* /*drot*/, double* pnewdt, const double* /*celent*/,
    const double* /*dfgrd0*/, const double* F, const int* /*noel*/, const int* /*npt*/, const int* /*layer*/,
    const int* /*kspt*/, const int* /*kstep*/, const int* /*kinc*/) {
  *sse = *spd = *scd = *rpl = *drpldt = 0;
  for (int i = 0; i < *ntens; ++i) ddsddt[i] = drplde[i] = 0;
  const double unit = *nprops > 0 && props[0] > 0 ? props[0] : 1000;
  watch.ntens = *ntens, watch.ndi = *ndi, watch.nshr = *nshr;
  const bool solid = *ntens == 6 && *ndi == 3 && *nshr == 3;
  const bool again = solid && is_repeated(stran, dstran, time, *dtime, F);
  if (solid && !again) evaluate(stress, statev, stran, dstran, time, *dtime, *nstatv, unit, *pnewdt, F);

  for (int i = 0; i < *ntens; ++i) {
    stress[i] = solid ? watch.now.stress[i] : 0;
    for (int j = 0; j < *ntens; ++j) ddsdde[i + *ntens * j] = unit * (solid ? modulus[i][j] : i == j);
  }
  for (int i = 0; i < *nstatv; ++i) statev[i] = watch.now.id + i;
  if (again) return;

  write_report();
  const double reached = watch.no_deformation ? time[1] + *dtime : watch.now.t;
  if (!watch.told && (!solid || reached > path_end - 1e-3)) {
    watch.told = true;
    write_verdict(stderr);
  }
}
