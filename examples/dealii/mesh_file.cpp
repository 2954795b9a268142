#include "mesh_file.hpp"

#include <deal.II/base/point.h>
#include <deal.II/numerics/rtree.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "../common/rows.hpp"

namespace muscle {
namespace {

using Place = MeshFile::Place;
using Cell = MeshFile::Cell;
constexpr std::size_t most = std::numeric_limits<int>::max();

double distance(const Place& a, const Place& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                   (a[2] - b[2]) * (a[2] - b[2]));
}

/// "; there are 3 such cells", or nothing for one.
std::string with_others(std::size_t n, const std::string& what) {
  return n > 1 ? "; there are " + std::to_string(n) + " such " + what : "";
}

/// The row "NAME N" with N rows after it.
template <class ReadRow>
void read_section(common::Rows& rows, const std::string& name, std::size_t n, const ReadRow& read_row) {
  for (std::size_t i = 0; i < n; ++i) {
    if (!rows.next())
      throw Error(rows.path() + ": ends after " + std::to_string(i) + " of " + std::to_string(n) + " " +
                  name);
    read_row(i);
  }
}

std::size_t read_count(const common::Rows& rows, const std::string& name) {
  const std::size_t n = rows.count(1, "the number of " + name, 0, most);
  rows.ends_after(2);
  return n;
}

Place read_place(const common::Rows& rows, std::size_t from, const std::string& what) {
  Place p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = rows.number(from + i, what);
  rows.ends_after(from + 3);
  return p;
}

/// The nodes of a cell or a facet, from field `from` on, each once.
template <class Nodes>
void read_nodes(const common::Rows& rows, std::size_t from, std::size_t n, std::size_t n_nodes,
                const std::string& of, Nodes& nodes) {
  for (std::size_t k = 0; k < n; ++k) {
    const auto node = static_cast<unsigned>(rows.count(from + k, "a node", 0, n_nodes - 1));
    const auto end = nodes.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::find(nodes.begin(), end, node) != end)
      rows.fail(from + k, "node " + std::to_string(node) + " is twice in this " + of);
    nodes[k] = node;
  }
  rows.ends_after(from + n);
}

/// What comes after the first row, "nodes N".
void read_plain(common::Rows& rows, MeshFile& mesh) {
  read_section(rows, "nodes", read_count(rows, "nodes"), [&](std::size_t i) {
    mesh.node_lines.push_back(rows.line());
    mesh.node_labels.push_back(i);
    mesh.nodes.push_back(read_place(rows, 0, "a coordinate"));
  });
  if (mesh.nodes.empty()) throw Error(rows.path() + ": has no nodes");
  for (std::set<std::string> seen; rows.next();) {
    const std::string name = rows.text(0, "a section");
    if (name != "hexes" && name != "wedges") rows.unexpected(0, "'hexes' or 'wedges' and their number");
    if (!seen.insert(name).second) rows.fail(0, "there are " + name + " already");
    read_section(rows, name, read_count(rows, name), [&](std::size_t) {
      Cell cell;
      cell.shape = name == "hexes" ? Shape::hex : Shape::wedge;
      cell.line = rows.line();
      cell.label = mesh.cells.size();
      read_nodes(rows, 0, static_cast<std::size_t>(n_nodes(cell.shape)), mesh.nodes.size(), "cell",
                 cell.nodes);
      mesh.cells.push_back(cell);
    });
  }
  mesh.sections = {"all"};
}

/// What comes after the first row, "myogrowth mesh 1".
void read_with_sections(common::Rows& rows, MeshFile& mesh) {
  mesh.has_sections = true;
  static const std::map<std::string, Shape> shapes = {
      {"hex8", Shape::hex}, {"wedge6", Shape::wedge}, {"tet4", Shape::tet}, {"tet10", Shape::tet10}};
  const auto head = [&](const std::string& name) {
    if (!rows.next()) throw Error(rows.path() + ": ends before '" + name + "' and their number");
    if (rows.text(0, "'" + name + "'") != name) rows.unexpected(0, "'" + name + "' and their number");
    return read_count(rows, name);
  };
  std::map<std::size_t, std::size_t> lines;  // of labels
  const auto label = [&](std::size_t i) {
    const std::size_t found = rows.count(i, "a label", 0, std::numeric_limits<std::size_t>::max() / 4);
    const auto before = lines.emplace(found, rows.line());
    if (!before.second)
      rows.fail(i, "label " + std::to_string(found) + " is there already, in line " +
                       std::to_string(before.first->second));
    return found;
  };
  const auto once = [&](const std::string& what, const std::string& name, bool is_new) {
    if (!is_new) rows.fail(0, "there is a " + what + " '" + common::visible(name) + "' already");
  };
  read_section(rows, "nodes", head("nodes"), [&](std::size_t) {
    mesh.node_lines.push_back(rows.line());
    mesh.node_labels.push_back(label(0));
    mesh.nodes.push_back(read_place(rows, 1, "a coordinate"));
  });
  if (mesh.nodes.empty()) throw Error(rows.path() + ": has no nodes");
  read_section(rows, "sections", head("sections"), [&](std::size_t) {
    const std::string name = rows.text_from(0, "a name");
    rows.ends_after(1);
    once("section", name, std::find(mesh.sections.begin(), mesh.sections.end(), name) == mesh.sections.end());
    mesh.sections.push_back(name);
  });
  if (mesh.sections.empty()) throw Error(rows.path() + ": has no sections");
  lines.clear();
  read_section(rows, "cells", head("cells"), [&](std::size_t) {
    const auto shape = shapes.find(rows.text(0, "a type"));
    if (shape == shapes.end()) rows.unexpected(0, "tet4, tet10, hex8 or wedge6");
    Cell cell;
    cell.shape = shape->second;
    cell.line = rows.line();
    cell.label = label(1);
    cell.section = static_cast<unsigned>(rows.count(2, "a section", 0, mesh.sections.size() - 1));
    read_nodes(rows, 3, static_cast<std::size_t>(n_nodes(cell.shape)), mesh.nodes.size(), "cell", cell.nodes);
    mesh.cells.push_back(cell);
  });
  for (std::size_t left = head("surfaces"); left > 0; --left) {
    if (!rows.next()) throw Error(rows.path() + ": ends before the last surface");
    MeshFile::Surface surface;
    surface.name = rows.text(0, "the name of a surface");
    once("surface", surface.name, mesh.surface(surface.name) == nullptr);
    read_section(rows, "facets of surface " + surface.name, read_count(rows, "facets"), [&](std::size_t) {
      MeshFile::Facet facet;
      facet.n = rows.size() == 3 ? 3 : 4;
      read_nodes(rows, 0, facet.n, mesh.nodes.size(), "facet", facet.nodes);
      surface.facets.push_back(facet);
    });
    mesh.surfaces.push_back(surface);
  }
  const std::size_t n = head("fibres");
  if (n != 0 && n != mesh.cells.size())
    rows.unexpected(1, "the number of cells, " + std::to_string(mesh.cells.size()) + ", or 0");
  read_section(rows, "fibres", n, [&](std::size_t) {
    mesh.fibres.push_back(read_place(rows, 0, "a component of the fibre"));
    if (mesh.fibres.back() == Place{}) rows.unexpected(0, "a fibre of a length > 0");
  });
  if (!rows.next()) return;
  if (rows.text(0, "'sets' or the end of the file") != "sets")
    rows.unexpected(0, "'sets' or the end of the file");
  for (std::size_t left = read_count(rows, "sets"); left > 0; --left) {
    if (!rows.next()) throw Error(rows.path() + ": ends before the last set");
    MeshFile::Set set;
    set.name = rows.text(0, "the name of a set");
    once("section or set", set.name, mesh.cells_of(set.name).empty());
    read_section(rows, "cells of set " + set.name, read_count(rows, "cells"), [&](std::size_t) {
      set.cells.push_back(static_cast<unsigned>(rows.count(0, "a cell", 0, mesh.cells.size() - 1)));
      rows.ends_after(1);
    });
    mesh.sets.push_back(set);
  }
  if (rows.next()) rows.unexpected(0, "the end of the file");
}

/// Makes second-degree tetrahedra of first-degree ones, with straight edges, or the other way round.
void change_degree(MeshFile& mesh, const std::string& degree) {
  const auto has = [&](Shape shape) {
    return std::any_of(mesh.cells.begin(), mesh.cells.end(), [&](const Cell& c) { return c.shape == shape; });
  };
  const bool others = has(Shape::hex) || has(Shape::wedge), second = has(Shape::tet10);
  if (second && has(Shape::tet))
    throw Error(mesh.path + ": has tetrahedra of four and of ten nodes; they do not fit together");
  if (others && degree == "2")
    throw Error("Mesh/Degree = 2: must be 1 where there are hexahedra or wedges, as in " + mesh.path);
  if (others && second && degree != "1")
    throw Error(mesh.path +
                ": has tetrahedra of ten nodes beside hexahedra or wedges; Mesh/Degree = 1 drops their "
                "nodes between corners");
  if (degree == "2" && !second) {
    std::map<std::pair<unsigned, unsigned>, unsigned> between;
    for (Cell& cell : mesh.cells) {
      cell.shape = Shape::tet10;
      for (unsigned e = 0; e < 6; ++e) {
        const unsigned a = cell.nodes[static_cast<unsigned>(tet_edges[e][0])],
                       b = cell.nodes[static_cast<unsigned>(tet_edges[e][1])];
        const auto found = between.emplace(std::minmax(a, b), static_cast<unsigned>(mesh.nodes.size()));
        cell.nodes[4 + e] = found.first->second;
        if (!found.second) continue;
        Place middle;
        for (std::size_t i = 0; i < 3; ++i) middle[i] = (mesh.nodes[a][i] + mesh.nodes[b][i]) / 2;
        mesh.nodes.push_back(middle);
        mesh.node_labels.push_back(0);
        mesh.node_lines.push_back(cell.line);
      }
    }
  } else if (degree == "1" && second) {
    std::vector<unsigned> number(mesh.nodes.size(), static_cast<unsigned>(most));
    MeshFile corners = mesh;
    corners.nodes.clear(), corners.node_labels.clear(), corners.node_lines.clear();
    for (Cell& cell : corners.cells) {
      if (cell.shape == Shape::tet10) cell.shape = Shape::tet;
      for (unsigned a = 0; a < static_cast<unsigned>(n_nodes(cell.shape)); ++a) {
        unsigned& node = number[cell.nodes[a]];
        if (node == most) {
          const unsigned from = cell.nodes[a];
          node = static_cast<unsigned>(corners.nodes.size());
          corners.nodes.push_back(mesh.nodes[from]);
          corners.node_labels.push_back(mesh.node_labels[from]);
          corners.node_lines.push_back(mesh.node_lines[from]);
        }
        cell.nodes[a] = node;
      }
    }
    for (MeshFile::Surface& surface : corners.surfaces) {
      for (MeshFile::Facet& facet : surface.facets) {
        for (unsigned k = 0; k < facet.n; ++k) facet.nodes[k] = number[facet.nodes[k]];
      }
    }
    mesh = std::move(corners);
  }
}

/// Cells that are inside out or flat, at their integration points and corners. Returns the length of the
/// shortest edge or diagonal.
double check_cells(const MeshFile& mesh) {
  std::vector<std::size_t> bad;
  double shortest = std::numeric_limits<double>::max();
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const Cell& cell = mesh.cells[c];
    double X[3 * most_nodes], places[3 * most_points], volumes[most_points], longest = 0;
    for (unsigned a = 0; a < static_cast<unsigned>(n_nodes(cell.shape)); ++a) {
      for (unsigned i = 0; i < 3; ++i) X[3 * a + i] = mesh.nodes[cell.nodes[a]][i];
      for (unsigned b = 0; b < a; ++b) {
        const double length = distance(mesh.nodes[cell.nodes[a]], mesh.nodes[cell.nodes[b]]);
        shortest = std::min(shortest, length);
        longest = std::max(longest, length);
      }
    }
    integration_points(cell.shape, X, places, volumes);
    const double least = *std::min_element(volumes, volumes + n_points(cell.shape));
    if (!(least > 1e-12 * longest * longest * longest)) bad.push_back(c);
  }
  if (!bad.empty()) {
    std::string labels;
    for (std::size_t i = 1; i < std::min<std::size_t>(bad.size(), 20) && mesh.has_sections; ++i)
      labels += (i > 1 ? ", " : ": also ") + std::to_string(mesh.cells[bad[i]].label);
    throw Error(mesh.cell(bad[0]) + " is inside out or flat" + with_others(bad.size(), "cells") + labels);
  }
  return shortest;
}

/// Nodes without a cell, and nodes at one place: parts that they should join would be apart.
void check_nodes(const MeshFile& mesh, double shortest) {
  std::vector<bool> used(mesh.nodes.size());
  for (const Cell& cell : mesh.cells) {
    for (unsigned a = 0; a < static_cast<unsigned>(n_nodes(cell.shape)); ++a) used[cell.nodes[a]] = true;
  }
  const auto unused = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  if (unused > 0) {
    const auto first = std::find(used.begin(), used.end(), false) - used.begin();
    throw Error(mesh.node(static_cast<std::size_t>(first)) + " is of no cell" + with_others(unused, "nodes"));
  }
  using Row = std::pair<dealii::Point<3>, unsigned>;
  std::vector<Row> places;
  for (unsigned i = 0; i < mesh.nodes.size(); ++i)
    places.emplace_back(dealii::Point<3>(mesh.nodes[i][0], mesh.nodes[i][1], mesh.nodes[i][2]), i);
  const auto tree = dealii::pack_rtree(places);
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
    throw Error(mesh.node(same[0].second) + " is at the place of node " +
                std::to_string(mesh.node_labels[same[0].first]) + with_others(same.size(), "pairs of nodes") +
                ": cells that should hold together would not");
}

/// Cells that more than two share a face of, and parts that no face joins. Finds the cells of the facets.
void check_faces(MeshFile& mesh) {
  static const std::vector<std::vector<unsigned>> hex = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                                         {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}},
                                                  wedge = {{0, 1, 2},
                                                           {3, 4, 5},
                                                           {0, 1, 4, 3},
                                                           {1, 2, 5, 4},
                                                           {2, 0, 3, 5}},
                                                  tet = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  using Key = std::array<unsigned, 4>;  // sorted
  const auto key_of = [](const auto& nodes, std::size_t n) {
    Key key;
    key.fill(static_cast<unsigned>(-1));
    std::copy(nodes.begin(), nodes.begin() + static_cast<std::ptrdiff_t>(n), key.begin());
    std::sort(key.begin(), key.end());
    return key;
  };
  std::vector<std::pair<Key, std::size_t>> faces;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const Shape shape = mesh.cells[c].shape;
    for (const std::vector<unsigned>& face : shape == Shape::hex     ? hex
                                             : shape == Shape::wedge ? wedge
                                                                     : tet) {
      std::array<unsigned, 4> nodes;
      for (std::size_t k = 0; k < face.size(); ++k) nodes[k] = mesh.cells[c].nodes[face[k]];
      faces.emplace_back(key_of(nodes, face.size()), c);
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
      throw Error(mesh.cell(faces[i].second) + " shares a face with two others, cells " +
                  std::to_string(mesh.cells[faces[i - 2].second].label) + " and " +
                  std::to_string(mesh.cells[faces[i - 1].second].label));
    part[first_of(faces[i].second)] = first_of(faces[i - 1].second);
  }
  for (std::size_t c = 0; c < part.size(); ++c) {
    if (first_of(c) != first_of(0))
      throw Error(mesh.cell(c) + " is of another part than cell " + std::to_string(mesh.cells[0].label) +
                  ": no faces join them");
  }
  for (MeshFile::Surface& surface : mesh.surfaces) {
    std::set<Key> seen;
    for (std::size_t i = 0; i < surface.facets.size(); ++i) {
      MeshFile::Facet& facet = surface.facets[i];
      const Key key = key_of(facet.nodes, facet.n);
      const auto range = std::equal_range(faces.begin(), faces.end(), std::make_pair(key, std::size_t(0)),
                                          [](const auto& a, const auto& b) { return a.first < b.first; });
      const std::string name = mesh.path + ": surface " + surface.name + ", facet " + std::to_string(i + 1) +
                               " with node " + std::to_string(mesh.node_labels[facet.nodes[0]]);
      if (range.first == range.second) throw Error(name + ": is no face of a cell");
      if (range.second - range.first > 1) throw Error(name + ": lies between two cells, not on the surface");
      if (!seen.insert(key).second) throw Error(name + ": is twice in this surface");
      facet.cell = static_cast<unsigned>(range.first->second);
    }
  }
}

/// Gives what rank 0 has to all ranks.
template <class T>
void share(std::vector<T>& values, MPI_Comm comm) {
  std::uint64_t n = values.size();
  MPI_Bcast(&n, 1, MPI_UINT64_T, 0, comm);
  values.resize(n);
  char* bytes = reinterpret_cast<char*>(values.data());
  const std::size_t size = n * sizeof(T);
  for (std::size_t done = 0; done < size;) {  // in pieces, since MPI counts in int
    const std::size_t piece = std::min(size - done, std::size_t(1) << 30);
    MPI_Bcast(bytes + done, static_cast<int>(piece), MPI_BYTE, 0, comm);
    done += piece;
  }
}

void share(MeshFile& mesh, MPI_Comm comm) {
  mesh.path = dealii::Utilities::MPI::broadcast(comm, mesh.path);
  mesh.has_sections = dealii::Utilities::MPI::broadcast(comm, mesh.has_sections);
  mesh.sections = dealii::Utilities::MPI::broadcast(comm, mesh.sections);
  share(mesh.nodes, comm);
  share(mesh.node_labels, comm);
  share(mesh.node_lines, comm);
  share(mesh.cells, comm);
  share(mesh.fibres, comm);
  mesh.surfaces.resize(dealii::Utilities::MPI::broadcast(comm, mesh.surfaces.size()));
  for (MeshFile::Surface& surface : mesh.surfaces) {
    surface.name = dealii::Utilities::MPI::broadcast(comm, surface.name);
    share(surface.facets, comm);
  }
  mesh.sets.resize(dealii::Utilities::MPI::broadcast(comm, mesh.sets.size()));
  for (MeshFile::Set& set : mesh.sets) {
    set.name = dealii::Utilities::MPI::broadcast(comm, set.name);
    share(set.cells, comm);
  }
}

}  // namespace

std::string MeshFile::cell(std::size_t i) const {
  return path + ":" + std::to_string(cells[i].line) + (has_sections ? ": element " : ": cell ") +
         std::to_string(cells[i].label);
}

std::string MeshFile::node(std::size_t i) const {
  return path + ":" + std::to_string(node_lines[i]) + ": node " + std::to_string(node_labels[i]);
}

const MeshFile::Surface* MeshFile::surface(const std::string& name) const {
  for (const Surface& s : surfaces) {
    if (s.name == name) return &s;
  }
  return nullptr;
}

std::string MeshFile::surface_names() const {
  std::string names;
  for (const Surface& s : surfaces) names += (names.empty() ? "" : ", ") + s.name;
  return names.empty() ? "none" : names;
}

std::vector<char> MeshFile::cells_of(const std::string& name) const {
  std::vector<char> has;
  const auto section = std::find(sections.begin(), sections.end(), name);
  if (section != sections.end()) {
    for (const Cell& cell : cells) has.push_back(cell.section == section - sections.begin());
  }
  for (const Set& set : sets) {
    if (set.name != name) continue;
    has.resize(cells.size());
    for (const unsigned c : set.cells) has[c] = 1;
  }
  return has;
}

std::string MeshFile::set_names() const {
  std::string names;
  for (const std::string& name : sections) names += (names.empty() ? "" : ", ") + name;
  for (const Set& set : sets) names += (names.empty() ? "" : ", ") + set.name;
  return names;
}

std::map<std::pair<unsigned, unsigned>, unsigned> MeshFile::mid_nodes() const {
  std::map<std::pair<unsigned, unsigned>, unsigned> between;
  for (const Cell& cell : cells) {
    for (unsigned e = 0; e < 6 && cell.shape == Shape::tet10; ++e) {
      between.emplace(std::minmax(cell.nodes[static_cast<unsigned>(tet_edges[e][0])],
                                  cell.nodes[static_cast<unsigned>(tet_edges[e][1])]),
                      cell.nodes[4 + e]);
    }
  }
  return between;
}

std::vector<unsigned> MeshFile::nodes_of(const Surface& surface) const {
  std::set<unsigned> found;
  const auto between = mid_nodes();
  for (const Facet& facet : surface.facets) {
    for (unsigned k = 0; k < facet.n; ++k) {
      found.insert(facet.nodes[k]);
      const auto middle = between.find(std::minmax(facet.nodes[k], facet.nodes[(k + 1) % facet.n]));
      if (middle != between.end()) found.insert(middle->second);
    }
  }
  return {found.begin(), found.end()};
}

MeshFile read_mesh_file(const Parameters::Geometry& geometry, MPI_Comm comm) {
  MeshFile mesh;
  on_first(comm, [&] {
    mesh.path = geometry.file;
    common::Rows rows(mesh.path, common::Separator::blanks);
    if (!rows.next()) throw Error(mesh.path + ": is empty");
    if (rows.text(0, "'nodes'") == "myogrowth") {
      if (rows.text_from(0, "a text") != "myogrowth mesh 1") rows.unexpected(0, "'myogrowth mesh 1'");
      read_with_sections(rows, mesh);
    } else {
      if (rows.text(0, "'nodes'") != "nodes")
        rows.unexpected(0, "'nodes' and their number, or 'myogrowth mesh 1'");
      read_plain(rows, mesh);
    }
    if (mesh.cells.empty()) throw Error(mesh.path + ": has no cells");
    const double shortest = check_cells(mesh);
    change_degree(mesh, geometry.degree);
    check_nodes(mesh, shortest);
    check_faces(mesh);
  });
  share(mesh, comm);
  return mesh;
}

}  // namespace muscle
