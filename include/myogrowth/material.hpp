/// @file
/// The C++ interface of myogrowth: update a material point, read the measures that your code works in.
///
///     myogrowth::FibreGrowth<> muscle;                        // the paper's Table 1: kPa, days
///     myogrowth::State<> state;                               // G = 1, fibre along x
///     auto step = myogrowth::update(muscle, F, state, dt);    // F: Eigen 3x3, at the end of the step
///     if (!step.ok()) ...                                     // step.status says why; nothing has changed
///     step.cauchy(); step.ddsdde(); step.first_piola(); step.dP_dF();
///     state = step.state;                                     // once the global step has converged
#ifndef MYOGROWTH_MATERIAL_HPP
#define MYOGROWTH_MATERIAL_HPP

#include "elastic/fibre_growth_of.hpp"
#include "kernel.hpp"
#include "tensor.hpp"
#include "version.hpp"

namespace myogrowth {

/// What a material point remembers from one time step to the next, and its fibre.
template <class T = double>
struct State {
  T G = T(1);                     ///< relative serial sarcomere number [-]
  T lambda = T(1);                ///< total fibre stretch, for the midpoint flow [-]
  Vec3<T> n0 = Vec3<T>::UnitX();  ///< fibre direction in the reference configuration, any length > 0 [-]
};

/// Result of an update. T as in FibreGrowth's formulas: a real number, complex, dual. Point: what
/// update_point of the material gives.
///
/// `status` is about the numbers of `point`, which are finite where it is ok. The measures below are made
/// from them when they are asked for, and can be beyond the range of T for an F that no muscle has: of
/// double, dS_dE() where a stretch is below about 1e-75, dP_dF() and second_piola() below 1e-150. Their
/// entries are then infinite or NaN. (The C API, and all that is built on it, calls that not finite.)
template <class T = double, class Point = PointUpdate<T>>
struct Update {
  State<T> state;  ///< at the end of the step; the state that came in if the update failed
  Mat3<T> F;       ///< the deformation gradient it was made for [-]
  Point point;     ///< the kernel's numbers: lambda, lambda_e, J, Je, psi, dG_dlambda, ...

  /// Whether there is a result, and why not.
  UpdateStatus status() const { return point.status; }
  /// Whether there is one.
  bool ok() const { return point.status == UpdateStatus::ok; }

  /// Kirchhoff stress tau = J sigma [stress].
  Mat3<T> kirchhoff() const { return from_six(six(point.tau)); }
  /// Modulus of its Jaumann rate, consistent with the discrete update (6x6; columns: engineering shear)
  /// [stress].
  Mat6<T> jaumann_modulus() const {
    Mat6<T> c;
    spatial_modulus(point, c.data());
    return c;
  }

  /// Cauchy stress [stress].
  Mat3<T> cauchy() const {
    Vec6<T> sigma;
    cauchy_from_kirchhoff(point.J, point.tau, sigma.data());
    return from_six(sigma);
  }
  /// Abaqus's DDSDDE, (1/J) d(J sigma) under the Jaumann rate [stress].
  Mat6<T> ddsdde() const {
    Mat6<T> d;
    spatial_modulus(point, d.data(), T(Real<T>(1) / point.J));
    return d;
  }
  /// First Piola-Kirchhoff stress P [stress].
  Mat3<T> first_piola() const {
    Mat3<T> P;
    first_piola_from_kirchhoff(F.data(), point.tau, P.data());
    return P;
  }
  /// dP_iJ/dF_kL at (i + 3J, k + 3L) [stress].
  Mat9<T> dP_dF() const {
    Mat9<T> A;
    dP_dF_from_jaumann(F.data(), point.tau, jaumann_modulus().data(), A.data());
    return A;
  }
  /// Second Piola-Kirchhoff stress S [stress].
  Mat3<T> second_piola() const {
    Vec6<T> S;
    second_piola_from_kirchhoff(F.data(), point.tau, S.data());
    return from_six(S);
  }
  /// dS/dE (6x6; columns: engineering shear 2E) [stress].
  Mat6<T> dS_dE() const {
    Mat6<T> D;
    dS_dE_from_jaumann(F.data(), point.tau, jaumann_modulus().data(), D.data());
    return D;
  }

 private:
  static Vec6<T> six(const T s[6]) { return Eigen::Map<const Vec6<T>>(s); }
};

namespace detail {

template <class Point, class Material, class T, class P, class... Activation>
Update<T, Point> make_update(const Material& material, const Mat3<T>& F, const State<T>& state, const P& dt,
                             const Activation&... activation) {
  Update<T, Point> result;
  result.F = F;
  result.state = state;
  update_point(material, result.F.data(), state.n0.data(), state.G, state.lambda, dt, result.point,
               activation...);
  if (result.ok()) {
    result.state.G = result.point.G;
    result.state.lambda = result.point.lambda;
  }
  return result;
}

}  // namespace detail

/// One step of length dt [time] to the deformation gradient F (3x3), from `state`, which is not changed.
/// F may be any Eigen expression. dt <= 0 is an elastic step. If the update fails, `status()` says why and
/// every stress is NaN.
template <class T, class P>
Update<T> update(const FibreGrowth<P>& material, const std::common_type_t<Mat3<T>>& F, const State<T>& state,
                 const std::common_type_t<P>& dt) {
  return detail::make_update<PointUpdate<T>>(material, F, state, P(dt));
}

/// The same with any elastic law. activation: a number from 0 to 1, constant over the step.
template <class T, class Elastic, class P>
Update<T, ElasticPointUpdate<T>> update(const FibreGrowthOf<Elastic, P>& material,
                                        const std::common_type_t<Mat3<T>>& F, const State<T>& state,
                                        const std::common_type_t<P>& dt,
                                        const std::common_type_t<T>& activation = T(Real<T>(0))) {
  return detail::make_update<ElasticPointUpdate<T>>(material, F, state, P(dt), activation);
}

}  // namespace myogrowth

#endif
