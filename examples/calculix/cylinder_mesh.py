"""The biceps femoris as a cylinder, 400 mm long and 20 mm in diameter: a disc of quadrilaterals and triangles, swept.

mesh(size) gives C3D8 and C3D6 in layers along z. `paper` has as many of each as the paper: 38,556 = 204 x 189 and
14,931 = 79 x 189. The paper does not show its disc; this one has a node in the centre and rings around it.
"""
import argparse
import io
import math
from typing import NamedTuple

import numpy as np

from shared import files

LENGTH, RADIUS = 400.0, 10.0  # mm


class Size(NamedTuple):
    """How fine a mesh is."""

    rings: list  # nodes in every ring of the disc
    quads: int  # quadrilaterals in the disc; what is left of it are triangles
    layers: int
    grading: float = 1.0  # height of the layers half way along over that of the layers at the ends
    ring_grading: float = 1.0  # width of the ring around the centre over that of the outermost one


SIZES = {
    "tiny": Size([6, 12], 8, 10),
    "coarse": Size([6, 12, 18, 24], 36, 36, grading=10.0),
    "medium": Size([6 * k for k in range(1, 6)], 56, 60, grading=8.0),
    "paper": Size([6 * k for k in range(1, 9)] + [55], 204, 189),
    "fine": Size([6 * k for k in range(1, 11)], 230, 120, grading=8.0),
}


class Mesh(NamedTuple):
    """Indices count from 0. In a deck, nodes and elements count from 1: first all C3D8, then all C3D6."""

    nodes: np.ndarray  # (n, 3) mm
    hexes: np.ndarray  # (m, 8) nodes in the order of C3D8
    wedges: np.ndarray  # (k, 6) nodes in the order of C3D6
    proximal: np.ndarray  # nodes at z = 0
    distal: np.ndarray  # nodes at z = LENGTH
    levels: np.ndarray  # (layers + 1,) mm, z between the layers

    def elements(self):
        """The nodes of every element, in the order of the deck's numbers."""
        return [self.hexes, self.wedges]

    def layer_of_elements(self):
        """(m + k,) the layer that every element lies in, from 0."""
        layers = len(self.levels) - 1
        return np.concatenate([np.repeat(np.arange(layers), len(cells) // layers) for cells in self.elements()])


def ring_nodes(counts, grading):
    """Points of the disc [mm], the centre first, and the index of every ring's nodes."""
    points, index = [(0.0, 0.0)], [[0]]
    widths = grading ** -np.linspace(0, 1, len(counts))
    for n, r in zip(counts, (RADIUS * np.cumsum(widths) / widths.sum()).tolist()):
        index.append(list(range(len(points), len(points) + n)))
        points += [(r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n)) for i in range(n)]
    return points, index


def triangles(index):
    """Triangles between the rings, counterclockwise: a zipper that always closes the side which lags behind."""
    outer = index[1]
    result = [(0, a, b) for a, b in zip(outer, outer[1:] + outer[:1])]
    for inner, outer in zip(index[1:], index[2:]):
        i = j = 0
        n, m = len(inner), len(outer)
        while i < n or j < m:
            if (j + 1) * n <= (i + 1) * m:
                result.append((inner[i % n], outer[j], outer[(j + 1) % m]))
                j += 1
            else:
                result.append((inner[i], outer[j % m], inner[(i + 1) % n]))
                i += 1
    return result


def worst_corner(points, polygon):
    """The largest deviation of a corner from a right angle; pi or more: not convex."""
    worst = 0.0
    for a, b, c in zip(polygon[-1:] + polygon[:-1], polygon, polygon[1:] + polygon[:1]):
        (xa, ya), (xb, yb), (xc, yc) = points[a], points[b], points[c]
        u, v = (xc - xb, yc - yb), (xa - xb, ya - yb)
        angle = math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
        worst = max(worst, abs(angle - math.pi / 2) if angle > 0 else math.pi)
    return worst


def merge(points, tris, n_quads):
    """n_quads quadrilaterals of pairs of triangles, the squarest first, and the triangles that are left."""
    owner = {}  # of a directed edge: its triangle and the corner across
    for t, tri in enumerate(tris):
        for k in range(3):
            owner[tri[k], tri[(k + 1) % 3]] = t, tri[(k + 2) % 3]
    pairs = []
    for (a, b), (t, c) in owner.items():
        if a < b and (b, a) in owner:
            other, d = owner[b, a]
            quad = [a, d, b, c]
            pairs.append((worst_corner(points, quad), t, other, quad))
    quads, used = [], set()
    for worst, t, other, quad in sorted(pairs):
        if len(quads) < n_quads and worst < 0.45 * math.pi and t not in used and other not in used:
            used |= {t, other}
            quads.append(quad)
    if len(quads) != n_quads:
        raise ValueError(f"the disc gives {len(quads)} quadrilaterals, not {n_quads}")
    return quads, [tri for t, tri in enumerate(tris) if t not in used]


def layer_levels(layers, grading):
    """(layers + 1,) mm: z between the layers, whose heights grow geometrically from both ends to the middle."""
    if grading == 1.0:
        return np.array([LENGTH * k / layers for k in range(layers + 1)])
    from_end = np.minimum(np.arange(layers), np.arange(layers)[::-1])
    heights = grading ** (from_end / from_end.max())
    levels = np.concatenate([[0.0], np.cumsum(heights)])
    levels *= LENGTH / levels[-1]
    levels[-1] = LENGTH  # exactly, for the set of nodes there
    return levels


def swept(cells, layers, disc):
    """(layers * cells, 2 * corners): one cell of the disc after another, layer after layer."""
    bottom = np.arange(layers)[:, None, None] * disc + np.array(cells)
    return np.concatenate([bottom, bottom + disc], axis=2).reshape(-1, 2 * len(cells[0]))


def mesh(size):
    """The mesh of a size in SIZES."""
    if size not in SIZES:
        raise files.FileError(f"mesh {size!r}: must be one of {', '.join(SIZES)}")
    return sweep(SIZES[size], layer_levels(SIZES[size].layers, SIZES[size].grading))


def sweep(size, levels):
    """The disc of a Size, swept through levels [mm]."""
    points, index = ring_nodes(size.rings, size.ring_grading)
    quads, tris = merge(points, triangles(index), size.quads)
    layers, disc = len(levels) - 1, len(points)
    nodes = np.column_stack([np.tile(np.array(points), (layers + 1, 1)), np.repeat(levels, disc)])
    return Mesh(nodes, swept(quads, layers, disc), swept(tris, layers, disc), np.arange(disc),
                np.arange(disc) + layers * disc, levels)


def write_text(path, m):
    """The mesh as plain text, for programs that read no deck (examples/dealii): nodes, then hexahedra and wedges by their
    nodes, counted from 0."""
    f = io.StringIO()
    for name, rows, form in (("nodes", m.nodes, "%.17g"), ("hexes", m.hexes, "%d"), ("wedges", m.wedges, "%d")):
        f.write(f"{name} {len(rows)}\n")
        np.savetxt(f, rows, fmt=form)
    files.write_text(path, f.getvalue())


def main():
    p = argparse.ArgumentParser(description="Writes the mesh as plain text: nodes, hexahedra, wedges.")
    p.add_argument("size", choices=SIZES)
    p.add_argument("file", metavar="FILE")
    a = p.parse_args()
    write_text(a.file, mesh(a.size))


if __name__ == "__main__":
    with files.faults_in_one_line("cylinder_mesh.py"):
        main()
