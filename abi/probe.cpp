// A UMAT that is no material: it watches what the host does with a UMAT, on one element that is led along a
// path known here, and writes a verdict to myogrowth_probe.txt. docs/probe.md has the path and how to run it.
//
// The element's state is uniform, so all its points see and return the same: successive calls with the same
// arguments are one evaluation, of which the first call is looked at, and no point has to be told from
// another. What is remembered is static: one job of one element in one thread.
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <myogrowth/version.hpp>

#include "fortran_name.hpp"

namespace {

/// std::complex would bring libgcc_s.
struct Complex {
  double re, im;
};
Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
Complex operator*(Complex a, Complex b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
Complex operator*(double k, Complex a) { return {k * a.re, k * a.im}; }
Complex conj(Complex a) { return {a.re, -a.im}; }
Complex polar(double size, double angle) { return {size * std::cos(angle), size * std::sin(angle)}; }
double abs(Complex a) { return std::hypot(a.re, a.im); }
double arg(Complex a) { return std::atan2(a.im, a.re); }

// ---- The path ----
// To t = 2: F11 alone is prescribed, 1e-4 up and down, F22 and F33 are free, so that the host has to solve
// with DDSDDE. To t = 4: stretch and shear. To t = 10: a rigid rotation of 90 degrees about axis 3, in
// unequal parts. F33 grows all the way from t = 2; no turn of the basis about axis 3 and no transposition
// changes it: it is the clock.

constexpr double free_until = 2, sheared_at = 4, path_end = 10, f33_rate = 0.05;
constexpr double turned_by[] = {0, 10, 35, 45, 65, 70, 90};  // degrees at t = 4, 5, ...

/// A matrix in the plane as a map of complex numbers: F x = p x + q conj(x). To turn it from the left is to
/// multiply p and q by exp(i angle), to transpose it is to conjugate p; U of the polar decomposition has p >
/// 0.
struct Planar {
  Complex p, q;
};

Planar planar(double f11, double f21, double f12, double f22) {
  return {{(f11 + f22) / 2, (f21 - f12) / 2}, {(f11 - f22) / 2, (f21 + f12) / 2}};
}

Planar knot(int t) {
  if (t <= 2) return planar(1, 0, 0, 1);
  if (t == 3) return planar(1.1, 0, 0.15, 0.95);
  const Planar sheared = planar(1.2, 0, 0.3, 0.9);
  const Complex turn = polar(1, turned_by[t < 10 ? t - 4 : 6] * std::acos(-1.0) / 180);
  return {turn * sheared.p, turn * sheared.q};
}

/// F in the plane at t, in fixed axes: displacements are linear in time between whole t.
Planar expected(double t) {
  const int from = t < 2 ? 2 : t < 9 ? static_cast<int>(t) : 9;
  const Planar a = knot(from), b = knot(from + 1);
  const double s = t - from;
  return {a.p + s * (b.p - a.p), a.q + s * (b.q - a.q)};
}

double clock_of(const double* F) { return free_until + (F[8] - 1) / f33_rate; }

// ---- The law ----

/// d sigma / d eps in units of PROPS(1): unsymmetric, its symmetric part positive definite. 22 and 33 meet no
/// shear, so the free strains stay uniform.
constexpr double modulus[6][6] = {{3, 1.5, 0.7, 0, 0, 0}, {0.5, 3, 1.6, 0, 0, 0}, {1.3, 0.4, 3, 0, 0, 0},
                                  {0, 0, 0, 1, 0, 0},     {0, 0, 0, 0, 1, 0},     {0, 0, 0, 0, 0, 1}};
/// Stress on the prescribed part of the path, in the same units.
constexpr double held_stress[6] = {0.02, -0.01, 0.005, 0.012, 0, 0};

// ---- What is remembered ----

/// What the host did with an argument, as far as the observations leave a choice. Sets of hypotheses: an
/// observation strikes out those that do not explain it.
using Set = unsigned;
constexpr Set all = ~0u;

enum : Set {  // DFGRD1; R the rotation of the polar decomposition, A another
  fixed = 1,
  fixed_transposed = 2,
  abaqus_local = 4,             // A^T F A
  abaqus_local_transposed = 8,  // the same, transposed
  classical_local = 16,         // Q^T R^T F Q
  other_local = 32,             // A^T F
  other_local_transposed = 64
};
enum : Set {  // STRESS on entry
  as_returned = 1,
  turned_before = 2,
  turned_after = 4,
  turned_twice = 8,
  zero = 16,
  turned_back = 32,
  second_piola = 64,
  scaled = 128
};
enum : Set { pnewdt_one = 1, pnewdt_huge = 2, pnewdt_negative = 4, pnewdt_other = 8 };
enum : Set { time_of_start = 1, time_of_end = 2 };
enum : Set { strain_zero = 1, strain_small = 2, strain_rate = 4 };
enum { as_given, transposed, symmetrised, upper, lower, n_uses };  // DDSDDE

struct Evaluation {
  double id = 0;  // what it left in STATEV
  double time[2] = {}, dtime = 0, F[9] = {}, strain[6] = {}, stress[6] = {}, t = 0;
  bool small = false;
};

struct Watch {
  int evaluations = 0, increments = 0;
  Evaluation now;
  bool first_of_increment = true;
  double converged_id = 0;
  int n_converged = 0;
  double converged_t = -1, converged_t_before = -1;

  int ndi = 0, nshr = 0, ntens = 0;
  double first_state = 0;
  int state_kept = 0, state_restored = 0, state_not_restored = 0, state_lost = 0, state_strange = 0;
  Set pnewdt = 0;
  double pnewdt_last = 0;
  int frames_seen = 0, stresses_seen = 0, times_seen = 0, strains_seen = 0, dtimes_seen = 0;
  Set frame = all, stress = all, time = all, strain = all;
  bool dtime_wrong = false, no_deformation = false;
  double angle = 0, angle_first = 0, angle_spread = 0, offset = 0, offset_first = 0, offset_spread = 0;
  double scale = 0;
  double F_last[9] = {};
  int shear_place = -1;
  int uses[n_uses] = {}, solves = 0;
  bool told = false, told_of_file = false;
};
Watch watch;

bool near(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }
bool near(Complex a, Complex b, double tolerance) { return abs(a - b) <= tolerance; }

// ---- DFGRD1 ----

/// An angle of a basis, known but for half turns, into (-90, 90] degrees.
double half_turn(double angle) { return angle - std::acos(-1.0) * std::round(angle / std::acos(-1.0)); }
double largest(double a, double b) { return a > b ? a : b; }

void see_frame(const Evaluation& e) {
  if (e.time[1] > 3.5 && (near(e.F[8], 1, 1e-2) || e.F[8] == 0)) watch.no_deformation = true;
  if (!(e.t > sheared_at + 0.5 && e.t < path_end + 0.01)) return;
  const Planar f = expected(e.t), m = planar(e.F[0], e.F[1], e.F[3], e.F[4]);
  const double ok = 1e-4;
  const bool q_size = near(abs(m.q), abs(f.q), ok);
  Set fits = 0;
  if (near(m.p, f.p, ok) && near(m.q, f.q, ok)) fits |= fixed;
  if (near(m.p, conj(f.p), ok) && near(m.q, f.q, ok)) fits |= fixed_transposed;
  if (near(m.p, f.p, ok) && q_size) fits |= abaqus_local;
  if (near(m.p, conj(f.p), ok) && q_size) fits |= abaqus_local_transposed;
  if (near(m.p, {abs(f.p), 0}, ok) && q_size) fits |= classical_local;
  const bool p_size = near(abs(m.p), abs(f.p), ok);
  if (p_size && near(m.p * f.q, m.q * f.p, ok)) fits |= other_local;
  if (p_size && near(conj(m.p) * f.q, m.q * f.p, ok)) fits |= other_local_transposed;
  for (int i = 0; i < 9; ++i) watch.F_last[i] = e.F[i];
  watch.frame &= fits;

  // The angle of the basis: against fixed axes, and against R.
  const double R = arg(f.p), of_q = arg(f.q) - arg(m.q);
  watch.offset = half_turn((watch.frame & (abaqus_local | abaqus_local_transposed)) ? of_q / 2 - R
                           : (watch.frame & classical_local)                        ? (of_q - R) / 2
                                                                                    : of_q - R);
  watch.angle = half_turn(watch.offset + R);
  if (watch.frames_seen++ == 0) {
    watch.angle_first = watch.angle;
    watch.offset_first = watch.offset;
  }
  watch.angle_spread = largest(watch.angle_spread, std::abs(half_turn(watch.angle - watch.angle_first)));
  watch.offset_spread = largest(watch.offset_spread, std::abs(half_turn(watch.offset - watch.offset_first)));
}

// ---- STRESS on entry ----

/// Whether the stress in units of PROPS(1) is `k` times the held one, turned by an angle about axis 3.
bool is_held(const double* s, double angle, double k = 1) {
  const double* h = held_stress;
  const Complex turned = polar(k, 2 * angle) * Complex{(h[0] - h[1]) / 2, h[3]};
  const double ok = 2e-4 * (1 + std::abs(k));
  return near((s[0] + s[1]) / 2, k * (h[0] + h[1]) / 2, ok) && near({(s[0] - s[1]) / 2, s[3]}, turned, ok) &&
         near(s[2], k * h[2], ok) && near(s[4], 0, ok) && near(s[5], 0, ok);
}

bool is_second_piola(const double* s, double t) {  // F S F^T = J sigma
  const Planar f = expected(t);
  const Complex e1 = f.p + f.q, e2 = Complex{0, 1} * (f.p - f.q);  // columns of F
  const double F[2][2] = {{e1.re, e2.re}, {e1.im, e2.im}};
  const double f33 = 1 + f33_rate * (t - free_until), J = f33 * (F[0][0] * F[1][1] - F[0][1] * F[1][0]);
  const double S[2][2] = {{s[0], s[3]}, {s[3], s[1]}};
  double sigma[6] = {0, 0, f33 * f33 * s[2] / J, 0, s[4], s[5]};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      sigma[0] += F[0][i] * S[i][j] * F[0][j] / J;
      sigma[1] += F[1][i] * S[i][j] * F[1][j] / J;
      sigma[3] += F[0][i] * S[i][j] * F[1][j] / J;
    }
  }
  return is_held(sigma, 0);
}

void see_stress(const Evaluation& e, const double* stress, double unit) {
  if (!(watch.converged_t > sheared_at + 0.5 && watch.converged_t_before > sheared_at - 0.5)) return;
  if (!(e.t > watch.converged_t + 0.1)) return;
  double s[6];
  for (int i = 0; i < 6; ++i) s[i] = stress[i] / unit;
  const double R_last = arg(expected(watch.converged_t).p);
  const double before = arg(expected(e.t).p) - R_last,
               after = R_last - arg(expected(watch.converged_t_before).p);
  const double factor = s[2] / held_stress[2];
  Set fits = 0;
  if (is_held(s, 0)) fits |= as_returned;
  if (is_held(s, before)) fits |= turned_before;
  if (is_held(s, after)) fits |= turned_after;
  if (is_held(s, before + after)) fits |= turned_twice;
  if (is_held(s, 0, 0)) fits |= zero;
  if (is_held(s, -R_last)) fits |= turned_back;
  if (is_second_piola(s, watch.converged_t)) fits |= second_piola;
  if (std::abs(factor) > 0.1 && is_held(s, 0, factor)) fits |= scaled;
  watch.scale = factor;
  watch.stress &= fits;
  ++watch.stresses_seen;
}

// ---- STATEV, times, strains ----

void see_state(double entry, double previous_id, bool whole) {
  const bool inner = !watch.first_of_increment;
  if (!whole) {
    ++watch.state_strange;
  } else if (entry == watch.converged_id) {
    if (inner && watch.n_converged > 0) ++watch.state_restored;
    if (!inner && watch.n_converged > 0) ++watch.state_kept;
  } else if (inner && entry == previous_id) {
    ++watch.state_not_restored;
  } else if (entry == 0) {
    ++watch.state_lost;
  } else {
    ++watch.state_strange;
  }
}

/// An increment has ended with this evaluation.
void converge(const Evaluation& e) {
  ++watch.n_converged;
  watch.converged_id = e.id;
  watch.converged_t_before = watch.converged_t;
  watch.converged_t = e.t;
  if (!(e.t > free_until + 0.5)) return;
  Set fits = 0;
  if (near(e.time[1] + e.dtime, e.t, 1e-3)) fits |= time_of_start;
  if (near(e.time[1], e.t, 1e-3)) fits |= time_of_end;
  watch.time &= fits;
  ++watch.times_seen;
  if (watch.converged_t_before > free_until + 0.5) {
    ++watch.dtimes_seen;
    if (!near(e.dtime, e.t - watch.converged_t_before, 1e-3)) watch.dtime_wrong = true;
  }
}

void see_strain(const Evaluation& e, const double* dstran) {
  if (!(e.t > free_until + 1.5 && e.t < sheared_at + 0.01)) return;
  if (!(watch.converged_t > free_until + 0.5 && e.t > watch.converged_t + 0.5)) return;
  const Planar a = expected(watch.converged_t), b = expected(e.t);
  const Planar d = {b.p - a.p, b.q - a.q}, sum = {a.p + b.p, a.q + b.q};
  // 2 d sum^-1, with sum^-1 x = (conj(p) x - q conj(x)) / (|p|^2 - |q|^2)
  const double det = (sum.p * conj(sum.p) - sum.q * conj(sum.q)).re;
  const Planar rate = {2 / det * (d.p * conj(sum.p) - d.q * conj(sum.q)),
                       2 / det * (d.q * sum.p - d.p * sum.q)};
  const auto is = [&](const Planar& g) {
    return near(dstran[0], g.p.re + g.q.re, 2e-3) && near(dstran[1], g.p.re - g.q.re, 2e-3) &&
           near(dstran[3], 2 * g.q.im, 2e-3);
  };
  Set fits = 0;
  if (is({})) fits |= strain_zero;
  if (is(d)) fits |= strain_small;
  if (is(rate)) fits |= strain_rate;
  watch.strain &= fits;
  ++watch.strains_seen;
  for (int i = 3; i < 6; ++i) {
    if (std::abs(dstran[i]) > 0.02) watch.shear_place = i;
  }
}

// ---- DDSDDE ----

double used(int use, int i, int j) {
  const double given = modulus[i][j], other = modulus[j][i];
  switch (use) {
    case as_given:
      return given;
    case transposed:
      return other;
    case symmetrised:
      return (given + other) / 2;
    case upper:
      return i < j ? given : other;
    default:
      return i > j ? given : other;
  }
}

/// Newton's method moves the free strains so that 0 = sigma + K d(strain) in 22 and 33: which K did the host
/// take? This needs no convergence, only one move within an increment.
void see_tangent(const Evaluation& a, const Evaluation& b, double unit) {
  if (!a.small || !b.small) return;
  const double d[3] = {b.strain[0] - a.strain[0], b.strain[1] - a.strain[1], b.strain[2] - a.strain[2]};
  const double size = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]);
  if (!(std::abs(d[1]) + std::abs(d[2]) > 1e-6)) return;
  ++watch.solves;
  double error[n_uses];
  int best = 0;
  for (int use = 0; use < n_uses; ++use) {
    error[use] = 0;
    for (int i = 1; i < 3; ++i) {
      double r = a.stress[i] / unit;
      for (int j = 0; j < 3; ++j) r += used(use, i, j) * d[j];
      error[use] += std::abs(r) / size;
    }
    if (error[use] < error[best]) best = use;
  }
  int close = 0;
  for (double e : error) close += e < 0.06;
  if (error[best] < 0.02 && close == 1) ++watch.uses[best];
}

// ---- The verdict ----

const char* const ok_mark = "[ok]      ";
const char* const harmless = "[harmless]";
const char* const wrong = "[WRONG]   ";
const char* const unknown = "[?]       ";
const char* const cannot = "cannot be told here";

double degrees(double a) { return a * 180 / std::acos(-1.0); }

void write_frame(std::FILE* f) {
  const char* name = "DFGRD1";
  if (watch.no_deformation) {
    std::fprintf(f, "%s %-8s stays without deformation. Switch on NLGEOM (finite strains).\n", wrong, name);
  } else if (watch.frames_seen == 0) {
    std::fprintf(f, "%s %-8s %s: the rotation has not been reached.\n", unknown, name, cannot);
  } else if (watch.frame & fixed) {
    std::fprintf(f, "%s %-8s is F in fixed axes, column by column. PROPS(10) = 0.\n", ok_mark, name);
  } else if (watch.frame & fixed_transposed) {
    std::fprintf(f,
                 "%s %-8s is transposed (row by row), in fixed axes. No PROPS flag mends it: transpose it.\n",
                 wrong, name);
  } else if (watch.frame & (abaqus_local | abaqus_local_transposed)) {
    const bool t = !(watch.frame & abaqus_local);
    if (watch.angle_spread < 1e-3) {
      std::fprintf(f,
                   "%s %-8s is F%s in fixed axes turned by %.2f degrees about axis 3. PROPS(10) = 0, n0 in "
                   "these axes.\n",
                   t ? wrong : ok_mark, name, t ? " transposed (mend this first)" : "", degrees(watch.angle));
    } else if (watch.offset_spread < 1e-3) {
      std::fprintf(f, "%s %-8s is (RQ)^T F (RQ)%s: its basis turns with the material. PROPS(10) = 1.\n",
                   t ? wrong : ok_mark, name, t ? " transposed (mend this first)" : "");
    } else {
      std::fprintf(f, "%s %-8s is A^T F A%s, A neither fixed nor turning with R. No PROPS flag fits.\n",
                   wrong, name, t ? " transposed" : "");
    }
  } else if (watch.frame & classical_local) {
    std::fprintf(
        f,
        "%s %-8s is R^T F, the right stretch: its basis turns with the material. PROPS(10) = 1. (It is "
        "symmetric: whether it is transposed makes no difference and %s.)\n",
        ok_mark, name, cannot);
  } else if (watch.frame & (other_local | other_local_transposed)) {
    std::fprintf(
        f,
        "%s %-8s is A^T F%s, where A turns but is not R of the polar decomposition. PROPS(10) = 1 is an "
        "approximation for small shear.\n",
        wrong, name, watch.frame & other_local ? "" : ", transposed");
  } else {
    std::fprintf(
        f, "%s %-8s %s: it is no known form of the prescribed F. Is the path the one of docs/probe.md?\n",
        unknown, name, cannot);
    const double* F = watch.F_last;
    std::fprintf(f, "           The last one, by rows: %.6f %.6f %.6f / %.6f %.6f %.6f / %.6f %.6f %.6f\n",
                 F[0], F[3], F[6], F[1], F[4], F[7], F[2], F[5], F[8]);
  }
  const bool local = watch.frame & (abaqus_local | abaqus_local_transposed | classical_local) &&
                     !(watch.frame & (fixed | fixed_transposed));
  if (watch.frames_seen && local && watch.angle_spread >= 1e-3 && watch.offset_spread < 1e-3 &&
      std::abs(watch.offset_first) > 1e-3) {
    std::fprintf(
        f,
        "           Against R it is turned by %.2f degrees: the Q of a local orientation; without one, "
        "a rotation other than R, and PROPS(10) = 1 is an approximation for small shear.\n",
        degrees(watch.offset_first));
  }
}

void write_stress(std::FILE* f) {
  const char *mark = harmless, *text;
  if (watch.stresses_seen == 0) {
    mark = unknown;
    text = "on entry: cannot be told here: the rotation has not been reached.";
  } else if (watch.stress & as_returned) {
    mark = ok_mark;
    text = "on entry is what was returned.";
  } else if (watch.stress & turned_before) {
    mark = ok_mark;
    text =
        "on entry is what was returned, turned by the rotation of the coming increment, as Abaqus documents.";
  } else if (watch.stress & (turned_after | turned_twice)) {
    mark = wrong;
    text =
        "is turned by the rotation of the increment after the call. Ours is the final Cauchy stress: have "
        "the host not turn it. No PROPS flag mends it.";
  } else if (watch.stress & zero) {
    text = "on entry is zero. The UMAT does not read it.";
  } else if (watch.stress & turned_back) {
    mark = wrong;
    text =
        "on entry is R^T sigma R. Likely the host takes what is returned as another measure than Cauchy "
        "stress in the axes of DFGRD1.";
  } else if (watch.stress & second_piola) {
    text = "on entry is second Piola-Kirchhoff stress of what was returned. The UMAT does not read it.";
  } else if (watch.stress & scaled) {
    std::fprintf(f, "%s %-8s on entry is %.6f times what was returned. The UMAT does not read it.\n",
                 harmless, "STRESS", watch.scale);
    return;
  } else {
    text = "on entry is no form of what was returned (garbage). The UMAT does not read it.";
  }
  std::fprintf(f, "%s %-8s %s\n", mark, "STRESS", text);
}

void write_state(std::FILE* f) {
  const char *mark = wrong, *text;
  if (watch.state_strange) {
    text = "on entry has numbers that were not returned. Growth cannot work.";
  } else if (watch.state_lost) {
    text = "is lost between calls. Growth cannot work.";
  } else if (watch.state_not_restored) {
    text =
        "on entry is that of the last call, not of the last increment: growth would go on with every "
        "iteration.";
  } else if (watch.state_kept && watch.state_restored) {
    mark = ok_mark;
    text = "is kept, and restored to the last increment's end before every iteration.";
  } else if (watch.state_kept) {
    mark = unknown;
    text = "is kept between increments; whether it is restored between iterations cannot be told here.";
  } else {
    mark = unknown;
    text = "cannot be told here: no increment has ended.";
  }
  std::fprintf(f, "%s %-8s %s\n", mark, "STATEV", text);
  if (watch.first_state == 0) {
    std::fprintf(f, "%s %-8s is 0 at first.\n", ok_mark, "STATEV");
  } else {
    std::fprintf(f, "%s %-8s is %g at first. The UMAT takes 0 as not initialised: set it to 0 or to G.\n",
                 wrong, "STATEV", watch.first_state);
  }
}

void write_pnewdt(std::FILE* f) {
  if (watch.pnewdt == pnewdt_one) {
    std::fprintf(f, "%s %-8s is 1 on entry.\n", ok_mark, "PNEWDT");
  } else if (watch.pnewdt == pnewdt_huge) {
    std::fprintf(f, "%s %-8s is huge on entry (%.3g). The UMAT only lowers it.\n", harmless, "PNEWDT",
                 watch.pnewdt_last);
  } else if (watch.pnewdt == pnewdt_negative) {
    std::fprintf(
        f,
        "%s %-8s is %g on entry. The UMAT leaves what is below 0.25, so a step that it refuses is not "
        "cut back by PNEWDT; STRESS is NaN then. No PROPS flag mends it: take small increments.\n",
        wrong, "PNEWDT", watch.pnewdt_last);
  } else {
    std::fprintf(f, "%s %-8s is not 1 throughout on entry, %g in the last call. The UMAT only lowers it.\n",
                 harmless, "PNEWDT", watch.pnewdt_last);
  }
}

void write_times(std::FILE* f) {
  if (watch.times_seen == 0) {
    std::fprintf(f, "%s %-8s %s yet.\n", unknown, "TIME", cannot);
  } else {
    const bool start = watch.time & time_of_start, end = watch.time & time_of_end;
    std::fprintf(f, "%s %-8s %s The UMAT does not read it.\n", start ? ok_mark : harmless, "TIME",
                 start ? "is that of the start of the increment, as in Abaqus."
                 : end ? "is that of the end of the increment."
                       : "TIME(2) is neither that of the start nor of the end of the increment.");
  }
  if (watch.dtimes_seen == 0) {
    std::fprintf(f, "%s %-8s %s yet.\n", unknown, "DTIME", cannot);
  } else if (watch.dtime_wrong) {
    std::fprintf(f, "%s %-8s is not the length of the increment: growth would be wrong.\n", wrong, "DTIME");
  } else {
    std::fprintf(f, "%s %-8s is the length of the increment.\n", ok_mark, "DTIME");
  }
}

void write_strain(std::FILE* f) {
  const char* text = watch.strains_seen == 0       ? nullptr
                     : watch.strain & strain_zero  ? "is zero."
                     : watch.strain & strain_small ? "is small strain."
                     : watch.strain & strain_rate
                         ? "is the strain of the increment, logarithmic or by Hughes-Winget."
                         : "is no measure known here, or in another basis.";
  if (text) {
    std::fprintf(f, "%s %-8s %s The UMAT does not read it.\n",
                 watch.strain & strain_rate ? ok_mark : harmless, "DSTRAN", text);
  } else {
    std::fprintf(f, "%s %-8s %s.\n", unknown, "DSTRAN", cannot);
  }
  if (watch.shear_place == 3) {
    std::fprintf(f, "%s %-8s 12 is the fourth component of strain; the order of 13 and 23 %s.\n", ok_mark,
                 "ORDER", cannot);
  } else if (watch.shear_place > 3) {
    std::fprintf(f, "%s %-8s 12 is component %d of strain, not 4: 11 22 33 12 13 23 is needed.\n", wrong,
                 "ORDER", watch.shear_place + 1);
  } else {
    std::fprintf(f, "%s %-8s of the components: %s.\n", unknown, "ORDER", cannot);
  }
}

void write_tangent(std::FILE* f) {
  static const char* const meaning[n_uses] = {
      "is used as given, unsymmetric: keep UNSYMM, or what the host calls it.",
      "is used transposed: right results, slow convergence. "
      "Transpose it in between, if the host has no switch.",
      "is used symmetrised: right results, slower convergence. Ask "
      "for the unsymmetric solver (Abaqus: UNSYMM).",
      "is used by its upper triangle alone: right results, slower "
      "convergence. Ask for the unsymmetric solver.",
      "is used by its lower triangle alone: right results, slower "
      "convergence. Ask for the unsymmetric solver."};
  int votes = 0, best = 0;
  for (int use = 0; use < n_uses; ++use) {
    votes += watch.uses[use];
    if (watch.uses[use] > watch.uses[best]) best = use;
  }
  if (votes > 0 && votes == watch.uses[best]) {
    std::fprintf(f, "%s %-8s %s\n", best == as_given ? ok_mark : wrong, "DDSDDE", meaning[best]);
  } else {
    std::fprintf(f, "%s %-8s %s: %s.\n", unknown, "DDSDDE", cannot,
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
  std::fprintf(f, "%s %-8s = %d, NDI = %d, NSHR = %d%s\n", solid ? ok_mark : wrong, "NTENS", watch.ntens,
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

// ---- The call ----

/// Strain in the free part of the path; where the host gives no deformation gradient there, its own.
void find_strain(const double* F, const double* stran, const double* dstran, double (&strain)[6]) {
  bool none = true;  // zero or the identity
  for (int i = 0; i < 9; ++i) none = none && (F[i] == 0 || (i % 4 == 0 && F[i] == 1));
  for (int i = 0; i < 6; ++i) strain[i] = none ? stran[i] + dstran[i] : 0;
  if (none) return;
  for (int i = 0; i < 3; ++i) strain[i] = F[4 * i] - 1;
  strain[3] = F[1] + F[3];
  strain[4] = F[2] + F[6];
  strain[5] = F[5] + F[7];
}

void evaluate(double* stress, const double* statev, const double* stran, const double* dstran,
              const double* time, double dtime, int nstatv, double unit, double pnewdt, const double* F) {
  const Evaluation last = watch.now;
  Evaluation& e = watch.now;
  e = Evaluation();
  e.time[0] = time[0], e.time[1] = time[1], e.dtime = dtime;
  for (int i = 0; i < 9; ++i) e.F[i] = F[i];
  e.t = clock_of(F);
  e.id = 1000 + ++watch.evaluations;
  find_strain(F, stran, dstran, e.strain);
  e.small = true;
  for (double component : e.strain) e.small = e.small && std::abs(component) < 2e-3;

  const bool started = watch.evaluations > 1;
  watch.first_of_increment = !started || time[1] != last.time[1] || dtime != last.dtime;
  if (watch.first_of_increment) {
    ++watch.increments;
    if (started && time[1] > last.time[1]) converge(last);  // else it is tried again, with another DTIME
  }
  if (nstatv > 0) {
    bool whole = true;
    for (int i = 1; i < nstatv && watch.n_converged > 0; ++i) {
      whole = whole && statev[i] == (statev[0] == 0 ? 0 : statev[0] + i);
    }
    if (!started) watch.first_state = watch.converged_id = statev[0];
    if (started) see_state(statev[0], last.id, whole);
  }
  watch.pnewdt |= pnewdt == 1     ? pnewdt_one
                  : pnewdt > 1e30 ? pnewdt_huge
                  : pnewdt < 0    ? pnewdt_negative
                                  : pnewdt_other;
  watch.pnewdt_last = pnewdt;
  see_frame(e);
  see_stress(e, stress, unit);
  see_strain(e, dstran);

  for (int i = 0; i < 6; ++i) {
    e.stress[i] = held_stress[i] * unit;
    if (!e.small) continue;
    e.stress[i] = 0;
    for (int j = 0; j < 6; ++j) e.stress[i] += modulus[i][j] * e.strain[j] * unit;
  }
  if (started && !watch.first_of_increment) see_tangent(last, e, unit);
}

void probe(double* stress, double* statev, double* ddsdde, const double* stran, const double* dstran,
           const double* time, double dtime, int ndi, int nshr, int ntens, int nstatv, double unit,
           double pnewdt, const double* F) {
  watch.ntens = ntens, watch.ndi = ndi, watch.nshr = nshr;
  const bool solid = ntens == 6 && ndi == 3 && nshr == 3;
  bool again = solid && watch.evaluations > 0 && time[0] == watch.now.time[0] &&
               time[1] == watch.now.time[1] && dtime == watch.now.dtime;
  double strain[6];
  find_strain(F, stran, dstran, strain);
  for (int i = 0; again && i < 9; ++i) again = near(F[i], watch.now.F[i], 1e-12);
  for (int i = 0; again && i < 6; ++i) again = near(strain[i], watch.now.strain[i], 1e-12);
  if (solid && !again) evaluate(stress, statev, stran, dstran, time, dtime, nstatv, unit, pnewdt, F);

  for (int i = 0; i < ntens; ++i) {
    stress[i] = solid ? watch.now.stress[i] : 0;
    for (int j = 0; j < ntens; ++j) ddsdde[i + ntens * j] = unit * (solid ? modulus[i][j] : i == j);
  }
  for (int i = 0; i < nstatv; ++i) statev[i] = watch.now.id + i;
  if (again) return;

  // Written anew each time, so that a crash of the host loses nothing.
  const char* const name = "myogrowth_probe.txt";
  std::FILE* file = std::fopen(name, "w");
  bool written = false;
  if (file) {
    write_verdict(file);
    const bool whole = std::ferror(file) == 0;
    written = std::fclose(file) == 0 && whole;
  }
  if (!written && !watch.told_of_file) {
    watch.told_of_file = true;
    std::fprintf(stderr, "myogrowth probe: %s cannot be written in the host's folder: %s.\n", name,
                 std::strerror(errno));
  }
  const double reached = watch.no_deformation ? time[1] + dtime : watch.now.t;
  if (!watch.told && (!solid || reached > path_end - 1e-3)) {
    watch.told = true;
    write_verdict(stderr);
  }
}

}  // namespace

/// The arguments of Abaqus/Standard's UMAT, in its order.
extern "C" void MYOGROWTH_FORTRAN(umat, UMAT)(
    double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd, double* rpl,
    double* ddsddt, double* drplde, double* drpldt, const double* stran, const double* dstran,
    const double* time, const double* dtime, const double* /*temp*/, const double* /*dtemp*/,
    const double* /*predef*/, const double* /*dpred*/, const char* /*cmname*/, const int* ndi,
    const int* nshr, const int* ntens, const int* nstatv, const double* props, const int* nprops,
    const double* /*coords*/, const double* /*drot*/, double* pnewdt, const double* /*celent*/,
    const double* /*dfgrd0*/, const double* dfgrd1, const int* /*noel*/, const int* /*npt*/,
    const int* /*layer*/, const int* /*kspt*/, const int* /*kstep*/, const int* /*kinc*/) {
  *sse = *spd = *scd = *rpl = *drpldt = 0;
  for (int i = 0; i < *ntens; ++i) ddsddt[i] = drplde[i] = 0;
  const double unit = *nprops > 0 && props[0] > 0 ? props[0] : 1000;
  probe(stress, statev, ddsdde, stran, dstran, time, *dtime, *ndi, *nshr, *ntens, *nstatv, unit, *pnewdt,
        dfgrd1);
}
