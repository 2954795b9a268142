// The element of examples/dealii by itself: its stiffness against differences of its residual, and its
// residual against the library's update at every point.
#include "../../examples/dealii/element.hpp"
#include "../support/larger.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <myogrowth/material.hpp>
#include <random>
#include <vector>

namespace {

using namespace muscle;

/// Cells of one shape: distorted, deformed at random, with oblique fibres, some of their points growing.
struct Sample {
  Shape shape;
  int n, dofs, points;
  std::vector<double> X, u, n0, G_n, lambda_n;

  Sample(Shape shape_, int cells)
      : shape(shape_), n(cells), dofs(3 * n_nodes(shape_)), points(n_points(shape_)) {
    static constexpr double hex[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0,
                                       0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    static constexpr double wedge[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1};
    static constexpr double tet[30] = {0,   0,   0, 1, 0,   0, 0, 1, 0,   0,   0, 1,   0.5, 0,   0,
                                       0.5, 0.5, 0, 0, 0.5, 0, 0, 0, 0.5, 0.5, 0, 0.5, 0,   0.5, 0.5};
    std::mt19937 random(7);
    std::uniform_real_distribution<double> d(-1, 1);
    for (int c = 0; c < n; ++c) {
      for (int k = 0; k < dofs; ++k) {
        const double x = shape == Shape::hex ? hex[k] : shape == Shape::wedge ? wedge[k] : tet[k];
        X.push_back(2 * x + (shape == Shape::tet10 ? 0.05 : 0.2) * d(random));
        u.push_back(0.1 * x * (k % 3 + 1) + (shape == Shape::tet10 ? 0.03 : 0.08) * d(random));
      }
      for (int q = 0; q < points; ++q) {
        for (int i = 0; i < 3; ++i) n0.push_back(d(random));
        G_n.push_back(1 + 0.04 * (d(random) + 1));
        lambda_n.push_back(1.05 + 0.05 * d(random));
      }
    }
  }

  Cells cells() const { return {shape, n, X.data(), u.data(), n0.data(), G_n.data(), lambda_n.data()}; }

  std::vector<double> residual(Elements& elements, double dt) const {
    std::vector<double> R(static_cast<std::size_t>(n * dofs));
    EXPECT_LT(elements.evaluate(cells(), dt, {R.data(), nullptr, nullptr, nullptr}).point, 0);
    return R;
  }
};

/// An elastic law half active, with its defaults but for an optimum at rest, so that its fibres carry at most
/// points, and a law 3 that does not overflow where the volume changes by a half.
myogrowth::abi::LawChoice law_choice(int number) {
  namespace abi = myogrowth::abi;
  abi::LawChoice choice{};
  choice.law = static_cast<abi::Law>(number);
  if (number == 0) return choice;
  abi::Text text;
  EXPECT_FALSE(abi::find_parameter_fault<double>(nullptr, 0, 0, choice, text)) << text;
  choice.activation = 0.5;
  if (number == 1) choice.p[5] = 1;
  if (number == 2) choice.p[4] = 1;
  if (number == 3) choice.p[3] = 2;
  return choice;
}

/// An elastic law, and whether it goes by the full modulus; all but eq. 3 do.
struct Elastic {
  int law;
  bool full;
};
constexpr Elastic all_laws[] = {{0, false}, {0, true}, {1, true}, {2, true}, {3, true}};

class Tangents : public testing::TestWithParam<
                     std::tuple<Shape, Volume, myogrowth::EnergyPer, myogrowth::TimeIntegration, Elastic>> {
 protected:
  Shape shape = std::get<0>(GetParam());
  Volume volume = std::get<1>(GetParam());
  Elastic elastic = std::get<4>(GetParam());
  myogrowth::FibreGrowth<> material;
  Tangents() {
    material.energy = std::get<2>(GetParam());
    material.integration = std::get<3>(GetParam());
  }
};

TEST_P(Tangents, AreTheDerivativesOfTheResidual) {
  Sample s(shape, 3);
  Elements elements(material, volume, law_choice(elastic.law), elastic.full);
  const double dt = 0.3, h = 1e-5;
  const auto size = static_cast<std::size_t>(s.n * s.dofs);
  std::vector<double> R(size), K(size * static_cast<std::size_t>(s.dofs));
  ASSERT_LT(elements.evaluate(s.cells(), dt, {R.data(), K.data(), nullptr, nullptr}).point, 0);
  // With other laws the points' stress without a tangent may differ by rounding.
  const auto without = s.residual(elements, dt);
  double force = 0, difference = 0, largest = 0, worst = 0, unsymmetric = 0;
  for (std::size_t k = 0; k < size; ++k) {
    force = std::max(force, std::abs(R[k]));
    difference = larger(difference, std::abs(R[k] - without[k]));
  }
  EXPECT_LE(difference, elastic.full ? 1e-14 * force : 0);
  for (int c = 0; c < s.n; ++c) {
    for (int j = 0; j < s.dofs; ++j) {
      double& x = s.u[static_cast<std::size_t>(c * s.dofs + j)];
      const double at = x;
      x = at + h;
      const auto plus = s.residual(elements, dt);
      x = at - h;
      const auto minus = s.residual(elements, dt);
      x = at;
      for (int i = 0; i < s.dofs; ++i) {
        const auto row = static_cast<std::size_t>(c * s.dofs + i);
        const double k = K[row * static_cast<std::size_t>(s.dofs) + static_cast<std::size_t>(j)];
        const double transposed = K[static_cast<std::size_t>((c * s.dofs + j) * s.dofs + i)];
        largest = std::max(largest, std::abs(k));
        worst = larger(worst, std::abs(k - (plus[row] - minus[row]) / (2 * h)));
        unsymmetric = std::max(unsymmetric, std::abs(k - transposed));
      }
    }
  }
  EXPECT_LT(worst, 3e-8 * largest);
  EXPECT_GT(unsymmetric, 1e-3 * largest);  // it grows: the test sees the growth term
}

INSTANTIATE_TEST_SUITE_P(Elements, Tangents,
                         testing::Combine(testing::ValuesIn(all_shapes),
                                          testing::Values(Volume::pointwise, Volume::mean_dilatation),
                                          testing::Values(myogrowth::EnergyPer::reference_volume,
                                                          myogrowth::EnergyPer::grown_volume),
                                          testing::Values(myogrowth::TimeIntegration::backward_euler,
                                                          myogrowth::TimeIntegration::midpoint_flow),
                                          testing::ValuesIn(all_laws)));

// Eq. 3 by its seven numbers and by the 6 x 6 modulus: two derivations of one element.
TEST(Element, GivesTheSameByEitherTangent) {
  for (Shape shape : all_shapes) {
    for (Volume volume : {Volume::pointwise, Volume::mean_dilatation}) {
      for (auto energy : {myogrowth::EnergyPer::reference_volume, myogrowth::EnergyPer::grown_volume}) {
        const Sample s(shape, 20);
        myogrowth::FibreGrowth<> material;
        material.energy = energy;
        material.c1 = 400;
        const auto size = static_cast<std::size_t>(s.n * s.dofs),
                   all = size * static_cast<std::size_t>(s.dofs);
        std::vector<double> R[2], K[2];
        for (bool full : {false, true}) {
          R[full].resize(size);
          K[full].resize(all);
          Elements elements(material, volume, {}, full);
          ASSERT_LT(
              elements.evaluate(s.cells(), 0.3, {R[full].data(), K[full].data(), nullptr, nullptr}).point, 0);
        }
        for (const auto* both : {R, K}) {
          double largest = 0, worst = 0;
          for (std::size_t k = 0; k < both[0].size(); ++k) {
            largest = std::max(largest, std::abs(both[0][k]));
            worst = larger(worst, std::abs(both[0][k] - both[1][k]));
          }
          EXPECT_LT(worst, 1e-13 * largest);
        }
      }
    }
  }
}

/// What the library gives at a point: P, G and lambda_e.
struct AtPoint {
  Eigen::Matrix3d P;
  double G, lambda_e;
};
AtPoint at_point(int law, const Eigen::Matrix3d& F, const myogrowth::State<>& state, double dt) {
  const auto take = [](const auto& step) {
    EXPECT_TRUE(step.ok());
    return AtPoint{step.first_piola(), step.state.G, step.point.lambda_e};
  };
  const myogrowth::FibreGrowth<> material;
  if (law == 0) return take(myogrowth::update(material, F, state, dt));
  AtPoint result;
  namespace abi = myogrowth::abi;
  abi::with_other_law(material, law_choice(law), [&](auto&, const auto& muscle, double activation) {
    result = take(myogrowth::update(muscle, F, state, dt, activation));
    return myogrowth::UpdateStatus::ok;
  });
  return result;
}

// A homogeneous deformation: the points' forces are P:grad N, and J^ is det F.
TEST(Element, GivesTheLawsStressAndState) {
  for (const int law : {0, 1, 2, 3})
    for (Shape shape : all_shapes) {
      for (Volume volume : {Volume::pointwise, Volume::mean_dilatation}) {
        Sample s(shape, 40);
        Eigen::Matrix3d F;
        F << 1.09, 0.03, -0.02, 0.01, 0.97, 0.04, 0.02, -0.03, 0.98;
        for (int k = 0; k < s.n * s.dofs / 3; ++k) {
          const Eigen::Vector3d X = Eigen::Map<const Eigen::Vector3d>(&s.X[static_cast<std::size_t>(3 * k)]);
          Eigen::Map<Eigen::Vector3d>(&s.u[static_cast<std::size_t>(3 * k)]) = F * X - X;
        }
        for (std::size_t k = 0; k < s.n0.size(); ++k) s.n0[k] = k % 3 == 0 ? 0.8 : k % 3 == 1 ? 0.0 : 0.6;
        for (double& G : s.G_n) G = 1.01;
        const myogrowth::FibreGrowth<> material;
        Elements elements(material, volume, law_choice(law));
        const auto points = static_cast<std::size_t>(s.n * s.points);
        std::vector<double> R(static_cast<std::size_t>(s.n * s.dofs)), G(points), scalars(5 * points);
        ASSERT_LT(elements.evaluate(s.cells(), 0.2, {R.data(), nullptr, scalars.data(), G.data()}).point, 0);
        myogrowth::State<> state;
        state.G = 1.01;
        state.n0 = {0.8, 0, 0.6};
        const AtPoint step = at_point(law, F, state, 0.2);
        double virtual_work = 0, expected = 0;  // of the displacement (X_1, X_3, X_2)
        Eigen::Matrix3d H;
        H << 1, 0, 0, 0, 0, 1, 0, 1, 0;
        for (int k = 0; k < s.n * s.dofs / 3; ++k) {
          virtual_work += (H * Eigen::Map<const Eigen::Vector3d>(&s.X[static_cast<std::size_t>(3 * k)]))
                              .dot(Eigen::Map<const Eigen::Vector3d>(&R[static_cast<std::size_t>(3 * k)]));
        }
        for (int c = 0; c < s.n; ++c) {
          double places[3 * most_points], volumes[most_points];
          integration_points(shape, &s.X[static_cast<std::size_t>(c * s.dofs)], places, volumes);
          for (int q = 0; q < s.points; ++q) expected += volumes[q] * step.P.cwiseProduct(H).sum();
        }
        EXPECT_NEAR(virtual_work, expected, 1e-12 * std::abs(expected));
        for (std::size_t k = 0; k < points; ++k) {
          EXPECT_NEAR(G[k], step.G, 1e-14);
          EXPECT_NEAR(scalars[k], step.lambda_e, 1e-14);
        }
      }
    }
}

// The first point that is turned inside out is named, in whatever block it lies.
TEST(Element, NamesThePointThatFails) {
  for (const int law : {0, 1, 2, 3})
    for (Volume volume : {Volume::pointwise, Volume::mean_dilatation}) {
      Sample s(Shape::hex, 20);
      const int cell = 13;
      for (int i = 0; i < 3; ++i)
        s.u[static_cast<std::size_t>(cell * s.dofs + 18 + i)] -= 3;  // corner 7 of 8
      std::vector<double> R(static_cast<std::size_t>(s.n * s.dofs));
      Elements elements(myogrowth::FibreGrowth<>(), volume, law_choice(law));
      const Failure failure = elements.evaluate(s.cells(), 0.1, {R.data(), nullptr, nullptr, nullptr});
      EXPECT_EQ(failure.cell, cell);
      EXPECT_GE(failure.point, 0);
      EXPECT_LT(Eigen::Map<const Eigen::Matrix3d>(failure.F).determinant(), 0);
    }
}

}  // namespace
