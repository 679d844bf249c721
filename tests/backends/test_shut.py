"""Problems that no force opens: every backend answers exactly, and nothing is iterated."""

import numpy as np
import pytest
from strategies import BACKENDS

import contactqp as cq

MATRIX = [[2.0, -1.0], [-1.0, 2.0]]


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_membrane_without_load_on_a_support_at_its_height_is_exact(backend):
    model = cq.Membrane(cq.Frame.disk(1.0).lattice(0.25), tension=1.0, load=0.0, support=0.0)
    solution = cq.solve(model, backend)
    assert solution.status == "certified"
    assert not solution.gap.any()
    assert solution.iterations == 0
    assert solution.relative_bound < 1e-15


@pytest.mark.parametrize("backend", ["osqp", "clarabel", "psor", "active-set"])
def test_the_answer_is_the_admissible_gap_nearest_to_zero(backend):
    shut = cq.ContactQP(MATRIX, [-1.0, -1.0], lower=1.0, upper=4.0)  # R at (1, 1) is 0
    np.testing.assert_array_equal(cq.solve(shut, backend).gap, [1.0, 1.0])
    pressed = cq.ContactQP(MATRIX, [3.0, 0.0], lower=0.0)
    np.testing.assert_array_equal(cq.solve(pressed, backend, tol=1e-12).gap, [0.0, 0.0])


def test_a_matrix_that_is_no_m_matrix_as_well():
    solution = cq.solve(cq.ContactQP(0.1 * np.eye(3) + 0.9, np.ones(3)), "clarabel")
    assert solution.status == "certified"
    assert not solution.gap.any()


def test_a_session_answers_them_too():
    session = cq.Solver(cq.ContactQP(MATRIX, [-1.0, 3.0]), "clarabel")
    assert not session.solve(q=[1.0, 1.0]).gap.any()
    np.testing.assert_allclose(session.solve().gap, [0.5, 0.0], atol=1e-6)


def test_options_are_checked_all_the_same():
    shut = cq.ContactQP(MATRIX, [1.0, 1.0])
    with pytest.raises(ValueError, match="relaxation must lie strictly between 0 and 2"):
        cq.solve(shut, "psor", relaxation=3.0)
    solution = cq.solve(shut, "clarabel", eps=1e-8)
    assert not solution.gap.any()
