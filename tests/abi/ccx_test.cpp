// The two routines of libMYOGROWTH as CalculiX calls them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cfloat>
#include <thread>

#include "../support/ccx_host.hpp"
#include "../support/larger.hpp"
#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

using namespace myogrowth;
using samples::Kind;

namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const Kind kinds[] = {Kind::growing, Kind::below_threshold, Kind::saturated, Kind::elastic_step, Kind::any};

// A call of either routine: stress is S, ddsdde is dS/dE. What ccx leaves uninitialised, and what the
// routines do not need, is not there to be read: a null pointer.
struct Call : host::Call {
  static constexpr int icmd_both = 1, icmd_stress = 3;
  int nstatv() const { return static_cast<int>(statev.size()); }
  int nprops() const { return static_cast<int>(props.size()); }

  Call() { pnewdt = -1; }

  Call& ccx() {
    const int n_state = nstatv(), n_props = nprops();
    CCX(stress.data(), statev.data(), ddsdde.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
        nullptr, nullptr, nullptr, nullptr, &dtime, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr,
        nullptr, nullptr, &n_state, props.data(), &n_props, nullptr, nullptr, &pnewdt, nullptr, nullptr,
        F.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, 0);
    return *this;
  }

  // At point `iint` of element `iel` among all points of a model; the others must stay as they are.
  Call& native(int icmd = icmd_both, int iel = 3, int iint = 2) {
    const int mi[1] = {4}, elements = 5, n_state = nstatv(), kode = -100 - nprops();
    const std::size_t n = statev.size(), begin = n * static_cast<std::size_t>(iint - 1 + mi[0] * (iel - 1));
    std::vector<double> before(n * static_cast<std::size_t>(mi[0] * elements), host::untouched),
        after = before;
    std::copy(statev.begin(), statev.end(), before.begin() + static_cast<std::ptrdiff_t>(begin));
    double stiff[21];
    std::fill(stiff, stiff + 21, host::untouched);
    NATIVE(nullptr, &iel, &iint, &kode, props.data(), nullptr, nullptr, nullptr, nullptr, nullptr, F.data(),
           nullptr, nullptr, nullptr, &dtime, nullptr, nullptr, &icmd, nullptr, mi, &n_state, before.data(),
           after.data(), stress.data(), stiff, nullptr, nullptr, nullptr, &pnewdt, nullptr, 0);
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (i >= begin && i < begin + n) {
        statev[i - begin] = after[i];
      } else {
        EXPECT_EQ(after[i], host::untouched) << i;
      }
    }
    for (int col = 0, k = 0; col < 6; ++col) {
      for (int row = 0; row <= col; ++row, ++k) ddsdde(row, col) = ddsdde(col, row) = stiff[k];
    }
    return *this;
  }
};

Mat6<double> symmetric(const Mat6<double>& D) { return (D + D.transpose()) / 2; }

// A point with, now and then, each of the options: energy, second order, removal.
samples::Point point_with_options(samples::Random& r, Kind kind, double largest_dt = 1e4) {
  samples::Point p = samples::point(r, kind, largest_dt);
  if (r.chance(0.5)) p.muscle.energy = EnergyPer::grown_volume;
  if (r.chance(0.3)) p.muscle.removal = {0.8, 1.5, 0.6, p.muscle.growth.lambda_crit};
  if (r.chance(0.3)) {
    p.muscle.integration = TimeIntegration::midpoint_flow;
    p.state.lambda = r.uniform(0.9, 1.2);
  }
  return p;
}

Call call_of(const samples::Point& p, bool fibre_in_state) {
  const auto& g = p.muscle.growth;
  const auto& removal = p.muscle.removal;
  const double given = p.muscle.energy == EnergyPer::grown_volume,
               second = p.muscle.integration == TimeIntegration::midpoint_flow;
  const Eigen::Vector3d n = fibre_in_state ? Eigen::Vector3d::Zero() : p.state.n0;
  Call c;
  c.props = {p.muscle.c1, p.muscle.c2, g.tau, g.gamma, g.G_max, g.lambda_crit,
             n[0],        n[1],        n[2],  0,       given,   second};
  if (removal.tau_rev > 0) {
    c.props.insert(c.props.end(),
                   {0, removal.tau_rev, removal.gamma_rev, removal.G_min, removal.lambda_crit_rev});
  }
  c.statev[0] = p.state.G;
  c.statev[2] = p.state.lambda;
  for (int i = 0; i < 3 && fibre_in_state; ++i) c.statev[static_cast<std::size_t>(5 + i)] = p.state.n0[i];
  c.F = p.F;
  c.dtime = p.dt;
  return c;
}

TEST(Ccx, BothAreTheCoreBitForBit) {
  samples::Random r(71);
  int grew = 0, shrank = 0;
  double unsymmetry = 0;
  for (int i = 0; i < 3000; ++i) {
    const samples::Point p = point_with_options(r, r.pick(kinds));
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    ASSERT_TRUE(u.ok());
    const Call start = call_of(p, r.chance(0.5));
    Call c = start, n = start, stress_only = start;
    c.ccx();
    n.native();
    stress_only.native(Call::icmd_stress);
    const Mat6<double> D = u.dS_dE();
    EXPECT_EQ(c.ddsdde, D);
    EXPECT_EQ(n.ddsdde, symmetric(D));
    EXPECT_EQ(stress_only.ddsdde, D.Constant(host::untouched));
    for (const Call* x : {&c, &n, &stress_only}) {
      EXPECT_EQ(x->stress, to_six(u.second_piola()));
      EXPECT_EQ(x->statev[0], u.state.G);
      EXPECT_EQ(x->statev[1], u.point.lambda_e);
      EXPECT_EQ(x->statev[2], u.point.lambda);
      EXPECT_EQ(x->statev[3], u.point.J);
      EXPECT_EQ(x->statev[4], u.point.Je);
      for (int k = 0; k < 3; ++k) EXPECT_EQ(x->statev[static_cast<std::size_t>(5 + k)], u.point.n0[k]);
      EXPECT_EQ(x->pnewdt, -1);
    }
    grew += u.state.G > p.state.G;
    shrank += u.state.G < p.state.G;
    unsymmetry = std::max(unsymmetry, (D - D.transpose()).norm() / D.norm());
  }
  EXPECT_GT(grew, 500);
  EXPECT_GT(shrank, 50);
  EXPECT_GT(unsymmetry, 0.05);  // or NATIVE's symmetric part would be no test
}

// dE = sym(F^T dF): with dF = F^-T dE, S is differenced along each of the six strains.
TEST(Ccx, TheTangentIsTheCentralDifferenceOfTheStress) {
  samples::Random r(72);
  const double h = 5e-7;
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const Kind smooth[] = {Kind::growing, Kind::below_threshold, Kind::elastic_step};
    const samples::Point p = point_with_options(r, r.pick(smooth), 10);
    const Call start = call_of(p, r.chance(0.5));
    Mat6<double> difference;
    for (int col = 0; col < 6; ++col) {
      Vec6<double> dE = Vec6<double>::Zero();
      dE[col] = col < 3 ? h : h / 2;
      const Eigen::Matrix3d dF = p.F.transpose().inverse() * from_six(dE);
      Call plus = start, minus = start;
      plus.F += dF;
      minus.F -= dF;
      difference.col(col) = (plus.ccx().stress - minus.ccx().stress) / (2 * h);
    }
    const Mat6<double> D = Call(start).ccx().ddsdde;
    worst = larger(worst, (difference - D).norm() / D.norm());
  }
  EXPECT_LE(worst, 2e-7);
}

// In several steps, each from what the one before has left: the fibre and lambda are remembered.
TEST(Ccx, AHistoryOfSecondOrderWithRemovalIsTheCores) {
  FibreGrowth<> m;
  m.integration = TimeIntegration::midpoint_flow;
  m.removal = {0.8, 1.5, 0.6, 0.98};
  State<> state;
  state.n0 = {0.6, 0.48, 0.64};
  Call c;
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 0.6, 0.48, 0.64, 0, 0, 1, 0, 0.8, 1.5, 0.6, 0.98};
  Call n = c;
  double highest = 1, lowest = 1;
  for (int i = 1; i <= 200; ++i) {
    c.F(0, 0) = 1 + 0.25 * std::sin(0.05 * i);
    c.F(0, 1) = 0.1 * std::sin(0.1 * i);
    n.F = c.F;
    const auto u = update(m, c.F, state, c.dtime);
    c.ccx();
    n.native();
    state = u.state;
    EXPECT_NEAR(c.statev[0], state.G, 1e-13);
    EXPECT_LE((c.stress - to_six(u.second_piola())).norm(), 1e-12 * (1 + c.stress.norm()));
    EXPECT_EQ(n.stress, c.stress);
    EXPECT_EQ(n.statev, c.statev);
    highest = std::max(highest, state.G);
    lowest = std::min(lowest, state.G);
  }
  EXPECT_GT(highest, 1.01);
  EXPECT_LT(lowest, 0.99);
}

// All that CalculiX 2.20 can read of *INITIAL CONDITIONS: six entries, STATEV(5) = -1.
TEST(Ccx, AFibreInTheFirstSixStateVariables) {
  samples::Random r(73);
  for (int i = 0; i < 100; ++i) {
    const samples::Point p = samples::point(r, Kind::growing);
    Call expected = call_of(p, true), c = expected;
    expected.statev[2] = 0;
    c.statev = {p.state.G, p.state.n0[0], p.state.n0[1], p.state.n0[2], -1, 0, 0, 0};
    c.props[11] = expected.props[11] = i % 2;  // of second order: from lambda = 1, not from n0_2
    Call n = c;
    expected.ccx();
    c.ccx();
    n.native();
    EXPECT_EQ(c.stress, expected.stress);
    EXPECT_EQ(c.statev, expected.statev);
    EXPECT_EQ(n.stress, expected.stress);
    EXPECT_EQ(n.statev, expected.statev);
  }
}

TEST(Ccx, NativeFindsItsPointInTheModel) {
  Call expected;
  expected.F(0, 0) = 1.1;
  expected.ccx();
  for (int iel = 1; iel <= 5; ++iel) {
    for (int iint = 1; iint <= 4; ++iint) {
      Call n;
      n.F(0, 0) = 1.1;
      n.native(Call::icmd_both, iel, iint);  // looks at all other points, too
      EXPECT_EQ(n.statev, expected.statev);
    }
  }
}

TEST(Ccx, ZeroIsTakenAsIdentity) {  // F and the state in a step without NLGEOM
  for (Call& (*run)(Call&) :
       {+[](Call& c) -> Call& { return c.ccx(); }, +[](Call& c) -> Call& { return c.native(); }}) {
    Call c;
    c.F.setZero();
    run(c);
    EXPECT_EQ(c.stress, c.stress.Zero());
    EXPECT_EQ(c.statev, (std::vector<double>{1, 1, 1, 1, 1, 1, 0, 0}));
    EXPECT_EQ(c.ddsdde(0, 0), 24);  // c1 + 2 c2
    EXPECT_EQ(c.ddsdde(0, 1), 16);
    EXPECT_EQ(c.ddsdde(3, 3), 4);
    EXPECT_EQ(c.ddsdde(0, 3), 0);
  }
}

TEST(Ccx, AsksForASmallerStepWhereNoneCanBeTaken) {
  for (double bad : {-0.2, 0.0, nan, DBL_MAX}) {
    for (double pnewdt : {-1.0, 0.1, 0.25, 0.5, 1.0}) {
      for (bool native : {false, true}) {
        Call c;
        c.statev = {1.03, 2, 3, 4, 5, 0, 0, 1};
        const auto before = c.statev;
        c.F(1, 1) = bad;
        c.pnewdt = pnewdt;
        testing::internal::CaptureStdout();
        native ? c.native() : c.ccx();
        EXPECT_EQ(testing::internal::GetCapturedStdout(), "");  // an ordinary event: no message
        EXPECT_EQ(c.pnewdt, pnewdt == 0.1 ? 0.1 : 0.25);
        EXPECT_EQ(c.statev, before);
        EXPECT_TRUE(c.stress.array().isNaN().all());
        EXPECT_TRUE(c.ddsdde.array().isNaN().all());
      }
    }
  }
}

// The UMAT's PNEWDT is the factor; ccx knows only cuts.
TEST(Ccx, AdviceBelowOneIsACutAndAboveOneIsNothing) {
  int cuts = 0, enlargements = 0;
  for (double tolerance : {1e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6}) {
    host::Call umat;
    umat.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, 0, tolerance};
    umat.F(0, 0) = 1.1;
    umat.pnewdt = DBL_MAX;
    Call start;
    start.props = umat.props;
    start.F = umat.F;
    const double factor = umat.run().pnewdt;
    for (double pnewdt : {-1.0, 0.01, 1.0}) {
      Call c = start, n = start;
      c.pnewdt = n.pnewdt = pnewdt;
      c.ccx();
      n.native();
      EXPECT_EQ(c.pnewdt, factor >= 1 || pnewdt == 0.01 ? pnewdt : factor) << tolerance;
      EXPECT_EQ(n.pnewdt, c.pnewdt);
      EXPECT_EQ(c.statev[0], umat.statev[0]);  // the step is a good one all the same
    }
    cuts += factor < 1;
    enlargements += factor > 1;
  }
  EXPECT_GT(cuts, 0);
  EXPECT_GT(enlargements, 0);
}

// Bad input ends the process with ccx's status 201; the one message goes to stdout, where ccx has its own.
// What the child process writes there is led to where gtest looks, and its stderr to nowhere.
class CcxBadInputDeathTest : public testing::Test {
 protected:
  static void stdout_alone() {
    dup2(STDERR_FILENO, STDOUT_FILENO);
    if (!std::freopen("/dev/null", "w", stderr)) std::abort();
  }
  static void expect_end(Call c, const std::string& words) {
    const std::string text = "^\n \\*ERROR in myogrowth: [^\n]*" + words + "[^\n]*\n\n$";
    EXPECT_EXIT((stdout_alone(), c.ccx()), testing::ExitedWithCode(201), text);
    EXPECT_EXIT((stdout_alone(), c.native()), testing::ExitedWithCode(201), text);
  }
};

TEST_F(CcxBadInputDeathTest, InProps) {
  Call c;
  c.props[1] = -4;
  expect_end(c, "PROPS\\(2\\) = -4: c2.*> 0");
  c = Call();
  c.props.resize(5);
  expect_end(c, "NPROPS = 5");
  c = Call();
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 0, 0, 0};
  expect_end(c, "PROPS\\(7:9\\) = 0, 0, 0");
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 1};
  expect_end(c, "PROPS\\(10\\) = 1.*ORIENTATION");
}

TEST_F(CcxBadInputDeathTest, WarnsOfMoreConstantsThanFit) {
  Call c;
  c.props = {0, 0, 0.5, 2, 1.1, 1.01, 1, 0, 0};
  c.props.resize(21);
  c.props[18] = 1, c.props[20] = 10;
  const auto run = [&c] {
    stdout_alone();
    for (int i = 0; i < 2; ++i) c.ccx(), c.native();
    std::_Exit(0);
  };
  EXPECT_EXIT(run(), testing::ExitedWithCode(0), "^$");
  c.props.push_back(10);
  EXPECT_EXIT(run(), testing::ExitedWithCode(0),
              "^\n \\*WARNING in myogrowth: CONSTANTS = 22: CalculiX has room for 21[^\n]*\n\n$");
}

TEST_F(CcxBadInputDeathTest, InDepvarAndStatev) {
  Call c;
  c.statev.clear();
  expect_end(c, "\\*DEPVAR = 0");
  c = Call();
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, 1};
  c.statev.resize(2);
  expect_end(c, "\\*DEPVAR = 2: with PROPS\\(12\\) = 1");
  c = Call();
  c.statev = {0, 1, 0, 0, -1, 0};
  expect_end(c, "STATEV\\(5\\) = -1.*at least 8");
  c = Call();
  c.statev[0] = -1;
  expect_end(c, "STATEV\\(1\\) = -1");
  c = Call();
  c.props = {16, 4, 0.5, 2, 1.1, 1.01, 1, 0, 0, 0, 0, 1};
  c.statev[2] = -1;
  expect_end(c, "STATEV\\(3\\) = -1");
  c = Call();
  c.statev[6] = nan;
  expect_end(c, "STATEV\\(7\\) = -?nan");
}

TEST_F(CcxBadInputDeathTest, IsToldOnceByAllThreads) {
  const auto run_four = [] {
    stdout_alone();
    std::atomic<int> ready{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&ready] {
        Call c;
        c.props[1] = -4;
        ++ready;
        while (ready < 4) std::this_thread::yield();
        c.ccx();
      });
    }
    for (auto& t : threads) t.join();
  };
  for (int i = 0; i < 50; ++i) {  // once in a few of them, two threads meet there
    EXPECT_EXIT(run_four(), testing::ExitedWithCode(201), "^\n \\*ERROR [^\n]*\n\n$");
  }
}

}  // namespace
