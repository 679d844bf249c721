"""Checks of options, declared where an option is named: in the annotations of a backend's signature.

``rho: Positive = 3.0`` is a positive number, ``eps: Positive | None = None`` that or None,
``method: Literal["a", "b"] = "a"`` one of these words, and ``history: bool = False`` True or False.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin, get_type_hints

from ..foundation.checks import boolean, finite_number, integer_at_least, one_of, open_interval, positive_number


@dataclass(frozen=True)
class Check:
    """What stands in an annotation: ``call(value, name)`` raises a TypeError or ValueError unless the value will do."""

    call: Callable[[Any, str], object]


_PLAIN: Mapping[Any, Callable[[Any, str], object]] = {
    bool: boolean,
    int: lambda value, name: integer_at_least(value, -sys.maxsize, name),
    float: finite_number,
}
"""The checks of annotations that say no more than a kind."""

Positive: TypeAlias = Annotated[float, Check(positive_number)]


def _named_settings(value: Any, name: str) -> None:
    """Raise a TypeError unless a value maps names to settings."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise TypeError(f"{name} must map names of the solver's own settings to values, got {value!r}")


def _plain_settings(value: Any, name: str) -> None:
    """Raise an error unless a value maps names without a dash to texts and numbers, or to None."""
    _named_settings(value, name)
    for key, setting in value.items():
        if not key or key.startswith("-"):
            raise ValueError(f"{name} must have names without a dash, got {key!r}")
        if not isinstance(setting, (str, bool, int, float, NoneType)):
            raise TypeError(f"{name} must have texts, numbers or None as values, but {key!r} is {setting!r}")


Settings: TypeAlias = Annotated[Mapping[str, Any], Check(_named_settings)]
"""Settings of a solver, by its own names."""

PlainSettings: TypeAlias = Annotated[Mapping[str, str | float | None], Check(_plain_settings)]
"""Settings that can be written as words: an option's name, and its value, or None where it has none."""


def between(low: float, high: float) -> Check:
    """Return the check of a number strictly between two others."""
    return Check(lambda value, name: open_interval(value, low, high, name))


def check_values(declared: Callable[..., Any], options: Mapping[str, Any]) -> None:
    """Check options one after the other, in the order in which they are given.

    Parameters
    ----------
    declared : callable
        In whose signature they are annotated; options without an annotation pass.
    options : mapping of str to object

    Raises
    ------
    TypeError, ValueError
        If one has the wrong kind or range.

    Examples
    --------
    >>> def prepare(rho: Positive = 3.0, how: Literal["well", "fast"] | None = None): ...
    >>> check_values(prepare, {"rho": 1.0, "how": None})
    >>> check_values(prepare, {"rho": -1.0})
    Traceback (most recent call last):
    ValueError: rho must be > 0, got -1
    >>> check_values(prepare, {"how": "fats"})
    Traceback (most recent call last):
    ValueError: how must be one of 'well', 'fast', got 'fats'; did you mean 'fast'?
    >>> check_values(lambda *, history: 0, {"history": 1})  # nothing is annotated
    >>> def solve(*, history: bool = False): ...
    >>> check_values(solve, {"history": 1})
    Traceback (most recent call last):
    TypeError: history must be True or False, got 1
    """
    hints = _hints(declared)
    for name, value in options.items():
        _check(value, hints.get(name), name)


@cache
def _hints(declared: Callable[..., Any]) -> dict[str, Any]:
    try:
        return get_type_hints(declared, include_extras=True)
    except (NameError, TypeError):  # another distribution's may be known to its type checker only
        return {}


def _check(value: Any, hint: Any, name: str) -> None:
    """Check one value by what its annotation says of it."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType) and NoneType in parts:
        others = [part for part in parts if part is not NoneType]
        if value is not None and len(others) == 1:
            _check(value, others[0], name)
    elif origin is Literal:
        one_of(value, parts, name)
    elif hint in _PLAIN:
        _PLAIN[hint](value, name)
    elif origin is Annotated:
        for check in parts[1:]:
            if isinstance(check, Check):
                check.call(value, name)
