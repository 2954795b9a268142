// The example's points in a structure of arrays, one time step of a point, and the difference of two results.
// Host and device compile the same code; nothing here is specific to CUDA.
#ifndef MYOGROWTH_EXAMPLES_MANY_POINTS_HPP
#define MYOGROWTH_EXAMPLES_MANY_POINTS_HPP

#include <cmath>
#include <cstddef>
#include <myogrowth/many/views.hpp>
#include <random>
#include <vector>

namespace many_points {

using namespace myogrowth;

/// Numbers of the tangent per point.
constexpr int tangent_size(Tangent tangent) { return tangent == Tangent::full ? 36 : 7; }
/// Numbers per point that a step reads (F, n0, G) and writes (stress, G, tangent); dt is the same for all.
constexpr int traffic(Tangent tangent) { return 9 + 3 + 1 + 6 + 1 + tangent_size(tangent); }

/// Addresses of the arrays, on host or device; component c of point i is at [c n + i].
template <class V>
struct Arrays {
  std::ptrdiff_t n;
  const V *F, *n0, *G_n, *dt;
  V *stress, *G, *tangent;
};

/// One step of point i.
template <Tangent tangent, class V>
MYOGROWTH_FUNCTION MYOGROWTH_FLAT UpdateStatus step(const FibreGrowth<V>& material, const Arrays<V>& a,
                                                    std::ptrdiff_t i) {
  using batch::soa;
  const batch::Input in{soa(a.F, a.n), soa(a.n0, a.n), soa(a.G_n, a.n), batch::shared(a.dt)};
  const batch::Output out{soa(a.stress, a.n), soa(a.G, a.n), soa(a.tangent, a.n)};
  return update_one<tangent>(material, i, in, out);
}

/// Input: stretched fibres of all directions, about three in four of which grow.
template <class V>
struct Inputs {
  std::vector<V> F, n0, G_n, dt;

  explicit Inputs(std::size_t n) : F(9 * n), n0(3 * n), G_n(n), dt(1, V(0.1)) {
    std::mt19937_64 random(20240607);
    std::uniform_real_distribution<double> between(-1, 1);
    for (std::size_t i = 0; i < n; ++i) {
      double a[3], square = 0;
      for (double& x : a) x = between(random), square += x * x;
      for (std::size_t c = 0; c < 3; ++c) n0[c * n + i] = static_cast<V>(a[c] / std::sqrt(square));
      const double stretch = 1.1 + 0.1 * between(random);
      for (std::size_t c = 0; c < 9; ++c)
        F[c * n + i] = static_cast<V>((c % 4 == 0 ? stretch : 0) + 0.05 * between(random));
      G_n[i] = static_cast<V>(1.04 + 0.04 * between(random));
    }
  }
};

/// Output.
template <class V>
struct Results {
  std::vector<V> stress, G, tangent;
  Results(std::size_t n, Tangent t)
      : stress(6 * n), G(n), tangent(static_cast<std::size_t>(tangent_size(t)) * n) {}
};

/// Host arrays in the form that a step takes.
template <class V>
Arrays<V> arrays(const Inputs<V>& in, Results<V>& out) {
  return {static_cast<std::ptrdiff_t>(out.G.size()),
          in.F.data(),
          in.n0.data(),
          in.G_n.data(),
          in.dt.data(),
          out.stress.data(),
          out.G.data(),
          out.tangent.data()};
}

/// The largest differences between two results of all points: of G; of the Cauchy stress, relative to its
/// norm and the stiffness c1 + 2 c2; of DDSDDE, relative to its norm. Infinite where a result is NaN.
struct Differences {
  double G = 0, stress = 0, tangent = 0;
};
template <Tangent tangent, class V>
Differences largest_differences(const FibreGrowth<V>& material, const Results<V>& a, const Results<V>& b) {
  const std::size_t n = a.G.size();
  const auto ddsdde = [&](const Results<V>& r, std::size_t i, V c[36]) {
    V stress[6], t[36];
    for (std::size_t k = 0; k < 6; ++k) stress[k] = r.stress[k * n + i];
    for (std::size_t k = 0; k < tangent_size(tangent); ++k) t[k] = r.tangent[k * n + i];
    if (tangent == Tangent::compact) {
      CompactTangent<V>{{t[0], t[1], t[2]}, t[3], t[4], t[5], t[6]}.expand(material, stress, c);
    } else {
      for (int k = 0; k < 36; ++k) c[k] = t[k];
    }
  };
  const auto raise = [](double& most, double difference) {
    if (!(difference <= most)) most = std::isnan(difference) ? HUGE_VAL : difference;
  };
  Differences d;
  for (std::size_t i = 0; i < n; ++i) {
    double apart = 0, size = 0;
    raise(d.G, std::abs(static_cast<double>(a.G[i]) - static_cast<double>(b.G[i])));
    for (std::size_t k = 0; k < 6; ++k) {
      const double x = a.stress[k * n + i], y = b.stress[k * n + i];
      apart += (x - y) * (x - y), size += y * y;
    }
    raise(d.stress,
          std::sqrt(apart) / (std::sqrt(size) + static_cast<double>(material.c1 + 2 * material.c2)));
    V c[36], e[36];
    ddsdde(a, i, c), ddsdde(b, i, e);
    apart = size = 0;
    for (int k = 0; k < 36; ++k) {
      const double x = c[k], y = e[k];
      apart += (x - y) * (x - y), size += y * y;
    }
    raise(d.tangent, std::sqrt(apart / size));
  }
  return d;
}

}  // namespace many_points

#endif
