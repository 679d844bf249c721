"""Beams whose exact answers are known."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector, integer_at_least, one_of, positive_number
from ..models.beam import Beam, End
from .catalogue import entry
from .intervals import covered, distance_to_points, shared
from .known import Known


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
    return _on_floor(nodes, count / (nodes + 1), end, positive_number(tension, "tension") if tension else 0.0)


def _on_floor(nodes: int, touchdown: float, end: End, tension: float) -> tuple[Beam, Vector]:
    spacing = 1 / (nodes + 1)
    distance = np.minimum(np.arange(1, nodes + 1), nodes - np.arange(nodes)) * spacing
    x = np.append(np.minimum(distance, touchdown), touchdown)
    fallen = _stretched(x, touchdown, end, tension) if tension else _bent(x, touchdown, end)
    beam = Beam(
        nodes=nodes,
        spacing=spacing,
        bending_stiffness=1.0,
        tension=tension,
        load=1.0,
        support=float(fallen[-1]),
        ends=end,
    )
    return beam, fallen[:-1]


@entry("beam-pinned", n=49)
def _pinned_entry(name: str, nodes: int) -> Known:
    """Return a beam with pinned ends on a flat floor: EI = p = L = 1, a = 3/10, a force pa/2 at touchdown."""
    return _entry(name, nodes, "pinned", 0.0, force=_TOUCHDOWN / 2)


@entry("beam-clamped", n=49)
def _clamped_entry(name: str, nodes: int) -> Known:
    """Return a beam with clamped ends on a flat floor: EI = p = L = 1, a = 3/10, a force pa/3 at touchdown."""
    return _entry(name, nodes, "clamped", 0.0, force=_TOUCHDOWN / 3)


@entry("beam-with-tension", n=49)
def _tension_entry(name: str, nodes: int) -> Known:
    """Return a stretched beam with pinned ends on a flat floor: EI = p = L = 1, T = 100, a = 3/10."""
    tension = 100.0
    rate = np.sqrt(tension)
    _, _, d, e = _coefficients(_TOUCHDOWN, "pinned", tension)
    shear = rate**3 * (d * np.cosh(rate * _TOUCHDOWN) + e * np.sinh(rate * _TOUCHDOWN))
    return _entry(name, nodes, "pinned", tension, force=float(shear))


_TOUCHDOWN = 0.3


def _entry(name: str, nodes: int, end: End, tension: float, force: float) -> Known:
    beam, deflection = _on_floor(nodes, _TOUCHDOWN, end, tension)
    x, spacing, ends = beam.lattice.node_x, beam.lattice.spacing, (_TOUCHDOWN, 1 - _TOUCHDOWN)
    reaction = covered(x, spacing, *ends) + sum(shared(x, spacing, touchdown, force) for touchdown in ends)
    return Known(
        name,
        beam,
        "Euler and Bernoulli's equation, EI w⁗ - T w″ = p - ρ, solved piece by piece",
        spacing,
        deflection=deflection,
        reaction=reaction,
        contact_area=1 - 2 * _TOUCHDOWN,
        distance=distance_to_points(*ends),
    )


def _bent(x: Vector, a: float, end: End) -> Vector:
    if end == "pinned":
        return np.asarray(x**4 / 24 - a * x**3 / 12 + a**3 * x / 12)
    return np.asarray(x**4 / 24 - a * x**3 / 9 + a**2 * x**2 / 12)


def _stretched(x: Vector, a: float, end: End, tension: float) -> Vector:
    rate = np.sqrt(tension)
    b, c, d, e = _coefficients(a, end, tension)
    return np.asarray(b + c * x + d * np.sinh(rate * x) + e * np.cosh(rate * x) - x**2 / (2 * tension))


def _coefficients(a: float, end: End, tension: float) -> Vector:
    """Return b, c, d, e of the free part."""
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
    return np.asarray(np.linalg.solve(rows, right))
