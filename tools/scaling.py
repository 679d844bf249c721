"""How the multigrid of many processes scales, on paper: messages are counted, and a few numbers of a machine assumed.

    python tools/scaling.py

No line is a run of so many processes. What each process sends in a cycle is counted by the levels, and tests hold these
counts against those of runs of a few; seconds follow from `Machine`, on each level those of the slowest process, for
which the others wait. Strong scaling: one square, by more and more processes. Weak scaling: as many nodes for each
process. Strips of fewer than 16 rows, or of 64 where that is faster, are merged. A cycle is one of the finest lattice,
in which no node comes into contact or leaves it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from math import ceil, isqrt, log2
from typing import NamedTuple

import numpy as np

from contactqp.methods.multigrid.hierarchy import VISITED, Plan, plans
from contactqp.methods.multigrid.rows import BLOCK, DIRECT
from contactqp.methods.multigrid.strips import LEAST_ROWS, divided, held, merged, merging

REACH = 6
"""Rows of the gap that neighbours exchange."""

TOLD = 128
"""Bytes that a process tells all others at once."""

TELLINGS = 2
"""How often that happens in a cycle: what is out of balance, and whether bounds have cut the correction short."""

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
        Of one pass over one node, in one thread: what a cycle on 8191² nodes took two processes on two cores, 1.0 s,
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
    pass_seconds: float = 4e-9
    told_seconds: float = 2e-6
    node_bytes: float = 100.0
    process_bytes: float = 0.2e9


MACHINE = Machine()


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


class Level(NamedTuple):
    """One level below the lattice.

    Attributes
    ----------
    plan : Plan
    found : tuple of int
        The first row that each process finds from the level above, and one past the last row.
    edges : tuple of int
        The first row of each process that holds it, and one past the last row.
    step : int
        How many strips are merged into one.
    """

    plan: Plan
    found: tuple[int, ...]
    edges: tuple[int, ...]
    step: int


@cache
def levels(rows: int, columns: int, ranks: int, least: int = BLOCK) -> list[Level]:
    """Return the levels of a lattice of equal arms, whose rows are divided among so many processes."""
    edges, made = tuple(divided(rows, ranks, least)), []
    for plan in plans(Square(rows, columns)):  # type: ignore[arg-type]
        found = (1, *(edge // plan.row_coarsening for edge in edges[1:-1]), plan.rows + 1)
        step = len(edges) - 1 if plan.rows * plan.columns <= DIRECT else merging(found, least)
        edges = merged(found, step)
        made.append(Level(plan, found, edges, step))
    return made


@dataclass
class Cycle:
    """What a process does in a cycle, or of it on one level.

    Attributes
    ----------
    ranks : int
        How many processes there are.
    messages, sent : int
        To some others, and the bytes in them.
    passes : float
        Nodes that are passed over.
    nodes : float
        That are held of the lattice, and of levels whose strips are merged, beyond what it would hold of them alone.
    tellings : int
        How often all are told something.
    """

    ranks: int
    messages: int = 0
    sent: int = 0
    passes: float = 0.0
    nodes: float = 0.0
    tellings: int = 0

    def send(self, rows: int, row_bytes: int, times: int) -> None:
        """Count a message of some rows."""
        if rows > 0:
            self.messages += times
            self.sent += times * rows * row_bytes

    def seconds(self, machine: Machine = MACHINE) -> float:
        """Return how long it takes."""
        waits = self.messages + ceil(log2(self.ranks)) * self.tellings
        read = self.tellings * self.ranks * (machine.told_seconds + TOLD / machine.bandwidth)
        return machine.latency * waits + self.sent / machine.bandwidth + read + machine.pass_seconds * self.passes

    def memory(self, machine: Machine = MACHINE) -> float:
        """Return the bytes of the process."""
        return machine.process_bytes + machine.node_bytes * self.nodes


def stages(rows: int, columns: int, ranks: int, rank: int, least: int = BLOCK) -> list[Cycle]:
    """Return what a process does on the lattice and on each level that it has a share in, see `cycle`."""
    edges = tuple(divided(rows, ranks, least))
    own, neighbours = edges[rank + 1] - edges[rank], (rank > 0) + (rank < ranks - 1)
    stage = Cycle(ranks, nodes=own * columns, tellings=TELLINGS if ranks > 1 else 0)
    stage.passes = LATTICE_PASSES * (own + REACH * neighbours) * columns
    for _ in range(neighbours):
        stage.send(REACH, 8 * (columns + 2), 2)
    made = [stage]
    for depth, level in enumerate(levels(rows, columns, ranks, least)):
        plan, step, stage = level.plan, level.step, Cycle(ranks)
        made.append(stage)
        visits, coarsest = depth + 1, plan.row_coarsening * plan.column_coarsening == 1
        smoothings = 0 if coarsest else visits + 1
        row_bytes = (8 if plan.precision == "float64" else 4) * (plan.columns + 2)
        own = level.found[rank + 1] - level.found[rank]
        if step > 1:
            _hand_over(stage, level.found, step, rank, row_bytes, visits)
            if rank % step or rank // step >= len(level.edges) - 1:
                return made
            rank //= step
        height = level.edges[rank + 1] - level.edges[rank]
        neighbours = (rank > 0) + (rank < len(level.edges) - 2)
        stage.nodes = (height - own) * plan.columns
        for _ in range(neighbours):
            stage.send(VISITED, row_bytes, smoothings + (visits if step == 1 else 0))
        stage.passes = (visits + 3 * smoothings) * (height + VISITED * neighbours) * plan.columns
    return made


def cycle(rows: int, columns: int, ranks: int, rank: int, least: int = BLOCK) -> Cycle:
    """Return what a process does in a cycle in which no node comes into contact or leaves it, and no bound cuts.

    Parameters
    ----------
    rows, columns : int
        Nodes of the lattice.
    ranks, rank : int
        How many processes there are, and which of them it is.
    least : int
        See `contactqp.methods.multigrid.strips.LEAST_ROWS`.
    """
    made = stages(rows, columns, ranks, rank, least)
    names = "messages", "sent", "passes", "nodes", "tellings"
    return Cycle(ranks, *(sum(getattr(stage, name) for stage in made) for name in names))


def _hand_over(found: Cycle, edges: tuple[int, ...], step: int, rank: int, row_bytes: int, times: int) -> None:
    """Count what goes to those who hold merged strips, and what these give back."""
    ranks, strips = len(edges) - 1, merged(edges, step)
    last = len(strips) - 2
    strip = min(rank // step, last)
    first_row, last_row = held(edges, rank, 0)
    for other in range(max(0, strip - 1), min(last, strip + 1) + 1):
        wanted = held(strips, other, VISITED)
        if other * step != rank:
            found.send(min(last_row, wanted[1]) - max(first_row, wanted[0]), row_bytes, times)
    if rank == strip * step:
        for member in range(rank + 1, ranks if strip == last else rank + step):
            first_row, last_row = held(edges, member, VISITED)
            found.send(last_row - first_row, row_bytes, times)


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
    megabytes : float
        In these.
    """

    ranks: int
    points: int
    seconds: float
    speed_up: float
    gigabytes: float
    messages: int
    megabytes: float

    @property
    def efficiency(self) -> float:
        """Speed-up over processes."""
        return self.speed_up / self.ranks


def telling(points: int, ranks: int, least: int) -> list[int]:
    """Return the processes that may be the slowest on some level: the first, the last ones, and those of most rows."""
    steps = [1 << k for k in range(ranks.bit_length())]
    chosen = {0, ranks // 2, *((ranks // step - 1) * step for step in steps)}
    step = 1
    for edges, more in [
        (divided(points, ranks, least), 1),
        *(level[2:] for level in levels(points, points, ranks, least)),
    ]:
        step *= more
        heights = np.diff(edges)
        inner = int(np.argmax(heights[1:-1])) + 1 if heights.size > 2 else 0
        chosen |= {step * int(np.argmax(heights)), step * inner}
    return sorted(chosen)


def line(points: int, ranks: int, machine: Machine = MACHINE) -> Line:
    """Return a line for a square of so many nodes along a side."""
    return min((_line(points, ranks, least, machine) for least in (BLOCK, LEAST_ROWS)), key=lambda way: way.seconds)


def _line(points: int, ranks: int, least: int, machine: Machine) -> Line:
    chosen = telling(points, ranks, least)
    on_levels = zip_longest(*(stages(points, points, ranks, rank, least) for rank in chosen), fillvalue=Cycle(ranks))
    seconds = sum(max(stage.seconds(machine) for stage in stages_of_all) for stages_of_all in on_levels)
    every = [cycle(points, points, ranks, rank, least) for rank in chosen]
    alone = cycle(points, points, 1, 0).seconds(machine)
    messages = max(found.messages + found.tellings for found in every)
    sent = max(found.sent + TOLD * found.tellings for found in every)
    memory = max(found.memory(machine) for found in every)
    return Line(ranks, points, seconds, alone / seconds, memory / 1e9, messages, sent / 1e6)


STRONG = (31_623, 316_227), (1, 10, 100, 300, 1000, 1900, 10_000)
"""Nodes along the sides of squares of 10⁹ and 10¹¹ nodes, and the numbers of processes."""

WEAK = (10_000_000, (1, 10, 100, 300, 1000, 10_000))
"""Nodes for each process, and the numbers of processes: up to 10¹¹ nodes."""


def side(ranks: int) -> int:
    """Return the nodes along the side of a square that has as many for each process as `WEAK` says."""
    return isqrt(WEAK[0] * ranks)


def table(points_of: dict[int, int]) -> str:
    """Return a table for processes and the nodes along the side of their square, as the pages show it."""
    rows = ["| processes | nodes along a side | messages | MB | s | efficiency | GB |", "|---" * 7 + "|"]
    for ranks, points in points_of.items():
        found = line(points, ranks)
        numbers = found.messages, found.megabytes, found.seconds, found.efficiency, found.gigabytes
        rows.append("| " + " | ".join([f"{ranks:,}", f"{points:,}", *map(short, numbers)]) + " |")
    return "\n".join(rows)


def short(number: float) -> str:
    """Return a number in two digits, or whole."""
    return f"{number:,.0f}" if number >= 10 else f"{number:.2g}"


def tables() -> dict[str, str]:
    """Return the tables of strong and of weak scaling, by their names."""
    sides, counts = STRONG
    strong = {
        f"Strong scaling, {points:,}² nodes": table({ranks: points for ranks in counts if points >= BLOCK * ranks})
        for points in sides
    }
    return {**strong, "Weak scaling": table({ranks: side(ranks) for ranks in WEAK[1]})}


if __name__ == "__main__":
    for name, lines in tables().items():
        print(f"{name}\n\n{lines}\n")
