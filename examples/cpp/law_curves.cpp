// Prints the curves of the elastic laws (docs/laws.md) as CSV: a strip with its fibre along the pull and its
// sides free.
//   law_curves > curves.csv      law, G, activation, stretch [-], nominal stress [kPa]; rows without a
//   solution are left out
// G = 1: each law passive and fully active. Then law 2 before and after six weeks of a 10 % stretch, the
// paper's test.
#include <cmath>
#include <cstdio>
#include <myogrowth/elastic/blemker.hpp>
#include <myogrowth/elastic/ehret.hpp>
#include <myogrowth/elastic/neo_hookean.hpp>
#include <myogrowth/elastic/roehrle.hpp>
#include <myogrowth/material.hpp>
#include <myogrowth/more/stress_states.hpp>

using namespace myogrowth;

namespace {

template <class Law>
void curve(const char* name, const Law& law, double G, double activation, double from, double to) {
  FibreGrowthOf<Law> muscle;
  muscle.elastic = law;
  ElasticPointUpdate<double> u;
  double slope;
  for (int i = 0; i <= 150; ++i) {
    const double stretch = from + (to - from) * i / 150;
    double sides = 1 / std::sqrt(stretch);  // a start at which the volume is kept
    const auto status = uniaxial_stress(muscle, stretch, G, 1.0, 0.0, sides, u, slope, activation);
    if (status != UpdateStatus::ok) continue;
    std::printf("%s,%.6f,%g,%.6f,%.6f\n", name, G, activation, stretch, u.tau[0] / stretch);
  }
}

}  // namespace

int main() {
  std::printf("law,G,activation,stretch,stress\n");
  for (const double activation : {0.0, 1.0}) {
    if (activation == 0) curve("neo-Hookean", NeoHookean<>(), 1, 0, 0.7, 1.6);
    curve("Roehrle", Roehrle<>(), 1, activation, 0.6, 2.2);
    curve("Blemker", Blemker<>(), 1, activation, 0.6, 2.2);
    Ehret<> nearly_incompressible;  // its curve when active; with the published kappa = 100 it pushes
                                    // (docs/laws.md)
    nearly_incompressible.kappa = 1e4;
    curve("Ehret", nearly_incompressible, 1, activation, 0.6, 1.5);
    if (activation == 1) curve("Ehret kappa 100", Ehret<>(), 1, activation, 0.6, 1.5);
  }
  curve("tendon", Blemker<>::of_tendon(), 1, 0, 0.98, 1.06);

  // The force-length curve of the whole muscle: G after 10 % in a day, held to day 42. Eq. 4 needs the
  // stretch only.
  const FibreGrowthOf<Blemker<>> muscle;
  State<> state;
  Mat3<double> F = Mat3<double>::Identity();
  const double dt = 0.01;
  for (int step = 1; step <= 4200; ++step) {
    F(0, 0) = step * dt < 1 ? 1 + 0.1 * step * dt : 1.1;
    state = update(muscle, F, state, dt).state;
  }
  for (const double G : {1.0, state.G}) {
    for (const double activation : {0.0, 1.0}) curve("whole muscle", Blemker<>(), G, activation, 0.6, 2.6);
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    std::perror("standard output cannot be written");
    return 1;
  }
  return 0;
}
