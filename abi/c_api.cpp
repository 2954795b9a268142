// The C API: check, update, convert to the measure asked for, write. myogrowth.h says what it does; its
// tables are in c_tables.cpp.
#include "myogrowth.h"

#include <cstdint>
#include <limits>
#include <myogrowth/more/stress_states.hpp>
#include <type_traits>

#include "many.hpp"

namespace {

using namespace myogrowth;
using Call = abi::Common;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

Call call_of(int n_state, double dt, int measure, bool with_tangent) {
  Call c{};
  c.n_state = n_state;
  c.dt = dt;
  c.measure = measure;
  c.with_tangent = with_tangent;
  return c;
}

int check_props(const double* props, int n_props, Call& call, abi::Text& text) {
  if (!props) {
    abi::tell(text, "props = NULL: the constants are needed.");
    return MYOGROWTH_BAD_ARGUMENT;
  }
  const bool fault = abi::find_muscle_fault(props, n_props, false, call.properties, call.law, text) ||
                     abi::find_hybrid_fault("the C API", call.properties, text);
  return fault ? MYOGROWTH_BAD_PARAMETER : MYOGROWTH_OK;
}

void write_message(const char* text, char* message, int length) {
  if (message && length > 0) std::snprintf(message, static_cast<std::size_t>(length), "%s", text);
}

bool find_measure_fault(int measure, abi::Text& text) {
  if (myogrowth_stress_size(measure) > 0) return false;
  return abi::tell(text, "measure = %d: must be %d (Cauchy), %d (first Piola) or %d (second Piola).", measure,
                   MYOGROWTH_CAUCHY, MYOGROWTH_FIRST_PIOLA, MYOGROWTH_SECOND_PIOLA);
}

// Checks what the points have in common.
int check(const double* props, int n_props, Call& common, abi::Text& text) {
  if (find_measure_fault(common.measure, text) || abi::find_room_fault("n_state", common.n_state, text))
    return MYOGROWTH_BAD_ARGUMENT;
  const int status = check_props(props, n_props, common, text);
  if (status != MYOGROWTH_OK) return status;
  if (abi::find_stretch_fault("n_state", common.n_state, common.properties, text))
    return MYOGROWTH_BAD_ARGUMENT;
  if (common.properties.local_basis && common.measure != MYOGROWTH_CAUCHY) {
    abi::tell(text,
              "PROPS(10) = 1: frame must be 0 with a Piola stress, which refers to F itself and not to "
              "sqrt(F F^T).");
    return MYOGROWTH_BAD_PARAMETER;
  }
  return MYOGROWTH_OK;
}

// The same for points one after the other, and that the arrays of the first are there.
int check(const double* props, int n_props, const double* F, const double* state_in, const double* state_out,
          const double* stress, Call& common, abi::Text& text) {
  const char* missing = !F           ? "F"
                        : !state_in  ? "state_in"
                        : !state_out ? "state_out"
                        : !stress    ? "stress"
                                     : nullptr;
  if (missing) {
    abi::tell(text, "%s = NULL: it is needed.", missing);
    return MYOGROWTH_BAD_ARGUMENT;
  }
  return check(props, n_props, common, text);
}

// What comes in, and where what comes out goes.
struct Arrays {
  const myogrowth_input* in;
  int n_in;
  const myogrowth_output* out;
  int n_out;
  bool state_is_known;
  int* status;
  bool has_lambda;      ///< at the beginning of the step
  int stress, tangent;  ///< index of its only output, if that is whole and in its order, or -1
};

constexpr int n_entries_in = MYOGROWTH_STRESS;  // the first ones
constexpr int entry_of_state(int e) { return abi::row_of_state(e) / myogrowth_block_points; }

bool is_of_state(int entry) {
  return entry < MYOGROWTH_STRESS || (entry >= MYOGROWTH_G_END && entry < MYOGROWTH_ENERGY);
}

// The entry of the state at the beginning of a step that belongs to one at its end; of the others none.
int entry_at_start(int entry) {
  return entry == MYOGROWTH_G_END        ? MYOGROWTH_G
         : entry == MYOGROWTH_LAMBDA_END ? MYOGROWTH_LAMBDA
         : entry < MYOGROWTH_STRESS      ? entry
                                         : MYOGROWTH_UNUSED;
}

// Arrays of points that lie one after the other. Of the state's entries what fits is kept, the others are
// carried over as they are.
struct OneAfterTheOther {
  myogrowth_input in[2];
  myogrowth_output out[4];
  Arrays arrays{in, 0, out, 0, false, nullptr, false, -1, -1};
  const double* carried_from = nullptr;
  double* carried_to = nullptr;
  int n_state = 0, n_carried = 0;

  OneAfterTheOther(const Call& call, const double* F, const double* state_in, double* state_out,
                   double* stress, double* tangent, double* energy) {
    struct Entries {
      int tensor[81];
      constexpr explicit Entries(int first) : tensor{} {
        for (int& entry : tensor) entry = first + static_cast<int>(&entry - tensor);
      }
    };
    static constexpr Entries of_F(MYOGROWTH_F), of_stress(MYOGROWTH_STRESS), of_tangent(MYOGROWTH_TANGENT);
    static constexpr int of_energy = MYOGROWTH_ENERGY, other = MYOGROWTH_UNUSED;
    static constexpr int of_start[abi::n_kept] = {
        MYOGROWTH_G, other, MYOGROWTH_LAMBDA, other, other, MYOGROWTH_N0, MYOGROWTH_N0 + 1, MYOGROWTH_N0 + 2};
    static constexpr int of_end[abi::n_kept] = {entry_of_state(0), entry_of_state(1), entry_of_state(2),
                                                entry_of_state(3), entry_of_state(4), entry_of_state(5),
                                                entry_of_state(6), entry_of_state(7)};
    const int n = call.n_state, n_stress = myogrowth_stress_size(call.measure);
    const auto give = [this](double* data, std::ptrdiff_t step, int size, const int* entry) {
      if (data && size > 0) out[arrays.n_out++] = {data, step, size, entry};
    };
    if (stress) arrays.stress = arrays.n_out;
    give(stress, n_stress, n_stress, of_stress.tensor);
    if (tangent) arrays.tangent = arrays.n_out;
    give(tangent, n_stress * n_stress, n_stress * n_stress, of_tangent.tensor);
    give(energy, 1, n_stress > 0 ? 1 : 0, &of_energy);
    if (n < 1) return;
    in[arrays.n_in++] = {state_in, n,
                         abi::keeps_fibre(n)      ? abi::n_kept
                         : n > abi::stretch_entry ? abi::stretch_entry + 1
                                                  : 1,
                         of_start};
    in[arrays.n_in++] = {F, 9, 9, of_F.tensor};
    const int n_kept = abi::kept_entries(n);
    give(state_out, n, n_kept, of_end);
    n_state = n, n_carried = state_in == state_out ? 0 : n - n_kept;
    carried_from = state_in + n_kept, carried_to = state_out + n_kept;
  }
  OneAfterTheOther(const OneAfterTheOther&) = delete;
};

// The points of arrays, for abi::update_many.
struct Points {
  const Call& call;
  const Arrays& a;
  abi::Text& first_fault;
  const OneAfterTheOther* whole_state;  // or null
  int failed = 0, first_failed = -1;
  int missing[n_entries_in], n_missing = 0;  // what is in no array: 0

  Points(const Call& call_, const Arrays& arrays, abi::Text& text, const OneAfterTheOther* whole = nullptr)
      : call(call_), a(arrays), first_fault(text), whole_state(whole) {
    int n_there = 0;  // each of them once
    for (int i = 0; i < a.n_in; ++i) {
      for (int c = 0; c < a.in[i].size; ++c) n_there += a.in[i].entry[c] < n_entries_in;
    }
    if (n_there == n_entries_in) return;
    bool is_there[n_entries_in] = {};
    for (int i = 0; i < a.n_in; ++i) {
      for (int c = 0; c < a.in[i].size; ++c) {
        if (a.in[i].entry[c] < n_entries_in) is_there[a.in[i].entry[c]] = true;
      }
    }
    for (int e = 0; e < n_entries_in; ++e) {
      if (!is_there[e]) missing[n_missing++] = e;
    }
  }

  void describe(MyogrowthBlock& b) const {
    b.is_known = a.state_is_known;
    b.in = a.in, b.n_in = a.n_in;
    b.out = a.out, b.n_out = a.n_out;
    b.stress = a.stress, b.tangent = a.tangent;
  }
  void load(int, int, MyogrowthBlock& b) const {
    for (int m = 0; m < n_missing; ++m) {
      for (int k = 0; k < myogrowth_block_points; ++k) b.number[myogrowth_row(missing[m]) + k] = 0;
    }
  }
  void read(std::ptrdiff_t point, double (&number)[MYOGROWTH_UNUSED + 1]) const {
    for (int m = 0; m < n_missing; ++m) number[missing[m]] = 0;
    for (int i = 0; i < a.n_in; ++i) {
      for (int c = 0; c < a.in[i].size; ++c)
        number[a.in[i].entry[c]] = a.in[i].data[point * a.in[i].step + c];
    }
  }
  void finish(std::ptrdiff_t first, std::ptrdiff_t count) const {
    for (std::ptrdiff_t k = first; a.status && k < first + count; ++k) a.status[k] = MYOGROWTH_OK;
    if (!whole_state || whole_state->n_carried == 0) return;
    for (std::ptrdiff_t k = first * whole_state->n_state; count > 0; --count, k += whole_state->n_state) {
      for (int e = 0; e < whole_state->n_carried; ++e)
        whole_state->carried_to[k + e] = whole_state->carried_from[k + e];
    }
  }
  bool take(std::ptrdiff_t point, const abi::Result& r) const {
    for (int o = 0; o < a.n_out; ++o) {
      for (int c = 0; c < a.out[o].size; ++c)
        a.out[o].data[point * a.out[o].step + c] = r[myogrowth_row(a.out[o].entry[c])];
    }
    finish(point, 1);
    return true;
  }
  UpdateStatus one(std::ptrdiff_t point, abi::Text& text) const {
    double number[MYOGROWTH_UNUSED + 1], state[abi::n_kept] = {};
    read(point, number);
    for (int e = 0; e < 2 && a.state_is_known; ++e) {
      const double x = number[MYOGROWTH_G + e];
      if (x > 0 && is_finite(x)) continue;
      abi::tell(text, "%s = %.9g on entry: must be > 0 and finite.", e == 0 ? "G" : "lambda", x);
      return UpdateStatus::bad_state;
    }
    state[0] = number[MYOGROWTH_G];
    state[abi::stretch_entry] = number[MYOGROWTH_LAMBDA];
    for (int c = 0; c < 3; ++c) state[abi::fibre_entry + c] = number[MYOGROWTH_N0 + c];
    const double no_field = 0;  // PROPS(20) = -1 is refused
    return abi::update_alone(call, number + MYOGROWTH_F, state, no_field, text,
                             [&](const abi::Result& r) { return take(point, r); });
  }
  // NaN, so that no host can continue silently.
  void write_refusal(std::ptrdiff_t point, int status) const {
    double number[MYOGROWTH_UNUSED + 1];
    if (a.state_is_known) read(point, number);
    number[MYOGROWTH_UNUSED] = no_number;
    if (a.status) a.status[point] = status;
    for (int o = 0; o < a.n_out; ++o) {
      for (int c = 0; c < a.out[o].size; ++c) {
        const int entry = a.out[o].entry[c];
        if (a.state_is_known || !is_of_state(entry))
          a.out[o].data[point * a.out[o].step + c] = number[entry_at_start(entry)];
      }
    }
  }
  void refuse(int point, UpdateStatus status, abi::Text& text) {
    write_refusal(point, static_cast<int>(status));
    if (failed++ > 0) return;
    first_failed = point;
    tell_if_not_told(point, status, text);
    std::snprintf(first_fault, sizeof first_fault, "%s", text);
  }
  // Why there is no result, unless the text says so already.
  void tell_if_not_told(std::ptrdiff_t point, UpdateStatus status, abi::Text& text) const {
    if (text[0]) return;
    double number[MYOGROWTH_UNUSED + 1];
    read(point, number);
    abi::tell_why(status, number + MYOGROWTH_F, call.dt, text);
  }
};

// All points, of which those that failed are counted; or, where all have the same fault, none.
int update_all(int n_points, int fault, const Call& call, const Arrays& arrays, abi::Text& text,
               const OneAfterTheOther* whole_state, char* message, int message_length) {
  Points points(call, arrays, text, whole_state);
  if (fault != MYOGROWTH_OK) {
    for (int i = 0; i < n_points; ++i) points.write_refusal(i, fault);
    write_message(text, message, message_length);
    return n_points;
  }
  abi::update_many(call, 0, n_points, points);
  if (points.failed > 0 && message && message_length > 0) {
    std::snprintf(message, static_cast<std::size_t>(message_length), "point %d (of 0 to %d): %s",
                  points.first_failed, n_points - 1, text);
  }
  return points.failed;
}

// True, and the text, if one of the arrays of myogrowth_update_strided is not as it has to be.
template <class Array, class IsAllowed>
bool find_array_fault(const char* name, const Array* arrays, int n, int n_points, const IsAllowed& is_allowed,
                      abi::Text& text) {
  constexpr bool is_output = std::is_same<Array, myogrowth_output>::value;
  if (n < 0) return abi::tell(text, "n_%s = %d: must be >= 0.", name, n);
  if (n > 0 && !arrays) return abi::tell(text, "%s = NULL: n_%s = %d arrays are needed.", name, name, n);
  for (int i = 0; i < n; ++i) {
    const Array& a = arrays[i];
    if (!a.data || !a.entry)
      return abi::tell(text, "%s[%d].%s = NULL: it is needed.", name, i, a.data ? "entry" : "data");
    if (a.size < 1) return abi::tell(text, "%s[%d].size = %d: must be >= 1.", name, i, a.size);
    if (is_output && n_points > 1 && a.step < a.size && -a.step < a.size) {
      return abi::tell(text, "out[%d].step = %.0f: must be >= size = %d, or <= -size: points would overlap.",
                       i, static_cast<double>(a.step), a.size);
    }
    for (int c = 0; c < a.size; ++c) {
      if (!is_allowed(a.entry[c])) {
        return abi::tell(text, "%s[%d].entry[%d] = %d: must be a number that %s.", name, i, c, a.entry[c],
                         is_output ? "comes out, in this measure" : "comes in, and be there once");
      }
    }
  }
  return false;
}

// Whether numbers of two arrays are at one place, other than one point's state at its end and its beginning.
template <class Array>
bool overlap(const Array& a, const myogrowth_output& b, std::ptrdiff_t n_points) {
  using Place = std::intptr_t;
  constexpr Place bytes = sizeof(double);
  const Place last = n_points - 1, a_step = a.step * bytes, b_step = b.step * bytes;
  const Place a_size = a.size * bytes, b_size = b.size * bytes;
  // What is at a is so far from what is at b, the first points'.
  const Place apart = reinterpret_cast<Place>(a.data) - reinterpret_cast<Place>(b.data);
  const auto before = [&](Place step) { return step < 0 ? last * step : 0; };
  const auto after = [&](Place step) { return step > 0 ? last * step : 0; };
  if (apart + after(a_step) + a_size <= before(b_step) || after(b_step) + b_size <= apart + before(a_step))
    return false;
  // Whether some of `size` bytes from `at` on are those of some point of b.
  const auto meets = [&](Place at, Place size) {
    const Place s = b_step < 0 ? -b_step : b_step, from = b_step < 0 ? at - last * b_step : at;  // in order
    // The first that ends behind `at`; a step of 0 is that of an only point.
    const Place point = from < b_size ? 0 : s == 0 ? n_points : (from - b_size) / s + 1;
    return point <= last && point * s < from + size;
  };
  if (last > 0 && a_step != b_step) {
    const Place n = a_step == 0 ? 0 : last;
    for (Place i = 0; i <= n; ++i) {
      if (meets(apart + i * a_step, a_size)) return true;
    }
    return false;
  }
  for (int c = 0; c < a.size; ++c) {
    const Place at = apart + c * bytes, within = at / bytes;
    const bool is_its_end =
        at % bytes == 0 && within >= 0 && within < b.size && entry_at_start(b.entry[within]) == a.entry[c];
    if (!std::is_same<Array, myogrowth_output>::value && (a.entry[c] == MYOGROWTH_UNUSED || is_its_end))
      continue;
    // (Points of both are equally far apart: any of them that meet have a first or a last point among them.)
    if (meets(at, bytes) || meets(at + last * a_step, bytes)) return true;
  }
  return false;
}

// The output that has all entries from `first` on, in their order, if no other has one of them; else -1.
// (What is written directly is in no row of the block, from where others would have it.)
int sole_output(const Arrays& a, int first, int size) {
  int found = -1, outputs = 0;
  for (int o = 0; o < a.n_out; ++o) {
    bool has_some = false, is_whole = a.out[o].size == size;
    for (int c = 0; c < a.out[o].size; ++c) {
      const int which = a.out[o].entry[c] - first;
      has_some = has_some || (which >= 0 && which < size);
      is_whole = is_whole && which == c;
    }
    outputs += has_some;
    if (is_whole) found = o;
  }
  return outputs == 1 ? found : -1;
}

// The same for all of them.
bool find_fault(Arrays& a, int n_points, Call& call, abi::Text& text) {
  bool is_there[MYOGROWTH_UNUSED + 1] = {};
  const auto comes_in = [&](int entry) {
    const bool is_input =
        entry == MYOGROWTH_UNUSED || (entry >= 0 && entry < n_entries_in && !is_there[entry]);
    if (is_input) is_there[entry] = true;
    return is_input;
  };
  const int n_stress = myogrowth_stress_size(call.measure);
  const auto comes_out = [&](int entry) {
    const int of_tangent = entry - MYOGROWTH_TANGENT;
    const bool is_of_tangent = of_tangent >= 0 && of_tangent < n_stress * n_stress;
    call.with_tangent = call.with_tangent || is_of_tangent;
    return is_of_tangent || (entry >= MYOGROWTH_N0 && entry < MYOGROWTH_STRESS + n_stress) ||
           (entry >= MYOGROWTH_G_END && entry <= MYOGROWTH_ENERGY);
  };
  if (find_array_fault("in", a.in, a.n_in, n_points, comes_in, text) ||
      find_array_fault("out", a.out, a.n_out, n_points, comes_out, text))
    return true;
  for (int c = 0; c < 9; ++c) {
    if (!is_there[MYOGROWTH_F + c])
      return abi::tell(text, "F%d%d: is in no array of in: all of F is needed.", c % 3 + 1, c / 3 + 1);
  }
  a.has_lambda = is_there[MYOGROWTH_LAMBDA];
  a.stress = sole_output(a, MYOGROWTH_STRESS, n_stress);
  a.tangent = sole_output(a, MYOGROWTH_TANGENT, n_stress * n_stress);
  for (int o = 0; o < a.n_out; ++o) {
    for (int i = 0; i < a.n_in; ++i) {
      if (overlap(a.in[i], a.out[o], n_points))
        return abi::tell(text, "out[%d] overlaps in[%d]: only the state may be written where it is read.", o,
                         i);
    }
    for (int other = 0; other < o; ++other) {
      if (overlap(a.out[other], a.out[o], n_points))
        return abi::tell(text, "out[%d] overlaps out[%d]: it must have memory of its own.", o, other);
    }
  }
  return false;
}

}  // namespace

extern "C" {

int myogrowth_check(const double* props, int n_props, char* message, int message_length) {
  Call common{};
  abi::Text text = "";
  const int status = check_props(props, n_props, common, text);
  write_message(text, message, message_length);
  return status;
}

int myogrowth_update(const double* props, int n_props, const double F[9], const double* state_in,
                     double* state_out, int n_state, double dt, int measure, double* stress, double* tangent,
                     double* energy, char* message, int message_length) {
  abi::Text text;
  text[0] = '\0';  // (not all 400 of them)
  Call call = call_of(n_state, dt, measure, tangent != nullptr);
  int made = check(props, n_props, F, state_in, state_out, stress, call, text);
  if (made != MYOGROWTH_OK) call.n_state = 0;  // it may be anything, and no state is touched
  const OneAfterTheOther whole(call, F, state_in, state_out, stress, tangent, energy);
  abi::Text unused;
  const Points points(call, whole.arrays, unused, &whole);
  if (made == MYOGROWTH_OK) {
    call.n_state = abi::n_kept;  // with zeros for what is not there
    const UpdateStatus status = points.one(0, text);
    made = static_cast<int>(status);
    if (status != UpdateStatus::ok) points.tell_if_not_told(0, status, text);
  }
  write_message(text, message, message_length);
  if (made != MYOGROWTH_OK) points.write_refusal(0, made);
  return made;
}

int myogrowth_update_n(int n_points, const double* props, int n_props, const double* F,
                       const double* state_in, double* state_out, int n_state, double dt, int measure,
                       double* stress, double* tangent, double* energy, int* status, char* message,
                       int message_length) {
  write_message("", message, message_length);
  if (n_points <= 0) return 0;
  abi::Text text;
  text[0] = '\0';  // (not all 400 of them)
  Call call = call_of(n_state, dt, measure, tangent != nullptr);
  const int fault = check(props, n_props, F, state_in, state_out, stress, call, text);
  if (fault != MYOGROWTH_OK) call.n_state = 0;  // it may be anything, and no state is touched
  OneAfterTheOther whole(call, F, state_in, state_out, stress, tangent, energy);
  whole.arrays.status = status;
  call.n_state = abi::n_kept;  // with zeros for what is not there
  return update_all(n_points, fault, call, whole.arrays, text, &whole, message, message_length);
}

int myogrowth_update_strided(int n_points, const double* props, int n_props, const struct myogrowth_input* in,
                             int n_in, double dt, int measure, const struct myogrowth_output* out, int n_out,
                             int state_is_known, int* status, char* message, int message_length) {
  write_message("", message, message_length);
  if (n_points <= 0) return 0;
  abi::Text text = "";
  Call call = call_of(abi::n_kept, dt, measure, false);
  Arrays arrays{in, n_in, out, n_out, state_is_known != 0, status, false, -1, -1};
  int fault = MYOGROWTH_OK;
  if (find_measure_fault(measure, text) || find_fault(arrays, n_points, call, text)) {
    fault = MYOGROWTH_BAD_ARGUMENT;
    arrays.n_in = arrays.n_out = 0;
  } else {
    fault = check(props, n_props, call, text);
    const bool remembers = call.properties.material.integration == TimeIntegration::midpoint_flow;
    if (fault == MYOGROWTH_OK && remembers && !arrays.has_lambda) {
      abi::tell(text, "lambda: is in no array of in: with PROPS(12) = 1 it is needed.");
      fault = MYOGROWTH_BAD_ARGUMENT;
    }
  }
  return update_all(n_points, fault, call, arrays, text, nullptr, message, message_length);
}

int myogrowth_uniaxial(const double* props, int n_props, double stretch, const double* state_in,
                       double* state_out, int n_state, double dt, double* lateral, double* stress,
                       double* modulus, double* energy, char* message, int message_length) {
  abi::Text text = "";
  Call common = call_of(n_state, dt, MYOGROWTH_CAUCHY, modulus != nullptr);
  int made = check(props, n_props, &stretch, state_in, state_out, stress, common, text);
  if (made == MYOGROWTH_OK && abi::find_state_fault(state_in, n_state, common.properties, text))
    made = MYOGROWTH_BAD_STATE;
  if (made == MYOGROWTH_OK) {
    double side = lateral ? *lateral : 0, results[2], state[abi::n_kept], psi = 0;
    const double G = abi::number_at_start(state_in), last = abi::stretch_at_start(state_in, n_state);
    const UpdateStatus status = abi::with_material(
        common.properties.material, common.law,
        [&](auto& u, const auto& material, const auto&... activation) {
          double slope;
          const UpdateStatus found =
              uniaxial_stress(material, stretch, G, last, dt, side, u, slope, activation...);
          results[0] = u.tau[0] / u.J, results[1] = slope / u.J;
          abi::state_of(u, state);
          psi = u.psi;
          return found == UpdateStatus::ok && !are_finite(results, 2) ? UpdateStatus::not_finite : found;
        });
    made = static_cast<int>(status);
    if (status != UpdateStatus::ok) {
      const double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
      if (is_finite(stretch) && stretch > 0) {
        abi::tell_why(status, F, dt, text);
      } else {
        abi::tell(text, "stretch = %.9g: must be > 0 and finite.", stretch);
      }
    } else {
      for (int i = abi::fibre_entry; i < abi::n_kept && abi::keeps_fibre(n_state); ++i)
        state[i] = state_in[i];
      const int n = abi::kept_entries(n_state);
      for (int i = 0; i < n_state; ++i) state_out[i] = i < n ? state[i] : state_in[i];
      *stress = results[0];
      if (energy) *energy = psi;
      if (modulus) *modulus = results[1];
      if (lateral) *lateral = side;
    }
  }
  write_message(text, message, message_length);
  for (double* x : {stress, modulus, energy}) {
    if (made != MYOGROWTH_OK && x) *x = no_number;
  }
  return made;
}

}  // extern "C"
