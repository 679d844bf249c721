"""solve(): the contact multigrid of many processes, each of which holds some rows."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..backends.base import Stop
from ..backends.multigrid import MAX_CYCLES, CycleLog
from ..foundation.checks import Vector, integer_at_least
from ..foundation.text import counted
from ..foundation.threads import Team
from ..methods.multigrid.nested import Succession
from ..methods.multigrid.strips import LEAST_ROWS
from ..methods.multigrid.weighted_hierarchy import load_kernels
from ..proof.status import Status
from ..solving.request import Request
from .answer import AnswerByRows
from .membrane import MembraneByRows, require_rows
from .posed import MeasuresOfRows, PosedByRows
from .ranks import Ranks
from .starts import WarmStart, start_of

if TYPE_CHECKING:
    from mpi4py import MPI

_LIMITS = {
    Stop.DONE: Status.INACCURATE,
    Stop.ITERATION_LIMIT: Status.ITERATION_LIMIT,
    Stop.TIME_LIMIT: Status.TIME_LIMIT,
    Stop.FAILED: Status.INACCURATE,
}


def solve(
    membrane: MembraneByRows,
    comm: MPI.Comm | None = None,
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    warm_start: WarmStart = None,
    threads: int = 1,
    least_rows: int = LEAST_ROWS,
) -> AnswerByRows:
    """Solve a membrane whose rows are divided among the processes of a communicator; all of them must call it.

    The answer is the same to the bit for any number of processes. It is certified by the fast certificate of
    `contactqp.certify`, which all processes take together, and never gathered.

    Parameters
    ----------
    membrane : MembraneByRows
        The same in every process.
    comm : mpi4py.MPI.Comm, optional
        By default all processes that were started together.
    tol, max_iter, time_limit
        See `contactqp.solve`; the clock is that of the first process.
    warm_start : AnswerByRows or path, optional
        An earlier answer on the same lattice, under any load, to start from in the place of coarser lattices: one of
        the same processes' rows, or the path of a Zarr store that `AnswerByRows.to_zarr` has written, by any number of
        processes. It is clipped to what is admissible; one whose energy is more than that of the gap zero is not used.
    threads : int
        Threads of each process.
    least_rows : int
        Rows a process below which the strips of a coarse level are merged.

    Returns
    -------
    AnswerByRows

    Raises
    ------
    ImportError
        If mpi4py is not installed, or a store is given, and zarr is not.
    OSError
        If a store cannot be read; in every process.
    TypeError, ValueError
        If an argument is no good, or there are too many processes for so few rows; or if what is to be started from
        belongs to another lattice or other rows, or is not finite; in every process.

    Examples
    --------
    >>> import contactqp as cq
    >>> membrane = cq.mpi.MembraneByRows((63, 63), 1 / 64, 1.0, load=1.0, support=0.05)
    >>> answer = cq.mpi.solve(membrane)
    >>> answer.status.value, answer.gap.shape
    ('certified', (63, 63))
    >>> sharper = cq.mpi.solve(membrane, tol=1e-9, warm_start=answer)
    >>> sharper.status.value, sharper.iterations < cq.mpi.solve(membrane, tol=1e-9).iterations
    ('certified', True)
    """
    require_rows(membrane)
    request = Request.of(tol, max_iter, time_limit)
    threads, least_rows = integer_at_least(threads, 1, "threads"), integer_at_least(least_rows, 1, "least_rows")
    started, ranks = time.perf_counter(), Ranks(comm)
    start = start_of(warm_start, membrane, ranks)
    posed = PosedByRows(membrane, ranks, least_rows, threads, None if start is None else start.read)
    problems = Succession(posed.lattice, keeps=False)
    return solve_posed(posed, request, threads, started, problems, None if start is None else start.gap)


def solve_posed(
    posed: PosedByRows,
    request: Request,
    threads: int,
    started: float,
    problems: Succession,
    start: Vector | None = None,
    *,
    predicted: bool = False,
    resumes: bool = False,
) -> AnswerByRows:
    """Solve what has been posed already, see `solve`.

    Parameters
    ----------
    posed : PosedByRows
    request : Request
    threads : int
    started : float
        When the work began, by ``time.perf_counter()``.
    problems : Succession
        Those on the lattice, of which this is the next.
    start : array, shape (n,), optional
        A gap to start from (length).
    predicted, resumes : bool
        Where that comes from, see `contactqp.backends.base.Task`.
    """
    ranks = posed.ranks
    task = _Task(posed, request, threads, started)
    log = CycleLog(posed.lattice.reach)
    load_kernels(posed.lattice)
    setup_seconds = time.perf_counter() - started
    outcome: tuple[Stop, str] | None = None
    with Team(threads) as team:
        useful = None if start is None else posed.useful(start)
        unit = float(np.max(posed.units.length))
        if useful is None:
            predicted = resumes = False
        solver = problems.begun(posed.scaled(), team, useful, unit=unit, predicted=predicted, resumes=resumes)
        del start, useful  # of which the iteration keeps what it needs
        before, began = (ranks.messages, ranks.sent), time.perf_counter()
        while outcome is None:
            solver.relax()
            log.add(solver.estimate)
            outcome = log.outcome(solver, task, request.max_iter or MAX_CYCLES)
            if outcome is None:
                solver.correct()
    stop, why = outcome
    cycle_seconds = (time.perf_counter() - began) / log.cycles
    messages, sent = (now - then for now, then in zip((ranks.messages, ranks.sent), before, strict=True))
    gap = posed.lattice.layout.vector(solver.omega) if log.judged is None else log.judged
    del solver
    measures = task.measured(gap)
    certificate = measures.certificate()
    good = certificate.gap_bound <= task.tol * measures.scale
    return AnswerByRows(
        posed=posed,
        tol=task.tol,
        status=Status.CERTIFIED if good else _LIMITS[stop],
        termination=f"{why} after {counted(log.cycles, 'cycle')}",
        measures=measures,
        certificate=certificate,
        iterations=log.cycles,
        setup_seconds=setup_seconds,
        seconds=time.perf_counter() - started,
        cycle_seconds=cycle_seconds,
        messages=messages / log.cycles,
        sent=sent / log.cycles,
    )


@dataclass
class _Task:
    """What a cycle's log asks of a task, answered by all processes together."""

    posed: PosedByRows
    request: Request
    threads: int
    started: float
    _gap: Vector | None = None
    _measures: MeasuresOfRows | None = None

    @property
    def tol(self) -> float:
        """See `contactqp.backends.base.Task`."""
        return self.request.tolerance.tol

    @property
    def seconds_left(self) -> float:
        """Seconds until the time limit, by the clock of the first process."""
        if self.request.time_limit is None:
            return np.inf
        left = self.request.time_limit - (time.perf_counter() - self.started)
        return self.posed.ranks.everyones([left])[0]

    def bound(self, gap: Vector) -> float:
        """Return the bound of a dimensionless gap's error, relative to the error scale."""
        return self.measured(gap).relative_estimate

    def measured(self, gap: Vector) -> MeasuresOfRows:
        """Return the measures of a dimensionless gap; those of the last one are kept."""
        if self._measures is None or gap is not self._gap:
            posed = self.posed
            self._measures, self._gap = posed.measures(posed.units.gap(gap), self.threads), gap
        return self._measures
