"""Membranes whose answers depend on the radius alone."""

from __future__ import annotations

import math

import numpy as np

from ..foundation.checks import Vector, integer_at_least, open_interval, positive_number
from ..geometry.frame import Frame
from ..geometry.lattice import Lattice
from ..geometry.scikit_fem import circle
from ..models.membrane import Membrane
from ..models.mesh_membrane import MeshMembrane
from ..profiles.analytic import Hemisphere, Paraboloid, Uppermost
from .bent import CappedBall, Logarithmic, Mirrored, Quartic
from .catalogue import entry
from .known import Distance, Known


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
        lattice,
        tension=1.0,
        load=0.0,
        support=CappedBall(0.9),
        frame_height=Logarithmic(_BALL_A, 0.0, -_BALL_B, _BALL_RADIUS),
    )
    return model, -_ball_height(lattice.node_x, lattice.node_y)


_BALL_A, _BALL_B, _BALL_RADIUS = 0.680259411891719, 0.471519893402112, 0.697965148223374


def _ball_height(x: Vector, y: Vector) -> Vector:
    r = np.hypot(x, y)
    outside = -_BALL_A * np.log(np.maximum(r, _BALL_RADIUS)) + _BALL_B
    return np.where(r <= _BALL_RADIUS, np.sqrt(np.maximum(1 - r**2, 0.0)), outside)


@entry("ball", n=31)
def _ball_entry(name: str, nodes: int) -> Known:
    """Return Bueler's ball: a membrane hung over the unit ball on (-2, 2)², contact within r = 0.698.

    u = √(1 - r²) in contact, where it bears ρ = -TΔu = (2 - r²)/(1 - r²)^{3/2}.
    """
    model, deflection = ball(nodes)
    square = model.node_x**2 + model.node_y**2
    pressed = np.minimum(square, _BALL_RADIUS**2)
    return Known(
        name,
        model,
        "Bueler, PETSc for Partial Differential Equations, 2021, ch. 12",
        model.lattice.spacing,
        deflection=deflection,
        reaction=_within(model.lattice, _BALL_RADIUS, (2 - pressed) / (1 - pressed) ** 1.5),
        contact_area=math.pi * _BALL_RADIUS**2,
        distance=_from_circle(_BALL_RADIUS),
    )


def _within(lattice: Lattice, radius: float, pressure: Vector | float) -> Vector:
    """Return the forces of a pressure that acts within a circle."""
    inside = lattice.node_x**2 + lattice.node_y**2 < radius**2
    return np.asarray(np.where(inside, pressure, 0.0) * lattice.spacing**2)


def _from_circle(radius: float) -> Distance:
    def distance(x: Vector, y: Vector) -> Vector:
        return np.asarray(np.abs(np.hypot(x, y) - radius))

    return distance


@entry("constant-obstacle", n=31)
def _constant_entry(name: str, nodes: int) -> Known:
    """Return Nochetto, Siebert and Veeser's radial membrane over the plane: u = ((r² - R²)⁺)² on (-1, 1)², R = 0.7.

    Elevations; -Δu = f with f = -8R²(1 - (r² - R²)) for r < R, where u = 0 and ρ = -f, and else
    f = -4(2r² + 2(r² - R²)).
    """
    radius = 0.7

    def height(x: Vector, y: Vector) -> Vector:
        return np.asarray(np.maximum(x**2 + y**2 - radius**2, 0.0) ** 2)

    # Of the loads within the circle and beyond it the larger one acts, as they meet there: p = 8R²(1 + R² - r²) and
    # 16r² - 8R².
    within = Paraboloid(-8 * radius**2 * (1 + radius**2), 1 / (16 * radius**2))
    beyond = Paraboloid(8 * radius**2, -1 / 32)
    load = Mirrored(Uppermost(within, beyond))
    lattice = Frame.rectangle(2.0, 2.0).lattice(2 / (nodes + 1))
    return Known(
        name,
        Membrane(lattice, tension=1.0, load=load, support=0.0, frame_height=Quartic(-1.0, radius), upwards=True),
        "Nochetto, Siebert and Veeser, Pointwise a posteriori error control for elliptic obstacle problems, "
        "Numer. Math. 95 (2003), sect. 7.2",
        lattice.spacing,
        deflection=height(lattice.node_x, lattice.node_y),
        reaction=_within(lattice, radius, load(lattice.node_x, lattice.node_y)),
        contact_area=math.pi * radius**2,
        distance=_from_circle(radius),
    )


@entry("ring", n=31)
def _ring_entry(name: str, nodes: int) -> Known:
    """Return a ring that hangs about the unit disk: u = r²/2 - ln r - 1/2 for r > 1, else 0, on (-3/2, 3/2)², f = -2.

    Elevations; Δu = 2 beside the disk, and ρ = 2 on it.
    """

    def height(x: Vector, y: Vector) -> Vector:
        r = np.maximum(np.hypot(x, y), 1.0)
        return np.asarray(r**2 / 2 - np.log(r) - 0.5)

    lattice = Frame.rectangle(3.0, 3.0).lattice(3 / (nodes + 1))
    return Known(
        name,
        Membrane(
            lattice, tension=1.0, load=2.0, support=0.0, frame_height=Logarithmic(1.0, -0.5, 0.5, 1.0), upwards=True
        ),
        "Poisson's equation in the radius, Δu = 2 where u > 0; a common example for adaptive elements",
        lattice.spacing,
        deflection=height(lattice.node_x, lattice.node_y),
        reaction=_within(lattice, 1.0, 2.0),
        contact_area=math.pi,
        distance=_from_circle(1.0),
    )


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


_TOUCHDOWN = 0.5
_POISSON = "Poisson's equation in the radius, T(w″ + w′/r) = ρ - p, solved piece by piece"


def _disk(name: str, model: Membrane, deflection: Vector) -> Known:
    return Known(
        name,
        model,
        _POISSON,
        model.lattice.spacing,
        deflection=deflection,
        reaction=_within(model.lattice, _TOUCHDOWN, 1.0),
        contact_area=math.pi * _TOUCHDOWN**2,
        distance=_from_circle(_TOUCHDOWN),
    )


@entry("disk-over-floor", n=31)
def _fitted_entry(name: str, nodes: int) -> Known:
    """Return a disk over a flat floor, its arms ending on its contour: R = T = p = 1, touching within a = 1/2.

    w = p(R² - r²)/4T + (pa²/2T) ln(r/R) for r > a, and f = w(a).
    """
    return _disk(name, *disk_on_floor(2 / (nodes + 1), _TOUCHDOWN))


@entry("disk-in-steps", n=31)
def _stepped_entry(name: str, nodes: int) -> Known:
    """Return the disk over a flat floor whose frame follows the lattice in steps: of first order."""
    lattice = _in_steps(nodes)
    floor = float(_on_floor(np.zeros(1), np.zeros(1), _TOUCHDOWN)[0])
    model = Membrane(lattice, tension=1.0, load=1.0, support=floor)
    return _disk(name, model, _on_floor(model.node_x, model.node_y, _TOUCHDOWN))


def _in_steps(nodes: int) -> Lattice:
    """Return the lattice points within the unit disk: what `Frame.lattice` keeps, which would tell of its steps."""
    place = np.linspace(-1.0, 1.0, nodes + 2)
    inside = place**2 + place[:, None] ** 2 < 1 - 1e-9
    return Lattice(inside, 2 / (nodes + 1), (-1.0, -1.0))


@entry("disk-on-mesh", n=31)
def _mesh_entry(name: str, nodes: int) -> Known:
    """Return the disk over a flat floor on scikit-fem's mesh of triangles; n nodes along its diameter, 3, 7, 15, ..."""
    refinements = (nodes + 1).bit_length() - 2
    if nodes < 3 or 2 ** (refinements + 1) != nodes + 1:
        raise ValueError(f"n must be 3, 7, 15, 31, ... for {name!r}, whose edges are halved, got {nodes}")
    model, deflection = meshed_disk_on_floor(refinements, _TOUCHDOWN)
    inside = model.node_x**2 + model.node_y**2 < _TOUCHDOWN**2
    return Known(
        name,
        model,
        _POISSON,
        2 / (nodes + 1),
        deflection=deflection,
        reaction=np.where(inside, model.node_area, 0.0),
        contact_area=math.pi * _TOUCHDOWN**2,
        distance=_from_circle(_TOUCHDOWN),
    )


@entry("disk-over-hemisphere", n=31)
def _hemisphere_entry(name: str, nodes: int) -> Known:
    """Return a disk pressed on a hemisphere, its arms ending on its contour: R = T = p = 1, touching within a = 2/5.

    On the sphere of radius R its curvature bears ρ = p + T(2R² - r²)/(R² - r²)^{3/2}; beside it
    w = p(R² - r²)/4T + B ln(r/R), B = a²(1/√(R² - a²) + p/2T), and the summit is at d = w(a) - R + √(R² - a²).
    """
    touchdown = 0.4
    factor = touchdown**2 * (1 / math.sqrt(1 - touchdown**2) + 0.5)

    def beside(r: Vector) -> Vector:
        return np.asarray((1 - r**2) / 4 + factor * np.log(r))

    summit = float(beside(np.array(touchdown))) - 1 + math.sqrt(1 - touchdown**2)
    lattice = Frame.disk(1.0).lattice(2 / (nodes + 1), fitted=True)
    r = np.hypot(lattice.node_x, lattice.node_y)
    resting = np.minimum(r, touchdown) ** 2
    on_sphere = summit + 1 - np.sqrt(1 - resting)
    return Known(
        name,
        Membrane(lattice, tension=1.0, load=1.0, support=Hemisphere(summit, 1.0)),
        _POISSON,
        lattice.spacing,
        deflection=np.where(r < touchdown, on_sphere, beside(np.maximum(r, touchdown))),
        reaction=_within(lattice, touchdown, 1 + (2 - resting) / (1 - resting) ** 1.5),
        contact_area=math.pi * touchdown**2,
        distance=_from_circle(touchdown),
    )
