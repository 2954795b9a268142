// The variants that are timed and counted. Each is one line in `ours` or `peers`: a name, how many numbers
// per point it reads and writes, how well it must agree with the kernel, a function that works through a
// range of points, and one that reads its result at one of them.
#ifndef MYOGROWTH_BENCH_VARIANTS_HPP
#define MYOGROWTH_BENCH_VARIANTS_HPP

#include <dlfcn.h>
#include <myogrowth.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <myogrowth/kernel.hpp>
#include <myogrowth/many/laws.hpp>
#include <string>

#include "../abi/abaqus.h"
#include "points.hpp"

namespace bench {

constexpr double gammas[] = {2, 2.5};
constexpr std::size_t in_cache = 64;  ///< points per thread: 29 KB of the batch's data, which fit into L1
constexpr std::size_t streamed = 5 << 16;  ///< points in all: 175 MB through the UMAT, more than caches hold

/// Input of a pass over the points [first, last).
struct Work {
  const Points& points;
  Growth growth;
  double gamma;
  std::size_t first, last;
};

/// Outputs, shared by all variants: room for 50 numbers per point.
constexpr std::size_t room = 6 + 36 + nstatv;
inline Numbers memory;

/// The kernel's result for one point.
struct Result {
  double tau[6], c[36], G;
};

/// The instruction set of a variant's code; `fastest`: chosen at run time.
enum class Isa { base, avx2, avx512, fastest };
inline bool has(Isa isa) {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (isa == Isa::avx2) return avx2;
  if (isa == Isa::avx512) {
    return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  }
  return true;
#else
  return isa == Isa::base || isa == Isa::fastest;
#endif
}

using Pass = std::function<void(const Work&)>;
using Reader = std::function<Result(const Work&, std::size_t point)>;

struct Variant {
  std::string name;
  int numbers_read, numbers_written;  ///< per point
  double tolerance;
  Pass pass;
  Reader read;
  bool with_tangent = true;
  Isa isa = Isa::base;
  bool second_order = false;  ///< the second-order step
};

inline myogrowth::FibreGrowth<double> material(double gamma, bool second_order = false) {
  myogrowth::FibreGrowth<double> m;
  m.growth.gamma = gamma;
  if (second_order) m.integration = myogrowth::TimeIntegration::midpoint_flow;
  return m;
}

// --- our kernel

inline void kernel_point(const Work& w, const myogrowth::FibreGrowth<double>& m, std::size_t p, double* tau,
                         double* c, double& G) {
  myogrowth::PointUpdate<double> u;
  update_point(m, &w.points.F[9 * p], &w.points.n0[3 * p], w.points.G_n[w.growth][p], w.points.lambda_n[p],
               dtime, u);
  spatial_modulus(u, c);
  std::copy(u.tau, u.tau + 6, tau);
  G = u.G;
}

inline void kernel_pass(bool second_order, const Work& w) {
  const auto m = material(w.gamma, second_order);
  double *tau = memory.data(), *c = tau + 6 * w.points.size, *G = c + 36 * w.points.size;
  for (std::size_t p = w.first; p < w.last; ++p) kernel_point(w, m, p, tau + 6 * p, c + 36 * p, G[p]);
}

inline Result kernel_result(const Work& w, std::size_t p) {
  const double *tau = memory.data(), *c = tau + 6 * w.points.size, *G = c + 36 * w.points.size;
  Result r;
  std::copy_n(tau + 6 * p, 6, r.tau);
  std::copy_n(c + 36 * p, 36, r.c);
  r.G = G[p];
  return r;
}

// --- UMATs, as a host calls them: each in its own library; the state is copied so that it can be used again

inline Umat* load(const std::string& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* symbol = handle ? dlsym(handle, "umat_") : nullptr;
  if (!symbol) {
    std::fprintf(stderr, "%s\n", dlerror());
    std::exit(1);
  }
  return reinterpret_cast<Umat*>(symbol);
}

inline void umat_pass(Umat* umat, bool second_order, const Work& w) {
  const std::vector<double> constants = props(w.gamma, second_order);
  const int nprops = static_cast<int>(constants.size()), ndi = 3, nshr = 3, ntens = 6, statev_size = nstatv;
  const int number = 1;
  const double six[6] = {}, time[2] = {}, zero = 0, celent = 1, origin[3] = {};
  const double one[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const char name[81] = "MUSCLE                                                                          ";
  double spd = 0, scd = 0, rpl = 0, ddsddt[6] = {}, drplde[6] = {}, drpldt = 0, sse = 0, pnewdt = 1;
  double *stress = memory.data(), *ddsdde = stress + 6 * w.points.size, *statev = ddsdde + 36 * w.points.size;
  const double* statev_n = w.points.statev_n[w.growth].data();
  for (std::size_t p = w.first; p < w.last; ++p) {
    std::copy_n(statev_n + nstatv * p, nstatv, statev + nstatv * p);
    umat(stress + 6 * p, statev + nstatv * p, ddsdde + 36 * p, &sse, &spd, &scd, &rpl, ddsddt, drplde,
         &drpldt, six, six, time, &dtime, &zero, &zero, &zero, &zero, name, &ndi, &nshr, &ntens, &statev_size,
         constants.data(), &nprops, origin, one, &pnewdt, &celent, one, &w.points.F[9 * p], &number, &number,
         &number, &number, &number, &number);
  }
}

inline Result umat_result(const Work& w, std::size_t p) {
  const double *stress = memory.data(), *ddsdde = stress + 6 * w.points.size,
               *statev = ddsdde + 36 * w.points.size + nstatv * p;
  const double J = statev[3];
  Result r;
  for (std::size_t i = 0; i < 6; ++i) r.tau[i] = J * stress[6 * p + i];
  for (std::size_t i = 0; i < 36; ++i) r.c[i] = J * ddsdde[36 * p + i];
  r.G = statev[0];
  return r;
}

inline Variant umat_variant(const std::string& name, const std::string& library, double tolerance,
                            bool second_order = false) {
  Umat* umat = load(library);
  return {name,
          9 + nstatv,
          6 + 36 + nstatv,
          tolerance,
          [=](const Work& w) { umat_pass(umat, second_order, w); },
          umat_result,
          true,
          Isa::base,
          second_order};
}

// --- the C API for many points, with arrays laid out as for a UMAT

inline void update_n_pass(const Work& w) {
  const std::vector<double> constants = props(w.gamma);
  double *stress = memory.data(), *ddsdde = stress + 6 * w.points.size, *statev = ddsdde + 36 * w.points.size;
  myogrowth_update_n(static_cast<int>(w.last - w.first), constants.data(), static_cast<int>(constants.size()),
                     &w.points.F[9 * w.first], &w.points.statev_n[w.growth][nstatv * w.first],
                     statev + nstatv * w.first, nstatv, dtime, MYOGROWTH_CAUCHY, stress + 6 * w.first,
                     ddsdde + 36 * w.first, nullptr, nullptr, nullptr, 0);
}

// --- the batch, compiled for one instruction set, points in blocks

inline void batch_pass(BenchBatchPass* pass, int tangent, bool second_order, const double* activation,
                       const Work& w) {
  double *stress = memory.data(), *moduli = stress + 6 * w.points.size, *G = moduli + 36 * w.points.size;
  const std::size_t m = w.first;
  const BenchBatch b{static_cast<long>(w.last - w.first),
                     w.gamma,
                     &w.points.F_blocks[9 * m],
                     &w.points.n0_blocks[3 * m],
                     &w.points.G_n[w.growth][m],
                     &dtime,
                     stress + 6 * m,
                     G + m,
                     moduli + static_cast<std::size_t>(tangent) * m,
                     w.points.size == streamed,
                     second_order ? &w.points.lambda_n[m] : nullptr,
                     activation};
  pass(tangent, &b);
}

inline Result batch_result(int tangent, const Work& w, std::size_t p) {
  const double *stress = memory.data(), *moduli = stress + 6 * w.points.size,
               *G = moduli + 36 * w.points.size;
  const double* F = &w.points.F[9 * p];
  const double J = F[0] * (F[4] * F[8] - F[7] * F[5]) - F[3] * (F[1] * F[8] - F[7] * F[2]) +
                   F[6] * (F[1] * F[5] - F[4] * F[2]);
  double sigma[6], x[36];
  for (std::size_t c = 0; c < 6; ++c) sigma[c] = stress[in_blocks(6, p, c)];
  const auto n = static_cast<std::size_t>(tangent);
  for (std::size_t c = 0; c < n; ++c) x[c] = moduli[in_blocks(n, p, c)];
  if (tangent == 7) {
    const myogrowth::CompactTangent<double> compact{{x[0], x[1], x[2]}, x[3], x[4], x[5], x[6]};
    compact.expand(material(w.gamma), sigma, x);
  }
  if (tangent == 19) {
    myogrowth::CompactRoehrleTangent<double> compact{};
    std::copy_n(x, 3, compact.m), std::copy_n(x + 3, 6, compact.b), std::copy_n(x + 9, 6, compact.k);
    compact.kappa = x[15], compact.c01 = x[16], compact.shift = x[17], compact.J = x[18];
    compact.expand(sigma, x);
  }
  Result r;
  for (int i = 0; i < 6; ++i) r.tau[i] = J * sigma[i];
  for (int i = 0; i < 36; ++i) r.c[i] = tangent == 0 ? 0 : J * x[i];
  r.G = G[p];
  return r;
}

inline Variant batch_variant(const std::string& name, BenchBatchPass* pass, int tangent, Isa isa,
                             double tolerance, bool second_order = false,
                             const double* activation = nullptr) {
  return {name,
          second_order ? 14 : 13,
          7 + tangent,
          tolerance,
          [=](const Work& w) { batch_pass(pass, tangent, second_order, activation, w); },
          [=](const Work& w, std::size_t p) { return batch_result(tangent, w, p); },
          tangent > 0,
          isa,
          second_order};
}

// --- all

constexpr double closed_form = 1e-10, by_differences = 1e-6;

/// The variants of this library that this machine can run.
inline std::vector<Variant> ours() {
  std::vector<Variant> all = {
    umat_variant("umat_", "libmyogrowth_umat.so", closed_form),
    {"kernel", 13, 43, closed_form, [](const Work& w) { kernel_pass(false, w); }, kernel_result},
    {"myogrowth_update_n", 9 + nstatv, 42 + nstatv, closed_form, update_n_pass, umat_result, true,
     Isa::fastest},
    batch_variant("batch base, stress", bench_batch_base, 0, Isa::base, closed_form),
    batch_variant("batch base, compact", bench_batch_base, 7, Isa::base, closed_form),
    batch_variant("batch base, full", bench_batch_base, 36, Isa::base, closed_form),
#if defined(__x86_64__)
    batch_variant("batch AVX2, stress", bench_batch_avx2, 0, Isa::avx2, closed_form),
    batch_variant("batch AVX2, compact", bench_batch_avx2, 7, Isa::avx2, closed_form),
    batch_variant("batch AVX2, full", bench_batch_avx2, 36, Isa::avx2, closed_form),
    batch_variant("batch AVX-512, stress", bench_batch_avx512, 0, Isa::avx512, closed_form),
    batch_variant("batch AVX-512, compact", bench_batch_avx512, 7, Isa::avx512, closed_form),
    batch_variant("batch AVX-512, full", bench_batch_avx512, 36, Isa::avx512, closed_form),
#endif
    umat_variant("umat_, second order", "libmyogrowth_umat.so", closed_form, true),
    {"kernel, second order", 14, 43, closed_form, [](const Work& w) { kernel_pass(true, w); }, kernel_result,
     true, Isa::base, true},
    batch_variant("batch base, full, second order", bench_batch_base, 36, Isa::base, closed_form, true),
#if defined(__x86_64__)
    batch_variant("batch AVX2, full, second order", bench_batch_avx2, 36, Isa::avx2, closed_form, true),
    batch_variant("batch AVX-512, full, second order", bench_batch_avx512, 36, Isa::avx512, closed_form,
                  true),
#endif
  };
  all.erase(std::remove_if(all.begin(), all.end(), [](const Variant& v) { return !has(v.isa); }), all.end());
  return all;
}

/// Law 1 in packs. Not among ours(), whose instructions are counted.
inline std::vector<Variant> laws() {
  static constexpr double activation = 0.5;
  std::vector<Variant> all = {
    batch_variant("batch base, law 1, compact", bench_batch_base, 19, Isa::base, closed_form, false,
                  &activation),
    batch_variant("batch base, law 1, full", bench_batch_base, 36, Isa::base, closed_form, false,
                  &activation),
#if defined(__x86_64__)
    batch_variant("batch AVX2, law 1, compact", bench_batch_avx2, 19, Isa::avx2, closed_form, false,
                  &activation),
    batch_variant("batch AVX2, law 1, full", bench_batch_avx2, 36, Isa::avx2, closed_form, false,
                  &activation),
    batch_variant("batch AVX-512, law 1, compact", bench_batch_avx512, 19, Isa::avx512, closed_form, false,
                  &activation),
    batch_variant("batch AVX-512, law 1, full", bench_batch_avx512, 36, Isa::avx512, closed_form, false,
                  &activation),
#endif
  };
  all.erase(std::remove_if(all.begin(), all.end(), [](const Variant& v) { return !has(v.isa); }), all.end());
  return all;
}

/// Implementations as others would write them.
inline std::vector<Variant> peers() {
  return {
      umat_variant("Fortran UMAT, -O2", "libpeer_fortran_O2.so", closed_form),
      umat_variant("Fortran UMAT, -O3 -march=native", "libpeer_fortran_native.so", closed_form),
      umat_variant("Eigen transcription", "libpeer_eigen.so", closed_form),
      umat_variant("forward duals", "libpeer_dual.so", closed_form),
      umat_variant("numerical tangent", "libpeer_numerical.so", by_differences),
  };
}

/// The largest difference from the kernel at point p: of stress in units of c2, of the modulus in those of
/// its largest entry, of G. Infinite if any of them is not a number.
inline double difference(const Variant& variant, const Work& w, std::size_t p) {
  const auto m = material(w.gamma, variant.second_order);
  Result expected;
  kernel_point(w, m, p, expected.tau, expected.c, expected.G);
  const Result r = variant.read(w, p);
  const double scale = *std::max_element(expected.c, expected.c + 36);
  double worst = std::abs(r.G - expected.G), sum = r.G;
  for (int i = 0; i < 6; ++i)
    worst = std::max(worst, std::abs(r.tau[i] - expected.tau[i]) / m.c2), sum += r.tau[i];
  for (int i = 0; i < 36 && variant.with_tangent; ++i)
    worst = std::max(worst, std::abs(r.c[i] - expected.c[i]) / scale), sum += r.c[i];
  return std::isfinite(sum) ? worst : std::numeric_limits<double>::infinity();
}

}  // namespace bench

#endif
