"""Suites: which problems, how tight, and within what limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..foundation.checks import integer_at_least, integers_at_least, names_in, nearest, positive_number
from ..foundation.text import counted
from ..solving.tolerances import level_of

GIB = 2**30


@dataclass(frozen=True)
class Suite:
    """What a benchmark consists of.

    Attributes
    ----------
    name : str
    problems : mapping of str to tuple of int
        By family, see `FAMILIES`, the numbers that its problems are made by; one alone may be given as it is.
    levels : tuple of str
        Settings of every backend: "low", "mid", "high" or "default".
    time_limit : float
        Seconds for a solve.
    memory : int
        Bytes for a solver's process.
    repeats : int
        Runs of each solver in its process; the least time counts.

    Raises
    ------
    TypeError, ValueError
        If one of these is of another kind, or out of range.

    Examples
    --------
    >>> print(Suite("tiny", {"bowl": 7}, ("mid",), 5.0, 2 * GIB, 1))
    tiny: 1 problem of 1 family, mid; 5 s and 2 GiB each
    """

    name: str
    problems: Mapping[str, tuple[int, ...]]
    levels: tuple[str, ...]
    time_limit: float
    memory: int
    repeats: int

    def __post_init__(self) -> None:
        if not isinstance(self.problems, Mapping):
            raise TypeError(f"problems must be a mapping, as {{'bowl': (31, 63)}}, got {self.problems!r}")
        problems = {
            family: tuple(integers_at_least(numbers, 1, f"problems[{family!r}]"))
            for family, numbers in self.problems.items()
        }
        object.__setattr__(self, "problems", problems)
        object.__setattr__(
            self, "levels", tuple(level_of(level, "levels") for level in names_in(self.levels, "levels"))
        )
        positive_number(self.time_limit, "time_limit")
        integer_at_least(self.memory, 1, "memory")
        integer_at_least(self.repeats, 1, "repeats")

    def __str__(self) -> str:
        count = sum(map(len, self.problems.values()))
        return (
            f"{self.name}: {counted(count, 'problem')} of {counted(len(self.problems), 'family', 'families')}, "
            f"{', '.join(self.levels)}; "
            f"{self.time_limit:g} s and {self.memory / GIB:g} GiB each"
        )


SUITES: Mapping[str, Suite] = MappingProxyType(
    {
        suite.name: suite
        for suite in (
            Suite(
                "quick",
                {"hexagon": (3,), "bowl": (31,), "between": (31,), "cable": (200,), "beam": (60,), "dense": (60,)},
                ("mid",),
                10.0,
                4 * GIB,
                1,
            ),
            Suite(
                "standard",
                {
                    "hexagon": (1, 3, 10),
                    "bowl": (31, 63, 127, 255),
                    "ball": (31, 63, 127),
                    "spiral": (63, 127),
                    "between": (31, 63, 127),
                    "jumps": (63, 127),
                    "cable": (200, 2000),
                    "beam": (100, 1000),
                    "plate": (31, 63),
                    "scattered": (1000, 10_000),
                    "dense": (100, 400),
                },
                ("mid", "default"),
                20.0,
                8 * GIB,
                2,
            ),
            Suite(
                "large",
                {
                    "bowl": (255, 511, 1023),
                    "ball": (511, 1023),
                    "spiral": (511, 1023),
                    "between": (511, 1023),
                    "jumps": (255, 511),
                    "beam": (10_000, 100_000),
                    "plate": (127, 255),
                    "scattered": (100_000, 1_000_000),
                },
                ("low", "mid", "high"),
                300.0,
                16 * GIB,
                2,
            ),
        )
    }
)


def suite_of(suite: str | Suite) -> Suite:
    """Return the suite of a name; a suite itself is returned as it is.

    Raises
    ------
    ValueError
        If there is none of that name.

    Examples
    --------
    >>> suite_of("quick").levels
    ('mid',)
    """
    if isinstance(suite, Suite):
        return suite
    if suite not in SUITES:
        known = list(SUITES)
        raise ValueError(f"unknown suite {suite!r}{nearest(suite, known)}; known: {', '.join(known)}")
    return SUITES[suite]
