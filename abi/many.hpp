/// @file
/// The update of a host's points: in packs by the fastest batch of this machine, one by one where packs
/// cannot.
#ifndef MYOGROWTH_ABI_MANY_HPP
#define MYOGROWTH_ABI_MANY_HPP

#include <cstdint>
#include <myogrowth/more/left_stretch.hpp>
#include <new>

#include "block.hpp"
#include "elastic_laws.hpp"
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
  LawChoice law;
};

/// The row of a block where entry `e` of the state at the end is.
constexpr int row_of_state(int e) {
  return e < fibre_entry ? myogrowth_row_G_end + e * myogrowth_block_points
                         : myogrowth_row_n0 + (e - fibre_entry) * myogrowth_block_points;
}

/// What a step gives at one point, for the host to take, by the rows of a block; `step`: from one row to the
/// next.
struct Result {
  const double* column;
  std::ptrdiff_t step;
  double operator[](int row) const { return column[row / myogrowth_block_points * step]; }
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
  constexpr int size = myogrowth_block_points;
  double V[9], column[myogrowth_block_size / size], state_end[n_kept];
  double *stress = column + myogrowth_row_stress / size, *tangent = column + myogrowth_row_tangent / size;
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
  state_of(u, state_end);
  for (int e = 0; e < n_kept; ++e) column[row_of_state(e) / size] = state_end[e];
  column[myogrowth_row_psi / size] = u.psi;
  return take(Result{column, 1}) ? UpdateStatus::ok : UpdateStatus::not_finite;
}

/// The same by the law that PROPS ask for. field: field variable 1, read where PROPS(20) = -1.
template <class Number, class Take>
UpdateStatus update_alone(const Common& c, const double F[9], const double* state, Number field, Text& text,
                          const Take& take) {
  LawChoice law = c.law;
  if (law.by_field && find_field_fault(field, law, text)) return UpdateStatus::bad_state;
  return with_material(c.properties.material, law, [&](auto& u, const auto& material, const auto&... a) {
    return update_alone(c, material, u, F, state, text, take, a...);
  });
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

/// Whether packs may do it: they are not made for numbers so large or small that a product of a few is out of
/// range.
inline bool is_within(double x, double least, double most) {
  const double size = x < 0 ? -x : x;
  return size >= least && size <= most;
}
inline bool packs_can(const FibreGrowth<double>& m, double dt) {
  const GrowthRate<double>& g = m.growth;
  const RemovalRate<double>& r = m.removal;
  const bool removal = r.tau_rev == 0 || (is_within(r.tau_rev, 1e-30, 1e30) && r.gamma_rev <= 100 &&
                                          is_within(r.lambda_crit_rev, 1e-10, 1e10));
  return removal && is_within(m.c1, 0, 1e30) && is_within(m.c2, 1e-30, 1e30) &&
         is_within(g.tau, 1e-30, 1e30) && g.gamma <= 100 && is_within(g.G_max - 1, 1e-10, 1e10) &&
         is_within(g.lambda_crit, 1e-10, 1e10) && is_within(dt, 0, 1e30);
}

/// Updates the points [first, last): in packs those that packs can take, the others one by one.
///
/// Host has describe(block): says where all points come from and go to, if the batch may read and write them;
/// load(i, count, block): fills the rows of the block's points, from i on, that are not read so;
/// take(i, result): as update_alone's; finish(i, count): these have got their results; one(i, text): updates
/// point i by update_alone; refuse(i, status, text): it has no result, the text may be empty.
template <class Host>
void update_many(const Common& c, int first, int last, Host& host) {
  constexpr int size = myogrowth_block_points;
  const bool in_packs =
      packs_can(c.properties.material, c.dt) && !c.properties.local_basis && c.law.law == Law::neo_hookean;
  MyogrowthUpdateBlock* const update = update_block();
  constexpr std::size_t line = 64;  // (by hand: not every compiler can align the stack so)
  unsigned char memory[sizeof(MyogrowthBlock) + line];
  const std::size_t beyond = reinterpret_cast<std::uintptr_t>(memory) % line;
  MyogrowthBlock& block = *new (memory + (line - beyond)) MyogrowthBlock;
  block.dt = c.dt;
  block.stretch_is_checked =
      c.properties.material.integration == TimeIntegration::midpoint_flow || c.properties.tolerance > 0;
  block.is_known = block.is_given = false;
  block.n_in = block.n_out = 0;
  block.stress = block.tangent = -1;
  host.describe(block);
  for (int i = 0; i < 3; ++i) block.fibre[i] = c.properties.n0[i];
  Text text;
  for (int left = last - first; left > 0; first += size, left -= size) {
    const int count = left < size ? left : size;
    if (in_packs) {
      block.first = first;
      host.load(first, count, block);
      update(&c.properties.material, count, c.measure, c.with_tangent, &block);
    }
    if (block.is_given) host.finish(first, count);
    for (int k = 0; k < count && !block.is_given; ++k) {
      const int i = first + k;
      if (in_packs && block.number[myogrowth_row_check + k] == 0 &&
          host.take(i, Result{block.number + k, size}))
        continue;
      const UpdateStatus status = host.one(i, text);
      if (status != UpdateStatus::ok) host.refuse(i, status, text);
    }
    if (left <= size) break;  // `first` must not pass the largest int
  }
}

}  // namespace abi
}  // namespace myogrowth

#endif
