"""Membranes whose data are known between lattice points, too, for bounds of the gap there."""

import numpy as np

import contactqp as cq
from contactqp.continuum.cells import Cells
from contactqp.continuum.obstacle import ObstacleProblem


class Posed:
    """A gap over a plane: T = 1 unless told, the load a function of x and y, and γ on the frame another.

    Parameters
    ----------
    lattice : Lattice
    load, heights : callable
        q and γ at places.
    load_bends : number
        Bound of |q_xx| + |q_yy|.
    height_bends : pair of numbers
        Least and largest second derivative of γ along the frame.
    """

    def __init__(self, lattice, load, heights, load_bends=0.0, height_bends=(0.0, 0.0), tension=1.0):
        self.lattice, self.tension = lattice, tension
        rows, columns = lattice.shape
        h = lattice.spacing
        column, row = np.meshgrid(np.arange(columns + 2), np.arange(rows + 2))
        self.x, self.y = lattice.x[0] + h * (column - 1), lattice.y[0] + h * (row - 1)
        off = load_bends * h**2 / 8 * (1 + 1e-9)
        least, most = height_bends
        self.problem = ObstacleProblem(
            Cells(lattice.mask, h, lattice.halved),
            tension,
            load(self.x, self.y) + np.zeros(self.x.shape),
            heights(self.x, self.y) + np.zeros(self.x.shape),
            (-off, off),
            (-max(most, 0.0) * h**2 / 8 * (1 + 1e-9), max(-least, 0.0) * h**2 / 8 * (1 + 1e-9)),
        )
        model = cq.Membrane(lattice, tension, load=load, support=0.0, frame_height=lambda x, y: -heights(x, y))
        self.solver = cq.Solver(model, "multigrid", tol=1e-9)
        self.gap = self.problem.with_rim(self.resolve(np.zeros(self.x.shape)))
        closure = self.problem.cells.closure
        at = [np.flatnonzero(closure.any(axis=axis)) for axis in (1, 0)]
        self.box = tuple(slice(places[0], places[-1] + 1) for places in at)
        """Rows and columns of the points that the region reaches."""

    def resolve(self, change):
        numbering = self.lattice.numbering
        load = numbering.to_vector(self.problem.load + change, ring=1)
        solution = self.solver.solve(load=load, on_failure="ignore")
        return numbering.to_grid(solution.gap, ring=1)


def bowl(squares, depth=0.03):
    """Return a square membrane under a uniform load over a floor at a depth."""
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / squares)
    return Posed(lattice, lambda x, y: 1.0 + 0 * x, lambda x, y: depth + 0 * x)


def ring_height(x, y):
    """Return u = r²/2 - ln r - 1/2 for r > 1, else 0: Δu = 2 where u > 0."""
    r = np.maximum(np.hypot(x, y), 1.0)
    return r**2 / 2 - np.log(r) - 0.5


def ring(squares):
    """Return the membrane of the gallery's ring; along the frame u_xx = 1 - (y² - x²)/r⁴ is within 1 ± 4/9."""
    lattice = cq.Frame.rectangle(3, 3).lattice(3 / squares)
    return Posed(lattice, lambda x, y: 2.0 + 0 * x, ring_height, height_bends=(5 / 9, 13 / 9))
