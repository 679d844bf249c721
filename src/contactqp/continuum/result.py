"""Continuum: what is proven of the membrane itself by an answer of its lattice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Vector
from ..foundation.loading import load_modules
from ..foundation.pictures import UnitNames, Wanted
from ..foundation.text import at_most, folded, rounded_outwards
from ..plotting.of_squares import map_of_squares
from .contact import ContactBounds
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
        from the membrane (square root of force times length).
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
      potential energy   -0.01358923 to -0.01355716 (force times length)
      energy-norm error  <= 0.0081, 7 % of the norm
      contact error      <= 3.3e-05 (force times length)
    """

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
        share = contact.undecided.sum() / sum(state.sum() for state in states)
        own = f"the membrane itself: all is decided but for {at_most(100 * share)} % of the area"
        return map_of_squares(found.edges, states, Wanted(ax, None, title, units), own)

    def to_dataset(self) -> xr.Dataset:
        """Return the bounds as an xarray.Dataset: on the lattice's nodes by x and y, in squares by x_square, y_square.

        Variables: lower and upper (of the deflection), gap_lower, gap_upper, gap_lower_in_squares,
        gap_upper_in_squares, and contact_state of the squares (1 certainly in contact, 0 certainly clear, -1 undecided,
        -9 outside); what is one number stands in the attributes. Needs effort="pointwise".

        Returns
        -------
        xarray.Dataset
        """
        load_modules("xarray")
        import xarray as xr

        found = self._at_points("to_dataset")
        x, y = found.edges
        squares = {"x_square": (x[1:] + x[:-1]) / 2, "y_square": (y[1:] + y[:-1]) / 2}
        in_squares = ("y_square", "x_square")
        contact = found.contact
        state = np.where(contact.contact, 1, np.where(contact.clear, 0, np.where(contact.undecided, -1, -9)))
        nodal = {"lower": found.lower, "upper": found.upper, "gap_lower": found.gap_lower, "gap_upper": found.gap_upper}
        fields = {name: (("y", "x"), found.lattice.scatter(values)) for name, values in nodal.items()}
        fields["gap_lower_in_squares"] = (in_squares, found.gap_lower_in_cells)
        fields["gap_upper_in_squares"] = (in_squares, found.gap_upper_in_cells)
        attributes = {
            "data": self.data,
            "error_bound": found.error_bound,
            "contact_area": list(contact.area),
            "total_reaction": list(contact.reaction),
            "largest_depth": list(found.largest_depth),
            "free_boundary_width": contact.free_boundary_width,
            "potential_energy": list(self.energy),
            "energy_error": self.energy_error,
        }
        places = {"x": found.lattice.x, "y": found.lattice.y, **squares}
        return xr.Dataset(fields | {"contact_state": (in_squares, state)}, places, attributes)

    def _at_nodes(self, name: str) -> MembraneBounds | NodalBounds:
        return self._at_points(name) if self.at_nodes is None else self.at_nodes

    def _at_points(self, name: str) -> MembraneBounds:
        if self.pointwise is None:
            raise AttributeError(f"{name} needs solution.continuum(effort='pointwise'), this is {self.effort!r}")
        return self.pointwise

    def _facts(self) -> Iterator[tuple[str, str]]:
        lower, upper = rounded_outwards(*self.energy, digits=7)
        yield "data", self.data + (f": {', '.join(self.sampled)}" if self.sampled else "")
        yield "potential energy", f"{lower!r} to {upper!r} (force times length)"
        share = f", {at_most(100 * self.relative_energy_error)} % of the norm" if self.energy_norm else ""
        yield "energy-norm error", f"<= {at_most(self.energy_error)}{share}"
        if self.at_nodes is not None:
            yield "error at nodes", f"<= {at_most(self.at_nodes.error_bound)} (length)"
        yield "contact error", f"<= {at_most(self.contact_error)} (force times length)"
        if self.pointwise is not None:
            yield from self._facts_at_points(self.pointwise)

    @staticmethod
    def _facts_at_points(found: MembraneBounds) -> Iterator[tuple[str, str]]:
        yield "error at nodes", f"<= {at_most(found.error_bound)} (length)"
        contact = found.contact
        for name, bracket, unit in (
            ("largest depth", found.largest_depth, "length"),
            ("contact area", contact.area, "length squared"),
            ("total reaction", contact.reaction, "force"),
        ):
            lower, upper = rounded_outwards(*bracket, digits=6)
            yield name, f"{lower!r} to {upper!r} ({unit})"
        if np.isfinite(contact.free_boundary_width):
            yield "free boundary", f"within {at_most(contact.free_boundary_width)} (length) of the undecided squares"

    def __str__(self) -> str:
        words = "proven of the continuum itself" if self.proven else "computed of the continuum, not proven"
        rows = [f"Continuum({self.effort}): {words}"]
        rows += [folded(f"  {name:<19}{told}", 80, 21) for name, told in self._facts()]
        if not self.proven:
            rows.append(folded("  the bounds hold for the interpolants of the sampled data", 80, 2))
        return "\n".join(rows)

    def __repr__(self) -> str:
        return f"Continuum({self.effort!r}, {self.data}, energy_error <= {at_most(self.energy_error)})"
