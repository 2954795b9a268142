"""Decks of --export: CalculiX runs them and has the solver's answer; Abaqus's is checked as text.

test_export.py SOURCE CCX LIBRARY_FOLDER PROGRAM [unittest arguments]; every class is a ctest. Status 77: no CCX or no
PROGRAM (deal.II's), for the class CalculiX.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SOURCE = pathlib.Path(sys.argv[1]).resolve()
CCX, LIBRARIES, PROGRAM = sys.argv[2], pathlib.Path(sys.argv[3]).resolve(), sys.argv[4]
sys.path += [str(SOURCE / "examples" / "calculix"), str(SOURCE / "tests" / "muscle")]
sys.path.insert(0, str(SOURCE / "examples" / "muscle"))
import entries  # noqa: E402
import export  # noqa: E402
import fibres  # noqa: E402
import figures  # noqa: E402
import frd  # noqa: E402
import mesh as meshes  # noqa: E402
from shared import files  # noqa: E402

from test_mesh import Bar  # noqa: E402

MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
       "OMPI_MCA_hwloc_base_binding_policy": "none", "OMP_NUM_THREADS": "1"}
STEPS = ["Time/Steps=fixed", "Time/Step=0.125", "Time/End=1.5", "Output/Times=1"]


def spindle(kind, n=6):
    """A bar that is thinner at its ends, and bent."""
    bar = Bar(kind, n)
    bar.X = [(3 * (x - 0.5) * (1.2 - 0.02 * (z - 3)**2) + 0.05 * z * z, 3 * (y - 0.5) * (1.2 - 0.03 * (z - 3)**2), 4 * z)
             for x, y, z in bar.X]
    return bar


def shape_functions(kind, at):
    """(points, corners) of the straight element."""
    if kind == "hex8":
        return np.prod(1 + at[:, None, :] * meshes._HEX, axis=2) / 8
    L = np.column_stack([1 - at[:, :2].sum(axis=1) - (at[:, 2] if kind[:3] == "tet" else 0), at[:, :2]])
    return np.column_stack([L, at[:, 2]]) if kind[:3] == "tet" else np.hstack([L * (1 - at[:, 2:]) / 2, L * (1 + at[:, 2:]) / 2])


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def mesh(self, bar):
        path = self.folder / "bar.inp"
        path.write_text(bar.deck())
        return meshes.checked(meshes.read_raw(path), "mm")

    def write(self, code, mesh, *given):
        told = entries.read(SOURCE / "examples" / "muscle" / "muscle.prm")
        return export.write(code, mesh, entries.override(told, given), self.folder)[0]


class CalculiX(Case):
    def setUp(self):
        super().setUp()
        if not (CCX and os.access(CCX, os.X_OK) and PROGRAM):
            print(f"skipped: no ccx at '{CCX}', or no deal.II program")
            self.skipTest("no ccx or no solver")

    def ccx(self, deck):
        """{time: ({element: lambda_e, mean over its points}, {set: force})}"""
        environment = {**os.environ, "LD_LIBRARY_PATH": str(LIBRARIES), "OMP_NUM_THREADS": "1"}
        run = subprocess.run([CCX, deck.stem], cwd=deck.parent, env=environment, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stdout[-3000:])
        found = {}
        for p in frd.Dat(deck.with_suffix(".dat")).read(True):
            lambda_e, force = found.setdefault(p.time, ({}, {}))
            if p.name == "SDV":
                for number in np.unique(p.elements):
                    lambda_e[number] = p.values[p.elements == number, 1]
            else:
                force[p.set] = p.values
        return found

    def solver(self, mesh, *given):
        files.write_text(self.folder / "m.mesh", meshes.neutral(mesh))
        run = subprocess.run(["mpirun", "-n", "1", PROGRAM, SOURCE / "examples/muscle/muscle.prm", f"Mesh/File={self.folder}/m.mesh",
                              f"Output/Folder={self.folder}/out", *given], env={**os.environ, **MPI}, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stdout[-2000:] + run.stderr)
        return self.folder / "out"

    def test_same_answer(self):
        """lambda_e of each element to 1e-5, the force to 1e-4."""
        for kind in ("tet4", "tet10", "hex8", "wedge6"):
            mesh = self.mesh(spindle(kind))
            deck = self.write("calculix", mesh, *STEPS)
            there = self.ccx(deck)
            out = self.solver(mesh, *STEPS)
            found = figures.fields_of(out)
            forces = {(float(t), name): np.array([float(x) for x in f]) for _, (t, name, *f, _) in files.rows(
                out / "attachments.csv", ["time", "attachment", "force_x", "force_y", "force_z", "force_along_line"])}
            for day, pieces in found.items():
                fields = figures.Fields(mesh, pieces)
                lambda_e, force = there[day]
                _, weights = zip(*[(k, w) for k, (_, w) in fibres._gradients(mesh).items()])
                mean = np.array([np.average(lambda_e[number], weights=w) for number, w in zip(mesh.cell_labels, weights[0])])
                worst = np.abs(mean - fields.lambda_e).max()
                apart = np.abs(force["DISTAL"] - forces[day, "DISTAL"]).max() / np.abs(force["DISTAL"]).max()
                print(f"{kind} day {day:g}: lambda_e {fields.lambda_e.min():.4f} to {fields.lambda_e.max():.4f}, differs by {worst:.1e}, "
                      f"the force by {apart:.1e}")
                self.assertGreater(np.ptp(fields.lambda_e), 0.005)
                self.assertLess(worst, 1e-5)
                self.assertLess(apart, 1e-4)


class Motion(Case):
    """Of the mesh file: a rigid one changes nothing to 1e-9, seven digits nothing to 1e-5."""

    def setUp(self):
        super().setUp()
        if not PROGRAM:
            print("skipped: no deal.II program")
            self.skipTest("no solver")

    solver = CalculiX.solver

    def test_motion(self):
        bar = spindle("tet4")
        a, b = 0.6, -1.1
        R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ \
            np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
        still = np.array(bar.X)
        moved = still @ R.T + (400, 300, -500)
        found = []
        for X in (still, moved, np.array([[float(f"{c:.7g}") for c in x] for x in moved])):
            bar.X = [tuple(x) for x in X.tolist()]
            out = self.solver(self.mesh(bar), *STEPS, "Solver/Newton tolerance=1e-11")
            found.append(figures.read_regions(out / "regions.csv")["all"])
        figures.draw(self.mesh(bar), out, 1.0, out)
        for name in (*figures.NAMES, "against.png"):
            self.assertGreater((out / name).stat().st_size, 3000)
        rows = files.read_columns(out / "hot_volume.csv", figures.HOT)
        self.assertEqual(rows["time"], [1.0, 1.5])
        self.assertAlmostEqual(rows["lambda_e_from"][0], found[0]["lambda_e_p99"][found[0]["time"] == 1.0][0], delta=2e-3)
        for other, limit in zip(found[1:], (1e-9, 1e-5)):
            worst = max(np.abs(other[name] - found[0][name]).max() for name in ("lambda_e_mean", "lambda_e_p05", "lambda_e_p99", "G_mean"))
            print(f"differs by {worst:.1e}")
            self.assertLess(worst, limit)


    def test_fibres_of_decks_are_those_of_the_solver(self):
        """Two programs for the same flow: pennation by an aponeurosis, cells without a gradient, a set of its own."""
        given = ["Fibre/From=PROXIMAL, SIDE", "Fibre/List=UPPER uniform 0 3 4"]
        for kind in ("tet4", "tet10", "hex8", "wedge6"):
            bar = Bar(kind, 6)
            side = [i for i, (x, _, z) in enumerate(bar.X[:28]) if x == 0 and z <= 3]
            path = self.folder / "bar.inp"
            path.write_text(bar.deck(more=f"*NSET, NSET=SIDE\n{', '.join(str(i + 1) for i in side)}\n*ELSET, ELSET=UPPER, GENERATE\n"
                                          f"{len(bar.cells) - len(bar.cells) // 6 + 1}, {len(bar.cells)}\n"))
            mesh = meshes.checked(meshes.read_raw(path), "mm")
            told = entries.override(entries.read(SOURCE / "examples" / "muscle" / "muscle.prm"), given)
            deck = export.Input(told, mesh)
            n0 = fibres.at_points(mesh, deck.fibre, deck.direction, *deck.surfaces, deck.set_fibres)[kind]
            out = self.solver(mesh, *given, "Output/Fibres=true", "Time/Steps=fixed", "Time/Step=1", "Time/End=1")
            rows = files.read_columns(out / "fibres.csv", ["element", "point", "x", "y", "z", "n0_x", "n0_y", "n0_z"])
            there, at = (np.array([rows[start + k] for k in "xyz"]).T.reshape(n0.shape) for start in ("n0_", ""))
            points = fibres.POINTS[kind][0]  # whose order in a cell may be another one
            own = np.einsum("pn,cni->cpi", shape_functions(kind, points), mesh.corners(kind)[:, :meshes.CORNERS[kind]])
            apart = max(np.abs(n0[c, np.linalg.norm(own[c] - at[c, q], axis=1).argmin()] - there[c, q]).max()
                        for c in range(len(n0)) for q in range(len(points)))
            print(f"{kind}: {n0.shape[0]} elements, inclined by up to {np.degrees(np.arccos(n0[..., 2].min())):.0f} degrees, differs by {apart:.1e}")
            self.assertLess(apart, 1e-9)
            self.assertLess(n0[:-len(bar.cells) // 6, :, 2].min(), 0.8)
            upper = n0[-(len(bar.cells) // 6):]
            self.assertLess(np.abs(upper - (0, 0.6, 0.8)).max(), 1e-12)


class Text(Case):
    def test_abaqus(self):
        mesh = self.mesh(spindle("tet4"))
        text = self.write("abaqus", mesh, "Mesh/Degree=2", "Output/Times=1, 7", "Muscle/tau_rev=5", "Muscle/G_min=0.8",
                          "Muscle/lambda_crit_rev=0.99", "Muscle/gamma_rev=1").read_text()
        self.assertIn("TYPE=C3D10", text)
        self.assertIn("UNSYMM=YES", text)
        self.assertIn("CONSTANTS=17, UNSYMM", text)
        self.assertEqual(text.count("*STEP, NAME"), 3)
        again = meshes.checked(meshes.read_raw(self.folder / "muscle_abaqus.inp"), "mm")  # our own reader takes it
        self.assertAlmostEqual(again.each(meshes.volumes).sum() / mesh.each(meshes.volumes).sum(), 1, places=12)
        for end in meshes.ENDS:
            self.assertAlmostEqual(again.area(end) / mesh.area(end), 1, places=12)
        rows = re.findall(r"^(\d+), 0\., 0\., 0\., 0\., 0\., (\S+), (\S+)\n(\S+)$", text, re.MULTILINE)
        self.assertEqual(len(rows), len(mesh.cell_labels))
        n = np.array([[float(x.strip(", ")) for x in row[1:]] for row in rows])
        self.assertLess(np.abs(np.linalg.norm(n, axis=1) - 1).max(), 1e-10)
        orientation = (self.folder / "fibres_orientation.inp").read_text()
        self.assertEqual(orientation.count("\n"), len(rows) + 8)
        deck = text.replace("MATERIAL=", "ORIENTATION=FIBRES, MATERIAL=").replace("*ELEMENT, ", orientation + "*ELEMENT, ", 1)
        (self.folder / "oriented.inp").write_text(deck)
        oriented = meshes.checked(meshes.read_raw(self.folder / "oriented.inp", fibre="1"), "mm")  # and so are the fibres
        self.assertLess(np.abs(oriented.fibres - n).max(), 1e-9)
        self.assertTrue((self.folder / "fibres.vtu").is_file())

    def test_refused(self):
        for entry, words in (("Attachments/Protocol=x.csv", "left out"), ("Muscle/Volume=mean dilatation", "pointwise"),
                             ("Attachments/List=PROXIMAL fixed; DISTAL pulled 1 2 3", "away PART"), ("Muscle/tau=x", "finite number"),
                             ("Attachments/List=FAR fixed", "no surface FAR"), ("Fibre/Kind=oblique", "flow"),
                             ("Fibre/List=HIP mesh", "no section or set HIP; there are MUSCLE"), ("Fibre/List=MUSCLE flow PROXIMAL", "flow FROM TO"),
                             ("Fibre/From=PROXIMAL, SIDE", "no surface SIDE"), ("Attachments/List=DISTAL away 1 at 0:0 1:1 1:0", "jumps"),
                             ("Materials/List=OTHER muscle", "section MUSCLE"), ("Time/Steps=some", "adaptive"),
                             ("Muscle/Law=1", "must be 0"), ("Muscle/Activation=0.5", "must be 0"), ("Roehrle/c10=5", "left out"),
                             ("Materials/List=MUSCLE muscle law=1", "expected parameters as NAME=VALUE")):
            with self.assertRaises(files.FileError) as caught:
                self.write("abaqus", self.mesh(Bar()), entry)
            self.assertIn(words, str(caught.exception))


class Job(Case):
    """examples/muscle/muscle.py, as ./run muscle starts it."""

    def start(self, *arguments):
        return subprocess.run([sys.executable, SOURCE / "examples/muscle/muscle.py", *map(str, arguments)], capture_output=True, text=True,
                              cwd=self.folder, env={**os.environ, **MPI})

    def test_job(self):
        self.mesh(Bar())
        run = self.start("bar.inp", "--unit", "mm", "--check")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        for words in ("24 tet4", "volume         4 mm3", "PROXIMAL: 2 facets, 4 corner nodes, 1 mm2", "4 mm from PROXIMAL's centroid"):
            self.assertIn(words, run.stdout)
        self.assertFalse((self.folder / "out").exists())
        run = self.start("bar.inp", "--unit", "mm", "--export", "calculix", "Muscle/tau=1", "--out", "x")
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        self.assertIn("\n16, 4, 1, 2, 1.1, 1.01, 0, 0\n1, 0, 0, 1\n", (self.folder / "x" / "muscle_calculix.inp").read_text())
        for arguments, status, words in ((("bar.inp", "--unit", "mm", "Output/Folder=x"), 2, "--out names the folder"),
                                         (("bar.inp",), 2, "--unit is needed"), (("no.inp", "--unit", "mm"), 1, "no.inp: No such file"),
                                         (("--unit", "mm"), 2, "needs a MESH"),
                                         (("bar.inp", "--unit", "mm", "--prm", "no.prm"), 1, "no.prm: No such file")):
            run = self.start(*arguments)
            self.assertEqual(run.returncode, status, run.stderr)
            self.assertIn(words, run.stderr)
        two = Bar().deck(more="*ELSET, ELSET=A, GENERATE\n1, 12\n*ELSET, ELSET=B, GENERATE\n13, 24\n", element="")
        (self.folder / "two.inp").write_text(two)
        run = self.start("two.inp", "--unit", "mm")
        self.assertIn("section A has no material", run.stderr)


    def test_whole_job(self):
        """From the deck to pictures, a programme with it: all files that docs/muscle.md lists, and none is empty."""
        if not PROGRAM:
            print("no deal.II program: only its decks are tested")
            return
        self.mesh(spindle("tet4"))
        (self.folder / "hours.csv").write_text("step, 1.05\nhold, 0.25\nstep, 1\n")
        command = ["bar.inp", "--unit", "mm", "--program", PROGRAM, "--out", "x", "Attachments/Protocol=hours.csv", "Attachments/Cycle=1",
                   "Time/End=2", "Output/Times=1", "Output/Fibres=true"]
        run = self.start(*command)
        self.assertEqual((run.returncode, run.stderr), (0, ""), run.stdout)
        for name in ("muscle.png", "regions.png", "regions.csv", "fascicles.csv", "hot_spots.csv", "attachments.csv", "history.csv", "newton.csv",
                     "summary.json", "muscle.pvd", "hot_volume.csv", "mesh_report.txt", "muscle.mesh", "streamlines.csv", "fibres.csv"):
            self.assertGreater((self.folder / "x" / name).stat().st_size, 50, name)
        regions = figures.read_regions(self.folder / "x" / "regions.csv")
        self.assertEqual(set(regions), {"proximal", "middle", "distal", "all", "MUSCLE"})
        on = regions["all"]["time"] < 0.25
        self.assertGreater(regions["all"]["lambda_e_p05"][on].min(), 1.01)
        self.assertEqual(self.start(*command[:5], "--out", "y", "--against", "nowhere").returncode, 1)
        self.assertFalse((self.folder / "y").exists() and list((self.folder / "y").iterdir()))
        run = self.start(*command, "Time/Wrong=1")
        self.assertEqual(run.returncode, 1)
        self.assertIn("there is no entry 'Time/Wrong'", run.stderr)


class Flow(Case):
    def test_bar_and_refinement(self):
        """Straight in a bar; second order in a cone, whose flow is radial: from r = 4 to 8 about the origin."""
        for kind in ("tet4", "tet10", "hex8", "wedge6"):
            n0, lacking = fibres.flow(self.mesh(Bar(kind)))
            self.assertLess(max(np.abs(n - (0, 0, 1)).max() for n in n0.values()), 1e-9)
            self.assertEqual(lacking, 0)

    def test_cells_without_gradient(self):
        """Tetrahedra whose four nodes are all held have their neighbours' direction."""
        bar = Bar(n=5)
        bar.first = list(range(8))
        path = self.folder / "bar.inp"
        path.write_text(bar.deck())
        mesh = meshes.checked(meshes.read_raw(path), "mm")
        n0, lacking = fibres.flow(mesh)
        self.assertEqual(lacking, 6)
        self.assertLess(np.abs(n0["tet4"] - (0, 0, 1)).max(), 0.2)

    def test_cone(self):
        errors = []
        for n in (4, 8):
            t = np.linspace(-0.3, 0.3, n + 1)
            r = np.linspace(4, 8, 2 * n + 1)
            a, b, c = np.meshgrid(t, t, r, indexing="ij")
            X = c[..., None] * np.stack([np.tan(a), np.tan(b), np.ones_like(a)], axis=-1)
            X *= (c / np.linalg.norm(X, axis=-1))[..., None]
            ids = np.arange(a.size).reshape(a.shape)
            bar = Bar("hex8", 1)
            bar.X = X.reshape(-1, 3).tolist()
            bar.cells = [[ids[i, j, k], ids[i + 1, j, k], ids[i + 1, j + 1, k], ids[i, j + 1, k], ids[i, j, k + 1], ids[i + 1, j, k + 1],
                          ids[i + 1, j + 1, k + 1], ids[i, j + 1, k + 1]] for i in range(n) for j in range(n) for k in range(2 * n)]
            path = self.folder / "cone.inp"
            ends = [[f"*NSET, NSET={name}"] + [f"{m + 1}," for m in ids[:, :, k].ravel()] for name, k in (("PROXIMAL", 0), ("DISTAL", -1))]
            path.write_text(bar.deck(proximal=[0], distal=[0]).split("*NSET")[0] + "\n".join(sum(ends, [])) + "\n")
            mesh = meshes.checked(meshes.read_raw(path), "mm")
            n0, _ = fibres.flow(mesh)
            middle = mesh.X[mesh.nodes_of["hex8"]].mean(axis=1)
            mean = fibres.of_elements(mesh, n0)
            radial = middle / np.linalg.norm(middle, axis=1)[:, None]
            errors.append(np.linalg.norm(mean - radial, axis=1).mean())
        print("mean error of the direction in a cone", errors)
        self.assertLess(errors[1], errors[0] / 3)
        self.assertLess(errors[1], 2e-3)


if __name__ == "__main__":
    program = unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2, exit=False)
    ran = program.result
    sys.exit(1 if not ran.wasSuccessful() else 77 if ran.skipped and len(ran.skipped) == ran.testsRun else 0)
