"""compare(): one problem, several backends, and whether they agree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal, TypeVar

from ..backends import all_backends, choose_backend, get_backend, usual_backends
from ..backends.base import Backend
from ..backends.contract import check_declared
from ..errors import UnknownBackendError
from ..foundation.checks import integer_at_least
from ..models.base import ContactModel, split
from ..problem.contact_problem import ContactProblem
from ..solving.choice import chosen_backend
from ..solving.request import Request
from ..solving.solution import Solution
from ..solving.solver import Solver
from .comparison import Comparison
from .outcome import Outcome, Refusal
from .provenance import Provenance, machine, versions_of

Attempted = TypeVar("Attempted")


def compare(
    problem: ContactProblem | ContactModel,
    backends: Sequence[str | Backend] | Literal["all"] | None = None,
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
    repeats: int = 0,
) -> Comparison:
    """Solve one problem with several backends and cross-check the answers.

    A backend that is missing, cannot be imported, is unsuitable, fails or times out is a row of the result, never an
    exception.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet, ContactQP or ContactLCP
        What to solve.
    backends : sequence of str or Backend, or "all", optional
        Names, see `backend_names`, or backends themselves; by default the installed ones, those of other distributions
        too, whose methods suit the problem and are practical at its size; `Comparison.left_out` names the others. With
        "all" the solvers that qpsolvers and CVXPY find are among them (``qpsolvers:piqp``, ``cvxpy:scs``, ...), and
        `Comparison.left_out` tells of every other one why it was not asked.
    tol : float or str
        As for `solve`, for every backend: a number, or "low", "mid", "high" or "default".
    max_iter : int, optional
        Iterations of each backend, in its own unit.
    time_limit : float, optional
        Seconds for each backend.
    options : mapping of str to mapping, optional
        Options of a backend, by its name. Those of a backend that cannot be imported are not checked.
    repeats : int
        Further runs of each backend, in a `Solver` that keeps its set-up, for `Row.warm_seconds`.

    Returns
    -------
    Comparison

    Raises
    ------
    UnknownBackendError
        If there is no backend of a given name.
    TypeError, ValueError
        If an argument has the wrong kind or range, an option is not the backend's, or a backend is named twice.

    Examples
    --------
    >>> import contactqp as cq
    >>> comparison = cq.compare(cq.gallery.paper_hexagon(), backends=["clarabel", "mangasarian"])
    >>> comparison.agree
    True
    >>> comparison.to_frame()["contact"].tolist()
    [303, 303]
    """
    _, algebra = split(problem)
    names, left_out = _chosen(backends, algebra)
    asked = _by_name(names)
    given = _checked_options(options)
    stray = sorted(set(given) - set(asked))
    if stray:
        raise ValueError(f"options name {', '.join(map(repr, stray))}, which is not among the backends {list(asked)}")
    request = Request.of(tol, max_iter, time_limit)
    requests = {name: replace(request, options=dict(given.get(name, {}))) for name in asked}
    repeats = integer_at_least(repeats, 0, "repeats")
    found = {name: _found(backend, algebra) for name, backend in asked.items()}
    known = {name: method for name, method in found.items() if isinstance(method, Backend)}
    for name, method in known.items():
        method.check_options(requests[name].options)
    provenance = _provenance(known, requests, request, repeats)
    if known:
        # What the judge prepares once for a problem would otherwise be counted as the first backend's.
        algebra.prepare()
    outcomes = [
        Outcome(name, had)
        if isinstance(had, Refusal)
        else _outcome(name, problem, asked[name], requests[name], repeats)
        for name, had in found.items()
    ]
    return Comparison(problem, outcomes, request.tolerance, provenance, left_out)


def _chosen(
    backends: Sequence[str | Backend] | Literal["all"] | None, problem: ContactProblem
) -> tuple[Sequence[str | Backend], Mapping[str, str]]:
    """Return whom to ask, and why others are left out."""
    if backends is None:
        return usual_backends(problem)
    if isinstance(backends, str) and backends == "all":
        return all_backends(problem)
    return backends, {}


def _by_name(backends: Sequence[str | Backend]) -> dict[str, str | Backend]:
    """Return what was asked for, by its names."""
    if isinstance(backends, (str, Backend)):
        raise TypeError(f"backends must be a sequence of names, got {backends!r} alone; write [{backends!r}], or 'all'")
    if not isinstance(backends, Iterable):
        raise TypeError(f"backends must be a sequence of names, got {backends!r}")
    backends = list(backends)
    if not backends:
        raise ValueError("backends must hold a name at least, got none; leave them out for all that suit")
    for backend in backends:
        if isinstance(backend, Backend):
            check_declared(backend)
    names = [backend.name if isinstance(backend, Backend) else backend for backend in backends]
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"backends must hold names and Backends only, got {name!r}")
    if len(set(names)) != len(names):
        raise ValueError(f"backends must not repeat, got {names}")
    return dict(zip(names, backends, strict=True))


def _checked_options(options: Mapping[str, Mapping[str, Any]] | None) -> dict[str, Mapping[str, Any]]:
    example = "write options={'psor': {'relaxation': 1.5}}"
    if not isinstance(options, Mapping | None):
        raise TypeError(f"options must map a backend's name to its options, got {options!r}; {example}")
    for name, own in (options or {}).items():
        if not isinstance(own, Mapping):
            raise TypeError(f"options[{name!r}] must map the backend's options to values, got {own!r}; {example}")
    return dict(options or {})


def _found(backend: str | Backend, problem: ContactProblem) -> Backend | Refusal:
    """Return the backend of a name, or why it cannot be had; an unknown name is the caller's error."""
    try:
        return get_backend(choose_backend(problem)[0] if backend == "auto" else backend)
    except (UnknownBackendError, KeyboardInterrupt):
        raise
    except BaseException as error:  # what another distribution runs when it is loaded may raise anything
        return Refusal.by(error)


def _outcome(
    name: str, subject: ContactProblem | ContactModel, backend: str | Backend, request: Request, repeats: int
) -> Outcome:
    """Return what a backend makes of the problem, and the least time of further runs in one session."""
    first = _attempt(partial(_cold, subject, backend, request))
    if not repeats or isinstance(first, Refusal):
        return Outcome(name, first)
    session = _attempt(partial(_session, subject, backend, request))
    if isinstance(session, Refusal):
        return Outcome(name, first)
    again = [_attempt(partial(session.solve_varied, subject, warm_start=False)) for _ in range(repeats)]
    return Outcome(name, first, min((run.seconds for run in again if isinstance(run, Solution)), default=None))


def _cold(subject: ContactProblem | ContactModel, backend: str | Backend, request: Request) -> Solution:
    method, note = chosen_backend(backend, split(subject)[1], request.options)
    return Solution.by(method, subject, request, note=note)


def _session(subject: ContactProblem | ContactModel, backend: str | Backend, request: Request) -> Solver:
    return Solver(
        subject,
        backend,
        tol=request.tolerance.setting or request.tolerance.tol,
        max_iter=request.max_iter,
        time_limit=request.time_limit,
        **request.options,
    )


def _attempt(call: Callable[[], Attempted]) -> Attempted | Refusal:
    """Return what a call returns, or the refusal that an error on the way stands for."""
    try:
        return call()
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # whatever a library throws, a panic of compiled code too, is a finding about it
        return Refusal.by(error)


def _provenance(
    backends: Mapping[str, Backend], requests: Mapping[str, Request], request: Request, repeats: int
) -> Provenance:
    """Return what the answers of some backends are asked for and made with."""
    own = request.tolerance.own_defaults
    shipped = [name for name, backend in backends.items() if own and backend.has_own_defaults]
    options = {
        name: ({} if name in shipped else backend.options()) | dict(requests[name].options)
        for name, backend in backends.items()
    }
    return Provenance(
        max_iter=request.max_iter,
        time_limit=request.time_limit,
        repeats=repeats,
        options=options,
        own_defaults=tuple(shipped),
        versions=versions_of(
            package for backend in backends.values() for package in (*backend.also_needs, backend.package)
        ),
        machine=machine(),
    )
