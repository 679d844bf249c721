"""The problems that every explorer page has: the paper's hexagon, a disk, a rectangle, a cable, and a larger square."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from ..foundation.checks import Vector
from ..gallery.membranes import bowl, paper_hexagon
from ..geometry.frame import Frame
from ..models.cable import Cable
from ..models.membrane import Membrane
from ..profiles.analytic import Cone, Paraboloid, Plane
from .scenes import Scene, Shown

Shape = Callable[[Vector, Vector], Vector]

_LARGE = 129
"""Nodes along each side of the largest preset."""


def presets() -> Iterator[Scene]:
    """Yield the scenes, the paper's first."""
    yield _over("the paper's hexagon", paper_hexagon(), "hill and floor", _shapes(24.0, 1.25) | {_FLAT: Plane(1.25)})
    disk = Frame.disk(1.0).lattice(spacing=0.04)
    yield _over("disk", Membrane(disk, tension=1.0, load=1.5, support=0.2), _FLAT, _shapes(1.0, 0.2))
    rectangle = Frame.rectangle(3.0, 2.0).lattice(spacing=0.0625)
    yield _over("rectangle", Membrane(rectangle, tension=1.0, load=1.5, support=0.3), _FLAT, _shapes(1.0, 0.3))
    cable = Cable(span=100.0, start=-50.0, spacing=0.5, tension=1000.0, load=2.0, support=0.9)
    yield _over("cable", cable, _FLAT, _shapes(50.0, 0.9))
    yield Scene(f"square of {_LARGE} × {_LARGE} nodes", bowl(_LARGE), own="dented bowl")


_FLAT = "flat floor"


def _shapes(radius: float, depth: float) -> dict[str, Shape]:
    """Return surfaces for a frame of some radius, about a depth below it."""

    def waves(x: Vector, y: Vector) -> Vector:
        return np.asarray(depth * (1 - 0.4 * np.cos(2 * np.pi * x / radius) * np.cos(2 * np.pi * y / radius)))

    def bar(x: Vector, y: Vector) -> Vector:
        place = np.abs(x) / (0.3 * radius)
        return np.where(place <= 1, depth * (0.2 + 0.5 * place**2), np.inf)

    return {
        "dome": Paraboloid(0.2 * depth, radius**2 / (2 * depth)),
        "cone": Cone(0.1 * depth, 1.5 * depth / radius),
        "waves": waves,
        "round bar, nothing beside it": bar,
    }


def _over(name: str, model: Shown, own: str, shapes: Mapping[str, Shape]) -> Scene:
    """Return the scene of a model whose own support has a name, over other shapes, too."""
    x, y = model.node_x, model.node_y
    return Scene(name, model, {shape: np.asarray(surface(x, y), dtype=float) for shape, surface in shapes.items()}, own)
