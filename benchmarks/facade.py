"""Cost of the package's facade over calling OSQP or Clarabel directly with the same settings, in turn in one process.

    python benchmarks/facade.py [--nodes 255] [--repeat 5]

The direct call gets the dimensionless matrices ready-made and runs the library as the backend does (same settings,
same rounds), so what is left is scaling, conversion, judging and certifying. Prints, for each backend, both times and
the median of the ratios of neighbouring runs.
"""

from __future__ import annotations

import argparse
import statistics
import time

import clarabel
import numpy as np
import osqp
from scipy import sparse

import contactqp as cq
from contactqp.backends.clarabel import Clarabel
from contactqp.backends.osqp import Osqp
from contactqp.gallery import bowl


def direct_osqp(problem: cq.ContactQP, eps: list[float]) -> float:
    """Return the seconds that OSQP takes for set-up and the given rounds, polishing until that succeeds once."""
    quadratic, identity = sparse.csc_matrix(sparse.triu(problem.G)), sparse.csc_matrix(sparse.eye_array(problem.size))
    lower, upper = np.zeros(problem.size), np.full(problem.size, np.inf)
    options = Osqp().options()
    started = time.perf_counter()
    solver = osqp.OSQP()
    solver.setup(
        quadratic,
        problem.q.copy(),
        identity,
        lower,
        upper,
        rho=options["rho"],
        alpha=options["alpha"],
        adaptive_rho=1,
        eps_prim_inf=1e-15,
        eps_dual_inf=1e-15,
        max_iter=200_000,
        verbose=False,
    )
    polishing = True
    for k, tolerance in enumerate(eps):
        solver.update_settings(eps_abs=tolerance, eps_rel=tolerance, polishing=polishing and k > 0)
        polishing = solver.solve(raise_error=False).info.status_polish != 1 and polishing
    return time.perf_counter() - started


def direct_clarabel(problem: cq.ContactQP, eps: list[float]) -> float:
    """Return the seconds that Clarabel takes for set-up and the given rounds."""
    quadratic, held = sparse.csc_matrix(sparse.triu(problem.G)), sparse.csc_matrix(-sparse.eye_array(problem.size))
    options = Clarabel().options()
    started = time.perf_counter()
    for tolerance in eps:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_iter = 60
        settings.direct_solve_method = options["direct_solve_method"]
        settings.static_regularization_constant = options["static_regularization_constant"]
        settings.tol_gap_abs = settings.tol_gap_rel = tolerance
        settings.tol_feas = 1e-10
        cones = [clarabel.NonnegativeConeT(problem.size)]
        clarabel.DefaultSolver(quadratic, problem.q, held, np.zeros(problem.size), cones, settings).solve()
    return time.perf_counter() - started


def rounds(termination: str, first: float, factor: float) -> list[float]:
    """Return the tolerances that a backend went through, from the last that it names."""
    last = float(termination.rsplit("eps ", 1)[1])
    eps = [first]
    while eps[-1] > 1.5 * last:
        eps.append(eps[-1] / factor)
    return eps


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, default=255, help="nodes along a side of the square")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--tol", type=float, default=1e-6)
    arguments = parser.parse_args()
    print(f"{arguments.nodes} x {arguments.nodes} nodes, tol {arguments.tol:g}, medians of {arguments.repeat} pairs")
    cq.solve(bowl(7), "osqp")
    cq.solve(bowl(7), "clarabel")
    for name, direct in (("osqp", direct_osqp), ("clarabel", direct_clarabel)):
        facade_seconds, direct_seconds = [], []
        for _ in range(arguments.repeat):
            model = bowl(arguments.nodes)
            started = time.perf_counter()
            solution = cq.solve(model, name, tol=arguments.tol)
            facade_seconds.append(time.perf_counter() - started)
            scaled, _ = model.problem.scaled()
            finest = 1e-15 if model.lattice.size > 10_000 else 1e-14
            first = 100 * arguments.tol if name == "osqp" else finest * max(arguments.tol / 1e-6, 1.0) ** 2
            direct_seconds.append(direct(scaled, rounds(solution.termination, first, 10.0)))
        ratios = [a / b for a, b in zip(facade_seconds, direct_seconds, strict=True)]
        facade, middle = statistics.median(facade_seconds), statistics.median(direct_seconds)
        print(
            f"  {name:10s} facade {facade:7.3f} s   direct {middle:7.3f} s   ratio {statistics.median(ratios):.3f} "
            f"(from {min(ratios):.3f} to {max(ratios):.3f})   {solution.status.value}, {solution.iterations} iterations"
        )


if __name__ == "__main__":
    main()
