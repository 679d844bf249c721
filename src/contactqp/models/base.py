"""What models of contact have in common: nodes held by tension over a support, posed as a `ContactQP`."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ContactWarning
from ..foundation.cards import card
from ..foundation.checks import Mask, Vector, read_only, repeated, times, vector
from ..foundation.loading import load_modules
from ..foundation.outside import stacklevel_outside
from ..foundation.pictures import UnitNames, Wanted, drawn, drawn_in_space
from ..foundation.text import counted, span_of
from ..foundation.units import plain
from ..geometry.fields import Rows, in_rows, sample_points
from ..geometry.labelled import is_dataarray
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from ..problem.barrier import Barrier
from ..problem.contact_problem import ContactProblem
from ..problem.contact_qp import ContactQP
from ..profiles.analytic import Profile
from .sensitive import FrameHeights, Resistance
from .suspicions import Heights, Joints, suspicions_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class ForceBalance:
    """Resultants on the nodes, all vertical (force).

    Attributes
    ----------
    load : float
        ΣP, downwards.
    reaction : float
        ΣR over the nodes that the ceiling does not hold, upwards: of the support.
    frame : float
        Pull of the frame through the arms that end on it, upwards.
    ceiling : float
        -ΣR over the nodes that the ceiling holds, downwards: how it pushes.
    foundation : float
        Σkw times the area, upwards, of an elastic foundation.
    """

    load: float
    reaction: float
    frame: float
    ceiling: float = 0.0
    foundation: float = 0.0

    @property
    def imbalance(self) -> float:
        """ΣP + ceiling - ΣR - frame - foundation: zero but for rounding."""
        return self.load + self.ceiling - self.reaction - self.frame - self.foundation


_LEAST_DEPTH = 1e-6
"""The gap scale is at least this part of the unsupported deflection: a shallower support counts as flat."""

_BEYOND = 1e4
"""A support that lies so many times as deep as the load can press any node counts as none: its depth costs digits."""


_LENGTHS = "frame_height", "fixed_height", "spacing", "span", "start", "positions", "initial"
_QUANTITIES = dict.fromkeys(_LENGTHS, "length")
"""What arguments that are no fields of a model's `units` must be."""


class Coordinate(NamedTuple):
    """What a dataset's axis, or each node on it, is labelled by.

    Attributes
    ----------
    dimension : str or tuple of str
        The axis, or several.
    values : array
        One for each place on the axis.
    attributes : dict
        Unit or meaning of the values.
    """

    dimension: str | tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any]


class ContactModel(ABC):
    r"""Nodes that tensioned arms join to each other and to a frame, over a rigid support.

    Base of all models. A subclass says where its nodes are, what loads them, what lies below them, and with which force
    its arms resist a shape; everything else follows. With n nodes,

    .. math:: q = P - \mathrm{pull}(f), \qquad R = G \omega + q, \qquad w = f - \omega.

    **A subclass must set**, in its ``__init__``, the attributes `load` and `support`, by
    ``self.at_nodes(load, "load")`` and ``self.support_at_nodes(support)``, which take numbers, arrays and functions and
    check them; `ceiling` after the support, by ``self.ceiling_at_nodes(ceiling)``, and `foundation`, by
    ``self.foundation_at_nodes(foundation)``, if it has them; if it has heights that are positive upwards, `upwards`
    before that; at the end it calls
    ``self._warn()``, so that data which are
    probably not what was meant are told of. It must not change afterwards: what is derived from it is kept.

    **It must define**

    * `node_x`, `node_y`: places in plan, shape (n,), length;
    * `pull(depths)`: the force with which the arms pull each node upwards at given depths, shape (n,), force; it is
      ``G @ depths`` less what a frame at another height than zero takes over, formed from differences of depths; with
      the force of a foundation, if there is one;
    * `assemble_stiffness()`: G, shape (n, n), force per length: a sparse or dense symmetric positive definite matrix,
      or a `Stiffness`;
    * `max_slope(gap)` and `free_boundary(contact)`: the largest slope of an arm (no unit), for a caution, and middles
      of arms, shape (k, 2), length, for distances of contact sets.

    **It may set or override**, where the default does not say the truth

    * `node_area`: the area that each node stands for, shape (n,), or None. With it, `load` is a force per area;
      without it a force, and there is no ``contact_pressure``;
    * `nodal_load`: P, force, by default `load` times `node_area`;
    * `units`: in words, by the names gap, deflection, support, reaction, load and, with a `node_area`,
      contact_pressure;
    * `parameters`: numbers that hold for the whole model, by name, for its ``repr``, its card and its datasets;
    * `at_nodes` and `describe`: what fields may be given as, and what messages call a node;
    * `extent`, `coordinates` and `laid_out`: the size of its pictures, and its axes in a dataset;
    * ``_datum`` and `_frame_relief()`, where the frame is not at height zero: its mean depth, and how far it leaves
      that at most, length;
    * `arm_tensions` and `heights_of_frame`, so that answers are differentiated by the tension of each arm and by the
      height of each point of the frame;
    * `_take_tension(tension)`, so that `trace` can vary its tension; `_reach()` and `_reach_upwards()`, so that a
      support, or a ceiling, which is out of reach counts as none; `_joints()`, so that a support above the frame
      is told of.

    Names with an underscore are for subclasses alone; nothing else calls them. CONTRIBUTING.md has a whole example.

    Attributes
    ----------
    load : array, shape (n,)
        Active load at the nodes, positive downwards, in the unit that `units` tells.
    support : array, shape (n,)
        Height of the rigid profile at the nodes (length), positive downwards, unless ``upwards``; infinite where there
        is none.
    upwards : bool
        Whether heights are positive upwards, those that go in (support, frame) and those that come out (deflection);
        a load is positive downwards and a lift upwards in either case. What `pull` gets is a depth in either case.
    ceiling : array, shape (n,), or None
        Height of a rigid surface above the nodes (length), positive as that of the support; infinite where there is
        none. None if there is none anywhere.
    foundation : array, shape (n,), or None
        Stiffness k >= 0 of an elastic foundation (Winkler), which pulls each node to height zero by k times its
        deflection: force per area and length where there is a `node_area`, else force per length. None without one.
    node_area : array, shape (n,), or None
        Area (cable: length) that each node stands for; None if nodes stand for none.
    unit_names : mapping of str to str
        Units of ``"length"`` and ``"force"`` in symbols, as far as they have been told: what is given with a unit is
        checked and converted to them, and files tell them.
    """

    load: Vector
    support: Vector
    upwards: bool = False
    node_area: Vector | None = None
    ceiling: Vector | None = None
    foundation: Vector | None = None
    unit_names: Mapping[str, str] = MappingProxyType({})
    _datum: float = 0.0
    """Mean depth of the frame (length, positive downwards)."""
    _known_unreachable: Mask | None = None
    """Supports that the model which this one varies counts as none because they are out of reach."""
    _of_profile: bool = False
    """Whether a height was given as a profile, which returns depths whichever way heights are positive."""
    _laid_on: Lattice | None = None
    """The lattice that the nodes are those of, if there is one."""
    _relative: ContactQP | None = None
    """A problem of other forces that this one can share all else with."""
    _shared_pull: Vector | None = None
    """What `_pull_of_reference` returns, kept where models of other loads have the same."""
    _alike: ContactQP | None = None
    """A problem of the same stiffness, of which the facts can be shared."""
    given: Mapping[str, Any] = MappingProxyType({})
    """What the model was made from, by name and without units, of data that are fields; see `LatticeModel`."""

    @property
    @abstractmethod
    def node_x(self) -> Vector:
        """Abscissa of each node, shape (n,), length."""

    @property
    @abstractmethod
    def node_y(self) -> Vector:
        """Ordinate of each node in plan, shape (n,), length; zeros for nodes along x."""

    @abstractmethod
    def pull(self, depths: Vector) -> Vector:
        """Return the force with which the arms pull each node upwards (force), shape (n,), the frame being as it is.

        It must be formed from differences of depths, so that a common depth costs no digits.

        Parameters
        ----------
        depths : array, shape (n,)
            Of the nodes (length), positive downwards whatever ``upwards`` is, finite.
        """

    @abstractmethod
    def assemble_stiffness(self) -> Any:
        """Return the stiffness G (force per length) as a `ContactQP` takes it: by what `pull` grows with the depths."""

    @abstractmethod
    def max_slope(self, gap: Vector) -> float:
        """Return the largest difference quotient of the deflection along any arm (no unit)."""

    @abstractmethod
    def free_boundary(self, contact: Mask) -> NDArray[np.float64]:
        """Return the middles of the arms that join a node in contact to one that is not, shape (k, 2), length."""

    @property
    def arm_tensions(self) -> Mapping[str, Resistance]:
        """The tension of each arm as a parameter that answers are differentiated by, by name; none by default."""
        return {}

    @property
    def resistances(self) -> Mapping[str, Resistance]:
        """All that holds the nodes and that answers are differentiated by, by name; by default `arm_tensions`."""
        return self.arm_tensions

    @property
    def heights_of_frame(self) -> FrameHeights | None:
        """The height of each point of the frame as a parameter that answers are differentiated by; None by default."""
        return None

    @property
    def nodal_load(self) -> Vector:
        """Active force P on each node (force), positive downwards, shape (n,): the load times `node_area`, if any."""
        return self.load if self.node_area is None else times(self.load, self.node_area)

    def at_nodes(self, field: Any, name: str, *, allow_inf: bool = False, absent: float | None = None) -> Vector:
        """Return the values at the nodes of a field that is given as when the model was made, shape (n,), read-only.

        Parameters
        ----------
        field : number, array or function of (x, y)
            An array has an entry for each node; on a lattice it may also have the lattice's shape, or be an
            xarray.DataArray.
        name : str
            The argument's name, for messages.
        allow_inf : bool
            Whether an infinite value stands for a support that is not there.
        absent : float, optional
            That value: by default the one of a support, inf, or -inf where heights are positive upwards.

        Raises
        ------
        TypeError, ValueError
            If the values have the wrong kind or shape or are not finite.
        """
        field = self.without_unit(field, name)
        places = np.column_stack([self.node_x, self.node_y])
        absent = self._no_support if absent is None else absent
        chosen = np.arange(len(places))
        values = sample_points(places, chosen, field, name, self.describe, allow_inf=allow_inf, absent=absent)
        return read_only(np.array(values))

    def without_unit(self, value: Any, name: str) -> Any:
        """Return a value that may have a unit in the model's own, see `contactqp.foundation.units.plain`."""
        return plain(value, name, self.units.get(name) or _QUANTITIES.get(name, "1"), self.unit_names)

    def in_own_rows(self, field: Any, name: str, rows: Rows | None) -> Any:
        """Return a field as `at_nodes` takes it, where an array has been said to have its rows ``"up"`` or ``"down"``.

        Raises
        ------
        ValueError
            If rows are to be said and are not, see `contactqp.geometry.fields.in_rows`.
        """
        return in_rows(field, name, rows, "up")

    def support_at_nodes(self, support: Any) -> Vector:
        """Return the heights of a support at the nodes, given as when the model was made, shape (n,), read-only.

        A `Profile` returns depths; where heights are positive upwards it is turned over.

        Raises
        ------
        TypeError, ValueError
            See `at_nodes`.
        """
        return self.at_nodes(self._in_own_sense(support), "support", allow_inf=True)

    def ceiling_at_nodes(self, ceiling: Any) -> Vector | None:
        """Return the heights of a ceiling at the nodes, as `support_at_nodes` does; None for None.

        Raises
        ------
        TypeError, ValueError
            See `at_nodes`; or if it lies below the support anywhere.
        """
        if ceiling is None:
            return None
        heights = self.at_nodes(self._in_own_sense(ceiling), "ceiling", allow_inf=True, absent=-self._no_support)
        self._refuse_crossing(self.support, heights)
        return heights

    def foundation_at_nodes(self, foundation: Any) -> Vector | None:
        """Return the stiffness of a foundation at the nodes, given as a load is, shape (n,), read-only; None for None.

        Raises
        ------
        TypeError, ValueError
            See `at_nodes`; or if it is negative anywhere.
        """
        if foundation is None:
            return None
        stiffness = self.at_nodes(foundation, "foundation")
        if stiffness.min() < 0:
            worst = int(np.argmin(stiffness))
            raise ValueError(f"foundation must be >= 0, but is {stiffness[worst]:g} at {self.describe(worst)}")
        return stiffness

    @property
    def _no_support(self) -> float:
        """The height that stands for a support that is not there."""
        return -np.inf if self.upwards else np.inf

    def _refuse_crossing(self, support: Vector, ceiling: Vector | None) -> None:
        """Raise a ValueError if a ceiling lies below a support anywhere."""
        if ceiling is None:
            return
        crossing = support > ceiling if self.upwards else ceiling > support
        if crossing.any():
            worst = int(np.argmax(np.where(crossing, np.abs(ceiling - support), 0.0)))
            raise ValueError(
                f"ceiling must not lie below the support, but at {self.describe(worst)} the ceiling is at "
                f"{ceiling[worst]:g} and the support at {support[worst]:g} ({int(crossing.sum())} such nodes); heights "
                f"are {self.sense}"
            )

    def _in_own_sense(self, height: Any) -> Any:
        """Return a height as it was given, a profile's with the sign that this model's heights have."""
        self._of_profile |= isinstance(height, Profile)
        return elevations_of(height) if self.upwards else height

    def describe(self, node: int) -> str:
        """Name a node by its number and coordinates, for messages: ``node 3 (x=0.5, y=1)``."""
        return f"node {node} (x={self.node_x[node]:g}, y={self.node_y[node]:g})"

    @property
    def units(self) -> dict[str, str]:
        """Units of the model's quantities in words, by name."""
        lengths = dict.fromkeys(("gap", "deflection", "support", "ceiling"), "length")
        if self.node_area is None:
            return {**lengths, "reaction": "force", "load": "force", "foundation": "force per length"}
        pressures = dict.fromkeys(("load", "contact_pressure"), "force per area")
        return {**lengths, "reaction": "force", **pressures, "foundation": "force per area and length"}

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height in plan of what a picture of the model shows (length)."""
        return float(np.ptp(self.node_x)), float(np.ptp(self.node_y))

    @property
    def parameters(self) -> dict[str, float]:
        """Numbers that hold for the whole model, by name, as a dataset states them."""
        return {}

    @property
    def fields(self) -> dict[str, tuple[Vector, str, str]]:
        """Further data of the model at its nodes, shape (n,), with units in words and meanings, by name."""
        found = {}
        if self.ceiling is not None:
            found["ceiling"] = (self.ceiling, self.units["ceiling"], f"height of the ceiling, {self.sense}")
        if self.foundation is not None:
            told = "stiffness of the elastic foundation, which pulls to height zero"
            found["foundation"] = (self.foundation, self.units["foundation"], told)
        return found

    def fields_of_answer(self, gap: Vector) -> dict[str, tuple[Vector, str, str]]:
        """Return what follows from a gap at the nodes beside deflection and forces, as `fields` does.

        Parameters
        ----------
        gap : array, shape (n,)
            Length.
        """
        return {}

    @property
    def crs(self) -> str:
        """Coordinate reference system of x and y, as ``"EPSG:25832"``; ``""`` if none is known."""
        return "" if self._laid_on is None else self._laid_on.crs

    def contact_patches(self, contact: Mask) -> tuple[NDArray[np.int64], int]:
        """Return to which patch of nodes in contact, joined by arms, each node belongs, and how many there are.

        Parameters
        ----------
        contact : array of bool, shape (n,)

        Returns
        -------
        patch : array of int, shape (n,)
            From 1 on, in the order of their first nodes; 0 where there is no contact.
        count : int
        """
        load_modules("scipy.sparse.csgraph")
        from scipy.sparse import csgraph

        nodes, patch = np.flatnonzero(contact), np.zeros(self.size, dtype=np.int64)
        if not nodes.size:
            return patch, 0
        count, labels = csgraph.connected_components(self._joined()[nodes][:, nodes], directed=False)
        _, first, found = np.unique(labels, return_index=True, return_inverse=True)
        patch[nodes] = np.argsort(np.argsort(first))[found] + 1
        return patch, int(count)

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """Coordinates of what `laid_out` returns, by name."""
        length = {"units": "length"}
        places = {"x": self.node_x, "y": self.node_y}
        return {name: Coordinate("node", np.array(place), length) for name, place in places.items()}

    def laid_out(self, values: Vector | Mask) -> tuple[tuple[str, ...], NDArray[Any]]:
        """Return the dimensions of the nodes' values in a dataset, and the values laid out along them, a new array.

        Parameters
        ----------
        values : array, shape (n,)
        """
        return ("node",), np.array(values)

    @property
    def laid_out_on(self) -> dict[str, str]:
        """Attributes of each variable of a dataset that say what it is laid out on."""
        return {}

    @property
    def stiffness_data(self) -> tuple[NDArray[Any], ...]:
        """Arrays that the stiffness consists of: two models whose arrays are equal have the same one."""
        matrix = self.problem.G
        return matrix.data, matrix.indices, matrix.indptr

    def pull_per_tension(self, depths: Vector, pull_of_arms: Vector) -> Vector:
        """Return how `pull` grows with a tension that is one number, ``self.tension`` (no unit), shape (n,).

        Parameters
        ----------
        depths : array, shape (n,)
            Of the nodes (length), positive downwards.
        pull_of_arms : array, shape (n,)
            ``pull(depths)`` without the force of the foundation (force).
        """
        return np.asarray(pull_of_arms / self.tension)  # type: ignore[attr-defined]

    def _take_tension(self, tension: float) -> None:
        """Change a copy of the model to another tension, > 0, before anything is derived from it."""
        raise TypeError(
            f"a tension can be given to a Membrane or a Cable only, not to {self!r}; make another model of its kind"
        )

    def _take_foundation(self, foundation: Vector) -> None:
        """Change a copy of the model to a foundation of another stiffness, shape (n,), before anything is derived.

        By default `pull` and `assemble_stiffness` ask the attribute `foundation` themselves.
        """
        self.foundation = foundation

    def _frame_relief(self) -> float:
        """Return how far the frame leaves its mean height at most (length)."""
        return 0.0

    def _joined(self) -> Any:
        """Return a sparse matrix, shape (n, n), with an entry where two nodes count as side by side."""
        return self.problem.G

    def _reach(self) -> float:
        """Return a proven bound of how far the load alone presses any node below the frame's lowest point (length)."""
        return np.inf

    def _reach_upwards(self) -> float:
        """Return a proven bound of how far the load alone lifts any node above the frame's highest point (length)."""
        return np.inf

    def _joints(self) -> Joints | None:
        """Return the support at the places where nodes are joined to the frame, None where the model does not tell."""
        return None

    def _frame_grid(self) -> Grid | None:
        """Return the frame's ordinates from its mean height for a stencil, or None if they are zero."""
        return None

    def area_of_node(self, attribute: str) -> Vector:
        """Return `node_area` for an attribute that needs it; an AttributeError names that where there is none."""
        if self.node_area is None:
            raise AttributeError(
                f"{attribute} needs a Membrane or a Cable; the nodes of {self!r} stand for no area, "
                "so there is the reaction only"
            )
        return self.node_area

    @property
    def size(self) -> int:
        """Number of nodes n."""
        return self.support.size

    @cached_property
    def depth(self) -> Vector:
        """Ordinate of the support at the nodes (length), positive downwards whatever ``upwards`` is, shape (n,)."""
        return times(self.support, -1.0) if self.upwards else self.support

    @cached_property
    def ceiling_depth(self) -> Vector | None:
        """Ordinate of the ceiling at the nodes (length), positive downwards whatever ``upwards`` is, shape (n,)."""
        if self.ceiling is None:
            return None
        return times(self.ceiling, -1.0) if self.upwards else self.ceiling

    @cached_property
    def under_ceiling(self) -> Mask:
        """Where there is a ceiling that is not out of reach, shape (n,), read-only.

        Out of reach is one ten thousand times as high as the load can move any node: see `unreachable`.
        """
        if self.ceiling_depth is None:
            return np.broadcast_to(np.False_, (self.size,))
        above = self._datum - self.ceiling_depth
        there = np.isfinite(above)
        reach = self._reach_upwards() + self._frame_relief() + max(0.0, self._datum - float(self.depth.min()))
        scale = reach + self._reach() + max(0.0, -float(above.min()))
        return read_only(there & ~(above > _BEYOND * scale) if 0 < scale < np.inf else there)

    @property
    def upper(self) -> Vector | float:
        """Upper bound of the gaps (length), shape (n,): the way from support to ceiling; the number inf without one.

        Where there is no support, the gap is counted from the frame's mean height, and so is the ceiling.
        """
        if self.ceiling_depth is None or not self.under_ceiling.any():
            return np.inf
        return np.where(self.under_ceiling, self.reference - self.ceiling_depth, np.inf)

    @cached_property
    def nodal_foundation(self) -> Vector | None:
        """Stiffness of the foundation at each node (force per length), shape (n,): `foundation` times `node_area`."""
        if self.foundation is None or self.node_area is None:
            return self.foundation
        return times(self.foundation, self.node_area)

    def _forces_at(self, depth: float) -> Vector:
        """Return the load on the nodes less what the foundation pulls back at a depth (force), shape (n,)."""
        if self.nodal_foundation is None or not depth:
            return self.nodal_load
        return self.nodal_load - self.nodal_foundation * depth

    @cached_property
    def supported(self) -> Mask:
        """Where there is a support that is not `unreachable`, shape (n,)."""
        there = np.isfinite(self.depth)
        if there.all() and not self.unreachable.any():
            return np.broadcast_to(np.True_, (self.size,))
        return read_only(there & ~self.unreachable)

    @cached_property
    def unreachable(self) -> Mask:
        """Where a support is so deep that it provably cannot be touched, and counts as none, shape (n,), read-only.

        That is ten thousand times as deep as the load alone can press any node, such as 1e30 in place of infinity. The
        deflection is the same, and has all its digits; the gap is counted from the frame's mean height there, as
        without a support (see `clearance`).
        """
        known = self._known_unreachable
        if known is not None and not known.any():
            return known
        below = self.depth[:1] if repeated(self.depth) else self.depth
        below = below - self._datum if self._datum else below
        reach = self._reach() + self._frame_relief()
        if self.ceiling_depth is not None:
            # A ceiling that lies below the frame presses the nodes down to it.
            reach += max(0.0, float(self.ceiling_depth.max()) - self._datum)
        if known is not None:
            # Twice, because the stiffness is rounded, and the reach is that of the exact one.
            return read_only(known & (below > 2 * reach))
        scale = reach + max(0.0, -float(below.min()))
        deep = below > (_BEYOND * scale if 0 < scale < np.inf else np.inf)
        deep = deep & np.isfinite(below) if deep.any() else deep
        return np.broadcast_to(deep if deep.any() else np.False_, (self.size,))

    @property
    def sense(self) -> str:
        """Which way heights are positive, in words."""
        return "positive upwards" if self.upwards else "positive downwards"

    @property
    def cautions(self) -> tuple[str, ...]:
        """How much wider than the frame the lattice is, and what the data probably do not mean, one sentence each."""
        laid_on = self._laid_on
        return (*([laid_on.caution] if laid_on is not None and laid_on.caution else []), *self._suspicions())

    def _suspicions(self) -> Iterator[str]:
        frame = self._datum - self._frame_relief(), self._datum + self._frame_relief()
        return suspicions_of(
            Heights(
                depth=self.depth,
                frame=frame,
                load=self.nodal_load,
                ceiling=bool(self.under_ceiling.any()),
                upwards=self.upwards,
                of_profile=self._of_profile,
                joints=self._joints,
                describe=self.describe,
            )
        )

    def _warn(self) -> None:
        """Warn of what is strange about the data, where the code outside this package has made the model."""
        for suspicion in self._suspicions():
            warnings.warn(suspicion, ContactWarning, stacklevel=stacklevel_outside())

    @property
    def notes(self) -> tuple[str, ...]:
        """What was made of the data, one sentence each."""
        told = []
        count = int(np.count_nonzero(self.unreachable))
        if count:
            nearest = float(np.abs(self.support[self.unreachable]).min())
            told.append(
                f"the support at {counted(count, 'node')}, {nearest:g} deep or deeper, is out of reach and counts as "
                "none"
            )
        if self.ceiling is not None:
            out = np.isfinite(self.ceiling) & ~self.under_ceiling
            if out.any():
                nearest = float(np.abs(self.ceiling[out]).min())
                told.append(
                    f"the ceiling at {counted(int(np.count_nonzero(out)), 'node')}, {nearest:g} high or higher, is out "
                    "of reach and counts as none"
                )
        return tuple(told)

    @property
    def reference(self) -> Vector:
        """Depths that the gap is measured from: the support, and the frame's mean depth where there is none."""
        return self.depth if self.supported.all() else np.where(self.supported, self.depth, self._datum)

    @property
    def height_scale(self) -> float:
        """Largest modulus of the ordinates that the gap and the frame are measured from (length)."""
        return float(np.abs(self.reference).max()) + abs(self._datum) + self._frame_relief()

    @cached_property
    def problem(self) -> ContactQP:
        """The contact problem: q = P + b - G f, with b the pull of a frame that is not at height zero.

        G holds the foundation as well.
        """
        q = read_only(self.nodal_load - self._pull_of_reference())
        reference = self.reference - self._datum if self._datum else self.reference
        if self._relative is not None:
            return self._relative.with_forces(q, gap_scale=self._gap_scale, reference=reference)
        problem = ContactQP(
            self.assemble_stiffness(),
            q,
            lower=0.0 if self.supported.all() else np.where(self.supported, 0.0, -np.inf),
            upper=self.upper,
            gap_scale=self._gap_scale,
            reference=reference,
            frame_reference=self._frame_grid(),
        )
        if self._alike is not None:
            problem.share_facts(self._alike)
        return problem

    def _pull_of_reference(self) -> Vector:
        """Return the force with which the arms resist the shape of the reference (force), shape (n,)."""
        return self.pull(self.reference) if self._shared_pull is None else self._shared_pull

    def _gap_scale(self, barrier: Barrier | None) -> float | None:
        """Return the length by which tolerances are measured, or None if the model has no length of its own.

        An error of the gap is one of the deflection w, so its scale is that of w. Above, w is bounded by the support
        and by the deflection without one; below, by that under suction alone and by the highest summit: of these
        bounds the mean is taken, ordinates being measured from the frame's mean height. The unsupported deflection is
        bounded by the barrier. A ceiling bounds w in the same ways from the other side.
        """
        if barrier is None:
            return None
        v, load = barrier.v, self._forces_at(self._datum)
        lifted = load.min() < 0
        mean = float(barrier.mean_deflection(np.maximum(load, 0.0) if lifted else load, v))
        suction = float(barrier.mean_deflection(np.maximum(-load, 0.0), v)) if lifted else 0.0
        return self._scale_of(mean, suction, v)

    def _scale_of(self, mean: float, suction: float, v: Vector) -> float | None:
        """Return what `_gap_scale` does, given how far load and suction move the nodes in the mean without bounds.

        Parameters
        ----------
        mean, suction : float
            Mean deflections downwards and upwards (length), >= 0.
        v : array, shape (n,)
            What they are distributed as, > 0.
        """
        above = None
        if self.ceiling_depth is not None and self.under_ceiling.any():
            above = self._datum - self.ceiling_depth
        return length_scale(mean, suction, v, self.depth - self._datum, above, self._frame_relief())

    def plot(
        self, ax: Any = None, *, section: float | None = None, title: str | None = None, units: UnitNames = ""
    ) -> Figure:
        """Draw the model before it is solved: frame, support and load, with their directions.

        Ordinates are drawn positive downwards, and arrows show where the load points. A membrane's map shows which way
        the rows of arrays are counted, and where there is no support. The figure shows itself in a notebook; elsewhere
        use ``figure.savefig``.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own to draw into; by default there is a new figure.
        section : float, optional
            Ordinate y of the section (length); the nearest row is drawn. By default the middle one.
        title : str, optional
            Headline in place of the picture's own.
        units : str or mapping, optional
            Unit of length for labels, as ``"m"``, or ``{"length": "m", "force": "kN"}``.

        Returns
        -------
        matplotlib.figure.Figure
        """
        figure: Figure = drawn(self, Wanted(ax, section, title, units))
        return figure

    def plot3d(self, ax: Any = None, *, title: str | None = None, units: UnitNames = "") -> Figure:
        """Draw a membrane's frame and support in space, see `plot`; ``ax`` must be axes in space.

        Raises
        ------
        TypeError
            If the model is no membrane.
        """
        figure: Figure = drawn_in_space(self, Wanted(ax, None, title, units))
        return figure

    def __repr__(self) -> str:
        parameters = [f"{name}={value:g}" for name, value in self.parameters.items()]
        return self._line_of_text(counted(self.size, "node"), *parameters)

    @property
    def _fit(self) -> str:
        """How far the frame lies outside its contour, in a few words; empty where it does not."""
        return "" if self._laid_on is None else self._laid_on.fit

    def _line_of_text(self, *facts: str) -> str:
        """Return the class with some facts, and what is to be said of any model: load, support and its absence."""
        unsupported = int(np.count_nonzero(~self.supported))
        facts = (*facts, f"load={span_of(self.load)}", f"support={span_of(self.support)}")
        for name, values in (("ceiling", self.ceiling), ("foundation", self.foundation)):
            if values is not None:
                facts = (*facts, f"{name}={span_of(values)}")
        more = [f"{unsupported} unsupported"] * bool(unsupported) + ["heights upwards"] * self.upwards
        more += [f"frame {self._fit}"] * bool(self._fit)
        return f"{type(self).__name__}({', '.join([*facts, *more])})"

    def _repr_html_(self) -> str:
        units = self.units
        parameters = {name: f"{value:g}" for name, value in self.parameters.items()}
        unsupported = int(np.count_nonzero(~self.supported))
        support = f"{span_of(self.support)} ({units['support']}, {self.sense})"
        ceiling, foundation = self.ceiling, self.foundation
        facts = {
            "nodes": str(self.size),
            "in plan": " x ".join(f"{side:g}" for side in self.extent),
            **parameters,
            "load": f"{span_of(self.load)} ({units['load']}, positive downwards)",
            "support": support if unsupported < self.size else "none",
            "unsupported": counted(unsupported, "node") if unsupported else "",
            "ceiling": "" if ceiling is None else f"{span_of(ceiling)} ({units['support']}, {self.sense})",
            "foundation": "" if foundation is None else f"{span_of(foundation)} ({units['foundation']})",
            "frame": self._fit,
        }
        return card(type(self).__name__, facts)

    def deflection(self, gap: Vector) -> Vector:
        """Return the nodes' heights under the load (length), positive downwards, unless ``upwards``.

        w = f - ω; without a support the frame's mean height stands for f.
        """
        below = self._below(gap)
        return np.negative(below, out=below) if self.upwards else below

    def _below(self, gap: Vector) -> Vector:
        """Return w = f - ω (length), positive downwards."""
        return np.asarray(self.reference - gap)

    def clearance(self, gap: Vector) -> Vector:
        """Return how far the nodes are above the support as it was given (length), infinite where there is none.

        It is the gap, but where a support is `unreachable`.
        """
        return np.where(self.supported, gap, gap + (self.depth - self._datum))

    def lowest(self, heights: Vector) -> float:
        """Return the lowest of some heights: the largest where they are positive downwards."""
        return float(heights.min() if self.upwards else heights.max())

    def _reaction_in_balance(self, gap: Vector) -> Vector:
        """Return R for a gap vector (force), shape (n,)."""
        return self.problem.reaction(gap)

    def force_balance(self, gap: Vector) -> ForceBalance:
        """Return the resultants of load, support, ceiling, foundation and frame for a gap vector."""
        problem, below = self.problem, self._below(gap)
        reaction = self._reaction_in_balance(gap)
        _, at_ceiling = problem.bounds.contact(gap, reaction / problem.stiffness.diagonal())
        foundation = 0.0 if self.nodal_foundation is None else float((self.nodal_foundation * below).sum())
        pushed = -float(reaction[at_ceiling].sum()) if at_ceiling.any() else 0.0
        return ForceBalance(
            load=float(self.nodal_load.sum()),
            reaction=float(reaction.sum()) + pushed,
            frame=float(self.pull(below).sum()) - foundation,
            ceiling=pushed,
            foundation=foundation,
        )


def length_scale(
    mean: float,
    suction: float,
    v: Vector,
    below: Vector,
    above: Vector | None,
    relief: float,
    average: Callable[[Vector], float] = lambda values: float(values.mean()),
    least: Callable[[Vector], float] = lambda values: float(values.min()),
) -> float | None:
    """Return the length by which a model's tolerances are measured, see `ContactModel._gap_scale`; None for none.

    Parameters
    ----------
    mean, suction : float
        How far load and suction move the nodes in the mean without bounds (length), >= 0.
    v : array, shape (n,)
        What these are distributed as, > 0.
    below, above : array, shape (n,)
        How far the support lies below the frame's mean height, and a ceiling above it (length); ``above`` is None
        without a ceiling, and ``below`` is overwritten.
    relief : float
        How far the frame leaves its mean height (length).
    average, least : callable
        Mean and minimum over all nodes, where vectors hold a part of them only.
    """
    # Vectors of this length are made seldom: on large lattices that is what takes the time.
    down = mean * v
    down /= average(v)
    least_down = _LEAST_DEPTH * average(down)
    summit = max(0.0, -least(below))
    down += relief
    reachable = average(np.minimum(np.maximum(below, 0.0, out=below), down, out=down))
    if above is not None:
        up = suction * v / average(v)
        least_down = max(least_down, _LEAST_DEPTH * average(up))
        suction = average(np.minimum(np.maximum(above, 0.0), up + relief))
        summit += max(0.0, -least(above))
    return max(reachable + suction + summit, least_down) or None


def elevations_of(height: Any) -> Any:
    """Return a profile's depths as elevations, a function of (x, y), and everything else as it is."""
    return (lambda x, y: -height(x, y)) if isinstance(height, Profile) else height


def split(problem: ContactProblem | ContactModel) -> tuple[ContactModel | None, ContactProblem]:
    """Return the model, None for a bare problem, and its contact problem.

    Raises
    ------
    TypeError
        If it is neither.
    """
    if isinstance(problem, ContactModel):
        return problem, problem.problem
    if isinstance(problem, ContactProblem):
        return None, problem
    raise TypeError(
        f"problem must be a Membrane, a Cable, a CableNet, a ContactQP or a ContactLCP, got {type(problem).__name__}"
    )


def at_unknowns(
    problem: ContactProblem | ContactModel, values: Any, name: str, *, rows: Rows | None = None, copied: bool = True
) -> Vector:
    """Return a finite value for each unknown, shape (n,), however a program lays them out.

    Parameters
    ----------
    problem : Membrane, Cable, CableNet, ContactQP or ContactLCP
    values : array, xarray.DataArray, Solution, or xarray.Dataset
        A vector in node order; on a lattice an array of its shape, of which the entries that are no nodes may be
        anything or be masked, or a DataArray with the dims y and x; of a solution or a dataset its ``gap``.
    name : str
        The argument's name, for messages.
    rows : {"up", "down"}, optional
        Which way y goes from row to row of an array without coordinates: up, if nothing is said; but of a model that
        was made with ``rows="down"`` it must be said. A vector has no rows.
    copied : bool
        Whether the vector is a new one, whatever was given.

    Raises
    ------
    TypeError, ValueError
        If the values have the wrong kind or shape or are not finite.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Lattice.from_mask([[True, False], [True, True]], spacing=1.0)
    >>> membrane = cq.Membrane(lattice, tension=1.0, load=1.0, support=0.1)
    >>> at_unknowns(membrane, [[0.1, np.nan], [0.2, 0.3]], "gap")
    array([0.1, 0.2, 0.3])
    """
    model, algebra = split(problem)
    if not isinstance(values, np.ndarray):
        values = getattr(values, "gap", values)
    values = in_rows(values, name, rows, "up") if model is None else model.in_own_rows(values, name, rows)
    if model is not None and (is_dataarray(values) or np.ndim(values) == 2):
        values = model.at_nodes(values, name)
    elif algebra.stencil is not None and np.ndim(values) == 2:
        values = algebra.stencil.numbering.to_vector(np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan))
    return vector(values, algebra.size, name, copied=copied)
