"""Meshes of triangles as other programs have them: files that meshio reads, such as Gmsh's, and scikit-fem's."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..foundation.checks import Vector
from ..foundation.loading import needed
from ..foundation.text import shortened
from .scikit_fem import INSTALL
from .triangles import Numbers

_CORNERS = {"vertex": 1, "line": 2, "triangle": 3}
"""Cells that are taken, with the points that each has."""

_LEVEL = 1e-9
"""Part of its extent by which a mesh may leave its plane."""


class Source(NamedTuple):
    """A mesh as it was found; see `TriangleMesh` for what the parts are."""

    points: Vector
    triangles: Numbers
    groups: dict[str, Numbers]


def of_meshio(source: Any) -> Source:
    """Return the triangles of a meshio mesh, or of a file that meshio reads, with its groups by name.

    Parameters
    ----------
    source : str, Path or meshio.Mesh
        Points that no triangle uses, such as the centres of arcs in Gmsh's files, are left out.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it cannot be read, leaves its plane, or holds other cells than triangles, lines and points.
    ImportError
        If meshio is not installed.
    """
    meshio = needed("meshio", "MeshMembrane.from_meshio", INSTALL)
    if not isinstance(source, (str, Path)):
        return _taken(source)
    path = Path(source)
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {shortened(path, 200)}")
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            read = meshio.read(path)
        return _taken(read)
    except (Exception, SystemExit) as error:  # meshio says so and ends the program where no format fits
        told = "no format that meshio knows" if isinstance(error, SystemExit) else str(error)
        raise ValueError(f"{path}: cannot be read as a mesh: {shortened(told, 300)}") from None


def of_skfem(mesh: Any) -> Source:
    """Return the triangles of a scikit-fem mesh, with its boundaries and subdomains as groups.

    Raises
    ------
    TypeError
        If it is no mesh of straight triangles in plan.
    """
    points, triangles = np.asarray(getattr(mesh, "p", None)), np.asarray(getattr(mesh, "t", None))
    fits = points.shape[:1] == (2,) and triangles.shape[:1] == (3,)
    if not fits or points.shape[1] != triangles.max(initial=-1) + 1:  # curved ones have points between their corners
        raise TypeError(f"mesh must be a skfem.MeshTri of straight triangles, got {shortened(repr(mesh), 100)}")
    groups = {str(name): mesh.facets[:, np.asarray(cells)].T for name, cells in (mesh.boundaries or {}).items()}
    groups |= {str(name): triangles[:, np.asarray(cells)].T for name, cells in (mesh.subdomains or {}).items()}
    return Source(np.array(points.T), np.array(triangles.T), groups)


def _taken(mesh: Any) -> Source:
    kinds = {block.type for block in mesh.cells}
    if "triangle" not in kinds or not kinds <= set(_CORNERS):
        found = ", ".join(sorted(kinds)) or "none"
        raise ValueError(
            f"a mesh of triangles of three points is needed, beside which there may be lines and points; it has {found}"
        )
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > _LEVEL * float(np.ptp(points, axis=0).max()):
        low, high = points[:, 2].min(), points[:, 2].max()
        raise ValueError(f"the mesh must lie in a plane of one z, but z goes from {low:g} to {high:g}")
    triangles = np.concatenate([block.data for block in mesh.cells if block.type == "triangle"]).astype(np.int64)
    used = np.unique(triangles)
    number = np.full(len(points), -1, dtype=np.int64)
    number[used] = np.arange(used.size)
    gathered: dict[str, list[Numbers]] = {}
    for name, cells in _groups(mesh):
        renumbered = number[cells.reshape(len(cells), -1)]
        gathered.setdefault(name, []).append(renumbered[(renumbered >= 0).all(axis=1)])
    return Source(points[used, :2], number[triangles], {name: _joined(parts) for name, parts in gathered.items()})


def _groups(mesh: Any) -> Iterator[tuple[str, Numbers]]:
    """Yield what belongs to a group, cells block by block: sets by name, and Gmsh's physical groups."""
    names = {(int(tag), int(dimension)): str(name) for name, (tag, dimension) in mesh.field_data.items()}
    physical = mesh.cell_data.get("gmsh:physical", [None] * len(mesh.cells))
    for block, tags in zip(mesh.cells, physical, strict=True):
        for tag in [] if tags is None else np.unique(tags).tolist():
            # Those without a name, which have the number 0 if they belong to no group, go by their number.
            name = names.get((int(tag), _CORNERS[block.type] - 1), str(int(tag)) if tag else "")
            if name:
                yield name, np.asarray(block.data)[np.asarray(tags) == tag].astype(np.int64)
    for name, sets in mesh.cell_sets.items():
        for block, chosen in zip(mesh.cells, sets, strict=True):
            if chosen is not None and len(chosen) and not name.startswith("gmsh:"):
                yield str(name), np.asarray(block.data)[np.asarray(chosen, dtype=np.int64)].astype(np.int64)
    for name, chosen in mesh.point_sets.items():
        yield str(name), np.asarray(chosen, dtype=np.int64)


def _joined(parts: list[Numbers]) -> Numbers:
    """Return the cells of a group: as points, where they are of several kinds or points."""
    if len({part.shape[1] for part in parts}) > 1 or parts[0].shape[1] == 1:
        return np.unique(np.concatenate([part.ravel() for part in parts]))
    return np.unique(np.concatenate(parts), axis=0)
