// The rows of reference_rows against the DLLs as Abaqus on Windows loads them, the C API and each batch:
// check_rows ROWS [STANDARD_U.DLL EXPLICIT_U_D.DLL]. With SINGLE_FILE: against the single file, which is
// linked.
#include <windows.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "../../../abi/abaqus.h"

#ifndef SINGLE_FILE
#include <myogrowth.h>

#include <myogrowth/kernel.hpp>

#include "../../../abi/block.hpp"
#endif

namespace {

struct Row {
  double props[9], G, dt, F[9], G_end, stress[6], ddsdde[36];
};

std::vector<Row> read(const char* name) {
  std::ifstream file(name);
  std::vector<Row> rows;
  Row r;
  while (file.read(nullptr, 0)) {
    double* x = reinterpret_cast<double*>(&r);
    for (unsigned i = 0; i < sizeof r / sizeof *x; ++i) {
      if (!(file >> x[i])) return rows;
    }
    rows.push_back(r);
  }
  return rows;
}

int failed = 0;

struct Worst {
  double G = 0, stress = 0, ddsdde = 0;
  void take(const Row& r, double G_end, const double* s, const double* D) {
    const auto error = [](const double* a, const double* b, int n) {
      double d = 0, size = 0;
      for (int i = 0; i < n; ++i) d += (a[i] - b[i]) * (a[i] - b[i]), size += b[i] * b[i];
      const double e = std::sqrt(d / size);
      return std::isnan(e) ? 1e300 : e;
    };
    G = std::max(G, error(&G_end, &r.G_end, 1));
    stress = std::max(stress, error(s, r.stress, 6));
    ddsdde = std::max(ddsdde, error(D, r.ddsdde, 36));
  }
  void report(const char* name) const {
    std::printf("%-22s G %.1e  stress %.1e  DDSDDE %.1e\n", name, G, stress, ddsdde);
    if (!(G < 1e-13 && stress < 1e-12 && ddsdde < 1e-11)) ++failed;
  }
};

void check_umat(const char* name, Umat* umat, const std::vector<Row>& rows) {
  Worst worst;
  for (const Row& r : rows) {
    double stress[6] = {}, statev[8] = {r.G}, ddsdde[36], zero[9] = {}, sse, spd = 0, scd = 0, rpl, ddsddt[6],
           drplde[6], drpldt, pnewdt = 1, one = 1;
    const int three = 3, six = 6, eight = 8, nine = 9, kstep[4] = {1, 1, 1, 0}, k = 1;
    const char cmname[81] = "MUSCLE";
    umat(stress, statev, ddsdde, &sse, &spd, &scd, &rpl, ddsddt, drplde, &drpldt, zero, zero, zero, &r.dt,
         zero, zero, zero, zero, cmname, &three, &three, &six, &eight, r.props, &nine, zero, zero, &pnewdt,
         &one, r.F, r.F, &k, &k, &k, &k, kstep, &k);
    worst.take(r, statev[0], stress, ddsdde);
  }
  worst.report(name);
}

template <class Routine>
Routine* routine(const char* file, const char* name) {
  const HMODULE library = LoadLibraryA(file);
  if (!library) {
    std::printf("%s: LoadLibrary fails with error %lu\n", file, GetLastError());
    std::exit(1);
  }
  const FARPROC address = GetProcAddress(library, name);
  if (!address) {
    std::printf("%s: has no %s\n", file, name);
    std::exit(1);
  }
  return reinterpret_cast<Routine*>(reinterpret_cast<void*>(address));
}

#ifndef SINGLE_FILE
void check_c_api(const std::vector<Row>& rows) {
  Worst one;
  for (const Row& r : rows) {
    double state[9] = {r.G}, stress[6], ddsdde[36];
    char why[200] = "";
    if (myogrowth_update(r.props, 9, r.F, state, state, 9, r.dt, MYOGROWTH_CAUCHY, stress, ddsdde, nullptr,
                         why, sizeof why) != MYOGROWTH_OK) {
      std::printf("%s\n", why), ++failed;
    }
    one.take(r, state[0], stress, ddsdde);
  }
  one.report("myogrowth_update");
}

// All lanes of a block get the same point: none may differ.
void check_block(const char* name, MyogrowthUpdateBlock* update, const std::vector<Row>& rows) {
  Worst worst;
  constexpr int size = myogrowth_block_points;
  static MyogrowthBlock memory[2];
  // Anywhere a caller's stack may put it: as much as 8 bytes off any alignment.
  MyogrowthBlock& b = *reinterpret_cast<MyogrowthBlock*>(reinterpret_cast<char*>(memory) + 8);
  for (const Row& r : rows) {
    const double* const p = r.props;
    myogrowth::FibreGrowth<double> material;
    material.c1 = p[0], material.c2 = p[1], material.growth = {p[2], p[3], p[4], p[5]};
    for (int k = 0; k < size; ++k) {
      for (int i = 0; i < 9; ++i) b.number[myogrowth_row_F + k + size * i] = r.F[i];
      for (int i = 0; i < 3; ++i) b.number[myogrowth_row_n0 + k + size * i] = r.props[6 + i];
      b.number[myogrowth_row_G + k] = r.G;
      b.number[myogrowth_row_lambda + k] = 1;
    }
    b.dt = r.dt;
    b.stretch_is_checked = b.is_known = b.is_given = false;
    b.n_in = b.n_out = 0;
    b.stress = b.tangent = -1;
    for (int i = 0; i < 3; ++i) b.fibre[i] = r.props[6 + i];
    update(&material, size, 0, 1, &b);
    for (int k = 0; k < size; ++k) {
      double stress[6], ddsdde[36];
      for (int i = 0; i < 6; ++i) stress[i] = b.number[myogrowth_row_stress + k + size * i];
      for (int i = 0; i < 36; ++i) ddsdde[i] = b.number[myogrowth_row_tangent + k + size * i];
      worst.take(r, b.number[myogrowth_row_G_end + k], stress, ddsdde);
    }
  }
  worst.report(name);
}

// A pull along 11 without rotation, of which the VUMAT and the UMAT must say the same.
void check_vumat(Vumat* vumat, Umat* umat) {
  const double props[9] = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0};
  const int n = 40, three = 3, eight = 8, nine = 9, none = 0;
  std::vector<double> U(6 * n), one(n, 1), zero(9 * n), state(8 * n), stress(6 * n), state_new(8 * n),
      energy(n), inelastic(n);
  for (int i = 0; i < n; ++i) U[i] = 1 + 0.005 * i, U[i + n] = U[i + 2 * n] = 1 - 0.001 * i;
  const double dt = 0.1, time = 1;
  const char name[81] = "MUSCLE";
  vumat(&n, &three, &three, &eight, &none, &nine, &none, &time, &time, &dt, name, zero.data(), one.data(),
        props, one.data(), zero.data(), zero.data(), zero.data(), U.data(), zero.data(), zero.data(),
        zero.data(), state.data(), zero.data(), zero.data(), zero.data(), U.data(), zero.data(), zero.data(),
        stress.data(), state_new.data(), energy.data(), inelastic.data());
  double worst = 0;
  for (int i = 0; i < n; ++i) {
    const double F[9] = {U[i], 0, 0, 0, U[i + n], 0, 0, 0, U[i + 2 * n]};
    double s[6] = {}, statev[8] = {}, D[36], nothing[9] = {}, sse, spd = 0, scd = 0, rpl, a[6], b[6], c,
           pnewdt = 1, l = 1;
    const int six = 6, kstep[4] = {1, 1, 1, 0}, k = 1;
    umat(s, statev, D, &sse, &spd, &scd, &rpl, a, b, &c, nothing, nothing, nothing, &dt, nothing, nothing,
         nothing, nothing, name, &three, &three, &six, &eight, props, &nine, nothing, nothing, &pnewdt, &l, F,
         F, &k, &k, &k, &k, kstep, &k);
    for (int j = 0; j < 3; ++j) worst = std::max(worst, std::abs(stress[i + n * j] - s[j]));
    worst = std::max(worst, std::abs(state_new[i] - statev[0]));
  }
  std::printf("VUMAT against UMAT     %.1e\n", worst);
  if (!(worst < 1e-13) || state_new[n - 1] < 1.001) ++failed;
}
#endif

}  // namespace

int main(int argc, char** argv) {
  const std::vector<Row> rows = argc > 1 ? read(argv[1]) : std::vector<Row>();
  std::printf("%u rows\n", static_cast<unsigned>(rows.size()));
  if (rows.size() != 400) return 1;
#ifdef SINGLE_FILE
  check_umat("single file", MYOGROWTH_FORTRAN(umat, UMAT), rows);
#else
  if (argc != 4) return 2;
  Umat* umat = routine<Umat>(argv[2], "UMAT");
  check_umat(argv[2], umat, rows);
  check_vumat(routine<Vumat>(argv[3], "VUMAT"), umat);
  check_c_api(rows);
  check_block("batch, SSE2", myogrowth_update_block_base, rows);
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    check_block("batch, AVX2", myogrowth_update_block_avx2, rows);
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
    check_block("batch, AVX-512", myogrowth_update_block_avx512, rows);
  }
#endif
  return failed != 0;
}
