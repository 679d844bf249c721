"""Trial of the general backends' settings: which of those that certify is the fastest, over the default's time.

    contactqp bench run benchmarks/backend_settings.py osqp-settings --points hexagon,63,127,255

``backend_settings.txt`` is what the trial said when the settings were chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

import contactqp as cq
from contactqp.benchmark import Phase, Spec
from contactqp.gallery import bowl, paper_hexagon

VARIANTS: dict[str, list[dict[str, object]]] = {
    "osqp": [
        {},
        *({"rho": rho} for rho in (0.01, 0.03, 0.1, 1.0, 10.0)),
        *({"alpha": alpha} for alpha in (1.0, 1.6, 1.9)),
        {"polishing": False},
        {"polishing": False, "rho": 0.1, "alpha": 1.6, "eps": 1e-6},
        {"scaling": 0},
        {"adaptive_rho": False},
        {"check_termination": 10},
        {"check_termination": 100},
        {"eps": 1e-6},
        {"eps": 1e-8},
    ],
    "clarabel": [
        {},
        {"direct_solve_method": "faer"},
        {"equilibrate_enable": False},
        {"static_regularization_constant": 1e-7},
        {"static_regularization_constant": 1e-8},
        {"static_regularization_constant": 1e-10},
        {"eps": 1e-12},
        {"eps": 1e-13},
        {"eps": 1e-14},
        {"eps": 1e-15},
        {"eps": 1e-16},
    ],
    "mangasarian": [
        {},
        {"method": "highs-ipm"},
        {"presolve": True},
        {"cost": "barrier"},
        {"cost": "stiffness of the barrier"},
        {"cost": "random"},
        {"eps": 1e-7},
    ],
}
LARGEST = {"mangasarian": 63}
TIME_LIMIT = 20.0
"""Seconds a solve."""


class Given(NamedTuple):
    """A model, and the cost vectors that a linear program may be given."""

    model: cq.Membrane
    costs: Mapping[str, Any]


def given(point: str | int) -> Given:
    model = paper_hexagon() if isinstance(point, str) else bowl(point)
    barrier = model.problem.barrier
    assert barrier is not None
    random = np.random.default_rng(0).uniform(0.5, 2.0, model.size)
    return Given(model, {"barrier": barrier.v, "stiffness of the barrier": barrier.s, "random": random})


def solved(backend: str, variant: Mapping[str, object]) -> Callable[[Given], cq.Solution]:
    def run(case: Given) -> cq.Solution:
        options = {key: case.costs[str(value)] if key == "cost" else value for key, value in variant.items()}
        return cq.solve(case.model, backend, tol=1e-6, time_limit=TIME_LIMIT, on_failure="ignore", **options)

    return run


def trial(backend: str) -> Spec:
    def named(variant: Mapping[str, object]) -> str:
        return ", ".join(f"{key}={value}" for key, value in variant.items()) or "default"

    return Spec(
        f"{backend}-settings",
        f"{backend} with other settings, certified to 1e-6",
        given,
        ("hexagon", 63, 127),
        {
            named(variant): Phase(solved(backend, variant), largest=LARGEST.get(backend, np.inf))
            for variant in VARIANTS[backend]
        },
        point="hexagon, or nodes along a side of a bowl",
        repeat=2,
        smoke=15,
    )


SPECS = tuple(trial(backend) for backend in VARIANTS)
