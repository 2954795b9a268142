"""The one-element driver on its cases, held against exact solutions, and on what its users get wrong.

test_driver.py DRIVER UMAT ELASTIC_UMAT SOURCE [unittest arguments]; every class is a ctest.
"""
import csv
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

DRIVER, UMAT, ELASTIC, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:5])
CASES = SOURCE / "fortran_driver" / "cases"
COLUMNS = "time,G,lambda_e,lambda,J,Je,s11,s22,s33,s12,s13,s23,reaction,iterations".split(",")
C1, C2, TAU, GAMMA, G_MAX, CRIT = 16.0, 4.0, 0.5, 2.0, 1.1, 1.01


class Run:
    """A run of the driver in a folder of its own: what it printed, and its files."""

    def __init__(self, *arguments, text=None, edit=None, dump=None):
        self.kept = tempfile.TemporaryDirectory(prefix="myogrowth_")  # removed with the run
        self.folder = pathlib.Path(self.kept.name)
        arguments = list(arguments)
        if edit:
            text = pathlib.Path(arguments.pop(0)).read_text()
            for old, new in edit.items():
                assert old in text, old
                text = text.replace(old, new)
        if text is not None:
            (self.folder / "case.nml").write_text(text)
            arguments.insert(0, self.folder / "case.nml")
        done = subprocess.run([DRIVER, *arguments, "--out", self.folder], capture_output=True, text=True, timeout=300,
                              env={**os.environ, "MYOGROWTH_DUMP": str(dump or "")})
        self.status, self.screen, self.errors = done.returncode, done.stdout, done.stderr

    def rows(self, name="history.csv"):
        with open(self.folder / name) as f:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def flow(stretch, tau=TAU, n=4000):
    """G at the end of each time in `stretch` = [(t_end, lambda(t)), ...], by the classical Runge-Kutta method."""

    def rate(t, G, lam):
        return (max(G_MAX - G, 0) / (G_MAX - 1)) ** GAMMA * max(lam(t) / G - CRIT, 0) / tau

    G, t, result = 1.0, 0.0, []
    for end, lam in stretch:
        h = (end - t) / n
        for i in range(n):
            s = t + i * h
            k1 = rate(s, G, lam)
            k2 = rate(s + h / 2, G + h / 2 * k1, lam)
            k3 = rate(s + h / 2, G + h / 2 * k2, lam)
            G += h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(s + h, G + h * k3, lam))
        t = end
        result.append(G)
    return result


def cauchy(F, n0, G):
    """Stress of the law at a plane deformation F (3x3 rows) by its formulas."""
    f = [sum(F[i][j] * n0[j] for j in range(3)) for i in range(3)]
    J = (F[0][0] * F[1][1] - F[0][1] * F[1][0]) * F[2][2]
    tau = lambda i, j: ((C1 * math.log(J / G) - C2) * (i == j)
                        + C2 * (sum(F[i][k] * F[j][k] for k in range(3)) + (1 / G**2 - 1) * f[i] * f[j]))
    return [tau(i, j) / J for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]


class Cases(unittest.TestCase):
    def run_case(self, name):
        run = Run(CASES / name)
        self.assertEqual((run.status, run.errors), (0, ""))
        rows = run.rows()
        self.assertEqual(list(rows[0]), COLUMNS)
        self.assertEqual((rows[0]["time"], rows[0]["G"], rows[0]["s11"]), (0, 1, 0))
        for row in rows:
            self.assertTrue(all(math.isfinite(x) for x in row.values()))
            self.assertTrue(1 <= row["G"] <= G_MAX)
        return rows

    def test_cube(self):
        rows = self.run_case("cube.nml")
        at = {round(r["time"], 6): r for r in rows}
        exact = flow([(0.1, lambda t: 1 + 0.1 * t), (1, lambda t: 1 + 0.1 * t), (14, lambda t: 1.1), (42, lambda t: 1.1)])
        for t, G, value in ((1, exact[1], 1.0630), (14, exact[2], 1.0170), (42, exact[3], 1.0121)):
            self.assertAlmostEqual(1.1 / G, value, delta=5e-5)  # the stored values are the exact ones
            self.assertAlmostEqual(at[t]["lambda_e"], value, delta=1e-4)
            self.assertAlmostEqual(at[t]["G"], G, delta=5e-5)
        self.assertEqual(max(rows, key=lambda r: r["lambda_e"])["time"], 1)
        for row in rows[1::400]:  # equilibrium with free sides, and the pull: the law in uniaxial stress
            self.assertLess(abs(row["s22"]) + abs(row["s33"]) + abs(row["s12"]), 1e-8)
            self.assertAlmostEqual(row["reaction"], row["s11"] * row["J"] / row["lambda"], delta=1e-9)
            side = math.sqrt(row["J"] / row["lambda"])
            F = [[row["lambda"], 0, 0], [0, side, 0], [0, 0, side]]
            self.assertAlmostEqual(row["s11"], cauchy(F, (1, 0, 0), row["G"])[0], delta=1e-10)

    def test_order_in_dt(self):
        exact = flow([(0.1, lambda t: 1 + 0.1 * t), (1, lambda t: 1 + 0.1 * t), (2, lambda t: 1.1)])[-1]
        errors = []
        for dt in ("0.02", "0.01", "0.005"):
            run = Run(CASES / "cube.nml", edit={"duration = 42.0": "duration = 2.0", "dt = 0.01": f"dt = {dt}"})
            errors.append(run.rows()[-1]["G"] - exact)
        for coarse, fine in zip(errors, errors[1:]):
            self.assertAlmostEqual(math.log2(coarse / fine), 1, delta=0.05)

    def test_shear(self):
        rows = self.run_case("shear.nml")
        stretch = lambda t: math.sqrt(((1 + 0.3 * min(t, 1)) ** 2 + 1) / 2)
        start = (math.sqrt(2 * CRIT**2 - 1) - 1) / 0.3  # where growth sets in
        exact = flow([(start, stretch), (1, stretch), (10, stretch)])
        at = {round(r["time"], 6): r for r in rows}
        for t, G in ((1, exact[1]), (10, exact[2])):
            self.assertAlmostEqual(at[t]["G"], G, delta=1e-3)
        for row in rows[1:]:
            k = 0.3 * min(row["time"], 1)
            sigma = cauchy([[1, k, 0], [0, 1, 0], [0, 0, 1]], (math.sqrt(0.5), math.sqrt(0.5), 0), row["G"])
            for name, value in zip(COLUMNS[6:12], sigma):
                self.assertAlmostEqual(row[name], value, delta=1e-12)
            self.assertAlmostEqual(row["reaction"], row["s12"], delta=1e-12)  # unit top face, moving in its plane
            self.assertAlmostEqual(row["lambda"], stretch(row["time"]), delta=1e-13)

    def test_saturation(self):
        rows = self.run_case("saturation.nml")
        ramp = lambda t: 1 + 0.2 * t
        exact = flow([(0.05, ramp), (1, ramp), (42, lambda t: 1.2)], tau=0.005, n=20000)
        self.assertAlmostEqual(rows[-1]["G"], exact[-1], delta=1e-5)
        self.assertAlmostEqual(rows[-1]["G"], 1.1, delta=5e-5)
        self.assertAlmostEqual(rows[-1]["lambda_e"], 1.2 / 1.1, delta=5e-5)

    def test_fibre30(self):
        rows = self.run_case("fibre30.nml")
        for row in rows:  # no force but the pull's: zero in the mean over the free faces
            self.assertLess(abs(row["s33"]), 0.05)
        # The limit dt -> 0 by Richardson's extrapolation over dt = 0.05, 0.025.
        fine = Run(CASES / "fibre30.nml", edit={"dt = 0.05": "dt = 0.025"}).rows()
        finest = Run(CASES / "fibre30.nml", edit={"dt = 0.05": "dt = 0.0125"}).rows()
        a, b, c = rows[-1]["G"], fine[-1]["G"], finest[-1]["G"]
        self.assertAlmostEqual(math.log2((b - a) / (c - b)), 1, delta=0.05)
        self.assertAlmostEqual(2 * c - b, 2 * b - a, delta=1e-6)

    def test_traction_is_balanced(self):
        rows = self.run_case("traction_oblique.nml")
        for row in rows[1:]:
            self.assertAlmostEqual(row["reaction"], min(row["time"], 2), delta=1e-9)  # the pull on a unit face

    def test_cutback(self):
        run = Run(CASES / "cutback.nml")
        self.assertEqual(run.status, 0)
        self.assertIn("cut-back at time 0 ", run.screen)
        self.assertRegex(run.screen, r"PNEWDT = 0\.25")
        rows = run.rows()
        self.assertEqual([r["time"] for r in rows], [0, 1, 2])
        self.assertAlmostEqual(rows[-1]["reaction"], -20, delta=1e-6)


class Newton(unittest.TestCase):
    """Newton's order on an oblique-fibre cube under traction, with the full tangent and with its symmetric part."""

    @staticmethod
    def orders(run):
        """Orders in the asymptotic range: from the second iteration, residuals between 1e-2 and rounding."""
        increments = {}
        for row in run.rows("newton.log"):
            if row["iteration"] > 0:
                increments.setdefault(row["increment"], []).append(row["residual"])
        result = []
        for r in increments.values():
            for a, b, c in zip(r, r[1:], r[2:]):
                if a < 1e-2 and c > 2e-14:
                    result.append(math.log(c / b) / math.log(b / a))
        return result

    def test_quadratic_with_the_full_tangent_only(self):
        full = Run(CASES / "traction_oblique.nml")
        half = Run(CASES / "traction_oblique.nml", edit={"symmetrise = .false.": "symmetrise = .true."})
        self.assertEqual((full.status, half.status), (0, 0))
        orders, lost = self.orders(full), self.orders(half)
        iterations = [int(re.search(r"(\d+) iterations", run.screen).group(1)) for run in (full, half)]
        print(f"order {min(orders):.2f} to {max(orders):.2f} in {iterations[0]} iterations; symmetrised: "
              f"{sum(lost) / len(lost):.2f} on average in {iterations[1]} iterations")
        self.assertGreaterEqual(len(orders), 3)
        self.assertGreaterEqual(min(orders), 1.8)
        self.assertLess(sum(lost) / len(lost), 1.2)
        self.assertGreater(iterations[1], 1.8 * iterations[0])
        for a, b in zip(full.rows(), half.rows()):  # where it converges to is the same
            self.assertAlmostEqual(a["s11"], b["s11"], delta=1e-10)


class OtherUmats(unittest.TestCase):
    PULL = """
&material props = 1000.0, 0.3, {dtime}  nstatv = 0 /
&time duration = 1.0  dt = 0.1 /
&face name = 'x-' / &face name = 'y-' / &face name = 'z-' /
&face name = 'x+' time = 0.0, 1.0 value = 0.0, 0.1 /
""".replace("/ &face", "/\n&face")

    def test_our_own_by_path_is_the_linked_one(self):
        linked, loaded = Run(CASES / "cube.nml"), Run(CASES / "cube.nml", "--umat", UMAT)
        self.assertEqual(linked.rows(), loaded.rows())

    def test_an_elastic_one(self):
        rows = Run("--umat", ELASTIC, text=self.PULL.format(dtime=0)).rows()
        # Hughes-Winget strains are logarithmic to second order in the increment
        self.assertAlmostEqual(rows[-1]["s11"], 1000 * math.log(1.1), delta=1e-3)

    def test_its_pnewdt_is_honoured(self):
        run = Run("--umat", ELASTIC, text=self.PULL.format(dtime=0.05))
        self.assertEqual(run.status, 0)
        self.assertIn("PNEWDT = 0.4", run.screen)
        accepted = {r["increment"]: r["dt"] for r in run.rows("newton.log")}
        self.assertLessEqual(max(accepted.values()), 0.05 * 1.00001)
        self.assertAlmostEqual(run.rows()[-1]["s11"], 1000 * math.log(1.1), delta=1e-3)

    def test_one_that_never_has_enough_ends_the_run(self):
        run = Run("--umat", ELASTIC, text=self.PULL.format(dtime=1e-9))
        self.assertEqual(run.status, 2)
        self.assertIn("more than max_cutbacks = 10", run.errors)
        self.assertEqual(len(run.rows()), 1)  # what there was is kept

    def test_one_that_is_not_there(self):
        run = Run("--umat", "no_such_umat.so")
        self.assertEqual(run.status, 1)
        self.assertIn("no_such_umat.so", run.errors)


class Path(unittest.TestCase):
    def path(self, text):
        with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
            file = pathlib.Path(folder) / "F.csv"
            file.write_text(text)
            return Run("--path", file)

    HEAD = "time,F11,F12,F13,F21,F22,F23,F31,F32,F33\n"

    def test_one_step(self):
        run = self.path(self.HEAD + "# held at once\n0,1.1,0,0,0,1,0,0,0,1\n0.5,1.1,0,0,0,1,0,0,0,1\n")
        self.assertEqual(run.status, 0)
        rows = run.rows()
        self.assertEqual(rows[0]["G"], 1)
        self.assertAlmostEqual(rows[1]["G"], 1.02931485, delta=5e-9)
        D = run.rows("ddsdde.csv")[1]
        self.assertLess(D["D11"], D["D12"] + 8)  # growth softens along the fibre
        self.assertNotAlmostEqual(D["D12"], D["D21"], places=1)  # unsymmetric

    def test_rows_are_rows_of_F(self):
        rows = self.path(self.HEAD + "0,1,0.3,0,0,1,0,0,0,1\n").rows()
        sigma = cauchy([[1, 0.3, 0], [0, 1, 0], [0, 0, 1]], (1, 0, 0), 1)
        for name, value in zip(COLUMNS[6:12], sigma):
            self.assertAlmostEqual(rows[0][name], value, delta=1e-13)

    def test_errors_name_the_line(self):
        for text, words in (
            ("t,F\n0,1\n", ["F.csv:1", "header"]),
            (self.HEAD + "0,1,0,0,0,1,0,0,0\n", ["F.csv:2", "10 numbers"]),
            (self.HEAD + "0,1,0,0,0,one,0,0,0,1\n", ["F.csv:2", "one"]),
            (self.HEAD + "1,1,0,0,0,1,0,0,0,1\n0,1,0,0,0,1,0,0,0,1\n", ["F.csv:3", "time = 0"]),
        ):
            run = self.path(text)
            self.assertEqual(run.status, 1)
            for word in words:
                self.assertIn(word, run.errors)
        run = self.path(self.HEAD + "0,1,0,0,0,1,0,0,0,1\n1,-1,0,0,0,1,0,0,0,1\n")
        self.assertEqual(run.status, 2)
        self.assertIn("F.csv:3", run.errors)
        self.assertEqual(len(run.rows()), 1)


class Replay(unittest.TestCase):
    """What the UMAT writes into the folder of MYOGROWTH_DUMP where it gives no result, and the driver reads."""

    HEALTHY, SPOILED = "0.2,1.1,0.1,0,0,0.9,0,0.05,0,1", "0.2,1.1,0.1,0,0,-0.9,0,0.05,0,1"
    POINT = "&point\n ntens = 3\n dtime = 0.1\n pnewdt = 1\n dfgrd1 = 1, 0, 0, 0, 1, 0, 0, 0, 0\n" \
            " nprops = 6\n props = 16, 4, 0.5, 2, 1.1, 1.01\n nstatv = 9\n statev = 0 0 0 0 0 0 0 0 0\n/\n"

    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)
        self.dump = self.folder / "umat_1.nml"

    def path(self, row, **options):
        (self.folder / "F.csv").write_text(Path.HEAD + "0.1,1.05,0,0,0,1,0,0,0,1\n" + row + "\n")
        run = Run("--path", self.folder / "F.csv", **options)
        (self.folder / "F.csv").unlink()
        return run

    def replay(self, text=None):
        if text is not None:
            self.dump.write_text(text)
        return Run("--replay", self.dump)

    @staticmethod
    def values(run, name):
        found = re.search(rf"^{re.escape(name)} +(.*)$", run.screen, re.M)
        return [float(x) for x in found.group(1).split()]

    def test_a_row_of_a_path(self):
        ordinary = self.path(self.HEALTHY, dump=self.folder)
        self.assertEqual((ordinary.status, list(self.folder.iterdir())), (0, []))
        self.assertEqual(self.path(self.SPOILED).status, 2)
        self.assertEqual(list(self.folder.iterdir()), [])  # off by default
        self.assertEqual(self.path(self.SPOILED, dump=self.folder).status, 2)
        self.assertEqual(list(self.folder.iterdir()), [self.dump])
        again = self.replay()
        self.assertEqual((again.status, again.errors), (0, ""))
        self.assertIn("verdict: refused; det DFGRD1 = -0.99 is not > 0\n"
                      "when written: inverted: det F must be > 0\n", again.screen)
        self.assertTrue(all(math.isnan(x) for x in self.values(again, "STRESS") + self.values(again, "DDSDDE(6,:)")))
        self.assertEqual(self.values(again, "PNEWDT"), [0.25])
        self.assertEqual(len(list(again.folder.iterdir())), 0)  # no history.csv
        statev = self.values(again, "STATEV")
        first = ordinary.rows()[0]
        self.assertEqual(statev[:5], [first[name] for name in COLUMNS[1:6]])
        # With a healthy F it is what comes after that row.
        text = self.dump.read_text()
        self.assertIn("0, -0.90000000000000002, 0,", text)
        healed = self.replay(text.replace("0, -0.90000000000000002, 0,", "0, 0.9, 0,"))
        self.assertEqual((healed.status, healed.errors), (0, ""))
        self.assertIn("verdict: a result\n", healed.screen)
        second = ordinary.rows()[1]
        self.assertEqual(self.values(healed, "STRESS"), [second[name] for name in COLUMNS[6:12]])
        self.assertEqual(self.values(healed, "STATEV")[:5], [second[name] for name in COLUMNS[1:6]])
        D = ordinary.rows("ddsdde.csv")[1]
        for i in range(1, 7):
            self.assertEqual(self.values(healed, f"DDSDDE({i},:)"), [D[f"D{i}{j}"] for j in range(1, 7)])

    def test_bad_props(self):
        message = "PROPS(5) = 0.9: G_max, largest relative serial sarcomere number, must be finite and > 1."
        run = Run(text="&material props = 16, 4, 0.5, 2, 0.9, 1.01 /\n", dump=self.folder)
        self.assertEqual(run.status, 2)
        again = self.replay()
        self.assertEqual((again.status, again.errors), (0, f"myogrowth UMAT: {message}\n"))
        self.assertIn("verdict: refused; DFGRD1 and DTIME are in order", again.screen)
        self.assertIn(f"when written: {message}\n", again.screen)

    def test_a_cut_back_in_the_element(self):
        run = Run(CASES / "cutback.nml", dump=self.folder)
        self.assertEqual(run.status, 0)
        self.assertRegex(self.replay().screen, "verdict: refused; det DFGRD1 = -.*\nwhen written: inverted")

    def test_other_elements(self):
        for ntens, text in ((3, self.POINT), (4, self.POINT.replace("ntens = 3", "ntens = 4").replace("0\n np", "1\n np")),
                            (3, self.POINT.replace("= 1, 0, 0, 0, 1,", "= 0, 0, 0, 0, 0,"))):
            run = self.replay(text)
            self.assertIn("verdict: a result\n", run.screen)
            self.assertEqual(self.values(run, "STRESS"), [0]*ntens)
        for change, words in (("ntens = 5", "NTENS = 5: must be 6"), ("ntens = 0", "NTENS = 0: must be 6"),
                              ("ntens = 3\n ndi = 3\n nshr = 0", "NDI = 3, NSHR = 0: elements of one-dimensional")):
            run = self.replay(self.POINT.replace("ntens = 3", change))
            self.assertEqual(run.status, 0)
            self.assertIn("verdict: refused", run.screen)
            self.assertIn(words, run.errors)
        run = self.replay(self.POINT.replace("1, 0, 0, 0, 1, 0", "1, 0, NaN, 0, -1, Infinity"))
        self.assertIn("refused; det DFGRD1 = -1 is not > 0\n", run.screen)  # of the entries in the plane
        run = self.replay(self.POINT.replace("dtime = 0.1", "dtime = NaN"))
        self.assertIn("refused; DTIME is not finite\n", run.screen)
        run = self.replay(self.POINT.replace("= 1, 0, 0,", "= -Infinity, 0, 0,"))
        self.assertIn("refused; DFGRD1 or its determinant is not finite\n", run.screen)

    def test_another_umat(self):
        self.dump.write_text(self.POINT.replace("ntens = 3", "ntens = 6"))
        run = Run("--replay", self.dump, "--umat", ELASTIC)
        self.assertEqual((run.status, run.errors), (0, ""))
        self.assertIn("verdict: a result\n", run.screen)

    def test_what_is_wrong_with_a_file_is_named(self):
        for old, new, words in (
            (" dtime = 0.1\n", "", ":1: &point: dtime: is missing"),
            (" statev = 0 0 0 0 0 0 0 0 0\n", "", ":1: &point: statev: is missing"),
            ("dtime = 0.1", "dt = 0.1", ':3: &point: unknown variable "dt"; known: fault ntens dtime'),
            ("dtime = 0.1", "dtime = soon", ':3: &point: dtime = soon: "soon" is not a number'),
            ("ntens = 3", "ntens = 3.5", ":2: &point: ntens = 3.5: must be a whole number"),
            ("ntens = 3", "ntens = 1001", ":2: &point: ntens = 1001: must be at most 1000"),
            ("nprops = 6", "nprops = 7", "the number of values must be 7, is 6"),
            ("16, 4, 0.5", "16, 2*4", '"2*4" is not a number'),
            ("/\n", "", ":1: &point: is not closed by /"),
            ("&point", "&material", ":1: &material: unknown group; known: &point"),
            ("&point", "&point\n/\n&point", "one group, &point, is expected, found 2"),
        ):
            run = self.replay(self.POINT.replace(old, new))
            self.assertEqual(run.status, 1)
            self.assertIn(f"{self.dump}", run.errors)
            self.assertIn(words, run.errors)
            self.assertEqual(run.screen, "")
        run = Run("--replay", self.folder / "no_such.nml")
        self.assertEqual(run.status, 1)
        self.assertIn("no_such.nml: cannot be opened", run.errors)
        run = Run(CASES / "cube.nml", "--replay", self.dump)
        self.assertEqual((run.status, run.errors), (1, "myogrowth_driver: --replay goes without INPUT.nml and --path\n"))


class InputErrors(unittest.TestCase):
    """Every error names the file, the line, the group and the variable, what was found and what is allowed."""

    def expect(self, text, *words, status=1):
        run = Run(text=text)
        self.assertEqual(run.status, status, run.errors)
        for word in words:
            self.assertIn(word, run.errors)

    def test_values(self):
        self.expect("&time\n duration = 1\n dt = -0.1\n/\n", "case.nml:3: &time: dt = -0.1: must be > 0")
        self.expect("&time\n duration = 0 /\n", "case.nml:2: &time: duration = 0")
        self.expect("&element size = 1.0, 0.0, 1.0 /\n", "case.nml:1: &element: size")
        self.expect("&solver\n max_iterations = 0 /\n", "case.nml:2: &solver: max_iterations = 0: must be >= 1")
        self.expect("&time\n dt = fast /\n", "case.nml:2: &time: dt = fast: must be one number")
        self.expect("&material\n nstatv = 2\n statev_initial = 1, 2, 3 /\n", "case.nml:3: &material: statev_initial")

    def test_names(self):
        self.expect("&tim\n dt = 1 /\n", "case.nml:1: &tim: unknown group", "&time")
        self.expect("&time\n step = 1 /\n", 'case.nml:2: &time: unknown variable "step"', "duration")
        self.expect("&face\n name = 'top' /\n", "case.nml:2: &face: name = 'top'", "'x-'")
        self.expect("&face name = 'x+'\n control = 'force' /\n", "case.nml:2: &face: control = 'force'", "'traction'")

    def test_tables(self):
        self.expect("&face name = 'x+'\n time = 0, 1, 1\n value = 0, 1, 2 /\n", "case.nml:2: &face: time", "increase")
        self.expect("&face name = 'x+'\n time = 0, 1\n value = 0, 1, 2 /\n", "case.nml:3: &face: value", "2 numbers")

    def test_structure(self):
        self.expect("&time\n dt = 1\n", "case.nml:1: &time: is not closed by /")
        self.expect("dt = 1\n", "case.nml:1", "outside a group")
        self.expect("&time dt = 1 /\n&time dt = 2 /\n", "case.nml:2: &time: given already in line 1")

    def test_loading(self):
        self.expect("&face name = 'x-' /\n&face name = 'y-' /\n", "move as a rigid body", "translation along z")
        contradiction = "".join(f"&face name = '{n}' direction = 'x' value = {v} /\n" for n, v in
                                (("x-", 0), ("y-", 0.1)))
        self.expect(contradiction + "&face name = 'y-' /\n&face name = 'z-' /\n", "case.nml:2", "contradicts line 1")

    def test_the_umats_own_message(self):
        self.expect("&material props = 16, 4, 0.5, 2, 0.9, 1.01 /\n", "PROPS(5) = 0.9: G_max", status=2)

    def test_command_line(self):
        for arguments, word in ((["--fast"], "--fast"), (["no_such.nml"], "no_such.nml"), (["--umat"], "")):
            run = Run(*arguments)
            self.assertEqual(run.status, 1)
            self.assertIn(word, run.errors)


class CubeJob(unittest.TestCase):
    """What ./run cube does after building."""

    def cube(self, *options):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        folder = pathlib.Path(kept.name)
        script = SOURCE / "fortran_driver" / "cube.py"
        done = subprocess.run([sys.executable, script, "--driver", DRIVER, "--out", folder, *options],
                              capture_output=True, text=True, timeout=300)
        return done, folder

    def test_files_and_table(self):
        done, folder = self.cube()
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("fig2_elastic_stretch.png", "fig4_sarcomere_number.png"):
            self.assertEqual((folder / name).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertTrue((folder / "cube.nml").exists())
        with open(folder / "history.csv") as f:
            self.assertEqual(f.readline().strip().split(","), COLUMNS)
        table = {}
        for line in done.stdout.splitlines():
            found = re.match(r"(peak lambda_e|lambda_e, day 14|lambda_e, day 42)\s+(\S+)\s+(\S+)", line)
            if found:
                table[found.group(1)] = (float(found.group(2)), float(found.group(3)))
        for name, value in (("peak lambda_e", 1.0630), ("lambda_e, day 14", 1.0170), ("lambda_e, day 42", 1.0121)):
            for x in table[name]:
                self.assertAlmostEqual(x, value, delta=1e-4)

    def test_options(self):
        done, folder = self.cube("--stretch", "1.05", "--ramp", "0", "--duration", "5", "--step", "0.1", "--gamma", "1.5")
        self.assertEqual(done.returncode, 0, done.stderr)
        case = (folder / "cube.nml").read_text()
        self.assertIn("1.5", case)
        self.assertIn("duration = 5.0", case)
        done, _ = self.cube("--step", "-1")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--step = -1.0: must be > 0", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2)
