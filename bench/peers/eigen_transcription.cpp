// The paper's equations as they are written, with Eigen's matrices: F_g, F_e, C_e, S_e and L_e, pulled back
// by F_g, the consistent dS/dE, and all of it pushed forward to what a UMAT returns.
#include <Eigen/Dense>

#include "growth.hpp"
#include "umat.hpp"

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

namespace {

constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

Vector6d voigt(const Matrix3d& A) {
  Vector6d v;
  for (int a = 0; a < 6; ++a) v[a] = A(row[a], column[a]);
  return v;
}

// (A ⊙ B)_ijkl = (A_ik B_jl + A_il B_jk)/2
Matrix6d symmetric_product(const Matrix3d& A, const Matrix3d& B) {
  Matrix6d C;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      const int i = row[a], j = column[a], k = row[b], l = column[b];
      C(a, b) = (A(i, k) * B(j, l) + A(i, l) * B(j, k)) / 2;
    }
  }
  return C;
}

// V with voigt(A S A^T) = V voigt(S), so that A ... C ... A^T is V C V^T.
Matrix6d push_forward(const Matrix3d& A) {
  Matrix6d V;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      const int i = row[a], j = column[a], k = row[b], l = column[b];
      V(a, b) = k == l ? A(i, k) * A(j, k) : A(i, k) * A(j, l) + A(i, l) * A(j, k);
    }
  }
  return V;
}

}  // namespace

static void update(const double* props, double dtime, const double* dfgrd1, double* statev, double* stress,
                   double* ddsdde, double& sse) {
  const double c1 = props[0], c2 = props[1];
  const Matrix3d F = Eigen::Map<const Matrix3d>(dfgrd1);
  const Vector3d n0(statev[5], statev[6], statev[7]);
  const Matrix3d I = Matrix3d::Identity();
  const Matrix3d n0n0 = n0 * n0.transpose();

  // eq. 4
  const double lambda = (F * n0).norm();
  const Growth growth = grow(props, statev[0], lambda, dtime);
  const double G = growth.G;

  // eqs 1 and 2
  const Matrix3d Fg = I + (G - 1) * n0n0;
  const Matrix3d inverse_Fg = Fg.inverse();
  const Matrix3d Fe = F * inverse_Fg;
  const Matrix3d Ce = Fe.transpose() * Fe;
  const Matrix3d inverse_Ce = Ce.inverse();
  const double J = F.determinant(), ln_Je = std::log(Fe.determinant());

  // eq. 3
  sse = c1 / 2 * ln_Je * ln_Je + c2 / 2 * (Ce.trace() - 3 - 2 * ln_Je);
  const Matrix3d Se = c1 * ln_Je * inverse_Ce + c2 * (I - inverse_Ce);
  const Matrix6d Le = c1 * voigt(inverse_Ce) * voigt(inverse_Ce).transpose() +
                      2 * (c2 - c1 * ln_Je) * symmetric_product(inverse_Ce, inverse_Ce);
  const Matrix3d S = inverse_Fg * Se * inverse_Fg.transpose();
  const Matrix6d pull = push_forward(inverse_Fg);
  Matrix6d L = pull * Le * pull.transpose();

  // dS/dE = L + 2 dS/dG ⊗ dG/dC
  const Matrix3d dinverse_Fg = -1 / (G * G) * n0n0;
  const Matrix3d C = F.transpose() * F;
  const Matrix3d dCe = dinverse_Fg * C * inverse_Fg + inverse_Fg * C * dinverse_Fg;
  Vector6d dEe = voigt(dCe) / 2;
  dEe.tail<3>() *= 2;
  const Vector6d dSe = Le * dEe;
  const Matrix3d dS = dinverse_Fg * Se * inverse_Fg + inverse_Fg * Se * dinverse_Fg;
  const Vector6d dS_dG = voigt(dS) + pull * dSe;
  L += growth.dG_dlambda / lambda * dS_dG * voigt(n0n0).transpose();

  // tau, and the modulus of its Jaumann rate
  const Matrix3d tau = F * S * F.transpose();
  const Matrix6d push = push_forward(F);
  const Matrix6d c = push * L * push.transpose() + symmetric_product(I, tau) + symmetric_product(tau, I);
  Eigen::Map<Vector6d>(stress, 6) = voigt(tau) / J;
  Eigen::Map<Matrix6d>(ddsdde, 6, 6) = c / J;

  statev[0] = G;
  statev[1] = lambda / G;
  statev[2] = lambda;
  statev[3] = J;
  statev[4] = J / G;
}
