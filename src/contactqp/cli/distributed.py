"""``contactqp solve`` in several processes that mpiexec has started."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ..foundation.loading import needed
from ..io.zarr_stores import INSTALL
from .application import EXIT_BAD_INPUT, EXIT_NOT_CERTIFIED, EXIT_OK, check_output

if TYPE_CHECKING:
    from ..mpi.ranks import Ranks

_SIZES = "OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"
"""Variables of the environment in which launchers tell how many processes they have started."""


def processes_started() -> int:
    """Return how many processes of an MPI program this is one of; 1 where no launcher says so."""
    told = [os.environ[name] for name in _SIZES if name in os.environ]
    if "PMIX_RANK" in os.environ:  # as Slurm's srun starts processes
        told.append(os.environ.get("SLURM_NTASKS", "1"))
    return max((int(size) for size in told if size.isdigit()), default=1)


def solve_together(
    case: Path,
    backend: str,
    tol: float | str,
    time_limit: float | None,
    out: Path | None,
    plot: Path | None,
    warm_start: Path | None = None,
) -> int:
    """Solve a case in all processes, and return the exit code; the first one prints.

    Raises
    ------
    Exception
        In the first process, if all of them fail alike; what one process alone meets with ends all.
    """
    from ..mpi.ranks import Ranks

    ranks = Ranks()
    try:
        with ranks.ended_together():
            return _solved(ranks, case, backend, tol, time_limit, out, plot, warm_start)
    except Exception:
        if ranks.rank == 0:
            raise
        return EXIT_BAD_INPUT


def _solved(
    ranks: Ranks,
    case: Path,
    backend: str,
    tol: float | str,
    time_limit: float | None,
    out: Path | None,
    plot: Path | None,
    warm_start: Path | None,
) -> int:
    if ranks.size == 1:
        raise ValueError(
            f"{processes_started()} processes were started, but each is alone by its MPI: mpiexec belongs to another "
            "MPI than mpi4py; start them by the mpiexec of that"
        )
    if backend not in ("auto", "multigrid"):
        raise ValueError(f"--backend {backend}: several processes solve by multigrid only; leave it out")
    if plot is not None:
        raise ValueError("--plot draws what one process holds; draw from the store that --out writes")
    check_output("--out", out, (".zarr",))
    if out is not None:
        ranks.agreed(lambda: needed("zarr", "writing .zarr", INSTALL))
    from ..mpi.cases import membrane_of_case
    from ..mpi.solve import solve

    membrane = membrane_of_case(case, ranks.comm)
    answer = solve(membrane, ranks.comm, tol=tol, time_limit=time_limit, warm_start=warm_start)
    told = answer.summary()
    if ranks.rank == 0:
        typer.echo(told)
    if out is not None:
        answer.to_zarr(out)
        if ranks.rank == 0:
            typer.echo(f"fields: {out}")
    return EXIT_OK if answer.status.ok else EXIT_NOT_CERTIFIED
