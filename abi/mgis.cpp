// The generic behaviours `FibreGrowth` and, with the other elastic laws, `FibreGrowthRoehrle`, `...Blemker`
// and `...Ehret`: libmyogrowth_mgis.so, for all that loads behaviours through MGIS
// (MFrontGenericInterfaceSupport): dolfinx, MFEM-MGIS, OpenGeoSys ... examples/mgis/README.md says how.
// mgis_layout.hpp has how a point is passed, mgis_symbols.cpp what a host reads before it calls.
#include <atomic>
#include <cstdio>
#include <limits>
#include <myogrowth/more/stress_states.hpp>

#include "elastic_laws.hpp"
#include "mgis_layout.hpp"

namespace {

using namespace myogrowth;
using namespace myogrowth::abi::mgis;

// Material properties are PROPS(1:9), or PROPS(3:9) and the parameters of the elastic law; parameters
// PROPS(11:17), internal variables STATEV(1:5) and, in plane stress, STATEV(9): mgis_symbols.cpp.
// Temperature, the first of the external state variables, is not read; the second is Activation.
constexpr int first_parameter = abi::energy_entry, n_parameters = abi::hybrid_entry - first_parameter;
constexpr int n_variables = abi::fibre_entry;
constexpr const char* behaviour[1 + abi::n_laws] = {"FibreGrowth", "FibreGrowthRoehrle", "FibreGrowthBlemker",
                                                    "FibreGrowthEhret"};
// Parameters have defaults and are set for the whole process, as those of MFront are.
#define MYOGROWTH_DEFAULT(symbol, unit, meaning, initial, allowed) {initial},
#define MYOGROWTH_DEFAULTS \
  { MYOGROWTH_PROPS_OF_STEP(MYOGROWTH_DEFAULT) }
std::atomic<double> parameters[1 + abi::n_laws][n_parameters] = {MYOGROWTH_DEFAULTS, MYOGROWTH_DEFAULTS,
                                                                 MYOGROWTH_DEFAULTS, MYOGROWTH_DEFAULTS};
#undef MYOGROWTH_DEFAULTS
#undef MYOGROWTH_DEFAULT

// external: at the end of the step that is looked at.
bool find_properties_fault(abi::Law law, const double* given, const double* external,
                           abi::Properties& properties, abi::LawChoice& choice, abi::Text& text) {
  const int number = static_cast<int>(law), first = number == 0 ? 0 : 2;  // c1 and c2 are those of eq. 3
  double known[abi::n_props];
  for (int i = 0; i < abi::n_props; ++i) known[i] = abi::property(i).initial;
  known[0] = known[1] = 1;
  for (int i = first; i < abi::n_props_plain; ++i) known[i] = given[i - first];
  for (int i = 0; i < n_parameters; ++i) {
    known[first_parameter + i] = parameters[number][i].load(std::memory_order_relaxed);
  }
  const int bad = abi::read(known, properties);
  if (bad >= 0) return abi::tell_bad_entry(bad, known[bad], text);
  choice.law = law;
  if (number > 0) {
    if (!external)
      return abi::tell(text, "there are no external state variables: Temperature and Activation.");
    if (abi::find_parameter_fault(given + abi::n_props_plain - first, abi::parameters_of(law).size, 0, choice,
                                  text))
      return true;
    if (!abi::take_activation(external[1], choice))
      return abi::tell(text, "Activation = %.9g: must be >= 0 and <= 1.", external[1]);
  }
  const double* n0 = properties.n0;
  return n0[0] == 0 && n0[1] == 0 && n0[2] == 0 &&
         abi::tell(text, "n0_1, n0_2, n0_3 = 0, 0, 0: n0, the fibre direction, must have a length > 0.");
}

// The state at the beginning, in the places of STATEV.
bool find_state_fault(const double* given, const Hypothesis& h, const abi::Properties& properties,
                      double (&statev)[abi::n_statev], abi::Text& text) {
  for (double& x : statev) x = 0;
  for (int i = 0; i < n_variables; ++i) statev[i] = given[i];
  if (h.plane_stress) statev[abi::thickness_entry] = given[n_variables];
  const int bad = abi::find_bad_state_entry(statev, abi::n_statev, properties);
  return bad >= 0 &&
         abi::tell(text,
                   "%s = %.9g at the beginning of the step: must be > 0, or 0 where nothing is known yet.",
                   abi::state_variable(bad).symbol, statev[bad]);
}

// a: the activation, where the material has one.
template <class Material, class Point, class... Activation>
UpdateStatus update(const Material& material, const double* n0, const Hypothesis& h, const double* statev,
                    double dt, double F[9], Point& u, const Activation&... a) {
  const double G_n = abi::number_at_start(statev), lambda_n = abi::stretch_at_start(statev, abi::n_statev);
  if (!h.plane_stress) return update_point(material, F, n0, G_n, lambda_n, dt, u, a...);
  const double in_plane[4] = {F[0], F[1], F[3], F[4]};
  double thickness = statev[abi::thickness_entry], ignored[9];
  plane_stress(material, in_plane, n0, G_n, lambda_n, dt, thickness, u, ignored, a...);
  F[8] = thickness;
  return u.status;
}

int fail(abi::Law law, BehaviourData& d, const abi::Text& text) {
  if (d.error_message) std::snprintf(d.error_message, 512, "%s: %s", behaviour[static_cast<int>(law)], text);
  if (d.rdt) abi::lower(*d.rdt, abi::cut_back);
  return -1;
}

// The results of a point that has none: NaN, so that no host can continue silently.
int refuse(abi::Law law, const Hypothesis& h, const Request& request, BehaviourData& d,
           const abi::Text& text) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < h.n_operator(request.tangent) && request.with_operator; ++i) d.K[i] = nan;
  if (!request.only_prediction) {
    for (int i = 0; i < h.n_stress(request.measure); ++i) d.s1.thermodynamic_forces[i] = nan;
    if (d.s1.stored_energy) *d.s1.stored_energy = nan;
  }
  return fail(law, d, text);
}

int integrate(abi::Law law, const Hypothesis& h, BehaviourData& d) {
  Request request{};
  abi::Properties properties;
  abi::LawChoice choice{};
  double statev[abi::n_statev];
  abi::Text text;
  if (find_request_fault(d.K, request, text)) return fail(law, d, text);
  const double* external =
      request.only_prediction ? d.s0.external_state_variables : d.s1.external_state_variables;
  if (find_properties_fault(law, d.s1.material_properties, external, properties, choice, text) ||
      find_state_fault(d.s0.internal_state_variables, h, properties, statev, text)) {
    return refuse(law, h, request, d, text);
  }

  double F[9], F0[9];
  take_deformation(d.s0.gradients, h, F0);
  take_deformation(request.only_prediction ? d.s0.gradients : d.s1.gradients, h, F);
  const double dt = request.only_prediction && !request.with_growth ? 0 : d.dt;
  const double G_n = abi::number_at_start(statev), lambda_n = abi::stretch_at_start(statev, abi::n_statev);
  PointUpdate<double> u;
  double c[36];
  UpdateStatus status = abi::with_material(
      properties.material, choice, [&](auto& point, const auto& material, const auto&... activation) {
        const UpdateStatus made = update(material, properties.n0, h, statev, dt, F, point, activation...);
        u = point;
        if (!request.with_growth) point.dG_dlambda = 0;
        if (request.with_operator) spatial_modulus(point, c);
        return made;
      });

  double stress[9], K[81];
  const int n_stress = h.n_stress(request.measure), n_operator = h.n_operator(request.tangent);
  if (status == UpdateStatus::ok) {
    write_stress(request.measure, h, F, u, stress);
    if (!are_finite(stress, n_stress)) status = UpdateStatus::not_finite;
  }
  if (status == UpdateStatus::ok && request.with_operator) {
    if (request.tangent == 1) {
      write_dS_dE(h, F, u, c, K);
    } else {
      write_dX_dF(request.tangent, h, F, F0, u, c, K);
    }
    if (!are_finite(K, n_operator)) status = UpdateStatus::not_finite;
  }
  if (status != UpdateStatus::ok) {
    abi::tell(text, "%s.", abi::text(status));
    return refuse(law, h, request, d, text);
  }

  if (request.with_operator) std::memcpy(d.K, K, sizeof(double) * static_cast<std::size_t>(n_operator));
  if (request.only_prediction) return 1;
  for (int i = 0; i < n_stress; ++i) d.s1.thermodynamic_forces[i] = stress[i];
  abi::write_state(u, d.s1.internal_state_variables, n_variables);
  if (h.plane_stress) d.s1.internal_state_variables[n_variables] = F[8];
  if (d.s1.stored_energy) *d.s1.stored_energy = u.psi;
  if (properties.tolerance > 0 && d.rdt) {
    const double advice = abi::advised_factor(properties, G_n, lambda_n, u.lambda, dt);
    abi::lower(*d.rdt, advice);
    if (advice < 0.99) return 0;  // there is a result, but a shorter step is asked for
  }
  return 1;
}

int set_parameter(abi::Law law, const char* name, double value) {
  for (int i = 0; i < n_parameters && name && is_finite(value); ++i) {
    if (std::strcmp(name, abi::property(first_parameter + i).symbol) != 0) continue;
    parameters[static_cast<int>(law)][i].store(value, std::memory_order_relaxed);
    return 1;
  }
  return 0;
}

}  // namespace

// setParameter: sets a parameter for the whole process; 1, or 0 if there is none of that name or the value is
// not finite. What the value must be among the others is checked, and told, where it is used.
//
// The others: one time step at one point. They return 1; 0 if a shorter step is advised (rdt); -1 if there is
// no result: error_message says why, stresses, stored energy and operator are NaN (unless K is wrong), rdt is
// at most 0.25, all else is as it was. In plane stress F33 is found, not read: the gradients' third entry has
// no meaning there.
#define MYOGROWTH_BEHAVIOUR(name, law)                                                      \
  int name##_setParameter(const char* parameter, double value) {                            \
    return set_parameter(law, parameter, value);                                            \
  }                                                                                         \
  int name##_Tridimensional(BehaviourData* d) { return integrate(law, {9, 6, false}, *d); } \
  int name##_PlaneStrain(BehaviourData* d) { return integrate(law, {5, 4, false}, *d); }    \
  int name##_Axisymmetrical(BehaviourData* d) { return integrate(law, {5, 4, false}, *d); } \
  int name##_PlaneStress(BehaviourData* d) { return integrate(law, {5, 4, true}, *d); }

extern "C" {
MYOGROWTH_BEHAVIOUR(FibreGrowth, abi::Law::neo_hookean)
MYOGROWTH_BEHAVIOUR(FibreGrowthRoehrle, abi::Law::roehrle)
MYOGROWTH_BEHAVIOUR(FibreGrowthBlemker, abi::Law::blemker)
MYOGROWTH_BEHAVIOUR(FibreGrowthEhret, abi::Law::ehret)
}
