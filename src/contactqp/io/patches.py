"""Contact patches: connected nodes in contact, with area, reaction and middle, as a table and as contours."""

from __future__ import annotations

from functools import singledispatch
from math import fsum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import load_modules
from ..models.base import ContactModel
from ..models.mesh_membrane import MeshMembrane
from ..models.on_area import AreaModel
from ..models.on_line import LineModel

if TYPE_CHECKING:
    import pandas as pd

    from ..foundation.checks import Mask, Vector
    from ..models.records import Answered

_ROUNDING = 1e-13
"""Part of a mesh's extent by which corners of neighbouring parts of triangles may differ."""

COLUMNS = ("patch", "nodes", "area", "reaction", "x", "y")


def patches_of(solution: Answered, model: ContactModel) -> pd.DataFrame:
    """Return a row for each contact patch of a solution; see `Solution.patches`."""
    labels, count = model.contact_patches(solution.contact)
    table = table_of(labels, count, solution.reaction, model.node_x, model.node_y, model.node_area)
    if solution.certificate is not None:
        table["certain"] = np.bincount(labels[solution.certificate.contact], minlength=count + 1)[1:]
    return table


def table_of(
    labels: NDArray[np.int64], count: int, reaction: Vector, x: Vector, y: Vector, area: Vector | None
) -> pd.DataFrame:
    """Return a row for each patch.

    Parameters
    ----------
    labels : array of int, shape (n,)
        Patch of each node, from 1 on; 0 for none.
    count : int
        Number of patches.
    reaction, x, y : array, shape (n,)
        Force, and places in plan (length).
    area : array, shape (n,), or None
        What each node stands for.
    """
    load_modules("pandas")
    import pandas as pd

    order = np.argsort(labels, kind="stable")
    order = order[np.count_nonzero(labels == 0) :]
    parts = np.split(order, np.searchsorted(labels[order], np.arange(2, count + 1))) if count else []
    rows = [
        {
            "patch": number,
            "nodes": nodes.size,
            "area": np.nan if area is None else fsum(area[nodes]),
            "reaction": fsum(reaction[nodes]),
            "x": float(x[nodes].mean()),
            "y": float(y[nodes].mean()),
        }
        for number, nodes in enumerate(parts, 1)
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


@singledispatch
def contour_of(model: ContactModel, nodes: NDArray[np.intp]) -> Any:
    """Return the shapely geometry that the nodes of a patch cover: points, where nodes stand for no area."""
    load_modules("shapely")
    import shapely

    return shapely.MultiPoint(np.column_stack([model.node_x[nodes], model.node_y[nodes]]))


@contour_of.register(AreaModel)
def _squares(model: AreaModel, nodes: NDArray[np.intp]) -> Any:
    """Return the contour of the squares that the nodes stand for."""
    load_modules("shapely")
    import shapely

    lattice = model.lattice
    # Through whole numbers, so that neighbouring squares have the same corners.
    row, column = np.nonzero(lattice.scatter(_mask(model.size, nodes), fill=False))
    contour = shapely.union_all(shapely.box(column - 0.5, row - 0.5, column + 0.5, row + 0.5))
    origin = np.array(lattice.origin)
    return shapely.transform(shapely.simplify(contour, 0.0), lambda places: origin + lattice.spacing * places)


@contour_of.register(MeshMembrane)
def _thirds_of_triangles(model: MeshMembrane, nodes: NDArray[np.intp]) -> Any:
    """Return the contour of what the nodes stand for: of each triangle the third between a corner and the centroid."""
    load_modules("shapely")
    import shapely

    triangle, corner = np.nonzero(np.isin(model.triangles, model.free[nodes]))
    place = model.positions[model.triangles[triangle]]
    own, after, before = (place[np.arange(corner.size), (corner + k) % 3] for k in range(3))
    thirds = np.stack([own, (own + after) / 2, (own + after + before) / 3, (own + before) / 2], axis=1)
    return shapely.union_all(shapely.polygons(thirds), grid_size=_ROUNDING * max(model.extent))


@contour_of.register(LineModel)
def _stretch(model: LineModel, nodes: NDArray[np.intp]) -> Any:
    """Return the line that the nodes stand for."""
    load_modules("shapely")
    import shapely

    x, half = model.node_x[nodes], model.lattice.spacing / 2
    return shapely.LineString([(x.min() - half, 0.0), (x.max() + half, 0.0)])


def _mask(size: int, nodes: NDArray[np.intp]) -> Mask:
    mask = np.zeros(size, dtype=np.bool_)
    mask[nodes] = True
    return mask
