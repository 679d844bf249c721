"""Sentences about a comparison: who agrees, who spoils it, who said what is not so."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..proof.status import Status
from .rows import Row

if TYPE_CHECKING:
    from .comparison import Comparison


def verdict_of(comparison: Comparison) -> str:
    """Return one sentence: agreement, or who spoils it and why, and whose claims are false."""
    if comparison.agree:
        largest = max((pair.gap_difference for pair in comparison.pairs), default=0.0)
        differing = max((pair.differing_nodes.size for pair in comparison.pairs), default=0)
        proven = all(row.status == Status.CERTIFIED for row in comparison.rows)
        proof = "certified" if proven else "within tol by their residuals"
        same = "the same contact set" if not differing else f"contact sets that differ in up to {differing} nodes"
        return f"All {len(comparison.rows)} backends agree: {proof}, max gap difference {largest:.2g}, {same}."
    reasons = "; ".join(f"{name} {why}" for name, why in comparison.culprits.items())
    false = comparison.false_claims
    claims = f" Said to have solved it, and did not ({len(false)}): {', '.join(false)}." if false else ""
    return f"No agreement: {reasons or 'no backend was asked'}.{claims}"


def culprits_of(comparison: Comparison) -> dict[str, str]:
    """Return why there is no agreement, see `Comparison.culprits`."""
    found = {row.backend: _complaint(comparison, row) for row in comparison.rows if not row.ok}
    if found or all(pair.consistent for pair in comparison.pairs):
        return found
    conflicts = dict.fromkeys(comparison.solutions, 0)
    for pair in comparison.pairs:
        if not pair.consistent:
            conflicts[pair.first] += 1
            conflicts[pair.second] += 1
    most = max(conflicts.values())
    return {
        name: f"excludes the answers of {count} of {len(comparison.solutions) - 1} other backends"
        for name, count in conflicts.items()
        if count == most
    }


def findings_of(comparison: Comparison) -> tuple[str, ...]:
    """Return what went wrong on the way, see `Comparison.findings`."""
    found = [f"{row.backend}: {finding}" for row in comparison.rows for finding in row.findings]
    for pair in comparison.pairs:
        first, second = (comparison.solutions[name].certificate for name in (pair.first, pair.second))
        if first is not None and second is not None and not pair.consistent:
            nodes = np.count_nonzero(np.maximum(first.lower, second.lower) > np.minimum(first.upper, second.upper))
            found.append(
                f"the enclosures of {pair.first} and {pair.second} contradict each other at {nodes} "
                f"node{'' if nodes == 1 else 's'}, so the truth is not enclosed"
            )
    return tuple(found)


def false_claims_of(comparison: Comparison) -> dict[str, str]:
    """Return who said to have solved the problem and had not, see `Comparison.false_claims`."""
    return {
        row.backend: _refutation(comparison, row)
        for row in comparison.rows
        if row.claimed and not row.ok and not _proven_by_others(comparison, row)
    }


def _proven_by_others(comparison: Comparison, row: Row) -> bool:
    return row.relative_true_error is not None and row.relative_true_error <= comparison.tol


def _refutation(comparison: Comparison, row: Row) -> str:
    """Return what a backend said, and how far off its answer is at least, as far as it is known."""
    said = f"said {row.message!r}"
    asked = f"(asked for: {comparison.tol:g})"
    if row.relative_bound is None:
        return f"{said}, and returned no finite answer"
    if row.true_error_lower is None or row.true_error_upper is None or row.relative_true_error is None:
        return f"{said}, and its residual is {row.relative_bound:.2g} of the gap scale {asked}"
    least = row.relative_true_error * (row.true_error_lower / row.true_error_upper)
    if least > comparison.tol:
        return f"{said}, and its gap is wrong by at least {least:.2g} of the gap scale {asked}"
    return f"{said}, and its gap is proven no better than to {row.relative_true_error:.2g} of the gap scale {asked}"


def _complaint(comparison: Comparison, row: Row) -> str:
    if row.relative_bound is None or row.natural_residual is None:
        return f"({row.status}: {row.message})"
    scale = comparison.problem.gap_scale
    stiffness = float(comparison.problem.stiffness.diagonal().max())
    violations = {
        f"min gap {row.min_gap:.2g}": -(row.min_gap or 0.0) / scale,
        f"min reaction {row.min_reaction:.2g}": -(row.min_reaction or 0.0) / (stiffness * scale),
        f"natural residual {row.natural_residual:.2g}": row.natural_residual / scale,
    }
    worst = max(violations, key=lambda label: violations[label])
    return f"({row.status}: bound {row.relative_bound:.2g} > tol {comparison.tol:g}, {worst})"
