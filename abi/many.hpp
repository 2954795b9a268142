/// @file
/// The update of many points of a host: in packs by the fastest batch of this machine, one by one where packs
/// cannot.
#ifndef MYOGROWTH_ABI_MANY_HPP
#define MYOGROWTH_ABI_MANY_HPP

#include "block.hpp"
#include "point.hpp"

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
          {m.growth.tau, m.growth.gamma, m.growth.G_max, m.growth.lambda_crit},
          {m.removal.tau_rev, m.removal.gamma_rev, m.removal.G_min, m.removal.lambda_crit_rev},
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
  return is_within(m.c1, 0, 1e30) && is_within(m.c2, 1e-30, 1e30) && is_within(g.tau, 1e-30, 1e30) &&
         g.gamma <= 100 && is_within(g.G_max - 1, 1e-10, 1e10) && is_within(g.lambda_crit, 1e-10, 1e10) &&
         is_within(dt, 0, 1e30);
}
inline bool packs_can(const double* F, double G_n) {
  double square = 0;
  for (int i = 0; i < 9; ++i) square += F[i] * F[i];
  return is_within(G_n, 1e-10, 1e10) && square <= 1e20;
}

/// Point k of a block that has been updated.
struct BlockResult {
  const MyogrowthBlock& block;
  int k;
  /// The first n components of one of its arrays, one after the other.
  template <int n>
  void gather(const double* components, double* to) const {
    for (int i = 0; i < n; ++i) to[i] = components[k + i * myogrowth_block_points];
  }
  /// The entries of STATEV that a point keeps, and psi.
  double psi() const { return block.scalars[k + 4 * myogrowth_block_points]; }
  void state(double (&s)[n_kept]) const {
    s[0] = block.G_end[k];
    gather<4>(block.scalars, s + 1);
    gather<3>(block.n0, s + fibre_entry);
  }
};

/// Updates many points: in packs those that packs can take, the others one by one.
/// begin(i, F, start): F and what the step of point i starts from; false if packs are not to take it.
/// keep(i, result): false if the result is none for the host. alone(i): the update of all other points.
template <class Begin, class Keep, class Alone>
void update_many(const FibreGrowth<double>& m, double dt, int n_points, int measure, bool with_tangent,
                 const Begin& begin, const Keep& keep, const Alone& alone) {
  constexpr int size = myogrowth_block_points;
  const MyogrowthBlockMaterial material = block_material(m);
  const bool material_can = packs_can(m, dt);
  MyogrowthBlock block;
  block.dt = dt;
  for (int first = 0, left = n_points; left > 0; first += size, left -= size) {
    const int count = left < size ? left : size;
    bool done[size] = {};
    for (int k = 0; k < count && material_can; ++k) {
      Start start;
      double F[9], unit[3] = {1, 0, 0};
      done[k] = begin(first + k, F, start) && normalise(start.n0, unit) && packs_can(F, start.G);
      // Where it is not for packs, an undeformed point stands in its place.
      for (int i = 0; i < 9; ++i) block.F[k + size * i] = done[k] ? F[i] : i % 4 == 0 ? 1 : 0;
      for (int i = 0; i < 3; ++i) block.n0[k + size * i] = unit[i];
      block.G[k] = done[k] ? start.G : 1;
      block.lambda[k] = done[k] ? start.lambda : 1;
    }
    if (material_can) update_block()(&material, count, measure, with_tangent, &block);
    for (int k = 0; k < count; ++k) {
      done[k] = done[k] && block.check[k] == 0 && keep(first + k, BlockResult{block, k});
      if (!done[k]) alone(first + k);
    }
    if (left <= size) break;  // `first` must not pass the largest int
  }
}

}  // namespace abi
}  // namespace myogrowth

#endif
