r"""Families: all models whose data lie between two others, enclosed by two answers.

Let G be an M-matrix. The deflection w, a depth, of Gw = P + b - R with c ≤ w ≤ f, in contact as in `Membrane`, grows
with the load P, with the depths f and c of support and ceiling, and with that of the frame, which enters b ≥ 0
linearly: it is the largest subsolution below f, and what is a subsolution remains one if they grow (Cottle, Pang and
Stone, *The Linear Complementarity Problem*, 1992, sect. 3.11). So the answers for the least and for the greatest of
all data enclose those of the whole family, P and f and c and b varying from node to node as they like:

.. math:: w(P^-, f^-, c^-, b^-) ≤ w(P, f, c, b) ≤ w(P^+, f^+, c^+, b^+).

A tension that is one number, in all directions, divides the equation: w depends on P/T, which lies between the least
and the greatest quotient of the ends; a foundation would be divided, too, and pulls one way or the other with the sign
of w, so that there is no such order. Where w_j ≥ w_j^- at the neighbours, the support presses a node of every member
that is at f⁺ or above it if

.. math:: P_i^- + b_i^- - G_{ii} f_i^+ + \sum_{j \ne i} |G_{ij}| w_j^- > 0,

because its reaction is no less; it is in contact in all. A node with w_i^+ < f_i^- is clear in all.

Both answers are enclosed by their certificates. Their problems hold P + b - Gf rounded, as a member's does: by less
than some dq, which moves an answer by G⁻¹dq ≤ max(dq_i/s_i) v with the barrier v > 0, 0 < s ≤ Gv; this is added on
both sides.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..backends.base import Backend
from ..errors import UnsuitableProblemError
from ..foundation.brackets import Bracket
from ..foundation.checks import Mask, Vector, read_only
from ..foundation.rounding import gamma
from ..foundation.text import at_most, counted
from ..models.base import ContactModel
from ..models.on_lattice import LatticeModel
from .solution import Solution
from .solve import solve

_ROUNDING = gamma(64)
"""More roundings than a node's force has in a chain."""


@dataclass(frozen=True, eq=False)
class Family:
    """What holds the answers of all models whose data lie between two others.

    Attributes
    ----------
    model : Membrane or Cable
        The one in the middle.
    least, greatest : Solution
        The answers for the least and for the greatest loads and depths.
    deflection : pair of arrays, shape (n,)
        Lower and upper bounds of the deflection of every member, positive as the model's heights (length).
    contact : array of bool, shape (n,)
        Nodes that the support certainly holds in every member.
    clear : array of bool, shape (n,)
        Nodes that certainly touch the support in none.
    uncertain : tuple of str
        The names of what lies between two.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(1, 1).lattice(spacing=1 / 16)
    >>> membrane = cq.Membrane(lattice, tension=1.0, load=cq.between(0.9, 1.1), support=0.03)
    >>> family = cq.solve_between(membrane)
    >>> print(family)
    Family of membranes: load between two
      deflection         known to within 0.0023
      in contact         69 nodes in all, 8 more in some at most
    >>> one = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.05, support=0.03))
    >>> low, high = family.deflection
    >>> bool(((low <= one.deflection) & (one.deflection <= high)).all())
    True
    """

    model: ContactModel = field(repr=False)
    least: Solution = field(repr=False)
    greatest: Solution = field(repr=False)
    deflection: tuple[Vector, Vector] = field(repr=False)
    contact: Mask = field(repr=False)
    clear: Mask = field(repr=False)
    uncertain: tuple[str, ...] = ()

    @cached_property
    def spread(self) -> float:
        """The largest distance of the two bounds at a node (length)."""
        low, high = self.deflection
        return float((high - low).max())

    @property
    def contact_area(self) -> Bracket:
        """Bracket of the area (cable: the length) in contact in any member."""
        area = self.model.area_of_node("contact_area")
        return Bracket(float(area[self.contact].sum()), float(area[~self.clear].sum()))

    def __str__(self) -> str:
        nodes = int(np.count_nonzero(self.contact))
        more = int(np.count_nonzero(~self.contact & ~self.clear))
        noun = getattr(self.model, "noun", "model")
        return "\n".join(
            [
                f"Family of {noun}s: {', '.join(self.uncertain)} between two",
                f"  deflection         known to within {at_most(self.spread)}",
                f"  in contact         {counted(nodes, 'node')} in all, {more} more in some at most",
            ]
        )


def solve_between(
    model: ContactModel, backend: str | Backend = "auto", *, tol: float | str = 1e-6, **options: Any
) -> Family:
    """Enclose the answers of all models whose data lie between what `contactqp.between` says, by two solves.

    Parameters
    ----------
    model : Membrane or Cable
        Made with ``between`` for its load, support, ceiling, frame height, or for a tension that is one number.
    backend, tol, **options
        As for `contactqp.solve`.

    Returns
    -------
    Family

    Raises
    ------
    TypeError
        If the model is on no lattice.
    UnsuitableProblemError
        If its matrix is no M-matrix, as a beam's or a plate's, or an uncertain foundation or tension has no order.
    ValueError
        If nothing was given by ``between``, or what is lower lies above what is upper at a node.

    Examples
    --------
    See `Family`.
    """
    model = uncertain_model(model)
    found = enclosed_between(model.extremes(), backend, tol=tol, **options)
    sign = -1.0 if model.upwards else 1.0
    bounds = [read_only(sign * depth) for depth in found.depths]
    return Family(
        model,
        least=found.solutions[0],
        greatest=found.solutions[1],
        deflection=(bounds[1], bounds[0]) if model.upwards else (bounds[0], bounds[1]),
        contact=read_only(found.contact),
        clear=read_only(found.clear),
        uncertain=tuple(model.uncertain),
    )


class Between(NamedTuple):
    """What is known of all members between two.

    Attributes
    ----------
    solutions : (Solution, Solution)
        The answers of the two.
    depths : pair of arrays, shape (n,)
        Lower and upper bounds of the members' deflections, positive downwards (length).
    contact, clear : array of bool, shape (n,)
        Nodes that the support certainly holds in all, and those that certainly touch it in none.
    """

    solutions: tuple[Solution, Solution]
    depths: tuple[Vector, Vector]
    contact: Mask
    clear: Mask


def uncertain_model(model: ContactModel) -> LatticeModel:
    """Return a model whose `extremes` enclose what lies between them; for what is raised see `solve_between`."""
    if not isinstance(model, LatticeModel):
        raise TypeError(f"a Membrane or a Cable can be given data that lie between two others, not {model!r}")
    if not model.uncertain:
        raise ValueError(f"nothing of {model!r} was given by contactqp.between(lower, upper): solve() answers it")
    if not model.problem.is_m_matrix:
        raise UnsuitableProblemError(
            f"the matrix of {model!r} is no M-matrix: its answers do not grow with load and support, and two of them "
            "enclose no others"
        )
    return model


def enclosed_between(
    ends: tuple[LatticeModel, LatticeModel],
    backend: str | Backend,
    *,
    starts: tuple[Vector | None, Vector | None] = (None, None),
    **options: Any,
) -> Between:
    """Return what two answers tell of all members between them.

    Parameters
    ----------
    ends : (LatticeModel, LatticeModel)
        The models of the least and of the greatest of all data.
    backend, **options
        As for `contactqp.solve`.
    starts : pair of arrays, shape (n,), or None
        Gaps to start from (length).
    """
    low, high = (solve(end, backend, warm_start=start, **options) for end, start in zip(ends, starts, strict=True))
    below = _depths(low, 0), _depths(high, 1)
    clear = (below[1] < ends[0].depth) | ~np.isfinite(ends[0].depth)
    return Between((low, high), below, _pressed(*ends, below[0]), clear)


def _depths(solution: Solution, side: int) -> Vector:
    """Return lower (0) or upper (1) bounds of the depths of an answer and of all that are posed alike (length)."""
    model, certificate = solution.model, solution.certificate
    assert model is not None
    problem = model.problem
    barrier = problem.barrier
    if certificate is None or barrier is None:
        raise UnsuitableProblemError(f"the answer of {model!r} is not enclosed, so that it encloses no others")
    stiffness = problem.stiffness.diagonal()
    force = 4 * stiffness * model.height_scale + np.abs(model.nodal_load)
    moved = 2 * _ROUNDING * float((force / barrier.s).max()) * np.asarray(barrier.v) * (1 + _ROUNDING)
    moved = moved + _ROUNDING * model.height_scale
    return np.asarray(
        model.reference - certificate.upper - moved if side == 0 else model.reference - certificate.lower + moved
    )


def _pressed(low: LatticeModel, high: LatticeModel, depths: Vector) -> Mask:
    """Return at which nodes the support presses in every member, given what no member is above of (length)."""
    stiffness = low.problem.stiffness.diagonal()
    there = np.isfinite(high.depth)
    down = np.where(there, high.depth, 0.0)
    push = low.nodal_load - low.pull(depths) - stiffness * (down - depths)
    size = np.abs(low.nodal_load) + 8 * stiffness * (low.height_scale + np.abs(down) + np.abs(depths))
    return np.asarray(there & (push > _ROUNDING * size))
