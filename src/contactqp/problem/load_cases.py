"""LoadCases: many problems that differ in their forces alone, for passes over all of them at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .contact_problem import ContactProblem
from .posed import Posed, Units


class LoadCases(Posed):
    """Many problems that differ in their forces alone; they share the matrix and what is known of it, and the bounds.

    Parameters
    ----------
    facts, q, bounds
        See `Posed`; q has shape (cases, n).

    Examples
    --------
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> cases = LoadCases.of([problem, problem.with_forces([1.0, 1.0])])
    >>> cases.opens
    array([ True, False])
    """

    @classmethod
    def of(cls, problems: Sequence[ContactProblem]) -> LoadCases:
        """Return problems that differ in their forces alone as load cases."""
        return cls(problems[0].facts, np.array([problem.q for problem in problems]), problems[0].bounds)

    def tell(self, problems: Sequence[ContactProblem]) -> None:
        """Tell each of the cases, as problems of their own, what follows from its forces."""
        for problem, opens, mean in zip(problems, self.opens, self.mean_opening, strict=True):
            problem.opens, problem.mean_opening = opens, mean

    def scaled(self, gap_scale: float) -> tuple[LoadCases, Units]:
        """Return the dimensionless cases, as `ContactProblem.scaled` does, with one unit of length for all of them.

        Raises
        ------
        ValueError
            If numbers overflow.
        """
        q, bounds, units = self.in_units(gap_scale)
        return LoadCases(self.facts.scaled, q(), bounds), units
