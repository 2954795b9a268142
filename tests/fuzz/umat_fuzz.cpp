// Coverage-guided fuzzing of the UMAT under the sanitizers (clang's libFuzzer): whatever a host passes,
// nothing crashes, what is not allowed is reported, STATEV stays clean, and a result is a result.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "../support/umat_host.hpp"

namespace {
std::string message;
}

extern "C" {
void stdb_abqerr_(const int*, const char* text, const int*, const void*, const char*, std::size_t length,
                  std::size_t) {
  message.assign(text, length);
}
void xit_() {}
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
}

namespace {

/// Reads numbers off the fuzzer's bytes: telling ones by a single byte, any by nine. Zeros at the end.
struct Bytes {
  const std::uint8_t* at;
  std::size_t left;

  unsigned byte() {
    if (left == 0) return 0;
    --left;
    return *at++;
  }
  double number() {
    static const double telling[] = {0,    1,      -1,       1.1,  1.01,      0.5,    2,    16,
                                     4,    1e-300, 1e300,    1e-8, 1 + 1e-15, 0.999,  -0.3, 3,
                                     1e-3, 100,    INFINITY, NAN,  5e-324,    -1e-320};
    const unsigned choice = byte();
    constexpr unsigned n = sizeof telling / sizeof *telling;
    if (choice < 200) return telling[choice % n];
    double x = 0;
    unsigned char raw[8];
    for (unsigned char& b : raw) b = static_cast<unsigned char>(byte());
    std::memcpy(&x, raw, 8);
    return x;
  }
};

void require(bool holds, const char* what, const host::Call& c) {
  if (holds) return;
  std::fprintf(stderr, "FAILED: %s\nmessage: %s\nNTENS %d DTIME %.17g PNEWDT %.17g\nPROPS", what,
               message.c_str(), c.ntens, c.dtime, c.pnewdt);
  for (double x : c.props) std::fprintf(stderr, " %.17g", x);
  std::fprintf(stderr, "\nSTATEV");
  for (double x : c.statev) std::fprintf(stderr, " %.17g", x);
  std::fprintf(stderr, "\nF (column by column)");
  for (int i = 0; i < 9; ++i) std::fprintf(stderr, " %.17g", c.F(i));
  std::fprintf(stderr, "\n");
  std::abort();
}

/// What the manual says is not allowed, in words of its own.
bool is_faulty(const host::Call& c) {
  const auto& p = c.props;
  const std::size_t n = p.size();
  if ((c.ntens != 6 && c.ntens != 4 && c.ntens != 3) || n < 6 || c.statev.empty()) return true;
  for (double x : p) {
    if (!std::isfinite(x)) return true;
  }
  if (!(p[1] > 0) || !(p[0] > -2 * p[1] / 3) || !(p[2] > 0) || p[3] < 0 || !(p[4] > 1) || !(p[5] > 0))
    return true;
  for (std::size_t i = 9; i < n; ++i) {
    if (p[i] != 0 && (i >= 11 || p[i] != 1)) return true;
  }
  if (!std::isfinite(c.statev[0]) || c.statev[0] < 0) return true;
  double n0[3] = {n > 6 ? p[6] : 1, n > 7 ? p[7] : 0, n > 8 ? p[8] : 0};
  if (c.statev.size() >= 8) {
    const double* s = &c.statev[5];
    if (!std::isfinite(s[0]) || !std::isfinite(s[1]) || !std::isfinite(s[2])) return true;
    if (s[0] != 0 || s[1] != 0 || s[2] != 0) std::copy(s, s + 3, n0);
  }
  return n0[0] == 0 && n0[1] == 0 && n0[2] == 0;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes{data, size};
  host::Call c;
  const unsigned kind = bytes.byte();
  const int families[] = {6, 6, 4, 3};
  c.ntens = kind < 240 ? families[kind % 4] : static_cast<int>(kind % 7) - 1;
  c.props.resize(kind % 5 == 0 ? bytes.byte() % 20 : 9 + kind % 3);
  c.statev.resize(kind % 7 == 0 ? bytes.byte() % 14 : 9);
  for (int i = 0; i < 9; ++i) c.F(i) = bytes.number() + (kind % 2 && i % 4 == 0 ? 1 : 0);
  c.dtime = bytes.number();
  c.pnewdt = kind % 3 == 0 ? bytes.number() : 1;
  for (double& x : c.statev) x = bytes.number();
  for (double& x : c.props) x = bytes.number();

  const host::Call before = c;
  message.clear();
  c.run();

  if (is_faulty(before)) require(!message.empty(), "a fault was not reported", before);
  if (!message.empty()) require(is_faulty(before), "a fault was reported that is none", before);
  const int n = c.ntens > 0 ? c.ntens : 0;
  bool finite = n > 0;
  for (int i = 0; i < n; ++i) finite = finite && std::isfinite(c.stress[i]);
  for (int i = 0; i < n * n; ++i) finite = finite && std::isfinite(c.ddsdde(i));
  if (!finite) {
    require(c.pnewdt <= 0.25, "no result, and no smaller step asked for", before);
    require(same_bits(c.statev, before.statev), "no result, and STATEV was touched", before);
    for (int i = 0; i < n; ++i) require(std::isnan(c.stress[i]), "no result, and STRESS is not NaN", before);
    return 0;
  }
  require(message.empty(), "a result in spite of a fault", before);
  require(c.pnewdt == before.pnewdt || (std::isnan(c.pnewdt) && std::isnan(before.pnewdt)),
          "PNEWDT was touched", before);
  const double G_n = before.statev[0] == 0 ? 1 : before.statev[0];
  require(c.statev[0] >= G_n && c.statev[0] <= std::max(G_n, c.props[4]), "G is out of bounds", before);
  for (std::size_t i = 0; i < c.statev.size() && i < 8; ++i) {
    require(i >= 5 && c.statev.size() < 8 ? true : std::isfinite(c.statev[i]), "STATEV is not finite",
            before);
  }
  require(std::isfinite(c.sse), "SSE is not finite", before);
  return 0;
}
