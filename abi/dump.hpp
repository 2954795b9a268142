/// @file
/// Where a call gave no result: the call itself in a file, which the one-element driver replays. Off unless
/// the environment variable MYOGROWTH_DUMP names a folder.
#ifndef MYOGROWTH_ABI_DUMP_HPP
#define MYOGROWTH_ABI_DUMP_HPP

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <myogrowth/version.hpp>

#include "properties.hpp"

namespace myogrowth {
namespace abi {

constexpr int most_dumps = 20;      ///< of a process: a run that diverges must not fill the disk
constexpr int most_names = 1000;    ///< in a folder, which many processes may share
constexpr int most_entries = 1000;  ///< of PROPS and of STATEV; as many as the driver reads

/// All that the UMAT reads of its arguments, as they were on entry.
struct UmatCall {
  int ntens, ndi, nshr, nstatv, nprops;
  const double *statev, *props, *dfgrd1;
  double dtime, pnewdt;
  const double* J_hat;           ///< STRESS(NTENS+1) of a mixed element, else null
  const double *predef, *dpred;  ///< field variable 1 and its increment where they are read, else null
};

/// A number that Fortran and C read back to the same bits, whatever locale the host has set.
inline void write_number(std::FILE* file, double x) {
  if (!is_finite(x)) {
    std::fputs(x > 0 ? "Infinity" : x < 0 ? "-Infinity" : "NaN", file);
    return;
  }
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.17g", x);
  for (char* c = digits; *c; ++c) std::fputc(*c == ',' ? '.' : *c, file);
}

/// The n entries of PROPS or STATEV, one a line with its symbol, and their number.
template <class Entry>
void write_entries(std::FILE* file, const char* count, const char* name, const double* x, int n,
                   const Entry& (*entry)(int), int n_known) {
  const int listed = n < most_entries ? n : most_entries;
  std::fprintf(file, "  %s = %d\n", count, n);
  if (listed > 0) std::fprintf(file, "  %s =\n", name);
  if (listed < n) std::fprintf(file, "  ! the first %d of them only, more than can be replayed\n", listed);
  for (int i = 0; i < listed; ++i) {
    std::fputs("    ", file);
    write_number(file, x[i]);
    std::fprintf(file, "%s  ! %d %s\n", i + 1 < listed ? "," : "", i + 1, i < n_known ? entry(i).symbol : "");
  }
}

inline void write_call(std::FILE* file, int number, const UmatCall& call, const char* fault) {
  std::fprintf(
      file,
      "! A call that gave no result, as the UMAT of myogrowth %d.%d.%d got it. To make the call again:\n"
      "!   myogrowth_driver --replay umat_%d.nml\n"
      "&point\n"
      "  fault = \"%s\"\n"
      "  ntens = %d\n"
      "  ndi = %d\n"
      "  nshr = %d\n"
      "  dtime = ",
      MYOGROWTH_VERSION_MAJOR, MYOGROWTH_VERSION_MINOR, MYOGROWTH_VERSION_PATCH, number, fault, call.ntens,
      call.ndi, call.nshr);
  write_number(file, call.dtime);
  std::fputs("\n  pnewdt = ", file);
  write_number(file, call.pnewdt);
  std::fputs("\n  dfgrd1 =  ! row by row: 11 12 13, 21 22 23, 31 32 33\n", file);
  for (int i = 0; i < 9; ++i) {
    std::fputs(i % 3 == 0 ? "    " : " ", file);
    write_number(file, call.dfgrd1[i / 3 + 3 * (i % 3)]);
    std::fputs(i == 8 ? "\n" : i % 3 == 2 ? ",\n" : ",", file);
  }
  const auto write_if_there = [&](const char* name, const double* x, const char* meaning) {
    if (!x) return;
    std::fprintf(file, "  %s = ", name);
    write_number(file, *x);
    std::fprintf(file, "  ! %s\n", meaning);
  };
  write_if_there("jhat", call.J_hat, "the mixed element's volume ratio");
  write_if_there("predef", call.predef, "field variable 1, the activation");
  write_if_there("dpred", call.dpred, "its increment");
  write_entries(file, "nprops", "props", call.props, call.nprops, property, n_props);
  write_entries(file, "nstatv", "statev", call.statev, call.nstatv, state_variable, n_statev);
  std::fputs("/\n", file);
}

/// Writes the call to umat_1.nml, umat_2.nml, ..., the first that is not there yet, in the folder that
/// MYOGROWTH_DUMP names, if any. Where that cannot be done it says so once and is off from then on.
inline void dump(const UmatCall& call, const char* fault) {
  const char* folder = std::getenv("MYOGROWTH_DUMP");
  if (!folder || !*folder) return;
  static std::atomic<int> dumps{0};
  if (dumps >= most_dumps || dumps++ >= most_dumps) return;  // the first so that it cannot wrap around

  char path[4096 + 32] = "";  // no system's paths are longer than 4096
  std::FILE* file = nullptr;
  int number = 0;
  do {
    const int length = std::snprintf(path, sizeof path, "%s/umat_%d.nml", folder, ++number);
    errno = ENAMETOOLONG;
    if (length < 0 || length >= static_cast<int>(sizeof path)) break;
    file = std::fopen(path, "wx");  // x: of two threads or processes, only one gets the name
  } while (!file && errno == EEXIST && number < most_names);
  if (file) {
    write_call(file, number, call, fault);
    const bool incomplete = std::ferror(file) != 0;
    if (std::fclose(file) == 0 && !incomplete) return;
  }
  const int reason = errno;
  if (file) std::remove(path);  // half a call is of no use
  static std::atomic<bool> told{false};
  dumps = most_dumps;
  if (told.exchange(true)) return;
  std::fprintf(stderr, "myogrowth UMAT: MYOGROWTH_DUMP = %s: umat_%d.nml cannot be written there: %s.\n",
               folder, number, std::strerror(reason));
}

}  // namespace abi
}  // namespace myogrowth

#endif
