"""Fields that are known to lie between two others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .fields import is_function, of_x_and_y
from .labelled import is_dataarray


@dataclass(frozen=True, eq=False)
class Between:
    """A load, support, ceiling, frame height or tension that lies between two; `contactqp.between` makes it.

    Attributes
    ----------
    lower, upper : number, array, xarray.DataArray, function of (x, y), or profile
        The least and the greatest that it may be, given as a model takes it.
    """

    lower: Any
    upper: Any

    @property
    def middle(self) -> Any:
        """The field in the middle, by which a model stands that is made from it."""
        lower, upper = self.lower, self.upper
        if is_function(lower) or is_function(upper):
            return lambda x, y: (_at(lower, x, y) + _at(upper, x, y)) / 2
        if is_dataarray(lower) or is_dataarray(upper):
            return (lower + upper) / 2
        ends = [np.asarray(end, dtype=np.float64) if np.ndim(end) else end for end in (lower, upper)]
        return (ends[0] + ends[1]) / 2


def between(lower: Any, upper: Any) -> Between:
    """Return a field that is only known to lie between two, as ``load=between(0.9, 1.1)``.

    A model that is made from it stands for the one in the middle, and `contactqp.solve_between` encloses the answers of
    all.

    Parameters
    ----------
    lower, upper : number, array, xarray.DataArray, function of (x, y), or profile
        The least and the greatest that it may be, at every place, in the model's own sense: of heights that are
        positive downwards the lower one is the higher surface. Of profiles, which return depths, those of depths.

    Raises
    ------
    ValueError
        If both are numbers, and the lower one is the greater.

    Examples
    --------
    >>> import contactqp as cq
    >>> load = cq.between(0.9, 1.1)
    >>> load.middle
    1.0
    """
    if not any(is_function(end) or np.ndim(end) for end in (lower, upper)) and lower > upper:
        raise ValueError(f"between(lower, upper) must have lower <= upper, got {lower!r} and {upper!r}")
    return Between(lower, upper)


def middle_of(field: Any) -> Any:
    """Return the middle of what lies between two fields, and any other field as it is."""
    return field.middle if isinstance(field, Between) else field


def _at(field: Any, x: Any, y: Any) -> Any:
    return of_x_and_y(field)(x, y) if callable(field) else field
