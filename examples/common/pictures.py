"""Runs a study's program and draws what it found; no display is needed. Layout and `save` are all examples'.

    pictures.py fit | protocol | sensitivity PROGRAM [ARGUMENTS OF PROGRAM]
    pictures.py validate PROGRAM FILE.csv ...       every file by the fit program, into out/validation

The status is the program's; 1 if a picture, a table or standard output cannot be written (the message names it).
"""
import io
import itertools
import os
import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import matplotlib.ticker  # noqa: E402
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

import files  # noqa: E402

BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"  # Okabe and Ito's, for all eyes
CYCLE = [BLUE, ORANGE, GREEN, PURPLE, "#56B4E9", "#E69F00", "0.35"]
LAYOUT = {"font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 9.5, "axes.spines.top": False,
          "axes.spines.right": False, "savefig.dpi": 130}
GRID = {**LAYOUT, "axes.grid": True, "grid.alpha": 0.25, "legend.frameon": False, "legend.fontsize": 8}
CHI2_95 = 3.841
SYMBOLS = {"tau": r"$\tau$ [d]", "gamma": r"$\gamma$ [-]", "G_max": r"$G_{max}$ [-]", "lambda_crit": r"$\lambda_{crit}$ [-]",
           "ramp": "ramp [d]", "c1": r"$c_1$ [kPa]", "c2": r"$c_2$ [kPa]", "lambda_e": r"$\lambda_e$ [-]", "G": r"$G$ [-]"}


def plain(name):
    return SYMBOLS[name].split(" [")[0]


def literal(text):
    """A text in which matplotlib finds no formula."""
    return text.replace("$", r"\$")


def save(fig, path, colours=None):
    """As a PNG of 256 colours, to keep the files small; with a colour map: 224 of it, and greys."""
    buffer = io.BytesIO()
    fig.savefig(buffer, format="png")
    plt.close(fig)
    picture = Image.open(buffer).convert("RGB")
    palette = None
    if colours is not None:
        mapped, greys = colours(np.linspace(0, 1, 224))[:, :3], np.repeat(np.linspace(0, 1, 32)[:, None], 3, axis=1)
        palette = Image.new("P", (1, 1))
        palette.putpalette(np.round(255 * np.concatenate([mapped, greys])).astype(np.uint8).tobytes())
    with files.writing(path) as part:
        picture.quantize(256, kmeans=1, palette=palette, dither=Image.Dither.NONE).save(part, optimize=True)


# ---- Fit

def draw_measurements(ax, r, quantity, text="measured, ± sd"):
    ax.plot(r["time"], r[quantity], color=BLUE, lw=1.4, label="the law")
    chosen = [m for m in r["measurements"] if m["quantity"] == quantity]
    ax.errorbar([m["day"] for m in chosen], [m["value"] for m in chosen], yerr=[m["sd"] for m in chosen], fmt="o", ms=4,
                color=ORANGE, capsize=2, lw=1, label=text)
    ax.set(xlabel="time [days]", ylabel=SYMBOLS[quantity])
    ax.legend()


def draw_fit(out):
    r = files.read_json(out / "report.json")
    quantities = sorted({m["quantity"] for m in r["measurements"]}, reverse=True)
    n = len(quantities)
    fig, axes = plt.subplots(2, n, figsize=(5.6 * n, 5.2), sharex="col", squeeze=False, height_ratios=[2, 1])
    for (ax, below), quantity in zip(axes.T, quantities):
        draw_measurements(ax, r, quantity)
        ax.set_xlabel("")
        chosen = [m for m in r["measurements"] if m["quantity"] == quantity]
        below.plot([m["day"] for m in chosen], [(m["value"] - m["computed"]) / m["sd"] for m in chosen], "o", ms=4, color=ORANGE)
        for level in (-1.96, 0, 1.96):
            below.axhline(level, color="0.5", lw=0.8, ls=":" if level else "-")
        below.set(xlabel="time [days]", ylabel="(measured − law)/sd")
    axes[0, 0].set_title(literal(r["title"]), loc="left")
    fig.tight_layout()
    save(fig, out / "fit.png")

    found = r["parameters"]
    if not found:
        return
    fig, axes = plt.subplots(1, len(found), figsize=(3.6 * len(found) + 0.8, 3.4), squeeze=False, sharey=True)
    for ax, p in zip(axes[0], found):
        ax.plot(p["profile_x"], p["profile"], "o-", ms=2.5, lw=1.2, color=BLUE)
        if p["sd"]:
            curve = [((x - p["estimate"]) / p["sd"])**2 for x in p["profile_x"]]
            ax.plot(p["profile_x"], curve, "--", lw=1, color="0.5", label="from the curvature only")
        ax.axhline(CHI2_95, color=ORANGE, lw=1, ls=":", label="95 %")
        ax.axvline(p["estimate"], color="0.5", lw=0.8, ls=":")
        if max(p["profile_x"]) > 8 * min(p["profile_x"]):
            ax.set_xscale("log")
            ax.xaxis.set_major_formatter("{x:g}")
        else:
            ax.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(5))
        ax.set(xlabel=SYMBOLS[p["name"]], ylim=(-0.3, 12))
    axes[0][0].set_ylabel(r"$\chi^2$ above its minimum, the others fitted again")
    axes[0][0].legend()
    fig.tight_layout()
    save(fig, out / "profiles.png")


# ---- Validation

def draw_validation(out, folders):
    reports = [files.read_json(folder / "report.json") for folder in folders]
    fig, axes = plt.subplots(-(-len(reports) // 3), 3, figsize=(11.4, 6.2), squeeze=False)
    for ax in axes.flat[len(reports):]:
        ax.set_axis_off()
    rows = ["| study | day | quantity | published | the law | off by |", "|---|---|---|---|---|---|"]
    for ax, r in zip(axes.flat, reports):
        draw_measurements(ax, r, r["measurements"][-1]["quantity"], "published, ± sd")
        fitted = ["{} = {:.3g} ({} to {})".format(plain(p["name"]), p["estimate"],
                                                  *(f"{p[end]:.3g}" if p[end] else "open" for end in ("lower", "upper")))
                  for p in r["parameters"]]
        ax.set_title(literal(r["title"]) + "\n" + (", ".join(fitted) or "nothing fitted"), loc="left", fontsize=8.5)
        title = r["title"].replace("|", r"\|")
        for m in r["measurements"]:
            off = 100 * (m["computed"] / m["value"] - 1)
            rows.append(f"| {title} | {m['day']:g} | {m['quantity']} | {m['value']:.3f} ± {m['sd']:.3f} | "
                        f"{m['computed']:.3f} | {off:+.2f} % |")
    fig.tight_layout()
    save(fig, out / "validation.png")
    rows += [""] + [f"**{r['title']}**: {w}\n" for r in reports for w in r["warnings"]]
    files.write_text(out / "report.md", "\n".join(rows) + "\n![validation](validation.png)\n")
    print("\n".join(rows))


# ---- Protocols

def draw_protocol(out):
    r = files.read_json(out / "report.json")
    if "target" in r:
        return draw_design(out, r)
    fig, axes = plt.subplots(2, 2, figsize=(9.6, 6.4))
    panels = [("stretch", r"stretch $\lambda$ [-]"), ("lambda_e", r"elastic stretch $\lambda_e$ [-]"),
              ("G", r"sarcomere number $G$ [-]"), ("force", "force per reference area [kPa]")]
    for ax, (name, label) in zip(axes.flat, panels):
        for p, colour in zip(r["protocols"], itertools.cycle(CYCLE)):
            ax.plot(p["run"]["time"], p["run"][name], lw=1.2, color=colour, label=literal(p["title"]))
        ax.set(xlabel="time [days]", ylabel=label)
    for level, text in ((r["injury"], "threshold"), (1 + r["within"], "returned")):
        axes[0, 1].axhline(level, color="0.3", lw=0.9, ls=":")
        axes[0, 1].annotate(text, (0.99, level), xycoords=("axes fraction", "data"), xytext=(0, 3), textcoords="offset points",
                            ha="right", color="0.3", fontsize=8)
    axes[1, 0].legend(loc="lower right")
    fig.tight_layout()
    save(fig, out / "protocols.png")


def draw_design(out, r):
    fig, axes = plt.subplots(1, 2, figsize=(9.6, 3.8))
    last = 1.35 * max(x for x in (r["days"], r["step_days"] or 0, 1))
    for ax, name, label in zip(axes, ("stretch", "lambda_e"), (r"stretch $\lambda$ [-]", r"elastic stretch $\lambda_e$ [-]")):
        steps = "in daily steps" + (f": {r['step_days']:g} days" if r["step_days"] else "")
        for run, colour, text in (("run", BLUE, f"fastest: {r['days']:.2f} days"), ("steps", ORANGE, steps)):
            ax.plot(r[run]["time"], r[run][name], color=colour, lw=1.3, label=text)
        ax.set(xlabel="time [days]", ylabel=label, xlim=(-0.02 * last, last))
    axes[0].axhline(r["target"], color="0.3", lw=0.9, ls=":")
    if r["ramp_days"] and r["ramp_days"] < 3 * last:
        axes[0].plot([0, r["ramp_days"]], [1, r["target"]], "--", lw=1, color=GREEN,
                     label=f"constant rate: {r['ramp_days']:.1f} days")
    axes[1].axhline(r["limit"], color="0.3", lw=0.9, ls=":")
    axes[0].legend()
    fig.tight_layout()
    save(fig, out / "design.png")


# ---- Sensitivity

def draw_sensitivity(out):
    r = files.read_json(out / "report.json")
    names = r["names"]
    fig, axes = plt.subplots(1, 3, figsize=(11.4, 3.9))
    for k, title in enumerate(("peak", "final")):
        ax, middle = axes[k], r["middle"][k]
        bars = sorted(r["tornado"], key=lambda b: abs(b["high"][k] - b["low"][k]))
        for i, b in enumerate(bars):
            at = names.index(b["name"])
            ax.barh(i, b["low"][k] - middle, left=middle, color=BLUE, height=0.6, label="low" if i == 0 else None)
            ax.barh(i, b["high"][k] - middle, left=middle, color=ORANGE, height=0.6, label="high" if i == 0 else None)
            bars[i] = f"{plain(b['name'])}: {r['low'][at]:g} to {r['high'][at]:g}"
        ax.set_yticks(range(len(bars)), bars)
        ax.axvline(middle, color="0.3", lw=0.8)
        ax.set_title(rf"{title} $\lambda_e$, one at a time", loc="left")
        ax.legend(loc="lower right")
    for name, values, colour in zip(names, r["relative_lambda_e"], CYCLE):
        if any(values):
            axes[2].plot(r["time"], values, color=colour, lw=1.3, label=plain(name))
    axes[2].set_xscale("symlog", linthresh=1)
    axes[2].set(xlim=(0, r["days"]), xticks=[0, 0.5, 1, 2, 7, 14, 42], xlabel="time [days]")
    axes[2].xaxis.set_major_formatter("{x:g}")
    axes[2].xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axes[2].set_title(r"$(p/\lambda_e)\,\partial\lambda_e/\partial p$ over time", loc="left")
    axes[2].set_ylim(top=0.3 + axes[2].get_ylim()[1])
    axes[2].legend(ncol=2, loc="upper left")
    fig.tight_layout()
    save(fig, out / "local.png")

    fig, axes = plt.subplots(1, 3, figsize=(11.4, 3.4), sharey=True)
    for ax, g in zip(axes, r["global"]):
        for kind, colour, shift in (("first", BLUE, -0.2), ("total", ORANGE, 0.2)):
            values = [i[kind] for i in g["indices"]]
            spread = [[v - i[kind + "_interval"][0] for v, i in zip(values, g["indices"])],
                      [i[kind + "_interval"][1] - v for v, i in zip(values, g["indices"])]]
            ax.bar([x + shift for x in range(len(names))], values, width=0.38, color=colour,
                   label={"first": "first order", "total": "total"}[kind])
            ax.errorbar([x + shift for x in range(len(names))], values, yerr=[[max(s, 0) for s in side] for side in spread],
                        fmt="none", ecolor="0.2", elinewidth=0.9, capsize=2)
        ax.set_xticks(range(len(names)), [plain(n) for n in names])
        ax.set_title(g["output"].replace("lambda_e", r"$\lambda_e$") + f": {g['mean']:.4f} ± {g['sd']:.4f}", loc="left")
    axes[0].set_ylabel("Sobol's index [-]")
    axes[0].legend()
    fig.tight_layout()
    save(fig, out / "global.png")


DRAW = {"fit": draw_fit, "protocol": draw_protocol, "sensitivity": draw_sensitivity}


def run(kind, command):
    """Runs a program, passes on what it prints, and draws what is in the folder that it names last. Its status."""
    folder = None
    with subprocess.Popen(command, stdout=subprocess.PIPE) as program:
        for line in program.stdout:
            sys.stdout.buffer.write(line)
            sys.stdout.buffer.flush()
            if line.startswith(b"results in "):
                folder = pathlib.Path(os.fsdecode(line[len(b"results in "):].rstrip(b"\n")))
    if program.returncode < 0:
        raise files.FileError(f"{command[0]} {files.ended(program.returncode)}")
    if program.returncode == 0 and folder:
        with plt.rc_context(GRID):
            DRAW[kind](folder)
    return program.returncode


def validate(program, studies):
    out = pathlib.Path("out/validation")
    folders = [out / pathlib.Path(study).stem for study in studies]
    if not studies or len(set(folders)) < len(folders):
        raise files.FileError("validate: expected files, each of another name")
    files.make_folder(out)
    files.remove([out / "report.md", out / "validation.png"])
    for study, folder in zip(studies, folders):
        status = run("fit", [program, study, "--out", folder])
        if status:
            return status
    with plt.rc_context(GRID):
        draw_validation(out, folders)
    print(f"\nresults in {out}")
    return 0


def main(arguments):
    if len(arguments) < 2 or arguments[0] not in (*DRAW, "validate"):
        raise files.FileError(f"expected these arguments:\n{__doc__}")
    kind, program, *rest = arguments
    return validate(program, rest) if kind == "validate" else run(kind, [program, *rest])


if __name__ == "__main__":
    with files.faults_in_one_line("pictures.py"):
        status = main(sys.argv[1:])
    sys.exit(status)
