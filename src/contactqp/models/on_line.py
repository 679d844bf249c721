"""LineModel: nodes along x, a cable's or a beam's, over a rigid support."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector, finite_number, integer_at_least, positive_number
from ..foundation.limits import BYTES_TO_SOLVE, refuse_too_many
from ..geometry.fields import of_x_and_y
from ..geometry.lattice import Lattice, spacing_of_nodes
from .base import Coordinate
from .on_lattice import LatticeModel

if TYPE_CHECKING:
    import pandas as pd

    from .records import Answered


class LineModel(LatticeModel):
    """Nodes in a row along x, between two ends.

    Base of `Cable` and `Beam`, beside the one that says by what their nodes resist.

    Attributes
    ----------
    start : float
        Abscissa of the left end (length).
    """

    start: float
    _axes: ClassVar[tuple[int, ...]] = (1,)
    _load_unit = "force per length"
    _pressure_unit = "force per length"
    _tension_unit = "force"
    _foundation_unit = "force per length and length"

    def at_nodes(self, field: Any, name: str, *, allow_inf: bool = False, absent: float | None = None) -> Vector:
        """See `ContactModel.at_nodes`; a function may also be one of x alone."""
        return super().at_nodes(of_x_and_y(field), name, allow_inf=allow_inf, absent=absent)

    def _in_own_sense(self, height: Any) -> Any:
        return of_x_and_y(super()._in_own_sense(height))

    @property
    def _held(self) -> tuple[bool, bool]:
        """Whether the left and the right end are points of the frame, and no nodes."""
        left, *_, right = self.frame_points()[1].tolist()
        return left, right

    @property
    def span(self) -> float:
        """Distance of the ends (length)."""
        return self.lattice.spacing * (self.lattice.size + sum(self._held) - 1)

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """Abscissae of the nodes (length)."""
        return {"x": super().coordinates["x"]}

    def laid_out(self, values: Vector | Mask) -> tuple[tuple[str, ...], NDArray[Any]]:
        """Return values of the nodes along x; see `ContactModel.laid_out`."""
        _, grid = super().laid_out(values)
        return ("x",), grid[0]

    @property
    def point_x(self) -> Vector:
        """Abscissae of the nodes and of both ends (length), shape (points,)."""
        ends = np.array([self.start, self.start + self.span])
        left, right = self._held
        return np.concatenate([ends[: int(left)], self.node_x, ends[2 - int(right) :]])

    def along_points(self, below: Vector) -> Vector:
        """Return depths of the nodes with those of ends that are held (length), shape (points,)."""
        left, right = self._held
        return np.asarray(self._padded(below)[1][int(not left) : self.size + 1 + int(right)])

    def facts_of_span(self, solution: Answered, nodes: slice) -> dict[str, float]:
        """Return what `spans` tells beside what holds of any line, of a free span or a contact stretch, by column."""
        return {}

    def spans(self, solution: Answered) -> pd.DataFrame:
        """Return free spans and contact stretches in turn, from the left end to the right.

        A touchdown lies somewhere between a node in contact and a free one beside it, and is reported at the node in
        contact: a contact stretch goes from its first node to its last one, and a free span, which has one free node
        or more, from node in contact to node in contact, or to the end of the line. So the rows meet; only where a node
        in contact is next to an end that is held, nothing is told of the arm between them, which has no node of its
        own: it may hang free, or lie on the ground like its ends. Then the lengths add up to the line's less that arm.

        Parameters
        ----------
        solution : Solution
            An answer for this model, by any backend.

        Returns
        -------
        pandas.DataFrame
            One row each, with the columns

            * kind: "free" or "contact", by ``solution.contact``;
            * start, end, length: abscissae of the row's ends, and their distance (length), 0 for contact at one node;
              in contact it is a spacing less than what the nodes stand for, see `Solution.contact_area`;
            * nodes: how many are free (in contact);
            * largest_gap, largest_gap_at: of the nodes over a support, and its abscissa (length); nan in contact;
            * sag: how far a free span hangs below the chord of its ends at most (length); nan in contact;
            * largest_slope: of the arms between start and end, without sign; nan for contact at one node;
            * reaction: the sum of R over the nodes in contact (force); 0 for a free span;
            * reaction_lower, reaction_upper: bounds of the true sum (force); nan without a certificate;
            * certain: whether the certificate proves both ends of the row: that its outermost nodes, and their
              neighbours in the rows beside it, are in contact or free as ``solution.contact`` has it;
            * undecided: how many nodes of the row the certificate leaves undecided; all if there is no certificate;
            * of a beam largest_moment: the bending moment that is largest in size, with its sign (force times length);
              force_at_start, force_at_end: the concentrated reactions with which it comes down at the ends of a contact
              stretch, which are parts of its reaction (force); nan for a free span, at the ends of the line, and on
              stretches of fewer than six nodes or on ground so rough that nothing tells them from the rest.

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

        return spans_of(self, solution)


def lattice_on_line(span: float | None, nodes: int | None, spacing: float, start: float, noun: str) -> Lattice:
    """Return the lattice of the nodes between two ends, one row of them; see `Cable.lattice_of`."""
    spacing = spacing_of_nodes(spacing)
    start = finite_number(start, "start")
    count = _node_count(span, nodes, spacing, noun)
    return Lattice(np.ones((1, count), dtype=bool), spacing, (start + spacing, 0.0))


def _node_count(span: float | None, nodes: int | None, spacing: float, noun: str) -> int:
    if (span is None) == (nodes is None):
        raise ValueError(f"give either span or nodes, got span={span!r}, nodes={nodes!r}")
    if nodes is not None:
        count = integer_at_least(nodes, 1, "nodes")
        refuse_too_many(count, f"nodes of a {noun}", BYTES_TO_SOLVE, "choose fewer")
        return count
    # The quotient of the largest number and a small one is infinite, which is counted as such.
    ratio = positive_number(span, "span") / spacing
    refuse_too_many(ratio - 1, f"nodes of a {noun}", BYTES_TO_SOLVE, "choose a larger spacing")
    if abs(ratio - round(ratio)) > 1e-9 * ratio or round(ratio) < 2:
        raise ValueError(
            f"span must be a whole multiple (2 or more) of the spacing, got {span:g} / {spacing:g} = {ratio:.12g}"
        )
    return round(ratio) - 1
