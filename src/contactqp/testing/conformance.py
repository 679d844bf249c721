"""The conformance kit: what every backend must do, tried one after the other."""

from __future__ import annotations

import os
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from functools import partial
from io import StringIO
from typing import Any

import numpy as np

from ..backends import get_backend
from ..backends.base import Answer, Backend, Stop, Task
from ..backends.contract import check_declared, checked_answer
from ..errors import UnsuitableProblemError
from ..foundation.checks import Vector, open_interval, positive_number
from ..foundation.interrupts import OutOfTime, run_interruptibly
from ..foundation.quiet import flush_output
from ..problem.contact_problem import ContactProblem
from ..proof.judge import judge
from ..proof.measure import measure
from .known_problems import Known, one_sided, other_matrices, two_sided
from .report import CheckResult, ConformanceReport

_TIME_LIMIT = 0.2
"""Seconds that a backend is given whose judge is never satisfied."""

_PATIENCE = 5.0
"""Seconds after which it must be back; a limit is meant to be kept to within one."""

_REPEATED = 1e-12
"""Difference of dimensionless gaps that counts as rounding where a backend does not repeat itself to the bit."""

_LONGEST = 300
"""Characters of an error's words that are told."""

_UNKNOWN_OPTION = "no_such_option"


def check_backend(backend: str | Backend, *, tol: float | None = None, seconds: float = 120.0) -> ConformanceReport:
    """Try whether a backend does what the package, and whoever uses it, relies on.

    Known problems with one and two bounds, limits, warm starts, sessions, interrupts, wrong options, determinism,
    threads, inputs that must stay as they are, and silence. The package's own backends pass it. A check that fails does
    not keep the others from being made.

    Parameters
    ----------
    backend : str or Backend
        Its name, or the backend itself.
    tol : float, optional
        What answers are asked for, relative to the error scale; by default 1e-6, or the backend's ``reachable_tol``
        where that is more.
    seconds : float
        How long each check may take. One that takes longer fails, and is left behind at work.

    Returns
    -------
    ConformanceReport
        A table of all checks; ``ok`` tells whether none fails.

    Raises
    ------
    UnknownBackendError, MissingBackendError
        If there is no backend of that name, or it or its library cannot be loaded.
    TypeError, ValueError
        If an argument has the wrong kind or range.

    Examples
    --------
    >>> report = check_backend("psor")
    >>> report.ok
    True
    >>> print(report)  # doctest: +ELLIPSIS
    psor: all ... checks pass
      pass  declared facts
      pass  one-sided problems
      ...
    """
    method = backend if isinstance(backend, Backend) else get_backend(backend)
    reachable = getattr(method, "reachable_tol", None)
    tol = max(1e-6, reachable or 0.0) if tol is None else open_interval(tol, 0.0, 1.0, "tol")
    seconds = positive_number(seconds, "seconds")
    if isinstance(getattr(method, "package", None), str):  # else its declared facts fail
        method.require()
    kit = _Kit(method, tol, seconds)
    name = getattr(method, "name", type(method).__name__)
    return ConformanceReport(str(name), tuple(_made(check, kit, seconds) for check in _CHECKS))


class _Unmet(Exception):  # noqa: N818  (a finding, not a fault)
    """What a check expects, and what it got."""

    def __init__(self, expected: str, got: str) -> None:
        super().__init__(expected, got)
        self.expected, self.got = expected, got


class _DoesNotApply(Exception):  # noqa: N818  (a finding, not a fault)
    """A check is of no use for a backend; the reason is its text."""


@dataclass
class _Kit:
    """A backend, and how it is asked.

    Attributes
    ----------
    backend : Backend
    tol : float
    seconds : float
        How long each check may take.
    """

    backend: Backend
    tol: float
    seconds: float
    _work: list[Known] = field(default_factory=list)

    @property
    def known(self) -> Known:
        """The problem that most checks are made with: the first one that suits, dimensionless."""
        if not self._work:
            suited = self.suited([*one_sided(), *two_sided(), *other_matrices()])
            self._work.append(suited[0])
        return self._work[0]

    def suited(self, problems: list[Known]) -> list[Known]:
        """Return the problems that the backend does not refuse, dimensionless."""
        reason, found = "", []
        for known in problems:
            try:
                self.backend.check_problem(known.problem)
            except UnsuitableProblemError as error:
                reason = str(error)
                continue
            scaled, units = known.problem.scaled()
            found.append(Known(known.label, scaled, units.dimensionless(known.gap)))
        if not found:
            raise _DoesNotApply(reason)
        return found

    def task(self, problem: ContactProblem, bound: Callable[[Vector], float] | None = None, **asked: Any) -> Task:
        """Return a task with the kit's tolerance, and an honest judge unless another one is given."""
        limits = {"max_iter": None, "time_limit": None, "warm_start": None} | asked
        return Task(self.tol, bound=bound or (lambda gap: measure(problem, gap).relative_estimate), **limits)

    def answer(self, problem: ContactProblem, task: Task, **options: Any) -> Answer:
        """Return what the backend answers, which must be an `Answer`."""
        return checked_answer(self.backend, self.backend.solve(problem, task, **options), problem.size)

    def solved(self, known: Known, answer: Answer) -> None:
        """Require that an answer is the known solution, proven to within the tolerance."""
        wanted = f"a gap certified to {self.tol:g} for {known.label}"
        if answer.gap is None:
            raise _Unmet(wanted, f"no gap, stop {answer.stop.value!r} ({answer.termination})")
        gap = np.array(answer.gap, dtype=np.float64)
        verdict = judge(known.problem, gap, self.tol)
        if verdict.status.ok:
            return
        off = float(np.abs(gap - known.gap).max())
        claimed = ", which the backend claims to be solved" if answer.claimed else ""
        raise _Unmet(wanted, f"{verdict.status.value}, off by {off:.2g}{claimed} ({answer.termination})")


_Check = tuple[str, Callable[[_Kit], None]]


def _made(check: _Check, kit: _Kit, seconds: float) -> CheckResult:
    """Return what a check finds, whatever the backend does."""
    label, call = check
    try:
        # What the user's filters make of a warning is no concern of any check but that of silence.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run_interruptibly(lambda: call(kit), seconds=seconds)
    except _DoesNotApply as error:
        return CheckResult(label, "skip", got=str(error))
    except _Unmet as error:
        return CheckResult(label, "fail", error.expected, error.got)
    except OutOfTime:
        return CheckResult(label, "fail", f"an end within {seconds:g} s", "it was still at work, and is left behind")
    except (Exception, SystemExit) as error:  # what the backend throws is a finding about it
        return CheckResult(label, "fail", "no exception", f"{type(error).__name__}: {_shortened(error)}")
    return CheckResult(label, "pass")


def _shortened(error: BaseException) -> str:
    """Return an error's words, some of which hold whole arrays."""
    words = " ".join(str(error).split())
    return words if len(words) <= _LONGEST else f"{words[:_LONGEST]} ..."


def _declared_facts(kit: _Kit) -> None:
    check_declared(kit.backend)
    kit.backend.require()
    for known in (*one_sided(), *two_sided()):
        for need in kit.backend.needs:
            reason = need.holds(known.problem)
            if reason is not None and not isinstance(reason, str):
                raise _Unmet("None, or words that tell what is missing, from a need's holds", repr(reason))


def _solves(problems: Callable[[], list[Known]]) -> Callable[[_Kit], None]:
    """Return the check that those problems which suit are solved."""

    def check(kit: _Kit) -> None:
        for known in kit.suited(problems()):
            answer = kit.answer(known.problem, kit.task(known.problem))
            kit.solved(known, answer)
            if answer.stop is not Stop.DONE:
                raise _Unmet(f"stop 'done' for {known.label}", f"stop {answer.stop.value!r} ({answer.termination})")

    return check


def _facts_of_answers(kit: _Kit) -> None:
    problem = kit.known.problem
    answer = kit.answer(problem, kit.task(problem))
    times = answer.setup_seconds, answer.solve_seconds
    if not all(np.isfinite(times)) or min(times) < 0:
        raise _Unmet("setup_seconds and solve_seconds >= 0", f"{times[0]:g} and {times[1]:g}")
    if not answer.termination.strip():
        raise _Unmet("words for the end in termination", "an empty text")


def _iteration_limit(kit: _Kit) -> None:
    problem = kit.known.problem
    answer = kit.answer(problem, kit.task(problem, max_iter=1))
    if answer.iterations > 1:
        raise _Unmet("1 iteration at most with max_iter=1", f"{answer.iterations} iterations")
    good = answer.gap is not None and judge(problem, np.asarray(answer.gap), kit.tol).status.ok
    if not good and answer.stop is Stop.DONE and answer.claimed:
        raise _Unmet("stop 'iteration_limit' where one iteration is too few", f"stop 'done' ({answer.termination})")


def _time_limit(kit: _Kit) -> None:
    problem = kit.known.problem
    task = kit.task(problem, bound=lambda gap: np.inf, time_limit=_TIME_LIMIT)
    started = time.perf_counter()
    try:
        run_interruptibly(lambda: kit.answer(problem, task), seconds=_TIME_LIMIT + _PATIENCE)
    except OutOfTime:
        took = f"it was still at work after {time.perf_counter() - started:.1f} s"
        raise _Unmet(f"an end soon after {_TIME_LIMIT:g} s with time_limit={_TIME_LIMIT:g}", took) from None


def _warm_start(kit: _Kit) -> None:
    known = kit.known
    for label, start in (("the solution", known.gap), ("half the solution", known.problem.project(0.5 * known.gap))):
        given = np.array(start)
        answer = kit.answer(known.problem, kit.task(known.problem, warm_start=given))
        kit.solved(Known(f"{known.label}, started from {label}", known.problem, known.gap), answer)
        if not np.array_equal(given, start):
            raise _Unmet("a warm start that stays as it is", "the backend has changed it")


def _session(kit: _Kit) -> None:
    known = kit.known
    state = kit.backend.state_of(known.problem, kit.task(known.problem, keeps=True), {})
    kept: list[tuple[Vector, Vector]] = []
    for number, (label, other) in enumerate(_loads(known), 1):
        warm = kept[-1][0].copy() if kept else None
        task = kit.task(other, warm_start=warm, keeps=True, resumes=warm is not None)
        given = None if number == 1 else other
        answer = checked_answer(kit.backend, state.solve(other.q, task, given), other.size)
        kit.solved(Known(f"{label}, solve {number} of a session", other, np.full(other.size, np.nan)), answer)
        gap = np.asarray(answer.gap)
        kept.append((gap, gap.copy()))
    if not all(np.array_equal(gap, copy) for gap, copy in kept):
        raise _Unmet("gaps that stay as they were returned", "a later solve has changed an earlier one's")


def _loads(known: Known) -> Iterator[tuple[str, ContactProblem]]:
    """Yield a problem under several forces."""
    yield known.label, known.problem
    for label, factor in (("half the forces", 0.5), ("twice the forces", 2.0), ("the first forces again", 1.0)):
        yield label, known.problem.with_forces(factor * known.problem.q, gap_scale=1.0)


def _interrupts(kit: _Kit) -> None:
    known = kit.known
    asked = threading.Event()

    def interrupted(gap: Vector) -> float:
        asked.set()
        raise KeyboardInterrupt

    state = kit.backend.state_of(known.problem, kit.task(known.problem, keeps=True), {})
    try:
        state.solve(known.problem.q, kit.task(known.problem, bound=interrupted, keeps=True))
    except KeyboardInterrupt:
        pass
    else:
        if asked.is_set():
            raise _Unmet("a KeyboardInterrupt that is raised while it asks the judge is passed on", "it was swallowed")
    answer = checked_answer(kit.backend, state.solve(known.problem.q, kit.task(known.problem)), known.problem.size)
    kit.solved(Known(f"{known.label}, solved after an interrupt", known.problem, known.gap), answer)


def _wrong_options(kit: _Kit) -> None:
    problem = kit.known.problem

    def solve(options: Mapping[str, object]) -> None:
        kit.backend.check_options(options)
        kit.answer(problem, kit.task(problem, given=frozenset(options)), **options)

    for name in (_UNKNOWN_OPTION, *kit.backend.options()):
        _refused(f"{name}=object()", name, partial(solve, {name: object()}))


def _refused(what: str, name: str, call: Callable[[], object]) -> None:
    """Require that a call raises an error that names an option."""
    wanted = f"a TypeError or ValueError that names {name!r}, for {what}"
    try:
        call()
    except (TypeError, ValueError) as error:
        if name not in str(error):
            raise _Unmet(wanted, f"{type(error).__name__}: {_shortened(error)}") from None
        return
    except Exception as error:
        raise _Unmet(wanted, f"{type(error).__name__}: {_shortened(error)}") from None
    raise _Unmet(wanted, "it was taken")


def _determinism(kit: _Kit) -> None:
    problem, exact = kit.known.problem, kit.backend.repeatable
    first, second = (kit.answer(problem, kit.task(problem)) for _ in range(2))
    gaps = [np.full(problem.size, np.nan) if run.gap is None else np.asarray(run.gap) for run in (first, second)]
    if not np.allclose(gaps[0], gaps[1], rtol=0.0, atol=0.0 if exact else _REPEATED, equal_nan=True):
        wanted = f"the same gap twice, {'to the bit' if exact else 'to rounding'}"
        raise _Unmet(wanted, f"gaps that differ by {np.abs(gaps[0] - gaps[1]).max():.2g}")
    if exact and first.iterations != second.iterations:
        raise _Unmet("the same number of iterations twice", f"{first.iterations} and {second.iterations}")


def _threads(kit: _Kit) -> None:
    known = kit.known
    problems = [problem for _, problem in _loads(known)][:2]
    together = threading.Barrier(len(problems))

    def solve(problem: ContactProblem) -> Answer:
        task = kit.task(problem)
        together.wait(_PATIENCE)
        return kit.answer(problem, task)

    with ThreadPoolExecutor(len(problems)) as pool:
        answers = list(pool.map(solve, problems))
    for problem, answer in zip(problems, answers, strict=True):
        kit.solved(Known(f"{known.label}, two at once in threads", problem, known.gap), answer)


def _unmodified(kit: _Kit) -> None:
    problem = kit.known.problem
    before = {name: values.copy() for name, values in _data_of(problem).items()}
    try:
        kit.answer(problem, kit.task(problem))
    except ValueError as error:
        if "read-only" not in str(error):
            raise
        raise _Unmet("a problem that stays as it is", f"an attempt to change it (ValueError: {error})") from None
    changed = [name for name, values in _data_of(problem).items() if not np.array_equal(values, before[name])]
    for name in changed:  # it is the kit's problem, which other checks need as it was
        _restore(_data_of(problem)[name], before[name])
    if changed:
        raise _Unmet("a problem that stays as it is", f"{', '.join(changed)} changed")


def _data_of(problem: ContactProblem) -> dict[str, Any]:
    matrix = problem.G
    parts = {"q": problem.q, "lower": problem.lower, "upper": problem.upper}
    return parts | {"G.data": matrix.data, "G.indices": matrix.indices, "G.indptr": matrix.indptr}


def _restore(values: Any, before: Any) -> None:
    writeable = values.flags.writeable
    with suppress(ValueError):
        values.flags.writeable = True
        values[...] = before
        values.flags.writeable = writeable


def _silence(kit: _Kit) -> None:
    problems = [known.problem for known in kit.suited([*one_sided(), *two_sided()])]

    def solve() -> None:
        for problem in problems:
            kit.answer(problem, kit.task(problem))

    # Should it hang, the streams are put back before the check itself is left behind: they are the process's.
    with _listening() as heard:
        run_interruptibly(solve, seconds=0.5 * kit.seconds)
    if heard:
        raise _Unmet("nothing printed, and no warning", " ".join(" and ".join(heard).split())[:200])


@contextmanager
def _listening() -> Iterator[list[str]]:
    """Yield a list that holds, in the end, what was printed on either stream by any code, and what was warned of."""
    heard: list[str] = []
    spoken = StringIO()
    flush_output()
    with ExitStack() as stack:
        files = {}
        for number in (1, 2):
            with suppress(OSError):  # it may be closed
                files[number] = stack.enter_context(tempfile.TemporaryFile()), os.dup(number)
                os.dup2(files[number][0].fileno(), number)
        try:
            with redirect_stdout(spoken), redirect_stderr(spoken), warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                yield heard
        finally:
            flush_output()
            for number, (_, kept) in files.items():
                os.dup2(kept, number)
                os.close(kept)
        printed = [spoken.getvalue()]
        for file, _ in files.values():
            file.seek(0)
            printed.append(file.read().decode(errors="replace"))
    heard += [f"printed {text.strip()!r}" for text in printed if text.strip()]
    heard += [f"warned {str(warning.message)!r}" for warning in warned]


def _own_defaults(kit: _Kit) -> None:
    if not kit.backend.has_own_defaults:
        raise _DoesNotApply("it has no other defaults than its options'")
    problem = kit.known.problem
    answer = kit.answer(problem, kit.task(problem, own_defaults=True))
    if answer.gap is None:
        raise _Unmet(
            "a gap with the library's own defaults", f"none, stop {answer.stop.value!r} ({answer.termination})"
        )


_CHECKS: tuple[_Check, ...] = (
    ("declared facts", _declared_facts),
    ("one-sided problems", _solves(one_sided)),
    ("two-sided problems", _solves(two_sided)),
    ("other matrices", _solves(other_matrices)),
    ("facts of answers", _facts_of_answers),
    ("iteration limit", _iteration_limit),
    ("time limit", _time_limit),
    ("warm start", _warm_start),
    ("session", _session),
    ("interrupts", _interrupts),
    ("wrong options", _wrong_options),
    ("own defaults", _own_defaults),
    ("determinism", _determinism),
    ("threads", _threads),
    ("unmodified inputs", _unmodified),
    ("silence", _silence),
)
