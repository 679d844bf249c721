"""A problem as other packages pose it: CVXPY, qpsolvers, and scipy's linear programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UnsuitableProblemError
from ..foundation.checks import Vector
from ..foundation.loading import load_modules, needed

if TYPE_CHECKING:
    from .posed import Posed


@dataclass(frozen=True, eq=False)
class ConvexProgram:
    """A contact problem as a `cvxpy.Problem`, with its parts by name.

    Attributes
    ----------
    problem : cvxpy.Problem
        min ½ωᵀGω + qᵀω subject to ``contact``. Its ``objective`` and ``constraints`` go into problems of your own.
    gap : cvxpy.Variable, shape (n,)
        ω (length).
    q : cvxpy.Parameter, shape (n,)
        The forces, with the problem's own as its value: another load is another value, and nothing is compiled anew,
        because the program follows CVXPY's rules for parameters (DPP). Of a model, P more load on the nodes is P more
        in q.
    lower, upper : cvxpy constraint or None
        ω ≥ l and ω ≤ u at the nodes that have such a bound; None where no node has one.
    """

    problem: Any
    gap: Any
    q: Any
    lower: Any
    upper: Any
    _lower_nodes: NDArray[np.intp]
    _upper_nodes: NDArray[np.intp]

    @property
    def contact(self) -> tuple[Any, ...]:
        """The constraints that there are, the lower one first."""
        return tuple(each for each in (self.lower, self.upper) if each is not None)

    @property
    def reaction(self) -> Vector:
        """Reactions at the nodes (force), shape (n,): the constraints' dual values, those of ``upper`` with a minus.

        Raises
        ------
        ValueError
            If the program, or the one that the constraints went into, has not been solved.
        """
        found = np.zeros(self.gap.size)
        for constraint, nodes, sign in ((self.lower, self._lower_nodes, 1.0), (self.upper, self._upper_nodes, -1.0)):
            if constraint is None:
                continue
            if constraint.dual_value is None:
                raise ValueError("there are no reactions yet: call problem.solve() first")
            found[nodes] += sign * np.atleast_1d(constraint.dual_value)
        return found


def convex_program(problem: Posed) -> ConvexProgram:
    """Return a problem with a symmetric matrix as a program of CVXPY; see `ContactProblem.to_cvxpy`."""
    cvxpy = needed("cvxpy", "to_cvxpy")
    gap = cvxpy.Variable(problem.size, name="gap")
    forces = cvxpy.Parameter(problem.size, name="q", value=np.array(problem.q))
    nodes = np.flatnonzero(problem.supported), np.flatnonzero(np.isfinite(problem.upper))
    lower = gap[nodes[0]] >= problem.lower[nodes[0]] if nodes[0].size else None
    upper = gap[nodes[1]] <= problem.upper[nodes[1]] if nodes[1].size else None
    # That G is positive semidefinite is proven before.
    energy = 0.5 * cvxpy.quad_form(gap, problem.G.tocsc(), assume_PSD=True) + forces @ gap
    constraints = [each for each in (lower, upper) if each is not None]
    return ConvexProgram(cvxpy.Problem(cvxpy.Minimize(energy), constraints), gap, forces, lower, upper, *nodes)


def qpsolvers_problem(problem: Posed) -> Any:
    """Return a problem with a symmetric matrix as a `qpsolvers.Problem`; see `ContactProblem.to_qpsolvers`."""
    qpsolvers = needed("qpsolvers", "to_qpsolvers")
    load_modules("scipy.sparse")
    from scipy import sparse

    bounds = {"lb": np.array(problem.lower), "ub": np.array(problem.upper)}
    return qpsolvers.Problem(sparse.csc_matrix(problem.G), np.array(problem.q), **bounds)


def linear_program(problem: Posed) -> dict[str, Any]:
    """Return the arguments of `scipy.optimize.linprog` for Mangasarian's program; see `ContactProblem.to_linprog`."""
    positive = problem.positive_off_diagonal
    if positive is not None:
        row, column, value = positive
        raise UnsuitableProblemError(
            f"to_linprog needs a matrix without positive off-diagonal entries, but G[{row}, {column}] = {value:g}: "
            "the least element of {w >= l, Gw + q >= 0} solves the problem for such matrices only"
        )
    if not problem.one_sided:
        raise UnsuitableProblemError(
            "to_linprog needs a problem without upper bounds: where one presses, the reaction is negative, and the "
            "solution does not lie in {w >= l, Gw + q >= 0}"
        )
    bounds = np.column_stack([problem.lower, problem.upper])
    return {"c": np.ones(problem.size), "A_ub": -problem.G, "b_ub": np.array(problem.q), "bounds": bounds}
