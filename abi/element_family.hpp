/// @file
/// Abaqus/Standard's element families: what they give of F, and what they take of stress and tangent.
#ifndef MYOGROWTH_ABI_ELEMENT_FAMILY_HPP
#define MYOGROWTH_ABI_ELEMENT_FAMILY_HPP

#include <myogrowth/more/mixed_volume.hpp>
#include <myogrowth/more/stress_states.hpp>

#include "point.hpp"

namespace myogrowth {
namespace abi {

/// True, and the text, if the numbers of stress components are not those of a family below.
inline bool find_family_fault(int ntens, int ndi, int nshr, Text& text) {
  if (ntens == 6 && ndi == 3 && nshr == 3) return false;
  if (nshr == 1 && ((ntens == 4 && ndi == 3) || (ntens == 3 && ndi == 2))) return false;
  const struct {
    int ndi, nshr;
    const char* name;
  } unsupported[] = {{1, 0, "trusses, and beams in a plane,"},
                     {1, 1, "beams in space, and cohesive elements in a plane,"},
                     {1, 2, "cohesive elements"},
                     {2, 0, "axisymmetric shells and membranes"},
                     {3, 0, "elements of one-dimensional generalised plane strain"}};
  for (const auto& family : unsupported) {
    if (ndi != family.ndi || nshr != family.nshr || ntens != ndi + nshr) continue;
    return tell(text,
                "NTENS = %d, NDI = %d, NSHR = %d: %s are not supported; NTENS must be 6 (solids), 4 (plane "
                "strain, axisymmetric) or 3 (plane stress, membranes, shells).",
                ntens, ndi, nshr, family.name);
  }
  if (ntens == 6 || ntens == 4 || ntens == 3) {
    return tell(text, "NTENS = %d, NDI = %d, NSHR = %d: NDI and NSHR must be %d and %d with this NTENS.",
                ntens, ndi, nshr, ntens == 3 ? 2 : 3, ntens == 6 ? 3 : 1);
  }
  return tell(text,
              "NTENS = %d: must be 6 (solids), 4 (plane strain, axisymmetric) or 3 (plane stress, membranes, "
              "shells).",
              ntens);
}

/// F[9] from DFGRD1 as far as the family gives it: F_33 is not given in plane stress.
MYOGROWTH_NOINLINE inline void take_deformation(const double* dfgrd1, int ntens, double F[9]) {
  const bool solid = ntens == 6;
  const bool given[9] = {true, true, solid, true, true, solid, solid, solid, ntens != 3};
  for (int i = 0; i < 9; ++i) F[i] = given[i] ? dfgrd1[i] : 0;
  const double* taken = or_identity(F);
  for (int i = 0; i < 9; ++i) F[i] = taken[i];
  if (ntens == 3) F[8] = 1;
}

/// What a time step is made from. Material: FibreGrowth, or FibreGrowthOf, with which functions below take
/// the activation last.
template <class Material = FibreGrowth<double>>
struct Step {
  const Material& material;
  const double* F;
  const Start& start;
  double dt;
};

/// The first n components of tau and of c, whose columns are `rows` long, times 1/J.
template <int n>
UpdateStatus pack(const double* tau, const double* c, int rows, double per_J, double* stress,
                  double* ddsdde) {
  for (int j = 0; j < n; ++j) {
    stress[j] = tau[j] * per_J;
    for (int i = 0; i < n; ++i) ddsdde[i + n * j] = c[i + rows * j] * per_J;
  }
  return are_finite(stress, n) && are_finite(ddsdde, n * n) ? UpdateStatus::ok : UpdateStatus::not_finite;
}

/// Solids, NTENS = 6.
template <class Material, class Point, class... Activation>
UpdateStatus update_solid(const Step<Material>& s, Point& u, double* stress, double* ddsdde,
                          const Activation&... a) {
  if (update_point(s.material, s.F, s.start.n0, s.start.G, s.start.lambda, s.dt, u, a...) != UpdateStatus::ok)
    return u.status;
  const double per_J = 1 / u.J;
  spatial_modulus(u, ddsdde, per_J);
  for (int i = 0; i < 6; ++i) stress[i] = u.tau[i] * per_J;
  // Whether all is finite, by the sum, which costs less than to look at each.
  const auto sum = [](const double* x) { return (x[0] + x[1] + x[2]) + (x[3] + x[4] + x[5]); };
  double all = sum(stress);
  for (int j = 0; j < 6; ++j) all += sum(ddsdde + 6 * j);
  if (is_finite(all) || (are_finite(stress, 6) && are_finite(ddsdde, 36))) return UpdateStatus::ok;
  return UpdateStatus::not_finite;
}

/// Plane strain and axisymmetric elements, NTENS = 4.
template <class Material, class Point, class... Activation>
UpdateStatus update_plane_strain(const Step<Material>& s, Point& u, double* stress, double* ddsdde,
                                 const Activation&... a) {
  if (update_point(s.material, s.F, s.start.n0, s.start.G, s.start.lambda, s.dt, u, a...) != UpdateStatus::ok)
    return u.status;
  double c[36];
  spatial_modulus(u, c, 1 / u.J);
  for (double& t : u.tau) t *= 1 / u.J;
  return pack<4>(u.tau, c, 6, 1, stress, ddsdde);
}

/// Plane stress, membranes and shells, NTENS = 3. thickness: in, a start for F_33; out, F_33.
template <class Material, class Point, class... Activation>
UpdateStatus update_plane_stress(const Step<Material>& s, double& thickness, Point& u, double* stress,
                                 double* ddsdde, const Activation&... a) {
  const double in_plane[4] = {s.F[0], s.F[1], s.F[3], s.F[4]};
  double c[9];
  plane_stress(s.material, in_plane, s.start.n0, s.start.G, s.start.lambda, s.dt, thickness, u, c, a...);
  if (u.status != UpdateStatus::ok) return u.status;
  const double plane[3] = {u.tau[0], u.tau[1], u.tau[3]};
  return pack<3>(plane, c, 3, 1 / u.J, stress, ddsdde);
}

/// Mixed solids and plane strain. STRESS goes on: after J^, which is given, K = J d2U/dJ^2 and dK/dJ^ are
/// returned.
template <class Material, class Point, class... Activation>
UpdateStatus update_mixed_element(const Step<Material>& s, int ntens, double* J_hat, Point& u, double* stress,
                                  double* ddsdde, const Activation&... a) {
  MixedVolume<double> volume{1, std::numeric_limits<double>::quiet_NaN()};
  double c[36];
  update_mixed(s.material, s.F, s.start.n0, s.start.G, s.start.lambda, s.dt, *J_hat, u, c, volume, a...);
  if (u.status != UpdateStatus::ok) return u.status;
  J_hat[1] = volume.K;
  J_hat[2] = mixed_dK_dJ(s.material, s.F, s.start.n0, s.start.G, s.start.lambda, s.dt, *J_hat, a...);
  if (!are_finite(J_hat + 1, 2)) return UpdateStatus::not_finite;
  return ntens == 6 ? pack<6>(u.tau, c, 6, 1 / volume.J, stress, ddsdde)
                    : pack<4>(u.tau, c, 6, 1 / volume.J, stress, ddsdde);
}

}  // namespace abi
}  // namespace myogrowth

#endif
