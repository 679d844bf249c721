"""How far off the free boundary is against processor time: uniform lattice and refined mesh, on a known obstacle.

The upper half of the unit sphere lies below a membrane over (-2, 2)², without load, whose frame is where the exact
solution has it (E. Bueler, *PETSc for Partial Differential Equations*, SIAM 2021, chapter 12): it touches where
r <= a = 0.697965..., and is -A ln r + B beyond. Told is the Hausdorff distance between the circle r = a and the points
in the middle of edges that join a node in contact to one that is not; the Jaccard index of the contact area and the
disk r <= a, which is the area of what they have in common over that of both together; and the largest error of the
deflection. The contact area is that of the triangles whose corners are all in contact, or on a lattice that of the
squares about the nodes in contact. Time is that of all processors, from an empty model (the mesh: from 16² squares) to
the certified answer: other programs that run at the same time do not count.

    contactqp bench run benchmarks/refinement.py

VIAMR, which refines meshes through Firedrake, was published with a distance of 2.6e-3, a Jaccard index of 0.9982 and
17,447 vertices in 3.6 s on its authors' machine.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import shapely

import contactqp as cq
from contactqp.benchmark import Spec

RADIUS, SLOPE, RISE = 0.697965148223374, 0.680259411891719, 0.471519893402112
_LAST = 0.9
"""Where the sphere is carried on as a cone, which is nowhere steeper than that."""


def sphere(x, y):
    """Return the obstacle's height."""
    r, edge = np.hypot(x, y), np.sqrt(1 - _LAST**2)
    return np.where(r <= _LAST, np.sqrt(1 - np.minimum(r, _LAST) ** 2), edge - (r - _LAST) * _LAST / edge)


def exact(x, y):
    """Return the deflection's height."""
    r = np.hypot(x, y)
    return np.where(r <= RADIUS, sphere(x, y), -SLOPE * np.log(np.maximum(r, RADIUS)) + RISE)


GIVEN = {"load": 0.0, "support": sphere, "frame_height": exact, "upwards": True}


def on_lattice(squares):
    """Solve on a uniform lattice."""
    return cq.solve(cq.Membrane(cq.Frame.rectangle(4, 4).lattice(4 / squares), 1.0, **GIVEN), tol=1e-6)


def on_mesh(target):
    """Refine a coarse mesh."""
    import skfem

    side = np.linspace(-2, 2, 17)
    mesh = cq.MeshMembrane.from_skfem(skfem.MeshTri.init_tensor(side, side), 1.0, **GIVEN)
    return cq.refine(cq.solve(mesh, tol=1e-6), target).solution


def distance_from_circle(points):
    """Return the Hausdorff distance between points and the circle."""
    from scipy.spatial import KDTree

    off = np.abs(np.hypot(*points.T) - RADIUS).max()
    angle = np.linspace(0, 2 * np.pi, 20_000)
    apart, _ = KDTree(points).query(RADIUS * np.column_stack([np.cos(angle), np.sin(angle)]))
    return max(off, float(apart.max()))


def squares_in_contact(solution):
    """Return the corners of the squares about the nodes in contact, shape (k, 4, 2)."""
    model = solution.model
    half = model.lattice.spacing / 2
    middles = np.column_stack([model.node_x, model.node_y])[solution.contact]
    return middles[:, None] + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


def triangles_in_contact(solution):
    """Return the corners of the triangles whose nodes are all in contact, shape (k, 3, 2)."""
    model = solution.model
    touching = np.zeros(len(model.positions), dtype=bool)
    touching[model.free] = solution.contact
    return model.positions[model.triangles[touching[model.triangles].all(axis=1)]]


def jaccard(cells):
    """Return the Jaccard index of convex cells, by their corners, and the disk."""
    x, y = np.moveaxis(cells, 2, 0)
    area = np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)) / 2
    inside = (np.hypot(x, y) <= RADIUS).all(axis=1)
    common = area[inside].sum()
    circle = shapely.Point(0, 0).buffer(RADIUS, quad_segs=2000)
    cut = shapely.polygons(cells[~inside])
    common += shapely.area(shapely.intersection(cut, circle)).sum()
    return common / (area.sum() + np.pi * RADIUS**2 - common)


def off(cells: Callable[[Any], Any]) -> Callable[[Any, Any], dict[str, Any]]:
    def tell(case: Any, solution: Any) -> dict[str, Any]:
        model = solution.model
        return {
            "status": solution.status.value,
            "nodes": model.size,
            "Hausdorff": float(distance_from_circle(model.free_boundary(solution.contact))),
            "Jaccard": float(jaccard(cells(solution))),
            "error": float(np.abs(solution.deflection - exact(model.node_x, model.node_y)).max()),
        }

    return tell


SPECS = (
    Spec(
        "boundary-lattice",
        "how far off the free boundary is on a uniform lattice, against processor time",
        lambda squares: squares,
        (128, 256, 512, 1024, 1600),
        {"lattice": on_lattice},
        point="squares along a side",
        tell=off(squares_in_contact),
        repeat=2,
        smoke=64,
        drawn=True,
        clock=time.process_time,
    ),
    Spec(
        "boundary-mesh",
        "how far off the free boundary is on a refined mesh, against processor time",
        lambda target: target,
        (0.08, 0.03, 0.012, 0.006, 0.003),
        {"mesh": on_mesh},
        point="the length that edges at the boundary are refined to",
        tell=off(triangles_in_contact),
        repeat=2,
        smoke=0.1,
        clock=time.process_time,
    ),
)
