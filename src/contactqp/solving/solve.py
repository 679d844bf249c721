"""solve(): scale the problem, call a backend, judge its answer."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..backends.base import Backend
from ..foundation.checks import one_of
from ..foundation.deadline import Deadline
from ..models.base import ContactModel, split
from ..problem.contact_problem import ContactProblem
from .choice import chosen_backend
from .request import Request
from .solution import OnFailure, Solution
from .starts import started_from


def solve(
    problem: ContactProblem | ContactModel,
    backend: str | Backend = "auto",
    *,
    tol: float | str = 1e-6,
    max_iter: int | None = None,
    time_limit: float | None = None,
    warm_start: ArrayLike | Solution | None = None,
    on_failure: OnFailure = "warn",
    **options: Any,
) -> Solution:
    """Solve a contact problem with the backend of the given name, and judge the answer.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet, ContactQP or ContactLCP
        What to solve; it is never modified.
    backend : str or Backend
        ``"auto"``, a name in `backend_names` (``"osqp"``, ``"clarabel"``, ``"mangasarian"``, ``"psor"``,
        ``"multigrid"``, ``"active-set"``, ``"mprgp"``), or a `contactqp.backends.base.Backend`. ``"auto"`` takes
        multigrid on a lattice of more than some thousand nodes, and otherwise active sets; the solution's ``note`` says
        why.
    tol : float or str
        Wanted bound of max|ω_i - ω*_i| against the exact solution ω* of the discrete problem, relative to the error
        scale: that is ``problem.gap_scale``, or the answer's largest deflection (for a matrix, gap) where that is
        smaller; in (0, 1). It means the same for every backend, because the package
        certifies it itself. Or a level: ``"low"`` (1e-3), ``"mid"`` (1e-6), ``"high"`` (1e-9), or ``"default"``: one
        run of the library as its authors ship it, on the dimensionless problem, judged by 1e-6.
    max_iter : int, optional
        Limit of the backend's iterations, >= 1.
    time_limit : float, optional
        Limit in seconds, > 0, with set-up, judging, and what a first call loads and compiles. It is kept to within a
        second, or 5 % of it where that is more: a call into a library that cannot be stopped is left behind, and runs
        on in the background.
    warm_start : array or Solution, optional
        A gap to start from, shape (n,), length. Clarabel and Mangasarian's linear program cannot use one. One whose
        energy is above that of a cold start, the admissible gap nearest to zero, is dropped.
    on_failure : {"warn", "raise", "ignore"}
        What to do when the answer is not certified: issue a `ContactWarning`, raise a `NotCertifiedError` or
        leave it to the reader of ``solution.status``.
    **options
        The backend's own options; an unknown one is a TypeError that lists them.

    Returns
    -------
    Solution

    Raises
    ------
    UnknownBackendError, MissingBackendError
        If there is no such backend, or its library is not installed.
    UnsuitableProblemError
        If the backend's method needs a property that G does not have.
    NotCertifiedError
        If the answer is not certified and ``on_failure="raise"``.
    TypeError, ValueError
        If an argument has the wrong kind, shape or range.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.disk(1.0).lattice(spacing=0.25)
    >>> membrane = cq.Membrane(lattice, tension=1.0, load=4.0, support=0.5)
    >>> solution = cq.solve(membrane, backend="clarabel", tol=1e-8)
    >>> solution.status.value, int(solution.certificate.undecided.sum())
    ('certified', 0)
    """
    _, algebra = split(problem)
    request = Request.of(tol, max_iter, time_limit, options)
    one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
    deadline = Deadline(request.time_limit)
    method, note = chosen_backend(backend, algebra, options)
    start = started_from(warm_start, algebra)
    solution = Solution.by(method, problem, request, warm_start=start, note=note, deadline=deadline)
    solution.report(on_failure)
    return solution
