"""What every backend that calls a library has in common: `LibraryState`, of which a backend writes a few hooks.

The loop itself (call, ask the judge, tighten, keep the best, count, watch the clock) is that of `tightening`. Here
stands what is kept from load to load, and what a library is told at each call.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, TypeAlias

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import loaded, working_seconds
from ..problem.contact_problem import ContactProblem
from .base import Answer, State, Stop, Task, as_it_is_now
from .option_checks import check_values
from .tightening import Round, one_after_the_other, tightened

Vectors: TypeAlias = dict[str, Vector]
Workspace: TypeAlias = Any
"""What a library has set up, whatever that is."""

_LEAST_SECONDS, _MOST_SECONDS = 1e-6, 1e10
"""Time limits that every library takes: none is zero, and none infinite."""


@dataclass(frozen=True)
class Outcome:
    """What a library's word for the end of a call means.

    Attributes
    ----------
    stop : Stop
        Only after `Stop.DONE` is a tighter setting of any use.
    claims : bool
        Whether the library says that it has solved the problem.
    keeps : bool
        Whether what it has set up is as good as before, for the next load.
    """

    stop: Stop
    claims: bool = False
    keeps: bool = True


FAILED = Outcome(Stop.FAILED, keeps=False)
"""What any word means that a library's table does not list."""


@dataclass(frozen=True)
class Plan:
    """The first tolerance of a solve, the limit of its iterations over all rounds, and a note."""

    eps: float
    max_iter: int
    note: str = ""


@dataclass(frozen=True)
class Setting:
    """How a library is asked in a round: with which tolerance, and which factor on the objective.

    A tolerance that is absolute asks for more where the objective is larger. Each factor has a workspace of its own.
    """

    eps: float
    weight: float = 1.0


@dataclass(frozen=True)
class Ask:
    """What a library is to do in one call.

    Attributes
    ----------
    problem : ContactProblem
        The dimensionless problem as it is now.
    task : Task
    form : object
        What `LibraryState.form` has returned for the problem.
    eps, weight : float
        Those of the round's `Setting`.
    iterations : int
        Limit of this call.
    resumes : bool
        Whether the solve goes on from what the library has of the load before.
    finishes : bool
        Whether a last step is to be taken once the library has converged, such as a polish.
    """

    problem: ContactProblem
    task: Task
    form: Any = None
    eps: float = np.inf
    weight: float = 1.0
    iterations: int = 0
    resumes: bool = False
    finishes: bool = False

    @property
    def seconds(self) -> float:
        """Seconds that are left: positive, and finite."""
        return min(max(self.task.seconds_left, _LEAST_SECONDS), _MOST_SECONDS)


@dataclass(frozen=True)
class Reply:
    """What a library has found in one call.

    Attributes
    ----------
    status : hashable
        The library's word for the end of the call, which its table of outcomes translates.
    gap : array, shape (n,), or None
        The dimensionless gap; None if there is nothing to judge. It must not be the library's own memory.
    iterations : int
        Iterations of this call.
    words : str
        What is told of its end; by default the status, and the tolerance that was asked for.
    finished : str
        Name of the last step, if it was taken and succeeded.
    reaction : array, shape (n,), or None
        The dimensionless reaction, where the library's last step asks for a bound that presses.
    history : mapping of str to vector
        What was recorded in this call, on request.
    """

    status: Hashable
    gap: Vector | None
    iterations: int
    words: str = ""
    finished: str = ""
    reaction: Vector | None = None
    history: Mapping[str, Vector] = field(default_factory=dict)


class LibraryState(State):
    """A problem in a library: its workspaces, and what they were set up for.

    A subclass tells how one library is called: it writes `plan`, `set_up` and `call`, and of the other hooks and class
    attributes those that its library has a use for. The hooks that use a workspace run where Ctrl-C cannot hit them.

    A workspace is in use by one solve at a time: it is taken out before, and put back only if the last call in it has
    ended well. After Ctrl-C the library may still be at work in it, and what a failure leaves in it is of no use.

    Parameters
    ----------
    declared : callable
        The `prepare` in whose signature the options stand, and how they are checked: see `option_checks`.
    problem, task
        As for `Backend.prepare`.
    options : mapping of str to object
        The backend's options, in the order in which they are checked, and settings of the library that the package
        changes. With own defaults only what the user gave remains.

    Attributes
    ----------
    library : module
    problem : ContactProblem
        The problem that was prepared; its matrix is that of all others.
    settings : dict of str to object
        The library's settings.
    eps : float or None
        The option of that name, where there is one: the first tolerance, if the user gave it.

    Class attributes
    ----------------
    imports : str
        Name of the library's module, which ``self.library`` is.
    outcomes : mapping of hashable to Outcome
        What the library's words mean; any other is a failure.
    finish_option : str
        The option by which the user asks for a last step, "" if the library has none. The last step is asked for from
        the second round on where a bound presses, until it succeeds once: one that succeeded and did not satisfy the
        judge got the contact set wrong in a few nodes; repeated, it would undo what the iteration mends.
    tightest : float
        Each round asks for a tenth of the tolerance before, down to this one.
    most_iterations : int or None
        Limit of the iterations of one round, after which the next one begins.
    starts_again : bool
        Whether a call that fails in a workspace of the load before is made again in a new one.
    """

    imports: ClassVar[str]
    outcomes: ClassVar[Mapping[Any, Outcome]]
    finish_option: ClassVar[str] = ""
    tightest: ClassVar[float] = np.inf
    most_iterations: ClassVar[int | None] = None
    starts_again: ClassVar[bool] = False

    def __init__(
        self, declared: Callable[..., Any], problem: ContactProblem, task: Task, options: Mapping[str, Any]
    ) -> None:
        check_values(declared, options)
        self.problem, self.settings = problem, task.passed_on(**options)
        self.eps: float | None = self.settings.pop("eps", None)
        self.finishes = bool(self.settings.pop(self.finish_option, False))
        self._kept: dict[float, _Kept] = {}
        self._form: Any = None
        self.library = loaded(self.imports)

    @abstractmethod
    def plan(self, task: Task) -> Plan:
        """Return how to begin; with ``task.own_defaults`` as the library is shipped."""

    @abstractmethod
    def set_up(self, ask: Ask, vectors: Vectors) -> Workspace:
        """Return a new workspace for a problem, whose matrix is always the same.

        Parameters
        ----------
        ask : Ask
        vectors : dict of str to array
            What `vectors` has returned for the problem.
        """

    @abstractmethod
    def call(self, workspace: Workspace, ask: Ask) -> Reply:
        """Call the library once."""

    def form(self, problem: ContactProblem, tol: float) -> Any:
        """Return what of the program cannot be changed in a workspace; by default there is no such thing.

        Where it is no longer equal, new workspaces are set up.
        """

    def vectors(self, ask: Ask) -> Vectors:
        """Return the vectors of the program that can be changed in a workspace, by the library's names."""
        return {"q": ask.problem.q, "l": ask.problem.lower, "u": ask.problem.upper}

    def change(self, workspace: Workspace, changed: Vectors) -> bool:
        """Change vectors of the program; return False if that is not possible, and a new workspace is needed."""
        workspace.update(**changed)
        return True

    def start(self, workspace: Workspace, gap: Vector, reaction: Vector) -> None:
        """Tell the library from where to start; a library that cannot be told has no such hook."""

    def tighter(self, eps: float) -> Iterable[Setting]:
        """Yield the settings of the rounds after the first."""
        while self.tightest <= eps / 10 < np.inf:
            eps /= 10
            yield Setting(eps)

    def solve(self, q: Vector, task: Task, problem: ContactProblem | None = None) -> Answer:
        """See `State.solve`."""
        problem = as_it_is_now(self.problem, q, problem)
        form = self.form(problem, task.tol)
        if form != self._form:
            self._kept, self._form = {}, form
        kept, self._kept = self._kept, {}
        plan, rounds = self.plan(task), _Rounds(self, Ask(problem, task, self._form), kept)
        budget = plan.max_iter if task.max_iter is None else task.max_iter
        settings = rounds.settings(float(plan.eps))
        answer = tightened(task, rounds.call, settings, budget, note=plan.note)
        self._kept = {weight: slot for weight, slot in kept.items() if slot.outcome.keeps}
        return answer

    def dropped(self) -> list[Workspace]:
        """Return the workspaces that were kept for the next load, and keep them no longer."""
        kept, self._kept = self._kept, {}
        return [slot.workspace for slot in kept.values()]


@dataclass
class _Kept:
    """A workspace, the vectors that it holds, how the last call in it has ended, and whether there was one.

    ``resumes`` tells whether the solve at hand goes on from the one before.
    """

    workspace: Workspace
    vectors: Vectors
    outcome: Outcome = Outcome(Stop.DONE)
    used: bool = False
    resumes: bool = False


class _Rounds:
    """The calls for one solve.

    Parameters
    ----------
    state : LibraryState
    ask : Ask
        What is the same in all calls.
    kept : dict of float to _Kept
        The workspaces by the factor on the objective, to which new ones are added.
    """

    def __init__(self, state: LibraryState, ask: Ask, kept: dict[float, _Kept]) -> None:
        self._state, self._ask, self._kept = state, ask, kept
        self._begun = set[float]()
        self._finishes, self._finish_is_due = state.finishes, False

    def settings(self, eps: float) -> Iterator[Setting]:
        """Yield the settings of the rounds; with own defaults there is a second one only for the last step."""
        yield Setting(eps)
        if not self._ask.task.own_defaults:
            yield from self._state.tighter(eps)
        elif self._finish_is_due:
            yield Setting(eps)

    def call(self, setting: Setting, left: int) -> Round:
        """Return what one round finds; where a solve goes on from the load before, its first round ends with a finish.

        The bound of such a round is hardly ever too large, while each question to the judge takes its time.
        """
        task, weight = self._ask.task, setting.weight
        begins, before = weight not in self._begun, self._kept.get(weight)
        slot, setup_seconds = self._begin(setting) if begins else (self._kept[weight], 0.0)
        if task.seconds_left <= 0:
            return Round(None, Stop.TIME_LIMIT, "time limit during set-up", 0, setup_seconds)
        called = self._call_twice if begins and slot.resumes else self._call
        found = called(slot, setting, left)
        failed = found.stop is Stop.FAILED and not self._ask.task.abandoned.is_set()
        if failed and begins and slot is before and self._state.starts_again:
            del self._kept[weight]
            self._begun.discard(weight)
            return self.call(setting, left)
        return replace(found, setup_seconds=setup_seconds)

    def _begin(self, setting: Setting) -> tuple[_Kept, float]:
        """Return a workspace that is ready for its first call in this solve, and the seconds that its set-up took."""
        state, ask, seconds = self._state, replace(self._ask, weight=setting.weight), 0.0
        vectors, slot = state.vectors(ask), self._kept.get(setting.weight)
        if slot is not None:
            changed = {name: new.copy() for name, new in vectors.items() if not np.array_equal(new, slot.vectors[name])}
            slot = slot if not changed or state.change(slot.workspace, changed) else None
        if slot is None:
            started = working_seconds()
            slot = self._kept[setting.weight] = _Kept(state.set_up(ask, vectors), vectors)
            seconds = working_seconds() - started
        slot.vectors, slot.resumes = vectors, False
        self._begun.add(setting.weight)
        if type(state).start is not LibraryState.start:
            self._start(slot, setting.weight)
        return slot, seconds

    def _start(self, slot: _Kept, weight: float) -> None:
        """Have the library start from the warm start, or from zero: never from where a solve before has ended."""
        problem, task = self._ask.problem, self._ask.task
        if task.warm_start is not None:
            gap = problem.project(task.warm_start)
            reaction = problem.bounds.admissible_reaction(problem.stiffness.matvec(gap) + problem.q)
            self._state.start(slot.workspace, gap, weight * reaction)
            slot.resumes = slot.used and not task.own_defaults
        elif slot.used:
            self._state.start(slot.workspace, np.zeros(problem.size), np.zeros(problem.size))

    def _call_twice(self, slot: _Kept, setting: Setting, left: int) -> Round:
        """Return what a rough call and a fine one find together, the second with the last step."""
        rough = self._call(slot, replace(setting, eps=10 * setting.eps), left)
        if rough.stop is not Stop.DONE or rough.iterations >= left:
            return rough
        fine = self._call(slot, setting, left - rough.iterations)
        history = one_after_the_other([rough.history, fine.history])
        return replace(fine, iterations=rough.iterations + fine.iterations, history=history)

    def _call(self, slot: _Kept, setting: Setting, left: int) -> Round:
        """Call the library from where the call before has ended, and see whether it is to finish in the next."""
        state, most = self._state, self._state.most_iterations
        iterations = left if most is None or self._ask.task.own_defaults else min(left, most)
        told = replace(self._ask, eps=setting.eps, weight=setting.weight, iterations=iterations)
        ask = replace(told, resumes=slot.resumes, finishes=self._finish_is_due)
        reply = state.call(slot.workspace, ask)
        outcome = state.outcomes.get(reply.status, FAILED)
        slot.used, slot.outcome = True, outcome
        # A library may keep the outcome of its last finish, so it counts only where one was asked for.
        finished = reply.finished if ask.finishes else ""
        self._finishes = self._finishes and not finished
        self._finish_is_due = self._finishes and _presses(ask.problem, reply)
        cut_short = outcome.stop is Stop.ITERATION_LIMIT and iterations < left
        return Round(
            gap=reply.gap,
            stop=Stop.DONE if cut_short else outcome.stop,
            termination=reply.words or f"{reply.status}, eps {setting.eps:.0e}",
            iterations=reply.iterations,
            claims=outcome.claims,
            finish=finished,
            history=reply.history,
        )


def _presses(problem: ContactProblem, reply: Reply) -> bool:
    """Whether a bound presses: a last step takes the contact set for known, and OSQP complains where it is empty."""
    if reply.gap is None or reply.reaction is None:
        return False
    least = 1e-6 * np.abs(problem.q).max()
    below = (reply.reaction > least) & (reply.gap - problem.lower < 1e-6)
    above = (reply.reaction < -least) & (problem.upper - reply.gap < 1e-6)
    return bool((below | above).any())
