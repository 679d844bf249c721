"""How far off the free boundary is against processor time: uniform lattice and refined mesh, on a known obstacle.

The upper half of the unit sphere lies below a membrane over (-2, 2)², without load, whose frame is where the exact
solution has it (E. Bueler, *PETSc for Partial Differential Equations*, SIAM 2021, chapter 12): it touches where
r <= a = 0.697965..., and is -A ln r + B beyond. Told is the Hausdorff distance between the circle r = a and the points
in the middle of edges that join a node in contact to one that is not; the Jaccard index of the contact area and the
disk r <= a, which is the area of what they have in common over that of both together; and the largest error of the
deflection. The contact area is that of the triangles whose corners are all in contact, or on a lattice that of the
squares about the nodes in contact. Time is
that of all processors, from an empty model (the mesh: from 16² squares) to the certified answer: other programs that
run at the same time do not count. Of several runs the fastest is told.

    python benchmarks/refinement.py                     print the table
    python benchmarks/refinement.py --plot curve.png    and draw it
"""

import argparse
import time
import warnings

import numpy as np
import shapely
import skfem

import contactqp as cq

RADIUS, SLOPE, RISE = 0.697965148223374, 0.680259411891719, 0.471519893402112
_LAST = 0.9
"""Where the sphere is carried on as a cone, which is nowhere steeper than that."""

VIAMR = {"distance": 2.6e-3, "seconds": 3.6, "vertices": 17_447, "jaccard": 0.9982}
"""What VIAMR, which refines meshes through Firedrake, was published with on its authors' machine."""


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


def measured(solve, cells, size, repeat):
    """Return nodes, Hausdorff distance, Jaccard index, error, and the least processor time of some runs."""
    least = np.inf
    for _ in range(repeat):
        started = time.process_time()
        solution = solve(size)
        least = min(least, time.process_time() - started)
    model = solution.model
    distance = distance_from_circle(model.free_boundary(solution.contact))
    error = np.abs(solution.deflection - exact(model.node_x, model.node_y)).max()
    assert solution.status == "certified"
    return model.size, distance, float(jaccard(cells(solution))), float(error), least


def draw(rows, path):
    """Draw distances against seconds."""
    from contactqp.plotting.style import BLUE, CONTACT, INK, new_figure, tidy

    figure = new_figure(7, 4.6)
    axes = figure.subplots()
    beside = ((BLUE, (-6, -9), "right"), (CONTACT, (5, 4), "left"))
    for (kind, found), (colour, shift, side) in zip(rows.items(), beside, strict=True):
        nodes, distances, _, _, seconds = zip(*found, strict=True)
        axes.loglog(seconds, distances, "o-", color=colour, label=kind)
        for count, distance, second in zip(nodes, distances, seconds, strict=True):
            place = {"xytext": shift, "textcoords": "offset points", "fontsize": "x-small", "ha": side}
            axes.annotate(f"{count:,}", (second, distance), color=colour, **place)
    axes.plot(VIAMR["seconds"], VIAMR["distance"], "*", ms=12, color=INK, label="VIAMR, 17,447 vertices, as published")
    axes.set(xlabel="seconds of processor time", ylabel="Hausdorff distance of the free boundary")
    axes.legend(frameon=False)
    tidy(axes)
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--squares", type=int, nargs="+", default=[128, 256, 512, 1024, 1600])
    parser.add_argument("--targets", type=float, nargs="+", default=[0.08, 0.03, 0.012, 0.006, 0.003])
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("--plot")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", cq.ContactWarning)
    for solve, size in ((on_lattice, max(arguments.squares)), (on_mesh, min(arguments.targets))):
        solve(size)  # loads libraries and compiles kernels
    runs = {
        "uniform lattice": (on_lattice, squares_in_contact, arguments.squares),
        "refined mesh": (on_mesh, triangles_in_contact, arguments.targets),
    }
    rows = {}
    print(f"{'':16} {'nodes':>9} {'Hausdorff':>10} {'Jaccard':>8} {'error':>9} {'seconds':>8}")
    for kind, (solve, cells, sizes) in runs.items():
        rows[kind] = []
        for size in sizes:
            rows[kind].append(measured(solve, cells, size, arguments.repeat))
            nodes, distance, index, error, seconds = rows[kind][-1]
            print(f"{kind:16} {nodes:9,} {distance:10.2e} {index:8.5f} {error:9.2e} {seconds:8.2f}", flush=True)
    told = f"{VIAMR['vertices']:9,} {VIAMR['distance']:10.2e} {VIAMR['jaccard']:8.4f} {'':9} {VIAMR['seconds']:8.1f}"
    print(f"{'VIAMR, published':16} {told}")
    if arguments.plot:
        draw(rows, arguments.plot)


if __name__ == "__main__":
    main()
