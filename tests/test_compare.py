import json

import numpy as np
import pytest
from matplotlib.figure import Figure
from strategies import BACKENDS

import contactqp as cq
from contactqp.compare import Comparison
from contactqp.testing import assert_backends_agree, assert_complementary

HEXAGON = cq.gallery.paper_hexagon()


@pytest.fixture(scope="module")
def agreeing():
    return cq.compare(HEXAGON)


def test_the_table_as_data(agreeing):
    frame = agreeing.to_frame()
    assert list(frame.index) == list(BACKENDS)
    assert (frame["status"] == "certified").all()
    assert frame["contact"].tolist() == [303] * 6
    assert (frame["certain_contact"] + frame["certain_clear"] + frame["undecided"] == 1857).all()
    assert (frame["relative_bound"] <= 1e-6).all()
    assert frame["objective"].to_numpy() == pytest.approx(-141.6537778, abs=1e-5)
    assert (frame["setup_seconds"] + frame["solve_seconds"] > 0).all()


def test_the_pairs_as_data(agreeing):
    pairs = agreeing.pairs_frame()
    assert len(pairs) == 15
    assert (pairs["contact_jaccard"] == 0).all()
    assert pairs["consistent"].all()
    assert pairs["gap_difference"].max() < 2e-6 * HEXAGON.problem.gap_scale


def test_agreement_reads_well(agreeing):
    text = repr(agreeing)
    assert agreeing.agree
    assert agreeing.culprits == {}
    lines = text.splitlines()
    assert lines[0].startswith("Membrane(1857 nodes, spacing=1, tension=1), tol 1e-06 of the gap scale 1.09")
    assert lines[2].split() == [
        "backend", "status", "iterations", "seconds", "bound/scale", "true", "error", "min", "gap", "min", "R", "gap·R",
        "contact", "undecided",
    ]  # fmt: skip
    assert lines[-1].startswith("All 6 backends agree: certified, max gap difference ")
    assert lines[-1].endswith("the same contact set.")
    assert max(map(len, lines)) <= 132
    html = agreeing._repr_html_()
    assert html.count("<tr>") == 7
    assert "gap·R" in html


def test_json_can_be_read_back(agreeing):
    record = json.loads(agreeing.to_json())
    assert record["agree"] is True
    assert [row["backend"] for row in record["backends"]] == list(BACKENDS)
    assert len(record["pairs"]) == 15
    assert record["pairs"][0]["differing_nodes"] == []


def test_json_has_no_infinities():
    comparison = cq.compare(cq.Membrane(HEXAGON.lattice, 1.0, 0.1, np.inf), ["psor"])
    assert json.loads(comparison.to_json())["backends"][0]["min_gap"] is None


def test_a_disagreement_names_the_culprit_and_what_it_violates():
    comparison = cq.compare(
        HEXAGON, ["psor", "clarabel"], options={"psor": {"stopping": "step", "stopping_length": 0.1}}
    )
    assert not comparison.agree
    assert list(comparison.culprits) == ["psor"]
    assert "bound" in comparison.culprits["psor"]
    assert "No agreement: psor (inaccurate: bound" in repr(comparison)
    assert comparison.to_frame()["undecided"]["psor"] > 0


def forged(comparison, name, gap):
    """Replace one answer by another vector, judged as any other."""
    from dataclasses import replace

    from contactqp.judge import judge
    from contactqp.rows import row_of

    old = comparison.solutions[name]
    verdict = judge(old.problem, gap, old.tol)
    new = replace(
        old, gap=gap, status=verdict.status, residuals=verdict.residuals, certificate=verdict.certificate,
        relative_bound=verdict.relative_bound,
    )  # fmt: skip
    rows = [row_of(new, name) if row.backend == name else row for row in comparison.rows]
    return Comparison(comparison.problem, comparison.subject, comparison.tol, rows, comparison.solutions | {name: new})


@pytest.mark.parametrize(("change", "complaint"), [(0.01, "natural residual"), (-0.5, "min gap -0.5")])
def test_a_forged_answer_is_named(agreeing, change, complaint):
    wrong = forged(agreeing, "clarabel", agreeing.solutions["clarabel"].gap + change)
    assert not wrong.agree
    assert list(wrong.culprits) == ["clarabel"]
    assert complaint in wrong.culprits["clarabel"]
    assert wrong.verdict().startswith("No agreement: clarabel (inaccurate: bound")
    differing = [pair.differing_nodes.size for pair in wrong.pairs if "clarabel" in (pair.first, pair.second)]
    assert min(differing) > 0
    assert all(pair.consistent for pair in wrong.pairs)  # the enclosure is wide, but right
    assert isinstance(wrong.plot(), Figure)


def test_enclosures_that_exclude_each_other_convict_the_odd_one_out(agreeing):
    """Cannot happen with honest certificates, so one is forged."""
    from dataclasses import replace

    old = agreeing.solutions["psor"]
    impossible = replace(old.certificate, lower=old.certificate.lower + 1.0, upper=old.certificate.upper + 1.0)
    solutions = agreeing.solutions | {"psor": replace(old, certificate=impossible)}
    wrong = Comparison(agreeing.problem, agreeing.subject, agreeing.tol, agreeing.rows, solutions)
    assert not wrong.agree
    assert wrong.culprits == {"psor": "excludes the answers of 5 of 5 other backends"}


def test_without_enclosures_agreement_rests_on_the_answers():
    problem = cq.ContactQP(np.array([[1.0, 2.0], [2.0, 5.0]]), [-1.0, -1.0])
    comparison = cq.compare(problem, ["osqp", "clarabel", "psor", "mangasarian"])
    assert not comparison.agree
    assert list(comparison.culprits) == ["mangasarian"]
    assert "needs a Z-matrix" in comparison.culprits["mangasarian"]
    others = cq.compare(problem)
    assert [row.backend for row in others.rows] == ["osqp", "clarabel", "psor"]
    assert others.agree
    assert "within tol by their residuals" in others.verdict()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"backends": "osqp"}, TypeError, r"write \['osqp'\]"),
        ({"backends": ["osqp", "osqp"]}, ValueError, "must not repeat"),
        ({"backends": ["ossqp"]}, cq.UnknownBackendError, "did you mean 'osqp'"),
        ({"backends": ["osqp"], "options": {"psor": {}}}, ValueError, "options name 'psor'"),
        ({"backends": ["psor"], "options": {"psor": {"bta": 1}}}, TypeError, "no option 'bta'"),
        ({"tol": 2.0}, ValueError, "tol must lie strictly between 0 and 1"),
        ({"time_limit": -1.0}, ValueError, "time_limit must be > 0"),
        ({"problem": 7}, TypeError, "problem must be a Membrane"),
    ],
)
def test_bad_comparisons_say_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        cq.compare(**({"problem": HEXAGON} | arguments))


def test_a_comparison_of_nobody_agrees_on_nothing():
    comparison = cq.compare(HEXAGON, [])
    assert not comparison.agree
    assert comparison.best is None
    assert comparison.verdict() == "No agreement: no backend was asked."
    with pytest.raises(ValueError, match="nothing to draw"):
        comparison.plot()


def test_iteration_limits_are_passed_on():
    comparison = cq.compare(HEXAGON, ["osqp", "clarabel"], max_iter=3)
    assert comparison.to_frame()["status"].tolist() == ["iteration_limit", "iteration_limit"]
    assert (comparison.to_frame()["iterations"] <= 3).all()


def test_auto_is_a_name_like_any_other():
    comparison = cq.compare(HEXAGON, ["auto", "clarabel"])
    assert comparison.agree
    assert (comparison.pairs[0].first, comparison.pairs[0].second) == ("auto", "clarabel")
    with pytest.raises(AssertionError, match="auto has gap"):
        assert_backends_agree(HEXAGON, ["auto", "mangasarian"], tol=1e-15)
    with pytest.raises(TypeError, match="no option 'relaxatoin'"):
        cq.compare(HEXAGON, ["auto"], options={"auto": {"relaxatoin": 1}})


def test_timeouts_are_rows():
    comparison = cq.compare(cq.gallery.bowl(63), ["psor", "clarabel"], time_limit=1e-5, tol=1e-9)
    assert comparison.to_frame()["status"].tolist() == ["time_limit", "time_limit"]
    assert "time_limit" in comparison.culprits["psor"]


def test_assert_complementary_shows_the_worst_node(agreeing):
    gap = agreeing.solutions["osqp"].gap.copy()
    assert assert_complementary(HEXAGON, gap).status == "certified"
    worst = int(np.argmax(gap))
    gap[worst] -= 0.1
    with pytest.raises(AssertionError) as caught:
        assert_complementary(HEXAGON, gap)
    message = str(caught.value)
    assert "gap does not solve Membrane(1857 nodes" in message
    assert "certified bound" in message
    assert HEXAGON.lattice.describe(worst) in message
    with pytest.raises(AssertionError, match=r"worst node 1: gap 0.5"):
        assert_complementary(cq.ContactQP(np.array([[1.0, 2.0], [2.0, 5.0]]), [-1.0, -1.0]), [0.0, 0.5])


def test_assert_backends_agree_shows_table_and_worst_difference(monkeypatch, agreeing):
    wrong = forged(agreeing, "psor", agreeing.solutions["psor"].gap * 1.01)
    monkeypatch.setattr("contactqp.testing.compare", lambda *args, **kwargs: wrong)
    with pytest.raises(AssertionError) as caught:
        assert_backends_agree(HEXAGON)
    message = str(caught.value)
    assert message.startswith("No agreement: psor (inaccurate")
    assert "bound/scale" in message
    assert "largest difference at node" in message
    assert "psor has gap" in message


def test_assert_backends_agree_returns_the_comparison():
    assert assert_backends_agree(cq.gallery.islands(), ["psor", "clarabel"]).agree
