"""Benchmarks of parts: what is timed and in which order, by a clock that stands still, and files that describe them."""

import ast
import json
import re
from pathlib import Path

import numpy as np
import pandas
import pytest
from typer.testing import CliRunner

import contactqp as cq
from contactqp.benchmark import Phase, Spec, load_specs, run_specs, time_point
from contactqp.cli.commands import app

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "benchmarks").glob("*.py"))


class Clock:
    """Seconds that pass only where a phase says so."""

    def __init__(self):
        self.now, self.order = 0.0, []

    def __call__(self):
        return self.now

    def phase(self, name, *seconds, returns=None):
        """A phase that takes these seconds in turn, the last ones again and again."""
        left = list(seconds)

        def run(case):
            self.order.append(name)
            self.now += left.pop(0) if len(left) > 1 else left[0]
            return returns(case) if callable(returns) else returns

        return run


@pytest.fixture
def clock():
    return Clock()


def spec(clock, phases, **known):
    known = {"build": lambda point: point, "sweep": (1,), "point": "number", **known}
    return Spec(known.pop("name", "parts"), "parts", phases=phases, clock=clock, **known)


def printed(specs, **known):
    lines: list[str] = []
    return run_specs(specs, show=lines.append, **known), lines


def test_phases_run_in_turn_after_a_run_that_warms_up_and_the_least_counts(clock):
    parts = spec(clock, {"a": clock.phase("a", 9.0, 2.0, 4.0), "b": clock.phase("b", 9.0, 8.0, 6.0)}, repeat=2)
    first, second = time_point(parts, 1)
    assert clock.order == ["a", "b"] * 3
    assert (first.seconds, first.ratio, first.runs) == (2.0, 1.0, 2)
    assert (second.seconds, second.ratio) == (6.0, 3.0)


def test_what_takes_long_runs_once_and_need_not_warm_up(clock):
    parts = spec(clock, {"quick": clock.phase("quick", 1.0), "long": Phase(clock.phase("long", 5.0), once=True)})
    timings = time_point(parts, 1)
    assert clock.order == ["quick", "quick", "long", "quick", "quick"]
    assert [timing.runs for timing in timings] == [3, 1]


def test_ratios_are_over_the_fastest_of_those_that_are_named(clock):
    taken = {"a": 1.0, "b": 8.0, "c": 4.0}
    parts = spec(clock, {name: clock.phase(name, seconds) for name, seconds in taken.items()})
    assert [timing.ratio for timing in time_point(parts, 1)] == [1.0, 8.0, 4.0]
    parts = spec(clock, dict(parts.phases), beside=("b", "c"))
    assert [timing.ratio for timing in time_point(parts, 1)] == [0.25, 2.0, 1.0]


def test_what_is_missing_or_does_not_suit_is_told_in_words(clock):
    def unsuitable(case):
        raise cq.UnsuitableProblemError("it has no lattice")

    phases = {
        "a": Phase(clock.phase("a", 1.0), needs=("json", "no_such_module")),
        "b": unsuitable,
        "c": clock.phase("c", 1.0),
    }
    timings, lines = printed([spec(clock, phases)])
    assert [timing.words for timing in timings] == [
        "left out: no_such_module is not installed",
        "left out: it has no lattice",
        "",
    ]
    assert [timing.timed for timing in timings] == [False, False, True]
    assert np.isnan(timings[2].ratio)  # that of which it would be told is left out
    assert clock.order == ["c"] * 4
    assert any(line.endswith("left out: it has no lattice") for line in lines)


def test_numbers_are_limited_and_words_are_not(clock):
    built: list[object] = []
    phases = {"a": clock.phase("a", 1.0), "b": Phase(clock.phase("b", 1.0), largest=20)}
    parts = spec(clock, phases, build=built.append, sweep=("name", 10, 20, 30), repeat=lambda point: 1)
    told = [(timing.point, timing.phase) for timing in run_specs([parts], largest=25, show=lambda line: None)]
    assert told == [(point, name) for point in ("name", 10, 20) for name in "ab"]
    assert built == ["name", 10, 20]
    assert time_point(parts, 30, phases=["b"]) == []
    assert built == ["name", 10, 20]


def test_a_smoke_run_takes_the_small_point_once(clock):
    parts = spec(clock, {"a": clock.phase("a", 1.0)}, sweep=(100, 1000), smoke=5, repeat=7)
    (timing,) = run_specs([parts], smoke=True, show=lambda line: None)
    assert (timing.point, timing.runs) == (5, 1)
    assert clock.order == ["a"]
    assert spec(clock, {"a": clock.phase("a", 1.0)}, sweep=(100,)).smallest == 100


def test_facts_are_those_of_the_fastest_run_and_are_found_out_beside_the_clock(clock):
    counts = iter(range(9))

    def tell(case, result):
        clock.now += 1000.0
        return {"run": result, "case": case}

    run = clock.phase("a", 9.0, 3.0, 2.0, 4.0, returns=lambda case: next(counts))
    (timing,) = time_point(spec(clock, {"a": run}, tell=tell), 7)
    assert (timing.seconds, dict(timing.facts)) == (2.0, {"run": 2, "case": 7})


def test_an_answer_is_told_by_its_status(clock):
    parts = spec(clock, {"solve": lambda model: cq.solve(model, "active-set")}, build=cq.gallery.bowl, sweep=(7,))
    (timing,) = time_point(parts, 7, repeat=1, warm=False)
    assert timing.facts["status"] == "certified"
    assert float(timing.facts["bound"]) < 1e-6
    assert int(timing.facts["iterations"]) >= 1


def test_a_fact_must_not_hide_what_every_line_has(clock):
    parts = spec(clock, {"a": clock.phase("a", 1.0, returns={"seconds": 3.0})})
    with pytest.raises(ValueError, match="tells a fact 'seconds'; give it another name"):
        time_point(parts, 1)


def test_the_table_is_aligned_and_fits_eighty_columns(clock):
    """Seconds are n²/1e3, so that they grow with the power 2 of the number, and 1 of the n² unknowns."""

    def run(case):
        clock.now += case**2 / 1e3
        return {"status": "certified", "iterations": case, "bound": 1e-9 * case, "off": 1.0 / case}

    known = {"sweep": (10, 20, 40), "largest_facts": ("off",), "repeat": 1}
    plain = spec(clock, {"phase": run}, name="plain", **known)
    sized = spec(clock, {"a name that leaves no room": run, "b": run}, name="sized", size=lambda n: n**2, **known)
    _, lines = printed([plain, sized])
    assert max(map(len, lines)) <= 80
    assert lines[:5] == [
        "",
        "plain: parts (point: number)",
        "    point phase   seconds   ratio",
        "       10 phase     0.100       1",
        "         certified, iterations 10, bound 1e-08, off 0.1",
    ]
    assert "  phase: seconds grow as the number to the 2.00" in lines
    assert "  phase: off: median 0.05, largest 0.1 (3 lines)" in lines
    start = lines.index("sized: parts (point: number)")
    assert lines[start + 1 : start + 5] == [
        "    point      size phase                        seconds   ratio  µs each",
        "       10       100 a name that leaves no room     0.100       1    1e+03",
        "         certified, iterations 10, bound 1e-08, off 0.1",
        "                    b                              0.100       1    1e+03",
    ]
    assert "  b: seconds grow as the size to the 1.00" in lines
    assert "  all: off: median 0.05, largest 0.1 (6 lines)" in lines


def test_a_folder_gets_lines_versions_and_a_picture(clock, tmp_path):
    one = spec(clock, {"a": clock.phase("a", 1.0, returns={"cycles": 5})}, name="one", sweep=(1, 2), drawn=True)
    two = spec(clock, {"b": Phase(clock.phase("b", 1.0), needs=("no_such_module",))}, name="two", drawn=True)
    run_specs([one, two], out=tmp_path / "new", show=lambda line: None)
    table = pandas.read_csv(tmp_path / "new" / "timings.csv")
    assert table.spec.tolist() == ["one", "one", "two"]
    assert table.cycles.tolist()[:2] == [5, 5]
    assert table.seconds.isna().tolist() == [False, False, True]
    about = json.loads((tmp_path / "new" / "about.json").read_text())
    assert about["specs"] == ["one", "two"]
    assert about["versions"]["contactqp"] == cq.__version__
    assert about["machine"]["processors"]
    assert (tmp_path / "new" / "one.png").exists()
    assert not (tmp_path / "new" / "two.png").exists()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"name": "Two words"}, "joined by dashes, got 'Two words'"),
        ({"sweep": ()}, "sweep of 'parts' must not be empty"),
        ({"beside": ("b",)}, "beside of 'parts' has 'b'; its phases are a"),
    ],
)
def test_malformed_specs_are_refused(clock, wrong, said):
    with pytest.raises(ValueError, match=said):
        spec(clock, {"a": clock.phase("a", 1.0)}, **wrong)


def test_names_that_are_not_known_are_refused(clock):
    parts = spec(clock, {"solve": clock.phase("solve", 1.0)})
    with pytest.raises(ValueError, match="unknown benchmark 'part'; did you mean 'parts'"):
        run_specs([parts], names=["part"])
    with pytest.raises(ValueError, match="unknown phase 'solv'; did you mean 'solve'"):
        run_specs([parts], phases=["solv"])
    with pytest.raises(ValueError, match="repeat must be"):
        run_specs([parts], repeat=0)
    with pytest.raises(ValueError, match="two specs are called 'parts'"):
        run_specs([parts, parts])
    assert clock.order == []


def test_files_without_specs_are_refused(tmp_path):
    with pytest.raises(ValueError, match="there is no file"):
        load_specs(tmp_path / "none.py")
    (tmp_path / "empty.py").write_text("SPECS = ('word',)\n")
    with pytest.raises(ValueError, match="must define SPECS"):
        load_specs(tmp_path / "empty.py")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_file_of_the_folder_describes_benchmarks(path):
    for each in load_specs(path):
        assert all(re.fullmatch(r"\S(.{0,50}\S)?", name) for name in each.phases)
        assert each.smallest in each.sweep or each.smoke is not None
        assert len(each.summary) < 120
        assert all(callable(each.phase(name).run) for name in each.phases)
    names = {node.id for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Name)}
    assert not names & {"print", "__name__", "argparse"}


def commands():
    """What pages tell to run."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "changelog.d").glob("*.md"), *FILES]
    for page in pages:
        for told in re.findall(r"contactqp bench run ([^#`\n]+)", page.read_text(encoding="utf-8")):
            if "benchmarks/" in told and "NAME" not in told:
                yield told.strip()


@pytest.mark.parametrize("told", sorted(set(commands())))
def test_what_is_told_to_run_is_there(told):
    words = re.sub(r'--\w+ ("[^"]*"|\S+)', "", told).split()
    files = [word for word in words if word.endswith(".py")]
    known = {each.name for file in files for each in load_specs(ROOT / file)}
    assert known
    assert set(words) - set(files) <= known


def test_the_command_measures_what_a_file_describes(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    file = tmp_path / "parts.py"
    file.write_text(
        "from contactqp.benchmark import Spec\n"
        "SPECS = (\n"
        "    Spec('sum', 'a sum', range, (10, 20), {'sum': lambda case: {'sum': sum(case)}, 'max': max}),\n"
        "    Spec('other', 'another', range, (10,), {'sum': sum}),\n"
        ")\n"
    )
    call = ["bench", "run", str(file), "sum", "--points", "4,5", "--phases", "sum", "--repeat", "1"]
    told = CliRunner().invoke(app, [*call, "--out", str(tmp_path / "out")])
    assert told.exit_code == 0, told.output
    assert "sum: a sum (point: nodes along a side)" in told.output
    assert "other" not in told.output
    assert pandas.read_csv(tmp_path / "out" / "timings.csv")["sum"].tolist() == [6, 10]
    smoke = CliRunner().invoke(app, ["bench", "run", str(file), "--smoke"])
    assert smoke.exit_code == 0
    assert "other: another" in smoke.output
    assert "these times mean nothing" in smoke.output
    wrong = CliRunner().invoke(app, ["bench", "run", "sum"])
    assert wrong.exit_code == 2
    assert "name a Python file that defines SPECS" in wrong.output
