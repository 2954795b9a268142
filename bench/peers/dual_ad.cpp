// Only the stress is written, and forward dual numbers with six directions carry its derivatives. The local
// iteration runs on plain numbers; G then gets its derivatives by the implicit function theorem.
#include <cmath>

#include "growth.hpp"
#include "umat.hpp"

namespace {

constexpr int n = 6;

struct Dual {
  double v = 0, d[n] = {};  // value and derivatives
  Dual() = default;
  Dual(double value) : v(value) {}
};

Dual operator+(const Dual& a, const Dual& b) {
  Dual c(a.v + b.v);
  for (int i = 0; i < n; ++i) c.d[i] = a.d[i] + b.d[i];
  return c;
}
Dual operator-(const Dual& a, const Dual& b) {
  Dual c(a.v - b.v);
  for (int i = 0; i < n; ++i) c.d[i] = a.d[i] - b.d[i];
  return c;
}
Dual operator-(Dual a, double b) {
  a.v -= b;
  return a;
}
Dual operator*(const Dual& a, const Dual& b) {
  Dual c(a.v * b.v);
  for (int i = 0; i < n; ++i) c.d[i] = a.d[i] * b.v + a.v * b.d[i];
  return c;
}
Dual operator*(double a, const Dual& b) {
  Dual c(a * b.v);
  for (int i = 0; i < n; ++i) c.d[i] = a * b.d[i];
  return c;
}
/// f(a) with the slope f'(a).
Dual chain(double f, double slope, const Dual& a) {
  Dual c(f);
  for (int i = 0; i < n; ++i) c.d[i] = slope * a.d[i];
  return c;
}
Dual inverse(const Dual& a) { return chain(1 / a.v, -1 / (a.v * a.v), a); }
Dual sqrt(const Dual& a) { return chain(std::sqrt(a.v), 0.5 / std::sqrt(a.v), a); }
Dual log(const Dual& a) { return chain(std::log(a.v), 1 / a.v, a); }

}  // namespace

static void update(const double* props, double dtime, const double* dfgrd1, double* statev, double* stress,
                   double* ddsdde, double& sse) {
  constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
  const double c1 = props[0], c2 = props[1];
  const double* n0 = statev + 5;

  // dF = (e_k⊗e_l + e_l⊗e_k)/2 F in direction kl
  Dual F[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) F[i][j] = dfgrd1[i + 3 * j];
  }
  for (int a = 0; a < 6; ++a) {
    for (int j = 0; j < 3; ++j) {
      F[row[a]][j].d[a] += dfgrd1[column[a] + 3 * j] / 2;
      F[column[a]][j].d[a] += dfgrd1[row[a] + 3 * j] / 2;
    }
  }

  Dual f[3];
  for (int i = 0; i < 3; ++i) f[i] = n0[0] * F[i][0] + n0[1] * F[i][1] + n0[2] * F[i][2];
  const Dual lambda = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  const Growth growth = grow(props, statev[0], lambda.v, dtime);
  const Dual G = chain(growth.G, growth.dG_dlambda, lambda);

  // F_e = F F_g^-1 = F + (1/G - 1) f⊗n0, b_e = F_e F_e^T
  const Dual per_G = inverse(G), less = per_G - 1.0;
  Dual Fe[3][3], be[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) Fe[i][j] = F[i][j] + less * (n0[j] * f[i]);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) be[i][j] = Fe[i][0] * Fe[j][0] + Fe[i][1] * Fe[j][1] + Fe[i][2] * Fe[j][2];
  }
  const Dual J = F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) -
                 F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
                 F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
  const Dual ln_Je = log(J * per_G);

  for (int a = 0; a < 6; ++a) {
    const int i = row[a], j = column[a];
    Dual tau = c2 * be[i][j];
    if (i == j) tau = tau + c1 * ln_Je - c2;
    stress[a] = tau.v / J.v;
    for (int b = 0; b < 6; ++b) ddsdde[a + 6 * b] = tau.d[b] / J.v;
  }
  sse = c1 / 2 * ln_Je.v * ln_Je.v + c2 / 2 * (be[0][0].v + be[1][1].v + be[2][2].v - 3 - 2 * ln_Je.v);
  statev[0] = G.v;
  statev[1] = lambda.v / G.v;
  statev[2] = lambda.v;
  statev[3] = J.v;
  statev[4] = J.v / G.v;
}
