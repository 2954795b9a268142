// The calls that gave no result, in the files that MYOGROWTH_DUMP asks for. How many have been written is
// remembered by the process, so every test makes its calls in one of its own.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cfloat>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>

#include "../support/umat_host.hpp"

using host::Call;
namespace fs = std::filesystem;

namespace {

const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

class Dump : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "myogrowth_XXXXXX";
    ASSERT_NE(mkdtemp(&name[0]), nullptr);
    folder = name;
  }
  void TearDown() override { fs::remove_all(folder); }

  /// Starts a process, in the folder, with that value of the variable.
  pid_t start(const char* variable, const std::function<void()>& body) const {
    const pid_t child = fork();
    if (child != 0) return child;
    fs::current_path(folder);
    if (variable)
      setenv("MYOGROWTH_DUMP", variable, 1);
    else
      unsetenv("MYOGROWTH_DUMP");
    body();
    std::exit(HasFailure() ? 1 : 0);  // not _exit: ./run coverage would lose what this process has run
  }
  static void finish(pid_t child) {
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << "what was expected in the child process";
  }
  void in_child(const char* variable, const std::function<void()>& body) const {
    finish(start(variable, body));
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  std::string text(int number) const {
    std::ifstream file(folder / ("umat_" + std::to_string(number) + ".nml"));
    std::ostringstream all;
    all << file.rdbuf();
    return all.str();
  }

  fs::path folder;
};

Call inverted() {
  Call c;
  c.F(1, 1) = -0.2;
  return c;
}

Call with_bad_props() {
  Call c;
  c.props[4] = 0.9;
  return c;
}

/// The numbers that a file gives for a name.
std::vector<double> numbers(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string plain, line;
  while (std::getline(lines, line)) plain += line.substr(0, line.find('!')) + "\n";
  const std::size_t start = plain.find("\n  " + name + " =");
  if (start == std::string::npos) return {};
  const char* rest = plain.c_str() + start + name.size() + 5;
  std::vector<double> result;
  for (char* end = nullptr;; rest = end + std::strspn(end, " ,\n")) {
    const double x = std::strtod(rest, &end);
    if (end == rest) return result;
    result.push_back(x);
  }
}

/// NaN is NaN, whatever its bits are.
void expect_same(const std::vector<double>& a, const std::vector<double>& b, const char* name) {
  ASSERT_EQ(a.size(), b.size()) << name;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) && std::isnan(b[i])) continue;
    EXPECT_EQ(std::memcmp(&a[i], &b[i], sizeof(double)), 0)
        << name << " " << i << ": " << a[i] << ", " << b[i];
  }
}

void expect_call(const std::string& text, const Call& c) {
  expect_same(numbers(text, "ntens"), {double(c.ntens)}, "NTENS");
  expect_same(numbers(text, "ndi"), {double(c.n_direct())}, "NDI");
  expect_same(numbers(text, "nshr"), {double(c.n_shear())}, "NSHR");
  expect_same(numbers(text, "nprops"), {double(c.props.size())}, "NPROPS");
  expect_same(numbers(text, "nstatv"), {double(c.statev.size())}, "NSTATV");
  expect_same(numbers(text, "dtime"), {c.dtime}, "DTIME");
  expect_same(numbers(text, "pnewdt"), {c.pnewdt}, "PNEWDT");
  expect_same(numbers(text, "props"), c.props, "PROPS");
  expect_same(numbers(text, "statev"), c.statev, "STATEV");
  if (c.is_hybrid())
    expect_same(numbers(text, "jhat"), {c.J_hat}, "STRESS(NTENS+1)");
  else
    EXPECT_EQ(numbers(text, "jhat").size(), 0u);
  const Eigen::Matrix3d rows = c.F.transpose();
  expect_same(numbers(text, "dfgrd1"), std::vector<double>(rows.data(), rows.data() + 9), "DFGRD1");
}

struct Failure {
  const char* name;
  void (*spoil)(Call&);
  const char* fault;
  friend void PrintTo(const Failure& f, std::ostream* out) { *out << f.name; }
};

class DumpOf : public Dump, public testing::WithParamInterface<Failure> {};

TEST_P(DumpOf, IsTheCallBitForBit) {
  Call given;
  given.props = {16, 4, 0.1 + 0.2, 2, 1.1, 1.01, 1 / 3., -2 / 3., 2 / 3.};
  given.statev = {1.03, -1e-300, 5e-324, DBL_MAX, inf, 0.6, -0.0, 0.8, 0};
  given.F << 1.1, 0.1, 0.2, -0.3, 1 / 1.1, 0.4, 1e-17, 0.6, 1;
  given.dtime = 1 / 7.;
  given.pnewdt = 0.7;
  GetParam().spoil(given);

  std::string silent, message;
  const auto call = [&] {
    Call c = given;
    testing::internal::CaptureStderr();
    c.run();
    const std::string said = testing::internal::GetCapturedStderr();
    if (!said.empty()) {
      EXPECT_EQ(said, std::string("myogrowth UMAT: ") + GetParam().fault + "\n");
    }
    EXPECT_EQ(c.pnewdt, 0.25);
    expect_same(c.statev, given.statev, "STATEV");
    if (c.ntens > 0) {
      EXPECT_TRUE(std::isnan(c.stress[0]));
    }
  };
  in_child(nullptr, call);
  EXPECT_EQ(files(), 0u);
  in_child(".", call);  // the host sees no difference
  EXPECT_EQ(files(), 1u);
  const std::string written = text(1);
  expect_call(written, given);
  EXPECT_NE(written.find("\n  fault = \"" + std::string(GetParam().fault) + "\"\n"), std::string::npos)
      << written;
  EXPECT_NE(written.find("myogrowth_driver --replay umat_1.nml\n"), std::string::npos) << written;
}

constexpr const char *inverted_text = "inverted: det F must be > 0",
                     *not_finite_text = "not finite: F, dt or a result is NaN or beyond the range of double",
                     *either_text = "inverted or not finite: F must be finite and det F > 0",
                     *ntens_text =
                         "NTENS = 5: must be 6 (solids), 4 (plane strain, axisymmetric) or 3 (plane stress, "
                         "membranes, shells).";

INSTANTIATE_TEST_SUITE_P(
    Failures, DumpOf,
    testing::Values(
        Failure{"inverted", [](Call& c) { c.F.row(0) *= -1; }, inverted_text},
        Failure{"mixed_element",
                [](Call& c) {
                  c.props.resize(18);
                  c.props[17] = 1;
                  c.J_hat = -0.1 - 0.2;
                },
                inverted_text},
        Failure{"F_nan", [](Call& c) { c.F(0, 1) = nan; }, not_finite_text},
        Failure{"F_minus_inf", [](Call& c) { c.F(2, 0) = -inf; }, not_finite_text},
        Failure{"dtime_inf", [](Call& c) { c.dtime = inf; }, not_finite_text},
        Failure{"overflow",
                [](Call& c) {
                  c.props[0] = 1e308;
                  c.F(2, 2) = 0.5;
                },
                not_finite_text},
        Failure{"local_basis",
                [](Call& c) {
                  c.props.push_back(1);
                  c.F.col(1) *= -1;
                },
                either_text},
        Failure{"plane_stress",
                [](Call& c) {
                  c.ntens = 3;
                  c.F.row(0) *= -1;
                },
                inverted_text},
        Failure{"plane_strain",
                [](Call& c) {
                  c.ntens = 4;
                  c.F(2, 2) = -1;
                },
                inverted_text},
        Failure{"tau", [](Call& c) { c.props[2] = -0.1; },
                "PROPS(3) = -0.1: tau, time constant of growth, must be finite and > 0."},
        Failure{"no_props", [](Call& c) { c.props.clear(); },
                "NPROPS = 0: at least 6 constants are needed: c1, c2, tau, gamma, G_max, lambda_crit."},
        Failure{"G", [](Call& c) { c.statev[0] = -1; },
                "STATEV(1) = -1 on entry: G, the sarcomere number, must be > 0, or 0 where nothing is known "
                "yet."},
        Failure{"no_statev", [](Call& c) { c.statev.clear(); },
                "NSTATV = 0: at least 1 is needed, to remember G (9 keeps all)."},
        Failure{"family",
                [](Call& c) {
                  c.ntens = 3;
                  c.ndi = 3;
                  c.nshr = 0;
                },
                "NTENS = 3, NDI = 3, NSHR = 0: elements of one-dimensional generalised plane strain are not "
                "supported; NTENS must be 6 (solids), 4 (plane strain, axisymmetric) or 3 (plane stress, "
                "membranes, shells)."},
        Failure{"ntens", [](Call& c) { c.ntens = 5; }, ntens_text}),
    [](const auto& info) { return std::string(info.param.name); });

TEST_F(Dump, IsOffWithoutAName) {
  in_child("", [] { inverted().run(); });
  EXPECT_EQ(files(), 0u);
}

TEST_F(Dump, IsNotWrittenForAResult) {
  in_child(".", [] {
    for (int ntens : {6, 4, 3}) {
      Call c;
      c.ntens = ntens;
      c.F(0, 0) = 1.1;
      EXPECT_TRUE(std::isfinite(c.run().stress[0]));
    }
  });
  EXPECT_EQ(files(), 0u);
}

TEST_F(Dump, EndsAtTwentyAndKeepsWhatIsThere) {
  std::ofstream(folder / "umat_2.nml") << "from before";
  in_child(".", [] {
    for (int i = 0; i < 50; ++i) {
      Call c = inverted();
      c.dtime = i;
      c.run();
    }
  });
  EXPECT_EQ(files(), 21u);
  EXPECT_EQ(text(2), "from before");
  EXPECT_EQ(numbers(text(1), "dtime"), std::vector<double>{0});  // the first are the ones that are kept
  for (int i = 1; i < 20; ++i) EXPECT_EQ(numbers(text(i + 2), "dtime"), std::vector<double>{double(i)});
}

TEST_F(Dump, SharesAFolderWithOtherThreadsAndProcesses) {
  const auto four_threads = [] {
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([] {
        for (int i = 0; i < 20; ++i) inverted().run();
      });
    }
    for (std::thread& t : threads) t.join();
  };
  const pid_t one = start(".", four_threads), other = start(".", four_threads);
  finish(one);
  finish(other);
  EXPECT_EQ(files(), 40u);
  for (int i = 1; i <= 40; ++i) {
    expect_call(text(i), inverted());
    EXPECT_EQ(text(i).substr(text(i).size() - 2), "/\n");
  }
}

TEST_F(Dump, ListsAtMostAThousandEntries) {
  in_child(".", [] {
    Call c = inverted();
    c.statev.resize(1001);
    c.run();
  });
  EXPECT_EQ(numbers(text(1), "nstatv"), std::vector<double>{1001});
  EXPECT_EQ(numbers(text(1), "statev").size(), 1000u);
  EXPECT_NE(text(1).find("the first 1000 of them only"), std::string::npos);
}

TEST_F(Dump, SaysOnceThatItCannotWrite) {
  const std::string endless(2000, 'x');
  for (const char* name : {"nowhere", endless.c_str()}) {
    in_child(name, [name] {
      testing::internal::CaptureStderr();
      std::vector<std::thread> threads;
      for (int t = 0; t < 40; ++t) {
        threads.emplace_back([] {
          Call c = inverted();
          c.run();
          EXPECT_EQ(c.pnewdt, 0.25);
          EXPECT_EQ(c.statev, inverted().statev);
          EXPECT_TRUE(std::isnan(c.stress[0]));
        });
      }
      for (std::thread& t : threads) t.join();
      const std::string said = testing::internal::GetCapturedStderr();
      const std::string start =
          std::string("myogrowth UMAT: MYOGROWTH_DUMP = ") + name + ": umat_1.nml cannot be";
      EXPECT_EQ(said.compare(0, start.size(), start), 0) << said;
      EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    });
  }
  EXPECT_EQ(files(), 0u);
}

// As on a full disk: what was begun is not left behind.
TEST_F(Dump, SaysThatTheDiskIsFull) {
  in_child(".", [] {
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit usual, small;
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &usual), 0);
    small = usual;
    small.rlim_cur = 300;  // bytes
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    testing::internal::CaptureStderr();
    Call c = inverted();
    c.run();
    setrlimit(RLIMIT_FSIZE, &usual);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(said,
              "myogrowth UMAT: MYOGROWTH_DUMP = .: umat_1.nml cannot be written there: File too large.\n");
    EXPECT_EQ(c.pnewdt, 0.25);
  });
  EXPECT_EQ(files(), 0u);
}

TEST_F(Dump, TakesALongPath) {
  std::string name = std::string(200, 'a');
  for (int i = 0; i < 8; ++i) name += "/" + std::string(200, 'b');
  fs::create_directories(folder / name);
  in_child(name.c_str(), [] { inverted().run(); });
  EXPECT_TRUE(fs::exists(folder / name / "umat_1.nml"));
}

TEST_F(Dump, ComesBeforeTheMessage) {  // which may end the job
  in_child("nowhere", [] {
    testing::internal::CaptureStderr();
    with_bad_props().run();
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_LT(said.find("MYOGROWTH_DUMP"), said.find("PROPS(5) = 0.9")) << said;
    EXPECT_NE(said.find("PROPS(5) = 0.9"), std::string::npos) << said;
  });
}

}  // namespace
