"""What checking a matrix costs beside solving: seconds to make a problem, to answer, and to judge the answer.

    python benchmarks/checking.py

Each line is the least of three runs, each with a problem of its own, so that nothing is known of its matrix before.
"""

from __future__ import annotations

import time

import numpy as np
from scipy import sparse

import contactqp as cq

GRAPH_NODES, DEGREE, GROUND = 10_000, 20, 0.1
RUNS = 3


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


def main() -> None:
    """Print the table."""
    rng = np.random.default_rng(0)
    bowl = cq.gallery.bowl(255).problem
    cases = {
        "graph": (graph_matrix(), rng.normal(size=GRAPH_NODES)),
        "bowl's matrix": (bowl.G, bowl.q),
    }
    print(f"{'matrix':14s} {'unknowns':>9s} {'make':>8s} {'answer':>8s} {'judge':>8s}  status")
    for name, (matrix, q) in cases.items():
        best: tuple[float, ...] = (np.inf, np.inf, np.inf)
        status = ""
        for _ in range(RUNS):
            started = time.perf_counter()
            problem = cq.ContactQP(matrix, q)
            made = time.perf_counter() - started
            solution = cq.solve(problem, on_failure="ignore")
            answered = solution.setup_seconds + solution.solve_seconds
            best = min(best, (made, answered, solution.seconds - answered), key=sum)
            status = solution.status.value
        print(f"{name:14s} {q.size:9d} " + " ".join(f"{seconds:8.3f}" for seconds in best) + f"  {status}")


if __name__ == "__main__":
    main()
