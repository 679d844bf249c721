"""Contact patches as GeoJSON: a feature for each, with its contour, area, reaction and middle."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules
from .patches import contour_of, patches_of
from .provenance import provenance_of

if TYPE_CHECKING:
    from ..models.base import ContactModel
    from ..models.records import Answered


def write_geojson(solution: Answered, model: ContactModel, path: Path) -> None:
    """Write the contact patches, with the coordinates of the model.

    A coordinate reference system is told by the member ``crs``, which the older specification of GeoJSON has and GDAL
    and QGIS read: coordinates are the model's own, in its unit of length, and not degrees of WGS 84.
    """
    load_modules("shapely")
    import shapely

    labels, _ = model.contact_patches(solution.contact)
    features = [
        {
            "type": "Feature",
            "geometry": json.loads(shapely.to_geojson(contour_of(model, np.flatnonzero(labels == row["patch"])))),
            "properties": {name: _plain(value) for name, value in row.items()},
        }
        for row in patches_of(solution, model).to_dict("records")
    ]
    collection: dict[str, Any] = {"type": "FeatureCollection", "name": "contact patches"}
    if model.crs:
        collection["crs"] = {"type": "name", "properties": {"name": _urn(model.crs)}}
    told = {name: _plain(value) for name, value in provenance_of(solution, model).items()}
    text = json.dumps({**collection, "contactqp": told, "features": features}, indent=1, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _urn(crs: str) -> str:
    """Return a system by the name that GeoJSON takes.

    Examples
    --------
    >>> _urn("EPSG:25832")
    'urn:ogc:def:crs:EPSG::25832'
    """
    authority, _, code = crs.partition(":")
    return f"urn:ogc:def:crs:{authority.upper()}::{code}" if code.isdigit() else crs


def _plain(value: Any) -> Any:
    """Return a number as JSON has it: infinite ones and nan as null."""
    value = getattr(value, "item", lambda: value)()
    return None if isinstance(value, float) and not math.isfinite(value) else value
