"""What the table of solvers that other packages call says of each: the tightest certified tolerance, and seconds.

The tolerance is the power of ten that the paper's hexagon is certified to at all ten loads; the seconds are those of a
bowl on the unit square certified to 1e-6, by the number of nodes along a side. Run it as

    python benchmarks/solvers.py qpsolvers:piqp cvxpy:scs
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import contactqp as cq
from contactqp.backends import family_names

TIGHT = 1e-14


def reached(name: str, loads: list[float]) -> str:
    """Return the power of ten that all loads are certified to, and the largest bound."""
    bounds = [cq.solve(cq.gallery.paper_hexagon(p), name, tol=TIGHT, on_failure="ignore").relative_bound for p in loads]
    worst = max(bounds)
    if not np.isfinite(worst):
        return "no bound"
    tol = 10.0 ** np.ceil(np.log10(max(worst, TIGHT)))
    again = [cq.solve(cq.gallery.paper_hexagon(p), name, tol=tol, on_failure="ignore").status.ok for p in loads]
    return f"{tol:.0e} ({sum(again)} of {len(loads)} loads), largest bound {worst:.1e}"


def seconds(name: str, nodes: int, limit: float) -> str:
    """Return the seconds for a bowl, or how it failed."""
    started = time.perf_counter()
    solution = cq.solve(cq.gallery.bowl(nodes), name, time_limit=limit, on_failure="ignore")
    return f"{time.perf_counter() - started:.2f}" + ("" if solution.status.ok else f" ({solution.status.value})")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("solvers", nargs="*", default=family_names())
    parser.add_argument("--sizes", nargs="*", type=int, default=[15, 31, 63, 127, 255])
    parser.add_argument("--loads", nargs="*", type=float, default=list(cq.gallery.PAPER_LOADS))
    parser.add_argument("--limit", type=float, default=100.0, help="seconds for a solve")
    asked = parser.parse_args()
    for name in asked.solvers:
        if asked.loads:
            print(f"{name:22} hexagon: {reached(name, asked.loads)}", flush=True)
        for nodes in asked.sizes:
            print(f"{name:22} {nodes}² nodes: {seconds(name, nodes, asked.limit)} s", flush=True)


if __name__ == "__main__":
    main()
