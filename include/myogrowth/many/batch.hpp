/// @file
/// The update of many points at once: the law's own template with a SIMD pack as its scalar (pack.hpp).
///
/// Every point is one lane of a pack. A lane's result is the same bits wherever it stands and however many
/// points there are, and agrees with update_point to rounding. What a pack is not made for (a step that needs
/// bisection, or takes the flow through many panels; a point without a result) is done by the scalar
/// routines, point by point.
///
///   myogrowth::batch::Input in{soa(F, n), shared(n0), soa(G, n), shared(&dt)};
///   myogrowth::batch::Output out{soa(stress, n), soa(G, n), soa(ddsdde, n)};
///   std::ptrdiff_t failed = update_batch<Tangent::full>(material, n, in, out);
///
/// Materials in the place of the material gives every point its own. Points are independent: give parts of
/// them to threads as you like. Compile with the target's flags (-mavx2 -mfma, -march=native, ...) and -O3;
/// contraction to fused multiply-adds is welcome.
#ifndef MYOGROWTH_MANY_BATCH_HPP
#define MYOGROWTH_MANY_BATCH_HPP

#if defined(__clang__) && defined(__FAST_MATH__)
#error \
    "myogrowth/many/batch.hpp: clang's -ffast-math changes the results of packs; compile this file without it."
#endif

#include "views.hpp"

// Packs need the vector extensions of g++ and clang. Elsewhere, and where MYOGROWTH_NO_PACKS is defined, they
// are packs of one: update_one, point by point.
#if defined(__GNUC__) && !defined(MYOGROWTH_NO_PACKS)

#include <utility>

#include "pack.hpp"

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
  std::ptrdiff_t step;
  mutable Pack<V, N> waiting[4];  // to be written together with the next ones
  Points(const Aos<W, components>& view, std::ptrdiff_t i)
      : data(view.data + i * view.step), step(view.step) {}
  Pack<V, N> load(int c) const {
    Pack<V, N> p;
    for (int lane = 0; lane < N; ++lane) p.set(lane, data[lane * step + c]);
    return p;
  }
  /// Components come in their order. Four are written at once; the last four again, where fewer are left.
  void store(int c, const Pack<V, N>& p) const {
    if constexpr (turns<V, N> && components >= 4) {
      waiting[c % 4] = p;
      if (c % 4 == 3) {
        store_side_by_side(waiting, data + c - 3, step);
      } else if (c == components - 1) {
        const Pack<V, N> last[4] = {waiting[(c + 1) % 4], waiting[(c + 2) % 4], waiting[(c + 3) % 4], p};
        store_side_by_side(last, data + c - 3, step);
      }
    } else {
      for (int lane = 0; lane < N; ++lane) data[lane * step + c] = p[lane];
    }
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
constexpr bool is_streamed = false;
template <class V, int components, int block>
constexpr bool is_streamed<Streamed<V, components, block>> = true;
template <class Stress, class G, class Tangent, class Scalars>
constexpr bool is_streamed<Output<Stress, G, Tangent, Scalars>> =
    is_streamed<Stress> || is_streamed<G> || is_streamed<Tangent> || is_streamed<Scalars>;

/// What all packs of a batch have in common. Material: FibreGrowth<V>, or one that laws.hpp has packs of.
template <class V, class Material>
struct Common {
  const Material& material;
  const Branch<V, 1> growth;
  explicit Common(const Material& m) : material(m), growth(branch_of(m.growth)) {}
};

/// What the last stage needs to know of a material. laws.hpp has more of them.
template <class Material>
struct InPacks;
template <class V>
struct InPacks<FibreGrowth<V>> {
  static constexpr int n_compact = 7;  ///< numbers of the compact tangent
  template <class P>
  using Point = PointUpdate<P>;
  template <class P, class In>
  static void take_activation(const In&, std::ptrdiff_t, Point<P>&) {}
  template <class P>
  static void add_energy(const FibreGrowth<V>&, Point<P>&) {}
  template <class P>
  static void write_compact(const Point<P>& u, P* compact) {
    for (int i = 0; i < 3; ++i) compact[i] = u.f[i];
    compact[3] = u.dG_dlambda / u.lambda;
    compact[4] = u.tau[0] - u.c2 * u.be[0];
    compact[5] = u.G;
    compact[6] = u.J;
  }
};

/// An output that is written past the caches: register by register where that is a cache line.
template <class V, int N, class W, int components, int block>
struct Points<V, N, Streamed<W, components, block>> {
  static_assert(block % N == 0, "a block must hold whole registers: choose a smaller N, or a longer block");
  typename Aosoa<W, components, block>::Place at;
  Points(const Streamed<W, components, block>& view, std::ptrdiff_t i) : at(view.from(i)) {}
  void store(int c, const Pack<V, N>& p) const { p.stream(at(c)); }
};
constexpr int line_bytes = 64;

/// The registers of a pack by default. Fewer where a full tangent goes to memory line by line: shorter bursts
/// of stores take a fifth less time (docs/performance.md).
template <class V, Tangent tangent, class Out>
constexpr int registers_of_pack() {
  constexpr bool streams = is_streamed<Out>, by_lines = simd::native_lanes<V> * sizeof(V) == line_bytes;
  return streams && by_lines && tangent == Tangent::full ? 2 : 4;
}
template <class V, int N, Tangent tangent, class Out>
constexpr int lanes = N > 0 ? N : registers_of_pack<V, tangent, Out>() * simd::native_lanes<V>;

/// Where it goes otherwise: first into a buffer, for as many points as go through the stages together, and
/// from there line by line. For other outputs there is nothing to it.
template <class View, int width, int registers, class = void>
struct Stage {
  const View& view(const View& out, std::ptrdiff_t, std::ptrdiff_t) { return out; }
  void flush() const {}
};
template <class W, int components, int block, int width, int registers>
struct Stage<Streamed<W, components, block>, width, registers,
             std::enable_if_t<(width * sizeof(W) < line_bytes)>> {
  static_assert(block % width == 0,
                "a block must hold whole registers: choose a smaller N, or a longer block");
  struct View {
    Aosoa<W, components, block> blocks;
    std::ptrdiff_t first;
    using Place = typename Aosoa<W, components, block>::Place;
    Place from(std::ptrdiff_t i) const { return blocks.from(i - first); }
  };
  alignas(line_bytes) W buffer[entries(width * registers * components)];
  W* to = nullptr;
  std::ptrdiff_t count = 0;
  static constexpr int per_line = line_bytes / static_cast<int>(sizeof(W));
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
template <Tangent tangent, Measure measure, class Material, class In, class Out>
MYOGROWTH_NOINLINE UpdateStatus update_apart(const Material& material, std::ptrdiff_t i, const In& in,
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

/// Removal in the lanes that shrink. Not inlined, since few packs need it.
template <int N, class V, class Material>
MYOGROWTH_NOINLINE SolvedStep<Pack<V, N>> remove(const Material& m, Mask<V, N> shrinks, Pack<V, N> G_n,
                                                 Pack<V, N> lambda, Pack<V, N> dt) {
  return backward_euler(branch_of(m.growth, m.removal), shrinks, G_n, lambda, dt);
}

/// Growth in the lanes that few_steps has left. Not inlined, and from what is stored between the stages: so
/// the usual path keeps nothing in memory for it.
template <int N, class V, int width>
MYOGROWTH_NOINLINE void grow_further(const Branch<V, 1>& growth, Begun<V, width>* begun, Mask<V, N> up,
                                     Mask<V, N> left) {
  using P = Pack<V, N>;
  P lambda, G_n, dt;
  SolvedStep<P> found;
  found.x = found.y = P(V(0));
  found.left = left;
  found.iterations = 0;
  for (int k = 0; k < P::parts; ++k) {
    lambda.v[k] = begun[k].d.lambda.v[0];
    G_n.v[k] = begun[k].G_n.v[0];
    dt.v[k] = begun[k].dt.v[0];
    found.G.v[k] = begun[k].G.v[0];
    found.dG_dlambda.v[k] = begun[k].dG_dlambda.v[0];
  }
  found = solve_further(growth, up, G_n, lambda, dt, found);
  for (int k = 0; k < P::parts; ++k) {
    begun[k].G.v[0] = found.G.v[k];
    begun[k].dG_dlambda.v[0] = found.dG_dlambda.v[k];
    begun[k].bad.v[0] = begun[k].bad.v[0] | found.left.v[k];
  }
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
template <int N, class V, class Material, int width>
void grow(const Common<V, Material>& common, Begun<V, width>* begun) {
  using P = Pack<V, N>;
  const Material& material = common.material;
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
  P G = G_n, dG_dlambda = zero;
  Mask<V, N> unsolved = one < zero;
  const auto up = grows(material.growth, G_n, lambda, dt) & !bad;
  if (any(up)) {  // (where it does not grow G stays, and the slope is zero)
    const auto take = [&](const auto& step, Mask<V, N>& left) {
      G = step.G;
      dG_dlambda = step.dG_dlambda;
      left = left | step.left;
    };
    if (flows)
      take(follow(common.growth, up, G_n, lambda, dt), bad);
    else
      take(few_steps(common.growth, up, G_n, lambda, dt), unsolved);
  }
  if (material.removal.tau_rev > 0) {
    bad = bad | !is_finite(G_n);  // an infinite G would shrink to an ordinary one
    const auto down = shrinks(material.removal, G_n, lambda, dt) & !bad;
    if (any(down)) {
      const auto take = [&](const auto& step) {
        G = select(down, step.G, G);
        dG_dlambda = select(down, step.dG_dlambda, dG_dlambda);
        bad = bad | step.left;
      };
      if (flows)
        take(follow(branch_of(material.growth, material.removal), down, G_n, lambda, dt));
      else
        take(remove<N>(material, down, G_n, lambda, dt));
    }
  }
  if (flows) dG_dlambda = dG_dlambda * P(V(0.5));  // lambda here is the mean with that at the beginning
  for (int k = 0; k < P::parts; ++k) {
    begun[k].G.v[0] = G.v[k];
    begun[k].dG_dlambda.v[0] = dG_dlambda.v[k];
    begun[k].bad.v[0] = bad.v[k];
    J_minus_1.v[k] = begun[k].d.J_minus_1.v[0];
  }
  if (any(unsolved)) {
    grow_further<N>(common.growth, begun, up, unsolved);
    for (int k = 0; k < P::parts; ++k) G.v[k] = begun[k].G.v[0];
  }
  const P per_J = one / (one + J_minus_1), per_G = one / G;
  const P ln_Je = logarithm_of_Je(J_minus_1, G, per_G);
  for (int k = 0; k < P::parts; ++k) {
    begun[k].per_J.v[0] = per_J.v[k];
    begun[k].per_G.v[0] = per_G.v[k];
    begun[k].ln_Je.v[0] = ln_Je.v[k];
  }
}

/// f(0), f(1), ... f(n - 1), the numbers as types: for compilers that would not unroll a loop.
template <class F, int... i>
void for_each(const F& f, std::integer_sequence<int, i...>) {
  (f(std::integral_constant<int, i>()), ...);
}
template <int n, class F>
void for_each_of(const F& f) {
  for_each(f, std::make_integer_sequence<int, n>());
}

/// (s A^T)_ij for symmetric s[6] and A[9].
template <class T>
T times(const T s[6], int i, const T A[9], int j) {
  return s[symmetric_index(i, 0)] * A[j] + s[symmetric_index(i, 1)] * A[j + 3] +
         s[symmetric_index(i, 2)] * A[j + 6];
}

/// dP/dF or dS/dE of FibreGrowth, which measures.hpp makes from any modulus. With mu = c2 - c1 ln(J_e), and
/// the growth's part by the product rule, its pull-back is
///
///   dS_IJ/dE_KL = c1 C^-1_IJ C^-1_KL + mu (C^-1_IK C^-1_JL + C^-1_IL C^-1_JK) + weight X_IJ n_K n_L
///   dP_iJ/dF_kL = c1 F^-1_Ji F^-1_Lk + mu F^-1_Jk F^-1_Li + delta_ik (mu C^-1 + S)_JL + weight Y_iJ f_k n_L
///
/// where X = F^-1 dtau/dG F^-T, Y = dtau/dG F^-T, n = n0. inv: F^-1; stress: P or S. (A in the place of I,
/// which is a macro of C's.)
template <Measure measure, class P, class Array>
void pull_back(const PointUpdate<P>& u, const P inv[9], const P stress[9], const P& mu, Array&& moduli) {
  const P weight = u.dG_dlambda / u.lambda;
  P n[3], per_C[6];
  for (int A = 0; A < 3; ++A) n[A] = inv[A] * u.f[0] + inv[A + 3] * u.f[1] + inv[A + 6] * u.f[2];
  for (int a = 0; a < 6; ++a) {
    const int A = symmetric_row(a), J = symmetric_column(a);
    per_C[a] = inv[A] * inv[J] + inv[A + 3] * inv[J + 3] + inv[A + 6] * inv[J + 6];
  }
  if constexpr (measure == Measure::second_piola) {
    P X[6];
    push_symmetric(inv, u.dtau_dG, X);
    for_each_of<6>([&](auto col) {
      constexpr int K = symmetric_row(col), L = symmetric_column(col);
      const P w = weight * n[K] * n[L], c1 = u.c1 * per_C[col];
      for_each_of<6>([&](auto row) {
        constexpr int A = symmetric_row(row), J = symmetric_column(row);
        const P AK = per_C[symmetric_index(A, K)], JL = per_C[symmetric_index(J, L)];
        const P AL = per_C[symmetric_index(A, L)], JK = per_C[symmetric_index(J, K)];
        moduli[row + 6 * col] = c1 * per_C[row] + mu * (AK * JL + AL * JK) + X[row] * w;
      });
    });
  } else {
    P Y[9], mixed[6];
    for_each_of<9>([&](auto c) { Y[c] = times(u.dtau_dG, c % 3, inv, c / 3); });
    for (int a = 0; a < 6; ++a) {
      const int J = symmetric_row(a), L = symmetric_column(a);
      mixed[a] = mu * per_C[a] +
                 (inv[J] * stress[3 * L] + inv[J + 3] * stress[3 * L + 1] + inv[J + 6] * stress[3 * L + 2]);
    }
    for_each_of<9>([&](auto col) {
      constexpr int k = col % 3, L = col / 3;
      const P w = weight * u.f[k] * n[L], c1 = u.c1 * inv[L + 3 * k];
      for_each_of<9>([&](auto row) {
        constexpr int i = row % 3, J = row / 3;
        const P entry = c1 * inv[J + 3 * i] + mu * inv[J + 3 * k] * inv[L + 3 * i] + Y[row] * w;
        moduli[row + 9 * col] = i == k ? entry + mixed[symmetric_index(J, L)] : entry;
      });
    });
  }
}

/// The last stage: stress and tangent. Returns a bit for every lane that has to be done by update_one.
template <Tangent tangent, Measure measure, class Material, class V, int N, class In, class Out>
unsigned finish(const Material& material, const Begun<V, N>& b, const In& in, const Out& out,
                std::ptrdiff_t i) {
  using P = Pack<V, N>;
  const Points<V, N, std::decay_t<decltype(out.stress)>> stress_out(out.stress, i);
  const Points<V, N, std::decay_t<decltype(out.G)>> G_out(out.G, i);
  const Points<V, N, std::decay_t<decltype(out.tangent)>> tangent_out(out.tangent, i);
  const Points<V, N, std::decay_t<decltype(out.scalars)>> scalars_out(out.scalars, i);
  const P zero(V(0)), one(V(1));
  using Its = InPacks<Material>;
  typename Its::template Point<P> u;
  Its::template take_activation<P>(in, i, u);
  u.J = one + b.d.J_minus_1;
  u.lambda = b.d.lambda;
  u.dG_dlambda = b.dG_dlambda;
  for (int c = 0; c < 3; ++c) u.f[c] = b.d.f[c];
  stress(material, b.d, b.G, b.per_G, b.ln_Je, u);
  if constexpr (!std::is_same<std::decay_t<decltype(out.scalars)>, Absent>::value)
    Its::add_energy(material, u);

  // (If another component is infinite or NaN, one of these is too.)
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
    P compact[entries(Its::n_compact)];
    Its::write_compact(u, compact);
    for (int c = 0; c < Its::n_compact; ++c) tangent_out.store(c, compact[c]);
  }
  if constexpr (tangent == Tangent::full && measure == Measure::cauchy) {
    spatial_modulus(u, writer(tangent_out), factor);
  }
  if constexpr (measure != Measure::cauchy) {
    const Points<V, N, std::decay_t<decltype(in.F)>> F_in(in.F, i);
    P F[9], inv[9], cofactor[9];
    for (int c = 0; c < 9; ++c) F[c] = F_in.load(c);
    // By its own determinant, as measures.hpp's: J's rounding would count to its fourth power in dS/dE.
    const P per_det = P(V(1)) / cofactors(F, cofactor);
    for_each_of<9>([&](auto c) { inv[c] = cofactor[c / 3 + 3 * (c % 3)] * per_det; });
    P host[9];
    if constexpr (measure == Measure::first_piola) {
      for_each_of<9>([&](auto c) { host[c] = times(u.tau, c % 3, inv, c / 3); });
    } else {
      push_symmetric(inv, u.tau, host);
    }
    for (int c = 0; c < (measure == Measure::first_piola ? 9 : 6); ++c) stress_out.store(c, host[c]);
    if constexpr (tangent == Tangent::full) {
      if constexpr (std::is_same<Material, FibreGrowth<V>>::value) {
        pull_back<measure>(u, inv, host, u.c2 - u.c1 * b.ln_Je, writer(tangent_out));
      } else {
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
  }
  return bits(bad);
}

/// How many registers go through the stages together. Fewer where the memory has to take what comes out: it
/// then has less to take at once, and more to do meanwhile.
template <class V, int N, class Out>
constexpr int registers_at_once =
    Pack<V, N>::parts >= 8 || is_streamed<Out> ? Pack<V, N>::parts : 8 - 8 % Pack<V, N>::parts;

/// So many registers of points from point i on. Gives a bit of bad[register] for every lane that has to be
/// done by update_one instead. All go through one stage before the next: a point's operations wait for each
/// other, and the processor has those of other points to do meanwhile; and few numbers are needed at a time,
/// so that they stay in registers.
template <Tangent tangent, Measure measure, int N, class V, class Material, class In, class Out>
MYOGROWTH_FLAT void update_registers(const Common<V, Material>& common, std::ptrdiff_t i, int registers,
                                     const In& in, const Out& out, unsigned* bad) {
  constexpr int width = Pack<V, N>::width, parts = Pack<V, N>::parts;
  Begun<V, width> begun[registers_at_once<V, N, Out>];
  int begun_so_far = 0;
  do begin(in, i + begun_so_far * width, begun[begun_so_far]);
  while (++begun_so_far < registers);
  for (int k = registers; k % parts != 0; ++k) begun[k] = begun[0];  // to fill a pack
  for (int k = 0; k < registers; k += parts) grow<N>(common, begun + k);

  constexpr int most = registers_at_once<V, N, Out>;
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

template <Tangent tangent, Measure measure, class Material>
constexpr int n_tangent = tangent == Tangent::compact       ? InPacks<Material>::n_compact
                          : tangent == Tangent::none        ? 1
                          : measure == Measure::first_piola ? 81
                                                            : 36;

/// Fewer points than a register has, from point i on. Returns a bit for each that has to be done by
/// update_one.
template <Tangent tangent, Measure measure, int N, class V, class Material, class In, class Out>
MYOGROWTH_NOINLINE unsigned update_padded(const Common<V, Material>& common, std::ptrdiff_t i, int points,
                                          const In& in, const Out& out) {
  constexpr int width = Pack<V, N>::width;
  Padded<V, width, 9> F;
  Padded<V, width, 3> n0;
  Padded<V, width, 1> G, dt, lambda, activation, G_end;
  F.fill(in.F, i, points);
  n0.fill(in.n0, i, points);
  G.fill(in.G, i, points);
  dt.fill(in.dt, i, points);
  lambda.fill(in.lambda, i, points);
  if constexpr (std::is_same<std::decay_t<decltype(in.activation)>, Absent>::value) {
    for (V& a : activation.data) a = V(0);
  } else {
    activation.fill(in.activation, i, points);
  }
  Padded<V, width, measure == Measure::first_piola ? 9 : 6> stress;
  Padded<V, width, n_tangent<tangent, measure, Material>> moduli;
  Padded<V, width, 5> scalars;
  const Input<Soa<V>, Soa<V>, Soa<V>, Soa<V>, Soa<V>, Soa<V>> padded_in{
      F.view(), n0.view(), G.view(), dt.view(), lambda.view(), activation.view()};
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
template <Tangent tangent, Measure measure, int N, class V, class Material, class In, class Out>
std::ptrdiff_t update_range(const Material& material, std::ptrdiff_t first, std::ptrdiff_t last, const In& in,
                            const Out& out) {
  constexpr std::ptrdiff_t width = Pack<V, N>::width, most = registers_at_once<V, N, Out>;
  const Common<V, Material> common(material);
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
    unsigned some = bad[0];
    for (int k = 1; k < registers; ++k) some |= bad[k];
    if (is_streamed<Out> && some != 0) fence();  // what is written again comes last
    for (std::ptrdiff_t start = i; start < next && some != 0; start += width) {
      unsigned lanes = bad[(start - i) / width];
      for (std::ptrdiff_t point = start; lanes != 0; ++point, lanes >>= 1) {
        if (lanes & 1) failed += update_apart<tangent, measure>(material, point, in, out) != UpdateStatus::ok;
      }
    }
  }
  if (is_streamed<Out>) fence();
  return failed;
}

}  // namespace detail
}  // namespace batch
}  // namespace myogrowth

#else

namespace myogrowth {
namespace batch {
namespace detail {

template <class V, int N, Tangent, class>
constexpr int lanes = 1;

/// The points [first, last), of one material.
template <Tangent tangent, Measure measure, int N, class V, class Material, class In, class Out>
std::ptrdiff_t update_range(const Material& material, std::ptrdiff_t first, std::ptrdiff_t last, const In& in,
                            const Out& out) {
  std::ptrdiff_t failed = 0;
  for (std::ptrdiff_t i = first; i < last; ++i)
    failed += update_one<tangent, measure>(material, i, in, out) != UpdateStatus::ok;
  return failed;
}

}  // namespace detail
}  // namespace batch
}  // namespace myogrowth

#endif

namespace myogrowth {

/// One step of n points of one material. Returns how many have no result (det F <= 0, no fibre, G <= 0, or
/// not finite). N: the lanes of a pack, by default four registers of the compiler's target, two where a
/// full tangent is streamed line by line.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class In,
          class Out>
std::ptrdiff_t update_batch(const FibreGrowth<V>& material, std::ptrdiff_t n, const In& in, const Out& out) {
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  return batch::detail::update_range<tangent, measure, batch::detail::lanes<V, N, tangent, Out>, V>(
      material, 0, n, in, out);
}

/// The same for points of many materials. Every run of points of one material is done by packs of its own:
/// let the points of a material lie together.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class Index,
          class In, class Out>
std::ptrdiff_t update_batch(const batch::Materials<V, Index>& materials, std::ptrdiff_t n, const In& in,
                            const Out& out) {
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  std::ptrdiff_t failed = 0;
  for (std::ptrdiff_t first = 0, last; first < n; first = last) {
    const Index which = materials.index[first];
    for (last = first + 1; last < n && materials.index[last] == which;) ++last;
    failed += batch::detail::update_range<tangent, measure, batch::detail::lanes<V, N, tangent, Out>, V>(
        materials.data[which], first, last, in, out);
  }
  return failed;
}

}  // namespace myogrowth

#endif
