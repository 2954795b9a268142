// Times the law and other implementations of it, on the same points in one run, with all repetitions
// interleaved at random, and compares every result with the kernel's. ./run bench; report.py makes the
// tables.
#include <benchmark/benchmark.h>

#include <atomic>
#include <thread>

#include "flops.hpp"
#include "variants.hpp"

namespace bench {
namespace {

std::atomic<bool> all_agree{true};

std::string short_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

void time_it(benchmark::State& state, const Variant& variant, const Points& points, Growth growth,
             double gamma) {
  const auto threads = static_cast<std::size_t>(state.threads());
  const auto thread = static_cast<std::size_t>(state.thread_index());
  const bool is_streamed = points.size == streamed;
  const std::size_t share = is_streamed ? streamed / threads : in_cache;
  const Work w{points, growth, gamma, share * thread, share * (thread + 1)};
  if (thread == 0) {  // results of the previous variant must not be taken for those of this one
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::fill_n(memory.begin(), room * points.size, nan);
  }
  for (auto _ : state) {
    variant.pass(w);
    benchmark::ClobberMemory();
  }
  double worst = 0;
  for (std::size_t p = w.first; p < w.last; p += is_streamed ? 61 : 1) {
    worst = std::max(worst, difference(variant, w, p));
  }
  if (!(worst <= variant.tolerance)) {
    all_agree = false;
    state.SkipWithError(("differs from the kernel by " + short_text(worst)).c_str());
  }
  const auto counter = [](auto x) {
    return benchmark::Counter(static_cast<double>(x), benchmark::Counter::kAvgThreads);
  };
  state.counters["points"] = counter(share);
  state.counters["bytes_read"] = counter(8 * variant.numbers_read);
  state.counters["bytes_written"] = counter(8 * variant.numbers_written);
  state.counters["difference"] = counter(worst);
}

/// STREAM's Scale: the memory bandwidth for reading and writing (memory that is written is read first).
void copy(benchmark::State& state) {
  const auto threads = static_cast<std::size_t>(state.threads());
  const auto thread = static_cast<std::size_t>(state.thread_index());
  const std::size_t share = memory.size() / 2 / threads;
  const double* a = memory.data() + share * thread;
  double* b = memory.data() + memory.size() / 2 + share * thread;
  if (thread == 0) std::fill(memory.begin(), memory.end(), 1.0);
  double s = 1;
  benchmark::DoNotOptimize(s);
  for (auto _ : state) {
    for (std::size_t i = 0; i < share; ++i) b[i] = s * a[i];
    benchmark::ClobberMemory();
  }
  const auto counter = [](auto x) {
    return benchmark::Counter(static_cast<double>(x), benchmark::Counter::kAvgThreads);
  };
  state.counters["points"] = counter(share);
  state.counters["bytes_read"] = state.counters["bytes_written"] = counter(8);
}

/// Adds the kernel's flops and library functions per growing point to the output.
void tell_flops(const Points& points) {
  for (const double gamma : gammas) {
    myogrowth::FibreGrowth<Counted> m;
    m.growth.gamma = gamma;
    Counted::flops = Counted::functions = 0;
    for (std::size_t p = 0; p < in_cache; ++p) {
      Counted F[9], n0[3], c[36];
      std::copy_n(&points.F[9 * p], 9, F);
      std::copy_n(&points.n0[3 * p], 3, n0);
      myogrowth::PointUpdate<Counted> u;
      update_point(m, F, n0, Counted(points.G_n[active][p]), Counted(dtime), u);
      spatial_modulus(u, c);
    }
    const auto a_point = [](long count) { return std::to_string(static_cast<double>(count) / in_cache); };
    benchmark::AddCustomContext("flops, gamma " + short_text(gamma), a_point(Counted::flops));
    benchmark::AddCustomContext("functions, gamma " + short_text(gamma), a_point(Counted::functions));
  }
}

}  // namespace
}  // namespace bench

int main(int argc, char** argv) {
  using namespace bench;
  // Repetitions of all variants in random order, so that a slow moment of the machine does not hit only one.
  std::vector<std::string> text = {argv[0], "--benchmark_enable_random_interleaving=true",
                                   "--benchmark_repetitions=9", "--benchmark_min_time=0.02"};
  text.insert(text.end(), argv + 1, argv + argc);
  std::vector<char*> arguments;
  for (std::string& t : text) arguments.push_back(&t[0]);
  int n = static_cast<int>(arguments.size());
  benchmark::Initialize(&n, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(n, arguments.data())) return 2;

  const int max_threads = std::thread::hardware_concurrency() > 1 ? 2 : 1;
  memory.resize(std::max(room * streamed, std::size_t(1) << 25));
  const Points small(in_cache * static_cast<std::size_t>(max_threads)), large(streamed);
  tell_flops(small);
  std::vector<Variant> all = ours();
  for (const Variant& law : laws()) all.push_back(law);
  for (const Variant& peer : peers()) all.push_back(peer);
  for (const Points* points : {&small, &large}) {
    const std::string place = points == &small ? "cache" : "streamed";
    for (int threads = 1; threads <= max_threads; ++threads) {
      if (points == &large) benchmark::RegisterBenchmark("copy", copy)->Threads(threads);
      for (int g = 0; g < n_growths; ++g) {
        for (const double gamma : gammas) {
          for (const Variant& variant : all) {
            const bool of_law = variant.name.find("law") != std::string::npos;
            if ((variant.second_order || of_law) && points == &large)
              continue;  // limited by arithmetic, not by memory
            const auto growth = static_cast<Growth>(g);
            const std::string name =
                variant.name + "/" + place + "/" + growth_name[g] + "/" + short_text(gamma);
            benchmark::RegisterBenchmark(name.c_str(), [&variant, points, growth,
                                                        gamma](benchmark::State& state) {
              time_it(state, variant, *points, growth, gamma);
            })->Threads(threads);
          }
        }
      }
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  if (!all_agree) std::fprintf(stderr, "FAILED: not all results agree with the kernel's\n");
  return all_agree ? 0 : 1;
}
