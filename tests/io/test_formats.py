"""Solutions in other programs' formats, opened by what those programs read them with, and judged anew."""

import json

import meshio
import netCDF4
import numpy as np
import pytest
import pyvista
import rasterio
import shapely
import xarray as xr
import zarr
from triangulations import obtuse_rings

import contactqp as cq
from contactqp.io.meshes import shape_of
from contactqp.io.writers import WRITERS


def field(**changes):
    """Return a tilted membrane in elevations, with a hole, beside which there is no support."""
    frame = cq.Frame.polygon([(0, 0), (4, 0), (4, 3), (0, 3)], [[(1, 1), (1.5, 1), (1.5, 1.5), (1, 1.5)]])
    given = {
        "load": lambda x, y: 2 + 0.1 * x,
        "support": lambda x, y: np.where(x < 3, -0.2 - 0.01 * x * y, -np.inf),
        "frame_height": lambda x, y: 0.05 * x + 0.01 / 3 * y,
    }
    return cq.Membrane(frame.in_crs(25832).lattice(0.25), tension=1.1, upwards=True, **given | changes)


def net():
    positions = [[0, 0], [1.1, 0], [0, 0.7], [-1, 0], [0, -1], [2, 0.1], [1, 1]]
    segments = [[0, 1], [0, 2], [0, 3], [0, 4], [1, 5], [1, 6]]
    return cq.CableNet(
        positions,
        segments,
        force_density=np.arange(1.0, 7.0) / 3,
        load=1.0,
        support=0.1,
        fixed=[2, 3, 4, 5, 6],
        fixed_height=[0.0, 0.1, 0.0, 1 / 7, 0.0],
    )


def triangles(**changes):
    """Return a membrane on obtuse triangles, with a tension for each and a rim that is not level."""
    points, corners = obtuse_rings(5)
    given = {
        "load": lambda x, y: 4 + x,
        "support": 0.3,
        "ceiling": -0.2,
        "tension": lambda x, y: 1 + x**2,
        "frame_height": lambda x, y: 0.05 * x,
    }
    return cq.MeshMembrane(points, corners, **given | changes)


MODELS = {
    "membrane": field,
    "plain": lambda: cq.gallery.bowl(15),
    "rows": lambda: cq.Membrane(
        cq.Frame.rectangle(1, 1).lattice(0.25), 1.0, load=1.0, support=np.full((5, 5), 0.01), rows="down"
    ),
    "disk": lambda: cq.Membrane(cq.Frame.disk(1.0).lattice(0.2), 1.0, load=1.0, support=0.1),
    "cable": lambda: cq.Cable(
        span=10.0, spacing=0.5, tension=1 / 3, load=1.0, support=2.0, start=-3.0, frame_height=lambda x: 0.1 * x
    ),
    "net": net,
    "triangles": triangles,
    "upwards": lambda: triangles(upwards=True, support=-0.3, ceiling=None, tension=2.0, foundation=0.1),
}  # fmt: skip


@pytest.fixture(params=MODELS)
def solution(request):
    return cq.solve(MODELS[request.param]())


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_a_solution_is_restored_to_the_bit_and_judged(tmp_path, solution, suffix):
    again = cq.load_solution(solution.save(tmp_path / f"answer{suffix}"))
    assert repr(again.model) == repr(solution.model)
    assert (again.status, again.tol, again.backend) == (solution.status, solution.tol, solution.backend)
    assert (again.problem.G != solution.problem.G).nnz == 0
    for name in ("gap", "reaction", "deflection", "contact"):
        np.testing.assert_array_equal(getattr(again, name), getattr(solution, name))
    np.testing.assert_array_equal(again.problem.q, solution.problem.q)
    assert again.model is not None
    assert again.model.cautions == solution.model.cautions
    assert again.model.crs == solution.model.crs
    again.to_dataset().identical(solution.to_dataset())


def test_what_a_file_claims_is_not_trusted(tmp_path):
    solution = cq.solve(cq.gallery.bowl(15))
    file = solution.save(tmp_path / "answer.nc")
    with xr.open_dataset(file) as opened:
        data = opened.load()
    data["gap"] = data["gap"] + 0.01
    data.attrs |= {"status": "certified", "relative_bound": 0.0}
    data.to_netcdf(file)
    again = cq.load_solution(file)
    assert again.status.value == "inaccurate"
    assert again.certificate is not None
    assert again.certificate.gap_bound >= 0.0099
    data["load"] = 2 * data["load"]
    data.to_netcdf(file)
    assert cq.load_solution(file, tol="low").tol == 1e-3


def test_a_bad_answer_is_written_and_read(tmp_path):
    with pytest.warns(cq.ContactWarning):
        solution = cq.solve(cq.gallery.bowl(15), "psor", max_iter=1)
    for suffix in WRITERS:
        file = solution.save(tmp_path / f"answer{suffix}")
        if suffix in (".nc", ".zarr"):
            assert cq.load_solution(file).status.value in ("inaccurate", "unproven")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda data: data.attrs.pop("contactqp_model"), "must tell its model by the attribute contactqp_model"),
        (lambda data: data.attrs.update(contactqp_model="shell"), "it has 'shell'"),
        (lambda data: data.attrs.pop("spacing"), "it tells of a membrane, but has no 'spacing'"),
        (lambda data: data.attrs.update(tension=-1.0), "tension must be"),
    ],
)
def test_files_without_a_model_are_refused_in_words(tmp_path, change, told):
    file = cq.solve(cq.gallery.bowl(7)).save(tmp_path / "answer.nc")
    with xr.open_dataset(file) as opened:
        data = opened.load()
    change(data)
    data.to_netcdf(file)
    with pytest.raises(ValueError, match=told) as error:
        cq.load_solution(file)
    assert str(file) in str(error.value)


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"there is no file .*answer\.nc"):
        cq.load_solution(tmp_path / "answer.nc")
    with pytest.raises(ValueError, match=r"read from \.nc, \.zarr or \.npz, not from '\.csv'"):
        cq.load_solution(tmp_path / "answer.csv")
    for name in ("broken.nc", "broken.zarr"):
        (tmp_path / name).write_text("nothing")
        with pytest.raises(OSError, match=name):
            cq.load_solution(tmp_path / name)


def test_netcdf_keeps_the_conventions(tmp_path):
    solution = cq.solve(field())
    with netCDF4.Dataset(solution.save(tmp_path / "answer.nc")) as file:
        assert file.Conventions == "CF-1.11"
        assert "contactqp" in file.source
        assert {"title", "history", "date_created", "contactqp_version", "cautions"} <= set(file.ncattrs())
        assert file["x"].standard_name == "projection_x_coordinate"
        assert file["gap"].grid_mapping == "spatial_ref"
        assert "UTM zone 32N" in file["spatial_ref"].crs_wkt
        state = file["contact_state"]
        assert state.flag_values.tolist() == [-1, 0, 1, 2]
        assert state.flag_meanings == "undecided clear contact contact_upper"
        assert file["gap"].quantity == "length"
        assert "units" not in file["gap"].ncattrs()


def test_zarr_opens_its_store_and_replaces_it(tmp_path):
    solution = cq.solve(cq.gallery.bowl(15))
    file = solution.save(tmp_path / "answer.zarr")
    solution.save(file)
    assert [path.name for path in tmp_path.iterdir()] == ["answer.zarr"]
    store = zarr.open_group(file, mode="r")
    np.testing.assert_array_equal(np.asarray(store["gap"]), solution.to_dataset()["gap"])
    assert store.attrs["status"] == "certified"
    (tmp_path / "folder.zarr").mkdir()
    with pytest.raises(ValueError, match="there is a folder of that name"):
        solution.save(tmp_path / "folder.zarr")


def test_a_mesh_is_the_deflected_shape(tmp_path, solution):
    file = solution.save(tmp_path / "answer.vtu")
    mesh = pyvista.read(file)
    model = solution.model
    shape = shape_of(model, solution.gap)
    upwards = 1 if model.upwards else -1
    np.testing.assert_array_equal(mesh.points[:, 2], upwards * shape.deflection)
    nodes = shape.node
    np.testing.assert_array_equal(mesh.points[nodes, 0], model.node_x)
    np.testing.assert_array_equal(mesh.points[nodes, 1], model.node_y)
    np.testing.assert_array_equal(mesh.points[nodes, 2], upwards * solution.deflection)
    for name in ("reaction", "contact", "gap"):
        expected = model.clearance(solution.gap) if name == "gap" else getattr(solution, name)
        np.testing.assert_array_equal(mesh.point_data[name][nodes], expected)
    assert mesh.active_scalars_name == "contact_state"
    assert mesh.field_data["tension" if model.parameters else "tol"][0] == (
        model.parameters.get("tension", solution.tol)
    )
    assert solution.to_pyvista().field_data["status"][0] == "certified"
    told = meshio.read(file)
    np.testing.assert_array_equal(told.points, mesh.points)
    assert sum(len(block.data) for block in told.cells) == mesh.n_cells


def test_a_surface_covers_what_the_membrane_covers():
    mesh = cq.solve(field()).to_pyvista()
    flat = mesh.copy()
    flat.points[:, 2] = 0.0
    # Each of the four corners is cut by a triangle, and so is each inner corner of the hole not.
    assert flat.compute_cell_sizes()["Area"].sum() == pytest.approx(4 * 3 - 0.25 - 4 * 0.25**2 / 2)


def test_an_image_holds_the_fields_on_the_lattice(tmp_path):
    model = field()
    solution = cq.solve(model)
    image = pyvista.read(solution.save(tmp_path / "answer.vti"))
    lattice = model.lattice
    assert image.dimensions == (*lattice.shape[::-1], 1)
    assert (image.spacing[0], image.origin[:2]) == (lattice.spacing, lattice.origin)
    np.testing.assert_array_equal(
        image.point_data["reaction"].reshape(lattice.shape), lattice.scatter(solution.reaction)
    )
    warped = image.warp_by_scalar("elevation")
    assert warped.n_points == lattice.mask.size
    with pytest.raises(TypeError, match=r"answer\.vti: it takes a model on a lattice"):
        cq.solve(net()).save(tmp_path / "answer.vti")
    with pytest.raises(ValueError, match="kind must be one of"):
        solution.to_pyvista("plane")


def test_geotiff_has_bands_places_and_the_system(tmp_path):
    model = field()
    solution, lattice = cq.solve(model), model.lattice
    with rasterio.open(solution.save(tmp_path / "answer.tif")) as file:
        assert file.crs.to_epsg() == 25832
        band = file.descriptions.index("reaction") + 1
        values = file.read(band)
        np.testing.assert_array_equal(values[::-1], lattice.scatter(solution.reaction))
        assert file.units[band - 1] == "force"
        assert file.xy(0, 0) == (lattice.x[0], lattice.y[-1])
        assert file.tags()["contactqp_status"] == "certified"
    with pytest.raises(TypeError, match="a GeoTIFF holds the fields of a membrane"):
        cq.solve(net()).save(tmp_path / "net.tif")
    lost = cq.Membrane(cq.Frame.rectangle(1, 1).in_crs("EPSG:1").lattice(0.25), 1.0, load=1.0, support=0.1)
    with pytest.raises(ValueError, match="crs = 'EPSG:1' is no coordinate reference system"):
        cq.solve(lost).save(tmp_path / "lost.tif")


def test_geojson_has_the_contours_of_the_patches(tmp_path, solution):
    collection = json.loads(solution.save(tmp_path / "patches.geojson").read_text())
    table = solution.patches()
    assert len(collection["features"]) == len(table)
    for feature, (_, row) in zip(collection["features"], table.iterrows(), strict=True):
        contour = shapely.geometry.shape(feature["geometry"])
        assert contour.is_valid
        assert feature["properties"]["reaction"] == row["reaction"]
        if contour.geom_type in ("Polygon", "MultiPolygon"):
            assert contour.area == pytest.approx(row["area"], rel=1e-9)
            nodes = shapely.points(solution.model.node_x, solution.model.node_y)
            assert np.count_nonzero(shapely.contains(contour, nodes)) == row["nodes"]
        elif contour.geom_type == "LineString":
            assert contour.length == pytest.approx(row["area"])
        else:
            assert len(contour.geoms) == row["nodes"]
    if solution.model.crs:
        assert collection["crs"]["properties"]["name"] == "urn:ogc:def:crs:EPSG::25832"


def test_patches_are_told_apart():
    def hump(x):
        return 0.3 + 0.5 * np.cos(np.pi * x / 2) ** 2

    humps = cq.Cable(span=8.0, spacing=0.5, tension=1.0, load=0.4, support=hump)
    solution = cq.solve(humps)
    table = solution.patches()
    assert len(table) == 4
    assert table["patch"].tolist() == [1, 2, 3, 4]
    assert table["nodes"].sum() == solution.contact.sum() == table["certain"].sum()
    assert table["reaction"].sum() == pytest.approx(solution.reaction[solution.contact].sum())
    np.testing.assert_allclose(table["x"], [1, 3, 5, 7])
    as_net = cq.CableNet(
        np.column_stack([np.arange(17) / 2, np.zeros(17)]), np.column_stack([np.arange(16), np.arange(1, 17)]), 1.0,
        load=0.15, support=lambda x, y: hump(x), fixed=[0, 16],
    )  # fmt: skip
    other = cq.solve(as_net).patches()
    assert other["x"].tolist() == table["x"].tolist()
    assert other["area"].isna().all()
    free = cq.solve(cq.Cable(span=8.0, spacing=0.5, tension=1.0, load=0.2, support=9.0)).patches()
    assert len(free) == 0
    assert list(free) == list(table)


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_model_of_ones_own_is_written_where_it_can_be(tmp_path, suffix):
    from scipy import sparse

    from contactqp.models.base import ContactModel

    class String(ContactModel):
        def __init__(self):
            self.load, self.support = self.at_nodes(1.0, "load"), self.support_at_nodes(1.0)

        node_x = property(lambda self: np.arange(5.0))
        node_y = property(lambda self: np.zeros(5))

        def pull(self, depths):
            return self.assemble_stiffness() @ depths

        def assemble_stiffness(self):
            return sparse.diags_array([-np.ones(4), np.full(5, 2.0), -np.ones(4)], offsets=[-1, 0, 1]).tocsr()

        def max_slope(self, gap):
            return 0.0

        def free_boundary(self, contact):
            return np.zeros((0, 2))

    solution = cq.solve(String())
    if suffix in (".vti", ".tif"):
        with pytest.raises(TypeError, match="cannot write"):
            solution.save(tmp_path / f"answer{suffix}")
        return
    file = solution.save(tmp_path / f"answer{suffix}")
    if suffix == ".nc":
        with pytest.raises(ValueError, match="it has none"):
            cq.load_solution(file)


def test_a_missing_package_is_told_before_solving(tmp_path, monkeypatch):
    import sys

    from typer.testing import CliRunner

    from contactqp.cli.commands import app

    for name in ("pyvista", "zarr", "rasterio"):
        monkeypatch.setitem(sys.modules, name, None)
    for suffix, told in [(".vtu", "contactqp[vtk]"), (".zarr", "contactqp[zarr]"), (".tif", "contactqp[geo]")]:
        case = tmp_path / "case.toml"
        case.write_text('spacing=0.5\ntension=1.0\nload=1.0\nsupport=0.1\nframe={shape="disk",radius=2.0}\n')
        result = CliRunner().invoke(app, ["solve", str(case), "--out", str(tmp_path / f"x{suffix}")])
        assert result.exit_code == 2
        assert f"pip install '{told}'" in result.stderr
        assert "certified" not in result.stdout


@pytest.mark.parametrize("suffix", WRITERS)
def test_the_command_writes_every_format(tmp_path, suffix):
    from typer.testing import CliRunner

    from contactqp.cli.commands import app

    case, out = tmp_path / "case.toml", tmp_path / f"answer{suffix}"
    case.write_text('spacing=0.5\ntension=1.0\nload=1.0\nsupport=0.1\nframe={shape="rectangle",width=4.0,height=3.0}\n')
    result = CliRunner().invoke(app, ["solve", str(case), "--out", str(out)])
    assert result.exit_code == 0, result.stderr
    assert out.exists()


def test_an_interactive_view_shows_shape_and_support():
    plotter = cq.solve(field()).plot3d(interactive=True, title="Field")
    assert len(plotter.meshes) == 2
    plotter.close()
    with pytest.raises(TypeError, match="takes no ax"):
        cq.solve(field()).plot3d(object(), interactive=True)


def test_systems_of_joined_frames_must_agree():
    one, other = cq.Frame.rectangle(2, 2).in_crs(25832), cq.Frame.disk(0.5)
    assert (one - other).crs == "EPSG:25832"
    with pytest.raises(ValueError, match="bring both into one system"):
        _ = one | other.in_crs(25833)
    with pytest.raises(TypeError, match="crs must be text"):
        one.in_crs(2.5)


def test_a_mesh_of_triangles_is_opened_by_others(tmp_path):
    model = triangles()
    solution = cq.solve(model)
    file = solution.save(tmp_path / "disk.vtu")
    by_vtk, by_meshio = pyvista.read(file), meshio.read(file)
    assert by_vtk.n_cells == len(model.triangles)
    np.testing.assert_array_equal(by_meshio.cells_dict["triangle"], model.triangles)
    np.testing.assert_allclose(by_meshio.points[:, :2], model.positions)
    np.testing.assert_allclose(by_meshio.points[model.free, 2], -solution.deflection)
    np.testing.assert_allclose(by_meshio.points[model.fixed, 2], -model.fixed_height)
    np.testing.assert_allclose(by_vtk.point_data["gap"][model.free], solution.gap)
    assert by_vtk.area > np.pi * 0.9


def test_a_mesh_of_triangles_as_ugrid_has_it(tmp_path):
    model = triangles()
    solution = cq.solve(model)
    with xr.open_dataset(solution.save(tmp_path / "disk.nc")) as data:
        topology = data["mesh"].attrs
        assert (topology["cf_role"], topology["topology_dimension"]) == ("mesh_topology", 2)
        x, y = (data[name] for name in topology["node_coordinates"].split())
        np.testing.assert_array_equal(np.column_stack([x, y]), model.positions)
        connectivity = data[topology["face_node_connectivity"]]
        np.testing.assert_array_equal(connectivity, model.triangles)
        assert (connectivity.attrs["cf_role"], connectivity.attrs["start_index"]) == ("face_node_connectivity", 0)
        for name in ("gap", "deflection", "load", "contact_state"):
            assert (data[name].attrs["mesh"], data[name].attrs["location"]) == ("mesh", "node")
            assert data[name].dims == ("point",)
        whole = data["deflection"].fillna(data["frame_height"])
        assert not whole.isnull().any()
        np.testing.assert_array_equal(whole[model.free], solution.deflection)
        np.testing.assert_array_equal(data["fixed"].values.astype(bool), np.isin(np.arange(len(x)), model.fixed))


def test_the_contour_of_a_patch_on_a_mesh_is_that_of_its_nodes_parts_of_triangles(tmp_path):
    points, corners = obtuse_rings(8)
    model = cq.MeshMembrane(points, corners, 1.0, load=4.0, support=0.4)
    solution = cq.solve(model)
    [feature] = json.loads(solution.save(tmp_path / "patch.geojson").read_text())["features"]
    contour = shapely.geometry.shape(feature["geometry"])
    assert contour.area == pytest.approx(model.node_area[solution.contact].sum())
    assert contour.geom_type == "Polygon"
    covered = shapely.contains(contour, shapely.points(model.node_x, model.node_y))
    np.testing.assert_array_equal(covered, solution.contact)
