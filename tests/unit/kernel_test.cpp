// The kernel compared with the readable definitions and with closed forms.
#include <gtest/gtest.h>
#include <myogrowth/elastic/neo_hookean.hpp>
#include <myogrowth/more/left_stretch.hpp>
#include <myogrowth/more/mixed_volume.hpp>

#include "../support/dual.hpp"
#include "../support/moduli.hpp"
#include "../support/samples.hpp"

using namespace myogrowth;
using Complex = std::complex<double>;
using samples::Kind;

namespace {

template <class A, class B>
double error(const Eigen::MatrixBase<A>& expected, const Eigen::MatrixBase<B>& x) {
  return (x - expected).norm() / (expected.norm() + 1e-300);
}

NeoHookean<> elastic(const FibreGrowth<>& m) { return {m.c1, m.c2}; }

TEST(Definitions, GrowthTensorAndItsInverse) {
  samples::Random r(1);
  const Vec3<double> n0 = samples::direction(r);
  EXPECT_LE((growth_tensor(n0, 1.3) * inverse_growth_tensor(n0, 1.3) - Mat3<double>::Identity()).norm(),
            1e-15);
  EXPECT_NEAR(growth_tensor(n0, 1.3).determinant(), 1.3, 1e-15);
  EXPECT_LE((growth_tensor(n0, 1.3) * n0 - 1.3 * n0).norm(), 1e-15);
}

// psi -> S_e -> L_e by complex steps, then tau = F S F^T.
TEST(Definitions, StressAndModulusAreDerivativesOfTheEnergy) {
  samples::Random r(2);
  const NeoHookean<> law{16, 4};
  const Mat3<double> F = samples::deformation(r, 0.3), Ce = right_cauchy_green(F);
  const double h = 1e-30;
  Mat3<double> S;
  Mat6<double> L;
  for (int a = 0; a < 6; ++a) {
    Mat3<Complex> C = Ce.cast<Complex>();
    const int i = symmetric_row(a), j = symmetric_column(a);
    C(i, j) += Complex(0, i == j ? h : h / 2);
    if (i != j) C(j, i) += Complex(0, h / 2);
    S(i, j) = S(j, i) = 2 * law.psi(C).imag() / h;
    L.col(a) = 2 * to_six(Mat3<double>(law.S(C).imag() / h));
  }
  EXPECT_LE(error(law.S(Ce), S), 1e-14);
  EXPECT_LE(error(law.L(Ce), L), 1e-14);
  EXPECT_LE(error(law.kirchhoff(left_cauchy_green(F)), F * law.S(Ce) * F.transpose()), 1e-14);
  const Mat6<double> c = moduli::jaumann_from_dS_dE(F, law.kirchhoff(left_cauchy_green(F)), law.L(Ce));
  EXPECT_LE(error(law.spatial_modulus(left_cauchy_green(F)), c), 1e-14);
}

TEST(Kernel, AgreesWithTheDefinitions) {
  samples::Random r(3);
  for (Kind kind : {Kind::growing, Kind::below_threshold, Kind::saturated, Kind::elastic_step}) {
    for (int i = 0; i < 200; ++i) {
      const samples::Point p = samples::point(r, kind);
      const auto u = update(p.muscle, p.F, p.state, p.dt);
      ASSERT_TRUE(u.ok());
      const Vec3<double> n0 = p.state.n0.normalized();
      const double G = u.state.G;
      const Mat3<double> Fe = elastic_part(p.F, n0, G), be = left_cauchy_green(Fe);
      const NeoHookean<> law = elastic(p.muscle);
      EXPECT_NEAR(u.point.Je / Fe.determinant(), 1, 1e-12);
      EXPECT_NEAR(u.point.lambda / fibre_stretch(Mat3<double>(p.F), n0), 1, 1e-14);
      EXPECT_NEAR(u.point.lambda_e, u.point.lambda / G, 1e-14);
      EXPECT_NEAR(u.point.psi / law.psi(right_cauchy_green(Fe)), 1, 1e-11);
      EXPECT_LE(error(law.kirchhoff(be), u.kirchhoff()), 1e-12);
      EXPECT_LE(error(second_piola(law, p.F, n0, G), u.second_piola()), 1e-12);
      EXPECT_LE(error(moduli::consistent_modulus(law, p.F, n0, G, u.point.dG_dlambda), u.dS_dE()), 1e-12);
      if (kind != Kind::growing) {
        EXPECT_LE(error(law.spatial_modulus(be), u.jaumann_modulus()), 1e-12);
      }
    }
  }
}

// The elastic law without growth, in the kernel's accurate forms, written a second time.
TEST(Kernel, WithoutGrowthItIsTheElasticLawBitForBit) {
  samples::Random r(4);
  for (int sample = 0; sample < 1000; ++sample) {
    samples::Point p = samples::point(r, Kind::below_threshold);
    p.state.G = 1;
    p.muscle.growth.lambda_crit = 100;
    const Mat3<double> H = p.F - Mat3<double>::Identity();
    const double minor = H(1, 1) * H(2, 2) - H(1, 2) * H(2, 1);
    const double J_minus_1 =
        (H(0, 0) + H(1, 1) + H(2, 2)) +
        (H(0, 0) * H(1, 1) - H(0, 1) * H(1, 0) + H(0, 0) * H(2, 2) - H(0, 2) * H(2, 0) + minor) +
        (H(0, 0) * minor - H(0, 1) * (H(1, 0) * H(2, 2) - H(1, 2) * H(2, 0)) +
         H(0, 2) * (H(1, 0) * H(2, 1) - H(1, 1) * H(2, 0)));
    const double pressure = p.muscle.c1 * ln_1_plus(J_minus_1, J_minus_1, 1.0);
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    for (int a = 0; a < 6; ++a) {
      const int i = symmetric_row(a), j = symmetric_column(a);
      const double b_minus_I =
          H(i, j) + H(j, i) + (H(i, 0) * H(j, 0) + H(i, 1) * H(j, 1) + H(i, 2) * H(j, 2));
      EXPECT_EQ(u.point.tau[a], (i == j ? pressure : 0) + p.muscle.c2 * b_minus_I);
    }
    EXPECT_EQ(u.point.Je, u.point.J);
    EXPECT_EQ(u.point.lambda_e, u.point.lambda);
    samples::Point grown = p;
    grown.muscle.energy = EnergyPer::grown_volume;  // the two conventions agree at G = 1
    EXPECT_EQ(update(grown.muscle, p.F, p.state, p.dt).kirchhoff(), u.kirchhoff());
    EXPECT_EQ(update(grown.muscle, p.F, p.state, p.dt).ddsdde(), u.ddsdde());
  }
}

// Where the square of the fibre stretch is below all numbers, the stretch still has its digits.
TEST(Kernel, FibreStretchWhoseSquareIsBelowTheRange) {
  samples::Random r(41);
  for (const double size : {1e-150, 1e-160, 1e-200, 1e-290}) {
    State<> state;
    state.n0 = Vec3<double>::UnitX();
    const Mat3<double> F = samples::rotation(r) * Vec3<double>(size, 2, 1e100).asDiagonal();
    const auto u = update(FibreGrowth<>(), F, state, 0.1);
    ASSERT_TRUE(u.ok()) << size;
    EXPECT_NEAR(u.point.lambda / size, 1, 1e-15);
    EXPECT_EQ(u.point.lambda_e, u.point.lambda);
    EXPECT_EQ(u.state.lambda, u.point.lambda);
  }
}

TEST(Kernel, FreeGrowthIsStressFreeExactly) {
  samples::Random r(5);
  for (int i = 0; i < 1000; ++i) {  // to the last bit along an axis, where F = F_g holds G without rounding
    const double G = i == 0 ? 1.0 : r.uniform(1, 2);
    for (int axis = 0; axis < 3; ++axis) {
      Mat3<double> F = Mat3<double>::Identity();
      F(axis, axis) = G;
      State<> state;
      state.G = G;
      state.n0 = Vec3<double>::Unit(axis);
      const auto u = update(FibreGrowth<>{}, F, state, 1);
      EXPECT_EQ(u.kirchhoff(), (Mat3<double>::Zero())) << G;
      EXPECT_EQ(u.point.psi, 0);
      EXPECT_EQ(u.state.G, G);
    }
  }
  for (int i = 0; i < 100; ++i) {  // and to rounding for any fibre and any rotation after it
    State<> state;
    state.n0 = samples::direction(r);
    state.G = r.uniform(1, 1.1);
    const Mat3<double> F = samples::rotation(r) * growth_tensor(state.n0, state.G);
    EXPECT_LE(update(FibreGrowth<>{}, F, state, 0).kirchhoff().norm(), 1e-13);  // of stiffnesses of 16
  }
}

TEST(Kernel, ObjectiveUnderRotation) {
  samples::Random r(6);
  for (int i = 0; i < 300; ++i) {
    const samples::Point p = samples::point(r, Kind::any);
    const Mat3<double> Q = samples::rotation(r);
    const auto u = update(p.muscle, p.F, p.state, p.dt), v = update(p.muscle, Q * p.F, p.state, p.dt);
    EXPECT_NEAR(v.state.G, u.state.G, 1e-13);
    EXPECT_LE(error(Q * u.cauchy() * Q.transpose(), v.cauchy()), 1e-11);
    EXPECT_LE(error(u.second_piola(), v.second_piola()), 1e-11);
    EXPECT_LE(error(moduli::push_forward(Q, u.ddsdde()), v.ddsdde()), 1e-11);
    EXPECT_LE(error(u.dS_dE(), v.dS_dE()), 1e-11);
  }
}

TEST(Kernel, SenseAndLengthOfTheFibreDoNotMatter) {
  samples::Random r(7);
  for (int i = 0; i < 200; ++i) {
    samples::Point p = samples::point(r, Kind::any);
    p.state.n0.normalize();
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    State<> other = p.state;
    other.n0 = -p.state.n0;
    EXPECT_EQ(update(p.muscle, p.F, other, p.dt).ddsdde(), u.ddsdde());
    for (double length : {1e-200, 1e-3, 7.0, 1e200}) {
      other.n0 = length * p.state.n0;
      const auto v = update(p.muscle, p.F, other, p.dt);
      EXPECT_NEAR(v.state.G, u.state.G, 1e-14);
      EXPECT_LE(error(u.kirchhoff(), v.kirchhoff()), 1e-13);
    }
  }
}

TEST(Kernel, NormaliseIsIdempotent) {
  samples::Random r(8);
  for (int i = 0; i < 10000; ++i) {
    const Vec3<double> n = samples::direction(r) * r.log_uniform(1e-30, 1e30);
    double once[3], twice[3];
    ASSERT_TRUE(normalise(n.data(), once));
    ASSERT_TRUE(normalise(once, twice));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(once[k], twice[k]);
    EXPECT_NEAR(once[0] * once[0] + once[1] * once[1] + once[2] * once[2], 1, 1e-15);
  }
}

TEST(Kernel, RefusesWhatItCannotTakeAndSaysWhy) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const FibreGrowth<> muscle;
  const Mat3<double> I = Mat3<double>::Identity();
  const auto expect = [&](UpdateStatus status, const Mat3<double>& F, const State<>& state, double dt) {
    const auto u = update(muscle, F, state, dt);
    EXPECT_EQ(u.status(), status);
    EXPECT_FALSE(u.ok());
    EXPECT_TRUE(std::isnan(u.kirchhoff()(0, 0)));
    EXPECT_TRUE(std::isnan(u.ddsdde()(3, 3)));
    EXPECT_TRUE(u.state.G == state.G || std::isnan(state.G));
  };
  Mat3<double> F = I;
  F(2, 2) = -1;
  expect(UpdateStatus::inverted, F, {}, 1);
  F(2, 2) = 0;
  expect(UpdateStatus::inverted, F, {}, 1);
  F(2, 2) = nan;
  expect(UpdateStatus::not_finite, F, {}, 1);
  F(2, 2) = inf;
  expect(UpdateStatus::not_finite, F, {}, 1);
  expect(UpdateStatus::not_finite, 1e200 * I, {}, 1);  // beyond the range of double
  expect(UpdateStatus::inverted, 1e-200 * I, {}, 1);
  State<> state;
  state.G = nan;
  expect(UpdateStatus::not_finite, I, state, 1);
  for (double G : {0.0, -1.0}) {
    state.G = G;
    expect(UpdateStatus::bad_state, I, state, 1);
  }
  state = {};
  state.n0 = {0, 0, 0};
  expect(UpdateStatus::no_fibre, I, state, 1);
  state.n0 = {0, nan, 1};
  expect(UpdateStatus::not_finite, I, state, 1);
  expect(UpdateStatus::not_finite, I, {}, nan);
}

// Small strains keep their digits: the stress compared with its series in H = F - I.
TEST(Kernel, AccurateAtSmallStrain) {
  const FibreGrowth<> m;
  for (double e : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
    Mat3<double> F = Mat3<double>::Identity();
    F(0, 0) += e;
    F(0, 1) += e / 2;
    F(2, 2) -= e / 3;
    // exact from the rounded entries, in long double by the plain product form
    const long double a = static_cast<long double>(F(0, 0)) - 1, s = F(0, 1),
                      c = static_cast<long double>(F(2, 2)) - 1;
    const long double ln_J = log1pl(a + c + a * c);
    const Mat3<double> tau = update(m, F, State<>{}, 0).kirchhoff();
    const auto relative = [](double x, long double y) { return std::abs(static_cast<double>(x / y - 1)); };
    EXPECT_LE(relative(tau(0, 0), 16 * ln_J + 4 * (2 * a + a * a + s * s)), 1e-15) << e;
    EXPECT_LE(relative(tau(1, 1), 16 * ln_J), 1e-15) << e;
    EXPECT_LE(relative(tau(2, 2), 16 * ln_J + 4 * (2 * c + c * c)), 1e-14)
        << e;  // the two terms nearly cancel
    EXPECT_LE(relative(tau(0, 1), 4 * s), 1e-15) << e;
  }
}

template <class T>
class Scalars : public testing::Test {};
using ScalarTypes = testing::Types<double, float, long double, Complex, dual::Dual>;
TYPED_TEST_SUITE(Scalars, ScalarTypes, );

// One template for every scalar type: growth, stress and tangents as for double, to the rounding of the type.
TYPED_TEST(Scalars, GiveTheSameUpdate) {
  using T = TypeParam;
  using V = Real<T>;
  const double tolerance =
      400 * std::max<double>(static_cast<double>(std::numeric_limits<V>::epsilon()), 1e-15);
  samples::Random r(9);
  for (int i = 0; i < 100; ++i) {
    const samples::Point p = samples::point(r, Kind::growing, 10);
    const auto u = update(p.muscle, p.F, p.state, p.dt);
    const auto& g = p.muscle.growth;
    FibreGrowth<V> m;
    m.c1 = static_cast<V>(p.muscle.c1);
    m.c2 = static_cast<V>(p.muscle.c2);
    m.growth = {static_cast<V>(g.tau), static_cast<V>(g.gamma), static_cast<V>(g.G_max),
                static_cast<V>(g.lambda_crit)};
    State<T> state;
    state.G = T(static_cast<V>(p.state.G));
    Mat3<T> F;
    for (int k = 0; k < 9; ++k) F(k) = T(static_cast<V>(p.F(k)));
    for (int k = 0; k < 3; ++k) state.n0[k] = T(static_cast<V>(p.state.n0[k]));
    const Update<T> v = update(m, F, state, static_cast<V>(p.dt));
    ASSERT_TRUE(v.ok());
    EXPECT_NEAR(static_cast<double>(value(v.state.G)), u.state.G, tolerance);
    const auto compare = [&](const auto& expected, const auto& x) {
      const double size = expected.norm();
      for (int k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(static_cast<double>(value(x(k))), expected(k), tolerance * size);
      }
    };
    compare(u.cauchy(), v.cauchy());
    compare(u.ddsdde(), v.ddsdde());
    compare(u.dP_dF(), v.dP_dF());
    compare(u.dS_dE(), v.dS_dE());
  }
}

}  // namespace

// Singular by its digits, for numbers whose products and differences all round; det F from F - I is 2e-16 to
// 1 for them.
TEST(Kernel, ASingularDeformationIsInvertedWhateverRounds) {
  samples::Random r(21);
  for (int i = 0; i < 20000; ++i) {
    const double size = r.log_uniform(1e-6, 1e9);
    Mat3<double> F;
    for (int k = 0; k < 6; ++k) F(k) = size * r.uniform(-1, 1);
    const double a = r.uniform(-2, 2), b = r.chance(0.3) ? 0 : r.uniform(-2, 2);
    F.col(2) = a * F.col(0) + b * F.col(1);
    if (r.chance(0.5)) F.transposeInPlace();
    if (r.chance(0.3)) F.col(2).swap(F.col(0));
    EXPECT_EQ(update(FibreGrowth<>(), F, State<>(), 0.1).status(), UpdateStatus::inverted) << F;
    double V[9], c[36];
    EXPECT_FALSE(left_stretch(F.data(), V));
    PointUpdate<double> u;
    MixedVolume<double> volume;
    const double n0[3] = {1, 0, 0};
    EXPECT_EQ(update_mixed(FibreGrowth<>(), F.data(), n0, 1., 1., 0.1, 1., u, c, volume),
              UpdateStatus::inverted);
  }
  for (double unit : {1.0, 0.1, 1e8, 1e-3}) {
    Mat3<double> F;
    F << 1, 2, 3, 4, 5, 6, 7, 8, 9;
    EXPECT_EQ(update(FibreGrowth<>(), Mat3<double>(unit * F), State<>(), 0.1).status(),
              UpdateStatus::inverted)
        << unit;
  }
}

TEST(Kernel, ASmallVolumeThatIsExactKeepsItsDigits) {
  const FibreGrowth<> m;
  for (double x : {1e-1, 1e-2, 1e-5, 1e-15, 1e-60}) {
    const Mat3<double> F = Eigen::Vector3d(1, x, 1).asDiagonal();
    const auto u = update(m, F, State<>(), 0.1);
    ASSERT_TRUE(u.ok()) << x;
    EXPECT_NEAR(u.point.J / x, 1, 1e-15);
    EXPECT_NEAR(u.point.psi / (8 * std::log(x) * std::log(x) + 2 * (x * x - 1) - 4 * std::log(x)), 1, 1e-14)
        << x;
    const auto both = update(m, Mat3<double>(x * Mat3<double>::Identity()), State<>(), 0.1);
    ASSERT_TRUE(both.ok()) << x;
    EXPECT_NEAR(both.point.J / (x * x * x), 1, 1e-15);
    EXPECT_TRUE(both.dP_dF().allFinite()) << x;
  }
}

// By the digits that a type has: epsilon of a long double made of two doubles is no tolerance.
TEST(Kernel, TolerancesAreMadeOfDigits) {
  EXPECT_EQ(last_place<double>(), std::numeric_limits<double>::epsilon());
  EXPECT_EQ(last_place<float>(), std::numeric_limits<float>::epsilon());
  EXPECT_EQ(last_place<long double>(), std::ldexp(1.0L, 1 - std::numeric_limits<long double>::digits));
}
