"""Beam: bent between its ends, in the vicinity of rigid ground."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np

from ..foundation.checks import Mask, Vector, one_of, read_only
from ..foundation.keywords import known_by_name
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames
from ..foundation.units import checked_units, plain
from ..geometry.fields import of_x_and_y
from ..geometry.lattice import Lattice
from ..geometry.on_arms import ArmField, at_points_of_line
from .bending import BendingModel
from .on_line import LineModel, lattice_on_line
from .sensitive import Resistance, Values
from .tension import Tension

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from .records import Answered

End: TypeAlias = Literal["pinned", "clamped", "free"]
"""How an end of a beam is held: its height; its height and its slope, which is zero; not at all."""

ENDS: tuple[End, ...] = ("pinned", "clamped", "free")

_BENT_OVER_MEAN: dict[frozenset[End], float] = {
    frozenset({"clamped"}): 720.0,
    frozenset({"clamped", "pinned"}): 320.0,
    frozenset({"pinned"}): 120.0,
    frozenset({"clamped", "free"}): 20.0,
    frozenset({"pinned", "free"}): 0.0,
    frozenset({"free"}): 0.0,
}
"""pL⁴/EI over the mean deflection under a uniform load p, by how the ends are held; 0 where nothing else holds it."""

_REACH = 2
"""Nodes on either side that the stencil of bending reaches."""

_STRETCHED_OVER_MEAN = {0: 0.0, 1: 3.0, 2: 12.0}
"""pL²/T over the mean deflection of a cable, by the number of ends that are held."""


@dataclass(frozen=True, eq=False)
class InternalForces:
    """What a bent beam transmits from one cross-section to the next.

    Attributes
    ----------
    x : array, shape (m + 1,)
        Abscissae of the nodes and of both ends (length).
    moment : array, shape (m + 1,)
        Bending moment M = -EI w″, w being positive downwards (force times length): positive where it sags.
    arm_x : array, shape (m,)
        Middles of the arms between them (length).
    shear : array, shape (m,)
        V = dM/dx in the arms (force).
    reaction : (float, float)
        With which the left and the right end are held, upwards (force); 0 of a free one. It is the vertical force in
        the arm beside the end, V + T w′; the load on half a spacing at an end, which that end carries as well, belongs
        to no node, and is not in it.
    """

    x: Vector
    moment: Vector
    arm_x: Vector
    shear: Vector
    reaction: tuple[float, float]


class Beam(LineModel, BendingModel):
    r"""A beam over a smooth, rigid support, with tension or without.

    (EI w″)″ - (T w′)′ + kw = p - ρ, c ≤ w ≤ f, at small slopes (Euler and Bernoulli). Along the ground the beam presses
    on it by ρ = p - (EI f″)″ + (T f′)′ - kf. Where it leaves the ground, slope and moment are continuous but the shear
    is not, so that a concentrated reaction stands there as well. Over a flat floor f below its end a beam without
    tension spans a = (24 EI f/p)^¼ from a pinned end and comes down with the force pa/2, from a clamped one
    a = (72 EI f/p)^¼ and pa/3. On the lattice one or two nodes bear that force, whose ``contact_pressure`` grows as the
    spacing shrinks; `spans` has it, to second order of the spacing over level ground.

    The energy ½∫EI w″² + T w′² + kw² of second and first differences gives the rows (1, -4, 6, -4, 1) EI/Δ³ of G,
    symmetric and of second order up to the ends: a pinned end, w = w″ = 0, leaves 5 on the diagonal beside it; a
    clamped one, w = w′ = 0, leaves 7, by the image of the node beside it; a free one is itself a node, with 1.

    Parameters
    ----------
    span : float, optional
        Distance of the ends (length), a whole multiple of the spacing. Give ``span`` or ``nodes``.
    nodes : int, optional
        Number of nodes between the ends: span = (nodes + 1) spacing.
    spacing : float
        Δ, distance of neighbouring nodes (length), > 0.
    bending_stiffness : number, array or function of x
        EI, force times length squared, > 0. An array has a value for each node between the ends, or for each of these
        and both ends (without, an end has that of the node beside it).
    tension : number, array or function of x
        T, force: the number 0 for none, or else > 0. Of a function an arm between two nodes has the value in its
        middle, else the harmonic mean of the values at its ends; an array as for ``bending_stiffness``.
    load : number, array or function of x
        Active load p, positive downwards, force per length.
    support : number, array or function of x
        Height f of the ground (length). Heights are positive downwards, unless ``upwards``; ``inf`` where there is
        none.
    ends : pair of {"pinned", "clamped", "free"}, or one for both
        How the left and the right end are held. A free one needs something else that holds the beam: a clamp at the
        other end, a tension, or a foundation.
    frame_height : number or function of x
        Heights of the ends that are held, positive as those of the ground, length; a clamped one is level.
    start : float
        Abscissa of the left end (length).
    upwards : bool
        As for `Cable`.
    ceiling : number, array or function of x, optional
        Height c of a rigid surface above the beam (length), given and positive as the ground is: c ≤ f, or with
        ``upwards`` c ≥ f; ``-inf`` (``inf``) where there is none.
    foundation : number, array or function of x, optional
        Stiffness k ≥ 0 of an elastic foundation (Winkler), which pulls the beam to height zero by kw: force per length
        and length.
    units : str or mapping, optional
        As for `Membrane`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range, the ceiling lies below the ground, or nothing holds the beam
        where it is; the message names it.

    Attributes
    ----------
    ends : (str, str)
        How the left and the right end are held.

    Examples
    --------
    >>> import contactqp as cq
    >>> beam = cq.Beam(span=10.0, spacing=0.1, bending_stiffness=1.0, load=1.0, support=0.5)
    >>> beam
    Beam(99 nodes, spacing=0.1, bending_stiffness=1, pinned - pinned, load=1, support=0.5)
    >>> solution = cq.solve(beam)
    >>> beam.spans(solution)[["kind", "start", "end", "reaction", "force_at_start"]].round(2)
          kind  start   end  reaction  force_at_start
    0     free    0.0   1.8      0.00             NaN
    1  contact    1.8   8.2      8.14            0.93
    2     free    8.2  10.0      0.00             NaN

    A cantilever over a step that its end comes down to:

    >>> board = cq.Beam(4.0, spacing=0.5, bending_stiffness=2.0, ends=("clamped", "free"), load=1.0, support=3.0)
    >>> cq.solve(board).contact.nonzero()[0]
    array([7])
    """

    noun: ClassVar[str] = "beam"
    _bending_unit: ClassVar[str] = "force times length squared"

    @known_by_name
    def __init__(
        self,
        span: float | None = None,
        nodes: int | None = None,
        *,
        spacing: float,
        bending_stiffness: Any,
        tension: Any = 0.0,
        load: Any,
        support: Any,
        ends: tuple[End, End] | End = ("pinned", "pinned"),
        frame_height: Any = 0.0,
        start: float = 0.0,
        upwards: bool = False,
        ceiling: Any = None,
        foundation: Any = None,
        units: UnitNames | None = None,
    ) -> None:
        names = checked_units(units)
        span, spacing, start = (
            plain(value, name, "length", names)
            for value, name in ((span, "span"), (spacing, "spacing"), (start, "start"))
        )
        between = lattice_on_line(span, nodes, spacing, start, Beam.noun)
        self.start, self.ends = float(start), _checked_ends(ends)
        stiffness = plain(bending_stiffness, "bending_stiffness", self._bending_unit, names)
        self._rigidity = at_points_of_line(between, of_x_and_y(stiffness), "bending_stiffness")
        tensions = Tension.or_none(between, of_x_and_y(plain(tension, "tension", self._tension_unit, names)), "x")
        lattice = _with_free_ends(between, self._free)
        area = np.full(lattice.size, lattice.spacing)
        area[[0] * self._free[0] + [-1] * self._free[1]] /= 2
        super().__init__(
            *(lattice, self._at_own_nodes(tensions, between), load, support, frame_height),
            area=area if any(self._free) else lattice.spacing,
            upwards=upwards,
            ceiling=ceiling,
            foundation=foundation,
            units=names,
        )
        self._refuse_motion()
        self._warn()

    @staticmethod
    def lattice_of(
        span: float | None = None,
        nodes: int | None = None,
        *,
        spacing: float,
        ends: tuple[End, End] | End = ("pinned", "pinned"),
        start: float = 0.0,
    ) -> Lattice:
        """Return the lattice of a beam's nodes, one row of them: those between the ends, and ends that are free.

        Parameters
        ----------
        span, nodes, spacing, ends, start
            See the class.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong kind or range.

        Examples
        --------
        >>> import contactqp as cq
        >>> cq.Beam.lattice_of(10.0, spacing=2.5, ends=("clamped", "free")).x
        array([ 2.5,  5. ,  7.5, 10. ])
        """
        left, right = (end == "free" for end in _checked_ends(ends))
        return _with_free_ends(lattice_on_line(span, nodes, spacing, start, Beam.noun), (left, right))

    @property
    def point_stiffness(self) -> float | Vector:
        """EI at the nodes and at both ends, shape (points,), a number where it is the same everywhere."""
        return self._rigidity

    def pull_per_tension(self, depths: Vector, pull_of_arms: Vector) -> Vector:
        """See `ContactModel.pull_per_tension`."""
        rise = np.diff(self.along_points(depths)) / self.lattice.spacing
        return np.asarray(self._of_nodes(-np.diff(np.pad(rise, 1))))

    @property
    def resistances(self) -> Mapping[str, Resistance]:
        """See `ContactModel.resistances`: ``point_stiffness``, and ``bending_stiffness`` where it is one number."""
        found = {"point_stiffness": Resistance((self._bending.size,), self._bent_by, self._share_of_points)}
        if isinstance(self._rigidity, float):
            found["bending_stiffness"] = Resistance(
                (), self._bent_by, lambda depths, weights: self._share_of_points(depths, weights).sum()
            )
        return found

    def _bent_by(self, depths: Vector, stiffness: Values) -> Vector:
        """Return the force with which the points' bending alone pulls each node upwards, by their stiffness EI."""
        moment = self._bends * stiffness * self._turns(np.diff(self.along_points(depths)))
        return np.asarray(self._of_nodes(np.diff(np.pad(np.diff(moment), 1))))

    def _share_of_points(self, depths: Vector, weights: Vector) -> Vector:
        left, right = (int(held) for held in self._held)
        turn = self._turns(np.diff(self.along_points(depths)))
        return np.asarray(self._bends * turn * np.diff(np.pad(np.diff(np.pad(weights, (left, right))), 1)))

    @property
    def _free(self) -> tuple[bool, bool]:
        left, right = (end == "free" for end in self.ends)
        return left, right

    def _of_nodes(self, at_points: Any) -> Any:
        """Return what a quantity is at the nodes, given at all points of the beam, shape (points,)."""
        left, right = self._free
        return at_points[int(not left) : len(at_points) - int(not right)]

    def _at_own_nodes(self, tension: Tension, between: Lattice) -> Tension:
        """Return a tension that is known at the nodes between the ends with its values at free ends, too."""
        (field,) = tension.fields
        if isinstance(field.nodes, float) or field.nodes.size == between.size + sum(self._free):
            return tension
        arms = np.broadcast_to(field.arms, (1, between.size + 1))
        nodes = self._of_nodes(np.concatenate([arms[0, :1], field.nodes, arms[0, -1:]]))
        return Tension((ArmField(arms, read_only(nodes)),), tension.same)

    def _refuse_motion(self) -> None:
        """Raise a ValueError unless ends, tension and foundation hold the beam against moving as a rigid body."""
        if "clamped" in self.ends or "free" not in self.ends:
            return
        stretched = self._is_stretched
        springs = 0 if self.foundation is None else int(np.count_nonzero(self.foundation))
        if "pinned" in self.ends:
            if not stretched and not springs:
                raise ValueError(
                    f"ends={self.ends!r} let the beam turn about its pinned end: clamp that, or give a tension > 0 or "
                    "a foundation"
                )
        elif springs < (1 if stretched else 2):
            raise ValueError(
                f"ends={self.ends!r} let the beam fall, and a foundation under {'one' if stretched else 'two'} of its "
                "nodes or more does not hold it: pin or clamp an end, or give a foundation"
            )

    @property
    def bending_stiffness(self) -> float | Vector:  # type: ignore[override]
        """EI at the nodes (force times length squared), a number where it is the same everywhere."""
        return self._rigidity if isinstance(self._rigidity, float) else read_only(self._of_nodes(self._rigidity))

    def frame_points(self) -> Mask:
        """See `LatticeModel.frame_points`: the ends that are held."""
        points = super().frame_points()
        points[1, [0] * self._free[0] + [-1] * self._free[1]] = False
        return points

    @cached_property
    def _bending(self) -> Vector:
        """EI/Δ³ at the points of the beam, 0 where the moment is (force per length), shape (points,)."""
        return self._bends * self._rigidity

    @cached_property
    def _bends(self) -> Vector:
        """1/Δ³ at the points of the beam, 0 where there is no moment, shape (points,)."""
        at_points = np.full(self.size + sum(self._held), 1 / self.lattice.spacing**3)
        at_points[[0, -1]] *= [end == "clamped" for end in self.ends]
        return at_points

    @staticmethod
    def _turns(rise: Vector) -> Vector:
        """Return Δ²w″ at the points, given what the arms rise by; clamped ends mirror what is beside them."""
        return np.concatenate([2 * rise[:1], np.diff(rise), -2 * rise[-1:]])

    @cached_property
    def _stretching(self) -> Vector:
        """T/Δ of the arms (force per length), shape (points - 1,)."""
        count = self._bending.size - 1
        return np.array(np.broadcast_to(self._tension.fields[0].arms, (1, count))[0]) / self.lattice.spacing

    def _transmitted(self, below: Vector) -> tuple[Vector, Vector, Vector]:
        """Return M/Δ at the points, with the sign of w″, and the parts of bending and tension in the arms' force."""
        rise = np.diff(self.along_points(below))
        moment = self._bending * self._turns(rise)
        return moment, -np.diff(moment), self._stretching * rise

    def pull(self, depths: Vector) -> Vector:
        """Return the force with which the beam pulls each node upwards; see `ContactModel.pull`."""
        _, bending, stretching = self._transmitted(depths)
        pulled: Vector = self._of_nodes(-np.diff(np.pad(bending + stretching, 1)))
        return pulled if self.nodal_foundation is None else pulled + self.nodal_foundation * depths

    def assemble_stiffness(self) -> csr_array:
        """Return G, a matrix of five diagonals."""
        load_modules("scipy.sparse")
        from scipy import sparse

        bending, arms = self._bending.copy(), np.pad(self._stretching, 1)
        # A clamped end turns by twice as much as a node does, but counts for half a spacing.
        bending[[0, -1]] *= 2
        ring = np.pad(bending, 1)
        diagonal = ring[:-2] + ring[2:] + arms[:-1] + arms[1:]
        diagonal[1:-1] += 4 * bending[1:-1]
        inner = bending * np.concatenate([[0.0], np.ones(bending.size - 2), [0.0]])
        beside = -2 * (inner[:-1] + inner[1:]) - self._stretching
        left, right = self._held
        here = slice(int(left), bending.size - int(right))
        diagonal, beside = diagonal[here], beside[here.start : here.stop - 1]
        beyond = inner[here][1:-1]
        if self.nodal_foundation is not None:
            diagonal = diagonal + self.nodal_foundation
        size = diagonal.size
        diagonals = [(-2, beyond), (-1, beside), (0, diagonal), (1, beside), (2, beyond)]
        offsets, kept = zip(*(each for each in diagonals if abs(each[0]) < size), strict=True)
        return sparse.csr_array(sparse.diags_array(kept, offsets=offsets, shape=(size, size)))

    def internal_forces(self, gap: Vector) -> InternalForces:
        """Return bending moment, shear and the forces at the ends for a gap vector.

        Parameters
        ----------
        gap : array, shape (n,)
            Length, as that of a solution.

        Examples
        --------
        A weight of 1 hangs from a clamp at each end, 2 from each: the moments there are pL²/12.

        >>> import contactqp as cq
        >>> beam = cq.Beam(4.0, spacing=0.01, bending_stiffness=1.0, load=1.0, support=np.inf, ends="clamped")
        >>> forces = beam.internal_forces(cq.solve(beam).gap)
        >>> forces.moment[[0, 200, 400]].round(3), np.round(forces.reaction, 3)
        (array([-1.333,  0.667, -1.333]), array([1.995, 1.995]))
        """
        moment, bending, stretching = self._transmitted(self._below(gap))
        x, force = self.point_x, bending + stretching
        left, right = self._held
        return InternalForces(
            x=x,
            moment=-moment * self.lattice.spacing,
            arm_x=(x[:-1] + x[1:]) / 2,
            shear=bending,
            reaction=(float(force[0]) if left else 0.0, -float(force[-1]) if right else 0.0),
        )

    def fields_of_answer(self, gap: Vector) -> dict[str, tuple[Vector, str, str]]:
        """See `ContactModel.fields_of_answer`: bending moment and shear."""
        forces = self.internal_forces(gap)
        shear = np.concatenate([forces.shear[:1], (forces.shear[:-1] + forces.shear[1:]) / 2, forces.shear[-1:]])
        moment, shear = self._of_nodes(forces.moment), self._of_nodes(shear)
        return {
            "bending_moment": (moment, "force times length", "bending moment, positive where the beam sags"),
            "shear": (shear, "force", "slope of the bending moment along x, the mean of both sides of a node"),
        }

    def facts_of_span(self, solution: Answered, nodes: slice) -> dict[str, float]:
        r"""Return the largest bending moment, and the concentrated reactions where a contact stretch meets free spans.

        The stencil of bending reaches over two nodes, so that all but two nodes at each end of a stretch bear what the
        beam presses with there, ρΔ, as if it lay on the ground throughout. What the two bear beyond that, L₁ and L₂ at
        the distances Δ/2 and 3Δ/2 from the middle of the arm beside the free span, is concentrated. The beam comes down
        with F at t from that middle, and rests only from there on, pressing by ρ. Forces and moments are the same if
        F = L₁ + L₂ + ρt and Ft - ρt²/2 = (L₁ + 3L₂)Δ/2, so that F² = (L₁ + L₂)² + ρΔ(L₁ + 3L₂); on ground on which ρ
        changes little from node to node the error is of second order. It is nan at the ends of a line, on stretches of
        fewer than six nodes, which are all ends, and where ρ changes by as much as itself within three nodes.
        """
        moment = self._of_nodes(self.internal_forces(solution.gap).moment)[nodes]
        largest = {"largest_moment": float(moment[np.argmax(np.abs(moment))])}
        if not solution.contact[nodes.start]:
            return largest | {"force_at_start": np.nan, "force_at_end": np.nan}
        reaction = np.asarray(solution.reaction)[nodes]
        return largest | {
            "force_at_start": _comes_down(reaction) if nodes.start > 0 else np.nan,
            "force_at_end": _comes_down(reaction[::-1]) if nodes.stop < self.size else np.nan,
        }

    def _mean_under(self, load: float) -> float:
        span, kept = self.span, sum(self._held)
        bending = _BENT_OVER_MEAN[frozenset(self.ends)] * float(np.min(self._rigidity)) / span**4
        stretching = _STRETCHED_OVER_MEAN[kept] * float(np.min(self._tension.fields[0].arms)) / span**2
        return load / (bending + stretching + self._mean_foundation())

    def _stiffness_told(self) -> Iterator[str]:
        yield from super()._stiffness_told()
        yield " - ".join(self.ends)


def _checked_ends(ends: Any) -> tuple[End, End]:
    pair = (ends, ends) if isinstance(ends, str) else ends
    if not isinstance(pair, (tuple, list)) or len(pair) != 2:
        raise ValueError(f"ends must be a pair of {', '.join(map(repr, ENDS))}, left and right, got {ends!r}")
    left, right = (one_of(end, ENDS, f"ends[{k}]") for k, end in enumerate(pair))
    return left, right  # type: ignore[return-value]


def _with_free_ends(between: Lattice, free: tuple[bool, bool]) -> Lattice:
    """Return the lattice of the nodes between the ends, and of the ends that are free."""
    if not any(free):
        return between
    x, y = between.origin
    mask = np.ones((1, between.size + sum(free)), dtype=np.bool_)
    return Lattice(mask, between.spacing, (x - between.spacing * free[0], y))


def _comes_down(reaction: Vector) -> float:
    """Return the concentrated reaction beside a free span, see `Beam.facts_of_span`; the nodes go away from that."""
    if reaction.size < 2 * _REACH + 2:
        return np.nan
    side = np.sign(reaction[_REACH])
    resting = side * reaction[_REACH : min(_REACH + 3, reaction.size - _REACH)]
    pressing = float(resting[0])
    if not pressing > 0 or not np.ptp(resting) < pressing:
        return np.nan
    first, second = (float(side * one) - pressing for one in reaction[:_REACH])
    squared = (first + second) ** 2 + pressing * (first + 3 * second)
    return float(side * np.sqrt(max(squared, 0.0)))
