"""PosedByRows: the contact problem of one process's rows, and what all of them know together."""

from __future__ import annotations

from functools import cached_property
from hashlib import sha256

import numpy as np

from ..algebra.stencil import Stencil
from ..foundation.checks import Mask, Vector
from ..geometry.numbering import Grid, Layout, Numbering
from ..geometry.runs import SUPPORTED
from ..methods.multigrid.arms import Arms
from ..methods.multigrid.contact import NO_LIMITS, Limits
from ..methods.multigrid.strips import LEAST_ROWS, Strip, divided
from ..models.base import length_scale
from ..problem.barrier import Ends, Parabola, ends_of_lines, parabolas
from ..problem.contact_problem import ContactProblem
from ..problem.contact_qp import ContactQP
from .membrane import MembraneByRows
from .ranks import Ranks


class _PartOfParabola(Parabola):
    """A parabola on a process's rows."""

    def __init__(self, whole: Parabola, part: Strip, layout: Layout) -> None:
        rows = np.ascontiguousarray(whole.rows[part.offset : part.offset + part.height])
        super().__init__(rows, whole.columns, whole.least_s, whole.kind, layout)
        self._part, self._own_layout = part, layout

    @cached_property
    def largest_v(self) -> float:
        """Largest v of all processes' nodes."""
        part, layout = self._part, self._own_layout
        runs = layout.runs[layout.row_start[part.first] : layout.row_start[part.last]]
        nearest = np.clip(int(self.columns.argmax()), runs[:, 1], runs[:, 2] - 1)
        own = self.rows[runs[:, 0]] + self.columns[nearest]
        return max(part.everyones([float(own.max(initial=0.0))]))


class PosedByRows:
    """The contact problem on the rows that a process holds: its own ones, and some of its neighbours'.

    Nodes are numbered row by row within these rows. What is a number for the whole lattice (scale, barrier, arms) is
    the same in every process, to the bit, and for any number of processes.

    Parameters
    ----------
    membrane : MembraneByRows
        The same in every process.
    ranks : Ranks
    least : int
        See `contactqp.methods.multigrid.strips.LEAST_ROWS`.

    Attributes
    ----------
    part : Strip
        The rows, counted within the smallest rectangle that holds all nodes.
    problem : ContactQP
        As posed on these rows, not scaled.
    units : Units
        Those of the dimensionless problem.
    barrier : Parabola
        On these rows.
    lattice : Arms
    stencil : Stencil
        The stiffness.
    reference : array, shape (n,)
        Depths that the gap is measured from (length).
    load : array, shape (n,)
        P on each node (force).

    Raises
    ------
    ValueError
        If a process would have no node, or the lattice too few rows.
    """

    def __init__(self, membrane: MembraneByRows, ranks: Ranks, least: int = LEAST_ROWS) -> None:
        self.membrane, self.ranks = membrane, ranks
        self.top, self.left, shape = self._box()
        edges = divided(shape, membrane.tension, ranks.size, least)
        self.part = Strip(ranks, tuple(edges), least)
        self.columns = slice(self.left, self.left + shape[1])
        nodes, depth, above = ranks.agreed(self._read)
        numbering = Numbering(np.ascontiguousarray(nodes[1:-1, 1:-1]), whole=True)
        lone = [rank for rank, count in enumerate(ranks.everyones([self._count(numbering.mask)])) if not count]
        if lone:
            raise ValueError(f"process {lone[0]} of {ranks.size} has no node in its rows; start fewer processes")
        stencil = Stencil.on(numbering, *membrane.tension)
        self._rows_of_nodes = np.concatenate([[0], np.cumsum(np.count_nonzero(numbering.mask, axis=1))])
        datum = membrane.frame_depth
        supported = numbering.to_vector(np.isfinite(depth), ring=1)
        self.barrier = self._barrier(numbering.layout, shape, self._ends(nodes[1:-1, 1:-1], shape))
        ceiling = None if above is None else numbering.to_vector(above, ring=1)
        scale = self._scale(numbering.to_vector(depth, ring=1), ceiling)
        depth[~(nodes & np.isfinite(depth))] = datum
        self.reference = numbering.to_vector(depth, ring=1)
        self.stencil = stencil
        self.problem: ContactProblem = ContactQP(
            stencil,
            self.load - stencil.pull(depth),
            lower=0.0 if supported.all() else np.where(supported, 0.0, -np.inf),
            upper=np.inf if ceiling is None else np.where(np.isfinite(ceiling), self.reference - ceiling, np.inf),
            gap_scale=scale,
            reference=self.reference - datum if datum else self.reference,
        )
        scaled, self.units = self.problem.scaled()
        self.lattice = self._arms(scaled)

    def _box(self) -> tuple[int, int, tuple[int, int]]:
        """Return first row and column of the smallest rectangle that holds all nodes, and its rows and columns."""
        (rows, columns), ranks = self.membrane.shape, self.ranks
        first, last = (rows * k // ranks.size for k in (ranks.rank, ranks.rank + 1))
        nodes = ranks.agreed(lambda: self.membrane.nodes(first, last))
        own = np.flatnonzero(nodes.any(axis=1)) + first, np.flatnonzero(nodes.any(axis=0))
        sizes = zip(own, (rows, columns), strict=True)
        ends = [(int(at.min(initial=count)), int(at.max(initial=-1))) for at, count in sizes]
        found = ranks.everyones([ends])
        (top, bottom), (left, right) = (
            (min(ends[axis][0] for ends in found), max(ends[axis][1] for ends in found)) for axis in (0, 1)
        )
        if bottom < top:
            raise ValueError(f"mask of shape {self.membrane.shape} holds no node")
        return top, left, (bottom - top + 1, right - left + 1)

    def _read(self) -> tuple[Mask, Grid, Grid | None]:
        """Return nodes, depths and ceiling on the array of the rows with a ring about it, and keep the load."""
        part, membrane = self.part, self.membrane
        first, last = max(1, part.offset), min(part.count + 1, part.offset + part.height)
        rows = self.top + first - 1, self.top + last - 1
        inner = slice(first - part.offset, last - part.offset), slice(1, -1)
        there = membrane.nodes(*rows)
        shape = part.height, self.columns.stop - self.columns.start + 2
        nodes = np.zeros(shape, dtype=np.bool_)
        nodes[inner] = there[:, self.columns]

        def laid_out(name: str) -> Grid:
            grid = np.zeros(shape)
            grid[inner] = membrane.rows_of(name, *rows, there)[:, self.columns]
            return grid

        self.load = (membrane.node_area * laid_out("load"))[1:-1, 1:-1][nodes[1:-1, 1:-1]]
        depth = laid_out("support")
        above = laid_out("ceiling") if membrane.has_ceiling else None
        if above is not None and (crossing := (above > depth) & nodes).any():
            row, column = np.argwhere(crossing)[0]
            raise ValueError(
                f"ceiling must not lie below the support, but at depth {depth[row, column]:g} of the support it is "
                f"at depth {above[row, column]:g}"
            )
        return nodes, depth, above

    def _count(self, mask: Mask) -> int:
        return int(np.count_nonzero(mask[self.part.first - 1 : self.part.last - 1]))

    def _ends(self, mask: Mask, shape: tuple[int, int]) -> tuple[Ends, Ends]:
        """Return where all rows and columns of the whole lattice begin and end."""
        part = self.part
        own = mask[part.first - 1 : part.last - 1]
        begin = part.own[0] - 1
        rows, columns = ends_of_lines(own), ends_of_lines(own.T)
        ends = (
            (rows.lines + begin, rows.first, rows.last),
            (columns.lines, columns.first + begin, columns.last + begin),
        )
        found = self.ranks.everyones([ends])
        first, last = np.full(shape[1], shape[0]), np.full(shape[1], -1)
        for _, (lines, one, other) in found:
            np.minimum.at(first, lines, one)
            np.maximum.at(last, lines, other)
        lines = np.flatnonzero(last >= 0)
        every = Ends(*(np.concatenate(parts) for parts in zip(*(rows for rows, _ in found), strict=True)))
        return every, Ends(lines, first[lines], last[lines])

    def _barrier(self, layout: Layout, shape: tuple[int, int], ends: tuple[Ends, Ends]) -> Parabola:
        """Return the parabola of the least reach, as `contactqp.problem.barrier.find_barrier` does."""
        found = parabolas(shape, self.membrane.tension, (True, True), ends, layout)
        candidates = [_PartOfParabola(whole, self.part, layout) for whole in found if 0 < whole.least_s < np.inf]
        return min(candidates, key=lambda candidate: candidate.reach)

    def _scale(self, depth: Vector, ceiling: Vector | None) -> float | None:
        """Return the length that tolerances are measured by, see `contactqp.models.base.length_scale`."""
        v, count, datum = self.barrier.v, self.total(np.ones(self.load.size)), self.membrane.frame_depth
        # As `Barrier.mean_deflection`, for a load and for suction.
        pushes = (np.maximum(sign * self.load, 0.0) / self.barrier.least_s for sign in (1.0, -1.0))
        mean, suction = (self.total(push * v) / count for push in pushes)
        there = None if ceiling is None else any(self.part.everyones([bool(np.isfinite(ceiling).any())]))
        above = datum - ceiling if ceiling is not None and there else None

        def average(values: Vector) -> float:
            return self.total(values) / count

        return length_scale(mean, suction, v, depth - datum, above, 0.0, average, self.least)

    def _arms(self, scaled: ContactProblem) -> Arms:
        stencil, layout = scaled.stencil, scaled.layout
        assert stencil is not None
        kinds = layout.kinds
        if not all(self.part.everyones([kinds is None])):
            kinds = np.full(layout.mask.shape, SUPPORTED, dtype=np.uint8) if kinds is None else kinds
        laid_out = Layout(layout.mask, kinds)
        return Arms(laid_out, float(stencil.horizontal), float(stencil.vertical), part=self.part)

    def start(self) -> tuple[Grid, Grid, Limits]:
        """Return q, the reference and the bounds of the dimensionless problem on the lattice's grid."""
        (scaled, _), layout = self.problem.scaled(), self.lattice.layout
        limits: Limits = NO_LIMITS
        if not all(self.part.everyones([self.problem.bounds.standard])):
            lower, upper = (np.ascontiguousarray(bound) for bound in (scaled.lower, scaled.upper))
            limits = layout.grid(lower), layout.grid(upper)
        reference = np.broadcast_to(np.asarray(scaled.reference, dtype=np.float64), (scaled.size,))
        grid = layout.grid(np.ascontiguousarray(reference))
        self.part.share(grid)
        return layout.grid(scaled.q), grid, limits

    def nodes_of(self, first: int, last: int) -> slice:
        """Return the numbers of the nodes in the rows [first, last) of the arrays."""
        return slice(int(self._rows_of_nodes[first - 1]), int(self._rows_of_nodes[last - 1]))

    @cached_property
    def fingerprint(self) -> str:
        """Digest of forces and bounds of all nodes, the same for any number of processes."""
        problem, found = self.problem, []
        for block in self.part.blocks:
            at = self.nodes_of(*block)
            data = sha256(self.lattice.layout.mask[block[0] - 1 : block[1] - 1].tobytes())
            for values in (problem.q, problem.lower, problem.upper):
                data.update(np.ascontiguousarray(values[at]).tobytes())
            found.append(data.hexdigest())
        told = f"{self.membrane!r} {self.membrane.origin}", *self.part.everyones(found)
        return sha256("".join(told).encode()).hexdigest()

    @property
    def own(self) -> slice:
        """The numbers of the nodes in the process's own rows."""
        return self.nodes_of(self.part.first, self.part.last)

    def total(self, values: Vector) -> float:
        """Return the sum over all processes' nodes."""
        return self.part.sums([(float(values[self.nodes_of(*block)].sum()),) for block in self.part.blocks])[0]

    def least(self, values: Vector) -> float:
        """Return the least value of all processes' nodes."""
        return min(self.part.everyones([float(values[self.own].min())]))
