// Sobol's indices of Ishigami's function, which are known in closed form.
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "../../examples/sensitivity/sobol.hpp"

int main() {
  constexpr double pi = 3.14159265358979323846, a = 7, b = 0.1;
  constexpr std::size_t rows = 200000, n = 3;
  std::mt19937_64 random(7);
  const auto f = [](const std::array<double, n>& x) {
    const double sine = std::sin(x[1]);
    return std::sin(x[0]) + a * sine * sine + b * x[2] * x[2] * x[2] * x[2] * std::sin(x[0]);
  };
  std::vector<std::array<double, n + 2>> values(rows);
  for (auto& row : values) {
    std::array<double, n> points[2];
    for (auto& point : points) {
      for (double& x : point) x = pi * (2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1);
    }
    row[0] = f(points[0]);
    row[1] = f(points[1]);
    for (std::size_t i = 0; i < n; ++i) {
      auto mixed = points[0];
      mixed[i] = points[1][i];
      row[i + 2] = f(mixed);
    }
  }
  const Indices<n> found(
      rows, [&](std::size_t row, std::size_t k) { return values[row][k]; }, a / 2,
      [](std::size_t j) { return j; });

  const double pi4 = pi * pi * pi * pi;
  const double by_1 = (1 + b * pi4 / 5) * (1 + b * pi4 / 5) / 2, by_2 = a * a / 8,
               by_1_and_3 = b * b * pi4 * pi4 * (1.0 / 18 - 1.0 / 50);
  const double all = by_1 + by_2 + by_1_and_3;
  const double first[n] = {by_1 / all, by_2 / all, 0};
  const double total[n] = {(by_1 + by_1_and_3) / all, by_2 / all, by_1_and_3 / all};
  bool good = std::abs(found.mean - a / 2) < 0.03 && std::abs(found.variance / all - 1) < 0.02;
  for (std::size_t i = 0; i < n; ++i) {
    std::printf("input %zu: first order %.4f (exact %.4f), total %.4f (%.4f)\n", i + 1, found.first[i],
                first[i], found.total[i], total[i]);
    good = good && std::abs(found.first[i] - first[i]) < 0.02 && std::abs(found.total[i] - total[i]) < 0.02;
  }
  return good ? 0 : 1;
}
