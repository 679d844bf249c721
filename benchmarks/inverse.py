"""An inverse problem of any size: the form under a membrane, recovered from measured deflections by L-BFGS.

    python benchmarks/inverse.py                # 512² unknown heights, minutes
    python benchmarks/inverse.py --rows 127

It is the first problem of notebooks/10_design_and_inverse.ipynb, with one weight of smoothness. Times are those of one
run, because it is long: of the whole minimisation, and of an evaluation of J and its gradient, which is three contact
problems and three adjoint solves. On a machine that does other work, too, processor time tells more.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dstn, idstn
from scipy.optimize import minimize

import contactqp as cq

Vector = NDArray[np.float64]

TENSION, PRESSURES, NOISE = 2.0, (1.0, 2.0, 4.0), 5.5e-4


def hidden_form(x: Vector, y: Vector) -> Vector:
    hollow, knob = np.hypot(x - 0.18, y - 0.10), np.hypot(x + 0.20, y + 0.12)
    trenches = np.where(np.abs(y) > 0.27, 0.06, 0.0)
    return 0.03 + 0.03 * np.exp(-(hollow**2) / 0.03) - 0.012 * np.exp(-(knob**2) / 0.008) + trenches


def smoother(rows: int, spacing: float, length: float) -> Callable[[Vector], Vector]:
    """Return (1 - length² ∇²)⁻¹ on a square, zero on its sides."""
    waves = (2 - 2 * np.cos(np.pi * np.arange(1, rows + 1) / (rows + 1))) / spacing**2
    damping = 1 / (1 + length**2 * (waves[:, None] + waves[None, :]))
    return lambda values: idstn(damping * dstn(values.reshape(rows, rows), type=1), type=1).ravel()


def main(rows: int, alpha: float, steps: int) -> None:
    lattice = cq.Frame.rectangle(1.0, 1.0).lattice(1 / (rows + 1))
    hidden = cq.Membrane(lattice, TENSION, load=1.0, support=hidden_form)
    session = cq.Solver(hidden, tol=1e-10)
    truth = [session.solve(load=pressure) for pressure in PRESSURES]
    touched = np.any([solution.contact for solution in truth], axis=0)
    rng = np.random.default_rng(4)
    measured = [solution.deflection + NOISE * rng.normal(size=lattice.size) for solution in truth]
    smooth = smoother(rows, lattice.spacing, 0.05)
    start = smooth(np.max(measured, axis=0))
    seconds: list[float] = []

    def misfit(z: Vector) -> tuple[float, Vector]:
        begun = time.perf_counter()
        form = start + smooth(z)
        value, gradient = 0.5 * alpha * float(z @ z), alpha * z
        for pressure, depths in zip(PRESSURES, measured, strict=True):
            solution = session.solve(load=pressure, support=form)
            error = (solution.deflection - depths) / NOISE
            adjoint = solution.sensitivity().adjoint(deflection=error / NOISE, by="support", biactive="held")
            value += 0.5 * float(error @ error)
            gradient = gradient + smooth(adjoint["support"])
        seconds.append(time.perf_counter() - begun)
        return value, gradient

    misfit(np.zeros(lattice.size))
    seconds.clear()
    begun, processor = time.perf_counter(), time.process_time()
    options = {"maxiter": steps, "maxcor": 20, "ftol": 1e-6}
    result = minimize(misfit, np.zeros(lattice.size), jac=True, method="L-BFGS-B", options=options)
    whole, processor = time.perf_counter() - begun, time.process_time() - processor
    form = start + smooth(result.x)
    answers = [session.solve(load=pressure, support=form) for pressure in PRESSURES]
    left = [answer.deflection - depths for answer, depths in zip(answers, measured, strict=True)]
    error = 1e3 * (form - np.array(hidden.support))[touched]
    print(f"{rows}² = {lattice.size} unknown heights: {result.nit} steps, {len(seconds)} evaluations in {whole:.0f} s,")
    print(f"{processor:.0f} s of processor time; load of the machine {os.getloadavg()[0]:.1f}")
    print(f"an evaluation: {np.median(seconds):.2f} s (median), {processor / len(seconds):.2f} s of processor time")
    print(f"misfit {np.sqrt(np.mean(np.square(left))) / NOISE:.3f} of the noise, ", end="")
    print(f"error where touched {np.sqrt(np.mean(error**2)):.3f} mm, noise {1e3 * NOISE:.2f} mm")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=512)
    parser.add_argument("--alpha", type=float, default=1e5, help="weight of smoothness")
    parser.add_argument("--steps", type=int, default=40, help="at most so many")
    arguments = parser.parse_args()
    main(arguments.rows, arguments.alpha, arguments.steps)
