"""The paper's cube test: runs the one-element driver, compares with the exact solution, draws Figs 2 and 4; with an
elastic law other than eq. 3, the force-length curve before and after as well.

A cube of muscle with its fibre along the pull is stretched in a ramp and held; its sides are free. Its fibre stretch
is then the stretch of the cube, and eq. 4 an ordinary differential equation that needs no finite elements.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples/common"))
import files  # noqa: E402
from eq4 import exact, stretch  # noqa: E402

CASE = """! The paper's cube test, written by ./run cube
&material
  props = {c1!r}, {c2!r}, {tau!r}, {gamma!r}, {G_max!r}, {lambda_crit!r}, 1.0, 0.0, 0.0{law}   ! fibre along x
/
{field}&time
  duration = {duration!r}
  dt       = {step!r}
/
&face name = 'x-', control = 'displacement', value = 0.0 /
&face name = 'y-', control = 'displacement', value = 0.0 /
&face name = 'z-', control = 'displacement', value = 0.0 /
&face
  name    = 'x+'
  control = 'displacement'
  time    = {times}
  value   = {values}
/
&output
  print_every = {print_every!r}
/
"""
FILES = ("cube.nml", "history.csv", "newton.log", "fig2_elastic_stretch.png", "fig4_sarcomere_number.png")
COLUMNS = "time,G,lambda_e,lambda,J,Je,s11,s22,s33,s12,s13,s23,reaction,iterations".split(",")
FORCE_LENGTH = "force_length.png"  # with --law
POINT = """&material
  props = 0.0, 0.0, {tau!r}, {gamma!r}, {G_max!r}, 1000.0, 1.0, 0.0, 0.0, 9*0.0, {law}.0, {activation!r}
  statev_initial = {G!r}
/
"""
MOST_INCREMENTS = 100_000


def folder(text):
    if not text:
        raise argparse.ArgumentTypeError("the name of a folder is empty")
    return pathlib.Path(text)


class Once(argparse.Action):
    """An option that is given twice is an error: which of the two is meant?"""

    def __call__(self, parser, namespace, value, option_string=None):
        given = vars(namespace).setdefault("given", set())
        if self.dest in given:
            parser.error(f"{option_string} is given twice")
        given.add(self.dest)
        setattr(namespace, self.dest, value)


def arguments():
    p = argparse.ArgumentParser(prog="./run cube", description=__doc__.split("\n\n")[1], allow_abbrev=False,
                                formatter_class=argparse.ArgumentDefaultsHelpFormatter,
                                epilog="Exit status: 0 done, 1 a file cannot be read or written, 2 an option is wrong; "
                                       "else the driver's: 1 a parameter is wrong, 2 the run could not be finished, "
                                       "3 a result could not be written.")

    def add(option, default, text, **more):
        p.add_argument(option, action=Once, type=more.pop("type", files.number()), default=default, help=text, **more)

    add("--stretch", 1.10, "stretch that is held [-]", type=files.number(above=0))
    add("--ramp", 1.0, "time of the ramp to it; 0: at once [days]", type=files.number(0))
    add("--duration", 42.0, "end of the test [days]", type=files.number(above=0))
    add("--step", 0.01, "time increment [days]", type=files.number(above=0))
    add("--c1", 16.0, "first Lame constant [kPa]")
    add("--c2", 4.0, "second Lame constant [kPa]")
    add("--tau", 0.5, "time constant of growth [days]")
    add("--gamma", 2.0, "shape exponent [-]")
    add("--G-max", 1.1, "largest sarcomere number [-]", dest="G_max")
    add("--lambda-crit", 1.01, "elastic stretch above which sarcomeres are added [-]", dest="lambda_crit")
    add("--law", 0, "elastic law (docs/laws.md): 0 neo-Hookean, 1 Roehrle, 2 Blemker, 3 Ehret", type=int, choices=range(4))
    add("--activation", 0.0, "of laws 1 to 3; it rises in the ramp of the stretch [-]", type=files.number(0))
    add("--out", pathlib.Path("out/cube"), "folder of the results", type=folder)
    p.add_argument("--driver", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    a = p.parse_args()
    if a.ramp > a.duration:
        p.error(f"--ramp = {a.ramp}: must be at most --duration = {a.duration}")
    for name in ("c1", "c2") if a.law else ("activation",):
        if name in getattr(a, "given", ()):
            p.error(f"--{name}: is not of --law {a.law}")
    if a.activation > 1:
        p.error(f"--activation = {a.activation}: must be from 0 to 1")
    if a.law:
        a.c1 = a.c2 = 0.0
    if not a.duration / MOST_INCREMENTS <= a.step <= a.duration:
        p.error(f"--step = {a.step}: must be between --duration/{MOST_INCREMENTS} and --duration = {a.duration}")
    return a


def run(a):
    """The columns of the history that this run has written."""
    files.make_folder(a.out)
    files.lock(a.out / "lock")
    files.remove(a.out / name for name in (*FILES, FORCE_LENGTH))
    case = a.out / "cube.nml"
    if a.ramp > 0:
        times, values = f"0.0, {a.ramp!r}", f"0.0, {a.stretch - 1!r}"
    else:
        times, values = "0.0", f"{a.stretch - 1!r}"
    # Force that appears at once, without deformation, is too hard a step for Newton's method with law 3.
    rises = a.law > 0 and a.activation > 0 and a.ramp > 0
    law = f", 9*0.0, {a.law}.0, {-1.0 if rises else a.activation!r}" if a.law else ""
    field = f"&field time = 0.0, {a.ramp!r} value = 0.0, {a.activation!r} /   ! the activation\n" if rises else ""
    files.write_text(case, CASE.format(**{**vars(a), "law": law, "field": field}, times=times, values=values, print_every=a.duration / 14))
    given = [f"./{name}" if str(name).startswith("-") else name for name in (case, a.out)]  # else it would be an option
    status = subprocess.run([a.driver, given[0], "--out", given[1]]).returncode
    if status < 0:
        raise files.FileError(f"{a.driver}: {files.ended(status)}")
    if status:
        sys.exit(status)
    history = a.out / "history.csv"
    rows = {name: np.array(values) for name, values in files.read_columns(history, COLUMNS).items()}
    if abs(rows["time"][-1] - a.duration) > 1e-9 * a.duration:
        raise files.FileError(f"{history}: ends at time {rows['time'][-1]:g}, not at --duration = {a.duration:g}")
    return rows


def force_length(a, G, activation):
    """Stretches of the whole muscle, and its force per reference area, at a sarcomere number that stays: a strip whose
    sides are free. Rows of a path are points of their own then; their lateral stretches are bisected all at once."""
    stretch = np.linspace(0.7, 1.45, 61) if a.law == 3 else np.linspace(0.6, 2.2, 65)
    width = 1.15 if a.law == 3 else 1.3
    low, high = stretch**-0.5 / width, stretch**-0.5 * width
    with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
        case, path = pathlib.Path(folder) / "point.nml", pathlib.Path(folder) / "path.csv"
        case.write_text(POINT.format(**{**vars(a), "activation": activation, "G": float(G)}))

        def stresses(side):
            lines = [f"{n + 1},{x!r},0,0,0,{y!r},0,0,0,{y!r}\n" for n, (x, y) in enumerate(zip(stretch.tolist(), side.tolist()))]
            path.write_text("time,F11,F12,F13,F21,F22,F23,F31,F32,F33\n" + "".join(lines))
            done = subprocess.run([a.driver, case, "--path", path, "--out", folder, "--quiet"], stderr=subprocess.PIPE, text=True)
            if done.returncode:
                raise files.FileError(f"{a.driver}: the force-length curve: {done.stderr.strip() or files.ended(done.returncode)}")
            read = files.read_columns(pathlib.Path(folder) / "history.csv", COLUMNS)
            return np.array(read["s11"]), np.array(read["s22"])

        bracketed = (stresses(low)[1] < 0) & (stresses(high)[1] > 0)
        for _ in range(24):
            middle = (low + high) / 2
            along, across = stresses(middle)
            low, high = np.where(across > 0, low, middle), np.where(across > 0, middle, high)
    return stretch, np.where(bracketed, along * middle**2, np.nan)


def draw_force_length(a, G):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig, ax = plt.subplots(figsize=(6.4, 4.2), dpi=130)
    for number, colour, when in ((1.0, "#1d3f72", "before, G = 1"), (G, "#b3331d", f"after {a.duration:g} d, G = {G:.4f}")):
        passive = force_length(a, number, 0.0)
        ax.plot(*passive, "--", lw=1.2, color=colour, label=f"passive, {when}")
        if a.activation > 0:
            ax.plot(*force_length(a, number, a.activation), lw=1.6, color=colour, label=f"activation {a.activation:g}, {when}")
    ax.axvline(a.stretch, color="0.55", lw=0.8, ls=":")
    ax.set_xlabel("stretch of the whole muscle [-]")
    ax.set_ylabel("force per reference area [kPa]")
    ax.set_title(f"Force-length curve of a strip, elastic law {a.law}; dotted: the stretch that is held", fontsize=9.5)
    ax.grid(alpha=0.25)
    ax.legend(fontsize=8, frameon=False)
    fig.tight_layout()
    with files.writing(a.out / FORCE_LENGTH) as part:
        fig.savefig(part)
    plt.close(fig)


def compare(a, rows, G):
    """A table of the computed values beside the exact ones."""
    time, computed = rows["time"], rows["lambda_e"]
    reference = np.array([stretch(a, t) for t in time]) / G
    lines = [("peak lambda_e", computed.max(), reference.max())]
    for day in sorted({14.0, a.duration}):
        i = np.abs(time - day).argmin()
        if day <= a.duration:
            lines.append((f"lambda_e, day {time[i]:g}", computed[i], reference[i]))
    lines.append((f"G, day {a.duration:g}", rows["G"][-1], G[-1]))
    print(f"\n{'against the exact solution':28}{'computed':>10}{'exact':>10}{'difference':>12}")
    for name, value, right in lines:
        print(f"{name:28}{value:10.5f}{right:10.5f}{value - right:12.1e}")


def draw(a, rows, G):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    t = rows["time"]
    held = f"{100 * (a.stretch - 1):g} % stretch" + (f", ramped over {a.ramp:g} d and held" if a.ramp else ", held")
    law = rf"$\tau$ = {a.tau:g} d, $\gamma$ = {a.gamma:g}, $G_{{max}}$ = {a.G_max:g}, $\lambda_{{crit}}$ = {a.lambda_crit:g}"
    step = rf"backward Euler, $\Delta t$ = {a.step:g} d"
    early = np.flatnonzero(t <= 2 * a.ramp)
    shown = np.union1d(np.arange(0, len(t), max(1, len(t) // 60)), early[:: max(1, len(early) // 20)])

    def figure(name, column, reference, label, title, lines):
        fig, ax = plt.subplots(figsize=(6.4, 4.2), dpi=130)
        ax.plot(t[shown], rows[column][shown], "o", ms=3.5, color="#b3331d",
                label=f"one-element test, {step}")
        ax.plot(t, reference, "--", lw=1.4, color="#1d3f72", label="exact solution of eq. 4")
        for value, text, offset in lines:
            ax.axhline(value, color="0.55", lw=0.8, ls=":")
            ax.annotate(text, (0.99, value), xycoords=("axes fraction", "data"), xytext=(0, offset),
                        textcoords="offset points", ha="right", va="bottom" if offset > 0 else "top", color="0.35",
                        fontsize=8.5)
        ax.set_xlabel("time [days]")
        ax.set_ylabel(label)
        ax.set_title(f"{title}\n{held}; {law}", fontsize=9.5)
        ax.set_xlim(-0.01 * a.duration, a.duration)
        ax.margins(y=0.1)
        ax.grid(alpha=0.25)
        ax.legend(loc="center right", fontsize=8.5, frameon=False)
        fig.tight_layout()
        with files.writing(a.out / name) as part:
            fig.savefig(part)
        plt.close(fig)

    figure("fig2_elastic_stretch.png", "lambda_e", [stretch(a, s) / g for s, g in zip(t, G)],
           r"elastic fibre stretch $\lambda_e$ [-]", "Relative sarcomere length (the paper's Fig. 2)",
           [(a.lambda_crit, r"$\lambda_{crit}$: no growth below", -3)])
    limit = min(a.G_max, a.stretch / a.lambda_crit)
    text = r"$G_{max}$" if limit == a.G_max else r"$\lambda/\lambda_{crit}$: where growth ends"
    figure("fig4_sarcomere_number.png", "G", G, r"relative serial sarcomere number $G$ [-]",
           "Sarcomeres in series (the paper's Fig. 4)", [(limit, text, 3)] if limit > 1 else [])


def main():
    a = arguments()
    rows = run(a)
    G = exact(a, rows["time"])
    compare(a, rows, G)
    draw(a, rows, G)
    if a.law:
        draw_force_length(a, rows["G"][-1])
    print(f"\n{a.out}/: {', '.join((*FILES, *[FORCE_LENGTH] * (a.law > 0)))}")


if __name__ == "__main__":
    with files.faults_in_one_line("./run cube", ImportError, ValueError):
        try:
            main()
        except KeyboardInterrupt:
            sys.exit("./run cube: interrupted")
