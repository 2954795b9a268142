// PROPS(18) = 1, the UMAT in Abaqus/Standard's mixed (hybrid) elements with HYBRID FORMULATION=TOTAL: STRESS
// is three entries longer. Abaqus gives the independent volume ratio J^ in the first and takes K = J d2U/dJ^2
// and dK/dJ^ from the others.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using host::Call;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Call sample(samples::Random& r, int ntens, double c1) {
  Call c;
  c.ntens = ntens;
  const Eigen::Vector3d n0 = samples::direction(r);
  // Growth is active in all of them; second order and the grown energy in some.
  c.props = {c1,
             4,
             0.5,
             2,
             1.5,
             0.7,
             n0[0],
             n0[1],
             n0[2],
             0,
             r.uniform(0, 1) < 0.5 ? 0.0 : 1.0,
             r.uniform(0, 1) < 0.5 ? 0.0 : 1.0,
             0,
             0,
             0,
             0,
             0,
             1};
  c.statev.assign(9, 0.0);
  do {
    c.F = samples::deformation(r, 0.3);
    if (ntens == 4) c.F(0, 2) = c.F(1, 2) = c.F(2, 0) = c.F(2, 1) = 0;
  } while (c.F.determinant() < 0.3);
  c.J_hat = c.F.determinant();
  return c;
}

TEST(MixedElements, WithTheVolumeOfFItIsTheOrdinaryUpdate) {
  samples::Random r(71);
  for (int i = 0; i < 200; ++i) {
    Call mixed = sample(r, i % 2 ? 6 : 4, 16), plain = mixed;
    plain.props[17] = 0;
    mixed.run();
    plain.run();
    const int n = mixed.ntens;
    EXPECT_LE((mixed.stress - plain.stress).head(n).norm(), 1e-13 * (16 + plain.stress.head(n).norm()));
    const auto of = [n](const Call& c) { return Eigen::Map<const Eigen::MatrixXd>(c.ddsdde.data(), n, n); };
    EXPECT_LE((of(mixed) - of(plain)).norm(), 1e-13 * of(plain).norm());
    for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(mixed.statev[k], plain.statev[k], 1e-13) << k;
    EXPECT_EQ(plain.K, host::untouched);
  }
}

TEST(MixedElements, TheShapeIsThatOfFTheVolumeIsGiven) {
  samples::Random r(72);
  for (int i = 0; i < 200; ++i) {
    Call mixed = sample(r, 6, 16);
    const double J = mixed.F.determinant();
    mixed.J_hat = J * r.uniform(0.8, 1.25);
    Call scaled = mixed;
    scaled.props[17] = 0;
    scaled.F *= std::cbrt(mixed.J_hat / J);
    mixed.run();
    scaled.run();
    EXPECT_NEAR(mixed.statev[0], scaled.statev[0], 1e-13);
    EXPECT_NEAR(mixed.statev[3], mixed.J_hat, 1e-13);
    // The mean stress is work-conjugate to J^; the deviator counts per volume of F.
    const double mean = scaled.stress.head<3>().mean();
    EXPECT_NEAR(mixed.stress.head<3>().mean(), mean, 1e-12 * (16 + std::abs(mean)));
    Eigen::Matrix<double, 6, 1> deviator = scaled.stress * mixed.J_hat / J, got = mixed.stress;
    deviator.head<3>().array() -= mean * mixed.J_hat / J;
    got.head<3>().array() -= mean;
    EXPECT_LE((got - deviator).norm(), 1e-12 * (16 + deviator.norm()));
  }
}

// K, dK/dJ^ and DDSDDE against central differences of the discrete update; parameters up to nearly
// incompressible.
TEST(MixedElements, DerivativesOfTheDiscreteUpdate) {
  samples::Random r(73);
  for (double c1 : {16.0, 4e2, 4e4}) {
    for (int i = 0; i < 100; ++i) {
      Call c = sample(r, 6, c1);
      const double J = c.F.determinant(), ratio = r.uniform(0.9, 1.1);
      c.J_hat = J * ratio;
      Call at = Call(c).run();
      const double stiffness = at.ddsdde.norm(), h = 1e-5;

      Call up = c, down = c;
      up.J_hat += h, down.J_hat -= h;
      up.run(), down.run();
      const double dp = (up.stress - down.stress).head<3>().mean() / (2 * h);
      EXPECT_NEAR(at.K, J * dp, 2e-8 * (std::abs(at.K) + 1));
      EXPECT_NEAR(at.dK_dJ, (up.K - down.K) / (2 * h), 1e-7 * (std::abs(at.dK_dJ) + std::abs(at.K)));

      Matrix6 by_difference;
      const int row[6] = {0, 1, 2, 0, 0, 1}, col[6] = {0, 1, 2, 1, 2, 2};
      for (int k = 0; k < 6; ++k) {  // dF = D F with symmetric D, at fixed J^/J
        Eigen::Matrix3d D = Eigen::Matrix3d::Zero();
        D(row[k], col[k]) += 0.5, D(col[k], row[k]) += 0.5;
        Eigen::Matrix<double, 6, 1> tau[2];
        for (int side : {0, 1}) {
          Call moved = c;
          moved.F = (Eigen::Matrix3d::Identity() + (side ? h : -h) * D) * c.F;
          moved.J_hat = ratio * moved.F.determinant();
          moved.run();
          tau[side] = moved.F.determinant() * moved.stress;
        }
        by_difference.col(k) = (tau[1] - tau[0]) / (2 * h * J);
      }
      EXPECT_LE((at.ddsdde - by_difference).norm(), 1e-8 * stiffness) << c1;
    }
  }
}

TEST(MixedElements, RefuseAVolumeThatCannotBe) {
  for (double J_hat :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Call c;
    c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    c.J_hat = J_hat;
    c.run();
    EXPECT_EQ(c.pnewdt, 0.25);
    EXPECT_TRUE(c.stress.array().isNaN().all());
    EXPECT_TRUE(std::isnan(c.K) && std::isnan(c.dK_dJ));
    EXPECT_EQ(c.statev, std::vector<double>(8, 0.0));
  }
}

/// A cantilever in plane strain, bent by its free end, of 4-node quadrilaterals with all four points:
/// ordinary (CPE4), or mixed as CPE4H is, with one volume ratio and one pressure in an element.
struct Cantilever {
  int nx, ny;
  bool mixed;
  std::vector<double> props;
  double length = 4, height = 1;

  int node(int i, int j) const { return i * (ny + 1) + j; }
  int n_dof() const { return 2 * (nx + 1) * (ny + 1); }

  /// Internal forces and, by the UMAT's DDSDDE and K, the stiffness, of one element at its displacements.
  void element(const Eigen::Matrix<double, 4, 2>& X, const Eigen::Matrix<double, 8, 1>& u,
               Eigen::Matrix<double, 8, 1>& f, Eigen::Matrix<double, 8, 8>& K) const {
    const double a = 1 / std::sqrt(3.0), xi[4] = {-1, 1, 1, -1}, eta[4] = {-1, -1, 1, 1};
    struct Point {
      Eigen::Matrix<double, 4, 2> dN;
      Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
      double w;
    } q[4];
    double V = 0, v = 0;
    for (int k = 0; k < 4; ++k) {
      Eigen::Matrix<double, 4, 2> dN;
      for (int m = 0; m < 4; ++m) {
        dN(m, 0) = xi[m] * (1 + eta[m] * a * eta[k]) / 4;
        dN(m, 1) = eta[m] * (1 + xi[m] * a * xi[k]) / 4;
      }
      const Eigen::Matrix2d jacobian = X.transpose() * dN;
      dN = (dN * jacobian.inverse()).eval();
      const Eigen::Matrix<double, 2, 4> U = Eigen::Map<const Eigen::Matrix<double, 2, 4>>(u.data());
      q[k].F.topLeftCorner<2, 2>() += U * dN;
      q[k].dN = dN * q[k].F.topLeftCorner<2, 2>().inverse();
      q[k].w = jacobian.determinant();
      V += q[k].w, v += q[k].w * q[k].F.determinant();
    }
    f.setZero(), K.setZero();
    const double J_hat = v / V;
    double p = 0, bulk = 0;  // means over the element of the mean stress and of its derivative by J^
    Eigen::Matrix<double, 8, 1> dv = Eigen::Matrix<double, 8, 1>::Zero();
    Call c[4];
    for (int k = 0; k < 4; ++k) {
      c[k].ntens = 4;
      c[k].props = props;
      c[k].props[17] = mixed ? 1 : 0;
      c[k].statev.assign(9, 0.0);
      c[k].F = q[k].F;
      c[k].J_hat = J_hat;
      c[k].run();
      const double J = q[k].F.determinant();
      p += q[k].w / V * c[k].stress.head<3>().mean();
      bulk += q[k].w / V * c[k].K / J;
      for (int m = 0; m < 8; ++m) dv[m] += q[k].w * J * q[k].dN(m / 2, m % 2);
    }
    for (int k = 0; k < 4; ++k) {
      const double J = q[k].F.determinant(), w = q[k].w * J;
      const Eigen::Matrix4d D = Eigen::Map<const Eigen::Matrix4d>(c[k].ddsdde.data());
      Eigen::Vector4d s = c[k].stress.head<4>(), one(1, 1, 1, 0);
      Eigen::Matrix<double, 4, 8> B = Eigen::Matrix<double, 4, 8>::Zero();
      for (int m = 0; m < 4; ++m) {
        B(0, 2 * m) = B(3, 2 * m + 1) = q[k].dN(m, 0);
        B(1, 2 * m + 1) = B(3, 2 * m) = q[k].dN(m, 1);
      }
      Eigen::Matrix4d material = D;
      if (mixed) {
        // The deviator as the UMAT gives it, the mean stress of the element. At a fixed J^ strains are those
        // of shape alone, and a change of J^ is one of volume everywhere.
        const double mean = s.head<3>().mean();
        s.head<3>().array() += p - mean;
        const Eigen::RowVector4d mean_row = D.topRows<3>().colwise().mean();
        const Eigen::Matrix4d shape = Eigen::Matrix4d::Identity() - one * one.transpose() / 3;
        const Eigen::Matrix4d deviator = D - one * mean_row;
        material = deviator * shape + p * one * one.transpose();
        K += B.transpose() * deviator * one / 3 * w * dv.transpose() / v;
        K += dv * (q[k].w / V) * (mean_row * shape * B);
      }
      f += B.transpose() * s * w;
      K += B.transpose() * material * B * w;
      // The terms of the Jaumann rate and of the geometry: sigma D + D sigma apart, sigma l^T in.
      Eigen::Matrix2d sigma;
      sigma << s[0], s[3], s[3], s[1];
      for (int m = 0; m < 8; ++m) {
        for (int n = 0; n < 8; ++n) {
          Eigen::Matrix2d gm = Eigen::Matrix2d::Zero(), gn = gm;
          gm.row(m % 2) = q[k].dN.row(m / 2);
          gn.row(n % 2) = q[k].dN.row(n / 2);
          const Eigen::Matrix2d dm = (gm + gm.transpose()) / 2, dn = (gn + gn.transpose()) / 2;
          K(m, n) += w * ((gm * sigma * gn.transpose()).trace() - 2 * (dm * sigma * dn).trace());
        }
      }
    }
    if (mixed) K += bulk / V * dv * dv.transpose();
  }

  /// Deflection of the free end's middle under a dead load, by Newton's method; the steps it took.
  double deflection(double load, int& steps) const {
    constexpr int increments = 10;
    Eigen::VectorXd u = Eigen::VectorXd::Zero(n_dof()), f;
    Eigen::MatrixXd K;
    steps = 0;
    for (int increment = 1; increment <= increments; ++increment) {
      for (int iteration = 0; iteration < 25; ++iteration, ++steps) {
        f = Eigen::VectorXd::Zero(n_dof()), K = Eigen::MatrixXd::Zero(n_dof(), n_dof());
        for (int i = 0; i < nx; ++i) {
          for (int j = 0; j < ny; ++j) {
            const int nodes[4] = {node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)};
            Eigen::Matrix<double, 4, 2> X;
            X << i, j, i + 1, j, i + 1, j + 1, i, j + 1;
            X.col(0) *= length / nx, X.col(1) *= height / ny;
            Eigen::Matrix<double, 8, 1> ue, fe;
            Eigen::Matrix<double, 8, 8> Ke;
            for (int m = 0; m < 8; ++m) ue[m] = u[2 * nodes[m / 2] + m % 2];
            element(X, ue, fe, Ke);
            for (int m = 0; m < 8; ++m) {
              f[2 * nodes[m / 2] + m % 2] += fe[m];
              for (int n = 0; n < 8; ++n) K(2 * nodes[m / 2] + m % 2, 2 * nodes[n / 2] + n % 2) += Ke(m, n);
            }
          }
        }
        for (int j = 0; j <= ny; ++j) {
          const double share = (j == 0 || j == ny ? 0.5 : 1.0) / ny;
          f[2 * node(nx, j) + 1] -= load * increment / increments * share;
        }
        const int fixed = 2 * (ny + 1), free = n_dof() - fixed;
        if (f.tail(free).norm() < 1e-7 * load) break;
        u.tail(free) -= K.bottomRightCorner(free, free).partialPivLu().solve(f.tail(free));
      }
    }
    return u[2 * node(nx, ny / 2) + 1];
  }
};

// The host's stiffness, put together from DDSDDE and K, is the derivative of its forces.
TEST(MixedElements, StiffnessOfAnElement) {
  const Cantilever one{1, 1, true, {4e4, 4, 0.5, 2, 1.1, 1.01, 1, 0.5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};
  Eigen::Matrix<double, 4, 2> X;
  X << 0, 0, 1, 0, 1, 1, 0, 1;
  Eigen::Matrix<double, 8, 1> u, f, up, down;
  u << 0, 0, 0.2, 0.1, 0.3, 0.1, -0.1, 0.2;
  Eigen::Matrix<double, 8, 8> K, by_difference, ignored;
  one.element(X, u, f, K);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Matrix<double, 8, 1> step = Eigen::Matrix<double, 8, 1>::Unit(i) * 1e-5;
    one.element(X, u + step, up, ignored);
    one.element(X, u - step, down, ignored);
    by_difference.col(i) = (up - down) / 2e-5;
  }
  EXPECT_LE((K - by_difference).norm(), 1e-8 * K.norm());
}

// Nearly incompressible (c1 = 1000 c2) and growing: ordinary elements lock, mixed ones do
// not, and their Newton's method, with K and DDSDDE as the UMAT gives them, converges in a few steps.
TEST(MixedElements, DoNotLock) {
  const std::vector<double> props = {4e3, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const double load = 0.02;
  int steps[3];
  const double fine = Cantilever{16, 8, true, props}.deflection(load, steps[0]);
  const double coarse = Cantilever{8, 4, true, props}.deflection(load, steps[1]);
  const double locked = Cantilever{8, 4, false, props}.deflection(load, steps[2]);
  printf("deflection: mixed 16 x 8 %.6f, 8 x 4 %.6f, ordinary 8 x 4 %.6f\n", fine, coarse, locked);
  EXPECT_GT(fine, 0.2);
  EXPECT_NEAR(coarse / fine, 1, 0.06);
  EXPECT_LT(locked / fine, 0.2);
  EXPECT_LE(steps[0], 45);  // in ten increments
  EXPECT_LE(steps[1], 45);
}

// Where compressible, mixed and ordinary elements tend to the same.
TEST(MixedElements, AgreeWithOrdinaryOnesWhereTheseDoNotLock) {
  const std::vector<double> props = {4, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  int steps;
  const double mixed = Cantilever{16, 8, true, props}.deflection(0.04, steps);
  const double plain = Cantilever{16, 8, false, props}.deflection(0.04, steps);
  EXPECT_NEAR(mixed / plain, 1, 0.01);
}

}  // namespace
