"""A time limit holds, set-up and judging included, even where a call cannot be stopped."""

import threading
import time

import numpy as np
import pytest
from ctrl_c import PROMPTLY

import contactqp as cq
from contactqp.backends.base import Answer, Backend, State, Stop
from contactqp.foundation.loading import apart, is_loading
from contactqp.problem.facts import MatrixFacts

SLEEP = 5.0
"""Seconds of a call that does not look at the clock: far more than limit and slack together."""

SMALL = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
FULL = cq.ContactQP(0.1 * np.eye(3) + 0.9, [-1.0, 0.0, 0.0])


class Deaf(Backend):
    """Asks the judge once or never, and then does not come back in time."""

    name, summary, package = "deaf", "does not look at the clock", "numpy"

    def solve(self, problem, task, *, asks=False):
        if asks:
            task.bound(np.array([1.2, 0.0]))
            task.bound(np.array([1.01, 0.0]))
            task.bound(np.array([5.0, 5.0]))
        time.sleep(SLEEP)
        return Answer(np.array([0.5, 0.0]), Stop.DONE, "done", 1, 0.0, 0.0)


class SlowToPrepare(Backend):
    """Takes too long to set up."""

    name, summary, package = "slow", "takes long to set up", "numpy"
    prepared = 0

    def prepare(self, problem, task):
        type(self).prepared += 1
        time.sleep(SLEEP)
        return Prepared()


class Prepared(State):
    def solve(self, q, task, problem=None):
        return Answer(np.zeros(q.size), Stop.DONE, "done", 1, 0.0, 0.0)


def within_the_limit(call, limit=0.2):
    started = time.perf_counter()
    found = call()
    assert time.perf_counter() - started < limit + PROMPTLY
    return found


@pytest.mark.slow
def test_a_backend_that_does_not_look_at_the_clock_is_left_behind():
    solution = within_the_limit(lambda: cq.solve(SMALL, Deaf(), time_limit=0.2, on_failure="ignore"))
    assert solution.status == "time_limit"
    assert not solution.finite
    assert "left behind" in solution.termination


class SlowToLoad(Deaf):
    """Compiles for long at its first call."""

    over = threading.Event()

    def solve(self, problem, task):
        apart(self.over.wait)
        return Answer(None, Stop.FAILED, "", 0, 0.0, 0.0)


def test_a_limit_that_loading_uses_up_is_told_of_and_no_work():
    solution = cq.solve(SMALL, SlowToLoad(), time_limit=0.01, on_failure="ignore")
    SlowToLoad.over.set()
    while is_loading():
        time.sleep(0.01)
    assert solution.status == "time_limit"
    assert "compiling kernels" in solution.termination
    assert solution.run.abandoned
    assert 0 <= solution.seconds < solution.loading_seconds


@pytest.mark.slow
def test_the_best_answer_that_the_judge_was_asked_about_is_kept():
    solution = within_the_limit(lambda: cq.solve(SMALL, Deaf(), time_limit=0.2, asks=True, on_failure="ignore"))
    assert solution.status == "time_limit"
    np.testing.assert_allclose(solution.gap, np.array([1.01, 0.0]) * SMALL.scaled()[1].length, rtol=1e-12)
    assert np.isfinite(solution.relative_bound)


@pytest.mark.slow
def test_a_session_whose_set_up_takes_too_long_prepares_anew():
    session = cq.Solver(SMALL, SlowToPrepare(), time_limit=0.2)
    for count in (1, 2):
        solution = within_the_limit(lambda: session.solve(on_failure="ignore"))
        assert solution.status == "time_limit"
        assert SlowToPrepare.prepared == count


class PreparesOnceTooLong(Backend):
    """Is held up in its first set-up, and tells for which matrix its states were made."""

    name, summary, package = "held up", "is held up once", "numpy"

    def __init__(self):
        self.goes_on, self.done, self.prepared, self.used = threading.Event(), threading.Event(), 0, []

    def prepare(self, problem, task):
        self.prepared += 1
        if self.prepared == 1:
            self.goes_on.wait()
        return PreparedFor(problem, self)


class PreparedFor(State):
    def __init__(self, problem, backend):
        self.entry, self.backend = problem.G[0, 1], backend

    def solve(self, q, task, problem=None):
        self.backend.used.append((self.entry, problem.G[0, 1]))
        self.backend.done.set()
        return Answer(np.zeros(q.size), Stop.DONE, "done", 1, 0.0, 0.0)


@pytest.mark.slow
def test_a_set_up_that_was_left_behind_does_not_replace_a_later_one():
    backend, other = PreparesOnceTooLong(), cq.ContactQP([[2.0, -0.5], [-0.5, 2.0]], SMALL.q)
    session = cq.Solver(SMALL, backend, time_limit=0.2)
    assert session.solve(on_failure="ignore").status == "time_limit"
    session.solve_varied(other)
    backend.done.clear()
    backend.goes_on.set()
    assert backend.done.wait(SLEEP)
    session.solve_varied(other)
    assert backend.used[-1][0] == backend.used[-1][1]


def test_a_session_that_was_interrupted_prepares_anew():
    class Interrupted(Prepared):
        def solve(self, q, task, problem=None):
            raise KeyboardInterrupt

    class Counting(Backend):
        name, summary, package = "interrupted", "is interrupted once", "numpy"
        prepared = 0

        def prepare(self, problem, task):
            self.prepared += 1
            return Interrupted() if self.prepared == 1 else Prepared()

    backend = Counting()
    session = cq.Solver(SMALL, backend, time_limit=5.0)
    with pytest.raises(KeyboardInterrupt):
        session.solve()
    session.solve(on_failure="ignore")
    assert backend.prepared == 2


@pytest.mark.slow
def test_proofs_that_take_too_long_are_left_out(monkeypatch):
    def slow(self):
        time.sleep(SLEEP)

    monkeypatch.setattr(MatrixFacts, "least_eigenvalue", property(slow))
    problem = cq.ContactQP(FULL.G, FULL.q)
    solution = within_the_limit(
        lambda: cq.solve(problem, "active-set" if problem.is_m_matrix else "psor", time_limit=0.2, on_failure="ignore")
    )
    assert not solution.status.ok
    assert solution.relative_bound == np.inf


def test_a_limit_that_is_not_reached_changes_nothing():
    free, limited = cq.solve(SMALL), cq.solve(SMALL, time_limit=60.0)
    assert (free.gap == limited.gap).all()
    assert limited.status == "certified"


def test_an_error_in_the_backend_is_passed_on():
    class Broken(Backend):
        name, summary, package = "broken", "raises", "numpy"

        def solve(self, problem, task):
            raise ZeroDivisionError("deep inside")

    for limit in (None, 5.0):
        with pytest.raises(ZeroDivisionError, match="deep inside") as caught:
            cq.solve(SMALL, Broken(), time_limit=limit)
        assert "backend 'broken'" in "".join(caught.value.__notes__)
