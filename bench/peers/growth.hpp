// The local Newton iteration of the peers in C++, as it is usually written.
#ifndef MYOGROWTH_BENCH_PEERS_GROWTH_HPP
#define MYOGROWTH_BENCH_PEERS_GROWTH_HPP

#include <cmath>

struct Growth {
  double G, dG_dlambda;
};

/// One backward-Euler step of the growth law. props: those of libmyogrowth_umat.
inline Growth grow(const double* props, double G_n, double lambda, double dt) {
  const double tau = props[2], gamma = props[3], G_max = props[4], lambda_crit = props[5];
  if (lambda / G_n <= lambda_crit || G_n >= G_max) return {G_n, 0};
  double G = G_n, k = 0, dR = 1;
  for (int iteration = 0; iteration < 50; ++iteration) {
    k = std::pow((G_max - G) / (G_max - 1), gamma) / tau;
    const double phi = lambda / G - lambda_crit;
    const double R = G - G_n - dt * k * phi;
    dR = 1 - dt * (-gamma * k / (G_max - G) * phi - k * lambda / (G * G));
    G -= R / dR;
    if (std::abs(R) < 1e-13) break;
  }
  return {G, dt * k / G / dR};
}

#endif
