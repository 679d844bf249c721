"""trace(): one model under a sequence of loads, tensions or lifts of its support, each solved from the one before."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..backends.base import Backend
from ..foundation.checks import Vector, one_of, real_array, refuse_non_finite
from ..foundation.progress import Progress
from ..models.base import ContactModel
from ..models.varied import VARIED, reachable
from ..solving.choice import chosen_backend
from ..solving.solution import Solution
from ..solving.solve import solve
from ..solving.solver import Solver
from .load_path import LoadPath


def trace(
    model: ContactModel,
    *,
    loads: Iterable[float] | None = None,
    tensions: Iterable[float] | None = None,
    lifts: Iterable[float] | None = None,
    backend: str | Backend = "auto",
    tol: float | str = 1e-6,
    cold: bool = False,
    checkpoint: str | Path | None = None,
    on_failure: Literal["warn", "raise", "ignore"] = "warn",
    **options: Any,
) -> LoadPath:
    """Solve a model along a sequence of loads, tensions or lifts, each from the answer before.

    Parameters
    ----------
    model : ContactModel
        `Membrane`, `MeshMembrane`, `Cable`, `CableNet`, `Beam`, `Plate`, or one of your own.
        What is varied; it is never modified.
    loads : sequence of float, optional
        Factors of the model's load: proportional loading. Give exactly one of loads, tensions and lifts.
    tensions : sequence of float, optional
        Tensions, > 0; not for a net of cables. Where the model's tension varies, or goes by direction, factors of it.
    lifts : sequence of float, optional
        Heights (length) by which the support is lifted.
    backend, tol, on_failure, **options
        As for `solve`.
    cold : bool
        Whether to solve from a cold start as well, to count the iterations that warm starts save.
    checkpoint : path, optional
        A NetCDF file that keeps what is done after every value, so that an interrupted path is resumed from it by the
        same call. It must belong to the same model, parameter and backend. Answers to other values are added to it,
        and none is taken out. One path at a time may use it.

    Returns
    -------
    LoadPath

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or range, or the checkpoint belongs to another path, or is in use.
    NotCertifiedError
        If an answer is not certified and ``on_failure="raise"``.

    Examples
    --------
    >>> import contactqp as cq
    >>> path = cq.trace(cq.gallery.paper_hexagon(load=1.0), loads=[0.01, 0.02, 0.03])
    >>> path.to_frame()["contact"].tolist(), path.monotone
    ([105, 225, 303], True)
    """
    if not isinstance(model, ContactModel):
        raise TypeError(f"model must be a model, as Membrane, Cable or Beam, got {type(model).__name__}")
    parameter, values = _chosen({"load": loads, "tension": tensions, "lift": lifts})
    model = reachable(model, (VARIED[parameter](model, float(value)) for value in values))
    # The reason for "auto" is the same at every load, and would hide which solutions were restored.
    method, _ = chosen_backend(backend, model.problem, {})
    session = Solver(model, method, tol=tol, **options)
    one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
    with ExitStack() as held:
        file = None
        if checkpoint is not None:
            from .checkpoint import Checkpoint

            file = held.enter_context(Checkpoint(Path(checkpoint), model, parameter, session.backend.name, tol).held())
        solutions: list[Solution] = []
        cold_iterations: list[int] = []
        progress = held.enter_context(Progress(f"{parameter}s · {model.size} nodes"))
        for k, value in enumerate(map(float, values)):
            progress.update(f"{parameter} {value:g}, {k + 1} of {values.size}")
            varied = VARIED[parameter](model, value)
            kept, counted = (None, -1) if file is None else file.restored(value, varied)
            previous = solutions[-1] if solutions else None
            if kept is not None and kept.status.ok:
                solution = kept
            else:
                solution = session.solve_varied(varied, _start(previous, kept, session.last))
                solution.report(on_failure)
            new = solution is not kept
            if cold and counted < 0:
                started = previous is not None and previous.finite
                alone = solve(varied, session.backend, tol=tol, on_failure="ignore", **options) if started else solution
                counted, new = alone.iterations, True
            solutions.append(solution)
            cold_iterations.append(counted)
            if file is not None and new and not _worse(solution, kept):
                file.keep(value, solution, counted)
    return LoadPath(model, parameter, values, tuple(solutions), tuple(cold_iterations) if cold else None)


def _worse(solution: Solution, kept: Solution | None) -> bool:
    """Whether an answer is known less well than the one that was kept for its value."""
    return kept is not None and solution is not kept and not solution.relative_bound <= kept.relative_bound


def _start(previous: Solution | None, kept: Solution | None, last: Vector | None) -> Vector | bool:
    """Return what to start from: an answer that was kept for this value, or the one before, the session's if it is."""
    if kept is not None and kept.finite:
        return kept.gap
    if previous is None or not previous.finite:
        return False
    return True if previous.gap is last else previous.gap


def _chosen(given: dict[str, Iterable[float] | None]) -> tuple[str, Vector]:
    named = {name: values for name, values in given.items() if values is not None}
    if len(named) != 1:
        got = ", ".join(f"{name}s" for name in named) or "none of them"
        raise ValueError(f"give exactly one of loads, tensions and lifts, got {got}")
    ((parameter, chosen),) = named.items()
    wanted = f"{parameter}s must be a sequence of numbers, as [1.0, 2.0]"
    if not isinstance(chosen, (Iterable, np.ndarray)) or np.ndim(chosen := _listed(chosen)) == 0:
        raise TypeError(f"{wanted}, got {chosen!r}")
    values = real_array(chosen, f"{parameter}s")
    if values.ndim != 1 or not values.size:
        raise ValueError(f"{wanted}, got {'none' if not values.size else f'shape {values.shape}'}")
    refuse_non_finite(values, f"{parameter}s")
    if parameter == "tension" and not (values > 0).all():
        raise ValueError(f"tensions must be > 0, got {values.min():g}")
    distinct, counts = np.unique(values, return_counts=True)
    if distinct.size != values.size:
        repeated = distinct[counts > 1]
        raise ValueError(f"{parameter}s must not repeat a value, but {repeated[0]:g} is there {counts.max()} times")
    return parameter, values


def _listed(values: Iterable[float] | Vector) -> Any:
    return values if isinstance(values, (np.ndarray, str)) else list(values)
