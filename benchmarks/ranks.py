"""What dividing a lattice among processes costs, by MPI on this machine.

    contactqp bench run benchmarks/ranks.py
    contactqp bench run benchmarks/ranks.py divided --points 8191 --phases "1x2,2x1"

A phase ``PxT`` is P processes of T threads each, on a square over a paraboloid. The time of a line is that of the whole
program, with Python's start; what counts are "solve s", the seconds of a solve with the reading of its model after one
that has loaded and compiled all, "cycle ms", the milliseconds of a cycle on the finest lattice, "messages" and "MB",
what a process sends in such a cycle, and "GB", the largest memory of a process. Of "weak" each process has as many rows
as the point says. More processes than cores take turns.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from contactqp.benchmark import Phase, Spec

WORKER = """
import json, resource, sys
from mpi4py import MPI
import contactqp as cq

columns, rows, threads = map(int, sys.argv[1:])
world = MPI.COMM_WORLD

def hill(x, y):
    return 0.02 + 0.2 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)

def solved(rows):
    membrane = cq.mpi.MembraneByRows((rows, columns), 1 / (columns + 1), 1.0, load=1.0, support=hill)
    return cq.mpi.solve(membrane, world, tol=1e-6, threads=threads)

solved(min(rows, 127 * world.size))
answer = solved(rows)
memory = world.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, MPI.MAX)
if world.rank == 0:
    facts = {"rows": rows, "solve s": answer.seconds, "cycle ms": 1e3 * answer.cycle_seconds, "GB": memory}
    print(json.dumps({**facts, "cycles": answer.iterations, "messages": answer.messages, "MB": answer.sent / 1e6}))
"""


def by_processes(processes: int, threads: int, *, weak: bool = False) -> Callable[[int], dict[str, Any]]:
    """Return what solves a square of so many nodes along a side, or for each process so many rows."""

    def run(nodes: int) -> dict[str, Any]:
        mpiexec = shutil.which("mpiexec", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
        size = [nodes, nodes * processes if weak else nodes, threads]
        command = [str(mpiexec), "-n", str(processes), sys.executable, "-c", WORKER, *map(str, size)]
        done = subprocess.run(command, text=True, check=True, stdout=subprocess.PIPE)
        found: dict[str, Any] = json.loads(done.stdout)
        return found

    return run


def phase(processes: int, threads: int, *, weak: bool = False) -> Phase:
    return Phase(by_processes(processes, threads, weak=weak), needs=("mpi4py",), once=True)


SPECS = (
    Spec(
        "divided",
        "one square by processes and threads",
        int,
        (2047,),
        {
            f"{processes}x{threads}": phase(processes, threads)
            for processes, threads in ((1, 1), (1, 2), (2, 1), (4, 1))
        },
        smoke=127,
    ),
    Spec(
        "weak",
        "as many rows for each process",
        int,
        (1023,),
        {f"{processes}x1": phase(processes, 1, weak=True) for processes in (1, 2, 4)},
        smoke=127,
    ),
)
