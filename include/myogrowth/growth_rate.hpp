/// @file
/// Adaptation function and criterion of stretch-driven sarcomerogenesis (paper, eq. 4; Zöllner et al. 2012).
///
///   dG/dt = k_g(G) phi_g(lambda_e),   k_g = (1/tau) [(G_max - G)/(G_max - 1)]^gamma,
///   phi_g = <lambda_e - lambda_crit>,   lambda_e = lambda / G
#ifndef MYOGROWTH_GROWTH_RATE_HPP
#define MYOGROWTH_GROWTH_RATE_HPP

#include "scalar.hpp"

namespace myogrowth {

/// Parameters and right-hand side of eq. 4. The defaults are the paper's Table 1, time in days.
/// P is the type of the parameters: a real number, or a scalar that carries derivatives with respect to them.
template <class P = double>
struct GrowthRate {
  P tau = P(0.5);           ///< > 0: time to add sarcomeres at full capacity [time]
  P gamma = P(2);           ///< >= 0: how sharply the capacity fades as G nears G_max [-]
  P G_max = P(1.1);         ///< > 1: largest relative serial sarcomere number [-]
  P lambda_crit = P(1.01);  ///< > 0: elastic fibre stretch above which sarcomeres are added [-]

  /// What is left of the capacity to grow, [(G_max - G)/(G_max - 1)]^gamma [-]: 1 at G = 1, 0 at and beyond
  /// G_max, where the formula itself would turn positive again for even gamma.
  template <class T>
  MYOGROWTH_FUNCTION Product<T, P> capacity(const T& G) const {
    if (!(value(G) < value(G_max))) return Product<T, P>(0);
    return power(Product<T, P>((G_max - G) / (G_max - P(1))), gamma);
  }

  /// Derivative of the capacity with respect to G [-], 0 at and beyond G_max.
  template <class T>
  MYOGROWTH_FUNCTION Product<T, P> dcapacity_dG(const T& G) const {
    if (!(value(G) < value(G_max))) return Product<T, P>(0);
    return -gamma * capacity(G) / (G_max - G);
  }

  /// Adaptation function k_g(G) [1/time].
  template <class T>
  MYOGROWTH_FUNCTION Product<T, P> adaptation(const T& G) const {
    return capacity(G) / tau;
  }

  /// dk_g/dG [1/time].
  template <class T>
  MYOGROWTH_FUNCTION Product<T, P> dadaptation_dG(const T& G) const {
    return dcapacity_dG(G) / tau;
  }

  /// Growth criterion phi_g(lambda_e) = max(lambda_e - lambda_crit, 0) [-].
  template <class T>
  MYOGROWTH_FUNCTION Product<T, P> criterion(const T& lambda_e) const {
    if (!(value(lambda_e) > value(lambda_crit))) return Product<T, P>(0);
    return Product<T, P>(lambda_e - lambda_crit);
  }

  /// Growth rate dG/dt at sarcomere number G under the total fibre stretch lambda [1/time].
  template <class T>
  MYOGROWTH_FUNCTION Product<T, P> rate(const T& G, const T& lambda) const {
    return adaptation(G) * criterion(T(lambda / G));
  }
};

/// Removal of sarcomeres under a lower threshold, an extension of eq. 4 (docs/theory.md); off while
/// tau_rev = 0.
///
///   dG/dt = -k_rev(G) <lambda_crit_rev - lambda_e>
///   k_rev = (1/tau_rev) [(G - G_min)/(G_max - G_min)]^gamma_rev
template <class P = double>
struct RemovalRate {
  P tau_rev = P(0);          ///< > 0: time constant of removal [time]; 0: nothing is removed
  P gamma_rev = P(2);        ///< >= 0: how sharply removal fades as G nears G_min [-]
  P G_min = P(0.5);          ///< > 0 and < 1: smallest relative serial sarcomere number [-]
  P lambda_crit_rev = P(1);  ///< > 0 and <= lambda_crit: elastic stretch below which they are removed [-]
};

}  // namespace myogrowth

#endif
