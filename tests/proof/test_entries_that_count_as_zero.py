"""Positive off-diagonal entries within rounding: the matrix counts as an M-matrix, and bounds hold for it as it is."""

import numpy as np
import pytest
from rational import adversarial_answer, assert_certificate_holds, exact_solution, m_matrix
from scipy import sparse

import contactqp as cq
from contactqp.proof.enclosure import relaxed


def rotated_square(side, angle=0.3):
    """Return P1's matrix on right-angled triangles in a rotated square: its diagonals' entries are rounding."""
    x, y = np.meshgrid(np.arange(side + 2.0), np.arange(side + 2.0))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    points = np.column_stack([x.ravel(), y.ravel()]) @ turn / (side + 1)
    number = np.arange(points.shape[0]).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    triangles = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])])
    corner = points[triangles]
    edge = np.stack([corner[:, (k + 2) % 3] - corner[:, (k + 1) % 3] for k in range(3)], axis=1)
    area = 0.5 * np.abs(edge[:, 1, 0] * edge[:, 2, 1] - edge[:, 1, 1] * edge[:, 2, 0])
    local = np.einsum("eia,eja->eij", edge, edge) / (4 * area)[:, None, None]
    rows, columns = np.repeat(triangles, 3, axis=1).ravel(), np.tile(triangles, (1, 3)).ravel()
    matrix = sparse.csr_array((local.ravel(), (rows, columns)), shape=(number.size, number.size))
    inner = number[1:-1, 1:-1].ravel()
    return matrix[inner][:, inner], np.full(inner.size, 1.0 / (side + 1) ** 2)


def with_surplus(rng, size, largest):
    """Return a nearly M-matrix with some positive off-diagonal entries of up to ``largest`` of the diagonal."""
    matrix = m_matrix(rng, size)
    root = np.sqrt(np.diag(matrix))
    extra = np.triu(rng.uniform(0, largest, (size, size)) * (rng.uniform(size=(size, size)) < 0.5), 1)
    extra = (extra + extra.T) * root[:, None] * root
    matrix = np.where(extra > 0, extra, matrix)
    # What has become of the rows of a nearly singular matrix is made up for.
    return matrix + np.diag(2 * extra.sum(axis=1))


@pytest.mark.slow
@pytest.mark.parametrize("share", range(3))
@pytest.mark.parametrize("largest", [1e-15, 1e-2])
def test_bounds_hold_in_rational_arithmetic(monkeypatch, share, largest):
    """Entries of a hundredth, which are no rounding, show a gap in the proof that rounding would hide."""
    monkeypatch.setattr("contactqp.algebra.definiteness.NO_MORE_THAN_ROUNDING", 1.1 * largest)
    seen = 0
    for case in range(share, 240, 3):
        rng = np.random.default_rng([47, case])
        matrix = with_surplus(rng, int(rng.integers(2, 6)), largest)
        size = len(matrix)
        upper = np.where(rng.uniform(size=size) < 0.5, 10.0 ** rng.uniform(-2, 2, size), np.inf)
        bounds = {"upper": upper} if rng.uniform() < 0.3 else {}
        problem = cq.ContactQP(matrix, rng.normal(size=size) * 10.0 ** rng.uniform(-3, 3), **bounds)
        if problem.stiffness.surplus is None or not problem.is_m_matrix:
            continue
        seen += 1
        gap, reaction = exact_solution(problem)
        answer = adversarial_answer(rng, problem, gap)
        for effort in ("fast", "sharp"):
            certificate = cq.certify(problem, answer, effort=effort)
            assert not certificate.weaker
            assert_certificate_holds(certificate, gap, reaction, answer)
        if not np.isfinite(certificate.gap_bound):
            continue
        exact = np.array([float(x) for x in gap])
        lower, upper = relaxed(problem, certificate.lower, certificate.upper, sweeps=3)
        assert (lower <= np.nextafter(exact, np.inf)).all()
        assert (upper >= np.nextafter(exact, -np.inf)).all()
    assert seen > 30


def test_right_angles_in_a_rotated_square_are_an_m_matrix():
    matrix, load = rotated_square(30)
    assert matrix.tocoo().data[matrix.tocoo().row != matrix.tocoo().col].max() > 0
    problem = cq.ContactQP(matrix, 4 * load - matrix @ np.full(load.size, 0.1))
    assert problem.is_m_matrix
    assert problem.stiffness.surplus.nnz > 0
    for backend in ("auto", "active-set", "mangasarian", "psor"):
        solution = cq.solve(problem, backend)
        assert solution.status == "certified"
        assert not solution.certificate.weaker
    polished = cq.solve(problem, "active-set", tol=1e-12)
    assert polished.certificate.gap_bound < 1e-14


def test_its_matrix_stays_as_it_was_given():
    matrix, load = rotated_square(5)
    given = matrix.toarray()
    problem = cq.ContactQP(matrix, load)
    np.testing.assert_array_equal(problem.G.toarray(), (given + given.T) / 2)


@pytest.mark.parametrize("value", [1e-17, 1e-15])
def test_entries_beyond_rounding_are_not_zero(value):
    small = cq.ContactQP([[2.0, value], [value, 2.0]], [-1.0, 1.0])
    assert small.is_z_matrix
    large = cq.ContactQP([[2.0, 1e-13], [1e-13, 2.0]], [-1.0, 1.0])
    assert large.positive_off_diagonal == (0, 1, 1e-13)


def test_multigrid_recommends_only_what_accepts_the_problem():
    for off in (1e-17, 0.5, -0.5):
        problem = cq.ContactQP([[2.0, off], [off, 2.0]], [-1.0, 1.0])
        with pytest.raises(cq.UnsuitableProblemError, match="needs a problem on a lattice") as caught:
            cq.solve(problem, "multigrid")
        names = [name for name in cq.backend_names() if f"'{name}'" in str(caught.value).split("; take ")[1]]
        assert names
        for name in names:
            assert cq.solve(problem, name).status == "certified"
