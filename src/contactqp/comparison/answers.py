"""Answers: what several backends returned for one problem, and what their answers say together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..models.base import ContactModel
from ..problem.contact_problem import ContactProblem
from ..proof.certificate import Certificate
from ..solving.solution import Solution
from .metrics import Truth, boundary_distance, contact_jaccard, intersection


@dataclass(frozen=True, eq=False)
class Answers:
    """The answers of several backends to one problem, side by side.

    Attributes
    ----------
    problem : ContactProblem
    model : Membrane, Cable, CableNet or None
        What the problem comes from; None for a bare `ContactQP`.
    solutions : mapping of str to Solution
        By backend, of those that returned one.
    """

    problem: ContactProblem
    model: ContactModel | None
    solutions: Mapping[str, Solution]

    @cached_property
    def finite(self) -> dict[str, Solution]:
        """By backend, the answers that are finite vectors."""
        return {name: solution for name, solution in self.solutions.items() if solution.finite}

    @property
    def best(self) -> Solution | None:
        """The answer with the smallest certified bound, or None if no backend returned a finite one.

        Where no bound is known, it is that with the smallest residual.
        """
        return None if self.best_backend is None else self.finite[self.best_backend]

    @cached_property
    def best_backend(self) -> str | None:
        """Who returned the `best` answer."""

        def worth(name: str) -> tuple[float, float]:
            return self.finite[name].relative_bound, self.finite[name].relative_residual

        return min(self.finite, key=worth, default=None)

    @cached_property
    def certificates(self) -> list[Certificate]:
        """The certificates of those answers that have one."""
        return [solution.certificate for solution in self.solutions.values() if solution.certificate is not None]

    @cached_property
    def truth(self) -> Truth | None:
        """Where ω* lies by all certificates together; None without any, or if they contradict each other."""
        return intersection(self.certificates)

    @property
    def decided(self) -> dict[str, int]:
        """Nodes that the certificates together prove in contact or clear, and those that are undecided.

        With an upper bound ``"contact_upper"`` counts those of the nodes in contact that it holds.
        """
        contact, upper, clear = np.zeros((3, self.problem.size), dtype=np.bool_)
        for certificate in self.certificates:
            contact |= certificate.contact
            upper |= certificate.contact_upper
            clear |= certificate.clear
        found = {
            "contact": int(np.count_nonzero(contact)),
            "clear": int(np.count_nonzero(clear)),
            "undecided": int(np.count_nonzero(~(contact | clear))),
        }
        return found if self.problem.one_sided else found | {"contact_upper": int(np.count_nonzero(upper))}

    @cached_property
    def spread(self) -> Vector:
        """Largest less smallest gap of the finite answers at every node (length), shape (n,); zero without any."""
        largest, smallest = np.full(self.problem.size, -np.inf), np.full(self.problem.size, np.inf)
        for solution in self.finite.values():
            np.maximum(largest, solution.gap, out=largest)
            np.minimum(smallest, solution.gap, out=smallest)
        return largest - smallest if self.finite else np.zeros(self.problem.size)

    @cached_property
    def contact_sets(self) -> dict[str, Mask]:
        """By backend, the contact sets of the finite answers: with the lower bound, and with the upper if there is one.

        Each is of shape (1, n) or (2, n).
        """
        one_sided = self.problem.one_sided
        return {
            name: np.stack([s.contact_lower] if one_sided else [s.contact_lower, s.contact_upper])
            for name, s in self.finite.items()
        }

    def contact_jaccard(self, first: str, second: str) -> float:
        """Return the Jaccard distance of two backends' contact sets, see `metrics.contact_jaccard`."""
        return contact_jaccard(self.contact_sets[first], self.contact_sets[second])

    def boundary_distance(self, first: str, second: str) -> float | None:
        """Return the Hausdorff distance of two backends' free boundaries (length); None for a bare matrix.

        With an upper bound each of the two contact sets has a free boundary, and the larger distance counts.
        """
        if self.model is None:
            return None
        pairs = zip(self._free_boundaries[first], self._free_boundaries[second], strict=True)
        return max(boundary_distance(here, there) for here, there in pairs)

    @cached_property
    def _free_boundaries(self) -> dict[str, list[NDArray[np.float64]]]:
        """By backend, the free boundary of each of its `contact_sets`."""
        model = self.model
        assert model is not None
        return {name: [model.free_boundary(held) for held in sets] for name, sets in self.contact_sets.items()}
