"""Beams whose exact answers are known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

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
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    end = one_of(end, ("pinned", "clamped"), "end")  # type: ignore[assignment]
    return _on_floor(nodes, count / (nodes + 1), end, positive_number(tension, "tension") if tension else 0.0)


def _on_floor(nodes: int, touchdown: float, end: End, tension: float) -> tuple[Beam, Vector]:
    def shape(x: Vector) -> Vector:
        return _stretched(x, touchdown, end, tension) if tension else _bent(x, touchdown, end)

    return _down_on_floor(nodes, touchdown, end, shape, tension=tension)


def _down_on_floor(
    nodes: int, touchdown: float, end: End, shape: Callable[[Vector], Vector], **held: Any
) -> tuple[Beam, Vector]:
    """Return a beam that lies on a floor beyond its free parts, whose shape is given, and its deflection."""
    spacing = 1 / (nodes + 1)
    distance = np.minimum(np.arange(1, nodes + 1), nodes - np.arange(nodes)) * spacing
    fallen = shape(np.append(np.minimum(distance, touchdown), touchdown))
    beam = Beam(
        nodes=nodes,
        spacing=spacing,
        bending_stiffness=1.0,
        load=1.0,
        support=float(fallen[-1]),
        ends=end,
        **held,
    )
    return beam, fallen[:-1]


def beam_on_foundation(
    nodes: int, contact_starts_after: int, end: End = "pinned", *, stiffness: float = 1000.0
) -> tuple[Beam, Vector]:
    """Return a beam on an elastic foundation pressed on a flat floor, and its exact continuous deflection at the nodes.

    EI = p = L = 1, on the span (0, L), both ends held alike. With β⁴ = k/4EI the free part from each end is

        w = p/k + A cosh βx cos βx + B cosh βx sin βx + C sinh βx cos βx + D sinh βx sin βx

    (Hetényi, *Beams on Elastic Foundation*, 1946), where no deflection and no moment, or no slope, at the end, and no
    slope and no moment at x = a give the constants. There it comes down to the floor f = w(a), and from there on the
    foundation carries kf of the load p.

    Parameters
    ----------
    nodes : int
        Nodes between the ends.
    contact_starts_after : int
        a in spacings; at most (nodes + 1)/2, and so few that βa < 3π/4 where the ends are pinned, or βa < π where they
        are clamped: at these the floor lies at p/k, where the foundation carries the load alone.
    end : {"pinned", "clamped"}
    stiffness : float
        kL⁴/EI, > 0. Where βa is small, digits of the deflection are lost.

    Examples
    --------
    >>> beam, exact = beam_on_foundation(nodes=7, contact_starts_after=3)
    >>> (1000 * exact).round(3)
    array([0.308, 0.472, 0.501, 0.501, 0.501, 0.472, 0.308])
    """
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    end = one_of(end, ("pinned", "clamped"), "end")  # type: ignore[assignment]
    stiffness = positive_number(stiffness, "stiffness")
    spacing, rate = 1 / (nodes + 1), _rate(stiffness)
    longest = 0.75 * np.pi if end == "pinned" else np.pi
    if not rate * count * spacing < longest:
        raise ValueError(
            f"contact_starts_after must be < {longest / (rate * spacing):.4g}, got {count}: a longer free part lies on "
            "so stiff a foundation before it comes down"
        )
    return _on_foundation(nodes, count * spacing, end, stiffness)


def _rate(stiffness: float) -> float:
    """Return β, (k/4EI)^¼ for EI = 1."""
    return float((stiffness / 4) ** 0.25)


def _on_foundation(nodes: int, touchdown: float, end: End, stiffness: float) -> tuple[Beam, Vector]:
    return _down_on_floor(nodes, touchdown, end, lambda x: _sunk(x, touchdown, end, stiffness), foundation=stiffness)


def beam_between_floor_and_ceiling(half: int, contact_starts_after: int) -> tuple[Beam, Vector]:
    """Return a beam pressed on a floor on its left and on a ceiling on its right, and its exact continuous deflection.

    EI = 1 on the span (0, 2), p = 1 on the left half, -1 on the right, and 0 at the middle node; pinned ends. In the
    middle deflection and moment vanish, as at a pinned end, so that either half is that of `beam_on_floor` with L = 1,
    the right one turned over. The ceiling lies as high above the ends as the floor lies below them.

    Parameters
    ----------
    half : int
        Half the span in spacings.
    contact_starts_after : int
        The free parts' length a in spacings; at most half of ``half``.

    Examples
    --------
    >>> beam, exact = beam_between_floor_and_ceiling(half=4, contact_starts_after=2)
    >>> (1000 * exact).round(3)
    array([ 2.116,  2.604,  2.116,  0.   , -2.116, -2.604, -2.116])
    """
    half = integer_at_least(half, 2, "half")
    _, count = _nodes_and_touchdown(half - 1, contact_starts_after)
    return _between_floor_and_ceiling(half, count / half)


def _between_floor_and_ceiling(half: int, touchdown: float) -> tuple[Beam, Vector]:
    one, fallen = _on_floor(half - 1, touchdown, "pinned", 0.0)
    beam = Beam(
        nodes=2 * half - 1,
        spacing=one.lattice.spacing,
        bending_stiffness=1.0,
        load=np.concatenate([np.ones(half - 1), [0.0], -np.ones(half - 1)]),
        support=float(one.support[0]),
        ceiling=-float(one.support[0]),
        ends="pinned",
    )
    return beam, np.concatenate([fallen, [0.0], -fallen])


def _nodes_and_touchdown(nodes: int, contact_starts_after: int) -> tuple[int, int]:
    nodes = integer_at_least(nodes, 1, "nodes")
    count = integer_at_least(contact_starts_after, 1, "contact_starts_after")
    if 2 * count > nodes + 1:
        raise ValueError(f"contact_starts_after must be <= (nodes + 1)/2 = {(nodes + 1) / 2:g}, got {count}")
    return nodes, count


def _sunk(x: Vector, a: float, end: End, stiffness: float) -> Vector:
    return np.asarray(1 / stiffness + _constants(a, end, stiffness) @ _derivatives(_rate(stiffness) * x)[0])


def _constants(a: float, end: End, stiffness: float) -> Vector:
    """Return A, B, C, D of the free part."""
    at_end, at_touchdown = _derivatives(np.zeros(())), _derivatives(np.array(_rate(stiffness) * a))
    rows = [at_end[0], at_end[2 if end == "pinned" else 1], at_touchdown[1], at_touchdown[2]]
    return np.asarray(np.linalg.solve(rows, [-1 / stiffness, 0.0, 0.0, 0.0]))


def _derivatives(place: Vector) -> list[Vector]:
    """Return the four functions, their slopes over β, curvatures over 2β², and slopes of these over 2β³, by βx."""
    sinh, cosh, sin, cos = (function(place) for function in (np.sinh, np.cosh, np.sin, np.cos))
    functions = np.array([cosh * cos, cosh * sin, sinh * cos, sinh * sin])
    slopes = np.array(
        [sinh * cos - cosh * sin, cosh * cos + sinh * sin, cosh * cos - sinh * sin, cosh * sin + sinh * cos]
    )
    return [
        functions,
        slopes,
        np.array([-functions[3], functions[2], -functions[1], functions[0]]),
        np.array([-slopes[3], slopes[2], -slopes[1], slopes[0]]),
    ]


@entry("beam-pinned", n=49)
def _pinned_entry(name: str, nodes: int) -> Known:
    """Return a beam with pinned ends on a flat floor: EI = p = L = 1, a = 3/10, a force pa/2 at touchdown."""
    return _entry(name, *_on_floor(nodes, _TOUCHDOWN, "pinned", 0.0), force=_TOUCHDOWN / 2)


@entry("beam-clamped", n=49)
def _clamped_entry(name: str, nodes: int) -> Known:
    """Return a beam with clamped ends on a flat floor: EI = p = L = 1, a = 3/10, a force pa/3 at touchdown."""
    return _entry(name, *_on_floor(nodes, _TOUCHDOWN, "clamped", 0.0), force=_TOUCHDOWN / 3)


@entry("beam-with-tension", n=49)
def _tension_entry(name: str, nodes: int) -> Known:
    """Return a stretched beam with pinned ends on a flat floor: EI = p = L = 1, T = 100, a = 3/10."""
    tension = 100.0
    rate = np.sqrt(tension)
    _, _, d, e = _coefficients(_TOUCHDOWN, "pinned", tension)
    shear = rate**3 * (d * np.cosh(rate * _TOUCHDOWN) + e * np.sinh(rate * _TOUCHDOWN))
    return _entry(name, *_on_floor(nodes, _TOUCHDOWN, "pinned", tension), force=float(shear))


@entry("beam-on-foundation", n=49)
def _foundation_entry(name: str, nodes: int) -> Known:
    """Return a beam with pinned ends on springs over a flat floor: EI = p = L = 1, k = 1000, a = 3/10."""
    stiffness = 1000.0
    beam, deflection = _on_foundation(nodes, _TOUCHDOWN, "pinned", stiffness)
    third = _derivatives(np.array(_rate(stiffness) * _TOUCHDOWN))[3]
    shear = 2 * _rate(stiffness) ** 3 * float(_constants(_TOUCHDOWN, "pinned", stiffness) @ third)
    return _entry(name, beam, deflection, force=shear, pressure=1 - stiffness * float(beam.support[0]))


@entry("beam-between-floor-and-ceiling", n=99)
def _two_sided_entry(name: str, nodes: int) -> Known:
    """Return a beam pressed on a floor on its left and on a ceiling on its right: EI = 1, p = ±1, L = 2, a = 3/10."""
    if nodes % 2 == 0 or nodes < 3:
        raise ValueError(f"n must be odd and >= 3 for {name!r}, whose middle is a node, got {nodes}")
    beam, deflection = _between_floor_and_ceiling((nodes + 1) // 2, _TOUCHDOWN)
    x, spacing, ends = beam.lattice.node_x, beam.lattice.spacing, (_TOUCHDOWN, 1 - _TOUCHDOWN)
    reaction = sum(side * _pressed(x - start, spacing, _TOUCHDOWN / 2) for side, start in ((1, 0.0), (-1, 1.0)))
    return Known(
        name,
        beam,
        _MECHANICS,
        spacing,
        deflection=deflection,
        reaction=np.asarray(reaction),
        contact_area=2 * (ends[1] - ends[0]),
        distance=distance_to_points(*ends, *(1 + end for end in ends)),
    )


_TOUCHDOWN = 0.3
_MECHANICS = "Euler and Bernoulli's equation, EI w⁗ - T w″ + kw = p - ρ, solved piece by piece"


def _entry(name: str, beam: Beam, deflection: Vector, *, force: float, pressure: float = 1.0) -> Known:
    x, spacing, ends = beam.lattice.node_x, beam.lattice.spacing, (_TOUCHDOWN, 1 - _TOUCHDOWN)
    return Known(
        name,
        beam,
        _MECHANICS,
        spacing,
        deflection=deflection,
        reaction=_pressed(x, spacing, force, pressure),
        contact_area=ends[1] - ends[0],
        distance=distance_to_points(*ends),
    )


def _pressed(x: Vector, spacing: float, force: float, pressure: float = 1.0) -> Vector:
    """Return the reaction of a stretch between both touchdowns, with concentrated forces there."""
    ends = _TOUCHDOWN, 1 - _TOUCHDOWN
    concentrated = sum(shared(x, spacing, touchdown, force) for touchdown in ends)
    return np.asarray(pressure * covered(x, spacing, *ends) + concentrated)


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
