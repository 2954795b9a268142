/// @file
/// The update of many points at once: the law's own template with a SIMD pack as its scalar (simd.hpp).
///
/// Every point is one lane of a pack. A lane's result is the same bits wherever it stands and however many
/// points there are, and agrees with update_point to rounding. What a pack is not made for (removal, gamma <
/// 1, the second-order step, a step that Newton's method cannot take in its stride; a point without a result)
/// is done by the scalar routines, point by point.
///
///   myogrowth::batch::Input in{soa(F, n), shared(n0), soa(G, n), shared(&dt)};
///   myogrowth::batch::Output out{soa(stress, n), soa(G, n), soa(ddsdde, n)};
///   std::ptrdiff_t failed = update_batch<Tangent::full>(material, n, in, out);
///
/// Materials in the place of the material gives every point its own. Points are independent: give parts of
/// them to threads as you like. Compile with the target's flags (-mavx2 -mfma, -march=native, ...) and -O3;
/// contraction to fused multiply-adds is welcome.
#ifndef MYOGROWTH_BATCH_HPP
#define MYOGROWTH_BATCH_HPP

#include <utility>

#include "points.hpp"
#include "simd.hpp"

namespace myogrowth {

namespace batch {
namespace detail {

using namespace myogrowth::detail;
using namespace myogrowth::simd;

/// N points from point i on: packs read, p[c], and written, p[c] = x.
template <class V, int N, class View>
struct Points {
  typename View::Place at;
  Points(const View& view, std::ptrdiff_t i) : at(view.from(i)) {}
  Pack<V, N> load(int c) const { return Pack<V, N>::load(at(c)); }
  void store(int c, const Pack<V, N>& p) const { p.store(at(c)); }
};
template <class V, int N, class W, int components, int block>
struct Points<V, N, Aosoa<W, components, block>> {
  static_assert(block % N == 0, "a block must hold whole packs: choose N, or a longer block");
  typename Aosoa<W, components, block>::Place at;
  Points(const Aosoa<W, components, block>& view, std::ptrdiff_t i) : at(view.from(i)) {}
  Pack<V, N> load(int c) const { return Pack<V, N>::load(at(c)); }
  void store(int c, const Pack<V, N>& p) const { p.store(at(c)); }
};
template <class V, int N, class W, int components, int block>
struct Points<V, N, Streamed<W, components, block>> : Points<V, N, Aosoa<W, components, block>> {
  using Points<V, N, Aosoa<W, components, block>>::Points;
  void store(int c, const Pack<V, N>& p) const { p.stream(this->at(c)); }
};
template <class V, int N, class W>
struct Points<V, N, Shared<W>> {
  const W* data;
  Points(const Shared<W>& view, std::ptrdiff_t) : data(view.data) {}
  Pack<V, N> load(int c) const { return Pack<V, N>(data[c]); }
};
template <class V, int N, class W, int components>
struct Points<V, N, Aos<W, components>> {
  W* data;
  Points(const Aos<W, components>& view, std::ptrdiff_t i) : data(view.data + i * components) {}
  Pack<V, N> load(int c) const {
    Pack<V, N> p;
    for (int lane = 0; lane < N; ++lane) p.set(lane, data[lane * components + c]);
    return p;
  }
  void store(int c, const Pack<V, N>& p) const {
    for (int lane = 0; lane < N; ++lane) data[lane * components + c] = p[lane];
  }
};
template <class V, int N>
struct Points<V, N, None> {
  Points(None, std::ptrdiff_t) {}
  Pack<V, N> load(int) const { return Pack<V, N>(V(1)); }
  void store(int, const Pack<V, N>&) const {}
};

/// What writes c[k] = x into a view.
template <class V, int N, class View>
struct Writer {
  Points<V, N, View> points;
  struct Entry {
    const Points<V, N, View>& points;
    int c;
    void operator=(const Pack<V, N>& p) const { points.store(c, p); }
  };
  Entry operator[](int c) const { return {points, c}; }
};

template <class View>
constexpr bool is_streamed(const View&) {
  return false;
}
template <class V, int components, int block>
constexpr bool is_streamed(const Streamed<V, components, block>&) {
  return true;
}

/// What all packs of a batch have in common.
template <class V>
struct Common {
  const FibreGrowth<V>& material;
  const Exponent<V> to_gamma;
  const V per_time, per_width, per_crit;

  explicit Common(const FibreGrowth<V>& m)
      : material(m),
        to_gamma(m.growth.gamma),
        per_time(V(1) / m.growth.growth_time),
        per_width(V(1) / (m.growth.G_max - V(1))),
        per_crit(V(1) / m.growth.lambda_crit) {}
};

/// The start of a long step (growth_solve.hpp), lane by lane.
template <class V, int N>
Pack<V, N> long_step_start(const Common<V>& common, const Pack<V, N>& A, const Pack<V, N>& E,
                           const Pack<V, N>& lambda, const Pack<V, N>& G_n, const Pack<V, N>& room_n,
                           const Pack<V, N>& end) {
  using P = Pack<V, N>;
  const GrowthRate<V>& rate = common.material.growth;
  const P zero(V(0)), one(V(1)), crit(rate.lambda_crit);
  const P way = end - G_n, bound = E * end * way / A;
  const P q_end = lambda - crit * end, k_end = common.to_gamma(P((P(rate.G_max) - end) / room_n));
  P u = way;
  const auto tighten = [&u](const Mask<V, N>& there, const P& candidate) {
    u = select(there & (candidate < u), candidate, u);
  };
  tighten(q_end > zero, room_n * pow(P(bound / select(q_end > zero, q_end, one)), V(1) / rate.gamma));
  tighten(k_end > zero, bound / (crit * select(k_end > zero, k_end, one)));
  tighten(one > zero, room_n * pow(P(bound / (crit * room_n)), V(1) / (rate.gamma + V(1))));
  const P start = end - u * P(V(1) + 64 * std::numeric_limits<V>::epsilon());
  return select(start > G_n, start, G_n);
}

/// Backward Euler for the lanes that grow, gamma >= 1, as growth_solve.hpp has it. `left` are the lanes that
/// need the scalar routine.
template <class V, int N>
void grow_pack(const Common<V>& common, const Mask<V, N>& grows, const Pack<V, N>& G_n,
               const Pack<V, N>& lambda, const Pack<V, N>& dt, Pack<V, N>& G_end, Pack<V, N>& dG_dlambda,
               Mask<V, N>& left) {
  using P = Pack<V, N>;
  const GrowthRate<V>& rate = common.material.growth;
  const P zero(V(0)), one(V(1)), crit(rate.lambda_crit), limit(rate.G_max), gamma(rate.gamma);
  const P room_n = select(grows, limit - G_n, one), per_room = one / room_n;
  const P a = dt * P(common.per_time) * common.to_gamma(P(room_n * P(common.per_width)));
  // (Beyond all sense, but 1/a and what it multiplies would leave the normal range.)
  constexpr V epsilon = std::numeric_limits<V>::epsilon();
  const auto in_range = a < P(std::numeric_limits<V>::max() * epsilon * epsilon);
  P A = a, E = one;
  const auto steep = a > one;
  if (any(steep & grows)) {
    E = select(steep, one / a, one);
    A = select(steep, one, a);
  }
  P end = lambda * P(common.per_crit);
  end = select(end < limit, end, limit);
  // fourth_order_step, growth_solve.hpp
  const P g1 = gamma * per_room, g2 = g1 * (g1 - per_room) * P(V(0.5)),
          g3 = g2 * (g1 - (per_room + per_room)) * P(V(1.0 / 3));
  const auto step_from = [&](const P& G, const P& x, const P& k) {
    const P kq = k * (lambda - crit * G), kc = k * crit * x;
    const P f = kq - E * G * (G - G_n);
    const P b = (kc + E * (G + G - G_n) * x) + g1 * kq;
    const P a2 = (E * (x * x) - g1 * kc) - g2 * kq, a3 = g2 * kc + g3 * kq;
    return std::make_pair(x * f * (b * b + a2 * f), b * b * b + f * ((a2 + a2) * b + a3 * f));
  };
  const auto first = step_from(G_n, one, A);
  P G = G_n + rough_quotient(first.first, first.second);
  const auto is_long = grows & (A * (lambda - crit * G_n) > E * G_n * (end - G_n));
  G = select((G_n < G) & (G < end), G, G_n);

  // A lane that is done stays as it is, whatever its neighbours do.
  const P epsilon_(epsilon), gamma_plus_1(V(1) + rate.gamma);
  auto active = grows & !is_long, by_newton = is_long;
  for (int iteration = 0; iteration < 4 && any(active); ++iteration) {
    const P room = limit - G, x = room * per_room;
    const auto quotient = step_from(G, x, A * common.to_gamma(x));
    const P step = near_quotient(quotient.first, quotient.second);  // a last one is below 1e-4 G
    const P next = G + step, unit = next * room, s = step * (gamma_plus_1 * next + room);
    const auto inside = active & (G_n <= next) & (next <= end);
    G = select(inside, next, G);
    by_newton = by_newton | (active & !inside);
    active = inside & !(s * s * (s * step) < epsilon_ * next * (unit * unit * unit));
  }
  active = by_newton | active;
  if (any(active)) {  // Newton's method, from before the root
    P start = G_n;
    if (any(is_long)) start = select(is_long, long_step_start(common, A, E, lambda, G_n, room_n, end), G_n);
    G = select(active, select(start < end, start, end), G);
    constexpr int patience = 24;
    for (int iteration = 0; iteration < patience && any(active); ++iteration) {
      const P room = limit - G, x = room * per_room;
      const P k = A * common.to_gamma(x), kq = k * (lambda - crit * G);
      const P to_do = (kq - E * G * (G - G_n)) * x, slope = (E * (G + G - G_n) + k * crit) * x + g1 * kq;
      const P step =
          rough_quotient(to_do * G, slope * G + to_do);  // corrected by the next, or beyond all digits
      const P next = G + step;
      const auto onward = active & (next > G), inside = next < end;  // (not onward: rounding)
      G = select(onward, select(inside, next, end), G);
      active = onward & inside &
               !(step * step * (gamma_plus_1 * next + room) < P(epsilon / 4) * next * next * room);
    }
  }
  left = active | (grows & !in_range);

  G = select(G > G_n, G, G_n);
  G = select(G < end, G, end);
  const P room = limit - G;
  const P k = A * common.to_gamma(P(room * per_room));
  const P slope = (E * (G + G - G_n) + k * crit) * room + gamma * E * G * (G - G_n);
  const auto moves = grows & (room > zero) & (slope > zero);
  G_end = select(grows, select(room > zero, G, limit), G_n);
  dG_dlambda = select(moves, k * room / select(moves, slope, one), zero);
  dG_dlambda = select(dG_dlambda * crit > one, P(common.per_crit), dG_dlambda);
}

/// Apart, so that it does not weigh on the packs' code.
template <Tangent tangent, Measure measure, class V, class In, class Out>
MYOGROWTH_APART Status update_apart(const FibreGrowth<V>& material, std::ptrdiff_t i, const In& in,
                                    const Out& out) {
  return update_one<tangent, measure>(material, i, in, out);
}

/// N points from point i on, as one pack. Returns a bit for every lane that has to be done by update_one
/// instead.
template <Tangent tangent, Measure measure, int N, class V, class In, class Out>
MYOGROWTH_FLAT unsigned update_pack(const Common<V>& common, std::ptrdiff_t i, const In& in, const Out& out) {
  using P = Pack<V, N>;
  const FibreGrowth<V>& material = common.material;
  const Points<V, N, std::decay_t<decltype(in.F)>> F_in(in.F, i);
  const Points<V, N, std::decay_t<decltype(in.n0)>> n_in(in.n0, i);
  const Points<V, N, std::decay_t<decltype(in.G)>> G_in(in.G, i);
  const Points<V, N, std::decay_t<decltype(in.dt)>> dt_in(in.dt, i);
  const Points<V, N, std::decay_t<decltype(out.stress)>> stress_out(out.stress, i);
  const Points<V, N, std::decay_t<decltype(out.G)>> G_out(out.G, i);
  const Points<V, N, std::decay_t<decltype(out.tangent)>> tangent_out(out.tangent, i);
  const Points<V, N, std::decay_t<decltype(out.scalars)>> scalars_out(out.scalars, i);
  const P zero(V(0)), one(V(1));
  // (Not by a loop, which g++ would send through the stack, twice.)
  const P F[9] = {F_in.load(0), F_in.load(1), F_in.load(2), F_in.load(3), F_in.load(4),
                  F_in.load(5), F_in.load(6), F_in.load(7), F_in.load(8)};
  P n[3] = {n_in.load(0), n_in.load(1), n_in.load(2)};
  const P G_n = G_in.load(0), dt = dt_in.load(0);

  // As normalise() has it; a vector so short or long that its square is out of range is left to that.
  const P square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  const P rounding(4 * std::numeric_limits<V>::epsilon());
  const auto is_unit = (-rounding <= square - one) & (square - one <= rounding);
  if (any(!is_unit)) {
    const P per_length = select(is_unit, one, one / sqrt(square));
    for (int c = 0; c < 3; ++c) n[c] = n[c] * per_length;
  }
  auto bad = !((square > P(std::numeric_limits<V>::min() / std::numeric_limits<V>::epsilon())) &
               (square < P(std::numeric_limits<V>::max())) & (G_n > zero));

  Deformation<P> d;
  deform(F, n, d);
  PointUpdate<P> u;
  u.J = one + d.J_minus_1;
  u.lambda = d.lambda;
  for (int c = 0; c < 3; ++c) u.f[c] = d.f[c];
  bad = bad | !(u.J > zero);

  const auto steps = (dt > zero) & !bad;
  const auto grows =
      steps & (d.lambda > P(material.growth.lambda_crit) * G_n) & (G_n < P(material.growth.G_max));
  P G = G_n;
  u.dG_dlambda = zero;
  if (material.integration != TimeIntegration::backward_euler) {
    bad = bad | steps;  // whether it grows, and how, is a matter of lambda_n too
  } else if (any(grows)) {
    auto left = grows;
    if (material.growth.gamma >= 1) grow_pack(common, grows, G_n, d.lambda, dt, G, u.dG_dlambda, left);
    bad = bad | left;
  }
  if (material.removal.removal_time > 0) {
    bad = bad | (steps & !grows & (d.lambda < P(material.removal.lambda_crit) * G_n) &
                 (G_n > P(material.removal.G_min)));
  }
  stress(material, d, G, u);

  P check = u.tau[0];
  for (int c = 1; c < 6; ++c) check = check + u.tau[c];
  if (tangent != Tangent::none) {
    for (int c = 0; c < 6; ++c) check = check + u.dtau_dG[c] * u.dG_dlambda;
  }
  // Below, J_e - 1 may be -1 to rounding, where log1p is not made for it.
  const P least_Je(V(1e-6));
  bad = bad | !(check - check == zero) | !(dt - dt == zero) | !(u.J > least_Je * G);

  G_out.store(0, select(bad, G_n, G));
  const P scalars[5] = {u.lambda_e, u.lambda, u.J, u.Je, u.psi};
  for (int c = 0; c < 5; ++c) scalars_out.store(c, scalars[c]);
  const P factor = measure == Measure::cauchy ? one / u.J : one;
  if constexpr (measure == Measure::cauchy) {
    for (int c = 0; c < 6; ++c) stress_out.store(c, u.tau[c] * factor);
  } else {
    constexpr int n_stress = measure == Measure::first_piola ? 9 : 6;
    P host[n_stress];
    if constexpr (measure == Measure::first_piola) {
      first_piola_from_kirchhoff(F, u.tau, host);
    } else {
      second_piola_from_kirchhoff(F, u.tau, host);
    }
    for (int c = 0; c < n_stress; ++c) stress_out.store(c, host[c]);
  }
  if constexpr (tangent == Tangent::compact) {
    const P compact[7] = {u.f[0], u.f[1], u.f[2], u.dG_dlambda / u.lambda, u.tau[0] - u.c2 * u.be[0], G, u.J};
    for (int c = 0; c < 7; ++c) tangent_out.store(c, compact[c]);
  }
  if constexpr (tangent == Tangent::full && measure == Measure::cauchy) {
    spatial_modulus(u, Writer<V, N, std::decay_t<decltype(out.tangent)>>{tangent_out}, factor);
  }
  if constexpr (tangent == Tangent::full && measure != Measure::cauchy) {
    constexpr int n_moduli = measure == Measure::first_piola ? 81 : 36;
    P c[36], moduli[n_moduli];
    spatial_modulus(u, c, factor);
    if constexpr (measure == Measure::first_piola) {
      dP_dF_from_jaumann(F, u.tau, c, moduli);
    } else {
      dS_dE_from_jaumann(F, u.tau, c, moduli);
    }
    for (int k = 0; k < n_moduli; ++k) tangent_out.store(k, moduli[k]);
  }
  return bits(bad);
}

/// What a pack of fewer points than lanes reads and writes: arrays of its own, the last point repeated.
template <class V, int N, int components>
struct Padded {
  V data[N * components];
  Soa<V> view() { return {data, N}; }
  template <class View>
  void fill(const View& view, std::ptrdiff_t i, int points) {
    for (int c = 0; c < components; ++c) {
      for (int lane = 0; lane < N; ++lane)
        data[c * N + lane] = load_one<V>(view, c, i + (lane < points ? lane : points - 1));
    }
  }
  template <class View>
  void give(const View& view, std::ptrdiff_t i, int points) const {
    for (int c = 0; c < components; ++c) {
      for (int lane = 0; lane < points; ++lane) store_one(view, c, i + lane, data[c * N + lane]);
    }
  }
};

template <Tangent tangent, Measure measure>
constexpr int n_tangent = tangent == Tangent::compact       ? 7
                          : tangent == Tangent::none        ? 1
                          : measure == Measure::first_piola ? 81
                                                            : 36;

template <Tangent tangent, Measure measure, int N, class V, class In, class Out>
MYOGROWTH_APART unsigned update_padded(const Common<V>& common, std::ptrdiff_t i, int points, const In& in,
                                       const Out& out) {
  Padded<V, N, 9> F;
  Padded<V, N, 3> n0;
  Padded<V, N, 1> G, dt, lambda, G_end;
  F.fill(in.F, i, points);
  n0.fill(in.n0, i, points);
  G.fill(in.G, i, points);
  dt.fill(in.dt, i, points);
  lambda.fill(in.lambda, i, points);
  Padded<V, N, measure == Measure::first_piola ? 9 : 6> stress;
  Padded<V, N, n_tangent<tangent, measure>> moduli;
  Padded<V, N, 5> scalars;
  const Input<Soa<V>, Soa<V>, Soa<V>, Soa<V>, Soa<V>> padded_in{F.view(), n0.view(), G.view(), dt.view(),
                                                                lambda.view()};
  const Output<Soa<V>, Soa<V>, Soa<V>, Soa<V>> padded_out{stress.view(), G_end.view(), moduli.view(),
                                                          scalars.view()};
  const unsigned bad = update_pack<tangent, measure, N>(common, 0, padded_in, padded_out);
  stress.give(out.stress, i, points);
  G_end.give(out.G, i, points);
  if constexpr (tangent != Tangent::none) moduli.give(out.tangent, i, points);
  scalars.give(out.scalars, i, points);
  return bad & ~(~0u << points);
}

/// The points [first, last), of one material.
template <Tangent tangent, Measure measure, int lanes, class V, class In, class Out>
std::ptrdiff_t update_range(const FibreGrowth<V>& material, std::ptrdiff_t first, std::ptrdiff_t last,
                            const In& in, const Out& out) {
  const Common<V> common(material);
  std::ptrdiff_t failed = 0;
  for (std::ptrdiff_t i = first, next; i < last; i = next) {
    next = (i / lanes + 1) * lanes;  // whole packs lie within a block
    if (next > last) next = last;
    unsigned bad = next - i == lanes ? update_pack<tangent, measure, lanes>(common, i, in, out)
                                     : update_padded<tangent, measure, lanes>(
                                           common, i, static_cast<int>(next - i), in, out);
    for (int lane = 0; bad != 0; ++lane, bad >>= 1) {
      if (bad & 1) failed += update_one<tangent, measure>(material, i + lane, in, out) != Status::ok;
    }
  }
  if (is_streamed(out.stress) || is_streamed(out.G) || is_streamed(out.tangent)) fence();
  return failed;
}

}  // namespace detail
}  // namespace batch

/// One step of n points of one material. Returns how many have no result (det F <= 0, no fibre, G <= 0, or
/// not finite). N: the lanes of a pack, by default as many as the compiler's target has.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class In,
          class Out>
std::ptrdiff_t update_batch(const FibreGrowth<V>& material, std::ptrdiff_t n, const In& in, const Out& out) {
  constexpr int lanes = N > 0 ? N : 2 * simd::native_lanes<V>;
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  return batch::detail::update_range<tangent, measure, lanes>(material, 0, n, in, out);
}

/// The same for points of many materials. Every run of points of one material is done by packs of its own:
/// let the points of a material lie together.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class Index,
          class In, class Out>
std::ptrdiff_t update_batch(const batch::Materials<V, Index>& materials, std::ptrdiff_t n, const In& in,
                            const Out& out) {
  constexpr int lanes = N > 0 ? N : 2 * simd::native_lanes<V>;
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  std::ptrdiff_t failed = 0;
  for (std::ptrdiff_t first = 0, last; first < n; first = last) {
    const Index which = materials.index[first];
    for (last = first + 1; last < n && materials.index[last] == which;) ++last;
    failed +=
        batch::detail::update_range<tangent, measure, lanes>(materials.data[which], first, last, in, out);
  }
  return failed;
}

}  // namespace myogrowth

#endif
