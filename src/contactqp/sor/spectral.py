"""Spectral radius of the Jacobi matrix on a part of a net of equal arms, for a few sweeps' work.

The Jacobi matrix of the free nodes, B = I - D⁻¹G with a constant diagonal D, is symmetric, so the largest Ritz value of
a few Lanczos steps is a lower bound of its spectral radius μ (Parlett, *The Symmetric Eigenvalue Problem*, 1998,
ch. 12). Such a Krylov space sees the slowest mode only after about 1/√(1 - μ) steps. They are therefore made on a
coarser net, where they are few and cheap, and the Ritz vector is carried back to finer ones (nested iteration,
Hackbusch, *Multi-Grid Methods and Applications*, 1985, ch. 5). One product on the net itself gives its Rayleigh
quotient there: what is lost on the way makes the bound less sharp, but not wrong.

Work is counted in nodes that go through the matrix, as sweeps count theirs; the passes that coarsen, interpolate and
orthogonalise are not. On the clock an estimate takes 0.05 ms with 63 nodes on a side, 0.3 ms with 255 and 3 ms with a
thousand, and some forty with a million nodes that cannot be coarsened. That is two to ten times as long as the sweeps
it counts as, more on small nets. All estimates of a solve are 1 to 4 % of its time (hexagon and bowls, warm).
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks import Mask
from . import spectral_kernels as kernels

_Grid: TypeAlias = NDArray[np.float64]

_FEWEST_NODES = 10
"""A coarser net has at least so many nodes for each point of a block: 40 in the plane, 20 on a line."""
_COARSE_STEPS = 1.6
"""Lanczos steps on the coarsest net, in units of 1/√(1 - μ) there."""
_MOST_STEPS = 40
_MIDDLE_STEPS = 2
_ALWAYS_COARSENED = 2
_LONGEST_SIDE = 64
"""Nets are coarsened twice, and on until no side is longer than this."""

MOST_WORK = _MOST_STEPS + 2 * _MIDDLE_STEPS
"""More products with the Jacobi matrix of the net than any estimate is worth; as a rule it is one to three."""


class Radius(NamedTuple):
    """An estimate of a spectral radius.

    Attributes
    ----------
    mu : float
        The estimate: up to rounding, a lower bound.
    products : float
        Products with the Jacobi matrix, times the number of nodes of the net each was made on.
    """

    mu: float
    products: float


def jacobi_radius(free: Mask, across: float, along: float) -> Radius:
    """Return the spectral radius of the Jacobi matrix of the nodes ``free``, from below.

    Parameters
    ----------
    free : array of bool, shape (rows, columns)
        The nodes of the matrix; all others are held.
    across, along : float
        Stiffness of a horizontal and of a vertical arm over G_ii.

    Returns
    -------
    Radius

    Examples
    --------
    On a square of n x n nodes μ = cos(π/(n + 1)):

    >>> import math
    >>> free = np.ones((63, 63), dtype=bool)
    >>> estimate = jacobi_radius(free, 0.25, 0.25)
    >>> round((1 - estimate.mu) / (1 - math.cos(math.pi / 64)), 2)
    1.05
    >>> round(estimate.products / free.size, 1)
    2.2
    """
    nets = _nets(free, across > 0, along > 0)
    net = nets.pop()
    if net.nodes == 0:
        return Radius(0.0, 0.0)
    if not nets:
        mu, steps, _ = net.lanczos(net.ones(), across, along, 3, _MOST_STEPS, with_vector=False)
        return Radius(mu, steps * float(net.nodes))
    _, steps, vector = net.lanczos(net.ones(), across, along, 3, _MOST_STEPS)
    products = steps * float(net.nodes)
    while len(nets) > 1:
        net = nets.pop()
        _, steps, vector = net.lanczos(net.prolonged(vector)[0], across, along, _MIDDLE_STEPS, _MIDDLE_STEPS)
        products += steps * float(net.nodes)
    net = nets.pop()
    vector, squares = net.prolonged(vector)
    mu = float(kernels.moment(net.ranges, vector, across, along)) / squares
    return Radius(mu, products + float(net.nodes))


class _Net:
    """Nodes, with a ring about them.

    Attributes
    ----------
    mask : array of bool, shape (rows + 2, columns + 2)
        True = node.
    nodes : int
        How many they are.
    points : int
        Number of points, nodes or not, within the ring.
    block : (int, int)
        Height and width, in points, of the blocks that are the points of the next coarser net.
    """

    def __init__(self, mask: Mask, nodes: int) -> None:
        self.mask, self.nodes = mask, nodes
        self.points = (mask.shape[0] - 2) * (mask.shape[1] - 2)
        self.block = (1, 1)
        self.ranges = np.empty((len(mask), 2), dtype=np.int64)
        kernels.row_ranges(mask, self.ranges)

    def coarser(self, joined_across: bool, joined_along: bool) -> _Net:
        """Return the net of the blocks of two by two points of which at least three are nodes.

        With only two, blocks would stick out into what is held, and the vector with them: it would be a worse start.
        Lines that no arm joins stay apart.
        """
        rows, columns = self.mask.shape[0] - 2, self.mask.shape[1] - 2
        high, wide = 2 if joined_along and rows > 3 else 1, 2 if joined_across and columns > 3 else 1
        self.block = (high, wide)
        mask = np.zeros((-(-rows // high) + 2, -(-columns // wide) + 2), dtype=np.bool_)
        nodes = int(kernels.coarsen(self.mask, high, wide, mask))
        return _Net(mask, nodes)

    def ones(self) -> _Grid:
        """Return the vector of ones."""
        return self.mask.astype(np.float64)

    def prolonged(self, coarse: _Grid) -> tuple[_Grid, float]:
        """Return the moduli of a vector on the coarser net, interpolated linearly, and the sum of their squares."""
        vector = np.zeros(self.mask.shape)
        squares = float(kernels.prolong(coarse, *self.block, self.mask, self.ranges, vector))
        return (vector, squares) if squares > 0 else (self.ones(), float(self.nodes))

    def lanczos(
        self, start: _Grid, across: float, along: float, fewest: int, most: int, *, with_vector: bool = True
    ) -> tuple[float, int, _Grid]:
        """Return the largest Ritz value, the number of steps and the Ritz vector; see Parlett (1998), ch. 13.

        Steps go on until they are as many as the Ritz value itself asks for. A small step of the Ritz value is no
        reason to stop, as it stagnates on the way from one mode to the next.
        """
        basis = np.zeros((most + 1 if with_vector else 3, *self.mask.shape))
        basis[0] = start
        mu, steps = kernels.lanczos(self.mask, self.ranges, basis, across, along, fewest, most, _COARSE_STEPS, start)
        return float(mu), int(steps), start


def _nets(free: Mask, joined_across: bool, joined_along: bool) -> list[_Net]:
    """Return the net of the free nodes and the coarser ones, the coarsest last."""
    mask = np.zeros((free.shape[0] + 2, free.shape[1] + 2), dtype=np.bool_)
    mask[1:-1, 1:-1] = free
    nets = [_Net(mask, int(np.count_nonzero(free)))]
    while len(nets) <= _ALWAYS_COARSENED or max(nets[-1].mask.shape) - 2 > _LONGEST_SIDE:
        coarser = nets[-1].coarser(joined_across, joined_along)
        # Rounding of odd lengths apart, a block has as many points as the net shrinks.
        block = round(nets[-1].points / coarser.points)
        if block == 1 or coarser.nodes < _FEWEST_NODES * block:
            break
        nets.append(coarser)
    return nets
