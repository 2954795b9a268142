// Runs one of our variants over growing points a given number of times, for a tool that counts instructions:
//   instructions VARIANT GAMMA PASSES     (without arguments: compiler and flags, and the variants)
// count_instructions.py takes the difference of two runs with different numbers of passes, in which
// everything except the variant cancels.
#include <cstdio>
#include <cstdlib>

#include "variants.hpp"

int main(int argc, char** argv) {
  using namespace bench;
  const std::vector<Variant> variants = ours();
  if (argc == 1) {
    std::printf("%s\n", MYOGROWTH_BUILT_WITH);
    for (const Variant& variant :
         variants) {  // valgrind has no AVX-512, and `fastest` depends on the machine
      if (variant.isa == Isa::base || variant.isa == Isa::avx2) std::printf("%s\n", variant.name.c_str());
    }
    return 0;
  }
  if (argc != 4) return 2;
  const Points points(in_cache);
  memory.resize(room * points.size);
  const Work work{points, active, std::atof(argv[2]), 0, points.size};
  for (const Variant& variant : variants) {
    if (variant.name != argv[1]) continue;
    for (int pass = std::atoi(argv[3]); pass > 0; --pass) variant.pass(work);
    std::printf("%zu\n", points.size);  // points per pass
    return 0;
  }
  std::fprintf(stderr, "no variant '%s'\n", argv[1]);
  return 2;
}
