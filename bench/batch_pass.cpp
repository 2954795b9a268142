// Compiled for each instruction set, with -Dmyogrowth=myogrowth_<it> and what many/batch.hpp recommends.
#include "batch_pass.hpp"

#include <myogrowth/many/laws.hpp>

extern "C" void BENCH_BATCH_PASS(int tangent, const BenchBatch* b) {
  using namespace myogrowth;
  using batch::aosoa;
  FibreGrowth<double> m;
  m.growth.gamma = b->gamma;
  if (b->activation) {  // all terms are computed, whatever the parameters
    const FibreGrowthOf<Roehrle<double>> law1{{m.c2, 0, m.c1, 0, 0, 1.4, 0.05, 6.6}, m.growth, {}, {}, {}};
    const batch::Input in{aosoa<9, bench_block>(b->F),
                          aosoa<3, bench_block>(b->n0),
                          aosoa<1, bench_block>(b->G),
                          batch::shared(b->dt),
                          batch::Absent(),
                          batch::shared(b->activation)};
    const auto stress = aosoa<6, bench_block>(b->stress);
    const auto G = aosoa<1, bench_block>(b->G_end);
    if (tangent == 19)
      update_batch<Tangent::compact>(law1, b->n, in,
                                     batch::Output{stress, G, aosoa<19, bench_block>(b->tangent)});
    else
      update_batch<Tangent::full>(law1, b->n, in,
                                  batch::Output{stress, G, aosoa<36, bench_block>(b->tangent)});
    return;
  }
  const batch::Input in{aosoa<9, bench_block>(b->F), aosoa<3, bench_block>(b->n0),
                        aosoa<1, bench_block>(b->G), batch::shared(b->dt)};
  const auto update = [&](const auto& stress, const auto& G, const auto& compact, const auto& full) {
    if (tangent == 0) update_batch<Tangent::none>(m, b->n, in, batch::Output{stress, G});
    if (tangent == 7) update_batch<Tangent::compact>(m, b->n, in, batch::Output{stress, G, compact});
    if (tangent == 36) update_batch<Tangent::full>(m, b->n, in, batch::Output{stress, G, full});
  };
  if (b->lambda_n) {
    m.integration = TimeIntegration::midpoint_flow;
    const batch::Input all{in.F, in.n0, in.G, in.dt, aosoa<1, bench_block>(b->lambda_n)};
    update_batch<Tangent::full>(
        m, b->n, all,
        batch::Output{aosoa<6, bench_block>(b->stress), aosoa<1, bench_block>(b->G_end),
                      aosoa<36, bench_block>(b->tangent)});
  } else if (b->past_caches) {
    using batch::streamed;
    update(streamed<6, bench_block>(b->stress), streamed<1, bench_block>(b->G_end),
           streamed<7, bench_block>(b->tangent), streamed<36, bench_block>(b->tangent));
  } else {
    update(aosoa<6, bench_block>(b->stress), aosoa<1, bench_block>(b->G_end),
           aosoa<7, bench_block>(b->tangent), aosoa<36, bench_block>(b->tangent));
  }
}
