"""Errors of discrete answers over several spacings, and the orders that they show."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

QUANTITIES = ("deflection", "reaction", "contact_area", "free_boundary")
"""What is compared with the closed form, in the order of the table."""

_OVER_BOUND = 10.0
"""Times the solver's own error that one of the discretisation is at least."""


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


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of a problem of the gallery over several spacings.

    Attributes
    ----------
    name : str
        The entry's.
    title, source : str
        What it is, and where its closed form is from.
    exact : bool
        Whether the discrete answers are the continuous one, so that all errors are rounding.
    backend : str
        What solved it.
    rows : tuple of StudyRow
        From the largest spacing to the smallest.
    """

    name: str
    title: str
    source: str
    exact: bool
    backend: str
    rows: tuple[StudyRow, ...]

    @property
    def certified(self) -> bool:
        """Whether every answer's own error is certified to be as small as was asked for."""
        return all(row.status == "certified" for row in self.rows)

    def order(self, quantity: str) -> float:
        """Return the observed order of a quantity over all spacings: the slope of log error over log spacing.

        By least squares over the rows whose error is that of the discretisation: larger than the solver's own and than
        zero. nan where there are fewer than two.

        Parameters
        ----------
        quantity : {"deflection", "reaction", "contact_area", "free_boundary"}
        """
        told = [(row.spacing, error) for row in self.rows if (error := self._error(row, quantity)) is not None]
        if len({spacing for spacing, _ in told}) < 2:
            return math.nan
        spacing, error = np.log(np.array(told)).T
        return float(np.polyfit(spacing, error, 1)[0])

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
        if self.exact or not error > 0 or (quantity == "deflection" and error <= _OVER_BOUND * row.bound):
            return None
        return error
