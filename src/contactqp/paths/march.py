r"""march(): the parabolic obstacle problem, step by step, each step a contact problem.

A model whose nodes are damped moves by c ∂w/∂t = p - k w + (the pull of its arms) - ρ, w ≤ f, ρ ≥ 0, ρ (f - w) = 0.
With the nodes' areas A, the arms' and the foundation's pull K(w), and the damping C = cA, a step of implicit Euler is

.. math:: (C/Δt) w + K(w) = P + (C/Δt) w_{old} - R,

and one of Crank and Nicolson's method, multiplied by two so that its matrix is that of a model, too,

.. math:: (2C/Δt) w + K(w) = P + P_{old} - K(w_{old}) + (2C/Δt) w_{old} - R,

where R is twice the mean reaction. Either is the model on a stiffer foundation under another load. Half a step of Euler
has the matrix of a whole one of Crank and Nicolson.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..backends.base import Backend
from ..foundation.checks import Vector, one_of, read_only, real_array, refuse_non_finite
from ..foundation.progress import Progress
from ..foundation.text import counted
from ..models.base import ContactModel
from ..models.varied import admissible, depths_at_rest, reachable, with_foundation, with_load_of
from ..solving.choice import chosen_backend
from ..solving.solution import Solution
from ..solving.solver import Solver
from .time_history import TimeHistory

_DAMPED_STEPS = 2
"""Steps at the beginning that are each made as two halves of Euler's method, which damp what oscillates (Rannacher)."""

_EQUAL = 1e-9
"""Steps whose lengths differ by no more than this part are one length, and so have one matrix."""

_ROUNDING = 1e-9
"""Part of its heights by which an initial state may pass the support."""


@dataclass(frozen=True)
class _Step:
    """One solve.

    Attributes
    ----------
    start, end : float
        Times.
    length : float
        Of the step, rounded to that of those before.
    implicit : bool
        Whether by Euler's method, else by that of Crank and Nicolson.
    told : bool
        Whether its end is one of the times.
    """

    start: float
    end: float
    length: float
    implicit: bool
    told: bool

    @property
    def rate(self) -> float:
        """What the damping is multiplied by for the step's foundation (1/time)."""
        return 1 / self.length if self.implicit else 2 / self.length


def march(
    model: ContactModel,
    *,
    times: Iterable[float],
    damping: Any,
    method: Literal["crank-nicolson", "euler"] = "crank-nicolson",
    load: Callable[[float], Any] | Iterable[float] | None = None,
    initial: Any = None,
    backend: str | Backend = "auto",
    tol: float | str = 1e-8,
    checkpoint: str | Path | None = None,
    on_failure: Literal["warn", "raise", "ignore"] = "warn",
    **options: Any,
) -> TimeHistory:
    """Let a damped model move over its support in time: the parabolic obstacle problem.

    c ∂w/∂t = p - kw + ∂x(T ∂x w) + ∂y(T ∂y w) - ρ with w ≤ f, ρ ≥ 0 and ρ(f - w) = 0, and a ceiling if there is one;
    for a net the same with forces at its nodes. Between two times is one step, which is a contact problem and solved by
    a session; each is certified as far as `solve` certifies, given the state before (see `TimeHistory`).

    Parameters
    ----------
    model : ContactModel
        `Membrane`, `MeshMembrane`, `Cable`, `CableNet`, `Beam`, `Plate`, or one of your own.
        What moves; its frame and its support stay. It is never modified.
    times : sequence of float
        Ascending, at least two; the first is that of the initial state. Equal steps share one matrix, and what a
        backend has set up for it.
    damping : number, array, xarray.DataArray or function of (x, y)
        c > 0, given as a load is: force per area, or per length of a cable, or of a net's node force, per velocity.
    method : {"crank-nicolson", "euler"}
        Crank and Nicolson's method, of second order in the step, whose first two steps are made as two halves of
        implicit Euler each so that jumps in the data do not oscillate (Rannacher, *Finite element solution of diffusion
        problems with irregular data*, Numer. Math. 43, 1984); or implicit Euler, of first order.
    load : function of time, or sequence of float, optional
        A function returns the load at a time, given as when the model was made; a sequence has a factor of the model's
        load for each of the times, linear between them. By default the model's load stays.
    initial : number, array, xarray.DataArray, function of (x, y) or Solution, optional
        Deflection at the first time (length), positive as the model's heights, between support and ceiling. By default
        the mean height of the frame, or where that is not admissible the nearest height that is.
    backend, tol, on_failure, **options
        As for `solve`; the default tol is smaller, as errors of steps add up.
    checkpoint : path, optional
        A NetCDF file that keeps what is done after every step, so that the same call resumes an interrupted march from
        it, as for `trace`. What is kept is judged anew, for the step that it belongs to.

    Returns
    -------
    TimeHistory

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or range, or the checkpoint belongs to another march, or is in use.
    NotCertifiedError
        If a step is not certified and ``on_failure="raise"``.

    Examples
    --------
    A cable that is let go above a floor, and comes to rest on it:

    >>> import numpy as np
    >>> import contactqp as cq
    >>> cable = cq.Cable(span=10.0, spacing=0.5, tension=1.0, load=1.0, support=4.0)
    >>> history = cq.march(cable, times=np.linspace(0.0, 40.0, 41), damping=1.0)
    >>> [int(solution.contact.sum()) for solution in history.solutions[:10:3]], history.certified
    ([0, 0, 9, 9], True)
    >>> float(np.abs(history.deflections[-1] - cq.solve(cable).deflection).max().round(6))
    0.0
    """
    if not isinstance(model, ContactModel):
        raise TypeError(f"model must be a model, as Membrane, Cable or Beam, got {type(model).__name__}")
    one_of(on_failure, ("warn", "raise", "ignore"), "on_failure")
    one_of(method, ("crank-nicolson", "euler"), "method")
    instants = _checked_times(times)
    resistance = _checked_damping(model, damping)
    load_at = _load_in_time(model, load, instants)
    loads = _loads_at(model, load, load_at, instants)
    # Where the load stays, one row tells all.
    model = reachable(model, (with_load_of(model, row) for row in (loads[:1] if load is None else loads)))
    depths = _initial_depths(model, initial)
    first = -depths if model.upwards else depths
    steps = _steps(instants, method)
    on_ground = _OnGround(model, resistance)
    chosen, _ = chosen_backend(backend, on_ground.of(steps[0].rate).problem, {})
    session = Solver(on_ground.of(steps[0].rate), chosen, tol=tol, **options)
    with ExitStack() as held:
        file = None
        if checkpoint is not None:
            from .checkpoint import Checkpoint

            kind, more = f"time by {method}", (resistance, first)
            file = held.enter_context(Checkpoint(Path(checkpoint), model, kind, session.backend.name, tol, more).held())
        progress = held.enter_context(Progress(f"{counted(instants.size - 1, 'step')} · {model.size} nodes"))
        solutions: list[Solution] = []
        shares: list[float] = []
        for step in steps:
            progress.update(f"time {step.end:g}, of {instants[-1]:g}")
            problem = on_ground.at(step, depths, load_at(step.start), load_at(step.end))
            kept = None if file is None else file.restored(step.end, problem)[0]
            if kept is not None and kept.status.ok:
                solution = kept
            else:
                solution = session.solve_varied(problem)
                solution.report(on_failure)
                if file is not None:
                    file.keep(step.end, solution, -1)
            if not solution.finite:
                raise ArithmeticError(f"the step to time {step.end:g} has no finite answer: {solution.run.termination}")
            depths = -solution.deflection if model.upwards else solution.deflection
            if step.told:
                solutions.append(solution)
                shares.append(1.0 if step.implicit else 0.5)
    return TimeHistory(model, instants, first, tuple(solutions), method, read_only(loads), tuple(shares))


class _OnGround:
    """The model with the damping of a step in its foundation, and the state before in its load.

    Parameters
    ----------
    model : ContactModel
    damping : array, shape (n,)
    """

    def __init__(self, model: ContactModel, damping: Vector) -> None:
        self._model, self._damping = model, damping
        self._rate, self._held = 0.0, model

    def of(self, rate: float) -> ContactModel:
        """Return the model on the foundation of a step; the last one is kept."""
        if rate != self._rate:
            own = 0.0 if self._model.foundation is None else self._model.foundation
            self._rate, self._held = rate, with_foundation(self._model, own + rate * self._damping)
        return self._held

    def at(self, step: _Step, depths: Vector, before: Vector, after: Vector) -> ContactModel:
        """Return the model of a step from a state (depths, length), under the loads at its ends."""
        load = after + step.rate * self._damping * depths
        if not step.implicit:
            pull = self._model.pull(depths)
            areas = self._model.node_area
            load = load + (before - (pull if areas is None else pull / areas))
        return with_load_of(self.of(step.rate), read_only(load))


def _steps(times: Vector, method: str) -> list[_Step]:
    """Return the solves that lead through the times."""
    found: list[_Step] = []
    length = 0.0
    for k, (start, end) in enumerate(zip(times[:-1].tolist(), times[1:].tolist(), strict=True)):
        if abs((end - start) - length) > _EQUAL * length:
            length = end - start
        if method == "crank-nicolson" and k < _DAMPED_STEPS:
            middle = 0.5 * (start + end)
            found += [_Step(start, middle, length / 2, True, False), _Step(middle, end, length / 2, True, True)]
        else:
            found.append(_Step(start, end, length, method == "euler", True))
    return found


def _checked_times(times: Any) -> Vector:
    values = real_array(times if isinstance(times, (np.ndarray, str)) else list(times), "times")
    if values.ndim != 1 or values.size < 2:
        raise ValueError(f"times must be at least two numbers, that of the initial state first, got {times!r}")
    refuse_non_finite(values, "times")
    if not (np.diff(values) > 0).all():
        worst = int(np.argmin(np.diff(values)))
        raise ValueError(f"times must ascend, but {values[worst + 1]:g} follows {values[worst]:g}")
    return read_only(values)


def _checked_damping(model: ContactModel, damping: Any) -> Vector:
    values = model.at_nodes(damping, "damping")
    if not values.min() > 0:
        worst = int(np.argmin(values))
        raise ValueError(f"damping must be > 0, but is {values[worst]:g} at {model.describe(worst)}")
    return values


def _load_in_time(model: ContactModel, load: Any, times: Vector) -> Callable[[float], Vector]:
    """Return what gives the load at the nodes at a time, shape (n,)."""
    if load is None:
        return lambda time: model.load
    if callable(load):
        return lambda time: model.at_nodes(load(time), "load")
    factors = real_array(load if isinstance(load, (np.ndarray, str)) else list(load), "load")
    if factors.shape != times.shape:
        raise ValueError(
            f"load must be a function of time, or have a factor for each of the {times.size} times, got shape "
            f"{factors.shape}"
        )
    refuse_non_finite(factors, "load")
    return lambda time: np.asarray(float(np.interp(time, times, factors)) * model.load)


def _loads_at(model: ContactModel, load: Any, load_at: Callable[[float], Vector], times: Vector) -> Vector:
    """Return the load at the nodes at all times, shape (k + 1, n); a load that stays takes no memory for each."""
    if load is None:
        return np.broadcast_to(model.load, (times.size, model.size))
    loads = np.empty((times.size, model.size))
    for row, time in zip(loads, times, strict=True):
        row[:] = load_at(float(time))
    return loads


def _initial_depths(model: ContactModel, initial: Any) -> Vector:
    """Return the depths of the nodes at the first time (length), shape (n,)."""
    if initial is None:
        return depths_at_rest(model)
    heights = model.at_nodes(initial.deflection if isinstance(initial, Solution) else initial, "initial")
    depths = -heights if model.upwards else np.array(heights)
    allowed = admissible(model, depths)
    beyond = np.abs(depths - allowed)
    if beyond.max() > _ROUNDING * max(float(np.abs(depths).max()), float(np.abs(allowed).max())):
        worst = int(beyond.argmax())
        nearest = -allowed[worst] if model.upwards else allowed[worst]
        raise ValueError(
            f"initial must lie between support and ceiling, but is {heights[worst]:g} at {model.describe(worst)}, "
            f"where {nearest:g} is the nearest height that does"
        )
    return allowed
