"""Surfaces from files that tell where their values lie, in Python and in case files."""

from pathlib import Path

import numpy as np
import pytest
import rasterio
import xarray as xr

import contactqp as cq
from contactqp.io.cases import load_case
from contactqp.profiles import Along, Gridded, Scattered

EXAMPLES = Path(__file__).parents[2] / "examples"
X, Y = 500.0 + 10 * np.arange(6), 9000.0 + 10 * np.arange(4)
BED = 80 + 0.1 * (X - 500) + 0.2 * (Y[:, None] - 9000)
PLACES = (523.0, 9017.0)
THERE = 80 + 2.3 + 3.4


def tiff(file, values, north_up=True, **more):
    """Write values, whose rows go up, into pixels whose middles are at X and Y."""
    low, high = Y[0] - 5, Y[-1] + 5
    place = rasterio.Affine(10, 0, 495, 0, -10, high) if north_up else rasterio.Affine(10, 0, 495, 0, 10, low)
    shape = dict(zip(("height", "width"), values.shape, strict=True))
    options = {"count": 1, "dtype": "float32", "crs": "EPSG:25832", "transform": place} | more
    with rasterio.open(file, "w", driver="GTiff", **shape, **options) as data:
        data.write((values[::-1] if north_up else values).astype(options["dtype"]), 1)
    return file


def xyz(file, values, shuffled=True, separator=" "):
    points = np.column_stack([*map(np.ravel, np.meshgrid(X, Y)), values.ravel()])
    if shuffled:
        points = np.random.default_rng(0).permutation(points)
    file.write_text("# x y z\n" + "\n".join(separator.join(f"{each:g}" for each in point) for point in points))
    return file


@pytest.mark.parametrize("kind", ["north up", "south up", "doubles", "nc", "easting.nc", "zarr", "xyz", "csv"])
def test_a_grid_lies_where_its_file_puts_it(tmp_path, kind):
    file = tmp_path / f"bed.{kind.rpartition('.')[2]}"
    match kind:
        case "north up" | "south up":
            tiff(file.with_suffix(".tif"), BED, kind == "north up")
        case "doubles":
            tiff(file.with_suffix(".tif"), BED, dtype="float64")
        case "nc" | "zarr":
            data = xr.Dataset({"z": (("y", "x"), BED[::-1]), "k": 1.0}, {"x": X, "y": Y[::-1]})
            data.to_netcdf(file) if kind == "nc" else data.to_zarr(file, consolidated=False)
        case "easting.nc":
            xr.Dataset({"z": (("northing", "easting"), BED)}, {"easting": X, "northing": Y}).to_netcdf(file)
        case "xyz" | "csv":
            xyz(file, BED, separator=" " if kind == "xyz" else ",")
    bed = cq.read_surface(next(tmp_path.iterdir()))
    assert isinstance(bed, Gridded)
    np.testing.assert_array_equal(bed.x, X)
    np.testing.assert_array_equal(bed.y, Y)
    assert bed(*PLACES) == pytest.approx(THERE, rel=1e-7)


def test_elevations_factors_and_offsets(tmp_path):
    file = tiff(tmp_path / "bed.tif", -100 * BED)
    assert cq.read_surface(file, factor=0.01, offset=-2.0, upwards=True)(*PLACES) == pytest.approx(THERE + 2, rel=1e-7)
    assert cq.read_surface(file, factor=-0.01)(*PLACES) == pytest.approx(THERE, rel=1e-7)


@pytest.mark.parametrize("told", ["by the file", "by the user", "nan"])
@pytest.mark.parametrize("suffix", ["tif", "xyz"])
def test_holes_are_refused_or_without_support(tmp_path, suffix, told):
    absent = np.nan if told == "nan" else -9999.0
    values = BED.copy()
    values[1, 2] = absent
    by_file = {"nodata": absent} if told == "by the file" and suffix == "tif" else {}
    file = tmp_path / f"bed.{suffix}"
    tiff(file, values, **by_file) if suffix == "tif" else xyz(file, values)
    how = {} if by_file or told == "nan" else {"no_data": absent}
    with pytest.raises(ValueError, match="no height is known at x = 523, y = 9017"):
        cq.read_surface(file, **how)(*PLACES)
    bed = cq.read_surface(file, outside="none", **how)
    np.testing.assert_array_equal(bed([523.0, 400.0], [9017.0, 9017.0]), [np.inf, np.inf])
    assert bed(543.0, 9017.0) == pytest.approx(THERE + 2)


def test_beyond_a_map(tmp_path):
    file = tiff(tmp_path / "bed.tif", BED)
    with pytest.raises(ValueError, match="x = 400 lies outside the grid, which goes from 500 to 550"):
        cq.read_surface(file)(400.0, 9017.0)
    assert cq.read_surface(file, outside="hold")(400.0, 9000.0) == pytest.approx(80.0)


@pytest.mark.parametrize("separator", [" ", ";", ", "])
def test_points_that_fill_no_grid_are_scattered(tmp_path, separator):
    file = xyz(tmp_path / "bed.xyz", BED, separator=separator)
    lines = file.read_text().splitlines()
    file.write_text("\n".join(line for line in lines if "530" not in line or "9010" not in line))
    bed = cq.read_surface(file, no_data=80.0, outside="hold")
    assert isinstance(bed, Scattered)
    assert bed.x.size == BED.size - 2
    assert bed(*PLACES) == pytest.approx(THERE)
    assert isinstance(cq.read_surface(file, interpolation="cubic", outside="none"), Scattered)


def test_several_soundings_at_one_place(tmp_path):
    file = tmp_path / "bed.csv"
    file.write_text("x,y,z,sd\n0,0,1,9\n1,0,1,9\n0,1,1,9\n0,1,3,9\n")
    with pytest.raises(cq.CaseFileError, match=r"bed.csv: two soundings at x = 0, y = 1: keep one by duplicates"):
        cq.read_surface(file, key="z")
    assert cq.read_surface(file, key="z", duplicates="mean")(0.0, 1.0) == pytest.approx(2.0)
    assert cq.read_surface(file, key=2, duplicates="last", x="y", y="x")(1.0, 0.0) == pytest.approx(3.0)


def test_files_without_places_are_refused_with_a_remedy(tmp_path):
    np.save(tmp_path / "bed.npy", BED)
    np.savetxt(tmp_path / "bed.csv", BED, delimiter=",")
    shape = {"height": 4, "width": 6, "count": 1, "dtype": "float32"}
    with pytest.warns(rasterio.errors.NotGeoreferencedWarning):
        rasterio.open(tmp_path / "bed.tif", "w", driver="GTiff", **shape).close()
    for name in ("bed.npy", "bed.tif"):
        with pytest.raises(cq.CaseFileError, match=rf"{name}: it does not tell where its values lie; say profiles.Gr"):
            cq.read_surface(tmp_path / name)
    with pytest.raises(cq.CaseFileError, match=r"bed.csv: it has 6 columns and no header.*x, y and key; .*Gridded"):
        cq.read_surface(tmp_path / "bed.csv")
    with pytest.raises(cq.CaseFileError, match=r"nowhere.tif: there is no such file"):
        cq.read_surface(tmp_path / "nowhere.tif")
    with pytest.raises(cq.CaseFileError, match=r"interpolation = 'cubic' is for points of text files"):
        cq.read_surface(tiff(tmp_path / "map.tif", BED), interpolation="cubic")


LINE = """
model = "{model}"
span = 50.0
spacing = 5.0
start = 7.0
tension = 2.0
load = 0.5
frame_height = 79.0
{more}
support = {{profile = "map", file = "{file}", start = [500, 9000], end = {end}{how}}}
"""


def written(folder, text):
    (folder / "case.toml").write_text(text)
    return folder / "case.toml"


@pytest.mark.parametrize(("model", "more"), [("cable", ""), ("beam", "bending_stiffness = 3.0")])
@pytest.mark.parametrize("kind", ["tif", "xyz", "zarr"])
def test_a_line_over_a_map_in_a_case_file(tmp_path, model, more, kind):
    bed = BED.copy()
    bed[2] -= 3.0
    match kind:
        case "tif":
            tiff(tmp_path / "bed.tif", -bed)
        case "xyz":
            xyz(tmp_path / "bed.xyz", -bed)
        case "zarr":
            xr.Dataset({"z": (("y", "x"), -bed)}, {"x": X, "y": Y}).to_zarr(tmp_path / "bed.zarr", consolidated=False)
    case = LINE.format(model=model, more=more, file=f"bed.{kind}", end="[540, 9030]", how=", factor = -1")
    found = load_case(written(tmp_path, case))
    expected = Along(Gridded(X, Y, bed), (500, 9000), (540, 9030), abscissa=7.0)
    np.testing.assert_allclose(found.support, expected(found.node_x), rtol=1e-6)


@pytest.mark.parametrize(
    ("end", "how", "message"),
    [
        (
            "[550, 9030]",
            "",
            r"support: start and end are 58.309\d* apart, but span = 50; say so, or end = \[542.8.*, 90",
        ),
        ("[540, 9030]", ", outside = 'any'", r"support.outside: "),
        ("[540, 9030]", ", key = 'w'", r"support: .*bed.xyz: no column 'x'; it has"),
        ("[460, 9030]", "", r"case.toml: x = 496 lies outside the grid, which goes from 500 to 550"),
        ("[540]", "", r"support.end"),
    ],
)
def test_bad_lines_in_case_files_say_what_is_wrong(tmp_path, end, how, message):
    xyz(tmp_path / "bed.xyz", BED)
    case = LINE.format(model="cable", more="", file="bed.xyz", end=end, how=how)
    with pytest.raises(cq.CaseFileError, match=message):
        load_case(written(tmp_path, case))


PLAN = """
model = "{model}"
frame = {{shape = "rectangle", width = 30, height = 20, center = [525, 9015]}}
spacing = 5
tension = 1.0
load = 0.1
upwards = true
{more}
frame_height = -80
support = {{profile = "map", file = "bed.tif"{how}}}
"""


@pytest.mark.parametrize(("model", "more"), [("membrane", ""), ("plate", "bending_stiffness = 2.0")])
def test_a_map_under_a_membrane_and_a_plate(tmp_path, model, more):
    tiff(tmp_path / "bed.tif", -BED)
    found = load_case(written(tmp_path, PLAN.format(model=model, more=more, how="")))
    plane = 80 + 0.1 * (found.node_x - 500) + 0.2 * (found.node_y - 9000)
    np.testing.assert_allclose(found.support, -plane, rtol=1e-6)
    with pytest.raises(cq.CaseFileError, match="support: start and end are for a cable or a beam; leave them out"):
        load_case(
            written(tmp_path, PLAN.format(model=model, more=more, how=", start = [500, 9000], end = [530, 9000]"))
        )


def test_the_route_of_the_examples_lies_on_its_map():
    assert (EXAMPLES / "bathymetry.tif").stat().st_size < 50_000
    beam = load_case(EXAMPLES / "route.toml")
    bed = Along(
        cq.read_surface(EXAMPLES / "bathymetry.tif", upwards=True), (431200.0, 6512200.0), (432400.0, 6513800.0)
    )
    assert bed.span == 2000.0
    np.testing.assert_array_equal(beam.support, -bed(beam.node_x))
    solution = cq.solve(beam)
    assert solution.status == "certified"
    assert 0.2 < solution.contact.mean() < 0.9
