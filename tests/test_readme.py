"""The README's code is run, its outputs compared, and its facts checked."""

import re
from pathlib import Path

from pages import run
from strategies import BACKENDS

import contactqp as cq

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_code_runs_and_prints_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert run(README, {}) == README.count("```python") == 1


def test_every_backend_is_in_the_table():
    assert re.findall(r"^\| `([\w-]+)` \|", README, flags=re.MULTILINE) == list(BACKENDS)


def test_it_counts_the_recipes():
    recipes = {page.stem for page in (ROOT / "docs" / "howto").glob("*.md")} - {"index"}
    assert f"{len(recipes)} recipes" in README


def test_every_file_that_is_mentioned_exists():
    mentioned = set(re.findall(r"(?:docs|examples|notebooks|benchmarks)/[\w/.-]+\w", README))
    mentioned |= set(re.findall(r"\b[A-Z]+\.(?:md|cff)\b", README))
    assert len(mentioned) > 5
    for file in mentioned:
        assert (ROOT / file).exists(), file


def test_the_version_is_one():
    assert f"version: {cq.__version__}" in (ROOT / "CITATION.cff").read_text()
    assert f"## {cq.__version__}" in (ROOT / "CHANGELOG.md").read_text()
