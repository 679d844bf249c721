"""Models that differ in one parameter: the proportional load, the tension, or the height of the support."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import copy
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from ..foundation.checks import Mask, Vector, finite_number, positive_number, read_only, times
from .base import ContactModel

Model = TypeVar("Model", bound=ContactModel)


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
    return with_load_of(model, times(model.load, finite_number(factor, "load factor")))


def with_load_of(model: Model, load: Any) -> Model:
    """Return the model under another load at its nodes, shape (n,), in the unit of its own."""
    model._shared_pull = pull = model._pull_of_reference()
    varied = _copied(model, "load")
    varied.load = load
    if np.array_equal(varied.supported, model.supported):
        if np.array_equal(varied.under_ceiling, model.under_ceiling):
            varied._relative = model.problem
        varied._shared_pull = pull
    return varied


def with_tension(model: Model, tension: float) -> Model:
    """Return a membrane or a cable under another tension, > 0; other models raise a TypeError.

    Where the model's tension varies, or is not the same along x and along y, it is multiplied by ``tension``.
    """
    varied = _copied(model, "tension")
    varied._take_tension(positive_number(tension, "tension"))
    return varied


def with_foundation(model: Model, foundation: Any) -> Model:
    """Return the model on a foundation of another stiffness at its nodes, shape (n,), in the unit of its own."""
    varied = _copied(model, "foundation")
    varied._take_foundation(read_only(np.asarray(foundation, dtype=np.float64)))
    return varied


def with_lift(model: Model, lift: float) -> Model:
    """Return the model whose support is higher by ``lift`` (length), whichever way its heights are positive.

    A ceiling stays where it is; a ValueError tells where the support would be lifted above it.
    """
    rise = finite_number(lift, "lift")
    return _over(model, read_only(model.support + (rise if model.upwards else -rise)), model.unreachable)


def with_support(model: Model, support: Any) -> Model:
    """Return the model over another support at its nodes, shape (n,), length, positive as the model's own."""
    return _over(model, support, None)


def reachable(model: Model, variations: Iterable[Model]) -> Model:
    """Return the model with a support wherever it has one that a variation of it may touch.

    Parameters
    ----------
    model : Membrane, Cable or CableNet
    variations : iterable of such
        The model under other loads, tensions or lifts.
    """
    unreachable = model.unreachable
    if not unreachable.any():
        return model
    for variation in variations:
        unreachable = unreachable & variation.unreachable
    held = _copied(model)
    held._known_unreachable = read_only(unreachable)
    return held


def admissible(model: ContactModel, depths: Vector) -> Vector:
    """Return the depths nearest to some (length), shape (n,), that neither support nor ceiling forbids."""
    above = -np.inf if model.ceiling_depth is None else model.ceiling_depth
    return np.asarray(np.clip(depths, above, model.depth))


def depths_at_rest(model: ContactModel) -> Vector:
    """Return the depths of a model that lies in the mean plane of its frame, as far as support and ceiling let it."""
    return admissible(model, np.full(model.size, model._datum))


def _over(model: Model, support: Any, known_unreachable: Mask | None) -> Model:
    model._refuse_crossing(support, model.ceiling)
    varied = _copied(model, "support")
    varied.support, varied._known_unreachable = support, known_unreachable
    # Under a ceiling the way up to it is another one.
    if not (model.under_ceiling.any() or varied.under_ceiling.any()):
        if np.array_equal(varied.supported, model.supported):
            varied._relative = model.problem
    else:
        varied._alike = model.problem
    return varied


def _copied(model: Model, changes: str = "") -> Model:
    """Return a copy without anything that was derived from the data, by this class or a user's subclass of it.

    Of data that it ``changes`` only the values at the nodes are known.
    """
    varied = copy(model)
    varied.given = MappingProxyType({name: field for name, field in model.given.items() if name != changes})
    for kind in type(model).__mro__:
        for name, attribute in vars(kind).items():
            if isinstance(attribute, cached_property):
                varied.__dict__.pop(name, None)
    varied._relative = varied._alike = varied._shared_pull = None
    varied._known_unreachable = model.unreachable
    return varied


VARIED: dict[str, Callable[[Any, float], Any]] = {"load": with_load, "tension": with_tension, "lift": with_lift}
"""What varies a model, by the name of the parameter."""
