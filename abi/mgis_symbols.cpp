// What MGIS reads of the behaviour `FibreGrowth` before it calls it: mgis.cpp says where the names come from.
// Names and defaults are those of properties.hpp.
#include "properties.hpp"

namespace {

using namespace myogrowth;

using Name = const char*;
template <int n>
using Names = const char* [n];
template <int n>
using Types = int[n];

constexpr int n_parameters = abi::hybrid_entry - abi::energy_entry;  // PROPS(11:17)
constexpr int n_variables = abi::fibre_entry, n_variables_plane_stress = n_variables + 1;

constexpr Name symbol(int i) { return abi::Tables<>::property[i].symbol; }
constexpr Name variable(int i) { return abi::Tables<>::state_variable[i].symbol; }
constexpr bool is_text(Name a, Name b) { return *a == *b && (*a == 0 || is_text(a + 1, b + 1)); }

}  // namespace

extern "C" {

#define MYOGROWTH_MGIS(type, name)      \
  extern const type FibreGrowth_##name; \
  const type FibreGrowth_##name
// Of entry i of PROPS, whose symbol is held to the table.
#define MYOGROWTH_MGIS_BOUND(i, name, bound)                      \
  static_assert(is_text(symbol(i), #name), "the table's symbol"); \
  MYOGROWTH_MGIS(long double, name##_LowerPhysicalBound) = bound
#define MYOGROWTH_MGIS_DEFAULT(i, name)                           \
  static_assert(is_text(symbol(i), #name), "the table's symbol"); \
  MYOGROWTH_MGIS(double, name##_ParameterDefaultValue) = abi::Tables<>::property[i].initial

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
MYOGROWTH_MGIS(unsigned short, nMaterialProperties) = abi::n_props_plain;
MYOGROWTH_MGIS(Names<abi::n_props_plain>, MaterialProperties) = {
    symbol(0), symbol(1), symbol(2), symbol(3), symbol(4), symbol(5), symbol(6), symbol(7), symbol(8)};
MYOGROWTH_MGIS_BOUND(1, c2, 0);
MYOGROWTH_MGIS_BOUND(2, tau, 0);
MYOGROWTH_MGIS_BOUND(3, gamma, 0);
MYOGROWTH_MGIS_BOUND(4, G_max, 1);
MYOGROWTH_MGIS_BOUND(5, lambda_crit, 0);
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
MYOGROWTH_MGIS_DEFAULT(10, energy);
MYOGROWTH_MGIS_DEFAULT(11, integration);
MYOGROWTH_MGIS_DEFAULT(12, tolerance);
MYOGROWTH_MGIS_DEFAULT(13, tau_rev);
MYOGROWTH_MGIS_DEFAULT(14, gamma_rev);
MYOGROWTH_MGIS_DEFAULT(15, G_min);
MYOGROWTH_MGIS_DEFAULT(16, lambda_crit_rev);
}
