/// @file
/// The batch behind the routines that hosts call with many points: compiled once for each instruction set,
/// chosen when the library is loaded. Plain C at the border, so that code for one instruction set cannot leak
/// into another.
#ifndef MYOGROWTH_ABI_BLOCK_HPP
#define MYOGROWTH_ABI_BLOCK_HPP

#include <cstddef>

#include "myogrowth.h"

extern "C" {

/// Points in a block: with the full tangent, what goes in and comes out of it stays in the nearest cache.
constexpr int myogrowth_block_points = 64;

/// Where the rows of a block begin, one number of each of its points: row of an entry of myogrowth.h.
constexpr int myogrowth_row(int entry) { return entry * myogrowth_block_points; }
enum MyogrowthRow {
  myogrowth_row_F = myogrowth_row(MYOGROWTH_F),
  myogrowth_row_G = myogrowth_row(MYOGROWTH_G),
  myogrowth_row_lambda = myogrowth_row(MYOGROWTH_LAMBDA),
  myogrowth_row_n0 = myogrowth_row(MYOGROWTH_N0),
  myogrowth_row_stress = myogrowth_row(MYOGROWTH_STRESS),
  myogrowth_row_tangent = myogrowth_row(MYOGROWTH_TANGENT),
  myogrowth_row_G_end = myogrowth_row(MYOGROWTH_G_END),
  myogrowth_row_J = myogrowth_row(MYOGROWTH_J),
  myogrowth_row_psi = myogrowth_row(MYOGROWTH_ENERGY),
  myogrowth_row_check =
      myogrowth_row(MYOGROWTH_UNUSED + 1),  ///< 0 if all that comes out, and its sum, is finite
  myogrowth_block_size = myogrowth_row(MYOGROWTH_UNUSED + 2)
};

/// A block, and where its points' numbers come from and go to.
struct MyogrowthBlock {
  double number[myogrowth_block_size];  ///< of point k at [row + k]; fastest on a cache line
  double fibre[3];                      ///< n0 of points that have none, 0
  double dt;                            ///< length of the step
  bool stretch_is_checked;              ///< lambda must be finite and >= 0
  bool is_known;  ///< G and lambda must be > 0; else 0 is what is not known yet, and taken as 1
  bool is_given;  ///< out: all points have a result, and `out`, if there is any, has got it
  int n_in, n_out;
  const myogrowth_input* in;  ///< of all points of the call
  const myogrowth_output* out;
  int stress, tangent;   ///< index of its only output, if that is whole and in its order, or -1
  std::ptrdiff_t first;  ///< which of them is the block's first
};

/// Updates the first n points of a material, the bytes of a FibreGrowth<double> (which has another name in
/// each instruction set). measure: 0 Cauchy, 1 first, 2 second Piola-Kirchhoff. n0 is then of unit length.
using MyogrowthUpdateBlock = void(const void* material, int n, int measure, int with_tangent,
                                  MyogrowthBlock* block);
#pragma GCC visibility push(hidden)
MyogrowthUpdateBlock myogrowth_update_block_base, myogrowth_update_block_avx2, myogrowth_update_block_avx512;
#pragma GCC visibility pop
}

#endif
