"""Load paths and events of beams and plates, of which no comparison principle promises anything."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.models.varied import with_load


def over_ripples():
    return cq.Beam(
        10.0,
        spacing=0.25,
        bending_stiffness=1.0,
        load=1.0,
        support=lambda x: 0.5 + 0.1 * np.sin(2 * x),
        ends=("clamped", "pinned"),
    )


def on_two_posts():
    """Loaded on its left half, it comes down to the right post first, and is lifted off that over the middle one."""
    support = np.full(39, np.inf)
    support[19], support[31] = 0.02, 0.008
    load = np.where(np.arange(39) < 19, 1.0, 0.0)
    return cq.Beam(4.0, spacing=0.1, bending_stiffness=1.0, load=load, support=support)


@pytest.mark.parametrize(("make", "count"), [(over_ripples, 28), (on_two_posts, 3)])
def test_events_are_where_single_solutions_change(make, count):
    beam = make()
    found = cq.events(beam, 3.0)
    assert found.load.size == count
    for load in np.linspace(0.021, 2.99, 25):
        np.testing.assert_array_equal(found.contact_at(load), cq.solve(with_load(beam, load)).contact)


def test_a_beam_may_lift_off_as_its_load_grows():
    found = cq.events(on_two_posts(), 1.0)
    assert found.node.tolist() == [31, 19, 31]
    assert found.settles.tolist() == [True, True, False]


@pytest.mark.parametrize("parameter", ["loads", "tensions", "lifts"])
def test_nothing_is_promised_of_what_bends(parameter):
    beam = over_ripples()
    path = cq.trace(beam, **{parameter: [0.5, 1.0, 1.5] if parameter != "lifts" else [0.0, 0.05, 0.1]})
    assert not path.promised
    assert all(solution.status == cq.Status.CERTIFIED for solution in path.solutions)
    for finding in path.findings:
        assert "what bends may rise beside the place where it is pressed down" in finding
    if parameter == "loads":
        with pytest.raises(ValueError, match=r"touchdown loads need .* promised to be monotone, but what bends"):
            path.touchdown()


def test_a_path_that_lifts_off_says_why_that_is_no_mistake():
    beam = on_two_posts()
    found = cq.events(beam, 1.0)
    path = cq.trace(beam, loads=[float(found.load[1]), 1.0])
    assert path.findings
    assert "what bends may rise beside the place where it is pressed down" in path.findings[0]
