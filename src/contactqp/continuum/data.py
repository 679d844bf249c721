"""Data: what is known of a model's load, support, frame and tension everywhere, not at its nodes alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, repeated
from ..foundation.intervals import Interval
from ..foundation.surfaces import Curvature, Ranged
from ..geometry.fields import OnFrame, evaluated, is_function
from ..geometry.numbering import Grid
from ..models.on_lattice import LatticeModel
from ..profiles.analytic import Profile
from .cell_fields import CellField, array_field, continued, function_field, number_field
from .plan import CORNERS, Plan
from .stiff_signs import require_not_negative

Surfaces: TypeAlias = list[tuple[CellField, float]]
"""Fields that depths, multiplied by a sign, must not exceed."""


class Tensions(NamedTuple):
    """The tension in the quarter of each square that belongs to one of its corners (force per length).

    Attributes
    ----------
    middle, spread : float or array, shape (rows + 1, columns + 1)
        It lies within ``spread`` of ``middle``.
    mean_apart : float or array
        How far its mean over the quarter lies from ``middle`` at most.
    """

    middle: Any
    spread: Any
    mean_apart: Any

    @property
    def least(self) -> Any:
        """A lower bound of it."""
        return (self.middle - self.spread) * (1 - 1e-15)


@dataclass(frozen=True, eq=False)
class Data:
    """The fields of a model on the squares of its plan, as depths: positive downwards whatever the model's heights are.

    Attributes
    ----------
    model : Membrane or Cable
    plan : Plan

    Raises
    ------
    ValueError
        If the model has no such plan: its lattice is fitted to a contour, the frame's points lie outside it, or its
        sides cut squares elsewhere than along diagonals.
    """

    model: LatticeModel
    plan: Plan

    @classmethod
    def of(cls, model: LatticeModel) -> Data:
        """Return the data of a model on a lattice."""
        lattice = model.lattice
        if lattice.cuts is not None:
            raise ValueError(
                f"{lattice!r}: its frame cuts arms between the points of the lattice, and only one that runs "
                "along lines of the lattice can be enclosed; take fitted=False, and a spacing that fits if there is one"
            )
        if lattice.overshoot or (lattice.slanted and lattice.halved is None):
            how = "lies beside the lattice's points" if lattice.overshoot else "has slanted sides that cut squares"
            raise ValueError(
                f"{lattice!r}: its contour {how}, and only a frame that runs along lines of the lattice, or along "
                "diagonals of its squares as well with corners of 90° and more, can be enclosed; take "
                "Lattice.from_mask(lattice.mask, lattice.spacing, lattice.origin), another membrane, whose frame goes "
                "in steps"
            )
        return cls(model, Plan(lattice))

    def require_whole_squares(self, what: str) -> None:
        """Refuse a frame with slanted sides, for which something is not known."""
        if self.plan.halved.any():
            raise ValueError(
                f"{self.model.lattice!r}: its contour has slanted sides, and {what} only of a frame that runs along "
                "lines of the lattice; effort='pointwise' encloses the membrane in this one as well"
            )

    @cached_property
    def load(self) -> CellField:
        """Active pressure p, positive downwards (force per area)."""
        return self._field("load", self.model.load)

    @cached_property
    def support(self) -> CellField:
        """Depth of the support, infinite where there is none (length)."""
        return self._depth("support", self.model.depth, self._not_above_frame)

    @cached_property
    def ceiling(self) -> CellField | None:
        """Depth of the ceiling, -infinite where there is none (length); None without one."""
        depth = self.model.ceiling_depth
        return None if depth is None else self._depth("ceiling", depth, self._not_below_frame)

    @cached_property
    def surfaces(self) -> Surfaces:
        """What the membrane must not cross, each with the sign by which depths count so that it is an upper bound."""
        ceiling = [] if self.ceiling is None else [(-self.ceiling, -1.0)]
        return [(self.support, 1.0), *ceiling]

    def bends_of(self, surface: CellField, sign: float) -> Curvature | None:
        """Return the second derivatives of one of the `surfaces` on each square, as it counts; None if not known."""
        name = "support" if sign > 0 else "ceiling"
        given = self.model.given.get(name)
        if surface.straight or not is_function(given):
            none = Interval.of(np.zeros(self.plan.squares.shape))
            return Curvature(none, none, none)
        bends = given.curvature(*self.plan.around_squares) if isinstance(given, Ranged) else None
        if bends is None:
            return None
        turned = (self.model.upwards and not isinstance(given, Profile)) != (sign < 0)
        shape = self.plan.squares.shape
        parts = [-part if turned else part for part in bends]
        return Curvature(*(Interval(*(np.broadcast_to(end, shape) for end in (p.lower, p.upper))) for p in parts))

    @cached_property
    def foundation(self) -> CellField | None:
        """Stiffness k of the foundation (force per area and length); None without one.

        Raises
        ------
        ValueError
            If it is a function that is negative between the points.
        """
        stiffness, given = self.model.foundation, self.model.given.get("foundation")
        if stiffness is None or not (stiffness.any() or isinstance(given, Ranged)):
            return None
        if isinstance(given, Ranged):
            require_not_negative(given, self.plan.around_squares, self.plan.squares)
        return self._field("foundation", stiffness)

    @cached_property
    def frame(self) -> CellField:
        """Depth of the frame at its points, and how far it leaves the chord between two of them (length).

        At nodes its values are not used.
        """
        plan, given = self.plan, self.model.given.get("frame_height", 0.0)
        if not callable(given) and not isinstance(given, OnFrame):
            return number_field(plan, -given if self.model.upwards else given)
        if callable(given):
            return self._turned(given, function_field(plan, given, self._at_points(given, "frame_height", plan.points)))
        held = self.model.frame_heights
        assert held is not None
        own = np.where(self.model.frame_points(), held, self._on_frame(given))
        return self._turned(given, array_field(plan, continued(plan, np.zeros(plan.lattice.size), own)))

    @cached_property
    def bend_of_frame(self) -> Grid:
        """Bound of the modulus of the frame's second derivative along its edges, in each square with one of them."""
        return np.maximum(*self._bends_of_edges)

    @cached_property
    def bent_edges(self) -> Grid:
        """How many directions the frame's edges are bent along in each square, 0, 1 or 2."""
        return np.asarray(np.add(*[bend > 0 for bend in self._bends_of_edges], dtype=np.int64))

    @cached_property
    def _bends_of_edges(self) -> tuple[Grid, Grid]:
        """Bounds of the frame's second derivative along the edges of each square that run along x, and along y."""
        plan, given = self.plan, self.model.given.get("frame_height", 0.0)
        most = np.zeros(plan.squares.shape), np.zeros(plan.squares.shape)
        if not callable(given) or not self.frame.exact or not isinstance(given, Ranged):
            return most
        (x, y), (around_x, around_y) = plan.around_points, plan.around_squares
        for along, places in enumerate(((around_x, y), (x, around_y))):
            bends = given.curvature(*places)
            for corner in range(4):
                # The edges along x are those from the first corner to the second, and from the fourth to the third.
                ends = corner, (1, 0, 3, 2)[corner] if along == 0 else 3 - corner
                of_frame = plan.squares & np.logical_and(*[plan.at_corner(plan.frame, end) for end in ends])
                if bends is None:
                    most[along][of_frame] = np.inf
                    continue
                own = bends[0 if along == 0 else 2].magnitude
                shape = (plan.nodes.shape[0], plan.squares.shape[1]) if along == 0 else (plan.squares.shape[0], -1)
                own = np.broadcast_to(own, shape if along == 0 else (shape[0], plan.nodes.shape[1]))
                down, right = CORNERS[corner]
                rows, columns = plan.squares.shape
                beside = own[down : down + rows] if along == 0 else own[:, right : right + columns]
                np.maximum(most[along], np.where(of_frame, beside, 0.0), out=most[along])
        return most

    @cached_property
    def arms(self) -> tuple[Any, Any]:
        """Tension of the arms along x and along y between all points; any number where no node is at an end."""
        fields = self.model.tension_of_arms.fields
        found = []
        for axis, field in zip((1, 0), (fields[0], fields[-1]), strict=True):
            short = ((1, 1), (0, 0)) if axis == 1 else ((0, 0), (1, 1))
            arms = field.arms
            found.append(arms if isinstance(arms, float) else np.pad(arms, short, mode="edge"))
        return found[0], found[1]

    @cached_property
    def stiffness(self) -> Grid:
        """The lattice's own stiffness G_ii at each node (force per length), zero elsewhere."""
        at_points = np.zeros(self.plan.nodes.shape)
        along_x, along_y = (
            np.broadcast_to(arms, shape) for arms, shape in zip(self.arms, self._arm_shapes, strict=True)
        )
        at_points[:, 1:-1] += along_x[:, :-1] + along_x[:, 1:]
        at_points[1:-1] += along_y[:-1] + along_y[1:]
        if self.foundation is not None:
            at_points += self.foundation.values * self.plan.spacing**2
        return np.where(self.plan.nodes, at_points, 0.0)

    @property
    def _arm_shapes(self) -> tuple[tuple[int, int], tuple[int, int]]:
        rows, columns = self.plan.nodes.shape
        return (rows, columns - 1), (rows - 1, columns)

    @cached_property
    def sampled(self) -> tuple[str, ...]:
        """Names of the data that are known at points alone, so that nothing is proven of what lies between."""
        parts = {"load": self.load, "support": self.support, "frame_height": self.frame}
        parts |= {name: part for name, part in (("ceiling", self.ceiling), ("foundation", self.foundation)) if part}
        names = [name for name, part in parts.items() if not part.exact]
        return (*names, *(["tension"] if not self._tension_is_exact else []))

    def tensions(self, axis: int, corner: int) -> Tensions:
        """Return the tension along x (axis 1) or y (axis 0) in the quarters at one of the squares' corners.

        Numbers are the same everywhere. An array, whose arms have harmonic means, is meant as constant about each node,
        up to the middles of its arms. A function is known by its range.
        """
        kept: Any = self._tension_fields[self._along(axis)]
        if isinstance(kept, float):
            return Tensions(kept, 0.0, 0.0)
        if not isinstance(kept, CellField):
            return Tensions(self.plan.at_corner(kept, corner), 0.0, 0.0)
        own, beside, above, across = (kept_at(self.plan, kept.values, corner, k) for k in range(4))
        inner = np.stack([own, (own + beside) / 2, (own + above) / 2, (own + beside + above + across) / 4])
        mean = (9 * own + 3 * beside + 3 * above + across) / 16
        with np.errstate(invalid="ignore"):
            spread = np.maximum(inner.max(axis=0) - mean, mean - inner.min(axis=0)) * (1 + 1e-14) + kept.apart
            rounding = 1e-15 * np.abs(mean)
            return Tensions(mean, spread + rounding, kept.apart + rounding)

    @cached_property
    def least_tension(self) -> tuple[float, float]:
        """Lower bounds of the tension along x and along y (force per length).

        Raises
        ------
        ValueError
            If what is known of it between the points leaves room for none.
        """
        found = []
        for axis in (1, 0):
            least = [np.broadcast_to(self.tensions(axis, k).least, self.plan.squares.shape) for k in range(4)]
            found.append(min(float(np.min(one[self.plan.squares])) for one in least))
        return require_positive(found[0]), require_positive(found[1])

    @cached_property
    def even_tension(self) -> bool:
        """Whether the tension is one number everywhere and in all directions, not at the points alone."""
        return self.model.tension_of_arms.constant and all(isinstance(field, float) for field in self._tension_fields)

    def tension_at_points(self, which: int) -> Grid:
        """Return the tension along x (0) or y (1) that an array tells, at the points (force per length)."""
        kept = self._tension_fields[which]
        return np.asarray(kept) if isinstance(kept, np.ndarray) else np.full(self.plan.nodes.shape, np.nan)

    def _along(self, axis: int) -> int:
        return 0 if axis == 1 else len(self.model.tension_of_arms.fields) - 1

    @cached_property
    def _tension_fields(self) -> tuple[float | Grid | CellField, ...]:
        tension = self.model.tension_of_arms
        sources = tension.source or (None,) * len(tension.fields)
        return tuple(self._tension_field(*each) for each in zip(sources, tension.fields, strict=True))

    def _tension_field(self, source: Any, field: Any) -> float | Grid | CellField:
        constant = isinstance(field.nodes, float) and isinstance(field.arms, float)
        if constant and not isinstance(source, Ranged):
            return float(field.nodes)
        if is_function(source):
            return function_field(self.plan, source, self._at_points(source, "tension", self.plan.points))
        nodes = np.broadcast_to(field.nodes, (self.model.size,))
        return self._nan_filled(continued(self.plan, nodes, self._on_frame(source)))

    @cached_property
    def _tension_is_exact(self) -> bool:
        tension = self.model.tension_of_arms
        if not tension.source:
            return tension.constant
        return all(
            field.exact if isinstance(field, CellField) else not is_function(source)
            for source, field in zip(tension.source, self._tension_fields, strict=True)
        )

    def _field(self, name: str, nodal: Vector, continued_as: Callable[[Grid], Grid] | None = None) -> CellField:
        """Return a field whose values at the nodes, in the sense in which it was given, are known."""
        plan, given = self.plan, self.model.given.get(name)
        if is_function(given):
            values = np.where(plan.frame, self._at_points(given, name, plan.frame), np.nan)
            values[plan.nodes] = nodal
            return function_field(plan, given, values)
        same = repeated(nodal) or bool((nodal == nodal[0]).all())
        if same and not isinstance(given, OnFrame):
            return number_field(plan, float(nodal[0]))
        on_frame = self._on_frame(given)
        values = continued(plan, nodal, on_frame)
        if continued_as is not None:
            values = np.where(np.isnan(on_frame), continued_as(values), values)
        return array_field(plan, self._nan_filled(values), exact=name in self.model.given)

    def _nan_filled(self, values: Grid) -> Grid:
        return np.where(self.plan.points, values, 0.0)

    def _on_frame(self, given: Any) -> Grid:
        """Return what an array tells at points that are no nodes, nan elsewhere."""
        grid = np.full(self.plan.nodes.shape, np.nan)
        if isinstance(given, OnFrame) and given.values is not None:
            grid[1:-1, 1:-1][~self.plan.lattice.mask] = given.values
        return grid

    def _depth(self, name: str, depth: Vector, continued_as: Callable[[Grid], Grid]) -> CellField:
        if not self.model.upwards:
            return self._field(name, depth, continued_as)
        given = self.model.given.get(name)
        if isinstance(given, Profile):
            return self._field(name, depth, continued_as)
        return -self._field(name, -depth, lambda values: -continued_as(-values))

    def _turned(self, given: Any, field: CellField) -> CellField:
        """Return heights as depths; a profile returns depths."""
        return -field if self.model.upwards and not isinstance(given, Profile) else field

    def _at_points(self, function: Any, name: str, where: Any) -> Grid:
        row, column = np.nonzero(where)
        values = np.full(self.plan.nodes.shape, np.nan)
        values[where] = evaluated(function, *self.plan.lattice.ring_coordinates(row, column), name)
        return values

    def _not_above_frame(self, values: Grid) -> Grid:
        """Where an array tells nothing of the support at the frame, it goes on as it is, or as low as the frame."""
        return np.where(self.plan.frame, np.maximum(values, self.frame.values), values)

    def _not_below_frame(self, values: Grid) -> Grid:
        return np.where(self.plan.frame, np.minimum(values, self.frame.values), values)


def require_positive(tension: float) -> float:
    """Return a lower bound of a tension, refuse one that is not above zero."""
    if not tension > 0:
        raise ValueError(
            f"tension is known to be no less than {tension:.3g} between two points of the lattice, which must be > 0: "
            "take a finer lattice, or declare its second_derivative or a smaller constant"
        )
    return tension


def kept_within(
    nodes: Mask, points: NDArray[np.float64], sign: float, most: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return values at the points, at nodes moved to where they, times the sign, are no more than some others."""
    return np.where(nodes, sign * np.minimum(sign * points, most), points)


def kept_at(plan: Plan, points: Any, corner: int, which: int) -> Any:
    """Return values at a corner of the squares (0), beside it along x (1), along y (2), and across the square (3)."""
    down, right = CORNERS[corner]
    steps = ((0, 0), (0, 1), (1, 0), (1, 1))[which]
    place = down ^ steps[0], right ^ steps[1]
    return plan.at_corner(points, CORNERS.index(place))
