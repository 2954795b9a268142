"""The programs behind ./run fit, protocol and sensitivity, on small cases.

test_studies.py SOURCE PROGRAMS [unittest arguments]
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE, PROGRAMS = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
EXAMPLES = SOURCE / "examples"
sys.dont_write_bytecode = True


class Job(unittest.TestCase):
    program = ""

    @classmethod
    def setUpClass(cls):
        if not (PROGRAMS / cls.program).is_file():
            print(f"skipped: no {cls.program}; is Ceres Solver (libceres-dev) there?")
            sys.exit(77)

    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def file(self, text, name="study.csv"):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_it(self, *arguments, status=0):
        done = subprocess.run([PROGRAMS / self.program, *map(str, arguments), "--out", self.folder / "out"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done.stderr if status == 2 else done.stdout

    def report(self, *arguments):
        self.run_it(*arguments)
        return json.loads((self.folder / "out" / "report.json").read_text())

    def check_errors(self, cases):
        for text, message in cases:
            with self.subTest(text):
                self.assertIn(message, self.run_it(self.file(text), status=2))


def exact_day(G, stretch, tau, G_max, crit, G_n=1.0):
    """Day at which a muscle held at a stretch from G_n on has G, for gamma = 2 (docs/theory.md)."""
    b = stretch - crit * G_max

    def antiderivative(g):
        return stretch / b**2 * math.log(G_max - g) + G_max / b / (G_max - g) - stretch / b**2 * math.log(abs(stretch - crit * g))
    return tau * (G_max - 1)**2 * (antiderivative(G) - antiderivative(G_n))


MEASURED = [1, 2, 3, 4, 6, 9, 14, 21, 28, 42]


class Fit(Job):
    program = "study_fit"

    def test_history_is_exact(self):
        numbers = [1.01, 1.03, 1.05, 1.07, 1.08, 1.085]
        rows = "".join(f"measure, {exact_day(G, 1.1, 0.5, 1.1, 1.01)!r}, G, {G}, 0.01\n" for G in numbers)
        r = self.report(self.file("step, 1.1\n" + rows))
        for G, m in zip(numbers, r["measurements"]):
            self.assertAlmostEqual(m["computed"], G, delta=2e-5)

    def test_recovers_without_noise(self):
        truth = {"tau": 0.8, "gamma": 1.3, "G_max": 1.12, "lambda_crit": 1.005}
        head = "ramp, 1.08, 1\nhold, 10\nramp, 1.14, 1\nhold, 30\n"
        sets = "".join(f"set, {name}, {x}\n" for name, x in truth.items())
        blank = "".join(f"measure, {d}, lambda_e, 1, 0.001\n" for d in (0.5, *MEASURED, 12, 13))
        made = self.report(self.file(sets + head + blank))["measurements"]
        rows = "".join(f"measure, {m['day']}, lambda_e, {m['computed']!r}, 0.001\n" for m in made)
        bounds = "fit, tau, 0.05, 10\nfit, gamma, 0.2, 5\nfit, G_max, 1.08, 1.5\nfit, lambda_crit, 0.95, 1.04\n"
        r = self.report(self.file(head + bounds + rows), "--starts", 4)
        self.assertLess(r["chi2"], 1e-6)
        for i, p in enumerate(r["parameters"]):
            self.assertAlmostEqual(p["estimate"] / truth[p["name"]], 1, delta=1e-3)
            self.assertAlmostEqual(r["covariance"][i][i] / p["sd"]**2, 1, delta=1e-6)
            self.assertLess(p["lower"], truth[p["name"]])
            self.assertGreater(p["upper"] or math.inf, truth[p["name"]])

    def test_coverage(self):
        """95 % intervals: of 200 runs 190 +- 3.1 should hold the truth. Allowed: 178 to 200; below, twice in 10,000
        times for an interval that keeps its word (binomial)."""
        text = self.run_it(EXAMPLES / "identification" / "example.csv", "--coverage", 200)
        print(text)
        found = json.loads((self.folder / "out" / "coverage.json").read_text())
        self.assertEqual(len(found["parameters"]), 2)
        for p in found["parameters"]:
            self.assertGreaterEqual(p["by_profile"], 178)
            self.assertGreaterEqual(p["by_curvature"], 178)
            self.assertAlmostEqual(p["mean"] / p["truth"], 1, delta=0.1)

    def test_intervals_that_are_too_narrow_are_seen(self):
        """The test above can fail: with noise twice as large as the file says, the intervals hold the truth less often."""
        text = (EXAMPLES / "identification" / "example.csv").read_text()
        r = self.report(self.file(text.replace(", 0.003\n", ", 0.001\n")))
        self.assertTrue(any("too narrow" in w for w in r["warnings"]), r["warnings"])

    def test_says_what_cannot_be_told_apart(self):
        r = self.report(EXAMPLES / "identification" / "example_all.csv", "--starts", 2)
        self.assertTrue(any("gamma and G_max apart" in w for w in r["warnings"]), r["warnings"])
        nothing = self.report(self.file("fit, tau, 0.1, 10\nstep, 1.005\nhold, 9\nmeasure, 9, lambda_e, 1.005, 0.01\n"))
        self.assertTrue(any("say nothing of tau" in w for w in nothing["warnings"]), nothing["warnings"])
        two = self.report(self.file("fit, tau, 0.1, 10\nfit, gamma, 0.1, 5\nstep, 1.1\nmeasure, 3, lambda_e, 1.03, 0.01\n"))
        self.assertTrue(any("cannot tell tau, gamma apart" in w for w in two["warnings"]), two["warnings"])

    def test_robust(self):
        text = (EXAMPLES / "identification" / "example.csv").read_text() + "measure, 5, lambda_e, 1.2, 0.003\n"
        squares, robust = (self.report(self.file(text), *more)["values"][0] for more in ((), ("--robust", 1.5)))
        self.assertLess(abs(robust - 0.5), 0.2)
        self.assertGreater(abs(squares - 0.5), 2 * abs(robust - 0.5))

    def test_errors(self):
        self.check_errors([
            ("step, 1.1\nmeasure, 3, lambda_e, x, 0.01\n", "study.csv:2:23: expected a value, a number > 0, found 'x'"),
            ("step, 1.1\nmeasure, 3, lambda_e, 1.02, 0\n",
             "study.csv:2:29: expected a standard deviation, a number > 0, found '0'"),
            ("step, 1.1\nmeasure, 3, sigma, 1.02, 1\n", "study.csv:2:13: expected lambda_e or G, found 'sigma'"),
            ("step, 1.1\nmeasure, 3, G\n", "study.csv:2:14: expected a value, a number > 0, found nothing"),
            ("step, 1.1, 3\n", "study.csv:1:12: expected the end of the row, found '3'"),
            ("jump, 1.1\n", "study.csv:1:1: expected title, include, set, fit"),
            ("set, G_max, 0.9\n", "study.csv:1:13: expected G_max > 1, found '0.9'"),
            ("set, tua, 0.9\n", "study.csv:1:6: expected a parameter: c1, c2, tau"),
            ("fit, tau, 3, 2\n", "study.csv:1:14: expected an upper bound, a number > 3, found '2'"),
            ("fit, c1, 3, 4\n", "study.csv:1:6: expected tau, gamma, G_max or lambda_crit, found 'c1'"),
            ("include, nowhere.csv\n", "study.csv:1:10: expected the name of a file that can be read"),
            ("include, study.csv\n", "study.csv:1:10: expected the name of a file that can be read (and not in a circle)"),
            ("distract, 1, 3\n", "study.csv:1:1: expected a row 'rest_length, MM' before 'distract'"),
            ("set, tau_rev, 1\nset, lambda_rev, 1.5\nstep, 1.1\n", "lambda_rev = 1.5: expected at most lambda_crit = 1.01"),
            ("step, 1.1\n", "study.csv: expected a row 'measure"),
        ])
        good = self.file("step, 1.1\nmeasure, 3, G, 1.02, 1\n")
        self.assertIn("no option '--strats'", self.run_it(good, "--strats", 3, status=2))
        self.assertIn("--starts = 1.5: expected a whole number", self.run_it(good, "--starts", 1.5, status=2))
        self.assertIn("--set tau=-1: expected tau > 0", self.run_it(good, "--set", "tau=-1", status=2))
        self.assertIn("nowhere.csv: cannot be read", self.run_it("nowhere.csv", status=2))

    def test_pictures(self):
        out = self.folder / "out"
        command = [sys.executable, EXAMPLES / "common" / "pictures.py", "fit", PROGRAMS / self.program,
                   EXAMPLES / "identification" / "example.csv", "--starts", "1", "--out", out]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("fit.png", "profiles.png", "report.md"):
            self.assertGreater((out / name).stat().st_size, 1000)


class Published(Job):
    program = "study_fit"

    def test_the_docs_have_these_figures(self):
        docs = (SOURCE / "docs" / "studies.md").read_text()
        for path in sorted((EXAMPLES / "identification" / "published").glob("*.csv")):
            r = self.report(path)
            for m in r["measurements"]:
                off = 100 * (m["computed"] / m["value"] - 1)
                row = (f"| {r['title']} | {m['day']:g} | {m['quantity']} | {m['value']:.3f} ± {m['sd']:.3f} | "
                       f"{m['computed']:.3f} | {off:+.2f} % |")
                with self.subTest(row):
                    self.assertIn(row, docs)


class Protocol(Job):
    program = "study_protocol"

    def test_one_step_against_the_closed_form(self):
        r = self.report(EXAMPLES / "protocols" / "step1.csv", "--injury", 1.08, "--within", 0.02)["protocols"][0]
        day = [exact_day(1.14 / level, 1.14, 0.5, 1.3, 1.01) for level in (1.08, 1.02)]
        self.assertAlmostEqual(r["days_above_injury"], day[0], delta=1e-3)
        self.assertAlmostEqual(r["returned"], day[1], delta=2e-3)
        self.assertAlmostEqual(r["peak_lambda_e"], 1.14, delta=1e-12)
        with open(self.folder / "out" / "step1.csv", encoding="utf-8") as f:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
        for row in [r for r in rows[2::20] if r["day"] < 8]:  # the flow is exact at held stretch; the file has 8 digits
            self.assertAlmostEqual(exact_day(row["G"], 1.14, 0.5, 1.3, 1.01), row["day"], delta=1e-3)
        # Force by hand: sides free, c1 ln(lambda_e s^2) + c2 (s^2 - 1) = 0.
        s2 = rows[1]["lateral_stretch"]**2
        self.assertAlmostEqual(16 * math.log(1.14 * s2) + 4 * (s2 - 1), 0, delta=1e-5)
        self.assertAlmostEqual(rows[1]["force_per_reference_area"], 4 * (1.14**2 - s2) / 1.14, delta=1e-6)

    def test_more_steps_are_less_invasive(self):
        files = [EXAMPLES / "protocols" / f"{name}.csv" for name in ("step1", "step2", "step4", "step8", "continuous")]
        found = self.report(*files)["protocols"]
        for name in ("peak_lambda_e", "peak_force"):
            values = [p[name] for p in found]
            self.assertEqual(values, sorted(values, reverse=True))
        docs = (SOURCE / "docs" / "studies.md").read_text()
        for p in found:
            self.assertAlmostEqual(p["final_stretch"], 1.14, delta=1e-9)
            self.assertIn(f"| {p['title']} | {p['end_of_lengthening']:.2f} | {p['peak_lambda_e']:.4f} |", docs)

    def test_distraction(self):
        path = self.file("rest_length, 50\ndistract, 2, 5\nhold, 5\ndistract, -1, 4\n")
        r = self.report(path)["protocols"][0]
        self.assertAlmostEqual(max(r["run"]["stretch"]), 1.2, delta=1e-12)
        self.assertAlmostEqual(r["final_stretch"], 1.12, delta=1e-12)
        self.assertEqual(r["end_of_lengthening"], 5)

    def test_errors(self):
        self.assertIn("expected a file, or --design", self.run_it(status=2))
        self.check_errors([("set, tau, 1\n", "expected a row step, ramp, hold or distract"),
                           ("ramp, 1.1\n", "study.csv:1:10: expected a time in days, a number > 0, found nothing"),
                           ("hold, -1\n", "study.csv:1:7: expected a time in days, a number > 0, found '-1'")])


class Design(Job):
    program = "study_protocol"

    def test_rides_the_limit(self):
        for gamma in (0, 0.5, 1, 2, 3.5):
            with self.subTest(gamma=gamma):
                r = self.report("--design", 1.14, "--limit", 1.05, "--set", f"gamma={gamma}", "--set", "G_max=1.2")
                self.assertLess(r["peak"], 1.05 + 2e-6)
                self.assertLess(r["G_off"], 2e-6)
                self.assertLessEqual(r["step_peak"], 1.05 + 1e-9)
                # Others that are admissible take longer.
                self.assertGreater(r["ramp_days"], r["days"])
                self.assertGreaterEqual(r["step_days"], r["days"])
                arrived = next(t for t, x in zip(r["run"]["time"], r["run"]["stretch"]) if x >= 1.14 - 1e-12)
                self.assertAlmostEqual(arrived, r["days"], delta=1e-9)

    def test_closed_form_against_quadrature(self):
        """T = integral of dG/(k_g(G) (m - lambda_crit)) from 1 to target/m, by Simpson's rule."""
        r = self.report("--design", 1.2, "--limit", 1.06, "--set", "gamma=2.5", "--set", "G_max=1.3", "--set", "tau=3")
        n, end = 2000, 1.2 / 1.06
        values = [3 / (((1.3 - (1 + (end - 1) * i / n)) / 0.3)**2.5 * 0.05) for i in range(n + 1)]
        simpson = (values[0] + values[-1] + 4 * sum(values[1:-1:2]) + 2 * sum(values[2:-1:2])) * (end - 1) / n / 3
        self.assertAlmostEqual(r["days"] / simpson, 1, delta=1e-8)

    def test_schedule(self):
        self.report("--design", 1.2, "--limit", 1.06, "--set", "tau=3", "--set", "G_max=1.3", "--rest-length", 250)
        with open(self.folder / "out" / "schedule.csv", encoding="utf-8") as f:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
        for way in ("fastest", "steps"):
            self.assertAlmostEqual(sum(r[way + "_mm_this_day"] for r in rows), 50, delta=0.01)
            self.assertAlmostEqual(rows[-1][way + "_stretch"], 1.2, delta=1e-6)
        self.assertTrue(all(r["steps_stretch"] <= r["fastest_stretch"] + 1e-6 for r in rows))

    def test_out_of_reach(self):
        text = self.run_it("--design", 1.2, "--limit", 1.05, status=1)  # G_max = 1.1
        self.assertIn("No protocol reaches stretch 1.2 with lambda_e <= 1.05", text)
        self.assertIn("1.155", text)
        self.assertIn("--limit = 1.005: expected more than 1 and than lambda_crit = 1.01",
                      self.run_it("--design", 1.2, "--limit", 1.005, status=2))
        self.assertIn("expected --limit LAMBDA_E", self.run_it("--design", 1.2, status=2))


class Sensitivity(Job):
    program = "study_sensitivity"

    def test_near_the_middle_all_agree(self):
        """In narrow ranges the outputs are linear: Sobol's indices follow from the dual numbers' derivatives, and these
        from differences."""
        centre = {"tau": 0.5, "gamma": 2, "G_max": 1.1, "lambda_crit": 1.01, "ramp": 1, "c1": 16, "c2": 4}
        half = {"tau": 0.01, "gamma": 0.04, "G_max": 2e-4, "lambda_crit": 1e-4, "ramp": 0.02, "c1": 0.3, "c2": 0.005}
        ranges = [a for k, x in centre.items() for a in ("--range", f"{k}={x - half[k]!r}:{x + half[k]!r}")]
        r = self.report(*ranges, "--histories", 45000, "--threads", 2)
        peak_row = r["lambda_e"].index(max(r["lambda_e"]))
        places = (0, peak_row, "relative_lambda_e"), (1, -1, "relative_lambda_e"), (2, peak_row, "relative_force")
        for output, row, local in places:
            y = r["middle"][output]
            slopes = [r[local][i][row] * y / centre[name] for i, name in enumerate(r["names"])]
            variances = [(s * half[name])**2 / 3 for s, name in zip(slopes, r["names"])]
            found = r["global"][output]
            self.assertAlmostEqual(found["sd"] / math.sqrt(sum(variances)), 1, delta=0.05)
            for i, name in enumerate(r["names"]):
                with self.subTest(output=output, name=name):
                    ends = r["tornado"][i]
                    difference = (ends["high"][output] - ends["low"][output]) / (2 * half[name])
                    self.assertAlmostEqual(difference, slopes[i], delta=2e-3 * abs(slopes[i]) + 1e-6)
                    index = found["indices"][i]
                    self.assertAlmostEqual(index["first"], variances[i] / sum(variances), delta=0.05)
                    self.assertAlmostEqual(index["total"], variances[i] / sum(variances), delta=0.05)
                    self.assertLessEqual(index["total_interval"][0], index["total"])
                    self.assertGreaterEqual(index["total_interval"][1], index["total"])
            # Stresses scale with c1 and c2 together, time with tau and the ramp until the peak.
            if output != 1:
                self.assertAlmostEqual(slopes[0] * centre["tau"], -slopes[4] * centre["ramp"], delta=1e-4)
            self.assertAlmostEqual(slopes[5] * 16 + slopes[6] * 4, y if output == 2 else 0, delta=1e-6)

    def test_wide_ranges(self):
        r = self.report("--histories", 9000, "--threads", 2)
        self.assertLess(max(r["off"][:2]), 1.5e-3)
        again = self.report("--histories", 9000, "--threads", 1)
        self.assertEqual(r["global"], again["global"])  # whatever the threads
        for g in r["global"]:
            self.assertLess(sum(i["first"] for i in g["indices"]), 1.1)
            self.assertGreater(sum(i["total"] for i in g["indices"]), 0.9)

    def test_errors(self):
        for arguments, message in ((("--range", "tau=2"), "--range tau=2: expected NAME=LOW:HIGH"),
                                   (("--range", "G_max=0.9:1.2"), "--range G_max=0.9:1.2: expected 1 < LOW < HIGH"),
                                   (("--days", 1), "--days: expected more than the longest ramp"),
                                   (("a.csv",), "'a.csv': no file is read")):
            self.assertIn(message, self.run_it(*arguments, status=2))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
