"""Contact on matrices that are no lattice's, against a linear solve and against Clarabel, as ratios in one run.

    python benchmarks/matrices.py                      # every measure, some minutes
    python benchmarks/matrices.py mesh beam            # some of them
    python benchmarks/matrices.py --largest 10000      # none larger

Measures:

    mesh       P1 elements on squares cut in two, nodes moved by a quarter of the spacing, at several sizes
    delaunay   P1 elements on a Delaunay mesh of random nodes
    beam       a beam on a floor: seconds, and how far the touchdown lies from (24 EI f/p)^(1/4), in spacings
    plate      a plate over a bowl, by thirteen points
    space      seven points in a cube
    jumps      five points with coefficients 1 and 1, 1e3 or 1e6 in a checkerboard of blocks, as a matrix and by
               multigrid on the lattice, and how many times what equal coefficients take, in turn
    disk       the five points of a disk, given as a matrix
    clarabel   Clarabel on the smallest of the meshes

The time of contact is that of making the problem, which proves what is needed of the matrix, and of `cq.solve` with tol
1e-6; the first is told apart, too. The linear solve is pyamg's of Gx = -q to 1e-10 by conjugate gradients, by smoothed
aggregation or as Ruge and Stueben have it, whichever is faster, set-up included; without pyamg (pip install
'.[benchmarks]') it is left out. Times are the least of ``--repeat`` runs, taken in turn.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse
from timing import in_turn, seconds

import contactqp as cq

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from meshes import (
    assembled,
    beam_on_floor,
    bowl_in_space,
    bowl_on_a_checkerboard,
    bowl_on_triangles,
    membrane_over_bowl,
    plate_over_bowl,
)

MEASURES = ["mesh", "delaunay", "beam", "plate", "space", "jumps", "disk", "clarabel"]
MESHES, RANDOM, BEAMS, PLATES = (149, 299, 999), (100_000, 1_000_000), (1000, 10_000, 100_000), (63, 127)
CUBES, JUMPS, DISKS = (64, 100), (1.0, 1e3, 1e6), (1 / 256,)


def delaunay(nodes: int) -> tuple[Any, np.ndarray]:
    from scipy.spatial import Delaunay

    side = np.linspace(0, 1, int(np.sqrt(nodes)) + 1)
    low, high = np.zeros_like(side), np.ones_like(side)
    edges = [(side, low), (side, high), (low[1:-1], side[1:-1]), (high[1:-1], side[1:-1])]
    border = np.concatenate([np.column_stack(edge) for edge in edges])
    places = np.concatenate([border, np.random.default_rng(0).uniform(0, 1, (nodes, 2))])
    free = np.arange(places.shape[0]) >= border.shape[0]
    return membrane_over_bowl(*assembled(places, Delaunay(places).simplices, free))


def linear(matrix: Any, q: np.ndarray) -> list[Callable[[], object]]:
    if not find_spec("pyamg"):
        return []
    import pyamg

    solvers = pyamg.smoothed_aggregation_solver, pyamg.ruge_stuben_solver
    given = sparse.csr_matrix(matrix)
    given.indptr, given.indices = (numbers.astype(np.int32) for numbers in (given.indptr, given.indices))
    return [lambda solver=solver: solver(given).solve(-q, tol=1e-10, accel="cg") for solver in solvers]


def report(name: str, matrix: Any, q: np.ndarray, repeat: int, *, with_linear: bool = True) -> cq.Solution:
    others = linear(matrix, q) if with_linear else []
    problem = cq.ContactQP(matrix, q)
    cq.solve(problem)
    whole, *rest = in_turn(repeat, lambda: cq.solve(cq.ContactQP(matrix, q)), *others)
    making = min(seconds(lambda: cq.ContactQP(matrix, q)) for _ in range(repeat))
    solution = cq.solve(problem)
    told_bound = f"bound {solution.relative_bound:.1e}"
    if solution.certificate is not None:
        told_bound += f", {solution.certificate.undecided.sum()} undecided"
    told = (
        f"{name:10} {q.size:8} unknowns: {whole:.3f} s ({1e6 * whole / q.size:.2f} µs each), {making:.3f} s for making"
    )
    if rest:
        told += f", {whole / min(rest):.2f} x pyamg's linear solve"
    print(f"{told}; {solution.status}, {told_bound}", flush=True)
    return solution


def membrane_on_a_checkerboard(nodes: int, block: int, jump: float) -> cq.Membrane:
    """Return the membrane whose stiffness is that of `bowl_on_a_checkerboard`."""
    number = np.arange(nodes) // block
    tension = np.where((number[:, None] + number) % 2 == 1, jump, 1.0)
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / (nodes + 1))
    support = 0.05 + 0.4 * ((lattice.node_x - 0.5) ** 2 + (lattice.node_y - 0.5) ** 2)
    return cq.Membrane(lattice, tension.ravel(), load=8.0, support=support)


def report_jumps(nodes: int, repeat: int) -> None:
    given = [bowl_on_a_checkerboard(nodes, 32, jump) for jump in JUMPS]
    membranes = [lambda jump=jump: membrane_on_a_checkerboard(nodes, 32, jump) for jump in JUMPS]
    ways = [lambda case=case: cq.solve(cq.ContactQP(*case)) for case in given]
    ways += [lambda make=make: cq.solve(make(), "multigrid") for make in membranes]
    for way in ways:
        way()
    times = in_turn(repeat, *ways)
    for name, found in (("matrix", times[: len(JUMPS)]), ("lattice", times[len(JUMPS) :])):
        rows = zip(JUMPS, found, strict=True)
        ratios = ", ".join(f"{jump:.0e}: {time:.2f} s ({time / found[0]:.1f} x)" for jump, time in rows)
        print(f"jumps, {name}: {ratios}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measures", nargs="*", default=MEASURES)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--largest", type=int, default=1_000_000)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    if "mesh" in asked.measures:
        for nodes in (nodes for nodes in MESHES if nodes**2 <= asked.largest):
            report("mesh", *bowl_on_triangles(nodes), asked.repeat)
    if "delaunay" in asked.measures:
        for nodes in (nodes for nodes in RANDOM if nodes <= asked.largest):
            report("delaunay", *delaunay(nodes), asked.repeat)
    if "beam" in asked.measures:
        for nodes in (nodes for nodes in BEAMS if nodes <= asked.largest):
            matrix, q, spacing = beam_on_floor(nodes)
            solution = report("beam", matrix, q, asked.repeat, with_linear=False)
            touchdown = spacing * (1 + np.flatnonzero(solution.gap == 0)[0])
            print(f"           touchdown off by {abs(touchdown - 12.0**0.25) / spacing:.2f} spacings")
    if "plate" in asked.measures:
        for nodes in (nodes for nodes in PLATES if nodes**2 <= asked.largest):
            report("plate", *plate_over_bowl(nodes), asked.repeat, with_linear=False)
    if "space" in asked.measures:
        for nodes in (nodes for nodes in CUBES if nodes**3 <= asked.largest):
            report("space", *bowl_in_space(nodes), asked.repeat)
    if "jumps" in asked.measures:
        nodes = min(512, int(asked.largest**0.5))
        for jump in JUMPS:
            report(f"jumps {jump:.0e}", *bowl_on_a_checkerboard(nodes, 32, jump), asked.repeat)
        report_jumps(nodes, asked.repeat)
    if "disk" in asked.measures:
        for spacing in (spacing for spacing in DISKS if np.pi / spacing**2 <= 1.1 * asked.largest):
            disk = cq.Membrane(cq.Frame.disk(1.0).lattice(spacing), 1.0, load=8.0, support=0.3).problem
            report("disk", disk.G, disk.q, asked.repeat)
    if "clarabel" in asked.measures:
        problem = cq.ContactQP(*bowl_on_triangles(min(MESHES[0], int(asked.largest**0.5))))
        own, other = in_turn(1, lambda: cq.solve(problem), lambda: cq.solve(problem, "clarabel"))
        print(f"clarabel   {problem.size:8} unknowns: {other:.2f} s, {other / own:.0f} x active sets")


if __name__ == "__main__":
    main()
