"""The MPI example: test_mpi.py SOURCE MUSCLE C_LIBRARY [unittest arguments]; every class is a ctest."""
import concurrent.futures
import csv
import ctypes
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree
import zlib

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

    def command(self, ranks, name, entries, prm=None):
        entries = {"Output/Folder": self.folder / name, **entries}
        mpirun = ["mpirun", "-q", "-n", str(ranks)] if ranks > 1 else []  # one rank starts faster without
        files = [str(prm)] if prm else []
        return [*mpirun, str(MUSCLE), *files, *(f"{entry}={value}" for entry, value in entries.items())]

    def start(self, ranks, name, entries, prm=None):
        return subprocess.Popen(self.command(ranks, name, entries, prm), env=ENVIRONMENT, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True)

    def run_muscle(self, ranks, name, entries, status=0, prm=None):
        """What it prints; its files are in the folder `name`."""
        process = self.start(ranks, name, entries, prm)
        text, _ = process.communicate(timeout=280)
        self.assertEqual(process.returncode, status, text)
        return text

    def assert_refused(self, cases):
        """Runs that end at once, a few at a time: pairs of entries and what must be said."""
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            runs = [pool.submit(subprocess.run, self.command(1, f"refused_{i}", {**BRICK, **entries}), env=ENVIRONMENT, check=False,
                                capture_output=True, text=True, timeout=280) for i, (entries, _) in enumerate(cases)]
            for (_, message), future in zip(cases, runs):
                run = future.result()
                with self.subTest(message):
                    self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
                    self.assertRegex(run.stderr.rstrip(), message)

    def columns(self, name):
        return history.read(self.folder / name / "history.csv")

    def checks(self, name):
        """The norms of every step's Newton iterations."""
        steps = {}
        with open(self.folder / name / "newton.csv", encoding="ascii") as f:
            for row in csv.DictReader(f):
                steps.setdefault(float(row["time"]), []).append(float(row["residual"]))
        return list(steps.values())

    def assert_alike(self, a, b, tolerance, columns=history.COLUMNS):
        for column in columns:
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
        self.assertRegex(text, r"is of another run; (.|\n)*mesh = 20 hexahedra, .* in the checkpoint 16 hexahedra")

    SHORT = {**BRICK, "Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 1, "Output/Checkpoint every": 1}

    def test_of_another_run_is_refused_by_entry_and_can_be_forced(self):
        self.run_muscle(1, "a", self.SHORT)
        checkpoint = (self.folder / "a" / "checkpoint").read_bytes()
        more = {"Time/End": 2, "Output/Resume": "true"}
        for entries, message in (
                ({"Muscle/c1": 17}, "Muscle/c1 = 17, in the checkpoint 16"),
                ({"Ends/Pull": 5}, "Ends/Pull = 5, in the checkpoint 4"),
                ({"Ends/Kind": "free"}, "Ends/Kind = free, in the checkpoint clamped"),
                ({"Time/Ramp": 0.5}, "Time/Ramp = 0.5, in the checkpoint 1"),
                ({"Fibre/Direction": "0, 1, 1"}, "Fibre/Direction = 0, 1, 1, in the checkpoint 0, 0, 1"),
                ({"Geometry/Width": 10.001}, "Geometry/Width = 10.001, in the checkpoint 10"),
                ({"Muscle/tau_rev": 3}, "Muscle/tau_rev = 3, in the checkpoint 0")):
            with self.subTest(message):
                text = self.run_muscle(1, "a", {**self.SHORT, **more, **entries}, status=1)
                self.assertIn("checkpoint: is of another run; Output/Resume=force", text)
                self.assertIn(message, text)
                self.assertEqual((self.folder / "a" / "checkpoint").read_bytes(), checkpoint)
        text = self.run_muscle(1, "a", {**self.SHORT, "Time/End": 0.5, "Time/Ramp": 0.5, "Output/Resume": "force"}, status=1)
        self.assertIn("checkpoint: is of time 1, after the end", text)
        text = self.run_muscle(1, "a", {**self.SHORT, **more, "Time/Step": "0.50", "Solver/Newton tolerance": 1e-9})
        self.assertIn("Solver/Newton tolerance = 1e-09, in the checkpoint 1e-08", text)
        self.assertIn("Time/End = 2, in the checkpoint 1", text)  # told, and gone on with
        self.assertNotIn("Time/Step", text)
        self.assertEqual(self.columns("a")["time"].tolist(), [0.5, 1, 1.5, 2])
        text = self.run_muscle(1, "a", {**self.SHORT, "Time/End": 3, "Muscle/c1": 17, "Output/Resume": "force"})
        self.assertIn("Muscle/c1 = 17, in the checkpoint 16", text)
        self.assertEqual(self.columns("a")["time"][-1], 3)

    def test_damaged_ones_are_told_why(self):
        self.run_muscle(1, "a", self.SHORT)
        good = (self.folder / "a" / "checkpoint").read_bytes()
        records = len(good) - 16 * 368

        def changed(place):
            return good[:place] + bytes([good[place] ^ 1]) + good[place + 1:]

        cases = []
        for i, (content, why) in enumerate((
                (b"", "is empty"), (b"time,reaction\n" * 100, "is not a checkpoint of this program"), (good[:40], "is cut short"),
                (good[:200], "is cut short"), (good[:-1], "is cut short"), (good + b"\0", "has something after its end"),
                (good[:8] + good[8:12][::-1] + good[12:], "is of a machine with another order of bytes"),
                (good[:12] + b"\2\0\0\0" + good[16:], "is of version 2 of checkpoints; this program reads 3"),
                (good[:8] + b"\x10" + bytes(7) + good[16:], "is of an older version"), (changed(43), "header is damaged"),
                (changed(50), "header is damaged"), (changed(300), "header is damaged"), (changed(records - 5), "has no cell|data are damaged"),
                (changed(records + 3), "data are damaged"), (changed(len(good) - 100), "data are damaged"), (None, "cannot be read: Is a directory"))):
            folder = self.folder / str(i)
            folder.mkdir()
            if content is None:
                (folder / "checkpoint").mkdir()
            else:
                (folder / "checkpoint").write_bytes(content)
            cases.append(({**self.SHORT, "Output/Folder": folder, "Output/Resume": "force"}, "checkpoint: .*" + why))
        self.assert_refused(cases)

    def test_what_a_killed_run_has_left(self):
        """kill -9 at any moment, and a larger run's checkpoint.part."""
        entries = {**self.ENTRIES, "Time/Step": 0.02, "Time/End": 3, "Output/Checkpoint every": 1}
        self.run_muscle(1, "whole", entries)
        (self.folder / "killed").mkdir()
        (self.folder / "killed" / "checkpoint.part").write_bytes(b"x" * 1_000_000)
        for resume in ("false", "true", "true"):
            process = self.start(1, "killed", {**entries, "Output/Resume": resume})
            for line in process.stdout:
                if line.startswith("step") and int(line.split()[1]) % 30 == 29:
                    process.kill()
            process.wait(timeout=60)
            process.stdout.close()
        self.run_muscle(2, "killed", {**entries, "Output/Resume": "true"})
        self.assert_alike(self.columns("whole"), self.columns("killed"), 1e-10)

    def test_a_new_run_puts_the_old_checkpoint_aside(self):
        self.run_muscle(1, "a", self.SHORT)
        text = self.run_muscle(1, "a", {**self.SHORT, "Output/Checkpoint every": 0})
        self.assertIn("checkpoint.old", text)
        self.assertIn("checkpoint: cannot be read", self.run_muscle(1, "a", {**self.SHORT, "Output/Resume": "true"}, status=1))

    def test_of_edited_tables(self):
        self.run_muscle(1, "a", self.SHORT)
        path, more = self.folder / "a" / "history.csv", {**self.SHORT, "Time/End": 1.5, "Output/Resume": "true"}
        checkpoint, (head, first, second) = (self.folder / "a" / "checkpoint").read_bytes(), path.read_text().splitlines()
        for rows, message in (([head, second], "has 1 rows up to time 1, the run made 2 steps: rows are missing"),
                              ([head, first, second[:7]], r"history.csv:3:8: .*; the row is dropped"),
                              ([head, first, "soon," + second], r"history.csv:3:1: .*found 'soon'; the row is dropped"),
                              ([head, first, second, second], "has 3 rows .* that it did not write"), ([], "is not there")):
            path.unlink()
            (self.folder / "a" / "checkpoint").write_bytes(checkpoint)
            if rows:
                path.write_text("\n".join(rows) + "\n")
            self.assertRegex(self.run_muscle(1, "a", more), message)
            self.assertEqual(self.columns("a")["time"][-1], 1.5)
        path.write_text("day,force\n1,2\n")
        self.assertIn("history.csv:1:1: must be time,reaction", self.run_muscle(1, "a", more, status=1))


def write_mesh(path, nodes, hexes, wedges=()):
    with open(path, "w", encoding="ascii") as f:
        for name, rows in (("nodes", nodes), ("hexes", hexes), ("wedges", wedges)):
            f.write(f"{name} {len(rows)}\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows))
    return {"Geometry/Kind": "file", "Geometry/File": path}


def brick(place, cells=(2, 2, 4), size=(10, 10, 40 / 3)):
    """Nodes, where `place` puts them, and hexahedra of a brick."""
    nx, ny, nz = (n + 1 for n in cells)
    nodes = [place(*(s * i / n for s, i, n in zip(size, ijk, cells))) for ijk in
             ((i, j, k) for k in range(nz) for j in range(ny) for i in range(nx))]

    def node(i, j, k):
        return i + nx * (j + ny * k)

    hexes = [[node(i + a, j + b, k + c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
             for k in range(nz - 1) for j in range(ny - 1) for i in range(nx - 1)]
    return nodes, hexes


class Ends(Case):
    ENTRIES = {"Ends/Pull": 1, "Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 1, "Output/Times": ""}

    def test_are_the_same_with_seven_digits(self):
        def seven(x, y, z):  # 13.33333 or 13.33334, as single precision may have it
            return x, y, f"{z + (4e-6 if x == y else -4e-6):.7g}"

        for kind in ("clamped", "free"):
            for name, place in (("exact", lambda *p: p), ("seven", seven)):  # 13.33334 only in part
                text = self.run_muscle(2, name, {**self.ENTRIES, **write_mesh(self.folder / f"{name}.mesh", *brick(place)), "Ends/Kind": kind})
                self.assertRegex(text, r"distal end at z = 13.3333[34]: 9 nodes, area 100\n")
            self.assert_alike(self.columns("exact"), self.columns("seven"), 1e-5, history.COLUMNS[:-3])

    def test_must_be_closed(self):
        def dented(depth):
            return lambda x, y, z: (x, y, z - depth if z > 13 and x == y == 10 else z)

        entries = {**self.ENTRIES, **write_mesh(self.folder / "dented", *brick(dented(0.1)))}
        text = self.run_muscle(2, "a", entries, status=1)
        self.assertRegex(text, r"distal end at z = 13.33333: 8 nodes, area 75: is not closed: an area of 25.* beside it .* up to 0.1 from")
        self.assertIn("distal end at z = 13.33333: 9 nodes, area 100.0025\n", self.run_muscle(2, "a", {**entries, "Ends/Tolerance": 0.04}))
        # An end at two heights: the lower half is not of it.
        nodes, hexes = brick(lambda *p: p)
        hexes = [hexes[i] for i in range(16) if i not in (12, 14)]
        used = sorted({node for cell in hexes for node in cell})
        step = {**self.ENTRIES, **write_mesh(self.folder / "step", [nodes[node] for node in used],
                                             [[used.index(node) for node in cell] for cell in hexes])}
        self.assertRegex(self.run_muscle(2, "a", step),
                         "distal end at z = 13.33333: 6 nodes, area 50; an area of 50 that faces the same way lies elsewhere\n")
        sheared = write_mesh(self.folder / "sheared", *brick(lambda x, y, z: (x, y, z + 0.8 * x)))
        self.assertRegex(self.run_muscle(1, "a", {**self.ENTRIES, **sheared}, status=1),
                         r"proximal end at z = 0: 3 nodes, area 0: must be a flat face; 3 of these nodes have no face")


class Writing(Case):
    """What cannot be written ends the run, with the file and the reason, whichever rank it is."""

    ENTRIES = {**BRICK, "Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 1, "Output/Times": "0.5", "Output/Checkpoint every": 1}

    def test_on_a_full_disk(self):
        for ranks, name in ((1, "history.csv.part"), (1, "newton.csv.part"), (1, "day_0.5.0.vtu"), (2, "day_0.5.1.vtu"),
                            (1, "day_0.5.pvtu.part"), (2, "muscle.pvd.part"), (2, "checkpoint.part"), (1, "summary.json.part")):
            with self.subTest(name):
                (self.folder / name).mkdir()
                (self.folder / name / name).symlink_to("/dev/full")
                text = self.run_muscle(ranks, name, self.ENTRIES, status=1)
                self.assertIn(f"{name}: cannot be written: No space left on device", text)

    def test_in_the_middle(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (16384, 16384))

        entries = {**self.ENTRIES, "Time/Step": 0.001, "Output/Times": "", "Output/Checkpoint every": 0}
        process = subprocess.run(self.command(1, "a", entries), env={**ENVIRONMENT, "PMIX_MCA_gds": "hash"}, capture_output=True,
                                 text=True, check=False, preexec_fn=limit)
        self.assertEqual(process.returncode, 1, process.stdout)
        self.assertRegex(process.stderr, r"(newton|history|regions|hot_spots|attachments).csv: cannot be written: File too large")

    def test_in_a_folder_that_cannot_be(self):
        (self.folder / "file").write_text("")
        for name, why in (("file", "cannot be made a folder"), ("file/below", "cannot be made a folder: Not a directory"),
                          ("/proc/nobody/may", "cannot be made a folder: No such file")):
            text = self.run_muscle(2, name, self.ENTRIES, status=1)
            self.assertRegex(text, f"Output/Folder = .*{name}: {why}")
            self.assertNotIn("step", text)

    def test_two_at_once(self):
        entries = {**self.ENTRIES, "Time/Step": 0.001, "Output/Times": ""}
        with self.start(1, "a", entries) as first:
            for line in first.stdout:
                if line.startswith("step"):
                    break
            self.assertIn("a: another run is writing there", self.run_muscle(1, "a", self.ENTRIES, status=1))
            first.kill()
        self.run_muscle(1, "a", self.ENTRIES)


class Newton(Case):
    def test_is_quadratic(self):
        for name, more in (("pointwise", {}), ("mean", {"Muscle/Volume": "mean dilatation", "Muscle/c1": 400})):
            self.run_muscle(1, name, {**BRICK, "Fibre/Kind": "oblique", "Fibre/Angle": 30, "Ends/Pull": 8, "Time/Steps": "fixed",
                                      "Time/Step": 0.5, "Time/End": 1, "Solver/Newton tolerance": 1e-12, "Solver/Krylov tolerance": 1e-12,
                                      "Solver/Predictor": "false", **more})
            steps = self.checks(name)
            self.assertEqual(len(steps), 2)
            near = [(a, b) for norms in steps for a, b in zip(norms[1:], norms[2:]) if a < 0.05]
            self.assertGreaterEqual(len(near), 4)
            for a, b in near:
                self.assertLess(b, max(10 * a * a, 1e-12), steps)


def material_point(times, integration=1, area=100):
    """Force, G and lambda_e of a strip that is free to contract, stretched by a tenth until day 1: the library's C interface."""
    library = ctypes.CDLL(str(C_LIBRARY))
    doubles = ctypes.POINTER(ctypes.c_double)
    library.myogrowth_update.argtypes = [doubles, ctypes.c_int, doubles, doubles, doubles, ctypes.c_int, ctypes.c_double,
                                         ctypes.c_int, doubles, doubles, doubles, ctypes.c_char_p, ctypes.c_int]
    props = (ctypes.c_double * 12)(16, 4, 0.5, 2, 1.1, 1.01, 0, 0, 1, 0, 0, integration)
    state, start, rows = [0.0] * 9, 0.0, []
    for t in times:
        stretch = 1 + 0.1 * min(t, 1)

        def update(lateral):
            F = (ctypes.c_double * 9)(lateral, 0, 0, 0, lateral, 0, 0, 0, stretch)
            P, before, after = (ctypes.c_double * 9)(), (ctypes.c_double * 9)(*state), (ctypes.c_double * 9)()
            status = library.myogrowth_update(props, 12, F, before, after, 9, t - start, FIRST_PIOLA, P, None, None, None, 0)
            assert status == 0, status
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
        rows.append((area * P[8], after[0], after[1]))
    return rows


class Homogeneous(Case):
    """A brick that is free to contract is one material point: the library's, called by its C interface."""

    def test_is_the_material_point(self):
        times = [0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0]
        entries = {**BRICK, **SHARP, "Ends/Kind": "free", "Time/Steps": "listed", "Time/Times": ", ".join(map(str, times))}
        for integration, kind in ((0, "backward Euler"), (1, "second order")):
            self.run_muscle(1, "brick", {**entries, "Muscle/Integration": kind})
            columns = self.columns("brick")
            for k, (force, G, lambda_e) in enumerate(material_point(times, integration)):
                self.assertAlmostEqual(columns["reaction"][k], force, delta=1e-8 * abs(force))
                for column, value in (("G", G), ("lambda_e", lambda_e)):
                    for of in ("max", "mean", "min"):
                        self.assertAlmostEqual(columns[f"{column}_{of}"][k], value, delta=1e-9)


# Constants with which the laws' fibres carry and Newton's method takes ordinary steps; activation and pull of a cube.
LAWS = {1: ("Roehrle", {"c10": 10, "c01": 10, "kappa": 100, "sigma_p": 300, "sigma_a": 300, "lambda_opt": 1.05}, 0.2, 0.25),
        2: ("Blemker", {"G1": 10, "G2": 10, "kappa": 100, "sigma_max": 300, "lambda_opt": 1.05}, 0.2, 0.25),
        3: ("Ehret", {"alpha": 19.69, "beta": 1.19, "gamma_e": 0.5, "kappa": 20}, 0.01, 0.25)}


def law_entries(law):
    name, constants, *_ = LAWS[law]
    return {"Muscle/Law": law, **{f"{name}/{symbol}": value for symbol, value in constants.items()}}


class Laws(Case):
    """The elastic laws 1 to 3, active and growing."""

    CUBE = {**BRICK, "Geometry/Length": 1, "Geometry/Width": 1, "Geometry/Height": 1, "Geometry/Cells": "1, 1, 1", "Ends/Kind": "mixed",
            "Fibre/Direction": "0.33, 0.5, 0.8", "Time/Ramp": 2, "Time/End": 4, "Time/Steps": "fixed", "Time/Step": 0.125}

    def test_a_cube_is_the_drivers(self):
        """One element with an oblique fibre, activated while it is pulled: the UMAT in the one-element driver."""
        driver = os.environ.get("MYOGROWTH_DRIVER")
        if not driver:
            self.skipTest("there is no driver")
        for law, (_, constants, activation, pull) in LAWS.items():
            numbers = ", ".join(f"{x:.15e}" for x in constants.values())
            path = self.folder / f"law{law}.nml"
            path.write_text(
                f"&material props = 0.0, 0.0, 0.5, 2.0, 1.1, 1.01, 0.33, 0.5, 0.8, 2*0.0, 1.0, 6*0.0, {law}.0, -1.0, {numbers} nstatv = 9 /\n"
                f"&time duration = 4.0 dt = 0.125 /\n&field time = 0.0, 2.0 value = 0.0, {activation} /\n" +
                "".join(f"&face name = 'z-' direction = '{d}' value = 0.0 /\n" for d in "xyz") +
                f"&face name = 'z+' time = 0.0, 2.0 value = 0.0, {pull} /\n"
                "&solver tolerance_residual = 1.0e-12 tolerance_displacement = 1.0e-6 max_iterations = 40 /\n"
                "&output reaction_face = 'z+' /\n")
            done = subprocess.run([driver, path, "--out", self.folder / "driver"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("32 increments, 0 cut-backs", done.stdout)  # so that both take the same steps
            with open(self.folder / "driver" / "history.csv", encoding="ascii") as f:
                rows = list(csv.DictReader(f))[1:]
            self.run_muscle(1, f"law{law}", {**self.CUBE, **SHARP, **law_entries(law), "Muscle/Activation": f"2:{activation}", "Ends/Pull": pull})
            ours = self.columns(f"law{law}")
            self.assertEqual([float(r["time"]) for r in rows], ours["time"].tolist())
            self.assertGreater(ours["G_mean"][-1], 1.003)
            for k, row in enumerate(rows):
                for theirs, column in (("reaction", "reaction"), ("G", "G_mean"), ("lambda_e", "lambda_e_mean")):
                    self.assertAlmostEqual(ours[column][k], float(row[theirs]), delta=1e-10 * max(1, abs(float(row[theirs]))), msg=(law, k, column))

    def test_newton_is_quadratic(self):
        for law, activation, pull in ((1, 0.2, 10), (2, 0.2, 10), (3, 0.005, 6)):
            for volume in ("pointwise", "mean dilatation"):
                self.run_muscle(1, "a", {**BRICK, **law_entries(law), "Muscle/Volume": volume, "Muscle/Activation": activation, "Ends/Pull": pull,
                                         "Fibre/Kind": "oblique", "Fibre/Angle": 30, "Time/Steps": "fixed", "Time/Step": 0.1, "Time/End": 1.2,
                                         "Solver/Newton tolerance": 1e-12, "Solver/Krylov tolerance": 1e-12, "Solver/Predictor": "false"})
                self.assertGreater(self.columns("a")["G_max"][-1], 1.03)
                near = [(a, b) for norms in self.checks("a") for a, b in zip(norms[1:], norms[2:]) if 1e-8 < a < 5e-3]
                print(f"law {law}, {volume}: residual <= {max(b / a ** 2 for a, b in near if b > 1e-11):.1f} (last residual)^2, {len(near)} pairs")
                self.assertGreaterEqual(len(near), 10)
                for a, b in near:
                    self.assertLess(b, max(10 * a * a, 1e-11))

    def test_the_dense_loop_gives_the_same(self):
        for law, (_, _, activation, pull) in LAWS.items():
            entries = {**self.CUBE, **SHARP, **law_entries(law), "Muscle/Activation": f"2:{activation}", "Ends/Pull": pull}
            for assembly in ("compact", "dense"):
                self.run_muscle(1, assembly, {**entries, "Solver/Assembly": assembly})
            self.assert_alike(self.columns("compact"), self.columns("dense"), 1e-10)

    def test_law_1_without_fibres_is_law_0(self):
        for volume in ("pointwise", "mean dilatation"):
            entries = {**BRICK, **SHARP, "Muscle/Volume": volume, "Fibre/Kind": "oblique", "Fibre/Angle": 20, "Time/End": 2}
            self.run_muscle(1, "law0", entries)
            text = self.run_muscle(1, "law1", {**entries, "Muscle/Law": 1, "Muscle/c1": 16, "Roehrle/c10": 4, "Roehrle/c01": 0, "Roehrle/kappa": 16,
                                               "Roehrle/sigma_p": 0, "Roehrle/sigma_a": 0, "Ehret/w0": 0.5})
            self.assert_alike(self.columns("law0"), self.columns("law1"), 1e-10)
            self.assertIn("muscle: elastic law 1 (Roehrle): c10 = 4, c01 = 0, kappa = 16, sigma_p = 0, ", text)
            self.assertIn("Muscle/c1 is not read: nothing has elastic law 0\n", text)
            self.assertIn("Ehret/w0 is not read: nothing has elastic law 3\n", text)

    def test_an_activation_at_once_is_a_jump(self):
        """A number, or two rows of one time: without growth, in parts if it must be."""
        entries = {**BRICK, **SHARP, "Muscle/Law": 1, "Roehrle/lambda_opt": 1.05, "Ends/Kind": "free", "Time/Steps": "fixed", "Time/Step": 0.5, "Time/End": 2}
        for name, activation in (("number", "0.5"), ("rows", "0:0, 0:0.5"), ("later", "0:0.2 1:0.2 1:0.5")):
            self.run_muscle(1, name, {**entries, "Muscle/Activation": activation})
        self.assert_alike(self.columns("number"), self.columns("rows"), 1e-12)
        columns = self.columns("number")
        self.assertEqual(columns["time"].tolist(), [0, 0.5, 1, 1.5, 2])
        self.assertEqual(columns["G_max"][0], 1)
        self.assertGreater(columns["reaction"][0], 1000)
        columns = self.columns("later")
        self.assertEqual(columns["time"].tolist(), [0, 0.5, 1, 1, 1.5, 2])
        self.assertEqual(columns["G_mean"][2], columns["G_mean"][3])
        self.assertGreater(columns["reaction"][3], 1.5 * columns["reaction"][2])

    def test_restart(self):
        entries = {**BRICK, **SHARP, **law_entries(1), "Muscle/Activation": "0:0.1 1:0.3", "Time/Steps": "fixed", "Time/Step": 0.1,
                   "Time/End": 1, "Fibre/Kind": "oblique", "Fibre/Angle": 20}
        self.run_muscle(1, "whole", {**entries, "Output/Checkpoint every": 0})
        self.run_muscle(1, "a", {**entries, "Output/Checkpoint every": 7})
        text = self.run_muscle(1, "a", {**entries, "Output/Resume": "true", "Muscle/Activation": 0.3}, status=1)
        self.assertIn("Muscle/Activation = 0.3, in the checkpoint 0:0.1 1:0.3", text)
        text = self.run_muscle(2, "a", {**entries, "Output/Resume": "true", "Output/Checkpoint every": 0})
        self.assertNotIn("rows", text)
        self.assert_alike(self.columns("whole"), self.columns("a"), 1e-10)

    def test_a_checkpoint_of_before_there_were_laws(self):
        self.run_muscle(1, "a", Restart.SHORT)
        path = self.folder / "a" / "checkpoint"
        content = path.read_bytes()
        records = content[72 + int.from_bytes(content[24:32], "little"):]
        text = b"".join(line for line in content[72:-len(records)].splitlines(True) if not line.startswith((b"Muscle/Law", b"Muscle/Act", b"Roehrle")))
        self.assertLess(len(text) + 72 + len(records), len(content))
        header = content[:24] + len(text).to_bytes(8, "little") + content[32:64] + bytes(8)
        path.write_bytes(header[:64] + zlib.crc32(header + text).to_bytes(8, "little") + text + records)
        checkpoint = path.read_bytes()
        for entries, status, message in (({"Muscle/Law": 2}, 1, "Muscle/Law = 2, in the checkpoint not said"), ({}, 0, "resumed at time 1")):
            path.write_bytes(checkpoint)
            self.assertIn(message, self.run_muscle(1, "a", {**Restart.SHORT, "Time/End": 1.5, "Output/Resume": "true", **entries}, status=status))

    def test_what_is_not_allowed(self):
        self.assert_refused([
            ({"Muscle/Law": 4}, r"Muscle/Law = 4: must be 0 \(neo-Hookean\), 1 \(Roehrle\), 2 \(Blemker\) or 3 \(Ehret\)$"),
            ({"Muscle/Law": 1, "Roehrle/c10": 0}, r"Roehrle/c10 = 0: matrix, must be finite and > 0\.$"),
            ({"Muscle/Law": 3, "Ehret/lambda_opt": 0.5}, r"Ehret/lambda_opt = 0.5: optimum elastic stretch, must be finite and > lambda_min\.$"),
            ({"Blemker/tendon": 0.5}, r"Blemker/tendon = 0.5: .* must be finite and 0 or 1\.$"),
            ({"Roehrle/G1": 1}, r"there is no entry 'Roehrle/G1'; there are c10, c01, kappa,"),
            ({"Muscle/Activation": 0.5}, r"Muscle/Activation = 0.5: must be 0: no muscle has an elastic law with an active force"),
            ({"Muscle/Law": 2, "Blemker/tendon": 1, "Muscle/Activation": 0.5}, r"must be 0: no muscle has an elastic law with an active force"),
            ({"Muscle/Law": 1, "Muscle/Activation": -1}, r"Muscle/Activation = -1: activation, must be >= 0 and <= 1; -1 is not"),
            ({"Muscle/Law": 1, "Muscle/Activation": "1:0.5 2:1.5"}, r"= 1:0.5 2:1.5: activation, must be >= 0 and <= 1; 1.5 is not"),
            ({"Muscle/Law": 1, "Muscle/Activation": "2:0.5 1:0"}, r"the times must ascend; 1 does not"),
            ({"Muscle/Law": 1, "Muscle/Activation": "0,5"}, r"must be a number >= 0 and <= 1 or a table TIME:ACTIVATION .* decimal comma")])
        path = self.folder / "bad.prm"
        path.write_text("subsection Muscle\n  set Law = 2\nend\nsubsection Blemker\n  set lambda_star = 1\nend\n")
        self.assertRegex(self.run_muscle(1, "bad", BRICK, status=1, prm=path), r"bad.prm:5:7: Blemker/lambda_star = 1: end of .*, must be finite and > 1\.")


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
        self.assertRegex(text, r"is halved: no result \(inverted: det F must be > 0\) in hexahedron .*, point \d at \(.*\), G = 1, F = \[")
        self.assertEqual(self.columns("crushed")["time"][-1], 1)
        self.assertEqual(text.count("det F"), text.count("is halved: no result"))

    def test_steps_are_as_long_as_the_time_error_allows(self):
        for tolerance in (1e-3, 1e-6):
            self.run_muscle(1, f"{tolerance}", {**BRICK, "Time/Tolerance": tolerance, "Time/Ramp": 0.5, "Time/End": 10})
        coarse, fine = self.columns("0.001"), self.columns("1e-06")
        self.assertGreater(len(fine["time"]), 1.5 * len(coarse["time"]))
        self.assertLess(abs(coarse["G_mean"][-1] - fine["G_mean"][-1]), 1e-3)

    def test_a_pull_takes_as_many_steps_as_asked_for(self):
        entries = {**BRICK, **SHARP, "Time/Tolerance": 1, "Time/Step": 1, "Time/Ramp": 1, "Time/End": 1}
        for part, steps in ((0.25, 4), (0.5, 2), (1, 1)):
            self.run_muscle(1, f"part_{part}", {**entries, "Time/Part": part})
            self.assertEqual(len(self.columns(f"part_{part}")["time"]), steps)

    def test_gives_up_where_no_step_is_short_enough(self):
        text = self.run_muscle(1, "impossible", {**BRICK, "Ends/Pull": 1e6, "Solver/Newton iterations": 1, "Time/Steps": "fixed", "Time/Step": 1e-7, "Time/End": 0.01, "Time/Ramp": 0.01,
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
        self.assert_refused([
            ({"Muscle/tau": -1}, r"Muscle/tau = -1: must be > 0"),
            ({"Muscle/tau": "nan"}, r"Muscle/tau = nan: must be a number"),
            ({"Muscle/taux": 1}, r"there is no entry 'Muscle/taux'; there are c1, c2, tau,"),
            ({"Muskel/tau": 1}, r"there is no entry 'Muskel/tau'"),
            ({"Muscle/tau": "1e-320"}, r"Muscle/tau = 1e-320: must be a number: 1e-320 is beyond the range of double"),
            ({"Fibre/Direction": "0, 0, 1e-320"}, r"Fibre/Direction = 0, 0, 1e-320: must be three numbers: 1e-320 is beyond"),
            ({"Fibre/Direction": "0,1"}, r"Fibre/Direction = 0,1: must be three numbers$"),
            ({"Fibre/Kind": "function", "Fibre/Function": "0; 0; z0"}, r"Fibre/Function = 0; 0; z0: must be three expressions"),
            ({"Muscle/c1": -3}, r"Muscle/c1 = -3: must be > -2/3 c2"),
            ({"Muscle/tau_rev": 1, "Muscle/lambda_crit_rev": 3}, r"Muscle/lambda_crit_rev = 3: must be > 0 and <= lambda_crit"),
            ({"Time/End": 0.5}, r"Time/End = 0.5: must be >= Time/Ramp"),
            ({"Time/Step": "0,1"}, r"Time/Step = 0,1: must be a number > 0: decimal comma\? write 0.1"),
            ({"Time/Step": 1e-300}, r"Time/Step = 1e-300: must be >= 1e-9 of the end"),
            ({"Time/End": 1e16, "Time/Ramp": 1e15, "Time/Step": 1e8}, r"Time/Longest = 4: must be longer: more than a million steps"),
            ({"Time/Steps": "fixed", "Time/Step": 1e-6}, r"Time/Step = 1e-06: must be longer: more than a million steps"),
            ({"Geometry/Kind": "cylinder", "Geometry/Refinements": 1000}, r"Geometry/Refinements = 1000: must be a whole number from 0 to 8"),
            ({"Geometry/Cells": "10000, 10000, 10000"}, r"Geometry/Cells = .*: must be smaller"),
            ({"Time/Steps": "listed"}, r"Time/Times is empty"),
            ({"Time/Steps": "listed", "Time/Times": "2, 1"}, r"Time/Times = 2, 1: must be each greater than the one before .* 1 is not"),
            ({"Output/Times": "1, 1"}, r"Output/Times = 1, 1: must be apart"),
            ({"Tendon/Length": 20}, r"Tendon/Length = 20: must be less than half of Geometry/Length"),
            ({"Tendon/Length": 1}, r"Tendon/Length = 1: must be more than half the height of the first layer"),
            ({"Fibre/Direction": "0, 0, 0"}, r"Fibre/Direction = 0, 0, 0: must be of a length > 0"),
            ({"Fibre/Kind": "function", "Fibre/Function": "sin(; 0; 1"}, r"Fibre/Function = sin\(; 0; 1: must be three"),
            ({"Fibre/Kind": "file", "Fibre/File": "nowhere"}, r"nowhere: cannot be read: No such file"),
            ({"Fibre/Kind": "file", "Fibre/File": self.folder}, r": cannot be read: Is a directory"),
            ({"Geometry/Kind": "file", "Geometry/File": "nowhere"}, r"nowhere: cannot be read: No such file"),
            ({"Geometry/Kind": "file", "Geometry/File": self.folder}, r": cannot be read: Is a directory"),
            ({"Output/Resume": "true", "Output/Folder": self.folder / "new"}, r"checkpoint: cannot be read: No such file"),
            ({"Solver/Assembly": "dense", "Solver/Preconditioner": "GAMG"}, r"Solver/Assembly = dense: must be compact")])

    def test_in_a_mesh_file(self):
        nodes, hexes = brick(lambda *p: p, (1, 1, 2))
        path = self.folder / "a.mesh"
        write_mesh(path, nodes, hexes)
        good = path.read_text()

        def swapped(*rows):
            return [[*row[4:], *row[:4]] if i in rows else row for i, row in enumerate(hexes)]

        cases = []
        for i, (content, message) in enumerate((
                ("", "mesh: is empty"), ("elements 1\n", r":1:1: expected 'nodes' .*, found 'elements'"),
                (good.replace("hexes 2", "tets 2"), r":14:1: expected 'hexes' or 'wedges' and their number, found 'tets'"),
                (good.replace("hexes 2", "hexes 999999999"), r"mesh:17:1: expected a node|of 999999999 hexes"),
                (good.replace("hexes 2", "hexes -2"), r":14:7: expected the number of hexes, a whole number .*, found '-2'"),
                (good.replace("nodes 12", "nodes 1e9"), r":1:7: expected the number of nodes, .*found '1e9'"),
                (good.replace("wedges 0", "wedges"), r":17:7: expected the number of wedges, .*, found nothing"),
                (good + "hexes 0\n", r":18:1: there are hexes already"), (good + "end\n", r":18:1: expected .*, found 'end'"),
                (good.replace("10.0 0.0 0.0", "nan 0.0 0.0"), r":3:1: expected a coordinate, a number, found 'nan'"),
                (good.replace("10.0 0.0 0.0", "10,0 0.0 0.0"), r":3:1: .*found '10,0': decimal comma\? write 10.0"),
                (good.replace("10.0 0.0 0.0", "10.0 0.0"), r":3:9: expected a coordinate, a number, found nothing"),
                (good.replace("0 1 3 2 4", "0 1 12 2 4"), r":15:5: expected a node, a whole number from 0 to 11, found '12'"),
                (good.replace("0 1 3 2 4", "0 1 1 2 4"), r":15:5: node 1 is twice in this cell"),
                (good.replace("hexes", "\0hexes"), r":14:1: a NUL byte"), (good[:good.index("hexes")], "mesh: has no cells"),
                ((nodes, swapped(1)), r"mesh:16: cell 1 is inside out or flat$"),
                ((nodes, swapped(0, 1)), r"mesh:15: cell 0 is inside out or flat; there are 2 such cells"),
                ((brick(lambda x, y, z: (x, y, min(z, 20 / 3)), (1, 1, 2))[0], hexes), r"cell 1 is inside out or flat"),
                (([*nodes, (1, 1, 1)], hexes), r"mesh:14: node 12 is of no cell"),
                (([*nodes, nodes[4]], [hexes[0], [12, *hexes[1][1:]]]), r"mesh:14: node 12 is at the place of node 4"),
                ((nodes, [*hexes, hexes[0]]), r"shares a face with|is of another part"),
                (([*nodes, *((x, y, z + 50) for x, y, z in nodes)], [*hexes, *([i + 12 for i in row] for row in hexes)]),
                 r"mesh:29: cell 2 is of another part than cell 0"))):
            name = self.folder / f"{i}.mesh"
            if isinstance(content, str):
                name.write_text(content)
            else:
                write_mesh(name, *content)
            cases.append(({"Geometry/Kind": "file", "Geometry/File": name}, message))
        self.assert_refused(cases)
        write_mesh(path, nodes, hexes)  # byte order mark, CRLF, comments, empty lines
        path.write_bytes(b"\xef\xbb\xbf# a brick\r\n" + path.read_bytes().replace(b"\n", b" \r\n \r\n"))
        self.run_muscle(3, "good", {**BRICK, "Geometry/Kind": "file", "Geometry/File": path, "Ends/Pull": 1, "Time/End": 1})  # 2 cells

    def test_in_a_fibre_file(self):
        cases = []
        for i, (rows, message) in enumerate((("0 0 0 0 0 0\n", r":2:7: expected a fibre of a length > 0"), ("0 0 0 0 nan 1\n", r":2:9: .*found 'nan'"),
                              ("0 0 0 0 1\n", r":2:10: .*found nothing"), ("0 0 0 0 0 1 1\n", r":2:13: expected the end of the row"),
                                             ("", "has no rows"))):
            (self.folder / f"{i}.txt").write_text("# x y z n1 n2 n3\n" + rows)
            cases.append(({"Fibre/Kind": "file", "Fibre/File": self.folder / f"{i}.txt"}, message))
        self.assert_refused(cases)

    def test_on_one_rank_of_several_is_told_by_all(self):
        text = self.run_muscle(3, "bad", {**BRICK, "Fibre/Kind": "function", "Fibre/Function": "if(z > 30, 0, 1); 0; 0"}, status=1)
        self.assertEqual(text.count("must be finite and of a length > 0"), 1)

    def test_in_a_file(self):
        path = self.folder / "bad.prm"
        for content, message in (
                ("subsection Muscle\n  set G_max = 0.9\nend\n", r"bad.prm:2:7: Muscle/G_max = 0.9: must be > 1"),
                ("subsection Muscle\n  set c1 = x\nend\n", r":2:7: Muscle/c1 = x: must be a number"),
                ("subsection Muscle\n  set c3 = 1\nend\n", r":2:7: there is no entry 'Muscle/c3'; there are c1, c2"),
                ("subsection Muscle\n  set c1 = 1\n  set c1 = 2\nend\n", r":3:7: Muscle/c1 is said twice, .* 1 and 2; first in .*:2:7"),
                ("subsection Muskel\nend\n", r":1:12: expected a section: .*, found 'Muskel'"),
                ("subsection Time\nend\nsubsection Time\nend\n", r":3:12: section Time is there already, in .*:1:12"),
                ("subsection Time\n", r"section Time has no 'end'"), ("set c1 = 1\n", r":1:1: expected 'subsection NAME', found 'set'"),
                ("subsection Time\n  End 42\nend\n", r":2:3: expected 'set ENTRY = VALUE' or 'end' of Time, found 'End'")):
            with self.subTest(message):
                path.write_text(content)
                text = subprocess.run([MUSCLE, path], env=ENVIRONMENT, capture_output=True, text=True, check=False)
                self.assertEqual(text.returncode, 1)
                self.assertRegex(text.stderr, message)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
