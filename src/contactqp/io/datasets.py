"""Solutions as xarray datasets: on the array of a lattice, and along the nodes of any other model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..foundation.loading import load_modules
from .fields import Field, fields_of

if TYPE_CHECKING:
    import xarray as xr

    from ..models.base import ContactModel
    from ..models.records import Answered


def solution_dataset(solution: Answered, model: ContactModel) -> xr.Dataset:
    """Return the fields of a model's solution where the model lays them out (see `Solution.to_dataset`)."""
    attributes = {
        "model": repr(model),
        "backend": solution.backend,
        "status": str(solution.status),
        "tol": solution.tol,
        "relative_bound": solution.relative_bound,
        "relative_residual": solution.relative_residual,
        "iterations": solution.iterations,
        "seconds": solution.seconds,
        "cautions": "; ".join(solution.cautions),
    }
    return dataset_of(model, fields_of(solution)).assign_attrs(attributes | model.parameters)


def dataset_of(model: ContactModel, fields: Mapping[str, Field]) -> xr.Dataset:
    """Return quantities at a model's nodes as a dataset, with units and meanings, and the model's coordinates."""
    load_modules("xarray")
    import xarray as xr

    variables = {
        name: (*model.laid_out(field.values), {"units": field.unit, "long_name": field.meaning})
        for name, field in fields.items()
    }
    return xr.Dataset(variables, dict(model.coordinates))
