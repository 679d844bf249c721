"""Bounds: between which numbers each gap may lie."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra.stiffness import LatticeStiffness
from ..foundation.checks import Mask, Vector, read_only, real_array, repeated, told_shape
from ..geometry.numbering import Layout, Numbering
from ..geometry.runs import BOUNDED, FREE, SUPPORTED


class Bounds:
    """Lower and upper bounds of the unknowns: l ≤ ω ≤ u.

    Parameters
    ----------
    lower, upper : array, shape (n,)
        l ≤ u (length), -inf and inf where there is no bound; read-only. One number may be repeated in memory.

    Examples
    --------
    >>> bounds = Bounds.of(3, 0.0, [np.inf, 1.0, 2.0])
    >>> bounds.project(np.array([-1.0, 4.0, 1.5]))
    array([0. , 1. , 1.5])
    >>> bounds.one_sided
    False
    """

    def __init__(self, lower: Vector, upper: Vector) -> None:
        self.lower, self.upper = lower, upper
        self._known_layout: tuple[Numbering, Layout] | None = None

    @classmethod
    def of(cls, size: int, lower: ArrayLike, upper: ArrayLike, supported: ArrayLike | None = None) -> Bounds:
        """Return the bounds that a user gives, checked.

        Parameters
        ----------
        size : int
            Number of unknowns n.
        lower, upper : float or array, shape (n,)
            Length.
        supported : array of bool, shape (n,), optional
            False where there is no lower bound, whatever ``lower`` says.

        Raises
        ------
        TypeError, ValueError
            If one has the wrong kind or shape, is nan, leaves nothing in between, or is infinite on the wrong side.
        """
        low = _checked(lower, size, "lower", np.inf)
        high = _checked(upper, size, "upper", -np.inf)
        if supported is not None:
            mask = _support_mask(supported, size)
            if not mask.all():
                low = read_only(np.where(mask, low, -np.inf))
        if not (low <= high).all():
            worst = int(np.argmax(low > high))
            raise ValueError(
                f"lower must be <= upper, but at unknown {worst} lower is {low[worst]:g} and upper {high[worst]:g}"
            )
        return cls(low, high)

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return self.lower.size

    @cached_property
    def supported(self) -> Mask:
        """Where there is a lower bound, shape (n,)."""
        return np.broadcast_to(np.isfinite(_distinct(self.lower)), (self.size,))

    @cached_property
    def one_sided(self) -> bool:
        """Whether there is no upper bound anywhere."""
        return not np.isfinite(_distinct(self.upper)).any()

    @property
    def floor(self) -> Vector:
        """The lower bounds, and zero where there is none, shape (n,)."""
        return np.where(self.supported, self.lower, 0.0)

    @property
    def upper_if_any(self) -> Vector:
        """The upper bounds, shape (n,), or an empty vector where there is none at all, as kernels take them."""
        return np.zeros(0) if self.one_sided else self.upper

    @cached_property
    def standard(self) -> bool:
        """Whether every bound is a lower one, and zero."""
        lower = _distinct(self.lower)
        return self.one_sided and bool(((lower == 0) | np.isneginf(lower)).all())

    @cached_property
    def nearest_zero(self) -> Vector | float:
        """The admissible vector of least modulus, shape (n,); the number 0 where zero is admissible everywhere."""
        if (_distinct(self.lower) <= 0).all() and (_distinct(self.upper) >= 0).all():
            return 0.0
        return read_only(self.project(np.zeros(self.size)))

    @property
    def least_magnitude(self) -> float:
        """The least modulus of the finite bounds other than zero (length); 0 where there is none."""
        sizes = np.abs(np.concatenate([_distinct(self.lower), _distinct(self.upper)]))
        sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
        return float(sizes.min()) if sizes.size else 0.0

    def project(self, gap: Vector) -> Vector:
        """Return the admissible vector nearest to a gap, node by node, shape (n,)."""
        above = np.maximum(gap, self.lower)
        return above if self.one_sided else np.minimum(above, self.upper, out=above)

    def admissible_reaction(self, reaction: Vector) -> Vector:
        """Return the reaction nearest to one that the bounds can exert, node by node (force), shape (n,).

        R ≥ 0 where there is no upper bound, R ≤ 0 where there is no lower one, and 0 where there is neither.
        """
        pushed = np.where(self.supported, np.maximum(reaction, 0.0), 0.0)
        return pushed if self.one_sided else pushed + np.where(np.isfinite(self.upper), np.minimum(reaction, 0.0), 0.0)

    def natural_map(self, gap: Vector, correction: Vector) -> Vector:
        """Return ω - P(ω - c), with P the projection: zero at the solution only, if c is R/G_ii.

        Where the lower bound 0 is the only one it is min(ω, c), and c where there is none.

        Parameters
        ----------
        gap, correction : array, shape (n,)
            ω and c (length).
        """
        residual = np.minimum(gap - self.lower, correction)
        return residual if self.one_sided else np.maximum(residual, gap - self.upper, out=residual)

    def contact(self, gap: Vector, correction: Vector) -> tuple[Mask, Mask]:
        """Return the nodes that the lower and the upper bound hold, by the signs of their steps.

        Parameters
        ----------
        gap, correction : array, shape (n,)
            ω and R/G_ii (length).

        Returns
        -------
        lower, upper : array of bool, shape (n,)
            Where ω - R/G_ii lies below the lower bound, and where it lies above the upper one.
        """
        lower = correction > gap - self.lower
        if self.one_sided:
            return lower, np.zeros(self.size, dtype=np.bool_)
        upper = correction < gap - self.upper
        return lower & ~upper, upper

    def scaled(self, origin: Vector | float, length: Vector | float) -> Bounds:
        """Return the bounds of (ω - origin)/length: the same object where that changes nothing."""
        if self.standard:
            return self
        found = Bounds(*(read_only((bound - origin) / length) for bound in (self.lower, self.upper)))
        # A bound that is counted from elsewhere may become zero, but it may as well be looked up.
        found.kinds, found._known_layout = self.kinds, self._known_layout
        # Kernels are told the bounds wherever a node's kind says that it has some.
        found.standard = False
        return found

    @cached_property
    def kinds(self) -> NDArray[np.uint8] | None:
        """Kinds of nodes (see `contactqp.geometry.runs`), shape (n,); None if all are `SUPPORTED`.

        Supported are nodes whose only bound is the lower one, and zero.
        """
        if self.standard and self.supported.all():
            return None
        kinds = np.full(self.size, BOUNDED, dtype=np.uint8)
        open_above = np.isposinf(self.upper)
        kinds[open_above & (self.lower == 0)] = SUPPORTED
        kinds[open_above & np.isneginf(self.lower)] = FREE
        return kinds

    def layout(self, stencil: LatticeStiffness) -> Layout:
        """Return a lattice's nodes along its rows, those of a kind together; made once for a numbering."""
        if self.kinds is None:
            return stencil.layout
        numbering = stencil.numbering
        if self._known_layout is None or self._known_layout[0] is not numbering:
            kinds = np.ascontiguousarray(numbering.to_grid(self.kinds, fill=0)[numbering.box].astype(np.uint8))
            self._known_layout = numbering, Layout(numbering.layout.mask, kinds)
        return self._known_layout[1]


def _checked(value: ArrayLike, size: int, name: str, refused: float) -> Vector:
    bound = real_array(value, name)
    if bound.shape not in ((), (size,)):
        found = told_shape(bound, size, name)
        raise ValueError(f"{name} must be a number or have shape ({size},), got {found}")
    bad = np.flatnonzero(np.isnan(bound) | (bound == refused))
    if bad.size:
        wanted = "a number or -inf (no bound)" if refused > 0 else "a number or inf (no bound)"
        raise ValueError(f"{name} must be {wanted}, but entry {bad[0]} is {bound.flat[bad[0]]}")
    return np.broadcast_to(bound, (size,)) if bound.ndim == 0 else read_only(bound)


def _support_mask(value: ArrayLike, size: int) -> Mask:
    mask = np.array(value)
    if mask.dtype != np.bool_:
        raise TypeError(f"supported must be boolean, got dtype {mask.dtype}")
    if mask.shape != (size,):
        raise ValueError(f"supported must have shape ({size},), got {mask.shape}")
    return mask


def _distinct(bound: Vector) -> Vector:
    """Return the one entry of a repeated number, or the vector."""
    return bound[:1] if repeated(bound) else bound
