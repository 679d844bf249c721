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
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    end = one_of(end, ("pinned", "clamped"), "end")  # type: ignore[assignment]
    spacing = 1 / (nodes + 1)
    touchdown = count * spacing
    distance = _distance_to_end(nodes, spacing)
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
    spacing, rate = 1 / (nodes + 1), (stiffness / 4) ** 0.25
    longest = 0.75 * np.pi if end == "pinned" else np.pi
    if not rate * count * spacing < longest:
        raise ValueError(
            f"contact_starts_after must be < {longest / (rate * spacing):.4g}, got {count}: a longer free part lies on "
            "so stiff a foundation before it comes down"
        )
    x = np.append(np.minimum(_distance_to_end(nodes, spacing), count * spacing), count * spacing)
    fallen = _sunk(x, count * spacing, end, stiffness, rate)
    beam = Beam(
        nodes=nodes,
        spacing=spacing,
        bending_stiffness=1.0,
        load=1.0,
        support=float(fallen[-1]),
        ends=end,
        foundation=float(stiffness),
    )
    return beam, fallen[:-1]


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
    one, fallen = beam_on_floor(half - 1, contact_starts_after)
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


def _distance_to_end(nodes: int, spacing: float) -> Vector:
    return np.asarray(np.minimum(np.arange(1, nodes + 1), nodes - np.arange(nodes)) * spacing)


def _sunk(x: Vector, a: float, end: End, stiffness: float, rate: float) -> Vector:
    def derivatives(place: Vector) -> list[Vector]:
        """Return the four functions, their slopes over β and their curvatures over 2β²."""
        sinh, cosh, sin, cos = (function(rate * place) for function in (np.sinh, np.cosh, np.sin, np.cos))
        functions = np.array([cosh * cos, cosh * sin, sinh * cos, sinh * sin])
        slopes = np.array(
            [sinh * cos - cosh * sin, cosh * cos + sinh * sin, cosh * cos - sinh * sin, cosh * sin + sinh * cos]
        )
        curvatures = np.array([-functions[3], functions[2], -functions[1], functions[0]])
        return [functions, slopes, curvatures]

    at_end, at_touchdown = derivatives(np.zeros(())), derivatives(np.array(a))
    rows = [at_end[0], at_end[2 if end == "pinned" else 1], at_touchdown[1], at_touchdown[2]]
    constants = np.linalg.solve(rows, [-1 / stiffness, 0.0, 0.0, 0.0])
    return np.asarray(1 / stiffness + constants @ derivatives(x)[0])


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
