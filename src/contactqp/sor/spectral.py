"""Spectral radius of the Jacobi matrix on a part of a net of equal arms, for a few sweeps' work.

The Jacobi matrix of the free nodes, B = I - D⁻¹G with a constant diagonal D, is symmetric, so the largest Ritz value of
a few Lanczos steps is a lower bound of its spectral radius μ (Parlett, *The Symmetric Eigenvalue Problem*, 1998,
ch. 12). Such a Krylov space sees the slowest mode only after about 1/√(1 - μ) steps. They are therefore made on a
coarser net, where they are few and cheap, and the Ritz vector is carried back to finer ones (nested iteration,
Hackbusch, *Multi-Grid Methods and Applications*, 1985, ch. 5). One product on the net itself gives its Rayleigh
quotient there: what is lost on the way makes the bound less sharp, but not wrong.

Work is counted in nodes that go through the matrix, as sweeps count theirs; vectors that are scaled, added and
interpolated on the way are not. On the clock these passes in numpy take some ten times the compiled sweeps they count
as, more on small nets.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._checks import Mask

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

    >>> free = np.ones((63, 63), dtype=bool)
    >>> estimate = jacobi_radius(free, 0.25, 0.25)
    >>> round((1 - estimate.mu) / (1 - math.cos(math.pi / 64)), 2)
    1.05
    >>> round(estimate.products / free.size, 1)
    2.2
    """
    if not free.any():
        return Radius(0.0, 0.0)
    nets = _nets(free, across > 0, along > 0)
    vector = nets[-1].astype(float)
    mu, products = 0.0, 0.0
    for level in range(len(nets) - 1, -1, -1):
        net = nets[level]
        if level < len(nets) - 1:
            vector = _prolonged(vector, nets[level + 1].shape, net.shape)
        fewest, most = (_MIDDLE_STEPS, _MIDDLE_STEPS) if level else (1, 1)
        if level == len(nets) - 1:
            fewest, most = 3, _MOST_STEPS
        mu, vector, steps = _lanczos(net, np.abs(vector), across, along, fewest, most)
        products += steps * float(np.count_nonzero(net))
    return Radius(mu, products)


def _nets(free: Mask, joined_across: bool, joined_along: bool) -> list[Mask]:
    nets = [free]
    while len(nets) <= _ALWAYS_COARSENED or max(nets[-1].shape) > _LONGEST_SIDE:
        coarser = _coarser(nets[-1], joined_across, joined_along)
        # Rounding of odd lengths apart, a block has as many points as the net shrinks.
        block = round(nets[-1].size / coarser.size)
        if block == 1 or np.count_nonzero(coarser) < _FEWEST_NODES * block:
            break
        nets.append(coarser)
    return nets


def _coarser(net: Mask, joined_across: bool, joined_along: bool) -> Mask:
    """Return the blocks of two by two points of which at least three are nodes.

    With only two, blocks would stick out into what is held, and the vector with them: it would be a worse start. Lines
    that no arm joins stay apart.
    """
    high, wide = (
        2 if joined and length > 3 else 1
        for joined, length in zip((joined_along, joined_across), net.shape, strict=True)
    )
    rows, columns = (-(-length // block) for length, block in zip(net.shape, (high, wide), strict=True))
    padded = np.zeros((rows * high, columns * wide), dtype=bool)
    padded[: net.shape[0], : net.shape[1]] = net
    count = padded.reshape(rows, high, columns, wide).sum(axis=(1, 3))
    return np.asarray(4 * count >= 3 * high * wide)


def _prolonged(vector: _Grid, coarse: tuple[int, ...], fine: tuple[int, ...]) -> _Grid:
    """Return the values at the finer net's points, interpolated linearly between the middles of the blocks."""
    for axis in range(2):
        if coarse[axis] == fine[axis]:
            continue
        line = np.moveaxis(vector, axis, 0)
        padded = np.pad(line, ((1, 1), (0, 0)))
        finer = np.empty((2 * line.shape[0], line.shape[1]))
        finer[::2] = 0.75 * line + 0.25 * padded[:-2]
        finer[1::2] = 0.75 * line + 0.25 * padded[2:]
        vector = np.moveaxis(finer, 0, axis)
    return vector[: fine[0], : fine[1]]


def _lanczos(net: Mask, start: _Grid, across: float, along: float, fewest: int, most: int) -> tuple[float, _Grid, int]:
    """Return the largest Ritz value, its vector and the number of steps; see Parlett (1998), ch. 13.

    Steps go on until they are as many as the Ritz value itself asks for. A small step of the Ritz value is no
    reason to stop, as it stagnates on the way from one mode to the next.
    """
    from scipy.linalg import eigh_tridiagonal

    vector = np.where(net, start, 0.0)
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        vector = net.astype(float)
        length = float(np.linalg.norm(vector))
    vector /= length
    basis: list[_Grid] = []
    diagonal: list[float] = []
    beside: list[float] = []
    while True:
        basis.append(vector)
        product = _product(vector, net, across, along)
        diagonal.append(float(np.vdot(vector, product)))
        product -= diagonal[-1] * vector
        if beside:
            product -= beside[-1] * basis[-2]
        values, vectors = eigh_tridiagonal(np.array(diagonal), np.array(beside))
        steps, mu = len(basis), float(values[-1])
        length = float(np.linalg.norm(product))
        enough = max(fewest, _COARSE_STEPS / math.sqrt(max(1 - mu, 1e-12)))
        if steps >= min(most, enough) or length <= 1e-10:
            break
        beside.append(length)
        vector = product / length
    return mu, sum((w * v for w, v in zip(vectors[:, -1], basis, strict=True)), np.zeros(net.shape)), steps


def _product(vector: _Grid, net: Mask, across: float, along: float) -> _Grid:
    """Return the Jacobi matrix times a vector that is zero off the net."""
    product = np.zeros_like(vector)
    product[:, 1:] += across * vector[:, :-1]
    product[:, :-1] += across * vector[:, 1:]
    product[1:] += along * vector[:-1]
    product[:-1] += along * vector[1:]
    product *= net
    return product
