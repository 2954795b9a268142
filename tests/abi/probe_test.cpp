// The probe in hosts that behave and in hosts that misbehave, each in one way of its own: the verdict has to
// name that way and change in nothing else. The host is one element under uniform deformation, 8 points, with
// Newton's method on the two strains that are free. Each job runs in a process and a folder of its own, as
// jobs do.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "../support/umat_host.hpp"

namespace {

using Eigen::Matrix3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double unit = 250;  // PROPS(1)

/// F in fixed axes at whole times, as docs/probe.md prescribes it; F22 and F33 are free up to t = 2.
Matrix3d prescribed(int t) {
  Matrix3d F = Matrix3d::Identity();
  if (t == 1) F(0, 0) = 1 + 1e-4;
  if (t == 2) F(0, 0) = 1 - 1e-4;
  if (t <= 2) return F;
  F(2, 2) = 1 + 0.05 * (t - 2);
  const double share = t == 3 ? 0.5 : 1;
  F(0, 0) = 1 + 0.2 * share, F(0, 1) = 0.3 * share, F(1, 1) = 1 - 0.1 * share;
  const double degrees[] = {0, 10, 35, 45, 65, 70, 90};
  const double angle = t < 4 ? 0 : degrees[t - 4] * std::acos(-1.0) / 180;
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * F;
}

Matrix3d tensor(const Vector6d& v) {
  Matrix3d m;
  m << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  return m;
}
Vector6d components(const Matrix3d& m) {
  return (Vector6d() << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)).finished();
}
Matrix3d polar_rotation(const Matrix3d& F) {
  const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

struct Host {
  // What it does well, to be replaced by what it does badly.
  std::function<Matrix3d(const Matrix3d& F)> dfgrd1 = [](const Matrix3d& F) { return F; };
  std::function<Matrix6d(const Matrix6d&)> tangent = [](const Matrix6d& D) { return D; };
  /// STRESS handed over, from what is kept and the rotation of the increment.
  std::function<Matrix3d(const Matrix3d& kept, const Matrix3d& R)> before =
      [](const Matrix3d& s, const Matrix3d& R) { return Matrix3d(R * s * R.transpose()); };
  /// STRESS kept, from what came back, F and the rotation of the increment.
  std::function<Matrix3d(const Matrix3d&, const Matrix3d& F, const Matrix3d& R)> after =
      [](const Matrix3d& s, const Matrix3d&, const Matrix3d&) { return s; };
  double pnewdt = 1, first_state = 0;
  bool restores_state = true, keeps_state = true, imposes_at_once = false, time_of_end = false,
       strains = true, damps = false, cuts_back = false;
  double dtime_factor = 1;
  int ntens = 6, last = 10, n_points = 8;

  std::vector<std::vector<double>> converged_state, state;
  std::vector<Matrix3d> converged_stress, stress;
  double t_n = 0, dt = 1;
  Matrix3d F_n = Matrix3d::Identity();
  Vector6d strain_n = Vector6d::Zero(), strain = strain_n;

  void evaluate(const Matrix3d& F, Vector6d& sigma, Matrix6d& D) {
    const Matrix3d rate = 2 * (F - F_n) * (F + F_n).inverse(), W = (rate - rate.transpose()) / 2;
    const Matrix3d one = Matrix3d::Identity(), R = (one - W / 2).inverse() * (one + W / 2);
    Vector6d dstran = components((rate + rate.transpose()) / 2), stran = strain_n;
    dstran.tail<3>() *= 2;
    if (!strains) dstran.setZero(), stran.setZero();
    strain = stran + dstran;
    for (std::size_t point = 0; point < converged_state.size(); ++point) {
      Vector6d s = components(before(converged_stress[point], R));
      std::vector<double> statev = restores_state ? converged_state[point] : state[point];
      if (!keeps_state) statev.assign(statev.size(), 0.0);
      const Matrix3d M = dfgrd1(F);
      const int three = 3, nstatv = static_cast<int>(statev.size()), nprops = 1;
      const double time[2] = {time_of_end ? t_n + dt : t_n, time_of_end ? t_n + dt : t_n};
      const double dtime = dt * dtime_factor;
      double factor = pnewdt, out[20] = {};
      umat_(s.data(), statev.data(), D.data(), out, out + 1, out + 2, out + 3, out + 4, out + 10, out + 16,
            stran.data(), dstran.data(), time, &dtime, nullptr, nullptr, nullptr, nullptr, nullptr, &three,
            &three, &ntens, &nstatv, &unit, &nprops, nullptr, nullptr, &factor, nullptr, nullptr, M.data(),
            nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
      if (factor != pnewdt) _exit(2);
      sigma = s;
      stress[point] = after(tensor(s), F, R);
      state[point] = statev;
    }
    D = tangent(D);
  }

  void step(const Matrix3d& target, bool solve) {
    Vector6d sigma;
    Matrix6d D;
    Matrix3d F = imposes_at_once ? target : F_n;
    if (imposes_at_once && solve) F(1, 1) = F_n(1, 1), F(2, 2) = F_n(2, 2);
    for (int iteration = 0; iteration < 40; ++iteration) {
      evaluate(F, sigma, D);
      const Eigen::Vector2d force(sigma[1], sigma[2]);
      const double left = (target - F)(0, 0);
      if (solve) {
        if (left == 0 && force.norm() < 1e-9 * unit) break;
        const Eigen::Vector2d load = force + D.block<2, 1>(1, 0) * left;
        const Eigen::Vector2d d = -D.block<2, 2>(1, 1).inverse() * load * (damps ? 0.7 : 1.0);
        F(0, 0) = target(0, 0), F(1, 1) += d[0], F(2, 2) += d[1];
      } else {
        if ((target - F).norm() == 0) break;
        F = target;
      }
    }
    if (ntens != 6) return;
    t_n += dt, F_n = F, strain_n = strain, converged_state = state, converged_stress = stress;
  }

  void run() {
    const auto n = static_cast<std::size_t>(n_points);
    state = converged_state = std::vector<std::vector<double>>(n, std::vector<double>(4, first_state));
    stress = converged_stress = std::vector<Matrix3d>(n, Matrix3d::Zero());
    for (int t = 1; t <= last; ++t) {
      if (cuts_back && t > 4) {  // tries the whole, gives it up, takes two halves
        const Matrix3d half = (F_n + prescribed(t)) / 2;
        Vector6d sigma;
        Matrix6d D;
        evaluate(prescribed(t), sigma, D);
        dt = 0.5;
        state = converged_state;
        step(half, false);
        step(prescribed(t), false);
        dt = 1;
      } else {
        step(prescribed(t), t <= 2);
      }
    }
  }
};

using Lines = std::vector<std::string>;

/// The verdict's lines on the host, from the file that the probe left.
Lines verdict(Host host) {
  char folder[] = "/tmp/myogrowth_probe_XXXXXX";
  if (!mkdtemp(folder)) return {};
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(folder) != 0 || !std::freopen("stderr", "w", stderr)) _exit(1);
    host.run();
    std::exit(0);  // not _exit: ./run coverage would lose what this process has run
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  Lines lines;
  std::string line;
  const std::string path = folder;
  for (std::ifstream file(path + "/myogrowth_probe.txt"); std::getline(file, line);) {
    if (line[0] == '[' || line.rfind("           ", 0) == 0) lines.push_back(line);
  }
  // The same on standard error, once.
  std::size_t told = 0;
  for (std::ifstream file(path + "/stderr"); std::getline(file, line);) told += line[0] == '[';
  const bool ends = host.last == 10 || host.ntens != 6;
  EXPECT_EQ(told > 0, ends);
  for (const char* name : {"/myogrowth_probe.txt", "/stderr"}) unlink((path + name).c_str());
  rmdir(folder);
  return lines;
}

/// That the host's verdict is the good host's but for one line, which begins and goes on as said.
void expect_only(const Host& host, const std::string& mark, const std::string& name,
                 const std::string& words) {
  const Lines good = verdict(Host()), bad = verdict(host);
  ASSERT_EQ(good.size(), bad.size());
  int different = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    if (good[i] == bad[i]) continue;
    ++different;
    EXPECT_EQ(bad[i].rfind(mark, 0), 0u) << bad[i];
    EXPECT_EQ(bad[i].find(name), 11u) << bad[i];
    EXPECT_NE(bad[i].find(words), std::string::npos) << bad[i];
  }
  EXPECT_EQ(different, 1);
}

TEST(Probe, GoodHost) {
  Host at_once, one_point, cutting;
  at_once.imposes_at_once = true;
  one_point.n_points = 1;
  cutting.cuts_back = true;
  const Lines good = verdict(Host());
  EXPECT_EQ(good.size(), 11u);
  for (const auto& line : good) EXPECT_EQ(line.rfind("[ok]", 0), 0u) << line;
  EXPECT_EQ(verdict(at_once), good);
  EXPECT_EQ(verdict(one_point), good);
  EXPECT_EQ(verdict(cutting), good);
}

TEST(Probe, DeformationGradient) {
  Host host;
  host.dfgrd1 = [](const Matrix3d& F) { return Matrix3d(F.transpose()); };
  expect_only(host, "[WRONG]", "DFGRD1", "is transposed (row by row), in fixed axes");
  host.dfgrd1 = [](const Matrix3d& F) { return Matrix3d(polar_rotation(F).transpose() * F); };
  expect_only(host, "[ok]", "DFGRD1",
              "is R^T F, the right stretch: its basis turns with the material. PROPS(10) = 1");
  host.dfgrd1 = [](const Matrix3d& F) {
    return Matrix3d(polar_rotation(F).transpose() * F * polar_rotation(F));
  };
  expect_only(host, "[ok]", "DFGRD1", "is (RQ)^T F (RQ): its basis turns with the material. PROPS(10) = 1");
  host.dfgrd1 = [](const Matrix3d& F) {
    return Matrix3d(polar_rotation(F).transpose() * F.transpose() * polar_rotation(F));
  };
  expect_only(host, "[WRONG]", "DFGRD1", "is (RQ)^T F (RQ) transposed");
  const Matrix3d Q = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  host.dfgrd1 = [Q](const Matrix3d& F) { return Matrix3d(Q.transpose() * F * Q); };
  const Lines turned = verdict(host);
  EXPECT_EQ(turned[1],
            "[ok]       DFGRD1   is F in fixed axes turned by 22.92 degrees about axis 3. PROPS(10) = 0, n0 "
            "in these axes.");
  EXPECT_NE(turned[3].find("[?]        DDSDDE   cannot be told here"),
            std::string::npos);  // free in other axes
  host.dfgrd1 = [](const Matrix3d& F) {
    const Matrix3d more = Eigen::AngleAxisd(F(2, 2) - 1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return Matrix3d((polar_rotation(F) * more).transpose() * F);
  };
  expect_only(host, "[WRONG]", "DFGRD1", "is A^T F, where A turns but is not R");
  host.dfgrd1 = [](const Matrix3d& F) { return Matrix3d(F * F); };
  const Lines odd = verdict(host);
  EXPECT_NE(odd[1].find("[?]        DFGRD1   cannot be told here: it is no known form"), std::string::npos);
}

TEST(Probe, LocalBasisWithAnAngleOfItsOwn) {
  const Matrix3d Q = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Host host;
  host.dfgrd1 = [Q](const Matrix3d& F) {
    const Matrix3d A = polar_rotation(F) * Q;
    return Matrix3d(A.transpose() * F * A);
  };
  Lines lines = verdict(host);
  ASSERT_EQ(lines.size(), 12u);
  EXPECT_NE(lines[1].find("is (RQ)^T F (RQ): its basis"), std::string::npos);
  EXPECT_NE(lines[2].find("Against R it is turned by 22.92 degrees"), std::string::npos);
}

TEST(Probe, NoFiniteStrains) {
  for (double diagonal : {0.0, 1.0}) {
    Host host;
    host.dfgrd1 = [diagonal](const Matrix3d&) { return Matrix3d(diagonal * Matrix3d::Identity()); };
    const Lines lines = verdict(host);
    EXPECT_NE(lines[1].find("[WRONG]    DFGRD1   stays without deformation. Switch on NLGEOM"),
              std::string::npos);
    EXPECT_NE(lines[3].find("DDSDDE   is used as given"), std::string::npos);
  }
}

TEST(Probe, Stress) {
  const auto keep = [](const Matrix3d& s, const Matrix3d&) { return s; };
  Host host;
  host.before = keep;
  expect_only(host, "[ok]", "STRESS", "on entry is what was returned.");
  host.after = [](const Matrix3d& s, const Matrix3d&, const Matrix3d& R) {
    return Matrix3d(R * s * R.transpose());
  };
  expect_only(host, "[WRONG]", "STRESS", "is turned by the rotation of the increment after the call");
  host.after = [](const Matrix3d& s, const Matrix3d& F, const Matrix3d&) {
    return Matrix3d(F.determinant() * s);
  };
  expect_only(host, "[harmless]", "STRESS", "times what was returned");
  host.after = [](const Matrix3d& s, const Matrix3d& F, const Matrix3d&) {
    return Matrix3d(F.determinant() * F.inverse() * s * F.inverse().transpose());
  };
  expect_only(host, "[harmless]", "STRESS", "is second Piola-Kirchhoff stress");
  host.after = [](const Matrix3d& s, const Matrix3d& F, const Matrix3d&) {
    return Matrix3d(polar_rotation(F).transpose() * s * polar_rotation(F));
  };
  expect_only(host, "[WRONG]", "STRESS", "is R^T sigma R");
  for (double garbage : {0.0, 1e300, std::numeric_limits<double>::quiet_NaN(), 0.3}) {
    host.before = [garbage](const Matrix3d&, const Matrix3d&) {
      return Matrix3d(Matrix3d::Constant(garbage));
    };
    expect_only(host, "[harmless]", "STRESS", garbage == 0 ? "is zero" : "(garbage)");
  }
}

TEST(Probe, Tangent) {
  const struct {
    const char* words;
    Matrix6d (*use)(const Matrix6d&);
  } uses[] = {
      {"is used transposed", [](const Matrix6d& D) { return Matrix6d(D.transpose()); }},
      {"is used symmetrised", [](const Matrix6d& D) { return Matrix6d((D + D.transpose()) / 2); }},
      {"upper triangle", [](const Matrix6d& D) { return Matrix6d(D.selfadjointView<Eigen::Upper>()); }},
      {"lower triangle", [](const Matrix6d& D) { return Matrix6d(D.selfadjointView<Eigen::Lower>()); }}};
  for (const auto& u : uses) {
    for (bool at_once : {false, true}) {
      Host host;
      host.tangent = u.use;
      host.imposes_at_once = at_once;
      expect_only(host, "[WRONG]", "DDSDDE", u.words);
    }
  }
  Host damped;
  damped.damps = true;
  expect_only(damped, "[?]", "DDSDDE", "no Newton step with it explains");
}

TEST(Probe, State) {
  Host host;
  host.restores_state = false;
  expect_only(host, "[WRONG]", "STATEV", "is that of the last call");
  host = Host();
  host.keeps_state = false;
  expect_only(host, "[WRONG]", "STATEV", "is lost between calls");
  host = Host();
  host.first_state = 3.5;
  expect_only(host, "[WRONG]", "STATEV", "is 3.5 at first");
}

TEST(Probe, TimesAndFactors) {
  Host host;
  host.pnewdt = std::numeric_limits<double>::max();
  expect_only(host, "[harmless]", "PNEWDT", "is huge on entry");
  host.pnewdt = -1;
  expect_only(host, "[WRONG]", "PNEWDT", "is -1 on entry");
  host = Host();
  host.time_of_end = true;
  expect_only(host, "[harmless]", "TIME", "is that of the end of the increment");
  host = Host();
  host.dtime_factor = 60;
  const Lines lines = verdict(host);
  EXPECT_NE(lines[8].find("DTIME    is not the length of the increment"), std::string::npos);
}

TEST(Probe, NoStrains) {
  Host host;
  host.strains = false;
  const Lines good = verdict(Host()), lines = verdict(host);
  ASSERT_EQ(lines.size(), 11u);
  EXPECT_EQ(Lines(lines.begin(), lines.begin() + 9), Lines(good.begin(), good.begin() + 9));
  EXPECT_EQ(lines[9], "[harmless] DSTRAN   is zero. The UMAT does not read it.");
  EXPECT_EQ(lines[10], "[?]        ORDER    of the components: cannot be told here.");
}

TEST(Probe, NotASolid) {
  Host host;
  host.ntens = 4;
  const Lines lines = verdict(host);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("the probe needs a solid element"), std::string::npos);
}

// Where the report cannot be written, that is said, once; the verdict is on standard error all the same.
TEST(Probe, ReportThatCannotBeWritten) {
  char folder[] = "/tmp/myogrowth_probe_XXXXXX";
  ASSERT_TRUE(mkdtemp(folder));
  const std::string path = folder;
  ASSERT_EQ(mkdir((path + "/myogrowth_probe.txt").c_str(), 0700), 0);  // the name is taken by a folder
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(folder) != 0 || !std::freopen("stderr", "w", stderr)) _exit(1);
    Host().run();
    std::exit(0);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  std::string line;
  std::size_t told = 0, judged = 0;
  for (std::ifstream file(path + "/stderr"); std::getline(file, line);) {
    told += line ==
            "myogrowth probe: myogrowth_probe.txt cannot be written in the host's folder: Is a directory.";
    judged += line[0] == '[';
  }
  EXPECT_EQ(told, 1u);
  EXPECT_EQ(judged, 11u);
  rmdir((path + "/myogrowth_probe.txt").c_str());
  unlink((path + "/stderr").c_str());
  rmdir(folder);
}

TEST(Probe, JobThatEndsEarly) {
  Host host;
  host.last = 2;
  const Lines lines = verdict(host);
  EXPECT_NE(lines[1].find("[?]        DFGRD1   cannot be told here"), std::string::npos);
  EXPECT_NE(lines[3].find("[ok]       DDSDDE   is used as given"), std::string::npos);
}

}  // namespace
