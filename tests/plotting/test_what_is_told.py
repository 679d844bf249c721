"""Pictures show what there is, by its name: reactions on the scale of the answer, pits, rows, sections, cuts."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.quiver import Quiver
from matplotlib.text import Annotation

import contactqp as cq
from contactqp.plotting.on_lattice import telling_row
from contactqp.plotting.space import _cut_off

LATTICE = cq.Frame.rectangle(4, 3).lattice(0.25)


def peg(x, y):
    """A peg that holds one node aside of the middle, over ground that is not reached."""
    return np.where((x == 1.0) & (y == 1.0), 0.01, 0.5)


@pytest.fixture(scope="module")
def pegged():
    return cq.solve(cq.Membrane(LATTICE, 1.0, load=0.05, support=peg))


def legend_of(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def bars_of(axes):
    return [float(np.ptp(bar[:, 1])) for lines in axes.collections for bar in lines.get_segments()]


def test_reactions_of_free_nodes_are_not_drawn_and_the_scale_is_that_of_the_whole_answer(pegged):
    _, shape, _, force = pegged.plot(section=0.0).axes
    assert bars_of(force) == []
    assert force.get_ylim()[1] > pegged.reaction.max() > 1e-3
    assert "in contact" not in legend_of(shape)
    free = cq.solve(cq.Membrane(LATTICE, 1.0, load=0.01, support=1.0)).plot().axes[-1]
    assert bars_of(free) == []
    assert list(free.get_yticks()) == [0.0]
    line = cq.solve(cq.Cable(10, spacing=1.0, tension=1.0, load=0.01, support=9.0)).plot().axes[-1]
    assert bars_of(line) == []


def test_the_section_is_one_in_which_something_touches_and_is_marked_in_the_map(pegged):
    plan, shape, _, force = pegged.plot().axes
    assert shape.get_title() == "Section at y = 1"
    assert max(bars_of(force)) == pytest.approx(pegged.reaction.max())
    assert "in contact" in legend_of(shape)
    assert [line.get_ydata()[0] for line in plan.lines][-1] == 1.0
    everywhere = cq.solve(cq.Membrane(LATTICE, 1.0, load=1.0, support=0.05))
    nowhere = cq.solve(cq.Membrane(LATTICE, 1.0, load=0.01, support=1.0))
    for solution in (everywhere, nowhere):
        assert LATTICE.y[telling_row(solution.model, [solution], None)] == 0.0
    assert LATTICE.y[telling_row(pegged.model, [nowhere, pegged], None)] == 1.0


def test_a_reaction_is_a_force_per_node_in_the_units_that_are_told(pegged):
    labels = [pegged.plot(units=units).axes[-1].get_ylabel() for units in ("", "m", {"length": "m", "force": "kN"})]
    plain = "reaction R\n(force per node)"
    assert labels == [plain, plain, "reaction R\n(kN per node)"]


def test_nodes_without_a_support_are_marked_and_counted_in_every_map():
    def pit(x, y):
        return np.where(np.hypot(x, y) < 0.6, np.inf, 0.1)

    membrane = cq.Membrane(LATTICE, 1.0, load=0.5, support=pit)
    net = cq.CableNet.orthogonal(LATTICE, 1.0, load=0.05, support=pit)
    count = int(np.count_nonzero(~membrane.supported))
    for model in (membrane, net):
        solution = cq.solve(model)
        for figure in (solution.plot(), solution.certificate.plot()):
            told = [
                text.get_text() for part in (figure, *figure.subfigs) for each in part.legends for text in each.texts
            ]
            assert f"no support ({count})" in told
        assert f"no support ({count})" in legend_of(model.plot().axes[0])


def test_the_frame_is_joined_by_its_line_and_arrows_are_evenly_spaced():
    tilted = cq.Membrane(LATTICE, 1.0, load=0.3, support=-0.5, frame_height=lambda x, y: 0.1 * x, upwards=True)
    cable = cq.Cable(73, spacing=1.0, tension=1.0, load=1.0, support=-9.0, frame_height=lambda x: 0.1 * x, upwards=True)
    for model, ends in ((tilted, [-0.2, 0.2]), (cable, [0.0, 7.3])):
        axes = next(each for each in model.plot().axes if any(isinstance(c, Quiver) for c in each.get_children()))
        (dotted,) = (line for line in axes.lines if line.get_linestyle() == ":")
        np.testing.assert_allclose(dotted.get_ydata(), ends)
        (arrows,) = (child for child in axes.get_children() if isinstance(child, Quiver))
        steps = np.diff(np.asarray(arrows.X))
        np.testing.assert_allclose(steps, steps[0])
        assert 10 < steps.size + 1 <= 25


def test_rows_of_the_data_are_marked_as_they_were_given():
    support = np.linspace(0.1, 0.5, LATTICE.shape[0])[:, None] * np.ones(LATTICE.shape)
    plan = cq.Membrane(LATTICE, 1.0, load=0.1, support=support, rows="down").plot().axes[0]
    places = {text.get_text(): text.xy[1] for text in plan.texts if isinstance(text, Annotation)}
    assert places["row 0 of\nthe data given"] == LATTICE.y[-1]
    assert places["row 12 of\nthe data given"] == LATTICE.y[0]
    plan = cq.Membrane(LATTICE, 1.0, load=0.1, support=support).plot().axes[0]
    (text,) = (text for text in plan.texts if isinstance(text, Annotation) and text.get_text() == "row 0")
    assert text.xy[1] == LATTICE.y[0]


def test_a_level_support_has_a_scale_of_one_height():
    figure = cq.Membrane(LATTICE, 1.0, load=0.1, support=0.3).plot()
    (bar,) = (axes for axes in figure.axes if axes.get_ylabel().startswith("support f"))
    assert [text.get_text() for text in bar.get_yticklabels()] == ["0.3"]


@pytest.mark.parametrize("upwards", [False, True])
def test_a_deep_support_is_cut_off_at_a_plane_that_is_told(upwards):
    sign = -1.0 if upwards else 1.0
    model = cq.Membrane(
        LATTICE, 1.0, load=0.5, support=lambda x, y: sign * (0.2 + 1.5 * (x**2 + y**2)), upwards=upwards
    )
    title = cq.solve(model).plot3d().get_suptitle()
    assert "The support goes on below " in title
    plane = float(title.split("below ")[1].strip().rstrip("."))
    heights = np.pad(LATTICE.scatter(model.support), 1, constant_values=np.nan)
    assert _cut_off(heights, plane, upwards)
    assert np.nanmax(sign * heights) == sign * plane
    seen = np.isfinite(heights)
    assert 0 < np.count_nonzero(seen) < model.size
    shallow = cq.Membrane(LATTICE, 1.0, load=0.5, support=sign * 0.1, upwards=upwards)
    assert "goes on" not in cq.solve(shallow).plot3d().get_suptitle()


def test_the_picture_of_a_bare_problem_speaks_of_unknowns(pegged):
    figure = cq.solve(pegged.problem).plot(units="m")
    assert f"{pegged.problem.size} unknowns" in figure.get_suptitle()
    assert figure.axes[0].get_ylabel() == "gap ω, R / G_ii (m)"


def test_films_show_one_row_in_which_something_touches(tmp_path, pegged):
    film: Any = cq.trace(pegged.model, loads=[0.5, 1.0]).animate(tmp_path / "film.gif")
    assert film._fig.axes[1].get_title() == "Section at y = 1"


def test_no_axis_runs_to_the_edge_of_a_picture(pegged):
    figure = pegged.plot()
    figure.draw_without_rendering()
    width = figure.bbox.width
    assert all(axes.get_window_extent().x1 < width - 4 for axes in figure.axes)
    plan, legend = figure.axes[0], figure.subfigs[0].legends[0]
    label, below = plan.xaxis.label.get_window_extent(), legend.get_window_extent()
    assert all(lower < upper for lower, upper in pairwise([below.y1, label.y0]))
