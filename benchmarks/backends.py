"""What each backend takes for an answer, warm and cold, and what solvers of other packages are good for.

    contactqp bench run benchmarks/backends.py warm --out FOLDER      # and draws FOLDER/warm.png
    contactqp bench run benchmarks/backends.py cold --phases "import and model,osqp,multigrid"
    contactqp bench run benchmarks/backends.py tightest --points qpsolvers:piqp,cvxpy:scs

``warm`` is the time of a solve in a process that has solved before; ``cold`` that of a fresh Python process, whose
``first answer`` is what it takes beyond one that imports the package and makes the model. ``backend="auto"`` rests on
both. ``tightest`` and ``others`` are the figures of the solvers that qpsolvers and CVXPY call: the power of ten that
the paper's hexagon is certified to at all its loads, and the seconds for a bowl.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import contactqp as cq
from contactqp.backends import family_names
from contactqp.benchmark import Phase, Spec
from contactqp.gallery import PAPER_LOADS, bowl, paper_hexagon

LARGEST = {"mangasarian": 63, "osqp": 255, "clarabel": 255, "mprgp": 511, "psor": 1023, "active-set": 2047}
LARGEST_COLD = 127
TIGHT = 1e-14
LIMIT = 100.0
"""Seconds for a solve by a solver of another package."""


class Given(NamedTuple):
    """A bowl, and its matrix alone."""

    model: cq.Membrane
    matrix: cq.ContactQP


def given(nodes: int) -> Given:
    model = bowl(nodes)
    return Given(model, cq.ContactQP(model.problem.G, model.problem.q))


def warm(backend: str) -> Phase:
    """Return the phase of a backend; active sets are given the matrix, for on a lattice they begin with multigrid."""
    part = "matrix" if backend == "active-set" else "model"
    return Phase(
        lambda case: cq.solve(getattr(case, part), backend, tol=1e-6, on_failure="ignore"),
        largest=LARGEST.get(backend, np.inf),
    )


class Fresh(NamedTuple):
    """A number of nodes, and the seconds of a process that makes the model only."""

    nodes: int
    idle: float


def process_seconds(nodes: int, call: str) -> float:
    code = f"import contactqp as cq; model = cq.gallery.bowl({nodes}); model.problem; {call}"
    started = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return time.perf_counter() - started


def idle(nodes: int) -> Fresh:
    return Fresh(nodes, min(process_seconds(nodes, "pass") for _ in range(3)))


def cold(backend: str) -> Callable[[Fresh], dict[str, float]]:
    call = f"cq.solve(model, {backend!r}, tol=1e-6, on_failure='ignore')"
    return lambda case: {"first answer s": process_seconds(case.nodes, call) - case.idle}


class Asked(NamedTuple):
    """A solver, and what it is asked about."""

    name: str
    models: list[cq.Membrane]


SMALL = " on a small bowl"


def asked(point: str) -> Asked:
    models = [bowl(7)] if point.endswith(SMALL) else [paper_hexagon(load) for load in PAPER_LOADS]
    return Asked(point.removesuffix(SMALL), models)


def tightest(case: Asked) -> dict[str, Any]:
    """Return the power of ten that all problems are certified to, and the largest bound."""
    name, models = case
    worst = max(cq.solve(model, name, tol=TIGHT, on_failure="ignore").relative_bound for model in models)
    if not np.isfinite(worst):
        return {"said": "no bound"}
    tol = 10.0 ** np.ceil(np.log10(max(worst, TIGHT)))
    again = [cq.solve(model, name, tol=tol, on_failure="ignore").status.ok for model in models]
    return {"tol": tol, "problems": sum(again), "largest bound": float(worst)}


def other(name: str) -> Phase:
    return Phase(lambda model: cq.solve(model, name, tol=1e-6, time_limit=LIMIT, on_failure="ignore"), once=True)


SPECS = (
    Spec(
        "warm",
        "a bowl certified to 1e-6 by each backend, active sets given the matrix",
        given,
        (15, 31, 63, 127, 255, 511, 1023, 2047, 4095),
        {name: warm(name) for name in cq.backend_names()},
        size=lambda case: case.model.size,
        repeat=lambda nodes: 3 if nodes < 200 else 1,
        smoke=7,
        drawn=True,
    ),
    Spec(
        "cold",
        "a fresh process that solves a bowl once to 1e-6, beside one that makes the model only",
        idle,
        (15, 31, 63, 127),
        {
            "import and model": lambda case: process_seconds(case.nodes, "pass"),
            **{name: Phase(cold(name), largest=LARGEST.get(name, LARGEST_COLD)) for name in cq.backend_names()},
        },
        smoke=7,
    ),
    Spec(
        "tightest",
        "what solvers of other packages certify the hexagon to at all ten loads",
        asked,
        tuple(family_names()),
        {"all loads": Phase(tightest, once=True)},
        point="solver",
        smoke=f"qpsolvers:piqp{SMALL}",
    ),
    Spec(
        "others",
        "a bowl certified to 1e-6 by solvers of other packages",
        bowl,
        (15, 31, 63, 127, 255),
        {name: other(name) for name in family_names()},
        size=lambda model: model.size,
        smoke=7,
    ),
)
