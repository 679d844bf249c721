"""Answers that came from elsewhere, judged like those of a backend."""

from __future__ import annotations

import time

from ..foundation.checks import Vector
from ..models.base import ContactModel, split
from ..problem.contact_problem import ContactProblem
from ..proof.judge import judge
from .request import Request
from .solution import Run, Solution


def judged_answer(subject: ContactModel | ContactProblem, gap: Vector, tol: float | str, name: str) -> Solution:
    """Return an answer as a `Solution`, with its status, residuals and certificate.

    Parameters
    ----------
    subject : Membrane, Cable, another model, or a bare problem
    gap : array, shape (n,)
        The answer (length).
    tol : float or str
        What it is judged by, see `solve`.
    name : str
        Where it came from; it stands for the backend.

    Examples
    --------
    >>> import numpy as np
    >>> import contactqp as cq
    >>> cable = cq.Cable(nodes=3, spacing=1.0, tension=1.0, load=1.0, support=1.0)
    >>> judged_answer(cable, np.array([0.0, 0.0, 0.0]), 1e-6, "zeros").status.value
    'certified'
    """
    started = time.perf_counter()
    request = Request.of(tol)
    model, problem = split(subject)
    verdict = judge(problem, gap, request.tolerance.tol, model=model)
    seconds = time.perf_counter() - started
    run = Run(
        backend=name,
        gap=gap,
        termination="computed elsewhere",
        iterations=0,
        iteration_unit="iteration",
        setup_seconds=0.0,
        solve_seconds=0.0,
        seconds=seconds,
    )
    return Solution(subject, request, run, verdict)
