// The matrix of PETSc, with GAMG: smoothed aggregation that knows the rigid-body modes.
#include <petscksp.h>

#include <array>

#include "element.hpp"
#include "linear_system.hpp"

namespace muscle {
namespace {

using namespace dealii;

void petsc(PetscErrorCode code) { AssertThrow(code == 0, ExcMessage("PETSc error " + std::to_string(code))); }

class PetscSystem : public LinearSystem {
 public:
  explicit PetscSystem(const Unknowns& unknowns)
      : unknowns_(unknowns), partitioner_(unknowns.owned, unknowns.relevant, unknowns.comm) {
    const auto n = static_cast<PetscInt>(unknowns.owned.n_elements());
    petsc(MatCreate(unknowns.comm, &matrix_));
    petsc(MatSetSizes(matrix_, n, n, PETSC_DETERMINE, PETSC_DETERMINE));
    petsc(MatSetType(matrix_, MATAIJ));
    petsc(MatSetBlockSize(matrix_, 3));
    // The rows are allocated from what the cells bring: a first assembly of zeros, kept as the pattern.
    petsc(MatMPIAIJSetPreallocation(matrix_, 3 * most_neighbours, nullptr, 3 * most_neighbours, nullptr));
    petsc(MatSeqAIJSetPreallocation(matrix_, 3 * most_neighbours, nullptr));
    petsc(MatSetOption(matrix_, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
    const std::vector<double> zeros(9 * most_nodes * most_nodes, 0.0);
    for (std::size_t c = 0; c < unknowns.cell_nodes.size(); ++c) add(c, zeros.data());
    finish();
    petsc(MatSetOption(matrix_, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));

    Vec places;
    petsc(MatCreateVecs(matrix_, &places, nullptr));
    petsc(VecSetBlockSize(places, 3));
    double* x;
    petsc(VecGetArray(places, &x));
    for (std::size_t k = 0; k < unknowns.places.size(); ++k) {
      for (unsigned i = 0; i < 3; ++i) x[3 * k + i] = unknowns.places[k][i];
    }
    petsc(VecRestoreArray(places, &x));
    MatNullSpace modes;
    petsc(MatNullSpaceCreateRigidBody(places, &modes));
    petsc(MatSetNearNullSpace(matrix_, modes));
    petsc(MatNullSpaceDestroy(&modes));
    petsc(VecDestroy(&places));
    petsc(MatCreateVecs(matrix_, &x_, &b_));

    petsc(KSPCreate(unknowns.comm, &ksp_));
    petsc(KSPSetType(ksp_, KSPGMRES));
    petsc(KSPGMRESSetRestart(ksp_, 100));
    petsc(KSPSetPCSide(ksp_, PC_RIGHT));
    petsc(KSPSetNormType(ksp_, KSP_NORM_UNPRECONDITIONED));
    PC pc;
    petsc(KSPGetPC(ksp_, &pc));
    petsc(PCSetType(pc, PCGAMG));
    petsc(PetscOptionsSetValue(nullptr, "-mg_levels_ksp_max_it", "3"));
    petsc(PetscOptionsSetValue(nullptr, "-pc_gamg_threshold", "0"));
    petsc(PetscOptionsSetValue(nullptr, "-pc_gamg_coarse_eq_limit", "1000"));
    petsc(KSPSetFromOptions(ksp_));
  }

  ~PetscSystem() override {
    KSPDestroy(&ksp_);
    VecDestroy(&x_);
    VecDestroy(&b_);
    MatDestroy(&matrix_);
  }

  void clear() override { petsc(MatZeroEntries(matrix_)); }

  void add(std::size_t cell, const double* K) override {
    const std::vector<unsigned>& nodes = unknowns_.cell_nodes[cell];
    std::array<PetscInt, most_nodes> blocks;
    for (std::size_t a = 0; a < nodes.size(); ++a)
      blocks[a] = static_cast<PetscInt>(partitioner_.local_to_global(nodes[a]) / 3);
    const auto n = static_cast<PetscInt>(nodes.size());
    petsc(MatSetValuesBlocked(matrix_, n, blocks.data(), n, blocks.data(), K, ADD_VALUES));
  }

  void add_by_dealii(const AffineConstraints<double>&, const FullMatrix<double>&,
                     const dealii::Vector<double>&, const std::vector<types::global_dof_index>&,
                     Vector&) override {
    AssertThrow(false, ExcMessage("the dense loop is for ML"));
  }

  void finish() override {
    petsc(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
    petsc(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
  }

  void set_up() override {
    petsc(KSPSetReusePreconditioner(ksp_, PETSC_FALSE));
    petsc(KSPSetOperators(ksp_, matrix_, matrix_));
    petsc(KSPSetUp(ksp_));
    petsc(KSPSetReusePreconditioner(ksp_, PETSC_TRUE));
  }

  int solve(const Vector& rhs, Vector& x, double tolerance) override {
    double* values;
    petsc(VecGetArray(b_, &values));
    std::copy(rhs.begin(), rhs.end(), values);
    petsc(VecRestoreArray(b_, &values));
    petsc(KSPSetTolerances(ksp_, tolerance, 0, PETSC_DEFAULT, 500));
    petsc(KSPSolve(ksp_, b_, x_));
    const double* solution;
    petsc(VecGetArrayRead(x_, &solution));
    std::copy(solution, solution + x.locally_owned_size(), x.begin());
    petsc(VecRestoreArrayRead(x_, &solution));
    KSPConvergedReason reason;
    petsc(KSPGetConvergedReason(ksp_, &reason));
    PetscInt iterations;
    petsc(KSPGetIterationNumber(ksp_, &iterations));
    return reason > 0 ? static_cast<int>(iterations) : -1;
  }

 private:
  static constexpr PetscInt most_neighbours =
      27;  // of a node of a swept mesh of hexahedra; more are allocated as they come

  const Unknowns& unknowns_;
  const Utilities::MPI::Partitioner partitioner_;
  Mat matrix_;
  Vec x_, b_;
  KSP ksp_;
};

}  // namespace

std::unique_ptr<LinearSystem> petsc_system(const Unknowns& unknowns) {
  return std::make_unique<PetscSystem>(unknowns);
}

}  // namespace muscle
