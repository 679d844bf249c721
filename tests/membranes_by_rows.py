"""Membranes whose rows are divided: odd sizes, masks, supports and ceilings that are not everywhere, tensions."""

import numpy as np

import contactqp as cq


def masked():
    """A disk with a hole, off the lattice's middle, over a paraboloid with a gap in it."""
    rows, columns = 151, 120

    def inside(x, y):
        return ((x - 0.6) ** 2 + (y - 0.72) ** 2 < 0.55**2) & ((x - 0.7) ** 2 + (y - 0.6) ** 2 > 0.05**2)

    def support(x, y):
        depth = 0.01 + 0.1 * ((x - 0.6) ** 2 + (y - 0.8) ** 2)
        return np.where((x > 0.3) & (x < 0.45), np.inf, depth)

    return cq.mpi.MembraneByRows(
        (rows, columns), 0.01, 1.0, load=lambda x, y: 1.0 + np.sin(9 * x) * y, support=support, mask=inside
    )


def between():
    """Between a floor and a ceiling that is not everywhere, pulled harder along x, loads both ways."""

    def load(x, y):
        return 40.0 * np.sin(5.0 * y) * np.cos(3.0 * x)

    def ceiling(x, y):
        return np.where(y < 0.5, -0.03 - 0.01 * x, -np.inf)

    return cq.mpi.MembraneByRows(
        (111, 90), 0.01, (2.0, 1.0), load=load, support=lambda x, y: 0.05 + 0.02 * y, ceiling=ceiling
    )


def upwards():
    """Heights positive upwards, an array for a load, a frame above zero, and much softer along x."""
    load = np.random.default_rng(3).uniform(0.0, 3.0, (97, 64))
    return cq.mpi.MembraneByRows(
        (97, 64),
        0.01,
        (0.1, 1.0),
        load=load,
        support=cq.profiles.Paraboloid(depth=0.02, radius=8.0, center=(0.3, 0.5)),
        origin=(0.0, 0.02),
        frame_height=0.004,
        upwards=True,
    )


def patched():
    """Masked, between a floor with a hole and a ceiling, of patches that are pulled a hundred times as hard as others.

    On a foundation, and held by a frame that is not even.
    """
    rows, columns = 133, 101

    def inside(x, y):
        return (x - 0.5) ** 2 + (y - 0.65) ** 2 < 0.61**2

    def tension(x, y):
        return np.where((np.floor(5 * x) + np.floor(4 * y)) % 2 > 0, 10.0, 0.1) * (1.0 + 0.5 * x)

    def support(x, y):
        return np.where((x - 0.3) ** 2 + (y - 0.5) ** 2 < 0.01, np.inf, 0.02 + 0.03 * x)

    return cq.mpi.MembraneByRows(
        (rows, columns),
        0.01,
        tension,
        load=lambda x, y: 8.0 * np.cos(4.0 * y) + x,
        support=support,
        ceiling=lambda x, y: np.where(x > 0.5, -0.02, -np.inf),
        mask=inside,
        frame_height=lambda x, y: 0.004 * np.sin(5.0 * x),
        foundation=lambda x, y: np.where(y > 1.0, 3.0, 0.0),
    )


def woven():
    """An array of tensions along x, which no value is known of on the frame, and one tension along y."""
    warp = np.random.default_rng(7).uniform(0.5, 2.0, (145, 70))
    return cq.mpi.MembraneByRows((145, 70), 0.01, (warp, 1.0), load=3.0, support=lambda x, y: 0.02 + 0.1 * x * y)


CASES = {"masked": masked, "between": between, "upwards": upwards, "patched": patched, "woven": woven}
SIZES = {
    "masked": (1, 2, 3, 5),
    "between": (1, 2, 3, 5),
    "upwards": (1, 3),
    "patched": (1, 2, 3, 5),
    "woven": (1, 2, 3, 5, 9),
}
