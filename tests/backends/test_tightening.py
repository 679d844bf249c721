"""The loop of the library backends, with a library that answers by a script."""

import _thread
import signal
import threading
import time

import numpy as np
import pytest

from contactqp.backends.base import Stop, Task
from contactqp.backends.tightening import Round, tightened


class Library:
    """Returns the rounds of a script; a gap's only entry is its bound."""

    def __init__(self, *rounds):
        self.rounds = rounds
        self.asked = []

    def __call__(self, setting, iterations_left):
        self.asked.append((setting, iterations_left))
        return self.rounds[len(self.asked) - 1]


class Judge:
    """Reads the bound from the gap, and remembers what it was asked about."""

    def __init__(self):
        self.gaps = []

    def __call__(self, gap):
        self.gaps.append(gap)
        return float(gap[0])


def task_of(tol=1e-6, **options):
    return Task(tol, None, options.pop("time_limit", None), None, options.pop("bound", Judge()), **options)


def a_round(bound, stop=Stop.DONE, termination="solved", iterations=10, **options):
    gap = None if bound is None else np.array([bound])
    return Round(gap, stop, termination, iterations, claims=options.pop("claims", stop is Stop.DONE), **options)


def test_it_tightens_until_the_judge_is_satisfied():
    library = Library(a_round(1e-2), a_round(1e-4, iterations=20), a_round(1e-7, termination="very well"))
    task = task_of()
    answer = tightened(task, library, [3, 2, 1, 0], 100, note="as asked")
    assert library.asked == [(3, 100), (2, 90), (1, 70)]
    assert answer.gap is library.rounds[2].gap
    assert answer.gap is task.bound.gaps[-1]
    assert len(task.bound.gaps) == 3
    assert (answer.stop, answer.iterations, answer.termination) == (Stop.DONE, 40, "very well")
    assert (answer.note, answer.findings, answer.claimed) == ("as asked", (), True)


def test_one_setting_is_one_call():
    library = Library(a_round(1e-2))
    answer = tightened(task_of(), library, ["as shipped"], 100)
    assert library.asked == [("as shipped", 100)]
    assert (answer.stop, answer.claimed) == (Stop.DONE, True)


@pytest.mark.parametrize(("finish", "findings"), [("", 0), ("polish", 1)])
def test_the_best_answer_is_kept_and_a_last_step_that_harmed_is_a_finding(finish, findings):
    library = Library(a_round(1e-2), a_round(1e-5), a_round(1e-3, finish=finish), a_round(2e-5))
    answer = tightened(task_of(), library, range(4), 100)
    assert answer.gap is library.rounds[1].gap
    assert (answer.stop, answer.iterations) == (Stop.DONE, 40)
    assert len(answer.findings) == findings
    if findings:
        assert answer.findings[0].startswith("polish made the answer worse: bound 0.001 after, 1e-05 before")


def test_a_last_step_that_helped_is_no_finding():
    library = Library(a_round(1e-2), a_round(1e-9, finish="polish"))
    assert tightened(task_of(), library, range(4), 100).findings == ()


def test_iterations_are_limited_over_all_rounds():
    library = Library(a_round(1e-2, iterations=60), a_round(1e-3, iterations=40), a_round(1e-9))
    answer = tightened(task_of(), library, range(3), 100)
    assert library.asked == [(0, 100), (1, 40)]
    assert (answer.stop, answer.iterations, answer.claimed) == (Stop.ITERATION_LIMIT, 100, False)
    assert answer.gap is library.rounds[1].gap


def test_an_answer_that_satisfies_the_judge_at_the_limit_is_one():
    library = Library(a_round(1e-9, Stop.ITERATION_LIMIT, "enough", iterations=100))
    answer = tightened(task_of(), library, range(3), 100)
    assert (answer.stop, answer.termination, answer.claimed) == (Stop.DONE, "enough", False)


@pytest.mark.parametrize("stop", [Stop.FAILED, Stop.TIME_LIMIT, Stop.ITERATION_LIMIT])
@pytest.mark.parametrize(("bound", "best"), [(1e-3, 1), (1e-1, 0), (None, 0)])
def test_after_a_limit_or_a_failure_it_ends_with_the_best_so_far(stop, bound, best):
    library = Library(a_round(1e-2), a_round(bound, stop, "alas"), a_round(1e-9))
    task = task_of()
    answer = tightened(task, library, range(3), 100)
    assert (answer.stop, answer.termination, answer.claimed, answer.iterations) == (stop, "alas", False, 20)
    assert answer.gap is library.rounds[best].gap
    assert all(gap is not None for gap in task.bound.gaps)


def test_nothing_to_return_is_none():
    answer = tightened(task_of(), Library(a_round(None, Stop.FAILED, "infeasible")), range(3), 100)
    assert (answer.gap, answer.stop, answer.termination) == (None, Stop.FAILED, "infeasible")


def test_a_gap_without_a_bound_is_better_than_none():
    library = Library(a_round(np.inf), a_round(np.inf))
    answer = tightened(task_of(), library, range(2), 100)
    assert answer.gap is library.rounds[0].gap
    assert answer.stop is Stop.DONE


def test_time_that_set_up_has_used_up_leaves_none_for_a_call():
    library = Library(a_round(1e-9))
    late = task_of(time_limit=5.0, started=time.perf_counter() - 10.0)
    answer = tightened(late, library, range(3), 100, setup_seconds=10.0)
    assert library.asked == []
    assert (answer.gap, answer.stop, answer.claimed) == (None, Stop.TIME_LIMIT, False)
    assert answer.termination == "time limit during set-up"
    assert answer.setup_seconds == 10.0


def test_the_clock_is_looked_at_before_every_call():
    task = task_of(time_limit=60.0)
    library = Library(a_round(1e-2), a_round(1e-3), a_round(1e-9))

    def slow(setting, iterations_left):
        found = library(setting, iterations_left)
        task.started -= 40.0
        return found

    answer = tightened(task, slow, range(3), 100)
    assert library.asked == [(0, 100), (1, 90)]
    assert (answer.stop, answer.termination, answer.claimed) == (Stop.TIME_LIMIT, "solved", False)
    assert answer.gap is library.rounds[1].gap


def test_a_schedule_can_decide_by_the_round_before():
    library = Library(a_round(1e-2), a_round(1e-3), a_round(1e-4))

    def schedule():
        yield "first"
        while library.rounds[len(library.asked) - 1].gap[0] > 5e-4:
            yield f"after {len(library.asked)}"

    answer = tightened(task_of(), library, schedule(), 100)
    assert [setting for setting, _ in library.asked] == ["first", "after 1", "after 2"]
    assert answer.stop is Stop.DONE


def test_set_up_within_and_before_the_rounds_is_counted():
    library = Library(a_round(1e-2, setup_seconds=0.25), a_round(1e-9, setup_seconds=0.5))
    answer = tightened(task_of(), library, range(2), 100, setup_seconds=2.0)
    assert answer.setup_seconds == 2.75
    assert answer.solve_seconds < 0


def test_ctrl_c_is_passed_on_and_the_library_is_told():
    task, told = task_of(), threading.Event()

    def endless(setting, iterations_left):
        threading.Timer(0.05, _thread.interrupt_main).start()
        if task.abandoned.wait(20.0):
            told.set()
        return a_round(1e-9)

    # Tests that were started in the background ignore the signal.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            tightened(task, endless, range(3), 100)
    finally:
        signal.signal(signal.SIGINT, handler)
    assert told.wait(20.0)


def test_what_a_call_raises_is_passed_on():
    def broken(setting, iterations_left):
        raise ZeroDivisionError("deep inside")

    with pytest.raises(ZeroDivisionError, match="deep inside"):
        tightened(task_of(), broken, range(3), 100)
