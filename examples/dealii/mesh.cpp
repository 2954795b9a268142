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

std::unique_ptr<Mesh> from_file(const MeshFile& file, MPI_Comm comm) {
  std::vector<Point<3>> corners;
  std::vector<CellData<3>> cells;
  on_first(comm, [&] {
    std::vector<unsigned> number(file.nodes.size(), numbers::invalid_unsigned_int);
    for (const MeshFile::Cell& from : file.cells) {
      const auto n = static_cast<unsigned>(n_corners(from.shape));
      CellData<3> cell(n);
      for (unsigned a = 0; a < n; ++a) {
        unsigned& node = number[from.nodes[a]];
        if (node == numbers::invalid_unsigned_int) {
          node = static_cast<unsigned>(corners.size());
          const MeshFile::Place& p = file.nodes[from.nodes[a]];
          corners.emplace_back(p[0], p[1], p[2]);
        }
        cell.vertices[vertex(from.shape, a)] = node;
      }
      cells.push_back(cell);
    }
  });
  const auto ranks = Utilities::MPI::n_mpi_processes(comm);
  auto mesh = std::make_unique<parallel::fullydistributed::Triangulation<3>>(comm);
  mesh->create_triangulation(
      TriangulationDescription::Utilities::create_description_from_triangulation_in_groups<3, 3>(
          [&](Triangulation<3>& t) { t.create_triangulation(corners, cells, SubCellData()); },
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
    for (unsigned i = 0; i < 3; ++i) f->value(Point<3>(), i);
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

unsigned vertex(Shape shape, unsigned corner) {
  static constexpr unsigned hex[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  return shape == Shape::hex ? hex[corner] : corner;
}

std::unique_ptr<Mesh> make_mesh(const Parameters::Geometry& geometry, const MeshFile& file, MPI_Comm comm) {
  if (geometry.kind == "cylinder") return cylinder(geometry, comm);
  if (geometry.kind == "brick") return brick(geometry, comm);
  return from_file(file, comm);
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
