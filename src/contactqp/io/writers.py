"""File formats of solutions: what writes one, by the suffix of the file."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.files import replaced_as_a_whole, require_writable
from ..foundation.loading import needed
from .datasets import file_dataset
from .fields import fields_of
from .geojson import write_geojson
from .geotiff import INSTALL as GEO
from .geotiff import require_membrane, write_geotiff
from .meshes import INSTALL as VTK
from .meshes import require_lattice, write_image, write_surface
from .netcdf import write_netcdf_anew
from .zarr_stores import INSTALL as ZARR
from .zarr_stores import write_zarr

if TYPE_CHECKING:
    from ..models.base import ContactModel
    from ..models.records import Answered


def write_solution(solution: Answered, model: ContactModel, path: Path) -> None:
    """Write a model's solution into a file of the format that its suffix names, replacing one of that name as a whole.

    Parameters
    ----------
    solution : Solution
    model : Membrane, Cable, CableNet or another model
        The solution's.
    path : Path
        Its suffix must be one of `WRITERS`, and its folder must exist.

    Raises
    ------
    ValueError
        If it cannot become such a file.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> cable = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    >>> file = Path(tempfile.mkdtemp()) / "cable.csv"
    >>> write_solution(cq.solve(cable), cable, file)
    >>> file.read_text().splitlines()[1].split(",")[:5]
    ['0', '1.0', '0.0', '0.0', '1.0']
    """
    require_writable(path, tuple(WRITERS), "solution")
    require_suitable(path, model)
    with replaced_as_a_whole(path) as unfinished:
        WRITERS[path.suffix.lower()](solution, model, unfinished)


def _write_netcdf(solution: Answered, model: ContactModel, path: Path) -> None:
    """Write the dataset that `Solution.to_dataset` returns, by the conventions of CF, and the model."""
    write_netcdf_anew(file_dataset(solution, model), path)


def _write_zarr(solution: Answered, model: ContactModel, path: Path) -> None:
    """Write the same dataset as a Zarr store, a folder."""
    write_zarr(file_dataset(solution, model), path)


def _write_table(solution: Answered, model: ContactModel, path: Path) -> None:
    """Write a line for each node, with number, x, y and every quantity, below a line of names."""
    fields = fields_of(solution)
    # Yes and no as 1 and 0, which every program reads.
    columns = [np.multiply(field.values, 1).tolist() for field in fields.values()]
    nodes = zip(range(model.size), model.node_x.tolist(), model.node_y.tolist(), *columns, strict=True)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("node", "x", "y", *fields))
        writer.writerows(nodes)


def require_suitable(path: Path, model: ContactModel) -> None:
    """Raise unless a model can be written into a file of such a suffix, and what writes it is installed.

    Raises
    ------
    TypeError, ValueError
        If the format does not take such a model.
    ImportError
        If a package is missing; the message says what to type.
    """
    suffix = path.suffix.lower()
    try:
        for requirement in _REQUIREMENTS.get(suffix, ()):
            requirement(model)
    except TypeError as error:
        raise TypeError(f"cannot write {path}: {error}") from None


WRITERS: dict[str, Callable[[Answered, ContactModel, Path], None]] = {
    ".nc": _write_netcdf,
    ".csv": _write_table,
    ".zarr": _write_zarr,
    ".vti": write_image,
    ".vtu": write_surface,
    ".tif": write_geotiff,
    ".geojson": write_geojson,
}
"""What writes a solution, by the suffix of the file, in small letters.

Each takes a solution, its model, and the path of a file that is written anew, whose suffix may be another one, because
it takes its name when it is done. It writes what `contactqp.io.fields.fields_of` returns: values in node order, shape
(n,), unit and meaning of every quantity by name.
"""

_REQUIREMENTS: dict[str, tuple[Callable[[ContactModel], object], ...]] = {
    ".zarr": (lambda model: needed("zarr", "writing .zarr", ZARR),),
    ".vti": (require_lattice, lambda model: needed("pyvista", "writing .vti", VTK)),
    ".vtu": (lambda model: needed("pyvista", "writing .vtu", VTK),),
    ".tif": (require_membrane, lambda model: needed("rasterio", "writing .tif", GEO)),
}
"""What must hold before there is work to do, by the suffix of the file."""
