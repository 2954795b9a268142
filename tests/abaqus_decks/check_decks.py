"""The examples for Abaqus, which we cannot run: checks the decks by the rules that need no Abaqus, and tests the tools.

check_decks.py SOURCE DRIVER FORTRAN_COMPILER [unittest arguments]

The rules are Abaqus's input syntax, the UMAT's tables in docs/manual.md, and the geometry of the elements. Every rule is
broken once, in Spoiled, to show that it can be.
"""
import csv
import importlib
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv[1]).resolve()
DRIVER, COMPILER = sys.argv[2:4]
EXAMPLES = SOURCE / "examples" / "abaqus"
sys.dont_write_bytecode = True
sys.path.insert(0, str(EXAMPLES))
expected, make_cylinder = importlib.import_module("expected"), importlib.import_module("make_cylinder")

# Keywords that our decks use, and the parameters that they may have.
KNOWN = {
    "HEADING": "", "NODE": "NSET", "ELEMENT": "TYPE ELSET", "NSET": "NSET GENERATE", "ELSET": "ELSET GENERATE",
    "SOLID SECTION": "ELSET MATERIAL", "SHELL SECTION": "ELSET MATERIAL POISSON", "TRANSVERSE SHEAR STIFFNESS": "",
    "HOURGLASS STIFFNESS": "",
    "MATERIAL": "NAME", "DEPVAR": "", "USER MATERIAL": "CONSTANTS UNSYMM", "AMPLITUDE": "NAME TIME",
    "INITIAL CONDITIONS": "TYPE USER", "BOUNDARY": "AMPLITUDE", "STEP": "NAME NLGEOM UNSYMM INC", "STATIC": "",
    "OUTPUT": "FIELD HISTORY FREQUENCY", "ELEMENT OUTPUT": "ELSET", "NODE OUTPUT": "NSET",
    "EL PRINT": "ELSET FREQUENCY", "NODE PRINT": "NSET FREQUENCY SUMMARY TOTALS", "END STEP": "",
}
IN_STEP = {"STATIC", "OUTPUT", "ELEMENT OUTPUT", "NODE OUTPUT", "EL PRINT", "NODE PRINT", "END STEP"}

# State variables that the UMAT keeps in an element, and its last degree of freedom.
DEPVAR = {"C3D8": 8, "C3D6": 8, "CPE4": 8, "CAX4": 8, "S4": 9}
LAST_DOF = {"C3D8": 3, "C3D6": 3, "CPE4": 2, "CAX4": 2, "S4": 6}

# The three edges at each corner of a solid, right-handed unless it is inverted; and its faces.
EDGES = {
    "C3D8": [(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)],
    "C3D6": [(1, 2, 3), (2, 0, 4), (0, 1, 5), (5, 4, 0), (3, 5, 1), (4, 3, 2)],
}
FACES = {
    "C3D8": [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
    "C3D6": [(0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
}
TETRAHEDRA = {
    "C3D8": [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)],
    "C3D6": [(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)],
}
CORNERS = {"C3D8": 8, "C3D6": 6, "CPE4": 4, "CAX4": 4, "S4": 4}


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def dot(u, v):
    return sum(x * y for x, y in zip(u, v))


def triple(u, v, w):
    return dot(cross(u, v), w)


def is_inside_out(kind, x):
    """Whether the Jacobian of an element with corners x is not positive at all of them."""
    if kind in EDGES:
        return any(triple(*(minus(x[i], x[c]) for i in edges)) <= 0 for c, edges in enumerate(EDGES[kind]))
    normals = [cross(minus(x[(i + 1) % 4], x[i]), minus(x[i - 1], x[i])) for i in range(4)]
    if kind == "S4":  # either orientation is allowed
        return any(dot(n, normals[0]) <= 0 for n in normals)
    return any(n[2] <= 0 for n in normals) or (kind == "CAX4" and any(p[0] < 0 for p in x))


def volume(kind, x):
    return sum(abs(triple(*(minus(x[i], x[t[0]]) for i in t[1:]))) / 6 for t in TETRAHEDRA[kind])


def table(name):
    """Rows of the manual's table of PROPS or STATEV; docs.manual_tables compares the manual with the code."""
    lines = (SOURCE / "docs" / "manual.md").read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {name} |")) + 2
    rows = []
    for line in lines[start:]:
        if not line.startswith("|"):
            return rows
        rows.append([cell.strip().strip("`") for cell in line.strip("|").split("|")])
    return rows


PROPS, STATEV = table("PROPS"), table("STATEV")


def is_allowed(rule, x, c2):
    """What the table says in words: '> 0', '0 or 1', 'finite', or the bound of c1."""
    if not math.isfinite(x):
        return False
    if rule.startswith("> -2/3 c2"):
        return x > -2 / 3 * c2
    if rule == "finite":
        return True
    bound = re.fullmatch(r"(>=?) (\S+)", rule)
    if bound:
        return x > float(bound[2]) or (bound[1] == ">=" and x == float(bound[2]))
    return x in [float(word) for word in re.split(r", | or ", rule)]


class Keyword:
    def __init__(self, line, number):
        name, *parameters = [part.strip() for part in line[1:].split(",")]
        self.name, self.number, self.data = " ".join(name.upper().split()), number, []
        self.parameters = {}
        for part in filter(None, parameters):
            key, _, value = part.partition("=")
            self.parameters[" ".join(key.upper().split())] = value.strip().upper()

    def __getitem__(self, key):
        return self.parameters.get(key)

    def fields(self):
        """The data lines, split at the commas; a comma at the end of a line does not begin another field."""
        for line in self.data:
            row = [field.strip() for field in next(csv.reader([line], skipinitialspace=True))]
            yield row[:-1] if len(row) > 1 and not row[-1] else row

    def numbers(self):
        return [[float(field) for field in row] for row in self.fields()]


def keywords(text):
    result, open_line = [], None
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("**"):
            continue
        if open_line is not None or line.startswith("*"):
            line = (open_line or "") + line.strip()
            open_line = line if line.endswith(",") else None  # continues on the next line
            if open_line is None:
                result.append(Keyword(line, number))
        elif result:
            result[-1].data.append(line)
    return result


class Deck:
    """The contents of a deck, and `faults`: its errors."""

    def __init__(self, text):
        self.faults, self.nodes, self.elements = [], {}, {}
        self.sets = {"NSET": {}, "ELSET": {}}
        self.materials, self.sections, self.amplitudes, self.steps = {}, {}, {}, []
        self.keywords = keywords(text)
        for number, line in enumerate(text.splitlines(), 1):
            if len(line) > 256 or not line.isascii():
                self.faults.append(f"line {number}: longer than 256 characters, or not ASCII")
        inside, last_material = None, None
        for k in self.keywords:
            self.syntax(k)
            if k.name in IN_STEP and inside is None:
                self.fault(k, "outside a step")
            if k.name == "STEP":
                if inside:
                    self.fault(inside, "is not ended")
                inside = k
                self.steps.append(k)
            elif k.name == "END STEP":
                inside = None
            elif k.name == "MATERIAL":
                last_material = self.materials[k["NAME"]] = {"keyword": k}
            elif k.name in ("DEPVAR", "USER MATERIAL"):
                last_material[k.name] = k
            try:
                self.read(k)
            except (ValueError, IndexError, KeyError, AttributeError) as error:
                self.fault(k, f"cannot be read: {error!r}")
        if inside:
            self.fault(inside, "is not ended")
        for k in self.keywords:  # everything is defined: now check what is used
            try:
                self.check(k)
            except (ValueError, IndexError, KeyError, TypeError) as error:
                self.fault(k, f"cannot be checked: {error!r}")
        self.check_whole()

    def fault(self, k, text):
        self.faults.append(f"line {k.number}: *{k.name} {text}")

    def syntax(self, k):
        if k.name not in KNOWN:
            self.fault(k, "is not a keyword we know")
        for p in set(k.parameters) - set(re.findall(r"\S+", KNOWN.get(k.name, ""))):
            self.fault(k, f"has no parameter {p}")

    def read(self, k):
        if k.name == "NODE":
            rows = k.numbers()
            self.nodes.update({int(r[0]): (r[1:] + [0.0, 0.0])[:3] for r in rows})
            self.add("NSET", k["NSET"], [int(r[0]) for r in rows])
        elif k.name == "ELEMENT":
            rows = [[int(f) for f in row] for row in k.fields()]
            for label, *corners in rows:
                if label in self.elements:
                    self.fault(k, f"{label} is there twice")
                self.elements[label] = (k["TYPE"], corners)
            self.add("ELSET", k["ELSET"], [r[0] for r in rows])
        elif k.name in ("NSET", "ELSET"):
            for row in k.fields():
                if "GENERATE" in k.parameters:
                    first, last, every = (int(f) for f in row)
                    self.add(k.name, k[k.name], range(first, last + 1, every))
                else:
                    for field in row:
                        self.add(k.name, k[k.name], self.members(k, k.name, field))
        elif k.name == "AMPLITUDE":
            flat = [x for row in k.numbers() for x in row]
            self.amplitudes[k["NAME"]] = (k, flat[::2])
        elif k.name in ("SOLID SECTION", "SHELL SECTION"):
            for label in self.members(k, "ELSET", k["ELSET"]):
                self.sections[label] = k

    def add(self, kind, name, labels):
        if name:
            self.sets[kind].setdefault(name, set()).update(labels)

    def members(self, k, kind, field):
        """Labels of a set, or of a single number."""
        if field.isdecimal():
            return {int(field)}
        if field.upper() not in self.sets[kind]:
            self.fault(k, f"uses the {kind.lower()} {field}, which is not there")
        return self.sets[kind].get(field.upper(), set())

    def check(self, k):
        for kind in ("NSET", "ELSET"):  # the labels in sets, and the sets in output requests
            there = self.nodes if kind == "NSET" else self.elements
            if k[kind]:
                missing = [label for label in self.members(k, kind, k[kind]) if label not in there]
                if missing:
                    self.fault(k, f"{kind} {k[kind]}: {missing[0]} is not there")
        if k.name == "BOUNDARY":
            kinds = {kind for kind, _ in self.elements.values()}
            last = max((LAST_DOF.get(kind, 0) for kind in kinds), default=0)
            for name, *numbers in k.fields():
                if not all(label in self.nodes for label in self.members(k, "NSET", name)):
                    self.fault(k, f"{name} is no node")
                dofs = [int(n) for n in numbers[:2]]
                if not dofs or not 1 <= dofs[0] <= dofs[-1] <= last:
                    self.fault(k, f"has no degrees of freedom {numbers[:2]}")
                if len(numbers) > 2 and not math.isfinite(float(numbers[2])):
                    self.fault(k, "has a value that is not finite")
            if k["AMPLITUDE"] and k["AMPLITUDE"] not in self.amplitudes:
                self.fault(k, f"uses the amplitude {k['AMPLITUDE']}, which is not there")
        elif k.name == "AMPLITUDE":
            self.check_amplitude(k)
        elif k.name == "STEP":
            for parameter in ("NLGEOM", "UNSYMM"):
                if k[parameter] not in ("YES",) + (("",) if parameter == "NLGEOM" else ()):
                    self.fault(k, f"needs {parameter}=YES")
        elif k.name == "USER MATERIAL":
            self.check_user_material(k)
        elif k.name == "INITIAL CONDITIONS":
            self.check_initial_conditions(k)
        elif k.name == "SOLID SECTION":
            self.check_hourglass(k, 1)
        elif k.name == "SHELL SECTION":
            self.check_hourglass(k, 2)
            if self.following(k).name != "TRANSVERSE SHEAR STIFFNESS" or len(self.following(k).numbers()[0]) != 3:
                self.fault(k, "with a UMAT needs three numbers of *TRANSVERSE SHEAR STIFFNESS")
            if k["POISSON"] and not -1 <= float(k["POISSON"]) <= 0.5:
                self.fault(k, "has a POISSON that is not between -1 and 0.5")

    def following(self, k):
        return self.keywords[self.keywords.index(k) + 1]

    def check_hourglass(self, k, at_most_after):
        """Reduced elements have modes without strain. Abaqus holds them by a share of the elastic modulus, which a UMAT does
        not tell it: the section must say how stiffly."""
        kinds = {self.elements[label][0] for label in self.members(k, "ELSET", k["ELSET"])}
        after = self.keywords[self.keywords.index(k) + 1:][:at_most_after]
        if any(kind.endswith("R") for kind in kinds):
            stiffness = [next(o.fields(), []) for o in after if o.name == "HOURGLASS STIFFNESS"]
            if not stiffness or not stiffness[0] or not float(stiffness[0][0]) > 0:
                self.fault(k, "of reduced elements with a UMAT needs *HOURGLASS STIFFNESS > 0")

    def check_amplitude(self, k):
        times = self.amplitudes[k["NAME"]][1]
        flat = [x for row in k.numbers() for x in row]
        if len(flat) % 2 or any(len(row) > 8 for row in k.fields()):
            self.fault(k, "needs pairs, at most four in a line")
        if any(b <= a for a, b in zip(times, times[1:])):
            self.fault(k, "needs times that increase")

    def check_user_material(self, k):
        rows = k.numbers()
        values = [x for row in rows for x in row]
        if "UNSYMM" not in k.parameters:
            self.fault(k, "needs UNSYMM")
        if int(k["CONSTANTS"] or 0) != len(values):
            self.fault(k, f"says {k['CONSTANTS']} CONSTANTS and gives {len(values)}")
        if any(len(row) != 8 for row in rows[:-1]) or len(rows[-1]) > 8:
            self.fault(k, "needs lines of eight")
        required = sum(row[-1] == "required" for row in PROPS)
        if not required <= len(values) <= len(PROPS):
            self.fault(k, f"needs {required} to {len(PROPS)} constants")
        for row, x in zip(PROPS, values):
            if not is_allowed(row[-2], x, values[1]):
                self.fault(k, f"has PROPS({row[0]}) = {x:g}: {row[1]} must be {row[-2]}")
        if len(values) >= 9 and not any(values[6:9]):
            self.fault(k, "has a fibre without length")

    def depvar(self, label):
        """How many state variables the material of an element has."""
        section = self.sections.get(label)
        material = self.materials.get(section["MATERIAL"], {}) if section else {}
        return int(next(material["DEPVAR"].fields())[0]) if "DEPVAR" in material else None

    def check_initial_conditions(self, k):
        if k["TYPE"] != "SOLUTION":
            self.fault(k, "is not of TYPE=SOLUTION")
        rows = list(k.fields())
        if "USER" in k.parameters and rows:
            self.fault(k, "with USER takes no data")
        while rows:
            first = rows.pop(0)
            label = int(first[0])
            if label not in self.elements:
                self.fault(k, f"element {label} is not there")
                return
            values, full = first[1:], 7
            while len(values) == full and rows and full < self.depvar(label):
                values += rows.pop(0)
                full += 8
            if len(first) > 8 or len(values) != self.depvar(label):
                self.fault(k, f"element {label} has {len(values)} values, not {self.depvar(label)}")
                return
            [float(v) for v in values]

    def check_whole(self):
        if not self.steps or not self.elements:
            self.faults.append("there is no step, or no element")
        for label, (kind, corners) in self.elements.items():
            if kind not in CORNERS or len(corners) != CORNERS[kind]:
                self.faults.append(f"element {label}: {kind} with {len(corners)} nodes")
            elif not all(node in self.nodes for node in corners):
                self.faults.append(f"element {label}: a node of it is not there")
            elif is_inside_out(kind, [self.nodes[node] for node in corners]):
                self.faults.append(f"element {label}: is inside out")
        self.check_materials()
        total = 0.0
        for step in self.steps:
            total += self.check_static(step)
        for k, times in self.amplitudes.values():
            if k["TIME"] == "TOTAL TIME" and times and abs(times[-1] - total) > 1e-9:
                self.fault(k, f"ends at {times[-1]:g}, the steps at {total:g}")

    def check_materials(self):
        needs = {}
        for label, (kind, _) in self.elements.items():
            section = self.sections.get(label)
            if section is None:
                self.faults.append(f"element {label}: has no section")
                return
            if (section.name == "SHELL SECTION") != (kind == "S4"):
                self.fault(section, f"is not for {kind}")
                return
            needs.setdefault((section["MATERIAL"], DEPVAR.get(kind)), label)
        for (name, need), label in needs.items():
            if name not in self.materials:
                self.faults.append(f"element {label}: its material {name} is not there")
                continue
            material = self.materials[name]
            if "DEPVAR" not in material or "USER MATERIAL" not in material:
                self.fault(material["keyword"], "needs *DEPVAR and *USER MATERIAL")
                continue
            depvar = material["DEPVAR"]
            rows = list(depvar.fields())
            if int(rows[0][0]) != need:
                self.fault(depvar, f"is {rows[0][0]}: the UMAT needs {need} in element {label}")
            if [row[0] for row in rows[1:]] != [str(i + 1) for i in range(int(rows[0][0]))]:
                self.fault(depvar, "does not name its variables one after the other")
            for row, (_, symbol, *_) in zip(rows[1:], STATEV):
                if len(row) != 3 or row[1] != symbol.upper():
                    self.fault(depvar, f"calls {symbol} {row[1:]}")

    def check_static(self, step):
        """Checks the increments of a step and gives its time."""
        start = self.keywords.index(step)
        inside = []
        for k in self.keywords[start + 1 :]:
            inside.append(k)
            if k.name == "END STEP":
                break
        static = [k for k in inside if k.name == "STATIC"]
        if len(static) != 1:
            self.fault(step, "needs one *STATIC")
            return 0.0
        rows = static[0].numbers()
        if len(rows) != 1 or len(rows[0]) != 4:
            self.fault(static[0], "needs 4 numbers")
            return 0.0
        first, total, least, longest = rows[0]
        if not 0 < least <= first <= longest <= total:
            self.fault(static[0], "needs least <= first <= longest <= total increment")
        if int(step["INC"] or 100) < total / first:
            self.fault(step, "has too small an INC for its first increment")
        if not {"ELEMENT OUTPUT", "NODE OUTPUT"} <= {k.name for k in inside}:
            self.fault(step, "asks for no output")
        return total


def example(name):
    return (EXAMPLES / name).read_text(encoding="ascii")


class Decks(unittest.TestCase):
    def test_every_deck_keeps_the_rules(self):
        decks = sorted(EXAMPLES.glob("*.inp"))
        self.assertEqual({d.name for d in decks}, set(expected.DECKS))
        for path in decks:
            with self.subTest(path.name):
                deck = Deck(example(path.name))
                self.assertEqual(deck.faults, [])
                self.assertEqual(len(deck.steps), 2)
                self.assertIn("Never run in Abaqus", path.read_text())

    def test_the_parser_reads_what_abaqus_reads(self):
        text = example("cube_c3d8.inp")
        loose = text.replace("*USER MATERIAL, CONSTANTS=9, UNSYMM", "*User  Material,\n  constants = 9,\n unsymm")
        self.assertNotEqual(loose, text)
        self.assertEqual(Deck(loose.replace("X0", "x0").replace("*NODE,", "*node ,")).faults, [])

    def test_a_fibre_field_in_a_deck(self):
        block = "*INITIAL CONDITIONS, TYPE=SOLUTION\n1, 0., 0., 0., 0., 0., 1., 0.\n0.\n"
        for user in (block, "*INITIAL CONDITIONS, TYPE=SOLUTION, USER\n"):
            self.assertEqual(Deck(example("cube_c3d8.inp").replace("*AMPLITUDE", user + "*AMPLITUDE", 1)).faults, [])


class Spoiled(unittest.TestCase):
    """Each rule, broken: the checker must report it."""

    def spoil(self, old, new, words, deck="cube_c3d8.inp", count=1):
        text = example(deck)
        self.assertIn(old, text)
        faults = Deck(text.replace(old, new, count)).faults
        self.assertTrue(any(words in fault for fault in faults), f"{old!r} -> {new!r}: {faults}")

    def test_keywords_and_lines(self):
        self.spoil("*STATIC", "*STATICS", "is not a keyword")
        self.spoil("*NODE,", "*NODES,", "is not a keyword")
        self.spoil("NLGEOM=YES", "NLGEOMETRY=YES", "has no parameter NLGEOMETRY")
        self.spoil("muscle cube", "muscle\u00a0cube", "not ASCII")
        self.spoil("muscle cube", "muscle" * 60, "256 characters")
        self.spoil("*STEP, NAME=RAMP", "*OUTPUT, FIELD\n*STEP, NAME=RAMP", "outside a step")
        self.spoil("2, 1., 0., 0.", "2, 1., O., 0.", "cannot be read")

    def test_constants(self):
        self.spoil("CONSTANTS=9", "CONSTANTS=8", "says 8 CONSTANTS and gives 9")
        self.spoil("\n0.\n*AMPLITUDE", "\n*AMPLITUDE", "says 9 CONSTANTS and gives 8")
        self.spoil("1., 0.,\n0.", "1.,\n0., 0.", "lines of eight")
        self.spoil("1., 0.,\n0.\n", "1., 0.,\n" + 8 * "0., " + "\n0., 0., 0.\n", "constants")
        self.spoil("1.01, 1.,", "1.01, 0.,", "fibre without length")
        self.spoil("16., 4.", "-3., 4.", "PROPS(1) = -3: c1")
        self.spoil("16., 4.", "16., 0.", "PROPS(2) = 0: c2")
        self.spoil("4., 0.5", "4., 0.", "PROPS(3) = 0: tau")
        self.spoil("0.5, 2.", "0.5, -2.", "PROPS(4) = -2: gamma")
        self.spoil("2., 1.1,", "2., 1.0,", "PROPS(5) = 1: G_max")
        self.spoil("1.1, 1.01", "1.1, nan", "PROPS(6) = nan: lambda_crit")
        self.spoil("0., 1.\n*AMP", "0., 2.\n*AMP", "PROPS(10) = 2: frame", deck="shell_s4.inp")

    def test_hourglass_stiffness(self):
        words = "of reduced elements with a UMAT needs *HOURGLASS STIFFNESS > 0"
        section = "*SOLID SECTION, ELSET=MUSCLE, MATERIAL=MUSCLE\n"
        reduced = example("cube_c3d8.inp").replace("TYPE=C3D8", "TYPE=C3D8R")
        for given, right in (("", False), ("*HOURGLASS STIFFNESS\n0.\n", False), ("*HOURGLASS STIFFNESS\n", False),
                             ("*HOURGLASS STIFFNESS\n0.02\n", True)):
            faults = Deck(reduced.replace(section, section + given)).faults
            self.assertNotEqual(any(words in fault for fault in faults), right, faults)

    def test_unsymmetric(self):
        self.spoil("CONSTANTS=9, UNSYMM", "CONSTANTS=9", "needs UNSYMM")
        for step in ("RAMP", "HOLD"):
            self.spoil(f"{step}, NLGEOM=YES, UNSYMM=YES", f"{step}, NLGEOM=YES", "needs UNSYMM=YES")

    def test_nlgeom(self):
        for step in ("RAMP", "HOLD"):
            self.spoil(f"{step}, NLGEOM=YES", step, "needs NLGEOM=YES")
            self.spoil(f"{step}, NLGEOM=YES", f"{step}, NLGEOM=NO", "needs NLGEOM=YES")

    def test_depvar(self):
        self.spoil("*DEPVAR\n8", "*DEPVAR\n7", "the UMAT needs 8")
        self.spoil("*DEPVAR\n9", "*DEPVAR\n8", "the UMAT needs 9", deck="shell_s4.inp")
        self.spoil("\n2, LAMBDA_E", "\n3, LAMBDA_E", "one after the other")
        self.spoil("LAMBDA_E,", "LAMBDA,", "calls lambda_e")
        self.spoil("*DEPVAR\n8", "**", "needs *DEPVAR")

    def test_what_is_used_exists(self):
        self.spoil("1, 1, 2, 3, 4, 5, 6, 7, 8", "1, 1, 2, 3, 4, 5, 6, 7, 9", "a node of it is not there")
        self.spoil("1, 1, 2, 3, 4, 5, 6, 7, 8", "1, 1, 2, 3, 4, 5, 6, 7", "C3D8 with 7 nodes")
        self.spoil("2, 3, 6, 7", "2, 3, 6, 70", "70 is not there")
        self.spoil("X0, 1\n", "X1, 1\n", "uses the nset X1")
        self.spoil("X0, 1\n", "99, 1\n", "99 is no node")
        self.spoil("X0, 1\n", "X0, 4\n", "no degrees of freedom")
        self.spoil("NODE OUTPUT, NSET=PULLED", "NODE OUTPUT, NSET=PULL", "uses the nset PULL")
        self.spoil("EL PRINT, ELSET=MUSCLE", "EL PRINT, ELSET=MUSCLES", "uses the elset MUSCLES")
        self.spoil("SECTION, ELSET=MUSCLE", "SECTION, ELSET=TENDON", "has no section")
        self.spoil("MATERIAL=MUSCLE", "MATERIAL=TENDON", "its material TENDON is not there")
        self.spoil("AMPLITUDE=PULL", "AMPLITUDE=PUSH", "uses the amplitude PUSH")
        self.spoil("SHELL SECTION, ELSET=MUSCLE, MATERIAL=MUSCLE, POISSON=0.", "SOLID SECTION, ELSET=MUSCLE, MATERIAL=MUSCLE",
                   "is not for S4", deck="shell_s4.inp")
        self.spoil("*TRANSVERSE SHEAR STIFFNESS\n3.333333, 3.333333, 0.\n", "", "TRANSVERSE SHEAR", deck="shell_s4.inp")
        self.spoil("POISSON=0.", "POISSON=0.6", "POISSON", deck="shell_s4.inp")

    def test_amplitude(self):
        self.spoil("0., 0., 1., 1., 42., 1.", "0., 0., 1., 1., 0.5, 1.", "times that increase")
        self.spoil("0., 0., 1., 1., 42., 1.", "0., 0., 1., 1., 42.", "pairs")
        self.spoil("0., 0., 1., 1., 42., 1.", "0., 0., 1., 1., 41., 1.", "ends at 41, the steps at 42")

    def test_steps(self):
        self.spoil("0.25, 41., 1.E-6, 0.25", "0.25, 41., 1.E-6", "needs 4 numbers")
        self.spoil("0.25, 41., 1.E-6, 0.25", "0.25, 40., 1.E-6, 0.25", "the steps at 41")
        self.spoil("0.25, 41., 1.E-6, 0.25", "0.5, 41., 1.E-6, 0.25", "first <= longest")
        self.spoil("INC=1000", "INC=10", "too small an INC")
        self.spoil("*STATIC\n0.05, 1., 1.E-6, 0.05\n", "", "needs one *STATIC")
        self.spoil("*END STEP\n**", "**", "is not ended")
        text = example("cube_c3d8.inp")
        end = text.rindex("*END STEP")
        self.assertTrue(any("is not ended" in f for f in Deck(text[:end]).faults))
        self.assertTrue(any("no output" in f for f in Deck(text.replace("*ELEMENT OUTPUT\nS, LE, SDV\n", "").replace(
            "*ELEMENT OUTPUT, ELSET=MUSCLE\nSDV1, SDV2, SDV3\n", "")).faults))

    def test_inside_out(self):
        self.spoil("1, 1, 2, 3, 4, 5, 6, 7, 8", "1, 5, 6, 7, 8, 1, 2, 3, 4", "inside out")
        self.spoil("1, 1, 2, 3, 4, 5, 6, 7, 8", "1, 1, 2, 4, 3, 5, 6, 8, 7", "inside out")
        for deck in ("plane_strain_cpe4.inp", "axisymmetric_cax4.inp"):
            self.spoil("\n1, 1, 2, 3, 4", "\n1, 4, 3, 2, 1", "inside out", deck=deck)
        self.spoil("\n1, 0., 0.\n", "\n1, -0.1, 0.\n", "inside out", deck="axisymmetric_cax4.inp")
        self.spoil("\n1, 1, 2, 3, 4", "\n1, 1, 3, 2, 4", "inside out", deck="shell_s4.inp")
        text = make_cylinder.deck("coarse")
        wedge = re.search(r"TYPE=C3D6.*\n(\d+), (\d+), (\d+), (.*)", text)
        turned = wedge[0].replace(f"{wedge[2]}, {wedge[3]}, ", f"{wedge[3]}, {wedge[2]}, ", 1)
        self.assertTrue(any("inside out" in f for f in Deck(text.replace(wedge[0], turned)).faults))

    def test_initial_conditions(self):
        for rows, words in (("1, 0., 0., 0., 0., 0., 1., 0.", "has 7 values"), ("1, 0., 0., 0., 0., 0., 1., 0., 0.", "values"),
                            ("1, 0., 0., 0., 0., 0., 1., 0.\n0., 0.", "has 9 values"),
                            ("7, 0., 0., 0., 0., 0., 1., 0.\n0.", "element 7 is not there")):
            self.spoil("*AMPLITUDE", f"*INITIAL CONDITIONS, TYPE=SOLUTION\n{rows}\n*AMPLITUDE", words)


def skin(deck):
    """The faces of only one element, by their nodes; faces shared by more than two count too."""
    owners = {}
    for kind, corners in deck.elements.values():
        for face in FACES[kind]:
            key = tuple(sorted(corners[i] for i in face))
            owners[key] = owners.get(key, 0) + 1
    return [key for key, n in owners.items() if n != 2]


def is_on_surface(points):
    """Whether a face lies on an end or on the side of the cylinder."""
    return {p[2] for p in points} in ({0.0}, {400.0}) or all(abs(math.hypot(x, y) - 10) < 1e-6 for x, y, _ in points)


class Cylinder(unittest.TestCase):
    def check(self, size, n_hex, n_wedge, outer, layers):
        deck = Deck(make_cylinder.deck(size))
        self.assertEqual(deck.faults, [])  # among others: no inverted element
        kinds = [kind for kind, _ in deck.elements.values()]
        self.assertEqual((kinds.count("C3D8"), kinds.count("C3D6"), len(kinds)), (n_hex, n_wedge, n_hex + n_wedge))

        polygon = outer / 2 * 10**2 * math.sin(2 * math.pi / outer)
        self.assertLess(polygon, math.pi * 10**2)
        total = sum(volume(kind, [deck.nodes[n] for n in corners]) for kind, corners in deck.elements.values())
        self.assertAlmostEqual(total / (400 * polygon), 1, delta=1e-8)

        faces = skin(deck)
        self.assertTrue(all(is_on_surface([deck.nodes[n] for n in face]) for face in faces))
        self.assertEqual(len(faces), 2 * (n_hex + n_wedge) // layers + outer * layers)
        self.assertEqual({n for _, corners in deck.elements.values() for n in corners}, set(deck.nodes))

        for name, z in (("PROXIMAL", 0.0), ("DISTAL", 400.0)):
            self.assertEqual(deck.sets["NSET"][name], {n for n, p in deck.nodes.items() if p[2] == z})
        middle = {deck.nodes[n][2] for e in deck.sets["ELSET"]["MIDDLE"] for n in deck.elements[e][1]}
        self.assertEqual(len(middle), 2)
        self.assertTrue(min(middle) <= 200 <= max(middle))
        self.assertEqual(len(deck.sets["ELSET"]["MIDDLE"]), (n_hex + n_wedge) // layers)
        return deck

    def test_coarse(self):
        self.check("coarse", 1296, 864, 24, 36)

    def test_the_papers_counts(self):
        deck = self.check("paper", 38556, 14931, 55, 189)
        self.assertEqual((38556, 14931), (204 * 189, 79 * 189))
        self.assertEqual(len(deck.nodes), 51680)

    def test_a_gap_would_be_seen(self):
        deck = Deck(make_cylinder.deck("coarse"))
        del deck.elements[700]
        self.assertFalse(all(is_on_surface([deck.nodes[n] for n in face]) for face in skin(deck)))

    def test_command_line(self):
        with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
            path = pathlib.Path(folder) / "biceps.inp"
            script = [sys.executable, EXAMPLES / "make_cylinder.py"]
            subprocess.run([*script, "-o", path], check=True)
            self.assertEqual(path.read_text(), subprocess.run(script, check=True, capture_output=True, text=True).stdout)
            self.assertEqual(Deck(path.read_text()).faults, [])
        wrong = subprocess.run([*script, "--size", "huge"], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("coarse", wrong.stderr)


HEAD = "element,n1,n2,n3\n"
# With what spreadsheets add: a byte-order mark, DOS line ends, empty columns and rows.
GOOD = "\ufeff# a field\n" + HEAD + "\n3, 0, 0, 2.5   # any length\n1,1e-1,-0.2,.3,,\r\n , ,,\n12,0,1,0\n"

# Wrong tables: the line, and a word of the messages of Python and Fortran.
BAD = [
    ("", None, "header", "header"),
    (HEAD, None, "rows", "rows"),
    ("label,x,y,z\n1,1,0,0\n", 1, "header", "header"),
    (HEAD + "1,1,0\n", 2, "expected 4", "three numbers"),
    (HEAD + "1,1,0,0,0\n", 2, "expected 4", "three numbers"),
    (HEAD + "1,1,,0\n", 2, "n2 is missing", "three numbers"),
    (HEAD + "1.5,1,0,0\n", 2, "whole number > 0", "label > 0"),
    (HEAD + "0,1,0,0\n", 2, "whole number > 0", "label > 0"),
    (HEAD + "-4,1,0,0\n", 2, "whole number > 0", "label > 0"),
    (HEAD + "1,1,0,0\n\n# twice\n1,0,1,0\n", 5, "already in line 2", "every element once"),
    (HEAD + "1,1,one,0\n", 2, "n2 = 'one'", "three numbers"),
    (HEAD + "1,nan,0,0\n", 2, "n1 = 'nan'", "three numbers"),
    (HEAD + "1,inf,0,0\n", 2, "n1 = 'inf'", "three numbers"),
    (HEAD + "1,1-2,0,0\n", 2, "n1 = '1-2'", "three numbers"),
    (HEAD + "1,2*1,0,0\n", 2, "n1 = '2*1'", "three numbers"),
    (HEAD + "1,1/,0,0\n", 2, "n1 = '1/'", "three numbers"),
    (HEAD + "1,0,0,0.0\n", 2, "of any length > 0", "of any length > 0"),
    (HEAD + "1;1;0;0\n", 2, "not semicolons", "three numbers"),
    (HEAD + "1,1,0,\n", 2, "n3 is missing", "three numbers"),
]


class Fibres(unittest.TestCase):
    """fibres_to_initial_conditions.py"""

    def make(self, text, *options):
        with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
            path = pathlib.Path(folder) / "fibres.csv"
            if text is not None:
                path.write_bytes(text.encode())
            return subprocess.run([sys.executable, EXAMPLES / "fibres_to_initial_conditions.py", path, *options],
                                  capture_output=True, text=True)

    def test_good(self):
        done = self.make(GOOD)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout, "*INITIAL CONDITIONS, TYPE=SOLUTION\n"
                                      "3, 0., 0., 0., 0., 0., 0, 0\n2.5\n"
                                      "1, 0., 0., 0., 0., 0., 1e-1, -0.2\n.3\n"
                                      "12, 0., 0., 0., 0., 0., 0, 1\n0\n")
        done = self.make(HEAD + "1,0,0,2\n", "--depvar", "9")
        self.assertEqual(done.stdout, "*INITIAL CONDITIONS, TYPE=SOLUTION\n1, 0., 0., 0., 0., 0., 0, 0\n2, 0.\n")

    def test_in_a_deck(self):
        rows = HEAD + "".join(f"{e},0.1,0,1\n" for e in range(1, 1801))
        text = make_cylinder.deck("coarse").replace("*AMPLITUDE", self.make(rows).stdout + "*AMPLITUDE", 1)
        self.assertEqual(Deck(text).faults, [])
        shell = self.make(HEAD + "1,1,0,0\n", "--depvar", "9").stdout
        self.assertEqual(Deck(example("shell_s4.inp").replace("*AMPLITUDE", shell + "*AMPLITUDE", 1)).faults, [])

    def test_bad(self):
        for text, line, words, _ in BAD:
            done = self.make(text)
            self.assertEqual((done.returncode, done.stdout), (1, ""), text)
            self.assertIn(f"fibres.csv:{line}: " if line else "fibres.csv: ", done.stderr)
            self.assertIn(words, done.stderr)
            self.assertIn("expected" if "already" not in words else words, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
        missing = self.make(None)
        self.assertEqual(missing.returncode, 1)
        self.assertIn("No such file", missing.stderr)
        self.assertEqual(self.make(GOOD, "--depvar", "7").returncode, 2)

    def test_nothing_is_lost(self):
        """A full disk, a missing folder and a folder instead of a file are named, by each of the scripts."""
        for script, *arguments in ((EXAMPLES / "expected.py",), (EXAMPLES / "make_cylinder.py",)):
            with open("/dev/full", "w") as full:
                done = subprocess.run([sys.executable, script, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, rf"^{script.name}: .*No space left on device\n$")
        for output in ("/nonexistent/x.inp", "/"):
            done = self.make(GOOD, "-o", output)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, rf"^fibres_to_initial_conditions.py: {output}.*: .+\n$")
        with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:  # the table itself as the output
            table = pathlib.Path(folder) / "fibres.csv"
            table.write_bytes(GOOD.encode())
            done = subprocess.run([sys.executable, EXAMPLES / "fibres_to_initial_conditions.py", table, "-o", table],
                                  capture_output=True, text=True)
            self.assertEqual((done.returncode, table.read_bytes()), (1, GOOD.encode()))
            self.assertIn("fibres.csv: cannot be written: it is the file that was read", done.stderr)


class Sdvini(unittest.TestCase):
    """sdvini_fibre.f, with a mock host instead of Abaqus."""

    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        cls.addClassCleanup(cls.kept.cleanup)
        cls.folder = pathlib.Path(cls.kept.name)
        cls.host = cls.folder / "host"
        sources = [EXAMPLES / "sdvini_fibre.f", SOURCE / "tests" / "abaqus_decks" / "sdvini_host.f90"]
        flags = ["-Wall", "-Werror", "-Wno-unused-dummy-argument", "-fcheck=all"]  # Abaqus prescribes the arguments
        done = subprocess.run([COMPILER, *flags, "-J", cls.folder, *sources, "-o", cls.host], capture_output=True, text=True)
        if done.returncode:
            raise AssertionError(done.stderr)

    def call(self, text, *arguments, name="fibres.csv", variable=""):
        with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
            if text is not None:
                (pathlib.Path(folder) / name).write_bytes(text.encode())
            return subprocess.run([self.host, *map(str, arguments)], capture_output=True, text=True, cwd=folder,
                                  env={**os.environ, "MYOGROWTH_FIBRES": variable})

    def states(self, done):
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = [line.split() for line in done.stdout.splitlines()]
        return {int(row[0]): [float(x) for x in row[1:]] for row in rows}

    def test_values(self):
        wanted = {1: [0] * 5 + [0.1, -0.2, 0.3], 12: [0] * 5 + [0, 1, 0], 3: [0] * 5 + [0, 0, 2.5],
                  2: [0] * 8, 99: [0] * 8}  # the last two are not in the table
        for lop in (0, 4):
            self.assertEqual(self.states(self.call(GOOD, 8, lop, 1, 12, 3, 2, 99)), wanted)
        self.assertEqual(self.states(self.call(GOOD, 9, 0, 12)), {12: [0] * 5 + [0, 1, 0, 0]})

    def test_another_file(self):
        done = self.call(GOOD, 8, 0, 12, name="other.csv", variable="other.csv")
        self.assertEqual(self.states(done)[12][5:], [0, 1, 0])

    def test_errors(self):
        for text, line, _, words in BAD:
            done = self.call(text, 8, 0, 1)
            self.assertEqual((done.returncode, done.stdout), (3, ""), text)
            self.assertIn("-3 myogrowth SDVINI: ./fibres.csv" + (f":{line}: " if line else ": "), done.stderr)
            self.assertIn("expected", done.stderr)
            self.assertIn(words, done.stderr)
        for done, words in ((self.call(None, 8, 0, 1), "./fibres.csv: cannot be opened"),
                            (self.call(GOOD, 8, 0, 1, variable="/"), "/: expected the header"),
                            (self.call(GOOD, 8, 0, 1, variable="x" * 1100), "more than 1024 characters"),
                            (self.call(GOOD, 8, -1, 1), "have not been read"), (self.call(GOOD, 8, 1, 1), "have not been read"),
                            (self.call(GOOD, 7, 0, 1), "*DEPVAR must be 8")):
            self.assertEqual(done.returncode, 3)
            self.assertIn(words, done.stderr)


class Expected(unittest.TestCase):
    """What README.md tells users to expect."""

    def test_the_readme_has_the_scripts_table(self):
        done = subprocess.run([sys.executable, EXAMPLES / "expected.py"], capture_output=True, text=True, check=True)
        readme = (EXAMPLES / "README.md").read_text(encoding="utf-8")
        self.assertIn(f"<!-- expected.py -->\n{done.stdout}<!-- end -->", readme)

    def test_the_umat_gives_it(self):
        for name, sides in (("cube_c3d8.inp", 2), ("plane_strain_cpe4.inp", 1)):
            wanted = expected.history(EXAMPLES / name)
            self.assertEqual(len(wanted), 1 + 20 + 164)
            lines = ["time,F11,F12,F13,F21,F22,F23,F31,F32,F33"]
            for t, _, _, a, *_ in wanted:
                lines.append(f"{t!r},{expected.stretch(t)!r},0,0,0,{a!r},0,0,0,{a if sides == 2 else 1.0!r}")
            with tempfile.TemporaryDirectory(prefix="myogrowth_") as folder:
                path = pathlib.Path(folder) / "F.csv"
                path.write_text("\n".join(lines) + "\n")
                subprocess.run([DRIVER, "--path", path, "--out", folder], check=True, capture_output=True)
                with open(pathlib.Path(folder) / "history.csv") as f:
                    rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
            self.assertEqual(len(rows), len(wanted))
            for row, (_, G, lambda_e, _, s_fibre, s_held, _) in zip(rows, wanted):
                for column, value in (("G", G), ("lambda_e", lambda_e), ("s11", s_fibre), ("s22", 0), ("s33", s_held)):
                    self.assertAlmostEqual(row[column], value, delta=1e-12)

    def test_it_is_near_the_exact_solution(self):
        at = {round(row[0], 6): row[2] for row in expected.history(EXAMPLES / "cube_c3d8.inp")}
        for day, exact in ((1, 1.0630), (14, 1.0170), (42, 1.0121)):
            self.assertAlmostEqual(at[day], exact, delta=3e-4)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
