"""Writes an Abaqus deck of the biceps femoris as a cylinder: 400 mm long, 20 mm in diameter, its fibres along the axis.

make_cylinder.py [--size coarse|paper] [-o DECK]

One end is fixed, the other is moved by 40 mm along the axis in one day and held there to day 42. The mesh is a disc of
quadrilaterals and triangles swept in layers, C3D8 and C3D6 (../calculix/cylinder_mesh.py); `paper` has as many of each
as the paper: 38,556 and 14,931. Needs numpy.
"""
import argparse
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "calculix"))
import cylinder_mesh  # noqa: E402  the mesh is the one that runs in CalculiX
from shared import files  # noqa: E402

PULL = 40.0  # mm
FIRST = {"coarse": 0.02, "paper": 0.02}  # days, the first increment of every size

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
** The first increment moves the end by less than a layer's height, so that it cannot invert the last layer.
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


def deck(size):
    m = cylinder_mesh.mesh(size)
    nodes = [f"{i}, {x:.9g}, {y:.9g}, {z:.9g}" for i, (x, y, z) in enumerate(m.nodes.tolist(), 1)]

    def lines(cells, label):
        numbered = np.column_stack([label + np.arange(len(cells)), cells + 1]).tolist()
        return "\n".join(", ".join(map(str, row)) for row in numbered)

    n_hex, n_wedge, layers = len(m.hexes), len(m.wedges), len(m.levels) - 1
    half = layers // 2
    middle = [f"{start + half * n + 1}, {start + (half + 1) * n}, 1"
              for start, n in ((0, n_hex // layers), (n_hex, n_wedge // layers))]
    return DECK.format(size=size, n_hex=n_hex, n_wedge=n_wedge, nodes="\n".join(nodes), hexes=lines(m.hexes, 1),
                       wedges=lines(m.wedges, n_hex + 1), disc=m.proximal[-1] + 1, distal=m.distal[0] + 1,
                       last=m.distal[-1] + 1, middle="\n".join(middle), first=FIRST[size], pull=PULL, output=OUTPUT)


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], epilog=__doc__.split("\n\n")[2],
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--size", choices=FIRST, default="coarse", help="how fine the mesh is (default: %(default)s)")
    p.add_argument("-o", "--output", metavar="DECK", help="file to write (default: standard output)")
    a = p.parse_args()
    with files.faults_in_one_line("make_cylinder.py"):
        files.write_text_or_print(a.output, deck(a.size), encoding="ascii")


if __name__ == "__main__":
    main()
