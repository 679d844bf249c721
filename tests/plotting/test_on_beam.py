"""Pictures of beams."""

import numpy as np
import pytest

import contactqp as cq

matplotlib = pytest.importorskip("matplotlib")


@pytest.fixture
def on_floor():
    beam = cq.Beam(10.0, spacing=0.1, bending_stiffness=1.0, load=1.0, support=0.5)
    return beam, cq.solve(beam)


def test_an_answer_shows_shape_moment_shear_and_reactions(on_floor):
    beam, solution = on_floor
    figure = solution.plot(units={"length": "m", "force": "kN"})
    shape, bending, shear, reaction = figure.axes
    assert "positive downwards" in shape.get_ylabel()
    assert bending.get_ylabel() == "moment M,\nsagging > 0 (kN m)"
    assert shear.get_ylabel() == "shear V (kN)"
    forces = beam.internal_forces(solution.gap)
    np.testing.assert_array_equal(bending.lines[0].get_ydata(), forces.moment)
    assert bending.yaxis_inverted()
    np.testing.assert_array_equal(shear.lines[0].get_ydata(), forces.shear)
    told = [float(text.get_text()) for text in reaction.texts]
    force = beam.spans(solution)["force_at_start"][1]
    assert told == pytest.approx([force, force], rel=5e-3)
    figure.canvas.draw()


def test_nothing_is_told_of_touchdowns_where_there_are_none():
    beam = cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=np.inf, ends="clamped")
    figure = cq.solve(beam).plot()
    assert [text.get_text() for text in figure.axes[-1].texts] == ["no node touches"]
    figure.canvas.draw()


@pytest.mark.parametrize("ends", [("clamped", "free"), "free"])
def test_free_ends_are_drawn_as_nodes(ends):
    beam = cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=0.3, ends=ends, foundation=0.5)
    solution = cq.solve(beam)
    for figure in (beam.plot(), solution.plot(), solution.certificate.plot()):
        figure.canvas.draw()
    curve = solution.plot().axes[0].lines[0]
    x, heights = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
    assert x[np.isfinite(heights)].max() == 4.0


def test_a_beam_before_it_is_solved_shows_what_varies():
    beam = cq.Beam(4.0, spacing=0.5, bending_stiffness=lambda x: 1 + x, load=1.0, support=0.3)
    figure = beam.plot()
    assert [axes.get_ylabel() for axes in figure.axes][-1] == "bending_stiffness"
    figure.canvas.draw()


def test_pictures_of_load_paths_and_comparisons(on_floor):
    beam, _ = on_floor
    comparison = cq.compare(beam, ["active-set", "clarabel"])
    comparison.plot().canvas.draw()
    path = cq.trace(beam, loads=[0.5, 1.0])
    path.plot().canvas.draw()
