"""The cylinder in CalculiX: mesh, decks, readers, VTU, figures, and, where there is a ccx, whole jobs.

test_python.py SOURCE CCX LIBRARY_DIR [unittest arguments]      CCX = none: without the tests that need it
"""
import contextlib
import csv
import importlib
import io
import json
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest

import numpy as np

SOURCE, CCX, LIBRARY_DIR = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3]
EXAMPLES = SOURCE / "examples" / "calculix"
HAS_CCX = os.access(CCX, os.X_OK) and (pathlib.Path(LIBRARY_DIR) / "libMYOGROWTH.so").is_file()
sys.dont_write_bytecode = True
sys.path.insert(0, str(EXAMPLES))
cylinder_mesh, deck, elements, files, frd, history, kept = map(
    importlib.import_module, ("cylinder_mesh", "deck", "elements", "files", "frd", "history", "kept"))


def no_room(size):
    """For preexec_fn: files end at `size`, as on a disk that is full."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    @staticmethod
    def main(name, *options):
        """A program's main() as the interpreter would run it; in this process, which has read the libraries."""
        module = importlib.import_module(name)
        status, out, err, argv, handler = 0, io.StringIO(), io.StringIO(), sys.argv, signal.getsignal(signal.SIGTERM)
        sys.argv = [name + ".py", *map(str, options)]
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                module.main()
        except SystemExit as e:
            status = e.code if isinstance(e.code, int) else 1
            err.write("" if isinstance(e.code, int) else f"{e.code}\n")
        finally:
            sys.argv = argv
            signal.signal(signal.SIGTERM, handler)
            while files._locks:  # as for a process that ends
                files._locks.pop().close()
        return subprocess.CompletedProcess(options, status, out.getvalue(), err.getvalue())


class Files(Folder):
    """examples/common/files.py, which all Python programs read and write with."""

    def setUp(self):
        super().setUp()
        self.path = self.folder / "table.csv"

    def fails(self, words, call, *arguments):
        with self.assertRaises(files.FileError) as caught:
            call(*arguments)
        self.assertIn(words, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))

    def test_tables(self):
        """What spreadsheets and other systems make of a table is the same table."""
        for text in ("t,G\n0,1\n7,1.05\n", "\ufefft,G\r\n0,1\r\n7,1.05\r\n", "t,G\r0,1\r7,1.05",
                     " t , G \n\n  \n0, 1 \n,,\n\"7\",1.05\n",
                     "# a comment\nt,G,,\n0,1,,\n7,1.05,,  # another\n,,,\n"):
            self.path.write_bytes(text.encode())
            self.assertEqual(files.read_columns(self.path, ["t", "G"]), {"t": [0, 7], "G": [1, 1.05]}, text)

    def test_bad_tables(self):
        for text, words in ((b"", "table.csv: is empty: expected the header t,G"), (b"\n  \n", "is empty"),
                            (b"t,G\n", "table.csv: expected rows below the header"),
                            (b"G,t\n1,2\n", "table.csv:1: 'G,t': expected the header t,G"),
                            (b"t;G\n0;1\n", "table.csv:1: 't;G': expected commas between the columns, not semicolons"),
                            (b"t,G\n0,1\n7;1,05\n", "table.csv:3: '7;1,05': expected commas"), (b"t,G\n0;1\n", "not semicolons"),
                            (b"t,G\n7,1,05\n", "table.csv:2: 3 values: expected 2, t, G; numbers need a decimal point"),
                            (b't,G\n7,"1,05"\n', "table.csv:2: G = '1,05': expected a finite number, with a decimal point"),
                            (b"t,G\n\n7\n", "table.csv:3: 1 values: expected 2"), (b"t,G\n7,\n", "table.csv:2: G is missing"),
                            (b"t,G\n7,nan\n", "table.csv:2: G = 'nan': expected a finite number"),
                            (b"t,G\n7,1e999\n", "G = '1e999'"), (b"t,G\n7,1_0\n", "G = '1_0'"), (b"t,G\nx\ty,1\n", "t = 'x\\ty'"),
                            (b"t,G\n7,\"1\n", "table.csv:2: "), (b"t,G\n0,1\n\xb5,1\n", "table.csv:3: byte 0xb5 is not UTF-8"),
                            ("t,G\n0,1\n".encode("utf-16"), "is UTF-16: save it as UTF-8"),
                            (b"t,G\n0,1\n\0\0", "table.csv:3: has a byte of value 0")):
            self.path.write_bytes(text)
            self.fails(words, files.read_columns, self.path, ["t", "G"])

    def test_bad_json(self):
        for text, words in (('{"a": 1', "table.csv:1: column 8: is damaged or no JSON"),
                            ("", "is damaged"), ("[1]", "expected an object"),
                            ("[" * 100000, "nested too deeply")):
            self.path.write_text(text)
            self.fails(words, files.read_json, self.path)

    def test_a_file_is_written_whole_or_stays_as_it_was(self):
        self.path.write_text("old")
        self.path.chmod(0o640)
        with self.assertRaises(KeyboardInterrupt), files.writing(self.path) as part:
            part.write_text("half")
            raise KeyboardInterrupt
        self.assertEqual(self.path.read_text(), "old")
        files.write_text(self.path, "new\n")
        self.assertEqual((self.path.read_text(), self.path.stat().st_mode & 0o777), ("new\n", 0o640))
        link = self.folder / "link"
        link.symlink_to(self.path)
        files.write_text(link, "by the link\n")
        self.assertTrue(link.is_symlink() and self.path.read_text() == "by the link\n")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["link", "table.csv"])

    def test_a_device_without_an_end(self):
        self.addCleanup(setattr, files, "MOST_OF_DEVICE", files.MOST_OF_DEVICE)
        files.MOST_OF_DEVICE = 2**20
        self.fails("/dev/zero: is no file, and larger than 1 MiB", files.read_text, "/dev/zero")

    def test_what_cannot_be_written(self):
        self.path.write_text("old")
        full = pathlib.Path("/dev/full")
        self.fails("/dev/full: cannot be written: No space left on device", files.write_text, full, "text")
        self.assertTrue(full.is_char_device())
        self.fails(f"{self.folder}: cannot be written: it is a folder", files.write_text, self.folder, "text")
        self.fails("cannot be written: Not a directory", files.write_text, self.path / "x", "text")
        self.fails("cannot be written: No such file or directory", files.write_text, self.folder / "no" / "x", "text")
        self.fails("table.csv: cannot be made a folder: there is a file of that name", files.make_folder, self.path)
        self.fails("cannot be made a folder: a part of its name is a file", files.make_folder, self.path / "x")

    def run_with(self, body, **options):
        script = ("import sys\nsys.path.insert(0, sys.argv[1])\nimport files\n"
                  f"with files.faults_in_one_line('job'):\n    {body}\n")
        return subprocess.run([sys.executable, "-c", script, SOURCE / "examples" / "common", self.folder], text=True,
                              **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options})

    def test_one_line_and_a_status(self):
        self.path.write_text("old")
        done = self.run_with("files.write_text(sys.argv[2] + '/table.csv', 'x' * 100000)", preexec_fn=no_room(65536))
        self.assertEqual((done.returncode, done.stderr), (1, f"job: {self.path}: cannot be written: File too large\n"))
        self.assertEqual(self.path.read_text(), "old")
        done = self.run_with("files.make_folder(sys.argv[2] + '/new')", preexec_fn=no_room(4096))
        self.assertEqual((done.returncode, done.stderr), (1, f"job: {self.folder}/new: cannot be written to: File too large\n"))
        with open("/dev/full", "w") as full:
            done = self.run_with("print('a result')", stdout=full)
        self.assertEqual((done.returncode, done.stderr),
                         (1, "job: standard output cannot be written: No space left on device\n"))
        done = self.run_with("print('λ')", env={**os.environ, "PYTHONIOENCODING": "ascii"})
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "\\u03bb\n", ""))
        done = subprocess.run(["sh", "-c", '"$@" >&-', "sh", sys.executable, EXAMPLES / "cylinder_mesh.py", "tiny", self.path],
                              stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr), (1, "cylinder_mesh.py: standard output is closed\n"))
        for body, words in (("open('/nowhere')", "job: /nowhere: No such file or directory\n"),
                            ("open('/')", "job: /: Is a directory\n"),
                            ("import os; os.read(99, 1)", "job: Bad file descriptor\n"),
                            ("import subprocess; subprocess.run(['false'], check=True)", "job: false ended with status 1\n"),
                            ("import subprocess; subprocess.run(['sh', '-c', 'kill -9 $$'], check=True)",
                             "job: sh was killed by signal 9 (Killed)\n")):
            done = self.run_with(body)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "", words))

    def test_programs_say_what_they_cannot_read_or_write(self):
        timing = self.folder / "benchmark.json"
        run = {"run_type": "iteration", "run_name": "umat_/cache/active/2/threads:1", "name": "umat_", "family_index": 0,
               "threads": 1, "cpu_time": 5.0, "points": 1, "bytes_read": 8, "bytes_written": 8, "difference": 0}
        for name in ("results.json", "chart.png"):
            (self.folder / name).write_text("older")
        for text, script, arguments, words in (
                ("{", "bench/report.py", [timing], f"report.py: {timing}:1: column 2: is damaged or no JSON"),
                ("{}", "bench/report.py", [timing], f"report.py: {timing}: is not what `bench` writes: KeyError 'benchmarks'"),
                (json.dumps({"benchmarks": [], "context": {}}), "bench/report.py", [timing], "has no timings"),
                (json.dumps({"benchmarks": [{**run, "cpu_time": math.nan}]}), "bench/report.py", [timing],
                 "umat_: cpu_time = nan: expected"),
                (json.dumps({"benchmarks": [{**run, "run_name": "umat_"}]}), "bench/report.py", [timing],
                 "is not what `bench` writes"),
                ("", "bench/mpi_scaling.py", [], "usage: mpi_scaling.py MUSCLE"),
                ("", "bench/mpi_scaling.py", ["muscle", "PART=all"],
                 "PART=all: must be PART= and some of loops,krylov,ranks,weak"),
                ("", "examples/calculix/cylinder_mesh.py", ["tiny", "/dev/full"],
                 "cylinder_mesh.py: /dev/full: cannot be written: No space left on device"),
                ("", "examples/calculix/cylinder_mesh.py", ["tiny", timing / "x"],
                 "benchmark.json/x: cannot be written: Not a directory"),
                ("", "examples/calculix/figures.py", [self.folder],
                 f"figures.py: {self.folder}/case.json: No such file or directory"),
                ("", "docs/site/build_site.py", [timing], "cannot be made a folder: there is a file of that name"),
                ("", "tests/docs/check_manual.py", [timing], "usage: check_manual.py"),
                ("", "tests/docs/verify.py", ["build", "--check", "/nowhere"], "verify.py: /nowhere: No such file or directory")):
            timing.write_text(text)
            done = subprocess.run([sys.executable, SOURCE / script, *arguments], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (1, ""), script)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertEqual([p.name for p in self.folder.iterdir()], [timing.name])  # nothing of an older run

    def test_numbers_of_options(self):
        import argparse

        self.assertEqual(files.number(above=0, high=2)("1.5"), 1.5)
        for text in ("0", "-1", "2.5", "nan", "inf", "1e999", "x", "", "1_0"):
            with self.assertRaisesRegex(argparse.ArgumentTypeError, "must be a finite number > 0 and <= 2"):
                files.number(above=0, high=2)(text)
        with self.assertRaisesRegex(argparse.ArgumentTypeError, "write a decimal point"):
            files.number(above=0)("0,5")
        for text in ("1.0", "0", "300", "-3", "1e2"):
            with self.assertRaisesRegex(argparse.ArgumentTypeError, "must be a whole number >= 1 and <= 256"):
                files.number(1, 256, kind=int)(text)


class Mesh(unittest.TestCase):
    COUNTS = {"tiny": (80, 80), "coarse": (1296, 864), "medium": (3360, 2280),
              "paper": (38556, 14931), "fine": (27600, 16800)}
    FACES = {8: [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
             6: [(0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]}

    def each(self):
        for size in cylinder_mesh.SIZES:
            with self.subTest(size):
                yield size, cylinder_mesh.SIZES[size], cylinder_mesh.mesh(size)

    def test_counts(self):
        self.assertEqual(set(self.COUNTS), set(cylinder_mesh.SIZES))
        for size, _, m in self.each():
            self.assertEqual((len(m.hexes), len(m.wedges)), self.COUNTS[size])
        self.assertEqual(len(cylinder_mesh.mesh("paper").nodes), 51680)

    def test_volume_and_jacobians(self):
        for _, s, m in self.each():
            outer = s.rings[-1]
            exact = outer / 2 * 10**2 * math.sin(2 * math.pi / outer) * 400
            volumes = [elements.gauss_points(m.nodes, cells)[1] for cells in m.elements()]
            self.assertTrue(all((v > 0).all() for v in volumes))
            self.assertAlmostEqual(sum(v.sum() for v in volumes) / exact, 1, delta=1e-12)

    def test_node_sets(self):
        for _, _, m in self.each():
            self.assertEqual(set(m.proximal), set(np.flatnonzero(m.nodes[:, 2] == 0)))
            self.assertEqual(set(m.distal), set(np.flatnonzero(m.nodes[:, 2] == 400)))
            used = np.unique(np.concatenate([m.hexes.ravel(), m.wedges.ravel()]))
            self.assertTrue(np.array_equal(used, np.arange(len(m.nodes))))

    def skin(self, m):
        """The faces that one element has to itself; a face of three or more elements is an error."""
        faces = []
        for cells in m.elements():
            for face in self.FACES[cells.shape[1]]:
                nodes = np.sort(cells[:, list(face)], axis=1)
                faces.append(np.pad(nodes, ((0, 0), (4 - len(face), 0)), constant_values=-1))
        unique, count = np.unique(np.concatenate(faces), axis=0, return_counts=True)
        self.assertLessEqual(count.max(), 2)
        return unique[count == 1]

    def test_conforming(self):
        for _, s, m in self.each():
            outside = self.skin(m)
            self.assertEqual(len(outside), 2 * (len(m.hexes) + len(m.wedges)) // s.layers + s.rings[-1] * s.layers)
            for face in outside:
                p = m.nodes[face[face >= 0]]
                self.assertTrue(np.ptp(p[:, 2]) == 0 and p[0, 2] in (0, 400)
                                or np.allclose(np.hypot(p[:, 0], p[:, 1]), 10))

    def test_a_gap_would_be_seen(self):
        m = cylinder_mesh.mesh("tiny")
        self.assertEqual(len(self.skin(m._replace(hexes=np.delete(m.hexes, 30, axis=0)))), len(self.skin(m)) + 4)

    def test_layers(self):
        for _, s, m in self.each():
            heights = np.diff(m.levels)
            half = len(heights) // 2
            self.assertEqual((m.levels[0], m.levels[-1], len(heights)), (0, 400, s.layers))
            self.assertTrue(np.allclose(heights, heights[::-1]))
            self.assertAlmostEqual(heights.max() / heights.min(), s.grading, places=9)
            if s.grading > 1:
                self.assertTrue((np.diff(heights[:half]) > 0).all())
            centres = np.concatenate([m.nodes[cells].mean(axis=1) for cells in m.elements()])[:, 2]
            self.assertTrue(np.array_equal(np.searchsorted(m.levels, centres) - 1, m.layer_of_elements()))


class Elements(unittest.TestCase):
    def test_linear_fields_are_exact(self):
        m = cylinder_mesh.mesh("tiny")
        F = np.array([[1.1, 0.02, 0.03], [-0.04, 0.9, 0.05], [0.06, -0.07, 1.2]])
        for cells in m.elements():
            found = elements.gradients_at_centre(m.nodes, m.nodes @ (F - np.eye(3)).T, cells)
            self.assertTrue(np.allclose(found, F, atol=1e-12))

    def test_derivatives_are_those_of_the_shape_functions(self):
        at, h = np.array([[0.2, 0.3, -0.4]]), 1e-6
        for nodes in (6, 8):
            value, derivatives = elements.shape(nodes, at)
            self.assertAlmostEqual(value.sum(), 1)
            for k in range(3):
                step = h * np.eye(3)[k]
                difference = (elements.shape(nodes, at + step)[0] - elements.shape(nodes, at - step)[0]) / (2 * h)
                self.assertTrue(np.allclose(difference, derivatives[:, :, k], atol=1e-9))


class Decks(unittest.TestCase):
    def all_legs(self, case):
        m = cylinder_mesh.mesh(case.size)
        return [deck.leg(case, m, k) for k in range(len(deck.leg_times(case)))]

    def test_times(self):
        self.assertEqual(deck.output_times(deck.Case()), [1, 7, 14, 28, 42])
        self.assertEqual(deck.output_times(deck.Case(duration=10)), [1, 7, 10])
        self.assertEqual(deck.output_times(deck.Case(ramp=8, duration=28)), [8, 14, 28])
        self.assertEqual(deck.output_times(deck.Case(ramp=3, duration=3)), [3])
        # Two that are nearly the same would be one file, day_7.vtu, and a leg without length.
        self.assertEqual(deck.output_times(deck.Case(ramp=6.9999999, duration=42.0000001)), [6.9999999, 14, 28, 42.0000001])
        for case in (deck.Case(ramp=6.9999999, duration=27.98), deck.Case(ramp=6.99, duration=28.03)):
            times = deck.output_times(case)
            self.assertEqual(len({f"{day:g}" for day in times}), len(times))

    def test_steps(self):
        for size in cylinder_mesh.SIZES:
            for case in (deck.Case(size), deck.Case(size, ramp=0.01, duration=50), deck.Case(size, ramp=30.0, pull=80.0)):
                levels = cylinder_mesh.layer_levels(cylinder_mesh.SIZES[size].layers, cylinder_mesh.SIZES[size].grading)
                height = levels[-1] - levels[-2]
                t, count = 0.0, 0
                for start, end in deck.leg_times(case):
                    steps = deck.steps_of_leg(case, start, end, height)
                    self.assertEqual([s.output for s in steps], [False, True])
                    for s in steps:
                        self.assertTrue(0 < s.first <= s.longest <= s.period)
                        count += deck.planned_increments(s)
                        if t == 0:
                            self.assertLess(case.pull * s.first / case.ramp, height / 2)
                        t += s.period
                    self.assertAlmostEqual(t, end, delta=1e-9)
                self.assertTrue(20 <= count <= 55, count)

    def test_cards(self):
        legs = self.all_legs(deck.Case("tiny", energy=1, integration=1, fibre_angle=30))
        self.assertIn("*USER MATERIAL, CONSTANTS=12\n16, 4, 0.5, 2, 1.1, 1.01, 0.5, 0\n0.866025403784439, 0., 1., 1.\n",
                      legs[0])
        self.assertIn("NAME=@ABAQUS_MYOGROWTH_CCX@MUSCLE", legs[0])
        self.assertIn("PROXIMAL, 1, 3\nDISTAL, 1, 2\n", legs[0])
        self.assertNotIn("RESTART, READ", legs[0])
        self.assertIn("\n16, 4, 0.123456789, 2, 1.1,", self.all_legs(deck.Case("tiny", tau=0.123456789))[0])  # not cut
        for text in legs:
            self.assertEqual(text.count("*STEP, NLGEOM"), 2)
            self.assertEqual(text.count("*RESTART, WRITE"), 1)
            self.assertNotIn("ORIENTATION", text)
            self.assertNotIn("FREQUENCY", text)
            for line in text.splitlines():
                self.assertLessEqual(len(line), 130)
                self.assertTrue(all(len(field.strip()) <= 20 for field in line.split(",")) or line.startswith("*"), line)
        for text in legs[1:]:
            self.assertTrue(text.splitlines()[1] == "*RESTART, READ")
            self.assertNotIn("*NODE,", text)

    def test_props_are_the_manuals(self):
        manual = (SOURCE / "docs" / "manual.md").read_text(encoding="utf-8")
        rows = re.findall(r"^\| (\d+) \| `(\w+)` \|", manual, re.M)
        symbols = [symbol for _, symbol in rows]
        self.assertEqual(symbols[:12], ["c1", "c2", "tau", "gamma", "G_max", "lambda_crit", "n0_1", "n0_2", "n0_3", "frame",
                                        "energy", "integration"])
        after = symbols[symbols.index("G"):]
        self.assertEqual(after[:len(deck.STATE)], deck.STATE)

    def test_ends(self):
        m = cylinder_mesh.mesh("tiny")
        free = deck.leg(deck.Case("tiny", ends="free"), m, 0)
        on_x = int(np.flatnonzero(np.isclose(m.nodes[:, 0], 10) & (m.nodes[:, 2] == 0))[0]) + 1
        self.assertIn(f"*BOUNDARY\nPROXIMAL, 3, 3\n1, 1, 2\n{on_x}, 2, 2\n", free)
        mixed = deck.leg(deck.Case("tiny", ends="mixed"), m, 0)
        self.assertIn("*BOUNDARY\nPROXIMAL, 1, 3\n*STEP", mixed)
        case = deck.Case("tiny", ends="tendon", tendon_length=50, tendon_stiffness=50, tau=3.5)
        stiff = deck.tendon(case, m)
        self.assertEqual(stiff.sum(), 2 * 16)
        z = np.concatenate([m.nodes[cells].mean(axis=1) for cells in m.elements()])[:, 2]
        self.assertTrue(np.array_equal(stiff, (z < 40) | (z > 360)))
        text = deck.leg(case, m, 0)
        self.assertIn("800, 200, 3.5, 2, 1.1, 1000, 0, 0\n", text)
        self.assertIn("16, 4, 3.5, 2, 1.1, 1.01, 0, 0\n", text)
        for name, wanted in (("MUSCLE", ~stiff), ("TENDON", stiff)):
            listed = re.search(rf"\*ELSET, ELSET={name}\n([\d, \n]+)", text)[1]
            self.assertEqual([int(n) for n in re.findall(r"\d+", listed)], (np.flatnonzero(wanted) + 1).tolist())
        self.assertFalse(deck.tendon(deck.Case("tiny"), m).any())

    def test_tendons_are_alike_whatever_the_length_is_rounded_to(self):
        for size in cylinder_mesh.SIZES:
            m = cylinder_mesh.mesh(size)
            middle = (m.levels[:-1] + m.levels[1:]) / 2
            for k in range(min(5, len(middle) // 2)):
                for length in (middle[k] * (1 - 1e-13), middle[k], middle[k] * (1 + 1e-13)):  # that layer does not count
                    stiff = deck.tendon(deck.Case(size, ends="tendon", tendon_length=length), m)
                    layers = np.unique(m.layer_of_elements()[stiff])
                    self.assertEqual(layers.tolist(), [*range(k), *range(len(middle) - k, len(middle))], (size, k))


def frd_text(fields=True, last=True, nodes=6):
    """A wedge and its fields, as CalculiX writes them: two fields at day 1, one of them with two lines for a node."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 2), (1, 0, 2), (0, -1.5, 2)][:nodes]
    text = ["    1C", "    1UUSER", f"    2C{'':18}{nodes:12d}{'':37}1"]
    text += [f" -1{10 * i:10d}" + "".join(f"{x:12.5E}" for x in p) for i, p in enumerate(corners, 1)] + [" -3"]
    text += [f"    3C{'':18}{1:12d}{'':37}1", f" -1{7:10d}    2    0    1",
             " -2" + "".join(f"{10 * i:10d}" for i in range(1, 7)), " -3"]
    if fields:
        head = f"  100CL  101 1.000000000{nodes:12d}{'':21}0    1{'':11}1"
        text += ["    1PSTEP                         1           1           1", head, " -4  DISP        4    1",
                 " -5  D1          1    2    1    0", " -5  D2          1    2    2    0", " -5  D3          1    2    3    0",
                 " -5  ALL         1    2    0    0    1ALL"]
        text += [f" -1{10 * i:10d}" + "".join(f"{x:12.5E}" for x in (i, -i, i / 8)) for i in range(1, nodes + 1)] + [" -3"]
        text += [head, " -4  SDV         8    1"] + [f" -5  SDV{k:<3d}      1    1    0    0" for k in range(1, 9)]
        for i in range(1, nodes + 1):
            text += [f" -1{10 * i:10d}" + "".join(f"{x:12.5E}" for x in range(i, i + 6)),
                     " -2          " + "".join(f"{x:12.5E}" for x in (-i, i + 0.5))]
        text += [" -3"]
    return "\n".join(text + [" 9999\n"] * last)


class Frd(Folder):
    def read(self, text):
        path = self.folder / "job.frd"
        path.write_text(text)
        return frd.read_frd(path)

    def test_a_wedge(self):
        r = self.read(frd_text())
        self.assertEqual(r.nodes.tolist()[5], [0, -1.5, 2])
        self.assertEqual((r.wedge_numbers.tolist(), r.wedges.tolist(), r.hexes.shape), ([7], [[0, 1, 2, 3, 4, 5]], (0, 8)))
        self.assertEqual([s.time for s in r.steps], [1.0])
        self.assertEqual(r.steps[0].components, {"DISP": ["D1", "D2", "D3"], "SDV": [f"SDV{k}" for k in range(1, 9)]})
        self.assertEqual(r.steps[0].fields["DISP"][3].tolist(), [4, -4, 0.5])
        self.assertEqual(r.steps[0].fields["SDV"][1].tolist(), [2, 3, 4, 5, 6, 7, -2, 2.5])
        self.assertEqual(self.read(frd_text(fields=False)).steps, [])

    def bad(self, text, line, words):
        with self.assertRaises(frd.FormatError) as caught:
            self.read(text)
        self.assertIn(f"job.frd:{line}: ", str(caught.exception))
        self.assertIn(words, str(caught.exception))

    def test_truncated_anywhere(self):
        lines = frd_text().splitlines(keepends=True)
        for n in range(len(lines)):
            for text in ("".join(lines[:n]), "".join(lines[:n]) + lines[n][:2]):
                with self.subTest(n), self.assertRaises(frd.FormatError) as caught:
                    self.read(text)
                self.assertRegex(str(caught.exception), rf"job.frd:({n}|{n + 1}): ")
        self.bad("".join(lines[:7]), 8, "interrupted?")
        self.bad("".join(lines[:25]) + lines[25][:30], 26, "interrupted?")

    def test_spoiled(self):
        text = frd_text()
        self.bad(text.replace("    3C", "    4C"), 11, "expected 1, 2C, 3C")
        self.bad(text.replace("    2    0    1\n", "    6    0    1\n"), 12, "element type 6: expected 1 (C3D8) or 2 (C3D6)")
        self.bad(text.replace("         7    2", "         x    2"), 12, "expected an element number")
        self.bad(text.replace("-1.50000E+00", " ***********"), 9, "expected a number")
        self.bad(text.replace(" -4  DISP", " -7  DISP"), 17, "expected -4")
        self.bad(text.replace("1.000000000 ", "1.00000x000 ", 1), 16, "expected a time")
        self.bad(text.replace(" -1        30 3.0", " -2        30 3.0", 1), 24, "DISP in a node")
        self.bad(text.replace(" -1        60 6.00000E+00-6", " -1        99 6.00000E+00-6"), 16, "the mesh does not have")
        self.bad(text.replace("1\n -1        10 0", "2\n -1        10 0", 1), 3, "expected text")
        self.bad(text.replace("        60\n -3", "        61\n -3"), 53, "a node that is not there")
        self.bad(text.replace("2.00000E+00\n -3", "2.00000E+00\n -1"), 10, "expected -3, the end of the nodes")
        self.bad(" 9999\n", 2, "no mesh")
        self.bad(text.replace(" -1        20", " -1        10", 1), 5, "node 10 after node 10: expected increasing numbers")
        self.bad(text.replace("-1.50000E+00", "         NaN"), 9, "'         NaN' in columns 26 to 37: expected a finite number")
        self.bad(text.replace("6.00000E+00-6", "   Infinity-6"), 27, "expected a finite number")
        self.bad(text.replace("1.000000000 ", "        nan ", 1), 16, "expected a time")
        self.bad(text.replace(" -1        20 2.00000E+00", " -1        10 2.00000E+00", 1), 16,
                 "DISP is written twice for a node")
        self.bad(text.replace("2C                             6", "2C                             0"), 3, "0 nodes: must be >= 1")
        for count in ("999999999", "       -1"):
            for line, what in ((3, "nodes"), (11, "elements"), (16, "nodes")):
                lines = text.splitlines(keepends=True)
                lines[line - 1] = lines[line - 1][:24] + count.rjust(12) + lines[line - 1][36:]
                least = int(line == 3)
                self.bad("".join(lines), line, f"{count.strip()} {what}: must be >= {least} and, by the length of the file, <= ")

    def test_ends_of_lines_of_two_characters(self):
        path = self.folder / "dos.frd"
        path.write_bytes(frd_text().replace("\n", "\r\n").encode())
        self.assertEqual(frd.read_frd(path).steps[0].fields["SDV"][1].tolist(), [2, 3, 4, 5, 6, 7, -2, 2.5])

    def test_no_file(self):
        with self.assertRaises(FileNotFoundError):
            frd.read_frd(self.folder / "none.frd")


def dat_text(day, first=1.0):
    rows = [f"{e:10d} {p:3d} {first + e / 8:13.6E} {-p / 4:13.6E}" for e in (1, 2) for p in (1, 2)]
    return ("\n internal state variables (elem, integ.pnt.,values) for set ALL and time  " + f"{day:13.7E}".rjust(14) + "\n\n"
            + "\n".join(rows) + "\n\n total force (fx,fy,fz) for set DISTAL and time  " + f"{day:13.7E}" + "\n\n"
            + f"      {-1.5:14.6E}{0.25:14.6E}{day:14.6E}\n")


class Dat(Folder):
    def setUp(self):
        super().setUp()
        self.path = self.folder / "job.dat"

    def test_blocks(self):
        self.path.write_text(dat_text(0.5) + dat_text(42))
        blocks = frd.Dat(self.path).read()
        self.assertEqual([(b.name, b.set, b.time) for b in blocks],
                         [("SDV", "ALL", 0.5), ("RF", "DISTAL", 0.5), ("SDV", "ALL", 42), ("RF", "DISTAL", 42)])
        self.assertEqual((blocks[0].elements.tolist(), blocks[0].points.tolist()), ([1, 1, 2, 2], [1, 2, 1, 2]))
        self.assertEqual(blocks[0].values.tolist(), [[1.125, -0.25], [1.125, -0.5], [1.25, -0.25], [1.25, -0.5]])
        self.assertEqual(blocks[3].values.tolist(), [-1.5, 0.25, 42])

    def test_growing_by_every_character(self):
        text = dat_text(1) + dat_text(2)
        dat, found = frd.Dat(self.path), []
        for n in range(len(text) + 1):
            self.path.write_text(text[:n])
            found += dat.read(job_has_ended=False)
        found += dat.read()
        whole = frd.Dat(self.path).read()
        found, wanted = ([(b.name, b.time, b.values.tolist()) for b in blocks] for blocks in (found, whole))
        self.assertEqual(found, wanted)
        self.assertEqual(len(whole), 4)

    def bad(self, text, line, words):
        self.path.write_text(text)
        with self.assertRaises(frd.FormatError) as caught:
            frd.Dat(self.path).read()
        self.assertIn(f"job.dat:{line}: ", str(caught.exception))
        self.assertIn(words, str(caught.exception))

    def test_bad(self):
        text = dat_text(1)
        self.bad(text + dat_text(2)[:200], 17, "interrupted?")
        self.bad(text.replace(" internal state variables", " plastic strains"), 2, "expected 'internal state variables'")
        self.bad(text.replace("1.125000E+00 -5", "************ -5"), 5, "expected a number")
        self.bad(text.replace("         2   1", "         2   x"), 6, "expected a number")
        self.bad(text.replace(" -5.000000E-01\n         2", "\n         2"), 5, "as in the lines before")
        self.bad(text.rstrip("\n"), 11, "interrupted?")
        self.bad(text.replace("1.125000E+00 -5", "         NaN -5"), 5, "expected a finite number")
        self.bad(text.replace("time   1.0000000E+00", "time            NaN"), 2, "expected a time")
        self.path.write_text("\n")
        self.assertEqual(frd.Dat(self.path).read(), [])

    def test_ends_of_lines_of_two_characters(self):
        self.path.write_bytes(dat_text(1).replace("\n", "\r\n").encode())
        dat = frd.Dat(self.path)
        first = dat.read()
        with open(self.path, "ab") as f:
            f.write(dat_text(2).replace("\n", "\r\n").encode())
        self.assertEqual([(b.name, b.time) for b in first + dat.read()], [("SDV", 1), ("RF", 1), ("SDV", 2), ("RF", 2)])


def made_up_run(folder, case):
    """What a run leaves, without one: lambda_e = 1.05 + z / 10000, the stretch of 10 % uniform."""
    m = cylinder_mesh.mesh(case.size)
    gauss = history.GaussPoints(m, deck.tendon(case, m))
    state = np.ones((len(gauss.places), 5))
    state[:, deck.STATE.index("lambda_e")] = 1.05 + gauss.places[:, 2] / 1e4
    times = deck.output_times(case)
    printed = [frd.Print("SDV", "ALL", t, gauss.elements, gauss.numbers, state) for t in times]
    force = frd.Print("RF", "DISTAL", 1.0, np.empty(0), np.empty(0), np.array([0.0, 0, 99]))
    history.write(folder / "history.csv", [history.row(gauss, p, force) for p in printed])
    moved = m.nodes * [-0.05, -0.05, 0.1]
    np.savez(folder / "fields.npz", times=times, names=deck.STATE, displacement=[moved] * len(times),
             gauss=[state] * len(times), muscle=gauss.muscle)
    (folder / "case.json").write_text(json.dumps(case._asdict()))
    return m, gauss, state, moved


class History(Folder):
    def test_rows(self):
        case = deck.Case("tiny", ends="tendon", tendon_length=50)
        m, gauss, state, _ = made_up_run(self.folder, case)
        self.assertEqual((self.folder / "history.csv").read_text().splitlines()[0],
                         "time,reaction,lambda_e_max,lambda_e_mean,lambda_e_min,G_max,G_mean,G_min,x,y,z")
        h = history.read(self.folder / "history.csv")
        z = gauss.places[gauss.muscle, 2]
        self.assertTrue(z.min() > 40 and z.max() < 360)
        self.assertAlmostEqual(h["lambda_e_max"][0], 1.05 + z.max() / 1e4, places=6)
        self.assertAlmostEqual(h["lambda_e_min"][0], 1.05 + z.min() / 1e4, places=6)
        self.assertAlmostEqual(h["lambda_e_mean"][0], 1.07, places=6)
        self.assertAlmostEqual(h["z"][0], z.max(), places=3)
        means = gauss.element_means(state)[:, 1]
        centres = np.concatenate([m.nodes[cells].mean(axis=1) for cells in m.elements()])
        self.assertTrue(np.allclose(means, 1.05 + centres[:, 2] / 1e4, atol=1e-12))

    def test_damaged_results_are_named(self):
        """By all who read them: figures.py, studies.py and --resume."""
        figures, studies = importlib.import_module("figures"), importlib.import_module("studies")
        case = deck.Case("tiny", duration=7.0)
        made_up_run(self.folder, case)
        good = {name: (self.folder / name).read_bytes() for name in ("history.csv", "fields.npz", "case.json")}
        fields = dict(np.load(self.folder / "fields.npz"))
        states = fields["gauss"].copy()
        states[1, 3, 0] = np.nan

        def npz(**changed):
            np.savez(self.folder / "changed.npz", **{**fields, **changed})
            return (self.folder / "changed.npz").read_bytes()

        half = len(good["fields.npz"]) // 2
        flipped = bytearray(good["fields.npz"])
        flipped[half] ^= 1
        for name, content, words in (
                ("history.csv", good["history.csv"][:-20], "history.csv:3: "),
                ("history.csv", good["history.csv"].replace(b",1.07", b",nan", 1),
                 "history.csv:2: lambda_e_mean = 'nan': expected a finite"),
                ("history.csv", good["history.csv"].replace(b"G_max", b"G"), "history.csv:1: "),
                ("history.csv", b"\n".join(good["history.csv"].split(b"\n")[:2]) + b"\n", "end before day 7"),
                ("fields.npz", good["fields.npz"][:half], "fields.npz: is damaged or cut"),
                ("fields.npz", b"", "is damaged or cut"),
                ("fields.npz", bytes(flipped), "fields.npz: is damaged or cut"), ("fields.npz", b"text", "is damaged or cut"),
                ("fields.npz", npz(gauss=states), "fields.npz: gauss[1, 3, 0] = nan: expected a finite number"),
                ("fields.npz", npz(gauss=fields["gauss"][:, :5]), "fields.npz: gauss has shape (2, 5, 5): expected (2, 800, "),
                ("fields.npz", npz(times=[1.0, 5.0]), "end before day 7, the end of the run"),
                ("fields.npz", npz(times=np.array([None, 7.0])), "is damaged or cut"),
                ("case.json", good["case.json"][:-9], "case.json:1: column"),
                ("case.json", b"[]", "case.json: expected an object"),
                ("case.json", good["case.json"].replace(b'"pull"', b'"push"'), "case.json: pull is missing"),
                ("case.json", good["case.json"].replace(b"40.0", b"NaN"), "case.json: pull = nan: expected a finite number"),
                ("case.json", good["case.json"].replace(b"clamped", b"clamqed"),
                 "case.json: ends = 'clamqed': expected one of clamped"),
                ("case.json", good["case.json"].replace(b"tiny", b"edge x"), "mesh 'edge x': must be one of tiny, "),
                ("case.json", good["case.json"].replace(b"40.0", b'"far"'), "case.json: pull = 'far': expected a number")):
            for path, text in good.items():
                (self.folder / path).write_bytes(text)
            (self.folder / name).write_bytes(content)
            with self.assertRaises(files.FileError, msg=words) as caught:
                studies.Run(self.folder)
            self.assertIn(words, str(caught.exception))
        (self.folder / "case.json").write_bytes(good["case.json"])
        (self.folder / "fields.npz").write_bytes(good["fields.npz"][:half])
        done = subprocess.run([sys.executable, EXAMPLES / "figures.py", self.folder], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"figures.py: {self.folder}/fields.npz: is damaged or cut, or no .npz\n"))
        self.assertTrue(figures.NAMES and not any((self.folder / name).exists() for name in figures.NAMES))

    def test_another_print_is_refused(self):
        m = cylinder_mesh.mesh("tiny")
        gauss = history.GaussPoints(m, np.zeros(160, dtype=bool))
        good = frd.Print("SDV", "ALL", 1.0, gauss.elements, gauss.numbers, np.ones((800, 5)))
        gauss.check(good)
        for bad, words in ((good._replace(elements=gauss.elements[::-1]), "other Gauss points"),
                           (good._replace(values=np.ones((800, 8))), "8 state variables")):
            with self.assertRaisesRegex(ValueError, words):
                gauss.check(bad)


class Vtu(Folder):
    def test_what_is_written_is_read_back(self):
        import meshio
        vtu = importlib.import_module("vtu")

        case = deck.Case("tiny", fibre_angle=30)
        m, gauss, state, _ = made_up_run(self.folder, case)
        F = np.array([[0.95, 0, 0.02], [0, 0.95, 0], [0.0, 0, 1.1]])
        moved = m.nodes @ (F - np.eye(3)).T
        n = len(m.nodes)
        fields = {"DISP": moved, "STRESS": np.arange(6 * n).reshape(n, 6), "FORC": np.zeros((n, 3)),
                  "SDV": np.arange(5 * n).reshape(n, 5)}
        stiff = np.arange(160) < 5
        path = self.folder / "day_1.vtu"
        vtu.write_fields(path, m, fields, {"STRESS": vtu.STRESS}, gauss.element_means(state), stiff, deck.fibre(case))
        back = meshio.read(path)
        self.assertTrue(np.array_equal(back.points, m.nodes))
        self.assertEqual([c.type for c in back.cells], ["hexahedron", "wedge"])
        self.assertTrue(np.array_equal(back.cells[0].data, m.hexes) and np.array_equal(back.cells[1].data, m.wedges))
        self.assertEqual(set(back.point_data), {"displacement", "Cauchy_stress", "reaction", *deck.STATE})
        self.assertEqual(set(back.cell_data), {"fibre", "muscle", *(f"{name}_mean" for name in deck.STATE)})
        self.assertTrue(np.allclose(back.point_data["displacement"], moved, atol=1e-5))
        self.assertTrue(np.allclose(back.point_data["lambda"], fields["SDV"][:, 2]))
        direction = F @ [0.5, 0, math.sqrt(0.75)]
        self.assertTrue(np.allclose(np.concatenate(back.cell_data["fibre"]), direction / np.linalg.norm(direction), atol=1e-6))
        self.assertEqual(np.concatenate(back.cell_data["muscle"]).tolist(), (~stiff).astype(int).tolist())
        with self.assertRaisesRegex(ValueError, "components of the stress"):
            vtu.write_fields(path, m, fields, {"STRESS": ["S11"]}, state, stiff, deck.fibre(case))

        vtu.write_collection(self.folder / "all.pvd", [1, 42.5], [path, self.folder / "day_42.5.vtu"])
        import xml.etree.ElementTree
        sets = xml.etree.ElementTree.parse(self.folder / "all.pvd").getroot().findall("Collection/DataSet")
        self.assertEqual([(s.get("timestep"), s.get("file")) for s in sets], [("1", "day_1.vtu"), ("42.5", "day_42.5.vtu")])


class Figures(Folder):
    def test_all_sizes_and_ends(self):
        from PIL import Image
        figures = importlib.import_module("figures")
        for case in (deck.Case("medium"), deck.Case("tiny", ends="tendon", tendon_length=50, duration=7, fibre_angle=20),
                     deck.Case("paper", ends="free", duration=1)):
            made_up_run(self.folder, case)
            names = figures.draw(self.folder)
            self.assertEqual(names, ["fig1_mesh.png", "fig2_elastic_stretch.png", "fig3_sections.png",
                                     "fig4_sarcomere_number.png"])
            for name in names:
                self.assertLess((self.folder / name).stat().st_size, 200_000)
                with Image.open(self.folder / name) as picture:
                    self.assertEqual(picture.mode, "P")
                    self.assertGreater(min(picture.size), 300)

    def test_layers_have_the_values_of_their_gauss_points(self):
        figures = importlib.import_module("figures")
        m = cylinder_mesh.mesh("medium")
        places = history.GaussPoints(m, np.zeros(len(m.hexes) + len(m.wedges), dtype=bool)).places
        shown = figures.in_layers(m, 1 + 0.5 * places[:, 2])
        self.assertTrue(np.allclose(shown[:, 0], 1 + 0.5 * m.levels[:-1, None]))
        self.assertTrue(np.allclose(shown[:, 1], 1 + 0.5 * m.levels[1:, None]))
        # Where a node has quadrilaterals alone, what is linear in the disc is exact there.
        shown, disc = figures.in_layers(m, places[:, 0])[30, 0], len(m.proximal)
        plain = np.setdiff1d(m.hexes[:56, :4], m.wedges[:38, :3])
        self.assertTrue(len(plain) > 5 and plain.max() < disc)
        self.assertTrue(np.allclose(shown[plain], m.nodes[plain, 0], atol=1e-9))

    def test_section(self):
        figures = importlib.import_module("figures")
        for size in cylinder_mesh.SIZES:
            m = cylinder_mesh.mesh(size)
            places = figures.on_section(figures.section(m), m.nodes.reshape(len(m.levels), -1, 3))[0]
            self.assertTrue((np.diff(places[:, 0]) > 0).all())
            self.assertTrue(np.allclose(places[:, 1], 0, atol=1e-9))
            self.assertAlmostEqual(places[-1, 0], 10)
            self.assertLess(places[0, 0], -9.9)


FAKE_CCX = """#!/bin/sh
echo " *ERROR in myogrowth: PROPS(5) = 0.9: G_max must be > 1."
exit 201
"""


class Options(Folder):
    def setUp(self):
        super().setUp()
        self.ccx = self.folder / "ccx"
        self.ccx.write_text(FAKE_CCX)
        self.ccx.chmod(0o755)
        (self.folder / "libMYOGROWTH.so").touch()
        self.base = ["--size", "tiny", "--ccx", self.ccx, "--library-dir", self.folder, "--out", self.folder / "out"]

    def call(self, *options):
        return self.main("cylinder", *self.base, *options)

    def test_bad_options(self):
        for options, words in ((("--size", "huge"), "'huge'"), (("--ends", "glued"), "'glued'"),
                               (("--ramp", 0), "--ramp = 0.0: must be > 0"),
                               (("--ramp", "nan"), "--ramp = nan: must be finite"),
                               (("--duration", 0.5), "--duration = 0.5: must be >= --ramp = 1"),
                               (("--pull", -3), "--pull = -3.0: must be > 0 and <= 200"),
                               (("--fibre-angle", 90), "--fibre-angle = 90.0: must be >= 0 and < 90"),
                               (("--tau", 0), "--tau = 0.0: must be > 0"),
                               (("--tendon-stiffness", -1), "--tendon-stiffness = -1.0: must be > 0"),
                               (("--tendon-length", 0), "--tendon-length = 0.0: must be > 0 and < 200"),
                               (("--energy", 2), "--energy: invalid choice: 2 (choose from 0, 1)"),
                               (("--integration", 3), "--integration"), (("--threads", 0), "--threads = 0: must be > 0"),
                               (("--ccx", "/nowhere/ccx"), "--ccx = /nowhere/ccx: must be an executable file"),
                               (("--library-dir", "/nowhere"),
                                "--library-dir = /nowhere: must be a folder with libMYOGROWTH.so")):
            done = self.call(*options)
            self.assertEqual((done.returncode, done.stdout), (2, ""), options)
            self.assertIn(words, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_errors_of_ccx_are_shown(self):
        done = self.call()
        self.assertEqual(done.returncode, 1)
        self.assertIn("ccx ended with status 201", done.stderr)
        self.assertIn("PROPS(5) = 0.9: G_max must be > 1.", done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertFalse((self.folder / "out" / "history.csv").exists())

    def test_options_have_limits(self):
        for options, words in ((("--ramp", 1e-300), "--ramp = 1e-300: must be > 0, at least 0.0001 and at most 3650"),
                               (("--duration", 1e16), "--duration = 1e+16: must be <= 3650"),
                               (("--duration", "1e999"), "--duration = inf: must be finite"),
                               (("--duration", 1.0000001), "--duration = 1.0000001: must be --ramp = 1, or more than it by 0.1% at"),
                               (("--tau", 0.001, "--ramp", 2, "--duration", 2), "--ramp = 2.0: must be <= 1500 times --tau = 0.001"),
                               (("--tau", 1e-300), "--tau = 1e-300: must be >= 0.001 and <= 1e6"),
                               (("--tendon-stiffness", 1e300), "must be > 0 and <= 1e6"),
                               (("--threads", 40000), "--threads = 40000: must be > 0 and <= 256"),
                               (("--pull", "4O"), "argument --pull: invalid float value: '4O'"),
                               (("--pul1", 3), "unrecognized arguments: --pul1 3")):
            done = self.call(*options)
            self.assertEqual((done.returncode, done.stdout), (2, ""), options)
            self.assertIn(words, done.stderr)

    def test_ccx_is_killed(self):
        self.ccx.write_text("#!/bin/sh\necho step 3\nkill -9 $$\n")
        done = self.call()
        self.assertEqual((done.returncode, done.stderr), (1, "cylinder.py: ccx was killed by signal 9 (Killed); "
                                                             f"{self.folder}/out/ccx/leg0.log says:\nstep 3\n"))
        self.ccx.write_text("this is no program\n")
        done = self.call()
        self.assertEqual((done.returncode, done.stderr), (1, f"cylinder.py: {self.ccx}: Exec format error\n"))

    def test_where_nothing_can_be_written(self):
        """Before the work: ccx is not even started."""
        self.ccx.write_text(f"#!/bin/sh\ntouch {self.folder}/started\n")
        out = self.folder / "out"
        out.write_text("a file")
        done = self.call()
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"cylinder.py: {out}: cannot be made a folder: there is a file of that name\n"))
        done = subprocess.run([sys.executable, EXAMPLES / "cylinder.py", *self.base[:-1], self.folder / "full"],
                              capture_output=True, text=True, preexec_fn=no_room(8192))
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"cylinder.py: {self.folder}/full: cannot be written to: File too large\n"))
        done = self.call("--out", "/proc/nothing")
        self.assertEqual((done.returncode, done.stderr),
                         (1, "cylinder.py: /proc/nothing: cannot be written to: No such file or directory\n"))
        self.assertFalse((self.folder / "started").exists())

    def test_an_older_runs_results_are_not_left(self):
        out = self.folder / "out"
        out.mkdir()
        older = ["history.csv", "fields.npz", "cylinder.pvd", "day_7.vtu", "fig1_mesh.png", "fig4_sarcomere_number.png"]
        for name in [*older, "notes.txt"]:
            (out / name).write_text("older")
        self.assertEqual(self.call().returncode, 1)
        self.assertEqual([name for name in older if (out / name).exists()], [])
        self.assertTrue((out / "notes.txt").exists())

    def test_two_at_once(self):
        self.ccx.write_text("#!/bin/sh\nsleep 20\n")
        first = subprocess.Popen([sys.executable, EXAMPLES / "cylinder.py", *self.base], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL)
        while not (self.folder / "out" / "ccx" / "leg0.log").exists():
            time.sleep(0.05)
        done = self.call()
        first.terminate()
        first.wait()
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"cylinder.py: {self.folder}/out/ccx: another run is at work there\n"))

    def test_kept_runs_of_studies(self):
        """Damaged or another's: named before anything is run."""
        studies = importlib.import_module("studies")
        out = self.folder / "out"
        (out / "coarse").mkdir(parents=True)
        for text, words in (("{", "coarse/case.json:1: column 2: is damaged or no JSON"),
                            ("{}", "coarse/case.json: size is missing")):
            (out / "coarse" / "case.json").write_text(text)
            done = self.main("studies", *self.base[2:])
            self.assertEqual(done.returncode, 1)
            self.assertIn(words, done.stderr)
        (out / "coarse" / "case.json").write_text(json.dumps(deck.Case()._asdict()))
        (out / "coarse" / "fields.npz").write_text("cut")
        (out / "tables.md").write_text("older")
        page = self.folder / "page.md"
        page.write_text("no marks")
        paper = self.folder / "paper"
        paper.mkdir()
        (paper / "case.json").write_text(json.dumps(deck.Case("paper", ramp=2.0)._asdict()))
        for options, status, words in (((), 1, "coarse/"), (("--jobs", "0"), 2, "--jobs: 0: must be"),
                                       (("--jobs", "nan"), 2, "must be a whole number"),
                                       (("--write", page), 1, "page.md: no section between"),
                                       (("--paper", paper), 1, f"--paper {paper}: the run there has ramp = 2.0, not 1.0"),
                                       (("--paper", self.folder / "none"), 1, "none/case.json: No such file or directory")):
            done = self.main("studies", *self.base[2:], *options)
            self.assertEqual(done.returncode, status, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertFalse((out / "tables.md").exists() and status == 1)
        self.assertEqual(sorted(p.name for p in out.iterdir()), ["coarse"])
        job = studies.Job("coarse", deck.Case(pull=36.0), out / "coarse", self.ccx, self.folder)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            self.assertFalse(studies.is_done(job))
        self.assertIn("the run there has pull = 40.0, not 36.0: it is made anew", said.getvalue())

    def test_kept_runs_of_another_library(self):
        studies, case = importlib.import_module("studies"), deck.Case("tiny", duration=7.0)
        kept_run = self.folder / "out" / "one"
        kept_run.mkdir(parents=True)
        made_up_run(kept_run, case)
        a = types.SimpleNamespace(out=self.folder / "out", ccx=self.ccx, library_dir=self.folder, jobs=1)
        programs = kept.programs(self.ccx, self.folder / "libMYOGROWTH.so")
        for made_with, words in ((programs, ""), ({**programs, "libMYOGROWTH.so": "older"},
                                                  "warning: made with another ccx or libMYOGROWTH.so: one. Remove")):
            kept.write_programs(kept_run, made_with)
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
                self.assertEqual(studies.do_all(a, {"one": case}), {"one": kept_run})
            self.assertEqual(said.getvalue()[:len(words) or None], words)

    def test_a_worker_of_studies_is_killed(self):
        """As a machine without memory left does it: the pool alone would wait for ever."""
        studies = importlib.import_module("studies")
        self.ccx.write_text("#!/bin/sh\nkill -9 $PPID\n")
        a = types.SimpleNamespace(out=self.folder / "out", ccx=self.ccx, library_dir=self.folder, jobs=1)
        with contextlib.redirect_stdout(io.StringIO()), self.assertRaisesRegex(files.FileError, "ended from outside"):
            studies.do_all(a, {"one": deck.Case("tiny", duration=1.0)})

    def test_a_ccx_that_is_none(self):
        """build_ccx.sh, which all jobs with CalculiX ask for their ccx."""
        def ask(**environment):
            return subprocess.run([EXAMPLES / "build_ccx.sh"], env={"PATH": os.environ["PATH"], **environment},
                                  capture_output=True, text=True)

        cache = self.folder / "myogrowth"
        cache.mkdir()
        kept_ccx = cache / "ccx"
        kept_ccx.write_text("cut")
        kept_ccx.chmod(0o755)
        for environment, words in (({"XDG_CACHE_HOME": str(self.folder)}, f"{kept_ccx} does not start: remove it"),
                                   ({"MYOGROWTH_CCX": str(self.folder)}, f"MYOGROWTH_CCX={self.folder} is not an executable file"),
                                   ({"MYOGROWTH_CCX": "/nowhere"}, "MYOGROWTH_CCX=/nowhere is not an executable file")):
            done = ask(**environment)
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn(words, done.stderr)
        kept_ccx.write_text("#!/bin/sh\necho This is Version 2.20\nexit 201\n")
        self.assertEqual(ask(XDG_CACHE_HOME=str(self.folder)).stdout, f"{kept_ccx}\n")

    def test_no_results(self):
        self.ccx.write_text("#!/bin/sh\necho nothing to do\n")
        done = self.call()
        self.assertEqual(done.returncode, 1)
        self.assertIn("ccx printed no results", done.stderr)
        self.assertIn("nothing to do", done.stderr)

    def test_resume_without_a_run_or_of_another(self):
        done = self.call("--resume")
        self.assertEqual(done.returncode, 1)
        self.assertIn("--resume: there is no run in", done.stderr)
        self.call()
        done = self.call("--resume", "--ramp", 2)
        self.assertEqual(done.returncode, 1)
        self.assertIn("has ramp = 1.0, not 2.0", done.stderr)

    def test_too_thin_a_tendon(self):
        done = self.call("--ends", "tendon", "--tendon-length", 10)
        self.assertEqual(done.returncode, 1)
        self.assertIn("--tendon-length = 10: must be more than half the height of the first layer, 40 mm", done.stderr)


class Studies(Folder):
    @classmethod
    def setUpClass(cls):
        cls.studies = importlib.import_module("studies")

    def test_edge_meshes(self):
        for edge, interface in ((2.0, 0.0), (0.2, 0.0), (0.2, 20.0)):
            m = self.studies.mesh_of(f"edge {edge:g}" + (f" at {interface:g}" if interface else ""))
            volumes = np.concatenate([elements.gauss_points(m.nodes, cells)[1].ravel() for cells in m.elements()])
            self.assertTrue((volumes > 0).all())
            self.assertAlmostEqual(volumes.sum(), 6 * 10**2 * math.sin(math.pi / 6) * 400, delta=1e-6 * 120000)
            k = int(np.argmin(np.abs(m.levels - interface)))
            self.assertAlmostEqual(m.levels[k], interface, delta=1e-9)
            self.assertAlmostEqual(m.levels[k + 1] - m.levels[k], edge, delta=1e-9)
            self.assertTrue(np.allclose(m.levels + m.levels[::-1], 400))
            radii = np.unique(np.hypot(*m.nodes[m.proximal, :2].T).round(9))
            self.assertAlmostEqual(radii[-1] - radii[-2], edge, delta=1e-6)

    def test_references(self):
        # Ramp of two tau, then held; and Williams's exponent, by its equation.
        values = self.studies.at_a_point([1.0, 2.0, 4.0, 6.0, 14.0, 42.0])
        for value, known in zip(values, (1.06301, 1.04078, 1.02867, 1.02386, 1.01698, 1.01213)):
            self.assertAlmostEqual(value, known, delta=1e-5)
        self.assertAlmostEqual(self.studies.peak_at_a_point(7.0, 3.5)[0], 1.06301, delta=1e-5)
        e = 1 + self.studies.clamped_free_exponent()
        self.assertAlmostEqual(math.sin(e * math.pi / 2)**2, 2.4**2 / 5.6 - e**2 / 1.4, delta=1e-9)

    def test_all_names_are_folders_and_all_meshes_can_be_made(self):
        cases = self.studies.runs()
        self.assertEqual(len({name.replace(" ", "_").replace(",", "") for name in cases}), len(cases))
        for size in {case.size for case in cases.values()}:
            self.studies.mesh_of(size)

    def test_a_run_read_back(self):
        made_up_run(self.folder, deck.Case("tiny"))
        r = self.studies.Run(self.folder)
        self.assertEqual(r.days, [1, 7, 14, 28, 42])
        self.assertEqual(len(r.z), len(r.field("G", 42.0)))
        self.assertEqual(set(np.round(np.minimum(r.z, 400 - r.z)[r.first_layer], 3)), {8.453, 31.547})
        self.assertTrue(math.isnan(r.at("lambda_e_max", 3.25)))

    def test_tables_are_written_between_their_marks(self):
        path = self.folder / "report.md"
        path.write_text(f"before\n{self.studies.BEGIN}old\n{self.studies.END}after\n")
        self.studies.write_between_marks(path, "| new |\n")
        self.assertEqual(path.read_text(), f"before\n{self.studies.BEGIN}| new |\n{self.studies.END}after\n")
        path.write_text("nothing\n")
        with self.assertRaisesRegex(ValueError, "no section between"):
            self.studies.write_between_marks(path, "")


@unittest.skipUnless(HAS_CCX, "no ccx that loads libraries, or no libMYOGROWTH.so")
class Readme(Folder):
    def test_its_deck_is_the_exact_solution(self):
        text = (EXAMPLES / "README.md").read_text(encoding="utf-8")
        (self.folder / "cube.inp").write_text(re.search(r"^```\n(\*\* cube\.inp.*?)^```$", text, re.M | re.S)[1])
        subprocess.run([CCX, "cube"], cwd=self.folder, check=True, capture_output=True,
                       env={**os.environ, "LD_LIBRARY_PATH": str(pathlib.Path(LIBRARY_DIR).resolve())})
        prints = [b for b in frd.Dat(self.folder / "cube.dat").read() if b.name == "SDV"]
        for day, exact in ((1, 1.063012), (42, 1.012127)):  # of eq. 4, by Runge and Kutta's method
            values = next(b for b in prints if b.time == day).values
            self.assertEqual(values.shape, (8, 8))
            for lambda_e in values[:, 1]:
                self.assertAlmostEqual(lambda_e, exact, delta=2e-4)
        self.assertIn("λe = 1.0121", text)


@unittest.skipUnless(HAS_CCX, "no ccx that loads libraries, or no libMYOGROWTH.so")
class Job(Folder):
    @staticmethod
    def options(out, *options, ccx=CCX):
        return ["--size", "tiny", "--ccx", ccx, "--library-dir", LIBRARY_DIR, "--out", out, "--threads", "1", *map(str, options)]

    def command(self, out, *options):
        return [sys.executable, EXAMPLES / "cylinder.py", *self.options(out, *options)]

    def run_job(self, name, *options):
        done = subprocess.run(self.command(self.folder / name, *options), capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout, self.folder / name

    def test_whole_job(self):
        import meshio

        said, out = self.run_job("run", "--duration", 14)
        self.assertIn("80 C3D8 and 80 C3D6", said)
        self.assertIn("100 %", said)
        for name in ("history.csv", "cylinder.pvd", "day_1.vtu", "day_7.vtu", "day_14.vtu", "fields.npz", "fig1_mesh.png",
                     "fig3_sections.png"):
            self.assertTrue((out / name).is_file(), name)
        h = history.read(out / "history.csv")
        self.assertTrue((np.diff(h["time"]) > 0).all())
        self.assertTrue({1.0, 7.0, 14.0} <= set(h["time"]))
        self.assertTrue((h["lambda_e_min"] <= h["lambda_e_mean"]).all() and (h["lambda_e_mean"] <= h["lambda_e_max"]).all())
        self.assertTrue((np.diff(h["G_min"]) >= 0).all())

        # Fibre stretch is the total one over G, and the force is that of the Cauchy stress on the section half way.
        fields = np.load(out / "fields.npz")
        G, lambda_e, stretch, J, Je = fields["gauss"][-1].T
        self.assertTrue(np.allclose(G * lambda_e, stretch, rtol=2e-6) and np.allclose(J, G * Je, rtol=2e-6))
        m = cylinder_mesh.mesh("tiny")
        last = frd.read_frd(out / "ccx" / "leg2.frd").steps[-1]
        self.assertEqual(last.time, 14)
        self.assertTrue(np.allclose(last.fields["FORC"][m.distal, 2].sum(), h["reaction"][-1], rtol=1e-4))
        middle = slice(5 * len(m.proximal), 6 * len(m.proximal))
        x, y, _ = (m.nodes + last.fields["DISP"])[middle].T
        area = 12 / 2 * np.hypot(x, y).max() ** 2 * math.sin(2 * math.pi / 12)
        self.assertAlmostEqual(last.fields["STRESS"][middle, 2].mean() * area / h["reaction"][-1], 1, delta=2e-3)

        # The .frd's values in the nodes lie about those of the Gauss points; VTU has both.
        back = meshio.read(out / "day_14.vtu")
        means = np.concatenate(back.cell_data["lambda_e_mean"])
        self.assertAlmostEqual(means.mean(), back.point_data["lambda_e"].mean(), delta=1e-3)
        self.assertTrue(h["lambda_e_min"][-1] <= means.min() and means.max() <= h["lambda_e_max"][-1])

    def test_free_ends_are_the_law_of_one_point(self):
        # With free ends the stretch is 10 % everywhere: eq. 4 by backward Euler, by bisection, at the times of the history.
        _, out = self.run_job("run", "--ends", "free", "--integration", 0, "--duration", 7)
        h = history.read(out / "history.csv")
        G, t_last = 1.0, 0.0
        for t, mean in zip(h["time"], h["G_mean"]):
            stretch, low, high = 1 + 0.1 * min(t, 1.0), G, 1.1
            for _ in range(60):
                x = (low + high) / 2
                rate = (max(1.1 - x, 0) / 0.1) ** 2 / 0.5 * max(stretch / x - 1.01, 0)
                low, high = (x, high) if G + (t - t_last) * rate > x else (low, x)
            G, t_last = low, t
            self.assertAlmostEqual(mean, G, delta=1e-5)

    def test_second_order_is_near_the_exact_solution(self):
        _, out = self.run_job("run", "--ends", "free", "--integration", 1, "--duration", 14)
        h = history.read(out / "history.csv")
        for day, exact in ((1, 1.063012), (7, 1.022328), (14, 1.016979)):  # of eq. 4, by Runge and Kutta's method
            self.assertAlmostEqual(h["lambda_e_mean"][h["time"] == day][0], exact, delta=1e-4)

    def test_legs_are_the_same_as_one_job(self):
        case = deck.Case("tiny", duration=7)
        m = cylinder_mesh.mesh("tiny")
        whole = deck.leg(case, m, 0) + deck.leg(case, m, 1).replace("*RESTART, READ\n", "")
        (self.folder / "whole.inp").write_text(whole)
        subprocess.run([CCX, "whole"], cwd=self.folder, check=True, capture_output=True,
                       env={**os.environ, "LD_LIBRARY_PATH": LIBRARY_DIR, "OMP_NUM_THREADS": "1"})
        _, out = self.run_job("run", "--duration", 7)
        h = history.read(out / "history.csv")
        blocks = frd.Dat(self.folder / "whole.dat").read()
        self.assertEqual([b.time for b in blocks if b.name == "RF"], h["time"].tolist())
        self.assertEqual([float(f"{b.values[2]:.7g}") for b in blocks if b.name == "RF"], h["reaction"].tolist())
        self.assertTrue(np.array_equal([b for b in blocks if b.name == "SDV"][-1].values.astype(np.float32),
                                       np.load(out / "fields.npz")["gauss"][-1]))

    def test_interrupted_and_resumed(self):
        out = self.folder / "stopped"
        job = subprocess.Popen(self.command(out, "--duration", 14), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)
        while not (out / "ccx" / "leg0.npz").exists():
            time.sleep(0.05)
        time.sleep(0.2)
        job.send_signal(signal.SIGINT)
        _, error = job.communicate(timeout=60)
        self.assertEqual(job.returncode, 130, error)
        self.assertIn("the same command with --resume", error)
        self.assertNotIn("Traceback", error)
        shutil.copy(out / "ccx" / "leg0.npz", self.folder / "kept.npz")
        self.run_job("stopped", "--duration", 14, "--resume")
        _, straight = self.run_job("straight", "--duration", 14)
        self.assertEqual((out / "history.csv").read_text(), (straight / "history.csv").read_text())
        self.assertEqual((out / "ccx" / "leg0.npz").read_bytes(), (self.folder / "kept.npz").read_bytes())

    def test_runs_of_studies(self):
        studies = importlib.import_module("studies")
        a = types.SimpleNamespace(out=self.folder, ccx=pathlib.Path(CCX), library_dir=pathlib.Path(LIBRARY_DIR), jobs=2)
        cases = {"one": deck.Case("tiny", duration=1.0), "two, at 20": deck.Case("tiny", duration=1.0, fibre_angle=20.0)}
        with contextlib.redirect_stdout(io.StringIO()) as said:
            found = studies.do_all(a, cases)
            means = [studies.Run(folder).at("lambda_e_mean", 1.0) for folder in found.values()]
            times = [(folder / "fields.npz").stat().st_mtime_ns for folder in found.values()]
            self.assertEqual(studies.do_all(a, cases), found)
        self.assertIn("2 runs, 0 of them kept", said.getvalue())
        self.assertIn("2 runs, 2 of them kept", said.getvalue())
        self.assertGreater(means[0], means[1] + 0.001)
        self.assertEqual([(folder / "fields.npz").stat().st_mtime_ns for folder in found.values()], times)

    def test_what_ccx_did_not_write(self):
        """A disk that is full, a file that is cut: ccx ends with status 0, and its job is not taken for done."""
        spoiled, good = self.folder / "ccx", self.folder / "good"
        for harm, words in (("truncate -s -3000 leg0.frd", "leg0.frd:"), ("truncate -s -300 leg0.dat", "leg0.dat:"),
                            ("sed -i '/STRESS/,$d' leg0.frd", "leg0.frd:"), ("rm leg0.frd", "leg0.frd: No such file"),
                            ("sed -i 's/ 0.1000000E+01/ 0.9500000E+00/' leg0.dat", "leg0.dat ends on day 0.95, not on day 1;"),
                            ("rm leg0.dat", "ccx printed no results"), ("rm leg0.rout", "leg0.rout: No such file"),
                            (r"sed -i 's/ 1\.[0-9]\{6\}E+00/          NaN/' leg0.dat", "expected a finite number")):
            spoiled.write_text(f"#!/bin/sh\nif ! [ -d {good} ]; then {CCX} \"$1\" || exit; mkdir {good}; cp leg0.* {good}; fi\n"
                               f"mkdir harmed; cp {good}/leg0.[dfr]* harmed; cd harmed; {harm}; mv leg0.* ..; rmdir ../harmed\n")
            spoiled.chmod(0o755)
            done = self.main("cylinder", *self.options(self.folder / "run", "--duration", 7, ccx=spoiled))
            self.assertEqual(done.returncode, 1, harm)
            self.assertIn(words, done.stderr, harm)
            self.assertFalse((self.folder / "run" / "ccx" / "leg0.npz").exists(), harm)

    def test_damaged_files_are_named_on_resume(self):
        _, out = self.run_job("whole", "--duration", 7)
        history_csv = (out / "history.csv").read_text()

        def resumed(harm, *options):
            harmed = self.folder / "harmed"
            shutil.rmtree(harmed, ignore_errors=True)
            shutil.copytree(out, harmed)
            harm(harmed / "ccx")
            return self.main("cylinder", *self.options(harmed, "--duration", 7, "--resume", *options))

        def cut(path):
            path.write_bytes(path.read_bytes()[:-100])

        def flip(path, at):
            content = bytearray(path.read_bytes())
            content[at] ^= 1
            path.write_bytes(content)

        def rewrite(path, **changed):
            np.savez(path, **{**np.load(path), **changed})

        last = dict(np.load(out / "ccx" / "leg1.npz"))
        not_a_number = last["rows"].copy()
        not_a_number[2, 1] = np.nan
        for harm, words in ((lambda ccx: cut(ccx / "leg0.npz"), "leg0.npz: is damaged or cut"),
                            (lambda ccx: flip(ccx / "leg0.npz", 5000), "leg0.npz: is damaged or cut"),
                            (lambda ccx: rewrite(ccx / "leg1.npz", rows=not_a_number), "leg1.npz: rows[2, 1] = nan"),
                            (lambda ccx: rewrite(ccx / "leg1.npz", rows=last["rows"][:-1]), "leg1.npz: ends on day "),
                            (lambda ccx: rewrite(ccx / "leg1.npz", state=last["state"][:, :2]),
                             "leg1.npz: state has shape (800, 2)"),
                            (lambda ccx: rewrite(ccx / "leg1.npz", digests=["x", *last["digests"][1:]]),
                             "made with another deck"),
                            (lambda ccx: cut(ccx / "leg1.frd"), "leg1.frd: is cut, or not the one that this run wrote"),
                            (lambda ccx: flip(ccx / "leg1.frd", 5000), "leg1.frd: is cut, or not the one"),
                            (lambda ccx: (ccx / "leg0.frd").unlink(), "leg0.frd: No such file"),
                            (lambda ccx: (ccx / "leg1.npz").unlink(), "leg1.rin: No such file"),
                            (lambda ccx: ((ccx / "leg1.npz").unlink(), (ccx / "leg1.rin").write_text("x")),
                             "leg1.rin: is cut, or not"),
                            (lambda ccx: cut(ccx.parent / "case.json"), "case.json:")):
            done = resumed(harm)
            self.assertEqual(done.returncode, 1, words)
            self.assertIn(words, done.stderr)
        done = resumed(lambda ccx: None, "--pull", 36)
        self.assertIn("has pull = 40.0, not 36.0", done.stderr)
        done = resumed(lambda ccx: None)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual((self.folder / "harmed" / "history.csv").read_text(), history_csv)
        done = resumed(lambda ccx: (ccx.parent / "programs.json").write_text('{"ccx": "another"}'))
        self.assertEqual(done.returncode, 0)
        self.assertEqual(done.stderr.count("is not the one that this run was begun with"), 2)

    def test_ends_and_options(self):
        peaks = {}
        for name, options in (("free", ["--ends", "free"]), ("tendon", ["--ends", "tendon", "--tendon-length", 50]),
                              ("tilted", ["--fibre-angle", 20]), ("first", ["--integration", 0]), ("energy", ["--energy", 1])):
            _, out = self.run_job(name, "--duration", 1, *options)
            with open(out / "history.csv") as f:
                peaks[name] = {k: float(v) for k, v in list(csv.DictReader(f))[-1].items()}
            if name == "free":  # uniaxial tension: all points are alike, and the sides become thinner alike
                fields = np.load(out / "fields.npz")
                self.assertLess(np.ptp(fields["gauss"][-1][:, 1]), 3e-5)
                m = cylinder_mesh.mesh("tiny")
                rim = np.isclose(np.hypot(m.nodes[:, 0], m.nodes[:, 1]), 10)
                inward = np.einsum("ni,ni->n", fields["displacement"][-1][rim, :2], m.nodes[rim, :2]) / 10
                self.assertLess(np.ptp(inward), 1e-4)
                self.assertLess(inward.max(), -0.1)
            if name == "tendon":
                fields = np.load(out / "fields.npz")
                self.assertTrue((fields["gauss"][-1][~fields["muscle"], 0] == 1).all())
                self.assertLess(fields["gauss"][-1][~fields["muscle"], 1].max(), 1.01)
        self.assertGreater(peaks["tendon"]["lambda_e_mean"], peaks["free"]["lambda_e_mean"])
        self.assertLess(peaks["tilted"]["lambda_e_mean"], peaks["free"]["lambda_e_mean"])
        self.assertNotEqual(peaks["first"]["reaction"], peaks["energy"]["reaction"])


@unittest.skipUnless(HAS_CCX, "no ccx that loads libraries, or no libMYOGROWTH.so")
class Coarse(Folder):
    """The README's command to its end: `./run cylinder`, six weeks on the coarse mesh."""

    # Of this command with ccx 2.20 and SPOOLES, one thread. The time steps are wrong by about 4e-5 in lambda_e (below), and
    # another ccx or solver may choose others: hence 1e-4 for lambda_e and G. Late, the force goes with lambda_e - 1, which is
    # 0.012 on day 42: 1 % of it.
    PEAK = {"time": 1.0, "lambda_e_max": 1.06630, "lambda_e_mean": 1.06309, "lambda_e_min": 1.03634, "G_mean": 1.03473}
    END = {"time": 42.0, "lambda_e_max": 1.01323, "lambda_e_mean": 1.01220, "lambda_e_min": 1.00785, "G_max": 1.08853,
           "G_mean": 1.08675, "G_min": 1.06150}
    FORCES = {1.0: 202.34, 7.0: 71.35, 14.0: 54.28, 42.0: 38.83}  # mN

    def test_six_weeks(self):
        out = self.folder / "run"
        done = subprocess.run([sys.executable, EXAMPLES / "cylinder.py", "--ccx", CCX, "--library-dir", LIBRARY_DIR, "--out", out],
                              capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        h = history.read(out / "history.csv")
        peak = int(np.argmax(h["lambda_e_max"]))
        for row, wanted in ((peak, self.PEAK), (-1, self.END)):
            for name, value in wanted.items():
                self.assertAlmostEqual(h[name][row], value, delta=1e-4, msg=name)
        for day, force in self.FORCES.items():
            self.assertAlmostEqual(h["reaction"][h["time"] == day][0] / force, 1, delta=0.01)
        # The peak lies on the axis, half a diameter from one of the clamps.
        self.assertLess(math.hypot(h["x"][peak], h["y"][peak]), 1)
        self.assertAlmostEqual(min(h["z"][peak], 400 - h["z"][peak]), 10.5, delta=2.5)

        fields = np.load(out / "fields.npz")
        z = fields["place"][:, 2]
        middle = np.abs(z - 200) < np.abs(z - 200).min() + 0.01
        worst = [0.0, 0.0]
        for day, state in zip(fields["times"].tolist(), fields["gauss"].astype(float)):
            # Both ends are alike: the state is the same at z and 400 - z.
            values = [np.sort(state[np.abs(z - at) < 1e-3, 1]) for at in (z.min(), z.max())]
            self.assertTrue(np.allclose(*values, rtol=0, atol=2e-5))
            # Half way along the muscle is in uniaxial tension: eq. 4 at its stretch, and the force by hand.
            self.assertLess(np.ptp(state[middle, 1]), 1e-5)
            G, lambda_e, stretch = state[middle, :3].mean(axis=0)
            worst[0] = max(worst[0], abs(lambda_e - stretch / self.exact_G(stretch, day)))
            low, high = 0.8, 1.1  # for the stretch of the sides, which are free
            for _ in range(60):
                side = (low + high) / 2
                sideways = 16 * math.log(stretch * side**2 / G) + 4 * (side**2 - 1)
                low, high = (side, high) if sideways < 0 else (low, side)
            area = 24 / 2 * 10**2 * math.sin(2 * math.pi / 24)
            force = area / stretch * (16 * math.log(stretch * side**2 / G) + 4 * (lambda_e**2 - 1))
            worst[1] = max(worst[1], abs(h["reaction"][h["time"] == day][0] / force - 1))
        print(f"half way along, from eq. 4 and from the stress by hand: lambda_e {worst[0]:.1e}, force {worst[1]:.1e} of itself")
        self.assertLess(worst[0], 1e-4)
        self.assertLess(worst[1], 5e-4)

    @staticmethod
    def exact_G(stretch, day):
        """Eq. 4 with a ramp of a day to the stretch, by Runge and Kutta's method."""
        def rate(t, G):
            return ((1.1 - G) / 0.1)**2 / 0.5 * max((1 + (stretch - 1) * min(t, 1)) / G - 1.01, 0)

        G, t, step = 1.0, 0.0, 0.01
        while t < day - step / 2:
            k1 = rate(t, G)
            k2 = rate(t + step / 2, G + step / 2 * k1)
            k3 = rate(t + step / 2, G + step / 2 * k2)
            G += step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(t + step, G + step * k3))
            t += step
        return G


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
