"""TimeHistory: how a damped model moves over its support in time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.brackets import Bracket
from ..foundation.cards import card
from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.text import counted
from ..models.base import ContactModel
from ..solving.solution import Solution
from .answer_path import AnswerPath, stacked

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class TimeHistory(AnswerPath):
    """The states of a damped model at times.

    Made by `march`. Printing it shows a table; `to_frame` returns the table as data, `to_dataset` all fields.

    What is certified is each step: its bound is that of the error against the exact solution of the step's discrete
    problem, given the state before as it was computed. How far the steps themselves are from the motion in continuous
    time no bound says.

    Attributes
    ----------
    model : Membrane, Cable or CableNet
    times : array, shape (k + 1,)
    initial : array, shape (n,)
        Deflection at the first time (length), positive as the model's heights.
    solutions : tuple of Solution
        One for each later time. Each is that of the step's own problem, whose model has the damping in its foundation
        and the state before in its load; `reactions` and `total_reaction` are those of the model itself.
    method : {"crank-nicolson", "euler"}
    loads : array, shape (k + 1, n)
        Active load at the times, in the unit of the model's.
    shares : tuple of float
        What reactions of the steps' problems are to be multiplied by: a step of Crank and Nicolson's method is posed
        with twice its mean forces.
    """

    model: ContactModel
    times: Vector
    initial: Vector
    solutions: tuple[Solution, ...]
    method: str
    loads: Vector
    shares: tuple[float, ...]

    @property
    def _along(self) -> tuple[str, Vector]:
        return "time", self.times[1:]

    @property
    def deflections(self) -> Vector:
        """Deflection of the nodes at all times (length), shape (k + 1, n), positive as the model's heights."""
        return np.stack([self.initial, *(solution.deflection for solution in self.solutions)])

    @property
    def reactions(self) -> Vector:
        """Mean reaction of the support over each step (force), shape (k, n); by Euler's method that at its end."""
        steps = zip(self.shares, self.solutions, strict=True)
        return np.stack([share * np.asarray(solution.reaction) for share, solution in steps])

    @property
    def total_reaction(self) -> list[Bracket]:
        """Brackets of the sum of `reactions` (force), for each step; nan where there is no certificate."""
        steps = zip(self.shares, super().total_reaction, strict=True)
        return [Bracket(share * bracket.lower, share * bracket.upper) for share, bracket in steps]

    @property
    def certified(self) -> bool:
        """Whether every step is certified, given the one before."""
        return all(solution.status.ok for solution in self.solutions)

    @property
    def verdict(self) -> str:
        """How many steps are certified."""
        steps = counted(len(self.solutions), "step")
        if self.certified:
            return f"{steps} of {self.method}, each certified given the one before"
        missing = sum(not solution.status.ok for solution in self.solutions)
        return f"{steps} of {self.method}, {missing} of them not certified"

    def to_dataset(self) -> xr.Dataset:
        """Return all fields as an xarray.Dataset with time as first dimension.

        Variables: deflection, load, reaction (nan at the first time), contact; of each step relative_bound and
        iterations.
        """
        load_modules("xarray")
        import xarray as xr

        model, units = self.model, self.model.units
        reaction = [np.full(model.size, np.nan), *self.reactions]
        contact = [np.zeros(model.size, dtype=np.bool_), *(solution.contact for solution in self.solutions)]
        fields: dict[str, tuple[Iterable[NDArray[Any]], str, str]] = {
            "deflection": (self.deflections, units["deflection"], f"deflection, {model.sense}"),
            "load": (self.loads, units["load"], "active load, positive downwards"),
            "reaction": (reaction, units["reaction"], "mean reaction of the support over the step before"),
            "contact": (contact, "1", "whether the node is in contact"),
        }
        data = xr.Dataset(coords={"time": ("time", self.times)})
        for name, (rows, unit, meaning) in fields.items():
            dims, values = stacked(model, rows)
            data[name] = (("time", *dims), values, {"units": unit, "long_name": meaning})
        for name, place in model.coordinates.items():
            data = data.assign_coords({name: (place.dimension, place.values, place.attributes)})
        for name, numbers in (
            ("relative_bound", [solution.relative_bound for solution in self.solutions]),
            ("iterations", [float(solution.iterations) for solution in self.solutions]),
        ):
            data[name] = ("time", np.array([np.nan, *numbers]))
        data.attrs.update(model=repr(model), method=self.method, verdict=self.verdict)
        return data

    def _repr_html_(self) -> str:
        table = self._told.to_html(float_format=lambda number: f"{number:.4g}")
        return card(
            f"TimeHistory of {len(self.times)} times", {"model": repr(self.model), "steps": self.verdict}, table
        )

    def __repr__(self) -> str:
        span = f"time {self.times[0]:g} to {self.times[-1]:g}"
        return self._text(f"TimeHistory({self.model!r}, {span})")
