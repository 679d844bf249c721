"""MeshMembrane: a membrane on a mesh of triangles, linear between their corners, over a rigid support."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..foundation.checks import Mask, Vector, boolean, read_only
from ..foundation.keywords import known_by_name
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames
from ..foundation.text import counted, span_of
from ..foundation.units import checked_units, plain
from ..geometry.fields import FieldLike, is_function
from ..geometry.mesh_sources import of_meshio, of_skfem
from ..geometry.scikit_fem import assembled
from ..geometry.triangles import Halving, Numbers, TriangleMesh
from .base import Coordinate
from .mesh_arguments import FixedLike, fixed_points, tension_of_triangles
from .on_graph import GraphModel

_NOTHING = 8 * np.finfo(float).eps
"""Part of the smaller diagonal entry of its ends up to which an edge's stiffness is what rounding has left of zero."""


class MeshMembrane(GraphModel):
    r"""A membrane on a mesh of triangles, over a smooth, rigid support.

    -∇·(T∇w) + kw = p - ρ, as for a `Membrane`, by linear elements: between nodes i and j G has minus the stiffness of
    their edge, which is T/2 times the cotangents of the two angles across it (Duffin, *Distributed and lumped
    networks*, J. Math. Mech. 8, 1959); nodal forces are P = pA, R = ρA, with A a third of the areas of the node's
    triangles. Stiffness and areas are assembled by scikit-fem (``pip install 'contactqp[mesh]'``). Where the two angles
    are more than 180° together, an edge pushes its ends apart, and G is no M-matrix; it is solved and certified all the
    same.

    On boundaries that are not fixed the membrane is free: no force pulls there, ∂w/∂n = 0.

    Parameters
    ----------
    points : array, shape (points, 2)
        Plan coordinates x, y of all points (length).
    triangles : array of int, shape (triangles, 3)
        Numbers of the corners of each triangle, in either sense of rotation.
    tension : number, array, shape (triangles,), or function of (x, y)
        T, force per length, > 0, one for each triangle. A function is taken at their centroids.
    load : number, array or function of (x, y)
        Active pressure p, positive downwards (force per area). An array has an entry for each node, or for each point.
    support : number, array or function of (x, y)
        Height f of the rigid profile at the nodes (length), given as the load is, or as a profile. Heights are positive
        downwards, unless ``upwards``; ``inf`` (``-inf``) where there is no support.
    fixed : str, list of str, array of int or of bool, or function of (x, y), optional
        The points that are fixed: by the names of groups, their numbers, a mask of shape (points,), or a function that
        is True at them. By default the boundary, all edges that belong to one triangle only.
    frame_height : number, array or function of (x, y)
        Heights of the fixed points, positive as those of the support (length). An array has an entry for each fixed
        point in the order of their numbers, or for each point.
    groups : mapping of str to array of int, optional
        Points, shape (k,), edges, shape (k, 2), or triangles, shape (k, 3), by name.
    upwards : bool
        Whether heights are elevations, positive upwards, as for a `Membrane`.
    ceiling : number, array or function of (x, y), optional
        Height of a rigid surface above the membrane (length), given and positive as the support is, and not below it;
        ``-inf`` (``inf``) where there is none.
    foundation : number, array or function of (x, y), optional
        Stiffness k ≥ 0 of an elastic foundation (Winkler), which pulls the membrane to height zero by kw: force per
        area and length.
    units : str or mapping, optional
        As for `Membrane`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range; if a triangle has no area, a point belongs to no triangle or
        an edge to more than two, or a part of the mesh has no fixed point. The message names it.
    ImportError
        If scikit-fem is not installed.

    Attributes
    ----------
    mesh : TriangleMesh
        With ``points``, ``triangles``, ``areas``, ``edges`` and ``groups``.
    tension : float or array, shape (triangles,)
    node_area : array, shape (n,)

    Examples
    --------
    A square of two by two squares, each cut in two triangles, comes down on a floor:

    >>> import contactqp as cq
    >>> x, y = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0, 2.0])
    >>> corners = np.array([0, 1, 3, 4])  # of the squares: the lower left ones
    >>> lower, upper = corners[:, None] + [0, 1, 4], corners[:, None] + [0, 4, 3]
    >>> triangles, points = np.concatenate([lower, upper]), np.column_stack([x.ravel(), y.ravel()])
    >>> membrane = cq.MeshMembrane(points, triangles, 1.0, load=2.0, support=0.4)
    >>> membrane
    MeshMembrane(1 node, 8 triangles, 8 fixed points, tension=1, load=2, support=0.4)
    >>> cq.solve(membrane).reaction.round(12)  # pA - 4 T f
    array([0.4])
    """

    node_area: Vector
    halving: Halving | None = None
    """How the mesh came out of a coarser one, if `refined` made it."""

    @known_by_name
    def __init__(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        tension: FieldLike,
        *,
        load: FieldLike,
        support: FieldLike,
        fixed: FixedLike = None,
        frame_height: FieldLike = 0.0,
        groups: Mapping[str, ArrayLike] | None = None,
        upwards: bool = False,
        ceiling: FieldLike | None = None,
        foundation: FieldLike | None = None,
        units: UnitNames | None = None,
    ) -> None:
        names = checked_units(units)
        mesh = TriangleMesh(plain(points, "points", "length", names), triangles, groups)
        fields = {"load": load, "support": support, "ceiling": ceiling, "foundation": foundation}
        self._make(mesh, tension, fixed, fields | {"frame_height": frame_height}, boolean(upwards, "upwards"), names)
        self._warn()

    def _make(
        self,
        mesh: TriangleMesh,
        tension: Any,
        fixed: Any,
        fields: Mapping[str, Any],
        upwards: bool,
        units: Mapping[str, str],
    ) -> None:
        """Take a mesh, and what the arguments of these names, ``fields`` among them, say on it."""
        self.mesh, self.upwards, self.unit_names = mesh, upwards, units
        self.positions = mesh.points
        self.tension: float | Vector = tension_of_triangles(mesh, self.without_unit(tension, "tension"))
        stiffness, areas = assembled(mesh.points, mesh.triangles, self.tension)
        self._edge_stiffness: Vector = read_only(_of_edges(stiffness, mesh.edges))
        self._fix(fixed_points(mesh, fixed), "mesh")
        self.node_area = read_only(areas[self.free])
        self.load: Vector = self.at_nodes(fields["load"], "load")
        self.support: Vector = self.support_at_nodes(fields["support"])
        self.ceiling = self.ceiling_at_nodes(fields["ceiling"])
        self.foundation = self.foundation_at_nodes(fields["foundation"])
        self._hold(fields["frame_height"], "frame_height")
        self._fixed_as = fixed
        taken = {name: self.fixed_height if name == "frame_height" else getattr(self, name) for name in fields}
        self._given = {name: (fields[name], taken[name]) for name in fields} | {"tension": (tension, self.tension)}

    @classmethod
    def from_meshio(cls, mesh: Any, tension: FieldLike, **arguments: Any) -> MeshMembrane:
        """Return the membrane on a mesh that meshio has read, or on that of a file, as Gmsh writes them.

        Parameters
        ----------
        mesh : str, Path or meshio.Mesh
            Triangles in plan. Gmsh's physical groups, and the sets of cells and points of other formats, are known by
            their names (those without one by their number, as text): ``fixed="rim"`` fixes the points of such a group.
            Points that no triangle uses are left out, so that points may have other numbers than in the file.
        tension, **arguments
            As for the class.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        TypeError, ValueError
            As for the class; or if the mesh cannot be read, leaves its plane, or holds other cells.
        ImportError
            If meshio or scikit-fem is not installed.

        Examples
        --------
        >>> import meshio
        >>> import contactqp as cq
        >>> points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]]
        >>> cells = {"triangle": [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]}
        >>> cq.MeshMembrane.from_meshio(meshio.Mesh(points, cells), 1.0, load=1.0, support=0.05)
        MeshMembrane(1 node, 4 triangles, 4 fixed points, tension=1, load=1, support=0.05)
        """
        source = of_meshio(Path(mesh) if isinstance(mesh, str) else mesh)
        return cls(source.points, source.triangles, tension, groups=source.groups, **arguments)

    @classmethod
    def from_skfem(cls, mesh: Any, tension: FieldLike, **arguments: Any) -> MeshMembrane:
        """Return the membrane on a mesh of scikit-fem, whose boundaries and subdomains are groups.

        Parameters
        ----------
        mesh : skfem.MeshTri
            Of straight triangles.
        tension, **arguments
            As for the class.

        Raises
        ------
        TypeError, ValueError
            As for the class; or if it is no such mesh.

        Examples
        --------
        >>> import skfem
        >>> import contactqp as cq
        >>> disk = skfem.MeshTri.init_circle(3)
        >>> cq.MeshMembrane.from_skfem(disk, 1.0, load=4.0, support=0.5)
        MeshMembrane(113 nodes, 256 triangles, 32 fixed points, tension=1, load=4, support=0.5)
        """
        source = of_skfem(mesh)
        return cls(source.points, source.triangles, tension, groups=source.groups, **arguments)

    @property
    def edges(self) -> Numbers:
        """The edges of the mesh."""
        return self.mesh.edges

    @property
    def edge_stiffness(self) -> Vector:
        """T/2 times the cotangents of the angles across each edge, shape (edges,), force per length; of either sign."""
        return self._edge_stiffness

    @property
    def triangles(self) -> Numbers:
        """Numbers of the corners of the mesh's triangles among all points, shape (triangles, 3)."""
        return self.mesh.triangles

    @property
    def units(self) -> dict[str, str]:
        """Units of the model's quantities in words, by name."""
        return super().units | {"tension": "force per length"}

    @property
    def parameters(self) -> dict[str, float]:
        """Tension, where it is a number."""
        return {"tension": self.tension} if isinstance(self.tension, float) else {}

    def max_slope(self, gap: Vector) -> float:
        """Return the largest slope of a triangle that has a node (no unit)."""
        steepest = np.linalg.norm(self.mesh.gradients(self._everywhere(self._below(gap), self._fixed_depth)), axis=1)
        return float(steepest.max(where=(self._number[self.triangles] >= 0).any(axis=1), initial=0.0))

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """Places of all points (length), which are fixed and at which height, and the mesh as UGRID 1.0 has it."""
        length, told = {"units": "length"}, {"units": "length", "long_name": f"height of fixed points, {self.sense}"}
        x, y = self.positions.T
        corners = {"cf_role": "face_node_connectivity", "start_index": 0, "long_name": "corners of each triangle"}
        topology = {
            "cf_role": "mesh_topology",
            "topology_dimension": 2,
            "node_coordinates": "x y",
            "face_node_connectivity": "triangles",
        }
        return {
            "x": Coordinate("point", np.array(x), length),
            "y": Coordinate("point", np.array(y), length),
            "fixed": Coordinate("point", self._number < 0, {"long_name": "whether the point is fixed"}),
            "frame_height": Coordinate("point", self._everywhere(np.full(self.size, np.nan), self.fixed_height), told),
            "triangles": Coordinate(("triangle", "corner"), np.array(self.triangles), corners),
            "mesh": Coordinate((), np.array(0), topology),
        }

    def laid_out(self, values: Vector | Mask) -> tuple[tuple[str, ...], NDArray[Any]]:
        """Return the nodes' values at all points, nan or False at fixed ones; see `ContactModel.laid_out`."""
        everywhere = np.full(len(self.positions), False if values.dtype == np.bool_ else np.nan, dtype=values.dtype)
        everywhere[self.free] = values
        return ("point",), everywhere

    @property
    def laid_out_on(self) -> dict[str, str]:
        """The mesh, and its points, which UGRID calls nodes."""
        return {"mesh": "mesh", "location": "node"}

    def _take_tension(self, tension: float) -> None:
        factor = tension / self.tension if isinstance(self.tension, float) else tension
        self._edge_stiffness = read_only(factor * self._edge_stiffness)
        self.tension = tension if isinstance(self.tension, float) else read_only(factor * self.tension)

    def refined(self, chosen: ArrayLike | None = None) -> MeshMembrane:
        """Return the membrane on a finer mesh.

        Triangles that are chosen are split into four, and their neighbours into two or three, so that all sides meet.
        What was given as a number, a function or a profile is taken anew at the new nodes, and what was given as an
        array, or varied since, is interpolated; a triangle's tension is that of the one that it lies in. New points of
        the boundary are fixed between two fixed ones; by a function, or by names, those that it, or the group, holds.

        Parameters
        ----------
        chosen : array of bool, shape (triangles,), or of int, optional
            By default all.

        Raises
        ------
        TypeError, ValueError
            If it names no triangles; as for the class.

        Examples
        --------
        >>> import contactqp as cq
        >>> square = cq.MeshMembrane(
        ...     [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]],
        ...     [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        ...     *(1.0,),
        ...     load=1.0,
        ...     support=lambda x, y: 0.05 + x,
        ... )
        >>> finer = square.refined([True, False, False, False])
        >>> finer
        MeshMembrane(3 nodes, 11 triangles, 7 fixed points, tension=1, load=1, support=0.3 to 0.8)
        """
        count = len(self.triangles)
        mask = np.ones(count, dtype=np.bool_) if chosen is None else _chosen(chosen, count)
        halving = self.mesh.halved(mask)
        finer = type(self).__new__(type(self))
        fields = {name: self._carried(name, halving) for name in self._given if name != "tension"}
        tension, fixed = self._tension_on(halving), self._fixed_on(halving)
        finer._make(halving.mesh, tension, fixed, fields, self.upwards, self.unit_names)
        finer.halving = halving
        return finer

    def _tension_on(self, halving: Halving) -> Any:
        given, now = self._given["tension"][0], self.tension
        if now is self._given["tension"][1] and is_function(given):
            return given
        return now if isinstance(now, float) else np.asarray(now)[halving.parents]

    def _fixed_on(self, halving: Halving) -> Any:
        if not _by_points(self._fixed_as):
            return self._fixed_as
        old = len(self.positions)
        both = np.asarray((self._number < 0)[halving.ends].all(axis=1))
        return both & np.append(np.ones(old, dtype=np.bool_), np.isin(halving.halved, self.mesh.boundary))

    def _carried(self, name: str, halving: Halving) -> Any:
        """Return a field for a finer mesh: as it was given, or interpolated at all points."""
        given, taken = self._given[name]
        now = self.fixed_height if name == "frame_height" else getattr(self, name)
        if now is taken and (given is None or is_function(given) or np.ndim(given) == 0):
            return given
        of_frame = name == "frame_height"
        values = np.full(len(self.positions), np.nan)
        values[self.fixed if of_frame else self.free] = now
        return halving.between(_filled(values, self.positions))

    def _joined(self) -> Any:
        load_modules("scipy.sparse")
        from scipy import sparse

        ends = self._number[self.edges]
        one, other = ends[(ends >= 0).all(axis=1)].T
        return sparse.coo_array((np.ones(one.size), (one, other)), shape=(self.size, self.size)).tocsr()

    def __repr__(self) -> str:
        numbers = [(self.size, "node"), (len(self.triangles), "triangle"), (self.fixed.size, "fixed point")]
        told = f"{self.tension:g}" if isinstance(self.tension, float) else span_of(self.tension)
        return self._line_of_text(*(counted(number, noun) for number, noun in numbers), f"tension={told}")


def _of_edges(stiffness: Any, edges: Numbers) -> Vector:
    """Return the stiffness of each edge, exactly zero where it is what rounding has left of that."""
    one, other = edges.T
    found = -np.asarray(stiffness[one, other], dtype=np.float64).ravel()
    diagonal = stiffness.diagonal()
    found[np.abs(found) <= _NOTHING * np.minimum(diagonal[one], diagonal[other])] = 0.0
    return found


def _chosen(chosen: ArrayLike, count: int) -> Mask:
    given = np.asarray(chosen)
    if given.dtype == np.bool_ and given.shape == (count,):
        return np.asarray(given)
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        raise ValueError(f"chosen must be a mask of shape ({count},) or hold triangles' numbers, got {given.shape}")
    outside = given[(given < 0) | (given >= count)]
    if outside.size:
        raise ValueError(f"chosen names triangle {outside[0]}, but there are {count}, numbered 0 to {count - 1}")
    mask = np.zeros(count, dtype=np.bool_)
    mask[given.astype(np.int64)] = True
    return mask


def _by_points(fixed: Any) -> bool:
    """Whether fixed points were told by their numbers or a mask, which a finer mesh does not share."""
    if fixed is None or is_function(fixed) or isinstance(fixed, str):
        return False
    return not (isinstance(fixed, (list, tuple)) and all(isinstance(name, str) for name in fixed))


def _filled(values: Vector, places: Vector) -> Vector:
    """Return values at points, each nan replaced by what the nearest other point has."""
    unknown = np.isnan(values)
    if not unknown.any():
        return values
    load_modules("scipy.spatial")
    from scipy.spatial import KDTree

    filled, known = np.array(values), np.flatnonzero(~unknown)
    _, nearest = KDTree(places[known]).query(places[unknown])
    filled[unknown] = values[known[nearest]]
    return filled
