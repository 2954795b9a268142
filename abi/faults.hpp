/// @file
/// What can be wrong with the arguments of a host, found and told in the same words by every routine.
#ifndef MYOGROWTH_ABI_FAULTS_HPP
#define MYOGROWTH_ABI_FAULTS_HPP

#include <cstdarg>
#include <cstdio>
#include <limits>

#include "properties.hpp"

namespace myogrowth {
namespace abi {

/// One line that names an entry, its value and what is allowed. No % in it: Abaqus would look for an
/// argument.
using Text = char[400];

#if defined(__GNUC__)
#define MYOGROWTH_LIKE_PRINTF __attribute__((format(printf, 2, 3)))  // the compiler checks the arguments
#else
#define MYOGROWTH_LIKE_PRINTF
#endif

/// Why the kernel gave no result.
inline const char* text(UpdateStatus status) {
  static constexpr const char* texts[] = {
      "ok",
      "not finite: F, dt or a result is NaN or beyond the range of double",
      "inverted: det F must be > 0",
      "no fibre: n0 must have a length > 0",
      "bad state: G must be >= 0, and G and the fibre finite",
      "unknown status",  // 5 and 6 are myogrowth.h's
      "unknown status",
      "not converged: the stretch that frees the stress was not found in 200 iterations"};
  const int i = static_cast<int>(status), last = static_cast<int>(UpdateStatus::not_converged);
  return 0 <= i && i <= last ? texts[i] : "unknown status";
}

/// Formats like printf, cut to the room there is. Always true: "there is a fault".
MYOGROWTH_LIKE_PRINTF inline bool tell(Text& text, const char* format, ...) {
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return true;
}

/// What may be written of a number: 9 digits, fewer if the host's numbers have fewer.
template <class R>
constexpr int digits() {
  return std::numeric_limits<R>::digits10 < 9 ? std::numeric_limits<R>::digits10 : 9;
}

/// Says that x is not allowed for entry i of PROPS, which goes by its symbol, "G_max = 0.9: ...", or by a
/// place, "PROPS(5) = 0.9: G_max, ...".
inline bool tell_bad_entry(const Property& p, double x, Text& text, const char* place = nullptr,
                           int n_digits = digits<double>()) {
  const bool any = p.allowed == Allowed::any;
  return tell(text, "%s = %.*g: %s%s%s, must be finite%s%s.", place ? place : p.symbol, n_digits, x,
              place ? p.symbol : "", place ? ", " : "", p.meaning, any ? "" : " and ",
              any ? "" : abi::text(p.allowed));
}
inline bool tell_bad_entry(int i, double x, Text& text, const char* place = nullptr,
                           int n_digits = digits<double>()) {
  return tell_bad_entry(property(i), x, text, place, n_digits);
}

/// True, and the text, if the material may not have x as its parameter of entry i: for readers that take one
/// parameter at a time. Removal's are checked whether or not it is on.
inline bool find_value_fault(const FibreGrowth<double>& material, int i, double x, Text& text) {
  double p[n_props];
  write(material, p);
  p[i] = x;
  return !(is_finite(x) && is_in_range(property(i).allowed, x, p)) && tell_bad_entry(i, x, text);
}

/// True, and the text, if a parameter of the material is not allowed: the same check in the same words for
/// programs that have no PROPS.
inline bool find_material_fault(const FibreGrowth<double>& material, Text& text) {
  double p[n_props];
  write(material, p);
  const int bad = find_bad_entry(p);
  return bad >= 0 && tell_bad_entry(bad, p[bad], text);
}

/// Reads PROPS(1:nprops) with its options. True, and the text, if entries are missing or one is not allowed.
template <class R>
MYOGROWTH_NOINLINE bool find_fault_among_all(const R* props, int nprops, Properties& properties, Text& text) {
  if (nprops < n_props_required) {
    return tell(text,
                "NPROPS = %d: at least %d constants are needed: c1, c2, tau, gamma, G_max, lambda_crit.",
                nprops, n_props_required);
  }
  if (nprops > tau_rev_entry && props[tau_rev_entry] > 0 && nprops < hybrid_entry) {
    return tell(text,
                "NPROPS = %d: with PROPS(14) = tau_rev > 0, PROPS(15:17) are needed: gamma_rev, G_min, "
                "lambda_crit_rev.",
                nprops);
  }
  double known[n_props];
  for (int i = 0; i < n_props; ++i)
    known[i] = i < nprops ? static_cast<double>(props[i]) : property(i).initial;
  const int bad = read(known, properties);
  if (bad >= 0) {
    char place[24];
    std::snprintf(place, sizeof place, "PROPS(%d)", bad + 1);
    return tell_bad_entry(bad, known[bad], text, place, digits<R>());
  }
  for (int i = n_props; i < nprops; ++i) {
    if (props[i] != 0) {
      return tell(text, "PROPS(%d) = %.*g: elastic law 0 has 18 constants; further ones must be 0.", i + 1,
                  digits<R>(), static_cast<double>(props[i]));
    }
  }
  return false;
}

/// Reads PROPS(1:nprops), float or double. True, and the text, if entries are missing or one is not allowed.
template <class R>
bool find_props_fault(const R* props, int nprops, Properties& properties, Text& text) {
  if (n_props_required <= nprops && nprops <= n_props_plain) {
    double plain[n_props_plain];
    for (int i = 0; i < n_props_plain; ++i) {
      plain[i] = i < n_props_required || i < nprops ? static_cast<double>(props[i]) : property(i).initial;
    }
    if (read_plain(plain, properties)) return false;
  }
  return find_fault_among_all(props, nprops, properties, text);
}

/// True, and the text, if mixed elements are asked for where there are none. `where`: "VUMAT", ...
inline bool find_hybrid_fault(const char* where, const Properties& properties, Text& text) {
  if (!properties.hybrid) return false;
  return tell(text, "PROPS(18) = 1: hybrid must be 0 for %s; mixed elements are those of Abaqus/Standard.",
              where);
}

/// True, and the text, if there is no room for G. `name` is what the host calls the number of state
/// variables.
inline bool find_room_fault(const char* name, int nstatev, Text& text) {
  if (nstatev >= n_statev_required) return false;
  return tell(text, "%s = %d: at least %d is needed, to remember G (%d keeps all).", name, nstatev,
              n_statev_required, n_statev);
}

/// True, and the text, if the second-order step has no room to remember the stretch it starts from.
inline bool find_stretch_fault(const char* name, int nstatev, const Properties& properties, Text& text) {
  if (properties.material.integration == TimeIntegration::backward_euler || nstatev > stretch_entry)
    return false;
  return tell(text, "%s = %d: with PROPS(12) = 1 at least %d is needed, to remember lambda.", name, nstatev,
              stretch_entry + 1);
}

/// The fibre stretch at the beginning of a step, as STATEV remembers it; 1 where nothing is known yet.
inline double stretch_at_start(const double* statev, int nstatev) {
  return nstatev > stretch_entry && statev[stretch_entry] > 0 ? statev[stretch_entry] : 1;
}

/// Whether STATEV has room for the fibre, which is kept whole or not at all.
inline bool keeps_fibre(int nstatev) { return nstatev >= fibre_entry + 3; }

/// Checks what is used of STATEV(1:nstatev), nstatev >= n_statev_required, of one point on entry. Index of
/// the first entry that is not allowed: G, lambda or the fibre; -1 if all are.
inline int find_bad_state_entry(const double* statev, int nstatev, const Properties& properties) {
  const auto is_known_or_zero = [](double x) { return is_finite(x) && x >= 0; };
  if (!is_known_or_zero(statev[0])) return 0;
  const bool second_order = properties.material.integration == TimeIntegration::midpoint_flow;
  if ((second_order || properties.tolerance > 0) && nstatev > stretch_entry &&
      !is_known_or_zero(statev[stretch_entry])) {
    return stretch_entry;
  }
  const double* fibre = statev + fibre_entry;
  if (!keeps_fibre(nstatev) || is_finite(fibre[0] + fibre[1] + fibre[2])) return -1;
  for (int i = 0; i < 3; ++i) {
    if (!is_finite(fibre[i])) return fibre_entry + i;
  }
  return -1;
}

/// True, and the text, if an entry of STATEV is not allowed.
inline bool find_state_fault(const double* statev, int nstatev, const Properties& properties, Text& text) {
  const int bad = find_bad_state_entry(statev, nstatev, properties);
  if (bad < 0) return false;
  if (bad >= fibre_entry) {
    return tell(text, "STATEV(%d) = %.9g on entry: the fibre direction must be finite.", bad + 1,
                statev[bad]);
  }
  return tell(text, "STATEV(%d) = %.9g on entry: %s must be > 0, or 0 where nothing is known yet.", bad + 1,
              statev[bad], bad == 0 ? "G, the sarcomere number," : "lambda, the fibre stretch,");
}

/// Replaces n0, the fibre of PROPS, by that of STATEV if it has one. True, and the text, if there is none at
/// all.
inline bool find_fibre_fault(const double* statev, int nstatev, double (&n0)[3], Text& text) {
  if (keeps_fibre(nstatev)) {
    const double* fibre = statev + fibre_entry;
    const bool given = fibre[0] != 0 || fibre[1] != 0 || fibre[2] != 0;
    for (int i = 0; i < 3 && given; ++i) n0[i] = fibre[i];
  }
  if (n0[0] != 0 || n0[1] != 0 || n0[2] != 0) return false;
  return tell(
      text,
      "PROPS(7:9) = 0, 0, 0: n0, the fibre direction, must have a length > 0 (or give it in STATEV(6:8)).");
}

}  // namespace abi
}  // namespace myogrowth

#endif
