// The material points that every variant is timed on: random with a fixed seed, and similar to those of an
// analysis.
#ifndef MYOGROWTH_BENCH_POINTS_HPP
#define MYOGROWTH_BENCH_POINTS_HPP

#include <sys/mman.h>

#include <Eigen/Dense>
#include <cstddef>
#include <new>
#include <random>
#include <vector>

#include "batch_pass.hpp"

namespace bench {

/// Which points grow in the step.
enum Growth { active, half, inactive, n_growths };
constexpr const char* growth_name[n_growths] = {"active", "half", "inactive"};

constexpr int nstatv = 8;  ///< of libmyogrowth_umat: G, four results, the fibre
constexpr double dtime = 0.1, G_max = 1.1, lambda_crit = 1.01;

/// PROPS: Table 1 of the paper, except gamma.
inline std::vector<double> props(double gamma, bool second_order = false) {
  std::vector<double> all = {16, 4, 0.5, gamma, G_max, lambda_crit, 1, 0, 0};
  if (second_order) all.insert(all.end(), {0, 0, 1});
  return all;
}

/// Numbers aligned to a cache line, so that no pack crosses two; many of them on huge pages where the system
/// has some, or the walks through its page tables are timed as well.
template <class T>
struct OnCacheLine {
  using value_type = T;
  static constexpr std::align_val_t line{64}, huge_page{1 << 21};
  static bool are_many(std::size_t n) { return n * sizeof(T) >= 2 * static_cast<std::size_t>(huge_page); }
  OnCacheLine() = default;
  template <class U>
  OnCacheLine(const OnCacheLine<U>&) {}
  T* allocate(std::size_t n) {
    if (!are_many(n)) return static_cast<T*>(::operator new(n * sizeof(T), line));
    void* const p = ::operator new(n * sizeof(T), huge_page);
#if defined(MADV_HUGEPAGE)
    madvise(p, n * sizeof(T), MADV_HUGEPAGE);
#endif
    return static_cast<T*>(p);
  }
  void deallocate(T* p, std::size_t n) { ::operator delete(p, are_many(n) ? huge_page : line); }
  friend bool operator==(OnCacheLine, OnCacheLine) { return true; }
  friend bool operator!=(OnCacheLine, OnCacheLine) { return false; }
};
using Numbers = std::vector<double, OnCacheLine<double>>;

/// Component c of point p in blocks of bench_block points.
constexpr std::size_t in_blocks(std::size_t components, std::size_t p, std::size_t c) {
  return (p / bench_block * components + c) * bench_block + p % bench_block;
}

/// Inputs of `size` points, a multiple of bench_block, in the layouts that the variants take. F, and with it
/// the memory traffic, does not depend on which points grow: this is set by the sarcomere number at the start
/// of the step.
struct Points {
  std::size_t size;
  Numbers F, n0;                ///< 9 and 3 per point
  Numbers G_n[n_growths];       ///< 1 per point
  Numbers statev_n[n_growths];  ///< nstatv per point
  Numbers lambda_n;             ///< 1 per point: the stretch is held through the step
  Numbers F_blocks, n0_blocks;  ///< the same in blocks

  explicit Points(std::size_t size_)
      : size(size_), F(9 * size), n0(3 * size), lambda_n(size), F_blocks(9 * size), n0_blocks(3 * size) {
    std::mt19937_64 random(20240607);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto between = [&](double a, double b) { return a + (b - a) * unit(random); };
    for (int g = 0; g < n_growths; ++g) {
      G_n[g].resize(size);
      statev_n[g].assign(nstatv * size, 0.0);
    }
    for (std::size_t p = 0; p < size; ++p) {
      using Eigen::Matrix3d;
      using Eigen::Vector3d;
      const auto direction = [&] {
        return Vector3d(between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
      };
      // Stretch along the fibre, a contraction across it smaller than the isochoric one, shear of 2 %,
      // rotation up to 0.3.
      const double lambda = between(1.03, 1.1);
      const Vector3d n = direction();
      const Matrix3d I = Matrix3d::Identity(), nn = n * n.transpose();
      Matrix3d shear;
      for (int i = 0; i < 9; ++i) shear(i) = between(-0.02, 0.02);
      Matrix3d deformation = lambda * nn + (1 - 0.4 * (lambda - 1)) * (I - nn) + shear;
      deformation *= I + (lambda / (deformation * n).norm() - 1) * nn;
      const Matrix3d rotated = Eigen::AngleAxisd(between(0, 0.3), direction()) * deformation;
      Eigen::Map<Matrix3d>(F.data() + 9 * p) = rotated;
      Eigen::Map<Vector3d>(n0.data() + 3 * p) = n;
      lambda_n[p] = (rotated * n).norm();
      for (std::size_t c = 0; c < 9; ++c) F_blocks[in_blocks(9, p, c)] = F[9 * p + c];
      for (std::size_t c = 0; c < 3; ++c) n0_blocks[in_blocks(3, p, c)] = n0[3 * p + c];

      // A muscle that grows, anywhere between its start and the threshold; and a muscle at the threshold.
      const double growing = 1 + unit(random) * (lambda / 1.02 - 1);
      const double resting = lambda / between(1.0, 1.0095);
      G_n[active][p] = growing;
      G_n[inactive][p] = resting;
      G_n[half][p] = unit(random) < 0.5 ? growing : resting;
      for (int g = 0; g < n_growths; ++g) {
        double* statev = &statev_n[g][nstatv * p];
        statev[0] = G_n[g][p];
        statev[2] = lambda_n[p];
        for (int i = 0; i < 3; ++i) statev[5 + i] = n[i];
      }
    }
  }
};

}  // namespace bench

#endif
