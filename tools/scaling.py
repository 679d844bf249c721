"""How the multigrid of many processes scales, on paper: messages are counted, and a few numbers of a machine assumed.

    python tools/scaling.py

No line is a run of so many processes. What each process sends in a cycle is counted by the levels, and tests hold these
counts against those of runs of a few; seconds follow from `Machine`, those of the process with most rows. Strong
scaling: one square, by more and more processes. Weak scaling: as many nodes for each process. As it is, levels of fewer
than 16 rows a process, or of 64 where that is faster, are held whole by all. Merged, they would be held by every second
process, every fourth, and so on, which is not built. A cycle is one of the finest lattice, in which no node comes into
contact or leaves it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, isqrt, log2
from typing import NamedTuple

from contactqp.methods.multigrid.hierarchy import VISITED, Plan, plans
from contactqp.methods.multigrid.rows import BLOCK, DIRECT
from contactqp.methods.multigrid.strips import LEAST_ROWS, divided, divisible

REACH = 6
"""Rows of the gap that neighbours exchange."""

TOLD = 128
"""Bytes that a process tells all others at once."""

LATTICE_PASSES = 5
"""Three sweeps, the residual with its restriction, and the correction."""


@dataclass(frozen=True)
class Machine:
    """What is assumed of a machine.

    Attributes
    ----------
    latency : float
        Seconds that a message takes, however short; messages are waited for one after the other.
    bandwidth : float
        Bytes per second of a process's link.
    pass_seconds : float
        Of one pass over one node, in one thread: what a cycle on 8191² nodes took two processes on two cores, 1.2 s,
        over the passes that this counts.
    told_seconds : float
        That a process needs to read what another one has told all.
    node_bytes : float
        Memory for each node that a process holds.
    process_bytes : float
        Memory for Python and its libraries.
    """

    latency: float = 1e-5
    bandwidth: float = 1e10
    pass_seconds: float = 5e-9
    told_seconds: float = 2e-6
    node_bytes: float = 100.0
    process_bytes: float = 0.2e9


MACHINE = Machine()

ALL_ROWS = "as it is"
MERGED = "merged"


class Level(NamedTuple):
    """One level below the lattice.

    Attributes
    ----------
    plan : Plan
    edges : list of int
        Its first row of each process, and one past the last row; where all hold it whole, the rows that each finds.
    whole : bool
        Whether every process holds it whole.
    """

    plan: Plan
    edges: list[int]
    whole: bool


@dataclass(frozen=True)
class Square:
    """What plans of levels are made for: a lattice of equal arms and so many rows and columns."""

    rows: int
    columns: int
    typical_arms: tuple[float, float] = (0.25, 0.25)
    stiffest_corrected: float = 1.0
    varying: bool = False

    @property
    def reach(self) -> float:
        """See `contactqp.methods.multigrid.arms.Arms`."""
        squares = (self.columns + 1) ** 2, (self.rows + 1) ** 2
        return min(sum(squares) / 4, *(square / 2 for square in squares))


@dataclass
class Cycle:
    """What a process does in a cycle.

    Attributes
    ----------
    messages, sent : int
        To neighbours.
    gathered, gathered_bytes : int
        Levels that are collected by all, and their bytes.
    tellings : int
        Numbers that are told all.
    passes : float
        Nodes that are passed over.
    nodes : float
        That are held of the lattice, and of the levels that every process holds whole.
    """

    ranks: int
    messages: int = 0
    sent: int = 0
    gathered: int = 0
    gathered_bytes: int = 0
    tellings: int = 0
    passes: float = 0.0
    nodes: float = 0.0

    def exchange(self, neighbours: int, rows: int, row_bytes: int, times: int = 1) -> None:
        """Count rows that are sent to so many neighbours."""
        self.messages += times * neighbours
        self.sent += times * neighbours * rows * row_bytes

    def seconds(self, machine: Machine = MACHINE) -> float:
        """Return how long it takes."""
        deep = ceil(log2(self.ranks))
        waits = self.messages + deep * (self.gathered + self.tellings)
        read = self.tellings * self.ranks * (machine.told_seconds + TOLD / machine.bandwidth)
        moved = (self.sent + self.gathered_bytes) / machine.bandwidth
        return machine.latency * waits + moved + read * (self.ranks > 1) + machine.pass_seconds * self.passes

    def memory(self, machine: Machine = MACHINE) -> float:
        """Return the bytes of a process."""
        return machine.process_bytes + machine.node_bytes * self.nodes


def levels(rows: int, columns: int, ranks: int, least: int = BLOCK) -> Iterator[Level]:
    """Yield the levels, down to the first that is held whole, and those below it."""
    edges, whole = divided(rows, ranks, least), ranks == 1
    for plan in plans(Square(rows, columns)):  # type: ignore[arg-type]
        inner = [edge // plan.row_coarsening for edge in edges[1:-1]]
        edges = [1, plan.rows + 1] if whole else [1, *inner, plan.rows + 1]
        whole = whole or not divisible(plan.rows, ranks, least) or plan.rows * plan.columns <= DIRECT
        yield Level(plan, edges, whole)


def cycle(rows: int, columns: int, ranks: int, rank: int, least: int = BLOCK) -> Cycle:
    """Return what a process does in a cycle in which no node comes into contact or leaves it.

    Parameters
    ----------
    rows, columns : int
        Nodes of the lattice.
    ranks, rank : int
        How many processes there are, and which of them it is.
    least : int
        See `contactqp.methods.multigrid.strips.LEAST_ROWS`.
    """
    edges = divided(rows, ranks, least)
    neighbours = (rank > 0) + (rank < ranks - 1)
    found = Cycle(ranks, tellings=2 if ranks > 1 else 0)
    own = edges[rank + 1] - edges[rank]
    found.exchange(neighbours, REACH, 8 * (columns + 2), 2)
    found.passes = LATTICE_PASSES * (own + REACH * neighbours) * columns
    found.nodes = own * columns
    divided_before = True
    for depth, level in enumerate(levels(rows, columns, ranks, least)):
        visits, coarsest = depth + 1, level.plan.row_coarsening * level.plan.column_coarsening == 1
        row_bytes = (8 if level.plan.precision == "float64" else 4) * (level.plan.columns + 2)
        smoothings = 0 if coarsest else visits + 1
        if not level.whole:
            found.exchange(neighbours, VISITED, row_bytes, visits + smoothings)
        elif divided_before and ranks > 1:
            first, last = level.edges[rank], level.edges[rank + 1]
            own_bytes = row_bytes * (last - first + (rank == 0) + (rank == ranks - 1))
            found.gathered += visits + smoothings
            found.sent += (visits + smoothings) * own_bytes
            found.gathered_bytes += (visits + smoothings) * row_bytes * (level.plan.rows + 2)
        if level.whole and ranks > 1:
            found.nodes += level.plan.rows * level.plan.columns
        held = level.plan.rows if level.whole else level.edges[rank + 1] - level.edges[rank] + VISITED * neighbours
        found.passes += (visits + 3 * smoothings) * held * level.plan.columns
        divided_before = not level.whole
    return found


def merged_cycle(rows: int, columns: int, ranks: int) -> Cycle:
    """Return what the first process would do, were levels of few rows merged onto fewer and fewer processes.

    A level of fewer than `BLOCK` rows for each of the processes that hold the one above it is held by half of them: the
    others send their rows of the residual each time that it is visited, and get back as many of the correction.
    """
    found = Cycle(ranks, tellings=2 if ranks > 1 else 0)
    neighbours = min(2, ranks - 1)
    own, holding = -(-rows // ranks), ranks
    found.exchange(neighbours, REACH, 8 * (columns + 2), 2)
    found.passes = LATTICE_PASSES * (own + REACH * neighbours) * columns
    found.nodes = own * columns
    for depth, plan in enumerate(plans(Square(rows, columns))):  # type: ignore[arg-type]
        visits, coarsest = depth + 1, plan.row_coarsening * plan.column_coarsening == 1
        smoothings = 0 if coarsest else visits + 1
        row_bytes = (8 if plan.precision == "float64" else 4) * (plan.columns + 2)
        while holding > 1 and plan.rows < BLOCK * holding:
            handed_on = -(-plan.rows // holding)
            holding = -(-holding // 2)
            found.exchange(1, handed_on, row_bytes, visits + smoothings)
        neighbours, own = min(2, holding - 1), -(-plan.rows // holding)
        found.exchange(neighbours, VISITED, row_bytes, visits + smoothings)
        found.passes += (visits + 3 * smoothings) * (own + VISITED * neighbours) * plan.columns
        if plan.rows * plan.columns <= DIRECT:
            break
    return found


class Line(NamedTuple):
    """A line of a table.

    Attributes
    ----------
    ranks, points : int
        Processes, and nodes along a side.
    seconds, speed_up, gigabytes : float
        Of a cycle; over one process, which needs no messages; of memory.
    messages : int
        In a cycle.
    """

    ranks: int
    points: int
    seconds: float
    speed_up: float
    gigabytes: float
    messages: int

    @property
    def efficiency(self) -> float:
        """Speed-up over processes."""
        return self.speed_up / self.ranks


def slowest(points: int, ranks: int, least: int) -> Cycle:
    """Return what the process does that has most rows, and of these one in the middle."""
    edges = divided(points, ranks, least)
    most = max(range(ranks), key=lambda rank: (edges[rank + 1] - edges[rank], 0 < rank < ranks - 1))
    return cycle(points, points, ranks, most, least)


def line(points: int, ranks: int, kind: str, machine: Machine = MACHINE) -> Line:
    """Return a line for a square of so many nodes along a side."""
    if kind == MERGED:
        found = merged_cycle(points, points, ranks)
    else:
        found = min(
            (slowest(points, ranks, least) for least in (BLOCK, LEAST_ROWS)), key=lambda way: way.seconds(machine)
        )
    seconds = found.seconds(machine)
    alone = machine.pass_seconds * cycle(points, points, 1, 0).passes
    messages = found.messages + found.gathered + found.tellings
    return Line(ranks, points, seconds, alone / seconds, found.memory(machine) / 1e9, messages)


STRONG = (31_623, (1, 10, 100, 300, 1000, 1900))
"""10⁹ nodes, and the numbers of processes."""

WEAK = (10_000_000, (1, 10, 100, 300, 1000, 10_000))
"""Nodes for each process, and the numbers of processes: up to 10¹¹ nodes."""


def side(ranks: int) -> int:
    """Return the nodes along the side of a square that has as many for each process as `WEAK` says."""
    return isqrt(WEAK[0] * ranks)


def table(points_of: dict[int, int]) -> str:
    """Return a table for processes and the nodes along the side of their square, as the pages show it."""
    each = "messages | s | efficiency | GB"
    rows = [f"| processes | nodes along a side | {each} | merged: {each} |", "|---" * 10 + "|"]
    for ranks, points in points_of.items():
        cells = [f"{ranks:,}", f"{points:,}"]
        for kind in (ALL_ROWS, MERGED):
            found = line(points, ranks, kind)
            numbers = (found.messages, found.seconds, found.efficiency, found.gigabytes)
            cells += [short(number) for number in numbers]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def short(number: float) -> str:
    """Return a number in two digits, or whole."""
    return f"{number:,.0f}" if number >= 10 else f"{number:.2g}"


def tables() -> tuple[str, str]:
    """Return the tables of strong and of weak scaling."""
    return table(dict.fromkeys(STRONG[1], STRONG[0])), table({ranks: side(ranks) for ranks in WEAK[1]})


if __name__ == "__main__":
    for name, lines in zip(("Strong scaling", "Weak scaling"), tables(), strict=True):
        print(f"{name}\n\n{lines}\n")
