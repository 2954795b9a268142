/// @file
/// ceres::Jet, a forward dual number, as a scalar of the law: all it lacks is `value` (myogrowth/scalar.hpp).
/// Parameters may be Jets too; the local solve then carries their derivatives by the implicit function
/// theorem.
#ifndef MYOGROWTH_EXAMPLES_JET_HPP
#define MYOGROWTH_EXAMPLES_JET_HPP

#include <ceres/jet.h>

namespace ceres {
template <class T, int N>
T value(const Jet<T, N>& x) {
  return x.a;
}
}  // namespace ceres

#endif
