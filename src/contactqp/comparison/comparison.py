"""Comparison: the answers of several backends to one problem, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from ..foundation.checks import Vector, integer_at_least
from ..foundation.files import path_of
from ..foundation.loading import load_modules
from ..foundation.terminal import line_width
from ..models.base import ContactModel, split
from ..problem.contact_problem import ContactProblem
from ..solving.solution import Effort, Solution
from ..solving.tolerances import Tolerance
from .answers import Answers
from .conclusion import conclusion_of
from .disagreement import worst_nodes
from .metrics import Truth
from .outcome import Outcome
from .pairs import Pair, pairs_of
from .provenance import Provenance
from .rows import records_of, row_of
from .text import as_json, as_text

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


class Comparison:
    """The answers of several backends to one problem, side by side.

    Made by `compare`. Printing it shows a table; `to_frame` returns the table as data.

    Attributes
    ----------
    subject : str
        What was solved, in words.
    tolerance : Tolerance
        What was asked for.
    answers : Answers
        What was returned, and what the answers say together.
    rows : list of Row
        One for each backend, in the order asked for.
    pairs : list of Pair
        Every pair of backends that returned a finite answer.
    conclusion : Conclusion
        What rows and pairs say of the backends.
    provenance : Provenance
        Limits, options, versions, machine and time.
    """

    def __init__(
        self,
        posed: ContactProblem | ContactModel,
        outcomes: Sequence[Outcome],
        tolerance: Tolerance,
        provenance: Provenance | None = None,
        left_out: Mapping[str, str] | None = None,
    ) -> None:
        model, problem = split(posed)
        returned = {out.backend: out.answer for out in outcomes if isinstance(out.answer, Solution)}
        self.subject = repr(posed)
        self.tolerance = tolerance
        self.provenance = Provenance() if provenance is None else provenance
        self.answers = Answers(problem, model, returned)
        self.rows = [row_of(outcome, self.answers) for outcome in outcomes]
        self.pairs = pairs_of(self.answers, tolerance.tol)
        self.conclusion = conclusion_of(self.answers, self.rows, self.pairs, tolerance.tol, left_out)

    @property
    def problem(self) -> ContactProblem:
        """The contact problem."""
        return self.answers.problem

    @property
    def model(self) -> ContactModel | None:
        """The membrane, cable or cable net; None if a bare `ContactQP` was solved."""
        return self.answers.model

    @property
    def tol(self) -> float:
        """The tolerance asked for, relative to each answer's error scale (see `solve`)."""
        return self.tolerance.tol

    @property
    def setting(self) -> str:
        """The level that ``tol`` was asked for by, see `solve`; ``""`` for a number."""
        return self.tolerance.setting

    @property
    def solutions(self) -> Mapping[str, Solution]:
        """By backend, of those that returned one."""
        return self.answers.solutions

    @property
    def best(self) -> Solution | None:
        """The answer with the smallest certified bound, or None if no backend returned one."""
        return self.answers.best

    @property
    def truth(self) -> Truth | None:
        """Where ω* lies by all certificates together; None without any, or if they contradict each other."""
        return self.answers.truth

    @property
    def decided(self) -> dict[str, int]:
        """Nodes that the certificates together prove in contact or clear, and those that are undecided.

        With an upper bound ``"contact_upper"`` counts those of the nodes in contact that it holds.
        """
        return self.answers.decided

    @property
    def spread(self) -> Vector:
        """Largest less smallest gap of all answers at every node (length), shape (n,)."""
        return self.answers.spread

    @property
    def true_error(self) -> dict[str, tuple[float, float]]:
        """By backend, two lengths between which max|ω_i - ω*_i| certainly lies; empty without a `truth`."""
        return {
            row.backend: (row.true_error_lower, row.true_error_upper)
            for row in self.rows
            if row.true_error_lower is not None and row.true_error_upper is not None
        }

    @property
    def agree(self) -> bool:
        """Whether every backend was certified and every pair of enclosures intersects."""
        return self.conclusion.agree

    @property
    def cautions(self) -> tuple[str, ...]:
        """Why even a certified answer may not be what was meant, one sentence each; see `Solution.cautions`."""
        return self.conclusion.cautions

    @property
    def culprits(self) -> Mapping[str, str]:
        """Why there is no agreement: backend to reason, empty if all agree; see `Conclusion`."""
        return self.conclusion.culprits

    @property
    def false_claims(self) -> Mapping[str, str]:
        """By backend, of those that said they had solved the problem and are proven not to have: see `Conclusion`."""
        return self.conclusion.false_claims

    @property
    def unproven_claims(self) -> Mapping[str, str]:
        """By backend, the same of those whose claims are neither proven nor refuted."""
        return self.conclusion.unproven_claims

    @property
    def left_out(self) -> Mapping[str, str]:
        """By backend, why the default list does without it."""
        return self.conclusion.left_out

    @property
    def findings(self) -> tuple[str, ...]:
        """What went wrong on the way, though it may not show in the answers: one sentence each."""
        return self.conclusion.findings

    def verdict(self) -> str:
        """Return one sentence: agreement, or who spoils it and why."""
        return self.conclusion.sentence

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a pandas.DataFrame, indexed by backend."""
        load_modules("pandas")
        import pandas as pd

        return pd.DataFrame(records_of(self.rows, self.problem)).set_index("backend")

    def pairs_frame(self) -> pd.DataFrame:
        """Return the pairs as a pandas.DataFrame, with the number of differing nodes."""
        load_modules("pandas")
        import pandas as pd

        records = [asdict(pair) | {"differing_nodes": pair.differing_nodes.size} for pair in self.pairs]
        return pd.DataFrame(records, columns=list(Pair.__dataclass_fields__))

    def worst_nodes(self, count: int = 10) -> pd.DataFrame:
        """Return the nodes where the answers lie farthest apart.

        Parameters
        ----------
        count : int
            Largest number of nodes to return, >= 1.

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
        return worst_nodes(self.answers, integer_at_least(count, 1, "count"))

    def to_json(self, indent: int | None = 2) -> str:
        """Return rows, pairs, verdict, truth, findings and provenance as JSON; infinite and undefined become null."""
        return as_json(self, indent)

    def plot(self, *, title: str | None = None) -> Figure:
        """Draw the best answer's contact map, each backend's certified error, and where contact sets differ.

        Parameters
        ----------
        title : str, optional
            Headline in place of the picture's own.

        Raises
        ------
        ValueError
            If no backend returned an answer.
        """
        from .pictures import plot_comparison

        return plot_comparison(self, title)

    def plot_disagreement(self) -> Figure:
        """Draw how far the backends' gaps lie apart at every node, and number the worst nodes.

        On a membrane or a cable net it is a map, on a cable a curve along x, and for a bare matrix the differences are
        sorted. Where there are coordinates, nodes are circled that one backend has in contact and another has not.

        Raises
        ------
        ValueError
            If fewer than two backends returned an answer.
        """
        from .pictures import plot_disagreement

        return plot_disagreement(self)

    def report(
        self,
        path: str | Path,
        title: str = "",
        *,
        explorer: str | Path | None = None,
        continuum: Effort | None = None,
    ) -> Path:
        """Write everything as one HTML page that needs no network, no script and no other file.

        Parameters
        ----------
        path : path
            The file to write (.html or .htm), replaced if it exists; its folder must exist.
        title : str
            Headline; by default the problem.
        explorer : path, optional
            A page that `explore` has written of the problem: the report links it.
        continuum : {"energy", "pointwise"}, optional
            Whether to tell what the best answer proves of the membrane itself, see `Solution.continuum`.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If there is no such folder, or the suffix is another; or the membrane is none that can be enclosed.
        """
        from .html import write_report

        asked = None if continuum is None or self.best is None else self.best.continuum(continuum)
        return write_report(self, path_of(path), title, None if explorer is None else Path(explorer), asked)

    def __repr__(self) -> str:
        return as_text(self, line_width())

    def _repr_html_(self) -> str:
        from .html import notebook_table

        return notebook_table(self)
