"""The CUDA example: its command line, the registers of its kernels by ptxas, and a run where there is a device.

check_cuda.py FOLDER [unittest arguments]: the folder in which update_points was built; every class is a ctest.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

FOLDER = pathlib.Path(sys.argv[1]).resolve()
CASES = [(p, t) for p in ("fp64", "fp32") for t in ("full", "compact")]


def run(*arguments, **environment):
    return subprocess.run([FOLDER / "update_points", *arguments], capture_output=True, text=True, timeout=300,
                          env={**os.environ, **environment})


class CommandLine(unittest.TestCase):
    def test_help(self):
        done = run("--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for option in ("--points", "--precision", "--tangent", "--repetitions", "--out"):
            self.assertIn(option, done.stdout)

    def test_bad_input_is_named(self):
        for arguments, words in [(["--points", "0"], "--points 0: a whole number from 1"),
                                 (["--points", "1.5"], "--points 1.5: a whole number"),
                                 (["--points", "0x10"], "--points 0x10: a whole number"),
                                 (["--points", "1e18"], "--points 1e18: a whole number from 1 to 1000000000 is needed"),
                                 (["--repetitions", "many"], "--repetitions many: a whole number"),
                                 (["--precision", "fp16"], "--precision fp16: must be fp64, fp32 or all"),
                                 (["--tangent", "none"], "--tangent none: must be full, compact or all"),
                                 (["--out"], "--out needs a value"), (["--out", ""], "--out needs a value"), (["--device"], "no option --device")]:
            done = run(*arguments)
            self.assertEqual((done.returncode, done.stdout), (1, ""), arguments)
            self.assertIn(words, done.stderr)

    def test_what_cannot_be_written_is_named(self):
        with open("/dev/full", "wb") as full:
            done = subprocess.run([FOLDER / "update_points", "--help"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr),
                         (1, "update_points: standard output: cannot be written: No space left on device\n"))

    def test_no_device(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "results.json"
            done = run("--out", out, CUDA_VISIBLE_DEVICES="")
            self.assertEqual((done.returncode, done.stdout), (1, ""))
            self.assertIn("no CUDA device: ", done.stderr)
            self.assertFalse(out.exists())


class Registers(unittest.TestCase):
    def test_nothing_spilled(self):
        kernels = re.findall(r"Compiling entry function '(\w+)' for '(sm_\d+)'\n.*\n *(\d+) bytes stack frame, "
                             r"(\d+) bytes spill stores, (\d+) bytes spill loads\n.*Used (\d+) registers",
                             (FOLDER / "ptxas.txt").read_text())
        self.assertEqual(len(kernels), 2 * len(CASES))
        for name, architecture, stack, stores, loads, registers in kernels:
            print(f"{architecture} {name}: {registers} registers, {stack} bytes of stack")
            self.assertEqual((stack, stores, loads), ("0", "0", "0"), name)


class Device(unittest.TestCase):
    def test_run(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "results.json"
            done = run("--points", "100000", "--repetitions", "3", "--out", out)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            full = run("--points", "1000", "--repetitions", "1", "--out", "/dev/full")
            self.assertEqual(full.returncode, 1)
            self.assertIn("/dev/full: cannot be written: No space left on device", full.stderr)
            folder_is_no_file = run("--points", "1000", "--out", folder)
            self.assertEqual((folder_is_no_file.returncode, folder_is_no_file.stdout), (1, ""))
            self.assertIn("cannot be written: Is a directory", folder_is_no_file.stderr)
            many = run("--points", "1000000000", "--precision", "fp64", "--tangent", "full")
            self.assertEqual(many.returncode, 1)
            self.assertRegex(many.stderr, r"--points 1000000000: at most \d+ fit into memory")
            rows = json.loads(out.read_text())
            self.assertEqual([(r["precision"], r["tangent"]) for r in rows], CASES)
            for row in rows:
                self.assertAlmostEqual(row["points_per_second"] * row["bytes_per_point"] / row["bytes_per_second"], 1, 4)
                self.assertEqual(row["points_without_result"], 0)


if __name__ == "__main__":
    if "Device" in sys.argv and "no CUDA device" in run("--points", "1").stderr:
        print("no CUDA device: nothing was run")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
