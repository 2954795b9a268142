// The C API: check, update, convert to the measure asked for, write. myogrowth.h says what it does; its
// tables are in c_tables.cpp.
#include "myogrowth.h"

#include <limits>
#include <myogrowth/more/stress_states.hpp>

#include "elastic_laws.hpp"
#include "many.hpp"

namespace {

using namespace myogrowth;

// What the points of a call have in common.
struct Common : abi::Common {
  bool has_law;  // an elastic law other than eq. 3
  abi::LawChoice law;
};
Common common_of(int n_state, double dt, int measure, bool with_tangent) {
  Common c{};
  c.n_state = n_state;
  c.dt = dt;
  c.measure = measure;
  c.with_tangent = with_tangent;
  return c;
}

// The arrays of one point; or of the first of many, which lie one after the other.
struct Point {
  const double *F, *state_in;
  double *state_out, *stress, *tangent, *energy;
  Point at(int i, const Common& c) const {
    const int n = myogrowth_stress_size(c.measure);
    const auto of = [i](auto* array, int size) {
      return array ? array + static_cast<std::ptrdiff_t>(i) * size : nullptr;
    };
    return {of(F, 9),      of(state_in, c.n_state), of(state_out, c.n_state),
            of(stress, n), of(tangent, n * n),      of(energy, 1)};
  }
};

void write_message(const char* text, char* message, int length) {
  if (message && length > 0) std::snprintf(message, static_cast<std::size_t>(length), "%s", text);
}

int check_props(const double* props, int n_props, Common& common, abi::Text& text) {
  if (!props) {
    abi::tell(text, "props = NULL: the constants are needed.");
    return MYOGROWTH_BAD_ARGUMENT;
  }
  abi::Properties& properties = common.properties;
  common.has_law = abi::asks_for_law(props, n_props);
  const bool fault =
      (common.has_law ? abi::find_law_fault(props, n_props, nullptr, nullptr, properties, common.law, text)
                      : abi::find_props_fault(props, n_props, properties, text)) ||
      abi::find_hybrid_fault("the C API", properties, text);
  return fault ? MYOGROWTH_BAD_PARAMETER : MYOGROWTH_OK;
}

// Checks what the points have in common, and that the arrays of the first are there.
int check(const double* props, int n_props, const Point& first, Common& common, abi::Text& text) {
  const char* missing = !first.F           ? "F"
                        : !first.state_in  ? "state_in"
                        : !first.state_out ? "state_out"
                        : !first.stress    ? "stress"
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

void write_state(int n_state, const Point& p, const double (&state)[abi::n_kept]) {
  const int n = abi::kept_entries(n_state);
  for (int i = 0; i < n_state; ++i) p.state_out[i] = i < n ? state[i] : p.state_in[i];
}

template <class Result>
bool write(const Common& common, const Point& p, const Result& r) {
  common.measure == MYOGROWTH_FIRST_PIOLA ? r.template copy<9>(p.stress, p.tangent)
                                          : r.template copy<6>(p.stress, p.tangent);
  if (p.energy) *p.energy = r.psi;
  write_state(common.n_state, p, r.state);
  return true;
}

// The results of a point that has none: n stresses, NaN, so that no host can continue silently; its state is
// as it was.
int refuse(int n, const Point& p, int status) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < n && p.stress; ++i) p.stress[i] = nan;
  for (int i = 0; i < n * n && p.tangent; ++i) p.tangent[i] = nan;
  if (n > 0 && p.energy) *p.energy = nan;
  return status;
}

// The reason in words, where there is none yet.
const char* reason(UpdateStatus status, abi::Text& text) {
  if (status != UpdateStatus::ok && !text[0]) abi::tell(text, "%s.", abi::text(status));
  return text;
}

// Calls use(u, material, activation ...), with u what update_point of the material fills.
template <class Use>
UpdateStatus with_material(const Common& common, const Use& use) {
  const FibreGrowth<double>& m = common.properties.material;
  if (!common.has_law) {
    PointUpdate<double> u;
    return use(u, m);
  }
  UpdateStatus status = UpdateStatus::ok;
  abi::with_chosen_law(common.law, m, [&](const auto& material, double activation) {
    ElasticPointUpdate<double> u;
    status = use(u, material, activation);
  });
  return status;
}

UpdateStatus update(const Common& common, const Point& p, abi::Text& text) {
  return with_material(common, [&](auto& u, const auto& material, const auto&... activation) {
    const auto take = [&](const auto& r) { return write(common, p, r); };
    return abi::update_alone(common, material, u, p.F, p.state_in, text, take, activation...);
  });
}

}  // namespace

extern "C" {

int myogrowth_check(const double* props, int n_props, char* message, int message_length) {
  Common common{};
  abi::Text text = "";
  const int status = check_props(props, n_props, common, text);
  write_message(text, message, message_length);
  return status;
}

int myogrowth_update(const double* props, int n_props, const double F[9], const double* state_in,
                     double* state_out, int n_state, double dt, int measure, double* stress, double* tangent,
                     double* energy, char* message, int message_length) {
  abi::Text text = "";
  const Point p{F, state_in, state_out, stress, tangent, energy};
  Common common = common_of(n_state, dt, measure, tangent != nullptr);
  int made = check(props, n_props, p, common, text);
  if (made == MYOGROWTH_OK) {
    const UpdateStatus status = update(common, p, text);
    made = static_cast<int>(status);
    reason(status, text);
  }
  write_message(text, message, message_length);
  return made == MYOGROWTH_OK ? made : refuse(myogrowth_stress_size(measure), p, made);
}

int myogrowth_update_n(int n_points, const double* props, int n_props, const double* F,
                       const double* state_in, double* state_out, int n_state, double dt, int measure,
                       double* stress, double* tangent, double* energy, int* status, char* message,
                       int message_length) {
  write_message("", message, message_length);
  if (n_points <= 0) return 0;
  abi::Text text = "";
  const Point points{F, state_in, state_out, stress, tangent, energy};
  Common common = common_of(n_state, dt, measure, tangent != nullptr);
  const int n_stress = myogrowth_stress_size(measure);
  const int fault = check(props, n_props, points, common, text);
  if (fault != MYOGROWTH_OK) {
    write_message(text, message, message_length);
    common.n_state = 0;  // it may be anything, and no state is touched
    for (int i = 0; i < n_points; ++i) {
      refuse(n_stress, points.at(i, common), fault);
      if (status) status[i] = fault;
    }
    return n_points;
  }

  int failed = 0;
  const auto refuse_one = [&](int i, UpdateStatus why, abi::Text& words) {
    const int made = refuse(n_stress, points.at(i, common), static_cast<int>(why));
    if (status) status[i] = made;
    if (++failed > 1 || !message || message_length <= 0) return;
    std::snprintf(message, static_cast<std::size_t>(message_length), "point %d (of 0 to %d): %s", i,
                  n_points - 1, reason(why, words));
  };
  for (int i = 0; i < n_points && common.has_law; ++i) {  // there are no packs of these laws
    if (status) status[i] = MYOGROWTH_OK;
    const UpdateStatus made = update(common, points.at(i, common), text);
    if (made != UpdateStatus::ok) refuse_one(i, made, text);
  }
  if (common.has_law) return failed;
  abi::update_many(
      common, n_points,
      [&](int i, double(&F_i)[9]) {
        const Point p = points.at(i, common);
        for (int c = 0; c < 9; ++c) F_i[c] = p.F[c];
        return p.state_in;
      },
      [&](int i, const auto& r) {
        if (status) status[i] = MYOGROWTH_OK;
        return write(common, points.at(i, common), r);
      },
      refuse_one);
  return failed;
}

int myogrowth_uniaxial(const double* props, int n_props, double stretch, const double* state_in,
                       double* state_out, int n_state, double dt, double* lateral, double* stress,
                       double* modulus, double* energy, char* message, int message_length) {
  abi::Text text = "";
  const Point p{&stretch, state_in, state_out, stress, modulus, energy};
  Common common = common_of(n_state, dt, MYOGROWTH_CAUCHY, modulus != nullptr);
  int made = check(props, n_props, p, common, text);
  if (made == MYOGROWTH_OK && abi::find_state_fault(state_in, n_state, common.properties, text))
    made = MYOGROWTH_BAD_STATE;
  if (made == MYOGROWTH_OK) {
    double side = lateral ? *lateral : 0, results[2], state[abi::n_kept], psi = 0;
    const double G = abi::number_at_start(state_in), last = abi::stretch_at_start(state_in, n_state);
    const UpdateStatus status =
        with_material(common, [&](auto& u, const auto& material, const auto&... activation) {
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
      write_state(n_state, p, state);
      *stress = results[0];
      if (energy) *energy = psi;
      if (modulus) *modulus = results[1];
      if (lateral) *lateral = side;
    }
  }
  write_message(text, message, message_length);
  return made == MYOGROWTH_OK ? made : refuse(1, p, made);
}

}  // extern "C"
