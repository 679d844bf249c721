"""Tolerance levels, the libraries' own defaults, and what a backend claimed."""

import numpy as np
import pytest
from strategies import touching_softly

import contactqp as cq
from contactqp.backends.base import Answer, Stop
from contactqp.solving.tolerances import LEVELS, Tolerance, tolerance_of

HEXAGON = cq.gallery.paper_hexagon()


@pytest.mark.parametrize("level", LEVELS)
def test_levels_are_tolerances_by_name(level):
    solution = cq.solve(HEXAGON, "clarabel", tol=level)
    assert (solution.tol, solution.setting) == (LEVELS[level], level)
    assert solution.status == "certified"
    assert solution.relative_bound <= LEVELS[level]


def test_a_number_has_no_name():
    assert tolerance_of(1e-6) == Tolerance(1e-6, "")
    assert cq.solve(HEXAGON, "clarabel").setting == ""
    assert str(tolerance_of("mid")) == "1e-06 (mid)"
    assert str(tolerance_of(0.5)) == "0.5"


@pytest.mark.parametrize("function", [cq.solve, cq.compare])
def test_a_misspelt_level_lists_them_all(function):
    message = r"tol must be .* one of 'low', 'mid', 'high', 'default', got 'hgih'; did you mean 'high'\?"
    with pytest.raises(ValueError, match=message):
        function(HEXAGON, tol="hgih")
    with pytest.raises(TypeError, match="tol must be a real number, got None"):
        function(HEXAGON, tol=None)


def test_osqp_as_its_authors_ship_it():
    """The same vector as a call of the library without any setting of ours."""
    import osqp
    from scipy import sparse

    scaled, units = HEXAGON.problem.scaled()
    library = osqp.OSQP()
    library.setup(
        sparse.csc_matrix(sparse.triu(scaled.G, format="csc")),
        np.array(scaled.q),
        sparse.csc_matrix(sparse.eye_array(scaled.size)),
        np.zeros(scaled.size),
        np.full(scaled.size, np.inf),
        verbose=False,
    )
    result = library.solve(raise_error=False)
    solution = cq.solve(HEXAGON, "osqp", tol="default", on_failure="ignore")
    np.testing.assert_array_equal(solution.gap, result.x * units.length)
    assert solution.iterations == result.info.iter
    assert "eps 1e-03" in solution.termination
    assert solution.note == "OSQP as shipped: eps 0.001, rho 0.1, at most 4000 iterations"
    assert (solution.tol, solution.setting, solution.status) == (1e-6, "default", "inaccurate")
    assert solution.claimed_solved
    limited = cq.solve(HEXAGON, "osqp", tol="default", max_iter=10, on_failure="ignore")
    assert limited.note.endswith("at most 10 iterations")
    assert limited.iterations == 10


def test_clarabel_as_its_authors_ship_it():
    import clarabel
    from scipy import sparse

    scaled, units = HEXAGON.problem.scaled()
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    library = clarabel.DefaultSolver(
        sparse.csc_matrix(sparse.triu(scaled.G, format="csc")),
        np.array(scaled.q),
        -sparse.csc_matrix(sparse.eye_array(scaled.size)),
        np.zeros(scaled.size),
        [clarabel.NonnegativeConeT(scaled.size)],
        settings,
    )
    result = library.solve()
    solution = cq.solve(HEXAGON, "clarabel", tol="default", on_failure="ignore")
    assert solution.iterations == result.iterations
    np.testing.assert_allclose(solution.gap, np.array(result.x) * units.length, atol=1e-12)
    assert "eps 1e-08" in solution.termination
    assert solution.note == "Clarabel as shipped: tolerance 1e-08 of the duality gap, at most 200 iterations"
    assert solution.claimed_solved


def test_highs_as_scipy_calls_it(monkeypatch):
    import scipy.optimize

    calls = []
    original = scipy.optimize.linprog
    monkeypatch.setattr(scipy.optimize, "linprog", lambda *a, **k: calls.append(k) or original(*a, **k))
    model = cq.gallery.bowl(15)
    assert cq.solve(model, "mangasarian", tol="default", on_failure="ignore").claimed_solved
    assert set(calls[0]) == {"A_ub", "b_ub", "bounds", "options"}
    assert calls[0]["options"] == {}
    cq.solve(model, "mangasarian", tol="default", on_failure="ignore", eps=1e-9, presolve=False)
    assert calls[1]["options"] == {
        "primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9, "presolve": False,
    }  # fmt: skip


def test_given_options_and_limits_still_win():
    usual = cq.solve(HEXAGON, "osqp", tol="default", on_failure="ignore")
    finer = cq.solve(HEXAGON, "osqp", tol="default", on_failure="ignore", eps=1e-9)
    assert "eps 1e-09" in finer.termination
    assert finer.relative_bound < 1e-3 * usual.relative_bound
    assert cq.solve(HEXAGON, "osqp", tol="default", on_failure="ignore", rho=3.0).iterations > usual.iterations
    short = cq.solve(HEXAGON, "osqp", tol="default", on_failure="ignore", max_iter=10)
    assert (short.iterations, short.status, short.claimed_solved) == (10, "iteration_limit", False)
    loose = cq.solve(HEXAGON, "clarabel", tol="default", on_failure="ignore", eps=1e-3)
    assert loose.iterations < cq.solve(HEXAGON, "clarabel", tol="default", on_failure="ignore").iterations
    assert "eps 1e-03" in loose.termination


@pytest.mark.parametrize("name", ["psor", "multigrid", "active-set"])
def test_the_packages_own_methods_have_one_default(name):
    numbers, named = cq.solve(HEXAGON, name), cq.solve(HEXAGON, name, tol="default")
    np.testing.assert_array_equal(numbers.gap, named.gap)
    assert named.status == "certified"


def test_a_polish_that_makes_the_answer_worse_is_a_finding():
    """OSQP does not look at the sign of the multipliers that it polishes with."""
    solution = cq.solve(touching_softly(63, 1.0), "osqp", rho=0.01)
    assert solution.status == "certified"
    (finding,) = solution.findings
    assert finding.startswith("polish made the answer worse: bound ")
    after, before = (float(finding.split(word)[0].split()[-1]) for word in (" after", " before"))
    assert after > 10 * before > 0
    assert finding in repr(solution)


def test_a_polish_asked_for_beside_own_defaults_is_measured_too():
    model = touching_softly(31, 0.01)
    options = {"rho": 0.01}
    plain = cq.solve(model, "osqp", tol="default", on_failure="ignore", **options)
    solution = cq.solve(model, "osqp", tol="default", on_failure="ignore", polishing=True, **options)
    assert plain.findings == ()
    assert "polish made the answer worse" in solution.findings[0]
    np.testing.assert_array_equal(solution.gap, plain.gap)
    good = cq.solve(HEXAGON, "osqp", tol="default", on_failure="ignore", polishing=True, eps=1e-5)
    assert (good.status, good.findings) == ("certified", ())


def test_a_good_polish_is_no_finding():
    assert cq.solve(HEXAGON, "osqp", tol=1e-9).findings == ()


def test_a_claim_is_the_backends_own_word():
    assert Answer(None, Stop.DONE, "", 0, 0.0, 0.0).claimed
    assert not Answer(None, Stop.FAILED, "", 0, 0.0, 0.0).claimed
    assert not Answer(None, Stop.DONE, "", 0, 0.0, 0.0, claimed_solved=False).claimed
    hopeless = cq.solve(cq.gallery.bowl(15), "psor", tol=1e-17, on_failure="ignore")
    assert (hopeless.termination.startswith("steps are rounding errors"), hopeless.claimed_solved) == (True, False)
    assert cq.solve(cq.gallery.bowl(15), "psor").claimed_solved
    for name in ("multigrid", "active-set", "osqp", "clarabel", "mangasarian"):
        assert cq.solve(cq.gallery.bowl(15), name, tol=1e-5).claimed_solved


def test_a_round_that_ended_well_at_a_loose_tolerance_is_no_claim():
    cut = cq.solve(HEXAGON, "osqp", tol=1e-12, max_iter=25, on_failure="ignore", eps=0.5)
    assert cut.termination == "solved, eps 5e-01"
    assert (cut.status, cut.claimed_solved) == ("iteration_limit", False)
