"""The conformance kit: the package's own backends pass it, and backends that are broken on purpose are found out."""

import os
import sys
import time
import warnings
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from strategies import BACKENDS
from typer.testing import CliRunner

import contactqp as cq
from contactqp import backends
from contactqp.backends.base import Answer, Backend, Need, State, Stop
from contactqp.backends.option_checks import Check
from contactqp.cli.commands import app
from contactqp.foundation.checks import open_interval
from contactqp.testing import check_backend
from contactqp.testing.known_problems import one_sided, other_matrices, two_sided

factor = Annotated[float, Check(lambda value, name: open_interval(value, 0.0, 1.5, name))]


class Sound(Backend):
    """Projected Gauss-Seidel, as it should be written; the broken ones below change one thing each."""

    name: ClassVar[str] = "sound"
    summary: ClassVar[str] = "projected relaxation"
    package: ClassVar[str] = "numpy"
    needs: Any = (Need.Z_MATRIX,)

    def solve(self, problem, task, *, damping: factor = 0.9) -> Answer:
        gap = problem.project(np.zeros(problem.size) if task.warm_start is None else task.warm_start)
        stop, sweep, most = Stop.ITERATION_LIMIT, 0, task.max_iter or 3000
        while sweep < most and stop is Stop.ITERATION_LIMIT:
            gap = self.improved(problem, gap, damping)
            sweep += 1
            if sweep % 5 == 0 and task.accepts(gap):
                stop = Stop.DONE
            elif task.seconds_left <= 0:
                stop = Stop.TIME_LIMIT
        return Answer(gap, stop, stop.value, sweep, 0.0, 0.0)

    def improved(self, problem, gap, damping):
        return problem.project(gap - damping * problem.reaction(gap) / problem.stiffness.diagonal())


class Zeros(Sound):
    def solve(self, problem, task) -> Answer:
        return Answer(np.zeros(problem.size), Stop.DONE, "optimal", 1, 0.0, 0.0)


class ChangesForces(Sound):
    def solve(self, problem, task) -> Answer:
        forces = problem.q
        forces.setflags(write=True)
        found = super().solve(problem, task)
        forces *= 1.5
        return found


class ChangesReadOnly(Sound):
    def solve(self, problem, task) -> Answer:
        problem.q[:] = 0.0
        return super().solve(problem, task)


class ChangesStart(Sound):
    def solve(self, problem, task) -> Answer:
        if task.warm_start is not None:
            task.warm_start[:] = 0.0
        return super().solve(problem, task)


class Prints(Sound):
    def solve(self, problem, task) -> Answer:
        print("iteration 1")
        return super().solve(problem, task)


class PrintsBelow(Sound):
    def solve(self, problem, task) -> Answer:
        os.write(1, b"Polishing not needed")
        return super().solve(problem, task)


class Warns(Sound):
    def solve(self, problem, task) -> Answer:
        warnings.warn("exit flag 0", stacklevel=1)
        return super().solve(problem, task)


class IgnoresIterations(Sound):
    def solve(self, problem, task) -> Answer:
        task.max_iter = None
        return super().solve(problem, task)


class IgnoresTime(Sound):
    """Works on for a while, so that the test does not leave it behind for ever."""

    def solve(self, problem, task) -> Answer:
        if task.time_limit is not None:
            end = time.perf_counter() + 8.0
            while time.perf_counter() < end:
                time.sleep(0.05)
        return super().solve(problem, task)


class Forgets(State):
    def __init__(self, backend, problem):
        self.backend, self.problem, self.answer = backend, problem, None

    def solve(self, q, task, problem=None):
        if self.answer is None:
            self.answer = self.backend.relaxed(self.problem, task)
        return self.answer


class NoSession(Sound):
    """Answers the first load whatever the load is."""

    def relaxed(self, problem, task):
        return Sound.solve(self, problem, task)

    solve = Backend.solve

    def prepare(self, problem, task):
        return Forgets(self, problem)


class Rewrites(State):
    def __init__(self, backend, problem):
        self.backend, self.problem, self.memory = backend, problem, np.zeros(problem.size)

    def solve(self, q, task, problem=None):
        now = self.problem if problem is None else problem
        found = self.backend.relaxed(now, task)
        self.memory[:] = found.gap
        return Answer(self.memory, found.stop, found.termination, found.iterations, 0.0, 0.0)


class OwnMemory(NoSession):
    """Returns the array that it goes on to work in."""

    def prepare(self, problem, task):
        return Rewrites(self, problem)


class Swallows(Sound):
    def solve(self, problem, task) -> Answer:
        try:
            return super().solve(problem, task)
        except BaseException:
            return Answer(None, Stop.FAILED, "something went wrong", 0, 0.0, 0.0)


class TakesAnything(Sound):
    def solve(self, problem, task, *, damping=0.9) -> Answer:
        return super().solve(problem, task, damping=0.9)


class Random(Sound):
    def improved(self, problem, gap, damping):
        return super().improved(problem, gap, np.random.default_rng().uniform(0.5, 0.9))


class Rounds(Sound):
    """Adds up in another order each time, and says so."""

    repeatable = False

    def improved(self, problem, gap, damping):
        noise = np.random.default_rng().uniform(-1e-15, 1e-15, gap.size)
        return problem.project(super().improved(problem, gap, damping) + noise * (gap > 0))


class Global(Sound):
    """Keeps the problem at hand where all threads find it."""

    here: Any = None

    def solve(self, problem, task) -> Answer:
        type(self).here = problem
        time.sleep(0.05)
        return super().solve(type(self).here, task)


class Claims(Sound):
    def solve(self, problem, task) -> Answer:
        found = super().solve(problem, task)
        return Answer(found.gap, Stop.DONE, "optimal", found.iterations, 0.0, 0.0)


class Bare(Sound):
    def solve(self, problem, task) -> Answer:
        return np.zeros(problem.size)  # type: ignore[return-value]


class Crashes(Sound):
    def solve(self, problem, task) -> Answer:
        raise SystemExit("no licence")


class SaysNothing(Sound):
    def solve(self, problem, task) -> Answer:
        found = super().solve(problem, task)
        return Answer(found.gap, found.stop, "", found.iterations, 0.0, -1.0)


class Undeclared(Sound):
    summary: ClassVar[str] = ""


class OddNeed(Sound):
    class Wordless(Need):
        name = "luck"

        def holds(self, problem) -> Any:
            return True

    needs = (Wordless(),)


BROKEN = {
    Zeros: {"one-sided problems", "two-sided problems", "warm start", "session"},
    ChangesForces: {"unmodified inputs"},
    ChangesReadOnly: {"unmodified inputs", "one-sided problems"},
    ChangesStart: {"warm start"},
    Prints: {"silence"},
    PrintsBelow: {"silence"},
    Warns: {"silence"},
    IgnoresIterations: {"iteration limit"},
    IgnoresTime: {"time limit"},
    NoSession: {"session"},
    OwnMemory: {"session"},
    Swallows: {"interrupts"},
    TakesAnything: {"wrong options"},
    Random: {"determinism"},
    Global: {"threads"},
    Claims: {"iteration limit"},
    Bare: {"one-sided problems", "facts of answers"},
    Crashes: {"one-sided problems", "silence"},
    SaysNothing: {"facts of answers"},
    Undeclared: {"declared facts"},
    OddNeed: {"declared facts"},
}
"""What each is found out by; checks that fail as a consequence may come on top."""

ALONE = [
    Prints,
    PrintsBelow,
    Warns,
    IgnoresIterations,
    IgnoresTime,
    NoSession,
    OwnMemory,
    TakesAnything,
    Random,
    Global,
]
"""Those of which every other thing is as it should be."""


def test_a_sound_backend_passes():
    report = check_backend(Sound())
    assert report.ok, report
    assert {result.outcome for result in report.results} == {"pass", "skip"}


def test_answers_that_repeat_to_rounding_pass_where_that_is_declared():
    def determinism(backend):
        return next(result for result in check_backend(backend).results if result.check == "determinism")

    assert determinism(Rounds()).outcome == "pass"
    undeclared, random = Rounds(), Random()
    vars(undeclared)["repeatable"], vars(random)["repeatable"] = True, False
    assert determinism(undeclared).expected == "the same gap twice, to the bit"
    assert determinism(random).expected == "the same gap twice, to rounding"


@pytest.mark.parametrize("name", BACKENDS)
def test_our_own_backends_pass(name):
    report = check_backend(name)
    assert report.ok, report


@pytest.mark.slow
@pytest.mark.parametrize("broken", BROKEN)
def test_what_is_broken_is_named(broken):
    report = check_backend(broken())
    failed = {result.check for result in report.failures}
    assert not report.ok
    assert failed >= BROKEN[broken], report
    if broken in ALONE:
        assert failed == BROKEN[broken], report
    for result in report.failures:
        assert result.expected
        assert result.got
        assert result.expected in " ".join(repr(report).split()).replace("- ", "-") or len(result.expected) > 40


def test_the_report_says_what_was_expected_and_what_came():
    report = repr(check_backend(Zeros()))
    assert report.startswith("sound: ")
    assert "FAIL  one-sided problems" in report
    assert "expected: a gap certified to 1e-06 for a lattice of 100 nodes" in report
    assert "which the backend claims to be" in report
    assert max(map(len, report.splitlines())) <= 80


def test_what_does_not_apply_is_skipped_with_the_reason():
    (two,) = (result for result in check_backend("mangasarian").results if result.check == "two-sided problems")
    assert two.outcome == "skip"
    assert "needs a problem without an upper bound" in two.got


def test_a_check_that_hangs_ends_and_the_others_are_made():
    class Hangs(Sound):
        def solve(self, problem, task) -> Answer:
            time.sleep(1.0 if problem.size == 12 else 0.0)
            return super().solve(problem, task)

    before = sys.stdout
    report = check_backend(Hangs(), seconds=0.8)
    assert sys.stdout is before
    results = {result.check: result for result in report.results}
    assert results["one-sided problems"].got == "it was still at work, and is left behind"
    assert results["determinism"].outcome == "pass"


def test_bad_arguments_are_refused():
    with pytest.raises(cq.UnknownBackendError):
        check_backend("no-such-backend")

    class Missing(Sound):
        package: ClassVar[str] = "a-package-that-is-not-installed"

    with pytest.raises(cq.MissingBackendError, match="pip install a-package"):
        check_backend(Missing())
    with pytest.raises(ValueError, match="tol must lie strictly between 0 and 1"):
        check_backend("psor", tol=2.0)
    with pytest.raises(ValueError, match="seconds must be > 0"):
        check_backend("psor", seconds=0.0)


@pytest.mark.parametrize("known", [*one_sided(), *two_sided(), *other_matrices()], ids=lambda known: known.label)
def test_the_known_problems_have_the_known_solutions(known):
    solution = cq.solve(known.problem, tol=1e-9)
    assert solution.status == "certified"
    assert solution.gap == pytest.approx(known.gap, abs=1e-9)


def test_the_known_problems_have_contact_at_each_bound_that_they_have():
    for known in two_sided():
        solution = cq.solve(known.problem)
        assert solution.contact_lower.any()
        assert solution.contact_upper.any()
        assert not solution.contact.all()


PLUGIN = '''
"""A backend of another distribution."""
import numpy as np
from contactqp.backends.base import Answer, Backend, Need, Stop

class Relaxed(Backend):
    name, summary, package, licence = "toy-relaxation", "projected relaxation", "toy-distribution", "MIT"
    needs = (Need.Z_MATRIX,)

    def solve(self, problem, task) -> Answer:
        gap = problem.project(np.zeros(problem.size) if task.warm_start is None else task.warm_start)
        stop, sweep, most = Stop.ITERATION_LIMIT, 0, task.max_iter or 100_000
        while sweep < most and stop is Stop.ITERATION_LIMIT:
            gap = problem.project(gap - 0.9 * problem.reaction(gap) / problem.stiffness.diagonal())
            sweep += 1
            if sweep % 5 == 0 and task.accepts(gap):
                stop = Stop.DONE
            elif task.seconds_left <= 0:
                stop = Stop.TIME_LIMIT
        return Answer(gap, stop, stop.value, sweep, 0.0, 0.0)
'''


@pytest.fixture
def distribution(tmp_path, monkeypatch):
    """An installed distribution with a module, and an entry point that names its backend."""
    (tmp_path / "toy_distribution.py").write_text(PLUGIN)
    record = tmp_path / "toy_distribution-2.5.dist-info"
    record.mkdir()
    (record / "METADATA").write_text("Metadata-Version: 2.1\nName: toy-distribution\nVersion: 2.5\n")
    (record / "entry_points.txt").write_text("[contactqp.backends]\ntoy-relaxation = toy_distribution:Relaxed\n")
    monkeypatch.syspath_prepend(tmp_path)
    backends._outsiders.cache_clear()
    yield
    backends._outsiders.cache_clear()


def test_a_distribution_that_is_installed_adds_a_backend(distribution):
    assert cq.backend_names()[-1] == "toy-relaxation"
    assert backends.kind_of("toy-relaxation") == "plug-in"
    report = check_backend("toy-relaxation")
    assert report.ok, report
    comparison = cq.compare(cq.gallery.islands(), "all")
    assert "toy-relaxation" in [row.backend for row in comparison.rows]
    assert comparison.agree
    listed = CliRunner().invoke(app, ["backends"]).output
    told = " ".join(line for line in listed.splitlines() if line.startswith("toy-relaxation"))
    assert "toy-distribution 2.5" in told
    assert "MIT" in told
    assert listed.index("plug-in:") > listed.index("cvxpy family:")
