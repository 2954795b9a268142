// The UMAT in the element families that are not solids: NTENS = 4 (plane strain, axisymmetric) and 3 (plane
// stress). A small host, a patch of five distorted quadrilaterals, calls it as Abaqus documents and solves by
// Newton's method.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <myogrowth/more/stress_states.hpp>

#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using namespace myogrowth;
using host::Call;

namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();

/// STRESS and DDSDDE of a call with fewer components.
Eigen::VectorXd stress_of(const Call& c) { return c.stress.head(c.ntens); }
Eigen::MatrixXd ddsdde_of(const Call& c) {
  return Eigen::Map<const Eigen::MatrixXd>(c.ddsdde.data(), c.ntens, c.ntens);
}

Call call(samples::Random& r, int ntens) {
  Call c;
  c.ntens = ntens;
  const Eigen::Vector3d n0 = samples::direction(r);
  c.props = {16, 4, 0.5, 2, 1.5, 0.7, n0[0], n0[1], n0[2]};
  c.statev.assign(9, 0.0);
  do {
    c.F = samples::deformation(r, 0.3);
    c.F(0, 2) = c.F(1, 2) = c.F(2, 0) = c.F(2, 1) = 0;
  } while (c.F(2, 2) < 0.3 || c.F(0, 0) * c.F(1, 1) - c.F(0, 1) * c.F(1, 0) < 0.1);
  return c;
}

TEST(ElementFamilies, FourComponentsAreThoseOfTheSolid) {
  samples::Random r(61);
  for (int i = 0; i < 200; ++i) {
    Call solid = call(r, 6), plane = solid;
    plane.ntens = 4;
    plane.F(0, 2) = plane.F(1, 2) = plane.F(2, 0) = plane.F(2, 1) = nan;  // not there in such elements
    solid.run();
    plane.run();
    EXPECT_EQ(stress_of(plane), solid.stress.head(4));
    EXPECT_EQ(ddsdde_of(plane), (solid.ddsdde.topLeftCorner<4, 4>()));
    EXPECT_EQ(plane.statev, solid.statev);
    EXPECT_EQ(plane.stress[4], host::untouched);
    EXPECT_EQ(plane.ddsdde(16), host::untouched);
  }
}

TEST(ElementFamilies, ThreeComponentsArePlaneStress) {
  samples::Random r(62);
  for (int i = 0; i < 200; ++i) {
    Call c = call(r, 3);
    const double F[4] = {c.F(0, 0), c.F(1, 0), c.F(0, 1), c.F(1, 1)};
    c.F.row(2).setConstant(nan);
    c.F.col(2).setConstant(nan);
    FibreGrowth<> m;
    m.growth = {0.5, 2, 1.5, 0.7};
    PointUpdate<double> u;
    double thickness = 0;
    Eigen::Matrix3d modulus;
    ASSERT_EQ(plane_stress(m, F, &c.props[6], 1.0, 1.0, c.dtime, thickness, u, modulus.data()),
              UpdateStatus::ok);
    Call without = c;
    without.statev.resize(8);  // nowhere to keep the thickness
    c.run();
    without.run();
    EXPECT_LE((stress_of(c) - Eigen::Vector3d(u.tau[0], u.tau[1], u.tau[3]) / u.J).norm(),
              1e-15 * stress_of(c).norm());
    EXPECT_LE((ddsdde_of(c) - modulus / u.J).norm(), 1e-15 * modulus.norm());
    EXPECT_EQ(c.statev[8], thickness);
    EXPECT_EQ(stress_of(c), stress_of(without));
    Call next = c;  // starts from the thickness that was kept
    next.statev[0] = 1;
    next.run();
    EXPECT_NEAR(next.statev[8] / thickness, 1, 1e-14);
  }
}

// Shells and membranes: DFGRD1 is the classical local F, with PROPS(10) = 1.
TEST(ElementFamilies, ShellInALocalBasis) {
  samples::Random r(63);
  for (int i = 0; i < 100; ++i) {
    Call global = call(r, 3);
    Eigen::Matrix2d F = global.F.topLeftCorner<2, 2>();
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix2d R = svd.matrixU() * svd.matrixV().transpose();
    Call local = global;
    local.F.topLeftCorner<2, 2>() = R.transpose() * F;  // in the basis that has turned with the material
    local.props.push_back(1);
    global.run();
    local.run();
    Eigen::Matrix2d a, b;
    a << global.stress[0], global.stress[2], global.stress[2], global.stress[1];
    b << local.stress[0], local.stress[2], local.stress[2], local.stress[1];
    EXPECT_LE((R.transpose() * a * R - b).norm(), 1e-12 * a.norm());
    EXPECT_NEAR(local.statev[0], global.statev[0], 1e-13);
    EXPECT_NEAR(local.statev[8], global.statev[8], 1e-13);
  }
}

TEST(ElementFamilies, RefuseWhatCannotBe) {
  for (int ntens : {3, 4}) {
    Call c;
    c.ntens = ntens;
    c.statev.assign(9, 0.0);
    c.F(1, 1) = -1;
    c.run();
    EXPECT_EQ(c.pnewdt, 0.25);
    EXPECT_TRUE(stress_of(c).array().isNaN().all());
    EXPECT_EQ(c.statev, std::vector<double>(9, 0.0));
  }
}

enum class Family { plane_strain, plane_stress, axisymmetric };

/// MacNeal and Harder's patch: a square around a distorted one, five elements. Reference coordinates.
struct Patch {
  Family family;
  std::vector<double> props;
  Eigen::Matrix<double, 8, 2> X;
  const int element[5][4] = {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}};
  double radius = 0;  // of the left edge, axisymmetric

  struct Point {
    Call call;
    double R = 1;
  };
  std::vector<Point> points;  // after assemble

  Patch(Family f, std::vector<double> p) : family(f), props(std::move(p)) {
    X << 0, 0, 1, 0, 1, 1, 0, 1, 0.2, 0.15, 0.75, 0.3, 0.8, 0.7, 0.25, 0.65;
    if (family == Family::axisymmetric) X.col(0).array() += 1;
  }
  int ntens() const { return family == Family::plane_stress ? 3 : 4; }

  /// Internal forces and tangent at the displacements u (16), from G = 1, for a step dt.
  void assemble(const Eigen::VectorXd& u, double dt, Eigen::VectorXd& f, Eigen::MatrixXd& K) {
    f = Eigen::VectorXd::Zero(16);
    K = Eigen::MatrixXd::Zero(16, 16);
    points.clear();
    const double a = 1 / std::sqrt(3.0);
    for (const auto& nodes : element) {
      for (int q = 0; q < 4; ++q) {
        const double xi[4] = {-1, 1, 1, -1}, eta[4] = {-1, -1, 1, 1};
        Eigen::Matrix<double, 4, 2> dN_dxi, Xe, ue;
        Eigen::Vector4d N;
        for (int k = 0; k < 4; ++k) {
          N[k] = (1 + xi[k] * a * xi[q]) * (1 + eta[k] * a * eta[q]) / 4;
          dN_dxi(k, 0) = xi[k] * (1 + eta[k] * a * eta[q]) / 4;
          dN_dxi(k, 1) = eta[k] * (1 + xi[k] * a * xi[q]) / 4;
          Xe.row(k) = X.row(nodes[k]);
          ue.row(k) = u.segment<2>(2 * nodes[k]).transpose();
        }
        const Eigen::Matrix2d jacobian = Xe.transpose() * dN_dxi;
        const Eigen::Matrix<double, 4, 2> dN_dX = dN_dxi * jacobian.inverse();
        Point p;
        p.R = family == Family::axisymmetric ? N.dot(Xe.col(0)) : 1;
        p.call.ntens = ntens();
        p.call.props = props;
        p.call.statev.assign(9, 0.0);
        p.call.dtime = dt;
        p.call.F.topLeftCorner<2, 2>() = Eigen::Matrix2d::Identity() + ue.transpose() * dN_dX;
        if (family == Family::axisymmetric) p.call.F(2, 2) = 1 + N.dot(ue.col(0)) / p.R;
        p.call.run();
        EXPECT_EQ(p.call.pnewdt, 1);
        const double J = p.call.statev[3], weight = J * jacobian.determinant() * p.R;
        const Eigen::Matrix<double, 4, 2> dN_dx = dN_dX * p.call.F.topLeftCorner<2, 2>().inverse();
        const double r = p.R * p.call.F(2, 2);

        // Gradient of the displacement: components 11 21 12 22 33.
        Eigen::Matrix<double, 5, 8> B = Eigen::Matrix<double, 5, 8>::Zero();
        for (int k = 0; k < 4; ++k) {
          B(0, 2 * k) = B(1, 2 * k + 1) = dN_dx(k, 0);
          B(2, 2 * k) = B(3, 2 * k + 1) = dN_dx(k, 1);
          if (family == Family::axisymmetric) B(4, 2 * k) = N[k] / r;
        }
        const Eigen::VectorXd s = stress_of(p.call);
        const Eigen::MatrixXd c = ddsdde_of(p.call);
        const bool has_33 = ntens() == 4;
        Eigen::Matrix3d sigma = Eigen::Matrix3d::Zero();
        sigma(0, 0) = s[0], sigma(1, 1) = s[1], sigma(0, 1) = sigma(1, 0) = s[has_33 ? 3 : 2];
        if (has_33) sigma(2, 2) = s[2];
        const int row[5] = {0, 1, 0, 1, 2}, col[5] = {0, 0, 1, 1, 2};
        const auto place = [&](int i, int j) { return i == j ? i : has_33 ? 3 : 2; };  // in Abaqus's order
        Eigen::Matrix<double, 5, 5> A = Eigen::Matrix<double, 5, 5>::Zero();
        Eigen::Matrix<double, 5, 1> flat;
        const int n = has_33 ? 5 : 4;
        for (int x = 0; x < n; ++x) {
          const int i = row[x], j = col[x];
          flat[x] = sigma(i, j);
          for (int y = 0; y < n; ++y) {
            const int k = row[y], l = col[y];
            A(x, y) = c(place(i, j), place(k, l)) + (i == k) * sigma(j, l) -
                      ((i == k) * sigma(j, l) + (i == l) * sigma(j, k) + (j == k) * sigma(i, l) +
                       (j == l) * sigma(i, k)) /
                          2;
          }
        }
        if (!has_33) flat[4] = 0;
        const Eigen::Matrix<double, 8, 1> fe = B.transpose() * flat * weight;
        const Eigen::Matrix<double, 8, 8> Ke = B.transpose() * A * B * weight;
        for (int i = 0; i < 8; ++i) {
          f[2 * nodes[i / 2] + i % 2] += fe[i];
          for (int j = 0; j < 8; ++j) K(2 * nodes[i / 2] + i % 2, 2 * nodes[j / 2] + j % 2) += Ke(i, j);
        }
        points.push_back(p);
      }
    }
  }
};

class PatchTest : public testing::TestWithParam<std::tuple<Family, Eigen::Vector3d>> {};

// The outer nodes move as a homogeneous deformation: so must the inner ones, with one stress everywhere; and
// Newton's method gets there quadratically, from a start that is wrong, in an increment with much growth.
TEST_P(PatchTest, HomogeneousStateAndQuadraticNewton) {
  const auto [family, n0] = GetParam();
  Patch patch(family, {16, 4, 0.5, 2, 1.3, 1.01, n0[0], n0[1], n0[2]});
  Eigen::Matrix2d H;
  H << 0.25, 0.2, -0.1, 0.15;
  if (family == Family::axisymmetric)
    H << -0.1, 0, 0, 0.25;  // along the axis 2; a radial shear is not homogeneous
  Eigen::VectorXd exact(16), u = Eigen::VectorXd::Zero(16), f;
  for (int node = 0; node < 8; ++node) exact.segment<2>(2 * node) = H * patch.X.row(node).transpose();
  u.head<8>() = exact.head<8>();
  u.tail<8>() = 0.7 * exact.tail<8>();
  Eigen::MatrixXd K;
  std::vector<double> residuals;
  for (int iteration = 0; iteration < 20; ++iteration) {
    patch.assemble(u, 1.0, f, K);
    residuals.push_back(f.tail<8>().norm() / f.norm());
    if (residuals.back() < 1e-14) break;
    u.tail<8>() -= K.bottomRightCorner<8, 8>().partialPivLu().solve(f.tail<8>());
  }
  EXPECT_LE((u - exact).norm(), 1e-12);
  EXPECT_LE(residuals.size(), 8u);
  for (std::size_t k = 2; k < residuals.size(); ++k) {
    if (residuals[k - 2] < 1e-2 && residuals[k] > 1e-13) {
      EXPECT_GE(std::log(residuals[k] / residuals[k - 1]) / std::log(residuals[k - 1] / residuals[k - 2]),
                1.7);
    }
  }
  for (const auto& p : patch.points) {
    EXPECT_GT(p.call.statev[0], 1.005);  // it grew
    EXPECT_LE((stress_of(p.call) - stress_of(patch.points[0].call)).norm(), 1e-11);
    EXPECT_NEAR(p.call.statev[0], patch.points[0].call.statev[0], 1e-12);
  }

  // And K is the derivative of f, with the inner nodes away from equilibrium.
  Eigen::VectorXd away = exact, plus, minus;
  samples::Random r(64);
  for (int i = 8; i < 16; ++i) away[i] += r.uniform(-0.02, 0.02);
  Eigen::MatrixXd ignored;
  patch.assemble(away, 1.0, f, K);
  for (int j = 0; j < 16; ++j) {
    Eigen::VectorXd step = Eigen::VectorXd::Unit(16, j) * 1e-6;
    patch.assemble(away + step, 1.0, plus, ignored);
    patch.assemble(away - step, 1.0, minus, ignored);
    EXPECT_LE(((plus - minus) / 2e-6 - K.col(j)).norm(), 1e-7 * K.norm()) << j;
  }
}

INSTANTIATE_TEST_SUITE_P(Families, PatchTest,
                         testing::Values(std::tuple(Family::plane_strain, Eigen::Vector3d(1, 0.3, 0)),
                                         std::tuple(Family::plane_strain, Eigen::Vector3d(1, 0.3, 0.4)),
                                         std::tuple(Family::plane_stress, Eigen::Vector3d(1, 0.3, 0)),
                                         std::tuple(Family::plane_stress, Eigen::Vector3d(1, 0.5, 0.2)),
                                         std::tuple(Family::axisymmetric, Eigen::Vector3d(0, 1, 0))));

}  // namespace
