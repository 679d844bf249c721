"""Cable: stretched between fixed ends, in the vicinity of rigid ground."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, finite_number, integer_at_least, positive_number
from ..foundation.keywords import known_by_name
from ..foundation.limits import BYTES_TO_SOLVE, refuse_too_many
from ..foundation.pictures import UnitNames
from ..foundation.units import checked_units, plain
from ..geometry.fields import of_x_and_y
from ..geometry.lattice import Lattice, spacing_of_nodes
from .base import Coordinate
from .on_lattice import LatticeModel
from .tension import Tension

if TYPE_CHECKING:
    import pandas as pd

    from .records import Answered


class Cable(LatticeModel):
    r"""A cable over a smooth, rigid support.

    -T w″ = p - ρ between fixed ends; three-point differences give G = (T/Δ) tridiag(-1, 2, -1), P = pΔ, and the same
    complementarity problem as for a membrane. With a tension that varies, a ceiling and an elastic foundation it is
    -(T w′)′ + kw = p - ρ, c ≤ w ≤ f.

    Parameters
    ----------
    span : float, optional
        Distance of the ends (length), a whole multiple of the spacing. Give ``span`` or ``nodes``.
    nodes : int, optional
        Number of nodes between the ends: span = (nodes + 1) spacing.
    spacing : float
        Δ, distance of neighbouring nodes (length), > 0.
    tension : number, array or function of x
        T, force, > 0. Of a function an arm between two nodes has the value in its middle, else the harmonic mean of the
        values at its ends. An array has a value for each node, or for each node and both ends (without, the outer arms
        have those of their nodes).
    load : number, array or function of x
        Active load p, positive downwards, force per length. A function of (x, y) gets y = 0.
    support : number, array or function of x
        Height f of the ground (length). Heights are positive downwards, unless ``upwards``; ``inf`` where there is
        none. Ground far beyond the load's reach counts as none, see `unreachable`.
    frame_height : number or function of x
        Heights of the ends, positive as those of the ground, length.
    start : float
        Abscissa of the left end (length).
    upwards : bool
        Whether heights are elevations, positive upwards: those of ground and ends as they are given, and the deflection
        and all pictures and files; ``-inf`` where there is no ground. A load stays positive downwards, and a profile of
        `contactqp.profiles` a surface of depths.
    ceiling : number, array or function of x, optional
        Height c of a rigid surface above the cable (length), given and positive as the ground is: c ≤ f, or with
        ``upwards`` c ≥ f; ``-inf`` (``inf``) where there is none.
    foundation : number, array or function of x, optional
        Stiffness k ≥ 0 of an elastic foundation (Winkler), which pulls the cable to height zero by kw: force per length
        and length.
    units : str or mapping, optional
        As for `Membrane`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind, shape or range, or the ceiling lies below the ground; the message names it.

    Attributes
    ----------
    start : float
        Abscissa of the left end (length).

    Examples
    --------
    >>> import contactqp as cq
    >>> cable = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0)
    >>> cable
    Cable(9 nodes, spacing=1, tension=1, load=1, support=2)
    >>> cq.solve(cable, backend="clarabel").contact.nonzero()[0] + 1
    array([2, 3, 4, 5, 6, 7, 8])

    On springs that hold it up, it comes down to the ground farther from its ends:

    >>> sprung = cq.Cable(span=10.0, spacing=1.0, tension=1.0, load=1.0, support=2.0, foundation=0.4)
    >>> cq.solve(sprung).contact.nonzero()[0] + 1
    array([4, 5, 6])
    """

    _load_unit = "force per length"
    _pressure_unit = "force per length"
    _tension_unit = "force"
    _foundation_unit = "force per length and length"

    @known_by_name
    def __init__(
        self,
        span: float | None = None,
        nodes: int | None = None,
        *,
        spacing: float,
        tension: Any,
        load: Any,
        support: Any,
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
        lattice = Cable.lattice_of(span, nodes, spacing=spacing, start=start)
        tensions = Tension.of(lattice, of_x_and_y(plain(tension, "tension", "force", names)), "x")
        self.start, self._stiffness_of_tension = float(start), 1 / lattice.spacing
        super().__init__(
            *(lattice, tensions, load, support, frame_height),
            area=lattice.spacing,
            arms=(tensions.fields[0].arms / lattice.spacing, 0.0),
            upwards=upwards,
            ceiling=ceiling,
            foundation=foundation,
            units=names,
        )

    @staticmethod
    def lattice_of(
        span: float | None = None, nodes: int | None = None, *, spacing: float, start: float = 0.0
    ) -> Lattice:
        """Return the lattice of a cable's nodes, one row of them.

        Parameters
        ----------
        span, nodes, spacing, start
            See the class.

        Raises
        ------
        TypeError, ValueError
            If an argument has the wrong kind or range.

        Examples
        --------
        >>> import contactqp as cq
        >>> cq.Cable.lattice_of(10.0, spacing=2.5, start=-5.0).x
        array([-2.5,  0. ,  2.5])
        """
        spacing = spacing_of_nodes(spacing)
        start = finite_number(start, "start")
        count = _node_count(span, nodes, spacing)
        return Lattice(np.ones((1, count), dtype=bool), spacing, (start + spacing, 0.0))

    def at_nodes(self, field: Any, name: str, *, allow_inf: bool = False, absent: float | None = None) -> Vector:
        """See `ContactModel.at_nodes`; a function may also be one of x alone."""
        return super().at_nodes(of_x_and_y(field), name, allow_inf=allow_inf, absent=absent)

    def _in_own_sense(self, height: Any) -> Any:
        return of_x_and_y(super()._in_own_sense(height))

    @property
    def span(self) -> float:
        """Distance of the ends (length)."""
        return self.lattice.spacing * (self.lattice.size + 1)

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """Abscissae of the nodes (length)."""
        return {"x": super().coordinates["x"]}

    def laid_out(self, values: Vector | Mask) -> tuple[tuple[str, ...], NDArray[Any]]:
        """Return values of the nodes along x; see `ContactModel.laid_out`."""
        _, grid = super().laid_out(values)
        return ("x",), grid[0]

    def spans(self, solution: Answered) -> pd.DataFrame:
        """Return the cable's free spans and contact stretches in turn, from the left end to the right.

        A touchdown lies somewhere between a node in contact and a free one beside it, and is reported at the node in
        contact: a contact stretch goes from its first node to its last one, and a free span, which has one free node
        or more, from node in contact to node in contact, or to the cable's end. So the rows meet; only where a node in
        contact is next to the cable's end, nothing is told of the arm between them.

        Parameters
        ----------
        solution : Solution
            An answer for this cable, by any backend.

        Returns
        -------
        pandas.DataFrame
            One row each, with the columns

            * kind: "free" or "contact", by ``solution.contact``;
            * start, end, length: abscissae of the row's ends, and their distance (length), 0 for contact at one node;
            * nodes: how many are free (in contact);
            * largest_gap, largest_gap_at: of the nodes over a support, and its abscissa (length); nan in contact;
            * sag: how far a free span hangs below the chord of its ends at most (length); nan in contact;
            * largest_slope: of the arms between start and end, without sign; nan for contact at one node;
            * reaction: the sum of R over the nodes in contact (force); 0 for a free span;
            * reaction_lower, reaction_upper: bounds of the true sum (force); nan without a certificate;
            * certain: whether the certificate proves both ends of the row: that its outermost nodes, and their
              neighbours in the rows beside it, are in contact or free as ``solution.contact`` has it;
            * undecided: how many nodes of the row the certificate leaves undecided; all if there is no certificate.

        Raises
        ------
        TypeError, ValueError
            If it is no solution, of another model, or holds no finite answer.

        Examples
        --------
        >>> import contactqp as cq
        >>> cable, _ = cq.gallery.cable_on_floor(nodes=19, contact_starts_after=4)
        >>> cable.spans(cq.solve(cable))[["kind", "start", "end", "sag", "reaction", "certain"]].round(9)
              kind  start   end  sag  reaction  certain
        0     free    0.0   4.0  2.0       0.0     True
        1  contact    4.0  16.0  NaN      12.0     True
        2     free   16.0  20.0  2.0       0.0     True
        """
        from .spans import spans_of

        return spans_of(self, (self.start, self.start + self.span), solution)


def _node_count(span: float | None, nodes: int | None, spacing: float) -> int:
    if (span is None) == (nodes is None):
        raise ValueError(f"give either span or nodes, got span={span!r}, nodes={nodes!r}")
    if nodes is not None:
        count = integer_at_least(nodes, 1, "nodes")
        _refuse_too_many_nodes(count, "choose fewer")
        return count
    # The quotient of the largest number and a small one is infinite, which is counted as such.
    ratio = positive_number(span, "span") / spacing
    _refuse_too_many_nodes(ratio - 1, "choose a larger spacing")
    if abs(ratio - round(ratio)) > 1e-9 * ratio or round(ratio) < 2:
        raise ValueError(
            f"span must be a whole multiple (2 or more) of the spacing, got {span:g} / {spacing:g} = {ratio:.12g}"
        )
    return round(ratio) - 1


def _refuse_too_many_nodes(count: float, remedy: str) -> None:
    refuse_too_many(count, "nodes of a cable", BYTES_TO_SOLVE, remedy)
