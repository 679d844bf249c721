"""The equations of free nodes: checked, refined, by the next method where one fails, and made ready once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactqp as cq
from contactqp.algebra.nonsymmetric import NonsymmetricStiffness
from contactqp.algebra.sparse import SparseStiffness
from contactqp.algebra.stencil import Stencil
from contactqp.methods import free_system, linear
from contactqp.methods.free_system import FreeSystem


@given(st.integers(0, 10_000), st.integers(1, 9), st.booleans())
def test_it_solves_for_the_free_nodes_and_holds_the_others(seed, size, transposed):
    rng = np.random.default_rng(seed)
    beside = -rng.uniform(0, 1, (size, size)) * (1 - np.eye(size))
    matrix = beside + np.diag(0.1 - beside.sum(axis=1))
    free, force = rng.uniform(size=size) < 0.7, rng.normal(size=size)
    found = FreeSystem(NonsymmetricStiffness.of(matrix), free).solve(force, transposed=transposed)
    one = (matrix.T if transposed else matrix)[np.ix_(free, free)]
    np.testing.assert_array_equal(found[~free], 0.0)
    np.testing.assert_allclose(found[free], np.linalg.solve(one, force[free]), rtol=1e-9, atol=1e-12)


def left_over(stiffness, found, force):
    return np.abs(stiffness.matvec(found) - force).max() / np.abs(force).max()


def test_where_multigrid_fails_another_method_follows(monkeypatch):
    """A method that leaves all out of balance is no more asked, for the next force either."""
    asked = []

    def failing(force):
        asked.append(force.size)
        return np.zeros_like(force)

    monkeypatch.setattr(free_system, "solver", lambda stiffness, tolerance: (failing, False))
    stencil = Stencil(np.ones((20, 30), dtype=bool), 1.0, 2.0)
    system = FreeSystem(stencil, np.ones(stencil.size, dtype=bool))
    for force in (np.ones(stencil.size), np.arange(stencil.size) % 7.0):
        assert left_over(stencil, system.solve(force), force) < 1e-11
    assert asked == [600, 600]  # the solution, and a refinement that does not help


def test_poor_solutions_are_refined(monkeypatch):
    """A solver that is right to a thousandth is good enough, if it is asked again with what it has left."""
    matrix = np.diag([2.0, 3.0, 4.0]) - np.diag([1.0, 1.0], 1) - np.diag([1.0, 1.0], -1)
    asked = []

    def poor(stiffness, tolerance):
        def solve(force):
            asked.append(force)
            return np.linalg.solve(matrix, force) * 1.001

        return solve, False

    monkeypatch.setattr(free_system, "solver", poor)
    system = FreeSystem(SparseStiffness.of(matrix), np.ones(3, dtype=bool))
    np.testing.assert_allclose(system.solve(np.ones(3)), np.linalg.solve(matrix, np.ones(3)), rtol=1e-11)
    assert 3 <= len(asked) <= 6


def test_what_no_method_solves_is_refused_in_words(monkeypatch):
    singular = SparseStiffness.of([[1.0, -1.0], [-1.0, 1.0]])
    with pytest.raises(ValueError, match="the matrix of 2 free nodes is singular in double precision"):
        FreeSystem(singular, np.ones(2, dtype=bool)).solve(np.array([1.0, 1.0]))
    monkeypatch.setattr(free_system, "solver", lambda stiffness, tolerance: (np.zeros_like, False))
    monkeypatch.setattr(free_system, "factorised", lambda matrix, **more: None)
    sound = SparseStiffness.of([[2.0, -1.0], [-1.0, 2.0]])
    with pytest.raises(ValueError, match=r"equations of 2 free nodes are too ill-conditioned: .* times what rounding"):
        FreeSystem(sound, np.ones(2, dtype=bool)).solve(np.array([1.0, 1.0]))


def test_factors_are_made_once_for_a_contact_set(monkeypatch):
    made = []
    original = linear.solver

    def counting(stiffness, tolerance):
        made.append(stiffness.size)
        return original(stiffness, tolerance)

    monkeypatch.setattr(free_system, "solver", counting)
    session = cq.Solver(cq.Cable(nodes=19, spacing=0.5, tension=1.0, load=1.0, support=3.0), tol=1e-10)
    first, second = session.solve(), session.solve(load=1.0001)
    assert (first.contact == second.contact).all()
    for solution in (first, second):
        sensitivity = solution.sensitivity()
        sensitivity.forward(load=1.0)
        sensitivity.forward(support=1.0)
        sensitivity.adjoint(gap=1.0)
    assert made == [np.count_nonzero(~first.contact)]
    session.solve(load=2.0).sensitivity().forward(load=1.0)
    assert len(made) == 2
