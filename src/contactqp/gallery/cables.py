"""Cables whose exact answers are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector, finite_number, integer_at_least, positive_number, real_array, refuse_non_finite
from ..models.cable import Cable
from ..profiles.analytic import Paraboloid, Plane, Uppermost
from .catalogue import entry
from .intervals import at_node, covered, distance_to_points
from .known import Known


def cable_on_floor(nodes: int, contact_starts_after: int) -> tuple[Cable, Vector]:
    """Return a cable pressed on a flat floor, and its exact deflection at the nodes.

    From each end the free part is the parabola w = p a x/T - p x²/(2T) up to x = a = √(2Tf/p), where it touches the
    floor f with slope zero. Three-point differences of a parabola are exact, so where x = a is a node the discrete
    answer is the continuous one.

    Parameters
    ----------
    nodes : int
        Nodes between the ends.
    contact_starts_after : int
        a in spacings; at most (nodes + 1)/2.

    Examples
    --------
    >>> cable, exact = cable_on_floor(nodes=9, contact_starts_after=2)
    >>> exact
    array([1.5, 2. , 2. , 2. , 2. , 2. , 2. , 2. , 1.5])
    """
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    return _on_floor(nodes, float(count), 1.0)


def _on_floor(nodes: int, touchdown: float, spacing: float) -> tuple[Cable, Vector]:
    cable = Cable(nodes=nodes, spacing=spacing, tension=1.0, load=1.0, support=touchdown**2 / 2)
    distance = np.minimum(_distance_to_end(cable), touchdown)
    return cable, distance * touchdown - distance**2 / 2


@entry("cable-on-floor", n=39)
def _floor_entry(name: str, nodes: int) -> Known:
    """Return a cable on a flat floor: T = p = L = 1, f = a²/2, a = 3/10, w = ax - x²/2 before it."""
    return _between_touchdowns(name, *_on_floor(nodes, _TOUCHDOWN, 1 / (nodes + 1)), pressure=1.0, exact=True)


_TOUCHDOWN = 0.3
_MECHANICS = "the equation of a cable, T w″ = ρ - p, solved piece by piece"


def _between_touchdowns(
    name: str,
    cable: Cable,
    deflection: Vector,
    *,
    pressure: float,
    exact: bool = False,
    touchdown: float = _TOUCHDOWN,
) -> Known:
    """Return the entry of a cable that lies on the ground but for a length beside each end, pressed evenly."""
    x, spacing = cable.lattice.node_x, cable.lattice.spacing
    ends = touchdown, cable.span - touchdown
    return Known(
        name,
        cable,
        _MECHANICS,
        spacing,
        deflection=deflection,
        reaction=pressure * covered(x, spacing, *ends),
        exact=exact and at_node(touchdown, spacing),
        contact_area=ends[1] - ends[0],
        distance=distance_to_points(*ends),
    )


def _nodes_and_touchdown(nodes: int, contact_starts_after: int) -> tuple[int, int]:
    nodes = integer_at_least(nodes, 1, "nodes")
    count = integer_at_least(contact_starts_after, 1, "contact_starts_after")
    if 2 * count > nodes + 1:
        raise ValueError(f"contact_starts_after must be <= (nodes + 1)/2 = {(nodes + 1) / 2:g}, got {count}")
    return nodes, count


def cable_on_parabola(nodes: int, contact_starts_after: int, radius: float) -> tuple[Cable, Vector]:
    """Return a cable pressed on a parabolic hill or into a bowl, and its exact deflection at the nodes.

    T = p = Δ = 1, and f = f₀ + (x - L)²/(2 radius) with L the middle. On the ground ρ = p + T/radius. From each end the
    free part is the parabola w = αx - px²/(2T) that touches the ground with its tangent at x = a:

        α = pa/T - (L - a)/radius,   f₀ = pa²/(2T) - (L² - a²)/(2 radius),

    and f - w = (p/T + 1/radius)(x - a)²/2 before it. Three-point differences of a parabola are exact, so with a node at
    x = a the discrete answer is the continuous one; the touchdown nodes carry half of what those on the ground do.

    Parameters
    ----------
    nodes : int
        Nodes between the ends.
    contact_starts_after : int
        a in spacings; at most (nodes + 1)/2.
    radius : float
        Radius of curvature of the ground (length): > 0 for a hill, < -1 = -T/p for a bowl that the cable sinks into.

    Examples
    --------
    >>> cable, exact = cable_on_parabola(nodes=7, contact_starts_after=2, radius=4.0)
    >>> exact
    array([1.   , 1.   , 0.625, 0.5  , 0.625, 1.   , 1.   ])
    """
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    if not (finite_number(radius, "radius") > 0 or radius < -1):
        raise ValueError(f"radius must be > 0 or < -1, got {radius:g}")
    return _on_parabola(nodes, float(count), 1.0, radius)


def _on_parabola(nodes: int, touchdown: float, spacing: float, radius: float) -> tuple[Cable, Vector]:
    middle = spacing * (nodes + 1) / 2
    summit = touchdown**2 / 2 - (middle**2 - touchdown**2) / (2 * radius)
    ground = Paraboloid(summit, radius, (middle, 0.0))
    cable = Cable(nodes=nodes, spacing=spacing, tension=1.0, load=1.0, support=ground)
    distance = _distance_to_end(cable)
    free = (touchdown - (middle - touchdown) / radius) * distance - distance**2 / 2
    return cable, np.where(distance < touchdown, free, cable.support)


@entry("cable-on-hill", n=39)
def _hill_entry(name: str, nodes: int) -> Known:
    """Return a cable on a parabolic hill: T = p = L = 1, f″ = 1, a = 3/10; the hill bears ρ = p + T f″ = 2."""
    return _between_touchdowns(name, *_on_parabola(nodes, _TOUCHDOWN, 1 / (nodes + 1), 1.0), pressure=2.0, exact=True)


@entry("cable-in-bowl", n=39)
def _bowl_entry(name: str, nodes: int) -> Known:
    """Return a cable in a parabolic bowl: T = p = L = 1, f″ = -1/2, a = 3/10; the bowl bears ρ = p + T f″ = 1/2."""
    return _between_touchdowns(name, *_on_parabola(nodes, _TOUCHDOWN, 1 / (nodes + 1), -2.0), pressure=0.5, exact=True)


def cable_on_posts(depths: ArrayLike, bay: int) -> tuple[Cable, Vector, Vector]:
    """Return a cable on posts with nothing between them, its exact deflection, and the exact reactions.

    T = p = Δ = 1; the ends are at height zero. Between its posts the cable hangs by ps(ℓ - s)/(2T) below the chord, and
    post k carries R = pℓ - T(2d_k - d_{k-1} - d_{k+1})/ℓ: half the load of the bays beside it, less the vertical force
    of the tension where the chords of these bays meet.

    Parameters
    ----------
    depths : array, shape (posts,)
        Heights d of the posts' tops, positive downwards (length).
    bay : int
        ℓ, distance of neighbouring posts, and of the outer ones from the ends, in spacings, >= 2.

    Returns
    -------
    cable : Cable
    deflection, reaction : array, shape (n,)

    Raises
    ------
    ValueError
        If there is a post that the cable would not touch.

    Examples
    --------
    >>> cable, deflection, reaction = cable_on_posts([1.0, 2.0], bay=4)
    >>> reaction[cable.supported]
    array([4.  , 3.25])
    """
    return _on_posts(real_array(depths, "depths"), integer_at_least(bay, 2, "bay"), 1.0)


def _on_posts(tops: Vector, bay: int, spacing: float) -> tuple[Cable, Vector, Vector]:
    if tops.ndim != 1:
        raise ValueError(f"depths must have one dimension, got shape {tops.shape}")
    if not tops.size:
        raise ValueError("depths must hold one depth or more")
    refuse_non_finite(tops, "depths")
    held, length = np.concatenate([[0.0], tops, [0.0]]), bay * spacing
    carried = length + np.diff(held, 2) / length
    if carried.min() < 0:
        post = int(np.argmin(carried))
        raise ValueError(
            f"depths[{post}] = {tops[post]:g} is too deep beside its neighbours: the cable would not touch"
        )
    nodes = bay * (tops.size + 1) - 1
    x = spacing * np.arange(1.0, nodes + 1)
    at_posts = bay * np.arange(1, tops.size + 1) - 1
    support, reaction = np.full(nodes, np.inf), np.zeros(nodes)
    support[at_posts], reaction[at_posts] = tops, carried
    cable = Cable(nodes=nodes, spacing=spacing, tension=1.0, load=1.0, support=support)
    along = spacing * (np.arange(1, nodes + 1) % bay)
    deflection = np.interp(x, length * np.arange(held.size), held) + along * (length - along) / 2
    return cable, deflection, reaction


@entry("cable-on-posts", n=39)
def _posts_entry(name: str, nodes: int) -> Known:
    """Return a cable on three posts with nothing between them: T = p = L = 1, tops at 1/80, 1/64 and 1/80."""
    if (nodes + 1) % 4 or nodes < 7:
        raise ValueError(f"n must be 7, 11, 15, ... for {name!r}, whose posts are nodes, got {nodes}")
    cable, deflection, reaction = _on_posts(np.array([1 / 80, 1 / 64, 1 / 80]), (nodes + 1) // 4, 1 / (nodes + 1))
    return Known(name, cable, _MECHANICS, 1 / (nodes + 1), deflection=deflection, reaction=reaction, exact=True)


def cable_on_foundation(nodes: int, contact_starts_after: int, stiffness: float = 1.0) -> tuple[Cable, Vector]:
    """Return a cable on an elastic foundation over a flat floor, and its exact continuous deflection at the nodes.

    T = p = L = 1, on the span (0, L). With λ = √(k/T) the free part from each end is
    w = p/k - (p/k - f) cosh λ(a - x); it touches the floor f = (p/k)(1 - 1/cosh λa) with slope zero at x = a.

    Parameters
    ----------
    nodes : int
        Nodes between the ends.
    contact_starts_after : int
        a in spacings; at most (nodes + 1)/2.
    stiffness : float
        kL²/T, > 0.

    Examples
    --------
    >>> cable, exact = cable_on_foundation(nodes=7, contact_starts_after=2, stiffness=4.0)
    >>> exact.round(4)
    array([0.0213, 0.0283, 0.0283, 0.0283, 0.0283, 0.0283, 0.0213])
    """
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    return _on_foundation(nodes, count / (nodes + 1), positive_number(stiffness, "stiffness"))


def _on_foundation(nodes: int, touchdown: float, stiffness: float) -> tuple[Cable, Vector]:
    spacing, rate = 1 / (nodes + 1), np.sqrt(stiffness)
    # p/k - f is 1/(k cosh λa), and f = 2 sinh²(λa/2)/(k cosh λa), which loses no digits where λa is small.
    floor = 2 * np.sinh(rate * touchdown / 2) ** 2 / (stiffness * np.cosh(rate * touchdown))
    cable = Cable(
        nodes=nodes, spacing=spacing, tension=1.0, load=1.0, support=float(floor), foundation=float(stiffness)
    )
    left = touchdown - _distance_to_end(cable)
    rest = 2 * np.sinh(rate * np.maximum(left, 0.0) / 2) ** 2 / (stiffness * np.cosh(rate * touchdown))
    return cable, floor - rest


@entry("cable-on-foundation", n=39)
def _foundation_entry(name: str, nodes: int) -> Known:
    """Return a cable on springs over a flat floor: T = p = L = 1, k = 4, a = 2/5; the floor bears ρ = p - kf."""
    cable, deflection = _on_foundation(nodes, 0.4, 4.0)
    return _between_touchdowns(name, cable, deflection, pressure=1 / np.cosh(2 * 0.4), touchdown=0.4)


def cable_of_varying_tension(nodes: int, contact_starts_after: int, slope: float = 2.0) -> tuple[Cable, Vector]:
    """Return a cable whose tension grows towards its middle, and its exact continuous deflection at the nodes.

    T = T₀(1 + αs) with the distance s from the nearer end, T₀ = p = L = 1; a flat floor. The free part from each end
    has w' = p(a - s)/T, w = (p/T₀)[(a + 1/α) ln(1 + αs)/α - s/α], and touches the floor f = w(a) with slope zero at
    s = a.

    Parameters
    ----------
    nodes : int
        Nodes between the ends.
    contact_starts_after : int
        a in spacings; at most (nodes + 1)/2.
    slope : float
        αL, > 0.

    Examples
    --------
    >>> cable, exact = cable_of_varying_tension(nodes=7, contact_starts_after=2)
    >>> exact.round(4)
    array([0.0212, 0.027 , 0.027 , 0.027 , 0.027 , 0.027 , 0.0212])
    """
    nodes, count = _nodes_and_touchdown(nodes, contact_starts_after)
    return _of_varying_tension(nodes, count / (nodes + 1), positive_number(slope, "slope"))


def _of_varying_tension(nodes: int, touchdown: float, slope: float) -> tuple[Cable, Vector]:
    def fallen(distance: Vector) -> Vector:
        return np.asarray((touchdown + 1 / slope) * np.log1p(slope * distance) / slope - distance / slope)

    cable = Cable(
        nodes=nodes,
        spacing=1 / (nodes + 1),
        tension=Uppermost(Plane(1.0, slope), Plane(1.0 + slope, -slope)),
        load=1.0,
        support=float(fallen(np.array(touchdown))),
    )
    return cable, fallen(np.minimum(_distance_to_end(cable), touchdown))


@entry("cable-of-varying-tension", n=39)
def _varying_entry(name: str, nodes: int) -> Known:
    """Return a cable pulled harder in its middle: T = 1 + 2s at s from the nearer end, p = L = 1, a = 2/5."""
    return _between_touchdowns(name, *_of_varying_tension(nodes, 0.4, 2.0), pressure=1.0, touchdown=0.4)


def cable_between_floor_and_ceiling(half: int, contact_starts_after: int) -> tuple[Cable, Vector]:
    """Return a cable pressed on a floor on its left and on a ceiling on its right, and its exact deflection.

    T = Δ = 1, p = 1 on the left half, -1 on the right, and 0 at the middle node; the floor lies as deep below the ends
    as the ceiling lies above them, f = pa²/2T. Contact on [a, L/2 - a] below and on [L/2 + a, L - a] above; in between
    w = f - p(x - L/2 + a)²/2T on the left of the middle, and the negative of that on the right. Three-point differences
    of a parabola are exact, so the discrete answer is the continuous one.

    Parameters
    ----------
    half : int
        L/2 in spacings.
    contact_starts_after : int
        a in spacings; at most half of ``half``.

    Examples
    --------
    >>> cable, exact = cable_between_floor_and_ceiling(half=5, contact_starts_after=2)
    >>> exact
    array([ 1.5,  2. ,  2. ,  1.5,  0. , -1.5, -2. , -2. , -1.5])
    """
    half = integer_at_least(half, 2, "half")
    count = integer_at_least(contact_starts_after, 1, "contact_starts_after")
    if 2 * count > half:
        raise ValueError(f"contact_starts_after must be <= half / 2 = {half / 2:g}, got {count}")
    return _between_floor_and_ceiling(half, float(count), 1.0)


def _between_floor_and_ceiling(half: int, touchdown: float, spacing: float) -> tuple[Cable, Vector]:
    floor = touchdown**2 / 2
    side = np.sign(half - np.arange(1.0, 2 * half))  # 0 at the middle node
    cable = Cable(nodes=side.size, spacing=spacing, tension=1.0, load=side, support=floor, ceiling=-floor)
    # Either half is that of a cable on a floor.
    from_end = np.minimum(np.arange(1, 2 * half), 2 * half - np.arange(1, 2 * half))
    distance = np.minimum(spacing * np.minimum(from_end, half - from_end), touchdown)
    return cable, side * (distance * touchdown - distance**2 / 2)


@entry("cable-between-floor-and-ceiling", n=39)
def _two_sided_entry(name: str, nodes: int) -> Known:
    """Return a cable pressed on a floor on its left and on a ceiling on its right: T = L = 1, p = ±1, a = 1/10."""
    if nodes % 2 == 0 or nodes < 3:
        raise ValueError(f"n must be odd and >= 3 for {name!r}, whose middle is a node, got {nodes}")
    spacing, touchdown = 1 / (nodes + 1), 0.1
    cable, deflection = _between_floor_and_ceiling((nodes + 1) // 2, touchdown, spacing)
    x, left, right = cable.lattice.node_x, (touchdown, 0.5 - touchdown), (0.5 + touchdown, 1 - touchdown)
    return Known(
        name,
        cable,
        _MECHANICS,
        spacing,
        deflection=deflection,
        reaction=covered(x, spacing, *left) - covered(x, spacing, *right),
        exact=at_node(touchdown, spacing),
        contact_area=2 * (0.5 - 2 * touchdown),
        distance=distance_to_points(*left, *right),
    )


def _distance_to_end(cable: Cable) -> Vector:
    x = cable.lattice.node_x
    return np.minimum(x - cable.start, cable.start + cable.span - x)
