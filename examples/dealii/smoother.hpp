/// @file
/// The smoother of multigrid's finest level: Chebyshev iterations on a copy of the matrix in single
/// precision, in blocks of 3x3. They read 4.4 bytes an entry, where Trilinos's rows have 12, and are bound by
/// memory.
#ifndef MYOGROWTH_DEALII_SMOOTHER_HPP
#define MYOGROWTH_DEALII_SMOOTHER_HPP

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace muscle {

class Smoother {
 public:
  /// Returns the entries of this rank, which are given, and after them those of other ranks.
  using Exchange = std::function<const double*(const double* owned)>;

  /// Rows of a matrix as CSR, those of this rank: columns count its own unknowns first. Those of a node, 3k
  /// to 3k + 2, have the same columns, the three of each node they couple with, in any order. `start` is
  /// kept.
  Smoother(std::size_t n_rows, const int* start, const std::vector<unsigned>& columns, Exchange exchange);
  /// Copies the entries, divided by the diagonal of their row (single precision then neither overflows nor
  /// loses small rows).
  void copy(const double* values);
  /// x += p(D^-1 A) D^-1 (b - A x), where the polynomial damps what has eigenvalues of D^-1 A from
  /// largest / 20 to 1.1 largest: `sweeps` products with A, one fewer where x is zero. As ML's Chebyshev.
  void apply(double largest, int sweeps, bool x_is_zero, const double* b, double* x);

 private:
  /// r = D^-1 (b - A x)
  void residual(const double* b, const double* x, double* r) const;

  std::size_t n_rows_;
  const int* row_start_;
  std::vector<std::size_t> start_;  // of a node's row of blocks
  std::vector<unsigned> column_;    // first one of a block
  std::vector<float> block_;        // 9 of each, column by column
  std::vector<double> inverse_diagonal_, r_, change_;
  std::vector<std::uint16_t>
      place_;  // of a column of a node's rows: 3 (its block in the row) + its direction
  Exchange exchange_;
};

}  // namespace muscle

#endif
