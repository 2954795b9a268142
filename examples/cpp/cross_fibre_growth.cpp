// Hypertrophy, the library's CrossFibreGrowth: a muscle that is loaded for weeks adds sarcomeres in parallel,
// and becomes thicker until the tension on each sarcomere is back at its old value. Prints six weeks of
// growth, and compares the tangent with differences. A growth law of your own is a struct like this one.
#include <cmath>
#include <cstdio>
#include <myogrowth/more/cross_fibre_growth.hpp>

using namespace myogrowth;

int main() {
  const CrossFibreGrowth law;
  const NeoHookean<> elasticity;
  const Vec3<double> n0(std::cos(0.3), std::sin(0.3), 0);
  Mat3<double> F = Mat3<double>::Identity();
  F(0, 0) = 1.1;
  F(0, 1) = 0.1;
  double g = 1;
  const double dt = 0.25;  // days
  for (int step = 1; step <= 42 / dt; ++step) {
    const LawUpdate next = update(law, elasticity, F, n0, g, dt);
    if (!next.ok()) {
      std::fprintf(stderr, "no result on day %g\n", step * dt);
      return 1;
    }
    g = next.g;
    if (step % 28 == 0)
      std::printf("day %4.1f  cross-section %.4f  P_11 = %.4f kPa\n", step * dt, g, next.P(0, 0));
  }

  // dP/dF of one step, growth included, compared with central differences of the same step.
  const double h = 1e-6;
  const LawUpdate step = update(law, elasticity, F, n0, 1.05, dt);
  Mat9<double> difference;  // a NaN in it makes its norm NaN
  for (int k = 0; k < 9; ++k) {
    Mat3<double> plus = F, minus = F;
    plus.data()[k] += h;
    minus.data()[k] -= h;
    const Mat3<double> slope =
        (update(law, elasticity, plus, n0, 1.05, dt).P - update(law, elasticity, minus, n0, 1.05, dt).P) /
        (2 * h);
    for (int i = 0; i < 9; ++i) difference(i, k) = slope.data()[i] - step.dP_dF(i, k);
  }
  const double error = difference.norm() / step.dP_dF.norm();
  std::printf("dP/dF against differences: %.0e of its norm\n", error);
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    std::perror("standard output cannot be written");
    return 1;
  }
  return error < 1e-7 ? 0 : 1;
}
