"""Fields of one time as a VTU file, and a PVD file that names those of all times: for ParaView."""
import pathlib

import meshio
import numpy as np

import deck
import elements
from shared import files

# The .frd has the stress as xx yy zz xy yz zx, which is VTK's order too.
STRESS = ["SXX", "SYY", "SZZ", "SXY", "SYZ", "SZX"]


def fibres(mesh, displacements, n0):
    """(elements, 3) unit vectors of the fibres after the deformation, in the middle of every element."""
    n = np.concatenate([elements.gradients_at_centre(mesh.nodes, displacements, cells) @ n0 for cells in mesh.elements()])
    return n / np.linalg.norm(n, axis=1)[:, None]


def write_fields(path, mesh, fields, components, state, stiff, n0):
    """fields: of a Step of frd.py; state: (elements, state variables) means of the Gauss points; stiff: (elements,) true
    where the element is not muscle; n0: fibre before the deformation. Lengths in mm, stress in kPa, forces in mN."""
    if components["STRESS"] != STRESS:
        raise files.FileError(f"components of the stress are {components['STRESS']}: expected {STRESS}")
    point_data = {"displacement": fields["DISP"], "Cauchy_stress": fields["STRESS"], "reaction": fields["FORC"]}
    point_data.update(zip(deck.STATE, fields["SDV"].T))
    cell_data = {f"{name}_mean": values for name, values in zip(deck.STATE, state.T)}
    cell_data["fibre"] = fibres(mesh, fields["DISP"], n0)
    cell_data["muscle"] = np.where(stiff, 0, 1).astype(np.int32)
    split = [len(mesh.hexes)]
    grid = meshio.Mesh(
        mesh.nodes, [("hexahedron", mesh.hexes), ("wedge", mesh.wedges)],
        point_data={k: v.astype(np.float32) for k, v in point_data.items()},
        cell_data={k: np.split(v if v.dtype == np.int32 else v.astype(np.float32), split) for k, v in cell_data.items()})
    with files.writing(path) as part:
        meshio.write(part, grid, file_format="vtu", binary=True, compression="zlib")


def write_collection(path, times, written):
    """A PVD file beside the VTU files that it names."""
    lines = [f'    <DataSet timestep="{t:.9g}" part="0" file="{pathlib.Path(f).name}"/>' for t, f in zip(times, written)]
    files.write_text(path, '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
                     + "\n".join(lines) + "\n  </Collection>\n</VTKFile>\n")
