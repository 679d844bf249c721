"""Solutions read from files, and judged anew."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ContactWarning
from ..foundation.checks import vector
from ..foundation.text import shortened
from ..io.model_records import model_in, own_gap
from ..io.netcdf import read_netcdf
from ..io.zarr_stores import read_zarr
from ..problem.read import read
from .answered import judged_answer
from .solution import Solution
from .tolerances import DEFAULT_TOL

if TYPE_CHECKING:
    import xarray as xr

READERS: dict[str, Callable[[Path], xr.Dataset]] = {".nc": read_netcdf, ".zarr": read_zarr}
"""What reads a dataset with a model and its solution, by the suffix of the file in small letters."""


_ARRAYS = ".npz"
"""Suffix of the solutions of bare problems."""


def load_solution(path: str | Path, *, tol: float | str | None = None) -> Solution:
    """Return the solution that a file holds, with its model made anew and its answer judged anew.

    Nothing that the file says of the answer's worth is trusted: of status, bounds and contact states none is read. The
    model's numbers are those that were written, to the bit, and so is the gap.

    Parameters
    ----------
    path : str or Path
        ``.nc`` or ``.zarr``, as `Solution.save` and ``contactqp solve --out`` write them, or the ``.npz`` of a bare
        problem's solution.
    tol : float or str, optional
        What the answer is judged by, see `contactqp.solve`; by default what was asked for when it was solved.

    Returns
    -------
    Solution
        Its `backend` is the one that is named in the file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    OSError
        If it cannot be read.
    ValueError
        If its suffix is unknown, or it holds no model (no gap), or one that is none; the message names the file.

    Examples
    --------
    >>> import tempfile
    >>> import contactqp as cq
    >>> solution = cq.solve(cq.gallery.bowl(15), "psor")
    >>> again = load_solution(solution.save(Path(tempfile.mkdtemp()) / "bowl.nc"))
    >>> again.backend, again.status.value, bool((again.gap == solution.gap).all())
    ('psor', 'certified', True)
    """
    path = Path(path)
    suffix = path.suffix.lower()
    reader = READERS.get(suffix)
    if reader is None and suffix != _ARRAYS:
        raise ValueError(f"{path}: a solution is read from {', '.join(READERS)} or {_ARRAYS}, not from {path.suffix!r}")
    if not path.exists():
        raise FileNotFoundError(f"there is no file {path}")
    if reader is None:
        return _bare(path, tol)
    try:
        data = reader(path)
    except OSError as error:
        raise OSError(f"{path}: {error}") from None
    try:
        with warnings.catch_warnings():
            # What is strange about the model was told when it was made, and stands in the solution's cautions.
            warnings.simplefilter("ignore", ContactWarning)
            model = model_in(data)
            gap = own_gap(data, model)
        asked = float(data.attrs.get("tol", DEFAULT_TOL)) if tol is None else tol
        return judged_answer(model, gap, asked, str(data.attrs.get("backend", path.name)))
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: {shortened(error, 300)}") from None


def _bare(path: Path, tol: float | str | None) -> Solution:
    """Return the solution of a bare problem, which stands beside it in the file."""
    problem = read(path)
    with np.load(path, allow_pickle=False) as archive:
        told = {name: archive[name] for name in ("gap", "backend", "tol") if name in archive}
    if "gap" not in told:
        raise ValueError(f"{path}: it holds a problem, which contactqp.read returns, and no gap that solves it")
    try:
        gap = vector(told["gap"], problem.size, "gap")
        asked = float(told.get("tol", DEFAULT_TOL)) if tol is None else tol
        return judged_answer(problem, gap, asked, str(told.get("backend", path.name)))
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: {shortened(error, 300)}") from None
