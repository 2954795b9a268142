// The fibres: where they come from, flow from attachment to attachment, streamlines as fascicles.
#include <deal.II/lac/solver_cg.h>
#include <deal.II/numerics/rtree.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "muscle.hpp"

namespace muscle {

using namespace dealii;

namespace {

/// The Laplace operator of a scalar that lives on the first of the three unknowns of a node, cell by cell.
class Laplace {
 public:
  Laplace(const Unknowns& unknowns, std::vector<char> fixed)
      : unknowns_(unknowns), fixed_(std::move(fixed)) {}

  void add_cell(std::vector<double> K) { cells_.push_back(std::move(K)); }

  /// y = K x, or with the fixed nodes taken out.
  void apply(Vector& y, const Vector& x, bool all) const {
    x.update_ghost_values();
    y = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const auto& nodes = unknowns_.cell_nodes[c];
      const std::size_t n = nodes.size();
      for (std::size_t a = 0; a < n; ++a) {
        if (!all && fixed_[nodes[a] / 3]) continue;
        double sum = 0;
        for (std::size_t b = 0; b < n; ++b) {
          if (all || !fixed_[nodes[b] / 3]) sum += cells_[c][n * a + b] * x.local_element(nodes[b]);
        }
        y.local_element(nodes[a]) += sum;
      }
    }
    y.compress(VectorOperation::add);
    x.zero_out_ghost_values();
  }
  void vmult(Vector& y, const Vector& x) const { apply(y, x, false); }

  /// Its diagonal; where that is 0, 1.
  void diagonal(Vector& d) const {
    d = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      const auto& nodes = unknowns_.cell_nodes[c];
      for (std::size_t a = 0; a < nodes.size(); ++a)
        d.local_element(nodes[a]) += cells_[c][(nodes.size() + 1) * a];
    }
    d.compress(VectorOperation::add);
    for (unsigned k = 0; k < d.locally_owned_size(); ++k) {
      if (!(d.local_element(k) > 0)) d.local_element(k) = 1;
    }
  }

 private:
  const Unknowns& unknowns_;
  std::vector<char> fixed_;  // local nodes
  std::vector<std::vector<double>> cells_;
};

struct Jacobi {
  const Vector& diagonal;
  void vmult(Vector& y, const Vector& x) const {
    for (unsigned k = 0; k < y.locally_owned_size(); ++k)
      y.local_element(k) = x.local_element(k) / diagonal.local_element(k);
  }
};

}  // namespace

void Muscle::find_fibres() {
  std::string kind = parameters_.fibre.kind;
  if (kind == "default") kind = file_.fibres.empty() ? "flow" : "mesh";
  if (kind == "flow") return flow_fibres();
  if (kind == "mesh" && file_.fibres.empty())
    throw Error("Fibre/Kind = mesh: there are no fibres in " + file_.path);
  together(comm_, [&] {
    const FibreField field = kind == "mesh" ? FibreField() : make_fibre_field(parameters_.fibre);
    for (const Group& group : groups_) {
      for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
        for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
          const std::size_t p = first_point_[c] + q;
          Tensor<1, 3> fibre;
          if (field) {
            fibre = field(place(p));
          } else {
            const auto& from = file_.fibres[cells_[c]->id().get_coarse_cell_id()];
            fibre = Tensor<1, 3>({from[0], from[1], from[2]});
          }
          const double unit[3] = {fibre[0], fibre[1], fibre[2]};
          if (!myogrowth::normalise(unit, n0_.data() + 3 * p)) {
            std::ostringstream text;
            text << "Fibre: (" << fibre << ") at (" << place(p) << "): must be finite and of a length > 0";
            throw Error(text.str());
          }
        }
      }
    }
  });
}

/// Potential flow: phi is 0 on one surface, 1 on the other, and flows through no other part of the surface;
/// n0 = grad phi/|grad phi| at the integration points.
void Muscle::flow_fibres() {
  std::vector<signed char> value(file_.nodes.size(), -1);
  for (int side = 0; side < 2; ++side) {
    const std::string& name = side == 0 ? parameters_.fibre.from : parameters_.fibre.to;
    const MeshFile::Surface* surface = file_.surface(name);
    if (surface == nullptr || surface->facets.empty())
      throw Error(std::string("Fibre/") + (side == 0 ? "From" : "To") + " = " + name +
                  ": must be a surface of " + file_.path + ", which has " + file_.surface_names());
    for (const unsigned node : file_.nodes_of(*surface)) {
      if (value[node] == 1 - side)
        throw Error("Fibre/From and Fibre/To: " + parameters_.fibre.from + " and " + parameters_.fibre.to +
                    " touch, at " + file_.node(node));
      value[node] = static_cast<signed char>(side);
    }
  }
  Vector phi(u_), rhs(u_), diagonal(u_), change(u_);
  std::vector<char> fixed(support_of_.size(), 0);
  phi = 0;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const auto& in_file = file_.cells[cells_[c]->id().get_coarse_cell_id()].nodes;
    for (std::size_t a = 0; a < unknowns_->cell_nodes[c].size(); ++a) {
      if (value[in_file[a]] < 0) continue;
      const unsigned k = unknowns_->cell_nodes[c][a];
      fixed[k / 3] = 1;
      if (k < phi.locally_owned_size()) phi.local_element(k) = value[in_file[a]];
    }
  }
  Laplace laplace(*unknowns_, fixed);
  std::vector<double> gradients(3 * most_nodes * most_points);
  for (const Group& group : groups_) {
    const auto n = static_cast<std::size_t>(n_nodes(group.shape));
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      shape_gradients(group.shape, X_.data() + 3 * first_node_[c], gradients.data());
      std::vector<double> K(n * n);
      for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
        const double* g = gradients.data() + 3 * n * q;
        for (std::size_t a = 0; a < n; ++a) {
          for (std::size_t b = 0; b < n; ++b)
            K[n * a + b] += volumes_[first_point_[c] + q] *
                            (g[3 * a] * g[3 * b] + g[3 * a + 1] * g[3 * b + 1] + g[3 * a + 2] * g[3 * b + 2]);
        }
      }
      laplace.add_cell(std::move(K));
    }
  }
  laplace.apply(rhs, phi, true);
  for (unsigned k = 0; k < rhs.locally_owned_size(); ++k)
    rhs.local_element(k) = k % 3 == 0 && !fixed[k / 3] ? -rhs.local_element(k) : 0;
  laplace.diagonal(diagonal);
  change = 0;
  SolverControl control(100000, 1e-13 * rhs.l2_norm());
  SolverCG<Vector> cg(control);
  try {
    cg.solve(laplace, change, rhs, Jacobi{diagonal});
  } catch (const SolverControl::NoConvergence&) {
    throw Error("Fibre/Kind = flow: the potential was not found in 100000 iterations");
  }
  phi += change;
  phi.update_ghost_values();

  // Where there is no gradient, because all nodes of a cell are on one surface, the neighbours' mean holds,
  // layer by layer.
  const double least = 1e-6 / line_length_;
  std::vector<Tensor<1, 3>> mean(cells_.size());  // of the unit vectors, times volume; 0: none yet
  std::vector<std::size_t> without;
  std::vector<char> missing(volumes_.size(), 0);
  for (const Group& group : groups_) {
    const auto n = static_cast<std::size_t>(n_nodes(group.shape));
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      shape_gradients(group.shape, X_.data() + 3 * first_node_[c], gradients.data());
      bool lacks = false;
      for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
        const std::size_t p = first_point_[c] + q;
        Tensor<1, 3> g;
        for (std::size_t a = 0; a < n; ++a) {
          for (unsigned i = 0; i < 3; ++i)
            g[i] += gradients[3 * (n * q + a) + i] * phi.local_element(unknowns_->cell_nodes[c][a]);
        }
        missing[p] = !(g.norm() > least);
        lacks = lacks || missing[p];
        if (missing[p]) continue;
        g /= g.norm();
        for (unsigned i = 0; i < 3; ++i) n0_[3 * p + i] = g[i];
        mean[c] += volumes_[p] * g;
      }
      if (lacks) without.push_back(c);
    }
  }
  const auto first_without = Utilities::MPI::sum(without.size(), comm_);
  Vector sum(u_);
  const auto points_of = [&](std::size_t c) {
    return c + 1 < cells_.size() ? first_point_[c + 1] : volumes_.size();
  };
  const auto give = [&](std::size_t c, const Tensor<1, 3>& n) {
    double volume = 0;
    for (std::size_t p = first_point_[c]; p < points_of(c); ++p) {
      if (!missing[p]) continue;
      for (unsigned i = 0; i < 3; ++i) n0_[3 * p + i] = n[i];
      missing[p] = 0;
      volume += volumes_[p];
    }
    mean[c] += volume * n;
  };
  for (int round = 0; round < 100 && Utilities::MPI::sum(without.size(), comm_) > 0; ++round) {
    sum = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      for (const unsigned k : unknowns_->cell_nodes[c]) {
        for (unsigned i = 0; i < 3; ++i) sum.local_element(k + i) += mean[c][i];
      }
    }
    sum.compress(VectorOperation::add);
    sum.update_ghost_values();
    std::vector<std::size_t> left;
    std::vector<std::pair<std::size_t, Tensor<1, 3>>> found;
    for (const std::size_t c : without) {
      Tensor<1, 3> n;
      for (const unsigned k : unknowns_->cell_nodes[c]) {
        for (unsigned i = 0; i < 3; ++i) n[i] += sum.local_element(k + i);
      }
      if (n.norm() > 0) {
        found.emplace_back(c, n / n.norm());
      } else {
        left.push_back(c);
      }
    }
    sum.zero_out_ghost_values();
    for (const auto& entry : found) give(entry.first, entry.second);
    without = left;
  }
  const auto by_line = Utilities::MPI::sum(without.size(), comm_);
  for (const std::size_t c : without) give(c, line_);
  found_["cells_without_gradient"] = static_cast<double>(first_without);
  found_["potential_iterations"] = static_cast<double>(control.last_step());
  say("fibres: flow from " + parameters_.fibre.from + " to " + parameters_.fibre.to + ", " +
      std::to_string(control.last_step()) + " iterations; " + std::to_string(first_without) +
      " cells without a gradient have their neighbours' direction" +
      (by_line > 0 ? ", " + std::to_string(by_line) + " of them without such neighbours that of the line"
                   : ""));
}

/// Streamlines of the fibres from the proximal attachment on.
void Muscle::trace_fascicles() {}

}  // namespace muscle
