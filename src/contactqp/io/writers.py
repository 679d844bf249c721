"""File formats of solutions: what writes one, by the suffix of the file."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.files import replaced_as_a_whole, require_writable
from ..foundation.loading import needed
from ..problem.program_files import arrays_of
from .carried import Carried, fields_with
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


def write_solution(solution: Answered, model: ContactModel, path: Path, carried: Carried | None = None) -> None:
    """Write a model's solution into a file of the format that its suffix names, replacing one of that name as a whole.

    Parameters
    ----------
    solution : Solution
    model : Membrane, Cable, CableNet or another model
        The solution's.
    path : Path
        Its suffix must be one of `WRITERS`, and its folder must exist.
    carried : Carried, optional
        Bounds of the membrane itself, which go along.

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
    if carried is not None:
        require_room(path, none_at_nodes=not carried.at_nodes)
    with replaced_as_a_whole(path) as unfinished:
        WRITERS[path.suffix.lower()](solution, model, unfinished, carried)


_WITHOUT_NUMBERS, _WITHOUT_BOUNDS = (".csv",), (".geojson",)
"""Files that hold columns of nodes and nothing else, and those that bounds do not go into."""


def holds_bounds(path: Path) -> bool:
    """Whether a file of such a suffix has room for bounds of the membrane itself at the nodes."""
    return path.suffix.lower() not in _WITHOUT_BOUNDS


def require_room(path: Path, *, none_at_nodes: bool = False) -> None:
    """Raise a ValueError unless a file of such a suffix has room for bounds of the membrane itself.

    Parameters
    ----------
    path : Path
    none_at_nodes : bool
        Whether there are numbers only, as where no more than a membrane's energy was enclosed.
    """
    if not holds_bounds(path):
        known = " ".join(suffix for suffix in WRITERS if suffix not in _WITHOUT_BOUNDS)
        raise ValueError(
            f"{path}: bounds of the membrane itself go into {known} files; write the answer alone, or one of those"
        )
    if none_at_nodes and path.suffix.lower() in _WITHOUT_NUMBERS:
        raise ValueError(
            f"{path}: a table of nodes takes bounds at the nodes, and of an energy there are none; ask for "
            "'pointwise', or write .nc"
        )


def write_bare(solution: Answered, path: Path) -> None:
    r"""Write the solution of a bare problem, which has no places, into ``.csv`` or ``.npz``.

    A table has a line for each node, with its number, gap, reaction, the bounds of the gap, whether it touches, and
    with a certificate what is proven. Arrays have the same names, and beside them the problem by the names of
    `contactqp.read`, which reads it; `contactqp.load_solution` reads the solution.

    Raises
    ------
    ValueError
        If it cannot become such a file.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> file = Path(tempfile.mkdtemp()) / "two.csv"
    >>> write_bare(cq.solve(cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])), file)
    >>> print("\n".join(line[:20] for line in file.read_text().splitlines()))
    node,gap,reaction,lo
    0,0.5,0.0,0.0,inf,0,
    1,0.0,2.5,0.0,inf,1,
    """
    require_writable(path, tuple(BARE_WRITERS), "solution of a bare problem")
    with replaced_as_a_whole(path) as unfinished:
        BARE_WRITERS[path.suffix.lower()](solution, unfinished)


def _columns_of_bare(solution: Answered) -> dict[str, Vector | Mask]:
    fields = {name: field.values for name, field in fields_of(solution).items()}
    bounds = {name: np.array(getattr(solution.problem, name)) for name in ("lower", "upper")}
    return {"gap": fields.pop("gap"), "reaction": fields.pop("reaction"), **bounds, **fields}


def _write_bare_table(solution: Answered, path: Path) -> None:
    _write_columns(_columns_of_bare(solution), solution.problem.size, path)


def _write_bare_arrays(solution: Answered, path: Path) -> None:
    told = {"backend": solution.backend, "tol": solution.tol}
    problem = arrays_of(solution.problem, solution.problem.gap_scale)
    with path.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **problem | _columns_of_bare(solution) | told)


BARE_WRITERS: dict[str, Callable[[Answered, Path], None]] = {".csv": _write_bare_table, ".npz": _write_bare_arrays}
"""What writes the solution of a bare problem, by the suffix of the file in small letters."""


def _write_netcdf(solution: Answered, model: ContactModel, path: Path, carried: Carried | None) -> None:
    """Write the dataset that `Solution.to_dataset` returns, by the conventions of CF, and the model."""
    write_netcdf_anew(file_dataset(solution, model, carried), path)


def _write_zarr(solution: Answered, model: ContactModel, path: Path, carried: Carried | None) -> None:
    """Write the same dataset as a Zarr store, a folder."""
    write_zarr(file_dataset(solution, model, carried), path)


def _write_table(solution: Answered, model: ContactModel, path: Path, carried: Carried | None) -> None:
    """Write a line for each node, with number, x, y and every quantity, below a line of names."""
    fields = {name: field.values for name, field in fields_with(solution, carried).items()}
    _write_columns({"x": model.node_x, "y": model.node_y, **fields}, model.size, path)


def _write_columns(columns: dict[str, Vector | Mask], size: int, path: Path) -> None:
    """Write a line for each node, its number first, below a line of names."""
    # Yes and no as 1 and 0, which every program reads.
    nodes = zip(range(size), *(np.multiply(values, 1).tolist() for values in columns.values()), strict=True)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("node", *columns))
        writer.writerows(nodes)


def _write_patches(solution: Answered, model: ContactModel, path: Path, carried: Carried | None) -> None:
    """Write the contact patches; bounds do not go into them, see `require_room`."""
    write_geojson(solution, model, path)


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


WRITERS: dict[str, Callable[[Answered, ContactModel, Path, Carried | None], None]] = {
    ".nc": _write_netcdf,
    ".csv": _write_table,
    ".zarr": _write_zarr,
    ".vti": write_image,
    ".vtu": write_surface,
    ".tif": write_geotiff,
    ".geojson": _write_patches,
}
"""What writes a solution, by the suffix of the file, in small letters.

Each takes a solution, its model, the path of a file that is written anew, whose suffix may be another one, because it
takes its name when it is done, and bounds of the membrane itself that go along, or None. It writes what
`contactqp.io.carried.fields_with` returns: values in node order, shape (n,), unit and meaning of each by its name.
"""

_REQUIREMENTS: dict[str, tuple[Callable[[ContactModel], object], ...]] = {
    ".zarr": (lambda model: needed("zarr", "writing .zarr", ZARR),),
    ".vti": (require_lattice, lambda model: needed("pyvista", "writing .vti", VTK)),
    ".vtu": (lambda model: needed("pyvista", "writing .vtu", VTK),),
    ".tif": (require_membrane, lambda model: needed("rasterio", "writing .tif", GEO)),
}
"""What must hold before there is work to do, by the suffix of the file."""
