// A UMAT that is no material: it watches what the host does with a UMAT, on one element that is led along a
// path known here, and writes a verdict to myogrowth_probe.txt. docs/probe.md has the path and how to run it.
//
// The element's state is uniform, so all its points see and return the same: successive calls with the same
// arguments are one evaluation, of which the first call is looked at, and no point has to be told from
// another. What is remembered is static: one job of one element in one thread.
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <myogrowth/version.hpp>

#include "../abaqus.h"
#include "observe.hpp"

namespace {

using namespace probe;

const char *const ok = "[ok]", *const harmless = "[harmless]", *const wrong = "[WRONG]",
                  *const unknown = "[?]";
const char* const cannot = "cannot be told here";

// A line of the verdict: what of it is ok or not, an argument, and what the host does with it.
#if defined(__GNUC__)
__attribute__((format(printf, 4, 5)))
#endif
void say(std::FILE* f, const char* mark, const char* name, const char* format, ...) {
  std::fprintf(f, "%-10s %-8s ", mark, name);
  std::va_list arguments;
  va_start(arguments, format);
  std::vfprintf(f, format, arguments);
  va_end(arguments);
  std::fputc('\n', f);
}

double degrees(double a) { return a * 180 / std::acos(-1.0); }

void write_frame(std::FILE* f) {
  const char* name = "DFGRD1";
  const bool fixed_angle = watch.angle_spread < 1e-3, fixed_offset = watch.offset_spread < 1e-3;
  if (watch.no_deformation) {
    say(f, wrong, name, "stays without deformation. Switch on NLGEOM (finite strains).");
  } else if (watch.frames_seen == 0) {
    say(f, unknown, name, "%s: the rotation has not been reached.", cannot);
  } else if (watch.frame & fixed) {
    say(f, ok, name, "is F in fixed axes, column by column. PROPS(10) = 0.");
  } else if (watch.frame & fixed_transposed) {
    say(f, wrong, name, "is transposed (row by row), in fixed axes. No PROPS flag mends it: transpose it.");
  } else if (watch.frame & (abaqus_local | abaqus_local_transposed)) {
    const bool t = !(watch.frame & abaqus_local);
    const char *mark = t ? wrong : ok, *first = t ? " transposed (mend this first)" : "";
    if (fixed_angle) {
      say(f, mark, name,
          "is F%s in fixed axes turned by %.2f degrees about axis 3. PROPS(10) = 0, n0 in these axes.", first,
          degrees(watch.angle));
    } else if (fixed_offset) {
      say(f, mark, name, "is (RQ)^T F (RQ)%s: its basis turns with the material. PROPS(10) = 1.", first);
    } else {
      say(f, wrong, name, "is A^T F A%s, A neither fixed nor turning with R. No PROPS flag fits.",
          t ? " transposed" : "");
    }
  } else if (watch.frame & classical_local) {
    say(f, ok, name,
        "is R^T F, the right stretch: its basis turns with the material. PROPS(10) = 1. (It is symmetric: "
        "whether it is transposed makes no difference and %s.)",
        cannot);
  } else if (watch.frame & (other_local | other_local_transposed)) {
    say(f, wrong, name,
        "is A^T F%s, where A turns but is not R of the polar decomposition. PROPS(10) = 1 is an "
        "approximation for small shear.",
        watch.frame & other_local ? "" : ", transposed");
  } else {
    say(f, unknown, name,
        "%s: it is no known form of the prescribed F. Is the path the one of docs/probe.md?", cannot);
    const double* F = watch.F_last;
    std::fprintf(f, "           The last one, by rows: %.6f %.6f %.6f / %.6f %.6f %.6f / %.6f %.6f %.6f\n",
                 F[0], F[3], F[6], F[1], F[4], F[7], F[2], F[5], F[8]);
  }
  const bool local = watch.frame & (abaqus_local | abaqus_local_transposed | classical_local) &&
                     !(watch.frame & (fixed | fixed_transposed));
  if (watch.frames_seen && local && !fixed_angle && fixed_offset && std::abs(watch.offset_first) > 1e-3) {
    std::fprintf(
        f,
        "           Against R it is turned by %.2f degrees: the Q of a local orientation; without one, "
        "a rotation other than R, and PROPS(10) = 1 is an approximation for small shear.\n",
        degrees(watch.offset_first));
  }
}

// A sentence for each set of hypotheses; the first that is left counts.
struct Sentence {
  Set of;
  const char *mark, *text;
};
template <int n>
void say_first(std::FILE* f, const char* name, Set left, const Sentence (&sentences)[n]) {
  int i = 0;
  while (i < n - 1 && !(left & sentences[i].of)) ++i;  // the last is for none of them
  say(f, sentences[i].mark, name, "%s", sentences[i].text);
}

void write_stress(std::FILE* f) {
  if (watch.stresses_seen == 0) {
    say(f, unknown, "STRESS", "on entry: %s: the rotation has not been reached.", cannot);
    return;
  }
  char factor[100];
  std::snprintf(factor, sizeof factor, "on entry is %.6f times what was returned. The UMAT does not read it.",
                watch.scale);
  say_first(
      f, "STRESS", watch.stress,
      {{as_returned, ok, "on entry is what was returned."},
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
       {scaled, harmless, factor},
       {0, harmless, "on entry is no form of what was returned (garbage). The UMAT does not read it."}});
}

void write_state(std::FILE* f) {
  enum : Set { strange = 1, lost = 2, not_restored = 4, kept_and_restored = 8, kept = 16 };
  Set left = 0;
  if (watch.state_strange) left |= strange;
  if (watch.state_lost) left |= lost;
  if (watch.state_not_restored) left |= not_restored;
  if (watch.state_kept) left |= watch.state_restored ? kept_and_restored : kept;
  say_first(
      f, "STATEV", left,
      {{strange, wrong, "on entry has numbers that were not returned. Growth cannot work."},
       {lost, wrong, "is lost between calls. Growth cannot work."},
       {not_restored, wrong,
        "on entry is that of the last call, not of the last increment: growth would go on with every "
        "iteration."},
       {kept_and_restored, ok, "is kept, and restored to the last increment's end before every iteration."},
       {kept, unknown,
        "is kept between increments; whether it is restored between iterations cannot be told here."},
       {0, unknown, "cannot be told here: no increment has ended."}});
  if (watch.first_state == 0) {
    say(f, ok, "STATEV", "is 0 at first.");
  } else {
    say(f, wrong, "STATEV", "is %g at first. The UMAT takes 0 as not initialised: set it to 0 or to G.",
        watch.first_state);
  }
}

void write_pnewdt(std::FILE* f) {
  const char* name = "PNEWDT";
  if (watch.pnewdt == pnewdt_one) {
    say(f, ok, name, "is 1 on entry.");
  } else if (watch.pnewdt == pnewdt_huge) {
    say(f, harmless, name, "is huge on entry (%.3g). The UMAT only lowers it.", watch.pnewdt_last);
  } else if (watch.pnewdt == pnewdt_negative) {
    say(f, wrong, name,
        "is %g on entry. The UMAT leaves what is below 0.25, so a step that it refuses is not cut back by "
        "PNEWDT; STRESS is NaN then. No PROPS flag mends it: take small increments.",
        watch.pnewdt_last);
  } else {
    say(f, harmless, name, "is not 1 throughout on entry, %g in the last call. The UMAT only lowers it.",
        watch.pnewdt_last);
  }
}

void write_times(std::FILE* f) {
  if (watch.times_seen == 0) {
    say(f, unknown, "TIME", "%s yet.", cannot);
  } else {
    const bool start = watch.time & time_of_start, end = watch.time & time_of_end;
    say(f, start ? ok : harmless, "TIME", "%s The UMAT does not read it.",
        start ? "is that of the start of the increment, as in Abaqus."
        : end ? "is that of the end of the increment."
              : "TIME(2) is neither that of the start nor of the end of the increment.");
  }
  if (watch.dtimes_seen == 0) {
    say(f, unknown, "DTIME", "%s yet.", cannot);
  } else if (watch.dtime_wrong) {
    say(f, wrong, "DTIME", "is not the length of the increment: growth would be wrong.");
  } else {
    say(f, ok, "DTIME", "is the length of the increment.");
  }
}

void write_strain(std::FILE* f) {
  if (watch.strains_seen == 0) {
    say(f, unknown, "DSTRAN", "%s.", cannot);
  } else {
    say(f, watch.strain & strain_rate ? ok : harmless, "DSTRAN", "%s The UMAT does not read it.",
        watch.strain & strain_zero    ? "is zero."
        : watch.strain & strain_small ? "is small strain."
        : watch.strain & strain_rate  ? "is the strain of the increment, logarithmic or by Hughes-Winget."
                                      : "is no measure known here, or in another basis.");
  }
  if (watch.shear_place == 3) {
    say(f, ok, "ORDER", "12 is the fourth component of strain; the order of 13 and 23 %s.", cannot);
  } else if (watch.shear_place > 3) {
    say(f, wrong, "ORDER", "12 is component %d of strain, not 4: 11 22 33 12 13 23 is needed.",
        watch.shear_place + 1);
  } else {
    say(f, unknown, "ORDER", "of the components: %s.", cannot);
  }
}

void write_tangent(std::FILE* f) {
  static const char* const meaning[n_uses] = {
      "is used as given, unsymmetric: keep UNSYMM, or what the host calls it.",
      "is used transposed: right results, slow convergence. "
      "Transpose it in between, if the host has no switch.",
      "is used symmetrised: right results, slower convergence. Ask "
      "for the unsymmetric solver (Abaqus: UNSYMM).",
      "is used by its upper triangle only: right results, slower "
      "convergence. Ask for the unsymmetric solver.",
      "is used by its lower triangle only: right results, slower "
      "convergence. Ask for the unsymmetric solver."};
  int votes = 0, best = 0;
  for (int use = 0; use < n_uses; ++use) {
    votes += watch.uses[use];
    if (watch.uses[use] > watch.uses[best]) best = use;
  }
  if (votes > 0 && votes == watch.uses[best]) {
    say(f, best == as_given ? ok : wrong, "DDSDDE", "%s", meaning[best]);
  } else {
    say(f, unknown, "DDSDDE", "%s: %s.", cannot,
        watch.solves == 0 ? "the host has not solved for the free strains (t = 0 to 2)"
                          : "no Newton step with it explains how the free strains moved");
  }
}

void write_verdict(std::FILE* f) {
  const bool solid = watch.ntens == 6 && watch.ndi == 3 && watch.nshr == 3;
  std::fprintf(f, "myogrowth %d.%d.%d probe: what this host does with a UMAT\n", MYOGROWTH_VERSION_MAJOR,
               MYOGROWTH_VERSION_MINOR, MYOGROWTH_VERSION_PATCH);
  std::fprintf(f, "Seen so far: %d evaluations, %d increments, the path to t = %.3f of %g.\n\n",
               watch.evaluations, watch.increments, watch.now.t > 0 ? watch.now.t : 0.0, path_end);
  say(f, solid ? ok : wrong, "NTENS", "= %d, NDI = %d, NSHR = %d%s", watch.ntens, watch.ndi, watch.nshr,
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
