"""The paper's cylinder in FEBio: writes a model on the mesh of ./run cylinder, and reads what FEBio made of it.

    python3 cylinder.py cylinder.feb                      # --kinematic, --size, --history ...: --help
    febio4 -i cylinder.feb -import .../myogrowth_febio.so
    python3 cylinder.py cylinder.feb --read

The last command writes cylinder_history.csv, and prints how far it is from CalculiX's history on the same mesh.
"""
import argparse
import io
import pathlib
import sys
from xml.sax.saxutils import escape

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "common"),
                str(pathlib.Path(__file__).resolve().parents[1] / "calculix")]
import cylinder_mesh  # noqa: E402
import files  # noqa: E402
import history  # noqa: E402

PULL = 40.0  # mm, in a day
GROWTH = "<integration>{integration}</integration><fiber type=\"vector\">0,0,1</fiber>"
MATERIALS = {
    False: f'<material id="1" name="muscle" type="myogrowth fibre growth">{GROWTH}</material>',
    # FEBio's neo-Hookean with the same c1 = 16 and c2 = 4
    True: f'<material id="1" name="muscle" type="myogrowth kinematic growth">{GROWTH}'
          '<elastic type="neo-Hookean"><E>11.2</E><v>0.4</v></elastic></material>',
}
STEP = """    <step id="{number}">
      <Control>
        <analysis>STATIC</analysis>
        <time_steps>1</time_steps>
        <step_size>{length:.17g}</step_size>
        <solver type="solid">
          <symmetric_stiffness>{symmetry}</symmetric_stiffness>
          <rtol>0</rtol>
          <etol>1e-18</etol>
          <dtol>1e-8</dtol>
          <lstol>0</lstol>
          <max_refs>100</max_refs>
          <qn_method type="BFGS"><max_ups>0</max_ups></qn_method>
          <linear_solver type="{solver}"/>
        </solver>
      </Control>
    </step>
"""


def model(name, mesh, times, material, solver):
    """The text of a .feb file."""
    name, solver = (escape(text, {'"': "&quot;"}) for text in (name, solver))
    f = io.StringIO()
    f.write('<?xml version="1.0" encoding="ISO-8859-1"?>\n<febio_spec version="4.0">\n  <Module type="solid"/>\n'
            f"  <Material>\n    {material}\n  </Material>\n  <Mesh>\n    <Nodes name=\"all\">\n")
    for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1):
        f.write(f'<node id="{i}">{x:.17g},{y:.17g},{z:.17g}</node>\n')
    f.write("    </Nodes>\n")
    label = 1
    for kind, cells in (("hex8", mesh.hexes), ("penta6", mesh.wedges)):
        f.write(f'    <Elements type="{kind}" name="{kind}">\n')
        for cell in (cells + 1).tolist():
            f.write(f'<elem id="{label}">{",".join(map(str, cell))}</elem>\n')
            label += 1
        f.write("    </Elements>\n")
    for end, nodes in (("proximal", mesh.proximal), ("distal", mesh.distal)):
        f.write(f'    <NodeSet name="{end}">{",".join(map(str, (nodes + 1).tolist()))}</NodeSet>\n')
    f.write("""  </Mesh>
  <MeshDomains>
    <SolidDomain name="hex8" mat="muscle"/>
    <SolidDomain name="penta6" mat="muscle"/>
  </MeshDomains>
  <Boundary>
    <bc type="zero displacement" node_set="proximal"><x_dof>1</x_dof><y_dof>1</y_dof><z_dof>1</z_dof></bc>
    <bc type="zero displacement" node_set="distal"><x_dof>1</x_dof><y_dof>1</y_dof><z_dof>0</z_dof></bc>
""" + f"""    <bc type="prescribed displacement" node_set="distal"><dof>z</dof><value lc="1">{PULL:g}</value></bc>
  </Boundary>
  <LoadData>
    <load_controller id="1" type="loadcurve">
      <interpolate>LINEAR</interpolate>
      <points><point>0,0</point><point>1,1</point><point>{1 + times[-1]:.17g},1</point></points>
    </load_controller>
  </LoadData>
  <Step>
""")
    for number, (start, end) in enumerate(zip([0.0] + times, times), 1):
        f.write(STEP.format(number=number, length=end - start, solver=solver,
                            symmetry="symmetric" if solver == "skyline" else "non-symmetric"))
    f.write(f"""  </Step>
  <Output>
    <plotfile type="febio">
      <var type="displacement"/><var type="stress"/><var type="sarcomere number"/><var type="elastic fibre stretch"/>
      <var type="total relative volume"/><var type="elastic relative volume"/>
    </plotfile>
    <logfile>
      <element_data file="{name}_state.csv" delim="," data="sarcomere number;elastic fibre stretch"/>
      <node_data file="{name}_reactions.csv" delim="," data="Rz" node_set="distal"/>
    </logfile>
  </Output>
</febio_spec>
""")
    return f.getvalue()


def tables(path, items, columns):
    """(time, (items, columns)) of every state in a file of FEBio's log data, whose first column has the items' numbers."""
    result, time, rows = [], None, {}
    text = files.read_text(path)
    if not text.endswith("\n"):
        raise files.FileError(f"{path}: ends in the middle of a line")
    for number, line in enumerate([*text.splitlines(), "*Step"], 1):
        if line.startswith("*Step"):
            if rows and rows.keys() != set(items):
                raise files.FileError(f"{path}:{number}: {len(rows)} rows in a state, expected {len(items)}, of items {min(items)} to "
                                      f"{max(items)}")
            if rows and time is None:
                raise files.FileError(f"{path}:{number}: a state without *Time")
            if rows:
                result.append((time, np.array([rows[i] for i in items])))
            time, rows = None, {}
        elif line.startswith("*Time"):
            time = files.finite(path, number, "time", line.split("=")[-1])
        elif line and not line.startswith("*"):
            entries = line.split(",")
            if len(entries) != columns + 1:
                raise files.FileError(f"{path}:{number}: {len(entries)} entries, expected {columns + 1}")
            item, *values = (files.finite(path, number, "value", x) for x in entries)
            if item in rows:
                raise files.FileError(f"{path}:{number}: item {item:g} has a row in this state already")
            rows[item] = values
    if not result:
        raise files.FileError(f"{path}: has no state")
    return result


def read(a, mesh):
    """The history: reaction [mN] and means over the undeformed volume."""
    stem = a.model.with_suffix("")
    gauss = history.GaussPoints(mesh, np.zeros(len(mesh.layer_of_elements()), dtype=bool))
    weights = np.bincount(gauss.elements - 1, gauss.volumes)  # the elements' volumes
    states = tables(f"{stem}_state.csv", range(1, len(weights) + 1), 2)
    reactions = tables(f"{stem}_reactions.csv", (mesh.distal + 1).tolist(), 1)
    if [time for time, _ in states] != [time for time, _ in reactions]:
        raise files.FileError(f"{stem}_reactions.csv: its {len(reactions)} states are not at the times of the {len(states)} in "
                              f"{stem}_state.csv")
    columns = ["time", "reaction", "lambda_e_mean", "G_mean"]
    ours = np.array([[time, forces.sum(), *(weights @ state / weights.sum())[::-1]]
                     for (time, state), (_, forces) in zip(states, reactions) if time > 0])
    files.write_csv(f"{stem}_history.csv", columns, [[f"{x:.12g}" for x in row] for row in ours])
    for row in ours:
        print("day {:.6f}  reaction {:.6f} mN  lambda_e {:.7f}  G {:.7f}".format(*row))
    theirs = np.column_stack([history.read(a.history)[c] for c in columns])[: len(ours)]
    if len(theirs) < len(ours) or not np.allclose(theirs[:, 0], ours[:, 0], rtol=1e-5):
        raise files.FileError(f"{a.history}: its times are not those of {stem}_state.csv")
    worst = np.abs(ours / theirs - 1).max(axis=0)
    print("largest relative differences: " + ", ".join(f"{c} {d:.1e}" for c, d in zip(columns[1:], worst[1:])))


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0], allow_abbrev=False)
    p.add_argument("model", metavar="MODEL.feb", type=pathlib.Path)
    p.add_argument("--size", choices=cylinder_mesh.SIZES, default="coarse", help="of the mesh (default coarse)")
    p.add_argument("--history", metavar="FILE", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2]
                   / "tests/mpi/calculix_coarse.csv", help="a history.csv of ./run cylinder on the same mesh: for the ends of the time "
                   "steps, and with --read to compare with; the default has the first day of size coarse")
    p.add_argument("--kinematic", action="store_true", help="the second material, with FEBio's neo-Hookean in it")
    p.add_argument("--integration", type=int, choices=[0, 1], default=1, help="of eq. 4: 0 backward Euler, 1 second order (default)")
    p.add_argument("--solver", default="pardiso", help="FEBio's linear solver: pardiso (default), which needs an FEBio with MKL; skyline, "
                   "which every FEBio has, with the symmetric part of the tangent, so with more iterations; or another one")
    p.add_argument("--read", action="store_true", help="read FEBio's results of the model, instead of writing it")
    a = p.parse_args()
    mesh = cylinder_mesh.mesh(a.size)
    if a.read:
        read(a, mesh)
    else:
        times = history.read(a.history)["time"].tolist()
        if any(end <= start for start, end in zip([0.0] + times, times)):
            raise files.FileError(f"{a.history}: time: must be greater than 0 and grow from row to row")
        files.write_text(a.model, model(a.model.stem, mesh, times, MATERIALS[a.kinematic].format(integration=a.integration),
                                         a.solver))


if __name__ == "__main__":
    with files.faults_in_one_line("cylinder.py"):
        main()
