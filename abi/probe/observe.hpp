/// @file
/// What the probe sees of a host, call by call, and remembers: hypotheses, and what strikes them out.
#ifndef MYOGROWTH_ABI_PROBE_OBSERVE_HPP
#define MYOGROWTH_ABI_PROBE_OBSERVE_HPP

#include "path.hpp"

namespace probe {

/// What the host did with an argument, as far as the observations leave a choice. Sets of hypotheses: an
/// observation strikes out those that do not explain it, and the first one also `unseen`.
using Set = unsigned;
constexpr Set all = ~0u, unseen = 1u << 31;

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
enum : Set { dtime_right = 1 };
enum : Set { strain_zero = 1, strain_small = 2, strain_rate = 4 };
enum : Set {  // STATEV; what has happened, not what is left
  state_strange = 1,
  state_lost = 2,
  state_not_restored = 4,
  state_restored = 8,
  state_kept = 16
};
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
  double first_state = 0, pnewdt_last = 0;
  Set state = 0, pnewdt = 0;
  Set frame = all, stress = all, time = all, dtime = all, strain = all;
  bool no_deformation = false;
  double angle = 0, angle_first = 0, angle_spread = 0, offset = 0, offset_first = 0, offset_spread = 0;
  double scale = 0;
  double F_last[9] = {};
  int shear_place = -1;
  int uses[n_uses] = {}, solves = 0;
  bool told = false, told_of_file = false;
};
/// One job of one element in one thread.
static Watch watch;

inline bool near(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }
inline bool near(Complex a, Complex b, double tolerance) { return abs(a - b) <= tolerance; }

/// An angle of a basis, known but for half turns, into (-90, 90] degrees.
inline double half_turn(double angle) {
  return angle - std::acos(-1.0) * std::round(angle / std::acos(-1.0));
}
inline double largest(double a, double b) { return a > b ? a : b; }

inline void see_frame(const Evaluation& e) {
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
  const bool is_first = watch.frame & unseen;
  watch.frame &= fits;

  // The angle of the basis: against fixed axes, and against R.
  const double R = arg(f.p), of_q = arg(f.q) - arg(m.q);
  watch.offset = half_turn((watch.frame & (abaqus_local | abaqus_local_transposed)) ? of_q / 2 - R
                           : (watch.frame & classical_local)                        ? (of_q - R) / 2
                                                                                    : of_q - R);
  watch.angle = half_turn(watch.offset + R);
  if (is_first) {
    watch.angle_first = watch.angle;
    watch.offset_first = watch.offset;
  }
  watch.angle_spread = largest(watch.angle_spread, std::abs(half_turn(watch.angle - watch.angle_first)));
  watch.offset_spread = largest(watch.offset_spread, std::abs(half_turn(watch.offset - watch.offset_first)));
}

/// Whether the stress in units of PROPS(1) is `k` times the held one, turned by an angle about axis 3.
inline bool is_held(const double* s, double angle, double k = 1) {
  const double* h = held_stress;
  const Complex turned = polar(k, 2 * angle) * Complex{(h[0] - h[1]) / 2, h[3]};
  const double ok = 2e-4 * (1 + std::abs(k));
  return near((s[0] + s[1]) / 2, k * (h[0] + h[1]) / 2, ok) && near({(s[0] - s[1]) / 2, s[3]}, turned, ok) &&
         near(s[2], k * h[2], ok) && near(s[4], 0, ok) && near(s[5], 0, ok);
}

inline bool is_second_piola(const double* s, double t) {  // F S F^T = J sigma
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

inline void see_stress(const Evaluation& e, const double* stress, double unit) {
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
}

inline void see_state(double entry, double previous_id, bool whole) {
  const bool inner = !watch.first_of_increment;
  if (!whole) {
    watch.state |= state_strange;
  } else if (entry == watch.converged_id) {
    if (watch.n_converged > 0) watch.state |= inner ? state_restored : state_kept;
  } else if (inner && entry == previous_id) {
    watch.state |= state_not_restored;
  } else {
    watch.state |= entry == 0 ? state_lost : state_strange;
  }
}

/// An increment has ended with this evaluation.
inline void converge(const Evaluation& e) {
  ++watch.n_converged;
  watch.converged_id = e.id;
  watch.converged_t_before = watch.converged_t;
  watch.converged_t = e.t;
  if (!(e.t > free_until + 0.5)) return;
  Set fits = 0;
  if (near(e.time[1] + e.dtime, e.t, 1e-3)) fits |= time_of_start;
  if (near(e.time[1], e.t, 1e-3)) fits |= time_of_end;
  watch.time &= fits;
  if (!(watch.converged_t_before > free_until + 0.5)) return;
  const bool is_right = near(e.dtime, e.t - watch.converged_t_before, 1e-3);
  watch.dtime &= is_right ? Set(dtime_right) : 0;
}

inline void see_strain(const Evaluation& e, const double* dstran) {
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
  for (int i = 3; i < 6; ++i) {
    if (std::abs(dstran[i]) > 0.02) watch.shear_place = i;
  }
}

inline double used(int use, int i, int j) {
  const double given = modulus[i][j], other = modulus[j][i];
  const double by_use[n_uses] = {given, other, (given + other) / 2, i < j ? given : other,
                                 i > j ? given : other};
  return by_use[use];
}

/// Newton's method moves the free strains so that 0 = sigma + K d(strain) in 22 and 33: which K did the host
/// take? This needs no convergence, only one move within an increment.
inline void see_tangent(const Evaluation& a, const Evaluation& b, double unit) {
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

/// Strain in the free part of the path; where the host gives no deformation gradient there, its own.
inline void find_strain(const double* F, const double* stran, const double* dstran, double (&strain)[6]) {
  bool none = true;  // zero or the identity
  for (int i = 0; i < 9; ++i) none = none && (F[i] == 0 || (i % 4 == 0 && F[i] == 1));
  for (int i = 0; i < 6; ++i) strain[i] = none ? stran[i] + dstran[i] : 0;
  if (none) return;
  for (int i = 0; i < 3; ++i) strain[i] = F[4 * i] - 1;
  strain[3] = F[1] + F[3];
  strain[4] = F[2] + F[6];
  strain[5] = F[5] + F[7];
}

inline void evaluate(double* stress, const double* statev, const double* stran, const double* dstran,
                     const double* time, double dtime, int nstatv, double unit, double pnewdt,
                     const double* F) {
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

/// Whether this is the call of another point in the evaluation that was looked at last.
inline bool is_repeated(const double* stran, const double* dstran, const double* time, double dtime,
                        const double* F) {
  bool again = watch.evaluations > 0 && time[0] == watch.now.time[0] && time[1] == watch.now.time[1] &&
               dtime == watch.now.dtime;
  double strain[6];
  find_strain(F, stran, dstran, strain);
  for (int i = 0; again && i < 9; ++i) again = near(F[i], watch.now.F[i], 1e-12);
  for (int i = 0; again && i < 6; ++i) again = near(strain[i], watch.now.strain[i], 1e-12);
  return again;
}

}  // namespace probe

#endif
