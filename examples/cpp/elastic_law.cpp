// An elastic law of your own, given by its energy only: stiff passive fibres in an isotropic matrix
// (Holzapfel, Gasser and Ogden 2000). Stress, tangent and growth come from the library. The program stretches
// a strip by 10 % in a day, holds it for six weeks, and compares the tangent with differences of the step
// itself.
#include <cstdio>
#include <myogrowth/material.hpp>
#include <myogrowth/more/stress_states.hpp>

using namespace myogrowth;

namespace {

// psi = c/2 (I1 - 3 - 2 ln J) + kappa/2 ln^2 J + k1/(2 k2) (e^{k2 <I4 - 1>^2} - 1)
struct FibreReinforced {
  double c = 4, kappa = 16, k1 = 2, k2 = 1;  // [kPa], k2 [-]

  template <class T>
  T psi(const T Fe[9], const T n0[3], const T& /*activation*/) const {
    const Invariants<T> in = invariants(Fe, n0);
    const T ln_J = log(in.J);
    const T matrix = c / 2 * (in.I1 - 3. - 2. * ln_J) + kappa / 2 * ln_J * ln_J;
    if (value(in.I4) <= 1) return matrix;  // a slack fibre carries nothing; value() is what decides
    const T stretch = in.I4 - 1.;
    return matrix + k1 / (2 * k2) * expm1(k2 * stretch * stretch);
  }
};

}  // namespace

int main() {
  const FibreGrowthOf<FibreReinforced> muscle;  // growth: the paper's Table 1, in days
  double G = 1, last_stretch = 1, sides = 1, slope;
  ElasticPointUpdate<double> strip;
  const double dt = 0.25;
  for (int step = 1; step <= 168; ++step) {
    const double day = step * dt, stretch = day < 1 ? 1 + 0.1 * day : 1.1;
    if (uniaxial_stress(muscle, stretch, G, last_stretch, dt, sides, strip, slope) != UpdateStatus::ok)
      return 1;
    G = strip.G, last_stretch = stretch;
    if (step == 4 || step == 168) {
      std::printf("day %4.1f  G = %.4f  elastic stretch %.4f  stress %.3f kPa\n", day, G, strip.lambda_e,
                  strip.tau[0] / strip.J);
    }
  }

  // The tangent of a growing step with an oblique fibre against central differences of P.
  Mat3<double> F;
  F << 1.1, 0.1, 0, -0.05, 1.05, 0.02, 0, 0.1, 0.98;
  State<> state;
  state.n0 = {2, 1, -2};
  const auto u = update(muscle, F, state, 0.5);
  const double h = 1e-6;
  Mat9<double> difference;  // a NaN in it makes its norm NaN
  for (int k = 0; k < 9; ++k) {
    Mat3<double> plus = F, minus = F;
    plus.data()[k] += h, minus.data()[k] -= h;
    const Mat3<double> dP =
        (update(muscle, plus, state, 0.5).first_piola() - update(muscle, minus, state, 0.5).first_piola()) /
        (2 * h);
    for (int i = 0; i < 9; ++i) difference(i, k) = dP.data()[i] - u.dP_dF()(i, k);
  }
  std::printf("tangent against differences: %.1e kPa of %.0f kPa\n", difference.norm(), u.dP_dF().norm());
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    std::perror("standard output cannot be written");
    return 1;
  }
  return difference.norm() < 1e-7 && G > 1.08 ? 0 : 1;
}
