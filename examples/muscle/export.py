"""Decks of other codes from the input of ./run muscle: Abaqus and CalculiX. docs/muscle.md says what they contain.

Units: mm, kPa, mN, days. The Abaqus deck has not been run in Abaqus: there was no licence.
"""
import pathlib
import re
import sys

import numpy as np

import fibres
import mesh as meshes
from raw import NODES, fail
from shared import files

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "abaqus"))
import fibres_to_initial_conditions  # noqa: E402

TYPES = {"tet4": "C3D4", "tet10": "C3D10", "hex8": "C3D8", "wedge6": "C3D6"}
NEVER = 1000.0  # an elastic stretch that a tendon does not reach, so that it does not grow
REQUIRED = ("c1", "c2", "tau", "gamma", "G_max", "lambda_crit")
REMOVAL = ("tau_rev", "gamma_rev", "G_min", "lambda_crit_rev")
STATE = ["G", "lambda_e", "lambda", "J", "Je", "n0_1", "n0_2", "n0_3"]
# Entries that a deck does not need: they are of the solver itself.
SOLVER_ONLY = re.compile(r"Solver/.*|Output/.*|Time/(Tolerance|Longest|Part|Times|Steps|Step|Ramp|End)")


class Input:
    """The entries that a deck is made from; whatever it cannot have is refused by name."""

    def __init__(self, entries, mesh):
        self.entries, self.mesh = dict(entries), mesh
        text = self.text
        values = {name: self.number(f"Muscle/{name}") for name in REQUIRED}
        values.update({name: self.number(f"Muscle/{name}", 0.0) for name in REMOVAL})
        self.choice("Muscle/Volume", ("pointwise",))
        self.choice("Muscle/Law", ("0",))
        self.choice("Muscle/Activation", ("0",))
        energy = self.choice("Muscle/Energy", ("reference", "grown"))
        integration = self.choice("Muscle/Integration", ("second order", "backward Euler"))
        self.options = [float(energy == "grown"), float(integration == "second order")]
        self.stiffness = self.number("Tendon/Stiffness", 100.0)
        self.fibre = self.choice("Fibre/Kind", ("default", "flow", "mesh", "uniform"))
        self.direction = np.array(self.numbers("Fibre/Direction", "0, 0, 1", 3))
        self.surfaces = [text(f"Fibre/{side}", default) for side, default in (("From", "PROXIMAL"), ("To", "DISTAL"))]
        self.names = [text(f"Attachments/{side}", side.upper()) for side in ("Proximal", "Distal")]
        if not np.linalg.norm(self.direction) > 0:
            self.refuse("Fibre/Direction", "a direction of a length > 0")
        self.set_fibres = self.read_set_fibres(text("Fibre/List", ""))
        flows = [*self.surfaces, *(s for of in self.set_fibres for s in of[3:])]
        for name in (*(name.strip() for names in flows for name in names.split(",")), *self.names):
            if name not in mesh.surfaces:
                fail(mesh.path, f"has no surface {name}; there are {', '.join(mesh.surfaces)}")
        self.ramp, self.end = self.number("Time/Ramp", 1.0), self.number("Time/End", 42.0)
        self.steps = self.choice("Time/Steps", ("adaptive", "fixed", "listed"))
        self.step = self.number("Time/Step", 0.02)
        self.times = self.numbers("Time/Times", "") if self.steps == "listed" else []
        self.output = self.numbers("Output/Times", "1, 7, 14, 28, 42")
        if self.steps == "listed":
            self.end = self.times[-1] if self.times else self.end
        self.materials = self.read_materials(text("Materials/List", ""), values)
        self.actions = self.read_actions(text("Attachments/List", "") or f"{self.names[0]} fixed; {self.names[1]} away 0.1")
        rest = [name for name in self.entries if not SOLVER_ONLY.fullmatch(name)]
        if rest:
            self.refuse(rest[0], "left out: no deck is written with it")

    def text(self, name, default=None):
        if default is None and name not in self.entries:
            fail(name, "is missing")
        self._last = self.entries.get(name, (default, name))
        return self.entries.pop(name, (default, name))[0]

    def refuse(self, name, allowed):
        value, place = self.entries.get(name, getattr(self, "_last", ("", name)))
        fail(f"{place}: {name} = {value}", f"for a deck of another code, must be {allowed}")

    def number(self, name, default=None):
        return self.numbers(name, default if default is None else repr(default), 1)[0]

    def numbers(self, name, default=None, count=None):
        text = self.text(name, default)
        try:
            values = [float(v) for v in str(text).split(",") if v.strip()]
            if np.isfinite(values).all() and (count is None or len(values) == count):
                return values
        except ValueError:
            pass
        self.refuse(name, f"{count or 'some'} finite number{'' if count == 1 else 's'}")

    def choice(self, name, allowed):
        value = self.text(name, allowed[0])
        if value not in allowed:
            self.refuse(name, " or ".join(allowed))
        return value

    def read_set_fibres(self, text):
        """[(set, kind, direction, from, to)]"""
        found = []
        for item in filter(None, map(str.strip, text.split(";"))):
            name, kind, *more = [*item.split(), ""]
            more = more[:-1]
            if name not in self.mesh.sections and name not in self.mesh.sets:
                fail("Fibre/List", f"there is no section or set {name}; there are {', '.join([*self.mesh.sections, *self.mesh.sets])}")
            try:
                direction = np.array(list(map(float, more))) if kind == "uniform" else None
                surfaces = more if kind == "flow" else self.surfaces
                if kind not in ("uniform", "flow", "mesh") or len(more) != {"uniform": 3, "flow": 2, "mesh": 0}[kind] or \
                        (direction is not None and not 0 < np.linalg.norm(direction) < np.inf):
                    raise ValueError
            except ValueError:
                fail("Fibre/List", f"{files.shown(item)}: expected NAME and uniform X Y Z, flow FROM TO or mesh")
            found.append((name, kind, direction, *surfaces))
        return found

    def read_materials(self, text, muscle):
        """{section: PROPS without fibre and options, or with them}"""
        given = {}
        for item in filter(None, map(str.strip, text.split(";"))):
            name, kind, *more = item.split() + [""]
            if kind not in ("muscle", "tendon"):
                fail("Materials/List", f"{files.shown(item)}: expected NAME and muscle or tendon")
            values = dict(muscle)
            if kind == "tendon":
                values.update(c1=muscle["c1"] * self.stiffness, c2=muscle["c2"] * self.stiffness, lambda_crit=NEVER, tau_rev=0.0)
            for entry in filter(None, more):
                key, _, value = entry.partition("=")
                try:
                    if key not in values:
                        raise ValueError
                    values[key] = float(value)
                except ValueError:
                    fail("Materials/List", f"{files.shown(item)}: expected parameters as NAME=VALUE, of {', '.join(values)}")
            given[name] = values
        if not given and len(self.mesh.sections) == 1:
            given = {self.mesh.sections[0]: muscle}
        for name in self.mesh.sections:
            if name not in given:
                fail("Materials/List", f"section {name} of {self.mesh.path} has no material")
        return {name: given[name] for name in self.mesh.sections}

    def read_actions(self, text):
        """{surface: (displacement in mm, [(time, factor)])}"""
        mesh, found = self.mesh, {}
        line = mesh.centroid(self.names[1]) - mesh.centroid(self.names[0])
        for item in filter(None, map(str.strip, text.split(";"))):
            words = item.split()
            table = [(0.0, 0.0), (self.ramp, 1.0)]
            try:
                if "at" in words:
                    at = words.index("at")
                    table = [tuple(map(float, w.split(":"))) for w in words[at + 1:]]
                    words = words[:at]
                    if any(len(row) != 2 for row in table) or not table or not np.isfinite(table).all():
                        raise ValueError
                    if table[0][0] > 0:
                        table.insert(0, (0.0, 0.0))
                name, kind, numbers = words[0], words[1], [float(w) for w in words[2:]]
                size = {"fixed": 0, "displaced": 3, "away": 1}.get(kind, -1)
                if len(numbers) != size or not np.isfinite(numbers).all():
                    raise ValueError
            except (ValueError, IndexError):
                fail("Attachments/List", f"{files.shown(item)}: a deck can have NAME fixed, NAME displaced DX DY DZ and NAME away PART, "
                                         "and 'at TIME:FACTOR ...'")
            if name not in mesh.surfaces:
                fail("Attachments/List", f"there is no surface {name}; there are {', '.join(mesh.surfaces)}")
            if any(b[0] <= a[0] for a, b in zip(table, table[1:])):
                fail("Attachments/List", f"{files.shown(item)}: the times after 'at' must ascend; a deck cannot have jumps")
            side = -1 if name == self.names[0] else 1
            u = np.zeros(3) if kind == "fixed" else np.array(numbers) if kind == "displaced" else side * numbers[0] * line
            found[name] = (u, table)
        return found

    def periods(self):
        """(start, end, moves) between the times at which something changes or is to be written."""
        times = {t for _, table in self.actions.values() for t, _ in table} | set(self.output)
        times |= set(self.times)
        if self.steps == "fixed":
            times |= set((self.step * np.arange(1, int(round(self.end / self.step)))).tolist())
        times = sorted(t for t in times if 0 < t < self.end * (1 - 1e-9)) + [self.end]
        periods = []
        for start, end in zip([0.0] + times, times):
            moves = any(np.any(u) and factor(table, start) != factor(table, end) for u, table in self.actions.values())
            periods.append((start, end, moves))
        return periods

    def first_increment(self):
        """So that no increment moves an attachment by more than 0.4 of the shortest edge: CalculiX begins with all of it in
        the last layer of elements."""
        mesh = self.mesh
        shortest = min(np.linalg.norm(X[:, a] - X[:, b], axis=1).min() for X in map(mesh.corners, mesh.kinds)
                       for a, b in ((0, 1), (1, 2), (0, X.shape[1] - 1)))
        rates = [np.linalg.norm(u) * abs(b[1] - a[1]) / max(b[0] - a[0], 1e-12) for u, table in self.actions.values()
                 for a, b in zip(table, table[1:])]
        return 0.4 * shortest / max(max(rates, default=0), 1e-12)


def factor(table, t):
    return float(np.interp(t, [row[0] for row in table], [row[1] for row in table]))


def second_degree(mesh):
    """Makes each tetrahedron of first degree one of second, with straight edges."""
    if list(mesh.kinds) != ["tet4"]:
        if list(mesh.kinds) == ["tet10"]:
            return
        fail(mesh.path, f"Mesh/Degree = 2: must be 'as the file' where there are {', '.join(mesh.kinds)}")
    nodes, n = mesh.nodes_of.pop("tet4"), len(mesh.X)
    pairs = np.sort(nodes[:, meshes.EDGES].reshape(-1, 2), axis=1)
    unique, index = np.unique(pairs, axis=0, return_inverse=True)
    mesh.X = np.vstack([mesh.X, mesh.X[unique].mean(axis=1)])
    mesh.labels = np.concatenate([mesh.labels, mesh.labels.max() + 1 + np.arange(len(unique))])
    mesh.nodes_of["tet10"] = np.hstack([nodes, n + index.reshape(-1, 6)])
    mesh.kinds["tet10"] = mesh.kinds.pop("tet4")


def _rows(numbers, most=12):
    numbers = list(map(str, numbers))
    return "".join(", ".join(numbers[i:i + most]) + "\n" for i in range(0, len(numbers), most))


def _set(kind, name, numbers):
    return f"*{kind}, {kind}={name}\n" + _rows(numbers)


def clean(name):
    return re.sub(r"[^A-Z0-9_-]", "_", name.upper())


def _mesh(mesh, labels, numbers):
    text = ["*NODE, NSET=ALLNODES\n"]
    text += ["%d, %.12g, %.12g, %.12g\n" % (label, *x) for label, x in zip(labels.tolist(), mesh.X.tolist())]
    for kind, cells in mesh.kinds.items():
        text.append(f"*ELEMENT, TYPE={TYPES[kind]}, ELSET=ALLELEMENTS\n")
        for number, nodes in zip(numbers[cells].tolist(), labels[mesh.nodes_of[kind]].tolist()):
            text.append(", ".join(map(str, (number, *nodes))) + "\n")
    for k, name in enumerate(mesh.sections):
        text.append(_set("ELSET", clean(name), numbers[mesh.section == k].tolist()))
    for name, cells in mesh.sets.items():
        text.append(_set("ELSET", clean(name), numbers[cells].tolist()))
    for name in mesh.surfaces:
        text.append(_set("NSET", clean(name), labels[fibres.surface_nodes(mesh, name)].tolist()))
    return "".join(text)


def _numbered(mesh):
    """Labels of nodes and elements: the file's, or from 1 where it counts from 0."""
    return mesh.labels + (mesh.labels.min() < 1), mesh.cell_labels + (mesh.cell_labels.min() < 1)


def _props(values, n0, options):
    """PROPS, as short as they may be."""
    props = [values[name] for name in REQUIRED] + list(n0) + [0.0] + options
    if values["tau_rev"] > 0:
        props += [0.0] + [values[name] for name in REMOVAL]
    return props


def _numbers(values):
    return "".join(", ".join(f"{v:.15g}" for v in values[i:i + 8]) + "\n" for i in range(0, len(values), 8))


def _amplitudes(given):
    return "".join(f"*AMPLITUDE, NAME=MOVES_{clean(name)}, TIME=TOTAL TIME\n" +
                   "".join(f"{t:.15g}, {f:.15g}\n" for t, f in extended(table, given.end))
                   for name, (u, table) in given.actions.items() if np.any(u))


def extended(table, end):
    return table + ([(end + 1, table[-1][1])] if table[-1][0] < end + 1 else [])


def _increments(given, start, end, moves):
    period = end - start
    if given.steps != "adaptive":
        return f"{period:.15g}, {period:.15g}, {1e-6 * period:.6g}, {period:.15g}"
    if moves:
        longest = period / 20
        first = min(longest, given.first_increment())
    else:
        longest = min(1.0, period / 4) if start < 14 else min(4.0, period / 4)
        first = min(0.05, longest)
    return f"{first:.10g}, {period:.15g}, {1e-6 * period:.6g}, {longest:.10g}"


def calculix(given, n0):
    mesh = given.mesh
    labels, numbers = _numbered(mesh)
    text = [f"** myogrowth: {ascii(str(mesh.path))}\n** Units: mm, kPa, mN, days. Needs libMYOGROWTH.so: examples/calculix/README.md\n",
            _mesh(mesh, labels, numbers)]
    for name, values in given.materials.items():
        props = _props(values, (0.0, 0.0, 1.0), given.options)
        material = f"@ABAQUS_MYOGROWTH_CCX@{clean(name)}"
        text.append(f"*MATERIAL, NAME={material}\n*DEPVAR\n{len(STATE)}\n** c1, c2, tau, gamma, G_max, lambda_crit, n0 (of points: "
                    f"below); frame, energy, integration\n*USER MATERIAL, CONSTANTS={len(props)}\n{_numbers(props)}"
                    f"*SOLID SECTION, ELSET={clean(name)}, MATERIAL={material}\n")
    text.append("** The fibre of each point: element, point, 0, n0, -1 (STATEV(5) = -1 says that STATEV(2:4) is a fibre), 0\n")
    for kind, cells in mesh.kinds.items():
        for number, points in zip(numbers[cells].tolist(), n0[kind].tolist()):
            for q, n in enumerate(points, 1):
                text.append("*INITIAL CONDITIONS, TYPE=SOLUTION\n%d, %d, 0., %.12g, %.12g, %.12g, -1., 0.\n" % (number, q, *n))
    text.append(_amplitudes(given))
    for name, (u, _) in given.actions.items():
        if not np.any(u):
            text.append(f"*BOUNDARY\n{clean(name)}, 1, 3\n")
    moving = {name: (u, table) for name, (u, table) in given.actions.items() if np.any(u)}
    for start, end, moves in given.periods():
        text.append(f"** Days {start:g} to {end:g}\n*STEP, NLGEOM, INC=100000\n*STATIC\n{_increments(given, start, end, moves)}\n")
        # CalculiX's own tolerance is half a per cent of the forces, and it judges the rate after a few iterations.
        text.append("*CONTROLS, PARAMETERS=FIELD\n1.E-7, 1.E-5,,, 1.E-7,,, 1.E-12\n*CONTROLS, PARAMETERS=TIME INCREMENTATION\n"
                    "10, 20, 40, 40\n")
        for name, (u, _) in moving.items():
            for i in range(3):
                text.append(f"*BOUNDARY, AMPLITUDE=MOVES_{clean(name)}\n{clean(name)}, {i + 1}, {i + 1}, {u[i]:.15g}\n")
        often = ", FREQUENCY=100000"  # at the step's end only; in CalculiX it is one setting for all requests
        text.append(f"*EL PRINT, ELSET=ALLELEMENTS{often}\nSDV\n")
        for name in given.actions:
            text.append(f"*NODE PRINT, NSET={clean(name)}, TOTALS=ONLY{often}\nRF\n")
        text.append(f"*NODE FILE{often}\nU, RF\n*EL FILE{often}\nS, SDV\n*END STEP\n")
    return "".join(text)


def abaqus(given, n0):
    mesh = given.mesh
    labels, numbers = _numbered(mesh)
    mean = fibres.of_elements(mesh, n0)
    text = [f"*HEADING\nmyogrowth: {ascii(str(mesh.path))[:70]}\n** Units: mm, kPa, mN, days. Never run in Abaqus by us: "
            "examples/abaqus/README.md\n", _mesh(mesh, labels, numbers)]
    names = "".join(f"{i}, {name.upper()}\n" for i, name in enumerate(STATE, 1))
    for name, values in given.materials.items():
        props = _props(values, (0.0, 0.0, 1.0), given.options)
        text.append(f"*SOLID SECTION, ELSET={clean(name)}, MATERIAL={clean(name)}\n,\n*MATERIAL, NAME={clean(name)}\n*DEPVAR\n{len(STATE)}\n"
                    f"{names}** c1, c2, tau, gamma, G_max, lambda_crit, n0 (of elements: below); frame, energy, integration\n"
                    f"*USER MATERIAL, CONSTANTS={len(props)}, UNSYMM\n{_numbers(props)}")
    text.append("** The fibre of each element in STATEV(6:8)\n")
    rows = {number: [f"{c:.12g}" for c in n] for number, n in zip(numbers.tolist(), mean.tolist())}
    text.append(fibres_to_initial_conditions.block(rows, len(STATE)))
    text.append(_amplitudes(given))
    for name, (u, _) in given.actions.items():
        if not np.any(u):
            text.append(f"*BOUNDARY\n{clean(name)}, 1, 3\n")
    moving = {name: (u, table) for name, (u, table) in given.actions.items() if np.any(u)}
    for k, (start, end, moves) in enumerate(given.periods()):
        text.append(f"*STEP, NAME=DAY_{end:g}, NLGEOM=YES, UNSYMM=YES, INC=100000\nday {start:g} to {end:g}\n*STATIC\n"
                    f"{_increments(given, start, end, moves)}\n".replace(f"NAME=DAY_{end:g}", f"NAME=PERIOD_{k + 1}"))
        for name, (u, _) in moving.items():
            text.append(f"*BOUNDARY, AMPLITUDE=MOVES_{clean(name)}\n" +
                        "".join(f"{clean(name)}, {i + 1}, {i + 1}, {u[i]:.15g}\n" for i in range(3)))
        text.append("*OUTPUT, FIELD, FREQUENCY=1000\n*ELEMENT OUTPUT\nS, LE, SDV\n*NODE OUTPUT\nU, RF\n")
        for name in given.actions:
            text.append(f"*NODE PRINT, NSET={clean(name)}, FREQUENCY=1000, SUMMARY=NO, TOTALS=YES\nRF\n")
        text.append("*END STEP\n")
    return "".join(text)


def distribution(mesh, n0):
    """Local bases whose first axis is the fibre, for laws that take it from *ORIENTATION."""
    _, numbers = _numbered(mesh)
    mean = fibres.of_elements(mesh, n0)
    other = np.eye(3)[np.argmin(np.abs(mean), axis=1)]
    second = other - np.sum(other * mean, axis=1)[:, None] * mean
    second /= np.linalg.norm(second, axis=1)[:, None]
    rows = ["%d, " % k + ", ".join(f"{c:.12g}" for c in (*a, *b)) + "\n" for k, a, b in zip(numbers.tolist(), mean.tolist(), second.tolist())]
    return ("** Fibre along axis 1. Use: *SOLID SECTION, ..., ORIENTATION=FIBRES; with our UMAT not needed, and PROPS(10) = 1 then\n"
            "*DISTRIBUTION TABLE, NAME=FIBRES_TABLE\nCOORD3D, COORD3D\n"
            "*DISTRIBUTION, NAME=FIBRES_FIELD, LOCATION=ELEMENT, TABLE=FIBRES_TABLE\n, 1., 0., 0., 0., 1., 0.\n" + "".join(rows)
            + "*ORIENTATION, NAME=FIBRES, SYSTEM=RECTANGULAR\nFIBRES_FIELD\n3, 0.\n")


def write_vtu(path, mesh, n0):
    import meshio

    kinds = {"tet4": "tetra", "tet10": "tetra10", "hex8": "hexahedron", "wedge6": "wedge"}
    mean = fibres.of_elements(mesh, n0)
    grid = meshio.Mesh(mesh.X, [(kinds[k], mesh.nodes_of[k]) for k in mesh.kinds],
                       cell_data={"fibre": [mean[c] for c in mesh.kinds.values()],
                                  "region": [mesh.section[c].astype(np.int32) for c in mesh.kinds.values()]})
    with files.writing(path) as part:
        meshio.write(part, grid, file_format="vtu")


def write(code, mesh, entries, out):
    """The files of a job for `code`; returns their names."""
    entries = dict(entries)
    degree = entries.pop("Mesh/Degree", ("as the file", "Mesh/Degree"))
    if degree[0] not in ("as the file", "2"):
        fail(f"{degree[1]}: Mesh/Degree = {degree[0]}", "for a deck of another code, must be 'as the file' or 2")
    if degree[0] == "2":
        second_degree(mesh)
    given = Input(entries, mesh)
    n0 = fibres.at_points(mesh, given.fibre, given.direction, *given.surfaces, given.set_fibres)
    deck = out / f"muscle_{code}.inp"
    written = [deck, out / "fibres.vtu"]
    files.write_text(deck, {"calculix": calculix, "abaqus": abaqus}[code](given, n0), encoding="ascii")
    write_vtu(out / "fibres.vtu", mesh, n0)
    if code == "abaqus":
        written.append(out / "fibres_orientation.inp")
        files.write_text(written[-1], distribution(mesh, n0), encoding="ascii")
    return written
