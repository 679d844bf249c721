"""What runs in a solver's own process: ``python -m contactqp.benchmark.child ASK ANSWER`` with two files of JSON.

A process of its own keeps limits of time and memory, and whatever a library leaves behind, from the other solvers.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MissingBackendError, UnsuitableProblemError
from ..foundation.files import replaced_as_a_whole
from ..foundation.rounding import quotient_above, quotient_below
from ..gallery.families import FAMILIES
from .record import REFERENCE, Ask, Listed, Record

if TYPE_CHECKING:
    from ..backends.base import Backend
    from ..foundation.checks import Vector
    from ..models.base import ContactModel
    from ..problem.contact_problem import ContactProblem
    from ..solving.solution import Solution

_TRUTH_TOL, _TRUTH_SECONDS = 1e-12, 300.0
_LOADING_SECONDS = 150.0
_PAGE = 1024


def main(ask_file: str, answer_file: str) -> None:
    """Do what the first file asks for, and write what came of it to the second."""
    told = json.loads(Path(ask_file).read_text(encoding="utf-8"))
    sys.path[:0] = told["path"]
    ask, truth = Ask(**told["ask"]), Path(told["truth"])
    _limit_memory(ask.memory)
    answer = reference(ask, truth, told["listed"]) if ask.backend == REFERENCE else answered(ask, truth)
    with replaced_as_a_whole(Path(answer_file)) as unfinished:
        unfinished.write_text(json.dumps(answer), encoding="utf-8")


def reference(ask: Ask, truth: Path, listed: Listed) -> dict[str, Any]:
    """Enclose the solution of a problem, write the enclosure, and return who may be asked about the problem.

    Who may be asked is found out by loading libraries, "all" of which take seconds: only what is wanted is listed.
    """
    from ..backends import all_backends, usual_backends
    from ..models.base import split
    from ..solving.solve import solve

    subject = FAMILIES[ask.family].make(ask.number)
    problem = split(subject)[1]
    solution = solve(subject, tol=_TRUTH_TOL, time_limit=_TRUTH_SECONDS, on_failure="ignore")
    certificate = solution.certificate
    if certificate is not None and np.isfinite(certificate.gap_bound):
        with replaced_as_a_whole(truth) as unfinished, unfinished.open("wb") as file:
            np.savez(file, lower=certificate.lower, upper=certificate.upper)
    lists = {"none": lambda _: ([], {}), "usual": usual_backends, "all": all_backends}
    return {"listed": lists[listed](problem)[0]}


def answered(ask: Ask, truth: Path) -> dict[str, Any]:
    """Return the record of a solver's answer as plain data."""
    from ..models.base import split
    from ..solving.tolerances import tolerance_of

    subject = FAMILIES[ask.family].make(ask.number)
    size, tol = split(subject)[1].size, tolerance_of(ask.level).tol
    base = _peak_memory()
    try:
        # What is loaded and compiled, once in a process, would use up the time limit of the first run.
        loading = _solved(ask, subject, max_iter=1, time_limit=_LOADING_SECONDS).loading_seconds
        runs = [_solved(ask, subject) for _ in range(ask.repeats)]
    except MissingBackendError as error:
        return Record.of(ask, size=size, tol=tol, status="missing", message=str(error)).to_dict()
    except UnsuitableProblemError as error:
        return Record.of(ask, size=size, tol=tol, status="unsuitable", message=str(error)).to_dict()
    except MemoryError as error:
        return Record.of(ask, size=size, tol=tol, status="out of memory", message=str(error)).to_dict()
    except Exception as error:  # whatever a library throws is a finding about it
        said = f"{type(error).__name__}: {error}"
        return Record.of(ask, size=size, tol=tol, status="error", message=said).to_dict()
    first = next((run for run in runs if not run.status.ok), runs[0])
    fastest = min((run for run in runs if run.status is first.status), key=lambda run: run.seconds)
    known = Record.of(
        ask,
        size=size,
        tol=tol,
        status=first.status.value,
        claimed=all(run.claimed_solved for run in runs),
        message=first.termination,
        setup_seconds=fastest.setup_seconds,
        solve_seconds=fastest.solve_seconds,
        seconds=fastest.seconds,
        loading_seconds=loading,
        iterations=first.iterations,
        peak_memory=_peak_memory(),
        base_memory=base,
        **_error(first, truth),
    )
    return known.to_dict()


def _solved(ask: Ask, subject: ContactModel | ContactProblem, **limits: float) -> Solution:
    from ..solving.solve import solve

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        given: dict[str, Any] = {"time_limit": ask.time_limit} | limits
        return solve(subject, _backend(ask), tol=ask.level, on_failure="ignore", **given)


def _backend(ask: Ask) -> str | Backend:
    if not ask.imported:
        return ask.backend
    module, _, name = ask.backend.partition(":")
    made: Backend = getattr(import_module(module), name)()
    return made


def _error(solution: Solution, truth: Path) -> Mapping[str, float | None]:
    """Return how wrong an answer is, as far as it is known."""
    from ..comparison.metrics import Truth

    if not solution.finite:
        return {}
    scale = solution.verdict.scale
    found: dict[str, float | None] = {
        "relative_residual": _plain(solution.relative_residual),
        "relative_bound": _plain(solution.relative_bound),
    }
    if truth.exists():
        with np.load(truth) as kept:
            enclosed: Vector = kept["lower"]
            low, high = Truth(enclosed, kept["upper"]).error(solution.gap)
        found |= {"error_lower": quotient_below(low, scale), "error_upper": quotient_above(high, scale)}
    return found


def _plain(number: float) -> float | None:
    """Return a number that JSON can hold; None for no bound."""
    return float(number) if np.isfinite(number) else None


def _limit_memory(size: int) -> None:
    """Let the process take so many bytes at most, where the system can hold it to that."""
    try:
        import resource
    except ImportError:
        return
    # The data segment, because addresses that are only set apart count as little here as they cost.
    resource.setrlimit(resource.RLIMIT_DATA, (size, size))


def _peak_memory() -> int | None:
    """Return the most bytes that the process has held, as far as the system tells."""
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak if sys.platform == "darwin" else peak * _PAGE)


if __name__ == "__main__":
    main(*sys.argv[1:])
