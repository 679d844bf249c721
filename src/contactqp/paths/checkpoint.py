"""Checkpoint: a NetCDF file that keeps the answers of a load path that is not finished yet."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..foundation.checks import Vector
from ..foundation.files import held, require_folder
from ..foundation.loading import load_modules
from ..io.netcdf import read_netcdf, write_netcdf
from ..models.base import ContactModel
from ..proof.judge import judge
from ..solving.request import Request
from ..solving.solution import Run, Solution


@dataclass(frozen=True)
class _Entry:
    """What is kept of the answer for one value: the attributes of a `Run` by their names."""

    gap: Vector
    cold_iterations: int
    iterations: int
    setup_seconds: float
    solve_seconds: float
    seconds: float
    termination: str

    @classmethod
    def of(cls, solution: Solution, cold_iterations: int) -> _Entry:
        return cls(
            solution.gap,
            cold_iterations,
            solution.iterations,
            solution.setup_seconds,
            solution.solve_seconds,
            solution.seconds,
            solution.termination,
        )


_NAMES = tuple(_Entry.__dataclass_fields__)


class Checkpoint:
    """The answers that have been found for a model, by the value of the parameter that is varied, in a file.

    Nothing is taken out of it: answers to other values are added, and one is replaced only by another for the same
    value. It must be entered (`held`) before it is asked or written.

    Parameters
    ----------
    path : Path
        It is made if it is missing.
    model : Membrane, Cable or CableNet
    parameter, backend : str
        See `trace`.
    tol : float or str
        What answers are judged by.
    more : sequence of array
        What else the answers depend on.

    Raises
    ------
    ValueError
        If its folder is missing.
    """

    def __init__(
        self,
        path: Path,
        model: ContactModel,
        parameter: str,
        backend: str,
        tol: float | str,
        more: Sequence[Vector] = (),
    ) -> None:
        self._path, self._backend = path, backend
        self._request = Request.of(tol)
        require_folder(path, "checkpoint")
        self._mark = _mark(model, parameter, backend, more)
        self._entries: dict[float, _Entry] = {}
        self._iteration_unit = ""

    @contextmanager
    def held(self) -> Iterator[Checkpoint]:
        """Keep the file to oneself, and read what it holds.

        Raises
        ------
        ValueError
            If another thread or process has it, or it belongs to another path, or is no checkpoint.
        """
        with held(self._path, "checkpoint"):
            if self._path.exists():
                self._read()
            yield self

    def restored(self, value: float, model: ContactModel) -> tuple[Solution | None, int]:
        """Return the kept answer for a value, judged anew, and its cold iterations; None and -1 without one.

        Parameters
        ----------
        value : float
        model : Membrane, Cable or CableNet
            The model at that value.
        """
        entry = self._entries.get(value)
        if entry is None:
            return None, -1
        verdict = judge(model.problem, entry.gap, self._request.tolerance.tol, model=model)
        run = Run(
            backend=self._backend,
            gap=entry.gap,
            termination=entry.termination,
            iterations=entry.iterations,
            iteration_unit=self._iteration_unit,
            setup_seconds=entry.setup_seconds,
            solve_seconds=entry.solve_seconds,
            seconds=entry.seconds,
            note=f"restored from {self._path.name}",
        )
        return Solution(model, self._request, run, verdict), entry.cold_iterations

    def keep(self, value: float, solution: Solution, cold_iterations: int) -> None:
        """Write an answer beside all others, and replace the file as a whole."""
        load_modules("xarray")
        import xarray as xr

        self._entries[value] = _Entry.of(solution, cold_iterations)
        self._iteration_unit = solution.iteration_unit
        columns: dict[str, Any] = {"value": ("step", np.array(list(self._entries)))}
        for name in _NAMES:
            kept = [getattr(entry, name) for entry in self._entries.values()]
            axes = ("step", "node") if name == "gap" else "step"
            columns[name] = (axes, np.array(kept, dtype=object if name == "termination" else None))
        unit = self._iteration_unit
        data = xr.Dataset(columns, attrs={"mark": self._mark, "backend": self._backend, "iteration_unit": unit})
        write_netcdf(data, self._path)

    def _read(self) -> None:
        try:
            data = read_netcdf(self._path)
        except OSError as error:
            raise ValueError(f"{self._path} is no checkpoint ({error}); remove it or name another file") from None
        if data.attrs.get("mark") != self._mark:
            raise ValueError(
                f"the checkpoint {self._path} belongs to another model, parameter or backend; remove it or name another"
            )
        missing = {"value", *_NAMES} - set(data.variables)
        if missing:
            raise ValueError(f"{self._path} is no whole checkpoint: {', '.join(sorted(missing))} missing; remove it")
        columns = [data[name].to_numpy() for name in ("value", *_NAMES)]
        for value, gap, cold, iterations, setup, solving, seconds, words in zip(*columns, strict=True):
            times = float(setup), float(solving), float(seconds)
            self._entries[float(value)] = _Entry(gap, int(cold), int(iterations), *times, str(words))
        self._iteration_unit = str(data.attrs["iteration_unit"])


def _mark(model: ContactModel, parameter: str, backend: str, more: Sequence[Vector]) -> str:
    """Return a fingerprint of what a path is made of."""
    digest = hashlib.sha256(f"{parameter} {backend} {model!r}".encode())
    ceiling = () if model.ceiling is None else (model.ceiling,)
    for data in (*model.stiffness_data, model.problem.q, model.load, model.support, *ceiling, *more):
        digest.update(np.ascontiguousarray(data).tobytes())
    return digest.hexdigest()
