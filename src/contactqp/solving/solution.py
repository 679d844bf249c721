"""Solution: an answer, what it is worth, and the quantities that follow from it."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from ..algebra.conditioning import digits_kept
from ..backends.base import Answer, Backend, State, Stop
from ..backends.contract import checked_answer
from ..continuum.enclosed import continuum_of
from ..continuum.energy_estimate import EnergyEstimate, energy_estimate
from ..continuum.estimate import DiscretisationEstimate, discretisation_estimate
from ..continuum.result import Continuum
from ..errors import ContactWarning, NotCertifiedError
from ..foundation.brackets import Bracket
from ..foundation.checks import Mask, Vector, one_of, read_only
from ..foundation.deadline import Deadline
from ..foundation.files import path_of
from ..foundation.interrupts import OutOfTime
from ..foundation.loading import is_loading, loading_seconds, working_seconds
from ..foundation.pictures import UnitNames, Wanted
from ..foundation.progress import Progress
from ..foundation.text import at_most, counted
from ..methods.factors import DIRECT_SIZE
from ..models.base import ContactModel, ForceBalance, split
from ..models.membrane import Membrane
from ..models.records import held_reaction
from ..models.suspicions import steep
from ..problem.contact_problem import ContactProblem
from ..problem.posed import Units
from ..proof.certificate import Certificate
from ..proof.judge import Verdict, judge
from ..proof.measure import measure
from ..proof.measures import Measures
from ..proof.play import play
from ..proof.residuals import Residuals
from ..proof.sharper import sharper
from ..proof.status import DISCRETE, Status
from .choice import chosen_backend
from .request import Request
from .resolved import Resolved
from .starts import useful_start

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from ..io.carried import Carried
    from .sensitivity import Sensitivity

OnFailure = Literal["warn", "raise", "ignore"]

Effort = Literal["energy", "pointwise"]
"""How much is asked about the membrane itself, see `Solution.continuum`."""

_SHARP_ON_LATTICES = 100_000
"""Nodes up to which a sharp certificate takes some hundredths of a second."""

_WORTH_TELLING = 0.05
"""Seconds of loading and compiling that a solution tells of."""

_LIMITS = {
    Stop.DONE: None,
    Stop.ITERATION_LIMIT: Status.ITERATION_LIMIT,
    Stop.TIME_LIMIT: Status.TIME_LIMIT,
    Stop.FAILED: Status.FAILED,
}

_ABANDONED = "time limit; the call could not be stopped and was left behind"
_LOADING = "; it was still loading libraries or compiling kernels, which passes once on a machine"
_SHUT = "no force opens a gap: the admissible gap nearest to zero solves the problem"

_OUTCOMES = {
    Status.UNPROVEN: "returned an answer that is not proven",
    Status.INACCURATE: "returned an inaccurate answer",
    Status.ITERATION_LIMIT: "stopped at its iteration limit",
    Status.TIME_LIMIT: "stopped at its time limit",
    Status.FAILED: "failed",
}


@dataclass(frozen=True, eq=False)
class Run:
    """What a backend returned, and what it took.

    Attributes
    ----------
    backend : str
    gap : array, shape (n,)
        The backend's ω (length), as it is; nan if it returned nothing.
    termination : str
        The backend's own words for its end.
    iterations : int
        In the backend's ``iteration_unit``.
    setup_seconds, solve_seconds, seconds : float
        Time for set-up, for iterating, and in all with scaling and judging, once all is loaded.
    loading_seconds : float
        Time for loading libraries and compiling kernels, which is part of none of the others: it passes once.
    history : mapping of str to array
    note : str
        Why ``"auto"`` chose the backend, and what the backend has to tell.
    claimed_solved : bool
        Whether the backend itself said that it had solved the problem.
    findings : tuple of str
    abandoned : bool
        Whether the backend was left behind, still at work, when its time was over.
    """

    backend: str
    gap: Vector
    termination: str
    iterations: int
    iteration_unit: str
    setup_seconds: float
    solve_seconds: float
    seconds: float
    loading_seconds: float = 0.0
    history: Mapping[str, Vector] = field(default_factory=dict)
    note: str = ""
    claimed_solved: bool = False
    findings: tuple[str, ...] = ()
    abandoned: bool = False


class _Questions:
    """The judge's ear for a backend's questions: the last answer is remembered with its measures, and the best one.

    Attributes
    ----------
    best : array, shape (n,), or None
        The dimensionless gap with the least bound of those that were asked about.
    """

    def __init__(self, problem: ContactProblem, units: Units) -> None:
        self._problem, self._units = problem, units
        self._asked: Vector | None = None
        self._gap: Vector | None = None
        self._measures: Measures | None = None
        self._least = np.inf
        self.best: Vector | None = None

    def bound(self, dimensionless: Vector) -> float:
        """Return the judge's bound of a dimensionless gap's error, or its estimate, relative to the error scale."""
        if np.shape(dimensionless) != (self._problem.size,):
            raise ValueError(f"bound(gap) needs shape ({self._problem.size},), got {np.shape(dimensionless)}")
        gap = self._units.gap(dimensionless)
        if not np.isfinite(gap).all():
            return np.inf
        if self.best is None:
            self.best = dimensionless
        # What the last question needed is given up before another one is measured.
        self._measures = None
        self._asked, self._gap, self._measures = dimensionless, gap, measure(self._problem, gap)
        found = self._measures.relative_estimate
        if found <= self._least:
            self._least, self.best = found, dimensionless
        return found

    def known(self, dimensionless: Vector | None) -> tuple[Vector | None, Measures | None]:
        """Return the gap (length) of a backend's answer, and its measures if it was the last that was asked about."""
        if dimensionless is None:
            return None, None
        if dimensionless is self._asked:
            return self._gap, self._measures
        return self.gap_of(dimensionless), None

    def gap_of(self, dimensionless: Vector) -> Vector:
        """Return the gap (length) of a dimensionless one."""
        return self._units.gap(np.asarray(dimensionless, dtype=np.float64))


def shut_answer(problem: ContactProblem) -> Answer:
    """Return the answer to a problem that no force opens, with its gap in lengths."""
    nearest = np.broadcast_to(problem.bounds.nearest_zero, (problem.size,)).astype(np.float64)
    return Answer(nearest, Stop.DONE, _SHUT, 0, 0.0, 0.0)


def _asked(
    backend: Backend,
    problem: ContactProblem,
    request: Request,
    deadline: Deadline,
    warm_start: Vector | None,
    state: Callable[[], State] | None,
    *,
    resumes: bool,
    predicted: bool,
) -> tuple[Answer, Vector | None, Measures | None]:
    """Return a backend's answer, its gap (length), and what has been measured of it.

    A problem that no force opens is answered here: its solution is the admissible gap nearest to zero. The backend is
    called only for options, which it alone can check, and whose histories it alone can record.
    """
    shut = shut_answer(problem) if problem.shut else None
    if shut is not None and not request.options:
        return shut, shut.gap, None
    questions: _Questions | None = None

    def ask() -> tuple[Answer, Vector | None, Measures | None]:
        nonlocal questions
        scaled, units = problem.scaled()
        questions = _Questions(problem, units)
        start = None if warm_start is None else useful_start(warm_start, scaled, units)
        task = request.task(
            problem,
            units,
            questions.bound,
            warm_start=start,
            progress=progress,
            keeps=state is not None,
            resumes=resumes and start is not None,
            predicted=predicted and start is not None,
            deadline=deadline,
        )
        try:
            if state is None:
                answer = backend.solve(scaled, task, **request.options)
            else:
                answer = state().solve_problem(scaled, task)
            answer = checked_answer(backend, answer, problem.size)
        except Exception as error:
            error.add_note(f"raised by backend {backend.name!r} on {problem!r}")
            raise
        if shut is not None:
            return replace(answer, gap=shut.gap, stop=shut.stop, termination=shut.termination), shut.gap, None
        return answer, *questions.known(answer.gap)

    with Progress(f"{backend.name} · {problem.size} unknowns") as progress:
        try:
            return deadline.work(ask, progress)
        except OutOfTime:
            best = None if questions is None else questions.best
            words = _ABANDONED + (_LOADING if is_loading() else "")
            answer = Answer(best, Stop.TIME_LIMIT, words, 0, 0.0, time.perf_counter() - deadline.started)
            return answer, None if best is None or questions is None else questions.gap_of(best), None


@dataclass(frozen=True, eq=False, repr=False)
class Solution:
    """The answer of one backend to one problem, judged.

    Attributes
    ----------
    subject : Membrane, Cable, CableNet, ContactQP or ContactLCP
        What was solved.
    request : Request
        What was asked for.
    run : Run
        What the backend returned.
    verdict : Verdict
        What the judge found.
    """

    subject: ContactModel | ContactProblem
    request: Request
    run: Run
    verdict: Verdict

    @classmethod
    def by(
        cls,
        backend: Backend,
        subject: ContactModel | ContactProblem,
        request: Request,
        *,
        warm_start: Vector | None = None,
        note: str = "",
        state: Callable[[], State] | None = None,
        resumes: bool = False,
        predicted: bool = False,
        deadline: Deadline | None = None,
    ) -> Solution:
        """Scale the problem, call a backend that suits it, and judge its answer.

        Parameters
        ----------
        backend : Backend
        subject : Membrane, Cable, CableNet, ContactQP or ContactLCP
        request : Request
        warm_start : array, shape (n,), optional
            A gap to start from (length); see `contactqp.solving.starts.useful_start`.
        note : str
            Why the backend was chosen.
        state : callable, optional
            Returns what the backend prepared for this problem's matrix and kinds of bounds, or prepares it; its options
            are those of the state.
        resumes, predicted : bool
            See `contactqp.backends.base.Task`.
        deadline : Deadline, optional
            The time limit, if its clock has started before.
        """
        model, problem = split(subject)
        loaded, started = loading_seconds(), working_seconds()
        deadline = Deadline(request.time_limit) if deadline is None else deadline
        answer, gap, measures = _asked(
            backend, problem, request, deadline, warm_start, state, resumes=resumes, predicted=predicted
        )
        verdict = judge(
            problem,
            gap,
            request.tolerance.tol,
            _LIMITS[answer.stop],
            model=model,
            measures=measures,
            optional=deadline.checked,
        )
        seconds = working_seconds() - started
        loading = loading_seconds() - loaded
        return cls.of(backend, subject, request, answer, gap, verdict, note=note, seconds=seconds, loading=loading)

    @classmethod
    def of(
        cls,
        backend: Backend,
        subject: ContactModel | ContactProblem,
        request: Request,
        answer: Answer,
        gap: Vector | None,
        verdict: Verdict,
        *,
        note: str,
        seconds: float,
        loading: float = 0.0,
    ) -> Solution:
        """Return the solution that consists of a backend's answer and the judge's verdict.

        Parameters
        ----------
        backend, subject, request, note
            See `by`.
        answer : Answer
        gap : array, shape (n,), or None
            The answer's gap (length), if it has one.
        verdict : Verdict
        seconds, loading : float
            Time in all, and for loading.
        """
        run = Run(
            backend=backend.name,
            gap=np.full(split(subject)[1].size, np.nan) if gap is None or verdict.residuals is None else gap,
            termination=answer.termination,
            iterations=answer.iterations,
            iteration_unit=backend.iteration_unit,
            setup_seconds=answer.setup_seconds,
            solve_seconds=answer.solve_seconds,
            seconds=seconds,
            loading_seconds=loading,
            history=answer.history,
            note="; ".join(part for part in (note, answer.note) if part),
            claimed_solved=answer.claimed,
            findings=answer.findings,
            abandoned=answer.termination.startswith(_ABANDONED),
        )
        return cls(subject, request, run, verdict)

    def with_gap(self, gap: Vector, request: Request, note: str) -> Solution:
        """Return the solution with another gap, judged as a request asks for.

        Parameters
        ----------
        gap : array, shape (n,)
            Length.
        request : Request
        note : str
            What has been done to the answer.
        """
        verdict = judge(self.problem, gap, request.tolerance.tol, model=self.model)
        told = "; ".join(part for part in (self.run.note, note) if part)
        return Solution(self.subject, request, replace(self.run, gap=read_only(gap), note=told), verdict)

    @cached_property
    def problem(self) -> ContactProblem:
        """The contact problem."""
        return split(self.subject)[1]

    @property
    def model(self) -> ContactModel | None:
        """The membrane, cable or cable net; None if a bare `ContactQP` was solved."""
        return split(self.subject)[0]

    @property
    def backend(self) -> str:
        """Name of the backend that answered."""
        return self.run.backend

    @property
    def gap(self) -> Vector:
        """The backend's ω (length), as it is, shape (n,); nan if it returned nothing.

        Where there is no support: the frame's mean height less the deflection.
        """
        return self.run.gap

    @property
    def note(self) -> str:
        """Why ``"auto"`` chose the backend, what the backend has to tell, and what was made of the model's data."""
        return "; ".join(part for part in (self.run.note, *(() if self.model is None else self.model.notes)) if part)

    @cached_property
    def cautions(self) -> tuple[str, ...]:
        """Why a certified answer may still not be what was meant, one sentence each.

        Heights whose signs look wrong, a lattice wider than its frame, slopes beyond what the theory assumes; and a
        solution that is not the only one.
        """
        if self.model is None:
            several = (
                f"the solution is not unique: moved along the kernel by up to {self.play:.2g}, the answer meets the "
                "same conditions, to rounding"
            )
            return (several,) if self.play else ()
        return (*self.model.cautions, *steep(self.max_slope if self.finite else 0.0))

    @cached_property
    def play(self) -> float:
        """How far the answer can be moved along the kernel and still solve the problem as well (length).

        It is 0 where the problem has no kernel, and where contact holds it: see `contactqp.proof.play`.
        """
        if not self.finite or self.status is Status.CERTIFIED:
            return 0.0
        return play(self.problem, self.gap, self.tol * self.verdict.scale)

    @property
    def advice(self) -> str:
        """What to do about the status, one sentence."""
        if self.play:
            return "Add a force or a bound that decides which of the solutions is meant."
        return self.status.advice

    @property
    def tol(self) -> float:
        """The tolerance asked for, relative to the error scale (see `solve`)."""
        return self.request.tolerance.tol

    @property
    def setting(self) -> str:
        """The level that ``tol`` was asked for by, see `solve`; ``""`` for a number."""
        return self.request.tolerance.setting

    @property
    def status(self) -> Status:
        """The judge's finding."""
        return self.verdict.status

    @property
    def residuals(self) -> Residuals | None:
        """Distance from the optimality conditions; None without a finite answer."""
        return self.verdict.residuals

    @property
    def termination(self) -> str:
        """The backend's own words for its end."""
        return self.run.termination

    @property
    def iterations(self) -> int:
        """Iterations, in the backend's `iteration_unit`."""
        return self.run.iterations

    @property
    def iteration_unit(self) -> str:
        """What one iteration is."""
        return self.run.iteration_unit

    @property
    def setup_seconds(self) -> float:
        """Time for set-up."""
        return self.run.setup_seconds

    @property
    def solve_seconds(self) -> float:
        """Time for iterating."""
        return self.run.solve_seconds

    @property
    def seconds(self) -> float:
        """Time in all, with scaling and judging, but without `loading_seconds`."""
        return self.run.seconds

    @property
    def loading_seconds(self) -> float:
        """Time for loading libraries and compiling kernels, which passes once in a process."""
        return self.run.loading_seconds

    @property
    def history(self) -> Mapping[str, Vector]:
        """What was recorded on request, by backends that offer it."""
        return self.run.history

    @property
    def claimed_solved(self) -> bool:
        """Whether the backend itself said that it had solved the problem; ``status`` tells whether it had."""
        return self.run.claimed_solved

    @property
    def findings(self) -> tuple[str, ...]:
        """What the judge caught the backend at on the way, one sentence each."""
        return self.run.findings

    @property
    def finite(self) -> bool:
        """Whether the backend returned a finite vector."""
        return self.verdict.residuals is not None

    @cached_property
    def certificate(self) -> Certificate | None:
        """Enclosure of the true gap; None if there is no answer, or nothing is known of such a matrix.

        For up to 4000 unknowns, on a lattice 100,000, it is the sharp one, which is made when it is first asked for.
        Beyond, it is the judge's own; ``certify(solution.problem, solution.gap)`` sharpens it.
        """
        first = self.verdict.certificate
        affordable = DIRECT_SIZE if self.problem.stencil is None else _SHARP_ON_LATTICES
        return first if first is None or self.problem.size > affordable else sharper(first, self.gap)

    @property
    def relative_bound(self) -> float:
        """Certified bound of the gap's error over the error scale ``verdict.scale``; infinite without a certificate."""
        return self.verdict.relative_bound_of(self.certificate)

    @property
    def relative_residual(self) -> float:
        """Natural residual over the error scale: no bound of the error; infinite without a finite answer."""
        return self.verdict.relative_residual

    def report(self, on_failure: OnFailure, stacklevel: int = 3) -> None:
        """Warn, or raise a NotCertifiedError, if the answer is not as good as was asked for; see `solve`."""
        one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
        if self.status.ok or on_failure == "ignore":
            return
        bound, residual = self.verdict.relative_bound, self.relative_residual
        achieved = f"bound {bound:.2g} of the error scale"
        if not np.isfinite(bound) and self.finite:
            achieved = f"no bound is known, natural residual {residual:.2g} of the error scale"
        message = (
            f"{self.backend} {_OUTCOMES[self.status]}: {achieved}, wanted {self.tol:g} ({self.termination}). "
            f"{self.advice}{f' {self._conditioning}.' if self._conditioning else ''}"
        )
        if on_failure == "raise":
            raise NotCertifiedError(message, self)
        warnings.warn(message, ContactWarning, stacklevel=stacklevel)

    @cached_property
    def _conditioning(self) -> str:
        """What an ill-conditioned matrix has to do with an answer that is not certified; else empty."""
        problem = self.problem
        if self.status in (Status.CERTIFIED, Status.TIME_LIMIT) or problem.size > DIRECT_SIZE:
            return ""
        kept = digits_kept(problem.condition)
        if 10.0**-kept <= self.tol:
            return ""
        return (
            f"G is ill-conditioned, {problem.told_condition}: double precision keeps {counted(kept, 'digit')} of an "
            "answer"
        )

    @property
    def contact_area(self) -> Bracket:
        """Bracket of the area in contact (of cables and beams: the length), the sum of what its nodes stand for.

        A node stands for what is nearer to it than to another, of a line for half an arm to either side: m nodes next
        to each other for a length of m Δ. A stretch of `spans` goes from its first node to its last one, which is
        (m - 1) Δ. Where contact ends between two nodes the discrete problem does not tell.
        """
        self._physical("contact_area")
        return self._certified("contact_area").contact_area

    @property
    def total_reaction(self) -> Bracket:
        """Bracket of the true total reaction ΣR* (force)."""
        return self._certified("total_reaction").total_reaction

    def _certified(self, attribute: str) -> Certificate:
        if self.certificate is None:
            raise AttributeError(f"{attribute} needs a certificate; this solution has none ({self.advice})")
        return self.certificate

    @cached_property
    def reaction(self) -> Vector:
        """R = Gω + q, the support's nodal force (force, upwards), shape (n,).

        It is the answer's own: where a node is free, what is left out of balance, of either sign. Where the membrane
        touches is told by `contact`, not by ``reaction > 0``.
        """
        return read_only(self.problem.stiffness.matvec(self.gap) + self.problem.q)

    @property
    def contact(self) -> Mask:
        """The backend's own contact set: nodes that either bound holds, shape (n,)."""
        return self._contact[2]

    @property
    def contact_lower(self) -> Mask:
        """Nodes that the support holds, by the backend's own answer: R_i/G_ii > ω_i - l_i, shape (n,)."""
        return self._contact[0]

    @property
    def contact_upper(self) -> Mask:
        """Nodes that the upper bound holds, by the backend's own answer: R_i/G_ii < ω_i - u_i, shape (n,)."""
        return self._contact[1]

    @cached_property
    def _contact(self) -> tuple[Mask, Mask, Mask]:
        correction = self.reaction / self.problem.stiffness.diagonal()
        lower, upper = self.problem.bounds.contact(self.gap, correction)
        return read_only(lower), read_only(upper), read_only(lower | upper)

    @property
    def deflection(self) -> Vector:
        """Deflection of each node, w = f - ω (length), positive downwards, unless the model is ``upwards``."""
        return self._physical("deflection").deflection(self.gap)

    @property
    def contact_pressure(self) -> Vector:
        """ρ, the reaction over the area (cable: the length) that its node stands for, shape (n,).

        It is exactly 0 at nodes that are certainly clear, where the answer's own reaction is what rounding, or its
        error, has left out of balance, of either sign.
        """
        area = self._physical("contact_pressure").area_of_node("contact_pressure")
        return held_reaction(self) / area

    @property
    def max_slope(self) -> float:
        """Largest slope of the deflection along an arm; the theory assumes small ones."""
        return self._physical("max_slope").max_slope(self.gap)

    @property
    def force_balance(self) -> ForceBalance:
        """ΣP = ΣR + the frame's pull (force), with what a ceiling and a foundation add; see `ForceBalance`."""
        return self._physical("force_balance").force_balance(self.gap)

    def _physical(self, attribute: str) -> ContactModel:
        if self.model is None:
            raise AttributeError(
                f"{attribute} needs a model, as Membrane, Cable or Beam; "
                "this solution is of a bare ContactQP, which knows gap and reaction only"
            )
        return self.model

    def polish(self, *, tol: float | None = None) -> Solution:
        """Return the answer after active sets have gone on from it: exact to rounding once the contact set rests.

        It assembles G, and issues a `ContactWarning` if its own answer is not certified.

        Parameters
        ----------
        tol : float, optional
            Wanted bound in (0, 1), relative as in `solve`; by default the one that was asked for before.

        Returns
        -------
        Solution

        Raises
        ------
        UnsuitableProblemError
            If the matrix is no Z-matrix.
        ValueError
            If ``tol`` is out of range, or there is no finite answer to go on from.

        Examples
        --------
        >>> import contactqp as cq
        >>> rough = cq.solve(cq.gallery.paper_hexagon(), "osqp", tol=1e-2)
        >>> exact = rough.polish(tol=1e-11)
        >>> exact.status.value, exact.certificate.gap_bound < rough.certificate.gap_bound
        ('certified', True)
        """
        self._require_finite()
        request = Request.of(self.tol if tol is None else tol)
        method, note = chosen_backend("active-set", self.problem, {})
        polished = Solution.by(method, self.subject, request, warm_start=self.gap, note=note)
        polished.report("warn")
        return polished

    def sensitivity(self, *, tolerance: float = 1e-11) -> Sensitivity:
        """Return the derivatives of this solution by load, support and whatever else it depends on.

        Where nodes are undecided, or the bound is above 1e-8, the equations of the answer's free nodes are solved
        first, or, where its contact set is not the right one, active sets go on from it.

        Parameters
        ----------
        tolerance : float
            A node whose distance from a bound is at most this part of the gap scale, and whose reaction is at most
            this part of the mean nodal force, touches the bound without a force: derivatives are one-sided there. With
            0 proofs alone decide, which are of the stored numbers, and take their last digits at their word.

        Raises
        ------
        TypeError, ValueError
            If no enclosure is known, or the tolerance is not in [0, 1).

        Examples
        --------
        >>> import contactqp as cq
        >>> solution = cq.solve(cq.gallery.paper_hexagon(0.03), tol=1e-9)
        >>> solution.sensitivity().adjoint(reaction=1.0)["load"].shape
        (1857,)
        """
        from .sensitivity import Sensitivity

        return Sensitivity(self, tolerance)

    def continuum(self, effort: Effort = "energy") -> Continuum:
        """Return what this answer proves of the membrane itself, its distance from the lattice included.

        The certificate tells how far an answer is from the solution of the *lattice's* equations. This tells how far it
        is from the membrane that the lattice stands for: without unknown constants, with all rounding, and for any
        answer of any backend. The frame must run along lines of the lattice, or diagonals of its squares; for pointwise
        bounds a lattice may also be fitted to its contour.

        Parameters
        ----------
        effort : {"energy", "pointwise"}
            ``"energy"``: brackets of the potential energy, the energy norm of the error, and the contact error, in one
            pass; see `contactqp.continuum.energy`. ``"pointwise"``: besides, bounds of the deflection at every point,
            of the contact area, the total reaction and the free boundary, for a membrane of one tension over one
            support; the lattice is solved again a few times for that, from this answer on, which takes some five to ten
            times as long as a solve. See `contactqp.continuum.pointwise`. Either is computed once, and kept.

        Returns
        -------
        Continuum

        Raises
        ------
        AttributeError
            If there is no model, as of a bare problem.
        TypeError
            If it is not a model whose membrane can be enclosed.
        ValueError
            If ``effort`` is unknown, the answer is not finite, the lattice's frame does not run along its lines or
            diagonals of its squares, support and ceiling leave no room for the frame, or are not known to, between
            points of the lattice, a foundation is negative there, or the units are such that energies are no doubles.

        Examples
        --------
        >>> import contactqp as cq
        >>> lattice = cq.Frame.rectangle(1, 1).lattice(spacing=1 / 32)
        >>> membrane = cq.Membrane(lattice, tension=1.0, load=1.0, support=0.03)
        >>> found = cq.solve(membrane, tol=1e-9).continuum()
        >>> found.proven, found.energy_error < 0.0074, found.energy.lower < -0.013581 < found.energy.upper
        (True, True, True)
        """
        one_of(effort, ("energy", "pointwise"), "effort")
        return self._pointwise_bounds if effort == "pointwise" else self._energy_bounds

    @cached_property
    def _energy_bounds(self) -> Continuum:
        model = self._physical("continuum")
        self._require_finite()
        return continuum_of(model, self.gap, "energy")

    @cached_property
    def _pointwise_bounds(self) -> Continuum:
        model = self._physical("continuum")
        self._require_finite()
        resolve = Resolved(model, self.gap) if isinstance(model, Membrane) else None
        return continuum_of(model, self.gap, "pointwise", resolve)

    @overload
    def discretisation_estimate(self, effort: Literal["energy"] = "energy") -> EnergyEstimate: ...
    @overload
    def discretisation_estimate(self, effort: Literal["pointwise"]) -> DiscretisationEstimate: ...
    def discretisation_estimate(self, effort: Effort = "energy") -> EnergyEstimate | DiscretisationEstimate:
        """Estimate how far the answer is from the membrane itself, from lattices of other spacings.

        Nothing is proven by it: see `continuum` for what is. On the gallery's membranes with closed forms either is
        within 0.7 to 1.5 times the true error.

        Parameters
        ----------
        effort : {"energy", "pointwise"}
            ``"energy"``: the error in the energy norm, from lattices of twice and four times the spacing, which take a
            third of what this answer took. ``"pointwise"``: the error of the deflection at each node, from a lattice of
            half the spacing, which takes four to six times as long. Coarser lattices do not tell it: it depends on
            where between two nodes the free boundary lies.

        Returns
        -------
        EnergyEstimate or DiscretisationEstimate

        Raises
        ------
        AttributeError
            If there is no model, as of a bare problem.
        TypeError, ValueError
            If ``effort`` is unknown, it is no membrane whose frame runs along lines of the lattice, or diagonals of its
            squares, and, for the energy norm, of those of one of twice the spacing; or the answer is not finite.
        """
        one_of(effort, ("energy", "pointwise"), "effort")
        model = self._physical("discretisation_estimate")
        self._require_finite()

        def solve(relative: Membrane) -> Vector:
            method, note = chosen_backend("auto", relative.problem, {})
            answer = Solution.by(method, relative, Request.of(self.tol), note=note)
            answer.report("warn")
            return answer.gap

        if effort == "energy":
            return energy_estimate(model, self.gap, solve)
        return discretisation_estimate(model, self.gap, solve)

    def _require_finite(self) -> None:
        if not self.finite:
            raise ValueError(f"there is no finite answer to go on from: {self.backend} said {self.termination!r}")

    def to_dataset(self, *, continuum: Effort | None = None) -> xr.Dataset:
        """Return all fields on the lattice as an xarray.Dataset with dims y and x (a cable: x), nan outside the frame.

        Variables: gap, deflection, support, ceiling, foundation, tension (or tension_x and tension_y; where there are
        such, and they vary), reaction, contact_pressure, load, contact (the backend's own contact set,
        True or False), gap_lower, gap_upper, reaction_lower, reaction_upper, and contact_state (1 certainly in contact
        with the support, 2 with an upper bound, 0 certainly clear, -1 undecided). Where there is no support, gap and
        its bounds are infinite. A cable net's has the dim node, with the coordinates x, y and point, and no
        contact_pressure.

        Parameters
        ----------
        continuum : {"energy", "pointwise"}, optional
            Whether to carry what is proven of the membrane itself, see `continuum`: the variables and attributes of
            `Continuum.to_dataset`, whose names begin with ``continuum_`` here.

        Examples
        --------
        >>> import contactqp as cq
        >>> solution = cq.solve(cq.Cable(1.0, spacing=0.25, tension=1.0, load=1.0, support=0.1))
        >>> data = solution.to_dataset(continuum="energy")
        >>> bool((data["continuum_deflection_lower"] <= data["deflection"]).all()), data.attrs["continuum_data"]
        (True, 'exact')
        """
        from ..io.datasets import solution_dataset

        return solution_dataset(self, self._physical("to_dataset"), self._carried(continuum))

    def _carried(self, effort: Effort | None) -> Carried | None:
        """Return what is proven of the membrane itself, if it is asked for."""
        return None if effort is None else self.continuum(effort).carried

    def save(self, path: str | Path, *, continuum: Effort | None = None) -> Path:
        """Write the solution into a file of the format that its suffix names, replacing one of that name as a whole.

        Parameters
        ----------
        path : str or Path
            ``.nc`` and ``.zarr`` (a folder): the dataset of `to_dataset` by the conventions of CF, with the whole model
            and where it comes from, which `contactqp.load_solution` reads; ``.csv``: a line for each node; ``.vtu``:
            the deflected shape, and ``.vti``: the fields of a lattice, for ParaView; ``.tif``: a GeoTIFF of a
            membrane's fields; ``.geojson``: its contact patches. Of a bare problem ``.csv``, a line for each node, or
            ``.npz``, arrays by name with the problem, which `contactqp.load_solution` reads as well.
        continuum : {"energy", "pointwise"}, optional
            Whether what is proven of the membrane itself goes along, by names that begin with ``continuum_``: all of
            `to_dataset` in ``.nc`` and ``.zarr``; bounds at the nodes as columns of ``.csv``, as point data of
            ``.vtu`` and ``.vti``, and as bands of ``.tif``, where numbers are field data and tags. ``.geojson`` has no
            room for it, nor a table of nodes for an energy alone.

        Returns
        -------
        Path

        Raises
        ------
        TypeError, ValueError
            If the format does not take such a model, the suffix is unknown, or there is no such folder.
        ImportError
            If a package is missing; the message says what to type.

        Examples
        --------
        >>> import tempfile
        >>> import contactqp as cq
        >>> file = cq.solve(cq.gallery.bowl(15)).save(Path(tempfile.mkdtemp()) / "bowl.nc")
        >>> cq.load_solution(file).status.value
        'certified'
        """
        from ..io.writers import require_room, write_bare, write_solution

        path = path_of(path)
        if continuum is not None:
            self._physical("save(continuum=...)")
            require_room(path)
        if self.model is None:
            write_bare(self, path)
        else:
            write_solution(self, self.model, path, self._carried(continuum))
        return path

    def patches(self) -> pd.DataFrame:
        """Return a row for each contact patch: nodes in contact that arms join.

        Returns
        -------
        pandas.DataFrame
            patch (its number, from 1 on), nodes (how many), area (cable: length; nan where nodes stand for none),
            reaction (force), x and y (mean of its nodes, length), and, with a certificate, certain: how many of its
            nodes are proven to be in contact.

        Examples
        --------
        >>> import contactqp as cq
        >>> table = cq.solve(cq.gallery.islands()).patches()
        >>> int(table["nodes"].sum()) == int(cq.solve(cq.gallery.islands()).contact.sum())
        True
        """
        from ..io.patches import patches_of

        return patches_of(self, self._physical("patches"))

    def to_pyvista(self, kind: Literal["surface", "image"] = "surface") -> Any:
        """Return the solution as a mesh of PyVista, coloured by the contact state, with all fields at its points.

        Parameters
        ----------
        kind : {"surface", "image"}
            ``"surface"``: a `pyvista.UnstructuredGrid` of the deflected shape, z being the elevation; squares between
            the points of a lattice, frame included, or the segments of a cable or a net. ``"image"``: a
            `pyvista.ImageData` of a lattice's array, which is flat, and nan outside the frame.

        Raises
        ------
        TypeError
            If an image is asked for and the model has no lattice.
        ImportError
            If PyVista is not installed.

        Examples
        --------
        >>> import contactqp as cq
        >>> mesh = cq.solve(cq.gallery.bowl(15)).to_pyvista()
        >>> mesh.n_cells, mesh.active_scalars_name
        (256, 'contact_state')
        """
        from ..io.meshes import image_of, surface_of

        model = self._physical("to_pyvista")
        return {"surface": surface_of, "image": image_of}[one_of(kind, ("surface", "image"), "kind")](self, model)

    def plot(
        self,
        ax: Any = None,
        *,
        kind: Literal["map", "surface"] = "map",
        section: float | None = None,
        title: str | None = None,
        units: UnitNames = "",
        continuum: Literal["pointwise"] | None = None,
    ) -> Figure:
        """Draw the contact map and a section with support, deflection and reaction.

        The certain states have their own colours: in contact, clear, undecided; a line marks the free boundary.
        A cable and any model whose nodes lie in a line have a section only, a cable net its plan and a view in space,
        and a bare `ContactQP` its gaps and reactions, sorted. The figure shows itself in a notebook; elsewhere use
        ``figure.savefig``.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own to draw into: the map, or a cable's shape, alone. By default there is a new figure.
        kind : {"map", "surface"}
            ``"surface"`` is a view of a membrane in space, see `plot3d`.
        section : float, optional
            Ordinate y of the section (length); the nearest row is drawn. By default the middle one, or where that
            touches nowhere the one of the largest reaction.
        title : str, optional
            Headline in place of the picture's own.
        units : str or mapping, optional
            Unit of length for labels, as ``"m"``, or ``{"length": "m", "force": "kN"}``.
        continuum : {"pointwise"}, optional
            Whether to draw in the map the strip that holds the free boundary of the membrane itself, see `continuum`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from ..plotting.answers import plot_solution

        one_of(kind, ("map", "surface"), "kind")
        if continuum is not None:
            one_of(continuum, ("pointwise",), "continuum")
            if kind == "surface":
                raise ValueError("the strip of the free boundary is drawn in a map; leave kind or continuum out")
        if kind == "surface":
            figure: Figure = self.plot3d(ax, title=title, units=units)
            return figure
        strip = None if continuum is None else self.continuum(continuum).strip
        return plot_solution(self, Wanted(ax, section, title, units), strip)

    def plot3d(
        self, ax: Any = None, *, title: str | None = None, units: UnitNames = "", interactive: bool = False
    ) -> Any:
        """Draw a membrane's deflection over its support in space, with what is in contact in its own colour.

        Parameters
        ----------
        ax : matplotlib axes in space, optional
            By default there is a new figure.
        title, units
            See `plot`.
        interactive : bool
            Whether to draw by PyVista, for turning and zooming: any model's deflected shape over its support, heights
            drawn larger than lengths in plan.

        Returns
        -------
        matplotlib.figure.Figure, or pyvista.Plotter
            The latter if ``interactive``: ``show()`` opens it.

        Raises
        ------
        TypeError
            If it is no membrane's solution and not ``interactive``, or ``ax`` is not in space.
        ImportError
            If it is to be interactive and PyVista is not installed.
        """
        if interactive:
            from .in_space import plotter_of

            if ax is not None:
                raise TypeError("an interactive view takes no ax of matplotlib; leave it out")
            return plotter_of(self, self._physical("plot3d"), title)
        from ..plotting.answers import plot_in_space

        return plot_in_space(self, Wanted(ax, None, title, units))

    def _repr_html_(self) -> str:
        from ..plotting.cards import solution_card

        facts = dict[str, str]()
        for name, fact in self._facts():
            facts[name] = f"{facts[name]}; {fact}" if name in facts else fact
        return solution_card(self, facts | {"time": self._time, "iterations": self._count_of_iterations})

    @property
    def _count_of_iterations(self) -> str:
        return counted(self.iterations, self.iteration_unit)

    @property
    def _time(self) -> str:
        loading = self.loading_seconds
        return f"{self.seconds:.3g} s" + (f" and {loading:.2g} s of loading" if loading > _WORTH_TELLING else "")

    def __repr__(self) -> str:
        head = f"Solution by {self.backend}: {self.status.value}, {self._count_of_iterations}, {self._time}"
        return "\n".join([head, *(f"  {name:<11} {fact}" for name, fact in self._facts())])

    def _facts(self) -> Iterator[tuple[str, str]]:
        """Yield what there is to tell, one line each, by its name."""
        yield "problem", repr(self.problem if self.model is None else self.model)
        wanted = f"of the error scale; tol {self.tol:g}"
        if self.certificate is not None:
            relative = f"{at_most(self.relative_bound, 1)} {wanted}"
            lacking = "no proof of an M-matrix" if self.problem.is_z_matrix else "no M-matrix"
            proof = f"weaker bound, {lacking}" if self.certificate.weaker else "certified"
            yield "gap error", f"<= {at_most(self.certificate.gap_bound)} ({proof}), {relative}"
            yield "against", DISCRETE
            yield "nodes", f"{_counts_of(self.certificate)}: proven of the exact solution"
        elif self.residuals is not None:
            residual = f"{self.residuals.natural_residual:.2g} (natural), {self.relative_residual:.1g} {wanted}"
            yield "residual", f"{residual}; no enclosure is known for this matrix"
        for caution in self.cautions:
            yield "caution", caution
        for finding in self.findings:
            yield "finding", finding
        if self.note:
            yield "note", self.note
        if not self.status.ok:
            yield f"{self.backend} said", self.termination
            if self._conditioning:
                yield "matrix", self._conditioning
            yield "advice", self.advice


def _counts_of(certificate: Certificate) -> str:
    """Return how many nodes are proven to be in which state, in words."""
    proven = {"in contact": certificate.contact}
    if not certificate.problem.one_sided:
        proven = {"at lower": certificate.contact_lower, "at upper": certificate.contact_upper}
    states = {**proven, "clear": certificate.clear, "undecided": certificate.undecided}
    return ", ".join(f"{np.count_nonzero(nodes)} {name}" for name, nodes in states.items())
