"""Speed of projected over-relaxation's sweep, beside a copy of the same arrays, in one process.

    python benchmarks/psor.py [--nodes 1023] [--repeat 7]

Prints node updates a second of the lexicographic and of the red-black sweep on one core, and the bandwidth of a
compiled copy of the same number of doubles: the least time of ``--repeat`` runs of each, taken in turn.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from numba import njit

from contactqp.gallery import bowl
from contactqp.methods.sor.sweepers import LatticeSweeper

SWEEPS = 10


@njit("void(float64[::1], float64[::1])", cache=True)
def copy(source, target):  # type: ignore[no-untyped-def]
    for i in range(source.size):
        target[i] = source[i]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, default=1023, help="nodes along a side of the square")
    parser.add_argument("--repeat", type=int, default=7)
    arguments = parser.parse_args()
    problem, _ = bowl(arguments.nodes).problem.scaled()
    stencil = problem.stencil
    assert stencil is not None
    data = problem.layout, problem.q, np.zeros(problem.size), problem.bound_grids()
    sweepers = {
        "lexicographic": LatticeSweeper(stencil, *data),
        "red-black": LatticeSweeper(stencil, *data, red_black=True),
    }
    source = np.ones(problem.size)
    target = np.empty_like(source)
    works: dict[str, Callable[[], object]] = {
        name: (lambda sweeper=sweeper: sweeper.sweep(1.9, SWEEPS)) for name, sweeper in sweepers.items()
    }
    works["copy"] = lambda: [copy(source, target) for _ in range(SWEEPS)]
    best = dict.fromkeys(works, np.inf)
    for _ in range(arguments.repeat):
        for name, work in works.items():
            started = time.perf_counter()
            work()
            best[name] = min(best[name], time.perf_counter() - started)
    updates = SWEEPS * problem.size
    print(f"{arguments.nodes} x {arguments.nodes} nodes, one core, least of {arguments.repeat} runs of {SWEEPS} passes")
    for name, seconds in best.items():
        unit = "million doubles/s copied" if name == "copy" else "million node updates/s"
        print(f"  {name:14s} {updates / seconds / 1e6:7.0f} {unit:26s} {seconds / best['copy']:5.1f} x the copy's time")


if __name__ == "__main__":
    main()
