"""ContactLCP: complementarity problems with an M-matrix that is not symmetric."""

import math
import pickle

import numpy as np
import pytest
from rational import adversarial_answer, assert_certificate_holds, exact_solution, shares
from scipy import sparse

import contactqp as cq

METHODS = ("active-set", "psor", "mangasarian")


def upwind(size, drift, decay=0.1):
    """Return the matrix of -u'' + drift u' + decay u on (0, 1) by upwind differences."""
    h = 1 / (size + 1)
    left, right = 1 / h**2 + max(drift, 0) / h, 1 / h**2 + max(-drift, 0) / h
    diagonals = [np.full(size - 1, -left), np.full(size, left + right + decay), np.full(size - 1, -right)]
    return sparse.diags_array(diagonals, offsets=[-1, 0, 1]).tocsr()


def nonsymmetric(rng, size):
    """Return an M-matrix that is dominant by rows or by columns, at times nearly singular or of scales far apart."""
    weights = 10.0 ** rng.uniform(-rng.choice([0.5, 6]), 0.5, (size, size))
    weights *= rng.uniform(size=(size, size)) < rng.uniform(0.2, 1.0)
    np.fill_diagonal(weights, 0.0)
    ground = 10.0 ** rng.uniform(-rng.choice([0.5, 3, 9]), 0.5, size)
    matrix = np.diag(weights.sum(axis=1) + ground) - weights
    if rng.uniform() < 0.5:
        matrix = matrix.T
    if rng.uniform() < 0.5:
        matrix = 10.0 ** rng.uniform(-2, 2, size)[:, None] * matrix * 10.0 ** rng.uniform(-2, 2, size)
    return matrix


def adversarial(rng, matrix):
    """Return a problem whose nodes are free, held by either bound, or nearly biactive."""
    size = len(matrix)
    gap = rng.normal(size=size) * 10.0 ** rng.uniform(-rng.choice([1, 8]), 1, size)
    state = rng.integers(-1, 2 if rng.uniform() < 0.7 else 1, size)
    room = 10.0 ** rng.uniform(-rng.choice([1, 8, 17]), 1, (2, size))
    lower = np.where(state < 0, gap, gap - room[0])
    upper = np.where(state > 0, gap, gap + room[1])
    lower = np.where((state >= 0) & (rng.uniform(size=size) < 0.3), -np.inf, lower)
    upper = np.where((state <= 0) & (rng.uniform(size=size) < 0.5), np.inf, upper)
    press = -state * 10.0 ** rng.uniform(-rng.choice([1, 8, 18]), 1, size)
    press[rng.uniform(size=size) < rng.choice([0.0, 0.3, 1.0])] = 0.0
    q = press - matrix @ gap if rng.uniform() < 0.8 else rng.normal(size=size) * np.abs(np.diag(matrix))
    return cq.ContactLCP(matrix, q, lower, np.maximum(lower, upper))


@pytest.mark.slow
@pytest.mark.parametrize("share", shares(10))
def test_no_claim_is_violated_in_rational_arithmetic(share):
    certified = cases = 0
    for case in range(share, 3000, 10):
        rng = np.random.default_rng([2031, case])
        problem = adversarial(rng, nonsymmetric(rng, int(rng.integers(1, 6))))
        solved = cq.solve(problem, "active-set", on_failure="ignore")
        state = np.where(solved.contact_upper, 1, np.where(solved.contact_lower, -1, 0))
        gap, reaction = exact_solution(problem, state)
        answer = adversarial_answer(rng, problem, gap)
        for effort in ("fast", "sharp"):
            assert_certificate_holds(cq.certify(problem, answer, effort=effort), gap, reaction, answer)
        certificate = solved.certificate
        assert_certificate_holds(certificate, gap, reaction, solved.gap)
        cases, certified = cases + 1, certified + (solved.status is cq.Status.CERTIFIED)
    assert certified >= 0.97 * cases


@pytest.mark.parametrize("name", METHODS)
def test_every_method_agrees_with_the_exact_solution(name):
    for case in range(30):
        rng = np.random.default_rng([2032, case])
        size = int(rng.integers(2, 6))
        matrix = nonsymmetric(rng, size)
        matrix += 0.1 * np.diag(np.diag(matrix))
        problem = cq.ContactLCP(matrix, rng.normal(size=size) * np.diag(matrix))
        gap, _ = exact_solution(problem)
        solution = cq.solve(problem, name, tol=1e-8)
        assert solution.status is cq.Status.CERTIFIED
        np.testing.assert_allclose(solution.gap, np.array(gap, dtype=float), atol=1e-7 * problem.gap_scale)


def test_a_symmetric_matrix_gives_the_quadratic_programs_answer():
    matrix, q = [[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0]
    lcp, qp = cq.ContactLCP(matrix, q), cq.ContactQP(matrix, q)
    np.testing.assert_allclose(cq.solve(lcp).gap, cq.solve(qp).gap)
    assert lcp.gap_scale == pytest.approx(qp.gap_scale)
    assert not isinstance(lcp, cq.ContactQP)


@pytest.mark.parametrize("drift", [-3000.0, -30.0, 0.0, 30.0, 3000.0])
@pytest.mark.parametrize("two_sided", [False, True])
def test_convection_is_certified_by_every_method(drift, two_sided):
    matrix = upwind(200, drift)
    load = np.where(np.arange(200) % 100 < 40, -50.0, 60.0) * (1 + abs(drift) / 30)
    problem = cq.ContactLCP(matrix, load, 0.0, 1.0 if two_sided else np.inf)
    names = METHODS[:2] if two_sided else METHODS
    comparison = cq.compare(problem, list(names), tol=1e-6)
    assert comparison.agree, comparison
    solution = cq.solve(problem)
    assert solution.certificate.contact.any()
    assert solution.iterations < 40


def test_large_problems_are_solved_and_certified():
    size = 100
    one = upwind(size, 40.0, 0.0)
    matrix = (sparse.kron(one, sparse.eye_array(size)) + sparse.kron(sparse.eye_array(size), one)).tocsr()
    x = np.linspace(0, 1, size)
    load = np.add.outer(np.sin(9 * x), np.cos(7 * x)).ravel() * 30
    solution = cq.solve(cq.ContactLCP(matrix, load), "active-set", tol=1e-9)
    assert solution.status is cq.Status.CERTIFIED
    assert solution.certificate.contact.any()
    assert solution.certificate.clear.any()


def test_policy_iteration_ends_where_simultaneous_exchange_would_cycle():
    for case in range(300):
        rng = np.random.default_rng([2033, case])
        matrix = nonsymmetric(rng, 8)
        lower = -(10.0 ** rng.uniform(-3, 1, 8))
        problem = cq.ContactLCP(
            matrix, 3 * rng.normal(size=8) * np.diag(matrix), lower, lower + 10.0 ** rng.uniform(-3, 1, 8)
        )
        assert cq.solve(problem, "active-set", tol=1e-6).iterations < 60


# An American put by implicit steps and upwind differences: Black-Scholes' operator over the logarithm of the price.


def put_step(strike, rate, volatility, steps, points=1001, reach=2.0, years=1.0):
    """Return prices, payoff, and the problem of one implicit step for the value above the payoff as lower bound."""
    log = np.linspace(-reach, reach, points)
    h, dt = log[1] - log[0], years / steps
    drift, spread = rate - volatility**2 / 2, volatility**2 / 2 / h**2
    up, down = spread + max(drift, 0) / h, spread + max(-drift, 0) / h
    prices = strike * np.exp(log)
    payoff = np.maximum(strike - prices, 0.0)
    diagonals = [
        np.full(points - 1, -dt * down),
        np.full(points, 1 + dt * (up + down + rate)),
        np.full(points - 1, -dt * up),
    ]
    matrix = sparse.diags_array(diagonals, offsets=[-1, 0, 1]).tocsr()
    beyond = np.zeros(points)
    beyond[0] = -dt * down * (strike - strike * math.exp(-reach - h))
    return prices, payoff, matrix, beyond


def binomial_put(price, strike, rate, volatility, years, steps):
    """Return the value of an American put by Cox, Ross and Rubinstein's tree (J. Financ. Econ. 7, 1979)."""
    dt = years / steps
    up = math.exp(volatility * math.sqrt(dt))
    chance = (math.exp(rate * dt) - 1 / up) / (up - 1 / up)
    prices = price * up ** np.arange(-steps, steps + 1, 2.0)
    value = np.maximum(strike - prices, 0.0)
    for _ in range(steps):
        prices = prices[1:] / up
        value = math.exp(-rate * dt) * (chance * value[1:] + (1 - chance) * value[:-1])
        value = np.maximum(value, strike - prices)
    return value[0]


def test_american_puts_have_the_values_of_a_binomial_tree():
    prices, payoff, matrix, beyond = put_step(40.0, 0.06, 0.2, 400, 2001)
    solver = cq.Solver(cq.ContactLCP(matrix, beyond - payoff, lower=payoff), "active-set", tol=1e-9)
    value = payoff
    for _ in range(400):
        solution = solver.solve(q=beyond - value)
        assert solution.status is cq.Status.CERTIFIED
        assert solution.iterations < 20
        value = solution.gap
    for price in (34.0, 36.0, 40.0, 44.0):
        reference = binomial_put(price, 40.0, 0.06, 0.2, 1.0, 2000)
        assert np.interp(price, prices, value) == pytest.approx(reference, abs=3e-3)
    exercised = solution.certificate.contact
    assert exercised[0]
    assert not exercised[prices > 40].any()


def test_the_perpetual_put_has_the_closed_form():
    """McKean 1965: exercise below S* = K/(1 + σ²/2r), V = (K - S*)(S/S*)^(-2r/σ²) above."""
    strike, rate, volatility = 1.0, 0.05, 0.3
    errors = []
    for points in (501, 1001, 2001):
        log = np.linspace(-2, 4, points)
        h = log[1] - log[0]
        drift, spread = rate - volatility**2 / 2, volatility**2 / 2 / h**2
        up, down = spread + max(drift, 0) / h, spread + max(-drift, 0) / h
        matrix = sparse.diags_array([-down, up + down + rate, -up], offsets=[-1, 0, 1], shape=(points, points))
        optimum, power = strike / (1 + volatility**2 / (2 * rate)), -2 * rate / volatility**2
        prices = np.exp(np.concatenate([[log[0] - h], log, [log[-1] + h]]))
        exact = np.where(prices > optimum, (strike - optimum) * (prices / optimum) ** power, strike - prices)
        q = np.zeros(points)
        q[0], q[-1] = -down * exact[0], -up * exact[-1]
        payoff = np.maximum(strike - prices[1:-1], 0.0)
        solution = cq.solve(cq.ContactLCP(matrix, q, lower=payoff), tol=1e-9)
        errors.append(np.abs(solution.gap - exact[1:-1]).max())
    assert errors[0] / errors[1] == pytest.approx(2, abs=0.5)
    assert errors[1] / errors[2] == pytest.approx(2, abs=0.5)


# What is refused, and what it says.


@pytest.mark.parametrize(
    ("matrix", "words"),
    [
        ([[2.0, 1.0], [-1.0, 2.0]], r"M must be a Z-matrix \(off-diagonal entries <= 0\), but M\[0, 1\] = 1"),
        ([[1.0, -2.0], [-1.0, 1.0]], r"M must be a nonsingular M-matrix, but"),
        ([[1.0, -1.0], [-1.0, 1.0]], r"M must be a nonsingular M-matrix, but"),
        ([[0.0, -1.0], [-1.0, 2.0]], r"M must have a positive diagonal, but M\[0, 0\] is 0"),
        ([[1.0, np.nan], [0.0, 2.0]], r"M must be finite, but M\[0, 1\] is nan"),
        ([[1.0, 0.0]], r"M must be square, got shape \(1, 2\)"),
    ],
)
def test_matrices_are_checked(matrix, words):
    with pytest.raises(ValueError, match=words):
        cq.ContactLCP(matrix, np.zeros(len(matrix)))


def test_arguments_are_checked():
    with pytest.raises(TypeError, match="M must"):
        cq.ContactLCP(np.array([[1j]]), [0.0])
    with pytest.raises(ValueError, match="q"):
        cq.ContactLCP([[1.0]], [0.0, 1.0])
    with pytest.raises(ValueError, match="lower must be <= upper"):
        cq.ContactLCP([[1.0]], [0.0], 1.0, 0.0)


@pytest.mark.parametrize("name", ["osqp", "clarabel", "multigrid"])
def test_methods_for_quadratic_programs_refuse_and_say_why(name):
    problem = cq.ContactLCP([[2.0, -1.0], [-0.5, 2.0]], [-1.0, 3.0])
    words = r"a symmetric matrix \(a quadratic program\), but M\[0, 1\] = -1 and M\[1, 0\] = -0.5; take 'mangasarian'"
    with pytest.raises(cq.UnsuitableProblemError, match=words):
        cq.solve(problem, name)
    assert [row.backend for row in cq.compare(problem).rows] == ["mangasarian", "psor", "active-set"]
    symmetric = cq.ContactLCP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    with pytest.raises(cq.UnsuitableProblemError, match=r"whose matrix is symmetric; pose it as ContactQP\(M, q\)"):
        cq.solve(symmetric, name)


def test_there_is_no_energy():
    problem = cq.ContactLCP([[2.0, -1.0], [-0.5, 2.0]], [-1.0, 3.0])
    for function in (cq.potential_energy, cq.complementary_energy, cq.energy_bracket):
        with pytest.raises(cq.UnsuitableProblemError, match=r"no energy .* M\[0, 1\] = -1 and M\[1, 0\] = -0.5"):
            function(problem, [0.0, 0.0])
    assert math.isnan(cq.solve(problem).residuals.objective)
    assert cq.feasible(problem, [0.5, 0.0]).all()


def test_it_tells_what_it_is_and_can_be_pickled():
    problem = cq.ContactLCP([[2.0, -1.0], [0.0, 2.0]], [-1.0, 3.0], upper=[1.0, np.inf])
    assert repr(problem) == "ContactLCP(2 unknowns, 3 nonzeros, M-matrix, 1 with an upper bound)"
    again = pickle.loads(pickle.dumps(problem))
    np.testing.assert_array_equal(cq.solve(again).gap, cq.solve(problem).gap)
    solution = cq.solve(problem)
    assert "certified" in repr(solution)
    assert "ContactLCP" in repr(solution)


def test_the_total_reaction_is_bracketed():
    for case in range(50):
        rng = np.random.default_rng([2034, case])
        problem = adversarial(rng, nonsymmetric(rng, 4))
        gap, reaction = exact_solution(problem)
        low, high = cq.certify(problem, np.array(gap, dtype=float)).total_reaction
        assert low <= float(sum(reaction)) <= high


def test_sessions_and_many_loads():
    problem = cq.ContactLCP(upwind(30, 20.0), np.full(30, -1.0))
    solver = cq.Solver(problem, "psor", tol=1e-8)
    forces = np.random.default_rng(0).normal(size=(12, 30))
    solutions = cq.solve_many([problem.with_forces(q) for q in forces], tol=1e-8)
    for q, solution in zip(forces, solutions, strict=True):
        other = solver.solve(q=q)
        assert solution.status is other.status is cq.Status.CERTIFIED
        np.testing.assert_allclose(solution.gap, other.gap, atol=1e-6 * problem.gap_scale)


def test_over_relaxation_does_not_diverge():
    rng = np.random.default_rng(5)
    matrix = np.eye(60) - 0.999 * np.roll(np.eye(60), 1, axis=1)  # a flow in a circle: Jacobi's eigenvalues fill one
    problem = cq.ContactLCP(matrix, rng.normal(size=60))
    assert cq.solve(problem, "psor", tol=1e-8).status is cq.Status.CERTIFIED
