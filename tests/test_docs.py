"""The pages in docs/ say what is so: their code is run, and its outputs are compared."""

import ast
import re
from pathlib import Path

import pytest
from pages import run
from searches import SEARCHES
from strategies import BACKENDS
from test_readme import ROOT

import contactqp as cq
from contactqp import benchmark
from contactqp.backends import BY_NAME, get_backend
from contactqp.backends.solvers import SOLVERS

DOCS = Path(ROOT) / "docs"
BACKENDS_PAGE = (DOCS / "backends.md").read_text(encoding="utf-8")
CI_PAGE = (DOCS / "howto" / "ci.md").read_text(encoding="utf-8")
PAGE = (Path(ROOT) / "docs" / "a-backend.md").read_text(encoding="utf-8")


def test_the_backend_that_the_page_builds_passes_the_kit():
    first = PAGE.index("```python\nimport contactqp")
    building = re.search(r"```python\n(.*?)```", PAGE[:first], flags=re.DOTALL)
    assert building is not None
    namespace = {"__name__": "a_backend"}
    exec(building[1], namespace)
    assert run(PAGE[first:], namespace) == PAGE[first:].count("```python") == 3


def test_it_takes_forty_lines():
    code = re.search(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    assert code is not None
    written = code[1].split("class LeastSquares", 1)[1]
    written = re.sub(r'"""(.|\n)*?"""', "", written)
    assert len([line for line in written.splitlines() if line.strip()]) <= 40


def documented(page):
    """The names that a page of the reference describes."""
    text = (DOCS / "api" / f"{page}.rst").read_text(encoding="utf-8")
    return set(re.findall(r"^   (\w+)$", text, flags=re.MULTILINE)) | set(re.findall(r"autodata:: [\w.]+\.(\w+)", text))


def public_names(module):
    """What a module says is public, read from its source: its libraries need not be installed."""
    folder = Path(ROOT) / "src" / "contactqp"
    source = next(path for path in (folder / f"{module}.py", folder / module / "__init__.py") if path.exists())
    for statement in ast.parse(source.read_text(encoding="utf-8")).body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "__all__":
            return set(ast.literal_eval(statement.value))
    raise AssertionError(f"{module} does not say what is public")


def test_the_reference_has_every_public_name_once():
    pages = [page.stem for page in (DOCS / "api").glob("*.rst")]
    assert {"index", *MODULES} <= set(pages)
    own = [name for page in pages if page not in {*MODULES, "xarray", "index", "backends"} for name in documented(page)]
    assert sorted(own) == sorted(set(cq.__all__) - set(MODULES))


MODULES = ["benchmark", "gallery", "mpi", "profiles", "testing", "jax", "torch", "paper"]


@pytest.mark.parametrize("module", MODULES)
def test_the_reference_has_every_public_name_of_a_module(module):
    assert documented(module) == public_names(module)


def test_every_page_of_the_reference_is_in_its_index():
    listed = documented("index")
    assert listed == {page.stem for page in (DOCS / "api").glob("*.rst")} - {"index"}


PAGES = sorted(
    page.relative_to(DOCS)
    for folder in (".", "start", "howto", "theory", "coming-from")
    for page in (DOCS / folder).glob("*.md")
    if "```python" in page.read_text(encoding="utf-8") and page.stem not in {"a-backend", "ci"}
)
"""Pages whose code runs from its first line to its last; the others have tests of their own."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.with_suffix("").as_posix())
def test_a_page_prints_what_it_says(page, tmp_path, monkeypatch):
    (tmp_path / "examples").symlink_to(Path(ROOT) / "examples")
    monkeypatch.chdir(tmp_path)  # a file that a page writes is not found by its next run
    text = (DOCS / page).read_text(encoding="utf-8")
    assert run(text, {"__name__": page.stem}) == text.count("```python")


def test_there_are_recipes_enough_and_each_is_in_their_index():
    recipes = {page.stem for page in (DOCS / "howto").glob("*.md")} - {"index"}
    index = (DOCS / "howto" / "index.md").read_text(encoding="utf-8")
    assert len(recipes) >= 30
    assert sorted(re.findall(r"^([\w-]+)$", index, flags=re.MULTILINE)) == sorted(recipes)


def test_every_page_that_is_linked_is_there():
    for page in sorted(DOCS.rglob("*.md")):
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text(encoding="utf-8")):
            assert target.startswith(("../pictures", "../notebooks/")) or (page.parent / target).exists(), (
                page,
                target,
            )


def test_the_tests_that_it_shows_run_once_with_each_backend_and_fail_as_it_says(pytester, monkeypatch):
    [(code, expected)] = re.findall(r"```python\n(# test_.*?)```\n\n[^`]*```text\n(.*?)```", CI_PAGE, flags=re.DOTALL)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTEST_PLUGINS", "pytest_contactqp")
    pytester.makepyfile(test_my_program=code)
    result = pytester.runpytest_subprocess("-W", "error")
    result.assert_outcomes(passed=len(BACKENDS) + 1, failed=1)
    result.stdout.fnmatch_lines(["*FAILURES*", "*_ test_my_program _*"])
    assert expected in result.stdout.str() + "\n"


def test_every_backend_is_in_the_table_with_its_reachable_tolerance():
    for name in (*BACKENDS, *BY_NAME):
        row = next(line for line in BACKENDS_PAGE.splitlines() if line.startswith(f"| `{name}` |"))
        exponent = f"{get_backend(name).reachable_tol:.0e}".replace("e-0", "e-")
        assert f"| {exponent} |" in row


def test_every_solver_that_others_call_is_in_its_table():
    for name, facts in SOLVERS.items():
        row = next(line for line in BACKENDS_PAGE.splitlines() if line.startswith(f"| `{name}` | {facts.method} |"))
        reached = " / ".join(told(facts, package) for package in ("qpsolvers", "cvxpy"))
        matrix = f"{'dense' if facts.dense else 'sparse'}{', definite' if facts.definite else ''}"
        largest = " / ".join(f"{through.practical_size:,}" for through in facts.through.values())
        assert row == f"| `{name}` | {facts.method} | {matrix} | {facts.licence} | {reached} | {largest} |"


def test_the_table_of_the_standard_suite_is_that_of_its_records():
    results = benchmark.Results.read(Path(ROOT) / "benchmarks" / "results" / "standard")
    rows = {
        f"| `{one.backend}` | {one.level} | {one.proven} of {one.asked} | {one.claimed_but_wrong} of {one.claimed} "
        f"| {one.mean_seconds:.3g} | {one.relative_mean:.2g} |"
        for one in benchmark.summaries(results.records, results.suite.time_limit)
    }
    page = (DOCS / "benchmarks.md").read_text(encoding="utf-8")
    assert rows == {line for line in page.splitlines() if re.match(r"\| `\S+` \| (mid|default) \|", line)}


def told(facts, package):
    through = facts.through.get(package)
    return (
        "–" if through is None or through.reachable_tol is None else f"{through.reachable_tol:.0e}".replace("e-0", "e-")
    )


def test_every_recipe_is_searched_for_in_the_words_of_newcomers():
    recipes = {page.stem: page.read_text(encoding="utf-8") for page in (DOCS / "howto").glob("*.md")}
    del recipes["index"]
    assert set(SEARCHES) == set(recipes)
    for recipe, text in recipes.items():
        title = re.findall(r"\w+", re.search(r"^# (.*)", text, flags=re.MULTILINE)[1].lower())
        assert any(not set(re.findall(r"\w+", words.lower())) <= set(title) for words in SEARCHES[recipe]), recipe
