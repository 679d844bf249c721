"""Projected over-relaxation: the speed of its sweep, and sweeps with the automatic factor beside those of scanned ones.

    contactqp bench run benchmarks/relaxation.py sweep
    contactqp bench run benchmarks/relaxation.py factor        # steps of 0.05 on the hexagon, of 0.005 on the bowls
    contactqp bench run benchmarks/relaxation.py factor-fine   # steps of 0.01 on the hexagon

``sweep`` takes one core; its microseconds are those of an update of a node, and its ratios are over a compiled copy of
as many doubles. ``factor`` begins cold. The certified rule stands at 1e-6, the paper's two at a thousandth of the
spacing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

import contactqp as cq
from contactqp.benchmark import Phase, Spec
from contactqp.gallery import PAPER_LOADS, bowl, paper_hexagon

SWEEPS = 10
RULES = ("certified", "step", "residual")
SWEEP_LIMIT = 20_000


@njit("void(float64[::1], float64[::1])", cache=True)
def copy(source, target):  # type: ignore[no-untyped-def]
    for i in range(source.size):
        target[i] = source[i]


class Sweeping(NamedTuple):
    """Two sweepers over the same lattice, and arrays of its size."""

    lexicographic: Any
    red_black: Any
    source: Any
    target: Any


def sweeping(nodes: int) -> Sweeping:
    from contactqp.methods.sor.sweepers import LatticeSweeper

    problem, _ = bowl(nodes).problem.scaled()
    stencil = problem.stencil
    assert stencil is not None
    data = problem.layout, problem.q, np.zeros(problem.size), problem.bound_grids()
    source = np.ones(problem.size)
    sweepers = LatticeSweeper(stencil, *data), LatticeSweeper(stencil, *data, red_black=True)
    return Sweeping(*sweepers, source, np.empty_like(source))


def copies(case: Sweeping) -> None:
    for _ in range(SWEEPS):
        copy(case.source, case.target)


def solve(model: cq.Membrane, rule: str, **options: object) -> cq.Solution:
    if rule != "certified":
        options["stopping_length"] = 1e-3 * model.lattice.spacing
    return cq.solve(model, "psor", stopping=rule, on_failure="ignore", max_iter=SWEEP_LIMIT, **options)


def best_of_scan(model: cq.Membrane, rule: str, finest: float) -> tuple[float, int]:
    """Return the best factor and its sweeps; between the coarse factors about the best one the scan is refined."""
    coarse = np.round(np.arange(1.0, 2.0, 0.05), 2)
    sweeps = {float(beta): solve(model, rule, relaxation=float(beta)).iterations for beta in coarse}
    if finest < 0.05:
        about = min(sweeps, key=sweeps.__getitem__)
        for beta in np.round(np.arange(about - 0.05 + finest, min(about + 0.05, 2 - finest / 2), finest), 4):
            sweeps.setdefault(float(beta), solve(model, rule, relaxation=float(beta)).iterations)
    best = min(sweeps, key=sweeps.__getitem__)
    return best, sweeps[best]


class Scanned(NamedTuple):
    """A model, and the best factor and sweeps for each rule."""

    model: cq.Membrane
    best: dict[str, tuple[float, int]]


def scanned(point: str, on_hexagon: float) -> Scanned:
    kind, value = point.split()
    model, finest = (paper_hexagon(float(value)), on_hexagon) if kind == "hexagon" else (bowl(int(value)), 0.005)
    return Scanned(model, {rule: best_of_scan(model, rule, finest) for rule in RULES})


def automatic(rule: str) -> Phase:
    def run(case: Scanned) -> dict[str, float]:
        solution, (factor, sweeps) = solve(case.model, rule), case.best[rule]
        last = float(solution.termination.rsplit(" ", 1)[1])
        counts = {"factor": last, "sweeps": solution.iterations, "best factor": factor, "its sweeps": sweeps}
        return counts | {"over best": solution.iterations / sweeps}

    return Phase(run, once=True)


def factor(name: str, on_hexagon: float, points: tuple[str, ...]) -> Spec:
    return Spec(
        name,
        "sweeps with the automatic factor, beside the best of scanned ones",
        lambda point: scanned(point, on_hexagon),
        points,
        {rule: automatic(rule) for rule in RULES},
        point="problem",
        smoke="hexagon 0.1",
        largest_facts=("over best",),
    )


HEXAGONS = tuple(f"hexagon {load:g}" for load in PAPER_LOADS)


def passes(name: str) -> Callable[[Sweeping], object]:
    return lambda case: getattr(case, name).sweep(1.9, SWEEPS)


SPECS = (
    Spec(
        "sweep",
        f"{SWEEPS} sweeps of projected over-relaxation on one core, beside a copy of the same arrays",
        sweeping,
        (1023,),
        {"lexicographic": passes("lexicographic"), "red-black": passes("red_black"), "copy": copies},
        size=lambda case: SWEEPS * case.source.size,
        beside=("copy",),
        repeat=7,
        smoke=15,
    ),
    factor("factor", 0.05, (*HEXAGONS, "bowl 63", "bowl 127", "bowl 255")),
    factor("factor-fine", 0.01, HEXAGONS),
)
