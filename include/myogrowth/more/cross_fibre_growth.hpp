/// @file
/// Hypertrophy: a muscle under load adds sarcomeres in parallel until the tension on each is back at its old
/// value. A law of growth_law.hpp whose step has exactly one root for any dt (docs/theory.md).
///
///   F_g = sqrt(g) (I - n0⊗n0) + n0⊗n0,   dg/dt = k_g(g) <tension/tension_crit - 1>
///
/// g is the relative cross-section, 1 at start; the tension is n·tau(F_e) n along the fibre n = F_e n0/|F_e
/// n0|.
///
///     auto step = update(CrossFibreGrowth(), NeoHookean<>(), F, n0, g_n, dt);
#ifndef MYOGROWTH_MORE_CROSS_FIBRE_GROWTH_HPP
#define MYOGROWTH_MORE_CROSS_FIBRE_GROWTH_HPP

#include "growth_law.hpp"

namespace myogrowth {

/// The law. tau of the default is fitted to eight weeks of training (docs/evidence.md).
struct CrossFibreGrowth {
  NeoHookean<> muscle;                     ///< what the tension comes from; c1 >= 0, c2 > 0
  GrowthRate<> capacity{27.2, 2, 1.5, 1};  ///< k_g of eq. 4: tau [days], gamma, largest cross-section
  double tension_crit = 0.5;               ///< > 0: tension above which sarcomeres are added [stress]

  /// Where growth ends.
  double limit() const { return capacity.G_max; }

  /// F_g: only across the fibre, det F_g = g.
  template <class T>
  Mat3<T> growth_tensor(const T& g, const Vec3<T>& n0) const {
    const T thicker = sqrt(g);
    return thicker * Mat3<T>::Identity() + (T(1) - thicker) * n0 * n0.transpose();
  }

  /// The fibre's part of the Kirchhoff stress [stress].
  template <class T>
  T tension(const Mat3<T>& Fe, const Vec3<T>& n0) const {
    const Mat3<T> tau = muscle.kirchhoff(left_cauchy_green(Fe));
    const Vec3<T> n = Fe * n0 / fibre_stretch(Fe, n0);
    return contraction<T>(tau, n * n.transpose());
  }

  /// dg/dt [1/time].
  template <class T>
  T rate(const T& g, const Mat3<T>& Fe, const Vec3<T>& n0) const {
    const T over = tension(Fe, n0) / tension_crit - 1.;
    return value(over) > 0 ? T(capacity.adaptation(g) * over) : T(0);
  }

  /// g after dt [time] under a load that stays, where the tension on each fibre is the load over g
  /// (docs/theory.md): dg/dt = k_g(g) <overload/g - 1>, the exact flow of eq. 4. overload: load/tension_crit
  /// at g = 1.
  double at_constant_load(double g, double overload, double dt) const {
    const GrowthRate<> rate{capacity.tau, capacity.gamma, capacity.G_max, 1};
    return flow_growth(rate, RemovalRate<>(), g, overload, dt).G;
  }
};

}  // namespace myogrowth

#endif
