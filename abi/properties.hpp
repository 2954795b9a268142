/// @file
/// PROPS and STATEV of the UMAT: one table each, for the checks, the messages and the manual.
#ifndef MYOGROWTH_ABI_PROPERTIES_HPP
#define MYOGROWTH_ABI_PROPERTIES_HPP

#include <cstring>
#include <myogrowth/kernel.hpp>
#include <utility>

namespace myogrowth {
namespace abi {

// What a value must be: name, words, and the check of a finite x among the entries `all` of its table.
#define MYOGROWTH_ALLOWED(X)                                                                            \
  X(positive, "> 0", x > 0)                                                                             \
  X(not_negative, ">= 0", x >= 0)                                                                       \
  X(above_one, "> 1", x > 1)                                                                            \
  /* a bad c2 is reported as such */                                                                    \
  X(bulk_positive, "> -2/3 c2 (positive bulk modulus)", x >= 0 || !(all[1] > 0) || x > -2 * all[1] / 3) \
  X(any, "finite", true)                                                                                \
  X(zero_or_one, "0 or 1", x == 0 || x == 1)                                                            \
  X(below_one, "> 0 and < 1", x > 0 && x < 1)                                                           \
  X(up_to_lambda_crit, "> 0 and <= lambda_crit", x > 0 && x <= all[5])                                  \
  X(up_to_one, ">= 0 and <= 1", x >= 0 && x <= 1)                                                       \
  X(above_lambda_min, "> lambda_min", x > all[6]) /* of law 3's entries */

/// The names.
#define MYOGROWTH_ROW(name, words, check) name,
enum class Allowed { MYOGROWTH_ALLOWED(MYOGROWTH_ROW) };
#undef MYOGROWTH_ROW

/// What is allowed, in words.
#define MYOGROWTH_ROW(name, words, check) words,
inline const char* text(Allowed allowed) {
  static constexpr const char* words[] = {MYOGROWTH_ALLOWED(MYOGROWTH_ROW)};
  return words[static_cast<int>(allowed)];
}
#undef MYOGROWTH_ROW

/// Whether `x`, a finite number, is allowed among the others.
#define MYOGROWTH_ROW(name, words, check) \
  case Allowed::name:                     \
    return check;
inline bool is_in_range(Allowed allowed, double x, const double* all) {
  switch (allowed) { MYOGROWTH_ALLOWED(MYOGROWTH_ROW) }
  return false;
}
#undef MYOGROWTH_ROW

/// One entry of PROPS.
struct Property {
  const char* symbol;
  const char* unit;
  const char* meaning;
  double initial;  ///< taken when PROPS ends before this entry
  Allowed allowed;
};

/// One entry of STATEV.
struct StateVariable {
  const char* symbol;
  const char* meaning;
};

constexpr int n_props = 18;        ///< entries that mean something
constexpr int n_props_plain = 9;   ///< entries before the options, all of which are off (0) by default
constexpr int energy_entry = 10;   ///< index of energy in PROPS: the first of the options but for the frame
constexpr int tau_rev_entry = 13;  ///< index of tau_rev in PROPS: the first of removal's
constexpr int hybrid_entry = 17;  ///< index of hybrid in PROPS: what is before it, from tau_rev, is removal's
constexpr int law_entry = n_props;    ///< index of the elastic law in PROPS: elastic_laws.hpp
constexpr int n_props_required = 6;   ///< entries that have no default
constexpr int n_statev = 9;           ///< entries that the UMAT keeps, as far as NSTATV has room
constexpr int stretch_entry = 2;      ///< index of lambda in STATEV
constexpr int fibre_entry = 5;        ///< index of the first of the fibre's three in STATEV
constexpr int thickness_entry = 8;    ///< index of the thickness stretch in STATEV
constexpr int n_statev_required = 1;  ///< G has to be remembered

// The rows of PROPS: symbol, unit, meaning, what is taken when PROPS ends before it, what is allowed. (Lists
// of macros, since MGIS wants symbols of these names: mgis_symbols.cpp.)
#define MYOGROWTH_PROPS_OF_EQ_3(X)                         \
  X(c1, "stress", "first Lame constant", 0, bulk_positive) \
  X(c2, "stress", "second Lame constant (shear modulus)", 0, positive)
#define MYOGROWTH_PROPS_OF_GROWTH(X)                                                         \
  X(tau, "time", "time constant of growth", 0, positive)                                     \
  X(gamma, "-", "shape exponent of the adaptation function", 0, not_negative)                \
  X(G_max, "-", "largest relative serial sarcomere number", 0, above_one)                    \
  X(lambda_crit, "-", "elastic fibre stretch above which sarcomeres are added", 0, positive) \
  X(n0_1, "-", "fibre direction n0, reference configuration; any length > 0", 1, any)        \
  X(n0_2, "-", "(second component)", 0, any)                                                 \
  X(n0_3, "-", "(third component)", 0, any)
#define MYOGROWTH_PROPS_OF_FRAME(X) \
  X(frame, "-", "0: DFGRD1 is F in fixed axes; 1: local basis, F := sqrt(DFGRD1 DFGRD1^T)", 0, zero_or_one)
#define MYOGROWTH_PROPS_OF_STEP(X)                                                                           \
  X(energy, "-", "psi per unit 0: reference volume, 1: grown volume", 0, zero_or_one)                        \
  X(integration, "-", "of eq. 4 in time 0: backward Euler, 1: second order (flow at mid-step stretch)", 0,   \
    zero_or_one)                                                                                             \
  X(tolerance, "-", "of the time error of G in a step, for advice by PNEWDT; 0: no advice", 0, not_negative) \
  X(tau_rev, "time",                                                                                         \
    "time constant of removal; 0: nothing is removed, and gamma_rev, G_min, lambda_crit_rev are not used",   \
    0, not_negative)                                                                                         \
  X(gamma_rev, "-", "shape exponent of removal; required if tau_rev > 0", 0, not_negative)                   \
  X(G_min, "-", "smallest relative serial sarcomere number; required if tau_rev > 0", 0, below_one)          \
  X(lambda_crit_rev, "-",                                                                                    \
    "elastic fibre stretch below which sarcomeres are removed; required if tau_rev > 0", 0,                  \
    up_to_lambda_crit)
#define MYOGROWTH_PROPS_OF_ELEMENT(X) \
  X(hybrid, "-", "1: mixed elements of Abaqus/Standard, with HYBRID FORMULATION=TOTAL", 0, zero_or_one)

/// The tables; a template so that they are one in a program, also in C++14.
template <class Unused = void>
struct Tables {
#define MYOGROWTH_ROW(symbol, unit, meaning, initial, allowed) \
  {#symbol, unit, meaning, initial, Allowed::allowed},
  static constexpr Property property[n_props] = {
      MYOGROWTH_PROPS_OF_EQ_3(MYOGROWTH_ROW) MYOGROWTH_PROPS_OF_GROWTH(MYOGROWTH_ROW)
          MYOGROWTH_PROPS_OF_FRAME(MYOGROWTH_ROW) MYOGROWTH_PROPS_OF_STEP(MYOGROWTH_ROW)
              MYOGROWTH_PROPS_OF_ELEMENT(MYOGROWTH_ROW)};
#undef MYOGROWTH_ROW
  static constexpr StateVariable state_variable[n_statev] = {
      {"G", "relative serial sarcomere number; 0 on entry: not initialised, taken as 1"},
      {"lambda_e", "elastic fibre stretch lambda/G (relative sarcomere length)"},
      {"lambda", "total fibre stretch"},
      {"J", "det F, volume ratio"},
      {"Je", "J/G, elastic volume ratio"},
      {"n0_1", "reference fibre direction at this point; if not zero on entry it overrides PROPS(7:9)"},
      {"n0_2", "(second component)"},
      {"n0_3", "(third component)"},
      {"F33", "thickness stretch, with plane stress only (NTENS = 3); 0 on entry: not initialised"},
  };
};
template <class Unused>
constexpr Property Tables<Unused>::property[n_props];
template <class Unused>
constexpr StateVariable Tables<Unused>::state_variable[n_statev];

/// Entry i < n_props of PROPS.
inline const Property& property(int i) noexcept { return Tables<>::property[i]; }

/// Entry i < n_statev of STATEV.
inline const StateVariable& state_variable(int i) noexcept { return Tables<>::state_variable[i]; }

/// Index in PROPS of the entry of that symbol; -1 if there is none.
inline int find_property(const char* symbol) {
  for (int i = 0; i < n_props; ++i) {
    if (std::strcmp(symbol, property(i).symbol) == 0) return i;
  }
  return -1;
}

/// PROPS in the kernel's terms.
struct Properties {
  FibreGrowth<double> material;
  double n0[3];
  bool local_basis;
  double tolerance;  ///< of the time error in G; 0: no advice on the next step
  bool hybrid;       ///< STRESS is three entries longer
};

/// What entry i must be among the others: where nothing is removed, removal's entries are not used.
constexpr Allowed allowed(int i, const double* p) {
  return i > tau_rev_entry && i < hybrid_entry && p[tau_rev_entry] == 0 ? Allowed::any
                                                                        : Tables<>::property[i].allowed;
}

inline bool is_allowed(int i, const double* p) {
  return is_finite(p[i]) && is_in_range(allowed(i, p), p[i], p);
}

/// Whether the first entries are allowed, and their sum finite; entry by entry at compile time and without a
/// branch, since every call of every point asks.
template <int... i>
bool all_allowed(const double* p, std::integer_sequence<int, i...>) {
  bool all = true;
  double sum = 0;
  const bool each[] = {(sum += p[i], all &= is_in_range(allowed(i, p), p[i], p))...};
  (void)each;
  return all & is_finite(sum);
}

inline void take_plain(const double* p, Properties& out) {
  out.material.c1 = p[0];
  out.material.c2 = p[1];
  out.material.growth = GrowthRate<double>{p[2], p[3], p[4], p[5]};
  for (int i = 0; i < 3; ++i) out.n0[i] = p[6 + i];
}

/// Index of the first entry that is not allowed; -1 if all are.
inline int find_bad_entry(const double (&p)[n_props]) {
  for (int i = 0; i < n_props; ++i) {
    if (!is_allowed(i, p)) return i;
  }
  return -1;
}

/// The material's parameter that entry i of PROPS sets; null where that entry is an option or n0.
inline double* parameter(FibreGrowth<double>& m, int i) {
  double* const of_muscle[] = {&m.c1,           &m.c2,           &m.growth.tau,
                               &m.growth.gamma, &m.growth.G_max, &m.growth.lambda_crit};
  double* const of_removal[] = {&m.removal.tau_rev, &m.removal.gamma_rev, &m.removal.G_min,
                                &m.removal.lambda_crit_rev};
  if (0 <= i && i < n_props_required) return of_muscle[i];
  if (tau_rev_entry <= i && i < hybrid_entry) return of_removal[i - tau_rev_entry];
  return nullptr;
}

/// PROPS of a material, for those who have no PROPS and want its checks; what is not the material's takes its
/// default.
inline void write(const FibreGrowth<double>& material, double (&p)[n_props]) {
  FibreGrowth<double> m = material;
  for (int i = 0; i < n_props; ++i) p[i] = parameter(m, i) ? *parameter(m, i) : property(i).initial;
  p[energy_entry] = m.energy == EnergyPer::grown_volume;
  p[11] = m.integration == TimeIntegration::midpoint_flow;
}

/// Reads PROPS that end before the options. False if one is not allowed.
inline bool read_plain(const double (&p)[n_props_plain], Properties& out) {
  take_plain(p, out);
  out.local_basis = out.hybrid = false;
  out.tolerance = 0;
  return all_allowed(p, std::make_integer_sequence<int, n_props_plain>());
}

/// Takes all of PROPS, found to be allowed.
inline void take(const double (&p)[n_props], Properties& out) {
  take_plain(p, out);
  out.local_basis = p[9] != 0;
  out.material.integration = p[11] != 0 ? TimeIntegration::midpoint_flow : TimeIntegration::backward_euler;
  out.tolerance = p[12];
  out.hybrid = p[hybrid_entry] != 0;
  if (p[tau_rev_entry] > 0) out.material.removal = RemovalRate<double>{p[13], p[14], p[15], p[16]};
  out.material.energy = p[energy_entry] != 0 ? EnergyPer::grown_volume : EnergyPer::reference_volume;
}

/// Reads PROPS, all of it. Returns the index of the first entry that is not allowed, or -1 if all are.
inline int read(const double (&p)[n_props], Properties& out) {
  if (!all_allowed(p, std::make_integer_sequence<int, n_props>())) {
    const int bad = find_bad_entry(p);
    if (bad >= 0) return bad;  // else the sum only is not finite
  }
  take(p, out);
  return -1;
}

}  // namespace abi
}  // namespace myogrowth

#endif
