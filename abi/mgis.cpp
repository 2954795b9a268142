// The generic behaviour `FibreGrowth`, libmyogrowth_mgis.so, for all that loads behaviours through MGIS
// (MFrontGenericInterfaceSupport): dolfinx, MFEM-MGIS, OpenGeoSys ... examples/mgis/README.md says how.
//
// Neither MGIS nor MFront is needed to build this. What is laid out here in our own words are facts of
// theirs:
//   TFEL 4.1  mfront/include/MFront/GenericBehaviour/BehaviourData.h, State.h   the structures, K,
//   error_message
//             mfront/include/MFront/GenericBehaviour/Integrate.hxx              K[0], rdt, what is returned
//             mfront/src/SymbolsGenerator.cxx, GenericBehaviourSymbolsGenerator.cxx     names of the symbols
//   MGIS 3    include/MGIS/Behaviour/BehaviourDataView.hxx, StateView.hxx       the same structures
//             include/MGIS/Config.hxx                                           API version 1
//             src/LibrariesManager.cxx, BehaviourDescription.cxx, Behaviour.cxx what a host reads, and K[2] =
//             3 src/FiniteStrainSupport.cxx                                       component orders, rows
//             first
//
// Components: tensors 11 22 33 12 21 13 31 23 32, symmetric ones 11 22 33 12 13 23 with shears times sqrt(2);
// in two dimensions the first five and four. Operators are stored row by row.
#include <atomic>
#include <cstdio>
#include <cstring>
#include <limits>
#include <myogrowth/measures.hpp>
#include <myogrowth/stress_states.hpp>
#include <myogrowth/version.hpp>

#include "point.hpp"

namespace {

using namespace myogrowth;

// The material at one end of the time step. `Out`: const double at its beginning.
template <class Out>
struct StateView {
  const double* gradients;
  Out* thermodynamic_forces;
  const double* mass_density;
  const double* material_properties;
  Out* internal_state_variables;
  Out* stored_energy;
  Out* dissipated_energy;
  const double* external_state_variables;
};

struct BehaviourData {
  char* error_message;  // null, or room for 512 characters
  double dt;
  double* K;  // in: what is asked for, K[0..2]; out: the operator
  double* rdt;
  double* speed_of_sound;
  StateView<const double> s0;
  StateView<double> s1;
};

struct Hypothesis {
  int n_tensor, n_symmetric;
  bool plane_stress;
  int n_stress(int measure) const { return measure == 2 ? n_tensor : n_symmetric; }
  int n_operator(int tangent) const {
    return (tangent == 2 ? n_tensor : n_symmetric) * (tangent == 1 ? n_symmetric : n_tensor);
  }
};

// Where the components of F are in our nine, column by column.
constexpr int place[9] = {0, 4, 8, 3, 1, 6, 2, 7, 5};
constexpr int n_material_properties = 9;               // PROPS(1:9)
constexpr int first_parameter = 10, n_parameters = 7;  // PROPS(11:17)
constexpr int n_variables = abi::fibre_entry, n_variables_plane_stress = n_variables + 1;
constexpr double root_two = 1.4142135623730950488;

double weight(int a) { return a < 3 ? 1 : root_two; }

// Parameters have defaults and are set for the whole process, as those of MFront are.
std::atomic<double> parameters[n_parameters] = {{abi::property(10).initial}, {abi::property(11).initial},
                                                {abi::property(12).initial}, {abi::property(13).initial},
                                                {abi::property(14).initial}, {abi::property(15).initial},
                                                {abi::property(16).initial}};

// What K[0..2] ask for.
struct Request {
  bool only_prediction, with_operator, with_growth;
  int measure;  // 0: Cauchy, 1: second Piola, 2: first Piola
  int tangent;  // 0: dsigma/dF, 1: dS/dE, 2: dP/dF, 3: dtau/d(F F0^-1)
};

int nearest(double x, int last) {
  for (int i = 0; i <= last; ++i) {
    if (x < i + 0.5) return i;
  }
  return -1;
}

bool find_request_fault(const double* K, Request& r, abi::Text& text) {
  if (K[0] > 50) return abi::tell(text, "K[0] = %g: the speed of sound is not computed.", K[0]);
  r.only_prediction = K[0] < -0.25;
  r.with_operator = r.only_prediction || K[0] >= 0.5;
  r.with_growth = K[0] < -2.5 || K[0] >= 2.5;  // else the elastic operator, which is the secant one too
  r.measure = nearest(K[1], 2);
  r.tangent = nearest(K[2], 3);
  if (r.measure < 0) return abi::tell(text, "K[1] = %g: the stress measure must be 0, 1 or 2.", K[1]);
  if (r.tangent < 0) return abi::tell(text, "K[2] = %g: the operator must be 0, 1, 2 or 3.", K[2]);
  return false;
}

bool find_properties_fault(const double* given, abi::Properties& properties, abi::Text& text) {
  double known[abi::n_props];
  for (int i = 0; i < abi::n_props; ++i) known[i] = abi::property(i).initial;
  for (int i = 0; i < n_material_properties; ++i) known[i] = given[i];
  for (int i = 0; i < n_parameters; ++i) {
    known[first_parameter + i] = parameters[i].load(std::memory_order_relaxed);
  }
  const int bad = abi::read(known, properties);
  if (bad >= 0) {
    return abi::tell_bad_entry(bad, known[bad], text);
  }
  const double* n0 = properties.n0;
  if (n0[0] == 0 && n0[1] == 0 && n0[2] == 0) {
    return abi::tell(text, "n0_1, n0_2, n0_3 = 0, 0, 0: n0, the fibre direction, must have a length > 0.");
  }
  return false;
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

void take_deformation(const double* gradients, const Hypothesis& h, double F[9]) {
  for (int i = 0; i < 9; ++i) F[i] = i % 4 == 0 ? 1 : 0;
  for (int i = 0; i < h.n_tensor; ++i) F[place[i]] = gradients[i];
}

Status update(const abi::Properties& p, const Hypothesis& h, const double* statev, double dt, double F[9],
              PointUpdate<double>& u) {
  const double G_n = abi::number_at_start(statev), lambda_n = abi::stretch_at_start(statev, abi::n_statev);
  if (!h.plane_stress) return update_point(p.material, F, p.n0, G_n, lambda_n, dt, u);
  const double in_plane[4] = {F[0], F[1], F[3], F[4]};
  double thickness = statev[abi::thickness_entry], ignored[9];
  plane_stress(p.material, in_plane, p.n0, G_n, lambda_n, dt, thickness, u, ignored);
  F[8] = thickness;
  return u.status;
}

// In plane stress F33 follows the plane, by dP33 = 0 (for dS/dE: dS33 = 0). To X[rows x columns] its part is
// added; `row`: of the stress that vanishes, i33: its column.
void condense(double* X, int rows, int columns, const double* row, int i33) {
  double ratio[9], column33[9];
  for (int j = 0; j < columns; ++j) ratio[j] = row[j] / row[i33];
  for (int i = 0; i < rows; ++i) column33[i] = X[i + rows * i33];
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) X[i + rows * j] -= column33[i] * ratio[j];
  }
}

void write_stress(int measure, const Hypothesis& h, const double* F, const PointUpdate<double>& u,
                  double* stress) {
  double P[9], six[6];
  if (measure == 2) {
    first_piola_from_kirchhoff(F, u.tau, P);
    for (int i = 0; i < h.n_tensor; ++i) stress[i] = P[place[i]];
    return;
  }
  if (measure == 0) cauchy_from_kirchhoff(u.J, u.tau, six);
  if (measure == 1) second_piola_from_kirchhoff(F, u.tau, six);
  for (int a = 0; a < h.n_symmetric; ++a) stress[a] = weight(a) * six[a];
}

// dS/dE: both sides have shears times sqrt(2), while ours has columns of engineering shear.
void write_dS_dE(const Hypothesis& h, const double* F, const PointUpdate<double>& u, const double* c,
                 double* K) {
  double X[36];
  dS_dE_from_jaumann(F, u.tau, c, X);
  if (h.plane_stress) {
    double row[6];
    for (int j = 0; j < 6; ++j) row[j] = X[2 + 6 * j];
    condense(X, 6, 6, row, 2);
  }
  for (int a = 0; a < h.n_symmetric; ++a) {
    for (int b = 0; b < h.n_symmetric; ++b) K[b + h.n_symmetric * a] = weight(a) * weight(b) * X[a + 6 * b];
  }
}

// The others, which differentiate by F. F0: at the beginning of the step, for dtau/d(F F0^-1).
void write_dX_dF(int tangent, const Hypothesis& h, const double* F, const double* F0,
                 const PointUpdate<double>& u, const double* c, double* K) {
  double P[9], A[81], X[54], Y[54], row[9];
  first_piola_from_kirchhoff(F, u.tau, P);
  dP_dF_from_jaumann(F, u.tau, c, A);
  dtau_dF_from_dP_dF(F, P, A, X);
  if (tangent == 0) {
    dsigma_dF_from_dtau_dF(F, u.J, u.tau, X, Y);
    std::memcpy(X, Y, sizeof X);
  }
  if (h.plane_stress) {
    for (int j = 0; j < 9; ++j) row[j] = A[8 + 9 * j];
    condense(A, 9, 9, row, 8);
    condense(X, 6, 9, row, 8);
  }
  if (tangent == 3) {  // F = (F F0^-1) F0
    for (int a = 0; a < 6; ++a) {
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) {
          Y[a + 6 * (k + 3 * l)] =
              X[a + 6 * k] * F0[l] + X[a + 6 * (k + 3)] * F0[l + 3] + X[a + 6 * (k + 6)] * F0[l + 6];
        }
      }
    }
    std::memcpy(X, Y, sizeof X);
  }
  const int rows = tangent == 2 ? h.n_tensor : h.n_symmetric;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < h.n_tensor; ++j) {
      K[j + h.n_tensor * i] = tangent == 2 ? A[place[i] + 9 * place[j]] : weight(i) * X[i + 6 * place[j]];
    }
  }
}

int fail(BehaviourData& d, const abi::Text& text) {
  if (d.error_message) std::snprintf(d.error_message, 512, "FibreGrowth: %s", text);
  if (d.rdt && !(*d.rdt <= abi::cut_back)) *d.rdt = abi::cut_back;
  return -1;
}

// The results of a point that has none: NaN, so that no host can continue silently.
int refuse(const Hypothesis& h, const Request& request, BehaviourData& d, const abi::Text& text) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < h.n_operator(request.tangent) && request.with_operator; ++i) d.K[i] = nan;
  if (!request.only_prediction) {
    for (int i = 0; i < h.n_stress(request.measure); ++i) d.s1.thermodynamic_forces[i] = nan;
    if (d.s1.stored_energy) *d.s1.stored_energy = nan;
  }
  return fail(d, text);
}

int integrate(const Hypothesis& h, BehaviourData& d) {
  Request request{};
  abi::Properties properties;
  double statev[abi::n_statev];
  abi::Text text;
  if (find_request_fault(d.K, request, text)) return fail(d, text);
  if (find_properties_fault(d.s1.material_properties, properties, text) ||
      find_state_fault(d.s0.internal_state_variables, h, properties, statev, text)) {
    return refuse(h, request, d, text);
  }

  double F[9], F0[9];
  take_deformation(d.s0.gradients, h, F0);
  take_deformation(request.only_prediction ? d.s0.gradients : d.s1.gradients, h, F);
  const double dt = request.only_prediction && !request.with_growth ? 0 : d.dt;
  PointUpdate<double> u;
  const double G_n = abi::number_at_start(statev), lambda_n = abi::stretch_at_start(statev, abi::n_statev);
  Status status = update(properties, h, statev, dt, F, u);

  double stress[9], K[81];
  const int n_stress = h.n_stress(request.measure), n_operator = h.n_operator(request.tangent);
  if (status == Status::ok) {
    write_stress(request.measure, h, F, u, stress);
    if (!are_finite(stress, n_stress)) status = Status::not_finite;
  }
  if (status == Status::ok && request.with_operator) {
    double c[36];
    PointUpdate<double> v = u;
    if (!request.with_growth) v.dG_dlambda = 0;
    spatial_modulus(v, c);
    if (request.tangent == 1) {
      write_dS_dE(h, F, v, c, K);
    } else {
      write_dX_dF(request.tangent, h, F, F0, v, c, K);
    }
    if (!are_finite(K, n_operator)) status = Status::not_finite;
  }
  if (status != Status::ok) {
    abi::tell(text, "%s.", abi::text(status));
    return refuse(h, request, d, text);
  }

  if (request.with_operator) std::memcpy(d.K, K, sizeof(double) * static_cast<std::size_t>(n_operator));
  if (request.only_prediction) return 1;
  for (int i = 0; i < n_stress; ++i) d.s1.thermodynamic_forces[i] = stress[i];
  abi::write_state(u, d.s1.internal_state_variables, n_variables);
  if (h.plane_stress) d.s1.internal_state_variables[n_variables] = F[8];
  if (d.s1.stored_energy) *d.s1.stored_energy = u.psi;
  if (properties.tolerance > 0 && d.rdt) {
    const double advice = abi::advised_factor(properties, G_n, lambda_n, u.lambda, dt);
    if (!(*d.rdt <= advice)) *d.rdt = advice;
    if (advice < 0.99) return 0;  // there is a result, but a shorter step is asked for
  }
  return 1;
}

using Name = const char*;
template <int n>
using Names = const char* [n];
template <int n>
using Types = int[n];

constexpr Name symbol(int i) noexcept { return abi::Tables<>::property[i].symbol; }
constexpr Name variable(int i) noexcept { return abi::Tables<>::state_variable[i].symbol; }

}  // namespace

extern "C" {

#define MYOGROWTH_MGIS(type, name)      \
  extern const type FibreGrowth_##name; \
  const type FibreGrowth_##name

// What the entry is.
MYOGROWTH_MGIS(Name, mfront_ept) = "FibreGrowth";
MYOGROWTH_MGIS(Name, tfel_version) = "4.1.0";  // whose conventions are followed; no part of it is in here
MYOGROWTH_MGIS(Name, unit_system) = "";
MYOGROWTH_MGIS(Name, mfront_interface) = "Generic";
MYOGROWTH_MGIS(Name, src) = "myogrowth, abi/mgis.cpp";
MYOGROWTH_MGIS(unsigned short, mfront_mkt) = 1;     // a behaviour
MYOGROWTH_MGIS(unsigned short, api_version) = 1;    // TFEL 3.4.1 and after
MYOGROWTH_MGIS(unsigned short, BehaviourType) = 2;  // of finite strain
MYOGROWTH_MGIS(unsigned short,
               BehaviourKinematic) = 3;            // F and the Cauchy stress, K[1] and K[2] asking for others
MYOGROWTH_MGIS(unsigned short, SymmetryType) = 0;  // no material frame: n0 is in the axes of F
MYOGROWTH_MGIS(unsigned short, ElasticSymmetryType) = 0;
MYOGROWTH_MGIS(unsigned short, UsableInPurelyImplicitResolution) = 1;
MYOGROWTH_MGIS(unsigned short, requiresStiffnessTensor) = 0;
MYOGROWTH_MGIS(unsigned short, requiresThermalExpansionCoefficientTensor) = 0;
MYOGROWTH_MGIS(unsigned short, ComputesInternalEnergy) = 1;
MYOGROWTH_MGIS(unsigned short, ComputesDissipatedEnergy) = 0;
MYOGROWTH_MGIS(unsigned short, nModellingHypotheses) = 4;
MYOGROWTH_MGIS(Names<4>, ModellingHypotheses) = {"Axisymmetrical", "PlaneStress", "PlaneStrain",
                                                 "Tridimensional"};

// Gradients, forces, operator. Types: 0 scalar, 1 symmetric tensor, 3 tensor.
MYOGROWTH_MGIS(unsigned short, nMainVariables) = 1;
MYOGROWTH_MGIS(unsigned short, nGradients) = 1;
MYOGROWTH_MGIS(Names<1>, Gradients) = {"DeformationGradient"};
MYOGROWTH_MGIS(Types<1>, GradientsTypes) = {3};
MYOGROWTH_MGIS(unsigned short, nThermodynamicForces) = 1;
MYOGROWTH_MGIS(Names<1>, ThermodynamicForces) = {"Stress"};
MYOGROWTH_MGIS(Types<1>, ThermodynamicForcesTypes) = {1};
MYOGROWTH_MGIS(unsigned short, nTangentOperatorBlocks) = 2;
MYOGROWTH_MGIS(Names<2>, TangentOperatorBlocks) = {"Stress", "DeformationGradient"};

// Material properties: PROPS(1:9). Temperature, which MGIS adds to the external state variables, is not read.
MYOGROWTH_MGIS(unsigned short, nMaterialProperties) = n_material_properties;
MYOGROWTH_MGIS(Names<n_material_properties>, MaterialProperties) = {
    symbol(0), symbol(1), symbol(2), symbol(3), symbol(4), symbol(5), symbol(6), symbol(7), symbol(8)};
MYOGROWTH_MGIS(long double, c2_LowerPhysicalBound) = 0;
MYOGROWTH_MGIS(long double, tau_LowerPhysicalBound) = 0;
MYOGROWTH_MGIS(long double, gamma_LowerPhysicalBound) = 0;
MYOGROWTH_MGIS(long double, G_max_LowerPhysicalBound) = 1;
MYOGROWTH_MGIS(long double, lambda_crit_LowerPhysicalBound) = 0;
MYOGROWTH_MGIS(unsigned short, nExternalStateVariables) = 0;
MYOGROWTH_MGIS(Names<1>, ExternalStateVariables) = {nullptr};
MYOGROWTH_MGIS(Types<1>, ExternalStateVariablesTypes) = {0};
MYOGROWTH_MGIS(unsigned short, nInitializeFunctions) = 0;
MYOGROWTH_MGIS(Names<1>, InitializeFunctions) = {nullptr};
MYOGROWTH_MGIS(unsigned short, nPostProcessings) = 0;
MYOGROWTH_MGIS(Names<1>, PostProcessings) = {nullptr};

// Internal state variables: STATEV(1:5), and in plane stress STATEV(9). Zeros do at the beginning.
MYOGROWTH_MGIS(unsigned short, nInternalStateVariables) = n_variables;
MYOGROWTH_MGIS(Names<n_variables>, InternalStateVariables) = {variable(0), variable(1), variable(2),
                                                              variable(3), variable(4)};
MYOGROWTH_MGIS(Types<n_variables>, InternalStateVariablesTypes) = {};
MYOGROWTH_MGIS(unsigned short, PlaneStress_nInternalStateVariables) = n_variables_plane_stress;
MYOGROWTH_MGIS(Names<n_variables_plane_stress>, PlaneStress_InternalStateVariables) = {
    variable(0), variable(1), variable(2), variable(3), variable(4), variable(abi::thickness_entry)};
MYOGROWTH_MGIS(Types<n_variables_plane_stress>, PlaneStress_InternalStateVariablesTypes) = {};
MYOGROWTH_MGIS(long double, G_LowerPhysicalBound) = 0;

// Parameters: PROPS(11:17), all of them real numbers (type 0).
MYOGROWTH_MGIS(unsigned short, nParameters) = n_parameters;
MYOGROWTH_MGIS(Names<n_parameters>, Parameters) = {symbol(10), symbol(11), symbol(12), symbol(13),
                                                   symbol(14), symbol(15), symbol(16)};
MYOGROWTH_MGIS(Types<n_parameters>, ParametersTypes) = {};
MYOGROWTH_MGIS(double, energy_ParameterDefaultValue) = abi::Tables<>::property[10].initial;
MYOGROWTH_MGIS(double, integration_ParameterDefaultValue) = abi::Tables<>::property[11].initial;
MYOGROWTH_MGIS(double, tolerance_ParameterDefaultValue) = abi::Tables<>::property[12].initial;
MYOGROWTH_MGIS(double, tau_rev_ParameterDefaultValue) = abi::Tables<>::property[13].initial;
MYOGROWTH_MGIS(double, gamma_rev_ParameterDefaultValue) = abi::Tables<>::property[14].initial;
MYOGROWTH_MGIS(double, G_min_ParameterDefaultValue) = abi::Tables<>::property[15].initial;
MYOGROWTH_MGIS(double, lambda_crit_rev_ParameterDefaultValue) = abi::Tables<>::property[16].initial;

/// Sets a parameter for the whole process; 1, or 0 if there is none of that name or the value is not finite.
/// What the value must be among the others is checked, and told, where it is used.
int FibreGrowth_setParameter(const char* name, double value) {
  for (int i = 0; i < n_parameters && name && is_finite(value); ++i) {
    if (std::strcmp(name, FibreGrowth_Parameters[i]) != 0) continue;
    parameters[i].store(value, std::memory_order_relaxed);
    return 1;
  }
  return 0;
}

/// One time step at one point. Returns 1; 0 if a shorter step is advised (rdt); -1 if there is no result:
/// error_message says why, stresses, stored energy and operator are NaN (unless K is wrong), rdt is at most
/// 0.25, all else is as it was.
int FibreGrowth_Tridimensional(BehaviourData* d) { return integrate({9, 6, false}, *d); }
int FibreGrowth_PlaneStrain(BehaviourData* d) { return integrate({5, 4, false}, *d); }
int FibreGrowth_Axisymmetrical(BehaviourData* d) { return integrate({5, 4, false}, *d); }
/// F33 is found, not read: the gradients' third entry has no meaning here.
int FibreGrowth_PlaneStress(BehaviourData* d) { return integrate({5, 4, true}, *d); }
}
