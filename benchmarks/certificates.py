"""How sharp certificates are, and what they cost.

    contactqp bench run benchmarks/certificates.py sharpness-1e-3 sharpness-1e-6 sharpness-1e-9
    contactqp bench run benchmarks/certificates.py cost

``sharpness`` and ``beyond`` tell bound over true error, for the answers of every backend to problems of the gallery,
and to matrices that are no M-matrices: meshes of triangles, beams, plates and random ones. The true error is known to
rounding from an enclosure that is sharp to rounding; answers that are as near as that are said to be so, and are no
part of the median. ``cost`` tells what the two efforts take beside a lexicographic sweep of over-relaxation, and the
largest memory that each takes on top of problem and answer, in vectors of the lattice's size.
"""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import contactqp as cq
from contactqp.benchmark import Phase, Spec

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from meshes import beam_on_floor, bowl_on_triangles, plate_over_bowl

ROUNDING = 1e-14
LARGEST_LINEAR_PROGRAM = 3000
EFFORTS = ("fast", "sharp")

LATTICES: Mapping[str, Callable[[], Any]] = {
    **{f"hexagon {load:g}": lambda load=load: cq.gallery.paper_hexagon(load) for load in (0.01, 0.03, 0.1)},
    "bowl 63": lambda: cq.gallery.bowl(63),
    "bowl 127": lambda: cq.gallery.bowl(127),
    "spiral 63": lambda: cq.gallery.spiral(63),
    "ball 33": lambda: cq.gallery.ball(33)[0],
    "L, hole": lambda: cq.gallery.l_shape_with_hole(0.05),
    "islands": lambda: cq.gallery.islands(),
    "cable 199": lambda: cq.gallery.cable_on_floor(199, 40)[0],
}


def random(size: int, seed: int) -> cq.ContactQP:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    matrix = root @ root.T + 10.0 ** rng.uniform(-2, 1) * np.eye(size)
    return cq.ContactQP((matrix + matrix.T) / 2, rng.normal(size=size))


MATRICES: Mapping[str, Callable[[], Any]] = {
    **{f"mesh {n}": lambda n=n: cq.ContactQP(*bowl_on_triangles(n)) for n in (31, 63)},
    **{f"beam {n}": lambda n=n: cq.ContactQP(*beam_on_floor(n)[:2]) for n in (50, 100, 200)},
    **{f"plate {n}": lambda n=n: cq.ContactQP(*plate_over_bowl(n)) for n in (15, 31)},
    **{
        f"dense {n}{letter}": lambda n=n, seed=seed: random(n, seed)
        for seed, (n, letter) in enumerate([(5, "a"), (20, "a"), (80, "a"), (80, "b"), (300, "a"), (300, "b")])
    },
}


class Known(NamedTuple):
    """What is solved, its problem, and an enclosure of its solution that is sharp to rounding."""

    model: Any
    problem: Any
    truth: cq.Certificate


def known(problems: Mapping[str, Callable[[], Any]]) -> Callable[[str], Known]:
    def build(name: str) -> Known:
        model = problems[name]()
        problem = model if isinstance(model, cq.ContactQP) else model.problem
        return Known(model, problem, cq.certify(problem, cq.solve(model, "active-set", tol=1e-12).gap))

    return build


def answer(backend: str, tol: float) -> Phase:
    def run(case: Known) -> cq.Solution:
        if backend == "mangasarian" and case.problem.size > LARGEST_LINEAR_PROGRAM:
            raise cq.UnsuitableProblemError(f"its linear program takes long above {LARGEST_LINEAR_PROGRAM} unknowns")
        return cq.solve(case.model, backend, tol=tol, on_failure="ignore")

    return Phase(run, once=True)


def over_error(case: Known, solution: cq.Solution) -> dict[str, Any]:
    """Return both bounds over the true error, where that is more than what is not known of it."""
    gap, truth = solution.gap, case.truth
    error = max(float((gap - truth.upper).max()), float((truth.lower - gap).max()), 0.0)
    if error <= max(ROUNDING * case.problem.gap_scale, float((truth.upper - truth.lower).max())):
        return {"said": "as near as is known"}
    ratios = {f"{effort}/error": cq.certify(case.problem, gap, effort=effort).gap_bound / error for effort in EFFORTS}
    return {"error": error, **ratios}


def sharpness(name: str, problems: Mapping[str, Callable[[], Any]], tol: str) -> Spec:
    return Spec(
        f"{name}-{tol}",
        f"bound over true error of each backend's answers at a tolerance of {tol}",
        known(problems),
        tuple(problems),
        {backend: answer(backend, float(tol)) for backend in cq.backend_names()},
        point="problem",
        tell=over_error,
        smoke="cable 199" if problems is LATTICES else "beam 50",
        largest_facts=tuple(f"{effort}/error" for effort in EFFORTS),
    )


class Costly(NamedTuple):
    """A problem, an answer, and what sweeps over its lattice."""

    problem: Any
    gap: Any
    sweeper: Any


def costly(nodes: int) -> Costly:
    from contactqp.methods.sor.sweepers import LatticeSweeper

    problem = cq.gallery.bowl(nodes).problem
    gap = cq.solve(problem, "multigrid", tol=1e-6).gap
    stencil = problem.stencil
    assert stencil is not None
    return Costly(problem, gap, LatticeSweeper(stencil, problem.layout, problem.q, gap, problem.bound_grids()))


def certified(effort: str) -> Callable[[Costly], str]:
    def run(case: Costly) -> str:
        cq.certify(case.problem, case.gap, effort=effort)
        return effort

    return run


def memory(case: Costly, result: object) -> dict[str, float]:
    """Return what a certificate holds at most, numpy's arrays included, over a vector of the lattice's size."""
    if result not in EFFORTS:
        return {}
    tracemalloc.start()
    cq.certify(case.problem, case.gap, effort=str(result))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return {"vectors": peak / case.gap.nbytes}


SPECS = (
    *(sharpness("sharpness", LATTICES, tol) for tol in ("1e-3", "1e-6", "1e-9")),
    *(sharpness("beyond", MATRICES, tol) for tol in ("1e-6", "1e-8", "1e-10")),
    Spec(
        "cost",
        "certificates of an answer, beside a sweep of over-relaxation",
        costly,
        (255, 511, 1023),
        {"sweep": lambda case: case.sweeper.sweep(1.0, 1), **{effort: certified(effort) for effort in EFFORTS}},
        size=lambda case: case.problem.size,
        tell=memory,
        repeat=25,
        smoke=31,
    ),
)
