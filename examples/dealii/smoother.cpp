#include "smoother.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>

namespace muscle {

Smoother::Smoother(std::size_t n_rows, const int* start, const std::vector<unsigned>& columns,
                   Exchange exchange)
    : n_rows_(n_rows),
      row_start_(start),
      inverse_diagonal_(n_rows),
      r_(n_rows),
      change_(n_rows),
      exchange_(std::move(exchange)) {
  start_.push_back(0);
  for (std::size_t row = 0; row < n_rows; row += 3) {
    const auto first = columns.begin() + start[row], last = columns.begin() + start[row + 1];
    if (last - first > 0xffff) throw std::length_error("a node couples with more than 65,535 unknowns");
    const std::size_t n = column_.size();
    std::copy_if(first, last, std::back_inserter(column_), [](unsigned c) { return c % 3 == 0; });
    const auto begin = column_.begin() + static_cast<std::ptrdiff_t>(n);
    std::sort(begin, column_.end());
    start_.push_back(column_.size());
    for (auto c = first; c != last; ++c) {
      const auto block = std::lower_bound(begin, column_.end(), *c - *c % 3);
      if (block == column_.end() || *block != *c - *c % 3 || last - first != 3 * (column_.end() - begin))
        throw std::logic_error("Smoother: row " + std::to_string(row) + " couples with a part of a node");
      place_.push_back(static_cast<std::uint16_t>(3 * (block - begin) + *c % 3));
    }
  }
  block_.resize(9 * column_.size() + 3);  // residual() reads four numbers where three are meant
}

void Smoother::copy(const double* values) {
  const std::uint16_t* place = place_.data();
  for (std::size_t node = 0; node < start_.size() - 1; ++node) {
    const std::size_t first = start_[node], n = 3 * (start_[node + 1] - first);
    const unsigned* blocks = column_.data() + first;
    const std::ptrdiff_t own = std::find(blocks, blocks + n / 3, 3 * node) - blocks;
    for (std::size_t i = 0; i < 3; ++i) {
      const double* row = values + row_start_[3 * node + i];
      const std::size_t diagonal = 3 * static_cast<std::size_t>(own) + i;
      const double d = row[std::find(place, place + n, diagonal) - place];
      const double factor = inverse_diagonal_[3 * node + i] = d != 0 ? 1 / d : 1;
      for (std::size_t c = 0; c < n; ++c)
        block_[9 * first + 3 * place[c] + i] = static_cast<float>(factor * row[c]);
    }
    place += n;
  }
}

void Smoother::residual(const double* b, const double* x, double* r) const {
  for (std::size_t node = 0; node < start_.size() - 1; ++node) {
    double sum[4] = {};  // the fourth is not used: four of a register are faster than three
    for (std::size_t k = start_[node]; k < start_[node + 1]; ++k) {
      const float* a = block_.data() + 9 * k;
      const double* at = x + column_[k];
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 4; ++i) sum[i] += static_cast<double>(a[3 * j + i]) * at[j];
      }
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t row = 3 * node + i;
      r[row] = inverse_diagonal_[row] * b[row] - sum[i];
    }
  }
}

void Smoother::apply(double largest, int sweeps, bool x_is_zero, const double* b, double* x) {
  const double upper = 1.1 * largest, lower = largest / 20;
  const double half = (upper - lower) / 2, middle = (upper + lower) / 2;
  double ratio = half / middle;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    if (sweep == 0 && x_is_zero) {
      std::fill(x, x + n_rows_, 0.0);
      for (std::size_t i = 0; i < n_rows_; ++i) r_[i] = inverse_diagonal_[i] * b[i];
    } else {
      residual(b, exchange_(x), r_.data());
    }
    const double next = sweep == 0 ? ratio : 1 / (2 * middle / half - ratio);
    const double keep = sweep == 0 ? 0 : next * ratio, add = sweep == 0 ? 1 / middle : 2 * next / half;
    ratio = next;
    for (std::size_t i = 0; i < n_rows_; ++i) {
      change_[i] = keep * change_[i] + add * r_[i];
      x[i] += change_[i];
    }
  }
}

}  // namespace muscle
