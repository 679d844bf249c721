"""Membranes with known answers, or of shapes that are hard on a solver."""

from __future__ import annotations

import numpy as np

from ..foundation.checks import Vector, integer_at_least, positive_number
from ..geometry.frame import Frame
from ..geometry.lattice import Lattice
from ..models.membrane import Membrane
from ..profiles.analytic import HillAndFloor, Paraboloid
from .bent import DentedBowl, HalfPower
from .catalogue import entry
from .known import Known
from .spiral_ridge import SpiralRidge

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


@entry("hexagon", n=63)
def _hexagon_entry(name: str, nodes: int) -> Known:
    """Return the paper's hexagon over a surrogate surface, P' = 0.03 at 63 nodes along it; no formula is known."""
    if (nodes + 1) % 8:
        raise ValueError(f"n must be 7, 15, 23, ... for {name!r}, whose corners are lattice points, got {nodes}")
    spacing = 64.0 / (nodes + 1)
    lattice = Frame.polygon(PAPER_CORNERS).lattice(spacing)
    model = Membrane(lattice, tension=1.0, load=0.03, support=HillAndFloor())
    source = (
        "Analysis of membranes stretched over a unilateral support, of the 1970s; the surface stands in for a lost one"
    )
    return Known(name, model, source, spacing)


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
    return Membrane(lattice, tension=1.0, load=8.0, support=DentedBowl())


@entry("bowl", n=31)
def _bowl_entry(name: str, nodes: int) -> Known:
    """Return a membrane pressed into a dented bowl; no formula is known."""
    return Known(name, bowl(nodes), "contactqp", 1 / (nodes + 1))


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
    return Membrane(lattice, tension=1.0, load=0.0, support=SpiralRidge())


@entry("spiral", n=31)
def _spiral_entry(name: str, nodes: int) -> Known:
    """Return an unloaded membrane over a spiral ridge, whose contact set is a long curve; no formula is known."""
    source = "Gräser and Kornhuber, Multigrid methods for obstacle problems, J. Comput. Math. 27 (2009)"
    return Known(name, spiral(nodes), source, 2 / (nodes + 1))


@entry("biactive", n=31)
def _biactive_entry(name: str, nodes: int) -> Known:
    """Return a membrane that everywhere just touches its support and is held by it nowhere: ψ = -(x² - 1)(y² - 1).

    T = 1 on (-1, 1)², elevations: u = ψ, p = Δψ = 2(2 - x² - y²) downwards, so that gap and reaction are both zero at
    every node. Five-point differences of ψ are exact, so that the discrete answer is the continuous one; in double
    precision no program can tell contact from a gap.
    """
    lattice = Frame.rectangle(2.0, 2.0).lattice(2 / (nodes + 1))
    model = Membrane(
        lattice,
        tension=1.0,
        load=Paraboloid(4.0, -1 / 4),
        support=lambda x, y: -(x**2 - 1) * (y**2 - 1),
        upwards=True,
    )
    source = "manufactured: strict complementarity fails at every node"
    return Known(
        name,
        model,
        source,
        lattice.spacing,
        deflection=-(lattice.node_x**2 - 1) * (lattice.node_y**2 - 1),
        reaction=np.zeros(lattice.size),
        exact=True,
    )


@entry("biactive-half", n=31)
def _half_entry(name: str, nodes: int) -> Known:
    """Return a membrane that lies on the plane without pressing on it in one half: u = x⁴ for x > 0, else 0.

    T = 1 on (-1, 1)², elevations; p = Δu = 12x² for x > 0, else 0, downwards. Gap and reaction are both zero where
    x ≤ 0. Five-point differences lift the membrane there by some Δ², so that the discrete one is in contact nowhere.
    """
    lattice = Frame.rectangle(2.0, 2.0).lattice(2 / (nodes + 1))
    model = Membrane(
        lattice,
        tension=1.0,
        load=HalfPower(12.0, 2),
        support=0.0,
        frame_height=HalfPower(-1.0, 4),
        upwards=True,
    )
    return Known(
        name,
        model,
        "manufactured: strict complementarity fails in one half",
        lattice.spacing,
        deflection=np.maximum(lattice.node_x, 0.0) ** 4,
        reaction=np.zeros(lattice.size),
    )


@entry("incidence-set", n=31)
def _incidence_entry(name: str, nodes: int) -> Known:
    """Return Outrata, Kočvara and Zowe's membrane at the first design: T = p = 1, f = 0.03; no formula is known.

    The unit square over a flat floor, zero on its frame; MacMPEC's incid-set1, whose design variables move frame and
    contact set, has the elevation -0.03 and the load -1.
    """
    lattice = Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(1 / (nodes + 1))
    model = Membrane(lattice, tension=1.0, load=1.0, support=0.03)
    source = (
        "Outrata, Kočvara and Zowe, Nonsmooth Approach to Optimization Problems with Equilibrium Constraints, 1998, "
        "sect. 9.4; MacMPEC, incid-set1"
    )
    return Known(name, model, source, lattice.spacing)


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


@entry("ellipse", n=29)
def _fabric_entry(name: str, nodes: int) -> Known:
    """Return a fabric over an ellipse, pulled harder along x, free of contact; n nodes along its longer axis."""
    return _ellipse_known(name, nodes, fitted=True)


@entry("ellipse-in-steps", n=29)
def _stepped_entry(name: str, nodes: int) -> Known:
    """Return the fabric over an ellipse whose frame follows the lattice in steps: of first order."""
    return _ellipse_known(name, nodes, fitted=False)


def _ellipse_known(name: str, nodes: int, *, fitted: bool) -> Known:
    spacing = 2 * _ELLIPSE_A / (nodes + 1)
    model, deflection = orthotropic_ellipse(spacing, fitted=fitted)
    return Known(
        name,
        model,
        "T_x w_xx + T_y w_yy = -p, solved by a quadratic",
        spacing,
        deflection=deflection,
        reaction=np.zeros(deflection.size),
        exact=fitted,
        contact_area=0.0,
    )


_ELLIPSE_A, _ELLIPSE_B, _ELLIPSE_TENSION_X = 1.5, 1.0, 2.0


def _ellipse_height(x: Vector, y: Vector) -> Vector:
    curvature = _ELLIPSE_TENSION_X / _ELLIPSE_A**2 + 1 / _ELLIPSE_B**2
    return np.asarray((1 - x**2 / _ELLIPSE_A**2 - y**2 / _ELLIPSE_B**2) / (2 * curvature))
