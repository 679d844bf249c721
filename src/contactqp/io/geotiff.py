"""GeoTIFF files: a band for each field of a membrane, the northern row first, with its coordinate reference system."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.loading import needed
from ..foundation.units import unit_of
from ..models.on_area import AreaModel
from .carried import Carried, fields_with
from .provenance import provenance_of

if TYPE_CHECKING:
    from ..models.base import ContactModel
    from ..models.records import Answered

INSTALL = "contactqp[geo]"


def require_membrane(model: ContactModel) -> None:
    """Raise unless a model is a membrane, whose fields are pictures, in a system that is known.

    Raises
    ------
    TypeError, ValueError
        The latter if there is no such coordinate reference system.
    """
    if not isinstance(model, AreaModel):
        raise TypeError(f"a GeoTIFF holds the fields of a membrane or a plate, this is {model!r}; write .nc or .csv")
    if model.crs:
        rasterio = needed("rasterio", "writing GeoTIFF", INSTALL)
        try:
            rasterio.crs.CRS.from_user_input(model.crs)
        except rasterio.errors.CRSError as error:
            raise ValueError(f"crs = {model.crs!r} is no coordinate reference system: {error}") from None


def write_geotiff(solution: Answered, model: ContactModel, path: Path, carried: Carried | None = None) -> None:
    """Write every field as a band of doubles, nan outside the frame, with its unit and its name; numbers as tags."""
    require_membrane(model)
    assert isinstance(model, AreaModel)
    rasterio = needed("rasterio", "writing GeoTIFF", INSTALL)
    fields, lattice = fields_with(solution, carried), model.lattice
    rows, columns = lattice.shape
    step = lattice.spacing
    west, north = lattice.origin[0] - step / 2, float(lattice.y[-1]) + step / 2
    place = {"transform": rasterio.Affine(step, 0.0, west, 0.0, -step, north), "crs": model.crs or None}
    shape = {"height": rows, "width": columns, "count": len(fields), "dtype": "float64", "nodata": np.nan}
    with rasterio.open(path, "w", driver="GTiff", compress="deflate", **shape, **place) as file:
        for band, (name, field) in enumerate(fields.items(), 1):
            values = np.asarray(field.values, dtype=np.float64)
            file.write(lattice.scatter(values)[::-1], band)
            file.set_band_description(band, name)
            file.set_band_unit(band, unit_of(field.unit, model.unit_names) or field.unit)
            file.update_tags(band, meaning=field.meaning)
        facts = provenance_of(solution, model) | ({} if carried is None else carried.facts)
        file.update_tags(**{f"contactqp_{name}": str(value) for name, value in facts.items()})
