// One step of the law through the C++ headers.
#include <cstdio>
#include <myogrowth/material.hpp>

int main() {
  const myogrowth::FibreGrowth<> muscle;
  const Eigen::Matrix3d F = Eigen::Vector3d(1.2, 0.95, 0.95).asDiagonal();
  const auto step = myogrowth::update(muscle, F, myogrowth::State<>(), 0.1);
  std::printf("%.17g %.17g\n", step.state.G, step.cauchy()(0, 0));
  return step.ok() ? 0 : 1;
}
