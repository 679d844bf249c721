"""What is proven of a model's continuous counterpart by an answer, whichever kind of model it is."""

from __future__ import annotations

from collections.abc import Callable

from ..foundation.checks import Vector
from ..models.base import ContactModel
from ..models.membrane import Membrane
from .data import Data
from .energy import energy_bounds
from .membrane import membrane_bounds
from .result import EXACT, SAMPLED, Continuum


def continuum_of(
    model: ContactModel, gap: Vector, effort: str, resolve: Callable[[Vector], Vector] | None = None
) -> Continuum:
    """Return what an answer proves of the membrane that a model stands for.

    Parameters
    ----------
    model : Membrane
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
    if not isinstance(model, Membrane):
        raise TypeError(f"the continuous counterpart of a Membrane can be enclosed, not that of {model!r}")
    data = Data.of(model)
    depths = model.padded_below(gap)
    found = energy_bounds(data, depths)
    return Continuum(
        effort=effort,
        data=SAMPLED if data.sampled else EXACT,
        energy=found.energy,
        energy_error=found.error,
        energy_norm=found.norm,
        contact_error=found.contact_error,
        sampled=data.sampled,
        pointwise=None if resolve is None else membrane_bounds(data, depths, gap, resolve),
    )
