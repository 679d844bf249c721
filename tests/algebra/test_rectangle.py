import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

import contactqp as cq
from contactqp.algebra.rectangle import rectangle_of
from contactqp.algebra.stencil import Stencil


@given(rows=st.integers(1, 6), columns=st.integers(2, 6), seed=st.integers(0, 999), equal=st.booleans())
def test_the_stencil_found_has_the_same_matrix(rows, columns, seed, equal):
    rng = np.random.default_rng(seed)
    arms = (
        (rng.uniform(0.1, 1), rng.uniform(0.1, 1))
        if equal
        else (rng.uniform(0.1, 1, (rows, columns + 1)), rng.uniform(0.1, 1, (rows + 1, columns)))
    )
    matrix = Stencil(np.ones((rows, columns), dtype=bool), *arms).tocsr()
    found = rectangle_of(matrix)
    if rows * columns < 4:
        assert found is None
        return
    assert found is not None
    assert found.uniform == (equal and rows > 1) or (rows, columns) == (2, 2)
    np.testing.assert_allclose(found.tocsr().toarray(), matrix.toarray(), atol=1e-13)


def test_a_line_may_be_grounded_anywhere():
    ground = np.array([0.0, 0.3, 0.0, 0.0, 2.0])
    matrix = sparse.csr_array(np.diag(2.0 + ground) - np.eye(5, k=1) - np.eye(5, k=-1))
    found = rectangle_of(matrix)
    assert found is not None
    np.testing.assert_allclose(found.tocsr().toarray(), matrix.toarray(), atol=1e-13)
    plain = rectangle_of(sparse.csr_array(2 * np.eye(9) - np.eye(9, k=1) - np.eye(9, k=-1)))
    assert plain is not None
    assert plain.uniform


def test_the_usual_assembly_is_recognised():
    rows, columns = (sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)) for n in (20, 30))
    matrix = sparse.csr_array(sparse.kron(sparse.eye_array(20), columns) + sparse.kron(rows, sparse.eye_array(30)))
    found = rectangle_of(matrix)
    assert found is not None
    assert (found.mask.shape, found.uniform) == ((20, 30), True)


@pytest.mark.parametrize("change", ["grounded", "wrapped", "far", "positive"])
def test_other_matrices_are_not(change):
    matrix = Stencil(np.ones((5, 6), dtype=bool), 1.0, 1.0).tocsr().tolil()
    if change == "grounded":
        matrix[14, 14] += 0.1
    elif change == "wrapped":
        matrix[5, 6] = matrix[6, 5] = -0.1
    elif change == "far":
        matrix[0, 8] = matrix[8, 0] = -0.1
    else:
        matrix[0, 1] = matrix[1, 0] = 0.5
    assert rectangle_of(matrix.tocsr()) is None


def test_a_recognised_matrix_gets_a_parabola_for_a_barrier():
    model = cq.gallery.bowl(67)
    problem = cq.ContactQP(model.problem.G, model.problem.q)
    assert problem.barrier.kind == "paraboloid"
    assert (problem.barrier.s <= problem.G @ problem.barrier.v).all()
