"""Answers of programs that know nothing of contactqp, certified; and models written a second time, independently."""

from typing import Any

import cvxpy
import numpy as np
import pytest
import qpsolvers
from scipy import sparse

import contactqp as cq
from contactqp.testing import assert_complementary

cp: Any = cvxpy
MODEL = cq.gallery.paper_hexagon(0.05)


def test_cvxpy_solves_the_same_problem_stated_as_an_energy():
    """Minimise ½Σ T (difference along an arm)² - Σ P w over w ≤ f: no matrix of ours, no gap variable."""
    rows, columns = MODEL.lattice.shape
    w = cp.Variable((rows, columns))
    frame = ~MODEL.lattice.mask
    load = MODEL.lattice.scatter(MODEL.nodal_load, fill=0.0)
    support = MODEL.lattice.scatter(MODEL.support, fill=0.0)
    energy = 0.5 * (cp.sum_squares(cp.diff(w, axis=0)) + cp.sum_squares(cp.diff(w, axis=1))) - cp.sum(
        cp.multiply(load, w)
    )
    constraints = [cp.multiply(frame, w) == 0, cp.multiply(~frame, w) <= support]
    cp.Problem(cp.Minimize(energy), constraints).solve(
        solver=cp.CLARABEL, tol_gap_abs=1e-14, tol_gap_rel=1e-14, tol_feas=1e-10
    )
    deflection = MODEL.lattice.gather(w.value)
    verdict = assert_complementary(MODEL, MODEL.support - deflection, tol=1e-5)
    ours = cq.solve(MODEL, "psor")
    np.testing.assert_allclose(ours.deflection, deflection, atol=verdict.certificate.gap_bound + 2e-6)
    energy_of_shut_gap = 0.5 * MODEL.support @ (MODEL.problem.G @ MODEL.support) - MODEL.nodal_load @ MODEL.support
    assert energy.value - energy_of_shut_gap == pytest.approx(ours.residuals.objective, abs=1e-4)


@pytest.mark.filterwarnings("ignore:The default value of raise_error:PendingDeprecationWarning")
@pytest.mark.parametrize(
    "solver", sorted(set(qpsolvers.available_solvers) & {"osqp", "clarabel", "piqp", "scs", "highs"})
)
def test_qpsolvers_answers_can_be_certified(solver):
    problem = cq.gallery.bowl(15).problem
    size = problem.size
    accuracy = {
        "osqp": {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 20_000},
        "clarabel": {"tol_gap_abs": 1e-13, "tol_gap_rel": 1e-13},
        "scs": {"eps_abs": 1e-10, "eps_rel": 1e-10},
    }.get(solver, {})
    gap = qpsolvers.solve_qp(
        sparse.csc_matrix(problem.G), problem.q, lb=np.zeros(size), ub=np.full(size, 1e3), solver=solver, **accuracy
    )
    certificate = cq.certify(problem, gap)
    exact = cq.solve(problem, "osqp", tol=1e-11)
    assert certificate.gap_bound < 1e-2 * problem.gap_scale
    assert np.abs(gap - exact.gap).max() <= certificate.gap_bound * (1 + 1e-6)
    assert certificate.intersects(exact.certificate)
