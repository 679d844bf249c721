"""Fields and masks by the labels of pandas and xarray, and frames from other people's geometries."""

import json
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
import shapely
import xarray as xr

import contactqp as cq

LATTICE = cq.Frame.polygon([(0, 0), (4, 0), (4, 3), (0, 3)]).lattice(0.5)
X, Y = LATTICE.node_x, LATTICE.node_y
VALUES = 1 + X + 10 * Y
GRID = LATTICE.scatter(VALUES, fill=0.0)


def array(**changes):
    given = {"coords": {"y": LATTICE.y, "x": LATTICE.x}, "dims": ("y", "x")} | changes
    return xr.DataArray(GRID, **given)


def table():
    return pd.DataFrame({"x": X, "y": Y, "load": VALUES}).sample(frac=1.0, random_state=1)


LOADS = {
    "list": VALUES.tolist(),
    "nested list": GRID.tolist(),
    "float32": VALUES.astype(np.float32),
    "integers": VALUES.astype(np.int32),
    "series": pd.Series(VALUES),
    "series by numbers": pd.Series(VALUES).sample(frac=1.0, random_state=1),
    "series by names": pd.Series(VALUES, index=[f"n{k}" for k in range(VALUES.size)]),
    "series by places": table().set_index(["y", "x"])["load"],
    "nullable series": pd.Series(VALUES, dtype="Float64"),
    "table without labels": pd.DataFrame(GRID),
    "table by labels": pd.DataFrame(GRID, index=LATTICE.y, columns=LATTICE.x),
    "table by labels that go down": pd.DataFrame(GRID, index=LATTICE.y, columns=LATTICE.x).iloc[::-1],
    "table of places": table(),
    "table of more places": pd.concat([table(), pd.DataFrame({"x": [9.0], "y": [9.25], "load": [0.0]})]),
    "array": array(),
    "array that goes down": array()[::-1],
    "array turned": array().T,
    "array with a band": array().expand_dims("band"),
    "array by other names": array().rename(x="easting", y="northing"),
    "array by axes": xr.DataArray(
        GRID,
        {"v": ("v", LATTICE.y, {"axis": "Y"}), "u": ("u", LATTICE.x, {"standard_name": "projection_x_coordinate"})},
        ("v", "u"),
    ),
    "array along nodes": xr.DataArray(VALUES, dims="node"),
    "wider array": array().pad(x=2, y=2, constant_values=0).assign_coords(
        x=np.arange(-2, 11) * 0.5, y=np.arange(-2, 9) * 0.5
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LOADS)
def test_values_go_to_the_nodes_that_their_labels_say(name):
    given = LOADS[name]
    kept = given.copy() if hasattr(given, "copy") else None
    membrane = cq.Membrane(LATTICE, 1.0, load=given, support=0.1)
    expected = VALUES.astype(given.dtype) if name in ("float32", "integers") else VALUES
    np.testing.assert_array_equal(membrane.load, expected)
    if isinstance(given, (pd.DataFrame, pd.Series, xr.DataArray)):
        assert kept is not None
        assert kept.equals(given)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (array()[:5], "load does not cover the lattice: its y goes from 0 to 2, and 0 to 3 is needed"),
        (array().isel(x=slice(2, None)), "its x goes from 1 to 4, and 0 to 4 is needed"),
        (
            array()[:, ::2],
            r"no value at some of x = 0, ..., 4 .*lie between its own; interpolate it: profiles\.Gridded",
        ),
        (array().rename(x="lon", y="lat"), r"must have the dims \('y', 'x'\), got \('lat', 'lon'\)"),
        (table().iloc[1:], "load has no value at node .* and 0 other nodes; interpolate it"),
        (table().assign(x=table()["x"] + 0.1), "its points lie between the nodes"),
        (pd.concat([table(), table()]), "load has 2 values at x = 0.5, y = 0.5; leave one"),
        (table().rename(columns={"load": "p"}).assign(q=1.0), "one more column, or one 'load': p, q"),
        (pd.DataFrame(GRID, index=LATTICE.y + 9, columns=LATTICE.x), "its y goes from 9 to 12, and 0 to 3 is needed"),
    ],
)
def test_labels_that_do_not_fit_say_which(given, told):
    with pytest.raises(ValueError, match=told):
        cq.Membrane(LATTICE, 1.0, load=given, support=0.1)


def test_a_net_takes_values_by_coordinates():
    positions = [[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]]
    segments = [[0, 1], [0, 2], [0, 3], [0, 4]]
    ground = xr.DataArray(np.arange(9.0).reshape(3, 3), {"y": [-1, 0, 1], "x": [-1, 0, 1]}, ("y", "x"))
    net = cq.CableNet(positions, segments, 1.0, load=1.0, support=ground, fixed=[1, 2, 3, 4], fixed_height=ground)
    assert net.support.tolist() == [4.0]
    assert net.fixed_height.tolist() == [5.0, 7.0, 3.0, 1.0]
    with pytest.raises(ValueError, match="its x goes from 1 to 3, and 0 to 0 is needed"):
        cq.CableNet(positions, segments, 1.0, load=1.0, support=ground.assign_coords(x=[1, 2, 3]), fixed=[1, 2, 3, 4])
    with pytest.raises(ValueError, match="lie between its places"):
        cq.CableNet(
            positions, segments, 1.0, load=1.0, support=ground.assign_coords(x=[-1, 0.1, 1]), fixed=[1, 2, 3, 4]
        )


def test_a_grid_is_interpolated_on_request():
    coarse = xr.DataArray(np.add.outer([0.0, 30.0], [1.0, 5.0]), {"y": [0.0, 3.0], "x": [0.0, 4.0]}, ("y", "x"))
    np.testing.assert_allclose(
        cq.Membrane(LATTICE, 1.0, load=cq.profiles.Gridded.of(coarse), support=99.0).load, VALUES
    )
    down = cq.profiles.Gridded.of(coarse[::-1, ::-1])
    np.testing.assert_allclose(down(X, Y), VALUES)
    raised = cq.profiles.Gridded([0, 4], [0, 3], -coarse.to_numpy(), upwards=True)
    np.testing.assert_allclose(raised(X, Y), VALUES)
    with pytest.raises(ValueError, match=r"x = 5 lies outside the grid, which goes from 0 to 4"):
        down(5.0, 0.0)
    held = cq.profiles.Gridded.of(coarse, outside="hold")
    assert held(5.0, -1.0) == 5.0
    hole = coarse.copy()
    hole[0, 0] = np.nan
    assert cq.profiles.Gridded.of(hole, outside="none")([0.0, 4.0, 9.0], 3.0).tolist() == [31.0, 35.0, np.inf]
    assert np.isinf(cq.profiles.Gridded.of(hole, outside="none")(0.0, 1.0))
    with pytest.raises(ValueError, match="no height is known at x = 0, y = 1"):
        cq.profiles.Gridded.of(hole)(0.0, 1.0)
    with pytest.raises(ValueError, match="x must hold two places or more, in order"):
        cq.profiles.Gridded([0, 0], [0, 1], np.zeros((2, 2)))
    with pytest.raises(ValueError, match=r"shape \(2, 2\), got \(2, 3\)"):
        cq.profiles.Gridded([0, 1], [0, 1], np.zeros((2, 3)))
    with pytest.raises(TypeError, match=r"must be an xarray\.DataArray"):
        cq.profiles.Gridded.of(np.zeros((2, 2)))


def test_a_mask_lies_where_its_coordinates_say():
    mask = xr.DataArray([[True, True], [True, False]], {"y": [7.0, 6.5], "x": [3.0, 3.5]}, ("y", "x"))
    lattice = cq.Lattice.from_mask(mask, 0.5)
    assert (lattice.origin, lattice.mask.tolist()) == ((3.0, 6.5), [[True, False], [True, True]])
    frame = pd.DataFrame([[True, True], [True, False]], index=[7.0, 6.5], columns=[3.0, 3.5])
    assert cq.Lattice.from_mask(frame, 0.5).mask.tolist() == lattice.mask.tolist()
    assert cq.Lattice.from_mask(mask.drop_vars(["x", "y"]), 0.5).origin == (0.0, 0.0)
    with pytest.raises(
        ValueError, match=r"mask must lie on a lattice of spacing 1, but its x goes from 3 to 3\.5 in 2"
    ):
        cq.Lattice.from_mask(mask, 1.0)


SQUARE = shapely.box(0, 0, 1, 1)
APART = shapely.box(2, 0, 3, 1)
HOLED = shapely.box(0, 0, 4, 3) - shapely.box(1, 1, 2, 2)


class Parcel:
    __geo_interface__ = SQUARE.__geo_interface__


class Parcels:
    __geo_interface__ = {  # noqa: RUF012
        "type": "FeatureCollection",
        "features": [{"type": "Feature", "geometry": each.__geo_interface__} for each in (SQUARE, APART)],
    }


@pytest.mark.parametrize(
    ("geometry", "area"),
    [
        (HOLED, 11.0),
        (shapely.MultiPolygon([SQUARE, APART]), 2.0),
        (shapely.GeometryCollection([SQUARE, APART]), 2.0),
        (SQUARE.exterior, 1.0),
        (shapely.LineString([(0, 0), (1, 0), (1, 1), (0, 0)]), 0.5),
        (Parcel(), 1.0),
        (Parcels(), 2.0),
    ],
)
def test_frames_come_from_every_geometry_with_an_area(geometry, area):
    assert cq.Frame.from_shapely(geometry).area == area


@pytest.mark.parametrize("geometry", [HOLED, shapely.MultiPolygon([SQUARE, APART])])
def test_frames_come_from_text(tmp_path, geometry):
    frame = cq.Frame.from_shapely(geometry)
    again = cq.Frame.from_wkt(geometry.wkt)
    assert again.geometry.equals(geometry)
    assert again.lattice(0.25).mask.tolist() == frame.lattice(0.25).mask.tolist()
    assert cq.Frame.from_wkt(f"SRID=25832;{geometry.wkt}").crs == "EPSG:25832"
    features = [{"type": "Feature", "geometry": geometry.__geo_interface__, "properties": {}}]
    system = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    collection = {"type": "FeatureCollection", "features": features, "crs": system}
    text = json.dumps(collection)
    (tmp_path / "frame.geojson").write_text(text)
    for source in (collection, features[0], geometry.__geo_interface__, text, tmp_path / "frame.geojson"):
        assert cq.Frame.from_geojson(source).geometry.equals(geometry)  # type: ignore[arg-type]
    assert cq.Frame.from_geojson(collection).crs == "EPSG:25832"


def test_contours_that_are_none_are_refused_in_words(tmp_path):
    with pytest.raises(ValueError, match="no well-known text"):
        cq.Frame.from_wkt("POLYGON ((0 0")
    with pytest.raises(ValueError, match="holds no polygon, but LineString"):
        cq.Frame.from_geojson({"type": "LineString", "coordinates": [[0, 0], [1, 1]]})
    with pytest.raises(ValueError, match="no GeoJSON geometry"):
        cq.Frame.from_geojson({"type": "Plate"})
    (tmp_path / "frame.geojson").write_text("[1")
    with pytest.raises(ValueError, match=r"frame\.geojson: it is no JSON"):
        cq.Frame.from_geojson(tmp_path / "frame.geojson")
    (tmp_path / "frame.geojson").write_text("[1]")
    with pytest.raises(TypeError, match=r"frame\.geojson: it is no GeoJSON, but holds a list"):
        cq.Frame.from_geojson(tmp_path / "frame.geojson")
    bow = {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]}
    with pytest.raises(ValueError, match="not a valid polygon: Self-intersection"):
        cq.Frame.from_geojson(bow)
    with pytest.raises(TypeError, match="got Point"):
        cq.Frame.from_shapely(shapely.Point(0, 0))
    with pytest.raises(TypeError, match="load must hold real numbers"):
        cq.Membrane(LATTICE, 1.0, load=Fraction(1, 2), support=0.1)
