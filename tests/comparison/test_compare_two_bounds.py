"""With an upper bound a contact is a node and the bound that holds it; without one nothing is said of it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from ceilings import models_under_ceilings
from strategies import altered

import contactqp as cq
from contactqp.comparison.comparison import Comparison
from contactqp.comparison.metrics import boundary_distance, contact_jaccard
from contactqp.comparison.outcome import Outcome
from contactqp.proof.judge import judge
from contactqp.testing import assert_backends_agree, assert_complementary, assert_same_contact

MEMBRANE, CABLE, NET = models_under_ceilings()
PRESSED = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-3.0, 0.0], lower=0.0, upper=1.0)
"""The solution is (1, 0.5): the upper bound holds the first node, none the second."""


def answer(posed, gap):
    """Return a vector as a solution, judged as a backend's answer would be."""
    gap = np.asarray(gap, dtype=float)
    solved = cq.solve(posed, "osqp")
    return replace(solved, run=replace(solved.run, gap=gap), verdict=judge(solved.problem, gap, 1e-6))


def side_by_side(posed, **answers):
    outcomes = [Outcome(name, answer) for name, answer in answers.items()]
    return Comparison(posed, outcomes, next(iter(answers.values())).request.tolerance)


@pytest.fixture(scope="module")
def agreeing():
    return cq.compare(MEMBRANE)


def test_every_backend_that_suits_finds_both_contact_sets(agreeing):
    certificate = agreeing.best.certificate
    lower, upper = int(certificate.contact_lower.sum()), int(certificate.contact_upper.sum())
    assert min(lower, upper) >= 2
    assert agreeing.agree
    assert list(agreeing.solutions) == ["osqp", "clarabel", "psor", "multigrid", "active-set", "mprgp"]
    refused = cq.compare(MEMBRANE, ["mangasarian", "clarabel"])
    assert refused.rows[0].status == "unsuitable"
    assert "needs a problem without an upper bound" in refused.culprits["mangasarian"]
    frame = agreeing.to_frame()
    assert (frame["contact"] == lower + upper).all()
    assert (frame["contact_upper"] == upper).all()
    assert (frame["contact_jaccard"] == 0).all()
    assert (frame["boundary_distance"] == 0).all()
    assert agreeing.decided == {
        "contact": lower + upper, "contact_upper": upper, "clear": MEMBRANE.size - lower - upper, "undecided": 0,
    }  # fmt: skip
    record = json.loads(agreeing.to_json())
    assert {row["contact_upper"] for row in record["backends"]} == {upper}
    assert record["truth"]["contact_upper"] == upper


@pytest.mark.parametrize("model", [MEMBRANE, CABLE, NET], ids=lambda model: type(model).__name__)
def test_table_and_page_tell_how_many_nodes_are_at_the_upper_bound(model, tmp_path):
    comparison = cq.compare(model, ["osqp", "clarabel"])
    upper = int(comparison.best.contact_upper.sum())
    header, *body = [line.split() for line in repr(comparison).splitlines()[3:6]]
    assert header[-4:] == ["contact", "at", "upper", "undecided"]
    assert [line[-2] for line in body] == [str(upper)] * 2
    page = comparison.report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.count(f"in contact ({upper} of them at the upper bound)") == 2  # of the truth, and of the picture
    assert ">at the upper bound</th>" in page
    assert "<dt>at the upper bound</dt>" in page
    assert "max |max(ω − u, min(ω − l, R/Gᵢᵢ))|" in page


def test_without_an_upper_bound_nothing_is_said_of_it(tmp_path):
    comparison = cq.compare(cq.gallery.islands(), ["psor", "clarabel"])
    page = comparison.report(tmp_path / "page.html").read_text(encoding="utf-8")
    for shown in (repr(comparison), comparison.to_json(), page, " ".join(comparison.to_frame().columns)):
        assert "upper bound" not in shown.replace("Proven upper bound", "")
        assert "at upper" not in shown
        assert "contact_upper" not in shown
    shifted = cq.compare(cq.ContactQP([[2.0]], [3.0], lower=-1.0), ["psor", "clarabel"])
    assert "(ω − l)R" in shifted.report(tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_node_that_other_bounds_hold_differs():
    right, wrong = answer(PRESSED, [1.0, 0.5]), answer(PRESSED, [0.0, -10.0])
    assert (right.contact_upper.tolist(), wrong.contact_lower.tolist()) == ([True, False], [True, False])
    np.testing.assert_array_equal(right.contact, wrong.contact)
    comparison = side_by_side(PRESSED, right=right, wrong=wrong)
    (pair,) = comparison.pairs
    assert pair.differing_nodes.tolist() == [0]
    assert pair.contact_jaccard == 1.0
    assert comparison.to_frame()["contact_jaccard"].tolist() == [0.0, 1.0]
    assert [row.contact_upper for row in comparison.rows] == [1, 0]


def test_each_contact_set_has_a_free_boundary_of_its_own():
    """Under the opposite load each bound holds about the nodes that the other held."""
    opposite = type(MEMBRANE)(MEMBRANE.lattice, 1.0, load=-MEMBRANE.load, support=0.1, ceiling=-0.2)
    one, other = cq.solve(MEMBRANE, "active-set"), cq.solve(opposite, "active-set")
    comparison = side_by_side(MEMBRANE, one=one, other=other)
    (pair,) = comparison.pairs
    here, there = (
        [MEMBRANE.free_boundary(held) for held in (solution.contact_lower, solution.contact_upper)]
        for solution in (one, other)
    )
    assert pair.boundary_distance == max(map(boundary_distance, here, there)) > 3.0
    together = [MEMBRANE.free_boundary(solution.contact) for solution in (one, other)]
    assert boundary_distance(*together) < 3.0
    sets = [np.stack([solution.contact_lower, solution.contact_upper]) for solution in (one, other)]
    assert pair.contact_jaccard == contact_jaccard(*sets) == 1.0
    assert contact_jaccard(one.contact, other.contact) < 0.5
    assert pair.differing_nodes.tolist() == np.flatnonzero(one.contact | other.contact).tolist()
    circled = comparison.plot().subfigs[0].axes[0].get_title()
    assert f"backends differ at {pair.differing_nodes.size} circled nodes" in circled


def test_assertions_know_both_bounds():
    assert assert_complementary(PRESSED, [1.0, 0.5]).status == "certified"
    with pytest.raises(AssertionError, match=r"max\(gap - upper, min\(gap - lower, R/G_ii\)\) = -1\b") as caught:
        assert_complementary(PRESSED, [0.0, 0.0])
    assert "worst node 0: gap 0, reaction -3" in str(caught.value)
    shifted = cq.ContactQP([[2.0]], [3.0], lower=-1.0)
    with pytest.raises(AssertionError, match=r"min\(gap - lower, R/G_ii\) = 1\b"):
        assert_complementary(shifted, [0.0])
    assert assert_backends_agree(CABLE, ["psor", "osqp"]).agree
    assert assert_same_contact(cq.solve(CABLE, "psor"), cq.solve(CABLE, "active-set")).all()


def test_assertions_tell_at_which_bound_a_node_is():
    right, wrong = (
        altered(answer(PRESSED, gap), certificate=None, status=cq.Status.CERTIFIED)
        for gap in ([1.0, 0.5], [0.0, -10.0])
    )  # undecided nodes would be excused
    with pytest.raises(AssertionError) as caught:
        assert_same_contact(right, wrong)
    lines = str(caught.value).splitlines()
    assert lines[0] == "contact sets differ at 1 of 2 nodes"
    assert lines[1].startswith("  first:  1 in contact (1 of them at the upper bound), osqp's answer to ContactQP")
    assert lines[2].startswith("  second: 1 in contact (0 of them at the upper bound), osqp's answer to ContactQP")
    assert lines[3].startswith(
        "  node 0: at the upper bound in the first (gap 1, reaction -1.5), at the lower bound in "
    )
    higher = cq.ContactQP(PRESSED.G, PRESSED.q, upper=[2.0, 0.2])
    with pytest.raises(
        AssertionError, match=r"node 1: free in the first .*, at the upper bound in the second"
    ) as caught:
        assert_same_contact(cq.solve(PRESSED), cq.solve(higher))
    assert "these are two problems: their bounds differ at 2 nodes" in str(caught.value)
