// Coverage-guided fuzzing of the C API under the sanitizers (clang's libFuzzer), all of it: whatever a caller
// passes, nothing crashes or is written beyond its room, the status is the one that the header promises, a
// point that fails keeps its state and its neighbours, and many points at once are each alone, bit for bit.
#include <myogrowth.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "bytes.hpp"
#include "rules.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using rules::Numbers;
constexpr double untouched = -777;

/// Which pointers are NULL.
enum Null : unsigned {
  of_tangent = 1,
  of_energy = 2,
  of_message = 4,
  of_status = 8,
  of_props = 16,
  of_F = 32,
  of_state_in = 64,
  of_state_out = 128,
  of_stress = 256,
  of_all_needed = of_props | of_F | of_state_in | of_state_out | of_stress
};

struct Call {
  Numbers props, F, state;
  int n_points = 1, n_state = 9, measure = MYOGROWTH_CAUCHY, room = 500;
  double dt = 0.1;
  unsigned null = 0;
  bool in_place = false;

  std::size_t points() const { return static_cast<std::size_t>(std::max(n_points, 0)); }
  std::size_t state_size() const { return static_cast<std::size_t>(std::max(n_state, 0)); }
  std::size_t stress_size() const {
    return measure == MYOGROWTH_CAUCHY || measure == MYOGROWTH_SECOND_PIOLA ? 6
           : measure == MYOGROWTH_FIRST_PIOLA                               ? 9
                                                                            : 0;
  }
  Call alone(std::size_t k) const;
};

/// What came back; arrays that were not asked for stay as they were.
struct Made {
  int returned = 0;
  std::vector<int> status;
  Numbers state, stress, tangent, energy;
  std::string message;
};

void print(const char* name, const Numbers& x) {
  std::fprintf(stderr, "\n%s", name);
  for (double y : x) std::fprintf(stderr, " %.17g", y);
}

void require(bool holds, const char* what, const Call& c, const Made& m) {
  if (holds) return;
  std::fprintf(stderr, "FAILED: %s\nreturned %d: %s\nn_points %d n_state %d measure %d dt %.17g NULLs %x",
               what, m.returned, m.message.c_str(), c.n_points, c.n_state, c.measure, c.dt, c.null);
  print("props", c.props);
  print("F", c.F);
  print("state_in", c.state);
  print("state_out", m.state);
  print("stress", m.stress);
  print("energy", m.energy);
  std::fprintf(stderr, "\n");
  std::abort();
}

Numbers part(const Numbers& x, std::size_t k, std::size_t size) {
  const auto begin = x.begin() + static_cast<std::ptrdiff_t>(k * size);
  return Numbers(begin, begin + static_cast<std::ptrdiff_t>(size));
}

Call Call::alone(std::size_t k) const {
  Call one = *this;
  one.n_points = 1;
  one.F = part(F, k, 9);
  one.state = part(state, k, state_size());
  return one;
}

/// A message of any room, guarded on its far side.
struct Message {
  std::vector<char> text;
  std::size_t room;
  explicit Message(int length)
      : text(static_cast<std::size_t>(std::max(length, 0)) + 8, '#'), room(text.size() - 8) {}
  /// Where it ends within its room, and nothing is written beyond; else NULL.
  const char* read() const {
    for (std::size_t i = room; i < text.size(); ++i) {
      if (text[i] != '#') return nullptr;
    }
    return room == 0 ? "" : std::memchr(text.data(), '\0', room) ? text.data() : nullptr;
  }
};

/// An empty array has a pointer too, which the sanitizer lets nobody read.
template <class T>
T* pointer(std::vector<T>& array) {
  static T* const nothing = new T[0];
  return array.empty() ? nothing : array.data();
}

/// A call of myogrowth_update for a single point, of myogrowth_update_n for many.
Made run(const Call& c, bool many) {
  const std::size_t n = c.points(), size = c.stress_size();
  Made m;
  m.status.assign(n, -1);
  m.state = c.in_place ? c.state : Numbers(c.state_size() * n, untouched);
  m.stress.assign(size * n, untouched);
  m.tangent.assign(size * size * n, untouched);
  m.energy.assign(n, untouched);
  Message message(c.room);
  const int n_props = static_cast<int>(c.props.size());
  const auto given = [&](auto& array, Null null) { return c.null & null ? nullptr : pointer(array); };
  Numbers props = c.props, F = c.F, state_in = c.state;
  double* const out = given(m.state, of_state_out);
  const double* const in = c.null & of_state_in ? nullptr
                           : c.in_place && out  ? out
                                                : given(state_in, of_state_in);
  char* const text = c.null & of_message ? nullptr : message.text.data();
  m.returned = many
                   ? myogrowth_update_n(c.n_points, given(props, of_props), n_props, given(F, of_F), in, out,
                                        c.n_state, c.dt, c.measure, given(m.stress, of_stress),
                                        given(m.tangent, of_tangent), given(m.energy, of_energy),
                                        given(m.status, of_status), text, c.room)
                   : myogrowth_update(given(props, of_props), n_props, given(F, of_F), in, out, c.n_state,
                                      c.dt, c.measure, given(m.stress, of_stress),
                                      given(m.tangent, of_tangent), given(m.energy, of_energy), text, c.room);
  const char* read = message.read();
  m.message = c.null & of_message ? "" : read ? read : "(no end)";
  require(c.null & of_message || read, "the message is not within its room", c, m);
  return m;
}

constexpr int up_to_the_law = -1;  // OK, NOT_FINITE or INVERTED

/// The status that the header promises a point that is alone.
int promised(const Call& c) {
  if (c.null & of_all_needed || c.stress_size() == 0 || c.n_state < 1) return MYOGROWTH_BAD_ARGUMENT;
  if (rules::props_are_faulty_with_laws(c.props)) return MYOGROWTH_BAD_PARAMETER;
  if (rules::has_no_room(c.props, c.state.size())) return MYOGROWTH_BAD_ARGUMENT;
  if (c.props.size() > 9 && c.props[9] != 0 && c.measure != MYOGROWTH_CAUCHY) return MYOGROWTH_BAD_PARAMETER;
  if (rules::state_is_faulty(c.props, c.state)) return MYOGROWTH_BAD_STATE;
  if (rules::has_no_fibre(c.props, c.state)) return MYOGROWTH_NO_FIBRE;
  if (!std::isfinite(c.dt) || !rules::all_finite(c.F)) return MYOGROWTH_NOT_FINITE;
  return up_to_the_law;
}

/// |F n|, or |F^T n| where the basis turns with the material: sqrt(F F^T) stretches by as much.
double fibre_stretch(const Call& c) {
  Numbers n = rules::fibre(c.props, c.state);
  const double longest = rules::largest(n);
  for (double& x : n) x /= longest;
  const double length = std::hypot(n[0], n[1], n[2]);
  for (double& x : n) x /= length;
  const bool turned = c.props.size() > 9 && c.props[9] != 0;
  const std::size_t row = turned ? 3 : 1, column = turned ? 1 : 3;
  const auto component = [&](std::size_t i) {
    return c.F[i * row] * n[0] + c.F[i * row + column] * n[1] + c.F[i * row + 2 * column] * n[2];
  };
  return std::hypot(component(0), component(1), component(2));
}

/// A point alone: c.null has the needed pointers alone.
void check_point(const Call& c, const Made& m) {
  const int expected = promised(c);
  if (expected == up_to_the_law) {
    require(
        m.returned == MYOGROWTH_OK || m.returned == MYOGROWTH_NOT_FINITE || m.returned == MYOGROWTH_INVERTED,
        "a fault was reported that is none", c, m);
    require(m.returned != MYOGROWTH_OK || !rules::is_hopeless(c.F, c.dt), "a result in spite of det F < 0", c,
            m);
    require(m.returned == MYOGROWTH_OK || !rules::is_ordinary(c.props, c.state, c.F, c.dt),
            "an ordinary point was refused", c, m);
  } else {
    require(m.returned == expected, "not the status that the header promises", c, m);
  }
  require(m.message.empty() == (m.returned == MYOGROWTH_OK), "a message for a fault, else none", c, m);

  const bool has_stress = !(c.null & of_stress);
  if (m.returned != MYOGROWTH_OK) {
    require(rules::same_bits(m.state, Numbers(m.state.size(), untouched)), "a fault touched the state", c, m);
    require(!has_stress || rules::all_nan(m.stress), "a fault, and the stress is not NaN", c, m);
    require(rules::all_nan(m.tangent), "a fault, and the tangent is not NaN", c, m);
    require(c.stress_size() == 0 ? m.energy[0] == untouched : std::isnan(m.energy[0]),
            "a fault, and the energy is not NaN", c, m);
    return;
  }
  require(rules::all_finite(m.stress) && rules::all_finite(m.tangent) && rules::all_finite(m.energy),
          "a result that is not finite", c, m);
  const char* wrong = rules::what_is_wrong(m.state, c.state, c.props, c.F, fibre_stretch(c));
  require(!wrong, wrong, c, m);
}

/// Many points are done by packs, which have a logarithm and powers of their own.
bool is_near(const Numbers& a, const Numbers& b, double scale) {
  scale = std::max(scale, rules::largest_finite(b));
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool same = a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]));
    if (!same && !(std::abs(a[i] - b[i]) <= 1e-8 * scale)) return false;
  }
  return a.size() == b.size();
}

/// Many points at once: what each gives alone, and a message about the first that fails.
void check_points(const Call& c, const Made& all) {
  int failed = 0;
  std::string first;
  const std::size_t size = c.stress_size();
  for (std::size_t k = 0; k < c.points(); ++k) {
    const Call one = c.alone(k);
    const Made m = run(one, false);
    check_point(one, m);
    const double stiffness = rules::stiffness(c.props);
    // A tangent is a sum of terms as large as the stress, which may cancel.
    const double of_tangent_terms = std::max(stiffness, rules::largest_finite(m.stress));
    require(all.status[k] == m.returned && is_near(part(all.state, k, c.state_size()), m.state, 1) &&
                is_near(part(all.stress, k, size), m.stress, stiffness) &&
                is_near(part(all.tangent, k, size * size), m.tangent, of_tangent_terms) &&
                is_near({all.energy[k]}, m.energy, stiffness),
            "update_n is not update", one, m);
    if (m.returned == MYOGROWTH_OK || failed++ > 0) continue;
    const bool of_all = m.returned == MYOGROWTH_BAD_ARGUMENT || m.returned == MYOGROWTH_BAD_PARAMETER;
    const std::string last = std::to_string(c.n_points - 1);
    first = of_all ? m.message : "point " + std::to_string(k) + " (of 0 to " + last + "): " + m.message;
  }
  require(all.returned == failed, "the number of failed points", c, all);
  require(all.message == first, "the message is not about the first that fails", c, all);
}

/// The same call with what is optional left out, in place, or with less room for the message.
void check_variant(const Call& c, const Made& all) {
  const Made m = run(c, true);
  // A tangent beyond the range of double fails a point that asks for it, and no other.
  const bool is_beyond = std::count(all.status.begin(), all.status.end(), MYOGROWTH_NOT_FINITE) > 0;
  if (c.null & of_tangent && is_beyond && m.returned < all.returned) return;
  require(m.returned == all.returned, "optional arguments change the number of failed points", c, m);
  const std::size_t room = c.null & of_message || c.room <= 0 ? 0 : static_cast<std::size_t>(c.room) - 1;
  require(m.message == all.message.substr(0, room), "the message is not cut to its room", c, m);
  const auto is_left = [&](const Numbers& x) { return rules::same_bits(x, Numbers(x.size(), untouched)); };
  require(rules::same_bits(m.stress, all.stress), "optional arguments change the stress", c, m);
  require(c.null & of_tangent ? is_left(m.tangent) : rules::same_bits(m.tangent, all.tangent),
          "optional arguments change the tangent", c, m);
  require(c.null & of_energy ? is_left(m.energy) : rules::same_bits(m.energy, all.energy),
          "optional arguments change the energy", c, m);
  for (std::size_t k = 0; k < c.points(); ++k) {
    require(m.status[k] == (c.null & of_status ? -1 : all.status[k]), "optional arguments change a status", c,
            m);
    const bool stays = c.in_place && all.status[k] != MYOGROWTH_OK;
    require(rules::same_bits(part(m.state, k, c.state_size()),
                             part(stays ? c.state : all.state, k, c.state_size())),
            "optional arguments change the state", c, m);
  }
}

void check_check(const Call& c) {
  Message message(c.room), whole(500);
  Made m;
  const int n = static_cast<int>(c.props.size());
  Numbers all = c.props;
  const double* props = c.null & of_props ? nullptr : pointer(all);
  m.returned = myogrowth_check(props, n, c.null & of_message ? nullptr : message.text.data(), c.room);
  const int expected = c.null & of_props                            ? MYOGROWTH_BAD_ARGUMENT
                       : rules::props_are_faulty_with_laws(c.props) ? MYOGROWTH_BAD_PARAMETER
                                                                    : MYOGROWTH_OK;
  require(m.returned == expected && myogrowth_check(props, n, whole.text.data(), 500) == expected,
          "check: not the status that the header promises", c, m);
  require(whole.read() && (*whole.read() == '\0') == (expected == MYOGROWTH_OK),
          "check: a message for a fault, else none", c, m);
  if (c.null & of_message) return;
  const std::size_t kept = message.room > 0 ? message.room - 1 : 0;
  require(message.read() && message.read() == std::string(whole.read()).substr(0, kept),
          "check: the message is not cut to its room", c, m);
}

/// The tables at any index and for any symbol.
void check_tables(int i, const std::string& symbol) {
  const Call c;
  const Made m;
  const bool is_prop = i >= 0 && i < myogrowth_n_props(), is_state = i >= 0 && i < myogrowth_n_state();
  for (const char* text : {myogrowth_prop_symbol(i), myogrowth_prop_unit(i), myogrowth_prop_meaning(i),
                           myogrowth_prop_allowed(i)})
    require(is_prop ? text && *text : !text, "the table of props", c, m);
  for (const char* text : {myogrowth_state_symbol(i), myogrowth_state_unit(i), myogrowth_state_meaning(i)})
    require(is_state ? text && *text : !text, "the table of the state", c, m);
  require(std::isnan(myogrowth_prop_default(i)) == (!is_prop || i < myogrowth_n_props_required()),
          "the defaults of props", c, m);
  require(std::isnan(myogrowth_state_initial(i)) == !is_state, "the initial state", c, m);
  const int prop = myogrowth_prop_index(symbol.c_str()), state = myogrowth_state_index(symbol.c_str());
  require(prop == -1 || symbol == myogrowth_prop_symbol(prop), "the index of a prop", c, m);
  require(state == -1 || symbol == myogrowth_state_symbol(state), "the index of a state variable", c, m);
  require(!is_prop || myogrowth_prop_index(myogrowth_prop_symbol(i)) == i, "the index of a prop", c, m);
  require(!is_state || myogrowth_state_index(myogrowth_state_symbol(i)) == i, "the index of the state", c, m);
  require(*myogrowth_status_text(i) != '\0', "the text of a status", c, m);
  Call sized;
  sized.measure = i;
  require(static_cast<std::size_t>(myogrowth_stress_size(i)) == sized.stress_size(), "the size of a measure",
          c, m);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes{data, size};
  const auto integer = [&] {
    const int small = static_cast<int>(bytes.byte()) - 8;
    if (small < 200) return small;
    unsigned any = 0;
    for (int i = 0; i < 4; ++i) any = any << 8 | bytes.byte();
    return static_cast<int>(any);
  };
  const unsigned kind = bytes.byte(), sizes = bytes.byte();
  if (kind == 255) {
    const int i = integer();
    const std::string all(reinterpret_cast<const char*>(bytes.at), bytes.left);
    check_tables(i, all.c_str());  // up to its first zero
    return 0;
  }

  Call c;
  c.measure = kind % 8 < 6 ? static_cast<int>(kind % 3) : integer();
  c.in_place = kind & 8;
  c.n_points = static_cast<int>(sizes % 6) - 1;
  c.n_state = sizes < 192 ? 8 + static_cast<int>(sizes / 6 % 2)
                          : static_cast<int>(sizes / 6 % 11 + bytes.byte() % 5) - 1;
  if (kind & 16) c.null = bytes.byte() % 16;
  if (kind % 64 == 63) c.null |= (bytes.byte() * 16u) & of_all_needed;
  c.room = kind & 32 ? std::min(integer(), 600) : 500;
  c.dt = kind & 64 ? bytes.number() : std::exp2(10 * bytes.mild());
  c.props = bytes.props();
  for (std::size_t k = 0; k < c.points(); ++k) {
    Numbers F(9);
    const bool is_wild = bytes.byte() & 1;
    for (std::size_t i = 0; i < 9; ++i)
      F[i] = is_wild ? bytes.number() : (i % 4 == 0 ? 1 : 0) + 0.5 * bytes.mild();
    const Numbers state = bytes.state(c.state_size());
    c.F.insert(c.F.end(), F.begin(), F.end());
    c.state.insert(c.state.end(), state.begin(), state.end());
  }

  Call whole = c;  // all that is optional is there
  whole.null = c.null & of_all_needed;
  whole.in_place = false;
  whole.room = 500;
  const Made all = run(whole, true);
  check_points(whole, all);
  check_variant(c, all);
  check_check(c);
  return 0;
}
