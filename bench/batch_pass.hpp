// The batch over points in blocks of 16, for one instruction set. Plain C, so that the linker cannot take
// code compiled for one set for that of another.
#ifndef MYOGROWTH_BENCH_BATCH_PASS_HPP
#define MYOGROWTH_BENCH_BATCH_PASS_HPP

extern "C" {

constexpr int bench_block = 16;

struct BenchBatch {
  long n;
  double gamma;
  const double *F, *n0, *G, *dt;  ///< 9, 3 and 1 per point in blocks; 1
  double *stress, *G_end, *tangent;
  int past_caches;           ///< outputs are streamed
  const double* lambda_n;    ///< 1 per point; not null: the second-order step, with the full tangent
  const double* activation;  ///< 1; not null: elastic law 1, with parameters that make it the neo-Hookean one
};
/// Numbers of the tangent per point: 0, 7 (compact; of law 1: 19) or 36 (DDSDDE).
using BenchBatchPass = void(int tangent, const BenchBatch* batch);
BenchBatchPass bench_batch_base, bench_batch_avx2, bench_batch_avx512;
}

#endif
