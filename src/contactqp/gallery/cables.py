"""Cables whose exact answers are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.checks import Vector, finite_number, integer_at_least, positive_number, real_array, refuse_non_finite
from ..models.cable import Cable


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
    floor = count**2 / 2
    cable = Cable(nodes=nodes, spacing=1.0, tension=1.0, load=1.0, support=float(floor))
    x = cable.lattice.node_x
    distance = np.minimum(np.minimum(x, nodes + 1 - x), count)
    return cable, distance * count - distance**2 / 2


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
    middle = (nodes + 1) / 2
    summit = count**2 / 2 - (middle**2 - count**2) / (2 * radius)
    cable = Cable(
        nodes=nodes, spacing=1.0, tension=1.0, load=1.0, support=lambda x: summit + (x - middle) ** 2 / (2 * radius)
    )
    x = cable.lattice.node_x
    distance = np.minimum(x, nodes + 1 - x)
    free = (count - (middle - count) / radius) * distance - distance**2 / 2
    return cable, np.where(distance < count, free, cable.support)


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
    bay = integer_at_least(bay, 2, "bay")
    tops = real_array(depths, "depths")
    if tops.ndim != 1:
        raise ValueError(f"depths must have one dimension, got shape {tops.shape}")
    if not tops.size:
        raise ValueError("depths must hold one depth or more")
    refuse_non_finite(tops, "depths")
    held = np.concatenate([[0.0], tops, [0.0]])
    carried = bay + np.diff(held, 2) / bay
    if carried.min() < 0:
        post = int(np.argmin(carried))
        raise ValueError(
            f"depths[{post}] = {tops[post]:g} is too deep beside its neighbours: the cable would not touch"
        )
    nodes = bay * (tops.size + 1) - 1
    x = np.arange(1.0, nodes + 1)
    at_posts = bay * np.arange(1, tops.size + 1) - 1
    support, reaction = np.full(nodes, np.inf), np.zeros(nodes)
    support[at_posts], reaction[at_posts] = tops, carried
    cable = Cable(nodes=nodes, spacing=1.0, tension=1.0, load=1.0, support=support)
    along = x % bay
    deflection = np.interp(x, bay * np.arange(held.size), held) + along * (bay - along) / 2
    return cable, deflection, reaction


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
    stiffness = positive_number(stiffness, "stiffness")
    spacing, rate = 1 / (nodes + 1), np.sqrt(stiffness)
    touchdown = count * spacing
    # p/k - f is 1/(k cosh λa), and f = 2 sinh²(λa/2)/(k cosh λa), which loses no digits where λa is small.
    floor = 2 * np.sinh(rate * touchdown / 2) ** 2 / (stiffness * np.cosh(rate * touchdown))
    cable = Cable(
        nodes=nodes, spacing=spacing, tension=1.0, load=1.0, support=float(floor), foundation=float(stiffness)
    )
    left = touchdown - _distance_to_end(cable)
    rest = 2 * np.sinh(rate * np.maximum(left, 0.0) / 2) ** 2 / (stiffness * np.cosh(rate * touchdown))
    return cable, floor - rest


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
    slope = positive_number(slope, "slope")
    spacing = 1 / (nodes + 1)
    touchdown = count * spacing

    def fallen(distance: Vector) -> Vector:
        return np.asarray((touchdown + 1 / slope) * np.log1p(slope * distance) / slope - distance / slope)

    cable = Cable(
        nodes=nodes,
        spacing=spacing,
        tension=lambda x: 1 + slope * np.minimum(x, 1 - x),
        load=1.0,
        support=float(fallen(np.array(touchdown))),
    )
    return cable, fallen(np.minimum(_distance_to_end(cable), touchdown))


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
    floor = count**2 / 2
    cable = Cable(
        nodes=2 * half - 1,
        spacing=1.0,
        tension=1.0,
        load=lambda x: np.sign(half - x),
        support=floor,
        ceiling=-floor,
    )
    # Either half is that of a cable on a floor.
    from_middle = np.abs(cable.lattice.node_x - half)
    distance = np.minimum(np.minimum(from_middle, half - from_middle), count)
    return cable, np.sign(half - cable.lattice.node_x) * (distance * count - distance**2 / 2)


def _distance_to_end(cable: Cable) -> Vector:
    x = cable.lattice.node_x
    return np.minimum(x - cable.start, cable.start + cable.span - x)
