"""Compared: what tables, pages and pictures read of a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from ..solving.tolerances import Tolerance
from .answers import Answers
from .conclusion import Conclusion
from .pairs import Pair
from .provenance import Provenance
from .rows import Row


class Compared(Protocol):
    """Answers side by side, and what follows from them: what a view reads of a `Comparison`.

    Attributes
    ----------
    subject : str
        What was solved, in words.
    tolerance : Tolerance
        What was asked for.
    answers : Answers
    rows : sequence of Row
        One for each backend, in the order asked for.
    pairs : sequence of Pair
        Every two of the finite answers.
    conclusion : Conclusion
    provenance : Provenance
        Limits, options, versions, machine and time.
    """

    @property
    def subject(self) -> str: ...  # noqa: D102
    @property
    def tolerance(self) -> Tolerance: ...  # noqa: D102
    @property
    def answers(self) -> Answers: ...  # noqa: D102
    @property
    def rows(self) -> Sequence[Row]: ...  # noqa: D102
    @property
    def pairs(self) -> Sequence[Pair]: ...  # noqa: D102
    @property
    def conclusion(self) -> Conclusion: ...  # noqa: D102
    @property
    def provenance(self) -> Provenance: ...  # noqa: D102
