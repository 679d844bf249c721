"""Solver: a session that solves one problem under many loads, supports or tensions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..backends.base import Backend, CaseAnswers, State
from ..backends.contract import checked_cases
from ..foundation.checks import Vector, one_of
from ..foundation.deadline import Deadline
from ..foundation.keywords import known_by_name
from ..geometry.fields import Rows
from ..models.base import ContactModel, split
from ..models.varied import with_lift, with_load_of, with_support, with_tension
from ..problem.contact_problem import ContactProblem
from ..problem.facts import MatrixFacts
from ..problem.load_cases import LoadCases
from .choice import chosen_backend
from .prediction import Trail
from .request import Request
from .solution import OnFailure, Solution
from .starts import started_from
from .together import solved_together

_Mark: TypeAlias = tuple[MatrixFacts, NDArray[np.uint8] | None]
"""What a state is prepared for: the facts of a matrix, and the kinds of bounds."""


@dataclass
class _Kept:
    """What a backend has prepared, and what for.

    Each preparation writes into its own, so that one which was left behind and comes to its end later changes nothing
    of what the session has gone on with.
    """

    mark: _Mark | None
    state: State | None = None


class Solver:
    """A session: one model or problem, one backend, and what they keep from solve to solve.

    The matrix is checked, and its properties are proven, once; the backend keeps what it has set up (OSQP its
    workspace, multigrid its hierarchy, active sets their factors); and each solve starts from the last answer, or from
    what the last few let expect where the forces go on in one direction.

    Parameters
    ----------
    subject : Membrane, Cable, CableNet, ContactQP or ContactLCP
        What is solved; it is never modified.
    backend : str or Backend
        As for `contactqp.solve`; ``"auto"`` chooses once, by the subject.
    tol, max_iter, time_limit, **options
        As for `contactqp.solve`, for every solve of the session.

    Attributes
    ----------
    subject : Membrane, Cable, CableNet, ContactQP or ContactLCP
    backend : Backend

    Raises
    ------
    UnknownBackendError, MissingBackendError, UnsuitableProblemError
        See `contactqp.solve`.
    TypeError, ValueError
        If an argument has the wrong kind or range.

    Examples
    --------
    >>> import contactqp as cq
    >>> solver = cq.Solver(cq.gallery.paper_hexagon(), "active-set")
    >>> [int(solver.solve(load=load).contact.sum()) for load in (0.01, 0.02, 0.03)]
    [105, 225, 303]
    >>> int(solver.solve().contact.sum())  # the subject as it was given, under a load of 0.03
    303
    """

    def __init__(
        self,
        subject: ContactModel | ContactProblem,
        backend: str | Backend = "auto",
        *,
        tol: float | str = 1e-6,
        max_iter: int | None = None,
        time_limit: float | None = None,
        **options: Any,
    ) -> None:
        _, problem = split(subject)
        self.subject = subject
        self._request = Request.of(tol, max_iter, time_limit, options)
        self.backend, self._note = chosen_backend(backend, problem, options)
        self._kept = _Kept(None)
        self._last: Vector | None = None
        self._trail = Trail()
        self._asked = 0
        self._reference: Vector | float = 0.0

    @property
    def last(self) -> Vector | None:
        """The session's last answer (length), shape (n,); None without a finite one."""
        return self._last

    @known_by_name
    def solve(
        self,
        *,
        load: Any = None,
        support: Any = None,
        tension: float | None = None,
        lift: float | None = None,
        q: ArrayLike | None = None,
        rows: Rows | None = None,
        warm_start: bool | ArrayLike | Solution = True,
        on_failure: OnFailure = "warn",
    ) -> Solution:
        """Solve the session's subject, or a variation of it.

        What is not given is as in the subject, whatever was solved before.

        Parameters
        ----------
        load, support : number, array, xarray.DataArray or function of (x, y), optional
            Another load or support of the model, given and positive as when the model was made.
        tension : float, optional
            Another tension, > 0, of a membrane or a cable; a factor of its own where that varies or goes by direction.
        lift : float, optional
            Height (length) by which the support is lifted.
        q : array, shape (n,), optional
            Other forces of a bare `ContactQP` (force). A gap scale that it was made with stays.
        rows : {"up", "down"}, optional
            Which way y goes from row to row of a load or support that is an array without coordinates, as for
            `contactqp.certify`: of a model that was made with ``rows="down"`` it must be said. A vector has no rows.
        warm_start : bool, array or Solution
            Whether to start from the session's last answers, which is the default; or a gap to start from, shape (n,)
            in node order.
        on_failure : {"warn", "raise", "ignore"}
            As for `contactqp.solve`.

        Returns
        -------
        Solution

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong kind, shape or range, or does not go with the subject.
        NotCertifiedError
            If the answer is not certified and ``on_failure="raise"``.
        """
        one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
        subject = self._varied(load, support, tension, lift, q, rows)
        solution = self.solve_varied(subject, warm_start)
        solution.report(on_failure)
        return solution

    def solve_varied(
        self, subject: ContactModel | ContactProblem, warm_start: bool | ArrayLike | Solution = True
    ) -> Solution:
        """Solve a variation of the session's subject that has been made already, and judge the answer.

        Parameters
        ----------
        subject : Membrane, Cable, CableNet, ContactQP or ContactLCP
            Of the same unknowns. Where it shares matrix and kinds of bounds with what was solved before, the backend
            goes on with what it has set up.
        warm_start : bool, array or Solution
            See `solve`.

        Raises
        ------
        ValueError
            If it has other unknowns than the session's subject: another number of them, or nodes at other places.
        """
        _, problem = split(subject)
        _refuse_other_unknowns(subject, self.subject)
        deadline = Deadline(self._request.time_limit)
        self._keep_for(problem)
        start, predicted = self._start(warm_start, problem)
        own = isinstance(warm_start, (bool, np.bool_)) and start is not None
        try:
            solution = Solution.by(
                self.backend,
                subject,
                self._request,
                warm_start=start,
                note=self._note,
                state=partial(self._prepared, self._kept, problem, deadline),
                deadline=deadline,
                resumes=own and np.array_equal(problem.reference, self._reference),
                predicted=predicted,
            )
        except KeyboardInterrupt:
            # What is left behind may still be at work in it, after an interrupt as after the time limit.
            self._kept = _Kept(None)
            raise
        if solution.run.abandoned:
            self._kept = _Kept(None)
        self._last, self._reference = (solution.gap if solution.finite else None), problem.reference
        if self._last is None:
            self._trail.clear()
        else:
            self._trail.add(problem, self._last)
        return solution

    def solve_together(self, subjects: Sequence[ContactModel | ContactProblem], expected: int = 0) -> list[Solution]:
        """Solve variations of the session's subject that have been made already, and judge the answers.

        Where the backend answers many loads at once, and nothing was given that is meant for each, it is asked to.

        Parameters
        ----------
        subjects : sequence of Membrane, Cable, CableNet, ContactQP or ContactLCP
            They share the matrix and its facts.
        expected : int
            How many of them there will be in all, if that is known.
        """
        found: list[Solution | None] = [None] * len(subjects)
        if self._request.unlimited and len(subjects) > 1:
            self._asked = max(self._asked + len(subjects), expected)
            found = solved_together(self.backend, subjects, self._request, self._answers, self._note)
            last = next((solution for solution in reversed(found) if solution is not None), None)
            if last is not None:
                self._trail.clear()
                self._last, self._reference = last.gap, last.problem.reference
        return [self.solve_varied(subjects[k]) if known is None else known for k, known in enumerate(found)]

    def _answers(self, problem: ContactProblem, cases: LoadCases) -> CaseAnswers | None:
        """Return what the backend answers to load cases, of which one is given as a problem."""
        self._keep_for(problem)
        try:
            state = self._prepared(self._kept, problem, Deadline(None))
            return checked_cases(self.backend, state.answers(cases, self._asked), cases.q.shape)
        except KeyboardInterrupt:
            self._kept = _Kept(None)
            raise

    def _keep_for(self, problem: ContactProblem) -> None:
        """Go on with what was kept, or anew where that was kept for another matrix or other kinds of bounds."""
        mark = problem.facts.scaled, problem.bounds.kinds
        if not _same(mark, self._kept.mark):
            self._kept = _Kept(mark)
            self._trail.clear()

    def _prepared(self, kept: _Kept, problem: ContactProblem, deadline: Deadline) -> State:
        """Return the backend's state for a problem, prepared at the first call."""
        if kept.state is None:
            scaled, units = problem.scaled()
            task = self._request.task(problem, units, lambda gap: np.inf, keeps=True, deadline=deadline)
            kept.state = self.backend.state_of(scaled, task, self._request.options)
        return kept.state

    def _start(self, value: bool | ArrayLike | Solution, problem: ContactProblem) -> tuple[Vector | None, bool]:
        """Return where to start from, and whether that foresees all contact (see `Trail.predicted`)."""
        if not isinstance(value, (bool, np.bool_)):
            return started_from(value, problem), False
        if not value:
            return None, False
        return self._trail.predicted(problem) or (self._last, False)

    def _varied(
        self,
        load: Any,
        support: Any,
        tension: float | None,
        lift: float | None,
        q: ArrayLike | None,
        rows: Rows | None,
    ) -> ContactModel | ContactProblem:
        """Return the subject with what is given in place of its own."""
        given = {"load": load, "support": support, "tension": tension, "lift": lift}
        named = [name for name, value in given.items() if value is not None]
        if isinstance(self.subject, ContactProblem):
            if named:
                raise TypeError(f"{named[0]} goes with a model; {self.subject!r} takes other forces by q=")
            if q is None:
                return self.subject
            return self.subject.with_forces(q, gap_scale=self.subject.own_gap_scale)
        if q is not None:
            raise TypeError(f"q goes with a bare ContactQP; {self.subject!r} takes load=, support=, tension= or lift=")
        model: Any = self.subject
        if tension is not None:
            model = with_tension(model, tension)
        if support is not None:
            model = with_support(model, model.support_at_nodes(model.in_own_rows(support, "support", rows)))
        if lift is not None:
            model = with_lift(model, lift)
        if load is not None:
            model = with_load_of(model, model.at_nodes(model.in_own_rows(load, "load", rows), "load"))
        varied: ContactModel = model
        return varied

    def __repr__(self) -> str:
        return f"Solver({self.subject!r}, {self.backend.name}, tol {self._request.tolerance})"


def _refuse_other_unknowns(subject: ContactModel | ContactProblem, own: ContactModel | ContactProblem) -> None:
    (model, problem), (own_model, own_problem) = split(subject), split(own)
    if problem.facts is own_problem.facts:
        return
    if problem.size == own_problem.size:
        if problem.stencil is not None and own_problem.stencil is not None:
            alike = np.array_equal(problem.stencil.mask, own_problem.stencil.mask)
        elif model is not None and own_model is not None:
            places = (model.node_x, own_model.node_x), (model.node_y, own_model.node_y)
            alike = all(map(np.array_equal, *zip(*places, strict=True)))
        else:
            alike = True
        if alike or problem.stiffness.equals(own_problem.stiffness):
            return
    elsewhere = ", at other places" if problem.size == own_problem.size else ""
    raise ValueError(
        f"subject must have the unknowns that the session was made for, {own_problem.size} of {own!r}, but has "
        f"{problem.size}{elsewhere}: {subject!r}; make a Solver for it"
    )


def _same(mark: _Mark, other: _Mark | None) -> bool:
    if other is None or mark[0] is not other[0]:
        return False
    kinds, others = mark[1], other[1]
    return kinds is others or (kinds is not None and others is not None and np.array_equal(kinds, others))
