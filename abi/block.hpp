/// @file
/// The batch behind the routines that hosts call with many points: compiled once for each instruction set,
/// chosen when the library is loaded. Plain C at the border, so that code for one instruction set cannot leak
/// into another.
#ifndef MYOGROWTH_ABI_BLOCK_HPP
#define MYOGROWTH_ABI_BLOCK_HPP

extern "C" {

/// Points in a block: with the full tangent, what goes in and comes out of it stays in the nearest cache.
constexpr int myogrowth_block_points = 32;

/// A block: component c of point i is at [c * myogrowth_block_points + i]. Tangent and stress as in Measure's
/// order.
struct MyogrowthBlock {
  double F[9 * myogrowth_block_points], n0[3 * myogrowth_block_points];
  double G[myogrowth_block_points], lambda[myogrowth_block_points];  ///< at the beginning of the step
  double dt;
  double stress[9 * myogrowth_block_points], tangent[81 * myogrowth_block_points];
  double G_end[myogrowth_block_points];
  double scalars[5 * myogrowth_block_points];  ///< lambda_e, lambda, J, Je, psi
  double check[myogrowth_block_points];        ///< 0 if all that comes out, and its sum, is finite
};

/// Updates the first n points of the material of these PROPS, all 18 of them and found to be allowed.
/// measure: 0 Cauchy, 1 first, 2 second Piola-Kirchhoff. Where a point has no result its stress and its check
/// are NaN.
using MyogrowthUpdateBlock = void(const double* props, int n, int measure, int with_tangent,
                                  MyogrowthBlock* block);
#pragma GCC visibility push(hidden)
MyogrowthUpdateBlock myogrowth_update_block_base, myogrowth_update_block_avx2, myogrowth_update_block_avx512;
#pragma GCC visibility pop
}

#endif
