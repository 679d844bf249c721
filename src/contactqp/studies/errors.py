"""Errors of discrete answers over several spacings, and the orders that they show."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

QUANTITIES = ("deflection", "reaction", "contact_area", "free_boundary")
"""What is compared with the closed form, in the order of the table."""

AT_NODES = ("deflection", "reaction")
"""What an answer that is exact at the nodes tells exactly; where contact ends, it knows to within a spacing."""

_ROUNDING = 1e-12
"""Errors of up to so much of what is measured, of lengths of a spacing, are rounding."""

_OVER_BOUND = 10.0
"""Times the solver's own error that one of the discretisation is at least."""

_EXPLAINED = 0.9
"""Part of the variance of log error that a line over log spacing explains, if its slope is told as an order."""


@dataclass(frozen=True)
class StudyRow:
    """The errors at one spacing; nan where the closed form says nothing of a quantity.

    Attributes
    ----------
    n : int
        As `contactqp.gallery.load` takes it.
    unknowns : int
    spacing : float
        Length.
    deflection : float
        max |w_h - w| over the nodes (length); of a bare problem of the gap.
    reaction : float
        Σ|R_h - R| over Σ|R| (no unit): pointwise a reaction that jumps does not converge.
    contact_area : float
        |A_h - A| over A (no unit), of the area that the nodes in contact stand for.
    free_boundary : float
        The largest distance of a middle between a node in contact and one that is not from the exact free boundary
        (length).
    bound : float
        What the certificate leaves of the deflection's error to the solver (length); inf without one.
    status : str
        Of the answer.
    seconds : float
        Of its solution.
    exact : bool
        Whether the discrete answer is the continuous one at the nodes, so that errors of deflection and reaction are
        rounding.
    """

    n: int
    unknowns: int
    spacing: float
    deflection: float
    reaction: float
    contact_area: float
    free_boundary: float
    bound: float
    status: str
    seconds: float
    exact: bool = False


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a problem of the gallery over several spacings.

    Attributes
    ----------
    name : str
        The entry's.
    title, source : str
        What it is, and where its closed form is from.
    backend : str
        What solved it.
    rows : tuple of StudyRow
        From the largest spacing to the smallest.
    """

    name: str
    title: str
    source: str
    backend: str
    rows: tuple[StudyRow, ...]

    @property
    def exact(self) -> bool:
        """Whether all the discrete answers are the continuous one at the nodes."""
        return all(row.exact for row in self.rows)

    @property
    def certified(self) -> bool:
        """Whether every answer's own error is certified to be as small as was asked for."""
        return all(row.status == "certified" for row in self.rows)

    def order(self, quantity: str) -> float:
        """Return the observed order of a quantity over all spacings: the slope of log error over log spacing.

        By least squares over the rows whose error is that of the discretisation: larger than the solver's own and than
        rounding. nan where there are fewer than two, where errors do not fall with the spacing, and where they lie so
        far from the line that it explains less than nine tenths of their variance (both in logarithms), as those of an
        area that is counted in nodes may: a slope says nothing then.

        Parameters
        ----------
        quantity : {"deflection", "reaction", "contact_area", "free_boundary"}
        """
        told = [(row.spacing, error) for row in self.rows if (error := self._error(row, quantity)) is not None]
        if len({spacing for spacing, _ in told}) < 2:
            return math.nan
        spacing, error = np.log(np.array(told)).T
        across, along = spacing - spacing.mean(), error - error.mean()
        slope = float(across @ along / (across @ across))
        explained = slope * float(across @ along)
        return slope if slope > 0 and explained >= _EXPLAINED * float(along @ along) else math.nan

    def orders(self, quantity: str) -> tuple[float, ...]:
        """Return the observed order from each row to the next, nan where there is none; see `order`."""
        found = []
        for coarse, fine in zip(self.rows, self.rows[1:], strict=False):
            first, second = self._error(coarse, quantity), self._error(fine, quantity)
            known = first is not None and second is not None
            found.append(math.log(first / second) / math.log(coarse.spacing / fine.spacing) if known else math.nan)  # type: ignore[operator]
        return tuple(found)

    def _error(self, row: StudyRow, quantity: str) -> float | None:
        """Return a row's error where it is that of the discretisation, None elsewhere."""
        error: float = getattr(row, quantity)
        least = _ROUNDING * (row.spacing if quantity == "free_boundary" else 1.0)
        if quantity == "deflection":
            least = _OVER_BOUND * row.bound
        return error if error > least and not (row.exact and quantity in AT_NODES) else None
