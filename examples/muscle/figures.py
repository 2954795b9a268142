"""Pictures of a run of ./run muscle: the muscle from two sides, coloured by lambda_e, and curves by region."""
import re

import numpy as np

import mesh as meshes
from raw import FACES, fail
from shared import files

import pictures  # of examples/common
from pictures import BLUE, GREEN, ORANGE, plt

REGIONS = ["time", "region", "volume", *(f"{q}_{s}" for q in ("lambda_e", "G") for s in ("mean", "p05", "p50", "p95", "p99"))]
STREAMLINES = ["fascicle", "x", "y", "z"]
HOT = ["time", "lambda_e_from", "elements", "share_proximal_third", "share_distal_third", "share_with_a_facet_on_the_surface",
       "distance_to_attachment_median", "distance_to_attachment_max"]
NAMES = ("muscle.png", "regions.png")
LINES = {"proximal": (BLUE, "-", 2.2), "middle": (GREEN, "-", 1.4), "distal": (ORANGE, "--", 1.4)}
WEEKS = (7.0, 14.0, 42.0)


class Fields:
    """Displacement of the corner nodes [mm], lambda_e and kind of the cells, at one time."""

    def __init__(self, mesh, paths):
        import meshio

        self.u, self.lambda_e, self.tendon = np.full_like(mesh.X, np.nan), np.full(len(mesh.cell_labels), np.nan), \
            np.zeros(len(mesh.cell_labels), dtype=bool)
        cells = {tuple(sorted(nodes[:meshes.CORNERS[kind]])): cell for kind in mesh.kinds
                 for cell, nodes in zip(mesh.kinds[kind].tolist(), mesh.nodes_of[kind].tolist())}
        nearest = Nearest(mesh)
        for path in paths:
            try:
                grid = meshio.read(path, "vtu")
            except (Exception, SystemExit) as e:
                fail(path, f"meshio cannot read it: {type(e).__name__}: {e}")
            for name in ("displacement", "lambda_e", "tendon"):
                if name not in grid.point_data:
                    fail(path, f"has no {name}")
            index = nearest(grid.points, path)
            self.u[index] = grid.point_data["displacement"]
            for block in grid.cells:
                for nodes in np.asarray(block.data):
                    key = tuple(sorted(set(index[nodes].tolist())))
                    if key not in cells:
                        fail(path, "its cells are not those of the mesh")
                    self.lambda_e[cells[key]] = grid.point_data["lambda_e"][nodes[0]]
                    self.tendon[cells[key]] = grid.point_data["tendon"][nodes[0]] > 0.5
        if np.isnan(self.lambda_e).any():
            fail(paths[0], f"has no lambda_e for {np.isnan(self.lambda_e).sum()} elements of the mesh")


class Nearest:
    """Indices of a mesh's corner nodes by their places."""

    def __init__(self, mesh):
        self.X = mesh.X
        self.corners = np.unique(np.concatenate([nodes[:, :meshes.CORNERS[k]].ravel() for k, nodes in mesh.nodes_of.items()]))
        self.direction = np.array([0.5377, 0.6843, 0.4924])
        at = mesh.X[self.corners] @ self.direction
        order = np.argsort(at)
        self.at, self.corners = at[order], self.corners[order]
        self.tolerance = 1e-6 * np.abs(mesh.X).max()

    def __call__(self, points, path):
        at = points @ self.direction
        start = np.searchsorted(self.at, at - 2 * self.tolerance)
        best, found = np.full(len(points), np.inf), np.zeros(len(points), dtype=int)
        for step in range(1000):
            i = np.minimum(start + step, len(self.at) - 1)
            if not (self.at[i] <= at + 2 * self.tolerance).any():
                break
            distance = np.linalg.norm(self.X[self.corners[i]] - points, axis=1)
            nearer = distance < best
            best[nearer], found[nearer] = distance[nearer], self.corners[i[nearer]]
        if not (best <= 2 * self.tolerance).all():
            fail(path, "its points are not nodes of the mesh")
        return found


def frames(mesh):
    """Two views, from opposite sides: (right, up, to the viewer). Up is from DISTAL to PROXIMAL; the broad side is seen."""
    up = mesh.centroid("PROXIMAL") - mesh.centroid("DISTAL")
    up /= np.linalg.norm(up)
    X = mesh.X - mesh.X.mean(axis=0)
    X = X - np.outer(X @ up, up)
    _, vectors = np.linalg.eigh(X.T @ X)
    right = vectors[:, 2] - (vectors[:, 2] @ up) * up
    right /= np.linalg.norm(right)
    right *= np.sign(right[np.argmax(np.abs(right))])
    return [(right, up, np.cross(right, up)), (-right, up, -np.cross(right, up))]


def facets(mesh):
    """[(corner nodes, cell)] of the mesh's surface."""
    count = {}
    for kind, nodes in mesh.nodes_of.items():
        for face in FACES[kind]:
            rows = nodes[:, list(face)]
            for key, corners, cell in zip(map(tuple, np.sort(rows, axis=1).tolist()), rows.tolist(), mesh.kinds[kind].tolist()):
                count[key] = None if key in count else (corners, cell)
    return [entry for entry in count.values() if entry]


def draw_view(ax, X, outer, values, tendon, frame, colours, norm):
    """Orthographic, the facets that face the viewer from the farthest to the nearest."""
    from matplotlib.collections import PolyCollection

    right, up, to = frame
    polygons, depth, fill = [], [], []
    for corners, cell in outer:
        P = X[corners]
        flat = np.column_stack([P @ right, P @ up])
        a, b = flat[1] - flat[0], flat[2] - flat[0]
        if a[0] * b[1] - a[1] * b[0] <= 0:
            continue
        polygons.append(flat)
        depth.append((P @ to).mean())
        fill.append((0.75, 0.75, 0.75, 1) if values is None or tendon[cell] else colours(norm(values[cell])))
    order = np.argsort(depth)
    ax.add_collection(PolyCollection([polygons[i] for i in order], facecolors=[fill[i] for i in order],
                                     edgecolors=[fill[i] for i in order], linewidths=0.6))


def fields_of(out):
    """{day: [files]} of muscle.pvd."""
    text = files.read_text(out / "muscle.pvd")
    found = {}
    for day, name in re.findall(r'<DataSet timestep="([^"]+)"[^>]*file="([^"]+)"', text):
        path = out / name
        pieces = re.findall(r'<Piece Source="([^"]+)"', files.read_text(path)) if path.suffix == ".pvtu" else [name]
        found[float(day)] = [out / piece for piece in pieces]
    if not found:
        fail(out / "muscle.pvd", "names no fields")
    return found


def chosen(days, ramp):
    """The end of the ramp, weeks 1, 2 and 6, as far as they are there."""
    near = [d for d in days if any(abs(d - w) < 1e-6 * max(w, 1) for w in (ramp, *WEEKS))]
    return near or days[:4]


def read_streamlines(path):
    lines = {}
    if path.is_file():
        for line, fields in files.rows(path, STREAMLINES):
            lines.setdefault(fields[0], []).append([files.finite(path, line, *pair) for pair in zip(STREAMLINES[1:], fields[1:])])
    return [np.array(points) for points in lines.values()]


def draw_muscle(mesh, out, ramp):
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    found = fields_of(out)
    days = chosen(sorted(found), ramp)
    fields = {day: Fields(mesh, found[day]) for day in days}
    outer, views = facets(mesh), frames(mesh)
    lines = read_streamlines(out / "streamlines.csv")
    surface = [cell for _, cell in outer if not fields[days[0]].tendon[cell]]
    top = max(np.percentile(f.lambda_e[surface], 97) for f in fields.values())
    norm, colours = Normalize(1.0, max(round(top, 2), 1.01), clip=True), plt.get_cmap("viridis")
    columns = (1 if lines else 0) + len(days)
    widths = [np.ptp(mesh.X @ views[0][0])]
    height = max(np.ptp((mesh.X + np.nan_to_num(f.u)) @ views[0][1]) for f in fields.values())
    tall = 5.2
    wide = tall * 1.25 * widths[0] / height
    fig, axes = plt.subplots(1, 2 * columns, figsize=(max(2 * columns * wide + 1.1, 7), tall + 0.8), squeeze=False)
    axes = axes[0]
    for column in range(columns):
        day = None if lines and column == 0 else days[column - (1 if lines else 0)]
        for side, frame in enumerate(views):
            ax = axes[2 * column + side]
            if day is None:
                draw_view(ax, mesh.X, outer, None, None, frame, colours, norm)
                for points in lines:
                    ax.plot(points @ frame[0], points @ frame[1], color="k", lw=0.6, alpha=0.7)
            else:
                f = fields[day]
                draw_view(ax, mesh.X + np.nan_to_num(f.u), outer, f.lambda_e, f.tendon, frame, colours, norm)
            ax.set_aspect("equal")
            ax.autoscale_view()
            ax.set_axis_off()
            ax.set_title(("front", "back")[side], fontsize=8, color="0.35", y=-0.05)
            if side == 0:
                name = "day 0, fascicles" if day is None else f"day {day:g}"
                ax.text(1.05, 1.01, name, transform=ax.transAxes, ha="center", fontsize=10)
    # All on one scale, which a bar of 50 mm shows.
    low = min(ax.get_ylim()[0] for ax in axes)
    high = max(ax.get_ylim()[1] for ax in axes)
    half = max(np.ptp(ax.get_xlim()) for ax in axes) / 2
    for ax in axes:
        middle = np.mean(ax.get_xlim())
        ax.set(xlim=(middle - half, middle + half), ylim=(low, high))
    ax = axes[0]
    bar = 50.0 if height > 100 else 10.0 if height > 20 else 1.0
    x = ax.get_xlim()[0]
    ax.plot([x, x], [low, low + bar], color="k", lw=1.5, clip_on=False)
    ax.text(x, low + bar / 2, f"{bar:g} mm ", ha="right", va="center", fontsize=8)
    fig.subplots_adjust(left=0.06, right=0.88, top=0.94, bottom=0.06, wspace=0.08)
    place = fig.add_axes([0.905, 0.2, 0.013, 0.6])
    fig.colorbar(ScalarMappable(norm, colours), cax=place, extend="max", label=r"elastic stretch $\lambda_e$ [-]")
    pictures.save(fig, out / "muscle.png", colours)


def read_regions(path):
    """{region: {column: array}}"""
    found = {}
    for line, values in files.rows(path, REGIONS):
        row = [values[0], *values[2:]]
        names = [REGIONS[0], *REGIONS[2:]]
        found.setdefault(values[1], []).append([files.finite(path, line, *pair) for pair in zip(names, row)])
    return {region: dict(zip([REGIONS[0], *REGIONS[2:]], np.array(rows).T)) for region, rows in found.items()}


def draw_regions(out):
    regions = read_regions(out / "regions.csv")
    fig, axes = plt.subplots(1, 3, figsize=(11.4, 3.6))
    for name, (colour, style, width) in LINES.items():
        if name not in regions:
            continue
        r = regions[name]
        for ax, quantity in zip(axes[:2], ("lambda_e", "G")):
            ax.fill_between(r["time"], r[f"{quantity}_p05"], r[f"{quantity}_p95"], color=colour, alpha=0.15, lw=0)
            ax.plot(r["time"], r[f"{quantity}_p50"], color=colour, ls=style, lw=width, label=f"{name} third")
        axes[2].plot(r["time"], r["lambda_e_p99"], color=colour, ls=style, lw=width)
    for ax, title, label in zip(axes, ("elastic stretch: median, 5 % to 95 %", "sarcomere number: median, 5 % to 95 %",
                                       "elastic stretch that 1 % exceeds"),
                                (r"$\lambda_e$ [-]", r"$G$ [-]", r"$\lambda_e$ [-]")):
        ax.set_title(title, loc="left")
        ax.set(xlabel="time [days]", ylabel=label)
    axes[1].legend(loc="lower right")
    fig.tight_layout()
    pictures.save(fig, out / "regions.png")


def draw_against(out, other):
    """The thirds of this run, and of another one with regions.csv (./run mpi: the cylinder), on the same axes."""
    runs = [(out, "-", 2.0), (other, "--", 1.2)]
    fig, axes = plt.subplots(1, 3, figsize=(11.4, 3.6))
    for folder, style, width in runs:
        regions = read_regions(folder / "regions.csv")
        for name, (colour, *_) in LINES.items():
            if name in regions:
                r = regions[name]
                for ax, column in zip(axes, ("lambda_e_p50", "lambda_e_p99", "G_p50")):
                    ax.plot(r["time"], r[column], color=colour, ls=style, lw=width)
    for ax, title, label in zip(axes, ("elastic stretch: median", "elastic stretch that 1 % exceeds", "sarcomere number: median"),
                                (r"$\lambda_e$ [-]", r"$\lambda_e$ [-]", r"$G$ [-]")):
        ax.set_title(title, loc="left")
        ax.set(xlabel="time [days]", ylabel=label)
    handles = [plt.Line2D([], [], color=colour, label=f"{name} third") for name, (colour, *_) in LINES.items()]
    handles += [plt.Line2D([], [], color="0.3", ls=style, lw=width, label=str(folder)) for folder, style, width in runs]
    axes[2].legend(handles=handles, loc="lower right")
    fig.tight_layout()
    pictures.save(fig, out / "against.png")


def write_hot_volume(mesh, out):
    """Where the 1 % of the muscle's volume lies whose elements are stretched most: hot_volume.csv, before the deformation."""
    outer = facets(mesh)
    surface = np.zeros(len(mesh.cell_labels), dtype=bool)
    surface[[cell for _, cell in outer]] = True
    middle = np.zeros((len(mesh.cell_labels), 3))
    for kind, cells in mesh.kinds.items():
        middle[cells] = mesh.X[mesh.nodes_of[kind][:, :meshes.CORNERS[kind]]].mean(axis=1)
    start, line = mesh.centroid("PROXIMAL"), mesh.centroid("DISTAL") - mesh.centroid("PROXIMAL")
    along = (middle - start) @ line / (line @ line)
    held = np.unique([n for end in meshes.ENDS for f in mesh.surfaces[end] for n in f])
    volume = mesh.each(meshes.volumes)
    rows = []
    for day, paths in sorted(fields_of(out).items()):
        f = Fields(mesh, paths)
        order = [c for c in np.argsort(-f.lambda_e) if not f.tendon[c]]
        before = np.cumsum(volume[order]) - volume[order]
        hot = np.array(order)[before < 0.01 * volume[order].sum()]
        near = np.array([np.linalg.norm(mesh.X[held] - x, axis=1).min() for x in middle[hot]])
        share = [volume[hot][mask].sum() / volume[hot].sum() for mask in (along[hot] < 1 / 3, along[hot] > 2 / 3, surface[hot])]
        rows.append([f"{x:.6g}" for x in (day, f.lambda_e[hot].min(), len(hot), *share, np.median(near), near.max())])
    files.write_csv(out / "hot_volume.csv", HOT, rows)


def draw(mesh, out, ramp, against=None):
    write_hot_volume(mesh, out)
    with plt.rc_context(pictures.LAYOUT):
        draw_muscle(mesh, out, ramp)
    with plt.rc_context(pictures.GRID):
        draw_regions(out)
        if against:
            draw_against(out, against)
