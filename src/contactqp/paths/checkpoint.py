"""Checkpoint: a NetCDF file that keeps the answers of a load path that is not finished yet."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from ..foundation.checks import Vector
from ..foundation.files import replaced_as_a_whole, require_folder
from ..foundation.loading import load_modules
from ..models.base import ContactModel
from ..models.varied import VARIED
from ..proof.judge import judge
from ..solving.request import Request
from ..solving.solution import Run, Solution


class Checkpoint:
    """What has been done of a path, in a file.

    Parameters
    ----------
    path : Path
        It is made if it is missing.
    model : Membrane, Cable or CableNet
    parameter, backend : str
        See `trace`.

    Raises
    ------
    ValueError
        If the file belongs to another path, or is no checkpoint, or its folder is missing.
    """

    def __init__(self, path: Path, model: ContactModel, parameter: str, backend: str) -> None:
        self._path, self._model, self._parameter, self._backend = path, model, parameter, backend
        require_folder(path, "checkpoint")
        self._mark = _mark(model, parameter, backend)

    def restored(self, values: Vector, tol: float | str) -> list[tuple[Solution, int]]:
        """Return the solutions that the file holds of a path's first values, judged anew, and their cold iterations."""
        load_modules("xarray")
        import xarray as xr

        if not self._path.exists():
            return []
        try:
            with xr.open_dataset(self._path, engine="netcdf4") as file:
                data = file.load()
        except OSError as error:
            raise ValueError(f"{self._path} is no checkpoint ({error}); remove it or name another file") from None
        if data.attrs.get("mark") != self._mark:
            raise ValueError(
                f"the checkpoint {self._path} belongs to another model, parameter or backend; remove it or name another"
            )
        missing = {"value", "gap", "cold_iterations", "iterations", "termination"} - set(data.variables)
        if missing:
            raise ValueError(f"{self._path} is no whole checkpoint: {', '.join(sorted(missing))} missing; remove it")
        kept = data["value"].to_numpy()
        same = min(kept.size, values.size)
        differing = np.flatnonzero(kept[:same] != values[:same])
        count = int(differing[0]) if differing.size else same
        if same and not count:
            raise ValueError(
                f"the checkpoint {self._path} begins with {self._parameter} {kept[0]:g}, not {values[0]:g}; "
                "remove it or name another, so that nothing is lost"
            )
        return [self._solution(data.isel(step=k), float(values[k]), tol) for k in range(count)]

    def keep(self, values: Vector, solutions: list[Solution], cold_iterations: list[int]) -> None:
        """Write all that is done, and replace the file as a whole."""
        load_modules("xarray")
        import xarray as xr

        columns: dict[str, Any] = {
            "value": ("step", values),
            "gap": (("step", "node"), np.array([solution.gap for solution in solutions])),
            "cold_iterations": ("step", np.array(cold_iterations)),
        }
        for name in ("iterations", "setup_seconds", "solve_seconds", "seconds"):
            columns[name] = ("step", np.array([getattr(solution, name) for solution in solutions]))
        columns["termination"] = ("step", np.array([solution.termination for solution in solutions], dtype=object))
        unit = solutions[0].iteration_unit
        data = xr.Dataset(columns, attrs={"mark": self._mark, "backend": self._backend, "iteration_unit": unit})
        with replaced_as_a_whole(self._path) as unfinished:
            data.to_netcdf(unfinished, engine="netcdf4")

    def _solution(self, step: Any, value: float, tol: float | str) -> tuple[Solution, int]:
        model = VARIED[self._parameter](self._model, value)
        gap, request = step["gap"].to_numpy(), Request.of(tol)
        verdict = judge(model.problem, gap, request.tolerance.tol, model=model)
        run = Run(
            backend=self._backend,
            gap=gap,
            termination=str(step["termination"].item()),
            iterations=int(step["iterations"]),
            iteration_unit=str(step.attrs["iteration_unit"]),
            setup_seconds=float(step["setup_seconds"]),
            solve_seconds=float(step["solve_seconds"]),
            seconds=float(step["seconds"]),
            note=f"restored from {self._path.name}",
        )
        return Solution(model, request, run, verdict), int(step["cold_iterations"])


def _mark(model: ContactModel, parameter: str, backend: str) -> str:
    """Return a fingerprint of what a path is made of."""
    digest = hashlib.sha256(f"{parameter} {backend} {model!r}".encode())
    for data in (*model.stiffness_data, model.problem.q, model.load, model.support):
        digest.update(np.ascontiguousarray(data).tobytes())
    return digest.hexdigest()
