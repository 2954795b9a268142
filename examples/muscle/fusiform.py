"""The built-in muscle: a spindle of hexahedra along z, round, with a tendon at either end; mm.

Sizes are assumptions of this project, near the biceps femoris, long head, of the Visible Human (252 mm long,
182,000 mm3): the muscle's length, its diameters at the belly and at the tendons, the tendons' length. The radius is
that of the tendon and a sine squared more. Pennation is 0 by default, so that the solver makes the fibres by potential
flow; Ward et al. 2009 (Clin Orthop Relat Res 467:1074) measured 11.6 degrees in this muscle. With pennation > 0 the
fibres are inclined from the meridians to the axis, distally, by this angle on the surface and in proportion to the
radius inside.
"""
from typing import NamedTuple

import numpy as np

from raw import Cell, Raw
from shared import files


class Shape(NamedTuple):
    """What is built."""

    length: float = 250.0
    belly_diameter: float = 40.0
    end_diameter: float = 14.0
    tendon_length: float = 40.0
    pennation: float = 0.0
    fineness: int = 1


OPTIONS = {
    "length": (files.number(above=0), "of the built-in muscle between its tendons [mm]"),
    "belly_diameter": (files.number(above=0), "half way along [mm]"),
    "end_diameter": (files.number(above=0), "of the tendons, and of the muscle at them [mm]"),
    "tendon_length": (files.number(0), "of either tendon; 0: none [mm]"),
    "pennation": (files.number(0, below=60), "of the fibres on the surface [degrees]; 0: by potential flow"),
    "fineness": (files.number(1, 8, kind=int), "of the mesh: 1 has 3,072 hexahedra, 2 eight times as many"),
}


def add_options(p):
    for name, (kind, text) in OPTIONS.items():
        p.add_argument("--" + name.replace("_", "-"), type=kind, metavar="X", help=f"{text}, {getattr(Shape(), name):g} if not given")


def changed(a):
    return [name for name in OPTIONS if getattr(a, name) is not None]


def from_options(p, a):
    shape = Shape()._replace(**{name: getattr(a, name) for name in changed(a)})
    if shape.end_diameter > shape.belly_diameter:
        p.error(f"--end-diameter = {shape.end_diameter:g}: must be <= --belly-diameter = {shape.belly_diameter:g}")
    if max(shape.length, shape.belly_diameter) > 1000 * min(shape.length, shape.end_diameter):
        p.error("--length and the diameters differ by more than a factor of 1000")
    return shape


def disc(n):
    """Quadrilaterals of the unit disc: a square of n x n, and n/2 + 1 rings round it. Places (nodes, 2) and cells."""
    side = 0.45  # of the half square, with bulged edges
    ids, places, cells = {}, [], []

    def node(p):
        key = (round(p[0], 9), round(p[1], 9))
        if key not in ids:
            ids[key] = len(places)
            places.append(p)
        return ids[key]

    def square(u, v):  # u, v from -1 to 1
        return (side * u * (1 + 0.15 * (1 - v * v)), side * v * (1 + 0.15 * (1 - u * u)))

    at = np.linspace(-1, 1, n + 1)
    for i in range(n):
        for j in range(n):
            cells.append([node(square(at[a], at[b])) for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))])
    rings = n // 2 + 1
    edge = [(x, -1.0) for x in at[:-1]] + [(1.0, x) for x in at[:-1]] + [(-x, 1.0) for x in at[:-1]] + [(-1.0, -x) for x in at[:-1]]

    def ring(k, i):
        u, v = edge[i % len(edge)]
        x, y = square(u, v)
        angle = np.arctan2(-1, -1) + 2 * np.pi * (i % len(edge)) / len(edge)
        s = k / rings
        return ((1 - s) * x + s * np.cos(angle), (1 - s) * y + s * np.sin(angle))

    for k in range(rings):
        for i in range(len(edge)):
            cells.append([node(ring(k, i)), node(ring(k + 1, i)), node(ring(k + 1, i + 1)), node(ring(k, i + 1))])
    return np.array(places), np.array(cells)


def radius(shape, z):
    """Of the muscle at z from 0 to its length; the tendons' beyond."""
    s = np.clip(z / shape.length, 0, 1)
    return shape.end_diameter / 2 + (shape.belly_diameter - shape.end_diameter) / 2 * np.sin(np.pi * s)**2


def raw(shape):
    n = 4 * shape.fineness
    places, quads = disc(n)
    muscle = np.linspace(0, shape.length, 40 * shape.fineness + 1)
    tendon = np.linspace(0, shape.tendon_length, 4 * shape.fineness + 1) if shape.tendon_length > 0 else np.zeros(1)
    z = np.concatenate([-tendon[:0:-1], muscle, shape.length + tendon[1:]])
    r = radius(shape, z)
    # The section is a polygon with its corners on the circle. It gets the circle's area.
    corners = 4 * n
    scale = np.sqrt(2 * np.pi / (corners * np.sin(2 * np.pi / corners)))
    X = np.concatenate([np.column_stack([scale * ri * places, np.full(len(places), zi)]) for ri, zi in zip(r, z)])
    layers = [np.hstack([quads + k * len(places), quads + (k + 1) * len(places)]) for k in range(len(z) - 1)]
    cells = np.concatenate(layers)
    result = Raw("the built-in muscle", ["the built-in muscle"])
    result.nodes, result.node_labels = list(map(tuple, X.tolist())), list(range(1, len(X) + 1))
    result.node_places = [(0, 0)] * len(X)
    result.cells = [Cell("hex8", i, nodes, (0, 0)) for i, nodes in enumerate(cells.tolist(), 1)]
    middle = X[cells].mean(axis=1)
    is_muscle = (middle[:, 2] > 0) & (middle[:, 2] < shape.length)
    result.elsets = {"MUSCLE": np.flatnonzero(is_muscle).tolist()}
    if not is_muscle.all():
        result.elsets["TENDON"] = np.flatnonzero(~is_muscle).tolist()
    last = (len(z) - 1) * len(places)
    result.surfaces = {"PROXIMAL": [tuple(q) for q in quads.tolist()], "DISTAL": [tuple(q) for q in (quads + last).tolist()]}
    result.stretch = 0.1 * shape.length / (shape.length + 2 * shape.tendon_length)  # of all, for a tenth of the muscle's length
    result.notes.append(f"built in: length {shape.length:g}, belly {shape.belly_diameter:g}, ends {shape.end_diameter:g}, tendons "
                        f"{shape.tendon_length:g} mm, pennation {shape.pennation:g} degrees")
    if shape.pennation:
        result.fibres, result.fibres_from = fibres(shape, middle).tolist(), "the built-in muscle's pennation"
    return result


def fibres(shape, places):
    """(n, 3) unit vectors at places."""
    x, y, z = places.T
    distance = np.hypot(x, y)
    h = 1e-6 * shape.length
    R = radius(shape, z)
    slope = (radius(shape, z + h) - radius(shape, z - h)) / (2 * h)
    inclination = np.arctan(slope * distance / R) - np.where((z > 0) & (z < shape.length), np.radians(shape.pennation), 0) * distance / R
    outward = np.divide([x, y], distance, out=np.zeros((2, len(x))), where=distance > 0)
    return np.column_stack([*(np.sin(inclination) * outward), np.cos(inclination)])
