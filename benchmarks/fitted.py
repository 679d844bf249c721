"""Multigrid on lattices that are fitted to their frame, beside its time on those that are not.

    python benchmarks/fitted.py [--nodes 127 255 511 1023] [--repeat 7]

Prints for a disk over a floor, whose closed form is known, and for an ellipse with two tensions and no support: seconds
(the least of the repetitions, which alternate), cycles, and the largest error of the deflection, on both lattices, and
the ratio of the times.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable, Iterator

import numpy as np
from scipy.optimize import brentq
from shapely import Point, affinity
from timing import in_turn

import contactqp as cq
from contactqp.foundation.checks import Vector

FLOOR = 0.1
WIDE, HIGH, TENSION = 1.3, 0.7, (2.0, 1.0)

Exact = Callable[[Vector, Vector], Vector]


def over_floor(x: Vector, y: Vector) -> Vector:
    """Deflection of a disk of radius, tension and pressure 1 over a floor."""
    a = brentq(lambda r: (1 - r * r) / 4 + r * r / 2 * np.log(r) - FLOOR, 1e-9, 1)
    r = np.maximum(np.hypot(x, y), a)
    return np.asarray((1 - r * r) / 4 + a * a / 2 * np.log(r))


def free(x: Vector, y: Vector) -> Vector:
    """Deflection of an ellipse under a pressure of 1, without a support."""
    stiffness = 2 * (TENSION[0] / WIDE**2 + TENSION[1] / HIGH**2)
    return np.asarray((1 - (x / WIDE) ** 2 - (y / HIGH) ** 2) / stiffness)


def problems(nodes: int) -> Iterator[tuple[str, list[cq.Membrane], Exact]]:
    ellipse = cq.Frame.from_shapely(affinity.scale(Point(0, 0).buffer(1, quad_segs=20_000), WIDE, HIGH))
    for name, frame, width, tension, support, exact in (
        ("disk", cq.Frame.disk(1.0), 2.0, 1.0, FLOOR, over_floor),
        ("ellipse", ellipse, 2 * WIDE, TENSION, np.inf, free),
    ):
        origin = (0.37 * width / nodes, 0.21 * width / nodes)
        lattices = [frame.lattice(width / (nodes + 1), origin, fitted=fitted) for fitted in (False, True)]
        yield name, [cq.Membrane(each, tension, load=1.0, support=support) for each in lattices], exact


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, nargs="*", default=[127, 255, 511, 1023], help="along the width")
    parser.add_argument("--repeat", type=int, default=7)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", cq.ContactWarning)
    titles = [f"{name:>8s} {'N':>3s} {'error':>8s}" for name in ("plain", "fitted")]
    print("   ".join([f"{'frame':8s} {'nodes':>5s}", *titles, "ratio"]))
    for nodes in arguments.nodes:
        for name, models, exact in problems(nodes):
            solutions = [cq.solve(model, "multigrid") for model in models]
            times = in_turn(arguments.repeat, *(lambda model=model: cq.solve(model, "multigrid") for model in models))
            told = [f"{name:8s} {nodes:5d}"]
            for solution, model, seconds in zip(solutions, models, times, strict=True):
                error = np.abs(solution.deflection - exact(model.node_x, model.node_y)).max()
                told.append(f"{seconds:8.4f} {solution.iterations:3d} {error:8.1e}")
            print("   ".join([*told, f"{times[1] / times[0]:5.2f}"]))


if __name__ == "__main__":
    main()
