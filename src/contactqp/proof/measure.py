"""measure(): take the measures of an answer in the way that suits the problem."""

from __future__ import annotations

from collections.abc import Sequence

from ..foundation.checks import Vector
from ..problem.contact_problem import ContactProblem
from ..problem.load_cases import LoadCases
from .lattice_measures import LatticeMeasures, parabola_of
from .measures import Measures
from .semidefinite import SemidefiniteMeasures
from .vector_measures import Passes, VectorMeasures


def measure(problem: ContactProblem, gap: Vector) -> Measures:
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
    if problem.kernel is not None:
        return SemidefiniteMeasures(problem, gap)
    parabola = parabola_of(problem)
    return VectorMeasures(problem, gap) if parabola is None else LatticeMeasures(problem, parabola, gap)


def measures_of_cases(cases: LoadCases, problems: Sequence[ContactProblem], gaps: Vector) -> list[Measures]:
    """Return the measures of the answers to many load cases, all of them taken in the same passes over vectors.

    Parameters
    ----------
    cases : LoadCases
        With an M-matrix.
    problems : sequence of ContactQP
        Each case as a problem of its own.
    gaps : array, shape (cases, n)
        Finite gaps (length).

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> problem = cq.ContactQP([[2.0, -1.0], [-1.0, 2.0]], [-1.0, 3.0])
    >>> problems = [problem, problem.with_forces([-2.0, 3.0])]
    >>> measured = measures_of_cases(LoadCases.of(problems), problems, np.array([[0.6, 0.0], [1.0, 0.0]]))
    >>> [round(measures.residuals.natural_residual, 12) for measures in measured]
    [0.1, 0.0]
    """
    passes = Passes(cases, gaps)
    return [VectorMeasures(problem, gaps[case], passes, case) for case, problem in enumerate(problems)]
