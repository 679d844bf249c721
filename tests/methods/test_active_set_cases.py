"""The compiled active sets for many load cases, against a twin in plain numpy."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from strategies import bounds, m_matrices

from contactqp.methods.active_set import cases
from contactqp.methods.active_set.cases import CaseSolver

EPS = np.finfo(float).eps


def twin(matrix, q, lower, upper, most=40):
    """Return one case's gap and number of steps, by the same iteration; node order is that of the matrix."""
    size, diagonal, omega = len(q), np.diag(matrix), np.zeros(len(q))
    for step in range(1, most + 1):
        for sweep in range(5):
            for i in range(size) if sweep % 2 == 0 else reversed(range(size)):
                omega[i] = np.clip(omega[i] - (matrix[i] @ omega + q[i]) / diagonal[i], lower[i], upper[i])
        below = omega <= lower
        above = ~below & (omega >= upper)
        free = ~(below | above)
        target = omega.copy()
        for _ in range(2):
            target[free] -= np.linalg.solve(matrix[np.ix_(free, free)], (matrix @ target + q)[free])
        beyond, pulled = 4 * EPS * np.abs(target).max(), 8 * EPS * (diagonal * np.abs(target)).max()
        reaction = matrix @ target + q
        pressed = np.where(below, -reaction, np.where(above, reaction, 0.0)) <= pulled
        if (target >= lower - beyond).all() and (target <= upper + beyond).all() and pressed.all():
            return np.clip(target, lower, upper), step
        way = np.clip(target, lower, upper) - omega
        slope, curvature = way @ (matrix @ omega + q), way @ matrix @ way
        part = 1.0 if slope + curvature <= 0 or curvature <= 0 else max(0.0, -slope / curvature)
        omega = np.clip(omega + part * way, lower, upper)
    return omega, 0


def about_zero(lower, upper):
    """Return bounds that zero lies between."""
    return np.minimum(lower, 0.0), np.maximum(upper, 0.0)


@given(st.data())
def test_it_does_what_its_twin_in_numpy_does(data):
    matrix = data.draw(m_matrices(max_size=10, spread=0.0))
    size = len(matrix)
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    count = int(rng.integers(1, 70))
    lower, upper = about_zero(*data.draw(bounds(size)))
    if rng.uniform() < 0.5:
        lower, upper = np.where(rng.uniform(size=size) < 0.8, 0.0, -np.inf), np.full(size, np.inf)
    forces = rng.normal(size=(count, size))
    solver = CaseSolver(sparse.csr_array(matrix))
    order = solver.order
    ordered = matrix[np.ix_(order, order)]
    gaps, steps = solver.solve(forces, lower, upper)
    for q, gap, taken in zip(forces, gaps, steps, strict=True):
        expected, in_steps = twin(ordered, q[order], lower[order], upper[order])
        np.testing.assert_allclose(gap[order], expected, atol=1e-11 * (1 + np.abs(expected).max()))
        assert abs(taken - in_steps) <= 1  # rounding may decide on which side a node is


def line(size):
    return sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(size, size)).tocsr()


def test_any_portion_and_any_number_of_lanes_gives_the_same(monkeypatch):
    forces = np.random.default_rng(0).normal(size=(75, 30))
    lower, upper = np.zeros(30), np.full(30, 2.0)
    wanted = CaseSolver(line(30)).solve(forces, lower, upper)
    assert (wanted[1] > 0).all()
    for lanes, work in ((1, 1e9), (7, 1e9), (32, 1.0), (64, 1e5)):
        monkeypatch.setattr(cases, "_LANES", lanes)
        monkeypatch.setattr(cases, "_WORK_AT_ONCE", work)
        gaps, steps = CaseSolver(line(30)).solve(forces, lower, upper)
        np.testing.assert_allclose(gaps, wanted[0], atol=1e-13)
        np.testing.assert_array_equal(steps, wanted[1])


def test_threads_share_the_cases(monkeypatch):
    from contactqp.foundation import threads

    forces = np.random.default_rng(0).normal(size=(100, 30))
    wanted = CaseSolver(line(30)).solve(forces, np.zeros(30), np.full(30, np.inf))
    monkeypatch.setattr(threads, "_POINTS_WORTH_A_THREAD", 1)
    monkeypatch.setattr(threads, "_cores", lambda: 3)
    gaps, steps = CaseSolver(line(30)).solve(forces, np.zeros(30), np.full(30, np.inf))
    np.testing.assert_array_equal(gaps, wanted[0])
    np.testing.assert_array_equal(steps, wanted[1])


def test_a_shuffled_matrix_is_put_into_order():
    order = np.random.default_rng(0).permutation(30)
    shuffled = line(30)[order][:, order].tocsr()
    forces = np.random.default_rng(1).normal(size=(5, 30))
    straight, _ = CaseSolver(line(30)).solve(forces, np.zeros(30), np.full(30, np.inf))
    gaps, steps = CaseSolver(shuffled).solve(forces[:, order], np.zeros(30), np.full(30, np.inf))
    assert (steps > 0).all()
    np.testing.assert_allclose(gaps, straight[:, order], atol=1e-12)


def test_a_case_without_an_end_is_left_and_the_others_are_not(monkeypatch):
    monkeypatch.setattr(cases, "_MOST_STEPS", 1)
    forces = np.vstack([np.full(60, -1.0), np.full(60, 1.0), np.full(60, np.nan), np.linspace(-1, 0.6, 60)])
    gaps, steps = CaseSolver(line(60)).solve(forces, np.zeros(60), np.full(60, np.inf))
    assert steps.tolist() == [1, 1, 0, 0]
    assert gaps[1].max() == 0.0


def test_a_singular_matrix_is_left():
    ring = sparse.csr_array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    _, steps = CaseSolver(ring).solve(np.full((4, 3), -1.0), np.zeros(3), np.full(3, np.inf))
    assert (steps == 0).all()


@pytest.mark.parametrize(
    ("size", "count", "asked", "loaded", "worth"),
    [
        (20, 500, 500, False, False),
        (20, 500, 1000, False, True),
        (20, 500, 500, True, True),
        (20, 3, 5000, True, False),
        (1001, 500, 5000, True, False),
    ],
)
def test_when_many_together_are_worth_it(monkeypatch, size, count, asked, loaded, worth):
    monkeypatch.delitem(sys.modules, cases._KERNELS, raising=False)
    if loaded:
        monkeypatch.setitem(sys.modules, cases._KERNELS, cases)
    assert (CaseSolver.of(line(size), count, asked) is not None) is worth


def test_wide_bands_are_not_affordable():
    assert CaseSolver(line(400)).affordable
    assert not CaseSolver(sparse.csr_array(np.eye(400) - 1e-3)).affordable
