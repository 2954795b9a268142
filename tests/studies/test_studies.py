"""The programs behind ./run fit, protocol and sensitivity, on small cases.

test_studies.py SOURCE PROGRAMS [unittest arguments]
"""
import csv
import fcntl
import json
import math
import os
import pathlib
import re
import resource
import signal
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

    def run_limited(self, command, most_bytes, stdout=subprocess.PIPE):
        """Runs a program whose files may have so many bytes, as if the disk were full then. Its status and its errors."""
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
        done = subprocess.run([*map(str, command)], stdout=stdout, stderr=subprocess.PIPE, text=True, preexec_fn=limit)
        return done.returncode, done.stderr

    def check_writing(self, *arguments, slow=None):
        """Whatever cannot be written is named with its reason, and the status is not 0. With the arguments `slow` it takes
        minutes, which shows that the folder is tried before the first step."""
        command = [PROGRAMS / self.program, *arguments, "--out"]
        out, taken = self.folder / "out", self.file("", "taken")
        for most in (3000, 0):
            status, errors = self.run_limited([*command, out], most)
            self.assertEqual(status, 2, errors)
            self.assertRegex(errors, r"out(/[a-z0-9.]+)?: cannot be written( in)?: File too large\n$")
        for folder, message in ((taken, "taken: cannot be made a folder: Not a directory"),
                                (taken / "under", "under: cannot be made a folder: Not a directory"),
                                (self.folder / ("n" * 300), "nnn: cannot be made a folder: File name too long")):
            slowly = [command[0], *(slow or arguments), "--out", folder]
            done = subprocess.run([*map(str, slowly)], capture_output=True, text=True, timeout=10)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertIn(message, done.stderr)
        with open("/dev/full", "wb") as full:
            status, errors = self.run_limited([*command, out], resource.RLIM_INFINITY, stdout=full)
        self.assertEqual(status, 2)
        self.assertIn("standard output: cannot be written: No space left on device", errors)
        self.assertGreater((out / "report.json").stat().st_size, 1000)
        closed = subprocess.run(["sh", "-c", '"$@" >&-', "sh", *map(str, command), out], capture_output=True, text=True)
        self.assertEqual(closed.returncode, 2)
        self.assertIn("standard output: cannot be written: Bad file descriptor", closed.stderr)

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

    def test_removal_amplitude_and_several_files(self):
        """Two histories with cycles, made with known values, give these back; neither does by itself."""
        sets = ("set, tau, 2\nset, G_max, 1.5\nset, tau_rev, 6\nset, gamma_rev, 1\nset, G_min, 0.4\nset, lambda_crit_rev, 0.99\n"
                "fit, tau, 0.1, 50\nfit, tau_rev, 0.1, 50\nfit, amplitude, 0.2, 3\n")
        histories = ("step, 0.9\ncycle, 1.3, 6, 1, 2\nmeasure, 1.1, G, 1, 0.001\nmeasure, 2, lambda_e, 1, 0.001\n",
                     "step, 1.2\nhold, 20\nmeasure, 1, G, 1, 0.001\nmeasure, 4, G, 1, 0.001\nmeasure, 20, G, 1, 0.001\n")
        truth = (("--set", "tau=1.5"), ("--set", "tau_rev=4"))
        files = []
        for i, history in enumerate(histories):
            made = self.report(self.file(sets + history), "--starts", 1, *(w for t in truth for w in t))
            self.assertNotIn("null", str(made["chi2"]))
            plain = "\n".join(r for r in sets.splitlines() if not r.startswith("fit")) + "\n" + history
            made = self.report(self.file(plain), *(w for t in truth for w in t))["measurements"]
            rows = history[:history.index("measure")] + "".join(
                f"measure, {m['day']!r}, {m['quantity']}, {m['computed']!r}, 0.001\n" for m in made)
            files.append(self.file(("" if i else sets) + rows, f"history{i}.csv"))
        r = self.report(*files, "--starts", 1)
        self.assertLess(r["chi2"], 1e-6)
        for p, expected in zip(r["parameters"], (1.5, 4, 1)):
            self.assertAlmostEqual(p["estimate"] / expected, 1, delta=2e-3)
        self.assertIn("Not used: the rows 'set' and 'fit' of history0", self.run_it(files[1], files[0]))

    def test_design_of_an_experiment(self):
        """The power asked for is the power that the simulation finds, and less difference needs more subjects."""
        plan = EXAMPLES / "identification" / "plan.csv"
        found = []
        for against in (14, 2):
            text = self.run_it(plan, "--design", 1, "--against", f"tau={against}", "--coverage", 60)
            self.assertIn(f"tau = 0.5 against {against}", text)
            found.append(json.loads((self.folder / "out" / "design.json").read_text()))
            self.assertGreater(found[-1]["told"], 0.78)
        self.assertLess(found[0]["subjects"], found[1]["subjects"])
        for arguments, message in ((("--against", "tau=0.5"), "--against tau=0.5: expected NAME=VALUE, a value from 0.05 to 100"),
                                   (("--against", "G_max=2"), "NAME one of those to be fitted"),
                                   ((), "--against: expected only with --design, and --against with it")):
            self.assertIn(message, self.run_it(plan, "--design", 1, *arguments, status=2))

    def test_cycles_are_steps_and_holds(self):
        sets = "set, tau_rev, 6\nset, gamma_rev, 1\nset, G_min, 0.4\nset, lambda_crit_rev, 0.99\nstep, 0.9\n"
        end = "measure, 2, G, 1, 0.001\nmeasure, 4, G, 1, 0.001\n"
        rows = "step, 1.1\nhold, 0.25\nstep, 0.9\nhold, 1.75\n"
        found = [self.report(self.file(sets + text + end))["measurements"] for text in ("cycle, 1.1, 6, 2, 4\n", 2 * rows)]
        self.assertEqual(*found)

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

    def test_a_fit_without_a_result(self):
        """With tau near 1e-260 the rate's derivative is beyond all numbers."""
        text = self.run_it(self.file("fit, tau, 1e-300, 1\nset, gamma, 300\nramp, 2, 1.1\nmeasure, 3, G, 1, 0.01\n"),
                           "--starts", 5, status=2)
        self.assertRegex(text, r"error: no fit from tau = 1.4\d+e-260, gamma = 300, .*: expected narrower bounds")
        self.assertNotIn("Residual", text)

    def test_growth_to_its_end_with_gamma_below_one(self):
        """Where gamma < 1, G reaches G_max in finite time: the fit ends there, and says that gamma is open."""
        r = self.report(self.file("fit, gamma, 0.5, 1\nfit, G_max, 1.01, 1.05\nramp, 2, 1.1\nramp, 10, 3\n"
                                  "measure, 3, G, 1, 1e-6\n"), "--starts", 2)
        self.assertAlmostEqual(r["values"][2], 1.01, places=12)
        self.assertTrue(any("do not bound gamma" in w for w in r["warnings"]), r["warnings"])

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
            ("step, 1.1\nmeasure, 3, sigma, 1.02, 1\n", "study.csv:2:13: expected lambda_e, G or tendon, found 'sigma'"),
            ("step, 1.1\nmeasure, 3, G\n", "study.csv:2:14: expected a value, a number > 0, found nothing"),
            ("step, 1.1, 3\n", "study.csv:1:12: expected the end of the row, found '3'"),
            ("jump, 1.1\n", "study.csv:1:1: expected title, include, set, fit"),
            ("set, G_max, 0.9\n", "study.csv:1:13: G_max = 0.9: largest relative serial sarcomere number, must be finite and > 1"),
            ("set, tua, 0.9\n", "study.csv:1:6: expected a parameter: c1, c2, tau"),
            ("fit, tau, 3, 2\n", "study.csv:1:14: expected an upper bound, a number > 3, found '2'"),
            ("fit, c1, 3, 4\n", "study.csv:1:6: expected tau, gamma, G_max, lambda_crit, tau_rev, gamma_rev, G_min, lambda_crit_rev or amplitude, found"),
            ("include, nowhere.csv\n", "study.csv:1:10: expected the name of a file that can be read"),
            ("distract, 1, 3\n", "study.csv:1:1: expected a row 'rest_length, MM' before 'distract'"),
            ("step, 1.1\n", "study.csv: expected a row 'measure"),
            ("cycle, 1.1, 24, 1, 5\n", "study.csv:1:13: expected less than EVERY, 24 hours, found 24"),
            ("cycle, 1.1, 2, 2, 5\n", "study.csv:1:19: expected a multiple of EVERY, 2 days, found 5"),
            ("cycle, 1.1, 0.001, 0.001, 1000000\n", "study.csv:1:27: expected at most 250000 cycles"),
            ("step, 1.1\ntendon, 1, 100, 0\nmeasure, 3, G, 1.02, 1\n", "study.csv:2:1: expected no tendon: ./run fit is of muscle"),
            ("step, 1.1\nmeasure, 3, tendon, 1.02, 1\n", "study.csv: expected no measurement of a tendon"),
            ("fit, tau_rev, 1, 4\nstep, 0.9\nmeasure, 3, G, 0.99, 1\n", "study.csv:1:1: expected tau_rev > 0 to be set"),
            ("fit, amplitude, 2, 4\nstep, 0.9\nmeasure, 3, G, 0.99, 1\n", "study.csv:1:1: expected bounds of the amplitude that include 1"),
            ("fit, amplitude, 0, 20\nstep, 0.9\nmeasure, 3, G, 0.99, 1\n", "with amplitude = 20 the stretch 0.9 becomes -1"),
        ])
        good = self.file("step, 1.1\nmeasure, 3, G, 1.02, 1\n")
        self.assertIn("no option '--strats'", self.run_it(good, "--strats", 3, status=2))
        self.assertIn("--starts = 1.5: expected a whole number", self.run_it(good, "--starts", 1.5, status=2))
        for name, reason in (("nowhere.csv", "No such file or directory"), (self.folder, "Is a directory"),
                             (good / "study.csv", "Not a directory")):
            self.assertIn(f"{name}: cannot be read: {reason}", self.run_it(name, status=2))

    def test_parameters_are_those_of_the_umat(self):
        removal = "set, tau_rev, 1\nset, gamma_rev, 2\nset, G_min, 0.5\nset, lambda_crit_rev, "
        end = "step, 1.1\nmeasure, 3, G, 1.02, 1\n"
        self.check_errors([
            ("set, c1, -100\n" + end, "study.csv:1:10: c1 = -100: first Lame constant, must be finite and > -2/3 c2"),
            ("set, c1, -3\n" + end, "study.csv:1:10: c1 = -3: "),
            ("set, G_min, 1\n" + end, "study.csv:1:13: G_min = 1: "),
            ("set, lambda_rev, 1\n" + end, "study.csv:1:6: expected a parameter: c1, c2, tau, gamma, G_max, lambda_crit, tau_rev, "
             "gamma_rev, G_min, lambda_crit_rev, found 'lambda_rev'"),
            (removal + "1.5\n" + end, "study.csv:4:23: lambda_crit_rev = 1.5: elastic fibre stretch below which sarcomeres are"),
            ("set, tau_rev, 1\nset, gamma_rev, 2\nset, lambda_crit_rev, 1\n" + end,
             "study.csv:1:15: tau_rev = 1: expected G_min to be set too"),
            ("set, G_min, 0.5\n" + end, "study.csv:1:13: expected tau_rev to be set too: without it nothing is removed"),
            (removal + "1\nfit, lambda_crit, 0.98, 1.04\n" + end,
             "study.csv:5:1: with lambda_crit = 0.98: lambda_crit_rev = 1: "),
            ("fit, tau, -1, 3\n" + end, "study.csv:1:1: tau = -1: time constant of growth, must be finite and > 0"),
            ("fit, G_max, 1, 3\n" + end, "study.csv:1:1: G_max = 1: "),
            ("set, tau, 50\nfit, tau, 0.1, 5\n" + end,
             "study.csv:1:11: tau = 50: expected a start within the bounds of its fit, 0.1 to 5"),
        ])
        good = self.file("set, c1, -3\nset, c2, 6\n" + end)  # allowed together, whichever row is first
        self.run_it(good)
        for value, message in (("tau=-1", "tau = -1: time constant of growth, must be finite and > 0"), ("c2=4", "c1 = -3: "),
                               ("tau=nan", "expected a number, found 'nan'"), ("tau=", "expected a number, found ''"),
                               ("tau=0,5", "expected a number, found '0,5': decimal comma? write 0.5"),
                               ("tau_rev=1", "tau_rev = 1: expected gamma_rev to be set too"),
                               ("n0_1=1", "--set n0_1=1: expected NAME=VALUE, NAME one of c1, c2"), ("tau", "expected NAME=VALUE")):
            with self.subTest(value):
                self.assertIn(message, self.run_it(good, "--set", value, status=2))
        bounds = self.file("fit, gamma, 0.1, 1\n" + end)  # the default, 2, is no start of ours
        self.run_it(bounds, "--starts", 1)
        self.assertIn("study.csv:1:1: with --coverage or --design gamma = 2", self.run_it(bounds, "--coverage", 3, status=2))

    def test_includes(self):
        self.file("include, c.csv\n", "b.csv")
        self.file("include, ./study.csv\n", "c.csv")
        (self.folder / "link.csv").symlink_to(self.folder / "study.csv")
        self.check_errors([
            ("# itself\ninclude, study.csv\n", "study.csv:2:10: expected the name of a file that can be read, found 'study.csv': a circle"),
            ("include, link.csv\n", "found 'link.csv': a circle, "),
            ("include, b.csv\n", "/c.csv:1:10: expected the name of a file that can be read, found './study.csv': a circle, "),
            ("include, .\n", "/.: cannot be read: Is a directory"),
            ("include, nowhere.csv\n", "/nowhere.csv: cannot be read: No such file or directory"),
        ])
        chain = self.run_it(self.file("include, b.csv\n"), status=2).split("a circle, ")[1]
        self.assertEqual([pathlib.Path(name).name for name in chain.strip().split(" -> ")],
                         ["study.csv", "b.csv", "c.csv", "study.csv"])
        for i in range(120):
            self.file(f"include, deep{i + 1}.csv\n", f"deep{i}.csv")
        self.assertIn("more than 100 files, each included by the one before", self.run_it(self.folder / "deep0.csv", status=2))
        for i in range(9):  # 8**9 rows
            self.file(f"include, wide{i + 1}.csv\n" * 8, f"wide{i}.csv")
        self.file("hold, 1\n", "wide9.csv")
        self.assertIn("more than 100000 rows, with those of included files", self.run_it(self.folder / "wide0.csv", status=2))

    def test_what_is_said_twice(self):
        self.file("title, inner\nset, tau, 3\n", "inner.csv")
        end = "step, 1.1\nmeasure, 3, G, 1.02, 1\n"
        self.check_errors([
            ("set, tau, 1\nset, gamma, 1\nset, tau, 2\n" + end, "study.csv:3:1: set, tau was already given, in "),
            ("fit, tau, 1, 2\nfit, tau, 1, 3\n" + end, "study.csv:2:1: fit, tau was already given"),
            ("title, a\ntitle, b\n" + end, "study.csv:2:1: the title was already given"),
            ("set, tau, 1\ninclude, inner.csv\n" + end, "inner.csv:2:1: set, tau was already given, in "),
            (end + "measure, 3.0, G, 1.02, 1\n", "study.csv:3:1: the measurement of G = 1.02 on day 3 was already given"),
        ])
        r = self.report(self.file("include, inner.csv\ntitle, outer\nset, tau, 0.5\n" + end + "measure, 3, G, 1.03, 1\n"))
        self.assertEqual((r["title"], r["values"][0], len(r["measurements"])), ("outer", 0.5, 2))
        good = self.file(end)
        self.assertIn("--seed: expected only once", self.run_it(good, "--seed", 3, "--seed", 4, status=2))
        self.assertIn("expected only once", self.run_it(good, "--set", "tau=3", "--set", "tau=3", status=2))

    def test_limits(self):
        end = "measure, 3, G, 1.02, 1\n"
        far = "".join(f"ramp, {x}, 1\n" for _ in range(12) for x in (100, 0.01))
        self.check_errors([
            ("hold, 1e-300\n" + end, "study.csv:1:7: expected a time in days from 1e-06 to 1000000, found '1e-300'"),
            ("hold, 1e16\n" + end, "study.csv:1:7: expected a time in days from 1e-06 to 1000000, found '1e16'"),
            ("hold, 9e5\nhold, 9e5\n" + end, "study.csv:2:7: leads to day 1800000: expected at most 1000000"),
            ("step, 1e6\n" + end, "study.csv:1:7: expected a stretch from 0.01 to 100, found '1e6'"),
            ("rest_length, 10\ndistract, 1e300, 1e6\n" + end, "study.csv:2:11: leads to stretch 1e+305: expected 0.01 to 100"),
            ("rest_length, 10\ndistract, -1, 10\n" + end, "study.csv:2:11: leads to stretch 0: expected 0.01 to 100"),
            (far + end, "study: the history takes more than 1000000 time steps, by day "),
            ("step, 1.1\nmeasure, 1e16, G, 1, 1\n", "study.csv:2:10: expected a time in days, a number from 0 to 1000000"),
            ("step, 1.1\nmeasure, -1, G, 1, 1\n", "study.csv:2:10: expected a time in days, a number from 0 to 1000000, found '-1'"),
            ("step, 1.1\nmeasure, 1, G, 1, 1e-300\n", "study.csv:2:19: expected a standard deviation from 1e-06 to 1000"),
            ("step, 0x2\n" + end, "study.csv:1:7: expected a stretch, a number > 0, found '0x2'"),
            ("step, nan\n" + end, "study.csv:1:7: expected a stretch, a number > 0, found 'nan'"),
            ("ramp, 1,1\n" + end, "study.csv:1:7: two numbers or one? write '1, 1' or '1.1'"),
            ("", "study.csv: has no rows"),
            ("# no row\n,,,\n", "study.csv: has no rows"),
            ("set, tau, 1\n" + end, "study.csv: expected a row step, ramp, hold, distract or cycle"),
            ("title, a\x1b[2J\n" + end, "study.csv:1:8: expected a text in UTF-8 without control characters, found 'a\\x1b[2J'"),
        ])
        good = self.file("step, 1.1\n" + end)
        for arguments, message in (
                (("--starts", "1e300"), "--starts = 1e300: expected a whole number from 1 to 10000"),
                (("--starts", 0), "--starts = 0: expected a whole number from 1 to 10000"),
                (("--coverage", "1e9"), "--coverage = 1e9: expected a whole number from 1 to 1000000"),
                (("--seed", -1), "--seed = -1: expected a whole number from 0"),
                (("--robust", "nan"), "--robust = nan: expected a number"), (("--robust", "-1"), "--robust = -1: expected a number"),
                (("--robust", ""), "--robust: expected a value after it"), (("--set", "--seed"), "--set: expected a value after it"),
                (("-x",), "no option '-x'"), ((good,), "study.csv: expected each file only once")):
            with self.subTest(arguments):
                self.assertIn(message, self.run_it(good, *arguments, status=2))
        self.file("step, 1.1\n" + end).write_bytes("step, 1.1\n".encode("utf-16"))
        self.assertIn("study.csv: is a file in UTF-16", self.run_it(good, status=2))

    def test_what_spreadsheets_write_is_read(self):
        text = "title,Z\u00f6llner; 1,5 mm $x$ | y,,,\r\n,,,,\r\nstep,1.1,,,\r\nmeasure,3,G,1.02,1\r\n"
        path = self.folder / "study.csv"
        path.write_bytes(b"\xef\xbb\xbf" + text.encode())
        self.assertEqual(self.report(path)["title"], "Z\u00f6llner; 1,5 mm $x$ | y")

    def test_says_where_a_fit_ends(self):
        """tau = 0.05 between 1e-6 and 1e6 is far from both bounds, which are divided by factors."""
        numbers = [1.01, 1.03, 1.05, 1.07, 1.08]
        measured = "".join(f"measure, {exact_day(G, 1.1, 0.05, 1.1, 1.01)!r}, G, {G}, 0.001\n" for G in numbers)
        for bounds, at_bound in (("1e-6, 1e6", False), ("0.1, 1e6", True), ("1e-6, 0.01", True), ("0.04, 0.06", False)):
            with self.subTest(bounds):
                r = self.report(self.file(f"fit, tau, {bounds}\nstep, 1.1\n" + measured))
                self.assertEqual(any("tau ends at a bound" in w for w in r["warnings"]), at_bound, r["warnings"])
                if not at_bound:
                    self.assertAlmostEqual(r["values"][0], 0.05, delta=5e-4)
                    self.assertEqual(r["warnings"], [])

    def test_says_that_its_time_steps_are_too_long(self):
        for tau, too_long in ((0.5, False), (2e-4, True)):
            day = exact_day(1.05, 1.1, tau, 1.1, 1.01)
            r = self.report(self.file(f"set, tau, {tau}\nstep, 1.1\nmeasure, {day!r}, G, 1.05, 0.0001\n"))
            self.assertEqual(any("time steps are too long" in w for w in r["warnings"]), too_long, r["warnings"])

    def test_an_estimate_at_zero_has_a_profile(self):
        """No gamma is small enough for this growth: the estimate is its lower bound, 0."""
        r = self.report(self.file("set, tau, 8\nset, G_max, 1.2\nfit, gamma, 0, 8\nstep, 1.2\nhold, 4\nmeasure, 4, G, 1.15, 0.01\n"))
        p = r["parameters"][0]
        self.assertAlmostEqual(p["estimate"], 0, delta=1e-9)
        self.assertIsNone(p["lower"])
        self.assertTrue(all(x is not None for x in p["profile_x"]))
        self.assertLess(0, p["upper"])

    def test_says_that_the_history_is_shorter(self):
        for history, shorter in (("ramp, 1.1, 2", True), ("step, 1.1", False), ("step, 1.1\nhold, 3", False)):
            r = self.report(self.file(history + "\nmeasure, 3, G, 1.02, 1\n"))
            self.assertEqual(any("The history ends on day 2" in w for w in r["warnings"]), shorter, r["warnings"])

    def test_a_measurement_just_before_the_end(self):
        """It has a time step of its own, however long the history is."""
        late = self.report(self.file("step, 1.1\nhold, 1e6\nmeasure, 999999.9995, G, 1.02, 1\n"))
        last = self.report(self.file("step, 1.1\nhold, 1e6\nmeasure, 1e6, G, 1.02, 1\n"))
        self.assertAlmostEqual(late["measurements"][0]["computed"], last["measurements"][0]["computed"], delta=1e-9)

    def test_writing(self):
        path = EXAMPLES / "identification" / "published" / "zollner_2012.csv"
        self.check_writing(path, "--starts", 1, slow=(path, "--starts", 10000))

    def test_pictures(self):
        out = self.folder / "out"
        command = [sys.executable, EXAMPLES / "common" / "pictures.py", "fit", PROGRAMS / self.program,
                   EXAMPLES / "identification" / "example.csv", "--starts", "1", "--out", out]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("fit.png", "profiles.png", "report.md"):
            self.assertGreater((out / name).stat().st_size, 1000)
        # What is left when something fails is of no earlier run.
        status, errors = self.run_limited(command, 20000)
        self.assertEqual(status, 1)
        self.assertRegex(errors, r"pictures.py: .*/(fit|profiles).png: cannot be written: File too large\n$")
        self.assertFalse((out / "profiles.png").exists())
        with open("/dev/full", "wb") as full:
            status, errors = self.run_limited(command, resource.RLIM_INFINITY, stdout=full)
        self.assertEqual((status, errors.splitlines()[-1]),
                         (1, "pictures.py: standard output cannot be written: No space left on device"))
        command[4:5] = [self.file("title, $\\x$ | $5\nstep, 1.1\nmeasure, 3, G, 1.02, 1\n", "dollars.csv")]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = subprocess.run([*command[:2], "validate", command[3], "a/x.csv", "b/x.csv"], capture_output=True, text=True,
                              cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr), (1, "pictures.py: validate: expected files, each of another name\n"))


class Published(Job):
    program = "study_fit"

    def test_every_file_says_what_is_a_figure_and_what_ours(self):
        paths = sorted((EXAMPLES / "identification" / "published").rglob("*.csv"))
        self.assertGreater(len(paths), 20)
        for path in paths:
            text = path.read_text()
            comments = "".join(line for line in text.splitlines() if line.startswith("#"))
            with self.subTest(path.name):
                self.assertRegex(comments, r"[12][0-9]{3}|[Ss]ource")
                self.assertRegex(comments, "Ours|Not used|Source and doubts")
                if path.parent.name in ("muscle", "shape", "tendon", "cross_section", "not_used"):
                    self.assertRegex(comments, "Figures?:")
                    self.assertIn("Stimulus", comments)

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


class Evidence(Job):
    program = "study_evidence"

    def test_areas_are_those_of_the_docs(self):
        folder = EXAMPLES / "identification" / "published" / "cross_section"
        r = self.report("--area", folder / "defreitas_2011.csv", "--predict", folder / "seynnes_2007.csv", "--predict",
                        folder / "damas_2016.csv")
        docs = (SOURCE / "docs" / "evidence.md").read_text(encoding="utf-8")
        self.assertIn(f"τ = {r['tau']:.3g} d, overload {r['overload']:.3f}", docs)
        for s in r["studies"][1:]:
            for day, y in list(zip(s["day"], s["computed"]))[1:]:
                self.assertRegex(docs, rf"\| {s['name']} \| {day:g} \| [^|]* \| {y:.3f} \|")

    def test_areas_that_are_known(self):
        """Areas made by the law itself, in the closed form of eq. 4 with gamma = 2, give the parameters back."""
        tau, overload = 20, 1.3
        rows = "".join(f"area, {exact_day(g, overload, tau, 1.5, 1)!r}, {g}, 0.001\n" for g in (1.02, 1.05, 1.1, 1.2))
        r = self.report("--area", self.file("area, 0, 1, 0.001\n" + rows))
        self.assertAlmostEqual(r["tau"] / tau, 1, delta=1e-3)
        self.assertAlmostEqual(r["overload"], overload, delta=1e-3)

    def test_extensions_of_the_law(self):
        """Laws with more parameters are no worse, growth only gives back what it made, and ./run fit computes the same."""
        grown = exact_day(1.1, 1.2, 0.8, 1.6, 1.01)
        base = self.file("set, G_max, 1.6\nset, tau_rev, 0.8\nset, gamma_rev, 0\nset, G_min, 0.4\nset, lambda_crit_rev, 1\nstep, 1.2\n"
                         "hold, 5\n", "base.csv")
        growing = self.file(f"step, 1.2\nhold, 5\nmeasure, {grown!r}, G, 1.1, 0.001\n", "growing.csv")
        r = self.report("--extensions", base, growing)
        self.assertAlmostEqual(r["laws"][0]["values"][0] / 0.8, 1, delta=2e-3)
        casts = self.file("step, 0.9\ncycle, 1.2, 1, 1, 3\nhold, 2\nmeasure, 3, G, 1.02, 0.01\nmeasure, 5, G, 0.93, 0.01\n", "casts.csv")
        r = self.report("--extensions", base, growing, casts)
        laws = {law["name"]: law for law in r["laws"]}
        within = (("growth and removal, one rate", "two rates"), ("growth and removal, one rate", "one rate, which saturates"),
                  ("two rates", "two rates and lambda_crit_rev"), ("two rates", "two rates, which saturate"))
        for small, large in within:
            self.assertLess(laws[large]["chi2"], 1.02 * laws[small]["chi2"] + 1e-3, large)
        two = dict(zip(laws["two rates"]["parameters"], laws["two rates"]["values"]))
        self.program = "study_fit"
        again = self.report(self.file(f"include, base.csv\nset, tau, {two['tau']}\nset, tau_rev, {two['tau_rev']}\nmeasure, 5, G, 1, 1\n",
                                      "again.csv"), growing, casts)
        for m, y in zip(again["measurements"][1:], laws["two rates"]["computed"], strict=True):
            self.assertAlmostEqual(m["computed"], y, delta=2e-3)

    def test_the_docs_have_the_laws_that_are_compared(self):
        docs = (SOURCE / "docs" / "evidence.md").read_text(encoding="utf-8")
        path = EXAMPLES / "identification" / "published" / "muscle" / "burkholder_1998.csv"
        r = self.report("--extensions", EXAMPLES / "identification" / "dose.csv", path, "--set", "tau=0.5")
        table = docs.split("<!-- dose: written")[1]
        for law in r["laws"]:
            name = law["name"].replace("tau as set", "τ = 0.5 d held").replace("lambda_crit_rev", "λ_crit_rev")
            self.assertIn(f"| {name}", table)

    def test_the_regions_stretches_are_those_of_the_muscle(self):
        page = (SOURCE / "docs" / "muscle.md").read_text(encoding="utf-8")
        day_42 = page.split("| 42 | flow | 120.6 |")[1].splitlines()
        for row, name in ((day_42[1], "central"), (day_42[2], "distal")):
            cells = [c.strip() for c in row.strip("|").split("|")]
            self.assertEqual(cells[3], {"central": "middle", "distal": "distal"}[name])
            text = (EXAMPLES / "identification" / "published" / "shape" / f"biceps_femoris_{name}.csv").read_text()
            stretch = float(re.search(r"^ramp, ([0-9.]+), 63$", text, re.M).group(1))
            self.assertAlmostEqual(stretch, float(cells[5]) * float(cells[8]), delta=1e-4)

    def test_tables_are_put_between_their_marks(self):
        sys.path.insert(0, str(EXAMPLES / "identification"))
        import evidence
        page = self.file("a\n<!-- x: written by ./run evidence --write -->\nold\n<!-- end of x -->\nb\n", "page.md")
        evidence.write(page, {"x": ["| new |"]})
        self.assertEqual(page.read_text(), "a\n<!-- x: written by ./run evidence --write -->\n\n| new |\n\n<!-- end of x -->\nb\n")
        with self.assertRaisesRegex(Exception, "expected one pair of the marks of 'y'"):
            evidence.write(page, {"y": []})
        docs = (SOURCE / "docs" / "evidence.md").read_text(encoding="utf-8")
        for name in ("comparisons", "time constants", "left open", "tendon", "cycles", "dose", "areas"):
            self.assertEqual(docs.count(f"<!-- {name}: written by ./run evidence --write -->"), 1)

    def test_tendon_that_is_known(self):
        rows = ("set, G_max, 1.6\nset, lambda_crit, 1.05\nset, tau_rev, 1\nset, gamma_rev, 0\nset, G_min, 0.5\n"
                "set, lambda_crit_rev, 1.05\nset, tau, 1\ntendon, 1, 1e5, 1\nstep, 1.3\nhold, 20\n")
        r = self.report(self.file(rows + "measure, 3, G, 1.15, 0.01\nmeasure, 20, tendon, 1.1, 0.01\n"))
        everything = r["cases"][2]
        self.assertLess(everything["chi2"], 1e-6)
        self.assertAlmostEqual(everything["computed"][0], 1.15, delta=1e-4)
        self.assertAlmostEqual(everything["computed"][1], 1.1, delta=1e-4)

    def test_errors(self):
        self.assertIn("expected one of FILE.csv, --dose, --area and --extensions", self.run_it(status=2))
        self.assertIn("expected a row 'tendon'", self.run_it(self.file("step, 1.1\n"), status=2))
        self.assertIn("study.csv:1:1: expected the keyword 'area'", self.run_it("--area", self.file("aera, 0, 1, 1\n"), status=2))
        self.assertIn("study.csv:1:7: expected day 0 first", self.run_it("--area", self.file("area, 3, 1, 1\n"), status=2))


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

    def test_distraction_with_an_aponeurosis(self):
        """A tendon row: fibres and tendon share the lengthening, a tendon that creeps gives way, one that is rigid does not."""
        history = "rest_length, 50\ndistract, 1, 20\nhold, 10\n"
        found = {}
        for name, row in (("none", ""), ("rigid", "tendon, 0.5, 1e9, 0\n"), ("elastic", "tendon, 0.5, 5, 0\n"),
                          ("creeps", "tendon, 0.5, 5, 2\n")):
            found[name] = self.report(self.file(row + history))["protocols"][0]
            run = found[name]["run"]
            for stretch, tendon, day in list(zip(run["stretch"], run["tendon"], run["time"]))[1::50]:
                total = stretch + (0.5 if row else 0) * (tendon - 1)
                self.assertAlmostEqual(total, 1 + min(day, 20) / 50, delta=2e-8)
        self.assertAlmostEqual(found["rigid"]["final_G"], found["none"]["final_G"], delta=1e-7)
        self.assertLess(found["elastic"]["peak_force"], found["rigid"]["peak_force"])
        self.assertLess(found["creeps"]["final_lambda_e"], found["elastic"]["final_lambda_e"] - 1e-3)
        self.assertGreater(found["creeps"]["final_tendon"], 1.02)
        self.assertAlmostEqual(found["creeps"]["final_tendon"], found["creeps"]["run"]["tendon"][-1], delta=1e-12)
        docs = (SOURCE / "docs" / "evidence.md").read_text(encoding="utf-8")
        without, with_one = self.report(*(EXAMPLES / "protocols" / f"{name}.csv" for name in ("continuous", "aponeurosis")))["protocols"]
        self.assertIn(f"G = {with_one['final_G']:.4f} in place of {without['final_G']:.4f}", docs)
        self.assertAlmostEqual(with_one["final_tendon"], 1.10, delta=5e-3)

    def test_distraction(self):
        path = self.file("rest_length, 50\ndistract, 2, 5\nhold, 5\ndistract, -1, 4\n")
        r = self.report(path)["protocols"][0]
        self.assertAlmostEqual(max(r["run"]["stretch"]), 1.2, delta=1e-12)
        self.assertAlmostEqual(r["final_stretch"], 1.12, delta=1e-12)
        self.assertEqual(r["end_of_lengthening"], 5)

    def test_errors(self):
        self.assertIn("expected a file, or --design", self.run_it(status=2))
        good = self.file("step, 1.1\n")
        for arguments, message in (
                (("--injury", "nan"), "--injury = nan: expected a number > 0"), (("--within", -1), "--within = -1: expected a number > 0"),
                (("--limit", 1.05), "--limit: expected only with --design"), (("--rest-length", 5), "--rest-length: expected only with"),
                (("--set", "c1=-100"), "--set c1=-100: c1 = -100: first Lame constant"),
                (("--injure", 1), "no option '--injure'"), ((good,), "expected another name than that of a file before")):
            with self.subTest(arguments):
                self.assertIn(message, self.run_it(good, *arguments, status=2))
        self.assertIn("study.csv: would be overwritten", subprocess.run(
            [PROGRAMS / self.program, good, "--out", self.folder], capture_output=True, text=True).stderr)
        self.assertEqual(good.read_text(), "step, 1.1\n")
        far = "".join(f"ramp, {x}, 1\n" for _ in range(6) for x in (100, 0.01))
        for name in ("far1.csv", "far2.csv"):
            self.file(far, name)
        self.assertIn("far2: more than 1000000 time steps with the protocols before it",
                      self.run_it(self.folder / "far1.csv", self.folder / "far2.csv", status=2))
        self.check_errors([("set, tau, 1\n", "expected a row step, ramp, hold or distract"),
                           ("ramp, 1.1\n", "study.csv:1:10: expected a time in days, a number > 0, found nothing"),
                           ("hold, -1\n", "study.csv:1:7: expected a time in days, a number > 0, found '-1'")])

    def test_no_result(self):
        """With c1 < 0 a strip that is compressed far has no side stretch without stress."""
        self.assertIn("study: no result at stretch 0.198", self.run_it(self.file("set, c1, -1\nramp, 0.1, 10\n"), status=2))

    def test_two_runs_do_not_share_a_folder(self):
        path = self.file("step, 1.1\n")
        self.run_it(path)
        folder = os.open(self.folder / "out", os.O_RDONLY)
        self.addCleanup(os.close, folder)
        fcntl.flock(folder, fcntl.LOCK_EX)
        self.assertIn("out: another run is at work there", self.run_it(path, status=2))
        self.assertTrue((self.folder / "out" / "report.json").exists())

    def test_says_what_it_does_not_use(self):
        text = self.run_it(self.file("fit, tau, 0.1, 5\nstep, 1.1\nhold, 3\nmeasure, 3, G, 1.02, 1\n"))
        self.assertIn("Not used of study: its rows 'fit', its measurements.", text)
        self.assertNotIn("Not used", self.run_it(self.file("title, a | b\nstep, 1.1\nhold, 3\n")))
        self.assertIn("| a \\| b | 0.00 |", (self.folder / "out" / "report.md").read_text())

    def test_writing(self):
        self.check_writing(EXAMPLES / "protocols" / "step2.csv")


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

    def test_a_muscle_that_grows_without_end(self):
        """G_max = 1e12: k_g is 1/tau, so that T = tau (target/m - 1)/(m - lambda_crit)."""
        for gamma in (0, 1, 2.5):
            r = self.report("--design", 1.14, "--limit", 1.05, "--set", "G_max=1e12", "--set", f"gamma={gamma}")
            self.assertAlmostEqual(r["days"] / (0.5 * (1.14 / 1.05 - 1) / 0.04), 1, delta=1e-9)
            self.assertLess(r["G_off"], 2e-6)

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

    def test_no_input_is_overwritten(self):
        path = self.file("set, tau, 1\n", "fastest.csv")
        done = subprocess.run([PROGRAMS / self.program, path, "--design", "1.1", "--limit", "1.05", "--out", self.folder],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertIn("fastest.csv: would be overwritten; expected another folder than --out", done.stderr)
        self.assertEqual(path.read_text(), "set, tau, 1\n")

    def test_an_earlier_run_leaves_nothing(self):
        self.report("--design", 1.1, "--limit", 1.05)
        (self.folder / "out" / "design.png").write_bytes(b"old")
        self.run_it("--design", 1.2, "--limit", 1.05, status=1)
        self.assertEqual(list((self.folder / "out").iterdir()), [])

    def test_errors(self):
        for arguments, message in ((("--injury", 1.1), "--injury: not used with --design"), (("--limit", "nan"), "--limit = nan: expected"),
                                   (("--limit", 1.05, "--set", "gamma=-1"), "--set gamma=-1: gamma = -1: shape exponent"),
                                   (("--limit", 1.05, "--rest-length", 0), "--rest-length = 0: expected a number from 0.001")):
            self.assertIn(message, self.run_it("--design", 1.1, *arguments, status=2))
        for stretch in ("1", "nan", "1e300", "0,5"):
            self.assertIn(f"--design = {stretch}: expected a number from 1", self.run_it("--design", stretch, "--limit", 2, status=2))
        text = self.run_it("--design", 1.14, "--limit", 1.05, "--set", "tau=1e300", status=1)
        self.assertIn("takes 1.", text)
        self.assertIn("days, more than the 36500", text)
        self.assertIn("Not used of study: its history.", self.run_it(self.file("step, 1.1\n"), "--design", 1.1, "--limit", 1.05))

    def test_writing(self):
        self.check_writing("--design", 1.1, "--limit", 1.05)


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
                                   (("--range", "G_max=0.9:1.2"), "--range G_max=0.9:1.2: G_max = 0.9: largest relative serial"),
                                   (("--range", "c1=-100:3"), "--range c1=-100:3: c1 = -100: first Lame constant"),
                                   (("--range", "c1=-3:3", "--range", "c2=1:9"), "--range c1=-3:3: c1 = -3: first Lame constant"),
                                   (("--range", "tau=2:1"), "--range tau=2:1: expected LOW < HIGH"),
                                   (("--range", "tau=0,5:1"), "found '0,5': decimal comma? write 0.5"),
                                   (("--range", "tau=nan:1"), "--range tau=nan:1: expected a number, found 'nan'"),
                                   (("--range", "ramp=0:1"), "--range ramp=0:1: expected days from 1e-06 on"),
                                   (("--range", "tau=1:2", "--range", "tau=1:3"), "--range tau=1:3: expected only one range of tau"),
                                   (("--threads", 40000), "--threads = 40000: expected a whole number from 1 to 1024"),
                                   (("--threads", 0), "--threads = 0: expected a whole number from 1 to 1024"),
                                   (("--histories", "1e18"), "--histories = 1e18: expected a whole number from 900 to 10000000"),
                                   (("--seed", "1e300"), "--seed = 1e300: expected a whole number from 0 to"),
                                   (("--stretch", "nan"), "--stretch = nan: expected a number from 1"),
                                   (("--days", "1e16"), "--days = 1e16: expected a number from 1e-06 to 1000000"),
                                   (("--days", 1), "--days = 1: expected more than the longest ramp"),
                                   (("a.csv",), "'a.csv': no file is read")):
            with self.subTest(arguments):
                self.assertIn(message, self.run_it(*arguments, status=2))

    def test_what_does_not_vary_or_too_much(self):
        r = self.report("--histories", 900, "--stretch", 1.001, "--range", "lambda_crit=1.01:1.02")
        self.assertEqual([g["sd"] for g in r["global"]][1], 0)
        self.assertEqual([i["first"] for i in r["global"][1]["indices"]], [0] * 7)
        self.assertIn("the variance of the peak force is beyond the range of double",
                      self.run_it("--histories", 900, "--range", "c1=0:1e300", status=2))
        self.assertIn("a history has no result: tau = ", self.run_it("--histories", 900, "--range", "gamma=1:1e6", status=2))

    def test_threads_that_cannot_be_started(self):
        def limit():  # stacks of 1000 threads do not fit
            resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30))
        done = subprocess.run([PROGRAMS / self.program, "--threads", "1000", "--histories", "9000", "--out", self.folder / "out"],
                              capture_output=True, text=True, preexec_fn=limit)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"--threads = 1000: only [0-9]+ could be started: Resource temporarily unavailable")

    def test_writing(self):
        self.check_writing("--histories", 900, slow=("--histories", 10000000))


class Programs(unittest.TestCase):
    """The programs of examples/cpp."""

    def test_writing(self):
        for name in ("growth_over_time", "cross_fibre_growth", "elastic_law", "law_curves", "threads"):
            program = PROGRAMS / name
            if name in ("law_curves", "threads") and not program.is_file():
                continue  # not built without being asked for; no OpenMP
            with self.subTest(name), open("/dev/full", "wb") as full:
                self.assertEqual(subprocess.run([program], stdout=subprocess.DEVNULL).returncode, 0)
                done = subprocess.run([program], stdout=full, stderr=subprocess.PIPE, text=True)
                self.assertEqual((done.returncode, done.stderr),
                                 (1, "standard output cannot be written: No space left on device\n"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
