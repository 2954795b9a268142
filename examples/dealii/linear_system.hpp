/// @file
/// The linear system of a Newton step: a matrix assembled from cells, and GMRES with algebraic multigrid for
/// it.
#ifndef MYOGROWTH_DEALII_LINEAR_SYSTEM_HPP
#define MYOGROWTH_DEALII_LINEAR_SYSTEM_HPP

#include <deal.II/base/index_set.h>
#include <deal.II/base/point.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/full_matrix.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <memory>
#include <vector>

namespace muscle {

using Vector = dealii::LinearAlgebra::distributed::Vector<double>;

/// Where the unknowns are. The three of a node follow one another, x y z, and have one owner.
struct Unknowns {
  const dealii::DoFHandler<3>& dofs;
  MPI_Comm comm;
  dealii::IndexSet owned, relevant;
  std::vector<dealii::Point<3>> places;  ///< of the owned nodes
  std::vector<std::vector<unsigned>>
      cell_nodes;  ///< local index of the first unknown of each node, owned ones first
};

class LinearSystem {
 public:
  virtual ~LinearSystem() = default;
  /// Sets the matrix to zero.
  virtual void clear() = 0;
  /// Adds the matrix of a cell, row by row, (3 nodes) x (3 nodes); supported nodes are dealt with already.
  virtual void add(std::size_t cell, const double* K) = 0;
  /// The same as deal.II does it, with its treatment of constraints, and the cell's right side.
  virtual void add_by_dealii(const dealii::AffineConstraints<double>& constraints,
                             const dealii::FullMatrix<double>& K, const dealii::Vector<double>& r,
                             const std::vector<dealii::types::global_dof_index>& indices, Vector& rhs) = 0;
  /// All cells are there.
  virtual void finish() = 0;
  /// Makes the preconditioner for the matrix as it is.
  virtual void set_up() = 0;
  /// Returns the number of iterations to |rhs - K x| <= tolerance |rhs|, or -1 if it is not reached in 500.
  virtual int solve(const Vector& rhs, Vector& x, double tolerance) = 0;
};

std::unique_ptr<LinearSystem> trilinos_system(const Unknowns& unknowns);
std::unique_ptr<LinearSystem> petsc_system(const Unknowns& unknowns);

/// Six rigid-body modes of the owned nodes, mode after mode, about the origin.
std::vector<std::vector<double>> rigid_body_modes(const std::vector<dealii::Point<3>>& places);

}  // namespace muscle

#endif
