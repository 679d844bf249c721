"""Two processes, of which the first waits within MPI for the second, which reads its rows and never comes to an end."""

import os
import time
from pathlib import Path

from mpi4py import MPI

import contactqp as cq
from contactqp.foundation.interrupts import ended_by_interrupts
from contactqp.mpi.ranks import Ranks

RANK = MPI.COMM_WORLD.rank


def load(x, y):
    if y[0] == 0.0 or RANK == 1:
        Path(str(RANK)).write_text(str(os.getpid()))
    if RANK == 1:
        time.sleep(300)
    return 1.0


if __name__ == "__main__":
    with ended_by_interrupts(), Ranks().ended_together():
        cq.mpi.solve(cq.mpi.MembraneByRows((64, 20), 1.0, 1.0, load=load, support=0.1), least_rows=16)
