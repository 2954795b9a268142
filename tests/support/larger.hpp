// For the worst of many errors.
#ifndef MYOGROWTH_TESTS_SUPPORT_LARGER_HPP
#define MYOGROWTH_TESTS_SUPPORT_LARGER_HPP

#include <cmath>

// NaN where one of the two is, so that a bound on the worst error finds it. std::max drops it.
inline double larger(double worst, double error) {
  return error > worst || std::isnan(error) ? error : worst;
}

#endif
