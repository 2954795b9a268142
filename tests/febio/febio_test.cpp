// The FEBio plugin, called as FEBio does: PluginInitialize, classes by name, Init, Update at the beginning of
// a step, stress and tangent in every iteration, Serialize before a step and after one that failed.
#include <gtest/gtest.h>

#include "../support/samples.hpp"
#include "febio_like.hpp"

extern "C" unsigned int GetSDKVersion();
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

  explicit Host(std::map<std::string, double> parameters = {}) {
    model.parameters = std::move(parameters);
    model.fibre = {3, 2.4, 3.2};  // of any length
    material = kernel().create<FEElasticMaterial>("myogrowth fibre growth", &model);
    material->BuildParamList();
    point = std::make_unique<FEMaterialPoint>(material->CreateMaterialPointData());
  }
  void begin(double dt) {
    model.increment = dt;
    point->Update({dt});
  }
  mat3ds stress(const Eigen::Matrix3d& F) {
    FEElasticMaterialPoint& elastic = *point->ExtractData<FEElasticMaterialPoint>();
    for (int i = 0; i < 9; ++i) elastic.m_F(i / 3, i % 3) = F(i / 3, i % 3);
    elastic.m_J = F.determinant();
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

TEST(Febio, AStepThatFailedLeavesNothing) {
  Host straight, cut;
  straight.begin(0.3), straight.stress(on_path(0.3));
  cut.begin(0.3), cut.stress(on_path(0.3));
  DumpStream saved;
  cut.point->Serialize(saved);
  cut.begin(0.7), cut.stress(on_path(1.0));  // abandoned
  saved.loading = true;
  cut.point->Serialize(saved);
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

TEST(Febio, WhatIsNotAllowed) {
  EXPECT_THROW(Host({{"tau", 0.0}}), std::out_of_range);
  EXPECT_THROW(Host({{"G_max", 1.0}}), std::out_of_range);
  Host host;
  host.begin(0.1);
  EXPECT_TRUE(std::isnan(host.stress(-on_path(0))(0, 0)));
  EXPECT_NE(host.model.errors.find("det F"), std::string::npos) << host.model.errors;
}

}  // namespace
