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

#include <cmath>
#include <fstream>
#include <sstream>

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
  double volume = 0;
  for (const auto& cell : mesh->active_cell_iterators()) {
    if (cell->is_locally_owned()) volume += cell->measure();
  }
  volume = Utilities::MPI::sum(volume, comm);
  const double scale = std::sqrt(numbers::PI * geometry.radius * geometry.radius * geometry.length / volume);
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

struct SerialMesh {
  std::vector<Point<3>> nodes;
  std::vector<CellData<3>> cells;
};

SerialMesh read_mesh(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw Error("Geometry/File = " + path + ": cannot be read");
  SerialMesh mesh;
  const auto count = [&](const std::string& word) {
    std::string found;
    std::size_t n = 0;
    if (!(in >> found >> n) || found != word) {
      throw Error(path + ": \"" + found + "\": must be \"" + word + "\" and their number");
    }
    return n;
  };
  mesh.nodes.resize(count("nodes"));
  for (Point<3>& p : mesh.nodes) in >> p[0] >> p[1] >> p[2];
  const auto read_cells = [&](const std::string& word, const std::vector<unsigned>& order) {
    for (std::size_t n = count(word); n > 0; --n) {
      CellData<3> cell(static_cast<unsigned>(order.size()));
      for (unsigned k : order) {
        in >> cell.vertices[k];
        if (in && cell.vertices[k] >= mesh.nodes.size()) {
          throw Error(path + ": node " + std::to_string(cell.vertices[k]) +
                      " of a cell: must be less than their number, " + std::to_string(mesh.nodes.size()));
        }
      }
      mesh.cells.push_back(cell);
    }
  };
  read_cells("hexes", {0, 1, 3, 2, 4, 5, 7, 6});
  read_cells("wedges", {0, 1, 2, 3, 4, 5});
  if (!in) throw Error(path + ": ends too early, or has a word where a number must be");
  if (mesh.cells.empty()) throw Error(path + ": has no cells");
  return mesh;
}

std::unique_ptr<Mesh> from_file(const std::string& path, MPI_Comm comm) {
  // Rank 0 alone reads, but all must learn of an error.
  SerialMesh serial;
  std::string error;
  if (Utilities::MPI::this_mpi_process(comm) == 0) {
    try {
      serial = read_mesh(path);
    } catch (const Error& e) {
      error = e.what();
    }
  }
  error = Utilities::MPI::broadcast(comm, error);
  if (!error.empty()) throw Error(error);
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
  std::ifstream in(path);
  if (!in) throw Error("Fibre/File = " + path + ": cannot be read");
  using Row = std::pair<Point<3>, unsigned>;
  std::vector<Row> places;
  std::vector<Tensor<1, 3>> directions;
  std::string line;
  for (unsigned number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    Point<3> p;
    Tensor<1, 3> n;
    std::istringstream words(line);
    if (!(words >> p[0] >> p[1] >> p[2] >> n[0] >> n[1] >> n[2]) || !(n.norm() > 0)) {
      throw Error(path + ", line " + std::to_string(number) + ": \"" + line +
                  "\": must be x y z n1 n2 n3, n of a length > 0");
    }
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
