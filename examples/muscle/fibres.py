"""Fibres by potential flow, as the solver makes them: for decks of other codes, and to check it.

div grad phi = 0, phi = 0 on one surface, 1 on the other, no flux through the rest; n0 = grad phi/|grad phi| at the
integration points. Where all nodes of a cell are on one surface there is no gradient: the neighbours' mean holds.
"""
import numpy as np

import mesh as meshes
from raw import fail

# The points of CalculiX's elements, in its order, and their weights.
_HEX = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / np.sqrt(3)
POINTS = {
    "tet4": meshes.POINTS["tet4"][:2], "tet10": meshes.POINTS["tet10"][:2], "hex8": (_HEX, 1.0),
    "wedge6": (np.array([[1 / 3, 1 / 3, -1 / np.sqrt(3)], [1 / 3, 1 / 3, 1 / np.sqrt(3)]]), 0.5),
}


def _gradients(mesh):
    """Of each type: (cells, points, nodes, 3) gradients of the shape functions and (cells, points) volumes."""
    found = {}
    for kind in mesh.kinds:
        at, weight = POINTS[kind]
        derivatives = meshes.shape_derivatives(kind, at)
        J = np.einsum("cni,pnj->cpij", mesh.corners(kind), derivatives)
        found[kind] = np.einsum("pnj,cpji->cpni", derivatives, np.linalg.inv(J)), np.linalg.det(J) * weight
    return found


def surface_nodes(mesh, name):
    """(nodes,) true for the nodes of a surface's facets, those between their corners included."""
    on = np.zeros(len(mesh.X), dtype=bool)
    on[[n for f in mesh.surfaces[name] for n in f]] = True
    if "tet10" in mesh.kinds:
        edges = {tuple(sorted((f[k], f[k - 1]))) for f in mesh.surfaces[name] for k in range(3)}
        nodes = mesh.nodes_of["tet10"]
        for e, (a, b) in enumerate(meshes.EDGES):
            pairs = np.sort(nodes[:, [a, b]], axis=1)
            on[[m for m, pair in zip(nodes[:, 4 + e], map(tuple, pairs.tolist())) if pair in edges]] = True
    return on


def potential(mesh, start, end, gradients):
    """phi in the nodes, by conjugate gradients; `start` and `end` are names of surfaces, or several parted by commas."""
    fixed = [np.any([surface_nodes(mesh, name.strip()) for name in names.split(",")], axis=0) for names in (start, end)]
    if (fixed[0] & fixed[1]).any():
        fail(mesh.path, f"{start} and {end} touch")
    phi, free = fixed[1].astype(float), ~(fixed[0] | fixed[1])
    K = {kind: np.einsum("cp,cpai,cpbi->cab", w, g, g) for kind, (g, w) in gradients.items()}

    def apply(x):
        y = np.zeros_like(x)
        for kind, k in K.items():
            nodes = mesh.nodes_of[kind]
            y += np.bincount(nodes.ravel(), np.einsum("cab,cb->ca", k, x[nodes]).ravel(), len(x))
        return y

    diagonal = sum(np.bincount(mesh.nodes_of[kind].ravel(), np.einsum("caa->ca", k).ravel(), len(phi)) for kind, k in K.items())
    r = np.where(free, -apply(phi), 0)
    z = r / diagonal
    p, rz, limit = z.copy(), r @ z, 1e-13 * np.linalg.norm(r)
    for _ in range(100000):
        if np.linalg.norm(r) <= limit:
            return phi
        Ap = np.where(free, apply(p), 0)
        step = rz / (p @ Ap)
        phi += step * p
        r -= step * Ap
        z = r / diagonal
        rz, old = r @ z, rz
        p = z + rz / old * p
    fail(mesh.path, "the potential of the fibres was not found in 100000 iterations")


def flow(mesh, start="PROXIMAL", end="DISTAL"):
    """{type: (cells, points, 3) unit vectors}, and the number of cells without a gradient."""
    gradients = _gradients(mesh)
    phi = potential(mesh, start, end, gradients)
    line = mesh.centroid("DISTAL") - mesh.centroid("PROXIMAL")
    least = 1e-6 / np.linalg.norm(line)
    n0, missing, mean = {}, {}, {}
    for kind, (g, w) in gradients.items():
        slope = np.einsum("cpai,ca->cpi", g, phi[mesh.nodes_of[kind]])
        length = np.linalg.norm(slope, axis=2)
        missing[kind] = ~(length > least)
        n0[kind] = np.where(missing[kind][..., None], 0, slope / np.where(missing[kind], 1, length)[..., None])
        mean[kind] = np.einsum("cp,cpi->ci", w, n0[kind])
    lacking = int(sum(m.any(axis=1).sum() for m in missing.values()))
    for _ in range(100):
        if not any(m.any() for m in missing.values()):
            break
        total = np.zeros((len(phi), 3))
        for kind in n0:
            nodes = mesh.nodes_of[kind]
            np.add.at(total, nodes.ravel(), np.repeat(mean[kind], nodes.shape[1], axis=0))
        for kind, (_, w) in gradients.items():
            cells = np.flatnonzero(missing[kind].any(axis=1))
            n = total[mesh.nodes_of[kind][cells]].sum(axis=1)
            length = np.linalg.norm(n, axis=1)
            cells, n = cells[length > 0], n[length > 0] / length[length > 0][:, None]
            mean[kind][cells] += (w[cells] * missing[kind][cells]).sum(axis=1)[:, None] * n
            n0[kind][cells] = np.where(missing[kind][cells][..., None], n[:, None], n0[kind][cells])
            missing[kind][cells] = False
    for kind in n0:
        n0[kind][missing[kind]] = line / np.linalg.norm(line)
    return n0, lacking


def at_points(mesh, kind, direction=None, start="PROXIMAL", end="DISTAL", of_sets=()):
    """{type: (cells, points, 3)} by the Fibre/Kind of the solver: default, flow, mesh or uniform. `of_sets`: (set, kind,
    direction, start, end) of Fibre/List."""
    n0 = _of_all(mesh, kind, direction, start, end)
    for name, *of in of_sets:
        own = _of_all(mesh, *of)
        inside = np.zeros(len(mesh.cell_labels), dtype=bool)
        inside[mesh.sets[name] if name in mesh.sets else mesh.section == mesh.sections.index(name)] = True
        for k, cells in mesh.kinds.items():
            n0[k][inside[cells]] = own[k][inside[cells]]
    return n0


def _of_all(mesh, kind, direction, start, end):
    if kind == "default":
        kind = "flow" if mesh.fibres is None else "mesh"
    if kind == "flow":
        return flow(mesh, start, end)[0]
    if kind == "mesh" and mesh.fibres is None:
        fail(mesh.path, "Fibre/Kind = mesh: the mesh has no fibres")
    n = np.tile(direction / np.linalg.norm(direction), (len(mesh.cell_labels), 1)) if kind == "uniform" else mesh.fibres
    return {k: np.repeat(n[cells][:, None], len(POINTS[k][0]), axis=1) for k, cells in mesh.kinds.items()}


def of_elements(mesh, n0):
    """(cells, 3) the mean direction of each cell."""
    n = np.zeros((len(mesh.cell_labels), 3))
    for kind, cells in mesh.kinds.items():
        n[cells] = n0[kind].sum(axis=1)
    return n / np.linalg.norm(n, axis=1)[:, None]
