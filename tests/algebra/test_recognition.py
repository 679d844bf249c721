from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage, sparse

import contactqp as cq
from contactqp.algebra.recognition import lattice_of
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
    found = lattice_of(matrix)
    if rows * columns < 4:
        assert found is None
        return
    assert found is not None
    assert found.uniform == (equal and rows > 1) or (rows, columns) == (2, 2)
    np.testing.assert_allclose(found.tocsr().toarray(), matrix.toarray(), atol=1e-13)


@given(shape=st.tuples(st.integers(1, 9), st.integers(1, 9)), seed=st.integers(0, 9999), equal=st.booleans())
def test_masks_are_recognised_by_any_lattice_that_has_their_matrix(shape, seed, equal):
    """Nodes at random; those that do not hang together with the first are left out."""
    rng = np.random.default_rng(seed)
    mask, _ = ndimage.label(rng.uniform(size=shape) < 0.75)
    mask = mask == 1
    arms = (
        (1.0, 0.5)
        if equal
        else (rng.uniform(0.1, 1, (shape[0], shape[1] + 1)), rng.uniform(0.1, 1, (shape[0] + 1, shape[1])))
    )
    if not mask.any():
        return
    matrix = Stencil(mask, *arms).tocsr()
    found = lattice_of(matrix)
    if mask.sum() < 4:
        assert found is None
    elif found is None:  # of consecutive numbers, nodes above each other are taken for neighbours in a row
        assert any(alone_above_each_other(mask))
    else:
        np.testing.assert_allclose(found.tocsr().toarray(), matrix.toarray(), atol=1e-13)


def alone_above_each_other(mask):
    """Yield whether the last node of a row lies below the first of the next."""
    for below, above in pairwise(mask):
        yield below.any() and above.any() and np.flatnonzero(below)[-1] == np.flatnonzero(above)[0]


def test_a_disk_is_recognised_as_what_it_is():
    stencil = cq.Membrane(cq.Frame.disk(1.0).lattice(0.02), 1.0, load=8.0, support=0.3).problem.stencil
    found = lattice_of(stencil.tocsr())
    assert found.uniform
    assert (found.mask == stencil.mask[stencil.numbering.box]).all()


def test_a_line_may_be_grounded_anywhere():
    ground = np.array([0.0, 0.3, 0.0, 0.0, 2.0])
    matrix = sparse.csr_array(np.diag(2.0 + ground) - np.eye(5, k=1) - np.eye(5, k=-1))
    found = lattice_of(matrix)
    assert found is not None
    np.testing.assert_allclose(found.tocsr().toarray(), matrix.toarray(), atol=1e-13)
    plain = lattice_of(sparse.csr_array(2 * np.eye(9) - np.eye(9, k=1) - np.eye(9, k=-1)))
    assert plain is not None
    assert plain.uniform


def test_the_usual_assembly_is_recognised():
    rows, columns = (sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)) for n in (20, 30))
    matrix = sparse.csr_array(sparse.kron(sparse.eye_array(20), columns) + sparse.kron(rows, sparse.eye_array(30)))
    found = lattice_of(matrix)
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
    assert lattice_of(matrix.tocsr()) is None


def test_a_recognised_matrix_gets_a_parabola_for_a_barrier():
    model = cq.gallery.bowl(67)
    problem = cq.ContactQP(model.problem.G, model.problem.q)
    assert problem.barrier.kind == "paraboloid"
    assert (problem.barrier.s <= problem.G @ problem.barrier.v).all()
