"""The folders are the layers that the contract says, and no modules import each other in a circle."""

import re
import tomllib
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CONTRACT = PROJECT["tool"]["importlinter"]["contracts"][0]


@pytest.fixture(scope="module")
def graph():
    return grimp.build_graph("contactqp", cache_dir=None)


def floors():
    """Return the names on each floor, by the contract, top first."""
    return [{name.strip() for name in re.split(r"[|:]", layer)} for layer in CONTRACT["layers"]]


def test_the_table_in_contributing_is_the_contract():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.split("| folder |")[1].split("\n\n")[0].splitlines()[2:]
    assert [set(re.findall(r"`(\w+)`", row.split("|")[1])) for row in table] == floors()


def test_every_folder_and_module_has_a_floor(graph):
    top = {module.split(".")[1] for module in graph.modules if module.count(".") >= 1}
    assert top == set().union(*floors())
    assert CONTRACT["exhaustive"] is True


def test_the_tests_stand_in_folders_of_the_same_names():
    folders = {path.parent.name for path in (ROOT / "tests").glob("*/test_*.py")}
    assert folders - {"house"} <= set().union(*floors())


def test_no_modules_import_each_other_in_a_circle(graph):
    """Imports for type checkers and those within functions included; a package's face does not count."""
    modules = {module for module in graph.modules if graph.find_modules_directly_imported_by(module)}
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    circles = []

    def visit(module: str) -> None:
        order[module] = lowest[module] = len(order)
        stack.append(module)
        for other in graph.find_modules_directly_imported_by(module):
            if other not in order:
                visit(other)
                lowest[module] = min(lowest[module], lowest[other])
            elif other in stack:
                lowest[module] = min(lowest[module], order[other])
        if lowest[module] == order[module]:
            circle = stack[stack.index(module) :]
            del stack[stack.index(module) :]
            if len(circle) > 1:
                circles.append(sorted(circle))

    for module in sorted(modules):
        if module not in order:
            visit(module)
    assert circles == []


def test_nothing_below_imports_the_paper(graph):
    importers = {module.split(".")[1] for module in graph.find_modules_that_directly_import("contactqp.paper.facts")}
    assert importers <= {"paper", "cli"}
