/// @file
/// The update of many points at once: the law's own template with a SIMD pack as its scalar (simd.hpp).
///
/// Every point is one lane of a pack. A lane's result is the same bits wherever it stands and however many
/// points there are, and agrees with update_point to rounding. What a pack is not made for (removal, gamma <
/// 1 with backward Euler, a step so long that it takes more than a few iterations; a point without a result)
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

/// Blocks are read and written by whole registers of N points.
template <int N, class View>
constexpr bool holds_registers(const View*) {
  return true;
}
template <int N, class V, int components, int block>
constexpr bool holds_registers(const Aosoa<V, components, block>*) {
  return block % N == 0;
}

/// N points from point i on, as a pack: component c is read and written.
template <class V, int N, class View>
struct Points {
  static_assert(holds_registers<N>(static_cast<View*>(nullptr)),
                "a block must hold whole registers: choose a smaller N, or a longer block");
  typename View::Place at;
  Points(const View& view, std::ptrdiff_t i) : at(view.from(i)) {}
  Pack<V, N> load(int c) const { return Pack<V, N>::load(at(c)); }
  void store(int c, const Pack<V, N>& p) const { p.store(at(c)); }
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
struct Points<V, N, Absent> {
  Points(Absent, std::ptrdiff_t) {}
  Pack<V, N> load(int) const { return Pack<V, N>(V(1)); }
  void store(int, const Pack<V, N>&) const {}
};

/// What writes c[k] = x into a view.
template <class V, int N, class View>
struct Writer {
  const Points<V, N, View>& points;
  struct Entry {
    const Points<V, N, View>& points;
    int c;
    void operator=(const Pack<V, N>& p) const { points.store(c, p); }
  };
  Entry operator[](int c) const { return {points, c}; }
};
template <class V, int N, class View>
Writer<V, N, View> writer(const Points<V, N, View>& points) {
  return {points};
}

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
Pack<V, N> long_step_start(const Common<V>& common, const Mask<V, N>& is_long, const Pack<V, N>& A,
                           const Pack<V, N>& E, const Pack<V, N>& lambda, const Pack<V, N>& G_n,
                           const Pack<V, N>& room_n, const Pack<V, N>& end) {
  using P = Pack<V, N>;
  const GrowthRate<V>& rate = common.material.growth;
  const P one(V(1)), crit(rate.lambda_crit);
  const P way = end - G_n, bound = E * end * way / select(is_long, A, one);
  const P q_end = lambda - crit * end, room_end = select(is_long, P(rate.G_max) - end, room_n);
  const P k_end = common.to_gamma(P(room_end / room_n));
  P u = way;
  const auto ratio = [&](const P& divisor) {  // 1 where that does not limit u
    const auto limits = is_long & (bound < divisor);
    return P(select(limits, bound, one) / select(limits, divisor, one));
  };
  u = minimum(P(room_n * pow(ratio(q_end), V(1) / rate.gamma)), u);
  u = u * ratio(crit * k_end * u);
  u = minimum(P(room_n * pow(ratio(crit * room_n), V(1) / (rate.gamma + V(1)))), u);
  const P start = end - u * P(V(1) + 64 * last_place<V>());
  return select(start > G_n, start, G_n);
}

/// Where an output goes that is written past the caches: first into a buffer, for as many points as go
/// through the stages together, and from there line by line. For other outputs there is nothing to it.
template <class View, int width, int registers>
struct Stage {
  const View& view(const View& out, std::ptrdiff_t, std::ptrdiff_t) { return out; }
  void flush() const {}
};
template <class W, int components, int block, int width, int registers>
struct Stage<Streamed<W, components, block>, width, registers> {
  static_assert(block % width == 0,
                "a block must hold whole registers: choose a smaller N, or a longer block");
  static constexpr int line = 64;  // bytes
  struct View {
    Aosoa<W, components, block> blocks;
    std::ptrdiff_t first;
    using Place = typename Aosoa<W, components, block>::Place;
    Place from(std::ptrdiff_t i) const { return blocks.from(i - first); }
  };
  alignas(line) W buffer[entries(width * registers * components)];
  W* to = nullptr;
  std::ptrdiff_t count = 0;
  static constexpr int per_line = line / static_cast<int>(sizeof(W));
  View view(const Streamed<W, components, block>& out, std::ptrdiff_t i, std::ptrdiff_t n) {
    const bool blocks = i % block == 0 && n % block == 0;
    const bool lines = i * components % per_line == 0 && n * components % per_line == 0;
    if (!blocks || !lines) return {{out.data}, 0};  // parts of them are written as usual
    to = out.data + i * components;
    count = n * components;
    return {{buffer}, i};
  }
  void flush() const {
    for (std::ptrdiff_t k = 0; k < count; k += per_line) Pack<W, per_line>::load(buffer + k).stream(to + k);
  }
};

/// Apart, so that it does not weigh on the packs' code.
template <Tangent tangent, Measure measure, class V, class In, class Out>
MYOGROWTH_APART UpdateStatus update_apart(const FibreGrowth<V>& material, std::ptrdiff_t i, const In& in,
                                          const Out& out) {
  return update_one<tangent, measure>(material, i, in, out);
}

/// What is known of a register's points between the stages of an update.
template <class V, int N>
struct Begun {
  Deformation<Pack<V, N>> d;
  Pack<V, N> G_n, dt, lambda_n, G, dG_dlambda, per_G, ln_Je, per_J;
  Mask<V, N> bad;  ///< has to be done by update_one
};

/// The scaled growth number a = dt k_g(G_n) of growth_solve.hpp: (A, E) = (a, 1) for a <= 1 and (1, 1/a)
/// beyond. Adds to `left` the lanes where a is so large that 1/a and what it multiplies leave the normal
/// range.
template <class V, int N>
void growth_number(const Common<V>& common, const Pack<V, N>& room_n, const Pack<V, N>& dt, Pack<V, N>& A,
                   Pack<V, N>& E, Mask<V, N>& left) {
  using P = Pack<V, N>;
  const P one(V(1));
  A = dt * P(common.per_time) * common.to_gamma(P(room_n * P(common.per_width)));
  E = one;
  const auto steep = A > one;
  if (any(steep)) {
    constexpr V epsilon = last_place<V>();
    left = left | !(A < P((std::numeric_limits<V>::max)() * epsilon * epsilon));
    E = one / select(steep, A, one);
    A = select(steep, one, A);
  }
}

/// Newton's method from before the root for the lanes `active` of `begun`, as growth_solve.hpp has it.
/// Returns those that it cannot take in its stride. Apart, for the few packs that need it.
template <int N, class V, int width>
MYOGROWTH_APART Mask<V, N> newton_pack(const Common<V>& common, Mask<V, N> active, Begun<V, width>* begun) {
  using P = Pack<V, N>;
  const GrowthRate<V>& rate = common.material.growth;
  const P zero(V(0)), one(V(1)), crit(rate.lambda_crit), limit(rate.G_max), gamma(rate.gamma);
  P lambda, G_n, dt, G, A, E;
  for (int k = 0; k < P::parts; ++k) {
    lambda.v[k] = begun[k].d.lambda.v[0];
    G_n.v[k] = begun[k].G_n.v[0];
    dt.v[k] = begun[k].dt.v[0];
    G.v[k] = begun[k].G.v[0];
  }
  const P room_n = select(active, limit - G_n, one), per_room = one / room_n;
  Mask<V, N> out_of_range = active;  // (which grow_pack knows)
  growth_number(common, room_n, P(select(active, dt, zero)), A, E, out_of_range);
  const P end = minimum(P(lambda * P(common.per_crit)), limit);
  const auto is_long = active & (A * (lambda - crit * G_n) > E * G_n * (end - G_n));
  P start = G_n;
  if (any(is_long))
    start = select(is_long, long_step_start(common, is_long, A, E, lambda, G_n, room_n, end), G_n);
  G = select(active, minimum(start, end), G);

  // A lane that is done stays as it is, whatever its neighbours do.
  constexpr V epsilon = last_place<V>();
  const P g1 = gamma * per_room, gamma_plus_1(V(1) + rate.gamma);
  constexpr int patience = 24;
  for (int iteration = 0; iteration < patience && any(active); ++iteration) {
    const P room = limit - G, x = select(active, room * per_room, one);
    const P k = A * common.to_gamma(x), kq = k * (lambda - crit * G);
    const P to_do = (kq - E * G * (G - G_n)) * x, slope = (E * (G + G - G_n) + k * crit) * x + g1 * kq;
    const P divisor = slope * G + to_do, divides = select(active & (divisor > zero), divisor, one);
    const P step = rough_quotient(to_do * G, divides);  // corrected by the next, or beyond all digits
    const P next = G + step;
    const auto onward = active & (next > G), inside = next < end;  // (not onward: rounding)
    G = select(onward, select(inside, next, end), G);
    active =
        onward & inside & !(step * step * (gamma_plus_1 * next + room) < P(epsilon / 4) * next * next * room);
  }
  for (int k = 0; k < P::parts; ++k) begun[k].G.v[0] = G.v[k];
  return active;
}

/// Backward Euler for the lanes that grow, gamma >= 1: G and dG/dlambda. `left` are the lanes that need the
/// scalar routine.
///
/// With y = (G - G_n)/r, r = G_max - G_n, the equation of growth_solve.hpp divided by r^2 has no parameter in
/// its derivatives but gamma:
///
///   E (alpha + y) y = (A/r) (1 - y)^gamma (Q - crit y),   alpha = G_n/r,  Q = (lambda - crit G_n)/r
///
/// Two steps of order four from y = 0 (fourth_order_step there) are mostly all it takes. They may lead
/// astray, but there is one root alone with y < 1 and alpha + y > 0. A lane that does not grow has A = 0, and
/// y = 0.
template <int N, class V, int width>
void grow_pack(const Common<V>& common, const Mask<V, N>& grows, const Pack<V, N>& G_n,
               const Pack<V, N>& lambda, const Pack<V, N>& dt, Begun<V, width>* begun, Pack<V, N>& G,
               Pack<V, N>& dG_dlambda, Mask<V, N>& left) {
  using P = Pack<V, N>;
  const GrowthRate<V>& rate = common.material.growth;
  const V c = rate.gamma;
  const P zero(V(0)), one(V(1)), crit(rate.lambda_crit), limit(rate.G_max), g1(c), g2(c * (c - 1) / 2),
      g3(c * (c - 1) * (c - 2) / 6);
  const P r = select(grows, limit - G_n, one), per_r = one / r;
  P A, E;
  growth_number(common, r, P(select(grows, dt, zero)), A, E, left);
  A = A * per_r;
  const P alpha = G_n * per_r, Q = (lambda - crit * G_n) * per_r;

  P y;
  {  // at y = 0
    const P f = A * Q, kc = A * crit, b = (E * alpha + kc) + g1 * f;
    const P a2 = (E - g1 * kc) - g2 * f, a3 = g2 * kc + g3 * f, b2 = b * b;
    y = rough_quotient(f * (b2 + a2 * f), b * b2 + f * ((a2 + a2) * b + a3 * f));
  }
  Mask<V, N> done;
  {
    const P x = maximum(one - y, zero), k = A * common.to_gamma(x), kq = k * (Q - crit * y),
            kc = k * crit * x;
    const P z = alpha + y, f = kq - E * z * y, b = (E * (z + y) * x + kc) + g1 * kq;
    const P a2 = (E * (x * x) - g1 * kc) - g2 * kq, a3 = g2 * kc + g3 * kq, b2 = b * b;
    const P step = near_quotient(x * f * (b2 + a2 * f), b * b2 + f * ((a2 + a2) * b + a3 * f));
    y = y + step;
    // What such a step leaves is well below C^3 step^4, C = (1 + gamma)/x + 1/(alpha + y) > 1/(alpha + y).
    const V enough = std::sqrt(std::sqrt(last_place<V>()));
    const P now = alpha + y;
    done = abs(P(step * (P(V(1) + c) * now + x))) < P(enough) * now * x;
    // (Else with a G_max in the thousands what is multiplied here would leave the range.)
    if constexpr (sizeof(V) < sizeof(double)) done = done & (alpha > P(V(1e-3)));
  }
  P x = one - y;
  const P end = minimum(P(lambda * P(common.per_crit)), limit);
  G = maximum(minimum(P(G_n + r * y), end), G_n);
  const auto active = grows & !done;
  if (any(active)) {
    for (int k = 0; k < P::parts; ++k) begun[k].G.v[0] = G.v[k];
    left = left | newton_pack<N>(common, active, begun);
    for (int k = 0; k < P::parts; ++k) G.v[k] = begun[k].G.v[0];
    G = maximum(minimum(G, end), G_n);
    y = select(active, (G - G_n) * per_r, y);
    x = select(active, (limit - G) * per_r, x);
  }

  const P k = A * common.to_gamma(x), z = alpha + y;
  const P slope = (E * (z + y) + k * crit) * x + g1 * (E * z * y);
  dG_dlambda = select(G < limit, minimum(k * x / slope, P(common.per_crit)), zero);
}

/// The flow of growth_flow.hpp at the stretch of the middle of the step, for the lanes that grow: G and
/// dG/dlambda of `begun`. Returns the lanes that are left to the scalar routine. Apart, as it takes ten times
/// what the stages around it take.
template <int N, class V, int width>
MYOGROWTH_APART Mask<V, N> flow_pack(const Common<V>& common, const Mask<V, N>& asked,
                                     Begun<V, width>* begun) {
  using P = Pack<V, N>;
  const GrowthRate<V>& rate = common.material.growth;
  const P zero(V(0)), one(V(1)), half(V(0.5)), crit(rate.lambda_crit), limit(rate.G_max), gamma(rate.gamma);
  P lambda, G_n, dt;
  for (int k = 0; k < P::parts; ++k) {
    lambda.v[k] = (begun[k].d.lambda.v[0] + begun[k].lambda_n.v[0]) * V(0.5);
    G_n.v[k] = begun[k].G_n.v[0];
    dt.v[k] = begun[k].dt.v[0];
  }
  const P reached = minimum(P(lambda * P(common.per_crit)), limit);
  const auto grows = asked & (reached > G_n);  // but for rounding, all that are asked for
  const P r = select(grows, limit - G_n, one), per_r = one / r;
  const P a = select(grows, dt, zero) * P(common.per_time) * common.to_gamma(P(r * P(common.per_width)));
  // (Of a lane that does not grow: a way of 1, so that nothing is divided by 0.)
  const P end = select(grows, reached, G_n + one), u_n = end - G_n;
  const P room_end = select(grows, limit - end, zero);
  const P q_end = select(grows & (end >= limit), lambda - crit * limit, zero);
  struct At {
    P u, g, kappa, q;
  };
  const auto at = [&](const P& w) {
    const P u = u_n * exp(P(-w));
    return At{u, end - u, common.to_gamma(P((room_end + u) * per_r)), q_end + crit * u};
  };
  const GaussRule<V> rule = gauss_rule<V>();
  const auto integrate = [&](const P& from, const P& length, P& time, P& sensitivity) {
    const P half_length = length * half, middle = from + half_length;
    time = sensitivity = zero;
    for (int i = 0; i < 10; ++i) {
      const At there = at(middle + half_length * P(i < 5 ? rule.point[i] : -rule.point[i - 5]));
      const P per_kappa_q = one / (there.kappa * there.q);
      const P f = P(rule.weight[i % 5]) * there.g * there.u * per_kappa_q;
      time = time + f;
      sensitivity = sensitivity + f * there.kappa * per_kappa_q;
    }
    time = time * half_length;
    sensitivity = sensitivity * half_length;
  };

  // The part of the first panel that it takes, from the series of the time to second order; or whole panels.
  const P q_n = q_end + crit * u_n, ahead = a * q_n / (G_n * u_n);
  const P growth = u_n / G_n + gamma * u_n * per_r + crit * u_n / q_n - one;
  const P panel(flow_panel(rate.gamma));
  P part = ahead / (one + half * growth * ahead), from = zero, to_go = a, before = zero;
  auto beyond = grows & !(part < panel * P(V(0.9)));
  part = select(beyond, panel, maximum(part, zero));
  constexpr int most_panels = 16;
  for (int i = 0; i < most_panels && any(beyond); ++i) {
    P time, sensitivity;
    integrate(from, panel, time, sensitivity);
    const auto passes = beyond & (time < to_go);
    part = select(beyond & !passes, panel * (to_go / time), part);
    to_go = select(passes, to_go - time, to_go);
    before = select(passes, before + sensitivity, before);
    from = select(passes, from + panel, from);
    beyond = passes;
  }

  // Newton's method.
  const P curvature = u_n / G_n + (gamma + P(V(4)));
  P sum = zero;
  auto active = grows & !beyond;
  for (int iteration = 0; iteration < 8 && any(active); ++iteration) {
    P time, sensitivity;
    integrate(from, part, time, sensitivity);
    const At here = at(from + part);
    const P speed = here.kappa * here.q / (here.g * here.u), step = (to_go - time) * speed;
    const P next = part + step;
    part = select(active, maximum(minimum(next, panel + panel), -panel),
                  part);  // (what leaves the panel is left)
    sum = select(active, sensitivity + step / (speed * here.q), sum);
    active = active & !(curvature * step * step < P(last_place<V>() / 4) * (from + next));
  }
  const At last = at(from + part);
  const P dG_dlambda = last.kappa * last.q / last.g * (before + sum) * half;
  const P G = maximum(minimum(P(G_n + (u_n - last.u)), end), G_n);
  for (int k = 0; k < P::parts; ++k) {
    begun[k].G.v[0] = select(grows, G, G_n).v[k];
    begun[k].dG_dlambda.v[0] = select(grows, dG_dlambda, zero).v[k];
  }
  // (From far below the end, u_n - u would cost G digits.)
  const auto within = (zero <= part) & (part <= panel) & (u_n < P(V(8)) * G_n);
  return asked & ((!grows) | beyond | active | (!within));
}

/// The first stage for the points from point i on: their deformation.
template <class V, int N, class In>
void begin(const In& in, std::ptrdiff_t i, Begun<V, N>& b) {
  using P = Pack<V, N>;
  const Points<V, N, std::decay_t<decltype(in.F)>> F_in(in.F, i);
  const Points<V, N, std::decay_t<decltype(in.n0)>> n_in(in.n0, i);
  const Points<V, N, std::decay_t<decltype(in.G)>> G_in(in.G, i);
  const Points<V, N, std::decay_t<decltype(in.dt)>> dt_in(in.dt, i);
  const Points<V, N, std::decay_t<decltype(in.lambda)>> lambda_in(in.lambda, i);
  const P zero(V(0)), one(V(1));
  // (Not by a loop, which g++ would send through the stack, twice.)
  const P F[9] = {F_in.load(0), F_in.load(1), F_in.load(2), F_in.load(3), F_in.load(4),
                  F_in.load(5), F_in.load(6), F_in.load(7), F_in.load(8)};
  P n[3] = {n_in.load(0), n_in.load(1), n_in.load(2)};
  b.G_n = G_in.load(0);
  b.dt = dt_in.load(0);
  b.lambda_n = lambda_in.load(0);

  // As normalise() has it; a vector so short or long that its square is out of range is left to that.
  const P square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  const auto is_unit = abs(square - one) <= P(4 * last_place<V>());
  auto has_fibre = is_unit;
  if (any(!is_unit)) {
    has_fibre = (square > P((std::numeric_limits<V>::min)() / last_place<V>())) &
                (square < P((std::numeric_limits<V>::max)()));
    const P per_length = select(is_unit, one, one / sqrt(square));
    for (int c = 0; c < 3; ++c) n[c] = n[c] * per_length;
  }
  deform(F, n, b.d);
  const P least = least_J_minus_1(b.d.b_minus_I[0], b.d.b_minus_I[1], b.d.b_minus_I[2]);
  b.bad = !opaque(has_fibre & (b.d.J_minus_1 > least) & (b.G_n > zero) & is_finite(b.dt));
}

/// The second stage, for as many registers as a pack has: what is a chain of operations that wait for each
/// other, the growth, the logarithm and the reciprocals.
template <int N, class V, int width>
void grow(const Common<V>& common, Begun<V, width>* begun) {
  using P = Pack<V, N>;
  const FibreGrowth<V>& material = common.material;
  P lambda, G_n, dt, J_minus_1;
  Mask<V, N> bad;
  for (int k = 0; k < P::parts; ++k) {
    lambda.v[k] = begun[k].d.lambda.v[0];
    G_n.v[k] = begun[k].G_n.v[0];
    dt.v[k] = begun[k].dt.v[0];
    bad.v[k] = begun[k].bad.v[0];
  }
  const P zero(V(0)), one(V(1));
  const bool flows = material.integration == TimeIntegration::midpoint_flow;
  if (flows) {
    P lambda_n;
    for (int k = 0; k < P::parts; ++k) lambda_n.v[k] = begun[k].lambda_n.v[0];
    bad = bad | !opaque(is_finite(lambda_n) & (lambda_n > P(V(0))));
    lambda = (lambda + lambda_n) * P(V(0.5));
  }
  const auto grows =
      (dt > zero) & (lambda > P(material.growth.lambda_crit) * G_n) & (G_n < P(material.growth.G_max)) & !bad;
  P G = G_n, dG_dlambda = zero;
  if (any(grows)) {
    if (flows) {
      bad = bad | flow_pack<N>(common, grows, begun);
      for (int k = 0; k < P::parts; ++k) {
        G.v[k] = begun[k].G.v[0];
        dG_dlambda.v[k] = begun[k].dG_dlambda.v[0];
      }
    } else if (material.growth.gamma >= 1) {
      grow_pack<N>(common, grows, G_n, lambda, dt, begun, G, dG_dlambda, bad);
    } else {
      bad = bad | grows;
    }
  }
  if (material.removal.removal_time > 0) {
    bad = bad | ((dt > zero) & (lambda < P(material.removal.lambda_crit) * G_n) &
                 (G_n > P(material.removal.G_min)));
  }
  for (int k = 0; k < P::parts; ++k) {
    begun[k].G.v[0] = G.v[k];
    begun[k].dG_dlambda.v[0] = dG_dlambda.v[k];
    begun[k].bad.v[0] = bad.v[k];
    J_minus_1.v[k] = begun[k].d.J_minus_1.v[0];
  }
  const P per_J = one / (one + J_minus_1), per_G = one / G;
  const P ln_Je = logarithm_of_Je(J_minus_1, G, per_G);
  for (int k = 0; k < P::parts; ++k) {
    begun[k].per_J.v[0] = per_J.v[k];
    begun[k].per_G.v[0] = per_G.v[k];
    begun[k].ln_Je.v[0] = ln_Je.v[k];
  }
}

/// The last stage: stress and tangent. Returns a bit for every lane that has to be done by update_one.
template <Tangent tangent, Measure measure, class V, int N, class In, class Out>
unsigned finish(const FibreGrowth<V>& material, const Begun<V, N>& b, const In& in, const Out& out,
                std::ptrdiff_t i) {
  using P = Pack<V, N>;
  const Points<V, N, std::decay_t<decltype(out.stress)>> stress_out(out.stress, i);
  const Points<V, N, std::decay_t<decltype(out.G)>> G_out(out.G, i);
  const Points<V, N, std::decay_t<decltype(out.tangent)>> tangent_out(out.tangent, i);
  const Points<V, N, std::decay_t<decltype(out.scalars)>> scalars_out(out.scalars, i);
  const P zero(V(0)), one(V(1));
  PointUpdate<P> u;
  u.J = one + b.d.J_minus_1;
  u.lambda = b.d.lambda;
  u.dG_dlambda = b.dG_dlambda;
  for (int c = 0; c < 3; ++c) u.f[c] = b.d.f[c];
  stress(material, b.d, b.G, b.per_G, b.ln_Je, u);

  // (What is beyond all numbers in the other components is in these.)
  P check = u.tau[0] + u.tau[1] + u.tau[2];
  if (tangent != Tangent::none) {
    check = check + (u.dtau_dG[0] + u.dtau_dG[1] + u.dtau_dG[2]) * u.dG_dlambda;
  }
  // Below, J_e - 1 may be -1 to rounding, where log1p is not made for it.
  const P least_Je(V(1e-6));
  const auto bad = b.bad | !is_finite(check) | !(u.J > least_Je * b.G);

  G_out.store(0, select(bad, b.G_n, b.G));
  const P scalars[5] = {u.lambda_e, u.lambda, u.J, u.Je, u.psi};
  for (int c = 0; c < 5; ++c) scalars_out.store(c, scalars[c]);
  const P factor = measure == Measure::cauchy ? b.per_J : one;
  if constexpr (measure == Measure::cauchy) {
    for (int c = 0; c < 6; ++c) stress_out.store(c, u.tau[c] * factor);
  }
  if constexpr (tangent == Tangent::compact) {
    const P compact[7] = {u.f[0], u.f[1], u.f[2], u.dG_dlambda / u.lambda, u.tau[0] - u.c2 * u.be[0],
                          u.G,    u.J};
    for (int c = 0; c < 7; ++c) tangent_out.store(c, compact[c]);
  }
  if constexpr (tangent == Tangent::full && measure == Measure::cauchy) {
    spatial_modulus(u, writer(tangent_out), factor);
  }
  if constexpr (measure != Measure::cauchy) {
    const Points<V, N, std::decay_t<decltype(in.F)>> F_in(in.F, i);
    P F[9];
    for (int c = 0; c < 9; ++c) F[c] = F_in.load(c);
    constexpr int n_stress = measure == Measure::first_piola ? 9 : 6;
    P host[entries(n_stress)];
    if constexpr (measure == Measure::first_piola) {
      first_piola_from_kirchhoff(F, u.tau, host);
    } else {
      second_piola_from_kirchhoff(F, u.tau, host);
    }
    for (int c = 0; c < n_stress; ++c) stress_out.store(c, host[c]);
    if constexpr (tangent == Tangent::full) {
      constexpr int n_moduli = measure == Measure::first_piola ? 81 : 36;
      P c[36], moduli[entries(n_moduli)];
      spatial_modulus(u, c, factor);
      if constexpr (measure == Measure::first_piola) {
        dP_dF_from_jaumann(F, u.tau, c, moduli);
      } else {
        dS_dE_from_jaumann(F, u.tau, c, moduli);
      }
      for (int a = 0; a < n_moduli; ++a) tangent_out.store(a, moduli[a]);
    }
  }
  return bits(bad);
}

/// How many registers go through the stages together.
template <class V, int N>
constexpr int registers_at_once = Pack<V, N>::parts < 8 ? 8 - 8 % Pack<V, N>::parts : Pack<V, N>::parts;

/// So many registers of points from point i on. Gives a bit of bad[register] for every lane that has to be
/// done by update_one instead. All go through one stage before the next: a point's operations wait for each
/// other, and the processor has those of other points to do meanwhile; and few numbers are needed at a time,
/// so that they stay in registers.
template <Tangent tangent, Measure measure, int N, class V, class In, class Out>
MYOGROWTH_FLAT void update_registers(const Common<V>& common, std::ptrdiff_t i, int registers, const In& in,
                                     const Out& out, unsigned* bad) {
  constexpr int width = Pack<V, N>::width, parts = Pack<V, N>::parts;
  Begun<V, width> begun[registers_at_once<V, N>];
  int begun_so_far = 0;
  do begin(in, i + begun_so_far * width, begun[begun_so_far]);
  while (++begun_so_far < registers);
  for (int k = registers; k % parts != 0; ++k) begun[k] = begun[0];  // to fill a pack
  for (int k = 0; k < registers; k += parts) grow<N>(common, begun + k);

  constexpr int most = registers_at_once<V, N>;
  const std::ptrdiff_t points = registers * width;
  Stage<std::decay_t<decltype(out.stress)>, width, most> stress;
  Stage<std::decay_t<decltype(out.G)>, width, most> G;
  Stage<std::decay_t<decltype(out.tangent)>, width, most> moduli;
  Stage<std::decay_t<decltype(out.scalars)>, width, most> scalars;
  const Output to{stress.view(out.stress, i, points), G.view(out.G, i, points),
                  moduli.view(out.tangent, i, points), scalars.view(out.scalars, i, points)};
  for (int k = 0; k < registers; ++k)
    bad[k] = finish<tangent, measure>(common.material, begun[k], in, to, i + k * width);
  stress.flush();
  G.flush();
  moduli.flush();
  scalars.flush();
}

/// What a register of fewer points than lanes reads and writes: arrays of its own, the last point repeated.
template <class V, int N, int components>
struct Padded {
  V data[entries(N * components)];
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

/// Fewer points than a register has, from point i on. Returns a bit for each that has to be done by
/// update_one.
template <Tangent tangent, Measure measure, int N, class V, class In, class Out>
MYOGROWTH_APART unsigned update_padded(const Common<V>& common, std::ptrdiff_t i, int points, const In& in,
                                       const Out& out) {
  constexpr int width = Pack<V, N>::width;
  Padded<V, width, 9> F;
  Padded<V, width, 3> n0;
  Padded<V, width, 1> G, dt, lambda, G_end;
  F.fill(in.F, i, points);
  n0.fill(in.n0, i, points);
  G.fill(in.G, i, points);
  dt.fill(in.dt, i, points);
  lambda.fill(in.lambda, i, points);
  Padded<V, width, measure == Measure::first_piola ? 9 : 6> stress;
  Padded<V, width, n_tangent<tangent, measure>> moduli;
  Padded<V, width, 5> scalars;
  const Input<Soa<V>, Soa<V>, Soa<V>, Soa<V>, Soa<V>> padded_in{F.view(), n0.view(), G.view(), dt.view(),
                                                                lambda.view()};
  const Output<Soa<V>, Soa<V>, Soa<V>, Soa<V>> padded_out{stress.view(), G_end.view(), moduli.view(),
                                                          scalars.view()};
  unsigned bad;
  update_registers<tangent, measure, N>(common, 0, 1, padded_in, padded_out, &bad);
  stress.give(out.stress, i, points);
  G_end.give(out.G, i, points);
  if constexpr (tangent != Tangent::none) moduli.give(out.tangent, i, points);
  scalars.give(out.scalars, i, points);
  return bad & ~(~0u << points);
}

/// The points [first, last), of one material.
template <Tangent tangent, Measure measure, int N, class V, class In, class Out>
std::ptrdiff_t update_range(const FibreGrowth<V>& material, std::ptrdiff_t first, std::ptrdiff_t last,
                            const In& in, const Out& out) {
  constexpr std::ptrdiff_t width = Pack<V, N>::width, most = registers_at_once<V, N>;
  const Common<V> common(material);
  std::ptrdiff_t failed = 0;
  for (std::ptrdiff_t i = first, next; i < last; i = next) {
    unsigned bad[entries(most)];
    const std::ptrdiff_t whole = i % width == 0 ? (last - i) / width : 0;  // a register lies within a block
    const int registers = static_cast<int>(whole < most ? whole : most);
    if (registers > 0) {
      next = i + registers * width;
      update_registers<tangent, measure, N>(common, i, registers, in, out, bad);
    } else {
      next = (i / width + 1) * width;
      if (next > last) next = last;
      bad[0] = update_padded<tangent, measure, N>(common, i, static_cast<int>(next - i), in, out);
    }
    for (std::ptrdiff_t start = i; start < next; start += width) {
      unsigned lanes = bad[(start - i) / width];
      for (std::ptrdiff_t point = start; lanes != 0; ++point, lanes >>= 1) {
        if (lanes & 1) failed += update_apart<tangent, measure>(material, point, in, out) != UpdateStatus::ok;
      }
    }
  }
  if (is_streamed(out.stress) || is_streamed(out.G) || is_streamed(out.tangent)) fence();
  return failed;
}

}  // namespace detail
}  // namespace batch

/// One step of n points of one material. Returns how many have no result (det F <= 0, no fibre, G <= 0, or
/// not finite). N: the lanes of a pack, by default four registers of the compiler's target.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class In,
          class Out>
std::ptrdiff_t update_batch(const FibreGrowth<V>& material, std::ptrdiff_t n, const In& in, const Out& out) {
  constexpr int lanes = N > 0 ? N : 4 * simd::native_lanes<V>;
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  return batch::detail::update_range<tangent, measure, lanes>(material, 0, n, in, out);
}

/// The same for points of many materials. Every run of points of one material is done by packs of its own:
/// let the points of a material lie together.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class Index,
          class In, class Out>
std::ptrdiff_t update_batch(const batch::Materials<V, Index>& materials, std::ptrdiff_t n, const In& in,
                            const Out& out) {
  constexpr int lanes = N > 0 ? N : 4 * simd::native_lanes<V>;
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
