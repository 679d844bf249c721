"""What the terms of a comparison's page mean, in the words that suit the problem's bounds."""

from __future__ import annotations

from ..problem.contact_problem import ContactProblem


def legend_of(problem: ContactProblem) -> dict[str, str]:
    """Return the meanings of the page's terms, by term.

    Examples
    --------
    >>> import contactqp as cq
    >>> legend_of(cq.ContactQP([[1.0]], [-1.0], lower=-1.0, upper=1.0))["natural residual"]
    'max |max(ω − u, min(ω − l, R/Gᵢᵢ))| (length): zero at the solution only.'
    """
    terms = dict(_SUPPORTED)
    if not problem.bounds.standard:
        terms |= _BOUNDED
    if not problem.one_sided:
        terms |= _BOUNDED_ABOVE
    return terms


_SUPPORTED: dict[str, str] = {
    "bound": "Proven upper bound of max |ω − ω*| (length), from the answer's own certificate.",
    "true error": "Two lengths between which max |ω − ω*| lies, by the certificates of all backends together; over the "
    "scale: the larger one.",
    "scale": "The error scale, which tol is relative to: the gap scale, which is a length of the problem, or the "
    "answer's own largest deflection where that is smaller.",
    "primal residual": "max(0, −min ω) over supported nodes (length): by how much the support is penetrated.",
    "dual residual": "max(0, −min R) (force): by how much the support pulls.",
    "duality gap": "ωᵀR (force times length): zero at the solution.",
    "natural residual": "max |min(ω, R/Gᵢᵢ)| (length): zero at the solution only.",
    "objective": "½ωᵀGω + qᵀω (force times length).",
    "Jaccard distance": "1 − |intersection| / |union| of the contact set and the best answer's: 0 if they are equal.",
    "boundary distance": "Hausdorff distance of the free boundary from the best answer's (length), in middles of the "
    "lattice's arms; inf if only one has a free boundary.",
    "loading": "Seconds for loading libraries and compiling kernels, which pass once in a process; no other time "
    "contains them.",
    "cold, warm": "Seconds of the first run, with scaling and judging; and of the fastest of the runs after it, for "
    "which the backend kept its set-up.",
    "set-up, solve": "Seconds of the first run that the backend spent on conversion and factorisation, and on "
    "iterating.",
}

_BOUNDED: dict[str, str] = {
    "primal residual": "By how much a bound l ≤ ω ≤ u is overstepped at most (length).",
    "dual residual": "By how much a bound pulls at most (force): −R where the lower bound is the only one, R where the "
    "upper one is.",
    "duality gap": "Sum of (ω − l)R over the nodes where R ≥ 0 and of (ω − u)R over the others (force times length): "
    "zero at the solution.",
    "natural residual": "max |max(ω − u, min(ω − l, R/Gᵢᵢ))| (length): zero at the solution only.",
}
"""The same terms where there are other bounds than ω ≥ 0."""

_BOUNDED_ABOVE: dict[str, str] = {
    "at the upper bound": "Those of the nodes in contact that the upper bound holds; the lower one holds the others.",
    "Jaccard distance": "1 − |intersection| / |union| of the contact set and the best answer's: 0 if they are equal. A "
    "contact is a node and the bound that holds it.",
    "boundary distance": "Hausdorff distance of the free boundary from the best answer's (length), in middles of the "
    "lattice's arms: the larger one of those for the two bounds; inf if only one has a free boundary.",
}
"""The same terms, and one more, where nodes may have an upper bound."""
