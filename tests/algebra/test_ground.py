"""Stencils with arms to the ground against their matrices, and their bounds against rational numbers."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rational import exact_matrix
from strategies import lattice_masks

import contactqp as cq
from contactqp.algebra.stencil import Stencil


@st.composite
def grounded(draw):
    mask = draw(lattice_masks(4, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rows, columns = mask.shape
    varying = draw(st.booleans())
    arms: Any = (
        (rng.uniform(0.1, 2, (rows, columns + 1)), rng.uniform(0.1, 2, (rows + 1, columns))) if varying else (0.7, 0.3)
    )
    ground: Any = 0.4 if draw(st.booleans()) else rng.uniform(0, 10.0 ** rng.integers(-3, 4), mask.shape)
    horizontal, vertical = arms
    return Stencil(mask, horizontal, vertical, ground), rng


@given(grounded())
def test_what_it_does_is_what_its_matrix_does(case):
    stencil, rng = case
    matrix, x = stencil.tocsr().toarray(), rng.normal(size=(2, stencil.size))
    without = Stencil(stencil.mask, stencil.horizontal, stencil.vertical).tocsr().toarray()
    springs = np.broadcast_to(stencil.ground, stencil.mask.shape)[stencil.mask]
    np.testing.assert_allclose(matrix, without + np.diag(springs), rtol=1e-14)
    np.testing.assert_allclose(stencil.matvec(x), x @ matrix, rtol=1e-12, atol=1e-12 * matrix.max())
    np.testing.assert_allclose(stencil.modulus_matvec(np.abs(x)), np.abs(x) @ np.abs(matrix), rtol=1e-12)
    np.testing.assert_array_equal(stencil.diagonal(), np.diag(matrix))
    np.testing.assert_allclose(stencil.scaled(2.0).tocsr().toarray(), 2 * matrix)
    np.testing.assert_allclose(
        stencil.scaled(2.0).on_ground(stencil.ground).tocsr().toarray(), 2 * without + np.diag(springs), rtol=1e-14
    )
    height = stencil.numbering.to_grid(x[0], ring=1)
    np.testing.assert_allclose(stencil.pull(height), matrix @ x[0], rtol=1e-10, atol=1e-12 * matrix.max())
    free = rng.uniform(size=stencil.size) < 0.7
    if free.any():
        np.testing.assert_array_equal(stencil.restricted(free).tocsr().toarray(), matrix[np.ix_(free, free)])
    assert not stencil.uniform
    assert "on a foundation" in repr(stencil)
    assert not stencil.equals(Stencil(stencil.mask, stencil.horizontal, stencil.vertical))


@given(grounded())
def test_bounds_hold_in_rational_numbers(case):
    stencil, rng = case
    problem = cq.ContactQP(stencil, rng.normal(size=stencil.size))
    exact = exact_matrix(problem)
    high, low = rng.normal(size=stencil.size) + 1e3, 1e-14 * rng.normal(size=stencil.size)

    def product(*parts):
        x = [sum(Fraction(float(part[j])) for part in parts) for j in range(stencil.size)]
        return [
            sum(a * b for a, b in zip(row, x, strict=True)) + Fraction(float(q))
            for row, q in zip(exact, problem.q, strict=True)
        ]

    for (value, bound), true in (
        (stencil.enclosed_product(high, problem.q), product(high)),
        (stencil.accurate_product(high, low, problem.q), product(high, low)),
    ):
        assert all(
            abs(Fraction(float(v)) - t) <= Fraction(float(b)) for v, b, t in zip(value, bound, true, strict=True)
        )
    diagonal, rounding = stencil.diagonal(), Fraction(stencil.diagonal_rounding)
    assert all(abs(Fraction(float(d)) - exact[i][i]) <= rounding * exact[i][i] for i, d in enumerate(diagonal))
    barrier = problem.barrier
    assert barrier is not None
    v, s = barrier.v, barrier.s
    for row, least in zip(exact, s, strict=True):
        assert sum(a * Fraction(float(b)) for a, b in zip(row, v, strict=True)) >= Fraction(float(least)) > 0


def test_nothing_to_the_ground_is_nothing():
    mask = np.ones((3, 4), dtype=bool)
    assert Stencil(mask, 1.0, 2.0, np.zeros((3, 4))).uniform
    with pytest.raises(ValueError, match="ground must be finite and >= 0"):
        Stencil(mask, 1.0, 1.0, -1.0)
    with pytest.raises(ValueError, match=r"ground must be a number or have shape \(3, 4\)"):
        Stencil(mask, 1.0, 1.0, np.ones((4, 3)))
    assert Stencil(mask, 0.0, 0.0, 1.0).tocsr().nnz == 12  # springs alone
