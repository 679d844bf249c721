"""Nodes at the upper bound have a colour of their own, and a line in the legend where there are any."""

import numpy as np
import pytest
from ceilings import models_under_ceilings
from matplotlib.colors import to_rgba

import contactqp as cq
from contactqp.models.records import NodeState
from contactqp.plotting.on_net import _segment_states
from contactqp.plotting.states import STATE_COLOURS, colours_by_number, labels_of_states, seen
from contactqp.plotting.style import CONTACT_UPPER

MODELS = models_under_ceilings()


def legend_of(figure):
    parts = [figure, *figure.subfigs]
    return {text.get_text() for part in parts for legend in part.legends for text in legend.get_texts()}


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_a_legend_counts_the_nodes_at_each_bound(model):
    certificate = cq.solve(model).certificate
    lower, upper = int(certificate.contact_lower.sum()), int(certificate.contact_upper.sum())
    assert min(lower, upper, certificate.clear.sum()) >= 2
    assert not certificate.undecided.any()
    assert {
        f"certainly clear ({model.size - lower - upper})",
        f"certainly in contact ({lower})",
        f"certainly at the upper bound ({upper})",
    } <= legend_of(certificate.plot())
    rough = cq.certify(model, np.full(model.size, 0.1), effort="fast")
    assert f"undecided ({rough.undecided.sum()})" in legend_of(rough.plot())


def test_one_sided_legends_name_no_upper_bound():
    for model in (cq.gallery.islands(), cq.gallery.cable_on_floor(9, 2)[0]):
        assert not any("upper" in text for text in legend_of(cq.solve(model).certificate.plot()))


def test_each_state_has_a_colour_of_its_own():
    colours, low, high = colours_by_number()
    for state in NodeState:
        assert colours((state - low) / (high - low)) == to_rgba(STATE_COLOURS[state])
    assert len(set(STATE_COLOURS.values())) == len(NodeState)


def test_dots_of_a_net_at_the_upper_bound():
    net = MODELS[2]
    solution = cq.solve(net)
    axes = solution.plot().subfigs[0].axes[0]
    (dots,) = (
        dots
        for dots in axes.collections
        if len(dots.get_offsets()) > 1 and np.all(dots.get_facecolor() == to_rgba(CONTACT_UPPER))
    )
    expected = net.positions[net.free][solution.certificate.contact_upper]
    np.testing.assert_array_equal(dots.get_offsets(), expected)


def test_a_segment_is_in_contact_if_the_same_bound_holds_both_ends():
    chain = cq.CableNet(
        np.column_stack([np.arange(6.0), np.zeros(6)]),
        np.column_stack([np.arange(5), np.arange(1, 6)]),
        1.0,
        load=1.0,
        support=0.1,
        fixed=[0, 5],
    )
    for states, segments in (
        ([1, 1, 2, 2], [0, 1, 0, 2, 0]),
        ([0, 1, -1, 2], [0, 0, -1, -1, 0]),
    ):
        assert _segment_states(chain, np.array(states)).tolist() == segments


class Uncertified:
    """What a picture reads of an answer without a certificate."""

    certificate = None
    contact = np.array([True, True, False])
    contact_upper = np.array([False, True, False])


def test_without_a_certificate_nodes_are_free_and_not_clear():
    state, proven = seen(Uncertified())
    assert list(labels_of_states(state, proven).values()) == [
        "free (1)",
        "in contact (1)",
        "at the upper bound (1)",
    ]
