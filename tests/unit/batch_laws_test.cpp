// Batches of other elastic laws against update_point: law 1 in packs, full and compact tangent, in every
// measure; another law point by point.
#include <gtest/gtest.h>

#include <myogrowth/elastic/blemker.hpp>
#include <myogrowth/many/laws.hpp>
#include <vector>

#include "../support/larger.hpp"
#include "../support/samples.hpp"

using namespace myogrowth;

namespace {

struct Points {
  static constexpr int n = 203;  // no multiple of a register's lanes
  std::vector<double> F, n0, G, dt, lambda, activation;

  // Along the whole force-length curve, growing, shrinking or neither; the last three have no result.
  explicit Points(samples::Random& r) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d fibre = samples::direction(r) * r.uniform(0.5, 2);
      const Eigen::Matrix3d along = fibre * fibre.transpose() / fibre.squaredNorm();
      Eigen::Matrix3d X = samples::rotation(r) * samples::deformation(r, 0.2) *
                          (Eigen::Matrix3d::Identity() + r.uniform(-0.5, 1.4) * along);
      if (i % 20 == 1) X = Eigen::Matrix3d::Identity() + 1e-6 * samples::deformation(r, 0.2);
      if (i == n - 3) X(0, 0) = std::nan("");
      if (i == n - 2) X = -X;
      for (int c = 0; c < 9; ++c) F.push_back(X.data()[c]);
      for (int c = 0; c < 3; ++c) n0.push_back(i == n - 1 ? 0 : fibre[c]);
      G.push_back(r.uniform(0.9, 1.2));
      dt.push_back(r.log_uniform(1e-3, 1));
      lambda.push_back(r.uniform(0.8, 1.5));
      activation.push_back(r.chance(0.2) ? 0 : r.uniform());
    }
  }
};

template <class Law>
FibreGrowthOf<Law> muscle_of(const Law& law, samples::Random& r) {
  FibreGrowthOf<Law> m{law, {0.5, r.uniform(0.5, 3), 1.4, 1.01}, {}, {}, {}};
  if (r.chance(0.5)) m.removal = {0.8, 1.5, 0.6, 0.95};
  if (r.chance(0.5)) m.energy = EnergyPer::grown_volume;
  if (r.chance(0.5)) m.integration = TimeIntegration::midpoint_flow;
  return m;
}

double difference(const double* a, const double* b, int n) {
  double most = 0, size = 0;
  for (int i = 0; i < n; ++i)
    most = larger(most, std::abs(a[i] - b[i])), size = std::max(size, std::abs(b[i]));
  return std::isnan(most) ? 1 : most / size;
}

template <Tangent tangent, Measure measure, class Law>
double compare(const FibreGrowthOf<Law>& m, Points p) {
  constexpr int n = Points::n, n_stress = measure == Measure::first_piola ? 9 : 6,
                n_moduli = n_stress * n_stress,
                n_tangent = tangent == Tangent::compact ? CompactRoehrleTangent<double>::size : n_moduli;
  using namespace batch;
  std::vector<double> stress(n * n_stress), G(n), moduli(n * n_tangent), scalars(n * 5);
  const Input in{aos<9>(p.F.data()),  aos<3>(p.n0.data()),     aos<1>(p.G.data()),
                 aos<1>(p.dt.data()), aos<1>(p.lambda.data()), aos<1>(p.activation.data())};
  const Output out{aos<n_stress>(stress.data()), aos<1>(G.data()), aos<n_tangent>(moduli.data()),
                   aos<5>(scalars.data())};
  EXPECT_EQ((update_batch<tangent, measure>(m, n, in, out)), 3);
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    ElasticPointUpdate<double> u;
    update_point(m, &p.F[9 * i], &p.n0[3 * i], p.G[i], p.lambda[i], p.dt[i], u, p.activation[i]);
    if (u.status != UpdateStatus::ok) {
      EXPECT_TRUE(std::isnan(stress[n_stress * i]) && std::isnan(scalars[5 * i]));
      EXPECT_EQ(G[i], p.G[i]);
      continue;
    }
    double c[36], expected_stress[9], expected[81];
    spatial_modulus(u, c);
    if (measure == Measure::cauchy) {
      cauchy_from_kirchhoff(u.J, u.tau, expected_stress);
      spatial_modulus(u, expected, 1 / u.J);
    } else if (measure == Measure::first_piola) {
      first_piola_from_kirchhoff(&p.F[9 * i], u.tau, expected_stress);
      dP_dF_from_jaumann(&p.F[9 * i], u.tau, c, expected);
    } else {
      second_piola_from_kirchhoff(&p.F[9 * i], u.tau, expected_stress);
      dS_dE_from_jaumann(&p.F[9 * i], u.tau, c, expected);
    }
    const double* given = &moduli[n_tangent * i];
    double expanded[36];
    if (tangent == Tangent::compact) {
      CompactRoehrleTangent<double> t;
      std::copy_n(given, 3, t.m), std::copy_n(given + 3, 6, t.b), std::copy_n(given + 9, 6, t.k);
      t.kappa = given[15], t.c01 = given[16], t.shift = given[17], t.J = given[18];
      t.expand(&stress[n_stress * i], expanded);
      given = expanded;
    }
    const double *sigma = &stress[n_stress * i], *found = &scalars[5 * i];
    double stiffness = 0;  // stresses are differences of numbers of this size
    for (int k = 0; k < n_moduli; ++k) stiffness = std::max(stiffness, std::abs(expected[k]));
    for (int k = 0; k < n_stress; ++k)
      worst = larger(worst, std::abs(sigma[k] - expected_stress[k]) / stiffness);
    worst = larger(worst, difference(given, expected, n_moduli));
    const double numbers[5] = {u.lambda_e, u.lambda, u.J, u.Je, u.psi};
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found[k], numbers[k], 1e-14 * numbers[k]);
    EXPECT_NEAR(found[4], u.psi, 1e-13 * (std::abs(u.psi) + 1e-3));
    EXPECT_NEAR(G[i], u.G, 1e-14);
  }
  return worst;
}

TEST(BatchOfLaws, Law1InPacksIsUpdatePoint) {
  samples::Random r(5);
  double worst = 0;
  for (int i = 0; i < 12; ++i) {
    Roehrle<> law;
    law.kappa = r.log_uniform(50, 1000), law.c01 = i % 3 ? r.uniform(0, 20) : 0,
    law.lambda_opt = r.uniform(0.9, 1.4);
    const auto m = muscle_of(law, r);
    const Points p(r);
    worst = std::max({worst, compare<Tangent::full, Measure::cauchy>(m, p),
                      compare<Tangent::compact, Measure::cauchy>(m, p),
                      compare<Tangent::full, Measure::first_piola>(m, p),
                      compare<Tangent::full, Measure::second_piola>(m, p)});
  }
  std::printf("packs of law 1: %.1e of the stiffness at worst\n", worst);
  EXPECT_LE(worst, 1e-12);
}

TEST(BatchOfLaws, OthersPointByPoint) {
  samples::Random r(6);
  for (int i = 0; i < 4; ++i) {
    const auto m = muscle_of(Blemker<>(), r);
    EXPECT_LE((compare<Tangent::full, Measure::cauchy>(m, Points(r))), 1e-15);
  }
}

// Without an activation a muscle is passive.
TEST(BatchOfLaws, ActivationIsOptional) {
  const FibreGrowthOf<Roehrle<>> m;
  const double n0[3] = {1, 0, 0}, dt = 0.1, F[9] = {1.3, 0, 0, 0, 0.9, 0, 0, 0, 0.9}, G = 1;
  double stress[6], G_end, expected[6];
  using namespace batch;
  EXPECT_EQ(update_batch<Tangent::none>(m, 1, Input{aos<9>(F), shared(n0), aos<1>(&G), shared(&dt)},
                                        Output{aos<6>(stress), aos<1>(&G_end)}),
            0);
  ElasticPointUpdate<double> u;
  update_point(m, F, n0, G, 1.0, dt, u, 0.0);
  cauchy_from_kirchhoff(u.J, u.tau, expected);
  EXPECT_LE(difference(stress, expected, 6), 1e-12);
}

}  // namespace
