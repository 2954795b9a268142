// The C API: check, update, convert to the measure asked for, write. myogrowth.h says what it does; its
// tables are in c_tables.cpp.
#include "myogrowth.h"

#include <limits>
#include <myogrowth/more/stress_states.hpp>

#include "arrays.hpp"

namespace {

using namespace myogrowth;
using abi::Arrays;
using Call = abi::CallOfMany;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

Call call_of(int n_state, double dt, int measure, bool with_tangent) {
  Call c{};
  c.n_state = n_state;
  c.dt = dt;
  c.measure = measure;
  c.with_tangent = with_tangent;
  return c;
}

void write_message(const char* text, char* message, int length) {
  if (message && length > 0) std::snprintf(message, static_cast<std::size_t>(length), "%s", text);
}

// Checks what the points have in common, and that the arrays of the first are there.
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
  if (myogrowth_stress_size(common.measure) == 0) {
    abi::tell(text, "measure = %d: must be %d (Cauchy), %d (first Piola) or %d (second Piola).",
              common.measure, MYOGROWTH_CAUCHY, MYOGROWTH_FIRST_PIOLA, MYOGROWTH_SECOND_PIOLA);
    return MYOGROWTH_BAD_ARGUMENT;
  }
  if (abi::find_room_fault("n_state", common.n_state, text)) return MYOGROWTH_BAD_ARGUMENT;
  const int status = abi::check_props(props, n_props, common, text);
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

// The arrays of points that lie one after the other. Of the state's entries what fits is kept, the others are
// carried over as they are.
Arrays arrays_of(const Call& call, const double* F, const double* state_in, double* state_out, double* stress,
                 double* tangent, double* energy) {
  static constexpr int rows_of_state[abi::n_kept] = {
      abi::row_of_state(0), abi::row_of_state(1), abi::row_of_state(2), abi::row_of_state(3),
      abi::row_of_state(4), abi::row_of_state(5), abi::row_of_state(6), abi::row_of_state(7)};
  const int n = call.n_state, n_stress = myogrowth_stress_size(call.measure);
  Arrays a;
  a.F = {F, 9, {0, 1, 2, 3, 4, 5, 6, 7, 8}};
  a.give(stress, n_stress, n_stress, abi::rows_from(myogrowth_row_stress));
  a.give(tangent, n_stress * n_stress, n_stress * n_stress, abi::rows_from(myogrowth_row_tangent));
  if (n_stress > 0) a.give(energy, 1, 1, abi::rows_from(myogrowth_row_psi));
  if (n < 1) return a;
  a.G = {state_in, n, {0}};
  if (n > abi::stretch_entry) a.stretch = {state_in + abi::stretch_entry, n, {0}};
  if (abi::keeps_fibre(n)) a.n0 = {state_in + abi::fibre_entry, n, {0, 1, 2}};
  const int n_kept = abi::kept_entries(n);
  a.give(state_out, n, n_kept, rows_of_state);
  a.carried = {state_in + n_kept, n, state_in == state_out ? 0 : n - n_kept, nullptr};
  a.carried_to = state_out + n_kept;
  return a;
}

bool is_of_state(int row) {
  return (row >= myogrowth_row_G_end && row < myogrowth_row_psi) || row < myogrowth_row_stress;
}

// The results of a point that has none: NaN, so that no host can continue silently.
void refuse(const Arrays& a, std::ptrdiff_t point, int status) {
  if (a.status) a.status[point] = status;
  for (int o = 0; o < a.n_out; ++o) {
    for (int c = 0; c < a.out[o].size; ++c) {
      double& x = a.out[o].data[point * a.out[o].step + c];
      const int row = a.out[o].row[c];
      if (!is_of_state(row)) {
        x = no_number;
      } else if (a.is_known) {
        x = row == abi::row_of_state(0)                    ? a.G(point, 0)
            : row == abi::row_of_state(abi::stretch_entry) ? a.stretch(point, 0)
            : row < myogrowth_row_stress ? a.n0(point, (row - myogrowth_row_n0) / myogrowth_block_points)
                                         : no_number;
      }
    }
  }
}

// The reason in words, where there is none yet.
const char* reason(UpdateStatus status, abi::Text& text) {
  if (status != UpdateStatus::ok && !text[0]) abi::tell(text, "%s.", abi::text(status));
  return text;
}

// The points of arrays, for abi::update_many.
struct Points {
  const Call& call;
  const Arrays& a;
  abi::Text& first_fault;
  int failed = 0, first_failed = -1;
  int row_of_F[9];  // of F's components as they lie, where they are side by side
  bool is_dense;    // whether they are

  Points(const Call& call_, const Arrays& arrays, abi::Text& text)
      : call(call_), a(arrays), first_fault(text), is_dense(true) {
    bool is_there[9] = {};
    for (int c = 0; c < 9 && is_dense; ++c) {
      const std::ptrdiff_t at = a.F.component[c];
      is_dense = 0 <= at && at < 9 && !is_there[at];
      if (is_dense) is_there[at] = true, row_of_F[at] = myogrowth_row_F + c * myogrowth_block_points;
    }
  }

  void load(std::ptrdiff_t i, int count, MyogrowthBlock& b) const {
    b.is_known = a.is_known;
    b.n_in = 0;
    const auto from = [&](const abi::Given& given, int n, int first_row) {
      const bool is_regular = given.data && given.n_axes == 0;
      for (int c = 0; c < n && is_regular; ++c)
        b.in[b.n_in++] = {given.at(i) + given.component[c], given.step, 1,
                          abi::rows_from(first_row + c * myogrowth_block_points)};
      for (int k = 0; k < count && !is_regular; ++k) {
        const double* point = given.data ? given.at(i + k) : nullptr;
        for (int c = 0; c < n; ++c)
          b.number[first_row + c * myogrowth_block_points + k] = point ? point[given.component[c]] : 0;
      }
    };
    if (is_dense && a.F.n_axes == 0) {
      b.in[b.n_in++] = {a.F.at(i), a.F.step, 9, row_of_F};
    } else {
      from(a.F, 9, myogrowth_row_F);
    }
    from(a.G, 1, myogrowth_row_G);
    from(a.stretch, 1, myogrowth_row_lambda);
    from(a.n0, 3, myogrowth_row_n0);
    b.n_out = a.n_out;
    for (int o = 0; o < a.n_out; ++o) {
      b.out[o] = a.out[o];
      b.out[o].data += i * b.out[o].step;
    }
  }
  void finish(std::ptrdiff_t i) const {
    for (int e = 0; e < a.carried.size; ++e)
      a.carried_to[i * a.carried.step + e] = a.carried.data[i * a.carried.step + e];
    if (a.status) a.status[i] = MYOGROWTH_OK;
  }
  bool take(std::ptrdiff_t i, const abi::Result& r) const {
    for (int o = 0; o < a.n_out; ++o) {
      for (int c = 0; c < a.out[o].size; ++c) a.out[o].data[i * a.out[o].step + c] = r[a.out[o].row[c]];
    }
    finish(i);
    return true;
  }
  UpdateStatus one(std::ptrdiff_t i, abi::Text& text) const {
    double F[9], state[abi::n_kept] = {a.G(i, 0)};
    for (int c = 0; c < 9; ++c) F[c] = a.F(i, c);
    double& stretch = state[abi::stretch_entry] = a.stretch(i, 0);
    for (int c = 0; c < 3; ++c) state[abi::fibre_entry + c] = a.n0(i, c);
    if (a.is_known && !(state[0] > 0 && stretch > 0 && is_finite(stretch))) state[0] = no_number;
    const double no_field = 0;  // PROPS(20) = -1 is refused
    return abi::update_alone(call, F, state, no_field, text,
                             [&](const abi::Result& r) { return take(i, r); });
  }
  void refuse(int i, UpdateStatus status, abi::Text& text) {
    ::refuse(a, i, static_cast<int>(status));
    if (failed++ > 0) return;
    first_failed = i;
    std::snprintf(first_fault, sizeof first_fault, "%s", reason(status, text));
  }
};

}  // namespace

namespace myogrowth {
namespace abi {

int check_props(const double* props, int n_props, CallOfMany& call, Text& text) {
  if (!props) {
    tell(text, "props = NULL: the constants are needed.");
    return MYOGROWTH_BAD_ARGUMENT;
  }
  const bool fault = find_muscle_fault(props, n_props, false, call.properties, call.law, text) ||
                     find_hybrid_fault("the C API", call.properties, text);
  return fault ? MYOGROWTH_BAD_PARAMETER : MYOGROWTH_OK;
}

int update_arrays(const CallOfMany& call, const Arrays& arrays, int first, int last, Text& text, int* where) {
  Points points(call, arrays, text);
  update_many(call, first, last, points);
  if (where) *where = points.first_failed;
  return points.failed;
}

}  // namespace abi
}  // namespace myogrowth

extern "C" {

int myogrowth_check(const double* props, int n_props, char* message, int message_length) {
  Call common{};
  abi::Text text = "";
  const int status = abi::check_props(props, n_props, common, text);
  write_message(text, message, message_length);
  return status;
}

int myogrowth_update(const double* props, int n_props, const double F[9], const double* state_in,
                     double* state_out, int n_state, double dt, int measure, double* stress, double* tangent,
                     double* energy, char* message, int message_length) {
  abi::Text text = "";
  Call call = call_of(n_state, dt, measure, tangent != nullptr);
  int made = check(props, n_props, F, state_in, state_out, stress, call, text);
  if (made != MYOGROWTH_OK) call.n_state = 0;  // it may be anything, and no state is touched
  const Arrays a = arrays_of(call, F, state_in, state_out, stress, tangent, energy);
  if (made == MYOGROWTH_OK) {
    call.n_state = abi::n_kept;  // with zeros for what is not there
    abi::Text unused;
    const UpdateStatus status = Points(call, a, unused).one(0, text);
    made = static_cast<int>(status);
    reason(status, text);
  }
  write_message(text, message, message_length);
  if (made != MYOGROWTH_OK) refuse(a, 0, made);
  return made;
}

int myogrowth_update_n(int n_points, const double* props, int n_props, const double* F,
                       const double* state_in, double* state_out, int n_state, double dt, int measure,
                       double* stress, double* tangent, double* energy, int* status, char* message,
                       int message_length) {
  write_message("", message, message_length);
  if (n_points <= 0) return 0;
  abi::Text text = "";
  Call call = call_of(n_state, dt, measure, tangent != nullptr);
  const int fault = check(props, n_props, F, state_in, state_out, stress, call, text);
  if (fault != MYOGROWTH_OK) call.n_state = 0;  // it may be anything, and no state is touched
  Arrays a = arrays_of(call, F, state_in, state_out, stress, tangent, energy);
  a.status = status;
  if (fault != MYOGROWTH_OK) {
    write_message(text, message, message_length);
    for (int i = 0; i < n_points; ++i) refuse(a, i, fault);
    return n_points;
  }
  call.n_state = abi::n_kept;  // with zeros for what is not there
  int where;
  const int failed = abi::update_arrays(call, a, 0, n_points, text, &where);
  if (failed > 0 && message && message_length > 0) {
    std::snprintf(message, static_cast<std::size_t>(message_length), "point %d (of 0 to %d): %s", where,
                  n_points - 1, text);
  }
  return failed;
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
    reason(status, text);
    if (status == UpdateStatus::ok) {
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
