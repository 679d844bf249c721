"""What sessions save, as ratios measured in one run.

    python benchmarks/sessions.py                 # every measure, about two minutes
    python benchmarks/sessions.py path small      # some of them

Measures:

    path        20 loads on the bowl 511² by multigrid, a load against cold solves of the model and of a new one
    osqp        20 loads on the hexagon by OSQP in a session, against cold solves
    touchdown   touchdown loads to 1e-3 on the bowl 63², against following the events
    small       milliseconds of a solve: 2 unknowns in a session and by `solve`, 30² nodes built and solved
    many        milliseconds a problem of `solve_many` for 1000 random loads of one matrix, against a session

Times are the least of ``--repeat`` runs, taken in turn with what they are compared to.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from scipy import sparse
from timing import in_turn

import contactqp as cq
from contactqp.algebra.stencil import Stencil


def path(repeat: int, nodes: int) -> None:
    model, loads = cq.gallery.bowl(nodes), np.linspace(0.5, 1.5, 20)
    twenty, cold, fresh = in_turn(
        repeat,
        lambda: cq.trace(model, loads=loads, backend="multigrid"),
        lambda: cq.solve(model, "multigrid"),
        lambda: cq.solve(cq.gallery.bowl(nodes), "multigrid"),
    )
    load = twenty / loads.size
    print(
        f"path       {nodes}²: {1e3 * load:.1f} ms a load; {load / cold:.2f} x a cold solve ({1e3 * cold:.1f} ms), ",
        end="",
    )
    print(f"{load / fresh:.2f} x one of a new model ({1e3 * fresh:.1f} ms)")


def osqp(repeat: int) -> None:
    model, loads = cq.gallery.paper_hexagon(), np.linspace(0.01, 0.035, 20)
    models = [cq.gallery.paper_hexagon(float(load)) for load in loads]

    def session() -> None:
        solver = cq.Solver(model, "osqp")
        for load in loads:
            solver.solve(load=float(load))

    warm, cold = in_turn(repeat, session, lambda: [cq.solve(one, "osqp") for one in models])
    print(f"osqp       20 loads in {1e3 * warm:.0f} ms, {cold / warm:.2f} x faster than cold ({1e3 * cold:.0f} ms)")


def touchdown(repeat: int, nodes: int) -> None:
    model = cq.gallery.bowl(nodes)
    loads = cq.trace(model, loads=np.linspace(0.05, 1.0, 20))
    brackets, events = in_turn(
        repeat, lambda: loads.touchdown(width=1e-3), lambda: cq.events(model, start=0.05, stop=1.0)
    )
    print(f"touchdown  {nodes}²: {brackets:.2f} s, {brackets / events:.2f} x following the events ({events:.2f} s)")


def small(repeat: int) -> None:
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    solver = cq.Solver(problem)
    forces = [np.array([-1.0, 3.0]), np.array([-2.0, 3.0])]
    lattice = cq.Frame.rectangle(31.0, 31.0).lattice(1.0)
    session, single, square = in_turn(
        100 * repeat,
        lambda: [solver.solve(q=q) for q in forces],
        lambda: cq.solve(problem),
        lambda: cq.solve(cq.Membrane(lattice, 1.0, load=0.05, support=2.0)),
    )
    print(f"small      2 unknowns: {500 * session:.2f} ms in a session, {1e3 * single:.2f} ms by solve; ", end="")
    print(f"{lattice.size} nodes built and solved: {1e3 * square:.1f} ms")


def many(repeat: int) -> None:
    line = sparse.diags_array([-1.0, 2.01, -1.0], offsets=[-1, 0, 1], shape=(20, 20)).tocsr()
    lattices = [cq.Frame.rectangle(side + 1.0, side + 1.0).lattice(1.0) for side in (10, 20)]
    matrices = {
        "2 unknowns": np.array([[2.0, -1.0], [-1.0, 2.0]]),
        "20 unknowns in a line": line,
        "20 unknowns, dense": 21 * np.eye(20) - 1,
        "100 unknowns, a matrix": sparse.kronsum(line[:10, :10], line[:10, :10], format="csr"),
        "400 unknowns, a matrix": sparse.kronsum(line, line, format="csr"),
        **{f"{lattice.size} nodes of a lattice": Stencil(lattice.mask, 1.0, 1.0) for lattice in lattices},
    }
    for name, matrix in matrices.items():
        problem = cq.ContactQP(matrix, np.zeros(matrix.shape[0] if hasattr(matrix, "shape") else matrix.size))
        forces = np.random.default_rng(0).normal(size=(1000, problem.size))
        few = forces[:200]
        together, alone, built = in_turn(
            repeat,
            lambda problem=problem, forces=forces: cq.solve_many([problem.with_forces(q) for q in forces]),
            lambda problem=problem, few=few: session_of(problem, few),
            lambda problem=problem, forces=forces: [problem.with_forces(q) for q in forces],
        )
        a, b = (together - built) / len(forces), alone / len(few)
        print(f"many       {name}: {1e3 * a:.3f} ms a problem, {b / a:.1f} x faster than a session ({1e3 * b:.2f} ms)")


def session_of(problem: cq.ContactQP, forces: np.ndarray) -> None:
    solver = cq.Solver(problem)
    for q in forces:
        solver.solve(q=q)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "measures", nargs="*", metavar="measure", help="path, osqp, touchdown, small, many; all by default"
    )
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--path", type=int, default=511)
    parser.add_argument("--touchdown", type=int, default=63)
    given = parser.parse_args()
    measures: dict[str, Callable[[], None]] = {
        "path": lambda: path(given.repeat, given.path),
        "osqp": lambda: osqp(given.repeat),
        "touchdown": lambda: touchdown(given.repeat, given.touchdown),
        "small": lambda: small(given.repeat),
        "many": lambda: many(given.repeat),
    }
    unknown = sorted(set(given.measures) - set(measures))
    if unknown:
        parser.error(f"unknown measure {unknown[0]!r}; known are {', '.join(measures)}")
    for name in given.measures or measures:
        measures[name]()


if __name__ == "__main__":
    main()
