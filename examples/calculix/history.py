"""What happens over time: from the prints of every increment, one row of numbers each; and the Gauss points they come from."""
import numpy as np

import deck
import elements
from shared import files

COLUMNS = ["time", "reaction", "lambda_e_max", "lambda_e_mean", "lambda_e_min", "G_max", "G_mean", "G_min", "x", "y", "z"]


class GaussPoints:
    """The Gauss points of a mesh in the order in which CalculiX prints them."""

    def __init__(self, mesh, stiff):
        """stiff: (elements,) true where the element is not muscle."""
        parts = [elements.gauss_points(mesh.nodes, cells) for cells in mesh.elements()]
        self.places = np.concatenate([places.reshape(-1, 3) for places, _ in parts])  # (points, 3) mm
        self.volumes = np.concatenate([volumes.ravel() for _, volumes in parts])  # (points,) mm^3
        per_element = np.concatenate([np.full(len(v), v.shape[1]) for _, v in parts])
        self.elements = np.repeat(np.arange(len(stiff)) + 1, per_element)  # (points,) element numbers
        self.numbers = np.concatenate([np.tile(np.arange(v.shape[1]) + 1, len(v)) for _, v in parts])  # (points,) from 1
        self.muscle = ~stiff[self.elements - 1]  # (points,)

    def check(self, printed):
        """Whether a print of the .dat has these points and the state variables of the deck."""
        if not (np.array_equal(printed.elements, self.elements) and np.array_equal(printed.points, self.numbers)):
            raise files.FileError(f"the print of {printed.name} at day {printed.time:g} has other Gauss points than the mesh")
        if printed.values.shape[1] != len(deck.STATE):
            raise files.FileError(f"{printed.values.shape[1]} state variables at day {printed.time:g}: expected "
                                  f"{len(deck.STATE)}")

    def element_means(self, values):
        """(elements, components) means over the volume of every element of (points, components) values."""
        first = np.flatnonzero(np.diff(self.elements, prepend=0))
        return np.add.reduceat(values * self.volumes[:, None], first) / np.add.reduceat(self.volumes, first)[:, None]


def row(gauss, state, reaction):
    """A row of COLUMNS: extremes over the Gauss points of the muscle, means over its volume before the deformation, the
    axial reaction [mN] and where lambda_e is largest [mm, before the deformation]."""
    time, values = state.time, state.values[gauss.muscle]
    volumes = gauss.volumes[gauss.muscle]
    lambda_e, G = (values[:, deck.STATE.index(name)] for name in ("lambda_e", "G"))

    def spread(v):
        return v.max(), v @ volumes / volumes.sum(), v.min()

    return [time, reaction.values[2], *spread(lambda_e), *spread(G), *gauss.places[gauss.muscle][np.argmax(lambda_e)]]


def write(path, rows):
    files.write_csv(path, COLUMNS, [[f"{x:.7g}" for x in r] for r in rows])


def read(path):
    """The columns of a history.csv by their names, as arrays."""
    return {name: np.array(values) for name, values in files.read_columns(path, COLUMNS).items()}
