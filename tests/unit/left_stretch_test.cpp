#include <gtest/gtest.h>
#include <myogrowth/more/left_stretch.hpp>

#include <Eigen/Dense>

#include "../support/samples.hpp"

using namespace myogrowth;

namespace {

TEST(LeftStretch, OfARotatedKnownStretch) {
  samples::Random r(31);
  for (int i = 0; i < 2000; ++i) {
    // equal, nearly equal and very different stretches
    Eigen::Vector3d stretches(r.uniform(0.4, 2.5), r.uniform(0.4, 2.5), r.uniform(0.4, 2.5));
    if (i % 4 == 1) stretches[1] = stretches[0] * (1 + r.pick({0.0, 1e-15, 1e-9, 1e-5}));
    if (i % 4 == 2) stretches[2] = stretches[1] = stretches[0];
    if (i % 4 == 3) stretches[0] *= 100;
    const Eigen::Matrix3d axes = samples::rotation(r);
    const Eigen::Matrix3d expected = axes * stretches.asDiagonal() * axes.transpose();
    const Eigen::Matrix3d F = expected * samples::rotation(r);
    Eigen::Matrix3d V;
    ASSERT_TRUE(left_stretch(F.data(), V.data()));
    EXPECT_LE((V - expected).norm() / expected.norm(), 2e-15 * (i % 4 == 3 ? 10 : 1))
        << stretches.transpose();
    EXPECT_EQ(V, V.transpose());
  }
}

TEST(LeftStretch, OfASymmetricOneIsItself) {
  Eigen::Matrix3d F, V;
  F << 1.2, 0.1, 0, 0.1, 0.9, -0.05, 0, -0.05, 1.1;
  ASSERT_TRUE(left_stretch(F.data(), V.data()));
  EXPECT_LE((V - F).norm(), 1e-15);
}

TEST(LeftStretch, CarriesDerivatives) {
  using Complex = std::complex<double>;
  samples::Random r(32);
  const Eigen::Matrix3d F = samples::rotation(r) * samples::deformation(r, 0.3),
                        dF = samples::deformation(r, 0.5);
  const double h = 1e-30;
  const Eigen::Matrix3cd step = F.cast<Complex>() + Complex(0, h) * dF.cast<Complex>();
  Eigen::Matrix3cd V;
  ASSERT_TRUE(left_stretch(step.data(), V.data()));
  const Eigen::Matrix3d v = V.real(), dV = V.imag() / h;  // dV V + V dV = d(F F^T)
  EXPECT_LE((dV * v + v * dV - dF * F.transpose() - F * dF.transpose()).norm(), 1e-13);
}

TEST(LeftStretch, RefusesWhatHasNone) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity(), V = Eigen::Matrix3d::Constant(7);
  F(1, 1) = -1;
  EXPECT_FALSE(left_stretch(F.data(), V.data()));
  F(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(left_stretch(F.data(), V.data()));
  F.setZero();
  EXPECT_FALSE(left_stretch(F.data(), V.data()));
  EXPECT_EQ(V(0, 0), 7);
}

}  // namespace
