// The UMAT as a host sees it.
#include <gtest/gtest.h>

#include <cfloat>
#include <myogrowth/more/left_stretch.hpp>
#include <thread>

#include "../support/moduli.hpp"
#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using namespace myogrowth;
using host::Call;
using samples::Kind;

namespace {

const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

Call call_of(const samples::Point& p) {
  const auto& g = p.muscle.growth;
  Call c;
  c.props = {p.muscle.c1,
             p.muscle.c2,
             g.tau,
             g.gamma,
             g.G_max,
             g.lambda_crit,
             p.state.n0[0],
             p.state.n0[1],
             p.state.n0[2],
             0,
             p.muscle.energy == EnergyPer::grown_volume ? 1.0 : 0.0};
  c.statev[0] = p.state.G;
  c.F = p.F;
  c.dtime = p.dt;
  return c;
}

TEST(Umat, IsTheCoreBitForBit) {
  samples::Random r(41);
  for (int i = 0; i < 2000; ++i) {
    samples::Point p = samples::point(r, Kind::any);
    p.muscle.energy = r.chance(0.5) ? EnergyPer::reference_volume : EnergyPer::grown_volume;
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    Call c = call_of(p), d = c;
    c.run();
    EXPECT_EQ(c.stress, to_six(u.cauchy()));
    EXPECT_EQ(c.ddsdde, u.ddsdde());
    EXPECT_EQ(c.sse, u.point.psi);
    EXPECT_EQ(c.statev[0], u.state.G);
    EXPECT_EQ(c.statev[1], u.point.lambda_e);
    EXPECT_EQ(c.statev[2], u.point.lambda);
    EXPECT_EQ(c.statev[3], u.point.J);
    EXPECT_EQ(c.statev[4], u.point.Je);
    EXPECT_LE((Eigen::Map<Eigen::Vector3d>(&c.statev[5]) - p.state.n0.normalized()).norm(), 1e-15);
    EXPECT_EQ(c.pnewdt, 1);
    d.run(myogrowth_umat_);
    EXPECT_EQ(c.stress, d.stress);
    EXPECT_EQ(c.ddsdde, d.ddsdde);
    EXPECT_EQ(c.statev, d.statev);
  }
}

TEST(Umat, ZeroesTheThermalArraysAndLeavesTheRest) {
  Call c;
  c.run();
  EXPECT_EQ(c.rpl, 0);
  EXPECT_EQ(c.drpldt, 0);
  EXPECT_EQ(c.ddsddt, c.ddsddt.Zero());
  EXPECT_EQ(c.drplde, c.drplde.Zero());
  EXPECT_EQ(c.spd, host::untouched);
  EXPECT_EQ(c.scd, host::untouched);
}

TEST(Umat, MissingPropsTakeTheirDefaults) {
  samples::Random r(42);
  Call full;
  full.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0};
  full.F = samples::deformation(r, 0.2);
  full.F(0, 0) += 0.2;
  const Call expected = Call(full).run();
  EXPECT_GT(expected.statev[0], 1.001);
  for (std::size_t n = 6; n <= 20; ++n) {
    Call c = full;
    c.props.resize(n);  // beyond the table: zeros
    EXPECT_EQ(c.run().stress, expected.stress) << n;
    EXPECT_EQ(c.statev, expected.statev) << n;
  }
}

TEST(Umat, UninitialisedStateIsOne) {
  Call zero, one;
  zero.F(0, 0) = one.F(0, 0) = 1.1;
  one.statev[0] = 1;
  EXPECT_EQ(zero.run().statev, one.run().statev);
  EXPECT_EQ(zero.ddsdde, one.ddsdde);
}

TEST(Umat, WritesOfTheStateWhatFits) {
  Call all;
  all.F(0, 0) = 1.1;
  all.run();
  for (std::size_t n = 1; n <= 8; ++n) {
    Call c;
    c.F(0, 0) = 1.1;
    c.statev.assign(n, 0.0);
    c.statev.reserve(8);
    c.run();
    for (std::size_t i = 0; i < std::min<std::size_t>(n, 5); ++i) EXPECT_EQ(c.statev[i], all.statev[i]) << n;
    for (std::size_t i = 5; i < n && n < 8; ++i)
      EXPECT_EQ(c.statev[i], 0) << "half a direction, NSTATV = " << n;
    EXPECT_EQ(c.stress, all.stress);
  }
  Call more;
  more.F(0, 0) = 1.1;
  more.statev.assign(20, 0.0);
  more.run();
  for (std::size_t i = 8; i < 20; ++i) EXPECT_EQ(more.statev[i], 0);
}

TEST(Umat, AFibreInTheStateOverridesProps) {
  samples::Random r(43);
  for (int i = 0; i < 100; ++i) {
    const samples::Point p = samples::point(r, Kind::growing);
    Call by_props = call_of(p), by_state = by_props;
    for (std::size_t k = 0; k < 3; ++k) {
      by_state.statev[5 + k] = 3 * p.state.n0[static_cast<int>(k)];
      by_state.props[6 + k] = r.chance(0.5) ? 0 : r.uniform();
    }
    by_props.run();
    by_state.run();
    EXPECT_LE((by_state.stress - by_props.stress).norm(), 1e-13 * by_props.stress.norm());
    EXPECT_NEAR(by_state.statev[0], by_props.statev[0], 1e-14);
    // what is written back is used in the next call, and stays as it is, bit for bit
    Call again = by_props;
    again.statev[0] = p.state.G;
    again.run();
    EXPECT_EQ(again.statev, by_props.statev);
    EXPECT_LE((again.stress - by_props.stress).norm(), 1e-14 * by_props.stress.norm());
  }
}

TEST(Umat, ElasticStepsAndTrivialDeformations) {
  for (double dt : {0.0, -1.0}) {
    Call c;
    c.F(0, 0) = 1.1;
    c.dtime = dt;
    c.statev[0] = 1.03;
    EXPECT_EQ(c.run().statev[0], 1.03);
    EXPECT_EQ(c.ddsdde, c.ddsdde.transpose());
  }
  Call identity, zero;
  zero.F.setZero();  // as without NLGEOM
  for (Call* c : {&identity, &zero}) {
    c->run();
    EXPECT_EQ(c->stress, c->stress.Zero());
    EXPECT_EQ(c->statev[0], 1);
    EXPECT_EQ(c->statev[3], 1);
    EXPECT_EQ(c->sse, 0);
    EXPECT_EQ(c->ddsdde(0, 0), 24);  // c1 + 2 c2
    EXPECT_EQ(c->ddsdde(0, 1), 16);
    EXPECT_EQ(c->ddsdde(3, 3), 4);
    EXPECT_EQ(c->ddsdde(0, 3), 0);
  }
}

TEST(Umat, AskForASmallerStepWhereNoneCanBeTaken) {
  const auto expect = [](Call c) {
    for (double pnewdt : {1.0, DBL_MAX, 0.1, -1.0, nan}) {
      Call d = c;
      d.statev = {1.03, 2, 3, 4, 5, 0, 0, 1};
      const auto before = d.statev;
      d.pnewdt = pnewdt;
      testing::internal::CaptureStderr();
      d.run();
      EXPECT_EQ(testing::internal::GetCapturedStderr(), "");  // an ordinary event: no message
      EXPECT_EQ(d.pnewdt, pnewdt <= 0.25 ? pnewdt : 0.25);
      EXPECT_EQ(d.statev, before);
      EXPECT_TRUE(d.stress.array().isNaN().all());
      EXPECT_TRUE(d.ddsdde.array().isNaN().all());
      EXPECT_TRUE(std::isnan(d.sse));
    }
  };
  Call c;
  c.F(1, 1) = -0.2;
  expect(c);
  c.F(1, 1) = 0;
  expect(c);
  for (double x : {nan, inf, -inf, 1e300}) {
    c.F(1, 1) = 1;
    c.F(0, 1) = x;
    expect(c);
  }
  c = Call();
  c.dtime = nan;
  expect(c);
  c = Call();
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 1};  // also in a local basis
  c.F(2, 2) = -1;
  expect(c);
}

// F n0 = 0 where G is shrinking, with a det F that rounding makes positive: the tangent has the weight
// dG/dlambda/lambda = inf, though the stress is finite.
TEST(Umat, ACollapsedFibreHasNoResult) {
  const struct {
    std::vector<double> n0, F;
  } cases[] = {{{0, 1, 0}, {0.7, 0.1, 0.1, 0, 0, 0, 0.7, -0.3, 0}},
               {{0, 0, 1}, {0.1, -0.3, 1.3, 1.3, 1.1, -0.3, 0, 0, 0}},
               {{0, 1, 0}, {0.1, 0.7, 0.1, 0, 0, 0, 0.7, -0.3, -0.3}},
               {{0, 1, 1}, {0, 1.1, 2.2, 0, 0.20000000000000007, -0.35, 0, -0.20000000000000007, 0.35}},
               {{0, 1, 0}, {1, 0, 0, 0, 1e-310, 0, 0, 0, 1}}};
  for (const auto& k : cases) {
    for (int ntens : {6, 4, 3}) {
      Call c;
      c.ntens = ntens;
      c.props = {16, 4, 0.5, 2, 1.1, 1.01, k.n0[0], k.n0[1], k.n0[2], 0, 0, 0, 0, 0.5, 2, 0.5, 0.9};
      c.statev[0] = 1.05;
      c.F = Eigen::Map<const Eigen::Matrix3d>(k.F.data());
      const auto before = c.statev;
      c.run();
      const int n = ntens == 6 ? 6 : ntens;
      bool finite = true, nothing = true;
      for (int i = 0; i < n; ++i) finite = finite && std::isfinite(c.stress[i]);
      for (int i = 0; i < n * n; ++i) finite = finite && std::isfinite(c.ddsdde(i));
      for (int i = 0; i < n; ++i) nothing = nothing && std::isnan(c.stress[i]);
      for (int i = 0; i < n * n; ++i) nothing = nothing && std::isnan(c.ddsdde(i));
      EXPECT_TRUE(finite || nothing);
      if (ntens == 6) {
        EXPECT_TRUE(nothing);
      }
      if (finite) continue;
      EXPECT_EQ(c.pnewdt, 0.25);
      EXPECT_EQ(c.statev, before);
    }
  }
}

// Every entry is finite, or none and nothing is kept: also where numbers of any size meet, so that products
// leave the range of double in the middle.
TEST(Umat, AResultIsFiniteThroughout) {
  samples::Random r(48);
  int results = 0, refused = 0;
  for (int i = 0; i < 40000; ++i) {
    Call c;
    const double size = r.log_uniform(1e-100, 1e100);
    c.props = {r.chance(0.3) ? 0 : r.log_uniform(1e-150, 1e300),
               r.log_uniform(1e-150, 1e300),
               0.5,
               2,
               1.1,
               1.01,
               1,
               0,
               0,
               0,
               0,
               0,
               0,
               0.5,
               2,
               0.5,
               0.9};
    c.statev[0] = r.chance(0.5) ? 1.05 : r.log_uniform(1e-150, 1e150);
    c.F = samples::rotation(r) * size * samples::deformation(r, 0.6);
    const auto before = c.statev;
    c.run();
    const bool finite = c.stress.allFinite() && c.ddsdde.allFinite() && std::isfinite(c.sse);
    ++(finite ? results : refused);
    if (finite) {
      for (double x : c.statev) EXPECT_TRUE(std::isfinite(x));
      continue;
    }
    EXPECT_TRUE(c.stress.array().isNaN().all());
    EXPECT_TRUE(c.ddsdde.array().isNaN().all());
    EXPECT_EQ(c.statev, before);
    EXPECT_EQ(c.pnewdt, 0.25);
  }
  EXPECT_GT(results, 1000);
  EXPECT_GT(refused, 1000);
}

// Every bad input: one message that names the entry, its value and what is allowed; nothing lost.
struct BadInput {
  const char* name;
  void (*spoil)(Call&);
  std::vector<std::string> words;
  friend void PrintTo(const BadInput& b, std::ostream* out) { *out << b.name; }
};

class UmatBadInput : public testing::TestWithParam<BadInput> {};

TEST_P(UmatBadInput, IsNamed) {
  Call c;
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0};
  c.statev[1] = 5;
  GetParam().spoil(c);
  const auto before = c.statev;
  testing::internal::CaptureStderr();
  c.run();
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  EXPECT_NE(text.find("myogrowth UMAT: "), std::string::npos) << text;
  for (const auto& word : GetParam().words)
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  EXPECT_EQ(c.pnewdt, 0.25);
  const int n = std::max(0, std::min(6, c.ntens));
  for (int i = 0; i < n; ++i) EXPECT_TRUE(std::isnan(c.stress[i]));
  for (int i = n; i < 6; ++i) EXPECT_EQ(c.stress[i], host::untouched);
  for (int i = n * n; i < 36; ++i) EXPECT_EQ(c.ddsdde(i), host::untouched);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(c.statev[i] == before[i] || (std::isnan(before[i]) && std::isnan(c.statev[i])));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Inputs, UmatBadInput,
    testing::Values(
        BadInput{"c1", [](Call& c) { c.props[0] = -3; }, {"PROPS(1) = -3", "c1", "> -2/3 c2"}},
        BadInput{"c1_nan", [](Call& c) { c.props[0] = nan; }, {"PROPS(1) = nan", "c1", "finite"}},
        BadInput{"c2", [](Call& c) { c.props[1] = 0; }, {"PROPS(2) = 0", "c2", "> 0"}},
        BadInput{"c2_inf", [](Call& c) { c.props[1] = inf; }, {"PROPS(2) = inf", "c2", "finite"}},
        BadInput{"tau", [](Call& c) { c.props[2] = -0.5; }, {"PROPS(3) = -0.5", "tau", "> 0"}},
        BadInput{"gamma", [](Call& c) { c.props[3] = -1e-9; }, {"PROPS(4) = -1e-09", "gamma", ">= 0"}},
        BadInput{"G_max", [](Call& c) { c.props[4] = 1; }, {"PROPS(5) = 1", "G_max", "> 1"}},
        BadInput{"lambda_crit", [](Call& c) { c.props[5] = 0; }, {"PROPS(6) = 0", "lambda_crit", "> 0"}},
        BadInput{"n0_nan", [](Call& c) { c.props[7] = nan; }, {"PROPS(8) = nan", "n0_2", "finite"}},
        BadInput{"n0_zero", [](Call& c) { c.props[6] = 0; }, {"PROPS(7:9) = 0, 0, 0", "n0", "> 0"}},
        BadInput{"frame", [](Call& c) { c.props[9] = 2; }, {"PROPS(10) = 2", "frame", "0 or 1"}},
        BadInput{"energy", [](Call& c) { c.props[10] = 0.5; }, {"PROPS(11) = 0.5", "energy", "0 or 1"}},
        BadInput{
            "integration", [](Call& c) { c.props.push_back(2); }, {"PROPS(12) = 2", "integration", "0 or 1"}},
        BadInput{"tolerance",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, -1});
                 },
                 {"PROPS(13) = -1", ">= 0"}},
        BadInput{"tau_rev",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, 0, -1, 2, 0.5, 1});
                 },
                 {"PROPS(14) = -1", "tau_rev", ">= 0"}},
        BadInput{"removal_missing",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, 0, 1, 2, 0.5});
                 },
                 {"NPROPS = 16", "PROPS(15:17)", "G_min"}},
        BadInput{"gamma_rev",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, 0, 1, -2, 0.5, 1});
                 },
                 {"PROPS(15) = -2", "gamma_rev", ">= 0"}},
        BadInput{"G_min",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, 0, 1, 2, 1, 1});
                 },
                 {"PROPS(16) = 1", "G_min", "> 0 and < 1"}},
        BadInput{"lambda_crit_rev",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, 0, 1, 2, 0.5, 1.02});
                 },
                 {"PROPS(17) = 1.02", "lambda_crit_rev", "<= lambda_crit"}},
        BadInput{"no_room_for_lambda",
                 [](Call& c) {
                   c.props.push_back(1);
                   c.statev.resize(2);
                 },
                 {"NSTATV = 2", "PROPS(12) = 1", "at least 3"}},
        BadInput{"unknown",
                 [](Call& c) {
                   c.props.resize(18);
                   c.props.push_back(7);
                 },
                 {"PROPS(19) = 7", "elastic law, must be 0"}},
        BadInput{"beyond_law_0",
                 [](Call& c) {
                   c.props.resize(19);
                   c.props.push_back(7);
                 },
                 {"PROPS(20) = 7", "18 constants", "must be 0"}},
        BadInput{"hybrid",
                 [](Call& c) {
                   c.props.resize(17);
                   c.props.push_back(2);
                 },
                 {"PROPS(18) = 2", "hybrid", "0 or 1"}},
        BadInput{"hybrid_plane_stress",
                 [](Call& c) {
                   c.ntens = 3;
                   c.props.resize(17);
                   c.props.push_back(1);
                 },
                 {"PROPS(18) = 1", "hybrid must be 0 for plane stress"}},
        BadInput{"nprops", [](Call& c) { c.props.resize(5); }, {"NPROPS = 5", "at least 6"}},
        BadInput{"nprops_0", [](Call& c) { c.props.clear(); }, {"NPROPS = 0", "at least 6"}},
        BadInput{"nstatv", [](Call& c) { c.statev.clear(); }, {"NSTATV = 0", "at least 1"}},
        BadInput{"trusses",
                 [](Call& c) { c.ntens = 1, c.ndi = 1, c.nshr = 0; },
                 {"NTENS = 1, NDI = 1, NSHR = 0", "trusses", "not supported", "6 (solids)"}},
        BadInput{"beams",
                 [](Call& c) { c.ntens = 2, c.ndi = 1, c.nshr = 1; },
                 {"NTENS = 2, NDI = 1, NSHR = 1", "beams", "not supported", "6 (solids)"}},
        BadInput{"cohesive",
                 [](Call& c) { c.ntens = 3, c.ndi = 1, c.nshr = 2; },
                 {"NTENS = 3, NDI = 1, NSHR = 2", "cohesive", "not supported", "6 (solids)"}},
        BadInput{"axisymmetric_shells",
                 [](Call& c) { c.ntens = 2, c.ndi = 2, c.nshr = 0; },
                 {"NTENS = 2, NDI = 2, NSHR = 0", "axisymmetric shells", "not supported", "6 (solids)"}},
        BadInput{"generalised_plane_strain_1d",
                 [](Call& c) { c.ntens = 3, c.ndi = 3, c.nshr = 0; },
                 {"NTENS = 3, NDI = 3, NSHR = 0", "generalised plane strain", "not supported", "6 (solids)"}},
        BadInput{"ndi_of_plane_stress",
                 [](Call& c) { c.ntens = 3, c.ndi = 3, c.nshr = 1; },
                 {"NTENS = 3, NDI = 3, NSHR = 1", "must be 2 and 1"}},
        BadInput{"ndi_of_plane_strain",
                 [](Call& c) { c.ntens = 4, c.ndi = 2, c.nshr = 2; },
                 {"NTENS = 4, NDI = 2, NSHR = 2", "must be 3 and 1"}},
        BadInput{"ndi_of_solids",
                 [](Call& c) { c.ndi = 0, c.nshr = 0; },
                 {"NTENS = 6, NDI = 0, NSHR = 0", "must be 3 and 3"}},
        BadInput{"ntens_5", [](Call& c) { c.ntens = 5; }, {"NTENS = 5", "6 (solids)"}},
        BadInput{"ntens_7", [](Call& c) { c.ntens = 7; }, {"NTENS = 7", "6 (solids)"}},
        BadInput{"ntens_huge", [](Call& c) { c.ntens = 1000000; }, {"NTENS = 1000000", "6 (solids)"}},
        BadInput{"ntens_1", [](Call& c) { c.ntens = 1; }, {"NTENS = 1", "6 (solids)"}},
        BadInput{"ntens_0", [](Call& c) { c.ntens = 0; }, {"NTENS = 0", "6 (solids)"}},
        BadInput{"ntens_negative", [](Call& c) { c.ntens = -1; }, {"NTENS = -1", "6 (solids)"}},
        BadInput{"G_negative", [](Call& c) { c.statev[0] = -1; }, {"STATEV(1) = -1", "G", "> 0"}},
        BadInput{"G_nan", [](Call& c) { c.statev[0] = nan; }, {"STATEV(1) = nan", "G", "> 0"}},
        BadInput{"lambda_negative",
                 [](Call& c) {
                   c.props.push_back(1);  // second order
                   c.statev[2] = -1.1;
                 },
                 {"STATEV(3) = -1.1", "lambda", "> 0"}},
        BadInput{"lambda_nan_for_advice",
                 [](Call& c) {
                   c.props.insert(c.props.end(), {0, 1e-3});
                   c.statev[2] = nan;
                 },
                 {"STATEV(3) = nan", "lambda", "> 0"}},
        BadInput{"fibre_nan", [](Call& c) { c.statev[6] = nan; }, {"STATEV(7) = nan", "fibre", "finite"}}),
    [](const auto& info) { return std::string(info.param.name); });

// PROPS(12:17): the UMAT remembers the stretch that the second-order step starts from, and removes if told
// to.
TEST(Umat, SecondOrderAndRemovalAreTheCores) {
  samples::Random r(46);
  for (double integration : {0.0, 1.0}) {
    FibreGrowth<> m;
    m.integration = integration == 0 ? TimeIntegration::backward_euler : TimeIntegration::midpoint_flow;
    m.removal = {0.8, 1.5, 0.6, 0.98};
    Call c;
    c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, integration, 0, 0.8, 1.5, 0.6, 0.98};
    State<> state;
    double highest = 1, lowest = 1;
    for (int i = 1; i <= 200; ++i) {
      const double t = 0.05 * i;
      c.F(0, 0) = 1 + 0.15 * std::sin(t);
      c.F(0, 1) = 0.1 * std::sin(2 * t);
      c.dtime = 0.05;
      const auto u = update(m, c.F, state, 0.05);
      c.run();
      ASSERT_EQ(c.statev[0], u.state.G);
      ASSERT_EQ(c.ddsdde, u.ddsdde());
      state = u.state;
      highest = std::max(highest, state.G);
      lowest = std::min(lowest, state.G);
    }
    EXPECT_GT(highest, 1.05);
    EXPECT_LT(lowest, 0.95);
  }
}

TEST(Umat, AdvisesOnTheTimeIncrement) {
  for (double integration : {0.0, 1.0}) {
    const auto advice = [&](double dt, double tolerance, double pnewdt) {
      Call c;
      c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, integration, tolerance};
      c.statev[2] = std::max(1.1 - 2.5 * dt, 0.5);  // stretched at a rate
      c.F(0, 0) = 1.1;
      c.dtime = dt;
      c.pnewdt = pnewdt;
      c.run();
      EXPECT_TRUE(std::isfinite(c.stress[0]));
      return c.pnewdt;
    };
    EXPECT_EQ(advice(0.5, 0, DBL_MAX), DBL_MAX);   // off
    EXPECT_LT(advice(0.5, 1e-6, DBL_MAX), 1);      // too long for that
    EXPECT_EQ(advice(5.0, 1e-12, DBL_MAX), 0.25);  // but not below that
    EXPECT_EQ(advice(1e-6, 1e-3, DBL_MAX), 2);     // leave to enlarge
    EXPECT_EQ(advice(1e-6, 1e-3, 1), 1);           // never above what the host says
    EXPECT_EQ(advice(0.5, 1e-6, 0.1), 0.1);
    const double once = advice(0.02, 1e-4, DBL_MAX), half = advice(0.01, 1e-4, DBL_MAX);
    if (once < 2 && half < 2) {
      EXPECT_NEAR(half / once, 2, 0.2);  // the error is of second order
    }
  }
}

// No cut is by less than a tenth: with 0.99, 0.999, ... cut follows cut until the host gives up.
TEST(Umat, CutsAreNotForLittle) {
  samples::Random r(47);
  for (int i = 0; i < 200; ++i) {
    Call start;
    start.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, double(i % 2), r.log_uniform(1e-7, 1e-3)};
    start.statev = {1 + 0.05 * r.uniform(), 0, 1.05, 0, 0, 0, 0, 0};
    start.F(0, 0) = 1.05 + 0.1 * r.uniform();
    double dt = r.log_uniform(0.01, 10), factor = 0;
    for (int cuts = 0; cuts < 15 && factor < 1; ++cuts, dt *= factor) {
      Call c = start;
      c.dtime = dt;
      factor = c.run().pnewdt;
      EXPECT_TRUE(factor < 0.9001 || factor == 1) << factor;
    }
    EXPECT_EQ(factor, 1);
  }
}

TEST(Umat, ReportsTheFirstOfSeveralFaults) {
  Call c;
  c.props = {16, -4, -0.5, 2, 1.1, 1.01};
  testing::internal::CaptureStderr();
  c.run();
  EXPECT_NE(testing::internal::GetCapturedStderr().find("PROPS(2) = -4"), std::string::npos);
}

// With *ORIENTATION, Abaqus gives DFGRD1 = (R Q)^T F (R Q) and wants STRESS in the basis R Q.
TEST(Umat, LocalBasisAgreesWithGlobal) {
  samples::Random r(44);
  for (int i = 0; i < 300; ++i) {
    const samples::Point p = samples::point(r, Kind::growing);
    const Eigen::Matrix3d Q = samples::rotation(r);
    Eigen::Matrix3d V;
    ASSERT_TRUE(left_stretch(p.F.data(), V.data()));
    const Eigen::Matrix3d B = V.inverse() * p.F * Q;  // the turned basis, R Q
    Call global = call_of(p), local = global;
    local.F = B.transpose() * p.F * B;
    local.props[9] = 1;
    const Eigen::Vector3d n0 = Q.transpose() * p.state.n0;
    for (std::size_t k = 0; k < 3; ++k) local.props[6 + k] = n0[static_cast<int>(k)];
    global.run();
    local.run();
    EXPECT_NEAR(local.statev[0], global.statev[0], 1e-12);
    const Eigen::Matrix3d sigma = B.transpose() * from_six(Vec6<double>(global.stress)) * B;
    EXPECT_LE((from_six(Vec6<double>(local.stress)) - sigma).norm(), 1e-12 * sigma.norm());
    const Mat6<double> c = moduli::push_forward(Mat3<double>(B.transpose()), Mat6<double>(global.ddsdde));
    EXPECT_LE((local.ddsdde - c).norm(), 1e-12 * c.norm());
  }
}

TEST(Umat, TwoThreadsGetTheSameAsOne) {
  samples::Random r(45);
  std::vector<Call> calls, alone;
  for (int i = 0; i < 4000; ++i) calls.push_back(call_of(samples::point(r, Kind::any)));
  alone = calls;
  for (auto& c : alone) c.run();
  const auto every_second = [&](std::size_t first) {
    for (std::size_t i = first; i < calls.size(); i += 2) calls[i].run();
  };
  std::thread one(every_second, 0), two(every_second, 1);
  one.join();
  two.join();
  for (std::size_t i = 0; i < calls.size(); ++i) {
    ASSERT_EQ(calls[i].ddsdde, alone[i].ddsdde);
    ASSERT_EQ(calls[i].statev, alone[i].statev);
  }
}

}  // namespace
