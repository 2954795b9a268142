"""What could explain the differences from the paper: ends, ramps, meshes, fibres, energy and the unit of time, run by run.

Every run is a cylinder in CalculiX, kept in OUT/<name>/ and not made again; an interrupted one goes on from its last whole
leg. From the runs come tables (on the screen and in OUT/tables.md) and figures (OUT/*.png).
"""
import argparse
import json
import math
import multiprocessing
import os
import pathlib
import re
import resource
import shutil
import signal
import sys
import types
from typing import NamedTuple

import numpy as np

import cylinder
import cylinder_mesh
import deck
import frd
import history

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "fortran_driver"))
import cube  # noqa: E402  for the exact solution of eq. 4 at a point

BEGIN, END = "<!-- tables: ./run studies -->\n", "<!-- end of tables -->\n"
MIDDLE = cylinder_mesh.LENGTH / 2
TENDON = 20.0  # mm, length of the stiff layers where there are any
MUSCLE_ALONE = 36.0  # mm, the pull that stretches what is between two such layers by 10 %
EDGES = (2.0, 0.5, 0.125, 0.03)  # mm, sides of the elements in the clamped edge


# ---- Meshes that are fine at the clamped edge

def growing(first, total, ratio):
    """How many elements from one of size `first` make up `total` when each is about `ratio` times as long as the one
    before it, and their lengths, of which the first is `first` exactly."""
    n = max(2, math.ceil(math.log(1 + total * (ratio - 1) / first) / math.log(ratio)))
    low, high = 1.0, 4.0
    for _ in range(200):
        q = (low + high) / 2
        low, high = (q, high) if first * (q**n - 1) / (q - 1) < total else (low, q)
    return first * low ** np.arange(n)


def edge_mesh(edge, interface=0.0):
    """A mesh with elements of edge x edge [mm] at the surface of the ends, and of the layers at a distance `interface`
    from them. 18 nodes around: what happens at a clamp is almost axisymmetric, so that width does not matter there."""
    widths = growing(edge, cylinder_mesh.RADIUS, 1.5)
    rings = [6, 12][:len(widths) - 1] + [18] * max(len(widths) - 2, 1)
    size = cylinder_mesh.Size(rings, 18 * (len(rings) - 3), 0, ring_grading=widths[-1] / widths[0])
    half = growing(edge, MIDDLE - interface, 1.35)
    if interface:
        half = np.concatenate([growing(edge, interface, 1.35)[::-1], half])
    levels = np.concatenate([[0.0], np.cumsum(np.concatenate([half, half[::-1]]))])
    levels *= cylinder_mesh.LENGTH / levels[-1]
    levels[-1] = cylinder_mesh.LENGTH
    return cylinder_mesh.sweep(size, levels)


def mesh_of(size):
    """A mesh of cylinder_mesh.SIZES by its name, or `edge 0.5`, or `edge 0.5 at 20`."""
    if size in cylinder_mesh.SIZES:
        return cylinder_mesh.mesh(size)
    edge, *interface = re.findall(r"[\d.]+", size)
    return edge_mesh(float(edge), *map(float, interface))


# ---- Runs

def runs():
    """All runs by their names; the ones that take long first, so that they do not come last when two run at once."""
    week = 7 * deck.TAU
    at_once, to_peak = {"ramp": 1e-3, "duration": 1e-3}, {"duration": 1.0}
    cases = {"medium": {"size": "medium"}}
    cases.update({f"edge {h:g}": {"size": f"edge {h:g}", **to_peak} for h in reversed(EDGES)})
    cases.update({f"edge {h:g} at once": {"size": f"edge {h:g}", **at_once} for h in reversed(EDGES)})
    cases.update({f"ramp {ramp:g}": {"ramp": ramp} for ramp in (42.0, 14.0, 7.0, 2.0, 0.5)})
    cases["coarse"] = {}
    cases["tendon"] = {"ends": "tendon", "pull": MUSCLE_ALONE}
    cases["mixed"] = {"ends": "mixed"}
    cases["free"] = {"ends": "free", "size": "tiny"}
    cases["tiny"] = {"size": "tiny"}
    cases["energy 1"] = {"energy": 1, "duration": 14.0}
    cases["tau in weeks"] = {"tau": week}
    cases["tau in weeks, ramp 7"] = {"tau": week, "ramp": 7.0}
    for stiffness in (100.0, 10.0):
        for h in (0.5, 0.125):
            cases[f"tendon {stiffness:g}, edge {h:g}"] = {
                "ends": "tendon", "tendon_length": TENDON, "tendon_stiffness": stiffness, "pull": MUSCLE_ALONE,
                "size": f"edge {h:g} at {TENDON:g}", **to_peak}
    cases.update({f"fibre {angle:g}": {"fibre_angle": angle, **to_peak} for angle in (5.0, 10.0, 20.0)})
    return {name: deck.Case(**options) for name, options in cases.items()}


class Quiet:
    """In the place of cylinder.Progress, where several runs go on at once."""

    def __init__(self, increments):
        self.done = 0

    def skip(self, increments):
        pass

    def tell(self, row, line_stays):
        pass


class Job(NamedTuple):
    """What a worker needs."""

    name: str
    case: deck.Case
    folder: pathlib.Path
    ccx: pathlib.Path
    library_dir: pathlib.Path


def is_done(folder, case):
    saved = folder / "case.json"
    return (folder / "fields.npz").is_file() and json.loads(saved.read_text()) == case._asdict()


def do(job):
    """Runs a job that is not done yet; its name, and the CPU seconds of ccx."""
    saved, case = job.folder / "case.json", job.case
    resume = saved.is_file() and json.loads(saved.read_text()) == case._asdict()
    a = types.SimpleNamespace(out=job.folder, ccx=job.ccx, library_dir=job.library_dir, threads=1, resume=resume)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    mesh = mesh_of(case.size)
    folder = cylinder.start_folder(a, case)
    gauss = history.GaussPoints(mesh, deck.tendon(case, mesh))
    rows, states = cylinder.run_legs(a, case, mesh, gauss, folder, Quiet)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    history.write(job.folder / "history.csv", rows)
    times = [end for _, end in deck.leg_times(case)]
    np.savez_compressed(job.folder / "part.npz", times=times, gauss=np.array(states)[:, :, :2], seconds=seconds)
    shutil.rmtree(folder)
    os.replace(job.folder / "part.npz", job.folder / "fields.npz")
    return job.name, seconds


def do_all(a, cases):
    jobs = [Job(name, case, a.out / name.replace(" ", "_").replace(",", ""), a.ccx, a.library_dir)
            for name, case in cases.items()]
    waiting = [job for job in jobs if not is_done(job.folder, job.case)]
    print(f"{len(jobs)} runs, {len(jobs) - len(waiting)} of them kept in {a.out}/", flush=True)
    if waiting:
        # Ctrl-C or a request to end: SystemExit, so that the worker ends its ccx and itself.
        with multiprocessing.Pool(min(a.jobs, len(waiting)), leave_on_signals) as pool:
            for count, (name, seconds) in enumerate(pool.imap_unordered(do, waiting), 1):
                print(f"{count} of {len(waiting)}   {name}   {seconds:.0f} CPU-s", flush=True)
    return {job.name: job.folder for job in jobs}


def leave_on_signals():
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: sys.exit(130))


def arguments():
    p = argparse.ArgumentParser(prog=os.environ.get("MYOGROWTH_JOB", "studies.py"), description=__doc__,
                                formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    p.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/studies"), help="folder of runs, tables, figures")
    p.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="runs at a time, of one thread each")
    p.add_argument("--paper", type=pathlib.Path, default=pathlib.Path("out/paper"),
                   help="a finished run of cylinder.py --size paper, for the table of meshes; left out where there is none")
    p.add_argument("--write", type=pathlib.Path, help="a markdown file whose tables between two marks are to be made anew")
    p.add_argument("--ccx", type=pathlib.Path, required=True, help="the executable")
    p.add_argument("--library-dir", type=pathlib.Path, required=True, help=f"the folder of {cylinder.LIBRARY}")
    a = p.parse_args()
    if a.jobs < 1:
        p.error(f"--jobs = {a.jobs}: must be > 0")
    return a


def main():
    a = arguments()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        folders = do_all(a, runs())
    except KeyboardInterrupt:
        print("\ninterrupted; the same command goes on", file=sys.stderr)
        sys.exit(130)
    except (cylinder.JobError, frd.FormatError, ValueError, OSError) as e:
        print(e, file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
