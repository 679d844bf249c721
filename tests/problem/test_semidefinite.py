"""Problems whose matrix is semidefinite, and whose kernel contact must hold."""

import pickle
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from rational import _with_held_nodes, adversarial_answer, assert_certificate_holds, exact_matrix, shares
from scipy import sparse

import contactqp as cq

METHODS = ("active-set", "osqp", "clarabel", "psor", "mangasarian")


def exact_solution(problem):
    """Return gap and reaction of a solution in rational numbers, trying every contact set that holds the kernel."""
    matrix, q = exact_matrix(problem), [Fraction(float(force)) for force in problem.q]
    size = problem.size
    bounds = {-1: problem.lower, 1: problem.upper}
    choices = [(0, *(state for state in (-1, 1) if np.isfinite(bounds[state][i]))) for i in range(size)]
    for pattern in product(*choices):
        held = {i: Fraction(float(bounds[state][i])) for i, state in enumerate(pattern) if state}
        try:
            gap = _with_held_nodes(matrix, q, held)
        except ZeroDivisionError:
            continue
        reaction = [sum(a * b for a, b in zip(row, gap, strict=True)) + f for row, f in zip(matrix, q, strict=True)]
        between = all(problem.lower[i] <= gap[i] <= problem.upper[i] for i in range(size))
        if between and all(-state * reaction[i] >= 0 for i, state in enumerate(pattern) if state):
            return gap, reaction
    raise AssertionError("forces that press on the bounds have a solution")


def laplacian(rng, size):
    """Return the matrix of a connected graph with exact row sums of zero."""
    weights = np.triu(rng.integers(0, 8, (size, size)) / 8.0, 1)
    weights[np.arange(size - 1), np.arange(1, size)] += rng.choice([1.0, 2.0**-10])
    weights += weights.T
    return np.diag(weights.sum(axis=1)) - weights


def with_kernel(rng, size, count):
    """Return an integer matrix that is semidefinite, and its kernel of one or two integer vectors."""
    kernel = rng.integers(1, 4, (size, count)).astype(float) * rng.choice([-1, 1], (size, count))
    if rng.uniform() < 0.5:
        kernel[:, 0] = 1.0
    matrix = np.zeros((size, size))
    for chosen in product(range(size), repeat=count + 1):
        if len(set(chosen)) == count + 1:
            vector, part = np.zeros(size), kernel[list(chosen)]
            if count == 1:
                vector[list(chosen)] = part[1, 0], -part[0, 0]
            else:
                vector[list(chosen)] = np.cross(part[:, 0], part[:, 1])
            matrix += rng.integers(0, 3) * np.outer(vector, vector)
    return matrix, kernel


def posed(rng, matrix, kernel, two_sided=None):
    """Return a problem whose forces press on some bounds; None if they happen not to hold the kernel."""
    size = len(matrix)
    gap = rng.integers(0, 9, size) / 4.0
    state = rng.integers(-1, 2 if two_sided else 1, size)
    lower = np.where(state < 0, gap, gap - rng.integers(1, 9, size) / 8)
    upper = np.where(state > 0, gap, gap + rng.integers(1, 9, size) / 8) if two_sided else np.inf
    press = -state * rng.integers(0, 9, size) / 8 * 2.0 ** rng.choice([0, -20, -40])
    q = press - matrix @ gap
    try:
        return cq.ContactQP(matrix, q, lower, upper, kernel=kernel)
    except ValueError:
        return None


@pytest.mark.slow
@pytest.mark.parametrize("share", shares(10))
def test_no_claim_is_violated_in_rational_arithmetic(share):
    proven = cases = 0
    kinds = set()
    for case in range(share, 3000, 10):
        rng = np.random.default_rng([2041, case])
        size = int(rng.integers(2, 6))
        if rng.uniform() < 0.5:
            matrix, kernel = laplacian(rng, size), "constant"
        else:
            matrix, kernel = with_kernel(rng, size, 1 if size < 4 else int(rng.integers(1, 3)))
        problem = posed(rng, matrix, kernel, two_sided=rng.uniform() < 0.4)
        if problem is None:
            continue
        gap, reaction = exact_solution(problem)
        held = np.array([force != 0 for force in reaction])
        solved = cq.solve(problem, "active-set", on_failure="ignore")
        unique = problem.kernel.held_by(held)
        for answer in (solved.gap, adversarial_answer(rng, problem, gap)):
            for effort in ("fast", "sharp"):
                try:
                    certificate = cq.certify(problem, answer, effort=effort)
                except cq.UnsuitableProblemError:
                    continue
                assert unique
                assert_certificate_holds(certificate, gap, reaction, answer)
                kinds.add(certificate.barrier)
        cases, proven = cases + unique, proven + (unique and solved.status is cq.Status.CERTIFIED)
    assert cases > 100
    assert proven >= 0.93 * cases  # reactions of 1e-13 prove nothing beyond M-matrices
    assert {"linear solve", "smallest eigenvalue"} <= kinds


@pytest.mark.parametrize("name", METHODS)
def test_every_method_solves_a_ring(name):
    for case in range(10):
        rng = np.random.default_rng([2042, case])
        size = int(rng.integers(3, 9))
        ring = 2 * np.eye(size) - np.roll(np.eye(size), 1, 0) - np.roll(np.eye(size), -1, 0)
        q = rng.normal(size=size)
        problem = cq.ContactQP(ring, q - q.mean() + 0.3, kernel="constant")
        gap, _ = exact_solution(problem)
        solution = cq.solve(problem, name, tol=1e-7)
        assert solution.status is cq.Status.CERTIFIED, solution
        np.testing.assert_allclose(solution.gap, np.array(gap, dtype=float), atol=1e-6 * problem.gap_scale)
        assert solution.reaction.sum() == pytest.approx(0.3 * size, rel=1e-5)
        low, high = solution.total_reaction
        assert low <= q.size * 0.3 + 1e-12
        assert high >= q.size * 0.3 - 1e-12


def torus(size):
    """Return the five-point matrix of a periodic lattice."""
    ring = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(size, size)).tolil()
    ring[0, -1] = ring[-1, 0] = -1.0
    ring, one = ring.tocsr(), sparse.eye_array(size)
    return (sparse.kron(ring, one) + sparse.kron(one, ring)).tocsr()


@pytest.mark.parametrize("size", [16, 40, 90])
def test_a_rough_periodic_surface_is_certified(size):
    """A membrane without a frame rests on a rough surface that repeats itself."""
    rng = np.random.default_rng(size)
    x = 2 * np.pi * np.arange(size) / size
    rough = sum(
        np.cos(k * x[:, None] + m * x[None, :] + 7 * rng.uniform()) / (k * k + m * m)
        for k in range(1, 4)
        for m in range(3)
    ).ravel()
    problem = cq.ContactQP(torus(size), np.full(size**2, 0.05 / size), lower=rough, kernel="constant")
    solution = cq.solve(problem, tol=1e-8)
    assert solution.status is cq.Status.CERTIFIED, solution
    certificate = cq.certify(problem, solution.gap)
    assert certificate.contact.any()
    assert certificate.clear.any()
    assert certificate.undecided.sum() <= 2
    assert solution.reaction.sum() == pytest.approx(0.05 * size, rel=1e-6)
    assert "active-set" in solution.backend
    assert "kernel" in solution.note


def test_a_point_load_between_two_posts_has_the_exact_shape():
    """A free chain on a floor, pulled up in the middle by F, its ends pressed by more: its flanks are straight."""
    size, pull = 21, 1.0
    matrix = np.diag(np.r_[1.0, np.full(size - 2, 2.0), 1.0]) - np.eye(size, k=1) - np.eye(size, k=-1)
    q = np.zeros(size)
    q[size // 2], q[0], q[-1] = -pull, 1.0, 1.5
    solution = cq.solve(cq.ContactQP(matrix, q, kernel="constant"), tol=1e-12)
    np.testing.assert_allclose(solution.gap, pull / 2 * np.minimum(np.arange(size), np.arange(size)[::-1]), atol=1e-11)
    np.testing.assert_allclose(solution.reaction[[0, -1]], [0.5, 1.0], atol=1e-12)
    assert solution.status is cq.Status.CERTIFIED


def free_beam(size):
    """Return the matrix of a beam with free ends, the sum of its squared second differences."""
    bend = np.diff(np.eye(size), 2, axis=0)
    return bend.T @ bend


@pytest.mark.parametrize("name", ["active-set", "clarabel"])
def test_a_free_beam_on_a_floor_is_held_by_two_supports(name):
    size = 31
    rigid = np.column_stack([np.ones(size), np.arange(size)])
    q = np.full(size, 0.01)
    q[size // 2] -= 0.2
    problem = cq.ContactQP(free_beam(size), q, kernel=rigid)
    solution = cq.solve(problem, name, tol=1e-6)
    assert solution.status is cq.Status.CERTIFIED, solution
    np.testing.assert_allclose(rigid.T @ solution.reaction, rigid.T @ q, atol=1e-6)
    assert solution.certificate.least_eigenvalue is not None
    assert "smallest eigenvalue" in repr(solution.certificate)


def test_parts_that_are_not_joined_have_a_kernel_vector_each():
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    matrix, q = np.kron(np.eye(2), pair), [-1.0, 2.0, 3.0, -2.0]
    indicators = np.kron(np.eye(2), np.ones((2, 1)))
    solution = cq.solve(cq.ContactQP(matrix, q, kernel=indicators))
    assert solution.status is cq.Status.CERTIFIED
    np.testing.assert_allclose(solution.gap, [1.0, 0.0, 0.0, 2.0], atol=1e-12)
    with pytest.raises(ValueError, match="fall into 2 parts, each with a kernel of its own"):
        cq.ContactQP(matrix, q, kernel="constant")
    with pytest.raises(ValueError, match=r"k = kernel @ \[0, 1\], is -0.5: nothing holds the gap back"):
        cq.ContactQP(matrix, [-1.0, 2.0, 1.5, -2.0], kernel=indicators)


def test_upper_bounds_may_hold_the_kernel():
    ring = 2 * np.eye(4) - np.roll(np.eye(4), 1, 0) - np.roll(np.eye(4), -1, 0)
    q = np.array([-2.0, 0.5, -1.0, 0.3])
    for lower in (-np.inf, -3.0):
        solution = cq.solve(cq.ContactQP(ring, q, lower, 1.0, kernel="constant"))
        assert solution.status is cq.Status.CERTIFIED
        assert solution.contact_upper.any()
        assert solution.reaction.sum() == pytest.approx(q.sum())
    with pytest.raises(ValueError, match=r"k = -ones, is -2.2"):
        cq.ContactQP(ring, -q, -np.inf, 1.0, kernel="constant")


# What is refused, and what it says.

RING = 2 * np.eye(4) - np.roll(np.eye(4), 1, 0) - np.roll(np.eye(4), -1, 0)
PRESSED = np.array([-1.0, 0.0, 2.0, 0.0])


@pytest.mark.parametrize(
    ("q", "words"),
    [
        ([-1.0, 0.0, 0.5, 0.0], r"the sum of q is -0.5: nothing holds the gap back.*a force of more than 0.5"),
        ([-1.0, 0.0, 1.0, 0.0], r"the sum of q is 0 \(to rounding\): the gap is determined but for a multiple of it"),
        ([-0.1, -0.2, 0.3, 0.0], r"the sum of q is 0 \(to rounding\)"),
    ],
)
def test_forces_that_nothing_balances_are_refused(q, words):
    with pytest.raises(ValueError, match=words):
        cq.ContactQP(RING, q, kernel="constant")
    problem = cq.ContactQP(RING, PRESSED, kernel="constant")
    with pytest.raises(ValueError, match=words):
        problem.with_forces(q)
    with pytest.raises(ValueError, match=words):
        cq.Solver(problem).solve(q=q)


@pytest.mark.parametrize(
    ("matrix", "kernel", "words"),
    [
        (
            RING + np.diag([0.5, 0, 0, 0]),
            "constant",
            r"for the constant \(row sums\) \(G k\)\[0\] = 0.5; leave kernel out",
        ),
        (RING, [1.0, 1.0, 2.0, 1.0], r"for kernel\[:, 0\] \(G k\)\[2\] = 2"),
        (RING, np.ones((4, 2)), "linearly independent columns, but its 2 columns span less"),
        (RING, np.zeros(4), "linearly independent"),
        (RING, np.ones(3), r"kernel must be 'constant' or have shape \(4,\) or \(4, m\), got \(3,\)"),
        (RING, "constants", "kernel must be 'constant', or vectors"),
        (RING, [1.0, np.nan, 1.0, 1.0], r"kernel must be finite, but entry \[1, 0\] is nan"),
        (RING @ RING, "constant", None),
        (RING - 0.9 * np.array([[1, -1, 1, -1]] * 4) * np.array([[1], [-1], [1], [-1]]), "constant", None),
    ],
)
def test_kernels_are_checked(matrix, kernel, words):
    if words is None:
        assert "kernel" in repr(cq.ContactQP(matrix, PRESSED, kernel=kernel))
        return
    with pytest.raises(ValueError, match=words):
        cq.ContactQP(matrix, PRESSED, kernel=kernel)


def test_indefinite_matrices_are_refused():
    alternating = np.array([1.0, -1.0, 1.0, -1.0])
    with pytest.raises(ValueError, match="G must be positive semidefinite and have no other kernel than the one given"):
        cq.ContactQP(RING - 1.2 * np.outer(alternating, alternating), PRESSED, kernel="constant")
    with pytest.raises(ValueError, match="pass kernel="):
        cq.ContactQP(RING, PRESSED)


def test_a_lattice_with_a_frame_has_no_kernel():
    with pytest.raises(ValueError, match=r"kernel must consist of vectors k with G k = 0"):
        cq.ContactQP(cq.Stencil(np.ones((2, 2), dtype=bool), 1.0, 1.0), np.ones(4), kernel="constant")


def test_a_lattice_with_a_soft_frame_has_no_kernel_but_its_matrix_may_have():
    """As a lattice G consists of exact sums of arms, which the matrix with springs would round: bounds were false."""
    rng = np.random.default_rng(0)
    arms = rng.uniform(0.1, 1, (1, 13))
    arms[0, 0], arms[0, -1] = 1e-14, 0.0
    stencil = cq.Stencil(np.ones((1, 12), dtype=bool), arms, np.zeros((2, 12)))
    q = rng.normal(size=12)
    q[0] += 3 - q.sum()
    with pytest.raises(ValueError, match=r"ends? on the frame.*pass the matrix, stencil.tocsr\(\)"):
        cq.ContactQP(stencil, q, kernel="constant")
    problem = cq.ContactQP(stencil.tocsr(), q, kernel="constant")
    certificate = cq.certify(problem, cq.solve(problem).gap)
    held = dict.fromkeys(np.flatnonzero(certificate.contact).tolist(), Fraction(0))
    exact = _with_held_nodes(exact_matrix(problem), [Fraction(float(force)) for force in q], held)
    for lower, gap, upper in zip(certificate.lower, exact, certificate.upper, strict=True):
        assert Fraction(float(lower)) <= gap <= Fraction(float(upper))


@pytest.mark.parametrize("shift", [2.0**-39, -(2.0**-39)])
def test_a_kernel_that_rounding_has_spoilt_certifies_nothing_where_it_holds_the_gap(shift):
    """Row sums of 2e-12 count as zero; where the forces along the kernel are as small, another solution is near.

    With the rows short by 2⁻³⁹ and nodes 1 and 3 pressed by 2⁻³⁶ in all, (5/2, 2, 3/2, 2) solves it as well.
    """
    ring = 2 * np.eye(4) - np.roll(np.eye(4), 1, axis=0) - np.roll(np.eye(4), -1, axis=0)
    weak = cq.ContactQP(ring - shift * np.eye(4), [-1.0, 0.0, 1.0 + 2.0**-36, 0.0], kernel="constant")
    for gap in ([1.0, 0.5, 0.0, 0.5], cq.solve(weak, on_failure="ignore").gap):
        with pytest.raises(ValueError, match="rounding leaves"):
            cq.certify(weak, gap)
    other = np.linalg.solve(weak.G.toarray(), -weak.q)
    if shift > 0:
        assert (other > 0).all()
        assert other.max() < 3
    strong = cq.ContactQP(ring - shift * np.eye(4), [-1.0, 0.0, 1.1, 0.0], kernel="constant")
    assert cq.solve(strong).status == "certified"
    exact = cq.ContactQP(ring, [-1.0, 0.0, 1.0 + 2.0**-36, 0.0], kernel="constant")
    assert cq.solve(exact).status == "certified"


def test_it_tells_what_it_is_and_can_be_pickled():
    problem = cq.ContactQP(RING, PRESSED, kernel="constant")
    assert repr(problem) == "ContactQP(4 unknowns, 12 nonzeros, singular M-matrix, kernel: constant)"
    again = pickle.loads(pickle.dumps(problem))
    np.testing.assert_array_equal(cq.solve(again).gap, cq.solve(problem).gap)
    assert not problem.is_m_matrix
    comparison = cq.compare(problem)
    assert [row.backend for row in comparison.rows] == ["osqp", "clarabel", "mangasarian", "psor", "active-set"]
    assert comparison.agree, comparison
    with pytest.raises(cq.UnsuitableProblemError, match="a positive definite matrix, but G was given with a kernel"):
        cq.solve(problem, "multigrid")


def test_scale_and_units_do_not_matter():
    for unit in (1e-9, 1.0, 1e9):
        for force in (1e-9, 1.0, 1e9):
            problem = cq.ContactQP(RING * force / unit, PRESSED * force, kernel="constant")
            solution = cq.solve(problem, tol=1e-9)
            assert solution.status is cq.Status.CERTIFIED
            np.testing.assert_allclose(solution.gap / unit, [1.0, 0.5, 0.0, 0.5], rtol=1e-9, atol=1e-9)


def test_a_shut_problem_is_its_own_solution():
    solution = cq.solve(cq.ContactQP(RING, np.full(4, 0.5), kernel="constant"))
    assert solution.status is cq.Status.CERTIFIED
    assert not solution.gap.any()


def test_row_sums_that_are_zero_to_rounding_count_as_zero():
    matrix = RING * 0.1
    matrix[0, 0] = 0.1 + 0.1 + 1e-17
    weights = np.random.default_rng(0).uniform(size=(30, 30))
    weights = np.triu(weights, 1) + np.triu(weights, 1).T
    graph = np.diag(weights.sum(axis=1)) - weights
    q = np.random.default_rng(1).normal(size=30)
    solution = cq.solve(cq.ContactQP(graph, q - q.mean() + 0.1, kernel="constant"), tol=1e-10)
    assert solution.status is cq.Status.CERTIFIED


def test_the_energy_is_bracketed_from_above_alone():
    problem = cq.ContactQP(RING, PRESSED, kernel="constant")
    solution = cq.solve(problem)
    low, high = cq.energy_bracket(problem, solution.gap)
    assert low == -np.inf
    assert high == pytest.approx(cq.potential_energy(problem, solution.gap))
    with pytest.raises(ValueError, match="is singular"):
        cq.complementary_energy(problem, solution.reaction)
