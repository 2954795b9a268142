"""A muscle that is stretched and held, in dolfinx: a cube that is pulled along x with its sides free, or the paper's
cylinder, 400 mm long and 20 mm in diameter, whose ends are clamped and pulled apart by 40 mm.

    ./run fenicsx cube --angle 30             # the fibre 30 degrees off the pull
    ./run fenicsx cylinder --days 7

or, with the module on PYTHONPATH:  python3 stretch.py cube|cylinder [OPTIONS]. Writes history.csv and u.xdmf.
"""
import argparse
import logging
import math
import pathlib
import sys
import time
import traceback

import numpy as np
import ufl
from dolfinx import fem, io, mesh
from mpi4py import MPI

import myogrowth

logging.disable(logging.INFO)  # what FFCx compiles, and how
sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent), str(pathlib.Path(__file__).resolve().parents[1] / "common"),
                str(pathlib.Path(__file__).resolve().parents[1] / "calculix")]
import cylinder_mesh  # noqa: E402  for the cylinder's sizes and layers
import files  # noqa: E402  shared by all examples
from muscle import Muscle, Newton  # noqa: E402

COLUMNS = ["time", "reaction", "lambda_e_max", "lambda_e_mean", "lambda_e_min", "G_max", "G_mean", "G_min", "iterations"]


def disc(inner, rings):
    """Quadrilaterals of the unit disc: inner x inner of a square in the middle, and rings around it. Points and cells."""
    x = np.linspace(-0.5, 0.5, inner + 1)
    points = [(a, b) for b in x for a in x]
    cells = [(k, k + 1, k + inner + 2, k + inner + 1) for j in range(inner) for k in range(j * (inner + 1), j * (inner + 1) + inner)]
    side = range(inner)
    last = inner + 1
    rim = ([i for i in side] + [last * i + inner for i in side] + [last * inner + inner - i for i in side]
           + [last * (inner - i) for i in side])  # counterclockwise from the corner at -135 degrees
    angles = -0.75 * math.pi + 2 * math.pi * np.arange(len(rim)) / len(rim)
    square, circle = np.array([points[k] for k in rim]), np.column_stack([np.cos(angles), np.sin(angles)])
    for ring in range(rings):
        t = (ring + 1) / rings
        outer = list(range(len(points), len(points) + len(rim)))
        points += [tuple(p) for p in (1 - t) * square + t * circle]
        cells += [(a, c, d, b) for a, b, c, d in zip(rim, rim[1:] + rim[:1], outer, outer[1:] + outer[:1])]
        rim = outer
    return np.array(points), np.array(cells)


def cylinder(inner, rings, layers):
    """The paper's cylinder in hexahedra, with layers that are thin at the ends; CalculiX's coarse mesh has 36."""
    points, cells = disc(inner, rings)
    levels = cylinder_mesh.layer_levels(layers, 10.0)
    n = len(points)
    nodes = np.column_stack([np.tile(cylinder_mesh.RADIUS * points, (layers + 1, 1)), np.repeat(levels, n)])
    a, b, c, d = cells.T
    bottom = np.column_stack([a, b, d, c])  # dolfinx counts a hexahedron's corners x fastest
    hexes = np.concatenate([np.column_stack([bottom + k * n, bottom + (k + 1) * n]) for k in range(layers)])
    if MPI.COMM_WORLD.rank > 0:
        nodes, hexes = nodes[:0], hexes[:0]
    element = ufl.VectorElement("Lagrange", ufl.Cell("hexahedron", geometric_dimension=3), 1)
    return mesh.create_mesh(MPI.COMM_WORLD, hexes.astype(np.int64), nodes, ufl.Mesh(element))


class Pull:
    """Prescribed displacements: each a face, a direction and whether it is pulled. The face that is pulled comes last."""

    def __init__(self, V, faces):
        self.conditions, self.moving, self.node_forces = [], [], []
        for axis, place, direction, moves in faces:
            dofs = fem.locate_dofs_topological(V.sub(direction), 2, mesh.locate_entities_boundary(
                V.mesh, 2, lambda x, axis=axis, place=place: np.isclose(x[axis], place)))
            value = fem.Constant(V.mesh, 0.0)
            self.conditions.append(fem.dirichletbc(value, dofs, V.sub(direction)))
            if moves:
                self.moving.append(value)
                self.dofs = dofs

    def set(self, displacement):
        for value in self.moving:
            value.value = displacement

    def reaction(self, forces):
        """The force on the face that is pulled, all processes together."""
        first, last = forces.getOwnershipRange()
        own = self.dofs[self.dofs < last - first]
        return MPI.COMM_WORLD.allreduce(forces.array[own].sum())


def run(a):
    if a.what == "cube":
        domain = mesh.create_unit_cube(MPI.COMM_WORLD, a.cells, a.cells, a.cells, mesh.CellType.hexahedron)
        angle = math.radians(a.angle)
        n0, pulled = [math.cos(angle), math.sin(angle), 0.0], 0.1
        faces = [(axis, 0.0, axis, False) for axis in range(3)] + [(0, 1.0, 0, True)]
    else:
        domain = cylinder(a.cells, 2, a.layers)
        n0, pulled = [0.0, 0.0, 1.0], 0.1 * cylinder_mesh.LENGTH
        faces = [(2, place, axis, place > 0 and axis == 2) for place in (0.0, cylinder_mesh.LENGTH) for axis in range(3)]
    V = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
    u = fem.Function(V, name="u")
    pull = Pull(V, faces)
    muscle = Muscle(u, myogrowth.Parameters(integration=a.integration), n0)
    newton = Newton(muscle, pull.conditions, a.tolerance)
    first = MPI.COMM_WORLD.rank == 0
    rows, now, start = [], 0.0, time.perf_counter()
    if first:
        print(f"{a.what}: {domain.topology.index_map(3).size_global} hexahedra, {V.dofmap.index_map.size_global * 3} unknowns")
        print("        time     reaction  lambda_e mean       G mean   residuals")
    for end in a.times:
        pull.set(pulled * min(end, 1.0))
        residuals = newton.solve(end - now)
        now = end
        muscle.accept()
        state = muscle.step.state
        spread = [f for v in (muscle.step.lambda_e, state.G) for f in
                  (MPI.COMM_WORLD.allreduce(v.max(), MPI.MAX), muscle.mean(v), MPI.COMM_WORLD.allreduce(v.min(), MPI.MIN))]
        rows.append([now, pull.reaction(newton.forces()), *spread, len(residuals) - 1])
        if first:
            print(f"{now:12.6f} {rows[-1][1]:12.6f} {spread[1]:14.8f} {spread[4]:12.8f}   "
                  + " ".join(f"{r:.1e}" for r in residuals[1:]), flush=True)
    if first:
        files.write_csv(a.out / "history.csv", COLUMNS, [[f"{x:.12g}" for x in row] for row in rows])
        print(f"{len(rows)} steps in {time.perf_counter() - start:.1f} s; {a.out}/history.csv, {a.out}/u.xdmf")
    with io.XDMFFile(MPI.COMM_WORLD, str(a.out / "u.xdmf"), "w") as xdmf:
        xdmf.write_mesh(domain)
        xdmf.write_function(u, now)


def read_times(path):
    """The column `time` of a CSV file."""
    header, *lines = files.read_text(path).splitlines() or [""]
    if header.split(",")[0].strip() != "time":
        raise files.FileError(f"{path}:1: the first column must be time, found {files.shown(header)}")
    times = [0.0]
    for number, line in enumerate(lines, 2):
        times.append(files.finite(path, number, "time", line.split(",")[0]))
        if times[-1] <= times[-2]:
            raise files.FileError(f"{path}:{number}: time: must be greater than {times[-2]:g}, is {times[-1]:g}")
    if len(times) == 1:
        raise files.FileError(f"{path}: has no row")
    return times[1:]


def arguments():
    p = argparse.ArgumentParser(prog="./run fenicsx", description=__doc__.split("\n\n")[0], allow_abbrev=False)
    p.add_argument("what", choices=["cube", "cylinder"])
    p.add_argument("--cells", type=files.number(1, 100, kind=int), help="along an edge of the cube (default 2), or of the square in "
                   "the middle of the cylinder's disc (default 6: 24 around the rim, as in CalculiX's coarse mesh)")
    p.add_argument("--layers", type=files.number(3, 10000, kind=int), help="of the cylinder (default 36)")
    p.add_argument("--angle", type=files.number(-360, 360), help="of the cube's fibre and the pull [degrees] (default 0)")
    p.add_argument("--days", type=files.number(above=0), help="length of the test (default 2)")
    p.add_argument("--step", type=files.number(above=0), help="time step [days] (default 0.1)")
    p.add_argument("--times", metavar="FILE", type=pathlib.Path, help="the ends of the time steps: the first column of a CSV file, "
                   "whose header begins with time")
    p.add_argument("--integration", choices=["backward_euler", "midpoint_flow"], default="backward_euler")
    p.add_argument("--tolerance", type=files.number(above=0, below=1), default=1e-9, help="of the residual over all forces")
    p.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/fenicsx"), help="folder of the results")
    a = p.parse_args()
    unused = [("layers", "of the cube")] if a.what == "cube" else [("angle", "of the cylinder, whose fibres are along it")]
    for name, of_what in unused + ([("days", "where --times is given"), ("step", "where --times is given")] if a.times else []):
        if getattr(a, name) is not None:
            p.error(f"there is no --{name} {of_what}")
    a.cells, a.layers, a.angle = a.cells or (2 if a.what == "cube" else 6), a.layers or 36, a.angle or 0.0
    if a.times:
        a.times = read_times(a.times)
    else:
        a.days, a.step = a.days or 2.0, a.step or 0.1
        if a.days / a.step > 1e6:
            p.error(f"--days {a.days:g} in steps of {a.step:g}: must be at most 1e6 steps")
        a.times = list(np.linspace(0, a.days, max(1, math.ceil(a.days / a.step - 1e-9)) + 1)[1:])
    a.out = files.make_folder(a.out)
    return a


if __name__ == "__main__":
    try:
        with files.faults_in_one_line("stretch.py", RuntimeError, myogrowth.MyogrowthError):  # of Newton's method; F
            run(arguments())
    except BaseException as end:  # of any kind: the other processes would wait for this one
        status = end.code if isinstance(end, SystemExit) else traceback.format_exc()
        if status and MPI.COMM_WORLD.size > 1:
            if isinstance(status, str):
                print(status, file=sys.stderr, flush=True)
            MPI.COMM_WORLD.Abort(status if isinstance(status, int) else 1)
        raise
