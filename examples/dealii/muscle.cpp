#include "muscle.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_simplex_p.h>
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
#include "../common/rows.hpp"

namespace muscle {

using namespace dealii;
namespace abi = myogrowth::abi;

namespace {

constexpr unsigned wedge_index = 0, hex_index = 1, tet_index = 2;  // in the collections
constexpr double never = std::numeric_limits<double>::infinity();

unsigned index_of(const ReferenceCell& cell) {
  return cell == ReferenceCells::Wedge        ? wedge_index
         : cell == ReferenceCells::Hexahedron ? hex_index
                                              : tet_index;
}

Tensor<1, 3> axis_vector(unsigned i) {
  Tensor<1, 3> v;
  v[i] = 1;
  return v;
}

bool has_shape(const MeshFile& file, Shape shape) {
  return std::any_of(file.cells.begin(), file.cells.end(),
                     [&](const MeshFile::Cell& c) { return c.shape == shape; });
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
      file_(parameters.geometry.kind == "file" || parameters.geometry.kind == "mesh"
                ? read_mesh_file(parameters.geometry, comm)
                : MeshFile()),
      mesh_(make_mesh(parameters.geometry, file_, comm)),
      elements_(FESystem<3>(FE_WedgeP<3>(1), 3), FESystem<3>(FE_Q<3>(1), 3),
                FESystem<3>(FE_SimplexP<3>(has_shape(file_, Shape::tet10) ? 2 : 1), 3)),
      mappings_(MappingFE<3>(FE_WedgeP<3>(1)), MappingFE<3>(FE_Q<3>(1)), MappingFE<3>(FE_SimplexP<3>(1))),
      dofs_(*mesh_) {
  if (file_.has_sections) {
    find_materials();
  } else {
    materials_ = {parameters.muscle, parameters.tendon};
  }
  tell_laws();
  if (parameters.volume == Volume::mean_dilatation && has_shape(file_, Shape::tet))
    throw Error(
        "Muscle/Volume = mean dilatation: must be pointwise with tetrahedra of four nodes, which have "
        "one point; Mesh/Degree = 2 has four and does not lock");
  distribute();
  sort_cells();
  if (file_.has_sections) {
    find_attachments();
  } else {
    find_ends();
    find_end_supports();
  }
  start_points();
  find_fibres();
  if (parameters.write_fibres) write_fibres();
  find_regions();
  if (file_.has_sections && parameters.fascicles > 0) trace_fascicles();
  identity_ = identity();
  system_ = parameters.solver == "ML" ? trilinos_system(*unknowns_) : petsc_system(*unknowns_);
  dt_ = parameters.steps == "listed" ? parameters.end : parameters.step;
}

/// A material for every section of the mesh file, in the order of the sections.
void Muscle::find_materials() {
  const auto& given = parameters_.materials;
  for (const std::string& section : file_.sections) {
    const auto found = std::find_if(given.begin(), given.end(),
                                    [&](const Parameters::Material& m) { return m.section == section; });
    if (found != given.end()) {
      materials_.push_back(*found);
    } else if (given.empty() && file_.sections.size() == 1) {
      materials_.push_back(parameters_.muscle);
      materials_.back().section = section;
    } else {
      throw Error(file_.path + ": section " + section +
                  " has no material: Materials/List must say 'muscle' or 'tendon' for it");
    }
  }
  for (const auto& m : given) {
    if (std::find(file_.sections.begin(), file_.sections.end(), m.section) == file_.sections.end())
      throw Error("Materials/List: there is no section " + common::visible(m.section) + " in " + file_.path);
  }
}

/// Which elastic laws there are beside law 0, with all their constants, and what is said in vain.
void Muscle::tell_laws() const {
  for (const Parameters::Material& m : materials_) {
    if (m.elastic.law == abi::Law::neo_hookean) continue;
    const abi::LawParameters& table = abi::parameters_of(m.elastic.law);
    std::string text = m.section + ": elastic law " + std::to_string(static_cast<int>(m.elastic.law)) + " (" +
                       table.name + ")";
    for (int i = 0; i < table.size; ++i)
      text += std::string(i ? ", " : ": ") + table.entry[i].symbol + " = " + common::text_of(m.elastic.p[i]);
    if (m.grows) text += "; activation " + common::text_of(m.activation.rows().back().second) + " in the end";
    say(text);
  }
  for (const std::string& note : parameters_.notes) say(note);
}

void Muscle::distribute() {
  for (const auto& cell : dofs_.active_cell_iterators()) {
    if (cell->is_locally_owned()) {
      cell->set_active_fe_index(index_of(cell->reference_cell()));
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

/// One material after the other, in each hexahedra before wedges before tetrahedra: a group has one law and
/// one shape.
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
  support_of_.assign((u_.locally_owned_size() + u_.get_partitioner()->n_ghost_indices()) / 3, -1);
  node_X_.resize(3 * support_of_.size());
  const auto shape_of = [&](const auto& cell) {
    return cell->active_fe_index() == hex_index     ? Shape::hex
           : cell->active_fe_index() == wedge_index ? Shape::wedge
           : elements_[tet_index].degree == 2       ? Shape::tet10
                                                    : Shape::tet;
  };
  const auto material_of = [&](const auto& cell) -> std::size_t {
    if (file_.has_sections) return file_.cells[cell->id().get_coarse_cell_id()].section;
    const double z = cell->center()[2];
    return std::min(z - proximal_.z, distal_.z - z) < parameters_.tendon_length;
  };
  std::size_t points = 0;
  std::vector<types::global_dof_index> indices;
  for (std::size_t material = 0; material < materials_.size(); ++material) {
    for (const Shape shape : all_shapes) {
      Group group{shape, material, cells_.size(), 0, points};
      for (const auto& cell : dofs_.active_cell_iterators()) {
        if (!cell->is_locally_owned() || shape_of(cell) != shape || material_of(cell) != material) continue;
        first_node_.push_back(X_.size() / 3);
        first_point_.push_back(points);
        const auto& fe = cell->get_fe();
        indices.resize(fe.n_dofs_per_cell());
        cell->get_dof_indices(indices);
        std::vector<unsigned> nodes;
        for (unsigned a = 0; a < static_cast<unsigned>(n_nodes(shape)); ++a) {
          // Corners come first in deal.II too, and edges in the same order as in C3D10.
          const bool corner = a < static_cast<unsigned>(n_corners(shape));
          const unsigned v = corner ? vertex(shape, a) : a;
          nodes.push_back(u_.get_partitioner()->global_to_local(indices[fe.component_to_system_index(0, v)]));
          Point<3> X = corner ? cell->vertex(v) : Point<3>();
          if (!file_.cells.empty()) {
            const auto& from = file_.cells[cell->id().get_coarse_cell_id()];
            const MeshFile::Place& p = file_.nodes[from.nodes[a]];
            const Point<3> in_file(p[0], p[1], p[2]);
            AssertThrow(!corner || in_file == X, ExcInternalError());
            X = in_file;
          }
          for (unsigned i = 0; i < 3; ++i) {
            X_.push_back(X[i]);
            node_X_[nodes.back() + i] = X[i];
          }
          if (nodes.back() < unknowns_->owned.n_elements()) unknowns_->places[nodes.back() / 3] = X;
        }
        unknowns_->cell_nodes.push_back(nodes);
        cells_.push_back(cell);
        points += static_cast<std::size_t>(n_points(shape));
      }
      group.n = cells_.size() - group.first_cell;
      if (group.n > 0) groups_.push_back(group);
    }
  }
  const auto stiff = Utilities::MPI::sum(groups_.empty() || grows(groups_.back()) ? 0u : 1u, comm_);
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
    double area = 0, gap = 0, elsewhere = 0, farthest = 0;
    for (const auto& cell : cells_) {
      for (const unsigned f : cell->face_indices()) {
        const auto face = cell->face(f);
        if (!face->at_boundary()) continue;
        const unsigned n = face->n_vertices();
        unsigned held = 0;
        for (unsigned v = 0; v < n; ++v) held += end->has(face->vertex(v)[2]);
        const Tensor<1, 3> normal =
            n == 4 ? cross_product_3d(face->vertex(3) - face->vertex(0), face->vertex(2) - face->vertex(1))
                   : cross_product_3d(face->vertex(1) - face->vertex(0), face->vertex(2) - face->vertex(0));
        if (held == n) {
          area += normal.norm() / 2;
          for (unsigned v = 0; v < n; ++v) faces(face->vertex_dof_index(v, 0, cell->active_fe_index())) += 1;
        } else if (std::abs(normal[2]) > same_way * normal.norm() &&
                   (face->center()[2] - cell->center()[2]) * end->toward > 0) {
          (held > 0 ? gap : elsewhere) += normal.norm() / 2;
          for (unsigned v = 0; v < n && held > 0; ++v)
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
    elsewhere = Utilities::MPI::sum(elsewhere, comm_);
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
    // An end at two heights, or of several parts: the rest of it is free.
    say(elsewhere > 0
            ? text + "; an area of " + number("%.7g", elsewhere) + " that faces the same way lies elsewhere"
            : text);
  }
}

void Muscle::find_end_supports() {
  const auto& nodes = unknowns_->cell_nodes;
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
  Attachment still, moved;
  moved.action.kind = Action::displaced;
  moved.action.table = TimeTable({{0, 0}, {parameters_.ramp, 1}});
  moved.vector[2] = parameters_.pull;
  attachments_ = {still, moved};
  proximal_attachment_ = 0;
  distal_attachment_ = 1;
  line_[2] = 1;
  line_length_ = distal_.z - proximal_.z;
  proximal_start_[2] = proximal_.z;
  attachments_[0].action.surface = proximal_.name;
  attachments_[1].action.surface = distal_.name;
  cell_supported_.assign(cells_.size(), 0);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (std::size_t a = 0; a < nodes[c].size(); ++a) {
      const double* X = X_.data() + 3 * (first_node_[c] + a);
      const bool at_proximal = proximal_.has(X[2]), at_distal = distal_.has(X[2]);
      std::array<bool, 3> held = {{false, false, at_proximal || at_distal}};
      if ((at_proximal && clamp_proximal) || (at_distal && clamp_distal)) held[0] = held[1] = true;
      if (!clamp_proximal && std::equal(X, X + 3, axis.begin())) held[0] = held[1] = true;
      if (!clamp_proximal && std::equal(X, X + 3, far.begin())) held[1] = true;
      if (!held[0] && !held[1] && !held[2]) continue;
      cell_supported_[c] = true;
      if (support_of_[nodes[c][a] / 3] >= 0) continue;
      support_of_[nodes[c][a] / 3] = static_cast<int>(supports_.size());
      Support support;
      for (unsigned i = 0; i < 3; ++i) {
        if (held[i]) support.add(axis_vector(i), at_distal ? 1 : at_proximal ? 0 : -1);
      }
      supports_.push_back(support);
    }
  }
  support_step_.assign(node_X_.size(), 0);
}

/// The nodes of a facet as nodes of its cell, those between its corners included.
std::vector<unsigned> Muscle::cell_nodes_of(const MeshFile::Facet& facet) const {
  const MeshFile::Cell& cell = file_.cells[facet.cell];
  std::vector<unsigned> nodes;
  for (unsigned k = 0; k < facet.n; ++k) {
    const auto found = std::find(cell.nodes.begin(), cell.nodes.end(), facet.nodes[k]);
    nodes.push_back(static_cast<unsigned>(found - cell.nodes.begin()));
  }
  for (unsigned k = 0; k < 3 && cell.shape == Shape::tet10; ++k) {
    for (unsigned e = 0; e < 6; ++e) {
      if (std::minmax<unsigned>(nodes[k], nodes[(k + 1) % 3]) ==
          std::minmax(static_cast<unsigned>(tet_edges[e][0]), static_cast<unsigned>(tet_edges[e][1])))
        nodes.push_back(4 + e);
    }
  }
  return nodes;
}

/// The surfaces of the mesh file to which something happens; told, and refused where they cannot be.
void Muscle::find_attachments() {
  const auto& given = parameters_.attachments;
  std::vector<Action> actions = given.actions;
  const TimeTable ramp({{0, 0}, {parameters_.ramp, 1}});
  if (actions.empty()) {
    Action fixed, away;
    fixed.surface = given.proximal;
    away.surface = given.distal;
    away.kind = Action::away;
    away.amount = 0.1;
    away.table = ramp;
    actions = {fixed, away};
  }
  const auto find = [&](const std::string& name, const std::string& entry) {
    const MeshFile::Surface* found = file_.surface(name);
    if (found == nullptr)
      throw Error(entry + ": there is no surface " + common::visible(name) + " in " + file_.path +
                  "; there are: " + file_.surface_names());
    if (found->facets.empty())
      throw Error(entry + ": surface " + common::visible(name) + " in " + file_.path + " has no facets");
    return found;
  };
  // Area, centroid, mean outward normal; sign of a facet's d1 x d2.
  const auto sign_of = [&](const MeshFile::Facet& facet, const std::vector<unsigned>& nodes) {
    const MeshFile::Cell& cell = file_.cells[facet.cell];
    const auto X = [&](unsigned a) {
      const MeshFile::Place& p = file_.nodes[cell.nodes[a]];
      return Point<3>(p[0], p[1], p[2]);
    };
    Point<3> middle;
    for (int a = 0; a < n_corners(cell.shape); ++a)
      middle += X(static_cast<unsigned>(a)) / n_corners(cell.shape);
    const Tensor<1, 3> normal = cross_product_3d(X(nodes[1]) - X(nodes[0]), X(nodes[2]) - X(nodes[0]));
    return normal * (X(nodes[0]) - middle) > 0 ? 1. : -1.;
  };
  const auto measure = [&](const MeshFile::Surface& surface) {
    Attachment a;
    for (const MeshFile::Facet& facet : surface.facets) {
      const auto nodes = cell_nodes_of(facet);
      const double sign = sign_of(facet, nodes);
      for (const FacetPoint& q : facet_points(static_cast<unsigned>(nodes.size()))) {
        Tensor<1, 3> x, x1, x2;
        for (std::size_t k = 0; k < nodes.size(); ++k) {
          const MeshFile::Place& p = file_.nodes[file_.cells[facet.cell].nodes[nodes[k]]];
          const Tensor<1, 3> X({p[0], p[1], p[2]});
          x += q.N[k] * X;
          x1 += q.d1[k] * X;
          x2 += q.d2[k] * X;
        }
        const Tensor<1, 3> n = q.weight * sign * cross_product_3d(x1, x2);
        a.area += n.norm();
        a.normal += n;
        a.centroid += n.norm() * x;
      }
    }
    a.centroid /= a.area;
    a.normal /= a.area;
    return a;
  };
  const Attachment from = measure(*find(given.proximal, "Attachments/Proximal")),
                   to = measure(*find(given.distal, "Attachments/Distal"));
  proximal_start_ = from.centroid;
  line_ = to.centroid - from.centroid;
  line_length_ = line_.norm();
  if (!(line_length_ > 0))
    throw Error("Attachments: the centroids of " + given.proximal + " and " + given.distal +
                " are at one place");
  line_ /= line_length_;

  std::vector<std::vector<int>> of_node(file_.nodes.size());
  std::map<std::size_t, std::vector<std::pair<int, const MeshFile::Facet*>>> loaded;
  bool held = false;
  const auto slides = [](const Action& action) {
    return action.kind == Action::slides || action.kind == Action::slides_away;
  };
  for (const Action& action : actions) {
    const MeshFile::Surface& surface = *find(action.surface, "Attachments/List");
    Attachment a = measure(surface);
    a.action = action;
    const int index = static_cast<int>(attachments_.size());
    const auto nodes = file_.nodes_of(surface);
    a.nodes = static_cast<unsigned>(nodes.size());
    if (slides(action) && !(a.normal.norm() > 0.1))
      throw Error("Attachments/List: " + action.surface +
                  " cannot slide in its plane: it has none, its normals point to all sides");
    a.normal /= std::max(a.normal.norm(), 1e-300);
    for (const unsigned node : nodes) {
      for (const int before : of_node[node]) {
        const Attachment& other = attachments_[static_cast<std::size_t>(before)];
        // Forces may act where something else holds, and planes of symmetry may meet, at right angles.
        const bool may_touch =
            !action.holds() || !other.action.holds() ||
            (slides(action) && slides(other.action) && std::abs(a.normal * other.normal) < 1e-8);
        if (!may_touch)
          throw Error("Attachments: " + other.action.surface + " and " + action.surface + " touch, at " +
                      file_.node(node) + "; only surfaces that slide, at right angles, may");
      }
      of_node[node].push_back(index);
    }
    held = held || (action.holds() && !slides(action));
    if (surface.name == given.proximal) proximal_attachment_ = index;
    if (surface.name == given.distal) distal_attachment_ = index;
    const double toward = surface.name == given.proximal ? -1 : 1;
    const bool stretches = action.kind == Action::away || action.kind == Action::slides_away;
    if (!given.protocol.empty() && stretches) {
      if (action.own_table)
        throw Error("Attachments/List: " + action.surface + ": must have no 'at' with Attachments/Protocol");
      a.action.table = given.stretching;
      a.vector = toward * line_length_ * line_;
    } else {
      a.vector = stretches                       ? toward * action.amount * line_length_ * line_
                 : action.kind == Action::slides ? action.amount * a.normal
                                                 : action.vector;
    }
    if (!action.holds()) {
      for (const MeshFile::Facet& facet : surface.facets) loaded[facet.cell].emplace_back(index, &facet);
    }
    static const char* const words[] = {"fixed",  "displaced", "displaced away", "turned",
                                        "slides", "slides",    "pulled",         "pressed"};
    say("attachment " + action.surface + ": " + words[action.kind] + ", " + std::to_string(a.nodes) +
        " nodes, area " + number("%.7g", a.area));
    attachments_.push_back(a);
  }
  // Three planes across each other hold it too.
  for (const Attachment& a : attachments_) {
    for (const Attachment& b : attachments_) {
      for (const Attachment& c : attachments_)
        held = held || (slides(a.action) && slides(b.action) && slides(c.action) &&
                        std::abs(a.normal * cross_product_3d(b.normal, c.normal)) > 0.1);
    }
  }
  if (!held)
    throw Error(
        "Attachments/List: must have an attachment that is fixed, displaced, away or turned, or three that "
        "slide in planes across each other: nothing else holds the muscle in its place");
  bool any_stretch = false;
  for (const Attachment& a : attachments_)
    any_stretch = any_stretch || a.action.kind == Action::away || a.action.kind == Action::slides_away;
  if (!given.protocol.empty() && !any_stretch)
    throw Error(
        "Attachments/Protocol: needs an attachment that is 'away' or 'slides away' in Attachments/List");
  say("attachments " + given.proximal + " and " + given.distal + ": " + number("%.7g", line_length_) +
      " apart, between the centroids of their areas");

  cell_supported_.assign(cells_.size(), 0);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const std::size_t in_file = cells_[c]->id().get_coarse_cell_id();
    const auto& nodes = unknowns_->cell_nodes[c];
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      Support support;
      for (const int index : of_node[file_.cells[in_file].nodes[a]]) {
        const Attachment& attachment = attachments_[static_cast<std::size_t>(index)];
        if (slides(attachment.action)) support.add(attachment.normal, index);
        for (unsigned i = 0; i < 3 && attachment.action.holds() && !slides(attachment.action); ++i)
          support.add(axis_vector(i), index);
      }
      if (support.n == 0) continue;
      cell_supported_[c] = true;
      if (support_of_[nodes[a] / 3] >= 0) continue;
      support_of_[nodes[a] / 3] = static_cast<int>(supports_.size());
      supports_.push_back(support);
    }
    const auto facets = loaded.find(in_file);
    if (facets == loaded.end()) continue;
    for (const auto& facet : facets->second) {
      const auto of_cell = cell_nodes_of(*facet.second);
      loads_[c].push_back({static_cast<std::size_t>(facet.first), of_cell, sign_of(*facet.second, of_cell)});
    }
  }
  support_step_.assign(node_X_.size(), 0);
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
  // Forces below this are rounding, where nothing is loaded. The stiffness of laws 1 to 3 is that at rest.
  double stiffness = parameters_.muscle.law.c2;
  for (const Parameters::Material& m : materials_) {
    if (m.elastic.law == abi::Law::neo_hookean) continue;
    abi::with_other_law(m.law, m.elastic, [&](auto& u, const auto& material, double activation) {
      const double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, n0[3] = {0, 0, 1};
      const auto status = myogrowth::update_point(material, F, n0, 1., 1., 0., u, activation);
      for (const double c : u.elastic) stiffness = std::max(stiffness, std::abs(c));
      return status;
    });
  }
  force_floor_ = 1e-14 * stiffness * std::pow(Utilities::MPI::sum(volume, comm_), 2. / 3);
}

std::string Muscle::describe(const Group& group, const Failure& failure, double dt) const {
  const std::size_t c = group.first_cell + static_cast<std::size_t>(failure.cell);
  const std::size_t p = first_point_[c] + static_cast<std::size_t>(failure.point);
  const auto status = abi::with_material(
      material(group), elastic(group), [&](auto& u, const auto& m, const auto&... activation) {
        return myogrowth::update_point(m, failure.F, n0_.data() + 3 * p, G_n_[p], lambda_n_[p], dt, u,
                                       activation...);
      });
  std::ostringstream text;
  const CellId id = cells_[c]->id();
  text << "no result (" << myogrowth::abi::text(status) << ") in " << name_of(group.shape) << ' '
       << (file_.cells.empty() ? id.to_string() : std::to_string(file_.cells[id.get_coarse_cell_id()].label))
       << ", point " << failure.point + 1 << " at (" << places_[3 * p] << ", " << places_[3 * p + 1] << ", "
       << places_[3 * p + 2] << "), G = " << G_n_[p] << ", F = [";
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) text << failure.F[i + 3 * j] << (j < 2 ? " " : i < 2 ? "; " : "]");
  }
  return text.str();
}

/// What the supports have to go until `time`; where u_ has got there it is zero.
void Muscle::prepare_supports(double time, double part) {
  load_time_ = time;
  load_part_ = part;
  std::vector<double> factors;
  for (const Attachment& a : attachments_) factors.push_back(a.action.table.at(time, part));
  for (unsigned node = 0; node < support_of_.size(); ++node) {
    if (support_of_[node] < 0) continue;
    const Support& support = supports_[static_cast<std::size_t>(support_of_[node])];
    Tensor<1, 3> u, step;
    for (unsigned i = 0; i < 3; ++i) u[i] = u_.local_element(3 * node + i);
    for (unsigned d = 0; d < support.n; ++d) {
      Tensor<1, 3> target;
      if (support.attachment[d] >= 0) {
        const auto index = static_cast<std::size_t>(support.attachment[d]);
        const Attachment& a = attachments_[index];
        target = factors[index] * a.vector;
        if (a.action.kind == Action::turned) {  // Rodrigues
          const double angle = factors[index] * a.action.amount;
          const Point<3> X(node_X_[3 * node], node_X_[3 * node + 1], node_X_[3 * node + 2]);
          const Tensor<1, 3> arm = X - a.action.point, across = cross_product_3d(a.action.axis, arm);
          const double half = std::sin(angle / 2);
          target = std::sin(angle) * across + 2 * half * half * cross_product_3d(a.action.axis, across);
        }
      }
      step += support.along[d] * (support.along[d] * (target - u));
    }
    for (unsigned i = 0; i < 3; ++i) support_step_[3 * node + i] = step[i];
  }
  if (!parameters_.dense) return;
  constraints_.clear();
  constraints_.reinit(unknowns_->relevant);
  for (unsigned k = 0; k < node_X_.size(); ++k) {
    if (support_of_[k / 3] < 0) continue;
    const Support& support = supports_[static_cast<std::size_t>(support_of_[k / 3])];
    Tensor<1, 3> along;
    along[k % 3] = 1;
    if (support.held(along).norm() == 0) continue;
    const auto index = u_.get_partitioner()->local_to_global(k);
    constraints_.add_line(index);
    constraints_.set_inhomogeneity(index, support_step_[k]);
  }
  constraints_.close();
}

/// Takes the supported directions out of the matrix of a cell; what they do to the others goes to the right
/// side. With S the projection onto the supported directions of a node and P = I - S its rows and columns
/// become P K, K P and, on the diagonal, P K P + s S.
void Muscle::take_supports(const Group& group, std::size_t cell, double* K) {
  const std::vector<unsigned>& nodes = unknowns_->cell_nodes[cell];
  const auto n = nodes.size(), dofs = 3 * n;
  (void)group;
  std::array<double, 3 * most_nodes> step{};
  for (std::size_t j = 0; j < dofs; ++j) step[j] = support_step_[nodes[j / 3] + j % 3];
  for (std::size_t i = 0; i < dofs; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < dofs; ++j) sum += K[dofs * i + j] * step[j];
    rhs_.local_element(nodes[i / 3] + static_cast<unsigned>(i % 3)) -=
        sum;  // supported ones are taken out later
  }
  for (std::size_t b = 0; b < n; ++b) {
    const int index = support_of_[nodes[b] / 3];
    if (index < 0) continue;
    const Support& support = supports_[static_cast<std::size_t>(index)];
    double scale = 0;
    for (std::size_t i = 0; i < 3; ++i) scale += std::abs(K[(dofs + 1) * (3 * b + i)]) / 3;
    const auto project = [&](double* first, std::size_t stride) {
      Tensor<1, 3> x({first[0], first[stride], first[2 * stride]});
      x -= support.held(x);
      for (unsigned i = 0; i < 3; ++i) first[i * stride] = x[i];
    };
    for (std::size_t i = 0; i < dofs; ++i) project(K + dofs * i + 3 * b, 1);
    for (std::size_t j = 0; j < dofs; ++j) project(K + dofs * 3 * b + j, dofs);
    for (std::size_t j = 0; j < 3; ++j) {
      Tensor<1, 3> axis;
      axis[static_cast<unsigned>(j)] = 1;
      axis = support.held(axis);
      for (std::size_t i = 0; i < 3; ++i)
        K[dofs * (3 * b + i) + 3 * b + j] += scale * axis[static_cast<unsigned>(i)];
    }
  }
}

/// Subtracts the forces on the facets of a cell from its residual, and their derivatives from its stiffness.
void Muscle::add_loads(std::size_t cell, const double* u, double* R, double* K) {
  const auto found = loads_.find(cell);
  if (found == loads_.end()) return;
  const std::size_t dofs = 3 * unknowns_->cell_nodes[cell].size();
  for (const LoadedFacet& facet : found->second) {
    Attachment& a = attachments_[facet.attachment];
    const double factor = a.action.table.at(load_time_, load_part_) / a.area;
    const bool dead = a.action.kind == Action::pulled;
    const std::size_t n = facet.nodes.size();
    for (const FacetPoint& q : facet_points(static_cast<unsigned>(n))) {
      Tensor<1, 3> x1, x2;
      for (std::size_t k = 0; k < n; ++k) {
        for (unsigned i = 0; i < 3; ++i) {
          const double x =
              X_[3 * (first_node_[cell] + facet.nodes[k]) + i] + (dead ? 0 : u[3 * facet.nodes[k] + i]);
          x1[i] += q.d1[k] * x;
          x2[i] += q.d2[k] * x;
        }
      }
      const Tensor<1, 3> normal = facet.sign * cross_product_3d(x1, x2);
      const double pressure = q.weight * factor * a.action.amount;
      const Tensor<1, 3> force = dead ? q.weight * factor * normal.norm() * a.vector : pressure * normal;
      a.force += force;
      for (std::size_t k = 0; k < n; ++k) {
        for (unsigned i = 0; i < 3; ++i) R[3 * facet.nodes[k] + i] -= q.N[k] * force[i];
      }
      if (K == nullptr || dead) continue;
      for (std::size_t b = 0; b < n; ++b) {
        for (unsigned j = 0; j < 3; ++j) {
          Tensor<1, 3> axis;
          axis[j] = 1;
          const Tensor<1, 3> change =
              pressure * facet.sign *
              (q.d1[b] * cross_product_3d(axis, x2) + q.d2[b] * cross_product_3d(x1, axis));
          for (std::size_t k = 0; k < n; ++k) {
            for (unsigned i = 0; i < 3; ++i)
              K[dofs * (3 * facet.nodes[k] + i) + 3 * facet.nodes[b] + j] -= q.N[k] * change[i];
          }
        }
      }
    }
  }
}

/// The forces out of balance at u_, their norms and the reaction; with the tangent also the matrix and the
/// right side. Returns what was wrong at a point of any rank.
std::string Muscle::assemble(double dt, bool tangent) {
  ++costs_.checks;
  residual_ = 0;
  for (Attachment& a : attachments_) a.force = Tensor<1, 3>();
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
  std::array<double, 2> sums = {{0, 0}};  // of free and of supported directions
  for (unsigned node = 0; 3 * node < u_.locally_owned_size(); ++node) {
    Tensor<1, 3> r, b, held;
    for (unsigned i = 0; i < 3; ++i) {
      r[i] = residual_.local_element(3 * node + i);
      b[i] = rhs_.local_element(3 * node + i) - r[i];
    }
    if (support_of_[node] >= 0) {
      const Support& support = supports_[static_cast<std::size_t>(support_of_[node])];
      held = support.held(r);
      b -= support.held(b);
      for (unsigned d = 0; d < support.n; ++d) {
        if (support.attachment[d] >= 0)
          attachments_[static_cast<std::size_t>(support.attachment[d])].force +=
              support.along[d] * (support.along[d] * r);
      }
    }
    sums[0] += (r - held).norm_square();
    sums[1] += held.norm_square();
    if (tangent && !parameters_.dense) {
      for (unsigned i = 0; i < 3; ++i) rhs_.local_element(3 * node + i) = b[i];
    }
  }
  free_norm_ = std::sqrt(Utilities::MPI::sum(sums[0], comm_));
  support_norm_ = std::sqrt(Utilities::MPI::sum(sums[1], comm_));
  for (Attachment& a : attachments_) a.force = Utilities::MPI::sum(a.force, comm_);
  reaction_ =
      distal_attachment_ < 0 ? 0 : attachments_[static_cast<std::size_t>(distal_attachment_)].force * line_;
  return {};
}

std::string Muscle::assemble_compact(double dt, bool tangent) {
  constexpr std::size_t block = 64;  // points: what Elements takes through the law at once
  std::vector<double> u, R, K, scalars;
  for (const Group& group : groups_) {
    const auto nodes = static_cast<std::size_t>(n_nodes(group.shape)),
               points = static_cast<std::size_t>(n_points(group.shape));
    const std::size_t dofs = 3 * nodes, most = block / points;
    Elements elements(material(group), parameters_.volume, elastic(group));
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
        if (!loads_.empty())
          add_loads(cell + c, u.data() + dofs * c, R.data() + dofs * c,
                    tangent ? K.data() + dofs * dofs * c : nullptr);
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
        Eigen::Matrix3d P;
        Eigen::Matrix<double, 9, 9> A;
        const auto status = abi::with_material(
            material(group), elastic(group), [&](auto&, const auto& m, const auto&... activation) {
              const auto step = myogrowth::update(m, F, state, dt, activation...);
              P = step.first_piola();
              A = step.dP_dF();
              G_[p] = step.state.G;
              lambda_e_[p] = step.point.lambda_e;
              lambda_[p] = step.point.lambda;
              J_[p] = step.point.J;
              Je_[p] = step.point.Je;
              return step.point.status;
            });
        costs_.law += cpu_seconds() - law_start;
        if (status != myogrowth::UpdateStatus::ok) {
          Failure failure;
          failure.cell = static_cast<int>(c - group.first_cell);
          failure.point = static_cast<int>(q);
          std::copy(F.data(), F.data() + 9, failure.F);
          return describe(group, failure, dt);
        }
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

/// u_ moves by the solution of the linear system; |rhs| below `target` need not be gone into. After the first
/// iteration Newton's method may end with this solve: it gets the digits that are missing.
void Muscle::solve(double target, bool first) {
  const double rhs = rhs_.l2_norm();
  const double tolerance =
      std::max((first ? 1 : 0.01) * parameters_.krylov_tolerance, std::min(0.1, 0.1 * target / rhs));
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

/// G's mean over the volume of the muscle, at the begin of the step.
double Muscle::mean_G() const {
  double sums[2] = {0, 0};
  for (const Group& group : groups_) {
    const std::size_t n = !grows(group) ? 0 : group.n * static_cast<std::size_t>(n_points(group.shape));
    for (std::size_t p = group.first_point; p < group.first_point + n; ++p) {
      sums[0] += volumes_[p] * G_n_[p];
      sums[1] += volumes_[p];
    }
  }
  for (double& x : sums) x = Utilities::MPI::sum(x, comm_);
  return sums[1] > 0 ? sums[0] / sums[1] : 1;
}

/// How much mean G will change in a step, by its rates in the last two: one over the rate is linear in time,
/// as in a relaxation. 0 where this says nothing.
double Muscle::growth_in(double dt) const {
  if (before_.size() < 2) return 0;
  const double t0 = time_, t1 = before_[0].time, t2 = before_[1].time;
  const double last = mean_G_ - before_[0].G, earlier = before_[0].G - before_[1].G;
  if (!(last * earlier > 0)) return 0;
  const double inverse =
      (t0 - t1) / last + ((t0 - t1) / last - (t1 - t2) / earlier) * (dt + t0 - t1) / (t0 - t2);
  const double growth = dt / inverse;
  // A rate that more than doubles is none of a relaxation; short steps before a long one say too little.
  const bool good = inverse * last > 0.5 * (t0 - t1) && std::min(last / growth, earlier / growth) > 0.05 &&
                    std::abs(growth) > 1e-7;
  return good ? growth : 0;
}

/// u_ at the end of a step, as the parabola through the last three displacements has it: over time while the
/// attachments move, over the mean of G while they hold, since then only growth moves the nodes.
void Muscle::predict(double dt) {
  const std::size_t n = std::min<std::size_t>(before_.size(), 2);
  if (!parameters_.predict || n == 0 || dt == 0) return;
  const auto all = tables();
  const bool held = std::none_of(all.begin(), all.end(),
                                 [&](const TimeTable* table) { return table->changing_for(time_) < never; });
  const double growth = held ? growth_in(dt) : 0;
  const bool by_growth = growth != 0;
  std::vector<double> at{by_growth ? mean_G_ : time_};
  for (std::size_t k = 0; k < n; ++k) at.push_back(by_growth ? before_[k].G : before_[k].time);
  const double to = at[0] + (by_growth ? growth : dt);
  const auto weight = [&](std::size_t k) {
    double w = 1;
    for (std::size_t m = 0; m < at.size(); ++m) {
      if (m != k) w *= (to - at[m]) / (at[k] - at[m]);
    }
    return w;
  };
  u_ *= weight(0);
  for (std::size_t k = 0; k < n; ++k) u_.add(weight(k + 1), before_[k].u);
  u_.update_ghost_values();
}

Muscle::Attempt Muscle::step(double dt, double part) {
  if (parameters_.set_up_every_step) fresh_iterations_ = -1;
  predict(dt);
  prepare_supports(time_ + dt, part);
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
    const double target = std::max(parameters_.newton_tolerance * support_norm_, force_floor_);
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
    solve(target, iteration == 0);
    if (last_iterations_ < 0) return {false, "GMRES did not converge"};
    ++costs_.newton;
    for (unsigned node = 0; 3 * node < u_.locally_owned_size(); ++node) {
      Tensor<1, 3> x;
      for (unsigned i = 0; i < 3; ++i) x[i] = x_.local_element(3 * node + i);
      if (support_of_[node] >= 0) x -= supports_[static_cast<std::size_t>(support_of_[node])].held(x);
      for (unsigned i = 0; i < 3; ++i) u_.local_element(3 * node + i) += x[i] + support_step_[3 * node + i];
    }
    u_.update_ghost_values();
    prepare_supports(time_ + dt, part);
  }
}

/// The largest time error of G over the muscle's points, as the library estimates it.
double Muscle::time_error(double dt) const {
  const bool first_order = parameters_.muscle.law.integration == myogrowth::TimeIntegration::backward_euler;
  double worst = 0;
  for (const Group& group : groups_) {
    if (!grows(group)) continue;
    const auto& law = material(group);
    const std::size_t n = group.n * static_cast<std::size_t>(n_points(group.shape));
    for (std::size_t p = group.first_point; p < group.first_point + n; ++p) {
      const double error = first_order ? myogrowth::time_error_of_backward_euler(
                                             law.growth, law.removal, G_n_[p], lambda_n_[p], lambda_[p], dt)
                                       : myogrowth::time_error_of_midpoint_flow(
                                             law.growth, law.removal, G_n_[p], lambda_n_[p], lambda_[p], dt);
      worst = std::max(worst, error);
    }
  }
  return Utilities::MPI::max(worst, comm_);
}

void Muscle::commit(double dt) {
  before_.insert(before_.begin(), {time_, mean_G_, u_n_});
  if (before_.size() > 2) before_.pop_back();
  time_ += dt;
  G_n_ = G_;
  mean_G_ = mean_G();
  lambda_n_ = lambda_;
  u_n_ = u_;
  ++costs_.steps;
}

/// What moves or activates the muscle over time.
std::vector<const TimeTable*> Muscle::tables() const {
  std::vector<const TimeTable*> all;
  for (const Attachment& a : attachments_) all.push_back(&a.action.table);
  for (const Parameters::Material& m : materials_) all.push_back(&m.activation);
  return all;
}

/// The time at which a step must end: that of the ramp, of an output, of a listed step, of the whole.
double Muscle::next_stop() const {
  double stop = parameters_.end;
  const double now = time_ * (1 + 1e-12) + 1e-300;
  const auto consider = [&](double t) {
    if (t > now) stop = std::min(stop, t);
  };
  for (const TimeTable* table : tables()) consider(table->next_row(time_));
  for (const double t : parameters_.output_times) consider(t);
  for (const double t : parameters_.times) {
    if (parameters_.steps == "listed") consider(t);
  }
  return stop;
}

/// Whether an attachment or an activation jumps now.
bool Muscle::jumps() const {
  const auto all = tables();
  return std::any_of(all.begin(), all.end(), [&](const TimeTable* table) { return table->jumps_at(time_); });
}

/// Takes attachments and activation over a jump, without growth: in one go, or in parts where that is too
/// far. It counts as one step, as it has one row.
void Muscle::jump() {
  const int steps = costs_.steps + 1;
  double done = 0;
  for (double part = 1; done < 1;) {
    const double to = std::min(1.0, done + part);
    const Attempt attempt = step(0, to);
    if (attempt.converged) {
      done = to;
      commit(0);
      continue;
    }
    say("  jump at time " + number("%g", time_) + " is divided: " + attempt.why);
    u_ = u_n_;
    u_.update_ghost_values();
    ++costs_.cuts;
    fresh_iterations_ = -1;
    part /= 2;
    if (part < 1e-3)
      throw Error("no jump is short enough at time " + number("%g", time_) + ": " + attempt.why);
  }
  costs_.steps = steps;
  before_.clear();
  if (parameters_.steps == "adaptive") dt_ = std::min(dt_, parameters_.step);
}

bool Muscle::run(const volatile int& asked_to_end) {
  const double start = MPI_Wtime();
  std::ostringstream sizes;
  sizes << mesh_->n_global_active_cells() << " elements, " << dofs_.n_dofs() << " unknowns, "
        << Utilities::MPI::n_mpi_processes(comm_) << " ranks";
  say(sizes.str());
  if (parameters_.resume) {
    read_checkpoint();
    mean_G_ = mean_G();
    say("resumed at time " + number("%g", time_));
    find_fields();
  } else {
    put_checkpoint_aside();
  }
  start_rows();

  if (!parameters_.resume && jumps()) {
    jump();
    write_rows();
  }
  const double shortest = shortest_step * parameters_.end;
  const double planned = parameters_.steps == "listed" ? parameters_.end : parameters_.step;
  while (time_ < parameters_.end * (1 - 1e-12)) {
    const double step_start = MPI_Wtime(), stop = next_stop();
    const bool adaptive = parameters_.steps == "adaptive";
    double dt = dt_;
    if (adaptive) {
      dt = std::min(dt, parameters_.longest_step);
      for (const TimeTable* table : tables())
        dt = std::min(dt, parameters_.largest_part * table->changing_for(time_));
    }
    const bool to_stop = time_ + dt * 1.000001 >= stop;
    if (to_stop) dt = stop - time_;

    Attempt attempt = step(dt, 0);
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
      if (!time_is_too_long) before_.clear();  // perhaps the prediction has led astray
      if (!time_is_too_long) say("  step of " + number("%g", dt) + " is halved: " + attempt.why);
      dt_ = dt * (time_is_too_long ? factor : 0.5);
      if (dt_ < shortest)
        throw Error("no step is short enough at time " + number("%g", time_) + ": " + attempt.why);
      continue;
    }
    commit(dt);
    if (to_stop) {
      time_ = stop;  // to the last bit
      const auto all = tables();
      const bool row = std::any_of(all.begin(), all.end(), [&](const TimeTable* table) {
        return table->at(stop, 0) != table->at(stop - dt / 2, 0);
      });
      if (row) before_.clear();  // an attachment has come to the end of a way, or an activation
    }
    if (adaptive) {
      dt_ = to_stop ? std::max(dt_, factor * dt) : factor * dt;
    } else {
      dt_ = std::min(planned, 2 * dt_);
    }
    {
      const Clock clock(costs_.output);
      write_rows();
      if (jumps()) {
        jump();
        write_rows();
      }
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
