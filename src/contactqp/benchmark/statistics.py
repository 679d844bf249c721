"""What a benchmark's records say of each solver: times that count failures, profiles, growth, and wrong claims."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Vector
from .record import Record

SHIFT = 0.1
"""Seconds that are added to each time before the mean is taken, so that the shortest ones do not decide it."""

_MEASURABLE = 2e-3
"""Seconds below which a time says nothing of growth."""

_SHORTEST = 1e-6
"""Seconds, as which a time that the clock does not tell from none counts."""

_SIZES = 3
"""Sizes that a growth is fitted to at least."""

Solver = tuple[str, str]
"""A backend and its level."""


def by_solver(records: Iterable[Record]) -> dict[Solver, list[Record]]:
    """Return the records of each backend at each level, in the order in which they come."""
    found: dict[Solver, list[Record]] = {}
    for record in records:
        found.setdefault((record.backend, record.level), []).append(record)
    return found


def shifted_geometric_mean(seconds: Sequence[float], shift: float = SHIFT) -> float:
    """Return exp(mean(log(t + s))) - s, as benchmarks of optimisation programs give it (Mittelmann).

    Examples
    --------
    >>> round(shifted_geometric_mean([0.0, 0.3], shift=0.1), 12)
    0.1
    """
    times = np.asarray(seconds, dtype=float)
    return float(np.exp(np.log(times + shift).mean()) - shift)


def seconds_that_count(record: Record, limit: float) -> float:
    """Return a proven answer's seconds, and the time limit for any other: a failure takes all the time there is."""
    return limit if not record.proven or record.seconds is None else min(record.seconds, limit)


@dataclass(frozen=True)
class Summary:
    """One solver's line.

    Attributes
    ----------
    backend, level : str
    asked, proven : int
        Problems that it was asked about, and those that it is proven to have solved; not counted are problems that do
        not suit it, and solvers that are missing.
    refuted, unknown : int
        Answers that are proven to be worse than asked for, and those of which neither is known.
    claimed : int
        Answers of which it said itself that the problem was solved.
    claimed_but_wrong : int
        Those among them that are refuted.
    mean_seconds : float
        Shifted geometric mean; a problem that is not proven counts with the time limit.
    relative_mean : float
        That over the least of all solvers of the same level that were asked about the same problems.
    peak_memory : int
        Bytes, the most of all problems, beyond what the process held before.
    """

    backend: str
    level: str
    asked: int
    proven: int
    refuted: int
    unknown: int
    claimed: int
    claimed_but_wrong: int
    mean_seconds: float
    relative_mean: float
    peak_memory: int


def summaries(records: Sequence[Record], limit: float) -> list[Summary]:
    """Return a line for each solver, the best first within a level.

    Means are taken over the problems that suit all solvers of a level but those that are left out by their own limits,
    so a solver that was asked about hard problems only is compared on its own problems.

    Parameters
    ----------
    records : sequence of Record
    limit : float
        The time limit of a solve (s).
    """
    suited = [record for record in records if record.status not in ("missing", "unsuitable")]
    times: dict[tuple[str, str], dict[str, float]] = {}
    for record in suited:
        solver = times.setdefault((record.backend, record.level), {})
        solver[record.problem] = seconds_that_count(record, limit)
    found = []
    for (backend, level), own in by_solver(suited).items():
        mine = times[backend, level]
        same = [
            shifted_geometric_mean([other[problem] for problem in mine])
            for (_, its), other in times.items()
            if its == level and set(mine) <= set(other)
        ]
        mean = shifted_geometric_mean(list(mine.values()))
        found.append(
            Summary(
                backend,
                level,
                len(own),
                sum(record.proven for record in own),
                sum(record.refuted for record in own),
                sum(not record.proven and not record.refuted for record in own),
                sum(record.claimed for record in own),
                sum(record.claimed_but_wrong for record in own),
                mean,
                mean / max(min(same), 1e-9),
                max((max(0, (record.peak_memory or 0) - (record.base_memory or 0)) for record in own), default=0),
            )
        )
    return sorted(found, key=lambda line: (line.level, -line.proven / line.asked, line.mean_seconds))


def profile(records: Sequence[Record], level: str) -> tuple[Vector, Mapping[str, Vector]]:
    """Return a performance profile: the part of the problems that each solver proves within τ times the best's time.

    Dolan and Moré, *Benchmarking optimization software with performance profiles*, Mathematical Programming 91 (2002).
    A problem that a solver does not suit, for which it is missing, or about which it was not asked counts as not
    solved by it, as they have it.

    Parameters
    ----------
    records : sequence of Record
    level : str

    Returns
    -------
    factors : array
        τ, ascending from 1.
    parts : mapping of str to array
        By backend, in [0, 1].
    """
    chosen = [record for record in records if record.level == level]
    problems = list(dict.fromkeys(record.problem for record in chosen))
    backends = list(dict.fromkeys(record.backend for record in chosen))
    times = np.full((len(backends), len(problems)), np.inf)
    for record in chosen:
        if record.proven and record.seconds is not None:
            times[backends.index(record.backend), problems.index(record.problem)] = max(record.seconds, _SHORTEST)
    best = times.min(axis=0) if times.size else np.empty(0)
    solved = np.isfinite(best)
    ratios = times[:, solved] / best[solved]
    finite = ratios[np.isfinite(ratios)]
    factors = np.unique(np.concatenate([[1.0], finite]))
    return factors, {
        backend: np.array([(row <= factor).sum() for factor in factors]) / max(len(problems), 1)
        for backend, row in zip(backends, ratios, strict=True)
    }


@dataclass(frozen=True)
class Growth:
    """How a solver's time grows with the size within a family: seconds = c · size^exponent.

    Attributes
    ----------
    family, backend, level : str
    sizes, seconds : array
        Of the proven answers, by size.
    exponent : float
        The slope of a straight line through the logarithms (least squares).
    """

    family: str
    backend: str
    level: str
    sizes: Vector
    seconds: Vector
    exponent: float


def growths(records: Iterable[Record]) -> list[Growth]:
    """Return the growth of each solver within each family of which it has proven some sizes in measurable time."""
    groups: dict[tuple[str, str, str], list[Record]] = {}
    for record in records:
        if record.proven and record.seconds is not None and record.seconds > _MEASURABLE:
            groups.setdefault((record.family, record.backend, record.level), []).append(record)
    found = []
    for (family, backend, level), group in groups.items():
        own = sorted(group, key=lambda record: record.size or 0)
        sizes = np.array([float(record.size or 0) for record in own])
        seconds = np.array([record.seconds or 0.0 for record in own])
        slope = exponent(sizes, seconds)
        if slope is not None:
            found.append(Growth(family, backend, level, sizes, seconds, slope))
    return found


def exponent(sizes: Vector, seconds: Vector) -> float | None:
    """Return the exponent of a growth, as `Growth` has it; None without three sizes that take measurable time.

    Examples
    --------
    >>> exponent(np.array([1.0, 2.0, 4.0]), np.array([3.0, 12.0, 48.0])).__round__(12)
    2.0
    """
    measurable = seconds > _MEASURABLE
    if np.unique(sizes[measurable]).size < _SIZES:
        return None
    return float(np.polyfit(np.log(sizes[measurable]), np.log(seconds[measurable]), 1)[0])
