"""Solver: a session of many processes that solves one membrane under many loads."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Mask, Vector, integer_at_least
from ..foundation.keywords import known_by_name
from ..methods.multigrid.nested import Succession
from ..methods.multigrid.strips import LEAST_ROWS
from ..solving.prediction import Everywhere, Trail
from ..solving.request import Request
from .answer import AnswerByRows
from .membrane import MembraneByRows, require_rows
from .posed import PosedByRows
from .ranks import Ranks
from .solve import solve_posed
from .starts import Start, WarmStart, start_of

if TYPE_CHECKING:
    from mpi4py import MPI


class AllRows(Everywhere):
    """What is asked of all processes' nodes together, where vectors hold those of some rows."""

    def __init__(self, posed: PosedByRows) -> None:
        self._posed = posed

    def inner(self, one: Vector, other: Vector) -> float:
        """See `Everywhere`; summed block by block."""
        return self._posed.total(one * other)

    def largest(self, values: Vector) -> float:
        """See `Everywhere`."""
        own = values[self._posed.own]
        return max(self._posed.part.everyones([super().largest(own)]))

    def count(self, chosen: Mask) -> int:
        """See `Everywhere`."""
        return sum(self._posed.part.everyones([super().count(chosen[self._posed.own])]))


class Solver:
    """A session: one membrane by rows, and what is kept of it from solve to solve; all processes must call it alike.

    Rows are read, the stiffness is proven to be an M-matrix, and the multigrid's hierarchy is set up once. Each solve
    starts from the last answer, or from what the last few let expect where the loads go on in one direction, as
    `contactqp.Solver` does. Answers are the same to the bit for any number of processes. What is kept about doubles the
    memory: the coarser lattices' iterations, and the last three answers.

    Parameters
    ----------
    membrane : MembraneByRows
        The same in every process.
    comm, tol, max_iter, time_limit, threads, least_rows
        See `contactqp.mpi.solve`; for every solve of the session.

    Attributes
    ----------
    membrane : MembraneByRows
    ranks : Ranks
        The processes.

    Raises
    ------
    ImportError
        If mpi4py is not installed.
    TypeError, ValueError
        If an argument is no good.

    Examples
    --------
    >>> import contactqp as cq
    >>> membrane = cq.mpi.MembraneByRows((63, 63), 1 / 64, 1.0, load=1.0, support=0.05)
    >>> solver = cq.mpi.Solver(membrane)
    >>> [solver.solve(load=load).node_counts[0] for load in (0.8, 1.0, 1.2)]
    [145, 393, 605]
    >>> solver.solve(load=lambda x, y: 2.0 * x).status.value
    'certified'
    """

    def __init__(
        self,
        membrane: MembraneByRows,
        comm: MPI.Comm | None = None,
        *,
        tol: float | str = 1e-6,
        max_iter: int | None = None,
        time_limit: float | None = None,
        threads: int = 1,
        least_rows: int = LEAST_ROWS,
    ) -> None:
        require_rows(membrane)
        self.membrane = membrane
        self._request = Request.of(tol, max_iter, time_limit)
        self._threads = integer_at_least(threads, 1, "threads")
        self._least = integer_at_least(least_rows, 1, "least_rows")
        self.ranks = Ranks(comm)
        self._posed: PosedByRows | None = None
        self._last: Vector | None = None

    @known_by_name
    def solve(self, *, load: Any = None, warm_start: bool | WarmStart = True) -> AnswerByRows:
        """Solve the session's membrane, or the same under another load.

        Parameters
        ----------
        load : number, function or array, optional
            Given and positive as when the membrane was made; by default as it was then, whatever was solved before.
        warm_start : bool, AnswerByRows or path
            Whether to start from the session's last answers, which is the default; or what to start from, see
            `contactqp.mpi.solve`.

        Returns
        -------
        AnswerByRows

        Raises
        ------
        ImportError, OSError, TypeError, ValueError
            See `contactqp.mpi.solve`; in every process.
        """
        return self.solve_varied(self.membrane if load is None else self.membrane.under(load), warm_start)

    def solve_varied(self, membrane: MembraneByRows, warm_start: bool | WarmStart = True) -> AnswerByRows:
        """Solve a membrane that differs from the session's in its load alone.

        Parameters
        ----------
        membrane : MembraneByRows
            As `MembraneByRows.with_load` and `MembraneByRows.under` return it.
        warm_start : bool, AnswerByRows or path
            See `solve`.

        Raises
        ------
        ValueError
            If it differs in anything else.
        """
        started = time.perf_counter()
        given: WarmStart = None
        resumes = False
        if isinstance(warm_start, (bool, np.bool_)):
            resumes = bool(warm_start)
        else:
            given = warm_start
        told = "the session's last answers" if resumes else "no warm start"
        start = start_of(given, self.membrane, self.ranks, told)
        posed = self.posed(membrane, start)
        gap, predicted = None if start is None else start.gap, False
        if resumes:
            gap, predicted = self._trail.predicted(posed.problem) or (self._last, False)
        answer = self.answered(posed, started, gap, predicted=predicted, resumes=resumes)
        self._last = answer.measures.gap if np.isfinite(answer.gap_bound) else None
        if self._last is None:
            self._trail.clear()
        else:
            self._trail.add(posed.problem, self._last)
        return answer

    def posed(self, membrane: MembraneByRows, start: Start | None = None) -> PosedByRows:
        """Return the problem of a membrane that differs in its load alone; what it is to start from is read, too."""
        require_rows(membrane)
        if not self.membrane.differs_in_load_alone(membrane):
            raise ValueError(
                f"membrane must differ in its load alone from that of the session, {self.membrane!r}, as its with_load "
                f"and under return it, got {membrane!r}; make a Solver for it"
            )
        if self._posed is None:
            self._posed = PosedByRows(
                membrane, self.ranks, self._least, self._threads, None if start is None else start.read
            )
            self._problems = Succession(self._posed.lattice, keeps=True)
            self._trail = Trail(AllRows(self._posed))
        else:
            if start is not None:
                start.read(self._posed)
            self._posed = self._posed.under(membrane)
        return self._posed

    def answered(
        self,
        posed: PosedByRows,
        started: float,
        start: Vector | None = None,
        *,
        predicted: bool = False,
        resumes: bool = False,
    ) -> AnswerByRows:
        """Return the answer to what `posed` has returned, from a gap to start from; see `solve_posed`."""
        how = {"predicted": predicted, "resumes": resumes}
        return solve_posed(posed, self._request, self._threads, started, self._problems, start, **how)

    def __repr__(self) -> str:
        return f"Solver({self.membrane!r}, tol {self._request.tolerance})"
