"""The biceps femoris as a cylinder in CalculiX: stretched by 10 % in a day and held for six weeks, while it grows.

Writes the decks, runs ccx in legs from one time of output to the next, and makes of what it writes: history.csv, VTU
files and cylinder.pvd for ParaView, fields.npz, and figures. Needs a ccx that can load libraries (build_ccx.sh) and
libMYOGROWTH.so.
"""
import argparse
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import numpy as np

import cylinder_mesh
import deck
import figures
import frd
import history
import kept
import vtu
from shared import files

FIELDS = ("DISP", "STRESS", "FORC", "SDV")  # of the nodes, in the .frd of every leg
LIBRARY = "libMYOGROWTH.so"
MOST_THREADS = 256


class JobError(files.FileError):
    """What ended the job, in words for the user."""


def arguments():
    default = deck.Case()
    p = argparse.ArgumentParser(prog=os.environ.get("MYOGROWTH_JOB", "cylinder.py"), description=__doc__,
                                formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    p.add_argument("--size", choices=cylinder_mesh.SIZES, default=default.size,
                   help="how fine the mesh is; coarse, medium and fine have thin layers at the ends, where the stretch varies; "
                        "paper equal ones and as many elements as the paper's")
    p.add_argument("--ends", choices=deck.ENDS, default=default.ends,
                   help="clamped; free to become thinner; tendon: clamped, with a stiff layer that does not grow; or mixed: "
                        "the proximal end clamped, the distal one free to become thinner")
    p.add_argument("--tendon-length", type=float, default=default.tendon_length, help="of the stiff layer at each end [mm]")
    p.add_argument("--tendon-stiffness", type=float, default=default.tendon_stiffness, help="of that layer, over the muscle's")
    p.add_argument("--pull", type=float, default=default.pull, help="displacement of the distal end [mm of 400]")
    p.add_argument("--ramp", type=float, default=default.ramp, help="time of the ramp to it [days]")
    p.add_argument("--duration", type=float, default=default.duration, help="end of the test [days]")
    p.add_argument("--tau", type=float, default=default.tau, help="time constant of growth [days]")
    p.add_argument("--fibre-angle", type=float, default=default.fibre_angle,
                   help="between fibres and axis, in the x-z plane [degrees]")
    p.add_argument("--energy", type=int, choices=(0, 1), default=default.energy,
                   help="elastic energy per unit of 0: reference volume, 1: grown volume")
    p.add_argument("--integration", type=int, choices=(0, 1), default=default.integration,
                   help="of growth in time, 0: backward Euler, 1: second order")
    p.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/cylinder"), help="folder of the results")
    p.add_argument("--resume", action="store_true", help="go on after the last whole leg of an interrupted run")
    p.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)), help="of ccx")
    p.add_argument("--ccx", type=pathlib.Path, required=True, help="the executable")
    p.add_argument("--library-dir", type=pathlib.Path, required=True, help=f"the folder of {LIBRARY}")
    a = p.parse_args()

    def check(name, good, allowed):
        if not good:
            p.error(f"--{name.replace('_', '-')} = {getattr(a, name)}: must be {allowed}")

    for name in ("ramp", "duration", "pull", "fibre_angle", "tendon_length", "tendon_stiffness", "tau"):
        check(name, math.isfinite(getattr(a, name)), "finite")
    # CalculiX prints times with seven digits: they must tell the increments of a ramp apart to the end.
    check("ramp", 1e-4 <= a.ramp <= 3650, "> 0, at least 0.0001 and at most 3650")
    check("duration", a.duration >= a.ramp, f">= --ramp = {a.ramp:g}")
    check("duration", a.duration <= 3650, "<= 3650, ten years")
    check("duration", a.duration == a.ramp or a.duration >= (1 + deck.NEAR) * a.ramp,
          f"--ramp = {a.ramp:.12g}, or more than it by {deck.NEAR:.1%} at least")
    check("pull", 0 < a.pull <= 200, "> 0 and <= 200")
    check("fibre_angle", 0 <= a.fibre_angle < 90, ">= 0 and < 90")
    check("tendon_length", 0 < a.tendon_length < 200, "> 0 and < 200")
    check("tendon_stiffness", 0 < a.tendon_stiffness <= 1e6, "> 0 and <= 1e6")
    check("tau", a.tau > 0, "> 0")
    check("tau", 1e-3 <= a.tau <= 1e6, ">= 0.001 and <= 1e6")
    check("ramp", a.ramp <= 1500 * a.tau, f"<= 1500 times --tau = {a.tau:g}: it takes steps of twice that time, 1000 at most")
    check("threads", 0 < a.threads <= MOST_THREADS, f"> 0 and <= {MOST_THREADS}")
    check_programs(p, a)
    return a


def check_programs(p, a):
    if not (a.ccx.is_file() and os.access(a.ccx, os.X_OK)):
        p.error(f"--ccx = {a.ccx}: must be an executable file")
    if not (a.library_dir / LIBRARY).is_file():
        p.error(f"--library-dir = {a.library_dir}: must be a folder with {LIBRARY}")
    if os.pathsep in str(a.library_dir.resolve()):
        p.error(f"--library-dir = {a.library_dir}: must have no '{os.pathsep}' in its whole name, where the linker would cut it")


class Interrupted(Exception):
    """Ctrl-C, or a request to end."""


class Progress:
    """One line that says how far the job is; on a terminal it is written over, elsewhere one line a leg."""

    def __init__(self, increments):
        self.increments, self.done, self.skipped, self.start, self.width = increments, 0, 0, time.monotonic(), 0

    def skip(self, increments):
        self.done += increments
        self.skipped += increments

    def tell(self, row, line_stays):
        share = min(self.done / self.increments, 1.0)
        here = self.done - self.skipped
        left = (time.monotonic() - self.start) / here * max(self.increments - self.done, 0) if here else 0
        text = (f"increment {self.done} of about {self.increments}   day {row[0]:.2f}   largest lambda_e {row[2]:.4f}   "
                f"{100 * share:.0f} %" + (f"   about {left:.0f} s left" if share < 1 else ""))
        if sys.stdout.isatty():
            print("\r" + text.ljust(self.width), end="\n" if line_stays else "", flush=True)
            self.width = len(text)
        elif line_stays:
            print(text, flush=True)


def errors_in(log):
    """What ccx or the material said of an error: the lines from the first one on, a dozen at most."""
    lines = log.read_text(errors="replace").splitlines()
    first = next((i for i, line in enumerate(lines) if re.match(r"\s*\*ERROR|\s*myogrowth", line)), None)
    shown = lines[-12:] if first is None else lines[first:first + 12]
    return "\n".join(line for line in shown if line.strip())


def fields_of(path, mesh, day):
    """The last step of a .frd, which must have all fields in all nodes of the mesh on that day."""
    results = frd.read_frd(path)
    for name, cells, wanted in (("C3D8", results.hexes, mesh.hexes), ("C3D6", results.wedges, mesh.wedges)):
        if not np.array_equal(cells, wanted):
            raise JobError(f"{path}: the {name} are not those of the mesh")
    if not results.steps or not kept.ends_on(results.steps[-1].time, day):
        raise JobError(f"{path}: ends on day {results.steps[-1].time if results.steps else 0:g}, not on day {day:g}")
    for name in FIELDS:
        values = results.steps[-1].fields.get(name)
        if values is None or not np.isfinite(values).all():
            raise JobError(f"{path}: has no {name}" + ("" if values is None else " in some of the nodes"))
    return results.steps[-1]


def run_leg(a, folder, name, mesh, gauss, end, progress):
    """Runs ccx on <name>.inp. Rows of the history, one for every increment, and the last state of the Gauss points, once
    all that ccx should have written to the day `end` is there."""
    path = os.pathsep.join(filter(None, [str(a.library_dir.resolve()), os.environ.get("LD_LIBRARY_PATH")]))
    environment = {**os.environ, "OMP_NUM_THREADS": str(a.threads), "LD_LIBRARY_PATH": path}
    log, dat = folder / f"{name}.log", frd.Dat(folder / f"{name}.dat")
    rows, state, reaction = [], None, None

    def follow(job_has_ended):
        nonlocal state, reaction
        if not dat.path.exists():
            return
        for block in dat.read(job_has_ended):
            if block.name == "SDV":
                gauss.check(block)
                state = block
            else:
                reaction = block
            if state is not None and reaction is not None and state.time == reaction.time:
                rows.append(history.row(gauss, state, reaction))
                progress.done += 1
                progress.tell(rows[-1], line_stays=False)
                reaction = None

    with open(log, "wb") as out:
        # In a session of its own, so that Ctrl-C comes only to us and we end it.
        ccx = subprocess.Popen([a.ccx.resolve(), name], cwd=folder, stdout=out, stderr=subprocess.STDOUT,
                               stdin=subprocess.DEVNULL, env=environment, start_new_session=True, pass_fds=files.locks())
        try:
            while ccx.poll() is None:
                follow(job_has_ended=False)
                time.sleep(0.2)
        finally:
            if ccx.poll() is None:
                ccx.kill()
                ccx.wait()
    if ccx.returncode != 0:
        raise JobError(f"ccx {files.ended(ccx.returncode)}; {log} says:\n{errors_in(log)}")
    follow(job_has_ended=True)
    if not rows:
        raise JobError(f"ccx printed no results; {log} says:\n{errors_in(log)}")
    if not kept.ends_on(rows[-1][0], end):
        raise JobError(f"{dat.path} ends on day {rows[-1][0]:g}, not on day {end:g}; {log} says:\n{errors_in(log)}")
    fields_of(folder / f"{name}.frd", mesh, end)
    progress.tell(rows[-1], line_stays=True)
    return rows, state.values


def start_folder(a, case):
    """The folder of ccx's files, empty but for what --resume goes on from. No results are left in a.out until this run
    has its own."""
    programs = kept.programs(a.ccx, a.library_dir / LIBRARY)
    if a.resume:
        if not (a.out / "case.json").is_file():
            raise JobError(f"--resume: there is no run in {a.out}")
        different = kept.differences(kept.read_case(a.out), case)
        if different:
            raise JobError(f"--resume: the run in {a.out} has {different}")
        for name in kept.changed_programs(a.out, programs):
            print(f"warning: {name} is not the one that this run was begun with", file=sys.stderr)
    files.make_folder(a.out)
    folder = files.make_folder(a.out / "ccx")
    files.lock(folder / "lock")
    files.remove([*a.out.glob("day_*.vtu"), *(a.out / name for name in ("history.csv", "cylinder.pvd", "fields.npz",
                                                                       *figures.NAMES))])
    if not a.resume:
        files.remove(folder.glob("leg*"))
        kept.write_case(a.out, case)
        kept.write_programs(a.out, programs)
    return folder


def run_legs(a, case, mesh, gauss, folder, progress_of=Progress):
    """The rows of the history, and the states of the Gauss points at the ends of the legs."""
    legs = deck.leg_times(case)
    planned = [sum(map(deck.planned_increments, deck.steps_of_leg(case, start, end, mesh.levels[-1] - mesh.levels[-2])))
               for start, end in legs]
    progress = progress_of(sum(planned))
    all_rows, states = [], []
    for k, (start, end) in enumerate(legs):
        name, result, inp = f"leg{k}", folder / f"leg{k}.npz", deck.leg(case, mesh, k)
        if a.resume and result.is_file():
            rows, state, restart = kept.read_leg(result, inp, folder / f"{name}.frd", len(gauss.places), end)
            progress.skip(planned[k])
        else:
            rin = folder / f"{name}.rin"
            if a.resume and k > 0 and kept.digest(files.read_bytes(rin)) != restart:
                raise JobError(f"{rin}: is cut, or not the one that this run wrote: {kept.AGAIN}")
            for path in folder.glob(f"{name}.*"):
                if path.suffix != ".rin":
                    path.unlink()
            files.write_text(folder / f"{name}.inp", inp, encoding="ascii")
            try:
                rows, state = run_leg(a, folder, name, mesh, gauss, end, progress)
            except KeyboardInterrupt:
                raise Interrupted(f"\ninterrupted between day {start:g} and {end:g}; to go on from day {start:g}: "
                               "the same command with --resume") from None
            # Once the .npz is there, the leg is done: it has the printed results, and the leg's own restart file can go.
            with files.writing(result) as part:
                rout = folder / f"{name}.rout" if k + 1 < len(legs) else None
                restart = kept.write_leg(part, rows, state, inp, folder / f"{name}.frd", rout)
                if rout:
                    os.replace(rout, folder / f"leg{k + 1}.rin")
            for suffix in (".dat", ".rin", ".rout"):
                (folder / f"{name}{suffix}").unlink(missing_ok=True)
        all_rows += rows
        states.append(np.asarray(state, dtype=np.float32))
    return all_rows, states


def write_results(a, case, mesh, gauss, stiff, folder, rows, states):
    history.write(a.out / "history.csv", rows)
    times, written, displacements = [], [], []
    for k, (_, day) in enumerate(deck.leg_times(case)):
        step = fields_of(folder / f"leg{k}.frd", mesh, day)
        fields = step.fields
        times.append(day)
        written.append(a.out / f"day_{day:g}.vtu")
        vtu.write_fields(written[-1], mesh, fields, step.components, gauss.element_means(states[k]), stiff, deck.fibre(case))
        displacements.append(fields["DISP"].astype(np.float32))
    vtu.write_collection(a.out / "cylinder.pvd", times, written)
    with files.writing(a.out / "fields.npz") as part:
        np.savez_compressed(part, times=times, names=deck.STATE, displacement=displacements, gauss=states,
                            element=gauss.elements, point=gauss.numbers, place=gauss.places, volume=gauss.volumes,
                            muscle=gauss.muscle)


def job(a):
    case = deck.Case(**{name: getattr(a, name) for name in deck.Case._fields})
    mesh = cylinder_mesh.mesh(case.size)
    stiff = deck.tendon(case, mesh)
    if case.ends == "tendon" and not stiff.any():
        raise JobError(f"--tendon-length = {case.tendon_length:g}: must be more than half the height of the first layer, "
                       f"{mesh.levels[1]:g} mm")
    if stiff.all():
        raise JobError(f"--tendon-length = {case.tendon_length:g}: leaves no layer of muscle between the tendons")
    folder = start_folder(a, case)
    gauss = history.GaussPoints(mesh, stiff)
    print(f"{len(mesh.hexes)} C3D8 and {len(mesh.wedges)} C3D6, {len(mesh.nodes)} nodes, {a.threads} threads", flush=True)
    if stiff.any():
        layers = len(np.unique(mesh.layer_of_elements()[stiff])) // 2
        print(f"tendon: {layers} layers at either end, {mesh.levels[layers]:g} mm of it", flush=True)
    rows, states = run_legs(a, case, mesh, gauss, folder)
    write_results(a, case, mesh, gauss, stiff, folder, rows, states)
    peak = max(rows, key=lambda r: r[2])
    x, y, z = peak[8:]
    print(f"largest lambda_e {peak[2]:.4f} on day {peak[0]:.2f}, {math.hypot(x, y):.1f} mm from the axis and "
          f"{min(z, cylinder_mesh.LENGTH - z):.1f} mm from an end")
    print(f"day {rows[-1][0]:g}: lambda_e {rows[-1][4]:.4f} to {rows[-1][2]:.4f}, G {rows[-1][7]:.4f} to {rows[-1][5]:.4f}, "
          f"force {rows[-1][1]:.1f} mN")
    made = figures.draw(a.out)
    print(f"{a.out}/: history.csv, cylinder.pvd and its VTU files, fields.npz, {', '.join(made)}")


def main():
    a = arguments()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C: ccx must not live on without us
    try:
        with files.faults_in_one_line(os.environ.get("MYOGROWTH_JOB", "cylinder.py")):
            job(a)
    except Interrupted as e:
        print(e, file=sys.stderr)
        sys.exit(130)
    except KeyboardInterrupt:  # while the results were written
        sys.exit(130)


if __name__ == "__main__":
    main()
