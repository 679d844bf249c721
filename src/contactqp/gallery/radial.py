"""Membranes whose answers depend on the radius alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector, integer_at_least
from ..geometry.frame import Frame
from ..geometry.lattice import Lattice
from ..models.membrane import Membrane
from ..models.mesh_membrane import MeshMembrane
from ..profiles.analytic import Hemisphere
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

    def load(x: Vector, y: Vector) -> Vector:
        square = x**2 + y**2
        beyond = square - radius**2
        return np.asarray(np.where(beyond <= 0, 8 * radius**2 * (1 - beyond), 4 * (2 * square + 2 * beyond)))

    lattice = Frame.rectangle(2.0, 2.0).lattice(2 / (nodes + 1))
    return Known(
        name,
        Membrane(lattice, tension=1.0, load=load, support=0.0, frame_height=height, upwards=True),
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
        Membrane(lattice, tension=1.0, load=2.0, support=0.0, frame_height=height, upwards=True),
        "Poisson's equation in the radius, Δu = 2 where u > 0; a common example for adaptive elements",
        lattice.spacing,
        deflection=height(lattice.node_x, lattice.node_y),
        reaction=_within(lattice, 1.0, 2.0),
        contact_area=math.pi,
        distance=_from_circle(1.0),
    )


_TOUCHDOWN = 0.5
_DISK_FLOOR = (1 - _TOUCHDOWN**2) / 4 + _TOUCHDOWN**2 / 2 * math.log(_TOUCHDOWN)
_POISSON = "Poisson's equation in the radius, T(w″ + w′/r) = ρ - p, solved piece by piece"


def _over_floor(x: Vector, y: Vector) -> Vector:
    r = np.maximum(np.hypot(x, y), _TOUCHDOWN)
    return np.asarray((1 - r**2) / 4 + _TOUCHDOWN**2 / 2 * np.log(r))


def _disk(name: str, lattice: Lattice) -> Known:
    return Known(
        name,
        Membrane(lattice, tension=1.0, load=1.0, support=_DISK_FLOOR),
        _POISSON,
        lattice.spacing,
        deflection=_over_floor(lattice.node_x, lattice.node_y),
        reaction=_within(lattice, _TOUCHDOWN, 1.0),
        contact_area=math.pi * _TOUCHDOWN**2,
        distance=_from_circle(_TOUCHDOWN),
    )


@entry("disk-over-floor", n=31)
def _fitted_entry(name: str, nodes: int) -> Known:
    """Return a disk over a flat floor, its arms ending on its contour: R = T = p = 1, touching within a = 1/2.

    w = p(R² - r²)/4T + (pa²/2T) ln(r/R) for r > a, and f = w(a).
    """
    return _disk(name, Frame.disk(1.0).lattice(2 / (nodes + 1), fitted=True))


@entry("disk-in-steps", n=31)
def _stepped_entry(name: str, nodes: int) -> Known:
    """Return the disk over a flat floor whose frame follows the lattice in steps: of first order."""
    return _disk(name, _in_steps(nodes))


def _in_steps(nodes: int) -> Lattice:
    """Return the lattice points within the unit disk: what `Frame.lattice` keeps, which would tell of its steps."""
    place = np.linspace(-1.0, 1.0, nodes + 2)
    inside = place**2 + place[:, None] ** 2 < 1 - 1e-9
    return Lattice(inside, 2 / (nodes + 1), (-1.0, -1.0))


@entry("disk-on-mesh", n=31)
def _mesh_entry(name: str, nodes: int) -> Known:
    """Return the disk over a flat floor on a mesh of triangles in rings; n nodes along its diameter, odd."""
    if nodes % 2 == 0:
        raise ValueError(f"n must be odd for {name!r}, whose centre is a node, got {nodes}")
    points, triangles = _rings((nodes + 1) // 2)
    model = MeshMembrane(points, triangles, 1.0, load=1.0, support=_DISK_FLOOR)
    inside = model.node_x**2 + model.node_y**2 < _TOUCHDOWN**2
    return Known(
        name,
        model,
        _POISSON,
        2 / (nodes + 1),
        deflection=_over_floor(model.node_x, model.node_y),
        reaction=np.where(inside, model.node_area, 0.0),
        contact_area=math.pi * _TOUCHDOWN**2,
        distance=_from_circle(_TOUCHDOWN),
    )


def _rings(count: int) -> tuple[Vector, NDArray[np.int64]]:
    """Return the mesh of the unit disk in so many rings of 6, 12, 18, ... points about its centre."""
    points: list[Any] = [np.zeros((1, 2))]
    triangles: list[Any] = []
    for ring in range(1, count + 1):
        angle = np.arange(6 * ring) * np.pi / (3 * ring)
        points.append(ring / count * np.column_stack([np.cos(angle), np.sin(angle)]))
        along = np.arange(6 * ring)
        sector, place = np.divmod(along, ring)
        outer, inner = 1 + 3 * ring * (ring - 1), 1 + 3 * (ring - 1) * (ring - 2) if ring > 1 else 0
        below = inner + (sector * (ring - 1) + place) % max(6 * (ring - 1), 1)
        triangles.append(np.column_stack([below, outer + along, outer + (along + 1) % (6 * ring)]))
        gaps = place < ring - 1
        after = inner + (sector * (ring - 1) + place + 1) % max(6 * (ring - 1), 1)
        triangles.append(np.column_stack([below, outer + (along + 1) % (6 * ring), after])[gaps])
    return np.concatenate(points), np.concatenate(triangles)


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
