// What MGIS reads of a behaviour before it calls it: mgis.cpp says where the names come from. Names and
// defaults are those of properties.hpp and elastic_laws.hpp. Compiled for each behaviour, with
// -DMYOGROWTH_BEHAVIOUR=FibreGrowth... and -DMYOGROWTH_LAW=0 to 3.
#include "elastic_laws.hpp"

namespace {

using namespace myogrowth;

using Name = const char*;
template <int n>
using Names = const char* [n];
template <int n>
using Types = int[n];

#define MYOGROWTH_TEXT_OF(x) #x
#define MYOGROWTH_TEXT(x) MYOGROWTH_TEXT_OF(x)
#define MYOGROWTH_JOINED_OF(a, b) a##_##b
#define MYOGROWTH_JOINED(a, b) MYOGROWTH_JOINED_OF(a, b)

constexpr int n_variables = abi::fibre_entry;
constexpr Name variable(int i) { return abi::Tables<>::state_variable[i].symbol; }

// Of the rows of PROPS: how many, and their names.
#define MYOGROWTH_COUNT(...) +1
#define MYOGROWTH_NAME(symbol, ...) #symbol,
constexpr int n_parameters = MYOGROWTH_PROPS_OF_STEP(MYOGROWTH_COUNT);
static_assert(n_parameters == abi::hybrid_entry - abi::energy_entry, "what mgis.cpp reads");

// Material properties: c1 and c2 of eq. 3, those of growth, those of another elastic law.
#if MYOGROWTH_LAW == 0
constexpr int n_properties = abi::n_props_plain, n_external = 0;
#else
constexpr int n_of_growth = MYOGROWTH_PROPS_OF_GROWTH(MYOGROWTH_COUNT), n_external = 1;
constexpr const abi::LawParameters& law = abi::LawTables<>::law[MYOGROWTH_LAW - 1];
constexpr int n_properties = n_of_growth + law.size;
#endif
struct PropertyNames {  // laid out as an array
  Name data[n_properties];
};
constexpr PropertyNames property_names() {
#if MYOGROWTH_LAW == 0
  return {{MYOGROWTH_PROPS_OF_EQ_3(MYOGROWTH_NAME) MYOGROWTH_PROPS_OF_GROWTH(MYOGROWTH_NAME)}};
#else
  PropertyNames names{{MYOGROWTH_PROPS_OF_GROWTH(MYOGROWTH_NAME)}};
  for (int i = 0; i < law.size; ++i) names.data[n_of_growth + i] = law.entry[i].symbol;
  return names;
#endif
}

}  // namespace

extern "C" {

#define MYOGROWTH_MGIS(type, name)                               \
  extern const type MYOGROWTH_JOINED(MYOGROWTH_BEHAVIOUR, name); \
  const type MYOGROWTH_JOINED(MYOGROWTH_BEHAVIOUR, name)
// A lower bound for the rows that have one, a default.
#define MYOGROWTH_MGIS_BOUND(symbol, unit, meaning, initial, allowed) MYOGROWTH_BOUND_##allowed(symbol)
#define MYOGROWTH_BOUND_positive(symbol) MYOGROWTH_MGIS(long double, symbol##_LowerPhysicalBound) = 0;
#define MYOGROWTH_BOUND_not_negative(symbol) MYOGROWTH_BOUND_positive(symbol)
#define MYOGROWTH_BOUND_above_one(symbol) MYOGROWTH_MGIS(long double, symbol##_LowerPhysicalBound) = 1;
#define MYOGROWTH_BOUND_bulk_positive(symbol)
#define MYOGROWTH_BOUND_any(symbol)
#define MYOGROWTH_MGIS_DEFAULT(symbol, unit, meaning, initial, allowed) \
  MYOGROWTH_MGIS(double, symbol##_ParameterDefaultValue) = initial;

// What the entry is.
MYOGROWTH_MGIS(Name, mfront_ept) = MYOGROWTH_TEXT(MYOGROWTH_BEHAVIOUR);
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

// Material properties. Temperature, which MGIS puts before the external state variables, is not read.
MYOGROWTH_MGIS(unsigned short, nMaterialProperties) = n_properties;
MYOGROWTH_MGIS(PropertyNames, MaterialProperties) = property_names();
#if MYOGROWTH_LAW == 0
MYOGROWTH_PROPS_OF_EQ_3(MYOGROWTH_MGIS_BOUND)
#endif
MYOGROWTH_PROPS_OF_GROWTH(MYOGROWTH_MGIS_BOUND)
MYOGROWTH_MGIS(unsigned short, TemperatureRemovedFromExternalStateVariables) = 1;
MYOGROWTH_MGIS(unsigned short, nExternalStateVariables) = n_external;
MYOGROWTH_MGIS(Names<1>, ExternalStateVariables) = {n_external > 0 ? "Activation" : nullptr};
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
MYOGROWTH_MGIS(unsigned short, PlaneStress_nInternalStateVariables) = n_variables + 1;
MYOGROWTH_MGIS(Names<n_variables + 1>, PlaneStress_InternalStateVariables) = {
    variable(0), variable(1), variable(2), variable(3), variable(4), variable(abi::thickness_entry)};
MYOGROWTH_MGIS(Types<n_variables + 1>, PlaneStress_InternalStateVariablesTypes) = {};
MYOGROWTH_MGIS(long double, G_LowerPhysicalBound) = 0;

// Parameters: PROPS(11:17), all of them real numbers (type 0).
MYOGROWTH_MGIS(unsigned short, nParameters) = n_parameters;
MYOGROWTH_MGIS(Names<n_parameters>, Parameters) = {MYOGROWTH_PROPS_OF_STEP(MYOGROWTH_NAME)};
MYOGROWTH_MGIS(Types<n_parameters>, ParametersTypes) = {};
MYOGROWTH_PROPS_OF_STEP(MYOGROWTH_MGIS_DEFAULT)
}
