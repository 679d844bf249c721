"""Meshes of triangles with known properties, as points and triangles."""

import numpy as np


def split_lattice(lattice):
    """Return a lattice's squares, each cut into two triangles, with the frame points about it; nodes come first.

    Around nodes that lie next to the frame all squares are there, their outer corners included.
    """
    padded = np.pad(lattice.mask, 1)
    near = np.zeros_like(padded)
    for row, column in np.argwhere(padded):
        near[row - 1 : row + 2, column - 1 : column + 2] = True
    number = np.full(padded.shape, -1)
    number[padded] = np.arange(lattice.size)
    frame = near & ~padded
    number[frame] = lattice.size + np.arange(np.count_nonzero(frame))
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    triangles = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])])
    free = (triangles >= 0) & (triangles < lattice.size)
    triangles = triangles[(triangles >= 0).all(axis=1) & free.any(axis=1)]
    x, y = lattice.ring_coordinates(*np.nonzero(frame))
    points = np.column_stack([np.concatenate([lattice.node_x, x]), np.concatenate([lattice.node_y, y])])
    used = np.unique(triangles)
    new = np.full(len(points), -1)
    new[used] = np.arange(used.size)
    return points[used], new[triangles]


def rings(count):
    """Return concentric rings of 6, 12, ... points in the unit disk, the outermost on its rim, and their triangles."""
    from scipy.spatial import Delaunay

    places = [np.zeros((1, 2))]
    for k in range(1, count + 1):
        angle = 2 * np.pi * np.arange(6 * k) / (6 * k)
        places.append(np.column_stack([np.cos(angle), np.sin(angle)]) * k / count)
    points = np.concatenate(places)
    return points, Delaunay(points).simplices


def obtuse_rings(count, seed=0, moved=0.35):
    """Return the same points, those inside moved by a part of their distance, with triangles of any shape.

    The triangles are those of the points before they were moved, so that they are no longer Delaunay's.
    """
    points, triangles = rings(count)
    inside = np.hypot(*points.T) < 1 - 0.5 / count
    rng = np.random.default_rng(seed)
    moves = rng.uniform(-moved, moved, points.shape) / count
    return points + np.where(inside[:, None], moves, 0.0), triangles


def touching(load, floor):
    """Return where the unit disk of tension one touches a floor: p(1 - a²)/4 + (p a²/2) ln a = f."""
    from scipy.optimize import brentq

    def excess(a):
        return load * (1 - a * a) / 4 + load * a * a / 2 * np.log(a) - floor

    return brentq(excess, 1e-12, 1 - 1e-12)


def deflection_of_disk(x, y, load, floor):
    """Return the exact deflection of the unit disk of tension one over a floor."""
    a, r = touching(load, floor), np.hypot(x, y)
    beside = load * (1 - r * r) / 4 + load * a * a / 2 * np.log(np.maximum(r, a))
    return np.where(r > a, beside, floor)
