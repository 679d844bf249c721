"""What the conformance kit has found out about a backend."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import Literal

_WIDTH = 80


@dataclass(frozen=True)
class CheckResult:
    """What one check has found.

    Attributes
    ----------
    check : str
        What was tried, in a few words.
    outcome : {"pass", "fail", "skip"}
        "skip" where the check does not apply to the backend.
    expected, got : str
        Of a check that fails what should have been, and what was; of one that is skipped ``got`` is the reason.
    """

    check: str
    outcome: Literal["pass", "fail", "skip"]
    expected: str = ""
    got: str = ""


@dataclass(frozen=True, repr=False)
class ConformanceReport:
    """What all checks of `contactqp.testing.check_backend` have found; printing it shows a table.

    Attributes
    ----------
    backend : str
        Its name.
    results : tuple of CheckResult
        In the order in which they were made.

    Examples
    --------
    >>> fair = CheckResult("silence", "pass")
    >>> foul = CheckResult("determinism", "fail", "the same gap twice", "gaps that differ by 0.3")
    >>> report = ConformanceReport("dice", (fair, foul))
    >>> report.ok, [result.check for result in report.failures]
    (False, ['determinism'])
    >>> report
    dice: 1 of 2 checks fail
      pass  silence
      FAIL  determinism
            expected: the same gap twice
            got:      gaps that differ by 0.3
    """

    backend: str
    results: tuple[CheckResult, ...]

    @property
    def ok(self) -> bool:
        """Whether no check fails."""
        return not self.failures

    @property
    def failures(self) -> tuple[CheckResult, ...]:
        """The checks that fail."""
        return tuple(result for result in self.results if result.outcome == "fail")

    def __repr__(self) -> str:
        made = [result for result in self.results if result.outcome != "skip"]
        fails = len(self.failures)
        head = f"{fails} of {len(made)} checks {'fails' if fails == 1 == len(made) else 'fail'}" if fails else ""
        lines = [f"{self.backend}: {head or f'all {len(made)} checks pass'}"]
        for result in self.results:
            shown = "FAIL" if result.outcome == "fail" else result.outcome
            lines.append(f"  {shown}  {result.check}")
            if result.outcome == "skip":
                lines += _told("", result.got)
            elif result.outcome == "fail":
                lines += [*_told("expected: ", result.expected), *_told("got:      ", result.got)]
        return "\n".join(lines)


def _told(heading: str, text: str) -> list[str]:
    first = " " * 8 + heading
    return textwrap.wrap(text or "nothing", _WIDTH, initial_indent=first, subsequent_indent=" " * len(first))
