"""The contract between the package and a backend.

A backend turns a dimensionless problem into a vector and raw facts. It never judges its own answer, never prints,
and imports the library that it calls only when it is called.
"""

from __future__ import annotations

import inspect
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from threading import Event
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import MissingBackendError, UnsuitableProblemError
from ..foundation.checks import Vector, nearest
from ..foundation.progress import Progress, silent
from ..problem.contact_problem import ContactProblem
from ..problem.load_cases import LoadCases
from .option_checks import check_values


class Stop(StrEnum):
    """Why a backend stopped, in its own view."""

    DONE = "done"
    ITERATION_LIMIT = "iteration_limit"
    TIME_LIMIT = "time_limit"
    FAILED = "failed"


class Need(ABC):
    """A property of the problem that a backend's method relies on; the package verifies it.

    Anything with a `holds` method will do; a distribution can bring needs of its own.

    Attributes
    ----------
    name : str
        The property in a word or two, for tables.
    """

    name: ClassVar[str]
    Z_MATRIX: ClassVar[Need]
    LATTICE: ClassVar[Need]
    ONE_SIDED: ClassVar[Need]
    SYMMETRIC: ClassVar[Need]
    DEFINITE: ClassVar[Need]

    @abstractmethod
    def holds(self, problem: ContactProblem) -> str | None:
        """Return None if the problem has the property, and else what is needed and what the problem has instead."""


class _ZMatrix(Need):
    name = "Z-matrix"

    def holds(self, problem: ContactProblem) -> str | None:
        if problem.positive_off_diagonal is None:
            return None
        i, j, value = problem.positive_off_diagonal
        return f"a Z-matrix (off-diagonal entries <= 0), but G[{i}, {j}] = {value:g}"


class _Lattice(Need):
    name = "lattice"

    def holds(self, problem: ContactProblem) -> str | None:
        if problem.stencil is not None:
            return None
        return "a problem on a lattice (a Membrane or a Cable), but G was given as a matrix"


class _OneSided(Need):
    name = "no upper bound"

    def holds(self, problem: ContactProblem) -> str | None:
        if problem.one_sided:
            return None
        node = int(np.argmax(np.isfinite(problem.upper)))
        return (
            "a problem without an upper bound (with two bounds the admissible gaps have no least element that a linear "
            f"program could find), but upper is {problem.upper[node]:g} at unknown {node}"
        )


class _Symmetric(Need):
    name = "symmetric"

    def holds(self, problem: ContactProblem) -> str | None:
        if problem.symmetric:
            return None
        needed, asymmetry = "a symmetric matrix (a quadratic program)", problem.stiffness.asymmetry
        if asymmetry is None:
            return f"{needed}, but got a ContactLCP whose matrix is symmetric; pose it as ContactQP(M, q)"
        return f"{needed}, but {asymmetry}"


class _Definite(Need):
    name = "definite"

    def holds(self, problem: ContactProblem) -> str | None:
        if problem.kernel is None:
            return None
        return f"a positive definite matrix, but G was given with a kernel ({problem.facts.kind})"


Need.Z_MATRIX, Need.LATTICE, Need.ONE_SIDED = _ZMatrix(), _Lattice(), _OneSided()
Need.SYMMETRIC, Need.DEFINITE = _Symmetric(), _Definite()

USUAL: tuple[Need, ...] = (Need.SYMMETRIC, Need.DEFINITE)
"""What every method relies on, unless it says that it does without."""


@dataclass
class Task:
    """What a backend is asked for, besides the problem.

    Attributes
    ----------
    tol : float
        Wanted bound of the gap's error, relative to the error scale: the gap scale, or the answer's own deflection.
    max_iter : int or None
        Limit of iterations over all rounds; None for the backend's own default.
    time_limit : float or None
        Seconds from now.
    warm_start : array or None
        A dimensionless gap to start from, with no more energy than zero has.
    bound : callable
        ``bound(gap)`` returns the judge's bound of a dimensionless gap's error, relative to the error scale; where
        nothing is proven of the matrix it is an estimate, by residual and condition, that says how far to go on.
    length_unit : float or array, shape (n,)
        What one dimensionless gap is in the user's unit of length, for options that are lengths.
    gap_scale : float
        The problem's gap scale in the user's unit.
    progress : Progress
        To be kept up to date by backends that iterate in Python.
    own_defaults : bool
        Whether a backend that calls a library is to call it once, as its authors ship it, whatever ``tol`` is. What the
        user gave (``given``, limits, a warm start) still counts. The package's own methods have no other defaults.
    given : frozenset of str
        Names of the backend's options that the user gave.
    keeps : bool
        Whether a state that is prepared for the task will be asked again, so that it is worth its memory.
    resumes : bool
        Whether ``warm_start`` stems from the state's own last answer, and only the forces have changed since.
    predicted : bool
        Whether ``warm_start`` is extrapolated from the last answers, and their contact set has stayed or grown:
        nodes that are about to leave contact show nothing of it before.
    started : float
        When the clock of the time limit started, by ``time.perf_counter()``.
    abandoned : Event
        It is set when nobody waits for the answer any more, after Ctrl-C or at the limit: a library that can be told to
        stop is told then.
    """

    tol: float
    max_iter: int | None
    time_limit: float | None
    warm_start: Vector | None
    bound: Callable[[Vector], float]
    length_unit: float | Vector = 1.0
    gap_scale: float = 1.0
    progress: Progress = field(default_factory=silent)
    own_defaults: bool = False
    given: frozenset[str] = frozenset()
    keeps: bool = False
    resumes: bool = False
    predicted: bool = False
    started: float = field(default_factory=time.perf_counter)
    abandoned: Event = field(default_factory=Event)

    def accepts(self, gap: Vector) -> bool:
        """Whether the judge is satisfied with ``gap``."""
        return self.bound(gap) <= self.tol

    def passed_on(self, **options: Any) -> dict[str, Any]:
        """Return the options that a library is to be told: all, or with ``own_defaults`` those that the user gave."""
        return {name: value for name, value in options.items() if not self.own_defaults or name in self.given}

    def largest_length(self, gap: Vector) -> float:
        """Return the largest modulus of a dimensionless gap, in the user's unit of length."""
        return float(np.abs(gap * self.length_unit).max())

    @property
    def seconds_left(self) -> float:
        """Seconds until the time limit, infinite if there is none; 0 once nobody waits for the answer any more."""
        if self.abandoned.is_set():
            return 0.0
        if self.time_limit is None:
            return float("inf")
        return self.time_limit - (time.perf_counter() - self.started)


@dataclass
class Answer:
    """A backend's vector and raw facts.

    Attributes
    ----------
    gap : array or None
        The dimensionless gap; None if there is nothing to return.
    stop : Stop
        Why the backend stopped.
    termination : str
        The library's own words for it.
    iterations : int
        Iterations in the method's own unit, over all rounds.
    setup_seconds, solve_seconds : float
        Time spent on set-up (conversion, factorisation) and on iterating.
    history : mapping of str to vector
        What was recorded while iterating, on request.
    note : str
        A choice worth telling the user.
    findings : tuple of str
        What the judge caught the method at on the way, one sentence each.
    claimed_solved : bool or None
        Whether the method itself said that it had solved the problem, and not only that it can do no better; None for
        ``stop is Stop.DONE``.
    """

    gap: Vector | None
    stop: Stop
    termination: str
    iterations: int
    setup_seconds: float
    solve_seconds: float
    history: Mapping[str, Vector] = field(default_factory=dict)
    note: str = ""
    findings: tuple[str, ...] = ()
    claimed_solved: bool | None = None

    @property
    def claimed(self) -> bool:
        """Whether the method itself said that it had solved the problem."""
        return self.stop is Stop.DONE if self.claimed_solved is None else self.claimed_solved


@dataclass
class CaseAnswers:
    """A backend's answers to many load cases, and raw facts.

    Attributes
    ----------
    gaps : array, shape (cases, n)
        Dimensionless.
    iterations : array of int, shape (cases,)
        In the method's own unit; 0 where a case has not been solved, and is better asked for by itself.
    termination : str
        The method's own words for the end of those that have.
    unit : str
        That of the iterations.
    seconds : float
        Time spent on all of them.
    """

    gaps: Vector
    iterations: NDArray[np.int64]
    termination: str
    unit: str
    seconds: float

    def answer(self, case: int) -> Answer:
        """Return the answer to one case that has been solved."""
        steps = int(self.iterations[case])
        told = f"{self.termination} after {steps} {self.unit}s"
        return Answer(self.gaps[case], Stop.DONE, told, steps, 0.0, self.seconds / len(self.gaps))


class State(ABC):
    """What a backend keeps of a problem from load to load: a workspace, a hierarchy, factors."""

    @abstractmethod
    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        """Solve the prepared problem with other forces.

        Parameters
        ----------
        q : array, shape (n,)
            Dimensionless.
        task : Task
        problem : ContactProblem, optional
            The dimensionless problem as it is now: it has the forces ``q`` and the matrix that was prepared, and bounds
            of the same kinds, though their values and the reference may differ. By default the prepared one.
        """

    def solve_problem(self, problem: ContactProblem, task: Task) -> Answer:
        """Solve the problem as it is now, see `solve`; a state that lays its forces out need not ask for a vector."""
        return self.solve(problem.q, task, problem)

    def answers(self, cases: LoadCases, asked: int) -> CaseAnswers | None:
        """Return answers to many load cases at once, or None where each is better asked for by itself.

        Parameters
        ----------
        cases : LoadCases
            Dimensionless, with the matrix that was prepared and bounds of the same kinds; one unit of length serves for
            all, so that their own gap scales are at most one. Without limits, options and warm starts: a case that
            needs more than usual is left.
        asked : int
            Cases that the state has been asked for so far, with these: whether more work of its own is worth it.
        """
        return None


def as_it_is_now(prepared: ContactProblem, q: Vector, problem: ContactProblem | None) -> ContactProblem:
    """Return the problem that a state is asked to solve: the one that it is given, or the prepared one with forces q.

    Parameters
    ----------
    prepared, q, problem
        The problem that the state was prepared for, and the arguments of `State.solve`.
    """
    if problem is not None:
        return problem
    return prepared if q is prepared.q else prepared.with_forces(q, gap_scale=1.0)


class _OneShot(State):
    """The state of a backend that keeps nothing."""

    def __init__(self, backend: Backend, problem: ContactProblem, options: Mapping[str, Any]) -> None:
        self._backend, self._problem, self._options = backend, problem, dict(options)

    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        return self._backend.solve(as_it_is_now(self._problem, q, problem), task, **self._options)


class Backend(ABC):
    """Base of all backends; a subclass is one file.

    A subclass writes `solve`; or, if it can keep something from load to load, `prepare`. The one that it writes names
    the backend's own options as keywords with defaults.

    Attributes
    ----------
    name : str
        Name to call it by.
    summary : str
        The method, in a few words.
    package : str
        Distribution on PyPI that it needs; its version is shown.
    also_needs : collection of str
        Further distributions without which it cannot be called.
    install : str
        What to type where it is missing; "" for ``pip install`` of what is.
    licence : str
        That of the method's program, by its SPDX identifier; "" if it is not told.
    iteration_unit : str
        What one iteration is.
    needs : collection of Need
        Verified before `solve` is called.
    does_without : collection of Need
        Of what methods rely on unless they say otherwise (`USUAL`), that which this one does not: with `Need.SYMMETRIC`
        it solves a `ContactLCP`, too, which has no objective; with `Need.DEFINITE` problems with a kernel.
    has_own_defaults : bool
        Whether it calls a library that has other defaults than these options, and honours ``task.own_defaults``.
    practical_size : int or None
        Unknowns up to which it answers within a minute or so on two cores, as ``benchmarks/backends.py`` measures it
        with tol 1e-6, by order of magnitude; None if no such size has been met. Only default lists keep to it.
    reachable_tol : float or None
        The tightest power of ten that it certifies for the paper's hexagon at all ten loads, if that was measured.
    repeatable : bool
        Whether the same call gives the same answer to the bit; else to rounding, as where sums depend on where in
        memory their terms stand.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    package: ClassVar[str]
    also_needs: ClassVar[Collection[str]] = ()
    install: ClassVar[str] = ""
    licence: ClassVar[str] = ""
    iteration_unit: ClassVar[str] = "iteration"
    needs: ClassVar[Collection[Need]] = ()
    does_without: ClassVar[Collection[Need]] = ()
    has_own_defaults: ClassVar[bool] = False
    practical_size: ClassVar[int | None] = None
    reachable_tol: ClassVar[float | None] = None
    repeatable: ClassVar[bool] = True

    def solve(self, problem: ContactProblem, task: Task, *_: Any, **options: Any) -> Answer:
        """Solve the dimensionless ``problem``: l ≤ ω ≤ u, with zero always among the admissible gaps."""
        return self.state_of(problem, task, options).solve_problem(problem, task)

    def prepare(self, problem: ContactProblem, task: Task, *_: Any, **options: Any) -> State:
        """Return a state that solves the problem again and again; by default one that keeps nothing."""
        return _OneShot(self, problem, options)

    def state_of(self, problem: ContactProblem, task: Task, options: Mapping[str, Any]) -> State:
        """Return what `prepare` does, which must be a `State`."""
        state: Any = self.prepare(problem, task, **options)
        if not isinstance(state, State):
            raise TypeError(f"prepare of backend {self.name!r} must return a State, got {state!r}")
        return state

    def options(self) -> dict[str, Any]:
        """Return the backend's own options and their defaults.

        Raises
        ------
        TypeError
            If they are not all named keywords with defaults, so that a misspelt one would pass unnoticed.
        """
        written = self._written()
        if written is Backend.prepare:
            raise TypeError(f"backend {self.name!r} must define solve or prepare")
        parameters = list(inspect.signature(written).parameters.values())[3:]
        for parameter in parameters:
            if parameter.kind is not inspect.Parameter.KEYWORD_ONLY or parameter.default is inspect.Parameter.empty:
                raise TypeError(
                    f"backend {self.name!r} must name its options as keywords with defaults, but "
                    f"{written.__qualname__} takes {str(parameter)!r}; write "
                    f"def {written.__name__}(self, problem, task, *, option=default)"
                )
        return {parameter.name: parameter.default for parameter in parameters}

    def _written(self) -> Callable[..., Any]:
        """Return the one of `prepare` and `solve` that the subclass has written."""
        return type(self).prepare if type(self).solve is Backend.solve else type(self).solve

    def version(self) -> str | None:
        """Return the installed version of the library behind the backend, or None if it is missing."""
        return _version(self.package)

    def missing(self) -> list[str]:
        """Return the distributions that it needs and that are not installed."""
        others = [package for package in self.also_needs if _version(package) is None]
        return others if self.version() is not None else [*others, self.package]

    def to_install(self) -> str:
        """Return what to type where something that it needs is missing."""
        return self.install or f"pip install {' '.join(self.missing())}"

    def require(self) -> None:
        """Raise a MissingBackendError if a distribution that it needs is not installed."""
        missing = self.missing()
        if missing:
            several = len(missing) > 1
            raise MissingBackendError(
                f"backend {self.name!r} needs the package{'s' if several else ''} "
                f"{' and '.join(map(repr, missing))}, which {'are' if several else 'is'} not installed; "
                f"type: {self.to_install()}"
            )

    def check_options(self, options: Mapping[str, Any]) -> None:
        """Check options by their names, and their values by what their annotations say.

        Raises
        ------
        TypeError
            If an option is not one of the backend's, or its value has another kind than it is annotated with.
        ValueError
            If its value is outside its range.
        """
        known = self.options()
        for option in options:
            if option not in known:
                listed = ", ".join(known) or "none"
                meant = nearest(option, [*known, *_OF_EVERY_BACKEND])
                raise TypeError(f"backend {self.name!r} has no option {option!r}{meant}; its options: {listed}")
        check_values(self._written(), options)

    @property
    def all_needs(self) -> tuple[Need, ...]:
        """What the method relies on: `USUAL`, but for what it does without, and its own `needs`."""
        return (*(need for need in USUAL if need not in self.does_without), *self.needs)

    def check_problem(self, problem: ContactProblem) -> None:
        """Raise an UnsuitableProblemError if the problem lacks a property that the method relies on."""
        for need in self.all_needs:
            reason = need.holds(problem)
            if reason is not None:
                raise UnsuitableProblemError(f"backend {self.name!r} needs {reason}")


_OF_EVERY_BACKEND = ("tol", "max_iter", "time_limit", "warm_start", "on_failure")
"""Arguments of `solve` beside the options, which may have been meant."""


@cache
def _version(package: str) -> str | None:
    """Return a distribution's installed version, which reading takes a millisecond."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
