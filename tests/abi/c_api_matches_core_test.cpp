// The C API is the C++ core, bit for bit.
#include <gtest/gtest.h>
#include <myogrowth.h>

#include <algorithm>
#include <myogrowth/elastic/blemker.hpp>
#include <myogrowth/elastic/ehret.hpp>
#include <myogrowth/elastic/roehrle.hpp>
#include <myogrowth/more/left_stretch.hpp>
#include <myogrowth/more/stress_states.hpp>
#include <string>
#include <vector>

#include "../support/larger.hpp"
#include "../support/samples.hpp"

using namespace myogrowth;
using samples::Kind;

namespace {

struct Result {
  int status;
  double state[9], energy;
  Eigen::VectorXd stress;
  Eigen::MatrixXd tangent;
};

Result run(const samples::Point& p, int measure, bool local_basis = false) {
  const auto& g = p.muscle.growth;
  const double grown = p.muscle.energy == EnergyPer::grown_volume;
  const double props[] = {p.muscle.c1,   p.muscle.c2,         g.tau,         g.gamma,
                          g.G_max,       g.lambda_crit,       p.state.n0[0], p.state.n0[1],
                          p.state.n0[2], double(local_basis), grown};
  const int n = myogrowth_stress_size(measure);
  Result r{-1, {p.state.G}, 0, Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  r.status = myogrowth_update(props, 11, p.F.data(), r.state, r.state, 9, p.dt, measure, r.stress.data(),
                              r.tangent.data(), &r.energy, nullptr, 0);
  return r;
}

samples::Point point(samples::Random& r) {
  samples::Point p = samples::point(r, r.chance(0.5) ? Kind::growing : Kind::any);
  p.muscle.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
  return p;
}

TEST(CApi, IsTheCoreBitForBit) {
  samples::Random r(61);
  for (int i = 0; i < 2000; ++i) {
    const samples::Point p = point(r);
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    const Mat3<double> P = u.first_piola();
    const Result cauchy = run(p, MYOGROWTH_CAUCHY), first = run(p, MYOGROWTH_FIRST_PIOLA),
                 second = run(p, MYOGROWTH_SECOND_PIOLA);
    EXPECT_EQ(cauchy.stress, to_six(u.cauchy()));
    EXPECT_EQ(cauchy.tangent, u.ddsdde());
    EXPECT_EQ(first.stress, Eigen::Map<const Eigen::VectorXd>(P.data(), 9));
    EXPECT_EQ(first.tangent, u.dP_dF());
    EXPECT_EQ(second.stress, to_six(u.second_piola()));
    EXPECT_EQ(second.tangent, u.dS_dE());
    for (const Result* c : {&cauchy, &first, &second}) {
      EXPECT_EQ(c->status, MYOGROWTH_OK);
      EXPECT_EQ(c->energy, u.point.psi);
      const double state[9] = {u.state.G,     u.point.lambda_e, u.point.lambda, u.point.J, u.point.Je,
                               u.point.n0[0], u.point.n0[1],    u.point.n0[2],  0};
      for (int k = 0; k < 9; ++k) EXPECT_EQ(c->state[k], state[k]) << k;
    }
  }
}

TEST(CApi, TakesTheLeftStretchInALocalBasis) {
  samples::Random r(62);
  for (int i = 0; i < 200; ++i) {
    samples::Point p = point(r);
    const Result local = run(p, MYOGROWTH_CAUCHY, true);
    ASSERT_TRUE(left_stretch(p.F.data(), p.F.data()));
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    EXPECT_EQ(local.stress, to_six(u.cauchy()));
    EXPECT_EQ(local.tangent, u.ddsdde());
    EXPECT_EQ(local.state[0], u.state.G);
  }
}

// What myogrowth.h promises of many points: those of myogrowth_update to rounding, with the same status, and
// the same bits whatever the number and the order of the points.
TEST(CApi, ManyPointsAreTheSinglePointToRoundingWhateverTheirOrder) {
  samples::Random r(63);
  const double props[] = {16, 4, 0.5, 2.3, 1.3, 1.01, 1, 0, 0};
  for (int measure : {MYOGROWTH_CAUCHY, MYOGROWTH_FIRST_PIOLA, MYOGROWTH_SECOND_PIOLA}) {
    const auto n_stress = static_cast<std::size_t>(myogrowth_stress_size(measure));
    const std::size_t n = 203, n_tangent = n_stress * n_stress;
    struct Many {
      std::vector<double> F, state, stress, tangent, energy;
      std::vector<int> status;
    };
    const auto update_n = [&](Many& m, std::size_t first, std::size_t count) {
      return myogrowth_update_n(static_cast<int>(count), props, 9, &m.F[9 * first], &m.state[9 * first],
                                &m.state[9 * first], 9, 0.1, measure, &m.stress[n_stress * first],
                                &m.tangent[n_tangent * first], &m.energy[first], &m.status[first], nullptr,
                                0);
    };
    Many all{
        std::vector<double>(9 * n),         std::vector<double>(9 * n), std::vector<double>(n_stress * n),
        std::vector<double>(n_tangent * n), std::vector<double>(n),     std::vector<int>(n)};
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Matrix3d F = samples::rotation(r) * samples::deformation(r, 0.4);
      std::copy_n(F.data(), 9, &all.F[9 * i]);
      all.state[9 * i] = r.chance(0.1) ? 0 : 1 + 0.2 * r.uniform();
      for (std::size_t k = 5; k < 8; ++k) all.state[9 * i + k] = r.uniform(-1, 1);
      if (i % 50 == 7) all.F[9 * i] = -3 * std::abs(all.F[9 * i]) - 5;  // mostly turned inside out
      if (i % 50 == 8) all.state[9 * i] = -1;
    }
    Many reversed = all, pieces = all;
    const Many start = all;
    for (std::size_t i = 0; i < n; ++i) {
      std::copy_n(&start.F[9 * i], 9, &reversed.F[9 * (n - 1 - i)]);
      std::copy_n(&start.state[9 * i], 9, &reversed.state[9 * (n - 1 - i)]);
    }
    const int failed = update_n(all, 0, n);
    EXPECT_EQ(update_n(reversed, 0, n), failed);
    std::size_t first = 0;
    for (std::size_t size : {1u, 2u, 5u, 31u, 33u, 64u, 67u}) update_n(pieces, first, size), first += size;
    ASSERT_EQ(first, n);
    EXPECT_EQ(failed, std::count_if(all.status.begin(), all.status.end(), [](int x) { return x != 0; }));
    EXPECT_GE(failed, 4);
    EXPECT_LE(failed, 12);

    const auto same = [](const double* a, const double* b, std::size_t count) {
      return std::equal(a, a + count, b,
                        [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
    };
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = n - 1 - i;
      EXPECT_EQ(all.status[i], reversed.status[j]);
      EXPECT_TRUE(same(&all.stress[n_stress * i], &reversed.stress[n_stress * j], n_stress));
      EXPECT_TRUE(same(&all.tangent[n_tangent * i], &reversed.tangent[n_tangent * j], n_tangent));
      EXPECT_TRUE(same(&all.state[9 * i], &reversed.state[9 * j], 9));
      EXPECT_TRUE(same(&all.energy[i], &reversed.energy[j], 1));
      EXPECT_TRUE(same(&all.stress[n_stress * i], &pieces.stress[n_stress * i], n_stress));
      EXPECT_TRUE(same(&all.tangent[n_tangent * i], &pieces.tangent[n_tangent * i], n_tangent));
      EXPECT_TRUE(same(&all.state[9 * i], &pieces.state[9 * i], 9));

      std::vector<double> state(9), stress(n_stress), tangent(n_tangent);
      double energy;
      EXPECT_EQ(myogrowth_update(props, 9, &start.F[9 * i], &start.state[9 * i], state.data(), 9, 0.1,
                                 measure, stress.data(), tangent.data(), &energy, nullptr, 0),
                all.status[i]);
      if (all.status[i] != MYOGROWTH_OK) {
        EXPECT_TRUE(same(&all.state[9 * i], &start.state[9 * i], 9));
        EXPECT_TRUE(std::isnan(all.energy[i]) && std::isnan(all.stress[n_stress * i]));
        continue;
      }
      const auto difference = [](const double* a, const std::vector<double>& b) {
        double most = 0, size = 0;
        for (std::size_t k = 0; k < b.size(); ++k) {
          most = larger(most, std::abs(a[k] - b[k])), size = std::max(size, std::abs(b[k]));
        }
        return most / size;
      };
      worst = std::max({worst, difference(&all.stress[n_stress * i], stress),
                        difference(&all.tangent[n_tangent * i], tangent),
                        difference(&all.state[9 * i], state), difference(&all.energy[i], {energy})});
    }
    EXPECT_LE(worst, 1e-12);
    std::printf("measure %d: %.1e from the single point, relative\n", measure, worst);
  }
}

TEST(CApi, UniaxialIsTheCoreBitForBit) {
  samples::Random r(64);
  for (int i = 0; i < 300; ++i) {
    FibreGrowth<> m;
    m.c1 = r.uniform(0, 100);
    m.growth = {0.5, r.uniform(0.5, 4), 1.3, 1.01};
    m.integration = r.chance(0.5) ? TimeIntegration::midpoint_flow : TimeIntegration::backward_euler;
    const double second = m.integration == TimeIntegration::midpoint_flow;
    const double props[] = {m.c1, 4, 0.5, m.growth.gamma, 1.3, 1.01, 0, 0, 0, 0, 0, second};
    const double stretch = r.uniform(0.7, 1.6), G = 1 + 0.2 * r.uniform(), lambda_n = r.uniform(0.9, 1.2);
    PointUpdate<double> u;
    double side = 0.9, slope;
    ASSERT_EQ(uniaxial_stress(m, stretch, G, lambda_n, 0.3, side, u, slope), UpdateStatus::ok);

    double state[9] = {G, 7, lambda_n, 7, 7, 3, 4, 5, 6}, lateral = 0.9, stress, modulus, energy;
    ASSERT_EQ(myogrowth_uniaxial(props, 12, stretch, state, state, 9, 0.3, &lateral, &stress, &modulus,
                                 &energy, nullptr, 0),
              MYOGROWTH_OK);
    EXPECT_EQ(lateral, side);
    EXPECT_EQ(stress, u.tau[0] / u.J);
    EXPECT_EQ(modulus, slope / u.J);
    EXPECT_EQ(energy, u.psi);
    const double expected[9] = {u.G, u.lambda_e, u.lambda, u.J, u.Je, 3, 4, 5, 6};
    for (int k = 0; k < 9; ++k) EXPECT_EQ(state[k], expected[k]) << k;
  }
}

TEST(CApi, UniaxialSaysWhatItCannotTake) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double good[] = {16, 4, 0.5, 2, 1.1, 1.01}, bad[] = {16, -4, 0.5, 2, 1.1, 1.01};
  const struct {
    const double* props;
    double stretch, G, dt;
    int status;
    const char* words;
  } cases[] = {{good, -1, 1, 0.1, MYOGROWTH_INVERTED, "stretch = -1: must be > 0"},
               {good, nan, 1, 0.1, MYOGROWTH_NOT_FINITE, "stretch = nan: must be > 0"},
               {good, 1.1, 1, nan, MYOGROWTH_NOT_FINITE, "not finite: dt = nan"},
               {good, 1.1, -1, 0.1, MYOGROWTH_BAD_STATE, "STATEV(1) = -1"},
               {bad, 1.1, 1, 0.1, MYOGROWTH_BAD_PARAMETER, "PROPS(2) = -4"},
               {nullptr, 1.1, 1, 0.1, MYOGROWTH_BAD_ARGUMENT, "props = NULL"}};
  for (const auto& c : cases) {
    double state[9] = {c.G, 1, 2, 3, 4, 5, 6, 7, 8}, lateral = 0.9, stress = 1, modulus = 1, energy = 1;
    const std::vector<double> before(state, state + 9);
    char message[200] = "";
    EXPECT_EQ(myogrowth_uniaxial(c.props, 6, c.stretch, state, state, 9, c.dt, &lateral, &stress, &modulus,
                                 &energy, message, sizeof message),
              c.status);
    EXPECT_NE(std::string(message).find(c.words), std::string::npos) << message;
    EXPECT_EQ(std::vector<double>(state, state + 9), before);
    EXPECT_EQ(lateral, 0.9);
    EXPECT_TRUE(std::isnan(stress) && std::isnan(modulus) && std::isnan(energy));
    EXPECT_EQ(myogrowth_uniaxial(c.props, 6, c.stretch, state, state, 9, c.dt, nullptr, &stress, nullptr,
                                 nullptr, nullptr, 0),
              c.status);
  }
}

// The elastic laws: the core's results, one point or many, and a strip.
template <class Law>
void expect_law(int number, const Law& law) {
  samples::Random r(67);
  const FibreGrowthOf<Law> muscle{law, {0.5, 2, 1.1, 1.01}, {}, EnergyPer::grown_volume, {}};
  std::vector<double> props = {0, 0, 0.5, 2, 1.1, 1.01, 1, 0.5, -0.3, 0, 1};
  props.resize(20);
  props[18] = number;
  const int n = 40;
  std::vector<double> F, state(9 * n, 0.0), out(9 * n), P(9 * n), dP_dF(81 * n), energy(n);
  std::vector<int> status(n, -1);
  props[19] = 0.25;
  for (int i = 0; i < n; ++i) {
    const Eigen::Matrix3d F_i = samples::rotation(r) * samples::deformation(r, 0.15);
    F.insert(F.end(), F_i.data(), F_i.data() + 9);
  }
  const int n_props = static_cast<int>(props.size());
  EXPECT_EQ(myogrowth_update_n(n, props.data(), n_props, F.data(), state.data(), out.data(), 9, 0.1,
                               MYOGROWTH_FIRST_PIOLA, P.data(), dP_dF.data(), energy.data(), status.data(),
                               nullptr, 0),
            0);
  for (std::size_t i = 0; i < n; ++i) {
    State<> start;
    start.n0 = {1, 0.5, -0.3};
    const Eigen::Matrix3d F_i = Eigen::Map<const Eigen::Matrix3d>(&F[9 * i]);
    const auto u = update(muscle, F_i, start, 0.1, 0.25);
    ASSERT_TRUE(u.ok());
    EXPECT_EQ(Eigen::Map<const Eigen::Matrix3d>(&P[9 * i]), u.first_piola());
    EXPECT_EQ((Eigen::Map<const Mat9<double>>(&dP_dF[81 * i])), u.dP_dF());
    EXPECT_EQ(energy[i], u.point.psi);
    EXPECT_EQ(out[9 * i], u.state.G);
    double sigma[6], tangent[36], one[9] = {};
    EXPECT_EQ(myogrowth_update(props.data(), n_props, &F[9 * i], one, one, 9, 0.1, MYOGROWTH_CAUCHY, sigma,
                               tangent, nullptr, nullptr, 0),
              MYOGROWTH_OK);
    EXPECT_EQ((Eigen::Map<const Vec6<double>>(sigma)), to_six(u.cauchy()));
    EXPECT_EQ((Eigen::Map<const Mat6<double>>(tangent)), u.ddsdde());
  }
  double strip_state[9] = {}, sides = 0, lateral = 0, stress, modulus, slope;
  ElasticPointUpdate<double> u;
  ASSERT_EQ(myogrowth_uniaxial(props.data(), n_props, 1.1, strip_state, strip_state, 9, 0.1, &lateral,
                               &stress, &modulus, nullptr, nullptr, 0),
            MYOGROWTH_OK);
  ASSERT_EQ(uniaxial_stress(muscle, 1.1, 1.0, 1.0, 0.1, sides, u, slope, 0.25), UpdateStatus::ok);
  EXPECT_EQ(lateral, sides);
  EXPECT_EQ(stress, u.tau[0] / u.J);
  EXPECT_EQ(modulus, slope / u.J);
  EXPECT_EQ(strip_state[0], u.G);
  EXPECT_GT(strip_state[0], 1);
}

TEST(CApi, HasTheElasticLaws) {
  expect_law(1, Roehrle<>());
  expect_law(2, Blemker<>());
  expect_law(3, Ehret<>());
  EXPECT_EQ(myogrowth_n_laws(), 3);
  EXPECT_EQ(std::string(myogrowth_law_name(2)), "Blemker");
  EXPECT_EQ(myogrowth_law_n_parameters(2), 11);
  EXPECT_EQ(std::string(myogrowth_law_symbol(3, 2)), "gamma_e");
  EXPECT_EQ(std::string(myogrowth_law_unit(3, 2)), "stress");
  EXPECT_EQ(std::string(myogrowth_law_meaning(1, 1)), "matrix, second invariant");
  EXPECT_EQ(std::string(myogrowth_law_allowed(3, 7)), "> lambda_min");
  EXPECT_EQ(myogrowth_law_default(1, 5), 1.4);
  EXPECT_EQ(myogrowth_law_default_of_tendon(1, 5), 1.4);
  EXPECT_EQ(myogrowth_law_default_of_tendon(2, 0), Blemker<>::of_tendon().G1);
  EXPECT_EQ(myogrowth_law_default_of_tendon(2, 8), 1);
  for (const int law : {-1, 0, 4}) {
    EXPECT_EQ(myogrowth_law_name(law), nullptr);
    EXPECT_EQ(myogrowth_law_n_parameters(law), 0);
    EXPECT_EQ(myogrowth_law_symbol(law, 0), nullptr);
    EXPECT_TRUE(std::isnan(myogrowth_law_default(law, 0)));
    EXPECT_TRUE(std::isnan(myogrowth_law_default_of_tendon(law, 0)));
  }
  EXPECT_EQ(myogrowth_law_unit(1, 8), nullptr);
  EXPECT_EQ(myogrowth_law_meaning(1, -1), nullptr);
  EXPECT_EQ(myogrowth_law_allowed(1, 8), nullptr);
}

TEST(CApi, NamesWhatIsWrongWithAnElasticLaw) {
  std::vector<double> props = {0, 0, 0.5, 2, 1.1, 1.01};
  props.resize(21);
  char message[400];
  const auto check = [&] {
    EXPECT_EQ(myogrowth_check(props.data(), static_cast<int>(props.size()), message, sizeof message),
              MYOGROWTH_BAD_PARAMETER);
    return std::string(message);
  };
  props[6] = 1, props[18] = 1, props[20] = 10, props[19] = -1;
  EXPECT_EQ(check(), "PROPS(20) = -1: this host has no field variables; activation must be >= 0 and <= 1.");
  props[19] = 1.5;
  EXPECT_EQ(check(), "PROPS(20) = 1.5: activation, must be >= 0 and <= 1.");
  props[19] = 0.5, props[17] = 1;
  EXPECT_NE(check().find("PROPS(18) = 1: hybrid"), std::string::npos);
  props[17] = 0, props[20] = -2;
  EXPECT_EQ(check(), "PROPS(21) = -2: c10, matrix, must be finite and > 0.");
}

}  // namespace
