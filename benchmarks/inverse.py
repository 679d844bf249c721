"""An inverse problem of any size: the form under a membrane, recovered from measured deflections by L-BFGS.

    contactqp bench run benchmarks/inverse.py                 # 512² unknown heights, minutes
    contactqp bench run benchmarks/inverse.py --points 127

It is the first problem of notebooks/10_design_and_inverse.ipynb, with one weight of smoothness. It runs once, because
it is long: told are also the seconds of an evaluation of J and its gradient, which is three contact problems and three
adjoint solves, and processor time, which on a machine that does other work tells more.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dstn, idstn
from scipy.optimize import minimize

import contactqp as cq
from contactqp.benchmark import Phase, Spec

Vector = NDArray[np.float64]

TENSION, PRESSURES, NOISE = 2.0, (1.0, 2.0, 4.0), 5.5e-4
ALPHA, STEPS = 1e5, 40
"""Weight of smoothness, and steps at most."""


def hidden_form(x: Vector, y: Vector) -> Vector:
    hollow, knob = np.hypot(x - 0.18, y - 0.10), np.hypot(x + 0.20, y + 0.12)
    trenches = np.where(np.abs(y) > 0.27, 0.06, 0.0)
    return 0.03 + 0.03 * np.exp(-(hollow**2) / 0.03) - 0.012 * np.exp(-(knob**2) / 0.008) + trenches


def smoother(rows: int, spacing: float, length: float) -> Callable[[Vector], Vector]:
    """Return (1 - length² ∇²)⁻¹ on a square, zero on its sides."""
    waves = (2 - 2 * np.cos(np.pi * np.arange(1, rows + 1) / (rows + 1))) / spacing**2
    damping = 1 / (1 + length**2 * (waves[:, None] + waves[None, :]))
    return lambda values: idstn(damping * dstn(values.reshape(rows, rows), type=1), type=1).ravel()


class Measured(NamedTuple):
    """A session, what is hidden and where it is touched, measured deflections, what is started from, and a smoother."""

    session: cq.Solver
    hidden: Vector
    touched: Any
    deflections: list[Vector]
    start: Vector
    smooth: Callable[[Vector], Vector]

    def misfit(self, z: Vector) -> tuple[float, Vector]:
        """Return J and its gradient."""
        form = self.start + self.smooth(z)
        value, gradient = 0.5 * ALPHA * float(z @ z), ALPHA * z
        for pressure, depths in zip(PRESSURES, self.deflections, strict=True):
            solution = self.session.solve(load=pressure, support=form)
            error = (solution.deflection - depths) / NOISE
            adjoint = solution.sensitivity().adjoint(deflection=error / NOISE, by="support", biactive="held")
            value += 0.5 * float(error @ error)
            gradient = gradient + self.smooth(adjoint["support"])
        return value, gradient


def measured(rows: int) -> Measured:
    lattice = cq.Frame.rectangle(1.0, 1.0).lattice(1 / (rows + 1))
    hidden = cq.Membrane(lattice, TENSION, load=1.0, support=hidden_form)
    session = cq.Solver(hidden, tol=1e-10)
    truth = [session.solve(load=pressure) for pressure in PRESSURES]
    touched = np.any([solution.contact for solution in truth], axis=0)
    rng = np.random.default_rng(4)
    deflections = [solution.deflection + NOISE * rng.normal(size=lattice.size) for solution in truth]
    smooth = smoother(rows, lattice.spacing, 0.05)
    case = Measured(
        session, np.array(hidden.support), touched, deflections, smooth(np.max(deflections, axis=0)), smooth
    )
    case.misfit(np.zeros(lattice.size))
    return case


class Recovered(NamedTuple):
    """What the minimisation came to."""

    form: Vector
    steps: int
    seconds: list[float]
    processor: float


def recover(case: Measured) -> Recovered:
    seconds: list[float] = []

    def misfit(z: Vector) -> tuple[float, Vector]:
        begun = time.perf_counter()
        found = case.misfit(z)
        seconds.append(time.perf_counter() - begun)
        return found

    processor = time.process_time()
    options = {"maxiter": STEPS, "maxcor": 20, "ftol": 1e-6}
    result = minimize(misfit, np.zeros(case.start.size), jac=True, method="L-BFGS-B", options=options)
    return Recovered(case.start + case.smooth(result.x), result.nit, seconds, time.process_time() - processor)


def tell(case: Measured, found: Recovered) -> dict[str, float]:
    answers = [case.session.solve(load=pressure, support=found.form) for pressure in PRESSURES]
    left = [answer.deflection - depths for answer, depths in zip(answers, case.deflections, strict=True)]
    error = 1e3 * (found.form - case.hidden)[case.touched]
    count = len(found.seconds)
    return {
        "steps": found.steps,
        "evaluations": count,
        "s an evaluation": float(np.median(found.seconds)),
        "processor s": found.processor,
        "processor s an evaluation": found.processor / count,
        "misfit over noise": float(np.sqrt(np.mean(np.square(left))) / NOISE),
        "error where touched (mm)": float(np.sqrt(np.mean(error**2))),
    }


SPECS = (
    Spec(
        "inverse",
        "the form under a membrane, recovered from measured deflections",
        measured,
        (512,),
        {"L-BFGS": Phase(recover, once=True)},
        size=lambda case: case.start.size,
        tell=tell,
        smoke=15,
    ),
)
