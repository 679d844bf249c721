"""Contact on matrices that are no lattice's, against a linear solve and against Clarabel.

    contactqp bench run benchmarks/matrices.py                    # all, some minutes
    contactqp bench run benchmarks/matrices.py mesh beam          # some of them
    contactqp bench run benchmarks/matrices.py --largest 10000    # no larger numbers

The time of ``contact`` is that of making the problem, which proves what is needed of the matrix, and of `cq.solve` with
tol 1e-6; ``making`` is the first alone. The linear solve is pyamg's of Gx = -q to 1e-10 by conjugate gradients, by
smoothed aggregation or as Ruge and Stueben have it, set-up included, and ratios are over the faster one; without pyamg
(pip install '.[benchmarks]') it is left out.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

import contactqp as cq
from contactqp.benchmark import Phase, Spec, solution_facts

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from meshes import (
    assembled,
    beam_on_floor,
    bowl_in_space,
    bowl_on_a_checkerboard,
    bowl_on_triangles,
    membrane_over_bowl,
    plate_over_bowl,
)

LINEAR = ("aggregation", "Ruge-Stueben")
JUMPS = {"1": 1.0, "1e3": 1e3, "1e6": 1e6}
"""Coefficients in every other block, by what they are called."""
BLOCK = 32


class Given(NamedTuple):
    """A matrix, forces, and the matrix as pyamg takes it."""

    matrix: Any
    q: Any
    indexed: Any


def given(matrix: Any, q: Any) -> Given:
    indexed = sparse.csr_matrix(matrix)
    indexed.indptr, indexed.indices = (numbers.astype(np.int32) for numbers in (indexed.indptr, indexed.indices))
    return Given(matrix, q, indexed)


def contact(case: Given) -> cq.Solution:
    return cq.solve(cq.ContactQP(case.matrix, case.q), on_failure="ignore")


def making(case: Given) -> None:
    cq.ContactQP(case.matrix, case.q)


def linear(name: str) -> Phase:
    def run(case: Given) -> None:
        import pyamg

        solver = {LINEAR[0]: pyamg.smoothed_aggregation_solver, LINEAR[1]: pyamg.ruge_stuben_solver}[name]
        solver(case.indexed).solve(-case.q, tol=1e-10, accel="cg")

    return Phase(run, needs=("pyamg",))


def tell(case: Any, result: object) -> Mapping[str, Any]:
    if not isinstance(result, cq.Solution):
        return {}
    certificate = result.certificate
    undecided = {} if certificate is None else {"undecided": int(certificate.undecided.sum())}
    return {**solution_facts(result), **undecided}


def spec(name: str, summary: str, build: Callable[[Any], Given], sweep: tuple[int, ...], **known: Any) -> Spec:
    """Return a benchmark of contact on a matrix, beside a linear solve of it, if nothing else is said."""
    phases = {"contact": contact, "making": making, **{way: linear(way) for way in LINEAR}}
    common = {"phases": phases, "beside": LINEAR, "size": lambda case: case.q.size, "tell": tell}
    return Spec(name, summary, build, sweep, **{**common, **known})


def delaunay(nodes: int) -> Given:
    from scipy.spatial import Delaunay

    side = np.linspace(0, 1, int(np.sqrt(nodes)) + 1)
    low, high = np.zeros_like(side), np.ones_like(side)
    edges = [(side, low), (side, high), (low[1:-1], side[1:-1]), (high[1:-1], side[1:-1])]
    border = np.concatenate([np.column_stack(edge) for edge in edges])
    places = np.concatenate([border, np.random.default_rng(0).uniform(0, 1, (nodes, 2))])
    free = np.arange(places.shape[0]) >= border.shape[0]
    return given(*membrane_over_bowl(*assembled(places, Delaunay(places).simplices, free)))


def touchdown(case: Given, result: object) -> Mapping[str, Any]:
    """Return how far the touchdown lies from (24 EI f/p)^(1/4), in spacings."""
    facts = tell(case, result)
    if not isinstance(result, cq.Solution):
        return facts
    spacing = 10.0 / (case.q.size + 1)
    place = spacing * (1 + np.flatnonzero(result.gap == 0)[0])
    return {**facts, "touchdown off, spacings": float(abs(place - 12.0**0.25) / spacing)}


def disk(spacings: int) -> Given:
    problem = cq.Membrane(cq.Frame.disk(1.0).lattice(1 / spacings), 1.0, load=8.0, support=0.3).problem
    return given(problem.G, problem.q)


def membrane_on_a_checkerboard(nodes: int, jump: float) -> cq.Membrane:
    """Return the membrane whose stiffness is that of `bowl_on_a_checkerboard`."""
    number = np.arange(nodes) // BLOCK
    tension = np.where((number[:, None] + number) % 2 == 1, jump, 1.0)
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / (nodes + 1))
    support = 0.05 + 0.4 * ((lattice.node_x - 0.5) ** 2 + (lattice.node_y - 0.5) ** 2)
    return cq.Membrane(lattice, tension.ravel(), load=8.0, support=support)


class Jumping(NamedTuple):
    """The matrices of a checkerboard by their jumps."""

    nodes: int
    matrices: Mapping[float, Any]


def jumping(nodes: int) -> Jumping:
    return Jumping(nodes, {jump: bowl_on_a_checkerboard(nodes, BLOCK, jump) for jump in JUMPS.values()})


def by_matrix(jump: float) -> Callable[[Jumping], cq.Solution]:
    return lambda case: cq.solve(cq.ContactQP(*case.matrices[jump]), on_failure="ignore")


def by_lattice(jump: float) -> Callable[[Jumping], cq.Solution]:
    return lambda case: cq.solve(membrane_on_a_checkerboard(case.nodes, jump), "multigrid", on_failure="ignore")


OWN = {"phases": {"contact": contact, "making": making}, "beside": ()}

SPECS = (
    spec(
        "mesh",
        "linear elements on squares cut in two, nodes moved by a quarter of the spacing",
        lambda nodes: given(*bowl_on_triangles(nodes)),
        (149, 299, 999),
        smoke=15,
    ),
    spec(
        "delaunay",
        "linear elements on a Delaunay mesh of random nodes",
        delaunay,
        (100_000, 1_000_000),
        point="nodes",
        smoke=400,
    ),
    spec(
        "beam",
        "a beam on a floor, and how far its touchdown lies from the exact one",
        lambda nodes: given(*beam_on_floor(nodes)[:2]),
        (1000, 10_000, 100_000),
        point="nodes",
        smoke=100,
        **OWN | {"tell": touchdown},
    ),
    spec(
        "plate",
        "a plate over a bowl, by thirteen points",
        lambda nodes: given(*plate_over_bowl(nodes)),
        (63, 127),
        smoke=15,
        **OWN,
    ),
    spec("space", "seven points in a cube", lambda nodes: given(*bowl_in_space(nodes)), (64, 100), smoke=8),
    *(
        spec(
            f"jumps-{name}",
            f"five points between coefficients 1 and {name} in a checkerboard of blocks",
            lambda nodes, jump=jump: given(*bowl_on_a_checkerboard(nodes, BLOCK, jump)),
            (512,),
            smoke=64,
        )
        for name, jump in JUMPS.items()
    ),
    Spec(
        "jumps",
        "the same as matrices and by multigrid on the lattice, over what equal coefficients take",
        jumping,
        (512,),
        {
            **{f"matrix, {name}": by_matrix(jump) for name, jump in JUMPS.items()},
            **{f"lattice, {name}": by_lattice(jump) for name, jump in JUMPS.items()},
        },
        size=lambda case: case.nodes**2,
        smoke=64,
    ),
    spec(
        "disk",
        "the five points of a disk, given as a matrix",
        disk,
        (256,),
        point="spacings of its radius",
        smoke=16,
    ),
    Spec(
        "clarabel",
        "active sets and Clarabel on the smallest of the meshes",
        lambda nodes: cq.ContactQP(*bowl_on_triangles(nodes)),
        (149,),
        {"active-set": cq.solve, "clarabel": Phase(lambda problem: cq.solve(problem, "clarabel"), once=True)},
        size=lambda problem: problem.size,
        smoke=15,
    ),
)
