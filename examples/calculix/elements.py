"""C3D8 and C3D6 as CalculiX integrates them: shape functions, Gauss points in its order of printing, gradients."""
import numpy as np

_G = 1 / np.sqrt(3.0)
_CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])

# (points, 3) natural coordinates and (points,) weights, by the number of nodes of the element.
GAUSS = {
    8: np.array([[x, y, z] for z in (-_G, _G) for y in (-_G, _G) for x in (-_G, _G)]),
    6: np.array([[1 / 3, 1 / 3, -_G], [1 / 3, 1 / 3, _G]]),
}
WEIGHTS = {8: np.ones(8), 6: np.full(2, 0.5)}
CENTRE = {8: np.zeros((1, 3)), 6: np.array([[1 / 3, 1 / 3, 0]])}


def shape(nodes, at):
    """Shape functions (points, nodes) and their natural derivatives (points, nodes, 3) at natural coordinates (points, 3)."""
    xi, eta, zeta = at.T[:, :, None]
    if nodes == 8:
        x, y, z = 1 + xi * _CORNERS[:, 0], 1 + eta * _CORNERS[:, 1], 1 + zeta * _CORNERS[:, 2]
        derivatives = [_CORNERS[:, 0] * y * z / 8, x * _CORNERS[:, 1] * z / 8, x * y * _CORNERS[:, 2] / 8]
        return x * y * z / 8, np.stack(derivatives, axis=2)
    triangle = np.hstack([1 - xi - eta, xi, eta])
    by_xi, by_eta = np.broadcast_to([-1.0, 1.0, 0.0], triangle.shape), np.broadcast_to([-1.0, 0.0, 1.0], triangle.shape)
    bottom, top = (1 - zeta) / 2, (1 + zeta) / 2
    derivatives = [np.hstack([f * bottom, f * top]) for f in (by_xi, by_eta)] + [np.hstack([-triangle, triangle]) / 2]
    return np.hstack([triangle * bottom, triangle * top]), np.stack(derivatives, axis=2)


def jacobians(nodes, cells, at):
    """dx/dxi (elements, points, 3, 3) of cells (elements, corners) at natural coordinates (points, 3)."""
    _, derivatives = shape(cells.shape[1], at)
    return np.einsum("eni,pnj->epij", nodes[cells], derivatives)


def gauss_points(nodes, cells):
    """Places (elements, points, 3) [mm] and volumes (elements, points) [mm^3] of the Gauss points."""
    corners = cells.shape[1]
    values, _ = shape(corners, GAUSS[corners])
    places = np.einsum("eni,pn->epi", nodes[cells], values)
    return places, np.linalg.det(jacobians(nodes, cells, GAUSS[corners])) * WEIGHTS[corners]


def gradients_at_centre(nodes, displacements, cells):
    """Deformation gradient (elements, 3, 3) in the middle of every element."""
    centre = CENTRE[cells.shape[1]]
    reference = jacobians(nodes, cells, centre)[:, 0]
    current = jacobians(nodes + displacements, cells, centre)[:, 0]
    return current @ np.linalg.inv(reference)
