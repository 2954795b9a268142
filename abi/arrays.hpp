/// @file
/// Many points whose numbers lie as the C API or NumPy have them, and their update (c_api.cpp).
#ifndef MYOGROWTH_ABI_ARRAYS_HPP
#define MYOGROWTH_ABI_ARRAYS_HPP

#include "many.hpp"

namespace myogrowth {
namespace abi {

/// What the points of a call have in common.
using CallOfMany = Common;

/// The axes of an array of points, the last one fastest, and how far it goes along each, in numbers. One axis
/// is the rule.
struct Axis {
  std::ptrdiff_t size, step;
};

/// An input. A null pointer: zeros.
struct Given {
  const double* data = nullptr;
  std::ptrdiff_t step = 0;      ///< from a point to the next
  std::ptrdiff_t component[9];  ///< where a point's components are from its first one on; F: column by column
  int n_axes = 0;               ///< where the points have no one step
  const Axis* axis = nullptr;

  const double* at(std::ptrdiff_t point) const {
    if (n_axes == 0) return data + point * step;
    const double* p = data;
    for (int a = n_axes - 1; a > 0; point /= axis[a--].size) p += point % axis[a].size * axis[a].step;
    return p + point * axis[0].step;
  }
  double operator()(std::ptrdiff_t point, int c) const { return data ? at(point)[component[c]] : 0; }
};

/// What comes in, and where what comes out goes.
struct Arrays {
  Given F, G, stretch, n0;
  MyogrowthPlaces<double> out[11];
  int n_out = 0;
  int* status = nullptr;
  /// Entries of the state that are carried over to `carried_to`.
  MyogrowthPlaces<const double> carried{nullptr, 0, 0, nullptr};
  double* carried_to = nullptr;
  /// G and stretch must be > 0: 0 is no "not known yet". Where there is no result the state, all of which is
  /// then kept, is what came in, and lambda_e, J and Je are NaN; else it is left alone.
  bool is_known = false;

  /// Adds an output: component c is row[c] of a block. A null pointer adds none.
  void give(double* data, std::ptrdiff_t step, int size, const int* row) {
    if (data) out[n_out++] = {data, step, size, row};
  }
};

/// All rows of a block, one after the other, to point into.
struct Rows {
  int row[myogrowth_block_size / myogrowth_block_points] = {};
  constexpr Rows() {
    for (int& r : row) r = static_cast<int>(&r - row) * myogrowth_block_points;
  }
};
template <class Unused = void>
struct BlockRows {
  static constexpr Rows all{};
};
template <class Unused>
constexpr Rows BlockRows<Unused>::all;
/// The rows from one on.
inline const int* rows_from(int row) { return BlockRows<>::all.row + row / myogrowth_block_points; }

/// Reads PROPS. Returns a myogrowth_status, and the text if it is not MYOGROWTH_OK.
int check_props(const double* props, int n_props, CallOfMany& call, Text& text);
/// Updates the points [first, last). Returns how many have no result; the text is then about the first, whose
/// index goes to *where.
int update_arrays(const CallOfMany& call, const Arrays& arrays, int first, int last, Text& text, int* where);

}  // namespace abi
}  // namespace myogrowth

#endif
