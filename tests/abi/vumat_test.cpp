// The VUMAT as a host sees it, held to the UMAT. Compiled for either library (MYOGROWTH_VUMAT_SINGLE), and
// once more as a host that has Abaqus/Explicit's message and exit utilities (MYOGROWTH_TEST_WITH_UTILITIES).
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cfloat>
#include <thread>

#include "../support/larger.hpp"
#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

#ifdef MYOGROWTH_TEST_WITH_UTILITIES
namespace {
struct {
  int exits = 0, lop = 0;
  std::string text;
} utilities;
}  // namespace
extern "C" {
void xplb_abqerr_(const int* lop, const char* text, const int*, const void*, const char*, std::size_t length,
                  std::size_t) {
  utilities.lop = *lop;
  utilities.text += std::string(text, length) + "\n";
}
void xplb_exit_() { ++utilities.exits; }
}
#endif

namespace {

using Number = VumatReal;
constexpr double tolerance = sizeof(Number) == sizeof(float) ? 1e-5 : 1e-12;

using Eigen::Matrix3d;
using samples::Kind;
using Sym = Eigen::Matrix<double, 6, 1>;
using Numbers = std::vector<Number>;

const Number nan = std::numeric_limits<Number>::quiet_NaN(), inf = std::numeric_limits<Number>::infinity();
constexpr Number untouched = -777;

Matrix3d stretch_of(const Matrix3d& F) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(F.transpose() * F).operatorSqrt();
}

// 11 22 33 12 23 31
Sym to_vumat(const Matrix3d& s) {
  return (Sym() << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0)).finished();
}

/// One call's arguments, sized to the entry, and what came back. What the VUMAT promises not to read is not
/// there to be read.
struct Block {
  int size, ndir = 3, nshr = 3, nstatev;
  Numbers props = {16, 4, 0.5, 2, Number(1.1), Number(1.01)};
  Number step_time = 1, total_time = 1, dt = Number(0.1);
  Numbers density, strain_inc, stretch_old, stress_old, state_old, intern_old, inelas_old, stretch;
  Numbers stress, state, intern, inelas;

  explicit Block(int n, int n_state = 8)
      : size(n),
        nstatev(n_state),
        density(of(1), Number(1)),
        strain_inc(of(6)),
        stretch_old(of(6)),
        stress_old(of(6)),
        state_old(of(n_state)),
        intern_old(of(1), Number(3)),
        inelas_old(of(1), Number(4)) {
    for (int k = 0; k < n; ++k) set(stretch_old, k, to_vumat(Matrix3d::Identity()));
    stretch = stretch_old;
  }
  std::size_t of(int components) const { return static_cast<std::size_t>(size * components); }
  std::size_t at(int k, int i) const { return static_cast<std::size_t>(k + size * i); }
  void set(Numbers& array, int k, const Sym& s) const {
    for (int i = 0; i < 6; ++i) array[at(k, i)] = static_cast<Number>(s[i]);
  }
  Sym get(const Numbers& array, int k) const {
    Sym s;
    for (int i = 0; i < 6; ++i) s[i] = array[at(k, i)];
    return s;
  }
  bool is_nan(int k) const { return get(stress, k).array().isNaN().all(); }

  Block& run(Vumat* vumat = vumat_) {
    const int nfieldv = 0, lanneal = 0, nprops = static_cast<int>(props.size());
    stress.assign(of(std::max(0, ndir + nshr)), untouched);
    state.assign(of(nstatev), untouched);
    intern.assign(of(1), untouched);
    inelas.assign(of(1), untouched);
    vumat(&size, &ndir, &nshr, &nstatev, &nfieldv, &nprops, &lanneal, &step_time, &total_time, &dt, nullptr,
          nullptr, nullptr, props.data(), density.data(), strain_inc.data(), nullptr, nullptr,
          stretch_old.data(), nullptr, nullptr, stress_old.data(), state_old.data(), intern_old.data(),
          inelas_old.data(), nullptr, stretch.data(), nullptr, nullptr, stress.data(), state.data(),
          intern.data(), inelas.data());
    return *this;
  }
};

// What a call said, and how often it ended the analysis.
std::string run_and_listen(Block& b) {
#ifdef MYOGROWTH_TEST_WITH_UTILITIES
  utilities = {};
  testing::internal::CaptureStderr();
  b.run();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(utilities.exits, utilities.text.empty() ? 0 : 1);
  EXPECT_EQ(utilities.lop, utilities.text.empty() ? 0 : -2);
  EXPECT_EQ(utilities.text.find('%'), std::string::npos);  // % would ask for an argument
  EXPECT_LE(utilities.text.size(), 500u);                  // Abaqus's limit
  return utilities.text;
#else
  testing::internal::CaptureStderr();
  b.run();
  return testing::internal::GetCapturedStderr();
#endif
}

std::vector<double> props_of(const samples::Point& p) {
  const auto& g = p.muscle.growth;
  const bool grown = p.muscle.energy == myogrowth::EnergyPer::grown_volume;
  return {p.muscle.c1,   p.muscle.c2,   g.tau,         g.gamma, g.G_max,        g.lambda_crit,
          p.state.n0[0], p.state.n0[1], p.state.n0[2], 0,       grown ? 1. : 0.};
}

// A block of points, each at a stretch, a state and a fibre of its own.
Block random_block(samples::Random& r, int size) {
  Block b(size);
  for (int k = 0; k < size; ++k) {
    b.set(b.stretch, k, to_vumat(stretch_of(samples::deformation(r, 0.4))));
    const Eigen::Vector3d n0 = samples::direction(r);
    b.state_old[b.at(k, 0)] = static_cast<Number>(r.uniform(1, 1.09));
    for (int i = 0; i < 3; ++i) b.state_old[b.at(k, 5 + i)] = static_cast<Number>(n0[i]);
  }
  return b;
}

// Point k of b as a block of its own.
Block alone(const Block& b, int k) {
  Block one(1, b.nstatev);
  one.props = b.props;
  one.dt = b.dt;
  for (int i = 0; i < 6; ++i) one.stretch[one.at(0, i)] = b.stretch[b.at(k, i)];
  for (int i = 0; i < b.nstatev; ++i) one.state_old[one.at(0, i)] = b.state_old[b.at(k, i)];
  one.density[0] = b.density[static_cast<std::size_t>(k)];
  return one;
}

void expect_same_point(const Block& a, int k, const Block& b, int l) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(a.stress[a.at(k, i)], b.stress[b.at(l, i)]);
  for (int i = 0; i < a.nstatev; ++i) EXPECT_EQ(a.state[a.at(k, i)], b.state[b.at(l, i)]);
  EXPECT_EQ(a.intern[a.at(k, 0)], b.intern[b.at(l, 0)]);
  EXPECT_EQ(a.inelas[a.at(k, 0)], b.inelas[b.at(l, 0)]);
}

// Every point follows a path of its own, stretched to and fro while it turns; the UMAT is given F, the VUMAT
// U, and each its own state of the step before.
void follow_paths(samples::Random& r, int size, int n_steps, double& worst) {
  samples::Point p = samples::point(r, Kind::growing);
  p.muscle.energy =
      r.chance(0.5) ? myogrowth::EnergyPer::reference_volume : myogrowth::EnergyPer::grown_volume;
  p.muscle.growth.lambda_crit = r.uniform(0.9, 1.05);
  const std::vector<double> props = props_of(p);
  Block b(size, r.chance(0.5) ? 8 : 11);
  b.props.assign(props.begin(), props.end());
  b.props[9] = r.chance(0.5) ? 0 : 1;  // without meaning here
  b.dt = static_cast<Number>(p.muscle.growth.tau * r.log_uniform(1e-2, 1));

  struct Path {
    Matrix3d H, turn, R, U_old = Matrix3d::Identity();
    double frequency, density;
    host::Call umat;
  };
  std::vector<Path> paths(static_cast<std::size_t>(size));
  for (Path& path : paths) {
    path.H = samples::deformation(r, 0.3) - Matrix3d::Identity();
    path.turn = samples::rotation(r, 0.3);
    path.R = samples::rotation(r);
    path.frequency = r.uniform(0.05, 0.5);
    path.density = r.log_uniform(1e-9, 1e3);
    path.umat.props = props;
    path.umat.dtime = b.dt;
  }
  for (int step = 1; step <= n_steps; ++step) {
    for (int k = 0; k < size; ++k) {
      Path& path = paths[static_cast<std::size_t>(k)];
      path.R = path.turn * path.R;
      path.umat.F = path.R * (Matrix3d::Identity() + std::sin(path.frequency * step) * path.H);
      const Matrix3d U = stretch_of(path.umat.F);
      b.set(b.stretch_old, k, to_vumat(path.U_old));
      b.set(b.stretch, k, to_vumat(U));
      const double J_mid = (path.U_old.determinant() + U.determinant()) / 2;
      b.density[static_cast<std::size_t>(k)] = static_cast<Number>(path.density / J_mid);
      path.U_old = U;
      path.umat.run();
    }
    b.run();
    for (int k = 0; k < size; ++k) {
      const Path& path = paths[static_cast<std::size_t>(k)];
      const Matrix3d R = path.umat.F * path.U_old.inverse();
      const Matrix3d sigma = myogrowth::from_six(myogrowth::Vec6<double>(path.umat.stress));
      const Sym expected = to_vumat(R.transpose() * sigma * R);
      const double size_of_stress = expected.norm() + p.muscle.c1 + p.muscle.c2;
      const auto compare = [&](double difference, double unit) {
        worst = larger(worst, difference / unit);
        ASSERT_LE(difference, tolerance * unit) << "step " << step << ", point " << k;
      };
      compare((b.get(b.stress, k) - expected).norm(), size_of_stress);
      for (int i = 0; i < 8; ++i) {
        const double ours = b.state[b.at(k, i)], umats = path.umat.statev[static_cast<std::size_t>(i)];
        compare(std::abs(ours - umats), std::max(1.0, std::abs(umats)));
      }
      compare(std::abs(b.intern[b.at(k, 0)] * path.density - path.umat.sse), path.umat.sse + size_of_stress);
      ASSERT_EQ(b.inelas[b.at(k, 0)], b.inelas_old[b.at(k, 0)]);
    }
    b.state_old = b.state;
  }
}

TEST(Vumat, IsTheUmatInTheTurnedBasis) {
  samples::Random r(61);
  double worst = 0;
  for (const auto& blocks : {std::pair<int, int>{1, 200}, {7, 40}, {136, 4}}) {
    for (int i = 0; i < blocks.second; ++i) follow_paths(r, blocks.first, 60, worst);
  }
  RecordProperty("worst_relative_difference", testing::PrintToString(worst));
}

TEST(Vumat, UniaxialStretchByHand) {
  Block b(1);
  b.dt = 0;  // elastic
  b.state_old[0] = Number(1.25);
  b.density[0] = 2;
  b.set(b.stretch_old, 0, (Sym() << 1.5, 1, 1, 0, 0, 0).finished());
  b.stretch = b.stretch_old;
  b.run();
  const double J = 1.5, ln_Je = std::log(1.5 / 1.25), be = 1.44;  // (1.5/1.25)^2
  EXPECT_NEAR(b.stress[0], (16 * ln_Je + 4 * (be - 1)) / J, 10 * tolerance);
  EXPECT_NEAR(b.stress[1], 16 * ln_Je / J, 10 * tolerance);
  EXPECT_EQ(b.stress[3], 0);
  EXPECT_NEAR(b.state[1], 1.2, tolerance);
  const double psi = (16 * ln_Je * ln_Je + 4 * (be - 1 - 2 * ln_Je)) / 2;
  EXPECT_NEAR(b.intern[0], psi / (2 * J), 10 * tolerance);
}

TEST(Vumat, APointDoesNotDependOnItsPlaceInTheBlock) {
  samples::Random r(62);
  for (int size : {1, 7, 136}) {
    Block b = random_block(r, size), backwards = b;
    for (int k = 0; k < size; ++k) {
      const int l = size - 1 - k;
      for (int i = 0; i < 6; ++i) backwards.stretch[b.at(k, i)] = b.stretch[b.at(l, i)];
      for (int i = 0; i < 8; ++i) backwards.state_old[b.at(k, i)] = b.state_old[b.at(l, i)];
    }
    b.run();
    backwards.run(myogrowth_vumat_);
    for (int k = 0; k < size; ++k) {
      EXPECT_GE(b.state[b.at(k, 0)], b.state_old[b.at(k, 0)]);
      expect_same_point(b, k, alone(b, k).run(), 0);
      expect_same_point(b, k, backwards, size - 1 - k);
    }
  }
}

TEST(Vumat, InitialCallIsLinearElastic) {
  Block b(7, 10);
  b.step_time = b.total_time = 0;
  samples::Random r(63);
  for (auto* array : {&b.strain_inc, &b.stress_old, &b.state_old}) {
    for (Number& x : *array) x = static_cast<Number>(r.uniform(-1, 1));  // no state of ours either
  }
  b.stretch.assign(b.of(6), nan);  // not to be looked at
  b.stretch_old = b.stretch;
  EXPECT_EQ(run_and_listen(b), "");
  for (int k = 0; k < 7; ++k) {
    const Sym e = b.get(b.strain_inc, k);
    Sym expected = b.get(b.stress_old, k) + 8 * e;  // 2 c2, the shears being tensor components
    expected.head<3>().array() += 16 * e.head<3>().sum();
    EXPECT_LE((b.get(b.stress, k) - expected).norm(), tolerance * 50);
  }
  EXPECT_EQ(b.state, b.state_old);
  EXPECT_EQ(b.intern, b.intern_old);
  EXPECT_EQ(b.inelas, b.inelas_old);
}

TEST(Vumat, InitialCallHasTheStiffnessOfTheLaw) {
  const double h = std::is_same<Number, double>::value ? 1e-7 : 1e-3;
  for (int i = 0; i < 6; ++i) {
    Block law(1), check(1);
    check.step_time = check.total_time = 0;
    const Sym e = h * Sym::Unit(i);
    law.set(law.stretch, 0, to_vumat(Matrix3d::Identity()) + e);
    check.set(check.strain_inc, 0, e);
    const Sym difference = law.run().get(law.stress, 0) - check.run().get(check.stress, 0);
    EXPECT_LE(difference.norm(), 5 * h * check.get(check.stress, 0).norm()) << i;
  }
}

TEST(Vumat, LaterStepsBeginWithTheLaw) {
  Block b(1), later(1);
  b.set(b.stretch, 0, (Sym() << 1.2, 1, 1, 0, 0, 0).finished());
  later.stretch = b.stretch;
  later.step_time = 0;  // of a second step
  EXPECT_EQ(b.run().stress, later.run().stress);
}

TEST(Vumat, WritesOfTheStateWhatFitsAndKeepsTheRest) {
  samples::Random r(64);
  Block all = random_block(r, 3);
  all.props.insert(all.props.end(), {1, 0, 0});
  std::fill(all.state_old.begin() + 5 * 3, all.state_old.end(), Number(0));
  all.run();
  for (int n = 1; n <= 20; ++n) {
    Block b(3, n);
    b.props = all.props;
    b.stretch = all.stretch;
    for (int k = 0; k < 3; ++k) {
      b.state_old[b.at(k, 0)] = all.state_old[all.at(k, 0)];
      for (int i = 1; i < n; ++i) {
        if (i < 5 || i >= 8) b.state_old[b.at(k, i)] = Number(100 * i + k);
        if (i >= 5 && i < 8 && n < 8) b.state_old[b.at(k, i)] = Number(100 * i + k);
      }
    }
    b.run();
    EXPECT_EQ(b.stress, all.stress);
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < n; ++i) {
        const bool written = i < 5 || (i < 8 && n >= 8);
        EXPECT_EQ(b.state[b.at(k, i)], written ? all.state[all.at(k, i)] : b.state_old[b.at(k, i)]) << n << i;
      }
    }
  }
}

TEST(Vumat, UninitialisedStateIsOne) {
  Block zero(2);
  zero.set(zero.stretch, 0, (Sym() << 1.2, 1, 1, 0, 0, 0).finished());
  zero.set(zero.stretch, 1, (Sym() << 1.2, 1, 1, 0, 0, 0).finished());
  zero.state_old[1] = 1;
  zero.run();
  expect_same_point(zero, 0, zero, 1);
  EXPECT_GT(zero.state[0], 1.01);
}

TEST(Vumat, APointThatFailsDoesNotSpoilItsNeighbours) {
  samples::Random r(65);
  const Block whole = random_block(r, 7);
  const std::vector<Sym> bad = {
      Sym::Zero(),
      (Sym() << 1, 1, -1, 0, 0, 0).finished(),
      (Sym() << 1, 1, 1, nan, 0, 0).finished(),
      (Sym() << inf, 1, 1, 0, 0, 0).finished(),
      (Sym() << 1, 1, 1, 1, 1, 1).finished(),
      (Sym() << 1, 1, 1, 0, 0, 2).finished(),
  };
  for (const Sym& U : bad) {
    Block b = whole;
    b.set(b.stretch, 3, U);
    EXPECT_EQ(run_and_listen(b), "");
    EXPECT_TRUE(b.is_nan(3));
    for (int i = 0; i < 8; ++i) EXPECT_EQ(b.state[b.at(3, i)], b.state_old[b.at(3, i)]);
    EXPECT_TRUE(std::isnan(b.intern[3]));
    EXPECT_EQ(b.inelas[3], b.inelas_old[3]);
    for (int k = 0; k < 7; ++k) {
      if (k != 3) expect_same_point(b, k, alone(b, k).run(), 0);
    }
  }
}

// In single precision J = 1e50 is infinite, though the stress is not.
TEST(Vumat, AStateBeyondTheHostsNumbersIsNoResult) {
  Block b(2);
  b.set(b.stretch, 0, (Sym() << 1e20, 1e20, 1e10, 0, 0, 0).finished());
  EXPECT_EQ(run_and_listen(b), "");
  if (sizeof(Number) == sizeof(float)) {
    EXPECT_TRUE(b.is_nan(0));
    EXPECT_TRUE(std::isnan(b.intern[0]));
    for (int i = 0; i < 8; ++i) EXPECT_EQ(b.state[b.at(0, i)], 0) << i;
  } else {
    EXPECT_NEAR(b.state[b.at(0, 3)], Number(1e50), Number(1e35));
    EXPECT_TRUE(std::isfinite(b.intern[0]));
  }
  EXPECT_FALSE(b.is_nan(1));
}

TEST(Vumat, ABadStateIsNamedOncePerCall) {
  samples::Random r(66);
  const Block whole = random_block(r, 7);
  const struct {
    int entry;
    Number value;
    const char* words;
  } cases[] = {{0, -1, "STATEV(1) = -1 "},
               {0, nan, "STATEV(1) = nan "},
               {2, -1, "STATEV(3) = -1 "},
               {6, inf, "STATEV(7) = inf "}};
  for (const auto& c : cases) {
    Block b = whole;
    b.props.resize(12);
    b.props[11] = c.entry == 2;  // second order, which starts from the stretch of the state
    for (int k : {2, 5}) b.state_old[b.at(k, c.entry)] = c.value;
    const std::string text = run_and_listen(b);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    EXPECT_NE(text.find(c.words), std::string::npos) << text;
    for (int k = 0; k < 7; ++k) {
      if (k == 2 || k == 5) {
        EXPECT_TRUE(b.is_nan(k));
      } else {
        expect_same_point(b, k, alone(b, k).run(), 0);
      }
    }
  }
}

// Every bad input: one message for the block, that names the entry, its value and what is allowed.
struct BadInput {
  const char* name;
  void (*spoil)(Block&);
  std::vector<std::string> words;
  friend void PrintTo(const BadInput& b, std::ostream* out) { *out << b.name; }
};

class VumatBadInput : public testing::TestWithParam<BadInput> {};

TEST_P(VumatBadInput, IsNamed) {
  samples::Random r(67);
  for (Number time : {Number(0), Number(1)}) {  // in the data check as well
    Block b = random_block(r, 7);
    b.step_time = b.total_time = time;
    b.props = {16, 4, 0.5, 2, Number(1.1), Number(1.01), 1, 0, 0, 0, 0};
    GetParam().spoil(b);
    const std::string text = run_and_listen(b);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    EXPECT_NE(text.find("myogrowth VUMAT: "), std::string::npos) << text;
    for (const auto& word : GetParam().words)
      EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
    for (Number x : b.stress) EXPECT_TRUE(std::isnan(x));
    EXPECT_EQ(b.state, b.state_old);
    for (Number x : b.intern) EXPECT_TRUE(std::isnan(x));
    EXPECT_EQ(b.inelas, b.inelas_old);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Inputs, VumatBadInput,
    testing::Values(
        BadInput{"c1", [](Block& b) { b.props[0] = -3; }, {"PROPS(1) = -3", "c1", "> -2/3 c2"}},
        BadInput{"c2", [](Block& b) { b.props[1] = inf; }, {"PROPS(2) = inf", "c2", "finite"}},
        BadInput{"tau", [](Block& b) { b.props[2] = Number(-0.1); }, {"PROPS(3) = -0.1:", "tau", "> 0"}},
        BadInput{"gamma", [](Block& b) { b.props[3] = -1; }, {"PROPS(4) = -1", "gamma", ">= 0"}},
        BadInput{"G_max", [](Block& b) { b.props[4] = Number(0.9); }, {"PROPS(5) = 0.9:", "G_max", "> 1"}},
        BadInput{"lambda_crit", [](Block& b) { b.props[5] = nan; }, {"PROPS(6) = nan", "lambda_crit", "> 0"}},
        BadInput{"n0_nan", [](Block& b) { b.props[7] = nan; }, {"PROPS(8) = nan", "n0_2", "finite"}},
        BadInput{"frame", [](Block& b) { b.props[9] = 2; }, {"PROPS(10) = 2", "frame", "0 or 1"}},
        BadInput{"energy", [](Block& b) { b.props[10] = 0.5; }, {"PROPS(11) = 0.5", "energy", "0 or 1"}},
        BadInput{"unknown",
                 [](Block& b) {
                   b.props.resize(19);
                   b.props[18] = 7;
                 },
                 {"PROPS(19) = 7", "must be 0"}},
        BadInput{"hybrid",
                 [](Block& b) {
                   b.props.resize(18);
                   b.props[17] = 1;
                 },
                 {"PROPS(18) = 1", "hybrid must be 0 for Abaqus/Explicit"}},
        BadInput{"nprops", [](Block& b) { b.props.resize(5); }, {"NPROPS = 5", "at least 6"}},
        BadInput{"nprops_0", [](Block& b) { b.props.clear(); }, {"NPROPS = 0", "at least 6"}},
        BadInput{
            "nstatev", [](Block& b) { b.nstatev = 0, b.state_old.clear(); }, {"NSTATEV = 0", "at least 1"}},
        BadInput{"plane_strain", [](Block& b) { b.nshr = 1; }, {"NDIR, NSHR = 3, 1", "3, 3 only"}},
        BadInput{
            "plane_stress", [](Block& b) { b.ndir = 2, b.nshr = 1; }, {"NDIR, NSHR = 2, 1", "3, 3 only"}}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(Vumat, AFibreIsNeededOnceTimeRuns) {
  Block b(7);
  b.props.insert(b.props.end(), {0, 0, 0});
  b.state_old[b.at(4, 6)] = 2;  // the one point that has one
  std::string text = run_and_listen(b);
  EXPECT_NE(text.find("PROPS(7:9) = 0, 0, 0"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  for (int k = 0; k < 7; ++k) EXPECT_EQ(b.is_nan(k), k != 4);
  EXPECT_EQ(b.state[b.at(4, 6)], 1);
}

TEST(Vumat, AnEmptyBlockIsNothingToDo) {
  Block b(0);
  EXPECT_EQ(run_and_listen(b), "");
}

TEST(Vumat, TwoThreadsGetTheSameAsOne) {
  samples::Random r(68);
  std::vector<Block> blocks, serial;
  for (int i = 0; i < 40; ++i) blocks.push_back(random_block(r, 136));
  serial = blocks;
  for (auto& b : serial) b.run();
  const auto every_second = [&](std::size_t first) {
    for (std::size_t i = first; i < blocks.size(); i += 2) blocks[i].run();
  };
  std::thread one(every_second, 0), two(every_second, 1);
  one.join();
  two.join();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    ASSERT_EQ(blocks[i].stress, serial[i].stress);
    ASSERT_EQ(blocks[i].state, serial[i].state);
  }
}

}  // namespace
