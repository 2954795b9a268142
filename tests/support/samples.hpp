// Deterministic random numbers and material points: the same on every machine and with every standard
// library.
#ifndef MYOGROWTH_TESTS_SAMPLES_HPP
#define MYOGROWTH_TESTS_SAMPLES_HPP

#include <cmath>
#include <cstdint>
#include <myogrowth/material.hpp>
#include <vector>

namespace samples {

/// splitmix64 (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }  // [0, 1)
  double uniform(double a, double b) { return a + (b - a) * uniform(); }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  bool chance(double p) { return uniform() < p; }
  template <class T, std::size_t N>
  T pick(const T (&choices)[N]) {
    return choices[bits() % N];
  }

 private:
  std::uint64_t state_;
};

/// A direction, and a rotation about it by any angle (Rodrigues).
inline Eigen::Vector3d direction(Random& r) {
  for (;;) {
    const Eigen::Vector3d v(r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1));
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}
inline Eigen::Matrix3d rotation(Random& r, double largest_angle = 3.14159265358979) {
  const Eigen::Vector3d a = direction(r);
  const double angle = r.uniform(-largest_angle, largest_angle);
  Eigen::Matrix3d W;
  W << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * W + (1 - std::cos(angle)) * W * W;
}

/// I + H with entries of H up to `size`, det > 0.05.
inline Eigen::Matrix3d deformation(Random& r, double size) {
  for (;;) {
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 9; ++i) F(i) += r.uniform(-size, size);
    if (F.determinant() > 0.05) return F;
  }
}

/// The input of an update.
struct Point {
  myogrowth::FibreGrowth<> muscle;
  Eigen::Matrix3d F;
  myogrowth::State<> state;
  double dt;
};

enum class Kind { growing, below_threshold, saturated, elastic_step, any };

/// A random point of the given kind: oblique fibres of any length, large rotations, gamma 0.5 to 4, dt up to
/// 10,000 tau.
inline Point point(Random& r, Kind kind, double largest_dt = 1e4) {
  Point p;
  const double gammas[] = {0.5, 0.75, 1, 1.5, 2, 2.5, 3, 3.7, 4};
  p.muscle.c1 = r.uniform(2, 40);
  p.muscle.c2 = r.uniform(1, 10);
  p.muscle.growth = {r.uniform(0.1, 3), r.pick(gammas), 1 + r.log_uniform(0.02, 2), r.uniform(0.9, 1.1)};
  p.F = rotation(r) * deformation(r, 0.6);
  p.state.n0 = direction(r) * r.log_uniform(1e-3, 1e3);
  p.state.G = 1 + (p.muscle.growth.G_max - 1) * (r.chance(0.3) ? 0 : r.uniform(0, 0.95));
  p.dt = p.muscle.growth.tau * r.log_uniform(1e-6, largest_dt);
  const double lambda = (p.F * p.state.n0.normalized()).norm();
  const double G = p.state.G;
  if (kind == Kind::growing) p.muscle.growth.lambda_crit = lambda / G * r.uniform(0.5, 0.98);
  if (kind == Kind::below_threshold) p.muscle.growth.lambda_crit = lambda / G * r.uniform(1.001, 2);
  if (kind == Kind::saturated) p.state.G = p.muscle.growth.G_max * (r.chance(0.5) ? 1 : 1.1);
  if (kind == Kind::elastic_step) p.dt = 0;
  return p;
}

}  // namespace samples

#endif
