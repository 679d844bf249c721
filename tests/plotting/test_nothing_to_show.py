"""Pictures where there is little to show: no support, two unknowns, one height; and marks that touch an edge."""

import numpy as np
import pytest
from triangulations import rings

import contactqp as cq

LATTICE = cq.Frame.rectangle(2, 1).lattice(0.25)


def texts(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


@pytest.mark.parametrize(
    "model",
    [
        cq.Membrane(LATTICE, 1.0, load=1.0, support=np.inf),
        cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=np.inf),
    ],
)
def test_panels_without_a_support_say_so(model):
    figure = cq.solve(model).plot()
    assert {"no support here, and no gap", "no node touches"} <= set(texts(figure))
    names = [text.get_text() for axes in figure.axes if axes.get_legend() for text in axes.get_legend().get_texts()]
    assert "support f" not in names


def test_unknowns_are_counted_in_whole_numbers():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    comparison = cq.compare(problem, ["psor", "clarabel"])
    for figure in (cq.solve(problem).plot(), comparison.plot_disagreement()):
        axes = figure.axes[0]
        low, high = axes.get_xlim()
        assert [tick for tick in axes.get_xticks() if low <= tick <= high] == [1.0, 2.0]
        assert axes.lines[0].get_marker() == "o"


def test_a_long_headline_stays_within_its_figure():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    title = cq.compare(problem).plot_disagreement().get_suptitle().strip()
    assert "\n" in title
    assert " ".join(title.split()).endswith("(osqp, clarabel, mangasarian, psor, active-set, mprgp)")


def test_the_deflection_of_a_mesh_has_its_unit_and_one_height_no_scale():
    points, triangles = rings(4)
    loaded = cq.solve(cq.MeshMembrane(points, triangles, 1.0, load=1.0, support=0.1)).plot(units="m")
    assert "w, positive downwards (m)" in [axes.get_ylabel() for axes in loaded.axes]
    still = cq.solve(cq.MeshMembrane(points, triangles, 1.0, load=0.0, support=0.1)).plot()
    (bar,) = (axes for axes in still.axes if axes.get_ylabel().startswith("w, "))
    assert bar.get_yticks().tolist() == [0.0]


def test_marks_of_a_path_are_not_cut_off():
    cable = cq.Cable(nodes=9, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    history = cq.march(cable, times=[0.0, 1.0, 2.0], damping=1.0)
    for axes in history.plot().axes:
        values = np.concatenate([line.get_ydata() for line in axes.lines])
        low, high = axes.get_ylim()
        assert low <= values.min()
        assert values.max() <= high - 0.04 * (high - low)
