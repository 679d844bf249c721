"""LoadPath: the solutions of one model along a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.cards import card
from ..foundation.checks import Vector, positive_number
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames, Wanted
from ..foundation.text import counted
from ..models.base import ContactModel
from ..solving.solution import Solution
from .monotonicity import promised, violations, why_not

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.animation import FuncAnimation as Animation
    from matplotlib.figure import Figure

    from .touchdown import Touchdown


@dataclass(frozen=True, eq=False)
class LoadPath:
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
    def contact_fraction(self) -> Vector:
        """Nodes in contact over nodes with a support, for each value, in the backend's own view."""
        supported = max(1, int(np.count_nonzero(self.model.supported)))
        return np.array([np.count_nonzero(solution.contact) / supported for solution in self.solutions])

    @property
    def total_reaction(self) -> list[Bracket]:
        """Brackets of the total reaction (force), for each value; nan where there is no certificate."""
        unknown = Bracket(float("nan"), float("nan"))
        return [unknown if solution.certificate is None else solution.total_reaction for solution in self.solutions]

    @property
    def max_deflection(self) -> Vector:
        """Deflection of the lowest node (length), positive as the model's heights are, for each value."""
        return np.array([self.model.lowest(solution.deflection) for solution in self.solutions])

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

    def to_frame(self) -> pd.DataFrame:
        """Return one row for each value, as a pandas.DataFrame indexed by the parameter.

        Columns: status, relative_bound, contact, contact_fraction, undecided, total_reaction_lower,
        total_reaction_upper (force), max_deflection (length), iterations, cold_iterations (if recorded), seconds.
        """
        load_modules("pandas")
        import pandas as pd

        reactions = self.total_reaction
        columns: dict[str, Any] = {
            "status": [solution.status.value for solution in self.solutions],
            "relative_bound": [solution.relative_bound for solution in self.solutions],
            "contact": [int(np.count_nonzero(solution.contact)) for solution in self.solutions],
            "contact_fraction": self.contact_fraction,
            "undecided": [_undecided(solution) for solution in self.solutions],
            "total_reaction_lower": [bracket.lower for bracket in reactions],
            "total_reaction_upper": [bracket.upper for bracket in reactions],
            "max_deflection": self.max_deflection,
            "iterations": [solution.iterations for solution in self.solutions],
        }
        if self.cold_iterations is not None:
            columns["cold_iterations"] = list(self.cold_iterations)
        columns["seconds"] = [solution.seconds for solution in self.solutions]
        return pd.DataFrame(columns, index=pd.Index(self.values, name=self.parameter))

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

    def plot(self, ax: Any = None, *, title: str | None = None, units: UnitNames = "") -> Figure:
        """Draw contact fraction, total reaction, largest deflection and iterations against the parameter.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own, into which the contact fraction alone is drawn. By default there is a new figure.
        title : str, optional
            Headline in place of the verdict on monotonicity.
        units : str or mapping, optional
            Unit of length for labels, as ``"m"``, or ``{"length": "m", "force": "kN"}``.
        """
        from .pictures import plot_path

        first, wanted = self.solutions[0], Wanted(ax, None, title, units)
        return plot_path(self.to_frame(), first.iteration_unit, first.backend, self.verdict, wanted)

    def animate(
        self,
        file: str | Path | None = None,
        *,
        seconds: float = 0.5,
        section: float | None = None,
        title: str | None = None,
        units: UnitNames = "",
        writer: Any = None,
    ) -> Animation:
        """Show the answers one after the other: contact map and section, or a cable's shape.

        Parameters
        ----------
        file : path, optional
            Where to write the film to, by a writer of matplotlib's that the suffix stands for: ``.gif`` by pillow,
            ``.html`` as single pictures in a page, and ``.mp4``, ``.mov``, ``.mkv``, ``.avi`` and ``.webm`` by ffmpeg,
            if that is installed.
        seconds : float
            For each picture, > 0.
        section, title, units
            As for `contactqp.Solution.plot`; the parameter's value stands behind the title.
        writer : str or matplotlib writer, optional
            In place of the one that the suffix stands for.

        Returns
        -------
        matplotlib.animation.FuncAnimation
            In a notebook ``HTML(animation.to_jshtml())`` shows it.

        Raises
        ------
        ValueError
            If the file's folder does not exist, or nothing writes a film of its suffix.
        """
        from .animation import animated

        wanted = Wanted(None, section, title, units)
        values = [
            (f"{self.parameter} {value:g}", solution)
            for value, solution in zip(self.values, self.solutions, strict=True)
        ]
        return animated(self.model, values, wanted, positive_number(seconds, "seconds"), file, writer)

    def plot_touchdown(self, width: float | None = None) -> Figure:
        """Draw at which load each node settles: the contact maps of all loads in one picture.

        Parameters
        ----------
        width : float, optional
            See `touchdown`.
        """
        return self.touchdown(width).plot()

    @cached_property
    def cautions(self) -> tuple[str, ...]:
        """Why even certified answers may not be what was meant, of all values, each sentence once."""
        steepest = max(self.solutions, key=lambda solution: solution.max_slope if solution.finite else -1.0)
        return steepest.cautions

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

    @property
    def _told(self) -> pd.DataFrame:
        """The columns that fit into a window."""
        return self.to_frame()[["status", "relative_bound", "contact", "undecided", "max_deflection", "iterations"]]

    def __repr__(self) -> str:
        table = self._told
        text = table.to_string(float_format=lambda number: f"{number:.4g}")
        cautions = "".join(f"caution: {caution}\n" for caution in self.cautions)
        return f"LoadPath({self.model!r}, {len(self.solutions)} {self.parameter}s)\n{text}\n{cautions}{self.verdict}"


def _undecided(solution: Solution) -> int:
    certificate = solution.certificate
    return solution.problem.size if certificate is None else int(np.count_nonzero(certificate.undecided))
