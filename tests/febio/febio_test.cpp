// The FEBio plugin, called as FEBio does: PluginInitialize, classes by name, Init, Update at the beginning of
// a step, stress and tangent in every iteration, Serialize before a step and after one that failed.
#include <gtest/gtest.h>

#include <myogrowth/elastic/blemker.hpp>
#include <myogrowth/elastic/fibre_growth_of.hpp>

#include "../support/samples.hpp"
#include "febio_like.hpp"

extern "C" unsigned int GetSDKVersion();
extern "C" void GetPluginVersion(int& major, int& minor, int& patch);
extern "C" void PluginInitialize(FECoreKernel&);

namespace {

FECoreKernel& kernel() {
  static FECoreKernel kernel;
  static const bool initialised = (PluginInitialize(kernel), true);
  (void)initialised;
  return kernel;
}

Eigen::Matrix3d on_path(double t) {
  Eigen::Matrix3d F = Eigen::Vector3d(1 + 0.15 * t, 1 - 0.04 * t, 1 + 0.02 * t).asDiagonal();
  F(0, 1) = 0.1 * t, F(2, 0) = -0.05 * t;
  return F;
}

struct Host {
  FEModel model;
  std::unique_ptr<FEElasticMaterial> material;
  std::unique_ptr<FEMaterialPoint> point;

  using MakeElastic = std::function<FEElasticMaterial*(FEModel*)>;

  // elastic: what <elastic> of the material that has one is.
  explicit Host(std::map<std::string, double> parameters = {}, MakeElastic elastic = nullptr) {
    model.parameters = std::move(parameters);
    model.elastic = std::move(elastic);
    model.fibre = {3, 2.4, 3.2};  // of any length
    material = kernel().create<FEElasticMaterial>(
        model.elastic ? "myogrowth kinematic growth" : "myogrowth fibre growth", &model);
    material->BuildParamList();
    point = std::make_unique<FEMaterialPoint>(material->CreateMaterialPointData());
  }
  void begin(double dt) {
    model.increment = dt;
    point->Update({dt});
  }
  FEElasticMaterialPoint& deformation() { return *point->ExtractData<FEElasticMaterialPoint>(); }
  mat3ds stress(const Eigen::Matrix3d& F) {
    FEElasticMaterialPoint& whole = deformation();
    for (int i = 0; i < 9; ++i) whole.m_F(i / 3, i % 3) = F(i / 3, i % 3);
    whole.m_J = F.determinant();
    material->UpdateSpecializedMaterialPoints(*point, {model.increment});
    return material->Stress(*point);
  }
  double logged(const char* name) {
    FEElement element;
    element.points = {point.get(), point.get()};
    return kernel().create<FELogElemData>(name, &model)->value(element);
  }
};

TEST(Febio, StressStateAndTangent) {
  EXPECT_EQ(GetSDKVersion(), FE_SDK_VERSION);
  int version[3] = {-1, -1, -1};
  GetPluginVersion(version[0], version[1], version[2]);
  EXPECT_EQ(std::vector<int>(version, version + 3),
            (std::vector<int>{MYOGROWTH_VERSION_MAJOR, MYOGROWTH_VERSION_MINOR, MYOGROWTH_VERSION_PATCH}));
  Host host;
  myogrowth::State<> exact;
  exact.n0 = {0.6, 0.48, 0.64};
  double t = 0, worst = 0;
  const int voigt[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
  for (const double dt : {0.1, 0.3, 0.2, 0.4}) {
    t += dt;
    host.begin(dt);
    host.stress(0.5 * (on_path(t) + on_path(t - dt)));  // an iteration
    const Eigen::Matrix3d F = on_path(t);
    const auto u = myogrowth::update(myogrowth::FibreGrowth<>(), F, exact, dt);
    const mat3ds s = host.stress(F);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(s(i / 3, i % 3), u.cauchy()(i / 3, i % 3), 1e-14);
    ASSERT_TRUE(host.material->UseSecantTangent());
    // FEBio's modulus is dS/dE, pushed forward.
    const auto D = u.dS_dE();
    tens4dmm material(0.0);
    for (int i = 0; i < 81; ++i) {
      material(i % 3, i / 3 % 3, i / 9 % 3, i / 27) = D(voigt[i % 3][i / 3 % 3], voigt[i / 9 % 3][i / 27]);
    }
    const tens4dmm pushed =
        material.pp(host.point->ExtractData<FEElasticMaterialPoint>()->m_F) * (1 / F.determinant());
    const tens4dmm c = host.material->SecantTangent(*host.point),
                   C = host.material->SecantTangent(*host.point, true);
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b < 6; ++b) {
        worst =
            std::max({worst, std::abs(c.d[a][b] - pushed.d[a][b]), std::abs(C.d[a][b] - material.d[a][b])});
      }
    }
    exact = u.state;
    EXPECT_EQ(host.logged("sarcomere number"), exact.G);
    EXPECT_EQ(host.logged("elastic fibre stretch"), u.point.lambda_e);
    EXPECT_NEAR(host.material->StrainEnergyDensity(*host.point), u.point.psi, 1e-14);
  }
  EXPECT_GT(exact.G, 1.01);
  EXPECT_LT(worst, 1e-12);
  FEDomain domain;
  FEDataStream plot;
  domain.element.points = {host.point.get()};
  for (const char* name : {"sarcomere number", "total relative volume", "elastic relative volume"}) {
    kernel().create<FEPlotDomainData>(name, &host.model)->Save(domain, plot);
  }
  EXPECT_EQ(plot.numbers[0], exact.G);
  EXPECT_NEAR(plot.numbers[1], on_path(t).determinant(), 1e-15);
  EXPECT_NEAR(plot.numbers[2] * exact.G, plot.numbers[1], 1e-15);
}

/// A step as FEBio tries it, and goes back to what it has saved before.
void abandon_a_step(Host& host) {
  DumpStream saved;
  host.point->Serialize(saved);
  host.begin(0.7), host.stress(on_path(1.0));
  saved.loading = true;
  host.point->Serialize(saved);
}

TEST(Febio, AStepThatFailedLeavesNothing) {
  Host straight, cut;
  straight.begin(0.3), straight.stress(on_path(0.3));
  cut.begin(0.3), cut.stress(on_path(0.3));
  abandon_a_step(cut);
  for (Host* host : {&straight, &cut}) {
    host->begin(0.35), host->stress(on_path(0.65));
    host->begin(0.35), host->stress(on_path(1.0));
  }
  EXPECT_GT(straight.logged("sarcomere number"), 1.01);
  EXPECT_EQ(straight.logged("sarcomere number"), cut.logged("sarcomere number"));
}

TEST(Febio, TheFibreIsInTheMaterialsAxes) {
  Host given, turned;
  given.model.fibre = {0, 1, 0};
  turned.model.fibre = {1, 0, 0};
  turned.model.axes.a[0][0] = turned.model.axes.a[1][1] = 0;
  turned.model.axes.a[1][0] = 1, turned.model.axes.a[0][1] = -1;
  for (Host* host : {&given, &turned}) host->begin(0.5);
  const mat3ds a = given.stress(on_path(-1)), b = turned.stress(on_path(-1));
  for (int i = 0; i < 9; ++i) EXPECT_EQ(a(i / 3, i % 3), b(i / 3, i % 3));
  EXPECT_GT(given.logged("sarcomere number"), 1.005);  // on_path(-1) lengthens along y
}

// ---- Materials of FEBio's kind, to be wrapped.

constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

// FEBio's `neo-Hookean`: W = mu/2 (I1 - 3) - mu ln J + lambda/2 ln^2 J, so eq. 3 with c1 = lambda, c2 = mu.
class NeoHookeanOfFEBio : public FEElasticMaterial {
 public:
  explicit NeoHookeanOfFEBio(FEModel* model) : FEElasticMaterial(model) {}
  double of_lambda = 16, mu = 4;
  mat3ds Stress(FEMaterialPoint& point) override {
    const FEElasticMaterialPoint& e = *point.ExtractData<FEElasticMaterialPoint>();
    const auto s = [&](int i, int j) {
      double b = 0;
      for (int k = 0; k < 3; ++k) b += e.m_F(i, k) * e.m_F(j, k);
      return (mu * (b - (i == j)) + of_lambda * std::log(e.m_J) * (i == j)) / e.m_J;
    };
    return mat3ds(s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2));
  }
  tens4ds Tangent(FEMaterialPoint& point) override {
    const double J = point.ExtractData<FEElasticMaterialPoint>()->m_J, m = mu - of_lambda * std::log(J);
    tens4dmm c(0.0);
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) c(a, a, b, b) = (of_lambda + 2 * m * (a == b)) / J;
      c(a, (a + 1) % 3, a, (a + 1) % 3) = m / J;
    }
    return c.supersymm();
  }
  double StrainEnergyDensity(FEMaterialPoint& point) override {
    const FEElasticMaterialPoint& e = *point.ExtractData<FEElasticMaterialPoint>();
    double I1 = 0;
    for (int i = 0; i < 9; ++i) I1 += e.m_F(i / 3, i % 3) * e.m_F(i / 3, i % 3);
    return mu / 2 * (I1 - 3 - 2 * std::log(e.m_J)) + of_lambda / 2 * std::pow(std::log(e.m_J), 2);
  }
};

// A law of the library as a material of FEBio: anisotropic and active.
class ActiveMuscle : public FEElasticMaterial {
 public:
  explicit ActiveMuscle(FEModel* model) : FEElasticMaterial(model) {}
  static myogrowth::Blemker<> law() {
    myogrowth::Blemker<> law;
    law.kappa = 100;
    return law;
  }
  static constexpr double activation = 0.3;
  mat3ds Stress(FEMaterialPoint& point) override {
    const auto r = at(point);
    const double J = point.ExtractData<FEElasticMaterialPoint>()->m_J;
    return mat3ds(r.tau[0] / J, r.tau[1] / J, r.tau[2] / J, r.tau[3] / J, r.tau[5] / J, r.tau[4] / J);
  }
  tens4ds Tangent(FEMaterialPoint& point) override {
    const auto r = at(point);
    double C[36];
    myogrowth::truesdell_from_jaumann(r.tau, r.c, C);
    tens4dmm c(0.0);
    for (int i = 0; i < 36; ++i) {
      c(row[i % 6], column[i % 6], row[i / 6], column[i / 6]) =
          C[i] / point.ExtractData<FEElasticMaterialPoint>()->m_J;
    }
    return c.supersymm();
  }
  double StrainEnergyDensity(FEMaterialPoint& point) override { return at(point).psi; }

 private:
  myogrowth::ElasticResponse<double> at(FEMaterialPoint& point) {
    const FEElasticMaterialPoint& e = *point.ExtractData<FEElasticMaterialPoint>();
    double F[9];
    for (int i = 0; i < 9; ++i) F[i] = e.m_F(i % 3, i / 3);
    const vec3d n = model_->fibre.Normalized();
    const double n0[3] = {n.x, n.y, n.z};
    myogrowth::ElasticResponse<double> r;
    evaluate(law(), F, n0, activation, r);
    return r;
  }
};

// With a point of its own: the stress is larger by what the point remembers of the last step, and there is
// one only where the point was prepared.
class WithHistory : public NeoHookeanOfFEBio {
 public:
  using NeoHookeanOfFEBio::NeoHookeanOfFEBio;
  struct Point : FEMaterialPointData {
    using FEMaterialPointData::FEMaterialPointData;
    double now = 0, before = 0, prepared = 0;
    mat3d rate;
    void Update(const FETimeInfo& time) override {
      FEMaterialPointData::Update(time);
      before = now;
    }
    void Serialize(DumpStream& stream) override {
      FEMaterialPointData::Serialize(stream);
      stream& now& before;
    }
  };
  FEMaterialPointData* CreateMaterialPointData() override {
    return new Point(NeoHookeanOfFEBio::CreateMaterialPointData());
  }
  void UpdateSpecializedMaterialPoints(FEMaterialPoint& point, const FETimeInfo&) override {
    point.ExtractData<Point>()->prepared = point.ExtractData<FEElasticMaterialPoint>()->m_J;
  }
  mat3ds Stress(FEMaterialPoint& point) override {
    Point& own = *point.ExtractData<Point>();
    const FEElasticMaterialPoint& e = *point.ExtractData<FEElasticMaterialPoint>();
    if (own.prepared != e.m_J) throw std::logic_error("the point was not prepared");
    own.now = e.m_F(0, 0) - 1;
    own.rate = e.m_L;
    const mat3ds s = NeoHookeanOfFEBio::Stress(point);
    const double f = factor(own);
    return mat3ds(f * s(0, 0), f * s(1, 1), f * s(2, 2), f * s(0, 1), f * s(1, 2), f * s(0, 2));
  }
  tens4ds Tangent(FEMaterialPoint& point) override {
    tens4ds c = NeoHookeanOfFEBio::Tangent(point);
    for (auto& entries : c.d) {
      for (double& x : entries) x *= factor(*point.ExtractData<Point>());
    }
    return c;
  }
  static double factor(const Point& own) { return 1 + 5 * own.before; }
};

template <class Material>
FEElasticMaterial* make(FEModel* model) {
  return new Material(model);
}

TEST(FebioKinematic, NeoHookeanIsTheFirstMaterial) {
  for (const double grown : {0.0, 1.0}) {
    for (const double integration : {0.0, 1.0}) {
      Host first({{"energy", grown}, {"integration", integration}}),
          wrapped({{"energy", grown}, {"integration", integration}}, make<NeoHookeanOfFEBio>);
      ASSERT_TRUE(first.material->Init() && wrapped.material->Init());
      double t = 0;
      for (const double dt : {0.1, 0.3, 0.2, 0.4}) {
        t += dt;
        first.begin(dt), wrapped.begin(dt);
        const mat3ds a = first.stress(on_path(t)), b = wrapped.stress(on_path(t));
        for (int i = 0; i < 9; ++i) EXPECT_NEAR(a(i / 3, i % 3), b(i / 3, i % 3), 1e-14);
        const tens4dmm c = first.material->SecantTangent(*first.point),
                       d = wrapped.material->SecantTangent(*wrapped.point);
        for (int i = 0; i < 36; ++i) EXPECT_NEAR(c.d[i / 6][i % 6], d.d[i / 6][i % 6], 1e-12);
        EXPECT_NEAR(first.material->StrainEnergyDensity(*first.point),
                    wrapped.material->StrainEnergyDensity(*wrapped.point), 1e-14);
        for (const char* name : {"sarcomere number", "elastic fibre stretch", "elastic relative volume"})
          EXPECT_EQ(first.logged(name), wrapped.logged(name));
        EXPECT_EQ(wrapped.deformation().m_F(0, 1), on_path(t)(0, 1));  // the whole's again
        EXPECT_EQ(wrapped.deformation().m_J, on_path(t).determinant());
      }
      EXPECT_GT(first.logged("sarcomere number"), 1.01);
      EXPECT_EQ(wrapped.model.errors, "");
    }
  }
}

TEST(FebioKinematic, AnActiveMuscleIsTheLibrarys) {
  Host host({}, make<ActiveMuscle>);
  ASSERT_TRUE(host.material->Init());
  myogrowth::FibreGrowthOf<myogrowth::Blemker<>> muscle;
  muscle.elastic = ActiveMuscle::law();
  const double n0[3] = {0.6, 0.48, 0.64};
  double G = 1, t = 0;
  for (const double dt : {0.1, 0.3, 0.2, 0.4}) {
    t += dt;
    host.begin(dt);
    const Eigen::Matrix3d F = on_path(t);
    myogrowth::ElasticPointUpdate<double> u;
    update_point(muscle, F.data(), n0, G, 1., dt, u, ActiveMuscle::activation);
    const mat3ds s = host.stress(F);
    for (int a = 0; a < 6; ++a) EXPECT_NEAR(s(row[a], column[a]) * u.J, u.tau[a], 1e-12);
    G = u.G;
  }
  EXPECT_GT(G, 1.01);
  EXPECT_NEAR(host.logged("sarcomere number"), G, 1e-15);
}

// The modulus in the material frame, dS/dE, against differences of S of whole steps, growth included; the
// point's own history goes with it.
TEST(FebioKinematic, TheTangentIsThatOfTheStep) {
  for (const auto& elastic : {Host::MakeElastic(make<ActiveMuscle>), Host::MakeElastic(make<WithHistory>)}) {
    Host host({}, elastic);
    host.begin(0.4), host.stress(on_path(0.4));
    host.begin(0.6);
    const auto second_piola = [&](const Eigen::Matrix3d& F) {
      host.stress(F);
      return host.material->SecantStress(*host.point, true);
    };
    const Eigen::Matrix3d F = on_path(1);
    host.stress(F);
    const tens4dmm C = host.material->SecantTangent(*host.point, true);
    const double h = 1e-5;
    double worst = 0, skew = 0, size = 0;
    for (int b = 0; b < 6; ++b) {
      Eigen::Matrix3d E = Eigen::Matrix3d::Zero();
      E(row[b], column[b]) += 0.5, E(column[b], row[b]) += 0.5;  // dE; dF = F^-T dE
      const Eigen::Matrix3d dF = F.transpose().inverse() * E * h;
      const mat3ds up = second_piola(F + dF), down = second_piola(F - dF);
      for (int a = 0; a < 6; ++a) {
        const double of_step = (up(row[a], column[a]) - down(row[a], column[a])) / (2 * h),
                     ours = C(row[a], column[a], row[b], column[b]);
        worst = std::max(worst, std::abs(of_step - ours));
        size = std::max(size, std::abs(ours));
        skew = std::max(skew, std::abs(ours - C(row[b], column[b], row[a], column[a])));
      }
    }
    EXPECT_LT(worst, 1e-8 * size);
    EXPECT_GT(skew, 1e-3 * size);  // the muscle grows
  }
}

TEST(FebioKinematic, AStepThatFailedLeavesNothingInThePartsEither) {
  Host straight({}, make<WithHistory>), cut({}, make<WithHistory>);
  straight.begin(0.3), straight.stress(on_path(0.3));
  cut.begin(0.3), cut.stress(on_path(0.3));
  abandon_a_step(cut);
  mat3ds a, b;
  for (int i = 1; i < 3; ++i) {
    straight.begin(0.35), cut.begin(0.35);
    a = straight.stress(on_path(0.3 + 0.35 * i)), b = cut.stress(on_path(0.3 + 0.35 * i));
  }
  EXPECT_GT(straight.logged("sarcomere number"), 1.01);
  EXPECT_EQ(straight.logged("sarcomere number"), cut.logged("sarcomere number"));
  EXPECT_NE(straight.point->ExtractData<WithHistory::Point>()->before, 0);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(a(i / 3, i % 3), b(i / 3, i % 3));
}

// What a viscous material sees is the rate of the elastic deformation.
TEST(FebioKinematic, TheRateIsThatOfTheElasticPart) {
  Host host({}, make<WithHistory>);
  const Eigen::Vector3d n(0.6, 0.48, 0.64);
  Eigen::Matrix3d Fe_n = Eigen::Matrix3d::Identity(), F_n = Fe_n;
  double t = 0;
  for (const double dt : {0.3, 0.4}) {
    t += dt;
    host.begin(dt);
    const Eigen::Matrix3d F = on_path(t), L = (F - F_n) * F.inverse() / dt;
    for (int i = 0; i < 9; ++i) host.deformation().m_L(i / 3, i % 3) = L(i / 3, i % 3);
    host.stress(F);
    const double G = host.logged("sarcomere number");
    const Eigen::Matrix3d Fe = F + (1 / G - 1) * F * n * n.transpose(),
                          expected = (Fe - Fe_n) * Fe.inverse() / dt;
    const mat3d& rate = host.point->ExtractData<WithHistory::Point>()->rate;
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(rate(i / 3, i % 3), expected(i / 3, i % 3), 1e-14);
    for (int i = 0; i < 9; ++i) EXPECT_EQ(host.deformation().m_L(i / 3, i % 3), L(i / 3, i % 3));
    Fe_n = Fe, F_n = F;
  }
}

TEST(FebioKinematic, WhatCannotGrowIsRefused) {
  struct Remodeling : NeoHookeanOfFEBio {
    using NeoHookeanOfFEBio::NeoHookeanOfFEBio;
    const char* GetTypeStr() override { return "remodeling solid"; }
  };
  struct WithoutDeformation : NeoHookeanOfFEBio {
    using NeoHookeanOfFEBio::NeoHookeanOfFEBio;
    FEMaterialPointData* CreateMaterialPointData() override { return new FEMaterialPointData; }
  };
  Host grows_twice({}, [](FEModel* model) {
    return kernel().create<FEElasticMaterial>("myogrowth fibre growth", model).release();
  });
  EXPECT_FALSE(grows_twice.material->Init());
  EXPECT_NE(grows_twice.model.errors.find("grows by myogrowth already"), std::string::npos);
  Host remodeling({}, make<Remodeling>);
  EXPECT_FALSE(remodeling.material->Init());
  EXPECT_NE(remodeling.model.errors.find("<elastic type=\"remodeling solid\">"), std::string::npos)
      << remodeling.model.errors;
  Host without({}, make<WithoutDeformation>);
  EXPECT_FALSE(without.material->Init());
}

// The point has the whole's deformation again after a material that threw.
TEST(FebioKinematic, AMaterialThatThrows) {
  struct Throwing : NeoHookeanOfFEBio {
    using NeoHookeanOfFEBio::NeoHookeanOfFEBio;
    mat3ds Stress(FEMaterialPoint&) override { throw std::runtime_error("negative Jacobian"); }
  };
  Host host({}, make<Throwing>);
  host.begin(0.5);
  EXPECT_THROW(host.stress(on_path(1)), std::runtime_error);
  EXPECT_EQ(host.deformation().m_F(0, 0), on_path(1)(0, 0));
  EXPECT_EQ(host.deformation().m_J, on_path(1).determinant());
}

TEST(Febio, RemovalAndTheEnergysVolume) {
  Host host({{"tau_rev", 0.5}, {"gamma_rev", 1}, {"G_min", 0.7}, {"lambda_crit_rev", 0.99}, {"energy", 1}});
  ASSERT_TRUE(host.material->Init());
  host.begin(0.5);
  const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() * 0.95;
  const mat3ds s = host.stress(F);
  myogrowth::FibreGrowth<> material;
  material.removal = {0.5, 1, 0.7, 0.99};
  material.energy = myogrowth::EnergyPer::grown_volume;
  myogrowth::State<> state;
  state.n0 = {0.6, 0.48, 0.64};
  const auto u = myogrowth::update(material, F, state, 0.5);
  EXPECT_LT(u.point.G, 0.999);
  EXPECT_EQ(host.logged("sarcomere number"), u.point.G);
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(s(i / 3, i % 3), u.cauchy()(i / 3, i % 3), 1e-14);
}

// FEBio keeps the upper triangle of a symmetric stiffness: it must be that of the symmetric part.
TEST(Febio, ASymmetricStiffness) {
  Host host;
  host.begin(0.5), host.stress(on_path(1));
  const tens4dmm c = host.material->SolidTangent(*host.point);
  host.model.step.solver.m_msymm = REAL_SYMMETRIC;
  const tens4dmm s = host.material->SolidTangent(*host.point);
  double skew = 0;
  for (int i = 0; i < 36; ++i) {
    const int a = i / 6, b = i % 6;
    EXPECT_EQ(s.d[a][b], (c.d[a][b] + c.d[b][a]) / 2);
    skew = std::max(skew, std::abs(c.d[a][b] - c.d[b][a]));
  }
  EXPECT_GT(skew, 0.1);
}

// FEBio's own would take differences of the energy, growth included.
TEST(Febio, TheSecantStressIsTheStress) {
  Host host;
  host.begin(0.5);
  const mat3ds s = host.stress(on_path(1)), t = host.material->SecantStress(*host.point);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(s(i / 3, i % 3), t(i / 3, i % 3));
}

TEST(Febio, WhatIsNotAllowed) {
  const std::pair<const char*, double> bad[] = {{"tau", 0},   {"G_max", 1},  {"lambda_crit", 0},
                                                {"c2", 0},    {"gamma", -1}, {"tau_rev", -1},
                                                {"tau", NAN}, {"c1", -3}};
  for (const auto& [name, value] : bad) {
    Host host({{name, value}});
    EXPECT_FALSE(host.material->Init());
    EXPECT_EQ(host.model.errors.find(std::string("muscle: ") + name + " = "), 0) << host.model.errors;
  }
  EXPECT_THROW(Host({{"energy", 2.0}}), std::out_of_range);
  Host host;
  ASSERT_TRUE(host.material->Init());
  host.begin(0.1);
  EXPECT_TRUE(std::isnan(host.stress(-on_path(0))(0, 0)));
  EXPECT_NE(host.model.errors.find("det F"), std::string::npos) << host.model.errors;
}

}  // namespace
