// One muscle through every host's routine: the UMAT, the VUMAT, CalculiX's two, the C API and MGIS's
// behaviours give the same stress, tangent, energy and state, each in its own measure, with each elastic law,
// active and growing.
#include <gtest/gtest.h>
#include <myogrowth.h>

#include <Eigen/Eigenvalues>
#include <myogrowth/material.hpp>

#include "../support/ccx_host.hpp"
#include "../support/larger.hpp"
#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using namespace myogrowth;
using Eigen::Matrix3d;
using Numbers = std::vector<double>;

namespace {
struct MgisState {
  const double *gradients, *forces, *density, *properties;
  double *internal, *stored, *dissipated;
  const double* external;
};
struct MgisData {
  char* message;
  double dt, *K, *rdt, *speed;
  MgisState s0, s1;
};
}  // namespace
extern "C" {
using Behaviour = int(MgisData*);
Behaviour FibreGrowth_Tridimensional, FibreGrowthRoehrle_Tridimensional, FibreGrowthBlemker_Tridimensional,
    FibreGrowthEhret_Tridimensional, FibreGrowthEhret_PlaneStress;
using SetParameter = int(const char*, double);
SetParameter FibreGrowth_setParameter, FibreGrowthRoehrle_setParameter, FibreGrowthBlemker_setParameter,
    FibreGrowthEhret_setParameter;
extern const unsigned short FibreGrowthBlemker_nMaterialProperties,
    FibreGrowthBlemker_nExternalStateVariables, FibreGrowth_nExternalStateVariables,
    FibreGrowthBlemker_TemperatureRemovedFromExternalStateVariables;
extern const char *const FibreGrowthBlemker_MaterialProperties[18],
    *const FibreGrowthBlemker_ExternalStateVariables[1], *const FibreGrowthBlemker_mfront_ept;
}

namespace {

/// A call of a behaviour, with the arrays of both ends of its step.
struct MgisCall {
  Numbers F0, F1, stress, start, internal, properties, K = Numbers(81);
  double dt = 0.1, rdt = 1, stored = 0;
  char message[512] = "";

  int run(Behaviour& behaviour, const double* external) {
    MgisData d{
        message,
        dt,
        K.data(),
        &rdt,
        nullptr,
        {F0.data(), nullptr, nullptr, nullptr, start.data(), nullptr, nullptr, nullptr},
        {F1.data(), stress.data(), nullptr, properties.data(), internal.data(), &stored, nullptr, external}};
    return behaviour(&d);
  }
};

struct Muscle {
  int law;
  bool grown, second_order, removes;
  Numbers growth, n0, parameters;
  double activation, G, lambda, dt;
};

Muscle random_muscle(samples::Random& r, int law) {
  const Numbers published[4] = {{16, 4},
                                {10, 10, 1000, 300, 300, 1.4, 0.05, 6.6},
                                {0.5, 0.5, 1000, 300, 1.4, 0.05, 6.6, 1.4, 0, 2700, 46.4},
                                {19.69, 1.19, 0.1599, 100, 0.7388, 73.52, 0.682, 1.192}};
  Muscle m{law,
           r.chance(0.5),
           r.chance(0.3),
           r.chance(0.3),
           {r.uniform(0.3, 3), r.uniform(1, 3), r.uniform(1.05, 1.6), r.uniform(0.95, 1.05)},
           {r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(0.1, 1)},
           published[law],
           r.chance(0.2) ? 0 : r.uniform(),
           r.uniform(0.95, 1.04),
           r.uniform(0.95, 1.1),
           r.uniform(0.01, 0.5)};
  for (double& x : m.parameters)
    x *= x > 1 ? r.uniform(1, 1.1) : 1;  // (what must be 0, 1 or below 1 stays so)
  if (law == 2) m.parameters[8] = r.chance(0.3);
  return m;
}

// PROPS in the UMAT's order.
Numbers props_of(const Muscle& m, double activation) {
  Numbers p(20, 0.0);
  for (std::size_t i = 0; i < 2 && m.law == 0; ++i) p[i] = m.parameters[i];
  for (std::size_t i = 0; i < 4; ++i) p[2 + i] = m.growth[i];
  for (std::size_t i = 0; i < 3; ++i) p[6 + i] = m.n0[i];
  p[10] = m.grown, p[11] = m.second_order;
  if (m.removes) p[13] = 0.8, p[14] = 1.5, p[15] = 0.6, p[16] = 0.95;
  p[18] = m.law;
  if (m.law == 0) return p;
  p[19] = activation;
  p.insert(p.end(), m.parameters.begin(), m.parameters.end());
  return p;
}

struct Result {
  Matrix3d sigma;
  double psi;
  Numbers state;
};

class Hosts : public testing::Test {
 protected:
  samples::Random r{91};
  double worst = 0;

  void compare(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double scale = 0) {
    const double size = (a - b).norm() / std::max(b.norm(), scale);
    worst = larger(worst, std::isnan(size) ? 1 : size);
  }
};

TEST_F(Hosts, AgreeWithOneAnother) {
  Behaviour* const behaviour[] = {FibreGrowth_Tridimensional, FibreGrowthRoehrle_Tridimensional,
                                  FibreGrowthBlemker_Tridimensional, FibreGrowthEhret_Tridimensional};
  SetParameter* const set[] = {FibreGrowth_setParameter, FibreGrowthRoehrle_setParameter,
                               FibreGrowthBlemker_setParameter, FibreGrowthEhret_setParameter};
  int grew = 0, shrank = 0;
  for (int i = 0; i < 400; ++i) {
    const Muscle m = random_muscle(r, i % 4);
    const Matrix3d U = samples::deformation(r, 0.1), R = samples::rotation(r), F = R * U;
    const Matrix3d stretch = Eigen::SelfAdjointEigenSolver<Matrix3d>(F.transpose() * F).operatorSqrt();
    const Matrix3d turn = F * stretch.inverse();
    const Numbers props = props_of(m, m.activation), by_field = props_of(m, -1);
    const int n_props = static_cast<int>(props.size());
    const Numbers state = {m.G, 0, m.lambda, 0, 0, 0, 0, 0};

    host::Call umat;  // Cauchy stress, and DDSDDE
    umat.props = by_field;
    umat.predef = 0.25 * m.activation, umat.dpred = 0.75 * m.activation;
    umat.statev = state;
    umat.F = F;
    umat.dtime = m.dt;
    umat.run();
    ASSERT_EQ(umat.pnewdt, 1);
    const Matrix3d sigma = from_six(Vec6<double>(umat.stress));
    const double J = F.determinant();
    grew += umat.statev[0] > m.G, shrank += umat.statev[0] < m.G;

    Numbers out(8);  // the C API: each measure
    Vec6<double> cauchy, S;
    Mat6<double> ddsdde, dS_dE;
    Matrix3d P;
    Mat9<double> dP_dF;
    double psi = 0;
    const auto c_api = [&](int measure, double* stress, double* tangent) {
      ASSERT_EQ(myogrowth_update(props.data(), n_props, F.data(), state.data(), out.data(), 8, m.dt, measure,
                                 stress, tangent, &psi, nullptr, 0),
                MYOGROWTH_OK);
    };
    c_api(MYOGROWTH_CAUCHY, cauchy.data(), ddsdde.data());
    c_api(MYOGROWTH_SECOND_PIOLA, S.data(), dS_dE.data());
    c_api(MYOGROWTH_FIRST_PIOLA, P.data(), dP_dF.data());
    compare(cauchy, umat.stress);
    compare(ddsdde, umat.ddsdde);
    EXPECT_NEAR(psi, umat.sse, 1e-12 * std::abs(psi));
    EXPECT_EQ(out, umat.statev);
    compare(P, J * sigma * F.transpose().inverse());
    compare(F * from_six(S) * F.transpose() / J, sigma);

    host::Call ccx;  // CalculiX: S and dS/dE, by the interface for UMATs and by its own
    ccx.statev = state;
    const int n_state = 8, one = 1, icmd = 1;
    double pnewdt = -1;
    CCX(ccx.stress.data(), ccx.statev.data(), ccx.ddsdde.data(), nullptr, nullptr, nullptr, nullptr, nullptr,
        nullptr, nullptr, nullptr, nullptr, nullptr, &m.dt, nullptr, nullptr, nullptr, nullptr, nullptr,
        nullptr, nullptr, nullptr, &n_state, props.data(), &n_props, nullptr, nullptr, &pnewdt, nullptr,
        nullptr, F.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, 0);
    compare(ccx.stress, S);
    compare(ccx.ddsdde, dS_dE);
    EXPECT_EQ(ccx.statev, umat.statev);
    double stiff[21], native[6];
    const auto run_native = [&](const Numbers& constants) {
      const int code = -100 - static_cast<int>(constants.size());
      NATIVE(nullptr, &one, &one, &code, constants.data(), nullptr, nullptr, nullptr, nullptr, nullptr,
             F.data(), nullptr, nullptr, nullptr, &m.dt, nullptr, nullptr, &icmd, nullptr, &one, &n_state,
             state.data(), out.data(), native, stiff, nullptr, nullptr, nullptr, &pnewdt, nullptr, 0);
    };
    run_native(props);
    compare(Eigen::Map<const Vec6<double>>(native), S);
    EXPECT_NEAR(stiff[1], (dS_dE(0, 1) + dS_dE(1, 0)) / 2, 1e-12 * dS_dE.norm());
    if (m.law > 0) {  // the short order, which its 21 constants have room for
      Numbers constants = {m.activation, -1. * m.law};
      constants.insert(constants.end(), props.begin() + 2, props.begin() + 9);
      constants.insert(constants.end(), m.parameters.begin(), m.parameters.end());
      constants.insert(constants.end(), props.begin() + 10, props.begin() + 17);
      if (!m.removes)
        constants.resize(
            static_cast<std::size_t>(m.law == 2 && !m.second_order ? 21 : 9 + m.parameters.size() + 2));
      run_native(constants);
      compare(Eigen::Map<const Vec6<double>>(native), S);
      EXPECT_EQ(out, umat.statev);
    }
    EXPECT_EQ(pnewdt, -1);

    const int size = 2, n = 3, lanneal = 0,
              n_fields = 2;  // the VUMAT: R^T sigma R; the second point is its own
    Numbers of_state, stretches(12), stress(12), after(16), energy(2), none(2), density(2, 1.0), old(12),
        identity = {1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0}, field = {m.activation, 0.5, 7, 7};
    for (double x : state) of_state.push_back(x), of_state.push_back(x);
    const int six[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
    for (std::size_t k = 0; k < 6; ++k) {
      stretches[2 * k] = stretch(six[k][0], six[k][1]);
      stretches[2 * k + 1] = identity[2 * k];
    }
    const double time = 1;
    vumat_(&size, &n, &n, &n_state, &n_fields, &n_props, &lanneal, &time, &time, &m.dt, nullptr, nullptr,
           nullptr, by_field.data(), density.data(), old.data(), nullptr, nullptr, identity.data(), nullptr,
           nullptr, old.data(), of_state.data(), none.data(), none.data(), nullptr, stretches.data(), nullptr,
           field.data(), stress.data(), after.data(), energy.data(), none.data());
    Matrix3d turned;
    for (std::size_t k = 0; k < 6; ++k)
      turned(six[k][0], six[k][1]) = turned(six[k][1], six[k][0]) = stress[2 * k];
    compare(turn * turned * turn.transpose(), sigma, 0.01 * ddsdde.norm());  // U has been rounded
    EXPECT_NEAR(after[0], umat.statev[0], 1e-13);
    EXPECT_NEAR(energy[0] * (1 + J) / 2, psi, 1e-11 * std::abs(psi));

    // MGIS: P and dP/dF.
    Numbers properties = props;
    properties.assign(props.begin() + (m.law > 0 ? 2 : 0), props.begin() + 9);
    if (m.law > 0) properties.insert(properties.end(), m.parameters.begin(), m.parameters.end());
    const char* const names[] = {"energy",    "integration", "tolerance",      "tau_rev",
                                 "gamma_rev", "G_min",       "lambda_crit_rev"};
    for (std::size_t k = 0; k < 7; ++k) ASSERT_EQ(set[m.law](names[k], props[10 + k]), 1);
    const int row[9] = {0, 1, 2, 0, 1, 0, 2, 1, 2}, column[9] = {0, 1, 2, 1, 0, 2, 0, 2, 1};
    MgisCall mgis;
    mgis.F0 = mgis.F1 = mgis.stress = Numbers(9), mgis.internal = Numbers(5);
    mgis.start.assign(state.begin(), state.begin() + 5);
    mgis.properties = properties;
    mgis.dt = m.dt;
    for (std::size_t k = 0; k < 9; ++k) mgis.F0[k] = k < 3, mgis.F1[k] = F(row[k], column[k]);
    mgis.K[0] = 4, mgis.K[1] = 2, mgis.K[2] = 2;
    const Numbers external = {293.15, m.activation};
    ASSERT_EQ(mgis.run(*behaviour[m.law], external.data()), 1) << mgis.message;
    Matrix3d P_mgis;
    Mat9<double> A;
    for (int a = 0; a < 9; ++a) {
      P_mgis(row[a], column[a]) = mgis.stress[static_cast<std::size_t>(a)];
      for (int b = 0; b < 9; ++b)
        A(row[a] + 3 * column[a], row[b] + 3 * column[b]) = mgis.K[static_cast<std::size_t>(b + 9 * a)];
    }
    compare(P_mgis, P);
    compare(A, dP_dF);
    EXPECT_NEAR(mgis.stored, psi, 1e-12 * std::abs(psi));
    EXPECT_EQ(mgis.internal[0], umat.statev[0]);
  }
  for (SetParameter* s : set) {
    for (const char* name : {"energy", "integration", "tau_rev"}) s(name, 0);
  }
  EXPECT_GT(grew, 150);
  EXPECT_GT(shrank, 10);
  std::printf("hosts agree with one another: %.1e at worst\n", worst);
  EXPECT_LE(worst, 1e-12);
}

// A fibre stretch whose square is below all numbers: every routine finds it, or refuses the point.
TEST_F(Hosts, AgreeOnATinyFibreStretch) {
  for (int law = 0; law < 4; ++law) {
    const Muscle m = random_muscle(r, law);
    Numbers props = props_of(m, m.activation);
    props[6] = 1, props[7] = props[8] = 0;
    const Numbers state = {1, 0, 1, 0, 0, 0, 0, 0};
    const int n_props = static_cast<int>(props.size());
    host::Call umat;
    umat.props = props;
    umat.statev = state;
    umat.F = Eigen::Vector3d(1e-160, 2, 1e100).asDiagonal();
    umat.dtime = m.dt;
    umat.run();
    const bool has_result = umat.pnewdt == 1;
    Numbers one(8), many(8), stress(6), tangent(36);
    const int status =
        myogrowth_update(props.data(), n_props, umat.F.data(), state.data(), one.data(), 8, m.dt,
                         MYOGROWTH_CAUCHY, stress.data(), tangent.data(), nullptr, nullptr, 0);
    const int failed =
        myogrowth_update_n(1, props.data(), n_props, umat.F.data(), state.data(), many.data(), 8, m.dt,
                           MYOGROWTH_CAUCHY, stress.data(), tangent.data(), nullptr, nullptr, nullptr, 0);
    EXPECT_EQ(status, has_result ? MYOGROWTH_OK : MYOGROWTH_NOT_FINITE) << law;
    EXPECT_EQ(failed, has_result ? 0 : 1) << law;
    EXPECT_TRUE(has_result || law > 0);
    if (!has_result) continue;
    EXPECT_NEAR(umat.statev[2] / 1e-160, 1, 1e-15);
    EXPECT_EQ(one, umat.statev);
    EXPECT_EQ(many, umat.statev);
  }
}

// What is wrong goes by the same words everywhere; MGIS has names only.
TEST_F(Hosts, NameWhatIsWrong) {
  Muscle m = random_muscle(r, 1);
  m.parameters[2] = -1;
  const Numbers props = props_of(m, 0.5);
  char message[512] = "";
  EXPECT_EQ(myogrowth_check(props.data(), static_cast<int>(props.size()), message, 512),
            MYOGROWTH_BAD_PARAMETER);
  EXPECT_STREQ(message, "PROPS(23) = -1: kappa, resistance to volume change, must be finite and > 0.");
  const Numbers by_field = props_of(random_muscle(r, 1), -1);
  EXPECT_EQ(myogrowth_check(by_field.data(), 28, message, 512), MYOGROWTH_BAD_PARAMETER);
  EXPECT_STREQ(message,
               "PROPS(20) = -1: this host has no field variables; activation must be >= 0 and <= 1.");

  const int one = 1, n = 3, n_state = 1, n_props = 28, lanneal = 0;
  Numbers unit = {1, 1, 1, 0, 0, 0}, old(6), stress(6), state(1), energy(1), none(1);
  const auto vumat = [&](const Numbers& p, int n_fields, double activation) {
    const double time = 1, dt = 0.1, density = 1;
    testing::internal::CaptureStderr();
    vumat_(&one, &n, &n, &n_state, &n_fields, &n_props, &lanneal, &time, &time, &dt, nullptr, nullptr,
           nullptr, p.data(), &density, old.data(), nullptr, nullptr, unit.data(), nullptr, nullptr,
           old.data(), state.data(), none.data(), none.data(), nullptr, unit.data(), nullptr, &activation,
           stress.data(), state.data(), energy.data(), none.data());
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(text.empty(), !std::isnan(stress[0]));
    return text;
  };
  EXPECT_EQ(vumat(by_field, 1, 0.5), "");
  EXPECT_NE(vumat(by_field, 1, 1.5).find("PROPS(20) = -1, field variable 1 = 1.5: activation"),
            std::string::npos);
  EXPECT_NE(vumat(by_field, 0, 0.5).find("PROPS(20) = -1: this host has no field variables"),
            std::string::npos);
  EXPECT_NE(vumat(props, 0, 0).find("PROPS(23) = -1: kappa"), std::string::npos);

  const auto mgis = [&](Numbers properties, const double* external) {
    MgisCall call;
    call.F0 = call.F1 = {1, 1, 1, 0, 0, 0, 0, 0, 0}, call.stress = Numbers(9);
    call.start = call.internal = Numbers(5);
    call.properties = properties;
    const int made = call.run(FibreGrowthEhret_Tridimensional, external);
    EXPECT_EQ(std::isnan(call.stress[0]), made < 0);
    return made < 0 ? std::string(call.message) : "";
  };
  const Numbers fine = {0.5, 2, 1.1, 1.01, 1, 0, 0, 19.69, 1.19, 0.1599, 100, 0.7388, 73.52, 0.682, 1.192};
  const double external[] = {293.15, 0.5}, too_active[] = {0, 1.01};
  EXPECT_EQ(mgis(fine, external), "");
  EXPECT_EQ(mgis(fine, too_active), "FibreGrowthEhret: Activation = 1.01: must be >= 0 and <= 1.");
  EXPECT_EQ(mgis(fine, nullptr),
            "FibreGrowthEhret: there are no external state variables: Temperature and Activation.");
  Numbers wrong = fine;
  wrong[14] = 0.5;
  EXPECT_EQ(mgis(wrong, external),
            "FibreGrowthEhret: lambda_opt = 0.5: optimum elastic stretch, must be finite and > lambda_min.");
  wrong = fine;
  wrong[2] = 0.5;
  EXPECT_EQ(mgis(wrong, external).substr(0, 29), "FibreGrowthEhret: G_max = 0.5");
}

TEST(Mgis, BehavioursOfTheElasticLawsDescribeThemselves) {
  EXPECT_STREQ(FibreGrowthBlemker_mfront_ept, "FibreGrowthBlemker");
  EXPECT_EQ(FibreGrowthBlemker_nMaterialProperties, 18);
  const char* const names[] = {"tau",  "gamma", "G_max",       "lambda_crit", "n0_1",      "n0_2",
                               "n0_3", "G1",    "G2",          "kappa",       "sigma_max", "lambda_opt",
                               "P1",   "P2",    "lambda_star", "tendon",      "L1",        "L2"};
  for (int i = 0; i < 18; ++i) EXPECT_STREQ(FibreGrowthBlemker_MaterialProperties[i], names[i]);
  EXPECT_EQ(FibreGrowth_nExternalStateVariables, 0);
  EXPECT_EQ(FibreGrowthBlemker_nExternalStateVariables, 1);
  EXPECT_STREQ(FibreGrowthBlemker_ExternalStateVariables[0], "Activation");
  EXPECT_EQ(FibreGrowthBlemker_TemperatureRemovedFromExternalStateVariables, 1);  // MGIS puts it first
}

// In plane stress the thickness is found with a law, too.
TEST(Mgis, PlaneStressOfLaw3) {
  MgisCall mgis;
  mgis.properties = {0.5, 2, 1.1, 1.01, 1, 0.3, 0, 19.69, 1.19, 0.1599, 100, 0.7388, 73.52, 0.682, 1.192};
  mgis.F0 = {1, 1, 1, 0, 0}, mgis.F1 = {1.1, 1.02, 1, 0.05, -0.02};
  mgis.stress = Numbers(4), mgis.start = mgis.internal = Numbers(6);
  const double external[] = {0, 0.1};
  ASSERT_EQ(mgis.run(FibreGrowthEhret_PlaneStress, external), 1) << mgis.message;
  host::Call umat;
  umat.ntens = 3;
  umat.statev.assign(9, 0.0);
  umat.props = {0, 0, 0.5, 2, 1.1, 1.01, 1, 0.3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0.1};
  umat.F << 1.1, 0.05, 0, -0.02, 1.02, 0, 0, 0, 1;
  umat.run();
  EXPECT_NEAR(mgis.internal[5], umat.statev[8], 1e-12);
  const double size = umat.stress.head<3>().norm();
  EXPECT_NEAR(mgis.stress[0], umat.stress[0], 1e-11 * size);
  EXPECT_NEAR(mgis.stress[3] / std::sqrt(2.), umat.stress[2], 1e-11 * size);
}

}  // namespace
