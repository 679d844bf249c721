"""PETSc's SNESVI, on one rank and two, beside the package's own methods, certified to the same tolerance.

    contactqp bench run benchmarks/petsc.py                   # up to 1023 x 1023 nodes, and a mesh of 10^6 unknowns
    contactqp bench run benchmarks/petsc.py --largest 255     # smaller ones

The time is that of `cq.solve` with tol 1e-6, of a problem that is made before, without what the loading of libraries
and the start of PETSc's worker take. PETSc is timed once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import contactqp as cq
from contactqp.benchmark import Phase, Spec
from contactqp.foundation.loading import working_seconds

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from meshes import bowl_on_triangles


def solved(backend: str, **options: Any) -> Callable[[Any], cq.Solution]:
    return lambda problem: cq.solve(problem, backend, tol=1e-6, on_failure="ignore", **options)


PETSC = {f"petsc, {ranks} rank{'s'[: ranks - 1]}": Phase(solved("petsc", ranks=ranks), once=True) for ranks in (1, 2)}

SPECS = (
    Spec(
        "lattice",
        "a bowl on the unit square",
        lambda nodes: cq.gallery.bowl(nodes).problem,
        (63, 127, 255, 511, 1023),
        {"multigrid": solved("multigrid"), "active-set": solved("active-set"), **PETSC},
        size=lambda problem: problem.size,
        smoke=15,
        clock=working_seconds,
    ),
    Spec(
        "mesh",
        "linear elements on squares cut in two, nodes moved by a quarter of the spacing",
        lambda nodes: cq.ContactQP(*bowl_on_triangles(nodes)),
        (100, 300, 1000),
        {"active-set": solved("active-set"), **PETSC},
        size=lambda problem: problem.size,
        smoke=15,
        clock=working_seconds,
    ),
)
