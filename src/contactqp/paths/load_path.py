"""LoadPath: the solutions of one model along a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from ..foundation.cards import card
from ..foundation.checks import Vector, positive_number
from ..foundation.loading import load_modules
from ..foundation.text import counted
from ..models.base import ContactModel
from ..solving.solution import Solution
from .answer_path import AnswerPath
from .monotonicity import promised, violations, why_not

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from .touchdown import Touchdown


@dataclass(frozen=True, eq=False)
class LoadPath(AnswerPath):
    """The solutions of one model along a parameter.

    Made by `trace`. Printing it shows a table; `to_frame` returns the table as data, `to_dataset` all fields.

    Attributes
    ----------
    model : Membrane, Cable or CableNet
        The model that is varied.
    parameter : str
        ``"load"`` (factor of the model's load), ``"tension"`` or ``"lift"`` (of the support, length).
    values : array, shape (k,)
        In the order of the path.
    solutions : tuple of Solution
        One for each value.
    cold_iterations : tuple of int, or None
        Iterations from a cold start, if they were asked for.
    """

    model: ContactModel
    parameter: str
    values: Vector
    solutions: tuple[Solution, ...]
    cold_iterations: tuple[int, ...] | None = None

    @property
    def _along(self) -> tuple[str, Vector]:
        return self.parameter, self.values

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """Proven violations of the monotonicity that theory promises: gaps that grow, and nodes that lift off.

        Under a load that nowhere pulls upwards gaps only shrink and contact only grows as the load grows or the tension
        falls; under any load they do as the support is lifted. Contact with a ceiling shrinks in the one case, and
        grows as the support is lifted. A violation is proven if the enclosures exclude the
        contrary, by more than the rounding of the stored data explains. Where nothing is promised, a finding says so.
        """
        return tuple(violations(self.model, self.parameter, self.values, self.solutions))

    @property
    def monotone(self) -> bool:
        """Whether no violation of monotonicity is proven."""
        return not self.findings

    @property
    def promised(self) -> bool:
        """Whether theory promises monotonicity: the support is lifted, or the load nowhere pulls upwards.

        It does not for a tension that changes over a foundation, nor for a beam or a plate.
        """
        return promised(self.model, self.parameter)

    def touchdown(self, width: float | None = None) -> Touchdown:
        """Return for each node the loads between which it certainly comes into contact.

        Parameters
        ----------
        width : float, optional
            Wanted width of every bracket, > 0; further values between those of the path are solved for by bisection
            until it is reached. By default the path's own values are all that is used.

        Raises
        ------
        ValueError
            If monotonicity is violated, or the parameter is not the load.
        """
        from .bisection import touchdown_of

        if self.parameter != "load":
            raise ValueError(f"touchdown loads need a path of loads, this one's parameter is the {self.parameter}")
        if not self.promised:
            why = why_not(self.model)
            raise ValueError(f"touchdown loads need a path that is promised to be monotone, but {why}: see events")
        if self.findings:
            raise ValueError(f"touchdown loads need a monotone path, but {self.findings[0]}")
        wanted = None if width is None else positive_number(width, "width")
        return touchdown_of(self.model, self.values, self.solutions, wanted)

    def to_dataset(self) -> xr.Dataset:
        """Return all fields as an xarray.Dataset with the parameter as first dimension, and the table's columns.

        The field of active loads is called ``active_load``, because ``load`` is the dimension.
        """
        load_modules("xarray")
        import xarray as xr

        fields = [solution.to_dataset().rename(load="active_load") for solution in self.solutions]
        place = xr.Variable((self.parameter,), self.values)
        data = xr.concat(fields, dim=place, combine_attrs="drop_conflicts")
        for name, column in self.to_frame().items():
            data[str(name)] = ((self.parameter,), column.to_numpy())
        data.attrs["parameter"] = self.parameter
        return data

    def plot_touchdown(self, width: float | None = None) -> Figure:
        """Draw at which load each node settles: the contact maps of all loads in one picture.

        Parameters
        ----------
        width : float, optional
            See `touchdown`.
        """
        return self.touchdown(width).plot()

    @property
    def verdict(self) -> str:
        """The first finding and the number of others, or that there is none."""
        if not self.findings:
            return "no violation of monotonicity"
        others = len(self.findings) - 1
        return self.findings[0] + (f"; and {counted(others, 'more finding')}" if others else "")

    def _repr_html_(self) -> str:
        facts = {"model": repr(self.model), "monotonicity": self.verdict}
        table = self._told.to_html(float_format=lambda number: f"{number:.4g}")
        return card(f"LoadPath of {len(self.solutions)} {self.parameter}s", facts, table)

    def __repr__(self) -> str:
        return self._text(f"LoadPath({self.model!r}, {len(self.solutions)} {self.parameter}s)")
