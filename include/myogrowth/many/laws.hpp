/// @file
/// Many points of muscle with other elastic laws: update_batch as for FibreGrowth (batch.hpp).
///
///   FibreGrowthOf<Roehrle<>> muscle;
///   batch::Input in{soa(F, n), shared(n0), soa(G, n), shared(&dt), batch::Absent(), shared(&activation)};
///   update_batch<Tangent::full>(muscle, n, in, batch::Output{soa(stress, n), soa(G, n), soa(ddsdde, n)});
///
/// Law 1 goes in packs, in closed form. With b = b_e, m the direction of f = F n0, lambda_e and l as in
/// elastic/roehrle.hpp:
///
///   J DDSDDE = kappa I⊗I + 2 c01 (b⊗b - b⊙b) + (I∘A + A∘I) + k⊗(m⊗m)
///   A = tau + (c10 + 2 c01 - kappa ln J_e) I,   (b⊙b):D = b D b
///   k = (l dt/dl - 2 t) m⊗m + lambda dG/dlambda dtau/dG
///   -G dtau/dG = (2 lambda_e^2 (c10 + c01 I1) + l dt/dl) m⊗m + 2 c01 lambda_e^2 (b - m⊗bm - bm⊗m) + kappa I
///
/// b⊗b - b⊙b has the cofactors of b as its entries. For EnergyPer::grown_volume tau and the parameters count
/// G times, and dtau/dG has tau/G more. The other laws go point by point.
#ifndef MYOGROWTH_MANY_LAWS_HPP
#define MYOGROWTH_MANY_LAWS_HPP

#include "../elastic/fibre_growth_of.hpp"
#include "../elastic/roehrle.hpp"
#include "batch.hpp"

namespace myogrowth {

namespace detail {

/// A point of law 1 in closed form. c1 and c2 are kappa and c10 + 2 c01 - kappa ln J_e, G times for
/// grown_volume.
template <class T>
struct RoehrleUpdate : PointUpdate<T> {
  T activation, c01, m[3];
  T k[6];  ///< k above; the term with dG/dlambda included
};

/// All that follows from the deformation, det F (out.J) and the grown state, as stress() of FibreGrowth.
template <class T, class P>
MYOGROWTH_FUNCTION void stress(const FibreGrowthOf<Roehrle<P>, P>& material, const Deformation<T>& d,
                               const T& G, const T& per_G, const T& ln_Je, RoehrleUpdate<T>& out) {
  using V = Real<T>;
  const V one(1);
  const T two(V(2));
  const Roehrle<P>& law = material.elastic;
  const bool grown = material.energy == EnergyPer::grown_volume;
  const T scale = grown ? G : T(one), c10 = scale * law.c10, kappa = scale * law.kappa;
  const T pressure = kappa * ln_Je;
  out.G = G;
  out.lambda_e = d.lambda * per_G;
  out.Je = out.J * per_G;
  out.c01 = scale * law.c01;
  out.c1 = kappa;
  out.c2 = c10 + two * out.c01 - pressure;
  const T square = out.lambda_e * out.lambda_e;

  // b_e - I, as stress() of FibreGrowth has it.
  const T G_minus_1 = rounded(T(G - one)), square_minus_1 = G_minus_1 + G_minus_1 + G_minus_1 * G_minus_1;
  const T fe[3] = {quotient(d.f[0], G, per_G), quotient(d.f[1], G, per_G), quotient(d.f[2], G, per_G)};
  const T per_lambda = one / d.lambda;
  T B[6], M[6];
  for (int i = 0; i < 3; ++i) out.m[i] = d.f[i] * per_lambda;
  for (int c = 0; c < 6; ++c) {
    const int i = symmetric_row(c), j = symmetric_column(c);
    B[c] = d.b_minus_I[c] - square_minus_1 * (fe[i] * fe[j]);
    out.be[c] = c < 3 ? T(one + B[c]) : B[c];
    M[c] = out.m[i] * out.m[j];
  }
  const T trace = B[0] + B[1] + B[2], l = out.lambda_e / T(law.lambda_opt);
  const Curve<T> fibres = law.fibre_stress(l, out.activation);
  const T t = scale * fibres.f, slope = scale * (l * fibres.df);

  T bm[3];
  for (int i = 0; i < 3; ++i) {
    bm[i] = out.be[symmetric_index(i, 0)] * out.m[0] + out.be[symmetric_index(i, 1)] * out.m[1] +
            out.be[symmetric_index(i, 2)] * out.m[2];
  }
  const T along = two * square * (c10 + out.c01 * (trace + T(V(3)))) + slope, across = two * square * out.c01;
  const T of_fibre = slope - two * t, of_growth = d.lambda * out.dG_dlambda;
  T BB_trace(V(0));
  for (int c = 0; c < 6; ++c) {
    const int i = symmetric_row(c), j = symmetric_column(c);
    const T BB = B[symmetric_index(i, 0)] * B[symmetric_index(j, 0)] +
                 B[symmetric_index(i, 1)] * B[symmetric_index(j, 1)] +
                 B[symmetric_index(i, 2)] * B[symmetric_index(j, 2)];
    if (c < 3) BB_trace = BB_trace + BB;
    const T mooney = B[c] + trace * out.be[c] - BB;  // I1 b - b^2 - 2 I
    const T matrix = c10 * B[c] + out.c01 * mooney + t * M[c];
    out.tau[c] = c < 3 ? T(pressure + matrix) : matrix;
    const T rate = along * M[c] + across * (out.be[c] - out.m[i] * bm[j] - bm[i] * out.m[j]);
    const T dtau_dG = (c < 3 ? T(kappa + rate) : rate) * -per_G;
    out.dtau_dG[c] = grown ? T(dtau_dG + out.tau[c] * per_G) : dtau_dG;
    out.k[c] = of_fibre * M[c] + of_growth * out.dtau_dG[c];
  }
  // I2 - 3 = 2 tr(B) + (tr(B)^2 - B:B)/2. The energy of the fibres is added where it is asked for.
  const T I2_minus_3 = two * trace + (trace * trace - BB_trace) / two;
  out.psi =
      (c10 * (trace - two * ln_Je) + out.c01 * (I2_minus_3 - (two + two) * ln_Je) + pressure * ln_Je) / two;
}

/// The modulus from c1 = kappa, c01, c2, tau, b_e, m and k.
template <class T, class Array>
MYOGROWTH_FUNCTION void spatial_modulus(const RoehrleUpdate<T>& u, Array&& c, const T& factor) {
  using V = Real<T>;
  const T half = factor / T(V(2)), kappa = factor * u.c1, c01 = factor * u.c01;
  const T* b = u.be;
  const T C1 = c01 * (b[1] * b[2] - b[5] * b[5]), C2 = c01 * (b[0] * b[2] - b[4] * b[4]),
          C3 = c01 * (b[0] * b[1] - b[3] * b[3]), C12 = c01 * (b[4] * b[5] - b[3] * b[2]),
          C13 = c01 * (b[3] * b[5] - b[4] * b[1]), C23 = c01 * (b[3] * b[4] - b[0] * b[5]);
  const T A1 = half * (u.tau[0] + u.c2), A2 = half * (u.tau[1] + u.c2), A3 = half * (u.tau[2] + u.c2),
          h12 = half * u.tau[3], h13 = half * u.tau[4], h23 = half * u.tau[5];
  const T a12 = h12 + h12, a13 = h13 + h13, a23 = h23 + h23;
  T k[6];
  for (int i = 0; i < 6; ++i) k[i] = factor * u.k[i];
  const auto column = [&](int j, const T& e1, const T& e2, const T& e3, const T& e4, const T& e5,
                          const T& e6) {
    const T M = u.m[symmetric_row(j)] * u.m[symmetric_column(j)];
    c[6 * j] = e1 + k[0] * M, c[6 * j + 1] = e2 + k[1] * M, c[6 * j + 2] = e3 + k[2] * M;
    c[6 * j + 3] = e4 + k[3] * M, c[6 * j + 4] = e5 + k[4] * M, c[6 * j + 5] = e6 + k[5] * M;
  };
  const T D1 = C1 + C1, D2 = C2 + C2, D3 = C3 + C3, D12 = C12 + C12, D13 = C13 + C13, D23 = C23 + C23;
  // clang-format off
  column(0, kappa + (A1 + A1) + (A1 + A1), kappa + D3, kappa + D2, a12, a13, -D23);
  column(1, kappa + D3, kappa + (A2 + A2) + (A2 + A2), kappa + D1, a12, -D13, a23);
  column(2, kappa + D2, kappa + D1, kappa + (A3 + A3) + (A3 + A3), -D12, a13, a23);
  column(3, a12, a12, -D12, A1 + A2 - C3, h23 + C23, h13 + C13);
  column(4, a13, -D13, a13, h23 + C23, A1 + A3 - C2, h12 + C12);
  column(5, -D23, a23, a23, h13 + C13, h12 + C12, A2 + A3 - C1);
  // clang-format on
}
template <class T>
MYOGROWTH_FUNCTION void spatial_modulus(const RoehrleUpdate<T>& u, T c[36]) {
  spatial_modulus(u, c, T(Real<T>(1)));
}

}  // namespace detail

/// The tangent of law 1 in 19 numbers and the stress: enough to write it out. Names as above.
template <class T>
struct CompactRoehrleTangent {
  static constexpr int size = 19;  ///< numbers of it
  T m[3];                          ///< direction of the deformed fibre [-]
  T b[6];                          ///< elastic left Cauchy-Green tensor [-]
  T k[6];                          ///< k [stress]
  T kappa;                         ///< of the law; G times for EnergyPer::grown_volume [stress]
  T c01;                           ///< likewise [stress]
  T shift;                         ///< A - tau, of its diagonal [stress]
  T J;                             ///< volume ratio [-]

  /// DDSDDE[36] from the numbers and the Cauchy stress[6].
  MYOGROWTH_FUNCTION void expand(const T stress[6], T ddsdde[36]) const {
    detail::RoehrleUpdate<T> u;
    u.c1 = kappa, u.c01 = c01, u.c2 = shift;
    for (int i = 0; i < 3; ++i) u.m[i] = m[i];
    for (int i = 0; i < 6; ++i) u.be[i] = b[i], u.k[i] = k[i], u.tau[i] = J * stress[i];
    detail::spatial_modulus(u, ddsdde, T(Real<T>(1) / J));
  }
};

namespace batch {
namespace detail {

/// 0 where it is not there.
template <class V, class View>
V load_activation(const View& view, std::ptrdiff_t i) {
  return load_one<V>(view, 0, i);
}
template <class V>
V load_activation(Absent, std::ptrdiff_t) {
  return V(0);
}

#if defined(__GNUC__) && !defined(MYOGROWTH_NO_PACKS)
template <class P>
constexpr int n_lanes = P::width* P::parts;

template <class V>
struct InPacks<FibreGrowthOf<Roehrle<V>, V>> {
  using Material = FibreGrowthOf<Roehrle<V>, V>;
  static constexpr int n_compact = CompactRoehrleTangent<V>::size;
  template <class P>
  using Point = RoehrleUpdate<P>;
  template <class P, class In>
  static void take_activation(const In& in, std::ptrdiff_t i, Point<P>& u) {
    using View = std::decay_t<decltype(in.activation)>;
    u.activation = P(V(0));
    if constexpr (!std::is_same<View, Absent>::value)
      u.activation = Points<V, n_lanes<P>, View>(in.activation, i).load(0);
  }
  template <class P>
  static void add_energy(const Material& m, Point<P>& u) {
    P fibres;
    for (int lane = 0; lane < n_lanes<P>; ++lane) {
      const V energy = m.elastic.fibre_energy(V(u.lambda_e[lane] / m.elastic.lambda_opt), u.activation[lane]);
      fibres.set(lane, m.energy == EnergyPer::grown_volume ? u.G[lane] * energy : energy);
    }
    u.psi = u.psi + fibres;
  }
  template <class P>
  static void write_compact(const Point<P>& u, P* compact) {
    for (int i = 0; i < 3; ++i) compact[i] = u.m[i];
    for (int i = 0; i < 6; ++i) compact[3 + i] = u.be[i], compact[9 + i] = u.k[i];
    const P last[4] = {u.c1, u.c01, u.c2, u.J};
    for (int i = 0; i < 4; ++i) compact[15 + i] = last[i];
  }
};
#endif

/// The compact tangent from the general update; law 1 has one.
template <class V>
void write_compact(const FibreGrowthOf<Roehrle<V>, V>& material, const ElasticPointUpdate<V>& u,
                   const V& activation, CompactRoehrleTangent<V>& t) {
  const Roehrle<V>& law = material.elastic;
  const V scale = material.energy == EnergyPer::grown_volume ? u.G : V(1), l = u.lambda_e / law.lambda_opt;
  const Curve<V> fibres = law.fibre_stress(l, activation);
  t.kappa = scale * law.kappa, t.c01 = scale * law.c01, t.J = u.J;
  t.shift = scale * (law.c10 + 2 * law.c01 - law.kappa * std::log(u.Je));
  for (int i = 0; i < 3; ++i) t.m[i] = u.f[i] / u.lambda;
  for (int c = 0; c < 6; ++c) {
    t.b[c] = u.be[c];
    t.k[c] = scale * (l * fibres.df - 2 * fibres.f) * t.m[symmetric_row(c)] * t.m[symmetric_column(c)] +
             u.lambda * u.dG_dlambda * u.dtau_dG[c];
  }
}

}  // namespace detail
}  // namespace batch

/// One step of point i with any elastic law, by the scalar routines, as update_one of FibreGrowth.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, class Elastic, class V,
          class In, class Out>
UpdateStatus update_one(const FibreGrowthOf<Elastic, V>& material, std::ptrdiff_t i, const In& in,
                        const Out& out) {
  using namespace batch::detail;
  constexpr int n = measure == Measure::first_piola ? 9 : 6;
  constexpr int n_tangent = tangent == Tangent::none      ? 0
                            : tangent == Tangent::compact ? CompactRoehrleTangent<V>::size
                                                          : n * n;
  demand_room<n, n_tangent>(in, out);
  V F[9], n0[3];
  for (int c = 0; c < 9; ++c) F[c] = load_one<V>(in.F, c, i);
  for (int c = 0; c < 3; ++c) n0[c] = load_one<V>(in.n0, c, i);
  const V activation = load_activation<V>(in.activation, i);
  ElasticPointUpdate<V> u;
  update_point(material, F, n0, load_one<V>(in.G, 0, i), load_one<V>(in.lambda, 0, i),
               load_one<V>(in.dt, 0, i), u, activation);
  store_one(out.G, 0, i, u.G);
  const V scalars[5] = {u.lambda_e, u.lambda, u.J, u.Je, u.psi};
  for (int k = 0; k < 5; ++k) store_one(out.scalars, k, i, scalars[k]);
  V stress[entries(n)], c[36], moduli[entries(n * n)];
  if constexpr (measure == Measure::cauchy) cauchy_from_kirchhoff(u.J, u.tau, stress);
  if constexpr (measure == Measure::first_piola) first_piola_from_kirchhoff(F, u.tau, stress);
  if constexpr (measure == Measure::second_piola) second_piola_from_kirchhoff(F, u.tau, stress);
  for (int k = 0; k < n; ++k) store_one(out.stress, k, i, stress[k]);
  if constexpr (tangent == Tangent::compact) {
    CompactRoehrleTangent<V> t;
    write_compact(material, u, activation, t);
    const V last[4] = {t.kappa, t.c01, t.shift, t.J};
    for (int k = 0; k < 3; ++k) store_one(out.tangent, k, i, t.m[k]);
    for (int k = 0; k < 6; ++k)
      store_one(out.tangent, 3 + k, i, t.b[k]), store_one(out.tangent, 9 + k, i, t.k[k]);
    for (int k = 0; k < 4; ++k) store_one(out.tangent, 15 + k, i, last[k]);
  }
  if constexpr (tangent == Tangent::full) {
    spatial_modulus(u, c, measure == Measure::cauchy ? V(1) / u.J : V(1));
    if constexpr (measure == Measure::first_piola) dP_dF_from_jaumann(F, u.tau, c, moduli);
    if constexpr (measure == Measure::second_piola) dS_dE_from_jaumann(F, u.tau, c, moduli);
    for (int k = 0; k < n * n; ++k)
      store_one(out.tangent, k, i, measure == Measure::cauchy ? c[k] : moduli[k]);
  }
  return u.status;
}

/// One step of n points of one material, as update_batch of FibreGrowth. The compact tangent is
/// CompactRoehrleTangent; the other laws have none. N: as there.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class V, class In,
          class Out>
std::ptrdiff_t update_batch(const FibreGrowthOf<Roehrle<V>, V>& material, std::ptrdiff_t n, const In& in,
                            const Out& out) {
  static_assert(tangent != Tangent::compact || measure == Measure::cauchy, "the compact tangent is DDSDDE's");
  return batch::detail::update_range<tangent, measure, batch::detail::lanes<V, N, tangent, Out>, V>(
      material, 0, n, in, out);
}

/// The same with any other law: point by point.
template <Tangent tangent = Tangent::full, Measure measure = Measure::cauchy, int N = 0, class Elastic,
          class V, class In, class Out>
std::ptrdiff_t update_batch(const FibreGrowthOf<Elastic, V>& material, std::ptrdiff_t n, const In& in,
                            const Out& out) {
  static_assert(tangent != Tangent::compact, "this law has no compact tangent");
  std::ptrdiff_t failed = 0;
  for (std::ptrdiff_t i = 0; i < n; ++i)
    failed += update_one<tangent, measure>(material, i, in, out) != UpdateStatus::ok;
  return failed;
}

}  // namespace myogrowth

#endif
