"""Families of problems that the benchmark is made of: each by its name and one number."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..gallery import ball, beam_on_floor, bowl, cable_on_floor, paper_hexagon, spiral
from ..geometry.frame import Frame
from ..models.base import ContactModel
from ..models.membrane import Membrane
from ..models.plate import Plate
from ..problem.contact_problem import ContactProblem
from ..problem.contact_qp import ContactQP

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


FAMILIES: Mapping[str, Family] = MappingProxyType(
    {
        family.name: family
        for family in (
            Family("hexagon", "the paper's membrane on 1857 nodes", "load in hundredths", _hexagon),
            Family("bowl", "a membrane over a dented bowl", "nodes along a side", bowl),
            Family("ball", "a membrane over a ball", "nodes along a side", lambda nodes: ball(nodes)[0]),
            Family("spiral", "a membrane over a spiral ridge", "nodes along a side", spiral),
            Family("between", "a membrane between floor and ceiling", "nodes along a side", _between),
            Family("jumps", "a membrane whose tension jumps by 1000", "nodes along a side", _jumps),
            Family("cable", "a cable on a floor", "nodes", lambda nodes: cable_on_floor(nodes, nodes // 3)[0]),
            Family("beam", "a beam on a floor", "nodes", lambda nodes: beam_on_floor(nodes, nodes // 5)[0]),
            Family("plate", "a plate over a bowl", "nodes along a side", _plate_on_bowl),
            Family("scattered", "springs between scattered points", "unknowns", _scattered),
            Family("dense", "a random matrix of condition 1e4", "unknowns", _dense),
        )
    }
)
