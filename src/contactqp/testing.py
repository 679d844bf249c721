"""Assertions for the test suites of programs that solve contact problems."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ._checks import Vector, open_interval, vector
from .compare import Comparison, compare
from .judge import Verdict, judge, natural_map
from .model import TensionedNet
from .problem import ContactQP


def assert_complementary(problem: ContactQP | TensionedNet, gap: ArrayLike, *, tol: float = 1e-6) -> Verdict:
    """Assert that ``gap`` solves the problem: certified within ``tol`` of the gap scale.

    For a matrix that is no M-matrix the natural residual must be within it.

    Parameters
    ----------
    problem : Membrane, Cable or ContactQP
    gap : array, shape (n,)
        The claimed solution ω (length), from any program.
    tol : float
        As for `contactqp.solve`.

    Returns
    -------
    Verdict
        Residuals and certificate, for further checks.

    Raises
    ------
    AssertionError
        With the worst node, its gap, its reaction and the bound.

    Examples
    --------
    >>> import contactqp as cq
    >>> cable, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    >>> solution = cq.solve(cable, backend="clarabel")
    >>> verdict = assert_complementary(cable, solution.gap)
    >>> try:
    ...     assert_complementary(cable, solution.gap + 0.1)
    ... except AssertionError as error:
    ...     print(error)
    gap does not solve Cable(9 nodes, spacing=1, tension=1): certified bound 0.053 > 1e-06 of the gap scale
      worst node 1 (x=2, y=0): gap 0.1, reaction 0.5, min(gap, R/G_ii) = 0.1
      min gap 0.1, min reaction 0.1, gap·R 0.72
    """
    algebra = problem.problem if isinstance(problem, TensionedNet) else problem
    omega = vector(gap, algebra.size, "gap")
    verdict = judge(algebra, omega, open_interval(tol, 0.0, 1.0, "tol"))
    if verdict.status.ok:
        return verdict
    residuals = verdict.residuals
    assert residuals is not None
    reaction = algebra.reaction(omega)
    natural = natural_map(algebra, omega, reaction)
    worst = int(np.argmax(np.abs(natural)))
    kind = "natural residual" if verdict.certificate is None else "certified bound"
    raise AssertionError(
        f"gap does not solve {problem!r}: {kind} {verdict.relative_bound:.2g} > {tol:g} of the gap scale\n"
        f"  worst {_name_node(problem, worst)}: gap {omega[worst]:.6g}, reaction {reaction[worst]:.6g}, "
        f"min(gap, R/G_ii) = {natural[worst]:.3g}\n"
        f"  min gap {residuals.min_gap:.3g}, min reaction {residuals.min_reaction:.3g}, "
        f"gap·R {residuals.complementarity:.3g}"
    )


def assert_backends_agree(
    problem: ContactQP | TensionedNet, backends: Sequence[str] | None = None, *, tol: float = 1e-6
) -> Comparison:
    """Assert that all ``backends`` solve the problem, certified to ``tol``, with enclosures that intersect.

    Parameters
    ----------
    problem : Membrane, Cable or ContactQP
    backends : sequence of str, optional
        Names, see `contactqp.backend_names`; by default the package's own whose methods suit the problem.
    tol : float
        As for `contactqp.solve`.

    Returns
    -------
    Comparison

    Raises
    ------
    AssertionError
        With the culprits, the table, and the node where two answers differ most.

    Examples
    --------
    >>> import contactqp as cq
    >>> comparison = assert_backends_agree(cq.gallery.islands(), ["osqp", "clarabel"])
    """
    comparison = compare(problem, backends, tol=tol)
    if comparison.agree:
        return comparison
    raise AssertionError(f"{comparison.verdict()}\n{comparison!r}\n{_worst_difference(problem, comparison)}".rstrip())


def _worst_difference(problem: ContactQP | TensionedNet, comparison: Comparison) -> str:
    if not comparison.pairs:
        return ""
    pair = max(comparison.pairs, key=lambda pair: pair.gap_difference)
    first, second = (comparison.solutions[name] for name in (pair.first, pair.second))
    worst = int(np.argmax(np.abs(first.gap - second.gap)))

    def at(name: str, gap: Vector, reaction: Vector) -> str:
        return f"{name} has gap {gap[worst]:.9g}, reaction {reaction[worst]:.3g}"

    return (
        f"largest difference at {_name_node(problem, worst)}: {at(pair.first, first.gap, first.reaction)}; "
        f"{at(pair.second, second.gap, second.reaction)}"
    )


def _name_node(problem: ContactQP | TensionedNet, node: int) -> str:
    return problem.lattice.describe(node) if isinstance(problem, TensionedNet) else f"node {node}"
