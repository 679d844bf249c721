"""What CONTRIBUTING tells somebody to write works as it stands, and what it names is there."""

import importlib
import re
from pathlib import Path

import pytest
from pages import run

from contactqp.backends.base import Stop, Task
from contactqp.io.data_files import READERS
from contactqp.io.writers import WRITERS
from contactqp.models.base import ContactModel
from contactqp.plotting.views import answer_figure
from contactqp.problem.contact_qp import ContactQP
from contactqp.solving.solution import Solution

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "src" / "contactqp"
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
PROSE = re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL)
QUOTED = {" ".join(words.split()) for words in re.findall(r"`([^`]+)`", PROSE)}
MODULES = {path.stem for path in PACKAGE.rglob("*.py")} | {path.name for path in PACKAGE.iterdir() if path.is_dir()}

TO_BE_CHOSEN = {"NAME"}
"""Names that stand for those of what somebody adds."""

ARGUMENTS = {
    "problem": ContactQP,
    "task": Task,
    "solution": Solution,
    "model": ContactModel,
    "Solution": Solution,
    "Stop": Stop,
}
"""What the arguments and classes are that stand before a dot."""


def test_what_is_to_be_written_works(monkeypatch):
    for table in (WRITERS, READERS):
        monkeypatch.setitem(table, ".txt", None)
    assert run(PAGE, {"__name__": "contributing"}) == PAGE.count("```python") == 6
    assert any(kind.__name__ == "StringOnSprings" for kind in answer_figure.registry)


def exists(path):
    places = [root / (path + ending) for root in (ROOT, ROOT / "src", PACKAGE) for ending in ("", ".py")]
    return any(place.exists() for place in places)


def test_every_file_that_is_named_exists():
    named = {words for words in QUOTED if re.fullmatch(r"[\w.]+(/[\w.]+)+/?|[\w./]+(/|\.(py|md|toml))", words)}
    named = {path for path in named if not TO_BE_CHOSEN & set(re.split(r"[/.]", path))}
    assert len(named) > 10
    assert {path for path in named if not exists(path)} == set()


def found(name):
    """Whether there is a module of that name in the package, or in a module or an argument what stands behind dots."""
    first, *attributes = name.split(".")
    if first in ARGUMENTS:
        return len(attributes) == 1 and attributes[0] in {*dir(ARGUMENTS[first]), *ARGUMENTS[first].__annotations__}
    parts = name.removeprefix("contactqp.").split(".")
    for count in range(len(parts), 0, -1):
        try:
            thing = importlib.import_module(".".join(["contactqp", *parts[:count]]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[count:]:
            if not hasattr(thing, attribute):
                return False
            thing = getattr(thing, attribute)
        return True
    return False


def test_every_name_with_dots_exists():
    names = {words.split("(")[0] for words in QUOTED if re.fullmatch(r"\w+(\.\w+)+(\(\w*\))?", words)}
    names = {name for name in names if name.split(".")[0] in MODULES | {"contactqp"} | set(ARGUMENTS)}
    names = {name for name in names if not name.endswith((".py", ".toml", ".md"))}
    assert len(names) >= 10
    assert {name for name in names if not found(name)} == set()


def test_every_plain_name_stands_in_the_source():
    paths = sorted((ROOT / "src").rglob("*.py"))
    words = {path.stem for path in paths}.union(*(re.findall(r"\w+", path.read_text("utf-8")) for path in paths))
    names = {quoted for quoted in QUOTED if re.fullmatch(r"[A-Za-z_]\w*", quoted)} - TO_BE_CHOSEN
    assert len(names) > 25
    assert names - words - MODULES == set()


@pytest.mark.parametrize("wrong", ["foundation.nowhere", "task.nothing", "contactqp.proof.enclosure.nothing"])
def test_the_search_tells_what_is_missing(wrong):
    assert not found(wrong)
