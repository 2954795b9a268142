"""Cubes in CalculiX with libMYOGROWTH.so, held against the one-element driver, which calls the UMAT.

test_cubes.py CCX LIBRARY_FOLDER DRIVER UMAT SOURCE [unittest arguments]; every class is a ctest. Status 77: no CCX.

Stresses are in mPa (kPa 1e6): ccx takes residual forces below 1e-6 of its units for zero. Lengths are 1, times days.
"""
import csv
import itertools
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

CCX, LIBRARIES, DRIVER, UMAT, SOURCE = sys.argv[1], *(pathlib.Path(p).resolve() for p in sys.argv[2:6])
if not CCX or not os.access(CCX, os.X_OK):
    print(f'skipped: no ccx that loads libraries at "{CCX}" (MYOGROWTH_CCX; examples/calculix/build_ccx.sh builds one)')
    sys.exit(77)

INTEGRATION_POINTS = {"C3D8": 8, "C3D6": 2, "C3D4": 1, "C3D20": 27, "C3D20R": 8, "C3D10": 4}
TYPES = list(INTEGRATION_POINTS)
MUSCLE = (16e6, 4e6, 0.5, 2, 1.1, 1.01)
OBLIQUE = (0.6, 0.48, 0.64)
LIBRARY = "@ABAQUS_MYOGROWTH_CCX"
PRINT = 1e-6  # .dat has seven digits
FACES = {f"{axis}{side}": (i, float(side == "+")) for i, axis in enumerate("xyz") for side in "-+"}


class Mesh:
    """The unit cube in n^3 cells, each a brick, two wedges or six tetrahedra, with nodes at mid-edges if asked for."""

    def __init__(self, kind, n):
        self.kind, self.nodes, self.elements = kind, {}, []
        corner = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        if kind in ("C3D4", "C3D10"):
            parts = [self.path(order) for order in itertools.permutations(range(3))]
            edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
        elif kind == "C3D6":
            parts = [[corner[i] for i in (0, 1, 2, 4, 5, 6)], [corner[i] for i in (0, 2, 3, 4, 6, 7)]]
        else:
            parts = [corner]
            edges = [(i, (i + 1) % 4) for i in range(4)] + [(4 + i, 4 + (i + 1) % 4) for i in range(4)]
            edges += [(i, i + 4) for i in range(4)]
        for cell in itertools.product(range(n), repeat=3):
            for part in parts:
                points = [tuple((c + x) / n for c, x in zip(cell, point)) for point in part]
                if kind in ("C3D10", "C3D20", "C3D20R"):
                    points += [tuple((a + b) / 2 for a, b in zip(points[i], points[j])) for i, j in edges]
                self.elements.append([self.nodes.setdefault(p, len(self.nodes) + 1) for p in points])
        self.where = {number: point for point, number in self.nodes.items()}

    @staticmethod
    def path(order):
        """The tetrahedron along a way from corner to corner over edges in the directions of `order`."""
        points = [(0, 0, 0)]
        for axis in order:
            points.append(tuple(x + (i == axis) for i, x in enumerate(points[-1])))
        even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        return points if even else [points[1], points[0], *points[2:]]

    def on(self, face):
        axis, side = FACES[face]
        return [number for number, point in self.where.items() if point[axis] == side]

    def boundary(self):
        return [number for number, point in self.where.items() if {0, 1} & set(point)]

    def forces(self, face):
        """Nodal forces of a unit traction on a face: the integrals of its shape functions."""
        corners = {"C3D8": 8, "C3D6": 6, "C3D4": 4, "C3D20": 8, "C3D20R": 8, "C3D10": 4}[self.kind]
        result, on = {}, set(self.on(face))
        area = 1 / round((len(self.elements) / {8: 1, 6: 2, 4: 6}[corners]) ** (1 / 3)) ** 2  # of a cell's face
        for element in self.elements:
            corner = [node for node in element[:corners] if node in on]
            middle = [node for node in element[corners:] if node in on]
            if len(corner) == 4:
                weights = [-1 / 12] * 4 + [1 / 3] * 4 if middle else [1 / 4] * 4
            elif len(corner) == 3:
                weights = [0] * 3 + [1 / 6] * 3 if middle else [1 / 6] * 3
            else:
                continue
            for node, weight in zip(corner + middle, weights):
                result[node] = result.get(node, 0) + weight * area
        return result


def numbered(cards, per_line=8):
    cards = [str(c) for c in cards]
    return "".join(",".join(cards[i : i + per_line]) + "\n" for i in range(0, len(cards), per_line))


class Job:
    """A run of ccx in a folder of its own. `steps`: the cards of each *STEP."""

    def __init__(self, mesh, steps, props=MUSCLE, n0=(1, 0, 0), in_state=False, material=LIBRARY, fixed="", more=(),
                 reactions="x+", controls="1.E-9,1.E-7,,,1.E-9,,,1.E-13", threads=1, constants=None):
        props = (*props, *((0, 0, 1) if in_state else n0), *more)
        deck = "*NODE,NSET=ALL\n" + "".join(f"{n},{x},{y},{z}\n" for n, (x, y, z) in mesh.where.items())
        deck += f"*ELEMENT,TYPE={mesh.kind},ELSET=E\n"
        for i, nodes in enumerate(mesh.elements):  # a comma at a line's end: it goes on
            deck += numbered([i + 1, *nodes]).replace("\n", ",\n", len(nodes) // 8)
        for face in FACES:
            deck += f"*NSET,NSET={set_name(face)}\n" + numbered(mesh.on(face))
        deck += "*NSET,NSET=SURFACE\n" + numbered(mesh.boundary())
        n, lines = constants or (len(props), numbered(props) + ("0.\n" if len(props) % 8 == 0 else ""))
        deck += f"*MATERIAL,NAME={material}\n*USER MATERIAL,CONSTANTS={n}\n{lines}*DEPVAR\n8\n"
        deck += f"*SOLID SECTION,ELSET=E,MATERIAL={material}\n"
        if in_state:  # ccx 2.20 reads one point per card, and six variables
            for element, point in itertools.product(range(len(mesh.elements)), range(INTEGRATION_POINTS[mesh.kind])):
                deck += "*INITIAL CONDITIONS,TYPE=SOLUTION\n" + numbered([element + 1, point + 1, 0.0, *n0, -1.0, 0.0])
        deck += fixed
        for step in steps:
            deck += "*STEP,NLGEOM,INC=100000\n" + step
            # residuals alone decide, to 1e-9; ten iterations before the rate is judged, forty at most
            deck += f"*CONTROLS,PARAMETERS=FIELD\n{controls}\n*CONTROLS,PARAMETERS=TIME INCREMENTATION\n10,20,40,40\n"
            deck += f"*NODE PRINT,NSET={set_name(reactions)},TOTALS=ONLY\nRF\n*EL PRINT,ELSET=E\nSDV\n*END STEP\n"
        with tempfile.TemporaryDirectory(prefix="myogrowth_ccx_") as name:
            folder = pathlib.Path(name)
            (folder / "cube.inp").write_text(deck)
            if "PLAIN" in material:  # the UMAT as it is, by a name that ccx can ask for
                (folder / "libPLAIN.so").symlink_to(UMAT)
            environment = dict(os.environ, LD_LIBRARY_PATH=f"{LIBRARIES}:{folder}", OMP_NUM_THREADS=str(threads))
            done = subprocess.run([CCX, "cube"], cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
            self.status, self.screen = done.returncode, done.stdout
            self.dat, self.sta = ((folder / f"cube.{end}").read_text().splitlines() for end in ("dat", "sta"))

    def read(self):
        """time -> (reaction, [STATEV of every point])."""
        assert self.status == 0, f"status {self.status}\n" + "".join(re.findall(r".*ERROR.*\n.*\n", self.screen))
        result, time, kind = {}, None, None
        for line in self.dat:
            if "time" in line:
                time, kind = float(line.split()[-1]), line.split()[0]
                result.setdefault(time, ([], []))
            elif line.strip():
                values = line.split()
                if kind == "total":
                    result[time][0].extend(map(float, values))
                else:
                    result[time][1].append([float(v) for v in values[2:]])
        return result

    def attempts(self):
        """Rows of .sta: (step, increment, attempt, iterations, total time, step time, time increment, done)."""
        rows = []
        for line in self.sta[2:]:
            values = line.replace("U", " U ").split()
            whole, times = values[:3] + values[-4:-3], values[-3:]
            rows.append([*map(int, whole), *map(float, times), "U" not in values])
        return rows

    def newton(self):
        """For each attempt at an increment, its residual forces and its corrections of displacement."""
        lines = re.compile(r"largest residual force=\s+(\S+).*?largest correction to disp=\s+(\S+)", re.S)
        attempts = re.split(r"increment \d+ attempt \d+", self.screen)[1:]
        return [[(float(r), float(c)) for r, c in lines.findall(attempt)] for attempt in attempts]


def set_name(face):
    return face[0].upper() + {"-": "0", "+": "1"}[face[1]]


def static(dt, duration):
    return f"*STATIC,DIRECT\n{dt},{duration}\n"


def boundary(*cards):
    return "*BOUNDARY\n" + "".join(f"{set_name(c[0]) if c[0] in FACES else c[0]},{c[1]},{c[1]},{c[2]}\n" for c in cards)


def driver(*arguments, text):
    """The rows of history.csv, by time."""
    with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
        name = pathlib.Path(folder) / "input"
        name.write_text(text)
        command = [DRIVER, *arguments, name, "--out", folder, "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        with open(pathlib.Path(folder) / "history.csv") as f:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def element(faces, dt, duration, n0=(1, 0, 0), reaction=("x+", "x")):
    """The driver's element under face controls (name, direction, control, times, values)."""
    text = f"&material props = {', '.join(map(str, (*MUSCLE, *n0)))} /\n&time duration = {duration}\n dt = {dt} /\n"
    for name, direction, control, times, values in faces:
        text += f"&face name = '{name}' direction = '{direction}' control = '{control}'\n"
        text += f" time = {', '.join(map(str, times))}\n value = {', '.join(map(str, values))} /\n"
    text += "&solver tolerance_residual = 1.0e-12\n tolerance_displacement = 1.0e-6\n max_iterations = 40 /\n"
    return driver(text=text + f"&output reaction_face = '{reaction[0]}' reaction_direction = '{reaction[1]}' /\n")


def path(rows, n0, more=(), muscle=MUSCLE):
    """The driver's single point along rows of (time, F)."""
    text = "time,F11,F12,F13,F21,F22,F23,F31,F32,F33\n0,1,0,0,0,1,0,0,0,1\n"
    text += "".join(",".join(map(repr, (t, *itertools.chain(*F)))) + "\n" for t, F in rows)
    with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
        case = pathlib.Path(folder) / "case.nml"
        case.write_text(f"&material props = {', '.join(map(str, (*muscle, *n0, *more)))} /\n")
        return driver(case, "--path", text=text)[1:]


class Compared(unittest.TestCase):
    def expect_same(self, job, rows, component, name, sign=1, mean=False):
        """All points of all increments of ccx against the driver's row of the same number: the five scalars of STATEV
        to a digit of the print, reactions to 1e-5 of the largest."""
        printed = job.read()
        rows = [row for row in rows if row["time"] > 0]  # the driver's element has a row at 0, too
        self.assertEqual(len(printed), len(rows), name)
        largest = max(abs(row["reaction"]) for row in rows)
        worst = [0, 0]
        for (time, (reaction, points)), row in zip(printed.items(), rows):
            self.assertAlmostEqual(time, row["time"], delta=2e-6 * max(1, time))
            if mean:
                points = [[sum(values) / len(points) for values in zip(*points)]]
            for point in points:
                for value, key in zip(point, ("G", "lambda_e", "lambda", "J", "Je")):
                    worst[0] = max(worst[0], abs(value - row[key]))
            worst[1] = max(worst[1], abs(sign * reaction[component] - row["reaction"]) / largest)
        iterations = [a[3] for a in job.attempts()]
        print(f"{name:30} {len(rows)} increments, {sum(iterations)} iterations (most {max(iterations)}); worst: "
              f"state {worst[0]:.1e}, reaction {worst[1]:.1e}")
        self.assertLessEqual(worst[0], PRINT, name)
        self.assertLessEqual(worst[1], 1e-5, name)


ROLLERS = [(face, face[0], "displacement", [0], [0]) for face in ("x-", "y-", "z-")]
ROLLER_CARDS = boundary(("x-", 1, 0), ("y-", 2, 0), ("z-", 3, 0))


def affine(mesh, F):
    """All nodes of the surface moved as by F."""
    cards = "*BOUNDARY\n"
    for node in mesh.boundary():
        X = mesh.where[node]
        for i in range(3):
            cards += f"{node},{i + 1},{i + 1},{sum((F[i][j] - (i == j)) * X[j] for j in range(3))!r}\n"
    return cards


def dead_load(mesh, *tractions):
    """*CLOAD of tractions (face, direction, value)."""
    return "*CLOAD\n" + "".join(f"{node},{direction},{value * weight!r}\n" for face, direction, value in tractions
                                for node, weight in mesh.forces(face).items())


class Pull(Compared):
    """10 % along the fibre in a day, then held, the sides free: every element has the driver's state."""

    def test_all_elements(self):
        rows = element([*ROLLERS, ("x+", "x", "displacement", [0, 1], [0, 0.1])], 0.1, 3)
        read = {}
        for kind in TYPES:
            steps = [static(0.1, 1) + boundary(("x+", 1, 0.1)), static(0.1, 2)]
            job = Job(Mesh(kind, 1), steps, fixed=ROLLER_CARDS)
            self.expect_same(job, rows, 0, kind)
            read[kind] = job.read()
        for time, (reaction, points) in read["C3D8"].items():  # the same numbers in print
            self.assertAlmostEqual(read["C3D6"][time][0][0] / reaction[0], 1, delta=PRINT)
            self.assertEqual(read["C3D6"][time][1][0][:5], points[0][:5])


class Prescribed(Compared):
    """The surface moved by a homogeneous F, the fibre oblique; cells 2^3, so that one node at least is free."""

    def test_shear_and_stretch(self):
        """A shear of 0.3 with stretches, by the controls of the driver's faces."""
        F = [[1, 0.3, 0], [0, 1.1, 0], [0, 0, 0.95]]
        held = [(face, axis, "displacement", [0], [0]) for face, axis in (("y-", "x"), ("y-", "y"), ("z-", "z"))]
        moved = [(face, axis, "displacement", [0, 1], [0, value])
                 for face, axis, value in (("y+", "x", 0.3), ("y+", "y", 0.1), ("z+", "z", -0.05))]
        rows = element(held + moved, 0.1, 2, OBLIQUE, ("y+", "x"))
        self.run_all(F, rows, 0, "y+", "shear")

    def test_turned(self):
        """F = R U with a turn of 40 degrees, U with shear; the driver's single point gives stress, so the reaction on
        x+ is sigma n da = sigma (F e2 x F e3)."""
        U = [[1.1, 0.05, 0.02], [0.05, 1.02, -0.04], [0.02, -0.04, 0.95]]
        F = multiply(rotation((1, 2, 2), math.radians(40)), U)
        identity = [[float(i == j) for j in range(3)] for i in range(3)]
        at = lambda s: [[identity[i][j] + s * (F[i][j] - identity[i][j]) for j in range(3)] for i in range(3)]
        times = [0.1 * i for i in range(1, 21)]
        rows = path([(t, at(min(t, 1))) for t in times], OBLIQUE)
        for row, t in zip(rows, times):
            e2, e3 = ([line[j] for line in at(min(t, 1))] for j in (1, 2))
            area = [e2[i - 2] * e3[i - 1] - e2[i - 1] * e3[i - 2] for i in range(3)]
            row["reaction"] = sum(row[s] * a for s, a in zip(("s12", "s22", "s23"), area))
        self.run_all(F, rows, 1, "x+", "turned")

    def run_all(self, F, rows, component, reactions, name):
        for kind in TYPES:
            mesh = Mesh(kind, 2 if len(kind) == 4 else 1)
            steps = [static(0.1, 1) + affine(mesh, F), static(0.1, 1)]
            for in_state in (False, True):
                job = Job(mesh, steps, n0=OBLIQUE, in_state=in_state, reactions=reactions)
                self.expect_same(job, rows, component, f"{name}, {kind}, " + ("STATEV" if in_state else "PROPS"))


def rotation(axis, angle):
    """Rodrigues' formula."""
    n = [a / math.hypot(*axis) for a in axis]
    W = [[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]]
    W2 = multiply(W, W)
    s, c = math.sin(angle), math.cos(angle)
    return [[(i == j) + s * W[i][j] + (1 - c) * W2[i][j] for j in range(3)] for i in range(3)]


def multiply(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


class Laws(Compared):
    """The other elastic laws by the short order that has room in CalculiX's 21 constants, active and growing."""

    F = [[1.12, 0.1, 0], [0, 1.02, 0.05], [0, 0, 0.9]]
    PARAMETERS = {1: (1e7, 1e7, 1e8, 3e8, 2e8, 1.3, 0.05, 6), 2: (5e6, 5e6, 1e8, 3e8, 1.3, 0.05, 6.6, 1.4, 0, 0, 1),
                  3: (19.69, 1.19, 1.6e6, 20, 0.7388, 7e7, 0.682, 1.192)}  # in mPa
    GROWTH = MUSCLE[2:]

    def rows(self, law, activation, F, energy=0):
        at = lambda t: [[(i == j) + min(t, 1) * (F[i][j] - (i == j)) for j in range(3)] for i in range(3)]
        rows = path([(0.1 * i, at(0.1 * i)) for i in range(1, 21)], OBLIQUE, muscle=(0, 0, *self.GROWTH),
                    more=(0, energy, *[0] * 7, law, activation, *self.PARAMETERS[law]))
        for row in rows:  # on x+, force per reference area along x: sigma (F e2 x F e3)
            G = at(row["time"])
            e2, e3 = ([line[j] for line in G] for j in (1, 2))
            area = [e2[i - 2] * e3[i - 1] - e2[i - 1] * e3[i - 2] for i in range(3)]
            row["reaction"] = sum(row[s] * a for s, a in zip(("s11", "s12", "s13"), area))
        return rows

    def test_each_law(self):
        mesh = Mesh("C3D8", 2)
        for law in (1, 2, 3):
            for material in (LIBRARY, "@MYOGROWTH_NATIVE"):
                job = Job(mesh, [static(0.1, 1) + affine(mesh, self.F), static(0.1, 1)], props=(0.2, -law, *self.GROWTH),
                          n0=OBLIQUE, more=(*self.PARAMETERS[law], 1), material=material)
                self.expect_same(job, self.rows(law, 0.2, self.F, energy=1), 0, f"law {law}, {material}")

    def test_the_activation_may_follow_the_temperature(self):
        """Constants that depend on temperature: 0 and 1 at the temperatures 0 and 1."""
        mesh, law = Mesh("C3D8", 2), 1
        constants = [numbered((a, -law, *self.GROWTH, *OBLIQUE, *self.PARAMETERS[law], 0, a)) for a in (0.0, 1.0)]
        fixed = "*INITIAL CONDITIONS,TYPE=TEMPERATURE\nALL,0.3\n"
        identity = [[float(i == j) for j in range(3)] for i in range(3)]
        job = Job(mesh, [static(0.1, 1) + affine(mesh, identity) + "*TEMPERATURE\nALL,0.3\n"], n0=OBLIQUE, fixed=fixed,
                  constants=(18, "".join(constants)))
        expected = path([(0.1, identity)], OBLIQUE, muscle=(0, 0, *self.GROWTH),
                        more=(*[0] * 9, law, 0.3, *self.PARAMETERS[law]))[0]["s11"]
        self.assertAlmostEqual(job.read()[0.1][0][0] / expected, 1, delta=1e-5)

    def test_what_is_wrong_is_named(self):
        for props, words in (((1.2, -1), "PROPS(20) = 1.2: activation"), ((0.2, 0), "PROPS(2) = 0: c2")):
            job = Job(Mesh("C3D8", 1), [static(0.1, 1)], props=(*props, *self.GROWTH), fixed=ROLLER_CARDS)
            self.assertEqual(job.status, 201)
            self.assertIn(words, job.screen)


class Traction(Compared):
    """Dead loads. ccx takes the symmetric part of the tangent alone, so Newton's method converges linearly."""

    def test_all_elements(self):
        """A pull along the fibre."""
        rows = element([*ROLLERS, ("x+", "x", "traction", [0, 1], [0, 1.5e6])], 0.1, 3, reaction=("x-", "x"))
        for kind in TYPES:
            mesh = Mesh(kind, 1)
            steps = [static(0.1, 1) + dead_load(mesh, ("x+", 1, 1.5e6)), static(0.1, 2)]
            job = Job(mesh, steps, fixed=ROLLER_CARDS, reactions="x-")
            self.expect_same(job, rows, 0, f"traction, {kind}", sign=-1)

    def test_clamped_with_an_oblique_fibre(self):
        """Inhomogeneous: the driver's case traction_oblique.nml, in the mean over the points of a C3D8."""
        text = (SOURCE / "fortran_driver" / "cases" / "traction_oblique.nml").read_text()
        for old, new in (("16.0, 4.0", "16e6, 4e6"), ("0.0, 2.0\n  value = 0.0, 2.0", "0.0, 2.0\n  value = 0.0, 2e6"),
                         ("value = 0.0, 0.3", "value = 0.0, 0.3e6"), ("value = 0.0, 0.5", "value = 0.0, 0.5e6")):
            self.assertEqual(text.count(old), 1, old)
            text = text.replace(old, new)
        rows = driver(text=text)
        mesh = Mesh("C3D8", 1)
        load = dead_load(mesh, ("x+", 1, 2e6), ("x+", 2, 0.3e6), ("y+", 2, 0.5e6))
        for in_state in (False, True):
            job = Job(mesh, [static(1, 2) + load, static(1, 8)], n0=(0.8, 0.5, 0.33), in_state=in_state, reactions="x-",
                      fixed=boundary(*(("x-", i, 0) for i in (1, 2, 3))))
            self.expect_same(job, rows, 0, "clamped, C3D8, " + ("STATEV" if in_state else "PROPS"), sign=-1, mean=True)
            ratios = [b / a for r in job.newton() for (a, _), (b, _) in zip(r[2:], r[3:]) if b > 1e-3]
            print(f"  residuals fall by {min(ratios):.3f} to {max(ratios):.3f} an iteration")
            self.assertLess(max(ratios), 0.3)
            self.assertLessEqual(max(a[3] for a in job.attempts()), 20)


class Newton(unittest.TestCase):
    """Quadratic where the stretch of the fibre is prescribed: what is not symmetric then meets no free node."""

    @staticmethod
    def orders(values, below, above):
        triples = zip(values, values[1:], values[2:])
        return [math.log(c / b) / math.log(b / a) for a, b, c in triples if a < below and c > above]

    def test_quadratic(self):
        """By residual forces (1e5 at the beginning, printed to 1e-6) and by corrections of displacement. Mid-edge nodes are
        free along the fibre, and ccx starts the first increment with the whole pull in the last layer of nodes: there
        they have to move, and the rate is linear; from then on they are in place."""
        for kind in TYPES:
            steps = [static(0.5, 1) + boundary(("x+", 1, 0.3)), static(0.5, 1)]
            job = Job(Mesh(kind, 1), steps, fixed=ROLLER_CARDS)
            self.assertEqual(job.status, 0)
            by_force, by_displacement = [], []
            for attempt in job.newton()[len(kind) > 4 :]:
                residuals, corrections = zip(*attempt)
                by_force += self.orders(residuals, 1e5, 1e-4)
                by_displacement += self.orders(corrections, 1e-2, 1e-12)
            orders = by_force + by_displacement
            iterations = [a[3] for a in job.attempts()]
            print(f"{kind:6} iterations {iterations}, {len(orders)} orders {min(orders):.2f} to {max(orders):.2f}")
            self.assertGreaterEqual(len(orders), 3)
            self.assertGreaterEqual(min(orders), 1.7)


class Native(unittest.TestCase):
    """ccx's own interface is the same law: the prints of both are the same, also on two threads."""

    def test_both_interfaces(self):
        for kind in TYPES:
            mesh = Mesh(kind, 2 if len(kind) == 4 else 1)
            steps = [static(0.5, 1) + dead_load(mesh, ("x+", 1, 1e6), ("x+", 2, 0.2e6)), static(1, 2)]
            clamp = boundary(*(("x-", i, 0) for i in (1, 2, 3)))
            jobs = [Job(mesh, steps, n0=OBLIQUE, fixed=clamp, reactions="x-", material=material, threads=threads)
                    for material, threads in ((LIBRARY, 1), ("@MYOGROWTH_NATIVE", 1), ("@MYOGROWTH_NATIVE", 2))]
            read = [job.read() for job in jobs]
            worst = 0
            for other in read[1:]:
                self.assertEqual(list(other), list(read[0]))
                for time, (reaction, points) in read[0].items():
                    values = zip(reaction + sum(points, []), other[time][0] + sum(other[time][1], []))
                    worst = max(worst, *(abs(a - b) / max(1, abs(a)) for a, b in values))
            print(f"{kind:6} worst difference {worst:.1e}, iterations {[sum(a[3] for a in job.attempts()) for job in jobs]}")
            self.assertLessEqual(worst, 2 * PRINT)


class Cuts(unittest.TestCase):
    ASKED = "increment size decrease requested by a material user routine"

    def expect_cut(self, job, total):
        attempts = job.attempts()
        asked = job.screen.count(self.ASKED)
        accepted = [a for a in attempts if a[-1]]
        lengths = [a[6] for a in accepted]
        print(f"{asked} cuts asked for, {len(accepted)} increments of {min(lengths):g} to {max(lengths):g}")
        self.assertEqual(job.status, 0)
        self.assertGreaterEqual(asked, 1)
        self.assertEqual(len(attempts) - len(accepted), asked)
        self.assertAlmostEqual(accepted[-1][4], total, delta=1e-6)
        return accepted

    def test_advice(self):
        """PROPS(13): an increment is too long for its tolerance, and cut. G is the driver's on the times that ccx has
        accepted, to a digit of the print, and the exact one to what errors of 1e-4 an increment may add up to."""
        F = lambda s: [[1 + s, 0, 0], [0, 1, 0], [0, 0, 1]]
        steps = ["*STATIC\n1.E-4,1.E-3,1.E-9\n" + boundary(("x+", 1, 0.1)), "*STATIC\n0.3,10.,1.E-6,10.\n"]
        more = (0, 0, 0, 1e-4)
        job = Job(Mesh("C3D8", 1), steps, fixed=ROLLER_CARDS, more=more)
        accepted = self.expect_cut(job, 10.001)
        rows = path([(a[4], F(0.1 * min(1, a[4] / 1e-3))) for a in accepted], (1, 0, 0))
        self.assertEqual(len(rows), len(job.read()))
        for (reaction, points), row in zip(job.read().values(), rows):
            for point in points:
                self.assertAlmostEqual(point[0], row["G"], delta=PRINT)
        fine = path([(t * 1e-3, F(0.1)) for t in range(1, 10002)], (1, 0, 0))
        print(f"G = {rows[-1]['G']:.6f}; in 10,000 increments {fine[-1]['G']:.6f}")
        self.assertAlmostEqual(rows[-1]["G"], fine[-1]["G"], delta=len(accepted) * 1e-4)

    def test_inverted(self):
        """A push that turns the element inside out in the first iteration: the driver's cutback.nml."""
        mesh = Mesh("C3D8", 1)
        steps = ["*STATIC\n1.,1.,1.E-6\n" + dead_load(mesh, ("x+", 1, -20e6)), static(1, 1)]
        job = Job(mesh, steps, fixed=ROLLER_CARDS, reactions="x-")
        self.expect_cut(job, 2)
        rows = element([*ROLLERS, ("x+", "x", "traction", [0, 1], [0, -20e6])], 0.05, 2)
        reaction, points = job.read()[2.0]
        self.assertAlmostEqual(reaction[0], 20e6, delta=200)
        for point in points:
            self.assertAlmostEqual(point[2], rows[-1]["lambda"], delta=PRINT)
            self.assertEqual(point[0], 1)


class BadInput(unittest.TestCase):
    def expect(self, *words, **options):
        job = Job(Mesh("C3D8", 2), [static(0.1, 1) + boundary(("x+", 1, 0.1))], fixed=ROLLER_CARDS, threads=2, **options)
        self.assertEqual(job.status, 201)
        errors = re.findall(r"\*ERROR in myogrowth: .*", job.screen)
        self.assertEqual(len(errors), 1, job.screen[-2000:])
        for word in words:
            self.assertIn(word, errors[0])

    def test_ends_the_job_with_one_message(self):
        for material in (LIBRARY, "@MYOGROWTH_NATIVE"):
            self.expect("PROPS(2) = -4", "c2", "> 0", props=(16, -4, 0.5, 2, 1.1, 1.01), material=material)
            self.expect("PROPS(10) = 1", "*ORIENTATION", more=(1,), material=material)
            self.expect("PROPS(7:9) = 0, 0, 0", n0=(0, 0, 0), material=material)


class PlainUmat(unittest.TestCase):
    """Why libMYOGROWTH is needed: by ccx's Abaqus interfaces the UMAT itself gives wrong reactions in large shear."""

    def test_is_wrong_by_either_interface(self):
        mesh = Mesh("C3D8", 2)
        steps = [static(0.1, 0.5) + affine(mesh, [[1, 0.3, 0], [0, 1.1, 0], [0, 0, 0.95]])]
        read = {}
        for material in (LIBRARY, "@ABAQUSNL_PLAIN", "@ABAQUS_PLAIN"):
            read[material] = Job(mesh, steps, n0=OBLIQUE, reactions="y+", material=material).read()[0.5][0]
            print(f"{material:22} {[f'{x / 1e6:.4f}' for x in read[material]]} kPa")
        right = read.pop(LIBRARY)
        for wrong in read.values():
            self.assertGreater(max(abs(a - b) for a, b in zip(right, wrong)), 0.05 * max(map(abs, right)))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[6:]], verbosity=2)
