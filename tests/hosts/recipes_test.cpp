// Mock hosts that call the UMAT as the sources of other codes do, and the recipes of docs/hosts.md: right
// with the recipe and, where it is instructive, wrong without it. What a host does is described in our own
// words, and its source is cited.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cfloat>
#include <cmath>
#include <cstring>

#include "../../examples/mfem/muscle_model.hpp"
#include "../support/larger.hpp"
#include "../support/samples.hpp"
#include "../support/umat_host.hpp"

namespace {

using Eigen::Matrix3d;
using Numbers = std::vector<double>;
using Six = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Table 1, and an oblique fibre.
const Numbers muscle = {16, 4, 0.5, 2, 1.1, 1.01, 0.6, 0.48, 0.64};

myogrowth::State<> at_rest() {
  myogrowth::State<> s;
  s.n0 = {0.6, 0.48, 0.64};
  return s;
}

Matrix3d rotation(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
}
Matrix3d rotation_of(const Matrix3d& F) {  // Higham's iteration
  Matrix3d R = F;
  for (int i = 0; i < 30; ++i) R = (R + R.inverse().transpose().eval()) / 2;
  return R;
}

// A path that stretches by 15 % and rotates by 10 degrees in each step.
Matrix3d on_path(int step) {
  Matrix3d F = Eigen::Vector3d(1 + 0.015 * step, 1 - 0.004 * step, 1 + 0.002 * step).asDiagonal();
  F(0, 1) = 0.01 * step;
  return rotation(0.175 * step) * F;
}

double difference(const Matrix3d& a, const Matrix3d& b) { return (a - b).norm() / b.norm(); }

constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

Matrix3d tensor(const double* six) {
  Matrix3d A;
  for (int a = 0; a < 6; ++a) A(row[a], column[a]) = A(column[a], row[a]) = six[a];
  return A;
}

// ---- MOOSE
// -------------------------------------------------------------------------------------------------
// modules/solid_mechanics/src/materials/abaqus/AbaqusUMATStress.C, without `orientation`: always
// three-dimensional; F is transposed to Fortran's order; STATEV starts at 0; PNEWDT comes in as DBL_MAX;
// DDSDDE is read row by row, so transposed (issue 22225); the stress is rotated by the increment's rotation
// afterwards, unless decomposition_method is HughesWinget; CMNAME comes without its hidden length.
struct Moose {
  bool hughes_winget = true;
  Numbers state = Numbers(8, 0.0);
  Matrix3d F_old = Matrix3d::Identity(), stress = Matrix3d::Zero();
  double jacobian[3][3][3][3];
  double material_timestep = 0;

  void compute(const Matrix3d& F, double dt) {
    host::Call c;  // as MOOSE calls it: NOEL and COORDS are passed, but with other values than in Abaqus
    c.props = muscle;
    c.statev = state;
    c.dtime = dt;
    c.pnewdt = DBL_MAX;
    const RowMajor3 turned_round = F.transpose();
    std::memcpy(c.F.data(), turned_round.data(), sizeof(double) * 9);
    const Matrix3d rotation_increment = rotation_of(F * F_old.inverse());
    const Matrix3d old =
        hughes_winget ? Matrix3d(rotation_increment * stress * rotation_increment.transpose()) : stress;
    for (int a = 0; a < 6; ++a) c.stress[a] = old(row[a], column[a]);
    c.ddsdde.setZero();
    c.run();
    state = c.statev;
    material_timestep = c.pnewdt * dt;
    stress = tensor(c.stress.data());
    const double* d = c.ddsdde.data();
    const auto place = [](int i, int j) { return i == j ? i : 2 + i + j; };
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l) jacobian[i][j][k][l] = d[6 * place(i, j) + place(k, l)];
        }
      }
    }
    if (!hughes_winget) stress = rotation_increment * stress * rotation_increment.transpose();
    F_old = F;
  }
};

TEST(Moose, TheStressIsRightWithHughesWingetAlone) {
  for (const bool hughes_winget : {true, false}) {
    Moose moose;
    moose.hughes_winget = hughes_winget;
    auto exact = at_rest();
    for (int step = 1; step <= 10; ++step) {
      moose.compute(on_path(step), 0.1);
      const auto u = myogrowth::update(myogrowth::FibreGrowth<>(), on_path(step), exact, 0.1);
      exact = u.state;
      EXPECT_EQ(moose.state[0], exact.G);  // from a STATEV of zeros
      if (hughes_winget) {
        EXPECT_LT(difference(moose.stress, u.cauchy()), 1e-14);
      } else {
        EXPECT_GT(difference(moose.stress, u.cauchy()), 0.02);  // rotated once more, by 10 degrees
      }
      EXPECT_EQ(moose.material_timestep, DBL_MAX * 0.1);  // no limit
    }
    EXPECT_GT(exact.G, 1.02);
  }
}

TEST(Moose, AStepThatCannotBeTakenLimitsTheNext) {
  Moose moose;
  Matrix3d F = Matrix3d::Identity();
  F(0, 0) = -1;
  moose.compute(F, 0.1);
  EXPECT_EQ(moose.material_timestep, 0.025);
  EXPECT_TRUE(std::isnan(moose.stress(0, 0)));  // so that the solve fails, whether the limit is read or not
  EXPECT_EQ(moose.state[0], 0);
}

// A point that is stretched along x with its other stresses free, solved by Newton's method with the Jacobian
// as the host reads it, or as it should. Returns the iterations; F: the solution, upper triangular, so that
// it is unique.
int free_sides(bool as_read, Matrix3d& F) {
  F = Matrix3d::Identity();
  F(0, 0) = 1.15;
  Moose moose;
  for (int iteration = 1; iteration <= 200; ++iteration) {
    moose.state.assign(8, 0.0);
    moose.compute(F, 0.2);
    const Matrix3d& sigma = moose.stress;
    const auto free_ones = [](const Matrix3d& A) {
      Eigen::Matrix<double, 5, 1> x;
      x << A(1, 1), A(2, 2), A(0, 1), A(0, 2), A(1, 2);
      return x;
    };
    if (free_ones(sigma).norm() < 1e-10) return iteration;
    Eigen::Matrix<double, 5, 5> K;
    const int unknown[5][2] = {{1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (int m = 0; m < 5; ++m) {
      Matrix3d L = Matrix3d::Zero();
      L(unknown[m][0], unknown[m][1]) = 1;
      const Matrix3d D = (L + L.transpose()) / 2, W = (L - L.transpose()) / 2;
      Matrix3d rate = W * sigma - sigma * W - sigma * D.trace();
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          for (int k = 0; k < 3; ++k) {
            for (int l = 0; l < 3; ++l) {
              rate(i, j) += (as_read ? moose.jacobian[i][j][k][l] : moose.jacobian[k][l][i][j]) * D(k, l);
            }
          }
        }
      }
      K.col(m) = free_ones(rate);
    }
    const Eigen::Matrix<double, 5, 1> d = -K.partialPivLu().solve(free_ones(sigma));
    Matrix3d L = Matrix3d::Zero();
    for (int m = 0; m < 5; ++m) L(unknown[m][0], unknown[m][1]) = d[m];
    F += L * F;
  }
  return 1000;
}

TEST(Moose, TheTransposedJacobianCostsIterationsAndNothingElse) {
  Matrix3d right, read;
  const int as_given = free_sides(false, right), as_read = free_sides(true, read);
  std::printf("Newton iterations: %d with DDSDDE, %d with its transpose\n", as_given, as_read);
  EXPECT_LE(as_given, 7);
  EXPECT_GT(as_read, as_given);
  EXPECT_LT(as_read, 100);
  EXPECT_LT(difference(right, read), 1e-9);
}

// ---- Elmer
// ------------------------------------------------------------------------------------------------
// ElasticSolve.F90, LocalMatrixWithUMAT: NTENS is 6, or 4 in two dimensions; there an axisymmetric F is
// r, theta, z, so its shears are 13 and 31, for which STRESS has no component; PNEWDT begins as 3 and is
// kept; if asked for, one call with F = I comes first, and STRESS must not change in it; every iteration
// begins with the state of the last step.
struct Elmer {
  int ntens;
  Numbers props, state = Numbers(8, 0.0);
  double pnewdt = 3;
  host::Call last;

  explicit Elmer(int ntens_, Numbers props_ = muscle) : ntens(ntens_), props(std::move(props_)) {
    iterate(Matrix3d::Identity(), 0.1);
    for (int i = 0; i < ntens; ++i) EXPECT_EQ(last.stress[i], 0);
    end_step();
  }
  void iterate(const Matrix3d& F, double dtime) {
    last = host::Call();
    last.props = props;
    last.statev = state;
    last.ntens = ntens;
    last.F = F;
    last.dtime = dtime;
    last.pnewdt = pnewdt;
    last.stress.setZero();
    last.run();
    pnewdt = last.pnewdt;
  }
  void end_step() { state = last.statev; }
};

TEST(Elmer, SolidsAndPlaneStrain) {
  for (const int ntens : {6, 4}) {
    Elmer elmer(ntens);
    auto exact = at_rest();
    for (int step = 1; step <= 10; ++step) {
      Matrix3d F = on_path(step);
      if (ntens == 4) {
        F = Matrix3d::Identity();
        F.topLeftCorner<2, 2>() << 1 + 0.02 * step, 0.01 * step, -0.03 * step, 1 - 0.004 * step;
      }
      elmer.iterate(Matrix3d(F + 0.01 * Matrix3d::Identity()), 0.1);
      elmer.iterate(F, 0.1);
      elmer.end_step();
      const auto u = myogrowth::update(myogrowth::FibreGrowth<>(), F, exact, 0.1);
      exact = u.state;
      EXPECT_EQ(elmer.state[0], exact.G);
      const Matrix3d sigma = u.cauchy();
      for (int a = 0; a < ntens; ++a)
        EXPECT_NEAR(elmer.last.stress[a], sigma(row[a], column[a]), 1e-14 * sigma.norm());
    }
    EXPECT_GT(exact.G, 1.005);
    EXPECT_EQ(elmer.pnewdt, 3);
  }
}

TEST(Elmer, AxisymmetricShearIsRefused) {
  const double hoop = 0.96, along = 1.1, shear = 0.05;
  for (const bool has_law : {false, true}) {
    for (const auto& [i, j] : {std::pair<int, int>{0, 2}, {2, 0}}) {
      Elmer elmer(4);
      if (has_law) {
        elmer.props.resize(19, 0.0);
        elmer.props[0] = elmer.props[1] = 0, elmer.props[18] = 2;
      }
      const Numbers before = elmer.state;
      Matrix3d F = Eigen::Vector3d(hoop, hoop, along).asDiagonal();  // r, theta, z
      F(i, j) = shear;
      testing::internal::CaptureStderr();
      elmer.iterate(F, 0.1);
      const std::string message = testing::internal::GetCapturedStderr();
      const char* told =
          i == 0 ? "DFGRD1(1,3) = 0.05, DFGRD1(3,1) = 0," : "DFGRD1(1,3) = 0, DFGRD1(3,1) = 0.05,";
      EXPECT_NE(message.find(told), std::string::npos) << message;
      EXPECT_NE(message.find("not r, theta, z as in Elmer's axisymmetric elements"), std::string::npos)
          << message;
      for (int a = 0; a < 4; ++a) EXPECT_TRUE(std::isnan(elmer.last.stress[a]));
      EXPECT_EQ(elmer.last.statev, before);
    }
  }
}

// Without shear nothing tells the orders apart, and nothing has to: r, theta, z may be named 1, 2, 3, with
// the fibre by the same names.
TEST(Elmer, AxisymmetryWithoutShear) {
  const double hoop = 0.96, along = 1.1;
  Elmer elmer(4, {16, 4, 0.5, 2, 1.1, 1.01, 0, 0, 1});
  elmer.iterate(Matrix3d(Eigen::Vector3d(hoop, hoop, along).asDiagonal()), 0.1);
  host::Call abaqus;
  abaqus.ntens = 4;
  abaqus.props = {16, 4, 0.5, 2, 1.1, 1.01, 0, 1, 0};
  abaqus.F = Eigen::Vector3d(hoop, along, hoop).asDiagonal();  // r, z, theta
  abaqus.run();
  EXPECT_GT(abaqus.statev[0], 1.005);
  EXPECT_EQ(elmer.last.statev[0], abaqus.statev[0]);
  EXPECT_EQ(elmer.last.stress[2], abaqus.stress[1]);
  EXPECT_EQ(elmer.last.stress[1], abaqus.stress[2]);
  EXPECT_EQ(elmer.last.stress[3], 0);
}

// What Abaqus passes with NTENS = 4: zeros in 13 and 31, to rounding, or, whatever is there, a shear in the
// 1-2 plane.
TEST(Elmer, AbaqusIsNotTakenForIt) {
  for (const double F_12 : {0.0, 0.1}) {
    for (const double F_13 : {0.0, 1e-16, -1e-18, 0.1}) {
      if (F_12 == 0 && F_13 > 1e-12) continue;
      host::Call c;
      c.ntens = 4;
      c.F(0, 1) = F_12, c.F(0, 2) = F_13;
      c.run();
      EXPECT_TRUE(std::isfinite(c.stress[0]));
      EXPECT_EQ(c.pnewdt, 1);
    }
  }
}

// ---- WARP3D
// ------------------------------------------------------------------------------------------------
// src/rstgp1.f, drive_umat_update: six more arguments; PROPS are 50 numbers, 0 where none is given; STATEV
// is set to zero in step 1; PNEWDT comes in as 1e6; only the symmetric part of the tangent is kept; the
// result is taken for the unrotated Cauchy stress R^T sigma R unless the third entry of umat_set_features is
// 1; SSE is summed up.
extern "C" {
using WarpUmat = void(double*, double*, double*, double*, double*, double*, double*, double*, double*,
                      double*, const double*, const double*, const double*, const double*, const double*,
                      const double*, const double*, const double*, const char*, const int*, const int*,
                      const int*, const int*, const double*, const int*, const double*, const double*,
                      double*, const double*, const double*, const double*, const int*, const int*,
                      const int*, const int*, const int*, const int*, const int*, const int*, const int*,
                      const int*, double*, const int*);
}

struct Warp3d {
  bool says_cauchy = true;
  Numbers props = muscle, state = Numbers(8, 0.0);
  Matrix3d unrotated = Matrix3d::Zero();  // the stress that it stores
  Matrix6 tangent;
  double work = 0, pnewdt = 0;

  void update(const Matrix3d& F, double dtime) {
    Numbers fifty = props, statev = state;
    fifty.resize(50, 0.0);
    statev.push_back(-999999.9);  // its guard value after the last entry
    Six stress = Six::Zero();
    Matrix6 ddsdde = Matrix6::Zero();
    double sse = 0, spd = 0, scd = 0, rpl = 0, drpldt = 0, six[6] = {}, out[6] = {}, shared[5] = {};
    const double zero[6] = {}, time[2] = {}, celent = 1;
    const Matrix3d one = Matrix3d::Identity();
    const int ndi = 3, nshr = 3, ntens = 6, nstatv = 8, nprops = 50, some = 1, n_shared = 5;
    pnewdt = 1e6;
    reinterpret_cast<WarpUmat*>(reinterpret_cast<void (*)()>(myogrowth_umat_))(
        stress.data(), statev.data(), ddsdde.data(), &sse, &spd, &scd, &rpl, six, out, &drpldt, zero, zero,
        time, &dtime, zero, zero, zero, zero, "UMAT-WRP", &ndi, &nshr, &ntens, &nstatv, fifty.data(), &nprops,
        zero, one.data(), &pnewdt, &celent, one.data(), F.data(), &some, &some, &some, &some, &some, &some,
        &some, &some, &some, &some, shared, &n_shared);
    EXPECT_EQ(statev[8], -999999.9);
    state.assign(statev.begin(), statev.begin() + 8);
    const Matrix3d R = rotation_of(F), given = tensor(stress.data());
    unrotated = says_cauchy ? Matrix3d(R.transpose() * given * R) : given;
    tangent = (ddsdde + ddsdde.transpose()) / 2;
    work += sse + spd + scd;
  }
  Matrix3d cauchy(const Matrix3d& F) const { return rotation_of(F) * unrotated * rotation_of(F).transpose(); }
};

TEST(Warp3d, TheStressIsRightIfItIsSaidToBeCauchys) {
  for (const bool says_cauchy : {true, false}) {
    Warp3d warp;
    warp.says_cauchy = says_cauchy;
    auto exact = at_rest();
    double work = 0;
    for (int step = 1; step <= 10; ++step) {
      const Matrix3d F = on_path(step);
      warp.update(F, 0.1);
      const auto u = myogrowth::update(myogrowth::FibreGrowth<>(), F, exact, 0.1);
      exact = u.state;
      work = u.point.psi;
      EXPECT_EQ(warp.state[0], exact.G);
      EXPECT_EQ(warp.pnewdt, 1e6);
      if (says_cauchy) {
        EXPECT_LT(difference(warp.cauchy(F), u.cauchy()), 1e-14);
      } else {
        EXPECT_GT(difference(warp.cauchy(F), u.cauchy()), 0.02);
      }
      const Matrix6 c = u.ddsdde();
      EXPECT_LT((warp.tangent - (c + c.transpose()) / 2).norm(), 1e-12 * c.norm());
    }
    EXPECT_GT(warp.work, 2 * work);  // its energies are sums of ours over the steps, without meaning
  }
}

TEST(Warp3d, AFibreThatIsNotGivenIsNamed) {
  Warp3d warp;
  warp.props.resize(6);  // with Abaqus the fibre would be along x
  testing::internal::CaptureStderr();
  warp.update(on_path(1), 0.1);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("PROPS(7:9) = 0, 0, 0: n0"), std::string::npos);
  EXPECT_EQ(warp.pnewdt, 0.25);
}

// ---- code_aster
// -------------------------------------------------------------------------------------------- bibfor,
// lc0050.F90 and umatPrepareStrain.F90 (RELATION='UMAT'): it passes strains and their increments, small or
// logarithmic; DFGRD0 and DFGRD1 are all zero.
TEST(CodeAster, ItsUmatHasNoDeformationToGive) {
  host::Call c;
  c.props = muscle;
  c.F.setZero();  // whatever the values of STRAN and DSTRAN
  c.dtime = 1;
  c.run();
  EXPECT_EQ(c.stress, Six::Zero());  // undeformed: no stress, no growth, no message
  EXPECT_EQ(c.statev[0], 1);
  EXPECT_EQ(c.pnewdt, 1);
}

// ---- MFEM
// --------------------------------------------------------------------------------------------------
// fem/hyperelastic.cpp, HyperelasticNLFIntegrator: F = x^T DS, residual DS P^T, unknowns component by
// component.
TEST(Mfem, TheGradientIsThatOfTheResidual) {
  samples::Random r(1);
  const int dof = 8;
  MuscleModel model(myogrowth::FibreGrowth<>(), 3, 5);
  model.dt = 0.3;
  mfem::ElementTransformation T;
  T.ElementNo = 2, T.point.index = 4;
  model.SetTransformation(T);
  model.state(2, 4).n0 = {0.6, 0.48, 0.64};
  mfem::DenseMatrix DS(dof, 3), x(dof, 3);
  for (int a = 0; a < dof; ++a) {
    for (int i = 0; i < 3; ++i) DS(a, i) = r.uniform(-1, 1);
  }
  const auto gradient = [&](const mfem::DenseMatrix& at) {
    mfem::DenseMatrix F(3, 3);
    for (int i = 0; i < 3; ++i) {
      for (int J = 0; J < 3; ++J) {
        F(i, J) = i == J ? 1.1 : 0;
        for (int a = 0; a < dof; ++a) F(i, J) += at(a, i) * DS(a, J);
      }
    }
    return F;
  };
  const auto residual = [&](const mfem::DenseMatrix& at) {
    mfem::DenseMatrix P(3, 3), R(dof, 3);
    model.EvalP(gradient(at), P);
    for (int a = 0; a < dof; ++a) {
      for (int i = 0; i < 3; ++i) {
        for (int J = 0; J < 3; ++J) R(a, i) += 0.7 * DS(a, J) * P(i, J);
      }
    }
    return R;
  };
  for (int a = 0; a < dof; ++a) {
    for (int i = 0; i < 3; ++i) x(a, i) = r.uniform(-0.02, 0.02);
  }
  mfem::DenseMatrix A(3 * dof, 3 * dof);
  model.AssembleH(gradient(x), DS, 0.7, A);
  double worst = 0, asymmetry = 0, size = 0;
  const double h = 1e-6;
  for (int b = 0; b < dof; ++b) {
    for (int l = 0; l < 3; ++l) {
      mfem::DenseMatrix less = x, more = x;
      less(b, l) -= h, more(b, l) += h;
      const mfem::DenseMatrix R0 = residual(less), R1 = residual(more);
      for (int a = 0; a < dof; ++a) {
        for (int k = 0; k < 3; ++k) {
          const double entry = A(a + k * dof, b + l * dof);
          worst = larger(worst, std::abs(entry - (R1(a, k) - R0(a, k)) / (2 * h)));
          asymmetry = std::max(asymmetry, std::abs(entry - A(b + l * dof, a + k * dof)));
          size = std::max(size, std::abs(entry));
        }
      }
    }
  }
  EXPECT_LT(worst, 1e-7 * size);
  EXPECT_GT(asymmetry, 1e-3 * size);

  // The end of the step, only for the point that was evaluated.
  mfem::DenseMatrix P(3, 3);
  model.EvalP(gradient(x), P);
  EXPECT_EQ(model.state(2, 4).G, 1);
  model.EndStep();
  EXPECT_GT(model.state(2, 4).G, 1.001);
  EXPECT_EQ(model.state(2, 3).G, 1);
}

}  // namespace
