"""compare(): one problem, several backends, and whether they agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..backends import choose_backend, get_backend, suitable_backends
from ..errors import MissingBackendError, UnsuitableProblemError
from ..foundation.checks import integer_at_least, positive_number
from ..models.base import ContactModel, split
from ..problem.contact_qp import ContactQP
from ..solving.solution import Solution
from ..solving.solve import solve
from ..solving.tolerances import Tolerance, tolerance_of
from .comparison import Comparison
from .provenance import Provenance, machine, versions_of
from .rows import Row, row_of

if TYPE_CHECKING:
    from ..backends.base import Backend


def compare(
    problem: ContactQP | ContactModel,
    backends: Sequence[str] | None = None,
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
    repeats: int = 0,
) -> Comparison:
    """Solve one problem with several backends and cross-check the answers.

    A backend that is missing, unsuitable, fails or times out is a row of the result, never an exception.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet or ContactQP
        What to solve.
    backends : sequence of str, optional
        Names, see `backend_names`; by default the package's own whose methods suit the problem.
    tol : float or str
        As for `solve`, for every backend: a number, or "low", "mid", "high" or "default".
    max_iter : int, optional
        Iterations of each backend, in its own unit.
    time_limit : float, optional
        Seconds for each backend.
    options : mapping of str to mapping, optional
        Options of a backend, by its name.
    repeats : int
        Runs of each backend after the first, for `Row.warm_seconds`.

    Returns
    -------
    Comparison

    Raises
    ------
    UnknownBackendError
        If there is no backend of a given name.
    TypeError, ValueError
        If an argument has the wrong kind or range, or a backend is named twice.

    Examples
    --------
    >>> import contactqp as cq
    >>> comparison = cq.compare(cq.gallery.paper_hexagon(), backends=["clarabel", "mangasarian"])
    >>> comparison.agree
    True
    >>> comparison.to_frame()["contact"].tolist()
    [303, 303]
    """
    if isinstance(backends, str):
        raise TypeError(f"backends must be a sequence of names, got the string {backends!r}; write [{backends!r}]")
    _, algebra = split(problem)
    names = suitable_backends(algebra) if backends is None else list(backends)
    if len(set(names)) != len(names):
        raise ValueError(f"backends must not repeat, got {names}")
    options = dict(options or {})
    stray = sorted(set(options) - set(names))
    if stray:
        raise ValueError(f"options name {', '.join(map(repr, stray))}, which is not among the backends {names}")
    wanted = tolerance_of(tol)
    repeats = integer_at_least(repeats, 0, "repeats")
    if max_iter is not None:
        max_iter = integer_at_least(max_iter, 1, "max_iter")
    if time_limit is not None:
        time_limit = positive_number(time_limit, "time_limit")
    chosen = {name: choose_backend(algebra)[0] if name == "auto" else name for name in names}
    for name in names:
        get_backend(chosen[name]).check_options(options.get(name, {}))
    provenance = Provenance(
        max_iter=max_iter,
        time_limit=time_limit,
        repeats=repeats,
        options={name: _in_effect(get_backend(chosen[name]), wanted) | dict(options.get(name, {})) for name in names},
        versions=versions_of(chosen.values()),
        machine=machine(),
    )
    if names:
        # What the judge prepares once for a problem would otherwise be counted as the first backend's.
        algebra.prepare()
    rows: list[Row] = []
    solutions: dict[str, Solution] = {}
    limits = {"tol": tol, "max_iter": max_iter, "time_limit": time_limit}
    for name in names:
        first = _attempt(problem, name, limits, options.get(name, {}))
        if not isinstance(first, Solution):
            rows.append(first)
            continue
        again = [_attempt(problem, name, limits, options.get(name, {})) for _ in range(repeats)]
        warm = min((run.seconds for run in again if isinstance(run, Solution)), default=None)
        solutions[name] = first
        rows.append(row_of(first, name, warm))
    return Comparison(
        algebra, repr(problem), wanted.tol, rows, solutions, setting=wanted.setting, provenance=provenance
    )


def _in_effect(backend: Backend, wanted: Tolerance) -> dict[str, Any]:
    """Return the options that a backend has by default; with a library's own, those are not known here."""
    return {} if wanted.own_defaults and backend.has_own_defaults else backend.options()


def _attempt(
    problem: ContactQP | ContactModel, name: str, limits: Mapping[str, Any], options: Mapping[str, Any]
) -> Solution | Row:
    try:
        return solve(problem, name, on_failure="ignore", **limits, **options)
    except MissingBackendError as error:
        return Row(name, "missing", str(error))
    except UnsuitableProblemError as error:
        return Row(name, "unsuitable", str(error))
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # whatever a library throws, a panic of compiled code too, is a finding about it
        return Row(name, "error", f"{type(error).__name__}: {error}")
