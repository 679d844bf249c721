"""The base of the library backends, with a library that answers by a script."""

import _thread
import signal
import threading
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
import pytest

import contactqp as cq
from contactqp.backends.base import Backend, Stop, Task
from contactqp.backends.library import LibraryState, Outcome, Plan, Reply, Setting
from contactqp.backends.option_checks import Positive, between

FIRST = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], gap_scale=1.0)


@dataclass
class Toy:
    """What the library was asked for, and how it is to answer: by its words, and bounds of its answers."""

    script: list[Any] = field(default_factory=list)
    made: list[Any] = field(default_factory=list)
    calls: list[Any] = field(default_factory=list)
    changes: list[Any] = field(default_factory=list)
    starts: list[Any] = field(default_factory=list)
    takes_changes: bool = True

    def answer(self, ask):
        word, bound, *rest = self.script.pop(0) if self.script else ("well", 0.0)
        if isinstance(word, type):
            raise word("deep inside")
        if callable(word):
            word = word(ask)
        return word, bound, rest[0] if rest else ask.iterations // 2


class ToyBackend(Backend):
    name, summary, package = "toy", "answers by a script", "numpy"
    has_own_defaults = True

    def __init__(self, state=None, **script):
        self.toy: Toy = Toy(**script)
        self.state: Any = state or ToyState

    def prepare(
        self,
        problem,
        task,
        *,
        damping: Annotated[float, between(0.0, 1.0)] = 0.5,
        rho: Positive | None = None,
        how: Literal["well", "fast"] = "well",
        refine: bool = True,
        eps: Positive | None = None,
    ):
        options = {"damping": damping, "rho": rho, "how": how, "refine": refine, "eps": eps}
        state = self.state(ToyBackend.prepare, problem, task, options)
        state.toy = self.toy
        return state


class ToyState(LibraryState):
    toy: Toy
    imports = "math"
    outcomes = {  # noqa: RUF012
        "well": Outcome(Stop.DONE, claims=True),
        "worn": Outcome(Stop.DONE, keeps=False),
        "long": Outcome(Stop.ITERATION_LIMIT),
        "late": Outcome(Stop.TIME_LIMIT),
    }
    finish_option = "refine"
    tightest = 1e-9

    def plan(self, task):
        if task.own_defaults:
            return Plan(self.eps or 0.1, 50, "as shipped")
        return Plan(self.eps or 10 * task.tol, 1000)

    def set_up(self, ask, vectors):
        self.toy.made.append((ask.weight, vectors))
        return len(self.toy.made)

    def change(self, workspace, changed):
        self.toy.changes.append((workspace, changed))
        return self.toy.takes_changes

    def call(self, workspace, ask):
        self.toy.calls.append((workspace, ask))
        word, bound, iterations = self.toy.answer(ask)
        reaction = np.array([0.0, 3.0])
        return Reply(word, np.array([bound, 0.0]), iterations, finished="refinement", reaction=reaction)


class WarmState(ToyState):
    def start(self, workspace, gap, reaction):
        self.toy.starts.append((workspace, gap.tolist(), reaction.tolist()))


def task_of(tol=1e-6, **options):
    options = {"max_iter": None, "time_limit": None, "warm_start": None} | options
    return Task(tol, bound=lambda gap: float(gap[0]), **options)


def solved(state, problem=FIRST, **task):
    return state.solve(problem.q, task_of(**task), problem)


def prepared(*script, state=None, own_defaults=False, given=(), toy=None, **options):
    """Return the library's record and a state."""
    backend = ToyBackend(state, script=list(script), **(toy or {}))
    task = task_of(own_defaults=own_defaults, given=frozenset({*given, *options}))
    return backend.toy, backend.prepare(FIRST, task, **options)


def asked(toy, name):
    return [getattr(ask, name) for _, ask in toy.calls]


def test_nothing_is_set_up_before_the_first_solve_and_once_for_all():
    toy, state = prepared()
    assert toy.made == []
    first, second = solved(state), solved(state)
    assert [weight for weight, _ in toy.made] == [1.0]
    assert first.setup_seconds > 0
    assert second.setup_seconds == 0.0
    assert (first.stop, first.claimed, first.termination, first.note) == (Stop.DONE, True, "well, eps 1e-05", "")
    assert toy.changes == []


def test_tolerances_are_tightened_down_to_the_tightest():
    toy, state = prepared(*[("well", 1.0, 10)] * 10)
    answer = solved(state)
    assert asked(toy, "eps") == pytest.approx([1e-5, 1e-6, 1e-7, 1e-8, 1e-9])
    assert asked(toy, "iterations") == [1000, 990, 980, 970, 960]
    assert (answer.stop, answer.iterations, answer.gap[0]) == (Stop.DONE, 50, 1.0)


def test_a_given_tolerance_is_the_first_one():
    toy, state = prepared(*[("well", 1.0)] * 10, eps=2e-8)
    solved(state)
    assert asked(toy, "eps") == pytest.approx([2e-8, 2e-9])


def test_the_users_limit_counts_over_all_rounds():
    toy, state = prepared(("well", 1.0, 20), ("well", 1.0, 10))
    answer = solved(state, max_iter=30)
    assert asked(toy, "iterations") == [30, 10]
    assert (answer.stop, answer.iterations) == (Stop.ITERATION_LIMIT, 30)


def test_own_defaults_are_one_call_of_the_library_as_it_is_shipped():
    toy, state = prepared(("well", 1.0), own_defaults=True, given=("rho",))
    answer = solved(state, own_defaults=True)
    assert state.settings == {"rho": None}
    assert asked(toy, "eps") == [0.1]
    assert asked(toy, "iterations") == [50]
    assert (answer.note, answer.stop, answer.claimed) == ("as shipped", Stop.DONE, True)


def test_with_own_defaults_there_is_a_second_call_for_a_last_step_that_the_user_asks_for():
    toy, state = prepared(("well", 1.0), ("well", 0.0), own_defaults=True, refine=True, eps=0.3)
    solved(state, own_defaults=True)
    assert asked(toy, "eps") == [0.3, 0.3]
    assert asked(toy, "finishes") == [False, True]


def test_the_last_step_is_asked_for_from_the_second_round_until_it_succeeds():
    class Failing(ToyState):
        def call(self, workspace, ask):
            reply = super().call(workspace, ask)
            return Reply(reply.status, reply.gap, 1, finished="" if len(toy.calls) < 3 else "refinement", reaction=R)

    R = np.array([0.0, 3.0])
    toy, state = prepared(*[("well", bound) for bound in (1.0, 0.9, 0.95, 0.8, 0.7)], state=Failing)
    answer = solved(state)
    assert asked(toy, "finishes") == [False, True, True, False, False]
    assert len(answer.findings) == 1
    assert answer.findings[0].startswith("refinement made the answer worse")


@pytest.mark.parametrize("reaction", [None, np.zeros(2), np.array([3.0, 0.0])])
def test_no_last_step_is_asked_for_where_no_bound_presses(reaction):
    """A reaction without contact is none."""

    class Free(ToyState):
        def call(self, workspace, ask):
            found = super().call(workspace, ask)
            return Reply(found.status, found.gap, 1, reaction=reaction)

    toy, state = prepared(*[("well", 1.0)] * 5, state=Free)
    solved(state)
    assert asked(toy, "finishes") == [False] * 5


def test_no_last_step_is_asked_for_where_the_user_wants_none():
    toy, state = prepared(*[("well", 1.0)] * 5, refine=False)
    solved(state)
    assert asked(toy, "finishes") == [False] * 5


def test_only_vectors_that_have_changed_are_handed_over():
    toy, state = prepared()
    other = cq.ContactQP(FIRST.G, [-1.0, 3.0], lower=[-1.0, 0.0], gap_scale=1.0)
    solved(state)
    solved(state, other)
    solved(state, other)
    ((workspace, changed),) = toy.changes
    assert workspace == 1
    assert list(changed) == ["l"]
    assert changed["l"].tolist() == [-1.0, 0.0]


def test_a_workspace_that_takes_no_change_is_made_anew():
    toy, state = prepared(toy={"takes_changes": False})
    solved(state)
    solved(state, FIRST.with_forces([1.0, 1.0]))
    assert [vectors["q"].tolist() for _, vectors in toy.made] == [[-1.0, 3.0], [1.0, 1.0]]
    assert [workspace for workspace, _ in toy.calls] == [1, 2]


def test_what_cannot_be_changed_at_all_is_set_up_anew():
    class Formed(ToyState):
        def form(self, problem, tol):
            return tol > 1e-4

    toy, state = prepared(state=Formed)
    for tol in (1e-6, 1e-7, 1e-3, 1e-3):
        solved(state, tol=tol)
    assert [workspace for workspace, _ in toy.calls] == [1, 1, 2, 2]
    assert asked(toy, "form") == [False, False, True, True]


@pytest.mark.parametrize("word", ["what?", "worn"])
def test_a_workspace_that_failed_or_is_worn_out_is_not_kept(word):
    toy, state = prepared((word, 0.0))
    answer = solved(state)
    assert answer.claimed is False
    solved(state)
    assert [workspace for workspace, _ in toy.calls] == [1, 2]


@pytest.mark.parametrize("word", ["long", "late"])
def test_a_workspace_is_kept_after_a_limit(word):
    toy, state = prepared((word, 1.0))
    solved(state)
    solved(state)
    assert [workspace for workspace, _ in toy.calls] == [1, 1]


def test_a_word_that_the_table_does_not_list_is_a_failure():
    toy, state = prepared(("what?", 1.0))
    answer = solved(state)
    assert (answer.stop, answer.termination) == (Stop.FAILED, "what?, eps 1e-05")
    assert len(toy.calls) == 1


@pytest.mark.parametrize("trouble", [KeyboardInterrupt, ZeroDivisionError])
def test_a_workspace_is_dropped_after_what_a_call_raises(trouble):
    toy, state = prepared(("well", 0.0), (trouble, None))
    solved(state)
    with pytest.raises(trouble):
        solved(state)
    solved(state)
    assert [workspace for workspace, _ in toy.calls] == [1, 1, 2]


def test_what_ctrl_c_left_at_work_is_not_used_again_and_comes_to_an_end():
    """A library that was told to stop fails, as it sees it; that is no reason to try again."""

    class Again(ToyState):
        starts_again = True

    def endless(ask):
        threads.append(threading.current_thread())
        threading.Timer(0.05, _thread.interrupt_main).start()
        assert ask.task.abandoned.wait(20.0)
        return "what?"

    threads: list[threading.Thread] = []
    toy, state = prepared(("well", 0.0), (endless, 0.0), state=Again)
    solved(state)
    # Tests that were started in the background ignore the signal.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            solved(state)
    finally:
        signal.signal(signal.SIGINT, handler)
    (thread,) = threads
    thread.join(20.0)
    assert not thread.is_alive()
    assert len(toy.made) == 1
    solved(state)
    solved(state)
    assert [workspace for workspace, _ in toy.calls] == [1, 1, 2, 2]


def test_a_failure_in_a_workspace_of_the_load_before_is_tried_again_where_the_library_asks_for_it():
    class Again(ToyState):
        starts_again = True

    for state_class, workspaces, stop in ((Again, [1, 1, 2], Stop.DONE), (ToyState, [1, 1], Stop.FAILED)):
        toy, state = prepared(("well", 0.0), ("what?", 1.0), ("well", 0.0), state=state_class)
        solved(state)
        answer = solved(state)
        assert [workspace for workspace, _ in toy.calls] == workspaces
        assert answer.stop is stop
    toy, state = prepared(("what?", 1.0), state=Again)
    assert solved(state).stop is Stop.FAILED
    assert len(toy.calls) == 1


def test_each_factor_on_the_objective_has_a_workspace_of_its_own():
    class Weighted(ToyState):
        def tighter(self, eps):
            yield Setting(1e-7)
            yield Setting(1e-8, weight=100.0)

    toy, state = prepared(*[("well", 1.0)] * 2, ("worn", 1.0), *[("well", 1.0)] * 3, state=Weighted)
    solved(state)
    solved(state)
    assert [workspace for workspace, _ in toy.calls] == [1, 1, 2, 1, 1, 3]
    assert [weight for weight, _ in toy.made] == [1.0, 100.0, 100.0]


def test_a_round_that_is_cut_short_is_followed_by_the_next():
    class Short(ToyState):
        most_iterations = 7

    script = [("long", 1.0, 7), ("long", 1.0, 7), ("long", 1.0, 2)]
    toy, state = prepared(*script, state=Short)
    answer = solved(state, max_iter=16)
    assert asked(toy, "iterations") == [7, 7, 2]
    assert (answer.stop, answer.iterations) == (Stop.ITERATION_LIMIT, 16)
    toy, state = prepared(*script, state=Short, own_defaults=True)
    assert solved(state, own_defaults=True).stop is Stop.ITERATION_LIMIT
    assert asked(toy, "iterations") == [50]


def test_a_warm_start_tells_gap_and_reaction():
    toy, state = prepared(state=WarmState)
    solved(state, warm_start=np.array([0.5, -1.0]))
    assert toy.starts == [(1, [0.5, 0.0], [0.0, 2.5])]
    assert asked(toy, "resumes") == [False]


def test_where_the_objective_is_larger_so_is_the_reaction():
    class Weighted(WarmState):
        def tighter(self, eps):
            yield Setting(1e-8, weight=100.0)

    toy, state = prepared(("well", 1.0), ("well", 0.0), state=Weighted)
    solved(state, warm_start=np.array([0.5, 0.0]))
    assert toy.starts == [(1, [0.5, 0.0], [0.0, 2.5]), (2, [0.5, 0.0], [0.0, 250.0])]


def test_a_solve_that_goes_on_calls_twice_before_the_judge_is_asked():
    script = [("well", 1.0), ("well", 0.0), ("well", 1.0, 3), ("well", 0.0, 4)]
    toy, state = prepared(*script, state=WarmState)
    first = solved(state)
    toy.calls.clear()
    answer = solved(state, warm_start=first.gap)
    assert asked(toy, "eps") == pytest.approx([1e-4, 1e-5])
    assert asked(toy, "finishes") == [False, True]
    assert asked(toy, "resumes") == [True, True]
    assert asked(toy, "iterations") == [1000, 997]
    assert (answer.iterations, answer.stop) == (7, Stop.DONE)


@pytest.mark.parametrize(("word", "iterations"), [("late", 3), ("well", 1000)])
def test_a_solve_that_goes_on_calls_once_where_nothing_is_left(word, iterations):
    toy, state = prepared(("well", 0.0), (word, 1.0, iterations), state=WarmState)
    first = solved(state)
    answer = solved(state, warm_start=first.gap)
    assert len(toy.calls) == 2
    assert answer.iterations == iterations


def test_a_solve_without_a_warm_start_begins_at_zero():
    toy, state = prepared(state=WarmState)
    solved(state)
    assert toy.starts == []
    solved(state)
    assert toy.starts == [(1, [0.0, 0.0], [0.0, 0.0])]
    assert asked(toy, "resumes") == [False, False]


def test_with_own_defaults_no_solve_goes_on():
    toy, state = prepared(state=WarmState, own_defaults=True)
    for _ in range(2):
        solved(state, own_defaults=True, warm_start=np.zeros(2))
    assert asked(toy, "resumes") == [False, False]
    assert len(toy.starts) == 2


def test_time_that_runs_out_during_set_up():
    class Slow(ToyState):
        def set_up(self, ask, vectors):
            ask.task.started -= 100.0
            return super().set_up(ask, vectors)

    toy, state = prepared(state=Slow)
    answer = solved(state, time_limit=60.0)
    assert (answer.gap, answer.stop, answer.termination) == (None, Stop.TIME_LIMIT, "time limit during set-up")
    assert answer.setup_seconds > 0
    assert toy.calls == []
    assert solved(state).stop is Stop.DONE
    assert len(toy.made) == 1


def test_seconds_are_told_in_numbers_that_a_library_takes():
    toy, state = prepared()
    solved(state)
    solved(state, time_limit=60.0)
    assert toy.calls[0][1].seconds == 1e10
    assert 0 < toy.calls[1][1].seconds <= 60.0


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"damping": 1.0}, ValueError, "damping must lie strictly between 0 and 1, got 1"),
        ({"rho": 0}, ValueError, "rho must be > 0, got 0"),
        ({"rho": "x"}, TypeError, "rho must be a real number, got 'x'"),
        ({"how": "fats"}, ValueError, "how must be one of 'well', 'fast', got 'fats'; did you mean 'fast'?"),
        ({"eps": -1}, ValueError, "eps must be > 0, got -1"),
        ({"eps": -1, "damping": 7}, ValueError, "damping must lie strictly between 0 and 1, got 7"),
    ],
)
def test_options_are_checked_as_they_are_declared(options, error, words):
    with pytest.raises(error) as caught:
        prepared(**options)
    assert str(caught.value) == words


def test_options_are_settings_of_the_library():
    _, state = prepared(rho=2.0)
    assert state.settings == {"damping": 0.5, "rho": 2.0, "how": "well"}
    assert ToyBackend().options() == {"damping": 0.5, "rho": None, "how": "well", "refine": True, "eps": None}
