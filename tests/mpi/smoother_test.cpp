// The smoother of examples/dealii by itself: its polynomial, its blocks, and what single precision does to
// them.
#include "../../examples/dealii/smoother.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace {

/// A matrix of blocks of 3x3 with gaps, unsymmetric, rows of very different size; and as CSR, the columns of
/// a row in any order.
struct Sample {
  static constexpr int nodes = 12, n = 3 * nodes;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  std::vector<int> start = {0};
  std::vector<unsigned> columns;
  std::vector<double> values;

  explicit Sample(double size) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> d(-1, 1);
    for (int a = 0; a < nodes; ++a) {
      std::vector<int> order;
      for (int b = 0; b < nodes; ++b) {
        if (b != a && (a + 2 * b) % 3 != 0) continue;
        for (int j = 0; j < 3; ++j) order.push_back(3 * b + j);
      }
      std::shuffle(order.begin(), order.end(), random);
      for (int row = 3 * a; row < 3 * a + 3; ++row) {
        for (const int column : order) {
          const double x = d(random) * 0.1 + (row == column ? 2 : 0);
          A(row, column) = std::pow(size, a % 3) * x;
          columns.push_back(static_cast<unsigned>(column));
          values.push_back(A(row, column));
        }
        start.push_back(static_cast<int>(columns.size()));
      }
    }
  }
};

muscle::Smoother smoother_of(const Sample& s) {
  muscle::Smoother smoother(Sample::n, s.start.data(), s.columns, [](const double* x) { return x; });
  smoother.copy(s.values.data());
  return smoother;
}

TEST(Smoother, TakesTheChebyshevPolynomialFromTheError) {
  for (const double size : {1.0, 1e30, 1e-30}) {
    const Sample s(size);
    const double largest = 1.7;
    const Eigen::MatrixXd B = s.A.diagonal().cwiseInverse().asDiagonal() * s.A;
    const Eigen::VectorXd solution = Eigen::VectorXd::LinSpaced(Sample::n, -1, 2), b = s.A * solution;
    muscle::Smoother smoother = smoother_of(s);
    for (const int sweeps : {1, 2, 3, 5}) {
      for (const bool is_zero : {false, true}) {
        Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(Sample::n, 1, -3);
        const Eigen::VectorXd error = is_zero ? -solution : Eigen::VectorXd(x - solution);
        smoother.apply(largest, sweeps, is_zero, b.data(), x.data());
        // T_k((m - B) / h) / T_k(m / h) of the error, by the recurrence of Chebyshev's polynomials
        const double upper = 1.1 * largest, lower = largest / 20, h = (upper - lower) / 2, m = h + lower;
        double t0 = 1, t1 = m / h;
        Eigen::VectorXd p0 = error, p1 = (m * error - B * error) / h;
        for (int k = 1; k < sweeps; ++k) {
          const double t2 = 2 * m / h * t1 - t0;
          const Eigen::VectorXd p2 = 2 * (m * p1 - B * p1) / h - p0;
          t0 = t1, t1 = t2, p0 = p1, p1 = p2;
        }
        EXPECT_LT((x - solution - p1 / t1).norm(), 3e-7 * error.norm()) << size << " " << sweeps << is_zero;
      }
    }
  }
}

TEST(Smoother, RefusesAPartOfANode) {
  Sample s(1);
  EXPECT_NO_THROW(smoother_of(s));
  for (unsigned& c : s.columns) {
    if (c == 4) c = 7;
  }
  EXPECT_THROW(smoother_of(s), std::logic_error);
}

}  // namespace
