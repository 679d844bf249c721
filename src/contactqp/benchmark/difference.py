"""What changed between two runs of a benchmark."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .record import Record
from .results import Results

NOTABLE = 1.25
"""Factor of time that is worth a line."""

_MEASURABLE = 5e-3
"""Seconds below which a factor of time says nothing."""


@dataclass(frozen=True)
class Change:
    """One answer that differs.

    Attributes
    ----------
    problem, backend, level : str
    what : str
        In words: another status, a factor of time, or that one run lacks it.
    worse : bool
        Whether it speaks against the second run.
    """

    problem: str
    backend: str
    level: str
    what: str
    worse: bool

    def __str__(self) -> str:
        return f"{self.problem}, {self.backend}, {self.level}: {self.what}"


@dataclass(frozen=True)
class Difference:
    """Two runs beside each other.

    Attributes
    ----------
    changes : tuple of Change
        What is worse first.
    factor : float
        Geometric mean of the second run's seconds over the first's, of answers that both have proven; nan without any.
    common : int
        Answers that both have.
    """

    changes: tuple[Change, ...]
    factor: float
    common: int

    @property
    def worse(self) -> int:
        """How many changes speak against the second run."""
        return sum(change.worse for change in self.changes)


def difference(first: Results, second: Results) -> Difference:
    """Return what changed from one run of a benchmark to another.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from contactqp.benchmark.suites import SUITES
    >>> runs = [Results.begun(Path(tempfile.mkdtemp()), SUITES["quick"], {}, {}) for _ in range(2)]
    >>> for run, status in zip(runs, ("certified", "inaccurate")):
    ...     run.add(Record("bowl", 31, "psor", "mid", status=status, seconds=1.0))
    >>> print(difference(*runs).changes[0])
    bowl 31, psor, mid: was certified, is inaccurate
    """
    before = {record.key: record for record in first.records}
    after = {record.key: record for record in second.records}
    changes = [_changed(before[key], after[key]) for key in before if key in after]
    changes += [_lacking(record, "only in the first run") for key, record in before.items() if key not in after]
    changes += [_lacking(record, "only in the second run") for key, record in after.items() if key not in before]
    ratios = [
        after[key].seconds / record.seconds  # type: ignore[operator]
        for key, record in before.items()
        if key in after and _measured(record) and _measured(after[key])
    ]
    factor = float(np.exp(np.log(ratios).mean())) if ratios else float("nan")
    found = [change for change in changes if change is not None]
    return Difference(tuple(sorted(found, key=lambda change: not change.worse)), factor, len(before.keys() & after))


def _measured(record: Record) -> bool:
    return record.proven and record.seconds is not None and record.seconds > 0


def _changed(first: Record, second: Record) -> Change | None:
    if first.status != second.status:
        return Change(
            first.problem, first.backend, first.level, f"was {first.status}, is {second.status}", first.proven
        )
    if not _measured(first) or not _measured(second):
        return None
    before, after = first.seconds or 0.0, second.seconds or 0.0
    factor = after / before
    if max(before, after) < _MEASURABLE or max(factor, 1 / factor) < NOTABLE:
        return None
    said = f"{before:.3g} s, then {after:.3g} s ({factor:.2f} x)"
    return Change(first.problem, first.backend, first.level, said, factor > 1)


def _lacking(record: Record, what: str) -> Change:
    return Change(record.problem, record.backend, record.level, what, False)
