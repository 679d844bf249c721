"""Measures: what the judge and a certificate want to know of an answer, taken once."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from ..problem.contact_problem import ContactProblem
from .certificate import Certificate
from .residuals import Residuals

_LEAST_ANSWER = 1e-6
"""Answers near zero count as this part of the gap scale."""


class Measures(ABC):
    """Measures of one finite gap, by passes of numpy over vectors or by compiled ones over a lattice.

    Attributes
    ----------
    problem : ContactProblem
    """

    problem: ContactProblem

    @property
    @abstractmethod
    def residuals(self) -> Residuals:
        """The residuals of the optimality conditions."""

    @property
    @abstractmethod
    def largest_deflection(self) -> float:
        """Largest |w|, w = reference - ω (length)."""

    @property
    @abstractmethod
    def gap_bound(self) -> float:
        """Bound of max|ω - ω*| (length), as cheaply as it can be had.

        It is that of the fast certificate, or a little more; infinite where nothing is known of such a matrix.
        """

    @property
    def shut(self) -> bool:
        """Whether no force opens a gap, see `ContactProblem.shut`."""
        return self.problem.shut

    @property
    def estimated_error(self) -> float:
        """What iterations go on by (length): `gap_bound`, and where nothing is proven an estimate of the error."""
        return self.gap_bound

    @abstractmethod
    def certificate(self) -> Certificate | None:
        """Return the fast certificate, or None where nothing is known of such a matrix."""

    @property
    def scale(self) -> float:
        """The error scale, by which the error is measured: the gap scale, but not more than the answer's own (length).

        The answer's own is `largest_deflection`. If the error is proven below tol times that, it is the true solution's
        up to tol, so no overestimated gap scale lets a poor answer pass. Answers near zero count as a millionth of the
        gap scale; where no force opens a gap, the gap scale counts unabated.
        """
        scale = self.problem.gap_scale
        measured = scale if self.shut else max(min(scale, self.largest_deflection), _LEAST_ANSWER * scale)
        return max(measured, float(np.finfo(np.float64).tiny))

    @property
    def relative_bound(self) -> float:
        """`gap_bound` over `scale`."""
        return self.gap_bound / self.scale

    @property
    def relative_estimate(self) -> float:
        """`estimated_error` over `scale`."""
        return self.estimated_error / self.scale
