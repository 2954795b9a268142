"""Meshes of any shape in the MPI example: tetrahedra, attachments, fibres by flow, sections.

test_muscle.py SOURCE MUSCLE C_LIBRARY [unittest arguments]; every class is a ctest.
"""
import collections
import csv
import json
import math
import subprocess
import sys
import unittest

import numpy as np

import test_mpi
from test_mpi import SHARP, Case, brick, material_point

REAL = test_mpi.SOURCE.parent / "shared/data/bflh_female_left.inp"
KINDS = ("hex8", "wedge6", "tet4", "tet10")
# Corners of a hexahedron by kind; a tetrahedron for each way along three edges from corner 0 to corner 6.
PARTS = {"hex8": [range(8)], "wedge6": [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)],
         "tet4": [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]}
FACES = {"hex8": [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
         "wedge6": [(0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
         "tet4": [(0, 1, 2), (0, 1, 3), (1, 2, 3), (2, 0, 3)]}
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
# Axis, end, and which part along z.
SIDES = {"X0": (0, 0), "Y0": (1, 0), "PROXIMAL": (2, 0), "X1": (0, 1), "Y1": (1, 1), "DISTAL": (2, 1), "X0_LOWER": (0, 0, 0, 0.5),
         "X1_LOWER": (0, 1, 0, 0.5), "X1_UPPER": (0, 1, 0.5, 1)}
FIXED_STEPS = {"Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 1, "Output/Times": "", "Output/Fascicles": 0}


def write_box(path, kind, cells=(2, 2, 4), size=(10, 10, 40), place=lambda *p: p, sections=("MUSCLE",), section_of=lambda z: 0,
              surfaces=("PROXIMAL", "DISTAL"), fibres=None, sets=()):
    """A box of elements, its nodes where `place` puts them; second-degree ones curved accordingly. `kind` may depend on the
    hexahedron's middle that the elements part; `sets` are names and where along z, from 0 to 1."""
    path = f"{path}.mesh"
    flat, hexes = brick(lambda *p: p, cells, size)
    flat = [np.array(p, float) for p in flat]
    kind_of = kind if callable(kind) else lambda middle: kind
    elements, kinds = [], []
    for h in hexes:
        of = kind_of(np.mean([flat[n] for n in h], axis=0) / size)
        for part in PARTS["tet4" if of == "tet10" else of]:
            elements.append([h[i] for i in part])
            kinds.append(of)
    faces_of = [FACES["tet4" if of == "tet10" else of] for of in kinds]
    faces = collections.Counter(tuple(sorted(e[i] for i in f)) for e, own in zip(elements, faces_of) for f in own)
    found = {name: [] for name in surfaces}
    for e, own in zip(elements, faces_of):
        for f in own:
            nodes = [e[i] for i in f]
            if faces[tuple(sorted(nodes))] == 1:
                for name in surfaces:
                    axis, end, low, high = (*SIDES[name], 0, 1)[:4] if len(SIDES[name]) == 2 else SIDES[name]
                    if all(abs(flat[n][axis] - end * size[axis]) < 1e-9 and low <= flat[n][2] / size[2] <= high for n in nodes):
                        found[name].append(nodes)
    if kind == "tet10":
        between = {}
        for e in elements:
            for a, b in EDGES:
                key = tuple(sorted((e[a], e[b])))
                if key not in between:
                    between[key] = len(flat)
                    flat.append((flat[key[0]] + flat[key[1]]) / 2)
                e.append(between[key])
    with open(path, "w", encoding="ascii") as f:
        f.write(f"myogrowth mesh 1\nnodes {len(flat)}\n")
        f.writelines(f"{i + 101} {' '.join(repr(float(x)) for x in place(*p))}\n" for i, p in enumerate(flat))
        f.write(f"sections {len(sections)}\n" + "".join(f"{name}\n" for name in sections) + f"cells {len(elements)}\n")
        along = [np.mean([flat[n][2] for n in e]) / size[2] for e in elements]
        f.writelines(f"{of} {i + 501} {section_of(z)} {' '.join(map(str, e))}\n"
                     for i, (of, e, z) in enumerate(zip(kinds, elements, along)))
        f.write(f"surfaces {len(found)}\n")
        for name, facets in found.items():
            f.write(f"{name} {len(facets)}\n" + "".join(" ".join(map(str, nodes)) + "\n" for nodes in facets))
        f.write(f"fibres {len(elements) if fibres else 0}\n" + f"{fibres}\n" * (len(elements) if fibres else 0))
        if sets:
            f.write(f"sets {len(sets)}\n")
            for name, low, high in sets:
                inside = [i for i, z in enumerate(along) if low <= z <= high]
                f.write(f"{name} {len(inside)}\n" + "".join(f"{i}\n" for i in inside))
    return {"Mesh/File": path}


def shaken(x, y, z):
    """Moves the nodes inside a box of 10 x 10 x 40."""
    inside = 4 * math.sin(math.pi * x / 10) * math.sin(math.pi * y / 10) * math.sin(math.pi * z / 40)
    return x + 0.3 * inside, y - 0.2 * inside, z + 0.5 * inside


def table(path):
    with open(path, encoding="ascii") as f:
        return list(csv.DictReader(f))


class MeshCase(Case):
    def table(self, name, file):
        return table(self.folder / name / file)

    def assert_same_table(self, a, b, file, tolerance):
        rows, others = self.table(a, file), self.table(b, file)
        self.assertEqual(len(rows), len(others))
        self.assertGreater(len(rows), 2)
        for row, other in zip(rows, others):
            for column in row:
                try:
                    x, y = float(row[column]), float(other[column])
                except ValueError:
                    self.assertEqual(row[column], other[column])
                    continue
                self.assertLessEqual(abs(x - y), tolerance * max(1, abs(x)), (file, column, row))


class Elements(MeshCase):
    """Patch test: elements of any form in a homogeneous state, that of the library."""

    def test_a_free_brick_is_the_material_point(self):
        times = [0.3, 1.0, 3.0]
        rows = material_point(times)
        for kind in KINDS:
            mesh = write_box(self.folder / kind, kind, place=shaken, surfaces=("X0", "Y0", "PROXIMAL", "DISTAL"))
            more = [{}] if kind == "tet4" else [{}, {"Muscle/Volume": "mean dilatation"}]
            for volume in more:
                with self.subTest(kind=kind, **volume):
                    self.run_muscle(1, kind, {**mesh, **SHARP, **volume, "Output/Times": "", "Fibre/Kind": "uniform",
                                              "Attachments/List": "X0 slides 0; Y0 slides 0; PROXIMAL slides 0; DISTAL slides away 0.1",
                                              "Time/Steps": "listed", "Time/Times": ", ".join(map(str, times))})
                    columns = self.columns(kind)
                    for k, (force, G, lambda_e) in enumerate(rows):
                        self.assertAlmostEqual(columns["reaction"][k], force, delta=1e-8 * abs(force))
                        for of in ("max", "mean", "min"):
                            self.assertAlmostEqual(columns[f"G_{of}"][k], G, delta=1e-9)
                            self.assertAlmostEqual(columns[f"lambda_e_{of}"][k], lambda_e, delta=1e-9)
                    for row in self.table(kind, "regions.csv")[-5:]:
                        for column in ("lambda_e_mean", "lambda_e_p05", "lambda_e_p50", "lambda_e_p95", "lambda_e_p99"):
                            self.assertAlmostEqual(float(row[column]), rows[-1][2], delta=2e-9)
                    for row in self.table(kind, "fascicles.csv")[-40:]:
                        self.assertAlmostEqual(float(row["length"]) / float(row["length_0"]), 1.1, delta=1e-8 if kind[:3] == "tet" else 1e-3)
                        self.assertAlmostEqual(float(row["length_0"]), 40, delta=0.2)

    def test_two_kinds_in_one_mesh(self):
        """Hexahedra beside wedges, and wedges on tetrahedra: the material point again, on one rank and on three."""
        times = [0.3, 1.0]
        rows = material_point(times)
        for name, kind in (("beside", lambda at: "hex8" if at[0] < 0.5 else "wedge6"), ("on_top", lambda at: "wedge6" if at[2] < 0.5 else "tet4")):
            mesh = write_box(self.folder / name, kind, place=shaken, surfaces=("X0", "Y0", "PROXIMAL", "DISTAL"))
            for ranks in (1, 3):
                with self.subTest(name, ranks=ranks):
                    self.run_muscle(ranks, name, {**mesh, **SHARP, "Output/Times": "1", "Fibre/Kind": "uniform",
                                                  "Attachments/List": "X0 slides 0; Y0 slides 0; PROXIMAL slides 0; DISTAL slides away 0.1",
                                                  "Time/Steps": "listed", "Time/Times": ", ".join(map(str, times))})
                    columns = self.columns(name)
                    for k, (force, G, lambda_e) in enumerate(rows):
                        self.assertAlmostEqual(columns["reaction"][k], force, delta=1e-8 * abs(force))
                        for of in ("max", "mean", "min"):
                            self.assertAlmostEqual(columns[f"G_{of}"][k], G, delta=1e-9)
                            self.assertAlmostEqual(columns[f"lambda_e_{of}"][k], lambda_e, delta=1e-9)

    def test_a_turned_or_moved_file_changes_nothing(self):
        Q, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
        Q *= np.linalg.det(Q)
        for name, place in (("straight", lambda *p: p), ("turned", lambda *p: Q @ p + [300, -20, 7])):
            self.run_muscle(1, name, {**write_box(self.folder / name, "tet4", place=place), **SHARP, **FIXED_STEPS})
        for file in ("regions.csv", "hot_spots.csv"):
            self.assert_same_table("straight", "turned", file, 1e-9)
        self.assert_alike(self.columns("straight"), self.columns("turned"), 1e-9, ("reaction", "lambda_e_max", "G_max"))


class Locking(MeshCase):
    def reaction(self, name, n, more):
        mesh = write_box(self.folder / name, "tet4", (n, n, n), (10, 10, 10))
        self.run_muscle(1, name, {**mesh, "Muscle/c1": 4000, "Muscle/lambda_crit": 100, "Fibre/Kind": "uniform", "Output/Times": "",
                                  "Output/Fascicles": 0, "Time/Steps": "fixed", "Time/Step": 1, "Time/End": 1, **more})
        return self.columns(name)["reaction"][-1]

    def test_second_degree_with_mean_dilatation_does_not_lock(self):
        # The cube of test_mpi.py, 137.4 mN with 6 x 6 x 6 hexahedra: 134.8 and 134.4 mN.
        remedy = {"Mesh/Degree": 2, "Muscle/Volume": "mean dilatation"}
        coarse, fine = self.reaction("coarse", 3, remedy), self.reaction("fine", 4, remedy)
        self.assertLess(abs(coarse / fine - 1), 0.03)
        self.assertLess(abs(fine / 137.4 - 1), 0.03)
        self.assertGreater(self.reaction("locked", 4, {}), 5 * fine)


class Ranks(MeshCase):
    def test_one_two_and_three(self):
        def spindle(x, y, z):
            r = 0.4 + 0.6 * math.sin(math.pi * z / 40)
            return r * (x - 5) + 0.05 * z, r * (y - 5), z

        for degree in (1, 2):
            mesh = write_box(self.folder / "mesh", "tet4", place=spindle)
            entries = {**mesh, **SHARP, "Mesh/Degree": degree, "Time/Steps": "fixed", "Time/Step": 0.25, "Time/End": 1.5, "Output/Times": "",
                       "Output/Fascicles": 12, "Output/Fibres": "true"}
            for ranks in (1, 2, 3):
                self.run_muscle(ranks, f"on_{ranks}", entries)
            for ranks in (2, 3):
                self.assert_alike(self.columns("on_1"), self.columns(f"on_{ranks}"), 1e-9)
                for file in ("regions.csv", "attachments.csv", "fascicles.csv", "hot_spots.csv", "fibres.csv"):
                    self.assert_same_table("on_1", f"on_{ranks}", file, 1e-8 if file == "attachments.csv" else 1e-9)
        self.run_muscle(2, "again", {**entries, "Output/Checkpoint every": 4})
        self.run_muscle(3, "again", {**entries, "Output/Resume": "true"})
        self.assert_alike(self.columns("on_1"), self.columns("again"), 1e-9)
        self.assert_same_table("on_1", "again", "regions.csv", 1e-9)

    def test_smooth_steps_take_two_iterations(self):
        """By the predictor, but for the first step, and the two after the end of the ramp; without it they take three."""
        mesh = write_box(self.folder / "mesh", "tet4")
        for predictor, most in (("true", 2), ("false", 3)):
            self.run_muscle(1, "a", {**mesh, "Time/End": 14, "Output/Times": "", "Output/Fascicles": 0, "Solver/Predictor": predictor})
            attempts = []
            for row in self.table("a", "newton.csv"):
                if row["iteration"] == "0":
                    attempts.append([float(row["time"]), 0])
                attempts[-1][1] = int(row["iteration"])
            after = [time for time, _ in attempts if time >= 1][:2]
            counts = [n for time, n in attempts if time > 0 and time not in after]
            self.assertGreater(len(counts), 15)
            self.assertEqual(max(counts), most, attempts)
            self.assertEqual(sorted(counts)[len(counts) // 2], most, attempts)


class Fibres(MeshCase):
    def error(self, name, mesh, exact, more=()):
        """Mean and largest angle between the fibres and what they should be."""
        self.run_muscle(1, name, {**mesh, **FIXED_STEPS, "Time/Step": 1, "Ends/Pull": 0, "Output/Fibres": "true", **dict(more),
                                  "Attachments/List": "PROXIMAL fixed; DISTAL displaced 0 0 0"})
        rows = self.table(name, "fibres.csv")
        self.assertEqual(len({r["element"] for r in rows}) * max(int(r["point"]) for r in rows), len(rows))
        angles = []
        for r in rows:
            x, n = (np.array([float(r[k]) for k in keys]) for keys in (("x", "y", "z"), ("n0_x", "n0_y", "n0_z")))
            e = exact(x)
            angles.append(np.linalg.norm(n - e / np.linalg.norm(e)))
        return np.mean(angles), max(angles)

    def test_of_a_cylinder_are_exact(self):
        axis = np.array([0.2, -0.3, 1]) / np.linalg.norm([0.2, -0.3, 1])
        across = np.cross(axis, [1, 0, 0])
        across /= np.linalg.norm(across)
        third = np.cross(axis, across)

        def cylinder(x, y, z):  # of a square, its corners rounded off
            u, v = (x - 5) / 5, (y - 5) / 5
            return (u * math.sqrt(1 - v * v / 2) * across + v * math.sqrt(1 - u * u / 2) * third) * 5 + z * axis

        for kind in ("tet4", "wedge6", "hex8"):
            mesh = write_box(self.folder / kind, kind, place=cylinder)
            self.assertLess(self.error(kind, mesh, lambda x: axis)[1], 1e-9)
        mesh = write_box(self.folder / "straight", "tet4", place=cylinder)
        self.assertLess(self.error("second", mesh, lambda x: axis, {"Mesh/Degree": 2})[1], 1e-9)

    def test_of_a_cone_are_of_second_order(self):
        """Between two spheres about its tip, where the flow is radial; curved elements."""
        tip = np.array([3.0, 1, -5])

        def cone(x, y, z):
            d = np.array([0.06 * (x - 5), 0.06 * (y - 5), 1])
            return tip + (20 + z / 2) * d / np.linalg.norm(d)

        means = []
        for n in (1, 2, 4):
            mesh = write_box(self.folder / f"{n}", "tet10", (n, n, 2 * n), place=cone)
            means.append(self.error(f"on_{n}", mesh, lambda x: x - tip)[0])
        orders = [math.log2(a / b) for a, b in zip(means, means[1:])]
        self.assertLess(means[-1], 2e-3)
        self.assertGreater(orders[-1], 1.7)

    def test_of_sets(self):
        """Uniform in one section, by flow in the other, the mesh's own in a set that lies across both."""
        mesh = write_box(self.folder / "box", "tet4", (2, 2, 6), sections=("LOW", "HIGH"), section_of=lambda z: int(z > 0.5), fibres="0 1 0",
                         sets=(("BELLY", 0.34, 0.66),))
        more = {"Fibre/List": "LOW uniform 0 3 4; HIGH flow PROXIMAL DISTAL; BELLY mesh", "Materials/List": "LOW muscle; HIGH muscle",
                "Fibre/Kind": "function", "Fibre/Function": "0; 0; 0"}  # which all own fibres take the place of
        _, worst = self.error("a", mesh, lambda x: np.array([0, 1, 0] if 13.4 < x[2] < 26.6 else [0, 0.6, 0.8] if x[2] < 20 else [0, 0, 1]), more)
        self.assertLess(worst, 1e-9)
        for text, message in (("HIP mesh", "there is no section or set HIP in .*; there are: LOW, HIGH, BELLY"), ("LOW uniform 0 0 0", "of a length > 0"),
                              ("LOW flow PROXIMAL", "expected two surfaces after 'flow'"), ("LOW flow PROXIMAL HIP", "Fibre/To = HIP: must be a surface"),
                              ("LOW along", "expected NAME and uniform X Y Z, flow FROM TO or mesh, found 'along'")):
            self.assertRegex(self.run_muscle(1, "refused", {**mesh, **FIXED_STEPS, **more, "Fibre/Kind": "uniform", "Fibre/List": text}, status=1), message)

    def test_aponeuroses_incline_them(self):
        """Aponeuroses on the lower half of one side and the upper half of the other: the fibres go across, alike from both ends."""
        mesh = write_box(self.folder / "box", "hex8", (4, 2, 16), surfaces=("PROXIMAL", "DISTAL", "X0_LOWER", "X1_UPPER"))
        self.error("a", mesh, lambda x: np.array([0, 0, 1]), {"Fibre/From": "PROXIMAL, X0_LOWER", "Fibre/To": "DISTAL, X1_UPPER"})
        rows = {tuple(round(float(r[k]), 6) for k in "xyz"): [float(r[f"n0_{k}"]) for k in "xyz"] for r in self.table("a", "fibres.csv")}
        self.assertEqual(len(rows), 4 * 2 * 16 * 8)
        for (x, y, z), n in rows.items():
            other = rows[round(10 - x, 6), y, round(40 - z, 6)]
            self.assertLess(max(abs(a - b) for a, b in zip(n, other)), 1e-9)
            self.assertGreater(n[0], -1e-9)
        belly = [math.degrees(math.acos(n[2])) for (_, _, z), n in rows.items() if 15 < z < 25]
        self.assertTrue(20 < np.mean(belly) < 60, np.mean(belly))
        for ranks in (2, 3):
            self.run_muscle(ranks, "more", {**mesh, **FIXED_STEPS, "Output/Fibres": "true", "Fibre/From": "PROXIMAL, X0_LOWER",
                                            "Fibre/To": "DISTAL, X1_UPPER", "Attachments/List": "PROXIMAL fixed; DISTAL displaced 0 0 0"})
            self.assert_same_table("a", "more", "fibres.csv", 1e-9)

    def test_cells_without_a_gradient_have_their_neighbours(self):
        mesh = write_box(self.folder / "box", "tet4", (3, 3, 6), surfaces=("PROXIMAL", "DISTAL", "X1_LOWER"))
        entries = {**mesh, **FIXED_STEPS, "Output/Fibres": "true", "Fibre/From": "PROXIMAL, X1_LOWER", "Attachments/List": "PROXIMAL fixed; DISTAL away 0"}
        for ranks in (1, 3):
            text = self.run_muscle(ranks, f"on_{ranks}", entries)
            # Three tetrahedra of each hexahedron at the edge between the two surfaces have all nodes on them.
            self.assertRegex(text, r"fibres: flow from PROXIMAL,X1_LOWER to DISTAL, \d+ iterations; 9 cells without a gradient have")
            self.assertEqual(json.loads((self.folder / f"on_{ranks}" / "summary.json").read_text())["cells_without_gradient"], 9)
        self.assert_same_table("on_1", "on_3", "fibres.csv", 1e-9)
        for row in self.table("on_1", "fibres.csv"):
            self.assertAlmostEqual(sum(float(row[f"n0_{k}"])**2 for k in "xyz"), 1, delta=1e-12)

    def test_surfaces_that_touch_are_refused(self):
        mesh = write_box(self.folder / "box", "tet4", surfaces=("PROXIMAL", "DISTAL", "X0"))
        text = self.run_muscle(1, "a", {**mesh, **FIXED_STEPS, "Fibre/From": "X0", "Fibre/To": "DISTAL"}, status=1)
        self.assertIn("Fibre/From and Fibre/To: X0 and DISTAL touch, at", text)

    def test_come_from_the_mesh_file(self):
        mesh = write_box(self.folder / "box", "tet4", fibres="0.6 0 -0.8")
        self.assertLess(self.error("a", mesh, lambda x: np.array([0.6, 0, -0.8]))[1], 1e-12)
        self.assertLess(self.error("b", mesh, lambda x: np.array([0, 1, 1]), {"Fibre/Kind": "uniform", "Fibre/Direction": "0, 1, 1"})[1], 1e-12)


class Attachments(MeshCase):
    PLANES = "X0 slides 0; Y0 slides 0; PROXIMAL slides 0"

    def box(self, kind="tet4"):
        return write_box(self.folder / "box", kind, surfaces=("X0", "Y0", "PROXIMAL", "DISTAL"))

    def test_that_turn_together_strain_nothing(self):
        turn = "turned 3 0 7 1 2 -1 70"
        self.run_muscle(2, "a", {**self.box(), **SHARP, **FIXED_STEPS, "Time/Step": 0.1, "Attachments/List": f"PROXIMAL {turn}; DISTAL {turn}"})
        columns = self.columns("a")
        self.assertLess(max(abs(columns["lambda_e_max"] - 1)), 1e-8)
        self.assertLess(max(abs(columns["reaction"])), 1e-5)

    def test_a_force_holds_what_a_displacement_needs(self):
        for kind in ("hex8", "tet4"):
            entries = {**self.box(kind), **SHARP, **FIXED_STEPS, "Fibre/Kind": "uniform"}
            self.run_muscle(1, "moved", {**entries, "Attachments/List": self.PLANES + "; DISTAL slides 4"})
            force = self.columns("moved")["reaction"]
            ramp = f"at 0.5:{force[0] / force[1]!r} 1:1"
            self.run_muscle(2, "dead", {**entries, "Attachments/List": f"{self.PLANES}; DISTAL pulled 0 0 {force[1]!r} {ramp}"})
            self.assert_alike(self.columns("moved"), self.columns("dead"), 1e-8)
            # One that follows acts on the area as it is then: less by the lateral stretch squared.
            self.run_muscle(1, "follows", {**entries, "Attachments/List": f"{self.PLANES}; DISTAL pressed 80", "Solver/Newton tolerance": 1e-12,
                                           "Solver/Krylov tolerance": 1e-12, "Time/Step": 1})
            row = [r for r in self.table("follows", "attachments.csv") if r["attachment"] == "DISTAL"][-1]
            columns = self.columns("follows")
            stretch = columns["lambda_e_mean"][-1] * columns["G_mean"][-1]
            self.assertLess(abs(float(row["force_along_line"]) - columns["reaction"][-1]), 1e-7)
            self.assertTrue(0.8 < float(row["force_along_line"]) / 80 < 1 and stretch > 1.02)
            near = [(a, b) for norms in self.checks("follows") for a, b in zip(norms[1:], norms[2:]) if a < 0.05]
            for a, b in near:
                self.assertLess(b, max(10 * a * a, 1e-11))

    def test_a_programme_is_repeated(self):
        path = self.folder / "hours.csv"
        path.write_text("step, 1.05\nhold, 0.25\nstep, 1\nhold, 0.5\n")
        entries = {**self.box(), **SHARP, "Output/Times": "", "Output/Fascicles": 0, "Fibre/Kind": "uniform", "Time/End": 2.5}
        self.run_muscle(1, "file", {**entries, "Attachments/Protocol": path, "Attachments/Cycle": 1,
                                    "Attachments/List": self.PLANES + "; DISTAL slides away 0"})
        by_hand = "at 0:0 0:1 0.25:1 0.25:0 0.75:0 1:0 1:1 1.25:1 1.25:0 1.75:0 2:0 2:1 2.25:1 2.25:0 2.75:0"
        self.run_muscle(2, "hand", {**entries, "Attachments/List": f"{self.PLANES}; DISTAL slides 2 {by_hand}"})
        self.assert_alike(self.columns("file"), self.columns("hand"), 1e-8)
        columns = self.columns("file")
        first = columns["time"].tolist().index(0.25)
        self.assertEqual(columns["time"][0], 0)
        self.assertAlmostEqual(columns["lambda_e_mean"][0], 1.05, delta=1e-9)  # at once, and nothing has grown
        self.assertEqual(columns["G_mean"][0], 1)
        self.assertEqual(columns["time"][first + 1], 0.25)
        self.assertAlmostEqual(columns["lambda_e_mean"][first + 1] * columns["G_mean"][first], 1, delta=1e-9)
        self.assertEqual(columns["G_mean"][first], columns["G_mean"][first + 1])
        self.assertGreater(columns["G_mean"][-1], columns["G_mean"][first])


class Sections(MeshCase):
    ENTRIES = {**FIXED_STEPS, "Output/Fascicles": 5}

    def box(self):
        return write_box(self.folder / "box", "tet4", (2, 2, 6), sections=("BELLY", "CORD"), section_of=lambda z: int(abs(z - 0.5) > 1 / 3))

    def test_have_materials(self):
        for name, material in (("soft", "CORD tendon c1=16 c2=4"), ("stiff", "CORD tendon")):
            self.run_muscle(2, name, {**self.box(), **self.ENTRIES, "Materials/List": f"BELLY muscle tau=0.5; {material}"})
        rows = {(r["time"], r["region"]): r for r in self.table("stiff", "regions.csv")}
        cord, belly = rows["1", "CORD"], rows["1", "BELLY"]
        self.assertEqual((float(cord["G_p99"]), float(cord["G_mean"])), (1, 1))
        self.assertLess(float(cord["lambda_e_p99"]), 1.01)
        self.assertGreater(float(belly["lambda_e_p50"]), 1.05)
        self.assertAlmostEqual(float(cord["volume"]) * 2, float(belly["volume"]), delta=1e-6)
        self.assertEqual(float(rows["1", "all"]["volume"]), float(belly["volume"]))
        self.assertGreater(self.columns("stiff")["reaction"][-1], self.columns("soft")["reaction"][-1])
        for row in self.table("stiff", "fascicles.csv"):
            self.assertLess(float(row["length_0"]), 28)  # muscle only

    def test_element_sets_are_regions(self):
        mesh = write_box(self.folder / "box", "tet4", (2, 2, 6), sections=("MUSCLE",), sets=(("ALL", 0, 1), ("MIDDLE", 1 / 3, 2 / 3)))
        self.run_muscle(2, "a", {**mesh, **self.ENTRIES})
        rows = {(r["time"], r["region"]): r for r in self.table("a", "regions.csv")}
        for name, same in (("ALL", "all"), ("MIDDLE", "middle"), ("MUSCLE", "all")):
            self.assertEqual({**rows["1", name], "region": ""}, {**rows["1", same], "region": ""})
        self.assertEqual({r["region"] for r in self.table("a", "hot_spots.csv")}, {"proximal", "middle", "distal", "all", "MUSCLE", "ALL", "MIDDLE"})

    def test_without_material_are_refused(self):
        for materials, message in (("", "section BELLY has no material"), ("BELLY muscle", "section CORD has no material"),
                                   ("BELLY muscle; CORD tendon; BONE tendon", "there is no section BONE in"),
                                   ("BELLY muscle; CORD bone", "' CORD bone': expected NAME and muscle or tendon, found 'bone'"),
                                   ("BELLY muscle tau=-1; CORD tendon", "tau must be > 0"),
                                   ("BELLY muscle tau=1 tau=2; CORD tendon", "tau is said twice"),
                                   ("BELLY muscle; CORD tendon tau=1", "expected c1, c2 or law as NAME=VALUE, found 'tau=1'")):
            self.assertRegex(self.run_muscle(1, "a", {**self.box(), **self.ENTRIES, "Materials/List": materials}, status=1), message)


class Laws(MeshCase):
    def test_a_free_contraction_is_the_one_of_4C(self):
        """4C's regression test of law 3: the unit cube, active, free but for its planes of symmetry."""
        mesh = write_box(self.folder / "cube", "hex8", (1, 1, 1), (1, 1, 1), surfaces=("X0", "Y0", "PROXIMAL", "DISTAL"))
        for volume in ("pointwise", "mean dilatation"):
            self.run_muscle(1, "a", {**mesh, **FIXED_STEPS, **SHARP, "Muscle/Law": 3, "Muscle/Activation": f"1:{0.3341 / 2}", "Muscle/Volume": volume,
                                     "Muscle/lambda_crit": 100, "Fibre/Kind": "uniform", "Time/Step": 0.05,
                                     "Attachments/List": "X0 slides 0; Y0 slides 0; PROXIMAL slides 0"})
            self.assertAlmostEqual(self.columns("a")["lambda_e_mean"][-1], 1 - 0.31358536573847257, delta=1e-9)

    def test_of_sections_on_one_rank_and_two(self):
        """Law 1 in the belly, activated by a table of its own, law 2's tendon at both ends."""
        mesh = write_box(self.folder / "box", "hex8", (2, 2, 6), sections=("BELLY", "CORD"), section_of=lambda z: int(abs(z - 0.5) > 1 / 3))
        entries = {**mesh, **SHARP, **FIXED_STEPS, "Time/Step": 0.1, "Muscle/Volume": "mean dilatation", "Fibre/Kind": "uniform", "Muscle/lambda_crit": 0.95,
                   "Materials/List": "BELLY muscle law=1 kappa=500 lambda_opt=1.05 activation=0:0.05,1:0.2; CORD tendon law=2 tendon=1"}
        for ranks in (1, 2):
            text = self.run_muscle(ranks, f"on_{ranks}", {**entries, "Output/Times": "1"})
            self.assertIn("BELLY: elastic law 1 (Roehrle): c10 = 10, c01 = 10, kappa = 500,", text)
            self.assertRegex(text, r"CORD: elastic law 2 \(Blemker\): G1 = 50, G2 = 50, .* lambda_star = 1.03, tendon = 1")
        self.assert_alike(self.columns("on_1"), self.columns("on_2"), 1e-9)
        for file in ("regions.csv", "attachments.csv"):
            self.assert_same_table("on_1", "on_2", file, 1e-8)
        rows = {(r["time"], r["region"]): r for r in self.table("on_1", "regions.csv")}
        self.assertEqual(float(rows["1", "CORD"]["G_p99"]), 1)
        self.assertGreater(float(rows["1", "BELLY"]["G_mean"]), 1.001)
        self.assertIn('Name="activation"', (self.folder / "on_1" / "day_1.0.vtu").read_text())
        # With an activation of 0 the force is another.
        self.run_muscle(1, "passive", {**entries, "Materials/List": entries["Materials/List"].replace("0:0.05,1:0.2", "0")})
        self.assertLess(self.columns("passive")["reaction"][-1], 0.8 * self.columns("on_1")["reaction"][-1])

    def test_of_a_tendon_only(self):
        mesh = write_box(self.folder / "box", "hex8", (1, 1, 2))
        entries = {**mesh, **FIXED_STEPS, **SHARP, "Fibre/Kind": "uniform", "Materials/List": "MUSCLE tendon law=2 tendon=1"}
        self.run_muscle(1, "a", {**entries, "Output/Checkpoint every": 1})
        self.run_muscle(2, "a", {**entries, "Output/Resume": "true", "Time/End": 2})
        rows = self.table("a", "history.csv")
        self.assertEqual([float(r["time"]) for r in rows], [0.5, 1, 1.5, 2])
        for row in rows:
            self.assertGreater(float(row.pop("reaction")), 1)
            del row["time"]
            self.assertTrue(all(math.isnan(float(x)) for x in row.values()), row)  # numbers of the muscle, which is not there
        # Constants that nobody says are those of tendon, wherever tendon = 1 is said.
        of_section = {**entries, "Materials/List": "MUSCLE tendon law=2", "Blemker/tendon": 1}
        self.assertIn("G1 = 50,", self.run_muscle(1, "b", of_section))
        self.assertEqual([r["reaction"] for r in self.table("b", "history.csv")], [r["reaction"] for r in self.table("a", "history.csv")][:2])
        self.assertIn("G1 = 70,", self.run_muscle(1, "c", {**of_section, "Blemker/G1": 70}))
        self.assertIn("G1 = 0.5,", self.run_muscle(1, "d", {**of_section, "Materials/List": "MUSCLE muscle law=2 tendon=0"}))

    def test_of_sections_are_checked(self):
        mesh = write_box(self.folder / "box", "hex8", (1, 1, 1))
        for material, message in (("muscle law=4", r"law = 4: elastic law, must be 0 \(neo-Hookean\), 1"), ("muscle law=1 c1=4", "expected a parameter of section "
                                  r"Muscle but c1 and c2, law, activation or a constant of elastic law 1 \(c10, .*g2\) as NAME=VALUE, found 'c1=4'"),
                                  ("muscle law=1 kappa=0", "kappa = 0: resistance to volume change, must be finite and > 0"),
                                  ("muscle activation=0.5", "or law as NAME=VALUE, found 'activation=0.5'"),
                                  ("muscle law=2 activation=2", "activation: activation, must be >= 0 and <= 1; 2 is not"),
                                  ("muscle law=2 tendon=1 activation=0.1", "activation must be 0 with tendon = 1, which is never active"),
                                  ("tendon law=2 activation=0.1", "expected law or a constant of elastic law 2 .*found 'activation=0.1'")):
            with self.subTest(material):
                text = self.run_muscle(1, "a", {**mesh, **FIXED_STEPS, "Materials/List": f"MUSCLE {material}"}, status=1)
                self.assertRegex(text, f"Materials/List: 'MUSCLE {material}': .*{message}")


class Real(MeshCase):
    # An estimate of another program, CalculiX with fibres constant in an element (design/muscle.md): force [mN], and of the
    # thirds the elastic stretch's 50 and 99 % and the median of G.
    ESTIMATE = {1: (404.69, {"proximal": (1.0493, 1.2800, 1.0271), "middle": (1.0319, 1.0469, 1.0152), "distal": (1.0432, 1.1752, 1.0231)}),
                42: (125.36, {"proximal": (1.0152, 1.0835, 1.0887), "middle": (1.0100, 1.0168, 1.0674),
                              "distal": (1.0140, 1.0534, 1.0862)})}

    def test_six_weeks_of_a_biceps_femoris(self):
        if not REAL.is_file():
            self.skipTest(f"there is no {REAL}")
        subprocess.run([sys.executable, test_mpi.SOURCE / "examples/muscle/mesh.py", REAL, "--unit", "mm", "-o", self.folder / "mesh"],
                       check=True, capture_output=True)
        self.run_muscle(2, "a", {"Mesh/File": self.folder / "mesh", "Output/Times": "1, 42", "Output/Fascicles": 0},
                        prm=test_mpi.SOURCE / "examples/muscle/muscle.prm")
        rows = {(float(r["time"]), r["region"]): r for r in self.table("a", "regions.csv")}
        force = dict(zip(self.columns("a")["time"], self.columns("a")["reaction"]))
        for day, (reaction, thirds) in self.ESTIMATE.items():
            self.assertLess(abs(force[day] / reaction - 1), 0.05)
            for third, (median, most, G) in thirds.items():
                row = rows[day, third]
                self.assertLess(abs(float(row["lambda_e_p50"]) - median), 1e-3)
                self.assertLess(abs(float(row["lambda_e_p99"]) - most), 4e-3)
                self.assertLess(abs(float(row["G_p50"]) - G), 3e-3)
        for day in self.ESTIMATE:  # the tapering ends are stretched more than the belly, and grow more
            for column in ("lambda_e_p50", "G_p50"):
                self.assertGreater(min(float(rows[day, third][column]) for third in ("proximal", "distal")), float(rows[day, "middle"][column]))


class Faults(MeshCase):
    def test_are_named(self):
        mesh = write_box(self.folder / "box", "tet4")
        path = self.folder / "box.mesh"
        good = path.read_text()
        cases = [({"Attachments/List": text}, message) for text, message in (
            ("HIP fixed", r"Attachments/List: there is no surface HIP in .*; there are: PROXIMAL, DISTAL"),
            ("PROXIMAL held", r"'PROXIMAL held': expected NAME and one of fixed, .* found 'held'"),
            ("PROXIMAL fixed 1", r"'PROXIMAL fixed 1': expected no numbers"), ("DISTAL displaced 1 2", "expected a vector of three numbers after 'displaced'"),
            ("DISTAL displaced 1 2 x", "expected a number, found 'x'"), ("DISTAL fixed at 1", "expected TIME:FACTOR after 'at', found '1'"),
            ("DISTAL fixed at 2:1 1:1", "the times after 'at' must ascend; 1 does not"), ("DISTAL fixed; DISTAL fixed", "there is an action for DISTAL already"),
            ("DISTAL pulled 0 0 1", "nothing else holds the muscle"), ("DISTAL turned 0 0 0 0 0 0 9", "the axis must have a length > 0"))]
        cases += [({"Muscle/Volume": "mean dilatation"}, "must be pointwise with tetrahedra of four nodes"),
                  ({"Attachments/Distal": "KNEE"}, "Attachments/Distal: there is no surface KNEE"), ({"Fibre/From": "KNEE"}, "Fibre/From = KNEE: must be a surface"),
                  ({"Fibre/Kind": "mesh"}, "there are no fibres in"), ({"Solver/Assembly": "dense"}, "Solver/Assembly = dense: must be compact with Mesh/File"),
                  ({"Attachments/Protocol": "nowhere"}, "nowhere: cannot be read"), ({"Tendon/Length": 1}, "Tendon/Length = 1: must be 0 with Mesh/File")]
        facet = good[good.index("DISTAL 8\n") + 9:].splitlines()[0]
        for i, (content, message) in enumerate((
                (good.replace("mesh 1", "mesh 2"), r":1:1: expected 'myogrowth mesh 1'"), (good.replace("tet4 501", "tet5 501"), "expected tet4, tet10, hex8 or wedge6, found 'tet5'"),
                (good.replace("tet4 502 0", "tet4 501 0"), "label 501 is there already"), (good.replace("tet4 502 0", "tet4 502 1"), "expected a section, a whole number from 0 to 0"),
                (good.replace("\n" + facet + "\n", "\n0 1 44\n", 1), "is no face of a cell"), (good.replace("DISTAL 8\n", "PROXIMAL 8\n"), "there is a surface 'PROXIMAL' already"),
                (good.replace("fibres 0", "fibres 3"), "expected the number of cells, 96, or 0"), (good.replace("fibres 0\n", ""), "ends before 'fibres'"),
                (good + "sets 1\nA 1\n96\n", "expected a cell, a whole number from 0 to 95"), (good + "sets 1\nMUSCLE 1\n0\n", "there is a section or set 'MUSCLE' already"),
                (good + "sets 2\nA 1\n0\n", "ends before the last set"), (good + "more\n", "expected 'sets' or the end of the file"))):
            name = self.folder / f"{i}.mesh"
            name.write_text(content)
            cases.append(({"Mesh/File": name}, message))
        swapped = good.splitlines()
        row = next(i for i, line in enumerate(swapped) if line.startswith("tet4 503"))
        words = swapped[row].split()
        swapped[row] = " ".join([*words[:3], words[4], words[3], *words[5:]])
        (self.folder / "swapped").write_text("\n".join(swapped) + "\n")
        cases.append(({"Mesh/File": self.folder / "swapped"}, rf"swapped:{row + 1}: element 503 is inside out or flat"))
        for i, (entries, message) in enumerate(cases):
            with self.subTest(message):
                self.assertRegex(self.run_muscle(1, f"refused_{i}", {**mesh, **FIXED_STEPS, **entries}, status=1), message)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
