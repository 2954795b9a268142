"""What the MPI example costs: mpi_scaling.py MUSCLE [PART=loops,krylov,ranks,weak,muscle,answer]; Markdown tables on the screen.

`muscle` is six weeks of the biceps femoris of docs/muscle.md where its mesh lies in ../shared/data, else of the built-in one.
`answer` is six weeks of the paper's mesh in few steps, and how far its elastic stretch is from a run in ten times shorter ones.
CPU seconds are those of a rank (mean); a busy machine distorts them less than the clock. `loops` alternates the two loops.
"""
import pathlib
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "examples/common"))
import files  # noqa: E402  shared by all Python programs

# Layers of the coarsest mesh, refinements. Those of 16 layers have cells of one shape.
SIZES = {640: (16, 1), 5120: (16, 2), 40960: (16, 3), 10240: (32, 2), 51200: (20, 3)}
# The prototype's problem: backward Euler, six steps; linear systems solved to 1e-8 and a new preconditioner every step.
BASE = {"Muscle/Integration": "backward Euler", "Time/Steps": "fixed", "Time/Step": 0.1, "Time/Ramp": 0.6, "Time/End": 0.6,
        "Ends/Pull": 24, "Output/Times": "", "Output/Checkpoint every": 0}
AS_PROTOTYPE = {"Solver/Set up": "every step", "Solver/Krylov tolerance": 1e-8}
STAGES = ["law", "element", "insertion", "set_up", "krylov"]
REAL = TOP.parent / "shared/data/bflh_female_left.inp"


def start(command):
    status = subprocess.run(command, check=False, stdout=subprocess.DEVNULL).returncode
    if status != 0:
        sys.exit(f"mpi_scaling.py: {' '.join(map(str, command))}: ended with status {status}")


def solve(muscle, ranks, prm, entries):
    """The run's summary.json; its other files are in Output/Folder, if that is given."""
    with tempfile.TemporaryDirectory() as folder:
        folder = entries.get("Output/Folder", folder)
        entries = {**entries, "Output/Folder": folder}
        start(["mpirun", "-q", "-n", str(ranks), muscle, *prm, *(f"{entry}={value}" for entry, value in entries.items())])
        return files.read_json(pathlib.Path(folder, "summary.json"))


def run(muscle, ranks, elements, entries):
    layers, refinements = SIZES[elements]
    print(f"... {elements} elements, {ranks} ranks, {entries.get('Solver/Assembly', 'compact')}", file=sys.stderr, flush=True)
    return solve(muscle, ranks, [], {**BASE, "Geometry/Layers": layers, "Geometry/Refinements": refinements, **entries})


def row(name, s):
    cpu = s["cpu"]
    total = sum(cpu[stage] for stage in STAGES)
    stages = " | ".join(f"{cpu[stage]:.2f}" for stage in STAGES)
    print(f"| {name} | {stages} | **{total:.2f}** | {s['newton']} | {s['iterations'] / s['solves']:.1f} | {s['seconds']:.1f} | "
          f"{s['megabytes']:.0f} |", flush=True)
    return total


def head(title):
    print(f"\n{title}\n\n| | {' | '.join(STAGES)} | CPU per rank | Newton | GMRES per solve | wall | MB per rank |\n|{'---|' * 11}", flush=True)


def loops(muscle):
    for elements, repetitions in ((5120, 3), (51200, 1)):
        head(f"{elements} elements, 6 steps, one rank, CPU s: the loop one would write first, ours, and ours with its defaults")
        ratios = []
        for _ in range(repetitions):
            dense = row("dense", run(muscle, 1, elements, {**AS_PROTOTYPE, "Solver/Assembly": "dense"}))
            compact = row("compact", run(muscle, 1, elements, AS_PROTOTYPE))
            default = row("compact, defaults", run(muscle, 1, elements, {}))
            ratios.append((dense / compact, dense / default))
        print("\nratios:", ", ".join(f"{a:.2f} and {b:.2f}" for a, b in ratios))


def krylov(muscle):
    head("GMRES iterations to 1e-8 over a 64-fold range of sizes, cells of one shape, the first step, one rank")
    for elements in (640, 5120, 40960):
        row(f"{elements}", run(muscle, 1, elements, {**AS_PROTOTYPE, "Time/End": 0.1, "Time/Ramp": 0.1, "Ends/Pull": 4}))


def ranks(muscle):
    head("51,200 elements, 6 steps")
    for n in (1, 2):
        row(f"{n} ranks", run(muscle, n, 51200, {}))


def weak(muscle):
    head("5,120 elements per rank, 6 steps: a muscle of 400 mm, and one of 800 mm on two ranks")
    row("1 rank", run(muscle, 1, 5120, {}))
    row("2 ranks", run(muscle, 2, 10240, {"Geometry/Length": 800, "Ends/Pull": 48}))


def real(muscle):
    with tempfile.TemporaryDirectory() as folder:
        mesh = pathlib.Path(folder, "muscle.mesh")
        given, more, kinds = [str(REAL), "--unit", "mm"], {}, {"C3D4": {}, "C3D10": {"Mesh/Degree": 2}}
        if not REAL.is_file():
            print(f"... there is no {REAL}: the built-in muscle", file=sys.stderr, flush=True)
            given, kinds, more = [], {"C3D8": {}}, {"Materials/List": "MUSCLE muscle; TENDON tendon"}
        start([sys.executable, str(TOP / "examples/muscle/mesh.py"), *given, "-o", str(mesh)])
        head(f"Six weeks of {'the biceps femoris' if REAL.is_file() else 'the built-in muscle'}, 2 ranks")
        for kind, degree in kinds.items():
            print(f"... {kind}", file=sys.stderr, flush=True)
            s = solve(muscle, 2, [str(TOP / "examples/muscle/muscle.prm")], {"Mesh/File": mesh, **more, **degree})
            row(f"{s['elements']} {kind}, {s['unknowns']} unknowns, {s['steps']} steps", s)


def stretches(folder, day):
    """Elastic stretch of all nodes of a run's fields, rank by rank."""
    import meshio
    import numpy

    return numpy.concatenate([meshio.read(path).point_data["lambda_e"] for path in sorted(folder.glob(f"day_{day}.*.vtu"))])


def answer(muscle, size="paper", ranks=2):
    sys.path.insert(0, str(TOP / "examples/calculix"))
    import cylinder_mesh

    days, step, part, longest = (1, 42), 0.1, 0.25, 14
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        cylinder_mesh.write_text(folder / "mesh", cylinder_mesh.mesh(size))
        head(f"The cylinder's {size} mesh, six weeks, {ranks} ranks")
        for name, shorter in (("few", 1), ("ten times shorter", 10)):
            print(f"... {name} steps", file=sys.stderr, flush=True)
            s = solve(muscle, ranks, [str(TOP / "examples/dealii/biceps.prm")], {
                "Geometry/Kind": "file", "Geometry/File": folder / "mesh", "Output/Folder": folder / name, "Output/Checkpoint every": 0,
                "Output/Times": ",".join(map(str, days)), "Time/Tolerance": 1e-2, "Time/Step": step / shorter,
                "Time/Part": part / shorter, "Time/Longest": longest / shorter})
            row(f"{s['elements']} elements, {s['steps']} steps", s)
        for day in days:
            few, many = (stretches(folder / name, day) for name in ("few", "ten times shorter"))
            print(f"\nday {day}: lambda_e differs by at most {abs(few - many).max():.1e}")


def main():
    if len(sys.argv) < 2:
        sys.exit("usage: mpi_scaling.py MUSCLE [PART=loops,krylov,ranks,weak,muscle,answer]")
    parts = {"loops": loops, "krylov": krylov, "ranks": ranks, "weak": weak, "muscle": real, "answer": answer}
    chosen = list(parts)
    for argument in sys.argv[2:]:
        if not argument.startswith("PART=") or not set(argument[5:].split(",")) <= set(parts):
            sys.exit(f"mpi_scaling.py: {argument}: must be PART= and some of {','.join(parts)}")
        chosen = argument[5:].split(",")
    for part in chosen:
        parts[part](sys.argv[1])


if __name__ == "__main__":
    with files.faults_in_one_line("mpi_scaling.py"):
        main()
