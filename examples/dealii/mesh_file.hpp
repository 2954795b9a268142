/// @file
/// A mesh as its file has it: nodes, cells with their sections, surfaces, fibres. Every rank has all of it.
#ifndef MYOGROWTH_DEALII_MESH_FILE_HPP
#define MYOGROWTH_DEALII_MESH_FILE_HPP

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "element.hpp"
#include "parameters.hpp"

namespace muscle {

struct MeshFile {
  using Place = std::array<double, 3>;
  struct Cell {
    Shape shape = Shape::hex;
    unsigned section = 0;
    std::array<unsigned, most_nodes> nodes = {};  ///< in CalculiX's order
    std::size_t label = 0, line = 0;
  };
  struct Facet {
    unsigned n = 0;  ///< corners
    std::array<unsigned, 4> nodes = {};
    unsigned cell = 0;  ///< that it is a face of
  };
  struct Surface {
    std::string name;
    std::vector<Facet> facets;
  };

  std::string path;
  bool has_sections = false;  ///< and labels and surfaces: the file is of the kind "myogrowth mesh"
  std::vector<Place> nodes;
  std::vector<std::size_t> node_labels, node_lines;
  std::vector<Cell> cells;
  std::vector<std::string> sections;
  std::vector<Surface> surfaces;
  std::vector<Place> fibres;  ///< of the cells; may be empty
  struct Set {
    std::string name;
    std::vector<unsigned> cells;
  };
  std::vector<Set> sets;  ///< that are no sections

  /// FILE:LINE: element LABEL
  std::string cell(std::size_t i) const;
  std::string node(std::size_t i) const;
  /// The surface of that name, or nullptr.
  const Surface* surface(const std::string& name) const;
  std::string surface_names() const;
  /// Of each cell whether it is of the section or set of that name; empty if there is none.
  std::vector<char> cells_of(const std::string& name) const;
  /// The names of sections and sets.
  std::string set_names() const;
  /// The nodes of a surface, those between its corners included, in ascending order.
  std::vector<unsigned> nodes_of(const Surface& surface) const;
  /// The node between two corners of second-degree tetrahedra; -1 if there is none.
  std::map<std::pair<unsigned, unsigned>, unsigned> mid_nodes() const;
};

/// Reads a mesh on rank 0, checks it, changes its degree and gives it to all ranks.
/// Either "nodes N" and N rows x y z, then "hexes N" and "wedges N" with rows of nodes, counted from 0; or
/// "myogrowth mesh 1" as docs/muscle.md describes it.
MeshFile read_mesh_file(const Parameters::Geometry& geometry, MPI_Comm comm);

}  // namespace muscle

#endif
