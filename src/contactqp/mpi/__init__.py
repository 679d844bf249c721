"""Contact on lattices that no process holds whole: rows divided among the processes of an MPI communicator.

Every process builds the same `MembraneByRows`, and calls `solve`, which returns an `AnswerByRows`::

    from mpi4py import MPI
    import contactqp as cq

    membrane = cq.mpi.MembraneByRows((4095, 4095), 1 / 4096, 1.0, load=1.0, support=0.05)
    answer = cq.mpi.solve(membrane, MPI.COMM_WORLD)
    answer.to_zarr("result.zarr")

It needs ``pip install 'contactqp[mpi]'``, and is started by ``mpiexec -n 4 python program.py``.
"""

from .answer import AnswerByRows
from .cases import membrane_of_case
from .membrane import MembraneByRows
from .solve import solve
from .solver import Solver
from .trace import Step, trace

__all__ = ["AnswerByRows", "MembraneByRows", "Solver", "Step", "membrane_of_case", "solve", "trace"]
