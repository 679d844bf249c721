"""PosedByRows: the contact problem of one process's rows, and what all of them know together."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import TypeAlias

import numpy as np

from ..algebra.stiffness import LatticeStiffness
from ..foundation.checks import Mask, Vector
from ..foundation.threads import Team
from ..geometry.numbering import Grid, Layout, Numbering
from ..geometry.runs import FREE, SUPPORTED
from ..methods.multigrid.arms import Arms, joined_to_nodes
from ..methods.multigrid.contact import NO_LIMITS, Limits
from ..methods.multigrid.strips import LEAST_ROWS, Strip, divided
from ..models.base import length_scale
from ..problem.barrier import Ends, ends_of_lines, parabolas
from ..problem.contact_problem import ContactProblem
from ..problem.contact_qp import ContactQP
from ..proof.lattice_measures import LatticeMeasures
from .barriers import BarrierOfRows, PartOfBarrier, PartOfParabola, found_barrier
from .measures import MeasuresByRows
from .membrane import MembraneByRows
from .ranks import Ranks
from .stencils import PartOfStencil

MeasuresOfRows: TypeAlias = LatticeMeasures | MeasuresByRows


@dataclass
class _Read:
    """What a process has read of the membrane, on the array of its rows with a ring about it.

    Attributes
    ----------
    nodes : array of bool
    depth : array
        Of the support.
    above : array or None
        Depths of the ceiling.
    across, along : float or array
        Stiffness of the arms between points of the array's inner rows, along rows and along columns.
    ground : float or array
        Stiffness of the foundation at these.
    frame : float or array
        Depths of the frame where it holds arms, nan elsewhere.
    """

    nodes: Mask
    depth: Grid
    above: Grid | None
    across: float | Grid
    along: float | Grid
    ground: float | Grid
    frame: float | Grid


class ScaledByRows:
    """The dimensionless problem on a process's rows, see `contactqp.methods.multigrid.nested.Scaled`."""

    def __init__(self, posed: PosedByRows) -> None:
        self._problem = posed.problem
        self._scaled, _ = posed.problem.scaled()
        self._layout, self._part = posed.lattice.layout, posed.part

    @property
    def q(self) -> Vector:
        """Reaction that would hold the gap zero, shape (n,)."""
        return self._scaled.q

    def force_grid(self) -> Grid:
        """Return the same on the lattice's grid; as a vector it is made anew, and not kept."""
        return self._layout.grid(self._problem.scaled()[0].q)

    def reference_grid(self) -> Grid:
        """Return the reference ordinates of nodes and frame points on the grid."""
        grid = self._scaled.reference_grid()
        self._part.share(grid)
        return grid

    def bound_grids(self) -> Limits:
        """Return the bounds on the grid; where no node of any process is bounded by other than zero, empty grids."""
        scaled = self._scaled
        if all(self._part.everyones([scaled.bounds.standard])):
            return NO_LIMITS
        lower, upper = (self._layout.grid(np.ascontiguousarray(bound)) for bound in (scaled.lower, scaled.upper))
        return lower, upper

    def project(self, gap: Vector) -> Vector:
        """Return the admissible gap nearest to a gap, node by node."""
        return self._scaled.project(gap)


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
    threads : int
        Threads of each process.
    start : callable, optional
        Reads what is to be started from: it is called as soon as the rows are known, before what takes long.

    Attributes
    ----------
    part : Strip
        The rows, counted within the smallest rectangle that holds all nodes.
    numbering : Numbering
        The nodes that vectors hold, and their places in the array of the rows without its ring.
    problem : ContactQP
        As posed on these rows, not scaled.
    units : Units
        Those of the dimensionless problem.
    barrier : PartOfParabola or PartOfBarrier
        On these rows.
    lattice : Arms
    stencil : Stencil
        The stiffness.
    reference : array, shape (n,)
        Depths that the gap is measured from (length).
    load : array, shape (n,)
        P on each node (force).
    datum, relief : float
        Mean depth of the frame, and how far it leaves that at most (length).

    Raises
    ------
    ValueError
        If a process would have no node, or the lattice too few rows; or if the tension varies too much for a proof; or
        if there is nothing to start from on these rows.
    """

    def __init__(
        self,
        membrane: MembraneByRows,
        ranks: Ranks,
        least: int = LEAST_ROWS,
        threads: int = 1,
        start: Callable[[PosedByRows], None] | None = None,
    ) -> None:
        self.membrane, self.ranks, self._threads = membrane, ranks, threads
        self.top, self.left, shape = self._box()
        self.part = Strip(ranks, tuple(divided(shape[0], ranks.size, least)), least)
        self.columns = slice(self.left, self.left + shape[1])
        read = ranks.agreed(self._read)
        nodes, depth, above = read.nodes, read.depth, read.above
        self.numbering = numbering = Numbering(np.ascontiguousarray(nodes[1:-1, 1:-1]), whole=True)
        lone = [rank for rank, count in enumerate(ranks.everyones([self._count(numbering.mask)])) if not count]
        if lone:
            raise ValueError(f"process {lone[0]} of {ranks.size} has no node in its rows; start fewer processes")
        if start is not None:
            start(self)
        self._rows_of_nodes = np.concatenate([[0], np.cumsum(np.count_nonzero(numbering.mask, axis=1))])
        self.load = ranks.agreed(self._read_load)
        self.stencil = stencil = self._stencil(numbering, read)
        self.datum, self.relief, self._frame = self._frame_depths(read.frame)
        datum = self.datum
        supported = numbering.to_vector(np.isfinite(depth), ring=1)
        self.barrier: BarrierOfRows = self._barrier(shape, self._ends(nodes[1:-1, 1:-1], shape))
        self._ceiling = ceiling = None if above is None else numbering.to_vector(above, ring=1)
        scale = self._scale(numbering.to_vector(depth, ring=1))
        depth[~np.isfinite(depth)] = datum
        np.copyto(depth, self._frame, where=~nodes)
        self.reference = numbering.to_vector(depth, ring=1)
        self.problem: ContactProblem = ContactQP(
            stencil,
            self.load - stencil.pull(depth),
            lower=0.0 if supported.all() else np.where(supported, 0.0, -np.inf),
            upper=np.inf if ceiling is None else np.where(np.isfinite(ceiling), self.reference - ceiling, np.inf),
            gap_scale=scale,
            reference=self.reference - datum if datum else self.reference,
            frame_reference=np.asarray(self._frame - datum) if self.relief else None,
        )
        scaled, self.units = self.problem.scaled()
        self.lattice = self._lattice(scaled)

    def under(self, membrane: MembraneByRows) -> PosedByRows:
        """Return the problem of a membrane that differs in its load alone; it shares all that has been set up.

        Raises
        ------
        TypeError, ValueError
            If the load is no good; in every process.
        """
        if membrane is self.membrane:
            return self
        other, problem = copy(self), self.problem
        vars(other).pop("fingerprint", None)
        other.membrane = membrane
        other.load = self.ranks.agreed(other._read_load)
        forces = other.load - self.stencil.pull(self.heights(self.reference))
        scale = other._scale(np.where(problem.bounds.supported, self.reference, np.inf))
        other.problem = problem.with_forces(forces, gap_scale=scale)
        _, other.units = other.problem.scaled()
        return other

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

    def _read(self) -> _Read:
        """Return what the membrane is on the array of the rows, with a ring about it."""
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

        depth = laid_out("support")
        above = laid_out("ceiling") if membrane.has("ceiling") else None
        if above is not None and (crossing := (above > depth) & nodes).any():
            row, column = np.argwhere(crossing)[0]
            raise ValueError(
                f"ceiling must not lie below the support, but at depth {depth[row, column]:g} of the support it is "
                f"at depth {above[row, column]:g}"
            )
        window = self.top + part.offset - 1, self.left - 1, nodes
        return _Read(
            nodes,
            depth,
            above,
            membrane.arms("x", *window),
            membrane.arms("y", *window),
            membrane.node_area * laid_out("foundation")[1:-1, 1:-1] if membrane.has("foundation") else 0.0,
            membrane.frame_depths(*window),
        )

    @property
    def rows_of_nodes(self) -> tuple[int, int]:
        """The rows [first, last) of the membrane's lattice that vectors hold the nodes of."""
        first = self.top + self.part.offset
        return first, first + self.numbering.rows

    def _read_load(self) -> Vector:
        """Return the force on each node."""
        nodes = np.zeros((self.numbering.rows, self.membrane.shape[1]), dtype=np.bool_)
        nodes[:, self.columns] = self.numbering.mask
        load = self.membrane.rows_of("load", *self.rows_of_nodes, nodes)
        return self.membrane.node_area * self.numbering.to_vector(load[:, self.columns])

    def _stencil(self, numbering: Numbering, read: _Read) -> PartOfStencil:
        """Return the stiffness of the process's nodes."""
        across, along = (self._one_if_equal(arms) for arms in (read.across, read.along))
        stencil = PartOfStencil.on(numbering, across, along, read.ground)
        stencil.grounded = self.membrane.has("foundation")  # though no arm may end on the ground in these rows
        own = float(stencil.diagonal()[self.own].max())
        stencil.largest_of_all = max(self.part.everyones([own]))
        return stencil

    def _one_if_equal(self, arms: float | Grid) -> float | Grid:
        """Return the number that all arms of all processes have, if they do."""
        if isinstance(arms, float):
            return arms
        used = arms > 0
        found = self.part.everyones([(float(arms.min(where=used, initial=np.inf)), float(arms.max()))])
        least, most = min(least for least, _ in found), max(most for _, most in found)
        return most if least == most else arms

    def _frame_depths(self, frame: float | Grid) -> tuple[float, float, float | Grid]:
        """Return the mean depth of the frame where it holds arms, how far it leaves that at most, and all depths."""
        if isinstance(frame, float):
            return frame, 0.0, frame
        part, found = self.part, []
        for low, high in part.blocks:
            # The ring's rows are counted with those beside them.
            first = low - (low + part.offset == 1)
            last = high + (high + part.offset == part.count + 1)
            depths = frame[first:last][~np.isnan(frame[first:last])]
            ends = (float(depths.min(initial=np.inf)), float(depths.max(initial=-np.inf)))
            found.append((float(depths.sum()), float(depths.size), *ends))
        sums, counts, least, most = zip(*part.everyones(found), strict=True)
        lowest, highest = min(least), max(most)
        if lowest == highest:
            return lowest, 0.0, lowest
        mean = float(sum(sums)) / float(sum(counts))
        return mean, max(highest - mean, mean - lowest), np.where(np.isnan(frame), mean, frame)

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

    def _barrier(self, shape: tuple[int, int], ends: tuple[Ends, Ends]) -> BarrierOfRows:
        """Return what `contactqp.problem.barrier.find_barrier` finds, where all arms are equal a parabola."""
        stencil, layout = self.stencil, self.stencil.layout
        arms = tuple(float(arms) if arms.ndim == 0 else 1.0 for arms in (stencil.horizontal, stencil.vertical))
        found = parabolas(shape, (arms[0], arms[1]), (True, True), ends, layout)
        own = [PartOfParabola(whole, self.part, layout) for whole in found if 0 < whole.least_s < np.inf]
        if self._plain:
            return min(own, key=lambda candidate: candidate.reach)
        free = self._arms(stencil, layout.with_kind(FREE))
        with Team(self._threads) as team:
            return found_barrier(stencil, free, self.own, own, team)

    @property
    def _plain(self) -> bool:
        """Whether all arms are equal in each direction, and there is no foundation."""
        return self.stencil.even and not self.membrane.has("foundation")

    def _scale(self, depth: Vector) -> float | None:
        """Return the length that tolerances are measured by, see `contactqp.models.base.length_scale`."""
        ceiling = self._ceiling
        v, count, datum = self.barrier.v, self.total(np.ones(self.load.size)), self.datum
        # As `Barrier.mean_deflection`, for a load and for suction, at the frame's mean height.
        load = self.load - self.springs * datum if self.membrane.has("foundation") else self.load
        pushes = (np.maximum(sign * load, 0.0) / self.barrier.least_s for sign in (1.0, -1.0))
        mean, suction = (self.total(push * v) / count for push in pushes)
        there = None if ceiling is None else any(self.part.everyones([bool(np.isfinite(ceiling).any())]))
        above = datum - ceiling if ceiling is not None and there else None

        def average(values: Vector) -> float:
            return self.total(values) / count

        return length_scale(mean, suction, v, depth - datum, above, self.relief, average, self.least)

    @property
    def springs(self) -> Vector:
        """Stiffness of the foundation at each node (force per length)."""
        stencil = self.stencil
        return stencil.numbering.to_vector(np.broadcast_to(stencil.ground, stencil.mask.shape))

    def _lattice(self, scaled: ContactProblem) -> Arms:
        stencil, layout = scaled.stencil, scaled.layout
        assert stencil is not None
        kinds = layout.kinds
        if not all(self.part.everyones([kinds is None])):
            kinds = np.full(layout.mask.shape, SUPPORTED, dtype=np.uint8) if kinds is None else kinds
        return self._arms(stencil, Layout(layout.mask, kinds))

    def _arms(self, stencil: LatticeStiffness, layout: Layout) -> Arms:
        """Return the arms of a stencil of this process's nodes, which are laid out so."""
        if self._plain:
            return Arms(layout, float(stencil.horizontal), float(stencil.vertical), part=self.part)
        rows, columns = layout.mask.shape
        ground = np.array(np.broadcast_to(stencil.ground, layout.mask.shape))
        if stencil.even:
            return Arms(layout, float(stencil.horizontal), float(stencil.vertical), ground, part=self.part)
        across = np.broadcast_to(stencil.horizontal, (rows, columns + 1))
        along = np.broadcast_to(stencil.vertical, (rows + 1, columns))
        return Arms(layout, *joined_to_nodes(layout, across, along), ground, part=self.part)

    def scaled(self) -> ScaledByRows:
        """Return the dimensionless problem, as the multigrid starts from it."""
        return ScaledByRows(self)

    def useful(self, gap: Vector) -> Vector | None:
        """Return a gap to start from, dimensionless; None where a cold start is nearer to the solution by its energy.

        See `contactqp.solving.starts.useful_start`.

        Parameters
        ----------
        gap : array, shape (n,)
            Length.
        """
        scaled, units = self.problem.scaled()
        with np.errstate(over="ignore", invalid="ignore"):
            start = units.dimensionless(gap)
            admissible = scaled.project(start)
            energy = self.total((0.5 * scaled.stiffness.matvec(admissible) + scaled.q) * admissible)
        # Neither nan nor an overflow is <= 0.
        return start if energy <= 0 and np.isfinite(energy) else None

    def measures(self, gap: Vector, threads: int) -> MeasuresOfRows:
        """Return what all processes together measure of a gap (length), of which each holds its rows."""
        if isinstance(self.barrier, PartOfBarrier):
            return MeasuresByRows(self.problem, self.stencil, self.barrier, gap, self.part, self._rows_of_nodes)
        return LatticeMeasures(self.problem, self.barrier, gap, self.part, threads=threads)

    def heights(self, below: Vector) -> Grid:
        """Lay depths of the nodes out on the array of the rows, with the frame's where it holds arms."""
        grid = self.stencil.numbering.to_grid(below, ring=1)
        return np.where(np.pad(self.stencil.mask, 1), grid, self._frame)

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
            for arms in (self.stencil.horizontal, self.stencil.vertical, self.stencil.ground):
                rows = slice(block[0] - 1, block[1] - 1)
                data.update(np.ascontiguousarray(arms if arms.ndim == 0 else arms[rows]).tobytes())
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
