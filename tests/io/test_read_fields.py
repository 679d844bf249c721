"""Fields and masks from files, as case files read them, for models made in Python."""

import numpy as np
import pytest
import rasterio
import xarray as xr
from PIL import Image

import contactqp as cq

LATTICE = cq.Frame.polygon([(0, 0), (4, 0), (4, 3), (0, 3)]).lattice(0.5)
X, Y = np.meshgrid(LATTICE.x, LATTICE.y)
GRID = 1 + X + 10 * Y
VALUES = LATTICE.gather(GRID)


def tiff(file, grid, dtype, bands=("height",)):
    rows, columns = grid.shape
    place = {"transform": rasterio.Affine(0.5, 0, -0.25, 0, -0.5, 3.25), "crs": "EPSG:25832"}
    with rasterio.open(
        file, "w", driver="GTiff", height=rows, width=columns, count=len(bands), dtype=dtype, nodata=-9999, **place
    ) as data:
        for number, name in enumerate(bands, 1):
            data.write((number * grid[::-1]).astype(dtype), number)
            data.set_band_description(number, name)
    return file


def written(folder, kind):
    file = folder / f"field.{kind.split()[0]}"
    lines = [f"{x:g} {y:g} {z:g}" for x, y, z in zip(X.ravel(), Y.ravel(), GRID.ravel(), strict=True)]
    match kind:
        case "npy":
            np.save(file, GRID)
        case "npz":
            np.savez(file, height=GRID, other=1.0)
        case "csv":
            np.savetxt(file, GRID, delimiter=",")
        case "csv of places":
            file.write_text("\n".join(["x,y,height", *(line.replace(" ", ",") for line in lines[::-1])]))
        case "csv of columns":
            file.write_text(
                "\n".join(["a,y,x,height", *("7," + ",".join(line.split()[i] for i in (1, 0, 2)) for line in lines)])
            )
        case "xyz":
            file.write_text("\n".join(["# survey", *lines]))
        case "nc":
            xr.Dataset({"height": (("y", "x"), GRID), "k": 1.0}, {"x": LATTICE.x, "y": LATTICE.y}).to_netcdf(file)
        case "zarr":
            data = xr.Dataset({"height": (("y", "x"), GRID[::-1])}, {"x": LATTICE.x, "y": LATTICE.y[::-1]})
            data.to_zarr(file, consolidated=False)
        case "tif":
            tiff(file, GRID, "float32")
        case "tif of doubles":
            tiff(file, GRID, "float64")
        case "tif of bands":
            tiff(file, GRID / 2, "float64", ["half", "height"])
    return file


KINDS = [
    "npy",
    "npz",
    "csv",
    "csv of places",
    "csv of columns",
    "xyz",
    "nc",
    "zarr",
    "tif",
    "tif of doubles",
    "tif of bands",
]
WITH_KEYS = ("npz", "csv of columns", "nc", "zarr", "tif of bands")


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_file_is_read_to_the_bit(tmp_path, kind):
    file = written(tmp_path, kind)
    key = "height" if kind in WITH_KEYS else None
    np.testing.assert_array_equal(cq.read_field(file, LATTICE, key=key), VALUES)
    np.testing.assert_allclose(cq.read_field(file, LATTICE, key=key, factor=2.0, offset=1.0), 1 + 2 * VALUES)


@pytest.mark.parametrize("kind", ["xyz", "nc", "tif"])
def test_values_between_nodes_are_interpolated_on_request(tmp_path, kind):
    file = written(tmp_path, kind)
    finer = cq.Frame.polygon([(0, 0), (4, 0), (4, 3), (0, 3)]).lattice(0.25)
    found = cq.read_field(file, finer, resample=True, key="height" if kind == "nc" else None)
    np.testing.assert_allclose(found, 1 + finer.node_x + 10 * finer.node_y)
    with pytest.raises(cq.CaseFileError, match="between"):
        cq.read_field(file, finer, key="height" if kind == "nc" else None)


@pytest.mark.parametrize("kind", ["npy", "nc", "xyz"])
def test_nodes_without_a_value_are_told_or_filled(tmp_path, kind):
    grid = GRID.copy()
    grid[2, 3] = np.nan
    file = tmp_path / f"field.{kind}"
    if kind == "npy":
        np.save(file, grid)
    elif kind == "nc":
        xr.Dataset({"height": (("y", "x"), grid)}, {"x": LATTICE.x, "y": LATTICE.y}).to_netcdf(file)
    else:
        np.savetxt(file, np.column_stack([X.ravel(), Y.ravel(), grid.ravel()])[~np.isnan(grid.ravel())])
    filled = cq.read_field(file, LATTICE, missing=np.inf)
    assert np.isinf(filled).sum() == 1
    assert LATTICE.scatter(filled)[2, 3] == np.inf
    with pytest.raises(cq.CaseFileError, match=r"field\.\w+: .*(x=1\.5, y=1)"):
        cq.read_field(file, LATTICE)


def test_what_is_written_is_read_by_name(tmp_path):
    solution = cq.solve(cq.Membrane(LATTICE, 1.0, load=0.5, support=lambda x, y: 0.2 + 0.01 * x))
    for suffix in (".tif", ".nc", ".zarr"):
        file = solution.save(tmp_path / f"answer{suffix}")
        np.testing.assert_array_equal(cq.read_field(file, LATTICE, key="reaction", missing=0.0), solution.reaction)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("0 0 1\n1 0 1\n0 0 2\n", "2 values at x = 0, y = 0; leave one"),
        ("0 0 1\n1 0 1\n1.3 0 2\n", "no grid of equal steps along x"),
        ("x y z w\n0 0 1 1\n", "choose one of its columns by key: z, w"),
        ("0 0\n", "line 1: no column 2, it has 2 columns"),
        ("", "it has no rows"),
        ("0 0 1\n1 0 1\n0 1 1\n1 1 1\n", r"from x = 0 to 1, but nodes lie from 0.5 to 3.5"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_places_that_are_no_field_are_told(tmp_path, text, told):
    file = tmp_path / "field.xyz"
    file.write_text(text)
    with pytest.raises(cq.CaseFileError, match=told) as error:
        cq.read_field(file, LATTICE)
    assert str(file) in str(error.value)


def test_bands_and_variables_are_chosen_by_name(tmp_path):
    file = written(tmp_path, "tif of bands")
    np.testing.assert_array_equal(cq.read_field(file, LATTICE, key="1"), VALUES / 2)
    with pytest.raises(cq.CaseFileError, match="2 bands; choose one by key: half, height"):
        cq.read_field(file, LATTICE)
    with pytest.raises(cq.CaseFileError, match="no band 'heights' in it; it has half, height; did you mean 'height'"):
        cq.read_field(file, LATTICE, key="heights")
    file = cq.solve(cq.gallery.bowl(7)).save(tmp_path / "answer.nc")
    with pytest.raises(cq.CaseFileError, match="choose one of its variables by key: gap, deflection"):
        cq.read_field(file, LATTICE)
    with pytest.raises(cq.CaseFileError, match="there is no such file"):
        cq.read_field(tmp_path / "no.nc", LATTICE)


def test_masks_come_from_pictures_and_terrain(tmp_path):
    picture = np.zeros((3, 4), dtype=np.uint8)
    picture[0, :2] = 255  # in the north-west
    Image.fromarray(picture).save(tmp_path / "mask.png")
    lattice = cq.read_mask(tmp_path / "mask.png", 0.5, origin=(1.0, 2.0))
    assert (lattice.size, lattice.node_x.tolist(), lattice.node_y.tolist()) == (2, [1.0, 1.5], [3.0, 3.0])
    with pytest.raises(cq.CaseFileError, match="tells no places: say spacing="):
        cq.read_mask(tmp_path / "mask.png")
    lattice = cq.read_mask(tiff(tmp_path / "land.tif", GRID, "float32"), threshold=20.0)
    assert (lattice.spacing, lattice.origin, lattice.crs) == (0.5, (0.0, 0.0), "EPSG:25832")
    np.testing.assert_array_equal(lattice.mask, GRID > 20)
    with pytest.raises(cq.CaseFileError, match=r"its places are 0.5 and 0.5 apart, and not 1"):
        cq.read_mask(tmp_path / "land.tif", 1.0)


def test_a_case_knows_its_system(tmp_path):
    case = tmp_path / "case.toml"
    written(tmp_path, "xyz")
    case.write_text(
        'spacing = 0.5\ntension = 1.0\nload = 1.0\nsupport = {file = "field.xyz"}\ncrs = "EPSG:25832"\n'
        'frame = {shape = "polygon", corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]}\n'
    )
    from contactqp.io.cases import load_case

    model = load_case(case)
    assert model.crs == "EPSG:25832"
    np.testing.assert_array_equal(model.support, VALUES)
    tiff(tmp_path / "land.tif", GRID, "float32")
    case.write_text(
        'spacing=0.5\ntension=1.0\nload=1.0\nsupport=1.0\nframe={shape="mask",file="land.tif",threshold=20.0}\n'
    )
    assert load_case(case).crs == "EPSG:25832"
