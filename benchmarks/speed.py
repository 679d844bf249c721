"""The speed of the contact multigrid and of active sets, as ratios measured in one run.

    python benchmarks/speed.py                      # every measure, some minutes
    python benchmarks/speed.py per-node growth      # some of them
    python benchmarks/speed.py picture --plot docs/speed.png

Measures, each with its default size (nodes along a side), which an option of the same name changes:

    general-qp   (511)   multigrid and active sets against the fastest of OSQP, Clarabel and PIQP, same certified bound
    linear-amg   (1023)  multigrid's contact problem against pyamg's linear one: classical set-up, and CG to 1e-10
    own-linear   (2047)  multigrid's contact problem against the same lattice without a support
    per-node     (2047)  microseconds a node, certified to 1e-8
    growth       (8191)  exponent of time against nodes, from 255 up
    cycles       (4095)  cycles to an error of 1e-10 on bowl and spiral, from 255 up
    nested       (1023)  work until the error is that of the discretisation, on the ball
    huge         (10000) seconds and peak memory of a process that solves it once, certified to 1e-6
    picture              warm seconds against nodes for all backends, drawn with --plot

Warm times are the least of ``--repeat`` runs, taken in turn with what they are compared to. The model is built before;
its time is printed for ``huge``. PIQP and pyamg are optional: pip install '.[benchmarks]'.
"""

from __future__ import annotations

import argparse
import importlib.util
import resource
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
from timing import in_turn, seconds

import contactqp as cq
from contactqp.foundation.threads import Team
from contactqp.gallery import ball, bowl, spiral
from contactqp.methods.multigrid.arms import arms_of
from contactqp.methods.multigrid.nested import nested_start
from contactqp.proof.measure import measure

SIZES = {
    "general-qp": 511,
    "linear-amg": 1023,
    "own-linear": 2047,
    "per-node": 2047,
    "growth": 8191,
    "cycles": 4095,
    "nested": 1023,
    "huge": 10_000,
}
PIQP_TOLERANCES = (1e-10, 3e-11, 1e-11, 3e-12, 1e-12)
LARGEST_IN_PICTURE = {
    "mangasarian": 63,
    "osqp": 255,
    "clarabel": 255,
    "psor": 1023,
    "active-set": 2047,
    "multigrid": 4095,
}
COLOURS = {
    "mangasarian": "#7b4ea3",
    "osqp": "#1f5f8b",
    "clarabel": "#2a9d8f",
    "psor": "#b8862b",
    "active-set": "#555555",
    "multigrid": "#d6336c",
}


def report(name: str, text: str) -> None:
    print(f"{name:11s} {text}", flush=True)


def certified(problem: object, backend: str, tol: float = 1e-6) -> cq.Solution:
    solution = cq.solve(problem, backend, tol=tol, on_failure="ignore")
    if solution.status != "certified":
        print(f"    {backend} achieved {solution.relative_bound:.1e} only, wanted {tol:g}")
    return solution


def piqp(problem: cq.ContactQP, tol: float) -> float:
    """Return the seconds of PIQP's run, through qpsolvers, at the loosest of some tolerances that is certified."""
    from qpsolvers import Problem, solve_problem
    from scipy import sparse

    scaled, units = problem.scaled()
    program = Problem(sparse.csc_matrix(scaled.G), np.array(scaled.q), lb=np.zeros(scaled.size))
    for eps in PIQP_TOLERANCES:
        started = time.perf_counter()
        found = solve_problem(
            program, solver="piqp", eps_abs=PIQP_TOLERANCES[0], eps_rel=0.0, eps_duality_gap_abs=eps,
            eps_duality_gap_rel=0.0, max_iter=60,
        )  # fmt: skip
        taken = time.perf_counter() - started
        if found.x is not None and measure(problem, found.x * units.length).relative_bound <= tol:
            return taken
    return float("inf")


def general_qp(nodes: int, repeat: int) -> None:
    model = bowl(nodes)
    matrix = cq.ContactQP(model.problem.G, model.problem.q)
    matrix.gap_scale  # noqa: B018  (finds the barrier)
    own, active = in_turn(repeat, lambda: certified(model, "multigrid"), lambda: certified(matrix, "active-set"))
    times = {name: seconds(lambda name=name: certified(model, name)) for name in ("osqp", "clarabel")}
    if importlib.util.find_spec("piqp"):
        times["piqp"] = piqp(model.problem, 1e-6)
    else:
        print("    PIQP is not installed: pip install piqp")
    again, active_again = in_turn(
        repeat, lambda: certified(model, "multigrid"), lambda: certified(matrix, "active-set")
    )
    own, active = min(own, again), min(active, active_again)
    fastest = min(times, key=lambda name: times[name])
    listed = ", ".join(f"{name} {value:.1f} s" for name, value in times.items())
    report("general-qp", f"{nodes}²: {listed}; multigrid {own:.4f} s, active-set on the matrix {active:.3f} s")
    report(
        "", f"multigrid {times[fastest] / own:.0f} x faster than {fastest}; active-set {times[fastest] / active:.0f} x"
    )
    report("", f"active-set / multigrid {active / own:.1f}")


def linear_amg(nodes: int, repeat: int) -> None:
    if not importlib.util.find_spec("pyamg"):
        report("linear-amg", "pyamg is not installed: pip install pyamg")
        return
    import pyamg

    model = bowl(nodes)
    matrix, load = model.problem.G, np.array(model.nodal_load)

    def linear() -> None:
        pyamg.ruge_stuben_solver(matrix).solve(load, tol=1e-10, accel="cg")

    own, other = in_turn(repeat, lambda: certified(model, "multigrid"), linear)
    report(
        "linear-amg", f"{nodes}²: pyamg, linear {other:.2f} s; multigrid, contact {own:.3f} s; ratio {other / own:.1f}"
    )


def own_linear(nodes: int, repeat: int) -> None:
    model = bowl(nodes)
    free = cq.Membrane(model.lattice, model.tension, load=model.load, support=np.inf)
    contact, linear = in_turn(
        repeat, lambda: certified(model, "multigrid", 1e-8), lambda: certified(free, "multigrid", 1e-8)
    )
    report("own-linear", f"{nodes}²: contact {contact:.3f} s, linear {linear:.3f} s; ratio {contact / linear:.2f}")


def per_node(nodes: int, repeat: int) -> None:
    for name, model in (("bowl", bowl(nodes)), ("spiral", spiral(nodes)), ("ball", ball(nodes)[0])):
        model.problem.gap_scale  # noqa: B018
        (least,) = in_turn(repeat, lambda model=model: certified(model, "multigrid", 1e-8))
        report("per-node", f"{nodes}² {name}: {least:.3f} s, {1e6 * least / model.lattice.size:.3f} µs a node")


def growth(nodes: int, repeat: int) -> None:
    sides = [side for side in (255, 511, 1023, 2047, 4095, 8191, 16383) if side <= nodes]
    times = []
    for side in sides:
        model = bowl(side)
        model.problem.gap_scale  # noqa: B018
        (least,) = in_turn(repeat if side < 4000 else 2, lambda model=model: certified(model, "multigrid"))
        times.append(least)
        report("growth", f"{side}²: {least:.4f} s, {1e6 * least / side**2:.3f} µs a node")
        del model
    exponent = np.polyfit(2 * np.log(sides), np.log(times), 1)[0]
    report("", f"time grows as nodes to the power {exponent:.3f}")


def cycles(nodes: int, repeat: int) -> None:
    for name, make in (("bowl", bowl), ("spiral", spiral)):
        for side in (side for side in (255, 511, 1023, 2047, 4095, 8191) if side <= nodes):
            report("cycles", f"{side}² {name}: {_cycles_to(make(side), 1e-10)} cycles to an error of 1e-10")


def _cycles_to(model: cq.Membrane, error: float) -> int:
    """Return the finest cycles until max |ω - ω*| is below ``error`` of the gap scale, ω* from as many as help."""
    problem, _ = model.problem.scaled()
    lattice = arms_of(problem.stencil, problem.layout)
    q, height = lattice.layout.grid(problem.q), problem.reference_grid()
    with Team() as team:
        solver = nested_start(lattice, q, height, team)
        for _ in range(30):
            solver.relax()
            if solver.estimate <= solver.rest() / 4:
                break
            solver.correct()
        solver.relax()
        exact = solver.omega.copy()
        del solver
        solver = nested_start(lattice, q, height, team)
        for cycle in range(1, 40):
            solver.relax()
            if np.abs(solver.omega - exact).max() <= error:
                return cycle
            solver.correct()
    return 40


def nested(nodes: int, repeat: int) -> None:
    model, exact = ball(nodes)
    problem, units = model.problem.scaled()
    lattice = arms_of(problem.stencil, problem.layout)
    finished = np.abs(certified(model, "multigrid", 1e-7).deflection - exact).max()
    with Team() as team:
        solver = nested_start(lattice, lattice.layout.grid(problem.q), problem.reference_grid(), team)
        for _ in range(3):
            solver.relax()
            solver.correct()
            found = np.abs(model.deflection(lattice.layout.vector(solver.omega) * units.length) - exact).max()
            report(
                "nested",
                f"{nodes}² ball: {solver.work:.1f} sweeps' work, error {found:.2e} (discretisation: {finished:.2e})",
            )


def huge(nodes: int, repeat: int) -> None:
    subprocess.run([sys.executable, __file__, "--solve-once", str(nodes)], check=True)


def solve_once(nodes: int) -> None:
    cq.solve(bowl(127), "multigrid")
    started = time.perf_counter()
    model = bowl(nodes)
    model.problem.gap_scale  # noqa: B018
    built, building = time.perf_counter() - started, _peak()
    solution = certified(model, "multigrid")
    report(
        "huge",
        f"{nodes}² = {model.lattice.size:.2e} nodes: {solution.seconds:.1f} s, {solution.iterations} cycles, "
        f"bound {solution.relative_bound:.1e}; peak {_peak():.1f} GB (model {building:.1f} GB, built in {built:.0f} s)",
    )


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9


def picture(file: str, repeat: int) -> None:
    """Draw warm seconds against nodes, both on logarithmic scales."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    for backend, largest in LARGEST_IN_PICTURE.items():
        sides = [side for side in (15, 31, 63, 127, 255, 511, 1023, 2047, 4095) if side <= largest]
        times = []
        for side in sides:
            model = bowl(side)
            problem = cq.ContactQP(model.problem.G, model.problem.q) if backend == "active-set" else model
            (least,) = in_turn(
                repeat if backend == "multigrid" or side < 200 else 1, lambda p=problem, b=backend: certified(p, b)
            )
            times.append(least)
            report("picture", f"{backend:11s} {side}²: {least:.4f} s")
        label = f"{backend} (given the matrix)" if backend == "active-set" else backend
        axes.loglog([side**2 for side in sides], times, "o-", ms=4, color=COLOURS[backend], label=label)
    nodes = np.array([4e4, 1.7e7])
    axes.loglog(nodes, 2e-7 * nodes, color="0.6", lw=1, ls="--")
    axes.text(0.98, 0.03, "dashed: 0.2 µs a node", transform=axes.transAxes, ha="right", color="0.4", fontsize=9)
    axes.set(xlabel="nodes", ylabel="seconds, certified to 1e-6", title="A membrane pressed into a bowl")
    axes.legend(frameon=False, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file, dpi=150)


MEASURES: dict[str, Callable[[int, int], None]] = {
    "general-qp": general_qp,
    "linear-amg": linear_amg,
    "own-linear": own_linear,
    "per-node": per_node,
    "growth": growth,
    "cycles": cycles,
    "nested": nested,
    "huge": huge,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measures", nargs="*", metavar="measure", help="all but the picture by default")
    for name, side in SIZES.items():
        parser.add_argument(f"--{name}", type=int, default=side, help="nodes along a side")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--plot", default="speed.png", help="file of the picture")
    parser.add_argument("--solve-once", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.solve_once:
        solve_once(arguments.solve_once)
        return
    unknown = sorted(set(arguments.measures) - set(MEASURES) - {"picture"})
    if unknown:
        parser.error(f"unknown measure {', '.join(unknown)}; known: {', '.join([*MEASURES, 'picture'])}")
    for name in arguments.measures or MEASURES:
        if name == "picture":
            picture(arguments.plot, arguments.repeat)
        else:
            MEASURES[name](getattr(arguments, name.replace("-", "_")), arguments.repeat)


if __name__ == "__main__":
    main()
