// A day of growth of many fibres by several threads: update_batch over blocks of the points, threads by
// OpenMP. The sum of all results is the same to the last bit for any number of threads.
//   g++ -std=c++17 -O3 -march=native -fopenmp -I include threads.cpp && OMP_NUM_THREADS=2 ./a.out
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <myogrowth/many/batch.hpp>
#include <vector>

int main() {
  using namespace myogrowth;
  const std::ptrdiff_t n = 100003, block = 2048;  // a block's numbers stay in a core's cache
  const FibreGrowth<> muscle;
  const double n0[3] = {1, 0, 0}, dt = 0.1;
  std::vector<double> F(9 * n), G(n, 1.0), stress(6 * n), ddsdde(36 * n);
  for (std::ptrdiff_t i = 0; i < n; ++i) {  // stretches from 1 to 1.2, some shear
    for (int c = 0; c < 9; c += 4) F[static_cast<std::size_t>(c * n + i)] = 1;
    F[static_cast<std::size_t>(i)] += 0.2 * static_cast<double>(i) / n;
    F[static_cast<std::size_t>(3 * n + i)] = 0.05;
  }

  std::ptrdiff_t failed = 0;
  for (int step = 0; step < 10; ++step) {
#pragma omp parallel for reduction(+ : failed)
    for (std::ptrdiff_t i = 0; i < n; i += block) {
      // Points i to i + block: the arrays begin there, their components are still n apart.
      const batch::Input in{batch::soa(F.data() + i, n), batch::shared(n0), batch::soa(G.data() + i, n),
                            batch::shared(&dt)};
      const batch::Output out{batch::soa(stress.data() + i, n), batch::soa(G.data() + i, n),
                              batch::soa(ddsdde.data() + i, n)};
      failed += update_batch<Tangent::full>(muscle, std::min(block, n - i), in, out);
    }
  }

  std::uint64_t sum = 0;  // of the bits
  for (const auto* results : {&G, &stress, &ddsdde}) {
    for (const double& x : *results) {
      std::uint64_t bits;
      std::memcpy(&bits, &x, sizeof bits);
      sum = sum * 31 + bits;
    }
  }
  std::printf("G of the first point %.5f, of the last %.5f; %td without result; sum of all bits %016llx\n",
              G.front(), G.back(), failed, static_cast<unsigned long long>(sum));
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    std::perror("standard output cannot be written");
    return 1;
  }
  return failed == 0 ? 0 : 1;
}
