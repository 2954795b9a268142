"""Reads what CalculiX writes as text: the .frd (mesh and fields in the nodes) and the prints in the .dat.

    results = read_frd("job.frd")     results.nodes, results.hexes, results.wedges, results.steps[-1].fields["DISP"]
    for p in Dat("job.dat").read(): p.name, p.time, p.values

Everything has columns of fixed width, so numpy turns whole blocks into numbers at once. What cannot be read, and what
is no finite number, raises FormatError with the file, the line and what was expected there.
"""
import math
import re
from typing import NamedTuple

import numpy as np

from shared import files


class FormatError(files.FileError):
    """The file is not what CalculiX writes, or not all of it."""


class Step(NamedTuple):
    """The fields at one time."""

    time: float
    fields: dict  # of name to (nodes, components); NaN in nodes for which nothing is written
    components: dict  # of name to the names of the components


class Frd(NamedTuple):
    """A mesh, its nodes counted from 0 in hexes and wedges, and its fields."""

    node_numbers: np.ndarray  # (n,)
    nodes: np.ndarray  # (n, 3)
    hex_numbers: np.ndarray  # (m,)
    hexes: np.ndarray  # (m, 8)
    wedge_numbers: np.ndarray  # (k,)
    wedges: np.ndarray  # (k, 6)
    steps: list


class Print(NamedTuple):
    """One block of the .dat: SDV in the Gauss points of elements, or RF, the sum of reactions of a set of nodes."""

    name: str
    set: str
    time: float
    elements: np.ndarray  # (rows,) element numbers; empty for RF
    points: np.ndarray  # (rows,) Gauss points, from 1; empty for RF
    values: np.ndarray  # (rows, state variables), or (3,) for RF


class _Lines:
    """The text of a file, and the place in it."""

    def __init__(self, path, text, line=1):
        self.path, self.text, self.at, self.line = path, text, 0, line

    def fail(self, words, line=None):
        raise FormatError(f"{self.path}:{line or self.line}: {words}")

    def next(self, expected):
        end = self.text.find(b"\n", self.at)
        if end < 0:
            self.fail(f"the file ends here, expected {expected}: is the disk full, or was the job interrupted?")
        line = self.text[self.at:end]
        self.at, self.line = end + 1, self.line + 1
        return line

    def rows(self, count, lines_per_row, starts, expected):
        """(count, characters) the next rows; each has as many lines, of the same lengths, and its lines start alike."""
        begin, first_line = self.at, self.line
        for _ in range(lines_per_row):
            self.next(expected)
        width = self.at - begin
        text = self.text[begin:begin + count * width]
        whole = len(text) // width
        grid = np.frombuffer(text[:whole * width], "S1").reshape(whole, width)
        ends = np.flatnonzero(grid[0] == b"\n")
        right = ((grid == b"\n") == (grid[0] == b"\n")).all(axis=1)
        for start, key in zip([0, *(ends[:-1] + 1)], starts):
            right &= (grid[:, start:start + len(key)] == np.frombuffer(key, "S1")).all(axis=1)
        if not right.all():
            self.fail(f"expected {expected}", first_line + int(np.argmin(right)) * lines_per_row)
        if whole < count:
            self.fail(f"the file ends in row {whole + 1} of {count}, expected {expected}: is the disk full, or was the job "
                      "interrupted?",
                      first_line + whole * lines_per_row)
        self.at, self.line = begin + count * width, first_line + count * lines_per_row
        return grid

    def numbers(self, grid, begin, width, count, kind, lines_per_row=1):
        """(rows, count) numbers of rows that were just read: each `width` characters wide, the first at `begin`."""
        cells = np.ascontiguousarray(grid[:, begin:begin + width * count]).view(f"S{width}")
        try:
            values = cells.astype(kind)
            if np.isfinite(values).all():
                return values
        except (ValueError, OverflowError):
            pass
        for i, row in enumerate(cells):
            for k, cell in enumerate(row):
                try:
                    if math.isfinite(kind(cell)):
                        continue
                    expected = "expected a finite number"
                except (ValueError, OverflowError):
                    expected = "expected a number"
                self.fail(f"{cell.decode(errors='replace')!r} in columns {begin + k * width + 1} to {begin + (k + 1) * width}: "
                          f"{expected}", self.line - (len(cells) - i) * lines_per_row)
        raise AssertionError("numpy and Python read these numbers differently")

    def end_of(self, what):
        if not self.next(f"-3, the end of {what}").startswith(b" -3"):
            self.fail(f"expected -3, the end of {what}", self.line - 1)

    def integer(self, line, begin, end, expected):
        try:
            return int(line[begin:end])
        except ValueError:
            self.fail(f"columns {begin + 1} to {end} are {line[begin:end].decode(errors='replace')!r}: expected {expected}",
                      self.line - 1)

    def count(self, line, begin, end, what, least=0):
        """A number of things, each of which takes two characters at least."""
        count = self.integer(line, begin, end, f"a number of {what}")
        most = (len(self.text) - self.at) // 2
        if not least <= count <= most:
            self.fail(f"{count} {what}: must be >= {least} and, by the length of the file, <= {most}", self.line - 1)
        return count


def _read_nodes(lines, count):
    grid = lines.rows(count, 1, [b" -1"], "a node: -1, number, x, y, z")
    if grid.shape[1] != 50:
        lines.fail("expected nodes in lines of 49 characters", lines.line - count)
    numbers = lines.numbers(grid, 3, 10, 1, int)[:, 0]
    later = np.flatnonzero(np.diff(numbers) <= 0)
    if len(later):
        lines.fail(f"node {numbers[later[0] + 1]} after node {numbers[later[0]]}: expected increasing numbers",
                   lines.line - count + int(later[0]) + 1)
    places = lines.numbers(grid, 13, 12, 3, float)
    lines.end_of("the nodes")
    return numbers, places


def _read_elements(lines, count):
    """By type (1: C3D8, 2: C3D6): element numbers, and node numbers (elements, corners)."""
    corners = {1: 8, 2: 6}
    found = {kind: ([], []) for kind in corners}
    for _ in range(count):
        head = lines.next("an element: -1, number, type")
        if head[:3] != b" -1":
            lines.fail("expected an element: -1, number, type", lines.line - 1)
        kind = lines.integer(head, 13, 18, "the type of the element")
        if kind not in corners:
            lines.fail(f"element type {kind}: expected 1 (C3D8) or 2 (C3D6)", lines.line - 1)
        found[kind][0].append(lines.integer(head, 3, 13, "an element number"))
        row = lines.next("the nodes of an element: -2, numbers")
        if row[:3] != b" -2" or len(row) != 3 + 10 * corners[kind]:
            lines.fail(f"expected -2 and {corners[kind]} node numbers", lines.line - 1)
        found[kind][1].append([lines.integer(row, i, i + 10, "a node number") for i in range(3, len(row), 10)])
    lines.end_of("the elements")
    return {kind: (np.array(numbers, dtype=int), np.array(cells, dtype=int).reshape(-1, corners[kind]))
            for kind, (numbers, cells) in found.items()}


def _read_field(lines, rows, node_numbers):
    """The name, the names of the components and the values (nodes, components) of a field with that many rows."""
    head = lines.line - 1
    line = lines.next("-4, a field's name")
    if line[:3] != b" -4":
        lines.fail("expected -4, a field's name", lines.line - 1)
    name, listed = line[5:13].decode(errors="replace").strip(), lines.count(line, 13, 18, "components", 1)
    components = []
    for _ in range(listed):
        line = lines.next("-5, a component")
        if line[:3] != b" -5":
            lines.fail("expected -5, a component", lines.line - 1)
        if line[33:38].strip() != b"1":  # 1: a norm, of which no values are written
            components.append(line[5:13].decode(errors="replace").strip())
    n = len(components)
    if n == 0:
        lines.fail(f"{name} has no components", head)
    lines_per_row = (n + 5) // 6
    what = f"{name} in a node: -1, number, {n} values"
    grid = lines.rows(rows, lines_per_row, [b" -1"] + [b" -2"] * (lines_per_row - 1), what) if rows else np.empty((0, 50), "S1")
    values = []
    for k in range(lines_per_row):
        here = min(6, n - 6 * k)
        begin = k * (13 + 6 * 12 + 1) + 13
        if grid.shape[1] < begin + here * 12 + 1:
            lines.fail(f"expected {what}", lines.line - rows * lines_per_row)
        values.append(lines.numbers(grid, begin, 12, here, float, lines_per_row))
    numbers = lines.numbers(grid, 3, 10, 1, int, lines_per_row)[:, 0]
    lines.end_of("the field")
    place = np.searchsorted(node_numbers, numbers)
    if (place >= len(node_numbers)).any() or (node_numbers[place] != numbers).any():
        lines.fail(f"{name} is written for nodes that the mesh does not have", head)
    if len(np.unique(place)) < len(place):
        lines.fail(f"{name} is written twice for a node", head)
    whole = np.full((len(node_numbers), n), np.nan)
    whole[place] = np.hstack(values)
    return name, components, whole


def read_frd(path):
    """The mesh and all fields of a .frd that CalculiX has written as text."""
    lines = _Lines(path, files.read_bytes(path).replace(b"\r\n", b"\n"))
    node_numbers = nodes = elements = None
    steps = []
    while True:
        line = lines.next("9999, the end")
        key = line[:6].strip().decode(errors="replace")
        if key == "9999":
            break
        if key in ("2C", "3C", "100C"):
            if line[73:75].strip() not in (b"1", b"0") or (key == "3C" and nodes is None) or (key == "100C" and nodes is None):
                lines.fail("expected text, after the mesh", lines.line - 1)
        if key == "2C":
            node_numbers, nodes = _read_nodes(lines, lines.count(line, 24, 36, "nodes", 1))
        elif key == "3C":
            elements = _read_elements(lines, lines.count(line, 24, 36, "elements"))
        elif key == "100C":
            try:
                time = float(line[12:24])
            except ValueError:
                time = math.nan
            if not math.isfinite(time):
                lines.fail(f"{line[12:24].decode(errors='replace')!r}: expected a time", lines.line - 1)
            name, components, values = _read_field(lines, lines.count(line, 24, 36, "nodes"), node_numbers)
            if not steps or steps[-1].time != time or name in steps[-1].fields:
                steps.append(Step(time, {}, {}))
            steps[-1].fields[name], steps[-1].components[name] = values, components
        elif key[:1] != "1":
            lines.fail(f"{line[:40].decode(errors='replace')!r}: expected 1, 2C, 3C, 100C or 9999", lines.line - 1)
    if nodes is None or elements is None:
        lines.fail("there is no mesh in this file")
    for kind, (_, cells) in elements.items():
        place = np.minimum(np.searchsorted(node_numbers, cells), len(node_numbers) - 1)
        if (node_numbers[place] != cells).any():
            lines.fail("an element has a node that is not there")
        cells[:] = place
    return Frd(node_numbers, nodes, *elements[1], *elements[2], steps)


_PRINT = re.compile(rb" (?P<what>[a-z ]+) \([^)]*\) ?for set (?P<set>\S+) and time +(?P<time>\S+)$")
_NAMES = {b"internal state variables": "SDV", b"total force": "RF"}


class Dat:
    """A .dat, which may still be growing: every read() gives the blocks that have been completed since."""

    def __init__(self, path):
        self.path, self.offset, self.line = path, 0, 1

    def read(self, job_has_ended=True):
        raw = files.read_bytes(self.path, self.offset)
        lines = _Lines(self.path, raw.replace(b"\r\n", b"\n"), self.line)
        result = []
        while True:
            begin, first_line = lines.at, lines.line
            block = self._block(lines, job_has_ended)
            if block is None:
                if len(raw) > len(lines.text):  # ends of lines of two characters
                    begin = sum(map(len, raw.splitlines(keepends=True)[:first_line - self.line]))
                self.offset, self.line = self.offset + begin, first_line
                return result
            result.append(block)

    @staticmethod
    def _block(lines, job_has_ended):
        """A block, or None where there is none, or not all of it yet. A sum of forces is one line; state variables are all
        there when an empty line follows them."""
        text = lines.text
        while text.startswith(b"\n", lines.at):
            lines.next("")
        head_end = text.find(b"\n\n", lines.at)
        one_line = text.startswith(b" total force", lines.at)
        end = text.find(b"\n" if one_line else b"\n\n", head_end + 2) if head_end >= 0 else -1
        if end < 0 and job_has_ended and head_end >= 0 and text.endswith(b"\n"):
            end = len(text) - 1
        if end < 0:
            if job_has_ended and text[lines.at:].strip():
                lines.fail("the file ends in the middle of a block: is the disk full, or was the job interrupted?",
                           lines.line + text.count(b"\n", lines.at))
            return None
        head = lines.next("a heading")
        found = _PRINT.fullmatch(head.rstrip())
        if not found or found["what"] not in _NAMES:
            lines.fail(f"{head.decode(errors='replace')!r}: expected 'internal state variables' or 'total force', "
                       "a set and a time", lines.line - 1)
        name = _NAMES[found["what"]]
        try:
            time = float(found["time"])
        except ValueError:
            time = math.nan
        if not math.isfinite(time):
            lines.fail(f"{found['time'].decode(errors='replace')!r}: expected a time", lines.line - 1)
        lines.next("an empty line")
        count = text.count(b"\n", lines.at, end) + 1
        none = np.empty(0, dtype=int)
        if name == "RF":
            grid = lines.rows(count, 1, [b" "], "three forces")
            if count != 1 or grid.shape[1] != 49:
                lines.fail("expected one line with three forces", lines.line - count)
            return Print(name, found["set"].decode(errors="replace"), time, none, none, lines.numbers(grid, 6, 14, 3, float)[0])
        grid = lines.rows(count, 1, [b""], "element, Gauss point, values, as in the lines before")
        width = grid.shape[1] - 15
        if width <= 0 or width % 14:
            lines.fail("expected element (10 characters), Gauss point (4), values (14 each)", lines.line - count)
        elements, points = (lines.numbers(grid, begin, size, 1, int)[:, 0] for begin, size in ((0, 10), (10, 4)))
        values = lines.numbers(grid, 14, 14, width // 14, float)
        return Print(name, found["set"].decode(errors="replace"), time, elements, points, values)
