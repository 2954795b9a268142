/// @file
/// The batch behind the routines that hosts call with many points: compiled once for each instruction set,
/// chosen when the library is loaded. Plain C at the border, so that code for one instruction set cannot leak
/// into another.
#ifndef MYOGROWTH_ABI_BLOCK_HPP
#define MYOGROWTH_ABI_BLOCK_HPP

#include <myogrowth/kernel.hpp>

extern "C" {

/// Points in a block: with the full tangent, what goes in and comes out of it stays in the nearest cache.
constexpr int myogrowth_block_points = 32;

/// FibreGrowth in plain numbers.
struct MyogrowthBlockMaterial {
  double c1, c2, growth[4], removal[4];
  int grown_energy, second_order;
};

/// A block: component c of point i is at [c * myogrowth_block_points + i]. Tangent and stress as in Measure's
/// order.
struct MyogrowthBlock {
  double F[9 * myogrowth_block_points], n0[3 * myogrowth_block_points];
  double G[myogrowth_block_points], lambda[myogrowth_block_points];  ///< at the beginning of the step
  double dt;
  double stress[9 * myogrowth_block_points], tangent[81 * myogrowth_block_points];
  double G_end[myogrowth_block_points];
  double scalars[5 * myogrowth_block_points];  ///< lambda_e, lambda, J, Je, psi
  double check[myogrowth_block_points];        ///< 0 if all that comes out, and its sum, is finite
};

/// Updates the first n points. measure: 0 Cauchy, 1 first, 2 second Piola-Kirchhoff. Where a point has no
/// result its stress and its check are NaN.
using MyogrowthUpdateBlock = void(const MyogrowthBlockMaterial* material, int n, int measure,
                                  int with_tangent, MyogrowthBlock* block);
#pragma GCC visibility push(hidden)
MyogrowthUpdateBlock myogrowth_update_block_base, myogrowth_update_block_avx2, myogrowth_update_block_avx512;
#pragma GCC visibility pop
}

namespace myogrowth {
namespace abi {

/// The fastest that this machine has.
inline MyogrowthUpdateBlock* update_block() {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return myogrowth_update_block_base;
  const bool widest = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  return widest ? myogrowth_update_block_avx512 : myogrowth_update_block_avx2;
#else
  return myogrowth_update_block_base;
#endif
}

inline MyogrowthBlockMaterial block_material(const FibreGrowth<double>& m) {
  return {m.c1,
          m.c2,
          {m.growth.growth_time, m.growth.gamma, m.growth.G_max, m.growth.lambda_crit},
          {m.removal.removal_time, m.removal.gamma, m.removal.G_min, m.removal.lambda_crit},
          m.energy == EnergyPer::grown_volume,
          m.integration == TimeIntegration::midpoint_flow};
}

// Whether packs may do it: they are not made for numbers so large or small that a product of a few is out of
// range.
inline bool is_within(double x, double least, double most) {
  const double size = x < 0 ? -x : x;
  return size >= least && size <= most;
}
inline bool packs_can(const FibreGrowth<double>& m, double dt) {
  const GrowthRate<double>& g = m.growth;
  return is_within(m.c1, 0, 1e30) && is_within(m.c2, 1e-30, 1e30) && is_within(g.growth_time, 1e-30, 1e30) &&
         g.gamma <= 100 && is_within(g.G_max - 1, 1e-10, 1e10) && is_within(g.lambda_crit, 1e-10, 1e10) &&
         is_within(dt, 0, 1e30);
}
inline bool packs_can(const double* F, double G_n) {
  double square = 0;
  for (int i = 0; i < 9; ++i) square += F[i] * F[i];
  return is_within(G_n, 1e-10, 1e10) && square <= 1e20;
}

}  // namespace abi
}  // namespace myogrowth

#endif
