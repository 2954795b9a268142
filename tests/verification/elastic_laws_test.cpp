// The elastic laws compared with an independent evaluation in 50 digits, growth active, oblique fibres, any
// activation: laws 1 and 3 from their second Piola-Kirchhoff stress, law 2 from its energy by differences.
#include <gtest/gtest.h>

#include "../support/laws.hpp"
#include "../support/reference.hpp"

using namespace myogrowth;

namespace {

using reference::Elastic;
using reference::Matrix;
using reference::Real;
using reference::Vector;

Real trace(const Matrix& A) { return A[0][0] + A[1][1] + A[2][2]; }
Real along(const Matrix& A, const Vector& n) {
  Real sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) sum += n[i] * A[i][j] * n[j];
  }
  return sum;
}
template <class Entry>
Matrix fill(const Entry& entry) {
  Matrix A;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) A[i][j] = entry(i, j);
  }
  return A;
}
Real delta(int i, int j) { return i == j ? 1 : 0; }

Real active(const Real& l) {
  if (l <= Real("0.4") || l >= Real("1.6")) return 0;
  if (l < Real("0.6")) return 9 * (l - Real("0.4")) * (l - Real("0.4"));
  if (l > Real("1.4")) return 9 * (l - Real("1.6")) * (l - Real("1.6"));
  return 1 - 4 * (1 - l) * (1 - l);
}
Real passive(const Real& l, const Real& a, const Real& b, const Real& end) {
  if (l <= 1) return 0;
  if (l <= end) return a * (exp(b * (l - 1)) - 1);
  return a * (exp(b * (end - 1)) - 1) + a * b * exp(b * (end - 1)) * (l - end);
}
/// An integral by Simpson's rule, good to 1e-16, from `a` to `b` without a kink between.
template <class F>
Real integral(const F& f, const Real& a, const Real& b) {
  const int n = 400;
  Real sum = f(a) + f(b);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * f(Real(a + (b - a) * i / n));
  return sum * (b - a) / (3 * n);
}
/// The same over pieces that end at the kinks.
template <class F>
Real integral_from(const F& f, std::initializer_list<Real> kinks, const Real& to) {
  Real sum = 0;
  for (auto k = kinks.begin(); k != kinks.end() && *k < to; ++k) {
    const Real end = k + 1 == kinks.end() || to < k[1] ? to : k[1];
    sum += integral(f, Real(*k + Real("1e-40")), Real(end - Real("1e-40")));
  }
  return sum;
}

Elastic evaluate(const Roehrle<>& p, const Matrix& Fe, const Vector& n, const Real& a, bool with_energy) {
  const Matrix C = product(transpose(Fe), Fe), C_inverse = inverse(C);
  const Real ln_J = log(determinant(Fe)), I1 = trace(C), I4 = along(C, n), lambda = sqrt(I4);
  const auto force = [&](const Real& x) -> Real {
    const Real l = x / p.lambda_opt;
    return p.sigma_p * passive(l, p.g1, p.g2, 1.4) + a * p.sigma_a * active(l);
  };
  const Matrix S = fill([&](int i, int j) -> Real {
    return p.c10 * (delta(i, j) - C_inverse[i][j]) +
           p.c01 * (I1 * delta(i, j) - C[i][j] - 2 * C_inverse[i][j]) + p.kappa * ln_J * C_inverse[i][j] +
           force(lambda) / I4 * n[i] * n[j];
  });
  Elastic e{product(Fe, product(S, transpose(Fe))), 0};
  if (with_energy) {
    const Real I2 = (I1 * I1 - trace(product(C, C))) / 2;
    e.psi = (p.c10 * (I1 - 3 - 2 * ln_J) + p.c01 * (I2 - 3 - 4 * ln_J) + p.kappa * ln_J * ln_J) / 2 +
            integral_from([&](const Real& l) -> Real { return force(l * p.lambda_opt) / l; },
                          {Real("0.4"), Real("0.6"), Real(1), Real(1.4), Real("1.6")},
                          Real(lambda / p.lambda_opt));
  }
  return e;
}

Real energy(const Blemker<>& p, const Matrix& C, const Vector& n, const Real& a, bool with_energy) {
  const Real J = sqrt(reference::determinant(C));
  Matrix bar = C;
  for (auto& row : bar) {
    for (auto& x : row) x *= pow(J, Real(-2) / 3);
  }
  const Real I1 = trace(bar), I4 = along(bar, n), I5 = along(product(bar, bar), n), lambda = sqrt(I4);
  const Real omega = (I1 * I4 - I5) / (2 * lambda), B2 = log(omega + sqrt(omega * omega - 1));
  Real W = p.G1 * (I5 / (I4 * I4) - 1) + p.G2 * B2 * B2 + p.kappa / 2 * log(J) * log(J);
  if (!with_energy) return W;
  if (p.tendon) {
    return W + integral_from([&](const Real& l) -> Real { return passive(l, p.L1, p.L2, p.lambda_star) / l; },
                             {Real(1), Real(p.lambda_star)}, lambda);
  }
  return W + integral_from(
                 [&](const Real& l) -> Real {
                   return p.sigma_max * (passive(l, p.P1, p.P2, p.lambda_star) + a * active(l));
                 },
                 {Real("0.4"), Real("0.6"), Real(1), Real(1.4), Real("1.6")}, Real(lambda / p.lambda_opt));
}

/// The matrix part of the stress is that of differences of the energy; the fibre's is lambda dW3/dlambda
/// dev(M).
Elastic evaluate(const Blemker<>& p, const Matrix& Fe, const Vector& n, const Real& a, bool with_energy) {
  const Matrix C = product(transpose(Fe), Fe);
  const Real h("1e-17");
  const Matrix S = fill([&](int i, int j) -> Real {
    Matrix plus = C, minus = C;
    plus[i][j] += h / 2, plus[j][i] += h / 2;
    minus[i][j] -= h / 2, minus[j][i] -= h / 2;
    return (energy(p, plus, n, a, false) - energy(p, minus, n, a, false)) / h;
  });
  Elastic e{product(Fe, product(S, transpose(Fe))), 0};
  Vector f;
  for (int i = 0; i < 3; ++i) f[i] = Fe[i][0] * n[0] + Fe[i][1] * n[1] + Fe[i][2] * n[2];
  const Real square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
  const Real lambda = sqrt(square) * pow(reference::determinant(Fe), Real(-1) / 3), l = lambda / p.lambda_opt;
  const Real t = p.tendon ? passive(lambda, p.L1, p.L2, p.lambda_star)
                          : Real(p.sigma_max * l * (passive(l, p.P1, p.P2, p.lambda_star) + a * active(l)));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) e.tau[i][j] += t * (f[i] * f[j] / square - delta(i, j) / 3);
  }
  if (with_energy) e.psi = energy(p, C, n, a, true);
  return e;
}

Elastic evaluate(const Ehret<>& p, const Matrix& Fe, const Vector& n, const Real& a, bool with_energy) {
  const Matrix C = product(transpose(Fe), Fe), C_inverse = inverse(C);
  const Real w0 = p.w0, lambda = sqrt(along(C, n)), det = reference::determinant(C);
  const auto Ip = [&](const Real& l) -> Real { return w0 / 3 * (l * l + 2 / l) + (1 - w0) * l * l; };
  const auto wa = [&](const Real& l) -> Real {
    const Real lmin = p.lambda_min, lopt = p.lambda_opt;
    if (l <= lmin) return 0;
    const Real P =
        p.P_opt * a * (lmin - lopt) *
        (exp((2 * lmin - l - lopt) * (l - lopt) / (2 * (lmin - lopt) * (lmin - lopt))) - exp(Real(0.5)));
    return log(1 + 4 * p.alpha / Real(p.gamma) * P * exp(p.alpha * (1 - Ip(l)))) / (p.alpha * l * l);
  };
  const Real h("1e-17"), w = wa(lambda), dw = (wa(Real(lambda + h)) - wa(Real(lambda - h))) / (2 * h);
  const Matrix L = fill([&](int i, int j) -> Real { return w0 / 3 * delta(i, j) + (1 - w0) * n[i] * n[j]; });
  const Matrix CLC = product(C_inverse, product(L, C_inverse));
  const Real passive_I = trace(product(C, L)), I = passive_I + w * lambda * lambda;
  const Real J_tilde = det * trace(product(C_inverse, L));
  const Real eI = exp(p.alpha * (I - 1)), eJ = exp(p.beta * (J_tilde - 1));
  const Real eta = exp(p.alpha * (Ip(lambda) + w * lambda * lambda - 1)) * lambda * dw;
  const Matrix S = fill([&](int i, int j) -> Real {
    return p.gamma / Real(2) *
           (eI * (L[i][j] + w * n[i] * n[j]) - eJ * det * CLC[i][j] +
            (J_tilde * eJ - pow(det, Real(-p.kappa))) * C_inverse[i][j] + eta / 2 * n[i] * n[j]);
  });
  Elastic e{product(Fe, product(S, transpose(Fe))), 0};
  if (with_energy) {
    e.psi = p.gamma / Real(4) *
            ((exp(p.alpha * (passive_I - 1)) - 1) / p.alpha + (eJ - 1) / p.beta +
             (pow(det, Real(-p.kappa)) - 1) / p.kappa);
  }
  return e;
}

double error(const Eigen::MatrixXd& exact, const Eigen::MatrixXd& x) {
  return (x - exact).norm() / exact.norm();
}

template <class Law>
class AccuracyOfLaws : public testing::Test {};
using Laws = testing::Types<Roehrle<>, Blemker<>, Ehret<>>;
TYPED_TEST_SUITE(AccuracyOfLaws, Laws, );  // (clang wants the comma)

TYPED_TEST(AccuracyOfLaws, AgainstFiftyDigits) {
  samples::Random r(20261128);
  double stress = 0, tangent = 0, psi = 0;
  for (int i = 0; i < 40; ++i) {
    samples::Point p = samples::point(r, samples::Kind::growing);
    p.F = samples::rotation(r) * samples::deformation(r, 0.3);
    p.muscle.growth.G_max = 1.5;
    p.state.G = r.uniform(1, 1.2);
    p.muscle.growth.lambda_crit = (p.F * p.state.n0.normalized()).norm() / p.state.G * r.uniform(0.8, 0.98);
    p.muscle.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
    const FibreGrowthOf<TypeParam> muscle{laws::vary(TypeParam(), r), p.muscle.growth, p.muscle.removal,
                                          p.muscle.energy, p.muscle.integration};
    const double a = r.chance(0.2) ? 0 : r.uniform();
    const auto law = [&](const Matrix& Fe, const Vector& n) {
      return evaluate(muscle.elastic, Fe, n, a, false);
    };
    const auto with_energy = [&](const Matrix& Fe, const Vector& n) {
      return evaluate(muscle.elastic, Fe, n, a, true);
    };
    const auto u = update(muscle, p.F, p.state, p.dt, a);
    ASSERT_TRUE(u.ok());
    const reference::Result exact = reference::update(p, reference::exact(p.F), with_energy);
    EXPECT_GT(u.state.G, p.state.G);
    // What stress and energy are differences of is of the size of the modulus.
    const double scale = u.ddsdde().norm();
    stress = std::max(stress, (u.kirchhoff() - reference::rounded(exact.tau)).norm() /
                                  (reference::rounded(exact.tau).norm() + 1e-2 * scale));
    tangent = std::max(tangent, error(reference::ddsdde(p, law), u.ddsdde()));
    psi = std::max(psi, std::abs(u.point.psi - static_cast<double>(exact.psi)) /
                            (std::abs(static_cast<double>(exact.psi)) + 1e-2 * scale));
  }
  EXPECT_LE(stress, 1e-12);
  EXPECT_LE(tangent, 1e-10);
  EXPECT_LE(psi, 1e-11);
  std::printf("worst relative error: stress %.1e  DDSDDE %.1e  psi %.1e\n", stress, tangent, psi);
}

}  // namespace
