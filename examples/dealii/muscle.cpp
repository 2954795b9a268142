#include "muscle.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/fe_wedge_p.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/hp/fe_values.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <myogrowth/material.hpp>
#include <sstream>

#include "../../abi/faults.hpp"

namespace muscle {

using namespace dealii;

namespace {

constexpr unsigned wedge_index = 0, hex_index = 1;  // in the collections
constexpr double never = 1000;                      // an elastic stretch that the tendon does not reach

/// deal.II's vertex of the corner in CalculiX's order.
unsigned vertex(Shape shape, unsigned corner) {
  static constexpr unsigned hex[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  return shape == Shape::hex ? hex[corner] : corner;
}

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Adds the CPU seconds of its life to a sum.
struct Clock {
  double& sum;
  double start = cpu_seconds();
  explicit Clock(double& s) : sum(s) {}
  ~Clock() { sum += cpu_seconds() - start; }
};

}  // namespace

Muscle::Muscle(const Parameters& parameters, MPI_Comm comm)
    : parameters_(parameters),
      comm_(comm),
      rank_(Utilities::MPI::this_mpi_process(comm)),
      tendon_(parameters.muscle),
      mesh_(make_mesh(parameters.geometry, comm)),
      elements_(FESystem<3>(FE_WedgeP<3>(1), 3), FESystem<3>(FE_Q<3>(1), 3)),
      mappings_(MappingFE<3>(FE_WedgeP<3>(1)), MappingFE<3>(FE_Q<3>(1))),
      dofs_(*mesh_) {
  tendon_.c1 *= parameters.tendon_stiffness;
  tendon_.c2 *= parameters.tendon_stiffness;
  tendon_.growth.lambda_crit = never;
  tendon_.removal.tau_rev = 0;
  distribute();
  sort_cells();
  find_ends();
  find_supports();
  start_points();
  identity_ = identity();
  system_ = parameters.solver == "ML" ? trilinos_system(*unknowns_) : petsc_system(*unknowns_);
  dt_ = parameters.steps == "listed" ? parameters.end : parameters.step;
}

void Muscle::distribute() {
  for (const auto& cell : dofs_.active_cell_iterators()) {
    if (cell->is_locally_owned()) {
      cell->set_active_fe_index(cell->reference_cell() == ReferenceCells::Wedge ? wedge_index : hex_index);
    }
  }
  dofs_.distribute_dofs(elements_);
  IndexSet relevant;
  DoFTools::extract_locally_relevant_dofs(dofs_, relevant);
  unknowns_ =
      std::make_unique<Unknowns>(Unknowns{dofs_, comm_, dofs_.locally_owned_dofs(), relevant, {}, {}});
  u_.reinit(unknowns_->owned, relevant, comm_);
  u_n_.reinit(u_);
  residual_.reinit(u_);
  rhs_.reinit(u_);
  x_.reinit(u_);
}

/// Muscle before tendon, hexahedra before wedges: a group has one law and one shape.
void Muscle::sort_cells() {
  double least = std::numeric_limits<double>::max(), most = -least;
  for (const auto& cell : dofs_.active_cell_iterators()) {
    if (!cell->is_locally_owned()) continue;
    for (const unsigned v : cell->vertex_indices()) {
      least = std::min(least, cell->vertex(v)[2]);
      most = std::max(most, cell->vertex(v)[2]);
    }
  }
  proximal_.z = Utilities::MPI::min(least, comm_);
  distal_.z = Utilities::MPI::max(most, comm_);
  unknowns_->places.resize(unknowns_->owned.n_elements() / 3);
  std::size_t points = 0;
  for (const bool tendon : {false, true}) {
    for (const Shape shape : {Shape::hex, Shape::wedge}) {
      Group group{shape, tendon, cells_.size(), 0, points};
      for (const auto& cell : dofs_.active_cell_iterators()) {
        if (!cell->is_locally_owned() || (cell->active_fe_index() == hex_index) != (shape == Shape::hex))
          continue;
        const double z = cell->center()[2];
        if ((std::min(z - proximal_.z, distal_.z - z) < parameters_.tendon_length) != tendon) continue;
        first_node_.push_back(X_.size() / 3);
        first_point_.push_back(points);
        std::vector<unsigned> nodes;
        for (unsigned a = 0; a < static_cast<unsigned>(n_nodes(shape)); ++a) {
          const unsigned v = vertex(shape, a);
          const auto index = cell->vertex_dof_index(v, 0, cell->active_fe_index());
          nodes.push_back(u_.get_partitioner()->global_to_local(index));
          if (nodes.back() < unknowns_->owned.n_elements())
            unknowns_->places[nodes.back() / 3] = cell->vertex(v);
          for (unsigned i = 0; i < 3; ++i) X_.push_back(cell->vertex(v)[i]);
        }
        unknowns_->cell_nodes.push_back(nodes);
        cells_.push_back(cell);
        points += static_cast<std::size_t>(n_points(shape));
      }
      group.n = cells_.size() - group.first_cell;
      if (group.n > 0) groups_.push_back(group);
    }
  }
  const auto stiff = Utilities::MPI::sum(groups_.empty() || !groups_.back().tendon ? 0u : 1u, comm_);
  if (parameters_.tendon_length > 0 && stiff == 0) {
    std::ostringstream text;
    text << "Tendon/Length = " << parameters_.tendon_length
         << ": must be more than half the height of the first layer of cells";
    throw Error(text.str());
  }
}

/// Which nodes the ends hold; told, and refused where an end is not a closed flat face.
void Muscle::find_ends() {
  double height = std::numeric_limits<double>::max();  // the least of a cell, along z
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    double least = std::numeric_limits<double>::max(), most = -least;
    for (std::size_t a = 0; a < unknowns_->cell_nodes[c].size(); ++a) {
      const double z = X_[3 * (first_node_[c] + a) + 2];
      least = std::min(least, z);
      most = std::max(most, z);
    }
    height = std::min(height, most - least);
  }
  height = Utilities::MPI::min(height, comm_);
  for (End* end : {&proximal_, &distal_}) {
    end->tolerance = parameters_.ends_tolerance * height;
    // Faces on the surface: whole ones, and those that face the same way but are held in part: a gap.
    constexpr double same_way = 0.9;
    Vector faces(u_);  // how many whole faces a node has
    faces = 0;
    double area = 0, gap = 0, farthest = 0;
    for (const auto& cell : cells_) {
      for (const unsigned f : cell->face_indices()) {
        const auto face = cell->face(f);
        if (!face->at_boundary()) continue;
        const unsigned n = face->n_vertices();
        unsigned held = 0;
        for (unsigned v = 0; v < n; ++v) held += end->has(face->vertex(v)[2]);
        if (held == 0) continue;
        const Tensor<1, 3> normal =
            n == 4 ? cross_product_3d(face->vertex(3) - face->vertex(0), face->vertex(2) - face->vertex(1))
                   : cross_product_3d(face->vertex(1) - face->vertex(0), face->vertex(2) - face->vertex(0));
        if (held == n) {
          area += normal.norm() / 2;
          for (unsigned v = 0; v < n; ++v) faces(face->vertex_dof_index(v, 0, cell->active_fe_index())) += 1;
        } else if (std::abs(normal[2]) > same_way * normal.norm() &&
                   (face->center()[2] - cell->center()[2]) * end->toward > 0) {
          gap += normal.norm() / 2;
          for (unsigned v = 0; v < n; ++v)
            farthest = std::max(farthest, end->toward * (end->z - face->vertex(v)[2]));
        }
      }
    }
    faces.compress(VectorOperation::add);
    unsigned nodes = 0, loose = 0;
    for (unsigned k = 0; k < unknowns_->places.size(); ++k) {
      if (!end->has(unknowns_->places[k][2])) continue;
      ++nodes;
      loose += faces.local_element(3 * k) == 0;
    }
    nodes = Utilities::MPI::sum(nodes, comm_);
    loose = Utilities::MPI::sum(loose, comm_);
    area = Utilities::MPI::sum(area, comm_);
    gap = Utilities::MPI::sum(gap, comm_);
    farthest = Utilities::MPI::max(farthest, comm_);
    const std::string text = std::string(end->name) + " end at z = " + number("%.7g", end->z) + ": " +
                             std::to_string(nodes) + " nodes, area " + number("%.7g", area);
    const std::string more = "; nodes within Ends/Tolerance = " + number("%g", parameters_.ends_tolerance) +
                             " of the least height of a cell, " + number("%g", height) + ", are of the end";
    if (gap > 0)
      throw Error(text + ": is not closed: an area of " + number("%g", gap) +
                  " beside it faces the same way and has nodes that are not of the end, up to " +
                  number("%g", farthest) + " from it" + more);
    if (loose > 0 || area == 0)
      throw Error(text + ": must be a flat face; " + std::to_string(loose) +
                  " of these nodes have no face of the surface that is of the end" + more);
    say(text);
  }
}

void Muscle::find_supports() {
  const auto& nodes = unknowns_->cell_nodes;
  support_.assign(u_.locally_owned_size() + u_.get_partitioner()->n_ghost_indices(), none);
  const bool clamp_proximal = parameters_.ends != "free", clamp_distal = parameters_.ends == "clamped";
  // Free ends: one node of the proximal end, the nearest to the z axis, holds that end's place, and a second
  // one, the farthest from it along x, its turn about z.
  using Place = std::array<double, 3>;
  Place axis{}, far{};
  if (!clamp_proximal) {
    const auto best = [&](auto cost) {
      // cost, then z, y and x decide, so that all ranks find the same node.
      std::array<double, 4> mine = {{std::numeric_limits<double>::max(), 0, 0, 0}};
      for (const Point<3>& p : unknowns_->places) {
        if (proximal_.has(p[2])) mine = std::min(mine, std::array<double, 4>{{cost(p), p[2], p[1], p[0]}});
      }
      const auto all = Utilities::MPI::all_gather(comm_, mine);
      const auto least = *std::min_element(all.begin(), all.end());
      return Place{{least[3], least[2], least[1]}};
    };
    const auto rounded = [](double x) { return std::round(x * 1e9) / 1e9; };
    axis = best([&](const Point<3>& p) { return rounded(p[0] * p[0] + p[1] * p[1]); });
    far = best([&](const Point<3>& p) {
      return rounded(-std::abs(p[0] - axis[0]) + 1e-3 * std::abs(p[1] - axis[1]));
    });
  }
  cell_supported_.assign(cells_.size(), 0);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (std::size_t a = 0; a < nodes[c].size(); ++a) {
      const double* X = X_.data() + 3 * (first_node_[c] + a);
      const bool at_proximal = proximal_.has(X[2]), at_distal = distal_.has(X[2]);
      Support* s = support_.data() + nodes[c][a];
      if (at_proximal || at_distal) s[2] = at_distal ? pulled : held;
      if ((at_proximal && clamp_proximal) || (at_distal && clamp_distal)) s[0] = s[1] = held;
      if (!clamp_proximal && std::equal(X, X + 3, axis.begin())) s[0] = s[1] = held;
      if (!clamp_proximal && std::equal(X, X + 3, far.begin())) s[1] = held;
      for (int i = 0; i < 3; ++i) cell_supported_[c] |= s[i] != none;
    }
  }
  support_step_.assign(support_.size(), 0);
}

void Muscle::start_points() {
  const std::size_t n =
      cells_.empty() ? 0 : first_point_.back() + static_cast<std::size_t>(n_points(groups_.back().shape));
  places_.resize(3 * n);
  n0_.resize(3 * n);
  volumes_.resize(n);
  G_n_.assign(n, 1);
  lambda_n_.assign(n, 1);
  for (std::vector<double>* v : {&G_, &lambda_e_, &lambda_, &J_, &Je_}) v->assign(n, 1);
  double volume = 0;
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      const std::size_t p = first_point_[c];
      integration_points(group.shape, X_.data() + 3 * first_node_[c], places_.data() + 3 * p,
                         volumes_.data() + p);
    }
  }
  for (const double v : volumes_) volume += v;
  const auto inverted = Utilities::MPI::sum(
      std::count_if(volumes_.begin(), volumes_.end(), [](double v) { return !(v > 0); }), comm_);
  if (inverted > 0)
    throw Error("Geometry: " + std::to_string(inverted) +
                " integration points lie in cells that are inside out or flat");
  together(comm_, [&] {
    const FibreField field = make_fibre_field(parameters_.fibre);
    for (std::size_t p = 0; p < n; ++p) {
      const Point<3> place(places_[3 * p], places_[3 * p + 1], places_[3 * p + 2]);
      const Tensor<1, 3> fibre = field(place);
      const double unit[3] = {fibre[0], fibre[1], fibre[2]};
      if (!myogrowth::normalise(unit, n0_.data() + 3 * p)) {
        std::ostringstream text;
        text << "Fibre: (" << fibre << ") at (" << place << "): must be finite and of a length > 0";
        throw Error(text.str());
      }
    }
  });
  // Forces below this are rounding, where nothing is loaded.
  force_floor_ = 1e-12 * parameters_.muscle.c2 * std::pow(Utilities::MPI::sum(volume, comm_), 2. / 3);
}

std::string Muscle::describe(const Group& group, const Failure& failure, double dt) const {
  const std::size_t c = group.first_cell + static_cast<std::size_t>(failure.cell);
  const std::size_t p = first_point_[c] + static_cast<std::size_t>(failure.point);
  myogrowth::PointUpdate<double> u;
  const auto status =
      myogrowth::update_point(material(group), failure.F, n0_.data() + 3 * p, G_n_[p], lambda_n_[p], dt, u);
  std::ostringstream text;
  const CellId id = cells_[c]->id();
  text << "no result (" << myogrowth::abi::text(status) << ") in "
       << (group.shape == Shape::hex ? "hexahedron " : "wedge ")
       << (parameters_.geometry.kind == "file" ? std::to_string(id.get_coarse_cell_id()) : id.to_string())
       << ", point " << failure.point + 1 << " at (" << places_[3 * p] << ", " << places_[3 * p + 1] << ", "
       << places_[3 * p + 2] << "), G = " << G_n_[p] << ", F = [";
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) text << failure.F[i + 3 * j] << (j < 2 ? " " : i < 2 ? "; " : "]");
  }
  return text.str();
}

double Muscle::pull_at(double time) const {
  return parameters_.pull * std::min(time / parameters_.ramp, 1.0);
}

/// What the supports have to go until `time`; where u_ has got there it is zero.
void Muscle::prepare_supports(double time) {
  const double pull = pull_at(time);
  for (unsigned k = 0; k < support_.size(); ++k) {
    if (support_[k] != none) support_step_[k] = (support_[k] == pulled ? pull : 0) - u_.local_element(k);
  }
  if (!parameters_.dense) return;
  constraints_.clear();
  constraints_.reinit(unknowns_->relevant);
  for (unsigned k = 0; k < support_.size(); ++k) {
    if (support_[k] == none) continue;
    const auto index = u_.get_partitioner()->local_to_global(k);
    constraints_.add_line(index);
    constraints_.set_inhomogeneity(index, support_step_[k]);
  }
  constraints_.close();
}

/// Takes the supported unknowns out of the matrix of a cell; what they do to the others goes to the right
/// side.
void Muscle::take_supports(const Group& group, std::size_t cell, double* K) {
  const std::vector<unsigned>& nodes = unknowns_->cell_nodes[cell];
  const std::size_t n = 3 * static_cast<std::size_t>(n_nodes(group.shape));
  for (std::size_t j = 0; j < n; ++j) {
    const unsigned k = nodes[j / 3] + static_cast<unsigned>(j % 3);
    if (support_[k] == none) continue;
    for (std::size_t i = 0; i < n; ++i) {
      const unsigned row = nodes[i / 3] + static_cast<unsigned>(i % 3);
      if (support_[row] == none) rhs_.local_element(row) -= K[n * i + j] * support_step_[k];
      if (i != j) K[n * i + j] = K[n * j + i] = 0;
    }
  }
}

/// The forces out of balance at u_, their norms and the reaction; with the tangent also the matrix and the
/// right side. Returns what was wrong at a point of any rank.
std::string Muscle::assemble(double dt, bool tangent) {
  ++costs_.checks;
  residual_ = 0;
  if (tangent) {
    rhs_ = 0;
    system_->clear();
  }
  const std::string failure =
      first_text(comm_, parameters_.dense ? assemble_dense(dt) : assemble_compact(dt, tangent));
  if (!failure.empty()) return failure;
  const Clock clock(costs_.insertion);
  residual_.compress(VectorOperation::add);
  if (tangent) {
    rhs_.compress(VectorOperation::add);
    system_->finish();
  }
  std::array<double, 3> sums = {{0, 0, 0}};
  for (unsigned k = 0; k < u_.locally_owned_size(); ++k) {
    const double r = residual_.local_element(k);
    sums[support_[k] == none ? 0 : 1] += r * r;
    if (support_[k] == pulled) sums[2] += r;
    if (tangent && !parameters_.dense) {
      rhs_.local_element(k) = support_[k] == none ? rhs_.local_element(k) - r : 0;
    }
  }
  sums = {{Utilities::MPI::sum(sums[0], comm_), Utilities::MPI::sum(sums[1], comm_),
           Utilities::MPI::sum(sums[2], comm_)}};
  free_norm_ = std::sqrt(sums[0]);
  support_norm_ = std::sqrt(sums[1]);
  reaction_ = sums[2];
  return {};
}

std::string Muscle::assemble_compact(double dt, bool tangent) {
  constexpr std::size_t block = 64;  // points: what Elements takes through the law at once
  std::vector<double> u, R, K, scalars;
  for (const Group& group : groups_) {
    const auto nodes = static_cast<std::size_t>(n_nodes(group.shape)),
               points = static_cast<std::size_t>(n_points(group.shape));
    const std::size_t dofs = 3 * nodes, most = block / points;
    Elements elements(material(group), parameters_.volume);
    u.resize(most * dofs);
    R.resize(most * dofs);
    scalars.resize(5 * block);
    if (tangent) K.resize(most * dofs * dofs);
    for (std::size_t first = 0; first < group.n; first += most) {
      const std::size_t n = std::min(most, group.n - first), cell = group.first_cell + first,
                        p = first_point_[cell];
      {
        const Clock clock(costs_.element);
        for (std::size_t c = 0; c < n; ++c) {
          for (std::size_t a = 0; a < nodes; ++a) {
            const unsigned k = unknowns_->cell_nodes[cell + c][a];
            for (unsigned i = 0; i < 3; ++i) u[dofs * c + 3 * a + i] = u_.local_element(k + i);
          }
        }
        const Cells cells{group.shape,
                          static_cast<int>(n),
                          X_.data() + 3 * first_node_[cell],
                          u.data(),
                          n0_.data() + 3 * p,
                          G_n_.data() + p,
                          lambda_n_.data() + p};
        Failure failure = elements.evaluate(
            cells, dt, {R.data(), tangent ? K.data() : nullptr, scalars.data(), G_.data() + p});
        if (failure.point >= 0) {
          failure.cell += static_cast<int>(first);
          return describe(group, failure, dt);
        }
        for (std::size_t q = 0; q < n * points; ++q) {
          lambda_e_[p + q] = scalars[q];
          lambda_[p + q] = scalars[n * points + q];
          J_[p + q] = scalars[2 * n * points + q];
          Je_[p + q] = scalars[3 * n * points + q];
        }
      }
      const Clock clock(costs_.insertion);
      for (std::size_t c = 0; c < n; ++c) {
        for (std::size_t k = 0; k < dofs; ++k) {
          residual_.local_element(unknowns_->cell_nodes[cell + c][k / 3] + static_cast<unsigned>(k % 3)) +=
              R[dofs * c + k];
        }
        if (!tangent) continue;
        double* matrix = K.data() + dofs * dofs * c;
        if (cell_supported_[cell + c]) take_supports(group, cell + c, matrix);
        system_->add(cell + c, matrix);
      }
    }
    costs_.law += elements.law_seconds();
    costs_.element -= elements.law_seconds();
  }
  return {};
}

/// The loop one would write first: what the compact one is timed and tested against.
std::string Muscle::assemble_dense(double dt) {
  const double zeta = 0.5 / std::sqrt(3.0);
  const hp::QCollection<3> quadratures(
      Quadrature<3>({Point<3>(1. / 3, 1. / 3, 0.5 - zeta), Point<3>(1. / 3, 1. / 3, 0.5 + zeta)},
                    {0.25, 0.25}),
      QGauss<3>(2));
  hp::FEValues<3> values(mappings_, elements_, quadratures, update_gradients | update_JxW_values);
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      const double before = cpu_seconds(), law_before = costs_.law;
      const auto& cell = cells_[c];
      values.reinit(cell);
      const FEValues<3>& fe = values.get_present_fe_values();
      const unsigned n = fe.dofs_per_cell;
      FullMatrix<double> K(n, n);
      dealii::Vector<double> r(n), minus_r(n);
      std::vector<types::global_dof_index> indices(n);
      cell->get_dof_indices(indices);
      for (unsigned q = 0; q < fe.n_quadrature_points; ++q) {
        const std::size_t p = first_point_[c] + q;
        Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
        Eigen::Matrix<double, 9, Eigen::Dynamic> B = Eigen::Matrix<double, 9, Eigen::Dynamic>::Zero(9, n);
        for (unsigned a = 0; a < n; ++a) {
          const unsigned i = a % 3;
          for (unsigned J = 0; J < 3; ++J) {
            B(i + 3 * J, a) = fe.shape_grad(a, q)[J];
            F(i, J) += fe.shape_grad(a, q)[J] * u_(indices[a]);
          }
        }
        myogrowth::State<> state;
        state.G = G_n_[p];
        state.lambda = lambda_n_[p];
        state.n0 = Eigen::Map<const Eigen::Vector3d>(n0_.data() + 3 * p);
        const double law_start = cpu_seconds();
        const auto step = myogrowth::update(material(group), F, state, dt);
        const Eigen::Matrix3d P = step.first_piola();
        const Eigen::Matrix<double, 9, 9> A = step.dP_dF();
        costs_.law += cpu_seconds() - law_start;
        if (!step.ok()) {
          Failure failure;
          failure.cell = static_cast<int>(c - group.first_cell);
          failure.point = static_cast<int>(q);
          std::copy(F.data(), F.data() + 9, failure.F);
          return describe(group, failure, dt);
        }
        G_[p] = step.state.G;
        lambda_e_[p] = step.point.lambda_e;
        lambda_[p] = step.point.lambda;
        J_[p] = step.point.J;
        Je_[p] = step.point.Je;
        const Eigen::VectorXd force = B.transpose() * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(P.data());
        const Eigen::MatrixXd stiffness = B.transpose() * A * B;
        for (unsigned a = 0; a < n; ++a) {
          r(a) += fe.JxW(q) * force[a];
          for (unsigned b = 0; b < n; ++b) K(a, b) += fe.JxW(q) * stiffness(a, b);
        }
      }
      costs_.element += cpu_seconds() - before - (costs_.law - law_before);
      const Clock clock(costs_.insertion);
      for (unsigned a = 0; a < n; ++a) residual_(indices[a]) += r(a);
      minus_r.equ(-1, r);
      system_->add_by_dealii(constraints_, K, minus_r, indices, rhs_);
    }
  }
  return {};
}

/// u_ moves by the solution of the linear system; |rhs| below `target` need not be gone into.
void Muscle::solve(double target) {
  const double rhs = rhs_.l2_norm();
  const double tolerance = std::max(parameters_.krylov_tolerance, std::min(0.1, 0.1 * target / rhs));
  const auto attempt = [&] {
    const Clock clock(costs_.krylov);
    ++costs_.solves;
    last_iterations_ = system_->solve(rhs_, x_, tolerance);
    costs_.iterations += std::max(last_iterations_, 0);
  };
  const auto set_up = [&] {
    const Clock clock(costs_.set_up);
    ++costs_.set_ups;
    system_->set_up();
    fresh_iterations_ = -1;
  };
  const double digits = -std::log10(tolerance);
  const bool fresh = fresh_iterations_ < 0;
  if (fresh) set_up();
  attempt();
  if (last_iterations_ < 0 && !fresh) {
    set_up();
    attempt();
  }
  // Iterations are compared at the same gain, 1e-6.
  const int normal = static_cast<int>(last_iterations_ * 6 / digits);
  if (fresh_iterations_ < 0) {
    fresh_iterations_ = normal;
  } else if (2 * normal > 3 * fresh_iterations_) {
    fresh_iterations_ = -1;
  }
}

Muscle::Attempt Muscle::step(double dt) {
  if (parameters_.set_up_every_step) fresh_iterations_ = -1;
  prepare_supports(time_ + dt);
  double moves = 0;
  for (const double s : support_step_) moves = std::max(moves, std::abs(s));
  moves = Utilities::MPI::max(moves, comm_);
  double first = 0;
  for (int iteration = 0;; ++iteration) {
    // The first matrix is needed in any case, unless nothing moves; later ones only where the forces are out
    // of balance.
    bool tangent = parameters_.dense || iteration == 0;
    std::string failure = assemble(dt, tangent);
    if (!failure.empty()) return {false, failure};
    const double target = parameters_.newton_tolerance * std::max(support_norm_, force_floor_);
    log_newton(iteration, free_norm_ / std::max(support_norm_, force_floor_),
               iteration > 0 ? last_iterations_ : 0);
    if (free_norm_ <= target && (iteration > 0 || moves == 0)) return {true, {}};
    if (iteration == parameters_.newton_iterations) {
      std::ostringstream text;
      text << "forces are out of balance by " << free_norm_ << " after " << iteration
           << " Newton iterations, " << target << " is allowed";
      return {false, text.str()};
    }
    if (iteration == 1) first = free_norm_;
    if (iteration > 2 && !(free_norm_ < 10 * first)) return {false, "Newton's method diverges"};
    if (!tangent) {
      failure = assemble(dt, true);
      if (!failure.empty()) return {false, failure};
    }
    solve(target);
    if (last_iterations_ < 0) return {false, "GMRES did not converge"};
    ++costs_.newton;
    for (unsigned k = 0; k < u_.locally_owned_size(); ++k) {
      u_.local_element(k) += support_[k] == none ? x_.local_element(k) : support_step_[k];
    }
    u_.update_ghost_values();
    prepare_supports(time_ + dt);
  }
}

/// The largest time error of G over the muscle's points, as the library estimates it.
double Muscle::time_error(double dt) const {
  const auto& m = parameters_.muscle;
  const bool first_order = m.integration == myogrowth::TimeIntegration::backward_euler;
  double worst = 0;
  for (const Group& group : groups_) {
    if (group.tendon) continue;
    const std::size_t n = group.n * static_cast<std::size_t>(n_points(group.shape));
    for (std::size_t p = group.first_point; p < group.first_point + n; ++p) {
      const double error = first_order ? myogrowth::time_error_of_backward_euler(m.growth, m.removal, G_n_[p],
                                                                                 lambda_n_[p], lambda_[p], dt)
                                       : myogrowth::time_error_of_midpoint_flow(m.growth, m.removal, G_n_[p],
                                                                                lambda_n_[p], lambda_[p], dt);
      worst = std::max(worst, error);
    }
  }
  return Utilities::MPI::max(worst, comm_);
}

void Muscle::commit(double dt) {
  time_ += dt;
  G_n_ = G_;
  lambda_n_ = lambda_;
  u_n_ = u_;
  ++costs_.steps;
}

/// The time at which a step must end: that of the ramp, of an output, of a listed step, of the whole.
double Muscle::next_stop() const {
  double stop = parameters_.end;
  const double now = time_ * (1 + 1e-12) + 1e-300;
  const auto consider = [&](double t) {
    if (t > now) stop = std::min(stop, t);
  };
  consider(parameters_.ramp);
  for (const double t : parameters_.output_times) consider(t);
  for (const double t : parameters_.times) {
    if (parameters_.steps == "listed") consider(t);
  }
  return stop;
}

bool Muscle::run(const volatile int& asked_to_end) {
  const double start = MPI_Wtime();
  std::ostringstream sizes;
  sizes << mesh_->n_global_active_cells() << " elements, " << dofs_.n_dofs() << " unknowns, "
        << Utilities::MPI::n_mpi_processes(comm_) << " ranks";
  say(sizes.str());
  if (parameters_.resume) {
    read_checkpoint();
    say("resumed at time " + number("%g", time_));
    find_fields();
  } else {
    put_checkpoint_aside();
  }
  start_rows();

  const double shortest = shortest_step * parameters_.end;
  const double planned = parameters_.steps == "listed" ? parameters_.end : parameters_.step;
  while (time_ < parameters_.end * (1 - 1e-12)) {
    const double step_start = MPI_Wtime(), stop = next_stop();
    const bool adaptive = parameters_.steps == "adaptive";
    double dt = dt_;
    if (adaptive)
      dt = std::min(
          dt, time_ < parameters_.ramp * (1 - 1e-12) ? parameters_.ramp / 10 : parameters_.longest_step);
    const bool to_stop = time_ + dt * 1.000001 >= stop;
    if (to_stop) dt = stop - time_;

    Attempt attempt = step(dt);
    double factor = 2;
    if (attempt.converged && adaptive) {
      const double error = time_error(dt);
      factor = std::min(
          2.0, std::max(0.25, 0.9 * std::sqrt(parameters_.time_tolerance / std::max(error, 1e-300))));
      if (error > parameters_.time_tolerance && factor < 1) attempt.why = "time error";
    }
    if (!attempt.why.empty()) {
      u_ = u_n_;
      u_.update_ghost_values();
      ++costs_.cuts;
      fresh_iterations_ = -1;
      const bool time_is_too_long = attempt.converged;
      if (!time_is_too_long) say("  step of " + number("%g", dt) + " is halved: " + attempt.why);
      dt_ = dt * (time_is_too_long ? factor : 0.5);
      if (dt_ < shortest)
        throw Error("no step is short enough at time " + number("%g", time_) + ": " + attempt.why);
      continue;
    }
    commit(dt);
    if (to_stop) time_ = stop;  // to the last bit
    if (adaptive) {
      dt_ = to_stop ? std::max(dt_, factor * dt) : factor * dt;
    } else {
      dt_ = std::min(planned, 2 * dt_);
    }
    {
      const Clock clock(costs_.output);
      write_history();
      const auto& times = parameters_.output_times;
      const bool wanted =
          std::find(times.begin(), times.end(), time_) != times.end() || time_ == parameters_.end;
      if (!times.empty() && wanted) write_fields();
    }
    tell_progress(MPI_Wtime() - step_start);
    const bool ends = Utilities::MPI::max(static_cast<int>(asked_to_end), comm_) != 0;
    if (ends || (parameters_.checkpoint_every > 0 && costs_.steps % parameters_.checkpoint_every == 0)) {
      const Clock clock(costs_.output);
      write_checkpoint();
    }
    if (ends) {
      say("asked to end: the checkpoint is written; Output/Resume=true goes on from it");
      return false;
    }
  }
  write_summary(MPI_Wtime() - start);
  return true;
}

}  // namespace muscle
