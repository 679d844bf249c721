"""PETSc's SNESVI beside the package's own methods, certified to the same tolerance, as ratios in one run.

    python benchmarks/petsc.py                              # 1023 x 1023 nodes, and a mesh of 10^6 unknowns
    python benchmarks/petsc.py --nodes 255 --ranks 1 2 4    # smaller, on as many ranks

Measures:

    lattice    a bowl on NODES x NODES inner nodes: `petsc` with GAMG beside `multigrid` and `active-set`
    mesh       P1 elements on squares cut in two, nodes moved by a quarter of the spacing: beside `active-set`

The time is that of `cq.solve` with tol 1e-6, of a problem that is made before; the loading of libraries and the start
of the worker's interpreter are counted apart, and told. Each is called once to warm up, then ``--repeat`` times in
turn; the least counts.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from timing import seconds

import contactqp as cq

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from meshes import bowl_on_triangles

MEASURES = ["lattice", "mesh"]


class Way:
    """A way to solve a problem: its times, and its last answer."""

    def __init__(self, problem: Any, backend: str, **options: Any) -> None:
        self.name = ", ".join([backend, *(f"{name}={value}" for name, value in options.items())])
        self._problem, self._asked = problem, (backend, options)
        self._times: list[float] = []

    def run(self) -> None:
        """Solve the problem once."""
        backend, options = self._asked
        whole = seconds(lambda: self._solve(backend, options))
        self._times.append(whole - self.solution.loading_seconds)

    def _solve(self, backend: str, options: dict[str, Any]) -> None:
        self.solution = cq.solve(self._problem, backend, tol=1e-6, on_failure="ignore", **options)

    @property
    def least(self) -> float:
        """The least time of all runs but the first, without what loading took."""
        return min(self._times[1:] or self._times)


def report(name: str, problem: Any, own: list[str], ranks: list[int], repeat: int) -> None:
    ways = [Way(problem, backend) for backend in own] + [Way(problem, "petsc", ranks=number) for number in ranks]
    for _ in range(repeat + 1):
        for way in ways:
            way.run()
    for way in ways:
        solution, ratio = way.solution, way.least / ways[0].least
        print(
            f"{name}: {way.name:16} {way.least:8.3f} s, {ratio:6.1f} x {ways[0].name}; {solution.iterations} "
            f"{solution.iteration_unit}s, {solution.status}, bound {solution.relative_bound:.1e}, and "
            f"{solution.loading_seconds:.2f} s for loading",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measures", nargs="*", default=MEASURES, help=f"of {', '.join(MEASURES)}")
    parser.add_argument("--nodes", type=int, default=1023, help="inner nodes along a side of the lattice")
    parser.add_argument("--mesh", type=int, default=1000, help="inner nodes along a side of the mesh")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeat", type=int, default=1)
    asked = parser.parse_args()
    if "lattice" in asked.measures:
        size = f"lattice of {asked.nodes} x {asked.nodes} nodes"
        report(size, cq.gallery.bowl(asked.nodes), ["multigrid", "active-set"], asked.ranks, asked.repeat)
    if "mesh" in asked.measures:
        problem = cq.ContactQP(*bowl_on_triangles(asked.mesh))
        report(f"mesh of {problem.size} unknowns", problem, ["active-set"], asked.ranks, asked.repeat)


if __name__ == "__main__":
    main()
