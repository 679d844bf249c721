"""Work that several processes do together, each of them for some rows of what is laid out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, TypeVar

_Found = TypeVar("_Found")


class Together(Protocol):
    """The processes that work on something, as one of them sees them; all of them ask the same, one after the other.

    Attributes
    ----------
    rank, size : int
        Which of them it is, from 0 on, and how many they are.
    """

    rank: int
    size: int

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """Return what all have found, one after the other."""

    def agreed(self, work: Callable[[], _Found]) -> _Found:
        """Do a process's own part of some work; what one of them cannot do is an error in all."""


class Alone:
    """A process that works by itself."""

    rank, size = 0, 1

    def everyones(self, found: list[_Found]) -> list[_Found]:
        """See `Together`."""
        return found

    def agreed(self, work: Callable[[], _Found]) -> _Found:
        """See `Together`."""
        return work()


ALONE = Alone()


def share_of(count: int, together: Together) -> tuple[int, int]:
    """Return the part [first, last) of so many rows that a process takes.

    Examples
    --------
    >>> share_of(10, ALONE)
    (0, 10)
    """
    return count * together.rank // together.size, count * (together.rank + 1) // together.size


_POINTS = 1 << 18


def chunks(first: int, last: int, columns: int) -> Iterator[tuple[int, int]]:
    """Yield the rows [first, last) in parts of so many points that temporary arrays of them take little memory.

    Examples
    --------
    >>> list(chunks(3, 8, 1 << 17))
    [(3, 5), (5, 7), (7, 8)]
    """
    step = max(1, _POINTS // max(1, columns))
    for row in range(first, last, step):
        yield row, min(row + step, last)
