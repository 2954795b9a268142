/// @file
/// The distributed mesh and the fibre field.
#ifndef MYOGROWTH_DEALII_MESH_HPP
#define MYOGROWTH_DEALII_MESH_HPP

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>
#include <deal.II/distributed/tria_base.h>

#include <functional>
#include <memory>

#include "mesh_file.hpp"
#include "parameters.hpp"

namespace muscle {

using Mesh = dealii::parallel::DistributedTriangulationBase<3>;

/// Cylinder and brick: hexahedra of a forest of octrees (p4est). A file's cells: parted by METIS on rank 0;
/// the number of a coarse cell is its place in the file.
std::unique_ptr<Mesh> make_mesh(const Parameters::Geometry& geometry, const MeshFile& file, MPI_Comm comm);

/// deal.II's vertex of the corner in CalculiX's order.
unsigned vertex(Shape shape, unsigned corner);

/// A number of its own for every cell, whatever the number of ranks.
std::uint64_t cell_key(const dealii::CellId& id);

/// The fibre direction at a place before the deformation, of any length > 0.
using FibreField = std::function<dealii::Tensor<1, 3>(const dealii::Point<3>&)>;
FibreField make_fibre_field(const Parameters::Fibre& fibre);

}  // namespace muscle

#endif
