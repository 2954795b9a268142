/// @file
/// Stress and modulus of a law that is given by its energy only, by the library's own derivatives.
///
///     struct Mine {
///       template <class T>
///       T psi(const T Fe[9], const T n0[3], const T& activation) const;   // [stress]
///     };
///
/// With D_j the symmetric unit strain of component j, psi((I + t D_j)(I + s D_i) F_e) has the derivatives
/// tau_j with respect to t and c_ji with respect to both. Hyper-dual numbers (Fike and Alonso 2011) carry
/// them: exact to rounding, at 21 evaluations of the energy. That is slow, and good for trying a law out.
/// They have + - * / (also +=), sqrt, exp, expm1, log, log1p and pow with a number as exponent.
#ifndef MYOGROWTH_ELASTIC_FROM_ENERGY_HPP
#define MYOGROWTH_ELASTIC_FROM_ENERGY_HPP

#include "response.hpp"

namespace myogrowth {

/// A number with its derivatives in s, in t, and in both.
template <class T>
struct HyperDual {
  T v;   ///< value
  T s;   ///< d/ds
  T t;   ///< d/dt
  T st;  ///< d^2/dsdt

  HyperDual() = default;
  /// A constant.
  HyperDual(const Real<T>& constant) : v(constant), s(Real<T>(0)), t(s), st(s) {}  // NOLINT: as numbers do
  /// A number with derivatives.
  HyperDual(const T& v_, const T& s_, const T& t_, const T& st_) : v(v_), s(s_), t(t_), st(st_) {}
};

/// The number that decides.
template <class T>
Real<T> value(const HyperDual<T>& x) {
  return value(x.v);
}

/// @cond
template <class T>
HyperDual<T> operator+(const HyperDual<T>& a, const HyperDual<T>& b) {
  return {a.v + b.v, a.s + b.s, a.t + b.t, a.st + b.st};
}
template <class T>
HyperDual<T> operator-(const HyperDual<T>& a, const HyperDual<T>& b) {
  return {a.v - b.v, a.s - b.s, a.t - b.t, a.st - b.st};
}
template <class T>
HyperDual<T> operator-(const HyperDual<T>& a) {
  return {-a.v, -a.s, -a.t, -a.st};
}
template <class T>
HyperDual<T> operator*(const HyperDual<T>& a, const HyperDual<T>& b) {
  return {a.v * b.v, a.s * b.v + a.v * b.s, a.t * b.v + a.v * b.t,
          a.st * b.v + a.s * b.t + a.t * b.s + a.v * b.st};
}
namespace detail {
/// f(x) of a function with value f and derivatives df and ddf.
template <class T>
HyperDual<T> chain(const HyperDual<T>& x, const T& f, const T& df, const T& ddf) {
  return {f, df * x.s, df * x.t, df * x.st + ddf * x.s * x.t};
}
}  // namespace detail
template <class T>
HyperDual<T> operator/(const HyperDual<T>& a, const HyperDual<T>& b) {
  const T r = Real<T>(1) / b.v, dr = -r * r;
  return a * detail::chain(b, r, dr, T(Real<T>(-2) * r * dr));
}
#define MYOGROWTH_WITH_REALS(op)                                      \
  template <class T>                                                  \
  HyperDual<T> operator op(const HyperDual<T>& a, const Real<T>& b) { \
    return a op HyperDual<T>(b);                                      \
  }                                                                   \
  template <class T>                                                  \
  HyperDual<T> operator op(const Real<T>& a, const HyperDual<T>& b) { \
    return HyperDual<T>(a) op b;                                      \
  }
MYOGROWTH_WITH_REALS(+)
MYOGROWTH_WITH_REALS(-)
MYOGROWTH_WITH_REALS(*)
MYOGROWTH_WITH_REALS(/)
#undef MYOGROWTH_WITH_REALS
#define MYOGROWTH_IN_PLACE(op)                                \
  template <class T, class B>                                 \
  HyperDual<T>& operator op##=(HyperDual<T>& a, const B& b) { \
    return a = a op b;                                        \
  }
MYOGROWTH_IN_PLACE(+)
MYOGROWTH_IN_PLACE(-)
MYOGROWTH_IN_PLACE(*)
MYOGROWTH_IN_PLACE(/)
#undef MYOGROWTH_IN_PLACE

template <class T>
HyperDual<T> sqrt(const HyperDual<T>& x) {
  const T f = sqrt(x.v), df = Real<T>(0.5) / f;
  return detail::chain(x, f, df, T(-df / (x.v + x.v)));
}
template <class T>
HyperDual<T> exp(const HyperDual<T>& x) {
  const T f = exp(x.v);
  return detail::chain(x, f, f, f);
}
template <class T>
HyperDual<T> expm1(const HyperDual<T>& x) {
  const T f = expm1(x.v), df = f + Real<T>(1);
  return detail::chain(x, f, df, df);
}
template <class T>
HyperDual<T> log(const HyperDual<T>& x) {
  const T df = Real<T>(1) / x.v;
  return detail::chain(x, T(log(x.v)), df, T(-df * df));
}
template <class T>
HyperDual<T> log1p(const HyperDual<T>& x) {
  const T df = Real<T>(1) / (Real<T>(1) + x.v);
  return detail::chain(x, T(log1p(x.v)), df, T(-df * df));
}
template <class T>
HyperDual<T> pow(const HyperDual<T>& x, const Real<T>& p) {
  const Real<T> one(1);
  return detail::chain(x, T(pow(x.v, p)), T(p * pow(x.v, p - one)),
                       T(p * (p - one) * pow(x.v, p - one - one)));
}
/// @endcond

/// psi, tau and c of a law with an energy psi.
template <class Law, class T>
void evaluate_energy(const Law& law, const T Fe[9], const T n0[3], const T& activation,
                     ElasticResponse<T>& out) {
  using V = Real<T>;
  using H = HyperDual<T>;
  const T zero(V(0));
  const auto unit_strain = [](int a, T(&D)[9]) {
    for (T& x : D) x = T(V(0));
    D[symmetric_row(a) + 3 * symmetric_column(a)] = D[symmetric_column(a) + 3 * symmetric_row(a)] =
        T(a < 3 ? V(1) : V(0.5));
  };
  const auto product = [](const T A[9], const T B[9], T(&AB)[9]) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        AB[i + 3 * j] = A[i] * B[3 * j] + A[i + 3] * B[3 * j + 1] + A[i + 6] * B[3 * j + 2];
    }
  };
  out.psi = zero;  // (the loops below set everything, which g++ does not see)
  H n[3];
  for (int i = 0; i < 3; ++i) n[i] = H(n0[i], zero, zero, zero);
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i <= j; ++i) {
      T Di[9], Dj[9], DiF[9], DjF[9], DjDiF[9];
      unit_strain(i, Di), unit_strain(j, Dj);
      product(Di, Fe, DiF), product(Dj, Fe, DjF), product(Dj, DiF, DjDiF);
      H F[9];
      for (int k = 0; k < 9; ++k) F[k] = H(Fe[k], DiF[k], DjF[k], DjDiF[k]);
      const H psi = law.psi(F, n, H(activation, zero, zero, zero));
      out.psi = psi.v;
      out.tau[j] = psi.t;
      out.c[j + 6 * i] = out.c[i + 6 * j] = psi.st;
    }
  }
}

namespace detail {

template <class Law, class T>
auto respond(const Law& law, const T* Fe, const T* n0, const T& activation, ElasticResponse<T>& out, int)
    -> decltype(law.evaluate(Fe, n0, activation, out)) {
  law.evaluate(Fe, n0, activation, out);
}
template <class Law, class T>
void respond(const Law& law, const T* Fe, const T* n0, const T& activation, ElasticResponse<T>& out, long) {
  evaluate_energy(law, Fe, n0, activation, out);
}

}  // namespace detail

/// The response of a law to F_e with the unit vector n0: its own evaluate() where it has one, else from
/// psi().
template <class Law, class T>
void evaluate(const Law& law, const T Fe[9], const T n0[3], const T& activation, ElasticResponse<T>& out) {
  detail::respond(law, Fe, n0, activation, out, 0);
}

}  // namespace myogrowth

#endif
