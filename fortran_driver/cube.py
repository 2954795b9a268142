"""The paper's cube test: runs the one-element driver, compares with the exact solution, draws Figs 2 and 4.

A cube of muscle with its fibre along the pull is stretched in a ramp and held; its sides are free. Its fibre stretch
is then the stretch of the cube, and eq. 4 an ordinary differential equation that needs no finite elements.
"""
import argparse
import csv
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples/common"))
from eq4 import exact, stretch  # noqa: E402

CASE = """! The paper's cube test, written by ./run cube
&material
  props = {c1!r}, {c2!r}, {tau!r}, {gamma!r}, {G_max!r}, {lambda_crit!r}, 1.0, 0.0, 0.0   ! fibre along x
/
&time
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


def arguments():
    p = argparse.ArgumentParser(prog="./run cube", description=__doc__.split("\n\n")[1],
                                formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    p.add_argument("--stretch", type=float, default=1.10, help="stretch that is held [-]")
    p.add_argument("--ramp", type=float, default=1.0, help="time of the ramp to it; 0: at once [days]")
    p.add_argument("--duration", type=float, default=42.0, help="end of the test [days]")
    p.add_argument("--step", type=float, default=0.01, help="time increment [days]")
    p.add_argument("--c1", type=float, default=16.0, help="first Lame constant [kPa]")
    p.add_argument("--c2", type=float, default=4.0, help="second Lame constant [kPa]")
    p.add_argument("--tau", type=float, default=0.5, help="time constant of growth [days]")
    p.add_argument("--gamma", type=float, default=2.0, help="shape exponent [-]")
    p.add_argument("--G-max", dest="G_max", type=float, default=1.1, help="largest sarcomere number [-]")
    p.add_argument("--lambda-crit", dest="lambda_crit", type=float, default=1.01,
                   help="elastic stretch above which sarcomeres are added [-]")
    p.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/cube"), help="folder of the results")
    p.add_argument("--driver", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    a = p.parse_args()
    for name in ("stretch", "step", "duration"):
        if not getattr(a, name) > 0:
            p.error(f"--{name} = {getattr(a, name)}: must be > 0")
    if not 0 <= a.ramp <= a.duration:
        p.error(f"--ramp = {a.ramp}: must be between 0 and --duration = {a.duration}")
    return a


def run(a):
    a.out.mkdir(parents=True, exist_ok=True)
    case = a.out / "cube.nml"
    if a.ramp > 0:
        times, values = f"0.0, {a.ramp!r}", f"0.0, {a.stretch - 1!r}"
    else:
        times, values = "0.0", f"{a.stretch - 1!r}"
    case.write_text(CASE.format(times=times, values=values, print_every=a.duration / 14, **vars(a)))
    status = subprocess.run([a.driver, case, "--out", a.out]).returncode
    if status:
        sys.exit(status)
    with open(a.out / "history.csv", encoding="utf-8") as f:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def compare(a, rows, G):
    """A table of the computed values beside the exact ones."""
    peak = max(range(len(rows)), key=lambda i: rows[i]["lambda_e"])
    i_exact = max(range(len(rows)), key=lambda i: stretch(a, rows[i]["time"]) / G[i])

    def at(day):
        return min(range(len(rows)), key=lambda i: abs(rows[i]["time"] - day))

    lines = [("peak lambda_e", rows[peak]["lambda_e"], stretch(a, rows[i_exact]["time"]) / G[i_exact])]
    for day in sorted({14.0, a.duration}):
        if day <= a.duration:
            i = at(day)
            lines.append((f"lambda_e, day {day:g}", rows[i]["lambda_e"], stretch(a, rows[i]["time"]) / G[i]))
    lines.append((f"G, day {a.duration:g}", rows[-1]["G"], G[-1]))
    print(f"\n{'against the exact solution':28}{'computed':>10}{'exact':>10}{'difference':>12}")
    for name, computed, reference in lines:
        print(f"{name:28}{computed:10.5f}{reference:10.5f}{computed - reference:12.1e}")


def draw(a, rows, G):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    t = [r["time"] for r in rows]
    held = f"{100 * (a.stretch - 1):g} % stretch" + (f", ramped over {a.ramp:g} d and held" if a.ramp else ", held")
    law = rf"$\tau$ = {a.tau:g} d, $\gamma$ = {a.gamma:g}, $G_{{max}}$ = {a.G_max:g}, $\lambda_{{crit}}$ = {a.lambda_crit:g}"
    step = rf"backward Euler, $\Delta t$ = {a.step:g} d"
    points = slice(0, None, max(1, len(rows) // 60))
    early = [i for i, time in enumerate(t) if time <= 2 * a.ramp][:: max(1, int(0.1 * max(a.ramp, 1e-9) / a.step))]

    def figure(name, column, reference, label, title, lines):
        fig, ax = plt.subplots(figsize=(6.4, 4.2), dpi=130)
        shown = sorted(set(range(len(rows))[points]) | set(early))
        ax.plot([t[i] for i in shown], [rows[i][column] for i in shown], "o", ms=3.5, color="#b3331d",
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
        fig.savefig(a.out / name)
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
    G = exact(a, [r["time"] for r in rows])
    compare(a, rows, G)
    draw(a, rows, G)
    print(f"\n{a.out}/: cube.nml, history.csv, newton.log, fig2_elastic_stretch.png, fig4_sarcomere_number.png")


if __name__ == "__main__":
    main()
