"""The part of a stencil that a process holds."""

from __future__ import annotations

from ..algebra.stencil import Stencil
from ..geometry.numbering import Grid, Numbering


class PartOfStencil(Stencil):
    """A stencil that is part of a larger one.

    Attributes
    ----------
    largest_of_all : float or None
        The largest diagonal entry of all processes' nodes, once it is known.
    """

    largest_of_all: float | None = None

    @property
    def largest_diagonal(self) -> float:
        """See `Stencil`: that of all processes' nodes."""
        return super().largest_diagonal if self.largest_of_all is None else self.largest_of_all

    def on_rows(self, first: int, last: int) -> PartOfStencil:
        """Return the stencil of the nodes in some rows, for which the others are frame; it shares the arms."""

        def rows(arms: Grid, more: int = 0) -> Grid:
            return arms if arms.ndim == 0 else arms[first : last + more]

        part = PartOfStencil.__new__(PartOfStencil)
        part.numbering = Numbering(self.mask[first:last], whole=True)
        part.horizontal, part.vertical, part.ground = rows(self.horizontal), rows(self.vertical, 1), rows(self.ground)
        part.grounded, part.largest_of_all = self.grounded, self.largest_of_all
        return part
