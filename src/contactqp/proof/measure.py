"""measure(): take the measures of an answer in the way that suits the problem."""

from __future__ import annotations

from ..foundation.checks import Vector
from ..problem.contact_qp import ContactQP
from .lattice_measures import LatticeMeasures, parabola_of
from .measures import Measures
from .vector_measures import VectorMeasures


def measure(problem: ContactQP, gap: Vector) -> Measures:
    """Return the measures of a finite gap (length), shape (n,): compiled for a large lattice of equal arms.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> measures = measure(problem, np.array([0.6, 0.0]))
    >>> round(measures.residuals.natural_residual, 12), measures.gap_bound >= 0.1
    (0.1, True)
    """
    parabola = parabola_of(problem)
    return VectorMeasures(problem, gap) if parabola is None else LatticeMeasures(problem, parabola, gap)
