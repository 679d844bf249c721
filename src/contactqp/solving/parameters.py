"""What a contact problem's data are functions of: how they change with a parameter, and back."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..foundation.checks import Vector, finite_number, vector
from ..models.base import ContactModel
from ..models.sensitive import FrameHeights, Resistance, Values, one_each
from ..problem.contact_problem import ContactProblem


@dataclass
class Change:
    """Derivatives of the data of a contact problem, or of a number by them.

    Attributes
    ----------
    reaction : array, shape (n,)
        Of the reaction at a gap that stays (force).
    lower, upper : array, shape (n,)
        Of the bounds (length).
    reference : array, shape (n,)
        Of the depth that the gap is measured from (length).
    """

    reaction: Vector
    lower: Vector
    upper: Vector
    reference: Vector

    @classmethod
    def none(cls, size: int) -> Change:
        """Return that of n unknowns by what does not matter."""
        return cls(*(np.zeros(size) for _ in range(4)))

    def add(self, other: Change) -> None:
        """Add another one."""
        self.reaction = self.reaction + other.reaction
        self.lower = self.lower + other.lower
        self.upper = self.upper + other.upper
        self.reference = self.reference + other.reference


@dataclass(frozen=True)
class Parameter:
    """One of the parameters, as a linear map and its transpose.

    Attributes
    ----------
    of : callable
        Returns the `Change` for a direction, which is checked.
    by : callable
        Returns the derivative of a number by the parameter, given those by the data.
    """

    of: Callable[[Any], Change]
    by: Callable[[Change], Any]


class Parameters(ABC):
    """The parameters of what was solved, by their names."""

    known: Mapping[str, Parameter]

    def change(self, directions: Mapping[str, Any]) -> Change:
        """Return the change of the data in some directions together.

        Raises
        ------
        TypeError, ValueError
            If a name is unknown, or a direction of the wrong kind or shape.
        """
        if not directions:
            raise TypeError(f"give the direction of a parameter at least: {', '.join(self.known)}")
        total = Change.none(self.size)
        for name, direction in directions.items():
            total.add(self.named(name).of(direction))
        return total

    def gradient(self, by_data: Change, names: Collection[str]) -> dict[str, Any]:
        """Return the derivatives of a number by some parameters, given those by the data."""
        return {name: self.named(name).by(by_data) for name in names}

    def named(self, name: str) -> Parameter:
        """Return a parameter by its name.

        Raises
        ------
        TypeError
            If there is none.
        """
        if name not in self.known:
            raise TypeError(f"there is no parameter {name!r}; give {', '.join(self.known)}")
        return self.known[name]

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of unknowns n."""


class OfProblem(Parameters):
    """Those of a bare problem: forces and bounds."""

    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem
        self.known = {
            "q": Parameter(self._of("reaction"), lambda by: by.reaction),
            "lower": Parameter(self._of("lower"), lambda by: by.lower),
            "upper": Parameter(self._of("upper"), lambda by: by.upper),
        }

    @property
    def size(self) -> int:
        """See `Parameters.size`."""
        return self._problem.size

    def _of(self, name: str) -> Callable[[Any], Change]:
        def changed(direction: Any) -> Change:
            change = Change.none(self.size)
            given = np.full(self.size, float(direction)) if np.ndim(direction) == 0 else direction
            setattr(change, name, vector(given, self.size, name))
            return change

        return changed


class OfModel(Parameters):
    r"""Those of a model with G = A + K, A its arms and K its foundation.

    In depths, with the deflection w = f - ω, it is R = P - (Aw - Bh) - Kw with the frame's heights h, and A1 = B1
    because moving all at once takes no force of the arms. At a gap that stays, w changes as f does.
    """

    def __init__(self, model: ContactModel, gap: Vector, reaction: Vector) -> None:
        self._model, self._problem = model, model.problem
        self._deflection = model.reference - gap
        self._pull_of_arms = model.nodal_load - reaction - self._foundation * self._deflection
        self.known = {
            "load": Parameter(self._of_load, lambda by: self._areas * by.reaction),
            "support": Parameter(self._of_support, self._by_support),
            "frame_height": Parameter(self._of_frame, self._by_frame),
        }
        if model.ceiling is not None:
            self.known["ceiling"] = Parameter(self._of_ceiling, lambda by: -self._sign * self._under_ceiling * by.upper)
        if model.foundation is not None:
            self.known["foundation"] = Parameter(
                self._of_foundation, lambda by: -self._areas * self._deflection * by.reaction
            )
        for name, resistance in model.resistances.items():
            self.known[name] = Parameter(
                partial(self._of_resistance, name, resistance), partial(self._by_resistance, resistance)
            )
        frame = model.heights_of_frame
        if frame is not None:
            self.known[frame.name] = Parameter(partial(self._of_points, frame), partial(self._by_points, frame))
        if isinstance(getattr(model, "tension", None), float):
            self._by_tension = model.pull_per_tension(self._deflection, self._pull_of_arms)
            self.known["tension"] = Parameter(self._of_tension, lambda by: -float(by.reaction @ self._by_tension))

    @property
    def size(self) -> int:
        """See `Parameters.size`."""
        return self._model.size

    @property
    def _sign(self) -> float:
        """What depths are in the model's own sense."""
        return -1.0 if self._model.upwards else 1.0

    @property
    def _areas(self) -> Vector | float:
        return 1.0 if self._model.node_area is None else self._model.node_area

    @property
    def _foundation(self) -> Vector | float:
        stiffness = self._model.nodal_foundation
        return 0.0 if stiffness is None else stiffness

    @property
    def _under_ceiling(self) -> Vector:
        return np.asarray(self._model.under_ceiling, dtype=np.float64)

    def _of_load(self, direction: Any) -> Change:
        change = Change.none(self.size)
        change.reaction = self._areas * self._model.at_nodes(direction, "load")
        return change

    def _of_support(self, direction: Any) -> Change:
        change = Change.none(self.size)
        depth = self._sign * self._model.at_nodes(direction, "support")
        change.reference = np.where(self._model.supported, depth, 0.0)
        change.reaction = -self._problem.stiffness.matvec(change.reference)
        change.upper = self._under_ceiling * change.reference
        return change

    def _by_support(self, by: Change) -> Vector:
        return np.where(self._model.supported, self._sign * self._by_reference(by), 0.0)

    def _by_reference(self, by: Change) -> Vector:
        return by.reference - self._problem.stiffness.transposed.matvec(by.reaction) + self._under_ceiling * by.upper

    def _of_ceiling(self, direction: Any) -> Change:
        change = Change.none(self.size)
        change.upper = -self._sign * self._under_ceiling * self._model.at_nodes(direction, "ceiling")
        return change

    def _of_foundation(self, direction: Any) -> Change:
        change = Change.none(self.size)
        change.reaction = -self._areas * self._deflection * self._model.at_nodes(direction, "foundation")
        return change

    def _of_frame(self, direction: Any) -> Change:
        rise = self._sign * finite_number(direction, "frame_height")
        return self._frame_moved(rise * self._pull_of_frame, rise)

    def _frame_moved(self, force: Vector, mean: float) -> Change:
        """Return the change by forces of a frame that moves, from whose mean height gaps without a support count."""
        change = Change.none(self.size)
        change.reference = np.where(self._model.supported, 0.0, mean)
        change.reaction = force - self._problem.stiffness.matvec(change.reference)
        change.upper = self._under_ceiling * change.reference
        return change

    def _of_points(self, frame: FrameHeights, direction: Any) -> Change:
        depths = self._sign * one_each(direction, frame.weights.shape, frame.name)
        return self._frame_moved(frame.force(depths), float((frame.weights * depths).sum()))

    def _by_points(self, frame: FrameHeights, by: Change) -> Values:
        unsupported = float(self._by_reference(by)[~self._model.supported].sum())
        return self._sign * (frame.share(by.reaction) + unsupported * frame.weights)

    def _by_frame(self, by: Change) -> float:
        unsupported = self._by_reference(by)[~self._model.supported].sum()
        return self._sign * float(by.reaction @ self._pull_of_frame + unsupported)

    @cached_property
    def _pull_of_frame(self) -> Vector:
        """B1: the forces on the nodes when the frame moves down by one."""
        return self._problem.stiffness.matvec(np.ones(self.size)) - self._foundation

    def _of_resistance(self, name: str, resistance: Resistance, direction: Any) -> Change:
        change = Change.none(self.size)
        change.reaction = -resistance.pull(self._deflection, one_each(direction, resistance.shape, name))
        return change

    def _by_resistance(self, resistance: Resistance, by: Change) -> Values | float:
        found = -resistance.share(self._deflection, by.reaction)
        return found if resistance.shape else float(found)

    def _of_tension(self, direction: Any) -> Change:
        change = Change.none(self.size)
        change.reaction = -finite_number(direction, "tension") * self._by_tension
        return change
