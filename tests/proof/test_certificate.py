from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import enumerate_solution, problems

import contactqp as cq
from contactqp.proof.judge import judge


def within(certificate, gap):
    """Whether a gap lies between the bounds at every node."""
    return bool(((certificate.lower <= gap) & (gap <= certificate.upper)).all())


def noisy(gap, size, seed):
    return gap + 10.0**size * np.random.default_rng(seed).normal(size=gap.size)


@given(problem=problems(max_size=8, spread=3.0), size=st.floats(-14, 2), seed=st.integers(0, 2**32 - 1))
def test_the_enclosure_contains_the_enumerated_solution(problem, size, seed):
    exact = enumerate_solution(problem)
    certificate = cq.certify(problem, noisy(exact, size, seed))
    room = 1e-11 * (1 + np.abs(exact))  # the enumeration itself rounds
    assert (certificate.lower <= exact + room).all()
    assert (exact - room <= certificate.upper).all()


@given(problem=problems(max_size=8), size=st.floats(-10, 1), seed=st.integers(0, 2**32 - 1))
def test_certain_nodes_are_what_they_are_said_to_be(problem, size, seed):
    exact = enumerate_solution(problem)
    certificate = cq.certify(problem, noisy(exact, size, seed))
    reaction = problem.reaction(exact)
    assert not (certificate.contact & certificate.clear).any()
    assert (np.abs(exact[certificate.contact]) < 1e-9).all()
    assert (reaction[certificate.contact] > -1e-12).all()
    assert (exact[certificate.clear & problem.supported] > -1e-12).all()
    assert (np.abs(reaction[certificate.clear]) < 1e-9 * (1 + np.abs(problem.q).max())).all()


@given(problem=problems(max_size=8), size=st.floats(-9, 0), seed=st.integers(0, 2**32 - 1))
def test_the_bound_is_at_least_the_true_error_and_shrinks_with_it(problem, size, seed):
    exact = enumerate_solution(problem)
    wrong = noisy(exact, size, seed)
    assert cq.certify(problem, wrong).gap_bound >= np.abs(wrong - exact).max() * (1 - 1e-9) - 1e-12
    assert cq.certify(problem, exact).gap_bound <= 1e-9 * (1 + np.abs(exact).max())


def exact_solution_in_fractions(matrix, q):
    """Solve a small complementarity problem with rational numbers: Gauss elimination for every contact set."""
    size = len(q)
    matrix = [[Fraction(float(entry)) for entry in row] for row in matrix]
    q = [Fraction(float(entry)) for entry in q]
    for pattern in range(2**size):
        free = [i for i in range(size) if pattern >> i & 1]
        rows = [[matrix[i][j] for j in free] + [-q[i]] for i in free]
        for k in range(len(free)):
            pivot = rows[k][k]
            rows[k] = [entry / pivot for entry in rows[k]]
            for other in range(len(free)):
                if other != k:
                    rows[other] = [a - rows[other][k] * b for a, b in zip(rows[other], rows[k], strict=True)]
        gap = [Fraction(0)] * size
        for k, i in enumerate(free):
            gap[i] = rows[k][-1]
        reaction = [
            sum(a * b for a, b in zip(row, gap, strict=True)) + force for row, force in zip(matrix, q, strict=True)
        ]
        if min(gap) >= 0 and all(force >= 0 for i, force in enumerate(reaction) if i not in free):
            return gap
    raise AssertionError("an M-matrix problem has a solution")


@pytest.mark.slow
@given(problem=problems(max_size=5, spread=6.0), size=st.floats(-18, 0), seed=st.integers(0, 2**32 - 1))
def test_the_enclosure_holds_in_rational_arithmetic(problem, size, seed):
    """Of the problem whose data are the stored doubles, also when the error is as small as rounding."""
    if not problem.supported.all():
        problem = cq.ContactQP(problem.G, problem.q)
    exact = exact_solution_in_fractions(problem.G.toarray(), problem.q)
    rounded = np.array([float(entry) for entry in exact])
    certificate = cq.certify(problem, rounded * (1 + 10.0**size * np.random.default_rng(seed).normal(size=len(exact))))
    for i, value in enumerate(exact):
        assert Fraction(certificate.lower[i]) <= value <= Fraction(certificate.upper[i])


def corrupted(gap):
    worst = int(np.argmax(gap))
    shifted = gap.copy()
    shifted[worst] += 0.01 * gap[worst]
    return {
        "clipped": np.minimum(gap, 0.9 * gap.max()),
        "sign-flipped": -gap,
        "shifted at one node": shifted,
        "shifted up": gap + 1e-3 * gap.max(),
        "shifted down": gap - 1e-3 * gap.max(),
        "zero": np.zeros_like(gap),
        "scaled": 1.001 * gap,
        "reversed": np.roll(gap, 1),
    }


@pytest.mark.parametrize("fault", list(corrupted(np.ones(2))))
def test_the_judge_rejects_forged_answers_and_the_enclosure_widens(fault):
    problem = cq.gallery.paper_hexagon().problem
    honest = cq.solve(problem, "clarabel", tol=1e-8)
    forged = corrupted(honest.gap)[fault]
    verdict = judge(problem, forged, tol=1e-6)
    assert verdict.status == cq.Status.INACCURATE
    error = np.abs(forged - honest.gap).max()
    assert error * (1 - 1e-6) <= verdict.certificate.gap_bound
    if fault not in ("zero", "sign-flipped"):
        assert verdict.certificate.gap_bound <= 1.5 * error
    assert verdict.certificate.intersects(honest.certificate)
    assert not within(honest.certificate, forged)
    fast = cq.certify(problem, forged, effort="fast")
    assert fast.gap_bound > 1e3 * honest.certificate.gap_bound
    assert fast.gap_bound >= error * (1 - 1e-6)
    assert within(fast, np.where(honest.contact, 0.0, honest.gap))
    assert fast.intersects(honest.certificate)
    assert fast.undecided.sum() > 0


@pytest.mark.parametrize("gap", [None, np.full(1857, np.nan), np.ones(3)])
def test_the_judge_rejects_what_is_no_answer(gap):
    verdict = judge(cq.gallery.paper_hexagon().problem, gap, tol=1e-6)
    assert verdict.status == cq.Status.FAILED
    assert verdict.certificate is None
    assert verdict.relative_bound == np.inf


def test_residuals_by_hand():
    """G = [[2, -1], [-1, 2]], q = (-1, 3), ω = (1, -0.5): R = (1.5, 1)."""
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), [-1.0, 3.0])
    residuals = judge(problem, np.array([1.0, -0.5]), tol=1e-6).residuals
    assert residuals.min_gap == -0.5
    assert residuals.min_reaction == 1.0
    assert residuals.complementarity == 1.0 * 1.5 - 0.5 * 1.0
    assert residuals.natural_residual == 0.75
    assert residuals.objective == pytest.approx(0.5 * (1.0 * 2.5 - 0.5 * -2.0) - 1.0 - 1.5)


def test_the_enclosure_by_hand():
    """G = 2, q = -1, so ω* = 1/2; v = 1, s = 2. ω = 0.6 has R = 0.2, τ⁻ = 0.1; ω = 0.4 has R = -0.2, τ⁺ = 0.1."""
    problem = cq.ContactQP([[2.0]], [-1.0])
    above, below = (cq.certify(problem, [gap], effort="fast") for gap in (0.6, 0.4))
    assert (above.lower[0], above.upper[0]) == pytest.approx((0.5, 0.6))
    assert (below.lower[0], below.upper[0]) == pytest.approx((0.4, 0.5))
    assert above.intersects(below)
    assert above.clear[0]
    assert repr(above) == "Certificate(|gap error| <= 0.101; 0 in contact, 1 clear, 0 undecided; linear solve)"


@pytest.mark.parametrize("size", [1e140, 1e300, 1.7e308])
def test_numbers_that_overflow_prove_nothing(size):
    matrix = np.array([[2.0, -1.0], [-1.0, 2.0]])
    lattice = cq.Lattice.from_mask(np.ones((2, 2), dtype=bool), 1.0)
    problems = [
        (cq.ContactQP(matrix, [-1.0, 3.0]), [0.5, 0.0]),
        (cq.ContactQP(matrix * 1e200, [-1e200, 3e200]), [0.5, 0.0]),
        (cq.Membrane(lattice, 1.0, load=1.0, support=1.0).problem, None),
    ]
    for problem, exact in problems:
        certificate = cq.certify(problem, np.full(problem.size, size))
        assert certificate.gap_bound > 0.1 * size
        if exact is not None:
            assert within(certificate, exact)
        assert not certificate.contact.any()


def test_underflow_decides_nothing():
    lifted = cq.certify(cq.ContactQP([[1e-170]], [0.0]), [1e-160])
    assert lifted.lower[0] == 0.0
    assert not lifted.clear[0]
    free = cq.certify(cq.ContactQP([[1e-170]], [0.0], supported=[False]), [1e-160])
    assert free.lower[0] <= 0.0 <= free.upper[0]


def test_subnormal_errors_are_covered():
    matrix = np.diag([1.6286881624563463e103, 4.071720406140866e102])
    q = [-5.246702801007557e-210, 1.8434837146242492e19]
    certificate = cq.certify(cq.ContactQP(matrix, q), [3.2214287068e-313, 0.0])
    assert Fraction(certificate.upper[0]) >= Fraction(5.246702801007557e-210) / Fraction(1.6286881624563463e103)


@pytest.mark.parametrize("effort", ["fast", "sharp"])
@pytest.mark.parametrize("error", [0.0, 1e-15, 1e-7])
def test_biactive_nodes_stay_undecided(effort, error):
    """ω = R = 0 wherever the floor is the free cable's own parabola x(12 - x), in whole numbers: not so beside it."""
    x = np.arange(1.0, 12.0)
    floor = x * (12 - x)
    floor[:3] += 5.0
    cable = cq.Cable(nodes=11, spacing=1.0, tension=1.0, load=2.0, support=floor)
    exact = np.where(x < 4, 5.0, 0.0)
    certificate = cq.certify(cable.problem, exact + error, effort=effort)
    assert certificate.undecided[3:].all()
    assert certificate.clear[:3].all()


def test_nearly_biactive_nodes_are_decided_only_as_far_as_the_stored_numbers_allow():
    """The floor is the free membrane's shape but for rounding, so the signs are those of rounding errors."""
    lattice = cq.Frame.rectangle(8, 8).lattice(1.0)
    free = cq.solve(cq.Membrane(lattice, 1.0, load=0.25, support=np.inf), "clarabel", tol=1e-9).deflection
    problem = cq.Membrane(lattice, 1.0, load=0.25, support=free).problem
    assert cq.certify(problem, np.full(lattice.size, 1e-7), effort="fast").undecided.all()
    sharp = cq.certify(problem, np.full(lattice.size, 1e-7))
    assert sharp.upper.max() < 1e-13
    assert sharp.intersects(cq.solve(problem, "psor", tol=1e-12, on_failure="ignore").certificate)


def test_certify_checks_its_argument():
    problem = cq.ContactQP([[2.0]], [-1.0])
    with pytest.raises(ValueError, match="gap must be finite"):
        cq.certify(problem, [np.nan])
    with pytest.raises(ValueError, match=r"gap must have shape \(1,\)"):
        cq.certify(problem, [1.0, 2.0])


def test_every_status_has_advice():
    for status in cq.Status:
        assert status.advice.endswith(".")
    assert [status.value for status in cq.Status if status.ok] == ["certified"]
