// Coverage-guided fuzzing of the UMAT under the sanitizers (clang's libFuzzer): whatever a host passes,
// nothing crashes, what is not allowed is reported, STATEV stays clean, and a result is a result.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "../support/umat_host.hpp"
#include "bytes.hpp"
#include "rules.hpp"

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

/// What the manual says is not allowed.
bool is_faulty(const host::Call& c) {
  const bool solid = c.ntens == 6 && c.n_direct() == 3 && c.n_shear() == 3;
  const bool plane = c.n_shear() == 1 && (c.ntens == 4 || c.ntens == 3) && c.n_direct() == c.ntens - 1;
  if (!solid && !plane) return true;
  if (rules::is_in_elmers_order(c.ntens, c.F.data())) return true;
  const double hybrid = c.props.size() > 17 ? c.props[17] : 0;
  if (hybrid != 0 && (hybrid != 1 || c.ntens == 3)) return true;
  const bool has_law = c.props.size() > 18 && c.props[18] != 0;
  if (has_law ? rules::law_is_faulty(c.props, c.predef + c.dpred) : rules::props_are_faulty(c.props, 18))
    return true;
  return rules::has_no_room(c.props, c.statev.size()) || rules::state_is_faulty(c.props, c.statev) ||
         rules::has_no_fibre(c.props, c.statev);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes{data, size};
  host::Call c;
  const unsigned kind = bytes.byte();
  const int families[] = {6, 6, 4, 3};
  c.ntens = kind < 240 ? families[kind % 4] : static_cast<int>(kind % 7) - 1;
  c.props.resize(kind % 5 == 0 ? bytes.byte() % 20 : kind % 3 == 1 ? 18 : 9 + kind % 3);
  c.statev.resize(kind % 7 == 0 ? bytes.byte() % 14 : 9);
  for (int i = 0; i < 9; ++i) c.F(i) = bytes.number() + (kind % 2 && i % 4 == 0 ? 1 : 0);
  c.dtime = bytes.number();
  c.pnewdt = kind % 3 == 0 ? bytes.number() : 1;
  for (double& x : c.statev) x = bytes.number();
  for (double& x : c.props) x = bytes.number();
  c.J_hat = bytes.number();
  if (bytes.byte() >= 250) {
    c.ndi = static_cast<int>(bytes.byte() % 6) - 1;
    c.nshr = static_cast<int>(bytes.byte() % 6) - 1;
  }

  const unsigned law = bytes.byte();
  if (law % 3 == 1) {  // an elastic law, with as many of its entries as the bytes say
    c.props.resize(19 + law / 3 % 14);
    c.props[0] = c.props[1] = 0;
    c.props[18] = 1 + bytes.byte() % 4 % 3;
    for (std::size_t i = 19; i < c.props.size(); ++i) c.props[i] = i == 28 && law & 1 ? 0 : bytes.number();
    if (c.props.size() > 19 && law & 64) c.props[19] = -1;
    c.predef = bytes.number(), c.dpred = bytes.number();
  }

  const host::Call before = c;
  message.clear();
  c.run();

  if (is_faulty(before)) require(!message.empty(), "a fault was not reported", before);
  if (!message.empty()) require(is_faulty(before), "a fault was reported that is none", before);
  const int n = c.ntens > 0 ? c.ntens : 0;
  bool finite = n > 0;
  for (int i = 0; i < n; ++i) finite = finite && std::isfinite(c.stress[i]);
  for (int i = 0; i < n * n; ++i) finite = finite && std::isfinite(c.ddsdde(i));
  if (c.is_hybrid() && message.empty()) finite = finite && std::isfinite(c.K) && std::isfinite(c.dK_dJ);
  if (!finite) {
    require(c.pnewdt <= 0.25, "no result, and no smaller step asked for", before);
    require(rules::same_bits(c.statev, before.statev), "no result, and STATEV was touched", before);
    for (int i = 0; i < n; ++i) require(std::isnan(c.stress[i]), "no result, and STRESS is not NaN", before);
    for (int i = 0; i < n * n; ++i)
      require(std::isnan(c.ddsdde(i)), "no result, and DDSDDE is not NaN", before);
    require(std::isnan(c.sse), "no result, and SSE is not NaN", before);
    return 0;
  }
  require(message.empty(), "a result in spite of a fault", before);
  const bool advised = before.props.size() > 12 && before.props[12] > 0;
  require(advised || c.pnewdt == before.pnewdt || (std::isnan(c.pnewdt) && std::isnan(before.pnewdt)),
          "PNEWDT was touched", before);
  const double G_n = before.statev[0] == 0 ? 1 : before.statev[0];
  const double least = rules::removes(c.props) ? std::min(G_n, c.props[15]) : G_n;
  require(c.statev[0] >= least && c.statev[0] <= std::max(G_n, c.props[4]), "G is out of bounds", before);
  for (std::size_t i = 0; i < c.statev.size() && i < 8; ++i) {
    require(i >= 5 && c.statev.size() < 8 ? true : std::isfinite(c.statev[i]), "STATEV is not finite",
            before);
  }
  require(std::isfinite(c.sse), "SSE is not finite", before);
  return 0;
}
