"""Cable net: tensioned segments between points anywhere in plan, in the vicinity of a rigid support."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.stencil import Stencil
from ..foundation.checks import Vector, boolean, positive_number, read_only, refuse_non_finite
from ..foundation.keywords import known_by_name
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames
from ..foundation.text import counted
from ..foundation.units import checked_units, plain
from ..geometry.fields import FieldLike, Rows, checked_rows, frame_heights, sample
from ..geometry.lattice import Lattice
from ..profiles.analytic import Profile
from .base import elevations_of
from .cable_net_arguments import (
    Numbers,
    checked_positions,
    checked_segments,
    each_positive,
    fixed_mask,
    name_segment,
    refuse_overflow,
)
from .on_graph import GraphModel
from .reach import reach_on_lattice
from .sensitive import Resistance


class CableNet(GraphModel):
    r"""A net of tensioned segments between points, any graph, over a smooth, rigid support.

    The horizontal tension S of a segment of plan length ℓ is constant, slopes are small, and there is no friction: a
    segment pulls its ends together by S/ℓ, its force density, times their difference in height. So G has the sum of the
    force densities of a node's segments on its diagonal, and minus that of the segment between two nodes beside it;
    R = Gω + q with q = P + b - Gf as for a membrane. Points are either fixed, as a frame is, or nodes, which are the
    unknowns; vectors are in the order of the nodes' numbers among the points.

    Nodes stay where they are in plan: that takes horizontal forces in balance, `plan_imbalance` zero, or guides that
    supply the rest. `plan_in_equilibrium` moves nodes to where force densities are in balance, by Schek, *The force
    density method for form finding and computation of general networks*, Comput. Methods Appl. Mech. Engrg. 3 (1974).

    Parameters
    ----------
    positions : array, shape (points, 2)
        Plan coordinates x, y of all points (length).
    segments : array of int, shape (segments, 2)
        Numbers of the two points that each segment joins. One between two fixed points has no effect.
    tension : float or array, shape (segments,)
        S, horizontal force in each segment, > 0. Give ``tension`` or ``force_density``.
    force_density : float or array, shape (segments,)
        S/ℓ, force per length, > 0.
    load : number, array or function of (x, y)
        Active force P on each node, positive downwards (force). An array has an entry for each node, or for each point.
    support : number, array or function of (x, y)
        Height f of the rigid profile at the nodes (length). Heights are positive downwards, unless ``upwards``; ``inf``
        where there is no support. One far beyond the load's reach counts as none, see `unreachable`. The segments
        themselves touch nothing.
    fixed : array of int or of bool
        Numbers of the points that are fixed, or a mask of shape (points,).
    fixed_height : number, array or function of (x, y)
        Heights of the fixed points, positive as those of the support (length). An array has an entry for each fixed
        point in the order of their numbers, or for each point.
    upwards : bool
        Whether heights are elevations, positive upwards: those of support and fixed points as they are given, and the
        deflection and all pictures and files; ``-inf`` where there is no support. A load stays positive downwards, and
        a profile of `contactqp.profiles` a surface of depths.
    ceiling : number, array or function of (x, y), optional
        Height of a rigid surface above the nodes (length), given and positive as the support is, and not below it;
        ``-inf`` (``inf``) where there is none.
    foundation : number, array or function of (x, y), optional
        Stiffness k ≥ 0 of a spring at each node that pulls it to height zero (force per length).
    units : str or mapping, optional
        As for `Membrane`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range, a segment has no length or is given twice, or a part of the
        net has no fixed point; the message names it.

    Attributes
    ----------
    positions, segments : array
        As given, read-only.
    length, tension, force_density : array, shape (segments,)
        ℓ, S and S/ℓ.
    free, fixed : array of int
        Numbers of the nodes, shape (n,), and of the fixed points, ascending.
    load : array, shape (n,)
        P (force).

    Examples
    --------
    Four segments of tension 2 hold a node; it comes down on a support 0.1 below their plane:

    >>> import contactqp as cq
    >>> net = cq.CableNet(
    ...     [[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]],
    ...     [[0, 1], [0, 2], [0, 3], [0, 4]],
    ...     tension=2.0,
    ...     load=1.0,
    ...     support=0.1,
    ...     fixed=[1, 2, 3, 4],
    ... )
    >>> net
    CableNet(1 node, 4 segments, 4 fixed points, load=1, support=0.1)
    >>> cq.solve(net).reaction.round(12)
    array([0.2])
    """

    @known_by_name
    def __init__(
        self,
        positions: ArrayLike,
        segments: ArrayLike,
        tension: ArrayLike | None = None,
        *,
        force_density: ArrayLike | None = None,
        load: FieldLike,
        support: FieldLike,
        fixed: ArrayLike,
        fixed_height: FieldLike = 0.0,
        upwards: bool = False,
        ceiling: FieldLike | None = None,
        foundation: FieldLike | None = None,
        units: UnitNames | None = None,
    ) -> None:
        self.unit_names = names = checked_units(units)
        positions = plain(positions, "positions", "length", names)
        tension = plain(tension, "tension", "force", names)
        force_density = plain(force_density, "force_density", "force per length", names)
        self.upwards = boolean(upwards, "upwards")
        self.positions: Vector = read_only(checked_positions(positions))
        self.segments: Numbers = read_only(checked_segments(segments, len(self.positions)))
        self.length: Vector = read_only(self._lengths())
        if (tension is None) == (force_density is None):
            raise ValueError("give either tension or force_density" + ("" if tension is None else ", not both"))
        if force_density is None:
            self.tension: Vector = read_only(each_positive(tension, len(self.segments), "tension"))
            with np.errstate(over="ignore", under="ignore"):
                self.force_density: Vector = read_only(self.tension / self.length)
        else:
            self.force_density = read_only(each_positive(force_density, len(self.segments), "force_density"))
            self.tension = read_only(self.force_density * self.length)
        refuse_overflow(self.force_density)
        self._fix(fixed_mask(fixed, len(self.positions)), "net")
        self.load: Vector = self.at_nodes(load, "load")
        self.support: Vector = self.support_at_nodes(support)
        self.ceiling = self.ceiling_at_nodes(ceiling)
        self.foundation = self.foundation_at_nodes(foundation)
        self._hold(fixed_height, "fixed_height")
        self._warn()

    @classmethod
    def orthogonal(
        cls,
        lattice: Lattice,
        tension: float,
        *,
        load: FieldLike,
        support: FieldLike,
        frame_height: FieldLike = 0.0,
        upwards: bool = False,
        rows: Rows = "up",
        ceiling: FieldLike | None = None,
        foundation: FieldLike | None = None,
        units: UnitNames | None = None,
    ) -> CableNet:
        """Return the net of cables along the rows and columns of a lattice.

        It is the net of orthogonal cables of the paper that contactqp starts from: with S = TΔ and P = pΔ² its G and q
        are those of the `Membrane`, and so is which supports are out of reach. They are so to the bit where S/Δ and P
        are the doubles T and pΔ²; the same supports may be said in elevations, and rows either way.

        Parameters
        ----------
        lattice : Lattice
            The nodes; the frame points beside them become fixed points, numbered after the nodes.
        tension : float
            S, force in each cable, > 0.
        load : number, array, xarray.DataArray or function of (x, y)
            Active force P on each node, positive downwards (force); arrays as for a membrane.
        support : number, array, xarray.DataArray or function of (x, y)
            As for a membrane.
        frame_height : number, array or function of (x, y)
            As for a membrane.
        upwards, rows, units, ceiling
            As for a membrane.
        foundation : number, array, xarray.DataArray or function of (x, y), optional
            Stiffness k ≥ 0 of a spring at each node (force per length).

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong kind, shape or range.

        Examples
        --------
        >>> import contactqp as cq
        >>> lattice = cq.Frame.rectangle(4, 4).lattice(spacing=1.0)
        >>> cq.CableNet.orthogonal(lattice, 1.0, load=1.0, support=0.9)
        CableNet(9 nodes, 24 segments, 12 fixed points, load=1, support=0.9)
        """
        if not isinstance(lattice, Lattice):
            raise TypeError(
                f"lattice must be a Lattice, got {type(lattice).__name__}; "
                "make one with Frame.lattice or Lattice.from_mask"
            )
        if lattice.cuts is not None:
            raise ValueError(
                f"a net of cables ends on the lattice's points; make its lattice without fitted=True: {lattice!r}"
            )
        names = checked_units(units)
        tension = positive_number(plain(tension, "tension", "force", names), "tension")
        load, support = plain(load, "load", "force", names), plain(support, "support", "length", names)
        frame_height, ceiling = (
            plain(height, name, "length", names)
            for height, name in ((frame_height, "frame_height"), (ceiling, "ceiling"))
        )
        stencil = Stencil(lattice.mask, 1.0, 1.0)
        nodes, frame = stencil.padded_mask(), stencil.frame_points()
        number = np.full(nodes.shape, -1, dtype=np.int64)
        number[nodes] = np.arange(lattice.size)
        number[frame] = lattice.size + np.arange(np.count_nonzero(frame))
        rows, absent = checked_rows(rows), -np.inf if boolean(upwards, "upwards") else np.inf
        of_profile = any(isinstance(height, Profile) for height in (support, frame_height, ceiling))
        if upwards:
            support, frame_height, ceiling = map(elevations_of, (support, frame_height, ceiling))
        if ceiling is not None:
            ceiling = sample(lattice, ceiling, "ceiling", allow_inf=True, absent=-absent, rows=rows)
        if foundation is not None:
            foundation = plain(foundation, "foundation", "force per length", names)
            foundation = sample(lattice, foundation, "foundation", rows=rows)
        heights, _ = frame_heights(lattice, stencil.frame_points(), frame_height, rows)
        x, y = lattice.ring_coordinates(*np.nonzero(frame))
        # Rows before columns: a node's forces are then summed as a stencil does, and are the same to the bit.
        segments = np.concatenate(
            [_pairs(number[:, :-1], number[:, 1:], lattice.size), _pairs(number[:-1], number[1:], lattice.size)]
        )
        net = cls(
            np.column_stack([np.concatenate([lattice.node_x, x]), np.concatenate([lattice.node_y, y])]),
            segments,
            force_density=tension / lattice.spacing,
            load=sample(lattice, load, "load", rows=rows),
            support=sample(lattice, support, "support", allow_inf=True, absent=absent, rows=rows),
            fixed=lattice.size + np.arange(x.size),
            fixed_height=0.0 if heights is None else heights[frame],
            upwards=upwards,
            ceiling=ceiling,
            foundation=foundation,
            units=names,
        )
        net._laid_on, net._of_profile = lattice, of_profile
        return net

    @staticmethod
    def plan_in_equilibrium(
        positions: ArrayLike, segments: ArrayLike, force_density: ArrayLike, *, fixed: ArrayLike
    ) -> Vector:
        """Return the positions at which the horizontal forces of all segments are in balance at every node.

        Parameters
        ----------
        positions, segments, force_density, fixed
            See the class. Nodes may be anywhere but on each other, as their positions are what is sought.

        Returns
        -------
        array, shape (points, 2)
            Plan coordinates (length); those of fixed points as they were.

        Raises
        ------
        TypeError, ValueError
            As for the class.

        Examples
        --------
        >>> import contactqp as cq
        >>> corners = [[0, 0], [4, 0], [4, 4], [0, 4]]
        >>> spokes = [[0, 4], [1, 4], [2, 4], [3, 4]]
        >>> cq.CableNet.plan_in_equilibrium([*corners, [1, 1]], spokes, [1, 1, 3, 3], fixed=[0, 1, 2, 3])[4]
        array([2., 3.])
        """
        load_modules("scipy.sparse.linalg")
        from scipy.sparse.linalg import spsolve

        net = CableNet(positions, segments, force_density=force_density, load=0.0, support=0.0, fixed=fixed)
        moved = np.array(net.positions)
        moved[net.free] += spsolve(net.assemble_stiffness().tocsc(), net.plan_imbalance).reshape(-1, 2)
        return moved

    @property
    def plan_imbalance(self) -> Vector:
        """What the segments' horizontal forces on each node add up to, shape (n, 2), force."""
        pulled = self.force_density[:, None] * (
            self.positions[self.segments[:, 1]] - self.positions[self.segments[:, 0]]
        )
        return np.column_stack([self._sum_at_nodes(np.column_stack([along, -along]).ravel()) for along in pulled.T])

    @property
    def edges(self) -> Numbers:
        """The segments."""
        return self.segments

    @property
    def edge_stiffness(self) -> Vector:
        """The segments' force densities."""
        return self.force_density

    def max_slope(self, gap: Vector) -> float:
        """Return the largest slope of a segment that ends on a node (no unit)."""
        rise = np.abs(self._rises(self._below(gap)))
        return float((rise / self.length).max(where=self._holding, initial=0.0))

    @property
    def arm_tensions(self) -> Mapping[str, Resistance]:
        """By ``tension``, shape (segments,)."""

        def pull(depths: Vector, tensions: Vector) -> Vector:
            force = tensions / self.length * self._rises(depths)
            return self._sum_at_nodes(np.column_stack([force, -force]).ravel())

        def share(depths: Vector, weights: Vector) -> Vector:
            first, second = self._everywhere(weights, np.zeros(self.fixed.size))[self.segments].T
            return np.asarray(self._rises(depths) / self.length * (first - second))

        return {"tension": Resistance((len(self.segments),), pull, share)}

    def _reach_of(self, force: Vector) -> float:
        """See `GraphModel._reach_of`; on a lattice it is the membrane's."""
        if self._laid_on is not None:
            # As a membrane decides, so that the same supports count as none.
            stiffness = float(self.force_density[0])
            return reach_on_lattice(self._laid_on.shape, (stiffness, stiffness), force)
        return super()._reach_of(force)

    def _lengths(self) -> Vector:
        first, second = self.positions[self.segments[:, 0]], self.positions[self.segments[:, 1]]
        lengths = np.hypot(*(first - second).T)
        if not lengths.all():
            k = int(np.argmin(lengths))
            x, y = first[k]
            raise ValueError(f"{name_segment(self.segments, k)} has no length: both points lie at ({x:g}, {y:g})")
        refuse_non_finite(lengths, "the segments' length")
        return np.asarray(lengths)

    def __repr__(self) -> str:
        numbers = [(self.size, "node"), (len(self.segments), "segment"), (self.fixed.size, "fixed point")]
        return self._line_of_text(*(counted(number, noun) for number, noun in numbers))


def _pairs(one: Numbers, other: Numbers, nodes: int) -> Numbers:
    """Return the pairs of neighbouring points of which one is a node; those that are no points have number -1."""
    joined = (one >= 0) & (other >= 0) & ((one < nodes) | (other < nodes))
    return np.column_stack([one[joined], other[joined]])
