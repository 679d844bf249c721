"""Spectral radius of the Jacobi matrix on a part of a net of equal arms, for a few sweeps' work.

The Jacobi matrix of the free nodes, B = I - D⁻¹G with a constant diagonal D, is symmetric, so the largest Ritz value of
a few Lanczos steps is a lower bound of its spectral radius μ (Parlett, *The Symmetric Eigenvalue Problem*, 1998,
ch. 12). Such a Krylov space sees the slowest mode only after about 1/√(1 - μ) steps. They are therefore made on a
coarser net, where they are few and cheap, and the Ritz vector is carried back to finer ones (nested iteration,
Hackbusch, *Multi-Grid Methods and Applications*, 1985, ch. 5). One product on the net itself gives its Rayleigh
quotient there: what is lost on the way makes the bound less sharp, but not wrong.

Work is counted in nodes that go through the matrix, as sweeps count theirs; the passes that coarsen, interpolate and
orthogonalise are not. On the clock an estimate takes 0.1 ms with 63 nodes on a side, 0.5 ms with 255 and 3 ms with a
thousand, and some twenty on a line of a million nodes. From 255 nodes on a side that is about as long as the sweeps it
counts as; with 127 it is four times as long, with 63 eight times, as what is not compiled (see `spectral_kernels`)
takes its time on the smallest net, too. All estimates of a certified solve are 1 to 5 % of its time (hexagon and bowls,
warm), half a millisecond at most up to 63 nodes on a side. Solves by the paper's rules are shorter, some by far: of
those it is 4 to 13 % from 127 nodes on a side, and up to half for the hexagon, that is 0.3 ms.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ...foundation.checks import Mask
from ..sor import spectral_kernels as kernels

_Grid: TypeAlias = NDArray[np.float64]

_FEWEST_NODES = 10
"""A coarser net has at least so many nodes for each point of a block: 40 in the plane, 20 on a line."""
_COARSE_STEPS = 1.6
"""Lanczos steps on the coarsest net, in units of 1/√(1 - μ) there."""
_MOST_STEPS = 40
_NEGLIGIBLE = 1e-10
"""A unit vector's product with the matrix that is so close to the Krylov space lies in it."""
_ROUNDING = 1e-14
"""Distance of inverse iteration's shift from the bound: well above the rounding errors of a factorisation."""
_MOST_ROUNDS = 30
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
    return Radius(net.moment(vector, across, along) / squares, products + float(net.nodes))


class NodeGrid:
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

    def __init__(self, mask: Mask) -> None:
        self.mask = mask
        self.nodes = int(np.count_nonzero(mask))
        self.points = (mask.shape[0] - 2) * (mask.shape[1] - 2)
        self.block = (1, 1)

    def coarser(self, joined_across: bool, joined_along: bool) -> NodeGrid:
        """Return the net of the blocks of two by two points of which at least three are nodes.

        With only two, blocks would stick out into what is held, and the vector with them: it would be a worse start.
        Lines that no arm joins stay apart.
        """
        rows, columns = self.mask.shape[0] - 2, self.mask.shape[1] - 2
        high, wide = 2 if joined_along and rows > 3 else 1, 2 if joined_across and columns > 3 else 1
        self.block = (high, wide)
        mask = np.zeros((-(-rows // high) + 2, -(-columns // wide) + 2), dtype=np.bool_)
        # The last block of an odd length reaches into the ring. Four points are counted whatever the block: twice a
        # point, or four times, if it has fewer.
        bottom, right = high * (mask.shape[0] - 2) + 1, wide * (mask.shape[1] - 2) + 1
        points = self.mask.view(np.uint8)
        pairs = points[1:bottom:high] + points[high:bottom:high]
        np.greater_equal(pairs[:, 1:right:wide] + pairs[:, wide:right:wide], 3, out=mask[1:-1, 1:-1])
        return NodeGrid(mask)

    def ones(self) -> _Grid:
        """Return the vector of ones."""
        return self.mask.astype(np.float64)

    def prolonged(self, coarse: _Grid) -> tuple[_Grid, float]:
        """Return the moduli of a vector on the coarser net, interpolated linearly, and the sum of their squares."""
        vector = np.zeros(self.mask.shape)
        squares = kernels.prolong(coarse, *self.block, self.mask, vector)
        return (vector, squares) if squares > 0 else (self.ones(), float(self.nodes))

    def moment(self, vector: _Grid, across: float, along: float) -> float:
        """Return the product of a vector with the Jacobi matrix times itself."""
        line, width = vector.ravel(), vector.shape[1]
        # Each arm once. Rows may be strung together, as their ends lie in the ring.
        return 2 * (across * _dot(line[1:], line[:-1]) + along * _dot(line[width:], line[:-width]))

    def lanczos(
        self, start: _Grid, across: float, along: float, fewest: int, most: int, *, with_vector: bool = True
    ) -> tuple[float, int, _Grid]:
        """Return the largest Ritz value μ, the number of steps and the Ritz vector; see Parlett (1998), ch. 13.

        Steps go on until they are as many as the Ritz value itself asks for, 1.6/√(1 - μ). A small step of the Ritz
        value is no reason to stop, as it stagnates on the way from one mode to the next. Without the vector, three
        vectors of the basis are kept, and the start is returned.
        """
        slots = most + 1 if with_vector else 3
        basis = np.zeros((slots, start.size))
        basis[0] = start.ravel()
        mask, width = self.mask.ravel(), start.shape[1]
        diagonal: list[float] = []
        beside: list[float] = []
        scales: list[float] = []
        length, back = math.sqrt(_dot(basis[0], basis[0])), 0.0
        while True:
            steps = len(diagonal)
            scales.append(1 / length)
            before, vector, product = (basis[(steps + k) % slots] for k in (-1, 0, 1))
            element, new_length = kernels.lanczos_step(
                mask, width, vector, before, product, across, along, scales[-1], back
            )
            diagonal.append(element)
            steps += 1
            enough = steps >= fewest and _all_below(diagonal, beside, 1 - (_COARSE_STEPS / steps) ** 2)
            if enough or steps == most or new_length <= _NEGLIGIBLE:
                break
            beside.append(new_length)
            back = new_length / length
            length = new_length
        mu, weights = largest_eigenpair(diagonal, beside)
        if not with_vector:
            return mu, steps, start
        return mu, steps, np.einsum("i,ij->j", weights * scales, basis[:steps]).reshape(start.shape)


def _dot(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the product of two vectors, without the threads of a BLAS: to wake them takes longer."""
    return float(np.einsum("i,i", one, other))


def largest_eigenpair(diagonal: list[float], beside: list[float]) -> tuple[float, NDArray[np.float64]]:
    """Return the largest eigenvalue of a symmetric tridiagonal matrix and its unit vector.

    The elements beside the diagonal are positive, so the vector's are, too. Inverse iteration from ones, each time with
    the least upper bound that the last vector gives as shift, converges quadratically and subtracts nothing (Noda,
    Numer. Math. 17, 1971). It takes five to eight rounds, less time than the threads of a LAPACK take to wake.
    """
    bound = max(map(sum, zip(diagonal, [0.0, *beside], [*beside, 0.0], strict=True)))
    margin = _ROUNDING * max(1.0, abs(bound))
    vector = [1.0] * len(diagonal)
    for _ in range(_MOST_ROUNDS):
        shift = bound + margin
        pivot, value = shift - diagonal[0], vector[0]
        pivots, solution = [pivot], [value]
        for element, arm, old in zip(diagonal[1:], beside, vector[1:], strict=True):
            share = arm / pivot
            pivot = shift - element - arm * share
            value = old + share * value
            pivots.append(pivot)
            solution.append(value)
        solution[-1] = value = value / pivot
        for k in range(len(beside) - 1, -1, -1):
            solution[k] = value = (solution[k] + beside[k] * value) / pivots[k]
        # The eigenvalue lies below the shift by no less than the least of these, and by no more than the largest.
        below = [old / new for old, new in zip(vector, solution, strict=True)]
        largest = max(solution)
        vector = [value / largest for value in solution]
        bound = shift - min(below)
        if max(below) - min(below) <= margin:
            break
    unit = np.array(vector)
    return bound, unit / math.sqrt(_dot(unit, unit))


def _all_below(diagonal: list[float], beside: list[float], bound: float) -> bool:
    """Whether all eigenvalues of a symmetric tridiagonal matrix are below a bound, by its pivots (Sturm)."""
    pivot = diagonal[0] - bound
    for element, arm in zip(diagonal[1:], beside, strict=True):
        if pivot >= 0:
            return False
        pivot = element - bound - arm * arm / pivot
    return pivot < 0


def _nets(free: Mask, joined_across: bool, joined_along: bool) -> list[NodeGrid]:
    """Return the net of the free nodes and the coarser ones, the coarsest last."""
    mask = np.zeros((free.shape[0] + 2, free.shape[1] + 2), dtype=np.bool_)
    mask[1:-1, 1:-1] = free
    nets = [NodeGrid(mask)]
    while len(nets) <= _ALWAYS_COARSENED or max(nets[-1].mask.shape) - 2 > _LONGEST_SIDE:
        coarser = nets[-1].coarser(joined_across, joined_along)
        # Rounding of odd lengths apart, a block has as many points as the net shrinks.
        block = round(nets[-1].points / coarser.points)
        if block == 1 or coarser.nodes < _FEWEST_NODES * block:
            break
        nets.append(coarser)
    return nets
