r"""Cables themselves: what is known of them between their nodes, and bounds of their heights at every node.

**Heights.** (Constant T, no foundation, no ceiling.) Between two nodes let W be the cubic through their heights with
-TW″ = Ip + a, where Ip is linear between the values of p at both, and a a number. At a node its slope jumps by the
force

.. math:: F_i = -T[W′] = (S_w - S_e)/h - h(p_{i-1} + 4p_i + p_{i+1})/6 - h(a_w + a_e)/2,

where S are the differences times T, to the west and to the east. The parabola v = x(L - x)/2T has -Tv″ = 1, and its
linear interpolant Iv the force h at each node.

*From above.* A function W that is not below the ends, with -TW″ ≥ p between the nodes and F_i ≥ 0 at those where
W_i < f_i, is no less than w*: on the set where w* > W the nodes have W_i < w_i* ≤ f_i, and w* is a subsolution, so that
w* - W is convex there, and it vanishes at the ends of the set. With a no less than p - Ip and any heights w_i,
W + τ⁺Iv has that if at each node τ⁺h ≥ -F_i, or τ⁺v_i ≥ f_i - w_i.

*From below.* A function W that is neither above the ends nor above f, with -TW″ ≤ p and F_i ≤ 0, is no more than w*,
which is the largest of these. With a no more than p - Ip, τ⁻h ≥ F_i at each node, and D ≥ 0 no less than W - f
anywhere, W - τ⁻Iv - D has that; W - f is on each stretch at most max(w - f) at its ends, h²/8T max(0, p), and
``below``.

On flat ground D is h²p/8T: a bound of second order, without another solve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..foundation.checks import Mask, Vector
from ..foundation.intervals import Interval
from ..foundation.rounding import UNDERFLOW
from ..foundation.surfaces import Curvature, Ranged
from ..geometry.fields import OnFrame, is_function, of_x_and_y
from ..models.cable import Cable
from ..profiles.analytic import Profile
from .cell_fields import CellField, array_field, function_field, number_field
from .data import Tensions
from .rounded import FEW, GROW
from .stiff_signs import require_not_negative


class _AlongX:
    """A function of (x, y) on the line y = 0, on which it bends along x alone."""

    def __init__(self, function: Any) -> None:
        self.function = function

    def range(self, x: Interval, y: Interval) -> Interval | None:
        """See `contactqp.foundation.surfaces.Ranged`."""
        return self.function.range(x, y) if isinstance(self.function, Ranged) else None

    def curvature(self, x: Interval, y: Interval) -> Curvature | None:
        """See `contactqp.foundation.surfaces.Ranged`."""
        known = self.function.curvature(x, y)
        none = Interval.of(np.zeros(x.lower.shape))
        return None if known is None else Curvature(known.xx, none, none)


@dataclass(frozen=True, eq=False)
class Line:
    """The stretches between a cable's nodes and ends, told as `contactqp.continuum.plan.Plan` tells squares.

    Attributes
    ----------
    cable : Cable
    """

    cable: Cable

    @property
    def spacing(self) -> float:
        """Length h of a stretch."""
        return self.cable.lattice.spacing

    @cached_property
    def nodes(self) -> Mask:
        """Which points are nodes: all but both ends."""
        nodes = np.ones(self.cable.size + 2, dtype=np.bool_)
        nodes[[0, -1]] = False
        return nodes

    @cached_property
    def squares(self) -> Mask:
        """All stretches belong to the cable."""
        return np.ones(self.cable.size + 1, dtype=np.bool_)

    @staticmethod
    def at_corner(points: Any, corner: int) -> Any:
        """Return what points have at the left (0, 3) or right (1, 2) end of each stretch."""
        return points[:-1] if corner in (0, 3) else points[1:]

    @cached_property
    def x(self) -> Vector:
        """Abscissae of the points (length)."""
        return np.asarray(self.cable.point_x)

    @cached_property
    def around_points(self) -> tuple[Interval, Interval]:
        """What holds x and y of each point."""
        x = Interval.around(self.x, 4 * np.spacing(np.abs(self.x).max()))
        return x, Interval.of(np.zeros(self.x.size))

    @cached_property
    def around_squares(self) -> tuple[Interval, Interval]:
        """What holds x and y on each stretch."""
        x, _ = self.around_points
        return Interval(x.lower[:-1], x.upper[1:]), Interval.of(np.zeros(self.x.size - 1))

    def field(self, name: str, nodal: Vector, turned: bool) -> CellField:
        """Return a field by its values at the nodes, ``turned`` if what was given is a height and the field a depth."""
        given = self.cable.given.get(name)
        if is_function(given):
            ends = np.broadcast_to(np.asarray(of_x_and_y(given)(self.x, 0 * self.x), dtype=np.float64), self.x.shape)
            sign = -1.0 if turned and not isinstance(given, Profile) else 1.0
            values = np.array(ends)
            values[1:-1] = sign * nodal
            field = function_field(self, _AlongX(given) if isinstance(given, Ranged) else given, values)
            return -field if sign < 0 else field
        if not isinstance(given, OnFrame) and (nodal == nodal[0]).all():
            return number_field(self, float(nodal[0]))
        return array_field(self, np.concatenate([nodal[:1], nodal, nodal[-1:]]), exact=name in self.cable.given)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Depths of both ends (length)."""
        heights = self.cable.padded_below(np.zeros(self.cable.size))[1]
        return float(heights[0]), float(heights[-1])

    @cached_property
    def load(self) -> CellField:
        """Active load p, positive downwards (force per length)."""
        return self.field("load", self.cable.load, False)

    @cached_property
    def foundation(self) -> CellField | None:
        """Stiffness k of the foundation (force per length and length); None without one.

        Raises
        ------
        ValueError
            If it is a function that is negative between the nodes.
        """
        stiffness, given = self.cable.foundation, self.cable.given.get("foundation")
        if stiffness is None or not (stiffness.any() or isinstance(given, Ranged)):
            return None
        if isinstance(given, Ranged):
            require_not_negative(_AlongX(given), self.around_squares, self.squares)
        return self.field("foundation", stiffness, False)

    @cached_property
    def surfaces(self) -> list[tuple[CellField, float]]:
        """What the cable must not cross, each with the sign by which depths count so that it is an upper bound."""
        support = self.field("support", self.cable.depth, self.cable.upwards)
        found = [(self._not_beyond_ends(support, 1.0, "support"), 1.0)]
        if self.cable.ceiling_depth is not None:
            ceiling = -self.field("ceiling", self.cable.ceiling_depth, self.cable.upwards)
            found.append((self._not_beyond_ends(ceiling, -1.0, "ceiling"), -1.0))
        return found

    def bends_of(self, surface: CellField, sign: float) -> tuple[Vector, Vector] | None:
        """Return bounds of the second derivative of one of the `surfaces` on each stretch, as it counts, if known."""
        given = self.cable.given.get("support" if sign > 0 else "ceiling")
        if surface.straight or not is_function(given):
            none = np.zeros(self.squares.shape)
            return none, none
        known = _AlongX(given).curvature(*self.around_squares) if isinstance(given, Ranged) else None
        if known is None:
            return None
        turned = (self.cable.upwards and not isinstance(given, Profile)) != (sign < 0)
        along = -known.xx if turned else known.xx
        return np.broadcast_to(along.lower, self.squares.shape), np.broadcast_to(along.upper, self.squares.shape)

    def _not_beyond_ends(self, surface: CellField, sign: float, name: str) -> CellField:
        """Refuse ends that a surface has no room for; an array, which tells nothing of them, is as deep there."""
        values = np.array(surface.values)
        for place, end in zip((0, -1), self.ends, strict=True):
            beyond = sign * end - values[place]
            if beyond > 0:
                if not isinstance(self.cable.given.get(name), OnFrame):
                    raise ValueError(
                        f"the end at x={self.x[place]:g} lies beyond the {name}, by {beyond:.3g}: no cable can be held "
                        f"there; the {name} must leave room for the ends"
                    )
                values[place] = sign * end
        return replace(surface, values=values)

    @cached_property
    def sampled(self) -> tuple[str, ...]:
        """Names of the data that are known at points alone."""
        parts = {"load": self.load, "foundation": self.foundation}
        parts |= {name: part for name, (part, _) in zip(("support", "ceiling"), self.surfaces, strict=False)}
        names = [name for name, part in parts.items() if part is not None and not part.exact]
        tension = self.cable.tension_of_arms
        told = isinstance(self._tension, CellField) and not self._tension.exact
        return (*names, *(["tension"] if told or not (tension.source or tension.constant) else []))

    @cached_property
    def arms(self) -> Vector:
        """Tension of each arm (force), shape (nodes + 1,)."""
        return np.broadcast_to(np.ravel(self.cable.tension_of_arms.fields[0].arms), self.squares.shape)

    @cached_property
    def _tension(self) -> CellField | Vector:
        field, source = self.cable.tension_of_arms.fields[0], self.cable.tension_of_arms.source
        if source and is_function(source[0]):
            values = np.broadcast_to(np.asarray(source[0](self.x, 0 * self.x), dtype=np.float64), self.x.shape)
            return function_field(self, _AlongX(source[0]) if isinstance(source[0], Ranged) else source[0], values)
        nodes = np.broadcast_to(field.nodes, (self.cable.size,))
        return np.concatenate([nodes[:1], nodes, nodes[-1:]])

    @property
    def even_tension(self) -> bool:
        """Whether the tension is one number everywhere, not at the nodes and in the middles of arms alone."""
        known = not isinstance(self._tension, CellField) or self._tension.straight
        return self.cable.tension_of_arms.constant and known

    def tensions(self, side: int) -> Tensions:
        """Return the tension in the halves of the stretches next to their left (0) or right (1) ends."""
        kept = self._tension
        if not isinstance(kept, CellField):
            return Tensions(self.at_corner(kept, side), 0.0, 0.0)
        own, far = self.at_corner(kept.values, side), self.at_corner(kept.values, 1 - side)
        rounding = 1e-15 * np.abs(own)
        return Tensions((3 * own + far) / 4, np.abs(far - own) / 4 + kept.apart + rounding, kept.apart + rounding)


def cable_heights(line: Line, depths: Vector) -> tuple[Vector, Vector] | None:
    """Return lower and upper bounds of the depths of the cable itself at its nodes (length), shape (n,) each.

    None for a cable whose tension varies, on a foundation, or under a ceiling.

    Parameters
    ----------
    line : Line
    depths : array, shape (n,)
        Of the nodes, positive downwards (length).
    """
    if not line.even_tension or line.foundation is not None or len(line.surfaces) > 1:
        return None
    own, h, tension = np.concatenate([line.ends[:1], depths, line.ends[1:]]), line.spacing, float(line.arms[0])
    load, support = line.load, line.surfaces[0][0]
    flux, p, size = tension * np.diff(own), load.values, np.abs(load.values)
    force = (flux[:-1] - flux[1:]) / h**2 - (p[:-2] + 4 * p[1:-1] + p[2:]) / 6  # over h
    rounding = FEW * ((np.abs(flux[:-1]) + np.abs(flux[1:])) / h**2 + size[:-2] + size[1:-1] + size[2:]) + UNDERFLOW
    number = np.arange(1, own.size - 1)
    barrier = h**2 * number * (own.size - 1 - number) / (2 * tension)
    gap = support.values[1:-1] - own[1:-1]
    off = np.maximum(support.rounding[1:], support.rounding[:-1]) + FEW * np.abs(own[1:-1])
    raised = rounding - force + (load.above[1:] + load.above[:-1]) / 2 * GROW
    touching = np.where(np.isfinite(gap), np.maximum(gap + off, 0.0) / barrier, np.inf)
    above = max(0.0, float(np.minimum(raised, touching * GROW).max()))
    below = max(0.0, float((rounding + force + (load.below[1:] + load.below[:-1]) / 2 * GROW).max()))
    steep = ~np.isfinite(support.below) | ~np.isfinite(support.values[1:] + support.values[:-1])
    bulge = h**2 / (8 * tension) * np.maximum(np.maximum(p[1:], p[:-1]), 0.0) * GROW
    with np.errstate(invalid="ignore"):
        crossing = np.maximum(own[1:] - support.values[1:], own[:-1] - support.values[:-1]) + support.below
        rim = np.maximum(own[1:], own[:-1]) - support.range_lower
    over = np.where(steep, rim, crossing) + bulge + FEW * np.maximum(np.abs(own[1:]), np.abs(own[:-1]))
    drop = max(0.0, float(over.max()))
    room = FEW * (np.abs(own[1:-1]) + drop)
    lower = own[1:-1] - below * barrier * GROW - drop - room
    upper = own[1:-1] + above * barrier * GROW + room
    return lower, np.minimum(upper, support.values[1:-1] + off)
