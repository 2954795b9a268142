"""examples/febio/cylinder.py: the model that it writes is the mesh, and what it reads of FEBio's files is what is in them.

test_cylinder.py SOURCE [unittest arguments]. FEBio itself is not needed.
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

import numpy as np

SOURCE = pathlib.Path(sys.argv[1]).resolve()
SCRIPT = SOURCE / "examples/febio/cylinder.py"
REFERENCE = SOURCE / "tests/mpi/calculix_coarse.csv"


class Cylinder(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)
        self.model = self.folder / "muscle.feb"

    def run_script(self, *arguments):
        return subprocess.run([sys.executable, SCRIPT, self.model, *map(str, arguments)], capture_output=True, text=True, timeout=60)

    def test_model(self):
        done = self.run_script("--kinematic")
        self.assertEqual(done.returncode, 0, done.stderr)
        feb = ET.parse(self.model).getroot()
        points = np.array([[float(x) for x in n.text.split(",")] for n in feb.find("Mesh/Nodes")])
        for kind, count, corners in (("hex8", 1296, (1, 3, 4)), ("penta6", 864, (1, 2, 3))):
            cells = np.array([[int(i) for i in e.text.split(",")] for e in feb.find(f"Mesh/Elements[@type='{kind}']")]) - 1
            self.assertEqual(len(cells), count)
            a, b, c = (points[cells[:, k]] - points[cells[:, 0]] for k in corners)
            determinants = np.einsum("ij,ij->i", np.cross(a, b), c)  # the corner at the first node is not inside out
            self.assertGreater(determinants.min(), 0)
        lengths = [float(s.find("Control/step_size").text) for s in feb.find("Step")]
        np.testing.assert_allclose(np.cumsum(lengths), np.genfromtxt(REFERENCE, delimiter=",", names=True)["time"], rtol=1e-12)
        ends = {s.get("name"): [int(i) - 1 for i in s.text.split(",")] for s in feb.findall("Mesh/NodeSet")}
        self.assertTrue(np.all(points[ends["proximal"], 2] == 0) and np.all(points[ends["distal"], 2] == 400))

    def write_results(self, elements=2160, scale=1.0):
        reference = np.genfromtxt(REFERENCE, delimiter=",", names=True)
        for what, count, columns in (("state", elements, ("G_mean", "lambda_e_mean")), ("reactions", 61, ("reaction",))):
            text = []
            for n, row in enumerate(reference, 1):
                text.append(f"*Step  = {n}\n*Time  = {row['time']:.9g}\n*Data  = {what}\n")
                values = [row[c] * scale / (count if c == "reaction" else 1) for c in columns]
                text += [f"{i}," + ",".join(f"{x:.12g}" for x in values) + "\n" for i in range(1, count + 1)]
            (self.folder / f"muscle_{what}.csv").write_text("".join(text))

    def test_results(self):
        self.write_results(scale=1.001)
        done = self.run_script("--read")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("differences: reaction 1.0e-03, lambda_e_mean 1.0e-03, G_mean 1.0e-03", done.stdout)
        self.assertEqual(len((self.folder / "muscle_history.csv").read_text().splitlines()), 14)

    def test_what_is_wrong_is_said(self):
        done = self.run_script("--read")
        self.assertIn("muscle_state.csv: No such file", done.stderr)
        self.write_results(elements=2159)
        done = self.run_script("--read")
        self.assertIn("muscle_state.csv:2163: 2159 rows in a state, expected 2160", done.stderr)
        self.write_results()
        times = self.folder / "times.csv"
        header, *rows = REFERENCE.read_text().splitlines()
        times.write_text("\n".join([header, *rows[1:], rows[0]]))
        self.assertIn("its times are not those of", self.run_script("--read", "--history", times).stderr)
        self.assertIn("must be greater than 0 and grow", self.run_script("--history", times).stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
