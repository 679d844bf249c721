"""trace(): one membrane under several loads, by many processes, which leave a store for each."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..foundation.brackets import Bracket
from ..foundation.checks import finite_number, integer_at_least
from ..foundation.files import made_folder
from ..methods.multigrid.strips import LEAST_ROWS
from ..solving.request import Request
from .membrane import MembraneByRows, require_rows
from .posed import PosedByRows
from .ranks import Ranks
from .solve import solve_posed
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

    A store appears when it is whole. Called again, after the processes have been killed for instance, it goes on after
    the stores that are there, if they are of the same data and a tolerance that is no larger; the number of processes
    may be another, for the bits are the same.

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
    require_rows(membrane)
    request, threads = Request.of(tol, None, None), integer_at_least(threads, 1, "threads")
    ranks, factors = Ranks(comm), [finite_number(factor, f"loads[{k}]") for k, factor in enumerate(loads)]
    place = ranks.agreed(lambda: made_folder(Path(folder)))
    steps = []
    for number, factor in enumerate(factors):
        started, store = time.perf_counter(), place / f"load-{number:04d}.zarr"
        posed = PosedByRows(membrane.with_load(factor), ranks, least_rows, threads)
        wanted = posed.fingerprint
        known = ranks.everyones([facts_of_store(store)] if ranks.rank == 0 else [])[0]
        resumed = known.get("fingerprint") == wanted and known.get("tol", 1.0) <= tol
        if not resumed:
            answer = solve_posed(posed, request, threads, started)
            numbers = {"contact_area": list(answer.contact_area), "total_reaction": list(answer.total_reaction)}
            own = {"fingerprint": wanted, "load_factor": factor, **numbers}
            answer.to_zarr(store, own)
            known = {"status": answer.status.value, "gap_error_bound": answer.gap_bound, **own}
        steps.append(_step(factor, store, known, resumed=resumed))
    return steps


def _step(factor: float, store: Path, facts: dict[str, Any], *, resumed: bool) -> Step:
    area, reaction = (Bracket(*map(float, facts[name])) for name in ("contact_area", "total_reaction"))
    return Step(factor, store, str(facts["status"]), float(facts["gap_error_bound"]), area, reaction, resumed)
