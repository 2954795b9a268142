// Compiled for each instruction set, with -Dmyogrowth=myogrowth_<it> and what batch.hpp recommends.
#include "batch_pass.hpp"

#include <myogrowth/batch.hpp>

extern "C" void BENCH_BATCH_PASS(int tangent, const BenchBatch* b) {
  using namespace myogrowth;
  using batch::aosoa;
  FibreGrowth<double> m;
  m.growth.gamma = b->gamma;
  const batch::Input in{aosoa<9, bench_block>(b->F), aosoa<3, bench_block>(b->n0),
                        aosoa<1, bench_block>(b->G), batch::shared(b->dt)};
  const auto stress = aosoa<6, bench_block>(b->stress);
  const auto G = aosoa<1, bench_block>(b->G_end);
  if (tangent == 0) update_batch<Tangent::none>(m, b->n, in, batch::Output{stress, G});
  if (tangent == 7)
    update_batch<Tangent::compact>(m, b->n, in, batch::Output{stress, G, aosoa<7, bench_block>(b->tangent)});
  if (tangent == 36)
    update_batch<Tangent::full>(m, b->n, in, batch::Output{stress, G, aosoa<36, bench_block>(b->tangent)});
}
