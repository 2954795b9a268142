// The C API: check, update, convert to the measure asked for, write. myogrowth.h says what it does; its
// tables are in c_tables.cpp.
#include "myogrowth.h"

#include <limits>
#include <myogrowth/more/left_stretch.hpp>
#include <myogrowth/more/stress_states.hpp>

#include "elastic_laws.hpp"
#include "many.hpp"

namespace {

using namespace myogrowth;

// What the points of a call have in common.
struct Common {
  abi::Properties properties;
  int n_state;
  double dt;
  int measure, n_stress;
  bool has_law = false;  // an elastic law other than eq. 3
  abi::LawChoice law{};
};

// The arrays of one point; or of the first of many, which lie one after the other.
struct Point {
  const double *F, *state_in;
  double *state_out, *stress, *tangent, *energy;
  Point at(int i, const Common& c) const {
    const auto of = [i](auto* array, int size) {
      return array ? array + static_cast<std::ptrdiff_t>(i) * size : nullptr;
    };
    return {of(F, 9),
            of(state_in, c.n_state),
            of(state_out, c.n_state),
            of(stress, c.n_stress),
            of(tangent, c.n_stress * c.n_stress),
            of(energy, 1)};
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
  if (common.n_stress == 0) {
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

void write(const Common& common, const Point& p, const double (&state)[abi::n_kept], double psi) {
  if (p.energy) *p.energy = psi;
  const int n = abi::kept_entries(common.n_state);
  for (int i = 0; i < common.n_state; ++i) p.state_out[i] = i < n ? state[i] : p.state_in[i];
}

// The results of a point that has none: NaN, so that no host can continue silently; its state is as it was.
int refuse(const Common& common, const Point& p, int status) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const int n = common.n_stress;
  for (int i = 0; i < n && p.stress; ++i) p.stress[i] = nan;
  for (int i = 0; i < n * n && p.tangent; ++i) p.tangent[i] = nan;
  if (n > 0 && p.energy) *p.energy = nan;
  return status;
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

int update(const Common& common, const Point& p, abi::Text& text) {
  abi::Start start;
  UpdateStatus status = abi::find_start(p.state_in, common.n_state, common.properties, start, text);
  if (status != UpdateStatus::ok) return refuse(common, p, static_cast<int>(status));
  double V[9];
  const bool turned = common.properties.local_basis && left_stretch(p.F, V);
  const double* F = turned ? V : p.F;
  double state[abi::n_kept], psi = 0;
  status = with_material(common, [&](auto& u, const auto& material, const auto&... activation) {
    UpdateStatus made =
        update_point(material, F, start.n0, start.G, start.lambda, common.dt, u, activation...);
    // det F can be 0 to the one and > 0 to the other, to rounding: F itself is then the wrong one.
    if (made == UpdateStatus::ok && common.properties.local_basis && !turned) made = UpdateStatus::inverted;
    if (made == UpdateStatus::ok) {
      abi::convert(common.measure, F, u, p.stress, p.tangent);
      const int n = common.n_stress;
      const bool finite = are_finite(p.stress, n) && (!p.tangent || are_finite(p.tangent, n * n));
      if (!finite) made = UpdateStatus::not_finite;
      abi::state_of(u, state);
      psi = u.psi;
    }
    return made;
  });
  if (status != UpdateStatus::ok) {
    abi::tell(text, "%s.", abi::text(status));
    return refuse(common, p, static_cast<int>(status));
  }
  write(common, p, state, psi);
  return MYOGROWTH_OK;
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
  Common common{{}, n_state, dt, measure, myogrowth_stress_size(measure)};
  const int fault = check(props, n_props, p, common, text);
  const int made = fault != MYOGROWTH_OK ? refuse(common, p, fault) : update(common, p, text);
  write_message(text, message, message_length);
  return made;
}

int myogrowth_update_n(int n_points, const double* props, int n_props, const double* F,
                       const double* state_in, double* state_out, int n_state, double dt, int measure,
                       double* stress, double* tangent, double* energy, int* status, char* message,
                       int message_length) {
  write_message("", message, message_length);
  if (n_points <= 0) return 0;
  abi::Text text = "";
  const Point points{F, state_in, state_out, stress, tangent, energy};
  Common common{{}, n_state, dt, measure, myogrowth_stress_size(measure)};
  const int fault = check(props, n_props, points, common, text);
  if (fault != MYOGROWTH_OK) {
    write_message(text, message, message_length);
    common.n_state = 0;  // it may be anything, and no state is touched
    for (int i = 0; i < n_points; ++i) {
      refuse(common, points.at(i, common), fault);
      if (status) status[i] = fault;
    }
    return n_points;
  }

  int failed = 0;
  const auto update_one = [&](int i) {
    const int made = update(common, points.at(i, common), text);
    if (status) status[i] = made;
    if (made == MYOGROWTH_OK || ++failed > 1 || !message || message_length <= 0) return;
    std::snprintf(message, static_cast<std::size_t>(message_length), "point %d (of 0 to %d): %s", i,
                  n_points - 1, text);
  };
  if (common.has_law) {  // there are no packs of these laws
    for (int i = 0; i < n_points; ++i) update_one(i);
    return failed;
  }
  abi::update_many(
      common.properties.material, dt, n_points, measure, tangent != nullptr,
      [&](int i, double(&F_i)[9], abi::Start& start) {
        const Point p = points.at(i, common);
        for (int c = 0; c < 9; ++c) F_i[c] = p.F[c];
        return !common.properties.local_basis &&
               abi::find_start(p.state_in, n_state, common.properties, start, text) == UpdateStatus::ok;
      },
      [&](int i, const abi::BlockResult& r) {
        const Point p = points.at(i, common);
        double state[abi::n_kept];
        r.state(state);
        common.n_stress == 9 ? r.gather<9>(r.block.stress, p.stress) : r.gather<6>(r.block.stress, p.stress);
        if (tangent && common.n_stress == 9) r.gather<81>(r.block.tangent, p.tangent);
        if (tangent && common.n_stress == 6) r.gather<36>(r.block.tangent, p.tangent);
        write(common, p, state, r.psi());
        if (status) status[i] = MYOGROWTH_OK;
        return true;
      },
      update_one);
  return failed;
}

int myogrowth_uniaxial(const double* props, int n_props, double stretch, const double* state_in,
                       double* state_out, int n_state, double dt, double* lateral, double* stress,
                       double* modulus, double* energy, char* message, int message_length) {
  abi::Text text = "";
  const Point p{&stretch, state_in, state_out, stress, modulus, energy};
  Common common{{}, n_state, dt, MYOGROWTH_CAUCHY, 1};
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
    if (status == UpdateStatus::ok) {
      for (int i = abi::fibre_entry; i < abi::n_kept && abi::keeps_fibre(n_state); ++i)
        state[i] = state_in[i];
      write(common, p, state, psi);
      *stress = results[0];
      if (modulus) *modulus = results[1];
      if (lateral) *lateral = side;
    } else {
      abi::tell(text, "%s.", abi::text(status));
    }
  }
  if (made != MYOGROWTH_OK) refuse(common, p, made);
  write_message(text, message, message_length);
  return made;
}

}  // extern "C"
