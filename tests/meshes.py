"""Stiffness matrices that are no M-matrices: meshes of triangles, beams and plates."""

import numpy as np
from scipy import sparse


def triangles(nodes, moved, rng):
    """Return the stiffness of linear elements on the unit square, and what each node stands for.

    It has ``nodes`` times ``nodes`` inner nodes, each moved by up to a part of the spacing, and each square has a
    diagonal: where angles are obtuse, entries beside the diagonal are positive.
    """
    count = nodes + 1
    x, y = (grid.astype(float) for grid in np.meshgrid(np.arange(count + 1), np.arange(count + 1)))
    inner = np.s_[1:-1, 1:-1]
    x[inner] += rng.uniform(-moved, moved, (nodes, nodes))
    y[inner] += rng.uniform(-moved, moved, (nodes, nodes))
    places = np.column_stack([x.ravel(), y.ravel()]) / count
    number = np.arange(places.shape[0]).reshape(x.shape)
    a, b, c, d = number[:-1, :-1].ravel(), number[:-1, 1:].ravel(), number[1:, :-1].ravel(), number[1:, 1:].ravel()
    corners = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])])
    free = np.zeros(x.shape, dtype=bool)
    free[inner] = True
    return assembled(places, corners, free.ravel())


def assembled(places, corners, free):
    """Return the stiffness of linear elements, what each free node stands for, and where it lies."""
    edges = places[np.roll(corners, -1, axis=1)] - places[np.roll(corners, 1, axis=1)]
    area = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    corners, edges, area = (values[area > 1e-14] for values in (corners, edges, area))
    element = np.einsum("tik,tjk->tij", edges, edges) / (4 * area)[:, None, None]
    rows, columns = np.repeat(corners, 3, axis=1).ravel(), np.tile(corners, 3).ravel()
    matrix = sparse.coo_array((element.ravel(), (rows, columns)), shape=(free.size, free.size)).tocsr()
    share = np.bincount(corners.ravel(), weights=np.repeat(area / 3, 3), minlength=free.size)
    matrix = matrix[free][:, free]
    return sparse.csr_array((matrix + matrix.T) / 2), share[free], places[free]


def bowl_on_triangles(nodes, moved=0.25, seed=0):
    """Return matrix and forces of a membrane over a bowl, on `triangles`."""
    return membrane_over_bowl(*triangles(nodes, moved, np.random.default_rng(seed)))


def membrane_over_bowl(matrix, share, places):
    """Return a membrane's matrix, and its forces over a bowl that it touches in the middle of the unit square."""
    gap = 0.05 + 0.2 * ((places - 0.5) ** 2).sum(axis=1)
    return matrix, 2.0 * share - matrix @ gap


def beam_on_floor(nodes, drop=0.5, length=10.0, clamped=False):
    """Return matrix and forces of a beam of bending stiffness and weight one, above a floor, and its spacing.

    Its ends, pinned or clamped, lie ``drop`` above the floor; the free span at each is (24 drop)^(1/4) long if they are
    pinned, and (72 drop)^(1/4) if they are clamped. The stiffness over the cube of the spacing is rounded to 24
    bits, so that the rows 1, -4, 6, -4, 1 of the matrix sum up to zero as they should: of many nodes, what rounding
    leaves in their place is a foundation that is stiffer than the beam.
    """
    spacing = length / (nodes + 1)
    stiffness = float(np.float32(1 / spacing**3))
    rows = [np.full(nodes - abs(k), entry) for k, entry in zip(range(-2, 3), (1.0, -4.0, 6.0, -4.0, 1.0), strict=True)]
    rows[2][[0, -1]] = 7.0 if clamped else 5.0
    integers = sparse.diags_array(rows, offsets=[-2, -1, 0, 1, 2]).tocsr()
    return integers * stiffness, spacing - drop * stiffness * integers.sum(axis=1), spacing


def beam_over_floor(nodes, drop=0.5, length=10.0, clamped=False):
    """Return the gap between the beam of `beam_on_floor` and its floor at the nodes, in closed form."""
    x = length * np.arange(1, nodes + 1) / (nodes + 1)
    x = np.minimum(x, length - x)
    if clamped:
        a = (72 * drop) ** 0.25
        depth = x**4 / 24 - a * x**3 / 9 + a**2 * x**2 / 12
    else:
        a = (24 * drop) ** 0.25
        depth = x**4 / 24 - a * x**3 / 12 + a**3 * x / 12
    return np.where(x < a, drop - depth, 0.0)


def plate_over_bowl(nodes):
    """Return matrix and forces of a simply supported plate over a bowl, by the thirteen-point stencil."""
    line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(nodes, nodes))
    laplacian = sparse.kronsum(line, line).tocsr()
    matrix, spacing = sparse.csr_array(laplacian @ laplacian), 1.0 / (nodes + 1)
    x, y = np.meshgrid(*(spacing * np.arange(1, nodes + 1),) * 2)
    gap = 0.02 + 0.1 * ((x - 0.5) ** 2 + (y - 0.5) ** 2).ravel()
    return matrix, 1600.0 * spacing**4 - matrix @ gap


def bowl_in_space(nodes):
    """Return G and q of seven points on a cube of so many nodes a side, whose gap is that over a bowl in space."""
    spacing = 1 / (nodes + 1)
    line = sparse.diags_array([np.full(nodes, 2.0), -np.ones(nodes - 1), -np.ones(nodes - 1)], offsets=[0, 1, -1])
    eye = sparse.eye_array(nodes)
    matrix = sum(
        sparse.kron(sparse.kron(*pair), last)
        for pair, last in (((line, eye), eye), ((eye, line), eye), ((eye, eye), line))
    )
    side = np.arange(1, nodes + 1) * spacing - 0.5
    support = 0.03 + 0.5 * (side[:, None, None] ** 2 + side[:, None] ** 2 + side**2).ravel()
    matrix = (matrix * spacing).tocsr()
    return matrix, matrix @ support - 2.0 * spacing**3


def bowl_on_a_checkerboard(nodes, block, jump):
    """Return G and q of five points between cells whose coefficients are 1 and ``jump`` in blocks, over a bowl."""
    number = np.arange(nodes)
    stiff = (number[:, None] // block + number // block) % 2 == 1
    coefficient = np.where(stiff, jump, 1.0)
    place = np.arange(nodes**2).reshape(nodes, nodes)
    arms, one, other = [], [], []
    for first, second in (((slice(None), slice(1, None)), (slice(None), slice(-1))), ((slice(1, None),), (slice(-1),))):
        a, b = coefficient[first], coefficient[second]
        arms.append((2 * a * b / (a + b)).ravel())
        one.append(place[first].ravel())
        other.append(place[second].ravel())
    places = np.concatenate(one), np.concatenate(other)
    beside = sparse.coo_array((np.concatenate(arms), places), shape=(nodes**2, nodes**2))
    beside = (beside + beside.T).tocsr()
    frame = np.zeros((nodes, nodes))
    for edge in ((0,), (-1,), (slice(None), 0), (slice(None), -1)):
        frame[edge] += coefficient[edge]
    matrix = (sparse.diags_array(beside.sum(axis=1) + frame.ravel()) - beside).tocsr()
    side = np.arange(1, nodes + 1) / (nodes + 1) - 0.5
    support = 0.05 + 0.4 * (side[:, None] ** 2 + side**2).ravel()
    return matrix, matrix @ support - 8.0 / (nodes + 1) ** 2


def scattered(problem, seed=0):
    """Return matrix and forces of a problem with its unknowns in an order in which nothing is recognised."""
    order = np.random.default_rng(seed).permutation(problem.size)
    matrix = problem.G[order][:, order]
    matrix.sort_indices()
    return matrix, problem.q[order], order
