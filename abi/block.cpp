// The batch for one instruction set: compiled for each, with -Dmyogrowth=myogrowth_<it>. The library's
// namespace then has a name of its own, so that the linker cannot take this code for that of another set;
// block.hpp is plain C.
#include "block.hpp"

#include <myogrowth/many/batch.hpp>

#include "properties.hpp"

namespace {

using namespace myogrowth;

template <Tangent tangent, Measure measure>
void update(const FibreGrowth<double>& material, int n, MyogrowthBlock& b) {
  constexpr std::ptrdiff_t points = myogrowth_block_points;
  using batch::shared;
  using batch::soa;
  const batch::Input<batch::Soa<double>, batch::Soa<double>, batch::Soa<double>, batch::Shared<double>,
                     batch::Soa<double>>
      in{soa(b.F, points), soa(b.n0, points), soa(b.G, points), shared(&b.dt), soa(b.lambda, points)};
  const batch::Output<batch::Soa<double>, batch::Soa<double>, batch::Soa<double>, batch::Soa<double>> out{
      soa(b.stress, points), soa(b.G_end, points), soa(b.tangent, points), soa(b.scalars, points)};
  update_batch<tangent, measure>(material, n, in, out);

  constexpr int n_stress = measure == Measure::first_piola ? 9 : 6;
  constexpr int n_tangent = tangent == Tangent::none ? 0 : n_stress * n_stress;
  const auto check = [&b](const auto& at) {
    auto sum = at(b.stress) + at(b.G_end);
    for (int c = 0; c < 5; ++c) sum = sum + at(b.scalars + c * points);
    for (int c = 1; c < n_stress; ++c) sum = sum + at(b.stress + c * points);
    for (int c = 0; c < n_tangent; ++c) sum = sum + at(b.tangent + c * points);
    return sum * decltype(sum)(0);  // NaN if it is not finite
  };
  using P = simd::Pack<double, simd::native_lanes<double>>;
  int k = 0;
  for (; k + P::width <= n; k += P::width)
    check([k](const double* x) { return P::load(x + k); }).store(b.check + k);
  for (; k < n; ++k) b.check[k] = check([k](const double* x) { return x[k]; });
}

}  // namespace

extern "C" void MYOGROWTH_UPDATE_BLOCK(const double* props, int n, int measure, int with_tangent,
                                       MyogrowthBlock* block) {
  double known[abi::n_props];
  for (int i = 0; i < abi::n_props; ++i) known[i] = props[i];
  abi::Properties properties;
  abi::read(known, properties);
  const FibreGrowth<double>& m = properties.material;
  if (with_tangent) {
    if (measure == 0) return update<Tangent::full, Measure::cauchy>(m, n, *block);
    if (measure == 1) return update<Tangent::full, Measure::first_piola>(m, n, *block);
    return update<Tangent::full, Measure::second_piola>(m, n, *block);
  }
  if (measure == 0) return update<Tangent::none, Measure::cauchy>(m, n, *block);
  if (measure == 1) return update<Tangent::none, Measure::first_piola>(m, n, *block);
  return update<Tangent::none, Measure::second_piola>(m, n, *block);
}
