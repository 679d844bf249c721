"""What dividing a lattice among processes costs, by MPI on this machine.

    python benchmarks/ranks.py                               # 2047², about two minutes
    python benchmarks/ranks.py --nodes 8191 --processes 1x2 2x1
    python benchmarks/ranks.py --nodes 1023 --weak           # so many rows for each process

A setting ``PxT`` is P processes of T threads each. Printed are the seconds of a solve on a square over a paraboloid,
with its model's rows, and of a cycle on the finest lattice; the messages that a process sends in such a cycle, and
their bytes; and the largest memory of a process. Times are the least of ``--repeat`` runs of all settings in turn; what
is loaded and compiled before counts nowhere.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

SETTINGS = "1x1", "1x2", "2x1", "4x1"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--nodes", type=int, default=2047)
    parser.add_argument("--processes", nargs="+", default=SETTINGS)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--weak", action="store_true")
    parser.add_argument("--worker", type=int, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.worker:
        work(asked.nodes, asked.worker, weak=asked.weak)
        return
    least: dict[str, dict[str, float]] = {}
    for _ in range(asked.repeat):
        for setting in asked.processes:
            found = measured(setting, asked.nodes, weak=asked.weak)
            kept = least.setdefault(setting, found)
            least[setting] = {name: min(value, kept[name]) for name, value in found.items()}
    for setting, found in least.items():
        told = "{rows:.0f} rows: {seconds:.2f} s, {cycles:.0f} cycles of {milliseconds:.0f} ms; "
        told += "a process: {memory:.2f} GB, {messages:.0f} messages and {megabytes:.2f} MB a cycle"
        units = {"milliseconds": 1e3 * found["cycle"], "megabytes": found["sent"] / 1e6}
        print(f"{setting:>5}  {told.format(**found, **units)}")


def measured(setting: str, nodes: int, *, weak: bool) -> dict[str, float]:
    processes, threads = setting.split("x")
    mpiexec = shutil.which("mpiexec", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    command = [str(mpiexec), "-n", processes, sys.executable, __file__, "--nodes", str(nodes), "--worker", threads]
    ended = subprocess.run([*command, *["--weak"] * weak], stdout=subprocess.PIPE, text=True, check=True)
    return dict(json.loads(ended.stdout))


def work(nodes: int, threads: int, *, weak: bool) -> None:
    import resource

    from mpi4py import MPI

    import contactqp as cq

    def square(rows: int) -> cq.mpi.MembraneByRows:
        def hill(x: float, y: float) -> float:
            return 0.02 + 0.2 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)

        return cq.mpi.MembraneByRows((rows, nodes), 1 / (nodes + 1), 1.0, load=1.0, support=hill)

    world = MPI.COMM_WORLD
    cq.mpi.solve(square(127 * world.size), world, threads=threads)
    rows = nodes * world.size if weak else nodes
    answer = cq.mpi.solve(square(rows), world, tol=1e-6, threads=threads)
    memory = world.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, MPI.MAX)
    if world.rank == 0:
        numbers = {"rows": rows, "seconds": answer.seconds, "cycles": answer.iterations, "cycle": answer.cycle_seconds}
        print(json.dumps({**numbers, "messages": answer.messages, "sent": answer.sent, "memory": memory}))


if __name__ == "__main__":
    main()
