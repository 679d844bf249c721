"""AnswerPath: the solutions of one model in an order, along a parameter or in time."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.brackets import Bracket
from ..foundation.checks import Vector, positive_number
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames, Wanted
from ..foundation.terminal import line_width
from ..foundation.text import folded
from ..models.base import ContactModel
from ..solving.solution import Solution

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.animation import FuncAnimation as Animation
    from matplotlib.figure import Figure


class AnswerPath:
    """What is told of solutions in an order; base of `LoadPath` and `TimeHistory`.

    Attributes
    ----------
    model : Membrane, Cable or CableNet
    solutions : tuple of Solution
    cold_iterations : tuple of int, or None
        Iterations from a cold start, if they were asked for.
    """

    model: ContactModel
    solutions: tuple[Solution, ...]
    cold_iterations: tuple[int, ...] | None = None

    @property
    def _along(self) -> tuple[str, Vector]:
        """The name of what goes on from solution to solution, and its values."""
        raise NotImplementedError

    @property
    def verdict(self) -> str:
        """What is to be said of all solutions together."""
        raise NotImplementedError

    @property
    def contact_fraction(self) -> Vector:
        """Nodes in contact over nodes with a support, for each solution, in the backend's own view."""
        supported = max(1, int(np.count_nonzero(self.model.supported)))
        return np.array([np.count_nonzero(solution.contact) / supported for solution in self.solutions])

    @property
    def total_reaction(self) -> list[Bracket]:
        """Brackets of the total reaction (force), for each solution; nan where there is no certificate."""
        unknown = Bracket(float("nan"), float("nan"))
        return [unknown if solution.certificate is None else solution.total_reaction for solution in self.solutions]

    @property
    def max_deflection(self) -> Vector:
        """Deflection of the lowest node (length), positive as the model's heights are, for each solution."""
        return np.array([self.model.lowest(solution.deflection) for solution in self.solutions])

    def to_frame(self) -> pd.DataFrame:
        """Return one row for each solution, as a pandas.DataFrame indexed by what goes on.

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
        name, values = self._along
        return pd.DataFrame(columns, index=pd.Index(values, name=name))

    def plot(self, ax: Any = None, *, title: str | None = None, units: UnitNames = "") -> Figure:
        """Draw contact fraction, total reaction, largest deflection and iterations against what goes on.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own, into which the contact fraction alone is drawn. By default there is a new figure.
        title : str, optional
            Headline in place of the verdict.
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
            As for `contactqp.Solution.plot`; what goes on stands behind the title.
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

        name, values = self._along
        wanted = Wanted(None, section, title, units)
        answers = [(f"{name} {value:g}", solution) for value, solution in zip(values, self.solutions, strict=True)]
        return animated(self.model, answers, wanted, positive_number(seconds, "seconds"), file, writer)

    @cached_property
    def cautions(self) -> tuple[str, ...]:
        """Why even certified answers may not be what was meant, of all solutions, each sentence once."""
        steepest = max(self.solutions, key=lambda solution: solution.max_slope if solution.finite else -1.0)
        return steepest.cautions

    @property
    def _told(self) -> pd.DataFrame:
        """The columns that fit into a window."""
        return self.to_frame()[["status", "relative_bound", "contact", "undecided", "max_deflection", "iterations"]]

    def _text(self, headline: str) -> str:
        """Return the table below a headline, and the verdict."""
        room, told, left_out = line_width(), self._told, list[str]()
        text = _as_text(told)
        while room is not None and told.shape[1] > 1 and max(map(len, text.splitlines())) > room:
            left_out.insert(0, str(told.columns[-1]))
            told = told.iloc[:, :-1]
            text = _as_text(told)
        remarks = [*(f"caution: {caution}" for caution in self.cautions), self.verdict]
        if left_out:
            remarks.append(f"Left out for want of room: {', '.join(left_out)}; to_frame() has all.")
        if room is not None:
            headline, remarks = folded(headline, room, 2), [folded(line, room, 2) for line in remarks]
        return "\n".join([headline, text, *remarks])


def _as_text(table: pd.DataFrame) -> str:
    text: str = table.to_string(float_format=lambda number: f"{number:.4g}")
    return "\n".join(line.rstrip() for line in text.splitlines())


def _undecided(solution: Solution) -> int:
    certificate = solution.certificate
    return solution.problem.size if certificate is None else int(np.count_nonzero(certificate.undecided))


def stacked(model: ContactModel, rows: Iterable[NDArray[Any]]) -> tuple[tuple[str, ...], NDArray[Any]]:
    """Return the dimensions behind the first, and the arrays that a dataset holds of several nodal fields."""
    laid = [model.laid_out(np.asarray(row)) for row in rows]
    return laid[0][0], np.stack([values for _, values in laid])
