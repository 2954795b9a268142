// A host may have floating-point traps on: no ordinary call raises invalid, divide-by-zero or overflow, lanes
// of packs that are not asked for included.
#include <gtest/gtest.h>
#include <myogrowth.h>

#include <algorithm>
#include <cfenv>
#include <myogrowth/many/batch.hpp>
#include <myogrowth/more/left_stretch.hpp>
#include <myogrowth/more/stress_states.hpp>

#include "mgis_layout.hpp"

#include "../support/ccx_host.hpp"
#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using namespace myogrowth;

extern "C" int FibreGrowth_Tridimensional(myogrowth::abi::mgis::BehaviourData* d);
extern "C" int FibreGrowth_PlaneStress(myogrowth::abi::mgis::BehaviourData* d);

namespace {

// Ordinary, and hard: nothing grows or all does, at a threshold or a limit, every gamma, steps from none to
// long.
struct Case {
  std::vector<double> props;
  Eigen::Matrix3d F;
  double G, lambda, dt;
};

Case ordinary(samples::Random& r) {
  const double gammas[] = {0, 0.05, 0.5, 1, 1.5, 2, 2, 2.5, 2.7, 3.5, 20},
               steps[] = {0, 1e-9, 1e-3, 0.1, 1, 10, 1e4, 1e9};
  Case c;
  c.props = {16,
             4,
             r.log_uniform(0.01, 10),
             r.pick(gammas),
             1 + r.log_uniform(1e-3, 2),
             r.uniform(0.9, 1.1),
             1,
             0,
             0,
             0,
             r.chance(0.3) ? 1.0 : 0.0,
             r.chance(0.4) ? 1.0 : 0.0,
             r.chance(0.5) ? 1e-4 : 0.0};
  const double G_max = c.props[4], lambda_crit = c.props[5];
  if (r.chance(0.4)) {
    for (double x :
         {r.log_uniform(0.01, 10), r.pick(gammas), r.uniform(0.3, 0.9), lambda_crit * r.uniform(0.8, 1)})
      c.props.push_back(x);
  }
  c.G = r.chance(0.3) ? 1 : r.chance(0.2) ? G_max : r.uniform(0.8, G_max);
  c.lambda = r.chance(0.5) ? 1 : r.uniform(0.7, 1.6);
  c.dt = r.pick(steps) * r.uniform(0.5, 1);
  c.F = r.chance(0.1) ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                      : samples::deformation(r, r.chance(0.5) ? 1e-6 : 0.3);
  const double n_stretch = c.F.col(0).norm(), kind = r.uniform();
  if (kind < 0.2) c.F *= lambda_crit * c.G / n_stretch;    // at the threshold
  if (kind > 0.8) c.F *= lambda_crit * G_max / n_stretch;  // where the limits meet
  return c;
}

FibreGrowth<> material(const std::vector<double>& p) {
  FibreGrowth<> m;
  m.growth = {p[2], p[3], p[4], p[5]};
  if (p.size() > 16) m.removal = {p[13], p[14], p[15], p[16]};
  if (p[10] == 1) m.energy = EnergyPer::grown_volume;
  if (p[11] == 1) m.integration = TimeIntegration::midpoint_flow;
  return m;
}

constexpr int traps = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;

// Calls it n times and counts the calls that raise a flag.
template <class Call>
void expect_no_flags(int n, const Call& call) {
  samples::Random r(11);
  int raised = 0;
  for (int i = 0; i < n; ++i) {
    std::string which;
    const auto guarded = [&](const std::vector<double>& props, const auto& body) {
      std::feclearexcept(FE_ALL_EXCEPT);
      body();
      const int flags = std::fetestexcept(traps);
      std::feclearexcept(FE_ALL_EXCEPT);
      if (flags == 0 || ++raised > 5) return;
      std::string text = flags & FE_INVALID     ? "invalid"
                         : flags & FE_DIVBYZERO ? "divide by zero"
                                                : "overflow";
      for (double p : props) text += " " + std::to_string(p);
      ADD_FAILURE() << "call " << i << ": " << text;
    };
    call(r, guarded);
  }
  EXPECT_EQ(raised, 0);
}

}  // namespace

TEST(Traps, Update) {
  expect_no_flags(200000, [](samples::Random& r, const auto& guarded) {
    const Case c = ordinary(r);
    const FibreGrowth<> m = material(c.props);
    State<> state;
    state.G = c.G, state.lambda = c.lambda;
    guarded(c.props, [&] {
      const auto u = update(m, c.F, state, c.dt);
      EXPECT_TRUE(u.ok());
      volatile double kept = u.dP_dF()(0, 0) + u.ddsdde()(0, 0) + u.dS_dE()(0, 0);
      (void)kept;
    });
  });
}

TEST(Traps, PlainAndUniaxialStress) {
  expect_no_flags(10000, [](samples::Random& r, const auto& guarded) {
    const Case c = ordinary(r);
    const FibreGrowth<> m = material(c.props);
    const double in_plane[4] = {c.F(0, 0), c.F(1, 0), c.F(0, 1), c.F(1, 1)}, n0[3] = {1, 0, 0};
    PointUpdate<double> u;
    double free_stretch = 0, moduli[9], slope;
    guarded(c.props, [&] {
      EXPECT_EQ(plane_stress(m, in_plane, n0, c.G, c.lambda, c.dt, free_stretch, u, moduli),
                UpdateStatus::ok);
      free_stretch = 0;
      EXPECT_EQ(uniaxial_stress(m, c.F(0, 0), c.G, c.lambda, c.dt, free_stretch, u, slope), UpdateStatus::ok);
    });
  });
}

// Points of one material, of which each does something else.
template <class Body>
void with_points(samples::Random& r, int n, const Body& body) {
  const Case first = ordinary(r);
  std::vector<double> F, G, lambda;
  for (int i = 0; i < n; ++i) {
    const Case c = ordinary(r);
    F.insert(F.end(), c.F.data(), c.F.data() + 9);
    G.push_back(std::min(c.G, first.props[4]));
    lambda.push_back(c.lambda);
  }
  body(first, F, G, lambda);
}

TEST(Traps, Batch) {
  expect_no_flags(3000, [](samples::Random& r, const auto& guarded) {
    constexpr int n = 37;
    with_points(
        r, n,
        [&](const Case& c, std::vector<double>& F, std::vector<double>& G, std::vector<double>& lambda) {
          using namespace batch;
          double n0[3] = {1, 0, 0}, dt = c.dt;
          std::vector<double> stress(9 * n), tangent(81 * n);
          const FibreGrowth<> m = material(c.props);
          const Input in{aos<9>(F.data()), shared(n0), soa(G.data(), n), shared(&dt), soa(lambda.data(), n)};
          std::vector<double> G_end(G);
          const Output out{soa(stress.data(), n), soa(G_end.data(), n), soa(tangent.data(), n)};
          guarded(c.props, [&] {
            EXPECT_EQ(update_batch<Tangent::full>(m, n, in, out), 0);
            EXPECT_EQ((update_batch<Tangent::full, Measure::first_piola>(m, n, in, out)), 0);
          });
        });
  });
}

TEST(Traps, CApi) {
  expect_no_flags(5000, [](samples::Random& r, const auto& guarded) {
    constexpr int n = 37;
    with_points(
        r, n,
        [&](const Case& c, std::vector<double>& F, std::vector<double>& G, std::vector<double>& lambda) {
          std::vector<double> state(8 * n), stress(9 * n), tangent(81 * n), energy(n);
          for (int i = 0; i < n; ++i)
            state[entries(8 * i)] = G[entries(i)], state[entries(8 * i + 2)] = lambda[entries(i)];
          const int measure = static_cast<int>(r.bits() % 3);
          guarded(c.props, [&] {
            EXPECT_EQ(myogrowth_update_n(n, c.props.data(), static_cast<int>(c.props.size()), F.data(),
                                         state.data(), state.data(), 8, c.dt, measure, stress.data(),
                                         tangent.data(), energy.data(), nullptr, nullptr, 0),
                      0);
          });
        });
  });
}

TEST(Traps, Umat) {
  expect_no_flags(200000, [](samples::Random& r, const auto& guarded) {
    const Case c = ordinary(r);
    host::Call call;
    call.props = c.props;
    call.F = c.F;
    call.dtime = c.dt;
    call.statev[0] = c.G, call.statev[2] = c.lambda;
    const int families[] = {6, 6, 6, 4, 3};
    call.ntens = r.pick(families);
    if (call.ntens == 4) call.F(0, 2) = call.F(1, 2) = call.F(2, 0) = call.F(2, 1) = 0;
    if (call.ntens == 6 && r.chance(0.2)) call.props[9] = 1;  // local basis
    if (call.ntens == 6 && r.chance(0.2)) {
      while (call.props.size() < 17) call.props.push_back(0);
      call.props.push_back(1);  // mixed
      call.J_hat = call.F.determinant() * r.uniform(0.99, 1.01);
    }
    guarded(call.props, [&] { call.run(); });
  });
}

// The same material with another elasticity, PROPS(19:31), passive or active; law 0 one time in four.
std::vector<double> with_elastic_law(samples::Random& r, std::vector<double> props) {
  const int law = static_cast<int>(r.bits() % 4);
  if (law == 0) return props;
  props[0] = props[1] = 0;
  props.resize(18);
  props.push_back(law);
  props.push_back(r.chance(0.3) ? 0 : r.uniform(0, 1));
  if (law == 2 && r.chance(0.3)) {  // its tendon
    for (double x : {0.5, 0.5, 1000.0, 300.0, 1.4, 0.05, 6.6, 1.03, 1.0, 2700.0, 46.4}) props.push_back(x);
  }
  return props;
}

TEST(Traps, ElasticLaws) {
  expect_no_flags(20000, [](samples::Random& r, const auto& guarded) {
    Case c = ordinary(r);
    c.F =
        samples::deformation(r, 0.15);  // Ehret's exponents of 20 and 100 go beyond the range where G_max = 3
    const std::vector<double> props = with_elastic_law(r, c.props);
    const int n_props = static_cast<int>(props.size()), measure = static_cast<int>(r.bits() % 3);
    double state[9] = {c.G, 0, c.lambda}, after[9], stress[9], tangent[81], energy;
    host::Call call;
    call.props = props;
    call.F = c.F;
    call.dtime = c.dt;
    call.statev[0] = c.G, call.statev[2] = c.lambda;
    const int families[] = {6, 6, 4, 3};
    call.ntens = r.pick(families);
    if (call.ntens == 4) call.F(0, 2) = call.F(1, 2) = call.F(2, 0) = call.F(2, 1) = 0;
    guarded(props, [&] {
      EXPECT_EQ(myogrowth_update(props.data(), n_props, c.F.data(), state, after, 9, c.dt, measure, stress,
                                 tangent, &energy, nullptr, 0),
                0);
      call.run();
    });
  });
}

TEST(Traps, Vumat) {
  expect_no_flags(2000, [](samples::Random& r, const auto& guarded) {
    constexpr int n = 37;
    with_points(
        r, n,
        [&](const Case& c, std::vector<double>& F, std::vector<double>& G, std::vector<double>& lambda) {
          std::vector<double> zero(9 * n), one(n, 1), U(6 * n), defgrad(9 * n), state(8 * n),
              state_end(8 * n), stress(6 * n), energy(n), inelastic(n);
          const int abaqus_row[9] = {0, 1, 2, 0, 1, 2, 1, 2, 0},
                    abaqus_column[9] = {0, 1, 2, 1, 2, 0, 0, 1, 2};
          for (int i = 0; i < n; ++i) {
            const Eigen::Map<const Eigen::Matrix3d> at(F.data() + 9 * i);
            Eigen::Matrix3d V;
            ASSERT_TRUE(left_stretch(Eigen::Matrix3d(at.transpose()).eval().data(), V.data()));  // U of F
            for (int k = 0; k < 9; ++k) defgrad[entries(n * k + i)] = at(abaqus_row[k], abaqus_column[k]);
            for (int k = 0; k < 6; ++k) U[entries(n * k + i)] = V(abaqus_row[k], abaqus_column[k]);
            state[entries(i)] = G[entries(i)], state[entries(2 * n + i)] = lambda[entries(i)];
          }
          const int three = 3, none = 0, n_state = 8, n_props = static_cast<int>(c.props.size()), points = n;
          const double time = 1;
          const char name[81] = "";
          guarded(c.props, [&] {
            vumat_(&points, &three, &three, &n_state, &none, &n_props, &none, &time, &time, &c.dt, name,
                   zero.data(), one.data(), c.props.data(), one.data(), zero.data(), zero.data(), zero.data(),
                   U.data(), defgrad.data(), zero.data(), zero.data(), state.data(), zero.data(), zero.data(),
                   zero.data(), U.data(), defgrad.data(), zero.data(), stress.data(), state_end.data(),
                   energy.data(), inelastic.data());
          });
          EXPECT_TRUE(std::isfinite(stress[0]));
        });
  });
}

TEST(Traps, CalculiX) {
  expect_no_flags(100000, [](samples::Random& r, const auto& guarded) {
    const Case c = ordinary(r);
    std::vector<double> props = c.props;
    double stress[6], ddsdde[36], statev[8] = {c.G, 0, c.lambda}, pnewdt = -1;
    const int n_state = 8, n_props = static_cast<int>(props.size());
    guarded(props, [&] {
      CCX(stress, statev, ddsdde, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
          nullptr, nullptr, &c.dt, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
          &n_state, props.data(), &n_props, nullptr, nullptr, &pnewdt, nullptr, nullptr, c.F.data(), nullptr,
          nullptr, nullptr, nullptr, nullptr, nullptr, 0);
    });
    EXPECT_TRUE(std::isfinite(stress[0]));
  });
}

// In three dimensions and in plane stress, every measure with its operator.
TEST(Traps, Mgis) {
  expect_no_flags(100000, [](samples::Random& r, const auto& guarded) {
    const Case c = ordinary(r);
    const bool is_plane = r.chance(0.2);
    const int row[9] = {0, 1, 2, 0, 1, 0, 2, 1, 2}, column[9] = {0, 1, 2, 1, 0, 2, 0, 2, 1};
    double F0[9] = {1, 1, 1}, F1[9], state0[9] = {c.G, 0, c.lambda}, state1[9], stress[9], K[81], energy,
           rdt = 1;
    for (int i = 0; i < 9; ++i) F1[i] = c.F(row[i], column[i]);
    const int measure = static_cast<int>(r.bits() % 3);
    K[0] = 4, K[1] = measure, K[2] = measure;  // the consistent operator of that measure
    const double* properties = c.props.data();
    myogrowth::abi::mgis::BehaviourData d{
        nullptr,
        c.dt,
        K,
        &rdt,
        nullptr,
        {F0, stress, nullptr, properties, state0, nullptr, nullptr, nullptr},
        {F1, stress, nullptr, properties, state1, &energy, nullptr, nullptr}};
    int result = 0;
    guarded(c.props,
            [&] { result = is_plane ? FibreGrowth_PlaneStress(&d) : FibreGrowth_Tridimensional(&d); });
    EXPECT_EQ(result, 1);
  });
}
