"""Team: threads that share the rows of a lattice."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import cache
from itertools import pairwise
from types import TracebackType
from typing import Any

_POINTS_WORTH_A_THREAD = 60_000
"""Handing work to a thread takes some 60 microseconds: as long as a sweep over this many points."""


class Team:
    """Runs a kernel on strips of rows, one strip a thread; kernels release the interpreter lock.

    Parameters
    ----------
    threads : int, optional
        Number of threads, the caller's included; by default the number of cores that this process may use.
    """

    def __init__(self, threads: int | None = None) -> None:
        self.threads = threads or _cores()
        self._pool: ThreadPoolExecutor | None = None

    def __enter__(self) -> Team:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown()

    def strips(self, first: int, last: int, columns: int, least: int = 8) -> list[tuple[int, int]]:
        """Divide the rows [first, last) into strips of about equal height, as many as are worth a thread.

        Each has at least ``least`` rows, if there is more than one.
        """
        rows = last - first
        count = max(1, min(self.threads, rows * columns // _POINTS_WORTH_A_THREAD, rows // least))
        edges = [first + rows * k // count for k in range(count + 1)]
        return list(pairwise(edges))

    def run(self, kernel: Callable[..., Any], strips: list[tuple[int, int]], *arguments: Any) -> list[Any]:
        """Return ``kernel(*arguments, first, last)`` for every strip, of which there may be more than threads.

        What the caller has told numpy to do about overflow and the like (`numpy.errstate`) holds in all of them.
        """
        if self.threads == 1 or len(strips) == 1:
            return [kernel(*arguments, *strip) for strip in strips]
        shares = min(self.threads, len(strips))
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self.threads - 1)
        edges = [len(strips) * k // shares for k in range(shares + 1)]

        def work(first: int, last: int) -> list[Any]:
            return [kernel(*arguments, *strip) for strip in strips[first:last]]

        others = [self._pool.submit(copy_context().run, work, first, last) for first, last in pairwise(edges[1:])]
        results = work(0, edges[1])
        for other in others:
            results += other.result()
        return results


@cache
def shared_team() -> Team:
    """Return the team of the whole process, for work that has no beginning and no end of its own.

    A process that was forked makes one of its own: threads do not come with it.
    """
    return Team()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=shared_team.cache_clear)


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
