"""Reads Gmsh's .msh (2.2 and 4.1) and VTK's files: physical groups, region ids, 0/1 fields and fibres become sets.

ASCII .msh is read here, so that faults have lines; binary .msh, .vtk and .vtu by meshio, where elements and nodes are
counted from 0 in the order of the file, as ParaView does.
"""
import contextlib
import io
import pathlib
import re

import numpy as np

from raw import Cell, Raw, fail, some
from shared import files

SOLIDS = {4: ("tet4", 4), 11: ("tet10", 10), 5: ("hex8", 8), 6: ("wedge6", 6)}  # Gmsh's types
PLANES = {2: (3, 3), 3: (4, 4), 9: (3, 6), 16: (4, 8), 10: (4, 9)}  # corners, nodes
LOW = {15: 1, 1: 2, 8: 3, 26: 4, 27: 5}  # points and lines: nodes
GMSH_TET10 = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
OF_MESHIO = {"tetra": "tet4", "tetra10": "tet10", "hexahedron": "hex8", "wedge": "wedge6"}
PLANES_OF_MESHIO = {"triangle": 3, "quad": 4, "triangle6": 3, "quad8": 4, "quad9": 4}
REGIONS = ("section", "sections", "region", "regions", "material", "materialids", "material_id", "set", "physical",
           "gmsh:physical", "cellentityids", "medit:ref")
FIBRES = ("fibre", "fiber", "fibres", "fibers", "f0", "n0", "fibre_direction", "fiber_direction")


def named(name):
    """A name as sets have it here: upper case, ASCII, without what parts names in lists and tables."""
    return re.sub(r'[\s,;"]+', "_", str(name).upper().encode("ascii", "backslashreplace").decode().strip())


class _Msh:
    """The lines of an ASCII .msh."""

    def __init__(self, path):
        self.raw, self.groups, self.entities, self.index = Raw(path, [path]), {}, {}, {}
        self.seen, self.repeated, self.low = {}, 0, 0
        self.fields, self.unused = {}, []  # of $ElementData with three components: {name: {label: vector}}
        self.lines, self.at = files.read_text(path).split("\n"), 0

    def fail(self, words, line=None):
        fail(f"{self.raw.path}:{line or self.at}", words)

    def next(self, expected):
        if self.at >= len(self.lines):
            self.fail(f"the file ends here, expected {expected}", len(self.lines))
        self.at += 1
        return self.lines[self.at - 1].strip()

    def numbers(self, expected, least, kind=int, text=None):
        text = self.next(expected) if text is None else text
        try:
            values = [kind(x) for x in text.split()]
            if len(values) >= least and np.isfinite(values).all():
                return values
        except (ValueError, OverflowError):
            pass
        self.fail(f"{files.shown(text)}: expected {expected}")

    def read(self, names, fibre):
        version = None
        while self.at < len(self.lines):
            text = self.next("a section")
            if not text:
                continue
            if not text.startswith("$"):
                self.fail(f"{files.shown(text)}: expected $ and the name of a section")
            name = text[1:]
            if name == "MeshFormat":
                text = self.next("the version")
                version, binary = (text.split() + ["", "", ""])[:2]
                if version not in ("2.2", "4.1") or binary != "0":
                    self.fail(f"{files.shown(text)}: expected 2.2 or 4.1, and 0 for ASCII")
            elif name == "PartitionedEntities":
                self.fail("the mesh is partitioned: save it whole")
            elif version and name in ("PhysicalNames", "Entities", "Nodes", "Elements", "ElementData"):
                read = {"PhysicalNames": self.physical_names, "Entities": self.read_entities, "ElementData": self.element_data}.get(name)
                (read or getattr(self, f"{name.lower()}_{version[0]}"))()
            else:
                self.unused.append(name)
                while self.next(f"$End{name}") != f"$End{name}":
                    pass
                continue
            while (text := self.next(f"$End{name}")) == "":
                pass
            if text != f"$End{name}":
                self.fail(f"{files.shown(text)}: expected $End{name}")
        if version is None:
            self.fail("has no $MeshFormat")
        raw = self.raw
        if self.repeated:
            raw.notes.append(f"{self.repeated} elements are there more than once, for several physical groups: taken once")
        if self.low:
            raw.notes.append(f"{self.low} points and lines are not used")
        unused = [name for name in dict.fromkeys(self.unused) if name not in ("Comments", "Periodic", "Parametrizations")]
        if unused:
            raw.notes.append("sections that are not used: " + ", ".join("$" + name for name in unused))
        self.find_fibres(fibre)
        rename(raw, names)
        return raw

    def find_fibres(self, wanted):
        raw = self.raw
        name = pick(raw.path, "fibre", {name: [np.zeros((1, 3))] for name in self.fields}, wanted, FIBRES, lambda a: True)
        if name is None:
            return
        values = self.fields[name]
        lacking = [cell.label for cell in raw.cells if cell.label not in values]
        if lacking:
            fail(raw.path, f"$ElementData '{name}': has no fibre for elements {some(lacking)}")
        raw.fibres, raw.fibres_from = [tuple(values[cell.label]) for cell in raw.cells], f"$ElementData '{name}'"

    def element_data(self):
        tags = [[self.next("a tag") for _ in range(self.numbers("the number of tags", 1)[0])] for _ in range(3)]
        name = (tags[0] or [""])[0].strip('"')
        _, components, count = [*self.numbers("step, components, rows", 3, text=" ".join(tags[2])), 0][:3]
        rows = {}
        for _ in range(count):
            label, *values = self.numbers(f"an element's number and {components} numbers", 1 + components, float)
            rows[int(label)] = values[:components]
        if components == 3:
            self.fields[name] = rows
        else:
            self.unused.append(f"ElementData '{name}' ({components} components)")

    def physical_names(self):
        for _ in range(self.numbers("the number of names", 1)[0]):
            text = self.next("a name")
            match = re.fullmatch(r'(\d)\s+(-?\d+)\s+"(.*)"', text)
            if not match:
                self.fail(f'{files.shown(text)}: expected dimension, number and "name"')
            self.groups[int(match[1]), int(match[2])] = named(match[3])

    def read_entities(self):
        counts = self.numbers("the numbers of points, curves, surfaces and volumes", 4)
        for dim, count in enumerate(counts[:4]):
            for _ in range(count):
                values = self.numbers("an entity", 5 if dim == 0 else 8, float)
                at = 4 if dim == 0 else 7
                self.entities[dim, int(values[0])] = [int(v) for v in values[at + 1:at + 1 + int(values[at])]]

    def node(self, label, x):
        if label in self.index:
            self.fail(f"node {label} is there already, in line {self.raw.node_places[self.index[label]][1]}")
        self.index[label] = len(self.raw.nodes)
        self.raw.nodes.append(tuple(x))
        self.raw.node_labels.append(label)
        self.raw.node_places.append((0, self.at))

    def nodes_2(self):
        for _ in range(self.numbers("the number of nodes", 1)[0]):
            values = self.numbers("a node: number, x, y, z", 4, float)
            self.node(int(values[0]), values[1:4])

    def nodes_4(self):
        for _ in range(self.numbers("the number of blocks", 4)[0]):
            count = self.numbers("a block of nodes", 4)[3]
            labels = [self.numbers("a node's number", 1)[0] for _ in range(count)]
            for label in labels:
                self.node(label, self.numbers(f"coordinates of node {label}", 3, float)[:3])

    def elements_2(self):
        for _ in range(self.numbers("the number of elements", 1)[0]):
            values = self.numbers("an element: number, type, tags, nodes", 4)
            label, kind, tags = values[:3]
            self.element(label, kind, [t for t in values[3:4] if tags > 0 and t], values[3 + tags:])

    def elements_4(self):
        for _ in range(self.numbers("the number of blocks", 4)[0]):
            dim, entity, kind, count = self.numbers("a block of elements", 4)[:4]
            groups = self.entities.get((dim, entity), [])
            for _ in range(count):
                label, *nodes = self.numbers("an element: number, nodes", 2)
                self.element(label, kind, groups, nodes)

    def element(self, label, kind, groups, nodes):
        raw = self.raw
        count = SOLIDS[kind][1] if kind in SOLIDS else PLANES[kind][1] if kind in PLANES else LOW.get(kind)
        if count is None:
            self.fail(f"element {label} is of Gmsh's type {kind}: allowed are tetrahedra of 4 and 10 nodes (4, 11), hexahedra of 8 "
                      "(5) and wedges of 6 (6), and triangles and quadrilaterals for surfaces")
        if len(nodes) != count:
            self.fail(f"element {label}: {len(nodes)} nodes, expected {count}")
        missing = [n for n in nodes if n not in self.index]
        if missing:
            self.fail(f"element {label}: node {missing[0]} is not there")
        nodes = [self.index[n] for n in nodes]
        if kind in LOW:
            self.low += 1
        elif kind in PLANES:
            for g in groups:
                raw.surfaces.setdefault(self.group(2, g), []).append(tuple(nodes[:PLANES[kind][0]]))
        else:
            if kind == 11:
                nodes = [nodes[k] for k in GMSH_TET10]
            key = tuple(nodes)
            if key in self.seen and groups:
                self.repeated += 1
            else:
                self.seen[key] = len(raw.cells)
                raw.cells.append(Cell(SOLIDS[kind][0], label, nodes, (0, self.at)))
            for g in groups:
                raw.elsets.setdefault(self.group(3, g), []).append(self.seen[key])

    def group(self, dim, tag):
        return self.groups.get((dim, abs(tag)), str(abs(tag)))


def rename(raw, names):
    """Numbers of groups that the user has given names: --names 1=MUSCLE,11=PROXIMAL."""
    for number, name in (names or {}).items():
        found = [table for table in (raw.elsets, raw.surfaces) if number in table]
        if not found:
            there = sorted({*raw.elsets, *raw.surfaces})
            fail(raw.path, f"--names {number}={name}: there is no group of this number; there are {', '.join(there) or 'none'}")
        for table in found:
            table.setdefault(named(name), []).extend(table.pop(number))


def read_msh(path, names=None, fibre=None):
    head = files.read_bytes(path)[:200].split(b"\n")
    if head[0].strip() == b"$MeshFormat" and len(head) > 1 and head[1].split()[1:2] == [b"1"]:
        return read_meshio(path, names, fibre=fibre, file_format="gmsh")
    return _Msh(path).read(names, fibre)


# ---- By meshio

def read_meshio(path, names=None, region=None, fibre=None, file_format=None):
    import meshio

    files.read_bytes(path)[:1]  # says so if it cannot be read
    file_format = file_format or pathlib.Path(path).suffix[1:].lower()
    try:
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            mesh = getattr(meshio, file_format).read(path)  # meshio.read() ends the program without saying why
    except (Exception, SystemExit) as e:  # meshio has no exception of its own for most faults
        hint = {"gmsh": "save it as ASCII (Mesh.Binary = 0)", "vtk": "save it as .vtu, or as ASCII"}.get(file_format, "")
        fail(path, "; ".join(filter(None, (f"meshio cannot read it: {type(e).__name__}" + f": {e}".rstrip(": "), hint))))
    raw = Raw(path, [path])
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3:
        fail(path, "its points do not have three coordinates")
    raw.nodes = [tuple(p) for p in points.tolist()]
    raw.node_labels = list(range(len(points)))
    raw.node_places = [(0, 0)] * len(points)
    raw.notes.append("nodes and elements are counted from 0, in the order of the file")
    arrays = {name: [plain(v) for v in values] for name, values in mesh.cell_data.items()}
    at_points = {name: plain(values) for name, values in mesh.point_data.items()}
    region = pick(path, "region", arrays, region, REGIONS, lambda a: a.ndim == 1 and np.array_equal(a, np.round(a)))
    vectors = {name: [values] for name, values in at_points.items() if name not in arrays}
    fibre = pick(path, "fibre", {**vectors, **arrays}, fibre, FIBRES, lambda a: a.ndim == 2 and a.shape[1] == 3)
    groups = {(int(d), int(tag)): named(name) for name, (tag, d) in mesh.field_data.items()} if file_format == "gmsh" else {}
    fibres, label = [], 0
    flags = [name for name, values in arrays.items() if name != region and named(name) not in map(named, REGIONS)
             and all(v.ndim == 1 and np.isin(v, (0, 1)).all() for v in values)]
    for b, block in enumerate(mesh.cells):
        kind, data = block.type, np.asarray(block.data)
        if kind not in OF_MESHIO and kind not in PLANES_OF_MESHIO and kind not in ("vertex", "line", "line3"):
            fail(path, f"element {label} is of type {kind}: allowed are {', '.join(OF_MESHIO)}, and triangle and quad for surfaces")
        if data.size and not (0 <= data.min() and data.max() < len(points)):
            fail(path, f"an element of type {kind} has node {data.min() if data.min() < 0 else data.max()}, of {len(points)} "
                       "counted from 0")
        for i, nodes in enumerate(data.tolist()):
            group = int(arrays[region][b][i]) if region else None
            if kind in OF_MESHIO:
                if region and not (file_format == "gmsh" and group == 0):
                    raw.elsets.setdefault(groups.get((3, group), str(group)), []).append(len(raw.cells))
                for name in flags:
                    if arrays[name][b][i]:
                        raw.elsets.setdefault(named(name), []).append(len(raw.cells))
                raw.cells.append(Cell(OF_MESHIO[kind], label, nodes, (0, 0)))
                if fibre in arrays:
                    fibres.append(tuple(arrays[fibre][b][i].tolist()))
                elif fibre:
                    fibres.append(mean_direction(at_points[fibre][nodes]))
            elif kind in PLANES_OF_MESHIO and region:
                raw.surfaces.setdefault(groups.get((2, group), str(group)), []).append(tuple(nodes[:PLANES_OF_MESHIO[kind]]))
            label += 1
    for name, values in at_points.items():
        if values.ndim == 1 and np.isin(values, (0, 1)).all():
            raw.nsets[named(name)] = np.flatnonzero(values).tolist()
    if not raw.cells:
        fail(path, "has no tetrahedra, hexahedra or wedges")
    if fibre:
        raw.fibres, raw.fibres_from = fibres, f"{'cell' if fibre in arrays else 'point'} data '{fibre}'"
    if region:
        raw.notes.append(f"sections and surfaces by the cell data '{region}'")
    rename(raw, names)
    return raw


def plain(values):
    """Fields of one component, which legacy VTK has as (n, 1), as (n,)."""
    values = np.asarray(values)
    return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values


def mean_direction(vectors):
    """Of the nodes of a cell. A fibre has no sign: all are taken as the first one points."""
    return tuple((vectors * np.where(vectors @ vectors[0] < 0, -1, 1)[:, None]).sum(axis=0).tolist())


def pick(path, what, arrays, wanted, usual, fits):
    """The name of the cell data that say the region, or the fibre."""
    good = [name for name, values in arrays.items() if values and all(fits(v) for v in values)]
    if wanted is not None:
        if wanted not in good:
            fail(path, f"--{what} {wanted}: is no such cell data; those that fit are {', '.join(good) or 'none'}")
        return wanted
    return next((name for u in usual for name in good if name.lower() == u), None)
