"""Pair: how two backends' answers differ."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .answers import Answers

UNPROVEN_AGREEMENT = 100.0
"""Without enclosures two answers agree if they differ by at most this times tol times the gap scale."""


@dataclass(frozen=True, eq=False)
class Pair:
    """How two backends' answers differ.

    Attributes
    ----------
    first, second : str
        The backends.
    gap_difference : float
        max |Δω| (length).
    contact_jaccard : float
        1 - |intersection| / |union| of the two contact sets: 0 if they are equal. A contact is a node and the bound
        that holds it.
    differing_nodes : array of int
        Nodes that one has in contact and the other does not, or that other bounds hold.
    consistent : bool
        Whether one solution can satisfy both enclosures (without enclosures: whether the gaps differ by at most
        100 tol times the gap scale).
    enclosed : bool
        Whether both have an enclosure.
    boundary_distance : float or None
        Hausdorff distance of the two free boundaries (length); None for a bare matrix.
    """

    first: str
    second: str
    gap_difference: float
    contact_jaccard: float
    differing_nodes: NDArray[np.int64]
    consistent: bool
    boundary_distance: float | None = None
    enclosed: bool = True


def pairs_of(answers: Answers, tol: float) -> list[Pair]:
    """Return every pair of finite answers, in the order asked for."""
    return [_pair(first, second, answers, tol) for first, second in combinations(answers.finite, 2)]


def _pair(first_backend: str, second_backend: str, answers: Answers, tol: float) -> Pair:
    first, second = answers.finite[first_backend], answers.finite[second_backend]
    sets = answers.contact_sets
    difference = float(np.abs(first.gap - second.gap).max())
    certificates = first.certificate, second.certificate
    if certificates[0] is not None and certificates[1] is not None:
        consistent = certificates[0].intersects(certificates[1])
    else:
        consistent = difference <= UNPROVEN_AGREEMENT * tol * answers.problem.gap_scale
    return Pair(
        first=first_backend,
        second=second_backend,
        gap_difference=difference,
        contact_jaccard=answers.contact_jaccard(first_backend, second_backend),
        differing_nodes=np.flatnonzero((sets[first_backend] != sets[second_backend]).any(axis=0)),
        consistent=consistent,
        boundary_distance=answers.boundary_distance(first_backend, second_backend),
        enclosed=None not in certificates,
    )


def differing_nodes(pairs: Iterable[Pair]) -> NDArray[np.int64]:
    """Return the nodes whose contact differs in any of the pairs, ascending."""
    found = [pair.differing_nodes for pair in pairs]
    return np.unique(np.concatenate(found)) if found else np.array([], dtype=np.int64)
