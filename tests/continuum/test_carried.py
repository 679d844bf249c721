"""Bounds of the membrane itself go along where they are asked for: in datasets, files, pictures and reports."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import contactqp as cq
from contactqp.io.answers import read_answer


@pytest.fixture(scope="module")
def solution():
    lattice = cq.Frame.rectangle(1, 0.75).lattice(1 / 16)
    model = cq.Membrane(lattice, 1.0, load=1.0, support=0.02, units={"length": "m", "force": "kN"})
    return cq.solve(model, tol=1e-9)


def test_bounds_are_computed_once(solution):
    assert solution.continuum("pointwise") is solution.continuum("pointwise")
    assert solution.continuum() is not solution.continuum("pointwise")


def test_a_dataset_has_them_only_where_they_are_asked_for(solution):
    plain, carried = solution.to_dataset(), solution.to_dataset(continuum="pointwise")
    assert not [name for name in plain.variables if "continuum" in name or "square" in name]
    assert carried.drop_vars(set(carried.variables) - set(plain.variables)).equals(plain)
    found = solution.continuum("pointwise")
    for name, variable in found.to_dataset().data_vars.items():
        assert carried[name if name.endswith("_bounds") else f"continuum_{name}"].equals(variable), name
    assert (carried["continuum_deflection_lower"] <= carried["deflection"]).sum() == solution.problem.size
    assert carried.attrs["continuum_effort"] == "pointwise"
    energy = solution.to_dataset(continuum="energy")
    assert "continuum_potential_energy_lower" in energy
    assert "continuum_deflection_lower" not in energy


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_files_hold_them_by_the_conventions_of_cf(solution, tmp_path, suffix):
    carried = solution.to_dataset(continuum="pointwise")
    file = solution.save(tmp_path / f"bowl{suffix}", continuum="pointwise")
    with xr.open_dataset(file) if suffix == ".nc" else xr.open_zarr(file, consolidated=False) as stored:
        for name, variable in carried.data_vars.items():
            np.testing.assert_array_equal(stored[name].to_numpy(), variable.to_numpy(), err_msg=name)
        assert stored["continuum_contact_area_lower"].attrs["units"] == "m2"
        assert stored["continuum_energy_error"].attrs["quantity"] == "square root of force times length"
        assert "units" not in stored["continuum_energy_error"].attrs
        assert stored["x_square"].attrs | {"axis": "X", "units": "m", "bounds": "x_square_bounds"} == (
            stored["x_square"].attrs
        )
        state = stored["continuum_contact_state_in_squares"].attrs
        assert dict(zip(state["flag_meanings"].split(), state["flag_values"], strict=True)) == {
            "contact": 1,
            "clear": 0,
            "undecided": -1,
        }
    assert (cq.load_solution(file).gap == solution.gap).all()


def test_patches_and_tables_of_an_energy_have_no_room_for_them(solution, tmp_path):
    with pytest.raises(ValueError, match=r"bounds of the membrane itself go into \.nc \.csv .* files"):
        solution.save(tmp_path / "bowl.geojson", continuum="pointwise")
    with pytest.raises(ValueError, match=r"bowl\.csv: a table of nodes takes bounds at the nodes"):
        solution.save(tmp_path / "bowl.csv", continuum="energy")
    with pytest.raises(AttributeError, match="needs a model"):
        cq.solve(solution.problem).save(tmp_path / "bare.csv", continuum="pointwise")
    assert not list(tmp_path.iterdir())


NODAL = ("deflection_lower", "deflection_upper", "gap_lower", "gap_upper")


def test_a_table_of_nodes_has_columns_of_them(solution, tmp_path):
    file = solution.save(tmp_path / "bowl.csv", continuum="pointwise")
    table = pd.read_csv(file, dtype=str)  # older versions read numbers to the last bit but one
    proven = solution.continuum("pointwise").carried
    for name in NODAL:
        np.testing.assert_array_equal(table[f"continuum_{name}"].astype(float), proven.at_nodes[name].values)
    assert (table.continuum_deflection_lower.astype(float) <= table.deflection.astype(float)).all()
    np.testing.assert_array_equal(read_answer(file, solution.model), solution.gap)
    assert not [name for name in pd.read_csv(solution.save(tmp_path / "plain.csv")) if "continuum" in name]


def test_bands_of_a_geotiff_are_described(solution, tmp_path):
    rasterio = pytest.importorskip("rasterio")
    found = solution.continuum("pointwise")
    with rasterio.open(solution.save(tmp_path / "bowl.tif", continuum="pointwise")) as stored:
        for name in NODAL:
            band = stored.descriptions.index(f"continuum_{name}") + 1
            values = found.carried.at_nodes[name].values
            np.testing.assert_array_equal(solution.model.lattice.gather(stored.read(band)[::-1]), values)
            assert stored.units[band - 1] == "m"
            assert "proven" in stored.tags(band)["meaning"]
        assert float(stored.tags()["contactqp_continuum_contact_area_upper"]) == found.contact.area.upper
        assert stored.tags()["contactqp_continuum_data"] == "exact"


@pytest.mark.parametrize("suffix", [".vtu", ".vti"])
def test_paraview_reads_them_at_points(solution, tmp_path, suffix):
    pyvista = pytest.importorskip("pyvista")
    found = solution.continuum("pointwise")
    mesh = pyvista.read(solution.save(tmp_path / f"bowl{suffix}", continuum="pointwise"))
    for name in NODAL:
        values = np.asarray(mesh.point_data[f"continuum_{name}"])
        np.testing.assert_array_equal(values[~np.isnan(values)], found.carried.at_nodes[name].values)
    assert mesh.field_data["continuum_contact_area_lower"][0] == found.contact.area.lower
    energy = pyvista.read(solution.save(tmp_path / f"energy{suffix}", continuum="energy"))
    assert energy.field_data["continuum_energy_error"][0] == solution.continuum().energy_error


def test_a_map_shows_the_strip(solution):
    figure = solution.plot(continuum="pointwise")
    assert "strip that holds the membrane's own free boundary" in figure.axes[0].get_title()
    plain = solution.plot()
    assert len(figure.axes[0].collections) == len(plain.axes[0].collections) + 2
    strip = solution.continuum("pointwise").strip
    hatched = figure.axes[0].collections[-2].get_paths()
    area = sum(np.prod(np.ptp(path.vertices, axis=0)) for path in hatched)
    assert area == pytest.approx(strip.squares.sum() / 16**2)
    own = plain.axes[0]
    solution.plot(own, continuum="pointwise")
    assert "hatched" in own.get_title()
    with pytest.raises(ValueError, match="drawn in a map"):
        solution.plot(kind="surface", continuum="pointwise")
    with pytest.raises(ValueError, match="continuum must be one of 'pointwise', got 'energy'"):
        solution.plot(continuum="energy")


def test_a_report_tells_of_the_best_answer(solution, tmp_path):
    comparison = cq.compare(solution.model, ["psor"])
    page = comparison.report(tmp_path / "report.html", continuum="pointwise").read_text(encoding="utf-8")
    found = comparison.best.continuum("pointwise")
    assert "<h2>The membrane itself</h2>" in page
    assert f"{found.contact.undecided.sum()} undecided" in page
    assert page.count("<img") == 2
    energy = comparison.report(tmp_path / "report.html", continuum="energy").read_text(encoding="utf-8")
    assert "potential energy" in energy
    assert energy.count("<img") == 1
    assert "membrane itself" not in comparison.report(tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_cable_has_bounds_at_its_nodes_and_no_squares():
    solution = cq.solve(cq.Cable(1.0, spacing=0.05, tension=1.0, load=1.0, support=0.05))
    data = solution.to_dataset(continuum="pointwise")
    assert (data["continuum_deflection_lower"] <= data["deflection"]).all()
    assert "x_square" not in data.dims
    with pytest.raises(AttributeError, match=r"strip is known of a Membrane, this is of Cable\("):
        solution.plot(continuum="pointwise")
