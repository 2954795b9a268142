"""The MPI example: test_mpi.py SOURCE MUSCLE C_LIBRARY [unittest arguments]; every class is a ctest."""
import csv
import ctypes
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree

SOURCE, MUSCLE, C_LIBRARY = (pathlib.Path(p).resolve() for p in sys.argv[1:4])
sys.path.insert(0, str(SOURCE / "examples" / "calculix"))
import cylinder_mesh  # noqa: E402
import history  # noqa: E402

ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
               "OMPI_MCA_mpi_yield_when_idle": "1"}
FIRST_PIOLA = 1  # MYOGROWTH_FIRST_PIOLA
SHARP = {"Solver/Newton tolerance": 1e-11, "Solver/Krylov tolerance": 1e-8}
BRICK = {"Geometry/Kind": "brick", "Geometry/Length": 40, "Geometry/Cells": "2, 2, 4", "Ends/Pull": 4, "Output/Times": ""}


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    if not hasattr(unittest.TestCase, "enterContext"):  # Python before 3.11

        def enterContext(self, context):
            self.addCleanup(context.__exit__, None, None, None)
            return context.__enter__()

    def mesh(self, size):
        path = self.folder / f"{size}.mesh"
        cylinder_mesh.write_text(path, cylinder_mesh.mesh(size))
        return {"Geometry/Kind": "file", "Geometry/File": path, "Output/Times": ""}

    def command(self, ranks, name, entries):
        entries = {"Output/Folder": self.folder / name, **entries}
        return ["mpirun", "-q", "-n", str(ranks), str(MUSCLE), *(f"{entry}={value}" for entry, value in entries.items())]

    def start(self, ranks, name, entries):
        return subprocess.Popen(self.command(ranks, name, entries), env=ENVIRONMENT, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True)

    def run_muscle(self, ranks, name, entries, status=0):
        """What it prints; its files are in the folder `name`."""
        process = self.start(ranks, name, entries)
        text, _ = process.communicate(timeout=280)
        self.assertEqual(process.returncode, status, text)
        return text

    def columns(self, name):
        return history.read(self.folder / name / "history.csv")

    def checks(self, name):
        """The norms of every step's Newton iterations."""
        steps = {}
        with open(self.folder / name / "newton.csv", encoding="ascii") as f:
            for row in csv.DictReader(f):
                steps.setdefault(float(row["time"]), []).append(float(row["residual"]))
        return list(steps.values())

    def assert_alike(self, a, b, tolerance):
        for column in history.COLUMNS:
            self.assertEqual(len(a[column]), len(b[column]))
            for x, y in zip(a[column], b[column]):
                self.assertLessEqual(abs(x - y), tolerance * max(abs(x), 1), column)


class Ranks(Case):
    """The results do not depend on the number of ranks, on either kind of mesh, nor on how the cells are assembled."""

    def same_on(self, entries):
        for ranks in (1, 2, 3):
            self.run_muscle(ranks, f"on_{ranks}", {**entries, **SHARP})
        self.assertGreater(len(self.columns("on_1")["time"]), 3)
        for ranks in (2, 3):
            self.assert_alike(self.columns("on_1"), self.columns(f"on_{ranks}"), 1e-10)

    def test_hexahedra_and_wedges(self):
        entries = {**self.mesh("tiny"), "Fibre/Kind": "oblique", "Fibre/Angle": 10, "Tendon/Length": 50, "Time/End": 2,
                   "Time/Tolerance": 1e-3, "Time/Step": 0.1}
        self.same_on(entries)
        for name, other in (("dense", {"Solver/Assembly": "dense"}), ("GAMG", {"Solver/Preconditioner": "GAMG"})):
            self.run_muscle(2, name, {**entries, **SHARP, **other})
            self.assert_alike(self.columns("on_1"), self.columns(name), 1e-9)

    def test_octrees_with_free_ends(self):
        self.same_on({"Geometry/Refinements": 1, "Geometry/Layers": 4, "Ends/Kind": "free", "Time/End": 2, "Output/Times": "",
                      "Fibre/Kind": "pennate", "Fibre/Angle": 15, "Time/Steps": "fixed", "Time/Step": 0.5,
                      "Muscle/c1": 400, "Muscle/Volume": "mean dilatation"})


class Restart(Case):
    ENTRIES = {**BRICK, **SHARP, "Time/Steps": "fixed", "Time/Step": 0.1, "Fibre/Kind": "oblique", "Fibre/Angle": 20}

    def test_on_other_numbers_of_ranks(self):
        for name, mesh in (("brick", {}), ("file", self.mesh("tiny"))):
            entries = {**self.ENTRIES, **mesh, "Output/Checkpoint every": 4}
            self.run_muscle(1, f"whole_{name}", {**entries, "Time/End": 1})
            self.run_muscle(2, name, {**entries, "Time/End": 1, "Output/Checkpoint every": 7})
            for ranks in (1, 2, 3):  # always from step 7
                self.run_muscle(ranks, name, {**entries, "Time/End": 1, "Output/Resume": "true", "Output/Checkpoint every": 0})
                self.assert_alike(self.columns(f"whole_{name}"), self.columns(name), 1e-10)

    def test_when_asked_to_end(self):
        entries = {**self.ENTRIES, "Time/Step": 0.02, "Time/End": 2, "Output/Checkpoint every": 0}
        process = self.start(2, "ended", entries)
        path = self.folder / "ended" / "history.csv"
        while process.poll() is None and (not path.exists() or len(path.read_text().splitlines()) < 4):
            time.sleep(0.02)
        ranks = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        os.kill(int(ranks[-1]), signal.SIGTERM)  # as a batch system does
        text, _ = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 75, text)
        self.assertIn("the checkpoint is written", text)
        so_far = len(self.columns("ended")["time"])
        self.assertLess(so_far, 100)
        self.run_muscle(3, "ended", {**entries, "Output/Resume": "true"})
        self.run_muscle(1, "whole", entries)
        self.assert_alike(self.columns("whole"), self.columns("ended"), 1e-10)

    def test_of_another_mesh(self):
        entries = {**self.ENTRIES, "Time/End": 0.2, "Time/Ramp": 0.2, "Output/Checkpoint every": 1}
        self.run_muscle(1, "a", entries)
        text = self.run_muscle(2, "a", {**entries, "Geometry/Cells": "2, 2, 5", "Output/Resume": "true"}, status=1)
        self.assertIn("checkpoint: has 16 cells, the mesh has 20", text)


class Newton(Case):
    def test_is_quadratic(self):
        for name, more in (("pointwise", {}), ("mean", {"Muscle/Volume": "mean dilatation", "Muscle/c1": 400})):
            self.run_muscle(1, name, {**BRICK, "Fibre/Kind": "oblique", "Fibre/Angle": 30, "Ends/Pull": 8, "Time/Steps": "fixed",
                                      "Time/Step": 0.5, "Time/End": 1, "Solver/Newton tolerance": 1e-12, "Solver/Krylov tolerance": 1e-12, **more})
            steps = self.checks(name)
            self.assertEqual(len(steps), 2)
            near = [(a, b) for norms in steps for a, b in zip(norms[1:], norms[2:]) if a < 0.05]
            self.assertGreaterEqual(len(near), 4)
            for a, b in near:
                self.assertLess(b, max(10 * a * a, 1e-12), steps)


class Homogeneous(Case):
    """A brick that is free to contract is one material point: the library's, called by its C interface."""

    def test_is_the_material_point(self):
        times = [0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0]
        entries = {**BRICK, **SHARP, "Ends/Kind": "free", "Time/Steps": "listed", "Time/Times": ", ".join(map(str, times))}
        library = ctypes.CDLL(str(C_LIBRARY))
        doubles = ctypes.POINTER(ctypes.c_double)
        library.myogrowth_update.argtypes = [doubles, ctypes.c_int, doubles, doubles, doubles, ctypes.c_int, ctypes.c_double,
                                             ctypes.c_int, doubles, doubles, doubles, ctypes.c_char_p, ctypes.c_int]
        for integration, kind in ((0, "backward Euler"), (1, "second order")):
            self.run_muscle(1, "brick", {**entries, "Muscle/Integration": kind})
            columns = self.columns("brick")
            props = (ctypes.c_double * 12)(16, 4, 0.5, 2, 1.1, 1.01, 0, 0, 1, 0, 0, integration)
            state, start = [0.0] * 9, 0.0
            for k, t in enumerate(times):
                stretch = 1 + 0.1 * min(t, 1)

                def update(lateral):
                    F = (ctypes.c_double * 9)(lateral, 0, 0, 0, lateral, 0, 0, 0, stretch)
                    P, before, after = (ctypes.c_double * 9)(), (ctypes.c_double * 9)(*state), (ctypes.c_double * 9)()
                    status = library.myogrowth_update(props, 12, F, before, after, 9, t - start, FIRST_PIOLA, P, None, None,
                                                      None, 0)
                    self.assertEqual(status, 0)
                    return P, after

                low, high = 0.8, 1.1
                for _ in range(60):
                    middle = (low + high) / 2
                    if update(middle)[0][0] > 0:
                        high = middle
                    else:
                        low = middle
                P, after = update(low)
                state, start = list(after), t
                self.assertAlmostEqual(columns["reaction"][k], 100 * P[8], delta=1e-8 * abs(100 * P[8]))
                for column, value in (("G", after[0]), ("lambda_e", after[1])):
                    for of in ("max", "mean", "min"):
                        self.assertAlmostEqual(columns[f"{column}_{of}"][k], value, delta=1e-9)


class CalculiX(Case):
    def test_gives_the_same_on_the_same_mesh(self):
        # ./run cylinder --out out/coarse --duration 7; the rows to day 1 of out/coarse/history.csv
        reference = history.read(SOURCE / "tests" / "mpi" / "calculix_coarse.csv")
        times = ", ".join(f"{t:.7g}" for t in reference["time"])
        self.run_muscle(1, "coarse", {**self.mesh("coarse"), "Time/Steps": "listed", "Time/Times": times})
        ours = self.columns("coarse")
        for column, tolerance in (("reaction", 5e-5), ("lambda_e_max", 1e-5), ("lambda_e_mean", 1e-5), ("lambda_e_min", 1e-5),
                                  ("G_max", 1e-5), ("G_mean", 1e-5), ("G_min", 1e-5), ("time", 1e-6)):
            for x, y in zip(ours[column], reference[column]):
                self.assertLess(abs(x / y - 1), tolerance, column)


class Locking(Case):
    def reaction(self, name, cells, volume):
        self.run_muscle(1, name, {**BRICK, "Geometry/Length": 10, "Geometry/Cells": cells, "Ends/Pull": 1, "Muscle/c1": 4000,
                                  "Muscle/lambda_crit": 100, "Muscle/Volume": volume, "Time/Steps": "fixed", "Time/Step": 1,
                                  "Time/End": 1})
        return self.columns(name)["reaction"][-1]

    def test_mean_dilatation_does_not_lock(self):
        # A clamped, nearly incompressible cube that is stretched by a tenth: 139.2 and 137.4 mN; pointwise 2274 mN.
        coarse, fine = (self.reaction(f"mean{n}", f"{n}, {n}, {n}", "mean dilatation") for n in (4, 6))
        self.assertLess(abs(coarse / fine - 1), 0.02)
        self.assertGreater(self.reaction("pointwise", "4, 4, 4", "pointwise"), 10 * fine)


class Cuts(Case):
    def test_a_step_that_turns_a_cell_inside_out_is_halved(self):
        text = self.run_muscle(2, "crushed", {**BRICK, "Ends/Pull": -34, "Time/Steps": "fixed", "Time/Step": 1, "Time/End": 1})
        self.assertRegex(text, r"is halved: det F <= 0 in hexahedron .*, point \d at \(.*\), G = 1, F = \[")
        self.assertEqual(self.columns("crushed")["time"][-1], 1)
        self.assertEqual(text.count("det F"), text.count("is halved: det F"))

    def test_steps_are_as_long_as_the_time_error_allows(self):
        for tolerance in (1e-3, 1e-6):
            self.run_muscle(1, f"{tolerance}", {**BRICK, "Time/Tolerance": tolerance, "Time/Ramp": 0.5, "Time/End": 10})
        coarse, fine = self.columns("0.001"), self.columns("1e-06")
        self.assertGreater(len(fine["time"]), 1.5 * len(coarse["time"]))
        self.assertLess(abs(coarse["G_mean"][-1] - fine["G_mean"][-1]), 1e-3)

    def test_gives_up_where_no_step_is_short_enough(self):
        text = self.run_muscle(1, "impossible", {**BRICK, "Solver/Newton iterations": 1, "Time/Steps": "fixed", "Time/Step": 1e-7,
                                                 "Solver/Newton tolerance": 1e-14}, status=1)
        self.assertIn("no step is short enough", text)


class Fields(Case):
    def test_are_for_paraview(self):
        self.run_muscle(2, "fields", {**self.mesh("tiny"), "Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 1,
                                      "Output/Times": "0.5"})
        parse = xml.etree.ElementTree.parse
        sets = parse(self.folder / "fields" / "muscle.pvd").findall(".//DataSet")
        self.assertEqual([s.get("timestep") for s in sets], ["0.5", "1"])
        pieces = parse(self.folder / "fields" / sets[0].get("file")).findall(".//Piece")
        cells = 0
        for piece in pieces:
            tree = parse(self.folder / "fields" / piece.get("Source"))
            cells += sum(int(p.get("NumberOfCells")) for p in tree.findall(".//Piece"))
            names = {a.get("Name") for a in tree.findall(".//PointData/DataArray")}  # deal.II's way of writing cells' values
            self.assertEqual(names, {"displacement", "G", "lambda_e", "lambda", "J", "Je", "n0_x", "n0_y", "n0_z", "tendon"})
        mesh = cylinder_mesh.mesh("tiny")
        self.assertEqual(cells, len(mesh.hexes) + len(mesh.wedges))

    def test_fibres_come_from_a_file_or_a_function(self):
        path = self.folder / "fibres.txt"
        path.write_text("# x y z n1 n2 n3\n2 0 0 0.6 0 0.8\n8 0 0 -3 0 4\n")
        entries = {**BRICK, "Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 1}
        self.run_muscle(1, "file", {**entries, "Fibre/Kind": "file", "Fibre/File": path})
        self.run_muscle(2, "function", {**entries, "Fibre/Kind": "function", "Fibre/Function": "if(x < 5, 3, -3); 0; 4"})
        self.assert_alike(self.columns("file"), self.columns("function"), 1e-6)


class BadInput(Case):
    def test_is_named(self):
        broken = self.folder / "broken.mesh"
        broken.write_text("nodes 1\n0 0 0\nhexes 1\n0 1 2 3 4 5 6 7\nwedges 0\n")
        for entries, message in (
                ({"Muscle/tau": -1}, r"Muscle/tau=-1: .*value -1 for the entry named tau does not match"),
                ({"Muscle/taux": 1}, r"No entry with name <taux>"),
                ({"Muscle/c1": -3}, r"Muscle/c1 = -3: must be > -2/3 c2"),
                ({"Time/End": 0.5}, r"Time/End = 0.5: must be >= Time/Ramp"),
                ({"Time/Steps": "listed"}, r"Time/Times is empty"),
                ({"Time/Steps": "listed", "Time/Times": "2, 1"}, r"Time/Times: an entry = 1: must be greater than the one before"),
                ({"Tendon/Length": 20}, r"Tendon/Length = 20: must be less than half of Geometry/Length"),
                ({"Tendon/Length": 1}, r"Tendon/Length = 1: must be more than half the height of the first layer"),
                ({"Fibre/Direction": "0, 0, 0"}, r"Fibre/Direction = 0, 0, 0: must be of a length > 0"),
                ({"Fibre/Kind": "function", "Fibre/Function": "sin(; 0; 1"}, r"Fibre/Function = sin\(; 0; 1: must be three"),
                ({"Fibre/Kind": "file", "Fibre/File": "nowhere"}, r"Fibre/File = nowhere: cannot be read"),
                ({"Geometry/Kind": "file", "Geometry/File": "nowhere"}, r"Geometry/File = nowhere: cannot be read"),
                ({"Geometry/Kind": "file", "Geometry/File": broken}, r"node 1 of a cell: must be less than their number, 1"),
                ({"Output/Resume": "true"}, r"checkpoint: cannot be read"),
                ({"Solver/Assembly": "dense", "Solver/Preconditioner": "GAMG"}, r"Solver/Assembly = dense: must be compact")):
            with self.subTest(message):
                self.assertRegex(self.run_muscle(1, "bad", {**BRICK, **entries}, status=1), message)

    def test_on_one_rank_of_several_is_told_by_all(self):
        text = self.run_muscle(3, "bad", {**BRICK, "Fibre/Kind": "function", "Fibre/Function": "if(z > 30, 0, 1); 0; 0"}, status=1)
        self.assertEqual(text.count("must be finite and of a length > 0"), 1)

    def test_in_a_file(self):
        path = self.folder / "bad.prm"
        path.write_text("subsection Muscle\n  set G_max = 0.9\nend\n")
        text = subprocess.run([MUSCLE, path], env=ENVIRONMENT, capture_output=True, text=True, check=False).stderr
        self.assertRegex(text, r"Line <2> of file <.*bad.prm>.* value 0.9 for the entry named G_max")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
