"""What CONTRIBUTING tells somebody to write works as it stands, and what it names is there."""

import re
from pathlib import Path

from pages import run

from contactqp.io.data_files import READERS
from contactqp.io.writers import WRITERS
from contactqp.plotting.views import answer_figure

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_what_is_to_be_written_works(monkeypatch):
    for table in (WRITERS, READERS):
        monkeypatch.setitem(table, ".txt", None)
    assert run(PAGE, {"__name__": "contributing"}) == PAGE.count("```python") == 5
    assert any(kind.__name__ == "StringOnSprings" for kind in answer_figure.registry)


def test_every_file_that_is_named_exists():
    prose = re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL)
    named = {name for name in re.findall(r"`([\w./]+(?:/|\.py|\.md|\.toml))`", prose) if "NAME" not in name}
    assert len(named) > 8
    for name in named:
        assert any((folder / name).exists() for folder in (ROOT, ROOT / "src" / "contactqp")), name
