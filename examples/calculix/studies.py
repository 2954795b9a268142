"""What could explain the differences from the paper: ends, ramps, meshes, fibres, energy and the unit of time, run by run.

Every run is a cylinder in CalculiX, kept in OUT/<name>/ and not made again; an interrupted one goes on from its last whole
leg. From the runs come tables (on the screen and in OUT/tables.md) and figures (OUT/*.png).
"""
import argparse
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
import history
import kept
from shared import eq4, files

BEGIN, END = "<!-- tables: ./run studies -->\n", "<!-- end of tables -->\n"
MIDDLE = cylinder_mesh.LENGTH / 2
TENDON = 20.0  # mm, length of the stiff layers where there are any
MUSCLE_ALONE = 36.0  # mm, the pull that stretches what is between two such layers by 10 %
PAPER = pathlib.Path("out/paper")
EDGES = (2.0, 0.6, 0.2, 0.06)  # mm, sides of the elements in the clamped edge
LATER = 0.2  # mm, the one of them that is followed to the end


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
    from them. 12 nodes around: what happens at a clamp is almost axisymmetric, so that width does not matter there."""
    widths = growing(edge, cylinder_mesh.RADIUS, 1.5)
    rings = [6] + [12] * (len(widths) - 1)
    size = cylinder_mesh.Size(rings, 12 * (len(rings) - 2), 0, ring_grading=widths[-1] / widths[0])
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
    found = re.fullmatch(r"edge (\d+(?:\.\d+)?)(?: at (\d+(?:\.\d+)?))?", size)
    if not found:
        raise files.FileError(f"mesh {size!r}: must be one of {', '.join(cylinder_mesh.SIZES)}, or edge NUMBER [at NUMBER]")
    return edge_mesh(*(float(x) for x in found.groups() if x))


# ---- Runs

def runs():
    """All runs by their names; the ones that take long first, so that they do not come last when two run at once."""
    week = 7 * deck.TAU
    at_once, to_peak = {"ramp": 1e-3, "duration": 1e-3}, {"duration": 1.0}
    cases = {"medium": {"size": "medium"}}
    cases.update({f"edge {h:g}": {"size": f"edge {h:g}", **to_peak} for h in reversed(EDGES)})
    cases.update({f"edge {h:g} at once": {"size": f"edge {h:g}", **at_once} for h in reversed(EDGES)})
    cases.update({f"ramp {ramp:g}": {"ramp": ramp} for ramp in (42.0, 14.0, 7.0, 2.0, 0.5)})
    cases["ramp 1.5"] = {"ramp": 1.5, "duration": 1.5}
    cases[f"edge {LATER:g}, six weeks"] = {"size": f"edge {LATER:g}"}
    cases["coarse"] = {}
    cases["tendon"] = {"ends": "tendon", "pull": MUSCLE_ALONE}
    cases["mixed"] = {"ends": "mixed"}
    cases["free"] = {"ends": "free", "size": "tiny"}
    cases["tiny"] = {"size": "tiny"}
    cases["energy 1"] = {"energy": 1, "duration": 14.0}
    cases["tau in weeks"] = {"tau": week}
    cases["tau in weeks, ramp 7"] = {"tau": week, "ramp": 7.0}
    for stiffness in (100.0, 10.0):
        for h in EDGES[1:3]:
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


def is_same(job):
    """Whether the job's folder has a run of its case; one of another case is made anew, and said so."""
    if not (job.folder / "case.json").is_file():
        return False
    different = kept.differences(kept.read_case(job.folder), job.case)
    if different:
        print(f"{job.folder}: the run there has {different}: it is made anew", flush=True)
    return not different


def is_done(job):
    """Whether the run is kept, whole. A damaged file of it ends the program."""
    if not is_same(job) or not (job.folder / "fields.npz").is_file():
        return False
    Run(job.folder)
    return True


def do(job):
    """Runs a job that is not done yet; its name, and the CPU seconds of ccx."""
    case = job.case
    resume = (job.folder / "case.json").is_file() and kept.read_case(job.folder) == case
    a = types.SimpleNamespace(out=job.folder, ccx=job.ccx, library_dir=job.library_dir, threads=1, resume=resume)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    mesh = mesh_of(case.size)
    folder = cylinder.start_folder(a, case)
    gauss = history.GaussPoints(mesh, deck.tendon(case, mesh))
    rows, states = cylinder.run_legs(a, case, mesh, gauss, folder, Quiet)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    history.write(job.folder / "history.csv", rows)
    times = [end for _, end in deck.leg_times(case)]
    with files.writing(job.folder / "fields.npz") as part:
        np.savez_compressed(part, times=times, gauss=np.array(states)[:, :, :2])
    shutil.rmtree(folder)
    return job.name, seconds


def do_all(a, cases):
    jobs = [Job(name, case, a.out / name.replace(" ", "_").replace(",", ""), a.ccx, a.library_dir)
            for name, case in cases.items()]
    waiting = [job for job in jobs if not is_done(job)]
    print(f"{len(jobs)} runs, {len(jobs) - len(waiting)} of them kept in {a.out}/", flush=True)
    programs = kept.programs(a.ccx, a.library_dir / cylinder.LIBRARY)
    older = [job.name for job in jobs if job not in waiting and kept.changed_programs(job.folder, programs)]
    if older:
        print(f"warning: made with another ccx or {cylinder.LIBRARY}: {'; '.join(older)}. Remove their folders in {a.out}/ to "
              "have them made again", file=sys.stderr)
    if waiting:
        # Ctrl-C or a request to end: SystemExit, so that the worker ends its ccx and itself.
        with multiprocessing.Pool(min(a.jobs, len(waiting)), leave_on_signals) as pool:
            for count, (name, seconds) in enumerate(results(pool, waiting), 1):
                print(f"{count} of {len(waiting)}   {name}   {seconds:.0f} CPU-s", flush=True)
    return {job.name: job.folder for job in jobs}


def results(pool, waiting):
    """What `do` returns, as it comes. A pool replaces a worker that was killed, and waits for its result for ever."""
    workers, coming = {p.pid for p in multiprocessing.active_children()}, pool.imap_unordered(do, waiting)
    while True:
        try:
            yield coming.next(timeout=2)
        except StopIteration:
            return
        except multiprocessing.TimeoutError:
            if {p.pid for p in multiprocessing.active_children()} != workers:
                raise cylinder.JobError("one of the processes that make the runs was ended from outside (too little "
                                        "memory?); the same command goes on") from None


def leave_on_signals():
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: sys.exit(130))


# ---- What a run says

class Run:
    """A finished run: its history, and lambda_e and G of the Gauss points at the times of output."""

    def __init__(self, folder):
        self.case = kept.read_case(folder)
        self.mesh = mesh_of(self.case.size)
        gauss = history.GaussPoints(self.mesh, deck.tendon(self.case, self.mesh))
        self.h = history.read(folder / "history.csv")
        path = folder / "fields.npz"
        found = kept.arrays(path, "times", "gauss")
        self.days, muscle = found["times"].tolist(), gauss.muscle
        kept.demand_shape(path, "gauss", found["gauss"], (len(self.days), len(muscle), None))
        if self.days != deck.output_times(self.case) or not kept.ends_on(self.h["time"][-1], self.case.duration):
            raise files.FileError(f"{path} and history.csv: end before day {self.case.duration:g}, the end of the run: remove "
                                  f"{folder} to have it made anew")
        self.states = found["gauss"][:, muscle, :2].astype(float)
        x, y, self.z = gauss.places[muscle].T
        self.x, self.r = x, np.hypot(x, y)
        self.ends = self.z < MIDDLE, self.z > MIDDLE  # proximal, distal
        self.at_surface, self.at_axis = self.r > 0.95 * self.r.max(), self.r < 1.05 * self.r.min()
        self.outermost = self.r > 0.995 * self.r.max()
        layer = self.mesh.layer_of_elements()[gauss.elements[muscle] - 1]
        from_end = np.minimum(layer, layer.max() + layer.min() - layer)
        self.first_layer = from_end == from_end.min()  # of the muscle, at both ends
        self.heights = np.diff(self.mesh.levels)[layer.min():layer.max() + 1]

    def field(self, name, day):
        return self.states[self.days.index(day), :, deck.STATE.index(name)]

    def at(self, name, day):
        """The column of the history on a day of output; nan where the run ends before."""
        found = np.flatnonzero(np.isclose(self.h["time"], day))
        return self.h[name][found[0]] if len(found) else math.nan

    def peak(self):
        """Row of the history with the largest lambda_e."""
        k = int(np.argmax(self.h["lambda_e_max"]))
        return {name: column[k] for name, column in self.h.items()}

    def where(self):
        """The place of the peak: distances [mm] from the axis and from the nearer end."""
        row = self.peak()
        r, z = math.hypot(row["x"], row["y"]), row["z"]
        return f"{r:.1f} / {min(z, cylinder_mesh.LENGTH - z):.1f}"

    def largest(self, name, day, chosen):
        return self.field(name, day)[chosen].max()

    def edge(self, day, name="lambda_e"):
        """Largest in the surface of the first layers."""
        return self.largest(name, day, self.first_layer & self.at_surface)

    def axis_at_end(self, day):
        return self.field("lambda_e", day)[self.first_layer & self.at_axis].mean()

    def middle(self, day):
        return self.field("lambda_e", day)[np.abs(self.z - MIDDLE) < np.abs(self.z - MIDDLE).min() + 0.01].mean()

    def along(self, chosen, day):
        """Distance from the proximal end and mean lambda_e at every height of Gauss points among those chosen."""
        z, values = np.round(self.z[chosen], 4), self.field("lambda_e", day)[chosen]
        heights = np.unique(z[z < MIDDLE])
        return heights, np.array([values[z == h].mean() for h in heights])


def at_a_point(times, ramp=1.0, tau=deck.TAU):
    """lambda_e by the exact solution of eq. 4 at a point of the cylinder far from its ends, where the stretch is 1.10."""
    a = types.SimpleNamespace(stretch=1.1, ramp=ramp, tau=tau, gamma=deck.GAMMA, G_max=deck.G_MAX, lambda_crit=deck.LAMBDA_CRIT)
    return np.array([eq4.stretch(a, t) / G for t, G in zip(times, eq4.exact(a, times))])


def peak_at_a_point(ramp, tau=deck.TAU):
    times = np.linspace(0, ramp, 401)[1:].tolist()
    values = at_a_point(times, ramp, tau)
    return values.max(), times[int(np.argmax(values))]


def clamped_free_exponent():
    """Of the distance from the edge between a clamped and a free face at a right angle, in the strains of linear
    elasticity with Poisson's ratio of c1 and c2 (Williams 1952, plane strain)."""
    nu = deck.C1 / (2 * (deck.C1 + deck.C2))
    kappa = 3 - 4 * nu
    low, high = 0.3, 1.0
    for _ in range(100):
        e = (low + high) / 2
        low, high = (e, high) if math.sin(e * math.pi / 2)**2 < (kappa + 1)**2 / (4 * kappa) - e**2 / kappa else (low, e)
    return low - 1


def fitted_exponent(sizes, strains):
    return np.polyfit(np.log(sizes), np.log(strains), 1)[0]


# ---- Tables

def decimals(x, n=4):
    return "" if math.isnan(x) else f"{x:.{n}f}"


def table(head, rows):
    def text(x):
        return decimals(x) if isinstance(x, float) else str(x)

    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(text, row)) + " |" for row in rows]) + "\n"


def table_of_meshes(found):
    rows = []
    for name in ("tiny", "coarse", "medium", "paper"):
        if name not in found:
            continue
        r = found[name]
        rows.append([name, f"{len(r.mesh.hexes):,} + {len(r.mesh.wedges):,}", f"{r.heights[0]:.1f}", r.peak()["lambda_e_max"],
                     r.where(), r.edge(1.0), r.axis_at_end(1.0), r.middle(1.0), r.at("lambda_e_max", 14),
                     *(r.at(f"lambda_e_{what}", 42) for what in ("max", "mean", "min")), r.at("G_mean", 42),
                     decimals(r.at("reaction", 42), 2)])
    return table(["mesh", "C3D8 + C3D6", "end layer [mm]", "peak", "at [mm] †", "edge, day 1", "axis at clamp, day 1",
                  "mid-length, day 1", "largest, day 14", "largest, day 42", "mean, day 42", "smallest, day 42",
                  "mean G, day 42", "force [mN], day 42"], rows)


def table_of_edges(found):
    rows = []
    strains = {"at once": [], "ramp": []}
    for h in EDGES:
        at_once, ramp = found[f"edge {h:g} at once"], found[f"edge {h:g}"]
        day = at_once.case.ramp
        strains["at once"].append(at_once.edge(day) - 1)
        strains["ramp"].append(ramp.edge(1.0) - 1)
        inside = [r.largest("lambda_e", d, ~r.at_surface) for r, d in ((at_once, day), (ramp, 1.0))]
        rows.append([f"{h:g}", at_once.edge(day), inside[0], at_once.where(), ramp.edge(1.0), inside[1], ramp.where(),
                     ramp.edge(1.0, "G"), ramp.axis_at_end(1.0)])
    said = table(["element at the edge [mm]", "at once: edge", "at once: largest inside", "largest of all at [mm] †",
                  "1 d ramp: edge", "1 d ramp: largest inside", "largest of all at [mm] †", "1 d ramp: G, edge",
                  "1 d ramp: axis at clamp"], rows)
    r = found[f"edge {LATER:g}, six weeks"]
    rows = [[f"{day:g}", r.edge(day), r.largest("lambda_e", day, ~r.at_surface), r.edge(day, "G"), r.axis_at_end(day)]
            for day in r.days]
    said += f"\nElements of {LATER:g} mm, over time:\n\n" + table(
        ["day", "edge", "largest inside", "G, edge", "axis at clamp"], rows)
    once, ramp = (fitted_exponent(EDGES[1:], strains[kind][1:]) for kind in ("at once", "ramp"))
    return said + (f"\nFit: λe − 1 at the edge is proportional to (element size)^p with p = {once:.2f} at once and {ramp:.2f} "
                   f"after the\nramp (without the coarsest mesh). Linear elasticity has p = {clamped_free_exponent():.2f} for a "
                   "clamped face beside a free one.\n")


def table_of_ramps(found):
    rows = []
    for ramp in (0.5, 1.0, 1.5, 2.0, 7.0, 14.0, 42.0):
        r = found["coarse" if ramp == 1 else f"ramp {ramp:g}"]
        peak, day = peak_at_a_point(ramp)
        later = at_a_point([14.0, 42.0], ramp)
        rows.append([f"{ramp:g}", peak, f"{day:.3g}", *later.tolist(), r.peak()["lambda_e_max"], f"{r.peak()['time']:.3g}",
                     r.where(), r.middle(ramp), r.edge(ramp), r.at("lambda_e_max", 14), r.at("lambda_e_max", 42),
                     r.at("lambda_e_mean", 42)])
    return table(["ramp [d]", "point: peak", "on day", "point: day 14", "point: day 42", "cylinder: peak", "on day", "at [mm] †",
                  "mid-length, end of ramp", "edge, end of ramp", "largest, day 14", "largest, day 42", "mean, day 42"], rows)


def table_of_ends(found):
    rows = []
    for name, text in (("coarse", "clamped"), ("mixed", "proximal clamped, distal free"), ("free", "free"),
                       ("tendon", "tendon, 100 times as stiff"),
                       *((f"tendon {k:g}, edge {h:g}", f"tendon, {k:g} times as stiff, elements of {h:g} mm beside it")
                         for k in (100, 10) for h in EDGES[1:3])):
        r = found[name]
        values, here = r.field("lambda_e", 1.0), r.first_layer
        edges, axes = ([values[here & side & end].max() for end in r.ends] for side in (r.at_surface, r.at_axis))
        rows.append([text, r.peak()["lambda_e_max"], r.where(), *edges, *axes, r.middle(1.0),
                     r.at("lambda_e_min", 1), *(r.at(f"lambda_e_{what}", 42) for what in ("max", "mean", "min"))])
    return table(["ends", "peak", "at [mm] †", "proximal edge, day 1", "distal edge", "axis at the proximal end",
                  "at the distal end",
                  "mid-length", "smallest",
                  "largest, day 42", "mean, day 42", "smallest, day 42"], rows)


def table_of_fibres(found):
    rows = []
    for angle in (0.0, 5.0, 10.0, 20.0):
        r = found["coarse" if angle == 0 else f"fibre {angle:g}"]
        values, row = r.field("lambda_e", 1.0), [f"{angle:g}"]
        for end in r.ends:
            for side in (r.x < -0.85 * r.r.max(), r.x > 0.85 * r.r.max()):
                row.append(values[r.first_layer & r.at_surface & end & side].mean())
        peak = r.peak()
        row += [r.middle(1.0), peak["lambda_e_max"], f"{peak['x']:.1f} / {peak['y']:.1f} / {peak['z']:.1f}"]
        rows.append(row)
    return table(["fibre [°]", "proximal, x < 0", "proximal, x > 0", "distal, x < 0", "distal, x > 0", "mid-length", "peak",
                  "at x / y / z [mm]"], rows)


def table_of_energies(found):
    rows = [[text, r.peak()["lambda_e_max"], r.where(), r.edge(1.0), r.at("lambda_e_max", 14), r.at("lambda_e_min", 14),
             decimals(r.at("reaction", 1), 2), decimals(r.at("reaction", 14), 2)]
            for text, r in (("0: reference", found["coarse"]), ("1: grown", found["energy 1"]))]
    return table(["energy per unit of volume", "peak", "at [mm] †", "edge, day 1", "largest, day 14", "smallest, day 14",
                  "force, day 1 [mN]", "force, day 14 [mN]"], rows)


def table_of_times(found):
    week = 7 * deck.TAU
    rows = []
    for tau, ramp, name in ((deck.TAU, 1.0, "coarse"), (deck.TAU, 7.0, "ramp 7"), (deck.TAU, 42.0, "ramp 42"),
                            (week, 1.0, "tau in weeks"), (week, 7.0, "tau in weeks, ramp 7"), (week, 42.0, None)):
        peak, _ = peak_at_a_point(ramp, tau)
        day_14, day_42 = at_a_point([14.0, 42.0], ramp, tau).tolist()
        row = [f"{deck.TAU:g} {'days' if tau == deck.TAU else 'weeks'}", f"{ramp:g}", peak, day_14, day_42,
               f"{(peak - day_14) / (peak - day_42):.0%}" if ramp < 14 else ""]
        if name:
            r = found[name]
            row += [r.peak()["lambda_e_max"], r.at("lambda_e_max", 14), r.at("lambda_e_max", 42), r.at("lambda_e_mean", 42)]
        rows.append(row + [""] * (10 - len(row)))
    return table(["τ", "ramp [d]", "point: peak", "point: day 14", "point: day 42", "of the fall by day 14", "cylinder: peak",
                  "largest, day 14", "largest, day 42", "mean, day 42"], rows)


def table_of_weeks(found):
    name = "paper" if "paper" in found and 42 in found["paper"].days else "medium"
    r, rows = found[name], []
    G_end, top = r.at("G_mean", 42), r.at("lambda_e_mean", 1)
    for start, end in ((0, 1), (1, 7), (7, 14), (14, 28), (28, 42)):
        G = [r.at("G_mean", t) if t else 1.0 for t in (start, end)]
        mean = [r.at("lambda_e_mean", t) if t else 1.0 for t in (start, end)]
        rows.append([f"{start} to {end}", f"{G[1] - G[0]:.4f}", f"{(G[1] - G[0]) / (G_end - 1):.0%}",
                     f"{(G[1] - G[0]) / (end - start):.5f}", mean[1], r.at("lambda_e_max", end),
                     f"{(mean[0] - mean[1]) / (top - r.at('lambda_e_mean', 42)):.0%}" if start else ""])
    return table(["days", "growth of mean G", "of all growth", "a day", "mean λe at the end", "largest λe at the end",
                  "of the fall of the mean"], rows) + f"\nMesh “{name}”.\n"


def tables(found):
    """Markdown of all tables."""
    note = ("† distance from the axis / from the nearer end, before the deformation. All λe are values at Gauss points.\n"
            "“edge”: the largest value in the surface (outer 5 % of the radius) of the first layer of muscle. “inside”: without\n"
            "the surface. “point”: the exact solution of eq. 4.\n")
    parts = [("Meshes", table_of_meshes), ("The clamped edge", table_of_edges), ("Length of the ramp", table_of_ramps),
             ("Ends", table_of_ends), ("Oblique fibres", table_of_fibres), ("Energy convention", table_of_energies),
             ("Days or weeks", table_of_times), ("When it grows, and when λe falls", table_of_weeks)]
    return "\n".join(f"**{title}**\n\n{make(found)}" for title, make in parts) + "\n" + note


def between_marks(path):
    """The page, and where its tables begin and end."""
    page = files.read_text(path)
    found = re.search(re.escape(BEGIN) + "(.*?)" + re.escape(END), page, re.S)
    if not found:
        raise files.FileError(f"{path}: no section between '{BEGIN.strip()}' and '{END.strip()}'")
    return page, *found.span(1)


def write_between_marks(path, text):
    page, begin, end = between_marks(path)
    files.write_text(path, page[:begin] + text + page[end:])


def arguments():
    p = argparse.ArgumentParser(prog=os.environ.get("MYOGROWTH_JOB", "studies.py"), description=__doc__,
                                formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    p.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/studies"), help="folder of runs, tables, figures")
    p.add_argument("--jobs", type=files.number(1, cylinder.MOST_THREADS, kind=int), default=len(os.sched_getaffinity(0)),
                   help="runs at a time, of one thread each")
    p.add_argument("--paper", type=pathlib.Path, default=PAPER,
                   help="a finished run of cylinder.py --size paper, for the table of meshes; left out where there is none")
    p.add_argument("--write", type=pathlib.Path,
                   help="a markdown file whose tables between two marks are to be made anew, and its figures in images/ "
                        "beside it")
    p.add_argument("--ccx", type=pathlib.Path, required=True, help="the executable")
    p.add_argument("--library-dir", type=pathlib.Path, required=True, help=f"the folder of {cylinder.LIBRARY}")
    a = p.parse_args()
    cylinder.check_programs(p, a)
    return a


def paper_run(folder):
    """The run of the paper's mesh, or None where there is none; its case must be the paper's."""
    if folder == PAPER and not (folder / "fields.npz").exists():
        return None
    different = kept.differences(kept.read_case(folder), deck.Case(size="paper"))
    if different:
        raise files.FileError(f"--paper {folder}: the run there has {different}")
    return Run(folder)


def job(a):
    import study_figures  # it needs this module, so not before

    files.make_folder(a.out)
    files.remove(a.out / name for name in ("tables.md", *study_figures.MADE))
    if a.write:  # before the work: whether it can be written
        between_marks(a.write)
        files.make_folder(a.write.parent / "images")
    paper = paper_run(a.paper)
    found = {name: Run(folder) for name, folder in do_all(a, runs()).items()}
    if paper:
        found["paper"] = paper
    text = tables(found)
    print("\n" + text)
    files.write_text(a.out / "tables.md", text)
    made = study_figures.draw(a.out, found)
    if a.write:
        write_between_marks(a.write, text)
        for name in made:
            with files.writing(a.write.parent / "images" / f"study_{name}") as part:
                shutil.copyfile(a.out / name, part)
    print(f"{a.out}/: tables.md, {', '.join(made)}")


def main():
    a = arguments()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with files.faults_in_one_line(os.environ.get("MYOGROWTH_JOB", "studies.py"), cylinder.Interrupted):
            job(a)
    except KeyboardInterrupt:
        print("\ninterrupted; the same command goes on", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
