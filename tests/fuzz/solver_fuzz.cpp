// Ten million deterministic growth steps, dt/tau from 1e-12 to 1e300, around every place where the solve
// could go wrong: never out of the bracket, never NaN, a bounded number of iterations, and a root of the
// equation.
//
//     solver_fuzz [CASES] [SEED]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <myogrowth/growth_step.hpp>

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

Step random_step(samples::Random& r) {
  const double gammas[] = {0,     1e-20, 1e-3, 0.05, 0.1, 0.3, 0.5, 0.75, 0.999, 1,
                           1.001, 1.5,   2,    2.5,  3,   3.7, 4,   5,    8,     20};
  Step s;
  s.rate.growth_time = r.log_uniform(1e-3, 1e3);
  s.rate.gamma = r.chance(0.2) ? r.uniform(0, 6) : r.pick(gammas);
  s.rate.G_max = 1 + r.log_uniform(1e-6, 10);
  s.rate.lambda_crit = r.uniform(0.5, 1.5);
  if (r.chance(0.5)) {
    s.removal = {r.log_uniform(1e-3, 1e3), r.chance(0.2) ? r.uniform(0, 6) : r.pick(gammas),
                 1 - r.log_uniform(1e-6, 0.99), s.rate.lambda_crit * r.uniform(0.5, 1)};
  }
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
      s.lambda = s.removal.lambda_crit * s.G_n * (1 - r.log_uniform(1e-14, 0.99));
      break;
    case 3:
      s.lambda =
          s.removal.lambda_crit * s.removal.G_min * (1 + r.uniform(-1, 1) * r.log_uniform(1e-14, 0.99));
      break;
    default:
      s.lambda = r.uniform(0.3, 4);
  }
  s.dt = s.rate.growth_time * (r.chance(0.5) ? r.log_uniform(1e-12, 1e300) : r.log_uniform(1e-6, 1e6));
  return s;
}

// Whether the root of the equation, grown or shrunk, lies within 8 units in the last place of G.
bool is_root(const Step& s, double G) {
  using L = long double;
  const L dt = s.dt, lambda = s.lambda;
  const GrowthRate<L> rate{s.rate.growth_time, s.rate.gamma, s.rate.G_max, s.rate.lambda_crit};
  const auto residual = [&](L g) -> L {
    if (G > s.G_n) return g - s.G_n - dt * rate.rate(g, lambda);
    const L x = (g - s.removal.G_min) / (rate.G_max - s.removal.G_min);
    const L k = x > 0 ? power(x, L(s.removal.gamma)) / s.removal.removal_time : L(0);
    return g - s.G_n + dt * k * std::max(s.removal.lambda_crit - lambda / g, L(0));
  };
  const L ulp = 8 * static_cast<L>(std::numeric_limits<double>::epsilon()) * G;
  return residual(G - ulp) <= 0 && residual(G + ulp) >= 0;
}

}  // namespace

int main(int argc, char** argv) {
  const long long cases = argc > 1 ? std::atoll(argv[1]) : 10'000'000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  samples::Random r(seed);
  long long grew = 0, iterations = 0, failures = 0;
  int worst = 0;
  for (long long i = 0; i < cases; ++i) {
    const Step s = random_step(r);
    const auto step = solve_growth(s.rate, s.removal, s.G_n, s.lambda, s.dt);
    const double upper = std::max(s.G_n, std::min(s.rate.G_max, s.lambda / s.rate.lambda_crit));
    const bool removes = s.removal.removal_time > 0 && s.lambda < s.removal.lambda_crit * s.G_n;
    const double lower =
        removes ? std::min(s.G_n, std::max(s.removal.G_min, s.lambda / s.removal.lambda_crit)) : s.G_n;
    const double slope = step.dG_dlambda * (removes ? s.removal.lambda_crit : s.rate.lambda_crit);
    const bool good = step.G >= lower && step.G <= upper && slope >= 0 && (removes || slope <= 1 + 1e-9) &&
                      std::isfinite(slope) &&
                      step.iterations <= (removes ? most_removal_iterations : most_iterations) &&
                      (step.iterations == 0 || step.G == s.G_n || is_root(s, step.G));
    if (!good && ++failures <= 10) {
      std::printf(
          "FAILED: tau %.17g gamma %.17g G_max %.17g lambda_crit %.17g G_n %.17g lambda %.17g dt %.17g\n"
          "        removal: tau %.17g gamma %.17g G_min %.17g lambda_crit %.17g\n"
          "        gave G %.17g in [%.17g, %.17g], dG/dlambda %.17g, %d iterations\n",
          s.rate.growth_time, s.rate.gamma, s.rate.G_max, s.rate.lambda_crit, s.G_n, s.lambda, s.dt,
          s.removal.removal_time, s.removal.gamma, s.removal.G_min, s.removal.lambda_crit, step.G, lower,
          upper, step.dG_dlambda, step.iterations);
    }
    grew += step.iterations > 0;
    iterations += step.iterations;
    worst = std::max(worst, step.iterations);
    if ((i + 1) % (cases / 10 + 1) == 0)
      std::printf("%lld of %lld steps\n", i + 1, cases), std::fflush(stdout);
  }
  std::printf("%lld steps, %lld grew or shrank, %.2f iterations on average, %d at most, %lld failures\n",
              cases, grew, static_cast<double>(iterations) / static_cast<double>(grew), worst, failures);
  return failures == 0 ? 0 : 1;
}
