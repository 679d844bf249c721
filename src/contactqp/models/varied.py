"""Models that differ in one parameter: the proportional load, the tension, or the height of the support."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any, TypeVar

from ..foundation.checks import finite_number, positive_number, read_only, times
from .base import ContactModel
from .on_lattice import LatticeModel

Model = TypeVar("Model", bound=ContactModel)
Net = TypeVar("Net", bound=LatticeModel)


def with_load(model: Model, factor: float) -> Model:
    """Return the model under ``factor`` times its load.

    Parameters
    ----------
    model : Membrane, Cable or CableNet
    factor : float
        Of either sign.

    Examples
    --------
    >>> import contactqp as cq
    >>> float(with_load(cq.gallery.paper_hexagon(0.02), 1.5).load[0])
    0.03
    """
    varied = _copied(model)
    varied.load = times(model.load, finite_number(factor, "load factor"))
    return varied


def with_tension(model: Net, tension: float) -> Net:
    """Return a membrane or a cable under another tension, > 0."""
    if not isinstance(model, LatticeModel):
        raise TypeError(f"a tension can be given to a Membrane or a Cable only, not to {model!r}; make another net")
    varied = _copied(model)
    varied.tension = positive_number(tension, "tension")
    varied.stencil = model.stencil.scaled(varied.tension / model.tension)
    return varied


def with_lift(model: Model, lift: float) -> Model:
    """Return the model whose support is higher by ``lift`` (length), its ordinates smaller."""
    varied = _copied(model)
    varied.support = read_only(model.support - finite_number(lift, "lift"))
    return varied


def _copied(model: Model) -> Model:
    """Return a copy without what was derived from the data."""
    varied = copy(model)
    for derived in ("problem", "supported"):
        varied.__dict__.pop(derived, None)
    return varied


VARIED: dict[str, Callable[[Any, float], Any]] = {"load": with_load, "tension": with_tension, "lift": with_lift}
"""What varies a model, by the name of the parameter."""
