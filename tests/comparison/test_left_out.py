"""The default list does without what is hopeless at a problem's size, and says so."""

import json

import numpy as np
import pytest

import contactqp as cq
from contactqp import backends
from contactqp.backends.clarabel import Clarabel
from contactqp.backends.mangasarian import Mangasarian
from contactqp.comparison.compare import compare


@pytest.fixture
def impractical(monkeypatch):
    monkeypatch.setattr(Mangasarian, "practical_size", 10)
    monkeypatch.setattr(Clarabel, "practical_size", 20)


def test_what_is_left_out_is_told(impractical, tmp_path):
    comparison = compare(cq.gallery.bowl(5))
    assert comparison.left_out == {
        "clarabel": "is practical up to 20 unknowns",
        "mangasarian": "is practical up to 10 unknowns",
    }
    assert [row.backend for row in comparison.rows] == ["osqp", "psor", "multigrid", "active-set", "mprgp"]
    assert comparison.agree
    assert "Left out: mangasarian is practical up to 10 unknowns." in repr(comparison)
    assert json.loads(comparison.to_json())["left_out"] == comparison.left_out
    assert "Left out: clarabel" in comparison.report(tmp_path / "page.html").read_text(encoding="utf-8")


def test_who_is_left_out_for_the_same_reason_stands_in_one_line(monkeypatch):
    for method in (Mangasarian, Clarabel):
        monkeypatch.setattr(method, "practical_size", 10)
    comparison = compare(cq.gallery.bowl(5))
    assert "Left out: clarabel, mangasarian: is practical up to 10 unknowns." in repr(comparison)


def test_who_is_asked_by_name_is_never_left_out(impractical):
    comparison = compare(cq.gallery.bowl(5), ["clarabel", "psor"])
    assert comparison.left_out == {}
    assert [row.backend for row in comparison.rows] == ["clarabel", "psor"]


def test_where_nothing_is_practical_all_are_asked(monkeypatch):
    for name in cq.backend_names():
        monkeypatch.setattr(type(backends.get_backend(name)), "practical_size", 1)
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    names, left_out = backends.usual_backends(problem)
    assert names == backends.suitable_backends(problem)
    assert left_out == {}


def test_half_a_million_nodes_are_left_to_what_is_fast():
    names, left_out = backends.usual_backends(cq.gallery.bowl(707).problem)
    assert names == ["psor", "multigrid", "active-set"]
    assert list(left_out) == ["osqp", "clarabel", "mangasarian", "mprgp"]


def test_answers_and_what_belongs_to_them_can_be_compared_by_equality():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    first, second = (cq.solve(problem, "mangasarian", cost=np.array([1.0, 2.0])) for _ in range(2))
    for one, other in ((first, second), (first.request, second.request), (first.verdict, second.verdict)):
        assert one == one
        assert (one == other) in (True, False)
    comparisons = [compare(problem, ["psor", "clarabel"]) for _ in range(2)]
    assert (comparisons[0].truth == comparisons[1].truth) is False
    assert (comparisons[0].pairs[0] == comparisons[1].pairs[0]) is False
