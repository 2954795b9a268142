// What projects and system headers define before our headers are read: names as macros, and Eigen's defaults.
// The results are those of the kernel, which takes plain arrays.
#define EIGEN_DEFAULT_TO_ROW_MAJOR
#define EIGEN_DEFAULT_DENSE_INDEX_TYPE int
#define EIGEN_NO_AUTOMATIC_RESIZING
#define EIGEN_INITIALIZE_MATRICES_BY_NAN
#define EIGEN_MAX_ALIGN_BYTES 0
#include <gtest/gtest.h>
// The standard's and Eigen's own headers come first, as they cannot be read after some of these macros
// either.
#include <Eigen/Dense>
#include "macros.hpp"

#include <myogrowth/many/batch.hpp>
#include <myogrowth/material.hpp>
#include <myogrowth/more/growth_law.hpp>
#include <myogrowth/more/left_stretch.hpp>
#include <myogrowth/more/mixed_volume.hpp>
#include <myogrowth/more/stress_states.hpp>

#undef F
#undef min
#undef max
#undef I

namespace {

using namespace myogrowth;

constexpr double numbers[9] = {1.2, 0.03, -0.02, 0.1, 0.95, 0.04, 0.07, -0.05, 1.02};

struct Isotropic {  // as in more/growth_law.hpp
  double limit() const { return 1.5; }
  template <class T>
  Mat3<T> growth_tensor(const T& g, const Vec3<T>&) const {
    return pow(g, 1. / 3) * Mat3<T>::Identity();
  }
  template <class T>
  T rate(const T& g, const Mat3<T>& Fe, const Vec3<T>&) const {
    return (1.5 - g) * T(Fe(0, 0) * Fe(0, 0));
  }
};

}  // namespace

TEST(Macros, ResultsAreThoseOfTheKernel) {
  const FibreGrowth<> muscle;
  const double n0[3] = {1, 0.2, 0};
  PointUpdate<double> u;
  ASSERT_EQ(update_point(muscle, numbers, n0, 1.0, 0.1, u), UpdateStatus::ok);
  ASSERT_GT(u.G, 1);

  Eigen::Matrix3d deformation_gradient;  // row by row
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) deformation_gradient(i, j) = numbers[i + 3 * j];
  }
  State<> state;
  state.n0 = {1, 0.2, 0};
  const auto step = update(muscle, deformation_gradient, state, 0.1);
  ASSERT_TRUE(step.ok());
  EXPECT_EQ(step.state.G, u.G);
  double P[9], c[36], A[81], D[36];
  first_piola_from_kirchhoff(numbers, u.tau, P);
  spatial_modulus(u, c);
  dP_dF_from_jaumann(numbers, u.tau, c, A);
  dS_dE_from_jaumann(numbers, u.tau, c, D);
  const Eigen::Matrix3d tau = step.kirchhoff(), first = step.first_piola();
  const Eigen::Matrix<double, 9, 9> moduli = step.dP_dF();
  const Eigen::Matrix<double, 6, 6> jaumann = step.jaumann_modulus(), second = step.dS_dE();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_EQ(tau(i, j), u.tau[symmetric_index(i, j)]);
      EXPECT_EQ(first(i, j), P[i + 3 * j]);
    }
  }
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 9; ++j) EXPECT_EQ(moduli(i, j), A[i + 9 * j]);
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      EXPECT_EQ(jaumann(i, j), c[i + 6 * j]);
      EXPECT_EQ(second(i, j), D[i + 6 * j]);
    }
  }
}

TEST(Macros, TheReadableDefinitionsAgree) {
  Mat3<double> deformation_gradient;
  std::copy_n(numbers, 9, deformation_gradient.data());
  const Vec3<double> n0 = Vec3<double>(1, 0.2, 0) / std::sqrt(1.04);
  State<> state;
  state.n0 = n0;
  const auto step = update(FibreGrowth<>(), deformation_gradient, state, 0.1);
  const Mat3<double> S = second_piola(NeoHookean<>(), deformation_gradient, n0, step.state.G);
  const Mat3<double> be = left_cauchy_green(elastic_part(deformation_gradient, n0, step.state.G));
  const auto held = update(FibreGrowth<>(), deformation_gradient, step.state, 0);  // does not grow
  EXPECT_LE((S - step.second_piola()).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LE((NeoHookean<>().spatial_modulus(be) - held.jaumann_modulus()).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_TRUE(update(Isotropic(), NeoHookean<>(), deformation_gradient, n0, 1, 0.1).ok());
}
