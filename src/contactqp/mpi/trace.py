"""trace(): one membrane under several loads, by many processes, which leave a store for each."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Vector, finite_number
from ..foundation.files import made_folder
from ..methods.multigrid.strips import LEAST_ROWS
from ..solving.prediction import KEPT, Known, extrapolated
from .membrane import MembraneByRows
from .posed import PosedByRows
from .solver import AllRows, Solver
from .starts import gap_of_store
from .store import facts_of_store

if TYPE_CHECKING:
    from mpi4py import MPI


@dataclass(frozen=True)
class Step:
    """One load of a `trace`.

    Attributes
    ----------
    factor : float
        By which the membrane's load is multiplied.
    store : Path
        Where the answer is.
    status : str
        ``"certified"`` if the error is proven to be within the tolerance.
    gap_bound : float
        Proven bound of the gap's error (length).
    contact_area, total_reaction : Bracket
        Area in contact, and the sum of the reactions (force).
    resumed : bool
        Whether the store had been there before.
    """

    factor: float
    store: Path
    status: str
    gap_bound: float
    contact_area: Bracket
    total_reaction: Bracket
    resumed: bool


def trace(
    membrane: MembraneByRows,
    loads: Iterable[float],
    folder: str | Path,
    comm: MPI.Comm | None = None,
    *,
    tol: float = 1e-6,
    threads: int = 1,
    least_rows: int = LEAST_ROWS,
) -> list[Step]:
    """Solve a membrane under several loads, one after the other, and write a Zarr store of each; all must call it.

    What does not depend on the load is set up once. From the third load on each solve starts from what the stores of
    the last three let expect, where contact grows from load to load; else from coarser lattices.

    A store appears when it is whole. Called again, after the processes have been killed for instance, it goes on after
    the stores that are there, if they are of the same data and a tolerance that is no larger; the number of processes
    may be another, for the bits are the same, and those that follow start from the stores as they would have before.

    Parameters
    ----------
    membrane : MembraneByRows
    loads : iterable of float
        Factors of its load.
    folder : str or Path
        Made if it is missing; the stores in it are called ``load-0000.zarr`` and so on.
    comm, tol, threads, least_rows
        See `solve`.

    Returns
    -------
    list of Step
        The same in every process.

    Raises
    ------
    ImportError, OSError, TypeError, ValueError
        See `solve`; or if a store cannot be written; in every process.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> membrane = cq.mpi.MembraneByRows((63, 63), 1 / 64, 1.0, load=1.0, support=0.05)
    >>> steps = cq.mpi.trace(membrane, [0.5, 1.0], tempfile.mkdtemp())
    >>> [step.status for step in steps], steps[0].contact_area.upper < steps[1].contact_area.lower
    (['certified', 'certified'], True)
    """
    session = Solver(membrane, comm, tol=tol, threads=threads, least_rows=least_rows)
    ranks, factors = session.ranks, [finite_number(factor, f"loads[{k}]") for k, factor in enumerate(loads)]
    place = ranks.agreed(lambda: made_folder(Path(folder)))
    steps: list[Step] = []
    for number, factor in enumerate(factors):
        started, store = time.perf_counter(), place / f"load-{number:04d}.zarr"
        posed = session.posed(membrane.with_load(factor))
        wanted = posed.fingerprint
        known = ranks.everyones([facts_of_store(store)] if ranks.rank == 0 else [])[0]
        resumed = known.get("fingerprint") == wanted and known.get("tol", 1.0) <= tol
        if not resumed:
            start = _expected(steps, factor, posed)
            answer = session.answered(posed, started, start, predicted=True)
            numbers = {"contact_area": list(answer.contact_area), "total_reaction": list(answer.total_reaction)}
            own = {"fingerprint": wanted, "load_factor": factor, **numbers}
            answer.to_zarr(store, own)
            known = {"status": answer.status.value, "gap_error_bound": answer.gap_bound, **own}
        steps.append(_step(factor, store, known, resumed=resumed))
    return steps


def _expected(steps: list[Step], factor: float, posed: PosedByRows) -> Vector | None:
    """Return the gap (length) that the stores of the last steps let expect; None where it had better be a cold start.

    It is read from the stores, not from memory, so that it is the same where the trace was interrupted before.
    """
    last: list[Step] = []
    for step in steps:
        if np.isfinite(step.gap_bound):
            last = [*(one for one in last[1 - KEPT :] if one.factor != step.factor), step]
    if last and last[-1].factor == factor:
        return gap_of_store(last[-1].store, posed)
    if len(last) < 2:
        return None
    known = [Known(step.factor, gap_of_store(step.store, posed), posed.problem.bounds) for step in last]
    found = extrapolated(known, factor - last[-1].factor, AllRows(posed))
    return found[0] if found is not None and found[1] else None


def _step(factor: float, store: Path, facts: dict[str, Any], *, resumed: bool) -> Step:
    area, reaction = (Bracket(*map(float, facts[name])) for name in ("contact_area", "total_reaction"))
    return Step(factor, store, str(facts["status"]), float(facts["gap_error_bound"]), area, reaction, resumed)
