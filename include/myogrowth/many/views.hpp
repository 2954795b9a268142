/// @file
/// The numbers of many points, wherever they lie, and the update of one of them.
///
/// Views say where component c of point i is; update_one reads point i, updates it by the scalar routines and
/// writes what is asked for. So a loop of one's own, or a device's thread (docs/gpu.md), needs no more than
///
///   using namespace myogrowth::batch;
///   Input in{soa(F, n), shared(n0), soa(G, n), shared(&dt)};
///   Output out{soa(stress, n), soa(G, n), soa(ddsdde, n)};
///   UpdateStatus status = update_one<Tangent::full>(material, i, in, out);
///
/// batch.hpp is the same by many points at once.
#ifndef MYOGROWTH_MANY_VIEWS_HPP
#define MYOGROWTH_MANY_VIEWS_HPP

#include <cstddef>

#include "../kernel.hpp"
#include "../measures.hpp"

namespace myogrowth {

/// The stress that is asked for, and the tangent that goes with it.
enum class Measure {
  cauchy,       ///< sigma, 6: 11 22 33 12 13 23; DDSDDE, 36
  first_piola,  ///< P, 9, column by column; dP/dF, 81 at (i + 3J) + 9 (k + 3L)
  second_piola  ///< S, 6; dS/dE, 36
};
/// How much of the tangent.
enum class Tangent {
  none,
  full,
  compact  ///< with Measure::cauchy: the 7 numbers of CompactTangent
};

/// The tangent in 7 numbers and the stress: enough to apply it or to write it out.
///
///   J DDSDDE:D = c1 tr(D) I + B D + D B + weight (f . D f) dtau/dG,   B = c2 b_e = J sigma - shift I,
///   dtau/dG = -(c1 I + 2 c2/G^2 f⊗f)/G  (+ J sigma/G with EnergyPer::grown_volume, where c1 and c2 count G
///   times)
template <class T>
struct CompactTangent {
  T f[3];    ///< deformed fibre F n0 [-]
  T weight;  ///< dG/dlambda/lambda [-]
  T shift;   ///< c1 ln(J_e) - c2 [stress]
  T G;       ///< sarcomere number [-]
  T J;       ///< volume ratio [-]

  /// DDSDDE[36] from the numbers and the Cauchy stress[6].
  template <class P>
  MYOGROWTH_FUNCTION void expand(const FibreGrowth<P>& material, const T stress[6], T ddsdde[36]) const {
    PointUpdate<T> u;
    const T one(Real<T>(1)), per_G = one / G;
    const bool grown = material.energy == EnergyPer::grown_volume;
    u.c1 = grown ? T(G * material.c1) : T(material.c1);
    u.c2 = grown ? T(G * material.c2) : T(material.c2);
    u.lambda = one;
    u.dG_dlambda = weight;
    for (int a = 0; a < 6; ++a) {
      const T tau = J * stress[a], ff = f[symmetric_row(a)] * f[symmetric_column(a)];
      u.be[a] = (a < 3 ? T(tau - shift) : tau) / u.c2;
      u.dtau_dG[a] = -(u.c2 + u.c2) * per_G * per_G * per_G * ff;
      if (a < 3) u.dtau_dG[a] = u.dtau_dG[a] - u.c1 * per_G;
      if (grown) u.dtau_dG[a] = u.dtau_dG[a] + tau * per_G;
    }
    for (int i = 0; i < 3; ++i) u.f[i] = f[i];
    spatial_modulus(u, ddsdde, T(one / J));
  }
};

/// Numbers of one kind of all points, `component` many each. Where component c of point i lies:
namespace batch {

/// One array per component, n (or more) apart.
template <class V>
struct Soa {
  V* data;           ///< component 0 of point 0
  std::ptrdiff_t n;  ///< how far components are apart
  /// @cond
  struct Place {
    V* data;
    std::ptrdiff_t n;
    MYOGROWTH_FUNCTION V* operator()(int c) const { return data + c * n; }
  };
  MYOGROWTH_FUNCTION Place from(std::ptrdiff_t i) const { return {data + i, n}; }
  /// @endcond
};
/// One point after the other, its components side by side.
template <class V, int components>
struct Aos {
  V* data;                           ///< component 0 of point 0
  std::ptrdiff_t step = components;  ///< how far points are apart
  /// @cond
  struct Place {
    V* data;
    MYOGROWTH_FUNCTION V* operator()(int c) const { return data + c; }
  };
  MYOGROWTH_FUNCTION Place from(std::ptrdiff_t i) const { return {data + i * step}; }
  /// @endcond
};
/// Blocks of `block` points, a multiple of a register's lanes; in a block one component after the other. The
/// fastest.
template <class V, int components, int block = 16>
struct Aosoa {
  V* data;  ///< component 0 of point 0
  /// @cond
  struct Place {
    V* data;
    MYOGROWTH_FUNCTION V* operator()(int c) const { return data + c * block; }
  };
  MYOGROWTH_FUNCTION Place from(std::ptrdiff_t i) const {
    const auto within = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(i) % block);  // (i >= 0)
    return {data + (i - within) * components + within};
  }
  /// @endcond
};
/// An output in such blocks that lies on cache lines (64 bytes) and is written past the caches: for more
/// points than caches hold. It saves the memory from reading what will be written over. Blocks of 16 or less.
template <class V, int components, int block = 16>
struct Streamed : Aosoa<V, components, block> {};
/// The same for all points.
template <class V>
struct Shared {
  V* data;  ///< component 0
  /// @cond
  struct Place {
    V* data;
    MYOGROWTH_FUNCTION V* operator()(int c) const { return data + c; }
  };
  MYOGROWTH_FUNCTION Place from(std::ptrdiff_t) const { return {data}; }
  /// @endcond
};
/// Not there: what would be written is not.
struct Absent {
  /// @cond
  struct Place {};
  /// @endcond
};

/// The views by their names, for pointers of any kind.
/// @{
template <class V>
MYOGROWTH_FUNCTION Soa<V> soa(V* data, std::ptrdiff_t n) {
  return {data, n};
}
template <int components, class V>
MYOGROWTH_FUNCTION Aos<V, components> aos(V* data, std::ptrdiff_t step = components) {
  return {data, step};
}
template <int components, int block = 16, class V = double>
MYOGROWTH_FUNCTION Aosoa<V, components, block> aosoa(V* data) {
  return {data};
}
template <int components, int block = 16, class V = double>
MYOGROWTH_FUNCTION Streamed<V, components, block> streamed(V* data) {
  return {{data}};
}
template <class V>
MYOGROWTH_FUNCTION Shared<V> shared(V* data) {
  return {data};
}
/// @}

/// Materials of points: that of point i is data[index[i]].
template <class V, class Index>
struct Materials {
  const FibreGrowth<V>* data;  ///< the materials
  const Index* index;          ///< which of them, for every point
};

/// What goes in: F (9, column by column), n0 (3, of any length > 0), G_n, dt [time]; and, for the
/// second-order step, lambda_n; for laws that are active (many/laws.hpp), the activation.
template <class F_, class N0, class G_, class Dt, class Lambda = Absent, class Activation = Absent>
struct Input {
  F_ F;                     ///< deformation gradient at the end of the step [-]
  N0 n0;                    ///< fibre [-]
  G_ G;                     ///< sarcomere number at the beginning [-]
  Dt dt;                    ///< length of the step [time]
  Lambda lambda{};          ///< total fibre stretch at the beginning [-]
  Activation activation{};  ///< from 0 to 1; not there: 0 [-]
};
/// @cond
template <class F_, class N0, class G_, class Dt>
Input(F_, N0, G_, Dt) -> Input<F_, N0, G_, Dt>;
template <class F_, class N0, class G_, class Dt, class Lambda>
Input(F_, N0, G_, Dt, Lambda) -> Input<F_, N0, G_, Dt, Lambda>;
template <class F_, class N0, class G_, class Dt, class Lambda, class Activation>
Input(F_, N0, G_, Dt, Lambda, Activation) -> Input<F_, N0, G_, Dt, Lambda, Activation>;
/// @endcond

/// What comes out: stress; G; tangent; and, if asked for, scalars (5): lambda_e, lambda, J, Je, psi. G may be
/// the place that G_n came from. Where a point has no result its G is as it was and the rest is NaN.
template <class Stress, class G_, class Tangent_ = Absent, class Scalars = Absent>
struct Output {
  Stress stress;       ///< in the measure asked for [stress]
  G_ G;                ///< sarcomere number at the end [-]
  Tangent_ tangent{};  ///< as much of it as asked for [stress]
  Scalars scalars{};   ///< lambda_e, lambda, J, Je [-], psi [stress]
};
/// @cond
template <class Stress, class G_>
Output(Stress, G_) -> Output<Stress, G_>;
template <class Stress, class G_, class Tangent_>
Output(Stress, G_, Tangent_) -> Output<Stress, G_, Tangent_>;
template <class Stress, class G_, class Tangent_, class Scalars>
Output(Stress, G_, Tangent_, Scalars) -> Output<Stress, G_, Tangent_, Scalars>;
/// @endcond

namespace detail {

template <class V, class View>
MYOGROWTH_FUNCTION V load_one(const View& view, int c, std::ptrdiff_t i) {
  return *view.from(i)(c);
}
template <class V>
MYOGROWTH_FUNCTION V load_one(Absent, int, std::ptrdiff_t) {
  return V(1);
}
template <class V, class View>
MYOGROWTH_FUNCTION void store_one(const View& view, int c, std::ptrdiff_t i, V x) {
  *view.from(i)(c) = x;
}
template <class V>
MYOGROWTH_FUNCTION void store_one(Absent, int, std::ptrdiff_t, V) {}

/// Components of a point that a view has room for, as far as its type says.
template <class View>
constexpr int room = 1000;
template <class V, int components>
constexpr int room<Aos<V, components>> = components;
template <class V, int components, int block>
constexpr int room<Aosoa<V, components, block>> = components;
template <class V, int components, int block>
constexpr int room<Streamed<V, components, block>> = components;

/// Refuses to compile views with room for fewer components than are read or written: those of another point,
/// or what lies behind the array, would take their place.
template <int n_stress, int n_tangent, class In, class Out>
MYOGROWTH_FUNCTION constexpr void demand_room(const In& in, const Out& out) {
  static_assert(room<std::decay_t<decltype(in.F)>> >= 9, "F has 9 components");
  static_assert(room<std::decay_t<decltype(in.n0)>> >= 3, "n0 has 3 components");
  static_assert(room<std::decay_t<decltype(out.stress)>> >= n_stress, "a stress has 6 components, P has 9");
  static_assert(room<std::decay_t<decltype(out.tangent)>> >= n_tangent,
                "a tangent has 36 components, dP/dF 81; a compact one 7, that of law 1 19");
  static_assert(room<std::decay_t<decltype(out.scalars)>> >= 5, "scalars has 5 components");
  (void)in, (void)out;
}

/// What writes c[k] = x to point i of a view.
template <class View>
struct Entries {
  View view;
  std::ptrdiff_t i;
  MYOGROWTH_FUNCTION auto& operator[](int c) const { return *view.from(i)(c); }
};

}  // namespace detail
}  // namespace batch

/// One step of point i of the views, by the scalar routines. Where it has no result its G is as it was and
/// the rest is NaN.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, class V, class In, class Out>
MYOGROWTH_FUNCTION MYOGROWTH_FLAT UpdateStatus update_one(const FibreGrowth<V>& material, std::ptrdiff_t i,
                                                          const In& in, const Out& out) {
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  using batch::detail::Entries;
  using batch::detail::load_one;
  using batch::detail::store_one;
  constexpr int n_stress = measure == Measure::first_piola ? 9 : 6;
  constexpr int n_tangent = tangent == Tangent::none      ? 0
                            : tangent == Tangent::compact ? 7
                                                          : n_stress * n_stress;
  batch::detail::demand_room<n_stress, n_tangent>(in, out);
  V F[9], n0[3];
  for (int c = 0; c < 9; ++c) F[c] = load_one<V>(in.F, c, i);
  for (int c = 0; c < 3; ++c) n0[c] = load_one<V>(in.n0, c, i);
  PointUpdate<V> u;
  update_point(material, F, n0, load_one<V>(in.G, 0, i), load_one<V>(in.lambda, 0, i),
               load_one<V>(in.dt, 0, i), u);

  store_one(out.G, 0, i, u.G);
  const V scalars[5] = {u.lambda_e, u.lambda, u.J, u.Je, u.psi};
  for (int k = 0; k < 5; ++k) store_one(out.scalars, k, i, scalars[k]);
  V stress[entries(n_stress)];
  if constexpr (measure == Measure::cauchy) cauchy_from_kirchhoff(u.J, u.tau, stress);
  if constexpr (measure == Measure::first_piola) first_piola_from_kirchhoff(F, u.tau, stress);
  if constexpr (measure == Measure::second_piola) second_piola_from_kirchhoff(F, u.tau, stress);
  for (int k = 0; k < n_stress; ++k) store_one(out.stress, k, i, stress[k]);

  // Of a point without a result everything is NaN, and what is made of it, zeros of the modulus included.
  if constexpr (tangent == Tangent::compact) {
    const V compact[7] = {u.f[0],
                          u.f[1],
                          u.f[2],
                          u.dG_dlambda / u.lambda,
                          u.tau[0] - u.c2 * u.be[0],
                          u.status == UpdateStatus::ok ? u.G : u.J,
                          u.J};
    for (int k = 0; k < 7; ++k) store_one(out.tangent, k, i, compact[k]);
  }
  if constexpr (tangent == Tangent::full) {
    const Entries<std::decay_t<decltype(out.tangent)>> to{out.tangent, i};
    if constexpr (measure == Measure::cauchy) {
      spatial_modulus(u, to, V(1) / u.J);
    } else {
      constexpr int n = measure == Measure::first_piola ? 81 : 36;
      V c[36], moduli[entries(n)];
      spatial_modulus(u, c);
      if constexpr (measure == Measure::first_piola) dP_dF_from_jaumann(F, u.tau, c, moduli);
      if constexpr (measure == Measure::second_piola) dS_dE_from_jaumann(F, u.tau, c, moduli);
      for (int k = 0; k < n; ++k) to[k] = moduli[k];
    }
  }
  return u.status;
}

}  // namespace myogrowth

#endif
