"""Figures of a run of cylinder.py, from its history.csv, fields.npz and case.json; no display is needed.

    figures.py OUT      fig1_mesh.png, fig2_elastic_stretch.png, fig3_sections.png, fig4_sarcomere_number.png in OUT
"""
import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from matplotlib.gridspec import GridSpec  # noqa: E402

import cylinder_mesh  # noqa: E402
import deck  # noqa: E402
import elements  # noqa: E402
import history  # noqa: E402
import kept  # noqa: E402
from shared import files  # noqa: E402
from pictures import BLUE, GREEN, LAYOUT, ORANGE, PURPLE, save  # noqa: E402

COLOURS = matplotlib.colormaps["viridis"]
CLOSE_UP = 25.0  # mm, of each end
NAMES = ("fig1_mesh.png", "fig2_elastic_stretch.png", "fig3_sections.png", "fig4_sarcomere_number.png")
COMPRESSED = 5.0  # how many times shorter the axis is in the whole view than the radius


def describe(case):
    ends = {"clamped": "clamped ends", "free": "ends free to become thinner",
            "tendon": f"clamped tendons of {case.tendon_length:g} mm",
            "mixed": "proximal end clamped, distal one free to become thinner"}[case.ends]
    fibres = "fibres along the axis" if case.fibre_angle == 0 else f"fibres {case.fibre_angle:g}° off the axis"
    return f"{case.pull / cylinder_mesh.LENGTH:.0%} stretch, ramped over {case.ramp:g} d and held; {ends}; {fibres}"


# ---- Fig. 1: the mesh

def skin(mesh, levels):
    """Corner points (faces, 4, 3) of the outer faces between two levels, seen from outside; triangles repeat a corner."""
    first, last = levels
    disc = len(mesh.proximal)
    layers = len(mesh.levels) - 1
    cells = [c[:len(c) // layers, :c.shape[1] // 2] for c in mesh.elements()]  # of the disc
    edges = np.concatenate([np.stack([c, np.roll(c, -1, axis=1)], axis=2).reshape(-1, 2) for c in cells])
    known = {tuple(e) for e in edges.tolist()}
    rim = np.array([e for e in edges.tolist() if (e[1], e[0]) not in known])
    sides = [np.column_stack([rim + k * disc, rim[:, ::-1] + (k + 1) * disc]) for k in range(first, last)]
    ends = []
    for level, turn in ((first, -1), (last, 1)):
        for c in cells:
            ends.append(np.pad(c, ((0, 0), (0, 4 - c.shape[1])), mode="edge")[:, ::turn] + level * disc)
    return mesh.nodes[np.concatenate(sides + ends)]


def show_mesh(ax, faces, eye, target, spread):
    """Draws the faces that look at the eye, in perspective; all of a convex body is right this way."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [1.0, 0, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    small = np.linalg.norm(normals, axis=1) == 0
    normals[small] = np.cross(faces[small, 1] - faces[small, 0], faces[small, 2] - faces[small, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    seen = np.einsum("fi,fi->f", normals, eye - faces.mean(axis=1)) > 0
    ray = faces[seen] - eye
    depth = ray @ forward
    flat = np.stack([ray @ right / depth, ray @ up / depth], axis=2)
    light = 0.62 + 0.33 * np.clip(normals[seen] @ (0.5 * up - 0.75 * forward - 0.2 * right), 0, 1)
    base = np.array([0.93, 0.72, 0.62])
    ax.add_collection(PolyCollection(flat, facecolors=light[:, None] * base, edgecolors="0.25", linewidths=spread))
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    margin = 0.02 * (high - low)
    ax.set(xlim=(low[0] - margin[0], high[0] + margin[0]), ylim=(low[1] - margin[1], high[1] + margin[1]), aspect="equal")
    ax.axis("off")


def draw_mesh(path, case):
    mesh = cylinder_mesh.mesh(case.size)
    length, layers = cylinder_mesh.LENGTH, len(mesh.levels) - 1
    fig = plt.figure(figsize=(8.2, 5.6))
    grid = GridSpec(2, 2, height_ratios=[1, 1.9], hspace=0.1, wspace=0.04, left=0.01, right=0.99, top=0.88, bottom=0.02)
    ax = fig.add_subplot(grid[0, :])
    show_mesh(ax, skin(mesh, (0, layers)), np.array([70.0, -230, -190]), np.array([0, 0, 0.42 * length]), 0.12)
    ax.set_title("the whole cylinder, proximal end in front: 400 mm long, 20 mm in diameter, true to scale", pad=2)
    depth = int(np.searchsorted(mesh.levels, 40.0 - 1e-9))
    for column, name, levels, z, side in ((0, "proximal end, fixed", (0, depth), 0.0, -1),
                                          (1, "distal end, moved along the axis", (layers - depth, layers), length, 1)):
        ax = fig.add_subplot(grid[1, column])
        show_mesh(ax, skin(mesh, levels), np.array([45.0, -60, z + side * 80]), np.array([0, 0, z - side * 14]), 0.4)
        ax.set_title(f"{name}: {mesh.levels[depth]:.0f} mm of it", pad=2)
    heights = np.diff(mesh.levels)
    graded = f" to {heights.max():.3g}" if np.ptp(heights) > 1e-6 else ""
    fig.suptitle(f"Mesh “{case.size}”: {len(mesh.hexes):,} C3D8 + {len(mesh.wedges):,} C3D6, {len(mesh.nodes):,} nodes, "
                 f"{layers} layers of {heights.min():.3g}{graded} mm", fontsize=10.5)
    save(fig, path)


# ---- Figs 2 and 4: over time

def draw_history(path, case, h, name, label, title, level, level_text):
    fig, ax = plt.subplots(figsize=(6.6, 4.2))
    t = np.concatenate([[0.0], h["time"]])
    high, mean, low = (np.concatenate([[1.0], h[f"{name}_{what}"]]) for what in ("max", "mean", "min"))
    ax.fill_between(t, low, high, color=BLUE, alpha=0.12, lw=0)
    ax.plot(t, high, "o-", ms=2.6, lw=1.5, color=ORANGE, label="largest of all Gauss points")
    ax.plot(t, mean, "-", lw=1.5, color=BLUE, label="mean over the volume")
    ax.plot(t, low, "s-", ms=2.2, lw=1.2, color=GREEN, label="smallest")
    ax.axhline(level, color="0.5", lw=0.8, ls=":")
    ax.annotate(level_text, (1, level), xycoords=("axes fraction", "data"), xytext=(4, 0), textcoords="offset points",
                va="center", color="0.3", fontsize=8.5, annotation_clip=False)
    if name == "lambda_e":
        top = int(np.argmax(high))
        ax.annotate(f"{high[top]:.4f} on day {t[top]:.2f}", (t[top], high[top]), xytext=(10, 0), textcoords="offset points",
                    va="center", fontsize=8.5)
    ax.set(xlabel="time [days]", ylabel=label, xlim=(-0.01 * t[-1], t[-1]))
    if t[-1] > 14:
        ax.set_xticks(np.arange(0, t[-1] + 0.1, 7))
    ax.margins(y=0.1)
    ax.grid(alpha=0.25)
    ax.set_title(f"{title}; mesh “{case.size}”\n{describe(case)}", loc="left", fontsize=9)
    ax.legend(frameon=False, loc="center right", fontsize=8.5)
    fig.tight_layout()
    save(fig, path)


# ---- Fig. 3: sections

def section(mesh):
    """Where the plane y = 0 cuts the disc's edges: nodes (points, 2) of the edges and weights (points, 2), ordered by x."""
    layers = len(mesh.levels) - 1
    edges = set()
    for c in mesh.elements():
        c = c[:len(c) // layers, :c.shape[1] // 2]
        for k in range(c.shape[1]):
            edges |= {tuple(sorted(e)) for e in zip(c[:, k].tolist(), np.roll(c, -1, axis=1)[:, k].tolist())}
    found = {}
    for a, b in edges:
        ya, yb = (y if abs(y) > 1e-9 else 0.0 for y in mesh.nodes[[a, b], 1])
        if ya * yb > 0 or ya == yb:
            continue
        w = yb / (yb - ya)
        x = w * mesh.nodes[a, 0] + (1 - w) * mesh.nodes[b, 0]
        found.setdefault(round(x, 6), ((a, b), (w, 1 - w)))
    ordered = [found[x] for x in sorted(found)]
    return np.array([nodes for nodes, _ in ordered]), np.array([weights for _, weights in ordered])


def on_section(cut, values):
    """(levels, points, components) in the section of (levels, nodes of the disc, components)."""
    nodes, weights = cut
    return np.einsum("lpkc,pk->lpc", values[:, nodes], weights)


def in_layers(mesh, values):
    """(layers, 2, nodes of the disc): values of the Gauss points at the bottom and the top of every layer.

    Every layer has values of its own, linear in height: no average across layers, so that what jumps is seen to jump.
    In the disc they go from the Gauss points to the corners of their element, where the mean of the elements is taken.
    """
    layers, disc = len(mesh.levels) - 1, len(mesh.proximal)
    bottom = [cells[:len(cells) // layers, :cells.shape[1] // 2] for cells in mesh.elements()]
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])  # of the corners of a quadrilateral
    gauss = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
    to_corners = np.prod(1 + np.sqrt(3) * signs[:, None] * gauss[None], axis=2) / 4
    n = 8 * len(mesh.hexes)
    quads = values[:n].reshape(layers, -1, 2, 4) @ to_corners.T
    triangles = np.repeat(values[n:].reshape(layers, -1, 2, 1), 3, axis=3)
    total, count = np.zeros((disc, layers, 2)), np.zeros(disc)
    for cells, corners in zip(bottom, (quads, triangles)):
        np.add.at(total, cells, corners.transpose(1, 3, 0, 2))
        np.add.at(count, cells, 1)
    mean = (total / count[:, None, None]).transpose(1, 2, 0)
    middle, half = mean.mean(axis=1), np.sqrt(3) / 2 * (mean[:, 1] - mean[:, 0])
    return np.stack([middle - half, middle + half], axis=1)


def current_places(mesh, displacement):
    moved = mesh.nodes + displacement
    return np.concatenate([elements.gauss_points(moved, cells)[0].reshape(-1, 3) for cells in mesh.elements()])


def draw_section(axes, mesh, cut, displacement, gauss, muscle, stiff_layers):
    """The three views of one time: proximal close-up, the whole, distal close-up. The image, for the colour bar."""
    shape = on_section(cut, (mesh.nodes + displacement).reshape(len(mesh.levels), -1, 3))
    z, x = shape[:, :, 2], shape[:, :, 0]
    layers, points = len(z) - 1, z.shape[1]
    values = np.stack([on_section(cut, v[:, :, None])[:, :, 0] for v in in_layers(mesh, gauss).transpose(1, 0, 2)], axis=1)
    first = np.arange(points - 1)
    pair = np.concatenate([np.column_stack([first, first + 1, first + points]),
                           np.column_stack([first + 1, first + points + 1, first + points])])
    drawn = np.setdiff1d(np.arange(layers), stiff_layers)
    triangles = (drawn[:, None, None] * 2 * points + pair).reshape(-1, 3)
    doubled = [np.stack([c[:-1], c[1:]], axis=1).ravel() for c in (z, x)]  # every level once for either layer
    places = current_places(mesh, displacement)
    inside = np.flatnonzero(muscle)
    extremes = [(inside[np.argmax(gauss[inside])], "^", "largest"), (inside[np.argmin(gauss[inside])], "v", "smallest")]
    low, high = gauss[inside].min(), gauss[inside].max()
    if high - low < 1e-6:
        low, high = low - 5e-7, high + 5e-7
    end = z[-1].mean()
    image = None
    for ax, window in zip(axes, ((0, CLOSE_UP), (0, end), (end - CLOSE_UP, end))):
        image = ax.tripcolor(*doubled, triangles, values.ravel(), shading="gouraud", cmap=COLOURS, vmin=low, vmax=high)
        for k in stiff_layers:
            ax.fill_betweenx(x[k], z[k], z[k + 1], color="0.75", lw=0)
        ax.plot(z[:, 0], x[:, 0], z[:, -1], x[:, -1], z[0], x[0], z[-1], x[-1], color="0.2", lw=0.6)
        for point, marker, _ in extremes:
            place = places[point]
            if window[0] <= place[2] <= window[1]:
                radius = np.copysign(np.hypot(place[0], place[1]), place[0])
                ax.plot(place[2], radius, marker, ms=6, mfc="white" if marker == "^" else "black",
                        mec="black" if marker == "^" else "white", mew=0.9, clip_on=False, zorder=5)
        pad = 0.6 if ax is not axes[1] else 0.6 * COMPRESSED
        ax.set(xlim=(window[0] - pad, window[1] + pad), ylim=(-10.8, 10.8))
        ax.set_aspect(1.0 if ax is not axes[1] else COMPRESSED)
        ax.set_yticks([-10, 0, 10])
        ax.tick_params(length=2.5, labelsize=7.5)
    axes[1].set_yticklabels([])
    axes[2].set_yticklabels([])
    axes[2].set_xticks([np.round(end) - 20, np.round(end) - 10, np.round(end)])
    return image


def draw_sections(path, case, fields, name, label, title):
    mesh = cylinder_mesh.mesh(case.size)
    cut = section(mesh)
    column = fields["names"].tolist().index(name)
    times = fields["times"]
    stiff_layers = np.unique(mesh.layer_of_elements()[deck.tendon(case, mesh)])

    whole = (cylinder_mesh.LENGTH + case.pull) / COMPRESSED
    fig = plt.figure(figsize=(9.6, 1.18 * len(times) + 1.3))
    grid = GridSpec(len(times), 4, width_ratios=[CLOSE_UP, whole, CLOSE_UP, 2.2], hspace=0.5, wspace=0.12, left=0.085,
                    right=0.925, top=1 - 0.93 / fig.get_figheight(), bottom=0.42 / fig.get_figheight())
    for i, day in enumerate(times):
        axes = [fig.add_subplot(grid[i, k]) for k in range(3)]
        image = draw_section(axes, mesh, cut, fields["displacement"][i].astype(float),
                             fields["gauss"][i][:, column].astype(float), fields["muscle"], stiff_layers)
        bar = fig.colorbar(image, cax=fig.add_subplot(grid[i, 3]))
        bar.set_ticks(np.linspace(*image.get_clim(), 3))
        bar.ax.set_yticklabels([f"{v:.4f}" for v in np.linspace(*image.get_clim(), 3)], fontsize=7.5)
        bar.outline.set_visible(False)
        when = "end of ramp" if day == case.ramp else f"day {day:g}" if day % 7 else f"week {day / 7:g}"
        axes[0].set_ylabel(f"{when}\nx [mm]", fontsize=8.5)
        if i == 0:
            for ax, text in zip(axes, ("proximal end, to scale", f"whole length, axis compressed {COMPRESSED:g} times",
                                       "distal end, to scale")):
                ax.set_title(text, fontsize=8.5, pad=3)
        if i == len(times) - 1:
            for ax in axes:
                ax.set_xlabel("z after the deformation [mm]", fontsize=8)
    fig.suptitle(f"{title}: {label} in the plane y = 0, mesh “{case.size}”\n{describe(case)}\n"
                 "each time with its own colours; △: largest, ▼: smallest of all Gauss points",
                 fontsize=9.5, y=1 - 0.08 / fig.get_figheight(), va="top")
    save(fig, path, COLOURS)


def draw(out):
    """Draws all figures into the folder of the run; their names."""
    out = pathlib.Path(out)
    files.remove(out / name for name in NAMES)
    case = kept.read_case(out)
    h = history.read(out / "history.csv")
    fields = kept.arrays(out / "fields.npz", "times", "names", "displacement", "gauss", "muscle")
    mesh = cylinder_mesh.mesh(case.size)
    points = 8 * len(mesh.hexes) + 2 * len(mesh.wedges)
    for name, shape in (("displacement", (len(fields["times"]), len(mesh.nodes), 3)), ("muscle", (points,)),
                        ("gauss", (len(fields["times"]), points, len(fields["names"])))):
        kept.demand_shape(out / "fields.npz", name, fields[name], shape)
    stretch = 1 + case.pull / cylinder_mesh.LENGTH
    names = list(NAMES)
    with matplotlib.rc_context(LAYOUT):
        draw_mesh(out / names[0], case)
        draw_history(out / names[1], case, h, "lambda_e", r"elastic fibre stretch $\lambda_e$ [-]",
                     "Relative sarcomere length (the paper's Fig. 2)", deck.LAMBDA_CRIT, r"$\lambda_{crit}$")
        draw_sections(out / names[2], case, fields, "lambda_e", r"$\lambda_e$ [-]",
                      "Elastic fibre stretch (the paper's Fig. 3)")
        limit = min(deck.G_MAX, stretch / deck.LAMBDA_CRIT)
        text = r"$G_{max}$" if limit == deck.G_MAX else rf"${stretch:g}/\lambda_{{crit}}$"
        draw_history(out / names[3], case, h, "G", r"relative serial sarcomere number $G$ [-]",
                     "Sarcomeres in series (the paper's Fig. 4)", limit, text)
    return names


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("out", metavar="OUT", help="folder of the run")
    with files.faults_in_one_line("figures.py"):
        draw(parser.parse_args().out)
