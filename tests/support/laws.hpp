// Random elastic laws, and what is asked of each of them.
#ifndef MYOGROWTH_TESTS_LAWS_HPP
#define MYOGROWTH_TESTS_LAWS_HPP

#include <myogrowth/elastic/blemker.hpp>
#include <myogrowth/elastic/ehret.hpp>
#include <myogrowth/elastic/neo_hookean.hpp>
#include <myogrowth/elastic/roehrle.hpp>

#include "samples.hpp"

namespace laws {

using namespace myogrowth;

inline NeoHookean<> vary(NeoHookean<>, samples::Random& r) { return {r.uniform(2, 40), r.uniform(1, 10)}; }
inline Roehrle<> vary(Roehrle<> law, samples::Random& r) {
  law.c10 *= r.uniform(0.5, 2);
  law.c01 *= r.chance(0.2) ? 0 : r.uniform(0.5, 2);
  law.kappa *= r.log_uniform(0.01, 1);
  law.lambda_opt = r.uniform(1, 1.5);
  law.g2 = r.uniform(2, 8);
  return law;
}
inline Blemker<> vary(Blemker<> law, samples::Random& r) {
  if (r.chance(0.3)) {
    law = Blemker<>::of_tendon();
    law.L2 = r.uniform(10, 50);
  }
  law.G1 *= r.uniform(0.5, 20);
  law.G2 *= r.uniform(0.5, 20);
  law.kappa *= r.log_uniform(0.01, 1);
  law.lambda_opt = r.uniform(1, 1.5);
  return law;
}
inline Ehret<> vary(Ehret<> law, samples::Random& r) {
  law.alpha = r.uniform(1, 20);
  law.beta = r.uniform(0.5, 2);
  law.gamma *= r.uniform(0.5, 2);
  law.kappa = r.uniform(1, 20);
  law.w0 = r.uniform(0.1, 0.9);
  return law;
}

/// A tendon's curve has its kink at rest.
template <class Law>
Law without_tendon(Law law) {
  return law;
}
inline Blemker<> without_tendon(Blemker<> law) {
  law.tendon = false;
  law.lambda_star = 1.4;
  return law;
}

}  // namespace laws

#endif
