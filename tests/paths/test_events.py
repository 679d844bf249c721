"""Exact events along load paths: against hand computations, and against solutions in between."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.models.varied import with_load


def listed(found):
    return [
        (pytest.approx(load), int(node), bool(settles))
        for load, node, settles in zip(found.load, found.node, found.settles, strict=True)
    ]


def cable(load, support, **options):
    return cq.Cable(nodes=len(support), spacing=1.0, tension=1.0, load=load, support=support, **options)


def test_two_nodes_by_hand():
    """w = λ(1, 1) until w_0 = 1; then 2w_1 - 1 = λ, so that w_1 = 2 at λ = 3."""
    found = cq.events(cable(1.0, [1.0, 2.0]), stop=4.0)
    assert listed(found) == [(1.0, 0, True), (3.0, 1, True)]
    assert found.first_touch == pytest.approx(1.0)
    assert found.full_contact == pytest.approx(3.0)
    np.testing.assert_allclose(found.touchdown, [1.0, 3.0])
    assert repr(found).endswith("load factors 0 to 4: 2 nodes settle)")


def test_three_nodes_by_hand():
    """w = λ(3/2, 2, 3/2) until w_1 = 1 at λ = 1/2; then w_0 = w_2 = (λ + 1)/2, which is 3 at λ = 5 and 4 at λ = 7."""
    found = cq.events(cable(1.0, [3.0, 1.0, 4.0]), stop=8.0)
    assert listed(found) == [(0.5, 1, True), (5.0, 0, True), (7.0, 2, True)]
    assert found.contact_at(0.5).tolist() == [False, True, False]
    assert found.contact_at(6.0).tolist() == [True, True, False]
    assert np.isnan(cq.events(cable(1.0, [3.0, 1.0, 4.0]), stop=6.0).full_contact)


def test_a_node_lifts_by_hand():
    """P = λ(1, -1), f = (1, -1/2): R_1 = 3/4 - λ/2 vanishes at λ = 3/2; then w = λ(1, -1)/3, and w_0 = 1 at λ = 3."""
    found = cq.events(cable([1.0, -1.0], [1.0, -0.5]), stop=4.0)
    assert found.contact_at_start.tolist() == [False, True]
    assert listed(found) == [(1.5, 1, False), (3.0, 0, True)]
    assert repr(found).endswith("1 nodes settle, 1 lifts)")
    assert found.to_frame()["event"].tolist() == ["lifts", "settles"]
    assert np.isnan(found.touchdown[1])
    assert found.first_touch == 0.0


def test_nodes_that_touch_together_settle_together():
    """A flat floor under a symmetric net: its nodes settle in orbits."""
    membrane = cq.Membrane(cq.Frame.rectangle(6, 6).lattice(1.0), 1.0, load=1.0, support=1.0)
    found = cq.events(membrane, stop=3.0)
    assert found.load.size == 25
    counts = np.unique(np.round(found.load, 9), return_counts=True)[1]
    assert set(counts.tolist()) <= {1, 4, 8}
    assert found.full_contact == pytest.approx(2.0)  # in a corner Gf = 4 - 1 - 1 = 2


def test_a_net_that_grazes_its_support_from_the_start():
    """Without a load the hexagon touches the summit with no reaction; with any load it rests on it."""
    found = cq.events(cq.gallery.paper_hexagon(1.0), stop=0.1)
    assert found.first_touch == 0.0
    assert (found.settles).all()
    for load in cq.gallery.PAPER_LOADS:
        certificate = cq.solve(cq.gallery.paper_hexagon(load), tol=1e-9).certificate
        np.testing.assert_array_equal(found.contact_at(load), certificate.contact)


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), whole=st.booleans())
@pytest.mark.filterwarnings("ignore:load nowhere presses downwards")
def test_contact_between_events_is_that_of_solutions(seed, whole):
    """Loads of both signs, supports above and below the frame, with ties where all data are whole numbers."""
    rng = np.random.default_rng(seed)
    mask = rng.uniform(size=rng.integers(1, 7, 2)) < 0.8
    mask[0, 0] = True
    lattice = cq.Lattice(mask, 1.0)
    load, support = rng.normal(size=lattice.size), rng.uniform(-0.5, 1.0, lattice.size)
    if whole:
        load, support = np.round(load), np.round(2 * support)
    support[rng.uniform(size=lattice.size) < 0.1] = np.inf
    membrane = cq.Membrane(lattice, 1.0, load=load, support=support)
    found = cq.events(membrane, stop=4.0, start=-4.0)
    assert (np.diff(found.load) >= 0).all()
    for factor in rng.uniform(-4, 4, 8):
        certificate = cq.solve(with_load(membrane, factor), "active-set", tol=1e-11, on_failure="ignore").certificate
        contact = found.contact_at(factor)
        assert not (contact & certificate.clear).any()
        assert not (~contact & certificate.contact).any()


def test_factors_with_a_border_are_as_good_as_new_ones(monkeypatch):
    membrane = cq.gallery.bowl(15)
    with_border = cq.events(membrane, stop=3.0)
    monkeypatch.setattr("contactqp.paths.bordered._MOST_BORDERS", 0)
    anew = cq.events(membrane, stop=3.0)
    np.testing.assert_array_equal(with_border.node, anew.node)
    np.testing.assert_allclose(with_border.load, anew.load, rtol=1e-10)


@pytest.mark.parametrize("stop", [4.0, 1e6, 1e11])
def test_events_do_not_merge_because_the_range_is_long(stop):
    assert listed(cq.events(cable(1.0, [1.0, 2.0]), stop=stop)) == [(1.0, 0, True), (3.0, 1, True)]


def test_one_deep_node_does_not_spoil_the_others():
    deep, none = (cq.events(cable(1.0, [depth, np.inf, np.inf, 2, 3, 2.5]), stop=10) for depth in (1e12, np.inf))
    assert deep.node.tolist() == none.node.tolist() == [3, 4, 5]
    np.testing.assert_allclose(deep.load, none.load, rtol=1e-3)


def test_contact_peels_off_a_flat_floor_node_by_node():
    load = np.zeros(301)
    load[150] = -1.0
    found = cq.events(cable(load, np.zeros(301)), stop=1.0)
    assert found.contact_at_start.sum() == 0


@pytest.mark.parametrize("load", [[1, 1, -2, -1, 2], [-2, 0, -1, -1, 1, 0, 2], [2, 2, 2, -2, -1, -2, 2]])
def test_what_a_node_undoes_at_once_is_no_event(load):
    found = cq.events(cable(np.array(load, dtype=float), np.zeros(len(load))), stop=1.0, start=-1.0)
    pairs = set(zip(found.load.round(12).tolist(), found.node.tolist(), strict=True))
    assert len(pairs) == found.load.size


def test_nothing_happens_where_there_is_no_support():
    found = cq.events(cable(1.0, [np.inf, np.inf]), stop=10.0)
    assert found.load.size == 0
    assert np.isnan(found.first_touch)
    assert np.isnan(found.full_contact)
    assert np.isnan(found.touchdown).all()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"stop": 0.0}, ValueError, "stop must be > start, got start=0, stop=0"),
        ({"stop": np.nan}, ValueError, "stop must be finite"),
        ({"model": 7, "stop": 1.0}, TypeError, "model must be a model, as Membrane, Cable or Beam, got int"),
    ],
)
def test_bad_arguments_say_what_is_wrong(arguments, error, message):
    with pytest.raises(error, match=message):
        cq.events(**({"model": cable(1.0, [1.0])} | arguments))
    with pytest.raises(ValueError, match="load must lie between 0 and 2, got 3"):
        cq.events(cable(1.0, [1.0]), stop=2.0).contact_at(3.0)


def test_nodes_that_leave_and_join_at_once_where_many_have_changed_sides():
    """Two nodes change sides together, one back, when as many have changed as are kept beside the factors."""
    load, support = [-1.0, 6.0], [0.1, 2.0]
    pair = cq.Membrane(cq.Lattice(np.ones((1, 2), dtype=bool), 1.0), 1.0, load=load, support=support)
    tie = cq.events(pair, stop=20.0).load[-1]
    mask = np.zeros((1, 96), dtype=bool)
    mask[0, :94:2] = mask[0, 94:] = True
    alone = np.r_[tie / 4, np.linspace(0.01, 0.2, 46) * tie / 4]
    model = cq.Membrane(cq.Lattice(mask, 1.0), 1.0, load=np.r_[np.ones(47), load], support=np.r_[alone, support])
    settled = cq.events(model, stop=20.0)
    np.testing.assert_allclose(np.sort(settled.load)[:46], np.sort(4 * alone[1:]), rtol=1e-9)
    assert tie in settled.load
