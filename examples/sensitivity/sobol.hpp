/// @file
/// Sobol's indices from Saltelli's plan: for every row two independent points A and B, and A with one input
/// at a time taken from B.
#ifndef MYOGROWTH_EXAMPLES_SOBOL_HPP
#define MYOGROWTH_EXAMPLES_SOBOL_HPP

#include <array>
#include <cstddef>

/// First-order and total index of every input: by the estimators of Saltelli et al. 2010 (first order:
/// mean of f(B) (f(A with i from B) - f(A)), over the variance) and of Jansen 1999 (total: half the mean
/// square of f(A) - f(A with i from B)).
template <std::size_t n>
struct Indices {
  std::array<double, n> first{}, total{};
  double mean = 0, variance = 0;

  /// f(row, k): result of the row's history k: A, B, A with input k - 2 from B. row_of(j): the row to take as
  /// j-th. about: roughly the mean; with it taken off, the first-order estimator scatters least.
  template <class F, class RowOf>
  Indices(std::size_t rows, const F& f, double about, const RowOf& row_of) {
    const double count = static_cast<double>(rows);
    double square = 0;
    for (std::size_t j = 0; j < rows; ++j) {
      const std::size_t row = row_of(j);
      const double a = f(row, 0) - about, b = f(row, 1) - about;
      mean += a + b;
      square += a * a + b * b;
      for (std::size_t i = 0; i < n; ++i) {
        const double mixed = f(row, i + 2) - about;
        first[i] += b * (mixed - a);
        total[i] += (a - mixed) * (a - mixed) / 2;
      }
    }
    mean /= 2 * count;
    variance = square / (2 * count) - mean * mean;
    const double rounding = 1e-14 * about;
    if (variance < rounding * rounding) variance = 0;  // nothing varies
    for (std::size_t i = 0; i < n; ++i) {
      first[i] = variance > 0 ? first[i] / count / variance : 0;
      total[i] = variance > 0 ? total[i] / count / variance : 0;
    }
    mean += about;
  }
};

#endif
