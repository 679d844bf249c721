import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from meshes import scattered
from scipy import ndimage, sparse
from strategies import lattice_masks, m_matrices, problems

import contactqp as cq
from contactqp.algebra.sparse import SparseStiffness
from contactqp.algebra.stencil import Stencil
from contactqp.problem import barrier as barriers
from contactqp.problem.barrier import find_barrier

NOT_Z = np.array([[1.0, 2.0], [2.0, 5.0]])


def test_every_way_to_give_the_matrix_gives_the_same_problem():
    dense = np.array([[2.0, -1.0], [-1.0, 2.0]])
    forms = [dense, dense.tolist(), sparse.csr_array(dense), sparse.csc_matrix(dense), sparse.coo_array(dense)]
    for form in forms:
        np.testing.assert_array_equal(cq.ContactQP(form, [1, -1]).G.toarray(), dense)


def test_integers_are_taken_and_inputs_are_not_modified():
    matrix, q = sparse.csr_array(np.array([[2, -1], [-1, 2]])), np.array([1, -1])
    problem = cq.ContactQP(matrix, q)
    assert problem.q.dtype == np.float64
    assert matrix.dtype.kind == "i"
    assert q.dtype.kind == "i"
    q[0] = 99
    assert problem.q[0] == 1.0


def test_rounding_asymmetry_is_averaged_away():
    matrix = np.array([[2.0, -1.0], [-1.0 - 1e-15, 2.0]])
    problem = cq.ContactQP(matrix, [0.0, 0.0])
    assert problem.G[0, 1] == problem.G[1, 0]


@pytest.mark.parametrize(
    ("matrix", "q", "error", "message"),
    [
        (np.eye(2), [1.0], ValueError, r"q must have shape \(2,\), got \(1,\)"),
        (np.eye(2), [[1.0], [2.0]], ValueError, r"q must have shape \(2,\), got \(2, 1\)"),
        (np.eye(2), [1.0, np.nan], ValueError, "q must be finite, but entry 1 is nan"),
        (np.eye(2), [1.0, 1j], TypeError, "q must be real, got complex"),
        (np.eye(2) * 1j, [1.0, 1.0], TypeError, "G must be real, got complex"),
        (sparse.eye_array(2, dtype=complex), [1.0, 1.0], TypeError, "G must hold real numbers, got dtype complex"),
        (np.ones((2, 3)), [1.0, 1.0], ValueError, r"G must be square, got shape \(2, 3\)"),
        (sparse.coo_array([1.0, 2.0]), [1.0, 1.0], ValueError, r"G must be a square matrix, got shape \(2,\)"),
        (np.eye(2), np.ma.masked_array([1.0, 2.0], [True, False]), ValueError, "q has masked entries"),
        (np.ones(4), [1.0, 1.0], ValueError, r"G must be a square matrix, got shape \(4,\)"),
        (np.zeros((0, 0)), [], ValueError, r"at least one row"),
        (np.array([[1.0, np.inf], [np.inf, 1.0]]), [1.0, 1.0], ValueError, r"G must be finite, but G\[0, 1\] is inf"),
        (
            np.array([[2.0, -1.0], [0.0, 2.0]]),
            [1.0, 1.0],
            ValueError,
            r"G must be symmetric, but G\[.*pass \(G \+ G.T\)",
        ),
        (np.diag([1.0, -3.0]), [1.0, 1.0], ValueError, r"G must be positive definite, but G\[1, 1\] is -3"),
        (np.diag([1.0, 0.0]), [1.0, 1.0], ValueError, r"G must be positive definite, but G\[1, 1\] is 0"),
        (np.array([[1.0, 2.0], [2.0, 1.0]]), [1.0, 1.0], ValueError, "not below the geometric mean"),
        (np.array([[1.0, -1.0], [-1.0, 1.0]]), [1.0, 1.0], ValueError, "not below the geometric mean"),
        (
            np.eye(3) - 0.5 * (np.ones((3, 3)) - np.eye(3)),
            np.ones(3),
            ValueError,
            "is singular, or too ill-conditioned",
        ),
        (np.eye(3) - 0.6 * (np.ones((3, 3)) - np.eye(3)), np.ones(3), ValueError, r"factorisation finds 1 pivot"),
    ],
)
def test_bad_problems_say_what_is_wrong(matrix, q, error, message):
    with pytest.raises(error, match=message):
        cq.ContactQP(matrix, q)


def test_a_zero_pivot_is_no_way_around():
    """The factorisation must exchange rows here; eigenvalues -0.24, 2, 2, 4.24."""
    matrix = np.array([[2, 1, 1, -1], [1, 2, 1, 1], [1, 1, 2, -1], [-1, 1, -1, 2]])
    assert np.linalg.eigvalsh(matrix).min() < -0.2
    with pytest.raises(ValueError, match="numerically it is not"):
        cq.ContactQP(matrix, np.zeros(4))


def test_a_hair_of_indefiniteness_is_found_when_the_barrier_is_needed():
    size = 1000
    diagonal = np.full(size, 2 * (1 - 0.4e-14))
    diagonal[0] = 2 * (1 + 2e-10)
    matrix = sparse.diags_array([-np.ones(size - 1), diagonal, -np.ones(size - 1)], offsets=[-1, 0, 1]).tolil()
    matrix[0, size - 1] = matrix[size - 1, 0] = -1.0
    matrix[0, 0] -= 4e-10
    with pytest.raises(ValueError, match="positive definite"):
        cq.solve(cq.ContactQP(matrix.tocsr(), -np.ones(size)), "clarabel")


@pytest.mark.parametrize("scale", [1e-200, 1e200])
def test_extreme_but_sound_matrices_are_taken(scale):
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]) * scale, np.array([-1.0, 3.0]) * scale)
    assert problem.is_m_matrix
    np.testing.assert_allclose(cq.solve(problem, "clarabel").gap, [0.5, 0.0], atol=1e-6)


def test_unknowns_of_mixed_units_are_balanced():
    matrix = 2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    units = np.array([1.0, 1e5, 1e10, 1e-5])
    assert cq.ContactQP(units[:, None] * matrix * units, -units).is_m_matrix


def test_ranges_beyond_double_precision_are_refused():
    with pytest.raises(ValueError, match="too wide for double precision"):
        cq.solve(cq.ContactQP(np.diag([1e200, 1e-160, 1.0]), [-1e150, -1e150, 1.0]), "clarabel")


def test_the_assembled_matrix_cannot_be_changed():
    for problem in (cq.gallery.islands().problem, cq.ContactQP(np.eye(2), [1.0, 1.0])):
        with pytest.raises(ValueError, match="read-only"):
            problem.G.data[:] = 0.0


def test_bad_support_masks_say_what_is_wrong():
    with pytest.raises(TypeError, match="supported must be boolean, got dtype int64"):
        cq.ContactQP(np.eye(2), [1.0, 1.0], supported=[1, 0])
    with pytest.raises(ValueError, match=r"supported must have shape \(2,\), got \(3,\)"):
        cq.ContactQP(np.eye(2), [1.0, 1.0], supported=[True, True, False])
    with pytest.raises(ValueError, match="gap_scale must be > 0"):
        cq.ContactQP(np.eye(2), [1.0, 1.0], gap_scale=0.0)
    with pytest.raises(ValueError, match=r"gap must have shape \(2,\), got \(2, 1\)"):
        cq.ContactQP(np.eye(2), [1.0, 1.0]).reaction(np.ones((2, 1)))


@given(matrix=m_matrices(max_size=7), shift=st.floats(0.0, 3.0))
def test_definiteness_is_what_the_eigenvalues_say(matrix, shift):
    shifted = matrix - shift * np.diag(np.diag(matrix)) * 0.5
    diagonal = np.diag(shifted)
    if (diagonal <= 0).any():
        return
    smallest = np.linalg.eigvalsh(shifted / np.sqrt(np.outer(diagonal, diagonal))).min()
    if abs(smallest) < 1e-9:
        return
    if smallest > 0:
        cq.ContactQP(shifted, np.zeros(len(matrix)))
    else:
        with pytest.raises(ValueError, match="positive definite"):
            cq.ContactQP(shifted, np.zeros(len(matrix)))


def test_z_and_m_matrices_are_verified():
    problem = cq.ContactQP(NOT_Z, [-1.0, -1.0])
    assert not problem.is_z_matrix
    assert not problem.is_m_matrix
    assert problem.positive_off_diagonal == (0, 1, 2.0)
    assert repr(problem) == "ContactQP(2 unknowns, 4 nonzeros, no Z-matrix)"
    tiny_positive = np.array([[2.0, 1e-9], [1e-9, 2.0]])
    assert not cq.ContactQP(tiny_positive, [1.0, 1.0]).is_z_matrix


@given(matrix=m_matrices(max_size=8, spread=4.0))
def test_barriers_of_matrices_are_barriers(matrix):
    found = find_barrier(SparseStiffness(sparse.csr_array(matrix)))
    assert found is not None
    assert found.v.min() > 0
    assert (matrix @ found.v >= found.s * (1 - 1e-12)).all()
    assert found.s.min() > 0


@pytest.mark.parametrize(
    ("mask", "kind"),
    [
        (np.ones((9, 9), dtype=bool), "paraboloid"),
        (np.ones((3, 40), dtype=bool), "strip along x"),
        (np.ones((40, 3), dtype=bool), "strip along y"),
        (np.hypot(*np.mgrid[-9:10, -9:10]) < 9, "paraboloid"),
        (np.array([[True]]), "paraboloid"),
    ],
)
def test_the_barrier_of_a_lattice_is_exact_and_fits_its_shape(mask, kind):
    stencil = Stencil(mask, 1.0, 1.0)
    found = find_barrier(stencil)
    assert found is not None
    assert found.kind == kind
    product = stencil.tocsr() @ found.v
    inside = ndimage.binary_erosion(mask)[mask]
    assert found.v.min() > 0
    assert 0 < found.s.min() <= found.s.max() <= product.min()
    np.testing.assert_allclose(found.s[inside], product[inside], rtol=1e-12)
    assert found.reach >= found.v.max() / found.s.min()


@given(mask=lattice_masks(), across=st.floats(0, 3), along=st.floats(0.1, 3))
def test_parabolas_are_barriers_on_any_lattice(mask, across, along):
    stencil = Stencil(mask, across, along)
    found = find_barrier(stencil)
    assert found is not None
    assert found.v.min() > 0
    assert found.s.min() > 0
    assert (found.s <= stencil.tocsr() @ found.v * (1 + 1e-12)).all()


def test_a_parabola_is_not_trusted_where_arms_vary():
    mask = np.ones((5, 5), dtype=bool)
    rng = np.random.default_rng(3)
    stencil = Stencil(mask, 10.0 ** rng.uniform(-3, 3, (5, 6)), 10.0 ** rng.uniform(-3, 3, (6, 5)))
    found = find_barrier(stencil)
    assert found is not None
    assert found.kind == "linear solve"
    assert (stencil.tocsr() @ found.v > 0).all()


def test_large_matrices_get_their_barrier_by_conjugate_gradients(monkeypatch):
    disk = cq.Membrane(cq.Frame.disk(1.0).lattice(0.025), 1.0, load=1.0, support=1.0)
    matrix, *_ = scattered(disk.problem)
    problem = cq.ContactQP(matrix, np.ones(matrix.shape[0]))
    assert problem.is_m_matrix
    monkeypatch.setattr(barriers, "DIRECT_SIZE", 10**6)
    direct = find_barrier(problem.stiffness)
    assert direct is not None
    np.testing.assert_allclose(problem.barrier.v, direct.v, rtol=0.2)


@given(problem=problems())
def test_scaling_is_undone_exactly_enough(problem):
    scaled, units = problem.scaled()
    if problem.stencil is None:
        assert ((scaled.stiffness.diagonal() >= 0.5) & (scaled.stiffness.diagonal() <= 2)).all()
        assert (np.frexp(units.length / problem.gap_scale)[0] == 0.5).all()
    else:
        np.testing.assert_allclose(scaled.stiffness.diagonal(), 1.0)
    assert scaled.gap_scale == 1.0
    assert scaled.is_m_matrix == problem.is_m_matrix
    rng = np.random.default_rng(0)
    gap = rng.normal(size=problem.size)
    np.testing.assert_allclose(
        scaled.reaction(gap) * units.force, problem.reaction(gap * units.length), rtol=1e-9, atol=1e-12
    )


def test_the_gap_scale_is_a_mean_of_the_gap_and_scales_with_it():
    cable, _ = cq.gallery.cable_on_floor(nodes=59, contact_starts_after=20)
    bare = cq.ContactQP(cable.problem.G, cable.problem.q)
    gap = cq.solve(cable, "clarabel").gap
    assert 0.2 * gap.mean() < bare.gap_scale < 5 * gap.max()
    assert 0.2 * gap.mean() < cable.problem.gap_scale < 5 * gap.max()
    assert cq.ContactQP(cable.problem.G, 1e5 * cable.problem.q).gap_scale == pytest.approx(1e5 * bare.gap_scale)
    assert cq.ContactQP(cable.problem.G, np.zeros(59)).gap_scale == 1.0


def test_forces_at_few_nodes_of_a_band_do_not_make_the_scale_small():
    """A beam on a foundation is clear at its ends alone: the mean of all gaps says nothing of these."""
    size = 4000
    off = -np.ones(size - 1)
    bend = sparse.diags_array([off, np.full(size, 2.0), off], offsets=[-1, 0, 1])
    stiffness = (bend @ bend + sparse.eye_array(size)).tocsr()
    support = 0.3 + 0.2 * np.sin(6 * np.pi * np.arange(1, size + 1) / (size + 1))
    problem = cq.ContactQP(stiffness, 0.5 - stiffness @ support)
    gap = cq.solve(problem, "active-set").gap
    assert np.flatnonzero(gap).tolist() == [0, size - 1]
    assert 0.2 * gap.max() < problem.gap_scale < 5 * gap.max()


def test_without_any_force_the_bounds_are_what_the_gap_scale_is_made_of():
    lifted = 1e-9 * np.array([2.0, 3.0])
    assert cq.ContactQP(np.eye(2), -lifted, lower=lifted).gap_scale == lifted.max()
    narrow = cq.ContactQP(np.eye(2), np.zeros(2), -1e-7, [1e9, 1e-8])
    assert narrow.gap_scale == 1e-8
    assert cq.ContactQP(np.eye(2), np.zeros(2), -np.inf, 0.0).gap_scale == 1.0
    extreme = cq.ContactQP(np.eye(2), np.zeros(2), -1e-200, 1e200)
    assert cq.solve(extreme, "osqp", eps=1e-6).status == "certified"


def test_a_model_of_a_million_nodes_never_assembles_its_matrix(monkeypatch):
    assemble = Stencil.tocsr
    monkeypatch.setattr(Stencil, "tocsr", lambda self: assemble(self) if self.size < 5000 else pytest.fail("assembled"))
    lattice = cq.Lattice.from_mask(np.ones((300, 300), dtype=bool), 1.0)
    problem = cq.Membrane(lattice, 1.0, load=0.1, support=3.0).problem
    cq.certify(problem, np.ones(problem.size), effort="fast")
    cq.certify(problem, np.ones(problem.size))
    assert "90000 unknowns" in repr(problem)
