// Compiled as all of ours, and once more with -ffast-math (MYOGROWTH_FAST), where the library's namespace has
// a name of its own: the linker cannot take code of one for that of the other.
#ifdef MYOGROWTH_FAST
#define myogrowth myogrowth_fast
#define MYOGROWTH_NAME(name) name##_fast
#else
#define MYOGROWTH_NAME(name) name
#endif
#include "steps.hpp"

#include <algorithm>
#include <myogrowth/many/batch.hpp>
#include <myogrowth/material.hpp>

using namespace myogrowth;

namespace {

FibreGrowth<> material(const steps::Input& in) {
  FibreGrowth<> m;
  m.growth.gamma = in.gamma;
  m.removal = {in.tau_rev, 2, 0.5, 0.99};
  if (in.second_order) m.integration = TimeIntegration::midpoint_flow;
  return m;
}

}  // namespace

steps::Output steps::MYOGROWTH_NAME(by_update)(const Input& in) {
  State<> state;
  state.G = in.G;
  state.lambda = in.lambda;
  state.n0 = Vec3<double>(in.n0);
  const auto u = update(material(in), Mat3<double>(in.F), state, in.dt);
  Output out{static_cast<int>(u.status()), {}};
  const Mat6<double> c = u.ddsdde();
  const Mat3<double> sigma = u.cauchy();
  std::copy_n(c.data(), 36, out.numbers);
  std::copy_n(sigma.data(), 9, out.numbers + 36);
  out.numbers[45] = u.state.G;
  std::copy_n(u.point.n0, 3, out.numbers + 46);
  out.numbers[49] = u.point.psi;
  return out;
}

steps::Output steps::MYOGROWTH_NAME(by_batch)(const Input& in) {
  using namespace batch;
  double F[9], n0[3], G = in.G, lambda = in.lambda, dt = in.dt;
  std::copy_n(in.F, 9, F);
  std::copy_n(in.n0, 3, n0);
  Output out{0, {}};
  const batch::Input<Soa<double>, Soa<double>, Soa<double>, Soa<double>, Soa<double>> from{
      soa(F, 1), soa(n0, 1), soa(&G, 1), soa(&dt, 1), soa(&lambda, 1)};
  const batch::Output to{soa(out.numbers + 36, 1), soa(out.numbers + 45, 1), soa(out.numbers, 1)};
  out.status = static_cast<int>(update_batch<Tangent::full>(material(in), 1, from, to));
  return out;
}
