/// @file
/// Residual and stiffness of hexahedra, wedges and tetrahedra that carry the law, on plain arrays: no
/// finite-element code.
///
/// Total Lagrangian, in the measures of the kernel. With g_a = F^-T grad N_a and B = c2 b_e = tau - shift I,
/// the compact tangent of many/batch.hpp leaves of w P:grad N_a and its derivative
///
///   R_a  = w tau g_a
///   K_ab = w { c1 g_a⊗g_b - shift g_b⊗g_a + (g_a.B g_b) I + weight (dtau/dG g_a)⊗f (f.g_b) }
///
/// that is, products of a few vectors of the element: nothing of size 9 x 9 or 6 x 6 is formed. The mean
/// dilatation (Simo, Taylor and Pister 1985; Bonet and Wood, ch. 8) evaluates the law at (J^/J)^(1/3) F,
/// where J^ is the ratio of the element's volumes, and its K has two more such products (element.cpp).
#ifndef MYOGROWTH_DEALII_ELEMENT_HPP
#define MYOGROWTH_DEALII_ELEMENT_HPP

#include <cstddef>
#include <vector>

#include "../../abi/elastic_laws.hpp"

namespace muscle {

/// The elements there are, with the nodes in CalculiX's order (C3D8, C3D6, C3D4 and C3D10) and its
/// integration points.
enum class Shape { hex, wedge, tet, tet10 };
constexpr Shape all_shapes[] = {Shape::hex, Shape::wedge, Shape::tet, Shape::tet10};
constexpr int n_nodes(Shape shape) {
  return shape == Shape::hex ? 8 : shape == Shape::wedge ? 6 : shape == Shape::tet ? 4 : 10;
}
constexpr int n_corners(Shape shape) { return shape == Shape::tet10 ? 4 : n_nodes(shape); }
constexpr int n_points(Shape shape) {
  return shape == Shape::hex ? 8 : shape == Shape::wedge ? 2 : shape == Shape::tet ? 1 : 4;
}
constexpr const char* name_of(Shape shape) {
  return shape == Shape::hex ? "hexahedron" : shape == Shape::wedge ? "wedge" : "tetrahedron";
}
constexpr int most_nodes = 10, most_points = 8;

/// The corners that the nodes 4 to 9 of a tetrahedron of second degree lie between.
constexpr int tet_edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// The volume ratio that the law sees at a point.
enum class Volume {
  pointwise,        ///< det F
  mean_dilatation,  ///< the element's, so that nearly incompressible muscle does not lock
};

/// Cells of one shape and one material; every array holds one cell after the other.
struct Cells {
  Shape shape;
  int n;
  const double* X;         ///< n x nodes x 3: places before the deformation [length]
  const double* u;         ///< n x nodes x 3: displacements [length]
  const double* n0;        ///< n x points x 3: fibres [-]
  const double* G_n;       ///< n x points: sarcomere numbers at the start of the step [-]
  const double* lambda_n;  ///< n x points: fibre stretches at the start of the step [-]
};

/// What comes of them, laid out alike. An array that is not wanted is nullptr.
struct Forces {
  double* residual;   ///< n x (nodes x 3) [force]
  double* stiffness;  ///< n x (nodes x 3) x (nodes x 3), row by row [force/length]
  double* scalars;    ///< 5 arrays of n x points: lambda_e, lambda, J, Je, psi
  double* G;          ///< n x points: sarcomere numbers at the end of the step [-]
};

/// The point at which the law had no result, or `point` = -1.
struct Failure {
  int cell = -1, point = -1;
  double F[9] = {};  ///< column by column, as the law saw it
};

/// Evaluates cells, in blocks that fit the first cache, with the law on the points of a block at once.
class Elements {
 public:
  /// `elastic`: the elastic law, its constants and the activation at the end of the step; none: eq. 3, which
  /// goes by its tangent of seven numbers. The other laws go by the 6 x 6 modulus, and so does eq. 3 with
  /// `full`: another way to the same numbers.
  Elements(const myogrowth::FibreGrowth<>& material, Volume volume,
           const myogrowth::abi::LawChoice& elastic = {}, bool full = false)
      : material_(material),
        volume_(volume),
        elastic_(elastic),
        full_(full || elastic.law != myogrowth::abi::Law::neo_hookean) {}

  /// One step of length dt [time]. Stops at the first point without a result.
  Failure evaluate(const Cells& cells, double dt, const Forces& out);

  /// CPU seconds that the law has taken of that.
  double law_seconds() const { return law_seconds_; }

 private:
  /// What the law gives at the points of a block; every array begins with a component's first point.
  struct PointArrays {
    double *sigma, *G, *modulus, *scalars;
  };
  std::ptrdiff_t update_points(const Cells& cells, std::ptrdiff_t start, std::ptrdiff_t count, double dt,
                               const double* F, bool tangent, const PointArrays& out);
  template <Shape shape, bool tangent>
  Failure block(const Cells& cells, int first, int n, double dt, const Forces& out);

  myogrowth::FibreGrowth<> material_;
  Volume volume_;
  myogrowth::abi::LawChoice elastic_;
  bool full_;
  double law_seconds_ = 0;
};

/// Places [length] and volumes [length^3] of the integration points of a cell, points x 3 and points.
void integration_points(Shape shape, const double* X, double* places, double* volumes);

/// Derivatives of the shape functions over X at the integration points, points x nodes x 3 [1/length].
void shape_gradients(Shape shape, const double* X, double* gradients);

}  // namespace muscle

#endif
