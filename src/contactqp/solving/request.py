"""Request: what an answer is asked for, checked once and passed on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..backends.base import Task
from ..foundation.checks import Vector, integer_at_least, positive_number
from ..foundation.deadline import Deadline
from ..foundation.progress import Progress, silent
from ..problem.contact_problem import ContactProblem
from ..problem.posed import Units
from .tolerances import Tolerance, tolerance_of


@dataclass(frozen=True, eq=False)
class Request:
    """What a backend is asked for.

    Attributes
    ----------
    tolerance : Tolerance
        Wanted bound of the error, relative to the error scale, and the name it was asked for by.
    max_iter : int or None
        Limit of the backend's iterations.
    time_limit : float or None
        Limit in seconds.
    options : mapping of str to value
        The backend's own options that were given.
    """

    tolerance: Tolerance
    max_iter: int | None = None
    time_limit: float | None = None
    options: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        tol: object,
        max_iter: object = None,
        time_limit: object = None,
        options: Mapping[str, Any] | None = None,
    ) -> Request:
        """Return the request that arguments of `contactqp.solve` stand for.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong kind or range.

        Examples
        --------
        >>> Request.of("mid", max_iter=10).tolerance.tol
        1e-06
        """
        return cls(
            tolerance_of(tol),
            None if max_iter is None else integer_at_least(max_iter, 1, "max_iter"),
            None if time_limit is None else positive_number(time_limit, "time_limit"),
            dict(options or {}),
        )

    @property
    def unlimited(self) -> bool:
        """Whether nothing but a tolerance was given: no limits, and no options."""
        limited = self.max_iter is not None or self.time_limit is not None
        return not (limited or self.options or self.tolerance.own_defaults)

    def task(
        self,
        problem: ContactProblem,
        units: Units,
        bound: Callable[[Vector], float],
        *,
        warm_start: Vector | None = None,
        progress: Progress | None = None,
        keeps: bool = False,
        resumes: bool = False,
        predicted: bool = False,
        deadline: Deadline | None = None,
    ) -> Task:
        """Return the task that a backend is given.

        Parameters
        ----------
        problem : ContactProblem
            As posed, not scaled.
        units : Units
            Those of the dimensionless problem.
        bound, warm_start, progress, keeps, resumes, predicted
            See `Task`; by default no progress is shown.
        deadline : Deadline, optional
            The time limit, if its clock has started before; by default it starts now.
        """
        deadline = Deadline(self.time_limit) if deadline is None else deadline
        return Task(
            tol=self.tolerance.tol,
            max_iter=self.max_iter,
            time_limit=self.time_limit,
            warm_start=warm_start,
            bound=bound,
            length_unit=units.length,
            gap_scale=problem.gap_scale,
            progress=silent() if progress is None else progress,
            own_defaults=self.tolerance.own_defaults,
            given=frozenset(self.options),
            keeps=keeps,
            resumes=resumes,
            predicted=predicted,
            started=deadline.started,
            abandoned=deadline.abandoned,
        )
