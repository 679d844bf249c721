"""The README's code is run, its outputs compared, and its facts checked."""

import re
from pathlib import Path

from pages import run
from strategies import BACKENDS

import contactqp as cq
from contactqp.backends import get_backend
from contactqp.backends.solvers import SOLVERS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_code_runs_and_prints_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert run(README, {}) == README.count("```python") - 1 == 17  # the other one is run by the next test


def test_the_tests_that_it_shows_run_once_with_each_backend_and_fail_as_it_says(pytester, monkeypatch):
    [(code, expected)] = re.findall(r"```python\n(# test_.*?)```\n\n[^`]*```text\n(.*?)```", README, flags=re.DOTALL)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTEST_PLUGINS", "pytest_contactqp")
    pytester.makepyfile(test_my_program=code)
    result = pytester.runpytest_subprocess("-W", "error")
    result.assert_outcomes(passed=len(BACKENDS) + 1, failed=1)
    result.stdout.fnmatch_lines(["*FAILURES*", "*_ test_my_program _*"])
    assert expected in result.stdout.str() + "\n"


def test_every_backend_is_in_the_table_with_its_reachable_tolerance():
    for name in BACKENDS:
        row = next(line for line in README.splitlines() if line.startswith(f"| `{name}` |"))
        exponent = f"{get_backend(name).reachable_tol:.0e}".replace("e-0", "e-")
        assert f"| {exponent} |" in row


def test_every_file_that_is_mentioned_exists():
    mentioned = set(re.findall(r"(?:docs|examples|notebooks|benchmarks)/[\w/.]+\w", README))
    mentioned |= set(re.findall(r"\b[A-Z]+\.(?:md|cff)\b", README))
    assert len(mentioned) > 5
    for file in mentioned:
        assert (ROOT / file).exists(), file


def test_the_version_is_one():
    assert f"version: {cq.__version__}" in (ROOT / "CITATION.cff").read_text()
    assert f"## {cq.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_every_solver_that_others_call_is_in_its_table():
    for name, facts in SOLVERS.items():
        row = next(line for line in README.splitlines() if line.startswith(f"| `{name}` | {facts.method} |"))
        reached = " / ".join(told(facts, package) for package in ("qpsolvers", "cvxpy"))
        matrix = f"{'dense' if facts.dense else 'sparse'}{', definite' if facts.definite else ''}"
        largest = " / ".join(f"{through.practical_size:,}" for through in facts.through.values())
        assert row == f"| `{name}` | {facts.method} | {matrix} | {facts.licence} | {reached} | {largest} |"


def told(facts, package):
    through = facts.through.get(package)
    return (
        "–" if through is None or through.reachable_tol is None else f"{through.reachable_tol:.0e}".replace("e-0", "e-")
    )
