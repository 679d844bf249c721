"""GraphModel: points anywhere in plan, some of them fixed, and what joins each two of them."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, read_only
from ..foundation.loading import load_modules
from ..geometry.fields import sample_points
from .base import ContactModel, Coordinate
from .cable_net_arguments import Numbers
from .sensitive import FrameHeights, Values
from .suspicions import Joints

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class GraphModel(ContactModel):
    """Points in plan, fixed ones and nodes, joined by edges that pull their ends together.

    Base of `CableNet` and `MeshMembrane`. An edge of stiffness k pulls its ends together by k times their difference in
    height: G has the sum of the stiffnesses of a node's edges on its diagonal, and minus that of the edge between two
    nodes beside it. Vectors are in the order of the nodes' numbers among the points.

    A subclass sets `positions`, calls ``self._fix(mask)`` and, once its load and its heights are known,
    ``self._hold(heights, name)``.

    Attributes
    ----------
    positions : array, shape (points, 2)
        Plan coordinates x, y of all points (length).
    free, fixed : array of int
        Numbers of the nodes, shape (n,), and of the fixed points, ascending.
    fixed_height : array
        Heights of the fixed points, positive as those of the support (length).
    """

    positions: Vector
    free: Numbers
    fixed: Numbers
    fixed_height: Vector
    _number: Numbers
    """Which node each point is, -1 for fixed ones."""
    _fixed_depth: Vector
    _frame: Vector
    """Depths of the fixed points that an edge joins to a node (length)."""

    @property
    @abstractmethod
    def edges(self) -> Numbers:
        """Numbers of the two points that each edge joins, shape (edges, 2)."""

    @property
    @abstractmethod
    def edge_stiffness(self) -> Vector:
        """Force per difference in height of an edge's ends, shape (edges,), force per length."""

    def _fix(self, is_fixed: Mask, noun: str) -> None:
        """Tell fixed points from nodes, and refuse parts without a fixed one; ``noun`` is what the parts are of."""
        self.fixed = read_only(np.flatnonzero(is_fixed))
        self.free = read_only(np.flatnonzero(~is_fixed))
        self._number = np.full(len(self.positions), -1, dtype=np.int64)
        self._number[self.free] = np.arange(self.free.size)
        self._refuse_floating_parts(noun)

    def _hold(self, heights: Any, name: str) -> None:
        """Put the fixed points at heights, given as the argument of that name."""
        given = self._in_own_sense(self.without_unit(heights, name))
        values = sample_points(self.positions, self.fixed, given, name, self._describe_fixed)
        self.fixed_height = read_only(np.array(values))
        self._fixed_depth = read_only(-self.fixed_height) if self.upwards else self.fixed_height
        self._frame = self._fixed_depth[np.isin(self.fixed, self.edges[self._holding].ravel())]
        self._datum = float(self._frame.mean())

    def at_nodes(self, field: Any, name: str, *, allow_inf: bool = False, absent: float | None = None) -> Vector:
        """See `ContactModel.at_nodes`; an array has an entry for each node, or for each point."""
        field, absent = self.without_unit(field, name), self._no_support if absent is None else absent
        values = sample_points(
            self.positions, self.free, field, name, self.describe, allow_inf=allow_inf, absent=absent
        )
        return read_only(np.array(values))

    @property
    def node_x(self) -> Vector:
        """Abscissa of each node, shape (n,), length."""
        return np.asarray(self.positions[self.free, 0])

    @property
    def node_y(self) -> Vector:
        """Ordinate of each node in plan, shape (n,), length."""
        return np.asarray(self.positions[self.free, 1])

    def describe(self, node: int) -> str:
        """Name a node by its number, that of its point, and its coordinates: ``node 3 (point 7, x=0.5, y=1)``."""
        point = int(self.free[node])
        return f"node {node} (point {point}, x={self.positions[point, 0]:g}, y={self.positions[point, 1]:g})"

    def _describe_fixed(self, k: int) -> str:
        x, y = self.positions[self.fixed[k]]
        return f"point {self.fixed[k]} (x={x:g}, y={y:g})"

    def point_heights(self, heights: Vector) -> Vector:
        """Return heights of all points, shape (points,), from those of the nodes; the fixed ones have their own."""
        return self._everywhere(heights, self.fixed_height)

    def _everywhere(self, at_nodes: Vector, at_fixed: Vector) -> Vector:
        everywhere = np.empty(len(self.positions))
        everywhere[self.free], everywhere[self.fixed] = at_nodes, at_fixed
        return everywhere

    def free_boundary(self, contact: Mask) -> NDArray[np.float64]:
        """Return the middles of the edges that join a node in contact to one that is not, shape (k, 2), length."""
        ends = self._number[self.edges]
        crossing = (ends >= 0).all(axis=1) & (contact[ends[:, 0]] != contact[ends[:, 1]])
        middles: NDArray[np.float64] = self.positions[self.edges[crossing]].mean(axis=1)
        return middles

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height in plan of all points, fixed ones included (length)."""
        width, height = np.ptp(self.positions, axis=0)
        return float(width), float(height)

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """Plan coordinates of the nodes (length), and their numbers among all points."""
        point = Coordinate("node", np.array(self.free), {"long_name": "number among all points"})
        return super().coordinates | {"point": point}

    @cached_property
    def _holding(self) -> Mask:
        """Edges with a node at one end or both."""
        return np.asarray((self._number[self.edges] >= 0).any(axis=1))

    def assemble_stiffness(self) -> csr_array:
        """Return G: the edges' stiffnesses summed on the diagonal, and minus those between nodes beside it."""
        load_modules("scipy.sparse")
        from scipy import sparse

        ends = self._number[self.edges]
        between = (ends >= 0).all(axis=1) & (self.edge_stiffness != 0)
        one, other = ends[between].T
        stiffness = self.edge_stiffness[between]
        with np.errstate(over="ignore"):
            diagonal = self._sum_at_nodes(np.repeat(self.edge_stiffness, 2))
            if self.nodal_foundation is not None:
                diagonal = diagonal + self.nodal_foundation
        nodes = np.arange(self.size)
        return sparse.coo_array(
            (
                np.concatenate([diagonal, -stiffness, -stiffness]),
                (np.concatenate([nodes, one, other]), np.concatenate([nodes, other, one])),
            ),
            shape=(self.size, self.size),
        ).tocsr()

    def pull(self, depths: Vector) -> Vector:
        """Return the force with which the edges pull each node upwards; see `ContactModel.pull`."""
        force = self.edge_stiffness * self._rises(depths)
        pulled = self._sum_at_nodes(np.column_stack([force, -force]).ravel())
        return pulled if self.nodal_foundation is None else pulled + self.nodal_foundation * depths

    @property
    def heights_of_frame(self) -> FrameHeights:
        """By ``fixed_height``, shape (fixed points,)."""
        holds = np.isin(self.fixed, self.edges[self._holding].ravel())
        one, other = self.edges.T

        def force(depths: Values) -> Vector:
            everywhere = self._everywhere(np.zeros(self.size), depths)
            pulled = self.edge_stiffness * (everywhere[one] - everywhere[other])
            return -self._sum_at_nodes(np.column_stack([pulled, -pulled]).ravel())

        def share(weights: Vector) -> Values:
            everywhere = self._everywhere(weights, np.zeros(self.fixed.size))
            found = np.zeros(len(self.positions))
            np.add.at(found, one, self.edge_stiffness * everywhere[other])
            np.add.at(found, other, self.edge_stiffness * everywhere[one])
            return found[self.fixed]

        return FrameHeights("fixed_height", holds / holds.sum(), force, share)

    def _rises(self, heights: Vector) -> Vector:
        """Return for each edge the ordinate of its first end less that of its second one."""
        everywhere = self._everywhere(heights, self._fixed_depth)
        return np.asarray(everywhere[self.edges[:, 0]] - everywhere[self.edges[:, 1]])

    def _sum_at_nodes(self, values: Vector) -> Vector:
        """Return for each node the sum of the values at the edges' ends there, pair by pair.

        ``values`` has those of each edge's two ends in turn.
        """
        order, pair_start, node_start = self._ends_by_node
        pairs = np.add.reduceat(values[order], pair_start)
        return np.asarray(np.add.reduceat(pairs, node_start))

    @cached_property
    def _ends_by_node(self) -> tuple[Numbers, Numbers, Numbers]:
        """The edges' ends at nodes by node, where pairs of them start, and where the nodes' pairs start."""
        node = self._number[self.edges].ravel()
        order = np.argsort(node, kind="stable")[np.count_nonzero(node < 0) :]
        count = np.bincount(node[order], minlength=self.size)
        start = np.cumsum(count) - count
        place = np.arange(order.size) - np.repeat(start, count)
        pairs = (count + 1) // 2
        return order, np.flatnonzero(place % 2 == 0), np.cumsum(pairs) - pairs

    def _frame_relief(self) -> float:
        return float(np.abs(self._frame - self._datum).max())

    def _reach(self) -> float:
        return self._reach_of(self._forces_at(self._datum + self._frame_relief()))

    def _reach_upwards(self) -> float:
        return self._reach_of(-self._forces_at(self._datum - self._frame_relief()))

    def _reach_of(self, force: Vector) -> float:
        """Return a bound of how far forces, positive downwards, press any node below a frame at height zero.

        The deflection of any node is at most the whole load times the node's own softness, and that is at most the
        softness of a path to a fixed point: to take the other edges away makes the whole softer (Rayleigh). That is so
        if no edge pushes its ends apart; else nothing is known.
        """
        if self.edge_stiffness.min() < 0:
            return np.inf
        load_modules("scipy.sparse", "scipy.sparse.csgraph")
        from scipy import sparse
        from scipy.sparse import csgraph

        points = len(self.positions)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            graph = sparse.coo_array((1 / self.edge_stiffness, tuple(self.edges.T)), shape=(points, points))
            softness = csgraph.dijkstra(graph.tocsr(), directed=False, indices=self.fixed, min_only=True)
            reach = float(np.maximum(force, 0.0).sum() * softness[self.free].max())
        return reach if np.isfinite(reach) else np.inf

    def _joints(self) -> Joints:
        """Return the support at the fixed points as high as at the nodes beside them, and its steps for its bends."""
        node = self._number[self.edges]
        depth = self._everywhere(self.depth, self._fixed_depth)
        depth[np.isinf(depth)] = np.nan
        fall = depth[self.edges[:, 1]] - depth[self.edges[:, 0]]
        first, second = (node[:, 0] < 0) & (node[:, 1] >= 0), (node[:, 0] >= 0) & (node[:, 1] < 0)
        above, steps = np.concatenate([-fall[first], fall[second]]), np.abs(fall[(node >= 0).all(axis=1)])
        return Joints(
            np.concatenate([node[first, 1], node[second, 0]]),
            np.where(np.isnan(above), -np.inf, above),
            steps[~np.isnan(steps)],
        )

    def _refuse_floating_parts(self, noun: str) -> None:
        load_modules("scipy.sparse", "scipy.sparse.csgraph")
        from scipy import sparse
        from scipy.sparse import csgraph

        points = len(self.positions)
        ones = np.ones(len(self.edges))
        count, part = csgraph.connected_components(
            sparse.coo_array((ones, tuple(self.edges.T)), shape=(points, points)), directed=False
        )
        loose = np.bincount(part[self.fixed], minlength=count) == 0
        if loose.any():
            point = int(np.flatnonzero(loose[part])[0])
            x, y = self.positions[point]
            raise ValueError(
                f"{int(loose.sum())} part(s) of the {noun} have no fixed point, among them that of point {point} "
                f"(x={x:g}, y={y:g}); fix a point of each, or join them to the rest"
            )
