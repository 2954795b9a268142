// The C API: unpack, update, convert to the measure asked for, pack, report. myogrowth.h says what it does.
#include "myogrowth.h"

#include <cstring>
#include <myogrowth/kernel.hpp>
#include <myogrowth/left_stretch.hpp>
#include <myogrowth/measures.hpp>
#include <myogrowth/version.hpp>

#include "block.hpp"
#include "point.hpp"

namespace {

using namespace myogrowth;

static_assert(MYOGROWTH_OK == static_cast<int>(Status::ok) &&
                  MYOGROWTH_NOT_FINITE == static_cast<int>(Status::not_finite) &&
                  MYOGROWTH_INVERTED == static_cast<int>(Status::inverted) &&
                  MYOGROWTH_NO_FIBRE == static_cast<int>(Status::no_fibre) &&
                  MYOGROWTH_BAD_STATE == static_cast<int>(Status::bad_state) &&
                  MYOGROWTH_NOT_CONVERGED == static_cast<int>(Status::not_converged),
              "the kernel's status is passed on as it is");

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// What the points of a call have in common.
struct Common {
  abi::Properties properties;
  int n_state;
  double dt;
  int measure;
};

// The arrays of one point.
struct Point {
  const double *F, *state_in;
  double *state_out, *stress, *tangent, *energy;
};

void set_nan(double* x, int n) {
  for (int i = 0; i < n && x; ++i) x[i] = not_a_number;
}

void write_message(const char* text, char* message, int length) {
  if (message && length > 0) std::snprintf(message, static_cast<std::size_t>(length), "%s", text);
}

int check_props(const double* props, int n_props, abi::Properties& properties, abi::Text& text) {
  if (!props) {
    abi::tell(text, "props = NULL: the constants are needed.");
    return MYOGROWTH_BAD_ARGUMENT;
  }
  const bool fault = abi::find_props_fault(props, n_props, properties, text) ||
                     abi::find_hybrid_fault("the C API", properties, text);
  return fault ? MYOGROWTH_BAD_PARAMETER : MYOGROWTH_OK;
}

// Checks what the points have in common, and that the arrays of the first are there.
int check(const double* props, int n_props, const Point& first, Common& common, abi::Text& text) {
  if (!first.F || !first.state_in || !first.state_out || !first.stress) {
    abi::tell(text, "%s = NULL: it is needed.",
              !first.F           ? "F"
              : !first.state_in  ? "state_in"
              : !first.state_out ? "state_out"
                                 : "stress");
    return MYOGROWTH_BAD_ARGUMENT;
  }
  if (myogrowth_stress_size(common.measure) == 0) {
    abi::tell(text, "measure = %d: must be %d (Cauchy), %d (first Piola) or %d (second Piola).",
              common.measure, MYOGROWTH_CAUCHY, MYOGROWTH_FIRST_PIOLA, MYOGROWTH_SECOND_PIOLA);
    return MYOGROWTH_BAD_ARGUMENT;
  }
  if (abi::find_room_fault("n_state", common.n_state, text)) return MYOGROWTH_BAD_ARGUMENT;
  const int status = check_props(props, n_props, common.properties, text);
  if (status == MYOGROWTH_OK && abi::find_stretch_fault("n_state", common.n_state, common.properties, text)) {
    return MYOGROWTH_BAD_ARGUMENT;
  }
  if (status == MYOGROWTH_OK && common.properties.local_basis && common.measure != MYOGROWTH_CAUCHY) {
    abi::tell(text,
              "PROPS(10) = 1: frame must be 0 with a Piola stress, which refers to F itself and not to "
              "sqrt(F F^T).");
    return MYOGROWTH_BAD_PARAMETER;
  }
  return status;
}

void convert(int measure, const double* F, const PointUpdate<double>& u, double* stress, double* tangent) {
  double c[36];
  if (tangent && measure != MYOGROWTH_CAUCHY) spatial_modulus(u, c);
  switch (measure) {
    case MYOGROWTH_CAUCHY:
      cauchy_from_kirchhoff(u.J, u.tau, stress);
      if (tangent) spatial_modulus(u, tangent, 1 / u.J);
      return;
    case MYOGROWTH_FIRST_PIOLA:
      first_piola_from_kirchhoff(F, u.tau, stress);
      if (tangent) dP_dF_from_jaumann(F, u.tau, c, tangent);
      return;
    default:
      second_piola_from_kirchhoff(F, u.tau, stress);
      if (tangent) dS_dE_from_jaumann(F, u.tau, c, tangent);
  }
}

constexpr int n_ours = abi::fibre_entry + 3;  // entries of the state that are written

void write_state(const double (&ours)[n_ours], int n_state, const Point& p) {
  const int room = abi::keeps_fibre(n_state) ? n_ours : abi::fibre_entry;
  for (int i = 0; i < n_state; ++i) p.state_out[i] = i < room ? ours[i] : p.state_in[i];
}

// The update of one point. On failure it writes the text and not the state; stress and tangent are then for
// refuse() to wipe.
int update(const Common& common, const Point& p, abi::Text& text) {
  const double* given = common.properties.n0;
  double n0[3] = {given[0], given[1], given[2]};
  if (abi::find_state_fault(p.state_in, common.n_state, common.properties, text)) return MYOGROWTH_BAD_STATE;
  if (abi::find_fibre_fault(p.state_in, common.n_state, n0, text)) return MYOGROWTH_NO_FIBRE;

  double V[9];  // an F that has none is refused below
  const bool turned = common.properties.local_basis && left_stretch(p.F, V);
  const double* F = turned ? V : p.F;
  const double G_n = p.state_in[0] == 0 ? 1 : p.state_in[0];
  PointUpdate<double> u;
  const double lambda_n = abi::stretch_at_start(p.state_in, common.n_state);
  Status status = update_point(common.properties.material, F, n0, G_n, lambda_n, common.dt, u);
  // det F can be 0 to the one and > 0 to the other, to rounding: F itself is then the wrong one.
  if (status == Status::ok && common.properties.local_basis && !turned) status = Status::inverted;
  if (status == Status::ok) {
    convert(common.measure, F, u, p.stress, p.tangent);
    const int n = myogrowth_stress_size(common.measure);
    const bool finite = are_finite(p.stress, n) && (!p.tangent || are_finite(p.tangent, n * n));
    if (!finite) status = Status::not_finite;
  }
  if (status != Status::ok) {
    abi::tell(text, "%s.", myogrowth_status_text(static_cast<int>(status)));
    return static_cast<int>(status);
  }
  if (p.energy) *p.energy = u.psi;
  write_state({u.G, u.lambda_e, u.lambda, u.J, u.Je, u.n0[0], u.n0[1], u.n0[2]}, common.n_state, p);
  return MYOGROWTH_OK;
}

// The results of a point that has none.
void refuse(int measure, const Point& p) {
  const int n = myogrowth_stress_size(measure);
  set_nan(p.stress, n);
  set_nan(p.tangent, n * n);
  if (n > 0) set_nan(p.energy, 1);
}

// Point i of an array of `size` numbers a point, which may be NULL.
template <class T>
T* at(T* array, int i, int size) {
  return array ? array + static_cast<std::ptrdiff_t>(i) * size : nullptr;
}

// The points of a call, n of each array one after the other.
struct Points {
  Point first;
  int stress_size, state_stride;
  Point operator[](int i) const {
    return {at(first.F, i, 9),
            at(first.state_in, i, state_stride),
            at(first.state_out, i, state_stride),
            at(first.stress, i, stress_size),
            at(first.tangent, i, stress_size * stress_size),
            at(first.energy, i, 1)};
  }
};

// x[0], x[stride], ... one after the other.
template <int n>
void gather(const double* x, double* to) {
  for (int i = 0; i < n; ++i) to[i] = x[i * myogrowth_block_points];
}

// The batch's update of the points from `start` on, at most a block of them. done[k]: whether point start + k
// has a result; the others are as they were, and update() says why.
void update_many(const Common& common, const Points& points, int start, int count, bool* done) {
  constexpr int stride = myogrowth_block_points;
  const abi::Properties& properties = common.properties;
  MyogrowthBlock block;
  block.dt = common.dt;
  abi::Text ignored;
  for (int k = 0; k < count; ++k) {
    const Point p = points[start + k];
    double n0[3] = {properties.n0[0], properties.n0[1], properties.n0[2]}, unit[3] = {1, 0, 0};
    const double G_n = abi::number_at_start(p.state_in);
    done[k] = !abi::find_state_fault(p.state_in, common.n_state, properties, ignored) &&
              !abi::find_fibre_fault(p.state_in, common.n_state, n0, ignored) && normalise(n0, unit) &&
              abi::packs_can(p.F, G_n);
    const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, *F = done[k] ? p.F : identity;
    for (int i = 0; i < 9; ++i) block.F[k + stride * i] = F[i];
    for (int i = 0; i < 3; ++i) block.n0[k + stride * i] = unit[i];
    block.G[k] = done[k] ? G_n : 1;
    block.lambda[k] = done[k] ? abi::stretch_at_start(p.state_in, common.n_state) : 1;
  }
  const MyogrowthBlockMaterial material = abi::block_material(properties.material);
  abi::update_block()(&material, count, common.measure, points.first.tangent != nullptr, &block);

  for (int k = 0; k < count; ++k) {
    done[k] = done[k] && block.check[k] == 0;
    if (!done[k]) continue;
    const Point p = points[start + k];
    if (points.stress_size == 6) {
      gather<6>(block.stress + k, p.stress);
      if (p.tangent) gather<36>(block.tangent + k, p.tangent);
    } else {
      gather<9>(block.stress + k, p.stress);
      if (p.tangent) gather<81>(block.tangent + k, p.tangent);
    }
    const double* s = block.scalars + k;
    if (p.energy) *p.energy = s[4 * stride];
    write_state({block.G_end[k], s[0], s[stride], s[2 * stride], s[3 * stride], block.n0[k],
                 block.n0[k + stride], block.n0[k + 2 * stride]},
                common.n_state, p);
  }
}

// Index of a symbol in a table of n entries.
int find(const char* symbol, const char* (*symbol_of)(int), int n) {
  for (int i = 0; i < n && symbol; ++i) {
    if (std::strcmp(symbol, symbol_of(i)) == 0) return i;
  }
  return -1;
}

bool is_prop(int i) { return 0 <= i && i < abi::n_props; }
bool is_state(int i) { return 0 <= i && i < abi::n_statev; }

#define MYOGROWTH_TEXT_OF(x) #x
#define MYOGROWTH_VERSION_OF(a, b, c) MYOGROWTH_TEXT_OF(a) "." MYOGROWTH_TEXT_OF(b) "." MYOGROWTH_TEXT_OF(c)

}  // namespace

extern "C" {

const char* myogrowth_status_text(int status) {
  switch (status) {
    case MYOGROWTH_OK:
    case MYOGROWTH_NOT_FINITE:
    case MYOGROWTH_INVERTED:
    case MYOGROWTH_NO_FIBRE:
    case MYOGROWTH_BAD_STATE:
    case MYOGROWTH_NOT_CONVERGED:
      return abi::text(static_cast<Status>(status));
    case MYOGROWTH_BAD_PARAMETER:
      return "bad parameter: an entry of props is missing or not allowed";
    case MYOGROWTH_BAD_ARGUMENT:
      return "bad argument: a NULL pointer, an unknown measure, or no room for the state";
  }
  return "unknown status";
}

int myogrowth_stress_size(int measure) {
  switch (measure) {
    case MYOGROWTH_CAUCHY:
    case MYOGROWTH_SECOND_PIOLA:
      return 6;
    case MYOGROWTH_FIRST_PIOLA:
      return 9;
  }
  return 0;
}

void myogrowth_version(int* major, int* minor, int* patch) {
  *major = MYOGROWTH_VERSION_MAJOR;
  *minor = MYOGROWTH_VERSION_MINOR;
  *patch = MYOGROWTH_VERSION_PATCH;
}
const char* myogrowth_version_text(void) {
  return MYOGROWTH_VERSION_OF(MYOGROWTH_VERSION_MAJOR, MYOGROWTH_VERSION_MINOR, MYOGROWTH_VERSION_PATCH);
}

int myogrowth_n_props(void) { return abi::n_props; }
int myogrowth_n_props_required(void) { return abi::n_props_required; }
const char* myogrowth_prop_symbol(int i) { return is_prop(i) ? abi::property(i).symbol : nullptr; }
const char* myogrowth_prop_unit(int i) { return is_prop(i) ? abi::property(i).unit : nullptr; }
const char* myogrowth_prop_meaning(int i) { return is_prop(i) ? abi::property(i).meaning : nullptr; }
const char* myogrowth_prop_allowed(int i) {
  return is_prop(i) ? abi::text(abi::property(i).allowed) : nullptr;
}
double myogrowth_prop_default(int i) {
  return is_prop(i) && i >= abi::n_props_required ? abi::property(i).initial : not_a_number;
}
int myogrowth_prop_index(const char* symbol) { return find(symbol, myogrowth_prop_symbol, abi::n_props); }

int myogrowth_n_state(void) { return abi::n_statev; }
int myogrowth_n_state_required(void) { return abi::n_statev_required; }
const char* myogrowth_state_symbol(int i) { return is_state(i) ? abi::state_variable(i).symbol : nullptr; }
const char* myogrowth_state_unit(int i) { return is_state(i) ? "-" : nullptr; }  // ratios, all of them
const char* myogrowth_state_meaning(int i) { return is_state(i) ? abi::state_variable(i).meaning : nullptr; }
double myogrowth_state_initial(int i) {
  const bool is_fibre = abi::fibre_entry <= i && i < abi::fibre_entry + 3;
  return !is_state(i) ? not_a_number : is_fibre ? 0 : 1;
}
int myogrowth_state_index(const char* symbol) { return find(symbol, myogrowth_state_symbol, abi::n_statev); }

int myogrowth_check(const double* props, int n_props, char* message, int message_length) {
  abi::Properties properties;
  abi::Text text = "";
  const int status = check_props(props, n_props, properties, text);
  write_message(text, message, message_length);
  return status;
}

int myogrowth_update(const double* props, int n_props, const double F[9], const double* state_in,
                     double* state_out, int n_state, double dt, int measure, double* stress, double* tangent,
                     double* energy, char* message, int message_length) {
  const Point p{F, state_in, state_out, stress, tangent, energy};
  Common common{{}, n_state, dt, measure};
  abi::Text text;
  text[0] = '\0';
  int status = check(props, n_props, p, common, text);
  if (status == MYOGROWTH_OK) status = update(common, p, text);
  if (status != MYOGROWTH_OK) refuse(measure, p);
  write_message(text, message, message_length);
  return status;
}

int myogrowth_update_n(int n_points, const double* props, int n_props, const double* F,
                       const double* state_in, double* state_out, int n_state, double dt, int measure,
                       double* stress, double* tangent, double* energy, int* status, char* message,
                       int message_length) {
  write_message("", message, message_length);
  if (n_points <= 0) return 0;
  Common common{{}, n_state, dt, measure};
  abi::Text text;
  const int fault =
      check(props, n_props, Point{F, state_in, state_out, stress, tangent, energy}, common, text);
  if (fault != MYOGROWTH_OK) write_message(text, message, message_length);

  const Points points{{F, state_in, state_out, stress, tangent, energy},
                      myogrowth_stress_size(measure),
                      fault == MYOGROWTH_OK ? n_state : 0};
  const bool in_packs = fault == MYOGROWTH_OK && !common.properties.local_basis &&
                        abi::packs_can(common.properties.material, dt);
  int failed = 0;
  for (int start = 0; start < n_points; start += myogrowth_block_points) {
    const int left = n_points - start, count = left < myogrowth_block_points ? left : myogrowth_block_points;
    bool done[myogrowth_block_points] = {};
    if (in_packs) update_many(common, points, start, count, done);
    for (int i = start; i < start + count; ++i) {
      const Point p = points[i];
      const int made = fault != MYOGROWTH_OK ? fault
                       : done[i - start]     ? MYOGROWTH_OK
                                             : update(common, p, text);
      if (status) status[i] = made;
      if (made == MYOGROWTH_OK) continue;
      refuse(measure, p);
      if (++failed == 1 && fault == MYOGROWTH_OK && message && message_length > 0) {
        std::snprintf(message, static_cast<std::size_t>(message_length), "point %d (of 0 to %d): %s", i,
                      n_points - 1, text);
      }
    }
  }
  return failed;
}

}  // extern "C"
