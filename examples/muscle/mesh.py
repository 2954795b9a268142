"""Reads a muscle's mesh, checks it, reports it, and writes it for the solver. docs/muscle.md has files and rules.

    mesh.py MESH --unit mm -o muscle.mesh        MESH: Abaqus .inp, Gmsh .msh, .vtk, .vtu
    mesh.py --fusiform -o muscle.mesh            the built-in muscle (fusiform.py)
"""
import argparse
import pathlib
import re
import sys

import numpy as np

import fields
import fusiform
import inp
from raw import CORNERS, FACES, NODES, fail, some
from shared import files

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3}
ENDS = ("PROXIMAL", "DISTAL")
TISSUES = ("MUSCLE", "TENDON", "APONEUROSIS")
FLAT = 1e-6  # of the volume of a cube on the longest edge
EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])  # of tet10's nodes 4 to 9
TURNS = {  # orders of nodes that mend an element whose nodes are in another order than Abaqus's
    "tet4": [[0, 2, 1, 3]], "tet10": [[0, 2, 1, 3, 6, 5, 4, 7, 9, 8]], "wedge6": [[3, 4, 5, 0, 1, 2]],
    "hex8": [[4, 5, 6, 7, 0, 1, 2, 3], [0, 1, 3, 2, 4, 5, 7, 6], [4, 5, 7, 6, 0, 1, 3, 2]],
}
_G, _A, _B = 1 / np.sqrt(3), 0.13819660112501051518, 0.58541019662496845446
_HEX = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
_TET = np.array([[_A, _A, _A], [_B, _A, _A], [_A, _B, _A], [_A, _A, _B]])
_UNIT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
_PRISM = np.array([[0, 0], [1, 0], [0, 1]], dtype=float)
# Points and weights that integrate the volume, and the corners.
POINTS = {
    "tet4": (np.array([[0.25, 0.25, 0.25]]), 1 / 6, _UNIT), "tet10": (_TET, 1 / 24, _UNIT), "hex8": (_G * _HEX, 1.0, _HEX),
    "wedge6": (np.array([[*p, z] for z in (-_G, _G) for p in ((1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3))]), 1 / 6,
               np.array([[*p, z] for z in (-1, 1) for p in _PRISM])),
}


def _triangle6():
    """Weights, shape functions and their two derivatives (points, 6) at points exact to fourth order (Dunavant 1985)."""
    rows = [(a, w / 2, k) for a, w in ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)) for k in range(3)]
    slope, after = np.array([[-1, -1], [1, 0], [0, 1]]), [1, 2, 0]
    L = np.array([[1 - 2 * a if i == k else a for i in range(3)] for a, _, k in rows])
    N = np.hstack([L * (2 * L - 1), 4 * L * L[:, after]])
    d = [np.hstack([(4 * L - 1) * s, 4 * (s * L[:, after] + L * s[after])]) for s in slope.T]
    return np.array([w for _, w, _ in rows]), N, *d


TRIANGLE6 = _triangle6()


def shape_derivatives(kind, at):
    """(points, nodes, 3) derivatives of the shape functions at natural coordinates (points, 3)."""
    if kind == "hex8":
        f = 1 + at[:, None, :] * _HEX
        return np.stack([_HEX[:, i] * f[..., (i + 1) % 3] * f[..., (i + 2) % 3] / 8 for i in range(3)], axis=2)
    if kind == "wedge6":
        x, y, z = at.T
        L = np.stack([1 - x - y, x, y], axis=1)
        slope = np.array([[-1, -1], [1, 0], [0, 1]])
        low, high = ((1 - z) / 2)[:, None, None], ((1 + z) / 2)[:, None, None]
        plane = np.concatenate([slope * low, slope * high], axis=1)
        return np.concatenate([plane, np.concatenate([-L, L], axis=1)[:, :, None] / 2], axis=2)
    slope = np.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    if kind == "tet4":
        return np.broadcast_to(slope, (len(at), 4, 3))
    L = np.concatenate([1 - at.sum(axis=1, keepdims=True), at], axis=1)
    middle = 4 * (L[:, EDGES[:, 0], None] * slope[EDGES[:, 1]] + L[:, EDGES[:, 1], None] * slope[EDGES[:, 0]])
    return np.concatenate([(4 * L - 1)[:, :, None] * slope, middle], axis=1)


def determinants(kind, X, at):
    """(cells, points) det dx/dxi of cells with nodes X (cells, nodes, 3)."""
    return np.linalg.det(np.einsum("cni,pnj->cpij", X, shape_derivatives(kind, at)))


def volumes(kind, X):
    points, weight, _ = POINTS[kind]
    return determinants(kind, X, points).sum(axis=1) * weight


def longest(X):
    """(cells,) the longest distance between two corners."""
    n = X.shape[1]
    return np.max([np.linalg.norm(X[:, a] - X[:, b], axis=1) for a in range(n) for b in range(a)], axis=0)


def quality(kind, X):
    """(cells,) 1: regular, 0: flat. Tetrahedra: 12 (3 V)^(2/3) over the sum of the squared edges. Others: the least
    Jacobian at a corner over the product of the lengths of its columns, 1 for a right prism of an equilateral triangle."""
    if CORNERS[kind] == 4:
        X = X[:, :4]
        squares = sum(np.sum((X[:, a] - X[:, b])**2, axis=1) for a, b in EDGES)
        return 12 * np.cbrt(3 * np.maximum(volumes("tet4", X), 0))**2 / squares
    J = np.einsum("cni,pnj->cpij", X, shape_derivatives(kind, POINTS[kind][2]))
    if kind == "wedge6":  # the two edges of the triangle that meet at the corner
        corner = np.arange(6)
        ends = [3 * (corner // 3) + (corner + k) % 3 for k in (1, 2)]
        J[..., :2] = np.stack([X[:, end] - X for end in ends], axis=-1)
    scaled = np.linalg.det(J) / np.linalg.norm(J, axis=2).prod(axis=2)
    return scaled.min(axis=1) / (np.sqrt(0.75) if kind == "wedge6" else 1)


class Mesh:
    """A mesh that has passed the checks: lengths in mm, indices from 0. Cells are grouped by type: kinds[name] are the
    indices of their cells, nodes_of[name] (cells, nodes) their nodes."""

    def __init__(self, raw, unit):
        self.path, self.raw, self.unit, self.notes = raw.path, raw, unit, list(raw.notes)
        self.X = np.array(raw.nodes, dtype=float).reshape(-1, 3) * UNITS[unit]
        self.labels = np.array(raw.node_labels)
        self.cell_labels = np.array([c.label for c in raw.cells])
        self.cell_kinds = [c.kind for c in raw.cells]
        self.kinds, self.nodes_of = {}, {}
        for kind in NODES:
            cells = [i for i, k in enumerate(self.cell_kinds) if k == kind]
            if cells:
                self.kinds[kind] = np.array(cells)
                self.nodes_of[kind] = np.array([raw.cells[i].nodes for i in cells])
        self._between = None, {}
        self.sections, self.section = [], None  # names; (cells,) their indices
        self.surfaces = {}  # name to facets, (corners) each
        self.sets = {}  # name to (cells,) of the element sets that are no sections
        self.fibres = None if raw.fibres is None else np.array(raw.fibres, dtype=float)

    def corners(self, kind):
        return self.X[self.nodes_of[kind]]

    def each(self, function):
        """(cells,) function(kind, X) of all cells, in the file's order."""
        values = np.zeros(len(self.cell_labels))
        for kind, cells in self.kinds.items():
            values[cells] = function(kind, self.corners(kind))
        return values

    def between(self):
        """{(corner, corner): node between them} of tetrahedra of ten nodes."""
        nodes = self.nodes_of.get("tet10", np.zeros((0, 10), dtype=int))
        if self._between[0] is not nodes:
            pairs = map(tuple, np.sort(nodes[:, EDGES].reshape(-1, 2), axis=1).tolist())
            self._between = nodes, dict(zip(pairs, nodes[:, 4:].ravel().tolist()))
        return self._between[1]

    def facet_vectors(self, name):
        """(facets, 3) outward area vectors, (facets, 3) centroids and (facets,) areas of a surface's facets, curved where they are."""
        between = self.between()
        if between and self.surfaces[name]:
            facets = np.array([[*f, *(between[tuple(sorted((f[k], f[(k + 1) % 3])))] for k in range(3))] for f in self.surfaces[name]])
            x, x1, x2 = (np.einsum("qa,fai->fqi", values, self.X[facets]) for values in TRIANGLE6[1:])
            normals = TRIANGLE6[0][:, None] * np.cross(x1, x2)
            sizes = np.linalg.norm(normals, axis=2)[..., None]
            areas = sizes.sum(axis=1)
            return normals.sum(axis=1), (sizes * x).sum(axis=1) / np.maximum(areas, 1e-300), areas[:, 0]
        vectors, centres, areas = [], [], []
        for facet in self.surfaces[name]:
            X = self.X[list(facet)]
            parts = [(X[0], X[k], X[k + 1]) for k in range(1, len(X) - 1)]
            normals = [np.cross(b - a, c - a) / 2 for a, b, c in parts]
            sizes = [np.linalg.norm(v) for v in normals]
            vectors.append(np.sum(normals, axis=0))
            areas.append(sum(sizes))
            centres.append(sum(s * (a + b + c) / 3 for s, (a, b, c) in zip(sizes, parts)) / max(areas[-1], 1e-300))
        return np.array(vectors), np.array(centres), np.array(areas)

    def area(self, name):
        return self.facet_vectors(name)[2].sum()

    def centroid(self, name):
        _, centres, areas = self.facet_vectors(name)
        return np.average(centres, axis=0, weights=areas)


# ---- Checks

FARTHEST = 1e9  # mm, of a node

def check_cells(mesh):
    """Refuses numbers that are not finite, nodes that are twice in a cell, and flat cells; turns cells whose nodes are only
    in another order. Returns the (cells,) that were turned."""
    raw, turned = mesh.raw, np.zeros(len(mesh.cell_labels), dtype=bool)
    wrong = np.flatnonzero(~(np.abs(mesh.X) <= FARTHEST).all(axis=1))
    if len(wrong):
        fail(raw.node(wrong[0]), f"coordinates {raw.nodes[wrong[0]]}: expected finite numbers, at most {FARTHEST:g} mm")
    flat, folded, curved = [], [], []
    for kind, cells in mesh.kinds.items():
        nodes = mesh.nodes_of[kind]
        order = np.sort(nodes, axis=1)
        twice = np.flatnonzero((order[:, 1:] == order[:, :-1]).any(axis=1))
        if len(twice):
            row = order[twice[0]]
            label = mesh.labels[row[1:][row[1:] == row[:-1]][0]]
            fail(raw.cell(cells[twice[0]]), f"node {label} is twice in it" + also(mesh, cells[twice]))

        n, straight = CORNERS[kind], "tet4" if kind == "tet10" else kind

        def least(nodes):
            return determinants(straight, mesh.X[nodes[:, :n]], POINTS[straight][0]).min(axis=1)

        size = longest(mesh.corners(kind)[:, :n])**3
        # det is six times the volume for tetrahedra, an eighth of it for hexahedra, twice it for wedges
        limit = FLAT * size * {4: 6, 6: 2, 8: 0.125}[n]
        value = least(nodes)
        bad = np.flatnonzero(~(value > limit))
        for order in TURNS[kind]:
            if not len(bad):
                break
            trial = nodes[bad][:, order]
            good = least(trial) > limit[bad]
            nodes[bad[good]] = trial[good]
            turned[cells[bad[good]]] = True
            bad = bad[~good]
        for i in bad:
            values = determinants(straight, mesh.X[nodes[i:i + 1, :n]], POINTS[straight][0])[0]
            (flat if n == 4 or np.abs(values).max() <= limit[i] else folded).append(cells[i])
        if kind == "tet10" and not len(bad):
            inside = determinants(kind, mesh.corners(kind), np.vstack([POINTS[kind][0], _UNIT])).min(axis=1)
            curved += list(cells[~(inside > limit)])
    for found, what in ((flat, "is flat"), (folded, "is inside out in a part: a node is at a wrong place"),
                        (curved, "is turned inside out by its nodes between the corners")):
        if found:
            found = np.sort(found)
            fail(raw.cell(found[0]), what + also(mesh, found))
    if turned.any():
        whole = " (all of them: the mesh is a mirror image, or its program numbers nodes the other way)" if turned.all() else ""
        mesh.notes.append(f"{turned.sum()} elements whose nodes were in another order than Abaqus's were turned{whole}: "
                          f"{some(mesh.cell_labels[turned])}")
    return turned


def also(mesh, cells):
    labels = mesh.cell_labels[cells]
    return f"; {len(labels)} such elements: {some(labels)}" if len(labels) > 1 else ""


def all_faces(mesh):
    """Of all faces of all cells: (faces, 4) sorted corners (-1: a triangle), their cells, the side that the outward order
    of corners is of (+-1), and the corners themselves."""
    keys, cells, sides, corners = [], [], [], []
    for kind, rows in mesh.kinds.items():
        for face in FACES[kind]:
            nodes = mesh.nodes_of[kind][:, list(face)]
            start = np.argmin(nodes, axis=1)
            cycle = np.take_along_axis(nodes, (start[:, None] + np.arange(len(face))) % len(face), axis=1)
            sides.append(np.where(cycle[:, 1] < cycle[:, -1], 1, -1))
            cells.append(rows)
            pad = np.full((len(rows), 4 - len(face)), -1)
            keys.append(np.hstack([pad, np.sort(nodes, axis=1)]))
            corners.append(np.hstack([cycle, pad]))
    keys, cells, sides, corners = map(np.concatenate, (keys, cells, sides, corners))
    order = np.lexsort((cells, *keys.T[::-1]))
    return keys[order], cells[order], sides[order], corners[order]


def check_faces(mesh, turned):
    """Refuses cells that overlap and parts that no face joins. Returns {sorted corners: outward facet} of the surface."""
    raw = mesh.raw
    keys, cells, sides, corners = all_faces(mesh)
    same = (keys[1:] == keys[:-1]).all(axis=1)
    triple = np.flatnonzero(same[1:] & same[:-1])
    if len(triple):
        a, b, c = cells[triple[0]:triple[0] + 3]
        fail(raw.cell(c), f"shares a face with two others, elements {mesh.cell_labels[a]} and {mesh.cell_labels[b]}")
    pairs = np.flatnonzero(same)
    crossing = (corners[pairs, 3] >= 0) & (corners[pairs, 2] != corners[pairs + 1, 2])
    overlap = (sides[pairs] == sides[pairs + 1]) | crossing
    if overlap.any():
        a, b = cells[pairs[overlap]], cells[pairs[overlap] + 1]
        found = np.unique(np.concatenate([a, b]))
        inverted = found[turned[found]] if turned[found].any() and not turned[found].all() else found
        fail(raw.cell(inverted[0]), ("is inside out: with its nodes in the other order" if len(inverted) < len(found) else "")
             + f" it overlaps its neighbours, so that a node is at a wrong place; {len(inverted)} such elements: "
             f"{some(mesh.cell_labels[inverted])}")
    outer = np.ones(len(keys), dtype=bool)
    outer[pairs] = outer[pairs + 1] = False
    facets = {tuple(int(n) for n in k if n >= 0): tuple(int(n) for n in f if n >= 0) for k, f in zip(keys[outer], corners[outer])}
    for facet, c in [(f, c) for f, c in zip(facets.values(), cells[outer]) if len(f) == 4]:
        for k in range(4):
            triangle = tuple(sorted(n for j, n in enumerate(facet) if j != k))
            if triangle in facets:
                other = cells[outer][list(facets).index(triangle)]
                fail(raw.cell(c), f"a quadrilateral face of this {mesh.cell_kinds[c]} lies on a triangle of the "
                     f"{mesh.cell_kinds[other]} {mesh.cell_labels[other]}: such faces do not join (a pyramid would, which deal.II "
                     "does not have with them); mesh both sides with the same kind of face")
    part = list(range(len(mesh.cell_labels)))

    def first_of(c):
        while part[c] != c:
            part[c] = part[part[c]]
            c = part[c]
        return c

    for i in pairs:
        a, b = sorted((first_of(cells[i]), first_of(cells[i + 1])))
        part[b] = a
    groups = np.array([first_of(c) for c in range(len(part))])
    heads, counts = np.unique(groups, return_counts=True)
    if len(heads) > 1:
        fail(raw.cell(heads[np.argsort(counts)[-2]]), f"no face joins it to the rest: the mesh is of {len(heads)} parts, of "
             f"{some(sorted(counts, reverse=True))} elements; parts must share nodes")
    return facets


def check_nodes(mesh):
    """Leaves out nodes of no cell; refuses nodes at one place. Returns (nodes,) new indices, -1 for those left out."""
    used = np.zeros(len(mesh.X), dtype=bool)
    for nodes in mesh.nodes_of.values():
        used[nodes] = True
    if not used.all():
        mesh.notes.append(f"{(~used).sum()} nodes of no element are left out: {some(abs(mesh.labels[~used]), 5)}")
    index = np.where(used, np.cumsum(used) - 1, -1)
    X, numbers = mesh.X[used], np.flatnonzero(used)
    shortest = min(np.linalg.norm(mesh.corners(kind)[:, a] - mesh.corners(kind)[:, b], axis=1).min()
                   for kind in mesh.kinds for a, b in ((0, 1), (1, 2), (0, CORNERS[kind] - 1)))
    # Along a direction in which hardly any two nodes are alike.
    at = X @ np.array([0.5377, 0.6843, 0.4924])
    order, limit, step = np.argsort(at, kind="stable"), 1e-3 * shortest, 1
    at = at[order]
    while step < len(at):
        near = np.flatnonzero(at[step:] - at[:-step] < limit)
        if not len(near):
            break
        close = near[np.linalg.norm(X[order[near]] - X[order[near + step]], axis=1) < limit]
        if len(close):
            a, b = sorted(numbers[[order[close[0]], order[close[0] + step]]])
            fail(mesh.raw.node(b), f"is at the place of node {mesh.labels[a]}" +
                 (f"; at least {len(close)} such pairs" if len(close) > 1 else "") + ": elements that should hold together would not")
        step += 1
    return index


def check_middles(mesh):
    """Says how far nodes between corners are off the straight edge; they are kept."""
    if "tet10" not in mesh.kinds:
        return
    if len(mesh.kinds) > 1:
        others = [k for k in mesh.kinds if k != "tet10"]
        fail(mesh.raw.cell(mesh.kinds[others[0]][0]), f"{others[0]} beside tetrahedra of ten nodes: their faces do not fit together")
    X = mesh.corners("tet10")
    off = np.linalg.norm(X[:, 4:] - (X[:, EDGES[:, 0]] + X[:, EDGES[:, 1]]) / 2, axis=2)
    length = np.linalg.norm(X[:, EDGES[:, 0]] - X[:, EDGES[:, 1]], axis=2)
    c, e = np.unravel_index(np.argmax(off / length), off.shape)
    if (off / length).max() > 1e-6:
        mesh.notes.append(f"nodes between corners are up to {100 * (off / length).max():.3g} % of the edge off its middle (node "
                          f"{mesh.labels[mesh.nodes_of['tet10'][c, 4 + e]]}, {off[c, e]:.3g} mm, element "
                          f"{mesh.cell_labels[mesh.kinds['tet10'][c]]}): they are kept, edges may be curved")


def choose_sections(mesh, wanted):
    """Every cell is of one section: by --sections, by the deck's *SOLID SECTIONs, or by its sets."""
    raw, n = mesh.raw, len(mesh.cell_labels)
    names = {fields.named(name): cells for name, cells in raw.elsets.items()}
    if wanted:
        wanted = [fields.named(w) for w in wanted]
        missing = [w for w in wanted if w not in names]
        if missing:
            fail(raw.path, f"--sections {missing[0]}: there is no such element set; there are {some(sorted(names)) or 'none'}")
        chosen = wanted
    elif raw.sections is not None:
        by_section = {}
        for c, name in enumerate(raw.sections):
            by_section.setdefault(fields.named(name), []).append(c)
        names, chosen = by_section, list(by_section)
    else:
        tissues = [name for name in names if name.rpartition(".")[2].startswith(TISSUES)]
        covered = [c for name in tissues for c in names[name]]
        # Sets that are each tissue's, or all sets, if they cover every element once.
        chosen = next((some_of for some_of in (tissues, list(names)) if sorted(c for s in some_of for c in names[s]) == list(range(n))),
                      tissues if covered else [])
        if not chosen:
            if names:
                mesh.notes.append(f"the element sets ({some(sorted(names))}) do not part the mesh: all of it is one section, MUSCLE; "
                                  "--sections A,B names those that do")
            else:
                mesh.notes.append("no element sets: all of the mesh is one section, MUSCLE")
            names, chosen = {"MUSCLE": range(n)}, ["MUSCLE"]
    section = np.full(n, -1)
    for k, name in enumerate(chosen):
        cells = np.array(list(names[name]), dtype=int)
        again = cells[section[cells] >= 0]
        if len(again):
            fail(raw.cell(again[0]), f"is in two sections, {chosen[section[again[0]]]} and {name}" + also(mesh, again) +
                 "; --sections A,B names the sets that part the mesh")
        section[cells] = k
    without = np.flatnonzero(section < 0)
    if len(without):
        fail(raw.cell(without[0]), f"is in none of the sections {some(chosen)}" + also(mesh, without))
    mesh.sections, mesh.section = chosen, section
    # Names of Abaqus/CAE's internal sets begin with _.
    mesh.sets = {name: np.unique(np.array(cells, dtype=int)) for name, cells in
                 ((fields.named(name), cells) for name, cells in raw.elsets.items()) if cells and name not in chosen and name[0] != "_"}


def near(X, places, distance):
    """(nodes,) whether a node is within a distance of some places."""
    return np.array([len(places) > 0 and np.linalg.norm(places - x, axis=1).min() <= distance for x in X])


def widen(mesh, outer, distance):
    """Attachments get the surface's facets within a distance of them; with distance < 0 they lose those at their border."""
    for end in ENDS:
        own = {tuple(sorted(f)) for f in mesh.surfaces[end]}
        nodes = {n for f in own for n in f}
        border = nodes & {n for key in outer if key not in own for n in key}
        at = np.array(sorted({n for key in outer for n in key}))
        close = set(at[near(mesh.X[at], mesh.X[sorted(nodes if distance > 0 else border)], abs(distance))].tolist())
        mesh.surfaces[end] = [f for key, f in outer.items() if key in own and (distance > 0 or not close & set(key))
                              or distance > 0 and close >= set(key)]
        mesh.notes.append(f"--widen {distance:g}: {end} has {len(mesh.surfaces[end])} facets instead of {len(own)}")
        if not mesh.surfaces[end]:
            fail(mesh.raw.path, f"--widen {distance:g}: nothing is left of {end}")


def choose_surfaces(mesh, outer, ends, names, wider=0):
    """All surfaces, and all sets of nodes that hold facets of the mesh's surface. PROXIMAL and DISTAL must be among them."""
    raw = mesh.raw
    for name, facets in raw.surfaces.items():
        found = {}
        for facet in facets:
            key = tuple(sorted(facet))
            if key not in outer:
                fail(raw.path, f"surface {name}: the facet of nodes {', '.join(str(mesh.labels[n]) for n in facet)} is not on the "
                               "surface of the mesh")
            found[key] = outer[key]
        mesh.surfaces[fields.named(name)] = list(found.values())
    for name, nodes in raw.nsets.items():
        inside = np.zeros(len(mesh.X), dtype=bool)
        inside[list(nodes)] = True
        found = [f for key, f in outer.items() if inside[list(key)].all()]
        name = fields.named(name)
        if name not in mesh.surfaces and (len(found) < len(outer) or name in ENDS) and (found or name in ENDS):
            mesh.surfaces[name] = found
    taken = {}
    for end, name in zip(ENDS, names):
        usual = [s for s in mesh.surfaces if s.rpartition(".")[2] == end] or \
            [s for s in mesh.surfaces if re.match(rf"(.*\.)?_?{end}([_\-].*)?$", s)]
        if name:
            usual = [s for s in mesh.surfaces if s == fields.named(name)]
            if not usual:
                fail(raw.path, f"--{end.lower()} {name}: there is no such surface or set of nodes; there are "
                               f"{some(sorted(mesh.surfaces)) or 'none'}")
        if len(usual) > 1:
            fail(raw.path, f"{some(usual)} could all be {end}: name one by --{end.lower()}")
        taken[end] = usual[0] if usual else None
    if ends:
        if any(taken.values()):
            fail(raw.path, f"--ends: the mesh has {some(t for t in taken.values() if t)} already")
        mesh.surfaces.update(find_ends(mesh, outer, *ends))
    else:
        for end, name in taken.items():
            if name is None:
                fail(raw.path, f"has no surface or set of nodes {end}; there are {some(sorted(mesh.surfaces)) or 'none'}. "
                               f"Name one by --{end.lower()} NAME, or find the ends by --ends AXIS,TOLERANCE")
            if name != end:
                mesh.notes.append(f"{end} is {name}")
                mesh.surfaces[end] = mesh.surfaces[name]
    if wider:
        widen(mesh, outer, wider)
    held = []
    for end in ENDS:
        facets = mesh.surfaces[end]
        nodes = {n for f in facets for n in f}
        if not facets:
            given = raw.nsets.get(taken[end], []) if taken.get(end) else []
            fail(raw.path, f"{end} holds no facet of the mesh's surface" + (f" (its {len(given)} nodes span none)" if given else ""))
        held.append(nodes)
    shared = sorted(held[0] & held[1])
    if shared:
        fail(raw.path, f"PROXIMAL and DISTAL touch: they share {len(shared)} nodes: {some(mesh.labels[shared])}")


def find_ends(mesh, outer, axis, tolerance):
    """Facets that face along the axis, within 60 degrees, and whose nodes are all within the tolerance of the extreme."""
    sign, axis = (-1 if axis[0] == "-" else 1), "xyz".index(axis[-1])
    facets = list(outer.values())
    mesh.surfaces["?"] = facets
    vectors, *_ = mesh.facet_vectors("?")
    del mesh.surfaces["?"]
    facing = sign * vectors[:, axis] / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
    at = sign * mesh.X[:, axis]
    nodes = np.unique([n for f in facets for n in f])
    low, high = at[nodes].min(), at[nodes].max()
    found = {
        "PROXIMAL": [f for f, c in zip(facets, facing) if c < -0.5 and (at[list(f)] <= low + tolerance).all()],
        "DISTAL": [f for f, c in zip(facets, facing) if c > 0.5 and (at[list(f)] >= high - tolerance).all()],
    }
    for name, side, extreme in (("PROXIMAL", -1, low), ("DISTAL", 1, high)):
        held = {n for f in found[name] for n in f}
        if not held:
            needed = [np.abs(at[list(f)] - extreme).max() for f, c in zip(facets, facing) if side * c > 0.5]
            fail(mesh.raw.path, f"--ends: no facet that faces along {'xyz'[axis]} lies within {tolerance:g} mm of {'xyz'[axis]} = "
                 f"{sign * extreme:.6g} mm, for {name}" + (f"; the first does within {min(needed):.3g} mm" if needed else ""))
        mesh.notes.append(f"--ends: {name} are {len(found[name])} facets with {len(held)} nodes within {tolerance:g} mm of "
                          f"{'xyz'[axis]} = {sign * extreme:.6g} mm")
    return found


def check_fibres(mesh):
    if mesh.fibres is None:
        return
    length = np.linalg.norm(mesh.fibres, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 0)))
    if len(bad):
        fail(mesh.raw.cell(bad[0]), f"fibre {mesh.fibres[bad[0]]}: expected a finite direction of a length > 0" + also(mesh, bad))
    mesh.fibres /= length[:, None]
    mesh.notes.append(f"fibres by {mesh.raw.fibres_from}")


def checked(raw, unit, ends=None, names=(None, None), sections=None, wider=0):
    """The Mesh of what was read, or a FileError."""
    mesh = Mesh(raw, unit)
    turned = check_cells(mesh)
    index = check_nodes(mesh)
    outer = check_faces(mesh, turned)
    check_middles(mesh)
    choose_sections(mesh, sections)
    choose_surfaces(mesh, outer, ends, names, wider)
    check_fibres(mesh)
    mesh.outer_facets = len(outer)
    mesh.n_sets = {name: len(nodes) for name, nodes in raw.nsets.items()}
    keep = index >= 0
    mesh.X, mesh.labels = mesh.X[keep], mesh.labels[keep]
    mesh.nodes_of = {kind: index[nodes] for kind, nodes in mesh.nodes_of.items()}
    order = sorted(mesh.surfaces, key=lambda name: (ENDS.index(name) if name in ENDS else len(ENDS), name))
    mesh.surfaces = {name: sorted(tuple(int(index[n]) for n in f) for f in mesh.surfaces[name]) for name in order}
    extent = np.ptp(mesh.X, axis=0).max()
    if not 1 <= extent <= 2000:
        mesh.notes.append(f"WARNING: with --unit {unit} the mesh is {extent:.4g} mm long: is that the unit of the file?")
    return mesh


CORNER_PARTS = np.array([(0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3)])  # of a tetrahedron; 4 to 9: middles of EDGES
DIAGONALS = {(4, 9): (5, 6, 7, 8), (5, 7): (4, 6, 9, 8), (6, 8): (4, 5, 9, 7)}  # of the octahedron between them, and who surrounds them


def refine(mesh):
    """Parts each tetrahedron into eight; the octahedron in its middle along its shortest diagonal. Edges stay straight."""
    if list(mesh.kinds) != ["tet4"]:
        fail(mesh.path, f"--refine: must be 0 for a mesh of {', '.join(mesh.kinds)}: only tetrahedra of four nodes are refined")
    corners, n = mesh.nodes_of["tet4"], len(mesh.X)
    pairs, index = np.unique(np.sort(corners[:, EDGES].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    mesh.X = np.vstack([mesh.X, mesh.X[pairs].mean(axis=1)])
    nodes = np.hstack([corners, n + index.reshape(-1, 6)])
    lengths = np.stack([np.linalg.norm(mesh.X[nodes[:, a]] - mesh.X[nodes[:, b]], axis=1) for a, b in DIAGONALS])
    inner = np.array([[(a, b, ring[k], ring[k - 1]) for k in range(4)] for (a, b), ring in DIAGONALS.items()])
    parts = np.concatenate([np.broadcast_to(CORNER_PARTS, (len(nodes), 4, 4)), inner[np.argmin(lengths, axis=0)]], axis=1)
    cells = np.take_along_axis(nodes[:, None], parts, axis=2).reshape(-1, 4)
    other = determinants("tet4", mesh.X[cells], POINTS["tet4"][0])[:, 0] < 0
    cells[other] = cells[other][:, [0, 2, 1, 3]]
    middle = dict(zip(map(tuple, pairs.tolist()), range(n, len(mesh.X))))

    def four(f):
        m = [middle[tuple(sorted((f[k], f[(k + 1) % 3])))] for k in range(3)]
        return [(f[0], m[0], m[2]), (m[0], f[1], m[1]), (m[2], m[1], f[2]), tuple(m)]

    mesh.surfaces = {name: [part for f in facets for part in four(f)] for name, facets in mesh.surfaces.items()}
    mesh.kinds, mesh.nodes_of = {"tet4": np.arange(len(cells))}, {"tet4": cells}
    mesh.cell_kinds = ["tet4"] * len(cells)
    mesh.labels, mesh.cell_labels = np.arange(1, len(mesh.X) + 1), np.arange(1, len(cells) + 1)
    mesh.section = np.repeat(mesh.section, 8)
    mesh.fibres = None if mesh.fibres is None else np.repeat(mesh.fibres, 8, axis=0)
    mesh.sets = {name: (8 * of[:, None] + np.arange(8)).ravel() for name, of in mesh.sets.items()}
    mesh.outer_facets *= 4
    return mesh


def read_raw(path, names=None, region=None, fibre=None):
    suffix = pathlib.Path(path).suffix.lower()
    if suffix not in (".inp", ".msh", ".vtk", ".vtu"):
        fail(path, "expected a file .inp (Abaqus), .msh (Gmsh), .vtk or .vtu")
    for option, value, fits in (("names", names, suffix != ".inp"), ("region", region, suffix in (".vtk", ".vtu"))):
        if value and not fits:
            fail(path, f"--{option} is not for {suffix} files")
    if suffix == ".inp":
        if fibre not in (None, "1", "2", "3"):
            fail(path, f"--fibre {files.shown(fibre)}: of a deck, expected 1, 2 or 3, the axis of *ORIENTATION that is the fibre")
        return inp.read(path, fibre and int(fibre))
    return fields.read_msh(path, names, fibre) if suffix == ".msh" else fields.read_meshio(path, names, region, fibre)


# ---- What is said and written

def report(mesh):
    """The text to read before a run."""
    low, high = mesh.X.min(axis=0), mesh.X.max(axis=0)
    volume, q = mesh.each(volumes), mesh.each(quality)
    lines = [f"{mesh.path}: {len(mesh.X)} nodes, " + ", ".join(f"{len(c)} {k}" for k, c in mesh.kinds.items())
             + f"; lengths in mm, from {mesh.unit}",
             f"  volume         {volume.sum():.6g} mm3",
             "  bounding box   " + " x ".join(f"{d:.5g}" for d in high - low) + " mm: " +
             ", ".join(f"{a} {l:.6g} to {h:.6g}" for a, l, h in zip("xyz", low, high)),
             f"  quality        least {q.min():.3f} (element {mesh.cell_labels[np.argmin(q)]}), 5 % {np.percentile(q, 5):.3f}, "
             f"median {np.median(q):.3f}; 1: regular, 0: flat"]
    poor = np.flatnonzero(q < 0.1)
    if len(poor):
        lines.append(f"                 below 0.1: {len(poor)} elements, {some(mesh.cell_labels[poor[np.argsort(q[poor])]], 10)}")
    for k, name in enumerate(mesh.sections):
        inside = mesh.section == k
        lines.append(f"  section        {name}: {inside.sum()} elements, {volume[inside].sum():.6g} mm3")
    if mesh.sets:
        lines.append("  element sets   " + ", ".join(f"{name} ({len(cells)})" for name, cells in mesh.sets.items()))
    if mesh.n_sets:
        lines.append("  node sets      " + ", ".join(f"{name} ({n})" for name, n in mesh.n_sets.items()))
    lines.append(f"  surface        {mesh.outer_facets} facets")
    for name, facets in mesh.surfaces.items():
        nodes = {n for f in facets for n in f}
        lines.append(f"  {'attachment' if name in ENDS else 'surface':14} {name}: {len(facets)} facets, {len(nodes)} corner nodes, "
                     f"{mesh.area(name):.6g} mm2")
    line = mesh.centroid("DISTAL") - mesh.centroid("PROXIMAL")
    lines.append(f"  line           {np.linalg.norm(line):.6g} mm from PROXIMAL's centroid to DISTAL's, along "
                 + ", ".join(f"{x:.4f}" for x in line / np.linalg.norm(line)))
    return "\n".join(lines + [f"  note           {note}" for note in mesh.notes]) + "\n"


def neutral(mesh):
    """The text of the solver's file."""
    lines = ["myogrowth mesh 1", f"nodes {len(mesh.X)}"]
    lines += ["%d %.17g %.17g %.17g" % (label, *x) for label, x in zip(mesh.labels.tolist(), mesh.X.tolist())]
    lines += [f"sections {len(mesh.sections)}", *mesh.sections, f"cells {len(mesh.cell_labels)}"]
    order = []
    for kind, cells in mesh.kinds.items():
        order += cells.tolist()
        lines += [f"{kind} {label} {section} " + " ".join(map(str, nodes)) for label, section, nodes in zip(
            mesh.cell_labels[cells].tolist(), mesh.section[cells].tolist(), mesh.nodes_of[kind].tolist())]
    lines.append(f"surfaces {len(mesh.surfaces)}")
    for name, facets in mesh.surfaces.items():
        lines += [f"{name} {len(facets)}", *(" ".join(map(str, f)) for f in facets)]
    lines.append(f"fibres {0 if mesh.fibres is None else len(order)}")
    if mesh.fibres is not None:
        lines += ["%.17g %.17g %.17g" % tuple(mesh.fibres[c]) for c in order]
    place = np.empty(len(order), dtype=int)
    place[order] = np.arange(len(order))
    lines.append(f"sets {len(mesh.sets)}")
    for name, cells in mesh.sets.items():
        lines += [f"{name} {len(cells)}", *map(str, np.sort(place[cells]).tolist())]
    return "\n".join(lines) + "\n"


# ---- Options, shared with muscle.py

def add_options(p):
    p.add_argument("mesh", nargs="?", metavar="MESH", help="Abaqus .inp, Gmsh .msh, .vtk or .vtu; none: the built-in muscle")
    p.add_argument("--unit", choices=UNITS, help="of the lengths in MESH; has no default")
    p.add_argument("--ends", metavar="AXIS,TOLERANCE", help="finds the attachments of a mesh without sets: the facets within "
                   "TOLERANCE [mm] of the least AXIS (x, y or z; PROXIMAL) and of the greatest (DISTAL); -z: the other way round")
    p.add_argument("--proximal", metavar="NAME", help="the surface or set of nodes that is PROXIMAL")
    p.add_argument("--distal", metavar="NAME", help="the same for DISTAL")
    p.add_argument("--widen", type=files.number(), default=0, metavar="MM", help="adds to PROXIMAL and DISTAL the facets of the surface "
                   "within MM of them; MM < 0 takes away those within -MM of their border: to see what the areas decide")
    p.add_argument("--sections", metavar="A,B,...", help="the element sets that part the mesh; each needs a material")
    p.add_argument("--refine", type=files.number(0, 4, kind=int), default=0, metavar="N", help="parts each tetrahedron into eight, N "
                   "times; nodes and elements get new numbers")
    p.add_argument("--names", metavar="N=NAME,...", help="names of Gmsh's groups without one, or of regions of a .vtk or .vtu")
    p.add_argument("--region", metavar="FIELD", help="the cell data of a .vtk or .vtu with the numbers of regions")
    p.add_argument("--fibre", metavar="FIELD", help="the data of cells, or of points, with fibre directions; of an Abaqus deck 1, 2 or 3, "
                   "the axis of *ORIENTATION that is the fibre")
    fusiform.add_options(p)


def joined(words):
    """`--ends -z,2` as one word, which argparse would take for two options."""
    words = list(words)
    for i in reversed(range(len(words) - 1)):
        if words[i] == "--ends" and re.match(r"-[xyz],", words[i + 1]):
            words[i:i + 2] = [f"--ends={words[i + 1]}"]
    return words


def from_options(p, a):
    """The Mesh that the options ask for; `p` tells of wrong ones."""
    shape = fusiform.from_options(p, a)
    if a.mesh is None:
        given = [name for name in ("unit", "ends", "proximal", "distal", "sections", "widen", "refine", "names", "region", "fibre") if getattr(a, name)]
        if given:
            p.error(f"--{given[0]} needs a MESH")
        return checked(fusiform.raw(shape), "mm")
    changed = fusiform.changed(a)
    if changed:
        p.error(f"--{changed[0].replace('_', '-')} is of the built-in muscle, not of {a.mesh}")
    if a.unit is None:
        p.error("--unit is needed, the unit of the lengths in the file: mm, cm, m or um")
    ends = None
    if a.ends:
        match = re.fullmatch(r"(-?[xyz]),([^,]+)", a.ends)
        try:
            tolerance = files.number(above=0)(match[2] if match else "")
        except argparse.ArgumentTypeError:
            p.error(f"--ends {a.ends}: expected x, y, z, -x, -y or -z, a comma, and a tolerance > 0 in mm")
        ends = (match[1], tolerance)
    names = None
    if a.names:
        pairs = [pair.partition("=") for pair in a.names.split(",")]
        if not all(re.fullmatch(r"-?\d+", n) and name for n, _, name in pairs):
            p.error(f"--names {a.names}: expected NUMBER=NAME, parted by commas")
        names = {n: name for n, _, name in pairs}
    raw = read_raw(a.mesh, names, a.region, a.fibre)
    mesh = checked(raw, a.unit, ends, (a.proximal, a.distal), a.sections.split(",") if a.sections else None, a.widen)
    for _ in range(a.refine):
        mesh = refine(mesh)
    return mesh


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(p)
    p.add_argument("-o", "--output", metavar="FILE", help="the mesh as the solver reads it")
    a = p.parse_args(joined(sys.argv[1:]))
    with files.faults_in_one_line("mesh.py"):
        mesh = from_options(p, a)
        print(report(mesh), end="")
        if a.output:
            files.write_text(a.output, neutral(mesh), encoding="ascii")


if __name__ == "__main__":
    main()
