"""Solutions as xarray datasets: on the array of a lattice, and along the nodes of any other model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules, loaded
from ..foundation.units import unit_of
from ..models.records import NodeState
from .carried import BESIDE, Carried
from .fields import Field, fields_of
from .model_records import record_of
from .provenance import facts_of, provenance_of

if TYPE_CHECKING:
    import xarray as xr

    from ..models.base import ContactModel
    from ..models.records import Answered


def solution_dataset(solution: Answered, model: ContactModel, carried: Carried | None = None) -> xr.Dataset:
    """Return the fields of a model's solution where the model lays them out, and the model (`Solution.to_dataset`).

    Parameters
    ----------
    solution : Solution
    model : Membrane, Cable, CableNet or another model
    carried : Carried, optional
        Bounds of the membrane itself, which become variables and attributes by their names after `BESIDE`.
    """
    data, record = dataset_of(model, fields_of(solution)).assign_attrs(facts_of(solution, model)), record_of(model)
    for name, (dimensions, values, meaning) in record.variables.items():
        data[name] = (dimensions, values, {"long_name": meaning})
    data = data.assign_attrs(record.attributes)
    if carried is None:
        return data
    beside = carried.dataset()
    # What tells where squares begin and end is named by their coordinates, as it is.
    named = [name for name in beside.data_vars if not str(name).endswith("_bounds")]
    about = {f"{BESIDE}{name}": told for name, told in beside.attrs.items()}
    return data.merge(beside.rename({name: f"{BESIDE}{name}" for name in named})).assign_attrs(about)


def file_dataset(solution: Answered, model: ContactModel, carried: Carried | None = None) -> xr.Dataset:
    """Return what files hold: these fields by the conventions of CF, where they come from, and the whole model."""
    data = solution_dataset(solution, model, carried)
    if not model.supported.all():
        # Without a support a gap is infinite, and the one that was solved for is counted from the frame's mean height.
        gap = Field(solution.gap, "length", "gap as solved for, without a support from the frame's mean height")
        data["gap_from_reference"] = dataset_of(model, {"gap": gap})["gap"]
    for variable in data.variables.values():
        variable.attrs = _by_conventions(variable.attrs)
    for axis in {"x", "y"} & set(data.dims):
        data[axis].attrs |= {"axis": str(axis).upper(), "long_name": f"{axis} of the nodes"}
    for axis in {"x_square", "y_square"} & set(data.dims):
        data[axis].attrs["axis"] = str(axis)[0].upper()
    if "contact_state" in data:
        states = {"flag_values": np.array(list(map(float, NodeState))), "flag_meanings": _MEANINGS}
        data["contact_state"].attrs |= states
    if model.crs:
        _tell_system(data, model.crs)
    return data.assign_attrs({"Conventions": "CF-1.11", **provenance_of(solution, model)})


_MEANINGS = " ".join(state.name.lower() for state in NodeState)

_NO_UNITS = (
    "length",
    "force",
    "force per area",
    "force per length",
    "length squared",
    "force times length",
    "square root of force times length",
)
"""What a model calls its units as long as it has not been told them; CF takes symbols only."""


def _by_conventions(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a variable's attributes with its quantity in place of units that are words."""
    if attributes.get("units") not in _NO_UNITS:
        return dict(attributes)
    others = {name: value for name, value in attributes.items() if name != "units"}
    return {"quantity": attributes["units"], **others}


def _tell_system(data: xr.Dataset, crs: str) -> None:
    """Say in which coordinate reference system x and y are, as CF and GDAL read it."""
    data["spatial_ref"] = ((), np.int32(0), {"crs_wkt": _wkt(crs), "spatial_ref": crs})
    for name, variable in data.data_vars.items():
        if name != "spatial_ref" and (
            {"x", "y"} <= set(variable.dims) or {"x_square", "y_square"} <= set(variable.dims)
        ):
            variable.attrs["grid_mapping"] = "spatial_ref"
    for axis in {"x", "y", "x_square", "y_square"} & set(data.dims):
        data[axis].attrs["standard_name"] = f"projection_{str(axis)[0]}_coordinate"


def _wkt(crs: str) -> str:
    """Return a system as WKT, or as it was told where nothing is there that could translate it."""
    try:
        rasterio = loaded("rasterio")
    except ImportError:
        return crs
    return str(rasterio.crs.CRS.from_user_input(crs).to_wkt())


def dataset_of(model: ContactModel, fields: Mapping[str, Field]) -> xr.Dataset:
    """Return quantities at a model's nodes as a dataset, with units and meanings, and the model's coordinates."""
    load_modules("xarray")
    import xarray as xr

    on = model.laid_out_on
    variables = {
        name: (*model.laid_out(field.values), {"units": _told(field.unit, model), "long_name": field.meaning, **on})
        for name, field in fields.items()
    }
    coordinates = {
        name: (place.dimension, place.values, _with_unit(place.attributes, model))
        for name, place in model.coordinates.items()
    }
    return xr.Dataset(variables, coordinates)


def _told(unit: str, model: ContactModel) -> str:
    """Return a unit in symbols, and in words where the model has not been told it."""
    return unit_of(unit, model.unit_names) or unit


def _with_unit(attributes: Mapping[str, Any], model: ContactModel) -> dict[str, Any]:
    return {name: _told(value, model) if name == "units" else value for name, value in attributes.items()}
