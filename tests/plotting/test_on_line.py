"""Models whose nodes lie in a line are drawn along it, wherever it runs, and not as a strip in plan."""

from typing import Any

import numpy as np
import pytest
from springs import springs

import contactqp as cq
from contactqp.plotting.on_line import ALONG_THE_LINE, line_of, line_through

COUNT = 11
PLACES = np.linspace(0, 5, COUNT)


def chain(direction=(1.0, 0.0), **changes):
    """A cable as a net of segments in a line, whose points are numbered from both ends inwards."""
    order = np.argsort(np.argsort(np.minimum(np.arange(COUNT), COUNT - 1 - np.arange(COUNT)), kind="stable"))
    positions = np.empty((COUNT, 2))
    positions[order] = np.outer(PLACES, direction)
    made = {"tension": 2.0, "load": 0.5, "support": 0.4, "fixed": [0, 1], "fixed_height": [0.0, 0.1]}
    return cq.CableNet(positions, np.column_stack([order[:-1], order[1:]]), **(made | changes))


def curve(axes, label):
    [line] = [line for line in axes.lines if line.get_label() == label]
    x, y = line.get_data()
    return np.asarray(x), np.asarray(y)


@pytest.mark.parametrize(
    ("direction", "label"), [((1.0, 0.0), "x"), ((0.0, 1.0), "y"), ((0.6, 0.8), ALONG_THE_LINE), ((-0.8, 0.6), None)]
)
def test_a_net_in_a_line_is_drawn_along_it(direction, label):
    net = chain(direction)
    solution = cq.solve(net)
    shape, gap, reaction = solution.plot().axes
    assert reaction.get_xlabel() == (label or ALONG_THE_LINE)
    x, heights = curve(shape, "net w")
    known = np.isfinite(x)
    np.testing.assert_allclose(np.unique(x[known].round(9)), PLACES, atol=1e-9)
    np.testing.assert_allclose(np.unique(heights[known]), np.unique(net.point_heights(solution.deflection)))
    assert np.abs(np.diff(x[known].reshape(-1, 2), axis=1)).max() == pytest.approx(0.5)  # no line but the segments
    ends = [x for x, _ in (line.get_data() for line in gap.lines[:1])]
    assert (np.diff(ends[0]) > 0).all()
    assert shape.get_ylim()[0] > shape.get_ylim()[1]


def test_it_is_drawn_like_the_cable_that_it_is():
    cable = cq.Cable(5.0, spacing=0.5, tension=2.0, load=1.0, support=0.4)
    net = chain(fixed_height=0.0, force_density=4.0, tension=None)
    for view in (lambda model: model.plot(), lambda model: cq.solve(model).certificate.plot()):
        assert view(net).get_size_inches().tolist() == view(cable).get_size_inches().tolist()
    frame = [curve(model.plot().axes[0], "frame") for model in (net, cable)]
    np.testing.assert_allclose(*frame)
    [above], [below] = (cq.solve(model).certificate.plot().axes for model in (net, cable))
    assert above.get_ylabel() == below.get_ylabel() == "gap ω"


def test_all_other_pictures_run_along_the_line_too():
    net = chain((0.6, 0.8))
    touchdown = cq.trace(net, loads=[0.5, 1.0, 2.0]).touchdown()
    comparison = cq.compare(net, ["clarabel", "osqp"])
    figures = [net.plot(), touchdown.plot(), cq.solve(net).certificate.plot(), comparison.plot_disagreement()]
    assert [figure.axes[0].get_xlabel() for figure in figures] == [ALONG_THE_LINE] * 4
    assert net.plot(units="m").axes[0].get_xlabel() == f"{ALONG_THE_LINE} (m)"
    assert "Section" in {axes.get_title() for axes in comparison.plot().axes}


def test_an_own_model_in_a_line_has_no_frame_to_draw():
    places = np.column_stack([np.linspace(0, 4, 40)[::-1], np.zeros(40)])
    model = springs(places=places)
    axes = model.plot().axes[0]
    assert "frame" not in {line.get_label() for line in axes.lines}
    x, heights = curve(cq.solve(model).plot().axes[0], "deflection w")
    np.testing.assert_allclose(heights, model.exact[::-1])
    assert (np.diff(x) > 0).all()


def test_loads_of_touchdown_stand_for_every_node_of_which_something_is_known():
    touchdown = cq.trace(chain(), loads=[0.3, 0.6, 1.0]).touchdown()
    axes = touchdown.plot().axes[0]
    known = np.isfinite(touchdown.load)
    np.testing.assert_allclose(np.sort(curve(axes, "middle")[1]), np.sort(touchdown.load[known]))
    above = ~known & np.isfinite(touchdown.clear)
    assert above.any()
    np.testing.assert_allclose(curve(axes, "settles above")[1], touchdown.clear[above])


@pytest.mark.parametrize("upwards", [False, True])
def test_a_film_has_one_scale_for_all_its_pictures(upwards):
    sign = -1.0 if upwards else 1.0
    net = chain((0.6, 0.8), upwards=upwards, fixed_height=[0.0, 0.1 * sign], support=lambda x, y: sign * (0.4 + x / 9))
    film: Any = cq.trace(net, loads=[0.1, 1.0, 5.0]).animate()
    ends = []
    for k in range(3):
        film._func(k)
        ends.append(film._fig.axes[0].get_ylim())
    assert ends[0] == ends[1] == ends[2]
    assert film._fig.get_size_inches().tolist() == [9.0, 4.0]
    lowest = ends[0][0]
    assert sign * lowest > 0.4
    (ground,) = film._fig.axes[0].collections
    assert (sign * ground.get_paths()[0].vertices[:, 1]).max() >= sign * lowest  # it does not end in the air
    film._draw_was_started = True  # it is not to be shown, and matplotlib would warn of that


def test_what_is_no_line_keeps_its_map():
    assert line_of(springs()) is None
    assert (
        line_of(cq.CableNet([[0, 0], [1, 0], [0, 1]], [[0, 1], [0, 2]], 1.0, load=1.0, support=1.0, fixed=[1, 2]))
        is None
    )
    assert line_through(np.zeros(1), np.zeros(1)).label == "x"
