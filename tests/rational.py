"""Contact problems that try rounding bounds hard, and their exact solutions in rational numbers."""

from __future__ import annotations

import os
from fractions import Fraction
from itertools import product

import numpy as np

import contactqp as cq
from contactqp.algebra.stencil import Stencil


def shares(count):
    """Return the numbers of those of ``count`` shares of adversarial cases that are tried.

    Every third is; all of them with Hypothesis's profile "thorough", as when a bound or its roundings change.
    """
    return range(0, count, 1 if os.environ.get("HYPOTHESIS_PROFILE") == "thorough" else 3)


def exact_matrix(problem):
    """Return G as the package means it, in rational numbers: on a lattice the exact sums of the arms."""
    stencil = problem.stencil
    if stencil is None:
        return [[Fraction(float(entry)) for entry in row] for row in problem.G.toarray()]
    number = np.full((stencil.mask.shape[0] + 2, stencil.mask.shape[1] + 2), -1)
    number[1:-1, 1:-1][stencil.mask] = np.arange(stencil.size)
    arms = [np.broadcast_to(arm, stencil.mask.shape) for arm in stencil.weights()]
    matrix = [[Fraction(0)] * stencil.size for _ in range(stencil.size)]
    for i, j in np.argwhere(stencil.mask):
        own = number[i + 1, j + 1]
        for arm, (down, right) in zip(arms, ((0, -1), (0, 1), (-1, 0), (1, 0)), strict=True):
            weight, other = Fraction(float(arm[i, j])), number[i + 1 + down, j + 1 + right]
            matrix[own][own] += weight
            if other >= 0:
                matrix[own][other] -= weight
        matrix[own][own] += Fraction(float(np.broadcast_to(stencil.ground, stencil.mask.shape)[i, j]))
    return matrix


def exact_solution(problem, guess=None):
    """Return gap and reaction of the exact solution, from the contact set of ``guess`` on, or trying every one.

    A contact set is a state for each node: 0 free, -1 held by the lower bound, 1 by the upper one. ``guess`` is one,
    or a mask of the free nodes where there are no upper bounds.
    """
    matrix = exact_matrix(problem)
    q = [Fraction(float(entry)) for entry in problem.q]
    size = len(q)
    bounds = {
        -1: [Fraction(float(x)) if np.isfinite(x) else None for x in problem.lower],
        1: [Fraction(float(x)) if np.isfinite(x) else None for x in problem.upper],
    }
    choices = [(0, *(state for state in (-1, 1) if bounds[state][i] is not None)) for i in range(size)]
    pattern: tuple[int, ...] = (0,) * size
    if guess is not None:
        guess = np.where(guess | ~problem.supported, 0, -1) if np.asarray(guess).dtype == bool else guess
        pattern = tuple(int(x) for x in guess)

    def after(pattern):
        """Return gap and reaction of a contact set, and the one that follows: itself where they are the solution."""
        gap = _with_held_nodes(matrix, q, {i: bounds[state][i] for i, state in enumerate(pattern) if state})
        reaction = [
            sum(a * b for a, b in zip(row, gap, strict=True)) + force for row, force in zip(matrix, q, strict=True)
        ]
        following = list(pattern)
        for i, state in enumerate(pattern):
            if state:
                following[i] = state if -state * reaction[i] >= 0 else 0
            elif bounds[-1][i] is not None and gap[i] < bounds[-1][i]:
                following[i] = -1
            elif bounds[1][i] is not None and gap[i] > bounds[1][i]:
                following[i] = 1
        return gap, reaction, tuple(following)

    for _ in range(size + 2):  # mostly it ends there; where it goes round, every set is tried
        gap, reaction, following = after(pattern)
        if following == pattern:
            return gap, reaction
        pattern = following
    for pattern in product(*choices):
        gap, reaction, following = after(pattern)
        if following == pattern:
            return gap, reaction
    raise AssertionError("a positive definite problem has a solution")


def _with_held_nodes(matrix, q, held):
    """Solve the equations of the free nodes by Gauss elimination, the others held where they are."""
    free = [i for i in range(len(q)) if i not in held]
    rows = [[matrix[i][j] for j in free] + [-q[i] - sum(matrix[i][j] * x for j, x in held.items())] for i in free]
    for k in range(len(free)):
        pivot = rows[k][k]
        rows[k] = [entry / pivot for entry in rows[k]]
        for other in range(len(free)):
            if other != k and rows[other][k]:
                rows[other] = [a - rows[other][k] * b for a, b in zip(rows[other], rows[k], strict=True)]
    gap = [held.get(i, Fraction(0)) for i in range(len(q))]
    for k, i in enumerate(free):
        gap[i] = rows[k][-1]
    return gap


def is_positive_definite(rows):
    """Whether an exact symmetric matrix is, by the pivots of Gauss's elimination."""
    for k, row in enumerate(rows):
        if row[k] <= 0:
            return False
        for other in rows[k + 1 :]:
            factor = other[k] / row[k]
            other[k:] = [a - factor * b for a, b in zip(other[k:], row[k:], strict=True)]
    return True


def m_matrix(rng, size):
    """Return a symmetric M-matrix, at times nearly singular or of scales far apart."""
    weights = np.triu(10.0 ** rng.uniform(-rng.choice([0.5, 6]), 0.5, (size, size)), 1)
    weights *= rng.uniform(size=(size, size)) < rng.uniform(0.2, 1.0)
    weights += weights.T
    ground = 10.0 ** rng.uniform(-rng.choice([0.5, 3, 9]), 0.5, size)
    scale = 10.0 ** rng.uniform(-1, 1, size) ** 3 if rng.uniform() < 0.5 else np.ones(size)
    matrix = scale[:, None] * (np.diag(weights.sum(axis=1) + ground) - weights) * scale[None, :]
    return (matrix + matrix.T) / 2


def lattice_stencil(rng):
    mask = rng.uniform(size=(rng.integers(1, 4), rng.integers(1, 4))) < 0.7
    mask[0, 0] = True
    rows, columns = mask.shape
    if rng.uniform() < 0.5:
        return Stencil(mask, *(10.0 ** rng.uniform(-3, 3, 2)))
    return Stencil(
        mask, 10.0 ** rng.uniform(-3, 3, (rows, columns + 1)), 10.0 ** rng.uniform(-3, 3, (rows + 1, columns))
    )


def adversarial_problem(rng, largest=5):
    """Return a small problem with an M-matrix: any forces, nearly or exactly biactive nodes, some without support."""
    if rng.uniform() < 0.3:
        stiffness = lattice_stencil(rng)
    else:
        stiffness = m_matrix(rng, rng.integers(1, largest + 1))
        if rng.uniform() < 0.2:
            stiffness = np.round(stiffness * 4) / 4
            stiffness[np.diag_indices(len(stiffness))] = 0.25 - (stiffness.sum(axis=1) - np.diag(stiffness))
    bare = cq.ContactQP(stiffness, np.zeros(stiffness.size if isinstance(stiffness, Stencil) else len(stiffness)))
    size = bare.size
    gap = np.where(rng.uniform(size=size) < 0.5, 10.0 ** rng.uniform(-rng.choice([1, 8, 16]), 1, size), 0.0)
    if rng.uniform() < 0.3:
        gap = np.round(gap * 4)
    press = np.where(gap == 0, 10.0 ** rng.uniform(-rng.choice([1, 8, 18]), 1, size), 0.0)
    press[rng.uniform(size=size) < rng.choice([0.0, 0.5, 1.0])] = 0.0
    kind = rng.uniform()
    if kind < 0.7:
        q = press - bare.stiffness.matvec(gap)
    elif kind < 0.9:
        q = rng.normal(size=size) * 10.0 ** rng.uniform(-3, 3, size)
    else:
        q = np.zeros(size)
    supported = rng.uniform(size=size) < 0.8 if rng.uniform() < 0.3 else None
    return cq.ContactQP(stiffness, q * 10.0 ** rng.choice([0, 0, -30, 30]), supported=supported)


def adversarial_bounds(rng, stiffness):
    """Return a problem with two bounds: nodes free, held by either, nearly or exactly biactive, bounds equal or far."""
    bare = cq.ContactQP(stiffness, np.zeros(stiffness.size if isinstance(stiffness, Stencil) else len(stiffness)))
    size = bare.size
    gap = rng.normal(size=size) * 10.0 ** rng.uniform(-rng.choice([1, 8]), 1, size)
    gap = np.where(rng.uniform(size=size) < 0.3, 0.0, gap)
    state = rng.integers(-1, 2, size)
    room = 10.0 ** rng.uniform(-rng.choice([1, 8, 17]), 1, (2, size)) * (rng.uniform(size=(2, size)) < 0.95)
    lower = np.where(state < 0, gap, gap - room[0])
    upper = np.where(state > 0, gap, gap + room[1])
    lower = np.where((state >= 0) & (rng.uniform(size=size) < 0.3), -np.inf, lower)
    upper = np.where((state <= 0) & (rng.uniform(size=size) < 0.3), np.inf, upper)
    press = -state * 10.0 ** rng.uniform(-rng.choice([1, 8, 18]), 1, size)
    press[rng.uniform(size=size) < rng.choice([0.0, 0.3, 1.0])] = 0.0
    q = press - bare.stiffness.matvec(gap) if rng.uniform() < 0.8 else rng.normal(size=size)
    return cq.ContactQP(stiffness, q, lower, np.maximum(lower, upper))


def adversarial_answer(rng, problem, exact):
    """Return an answer that is exact up to rounding, or wrong by any amount."""
    gap = np.array([float(entry) for entry in exact])
    size = 10.0 ** rng.uniform(-18, 1)
    kind = rng.integers(4)
    if kind == 0:
        return gap * (1 + size * rng.normal(size=gap.size))
    if kind == 1:
        return gap + size * np.abs(gap).max() * rng.normal(size=gap.size)
    if kind == 2:
        return np.maximum(gap + size * np.abs(gap).max() * rng.normal(size=gap.size), 0.0)
    return rng.choice([0.0, 1.0, -1.0]) * (np.abs(gap).max() + 1) * rng.uniform(size=gap.size)


def _is_below(bound, exact):
    """Whether a lower bound holds; there may be none, but NaN and inf are errors."""
    return bound == -np.inf or Fraction(float(bound)) <= exact


def _is_above(bound, exact):
    return _is_below(-bound, -exact)


def assert_certificate_holds(certificate, exact_gap, exact_reaction, answer):
    """Assert every claim of a certificate in rational arithmetic."""
    problem = certificate.problem
    low, high = certificate.reaction
    for i, (gap, reaction) in enumerate(zip(exact_gap, exact_reaction, strict=True)):
        assert _is_below(certificate.lower[i], gap)
        assert _is_above(certificate.upper[i], gap)
        assert _is_above(certificate.gap_bound, abs(Fraction(float(answer[i])) - gap))
        assert reaction > 0 or not certificate.contact_lower[i]
        assert reaction < 0 or not certificate.contact_upper[i]
        assert certificate.contact[i] == (certificate.contact_lower[i] or certificate.contact_upper[i])
        if certificate.clear[i]:
            assert not problem.supported[i] or gap > Fraction(float(problem.lower[i]))
            assert not np.isfinite(problem.upper[i]) or gap < Fraction(float(problem.upper[i]))
        assert _is_below(low[i], reaction)
        assert _is_above(high[i], reaction)
    total = sum(exact_reaction)
    bracket = certificate.total_reaction
    assert _is_below(bracket.lower, total)
    assert _is_above(bracket.upper, total)
    if problem.one_sided:  # what pushes up alone is bounded from below whatever the answer
        assert np.isfinite([*certificate.lower, *low, bracket.lower]).all()
    count = sum(reaction != 0 for reaction in exact_reaction)
    assert certificate.contact_nodes.lower <= count <= certificate.contact_nodes.upper
