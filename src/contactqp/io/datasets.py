"""Solutions as xarray datasets: on the net of a lattice, and along the nodes of a cable net."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector
from ..models.base import ContactModel
from ..models.cable_net import CableNet
from ..models.on_lattice import LatticeModel

if TYPE_CHECKING:
    import xarray as xr

    from ..models.records import Answered


def solution_dataset(solution: Answered, model: ContactModel) -> xr.Dataset:
    """Return the fields of a solution on its net (see `Solution.to_dataset`)."""
    import xarray as xr

    attributes = {
        "model": repr(model),
        "backend": solution.backend,
        "status": str(solution.status),
        "tol": solution.tol,
        "relative_bound": solution.relative_bound,
        "iterations": solution.iterations,
        "seconds": solution.seconds,
    }
    if isinstance(model, LatticeModel):
        attributes |= {"tension": model.tension, "spacing": model.lattice.spacing}
    length = {"units": "length"}
    coordinates: dict[str, Any] = {name: (dim, place, length) for name, (dim, place) in places(model).items()}
    if isinstance(model, CableNet):
        coordinates["point"] = ("node", np.array(model.free), {"long_name": "number among all points"})
    variables = {
        name: (*placed(model, values), {"units": unit, "long_name": long_name})
        for name, (values, unit, long_name) in _fields(solution, model).items()
    }
    return xr.Dataset(variables, coordinates, attributes)


def places(model: ContactModel) -> dict[str, tuple[str, Vector]]:
    """Return dimension and values (length) of a dataset's coordinates: of the net's, or of the nodes without a net."""
    if not isinstance(model, LatticeModel):
        return {"x": ("node", np.array(model.node_x)), "y": ("node", np.array(model.node_y))}
    across = {"x": ("x", np.array(model.lattice.x))}
    return across if model.is_line else across | {"y": ("y", np.array(model.lattice.y))}


def placed(model: ContactModel, values: Vector) -> tuple[tuple[str, ...], Vector]:
    """Return the dimensions of the nodes' values in a dataset, and the values laid out along them."""
    if not isinstance(model, LatticeModel):
        return ("node",), np.array(values)
    grid = model.lattice.scatter(values)
    return (("x",), grid[0]) if model.is_line else (("y", "x"), grid)


def _fields(solution: Answered, model: ContactModel) -> dict[str, tuple[Vector, str, str]]:
    """Return by name the values at the nodes, the unit, and what it is."""
    supported = model.supported
    fields: dict[str, tuple[Vector, str, str]] = {
        "gap": (_unlimited(solution.gap, supported), "length", "clearance over the support"),
        "deflection": (solution.deflection, "length", "deflection, positive downwards"),
        "support": (model.support, "length", "ordinate of the rigid profile, positive downwards"),
        "reaction": (solution.reaction, "force", "nodal reaction of the support, upwards"),
        "load": (model.load, model.units["load"], "active load, positive downwards"),
    }
    if model.node_area is not None:
        unit = model.units["contact_pressure"]
        fields["contact_pressure"] = (solution.contact_pressure, unit, "reaction of the support, upwards")
    certificate = solution.certificate
    if certificate is not None:
        state = np.where(certificate.contact, 1.0, np.where(certificate.clear, 0.0, -1.0))
        fields |= {
            "gap_lower": (_unlimited(certificate.lower, supported), "length", "certified lower bound of the gap"),
            "gap_upper": (_unlimited(certificate.upper, supported), "length", "certified upper bound of the gap"),
            "reaction_lower": (certificate.reaction[0], "force", "certified lower bound of the reaction"),
            "reaction_upper": (certificate.reaction[1], "force", "certified upper bound of the reaction"),
            "contact_state": (state, "1", "1 certainly in contact, 0 certainly clear, -1 undecided"),
        }
    return fields


def _unlimited(gap: Vector, supported: np.ndarray) -> Vector:
    return np.where(supported, gap, np.inf)
