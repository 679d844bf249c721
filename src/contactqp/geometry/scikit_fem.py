"""What scikit-fem is asked for: the stiffness of linear triangles by its assembly, and meshes by its refinement."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import needed

INSTALL = "contactqp[mesh]"

Numbers = NDArray[np.int64]


def assembled(points: Vector, triangles: Numbers, tension: Vector | float) -> tuple[Any, Vector]:
    r"""Return the stiffness of linear elements, and the area that each point stands for.

    Parameters
    ----------
    points : array, shape (points, 2)
        Length.
    triangles : array of int, shape (triangles, 3)
    tension : float or array, shape (triangles,)
        T, force per length.

    Returns
    -------
    stiffness : sparse array, shape (points, points)
        :math:`\int T ∇φ_i·∇φ_j` over all triangles (force per length).
    areas : array, shape (points,)
        :math:`\int φ_i`: a third of the areas of each point's triangles.

    Raises
    ------
    ImportError
        If scikit-fem is not installed.
    """
    fem = needed("skfem", "MeshMembrane", INSTALL)
    basis = fem.Basis(_mesh(fem, points, triangles), fem.ElementTriP1(), intorder=1)
    given = np.broadcast_to(np.asarray(tension, dtype=np.float64), (len(triangles),))
    within = basis.with_element(fem.ElementTriP0()).interpolate(given.copy())
    stiffness = fem.BilinearForm(_stretched).assemble(basis, tension=within)
    areas: Vector = fem.LinearForm(_held).assemble(basis)
    return stiffness.tocsr(), areas


def _stretched(u: Any, v: Any, w: Any) -> Any:
    return w["tension"] * (u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1])


def _held(v: Any, w: Any) -> Any:
    return 1.0 * v


def halved_where(points: Vector, triangles: Numbers, chosen: Mask) -> tuple[Vector, Numbers]:
    """Return points and triangles of the mesh in which some triangles are split into four.

    Parameters
    ----------
    points, triangles
        See `assembled`.
    chosen : array of bool, shape (triangles,)
        Neighbours are split into two or three, so that all sides meet.

    Returns
    -------
    points : array
        The given ones first; each other one is in the middle between two of them.
    triangles : array of int
    """
    fem = needed("skfem", "refining a mesh", INSTALL)
    mesh = _mesh(fem, points, triangles)
    finer = mesh.refined() if chosen.all() else mesh.refined(np.flatnonzero(chosen))
    return np.array(finer.p.T), np.array(finer.t.T, dtype=np.int64)


def circle(refinements: int) -> tuple[Vector, Numbers]:
    """Return points and triangles of scikit-fem's mesh of the unit disk, whose boundary is a polygon on the circle.

    Parameters
    ----------
    refinements : int
        How often the edges of eight triangles are halved.
    """
    mesh = needed("skfem", "a mesh of a disk", INSTALL).MeshTri.init_circle(refinements)
    return np.array(mesh.p.T), np.array(mesh.t.T, dtype=np.int64)


def _mesh(fem: Any, points: Vector, triangles: Numbers) -> Any:
    return fem.MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T, dtype=np.int32))
