// The C API's tables, texts and sizes: PROPS and STATEV as properties.hpp has them.
#include <myogrowth/version.hpp>

#include "elastic_laws.hpp"
#include "myogrowth.h"

namespace {

using namespace myogrowth;

static_assert(MYOGROWTH_OK == static_cast<int>(UpdateStatus::ok) &&
                  MYOGROWTH_NOT_FINITE == static_cast<int>(UpdateStatus::not_finite) &&
                  MYOGROWTH_INVERTED == static_cast<int>(UpdateStatus::inverted) &&
                  MYOGROWTH_NO_FIBRE == static_cast<int>(UpdateStatus::no_fibre) &&
                  MYOGROWTH_BAD_STATE == static_cast<int>(UpdateStatus::bad_state) &&
                  MYOGROWTH_NOT_CONVERGED == static_cast<int>(UpdateStatus::not_converged),
              "the kernel's status is passed on as it is");

const abi::Property* prop(int i) { return 0 <= i && i < abi::n_props ? &abi::property(i) : nullptr; }
const abi::StateVariable* state(int i) {
  return 0 <= i && i < abi::n_statev ? &abi::state_variable(i) : nullptr;
}
const abi::LawParameters* law_of(int law) {
  return 1 <= law && law <= abi::n_laws ? &abi::parameters_of(static_cast<abi::Law>(law)) : nullptr;
}
const abi::Property* law_entry(int law, int i) {
  return law_of(law) && 0 <= i && i < law_of(law)->size ? &law_of(law)->entry[i] : nullptr;
}
// The columns of a row, which is null where there is none.
const char* symbol(const abi::Property* row) { return row ? row->symbol : nullptr; }
const char* unit(const abi::Property* row) { return row ? row->unit : nullptr; }
const char* meaning(const abi::Property* row) { return row ? row->meaning : nullptr; }
const char* allowed(const abi::Property* row) { return row ? abi::text(row->allowed) : nullptr; }
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

#define MYOGROWTH_TEXT_OF(x) #x
#define MYOGROWTH_VERSION_OF(a, b, c) MYOGROWTH_TEXT_OF(a) "." MYOGROWTH_TEXT_OF(b) "." MYOGROWTH_TEXT_OF(c)

}  // namespace

extern "C" {

const char* myogrowth_status_text(int status) {
  if (status == MYOGROWTH_BAD_PARAMETER) return "bad parameter: an entry of props is missing or not allowed";
  if (status == MYOGROWTH_BAD_ARGUMENT)
    return "bad argument: a NULL pointer, an unknown measure, or no room for the state";
  return abi::text(static_cast<UpdateStatus>(status));  // "unknown status" where it is none
}

int myogrowth_stress_size(int measure) {
  if (measure == MYOGROWTH_FIRST_PIOLA) return 9;
  return measure == MYOGROWTH_CAUCHY || measure == MYOGROWTH_SECOND_PIOLA ? 6 : 0;
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
const char* myogrowth_prop_symbol(int i) { return symbol(prop(i)); }
const char* myogrowth_prop_unit(int i) { return unit(prop(i)); }
const char* myogrowth_prop_meaning(int i) { return meaning(prop(i)); }
const char* myogrowth_prop_allowed(int i) { return allowed(prop(i)); }
double myogrowth_prop_default(int i) {
  return prop(i) && i >= abi::n_props_required ? prop(i)->initial : not_a_number;
}
int myogrowth_prop_index(const char* symbol) { return symbol ? abi::find_property(symbol) : -1; }

int myogrowth_n_laws(void) { return abi::n_laws; }
const char* myogrowth_law_name(int law) { return law_of(law) ? law_of(law)->name : nullptr; }
int myogrowth_law_n_parameters(int law) { return law_of(law) ? law_of(law)->size : 0; }
const char* myogrowth_law_symbol(int law, int i) { return symbol(law_entry(law, i)); }
const char* myogrowth_law_unit(int law, int i) { return unit(law_entry(law, i)); }
const char* myogrowth_law_meaning(int law, int i) { return meaning(law_entry(law, i)); }
const char* myogrowth_law_allowed(int law, int i) { return allowed(law_entry(law, i)); }
double myogrowth_law_default(int law, int i) {
  return law_entry(law, i) ? abi::default_of(static_cast<abi::Law>(law), i, false) : not_a_number;
}
double myogrowth_law_default_of_tendon(int law, int i) {
  return law_entry(law, i) ? abi::default_of(static_cast<abi::Law>(law), i, true) : not_a_number;
}

int myogrowth_n_state(void) { return abi::n_statev; }
int myogrowth_n_state_required(void) { return abi::n_statev_required; }
const char* myogrowth_state_symbol(int i) { return state(i) ? state(i)->symbol : nullptr; }
const char* myogrowth_state_unit(int i) { return state(i) ? "-" : nullptr; }  // ratios, all of them
const char* myogrowth_state_meaning(int i) { return state(i) ? state(i)->meaning : nullptr; }
double myogrowth_state_initial(int i) {
  const bool is_fibre = abi::fibre_entry <= i && i < abi::fibre_entry + 3;
  return !state(i) ? not_a_number : is_fibre ? 0 : 1;
}
int myogrowth_state_index(const char* symbol) {
  for (int i = 0; i < abi::n_statev && symbol; ++i) {
    if (std::strcmp(symbol, state(i)->symbol) == 0) return i;
  }
  return -1;
}

}  // extern "C"
