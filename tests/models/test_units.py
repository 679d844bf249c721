"""Units of pint and of attributes are checked and converted, and never lost."""

import sys
from typing import Any

import numpy as np
import pint
import pytest
import xarray as xr

import contactqp as cq

LATTICE = cq.Frame.rectangle(2.0, 2.0).lattice(0.5)
U: Any = pint.UnitRegistry()
UNITS = {"length": "m", "force": "kN"}
PLAIN = cq.Membrane(LATTICE, 2.0, load=0.3, support=0.1, frame_height=0.05)


def told(values, units, of_places=""):
    attributes = {"units": of_places} if of_places else {}
    places = {"y": ("y", LATTICE.y, attributes), "x": ("x", LATTICE.x, attributes)}
    return xr.DataArray(np.full(LATTICE.shape, values), places, ("y", "x"), attrs={"units": units})


@pytest.mark.parametrize("load", [300 * U.N / U.m**2, 0.3 * U.kPa, told(300.0, "N m-2"), told(0.3, "kN/m^2")])
@pytest.mark.parametrize("support", [100 * U.mm, told(10.0, "cm"), np.full(LATTICE.size, 0.1) * U.m])
def test_quantities_are_converted(load, support):
    model = cq.Membrane(
        LATTICE, 2000 * U.N / U.m, load=load, support=support, frame_height=5 * U.cm, units=UNITS
    )  # fmt: skip
    assert model.tension == PLAIN.tension
    np.testing.assert_allclose(model.load, PLAIN.load, rtol=1e-15)
    np.testing.assert_allclose(model.support, PLAIN.support, rtol=1e-15)
    np.testing.assert_allclose(model.problem.q, PLAIN.problem.q, rtol=1e-12)


def test_cables_and_nets_convert_too():
    cable = cq.Cable(
        span=1000 * U.cm, spacing=100 * U.cm, tension=1000 * U.N, load=2 * U.kN / U.m, support=0.5, start=1 * U.m,
        units=UNITS,
    )  # fmt: skip
    assert (cable.span, cable.tension, cable.start, cable.load[0]) == (10.0, 1.0, 1.0, 2.0)
    net = cq.CableNet(
        np.array([[0, 0], [100, 0], [0, 100]]) * U.cm, [[0, 1], [0, 2]], 1000 * U.N, load=1 * U.kN, support=1 * U.m,
        fixed=[1, 2], fixed_height=[1, 2] * U.mm, units=UNITS,
    )  # fmt: skip
    assert (net.positions[1, 0], net.tension[0], net.fixed_height.tolist()) == (1.0, 1.0, [0.001, 0.002])
    laid = cq.CableNet.orthogonal(LATTICE, 1000 * U.N, load=1.0 * U.kN, support=100 * U.mm, units=UNITS)
    assert (laid.force_density[0], laid.support[0]) == (2.0, 0.1)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"load": 3 * U.m}, r"load must be a force per area \(kN m-2\), but its unit is m"),
        ({"support": told(1.0, "kN")}, r"support must be a length \(m\), but its unit is kN"),
        ({"support": told(1.0, "wibble")}, "support has the units 'wibble', which are none"),
        ({"support": told(1.0, "force")}, "support must be a length, but its units say force"),
        ({"tension": 3 * U.kN}, r"tension must be a force per length \(kN m-1\)"),
        ({"units": None, "load": 3 * U.Pa}, "load has the unit Pa, and the model has not been told its own"),
        ({"units": "m", "load": 3 * U.Pa}, "has not been told its own"),
        ({"units": None, "load": told(1.0, "m")}, r"load must be a force per area \(N m-2\), but its unit is m"),
        ({"units": None, "support": told(1.0, "mm", "m")}, "support is in mm and its x in m; bring them to one"),
        ({"units": {"mass": "kg"}}, "units must be of 'length' and 'force', got 'mass'"),
    ],
)
def test_what_is_another_quantity_is_refused(given, message):
    arguments = {"tension": 2.0, "load": 0.3, "support": 0.1, "units": UNITS} | given
    with pytest.raises(ValueError, match=message):
        cq.Membrane(LATTICE, arguments.pop("tension"), **arguments)


@pytest.mark.parametrize("units", [7, {"length": 1}])
def test_units_that_are_no_text_are_refused(units):
    with pytest.raises(TypeError, match="units"):
        cq.Membrane(LATTICE, 2.0, load=1.0, support=0.1, units=units)


def test_a_unit_is_never_lost():
    with pytest.raises(TypeError, match="width has a unit"):
        cq.Frame.rectangle(4 * U.m, 3)
    with pytest.raises(TypeError, match="q has a unit"):
        cq.ContactQP(np.eye(2), [1.0, 2.0] * U.N)


def test_data_of_ones_own_go_in_again():
    data = cq.solve(PLAIN).to_dataset()
    assert data["support"].attrs["units"] == "length"
    again = cq.Membrane(LATTICE, 2.0, load=data["load"].fillna(0), support=data["support"].fillna(0), frame_height=0.05)
    np.testing.assert_array_equal(again.problem.q, PLAIN.problem.q)


def test_files_tell_the_units_and_keep_them(tmp_path):
    model = cq.Membrane(LATTICE, 2.0, load=0.3, support=0.01, units=UNITS)
    solution = cq.solve(model)
    assert solution.to_dataset()["load"].attrs["units"] == "kN m-2"
    assert solution.to_dataset()["x"].attrs["units"] == "m"
    file = solution.save(tmp_path / "answer.nc")
    with xr.open_dataset(file) as data:
        assert data["reaction"].attrs["units"] == "kN"
        millimetres = data["support"].fillna(0) * 1000
        millimetres.attrs["units"] = "mm"
        other = cq.Membrane(LATTICE, 2.0, load=data["load"].fillna(0), support=millimetres, units=UNITS)
    np.testing.assert_allclose(other.problem.q, model.problem.q)
    again = cq.load_solution(file)
    assert again.model is not None
    assert again.model.unit_names == UNITS


def test_without_pint_units_that_differ_are_refused_and_others_taken(monkeypatch):
    monkeypatch.setitem(sys.modules, "pint", None)
    same = cq.Membrane(LATTICE, 2.0, load=told(0.3, "kN m-2"), support=told(0.1, "m"), units=UNITS)
    assert same.load[0] == 0.3
    assert cq.Membrane(LATTICE, 2.0, load=told(0.3, "kPa"), support=0.1).load[0] == 0.3
    with pytest.raises(ImportError, match=r"load, whose units are 'kPa' and not 'kN m-2', needs pint: pip install"):
        cq.Membrane(LATTICE, 2.0, load=told(0.3, "kPa"), support=0.1, units=UNITS)
