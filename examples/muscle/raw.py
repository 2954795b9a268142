"""A mesh as a file has it, before any check: what the readers make and mesh.py checks."""
from dataclasses import dataclass, field

from shared import files

# Nodes of an element's faces in Abaqus's order, outward: S1, S2, ... of *SURFACE. Of tet10 the corners.
FACES = {
    "tet4": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
    "hex8": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge6": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
}
FACES["tet10"] = FACES["tet4"]
NODES = {"tet4": 4, "tet10": 10, "hex8": 8, "wedge6": 6}
CORNERS = {"tet4": 4, "tet10": 4, "hex8": 8, "wedge6": 6}


@dataclass
class Cell:
    kind: str  # of NODES
    label: int
    nodes: list  # indices, in Abaqus's order
    place: tuple  # (file, line)


@dataclass
class Raw:
    path: object
    places: list = field(default_factory=list)  # names of the files that were read
    nodes: list = field(default_factory=list)  # (x, y, z) as the file has them
    node_labels: list = field(default_factory=list)
    node_places: list = field(default_factory=list)  # (file, line)
    cells: list = field(default_factory=list)
    sections: list = None  # name of each cell's section; None: the file does not say
    elsets: dict = field(default_factory=dict)  # name to indices of cells
    nsets: dict = field(default_factory=dict)  # name to indices of nodes
    surfaces: dict = field(default_factory=dict)  # name to (corner indices) of facets
    fibres: list = None  # (x, y, z) of each cell
    notes: list = field(default_factory=list)  # what the user should know of the reading
    fibres_from: str = ""
    stretch: float = None  # part of the distance that DISTAL is moved by, if the mesh asks for one

    def where(self, place):
        """FILE:LINE, or FILE for a binary file."""
        name = self.places[place[0]]
        return f"{name}:{place[1]}" if place[1] else f"{name}"

    def node(self, i):
        return f"{self.where(self.node_places[i])}: node {self.node_labels[i]}"

    def cell(self, i):
        return f"{self.where(self.cells[i].place)}: element {self.cells[i].label}"


def fail(where, words):
    raise files.FileError(f"{where}: {words}")


def some(labels, most=20):
    """Numbers in words, the first twenty of them."""
    labels = list(labels)
    return ", ".join(map(str, labels[:most])) + (f" ... ({len(labels)} in all)" if len(labels) > most else "")
