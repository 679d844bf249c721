"""The speed of the contact multigrid and of active sets, beside general solvers, linear solves and itself.

    contactqp bench run benchmarks/speed.py                    # all, some minutes
    contactqp bench run benchmarks/speed.py per-node growth    # some of them

``huge`` solves 10⁸ nodes in a process of its own, whose peak of memory it tells. PIQP and pyamg are optional: pip
install '.[benchmarks]'.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq
from shapely import Point, affinity

import contactqp as cq
from contactqp.benchmark import Phase, Spec
from contactqp.foundation.checks import Vector
from contactqp.foundation.threads import Team
from contactqp.gallery import ball, bowl, spiral
from contactqp.proof.measure import measure

REPEAT = 5


def solve(problem: object, backend: str = "multigrid", tol: float = 1e-6) -> cq.Solution:
    return cq.solve(problem, backend, tol=tol, on_failure="ignore")


def ready(model: cq.Membrane) -> cq.Membrane:
    """Return a model of which all is known that a solve would find out first."""
    model.problem.gap_scale  # noqa: B018  (finds the barrier)
    return model


# Beside general solvers and linear ones.

PIQP_TOLERANCES = (1e-10, 3e-11, 1e-11, 3e-12, 1e-12)


class Given(NamedTuple):
    """A bowl as a model, as a matrix, and as PIQP is called with it, if it is installed."""

    model: cq.Membrane
    matrix: cq.ContactQP
    piqp: Callable[[], Any] | None


def given(nodes: int) -> Given:
    model = ready(bowl(nodes))
    matrix = cq.ContactQP(model.problem.G, model.problem.q)
    matrix.gap_scale  # noqa: B018
    return Given(model, matrix, None if PIQP.lacks else loosest_piqp(model.problem, 1e-6))


def loosest_piqp(problem: cq.ContactQP, tol: float) -> Callable[[], Any]:
    """Return the call of PIQP, through qpsolvers, with the loosest of some tolerances whose answer is certified."""
    from qpsolvers import Problem, solve_problem
    from scipy import sparse

    scaled, units = problem.scaled()
    program = Problem(sparse.csc_matrix(scaled.G), np.array(scaled.q), lb=np.zeros(scaled.size))
    common = {"solver": "piqp", "eps_abs": PIQP_TOLERANCES[0], "eps_rel": 0.0, "eps_duality_gap_rel": 0.0}
    for eps in PIQP_TOLERANCES:
        call = partial(solve_problem, program, **common, eps_duality_gap_abs=eps, max_iter=60)
        found = call().x
        if found is not None and measure(problem, found * units.length).relative_bound <= tol:
            return call
    raise cq.UnsuitableProblemError("PIQP's answer is not certified at any tolerance")


PIQP = Phase(lambda case: {"iterations": case.piqp().extras["info"].iter}, needs=("qpsolvers", "piqp"), once=True)


def pyamg_solve(model: cq.Membrane) -> None:
    import pyamg

    pyamg.ruge_stuben_solver(model.problem.G).solve(np.array(model.nodal_load), tol=1e-10, accel="cg")


def with_and_without(nodes: int) -> dict[str, cq.Membrane]:
    model = bowl(nodes)
    free = cq.Membrane(model.lattice, model.tension, load=model.load, support=np.inf)
    return {"contact": model, "linear": free}


def three(nodes: int) -> dict[str, cq.Membrane]:
    return {"bowl": ready(bowl(nodes)), "spiral": ready(spiral(nodes)), "ball": ready(ball(nodes)[0])}


def of_each(names: tuple[str, ...], tol: float) -> dict[str, Callable[[Any], cq.Solution]]:
    """Return a phase for each model of a case: its solve."""
    return {name: lambda case, name=name: solve(case[name], tol=tol) for name in names}


# What its cycles are worth.


class Cycling(NamedTuple):
    """A problem as the multigrid has it, with the model and what an answer is compared with."""

    model: cq.Membrane
    lattice: Any
    q: Any
    height: Any
    exact: Any

    def start(self, team: Team) -> Any:
        """Return the multigrid's iteration at its first guess, from the coarser lattices."""
        from contactqp.methods.multigrid.nested import nested_start

        return nested_start(self.lattice, self.q, self.height, team)


def cycling(model: cq.Membrane, exact: Any = None) -> Cycling:
    from contactqp.methods.multigrid.arms import arms_of

    problem, _ = model.problem.scaled()
    lattice = arms_of(problem.stencil, problem.layout)
    return Cycling(model, lattice, lattice.layout.grid(problem.q), problem.reference_grid(), exact)


def with_truth(model: cq.Membrane) -> Cycling:
    """Return a problem with the dimensionless gap after as many cycles as help."""
    case = cycling(model)
    with Team() as team:
        solver = case.start(team)
        for _ in range(30):
            solver.relax()
            if solver.estimate <= solver.rest() / 4:
                break
            solver.correct()
        solver.relax()
        return case._replace(exact=solver.omega.copy())


def cycles_to(case: Cycling, error: float) -> dict[str, int]:
    """Return the finest cycles until max |ω - ω*| is below ``error`` of the gap scale."""
    with Team() as team:
        solver = case.start(team)
        for cycle in range(1, 40):
            solver.relax()
            if np.abs(solver.omega - case.exact).max() <= error:
                return {"cycles": cycle}
            solver.correct()
    return {"cycles": 40}


def hung_over_a_ball(nodes: int) -> Cycling:
    return cycling(*ball(nodes))


def some_cycles(case: Cycling, count: int) -> tuple[float, Any]:
    """Return the work (sweeps over the lattice) of a number of cycles, and the dimensionless gap after them."""
    with Team() as team:
        solver = case.start(team)
        for _ in range(count):
            solver.relax()
            solver.correct()
        return solver.work, solver.omega.copy()


def error_beside_discretisation(case: Cycling, result: tuple[float, Any] | cq.Solution) -> dict[str, float]:
    """Return the distance from the continuous answer."""
    if isinstance(result, cq.Solution):
        return {"error": float(np.abs(result.deflection - case.exact).max())}
    work, omega = result
    gap = case.lattice.layout.vector(omega) * case.model.problem.scaled()[1].length
    return {"work": work, "error": float(np.abs(case.model.deflection(gap) - case.exact).max())}


def cycles_of(count: int) -> Callable[[Cycling], object]:
    return lambda case: some_cycles(case, count)


# A process of its own, for its memory.

SOLVED_ONCE = """
import json, resource, sys, time
import contactqp as cq

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9

cq.solve(cq.gallery.bowl(127), "multigrid")
begun = time.perf_counter()
model = cq.gallery.bowl(int(sys.argv[1]))
model.problem.gap_scale
facts = {"build s": time.perf_counter() - begun, "model GB": peak()}
solution = cq.solve(model, "multigrid", on_failure="ignore")
facts |= {"status": solution.status.value, "solve s": solution.seconds, "cycles": solution.iterations}
print(json.dumps(facts | {"bound": float(solution.relative_bound), "peak GB": peak()}))
"""


def solved_in_a_process(nodes: int) -> Mapping[str, Any]:
    command = [sys.executable, "-c", SOLVED_ONCE, str(nodes)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    told: Mapping[str, Any] = json.loads(done.stdout)
    return told


# Lattices that are fitted to their frame.

FLOOR = 0.1
WIDE, HIGH, TENSION = 1.3, 0.7, (2.0, 1.0)


def over_floor(x: Vector, y: Vector) -> Vector:
    """Deflection of a disk of radius, tension and pressure 1 over a floor."""
    a = brentq(lambda r: (1 - r * r) / 4 + r * r / 2 * np.log(r) - FLOOR, 1e-9, 1)
    r = np.maximum(np.hypot(x, y), a)
    return np.asarray((1 - r * r) / 4 + a * a / 2 * np.log(r))


def without_support(x: Vector, y: Vector) -> Vector:
    """Deflection of an ellipse under a pressure of 1."""
    stiffness = 2 * (TENSION[0] / WIDE**2 + TENSION[1] / HIGH**2)
    return np.asarray((1 - (x / WIDE) ** 2 - (y / HIGH) ** 2) / stiffness)


def plain_and_fitted(frame: cq.Frame, width: float, nodes: int, **known: Any) -> dict[str, cq.Membrane]:
    origin = (0.37 * width / nodes, 0.21 * width / nodes)
    lattices = {name: frame.lattice(width / (nodes + 1), origin, fitted=name == "fitted") for name in LATTICES}
    return {name: cq.Membrane(lattice, load=1.0, **known) for name, lattice in lattices.items()}


def disk(nodes: int) -> dict[str, cq.Membrane]:
    return plain_and_fitted(cq.Frame.disk(1.0), 2.0, nodes, tension=1.0, support=FLOOR)


def ellipse(nodes: int) -> dict[str, cq.Membrane]:
    frame = cq.Frame.from_shapely(affinity.scale(Point(0, 0).buffer(1, quad_segs=20_000), WIDE, HIGH))
    return plain_and_fitted(frame, 2 * WIDE, nodes, tension=TENSION, support=np.inf)


LATTICES = ("plain", "fitted")


def with_error(exact: Callable[[Vector, Vector], Vector]) -> Callable[[Any, cq.Solution], dict[str, Any]]:
    def tell(case: Any, solution: cq.Solution) -> dict[str, Any]:
        error = np.abs(solution.deflection - exact(solution.model.node_x, solution.model.node_y)).max()
        return {"cycles": solution.iterations, "error": float(error)}

    return tell


FITTED = {
    "sweep": (127, 255, 511, 1023),
    "phases": of_each(LATTICES, 1e-6),
    "point": "nodes along the width",
    "repeat": 7,
    "smoke": 31,
}

SPECS = (
    Spec(
        "general-qp",
        "multigrid, and active sets on the matrix, against the fastest general solver, all certified to 1e-6",
        given,
        (511,),
        {
            "multigrid": lambda case: solve(case.model),
            "active-set": lambda case: solve(case.matrix, "active-set"),
            "osqp": Phase(lambda case: solve(case.model, "osqp"), once=True),
            "clarabel": Phase(lambda case: solve(case.model, "clarabel"), once=True),
            "piqp": PIQP,
        },
        size=lambda case: case.model.size,
        beside=("osqp", "clarabel", "piqp"),
        repeat=REPEAT,
        smoke=15,
    ),
    Spec(
        "linear-amg",
        "multigrid's contact problem, to 1e-6, against pyamg's linear one: classical set-up, and CG to 1e-10",
        bowl,
        (1023,),
        {"contact": solve, "pyamg": Phase(pyamg_solve, needs=("pyamg",))},
        size=lambda case: case.size,
        beside=("pyamg",),
        repeat=REPEAT,
        smoke=63,
    ),
    Spec(
        "own-linear",
        "multigrid's contact problem against the same lattice without a support, certified to 1e-8",
        with_and_without,
        (2047,),
        of_each(("contact", "linear"), 1e-8),
        size=lambda case: case["contact"].size,
        beside=("linear",),
        repeat=REPEAT,
        smoke=63,
    ),
    Spec(
        "per-node",
        "multigrid, certified to 1e-8",
        three,
        (2047,),
        of_each(("bowl", "spiral", "ball"), 1e-8),
        size=lambda case: case["bowl"].size,
        repeat=REPEAT,
        smoke=63,
    ),
    Spec(
        "growth",
        "multigrid against nodes, certified to 1e-6",
        lambda nodes: ready(bowl(nodes)),
        (255, 511, 1023, 2047, 4095, 8191),
        {"multigrid": solve},
        size=lambda case: case.size,
        repeat=lambda nodes: REPEAT if nodes < 4000 else 2,
        smoke=63,
        drawn=True,
    ),
    Spec(
        "cycles",
        "finest cycles of multigrid to an error of 1e-10",
        lambda nodes: {"bowl": with_truth(bowl(nodes)), "spiral": with_truth(spiral(nodes))},
        (255, 511, 1023, 2047, 4095),
        {name: Phase(lambda case, name=name: cycles_to(case[name], 1e-10), once=True) for name in ("bowl", "spiral")},
        smoke=63,
    ),
    Spec(
        "nested",
        "cycles of multigrid until the error is that of the discretisation, on the ball",
        hung_over_a_ball,
        (1023,),
        {
            "certified to 1e-7": lambda case: solve(case.model, tol=1e-7),
            **{f"{count} of its cycles": cycles_of(count) for count in (1, 2, 3)},
        },
        tell=error_beside_discretisation,
        smoke=63,
    ),
    Spec(
        "huge",
        "multigrid once in a process of its own, certified to 1e-6, with its peak of memory",
        lambda nodes: nodes,
        (10_000,),
        {"process": Phase(solved_in_a_process, once=True)},
        size=lambda nodes: nodes**2,
        smoke=63,
    ),
    Spec(
        "fitted-disk",
        "multigrid on a lattice that is fitted to a disk, beside one in steps; over a floor, error of the closed form",
        disk,
        tell=with_error(over_floor),
        **FITTED,
    ),
    Spec(
        "fitted-ellipse",
        "multigrid on a lattice that is fitted to an ellipse; two tensions, no support, error of the closed form",
        ellipse,
        tell=with_error(without_support),
        **FITTED,
    ),
)
