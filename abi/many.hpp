/// @file
/// The update of a host's points: in packs by the fastest batch of this machine, one by one where packs
/// cannot.
#ifndef MYOGROWTH_ABI_MANY_HPP
#define MYOGROWTH_ABI_MANY_HPP

#include <myogrowth/more/left_stretch.hpp>

#include "block.hpp"
#include "point.hpp"

namespace myogrowth {
namespace abi {

/// What the points of a call have in common.
struct Common {
  Properties properties;
  int n_state;  ///< entries of a point's state, n_statev_required at least
  double dt;
  int measure;  ///< of stress and tangent, as convert() has them
  bool with_tangent;
};

/// What a step gives at one point, for the host to take: component c of stress and tangent at [c * stride].
template <int stride>
struct Result {
  const double *stress, *tangent;
  double psi, state[n_kept];
  /// The n components of the stress, and of the tangent unless it is null, one after the other.
  template <int n>
  void copy(double* to_stress, double* to_tangent) const {
    for (int c = 0; c < n; ++c) to_stress[c] = stress[c * stride];
    for (int c = 0; c < n * n && to_tangent; ++c) to_tangent[c] = tangent[c * stride];
  }
};

/// One step at one point by the scalar law of a material; u is what its update_point fills, a its activation
/// where it has one. take(result): false if it is none for the host. Where there is no
/// result the status says why, and the text names the entry if it is the state that is not allowed.
template <class Material, class Point, class Take, class... Activation>
UpdateStatus update_alone(const Common& c, const Material& material, Point& u, const double F_given[9],
                          const double* state, Text& text, const Take& take, const Activation&... a) {
  text[0] = '\0';
  Start start;
  const UpdateStatus found = find_start(state, c.n_state, c.properties, start, text);
  if (found != UpdateStatus::ok) return found;
  double V[9], stress[9], tangent[81];
  const bool local = c.properties.local_basis, turned = local && left_stretch(F_given, V);
  const double* F = turned ? V : F_given;
  if (update_point(material, F, start.n0, start.G, start.lambda, c.dt, u, a...) != UpdateStatus::ok)
    return u.status;
  // det F can be 0 to the one and > 0 to the other, to rounding: F itself is then the wrong one.
  if (local && !turned) return UpdateStatus::inverted;
  convert(c.measure, F, u, stress, c.with_tangent ? tangent : nullptr);
  const int n = c.measure == 1 ? 9 : 6;
  if (!are_finite(stress, n) || (c.with_tangent && !are_finite(tangent, n * n)))
    return UpdateStatus::not_finite;
  Result<1> result{stress, tangent, u.psi, {}};
  state_of(u, result.state);
  return take(result) ? UpdateStatus::ok : UpdateStatus::not_finite;
}

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
inline Result<myogrowth_block_points> result_of(const MyogrowthBlock& block, int k) {
  constexpr int size = myogrowth_block_points;
  Result<size> r{block.stress + k, block.tangent + k, block.scalars[k + 4 * size], {block.G_end[k]}};
  for (int i = 0; i < 4; ++i) r.state[1 + i] = block.scalars[k + size * i];
  for (int i = 0; i < 3; ++i) r.state[fibre_entry + i] = block.n0[k + size * i];
  return r;
}

/// Updates many points: in packs those that packs can take, the others one by one. read(i, F): copies F of
/// point i and returns its state. take(i, result): as update_alone's. refuse(i, status, text): point i has no
/// result; the text may be empty.
template <class Read, class Take, class Refuse>
void update_many(const Common& c, int n_points, const Read& read, const Take& take, const Refuse& refuse) {
  constexpr int size = myogrowth_block_points;
  double props[n_props];
  write(c.properties.material, props);
  const bool material_can = packs_can(c.properties.material, c.dt) && !c.properties.local_basis;
  MyogrowthBlock block;
  block.dt = c.dt;
  Text text;
  for (int first = 0, left = n_points; left > 0; first += size, left -= size) {
    const int count = left < size ? left : size;
    bool done[size] = {};
    for (int k = 0; k < count && material_can; ++k) {
      Start start;
      double F[9], unit[3] = {1, 0, 0};
      const double* state = read(first + k, F);
      done[k] = find_start(state, c.n_state, c.properties, start, text) == UpdateStatus::ok &&
                normalise(start.n0, unit) && packs_can(F, start.G);
      // Where it is not for packs, an undeformed point stands in its place.
      for (int i = 0; i < 9; ++i) block.F[k + size * i] = done[k] ? F[i] : i % 4 == 0 ? 1 : 0;
      for (int i = 0; i < 3; ++i) block.n0[k + size * i] = unit[i];
      block.G[k] = done[k] ? start.G : 1;
      block.lambda[k] = done[k] ? start.lambda : 1;
    }
    if (material_can) update_block()(props, count, c.measure, c.with_tangent, &block);
    for (int k = 0; k < count; ++k) {
      const int i = first + k;
      if (done[k] && block.check[k] == 0 && take(i, result_of(block, k))) continue;
      double F[9];
      const double* state = read(i, F);
      PointUpdate<double> u;
      const UpdateStatus status = update_alone(c, c.properties.material, u, F, state, text,
                                               [&](const auto& r) { return take(i, r); });
      if (status != UpdateStatus::ok) refuse(i, status, text);
    }
    if (left <= size) break;  // `first` must not pass the largest int
  }
}

}  // namespace abi
}  // namespace myogrowth

#endif
