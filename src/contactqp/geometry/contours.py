"""Contours as others write them: shapely geometries of every kind that holds polygons, and GeoJSON."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..foundation.loading import load_modules
from ..foundation.text import shortened

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry


def polygons_of(geometry: Any) -> Any:
    """Return a polygon or several for a ring, a collection, or an object that tells its geometry; else it as it is."""
    load_modules("shapely.geometry")
    import shapely
    from shapely.geometry import shape

    if not hasattr(geometry, "geom_type") and hasattr(geometry, "__geo_interface__"):
        told = geometry.__geo_interface__
        return polygons_in(told) if "features" in told or "geometry" in told else shape(told)
    kind = getattr(geometry, "geom_type", "")
    if kind == "LinearRing" or (kind == "LineString" and geometry.is_closed):
        return shapely.Polygon(geometry)
    if kind == "GeometryCollection" and geometry.geoms:
        return shapely.union_all([polygons_of(part) for part in geometry.geoms])
    return geometry


def read_geojson(source: str | Path | Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
    """Return what messages call a source of GeoJSON, and what it holds."""
    if isinstance(source, Mapping):
        return "", source
    is_text = isinstance(source, str) and source.lstrip().startswith("{")
    name = "" if is_text else f"{source}: "
    text = source if is_text else Path(source).read_text(encoding="utf-8-sig")
    try:
        data = json.loads(str(text))
    except ValueError as error:
        raise ValueError(f"{name}it is no JSON: {shortened(error, 200)}") from None
    if not isinstance(data, Mapping):
        raise TypeError(f"{name}it is no GeoJSON, but holds a {type(data).__name__}")
    return name, data


def polygons_in(data: Mapping[str, Any]) -> BaseGeometry:
    """Return the polygons of a GeoJSON object, those of several features joined.

    Raises
    ------
    ValueError
        If it holds none, or is no GeoJSON.
    """
    load_modules("shapely.geometry")
    import shapely
    from shapely.geometry import shape

    if "features" in data:
        geometries = [each.get("geometry") for each in data["features"]]
    else:
        geometries = [data.get("geometry") if "geometry" in data else data]
    try:
        shapes = [shape(each) for each in geometries if each]
    except Exception as error:  # of a mapping that is no geometry shapely may say anything
        raise ValueError(f"it is no GeoJSON geometry: {shortened(error, 200)}") from None
    areas = [each for each in map(polygons_of, shapes) if each.geom_type in ("Polygon", "MultiPolygon")]
    if not areas:
        kinds = ", ".join(sorted({each.geom_type for each in shapes})) or "nothing"
        raise ValueError(f"it holds no polygon, but {kinds}")
    for area in areas:
        if not area.is_valid:
            raise ValueError(f"the contour is not a valid polygon: {shapely.is_valid_reason(area)}")
    return areas[0] if len(areas) == 1 else shapely.union_all(areas)


def crs_in(data: Mapping[str, Any]) -> str:
    """Return the coordinate reference system that a GeoJSON object names, ``""`` where it names none.

    Examples
    --------
    >>> crs_in({"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}})
    'EPSG:25832'
    """
    name = str(((data.get("crs") or {}).get("properties") or {}).get("name", ""))
    found = re.fullmatch(r"urn:ogc:def:crs:(\w+):[^:]*:(\w+)", name)
    return f"{found[1]}:{found[2]}" if found else name
