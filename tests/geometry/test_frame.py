import numpy as np
import pytest
import shapely

import contactqp as cq
from contactqp.gallery import PAPER_CORNERS


def test_the_papers_hexagon_has_1857_nodes_in_rows_of_17_to_63():
    lattice = cq.Frame.polygon(PAPER_CORNERS).lattice(spacing=1.0)
    rows = lattice.mask.sum(axis=1)
    assert lattice.size == 1857
    assert lattice.shape == (49, 65)
    assert rows[1:-1].tolist() == [*range(17, 64, 2), *range(61, 16, -2)]


@pytest.mark.parametrize("spacing", [1.0, 0.1, 1 / 3, 1e-6, 1e6])
def test_nodes_on_the_contour_belong_to_the_frame_at_every_scale(spacing):
    corners = np.array(PAPER_CORNERS) * spacing
    assert cq.Frame.polygon(corners).lattice(spacing).size == 1857
    assert cq.Frame.rectangle(8 * spacing, 6 * spacing).lattice(spacing).size == 7 * 5
    assert cq.Frame.disk(5 * spacing).lattice(spacing).size == 69  # Gauss circle problem: 81 - 12 on the circle


def test_rectangle_disk_and_hexagon_have_their_areas():
    assert cq.Frame.rectangle(3, 2).area == pytest.approx(6)
    assert cq.Frame.disk(2).area == pytest.approx(4 * np.pi, rel=1e-3)
    assert cq.Frame.hexagon(2).area == pytest.approx(6 * np.sqrt(3))
    fine = cq.Frame.hexagon(1.0).lattice(0.01)
    assert fine.size * 0.01**2 == pytest.approx(1.5 * np.sqrt(3), rel=0.01)


def test_a_net_may_be_shifted():
    with pytest.warns(
        cq.ContactWarning, match="3 x 3 instead of 2 x 2, up to 50% wider; .*; with another origin it fits"
    ):
        lattice = cq.Frame.rectangle(2, 2).lattice(1.0, origin=(0.5, 0.5))
    assert lattice.size == 4
    np.testing.assert_allclose(np.unique(lattice.node_x), [-0.5, 0.5])


def test_holes_unions_and_intersections():
    square = cq.Frame.rectangle(6, 6)
    ring = square - cq.Frame.rectangle(2, 2)
    assert ring.lattice(1.0).size == 25 - 9  # the hole's contour is frame too
    holed = cq.Frame.polygon([(-3, -3), (3, -3), (3, 3), (-3, 3)], holes=[[(-1, -1), (1, -1), (1, 1), (-1, 1)]])
    np.testing.assert_array_equal(ring.lattice(1.0).mask, holed.lattice(1.0).mask)
    two = cq.Frame.rectangle(2, 2, center=(-4, 0)) | cq.Frame.rectangle(2, 2, center=(4, 0))
    assert two.lattice(0.5).parts == 2
    assert (square & cq.Frame.rectangle(2, 20)).lattice(0.5).size == 3 * 11
    assert repr(square - cq.Frame.disk(1)) == "Frame.rectangle(6, 6) - disk(1)"


def test_a_shared_edge_is_no_wall():
    joined = cq.Frame.rectangle(2, 2, center=(1, 0)) | cq.Frame.rectangle(2, 2, center=(3, 0))
    assert joined.lattice(0.5).size == 7 * 3
    square = cq.Frame.rectangle(4, 4)
    assert ((square - cq.Frame.disk(1)) | cq.Frame.disk(1)).lattice(0.5).size == square.lattice(0.5).size


@pytest.mark.parametrize("width", [0.1, 0.3, 0.7, 1.1])
def test_edges_that_meet_but_for_rounding_are_no_walls(width):
    first, second, third = (
        cq.Frame.rectangle(width, width, center=(width / 2 + k * width, width / 2)) for k in range(3)
    )
    joined = first | second | third
    assert joined.lattice(width / 2).size == 5
    assert joined.geometry.geom_type == "Polygon"
    assert joined.area == pytest.approx(3 * width**2)


@pytest.mark.parametrize("offset", [5e6, 1e8])
def test_frames_far_from_the_origin(offset):
    """Map coordinates in metres: nodes on the contour still belong to the frame, and those inside are found."""
    corners = [(offset + x, offset + y) for x, y in ((0, 0), (5, 0), (5, 5), (0, 5))]
    assert cq.Frame.polygon(corners).lattice(0.5, origin=(offset, offset)).size == 81
    center = (offset, offset)
    assert cq.Frame.rectangle(0.6, 0.6, center=center).lattice(0.1, origin=center).size == 25


def test_shapely_geometries_are_taken():
    frame = cq.Frame.from_shapely(shapely.MultiPolygon([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 5, 2)]))
    assert frame.lattice(1.0).size == 2


def test_bad_frames_say_what_is_wrong():
    with pytest.raises(ValueError, match="width must be > 0, got -1"):
        cq.Frame.rectangle(-1, 2)
    with pytest.raises(ValueError, match="radius must be finite, got nan"):
        cq.Frame.disk(float("nan"))
    with pytest.raises(ValueError, match="at least 3 corners, got 2"):
        cq.Frame.polygon([(0, 0), (1, 1)])
    with pytest.raises(ValueError, match=r"corners\[1\] must be a pair"):
        cq.Frame.polygon([(0, 0), (1, 1, 1), (0, 1)])
    with pytest.raises(ValueError, match="Self-intersection"):
        cq.Frame.polygon([(0, 0), (1, 1), (1, 0), (0, 1)])
    with pytest.raises(TypeError, match="Polygon or MultiPolygon, got Point"):
        cq.Frame.from_shapely(shapely.Point(0, 0))
    with pytest.raises(ValueError, match="encloses no area"):
        cq.Frame.rectangle(1, 1) - cq.Frame.rectangle(2, 2)
    with pytest.raises(ValueError, match="no lattice point of spacing 2"):
        cq.Frame.rectangle(1, 1).lattice(2.0, origin=(0.9, 0.9))
    with pytest.raises(ValueError, match="spacing must be > 0, got 0"):
        cq.Frame.rectangle(1, 1).lattice(0)


@pytest.mark.parametrize(
    ("width", "height", "spacing", "center"),
    [
        (3, 3, 1.0, (0, 0)),
        (5, 4, 1.0, (0, 0)),
        (1, 1, 1 / 3, (0.5, 0.5)),
        (0.7, 0.3, 0.1, (5.05, -3.3)),
        (9, 4, 0.5, (1, 7)),
    ],
)
def test_a_rectangle_fits_where_the_spacing_divides_its_sides(width, height, spacing, center):
    lattice = cq.Frame.rectangle(width, height, center).lattice(spacing)
    columns, rows = round(width / spacing) - 1, round(height / spacing) - 1
    assert lattice.size == columns * rows
    assert lattice.overshoot == 0
    assert lattice.node_x.min() == pytest.approx(center[0] - width / 2 + spacing)
    assert lattice.node_x.max() == pytest.approx(center[0] + width / 2 - spacing)
    assert lattice.node_y.min() == pytest.approx(center[1] - height / 2 + spacing)
    assert "outside" not in repr(lattice)


def test_a_membrane_on_a_rectangle_is_as_wide_as_the_rectangle():
    """Of a strip of width 3 under p = 1, T = 1 the deflection is x(3 - x)/2 at the nodes: 1 at both inner ones."""
    strip = cq.Membrane(cq.Frame.rectangle(3, 600).lattice(1.0), 1.0, load=1.0, support=np.inf)
    deflection = strip.lattice.scatter(cq.solve(strip).deflection)
    np.testing.assert_allclose(deflection[300, 1:-1], [1.0, 1.0], rtol=1e-6)


def test_lattices_that_fitted_before_stay_as_they_were():
    for frame, spacing in ((cq.Frame.polygon(PAPER_CORNERS), 1.0), (cq.Frame.rectangle(4, 4), 4 / 32)):
        default, told = frame.lattice(spacing), frame.lattice(spacing, origin=(0.0, 0.0))
        assert default.origin == told.origin
        np.testing.assert_array_equal(default.mask, told.mask)
        assert default.overshoot == 0
    for frame, spacing in ((cq.Frame.disk(1.0), 0.04), (cq.Frame.hexagon(1.0), 0.01)):
        assert frame.lattice(spacing).origin == frame.lattice(spacing, origin=(0.0, 0.0)).origin


@pytest.mark.parametrize(("spacing", "wider", "fitting"), [(0.3, "20%", "0.25 or 0.5"), (0.7, "40%", "0.5")])
def test_a_frame_that_grows_is_loud_and_names_spacings_that_fit(spacing, wider, fitting):
    with pytest.warns(
        cq.ContactWarning, match=rf"instead of 1 x 1, up to {wider} wider; .*; fitting spacings: {fitting}$"
    ) as w:
        lattice = cq.Frame.rectangle(1, 1).lattice(spacing)
    assert w[0].filename == __file__
    assert lattice.caution == str(w[0].message)
    membrane = cq.Membrane(lattice, 1.0, load=0.01, support=1.0)
    assert cq.solve(membrane).cautions == (lattice.caution,)
    assert f"caution     {lattice.caution}" in repr(cq.solve(membrane))


def test_a_disk_tells_how_far_the_frame_lies_outside_of_it():
    lattice = cq.Frame.disk(1.0).lattice(0.25)
    padded = np.pad(lattice.mask, 1)
    beside = np.zeros_like(padded)
    for axis in (0, 1):
        for step in (-1, 1):
            beside |= np.roll(padded, step, axis)
    x, y = lattice.ring_coordinates(*np.nonzero(beside & ~padded))
    assert lattice.overshoot == pytest.approx(np.hypot(x, y).max() - 1, abs=1e-3 * 0.25)
    assert repr(lattice) == "Lattice(45 nodes in 9 x 9, spacing=0.25, up to 0.12 outside its contour)"
    assert cq.Frame.polygon([(0, 0), (1, 0), (0, 1)]).lattice(0.25).overshoot == 0
    assert cq.Lattice.from_mask(np.ones((2, 2), bool), 1.0).overshoot == 0


def test_hopeless_spacings_are_refused():
    with pytest.raises(
        ValueError, match=r"spacing 10 lies inside Frame.rectangle\(4, 2\); choose a spacing well below 2"
    ):
        cq.Frame.rectangle(4, 2).lattice(10.0)
    with pytest.raises(ValueError, match="spacing 1 lies inside"):
        cq.Frame.rectangle(1, 1).lattice(1.0)
    assert cq.Frame.rectangle(2, 2).lattice(1.0).size == 1


def test_the_spacing_that_is_suggested_fits_as_it_is_written():
    with pytest.warns(cq.ContactWarning, match="fitting spacings") as told:
        cq.Frame.rectangle(6, 4).lattice(0.68)
    for text in str(told[0].message).split("fitting spacings: ")[1].split(" or "):
        assert cq.Frame.rectangle(6, 4).lattice(float(text)).overshoot == 0.0
