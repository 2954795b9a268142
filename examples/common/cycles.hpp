/// @file
/// Growth over thousands of equal cycles, such as hours of stretch a day, for the price of a few.
///
/// A cycle holds one stretch and then another; the exact flow of eq. 4 makes it one map G -> Phi(G). Both
/// flows contract, as the rate falls with G: 0 <= dPhi/dG <= 1, so what is wrong in G never grows. Let Delta
/// = Phi(G) - G. N cycles at once are
///
///   G_{n+N} = G_n + N Delta(G_n + (N - 1)/2 Delta(G_n)),
///
/// exact for N = 1 and of second order in N Delta (a multirevolution method: Calvo, Jay, Montijano, Rández,
/// Numerische Mathematik 97, 2004). N follows from the difference between one such jump and two of N/2.
#ifndef MYOGROWTH_EXAMPLES_CYCLES_HPP
#define MYOGROWTH_EXAMPLES_CYCLES_HPP

#include <algorithm>
#include <cmath>
#include <myogrowth/growth_flow.hpp>

namespace study {

/// `hours` at `stretch`, and what is left of `days` at `rest`.
struct Cycle {
  double stretch, hours, rest, days;
};

/// G after one cycle.
inline double one_cycle(const myogrowth::GrowthRate<>& growth, const myogrowth::RemovalRate<>& removal,
                        const Cycle& c, double G) {
  G = flow_growth(growth, removal, G, c.stretch, c.hours / 24).G;
  return flow_growth(growth, removal, G, c.rest, c.days - c.hours / 24).G;
}

struct Cycles {
  double G;
  long evaluated;  ///< cycles that were computed
};

/// G after n cycles. The error of a jump of N is kept below tolerance N/(2 n), so that of G is below the
/// tolerance as far as the estimate holds; tests/studies/cycles_test.cpp compares with every cycle computed.
inline Cycles many_cycles(const myogrowth::GrowthRate<>& growth, const myogrowth::RemovalRate<>& removal,
                          const Cycle& c, double G, long n, double tolerance) {
  long evaluated = 0;
  const auto change = [&](double g) {
    ++evaluated;
    return one_cycle(growth, removal, c, g) - g;
  };
  const auto jump = [&](double g, double first, long N) {
    const double size = static_cast<double>(N);
    return N == 1 ? g + first : g + size * change(g + (size - 1) / 2 * first);
  };
  long N = 1;
  for (long done = 0; done < n;) {
    const double first = change(G);
    // The change of a cycle never grows: this is all that can still come.
    if (std::abs(first) * static_cast<double>(n - done) <= tolerance / 4) break;
    const long half = std::min(N, n - done) / 2;
    if (half == 0) {
      G += first;
      ++done;
      N = 2;
      continue;
    }
    const double whole = jump(G, first, 2 * half), middle = jump(G, first, half);
    const double halves = jump(middle, change(middle), half);
    const double size = static_cast<double>(2 * half);
    const double error = std::abs(whole - halves) / 3,
                 allowed = tolerance / 2 * size / static_cast<double>(n);
    if (error <= allowed) {
      G = halves;
      done += 2 * half;
    }
    // (A jump's error is of order N^3; the allowed one of order N.)
    const double factor = 0.9 * std::sqrt(allowed / std::max(error, 1e-3 * allowed));
    const double next = size * std::clamp(factor, 0.1, 4.0);
    N = std::max(1L, static_cast<long>(next));
  }
  return {G, evaluated};
}

}  // namespace study

#endif
