"""Writes an Abaqus deck of the biceps femoris as a cylinder: 400 mm long, 20 mm in diameter, its fibres along the axis.

make_cylinder.py [--size coarse|paper] [-o DECK]

One end is fixed, the other is moved by 40 mm along the axis in one day and held there to day 42. The mesh is a disc of
quadrilaterals and triangles swept in layers, C3D8 and C3D6; `paper` has as many of each as the paper: 38,556 and
14,931. The paper does not show its disc; this one has a node in the centre and rings around it.
"""
import argparse
import math
import sys

LENGTH, RADIUS, PULL = 400.0, 10.0, 40.0  # mm

#        nodes in the rings, quadrilaterals in the disc, layers, first increment [days]
SIZES = {
    "coarse": ([6, 12, 18, 24], 36, 30, 0.05),
    "paper": ([6 * k for k in range(1, 9)] + [55], 204, 189, 0.02),
}

DECK = """*HEADING
myogrowth: biceps femoris as a cylinder, {n_hex} C3D8 and {n_wedge} C3D6, 10 % stretch in one day, held to day 42
** Written by make_cylinder.py --size {size}. Units mm, kPa, mN, days. Never run in Abaqus by us: see README.md.
** Axis and fibres along z.
**
*NODE, NSET=ALL
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=MUSCLE
{hexes}
*ELEMENT, TYPE=C3D6, ELSET=MUSCLE
{wedges}
*NSET, NSET=PROXIMAL, GENERATE
1, {disc}, 1
*NSET, NSET=DISTAL, GENERATE
{distal}, {last}, 1
** A layer half way along
*ELSET, ELSET=MIDDLE, GENERATE
{middle}
*SOLID SECTION, ELSET=MUSCLE, MATERIAL=MUSCLE
*MATERIAL, NAME=MUSCLE
*DEPVAR
8
1, G, "relative serial sarcomere number"
2, LAMBDA_E, "elastic fibre stretch"
3, LAMBDA, "total fibre stretch"
4, J, "volume ratio"
5, JE, "elastic volume ratio"
6, N0_1, "reference fibre direction"
7, N0_2, "(second component)"
8, N0_3, "(third component)"
** c1, c2 [kPa], tau [days], gamma, G_max, lambda_crit (Table 1), n0_1, n0_2; then n0_3
*USER MATERIAL, CONSTANTS=9, UNSYMM
16., 4., 0.5, 2., 1.1, 1.01, 0., 0.,
1.
*AMPLITUDE, NAME=PULL, TIME=TOTAL TIME
** time [days], share of the stretch: ramped over one day, held to day 42
0., 0., 1., 1., 42., 1.
*BOUNDARY
PROXIMAL, 1, 3
DISTAL, 1, 2
**
** The first increment moves the end by less than a layer's height, so that no start can turn the last layer inside out.
*STEP, NAME=RAMP, NLGEOM=YES, UNSYMM=YES, INC=1000
one day: stretched by 10 %
*STATIC
{first}, 1., 1.E-6, 0.05
*BOUNDARY, AMPLITUDE=PULL
DISTAL, 3, 3, {pull}
{output}**
*STEP, NAME=HOLD, NLGEOM=YES, UNSYMM=YES, INC=1000
to day 42: held
*STATIC
0.05, 41., 1.E-6, 1.
{output}"""

OUTPUT = """*OUTPUT, FIELD, FREQUENCY=10
*ELEMENT OUTPUT
S, LE, SDV
*NODE OUTPUT
U, RF
*OUTPUT, HISTORY, FREQUENCY=1
*ELEMENT OUTPUT, ELSET=MIDDLE
SDV1, SDV2, SDV3
*NODE PRINT, NSET=DISTAL, FREQUENCY=1, SUMMARY=NO, TOTALS=YES
RF3
*END STEP
"""


def rings(counts):
    """Points of the disc, the centre first, and the index of every ring's nodes."""
    points, index = [(0.0, 0.0)], [[0]]
    for k, n in enumerate(counts, 1):
        r = RADIUS * k / len(counts)
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


def deck(size):
    counts, n_quads, layers, first = SIZES[size]
    points, index = rings(counts)
    quads, tris = merge(points, triangles(index), n_quads)
    disc = len(points)

    nodes = []
    for layer in range(layers + 1):
        z = LENGTH * layer / layers
        nodes += [f"{layer * disc + i + 1}, {x:.9g}, {y:.9g}, {z:.9g}" for i, (x, y) in enumerate(points)]

    def swept(cells, label):
        lines = []
        for layer in range(layers):
            for cell in cells:
                corners = [level * disc + i + 1 for level in (layer, layer + 1) for i in cell]
                lines.append(", ".join(map(str, [label + len(lines), *corners])))
        return "\n".join(lines)

    n_hex, n_wedge = len(quads) * layers, len(tris) * layers
    half = layers // 2
    middle = [f"{start + half * n + 1}, {start + (half + 1) * n}, 1" for start, n in ((0, len(quads)), (n_hex, len(tris)))]
    return DECK.format(size=size, n_hex=n_hex, n_wedge=n_wedge, nodes="\n".join(nodes), hexes=swept(quads, 1),
                       wedges=swept(tris, n_hex + 1), disc=disc, distal=layers * disc + 1, last=(layers + 1) * disc,
                       middle="\n".join(middle), first=first, pull=PULL, output=OUTPUT)


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], epilog=__doc__.split("\n\n")[2],
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--size", choices=SIZES, default="coarse", help="how fine the mesh is (default: %(default)s)")
    p.add_argument("-o", "--output", metavar="DECK", help="file to write; the standard output without")
    a = p.parse_args()
    text = deck(a.size)
    if a.output:
        with open(a.output, "w", encoding="ascii", newline="\n") as f:
            f.write(text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
