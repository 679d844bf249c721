import json
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from strategies import BACKENDS, altered

import contactqp as cq
from contactqp.backends import get_backend
from contactqp.backends.base import Answer, Backend, State, Stop
from contactqp.backends.psor import Psor
from contactqp.comparison.comparison import Comparison
from contactqp.comparison.outcome import Outcome
from contactqp.proof.judge import judge
from contactqp.solving.tolerances import Tolerance
from contactqp.testing import assert_backends_agree, assert_complementary

HEXAGON = cq.gallery.paper_hexagon()


@pytest.fixture(scope="module")
def agreeing():
    return cq.compare(HEXAGON)


def test_the_table_as_data(agreeing):
    frame = agreeing.to_frame()
    assert list(frame.index) == list(BACKENDS)
    assert (frame["status"] == "certified").all()
    assert frame["contact"].tolist() == [303] * 7
    assert (frame["certain_contact"] + frame["certain_clear"] + frame["undecided"] == 1857).all()
    assert (frame["relative_bound"] <= 1e-6).all()
    assert frame["objective"].to_numpy() == pytest.approx(-141.6537778, abs=1e-5)
    assert (frame["setup_seconds"] + frame["solve_seconds"] > 0).all()


def test_the_pairs_as_data(agreeing):
    pairs = agreeing.pairs_frame()
    assert len(pairs) == 21
    assert (pairs["contact_jaccard"] == 0).all()
    assert pairs["consistent"].all()
    assert pairs["gap_difference"].max() < 2e-6 * HEXAGON.problem.gap_scale


def test_agreement_reads_well(agreeing):
    text = repr(agreeing)
    assert agreeing.agree
    assert agreeing.culprits == {}
    lines = text.splitlines()
    assert lines[:2] == [
        "Membrane(1857 nodes, spacing=1, tension=1, load=0.03, support=0 to 1.25)",
        "gap errors against the exact solution of the discrete problem: tol 1e-06 of the error scale, which is at most "
        "1.09",
    ]
    assert lines[3].split() == [
        "backend", "status", "iterations", "seconds", "bound/scale", "true", "error", "min", "gap", "min", "R", "gap·R",
        "contact", "undecided",
    ]  # fmt: skip
    assert lines[-1].startswith("All 7 backends agree: certified, max gap difference ")
    assert lines[-1].endswith("the same contact set.")
    assert max(map(len, lines)) <= 132
    html = agreeing._repr_html_()
    assert html.count("<tr>") == 8
    assert "gap·R" in html


def test_json_can_be_read_back(agreeing):
    record = json.loads(agreeing.to_json())
    assert record["agree"] is True
    assert [row["backend"] for row in record["backends"]] == list(BACKENDS)
    assert len(record["pairs"]) == 21
    assert record["pairs"][0]["differing_nodes"] == []


def test_json_has_no_infinities():
    comparison = cq.compare(cq.Membrane(HEXAGON.lattice, 1.0, load=0.1, support=np.inf), ["psor"])
    assert json.loads(comparison.to_json())["backends"][0]["min_gap"] is None


def test_a_disagreement_names_the_culprit_and_what_it_violates():
    comparison = cq.compare(
        HEXAGON, ["psor", "clarabel"], options={"psor": {"stopping": "step", "stopping_length": 0.1}}
    )
    assert not comparison.agree
    assert list(comparison.culprits) == ["psor"]
    assert "bound" in comparison.culprits["psor"]
    assert "No agreement: psor (inaccurate: bound" in repr(comparison)
    assert comparison.to_frame()["relative_true_error"]["psor"] > 1e-3


def beside(comparison, **answers):
    """Return a comparison of the same problem in which some answers are others."""
    solutions = {name: comparison.solutions[name] for name in comparison.to_frame().index} | answers
    outcomes = [Outcome(name, solution) for name, solution in solutions.items()]
    return Comparison(comparison.model or comparison.problem, outcomes, comparison.tolerance)


def forged(comparison, name, gap):
    """Replace one answer by another vector, judged as any other."""
    old = comparison.solutions[name]
    new = replace(old, run=replace(old.run, gap=gap), verdict=judge(old.problem, gap, old.tol))
    return beside(comparison, **{name: new})


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
    old = agreeing.solutions["psor"]
    impossible = replace(old.certificate, lower=old.certificate.lower + 1.0, upper=old.certificate.upper + 1.0)
    wrong = beside(agreeing, psor=altered(old, certificate=impossible))
    assert not wrong.agree
    assert wrong.culprits == {"psor": "excludes the answers of 6 of 6 other backends"}
    assert wrong.truth is None
    assert wrong.true_error == {}
    assert len(wrong.findings) == 6
    assert "the enclosures of osqp and psor contradict each other at 1857 nodes" in repr(wrong)
    assert json.loads(wrong.to_json())["truth"] is None


def test_the_truth_is_narrower_than_any_enclosure(agreeing):
    truth = agreeing.truth
    for name, solution in agreeing.solutions.items():
        certificate = solution.certificate
        assert (certificate.lower <= truth.lower).all()
        assert (truth.upper <= certificate.upper).all()
        low, high = agreeing.true_error[name]
        assert 0 <= low <= high <= certificate.gap_bound
    best = agreeing.best
    low, high = agreeing.true_error["psor"]
    assert low <= np.abs(agreeing.solutions["psor"].gap - best.gap).max() + best.certificate.gap_bound
    assert agreeing.decided == {"contact": 303, "clear": 1554, "undecided": 0}


def test_metrics_are_in_the_rows(agreeing):
    frame = agreeing.to_frame()
    assert (frame["primal_residual"] == np.maximum(0, -frame["min_gap"])).all()
    assert (frame["dual_residual"] == np.maximum(0, -frame["min_reaction"])).all()
    assert (frame["gap_bound"] == [s.certificate.gap_bound for s in agreeing.solutions.values()]).all()
    assert (frame["relative_true_error"] <= frame["relative_bound"] * (1 + 1e-12)).all()
    assert (frame["cold_seconds"] >= frame["setup_seconds"] + frame["solve_seconds"]).all()
    assert frame["warm_seconds"].isna().all()
    assert frame["claimed"].all()
    assert (frame["contact_jaccard"] == 0).all()
    assert (frame["boundary_distance"] == 0).all()
    record = json.loads(agreeing.to_json())
    assert set(record["backends"][0]) == {"backend", *frame.columns}
    assert record["truth"]["contact"] == 303
    assert (record["findings"], record["false_claims"], record["setting"]) == ([], {}, "")
    assert {"numpy", "osqp", "contactqp", "Python"} <= set(record["provenance"]["versions"])
    assert record["provenance"]["options"]["osqp"]["rho"] == 3.0


def test_another_contact_set_has_distances(agreeing):
    """The answer to a higher load: its contact set holds the true one."""
    other = cq.solve(cq.gallery.paper_hexagon(0.04), "active-set").gap
    wrong = forged(agreeing, "clarabel", other)
    row = wrong.to_frame().loc["clarabel"]
    contact, best = wrong.solutions["clarabel"].contact, wrong.best.contact
    assert row["contact_jaccard"] == pytest.approx(1 - np.sum(contact & best) / np.sum(contact | best))
    assert 0.1 < row["contact_jaccard"] < 0.9
    assert 1.0 <= row["boundary_distance"] < 20.0
    apart = np.abs(other - wrong.best.gap).max()
    assert row["true_error_lower"] <= apart + 1e-9
    assert row["true_error_upper"] == pytest.approx(apart, rel=1e-6)
    (pair,) = (pair for pair in wrong.pairs if (pair.first, pair.second) == ("osqp", "clarabel"))
    assert pair.boundary_distance == row["boundary_distance"]
    assert pair.differing_nodes.tolist() == np.flatnonzero(contact != best).tolist()


def test_a_penetrating_answer_has_a_primal_residual(agreeing):
    gap = agreeing.solutions["clarabel"].gap.copy()
    gap[3] = -0.5
    row = forged(agreeing, "clarabel", gap).to_frame().loc["clarabel"]
    assert row["primal_residual"] == 0.5
    assert row["dual_residual"] > 0
    assert row["true_error_lower"] >= 0.5


def test_own_defaults_are_claims_to_be_checked():
    comparison = cq.compare(HEXAGON, ["osqp", "psor"], tol="default")
    assert (comparison.tol, comparison.setting) == (1e-6, "default")
    assert list(comparison.false_claims) == ["osqp"]
    assert comparison.false_claims["osqp"].startswith("said 'solved, eps 1e-03', and its gap is wrong by at least 0.0")
    assert comparison.verdict().endswith(" Said to have solved it, and did not (1): osqp.")
    assert "False claim: osqp said" in repr(comparison)
    assert "tol 1e-06 (default) of the error scale" in repr(comparison)
    low, high = comparison.true_error["osqp"]
    assert 1e-6 * HEXAGON.problem.gap_scale < low <= high < 1.001 * low
    assert comparison.provenance.options["osqp"] == {}
    assert comparison.provenance.options["psor"]["order"] == "lexicographic"


def test_an_answer_that_others_prove_right_is_no_false_claim(monkeypatch):
    """With fast certificates Clarabel's own is too wide for tol; with the others' its answer is proven good enough."""
    monkeypatch.setattr("contactqp.proof.judge.SHARP_SIZE", 0)
    monkeypatch.setattr("contactqp.solving.solution.DIRECT_SIZE", 0)
    monkeypatch.setattr("contactqp.solving.solution._SHARP_ON_LATTICES", 0)
    cable = cq.Cable(span=100.0, spacing=1.0, tension=1000.0, load=2.0, support=0.9)
    comparison = cq.compare(cable, ["clarabel", "psor"], tol="default")
    row = comparison.to_frame().loc["clarabel"]
    assert (row["status"], row["claimed"]) == ("inaccurate", True)
    assert row["relative_true_error"] <= 1e-6 < row["relative_bound"]
    assert comparison.false_claims == {}
    alone = cq.compare(cable, ["clarabel"], tol="default")
    assert alone.false_claims == {}
    assert "and its gap is proven to" in alone.unproven_claims["clarabel"]
    assert alone.verdict().endswith(" Said to have solved it, which is not proven (1): clarabel.")


def test_without_any_enclosure_no_claim_is_called_false(monkeypatch):
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    problem = cq.ContactQP(0.1 * np.eye(3) + 0.9, [-1.0, -0.9, -0.8])
    comparison = cq.compare(problem, ["osqp"], tol="default", options={"osqp": {"eps": 0.5}})
    assert comparison.truth is None
    assert comparison.false_claims == {}
    told = comparison.unproven_claims["osqp"]
    assert "and nothing is proven of its error; its residual is" in told
    assert f"Unproven: osqp {told}." in repr(comparison)
    assert json.loads(comparison.to_json())["unproven_claims"] == {"osqp": told}
    assert comparison.rows[0].gap_bound is None
    assert comparison.rows[0].boundary_distance is None


def test_an_honest_failure_is_no_false_claim():
    comparison = cq.compare(HEXAGON, ["osqp", "clarabel", "psor"], max_iter=3)
    assert not comparison.to_frame()["claimed"].any()
    assert comparison.false_claims == {}


def test_repeats_are_warm_runs():
    comparison = cq.compare(cq.gallery.islands(), ["psor", "mangasarian"], repeats=2)
    assert (comparison.to_frame()["warm_seconds"] > 0).all()
    assert comparison.provenance.repeats == 2
    with pytest.raises(ValueError, match="repeats must be >= 0, got -1"):
        cq.compare(HEXAGON, repeats=-1)


def test_warm_runs_keep_the_set_up_and_forget_the_answer():
    seen = []

    class Remembering(State):
        def solve(self, q, task, problem=None):
            seen.append((self, task.warm_start))
            return Answer(np.zeros(q.size), Stop.DONE, "as you like it", 1, 0.0, 0.0)

    class Recorder(Backend):
        name, summary, package = "recorder", "records what it is asked", "numpy"

        def prepare(self, problem, task):
            return Remembering()

    comparison = cq.compare(cq.gallery.islands(), [Recorder()], repeats=3)
    (first, *again), starts = zip(*seen, strict=True)
    assert starts == (None,) * 4
    assert len(again) == 3
    assert len(set(again)) == 1
    assert again[0] is not first
    assert comparison.rows[0].warm_seconds > 0


def test_the_worst_nodes_name_who_differs(agreeing):
    node = 7
    gap = agreeing.solutions["clarabel"].gap.copy()
    gap[node] += 0.25
    wrong = forged(agreeing, "clarabel", gap)
    worst = wrong.worst_nodes(3)
    first = worst.iloc[0]
    assert (first["node"], first["larger"], len(worst)) == (node, "clarabel", 3)
    assert (first["x"], first["y"]) == (HEXAGON.lattice.node_x[node], HEXAGON.lattice.node_y[node])
    assert first["larger_gap"] - first["smaller_gap"] == first["difference"] == wrong.spread[node]
    assert first["difference"] == pytest.approx(0.25, rel=1e-6)
    assert first["larger_reaction"] == wrong.solutions["clarabel"].reaction[node]
    assert first["true_lower"] <= first["smaller_gap"] + 1e-6
    assert first["true_upper"] < first["larger_gap"]
    assert (np.diff(worst["difference"]) <= 0).all()
    with pytest.raises(ValueError, match="count must be >= 1, got 0"):
        wrong.worst_nodes(0)
    alone = cq.compare(HEXAGON, ["psor"]).worst_nodes()
    assert alone.empty
    assert list(alone.columns) == list(worst.columns)


def test_the_disagreement_is_drawn_for_every_kind_of_problem(agreeing):
    gap = agreeing.solutions["clarabel"].gap + 0.01
    (axes, bar) = forged(agreeing, "clarabel", gap).plot_disagreement().axes
    assert "nodes whose contact differs" in axes.get_title()
    assert axes.texts[0].get_text() == "1"
    assert bar.get_ylabel() == "difference of gaps (length)"
    values = axes.collections[0].get_array()
    assert values.compressed().size == 1857
    cable, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    (line,) = cq.compare(cable, ["psor", "clarabel"]).plot_disagreement().axes
    assert line.get_yscale() == "log"
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    (sorted_,) = cq.compare(problem, ["psor", "clarabel"]).plot_disagreement().axes
    assert np.diff(sorted_.lines[0].get_ydata()).max() <= 0
    with pytest.raises(ValueError, match="needs two answers, and there are 1"):
        cq.compare(cable, ["psor"]).plot_disagreement()


def test_answers_that_are_the_same_have_nothing_to_show(agreeing):
    same = forged(agreeing, "clarabel", agreeing.solutions["osqp"].gap)
    twins = [Outcome(name, same.solutions[name]) for name in ("osqp", "clarabel")]
    comparison = Comparison(HEXAGON, twins, same.tolerance)
    assert comparison.spread.max() == 0
    axes = comparison.plot_disagreement().axes[0]
    assert len(axes.texts) == 0
    assert "the contact sets are the same" in axes.get_title()


def test_beyond_m_matrices_agreement_rests_on_proofs(monkeypatch):
    problem = cq.ContactQP(np.array([[1.0, 2.0], [2.0, 5.0]]), [-1.0, -1.0])
    comparison = cq.compare(problem, ["osqp", "clarabel", "psor", "mangasarian"])
    assert not comparison.agree
    assert list(comparison.culprits) == ["mangasarian"]
    assert "needs a Z-matrix" in comparison.culprits["mangasarian"]
    others = cq.compare(problem)
    assert [row.backend for row in others.rows] == ["osqp", "clarabel", "psor", "active-set", "mprgp"]
    assert others.agree
    assert others.verdict().startswith("All 5 backends agree: certified")
    monkeypatch.setattr("contactqp.algebra.band.MOST_ENTRIES", 2)
    unproven = cq.compare(cq.ContactQP(0.1 * np.eye(3) + 0.9, [-1.0, 0.0, 0.0]))
    assert not unproven.agree
    assert {row.status for row in unproven.rows} == {"unproven"}
    assert all(row.relative_bound == np.inf and row.relative_residual < 1e-6 for row in unproven.rows)
    assert "residual/scale" in repr(unproven)
    assert "no bound is known" in unproven.verdict()
    assert unproven.best is min(unproven.solutions.values(), key=lambda solution: solution.relative_residual)
    assert json.loads(unproven.to_json())["backends"][0]["relative_bound"] is None


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"backends": "osqp"}, TypeError, r"write \['osqp'\]"),
        ({"backends": ["osqp", "osqp"]}, ValueError, "must not repeat"),
        ({"backends": ["osqp", 7]}, TypeError, "backends must hold names and Backends only, got 7"),
        ({"backends": get_backend("osqp")}, TypeError, "backends must be a sequence of names, got .*Osqp.* alone"),
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
    comparison = Comparison(HEXAGON, [], Tolerance(1e-6))
    assert not comparison.agree
    assert comparison.best is None
    assert comparison.verdict() == "No agreement: no backend was asked."
    with pytest.raises(ValueError, match="nothing to draw"):
        comparison.plot()


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"backends": []}, ValueError, "backends must hold a name at least, got none; leave them out for all"),
        ({"backends": 3}, TypeError, "backends must be a sequence of names, got 3"),
        ({"options": 3}, TypeError, "options must map a backend's name to its options, got 3; write options={'psor'"),
        ({"options": [1]}, TypeError, r"options must map a backend's name to its options, got \[1\]; write"),
        ({"options": {"osqp": 3}}, TypeError, r"options\['osqp'\] must map the backend's options to values, got 3"),
    ],
)  # fmt: skip
def test_arguments_of_another_kind_are_named(given, error, told):
    with pytest.raises(error, match=told):
        cq.compare(HEXAGON, **given)


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


def test_a_backend_itself_is_as_good_as_its_name():
    comparison = cq.compare(HEXAGON, [get_backend("psor"), "clarabel"], options={"psor": {"relaxation": 1.9}})
    assert list(comparison.solutions) == ["psor", "clarabel"]
    assert comparison.provenance.options["psor"]["relaxation"] == 1.9
    assert comparison.agree
    with pytest.raises(ValueError, match=r"must not repeat, got \['psor', 'psor'\]"):
        cq.compare(HEXAGON, [get_backend("psor"), "psor"])


def test_a_comparison_knows_its_model_even_if_nobody_answered():
    cable, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    matrix = cq.ContactQP(np.eye(2), [1.0, 1.0])
    for posed, backends in ((cable, []), (HEXAGON, []), (matrix, ["multigrid"])):
        comparison = cq.compare(posed, backends) if backends else Comparison(posed, [], Tolerance(1e-6))
        assert comparison.best is None
        assert (comparison.model or comparison.problem) is posed
        assert comparison.problem is getattr(posed, "problem", posed)


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
    monkeypatch.setattr("contactqp.testing.assertions.compare", lambda *args, **kwargs: wrong)
    with pytest.raises(AssertionError) as caught:
        assert_backends_agree(HEXAGON)
    message = str(caught.value)
    assert message.startswith("No agreement: psor (inaccurate")
    assert "bound/scale" in message
    assert "largest difference at node" in message
    assert "psor has gap" in message


def test_assert_backends_agree_returns_the_comparison():
    assert assert_backends_agree(cq.gallery.islands(), ["psor", "clarabel"]).agree


def test_a_session_that_cannot_be_set_up_leaves_the_answer_without_warm_seconds():
    class Refuses(Psor):
        name = "cannot-prepare"
        asked = 0

        def holds(self, problem):
            Refuses.asked += 1
            return "asked too often" if Refuses.asked > 1 else None

        @property
        def needs(self):
            return (self,)

    (row,) = cq.compare(HEXAGON, [Refuses()], repeats=2).rows
    assert row.status == "certified"
    assert row.warm_seconds is None
    assert Refuses.asked == 2


def test_every_page_says_once_what_errors_are_against(agreeing, tmp_path):
    against = "the exact solution of the discrete problem"
    page = agreeing.report(tmp_path / "page.html").read_text(encoding="utf-8")
    for text in (repr(agreeing), agreeing._repr_html_(), page, repr(agreeing.best), agreeing.best._repr_html_()):
        assert text.lower().count(against) == 1


def test_what_is_relative_to_the_answer_s_own_scale_is_not_called_the_problem_s():
    """An answer near zero has a smaller scale than the problem."""
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], gap_scale=100.0)
    with pytest.warns(cq.ContactWarning, match=r"bound \S+ of the error scale, wanted 1e-06"):
        solution = cq.solve(problem, "psor", max_iter=1)
    assert solution.verdict.scale < problem.gap_scale
    assert solution.relative_bound == solution.certificate.gap_bound / solution.verdict.scale
    assert "of the error scale; tol 1e-06" in repr(solution)
    assert "gap scale" not in repr(solution)
