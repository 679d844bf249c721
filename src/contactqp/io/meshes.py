"""Solutions as meshes of PyVista: the deflected shape in space, and a lattice's array as an image; and as VTK files."""

from __future__ import annotations

from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import needed
from ..models.base import ContactModel
from ..models.cable_net import CableNet
from ..models.mesh_membrane import MeshMembrane
from ..models.on_lattice import LatticeModel
from .carried import Carried, fields_with
from .provenance import provenance_of

if TYPE_CHECKING:
    from ..foundation.checks import Vector
    from ..models.records import Answered

INSTALL = "contactqp[vtk]"

_STATE = "contact_state"


class Shape(NamedTuple):
    """Points of a model, frame included, and what joins them.

    Attributes
    ----------
    x, y, deflection : array, shape (points,)
        Places in plan and heights as the model has them (length).
    node : array of int, shape (n,)
        Which of the points are the nodes, in their order.
    cells : array of int, shape (cells, 2, 3 or 4)
        Numbers of the points at the ends of a segment, or around a triangle or a square; of a triangle among squares
        with one -1.
    """

    x: Vector
    y: Vector
    deflection: Vector
    node: NDArray[np.int64]
    cells: NDArray[np.int64]


@singledispatch
def shape_of(model: ContactModel, gap: Vector) -> Shape:
    """Return the shape of a model at a gap; of a model of one's own its nodes, joined as its stiffness joins them."""
    upper = model.problem.G.tocoo()
    joined = (upper.row < upper.col) & (upper.data != 0)
    cells = np.column_stack([upper.row[joined], upper.col[joined]]).astype(np.int64)
    return Shape(model.node_x, model.node_y, model.deflection(gap), np.arange(model.size), cells)


@shape_of.register(LatticeModel)
def _on_lattice(model: LatticeModel, gap: Vector) -> Shape:
    nodes = model.padded_mask()
    there = nodes | model.frame_points()
    number = np.full(there.shape, -1, dtype=np.int64)
    number[there] = np.arange(np.count_nonzero(there))
    x, y = model.lattice.ring_coordinates(*np.nonzero(there))
    corners = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
    squares = np.stack(corners, axis=-1).reshape(-1, 4)
    # A corner of the contour that no arm meets is no frame point: there is a triangle. Squares of frame points alone
    # lie outside.
    node = np.append(nodes[there], False)
    cells = squares[(np.count_nonzero(squares >= 0, axis=1) >= 3) & node[squares].any(axis=1)]
    if not cells.size:  # a cable
        row, column = np.nonzero(there[:, :-1] & there[:, 1:])
        cells = np.column_stack([number[row, column], number[row, column + 1]])
    return Shape(x, y, model.padded_deflection(gap)[there], number[nodes], cells)


@shape_of.register(CableNet)
def _of_net(model: CableNet, gap: Vector) -> Shape:
    heights = model.point_heights(model.deflection(gap))
    x, y = model.positions.T
    return Shape(x, y, heights, np.asarray(model.free), np.asarray(model.segments))


@shape_of.register(MeshMembrane)
def _of_triangles(model: MeshMembrane, gap: Vector) -> Shape:
    heights = model.point_heights(model.deflection(gap))
    x, y = model.positions.T
    return Shape(x, y, heights, np.asarray(model.free), np.asarray(model.triangles))


def surface_of(solution: Answered, model: ContactModel, carried: Carried | None = None) -> Any:
    """Return the deflected shape as a `pyvista.UnstructuredGrid`; see `Solution.to_pyvista`."""
    pyvista = needed("pyvista", "to_pyvista", INSTALL)
    shape = shape_of(model, solution.gap)
    elevation = shape.deflection if model.upwards else -shape.deflection
    corners = np.count_nonzero(shape.cells >= 0, axis=1)
    told = np.column_stack([corners, shape.cells])
    kinds = np.array([0, 0, pyvista.CellType.LINE, pyvista.CellType.TRIANGLE, pyvista.CellType.QUAD], dtype=np.uint8)
    points = np.column_stack([shape.x, shape.y, elevation])
    mesh = pyvista.UnstructuredGrid(told[told >= 0], kinds[corners], points)
    for name, values in _point_data(solution, model, carried).items():
        everywhere = np.full(shape.x.shape, 0 if values.dtype == np.uint8 else np.nan, dtype=values.dtype)
        everywhere[shape.node] = values
        mesh.point_data[name] = everywhere
    mesh.point_data["deflection"] = shape.deflection
    mesh.point_data["elevation"] = elevation
    return _described(mesh, solution, model, carried)


def image_of(solution: Answered, model: ContactModel, carried: Carried | None = None) -> Any:
    """Return the fields on a lattice's array as a `pyvista.ImageData`; see `Solution.to_pyvista`.

    Raises
    ------
    TypeError
        If the model has no lattice.
    """
    require_lattice(model)
    assert isinstance(model, LatticeModel)
    pyvista = needed("pyvista", "to_pyvista", INSTALL)
    lattice = model.lattice
    rows, columns = lattice.shape
    image = pyvista.ImageData(
        dimensions=(columns, rows, 1), spacing=(lattice.spacing,) * 3, origin=(*lattice.origin, 0.0)
    )
    for name, values in _point_data(solution, model, carried).items():
        grid = lattice.scatter(values, fill=0 if values.dtype == np.uint8 else np.nan)
        image.point_data[name] = grid.ravel()
    return _described(image, solution, model, carried)


def require_lattice(model: ContactModel) -> None:
    """Raise a TypeError unless a model's nodes lie on a lattice."""
    if not isinstance(model, LatticeModel):
        raise TypeError(f"it takes a model on a lattice, this one is {model!r}; write .vtu, .nc or .csv")


def _point_data(solution: Answered, model: ContactModel, carried: Carried | None) -> dict[str, NDArray[Any]]:
    """Return the fields at the nodes, with yes and no as bytes, and elevations for filters that warp by them."""
    data: dict[str, NDArray[Any]] = {
        name: field.values.astype(np.uint8) if field.values.dtype == np.bool_ else np.array(field.values)
        for name, field in fields_with(solution, carried).items()
    }
    upwards = 1.0 if model.upwards else -1.0
    data["elevation"] = upwards * data["deflection"]
    data["support_elevation"] = np.where(np.isfinite(data["support"]), upwards * data["support"], np.nan)
    return data


def _described(mesh: Any, solution: Answered, model: ContactModel, carried: Carried | None) -> Any:
    for name, value in (provenance_of(solution, model) | ({} if carried is None else carried.facts)).items():
        mesh.field_data[name] = [value]
    mesh.set_active_scalars(_STATE if _STATE in mesh.point_data else "contact")
    return mesh


def write_image(solution: Answered, model: ContactModel, path: Path, carried: Carried | None = None) -> None:
    """Write the fields on a lattice's array as a VTK image, which ParaView warps by ``elevation``."""
    image_of(solution, model, carried).save(path)


def write_surface(solution: Answered, model: ContactModel, path: Path, carried: Carried | None = None) -> None:
    """Write the deflected shape as a VTK mesh, which ParaView shows in space, coloured by the contact state."""
    mesh = surface_of(solution, model, carried)
    # Words are left out: readers of other projects, such as meshio, refuse files with them.
    words = [name for name in list(mesh.field_data) if np.asarray(mesh.field_data[name]).dtype.kind not in "iuf"]
    for name in words:
        mesh.field_data.remove(name)
    mesh.save(path)
