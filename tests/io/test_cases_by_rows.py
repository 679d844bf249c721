"""Cases of which several processes read some rows each: the same bits as where one reads the whole."""

import tracemalloc

import numpy as np
import pytest
from peers import by_peers, without_locks

import contactqp as cq
from contactqp.geometry.fields import is_function
from contactqp.geometry.on_contour import FrameFit
from contactqp.io.cases import load_case, read_membrane_by_rows
from contactqp.io.surfaces import surface_of_file

SIZES = 1, 2, 3, 5
FIELDS = "support", "ceiling", "load", "foundation"


@pytest.fixture(autouse=True)
def _threads(monkeypatch):
    without_locks(monkeypatch, FrameFit)


def written(folder, text, **files):
    for name, values in files.items():
        np.save(folder / f"{name}.npy", values)
    case = folder / "case.toml"
    case.write_text(text)
    return case


def by_rows(case, size):
    """Return the nodes, and the fields at them, that so many processes find together, and what each has been told."""

    def one(peer):
        parts = read_membrane_by_rows(case, peer)
        lattice, (rows, _) = parts["lattice"], parts["lattice"].shape
        membrane = cq.mpi.MembraneByRows.on(lattice, parts["tension"], **{k: parts[k] for k in parts if k not in DONE})
        # Not the rows that the process has looked at.
        first, last = (rows * (peer.size - peer.rank - one) // peer.size for one in (1, 0))
        nodes = membrane.nodes(first, last)
        found = {name: membrane.rows_of(name, first, last) for name in FIELDS if membrane.has(name)}
        arms = [membrane.arms(axis, first - 1, -1, ringed(membrane, first, last)) for axis in "xy"]
        return nodes, found, arms, (lattice.shape, lattice.origin, lattice.spacing, lattice.facts, parts["rows"])

    return by_peers(size, one)[::-1]


DONE = "lattice", "tension"


def ringed(membrane, first, last):
    """Return where there are nodes on some rows with a ring."""
    low, high = max(0, first - 1), min(membrane.shape[0], last + 1)
    padding = (low - first + 1, last + 1 - high), (1, 1)
    return np.pad(membrane.nodes(low, high), padding)


def assert_the_same(case):
    model = load_case(case)
    lattice, sense = model.lattice, -1.0 if model.upwards else 1.0
    told = (lattice.overshoot, lattice.caution, lattice.slanted, lattice.crs)
    for size in SIZES:
        found = by_rows(case, size)
        assert {part[3] for part in found} == {(lattice.shape, lattice.origin, lattice.spacing, told, model.rows)}
        nodes = np.concatenate([part[0] for part in found])
        np.testing.assert_array_equal(nodes, lattice.mask)
        for name in found[0][1]:
            whole = np.concatenate([part[1][name] for part in found])
            wanted = getattr(model, name) * (sense if name in ("support", "ceiling") else 1.0)
            np.testing.assert_array_equal(whole[nodes], wanted)
        for k, field in enumerate(model.tension_of_arms.fields):
            if isinstance(field.arms, float):
                assert {part[2][k] for part in found if np.ndim(part[2][k]) == 0} <= {field.arms}
            else:
                parts = [part[2][k] for part in found]
                whole = np.concatenate([part if k == 0 else part[:-1] for part in parts])
                used = whole > 0
                np.testing.assert_array_equal(whole[used], field.arms[: len(whole)][used])


HOLED = """
shape = "polygon"
corners = [[0.0, 0.0], [2.03, 0.1], [1.9, 1.0], [2.2, 2.1], [0.1, 1.93]]
holes = [[[0.5, 0.5], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0]]]
"""
FRAMES = {
    "disk": ('shape = "disk"\nradius = 1.0', 0.07),
    "at a tie": ('shape = "rectangle"\nwidth = 1.0\nheight = 0.6', 0.05),
    "growing": ('shape = "rectangle"\nwidth = 1.0\nheight = 1.0', 0.023),
    "hexagon": ('shape = "hexagon"\nside = 1.0\ncenter = [3.1, -2.0]', 0.05),
    "polygon": (HOLED, 0.03),
}


@pytest.mark.filterwarnings("ignore::contactqp.ContactWarning")
@pytest.mark.parametrize("frame", FRAMES)
def test_frames_are_laid_out_by_rows_as_the_whole_is(tmp_path, frame):
    contour, spacing = FRAMES[frame]
    case = written(
        tmp_path,
        f"""
spacing = {spacing}
tension = 1.0
load = 2.0
support = {{profile = "paraboloid", depth = 0.05, radius = 10.0}}
ceiling = -0.5
[frame]
{contour}
""",
    )
    assert_the_same(case)


@pytest.mark.parametrize("direction", ["up", "down"])
def test_masks_and_fields_of_files_are_read_by_rows(tmp_path, direction):
    rng = np.random.default_rng(5)
    mask = rng.uniform(size=(61, 40)) > 0.2
    support = rng.uniform(0.1, 0.2, (61, 40)).astype(np.float32)
    support[7, 3:9] = np.nan
    case = written(
        tmp_path,
        f"""
spacing = 0.5
origin = [1.0, 2.0]
upwards = true
tension = [{{file = "warp.npy", rows = "{direction}"}}, 1.0]
load = {{file = "load.npy", rows = "{direction}", resample = true, no_data = -9}}
support = {{file = "support.npy", factor = -0.3, offset = -0.1, missing = "none", rows = "{direction}"}}
foundation = {{file = "springs.npy", resample = true, rows = "{direction}"}}
frame = {{shape = "mask", file = "mask.npy", rows = "{direction}"}}
""",
        mask=mask,
        support=support,
        warp=np.asfortranarray(rng.uniform(1.0, 2.0, (61, 40))),
        load=rng.integers(0, 9, (30, 17)).astype(np.int16),
        springs=rng.uniform(size=(1, 9)),
    )
    assert_the_same(case)


@pytest.mark.parametrize("installed", [True, False])
def test_bands_of_tiff_files_are_read_by_rows(tmp_path, monkeypatch, installed):
    rasterio = pytest.importorskip("rasterio")
    if not installed:
        monkeypatch.setattr("contactqp.io.rasters._has_rasterio", lambda: False)
    rng = np.random.default_rng(8)
    place = rasterio.Affine(0.1, 0.0, 0.95, 0.0, -0.1, 9.05)
    shape = {"width": 50, "height": 71, "count": 1, "dtype": "float32", "nodata": -1.0, "transform": place}
    for name, values in (("ground", rng.uniform(0.5, 1.0, (71, 50))), ("field", rng.uniform(size=(71, 50)) - 0.05)):
        with rasterio.open(tmp_path / f"{name}.tif", "w", driver="GTiff", crs="EPSG:25832", **shape) as file:
            file.write(np.where(values < 0, -1.0, values).astype(np.float32), 1)
    case = written(
        tmp_path,
        """
spacing = 0.1
tension = 1.0
load = {file = "ground.tif", factor = 3.0}
support = {profile = "map", file = "ground.tif", factor = -2.0, offset = 0.1}
ceiling = {profile = "map", file = "field.tif", outside = "none", offset = 3.0}
foundation = {file = "ground.tif", resample = true}
upwards = true
frame = {shape = "mask", file = "field.tif", threshold = 0.0}
""",
    )
    assert_the_same(case)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ('frame = {shape = "disk", radius = 0.01}', "no lattice point of spacing 0.1 lies inside"),
        ('frame = {shape = "mask", file = "nothing.npy"}', "mask of shape .* holds no node"),
        ('frame = {shape = "mask", file = "missing.npy"}', "there is no file"),
        ('frame = {shape = "disk", radius = 1e5}', "in each of 3 processes would need"),
        ('frame = {shape = "disk", radius = 1.0}\nfitted = true', "fitted = true is not solved"),
        ('frame = {shape = "disk", radius = 1.0}\nmodel = "plate"', "only a membrane"),
        ('frame = {shape = "disk", radius = 1.0}\nceiling = {file = "nothing.npy"}', "it has shape .30, 20."),
    ],
)
def test_what_is_refused_is_told_alike_by_all(tmp_path, given, told):
    text = f"spacing = 0.1\ntension = 1.0\nload = 1.0\nsupport = 0.1\n{given}"
    case = written(tmp_path, text, nothing=np.zeros((30, 20)))

    def one(peer):
        with pytest.raises(cq.CaseFileError, match=told) as raised:
            read_membrane_by_rows(case, peer)
        return str(raised.value)

    assert len(set(by_peers(3, one))) == 1


def test_a_node_without_a_value_is_told_when_its_row_is_read(tmp_path):
    load = np.ones((30, 20))
    load[4, 7] = np.nan
    text = 'spacing = 0.1\ntension = 1.0\nload = {file = "load.npy"}\nsupport = 0.1\n'
    case = written(tmp_path, text + 'frame = {shape = "mask", file = "mask.npy"}', load=load, mask=np.ones((30, 20)))
    (parts,) = by_peers(1, lambda peer: read_membrane_by_rows(case, peer))
    membrane = cq.mpi.MembraneByRows.on(parts["lattice"], 1.0, load=parts["load"], support=0.1)
    membrane.rows_of("load", 5, 30)
    with pytest.raises(cq.CaseFileError, match=r"load.file = 'load.npy': it holds no value at x=0.7, y=0.4; fill"):
        membrane.rows_of("load", 0, 5)


def test_no_process_holds_an_array_of_the_whole_lattice(tmp_path):
    """Of 1500² points one of four processes takes less than a byte each, where the whole of a field takes eight."""
    count = 1500
    case = written(
        tmp_path,
        f"""
spacing = {1 / (count + 1)}
tension = 1.0
load = {{file = "load.npy"}}
support = {{file = "coarse.npy", resample = true}}
frame = {{shape = "polygon", corners = [[0, 0], [1, 0], [1, 1], [0, 1]]}}
""",
        load=np.ones((count + 2, count + 2), dtype=np.float32),
        coarse=np.full((20, 20), 0.1),
    )

    class First:
        """The first of four, which is told nothing by the others."""

        rank, size = 0, 4

        def everyones(self, found):
            return found

        def agreed(self, work):
            return work()

    tracemalloc.start()
    try:
        parts = read_membrane_by_rows(case, First())
        membrane = cq.mpi.MembraneByRows.on(parts["lattice"], 1.0, load=parts["load"], support=parts["support"])
        laid_out = tracemalloc.get_traced_memory()[1]
        nodes = membrane.nodes(0, 100)
        assert membrane.rows_of("load", 0, 100)[nodes].all()
        assert membrane.rows_of("support", 0, 100)[nodes].all()
        read = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert laid_out < 15e6
    assert read < 15e6


def test_functions_are_left_alone(tmp_path):
    text = 'spacing = 0.1\ntension = 1.0\nload = 1.0\nsupport = {profile = "plane", depth = 0.1}\n'
    case = written(tmp_path, text + 'frame = {shape = "disk", radius = 1.0}')
    (parts,) = by_peers(1, lambda peer: read_membrane_by_rows(case, peer))
    assert is_function(parts["support"])


@pytest.mark.filterwarnings("ignore::contactqp.ContactWarning")
@pytest.mark.parametrize("suffix", ["nc", "zarr"])
@pytest.mark.parametrize("turned", [False, True])
def test_variables_of_datasets_are_read_by_rows(tmp_path, suffix, turned):
    xr = pytest.importorskip("xarray")
    pytest.importorskip("zarr" if suffix == "zarr" else "netCDF4")
    rng = np.random.default_rng(9)
    values = rng.uniform(0.1, 0.3, (2, 1, 33, 27)).astype(np.float32)
    values[0, 0, 3, 4:9], values[1, 0, 12, 7] = np.nan, 0.5
    places = {"northing": np.linspace(-1.1, 1.1, 33), "x": np.linspace(-1.3, 1.2, 27)}
    ground, roof = (xr.DataArray(each, places, ("band", "northing", "x")) for each in values)
    if turned:
        ground, roof = ground[:, ::-1, ::-1].transpose("x", "band", "northing"), roof[:, ::-1]
    data = xr.Dataset({"ground": ground, "roof": roof})
    for each in data.values():
        each.encoding.update(dtype="int16", scale_factor=0.001, _FillValue=-9)
    file = tmp_path / f"maps.{suffix}"
    data.to_netcdf(file) if suffix == "nc" else data.to_zarr(file, consolidated=False)
    case = written(
        tmp_path,
        f"""
spacing = 0.07
tension = 1.0
load = 1.0
ceiling = {{profile = "map", file = "maps.{suffix}", key = "roof", factor = -3.0}}
support = {{profile = "map", file = "maps.{suffix}", key = "ground", outside = "none", no_data = 0.5, offset = 0.1}}
frame = {{shape = "disk", radius = 1.0}}
""",
    )
    assert_the_same(case)


def test_of_a_variable_no_more_is_read_than_the_rows_that_are_near(tmp_path, monkeypatch):
    xr = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    monkeypatch.setattr("contactqp.io.surfaces._KEPT", 1 << 14)
    count = 1500
    places = {"y": np.linspace(0.0, 1.0, count), "x": np.linspace(0.0, 1.0, count)}
    ground = xr.DataArray(np.full((count, count), 0.1), places, ("y", "x"))
    chunks = {"ground": {"chunks": (50, count)}}
    xr.Dataset({"ground": ground}).to_zarr(tmp_path / "map.zarr", consolidated=False, encoding=chunks)
    surface = surface_of_file(
        tmp_path / "map.zarr",
        **dict.fromkeys(("key", "x", "y", "no_data", "delimiter")),
        factor=1.0,
        offset=0.0,
        upwards=False,
        interpolation="linear",
        outside="error",
        duplicates="error",
        decimal=".",
        by_rows=True,
    )
    surface(0.5, 0.25)  # what is loaded at first
    tracemalloc.start()
    try:
        found = surface(np.linspace(0.0, 1.0, count), 0.5)
        taken = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_allclose(found, 0.1)
    assert taken < 0.2 * ground.nbytes
