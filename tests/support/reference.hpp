// The law evaluated in 50 decimal digits straight from the paper's definitions: matrices, inverses, a
// bracketing root finder, and derivatives by central differences of the discrete update. It shares no formula
// with the library.
#ifndef MYOGROWTH_TESTS_REFERENCE_HPP
#define MYOGROWTH_TESTS_REFERENCE_HPP

#include <boost/math/tools/toms748_solve.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "samples.hpp"

namespace reference {

using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>, boost::multiprecision::et_off>;
template <class T>
struct Three {
  T x[3];
  T& operator[](int i) { return x[i]; }
  const T& operator[](int i) const { return x[i]; }
  T* begin() { return x; }
  T* end() { return x + 3; }
};
using Vector = Three<Real>;
using Matrix = Three<Vector>;  // rows

inline Matrix product(const Matrix& A, const Matrix& B) {
  Matrix C;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) C[i][j] = A[i][0] * B[0][j] + A[i][1] * B[1][j] + A[i][2] * B[2][j];
  }
  return C;
}
inline Matrix transpose(const Matrix& A) {
  Matrix B;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) B[i][j] = A[j][i];
  }
  return B;
}
inline Real determinant(const Matrix& A) {
  return A[0][0] * (A[1][1] * A[2][2] - A[1][2] * A[2][1]) -
         A[0][1] * (A[1][0] * A[2][2] - A[1][2] * A[2][0]) +
         A[0][2] * (A[1][0] * A[2][1] - A[1][1] * A[2][0]);
}
inline Matrix inverse(const Matrix& A) {
  Matrix B;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int p = (j + 1) % 3, q = (j + 2) % 3, r = (i + 1) % 3, s = (i + 2) % 3;
      B[i][j] = (A[p][r] * A[q][s] - A[p][s] * A[q][r]) / determinant(A);
    }
  }
  return B;
}
inline Matrix identity() {
  Matrix I;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) I[i][j] = i == j ? 1 : 0;
  }
  return I;
}
inline Matrix exact(const Eigen::Matrix3d& F) {
  Matrix A;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) A[i][j] = F(i, j);
  }
  return A;
}

/// Root of backward Euler's equation, only by bracketing.
inline Real grow(const myogrowth::GrowthRate<>& rate, const Real& G_n, const Real& lambda, const Real& dt) {
  const Real tau = rate.tau, gamma = rate.gamma, G_max = rate.G_max, crit = rate.lambda_crit;
  if (lambda <= crit * G_n || G_n >= G_max || dt <= 0) return G_n;
  const auto residual = [&](const Real& G) -> Real {
    const Real x = (G_max - G) / (G_max - 1);
    const Real k = x > 0 ? (gamma == 0 ? Real(1) : Real(pow(x, gamma))) : Real(gamma == 0 ? 1 : 0);
    return G - G_n - dt / tau * k * (lambda / G - crit);
  };
  const Real end = lambda / crit < G_max ? Real(lambda / crit) : G_max;
  if (residual(end) <= 0) return end;  // only for gamma = 0
  boost::uintmax_t most = 500;
  const auto bracket = boost::math::tools::toms748_solve(
      residual, G_n, end, residual(G_n), residual(end),
      [](const Real& a, const Real& b) { return b - a <= Real("1e-45"); }, most);
  return (bracket.first + bracket.second) / 2;
}

/// The same for removal.
inline Real shrink(const myogrowth::GrowthRate<>& growth, const myogrowth::RemovalRate<>& rate,
                   const Real& G_n, const Real& lambda, const Real& dt) {
  const Real tau = rate.tau_rev, gamma = rate.gamma_rev, G_max = growth.G_max, G_min = rate.G_min,
             crit = rate.lambda_crit_rev;
  if (lambda >= crit * G_n || G_n <= G_min || dt <= 0) return G_n;
  const auto residual = [&](const Real& G) -> Real {
    const Real x = (G - G_min) / (G_max - G_min);
    const Real k = x > 0 ? (gamma == 0 ? Real(1) : Real(pow(x, gamma))) : Real(gamma == 0 ? 1 : 0);
    return G - G_n + dt / tau * k * (crit - lambda / G);
  };
  const Real end = lambda / crit > G_min ? Real(lambda / crit) : G_min;
  if (residual(end) >= 0) return end;  // only for gamma = 0
  boost::uintmax_t most = 500;
  const auto bracket = boost::math::tools::toms748_solve(
      residual, end, G_n, residual(end), residual(G_n),
      [](const Real& a, const Real& b) { return b - a <= Real("1e-45"); }, most);
  return (bracket.first + bracket.second) / 2;
}

struct Result {
  Real G, lambda_e, J, psi;
  Matrix tau;
};

/// Kirchhoff stress and energy of an elastic law.
struct Elastic {
  Matrix tau;
  Real psi;
};

/// Eq. 3.
inline Elastic neo_hookean(const Real& c1, const Real& c2, const Matrix& Fe) {
  const Matrix be = product(Fe, transpose(Fe));
  const Real ln_Je = log(determinant(Fe));
  Elastic e;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) e.tau[i][j] = (i == j ? Real(c1 * ln_Je - c2) : Real(0)) + c2 * be[i][j];
  }
  e.psi = (c1 * ln_Je * ln_Je + c2 * (be[0][0] + be[1][1] + be[2][2] - 3 - 2 * ln_Je)) / 2;
  return e;
}

/// The update of a sample at F (which may differ from the sample's own, for differences) with an elastic law
/// of F_e and the unit vector n0.
template <class Law>
Result update(const samples::Point& p, const Matrix& F, const Law& elastic) {
  Vector n, f;
  Real length = 0, lambda = 0;
  for (int i = 0; i < 3; ++i) length += Real(p.state.n0[i]) * Real(p.state.n0[i]);
  for (int i = 0; i < 3; ++i) n[i] = Real(p.state.n0[i]) / sqrt(length);
  for (int i = 0; i < 3; ++i) f[i] = F[i][0] * n[0] + F[i][1] * n[1] + F[i][2] * n[2];
  lambda = sqrt(Real(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
  Result r;
  r.G = grow(p.muscle.growth, p.state.G, lambda, p.dt);
  if (p.muscle.removal.tau_rev > 0 && r.G == p.state.G) {
    r.G = shrink(p.muscle.growth, p.muscle.removal, p.state.G, lambda, p.dt);
  }
  r.lambda_e = lambda / r.G;
  r.J = determinant(F);
  Matrix Fg = identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) Fg[i][j] += (r.G - 1) * n[i] * n[j];
  }
  const Elastic e = elastic(product(F, inverse(Fg)), n);
  const Real factor = p.muscle.energy == myogrowth::EnergyPer::grown_volume ? r.G : Real(1);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r.tau[i][j] = factor * e.tau[i][j];
  }
  r.psi = factor * e.psi;
  return r;
}

/// The same with the sample's own law, eq. 3.
inline Result update(const samples::Point& p, const Matrix& F) {
  return update(p, F,
                [&](const Matrix& Fe, const Vector&) { return neo_hookean(p.muscle.c1, p.muscle.c2, Fe); });
}

inline Matrix first_piola(const Matrix& F, const Matrix& tau) { return product(tau, transpose(inverse(F))); }
inline Matrix second_piola(const Matrix& F, const Matrix& tau) {
  return product(inverse(F), product(tau, transpose(inverse(F))));
}

/// Central difference of measure(F, tau(F)) along dF, of the discrete update with these laws.
template <class Measure, class... Law>
Matrix derivative(const samples::Point& p, const Matrix& F, const Matrix& dF, Measure measure,
                  const Law&... law) {
  const Real h("1e-16");
  Matrix plus = F, minus = F, d;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      plus[i][j] += h * dF[i][j];
      minus[i][j] -= h * dF[i][j];
    }
  }
  const Matrix a = measure(plus, update(p, plus, law...).tau),
               b = measure(minus, update(p, minus, law...).tau);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) d[i][j] = (a[i][j] - b[i][j]) / (2 * h);
  }
  return d;
}

/// The symmetric unit tensor of column `col` in Abaqus's order; for shears half of each, as gamma = 2
/// epsilon.
inline Matrix unit_strain(int col) {
  Matrix D = identity();
  for (auto& row : D) row = Vector{};
  const int i = myogrowth::symmetric_row(col), j = myogrowth::symmetric_column(col);
  D[i][j] += Real(1) / 2;
  D[j][i] += Real(1) / 2;
  return D;
}

inline void put(const Matrix& A, int col, myogrowth::Mat6<double>& C) {
  for (int row = 0; row < 6; ++row) {
    C(row, col) = static_cast<double>(A[myogrowth::symmetric_row(row)][myogrowth::symmetric_column(row)]);
  }
}

template <class... Law>
myogrowth::Mat6<double> ddsdde(const samples::Point& p, const Law&... law) {
  myogrowth::Mat6<double> C;
  const Matrix F = exact(p.F);
  const Real J = determinant(F);
  for (int col = 0; col < 6; ++col) {
    put(derivative(
            p, F, product(unit_strain(col), F),
            [&](const Matrix&, Matrix tau) {
              for (auto& row : tau) {
                for (auto& x : row) x /= J;
              }
              return tau;
            },
            law...),
        col, C);
  }
  return C;
}

inline myogrowth::Mat6<double> dS_dE(const samples::Point& p) {
  myogrowth::Mat6<double> C;
  const Matrix F = exact(p.F);
  for (int col = 0; col < 6; ++col) {
    // dE = sym(F^T dF)
    put(derivative(p, F, product(transpose(inverse(F)), unit_strain(col)), second_piola), col, C);
  }
  return C;
}

inline myogrowth::Mat9<double> dP_dF(const samples::Point& p) {
  myogrowth::Mat9<double> A;
  const Matrix F = exact(p.F);
  for (int k = 0; k < 3; ++k) {
    for (int L = 0; L < 3; ++L) {
      Matrix dF = identity();
      for (auto& row : dF) row = Vector{};
      dF[k][L] = 1;
      const Matrix d = derivative(p, F, dF, first_piola);
      for (int i = 0; i < 3; ++i) {
        for (int J = 0; J < 3; ++J) A(i + 3 * J, k + 3 * L) = static_cast<double>(d[i][J]);
      }
    }
  }
  return A;
}

inline Eigen::Matrix3d rounded(const Matrix& A) {
  Eigen::Matrix3d B;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) B(i, j) = static_cast<double>(A[i][j]);
  }
  return B;
}

}  // namespace reference

#endif
