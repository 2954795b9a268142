/// @file
/// Muscle fibres and a tendon in series: growth of the fibres by eq. 4, a tendon that is elastic and creeps.
///
///   length   lambda + r (nu - 1) = Lambda          in lengths of the fibres at rest; r: the tendon's
///   tendon   nu = nu_c exp(P/E),   dnu_c/dt = nu_c <P>/eta
///   force    P = P(lambda, G), the library's uniaxial stress with the exact flow at the stretch of mid-step
///
/// A step solves for the stretch lambda of the fibres at its end. The creep is taken by the trapezoidal rule,
/// so the step is of second order. P grows with lambda, growth included, and nu with P: the length grows with
/// lambda from below -r to infinity, so there is exactly one lambda for any length and any step.
#ifndef MYOGROWTH_EXAMPLES_MUSCLE_TENDON_HPP
#define MYOGROWTH_EXAMPLES_MUSCLE_TENDON_HPP

#include <cmath>
#include <myogrowth/more/stress_states.hpp>

namespace study {

/// A tendon in series with the fibres.
struct Tendon {
  double length = 0;     ///< r, at rest [lengths of the fibres]; 0: there is none
  double stiffness = 0;  ///< E, force per reference area of the fibres over logarithmic stretch [stress]
  double viscosity = 0;  ///< eta [stress time]; 0: it does not creep
};

/// Both at a point of time.
struct MuscleTendon {
  double G = 1, stretch = 1, lateral = 1;  ///< of the fibres
  double creep = 1;                        ///< nu_c
  double force = 0;                        ///< P, per reference area of the fibres [stress]

  /// nu, the relative length of the tendon.
  double tendon(const Tendon& t) const { return t.length > 0 ? creep * std::exp(force / t.stiffness) : 1; }
};

namespace detail {

/// The fibres at the end of a step of dt, for their stretch there.
struct Fibres {
  const myogrowth::FibreGrowth<>& muscle;
  const MuscleTendon& before;
  double dt;
  double lateral;                    // also the start of the next search
  myogrowth::PointUpdate<double> u;  // of the last evaluation
  double dforce;                     // dP/dln(stretch)

  myogrowth::UpdateStatus evaluate(double stretch) {
    double slope;
    const auto status = uniaxial_stress(muscle, stretch, before.G, before.stretch, dt, lateral, u, slope);
    if (status == myogrowth::UpdateStatus::ok) dforce = (slope - u.tau[0]) / stretch;
    return status;
  }
  double force(double stretch) const { return u.tau[0] / stretch; }
  MuscleTendon after(double stretch, double creep) const {
    return {u.G, stretch, lateral, creep, force(stretch)};
  }
};

/// nu_c after a step at whose end the force is P, and its derivative with respect to P.
inline double creep_of(const Tendon& t, const MuscleTendon& before, double dt, double P, double* derivative) {
  const double per = t.viscosity > 0 && dt > 0 ? dt / (2 * t.viscosity) : 0;
  const double creep = before.creep * std::exp(per * (std::fmax(before.force, 0) + std::fmax(P, 0)));
  if (derivative) *derivative = P > 0 ? creep * per : 0;
  return creep;
}

}  // namespace detail

/// One step of dt >= 0 to a length Lambda; `now` is left as it is if there is no result.
inline myogrowth::UpdateStatus step_to_length(const myogrowth::FibreGrowth<>& muscle, const Tendon& t,
                                              double length, double dt, MuscleTendon& now) {
  detail::Fibres fibres{muscle, now, dt, now.lateral, {}, 0};
  if (!(t.length > 0)) {  // the length is the stretch
    const auto status = fibres.evaluate(length);
    if (status == myogrowth::UpdateStatus::ok) now = fibres.after(length, now.creep);
    return status;
  }
  double x = now.stretch, creep = now.creep;
  const auto status = myogrowth::detail::free_stretch(x, [&](double stretch, double& more, double& slope) {
    const auto made = fibres.evaluate(stretch);
    const double P = fibres.force(stretch);
    double dcreep;
    creep = detail::creep_of(t, now, dt, P, &dcreep);
    const double elastic = std::exp(P / t.stiffness);
    more = stretch + t.length * (creep * elastic - 1) - length;
    slope = stretch + t.length * elastic * (dcreep + creep / t.stiffness) * fibres.dforce;
    return made;
  });
  if (status == myogrowth::UpdateStatus::ok) now = fibres.after(x, creep);
  return status;
}

/// One step of dt >= 0 to a force P [stress]; `now` is left as it is if there is no result.
inline myogrowth::UpdateStatus step_to_force(const myogrowth::FibreGrowth<>& muscle, const Tendon& t,
                                             double P, double dt, MuscleTendon& now) {
  detail::Fibres fibres{muscle, now, dt, now.lateral, {}, 0};
  double x = now.stretch;
  const auto status = myogrowth::detail::free_stretch(x, [&](double stretch, double& more, double& slope) {
    const auto made = fibres.evaluate(stretch);
    more = fibres.force(stretch) - P;
    slope = fibres.dforce;
    return made;
  });
  if (status == myogrowth::UpdateStatus::ok) now = fibres.after(x, detail::creep_of(t, now, dt, P, nullptr));
  return status;
}

/// Lambda, the length of both.
inline double length_of(const Tendon& t, const MuscleTendon& m) {
  return m.stretch + t.length * (m.tendon(t) - 1);
}

}  // namespace study

#endif
