// Linked into tests that are compiled for a larger instruction set: on a machine without it they end as
// skipped. This file is compiled for the baseline and runs before any other code, static initialisers
// included.
#include <unistd.h>
#include <cstdio>

namespace {

__attribute__((constructor(101))) void skip_where_it_is_missing() {
  __builtin_cpu_init();
  if (MYOGROWTH_NEEDS_ISA) return;
  std::puts("skipped: this machine lacks the instructions that these tests are compiled for");
  std::fflush(stdout);
  _exit(77);
}

}  // namespace
