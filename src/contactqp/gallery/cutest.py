"""Membranes of the collection CUTEst whose optimal energies are published: torsion, obstacles, a journal bearing.

Gould, Orban and Toint, *CUTEst: a constrained and unconstrained testing environment*, 2015; the values are those of its
files. A grid of P points along a side, the frame's among them, has P - 2 nodes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from ..errors import ContactWarning
from ..foundation.checks import Vector
from ..geometry.frame import Frame
from ..models.membrane import Membrane
from ..profiles.analytic import Plane, Uppermost
from .bent import Mirrored
from .catalogue import entry
from .known import Known, Quoted

Printed = Mapping[int, str]
"""Optimal energies as they are printed, by the nodes along a side."""


def _energy(printed: Printed, nodes: int, name: str) -> Quoted | None:
    text = printed.get(nodes)
    if text is None:
        return None
    digits = len(text.split(".")[1])
    return Quoted(float(text), max(0.6 * 10.0**-digits, _OF_SOLVERS), f"CUTEst, {name}.SIF")


_OF_SOLVERS = 2e-8
"""What the files' values, which were computed by solvers to a tolerance, are worth where more digits are printed."""


_Field = Callable[[Vector, Vector], Vector]


def _arms_to_frame_halved(spacing: float) -> tuple[_Field, _Field]:
    """Return the tension along x and along y of an arm by its middle: one, but half where it ends on the frame."""

    def along(place: Vector) -> Vector:
        return np.asarray(np.where(np.minimum(place, 1 - place) < 0.75 * spacing, 0.5, 1.0))

    return lambda x, y: along(x), lambda x, y: along(y)


_MORE_TORALDO = "Moré and Toraldo, SIAM J. Optim. 1 (1991); CUTEst"

_FORCE = {"1": 5.0, "2": 5.0, "3": 10.0, "4": 10.0, "5": 20.0, "6": 20.0}
_FORCE |= dict(zip("ABCDEF", _FORCE.values(), strict=True))
"""c by the last character of the name: two names differ by where a method starts, which is no part of the problem."""

_TORSION: Mapping[float, Printed] = MappingProxyType(
    {
        5.0: {2: "-0.51851852", 8: "-0.49234185", 20: "-0.45608771"},
        10.0: {2: "-1.2592592567", 8: "-1.2705380252", 20: "-1.2422498827"},
        20.0: {2: "-2.7407407353", 8: "-2.8971193358", 20: "-2.8847068155"},
    }
)
_SIDES = (2, 8, 20, 30, 72, 98, 120)
"""Nodes along a side of the grids of Q = 2, 5, 11, 16, 37, 50 and 61."""

_TORSION_OF_MINPACK: Mapping[float, Printed] = MappingProxyType(
    {
        force: dict(zip(_SIDES, printed.split(), strict=True))
        for force, printed in {
            5.0: "-0.30864 -0.40570 -0.41611 -0.41740 -0.41830 -0.41839 -0.41842",
            10.0: "-1.0370 -1.1766 -1.1995 -1.2023 -1.2042 -1.2044 -1.2045",
            20.0: "-2.5185 -2.7984 -2.8406 -2.8461 -2.8502 -2.8507 -2.8508",
        }.items()
    }
)


def _torsion(name: str, nodes: int, *, halved: bool, printed: Mapping[float, Printed]) -> Known:
    if nodes % 2:
        raise ValueError(f"n must be even for {name!r}, whose grids have 2Q points along a side, got {nodes}")
    spacing, force = 1 / (nodes + 1), _FORCE[name[-1]]

    to_frame = Uppermost(Plane(0.0, 1.0), Plane(1.0, -1.0), Plane(0.0, 0.0, 1.0), Plane(1.0, 0.0, -1.0))
    lattice = Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(spacing)
    model = Membrane(
        lattice,
        tension=_arms_to_frame_halved(spacing) if halved else 1.0,
        load=force,
        support=to_frame,
        ceiling=Mirrored(to_frame),
    )
    return Known(name, model, _MORE_TORALDO, spacing, energy=_energy(printed[force], nodes, name))


@entry(*(f"TORSION{k}" for k in "123456"), n=20)
def _torsion_entry(name: str, nodes: int) -> Known:
    """Return elastic-plastic torsion of a square bar: T = 1, c = 5, 10 or 20, |u| ≤ distance to the boundary.

    The energies of the arms are summed node by node over the nodes, so that an arm to the frame counts half.
    """
    return _torsion(name, nodes, halved=True, printed=_TORSION)


@entry(*(f"TORSION{k}" for k in "ABCDEF"), n=20)
def _torsion_of_minpack_entry(name: str, nodes: int) -> Known:
    """Return elastic-plastic torsion of a square bar as in MINPACK-2, by five-point differences: c = 5, 10 or 20."""
    return _torsion(name, nodes, halved=False, printed=_TORSION_OF_MINPACK)


_OBSTACLE: Mapping[str, Printed] = MappingProxyType(
    {
        "A": {2: "0.753659753", 8: "1.397897560", 21: "1.678027027", 30: "1.748270032"},
        "B": {2: "-0.0081108", 8: "2.87503823", 21: "6.51932527", 30: "6.88708670"},
    }
)


@entry("OBSTCLAE", "OBSTCLAL", "OBSTCLBL", "OBSTCLBM", "OBSTCLBU", n=21)
def _obstacle_entry(name: str, nodes: int) -> Known:
    """Return Dembo and Tulowitzki's membrane on the unit square, A over one obstacle, B between two; a load of -1.

    Elevations: A has u ≥ sin 3.2x sin 3.3y (and an upper bound of 2000, out of reach), B has
    s³ ≤ u ≤ s² + 0.02 with s = sin 9.2x sin 9.3y; x runs along the rows that the files number first. An arm to the
    frame counts half, as in TORSION1. The last letter says where a method starts, which is no part of the problem.
    """
    spacing, one_sided = 1 / (nodes + 1), name[-2] == "A"

    def first(x: Vector, y: Vector) -> Vector:
        return np.asarray(np.sin(3.2 * x) * np.sin(3.3 * y))

    def second(x: Vector, y: Vector) -> Vector:
        return np.asarray(np.sin(9.2 * x) * np.sin(9.3 * y))

    lattice = Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(spacing)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContactWarning)  # of A, which has the obstacle above the frame in a corner
        model = Membrane(
            lattice,
            tension=_arms_to_frame_halved(spacing),
            load=-1.0,
            support=first if one_sided else lambda x, y: second(x, y) ** 3,
            ceiling=None if one_sided else lambda x, y: second(x, y) ** 2 + 0.02,
            upwards=True,
        )
    source = "Dembo and Tulowitzki, WP 71, Yale University, 1983; Moré and Toraldo, SIAM J. Optim. 1 (1991); CUTEst"
    return Known(name, model, source, spacing, energy=_energy(_OBSTACLE[name[-2]], nodes, name))


_BEARING: Printed = MappingProxyType(
    {2: "-0.22474", 8: "-0.17896", 21: "-0.18005", 30: "-0.18030", 73: "-0.18055", 98: "-0.18057"}
)


@entry("JNLBRNG1", "journal-bearing", n=30)
def _bearing_entry(name: str, nodes: int) -> Known:
    """Return a journal bearing of eccentricity 1/10: its oil cavitates where the pressure would be negative.

    Reynolds' equation -∇·(h³∇u) = ε sin θ, u ≥ 0, on (0, 2π) x (0, 20) with h = 1 + ε cos θ, u = 0 on the boundary: a
    membrane of tension h³ over a flat support. The grid has other spacings in θ and along the axis, δ and η: along y it
    is drawn with δ, T_x = h³ η/δ, T_y = h³ δ/η, p = ε sin θ η/δ. MINPACK-2's linear elements on halved rectangles take
    for h³ the mean of both ends along θ, and along the axis (4h³(θ) + h³(θ + δ) + h³(θ - δ))/6.
    """
    eccentricity, spacing = 0.1, 2 * np.pi / (nodes + 1)
    ratio = 20 / (nodes + 1) / spacing

    def cubed(theta: Vector) -> Vector:
        return np.asarray((1 + eccentricity * np.cos(theta)) ** 3)

    def around(x: Vector, y: Vector) -> Vector:
        return np.asarray(ratio * (cubed(x - spacing / 2) + cubed(x + spacing / 2)) / 2)

    def along(x: Vector, y: Vector) -> Vector:
        return np.asarray((4 * cubed(x) + cubed(x + spacing) + cubed(x - spacing)) / 6 / ratio)

    lattice = Frame.rectangle(2 * np.pi, 2 * np.pi, center=(np.pi, np.pi)).lattice(spacing)
    model = Membrane(
        lattice,
        tension=(around, along),
        load=lambda x, y: -eccentricity * np.sin(x) * ratio,
        support=0.0,
        upwards=True,
    )
    return Known(name, model, _MORE_TORALDO, spacing, energy=_energy(_BEARING, nodes, "JNLBRNG1"))
