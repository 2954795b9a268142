// Material points and what the law in 50 digits says of them, one a line, for programs that have no Boost:
// PROPS(1:9), G, dt, F column by column, and then G at the end, the Cauchy stress and DDSDDE.
#include <cstdio>

#include "../support/reference.hpp"

int main() {
  using samples::Kind;
  samples::Random r(20261128);
  for (int i = 0; i < 400; ++i) {
    const Kind kinds[] = {Kind::growing, Kind::below_threshold, Kind::saturated, Kind::elastic_step};
    samples::Point p = samples::point(r, i % 2 ? Kind::growing : kinds[i / 2 % 4]);
    p.state.n0.normalize();
    const reference::Matrix F = reference::exact(p.F);
    const reference::Result exact = reference::update(p, F);
    const auto& g = p.muscle.growth;
    std::printf("%.17g %.17g %.17g %.17g %.17g %.17g", p.muscle.c1, p.muscle.c2, g.tau, g.gamma, g.G_max,
                g.lambda_crit);
    const auto put = [](double x) { std::printf(" %.17g", x); };
    for (int k = 0; k < 3; ++k) put(p.state.n0[k]);
    put(p.state.G), put(p.dt);
    for (int k = 0; k < 9; ++k) put(p.F(k));
    put(static_cast<double>(exact.G));
    for (int k = 0; k < 6; ++k) {
      const auto& row = exact.tau[myogrowth::symmetric_row(k)];
      put(static_cast<double>(row[myogrowth::symmetric_column(k)] / exact.J));
    }
    const auto D = reference::ddsdde(p);
    for (int k = 0; k < 36; ++k) put(D(k));
    std::printf("\n");
  }
}
