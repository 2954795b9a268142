// What the manual says is not allowed, and what must have a result, in words of their own: the fuzzers hold
// the routines to these.
#ifndef MYOGROWTH_TESTS_FUZZ_RULES_HPP
#define MYOGROWTH_TESTS_FUZZ_RULES_HPP

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace rules {

using Numbers = std::vector<double>;

inline bool all_finite(const Numbers& x) {
  return std::all_of(x.begin(), x.end(), [](double y) { return std::isfinite(y); });
}
inline bool all_nan(const Numbers& x) {
  return std::all_of(x.begin(), x.end(), [](double y) { return std::isnan(y); });
}
inline bool same_bits(const Numbers& a, const Numbers& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

inline bool is_second_order(const Numbers& p) { return p.size() > 11 && p[11] == 1; }
inline bool removes(const Numbers& p) { return p.size() > 13 && p[13] > 0; }

/// known: the number of entries that mean something to the routine; the rest must be 0.
inline bool props_are_faulty(const Numbers& p, std::ptrdiff_t known = 17) {
  if (p.size() < 6 || !all_finite(p)) return true;
  if (!(p[1] > 0) || !(p[0] > -2 * p[1] / 3) || !(p[2] > 0) || p[3] < 0 || !(p[4] > 1) || !(p[5] > 0))
    return true;
  for (std::size_t i : {9u, 10u, 11u}) {
    if (i < p.size() && p[i] != 0 && p[i] != 1) return true;
  }
  if (p.size() > 12 && p[12] < 0) return true;
  if (p.size() > 13 && p[13] < 0) return true;
  if (removes(p) &&
      (p.size() < 17 || p[14] < 0 || !(p[15] > 0 && p[15] < 1) || !(p[16] > 0 && p[16] <= p[5])))
    return true;
  return std::any_of(p.begin() + std::min(known, p.end() - p.begin()), p.end(),
                     [](double x) { return x != 0; });
}

/// The same where PROPS(19) asks for an elastic law; c1 and c2 must be 0 then. field: PREDEF + DPRED.
inline bool law_is_faulty(Numbers p, double field) {
  const double law = p[18];
  if ((law != 1 && law != 2 && law != 3) || p[0] != 0 || p[1] != 0) return true;
  const double a = p.size() < 20 ? 0 : p[19] == -1 ? field : p[19];
  if (!(a >= -1e-9 && a <= 1 + 1e-9)) return true;
  const std::size_t known = law == 2 ? 31 : 28;
  if (std::any_of(
          p.begin() + std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(known), p.end() - p.begin()),
          p.end(), [](double x) { return x != 0; }))
    return true;
  const Numbers defaults = law == 1   ? Numbers{10, 10, 1000, 300, 300, 1.4, 0.05, 6.6}
                           : law == 2 ? Numbers{0.5, 0.5, 1000, 300, 1.4, 0.05, 6.6, 1.4, 0, 2700, 46.4}
                                      : Numbers{19.69, 1.19, 0.1599, 100, 0.7388, 73.52, 0.682, 1.192};
  Numbers q = defaults;
  for (std::size_t i = 20; i < p.size() && i < known; ++i) q[i - 20] = p[i];
  if (!all_finite(q)) return true;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const bool may_be_zero = (law == 1 && (i == 1 || i == 3 || i == 4 || i == 6)) ||
                             (law == 2 && (i == 3 || i == 5 || i == 8 || i == 9)) ||
                             (law == 3 && (i == 4 || i == 5));
    if (q[i] < 0 || (q[i] == 0 && !may_be_zero)) return true;
  }
  if (law == 2 && (!(q[7] > 1) || (q[8] != 0 && q[8] != 1))) return true;
  if (law == 3 && (q[4] > 1 || !(q[7] > q[6]))) return true;
  p.resize(18);
  p[0] = p[1] = 1;
  return props_are_faulty(p, 18);
}

/// For routines that have the elastic laws, but neither field variables nor mixed elements.
inline bool props_are_faulty_with_laws(const Numbers& p) {
  if (p.size() < 19 || p[18] == 0) return props_are_faulty(p);
  return law_is_faulty(p, NAN) || p[17] != 0;
}

/// A shear in the 1-3 plane beyond rounding, and none in the 1-2 plane, F column by column: with NTENS = 4
/// not Abaqus's order.
inline bool is_in_elmers_order(int ntens, const double* F) {
  const double rounding = 1e-12 * std::abs(F[0]);
  return ntens == 4 && F[1] == 0 && F[3] == 0 && (std::abs(F[2]) > rounding || std::abs(F[6]) > rounding);
}

/// Whether a state of n entries has room for what a step begins with.
inline bool has_no_room(const Numbers& p, std::size_t n) { return n < (is_second_order(p) ? 3 : 1); }

/// s: one entry or more. The stretch at the beginning counts where it is used.
inline bool state_is_faulty(const Numbers& p, const Numbers& s) {
  if (!std::isfinite(s[0]) || s[0] < 0) return true;
  const bool uses_stretch = is_second_order(p) || (p.size() > 12 && p[12] > 0);
  if (uses_stretch && s.size() > 2 && !(std::isfinite(s[2]) && s[2] >= 0)) return true;
  return s.size() >= 8 && !(std::isfinite(s[5]) && std::isfinite(s[6]) && std::isfinite(s[7]));
}

/// The fibre that counts, of any length: that of the state if it has one, else that of PROPS.
inline Numbers fibre(const Numbers& p, const Numbers& s) {
  if (s.size() >= 8 && (s[5] != 0 || s[6] != 0 || s[7] != 0)) return {s[5], s[6], s[7]};
  return {p.size() > 6 ? p[6] : 1, p.size() > 7 ? p[7] : 0, p.size() > 8 ? p[8] : 0};
}
inline bool has_no_fibre(const Numbers& p, const Numbers& s) {
  const Numbers n = fibre(p, s);
  return n[0] == 0 && n[1] == 0 && n[2] == 0;
}

/// c1 + 2 c2, as far as there are such.
inline double stiffness(const Numbers& p) { return p.size() > 1 ? std::abs(p[0]) + 2 * std::abs(p[1]) : 0; }

inline double det(const Numbers& F) {
  const auto f = [&](std::size_t i) { return static_cast<long double>(F[i]); };
  return static_cast<double>(f(0) * (f(4) * f(8) - f(5) * f(7)) - f(3) * (f(1) * f(8) - f(2) * f(7)) +
                             f(6) * (f(1) * f(5) - f(2) * f(4)));
}
inline double largest(const Numbers& x) {
  double all = 0;
  for (double y : x) all = std::max(all, std::abs(y));
  return all;
}
inline double largest_finite(const Numbers& x) {
  double all = 0;
  for (double y : x) all = std::max(all, std::isfinite(y) ? std::abs(y) : 0);
  return all;
}

/// Arguments without a fault that are so ordinary, by orders of magnitude, that there must be a result.
inline bool is_ordinary(const Numbers& p, const Numbers& s, const Numbers& F, double dt) {
  const auto within = [](double x, double low, double high) { return low <= x && x <= high; };
  if (is_second_order(p) && !(s[2] == 0 || within(s[2], 0.1, 10))) return false;
  if (removes(p) &&
      !(within(p[13], 1e-3, 1e3) && p[14] <= 100 && within(p[15], 1e-3, 1 - 1e-6) && p[16] >= 1e-3))
    return false;
  return within(p[0] + 2 * p[1] / 3, 1e-3, 1e3) && within(p[1], 1e-3, 1e3) && within(p[2], 1e-3, 1e3) &&
         p[3] <= 100 && within(p[4], 1 + 1e-6, 1e3) && within(p[5], 1e-3, 1e3) &&
         (s[0] == 0 || within(s[0], 0.1, 10)) && std::isfinite(dt) && all_finite(F) && largest(F) <= 10 &&
         det(F) >= 1e-3;
}
/// An F so clearly turned inside out, or a step so clearly not a number, that there can be none.
inline bool is_hopeless(const Numbers& F, double dt) {
  if (!std::isfinite(dt) || !all_finite(F)) return true;
  const double size = 1 + largest(F);
  return det(F) < -1e-9 * size * size * size;
}

/// What a step leaves in the state `now`, coming from `before`. fibre_stretch and J as the caller has them
/// from the kinematics alone, of F so large.
inline const char* what_is_wrong(const Numbers& now, const Numbers& before, const Numbers& p,
                                 const Numbers& F, double fibre_stretch) {
  const std::size_t ours = now.size() >= 8 ? 8 : std::min<std::size_t>(now.size(), 5);
  if (!all_finite(Numbers(now.begin(), now.begin() + static_cast<std::ptrdiff_t>(ours))))
    return "the state is not finite";
  const double G_n = before[0] == 0 ? 1 : before[0];
  const double least = removes(p) ? std::min(G_n, p[15]) : G_n;
  if (!(now[0] >= least && now[0] <= std::max(G_n, p[4]))) return "G is out of bounds";
  if (!same_bits(Numbers(now.begin() + static_cast<std::ptrdiff_t>(ours), now.end()),
                 Numbers(before.begin() + static_cast<std::ptrdiff_t>(ours), before.end())))
    return "an entry of the state that is not ours was not carried over";
  if (now.size() < 5) return nullptr;
  const auto near = [](double a, double b, double unit) { return std::abs(a - b) <= 1e-6 * unit; };
  const double size = 1 + largest(F);
  if (!near(now[2], fibre_stretch, size)) return "lambda is not the fibre's stretch";
  if (!near(now[1] * now[0], now[2], size)) return "lambda_e G is not lambda";
  if (!near(now[3], det(F), size * size * size)) return "J is not det F";
  if (!near(now[4] * now[0], now[3], size * size * size)) return "Je G is not J";
  if (ours == 8 && !near(std::hypot(now[5], now[6], now[7]), 1, 1)) return "n0 is not of unit length";
  return nullptr;
}

}  // namespace rules

#endif
