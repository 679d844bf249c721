"""What the proofs of enclosures say, on problems whose solutions are known exactly."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rational import (
    adversarial_answer,
    adversarial_problem,
    assert_certificate_holds,
    exact_matrix,
    exact_solution,
    shares,
)
from strategies import BACKENDS, enumerate_solution, problems

import contactqp as cq
from contactqp.algebra.compensated import two_product, two_sum
from contactqp.methods.linear import free_set_solver
from contactqp.proof.enclosure import Base, certain_contact, enclosure_about, multiples, relaxed

ADVERSARIAL_CASES = 10_000
SHARE = 20

CHAIN = cq.ContactQP([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]], [-1.0, 2.0, 3.0])
"""Its solution is (1/2, 0, 0), its reaction (0, 3/2, 3)."""


@pytest.mark.slow
@pytest.mark.parametrize("share", shares(SHARE))
def test_no_claim_is_violated_in_rational_arithmetic(share):
    for case in range(share, ADVERSARIAL_CASES, SHARE):
        rng = np.random.default_rng([2026, case])
        problem = adversarial_problem(rng)
        guess = cq.solve(problem, "active-set", on_failure="ignore").gap > 0
        gap, reaction = exact_solution(problem, guess)
        answer = adversarial_answer(rng, problem, gap)
        for effort in ("fast", "sharp"):
            assert_certificate_holds(cq.certify(problem, answer, effort=effort), gap, reaction, answer)


def gallery_models():
    yield from ((f"hexagon at {load}", cq.gallery.paper_hexagon(load)) for load in cq.gallery.PAPER_LOADS)
    yield "bowl", cq.gallery.bowl(31)
    yield "spiral", cq.gallery.spiral(31)
    yield "ball", cq.gallery.ball(31)[0]
    yield "cable", cq.gallery.cable_on_floor(49, 12)[0]
    yield "L with a hole", cq.gallery.l_shape_with_hole(0.1)
    yield "islands", cq.gallery.islands()


@pytest.mark.parametrize("model", [pytest.param(model, id=name) for name, model in gallery_models()])
def test_enclosures_of_wrong_answers_hold_all_over_the_gallery(model):
    """The truth lies within 1e-12 of an answer that is certified to that; every other enclosure must meet it."""
    problem = model.problem
    truth = cq.solve(problem, "active-set", tol=1e-12).certificate
    rng = np.random.default_rng(7)
    for size in (1e-12, 1e-8, 1e-4, 1e-1):
        answer = truth.upper + size * problem.gap_scale * rng.normal(size=problem.size)
        for effort in ("fast", "sharp"):
            certificate = cq.certify(problem, answer, effort=effort)
            assert certificate.intersects(truth)
            assert certificate.gap_bound >= np.maximum(answer - truth.upper, truth.lower - answer).max()
            assert not (certificate.contact & truth.clear).any()
            assert not (certificate.clear & truth.contact).any()


def test_every_node_of_the_hexagon_is_decided_at_all_ten_loads():
    for load in cq.gallery.PAPER_LOADS:
        for name in BACKENDS:
            certificate = cq.solve(cq.gallery.paper_hexagon(load), name, tol=1e-8).certificate
            assert not certificate.undecided.any(), (load, name)


@pytest.mark.parametrize("name", BACKENDS)
def test_the_bound_is_within_a_factor_of_the_true_error(name):
    """Against a reference that is itself certified; where both are at rounding the factor says nothing."""
    for _, model in gallery_models():
        if name == "mangasarian" and model.lattice.size > 2000:
            continue
        solution = cq.solve(model, name, tol=1e-5)
        truth = cq.solve(model, "active-set", tol=1e-12).certificate
        error = max((solution.gap - truth.upper).max(), (truth.lower - solution.gap).max())
        if error > 1e-14:
            assert solution.certificate.gap_bound <= 1.6 * error


@given(problem=problems(max_size=7), seed=st.integers(0, 2**32 - 1))
def test_relaxation_keeps_and_shrinks_bounds(problem, seed):
    exact = enumerate_solution(problem)
    rng = np.random.default_rng(seed)
    room = 1e-11 * (1 + np.abs(exact))
    lower, upper = exact - rng.exponential(size=exact.size), exact + rng.exponential(size=exact.size)
    for _ in range(5):
        new_lower, new_upper = relaxed(problem, lower, upper)
        assert (lower <= new_lower).all()
        assert (new_upper <= upper).all()
        assert (new_lower <= exact + room).all()
        assert (exact - room <= new_upper).all()
        lower, upper = new_lower, new_upper
    assert np.abs(upper - lower).max() < np.inf


@given(problem=problems(max_size=7), seed=st.integers(0, 2**32 - 1))
def test_super_and_subsolutions_stay_such_under_relaxation(problem, seed):
    """In exact arithmetic, so in fractions: u ≥ 0 and R(u) ≥ 0 stays, and so does R(z)_i ≤ 0 wherever z_i > 0."""
    rng = np.random.default_rng(seed)
    matrix, size = exact_matrix(problem), problem.size
    q = [Fraction(float(force)) for force in problem.q]
    held = problem.supported

    def reaction(x):
        return [sum(a * b for a, b in zip(row, x, strict=True)) + force for row, force in zip(matrix, q, strict=True)]

    def jacobi(x):
        moved = [own - force / matrix[i][i] for i, (own, force) in enumerate(zip(x, reaction(x), strict=True))]
        return [max(Fraction(0), x) if held[i] else x for i, x in enumerate(moved)]

    def gauss_seidel(x):
        x = list(x)
        for i in range(size):
            moved = x[i] - reaction(x)[i] / matrix[i][i]
            x[i] = max(Fraction(0), moved) if held[i] else moved
        return x

    v = [Fraction(float(entry)) for entry in problem.barrier.v]
    exact, _ = exact_solution(problem)
    shift = Fraction(float(rng.exponential()))
    for sweep in (jacobi, gauss_seidel):
        above, below = (
            [x + shift * y for x, y in zip(exact, v, strict=True)],
            [x - shift * y for x, y in zip(exact, v, strict=True)],
        )
        for _ in range(3):
            assert all(r >= 0 for r in reaction(above))
            assert all(x >= 0 or not held[i] for i, x in enumerate(above))
            assert all(r <= 0 for i, r in enumerate(reaction(below)) if below[i] > 0 or not held[i])
            next_above, next_below = sweep(above), sweep(below)
            assert all(new <= old for new, old in zip(next_above, above, strict=True))
            assert all(new >= old for new, old, x in zip(next_below, below, exact, strict=True) if old > 0)
            assert all(low <= x <= high for low, x, high in zip(next_below, exact, next_above, strict=True))
            above, below = next_above, [max(a, b) for a, b in zip(next_below, below, strict=True)]


def test_the_free_set_barrier_by_hand():
    """F = {0}: v = (1/2, 0, 0), Gv = (1, -1/2, 0). Base (0.6, 0, 0): R = (0.2, 1.4, 3), so τ⁻ = 0.2, τ⁺ = 0."""
    v, s = np.array([0.5, 0.0, 0.0]), np.array([1.0, -0.5, 0.0])
    answer = np.array([0.6, 0.0, 0.0])
    found = multiples(CHAIN, Base.of(CHAIN, answer), v, s)
    assert found.held.all()
    assert (found.raise_by, found.lower_by) == (pytest.approx(0.0, abs=1e-15), pytest.approx(0.2))
    enclosure = enclosure_about(answer, CHAIN.bounds, Base.of(CHAIN, answer), v, found, "free set")
    lower, upper = enclosure.bounds(CHAIN.bounds)
    np.testing.assert_allclose(lower, [0.5, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(upper, [0.6, 0.0, 0.0], atol=1e-15)


def test_the_free_set_barrier_is_refused_where_it_would_lift_a_node():
    """R_1 = 2 - 5 < 0: node 1 is not in contact, as the base has it, so no multiple of v is an upper bound."""
    v, s = np.array([0.5, 0.0, 0.0]), np.array([1.0, -0.5, 0.0])
    answer = np.array([5.0, 0.0, 0.0])
    found = multiples(CHAIN, Base.of(CHAIN, answer), v, s)
    assert found.held.tolist() == [True, False, True]
    assert enclosure_about(answer, CHAIN.bounds, Base.of(CHAIN, answer), v, found, "free set").bound == np.inf
    known = multiples(CHAIN, Base.of(CHAIN, answer), v, s, np.array([False, True, True]))
    assert known.held.all()


def test_the_error_spreads_through_the_free_region_only():
    """On a cable that lies on a floor, a wrong force at one end moves nothing beyond the contact nodes."""
    cable, exact = cq.gallery.cable_on_floor(199, 20)
    problem = cable.problem
    free = exact < exact.max()
    solve, precise = free_set_solver(problem.stiffness, free)
    assert precise
    v = np.zeros(problem.size)
    v[free] = solve(np.ones(free.sum()))
    assert v.max() < 0.05 * problem.barrier.v.max()
    answer = exact.max() - exact + 1e-9 * free
    certificate = cq.certify(problem, answer)
    assert certificate.gap_bound < 1.0001e-9
    assert not certificate.undecided.any()


@given(st.floats(-1e150, 1e150), st.floats(-1e150, 1e150))
def test_sums_and_products_keep_their_error(first, second):
    total, rest = two_sum(first, second)
    assert Fraction(total) + Fraction(rest) == Fraction(first) + Fraction(second)
    assert total == first + second
    product, rest = two_product(first, second)
    if 1e-250 < abs(product) < 1e290:
        assert Fraction(product) + Fraction(rest) == Fraction(first) * Fraction(second)


@given(seed=st.integers(0, 2**32 - 1))
def test_accurate_reactions_are_accurate(seed):
    """Also where the reaction nearly vanishes, because the gap solves the equations up to its last digit."""
    rng = np.random.default_rng(seed)
    problem = adversarial_problem(rng)
    gap, _ = exact_solution(problem)
    high = np.array([float(x) for x in gap])
    low = np.array([float(x - Fraction(y)) for x, y in zip(gap, high, strict=True)]) * rng.choice([0.0, 1.0, 2.0])
    reaction, bound = problem.stiffness.accurate_product(high, low, problem.q)
    matrix = exact_matrix(problem)
    for i, row in enumerate(matrix):
        exact = Fraction(float(problem.q[i]))
        exact += sum(a * (Fraction(x) + Fraction(y)) for a, x, y in zip(row, high, low, strict=True))
        assert abs(Fraction(reaction[i]) - exact) <= Fraction(bound[i])
        size = sum(abs(a) * abs(Fraction(x)) for a, x in zip(row, high, strict=True)) + abs(
            Fraction(float(problem.q[i]))
        )
        assert Fraction(bound[i]) <= Fraction(1e-29) * size + Fraction(1e-14) * abs(exact) + Fraction(1e-14) * sum(
            abs(a) * abs(Fraction(y)) for a, y in zip(row, low, strict=True)
        ) + Fraction(1e-299)


def test_certain_contact_by_hand():
    """Node 1 is pulled open by 0.5 at most, node 0 by its own load: only the former is certainly in contact."""
    contact, above = certain_contact(CHAIN, np.zeros(3), np.array([0.5, 0.5, 0.5]))
    assert not above.any()
    assert contact.tolist() == [False, True, True]
    assert certain_contact(CHAIN, np.zeros(3), np.array([3.0, 3.0, 3.0]))[0].tolist() == [False, False, False]


def test_brackets_of_reactions_by_hand():
    certificate = cq.certify(CHAIN, [0.6, 0.0, 0.0], effort="fast")
    low, high = certificate.reaction
    assert (low <= [0.0, 1.5, 3.0]).all()
    assert (high >= [0.0, 1.5, 3.0]).all()
    assert certificate.total_reaction.lower <= 4.5 <= certificate.total_reaction.upper
    sharp = cq.certify(CHAIN, [0.6, 0.0, 0.0])
    np.testing.assert_allclose(sharp.reaction[0], [0.0, 1.5, 3.0], atol=1e-14)
    np.testing.assert_allclose(sharp.reaction[1], [0.0, 1.5, 3.0], atol=1e-14)
    assert sharp.total_reaction == (pytest.approx(4.5), pytest.approx(4.5))
    assert sharp.contact_nodes == (2, 2)


def test_the_total_reaction_is_sharper_than_its_parts():
    """Off the frame the column sums of G vanish, so that the errors of the nodes' reactions cancel."""
    problem = cq.gallery.paper_hexagon().problem
    answer = cq.solve(problem, "clarabel", tol=1e-2).gap
    certificate = cq.certify(problem, answer, effort="fast")
    low, high = certificate.reaction
    width = certificate.total_reaction.upper - certificate.total_reaction.lower
    assert width < 0.1 * (high.sum() - low.sum())
    assert certificate.total_reaction.lower <= cq.certify(problem, answer).total_reaction.lower


def test_the_total_reaction_is_bounded_where_sums_round_or_overflow():
    """Bounds that are true, and a sum that a rounded difference of middle and width would pass by half an ulp."""
    tiny = 2.0**-53 - 2.0**-70
    problem = cq.ContactQP([[32.0, -4.5], [-4.5, 1.0]], [1 + 2.0**-52, -tiny], supported=[True, False])
    bounds = np.array([0.0, -tiny]), np.array([0.0, tiny])
    nowhere = np.zeros(2, dtype=bool)
    certificate = cq.Certificate(problem, *bounds, tiny, nowhere, np.array([False, True]), "by hand")
    exact = Fraction(1) + Fraction(2) ** -52 - Fraction(9, 2) * Fraction(tiny)
    assert Fraction(certificate.total_reaction.lower) <= exact <= Fraction(certificate.total_reaction.upper)
    heavy = cq.certify(cq.ContactQP(np.eye(2), [1.7e308, 1.7e308]), [0.0, 0.0])
    assert heavy.total_reaction.upper == np.inf
    assert heavy.contact.all()


def test_sharp_certificates_keep_what_fast_ones_prove(monkeypatch):
    monkeypatch.setattr("contactqp.proof.lattice_measures._WORTH_COMPILED_PASSES", 0)
    for case in range(200):
        rng = np.random.default_rng([3, case])
        problem = adversarial_problem(rng)
        gap, _ = exact_solution(problem)
        answer = adversarial_answer(rng, problem, gap)
        fast, sharp = (cq.certify(problem, answer, effort=effort) for effort in ("fast", "sharp"))
        assert (fast.lower <= sharp.lower).all()
        assert (sharp.upper <= fast.upper).all()
        assert sharp.gap_bound <= fast.gap_bound
        assert (fast.contact <= sharp.contact).all()
        assert (fast.clear <= sharp.clear).all()


def test_solutions_bracket_contact_area_and_total_reaction():
    membrane = cq.gallery.paper_hexagon()
    solution = cq.solve(membrane, "clarabel", tol=1e-8)
    assert solution.contact_area == (303.0, 303.0)
    assert solution.total_reaction.lower <= solution.force_balance.reaction * (1 + 1e-9)
    assert solution.total_reaction.upper - solution.total_reaction.lower < 1e-9
    bare = cq.solve(membrane.problem, "clarabel", tol=1e-8)
    assert bare.total_reaction == solution.total_reaction
    with pytest.raises(AttributeError, match="contact_area needs a model, as Membrane, Cable or Beam"):
        _ = bare.contact_area


def test_a_certificate_is_sharpened_when_it_is_asked_for():
    solution = cq.solve(cq.gallery.paper_hexagon(), "psor", tol=1e-6)
    assert solution.certificate.gap_bound < 0.1 * solution.verdict.certificate.gap_bound
    assert solution.relative_bound < 0.1 * solution.verdict.relative_bound
    large = cq.solve(cq.gallery.bowl(400), tol=1e-6)
    assert large.certificate.lower is large.verdict.certificate.lower


def test_models_are_certified_and_drawn():
    membrane = cq.gallery.paper_hexagon()
    rough = cq.solve(membrane, "osqp", tol="default", on_failure="ignore").gap
    certificate = cq.certify(membrane, rough, effort="fast")
    assert certificate.gap_bound == cq.certify(membrane.problem, rough, effort="fast").gap_bound
    assert certificate.contact_area == certificate.contact_nodes
    legend = [text.get_text() for text in certificate.plot().legends[0].get_texts()]
    assert legend[2] == f"undecided ({certificate.undecided.sum()})"
    cable, exact = cq.gallery.cable_on_floor(9, 2)
    assert cq.certify(cable, cable.support - exact).plot().axes
    with pytest.raises(
        AttributeError, match="plot needs a model, as Membrane, Cable or Beam; this certificate is of a bare"
    ):
        cq.certify(membrane.problem, rough).plot()
    with pytest.raises(
        TypeError, match="problem must be a Membrane, a Cable, a CableNet, a ContactQP or a ContactLCP, got int"
    ):
        cq.certify(7, rough)


def test_garbage_is_certified_too():
    """Newton's method finds the contact set even from an answer that knows nothing of it."""
    membrane = cq.gallery.paper_hexagon()
    truth = cq.solve(membrane, "active-set", tol=1e-12).certificate
    for garbage in (np.zeros(1857), np.ones(1857), np.random.default_rng(0).normal(size=1857)):
        certificate = cq.certify(membrane, garbage)
        assert certificate.gap_bound <= 1.001 * max((garbage - truth.upper).max(), (truth.lower - garbage).max())
        assert not certificate.undecided.any()


def test_an_unknown_effort_is_refused():
    with pytest.raises(ValueError, match="effort must be one of 'fast', 'sharp', got 'sharpp'; did you mean 'sharp'"):
        cq.certify(CHAIN, [0.5, 0.0, 0.0], effort="sharpp")
