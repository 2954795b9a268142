"""A real muscle, or the built-in one: its mesh is read and checked, the solver stretches it, pictures show it.

    ./run muscle                                          the built-in muscle, six weeks
    ./run muscle MESH --unit mm [Section/Entry=value ...] yours; a mesh with PROXIMAL and DISTAL needs no more
    ./run muscle MESH --unit mm --check                   only the report on the mesh
    ./run muscle MESH --unit mm --export calculix         a deck for another code, from the same input
"""
import argparse
import os
import pathlib
import re
import shlex
import subprocess
import sys

import entries
import export
import mesh as meshes
from raw import fail
from shared import files

FOLDER = pathlib.Path(__file__).resolve().parent
ENTRY = re.compile(r"[A-Z][A-Za-z]*/[^=]+=.*", re.DOTALL)


def arguments():
    p = argparse.ArgumentParser(prog=os.environ.get("MYOGROWTH_JOB", "muscle.py"), description=__doc__,
                                formatter_class=argparse.RawDescriptionHelpFormatter,
                                epilog="Section/Entry=value: entries of the solver, ./run muscle --entries lists them")
    meshes.add_options(p)
    p.add_argument("--prm", metavar="FILE", type=pathlib.Path, help="parameter file, in place of examples/muscle/muscle.prm")
    p.add_argument("--ranks", type=files.number(1, 999999, kind=int), default=2, metavar="N", help="of MPI (default 2)")
    p.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/muscle"), help="folder of the results")
    p.add_argument("--against", metavar="FOLDER", type=pathlib.Path, help="another run's results (with regions.csv, as ./run mpi has): "
                   "both on the same axes in against.png")
    p.add_argument("--check", action="store_true", help="only read the mesh, check it and report")
    p.add_argument("--export", choices=("abaqus", "calculix"), help="write a deck for that code, and do not run")
    p.add_argument("--program", type=pathlib.Path, help=argparse.SUPPRESS)
    given = [w for w in sys.argv[1:] if ENTRY.fullmatch(w)]
    a = p.parse_args(meshes.joined(w for w in sys.argv[1:] if not ENTRY.fullmatch(w)))
    a.entries = given
    for entry in given:
        name = entry.partition("=")[0]
        if name in ("Output/Folder", "Mesh/File") or name.startswith("Geometry/"):
            p.error(f"{name}: is not for this job: " + ("--out names the folder" if name == "Output/Folder" else "MESH names the mesh"))
    return p, a


def material_of(name):
    """By the name of a section: muscle, tendon or None."""
    word = name.rpartition(".")[2]
    return "muscle" if word.startswith("MUSCLE") else "tendon" if word.startswith(("TENDON", "APONEUROSIS")) else None


def own_entries(mesh, prm, given):
    """What the solver is told beside the .prm and the user's entries: materials by the sections' names, and for the built-in
    muscle a stretch of a tenth of its length without the tendons."""
    told = entries.override(entries.read(prm), given)
    found = []
    if not told.get("Materials/List", ("",))[0] and len(mesh.sections) > 1:
        unknown = [name for name in mesh.sections if material_of(name) is None]
        if unknown:
            fail(mesh.path, f"section {unknown[0]} has no material: give Materials/List=\"NAME muscle; NAME tendon; ...\" for "
                            f"{', '.join(mesh.sections)}")
        found.append("Materials/List=" + "; ".join(f"{name} {material_of(name)}" for name in mesh.sections))
    if mesh.raw.stretch and prm == FOLDER / "muscle.prm" and not any(g.startswith("Attachments/List") for g in given):
        found.append(f"Attachments/List=PROXIMAL fixed; DISTAL away {mesh.raw.stretch:.10g}")
    return found


def main():
    p, a = arguments()
    with files.faults_in_one_line(p.prog):
        mesh = meshes.from_options(p, a)
        text = meshes.report(mesh)
        print(text, end="", flush=True)
        if a.check:
            return 0
        prm = a.prm or FOLDER / "muscle.prm"
        more = own_entries(mesh, prm, a.entries)
        for entry in more:
            print(f"  entry          {entry}")
        out = files.make_folder(a.out)
        if a.export:
            told = entries.override(entries.read(FOLDER / "muscle.prm"), [])
            told.update(entries.read(prm))
            written = export.write(a.export, mesh, entries.override(told, more + a.entries), out)
            print("written: " + ", ".join(map(str, written)))
            return 0
        if a.program is None:
            p.error("--program is needed to run")
        from figures import NAMES, draw, read_regions  # after the checks: matplotlib takes a second

        if a.against:
            read_regions(a.against / "regions.csv")  # told before the run, if it is not there
        files.remove([out / name for name in (*NAMES, "against.png", "streamlines.csv")])
        files.write_text(out / "mesh_report.txt", text)
        files.write_text(out / "muscle.mesh", meshes.neutral(mesh), encoding="ascii")
        command = ["mpirun", "-n", str(a.ranks), str(a.program), str(prm), f"Mesh/File={out / 'muscle.mesh'}", f"Output/Folder={out}",
                   *more, *a.entries]
        print("\n$ " + shlex.join(command[3:]), flush=True)
        try:
            status = subprocess.run(command).returncode
        except KeyboardInterrupt:  # the solver has got it too, and says what is left
            return 130
        if status:
            return status if status > 0 else 1
        told = entries.override(entries.read(prm), a.entries)
        draw(mesh, out, float(told.get("Time/Ramp", ("1",))[0]), a.against)
        print(f"pictures: {', '.join(str(out / name) for name in (*NAMES, *(['against.png'] if a.against else [])))}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
