"""Families of problems, each by its name and one number: what benchmarks, test sets and collections are made of.

Each of these takes some of the families, in sizes of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..geometry.frame import Frame
from ..models.base import ContactModel
from ..models.cable import Cable
from ..models.membrane import Membrane
from ..models.plate import Plate
from ..problem.contact_problem import ContactProblem
from ..problem.contact_qp import ContactQP
from .beams import beam_on_floor
from .cables import cable_between_floor_and_ceiling, cable_on_floor
from .catalogue import load
from .membranes import paper_hexagon

Subject = ContactModel | ContactProblem

_BLOCK, _JUMP = 8, 1e3
_GROUND, _NEIGHBOURS = 1e-3, 4


@dataclass(frozen=True)
class Family:
    """Problems of one kind.

    Attributes
    ----------
    name : str
    summary : str
        What they are, in a few words.
    number : str
        What the number stands for that a problem is made by.
    make : callable
        Of the number.
    """

    name: str
    summary: str
    number: str
    make: Callable[[int], Subject]


def _hexagon(hundredths: int) -> Membrane:
    return paper_hexagon(hundredths / 100)


def _between(nodes: int) -> Membrane:
    """Return a membrane that is pulled up and down in turn, between a floor and a ceiling."""
    lattice = Frame.rectangle(1.0, 1.0).lattice(1.0 / (nodes + 1))
    return Membrane(lattice, 1.0, load=_waves, support=0.1, ceiling=-0.1)


def _waves(x: Vector, y: Vector) -> Vector:
    return 40.0 * np.sin(3 * np.pi * x) * np.sin(2 * np.pi * y)


def _jumps(nodes: int) -> Membrane:
    """Return a bowl's membrane whose tension is a thousand times as large in every other square of a checkerboard."""
    lattice = Frame.rectangle(1.0, 1.0).lattice(1.0 / (nodes + 1))

    def tension(x: Vector, y: Vector) -> Vector:
        odd = (np.floor(_BLOCK * x) + np.floor(_BLOCK * y)) % 2
        return np.where(odd > 0, _JUMP, 1.0)

    return Membrane(lattice, tension, load=200.0, support=lambda x, y: 0.05 + 0.2 * ((x - 0.5) ** 2 + (y - 0.5) ** 2))


def _channel(nodes: int) -> Cable:
    """Return a cable in a channel; it has an odd number of nodes, so that one of them is in the middle."""
    return cable_between_floor_and_ceiling((nodes + 1) // 2, nodes // 5)[0]


def _plate_on_bowl(nodes: int) -> Plate:
    """Return a simply supported plate that is pressed into a bowl."""
    lattice = Frame.rectangle(1.0, 1.0, (0.5, 0.5)).lattice(1.0 / (nodes + 1))
    return Plate(lattice, 1.0, load=1600.0, support=_shallow, edge="simply supported")


def _shallow(x: Vector, y: Vector) -> Vector:
    return 0.02 + 0.1 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)


def _scattered(size: int) -> ContactQP:
    """Return springs of random stiffness between points in a square and their nearest neighbours, over a bowl."""
    load_modules("scipy.sparse", "scipy.spatial")
    from scipy import sparse
    from scipy.spatial import KDTree

    rng = np.random.default_rng(size)
    places = rng.uniform(size=(size, 2))
    _, near = KDTree(places).query(places, _NEIGHBOURS + 1)
    row, column = np.repeat(np.arange(size), _NEIGHBOURS), near[:, 1:].ravel()
    springs = sparse.coo_array((rng.uniform(0.2, 2.0, row.size), (row, column)), shape=(size, size)).tocsr()
    springs = springs + springs.T
    held = np.where(np.abs(places - 0.5).max(axis=1) > 0.47, 1.0, _GROUND)
    stiffness = (sparse.diags_array(springs.sum(axis=1) + held) - springs).tocsr()
    gap = 0.05 + 0.2 * ((places - 0.5) ** 2).sum(axis=1)
    return ContactQP(stiffness, 8.0 / size - stiffness @ gap)


def _dense(size: int) -> ContactQP:
    """Return a random matrix of condition 1e4 with entries of both signs, and forces of both signs."""
    rng = np.random.default_rng(size)
    axes, _ = np.linalg.qr(rng.normal(size=(size, size)))
    matrix = (axes * np.geomspace(1e-2, 1e2, size)) @ axes.T
    return ContactQP((matrix + matrix.T) / 2, rng.normal(size=size))


def _known(name: str, summary: str) -> Family:
    """Return the family of an entry of the catalogue."""
    return Family(name, summary, "nodes along a side", lambda nodes: load(name, nodes).model)


FAMILIES: Mapping[str, Family] = MappingProxyType(
    {
        family.name: family
        for family in (
            Family("hexagon", "the paper's membrane on 1857 nodes", "load in hundredths", _hexagon),
            _known("bowl", "a membrane over a dented bowl"),
            _known("ball", "a membrane over a ball"),
            _known("spiral", "a membrane over a spiral ridge"),
            _known("rough-05", "a membrane on rough ground"),
            _known("constant-obstacle", "a membrane on a plane, lifted outside a disk"),
            _known("incidence-set", "a membrane over a flat floor"),
            _known("biactive-half", "a membrane that touches half of a plane without pressing"),
            _known("OBSTCLAE", "Dembo and Tulowitzki's membrane over one obstacle"),
            _known("OBSTCLBL", "Dembo and Tulowitzki's membrane between two obstacles"),
            Family("between", "a membrane between floor and ceiling", "nodes along a side", _between),
            Family("jumps", "a membrane whose tension jumps by 1000", "nodes along a side", _jumps),
            _known("journal-bearing", "the film of oil in a journal bearing"),
            Family("cable", "a cable on a floor", "nodes", lambda nodes: cable_on_floor(nodes, nodes // 3)[0]),
            Family("channel", "a cable between floor and ceiling", "nodes, odd", _channel),
            Family("beam", "a beam on a floor", "nodes", lambda nodes: beam_on_floor(nodes, nodes // 5)[0]),
            Family("plate", "a plate over a bowl", "nodes along a side", _plate_on_bowl),
            Family("scattered", "springs between scattered points", "unknowns", _scattered),
            Family("dense", "a random matrix of condition 1e4", "unknowns", _dense),
        )
    }
)
"""By name."""
