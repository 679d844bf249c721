"""Problems in the words of other packages, solved there."""

import cvxpy as cp
import numpy as np
import pytest
import qpsolvers
from scipy.optimize import linprog

import contactqp as cq

HEXAGON = cq.gallery.paper_hexagon()
BETWEEN = cq.ContactQP(
    2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1),
    [-3.0, 1.0, -0.5, 2.0, -1.0],
    lower=[0.0, -np.inf, -0.1, 0.2, 0.0],
    upper=[0.5, 0.3, np.inf, np.inf, 0.1],
)
LCP = cq.ContactLCP(
    np.diag(np.full(4, 3.0)) - np.diag(np.full(3, 2.0), -1) - np.diag(np.full(3, 0.5), 1), [-6.0, 0, 0, 1]
)


def holed():
    lattice = cq.Frame.rectangle(1.0, 1.0).lattice(0.125)
    return cq.Membrane(lattice, 1.0, load=4.0, support=lambda x, y: np.where(x < 0, 0.1, np.inf)).problem


@pytest.mark.parametrize("problem", [BETWEEN, HEXAGON.problem, holed()], ids=["two-sided", "hexagon", "holed"])
def test_dual_values_of_cvxpy_are_the_reactions(problem):
    program = problem.to_cvxpy()
    exact = cq.solve(problem, "active-set", tol=1e-12)
    program.problem.solve(solver="CLARABEL")
    scale = problem.gap_scale
    np.testing.assert_allclose(program.gap.value, exact.gap, atol=1e-4 * scale)
    held = np.where(problem.supported | np.isfinite(problem.upper), exact.reaction, 0.0)
    np.testing.assert_allclose(program.reaction, held, atol=1e-4 * scale * problem.stiffness.diagonal().max())


def test_another_load_is_another_value_of_the_parameter():
    program = BETWEEN.to_cvxpy()
    assert program.problem.is_dcp(dpp=True)
    assert program.q.value.tolist() == BETWEEN.q.tolist()
    for factor in (1.0, -0.5):
        program.q.value = factor * BETWEEN.q
        program.problem.solve(solver="CLARABEL")
        exact = cq.solve(BETWEEN.with_forces(factor * BETWEEN.q), tol=1e-12)
        np.testing.assert_allclose(program.gap.value, exact.gap, atol=1e-6)


def test_constraints_of_ones_own_may_be_added():
    program = BETWEEN.to_cvxpy()
    tied = cp.Problem(program.problem.objective, [*program.contact, program.gap[0] == program.gap[4]])
    tied.solve(solver="CLARABEL")
    assert program.gap.value[0] == pytest.approx(program.gap.value[4], abs=1e-8)
    assert program.gap.value[0] == pytest.approx(0.1, abs=1e-6)
    assert program.reaction.shape == (5,)


def test_reactions_before_solving_are_refused():
    with pytest.raises(ValueError, match=r"call problem\.solve\(\) first"):
        _ = BETWEEN.to_cvxpy().reaction


def test_a_problem_without_any_bound_has_no_constraints():
    program = cq.ContactQP(np.eye(2), [1.0, 2.0], lower=-np.inf).to_cvxpy()
    program.problem.solve(solver="CLARABEL")
    assert (program.contact, program.reaction.tolist()) == ((), [0.0, 0.0])
    np.testing.assert_allclose(program.gap.value, [-1.0, -2.0], atol=1e-6)


@pytest.mark.parametrize("problem", [BETWEEN, HEXAGON.problem], ids=["two-sided", "hexagon"])
def test_qpsolvers_solves_the_problem(problem):
    posed = problem.to_qpsolvers()
    found = qpsolvers.solve_problem(posed, solver="clarabel")
    assert found.is_optimal(1e-4)
    exact = cq.solve(problem, "active-set", tol=1e-12)
    np.testing.assert_allclose(found.x, exact.gap, atol=1e-4 * problem.gap_scale)
    posed.q[0] = 7.0
    assert problem.q[0] != 7.0


@pytest.mark.parametrize("problem", [HEXAGON.problem, holed(), LCP], ids=["hexagon", "holed", "not symmetric"])
def test_linprog_solves_the_problem(problem):
    found = linprog(**problem.to_linprog())
    assert found.status == 0
    exact = cq.solve(problem, "active-set", tol=1e-12)
    np.testing.assert_allclose(found.x, exact.gap, atol=1e-5 * problem.gap_scale)


def test_linear_programs_that_solve_nothing_are_refused():
    with pytest.raises(cq.UnsuitableProblemError, match="without upper bounds"):
        BETWEEN.to_linprog()
    with pytest.raises(cq.UnsuitableProblemError, match=r"but G\[0, 1\] = 0\.5"):
        cq.ContactQP([[2.0, 0.5], [0.5, 2.0]], [-1.0, 1.0]).to_linprog()


@pytest.mark.parametrize("name", ["to_cvxpy", "to_qpsolvers"])
def test_what_minimises_nothing_is_no_quadratic_program(name):
    with pytest.raises(cq.UnsuitableProblemError, match="no energy"):
        getattr(LCP, name)()


def test_a_missing_package_is_named(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(ImportError, match="to_cvxpy needs cvxpy: pip install 'cvxpy'"):
        BETWEEN.to_cvxpy()
