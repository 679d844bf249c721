"""What a call costs beyond its method: the package around a library, checks of a matrix, and what sessions save.

contactqp bench run benchmarks/calls.py
contactqp bench run benchmarks/calls.py facade-osqp facade-clarabel
contactqp bench run benchmarks/calls.py path touchdown many
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.backends.clarabel import Clarabel
from contactqp.backends.osqp import Osqp
from contactqp.benchmark import Spec, solution_facts
from contactqp.gallery import bowl, paper_hexagon

TOL = 1e-6

# A library called directly with the dimensionless matrices and the rounds that its backend went through.


class Direct(NamedTuple):
    """What a library is called with."""

    nodes: int
    problem: cq.ContactQP
    rounds: list[float]


def direct(backend: str) -> Callable[[int], Direct]:
    """Return what builds a case: the rounds are read from an answer, which names the last tolerance."""

    def build(nodes: int) -> Direct:
        model = bowl(nodes)
        finest = 1e-15 if model.size > 10_000 else 1e-14
        eps = [100 * TOL if backend == "osqp" else finest]
        last = float(cq.solve(model, backend, tol=TOL).termination.rsplit("eps ", 1)[1])
        while eps[-1] > 1.5 * last:
            eps.append(eps[-1] / 10)
        return Direct(nodes, model.problem.scaled()[0], eps)

    return build


def direct_osqp(case: Direct) -> None:
    """Set OSQP up and go through the rounds, polishing until that succeeds once."""
    import osqp

    problem, options = case.problem, Osqp().options()
    quadratic, identity = sparse.csc_matrix(sparse.triu(problem.G)), sparse.csc_matrix(sparse.eye_array(problem.size))
    lower, upper = np.zeros(problem.size), np.full(problem.size, np.inf)
    settings = {"rho": options["rho"], "alpha": options["alpha"], "adaptive_rho": 1, "verbose": False}
    solver = osqp.OSQP()
    solver.setup(
        quadratic, problem.q.copy(), identity, lower, upper, **settings,
        eps_prim_inf=1e-15, eps_dual_inf=1e-15, max_iter=200_000,
    )  # fmt: skip
    polishing = True
    for k, tolerance in enumerate(case.rounds):
        solver.update_settings(eps_abs=tolerance, eps_rel=tolerance, polishing=polishing and k > 0)
        polishing = solver.solve(raise_error=False).info.status_polish != 1 and polishing


def direct_clarabel(case: Direct) -> None:
    """Go through the rounds with Clarabel, which is set up anew for each."""
    import clarabel

    problem, options = case.problem, Clarabel().options()
    quadratic, held = sparse.csc_matrix(sparse.triu(problem.G)), sparse.csc_matrix(-sparse.eye_array(problem.size))
    for tolerance in case.rounds:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_iter = 60
        settings.direct_solve_method = options["direct_solve_method"]
        settings.static_regularization_constant = options["static_regularization_constant"]
        settings.tol_gap_abs = settings.tol_gap_rel = tolerance
        settings.tol_feas = 1e-10
        cones = [clarabel.NonnegativeConeT(problem.size)]
        clarabel.DefaultSolver(quadratic, problem.q, held, np.zeros(problem.size), cones, settings).solve()


def facade(backend: str, call: Callable[[Direct], None]) -> Spec:
    return Spec(
        f"facade-{backend}",
        f"a model made and solved by {backend} to {TOL:g}, over the library called with ready matrices",
        direct(backend),
        (255,),
        {"directly": call, "cq.solve": lambda case: cq.solve(bowl(case.nodes), backend, tol=TOL)},
        repeat=5,
        smoke=15,
    )


# Checks of a matrix.

GRAPH_NODES, DEGREE, GROUND = 10_000, 20, 0.1


def matrices(name: str) -> tuple[Any, Any]:
    if name != "graph":
        problem = bowl(31 if name == "small bowl" else 255).problem
        return problem.G, problem.q
    return graph_matrix(), np.random.default_rng(0).normal(size=GRAPH_NODES)


def graph_matrix() -> sparse.csr_array:
    """Return Q = aI + (1-a)/2 (I - D^-½ A D^-½) of a random graph: an M-matrix that no row tells to be one."""
    density = DEGREE / 2 / GRAPH_NODES
    half = sparse.random_array((GRAPH_NODES, GRAPH_NODES), density=density, rng=np.random.default_rng(1), format="csr")
    joined = ((half + half.T) > 0).astype(float).tocsr()
    joined.setdiag(0.0)
    joined.eliminate_zeros()
    root = sparse.diags_array(1 / np.sqrt(np.maximum(joined.sum(axis=1), 1.0)))
    one = sparse.eye_array(GRAPH_NODES)
    return (GROUND * one + (1 - GROUND) / 2 * (one - root @ joined @ root)).tocsr()


def parts_of_a_solve(case: Any, result: Any) -> dict[str, Any]:
    if not isinstance(result, cq.Solution):
        return {}
    answer = result.setup_seconds + result.solve_seconds
    return solution_facts(result) | {"answer s": answer, "judge s": result.seconds - answer}


# Sessions.


class Path(NamedTuple):
    """A model, its loads, and how it is made anew."""

    model: cq.Membrane
    loads: Any
    anew: Callable[[], cq.Membrane]


def path(nodes: int) -> Path:
    return Path(bowl(nodes), np.linspace(0.5, 1.5, 20), lambda: bowl(nodes))


def hexagons(count: int) -> list[cq.Membrane]:
    return [paper_hexagon(float(load)) for load in np.linspace(0.01, 0.035, count)]


def in_a_session(models: list[cq.Membrane]) -> None:
    solver = cq.Solver(models[0], "osqp")
    for model in models:
        solver.solve(load=model.load)


def little(unknowns: int) -> tuple[cq.ContactQP, cq.Solver, list[Any]]:
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    return problem, cq.Solver(problem), [np.array([-1.0, 3.0]), np.array([-2.0, 3.0])]


LATTICE = cq.Frame.rectangle(31.0, 31.0).lattice(1.0)
MANY = 200


def many(name: str) -> tuple[cq.ContactQP, Any]:
    """Return a problem, and forces of many others with its matrix."""
    line = sparse.diags_array([-1.0, 2.01, -1.0], offsets=[-1, 0, 1], shape=(20, 20)).tocsr()
    mask = {side: cq.Frame.rectangle(side + 1.0, side + 1.0).lattice(1.0).mask for side in (10, 20)}
    matrix: Any = {
        "2": lambda: np.array([[2.0, -1.0], [-1.0, 2.0]]),
        "20 line": lambda: line,
        "20 dense": lambda: 21 * np.eye(20) - 1,
        "100": lambda: sparse.kronsum(line[:10, :10], line[:10, :10], format="csr"),
        "400": lambda: sparse.kronsum(line, line, format="csr"),
        "100 nodes": lambda: Stencil(mask[10], 1.0, 1.0),
        "400 nodes": lambda: Stencil(mask[20], 1.0, 1.0),
    }[name]()
    problem = cq.ContactQP(matrix, np.zeros(matrix.shape[0] if hasattr(matrix, "shape") else matrix.size))
    return problem, np.random.default_rng(0).normal(size=(MANY, problem.size))


def session_of(case: tuple[cq.ContactQP, Any]) -> None:
    problem, forces = case
    solver = cq.Solver(problem)
    for q in forces:
        solver.solve(q=q)


SPECS = (
    facade("osqp", direct_osqp),
    facade("clarabel", direct_clarabel),
    Spec(
        "checking",
        "a problem of a matrix, of which nothing is known before, made; and made, answered and judged",
        matrices,
        ("graph", "bowl"),
        {
            "make": lambda case: cq.ContactQP(*case),
            "make and solve": lambda case: cq.solve(cq.ContactQP(*case), on_failure="ignore"),
        },
        point="the matrix: of a graph, or of a bowl of 255² nodes",
        tell=parts_of_a_solve,
        smoke="small bowl",
    ),
    Spec(
        "path",
        "twenty loads on a bowl by multigrid in a session, against twenty cold solves of the model and of new ones",
        path,
        (511,),
        {
            "cold": lambda case: [cq.solve(case.model, "multigrid") for _ in case.loads],
            "cold, new models": lambda case: [cq.solve(case.anew(), "multigrid") for _ in case.loads],
            "in a session": lambda case: cq.trace(case.model, loads=case.loads, backend="multigrid"),
        },
        smoke=63,
    ),
    Spec(
        "osqp-path",
        "loads on the hexagon by OSQP in a session, against cold solves",
        hexagons,
        (20,),
        {"cold": lambda models: [cq.solve(model, "osqp") for model in models], "in a session": in_a_session},
        point="loads",
        smoke=2,
    ),
    Spec(
        "touchdown",
        "touchdown loads to 1e-3 by solves in between, against following the events",
        bowl,
        (63,),
        {
            "events": lambda model: cq.events(model, start=0.05, stop=1.0),
            "in between": lambda model: cq.trace(model, loads=np.linspace(0.05, 1.0, 20)).touchdown(width=1e-3),
        },
        smoke=15,
    ),
    Spec(
        "small",
        "two solves of two unknowns in a session and by solve, and a membrane on 30² nodes made and solved",
        little,
        (2,),
        {
            "in a session": lambda case: [case[1].solve(q=q) for q in case[2]],
            "by solve": lambda case: [cq.solve(case[0]) for _ in case[2]],
            "30² nodes": lambda case: cq.solve(cq.Membrane(LATTICE, 1.0, load=0.05, support=2.0)),
        },
        point="unknowns",
        repeat=300,
    ),
    Spec(
        "many",
        f"{MANY} random loads of one matrix by solve_many, against a session; a size is their number",
        many,
        ("2", "20 line", "20 dense", "100", "400", "100 nodes", "400 nodes"),
        {
            "session": session_of,
            "solve_many": lambda case: cq.solve_many([case[0].with_forces(q) for q in case[1]]),
            "problems made": lambda case: [case[0].with_forces(q) for q in case[1]],
        },
        point="unknowns; in a line, of a dense matrix, of a sparse one, or nodes of a lattice",
        size=lambda case: len(case[1]),
    ),
)
