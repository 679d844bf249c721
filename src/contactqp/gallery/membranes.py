"""Membranes with known answers, or of shapes that are hard on a solver."""

from __future__ import annotations

import math

import numpy as np

from ..foundation.checks import Vector, integer_at_least, open_interval, positive_number
from ..geometry.frame import Frame
from ..geometry.lattice import Lattice
from ..geometry.scikit_fem import circle
from ..models.membrane import Membrane
from ..models.mesh_membrane import MeshMembrane
from ..profiles.analytic import HillAndFloor

PAPER_LOADS = tuple(k / 100 for k in range(1, 11))
"""The ten dimensionless loads P' = pΔ/T of the paper's Table 1."""

PAPER_CORNERS = ((32.0, 0.0), (8.0, 24.0), (-8.0, 24.0), (-32.0, 0.0), (-8.0, -24.0), (8.0, -24.0))
"""Corners of the paper's hexagon in spacings: the doubly symmetric one with 45° sides and 1857 nodes."""


def paper_hexagon(load: float = 0.03) -> Membrane:
    """Return the paper's hexagonal membrane of 1857 nodes over a surrogate surface.

    The contour is the only doubly symmetric hexagon with 45° sides and lattice corners that holds 1857 nodes; the
    paper's rigid surface, its Fig. 4, is lost, and `HillAndFloor` stands in for it.

    Parameters
    ----------
    load : float
        P' = pΔ/T; the paper's are 0.01, 0.02, …, 0.10.

    Examples
    --------
    >>> paper_hexagon().lattice.size
    1857
    """
    return Membrane(Frame.polygon(PAPER_CORNERS).lattice(spacing=1.0), tension=1.0, load=load, support=HillAndFloor())


def bowl(nodes: int) -> Membrane:
    """Return a pressed membrane over a dented bowl on the unit square, ``nodes`` x ``nodes``.

    T = 1, p = 8, f = 0.15 + 0.3((x - 0.5)² + (y - 0.45)²) + 0.03 sin 9x sin 7y.

    Parameters
    ----------
    nodes : int
        Nodes along each side.

    Examples
    --------
    >>> bowl(15).lattice
    Lattice(225 nodes in 17 x 17, spacing=0.0625)
    """
    nodes = integer_at_least(nodes, 1, "nodes")
    lattice = Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(spacing=1 / (nodes + 1))
    return Membrane(lattice, tension=1.0, load=8.0, support=_dented_bowl)


def _dented_bowl(x: Vector, y: Vector) -> Vector:
    dents = 0.03 * np.sin(9 * x) * np.sin(7 * y)
    return np.asarray(0.15 + 0.3 * ((x - 0.5) ** 2 + (y - 0.45) ** 2) + dents)


def spiral(nodes: int) -> Membrane:
    """Return an unloaded membrane hung over a spiral ridge, whose contact set is as long as the lattice lets it be.

    Gräser and Kornhuber, *Multigrid methods for obstacle problems*, J. Comput. Math. 27 (2009): on (-1, 1)²
    above ψ = sin(2π/r + π/2 - θ) + r(r + 1)/(r - 2) - 3r + 3.6, ψ(0) = 3.6. Here T = 1, p = 0, and heights are
    deflections downwards: f = -ψ.

    Parameters
    ----------
    nodes : int
        Nodes along each side, >= 1.

    Examples
    --------
    >>> float(spiral(3).support.min())
    -3.6
    """
    nodes = integer_at_least(nodes, 1, "nodes")
    lattice = Frame.rectangle(2.0, 2.0).lattice(spacing=2 / (nodes + 1))
    return Membrane(lattice, tension=1.0, load=0.0, support=_spiral_support)


def _spiral_support(x: Vector, y: Vector) -> Vector:
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    summit = r == 0
    r[summit] = 1.0
    height = np.sin(2 * np.pi / r + np.pi / 2 - angle) + r * (r + 1) / (r - 2) - 3 * r + 3.6
    height[summit] = 3.6
    return np.asarray(-height)


def ball(nodes: int) -> tuple[Membrane, Vector]:
    """Return a membrane hung over a ball, and its exact continuous deflection at the nodes.

    Bueler, *PETSc for Partial Differential Equations* (2021), ch. 12: on (-2, 2)² above ψ = √(1 - r²) for
    r ≤ 0.9, continued by its tangent; u = -A ln r + B outside the contact disk of radius a, and on the frame. Here
    heights are deflections downwards: f = -ψ, w = -u.

    Parameters
    ----------
    nodes : int
        Nodes along each side, an odd number for one at the summit.

    Returns
    -------
    model : Membrane
    deflection : array, shape (nodes²,)

    Examples
    --------
    >>> model, exact = ball(31)
    >>> round(float(exact.min()), 12)
    -1.0
    """
    nodes = integer_at_least(nodes, 1, "nodes")
    lattice = Frame.rectangle(4.0, 4.0).lattice(spacing=4 / (nodes + 1))
    model = Membrane(
        lattice, tension=1.0, load=0.0, support=_ball_support, frame_height=lambda x, y: -_ball_height(x, y)
    )
    return model, -_ball_height(lattice.node_x, lattice.node_y)


_BALL_A, _BALL_B, _BALL_RADIUS = 0.680259411891719, 0.471519893402112, 0.697965148223374


def _ball_support(x: Vector, y: Vector) -> Vector:
    r = np.hypot(x, y)
    edge = 0.9
    height = math.sqrt(1 - edge**2)
    tangent = height - edge / height * (r - edge)
    return -np.where(r <= edge, np.sqrt(np.maximum(1 - r**2, 0.0)), tangent)


def _ball_height(x: Vector, y: Vector) -> Vector:
    r = np.hypot(x, y)
    outside = -_BALL_A * np.log(np.maximum(r, _BALL_RADIUS)) + _BALL_B
    return np.where(r <= _BALL_RADIUS, np.sqrt(np.maximum(1 - r**2, 0.0)), outside)


def disk_on_floor(spacing: float, contact_radius: float = 0.5) -> tuple[Membrane, Vector]:
    """Return a membrane over a disk, pressed on a flat floor, and its exact continuous deflection at the nodes.

    T = p = R = 1; the lattice is fitted to the circle. With a the radius of the contact disk

        w = p(R² - r²)/4T + (pa²/2T) ln(r/R)

    outside it, which comes down to the floor f = w(a) with slope zero.

    Parameters
    ----------
    spacing : float
    contact_radius : float
        a, between 0 and 1.

    Examples
    --------
    >>> membrane, exact = disk_on_floor(0.25)
    >>> round(float(exact.max()), 6)
    0.100857
    """
    spacing = positive_number(spacing, "spacing")
    lattice = Frame.disk(1.0).lattice(spacing, fitted=True)
    floor = _on_floor(np.zeros(1), np.zeros(1), contact_radius)[0]
    membrane = Membrane(lattice, tension=1.0, load=1.0, support=float(floor))
    return membrane, _on_floor(membrane.node_x, membrane.node_y, contact_radius)


def meshed_disk_on_floor(refinements: int, contact_radius: float = 0.5) -> tuple[MeshMembrane, Vector]:
    """Return the membrane of `disk_on_floor` on a mesh of triangles, and its exact deflection at the nodes.

    Parameters
    ----------
    refinements : int
        How often scikit-fem has halved the edges of its mesh of eight triangles, > 0.
    contact_radius : float
        a, between 0 and 1.

    Examples
    --------
    >>> membrane, exact = meshed_disk_on_floor(3)
    >>> membrane
    MeshMembrane(113 nodes, 256 triangles, 32 fixed points, tension=1, load=1, support=0.1009)
    """
    refinements = integer_at_least(refinements, 1, "refinements")
    floor = _on_floor(np.zeros(1), np.zeros(1), contact_radius)[0]
    membrane = MeshMembrane(*circle(refinements), tension=1.0, load=1.0, support=float(floor))
    return membrane, _on_floor(membrane.node_x, membrane.node_y, contact_radius)


def _on_floor(x: Vector, y: Vector, contact_radius: float) -> Vector:
    """Return the deflection at points of a disk of radius, tension and pressure one; in the middle it is the floor."""
    a = open_interval(contact_radius, 0.0, 1.0, "contact_radius")
    r = np.maximum(np.hypot(x, y), a)
    return np.asarray((1 - r * r) / 4 + a * a / 2 * np.log(r))


def l_shape_with_hole(spacing: float = 0.1) -> Membrane:
    """Return a membrane on an L-shaped frame with a square hole, over a tilted plane.

    Parameters
    ----------
    spacing : float
        Lattice spacing; the L is 2 x 2.

    Examples
    --------
    >>> l_shape_with_hole().lattice.parts
    1
    """
    spacing = positive_number(spacing, "spacing")
    frame = Frame.polygon(
        [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], holes=[[(0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7)]]
    )
    return Membrane(frame.lattice(spacing), tension=1.0, load=4.0, support=lambda x, y: 0.05 + 0.02 * x)


def islands() -> Membrane:
    """Return membranes on four disconnected lattices: a block, a one-node channel, a corner and a single node.

    Examples
    --------
    >>> islands().lattice.parts
    4
    """
    picture = """
        .............
        .#####..#..#.
        .#####..#....
        .#####..#.###
        .#####..#.#..
        ..###...#.#..
        .............
    """
    mask = np.array([[point == "#" for point in row] for row in picture.split()])
    return Membrane(Lattice(mask, 1.0), tension=1.0, load=0.5, support=0.4)


def orthotropic_ellipse(spacing: float = 0.1, *, fitted: bool = True) -> tuple[Membrane, Vector]:
    """Return a fabric over an ellipse, pulled harder along x, and its exact continuous deflection at the nodes.

    Semi-axes a = 1.5 and b = 1, T_x = 2, T_y = 1, p = 1, no support:
    w = p(1 - x²/a² - y²/b²)/(2(T_x/a² + T_y/b²)). Five-point differences of it are exact, so that the only error is
    that of the frame: none where its points have the heights of that surface, and of first order where they lie at
    height zero.

    Parameters
    ----------
    spacing : float
    fitted : bool
        Whether the frame's points have the heights of the exact deflection, continued beyond the ellipse.

    Examples
    --------
    >>> membrane, exact = orthotropic_ellipse(0.25)
    >>> membrane.tension, float(exact.max().round(4))
    ((2.0, 1.0), 0.2647)
    """
    spacing = positive_number(spacing, "spacing")
    columns, rows = (int(np.ceil(axis / spacing)) for axis in (_ELLIPSE_A, _ELLIPSE_B))
    x, y = (spacing * np.arange(-count, count + 1, dtype=np.float64) for count in (columns, rows))
    inside = _ellipse_height(x[None, :], y[:, None]) > 0
    lattice = Lattice(inside, spacing, (float(x[0]), float(y[0])))
    membrane = Membrane(
        lattice,
        tension=(_ELLIPSE_TENSION_X, 1.0),
        load=1.0,
        support=np.inf,
        frame_height=_ellipse_height if fitted else 0.0,
    )
    return membrane, _ellipse_height(lattice.node_x, lattice.node_y)


_ELLIPSE_A, _ELLIPSE_B, _ELLIPSE_TENSION_X = 1.5, 1.0, 2.0


def _ellipse_height(x: Vector, y: Vector) -> Vector:
    curvature = _ELLIPSE_TENSION_X / _ELLIPSE_A**2 + 1 / _ELLIPSE_B**2
    return np.asarray((1 - x**2 / _ELLIPSE_A**2 - y**2 / _ELLIPSE_B**2) / (2 * curvature))
