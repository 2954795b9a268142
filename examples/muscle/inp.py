"""Reads an Abaqus deck's mesh: nodes, elements, sets, surfaces, solid sections; flat, or parts and their instances.

The rest of the deck (materials, steps, boundary conditions ...) is not used, and named in the notes.
"""
import math
import pathlib
import re

import numpy as np

from raw import FACES, NODES, Cell, Raw, fail, some
from shared import files

KINDS = {
    "tet4": "C3D4 C3D4H", "tet10": "C3D10 C3D10H C3D10HS C3D10I C3D10M C3D10MH C3D10T",
    "hex8": "C3D8 C3D8H C3D8HS C3D8I C3D8IH C3D8R C3D8RH C3D8S", "wedge6": "C3D6 C3D6H",
}
TYPES = {name: kind for kind, names in KINDS.items() for name in names.split()}
# Cards that make or move nodes and elements without listing them.
GENERATORS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL", "SUBSTRUCTURE GENERATE",
              "SYMMETRIC MODEL GENERATION", "IMPORT", "IMPORT NSET", "IMPORT ELSET", "MODEL CHANGE", "ELEMENT DELETE")
# Cards that join what the mesh itself does not.
JOINTS = ("TIE", "MPC", "EQUATION", "COUPLING", "RIGID BODY", "EMBEDDED ELEMENT", "CONTACT PAIR", "CONTACT", "SHELL TO SOLID COUPLING")
GENERATED_NAME = re.compile(r"_?PICKED.*|_?I\d+|SET-\d+")  # names that Abaqus/CAE makes up


class Card:
    def __init__(self, keyword, parameters, place):
        self.keyword, self.parameters, self.place, self.data = keyword, parameters, place, []


class Scope:
    """The names of a part, of an instance or of the deck."""

    def __init__(self, name, other=None):
        self.name = name
        self.nodes = dict(other.nodes) if other else {}  # label to (x, y, z, place)
        self.elements = dict(other.elements) if other else {}  # label to (kind, labels, place)
        self.sections = list(other.sections) if other else []  # (set, material, orientation, place)
        self.axes = {kind: dict(other.axes[kind]) if other else {} for kind in ("ORIENTATION", "DISTRIBUTION")}  # name to card
        self.sets = {kind: {name: list(rows) for name, rows in (other.sets[kind].items() if other else ())}
                     for kind in ("NSET", "ELSET", "SURFACE")}
        self.move = None  # of an instance: (place, numbers) of its data lines
        self.node_index, self.cell_index = {}, {}


class Deck:
    def __init__(self, path, fibre=None):
        self.raw, self.fibre = Raw(path), fibre  # the local axis that is the fibre: 1, 2 or 3
        self.top, self.parts, self.instances, self.unused = Scope(""), {}, {}, {}
        self.scope, self.inside = self.top, None

    def where(self, place):
        return self.raw.where(place)

    def fail(self, place, words):
        fail(self.where(place), words)

    # ---- Lines and cards

    def text_of(self, path):
        """Decks of Windows have other letters in their comments and names than UTF-8's."""
        data = files.read_bytes(path)
        try:
            data.decode("utf-8-sig")
        except UnicodeDecodeError:
            if data[:2] not in (b"\xff\xfe", b"\xfe\xff"):
                self.raw.notes.append(f"{path} is not UTF-8: read as Latin-1")
                return data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")
        return files.read_text(path)

    def lines(self, path, chain=()):
        """(place, text, path) of a file's lines and of those that it includes; comments are left out."""
        if path.resolve() in chain:
            raise files.FileError(f"{path}: includes itself, by *INCLUDE")
        chain, number = (*chain, path.resolve()), len(self.raw.places)
        self.raw.places.append(path)
        include = ""
        for line, text in enumerate(self.text_of(path).split("\n"), 1):
            text = text.strip()
            if not text or text.startswith("**"):
                continue
            if include or re.match(r"\*\s*include\b", text, re.IGNORECASE):
                include += text
                if not include.endswith(","):
                    name = self.card(include, (number, line)).parameters.get("INPUT")
                    if not name:
                        self.fail((number, line), "*INCLUDE needs INPUT=FILE")
                    yield from self.lines(self.beside(name, path, (number, line)), chain)
                    include = ""
                continue
            yield (number, line), text, path

    def beside(self, name, path, place):
        """A file that a deck names: relative to its own folder, or to that of the first deck."""
        name = name.replace("\\", "/")
        for folder in (path.parent, pathlib.Path(self.raw.path).parent):
            if (folder / name).is_file():
                return folder / name
        self.fail(place, f"there is no file {files.shown(name)} in {path.parent}")

    def cards(self, path):
        card, head, start = None, "", None
        for place, text, path in self.lines(path):
            if head and not text[0].isalpha():  # a comma too many: the card does not go on
                if card:
                    yield card
                card, head = self.card(head, start), ""
            if head or text.startswith("*"):
                start, head = start if head else place, head + text
                if head.endswith(","):
                    continue
                if card:
                    yield card
                card, head = self.card(head, start), ""
                name = card.parameters.get("INPUT")
                if name and card.keyword in ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "DISTRIBUTION"):
                    for row, text, _ in self.lines(self.beside(name, path, place)):
                        if text.startswith("*"):
                            self.fail(row, f"expected the data of *{card.keyword}, found a card: use *INCLUDE")
                        card.data.append((row, text))
            elif card:
                card.data.append((place, text))
            else:
                self.fail(place, f"{files.shown(text)}: data without a card above them")
        if head:
            self.fail(start, "the file ends in the middle of a card: a comma at its end says that it goes on")
        if card:
            yield card

    def card(self, text, place):
        fields = re.findall(r'(?:"[^"]*"|[^,"])+', text)
        keyword = " ".join(fields[0][1:].upper().split())
        parameters = {}
        for entry in fields[1:]:
            name, _, value = entry.partition("=")
            value = value.strip()
            parameters["".join(name.upper().split())] = value.strip('"') if value.startswith('"') else value
        if not keyword:
            self.fail(place, f"{files.shown(text)}: expected the name of a card after *")
        return Card(keyword, parameters, place)

    def fields(self, text):
        return [f.strip() for f in text.rstrip(",").split(",")] if '"' not in text else \
            [f.strip().strip('"') for f in re.findall(r'(?:"[^"]*"|[^,"])+', text.rstrip(","))]

    def whole(self, place, text, what):
        if re.fullmatch(r"[+]?\d{1,18}", text) and int(text) > 0:
            return int(text)
        self.fail(place, f"{files.shown(text)}: expected {what}, a whole number > 0")

    def number(self, place, text, what):
        if not text:
            return 0.0
        try:
            x = float(re.sub("[dD]", "e", text)) if "_" not in text else math.nan
            if math.isfinite(x):
                return x
        except ValueError:
            pass
        self.fail(place, f"{files.shown(text)}: expected {what}, a finite number")

    def needed(self, card, name):
        value = card.parameters.get(name, "").upper()
        if not value:
            self.fail(card.place, f"*{card.keyword} needs {name}=NAME")
        return value

    # ---- What the cards say

    def read(self):
        for card in self.cards(pathlib.Path(self.raw.path)):
            getattr(self, "read_" + card.keyword.lower().replace(" ", "_"), self.read_other)(card)
        if self.inside:
            fail(self.raw.path, f"ends without *END {self.inside}")

    def read_other(self, card):
        if card.keyword in GENERATORS:
            self.fail(card.place, f"*{card.keyword} is not read: write the deck with all its nodes and elements listed, in "
                                  "global Cartesian axes")
        if card.keyword.endswith(" SECTION"):
            self.fail(card.place, f"*{card.keyword}: only *SOLID SECTION is allowed, as for all of {', '.join(TYPES)}")
        self.unused.setdefault(card.keyword, card.place)

    def read_heading(self, card):
        pass

    def read_part(self, card):
        name = self.needed(card, "NAME")
        if self.inside or name in self.parts:
            self.fail(card.place, f"part {name} " + (f"within a {self.inside.lower()}" if self.inside else "is there already"))
        self.inside, self.scope = "PART", Scope(name)
        self.parts[name] = self.scope

    def read_end_part(self, card):
        self.leave(card, "PART", None)

    def leave(self, card, what, outer):
        if self.inside != what:
            self.fail(card.place, f"*END {what} without *{what}")
        self.inside, self.scope = outer, self.top

    def read_assembly(self, card):
        if self.inside:
            self.fail(card.place, f"*ASSEMBLY within a {self.inside.lower()}: *END {self.inside} is missing")
        self.inside = "ASSEMBLY"

    def read_end_assembly(self, card):
        self.leave(card, "ASSEMBLY", None)

    def read_instance(self, card):
        name = self.needed(card, "NAME")
        if self.inside != "ASSEMBLY" or name in self.instances:
            self.fail(card.place, f"instance {name} " + ("is there already" if name in self.instances else "outside an *ASSEMBLY"))
        if "LIBRARY" in card.parameters:
            self.fail(card.place, f"instance {name} is imported from another job (LIBRARY): write its mesh into the deck")
        part = self.needed(card, "PART")
        if part not in self.parts:
            self.fail(card.place, f"instance {name}: there is no part {part} above")
        self.inside, self.scope = "INSTANCE", Scope(name, self.parts[part])
        self.instances[name] = self.scope
        rows = []
        for (place, text), count in zip(card.data, (3, 7)):
            values = [self.number(place, f, "a translation or rotation") for f in self.fields(text)]
            values += [0.0] * (3 - len(values) if count == 3 else 0)
            if len(values) != count:
                self.fail(place, f"{len(values)} numbers: expected " +
                          ("the three of a translation" if count == 3 else "seven: two points of the axis and degrees"))
            rows.append((place, np.array(values)))
        if len(card.data) > 2:
            self.fail(card.data[2][0], "expected at most two lines: translation and rotation")
        self.scope.move = rows

    def read_end_instance(self, card):
        self.leave(card, "INSTANCE", "ASSEMBLY")

    def read_node(self, card):
        system = card.parameters.get("SYSTEM", "R").upper()
        if system not in ("R", ""):
            self.fail(card.place, f"*NODE, SYSTEM={system}: only R, global Cartesian axes, is allowed")
        name = card.parameters.get("NSET", "").upper()
        for place, text in card.data:
            fields = self.fields(text)
            if len(fields) not in (4, 7):  # else, perhaps, decimal commas
                self.fail(place, f"{files.shown(text)}: expected a node: label, x, y, z, and a normal or nothing")
            label = self.whole(place, fields[0], "a node's label")
            new = (*(self.number(place, f, "a coordinate of node " + fields[0]) for f in fields[1:4]), place)
            old = self.scope.nodes.get(label)
            if old and old[:3] != new[:3]:
                self.fail(place, f"node {label} is there already, in line {self.where(old[3])}, at another place")
            self.scope.nodes[label] = new
            if name:
                self.scope.sets["NSET"].setdefault(name, []).append((place, [label], None))

    def read_element(self, card):
        given = self.needed(card, "TYPE")
        kind = TYPES.get(given)
        if not kind:
            self.fail(card.place, f"*ELEMENT, TYPE={given}: is no element that can be computed; allowed are " +
                      ", ".join(TYPES))
        name, rows = card.parameters.get("ELSET", "").upper(), iter(card.data)
        for place, text in rows:
            fields = self.fields(text)
            while len(fields) <= NODES[kind]:
                go_on, more = next(rows, (place, None))
                if more is None:
                    self.fail(place, f"element {fields[0]}: {len(fields) - 1} nodes, expected the {NODES[kind]} of a {given}")
                fields += self.fields(more)
            label = self.whole(place, fields[0], "an element's label")
            if len(fields) != NODES[kind] + 1:
                self.fail(place, f"element {label}: {len(fields) - 1} nodes, expected the {NODES[kind]} of a {given}")
            if label in self.scope.elements:
                self.fail(place, f"element {label} is there already, in line {self.where(self.scope.elements[label][2])}")
            nodes = [self.whole(place, f, f"a node of element {label}") for f in fields[1:]]
            self.scope.elements[label] = (kind, nodes, place)
            self.scope.sets["ELSET"].setdefault(name, []).append((place, [label], None))

    def read_set(self, card):
        name, instance = self.needed(card, card.keyword), card.parameters.get("INSTANCE", "").upper()
        if instance and instance not in self.instances:
            self.fail(card.place, f"*{card.keyword}, INSTANCE={instance}: there is no such instance")
        rows = self.scope.sets[card.keyword].setdefault(name, [])
        if card.keyword == "NSET" and "ELSET" in card.parameters:
            rows.append((card.place, ["ELSET", card.parameters["ELSET"].upper()], instance))
        for place, text in card.data:
            fields = self.fields(text)
            if "GENERATE" not in card.parameters:
                rows.append((place, [int(f) if f.isascii() and f.isdigit() else f.upper() for f in fields if f], instance))
                continue
            if not 2 <= len(fields) <= 3:
                self.fail(place, f"{files.shown(text)}: expected first, last and step of GENERATE")
            first, last, *step = (self.whole(place, f, "first, last and step of GENERATE") for f in fields)
            if last < first or (last - first) % (step or [1])[0]:
                self.fail(place, f"{files.shown(text)}: last - first must be a multiple of the step, and not negative")
            rows.append((place, range(first, last + 1, (step or [1])[0]), instance))

    read_nset = read_elset = read_set

    def read_surface(self, card):
        name, kind = self.needed(card, "NAME"), card.parameters.get("TYPE", "ELEMENT").upper()
        if kind not in ("ELEMENT", "NODE") or "COMBINE" in card.parameters:
            self.fail(card.place, f"*SURFACE, NAME={name}: only TYPE=ELEMENT and TYPE=NODE are read, not " +
                      ("COMBINE" if "COMBINE" in card.parameters else f"TYPE={kind}"))
        for place, text in card.data:
            fields = [f.upper() for f in self.fields(text)]
            if kind == "NODE":
                member = int(fields[0]) if fields[0].isdigit() else fields[0]
                self.scope.sets["NSET"].setdefault(name, []).append((place, [member], None))
            else:
                self.scope.sets["SURFACE"].setdefault(name, []).append((place, (fields + [""])[:2], None))

    def read_solid_section(self, card):
        orientation = card.parameters.get("ORIENTATION", "").upper()
        self.scope.sections.append((self.needed(card, "ELSET"), card.parameters.get("MATERIAL", "").upper(), orientation, card.place))
        if orientation and not self.fibre:
            self.raw.notes.append(f"{self.where(card.place)}: ORIENTATION of *SOLID SECTION is not used: --fibre 1 (2, 3) takes its "
                                  "local axis as the fibre")
        if "COMPOSITE" in card.parameters:
            self.raw.notes.append(f"{self.where(card.place)}: COMPOSITE of *SOLID SECTION is not used")

    def read_axes(self, card):
        name = self.needed(card, "NAME")
        if name in self.scope.axes[card.keyword]:
            self.fail(card.place, f"*{card.keyword}, NAME={name} is there already")
        self.scope.axes[card.keyword][name] = card
        if not self.fibre:
            self.unused.setdefault(card.keyword, card.place)

    read_orientation = read_distribution = read_axes

    def read_distribution_table(self, card):
        pass  # what its columns are, *ORIENTATION says as well

    # ---- Fibres by *ORIENTATION

    def axes(self, kind, scope, name, place):
        for where in (scope, self.top):
            if name in where.axes[kind]:
                return where.axes[kind][name]
        self.fail(place, f"there is no *{kind}, NAME={name}")

    def basis(self, place, values, turn):
        """(3, 3) local axes, a row each: the first to point a, the second to the side of b, from c; turned by `turn`,
        (axis, degrees)."""
        a, b, c = (np.array([*values, 0., 0., 0.][k:k + 3]) for k in (0, 3, 6))
        normal = np.cross(a - c, b - c)
        if not np.linalg.norm(normal) > 1e-12 * np.linalg.norm(a - c) * np.linalg.norm(b - c):
            self.fail(place, "the points a and b of the local axes must not lie on one line with the origin")
        e1, e3 = (v / np.linalg.norm(v) for v in (a - c, normal))
        axes = np.array([e1, np.cross(e3, e1), e3])
        i, j = turn[0] % 3, (turn[0] + 1) % 3  # the other two
        x, y = math.cos(math.radians(turn[1])), math.sin(math.radians(turn[1]))
        axes[[i, j]] = x * axes[i] + y * axes[j], x * axes[j] - y * axes[i]
        return axes

    def oriented(self, scope, name, place, cells):
        """{cell: fibre} of a section's cells by its *ORIENTATION."""
        card = self.axes("ORIENTATION", scope, name, place)
        for parameter, allowed in (("SYSTEM", ("RECTANGULAR", "R")), ("DEFINITION", ("COORDINATES",)), ("LOCALDIRECTIONS", ("0",))):
            given = card.parameters.get(parameter, allowed[0]).upper()
            if given not in allowed:
                self.fail(card.place, f"*ORIENTATION, NAME={name}, {parameter}={given}: only {allowed[0]} is read")
        if not 1 <= len(card.data) <= 2:
            self.fail(card.place, f"*ORIENTATION, NAME={name}: expected one or two lines of data")
        turn = (1, 0.)
        if len(card.data) == 2:
            row, text = card.data[1]
            axis, angle = (self.fields(text) + ["", ""])[:2]
            turn = (self.whole(row, axis or "1", "the axis of a rotation"), self.number(row, angle, "degrees of a rotation"))
            if turn[0] > 3:
                self.fail(row, f"axis {turn[0]} of a rotation: expected 1, 2 or 3")
        row, text = card.data[0]
        given = self.fields(text)
        if len(given) == 1:
            values = self.distributed(scope, given[0].upper(), row, cells)
        else:
            values = dict.fromkeys(cells, (row, self.points_of_axes(row, given)))
        made = {}  # rows that many cells share are worked out once
        for c, (row, numbers) in values.items():
            if (row, turn) not in made:
                made[row, turn] = self.rotated(scope, self.basis(row, numbers, turn)[self.fibre - 1:self.fibre])[0]
            values[c] = made[row, turn]
        return values

    def points_of_axes(self, row, given):
        if len(given) not in (6, 9):
            self.fail(row, f"{len(given)} numbers: expected six, of the points a and b of the local axes, or nine")
        return [self.number(row, f, "a coordinate of the local axes") for f in given]

    def distributed(self, scope, name, place, cells):
        """{cell: (place, numbers)} by a *DISTRIBUTION."""
        card = self.axes("DISTRIBUTION", scope, name, place)
        where = card.parameters.get("LOCATION", "").upper()
        if where != "ELEMENT":
            self.fail(card.place, f"*DISTRIBUTION, NAME={name}, LOCATION={where or 'nothing'}: only ELEMENT is read")
        found, default = {}, None  # of two rows for an element the last one holds, as in Abaqus
        for row, text in card.data:
            who, *given = self.fields(text)
            value = (row, self.points_of_axes(row, given))
            if not who:
                if default:
                    self.fail(row, f"*DISTRIBUTION, NAME={name}: has a default already, {self.where(default[0])}")
                default = value
            elif who.isascii() and who.isdigit():
                found[self.one("ELSET", scope, int(who), row, f"distribution {name}")] = value
            else:
                found.update(dict.fromkeys(self.members("ELSET", scope, who.upper(), row), value))
        missing = [self.raw.cells[c].label for c in cells if c not in found]
        if missing and not default:
            self.fail(card.place, f"*DISTRIBUTION, NAME={name}: has no row for elements {some(missing)}, and no default")
        return {c: found.get(c, default) for c in cells}

    # ---- One mesh of it

    def members(self, kind, scope, name, place, chain=()):
        """Indices of a set's nodes or cells; or (corners) of a surface's facets."""
        if (scope.name, name) in chain:
            self.fail(place, f"set {name} contains itself")
        own, _, rest = name.partition(".")
        if name not in scope.sets[kind] and rest and scope is self.top and own in self.instances:
            return self.members(kind, self.instances[own], rest, place, chain)
        if name not in scope.sets[kind]:
            there = some(sorted(n for n in scope.sets[kind] if n)) or "none"
            self.fail(place, f"there is no {kind} {name}" + (f" in {scope.name}" if scope.name else "") + f"; there are: {there}")
        found = []
        for row, entries, instance in scope.sets[kind][name]:
            within = self.instances[instance] if instance else scope
            if kind == "SURFACE":
                found += self.faces(within, row, *entries, name)
            elif len(entries) == 2 and entries[0] == "ELSET" and kind == "NSET":
                cells = self.members("ELSET", within, entries[1], row)
                found += [n for c in cells for n in self.raw.cells[c].nodes]
            else:
                for entry in entries:
                    if isinstance(entry, int):
                        found.append(self.one(kind, within, entry, row, name))
                    elif re.fullmatch(r".+\.\d+", entry) and entry.rpartition(".")[0] in self.instances:
                        own, _, label = entry.rpartition(".")
                        found.append(self.one(kind, self.instances[own], int(label), row, name))
                    else:
                        found += self.members(kind, within, entry, row, (*chain, (scope.name, name)))
        return list(dict.fromkeys(found))

    def one(self, kind, scope, label, place, name):
        index = (scope.node_index if kind == "NSET" else scope.cell_index).get(label)
        if index is None:
            what = "node" if kind == "NSET" else "element"
            self.fail(place, f"{what} {label}, in set {name}, is not there" + (f" in {scope.name}" if scope.name else ""))
        return index

    def faces(self, scope, place, who, face, name):
        if re.fullmatch(r"\d+", who):
            cells = [self.one("ELSET", scope, int(who), place, name)]
        elif re.fullmatch(r".+\.\d+", who) and who.rpartition(".")[0] in self.instances:
            own, _, label = who.rpartition(".")
            cells = [self.one("ELSET", self.instances[own], int(label), place, name)]
        else:
            cells = self.members("ELSET", scope, who, place)
        facets = []
        for c in cells:
            cell = self.raw.cells[c]
            faces = FACES[cell.kind]
            if not face:  # all its faces on the mesh's surface
                facets += [f for f in (tuple(cell.nodes[k] for k in corners) for corners in faces)
                           if self.count_faces()[tuple(sorted(f))] == 1]
                continue
            number = int(face[1:]) if re.fullmatch(r"S[1-9]", face) else 0
            if not 1 <= number <= len(faces):
                self.fail(place, f"surface {name}, element {cell.label}: face {files.shown(face)}: expected S1 to S{len(faces)}")
            facets.append(tuple(cell.nodes[k] for k in faces[number - 1]))
        return facets

    def count_faces(self):
        if not hasattr(self, "_faces"):
            self._faces = {}
            for cell in self.raw.cells:
                for corners in FACES[cell.kind]:
                    key = tuple(sorted(cell.nodes[k] for k in corners))
                    self._faces[key] = self._faces.get(key, 0) + 1
        return self._faces

    def moved(self, scope):
        """The coordinates of an instance: translated, then turned about the axis."""
        X = np.array([n[:3] for n in scope.nodes.values()]).reshape(-1, 3)
        rows = scope.move or []
        if rows:
            X = X + rows[0][1]
        if len(rows) > 1:
            place, v = rows[1]
            a, axis = v[:3], v[3:6] - v[:3]
            if not np.linalg.norm(axis) > 0:
                self.fail(place, f"instance {scope.name}: the two points of its axis are one")
            X = a + self.rotated(scope, X - a)
        return X

    def rotated(self, scope, d):
        """Vectors of an instance, turned as it is."""
        rows = scope.move or []
        if len(rows) < 2:
            return d
        v = rows[1][1]
        n, angle = (v[3:6] - v[:3]) / np.linalg.norm(v[3:6] - v[:3]), math.radians(v[6])
        return d * math.cos(angle) + np.cross(n, d) * math.sin(angle) + np.outer(d @ n, n) * (1 - math.cos(angle))

    def assemble(self):
        raw, scopes = self.raw, list(self.instances.values())
        if not scopes and self.parts:
            fail(raw.path, f"has parts ({some(self.parts)}) but no *INSTANCE of one in an *ASSEMBLY")
        if scopes and self.top.elements:
            self.fail(next(iter(self.top.elements.values()))[2], "elements outside the parts of a deck with an *ASSEMBLY")
        scopes = [s for s in scopes] + [self.top]
        # Nodes of the assembly are reference points, of no element; their labels are marked as such by their sign.
        points = [self.top] if self.instances else []
        labels = [label for s in scopes if s not in points for label in s.nodes], [label for s in scopes for label in s.elements]
        again = [len(set(group)) < len(group) for group in labels]
        for what, renumber in zip(("nodes", "elements"), again):
            if renumber:
                raw.notes.append(f"{what} of several instances have the same labels: they are numbered anew, from 1, in the "
                                 "order of the instances")
        for scope in scopes:
            for (label, node), x in zip(scope.nodes.items(), self.moved(scope)):
                scope.node_index[label] = len(raw.nodes)
                raw.node_labels.append(-label if scope in points else len(raw.nodes) + 1 if again[0] else label)
                raw.node_places.append(node[3])
                raw.nodes.append(tuple(x))
            for label, (kind, nodes, place) in scope.elements.items():
                missing = [n for n in nodes if n not in scope.node_index]
                if missing:
                    self.fail(place, f"element {label}: node {missing[0]} is not there")
                scope.cell_index[label] = len(raw.cells)
                raw.cells.append(Cell(kind, len(raw.cells) + 1 if again[1] else label,
                                      [scope.node_index[n] for n in nodes], place))
        if not raw.cells:
            fail(raw.path, "has no elements")
        self.name_sets(scopes)
        self.name_sections(scopes)
        joints = [name for name in JOINTS if name in self.unused]
        if joints:
            raw.notes.append("WARNING: these cards join or hold what the mesh itself does not, and are not used: " + ", ".join(
                f"*{name} ({self.where(self.unused[name])})" for name in joints))
        rest = [name for name in self.unused if name not in joints and not name.startswith("END")]
        if rest:
            raw.notes.append("cards that are not used: " + ", ".join("*" + name for name in rest))
        return raw

    def name_sets(self, scopes):
        tables = {"NSET": self.raw.nsets, "ELSET": self.raw.elsets, "SURFACE": self.raw.surfaces}
        for kind, table in tables.items():
            used = {}
            for scope in scopes:
                for name in scope.sets[kind]:
                    used.setdefault(name, []).append(scope)
            for name, owners in used.items():
                if not name:
                    continue
                for scope in owners:
                    alone = len(owners) == 1 or scope is self.top
                    place = scope.sets[kind][name][0][0] if scope.sets[kind][name] else (0, 0)
                    table[name if alone else f"{scope.name}.{name}"] = self.members(kind, scope, name, place)

    def name_sections(self, scopes):
        """The section of every cell: that of *SOLID SECTION. Without such cards, left to the sets."""
        if not any(scope.sections for scope in scopes):
            if self.fibre:
                fail(self.raw.path, "--fibre: no *SOLID SECTION, and so no ORIENTATION")
            return
        of, materials, fibres = {}, {}, {}
        for scope in scopes:
            for name, material, orientation, place in scope.sections:
                section = material if GENERATED_NAME.fullmatch(name) and material else name
                if materials.setdefault(section, material) != material:
                    section = f"{scope.name}.{section}" if scope.name else f"{section}.{material}"
                cells = self.members("ELSET", scope, name, place)
                for c in cells:
                    if c in of and of[c] != section:
                        self.fail(place, f"element {self.raw.cells[c].label} has a section already, {of[c]}")
                    of[c] = section
                for c, fibre in (self.oriented(scope, orientation, place, cells) if self.fibre and orientation else {}).items():
                    if not np.array_equal(fibres.setdefault(c, fibre), fibre):
                        self.fail(place, f"element {self.raw.cells[c].label} has another ORIENTATION already, of another *SOLID SECTION")
        every = range(len(self.raw.cells))
        for table, what in ((of, "a *SOLID SECTION"), *([(fibres, "an ORIENTATION, which --fibre needs")] if self.fibre else [])):
            without = [self.raw.cells[c].label for c in every if c not in table]
            if without:
                fail(self.raw.path, f"elements without {what}: {some(without)}")
        self.raw.sections = [of[c] for c in every]
        if self.fibre:
            self.raw.fibres, self.raw.fibres_from = [fibres[c] for c in every], f"*ORIENTATION, axis {self.fibre}"


def read(path, fibre=None):
    """The Raw of a deck. `fibre`: 1, 2 or 3, the local axis of *ORIENTATION that is the fibre."""
    deck = Deck(path, fibre)
    deck.read()
    return deck.assemble()
