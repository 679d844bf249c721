r"""Which triangles of a mesh are too large: those of the free boundary, and those whose error moves it.

Where the free boundary crosses a triangle, it is known to the triangle's size. Elsewhere the deflection's error is
estimated from what is left of equilibrium, as in the pointwise estimators of Nochetto, Siebert and Veeser (*Pointwise a
posteriori error control for elliptic obstacle problems*, Numer. Math. 95, 2003): a triangle of size h contributes

.. math:: η = h\,\max|[T ∂_n w]|/T + h^2 \max|p - k w|/T,

the first from the jumps of the flux across its sides, none of it where all its nodes are held. An error e of the
deflection at a distance ℓ from the free boundary turns the membrane there by about e/ℓ, and moves the free boundary by
e/(ℓκ), where κ = ρ/T is the jump of curvature there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..models.mesh_membrane import MeshMembrane
from ..models.records import Answered

_SHARE = 0.1
"""Part of κ times the target and the size of the whole that the indicator of a triangle may be.

On the sphere of ``benchmarks/refinement.py`` a fifth of it takes half as many nodes again for the same free boundary,
and four times as much moves that by a third more in the mean.
"""


def crossed(model: MeshMembrane, contact: Mask) -> Mask:
    """Return which triangles have a node in contact and one that is not, shape (triangles,); fixed points are none.

    Parameters
    ----------
    contact : array of bool, shape (n,)
    """
    state = np.zeros(len(model.positions), dtype=np.int8)
    state[model.free] = np.where(contact, 2, 1)
    corners = state[model.triangles]
    return np.asarray((corners == 1).any(axis=1) & (corners == 2).any(axis=1))


def residuals(solution: Answered, model: MeshMembrane) -> Vector:
    """Return η of each triangle, shape (triangles,), length."""
    mesh = model.mesh
    heights = model.point_heights(solution.deflection)
    tension = np.broadcast_to(np.asarray(model.tension), (len(mesh.triangles),))
    flux = tension[:, None] * mesh.gradients(heights)
    side = mesh.points[mesh.edges[:, 1]] - mesh.points[mesh.edges[:, 0]]
    normal = np.column_stack([side[:, 1], -side[:, 0]]) / np.hypot(*side.T)[:, None]
    jump = np.abs((_jumps(mesh.triangle_edges, flux, len(mesh.edges)) * normal).sum(axis=1))
    held = np.ones(len(mesh.points), dtype=np.bool_)
    held[model.free] = False
    jump[held[mesh.edges].all(axis=1)] = 0.0  # the frame takes what arrives there
    pressure = model.nodal_load / model.node_area
    if model.foundation is not None:
        sunk = -solution.deflection if model.upwards else solution.deflection
        pressure = pressure - model.foundation * sunk
    out_of_balance = np.zeros(len(mesh.points))
    out_of_balance[model.free] = np.where(solution.contact, 0.0, np.abs(pressure))
    size = mesh.longest_sides
    found = size * jump[mesh.triangle_edges].max(axis=1) + size**2 * out_of_balance[mesh.triangles].max(axis=1)
    resting = held.copy()
    resting[model.free] = solution.contact
    return np.where(resting[mesh.triangles].all(axis=1), 0.0, found / tension)


def _jumps(triangle_edges: NDArray[np.int64], flux: Vector, edges: int) -> NDArray[np.float64]:
    """Return for each edge the flux of one of its triangles less that of the other, or the flux of its only one."""
    order = np.argsort(triangle_edges.ravel(), kind="stable")
    which, triangle = triangle_edges.ravel()[order], order // 3
    first = np.searchsorted(which, np.arange(edges))
    two = np.append(which[1:] == which[:-1], False)[first]
    found = flux[triangle[first]].copy()
    found[two] -= flux[triangle[first[two] + 1]]
    return found


def too_large(solution: Answered, model: MeshMembrane, target: float) -> Mask:
    """Return which triangles are to be split so that the free boundary is known to ``target`` (length); none if it is.

    Elsewhere no more is asked than what suits half the size that the triangles at the free boundary have so far: the
    meshes grow as a geometric series, and the last one takes most of the time. Where there is something to split, all
    triangles above half of what is allowed are: so there are fewer steps.
    """
    mesh = model.mesh
    crossing = crossed(model, solution.contact)
    width = float(mesh.longest_sides.max(where=crossing, initial=0.0))
    next_width = max(target, width / 2)
    allowed = _SHARE * _curvature(solution, model, crossing) * next_width * float(np.sqrt(mesh.areas.sum()))
    wide = crossing & (mesh.longest_sides > target)
    found = residuals(solution, model) if allowed else np.zeros(len(wide))
    if not (wide.any() or (found > allowed).any()):
        return np.zeros_like(wide)
    return np.asarray(wide | (found > allowed / 2) if allowed else wide)


def _curvature(solution: Answered, model: MeshMembrane, crossing: Mask) -> float:
    """Return κ (1/length): as a rule the reaction's pressure over the tension next to the free boundary.

    Where nothing is in contact, it is that of the load.
    """
    beside = np.zeros(len(model.positions), dtype=np.bool_)
    beside[model.triangles[crossing]] = True
    near = beside[model.free] & solution.contact
    tension = float(np.mean(model.tension))
    reaction = np.abs(solution.reaction / model.node_area)
    pressed = reaction[near] if near.any() else np.abs(model.nodal_load / model.node_area)
    return float(np.median(pressed)) / tension
