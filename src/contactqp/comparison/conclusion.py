"""Conclusion: what rows and pairs say of the backends, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..foundation.text import at_least, at_most
from ..problem.contact_problem import ContactProblem
from .answers import Answers
from .pairs import Pair
from .rows import Row


@dataclass(frozen=True)
class Conclusion:
    """Whether the backends agree; if not, who is to blame; and whose words were not to be relied on.

    Attributes
    ----------
    agree : bool
        Whether every backend was certified and every pair of enclosures intersects.
    culprits : mapping of str to str
        Why there is no agreement: backend to reason, empty if all agree. A backend is named if it returned no certified
        answer, with its worst optimality condition; or, where all look good and two still exclude each other, if its
        answer is consistent with fewer of the others than theirs are.
    false_claims : mapping of str to str
        By backend, of those that said they had solved the problem and are proven not to have: what they said, and what
        is known. The answer is no finite vector, or the certificates of all backends prove its error to be above tol.
    unproven_claims : mapping of str to str
        By backend, the same of those whose claims are neither proven nor refuted.
    findings : tuple of str
        What went wrong on the way, though it may not show in the answers: one sentence each.
    cautions : tuple of str
        Why even a certified answer may not be what was meant, by the best answer: see `Solution.cautions`.
    left_out : mapping of str to str
        By backend, why nobody asked it.
    sentence : str
        Agreement, or who spoils it and why, and whose claims are false.
    """

    agree: bool
    culprits: Mapping[str, str]
    false_claims: Mapping[str, str]
    findings: tuple[str, ...]
    cautions: tuple[str, ...]
    sentence: str
    left_out: Mapping[str, str] = field(default_factory=dict)
    unproven_claims: Mapping[str, str] = field(default_factory=dict)

    @property
    def remarks(self) -> list[str]:
        """Cautions, findings and false claims as lines, to be read below a table."""
        return [
            *(f"Caution: {caution}." for caution in self.cautions),
            *(f"Left out: {sentence}." for sentence in self.left_out_together),
            *(f"Finding: {finding}." for finding in self.findings),
            *(f"False claim: {name} {sentence}." for name, sentence in self.false_claims.items()),
            *(f"Unproven: {name} {sentence}." for name, sentence in self.unproven_claims.items()),
        ]

    @property
    def left_out_together(self) -> list[str]:
        """Who was not asked, and why: a sentence for each reason.

        Examples
        --------
        >>> why = {"a": "needs a lattice", "b": "is slow", "c": "needs a lattice"}
        >>> Conclusion(True, {}, {}, (), (), "", why).left_out_together
        ['b is slow', 'a, c: needs a lattice']
        """
        names: dict[str, list[str]] = {}
        for name, why in self.left_out.items():
            names.setdefault(why, []).append(name)
        alone = [f"{same[0]} {why}" for why, same in names.items() if len(same) == 1]
        return [*alone, *(f"{', '.join(same)}: {why}" for why, same in names.items() if len(same) > 1)]


def conclusion_of(
    answers: Answers, rows: Sequence[Row], pairs: Sequence[Pair], tol: float, left_out: Mapping[str, str] | None = None
) -> Conclusion:
    """Return what follows from the rows and pairs of some answers.

    Parameters
    ----------
    answers : Answers
    rows : sequence of Row
        One for each backend that was asked.
    pairs : sequence of Pair
        Every two of the finite answers.
    tol : float
        What was asked for, relative to each answer's error scale.
    left_out : mapping of str to str, optional
        By backend, why nobody asked it.
    """
    agree = bool(rows) and all(row.ok for row in rows) and all(pair.consistent for pair in pairs)
    culprits = _culprits(answers.problem, rows, pairs, tol)
    doubted = [row for row in rows if row.claimed and not row.ok and not _proven_by_others(row, tol)]
    false_claims = {row.backend: _refutation(row, tol) for row in doubted if _refuted(row, tol)}
    unproven_claims = {row.backend: _doubt(row, tol) for row in doubted if not _refuted(row, tol)}
    return Conclusion(
        agree=agree,
        culprits=culprits,
        false_claims=false_claims,
        findings=_findings(answers, rows, pairs),
        cautions=_cautions(answers),
        sentence=_agreement(rows, pairs) if agree else _disagreement(culprits, false_claims, unproven_claims),
        left_out=dict(left_out or {}),
        unproven_claims=unproven_claims,
    )


def _agreement(rows: Sequence[Row], pairs: Sequence[Pair]) -> str:
    largest = max((pair.gap_difference for pair in pairs), default=0.0)
    differing = max((pair.differing_nodes.size for pair in pairs), default=0)
    same = "the same contact set" if not differing else f"contact sets that differ in up to {differing} nodes"
    return f"All {len(rows)} backends agree: certified, max gap difference {largest:.2g}, {same}."


def _disagreement(
    culprits: Mapping[str, str], false_claims: Mapping[str, str], unproven_claims: Mapping[str, str]
) -> str:
    reasons = "; ".join(f"{name} {why}" for name, why in culprits.items())
    told = f"No agreement: {reasons or 'no backend was asked'}."
    if false_claims:
        told += f" Said to have solved it, and did not ({len(false_claims)}): {', '.join(false_claims)}."
    if unproven_claims:
        told += f" Said to have solved it, which is not proven ({len(unproven_claims)}): {', '.join(unproven_claims)}."
    return told


def _culprits(problem: ContactProblem, rows: Sequence[Row], pairs: Sequence[Pair], tol: float) -> dict[str, str]:
    """Return why there is no agreement, see `Conclusion.culprits`."""
    found = {row.backend: _complaint(problem, row, tol) for row in rows if not row.ok}
    if found or all(pair.consistent for pair in pairs):
        return found
    conflicts = {row.backend: 0 for row in rows}
    for pair in pairs:
        if not pair.consistent:
            conflicts[pair.first] += 1
            conflicts[pair.second] += 1
    most = max(conflicts.values())
    return {
        name: f"excludes the answers of {count} of {len(rows) - 1} other backends"
        for name, count in conflicts.items()
        if count == most
    }


def _complaint(problem: ContactProblem, row: Row, tol: float) -> str:
    """Return how a backend failed: in its own words without an answer, and else by what its answer violates most."""
    if row.relative_bound is None or row.natural_residual is None:
        return f"({row.status}: {row.message})"
    scale = problem.gap_scale
    stiffness = float(problem.stiffness.diagonal().max())
    violations = {
        f"min gap {row.min_gap:.2g}": -(row.min_gap or 0.0) / scale,
        f"min reaction {row.min_reaction:.2g}": -(row.min_reaction or 0.0) / (stiffness * scale),
        f"natural residual {row.natural_residual:.2g}": row.natural_residual / scale,
    }
    worst = max(violations, key=lambda label: violations[label])
    bound = f"bound {row.relative_bound:.2g} > tol {tol:g}" if np.isfinite(row.relative_bound) else "no bound is known"
    return f"({row.status}: {bound}, {worst})"


def _findings(answers: Answers, rows: Sequence[Row], pairs: Sequence[Pair]) -> tuple[str, ...]:
    """Return what the judge caught the backends at, and which enclosures contradict each other."""
    found = [f"{row.backend}: {finding}" for row in rows for finding in row.findings]
    for pair in pairs:
        first, second = (answers.finite[name].certificate for name in (pair.first, pair.second))
        if first is not None and second is not None and not pair.consistent:
            nodes = np.count_nonzero(np.maximum(first.lower, second.lower) > np.minimum(first.upper, second.upper))
            found.append(
                f"the enclosures of {pair.first} and {pair.second} contradict each other at {nodes} "
                f"node{'' if nodes == 1 else 's'}, so the truth is not enclosed"
            )
    return tuple(found)


def _cautions(answers: Answers) -> tuple[str, ...]:
    """Return what speaks against the best answer, and without one what speaks against the model."""
    if answers.best is not None:
        return answers.best.cautions
    return () if answers.model is None else answers.model.cautions


def _proven_by_others(row: Row, tol: float) -> bool:
    return row.relative_true_error is not None and row.relative_true_error <= tol


def _refuted(row: Row, tol: float) -> bool:
    """Whether it is proven that an answer is not within tol; one that is not finite is none."""
    return row.relative_bound is None or row.least_error > tol


def _refutation(row: Row, tol: float) -> str:
    """Return what a backend said, and how far off its answer is at least."""
    said = f"said {row.message!r}"
    if row.relative_bound is None:
        return f"{said}, and returned no finite answer"
    return f"{said}, and its gap is wrong by at least {at_least(row.least_error)} of the error scale {_judged_by(tol)}"


def _doubt(row: Row, tol: float) -> str:
    """Return what a backend said, and what is known of its answer, whose error may be within tol."""
    said = f"said {row.message!r}"
    if row.relative_true_error is None or not np.isfinite(row.relative_true_error):
        return (
            f"{said}, and nothing is proven of its error; its residual is {row.relative_residual:.2g} of the error "
            f"scale {_judged_by(tol)}"
        )
    return (
        f"{said}, and its gap is proven to {at_most(row.relative_true_error)} of the error scale only {_judged_by(tol)}"
    )


def _judged_by(tol: float) -> str:
    return f"(judged by {tol:g})"
