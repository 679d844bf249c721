"""Free spans and contact stretches of cables, on grounds for which they are known in closed form."""

import dataclasses

import numpy as np
import pytest
from strategies import BACKENDS, altered

import contactqp as cq
from contactqp import gallery
from contactqp.testing import assert_encloses

HILLS = [(9, 2, 4.0), (31, 5, 8.0), (31, 5, -2.0), (20, 3, 16.0), (10, 5, 4.0), (11, 5, 0.5), (15, 1, -8.0)]


@pytest.mark.parametrize(("nodes", "start", "radius"), HILLS)
def test_a_parabolic_ground_is_touched_where_the_tangents_meet(nodes, start, radius):
    cable, exact = gallery.cable_on_parabola(nodes, start, radius)
    solution = cq.solve(cable, "active-set", tol=1e-10)
    np.testing.assert_allclose(solution.deflection, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
    inside = np.arange(start, nodes + 2 - start) - 1
    np.testing.assert_array_equal(np.flatnonzero(solution.certificate.contact), inside)
    # On the ground -T w″ = p - ρ; half of it at the touchdown nodes, whose free side carries itself.
    expected = np.full(inside.size, 1 + 1 / radius)
    expected[[0, -1]] = expected[0] / 2
    np.testing.assert_allclose(solution.reaction[inside], expected, atol=1e-11 * np.abs(exact).max())


def test_the_parabola_is_the_flat_floor_when_it_is_very_flat():
    flat, on_floor = gallery.cable_on_floor(9, 2)
    curved, on_parabola = gallery.cable_on_parabola(9, 2, 1e9)
    np.testing.assert_allclose(on_parabola, on_floor, atol=1e-7)
    np.testing.assert_allclose(curved.support, flat.support, atol=1e-7)


@pytest.mark.parametrize("backend", BACKENDS)
def test_posts_carry_what_statics_say(backend):
    heights = [2.0, 3.5, 1.0, 2.0]
    cable, deflection, reaction = gallery.cable_on_posts(heights, bay=8)
    assert int(cable.supported.sum()) == 4
    # ΣP of half the bays beside a post, less the tension's share: T = p = 1, bays of 8.
    expected = [8 - (2.0 / 8 - 1.5 / 8), 8 - (1.5 / 8 + 2.5 / 8), 8 + (2.5 / 8 + 1.0 / 8), 8 - (1.0 / 8 + 2.0 / 8)]
    np.testing.assert_allclose(reaction[cable.supported], expected, atol=1e-14)
    assert not reaction[~cable.supported].any()
    tol = 1e-6 if backend == "mangasarian" else 1e-8
    solution = cq.solve(cable, backend, tol=tol)
    np.testing.assert_allclose(solution.deflection, deflection, atol=tol * cable.problem.gap_scale)
    assert_encloses(solution, cable.reference - deflection, slack=1e-14)
    lower, upper = solution.certificate.reaction
    assert ((lower <= reaction + 1e-13) & (reaction - 1e-13 <= upper)).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gallery.cable_on_parabola(9, 6, 4.0), r"contact_starts_after must be <= \(nodes \+ 1\)/2 = 5, got 6"),
        (lambda: gallery.cable_on_parabola(9, 2, -1.0), r"radius must be > 0 or < -1, got -1"),
        (lambda: gallery.cable_on_parabola(9, 2, 0.0), r"radius must be > 0 or < -1, got 0"),
        (lambda: gallery.cable_on_posts([1.0, 200.0], 4), r"depths\[1\] = 200 is too deep .* would not touch"),
        (lambda: gallery.cable_on_posts([], 4), "depths must hold one depth or more"),
        (lambda: gallery.cable_on_posts([[1.0]], 4), r"depths must have one dimension, got shape \(1, 1\)"),
        (lambda: gallery.cable_on_posts([1.0], 1), "bay must be >= 2, got 1"),
    ],
)
def test_bad_gallery_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_spans_over_a_flat_floor():
    cable, _ = gallery.cable_on_floor(nodes=19, contact_starts_after=4)
    spans = cable.spans(cq.solve(cable, "active-set"))
    assert spans["kind"].tolist() == ["free", "contact", "free"]
    assert spans["start"].tolist() == [0.0, 4.0, 16.0]
    assert spans["end"].tolist() == [4.0, 16.0, 20.0]
    assert spans["length"].tolist() == [4.0, 12.0, 4.0]
    assert spans["nodes"].tolist() == [3, 13, 3]
    first, touching, last = (row for _, row in spans.iterrows())
    # w = 4x - x²/2 before the floor at 8: gap 9/2 at x = 1, and the chord 2x lies 2 above at x = 2.
    for row, x in ((first, 1.0), (last, 19.0)):
        assert row["largest_gap"] == pytest.approx(4.5, abs=1e-12)
        assert row["largest_gap_at"] == x
        assert row["sag"] == pytest.approx(2.0, abs=1e-12)
        assert row["largest_slope"] == pytest.approx(3.5, abs=1e-12)
        assert row["reaction"] == row["reaction_upper"] == 0.0
    assert touching["reaction"] == pytest.approx(12.0, abs=1e-11)
    assert touching["reaction_lower"] <= 12.0 <= touching["reaction_upper"] < 12.0 + 1e-9
    assert touching[["largest_gap", "largest_gap_at", "sag"]].isna().all()
    assert touching["largest_slope"] == pytest.approx(0.0, abs=1e-12)
    assert spans["certain"].all()
    assert not spans["undecided"].any()


def test_point_contacts_have_no_length_and_the_reaction_of_statics():
    cable, deflection, reaction = gallery.cable_on_posts([2.0, 3.5, 1.0], bay=6)
    spans = cable.spans(cq.solve(cable, "active-set"))
    assert spans["kind"].tolist() == ["free", "contact"] * 3 + ["free"]
    posts = spans[spans["kind"] == "contact"]
    assert posts["start"].tolist() == posts["end"].tolist() == [6.0, 12.0, 18.0]
    assert posts["nodes"].tolist() == [1, 1, 1]
    np.testing.assert_allclose(posts["reaction"], reaction[cable.supported], atol=1e-11)
    assert posts["largest_slope"].isna().all()
    free = spans[spans["kind"] == "free"]
    np.testing.assert_allclose(free["sag"], 6.0**2 / 8, atol=1e-11)
    # Where nothing is below, there is no gap to measure.
    assert free[["largest_gap", "largest_gap_at"]].isna().all().all()
    heights = np.concatenate([[0.0], deflection, [0.0]])
    steepest = [np.abs(np.diff(heights[k : k + 7])).max() for k in range(0, 24, 6)]
    np.testing.assert_allclose(free["largest_slope"], steepest, atol=1e-11)


def test_the_largest_gap_is_one_over_a_support():
    """Sucked up from ends at 5 by 1 a length: w = 2.5 at x = 1, 0.5 at x = 3, with a ground of 3 below x = 1 only."""
    support = np.array([3.0, np.inf, np.inf, np.inf, np.inf])
    cable = cq.Cable(nodes=5, spacing=1.0, tension=1.0, load=-1.0, support=support, frame_height=5.0)
    span = cable.spans(cq.solve(cable, "active-set")).iloc[0]
    assert (span["kind"], span["nodes"], span["largest_gap_at"]) == ("free", 5, 1.0)
    assert span["largest_gap"] == pytest.approx(0.5)
    assert span["sag"] == 0.0


def test_a_free_span_has_no_reaction_even_in_a_rough_answer():
    cable, _ = gallery.cable_on_floor(nodes=19, contact_starts_after=4)
    rough = cq.solve(cable, "osqp", tol=1e-2)
    assert np.abs(rough.reaction[~rough.contact]).max() > 1e-16
    spans = cable.spans(rough)
    assert (spans["reaction"][spans["kind"] == "free"] == 0).all()


def test_rows_alternate_and_meet_at_contact_nodes():
    bed = cq.profiles.Sampled([0, 3, 7, 12, 15, 20, 26, 30], [0, 1.5, 0.2, 4, 3.5, 4, 0.7, 0])
    cable = cq.Cable(span=30.0, spacing=0.5, tension=2.0, load=0.5, support=bed, frame_height=bed)
    solution = cq.solve(cable, "active-set")
    spans = cable.spans(solution)
    assert (spans["kind"].to_numpy()[1:] != spans["kind"].to_numpy()[:-1]).all()
    np.testing.assert_array_equal(spans["end"].to_numpy()[:-1], spans["start"].to_numpy()[1:])
    touching = cable.lattice.node_x[solution.contact]
    assert set(spans[["start", "end"]].to_numpy().ravel()) <= {*touching, 0.0, 30.0}
    assert spans["nodes"].sum() == cable.lattice.size
    assert spans["reaction"].sum() == pytest.approx(solution.reaction[solution.contact].sum())
    assert (spans["kind"] == "free").sum() >= 2


def test_a_cable_whose_end_is_beside_a_contact_node_has_no_span_there():
    cable = cq.Cable(nodes=7, spacing=1.0, tension=1.0, load=1.0, support=np.array([0, 0, 0, 9, 9, 0, 0.0]), start=50.0)
    spans = cable.spans(cq.solve(cable, "active-set"))
    assert spans["kind"].tolist() == ["contact", "free", "contact"]
    assert spans["start"].tolist() == [51.0, 53.0, 56.0]
    assert spans["end"].tolist() == [53.0, 56.0, 57.0]


def test_a_cable_that_touches_nothing_or_lies_throughout_is_one_row():
    free = cq.Cable(nodes=5, spacing=1.0, tension=1.0, load=1.0, support=np.inf)
    spans = free.spans(cq.solve(free, "active-set"))
    assert (len(spans), spans["kind"][0], spans["start"][0], spans["end"][0]) == (1, "free", 0.0, 6.0)
    assert spans["sag"][0] == pytest.approx(4.5)
    lying = cq.Cable(nodes=5, spacing=1.0, tension=1.0, load=1.0, support=0.0)
    spans = lying.spans(cq.solve(lying, "active-set"))
    assert (len(spans), spans["kind"][0], spans["start"][0], spans["end"][0]) == (1, "contact", 1.0, 5.0)


def test_an_undecided_touchdown_is_not_certain():
    """A node that touches without a reaction: neither gap nor reaction decides."""
    support = np.array([9, 9, -3.0, -4, -3, 9, 9])
    cable = cq.Cable(nodes=7, spacing=1.0, tension=1.0, load=0.0, support=support)
    solution = cq.solve(cable, "active-set")
    assert solution.certificate.undecided.tolist() == [False, False, True, False, True, False, False]
    for touching in (True, False):
        contact = solution.certificate.contact | (solution.certificate.undecided & touching)
        spans = cable.spans(with_contact(solution, contact))
        assert spans["undecided"].sum() == 2
        assert not spans["certain"].any()
    decided = np.where(np.isin(np.arange(7), [2, 4]), 9.0, support)
    clear = cq.Cable(nodes=7, spacing=1.0, tension=1.0, load=0.0, support=decided)
    assert clear.spans(cq.solve(clear, "active-set"))["certain"].all()


def with_contact(solution, contact):
    """Return the solution as of a backend that has other nodes in contact."""
    copy = dataclasses.replace(solution)
    copy.__dict__["_contact"] = contact, np.zeros_like(contact), contact
    return copy


def test_without_a_certificate_nothing_is_certain():
    cable, _ = gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    bare = altered(cq.solve(cable, "active-set"), certificate=None)
    assert bare.certificate is None
    spans = cable.spans(bare)
    assert spans["kind"].tolist() == ["free", "contact", "free"]
    assert not spans["certain"].any()
    assert spans["undecided"].tolist() == spans["nodes"].tolist()
    assert spans[["reaction_lower", "reaction_upper"]].isna().all().all()


def test_spans_of_something_else_are_refused():
    cable, _ = gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    other, _ = gallery.cable_on_floor(nodes=9, contact_starts_after=3)
    with pytest.raises(TypeError, match="solution must be a Solution, got ndarray"):
        cable.spans(np.zeros(9))
    with pytest.raises(ValueError, match=r"solution must be of this cable.*solution.model.spans\(solution\)"):
        cable.spans(cq.solve(other, "active-set"))
    with pytest.warns(cq.ContactWarning):
        failed = cq.solve(cable, "clarabel", max_iter=1, tol=1e-15)
    nothing = altered(failed, gap=np.full(9, np.nan), residuals=None, certificate=None)
    with pytest.raises(ValueError, match="holds no finite answer"):
        cable.spans(nothing)


def test_a_stretch_of_contact_is_a_spacing_shorter_than_what_its_nodes_stand_for():
    cable, _ = cq.gallery.cable_on_floor(nodes=19, contact_starts_after=4)
    solution = cq.solve(cable)
    spans = cable.spans(solution)
    assert spans["length"][spans["kind"] == "contact"].sum() + cable.lattice.spacing == solution.contact_area.lower
