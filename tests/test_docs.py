"""The pages in docs/ say what is so: their code is run, and its outputs are compared."""

import re
from pathlib import Path

from pages import run
from test_readme import ROOT

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
