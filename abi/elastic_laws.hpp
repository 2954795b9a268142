/// @file
/// PROPS(19:31): the elastic laws other than eq. 3, their table of parameters, and what reads them.
///
/// This is the one place where they are read and checked, for all hosts. PROPS(19) = 0 or none: eq. 3.
#ifndef MYOGROWTH_ABI_ELASTIC_LAWS_HPP
#define MYOGROWTH_ABI_ELASTIC_LAWS_HPP

#include <myogrowth/elastic/blemker.hpp>
#include <myogrowth/elastic/ehret.hpp>
#include <myogrowth/elastic/fibre_growth_of.hpp>
#include <myogrowth/elastic/roehrle.hpp>

#include "faults.hpp"

namespace myogrowth {
namespace abi {

constexpr int activation_entry = law_entry + 1;     ///< index of the activation in PROPS
constexpr int first_law_parameter = law_entry + 2;  ///< index of a law's first parameter
constexpr int most_law_parameters = 11;             ///< of law 2
constexpr int n_laws = 3;                           ///< laws 1 to 3
constexpr double from_field = -1;                   ///< activation: field variable 1
constexpr double tolerance_of_activation = 1e-9;    ///< what a host's sums may leave beyond 0 and 1

/// PROPS(19).
enum class Law { neo_hookean, roehrle, blemker, ehret };

/// A law's parameters, in the order of PROPS; defaults are those of the law itself.
struct LawParameters {
  const char* name;
  int size;
  Property entry[most_law_parameters];
};

template <class Unused = void>
struct LawTables {
  static constexpr LawParameters law[n_laws] = {
      {"Roehrle",
       8,
       {{"c10", "stress", "matrix", Roehrle<>().c10, Allowed::positive},
        {"c01", "stress", "matrix, second invariant", Roehrle<>().c01, Allowed::not_negative},
        {"kappa", "stress", "resistance to volume change", Roehrle<>().kappa, Allowed::positive},
        {"sigma_p", "stress", "passive fibre stress", Roehrle<>().sigma_p, Allowed::not_negative},
        {"sigma_a", "stress", "active fibre stress at the optimum", Roehrle<>().sigma_a,
         Allowed::not_negative},
        {"lambda_opt", "-", "optimum elastic stretch; below 1 the fibre is tense at rest",
         Roehrle<>().lambda_opt, Allowed::positive},
        {"g1", "-", "passive curve", Roehrle<>().g1, Allowed::not_negative},
        {"g2", "-", "passive curve, exponent", Roehrle<>().g2, Allowed::positive}}},
      {"Blemker",
       11,
       {{"G1", "stress", "shear along the fibre; tendon: 50", Blemker<>().G1, Allowed::positive},
        {"G2", "stress", "shear across the fibre; tendon: 50", Blemker<>().G2, Allowed::positive},
        {"kappa", "stress", "resistance to volume change", Blemker<>().kappa, Allowed::positive},
        {"sigma_max", "stress", "largest isometric stress of muscle", Blemker<>().sigma_max,
         Allowed::not_negative},
        {"lambda_opt", "-", "optimum elastic stretch; below 1 the fibre is tense at rest",
         Blemker<>().lambda_opt, Allowed::positive},
        {"P1", "-", "passive curve of muscle", Blemker<>().P1, Allowed::not_negative},
        {"P2", "-", "passive curve of muscle, exponent", Blemker<>().P2, Allowed::positive},
        {"lambda_star", "-", "end of the exponential (muscle: of lambda_e/lambda_opt; tendon: 1.03)",
         Blemker<>().lambda_star, Allowed::above_one},
        {"tendon", "-", "0: muscle, 1: tendon or aponeurosis, never active", Blemker<>().tendon,
         Allowed::zero_or_one},
        {"L1", "stress", "fibre stress of tendon", Blemker<>().L1, Allowed::not_negative},
        {"L2", "-", "fibre stress of tendon, exponent", Blemker<>().L2, Allowed::positive}}},
      {"Ehret",
       8,
       {{"alpha", "-", "exponent of the stretches", Ehret<>().alpha, Allowed::positive},
        {"beta", "-", "exponent of the areas", Ehret<>().beta, Allowed::positive},
        {"gamma_e", "stress", "stiffness", Ehret<>().gamma, Allowed::positive},
        {"kappa", "-", "resistance to volume change, exponent", Ehret<>().kappa, Allowed::positive},
        {"w0", "-", "weight of the isotropic part", Ehret<>().w0, Allowed::up_to_one},
        {"P_opt", "stress", "active stress", Ehret<>().P_opt, Allowed::not_negative},
        {"lambda_min", "-", "elastic stretch below which nothing is active", Ehret<>().lambda_min,
         Allowed::positive},
        {"lambda_opt", "-", "optimum elastic stretch", Ehret<>().lambda_opt, Allowed::above_lambda_min}}},
  };
};
template <class Unused>
constexpr LawParameters LawTables<Unused>::law[n_laws];

/// The table of law 1, 2 or 3.
inline const LawParameters& parameters_of(Law law) { return LawTables<>::law[static_cast<int>(law) - 1]; }

/// Whether PROPS ask for one of them, or for something that is no law.
template <class R>
bool asks_for_law(const R* props, int nprops) {
  return nprops > law_entry && props[law_entry] != 0;
}

/// Whether the activation is to be field variable 1.
template <class R>
bool reads_field(const R* props, int nprops) {
  return asks_for_law(props, nprops) && nprops > activation_entry &&
         static_cast<double>(props[activation_entry]) == from_field;
}

/// What PROPS(19:) say.
struct LawChoice {
  Law law;
  bool by_field;  ///< the activation is that of field variable 1, which the host has to take
  double activation;
  double p[most_law_parameters];
};

/// Takes an activation; false if it is not allowed. R: the numbers of the host, which may have rounded it.
template <class R>
bool take_activation(R given, LawChoice& choice) {
  const double a = static_cast<double>(given), rounding = 4 * std::numeric_limits<R>::epsilon(),
               most = rounding > tolerance_of_activation ? rounding : tolerance_of_activation;
  choice.activation = a < 0 ? 0 : a > 1 ? 1 : a;
  return -most <= a && a <= 1 + most;
}

/// Takes field variable 1 where PROPS(20) = -1. True, and the text, if it is not allowed.
template <class R>
bool find_field_fault(R field, LawChoice& choice, Text& text) {
  return !take_activation(field, choice) &&
         tell(text, "PROPS(%d) = -1, field variable 1 = %.*g: activation, must be >= 0 and <= 1.",
              activation_entry + 1, digits<R>(), static_cast<double>(field));
}

/// Reads the n parameters that are given; a missing one has its published default. True, and the text, if one
/// is not allowed. It goes by its place in PROPS where parameters begin at `first` there, by its symbol where
/// first is 0.
template <class R>
bool find_parameter_fault(const R* given, int n, int first, LawChoice& choice, Text& text) {
  const LawParameters& table = parameters_of(choice.law);
  for (int i = 0; i < table.size; ++i) {
    const Property& entry = table.entry[i];
    choice.p[i] = i < n ? static_cast<double>(given[i]) : entry.initial;
    if (is_finite(choice.p[i]) && is_in_range(entry.allowed, choice.p[i], choice.p)) continue;
    char place[24];
    std::snprintf(place, sizeof place, "PROPS(%d)", first + i + 1);
    return tell_bad_entry(entry, choice.p[i], text, first > 0 ? place : nullptr, digits<R>());
  }
  for (int i = table.size; i < n; ++i) {
    if (given[i] != 0) {
      return tell(
          text,
          "PROPS(%d) = %.*g: elastic law %d (%s) has %d parameters, PROPS(%d:%d); further ones must be 0.",
          first + i + 1, digits<R>(), static_cast<double>(given[i]), static_cast<int>(choice.law), table.name,
          table.size, first + 1, first + table.size);
    }
  }
  return false;
}

/// Reads all PROPS where they ask for a law. has_fields: whether the host has field variables. True, and the
/// text, if an entry is not allowed.
template <class R>
bool find_law_fault(const R* props, int nprops, bool has_fields, Properties& properties, LawChoice& choice,
                    Text& text) {
  const double number = static_cast<double>(props[law_entry]);
  if (!(number == 1 || number == 2 || number == 3)) {
    return tell(
        text,
        "PROPS(%d) = %.9g: elastic law, must be 0 (neo-Hookean), 1 (Roehrle), 2 (Blemker) or 3 (Ehret).",
        law_entry + 1, number);
  }
  // The entries of all laws. c1 and c2 are those of eq. 3; a number there would be dropped without a word.
  R common[n_props];
  for (int i = 0; i < n_props; ++i) common[i] = props[i];
  for (int i = 0; i < 2; ++i) {
    if (props[i] != 0) {
      return tell(text, "PROPS(%d) = %.9g: %s is a constant of elastic law 0, must be 0 with PROPS(%d) = %g.",
                  i + 1, static_cast<double>(props[i]), property(i).symbol, law_entry + 1, number);
    }
    common[i] = 1;
  }
  if (find_props_fault(common, n_props, properties, text)) return true;

  choice.law = static_cast<Law>(static_cast<int>(number));
  const R given = nprops > activation_entry ? props[activation_entry] : R(0);
  choice.by_field = reads_field(props, nprops);
  if (choice.by_field && !has_fields) {
    return tell(text, "PROPS(%d) = -1: this host has no field variables; activation must be >= 0 and <= 1.",
                activation_entry + 1);
  }
  if (!choice.by_field && !take_activation(given, choice)) {
    return tell(text, "PROPS(%d) = %.*g: activation, must be >= 0 and <= 1%s.", activation_entry + 1,
                digits<R>(), static_cast<double>(given), has_fields ? ", or -1 for field variable 1" : "");
  }
  const int n_given = nprops > first_law_parameter ? nprops - first_law_parameter : 0;
  return find_parameter_fault(props + nprops - n_given, n_given, first_law_parameter, choice, text);
}

/// Reads all PROPS, whatever the law. True, and the text, if an entry is not allowed.
template <class R>
bool find_muscle_fault(const R* props, int nprops, bool has_fields, Properties& properties, LawChoice& choice,
                       Text& text) {
  choice = LawChoice{};
  return asks_for_law(props, nprops) ? find_law_fault(props, nprops, has_fields, properties, choice, text)
                                     : find_props_fault(props, nprops, properties, text);
}

/// Reads all PROPS and checks the length of STATEV for a host without mixed elements: `where` and `name` as
/// find_hybrid_fault and find_room_fault have them.
template <class R>
bool find_call_fault(const char* where, const char* name, const R* props, int nprops, bool has_fields,
                     int nstatev, Properties& properties, LawChoice& choice, Text& text) {
  return find_muscle_fault(props, nprops, has_fields, properties, choice, text) ||
         find_hybrid_fault(where, properties, text) || find_room_fault(name, nstatev, text) ||
         find_stretch_fault(name, nstatev, properties, text);
}

/// The laws from their entries, and the entries of law 2 from the law.
/// @{
inline Roehrle<> roehrle_of(const double* p) { return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]}; }
inline Blemker<> blemker_of(const double* p) {
  return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8] != 0, p[9], p[10]};
}
inline void write(const Blemker<>& law, double (&p)[most_law_parameters]) {
  const double entries[] = {law.G1, law.G2, law.kappa,       law.sigma_max,       law.lambda_opt,
                            law.P1, law.P2, law.lambda_star, law.tendon ? 1 : 0., law.L1,
                            law.L2};
  for (int i = 0; i < most_law_parameters; ++i) p[i] = entries[i];
}
inline Ehret<> ehret_of(const double* p) { return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]}; }
/// @}

/// The published value of parameter i; of law 2 that for tendon, on request.
inline double default_of(Law law, int i, bool tendon) {
  if (!tendon || law != Law::blemker) return parameters_of(law).entry[i].initial;
  double values[most_law_parameters];
  write(Blemker<>::of_tendon(), values);
  return values[i];
}

/// The material with that law: all else is that of PROPS(3:18).
template <class Elastic>
FibreGrowthOf<Elastic> with_law(const Elastic& law, const FibreGrowth<double>& m) {
  return {law, m.growth, m.removal, m.energy, m.integration};
}

/// What use(u, material, activation) gives for the material of the law that was chosen, of 1 to 3, with u
/// what its update_point fills.
template <class Use>
UpdateStatus with_other_law(const FibreGrowth<double>& m, const LawChoice& choice, const Use& use) {
  ElasticPointUpdate<double> u;
  if (choice.law == Law::roehrle) return use(u, with_law(roehrle_of(choice.p), m), choice.activation);
  if (choice.law == Law::blemker) return use(u, with_law(blemker_of(choice.p), m), choice.activation);
  return use(u, with_law(ehret_of(choice.p), m), choice.activation);
}

/// The same with any law; use(u, material) for eq. 3.
template <class Use>
UpdateStatus with_material(const FibreGrowth<double>& m, const LawChoice& choice, const Use& use) {
  if (choice.law != Law::neo_hookean) return with_other_law(m, choice, use);
  PointUpdate<double> u;
  return use(u, m);
}

}  // namespace abi
}  // namespace myogrowth

#endif
