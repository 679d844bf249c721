"""Pictures before solving, sections and units, own axes, views in space, and films."""

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from PIL import Image

import contactqp as cq
from contactqp.foundation.pictures import Wanted, drawn


@pytest.fixture(scope="module")
def membrane():
    lattice = (cq.Frame.rectangle(6, 4) - cq.Frame.disk(1.0)).lattice(spacing=0.5)
    return cq.Membrane(
        lattice, tension=1.0, load=lambda x, y: x, support=lambda x, y: np.where(x > 2.0, np.inf, 0.3 + 0.1 * y)
    )


@pytest.fixture(scope="module")
def solution(membrane):
    return cq.solve(membrane)


def texts(axes):
    return [text.get_text() for text in axes.texts]


def arrows_of(figure):
    (arrows,) = (child for axes in figure.axes for child in axes.get_children() if isinstance(child, Quiver))
    return arrows


def test_a_model_shows_its_support_its_rows_and_where_there_is_none(membrane):
    figure = membrane.plot()
    plan = figure.axes[0]
    assert {"row 0", "row 8", "column 0", "column 12"} <= set(texts(plan))
    row = next(text for text in plan.texts if text.get_text() == "row 0")
    assert row.xy[1] == membrane.lattice.y[0]
    assert "no support" in plan.get_legend().get_texts()[0].get_text()
    np.testing.assert_allclose(plan.collections[0].get_array().min(), membrane.support.min())


def test_arrows_point_where_the_load_does(membrane):
    figure = membrane.plot(section=1.5)
    arrows = arrows_of(figure)
    axes = arrows.axes
    assert axes.yaxis_inverted()
    down = np.asarray(arrows.V)
    load = np.asarray(arrows.X)  # the load is x
    assert (np.sign(down) == np.sign(load)).all()
    np.testing.assert_allclose(down / down.max(), load / load.max(), atol=1e-12)
    assert "Section at y = 1.5" in axes.get_title()


def test_a_cable_shows_frame_support_and_load():
    with pytest.warns(cq.ContactWarning, match="check the signs of load and support"):
        cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=-1.0, support=2.0)
    figure = cable.plot(units={"length": "m", "force": "kN"})
    (axes,) = figure.axes
    assert (np.asarray(arrows_of(figure).V) < 0).all()
    assert axes.get_xlabel() == "x (m)"
    assert axes.get_ylabel() == "height, positive downwards (m)"
    assert axes.get_title() == "Cable, 9 nodes, load 1 (kN/m) upwards"


def test_frames_lattices_and_nets_have_pictures(membrane):
    frame = cq.Frame.disk(1.0) - cq.Frame.disk(0.3)
    axes = frame.plot(units="mm").axes[0]
    assert axes.get_ylabel() == "y (mm)"
    assert len(axes.patches[0].get_path().to_polygons()) == 2
    axes = membrane.lattice.plot(title="").axes[0]
    assert axes.get_title() == ""
    assert len(axes.collections[1].get_offsets()) == membrane.lattice.size
    assert len(axes.collections[0].get_offsets()) == (~membrane.lattice.mask).sum()
    net = cq.CableNet.orthogonal(membrane.lattice, tension=1.0, load=1.0, support=0.4)
    assert "CableNet" in net.plot().axes[0].get_title()


def test_nothing_is_solved_for_a_picture(monkeypatch):
    lattice = cq.Frame.rectangle(3, 3).lattice(spacing=0.5)
    fresh = cq.Membrane(lattice, tension=1.0, load=0.0, support=np.inf)
    monkeypatch.setattr("contactqp.solving.solution.Solution.by", None)
    assert fresh.plot().axes
    assert fresh.plot3d().axes


def test_axes_of_ones_own_are_drawn_into(membrane, solution):
    figure = Figure(figsize=(9, 3))
    axes = figure.subplots(1, 3)
    cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    assert membrane.plot(ax=axes[0]) is figure
    assert solution.plot(ax=axes[1], title="mine", units="m") is figure
    assert cq.solve(cable).plot(axes[2]) is figure
    assert axes[1].get_title() == "mine"
    assert axes[1].get_xlabel() == "x (m)"
    assert axes[1].get_legend() is not None
    assert figure.legends == []
    assert axes[2].yaxis_inverted()


def test_a_section_is_the_row_nearest_to_where_it_is_wanted(solution, membrane):
    figure = solution.plot(section=1.3, units="m", title="T")
    titles = [axes.get_title() for axes in figure.axes]
    assert "Section at y = 1.5, the row nearest to 1.3" in titles
    assert "Section at y = 1.5" in [axes.get_title() for axes in solution.plot(section=1.5).axes]
    assert figure.get_suptitle().strip() == "T"
    with pytest.raises(ValueError, match="section must lie between y = -2 and 2, got 9"):
        membrane.plot(section=9.0)
    with pytest.raises(ValueError, match="units must be of 'length' and 'force', got 'mass'"):
        membrane.plot(units={"mass": "kg"})


def test_views_in_space_show_contact(solution, membrane):
    for figure in (membrane.plot3d(), solution.plot3d(), solution.plot(kind="surface", title="T")):
        axes = figure.axes[0]
        assert axes.name == "3d"
        low, high = axes.get_zlim()
        assert low > high  # heights are positive downwards
    with pytest.raises(ValueError, match="kind must be one of 'map', 'surface'"):
        solution.plot(kind="surfaces")
    with pytest.raises(TypeError, match="needs a Membrane"):
        cq.solve(solution.problem).plot3d()
    with pytest.raises(TypeError, match="axes in space"):
        solution.plot3d(Figure().subplots())
    with pytest.raises(TypeError, match="no picture in space of a Cable"):
        cq.Cable(span=4.0, spacing=1.0, tension=1.0, load=1.0, support=2.0).plot3d()


def test_what_has_no_picture_says_so():
    with pytest.raises(TypeError, match="no picture of a float"):
        drawn(3.0, Wanted())


def test_a_film_has_a_picture_for_each_load(tmp_path):
    cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    path = cq.trace(cable, loads=[0.1, 0.5, 1.0])
    film: Any = path.animate(tmp_path / "film.gif", seconds=0.2, title="cable")
    gif: Any
    with Image.open(tmp_path / "film.gif") as gif:
        assert gif.n_frames == 3
        assert gif.info["duration"] == 200
    assert film._fig.get_suptitle() == "cable: load 1"
    path.animate(tmp_path / "film.html")
    assert "data:image/png;base64" in (tmp_path / "film.html").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match="cannot write the film"):
        path.animate(tmp_path / "missing" / "film.gif")
    with pytest.raises(ValueError, match="seconds must be > 0"):
        path.animate(tmp_path / "film.gif", seconds=0.0)


@pytest.mark.slow
def test_a_film_of_a_membrane_shows_map_and_section(tmp_path, membrane):
    cq.trace(membrane, loads=[0.5, 1.0]).animate(tmp_path / "film.gif", section=1.0, units="m")
    gif: Any
    with Image.open(tmp_path / "film.gif") as gif:
        assert gif.n_frames == 2


def test_a_path_can_be_drawn_into_axes_of_ones_own():
    cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    path = cq.trace(cable, loads=[0.1, 1.0])
    axes = Figure().subplots()
    path.plot(axes, title="mine")
    assert axes.get_title() == "mine"
    np.testing.assert_allclose(axes.lines[0].get_ydata(), path.contact_fraction)
    labels = [each.get_ylabel() for each in path.plot(units={"length": "m", "force": "kN"}).axes]
    assert "deflection of the lowest node (m)" in labels
    assert "total reaction (kN)" in labels


def test_elevations_are_drawn_the_right_way_up():
    """The same membrane with heights downwards and upwards: the pictures show the same, with other numbers."""
    lattice = cq.Frame.rectangle(2.0, 1.0).lattice(0.1)

    def sides(upwards):
        sense = -1.0 if upwards else 1.0
        model = cq.Membrane(
            lattice, 1.0, load=2.0, support=lambda x, y: sense * (0.1 + 0.05 * x), upwards=upwards, frame_height=0.0
        )
        figure = model.plot()
        section = figure.axes[1]
        bottom, top = section.get_ylim()
        tip = arrows_of(figure)
        assert (np.sign(np.asarray(tip.V)) == np.sign(bottom - top)).all()  # the load points down
        assert f"positive {'upwards' if upwards else 'downwards'}" in section.get_ylabel()
        axes: Any = model.plot3d().axes[0]
        space = axes.get_zlim()
        answer = cq.solve(model).plot(units="m").axes[1]
        assert answer.get_ylabel() == f"height,\npositive {'upwards' if upwards else 'downwards'} (m)"
        return [sense * np.array(limits) for limits in ((bottom, top), space, answer.get_ylim())]

    np.testing.assert_allclose(sides(upwards=True), sides(upwards=False), atol=1e-12)


def test_maps_of_nodes_in_a_line_have_room_for_marks():
    places = np.column_stack([np.arange(6.0), np.zeros(6)])
    net = cq.CableNet(places, [(k, k + 1) for k in range(5)], 1.0, load=1.0, support=1.0, fixed=[0, 5])
    grid = cq.CableNet.orthogonal(cq.Frame.rectangle(3, 3).lattice(1.0), 1.0, load=1.0, support=0.2)
    for model, expected in ((net, "auto"), (grid, 1.0)):
        touchdown = cq.trace(model, loads=[0.2, 0.5, 1.0]).touchdown(width=0.05)
        assert touchdown.plot().axes[0].get_aspect() == expected


def test_films_of_unknown_suffixes_are_refused_and_sections_keep_their_scale(tmp_path):
    cable = cq.Cable(span=20.0, spacing=1.0, tension=100.0, load=1.0, support=-80.5, frame_height=-79.5, upwards=True)
    path = cq.trace(cable, loads=[0.1, 1.0, 2.0])
    with pytest.raises(ValueError, match=r"unknown suffix '\.xyz'; known: \.gif \.html"):
        path.animate(tmp_path / "film.xyz")
    film: Any = path.animate(tmp_path / "film.html")
    bottom, top = film._fig.axes[-1].get_ylim()
    assert -81.0 < bottom < -80.5 < -79.5 < top < -79.0
