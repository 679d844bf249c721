"""Continuum: what is proven of the membrane itself by an answer of its lattice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.cards import card
from ..foundation.checks import Vector
from ..foundation.pictures import UnitNames, Wanted
from ..foundation.text import at_most, folded, rounded_outwards
from ..io.carried import Carried, Quantity
from ..io.fields import Field
from ..models.base import ContactModel
from ..plotting.of_squares import Strip, map_of_squares
from .contact import ContactBounds
from .dataset import InSquares, both_ends, bounds_dataset
from .membrane import MembraneBounds

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

EXACT, SAMPLED = "exact", "sampled data"


class NodalBounds(NamedTuple):
    """Bounds of a continuous deflection at the nodes.

    Attributes
    ----------
    lower, upper : array, shape (n,)
        Positive as the model's heights (length).
    error_bound : float
        No less than the distance of the answer's deflections from it (length).
    """

    lower: Vector
    upper: Vector
    error_bound: float


@dataclass(frozen=True, eq=False)
class Continuum:
    """What an answer of the lattice tells of the continuous membrane, its distance from the lattice included.

    Attributes
    ----------
    model : Membrane or Cable
        What was solved on its lattice.
    effort : {"energy", "pointwise"}
        How much was asked for.
    data : {"exact", "sampled data"}
        Whether load, support, frame and tension are known between the points of the lattice: as numbers, arrays (which
        are meant as their bilinear interpolants), profiles, and `contactqp.Smooth` functions are. All bounds are proven
        then. Of other functions nothing is known but their values at points: the bounds then hold for the membrane
        whose data are the interpolants of these, and nothing is proven of the one that was meant.
    sampled : tuple of str
        Names of the data of which the latter is true.
    energy : Bracket
        Of the membrane's potential energy ∫ ½T|∇w|² + ½kw² - pw (force times length), of depths w, positive downwards.
    energy_error : float
        Bound of the energy norm, (∫ T|∇u|² + ku²)^½, of u = Iw - w*: how far the bilinear interpolant of the answer is
        from the membrane (square root of force times length). Where the frame halves squares along diagonals, the
        interpolant is linear on the halves. Infinite, as the bracket of the energy and the contact error are, where
        support and ceiling are not known to leave room for an interpolant at the frame.
    energy_norm : float
        Energy norm of the interpolant itself, which the error is to be compared with.
    contact_error : float
        Bound of ∫R*(f - v), the work of the membrane's reaction on what is left of a gap where it touches (force times
        length); v is the interpolant, lowered where it would cross a curved support between the nodes.
    pointwise : MembraneBounds or None
        With ``effort="pointwise"``: bounds of the membrane at every point, and of where it touches.
    at_nodes : NodalBounds or None
        Of a cable of one tension, without foundation and ceiling: bounds of its deflection at the nodes.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(1, 1).lattice(spacing=1 / 32)
    >>> found = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.0, support=0.03), tol=1e-9).continuum("energy")
    >>> print(found)
    Continuum(energy): proven of the continuum itself
      data               exact
      potential energy   -0.01358407 to -0.01355716 (force times length)
      energy-norm error  <= 0.0074, 6.4 % of the norm
      contact error      <= 2.7e-05 (force times length)
    """

    model: ContactModel
    effort: str
    data: str
    energy: Bracket
    energy_error: float
    energy_norm: float
    contact_error: float
    sampled: tuple[str, ...] = ()
    pointwise: MembraneBounds | None = None
    at_nodes: NodalBounds | None = None

    @property
    def proven(self) -> bool:
        """Whether the bounds are proven of the data that were given."""
        return self.data == EXACT

    @property
    def relative_energy_error(self) -> float:
        """`energy_error` over the norm of the interpolant; infinite if that is zero."""
        return self.energy_error / self.energy_norm if self.energy_norm else np.inf

    @property
    def lower(self) -> Vector:
        """Lower bounds of the deflection at the nodes (length), shape (n,), by effort="pointwise"."""
        return self._at_nodes("lower").lower

    @property
    def upper(self) -> Vector:
        """Upper bounds of the deflection at the nodes (length), shape (n,), by effort="pointwise"."""
        return self._at_nodes("upper").upper

    @property
    def error_bound(self) -> float:
        """Bound of the answer's distance from the membrane at the nodes (length), with effort="pointwise"."""
        return self._at_nodes("error_bound").error_bound

    @property
    def contact(self) -> ContactBounds:
        """Where the membrane touches, see `ContactBounds`; needs effort="pointwise"."""
        return self._at_points("contact").contact

    @property
    def largest_depth(self) -> Bracket:
        """Bracket of the membrane's largest depth, positive downwards (length); needs effort="pointwise"."""
        return self._at_points("largest_depth").largest_depth

    def plot(self, ax: Any = None, *, title: str | None = None, units: UnitNames = "") -> Figure:
        """Draw where the membrane touches: clear, in contact, and the strip that holds the free boundary.

        Needs effort="pointwise".

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes of your own to draw into; by default there is a new figure, which shows itself in a notebook.
        title : str, optional
            Headline in place of the picture's own.
        units : str or mapping, optional
            Unit of length for labels.
        """
        found = self._at_points("plot")
        contact = found.contact
        states = contact.clear, contact.undecided, contact.contact
        share = found.part_undecided
        own = f"the membrane itself: all is decided but for {at_most(100 * share)} % of the area"
        rings = () if found.lattice.outline is None else found.lattice.outline.rings
        return map_of_squares(found.edges, states, found.halves, Wanted(ax, None, title, units), own, rings)

    @property
    def strip(self) -> Strip:
        """The squares that hold the membrane's free boundary, for maps; needs effort="pointwise"."""
        found = self._at_points("strip")
        return Strip(found.edges, found.contact.undecided, found.halves)

    def to_dataset(self) -> xr.Dataset:
        """Return the bounds as an xarray.Dataset, with units and meaning of every variable.

        Numbers: potential_energy_lower and _upper, energy_error, energy_norm, contact_error. With effort="pointwise" at
        the nodes deflection_lower, deflection_upper, gap_lower and gap_upper, the numbers error_bound, data_part,
        free_boundary_width, and by _lower and _upper largest_depth, contact_area and total_reaction; in squares, by
        x_square and y_square, gap_lower_in_squares, gap_upper_in_squares and contact_state_in_squares (1 certainly in
        contact, 0 certainly clear, -1 undecided, nan outside). Of a cable that is enclosed at its nodes error_bound,
        deflection_lower and deflection_upper.

        Returns
        -------
        xarray.Dataset

        Examples
        --------
        >>> import contactqp as cq
        >>> data = cq.solve(cq.Cable(1.0, spacing=0.25, tension=1.0, load=1.0, support=0.1)).continuum().to_dataset()
        >>> data["deflection_lower"].dims, data["error_bound"].attrs["units"]
        (('x',), 'length')
        """
        nodal, told = self._fields_at_nodes, self._told
        return bounds_dataset(self.model, self._numbers, nodal, self._squares).assign_attrs(told)

    @property
    def carried(self) -> Carried:
        """What goes along into files: bounds at the nodes, numbers, and words."""
        return Carried(self._fields_at_nodes, self._numbers, self._told, self.to_dataset)

    @property
    def _told(self) -> dict[str, str]:
        return {"effort": self.effort, "data": self.data, "sampled": ", ".join(self.sampled)}

    @property
    def _fields_at_nodes(self) -> dict[str, Field]:
        if self.pointwise is None and self.at_nodes is None:
            return {}
        nodal = {"deflection_lower": self.lower, "deflection_upper": self.upper}
        if self.pointwise is not None:
            nodal |= {"gap_lower": self.pointwise.gap_lower, "gap_upper": self.pointwise.gap_upper}
        return {name: Field(values, "length", _meaning(name)) for name, values in nodal.items()}

    @property
    def _squares(self) -> InSquares | None:
        found = self.pointwise
        if found is None:
            return None
        return InSquares(found.edges, found.gap_lower_in_cells, found.gap_upper_in_cells, found.contact)

    @property
    def _numbers(self) -> dict[str, Quantity]:
        work, root = "force times length", "square root of force times length"
        numbers = both_ends("potential_energy", self.energy, work, "membrane's potential energy")
        numbers |= {
            "energy_error": Quantity(self.energy_error, root, "bound of the energy norm of the interpolant's error"),
            "energy_norm": Quantity(self.energy_norm, root, "energy norm of the interpolant"),
            "contact_error": Quantity(self.contact_error, work, "bound of the work of the reaction on the gap"),
        }
        if self.pointwise is not None or self.at_nodes is not None:
            told = "bound of the answer's distance from the membrane at the nodes"
            numbers["error_bound"] = Quantity(self.error_bound, "length", told)
        if self.pointwise is None:
            return numbers
        found, contact = self.pointwise, self.pointwise.contact
        width = "bound of the Hausdorff distance of undecided squares and free boundary"
        return {
            **numbers,
            "data_part": Quantity(found.data_part, "length", "part of error_bound that comes of data between nodes"),
            **both_ends("largest_depth", found.largest_depth, "length", "membrane's largest depth, positive downwards"),
            **both_ends("contact_area", contact.area, "length squared", "area in contact"),
            **both_ends("total_reaction", contact.reaction, "force", "force that the support bears"),
            "free_boundary_width": Quantity(contact.free_boundary_width, "length", width),
        }

    def _at_nodes(self, name: str) -> MembraneBounds | NodalBounds:
        return self._at_points(name) if self.at_nodes is None else self.at_nodes

    def _at_points(self, name: str) -> MembraneBounds:
        if self.pointwise is not None:
            return self.pointwise
        if self.effort == "pointwise":
            raise AttributeError(f"{name} is known of a Membrane, this is of {self.model!r}")
        raise AttributeError(f"{name} needs solution.continuum(effort='pointwise'), this is {self.effort!r}")

    def facts(self) -> Mapping[str, str]:
        """Return what there is to tell, one line each, by its name."""
        return dict(self._facts())

    def _facts(self) -> Iterator[tuple[str, str]]:
        yield "data", self.data + (f": {', '.join(self.sampled)}" if self.sampled else "")
        if np.isfinite(self.energy_error):
            yield from self._facts_of_energy()
        if self.pointwise is not None:
            yield from self._facts_at_points(self.pointwise)

    def _facts_of_energy(self) -> Iterator[tuple[str, str]]:
        lower, upper = rounded_outwards(*self.energy, digits=7)
        yield "potential energy", f"{lower!r} to {upper!r} (force times length)"
        share = f", {at_most(100 * self.relative_energy_error)} % of the norm" if self.energy_norm else ""
        yield "energy-norm error", f"<= {at_most(self.energy_error)}{share}"
        if self.at_nodes is not None:
            yield "error at nodes", f"<= {at_most(self.at_nodes.error_bound)} (length)"
        yield "contact error", f"<= {at_most(self.contact_error)} (force times length)"

    @staticmethod
    def _facts_at_points(found: MembraneBounds) -> Iterator[tuple[str, str]]:
        yield "error at nodes", f"<= {at_most(found.error_bound)} (length)"
        contact = found.contact
        counts = (("in contact", contact.contact), ("clear", contact.clear), ("undecided", contact.undecided))
        yield "squares", ", ".join(f"{np.count_nonzero(where)} {name}" for name, where in counts)
        for name, bracket, unit in (
            ("largest depth", found.largest_depth, "length"),
            ("contact area", contact.area, "length squared"),
            ("total reaction", contact.reaction, "force"),
        ):
            lower, upper = rounded_outwards(*bracket, digits=6)
            yield name, f"{lower!r} to {upper!r} ({unit})"
        if contact.undecided.any() and np.isfinite(contact.free_boundary_width):
            yield "free boundary", f"within {at_most(contact.free_boundary_width)} (length) of the undecided squares"

    @property
    def headline(self) -> str:
        """What this is, and whether it is proven, in a few words."""
        words = "proven of the continuum itself" if self.proven else "computed of the continuum, not proven"
        return f"Continuum({self.effort}): {words}"

    def _repr_html_(self) -> str:
        return card(self.headline, self.facts())

    def __str__(self) -> str:
        rows = [self.headline]
        rows += [folded(f"  {name:<19}{told}", 80, 21) for name, told in self._facts()]
        if not self.proven:
            rows.append(folded("  the bounds hold for the interpolants of the sampled data", 80, 2))
        return "\n".join(rows)

    def __repr__(self) -> str:
        known = np.isfinite(self.energy_error) or self.pointwise is None
        error = (
            f"energy_error <= {at_most(self.energy_error)}" if known else f"error_bound <= {at_most(self.error_bound)}"
        )
        return f"Continuum({self.effort!r}, {self.data}, {error})"


def _meaning(name: str) -> str:
    quantity, end = name.split("_")
    return f"proven {end} bound of the membrane's {quantity}"
