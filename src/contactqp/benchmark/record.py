"""Ask and Record: what a solver's process is told, and what is known of its answer."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, Self

REFERENCE = "reference"
"""The name under which the truth of a problem is found out."""

Listed = Literal["none", "usual", "all"]
"""Which backends are listed beside the truth of a problem, for who has named none."""


@dataclass(frozen=True)
class Ask:
    """One solver, one problem, one setting.

    Attributes
    ----------
    family : str
    number : int
        What the problem of the family is made by.
    backend : str
        A name, or ``module:Class`` of a `Backend` (then `imported`).
    level : str
    time_limit : float
        Seconds.
    memory : int
        Bytes.
    repeats : int
    imported : bool
        Whether the backend is to be imported.
    """

    family: str
    number: int
    backend: str
    level: str
    time_limit: float
    memory: int
    repeats: int = 1
    imported: bool = False

    @property
    def problem(self) -> str:
        """The problem's name."""
        return f"{self.family} {self.number}"

    @property
    def key(self) -> tuple[str, int, str, str]:
        """What tells it from others of the same suite."""
        return self.family, self.number, self.backend, self.level


@dataclass(frozen=True)
class Record:
    """One line of a benchmark.

    Attributes
    ----------
    family, number, backend, level
        See `Ask`.
    size : int or None
        Unknowns; None where the process ended before it told.
    status : str
        That of the judge (proven), ``"missing"``, ``"unsuitable"`` or ``"error"`` without an answer, and ``"killed"``
        or ``"out of memory"`` where the process was ended.
    claimed : bool
        Whether the solver itself said that it had solved the problem.
    message : str
        The solver's words, or the error's.
    tol : float
        What was asked for, relative to the error scale.
    setup_seconds, solve_seconds, seconds, loading_seconds : float or None
        The least of all runs: making ready, solving, and all with scaling and judging; and what loading took at first,
        which is no part of the others.
    iterations : int or None
    relative_residual, relative_bound : float or None
        Natural residual, and proven bound of the error, over the error scale.
    error_lower, error_upper : float or None
        Two numbers between which the true error lies, over the same scale; None where the truth is not enclosed.
    peak_memory, base_memory : int or None
        Bytes that the process has held at most, and before it solved.
    """

    family: str
    number: int
    backend: str
    level: str
    size: int | None = None
    status: str = "error"
    claimed: bool = False
    message: str = ""
    tol: float = 1e-6
    setup_seconds: float | None = None
    solve_seconds: float | None = None
    seconds: float | None = None
    loading_seconds: float | None = None
    iterations: int | None = None
    relative_residual: float | None = None
    relative_bound: float | None = None
    error_lower: float | None = None
    error_upper: float | None = None
    peak_memory: int | None = None
    base_memory: int | None = None

    @classmethod
    def of(cls, ask: Ask, **known: Any) -> Self:
        """Return the record of an ask."""
        return cls(ask.family, ask.number, ask.backend, ask.level, **known)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """Return the record that plain data stand for; what this release does not know is left out."""
        known = {field.name for field in fields(cls)}
        return cls(**{name: value for name, value in data.items() if name in known})

    def to_dict(self) -> dict[str, Any]:
        """Return the record as plain data."""
        return asdict(self)

    @property
    def key(self) -> tuple[str, int, str, str]:
        """See `Ask.key`."""
        return self.family, self.number, self.backend, self.level

    @property
    def problem(self) -> str:
        """The problem's name."""
        return f"{self.family} {self.number}"

    @property
    def proven(self) -> bool:
        """Whether the answer is proven to be as good as was asked for."""
        return self.status == "certified"

    @property
    def error_at_most(self) -> float | None:
        """The least number that the true error is proven not to exceed, over the error scale; None if there is none."""
        known = [bound for bound in (self.relative_bound, self.error_upper) if bound is not None]
        return min(known, default=None)

    @property
    def refuted(self) -> bool:
        """Whether the answer is proven to be worse than was asked for."""
        return self.error_lower is not None and self.error_lower > self.tol

    @property
    def claimed_but_wrong(self) -> bool:
        """Whether the solver said that it had solved what it is proven not to have solved."""
        return self.claimed and self.refuted
