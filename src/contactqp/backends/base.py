"""The contract between the package and a backend.

A backend turns a dimensionless `ContactQP` into a vector and raw facts. It never judges its own answer, never prints,
and imports the library that it calls only when it is called.
"""

from __future__ import annotations

import inspect
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, ClassVar

import numpy as np

from ..errors import MissingBackendError, UnsuitableProblemError
from ..foundation.checks import Vector, nearest
from ..foundation.progress import Progress, silent
from ..problem.contact_qp import ContactQP


class Stop(StrEnum):
    """Why a backend stopped, in its own view."""

    DONE = "done"
    ITERATION_LIMIT = "iteration_limit"
    TIME_LIMIT = "time_limit"
    FAILED = "failed"


class Need(StrEnum):
    """A property of the problem that a backend's method relies on; the package verifies it."""

    Z_MATRIX = "Z-matrix"
    LATTICE = "lattice"


@dataclass
class Task:
    """What a backend is asked for, besides the problem.

    Attributes
    ----------
    tol : float
        Wanted bound of the gap's error, relative to the gap scale.
    max_iter : int or None
        Limit of iterations over all rounds; None for the backend's own default.
    time_limit : float or None
        Seconds from now.
    warm_start : array or None
        A dimensionless gap to start from.
    bound : callable
        ``bound(gap)`` returns the judge's bound of a dimensionless gap's error, relative to the gap scale: certified
        for an M-matrix.
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
    started: float = field(default_factory=time.perf_counter)

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
        """Seconds until the time limit, infinite if there is none."""
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


class Backend(ABC):
    """Base of all backends; a subclass is one file.

    Class attributes
    ----------------
    name : str
        Name to call it by.
    summary : str
        The method, in a few words.
    package : str
        Distribution on PyPI that it needs; its version is shown.
    iteration_unit : str
        What one iteration is.
    needs : frozenset of Need
        Verified before `solve` is called.
    has_own_defaults : bool
        Whether it calls a library that has other defaults than these options, and honours ``task.own_defaults``.
    reachable_tol : float or None
        The tightest power of ten that it certifies for the paper's hexagon at all ten loads, if that was measured.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    package: ClassVar[str]
    iteration_unit: ClassVar[str] = "iteration"
    needs: ClassVar[frozenset[Need]] = frozenset()
    has_own_defaults: ClassVar[bool] = False
    reachable_tol: ClassVar[float | None] = None

    @abstractmethod
    def solve(self, problem: ContactQP, task: Task) -> Answer:
        """Solve the dimensionless ``problem``; subclasses add their options as named keywords with defaults."""

    @classmethod
    def options(cls) -> dict[str, Any]:
        """Return the backend's own options and their defaults."""
        parameters = inspect.signature(cls.solve).parameters.values()
        return {p.name: p.default for p in parameters if p.kind is inspect.Parameter.KEYWORD_ONLY}

    @classmethod
    def version(cls) -> str | None:
        """Return the installed version of the library behind the backend, or None if it is missing."""
        from importlib import metadata

        try:
            return metadata.version(cls.package)
        except metadata.PackageNotFoundError:
            return None

    @classmethod
    def require(cls) -> None:
        """Raise a MissingBackendError if the library is not installed."""
        if cls.version() is None:
            raise MissingBackendError(
                f"backend {cls.name!r} needs the package {cls.package!r}, which is not installed; "
                f"type: pip install {cls.package}"
            )

    @classmethod
    def check_options(cls, options: Mapping[str, Any]) -> None:
        """Raise a TypeError if an option is not one of the backend's."""
        known = cls.options()
        for option in options:
            if option not in known:
                listed = ", ".join(known) or "none"
                raise TypeError(
                    f"backend {cls.name!r} has no option {option!r}{nearest(option, known)}; its options: {listed}"
                )

    @classmethod
    def check_problem(cls, problem: ContactQP) -> None:
        """Raise an UnsuitableProblemError if the problem lacks a property that the method relies on."""
        if Need.Z_MATRIX in cls.needs and problem.positive_off_diagonal is not None:
            i, j, value = problem.positive_off_diagonal
            raise UnsuitableProblemError(
                f"backend {cls.name!r} needs a Z-matrix (off-diagonal entries <= 0), but G[{i}, {j}] = {value:g}; "
                "take 'osqp', 'clarabel' or 'psor'"
            )
        if Need.LATTICE in cls.needs and problem.stencil is None:
            raise UnsuitableProblemError(
                f"backend {cls.name!r} needs a problem on a lattice (a Membrane or a Cable), "
                "but G was given as a matrix; take 'active-set'"
            )


def feasible_start(problem: ContactQP, start: Vector) -> Vector:
    """Return a start without negative gaps at supported nodes."""
    return np.where(problem.supported, np.maximum(start, 0.0), start)
