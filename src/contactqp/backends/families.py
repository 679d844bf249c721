"""Families of backends: solvers that another package calls by name, each of them a backend that is made by its name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, metadata
from typing import Any, ClassVar

import numpy as np

from ..errors import MissingBackendError
from ..foundation.checks import Vector
from ..foundation.loading import loaded
from ..foundation.quiet import output_discarded, warnings_ignored
from ..problem.contact_problem import ContactProblem
from .base import Backend, Need, Stop, Task
from .library import Ask, Outcome, Plan, Reply, Vectors
from .placed_state import TIME, PlacedState
from .processes import Elsewhere, Here, LostProcessError, Placed, can_be_sent
from .rows import StateInRows
from .setting_names import check_setting_names
from .solvers import facts_of, solvers_through

_SOLVED, _BEST, _NOTHING, _ITERATIONS = "solved", "best", "nothing", "iteration limit"
_MANY_ROUNDS = 20


class Member(Backend):
    """A solver that another package calls: made by the solver's name, with what the table of solvers tells of it.

    Parameters
    ----------
    solver : str
        The name that the package has for it.

    Attributes
    ----------
    solver : str
    facts : Facts

    Class attributes
    ----------------
    family : str
        The package that calls it: its distribution, its module, and what stands before the colon in the names.
    """

    has_own_defaults: ClassVar[bool] = True
    family: ClassVar[str]

    def __init__(self, solver: str) -> None:
        self.solver, self.facts = solver, facts_of(solver, self.family)
        through = self.facts.through[self.family]
        vars(self).update(
            name=f"{self.family}:{solver}",
            summary=self.facts.method,
            package=self.facts.package,
            also_needs=(self.family,),
            licence=self.facts.licence,
            iteration_unit="iteration" if through.counted else "call",
            does_without=() if self.facts.definite else (Need.DEFINITE,),
            practical_size=through.practical_size,
            reachable_tol=through.reachable_tol,
            repeatable=self.facts.repeatable,
        )

    @staticmethod
    @abstractmethod
    def offered(library: Any) -> list[str]:
        """Return the names of the solvers that the package finds here.

        Parameters
        ----------
        library : module
        """

    @classmethod
    def listed(cls) -> list[str]:
        """Return the names of the solvers in the table, which may be installed or not."""
        return solvers_through(cls.family)

    @classmethod
    def names(cls) -> list[str]:
        """Return the names of all solvers: those in the table, and what else the package finds here."""
        return list(dict.fromkeys([*cls.listed(), *_found(cls)]))

    @classmethod
    def found_here(cls) -> list[str]:
        """Return the names of the solvers that the package finds here, none where it is not installed."""
        return list(_found(cls))

    @classmethod
    def knows(cls, solver: str) -> bool:
        """Whether there is a solver of that name; the package is loaded only for one that is not in the table."""
        return solver in cls.listed() or solver in _found(cls)

    @classmethod
    def why_not_found(cls, solver: str) -> str | None:
        """Return what to install for a solver that the package knows and does not find here; None if it knows none."""
        if solver not in _known(cls):
            return None
        extra = solver.replace("_", "-")
        extras = metadata.metadata(cls.family).get_all("Provides-Extra") or []
        named = next((known for known in (extra, extra.split("-")[0]) if known in extras), None)
        install = f"type: pip install '{cls.family}[{named}]'" if named else f"install it as {cls.family} tells"
        return f"{cls.family} knows the solver {solver!r}, but does not find it here; {install}"

    @staticmethod
    @abstractmethod
    def known_by(library: Any) -> list[str]:
        """Return the names of all solvers of quadratic programs that the package could call, installed or not.

        Parameters
        ----------
        library : module
        """

    def require(self) -> None:
        """See `Backend.require`; the package must find the solver, too."""
        super().require()
        if self.solver not in _found(type(self)):
            raise MissingBackendError(
                f"backend {self.name!r} needs {self.family} to find the solver {self.solver!r}, but it finds "
                f"{', '.join(_found(type(self))) or 'none'}; type: pip install --upgrade {self.family} {self.package}"
            )


@dataclass(frozen=True)
class Question:
    """The vectors of a program; the matrices do not change.

    Attributes
    ----------
    q : array, shape (n,)
    limits : array, shape (rows,)
        The right-hand side of the rows, those of equations first.
    lower, upper : array, shape (n,)
        The bounds, infinite where an equation stands in their place.
    start : array, shape (n,), or None
    """

    q: Vector
    limits: Vector
    lower: Vector
    upper: Vector
    start: Vector | None


@dataclass(frozen=True)
class Found:
    """What a package has found.

    Attributes
    ----------
    word : str
        The solver's own word for its end.
    gap : array, shape (n,), or None
    multiplier : array, shape (equations,), or None
        Those of the equations, where they are told.
    iterations : int or None
        None where it does not tell.
    solved : bool
        Whether the solver says that it has solved the problem.
    """

    word: str
    gap: Vector | None = None
    multiplier: Vector | None = None
    iterations: int | None = None
    solved: bool = False


class Program(ABC):
    """A program as a package has it solved; it may be in a process of its own.

    Parameters
    ----------
    solver : str
        The name that the package has for it.
    stiffness : sparse array, shape (n, n)
    rows : sparse matrix, shape (rows, n)
    equations : int
        How many of the rows are equations, which come first; the others are inequalities, at most.
    """

    family: ClassVar[str]

    def __init__(self, solver: str, stiffness: Any, rows: Any, equations: int) -> None:
        self.solver, self.facts = solver, facts_of(solver, self.family)
        self.stiffness, self.rows, self.equations = stiffness, rows, equations
        with warnings_ignored():
            self.library = loaded(self.family)
            if self.facts.greets:
                _hear_out(self.facts.greets)

    def solve(self, question: Question, settings: Mapping[str, Any]) -> Found:
        """Call the solver with its own settings; what it warns of is told by its words."""
        with warnings_ignored():
            return self.found(question, settings)

    @abstractmethod
    def found(self, question: Question, settings: Mapping[str, Any]) -> Found:
        """Call the package once."""


class MemberState(PlacedState, StateInRows):
    """A problem in a package that calls solvers by name.

    A solver whose call may take longer than a second is called in a process of its own, which Ctrl-C and the time limit
    end: see `contactqp.backends.processes`.

    Parameters
    ----------
    member : Member
    program : type of Program
    declared, problem, task, options
        As for `LibraryState`; the options are ``eps`` and ``settings``.
    """

    outcomes: ClassVar[Mapping[Any, Outcome]] = {
        **PlacedState.outcomes,
        _SOLVED: Outcome(Stop.DONE, claims=True),
        # A tolerance that is too tight for the solver takes nothing away from the answers before.
        _BEST: Outcome(Stop.DONE),
        _NOTHING: Outcome(Stop.DONE),
        _ITERATIONS: Outcome(Stop.ITERATION_LIMIT),
    }

    def __init__(
        self,
        member: Member,
        program: type[Program],
        declared: Callable[..., Any],
        problem: ContactProblem,
        task: Task,
        options: Mapping[str, Any],
    ) -> None:
        vars(self).update(imports=program.family)
        check_setting_names(member.name, member.facts, member.family, options["settings"] or ())
        with warnings_ignored():
            super().__init__(declared, problem, task, options)
        self.member, self.program, self.facts = member, program, member.facts
        self.through = member.facts.through[member.family]
        vars(self).update(tightest=self.facts.tightest, most_iterations=self._most)

    @property
    def _most(self) -> int:
        return self.facts.most if self.through.counted else 1

    def plan(self, task: Task) -> Plan:
        """See `LibraryState.plan`."""
        most = _MANY_ROUNDS * self._most
        if task.own_defaults:
            return Plan(self.eps or np.inf, most, f"{self.member.solver} as {self.member.family} calls it by default")
        return Plan(self.eps or max(task.tol**self.facts.order, self.facts.tightest), most)

    def set_up(self, ask: Ask, vectors: Vectors) -> Placed:
        """See `LibraryState.set_up`."""
        program = self.program, self.member.solver, self.problem.G, ask.form.matrix, ask.form.equations
        if self.problem.size > self.facts.quick and can_be_sent(self.settings):
            try:
                return Elsewhere(*program)
            except LostProcessError:  # where none can be started, Ctrl-C may come late
                pass
        return Here(*program)

    def question(self, ask: Ask) -> tuple[Any, ...]:
        """See `PlacedState.question`."""
        problem, form, task = ask.problem, ask.form, ask.task
        start = problem.project(task.warm_start) if self.facts.warm and task.warm_start is not None else None
        lower, upper = form.box(problem)
        return Question(np.array(problem.q), form.limits(problem), lower, upper, start), self._told(ask)

    def reply(self, ask: Ask, found: Found) -> Reply:
        """See `PlacedState.reply`.

        Some solvers catch Ctrl-C while they work, so that nobody else gets to know of it but by their words.
        """
        if "interrupt" in found.word.lower():
            raise KeyboardInterrupt
        done = int(found.iterations or 0) if self.through.counted else 1
        gap = found.gap
        if gap is not None and ask.form.equations:
            unknown = np.zeros(ask.form.equations)
            gap = ask.form.gap(ask.problem, gap, unknown if found.multiplier is None else found.multiplier)
        if gap is None or not np.isfinite(gap).all():
            status, gap = _NOTHING, None
        elif found.solved:
            status = _SOLVED
        elif ask.task.seconds_left <= 0:
            status = TIME
        elif self.through.counted and done >= ask.iterations:
            status = _ITERATIONS
        else:
            status = _BEST
        # Of the name of a member of an enumeration only the last part is of interest.
        word = found.word if " " in found.word else found.word.rsplit(".")[-1]
        eps = f", eps {ask.eps:.0e}" if self.facts.tolerances and np.isfinite(ask.eps) else ""
        return Reply(status, gap, done, f"{word}{eps}")

    def _told(self, ask: Ask) -> dict[str, Any]:
        """Return the solver's settings for a call: all, or by default those that the user asks for."""
        task, facts = ask.task, self.facts
        told: dict[str, Any] = {**({} if task.own_defaults else facts.settings), **self.through.settings}
        if np.isfinite(ask.eps):
            told |= dict.fromkeys(facts.tolerances, ask.eps)
        limited = task.max_iter is not None or not task.own_defaults
        if facts.iterations and self.through.counted and limited:
            told[facts.iterations] = ask.iterations
        if facts.seconds and task.time_limit is not None:
            told[facts.seconds] = ask.seconds
        return told | dict(self.settings.get("settings") or {})


@cache
def _found(member: type[Member]) -> tuple[str, ...]:
    """Return the solvers that a package finds, none where it is not installed or cannot be loaded."""
    try:
        with warnings_ignored():
            return tuple(member.offered(loaded(member.family)))
    except Exception:
        return ()


@cache
def _known(member: type[Member]) -> tuple[str, ...]:
    """Return the solvers that a package knows, none where it is not installed or cannot be loaded."""
    try:
        with warnings_ignored():
            return tuple(member.known_by(loaded(member.family)))
    except Exception:
        return ()


@cache
def _hear_out(place: str) -> None:
    """Have a library print its greeting where nobody reads it."""
    module, attribute = place.split(":")
    with warnings_ignored():
        loaded(module)
    with output_discarded():
        getattr(import_module(module), attribute)()
