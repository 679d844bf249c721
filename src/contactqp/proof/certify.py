"""certify(): enclose the exact solution, given any approximate one."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import UnsuitableProblemError
from ..foundation.checks import one_of
from ..geometry.fields import Rows
from ..models.base import ContactModel, at_unknowns, split
from ..models.records import Answered
from ..problem.contact_problem import ContactProblem
from .certificate import Certificate
from .measure import measure
from .sharper import SHARP_SIZE, sharper

Effort = Literal["fast", "sharp"]


@np.errstate(over="ignore", invalid="ignore")
def certify(
    problem: ContactProblem | ContactModel,
    gap: ArrayLike | Answered,
    *,
    effort: Effort | None = None,
    rows: Rows | None = None,
) -> Certificate:
    r"""Enclose the exact solution of ``problem``, given any approximate ``gap`` from any program.

    With a barrier v > 0, s ≤ Gv, s > 0, and R = Gω + q let (for the lower bound 0 alone)

    .. math::
        τ⁺ = \max_i \max(0, -ω_i/v_i, -R_i/s_i), \qquad τ⁻ = \max_i \max(0, \min(ω_i/v_i, R_i/s_i)).

    Then ω - τ⁻v ≤ ω* ≤ ω + τ⁺v, for ω + τ⁺v is a supersolution and ω - τ⁻v a subsolution; at a node without support
    ω_i/v_i counts as +∞. The proof for any bounds on both sides, and that of what makes the enclosure sharper, stands
    in `contactqp.proof.enclosure`: a correction by Newton's method to lay the bounds about, a barrier that vanishes on
    the contact set, and monotone relaxation. For matrices that are no M-matrices there are weaker bounds, see
    `contactqp.proof.beyond_m_matrices`.

    Every computed quantity is widened by a bound of its rounding error (Higham 2002, ch. 3), so that the
    statement holds for the exact solution of the problem whose G and q are the stored doubles; on a lattice G consists
    of the exact sums of its arms.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet, ContactQP or ContactLCP
        Any; what is known of its matrix decides on the kind of bound.
    gap : array, shape (n,), or xarray.DataArray, or Solution
        The approximate solution ω (length); it need not be feasible. On a lattice also an array of its shape, of which
        only the entries of nodes count, so that the others may be masked. Of a solution its gap is taken.
    rows : {"up", "down"}, optional
        Which way y goes from row to row of an array without coordinates: up (its first row has the smallest y), if
        nothing is said; of a model that was made with ``rows="down"`` it must be said. A vector in node order has no
        rows: ``rows`` says nothing of it.
    effort : {"sharp", "fast"}, optional
        ``"fast"`` evaluates the formulas above, on a lattice in a pass or two over it. ``"sharp"`` takes some
        linear solves on the nodes that are not in contact, and bounds the error to within a per cent as a rule; it
        holds some thirty vectors in memory. By default sharp up to five million unknowns, and fast beyond.

    Returns
    -------
    Certificate

    Raises
    ------
    UnsuitableProblemError
        If no bound is known: the matrix is no M-matrix and no H-matrix, and too large for a proof by factorisation; or
        it is so ill-conditioned that double precision proves nothing of it. The message tells which.
    TypeError, ValueError
        If ``problem`` is no problem, ``gap`` has the wrong shape or is not finite, or ``effort`` is unknown; or if the
        matrix turns out not to be positive definite, to rounding.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    >>> cq.certify(problem, [0.5, 0.0]).gap_bound < 1e-14
    True
    >>> cq.certify(problem, [0.51, 0.0])
    Certificate(|gap error| <= 0.0101; 1 in contact, 1 clear, 0 undecided; linear solve)
    >>> cq.certify(problem, [0.51, 0.0], effort="fast")
    Certificate(|gap error| <= 0.0201; 1 in contact, 1 clear, 0 undecided; linear solve)
    """
    model, algebra = split(problem)
    if effort is None:
        effort = "sharp" if algebra.size <= SHARP_SIZE else "fast"
    one_of(effort, ("fast", "sharp"), "effort")
    omega = at_unknowns(problem, gap, "gap", rows=rows, copied=False)
    found = measure(algebra, omega).certificate()
    if found is None:
        raise UnsuitableProblemError(
            f"no enclosure is known for {algebra!r}: {algebra.facts.why_nothing_is_proven}; rely on the residuals"
        )
    if effort == "sharp":
        found = sharper(found, omega)
    return found if model is None else replace(found, model=model)
