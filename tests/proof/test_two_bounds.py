"""Problems with a lower and an upper bound: solved by every backend that takes them, and proven."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rational import (
    adversarial_answer,
    adversarial_bounds,
    assert_certificate_holds,
    exact_solution,
    lattice_stencil,
    m_matrix,
    shares,
)
from strategies import BACKENDS, bounds, enumerate_solution, lattice_masks, m_matrices

import contactqp as cq
from contactqp.proof.lattice_measures import LatticeMeasures
from contactqp.proof.measure import measure

TWO_SIDED = tuple(name for name in BACKENDS if name != "mangasarian")


@pytest.mark.slow
@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("share", shares(10))
def test_no_claim_is_violated_in_rational_arithmetic(share, compiled, monkeypatch):
    monkeypatch.setattr("contactqp.proof.lattice_measures._WORTH_COMPILED_PASSES", 0 if compiled else 10**9)
    seen = 0
    for case in range(share, 3000, 10):
        rng = np.random.default_rng([2027, case])
        stiffness = lattice_stencil(rng) if compiled or rng.uniform() < 0.3 else m_matrix(rng, rng.integers(1, 5))
        if (stiffness.size if hasattr(stiffness, "mask") else len(stiffness)) > 5:
            continue
        problem = adversarial_bounds(rng, stiffness)
        solved = cq.solve(problem, "active-set", on_failure="ignore")
        state = np.where(solved.contact_upper, 1, np.where(solved.contact_lower, -1, 0))
        gap, reaction = exact_solution(problem, state)
        answer = adversarial_answer(rng, problem, gap)
        seen += isinstance(measure(problem, answer), LatticeMeasures)
        for effort in ("fast", "sharp"):
            assert_certificate_holds(cq.certify(problem, answer, effort=effort), gap, reaction, answer)
    assert (seen > 0) == compiled


@pytest.mark.slow
def test_no_claim_beyond_m_matrices_is_violated_in_rational_arithmetic():
    kinds = set()
    for case in range(500):
        rng = np.random.default_rng([2028, case])
        size = int(rng.integers(2, 5))
        root = rng.normal(size=(size, size))
        matrix = root @ root.T + 10.0 ** rng.uniform(-4, 1) * np.eye(size)
        if rng.uniform() < 0.5:
            matrix += np.diag(np.abs(matrix).sum(axis=1)) * rng.uniform(0.3, 1.2)
        matrix = (matrix + matrix.T) / 2
        problem = adversarial_bounds(rng, matrix)
        if problem.is_m_matrix:
            continue
        gap, reaction = exact_solution(problem)
        answer = adversarial_answer(rng, problem, gap)
        certificate = cq.certify(problem, answer)
        assert_certificate_holds(certificate, gap, reaction, answer)
        kinds.add(certificate.barrier)
    assert kinds == {"comparison matrix", "smallest eigenvalue"}


@pytest.mark.parametrize("name", [name for name in TWO_SIDED if name != "multigrid"])
@settings(max_examples=40)
@given(matrix=m_matrices(max_size=6), data=st.data())
def test_every_backend_solves_matrices_between_bounds(name, matrix, data):
    size = len(matrix)
    lower, upper = data.draw(bounds(size))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    problem = cq.ContactQP(matrix, rng.normal(size=size) * np.sqrt(np.diag(matrix)), lower, upper)
    exact = enumerate_solution(problem)
    solution = cq.solve(problem, name, tol=1e-6)
    scale = max(1.0, float(np.abs(exact).max()))
    np.testing.assert_allclose(solution.gap, exact, atol=1e-5 * scale)
    assert solution.certificate.gap_bound >= np.abs(solution.gap - exact).max() - 1e-11 * scale


@pytest.mark.parametrize("name", TWO_SIDED)
@settings(max_examples=25)
@given(mask=lattice_masks(), data=st.data())
def test_every_backend_solves_lattices_between_bounds(name, mask, data):
    stencil = cq.Stencil(mask, 1.0, 0.5)
    lower, upper = data.draw(bounds(stencil.size))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    problem = cq.ContactQP(stencil, rng.normal(size=stencil.size), lower, upper)
    solution, reference = cq.solve(problem, name, tol=1e-6), cq.solve(problem, "active-set", tol=1e-9)
    np.testing.assert_allclose(solution.gap, reference.gap, atol=1e-5)
    assert solution.certificate.intersects(reference.certificate)


@pytest.mark.parametrize("name", TWO_SIDED)
def test_a_cable_between_floor_and_ceiling_has_its_closed_form(name):
    """Pressed down on the left half and up on the right one, floor and ceiling at ±f.

    Contact on [a, L/2 - a] below and [L/2 + a, L - a] above, a = √(2Tf/p); the free part in the middle is two parabolas
    that meet at L/2 (T = p = Δ = 1, a = 6, f = 18, exact for three-point differences).
    """
    half, a = 40, 6
    floor = a**2 / 2
    x = np.arange(1.0, 2 * half)
    load = np.where(x < half, 1.0, np.where(x > half, -1.0, 0.0))
    stencil = cq.Stencil(np.ones((1, x.size), dtype=bool), 1.0, 0.0)
    # The gap to the floor is f - w between 0 and 2f.
    height = stencil.numbering.to_grid(np.full(x.size, floor), ring=1)
    problem = cq.ContactQP(stencil, load - stencil.pull(height), 0.0, 2 * floor)
    distance = np.minimum(np.minimum(x, np.abs(x - half)), 2 * half - x).clip(0, a)
    deflection = np.where(x <= half, 1, -1) * (distance * a - distance**2 / 2)
    solution = cq.solve(problem, name, tol=1e-9)
    assert solution.status == "certified"
    np.testing.assert_allclose(floor - solution.gap, deflection, atol=1e-7)
    below, above = (x >= a) & (x <= half - a), (x >= half + a) & (x <= 2 * half - a)
    certificate = solution.certificate
    assert (certificate.contact_lower <= below).all()
    assert (certificate.contact_upper <= above).all()
    inner_below, inner_above = (x > a) & (x < half - a), (x > half + a) & (x < 2 * half - a)
    assert (inner_below <= certificate.contact_lower).all()
    assert (inner_above <= certificate.contact_upper).all()
    assert not (certificate.contact & certificate.clear).any()


def test_the_bounds_are_checked():
    matrix = [[2.0, -1.0], [-1.0, 2.0]]
    with pytest.raises(ValueError, match=r"lower must be <= upper, but at unknown 1 lower is 1 and upper 0.5"):
        cq.ContactQP(matrix, [0.0, 0.0], [0.0, 1.0], [1.0, 0.5])
    with pytest.raises(ValueError, match=r"lower must be a number or -inf \(no bound\), but entry 0 is nan"):
        cq.ContactQP(matrix, [0.0, 0.0], np.nan)
    with pytest.raises(ValueError, match=r"upper must be a number or inf \(no bound\), but entry 1 is -inf"):
        cq.ContactQP(matrix, [0.0, 0.0], 0.0, [1.0, -np.inf])
    with pytest.raises(ValueError, match=r"lower must be a number or have shape \(2,\), got \(3,\)"):
        cq.ContactQP(matrix, [0.0, 0.0], np.zeros(3))


def test_the_linear_program_refuses_two_bounds_and_says_why():
    problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0], upper=[np.inf, 2.0])
    message = r"no least element .* but upper is 2 at unknown 1; take 'osqp'"
    with pytest.raises(cq.UnsuitableProblemError, match=message):
        cq.solve(problem, "mangasarian")
    assert "mangasarian" not in cq.compare(problem).to_frame().index


def test_bounds_that_exclude_zero_by_hand():
    """One node, G = 2, q = -1, 2 ≤ ω ≤ 3: the lower bound holds it, R = 3. With 0 ≤ ω ≤ 1/4 the upper one, R = -1/2."""
    low = cq.solve(cq.ContactQP([[2.0]], [-1.0], 2.0, 3.0))
    assert (low.gap.tolist(), low.reaction.tolist()) == ([2.0], [3.0])
    assert (low.contact_lower.tolist(), low.contact_upper.tolist()) == ([True], [False])
    high = cq.solve(cq.ContactQP([[2.0]], [-1.0], 0.0, 0.25))
    assert (high.gap.tolist(), high.reaction.tolist()) == ([0.25], [-0.5])
    assert (high.contact_lower.tolist(), high.contact_upper.tolist()) == ([False], [True])
    assert high.certificate.total_reaction.lower <= -0.5 <= high.certificate.total_reaction.upper


@given(matrix=m_matrices(max_size=6), data=st.data())
def test_energies_bracket_the_least_one(matrix, data):
    size = len(matrix)
    lower, upper = data.draw(bounds(size))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    problem = cq.ContactQP(matrix, rng.normal(size=size), lower, upper)
    exact = enumerate_solution(problem)
    energy = cq.potential_energy(problem, exact)
    room = 1e-9 * (1 + abs(energy))
    low, high = cq.energy_bracket(problem, exact + rng.normal(size=size))
    assert low - room <= energy <= high + room
    assert cq.energy_bracket(problem, exact) == pytest.approx((energy, energy), abs=room)


@pytest.mark.parametrize("effort", ["fast", "sharp"])
def test_a_stiff_node_does_not_swallow_what_the_others_leave_open(effort):
    """The gap zero presses the first node on its lower bound by 1e-182, and all that rounding adds is far more."""
    matrix, forces = [[1e250, 1e221], [1e221, 2e193]], [1e-182, -1e-211]
    problem = cq.ContactQP(matrix, forces, [0.0, -np.inf], [0.0, 0.0])
    certificate = cq.certify(problem, [0.0, 0.0], effort=effort)
    assert not certificate.contact_upper[0]
    lower, upper = certificate.reaction
    assert lower[0] <= 1e-182 <= upper[0]
