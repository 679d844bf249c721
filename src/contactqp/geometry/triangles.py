"""TriangleMesh: triangles between points in plan, checked, with their edges, their boundary and groups by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, nearest, read_only, real_array
from ..foundation.loading import load_modules
from ..foundation.text import counted
from .scikit_fem import halved_where

Numbers = NDArray[np.int64]

_FLAT = 8 * np.finfo(float).eps
"""A triangle of which twice the area is no more than this part of its longest side's square has none but rounding."""


class TriangleMesh:
    """Triangles between points in plan.

    Parameters
    ----------
    points : array, shape (points, 2)
        Plan coordinates x, y (length).
    triangles : array of int, shape (triangles, 3)
        Numbers of the corners of each, in either sense of rotation.
    groups : mapping of str to array of int, optional
        Points, shape (k,), edges, shape (k, 2), or triangles, shape (k, 3), by name.

    Raises
    ------
    TypeError, ValueError
        If numbers or coordinates are none, a triangle has no area, a point belongs to no triangle, or an edge to more
        than two; the message names the first.

    Examples
    --------
    >>> square = TriangleMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> square.areas, square.edges.tolist()
    (array([0.5, 0.5]), [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]])
    >>> square.boundary
    array([0, 2, 3, 4])
    """

    def __init__(self, points: ArrayLike, triangles: ArrayLike, groups: Mapping[str, ArrayLike] | None = None) -> None:
        self.points: Vector = read_only(_checked_points(points))
        self.triangles: Numbers = read_only(self._checked_corners(triangles))
        self.areas: Vector = read_only(self._checked_areas())
        self._refuse_isolated_points()
        self._refuse_folds()
        groups = {} if groups is None else groups
        self.groups: Mapping[str, Numbers] = MappingProxyType(
            {str(name): read_only(self._checked_group(str(name), cells)) for name, cells in groups.items()}
        )

    @cached_property
    def edges(self) -> Numbers:
        """Numbers of the two points of each edge, the lower first, shape (edges, 2), in the order of these."""
        count = len(self.points)
        return read_only(np.column_stack(np.divmod(self._edge_keys[0], count)))

    @cached_property
    def triangle_edges(self) -> Numbers:
        """Number of the edge across each corner of each triangle, shape (triangles, 3)."""
        return read_only(self._edge_keys[1].reshape(-1, 3))

    @cached_property
    def _edge_keys(self) -> tuple[Numbers, Numbers]:
        ends = np.sort(self.triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
        keys, which = np.unique(ends[:, 0] * len(self.points) + ends[:, 1], return_inverse=True)
        return keys, which.ravel()

    @cached_property
    def boundary(self) -> Numbers:
        """Numbers of the edges that belong to one triangle only."""
        return read_only(np.flatnonzero(np.bincount(self.triangle_edges.ravel()) == 1))

    @cached_property
    def middles(self) -> Vector:
        """Centroids of the triangles, shape (triangles, 2), length."""
        return np.asarray(self.points[self.triangles].mean(axis=1))

    @cached_property
    def longest_sides(self) -> Vector:
        """Length of the longest side of each triangle, shape (triangles,)."""
        return np.asarray(np.sqrt((self._across**2).sum(axis=2).max(axis=1)))

    @cached_property
    def _across(self) -> NDArray[np.float64]:
        """The side across each corner as a vector, in the sense of the corners, shape (triangles, 3, 2)."""
        corners = self.points[self.triangles]
        return corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]

    def gradients(self, heights: Vector) -> NDArray[np.float64]:
        """Return the gradient in each triangle of heights at the points, linear between them, shape (triangles, 2).

        Examples
        --------
        >>> mesh = TriangleMesh([[0, 0], [2, 0], [0, 1]], [[0, 1, 2]])
        >>> mesh.gradients(np.array([5.0, 7.0, 8.0]))
        array([[1., 3.]])
        """
        side = self._across
        twice = side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0]
        corner = heights[self.triangles]
        # From the first corner on: a common height costs no digits.
        rise = corner - corner[:, :1]
        across = np.stack([-side[:, :, 1], side[:, :, 0]], axis=2)
        return np.asarray(np.einsum("tk,tkd->td", rise, across) / twice[:, None])

    def points_of(self, names: Iterable[str]) -> Numbers:
        """Return the numbers of the points of some groups, ascending.

        Raises
        ------
        ValueError
            If there is no such group.
        """
        found = []
        for name in names:
            if name not in self.groups:
                known = ", ".join(map(repr, self.groups)) or "none"
                raise ValueError(f"the mesh has no group {name!r}{nearest(name, self.groups)}; it has {known}")
            found.append(self.groups[name].ravel())
        return np.unique(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)

    def halved(self, chosen: Mask) -> Halving:
        """Return the mesh in which some triangles are split into four, and neighbours so that all sides meet.

        Parameters
        ----------
        chosen : array of bool, shape (triangles,)

        Returns
        -------
        Halving
            The old points keep their numbers; each new one halves an edge.

        Raises
        ------
        ImportError
            If scikit-fem is not installed.
        """
        points, triangles = halved_where(self.points, self.triangles, chosen)
        load_modules("scipy.spatial")
        from scipy.spatial import KDTree

        old = len(self.points)
        middles = self.points[self.edges].mean(axis=1)
        _, edge = KDTree(middles, balanced_tree=False, compact_nodes=False).query(points[old:])
        ends = np.concatenate([np.repeat(np.arange(old), 2).reshape(-1, 2), self.edges[edge]])
        return Halving(TriangleMesh(points, triangles, self._halved_groups(ends, triangles)), ends, self, edge)

    def _halved_groups(self, ends: Numbers, triangles: Numbers) -> dict[str, Numbers]:
        """Return the groups of a finer mesh: edges and triangles in parts."""
        old, count = len(self.points), len(ends)
        if not self.groups:
            return {}
        new = {(int(a), int(b)): old + k for k, (a, b) in enumerate(ends[old:])}
        groups: dict[str, Numbers] = {}
        parent: Numbers | None = None
        for name, cells in self.groups.items():
            if cells.ndim == 1:
                groups[name] = cells
            elif cells.shape[1] == 2:
                parts = [
                    part
                    for a, b in np.sort(cells, axis=1).tolist()
                    for part in ([(a, new[a, b]), (new[a, b], b)] if (a, b) in new else [(a, b)])
                ]
                groups[name] = np.array(parts, dtype=np.int64).reshape(-1, 2)
            else:
                if parent is None:
                    parent = parents_of(triangles, ends, self.triangles, count)
                chosen = np.isin(_keys(self.triangles, count), _keys(cells, count))
                groups[name] = triangles[chosen[parent]]
        return groups

    def _checked_corners(self, value: ArrayLike) -> Numbers:
        triangles, points = np.array(value), len(self.points)
        if triangles.ndim != 2 or triangles.shape[1] != 3:
            raise ValueError(f"triangles must have shape (triangles, 3), got {triangles.shape}")
        if not len(triangles):
            raise ValueError("triangles must hold one or more, got shape (0, 3)")
        if triangles.dtype.kind not in "iu":
            raise TypeError(f"triangles must hold point numbers, integers, got dtype {triangles.dtype}")
        outside = np.flatnonzero(((triangles < 0) | (triangles >= points)).any(axis=1))
        if outside.size:
            told = _named(triangles, int(outside[0]))
            raise ValueError(f"{told}: there are {points} points, numbered 0 to {points - 1}")
        return triangles.astype(np.int64)

    def _checked_areas(self) -> Vector:
        side = self._across
        with np.errstate(over="ignore", invalid="ignore"):
            twice = np.abs(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0])
            flat = np.flatnonzero(twice <= _FLAT * (side**2).sum(axis=2).max(axis=1))
        if flat.size:
            told = _named(self.triangles, int(flat[0]))
            more = f" ({flat.size} such triangles)" if flat.size > 1 else ""
            raise ValueError(f"{told} has no area: its corners lie in a line{more}; leave it out, or move a corner")
        if not np.isfinite(twice).all():
            raise ValueError("the triangles' areas are too large for double precision; take another unit of length")
        return np.asarray(twice / 2)

    def _refuse_isolated_points(self) -> None:
        alone = np.flatnonzero(np.bincount(self.triangles.ravel(), minlength=len(self.points)) == 0)
        if alone.size:
            x, y = self.points[alone[0]]
            others = f" and {alone.size - 1} more" if alone.size > 1 else ""
            raise ValueError(f"point {alone[0]} (x={x:g}, y={y:g}){others} belongs to no triangle; leave it out")

    def _refuse_folds(self) -> None:
        several = np.flatnonzero(np.bincount(self.triangle_edges.ravel()) > 2)
        if several.size:
            one, other = self.edges[several[0]]
            of = np.flatnonzero((self.triangle_edges == several[0]).any(axis=1))
            told = ", ".join(f"triangles[{k}]" for k in of[:3])
            raise ValueError(
                f"the edge between the points {one} and {other} belongs to {counted(of.size, 'triangle')} ({told}); in "
                "plan it has one on either side"
            )

    def _checked_group(self, name: str, cells: ArrayLike) -> Numbers:
        group = np.array(cells)
        if group.ndim not in (1, 2) or (group.ndim == 2 and group.shape[1] not in (2, 3)):
            raise ValueError(
                f"groups[{name!r}] must hold points, shape (k,), edges, (k, 2), or triangles, (k, 3), got {group.shape}"
            )
        if group.size and group.dtype.kind not in "iu":
            raise TypeError(f"groups[{name!r}] must hold point numbers, integers, got dtype {group.dtype}")
        outside = group[(group < 0) | (group >= len(self.points))]
        if outside.size:
            raise ValueError(
                f"groups[{name!r}] names point {outside[0]}, but there are {len(self.points)} points, numbered 0 to "
                f"{len(self.points) - 1}"
            )
        return group.astype(np.int64)


class Halving(NamedTuple):
    """A mesh, and the coarser one that it was made of.

    Attributes
    ----------
    mesh : TriangleMesh
        The finer one, whose first points are those of the coarser one.
    ends : array of int, shape (points of the finer one, 2)
        Between which two points of the coarser one each lies midway; twice itself for an old point.
    coarser : TriangleMesh
    halved : array of int
        Numbers of the coarser one's edges that the new points halve, in their order.
    """

    mesh: TriangleMesh
    ends: Numbers
    coarser: TriangleMesh
    halved: Numbers

    @property
    def parents(self) -> Numbers:
        """Number of the coarser one's triangle that each triangle lies in, shape (triangles of the finer one,)."""
        return parents_of(self.mesh.triangles, self.ends, self.coarser.triangles, len(self.ends))

    def between(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values at the coarser one's points, linear between them, at all points of the finer one.

        Examples
        --------
        >>> coarse = TriangleMesh([[0, 0], [2, 0], [0, 1]], [[0, 1, 2]])
        >>> coarse.halved(np.array([True])).between(np.array([0.0, 1.0, 3.0]))[:4]
        array([0. , 1. , 3. , 0.5])
        """
        return np.asarray(values[self.ends].mean(axis=1))


def parents_of(triangles: Numbers, ends: Numbers, coarser: Numbers, points: int) -> Numbers:
    """Return the number of the coarser triangle that each finer one lies in.

    The points between which a part's corners lie are the corners of the triangle that it is a part of.

    Parameters
    ----------
    triangles : array of int, shape (k, 3)
        The finer ones.
    ends : array of int, shape (points, 2)
        See `Halving`.
    coarser : array of int, shape (m, 3)
    points : int
        More than the largest number among the coarser triangles' corners.
    """
    among = ends[triangles].reshape(-1, 6)
    low, high = among.min(axis=1), among.max(axis=1)
    middle = np.where((among != low[:, None]) & (among != high[:, None]), among, -1).max(axis=1)
    keys = _keys(coarser, points)
    order = np.argsort(keys)
    return np.asarray(order[np.searchsorted(keys[order], _keys(np.column_stack([low, middle, high]), points))])


def _keys(triangles: Numbers, points: int) -> Numbers:
    """Return a number for each triangle by its corners, in whichever order they stand."""
    low, middle, high = np.sort(triangles, axis=1).T
    return np.asarray((low * points + middle) * points + high)


def _checked_points(value: ArrayLike) -> Vector:
    points = real_array(value, "points")
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points must have shape (points, 2), got {points.shape}")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        x, y = points[bad[0]]
        raise ValueError(f"points must be finite, but point {bad[0]} is ({x:g}, {y:g})")
    return points


def _named(triangles: NDArray[Any], k: int) -> str:
    return f"triangles[{k}] = ({', '.join(map(str, triangles[k].tolist()))})"
