"""Assertions for the test suites of programs that solve contact problems."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..comparison.compare import compare
from ..comparison.comparison import Comparison
from ..foundation.checks import Mask, Vector, finite_number, open_interval
from ..foundation.text import at_upper_bound
from ..geometry.fields import Rows
from ..models.base import ContactModel, at_unknowns
from ..problem.contact_problem import ContactProblem
from ..proof.certificate import Certificate
from ..proof.judge import Verdict, judge
from ..proof.status import Status
from ..solving.solution import Solution

_ROUNDINGS = 16
"""Units of rounding of its largest value that a reference may be wrong by: formed as f - w, or summed up elsewhere."""

_SHOWN = 5
"""A message shows at most this many of the nodes that fail."""


def assert_complementary(
    problem: ContactProblem | ContactModel, gap: ArrayLike, *, tol: float = 1e-6, rows: Rows | None = None
) -> Verdict:
    """Assert that ``gap`` solves the problem: certified within ``tol`` of the error scale.

    A small residual is not enough: where nothing is proven, the assertion fails.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet, ContactQP or ContactLCP
    gap : array, shape (n,), or xarray.DataArray, or Solution
        The claimed solution ω (length), from any program; on a lattice also an array of its shape.
    tol : float
        As for `contactqp.solve`.
    rows : {"up", "down"}, optional
        As for `contactqp.certify`.

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
    gap does not solve Cable(9 nodes, spacing=1, tension=1, load=1, support=2):
    certified bound 0.053 > 1e-06 of the error scale
      worst node 1 (x=2, y=0): gap 0.1, reaction 0.5, min(gap, R/G_ii) = 0.1
      min gap 0.1, min reaction 0.1, gap·R 0.72
    """
    __tracebackhide__ = True  # pytest then points at the line of the test
    algebra = problem.problem if isinstance(problem, ContactModel) else problem
    omega, bounds = at_unknowns(problem, gap, "gap", rows=rows), algebra.bounds
    verdict = judge(algebra, omega, open_interval(tol, 0.0, 1.0, "tol"))
    if verdict.status.ok:
        return verdict
    residuals = verdict.residuals
    assert residuals is not None
    reaction = algebra.reaction(omega)
    natural = bounds.natural_map(omega, reaction / algebra.stiffness.diagonal())
    formula = "min(gap, R/G_ii)" if bounds.standard else "min(gap - lower, R/G_ii)"
    formula = formula if bounds.one_sided else f"max(gap - upper, {formula})"
    worst = int(np.argmax(np.abs(natural)))
    found = f"certified bound {verdict.relative_bound:.2g} > {tol:g} of the error scale"
    if verdict.certificate is None:
        found = f"no bound is known for such a matrix; residual {verdict.relative_residual:.2g} of the error scale"
    claim = "is not proven to solve" if verdict.status is Status.UNPROVEN else "does not solve"
    raise AssertionError(
        f"gap {claim} {problem!r}: {found}\n"
        f"  worst {_name_node(problem, worst)}: gap {omega[worst]:.6g}, reaction {reaction[worst]:.6g}, "
        f"{formula} = {natural[worst]:.3g}\n"
        f"  min gap {residuals.min_gap:.3g}, min reaction {residuals.min_reaction:.3g}, "
        f"gap·R {residuals.complementarity:.3g}"
    )


def assert_backends_agree(
    problem: ContactProblem | ContactModel, backends: Sequence[str] | None = None, *, tol: float = 1e-6
) -> Comparison:
    """Assert that all ``backends`` solve the problem, certified to ``tol``, with enclosures that intersect.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet, ContactQP or ContactLCP
    backends : sequence of str, optional
        Names, see `contactqp.backend_names`; by default those that `contactqp.compare` takes: the installed ones, of
        other distributions too, whose methods suit the problem and are practical at its size.
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
    __tracebackhide__ = True
    comparison = compare(problem, backends, tol=tol)
    if comparison.agree:
        return comparison
    raise AssertionError(f"{comparison.verdict()}\n{comparison!r}\n{_worst_difference(problem, comparison)}".rstrip())


def assert_encloses(
    certificate: Certificate | Solution, gap: ArrayLike, *, slack: float = 0.0, rows: Rows | None = None
) -> None:
    """Assert that a reference solution lies within proven bounds, node by node.

    The bounds of an answer that is not as good as was asked for are too wide to say anything of it, so that the
    assertion fails for a `Solution` whose status is not ok, wherever ``gap`` lies.

    Parameters
    ----------
    certificate : Certificate or Solution
        The bounds. A solution knows its status and its nodes too, so that messages can give coordinates; of a
        certificate alone nobody knows how narrow it was to be.
    gap : array, shape (n,), or xarray.DataArray, or Solution
        The reference ω (length): an exact solution, or another program's; on a lattice also an array of its shape.
    slack : float
        How wrong ``gap`` itself may be (length), >= 0; it widens the bounds. What the rounding of ``gap`` amounts to,
        and the proven error of a `Solution` that is given for it, are allowed for in any case.
    rows : {"up", "down"}, optional
        As for `contactqp.certify`.

    Raises
    ------
    AssertionError
        With the nodes that lie farthest outside and their bounds; also if there are no finite bounds to lie within, or
        the solution is not ok.
    TypeError, ValueError
        If an argument has the wrong kind, shape or range.

    Examples
    --------
    >>> import contactqp as cq
    >>> cable, deflection = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    >>> solution = cq.solve(cable, backend="clarabel", tol=1e-9)
    >>> gap = cable.support - deflection
    >>> assert_encloses(solution, gap)
    >>> gap[8] = 0.75
    >>> try:
    ...     assert_encloses(solution, gap)
    ... except AssertionError as error:
    ...     print(error)
    gap leaves the bounds of clarabel's answer to Cable(9 nodes, spacing=1, tension=1, load=1, support=2)
    at 1 of 9 nodes
      node 8 (x=9, y=0): gap 0.75 is 0.25 above the upper bound 0.5
      expected: lower <= gap <= upper at every node
      The bounds are proven: gap solves another problem (compare loads, supports and the order of the nodes),
      or it is known to within 0.25 only, which slack would say.
    """
    __tracebackhide__ = True
    bounds = certificate.certificate if isinstance(certificate, Solution) else certificate
    if isinstance(certificate, Solution) and bounds is None:
        raise AssertionError(f"{_whose(certificate)} has no bounds: {_why_unproven(certificate)}")
    if not isinstance(bounds, Certificate):
        raise TypeError(f"certificate must be a Certificate or a Solution, got {type(certificate).__name__}")
    omega = at_unknowns(bounds.problem if bounds.model is None else bounds.model, gap, "gap", rows=rows)
    slack = finite_number(slack, "slack")
    if slack < 0:
        raise ValueError(f"slack must be >= 0, got {slack:g}")
    if isinstance(certificate, Solution):
        _refuse_what_is_not_ok(certificate)
    of = f" of {_whose(certificate)}" if isinstance(certificate, Solution) else ""
    if not np.isfinite(bounds.gap_bound):
        raise AssertionError(f"the bounds{of} are infinite and would enclose any gap: scale the problem's numbers")
    excess = np.maximum(bounds.lower - omega, omega - bounds.upper)
    outside = np.flatnonzero(excess > slack + _own_error(gap, omega))
    if not outside.size:
        return

    def line(node: int) -> str:
        low, high, value = bounds.lower[node], bounds.upper[node], omega[node]
        side = f"above the upper bound {high:.9g}" if value > high else f"below the lower bound {low:.9g}"
        return f"{_name_node(certificate, node)}: gap {value:.9g} is {excess[node]:.3g} {side}"

    worst = outside[np.argsort(-excess[outside], kind="stable")]
    wanted = f"lower - {slack:g} <= gap <= upper + {slack:g}" if slack else "lower <= gap <= upper"
    raise AssertionError(
        f"gap leaves the bounds{of} at {outside.size} of {omega.size} nodes\n"
        f"{_list_nodes(worst, line)}\n"
        f"  expected: {wanted} at every node\n"
        "  The bounds are proven: gap solves another problem (compare loads, supports and the order of the nodes),\n"
        f"  or it is known to within {excess.max():.2g} only, which slack would say."
    )


def _own_error(gap: ArrayLike | Solution, values: Vector) -> float:
    """Return how wrong a reference is in any case (length): by rounding, and an answer by what is proven of it."""
    rounding = _ROUNDINGS * float(np.finfo(np.float64).eps) * float(np.abs(values).max(initial=0.0))
    proof = gap.certificate if isinstance(gap, Solution) else None
    return rounding if proof is None else rounding + proof.gap_bound


def assert_same_contact(first: Solution | ArrayLike, second: Solution | ArrayLike, *, rows: Rows | None = None) -> Mask:
    """Assert that two solutions have the same nodes in contact, except where either certificate leaves it undecided.

    One of the two may be a mask of the nodes in contact, by any program.

    A node that the lower bound holds in one solution and the upper bound in the other is not the same.

    Parameters
    ----------
    first, second : Solution, or array of bool
        Answers on the same nodes, by any backends and to any tolerances; also to two problems that should be one. Or
        one answer, and a mask: shape (n,), or on a lattice of the lattice's shape, or an xarray.DataArray.
    rows : {"up", "down"}, optional
        Which way the rows of a mask go, as for `contactqp.certify`.

    Returns
    -------
    array of bool, shape (n,)
        The nodes that were compared.

    Raises
    ------
    AssertionError
        With the number of nodes that differ, and the first of them with their gaps and reactions; also if there is no
        node to compare, or one of the solutions is not ok.
    TypeError, ValueError
        If an argument is no solution, or the two are on different nodes.

    Examples
    --------
    >>> import contactqp as cq
    >>> cable, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=2)
    >>> loose = cq.solve(cable, "osqp", tol=1e-2)
    >>> compared = assert_same_contact(loose, cq.solve(cable, "clarabel"))
    >>> int(compared.sum())
    9
    >>> deeper, _ = cq.gallery.cable_on_floor(nodes=9, contact_starts_after=3)
    >>> try:
    ...     assert_same_contact(cq.solve(deeper, "active-set"), cq.solve(cable, "active-set"))
    ... except AssertionError as error:
    ...     print(error)
    contact sets differ at 2 of 9 nodes
      first:  5 in contact, active-set's answer to Cable(9 nodes, spacing=1, tension=1, load=1, support=4.5)
      second: 7 in contact, active-set's answer to Cable(9 nodes, spacing=1, tension=1, load=1, support=2)
      node 1 (x=2, y=0): free in the first (gap 0.5, reaction ...), in contact in the second (gap 0, reaction 0.5)
      node 7 (x=8, y=0): free in the first (gap 0.5, reaction ...), in contact in the second (gap 0, reaction 0.5)
      expected: the same at the 9 nodes that no certificate leaves undecided
      Both are proven, so these are two problems: their forces q differ at 2 nodes; compare loads, supports and
      tensions.
    """
    __tracebackhide__ = True
    if isinstance(first, Solution) != isinstance(second, Solution):
        pair: tuple[Any, Any] = (first, second) if isinstance(first, Solution) else (second, first)
        return _assert_contact(pair[0], _mask_of(*pair, rows))
    if not (isinstance(first, Solution) and isinstance(second, Solution)):
        raise TypeError(
            f"first or second must be a Solution, as contactqp.solve returns it, got {type(first).__name__} and "
            f"{type(second).__name__}"
        )
    _refuse_other_nodes(first, second)
    for solution in (first, second):
        if solution.residuals is None:
            raise AssertionError(f"{_whose(solution)} has no contact set: {_why_unproven(solution)}")
        _refuse_what_is_not_ok(solution)
    proofs = [solution.certificate for solution in (first, second) if solution.certificate is not None]
    compared = np.ones(first.gap.size, dtype=np.bool_)
    for proof in proofs:
        compared &= ~proof.undecided
    if not compared.any():
        raise AssertionError(
            f"all {compared.size} nodes are undecided, there is no contact to compare: solve with a smaller tol than "
            f"{first.tol:g} and {second.tol:g}"
        )
    other = (first.contact_lower != second.contact_lower) | (first.contact_upper != second.contact_upper)
    differing = np.flatnonzero(other & compared)
    if not differing.size:
        return compared

    def line(node: int) -> str:
        views = (
            f"{_state(solution, node)} in the {place} "
            f"(gap {solution.gap[node]:.6g}, reaction {solution.reaction[node]:.6g})"
            for place, solution in (("first", first), ("second", second))
        )
        return f"{_name_node(first, node)}: {', '.join(views)}"

    raise AssertionError(
        f"contact sets differ at {differing.size} of {compared.size} nodes\n"
        f"  first:  {_count_contact(first)}, {_whose(first)}\n"
        f"  second: {_count_contact(second)}, {_whose(second)}\n"
        f"{_list_nodes(differing, line)}\n"
        f"  expected: the same at the {int(compared.sum())} nodes that no certificate leaves undecided\n"
        f"  {_why_contact_differs(first, second)}"
    )


def _mask_of(solution: Solution, mask: ArrayLike, rows: Rows | None) -> Mask:
    """Return a mask of a solution's nodes, shape (n,); it may be laid out on the lattice."""
    values: Any = np.ma.asarray(mask)
    if values.dtype != np.bool_:
        raise TypeError(
            f"a mask of the nodes in contact must be boolean, got dtype {values.dtype}; compare it first, e.g. gap <= 0"
        )
    numbers = getattr(mask, "astype", values.astype)(np.float64)
    return np.asarray(at_unknowns(solution.subject, numbers, "the mask", rows=rows) != 0)


def _assert_contact(solution: Solution, mask: Mask) -> Mask:
    """Assert that a solution's nodes in contact are those of a mask; see `assert_same_contact`."""
    __tracebackhide__ = True
    if solution.residuals is None:
        raise AssertionError(f"{_whose(solution)} has no contact set: {_why_unproven(solution)}")
    _refuse_what_is_not_ok(solution)
    proof = solution.certificate
    compared = np.ones(mask.size, dtype=np.bool_) if proof is None else ~proof.undecided
    if not compared.any():
        raise AssertionError(
            f"all {compared.size} nodes are undecided, there is no contact to compare: solve with a smaller tol than "
            f"{solution.tol:g}"
        )
    differing = np.flatnonzero((solution.contact != mask) & compared)
    if not differing.size:
        return compared

    def line(node: int) -> str:
        there = "in contact" if mask[node] else "free"
        numbers = f"gap {solution.gap[node]:.6g}, reaction {solution.reaction[node]:.6g}"
        return f"{_name_node(solution, node)}: {_state(solution, node)} ({numbers}), {there} in the mask"

    raise AssertionError(
        f"contact sets differ at {differing.size} of {compared.size} nodes\n"
        f"  solution: {_count_contact(solution)}, {_whose(solution)}\n"
        f"  mask:     {int(mask.sum())} in contact\n"
        f"{_list_nodes(differing, line)}\n"
        f"  expected: the same at the {int(compared.sum())} nodes that the certificate does not leave undecided"
    )


def _refuse_other_nodes(first: Solution, second: Solution) -> None:
    if first.gap.size != second.gap.size:
        raise ValueError(
            f"first and second must be on the same nodes, got {first.gap.size} and {second.gap.size} nodes"
        )
    if first.model is None or second.model is None:
        return
    here, there = first.model, second.model
    moved = np.flatnonzero((here.node_x != there.node_x) | (here.node_y != there.node_y))
    if moved.size:
        raise ValueError(
            f"first and second must be on the same nodes, got {here.describe(moved[0])} and {there.describe(moved[0])}"
        )


def _refuse_what_is_not_ok(solution: Solution) -> None:
    if not solution.status.ok:
        raise AssertionError(
            f"{_whose(solution)} is {solution.status.value}, bound {solution.relative_bound:.2g} of the error scale, "
            f"wanted {solution.tol:g} ({solution.termination}). {solution.advice}"
        )


def _why_unproven(solution: Solution) -> str:
    if solution.residuals is None:
        return f"no finite answer, {solution.status} ({solution.termination}). {solution.advice}"
    return "no enclosure is known for such a matrix"


def _why_contact_differs(first: Solution, second: Solution) -> str:
    """Return what to try: two certificates that decide a node differently belong to two problems."""
    other = np.count_nonzero(first.problem.q != second.problem.q)
    if other:
        difference = f"their forces q differ at {other} nodes; compare loads, supports and tensions"
    elif (first.problem.supported != second.problem.supported).any():
        difference = "other nodes have a support"
    elif moved := _count_other_bounds(first.problem, second.problem):
        difference = f"their bounds differ at {moved} nodes"
    else:
        difference = "their forces q are equal, so their matrices differ"
    return f"Both are proven, so these are two problems: {difference}."


def _count_other_bounds(first: ContactProblem, second: ContactProblem) -> int:
    return int(np.count_nonzero((first.lower != second.lower) | (first.upper != second.upper)))


def _state(solution: Solution, node: int) -> str:
    if solution.contact_upper[node]:
        return "at the upper bound"
    held = "in contact" if solution.problem.one_sided else "at the lower bound"
    return held if solution.contact_lower[node] else "free"


def _count_contact(solution: Solution) -> str:
    upper = None if solution.problem.one_sided else int(solution.contact_upper.sum())
    return f"{int(solution.contact.sum())} in contact{at_upper_bound(upper)}"


def _list_nodes(nodes: NDArray[np.intp], line: Callable[[int], str]) -> str:
    shown = [f"  {line(int(node))}" for node in nodes[:_SHOWN]]
    if nodes.size > _SHOWN:
        shown.append(f"  and {nodes.size - _SHOWN} more")
    return "\n".join(shown)


def _whose(solution: Solution) -> str:
    return f"{solution.backend}'s answer to {solution.subject!r}"


def _worst_difference(problem: ContactProblem | ContactModel, comparison: Comparison) -> str:
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


def _name_node(subject: ContactProblem | ContactModel | Certificate | Solution, node: int) -> str:
    known = subject.model if isinstance(subject, Solution) else subject
    return known.describe(node) if isinstance(known, ContactModel) else f"node {node}"
