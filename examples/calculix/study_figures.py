"""Figures of studies.py, from its runs."""
import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np

import deck
import figures
import studies
from figures import BLUE, GREEN, ORANGE, PURPLE

CLAIM = 1.06  # the paper's peak of lambda_e


def plain_numbers(axis, ticks):
    axis.set_major_locator(matplotlib.ticker.FixedLocator(ticks))
    axis.set_minor_locator(matplotlib.ticker.NullLocator())
    axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda x, _: f"{x:g}"))


def draw_ramps(path, found):
    fig, ax = plt.subplots(figsize=(6.6, 4.2))
    ramps = np.geomspace(0.25, 42, 60)
    for tau, style, text in ((deck.TAU, "-", "days"), (7 * deck.TAU, "--", "weeks")):
        ax.plot(ramps, [studies.peak_at_a_point(r, tau)[0] for r in ramps], style, color=BLUE, lw=1.5,
                label=rf"a point (exact), $\tau$ = 0.5 {text}")
    for tau, face, text in ((deck.TAU, None, "days"), (7 * deck.TAU, "white", "weeks")):
        chosen = [r for name, r in found.items() if r.case.tau == tau and
                  (name in ("coarse", "tau in weeks") or name.split(", ")[-1].startswith("ramp"))]
        ax.plot([r.case.ramp for r in chosen], [r.peak()["lambda_e_max"] for r in chosen], "^", ms=6, color=ORANGE, mfc=face,
                ls="none", label=rf"cylinder, largest of all, $\tau$ = 0.5 {text}")
    ax.axhline(CLAIM, color="0.5", lw=0.8, ls=":")
    ax.annotate("the paper's 1.06", (0.99, CLAIM), xycoords=("axes fraction", "data"), xytext=(0, 3), textcoords="offset points",
                ha="right", color="0.3", fontsize=8.5)
    ax.set_xscale("log")
    plain_numbers(ax.xaxis, [0.25, 0.5, 1, 2, 7, 14, 42])
    ax.set(xlabel="length of the ramp to 10 % stretch [days]", ylabel=r"peak of $\lambda_e$ [-]")
    ax.grid(alpha=0.25)
    ax.set_title("Largest elastic stretch against the length of the ramp; mesh “coarse”, clamped", loc="left", fontsize=9)
    ax.legend(frameon=False, fontsize=8.5)
    fig.tight_layout()
    figures.save(fig, path)


def draw_edges(path, found):
    fig, axes = plt.subplots(1, 3, figsize=(11, 4), width_ratios=[1, 1, 0.9])
    shown = [(name, colour) for name, colour in (("coarse", GREEN), ("medium", PURPLE), ("paper", ORANGE), ("edge 0.2", BLUE),
                                                 ("edge 0.06", "0.2")) if name in found]
    for ax, chosen, text in ((axes[0], "at_axis", "along the axis"),
                             (axes[1], "outermost", "along the surface (outermost Gauss points)")):
        for name, colour in shown:
            r = found[name]
            z, values = r.along(getattr(r, chosen), 1.0)
            inside = z < 45
            label = f"elements of {name[5:]} mm in the edge" if name.startswith("edge") else f"mesh “{name}”"
            ax.plot(z[inside], values[inside], "o-", ms=2.4, lw=1, color=colour, label=label)
        ax.set_xscale("log")
        plain_numbers(ax.xaxis, [0.01, 0.1, 1, 10, 40])
        ax.set(xlabel="distance from the clamp [mm]", ylabel=r"$\lambda_e$ at the end of the ramp [-]", ylim=(1.02, 1.155))
        ax.set_title(text, loc="left", fontsize=9)
        ax.grid(alpha=0.25)
    axes[0].legend(frameon=False, fontsize=8)
    h = np.array(studies.EDGES)
    once = np.array([found[f"edge {x:g} at once"].edge(1e-3) - 1 for x in h])
    ramp = np.array([found[f"edge {x:g}"].edge(1.0) - 1 for x in h])
    p = studies.clamped_free_exponent()
    axes[2].loglog(h, once, "^-", color=ORANGE, label="10 % at once")
    axes[2].loglog(h, ramp, "o-", color=BLUE, label="after the ramp of a day")
    axes[2].loglog(h, once[-1] * (h / h[-1])**p, ":", color="0.4", label=f"slope of linear elasticity, {p:.2f}")
    plain_numbers(axes[2].xaxis, list(h))
    plain_numbers(axes[2].yaxis, [0.05, 0.1, 0.2, 0.3])
    axes[2].set(xlabel="element in the clamped edge [mm]", ylabel=r"$\lambda_e - 1$ in the edge [-]")
    axes[2].set_title("in the edge, against the mesh", loc="left", fontsize=9)
    axes[2].grid(alpha=0.25)
    axes[2].legend(frameon=False, fontsize=8)
    fig.tight_layout()
    figures.save(fig, path)


def draw_times(path, found):
    fig, ax = plt.subplots(figsize=(6.6, 4.2))
    t = np.concatenate([np.linspace(0, 2, 41)[1:], np.linspace(2, 42, 161)[1:]])
    for tau, style in ((deck.TAU, "-"), (7 * deck.TAU, "--")):
        for ramp, colour in ((1.0, ORANGE), (7.0, BLUE), (42.0, GREEN)):
            times = sorted(set(t.tolist()) | {ramp})
            text = rf"$\tau$ = 0.5 {'d' if tau == deck.TAU else 'weeks'}, ramp of {ramp:g} d"
            ax.plot(times, studies.at_a_point(times, ramp, tau), style, color=colour, lw=1.4, label=text)
    for name, colour in (("coarse", ORANGE), ("ramp 7", BLUE), ("ramp 42", GREEN), ("tau in weeks", ORANGE),
                         ("tau in weeks, ramp 7", BLUE)):
        h = found[name].h
        ax.plot(h["time"], h["lambda_e_max"], "^", ms=2.6, color=colour)
    ax.axhline(CLAIM, color="0.5", lw=0.8, ls=":")
    ax.axvline(14, color="0.5", lw=0.8, ls=":")
    ax.set(xlabel="time [days]", ylabel=r"$\lambda_e$ [-]", xlim=(0, 42), ylim=(1, None), xticks=np.arange(0, 43, 7))
    ax.grid(alpha=0.25)
    ax.set_title("Lines: a point, exact; triangles: the largest in the cylinder, mesh “coarse”\n"
                 "Dotted: the paper's 1.06 and its two weeks", loc="left", fontsize=9)
    ax.legend(frameon=False, fontsize=8, ncol=2, loc="upper right")
    fig.tight_layout()
    figures.save(fig, path)


def draw_meshes(path, found):
    fig, axes = plt.subplots(1, 2, figsize=(8.6, 3.8))
    names = [name for name in ("tiny", "coarse", "medium", "paper") if name in found]
    places = range(len(names))
    for ax, day in zip(axes, (1, 42)):
        for what, mark, colour in (("max", "^-", ORANGE), ("mean", "o-", BLUE), ("min", "v-", GREEN)):
            ax.plot(places, [found[name].at(f"lambda_e_{what}", day) for name in names], mark, color=colour,
                    label={"max": "largest", "mean": "mean", "min": "smallest"}[what])
        edge = [found[name].edge(float(day)) if day in found[name].days else np.nan for name in names]
        ax.plot(places, edge, "s--", ms=4, color=PURPLE, label="edge")
        ax.set_xticks(places, [f"{name}\n{len(found[name].mesh.nodes):,}" for name in names])
        ax.set(xlabel="mesh, nodes", ylabel=rf"$\lambda_e$ on day {day} [-]")
        ax.grid(alpha=0.25)
    axes[0].legend(frameon=False, fontsize=8.5, loc="center right", bbox_to_anchor=(1, 0.4))
    fig.tight_layout()
    figures.save(fig, path)


def draw(out, found):
    """Draws all figures into a folder; their names."""
    with plt.rc_context(figures.LAYOUT):
        for name, make in MADE.items():
            make(out / name, found)
    return list(MADE)


MADE = {"ramps.png": draw_ramps, "edges.png": draw_edges, "times.png": draw_times, "meshes.png": draw_meshes}
