"""What is proven of a model's continuous counterpart by an answer, whichever kind of model it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..foundation.checks import Vector, read_only
from ..models.base import ContactModel
from ..models.cable import Cable
from ..models.membrane import Membrane
from .data import Data
from .energy import energy_bounds
from .line import Line, cable_energy, cable_heights
from .membrane import membrane_bounds
from .result import EXACT, SAMPLED, Continuum, NodalBounds


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
    data: Data | Line
    heights = pointwise = None
    if isinstance(model, Cable):
        data = Line(model)
        below = model.padded_below(gap)[1, 1:-1]
        found, bounds = cable_energy(data, below), cable_heights(data, below)
        heights = None if bounds is None else _at_nodes(model, gap, *bounds)
    elif isinstance(model, Membrane):
        data = Data.of(model)
        depths = model.padded_below(gap)
        found = energy_bounds(data, depths)
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


def _at_nodes(model: ContactModel, gap: Vector, lower: Vector, upper: Vector) -> NodalBounds:
    """Return bounds of depths as those of deflections, and how far they are from an answer at most."""
    if model.upwards:
        lower, upper = -upper, -lower
    own = model.deflection(gap)
    error = float(np.maximum(upper - own, own - lower).max())
    return NodalBounds(read_only(lower), read_only(upper), float(np.nextafter(error, np.inf)))
