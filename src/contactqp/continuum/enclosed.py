"""What is proven of a model's continuous counterpart by an answer, whichever kind of model it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Vector, read_only
from ..geometry.numbering import Grid
from ..models.base import ContactModel
from ..models.cable import Cable
from ..models.membrane import Membrane
from .data import Data
from .energy import EnergyBounds, energy_bounds
from .frame_room import require_room
from .line import Line, cable_heights
from .line_energy import cable_energy
from .membrane import membrane_bounds
from .result import EXACT, SAMPLED, Continuum, NodalBounds

_LARGEST = 1e70


def continuum_of(
    model: ContactModel, gap: Vector, effort: str, resolve: Callable[[Vector], Vector] | None = None
) -> Continuum:
    """Return what an answer proves of the membrane that a model stands for.

    Parameters
    ----------
    model : Membrane or Cable
    gap : array, shape (n,)
        Length.
    effort : {"energy", "pointwise"}
    resolve : callable, optional
        For ``"pointwise"``, see `contactqp.continuum.membrane.membrane_bounds`.

    Raises
    ------
    TypeError, ValueError
        See `Solution.continuum`.
    """
    _require_spacing(model)
    data: Data | Line
    heights = pointwise = None
    if isinstance(model, Cable):
        data = Line(model)
        below = model.padded_below(gap)[1, 1:-1]
        found = _within_doubles(model, cable_energy(data, below))
        bounds = cable_heights(data, below)
        heights = None if bounds is None else _at_nodes(model, gap, *bounds)
    elif isinstance(model, Membrane):
        data = Data.of(model)
        require_room(data)
        depths = model.padded_below(gap)
        found = _energy(data, depths, only=resolve is None)
        pointwise = None if resolve is None else membrane_bounds(data, depths, gap, resolve)
    else:
        raise TypeError(f"the continuous counterpart of a Membrane or a Cable can be enclosed, not that of {model!r}")
    return Continuum(
        model=model,
        effort=effort,
        data=SAMPLED if data.sampled else EXACT,
        energy=found.energy,
        energy_error=found.error,
        energy_norm=found.norm,
        contact_error=found.contact_error,
        sampled=data.sampled,
        pointwise=pointwise,
        at_nodes=heights,
    )


def _energy(data: Data, depths: Grid, *, only: bool) -> EnergyBounds:
    """Return what is proven of a membrane's energy: nothing in a frame that cuts squares, if more was asked for."""
    if not data.plan.on_lattice:
        if only:
            raise ValueError(
                f"{data.model.lattice!r}: its contour cuts squares anywhere, and energies are bounded only of frames "
                "that run along lines of the lattice, or diagonals of its squares; effort='pointwise' encloses the "
                "membrane in this one"
            )
        return EnergyBounds(Bracket(-np.inf, np.inf), np.inf, np.inf, np.nan)
    return _within_doubles(data.model, energy_bounds(data, depths))


def _require_spacing(model: ContactModel) -> None:
    """Refuse a lattice in units in which fourth powers of its spacing are no doubles, on which bounds depend."""
    if isinstance(model, Cable | Membrane):
        spacing = model.lattice.spacing
        if not 1 / _LARGEST <= spacing <= _LARGEST:
            raise ValueError(
                f"{model!r}: the squares of lengths in the unit of its spacing, {spacing:.3g}, are hardly doubles, and "
                f"nothing can be proven; take a unit of length in which it lies between {1 / _LARGEST:g} and "
                f"{_LARGEST:g}"
            )


def _within_doubles(model: ContactModel, found: EnergyBounds) -> EnergyBounds:
    """Return bounds of an energy that is a double, refuse others."""
    if not np.isfinite(found.norm):
        raise ValueError(
            f"{model!r}: the energy of the answer is larger than the largest double, and has no bounds; take units in "
            "which its tension and its heights are smaller"
        )
    return found


def _at_nodes(model: ContactModel, gap: Vector, lower: Vector, upper: Vector) -> NodalBounds:
    """Return bounds of depths as those of deflections, and how far they are from an answer at most."""
    if model.upwards:
        lower, upper = -upper, -lower
    own = model.deflection(gap)
    error = float(np.maximum(upper - own, own - lower).max())
    return NodalBounds(read_only(lower), read_only(upper), float(np.nextafter(error, np.inf)))
