/// @file
/// The batch behind the routines that hosts call with many points: compiled once for each instruction set,
/// chosen when the library is loaded. Plain C at the border, so that code for one instruction set cannot leak
/// into another.
#ifndef MYOGROWTH_ABI_BLOCK_HPP
#define MYOGROWTH_ABI_BLOCK_HPP

#include <cstddef>

/// Numbers of points in a host's memory: component c of point k, at data[k * step + c], is at
/// row[c] + k of a block.
template <class V>
struct MyogrowthPlaces {
  V* data;
  std::ptrdiff_t step;
  int size;        ///< components of a point
  const int* row;  ///< of each of them
};

extern "C" {

/// Points in a block: with the full tangent, what goes in and comes out of it stays in the nearest cache.
constexpr int myogrowth_block_points = 32;

/// Where the rows of a block begin: one number of each of its points.
enum MyogrowthRow {
  myogrowth_row_F = 0,                                                   ///< 9, column by column
  myogrowth_row_G = 9 * myogrowth_block_points,                          ///< at the beginning of the step
  myogrowth_row_lambda = myogrowth_row_G + myogrowth_block_points,       ///< likewise
  myogrowth_row_n0 = myogrowth_row_lambda + myogrowth_block_points,      ///< 3
  myogrowth_row_stress = myogrowth_row_n0 + 3 * myogrowth_block_points,  ///< up to 9
  myogrowth_row_tangent = myogrowth_row_stress + 9 * myogrowth_block_points,  ///< up to 81
  myogrowth_row_G_end = myogrowth_row_tangent + 81 * myogrowth_block_points,  ///< and lambda_e, lambda, J, Je
  myogrowth_row_psi = myogrowth_row_G_end + 5 * myogrowth_block_points,
  myogrowth_row_check =
      myogrowth_row_psi + myogrowth_block_points,  ///< 0 if all that comes out, and its sum, is finite
  myogrowth_block_size = myogrowth_row_check + myogrowth_block_points
};

/// A block, and where its points' numbers come from and go to.
struct MyogrowthBlock {
  double number[myogrowth_block_size];  ///< of point k at [row + k]
  double fibre[3];                      ///< n0 of points that have none, 0
  double dt;                            ///< length of the step
  bool stretch_is_checked;              ///< lambda must be finite and >= 0
  bool is_known;  ///< G and lambda must be > 0; else 0 is what is not known yet, and taken as 1
  bool is_given;  ///< out: all points have a result, and `out`, if there is any, has got it
  int n_in, n_out;
  MyogrowthPlaces<const double> in[14];
  MyogrowthPlaces<double> out[11];
};

/// Updates the first n points of the material of these PROPS, all 18 of them and found to be allowed.
/// measure: 0 Cauchy, 1 first, 2 second Piola-Kirchhoff. n0 is then of unit length.
using MyogrowthUpdateBlock = void(const double* props, int n, int measure, int with_tangent,
                                  MyogrowthBlock* block);
#pragma GCC visibility push(hidden)
MyogrowthUpdateBlock myogrowth_update_block_base, myogrowth_update_block_avx2, myogrowth_update_block_avx512;
#pragma GCC visibility pop
}

#endif
