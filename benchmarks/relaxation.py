"""Sweeps of projected over-relaxation with the automatic factor, beside the best of scanned factors.

    python benchmarks/relaxation.py [--nodes 63 127 255] [--loads 0.01 0.1] [--fine]

Prints, for the paper's hexagon at its ten loads or at those given, and for square bowls, from a cold start and for each
of the stopping rules: the best scanned factor and its number of sweeps, the automatic one's last factor and its sweeps,
and the ratio. Factors are scanned in steps of 0.05 on the hexagon, with ``--fine`` also in steps of 0.01 about the
best, and on the bowls in steps of 0.005 there.
The certified rule stands at tol = 1e-6, the paper's two at a thousandth of the spacing.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import numpy as np

import contactqp as cq
from contactqp.gallery import PAPER_LOADS, bowl, paper_hexagon

RULES = ("certified", "step", "residual")
SWEEP_LIMIT = 20_000


def solve(model: cq.Membrane, rule: str, **options: object) -> cq.Solution:
    if rule != "certified":
        options["stopping_length"] = 1e-3 * model.lattice.spacing
    return cq.solve(model, "psor", stopping=rule, on_failure="ignore", max_iter=SWEEP_LIMIT, **options)


def best_of_scan(model: cq.Membrane, rule: str, finest: float) -> tuple[float, int]:
    """Return the best factor and its sweeps; between the coarse factors about the best one the scan is refined."""
    coarse = np.round(np.arange(1.0, 2.0, 0.05), 2)
    sweeps = {float(beta): solve(model, rule, relaxation=float(beta)).iterations for beta in coarse}
    if finest < 0.05:
        about = min(sweeps, key=sweeps.__getitem__)
        for beta in np.round(np.arange(about - 0.05 + finest, min(about + 0.05, 2 - finest / 2), finest), 4):
            sweeps.setdefault(float(beta), solve(model, rule, relaxation=float(beta)).iterations)
    best = min(sweeps, key=sweeps.__getitem__)
    return best, sweeps[best]


def problems(loads: list[float], bowls: list[int], fine: bool) -> Iterator[tuple[str, cq.Membrane, float]]:
    for load in loads:
        yield f"hexagon {load:.2f}", paper_hexagon(load), 0.01 if fine else 0.05
    for nodes in bowls:
        yield f"bowl {nodes}", bowl(nodes), 0.005


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, nargs="*", default=[63, 127, 255], help="nodes along a side of the bowls")
    parser.add_argument("--loads", type=float, nargs="*", default=list(PAPER_LOADS), help="of the hexagon")
    parser.add_argument("--fine", action="store_true", help="scan the hexagon in steps of 0.01")
    arguments = parser.parse_args()
    print(f"{'problem':14s} {'rule':10s} {'best':>6s} {'N':>5s}   {'auto':>6s} {'N':>5s}   ratio")
    worst = dict.fromkeys(RULES, 0.0)
    for name, model, finest in problems(arguments.loads, arguments.nodes, arguments.fine):
        for rule in RULES:
            beta, sweeps = best_of_scan(model, rule, finest)
            automatic = solve(model, rule)
            last = float(automatic.termination.rsplit(" ", 1)[1])
            ratio = automatic.iterations / sweeps
            worst[rule] = max(worst[rule], ratio)
            print(
                f"{name:14s} {rule:10s} {beta:6.3f} {sweeps:5d}   {last:6.3f} {automatic.iterations:5d}   {ratio:.3f}"
            )
    print("worst:", ", ".join(f"{rule} {ratio:.3f}" for rule, ratio in worst.items()))


if __name__ == "__main__":
    main()
