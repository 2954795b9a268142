/// @file
/// Where the components of a symmetric tensor are among its six.
#ifndef MYOGROWTH_SYMMETRIC_HPP
#define MYOGROWTH_SYMMETRIC_HPP

#include "scalar.hpp"

namespace myogrowth {

/// Place of component ij of a symmetric tensor among its six: 11 22 33 12 13 23.
constexpr int symmetric_index(int i, int j) { return i == j ? i : i + j + 2; }
/// Row of component a of the six.
constexpr int symmetric_row(int a) { return a < 3 ? a : a == 5 ? 1 : 0; }
/// Column of component a of the six.
constexpr int symmetric_column(int a) { return a < 3 ? a : a == 3 ? 1 : 2; }

}  // namespace myogrowth

#endif
