"""StretchedModel: tensioned arms between the nodes of a lattice, over a rigid support."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.stencil import Stencil
from ..errors import UnsuitableProblemError
from ..foundation.checks import Vector, read_only, repeated
from ..geometry.between import Between
from ..geometry.fields import Rows
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from ..profiles.analytic import Profile
from .on_lattice import LatticeModel
from .reach import reach_on_lattice
from .rim import Rim
from .sensitive import FrameHeights, Resistance
from .tension import Tension
from .varied import with_load_of


class StretchedModel(LatticeModel):
    """Nodes on a lattice, joined to their neighbours by tensioned arms, over a support.

    Base of `Membrane` and `Cable`, which choose the stiffness of the arms and the load's unit.

    Attributes
    ----------
    stencil : Stencil
        The stiffness G; for the others see `LatticeModel`.
    """

    _takes_cuts = True
    _stiffness_of_tension: float = 1.0
    """Stiffness of an arm over its tension: of a membrane's the width that an arm stands for over its length."""

    def __init__(
        self,
        lattice: Lattice,
        tension: Tension,
        load: Any,
        support: Any,
        frame_height: Any,
        *,
        area: float,
        arms: tuple[Any, Any],
        upwards: bool = False,
        rows: Rows = "up",
        ceiling: Any = None,
        foundation: Any = None,
        units: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(
            *(lattice, tension, load, support, frame_height),
            area=area,
            upwards=upwards,
            rows=rows,
            ceiling=ceiling,
            foundation=foundation,
            units=units,
        )
        self._on_foundation = Stencil(lattice.mask, *arms, self._ground())
        self._rim = None if lattice.cuts is None else Rim.of(lattice, arms, self._end_heights)
        self.stencil = self._held_by_rim()
        self._warn()

    _made_from: Mapping[str, Any] = MappingProxyType({})
    """The arguments of the model, kept where some of them lie between two others."""

    def _keep_arguments(self, arguments: Mapping[str, Any]) -> None:
        """Keep what the model was made from, so that `extremes` can make others, where some of it lies between two."""
        tension = arguments["tension"]
        if isinstance(tension, Between):
            self.uncertain["tension"] = tension
        if self.uncertain:
            self._made_from = MappingProxyType(dict(arguments))

    def extremes(self) -> tuple[LatticeModel, LatticeModel]:
        """See `LatticeModel.extremes`."""
        if "foundation" in self.uncertain or ("tension" in self.uncertain and self.foundation is not None):
            raise UnsuitableProblemError(
                "a foundation pulls up what hangs down and down what is lifted: answers do not grow with its "
                "stiffness, or with an uncertain tension beside it, and no two of them enclose the others"
            )
        made = []
        for lowest in (True, False):
            chosen = dict(self._made_from)
            for name, field in self.uncertain.items():
                if name != "tension":
                    chosen[name] = field.lower if lowest != self._turned(name, field) else field.upper
            tension = self.uncertain.get("tension")
            if tension is None:
                made.append(type(self)(**chosen))
                continue
            # Depths depend on load over tension: the load of one tension stands for that of another.
            chosen["tension"] = tension.middle
            middle = type(self)(**chosen)
            factors = np.sort([tension.middle / tension.upper, tension.middle / tension.lower])
            share = np.where((middle.load >= 0) == lowest, factors[0], factors[1])
            made.append(with_load_of(middle, read_only(middle.load * share)))
        self._require_order(*made)
        return made[0], made[1]

    def _turned(self, name: str, field: Between) -> bool:
        """Whether what is lower is deeper: a height that is positive upwards, but of a profile, which tells depths."""
        return self.upwards and name != "load" and not isinstance(field.lower, Profile)

    def _require_order(self, low: StretchedModel, high: StretchedModel) -> None:
        pairs = {"load": (low.load, high.load), "support": (low.depth, high.depth)}
        if low.ceiling_depth is not None and high.ceiling_depth is not None:
            pairs["ceiling"] = low.ceiling_depth, high.ceiling_depth
        for name, (least, most) in pairs.items():
            if (least > most).any():
                worst = int(np.argmax(least > most))
                raise ValueError(
                    f"{name}=between(lower, upper): the lower one is above the upper one at {self.describe(worst)}"
                )

    def _held_by_rim(self) -> Stencil:
        """Return the stiffness with what arms that the contour cuts short are stiffer."""
        plain = self._on_foundation
        if self._rim is None or not self._rim.springs.any():
            return plain
        return plain.on_ground(plain.ground + self.lattice.scatter(self._rim.at_nodes(self.size), fill=0.0))

    def _ground(self) -> Any:
        """Return the stiffness of the foundation as a stencil takes it."""
        springs = self.nodal_foundation
        if springs is None or not springs.any():
            return 0.0
        return float(springs[0]) if repeated(springs) else self.lattice.scatter(springs, fill=0.0)

    def _take_tension(self, tension: float) -> None:
        factor = tension / self.tension if self._tension.constant else tension
        plain = self._on_foundation
        self._on_foundation = plain.scaled(factor).on_ground(plain.ground)
        self._rim = None if self._rim is None else self._rim.times(factor)
        self.stencil = self._held_by_rim()
        super()._take_tension(tension)

    def _take_foundation(self, foundation: Vector) -> None:
        self.foundation = foundation
        self._on_foundation = self._on_foundation.on_ground(self._ground())
        self.stencil = self._held_by_rim()

    def assemble_stiffness(self) -> Stencil:
        """Return the stencil."""
        return self.stencil

    def pull(self, depths: Vector) -> Vector:
        """Return the force with which the arms pull each node upwards; see `ContactModel.pull`."""
        force = self._on_foundation.pull(self._padded(depths))
        return force if self._rim is None else force + self._rim.pull(depths, self._heights)

    @property
    def arm_tensions(self) -> Mapping[str, Resistance]:
        """By ``arms_x``, shape (rows, columns + 1), and on a membrane ``arms_y``, shape (rows + 1, columns)."""
        names = ("arms_x", "arms_y")[: len(self._tension.fields)]
        return {name: self._tension_along(axis) for name, axis in zip(names, (1, 0), strict=False)}

    def _tension_along(self, axis: int) -> Resistance:
        """Return how the arms along an axis of the lattice's array pull."""
        rows, columns = self.lattice.shape
        numbering, factor = self.stencil.numbering, self._stiffness_of_tension
        inner = (slice(1, -1), slice(None)) if axis == 1 else (slice(None), slice(1, -1))

        def rises(grid: Grid) -> Grid:
            return np.asarray(np.diff(grid[inner], axis=axis))

        rim, heights = self._rim, self._heights

        def pull(depths: Vector, tensions: Grid) -> Vector:
            force = numbering.to_vector(-np.diff(factor * tensions * rises(self._padded(depths)), axis=axis))
            return force if rim is None else force + rim.pull_along(axis, depths, heights, factor * tensions)

        def share(depths: Vector, weights: Vector) -> Grid:
            found = factor * rises(self._padded(depths)) * rises(numbering.to_grid(weights, ring=1))
            if rim is not None:
                rim.add_share(axis, depths, heights, factor * weights, found)
            return found

        return Resistance((rows, columns + 1) if axis == 1 else (rows + 1, columns), pull, share)

    @property
    def heights_of_frame(self) -> FrameHeights:
        """By ``frame_heights``, shape (rows + 2, columns + 2): on the lattice's array with a ring about it."""
        stencil, rows, columns = self.stencil, *self.lattice.shape
        frame = self.frame_points()
        along_x = np.broadcast_to(stencil.horizontal, (rows, columns + 1))
        along_y = np.broadcast_to(stencil.vertical, (rows + 1, columns))

        rim = self._rim

        def force(depths: Grid) -> Vector:
            moved = -stencil.pull(np.where(frame, depths, 0.0))
            return moved if rim is None else moved + rim.force_of(depths, self.size)

        def share(weights: Vector) -> Grid:
            grid = stencil.numbering.to_grid(weights, ring=1)
            found = np.zeros(frame.shape)
            found[1:-1, 1:] += along_x * grid[1:-1, :-1]
            found[1:-1, :-1] += along_x * grid[1:-1, 1:]
            found[1:, 1:-1] += along_y * grid[:-1, 1:-1]
            found[:-1, 1:-1] += along_y * grid[1:, 1:-1]
            if rim is not None:
                np.add.at(found, (rim.row, rim.column), rim.springs * weights[rim.node])
            return np.where(frame, found, 0.0)

        return FrameHeights("frame_heights", frame / frame.sum(), force, share)

    def _frame_grid(self) -> Grid | None:
        if self._heights is None:
            return None
        return np.where(self.frame_points(), self._heights - self._datum, 0.0)

    def _reach(self) -> float:
        return self._reach_of(self._forces_at(self._datum + self._frame_relief()))

    def _reach_upwards(self) -> float:
        return self._reach_of(-self._forces_at(self._datum - self._frame_relief()))

    def _reach_of(self, force: Vector) -> float:
        return reach_on_lattice(self.lattice.shape, (self.stencil.horizontal, self.stencil.vertical), force)

    @property
    def stiffness_data(self) -> tuple[NDArray[Any], ...]:
        """Shape, mask and arms of the stencil; see `ContactModel.stiffness_data`."""
        stencil = self.stencil
        springs = (stencil.ground,) * stencil.grounded
        return np.array(stencil.mask.shape), stencil.mask, stencil.horizontal, stencil.vertical, *springs

    def _stiffness_told(self) -> Iterator[str]:
        yield f"tension={self._tension.told}"
