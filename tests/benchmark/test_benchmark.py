"""The benchmark: processes with limits, wrong claims, records that go on, statistics by hand, and the report."""

import json
import math
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pandas
import pytest
from liars import Crash, Glutton, Liar
from typer.testing import CliRunner

import contactqp as cq
from contactqp import benchmark
from contactqp.benchmark.record import Record
from contactqp.benchmark.results import Results
from contactqp.benchmark.suites import GIB
from contactqp.cli.commands import app

SMALL = benchmark.Suite("small", {"bowl": (7,), "dense": (20,)}, ("mid",), 5.0, 4 * GIB, 1)


def record(backend, problem, seconds, status="certified", level="mid", **known):
    family, number = problem.split()
    known = {"size": int(number) ** 2, "seconds": seconds, "status": status, **known}
    return Record(family, int(number), backend, level, **known)


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Two good solvers, one that lies and one that crashes, on two problems."""
    folder = tmp_path_factory.mktemp("benchmark")
    return benchmark.run(SMALL, folder, backends=["active-set", "mangasarian", Liar(), Crash()])


def of(results, backend):
    return [found for found in results.records if found.backend == backend]


def test_answers_are_proven_in_processes_of_their_own(measured):
    assert [found.status for found in of(measured, "active-set")] == ["certified"] * 2
    bowl = of(measured, "active-set")[0]
    assert bowl.size == 49
    assert bowl.claimed
    assert bowl.error_upper < 1e-6
    assert bowl.seconds > 0
    assert bowl.peak_memory is None or bowl.peak_memory >= bowl.base_memory > 2**20


def test_a_solver_that_lies_is_counted_wrong(measured):
    lies = of(measured, "liars:Liar")
    assert [found.claimed_but_wrong for found in lies] == [True, True]
    assert all(found.error_lower > 0.1 for found in lies)
    assert not any(found.claimed_but_wrong for found in of(measured, "active-set"))
    lines = {line.backend: line for line in benchmark.summaries(measured.records, SMALL.time_limit)}
    assert (lines["liars:Liar"].claimed_but_wrong, lines["liars:Liar"].proven) == (2, 0)
    assert (lines["active-set"].claimed_but_wrong, lines["active-set"].proven) == (0, 2)


def test_a_crash_and_an_unsuitable_problem_are_lines_of_the_table(measured):
    assert [(found.status, found.message[:31]) for found in of(measured, "liars:Crash")] == [
        ("error", "its process ended with code 7: "),
    ] * 2
    assert [found.status for found in of(measured, "mangasarian")] == ["certified", "unsuitable"]


def test_memory_is_limited(tmp_path):
    pytest.importorskip("resource")
    results = benchmark.run(replace(SMALL, problems={"bowl": (7,)}, memory=2 * GIB), tmp_path, backends=[Glutton()])
    assert [found.status for found in results.records] == ["out of memory"]


def test_a_run_that_was_stopped_goes_on_where_it_was(measured, monkeypatch):
    from contactqp.benchmark import runner

    def nothing(*_, **__):
        pytest.fail("asked again")

    path = measured.folder / "records.jsonl"
    whole = path.read_text()
    monkeypatch.setattr(runner, "_in_process", nothing)
    again = benchmark.run(SMALL, measured.folder, backends=["active-set", "mangasarian", Liar(), Crash()])
    assert [found.key for found in again.records] == [found.key for found in measured.records]
    path.write_text(whole + '{"family": "bo')  # it was stopped while it wrote
    torn = Results.read(measured.folder)
    assert len(torn.records) == len(measured.records)
    torn.add(record("late", "bowl 9", 1.0))
    assert Results.read(measured.folder).records[-1].backend == "late"
    path.write_text(whole)


def test_results_of_other_limits_are_not_mixed(measured):
    with pytest.raises(ValueError, match=r"holds results of another time limit \(5.0, now 6.0\)"):
        benchmark.run(replace(SMALL, time_limit=6.0), measured.folder, backends=["psor"])


def test_names_that_are_not_known_are_refused(tmp_path):
    with pytest.raises(ValueError, match="unknown suite 'quik'; did you mean 'quick'"):
        benchmark.run("quik", tmp_path)
    with pytest.raises(ValueError, match=r"families has 'bowls'.*did you mean 'bowl'"):
        benchmark.run(SMALL, tmp_path, families=["bowls"])
    with pytest.raises(ValueError, match=r"levels must be one of 'low', .*, got 'mdi'; did you mean 'mid'"):
        benchmark.run(SMALL, tmp_path, levels=["mdi"])
    with pytest.raises(TypeError, match=r"backends must be a sequence of names, got 'psor' alone; write \['psor'\]"):
        benchmark.run(SMALL, tmp_path, backends="psor")
    with pytest.raises(cq.UnknownBackendError, match="'activeset'; did you mean 'active-set'"):
        benchmark.run(SMALL, tmp_path, backends=["activeset"])
    with pytest.raises(ValueError, match="holds no results"):
        Results.read(tmp_path)


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"problems": {"bowl": 0}}, ValueError, r"problems\['bowl'\] must be >= 1, got 0"),
        ({"problems": {"bowl": "31"}}, TypeError, r"problems\['bowl'\] must be an integer or a sequence of integers"),
        ({"problems": ["bowl"]}, TypeError, r"problems must be a mapping, as .*, got \['bowl'\]"),
        ({"levels": "mid"}, TypeError, r"levels must be a sequence of names, got 'mid' alone"),
        ({"time_limit": 0}, ValueError, "time_limit must be > 0"),
        ({"memory": 2.5}, TypeError, "memory must be an integer"),
        ({"repeats": 0}, ValueError, "repeats must be >= 1"),
    ],
)
def test_a_suite_is_checked_when_it_is_made(given, error, told):
    with pytest.raises(error, match=told):
        replace(SMALL, **given)


@pytest.mark.parametrize("name", benchmark.FAMILIES)
def test_every_family_is_solved_and_touches_its_support(name):
    number = {"hexagon": 3, "dense": 20, "beam": 40, "scattered": 300}.get(name, 15)
    solution = cq.solve(benchmark.FAMILIES[name].make(number), tol=1e-9)
    assert solution.status == "certified"
    assert solution.contact.sum() < solution.problem.size
    assert solution.contact.any() == (name != "biactive-half")  # whose lattice is lifted off by its differences


def test_the_suites_name_families_that_exist():
    for suite in benchmark.SUITES.values():
        assert set(suite.problems) <= set(benchmark.FAMILIES)


def test_the_shifted_geometric_mean_by_hand():
    """(0.9 + 0.1)(0.0 + 0.1) = 0.1, whose root less 0.1 is the mean."""
    assert benchmark.shifted_geometric_mean([0.9, 0.0]) == pytest.approx(math.sqrt(0.1) - 0.1)


def test_failures_count_with_the_time_limit():
    lines = benchmark.summaries([record("a", "bowl 7", 1.0, "inaccurate"), record("b", "bowl 7", 1.0)], 10.0)
    assert [(line.backend, round(line.mean_seconds, 9)) for line in lines] == [("b", 1.0), ("a", 10.0)]
    assert lines[1].relative_mean == pytest.approx(10.0)


def test_a_profile_by_hand():
    """a is fastest on one of two problems and twice as slow on the other; b proves one alone."""
    records = [record("a", "bowl 7", 1.0), record("a", "bowl 9", 2.0), record("b", "bowl 9", 1.0)]
    factors, parts = benchmark.profile([*records, record("b", "bowl 7", 1.0, "inaccurate")], "mid")
    np.testing.assert_array_equal(factors, [1.0, 2.0])
    np.testing.assert_array_equal(parts["a"], [0.5, 1.0])
    np.testing.assert_array_equal(parts["b"], [0.5, 0.5])


def test_growth_of_exact_powers_is_found():
    (growth,) = benchmark.growths([record("a", f"bowl {n}", 1e-3 * n**3) for n in (8, 16, 32)])
    assert growth.exponent == pytest.approx(1.5)  # seconds grow with n³, unknowns with n²
    assert benchmark.growths([record("a", f"bowl {n}", 1.0) for n in (8, 16)]) == []


def test_a_difference_tells_what_is_worse(tmp_path):
    first, second = (Results.begun(tmp_path / name, SMALL, {}, {}) for name in "ab")
    for results, seconds, status in ((first, 1.0, "certified"), (second, 2.0, "inaccurate")):
        results.add(record("a", "bowl 7", seconds))
        results.add(record("b", "bowl 7", 1.0, status))
    second.add(record("c", "bowl 7", 1.0))
    found = benchmark.difference(first, second)
    assert [str(change) for change in found.changes] == [
        "bowl 7, a, mid: 1 s, then 2 s (2.00 x)",
        "bowl 7, b, mid: was certified, is inaccurate",
        "bowl 7, c, mid: only in the second run",
    ]
    assert (found.worse, found.factor, found.common) == (2, 2.0, 2)
    told = CliRunner().invoke(app, ["bench", "diff", str(tmp_path / "a"), str(tmp_path / "b")])
    assert told.exit_code == 1
    assert "worse: bowl 7, b, mid: was certified, is inaccurate" in told.output
    same = CliRunner().invoke(app, ["bench", "diff", str(tmp_path / "a"), str(tmp_path / "a")])
    assert same.exit_code == 0


def test_the_report_is_a_page_of_its_own(measured):
    tags = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            tags.append((tag, dict(attrs)))

    page = benchmark.write_report(measured)
    text = page.read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    assert not any(tag in ("script", "link") and "data:" not in (given.get("href") or "") for tag, given in tags)
    assert all(given["alt"] and given["src"].startswith("data:") for tag, given in tags if tag == "img")
    assert "2 of 5 answers that were said to be solved" in text
    assert "<h2>Limitations</h2>" in text
    assert "not run yet" not in text
    assert "bench --suite small --out FOLDER" in text
    assert "its process ended with code 7" in text
    table = measured.to_frame()
    assert (measured.folder / "records.csv").read_text().count("\n") == len(table) + 1
    assert table.claimed_but_wrong.sum() == 2
    if (measured.folder / "records.parquet").exists():
        pandas.testing.assert_frame_equal(pandas.read_parquet(measured.folder / "records.parquet"), table)


def test_the_command_prints_a_table_that_fits(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    done = Results.begun(tmp_path / "done", benchmark.SUITES["quick"], {}, {})
    about = json.loads((done.folder / "about.json").read_text())
    told = CliRunner().invoke(
        app,
        ["bench", "--backends", "active-set", "--families", "cable", "--out", str(tmp_path / "new")],
    )
    assert about["suite"]["name"] == "quick"
    assert told.exit_code == 0, told.output
    assert "active-set  mid" in told.output
    assert "1 of 1" in told.output
    assert max(map(len, told.output.split("report:")[0].splitlines())) <= 80
    left = "not run yet: hexagon 3; bowl 31; between 31; beam 60; dense 60"
    assert left in told.output
    page = (tmp_path / "new" / "report.html").read_text(encoding="utf-8")
    assert left in page
    assert "bench --suite quick --families cable --out FOLDER" in page


def test_ctrl_c_tells_how_many_answers_are_kept(tmp_path, monkeypatch):
    from contactqp.benchmark import runner

    answered = iter([record("psor", "hexagon 3", 1.0)])

    def measured(*_):
        try:
            return next(answered)
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(runner, "_reference", lambda *_: [])
    monkeypatch.setattr(runner, "_measured", measured)
    told = CliRunner().invoke(app, ["bench", "--backends", "psor,mprgp", "--out", str(tmp_path)])
    assert told.exit_code == 130
    assert f"1 answer is kept in {tmp_path}; started again, the same command goes on" in " ".join(told.output.split())


def test_an_error_is_at_most_the_lesser_of_its_bounds():
    """The answer's own bound may be less than what the truth's width leaves of its distance from it."""
    assert record("a", "bowl 7", 1.0, relative_bound=1e-12, error_upper=3e-12).error_at_most == 1e-12
    assert record("a", "bowl 7", 1.0, relative_bound=2e-7, error_upper=1e-7).error_at_most == 1e-7
    assert record("a", "bowl 7", 1.0).error_at_most is None


def test_a_suite_tells_how_many_problems_it_has():
    assert str(replace(SMALL, problems={"cable": (9,)})).split(",")[0] == "small: 1 problem of 1 family"
