"""What other distributions' backends may get wrong, and what is said of it."""

import numpy as np
import pytest
from typer.testing import CliRunner

import contactqp as cq
from contactqp import backends
from contactqp.backends.base import Answer, Backend, Stop
from contactqp.cli.commands import app

PROBLEM = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])


def answer(gap=(0.0, 0.0), stop=Stop.DONE, termination="optimal, honestly", iterations=1, seconds=0.0):
    return Answer(gap if gap is None else np.array(gap), stop, termination, iterations, seconds, 0.0)


def returning(value):
    class Made(Backend):
        name, summary, package = "stranger", "returns anything", "numpy"

        def solve(self, problem, task):
            return value

    return Made()


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (None, TypeError, "returned None where an Answer is needed"),
        (np.zeros(2), TypeError, "returned an object of type ndarray where an Answer is needed"),
        (answer(gap=[0.0]), ValueError, r"must have shape \(2,\), one number for each unknown, got \(1,\)"),
        (answer(gap=0.0), ValueError, r"must have shape \(2,\), one number for each unknown, got \(\)"),
        (answer(gap=[1j, 0.0]), TypeError, "must be real, got complex values"),
        (answer(gap=["a", "b"]), TypeError, "must hold real numbers"),
        (answer(stop="finished"), ValueError, "stop is 'finished'; take one of done, iteration_limit, time_limit"),
        (answer(stop=None), ValueError, "stop is None; take one of"),
        (answer(termination=None), TypeError, "termination must be a text, got None"),
        (answer(iterations=2.5), TypeError, "iterations, which .*, must be an integer, got 2.5"),
        (answer(seconds=None), TypeError, "setup_seconds, which .*, must be a real number, got None"),
    ],
)
def test_an_answer_that_is_none_is_refused_and_named(value, error, words):
    with pytest.raises(error, match=words) as caught:
        cq.solve(PROBLEM, returning(value))
    assert "backend 'stranger' returned" in str(caught.value)
    (row,) = cq.compare(PROBLEM, [returning(value)]).rows
    assert row.status == "error"
    assert "backend 'stranger' returned" in row.message


@pytest.mark.parametrize("stop", [Stop.DONE, Stop.ITERATION_LIMIT])
def test_nan_is_a_failure_in_words(stop):
    solution = cq.solve(PROBLEM, returning(answer(gap=[0.5, np.nan], stop=stop)), on_failure="ignore")
    assert solution.status == "failed"
    assert solution.termination == "optimal, honestly; but the gap is nan at unknown 1 (1 of 2 not finite)"
    assert solution.claimed_solved == (stop is Stop.DONE)


def test_nothing_may_be_returned_by_a_backend_that_says_so():
    solution = cq.solve(PROBLEM, returning(answer(gap=None, stop=Stop.TIME_LIMIT)), on_failure="ignore")
    assert solution.status == "time_limit"


def test_a_question_of_another_shape_is_refused():
    class Asking(Backend):
        name, summary, package = "asking", "asks", "numpy"

        def solve(self, problem, task):
            task.bound(np.zeros(1))

    with pytest.raises(ValueError, match=r"bound\(gap\) needs shape \(2,\), got \(1,\)") as caught:
        cq.solve(PROBLEM, Asking())
    assert "raised by backend 'asking'" in caught.value.__notes__[0]


@pytest.mark.parametrize("missing", ["name", "summary", "package"])
@pytest.mark.parametrize("value", [None, "", 3])
def test_what_a_backend_must_declare_is_told(missing, value):
    declared = {"name": "half", "summary": "a method", "package": "numpy"}
    if value is None:
        del declared[missing]
    else:
        declared[missing] = value
    made = type("Half", (Backend,), declared | {"solve": lambda self, problem, task: None})()
    called = "Half" if missing == "name" else "'half'"
    told = f"backend {called} must have a class attribute '{missing}', a text that is not empty, but "
    for call in (cq.solve, cq.Solver, lambda problem, backend: cq.compare(problem, [backend])):
        with pytest.raises(TypeError) as caught:
            call(PROBLEM, made)
        assert str(caught.value) == told + ("has none" if value is None else f"it is {value!r}")


def test_a_need_that_cannot_be_asked_is_refused():
    made = returning(answer())
    type(made).needs = ("M-matrix",)
    with pytest.raises(TypeError, match=r"backend 'stranger' needs 'M-matrix', which has no method holds\(problem\)"):
        cq.solve(PROBLEM, made)


def test_what_prepare_returns_must_be_a_state():
    class Unprepared(Backend):
        name, summary, package = "unprepared", "keeps nothing", "numpy"

        def prepare(self, problem, task):
            return None

    told = "prepare of backend 'unprepared' must return a State, got None"
    with pytest.raises(TypeError, match=told):
        cq.solve(PROBLEM, Unprepared())
    with pytest.raises(TypeError, match=told):
        cq.Solver(PROBLEM, Unprepared()).solve()


PLUGINS = """
from contactqp.backends.active_set import ActiveSetBackend

class Renamed(ActiveSetBackend):
    name = "another"

class Crashing(ActiveSetBackend):
    name = "crashing"

    def prepare(self, problem, task):
        raise ValueError("deep inside")
"""


@pytest.fixture
def plugins(tmp_path, monkeypatch):
    """A distribution with an entry point of another name than its backend, and a backend that raises."""
    (tmp_path / "strange_backends.py").write_text(PLUGINS)
    record = tmp_path / "strange-1.0.dist-info"
    record.mkdir()
    (record / "METADATA").write_text("Metadata-Version: 2.1\nName: strange\nVersion: 1.0\n")
    (record / "entry_points.txt").write_text(
        "[contactqp.backends]\nrenamed = strange_backends:Renamed\ncrashing = strange_backends:Crashing\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    backends._outsiders.cache_clear()
    yield
    backends._outsiders.cache_clear()


def test_an_entry_point_of_another_name_is_refused(plugins):
    told = "calls itself 'another'; its entry point must have the same name"
    with pytest.raises(cq.MissingBackendError, match=told):
        cq.solve(PROBLEM, "renamed")
    (row,) = cq.compare(PROBLEM, ["renamed"]).rows
    assert row.status == "missing"
    assert told in row.message
    assert told in cq.compare(PROBLEM).left_out["renamed"]
    listed = CliRunner().invoke(app, ["backends"])
    assert told in " ".join(listed.output.split())


def test_the_command_line_names_the_backend_that_raised(plugins):
    solved = CliRunner().invoke(app, ["solve", "examples/cable.toml", "--backend", "crashing"])
    assert solved.exit_code == 2
    assert "contactqp: deep inside (raised by backend 'crashing' on " in solved.output
    compared = CliRunner().invoke(app, ["compare", "examples/cable.toml", "--backends", "crashing", "--wide"])
    assert "ValueError: deep inside" in compared.output
    assert "crashing" in compared.output
