"""Time of every backend against size, warm in this process and cold in one of its own.

    python benchmarks/backends.py [--sizes 15 31 63 127] [--tol 1e-6] [--plot times.png]

Warm: the least of three solves of the bowl. Cold: a fresh Python process that imports the package, builds the model and
solves it once, the least of three, less the same process without the solve: what the first answer costs, with loading
the libraries and the compiled kernels. ``backend="auto"`` rests on this table.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time

import numpy as np

import contactqp as cq
from contactqp.gallery import bowl

LARGEST = {"mangasarian": 63}


def cold_seconds(backend: str | None, nodes: int, tol: float) -> float:
    """Return the seconds of a fresh process that builds the model and, unless ``backend`` is None, solves it."""
    call = "pass" if backend is None else f"cq.solve(model, {backend!r}, tol={tol})"
    code = f"import contactqp as cq; model = cq.gallery.bowl({nodes}); model.problem; {call}"
    best = np.inf
    for _ in range(3):
        started = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        best = min(best, time.perf_counter() - started)
    return float(best)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="*", default=[15, 31, 63, 127], help="nodes along a side")
    parser.add_argument("--backends", nargs="*", default=list(cq.backend_names()))
    parser.add_argument("--tol", type=float, default=1e-6)
    parser.add_argument("--plot", default=None, help="write a picture of the warm times")
    arguments = parser.parse_args()
    times: dict[str, list[tuple[int, float]]] = {name: [] for name in arguments.backends}
    print(
        f"{'nodes':>8s} {'backend':12s} {'status':10s} {'iterations':>10s} {'bound':>8s} {'warm s':>8s} {'cold s':>8s}"
    )
    for nodes in arguments.sizes:
        idle = cold_seconds(None, nodes, arguments.tol)
        for backend in arguments.backends:
            if nodes > LARGEST.get(backend, 10**9):
                continue
            solutions = [cq.solve(bowl(nodes), backend, tol=arguments.tol, on_failure="ignore") for _ in range(3)]
            best = min(solutions, key=lambda solution: solution.seconds)
            cold = cold_seconds(backend, nodes, arguments.tol) - idle
            times[backend].append((nodes**2, best.seconds))
            print(
                f"{nodes**2:8d} {backend:12s} {best.status.value:10s} {best.iterations:10d} {best.relative_bound:8.1e} "
                f"{best.seconds:8.3f} {cold:8.3f}",
                flush=True,
            )
    if arguments.plot:
        draw(times, arguments.plot)


def draw(times: dict[str, list[tuple[int, float]]], file: str) -> None:
    """Draw warm seconds against nodes, both on logarithmic scales."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    for backend, points in times.items():
        axes.loglog(*zip(*points, strict=True), "o-", label=backend)
    axes.set(xlabel="nodes", ylabel="seconds, certified", title="Bowl on the unit square")
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    main()
