"""Comparison: the answers of several backends to one problem, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import integer_at_least
from ..models.base import ContactModel
from ..problem.contact_qp import ContactQP
from ..proof.measure import measure
from ..solving.solution import Solution
from ..solving.tolerances import Tolerance
from .disagreement import spread_of, worst_nodes_of
from .metrics import Truth, boundary_distance, contact_jaccard, intersection
from .provenance import Provenance
from .rows import Pair, Row
from .text import as_html, as_json, as_text
from .verdicts import culprits_of, false_claims_of, findings_of, verdict_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


UNPROVEN_AGREEMENT = 100.0
"""Without enclosures two answers agree if they differ by at most this times tol times the gap scale."""


class Comparison:
    """The answers of several backends to one problem, side by side.

    Made by `compare`. Printing it shows a table; `to_frame` returns the table as data.

    Attributes
    ----------
    problem : ContactQP
    tol : float
    setting : str
        The level that ``tol`` was asked for by, see `solve`; ``""`` for a number.
    solutions : dict of str to Solution
        By backend, of those that returned one.
    provenance : Provenance
        Limits, options, versions, machine and time.
    """

    def __init__(
        self,
        problem: ContactQP,
        subject: str,
        tol: float,
        rows: Sequence[Row],
        solutions: dict[str, Solution],
        *,
        setting: str = "",
        provenance: Provenance | None = None,
    ) -> None:
        self.problem = problem
        self.subject = subject
        self.tol = tol
        self.setting = setting
        self.solutions = solutions
        self.provenance = Provenance() if provenance is None else provenance
        self._own_rows = list(rows)

    @cached_property
    def rows(self) -> list[Row]:
        """One `Row` for each backend, in the order asked for."""
        return [self._measured(row) for row in self._own_rows]

    @cached_property
    def truth(self) -> Truth | None:
        """Where ω* lies by all certificates together; None without any, or if they contradict each other."""
        return intersection(s.certificate for s in self.solutions.values() if s.certificate is not None)

    @property
    def true_error(self) -> dict[str, tuple[float, float]]:
        """By backend, two lengths between which max|ω_i - ω*_i| certainly lies; empty without a `truth`."""
        return {
            row.backend: (row.true_error_lower, row.true_error_upper)
            for row in self.rows
            if row.true_error_lower is not None and row.true_error_upper is not None
        }

    @cached_property
    def false_claims(self) -> dict[str, str]:
        """By backend, of those that said they had solved the problem and had not: what they said, and what is known.

        An answer that the others' certificates prove to be within tol is none, even if its own does not.
        """
        return false_claims_of(self)

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """What went wrong on the way, though it may not show in the answers: one sentence each."""
        return findings_of(self)

    @cached_property
    def pairs(self) -> list[Pair]:
        """Every pair of backends that returned a finite answer."""
        return [self._pair(first, second) for first, second in combinations(self.usable, 2)]

    @property
    def agree(self) -> bool:
        """Whether every backend was certified and every pair of enclosures intersects."""
        return bool(self.rows) and all(row.ok for row in self.rows) and all(pair.consistent for pair in self.pairs)

    @cached_property
    def culprits(self) -> dict[str, str]:
        """Why there is no agreement: backend to reason, empty if all agree.

        A backend is named if it returned no certified answer, with its worst optimality condition; or, where all look
        good and two still exclude each other, if its answer is consistent with fewer of the others than theirs are.
        """
        return culprits_of(self)

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a pandas.DataFrame, indexed by backend."""
        import pandas as pd

        return pd.DataFrame([asdict(row) for row in self.rows]).set_index("backend")

    def pairs_frame(self) -> pd.DataFrame:
        """Return the pairs as a pandas.DataFrame, with the number of differing nodes."""
        import pandas as pd

        records = [asdict(pair) | {"differing_nodes": pair.differing_nodes.size} for pair in self.pairs]
        return pd.DataFrame(records, columns=list(Pair.__dataclass_fields__))

    def to_json(self, indent: int | None = 2) -> str:
        """Return rows, pairs, verdict, truth, findings and provenance as JSON; infinite and undefined become null."""
        return as_json(self, indent)

    def plot(self) -> Figure:
        """Draw the best answer's contact map, each backend's certified error, and where contact sets differ."""
        from .pictures import plot_comparison

        return plot_comparison(self)

    def plot_disagreement(self) -> Figure:
        """Draw how far the backends' gaps lie apart at every node, and number the worst nodes.

        On a membrane or a cable net a map in which nodes are circled that some backends have in contact and others do
        not; on a cable along x; for a bare matrix sorted.

        Raises
        ------
        ValueError
            If fewer than two backends returned an answer.
        """
        from .pictures import plot_disagreement

        return plot_disagreement(self)

    @cached_property
    def spread(self) -> NDArray[np.float64]:
        """Largest less smallest gap of all answers at every node (length), shape (n,)."""
        return spread_of(self)

    def worst_nodes(self, count: int = 10) -> pd.DataFrame:
        """Return the nodes where the answers lie farthest apart.

        Parameters
        ----------
        count : int
            At most so many, >= 1.

        Returns
        -------
        pandas.DataFrame
            Columns: node; x, y (length; nan for a bare matrix); larger, smaller (the backends with the largest and the
            smallest gap there); larger_gap, smaller_gap, difference (length); larger_reaction, smaller_reaction
            (force); true_lower, true_upper (length; nan without a truth). Without two answers it is empty.

        Examples
        --------
        >>> import contactqp as cq
        >>> comparison = cq.compare(cq.gallery.islands(), ["psor", "clarabel"])
        >>> worst = comparison.worst_nodes(3)
        >>> len(worst), bool((worst["difference"].diff().dropna() <= 0).all())
        (3, True)
        """
        return worst_nodes_of(self, integer_at_least(count, 1, "count"))

    def report(self, path: str | Path, title: str = "") -> Path:
        """Write everything as one HTML page that needs no network, no script and no other file.

        Parameters
        ----------
        path : path
            The file to write, replaced if it exists; its folder must exist.
        title : str
            Headline; by default the problem.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If there is no such folder.
        """
        from .html import write_report

        return write_report(self, Path(path), title)

    @property
    def best(self) -> Solution | None:
        """The answer with the smallest certified bound, or None if no backend returned one."""
        return min(self.usable.values(), key=lambda s: s.relative_bound) if self.usable else None

    @property
    def decided(self) -> dict[str, int]:
        """Nodes that the certificates together prove in contact or clear, and those that are undecided."""
        certificates = [s.certificate for s in self.solutions.values() if s.certificate is not None]
        if not certificates:
            return {"contact": 0, "clear": 0, "undecided": self.problem.size}
        contact = np.logical_or.reduce([certificate.contact for certificate in certificates])
        clear = np.logical_or.reduce([certificate.clear for certificate in certificates])
        return {
            "contact": int(np.count_nonzero(contact)),
            "clear": int(np.count_nonzero(clear)),
            "undecided": int(np.count_nonzero(~(contact | clear))),
        }

    def verdict(self) -> str:
        """Return one sentence: agreement, or who spoils it and why."""
        return verdict_of(self)

    def __repr__(self) -> str:
        return as_text(self)

    def remarks(self) -> list[str]:
        """Return findings and false claims as lines, to be read below the table."""
        return [
            *(f"Finding: {finding}." for finding in self.findings),
            *(f"False claim: {name} {sentence}." for name, sentence in self.false_claims.items()),
        ]

    def _repr_html_(self) -> str:
        return as_html(self)

    @property
    def tolerance(self) -> Tolerance:
        """What was asked for: ``tol`` with the name of its level."""
        return Tolerance(self.tol, self.setting)

    @cached_property
    def usable(self) -> dict[str, Solution]:
        """By backend, the answers that are finite vectors."""
        return {name: s for name, s in self.solutions.items() if s.residuals is not None}

    @property
    def model(self) -> ContactModel | None:
        """The membrane, cable or cable net, None if a bare `ContactQP` was solved."""
        return next((s.model for s in self.solutions.values()), None)

    @cached_property
    def _boundaries(self) -> dict[str, NDArray[np.float64]]:
        return {name: s.model.free_boundary(s.contact) for name, s in self.usable.items() if s.model is not None}

    def _apart(self, first: str, second: str) -> float | None:
        """Return the distance of two backends' free boundaries."""
        if first not in self._boundaries or second not in self._boundaries:
            return None
        return boundary_distance(self._boundaries[first], self._boundaries[second])

    def _measured(self, row: Row) -> Row:
        """Return a row with its distances from the truth and from the best answer."""
        solution, best = self.usable.get(row.backend), self.best
        if solution is None or best is None:
            return row
        best_name = next(name for name, s in self.usable.items() if s is best)
        facts: dict[str, Any] = {
            "contact_jaccard": contact_jaccard(solution.contact, best.contact),
            "boundary_distance": self._apart(row.backend, best_name),
        }
        low, high = (None, None) if self.truth is None else self.truth.error(solution.gap)
        if high is not None and solution.certificate is not None:
            high = min(high, solution.certificate.gap_bound)
        relative = None if high is None else high / measure(self.problem, solution.gap).scale
        facts |= {"true_error_lower": low, "true_error_upper": high, "relative_true_error": relative}
        return replace(row, **facts)

    def _pair(self, first_name: str, second_name: str) -> Pair:
        first, second = self.usable[first_name], self.usable[second_name]
        differing = np.flatnonzero(first.contact != second.contact)
        difference = float(np.abs(first.gap - second.gap).max())
        if first.certificate is not None and second.certificate is not None:
            consistent = first.certificate.intersects(second.certificate)
        else:
            consistent = difference <= UNPROVEN_AGREEMENT * self.tol * self.problem.gap_scale
        return Pair(
            first=first_name,
            second=second_name,
            gap_difference=difference,
            contact_jaccard=contact_jaccard(first.contact, second.contact),
            differing_nodes=differing,
            consistent=consistent,
            boundary_distance=self._apart(first_name, second_name),
        )
