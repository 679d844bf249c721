"""Solvers of quadratic programs that other packages call by name: one row a solver, the same for every such package.

Where a solver has settings of its own for a tolerance, a limit of iterations or of time, the row names them, so that
``tol``, ``max_iter`` and ``time_limit`` mean the same for all. Sizes and tolerances were measured on two cores by
``benchmarks/backends.py``; the licences are those that the solvers' own distributions declare.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Through:
    """A solver as one package calls it.

    Attributes
    ----------
    practical_size : int or None
        See `contactqp.backends.base.Backend`.
    reachable_tol : float or None
        See `contactqp.backends.base.Backend`; None if it certifies no power of ten at all ten loads.
    counted : bool
        Whether the package tells iterations, and passes on a limit of them; else calls are counted.
    settings : mapping of str to object
        What this package must be told in any case, with the solver's defaults too.
    also : tuple of str
        Settings that the package takes beside the solver's own.
    """

    practical_size: int | None = None
    reachable_tol: float | None = None
    counted: bool = True
    settings: Mapping[str, Any] = field(default_factory=dict)
    also: tuple[str, ...] = ()


@dataclass(frozen=True)
class Facts:
    """What there is to know of a solver in order to call it.

    Attributes
    ----------
    package : str
        Its distribution on PyPI.
    method : str
        In a few words.
    licence : str
    tolerances : tuple of str
        Its settings that are given the tolerance of a round; without one there is one round.
    order : int
        The first tolerance is the wanted one to this power: an interior point with tolerance eps leaves √eps of a gap
        whose reaction is as small.
    tightest : float
        The last tolerance.
    most : int
        Iterations in one round.
    iterations, seconds : str
        Its settings for limits of iterations and of time, "" where it has none.
    settings : mapping of str to object
        Other settings that differ from those it is shipped with.
    settings_at : str
        Where its library tells the names of all its settings, as attributes, see `contactqp.backends.setting_names`; ""
        where it tells none.
    setting_names : tuple of str
        Names of settings that its library does not tell there.
    dense : bool
        Whether it takes matrices with all their zeros.
    triangle : bool
        Whether it is given the lower triangle of the matrix: not all releases of qpsolvers leave out what stands above
        it, and HiGHS does not read that as it is meant.
    box : bool
        Whether it takes bounds as they are; else as rows.
    definite : bool
        Whether it relies on a positive definite matrix.
    warm : bool
        Whether it takes a warm start.
    repeatable : bool
        See `contactqp.backends.base.Backend`.
    quick : float
        Unknowns up to which a call takes less than a second or so, or the solver answers Ctrl-C and watches the clock
        itself. Beyond it is called in a process of its own, see `contactqp.backends.processes`; a solver without a row
        is not, since that process might not know it.
    greets : str
        ``module:callable`` of what prints a greeting when it is called for the first time in a process.
    through : mapping of str to Through
        By the package that calls it.
    """

    package: str
    method: str
    licence: str
    tolerances: tuple[str, ...] = ()
    order: int = 1
    tightest: float = np.inf
    most: int = 200
    iterations: str = ""
    seconds: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    settings_at: str = ""
    setting_names: tuple[str, ...] = ()
    dense: bool = False
    triangle: bool = False
    box: bool = True
    definite: bool = False
    warm: bool = False
    repeatable: bool = True
    quick: float = np.inf
    greets: str = ""
    through: Mapping[str, Through] = field(default_factory=dict)


_EPS = ("eps_abs",)
_ABSOLUTE = {"eps_rel": 0.0}

_PROXQP = (
    *("check_duality_gap", "compute_preconditioner", "compute_timings", "default_H_eigenvalue_estimate"),
    *("eps_duality_gap_abs", "eps_duality_gap_rel", "initial_guess", "primal_infeasibility_solving", "sparse_backend"),
    *("verbose", "x", "y", "z"),
)
_SCS = (
    *("acceleration_interval", "acceleration_lookback", "acceleration_regularization", "acceleration_relaxation"),
    *("acceleration_type_1", "adaptive_scale", "alpha", "eps_infeas", "linear_solver", "log_csv_filename", "normalize"),
    *("rho_x", "scale", "write_data_filename"),
)
_DAQP = (
    *("cycle_tol", "dual_tol", "eps_prox", "eta_prox", "fval_bound", "iter_limit", "pivot_tol", "progress_tol"),
    "zero_tol",
)
_DAQP_OWN = (
    *("abs_subopt", "dual_start", "eq_reduction", "presolve", "refactor_tol", "rel_subopt", "rho_soft", "sing_tol"),
    *("time_limit", "verbose"),
)
"""What the solvers themselves take and, of an unknown name, refuse in other words than ours, or drop."""

SOLVERS: Mapping[str, Facts] = {
    "piqp": Facts(
        "piqp",
        "proximal interior point",
        "BSD-2-Clause",
        tolerances=("eps_abs", "eps_duality_gap_abs"),
        order=2,
        tightest=1e-15,
        iterations="max_iter",
        settings={"eps_rel": 0.0, "eps_duality_gap_rel": 0.0},
        settings_at="piqp:SparseSolver().settings",
        quick=8000,
        through={
            "qpsolvers": Through(20_000, 1e-13, also=("backend",)),
            "cvxpy": Through(20_000, 1e-13, also=("backend",)),
        },
    ),
    "proxqp": Facts(
        "proxsuite",
        "proximal augmented Lagrangian",
        "BSD-2-Clause",
        tolerances=_EPS,
        tightest=1e-14,
        most=10_000,
        iterations="max_iter",
        settings=_ABSOLUTE,
        warm=True,
        repeatable=False,
        setting_names=("backend", "mu_eq", "mu_in", "rho"),
        quick=1000,
        through={
            "qpsolvers": Through(3000, 1e-14, also=_PROXQP),
            "cvxpy": Through(1000, 1e-13),
        },
    ),
    "highs": Facts(
        "highspy",
        "active sets",
        "MIT",
        tolerances=("primal_feasibility_tolerance", "dual_feasibility_tolerance"),
        tightest=1e-10,
        seconds="time_limit",
        settings={"qp_regularization_value": 0.0},
        settings_at="highspy:HighsOptions()",
        setting_names=("hipo_system", "presolve_rule_off", "qp_allow_hot_start"),
        triangle=True,
        box=False,  # before 1.16 it is wrong where there are no rows and no bound is active
        definite=True,
        greets="highspy:Highs",
        quick=1000,
        through={
            "qpsolvers": Through(1000, 1e-13, counted=False, also=("verbose",)),
            "cvxpy": Through(1000, 1e-13, counted=False, also=("highs_options",)),
        },
    ),
    "scs": Facts(
        "scs",
        "operator splitting",
        "MIT",
        tolerances=_EPS,
        tightest=1e-14,
        most=50_000,
        iterations="max_iters",
        seconds="time_limit_secs",
        settings=_ABSOLUTE,
        setting_names=_SCS,
        warm=True,
        quick=10_000,
        through={
            "qpsolvers": Through(50_000, 1e-13, also=("verbose",)),
            "cvxpy": Through(50_000, 1e-13, also=("eps", "use_indirect", "use_quad_obj")),
        },
    ),
    "daqp": Facts(
        "daqp",
        "dual active sets",
        "MIT",
        tolerances=("primal_tol",),
        tightest=1e-12,
        setting_names=_DAQP,
        dense=True,
        definite=True,
        quick=1000,
        through={
            "qpsolvers": Through(1000, 1e-14, counted=False, also=_DAQP_OWN),
            "cvxpy": Through(1000, counted=False),
        },
    ),
    "quadprog": Facts(
        "quadprog",
        "dual active sets (Goldfarb, Idnani)",
        "GPL-2.0+",
        setting_names=("factorized",),
        dense=True,
        box=False,
        definite=True,
        quick=700,
        through={"qpsolvers": Through(1000, counted=False, also=("verbose",))},
    ),
    "ecos": Facts(
        "ecos",
        "interior point for cones",
        "GPL-3.0",
        tolerances=("abstol", "reltol", "feastol"),
        order=2,
        tightest=1e-15,
        iterations="max_iters",
        setting_names=("abstol_inacc", "feastol_inacc", "nitref", "reltol_inacc"),
        dense=True,
        box=False,
        definite=True,
        quick=1000,
        through={"qpsolvers": Through(1000, 1e-5, also=("verbose",)), "cvxpy": Through(1000, 1e-5)},
    ),
    "cvxopt": Facts(
        "cvxopt",
        "interior point for cones",
        "GPL-3.0+",
        tolerances=("abstol", "reltol"),
        tightest=1e-15,
        iterations="maxiters",
        setting_names=("debug", "feastol", "kktreg", "refinement", "use_correction"),
        box=False,
        quick=1000,
        through={
            "qpsolvers": Through(20_000, 1e-10, also=("verbose",)),
            "cvxpy": Through(300, counted=False, also=("kktsolver", "max_iters")),
        },
    ),
    "qpalm": Facts(
        "qpalm",
        "proximal augmented Lagrangian",
        "LGPL-3.0+",
        tolerances=_EPS,
        tightest=1e-14,
        most=10_000,
        iterations="max_iter",
        seconds="time_limit",
        settings=_ABSOLUTE,
        settings_at="qpalm:Settings()",
        warm=True,
        quick=10_000,
        through={"qpsolvers": Through(100_000, 1e-12), "cvxpy": Through(100_000, 1e-12)},
    ),
    "osqp": Facts(
        "osqp",
        "operator splitting",
        "Apache-2.0",
        tolerances=_EPS,
        tightest=1e-14,
        most=20_000,
        iterations="max_iter",
        seconds="time_limit",
        settings=_ABSOLUTE,
        settings_at="osqp:OSQP().ext.OSQPSettings",
        setting_names=("cg_preconditioner", "polish", "solver_type", "warm_start"),
        warm=True,
        quick=10_000,
        through={
            "qpsolvers": Through(50_000, 1e-13, also=("raise_error",)),
            # CVXPY asks for a last step, of which OSQP prints that it is not needed where there is no contact.
            "cvxpy": Through(50_000, 1e-13, settings={"polishing": False}),
        },
    ),
    "clarabel": Facts(
        "clarabel",
        "interior point",
        "Apache-2.0",
        tolerances=("tol_gap_abs", "tol_gap_rel"),
        order=2,
        tightest=1e-16,
        iterations="max_iter",
        seconds="time_limit",
        settings_at="clarabel:DefaultSettings()",
        box=False,
        quick=10_000,
        through={
            "qpsolvers": Through(50_000, 1e-13, counted=False),
            "cvxpy": Through(50_000, 1e-13, also=("accept_unknown", "use_quad_obj")),
        },
    ),
}
"""By the name that all such packages call a solver by."""

UNKNOWN = "a solver without a row in the table, as it is shipped"


def facts_of(solver: str, through: str) -> Facts:
    """Return what is known of a solver as a package calls it; of one that has no row, that it can be called.

    Parameters
    ----------
    solver, through : str
        Names of the solver and of the package.

    Examples
    --------
    >>> facts_of("piqp", "qpsolvers").package
    'piqp'
    >>> facts_of("gurobi", "qpsolvers").method
    'a solver without a row in the table, as it is shipped'
    """
    found = SOLVERS.get(solver)
    if found is not None and through in found.through:
        return found
    return Facts(through, UNKNOWN, "", through={through: Through(counted=False)})


def solvers_through(package: str) -> list[str]:
    """Return the names of the solvers in the table that a package calls.

    Examples
    --------
    >>> "quadprog" in solvers_through("qpsolvers"), "quadprog" in solvers_through("cvxpy")
    (True, False)
    """
    return [name for name, facts in SOLVERS.items() if package in facts.through]
