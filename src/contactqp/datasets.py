"""Solutions as xarray datasets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ._checks import Vector

if TYPE_CHECKING:
    import xarray as xr

    from .solution import Solution


def solution_dataset(solution: Solution) -> xr.Dataset:
    """Return the fields of a solution on its net (see `Solution.to_dataset`)."""
    import xarray as xr

    model = solution._physical("to_dataset")
    lattice, supported = model.lattice, model.supported
    fields: dict[str, tuple[Vector, str, str]] = {
        "gap": (_unlimited(solution.gap, supported), "length", "clearance of the membrane over the support"),
        "deflection": (solution.deflection, "length", "deflection, positive downwards"),
        "support": (model.support, "length", "ordinate of the rigid profile, positive downwards"),
        "reaction": (solution.reaction, "force", "nodal reaction of the support, upwards"),
        "contact_pressure": (
            solution.contact_pressure,
            model.units["contact_pressure"],
            "reaction of the support, upwards",
        ),
        "load": (model.load, model.units["load"], "active load, positive downwards"),
    }
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
    variables = {}
    for name, (values, unit, long_name) in fields.items():
        grid = lattice.scatter(values)
        dims, data = (("x",), grid[0]) if model.is_line else (("y", "x"), grid)
        variables[name] = (dims, data, {"units": unit, "long_name": long_name})
    length = {"units": "length"}
    coordinates = {"x": ("x", np.array(lattice.x), length)}
    if not model.is_line:
        coordinates["y"] = ("y", np.array(lattice.y), length)
    attributes = {
        "model": repr(model),
        "tension": model.tension,
        "spacing": lattice.spacing,
        "backend": solution.backend,
        "status": solution.status.value,
        "tol": solution.tol,
        "relative_bound": solution.relative_bound,
        "iterations": solution.iterations,
        "seconds": solution.seconds,
    }
    return xr.Dataset(variables, coordinates, attributes)


def _unlimited(gap: Vector, supported: np.ndarray) -> Vector:
    return np.where(supported, gap, np.inf)
