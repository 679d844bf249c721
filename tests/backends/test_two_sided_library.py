"""Library backends between two bounds: against an enumeration, and the data that they hand over."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import bounds, enumerate_solution, m_matrices

import contactqp as cq
from contactqp.backends import get_backend


@st.composite
def two_sided(draw, max_size=6):
    matrix = draw(m_matrices(max_size=max_size))
    lower, upper = draw(bounds(len(matrix)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return cq.ContactQP(matrix, rng.normal(size=len(matrix)) * np.sqrt(np.diag(matrix)), lower, upper)


@pytest.mark.parametrize("name", ["osqp", "clarabel"])
@given(problem=two_sided())
def test_answers_are_those_of_an_enumeration(name, problem):
    solution = cq.solve(problem, name, tol=1e-8)
    assert solution.status == "certified"
    error = np.abs(solution.gap - enumerate_solution(problem)).max()
    assert error <= solution.certificate.gap_bound * (1 + 1e-6) + 1e-12
    assert error <= 2e-8 * problem.gap_scale + 1e-12


@pytest.mark.parametrize("name", ["osqp", "clarabel"])
@given(problem=two_sided(max_size=4))
def test_a_warm_start_from_outside_of_the_bounds_leads_to_the_same(name, problem):
    start = 10.0 * np.random.default_rng(0).normal(size=problem.size)
    warm = cq.solve(problem, name, tol=1e-8, warm_start=start)
    np.testing.assert_allclose(warm.gap, enumerate_solution(problem), atol=2e-8 * problem.gap_scale + 1e-12)


@given(matrix=m_matrices(max_size=6), seed=st.integers(0, 2**32 - 1))
def test_the_linear_program_takes_any_lower_bounds(matrix, seed):
    rng = np.random.default_rng(seed)
    size = len(matrix)
    lower = np.where(rng.uniform(size=size) < 0.7, rng.normal(size=size), -np.inf)
    problem = cq.ContactQP(matrix, rng.normal(size=size) * np.sqrt(np.diag(matrix)), lower)
    solution = cq.solve(problem, "mangasarian", tol=1e-6)
    assert solution.status == "certified"
    np.testing.assert_allclose(solution.gap, enumerate_solution(problem), atol=2e-6 * problem.gap_scale + 1e-12)


def test_the_linear_program_refuses_upper_bounds_and_says_why():
    """min ω_1 + ω_2 over {ω ≥ 0, Gω + q ≥ 0} is (2, 1) here, above the upper bound of the first unknown."""
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-3.0, 0.0], 0.0, [0.5, np.inf])
    with pytest.raises(cq.UnsuitableProblemError, match=r"without an upper bound .* upper is 0.5 at unknown 0; take "):
        cq.solve(problem, "mangasarian")
    assert "upper bounds" in " ".join(type(get_backend("mangasarian")).__doc__.split())
    np.testing.assert_allclose(cq.solve(problem, "clarabel").gap, [0.5, 0.25], atol=1e-6)


@pytest.fixture
def handed_over(monkeypatch):
    """What OSQP is given: the vectors of set-up and of warm starts."""
    import osqp

    calls: dict[str, list[tuple[object, ...]]] = {"setup": [], "warm_start": []}
    setup, warm_start = osqp.OSQP.setup, osqp.OSQP.warm_start

    def noted_setup(self, P, q, A, l, u, **settings):  # noqa: E741
        calls["setup"].append((q, A, l, u))
        return setup(self, P, q, A, l, u, **settings)

    def noted_warm_start(self, x=None, y=None):
        calls["warm_start"].append((x, y))
        return warm_start(self, x=x, y=y)

    monkeypatch.setattr(osqp.OSQP, "setup", noted_setup)
    monkeypatch.setattr(osqp.OSQP, "warm_start", noted_warm_start)
    return calls


def test_osqp_gets_every_bound_in_its_own_row(handed_over):
    lower, upper = [-np.inf, 0.0, -np.inf, -1.0], [np.inf, np.inf, 2.0, 3.0]
    problem = cq.ContactQP(2.0 * np.eye(4), [-1.0, -1.0, -9.0, 1.0], lower, upper, gap_scale=1.0)
    scaled, _ = problem.scaled()
    cq.solve(problem, "osqp")
    ((_, rows, low, high),) = handed_over["setup"]
    np.testing.assert_array_equal(rows.toarray(), np.eye(4))
    np.testing.assert_array_equal(low, scaled.lower)
    np.testing.assert_array_equal(high, scaled.upper)
    assert handed_over["warm_start"] == []


def test_a_warm_start_of_osqp_is_admissible_and_has_multipliers_of_both_signs(handed_over):
    """Far below, the first unknown presses on its lower bound; far above, the second on its upper one; R = Gω + q."""
    problem = cq.ContactQP(np.eye(3), [4.0, -4.0, -2.0], [0.0, 0.0, -np.inf], [1.0, 1.0, np.inf], gap_scale=1.0)
    cq.solve(problem, "osqp", warm_start=np.array([-7.0, 7.0, 3.0]))
    ((start, multiplier),) = handed_over["warm_start"]
    np.testing.assert_array_equal(start, [0.0, 1.0, 3.0])
    np.testing.assert_array_equal(multiplier, [-4.0, 3.0, 0.0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_osqp_polishes_whichever_bound_presses(sign, capfd):
    """The hexagon upside down: its support is a ceiling."""
    problem = cq.gallery.paper_hexagon().problem
    ends = (0.0, np.inf) if sign > 0 else (-np.inf, 0.0)
    solution = cq.solve(cq.ContactQP(problem.G, sign * problem.q, *ends), "osqp")
    assert solution.status == "certified"
    assert solution.relative_bound < 1e-10
    assert solution.contact_upper.any() == (sign < 0)
    assert capfd.readouterr() == ("", "")


def test_clarabel_gets_a_row_for_every_bound_and_none_else(monkeypatch):
    import clarabel

    calls = []
    original = clarabel.DefaultSolver
    monkeypatch.setattr(clarabel, "DefaultSolver", lambda *data: calls.append(data) or original(*data))
    lower, upper = [-np.inf, 0.0, -np.inf, -1.0, 0.5], [np.inf, np.inf, 2.0, 3.0, 0.5]
    problem = cq.ContactQP(2.0 * np.eye(5), [-1.0, -1.0, -9.0, 1.0, 1.0], lower, upper, gap_scale=1.0)
    scaled, _ = problem.scaled()
    solution = cq.solve(problem, "clarabel", tol=1e-6)
    _, _, rows, limits, cones, _ = calls[0]
    np.testing.assert_array_equal(rows.toarray(), np.eye(5)[[4, 1, 3, 2, 3]] * np.array([[1, -1, -1, 1, 1]]).T)
    np.testing.assert_array_equal(
        limits, [scaled.lower[4], -scaled.lower[1], -scaled.lower[3], scaled.upper[2], scaled.upper[3]]
    )
    assert [(type(cone).__name__, cone.dim) for cone in cones] == [("ZeroConeT", 1), ("NonnegativeConeT", 4)]
    np.testing.assert_allclose(solution.gap, [0.5, 0.5, 2.0, -0.5, 0.5], atol=1e-6)


@pytest.mark.parametrize("backend", ["psor", "multigrid", "active-set", "osqp"])
def test_lower_bounds_above_zero_on_a_lattice(backend):
    """Kernels must be told these bounds, although they are zero once gaps are counted from them."""
    stencil = cq.Stencil(np.ones((12, 12), dtype=bool), 1.0, 1.0)
    solution = cq.solve(cq.ContactQP(stencil, np.full(stencil.size, -0.001), lower=0.5), backend)
    dense = cq.ContactQP(stencil.tocsr().toarray(), np.full(stencil.size, -0.001), lower=0.5)
    exact = cq.solve(dense, "clarabel", tol=1e-9)
    assert solution.status == "certified"
    np.testing.assert_allclose(solution.gap, exact.gap, atol=1e-5)


@pytest.mark.parametrize("given_as", ["stencil", "matrix"])
def test_lower_bounds_above_zero_on_a_large_lattice(given_as):
    stencil = cq.Stencil(np.ones((70, 70), dtype=bool), 1.0, 1.0)
    problem = cq.ContactQP(stencil if given_as == "stencil" else stencil.tocsr(), np.full(4900, -0.01), lower=0.5)
    solution = cq.solve(problem)
    assert solution.status == "certified"
    assert (solution.gap >= 0.5).all()
