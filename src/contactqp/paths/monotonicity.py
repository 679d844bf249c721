"""Proven violations of the monotonicity that theory promises of a load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from ..foundation.checks import Vector
from ..foundation.rounding import UNIT_ROUNDOFF
from ..models.base import ContactModel
from ..solving.solution import Solution

_CLOSING = {"load": 1, "tension": -1, "lift": 1}
"""Whether gaps shrink as the parameter grows, if the load nowhere pulls upwards."""


def promised(model: ContactModel, parameter: str) -> bool:
    """Whether theory promises monotonicity: the support is lifted, or the load nowhere pulls upwards.

    A membrane between a support and a ceiling sinks as its load grows, w' ≥ w for p' ≥ p, on a foundation as well: G
    is an M-matrix (comparison principle). To divide the tension by a factor is to multiply load and reactions by it,
    but the stiffness of a foundation, too, so that then nothing is promised. Nor is anything of a beam or a plate,
    whose G is no M-matrix: pressed down in one place, it may rise in another.
    """
    if not model.problem.is_z_matrix:
        return False
    if parameter == "tension" and model.foundation is not None and model.foundation.any():
        return False
    return parameter == "lift" or bool((model.load >= 0).all())


def violations(model: ContactModel, parameter: str, values: Vector, solutions: Sequence[Solution]) -> Iterator[str]:
    """Return a sentence for each violation that the certificates prove.

    Parameters
    ----------
    model : Membrane, Cable or CableNet
        The model that is varied.
    parameter : str
        See `LoadPath`.
    values : array, shape (k,)
        In any order.
    solutions : sequence of Solution
        One for each value.
    """
    order = np.argsort(values * _CLOSING[parameter])
    caution = "" if promised(model, parameter) else f" ({why_not(model)}, so nothing else was promised)"
    for earlier, later in pairwise(order):
        first, second = solutions[earlier], solutions[later]
        if first.certificate is None or second.certificate is None:
            continue
        between = f"between {parameter} {values[earlier]:g} and {values[later]:g}"
        rounding = np.zeros(model.size)
        if parameter != "load":  # under a load that grows, every q grows even as it is rounded
            rounding += _rounding_of_data(model, first, abs(values[earlier]))
            rounding += _rounding_of_data(model, second, abs(values[later]))
        grown = np.where(model.supported, second.certificate.lower - first.certificate.upper - rounding, -np.inf)
        worst = int(np.argmax(grown))
        if grown[worst] > 0:
            node = model.describe(worst)
            yield f"the gap grows {between}, by at least {grown[worst]:.2g} at {node}{caution}"
        lifted = np.flatnonzero(
            first.certificate.contact_lower & (second.certificate.lower > rounding) & model.supported
        )
        if lifted.size:
            node = model.describe(int(lifted[0]))
            yield f"{lifted.size} node(s) lift off {between}, the first {node}{caution}"
        if parameter == "lift":
            room = second.problem.upper - rounding
            leaving = np.flatnonzero(first.certificate.contact_upper & (second.certificate.upper < room))
            if leaving.size:
                yield f"{leaving.size} node(s) leave the ceiling {between}, the first {model.describe(int(leaving[0]))}"


def why_not(model: ContactModel) -> str:
    """Return why nothing is promised, in words."""
    if not model.problem.is_z_matrix:
        return "what bends may rise beside the place where it is pressed down"
    return "the load also pulls upwards" if (model.load < 0).any() else "the foundation resists whatever the tension is"


def _rounding_of_data(base: ContactModel, solution: Solution, value: float) -> Vector:
    """Return how far rounding errors of f and q, in a varied model, can move its gaps (length), shape (n,)."""
    problem, model = solution.problem, solution.model
    if model is None:
        return np.zeros(base.size)
    heights = model.height_scale + np.abs(base.depth[base.supported]).max(initial=0.0) + value
    force = np.abs(model.nodal_load) + 4 * problem.stiffness.diagonal() * heights
    if problem.barrier is None:
        # |e_i| ≤ u_i ‖u r‖/λ for a residual r, where λ bounds the smallest eigenvalue of G in units u; the rows of what
        # bends have more entries.
        least = problem.facts.least_eigenvalue
        if least is None:
            return np.full(base.size, np.inf)
        moved = least.units * float(np.linalg.norm(least.units * force)) / least.bound
        return np.asarray(16 * UNIT_ROUNDOFF * (moved + heights))
    return np.asarray(4 * UNIT_ROUNDOFF * (problem.barrier.v * float((force / problem.barrier.s).max()) + heights))
