"""Pictures of ceilings, of tension that varies and of foundations."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.legend import Legend

import contactqp as cq

LATTICE = cq.Frame.rectangle(4.0, 3.0).lattice(0.25)
MEMBRANE = cq.Membrane(
    LATTICE,
    (lambda x, y: 2 + x / 4, 1.0),
    load=lambda x, y: np.where(x < 0, 1.0, -1.0),
    support=0.1,
    ceiling=-0.08,
    foundation=lambda x, y: 1 + x**2,
)
CABLE = cq.Cable(
    10.0, spacing=0.25, tension=lambda x: 1 + x, load=lambda x: np.where(x < 5, 1.0, -1.0), support=-0.5, ceiling=0.4,
    upwards=True,
)  # fmt: skip
NET = cq.CableNet.orthogonal(
    LATTICE, 1.0, load=lambda x, y: np.where(x < 0, 0.1, -0.1), support=0.1, ceiling=-0.08, foundation=0.1
)


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def labels(axes):
    return [text.get_text() for legend in axes.findobj(Legend) for text in legend.get_texts()]


@pytest.mark.parametrize("model", [MEMBRANE, CABLE], ids=["membrane", "cable"])
def test_sections_have_both_surfaces(model):
    solution = cq.solve(model)
    assert solution.contact_lower.any()
    assert solution.contact_upper.any()
    figure = solution.plot()
    told = labels(figure)
    assert {"support f", "ceiling c", "in contact", "at the upper bound", "up to the ceiling"} <= set(told)
    figure.draw_without_rendering()
    section = next(axes for axes in figure.axes if axes.get_ylabel().startswith("height"))
    low, high = sorted(section.get_ylim())
    drawn = np.concatenate([solution.deflection, model.support, model.ceiling])
    assert low < drawn.min()
    assert drawn.max() < high


def test_maps_have_three_colours():
    figure = cq.solve(MEMBRANE).plot()
    told = labels(figure)
    assert any(text.startswith("certainly in contact (") for text in told)
    assert any(text.startswith("certainly at the upper bound (") for text in told)
    assert any(text.startswith("certainly clear (") for text in told)


def test_before_solving_tension_and_foundation_are_drawn_along_the_section():
    figure: Any = MEMBRANE.plot()
    assert {"tension_x", "foundation"} <= {axes.get_ylabel() for axes in figure.axes}
    assert "tension_x 1.562 to 2.438, tension_y 1, foundation 1 to 4.062" in figure._suptitle.get_text()
    tension = next(axes for axes in figure.axes if axes.get_ylabel() == "tension_x")
    np.testing.assert_allclose(tension.lines[0].get_ydata(), 2 + tension.lines[0].get_xdata() / 4)
    assert "tension" in {axes.get_ylabel() for axes in CABLE.plot().axes}
    plain = cq.Membrane(LATTICE, 1.0, load=1.0, support=0.1, foundation=2.0)
    assert not {"tension", "foundation"} & {axes.get_ylabel() for axes in plain.plot().axes}
    both = cq.Membrane(LATTICE, (lambda x, y: 2 + x / 4, lambda x, y: 3 + x / 4), load=1.0, support=0.1)
    assert {"along x", "along y"} <= set(labels(both.plot()))


def test_views_in_space_have_both_surfaces():
    axes = cq.solve(MEMBRANE).plot3d().axes[0]
    assert len(axes.collections) == 4  # membrane, support, ceiling and frame
    assert "ceiling c at nodes" in labels(cq.solve(NET).plot())
    assert NET.plot() is not None
