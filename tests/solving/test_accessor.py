"""``ds.contact``: the methods of a dataset, and the variable that a solution's dataset has."""

import copy
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pint
import pytest
import xarray as xr
from triangulations import rings

import contactqp as cq
import contactqp.xarray  # registers ds.contact

MODELS = {
    "hexagon": cq.gallery.paper_hexagon(),
    "disk": cq.Membrane(
        cq.Frame.disk(1.0).in_crs(25832).lattice(0.1), 1.0, load=1.0, support=lambda x, y: 0.1 + 0.1 * x
    ),
    "cable": cq.Cable(span=10.0, spacing=0.5, tension=1.0, load=1.0, support=2.0, start=-3.0),
}


def plain():
    x, y = np.linspace(0.0, 1.0, 17), np.linspace(0.0, 0.5, 9)
    ground = 0.06 + 0.1 * np.hypot(x - 0.5, y[:, None] - 0.25)
    return xr.Dataset({"support": (("y", "x"), ground), "load": 2.0, "tension": 1.0}, {"x": x, "y": y})


@pytest.mark.parametrize("name", MODELS)
def test_a_solution_answers_for_itself(name):
    solution = cq.solve(MODELS[name])
    data = solution.to_dataset()
    if name != "cable":
        again = data.contact.solve()
        np.testing.assert_array_equal(again["gap"], data["gap"])
        assert again.attrs["status"] == "certified"
    table, own = data.contact.patches(), solution.patches()
    assert table.equals(own[list(table)])
    histogram = data.contact.pressure_histogram(8)
    assert float(histogram.sum()) == pytest.approx(own["area"].sum())
    assert histogram["lower"][0] == solution.contact_pressure[solution.contact].min()
    assert data.contact.plot(title="T").axes[0].get_title() == "T"


def other_kinds():
    """Return a mesh, a net, a beam with a free end and a fitted disk."""
    points, triangles = rings(6)
    positions, segments = [[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], [[0, 1], [0, 2], [0, 3], [0, 4]]
    given = {"load": 1.0, "support": 0.1}
    return {
        "mesh": cq.MeshMembrane(points, triangles, 1.0, **given),
        "net": cq.CableNet(positions, segments, force_density=np.ones(4), fixed=[1, 2, 3, 4], **given),
        "beam": cq.Beam(10.0, spacing=0.5, bending_stiffness=1.0, load=0.2, support=0.1, ends=("clamped", "free")),
        "fitted": cq.Membrane(cq.Frame.disk(1.0).lattice(0.2, fitted=True), 1.0, **given),
    }


@pytest.mark.parametrize("kind", ["mesh", "net", "beam", "fitted"])
def test_patches_and_pressures_are_those_of_the_model_that_the_dataset_tells(kind):
    solution = cq.solve(other_kinds()[kind])
    data, own = solution.to_dataset(), solution.patches()
    table = data.contact.patches()
    assert len(table) == 1
    assert table.equals(own[list(table)])
    if kind == "net":
        with pytest.raises(ValueError, match="stand for no area, so that there is no pressure; patches"):
            data.contact.pressure_histogram()
    else:
        assert float(data.contact.pressure_histogram(5).sum()) == pytest.approx(own["area"].sum())
    if kind == "mesh":
        np.testing.assert_array_equal(data.contact.solve()["gap"], data["gap"])
        with pytest.raises(ValueError, match="there are 126 points"):
            data.isel(point=slice(1, None)).contact.patches()


def test_the_variable_stays_what_it_is():
    solution = cq.solve(MODELS["hexagon"])
    data = solution.to_dataset()
    contact = data.contact
    assert isinstance(contact, xr.DataArray)
    assert contact.identical(data["contact"])
    assert int(contact.sum()) == solution.contact.sum()
    assert float(data.reaction.where(contact).sum()) == pytest.approx(solution.reaction[solution.contact].sum())
    assert int((~contact & data.gap.notnull()).sum()) == (~solution.contact).sum()
    for other in (copy.copy(contact), copy.deepcopy(contact), pickle.loads(pickle.dumps(contact))):
        assert other.identical(data["contact"])
    data["contact"] = ~data["contact"]
    assert int(data.contact.sum()) == data["contact"].size - solution.contact.sum()
    derived: Any = (~contact)[0]
    assert derived.plot()


def test_a_dataset_is_solved_by_its_coordinates():
    data = plain()
    solved = data.contact.solve(tol=1e-9)
    lattice = cq.Frame.rectangle(1.0, 0.5, center=(0.5, 0.25)).lattice(1 / 16)
    membrane = cq.Membrane(lattice, 1.0, load=2.0, support=data["support"])
    np.testing.assert_allclose(solved["gap"], cq.solve(membrane, tol=1e-9).to_dataset()["gap"], atol=1e-12)
    down = data.isel(y=slice(None, None, -1)).transpose("x", "y")
    np.testing.assert_array_equal(down.contact.solve(tol=1e-9)["gap"], solved["gap"])
    assert data.contact.solution("psor", tension=2.0).backend == "psor"
    assert "contact" not in data.variables


def test_nodes_are_where_values_are_known():
    data = plain()
    holed = data.assign(support=data["support"].where((data.x > 0) & (data.y > 0) & (data.x + data.y < 1.2)))
    model = holed.contact.model()
    assert model.size == int(holed["support"].notnull().sum())
    mask = np.zeros((9, 17), dtype=bool)
    mask[2:5, 2:5] = True
    assert data.contact.model(nodes=mask).size == 9
    named = xr.DataArray(mask, {"y": data.y, "x": data.x}, ("y", "x"))
    assert data[{"y": slice(None, None, -1)}].contact.model(nodes=named[::-1]).node_y.tolist() == (
        data.contact.model(nodes=mask).node_y.tolist()
    )
    kept = data.assign(node_mask=named.astype(np.int8))
    assert kept.contact.model().size == 9


def test_a_row_is_a_cable():
    x = np.arange(11.0)
    data = xr.Dataset({"support": ("x", np.full(11, 2.0)), "load": ("x", np.ones(11))}, {"x": x}, {"tension": 1.0})
    cable = data.contact.model()
    assert isinstance(cable, cq.Cable)
    assert (cable.span, cable.start, cable.size) == (10.0, 0.0, 9)
    assert data.contact.solve().contact.patches()["nodes"].tolist() == [7]


def test_files_answer_for_themselves(tmp_path):
    solution = cq.solve(MODELS["disk"])
    with xr.open_dataset(solution.save(tmp_path / "disk.nc")) as data:
        assert data.contact.patches().equals(solution.patches().drop(columns="certain"))
        model = data.contact.model()
        assert model.crs == "EPSG:25832"
        np.testing.assert_array_equal(model.problem.q, solution.problem.q)


def test_units_of_a_dataset_are_checked():
    data = plain()
    data["support"] = data["support"] * 1000
    data["support"].attrs["units"] = "mm"
    data["tension"].attrs["units"] = "kN m-1"
    model = data.contact.model(units={"length": "m", "force": "N"}, tension=1000.0 * pint.Unit("N/m"))
    np.testing.assert_allclose(model.support.max(), plain()["support"][1:-1, 1:-1].max())
    assert data.contact.model(units={"length": "m", "force": "N"}).tension == 1000.0
    with pytest.raises(ValueError, match="load must be a force per area"):
        plain().assign(load=xr.DataArray(2.0, attrs={"units": "m"})).contact.model()


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (plain().drop_vars("load"), "must have load and support, but has no variable load"),
        (plain().drop_vars("tension"), "no variable and no attribute tension: say solve"),
        (plain().drop_vars("x"), "must have the coordinate x"),
        (plain().assign_coords(x=plain().x ** 2), "the coordinate x must have equal steps"),
        (
            plain().assign_coords(x=2 * plain().x),
            "must be the same along x and y, they are 0.125 along x, 0.0625",
        ),
        (plain().rename(x="a", y="b"), "must lie along y and x"),
    ],
)
def test_datasets_that_are_no_model_say_why(data, told):
    with pytest.raises(ValueError, match=told):
        data.contact.solve()


def test_datasets_that_are_no_solution_say_so():
    with pytest.raises(ValueError, match=r"no variable 'contact': it is no solution; ds\.contact\.solve"):
        plain().contact.patches()


def test_it_is_registered_on_request_only():
    code = (
        "import sys, contactqp as cq; assert 'xarray' not in sys.modules\n"
        "import xarray as xr; assert not hasattr(xr.Dataset(), 'contact')\n"
        "cq.xarray; assert hasattr(xr.Dataset(), 'contact')\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_ceilings_foundations_and_tension_that_varies_are_taken():
    data = plain()
    field = xr.zeros_like(data["support"]) + 1.0
    tension = field + 0.1 * field["x"]
    lifted = data.assign(ceiling=data["support"] - 1.0, foundation=0.5 * field, tension=tension)
    model = lifted.contact.model()
    nodes = {"x": xr.DataArray(model.node_x, dims="n"), "y": xr.DataArray(model.node_y, dims="n")}
    np.testing.assert_allclose(model.tension, tension.interp(nodes))
    np.testing.assert_allclose(model.ceiling, (data["support"] - 1.0).interp(nodes))
    np.testing.assert_array_equal(model.foundation, 0.5)
    pair = data.drop_attrs().drop_vars("tension", errors="ignore").assign(tension_x=tension, tension_y=2.0)
    pair.attrs = {name: value for name, value in data.attrs.items() if name != "tension"}
    np.testing.assert_allclose(pair.contact.model().tension[0], model.tension)


@pytest.mark.parametrize(
    "model",
    [
        cq.Cable(span=10.0, spacing=0.5, tension=1.0, load=1.0, support=4.0),
        cq.Beam(span=10.0, spacing=0.25, bending_stiffness=1.0, tension=0.5, load=1.0, support=0.5),
        cq.Plate(cq.Frame.rectangle(2, 1).lattice(0.1), 1.0, load=50.0, support=0.1, tension=1.0),
        cq.Membrane(
            cq.Frame.disk(1.0).lattice(0.1, fitted=True), 1.0, load=2.0, support=-0.2, upwards=True,
            frame_height=lambda x, y: 0.1 * x,
        ),
        cq.Membrane(
            cq.Frame.rectangle(2, 1).lattice(0.1), lambda x, y: 2 + x, load=9.0, support=0.2, ceiling=-0.1,
            foundation=1.0,
        ),
    ],
    ids=lambda model: type(model).__name__,
)  # fmt: skip
def test_a_solutions_dataset_is_solved_as_the_model_that_it_tells(model):
    solution = cq.solve(model, tol=1e-9)
    again = solution.to_dataset().contact.solve(tol=1e-9)
    xr.testing.assert_allclose(again["deflection"], solution.to_dataset()["deflection"], atol=1e-9)
    assert again.attrs["contactqp_model"] == solution.to_dataset().attrs["contactqp_model"]


def test_a_solutions_dataset_is_taken_as_it_is_or_not_at_all():
    model = cq.Membrane(cq.Frame.rectangle(2, 1).lattice(0.1), 1.0, load=lambda x, y: 5 + x + y, support=0.2)
    data = cq.solve(model, tol=1e-9).to_dataset()
    down = data[{"y": slice(None, None, -1)}].contact.solve(tol=1e-9)
    xr.testing.assert_allclose(down["gap"], data["gap"], atol=1e-9)
    heavier = data.assign(load=2 * data["load"]).contact.model()
    np.testing.assert_allclose(heavier.load, 2 * model.load)
    with pytest.raises(ValueError, match="tells its whole model, a membrane, so that tension cannot be given"):
        data.contact.model(tension=2.0)
    with pytest.raises(ValueError, match=r"x .*not those of the nodes|must"):
        data.isel(x=slice(3, None)).contact.model()
