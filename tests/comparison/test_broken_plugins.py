"""Backends of other distributions that cannot be imported, announced by real entry points: rows, never the end."""

import pytest
from typer.testing import CliRunner

import contactqp as cq
from contactqp import backends
from contactqp.cli.commands import app

MODULES = {
    "broken": "raise RuntimeError('built for another library')",
    "leaving": "raise SystemExit('no licence')",
    "greedy": """
from contactqp.backends.base import Backend

class Made(Backend):
    name, summary, package = "greedy", "takes anything", "numpy"

    def solve(self, problem, task, **options):
        raise AssertionError
""",
    "stranger": "Made = dict",
}


@pytest.fixture
def plugins(tmp_path, monkeypatch):
    """A distribution whose modules fail to import in every way, and an entry point without a module."""
    for name, text in MODULES.items():
        (tmp_path / f"{name}_backend.py").write_text(text)
    record = tmp_path / "plugins-1.0.dist-info"
    record.mkdir()
    (record / "METADATA").write_text("Metadata-Version: 2.1\nName: plugins\nVersion: 1.0\n")
    names = [*MODULES, "absent"]
    lines = [f"{name} = {name}_backend:Made" for name in names]
    (record / "entry_points.txt").write_text("\n".join(["[contactqp.backends]", *lines]))
    monkeypatch.syspath_prepend(tmp_path)
    backends._outsiders.cache_clear()
    yield names
    backends._outsiders.cache_clear()


REASONS = {
    "broken": "RuntimeError: built for another library",
    "leaving": "no licence",
    "greedy": "must name its options as keywords",
    "stranger": "is no subclass of contactqp.backends.base.Backend",
    "absent": "No module named 'absent_backend'",
}


def test_a_backend_that_cannot_be_imported_is_a_row_with_the_reason(plugins):
    assert cq.backend_names()[-len(plugins) :] == plugins
    options = {"broken": {"whatever": 1}, "psor": {"relaxation": 1.5}}
    comparison = cq.compare(cq.gallery.islands(), [*plugins, "psor"], options=options, repeats=1)
    assert [row.backend for row in comparison.rows] == [*plugins, "psor"]
    for row in comparison.rows[:-1]:
        assert row.status in ("missing", "error")
        assert REASONS[row.backend] in row.message
        assert row.iterations is row.claimed is row.relative_bound is None
    assert comparison.rows[-1].ok
    assert comparison.best is comparison.solutions["psor"]
    assert list(comparison.culprits) == plugins
    assert list(comparison.provenance.options) == ["psor"]


def test_where_no_backend_can_be_imported_there_is_a_comparison_too(plugins, tmp_path):
    model = cq.gallery.islands()
    comparison = cq.compare(model, ["broken"])
    assert comparison.best is None
    assert comparison.model is model
    assert comparison.verdict().startswith("No agreement: broken (missing: backend 'broken' ")
    page = comparison.report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert "built for another library" in page


def test_an_interrupt_is_not_taken_for_a_broken_backend(plugins, tmp_path):
    (tmp_path / "absent_backend.py").write_text("raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        cq.compare(cq.gallery.islands(), ["absent"])


def test_the_list_of_backends_names_those_that_cannot_be_imported(plugins):
    result = CliRunner().invoke(app, ["backends"])
    assert result.exit_code == 0
    shown = " ".join(result.output.split())
    for name in plugins:
        assert f"{name} - - - no, see below" in shown
        assert REASONS[name] in shown


WORKING = """
from contactqp.backends.active_set import ActiveSetBackend

class Made(ActiveSetBackend):
    name = "absent"
"""


def test_the_default_list_takes_plugins_that_work_and_tells_of_those_that_do_not(plugins, tmp_path):
    (tmp_path / "absent_backend.py").write_text(WORKING)
    comparison = cq.compare(cq.gallery.islands())
    assert comparison.rows[-1].backend == "absent"
    assert comparison.agree
    broken = [name for name in plugins if name != "absent"]
    assert list(comparison.left_out) == broken
    for name in broken:
        assert f"Left out: {name} cannot be called: " in repr(comparison)
        assert REASONS[name] in comparison.left_out[name]
    installed = backends.installed_backends()
    assert installed == [row.backend for row in comparison.rows]


def test_each_backend_is_loaded_once_to_find_out_who_is_usual(plugins, monkeypatch):
    loaded = []
    load = backends.get_backend
    monkeypatch.setattr(backends, "get_backend", lambda name: loaded.append(name) or load(name))
    backends.usual_backends(cq.gallery.islands().problem)
    assert sorted(loaded) == sorted(cq.backend_names())
