"""Double words, factors in a narrow band by them, and what these prove, against exact rational numbers."""

from fractions import Fraction

import numpy as np
import pytest
from numba import njit
from rational import is_positive_definite
from scipy import sparse

from contactqp.algebra import double_word_kernels as words
from contactqp.algebra.band import Band
from contactqp.algebra.narrow_band import WIDEST, NarrowBand, stiff_band


@njit
def _sum(a, a_low, b, b_low):
    return words.word_sum(a, a_low, b, b_low)


@njit
def _product(a, a_low, b, b_low):
    return words.word_product(a, a_low, b, b_low)


@njit
def _product_with_double(a, a_low, b, b_low):
    return words.product_with_double(a, a_low, b)


@njit
def _quotient(a, a_low, b, b_low):
    return words.quotient(a, a_low, b, b_low)


def exact(high, low=0.0):
    return Fraction(float(high)) + Fraction(float(low))


def double_word(rng):
    high = rng.choice([-1, 1]) * rng.uniform(1, 2) * 2.0 ** rng.integers(-60, 60)
    low = rng.uniform(-0.5, 0.5) * np.spacing(high) * 2.0 ** -rng.choice([0, 0, 3, 40])
    return high + low, low - ((high + low) - high)


OPERATIONS = {
    _sum: lambda x, y, _: x + y,
    _product: lambda x, y, _: x * y,
    _product_with_double: lambda x, _, high: x * high,
    _quotient: lambda x, y, _: x / y,
}


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda operation: operation.__name__)
def test_an_operation_is_as_accurate_as_the_proofs_say(operation):
    rng = np.random.default_rng(0)
    for case in range(3000):
        first, second = double_word(rng), double_word(rng)
        if case % 3 == 0:  # close to the first one's negative
            second = -first[0], float(-first[1] * rng.uniform(0.5, 1.5))
        wanted = OPERATIONS[operation](exact(*first), exact(*second), exact(second[0]))
        found = operation(*first, *second)
        assert found[0] == found[0] + found[1]
        assert abs(exact(*found) - wanted) <= Fraction(words.RELATIVE_ERROR) * abs(wanted)


def banded(rng, size, width, least=0.1):
    """Return a symmetric positive definite matrix of doubles whose rows reach ``width`` to either side."""
    lower = np.round(np.tril(np.triu(rng.normal(size=(size, size)), -width)) * 2**16) / 2**16  # squares are exact
    matrix = lower @ lower.T
    matrix = matrix / matrix.diagonal().max()
    return np.ldexp(np.round(np.ldexp(matrix, 40)), -40) + least * np.eye(size)


def narrow(matrix):
    band = NarrowBand.of(Band(sparse.csr_array(matrix)))
    assert band is not None
    return band


def rational(matrix):
    return [[exact(entry) for entry in row] for row in matrix]


def test_two_columns_by_hand():
    """A = [[4, 2], [2, 3]] has D = (4, 2) and L_21 = 1/2."""
    band, low = np.array([[4.0, 2.0], [3.0, 0.0]]), np.zeros((2, 2))
    assert words.factorise(band, low, 0, 2) == 0
    assert band.tolist() == [[4.0, 0.5], [2.0, 0.0]]
    assert not low.any()
    force, force_low = np.array([8.0, 6.0]), np.zeros(2)
    words.forwards(band, low, force, force_low, 0, 2)
    assert force.tolist() == [8.0, 2.0]
    words.backwards(band, low, force, force_low, 0, 2)
    assert force.tolist() == [1.5, 1.0]
    total, total_low = np.array([-8.0, -6.0]), np.zeros(2)
    words.add_product(np.array([[4.0, 2.0], [3.0, 0.0]]), force, force_low, total, total_low, 0, 2)
    assert not total.any()


@pytest.mark.parametrize("size", [1, 2, 3, 7, 12])
@pytest.mark.parametrize("width", [0, 1, 2, 5, 8])
def test_a_solution_has_twice_as_many_digits(size, width):
    rng = np.random.default_rng([size, width])
    matrix = banded(rng, size, min(width, size - 1))
    force = rng.normal(size=size)
    band = Band(sparse.csr_array(matrix))
    high, low = (part[band.place] for part in narrow(matrix).factors().solve(band.inwards(force)))
    for row, right in zip(rational(matrix), force, strict=True):
        left = sum((entry * exact(*x) for entry, x in zip(row, zip(high, low, strict=True), strict=True)), Fraction(0))
        assert abs(left - exact(right)) < 1e-28
    product, product_low = narrow(matrix).product(band.inwards(high), band.inwards(low), band.inwards(-force))
    assert np.abs(product).max() < 1e-28
    assert np.abs(product_low).max() < 1e-28


def test_held_rows_are_those_of_a_unit_matrix():
    rng = np.random.default_rng(1)
    matrix = banded(rng, 9, 3)
    held = np.array([0, 1, 0, 0, 1, 1, 0, 0, 1], dtype=bool)
    force = np.where(held, 0.0, rng.normal(size=9))
    band = NarrowBand(np.array([[matrix[min(j + d, 8), j] * (j + d < 9) for d in range(4)] for j in range(9)]))
    springs = rng.uniform(size=9)
    found, _ = band.factors(springs, held).solve(force)
    assert not found[held].any()
    free = ~held
    part = (matrix + np.diag(springs))[np.ix_(free, free)]
    np.testing.assert_allclose(part @ found[free], force[free], atol=1e-13)
    assert band.diagonal().tolist() == matrix.diagonal().tolist()


@pytest.mark.parametrize("seed", range(40))
def test_a_proven_eigenvalue_is_below_the_smallest_one(seed):
    """A - λ is positive definite in rational numbers, however near to singular A is."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(2, 12))
    width = int(rng.integers(1, min(size, WIDEST + 1)))
    matrix = banded(rng, size, width, 0.0)
    matrix += 2.0 ** -int(rng.integers(5, 40)) * np.eye(size)
    if seed % 2:  # a row that is, but for little, the difference of two others
        matrix[-1] = matrix[:, -1] = 0.0
        matrix[-1, -1] = matrix[0, 0]
        matrix[0, -1] = matrix[-1, 0] = matrix[0, 0] * (1 - 2.0 ** -int(rng.integers(20, 50)))
    band = NarrowBand.of(Band(sparse.csr_array(matrix)))
    factors = None if band is None else band.factors()
    if factors is None:
        assert band is None or not is_positive_definite(rational(matrix))
        return
    estimate = factors.estimated_least_eigenvalue()
    for part in (0.5, 0.999, 1 - 1e-9, 1 + 1e-9, 1.01, 2.0):
        bound = band.proven_least_eigenvalue(part * estimate)
        shifted = rational(matrix)
        for i, row in enumerate(shifted):
            row[i] -= exact(bound)
        assert is_positive_definite(shifted)
        assert bound == pytest.approx(part * estimate, rel=1e-10) if part < 0.9 else bound <= part * estimate


def test_what_double_precision_takes_for_singular_has_a_proven_eigenvalue():
    """A beam of 20,000 nodes, rows 1, -4, 6, -4, 1: its smallest eigenvalue is 4(1 - cos(π/(n + 1)))²."""
    size = 20_000
    rows = [np.full(size - abs(k), entry) for k, entry in zip(range(-2, 3), (1.0, -4.0, 6.0, -4.0, 1.0), strict=True)]
    rows[2][[0, -1]] = 5.0
    band = Band((sparse.diags_array(rows, offsets=[-2, -1, 0, 1, 2]) / 8).tocsr())
    least = 16 * np.sin(np.pi / (2 * (size + 1))) ** 4 / 8
    stiff = stiff_band(band)
    assert stiff.factors().estimated_least_eigenvalue() == pytest.approx(least, rel=1e-9)
    assert 0.99 * least < stiff.proven_least_eigenvalue(0.999 * least) < least
    assert stiff.proven_least_eigenvalue(1.001 * least) == 0.0
    assert band.proven_least_eigenvalue(0.9 * least) == 0.0


def test_double_precision_is_enough_for_a_short_beam_or_a_wide_band():
    rng = np.random.default_rng(0)
    assert stiff_band(Band(sparse.csr_array(banded(rng, 40, 3)))) is None
    wide = sparse.csr_array(banded(rng, 60, WIDEST + 2))
    assert stiff_band(Band(wide)) is None
    assert NarrowBand.of(Band(wide)) is None


def test_tiny_entries_neither_underflow_nor_spoil_the_proof():
    matrix = np.array([[1.0, 1e-200, 0.0], [1e-200, 1e-30, 1e-310], [0.0, 1e-310, 1.0]])
    bound = narrow(matrix).proven_least_eigenvalue(0.9e-30)
    assert 0 <= bound < 1e-30
    assert narrow(matrix).proven_least_eigenvalue(1.1e-30) == 0.0


def test_without_a_compiler_there_is_no_narrow_band(monkeypatch):
    monkeypatch.setattr("contactqp.algebra.narrow_band.can_compile", lambda: False)
    assert NarrowBand.of(Band(sparse.csr_array(np.eye(3)))) is None
