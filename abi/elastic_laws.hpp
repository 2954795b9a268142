/// @file
/// PROPS(19:31): the elastic laws other than eq. 3, their table of parameters, and what reads them.
///
/// PROPS(19) = 0 or none: eq. 3, and nothing of this file is used. Hosts that do not include it refuse any
/// other number (faults.hpp).
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

/// The law's place in the lists below.
enum class Law { roehrle = 1, blemker, ehret };

/// A law's parameters, in the order of PROPS.
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
       {{"c10", "stress", "matrix", 10, Allowed::positive},
        {"c01", "stress", "matrix, second invariant", 10, Allowed::not_negative},
        {"kappa", "stress", "resistance to volume change", 1000, Allowed::positive},
        {"sigma_p", "stress", "passive fibre stress", 300, Allowed::not_negative},
        {"sigma_a", "stress", "active fibre stress at the optimum", 300, Allowed::not_negative},
        {"lambda_opt", "-", "optimum elastic stretch; below 1 the fibre is tense at rest", 1.4,
         Allowed::positive},
        {"g1", "-", "passive curve", 0.05, Allowed::not_negative},
        {"g2", "-", "passive curve, exponent", 6.6, Allowed::positive}}},
      {"Blemker",
       11,
       {{"G1", "stress", "shear along the fibre", 0.5, Allowed::positive},
        {"G2", "stress", "shear across the fibre", 0.5, Allowed::positive},
        {"kappa", "stress", "resistance to volume change", 1000, Allowed::positive},
        {"sigma_max", "stress", "largest isometric stress of muscle", 300, Allowed::not_negative},
        {"lambda_opt", "-", "optimum elastic stretch; below 1 the fibre is tense at rest", 1.4,
         Allowed::positive},
        {"P1", "-", "passive curve of muscle", 0.05, Allowed::not_negative},
        {"P2", "-", "passive curve of muscle, exponent", 6.6, Allowed::positive},
        {"lambda_star", "-", "end of the exponential (muscle: of lambda_e/lambda_opt; tendon: 1.03)", 1.4,
         Allowed::above_one},
        {"tendon", "-", "0: muscle, 1: tendon or aponeurosis, never active", 0, Allowed::zero_or_one},
        {"L1", "stress", "fibre stress of tendon", 2700, Allowed::not_negative},
        {"L2", "-", "fibre stress of tendon, exponent", 46.4, Allowed::positive}}},
      {"Ehret",
       8,
       {{"alpha", "-", "exponent of the stretches", 19.69, Allowed::positive},
        {"beta", "-", "exponent of the areas", 1.19, Allowed::positive},
        {"gamma_e", "stress", "stiffness", 0.1599, Allowed::positive},
        {"kappa", "-", "resistance to volume change, exponent", 100, Allowed::positive},
        {"w0", "-", "weight of the isotropic part", 0.7388, Allowed::up_to_one},
        {"P_opt", "stress", "active stress", 73.52, Allowed::not_negative},
        {"lambda_min", "-", "elastic stretch below which nothing is active", 0.682, Allowed::positive},
        {"lambda_opt", "-", "optimum elastic stretch", 1.192, Allowed::above_lambda_min}}},
  };
};
template <class Unused>
constexpr LawParameters LawTables<Unused>::law[n_laws];

/// The table of law 1, 2 or 3.
inline const LawParameters& parameters_of(Law law) { return LawTables<>::law[static_cast<int>(law) - 1]; }

/// Whether PROPS ask for one of them, or for something that is no law.
inline bool asks_for_law(const double* props, int nprops) {
  return nprops > law_entry && props[law_entry] != 0;
}

/// What PROPS(19:) say.
struct LawChoice {
  Law law;
  double activation;
  double p[most_law_parameters];
};

/// Reads all PROPS where they ask for a law. predef, dpred: field variable 1 and its increment, read only
/// where PROPS(20) = -1; null where a host has none. True, and the text, if an entry is not allowed.
inline bool find_law_fault(const double* props, int nprops, const double* predef, const double* dpred,
                           Properties& properties, LawChoice& choice, Text& text) {
  char place[24];
  const double number = props[law_entry];
  if (!(number == 1 || number == 2 || number == 3)) {
    return tell(
        text,
        "PROPS(%d) = %.9g: elastic law, must be 0 (neo-Hookean), 1 (Roehrle), 2 (Blemker) or 3 (Ehret).",
        law_entry + 1, number);
  }
  // The entries of all laws. c1 and c2 are those of eq. 3; a number there would be dropped without a word.
  double common[n_props];
  for (int i = 0; i < n_props; ++i) common[i] = props[i];
  for (int i = 0; i < 2; ++i) {
    if (props[i] != 0) {
      return tell(text, "PROPS(%d) = %.9g: %s is a constant of elastic law 0, must be 0 with PROPS(%d) = %g.",
                  i + 1, props[i], property(i).symbol, law_entry + 1, number);
    }
    common[i] = 1;
  }
  if (find_props_fault(common, n_props, properties, text)) return true;

  choice.law = static_cast<Law>(static_cast<int>(number));
  const double given = nprops > activation_entry ? props[activation_entry] : 0;
  if (given == from_field && !(predef && dpred)) {
    return tell(text, "PROPS(%d) = -1: this host has no field variables; activation must be >= 0 and <= 1.",
                activation_entry + 1);
  }
  const double field = given == from_field ? *predef + *dpred : 0;
  choice.activation = given == from_field ? field : given;
  const double least = -tolerance_of_activation, most = 1 + tolerance_of_activation;
  if (!(least <= choice.activation && choice.activation <= most)) {
    if (given == from_field) {
      return tell(text, "PROPS(%d) = -1, field variable 1 = %.9g: activation, must be >= 0 and <= 1.",
                  activation_entry + 1, field);
    }
    return tell(text, "PROPS(%d) = %.9g: activation, must be >= 0 and <= 1, or -1 for field variable 1.",
                activation_entry + 1, given);
  }
  choice.activation = choice.activation < 0 ? 0 : choice.activation > 1 ? 1 : choice.activation;

  const LawParameters& table = parameters_of(choice.law);
  for (int i = 0; i < table.size; ++i) {
    const int entry = first_law_parameter + i;
    choice.p[i] = entry < nprops ? props[entry] : table.entry[i].initial;
    if (!is_finite(choice.p[i]) || !is_in_range(table.entry[i].allowed, choice.p[i], choice.p)) {
      std::snprintf(place, sizeof place, "PROPS(%d)", entry + 1);
      return tell_bad_entry(table.entry[i], choice.p[i], text, place);
    }
  }
  for (int i = first_law_parameter + table.size; i < nprops; ++i) {
    if (props[i] != 0) {
      return tell(
          text,
          "PROPS(%d) = %.9g: elastic law %g (%s) has %d parameters, PROPS(%d:%d); further ones must be 0.",
          i + 1, props[i], number, table.name, table.size, first_law_parameter + 1,
          first_law_parameter + table.size);
    }
  }
  return false;
}

/// The laws from their entries.
/// @{
inline Roehrle<> roehrle_of(const double* p) { return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]}; }
inline Blemker<> blemker_of(const double* p) {
  return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8] != 0, p[9], p[10]};
}
inline Ehret<> ehret_of(const double* p) { return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]}; }
/// @}

/// The material with that law: all else is that of PROPS(3:18).
template <class Elastic>
FibreGrowthOf<Elastic> with_law(const Elastic& law, const FibreGrowth<double>& m) {
  return {law, m.growth, m.removal, m.energy, m.integration};
}

/// Calls use(material, activation) with the material of the law that was chosen.
template <class Use>
void with_chosen_law(const LawChoice& choice, const FibreGrowth<double>& m, const Use& use) {
  if (choice.law == Law::roehrle) {
    use(with_law(roehrle_of(choice.p), m), choice.activation);
  } else if (choice.law == Law::blemker) {
    use(with_law(blemker_of(choice.p), m), choice.activation);
  } else {
    use(with_law(ehret_of(choice.p), m), choice.activation);
  }
}

}  // namespace abi
}  // namespace myogrowth

#endif
