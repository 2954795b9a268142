// A host that loads libmyogrowth_mgis.so as MGIS does: dlopen, metadata by name (that of the hypothesis
// first, then the general one), one call a point; and what comes back against the C++ face and against
// differences of the calls themselves. (What MGIS does: see the head of abi/mgis.cpp.)
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "../support/larger.hpp"
#include "../support/samples.hpp"

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Numbers = std::vector<double>;
using Eigen::Matrix3d;

// API version 1. (The state at the end is written to; one structure for both ends serves here.)
struct State {
  const double *gradients, *thermodynamic_forces, *mass_density, *material_properties, *internal,
      *stored_energy, *dissipated_energy, *external;
};
struct View {
  char* error_message;
  double dt;
  double* K;
  double* rdt;
  double* speed_of_sound;
  State s0, s1;
};
using Integrate = int (*)(View*);

struct Variable {
  std::string name;
  int type;  // 0 scalar, 1 symmetric tensor, 3 tensor
};

// What MGIS knows of a behaviour once it has loaded it.
struct Behaviour {
  std::string library, name, hypothesis;
  void* handle;
  Integrate integrate;
  std::vector<Variable> gradients, forces, variables;
  std::vector<std::string> properties, parameters, blocks;

  void* find(const std::string& suffix) const { return dlsym(handle, (name + "_" + suffix).c_str()); }
  void* find_of_hypothesis(const std::string& suffix) const {
    void* own = find(hypothesis + "_" + suffix);
    return own ? own : find(suffix);
  }
  template <class T>
  const T* get(const std::string& suffix) const {
    void* p = find_of_hypothesis(suffix);
    if (!p) throw std::runtime_error("no symbol " + suffix);
    return static_cast<const T*>(p);
  }
  std::vector<std::string> names(const std::string& what) const {
    const unsigned short n = *get<unsigned short>("n" + what);
    if (n == 0) return {};
    const char* const* p = get<const char*>(what);
    return {p, p + n};
  }
  std::vector<Variable> typed(const std::string& what) const {
    std::vector<Variable> result;
    const int* types = get<int>(what + "Types");
    for (const std::string& s : names(what)) result.push_back({s, *types++});
    return result;
  }
  bool is_3d() const { return hypothesis == "Tridimensional"; }
  int size(int type) const { return type == 0 ? 1 : type == 1 ? (is_3d() ? 6 : 4) : is_3d() ? 9 : 5; }
};

Behaviour load(const std::string& hypothesis) {
  Behaviour b;
  b.library = MYOGROWTH_MGIS_LIBRARY;
  b.name = "FibreGrowth";
  b.hypothesis = hypothesis;
  b.handle = dlopen(b.library.c_str(), RTLD_NOW);
  if (!b.handle) throw std::runtime_error(dlerror());
  b.integrate = reinterpret_cast<Integrate>(b.find(hypothesis));
  if (!b.integrate) throw std::runtime_error("no function for " + hypothesis);
  b.gradients = b.typed("Gradients");
  b.forces = b.typed("ThermodynamicForces");
  b.variables = b.typed("InternalStateVariables");
  b.properties = b.names("MaterialProperties");
  b.parameters = b.names("Parameters");
  b.blocks = b.names("TangentOperatorBlocks");
  return b;
}

const std::vector<std::string> hypotheses = {"Tridimensional", "PlaneStrain", "Axisymmetrical",
                                             "PlaneStress"};
enum Measure { cauchy = 0, second_piola = 1, first_piola = 2 };
enum Operator { dsigma_dF = 0, dS_dE = 1, dP_dF = 2, dtau_ddF = 3 };
enum Kind {
  prediction_tangent = -3,
  prediction_elastic = -1,
  none = 0,
  elastic = 1,
  secant = 2,
  consistent = 4
};
constexpr double untouched = -777;

// The order of MFront, written out: 11 22 33 12 21 13 31 23 32, and 11 22 33 12 13 23.
constexpr int tensor_row[9] = {0, 1, 2, 0, 1, 0, 2, 1, 2}, tensor_column[9] = {0, 1, 2, 1, 0, 2, 0, 2, 1};
constexpr int symmetric_row[6] = {0, 1, 2, 0, 0, 1}, symmetric_column[6] = {0, 1, 2, 1, 2, 2};

Numbers tensor(const Matrix3d& A, const Behaviour& b) {
  Numbers x;
  for (int i = 0; i < b.size(3); ++i) x.push_back(A(tensor_row[i], tensor_column[i]));
  return x;
}
Numbers symmetric(const Matrix3d& A, const Behaviour& b) {
  Numbers x;
  for (int i = 0; i < b.size(1); ++i) {
    x.push_back(A(symmetric_row[i], symmetric_column[i]) * (i < 3 ? 1 : std::sqrt(2.0)));
  }
  return x;
}

// One point of a host.
struct Point {
  Behaviour b;
  Numbers properties = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0};
  Matrix3d F0 = Matrix3d::Identity(), F1 = Matrix3d::Identity();
  Numbers variables0, variables1;
  double dt = 0.1, rdt = 1, kind = consistent, energy = untouched;
  int measure = first_piola, tangent = dP_dF;
  Numbers stress = Numbers(9, untouched), K = Numbers(81, untouched);
  std::string message;

  explicit Point(const std::string& hypothesis) : b(load(hypothesis)) {
    variables0.assign(b.variables.size(), 0);
    variables1.assign(b.variables.size(), untouched);
  }
  int integrate(bool with_message = true) {
    const Numbers F0_ = tensor(F0, b), F1_ = tensor(F1, b);
    char text[520];
    std::memset(text, '#', sizeof text);
    text[0] = '\0';
    Numbers s0 = stress;
    std::fill(K.begin(), K.end(), untouched);
    K[0] = kind, K[1] = measure, K[2] = tangent;
    View v{with_message ? text : nullptr,
           dt,
           K.data(),
           &rdt,
           nullptr,
           {F0_.data(), s0.data(), nullptr, nullptr, variables0.data(), nullptr, nullptr, nullptr},
           {F1_.data(), stress.data(), nullptr, properties.data(), variables1.data(), &energy, nullptr,
            nullptr}};
    const int result = b.integrate(&v);
    EXPECT_EQ(std::string(text + 512, 8), "########");
    message = text;
    return result;
  }
  Numbers used_stress() const {
    return {stress.begin(), stress.begin() + b.size(measure == first_piola ? 3 : 1)};
  }
  Matrix used_operator() const {
    return Eigen::Map<const Matrix>(K.data(), b.size(tangent == dP_dF ? 3 : 1),
                                    b.size(tangent == dS_dE ? 1 : 3));
  }
  void end_step() {  // as mgis::behaviour::update
    F0 = F1;
    variables0 = variables1;
  }
};

// A point of the hypothesis that grows much in the step, rotated and not too far from undeformed for
// differences.
Point growing(const std::string& hypothesis, samples::Random& r, samples::Point* same = nullptr) {
  Point p(hypothesis);
  samples::Point s = samples::point(r, samples::Kind::growing);
  s.F = samples::rotation(r) * samples::deformation(r, 0.2);
  if (!p.b.is_3d()) {
    const double angle = r.uniform(-3, 3);
    s.F = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * samples::deformation(r, 0.2);
    for (int i = 0; i < 2; ++i) s.F(i, 2) = s.F(2, i) = 0;
    if (hypothesis == "PlaneStress") s.state.n0[2] = 0;
  }
  const double lambda = (s.F * s.state.n0.normalized()).norm();
  s.state.G = 1.1;
  s.muscle.growth = {1, 2, 1.6, 0.7 * lambda / s.state.G};
  s.dt = r.uniform(0.2, 2);
  const auto& g = s.muscle.growth;
  p.properties = {s.muscle.c1,   s.muscle.c2,   g.tau,         g.gamma,      g.G_max,
                  g.lambda_crit, s.state.n0[0], s.state.n0[1], s.state.n0[2]};
  p.variables0[0] = s.state.G;
  p.F1 = s.F;
  p.F0 = s.F + 0.05 * Matrix3d::Identity();
  p.F0(0, 1) -= 0.1;
  p.dt = s.dt;
  if (same) *same = s;
  return p;
}

double difference(const Numbers& a, const Numbers& b) {
  double most = 0, size = 0;
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = larger(most, std::abs(a[i] - b[i]));
    size = std::max(size, std::abs(b[i]));
  }
  return std::isnan(most) ? most : most / size;
}
double difference(const Matrix& a, const Matrix& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

TEST(Mgis, MetadataIsWhatMgisAsksFor) {
  const std::vector<std::string> declared = load("Tridimensional").names("ModellingHypotheses");
  EXPECT_EQ(std::set<std::string>(declared.begin(), declared.end()),
            std::set<std::string>(hypotheses.begin(), hypotheses.end()));
  for (const std::string& h : hypotheses) {
    const Behaviour b = load(h);
    EXPECT_STREQ(*b.get<const char*>("mfront_ept"), "FibreGrowth");
    EXPECT_STRNE(*b.get<const char*>("tfel_version"), "");
    EXPECT_EQ(*b.get<unsigned short>("mfront_mkt"), 1);
    EXPECT_EQ(*b.get<unsigned short>("api_version"), 1);
    EXPECT_EQ(*b.get<unsigned short>("BehaviourType"), 2);
    EXPECT_EQ(*b.get<unsigned short>("BehaviourKinematic"), 3);
    EXPECT_EQ(*b.get<unsigned short>("SymmetryType"), 0);
    EXPECT_EQ(*b.get<unsigned short>("requiresStiffnessTensor"), 0);
    EXPECT_EQ(*b.get<unsigned short>("requiresThermalExpansionCoefficientTensor"), 0);
    EXPECT_EQ(*b.get<unsigned short>("ComputesInternalEnergy"), 1);
    EXPECT_EQ(*b.get<unsigned short>("ComputesDissipatedEnergy"), 0);
    ASSERT_EQ(b.gradients.size(), 1u);  // MGIS refuses other names and types for this kind of behaviour
    EXPECT_EQ(b.gradients[0].name, "DeformationGradient");
    EXPECT_EQ(b.gradients[0].type, 3);
    ASSERT_EQ(b.forces.size(), 1u);
    EXPECT_EQ(b.forces[0].name, "Stress");
    EXPECT_EQ(b.forces[0].type, 1);
    EXPECT_EQ(b.blocks, (std::vector<std::string>{"Stress", "DeformationGradient"}));
    EXPECT_EQ(b.properties, (std::vector<std::string>{"c1", "c2", "tau", "gamma", "G_max", "lambda_crit",
                                                      "n0_1", "n0_2", "n0_3"}));
    std::vector<std::string> names;
    for (const Variable& v : b.variables) {
      names.push_back(v.name);
      EXPECT_EQ(v.type, 0);
    }
    std::vector<std::string> expected = {"G", "lambda_e", "lambda", "J", "Je"};
    if (h == "PlaneStress") expected.push_back("F33");
    EXPECT_EQ(names, expected);
    EXPECT_TRUE(b.names("ExternalStateVariables").empty());
    EXPECT_TRUE(b.names("InitializeFunctions").empty());
    EXPECT_TRUE(b.names("PostProcessings").empty());
    const int* types = b.get<int>("ParametersTypes");
    for (const std::string& p : b.parameters) {
      EXPECT_EQ(*types++, 0);
      EXPECT_EQ(*b.get<double>(p + "_ParameterDefaultValue"), 0) << p;
    }
    EXPECT_EQ(b.parameters, (std::vector<std::string>{"energy", "integration", "tolerance", "tau_rev",
                                                      "gamma_rev", "G_min", "lambda_crit_rev"}));
    EXPECT_EQ(*b.get<long double>("G_max_LowerPhysicalBound"), 1);
    EXPECT_EQ(*b.get<long double>("c2_LowerPhysicalBound"), 0);
    EXPECT_EQ(b.find_of_hypothesis("c1_LowerPhysicalBound"), nullptr);
    EXPECT_EQ(b.find_of_hypothesis("c2_UpperPhysicalBound"), nullptr);
  }
  EXPECT_THROW(load("GeneralisedPlaneStrain"), std::runtime_error);
}

TEST(Mgis, ThreeDimensionsAreTheCppFace) {
  samples::Random r(1);
  double worst = 0;
  for (int n = 0; n < 500; ++n) {
    samples::Point s;
    Point p = growing("Tridimensional", r, &s);
    const auto step = myogrowth::update(s.muscle, s.F, s.state, s.dt);
    p.kind = n % 2 == 0 ? none : consistent;
    for (const int measure : {cauchy, second_piola, first_piola}) {
      p.measure = measure;
      ASSERT_EQ(p.integrate(), 1) << p.message;
      worst = std::max(
          worst, difference(p.used_stress(), measure == cauchy         ? symmetric(step.cauchy(), p.b)
                                             : measure == second_piola ? symmetric(step.second_piola(), p.b)
                                                                       : tensor(step.first_piola(), p.b)));
      EXPECT_EQ(p.variables1[0], step.state.G);
      EXPECT_EQ(p.variables1[1], step.point.lambda_e);
      EXPECT_EQ(p.variables1[2], step.point.lambda);
      EXPECT_EQ(p.variables1[3], step.point.J);
      EXPECT_EQ(p.variables1[4], step.point.Je);
      EXPECT_EQ(p.energy, step.point.psi);
      EXPECT_EQ(p.rdt, 1);
      EXPECT_EQ(p.K[3] == untouched, static_cast<int>(p.kind) == none);
    }
  }
  EXPECT_LT(worst, 1e-15);
}

TEST(Mgis, TwoDimensionsAreTheThirdHeld) {
  samples::Random r(2);
  for (const char* h : {"PlaneStrain", "Axisymmetrical"}) {
    for (int n = 0; n < 100; ++n) {
      Point plane = growing(h, r), solid("Tridimensional");
      solid.properties = plane.properties;
      solid.F0 = plane.F0, solid.F1 = plane.F1, solid.dt = plane.dt, solid.variables0 = plane.variables0;
      for (int tangent = dsigma_dF; tangent <= dtau_ddF; ++tangent) {
        plane.tangent = solid.tangent = tangent;
        plane.measure = solid.measure = tangent % 3;
        ASSERT_EQ(plane.integrate(), 1) << plane.message;
        ASSERT_EQ(solid.integrate(), 1) << solid.message;
        for (std::size_t i = 0; i < plane.used_stress().size(); ++i)
          EXPECT_EQ(plane.stress[i], solid.stress[i]);
        const Matrix in = plane.used_operator();
        EXPECT_EQ(in, solid.used_operator().topLeftCorner(in.rows(), in.cols()));
        EXPECT_EQ(plane.variables1, solid.variables1);
      }
    }
  }
}

TEST(Mgis, PlaneStressHasNoStressAcross) {
  samples::Random r(3);
  for (int n = 0; n < 100; ++n) {
    Point plane = growing("PlaneStress", r), solid("Tridimensional");
    plane.measure = cauchy;
    ASSERT_EQ(plane.integrate(), 1) << plane.message;
    EXPECT_LT(std::abs(plane.stress[2]),
              1e-12 * (std::abs(plane.stress[0]) + std::abs(plane.stress[1]) + 10));
    solid.properties = plane.properties;
    solid.F1 = plane.F1;
    solid.F1(2, 2) = plane.variables1[5];  // the thickness stretch that it found
    solid.dt = plane.dt, solid.measure = cauchy;
    solid.variables0.assign(plane.variables0.begin(), plane.variables0.begin() + 5);
    ASSERT_EQ(solid.integrate(), 1) << solid.message;
    for (int i = 0; i < 4; ++i)
      EXPECT_EQ(plane.stress[static_cast<std::size_t>(i)], solid.stress[static_cast<std::size_t>(i)]);
    EXPECT_EQ(Numbers(plane.variables1.begin(), plane.variables1.begin() + 5), solid.variables1);
    const Numbers before = plane.used_stress();
    plane.F1(2, 2) = 17;  // is not read
    plane.integrate();
    EXPECT_EQ(plane.used_stress(), before);
  }
}

// d(stress)/dF by central differences of the calls.
Matrix by_differences(Point p, int measure) {
  p.measure = measure;
  p.kind = none;
  const int n = p.b.size(3), m = p.b.size(measure == first_piola ? 3 : 1);
  const double h = 1e-6;
  Matrix D(m, n);
  const Matrix3d F = p.F1;
  for (int j = 0; j < n; ++j) {
    Numbers side[2];
    for (int s = 0; s < 2; ++s) {
      p.F1 = F;
      p.F1(tensor_row[j], tensor_column[j]) += s == 0 ? -h : h;
      EXPECT_EQ(p.integrate(), 1) << p.message;
      side[s] = p.used_stress();
    }
    for (int i = 0; i < m; ++i) {
      D(i, j) = (side[1][static_cast<std::size_t>(i)] - side[0][static_cast<std::size_t>(i)]) / (2 * h);
    }
  }
  return D;
}

// The operator asked for and dF -> stress, by the calls alone; E and tau by their definitions.
TEST(Mgis, EveryOperatorIsTheDerivativeOfTheStep) {
  samples::Random r(4);
  double worst[4] = {};
  for (const std::string& h : hypotheses) {
    for (int n = 0; n < 40; ++n) {
      Point p = growing(h, r);
      const bool plane_stress = h == "PlaneStress";
      for (int tangent = dsigma_dF; tangent <= dtau_ddF; ++tangent) {
        p.tangent = tangent;
        p.kind = n % 2 == 0 ? consistent : 3;
        p.measure = first_piola;  // the operator does not depend on what stress is asked for
        ASSERT_EQ(p.integrate(), 1) << p.message;
        const Matrix given = p.used_operator();
        const int n_F = p.b.size(3), n_s = p.b.size(1);
        Matrix found, wanted = given;
        if (tangent == dsigma_dF) found = by_differences(p, cauchy);
        if (tangent == dP_dF) found = by_differences(p, first_piola);
        if (tangent == dS_dE) {  // dS/dE : dE/dF is dS/dF
          Matrix dE_dF(n_s, n_F);
          for (int j = 0; j < n_F; ++j) {
            Matrix3d dF = Matrix3d::Zero();
            dF(tensor_row[j], tensor_column[j]) = 1;
            const Numbers dE = symmetric((dF.transpose() * p.F1 + p.F1.transpose() * dF) / 2, p.b);
            for (int i = 0; i < n_s; ++i) dE_dF(i, j) = dE[static_cast<std::size_t>(i)];
          }
          wanted = given * dE_dF;
          found = by_differences(p, second_piola);
        }
        if (tangent == dtau_ddF) {  // tau = J sigma, and F = (F F0^-1) F0
          found.resize(n_s, n_F);
          const double step = 1e-6;
          for (int j = 0; j < n_F; ++j) {
            Matrix3d direction = Matrix3d::Zero();
            direction(tensor_row[j], tensor_column[j]) = 1;
            if (plane_stress && j == 2) direction.setZero();  // F33 is not read
            Numbers tau[2];
            for (int s = 0; s < 2; ++s) {
              Point q = p;
              q.kind = none, q.measure = cauchy;
              q.F1 = (p.F1 * p.F0.inverse() + (s == 0 ? -step : step) * direction) * p.F0;
              EXPECT_EQ(q.integrate(), 1) << q.message;
              tau[s] = q.used_stress();
              for (double& x : tau[s]) x *= q.variables1[3];
            }
            for (int i = 0; i < n_s; ++i) {
              found(i, j) =
                  (tau[1][static_cast<std::size_t>(i)] - tau[0][static_cast<std::size_t>(i)]) / (2 * step);
            }
          }
        }
        worst[tangent] = larger(worst[tangent], difference(wanted, found));
      }
    }
  }
  std::printf("worst relative difference: dsigma/dF %.1e, dS/dE %.1e, dP/dF %.1e, dtau/ddF %.1e\n", worst[0],
              worst[1], worst[2], worst[3]);
  for (const double w : worst) EXPECT_LT(w, 2e-8);
}

TEST(Mgis, ElasticAndPredictionOperators) {
  samples::Random r(5);
  for (const std::string& h : hypotheses) {
    Point p = growing(h, r);
    ASSERT_EQ(p.integrate(), 1) << p.message;
    const Matrix with_growth = p.used_operator();
    p.kind = elastic;
    ASSERT_EQ(p.integrate(), 1);
    const Matrix without = p.used_operator();
    EXPECT_GT(difference(without, with_growth), 1e-3);
    p.kind = secant;
    ASSERT_EQ(p.integrate(), 1);
    EXPECT_EQ(p.used_operator(), without);
    // The elastic operator at the state reached is that of an elastic step from it.
    Point q = p;
    q.variables0 = p.variables1;
    q.dt = 0;
    q.kind = consistent;
    ASSERT_EQ(q.integrate(), 1);
    EXPECT_LT(difference(q.used_operator(), without), 1e-13);

    // Predictions: at the beginning of the step, and nothing but K is written.
    p.stress.assign(9, untouched), p.variables1.assign(p.variables1.size(), untouched), p.energy = untouched;
    for (const Kind kind : {prediction_elastic, prediction_tangent}) {
      p.kind = kind;
      ASSERT_EQ(p.integrate(), 1) << p.message;
      EXPECT_EQ(p.stress, Numbers(9, untouched));
      EXPECT_EQ(p.variables1, Numbers(p.variables1.size(), untouched));
      EXPECT_EQ(p.energy, untouched);
      Point at_start = p;
      at_start.F1 = p.F0;
      at_start.kind = consistent;
      if (kind == prediction_elastic) at_start.dt = 0;
      ASSERT_EQ(at_start.integrate(), 1);
      EXPECT_EQ(p.used_operator(), at_start.used_operator());
    }
  }
}

TEST(Mgis, AHistoryStartsFromZeros) {
  // Ten percent of stretch along the fibre in a day, held to day ten; MGIS begins with variables of 0.
  Point p("Tridimensional");
  const myogrowth::FibreGrowth<> muscle;
  myogrowth::State<> state;
  for (int n = 1; n <= 100; ++n) {
    p.F1(0, 0) = 1 + 0.1 * std::min(1.0, 0.1 * n);
    ASSERT_EQ(p.integrate(), 1) << p.message;
    state = myogrowth::update(muscle, p.F1, state, p.dt).state;
    p.end_step();
  }
  EXPECT_EQ(p.variables0[0], state.G);
  EXPECT_GT(state.G, 1.05);
}

TEST(Mgis, ErrorsNameTheEntry) {
  const auto told = [](Point p) {
    EXPECT_EQ(p.integrate(), -1);
    EXPECT_EQ(p.rdt, 0.25);
    EXPECT_EQ(p.variables1, Numbers(p.variables1.size(), untouched));
    const bool asked_well = p.kind < 50 && p.measure <= 2 && p.tangent <= 3;  // else sizes are not known
    if (asked_well) {
      for (double x : p.used_stress()) EXPECT_TRUE(std::isnan(x));
      EXPECT_TRUE(p.used_operator().array().isNaN().all());
      EXPECT_TRUE(std::isnan(p.energy));
    } else {
      EXPECT_EQ(p.stress, Numbers(9, untouched));
      EXPECT_EQ(p.energy, untouched);
    }
    const std::size_t used = asked_well ? static_cast<std::size_t>(p.used_operator().size()) : 3;  // K[0..2]
    for (std::size_t i = used; i < p.K.size(); ++i) EXPECT_EQ(p.K[i], untouched);
    const std::string text = p.message;
    EXPECT_EQ(p.integrate(false), -1);
    return text;
  };
  Point p("Tridimensional");
  p.properties[4] = 0.9;
  EXPECT_EQ(told(p),
            "FibreGrowth: G_max = 0.9: largest relative serial sarcomere number, must be finite and > 1.");
  p = Point("PlaneStress");
  p.properties[6] = 0;
  EXPECT_EQ(told(p),
            "FibreGrowth: n0_1, n0_2, n0_3 = 0, 0, 0: n0, the fibre direction, must have a length > 0.");
  p = Point("PlaneStrain");
  p.variables0[0] = -1;
  EXPECT_NE(told(p).find("G = -1 at the beginning of the step"), std::string::npos);
  const auto set = reinterpret_cast<int (*)(const char*, double)>(p.b.find("setParameter"));
  p = Point("PlaneStress");
  p.variables0[2] = -1;
  set("integration", 1);
  EXPECT_NE(told(p).find("lambda = -1 at the beginning of the step"), std::string::npos);
  set("integration", 0);
  p = Point("Tridimensional");
  p.F1(0, 0) = -1;
  EXPECT_EQ(told(p), "FibreGrowth: inverted: det F must be > 0.");
  p.integrate();
  EXPECT_TRUE(std::isnan(p.stress[0]));
  p.F1(0, 0) = std::nan("");
  EXPECT_NE(told(p).find("not finite"), std::string::npos);
  p = Point("Tridimensional");
  p.kind = 104;
  EXPECT_NE(told(p).find("K[0] = 104: the speed of sound"), std::string::npos);
  p.kind = consistent;
  p.measure = 3;
  EXPECT_NE(told(p).find("K[1] = 3"), std::string::npos);
  p.measure = cauchy;
  p.tangent = 4;
  EXPECT_NE(told(p).find("K[2] = 4"), std::string::npos);
  p.tangent = dP_dF;
  p.rdt = 0.1;  // another point has asked for less
  p.F1(0, 0) = -1;
  EXPECT_EQ(p.integrate(), -1);
  EXPECT_EQ(p.rdt, 0.1);
}

TEST(Mgis, ParametersHaveDefaultsAndAreSetByName) {
  Point p("Tridimensional");
  const auto set = reinterpret_cast<int (*)(const char*, double)>(p.b.find("setParameter"));
  ASSERT_NE(set, nullptr);
  EXPECT_EQ(set("energi", 1), 0);
  EXPECT_EQ(set("energy", std::nan("")), 0);

  p.F1(0, 0) = 1.2;
  p.variables0[0] = 1.05;
  p.kind = none, p.dt = 0;
  ASSERT_EQ(p.integrate(), 1);
  const Numbers per_reference = p.used_stress();
  EXPECT_EQ(set("energy", 1), 1);
  ASSERT_EQ(p.integrate(), 1);
  EXPECT_NEAR(p.stress[0], 1.05 * per_reference[0], 1e-12);
  EXPECT_EQ(set("energy", 2), 1);
  EXPECT_EQ(p.integrate(), -1);
  EXPECT_EQ(p.message,
            "FibreGrowth: energy = 2: psi per unit 0: reference volume, 1: grown volume, must be finite "
            "and 0 or 1.");
  EXPECT_EQ(set("energy", 0), 1);

  // Advice on the time step: a result, and a factor below 1.
  EXPECT_EQ(set("tolerance", 1e-6), 1);
  p.dt = 1;
  p.rdt = 1;
  EXPECT_EQ(p.integrate(), 0);
  EXPECT_GE(p.rdt, 0.25);
  EXPECT_LT(p.rdt, 0.99);
  EXPECT_GT(p.variables1[0], 1.05);
  EXPECT_EQ(set("tolerance", 0), 1);
  EXPECT_EQ(p.integrate(), 1);
}

}  // namespace
