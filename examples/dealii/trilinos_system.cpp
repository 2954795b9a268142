// The matrix of Trilinos. ML is set up for elasticity: three equations a node, the rigid-body modes as near
// null space, no entry dropped, three Chebyshev sweeps (on the finest level our own, smoother.hpp); with
// deal.II's own settings GMRES takes eight times as many iterations.
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_sparsity_pattern.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#include <ml_MultiLevelPreconditioner.h>
#include <Teuchos_ParameterList.hpp>

#include "linear_system.hpp"
#include "smoother.hpp"

namespace muscle {

using namespace dealii;

std::vector<std::vector<double>> rigid_body_modes(const std::vector<Point<3>>& places) {
  std::vector<std::vector<double>> modes(6, std::vector<double>(3 * places.size(), 0.0));
  for (std::size_t k = 0; k < places.size(); ++k) {
    for (unsigned i = 0; i < 3; ++i) {
      const unsigned j = (i + 1) % 3;
      modes[i][3 * k + i] = 1;
      modes[3 + i][3 * k + i] = -places[k][j];
      modes[3 + i][3 * k + j] = places[k][i];
    }
  }
  return modes;
}

namespace {

constexpr int sweeps = 3;

/// ML calls it on the finest level; TrilinosSystem::set_up has put the smoother into `data`.
int smooth(ML_Smoother* ml, int, double* x, int, double* b) {
  static_cast<Smoother*>(ml->smoother->data)
      ->apply(ml->my_level->Amat->lambda_max, sweeps, ml->init_guess == ML_ZERO, b, x);
  return 0;
}

class TrilinosSystem : public LinearSystem {
 public:
  explicit TrilinosSystem(const Unknowns& unknowns)
      : unknowns_(unknowns),
        partitioner_(
            std::make_shared<Utilities::MPI::Partitioner>(unknowns.owned, unknowns.relevant, unknowns.comm)) {
    TrilinosWrappers::SparsityPattern pattern(unknowns.owned, unknowns.owned, unknowns.relevant,
                                              unknowns.comm);
    DoFTools::make_sparsity_pattern(unknowns.dofs, pattern, AffineConstraints<double>(), true,
                                    Utilities::MPI::this_mpi_process(unknowns.comm));
    pattern.compress();
    matrix_.reinit(pattern);
    find_places();
  }

  void clear() override { matrix_ = 0; }

  void add(std::size_t cell, const double* K) override {
    const std::vector<unsigned>& nodes = unknowns_.cell_nodes[cell];
    const std::size_t n = nodes.size(), first = first_place_[cell];
    for (std::size_t a = 0; a < n; ++a) {
      if (nodes[a] >= n_owned_) {
        add_to_other_rank(nodes, a, K);
        continue;
      }
      for (std::size_t i = 0; i < 3; ++i) {
        double* row = values_ + row_start_[nodes[a] + i];
        const double* from = K + (3 * a + i) * 3 * n;
        const std::uint16_t* place = place_.data() + first + 3 * n * a;
        for (std::size_t b = 0; b < 3 * n; ++b) row[place[b]] += from[b];
      }
    }
  }

  void add_by_dealii(const AffineConstraints<double>& constraints, const FullMatrix<double>& K,
                     const dealii::Vector<double>& r, const std::vector<types::global_dof_index>& indices,
                     Vector& rhs) override {
    constraints.distribute_local_to_global(K, r, indices, matrix_, rhs);
  }

  void finish() override {
    matrix_.compress(VectorOperation::add);
    smoother_->copy(values_);
  }

  void set_up() override {
    TrilinosWrappers::PreconditionAMG::AdditionalData data;
    data.elliptic = true;
    data.w_cycle = true;  // keeps the iterations from growing with the size
    data.smoother_sweeps = sweeps;
    data.aggregation_threshold = 0;
    Teuchos::ParameterList ml;
    std::unique_ptr<Epetra_MultiVector> unused;
    data.set_parameters(ml, unused, matrix_);
    const Epetra_Map& map = matrix_.trilinos_matrix().OperatorDomainMap();
    modes_ = std::make_unique<Epetra_MultiVector>(map, 6);
    const auto modes = rigid_body_modes(unknowns_.places);
    for (int m = 0; m < 6; ++m) {
      const std::vector<double>& mode = modes[static_cast<std::size_t>(m)];
      std::copy(mode.begin(), mode.end(), (*modes_)[m]);
    }
    ml.set("PDE equations", 3);
    ml.set("aggregation: threshold", 0.0);
    ml.set("smoother: type", "Chebyshev");
    ml.set("smoother: sweeps", sweeps);
    ml.set("smoother: type (level 0)", "user-defined");
    ml.set("smoother: user-defined function", &smooth);
    ml.set("null space: type", "pre-computed");
    ml.set("null space: dimension", 6);
    ml.set("null space: vectors", modes_->Values());
    ml.set("ML output", 0);
    amg_.initialize(matrix_, ml);
    const auto& made = dynamic_cast<const ML_Epetra::MultiLevelPreconditioner&>(amg_.trilinos_operator());
    const ML& levels = *made.GetML();
    for (ML_Smoother* on_levels : {levels.pre_smoother, levels.post_smoother}) {
      ML_SmootherFunc* finest = on_levels[levels.ML_finest_level].smoother;
      if (finest && finest->func_ptr == smooth) finest->data = smoother_.get();  // a few nodes have one level
    }
  }

  int solve(const Vector& rhs, Vector& x, double tolerance) override {
    ReductionControl control(500, 0, tolerance, false, false);
    SolverGMRES<Vector> gmres(control, SolverGMRES<Vector>::AdditionalData(102, true));
    x = 0;
    try {
      gmres.solve(matrix_, x, rhs, amg_);
    } catch (const SolverControl::NoConvergence&) {
      return -1;
    }
    return static_cast<int>(control.last_step());
  }

 private:
  void make_smoother(const int* start, const int* columns) {
    const Epetra_CrsMatrix& m = matrix_.trilinos_matrix();
    std::vector<unsigned> local(static_cast<std::size_t>(m.NumMyNonzeros()));
    std::transform(columns, columns + local.size(), local.begin(), [&](int column) {
      return partitioner_->global_to_local(static_cast<types::global_dof_index>(m.GCID(column)));
    });
    ghosted_.reinit(partitioner_);
    smoother_ = std::make_unique<Smoother>(n_owned_, start, local, [this](const double* owned) {
      std::copy(owned, owned + n_owned_, ghosted_.begin());
      ghosted_.update_ghost_values();
      return ghosted_.begin();
    });
  }

  /// Where in the matrix's rows the entries of the cells go, so that nothing is searched for later. The three
  /// rows of a node have the same columns.
  void find_places() {
    const Epetra_CrsMatrix& m = matrix_.trilinos_matrix();
    int *start, *columns;
    AssertThrow(m.ExtractCrsDataPointers(start, columns, values_) == 0, ExcInternalError());
    row_start_ = start;
    n_owned_ = unknowns_.owned.n_elements();
    make_smoother(start, columns);
    for (const std::vector<unsigned>& nodes : unknowns_.cell_nodes) {
      first_place_.push_back(place_.size());
      for (const unsigned a : nodes) {
        for (const unsigned b : nodes) {
          for (unsigned j = 0; j < 3; ++j) {
            if (a >= n_owned_) {
              place_.push_back(0);
              continue;
            }
            const int column = m.LCID(static_cast<int>(partitioner_->local_to_global(b + j)));
            const auto place =
                std::lower_bound(columns + start[a], columns + start[a + 1], column) - columns - start[a];
            for (unsigned i = 0; i < 3; ++i) {
              AssertThrow(columns[start[a + i] + place] == column, ExcInternalError());
            }
            place_.push_back(static_cast<std::uint16_t>(place));
          }
        }
      }
    }
  }

  void add_to_other_rank(const std::vector<unsigned>& nodes, std::size_t a, const double* K) {
    const std::size_t n = 3 * nodes.size();
    std::vector<types::global_dof_index> columns;
    for (unsigned b : nodes) {
      for (unsigned j = 0; j < 3; ++j) columns.push_back(partitioner_->local_to_global(b + j));
    }
    for (std::size_t i = 0; i < 3; ++i) {
      matrix_.add(columns[3 * a + i], static_cast<unsigned>(n), columns.data(), K + (3 * a + i) * n, false,
                  false);
    }
  }

  const Unknowns& unknowns_;
  const std::shared_ptr<const Utilities::MPI::Partitioner> partitioner_;  // made by all ranks together
  TrilinosWrappers::SparseMatrix matrix_;
  TrilinosWrappers::PreconditionAMG amg_;
  std::unique_ptr<Epetra_MultiVector> modes_;
  Vector ghosted_;  // the smoother's x, with entries of other ranks
  std::unique_ptr<Smoother> smoother_;
  std::size_t n_owned_ = 0;
  double* values_ = nullptr;
  const int* row_start_ = nullptr;
  std::vector<std::size_t> first_place_;
  std::vector<std::uint16_t> place_;
};

}  // namespace

std::unique_ptr<LinearSystem> trilinos_system(const Unknowns& unknowns) {
  return std::make_unique<TrilinosSystem>(unknowns);
}

}  // namespace muscle
