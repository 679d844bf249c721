"""Matrices whose residuals say next to nothing of the error: no status is ok unless the answer is within tol."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from rational import adversarial_answer, assert_certificate_holds, exact_solution
from scipy import sparse

import contactqp as cq
from contactqp.problem.eigenvalue import proven_least_eigenvalue


def beam(nodes):
    """Return a beam over a floor, pinned at both ends: rows 1, -4, 6, -4, 1, with a condition that grows as n⁴."""
    step = 10.0 / (nodes + 1)
    differences = sparse.diags_array([1.0, -2.0, 1.0], offsets=[-1, 0, 1], shape=(nodes, nodes)).tocsr()
    matrix = (differences.T @ differences) / step**3
    return cq.ContactQP(matrix, step - matrix @ np.full(nodes, 0.5))


def beam_solution(problem, contact):
    """Return the exact gap with these nodes in contact, in sixty digits, where it satisfies all conditions."""
    size, matrix = problem.size, problem.G
    with localcontext() as context:
        context.prec = 60
        zero = Decimal(0)
        rows = [
            {int(j): Decimal(float(x)) for j, x in zip(matrix[[i]].indices, matrix[[i]].data, strict=True)}
            for i in range(size)
        ]
        q = [Decimal(float(x)) for x in problem.q]
        free = [i for i in range(size) if not contact[i]]
        upper: dict[int, dict[int, Decimal]] = {}
        right: dict[int, Decimal] = {}
        for i in free:
            row = {j: x for j, x in rows[i].items() if not contact[j]}
            force = -q[i]
            for k in sorted(j for j in row if j < i):
                factor = row.pop(k) / upper[k][k]
                for j, x in upper[k].items():
                    if j > k:
                        row[j] = row.get(j, zero) - factor * x
                force -= factor * right[k]
            upper[i], right[i] = row, force
        gap = [zero] * size
        for i in reversed(free):
            gap[i] = (right[i] - sum((x * gap[j] for j, x in upper[i].items() if j > i), zero)) / upper[i][i]
        reaction = [sum((x * gap[j] for j, x in rows[i].items()), q[i]) for i in range(size)]
        assert all(gap[i] >= 0 for i in free)
        assert all(reaction[i] >= 0 for i in range(size) if contact[i])
    return np.array([float(x) for x in gap])


@pytest.fixture(scope="module")
def long_beam():
    problem = beam(1000)
    contact = np.zeros(1000, dtype=bool)
    contact[185:815] = True
    return problem, beam_solution(problem, contact)


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "limit"), [("osqp", 20_000), ("clarabel", None), ("psor", 20_000)])
@pytest.mark.parametrize("tol", [1e-6, 1e-2])
def test_a_beam_is_ok_only_within_tol(long_beam, backend, limit, tol):
    problem, exact = long_beam
    solution = cq.solve(problem, backend, tol=tol, max_iter=limit, on_failure="ignore")
    error = np.abs(solution.gap - exact).max()
    assert not solution.status.ok or error <= tol * solution.verdict.scale
    if solution.certificate is not None:
        assert error <= solution.certificate.gap_bound * (1 + 1e-12)
        assert (solution.certificate.lower <= exact + 1e-16).all()
        assert (exact <= solution.certificate.upper + 1e-16).all()


def test_the_solution_of_a_beam_is_certified_node_by_node(long_beam):
    """Its smallest eigenvalue is 2e-11 of the diagonal, so that the bound has to come from a repaired base."""
    problem, exact = long_beam
    certificate = cq.certify(problem, exact)
    assert certificate.barrier == "smallest eigenvalue"
    assert certificate.gap_bound < 1e-10 * exact.max()
    assert (certificate.contact == (exact == 0)).all()
    off = exact + 0.01 * np.sin(np.arange(1000.0))
    assert cq.certify(problem, off).gap_bound == pytest.approx(np.abs(off - exact).max(), rel=1e-6)


@pytest.mark.parametrize("nodes", [20, 200])
def test_the_eigenvalue_of_a_beam_is_bounded_closely(nodes):
    matrix = beam(nodes).G
    least = proven_least_eigenvalue(matrix)
    exact = np.linalg.eigvalsh(least.units[:, None] * matrix.toarray() * least.units).min()
    assert 0.8 * exact < least.bound < exact
    assert least.proof == "factors"


def bent(rng):
    """Return a problem with a small band, at times nearly singular: free, in contact, or nearly between the two."""
    size = int(rng.integers(3, 8))
    width = int(rng.integers(1, 4))
    lower = np.tril(np.triu(rng.normal(size=(size, size)), -width))
    matrix = lower @ lower.T
    matrix = np.tril(matrix + 10.0 ** rng.uniform(-13, -1) * np.eye(size))
    matrix += np.tril(matrix, -1).T
    gap = np.where(rng.uniform(size=size) < 0.5, 10.0 ** rng.uniform(-rng.choice([1, 12]), 0, size), 0.0)
    press = np.where(gap == 0, 10.0 ** rng.uniform(-rng.choice([1, 15]), 0, size), 0.0)
    q = press - matrix @ gap
    if rng.uniform() < 0.5:
        return cq.ContactQP(matrix, q)
    upper = np.where(rng.uniform(size=size) < 0.5, gap, gap + 10.0 ** rng.uniform(-12, 0, size))
    return cq.ContactQP(matrix, q, np.where(rng.uniform(size=size) < 0.8, 0.0, -np.inf), upper)


@pytest.mark.parametrize("cases", [range(60), pytest.param(range(60, 600), marks=pytest.mark.slow)])
def test_certificates_in_twice_the_precision_hold_in_rational_numbers(cases, monkeypatch):
    """Every matrix is taken for a stiff narrow band."""
    monkeypatch.setattr("contactqp.algebra.narrow_band.STIFF", np.inf)
    monkeypatch.setattr("contactqp.algebra.narrow_band.SHORTEST", 0)
    certified = 0
    for case in cases:
        rng = np.random.default_rng([106, case])
        try:
            problem = bent(rng)
        except ValueError:  # singular to rounding
            continue
        gap, reaction = exact_solution(problem)
        solution = cq.solve(problem, "active-set", on_failure="ignore")
        certified += solution.status.ok
        for answer in (solution.gap, adversarial_answer(rng, problem, gap)):
            try:
                certificate = cq.certify(problem, answer)
            except cq.UnsuitableProblemError:
                continue
            assert_certificate_holds(certificate, gap, reaction, answer)
    assert certified > 0.8 * len(cases)


def gaussian_kernel(rng):
    """Return a small problem whose matrix is a Gaussian kernel with a little more on its diagonal."""
    size = int(rng.integers(3, 8))
    places = np.sort(rng.uniform(0, 1, size))
    matrix = np.exp(-((places[:, None] - places) ** 2) / 0.5) + 10.0 ** rng.uniform(-8, -4) * np.eye(size)
    return cq.ContactQP(matrix, rng.normal(size=size))


@pytest.mark.slow
def test_no_answer_to_a_gaussian_kernel_is_ok_and_off():
    certified, not_ok = 0, 0
    for case in range(320):
        problem = gaussian_kernel(np.random.default_rng([373, case]))
        backend = ("psor", "osqp", "clarabel", "auto")[case % 4]
        limit = 5 if backend == "psor" else None
        solution = cq.solve(problem, backend, tol=1e-5, max_iter=limit, on_failure="ignore")
        if not solution.status.ok:
            not_ok += 1
            continue
        certified += 1
        gap, _ = exact_solution(problem)
        error = max(abs(float(exact) - found) for exact, found in zip(gap, solution.gap, strict=True))
        assert error <= 1e-5 * solution.verdict.scale * (1 + 1e-12)
    assert certified > 80
    assert not_ok > 0
