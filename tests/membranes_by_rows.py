"""Membranes whose rows are divided: odd sizes, masks, supports that are not everywhere, ceilings, two tensions."""

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


CASES = {"masked": masked, "between": between, "upwards": upwards}
SIZES = {"masked": (1, 2, 3, 5), "between": (1, 2, 3, 5), "upwards": (1, 3)}
