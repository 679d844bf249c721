"""Stencil: the stiffness of tensioned arms between the nodes of a lattice, applied without assembling it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, read_only, real_array
from ..foundation.loading import load_modules
from ..foundation.rounding import DIFFERENCES, UNDERFLOW, gamma
from ..foundation.threads import Team
from ..geometry.numbering import Numbering
from .compensated import Chain, two_product, two_sum
from .stiffness import LatticeStiffness

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_Grid = NDArray[np.float64]

_POINTS_AT_ONCE = 1 << 15
"""Points of a lattice whose intermediate results stay in the processor's cache."""


class Stencil(LatticeStiffness):
    """Five-point stiffness G on a lattice: each node is joined to its four neighbours by arms.

    G_ii is the sum of the stiffnesses of the node's four arms, G_ij = -(stiffness of the arm) for two nodes
    that share one; an arm that ends on the frame enters the diagonal alone, and so does one that ends on the ground
    below the node. With every arm equal to the tension T this is the membrane's matrix (2.7)-(2.8) of the paper that
    contactqp starts from; with no vertical arms and T/spacing along x it is the cable's.

    Parameters
    ----------
    mask : array of bool, shape (rows, columns)
        True = node.
    horizontal : float or array, shape (rows, columns + 1)
        Stiffness (force per length) of the arm between ``[i, j - 1]`` and ``[i, j]``, >= 0.
    vertical : float or array, shape (rows + 1, columns)
        Stiffness of the arm between ``[i - 1, j]`` and ``[i, j]``, >= 0.
    ground : float or array, shape (rows, columns)
        Stiffness of the arm between ``[i, j]`` and the ground, which is at height zero, >= 0: of an elastic foundation.

    Raises
    ------
    ValueError
        If a stiffness is negative, not finite or of the wrong shape, or a node has no stiffness at all.

    Examples
    --------
    >>> import numpy as np
    >>> Stencil(np.ones((1, 3), dtype=bool), horizontal=1.0, vertical=1.0).tocsr().toarray()
    array([[ 4., -1.,  0.],
           [-1.,  4., -1.],
           [ 0., -1.,  4.]])
    >>> Stencil(np.ones((1, 2), dtype=bool), horizontal=1.0, vertical=0.0, ground=0.5).tocsr().toarray()
    array([[ 2.5, -1. ],
           [-1. ,  2.5]])
    """

    def __init__(
        self, mask: Mask, horizontal: float | _Grid, vertical: float | _Grid, ground: float | _Grid = 0.0
    ) -> None:
        self.numbering = Numbering(_checked_mask(mask))
        rows, columns = self.mask.shape
        self.horizontal = _arms(horizontal, (rows, columns + 1), "horizontal")
        self.vertical = _arms(vertical, (rows + 1, columns), "vertical")
        self.ground = _arms(ground, (rows, columns), "ground")
        self._refuse_extremes()
        if not self.uniform and not (self.horizontal.all() and self.vertical.all()):
            self._refuse_floating_parts()

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.numbering.size

    @property
    def longest_row(self) -> int:
        """Largest number of entries in a row: a node and its four neighbours."""
        return 5

    @property
    def positive_off_diagonal(self) -> None:
        """None: a stencil is a Z-matrix."""
        return None

    @property
    def lattice(self) -> Stencil:
        """The stencil itself."""
        return self

    @property
    def without_fill(self) -> bool:
        """Whether the lattice is a line."""
        return 1 in self.mask.shape

    @cached_property
    def nonzeros(self) -> int:
        """Number of nonzero entries of G."""
        west, south = self._node_arms()
        return self.size + 2 * (int(np.count_nonzero(west)) + int(np.count_nonzero(south)))

    @property
    def largest_diagonal(self) -> float:
        """Largest diagonal entry of G."""
        if self.even:
            springs = self.ground if self.ground.ndim == 0 else self.ground.max(where=self.mask, initial=0.0)
            return self._joined_arms() + float(springs)
        return float(self.diagonal().max())

    @property
    def finite(self) -> bool:
        """Whether all entries of G are finite."""
        return bool(np.isfinite(self.largest_diagonal))

    def scaled(self, factor: float) -> Stencil:
        """Return the stencil whose arms are all ``factor`` times as stiff."""
        return Stencil._of(self.numbering, self.horizontal * factor, self.vertical * factor, self.ground * factor)

    def on_ground(self, ground: Any) -> Stencil:
        """Return the stencil with other arms to the ground, a number or an array, which is not checked."""
        return Stencil._of(self.numbering, self.horizontal, self.vertical, ground)

    @classmethod
    def on(
        cls, numbering: Numbering, horizontal: float | _Grid, vertical: float | _Grid, ground: float | _Grid = 0.0
    ) -> Self:
        """Return the stencil of nodes that are numbered already; their arms are not checked, but for extremes."""
        return cls._of(numbering, *(np.asarray(arms, dtype=np.float64) for arms in (horizontal, vertical, ground)))

    @classmethod
    def _of(cls, numbering: Numbering, horizontal: _Grid, vertical: _Grid, ground: _Grid) -> Self:
        """Return the stencil of nodes that are numbered already, with arms that reach the frame."""
        stencil = cls.__new__(cls)
        stencil.numbering = numbering
        stencil.horizontal, stencil.vertical, stencil.ground = (
            read_only(np.asarray(arms)) for arms in (horizontal, vertical, ground)
        )
        stencil._refuse_extremes()
        return stencil

    def _refuse_extremes(self) -> None:
        if not (self.even and self._joined_arms() > 0) and not self._least_diagonal() > 0:
            raise ValueError("every node needs at least one arm of positive stiffness")
        if not self.finite:
            raise ValueError(
                "the stiffness of a node's arms together overflows: horizontal and vertical have values up to "
                f"{max(self.horizontal.max(), self.vertical.max(), self.ground.max()):g}; take larger units"
            )

    def diagonal(self) -> Vector:
        """Return the diagonal of G, shape (size,), force per length."""
        if self.uniform:
            return np.full(self.size, self._joined_arms())
        if self.even:
            with np.errstate(over="ignore"):
                springs = np.broadcast_to(self.ground, self.mask.shape)
                return np.asarray(self._joined_arms() + self.numbering.to_vector(springs))
        west, east, south, north = self.weights()
        with np.errstate(over="ignore"):
            joined = (west + east) + (south + north)
            if self.grounded:
                joined = joined + self.ground
        return self.numbering.to_vector(np.broadcast_to(joined, self.mask.shape))

    @property
    def diagonal_rounding(self) -> float:
        """See `Stiffness.diagonal_rounding`: each arm passes two sums, and one more turns it to the rounded entry.

        With arms to the ground it is one sum more.
        """
        return gamma(4) if self.grounded else gamma(3)

    def _joined_arms(self) -> float:
        """Return the stiffness of four equal arms together."""
        horizontal, vertical = float(self.horizontal), float(self.vertical)
        return (horizontal + horizontal) + (vertical + vertical)

    def _least_diagonal(self) -> float:
        return self._joined_arms() if self.uniform else float(self.diagonal().min())

    def matvec(self, vector: Vector) -> Vector:
        """Return G times a vector in node order, shape (..., size)."""
        west, east, south, north = self.weights()
        padded = self.numbering.to_grid(vector, ring=1)
        result = ((west + east) + (south + north)) * padded[..., 1:-1, 1:-1]
        result -= west * padded[..., 1:-1, :-2]
        result -= east * padded[..., 1:-1, 2:]
        result -= south * padded[..., :-2, 1:-1]
        result -= north * padded[..., 2:, 1:-1]
        if self.grounded:
            result += self.ground * padded[..., 1:-1, 1:-1]
        return self.numbering.to_vector(result)

    def pull(self, height: _Grid) -> Vector:
        """Return the force with which the arms resist a shape: sum of stiffness x (own height - the other end's).

        For heights h on nodes and frame it is Gh - b with b_i the sum of stiffness x height over node i's frame points;
        formed from differences, it does not lose digits to a common height. The ground is at height zero.

        Parameters
        ----------
        height : array, shape (rows + 2, columns + 2)
            Ordinates of nodes and frame points, with a ring about the lattice (see `Numbering.to_grid`).

        Returns
        -------
        array, shape (size,)
        """
        rows, columns = self.mask.shape
        arms = [np.broadcast_to(arm, self.mask.shape) for arm in (*self.weights(), self.ground)]
        pull = np.empty((rows, columns))

        def resist(first: int, last: int) -> None:
            step = max(1, _POINTS_AT_ONCE // columns)
            for row in range(first, last, step):
                rest = min(row + step, last)
                west, east, south, north, ground = (arm[row:rest] for arm in arms)
                near = height[row : rest + 2]
                own = near[1:-1, 1:-1]
                force = west * (own - near[1:-1, :-2]) + east * (own - near[1:-1, 2:])
                force += south * (own - near[:-2, 1:-1]) + north * (own - near[2:, 1:-1])
                if self.grounded:
                    force += ground * own
                pull[row:rest] = force

        with Team() as team:
            team.run(resist, team.strips(0, rows, columns))
        return self.numbering.to_vector(pull)

    def pull_and_magnitude(self, height: _Grid) -> tuple[Vector, Vector]:
        """Return the force of `pull`, and the same sum with the moduli of the differences; shapes (..., size)."""
        west, east, south, north = self.weights()
        own = height[..., 1:-1, 1:-1]
        force, magnitude = np.zeros(own.shape), np.zeros(own.shape)
        for arms, one, other in (
            ((west, east), height[..., 1:-1, :-2], height[..., 1:-1, 2:]),
            ((south, north), height[..., :-2, 1:-1], height[..., 2:, 1:-1]),
        ):
            first, second = own - one, own - other
            force += arms[0] * first + arms[1] * second
            magnitude += arms[0] * np.abs(first) + arms[1] * np.abs(second)
        if self.grounded:
            force += self.ground * own
            magnitude += self.ground * np.abs(own)
        return self.numbering.to_vector(force), self.numbering.to_vector(magnitude)

    def modulus_matvec(self, vector: Vector) -> Vector:
        """Return |G| times ``vector``."""
        return np.asarray(self.diagonal() * (2 * vector) - self.matvec(vector))

    def enclosed_product(self, vector: Vector, force: Vector | float = 0.0) -> tuple[Vector, Vector]:
        """Return G times a vector plus a force as computed, and a bound of its rounding error.

        It is formed from differences of neighbours, which keep the digits that a product with the diagonal would lose;
        see `Stiffness.enclosed_product`.
        """
        product, bound = self.pull_and_magnitude(self.numbering.to_grid(vector, ring=1))
        bound += np.abs(force)
        # What the ground adds is rounded once more in the sum, and once more in its bound.
        bound *= gamma(DIFFERENCES + 2 if self.grounded else DIFFERENCES)
        bound += UNDERFLOW
        return product + force, bound

    def accurate_product(self, high: Vector, low: Vector, force: Vector) -> tuple[Vector, Vector]:
        """Add stiffness times difference for the four arms of every point, some rows at a time."""
        rows, columns = self.mask.shape
        padded_high, padded_low = (self.numbering.to_grid(part, ring=1) for part in (high, low))
        forces = self.numbering.to_grid(force)
        weights = [np.broadcast_to(arm, self.mask.shape) for arm in self.weights()]
        result, bound = np.empty((rows, columns)), np.empty((rows, columns))
        step = max(1, _POINTS_AT_ONCE // columns)
        with np.errstate(over="ignore", invalid="ignore"):
            for first in range(0, rows, step):
                last = min(first + step, rows)
                chain = Chain(forces[first:last])
                own = slice(first + 1, last + 1), slice(1, columns + 1)
                for arm, (down, right) in zip(weights, ((0, -1), (0, 1), (-1, 0), (1, 0)), strict=True):
                    other = slice(first + 1 + down, last + 1 + down), slice(1 + right, columns + 1 + right)
                    stiffness = arm[first:last]
                    difference, rest = two_sum(padded_high[own], -padded_high[other])
                    rest += padded_low[own] - padded_low[other]
                    product, error = two_product(stiffness, difference)
                    chain.add(product, error, stiffness * rest)
                    chain.take_into_account(stiffness * (np.abs(padded_low[own]) + np.abs(padded_low[other])))
                if self.grounded:
                    stiffness = np.broadcast_to(self.ground, self.mask.shape)[first:last]
                    product, error = two_product(stiffness, padded_high[own])
                    chain.add(product, error, stiffness * padded_low[own])
                result[first:last], bound[first:last] = chain.result(6 if self.grounded else 5)
        return self.numbering.to_vector(result), self.numbering.to_vector(bound)

    def restricted(self, free: Mask) -> Stencil:
        """Return the stencil of some nodes, for which the others are frame."""
        mask = np.zeros(self.mask.shape, dtype=np.bool_)
        mask[self.mask] = free
        return Stencil(mask, self.horizontal, self.vertical, self.ground)

    def comparison(self) -> Stencil:
        """Return the stencil itself, which is its own comparison matrix."""
        return self

    def in_units(self, units: float | Vector) -> Stencil:
        """Return the stencil of nodes that all have the same unit of length, or a ValueError where they differ."""
        unit = float(np.ravel(units)[0])
        if not np.all(units == unit):
            raise ValueError("the nodes of a lattice have one unit of length together")
        return self.scaled(unit**2)

    def dimensionless(self) -> tuple[Stencil, float, float]:
        """Return the stencil with a largest diagonal entry of 1, one unit for all nodes, and that entry."""
        largest = self.largest_diagonal
        return self.scaled(1 / largest), 1.0, largest

    def _refuse_floating_parts(self) -> None:
        load_modules("scipy.sparse.csgraph")
        from scipy.sparse import csgraph

        matrix = self.tocsr()
        count, part = csgraph.connected_components(matrix, directed=False)
        west, east, south, north = (np.broadcast_to(arm, self.mask.shape) for arm in self.weights())
        points = self.padded_mask()
        held = (
            west * ~points[1:-1, :-2]
            + east * ~points[1:-1, 2:]
            + south * ~points[:-2, 1:-1]
            + north * ~points[2:, 1:-1]
        )
        held = held + self.ground
        loose = np.bincount(part, weights=held[self.mask] > 0, minlength=count) == 0
        if loose.any():
            node = int(np.flatnonzero(loose[part])[0])
            raise ValueError(f"{int(loose.sum())} part(s) have no arm to the frame, among them that of node {node}")

    def padded_mask(self) -> Mask:
        """Return the mask with a ring of frame points about it."""
        return np.pad(self.mask, 1)

    def frame_points(self) -> Mask:
        """Return where, on the array with a ring about it, a frame point is joined to a node by an arm."""
        west, east, south, north = (np.broadcast_to(arm > 0, self.mask.shape) & self.mask for arm in self.weights())
        joined = np.zeros((self.mask.shape[0] + 2, self.mask.shape[1] + 2), dtype=bool)
        joined[1:-1, :-2] |= west
        joined[1:-1, 2:] |= east
        joined[:-2, 1:-1] |= south
        joined[2:, 1:-1] |= north
        return np.asarray(joined & ~self.padded_mask())

    @property
    def _arrays(self) -> tuple[NDArray[Any], ...]:
        return self.mask, self.horizontal, self.vertical, self.ground

    def tocsr(self) -> csr_array:
        """Assemble G as a sparse array with sorted column numbers."""
        load_modules("scipy.sparse")
        from scipy.sparse import csr_array

        west, south = self._node_arms()
        index_type = np.int32 if 5 * self.size < 2**31 else np.int64
        number = np.full((self.mask.shape[0] + 2, self.mask.shape[1] + 2), -1, dtype=index_type)
        number[1:-1, 1:-1][self.mask] = np.arange(self.size, dtype=index_type)
        columns = np.empty((self.size, 5), dtype=index_type)
        values = np.empty((self.size, 5))
        kept = np.empty((self.size, 5), dtype=bool)
        east, north = np.zeros_like(west), np.zeros_like(south)
        east[:, :-1], north[:-1] = west[:, 1:], south[1:]
        neighbours = (
            (number[:-2, 1:-1], south),
            (number[1:-1, :-2], west),
            (number[1:-1, 1:-1], None),
            (number[1:-1, 2:], east),
            (number[2:, 1:-1], north),
        )
        for k, (neighbour, arm) in enumerate(neighbours):
            columns[:, k] = neighbour[self.mask]
            if arm is None:
                values[:, k], kept[:, k] = self.diagonal(), True
            else:
                np.negative(arm[self.mask], out=values[:, k])
                kept[:, k] = values[:, k] != 0
        pointers = np.zeros(self.size + 1, dtype=index_type)
        np.cumsum(kept.sum(axis=1), out=pointers[1:])
        return csr_array((values[kept], columns[kept], pointers), shape=(self.size, self.size))

    def weights(self) -> tuple[Any, Any, Any, Any]:
        """Return the stiffness of the west, east, south and north arm of every point of the array."""
        horizontal, vertical = self.horizontal, self.vertical
        west, east = (horizontal, horizontal) if horizontal.ndim == 0 else (horizontal[:, :-1], horizontal[:, 1:])
        south, north = (vertical, vertical) if vertical.ndim == 0 else (vertical[:-1], vertical[1:])
        return west, east, south, north

    def _node_arms(self) -> tuple[_Grid, _Grid]:
        """Return the stiffness of each point's west and south arm, 0 where it does not join two nodes."""
        west, _, south, _ = self.weights()
        west_arm, south_arm = np.zeros(self.mask.shape), np.zeros(self.mask.shape)
        west_arm[:, 1:] = np.where(
            self.mask[:, 1:] & self.mask[:, :-1], np.broadcast_to(west, self.mask.shape)[:, 1:], 0.0
        )
        south_arm[1:] = np.where(self.mask[1:] & self.mask[:-1], np.broadcast_to(south, self.mask.shape)[1:], 0.0)
        return west_arm, south_arm

    def __repr__(self) -> str:
        kind = "uniform" if self.horizontal.ndim == self.vertical.ndim == 0 else "varying arms"
        kind += ", on a foundation" * self.grounded
        return f"Stencil({self.size} nodes in {self.mask.shape[0]} x {self.mask.shape[1]}, {kind})"


def _checked_mask(mask: Any) -> Mask:
    points = np.asarray(mask)
    if points.dtype != np.bool_ or points.ndim != 2 or not points.any():
        raise ValueError(
            f"mask must be a two-dimensional boolean array with a node, got dtype {points.dtype}, shape {points.shape}"
        )
    return points if not points.flags.writeable else read_only(points.copy())


def _arms(value: float | _Grid, shape: tuple[int, int], name: str) -> _Grid:
    arms = real_array(value, name)
    if arms.ndim and arms.shape != shape:
        raise ValueError(f"{name} must be a number or have shape {shape}, got {arms.shape}")
    if not np.isfinite(arms).all() or (arms < 0).any():
        raise ValueError(f"{name} must be finite and >= 0, got values from {arms.min():g} to {arms.max():g}")
    return read_only(arms)
