// Six weeks of a muscle fibre held at 10 % stretch: prints the relative sarcomere number G over time.
// Needs only the headers:  g++ -std=c++17 -I include -I /usr/include/eigen3 growth_over_time.cpp
#include <cstdio>
#include <myogrowth/material.hpp>

int main() {
  const myogrowth::FibreGrowth<> muscle;  // the paper's Table 1, in kPa and days
  myogrowth::State<> state;               // G = 1, fibre along x
  const double dt = 0.05;                 // days
  for (int step = 1; step <= 42 / dt; ++step) {
    const double t = step * dt, stretch = t < 1 ? 1 + 0.1 * t : 1.1;
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F(0, 0) = stretch;
    const auto next = myogrowth::update(muscle, F, state, dt);
    if (!next.ok()) {
      std::fprintf(stderr, "no result on day %g\n", t);
      return 1;
    }
    state = next.state;
    if (step % 60 == 0)
      std::printf("day %4.1f  G = %.5f  lambda_e = %.5f\n", t, state.G, next.point.lambda_e);
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    std::perror("standard output cannot be written");
    return 1;
  }
}
