"""Beams whose exact answers are known."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector, integer_at_least, one_of, positive_number
from ..models.beam import Beam, End


def beam_on_floor(
    nodes: int, contact_starts_after: int, end: End = "pinned", *, tension: float = 0.0
) -> tuple[Beam, Vector]:
    """Return a heavy beam pressed on a flat floor, and its exact continuous deflection at the nodes.

    EI = p = L = 1, on the span (0, L), both ends held alike. The free part from each end comes down to the floor f with
    slope and moment zero at x = a. Without tension

        pinned:   w = x⁴/24 - ax³/12 + a³x/12,    f = a⁴/24,    a concentrated reaction a/2 at touchdown;
        clamped:  w = x⁴/24 - ax³/9 + a²x²/12,    f = a⁴/72,    a concentrated reaction a/3.

    With a tension, λ² = T/EI and w = b + cx + d sinh λx + e cosh λx - px²/2T, where b, c, d, e follow from the
    conditions at both ends of the free part.

    Parameters
    ----------
    nodes : int
        Nodes between the ends.
    contact_starts_after : int
        a in spacings; at most (nodes + 1)/2.
    end : {"pinned", "clamped"}
    tension : float
        TL²/EI, >= 0. Where λa is small, digits of the deflection are lost.

    Examples
    --------
    >>> beam, exact = beam_on_floor(nodes=7, contact_starts_after=3)
    >>> (1000 * exact).round(3)
    array([0.498, 0.773, 0.824, 0.824, 0.824, 0.773, 0.498])
    """
    nodes = integer_at_least(nodes, 1, "nodes")
    count = integer_at_least(contact_starts_after, 1, "contact_starts_after")
    if 2 * count > nodes + 1:
        raise ValueError(f"contact_starts_after must be <= (nodes + 1)/2 = {(nodes + 1) / 2:g}, got {count}")
    end = one_of(end, ("pinned", "clamped"), "end")  # type: ignore[assignment]
    spacing = 1 / (nodes + 1)
    touchdown = count * spacing
    distance = np.minimum(np.arange(1, nodes + 1), nodes - np.arange(nodes)) * spacing
    x = np.append(np.minimum(distance, touchdown), touchdown)
    fallen = _stretched(x, touchdown, end, positive_number(tension, "tension")) if tension else _bent(x, touchdown, end)
    beam = Beam(
        nodes=nodes,
        spacing=spacing,
        bending_stiffness=1.0,
        tension=float(tension),
        load=1.0,
        support=float(fallen[-1]),
        ends=end,
    )
    return beam, fallen[:-1]


def _bent(x: Vector, a: float, end: End) -> Vector:
    if end == "pinned":
        return np.asarray(x**4 / 24 - a * x**3 / 12 + a**3 * x / 12)
    return np.asarray(x**4 / 24 - a * x**3 / 9 + a**2 * x**2 / 12)


def _stretched(x: Vector, a: float, end: End, tension: float) -> Vector:
    rate = np.sqrt(tension)
    sinh, cosh = np.sinh(rate * a), np.cosh(rate * a)
    # Rows: no deflection, and no moment or no slope, at the end; no slope and no moment at touchdown.
    at_end = [0.0, 0.0, 0.0, rate**2] if end == "pinned" else [0.0, 1.0, rate, 0.0]
    rows = [
        [1.0, 0.0, 0.0, 1.0],
        at_end,
        [0.0, 1.0, rate * cosh, rate * sinh],
        [0.0, 0.0, rate**2 * sinh, rate**2 * cosh],
    ]
    right = [0.0, 1 / tension if end == "pinned" else 0.0, a / tension, 1 / tension]
    b, c, d, e = np.linalg.solve(rows, right)
    return np.asarray(b + c * x + d * np.sinh(rate * x) + e * np.cosh(rate * x) - x**2 / (2 * tension))
