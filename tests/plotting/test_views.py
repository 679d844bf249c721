"""Pictures, datasets and paths of a kind of model that registers nothing, and of one that registers its own."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from springs import Springs, springs

import contactqp as cq
from contactqp.models.cable import Cable
from contactqp.models.cable_net import CableNet
from contactqp.models.membrane import Membrane
from contactqp.plotting import views

MODEL = springs()
SOLUTION = cq.solve(MODEL)


def legend_of(figure):
    return {text.get_text() for legend in figure.legends for text in legend.get_texts()}


def test_an_unknown_kind_of_model_is_drawn_node_by_node():
    np.testing.assert_allclose(SOLUTION.deflection, MODEL.exact, rtol=1e-12)
    contact = int((MODEL.exact == MODEL.support).sum())
    for figure in (SOLUTION.plot(), SOLUTION.certificate.plot()):
        assert legend_of(figure) == {f"certainly clear ({40 - contact})", f"certainly in contact ({contact})"}
        (axes,) = figure.axes
        drawn = np.concatenate([dots.get_offsets() for dots in axes.collections])
        assert {tuple(place) for place in drawn} == {tuple(place) for place in MODEL.places}


def test_answers_for_an_unknown_kind_are_compared_in_plan():
    comparison = cq.compare(MODEL, ["clarabel", "active-set"], tol=1e-3)
    titles = {axes.get_title() for axes in comparison.plot().axes}
    assert "Contact map" in titles
    plan, bar = comparison.plot_disagreement().axes
    assert bar.get_ylabel() == "difference of gaps (length)"
    np.testing.assert_array_equal(plan.collections[0].get_offsets(), MODEL.places)
    np.testing.assert_array_equal(
        plan.collections[0].get_array(), np.maximum(comparison.spread, comparison.spread.max() * 1e-6)
    )


def test_loads_of_an_unknown_kind_are_followed(tmp_path):
    path = cq.trace(MODEL, loads=[0.5, 1.0, 2.0], checkpoint=tmp_path / "path.nc")
    touchdown = path.touchdown(width=0.01)
    exact = MODEL.stiffness * MODEL.support / MODEL.load
    between = (exact > 0.5) & (exact < 2.0)
    assert between.sum() > 10
    np.testing.assert_allclose(touchdown.load[between], exact[between], atol=0.005)
    known, *_ = (dots for dots in touchdown.plot().axes[0].collections if dots.get_array() is not None)
    np.testing.assert_array_equal(known.get_offsets(), MODEL.places[between])
    again = cq.trace(MODEL, loads=[0.5, 1.0, 2.0], checkpoint=tmp_path / "path.nc")
    assert all(solution.note == "restored from path.nc" for solution in again.solutions)
    with pytest.raises(ValueError, match="belongs to another model"):
        cq.trace(springs(seed=1), loads=[0.5], checkpoint=tmp_path / "path.nc")


def test_the_dataset_of_an_unknown_kind_has_one_dimension():
    data = SOLUTION.to_dataset()
    assert dict(data.sizes) == {"node": 40}
    np.testing.assert_array_equal(data["x"], MODEL.node_x)
    assert data["y"].attrs == {"units": "length"}
    assert data["contact_pressure"].attrs["units"] == "force per area"


class MarkedSprings(Springs):
    """Draws answers in its own way."""


@views.draw_answer.register(MarkedSprings)
def _draw_answer(model, part, solution):
    part.subplots().set_title("drawn by springs")


def test_a_kind_of_model_registers_its_own_pictures():
    model = MarkedSprings(MODEL.places, MODEL.stiffness, MODEL.load, MODEL.support)
    assert [axes.get_title() for axes in cq.solve(model).plot().axes] == ["drawn by springs"]
    titles = {axes.get_title() for axes in cq.compare(model, ["clarabel"]).plot().axes}
    assert "drawn by springs" in titles
    assert "Contact map" in {axes.get_title() for axes in SOLUTION.plot().axes}


@pytest.mark.parametrize(
    "view", [views.answer_figure, views.certificate_figure, views.values_figure, views.settling_figure]
)
def test_a_subclass_is_drawn_as_the_class_above_it(view):
    for kind in (Membrane, Cable, CableNet):
        assert view.dispatch(type("Own", (kind,), {})) is view.dispatch(kind)


@pytest.mark.parametrize("view", [views.answer_figure, views.draw_answer])
def test_a_bare_problem_is_drawn_as_no_model_is(view):
    assert view.dispatch(cq.ContactQP) is not view.dispatch(Springs)
    figure = cq.solve(MODEL.problem).plot()
    assert isinstance(figure, Figure)
    assert [axes.get_title() for axes in figure.axes] == ["Gap and reaction"]
