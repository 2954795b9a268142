// Plane stress and uniaxial stress: the free stretch, and the condensed tangents.
#include <gtest/gtest.h>
#include <myogrowth/elastic/ehret.hpp>
#include <myogrowth/elastic/fibre_growth_of.hpp>
#include <myogrowth/material.hpp>
#include <myogrowth/more/stress_states.hpp>

#include "../support/dual.hpp"
#include "../support/larger.hpp"
#include "../support/reference.hpp"

using namespace myogrowth;
using Complex = std::complex<double>;
using samples::Kind;

namespace {

enum class Fibre { in_plane, normal, oblique };

struct Membrane {
  FibreGrowth<> muscle;
  Eigen::Matrix2d F;
  State<> state;
  double dt;
};

Membrane membrane(samples::Random& r, Fibre fibre, Kind kind) {
  Membrane m;
  m.muscle.c1 = r.uniform(0, 40);
  m.muscle.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
  const double gammas[] = {0.5, 1, 2, 2.5, 4};
  m.muscle.growth = {r.uniform(0.1, 3), r.pick(gammas), 1 + r.log_uniform(0.02, 2), 1};
  do {
    const double angle = r.uniform(-3, 3), c = std::cos(angle), s = std::sin(angle);
    m.F << 1 + r.uniform(-0.4, 0.4), r.uniform(-0.4, 0.4), r.uniform(-0.4, 0.4), 1 + r.uniform(-0.4, 0.4);
    m.F = (Eigen::Matrix2d() << c, -s, s, c).finished() * m.F;
  } while (m.F.determinant() < 0.1);
  m.state.n0 = samples::direction(r);
  if (fibre == Fibre::in_plane) m.state.n0[2] = 0;
  if (fibre == Fibre::normal) m.state.n0 = {0, 0, -2};
  m.state.G = 1 + (m.muscle.growth.G_max - 1) * r.uniform(0, 0.9);
  m.dt = m.muscle.growth.tau * r.log_uniform(1e-4, 1e3);
  PointUpdate<double> u;
  double thickness = 0, c[9];
  EXPECT_EQ(plane_stress(m.muscle, m.F.data(), m.state.n0.data(), m.state.G, 1.0, 0.0, thickness, u, c),
            UpdateStatus::ok);
  m.muscle.growth.lambda_crit =
      u.lambda_e * (kind == Kind::growing ? r.uniform(0.6, 0.97) : r.uniform(1.05, 1.5));
  return m;
}

class PlaneStress : public testing::TestWithParam<std::tuple<Fibre, Kind>> {};

TEST_P(PlaneStress, FreesTheThicknessAndCondensesTheTangent) {
  const auto [fibre, kind] = GetParam();
  samples::Random r(51);
  double worst_stress = 0, worst_tangent = 0, largest_unsymmetry = 0;
  for (int i = 0; i < 300; ++i) {
    const Membrane m = membrane(r, fibre, kind);
    PointUpdate<double> u;
    double thickness = 0;
    Eigen::Matrix3d c, by_complex_step;
    ASSERT_EQ(
        plane_stress(m.muscle, m.F.data(), m.state.n0.data(), m.state.G, 1.0, m.dt, thickness, u, c.data()),
        UpdateStatus::ok);
    EXPECT_EQ(u.G > m.state.G, kind == Kind::growing);
    worst_stress = larger(worst_stress, std::abs(u.tau[2]) / (m.muscle.c1 + m.muscle.c2));

    // The result is the solid's update at that thickness, to the last bit.
    Eigen::Matrix3d F = Eigen::Matrix3d::Zero();
    F.topLeftCorner<2, 2>() = m.F;
    F(2, 2) = thickness;
    EXPECT_EQ(update(m.muscle, F, m.state, m.dt).kirchhoff(),
              from_six(Vec6<double>(Eigen::Map<const Vec6<double>>(u.tau))));

    // The result does not depend on the start.
    for (double start : {1e-3, 0.5, 3.0, 1e3, -1.0}) {
      PointUpdate<double> v;
      double again = start, c_again[9];
      EXPECT_EQ(
          plane_stress(m.muscle, m.F.data(), m.state.n0.data(), m.state.G, 1.0, m.dt, again, v, c_again),
          UpdateStatus::ok);
      EXPECT_NEAR(again / thickness, 1, 1e-13);
    }

    for (int col = 0; col < 3; ++col) {
      const double h = 1e-40;
      Eigen::Matrix2d D = Eigen::Matrix2d::Zero();
      if (col < 2) D(col, col) = 1;
      if (col == 2) D(0, 1) = D(1, 0) = 0.5;
      const Eigen::Matrix2cd step = m.F.cast<Complex>() + Complex(0, h) * (D * m.F).cast<Complex>();
      const Vec3<Complex> n0 = m.state.n0.cast<Complex>();
      PointUpdate<Complex> v;
      Complex F33 = 0.8 * thickness, c_complex[9];
      ASSERT_EQ(plane_stress(m.muscle, step.data(), n0.data(), Complex(m.state.G), Complex(1), m.dt, F33, v,
                             c_complex),
                UpdateStatus::ok);
      by_complex_step.col(col) << v.tau[0].imag() / h, v.tau[1].imag() / h, v.tau[3].imag() / h;
    }
    worst_tangent = larger(worst_tangent, (c - by_complex_step).norm() / c.norm());
    largest_unsymmetry = larger(largest_unsymmetry, (c - c.transpose()).norm() / c.norm());
  }
  EXPECT_LE(worst_stress, 1e-12);
  EXPECT_LE(worst_tangent, 1e-11);
  if (kind == Kind::growing && fibre != Fibre::normal) {
    EXPECT_GT(largest_unsymmetry, 0.05);
  }
  std::printf("worst: stress across %.1e, tangent %.1e\n", worst_stress, worst_tangent);
}

INSTANTIATE_TEST_SUITE_P(Fibres, PlaneStress,
                         testing::Combine(testing::Values(Fibre::in_plane, Fibre::normal, Fibre::oblique),
                                          testing::Values(Kind::growing, Kind::below_threshold)));

// The condensed tangent and the thickness compared with the reference in 50 digits, by differences of its own
// plane stress.
TEST(PlaneStress, AgainstFiftyDigits) {
  samples::Random r(52);
  using reference::Real;
  for (int i = 0; i < 20; ++i) {
    const Membrane m = membrane(r, i % 2 == 0 ? Fibre::in_plane : Fibre::oblique, Kind::growing);
    const samples::Point p{m.muscle, Eigen::Matrix3d::Identity(), m.state, m.dt};
    const auto solve = [&](const Real(&F)[2][2]) {
      reference::Matrix F3 = reference::identity();
      for (int a = 0; a < 2; ++a) {
        for (int b = 0; b < 2; ++b) F3[a][b] = F[a][b];
      }
      const auto across = [&](const Real& F33) -> Real {
        F3[2][2] = F33;
        return reference::update(p, F3).tau[2][2];
      };
      boost::uintmax_t most = 300;
      const auto bracket = boost::math::tools::toms748_solve(
          across, Real(0.05), Real(20), across(Real(0.05)), across(Real(20)),
          [](const Real& a, const Real& b) { return b - a <= Real("1e-42"); }, most);
      F3[2][2] = (bracket.first + bracket.second) / 2;
      return std::pair<Real, reference::Matrix>(F3[2][2], reference::update(p, F3).tau);
    };
    PointUpdate<double> u;
    double thickness = 0;
    Eigen::Matrix3d c, expected;
    ASSERT_EQ(
        plane_stress(m.muscle, m.F.data(), m.state.n0.data(), m.state.G, 1.0, m.dt, thickness, u, c.data()),
        UpdateStatus::ok);
    const Real exact[2][2] = {{m.F(0, 0), m.F(0, 1)}, {m.F(1, 0), m.F(1, 1)}};
    EXPECT_LE(std::abs(static_cast<double>(solve(exact).first / thickness - 1)), 1e-12);
    for (int col = 0; col < 3; ++col) {
      const Real h("1e-14");
      const double D[2][2] = {{col == 0 ? 1.0 : 0.0, col == 2 ? 0.5 : 0.0},
                              {col == 2 ? 0.5 : 0.0, col == 1 ? 1.0 : 0.0}};
      Real plus[2][2], minus[2][2];
      for (int a = 0; a < 2; ++a) {
        for (int b = 0; b < 2; ++b) {
          const Real d = D[a][0] * exact[0][b] + D[a][1] * exact[1][b];
          plus[a][b] = exact[a][b] + h * d;
          minus[a][b] = exact[a][b] - h * d;
        }
      }
      const auto up = solve(plus).second, down = solve(minus).second;
      const int rows[3][2] = {{0, 0}, {1, 1}, {0, 1}};
      for (int row = 0; row < 3; ++row) {
        expected(row, col) = static_cast<double>(
            (up[rows[row][0]][rows[row][1]] - down[rows[row][0]][rows[row][1]]) / (2 * h));
      }
    }
    EXPECT_LE((c - expected).norm() / expected.norm(), 1e-11);
  }
}

TEST(PlaneStress, SaysWhatItCannotTake) {
  const FibreGrowth<> muscle;
  const double n0[3] = {1, 0, 0}, nan = std::numeric_limits<double>::quiet_NaN();
  PointUpdate<double> u;
  double thickness = 0.9, c[9];
  const double inverted[4] = {1, 0, 0, -1}, bad[4] = {1, nan, 0, 1};
  EXPECT_EQ(plane_stress(muscle, inverted, n0, 1.0, 1.0, 1.0, thickness, u, c), UpdateStatus::inverted);
  EXPECT_EQ(plane_stress(muscle, bad, n0, 1.0, 1.0, 1.0, thickness, u, c), UpdateStatus::not_finite);
  EXPECT_EQ(thickness, 0.9);
  EXPECT_TRUE(std::isnan(u.tau[0]));
}

// A stress that no stretch frees, and one that jumps over zero without end.
TEST(FreeStretch, SaysThatItHasNotConverged) {
  int evaluations = 0;
  double x = 1;
  const auto never_free = [&](double, double& stress, double& slope) {
    ++evaluations;
    stress = -1, slope = 1;
    return UpdateStatus::ok;
  };
  EXPECT_EQ(detail::free_stretch(x, never_free), UpdateStatus::not_converged);
  EXPECT_EQ(evaluations, 200);
  const auto jumps = [](double at, double& stress, double& slope) {
    stress = at < 2 ? -1 : 1, slope = 1e-3;
    return UpdateStatus::ok;
  };
  x = 1;
  EXPECT_EQ(detail::free_stretch(x, jumps), UpdateStatus::not_converged);
}

// Law 3's volume term is a power of up to millions: Newton's steps are tiny on one side of the root, and a
// few percent away there is no number any more.
TEST(StressStates, OfAStiffLawAreFoundFromAnywhere) {
  FibreGrowthOf<Ehret<>> m;
  const double n0[3] = {1, 0, 0}, G = 0.9;
  for (const double kappa : {1e2, 1e4, 1e6}) {
    m.elastic.kappa = kappa;
    for (const double stretch : {0.3, 0.5, 0.9, 0.98, 1.1, 1.5, 3.0}) {
      for (const double start : {0.0, 0.3, 1.1, 3.0}) {
        for (const double activation : {0.0, 1.0}) {
          for (const double dt : {0.0, 100.0}) {
            SCOPED_TRACE(testing::Message() << kappa << " " << stretch << " " << start << " " << activation);
            ElasticPointUpdate<double> u;
            double side = start, thickness = start, slope, c[9];
            const double F[4] = {stretch, 0, 0.1, 1 / std::sqrt(stretch)};
            ASSERT_EQ(uniaxial_stress(m, stretch, G, 1.0, dt, side, u, slope, activation), UpdateStatus::ok);
            EXPECT_LE(std::abs(u.tau[1]), 1e-9 * u.elastic[7]);
            ASSERT_EQ(plane_stress(m, F, n0, G, 1.0, dt, thickness, u, c, activation), UpdateStatus::ok);
            EXPECT_LE(std::abs(u.tau[2]), 1e-9 * u.elastic[14]);
          }
        }
      }
    }
  }
}

TEST(UniaxialStress, FreesTheSidesAndCondensesTheSlope) {
  samples::Random r(53);
  for (int i = 0; i < 300; ++i) {
    FibreGrowth<> m;
    m.c1 = r.uniform(0, 1000);
    m.growth.gamma = r.uniform(0.5, 4);
    m.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
    const double stretch = r.uniform(0.5, 2), G = r.uniform(1, 1.09), dt = r.log_uniform(1e-3, 1e2);
    PointUpdate<double> u;
    double side = 0, slope;
    ASSERT_EQ(uniaxial_stress(m, stretch, G, 1.0, dt, side, u, slope), UpdateStatus::ok);
    EXPECT_LE(std::abs(u.tau[1]) + std::abs(u.tau[2]), 2e-12 * (m.c1 + m.c2));
    const double h = 1e-40;
    PointUpdate<Complex> v;
    Complex side_c = 1, slope_c;
    ASSERT_EQ(
        uniaxial_stress(m, Complex(stretch, h * stretch), Complex(G), Complex(1), dt, side_c, v, slope_c),
        UpdateStatus::ok);
    EXPECT_NEAR(v.tau[0].imag() / h, slope, 1e-11 * (std::abs(slope) + m.c2));
    // the same strip as a membrane that is stretched to the same sides is stress-free across, too
    const double F[4] = {stretch, 0, 0, side}, n0[3] = {1, 0, 0};
    PointUpdate<double> w;
    double thickness = 0, c[9];
    ASSERT_EQ(plane_stress(m, F, n0, G, 1.0, dt, thickness, w, c), UpdateStatus::ok);
    EXPECT_NEAR(thickness, side, 1e-12);
  }
}

TEST(UniaxialStress, SaysWhatItCannotTake) {
  const FibreGrowth<> muscle;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (auto [stretch, G, expected] :
       {std::tuple(nan, 1.0, UpdateStatus::not_finite), std::tuple(-1.0, 1.0, UpdateStatus::inverted),
        std::tuple(1.1, 0.0, UpdateStatus::bad_state)}) {
    PointUpdate<double> u;
    double lateral = 0, slope = 0;
    EXPECT_EQ(uniaxial_stress(muscle, stretch, G, 1.0, 0.1, lateral, u, slope), expected);
    EXPECT_TRUE(std::isnan(slope) && std::isnan(u.tau[0]));
    EXPECT_EQ(lateral, 0);
  }
}

}  // namespace
