#include "mesh.hpp"

#include <deal.II/base/function_parser.h>
#include <deal.II/base/mpi.h>
#include <deal.II/distributed/fully_distributed_tria.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/manifold_lib.h>
#include <deal.II/grid/tria_description.h>
#include <deal.II/numerics/rtree.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <sstream>

#include "../common/rows.hpp"
#include "element.hpp"

namespace muscle {
namespace {

using namespace dealii;

std::unique_ptr<Mesh> cylinder(const Parameters::Geometry& geometry, MPI_Comm comm) {
  auto mesh = std::make_unique<parallel::distributed::Triangulation<3>>(comm);
  GridGenerator::subdivided_cylinder(*mesh, static_cast<unsigned>(geometry.layers), geometry.radius,
                                     geometry.length / 2);
  GridTools::transform([&](const Point<3>& p) { return Point<3>(p[1], p[2], p[0] + geometry.length / 2); },
                       *mesh);
  mesh->set_manifold(0, CylindricalManifold<3>(2));
  mesh->refine_global(static_cast<unsigned>(geometry.refinements));
  // The section is a polygon with its corners on the circle. It gets the circle's area.
  const double corners = 4 * std::pow(2, geometry.refinements);
  const double scale = std::sqrt(2 * numbers::PI / (corners * std::sin(2 * numbers::PI / corners)));
  GridTools::transform([&](const Point<3>& p) { return Point<3>(scale * p[0], scale * p[1], p[2]); }, *mesh);
  return mesh;
}

std::unique_ptr<Mesh> brick(const Parameters::Geometry& geometry, MPI_Comm comm) {
  auto mesh = std::make_unique<parallel::distributed::Triangulation<3>>(comm);
  const std::vector<unsigned> cells(geometry.cells.begin(), geometry.cells.end());
  GridGenerator::subdivided_hyper_rectangle(*mesh, cells, Point<3>(),
                                            Point<3>(geometry.width, geometry.height, geometry.length));
  return mesh;
}

/// A mesh as its file has it, the corners of the cells in CalculiX's order.
struct SerialMesh {
  std::vector<Point<3>> nodes;
  std::vector<CellData<3>> cells;
  std::vector<std::size_t> lines;  // of the file: of the nodes, then of the cells

  std::string node(const std::string& path, std::size_t i) const {
    return path + ":" + std::to_string(lines[i]) + ": node " + std::to_string(i);
  }
  std::string cell(const std::string& path, std::size_t i) const {
    return path + ":" + std::to_string(lines[nodes.size() + i]) + ": cell " + std::to_string(i);
  }
};

Shape shape_of(const CellData<3>& cell) { return cell.vertices.size() == 8 ? Shape::hex : Shape::wedge; }

/// "; there are 3 such cells", or nothing for one.
std::string with_others(std::size_t n, const std::string& what) {
  return n > 1 ? "; there are " + std::to_string(n) + " such " + what : "";
}

/// Reads "nodes N" and N rows x y z, then "hexes N" and "wedges N" with rows of nodes, counted from 0.
SerialMesh read_mesh(const std::string& path) {
  common::Rows rows(path, common::Separator::blanks);
  SerialMesh mesh;
  constexpr std::size_t most = std::numeric_limits<int>::max();
  const auto section = [&](const std::string& name, const auto& read_row) {
    const std::size_t n = rows.count(1, "the number of " + name, 0, most);
    rows.ends_after(2);
    for (std::size_t i = 0; i < n; ++i) {
      if (!rows.next())
        throw Error(path + ": ends after " + std::to_string(i) + " of " + std::to_string(n) + " " + name);
      mesh.lines.push_back(rows.line());
      read_row();
    }
  };
  if (!rows.next()) throw Error(path + ": is empty");
  if (rows.text(0, "'nodes'") != "nodes") rows.unexpected(0, "'nodes' and their number");
  section("nodes", [&] {
    Point<3> p;
    for (unsigned i = 0; i < 3; ++i) p[i] = rows.number(i, "a coordinate");
    rows.ends_after(3);
    mesh.nodes.push_back(p);
  });
  if (mesh.nodes.empty()) throw Error(path + ": has no nodes");
  for (std::set<std::string> seen; rows.next();) {
    const std::string name = rows.text(0, "a section");
    if (name != "hexes" && name != "wedges") rows.unexpected(0, "'hexes' or 'wedges' and their number");
    if (!seen.insert(name).second) rows.fail(0, "there are " + name + " already");
    const auto corners = static_cast<std::size_t>(n_nodes(name == "hexes" ? Shape::hex : Shape::wedge));
    section(name, [&] {
      CellData<3> cell(static_cast<unsigned>(corners));
      for (std::size_t k = 0; k < corners; ++k) {
        const auto node = rows.count(k, "a node", 0, mesh.nodes.size() - 1);
        const auto end = cell.vertices.begin() + static_cast<std::ptrdiff_t>(k);
        if (std::find(cell.vertices.begin(), end, node) != end)
          rows.fail(k, "node " + std::to_string(node) + " is twice in this cell");
        cell.vertices[k] = static_cast<unsigned>(node);
      }
      rows.ends_after(corners);
      mesh.cells.push_back(cell);
    });
  }
  if (mesh.cells.empty()) throw Error(path + ": has no cells");
  return mesh;
}

/// Cells that are inside out or flat, at their integration points. Returns the length of the shortest edge or
/// diagonal.
double check_cells(const SerialMesh& mesh, const std::string& path) {
  std::vector<std::size_t> bad;
  double shortest = std::numeric_limits<double>::max();
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto& vertices = mesh.cells[c].vertices;
    double X[3 * most_nodes], places[3 * most_points], volumes[most_points], longest = 0;
    for (std::size_t a = 0; a < vertices.size(); ++a) {
      for (unsigned i = 0; i < 3; ++i) X[3 * a + i] = mesh.nodes[vertices[a]][i];
      for (std::size_t b = 0; b < a; ++b) {
        const double length = mesh.nodes[vertices[a]].distance(mesh.nodes[vertices[b]]);
        shortest = std::min(shortest, length);
        longest = std::max(longest, length);
      }
    }
    const Shape shape = shape_of(mesh.cells[c]);
    integration_points(shape, X, places, volumes);
    const double least = *std::min_element(volumes, volumes + n_points(shape));
    if (!(least > 1e-12 * longest * longest * longest)) bad.push_back(c);
  }
  if (!bad.empty())
    throw Error(mesh.cell(path, bad[0]) + " is inside out or flat" + with_others(bad.size(), "cells"));
  return shortest;
}

/// Nodes without a cell, and nodes at one place: parts that they should join would be apart.
void check_nodes(const SerialMesh& mesh, const std::string& path, double shortest) {
  std::vector<bool> used(mesh.nodes.size());
  for (const CellData<3>& cell : mesh.cells) {
    for (const unsigned v : cell.vertices) used[v] = true;
  }
  const auto unused = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  if (unused > 0) {
    const auto first = std::find(used.begin(), used.end(), false) - used.begin();
    throw Error(mesh.node(path, static_cast<std::size_t>(first)) + " is of no cell" +
                with_others(unused, "nodes"));
  }
  using Row = std::pair<Point<3>, unsigned>;
  std::vector<Row> places;
  for (unsigned i = 0; i < mesh.nodes.size(); ++i) places.emplace_back(mesh.nodes[i], i);
  const auto tree = pack_rtree(places);
  std::vector<std::pair<unsigned, unsigned>> same;
  for (const Row& row : places) {
    std::vector<Row> nearest;
    tree.query(boost::geometry::index::nearest(row.first, 2), std::back_inserter(nearest));
    for (const Row& other : nearest) {
      if (other.second > row.second && row.first.distance(other.first) < 1e-3 * shortest)
        same.emplace_back(row.second, other.second);
    }
  }
  if (!same.empty())
    throw Error(mesh.node(path, same[0].second) + " is at the place of node " +
                std::to_string(same[0].first) + with_others(same.size(), "pairs of nodes") +
                ": cells that should hold together would not");
}

/// Cells that more than two share a face of, and parts that no face joins.
void check_faces(const SerialMesh& mesh, const std::string& path) {
  static const std::vector<std::vector<unsigned>> faces_of[2] = {
      {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}},
      {{0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}};
  std::vector<std::pair<std::array<unsigned, 4>, std::size_t>> faces;  // sorted nodes, cell
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (const std::vector<unsigned>& face : faces_of[shape_of(mesh.cells[c]) == Shape::hex ? 0 : 1]) {
      std::array<unsigned, 4> nodes;
      nodes.fill(numbers::invalid_unsigned_int);
      for (std::size_t k = 0; k < face.size(); ++k) nodes[k] = mesh.cells[c].vertices[face[k]];
      std::sort(nodes.begin(), nodes.end());
      faces.emplace_back(nodes, c);
    }
  }
  std::sort(faces.begin(), faces.end());
  std::vector<std::size_t> part(mesh.cells.size());  // a cell of the same part; its own for one of them
  std::iota(part.begin(), part.end(), 0);
  const auto first_of = [&](std::size_t c) {
    while (part[c] != c) c = part[c] = part[part[c]];
    return c;
  };
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (faces[i].first != faces[i - 1].first) continue;
    if (i > 1 && faces[i].first == faces[i - 2].first)
      throw Error(mesh.cell(path, faces[i].second) + " shares a face with two others, cells " +
                  std::to_string(faces[i - 2].second) + " and " + std::to_string(faces[i - 1].second));
    part[first_of(faces[i].second)] = first_of(faces[i - 1].second);
  }
  for (std::size_t c = 0; c < part.size(); ++c) {
    if (first_of(c) != first_of(0))
      throw Error(mesh.cell(path, c) + " is of another part than cell 0: no faces join them");
  }
}

std::unique_ptr<Mesh> from_file(const std::string& path, MPI_Comm comm) {
  SerialMesh serial;
  on_first(comm, [&] {
    serial = read_mesh(path);
    const double shortest = check_cells(serial, path);
    check_nodes(serial, path, shortest);
    check_faces(serial, path);
    for (CellData<3>& cell : serial.cells) {
      if (shape_of(cell) != Shape::hex) continue;
      std::swap(cell.vertices[2], cell.vertices[3]);  // deal.II's order
      std::swap(cell.vertices[6], cell.vertices[7]);
    }
  });
  const auto ranks = Utilities::MPI::n_mpi_processes(comm);
  auto mesh = std::make_unique<parallel::fullydistributed::Triangulation<3>>(comm);
  mesh->create_triangulation(
      TriangulationDescription::Utilities::create_description_from_triangulation_in_groups<3, 3>(
          [&](Triangulation<3>& t) { t.create_triangulation(serial.nodes, serial.cells, SubCellData()); },
          [&](Triangulation<3>& t, const MPI_Comm&, unsigned) {
            GridTools::partition_triangulation(ranks, t, SparsityTools::Partitioner::metis);
          },
          comm, static_cast<int>(ranks)));
  return mesh;
}

FibreField fibres_from_file(const std::string& path) {
  common::Rows rows(path, common::Separator::blanks);
  using Row = std::pair<Point<3>, unsigned>;
  std::vector<Row> places;
  std::vector<Tensor<1, 3>> directions;
  while (rows.next()) {
    Point<3> p;
    Tensor<1, 3> n;
    for (unsigned i = 0; i < 3; ++i) p[i] = rows.number(i, "a coordinate of the place");
    for (unsigned i = 0; i < 3; ++i) n[i] = rows.number(3 + i, "a component of the fibre");
    rows.ends_after(6);
    if (!(n.norm() > 0)) rows.unexpected(3, "a fibre of a length > 0");
    places.emplace_back(p, static_cast<unsigned>(directions.size()));
    directions.push_back(n);
  }
  if (places.empty()) throw Error(path + ": has no rows");
  return [tree = pack_rtree(places), directions](const Point<3>& p) {
    std::vector<Row> nearest;
    tree.query(boost::geometry::index::nearest(p, 1), std::back_inserter(nearest));
    return directions[nearest[0].second];
  };
}

FibreField fibres_of_function(const std::string& text) {
  auto f = std::make_shared<FunctionParser<3>>(3);
  try {
    f->initialize("x,y,z", text, {{"pi", numbers::PI}});
    f->value(Point<3>());
  } catch (const ExceptionBase& e) {
    std::ostringstream info;
    e.print_info(info);
    throw Error("Fibre/Function = " + text +
                ": must be three expressions in x, y, z, parted by semicolons; muParser says:\n" +
                info.str());
  }
  return [f](const Point<3>& p) {
    Tensor<1, 3> n;
    for (unsigned i = 0; i < 3; ++i) n[i] = f->value(p, i);
    return n;
  };
}

}  // namespace

std::unique_ptr<Mesh> make_mesh(const Parameters::Geometry& geometry, MPI_Comm comm) {
  if (geometry.kind == "cylinder") return cylinder(geometry, comm);
  if (geometry.kind == "brick") return brick(geometry, comm);
  return from_file(geometry.file, comm);
}

std::uint64_t cell_key(const CellId& id) {
  // Children have three bits each; all cells of a mesh are refined equally often.
  std::uint64_t key = id.get_coarse_cell_id();
  for (const std::uint8_t child : id.get_child_indices()) key = 8 * key + child;
  return key;
}

FibreField make_fibre_field(const Parameters::Fibre& fibre) {
  if (fibre.kind == "function") return fibres_of_function(fibre.function);
  if (fibre.kind == "file") return fibres_from_file(fibre.file);
  const double s = std::sin(fibre.angle), c = std::cos(fibre.angle);
  if (fibre.kind == "pennate") {
    return [s, c](const Point<3>& p) { return Tensor<1, 3>({p[0] > 0 ? -s : s, 0, c}); };
  }
  const Tensor<1, 3> n = fibre.kind == "oblique"
                             ? Tensor<1, 3>({s, 0, c})
                             : Tensor<1, 3>({fibre.direction[0], fibre.direction[1], fibre.direction[2]});
  return [n](const Point<3>&) { return n; };
}

}  // namespace muscle
