// Ten million deterministic growth steps, dt/tau from 1e-12 to 1e300, around every place where the solve
// could go wrong: never out of the bracket, never NaN, a bounded number of iterations, and a root of the
// equation. As numbers, and as many once more in the lanes of packs.
//
//     solver_fuzz [CASES] [SEED]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <myogrowth/growth_step.hpp>
#include <myogrowth/many/pack.hpp>

#include "../support/samples.hpp"

using namespace myogrowth;

namespace {

constexpr int most_iterations = 30;           // for gamma <= 20
constexpr int most_removal_iterations = 120;  // bisection may take over

struct Step {
  GrowthRate<> rate;
  RemovalRate<> removal;  // at the other side of a gap, or off
  double G_n, lambda, dt;
};

void random_material(samples::Random& r, Step& s) {
  const double gammas[] = {0,     1e-20, 1e-3, 0.05, 0.1, 0.3, 0.5, 0.75, 0.999, 1,
                           1.001, 1.5,   2,    2.5,  3,   3.7, 4,   5,    8,     20};
  s.rate.tau = r.log_uniform(1e-3, 1e3);
  s.rate.gamma = r.chance(0.2) ? r.uniform(0, 6) : r.pick(gammas);
  s.rate.G_max = 1 + r.log_uniform(1e-6, 10);
  s.rate.lambda_crit = r.uniform(0.5, 1.5);
  if (r.chance(0.5)) {
    s.removal = {r.log_uniform(1e-3, 1e3), r.chance(0.2) ? r.uniform(0, 6) : r.pick(gammas),
                 1 - r.log_uniform(1e-6, 0.99), s.rate.lambda_crit * r.uniform(0.5, 1)};
  }
}

void random_state(samples::Random& r, Step& s) {
  const double width = s.rate.G_max - 1;
  switch (r.bits() % 5) {
    case 0:
      s.G_n = 1;
      break;
    case 1:
      s.G_n = 1 + width * r.uniform();
      break;
    case 2:
      s.G_n = s.rate.G_max - width * r.log_uniform(1e-12, 1);
      break;
    case 3:
      s.G_n = s.removal.G_min * (1 + r.log_uniform(1e-12, 2));
      break;
    default:
      s.G_n = r.uniform(0.1, 1.1);
  }
  switch (r.bits() % 5) {
    case 0:
      s.lambda = s.rate.lambda_crit * s.G_n * (1 + r.log_uniform(1e-14, 10));
      break;
    case 1:
      s.lambda = s.rate.lambda_crit * s.rate.G_max * (1 + r.uniform(-1, 1) * r.log_uniform(1e-14, 1));
      break;
    case 2:
      s.lambda = s.removal.lambda_crit_rev * s.G_n * (1 - r.log_uniform(1e-14, 0.99));
      break;
    case 3:
      s.lambda =
          s.removal.lambda_crit_rev * s.removal.G_min * (1 + r.uniform(-1, 1) * r.log_uniform(1e-14, 0.99));
      break;
    default:
      s.lambda = r.uniform(0.3, 4);
  }
  s.dt = s.rate.tau * (r.chance(0.5) ? r.log_uniform(1e-12, 1e300) : r.log_uniform(1e-6, 1e6));
}

// Whether the root of the equation, grown or shrunk, lies within 8 units in the last place of G.
bool is_root(const Step& s, double G) {
  using L = long double;
  const L dt = s.dt, lambda = s.lambda;
  const GrowthRate<L> rate{s.rate.tau, s.rate.gamma, s.rate.G_max, s.rate.lambda_crit};
  const auto residual = [&](L g) -> L {
    if (G > s.G_n) return g - s.G_n - dt * rate.rate(g, lambda);
    const L x = (g - s.removal.G_min) / (rate.G_max - s.removal.G_min);
    const L k = x > 0 ? power(x, L(s.removal.gamma_rev)) / s.removal.tau_rev : L(0);
    return g - s.G_n + dt * k * std::max(s.removal.lambda_crit_rev - lambda / g, L(0));
  };
  const L ulp = 8 * static_cast<L>(std::numeric_limits<double>::epsilon()) * G;
  return residual(G - ulp) <= 0 && residual(G + ulp) >= 0;
}

// What came of the steps so far, and the first that are wrong.
struct Tally {
  long long steps = 0, moved = 0, iterations = 0, failures = 0;
  int worst = 0;

  void take(const Step& s, const GrowthStep<double>& step) {
    const double upper = std::max(s.G_n, std::min(s.rate.G_max, s.lambda / s.rate.lambda_crit));
    const bool removes = s.removal.tau_rev > 0 && s.lambda < s.removal.lambda_crit_rev * s.G_n;
    const double lower =
        removes ? std::min(s.G_n, std::max(s.removal.G_min, s.lambda / s.removal.lambda_crit_rev)) : s.G_n;
    const double slope = step.dG_dlambda * (removes ? s.removal.lambda_crit_rev : s.rate.lambda_crit);
    const bool good = step.G >= lower && step.G <= upper && slope >= 0 && (removes || slope <= 1 + 1e-9) &&
                      std::isfinite(slope) &&
                      step.iterations <= (removes ? most_removal_iterations : most_iterations) &&
                      (step.iterations == 0 || step.G == s.G_n || is_root(s, step.G));
    if (!good && ++failures <= 10) {
      std::printf(
          "FAILED: tau %.17g gamma %.17g G_max %.17g lambda_crit %.17g G_n %.17g lambda %.17g dt %.17g\n"
          "        removal: tau %.17g gamma %.17g G_min %.17g lambda_crit %.17g\n"
          "        gave G %.17g in [%.17g, %.17g], dG/dlambda %.17g, %d iterations\n",
          s.rate.tau, s.rate.gamma, s.rate.G_max, s.rate.lambda_crit, s.G_n, s.lambda, s.dt,
          s.removal.tau_rev, s.removal.gamma_rev, s.removal.G_min, s.removal.lambda_crit_rev, step.G, lower,
          upper, step.dG_dlambda, step.iterations);
    }
    ++steps;
    moved += step.iterations > 0;
    iterations += step.iterations;
    worst = std::max(worst, step.iterations);
  }
  void say(const char* what) const {
    std::printf(
        "%s: %lld steps, %lld grew or shrank, %.2f iterations on average, %d at most, %lld failures\n", what,
        steps, moved, static_cast<double>(iterations) / static_cast<double>(moved), worst, failures);
    std::fflush(stdout);
  }
};

#ifndef __SANITIZE_ADDRESS__  // with it compilers take minutes for packs
// Steps of one material in the lanes of a pack. Returns how many lanes it leaves to the scalar routine; steps
// so long that 1/dt leaves a pack's range are not counted.
constexpr int lanes = 16;
int take_pack(samples::Random& r, Tally& tally) {
  using P = simd::Pack<double, lanes>;
  Step steps[lanes], material;
  random_material(r, material);
  P G_n, lambda, dt;
  for (int i = 0; i < lanes; ++i) {
    steps[i] = material;
    random_state(r, steps[i]);
    G_n.set(i, steps[i].G_n), lambda.set(i, steps[i].lambda), dt.set(i, steps[i].dt);
  }
  P G = G_n, slope(0.0);
  auto left = dt < P(0.0);
  const auto take = [&](const auto& moves, const auto& step) {
    G = select(moves, step.G, G);
    slope = select(moves, step.dG_dlambda, slope);
    left = left | (moves & step.left);
  };
  const auto up = detail::grows(material.rate, G_n, lambda, dt);
  const auto down = detail::shrinks(material.removal, G_n, lambda, dt);
  if (any(up)) take(up, detail::backward_euler(detail::branch_of(material.rate), up, G_n, lambda, dt));
  if (any(down)) {
    take(down,
         detail::backward_euler(detail::branch_of(material.rate, material.removal), down, G_n, lambda, dt));
  }
  const unsigned moves = bits(up | down), is_left = bits(left);
  int count = 0;
  for (int i = 0; i < lanes; ++i) {
    if (is_left >> i & 1u) {
      count += steps[i].dt < 1e250;
      ++tally.steps;
    } else {
      tally.take(steps[i], {G[i], slope[i], moves >> i & 1u ? 1 : 0});
    }
  }
  return count;
}
#endif

}  // namespace

int main(int argc, char** argv) {
  const long long cases = argc > 1 ? std::atoll(argv[1]) : 10'000'000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  samples::Random r(seed);
  Tally numbers;
  for (long long i = 0; i < cases; ++i) {
    Step s;
    random_material(r, s);
    random_state(r, s);
    numbers.take(s, solve_growth(s.rate, s.removal, s.G_n, s.lambda, s.dt));
  }
  numbers.say("numbers");
  long long failures = numbers.failures;
#ifndef __SANITIZE_ADDRESS__
  Tally packs;
  long long left = 0;
  while (packs.steps < cases) left += take_pack(r, packs);
  packs.say("packs");
  std::printf("packs left %lld lanes to the scalar routine\n", left);
  failures += packs.failures;
  if (left > cases / 1000) failures += left;  // packs are made for these steps
#endif
  return failures == 0 ? 0 : 1;
}
