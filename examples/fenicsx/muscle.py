"""Growth of muscle in dolfinx: myogrowth's law at the quadrature points, its exact tangent in Newton's method.

The stress P and its derivative dP/dF are functions on a quadrature element. Before each assembly one call of
myogrowth.update fills both for all points of the process; UFL's forms then only integrate them.
"""
import basix
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

import myogrowth


class Muscle:
    """Residual and tangent of a muscle with displacement u, and the state (G and the fibre) of each quadrature point.

    u: a vector function on hexahedra or tetrahedra. n0: the fibre at F = 1, one direction (3,) or, for each quadrature
    point of the process's cells, (cells, points, 3). degree: of the quadrature; 2 is 2 x 2 x 2 points in a hexahedron.
    activation: of an active elastic law, from 0 to 1; set it before a step, as the prescribed displacements.
    """

    def __init__(self, u, parameters, n0, degree=2):
        self.u, self.parameters = u, parameters
        mesh = u.function_space.mesh
        cells = mesh.topology.index_map(mesh.topology.dim)
        self.cells = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
        cell = mesh.ufl_cell()
        points, weights = basix.make_quadrature(getattr(basix.CellType, cell.cellname()), degree)

        def at_points(size):
            return fem.Function(fem.FunctionSpace(mesh, ufl.VectorElement("Quadrature", cell, degree, dim=size,
                                                                          quad_scheme="default")))

        self.P, self.dP_dF, self.weight = at_points(9), at_points(81), at_points(1)
        self.F_at_points = fem.Expression(ufl.Identity(3) + ufl.grad(u), points)
        dx = ufl.Measure("dx", mesh, metadata={"quadrature_degree": degree, "quadrature_scheme": "default"})
        v, du = ufl.TestFunction(u.function_space), ufl.TrialFunction(u.function_space)
        entries = [(i, j) for i in range(3) for j in range(3)]  # of a tensor, row by row, as NumPy stores it
        dF, vF = ufl.grad(du), ufl.grad(v)
        self.residual_form = fem.form(sum(self.P[a] * vF[i, j] for a, (i, j) in enumerate(entries)) * dx)
        self.tangent_form = fem.form(sum(self.dP_dF[9 * a + b] * dF[k, l] * vF[i, j] for a, (i, j) in enumerate(entries)
                                         for b, (k, l) in enumerate(entries)) * dx)
        shape = (len(self.cells), len(points))
        detJ = fem.Expression(abs(ufl.JacobianDeterminant(mesh)), points).eval(self.cells).reshape(shape)
        self.volumes = (detJ * weights)[: cells.size_local].ravel()  # of the process's own points, undeformed
        self.state = myogrowth.State(n0=np.broadcast_to(n0, (*shape, 3)).reshape(-1, 3))
        self.step = None
        self.activation = 0.0

    def update(self, dt):
        """P and dP/dF at the present u, dt after the state that is kept. MyogrowthError where u turns a cell inside out."""
        F = self.F_at_points.eval(self.cells).reshape(-1, 3, 3)
        self.step = myogrowth.update(self.parameters, F, dt, self.state, measure="first_piola", tangent=True,
                                     activation=self.activation)
        for function, values in ((self.P, self.step.stress), (self.dP_dF, self.step.tangent)):
            size = function.function_space.dofmap.bs
            function.x.array.reshape(-1, size)[function.function_space.dofmap.list.array] = values.reshape(-1, size)

    def accept(self):
        """Ends the time step: the states of the last update are those that the next one begins with."""
        self.state = self.step.state

    def mean(self, values):
        """Mean over the undeformed volume of a value for each point, such as muscle.step.state.G."""
        own = values.reshape(-1)[: len(self.volumes)]
        comm = self.u.function_space.mesh.comm
        return comm.allreduce(own @ self.volumes) / comm.allreduce(self.volumes.sum())


class Newton:
    """Full Newton iterations with the unsymmetric tangent, each solved by MUMPS's LU."""

    def __init__(self, muscle, conditions, tolerance=1e-9, most=20):
        self.muscle, self.conditions, self.tolerance, self.most = muscle, conditions, tolerance, most
        self.A = fem.petsc.create_matrix(muscle.tangent_form)
        self.b = fem.petsc.create_vector(muscle.residual_form)
        self.du = self.b.duplicate()
        self.solver = PETSc.KSP().create(muscle.u.function_space.mesh.comm)
        self.solver.setOperators(self.A)
        self.solver.setType("preonly")
        self.solver.getPC().setType("lu")
        self.solver.getPC().setFactorSolverType("mumps")

    def forces(self, lifted=False):
        """The internal forces of the last update: at prescribed displacements, the reactions. lifted: what the columns of
        prescribed displacements that are still to come contribute, subtracted."""
        with self.b.localForm() as local:
            local.set(0)
        fem.petsc.assemble_vector(self.b, self.muscle.residual_form)
        if lifted:
            fem.petsc.apply_lifting(self.b, [self.muscle.tangent_form], bcs=[self.conditions], x0=[self.muscle.u.vector],
                                    scale=-1.0)
        self.b.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return self.b

    def solve(self, dt):
        """Moves u to the end of the step; norms of the residual over that of all forces, one for each iteration."""
        u, norms = self.muscle.u, []
        while True:
            self.muscle.update(dt)
            b = self.forces()
            scale = b.norm()  # with the reactions in it
            fem.petsc.set_bc(b, self.conditions, u.vector, -1.0)  # where u is prescribed: how far it is from there
            norms.append(b.norm() / scale if scale > 0 else 1.0)
            if len(norms) > 1 and norms[-1] <= self.tolerance:
                return norms
            if len(norms) > self.most or not np.isfinite(norms[-1]):
                raise RuntimeError(f"Newton's method has not converged in {self.most} iterations, residuals {norms}")
            self.A.zeroEntries()
            fem.petsc.assemble_matrix(self.A, self.muscle.tangent_form, self.conditions)
            self.A.assemble()
            b = self.forces(lifted=True)
            fem.petsc.set_bc(b, self.conditions, u.vector, -1.0)
            self.solver.solve(b, self.du)
            u.vector.axpy(-1.0, self.du)
            u.x.scatter_forward()
