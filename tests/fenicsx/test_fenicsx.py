"""The dolfinx example against the one-element driver, CalculiX's cylinder and itself on two processes.

test_fenicsx.py DRIVER SOURCE [unittest arguments], with the module on PYTHONPATH; status 77 where there is no dolfinx.
"""
import csv
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

DRIVER, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
STRETCH = SOURCE / "examples/fenicsx/stretch.py"
# FFCx waits for a compilation that another process has begun, even for one that was killed: so a cache of our own.
CACHE = tempfile.TemporaryDirectory(prefix="myogrowth_")
REFERENCE = SOURCE / "tests/mpi/calculix_coarse.csv"
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
               "OMPI_MCA_mpi_yield_when_idle": "1", "XDG_CACHE_HOME": CACHE.name}
CASE = """&material props = 16.0, 4.0, 0.5, 2.0, 1.1, 1.01, 0.86602540378443865, 0.5, 0.0 /
&time duration = 2.0 dt = 0.1 /
&face name = 'x-' /
&face name = 'y-' /
&face name = 'z-' /
&face name = 'x+' time = 0.0, 1.0 value = 0.0, 0.1 /
"""

# An active cell under a pull along its fibre, its sides free: the force, and that of the library's strip.
ACTIVE = """
import stretch
V = stretch.fem.VectorFunctionSpace(stretch.mesh.create_unit_cube(stretch.MPI.COMM_WORLD, 1, 1, 1, stretch.mesh.CellType.hexahedron),
                                    ("Lagrange", 1))
pull = stretch.Pull(V, [(axis, 0.0, axis, False) for axis in range(3)] + [(0, 1.0, 0, True)])
parameters = stretch.myogrowth.Parameters(elastic=stretch.myogrowth.law("Roehrle", kappa=100))
muscle = stretch.Muscle(stretch.fem.Function(V), parameters, [1.0, 0.0, 0.0])
newton = stretch.Newton(muscle, pull.conditions, 1e-11)
muscle.activation = 0.1
pull.set(0.1)
newton.solve(0.1)
strip = stretch.myogrowth.simulate(parameters, [0.0, 0.1], [1.0, 1.1], activation=muscle.activation)
print(pull.reaction(newton.forces()), strip.force[1])
"""

# An error that is no reported fault, in the second process only.
BROKEN = """
import runpy, sys
from mpi4py import MPI
import myogrowth
if MPI.COMM_WORLD.rank == 1:
    myogrowth.update = None
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def read(path):
    with open(path) as f:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


class Case(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def stretch(self, *arguments, ranks=1, ok=True):
        """What was printed, and the rows of history.csv."""
        command = [*(["mpirun", "-q", "-n", str(ranks)] if ranks > 1 else []), sys.executable, str(STRETCH),
                   *map(str, arguments), "--out", self.folder]
        done = subprocess.run(command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=600)
        if not ok:
            return done
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout, read(self.folder / "history.csv")

    def equal(self, ours, theirs, tolerance):
        self.assertLess(abs(ours / theirs - 1), tolerance)


class Cube(Case):
    def test_one_cell_is_the_drivers_element(self):
        _, rows = self.stretch("cube", "--cells", 1, "--angle", 30)
        (self.folder / "case.nml").write_text(CASE)
        subprocess.run([DRIVER, self.folder / "case.nml", "--quiet", "--out", self.folder / "driver"], check=True)
        theirs = read(self.folder / "driver/history.csv")[1:]
        self.assertEqual(len(rows), len(theirs))
        for a, b in zip(rows, theirs):
            self.equal(a["reaction"], b["reaction"], 1e-8)
            self.equal(a["G_mean"], b["G"], 1e-9)
            self.equal(a["lambda_e_mean"], b["lambda_e"], 1e-9)
        self.assertGreater(rows[-1]["G_mean"], 1.03)

    def test_an_active_muscle(self):
        done = subprocess.run([sys.executable, "-c", ACTIVE], env=ENVIRONMENT, cwd=STRETCH.parent, capture_output=True, text=True,
                              timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr)
        force, strip = map(float, done.stdout.split())
        self.equal(force, strip, 1e-8)

    def test_newtons_order_and_two_processes(self):
        printed, rows = self.stretch("cube", "--cells", 3, "--angle", 30, "--tolerance", 1e-12)
        orders = []
        for line in printed.splitlines()[2:-1]:
            a, b, c = ([float(r) for r in line.split()[4:]] + [0, 0])[:3]
            if c > 1e-14:  # of which rounding is no part
                orders.append(math.log(c / b) / math.log(b / a))
            self.assertLess(b, 0.1 * a * a + 1e-13)  # quadratic with one constant in every step
        self.assertGreater(min(orders), 1.7)
        print("orders", " ".join(f"{o:.2f}" for o in orders))
        _, parallel = self.stretch("cube", "--cells", 3, "--angle", 30, "--tolerance", 1e-12, ranks=2)
        for a, b in zip(rows, parallel):
            for name in a:
                self.equal(a[name] + 1, b[name] + 1, 1e-10)

    def test_what_is_wrong_is_said(self):
        (self.folder / "times.csv").write_text("time,x\n0.1,1\n0.1,2\n")
        for arguments, status, message in ((["--layers", 3], 2, "there is no --layers of the cube"),
                                           (["--times", "times.csv", "--step", 0.2], 2, "there is no --step where --times is given"),
                                           (["--days", 1e300], 2, "--days 1e+300 in steps of 0.1: must be at most 1e6 steps"),
                                           (["--days", -1], 2, "--days: -1: must be a finite number > 0"),
                                           (["--times", self.folder / "times.csv"], 1, "times.csv:3: time: must be greater than 0.1")):
            done = self.stretch("cube", *arguments, ok=False)
            self.assertEqual(done.returncode, status)
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
        (self.folder / "history.csv").mkdir()  # which only the first process writes, and the second one waited for it
        done = self.stretch("cube", "--days", 0.1, ranks=2, ok=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("history.csv: cannot be written: it is a folder", done.stderr)
        done = subprocess.run(["mpirun", "-q", "-n", "2", sys.executable, "-c", BROKEN, str(STRETCH), "cube", "--out", self.folder / "broken"],
                              env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, 1)
        self.assertIn("TypeError", done.stderr)
        self.assertIn("there is no --angle of the cylinder", self.stretch("cylinder", "--angle", 30, ok=False).stderr)


class Cylinder(Case):
    def test_calculix(self):
        # The first days' steps of CalculiX's coarse mesh, of which 6 of 13 take seconds; the disc here has no wedges.
        lines = REFERENCE.read_text().splitlines()[:7]
        (self.folder / "times.csv").write_text("\n".join(lines))
        _, rows = self.stretch("cylinder", "--times", self.folder / "times.csv", "--integration", "midpoint_flow")
        theirs = read(self.folder / "times.csv")
        worst = {}
        for a, b in zip(rows, theirs):
            for name, tolerance in (("reaction", 3e-5), ("lambda_e_mean", 1e-6), ("G_mean", 1e-6), ("lambda_e_max", 3e-5),
                                    ("lambda_e_min", 2e-5)):
                self.equal(a[name], b[name], tolerance)
                worst[name] = max(worst.get(name, 0), abs(a[name] / b[name] - 1))
            self.assertLessEqual(a["iterations"], 3)
        print("differences", " ".join(f"{name} {x:.1e}" for name, x in worst.items()))


if __name__ == "__main__":
    try:
        import dolfinx  # noqa: F401
    except ImportError:
        sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
