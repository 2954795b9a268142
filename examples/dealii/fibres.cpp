// The fibres: where they come from, flow from attachment to attachment, streamlines as fascicles.
#include <deal.II/base/bounding_box.h>
#include <deal.II/lac/solver_cg.h>
#include <deal.II/numerics/rtree.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "../common/rows.hpp"
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

/// fibres.csv: a row for each integration point, whose number begins with 1, in the order of the file.
void Muscle::write_fibres() const {
  struct Row {
    std::uint64_t key, label;
    double values[6];
    int point;
  };
  std::vector<Row> rows;
  for (const Group& group : groups_) {
    for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
      const std::size_t in_file = cells_[c]->id().get_coarse_cell_id();
      for (int q = 0; q < n_points(group.shape); ++q) {
        const std::size_t p = first_point_[c] + static_cast<std::size_t>(q);
        Row row{
            cell_key(cells_[c]->id()), file_.cells.empty() ? in_file : file_.cells[in_file].label, {}, q + 1};
        std::copy_n(places_.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, row.values);
        std::copy_n(n0_.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, row.values + 3);
        rows.push_back(row);
      }
    }
  }
  std::vector<char> bytes(rows.size() * sizeof(Row));
  if (!rows.empty()) std::memcpy(bytes.data(), rows.data(), bytes.size());
  const auto all = Utilities::MPI::gather(comm_, bytes);
  on_first(comm_, [&] {
    std::vector<Row> sorted;
    for (const std::vector<char>& part : all) {
      const std::size_t before = sorted.size();
      sorted.resize(before + part.size() / sizeof(Row));
      if (!part.empty()) std::memcpy(static_cast<void*>(sorted.data() + before), part.data(), part.size());
    }
    std::sort(sorted.begin(), sorted.end(), [](const Row& a, const Row& b) {
      return std::make_pair(a.key, a.point) < std::make_pair(b.key, b.point);
    });
    common::Output out(parameters_.folder + "/fibres.csv");
    out << "element,point,x,y,z,n0_x,n0_y,n0_z\n";
    for (const Row& row : sorted) {
      std::string text = std::to_string(row.label) + "," + std::to_string(row.point);
      for (const double x : row.values) text += number(",%.13g", x);
      out << text << "\n";
    }
    out.close();
  });
}

/// Those of all cells, then those of sets.
void Muscle::find_fibres() {
  std::vector<char> has_own(file_.cells.size(), 0);
  std::vector<std::vector<char>> sets;
  for (const auto& of : parameters_.set_fibres) {
    sets.push_back(file_.cells_of(of.set));
    if (sets.back().empty())
      throw Error("Fibre/List: there is no section or set " + common::visible(of.set) + " in " + file_.path +
                  "; there are: " + file_.set_names());
    for (std::size_t c = 0; c < has_own.size(); ++c) has_own[c] = has_own[c] || sets.back()[c];
  }
  if (has_own.empty() || std::count(has_own.begin(), has_own.end(), 0) > 0) find_fibres(parameters_.fibre);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const std::vector<double> before = n0_;
    find_fibres(parameters_.set_fibres[k].fibre);
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      if (sets[k][cells_[c]->id().get_coarse_cell_id()]) continue;
      const std::size_t end = c + 1 < cells_.size() ? first_point_[c + 1] : volumes_.size();
      std::copy(before.begin() + static_cast<std::ptrdiff_t>(3 * first_point_[c]),
                before.begin() + static_cast<std::ptrdiff_t>(3 * end),
                n0_.begin() + static_cast<std::ptrdiff_t>(3 * first_point_[c]));
    }
    say("fibres of " + parameters_.set_fibres[k].set + ": " + parameters_.set_fibres[k].fibre.kind);
  }
}

/// n0_ of all points by one way.
void Muscle::find_fibres(const Parameters::Fibre& fibre) {
  std::string kind = fibre.kind;
  if (kind == "default") kind = file_.fibres.empty() ? "flow" : "mesh";
  if (kind == "flow") return flow_fibres(fibre);
  if (kind == "mesh" && file_.fibres.empty())
    throw Error("Fibre/Kind = mesh: there are no fibres in " + file_.path);
  together(comm_, [&] {
    const FibreField field = kind == "mesh" ? FibreField() : make_fibre_field(fibre);
    for (const Group& group : groups_) {
      for (std::size_t c = group.first_cell; c < group.first_cell + group.n; ++c) {
        for (std::size_t q = 0; q < static_cast<std::size_t>(n_points(group.shape)); ++q) {
          const std::size_t p = first_point_[c] + q;
          Tensor<1, 3> n;
          if (field) {
            n = field(place(p));
          } else {
            const auto& from = file_.fibres[cells_[c]->id().get_coarse_cell_id()];
            n = Tensor<1, 3>({from[0], from[1], from[2]});
          }
          const double unit[3] = {n[0], n[1], n[2]};
          if (!myogrowth::normalise(unit, n0_.data() + 3 * p)) {
            std::ostringstream text;
            text << "Fibre: (" << n << ") at (" << place(p) << "): must be finite and of a length > 0";
            throw Error(text.str());
          }
        }
      }
    }
  });
}

/// Potential flow: phi is 0 on some surfaces, 1 on others, and flows through no other part of the surface;
/// n0 = grad phi/|grad phi| at the integration points.
void Muscle::flow_fibres(const Parameters::Fibre& fibre) {
  const auto joined = [](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
    return text;
  };
  const std::string ends[2] = {joined(fibre.from), joined(fibre.to)};
  std::vector<signed char> value(file_.nodes.size(), -1);
  for (int side = 0; side < 2; ++side) {
    if (ends[side].empty())
      throw Error(std::string("Fibre/") + (side == 0 ? "From" : "To") + " is empty: must be a surface of " +
                  file_.path + ", which has " + file_.surface_names());
    for (const std::string& name : side == 0 ? fibre.from : fibre.to) {
      const MeshFile::Surface* surface = file_.surface(name);
      if (surface == nullptr || surface->facets.empty())
        throw Error(std::string("Fibre/") + (side == 0 ? "From" : "To") + " = " + common::visible(name) +
                    ": must be a surface of " + file_.path + ", which has " + file_.surface_names());
      for (const unsigned node : file_.nodes_of(*surface)) {
        if (value[node] == 1 - side)
          throw Error("Fibre/From and Fibre/To: " + ends[0] + " and " + ends[1] + " touch, at " +
                      file_.node(node));
        value[node] = static_cast<signed char>(side);
      }
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
  found_["cells_without_gradient"] += static_cast<double>(first_without);
  found_["potential_iterations"] = static_cast<double>(control.last_step());
  say("fibres: flow from " + ends[0] + " to " + ends[1] + ", " + std::to_string(control.last_step()) +
      " iterations; " + std::to_string(first_without) +
      " cells without a gradient have their neighbours' direction" +
      (by_line > 0 ? ", " + std::to_string(by_line) + " of them without such neighbours that of the line"
                   : ""));
}

namespace {

/// Finds the cell of a place, and the fibre there, between the nodes.
class Tracer {
 public:
  Tracer(const MeshFile& file, const std::vector<double>& directions) : file_(file), directions_(directions) {
    // Tetrahedra that the cells are made of; faces are taken as flat.
    static const std::vector<std::array<unsigned, 4>> of_hex = {{{0, 1, 2, 6}}, {{0, 2, 3, 6}},
                                                                {{0, 3, 7, 6}}, {{0, 7, 4, 6}},
                                                                {{0, 4, 5, 6}}, {{0, 5, 1, 6}}},
                                                      of_wedge = {{{0, 1, 2, 5}},
                                                                  {{0, 1, 5, 4}},
                                                                  {{0, 4, 5, 3}}},
                                                      of_tet = {{{0, 1, 2, 3}}};
    std::vector<std::pair<BoundingBox<3>, unsigned>> boxes;
    for (unsigned c = 0; c < file.cells.size(); ++c) {
      const auto& cell = file.cells[c];
      for (const auto& corners : cell.shape == Shape::hex     ? of_hex
                                 : cell.shape == Shape::wedge ? of_wedge
                                                              : of_tet) {
        Part part;
        part.cell = c;
        std::vector<Point<3>> places;
        for (unsigned k = 0; k < 4; ++k) {
          part.nodes[k] = cell.nodes[corners[k]];
          places.push_back(at(part.nodes[k]));
        }
        for (unsigned k = 0; k < 3; ++k) part.edges[k] = places[k + 1] - places[0];
        part.volume = part.edges[0] * cross_product_3d(part.edges[1], part.edges[2]);
        boxes.emplace_back(BoundingBox<3>(places), static_cast<unsigned>(parts_.size()));
        parts_.push_back(part);
      }
    }
    tree_ = pack_rtree(boxes);
  }

  struct Found {
    unsigned part = 0;
    std::array<double, 4> weights = {};
  };
  /// False if the place is outside.
  bool locate(const Point<3>& x, Found& found) const {
    std::vector<std::pair<BoundingBox<3>, unsigned>> near;
    tree_.query(boost::geometry::index::intersects(x), std::back_inserter(near));
    double best = -1e-9;
    bool inside = false;
    for (const auto& row : near) {
      const Part& p = parts_[row.second];
      const auto w = weights(p, x);
      const double least = *std::min_element(w.begin(), w.end());
      if (least < best) continue;
      best = least;
      found = {row.second, w};
      inside = true;
    }
    return inside;
  }
  Tensor<1, 3> direction(const Found& f) const {
    Tensor<1, 3> n;
    for (unsigned k = 0; k < 4; ++k) {
      for (unsigned i = 0; i < 3; ++i) n[i] += f.weights[k] * directions_[3 * parts_[f.part].nodes[k] + i];
    }
    return n / std::max(n.norm(), 1e-300);
  }
  unsigned cell(const Found& f) const { return parts_[f.part].cell; }
  /// Whether a place on the surface is on a cell with at least three nodes of a set.
  bool touches(const Point<3>& x, const std::vector<char>& set) const {
    std::vector<std::pair<BoundingBox<3>, unsigned>> near;
    tree_.query(boost::geometry::index::intersects(x), std::back_inserter(near));
    return std::any_of(near.begin(), near.end(), [&](const auto& row) {
      const Part& p = parts_[row.second];
      const auto w = weights(p, x);
      return *std::min_element(w.begin(), w.end()) > -1e-6 &&
             std::count_if(p.nodes.begin(), p.nodes.end(), [&](unsigned k) { return set[k] != 0; }) >= 3;
    });
  }
  /// A length of the cell's size.
  double size(const Found& f) const { return std::cbrt(std::abs(parts_[f.part].volume)); }
  Point<3> middle(const Found& f) const {
    Point<3> m;
    for (const unsigned node : parts_[f.part].nodes) m += at(node) / 4;
    return m;
  }
  Point<3> at(unsigned node) const {
    return {file_.nodes[node][0], file_.nodes[node][1], file_.nodes[node][2]};
  }

 private:
  struct Part {
    unsigned cell;
    std::array<unsigned, 4> nodes;
    std::array<Tensor<1, 3>, 3> edges;
    double volume;  // times 6
  };
  /// Barycentric coordinates.
  std::array<double, 4> weights(const Part& p, const Point<3>& x) const {
    const Tensor<1, 3> d = x - at(p.nodes[0]);
    const double w1 = d * cross_product_3d(p.edges[1], p.edges[2]) / p.volume,
                 w2 = p.edges[0] * cross_product_3d(d, p.edges[2]) / p.volume,
                 w3 = p.edges[0] * cross_product_3d(p.edges[1], d) / p.volume;
    return {{1 - w1 - w2 - w3, w1, w2, w3}};
  }
  const MeshFile& file_;
  const std::vector<double>& directions_;  // of the nodes
  std::vector<Part> parts_;
  RTree<std::pair<BoundingBox<3>, unsigned>> tree_;
};

/// A straight part of a streamline, in one cell.
struct Segment {
  int fascicle;
  unsigned cell;
  double middle[3], dX[3];
};

}  // namespace

/// Streamlines of the fibres from the proximal attachment on, seeded evenly over its area. They follow the
/// mean direction of the cells about every node, linear between the nodes, in steps of the second order; at
/// the surface between the attachments they are turned inwards. What lies in tendon is not counted.
void Muscle::trace_fascicles() {
  const MeshFile::Surface &from = *file_.surface(parameters_.attachments.proximal),
                          &to = *file_.surface(parameters_.attachments.distal);
  std::vector<double> directions(3 * file_.nodes.size(), 0.0);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const auto& cell = file_.cells[cells_[c]->id().get_coarse_cell_id()];
    const std::size_t end = c + 1 < cells_.size() ? first_point_[c + 1] : volumes_.size();
    for (std::size_t p = first_point_[c]; p < end; ++p) {
      for (int a = 0; a < n_corners(cell.shape); ++a) {
        for (std::size_t i = 0; i < 3; ++i)
          directions[3 * cell.nodes[static_cast<std::size_t>(a)] + i] += volumes_[p] * n0_[3 * p + i];
      }
    }
  }
  Utilities::MPI::sum(directions, comm_, directions);
  std::vector<Segment> segments;
  int arrived = 0;
  on_first(comm_, [&] {
    const Tracer tracer(file_, directions);
    std::vector<char> is_end(file_.nodes.size(), 0);
    for (const unsigned node : file_.nodes_of(to)) is_end[node] = 1;
    std::vector<double> area;  // up to each facet
    for (const auto& facet : from.facets) {
      const Tensor<1, 3> a = tracer.at(facet.nodes[1]) - tracer.at(facet.nodes[0]),
                         b = tracer.at(facet.nodes[2]) - tracer.at(facet.nodes[0]);
      area.push_back((area.empty() ? 0 : area.back()) + cross_product_3d(a, b).norm());
    }
    std::string points;
    for (int f = 0; f < parameters_.fascicles; ++f) {
      const double wanted = area.back() * (f + 0.5) / parameters_.fascicles;
      const auto i =
          static_cast<std::size_t>(std::lower_bound(area.begin(), area.end(), wanted) - area.begin());
      const MeshFile::Facet& facet = from.facets[i];
      const double before = i > 0 ? area[i - 1] : 0, s = std::sqrt((wanted - before) / (area[i] - before)),
                   t = std::fmod(0.5 + 0.618034 * f, 1.0);
      const Point<3> seed = tracer.at(facet.nodes[0]) * (1 - s) + tracer.at(facet.nodes[1]) * (s * (1 - t)) +
                            tracer.at(facet.nodes[2]) * (s * t);
      Point<3> middle;
      const auto& cell = file_.cells[facet.cell];
      for (int a = 0; a < n_corners(cell.shape); ++a)
        middle += tracer.at(cell.nodes[static_cast<std::size_t>(a)]) / n_corners(cell.shape);
      Point<3> x = seed + 1e-3 * (middle - seed);
      Tracer::Found here, there;
      if (!tracer.locate(x, here)) continue;
      const std::size_t segments_before = segments.size(), text_before = points.size();
      const auto note = [&](const Point<3>& p) {
        points += std::to_string(f);
        for (unsigned k = 0; k < 3; ++k) points += number(",%.7g", p[k]);
        points += "\n";
      };
      note(x);
      bool at_end = false;
      int turned = 0;
      for (int n = 0; n < 100000 && !at_end && turned < 500; ++n) {
        const double h = 0.3 * tracer.size(here);
        Tensor<1, 3> d = tracer.direction(here);
        if (tracer.locate(x + h / 2 * d, there)) d = tracer.direction(there);
        Point<3> next = x + h * d;
        if (!tracer.locate(next, there)) {
          double inside = 0, outside = 1;
          for (int k = 0; k < 30; ++k) {
            const double part = (inside + outside) / 2;
            (tracer.locate(x + part * h * d, there) ? inside : outside) = part;
          }
          next = x + inside * h * d;
          at_end = tracer.touches(next, is_end);
          if (!at_end && inside < 0.1) {  // along the surface
            ++turned;
            Tensor<1, 3> inward = tracer.middle(here) - x;
            inward /= std::max(inward.norm(), 1e-300);
            double w = 0.25;
            do {
              next = x + h / 4 * (d + w * inward) / (d + w * inward).norm();
              w *= 2;
            } while (!tracer.locate(next, there) && w < 1000);
          }
          if (!tracer.locate(next, there)) break;
        }
        Segment segment{f, 0, {}, {}};
        Tracer::Found half;
        const Point<3> m = x + (next - x) / 2;
        segment.cell = tracer.cell(tracer.locate(m, half) ? half : here);
        for (unsigned k = 0; k < 3; ++k) {
          segment.middle[k] = m[k];
          segment.dX[k] = next[k] - x[k];
        }
        segments.push_back(segment);
        x = next;
        here = there;
        note(x);
      }
      arrived += at_end;
      if (!at_end) {  // lost at the surface: it is no fascicle
        segments.resize(segments_before);
        points.resize(text_before);
      }
    }
    common::write_file(parameters_.folder + "/streamlines.csv", "fascicle,x,y,z\n" + points);
  });
  arrived = Utilities::MPI::broadcast(comm_, arrived);
  n_fascicles_ = parameters_.fascicles;
  found_["fascicles"] = n_fascicles_;
  found_["fascicles_arrived"] = arrived;
  say("fascicles: " + std::to_string(arrived) + " of " + std::to_string(n_fascicles_) +
      " streamlines come from " + from.name + " to " + to.name);
  std::uint64_t n = segments.size();
  MPI_Bcast(&n, 1, MPI_UINT64_T, 0, comm_);
  segments.resize(n);
  MPI_Bcast(segments.data(), static_cast<int>(n * sizeof(Segment)), MPI_BYTE, 0, comm_);

  std::map<std::size_t, std::size_t> local;  // cells by their place in the file
  for (std::size_t c = 0; c < cells_.size(); ++c) local[cells_[c]->id().get_coarse_cell_id()] = c;
  std::vector<double> gradients(3 * most_nodes * most_points);
  for (const Segment& segment : segments) {
    const auto found = local.find(segment.cell);
    const auto& cell = file_.cells[segment.cell];
    if (found == local.end() || !materials_[cell.section].grows) continue;
    const std::size_t c = found->second;
    const Point<3> middle(segment.middle[0], segment.middle[1], segment.middle[2]);
    std::size_t q = 0;  // the nearest integration point
    for (std::size_t k = 1; k < static_cast<std::size_t>(n_points(cell.shape)); ++k) {
      if (middle.distance(place(first_point_[c] + k)) < middle.distance(place(first_point_[c] + q))) q = k;
    }
    shape_gradients(cell.shape, X_.data() + 3 * first_node_[c], gradients.data());
    const auto size = static_cast<std::ptrdiff_t>(3 * n_nodes(cell.shape));
    const auto start = gradients.begin() + static_cast<std::ptrdiff_t>(q) * size;
    pieces_.push_back({segment.fascicle,
                       c,
                       first_point_[c] + q,
                       Tensor<1, 3>({segment.dX[0], segment.dX[1], segment.dX[2]}),
                       {start, start + size}});
  }
}

}  // namespace muscle
