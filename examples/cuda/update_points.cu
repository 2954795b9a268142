// One step of millions of material points on a CUDA device: compared with the same routine on the CPU, and
// timed in turns with the device's own copy. docs/gpu.md says how to use the law in a kernel of your own.
//
//   nvcc -std=c++17 -O3 --expt-relaxed-constexpr -arch=native -I include examples/cuda/update_points.cu
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <new>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "../common/files.hpp"
#include "../common/rows.hpp"
#include "many_points.hpp"

using namespace many_points;

// One thread per point. Arrays of one component after the other: the 32 threads of a warp read and write
// neighbours. At least 4 blocks per multiprocessor, that is up to 128 registers per thread: nothing is
// spilled.
constexpr int block_threads = 128, least_blocks = 4;
template <Tangent tangent, class V>
__global__ void __launch_bounds__(block_threads, least_blocks)
    update(FibreGrowth<V> material, Arrays<V> arrays, unsigned long long* failed) {
  const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(blockIdx.x) * block_threads + threadIdx.x;
  if (i >= arrays.n) return;
  // Set here, so that the compiler removes the code that the material does not use, and its registers.
  material.integration = TimeIntegration::backward_euler;
  material.removal.tau_rev = 0;
  if (step<tangent>(material, arrays, i) != UpdateStatus::ok) atomicAdd(failed, 1ull);
}

namespace {

[[noreturn]] void stop(const std::string& message) { throw common::Error(message); }

void check(cudaError_t error, const std::string& what) {
  if (error != cudaSuccess) stop(what + ": " + cudaGetErrorString(error));
}

/// n numbers on the device.
template <class V>
struct OnDevice {
  V* data = nullptr;
  explicit OnDevice(std::size_t n) {
    check(cudaMalloc(&data, n * sizeof(V)), std::to_string(n * sizeof(V)) + " bytes on the device");
  }
  explicit OnDevice(const std::vector<V>& host) : OnDevice(host.size()) {
    check(cudaMemcpy(data, host.data(), host.size() * sizeof(V), cudaMemcpyHostToDevice),
          "copy to the device");
  }
  OnDevice(const OnDevice&) = delete;
  ~OnDevice() { cudaFree(data); }
  void get(std::vector<V>& host) const {
    check(cudaMemcpy(host.data(), data, host.size() * sizeof(V), cudaMemcpyDeviceToHost),
          "copy from the device");
  }
};

/// Time on the device [s].
template <class Work>
double seconds(const Work& work) {
  cudaEvent_t from, to;
  check(cudaEventCreate(&from), "event");
  check(cudaEventCreate(&to), "event");
  check(cudaEventRecord(from), "event");
  work();
  check(cudaEventRecord(to), "event");
  check(cudaEventSynchronize(to), "update");
  float milliseconds = 0;
  check(cudaEventElapsedTime(&milliseconds, from, to), "event");
  cudaEventDestroy(from);
  cudaEventDestroy(to);
  return milliseconds * 1e-3;
}

double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + x.size() / 2, x.end());
  return x[x.size() / 2];
}

struct Options {
  std::size_t points = 2000000;
  int repetitions = 21;
  std::string precision = "all", tangent = "all", out;
};

const char* const usage =
    "usage: update_points [--points N] [--precision fp64|fp32|all] [--tangent full|compact|all]\n"
    "                     [--repetitions N] [--out FILE.json]\n\n"
    "One step of N muscle points (default 2000000) on the CUDA device, checked against the CPU and\n"
    "timed, as is a copy of as many bytes; the median of the repetitions (default 21). --out writes\n"
    "what was measured as JSON. Exits with 1 if device and CPU differ by more than rounding, or where\n"
    "there is no device.\n";

std::size_t count(const std::string& option, const std::string& text, std::size_t most) {
  double x;
  if (!common::to_number(text, x) || !(x >= 1 && x <= static_cast<double>(most)) || x != std::floor(x))
    stop(option + " " + common::visible(text) + ": a whole number from 1 to " + std::to_string(most) +
         " is needed");
  return static_cast<std::size_t>(x);
}

Options parse(int argc, char** argv) {
  Options o;
  for (int k = 1; k < argc; ++k) {
    const std::string option = argv[k];
    if (option == "--help") {
      common::print(usage);
      std::exit(0);
    }
    if (option != "--points" && option != "--precision" && option != "--tangent" &&
        option != "--repetitions" && option != "--out")
      stop("no option " + common::visible(option) + "; --help lists them");
    if (k + 1 == argc || !*argv[k + 1]) stop(option + " needs a value");
    const std::string text = argv[++k];
    const auto one_of = [&](std::string& to, const char* first, const char* second) {
      if (text != first && text != second && text != "all")
        stop(option + " " + common::visible(text) + ": must be " + first + ", " + second + " or all");
      to = text;
    };
    if (option == "--points") o.points = count(option, text, 1000000000);
    if (option == "--repetitions") o.repetitions = static_cast<int>(count(option, text, 10000));
    if (option == "--precision") one_of(o.precision, "fp64", "fp32");
    if (option == "--tangent") one_of(o.tangent, "full", "compact");
    if (option == "--out") o.out = text;
  }
  return o;
}

/// Refuses points that do not fit into the memory of the device or of this machine, whose system would kill
/// the program.
template <Tangent tangent, class V>
void check_memory(std::size_t n) {
  constexpr double in = 9 + 3 + 1, out = 6 + 1 + tangent_size(tangent), copied = (in + out) / 2 * 2;
  std::size_t device = 0, all = 0;
  check(cudaMemGetInfo(&device, &all), "memory of the device");
  const double here =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  const double most =
      std::min(static_cast<double>(device) / (in + out + copied), here / (in + 2 * out)) / sizeof(V);
  if (static_cast<double>(n) > most)
    stop("--points " + std::to_string(n) + ": at most " + std::to_string(static_cast<std::size_t>(most)) +
         " fit into memory");
}

/// Checks and times one case; adds its figures to the JSON. False if device and CPU do not agree.
template <Tangent tangent, class V>
bool run(const Options& o, const std::string& device, std::ostringstream& json) {
  const std::size_t n = o.points, bytes = n * sizeof(V) * traffic(tangent);
  const char* const precision = sizeof(V) == 8 ? "fp64" : "fp32";
  const char* const kind = tangent == Tangent::full ? "full" : "compact";
  const FibreGrowth<V> muscle;  // the paper's Table 1
  check_memory<tangent, V>(n);
  const Inputs<V> in(n);

  Results<V> on_cpu(n, tangent), from_device(n, tangent);
  const Arrays<V> host = arrays(in, on_cpu);
  for (std::ptrdiff_t i = 0; i < host.n; ++i) {
    if (step<tangent>(muscle, host, i) != UpdateStatus::ok) stop("a point has no result on the CPU");
  }

  const OnDevice<V> F(in.F), n0(in.n0), G_n(in.G_n), dt(in.dt);
  const OnDevice<V> stress(6 * n), G(n), moduli(from_device.tangent.size());
  const OnDevice<unsigned long long> failed(std::vector<unsigned long long>{0});
  const OnDevice<char> copy_from(bytes / 2), copy_to(bytes / 2);  // read and written: together `bytes`
  const Arrays<V> there{host.n, F.data, n0.data, G_n.data, dt.data, stress.data, G.data, moduli.data};
  const auto blocks = static_cast<unsigned>((n + block_threads - 1) / block_threads);
  const auto launch = [&] {
    update<tangent><<<blocks, block_threads>>>(muscle, there, failed.data);
    check(cudaGetLastError(), "launch");
  };
  const auto copy = [&] {
    check(cudaMemcpyAsync(copy_to.data, copy_from.data, bytes / 2, cudaMemcpyDeviceToDevice), "copy");
  };

  launch();
  copy();
  check(cudaDeviceSynchronize(), "update");
  stress.get(from_device.stress), G.get(from_device.G), moduli.get(from_device.tangent);
  std::vector<unsigned long long> failures(1);
  failed.get(failures);
  const Differences d = largest_differences<tangent>(muscle, from_device, on_cpu);
  // Device and CPU round differently: fused operations, other logarithms and powers.
  const double rounding = 64 * static_cast<double>(std::numeric_limits<V>::epsilon());
  const bool agree = failures[0] == 0 && d.G <= rounding && d.stress <= rounding && d.tangent <= rounding;

  std::vector<double> update_times, copy_times;
  for (int r = 0; r < o.repetitions; ++r) {
    copy_times.push_back(seconds(copy));
    update_times.push_back(seconds(launch));
  }
  const double time = median(update_times), copy_rate = static_cast<double>(bytes) / median(copy_times);
  const double points = static_cast<double>(n) / time, rate = static_cast<double>(bytes) / time;
  char line[400];
  std::snprintf(line, sizeof line,
                "%s %-7s  %8.1f million points/s  %7.1f GB/s  copy %7.1f GB/s  share %5.1f %%  "
                "differences %.1e %.1e %.1e%s\n",
                precision, kind, points * 1e-6, rate * 1e-9, copy_rate * 1e-9, 100 * rate / copy_rate, d.G,
                d.stress, d.tangent, agree ? "" : "  DIFFERS FROM THE CPU");
  common::print(line);
  json << (json.tellp() > 0 ? ",\n" : "") << "  {\"device\": \"" << device << "\", \"precision\": \""
       << precision << "\", \"tangent\": \"" << kind << "\", \"points\": " << n
       << ", \"bytes_per_point\": " << sizeof(V) * traffic(tangent) << ", \"points_per_second\": " << points
       << ", \"bytes_per_second\": " << rate << ", \"copy_bytes_per_second\": " << copy_rate
       << ", \"share_of_copy\": " << rate / copy_rate << ", \"largest_difference_of_G\": " << d.G
       << ", \"of_stress\": " << d.stress << ", \"of_tangent\": " << d.tangent
       << ", \"points_without_result\": " << failures[0] << "}";
  return agree;
}

/// All cases that are asked for; false if device and CPU do not agree.
bool run_all(int argc, char** argv) {
  const Options o = parse(argc, argv);
  int devices = 0;
  const cudaError_t found = cudaGetDeviceCount(&devices);
  if (found != cudaSuccess || devices == 0)
    stop(std::string("no CUDA device: ") + (found == cudaSuccess ? "none found" : cudaGetErrorString(found)));
  cudaDeviceProp device;
  check(cudaGetDeviceProperties(&device, 0), "device");
  // Before the first case, so that what cannot be written is known at once.
  std::optional<common::Output> file;
  if (!o.out.empty()) file.emplace(o.out);
  common::print(std::string(device.name) + ", " + std::to_string(o.points) +
                " points; differences from the CPU: G, stress, DDSDDE\n");

  std::ostringstream json;
  bool agree = true;
  const auto wanted = [](const std::string& option, const char* what) {
    return option == "all" || option == what;
  };
  if (wanted(o.precision, "fp64") && wanted(o.tangent, "full"))
    agree &= run<Tangent::full, double>(o, device.name, json);
  if (wanted(o.precision, "fp64") && wanted(o.tangent, "compact"))
    agree &= run<Tangent::compact, double>(o, device.name, json);
  if (wanted(o.precision, "fp32") && wanted(o.tangent, "full"))
    agree &= run<Tangent::full, float>(o, device.name, json);
  if (wanted(o.precision, "fp32") && wanted(o.tangent, "compact"))
    agree &= run<Tangent::compact, float>(o, device.name, json);
  if (file) {
    *file << "[\n" << json.str() << "\n]\n";
    file->close();
  }
  return agree;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    common::check_standard_streams();
    return run_all(argc, argv) ? 0 : 1;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "update_points: not enough memory; --points takes fewer\n");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "update_points: %s\n", e.what());
  }
  return 1;
}
