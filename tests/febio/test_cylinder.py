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
sys.path.insert(0, str(SOURCE / "examples/calculix"))
import cylinder_mesh  # noqa: E402

DISTAL = (cylinder_mesh.mesh("coarse").distal + 1).tolist()


class Cylinder(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)
        self.model = self.folder / "muscle.feb"

    def run_script(self, *arguments):
        return subprocess.run([sys.executable, SCRIPT, self.model, *map(str, arguments)], capture_output=True, text=True, timeout=60)

    def test_model(self):
        self.model = self.folder / "a & b.feb"
        done = self.run_script("--kinematic", "--solver", "\"<&>")
        self.assertEqual(done.returncode, 0, done.stderr)
        feb = ET.parse(self.model).getroot()
        self.assertEqual(feb.find("Output/logfile/element_data").get("file"), "a & b_state.csv")
        self.assertEqual({s.get("type") for s in feb.iter("linear_solver")}, {"\"<&>"})
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
        for what, items, columns in (("state", range(1, elements + 1), ("G_mean", "lambda_e_mean")), ("reactions", DISTAL, ("reaction",))):
            text = []
            for n, row in enumerate(reference, 1):
                text.append(f"*Step  = {n}\n*Time  = {row['time']:.9g}\n*Data  = {what}\n")
                values = [row[c] * scale / (len(items) if c == "reaction" else 1) for c in columns]
                text += [f"{i}," + ",".join(f"{x:.12g}" for x in values) + "\n" for i in items]
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
        for file, old, new, message in (("state", "\n5,", "\n4,", "muscle_state.csv:8: item 4 has a row in this state already"),
                                        ("state", "\n5,", "\n9999,", "2160 rows in a state, expected 2160, of items 1 to 2160"),
                                        ("reactions", "*Time", "*Tim", "muscle_reactions.csv:65: a state without *Time"),
                                        ("reactions", "*Time  = 0.", "*Time  = 0.9", "its 13 states are not at the times of the 13 in"),
                                        ("state", "", None, "muscle_state.csv: ends in the middle of a line")):
            self.write_results()
            path = self.folder / f"muscle_{file}.csv"
            text = path.read_text()
            self.assertIn(old, text)
            path.write_text(text[:-3] if new is None else text.replace(old, new, 1))
            self.assertIn(message, self.run_script("--read").stderr)
        self.write_results()
        times = self.folder / "times.csv"
        header, *rows = REFERENCE.read_text().splitlines()
        times.write_text("\n".join([header, *rows[1:], rows[0]]))
        self.assertIn("its times are not those of", self.run_script("--read", "--history", times).stderr)
        self.assertIn("must be greater than 0 and grow", self.run_script("--history", times).stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
