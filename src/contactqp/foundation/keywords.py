"""Arguments by name: what is said of those that do not exist, and of those that were given by position."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, TypeVar

from .checks import nearest

Function = TypeVar("Function", bound=Callable[..., Any])


def known_by_name(function: Function) -> Function:
    """Let a method refuse a keyword that it does not have with the name that was probably meant."""
    known = [*signature(function).parameters][1:]
    method = "" if function.__name__ == "__init__" else f".{function.__name__}"

    @wraps(function)
    def call(self: Any, *arguments: Any, **keywords: Any) -> Any:
        for name in keywords:
            if name not in known:
                kind = f"{type(self).__name__}{method}"
                raise TypeError(f"{kind} has no argument {name!r}{nearest(name, known)}; it has {', '.join(known)}")
        return function(self, *arguments, **keywords)

    return call  # type: ignore[return-value]


def by_name_after(kept: int, *names: str) -> Callable[[Function], Function]:
    """Return a decorator of an ``__init__`` whose arguments after the first few are keywords.

    Whoever gives them by position is warned, with the call spelled out that says the same.

    Parameters
    ----------
    kept : int
        How many arguments may stand without a name, ``self`` not counted.
    *names : str
        Names of the others, in the order in which they used to be taken.
    """

    def decorate(function: Function) -> Function:
        @wraps(function)
        def call(self: Any, *arguments: Any, **keywords: Any) -> Any:
            given = arguments[kept:]
            if not given:
                return function(self, *arguments, **keywords)
            if len(given) > len(names):
                most = kept + len(names)
                raise TypeError(f"{type(self).__name__} takes at most {most} arguments, got {len(arguments)}")
            named = dict(zip(names, given, strict=False))
            for name in named:
                if name in keywords:
                    raise TypeError(f"{type(self).__name__} got two values for {name}")
            spelled = ", ".join(["..."] * min(kept, 1) + [f"{name}={_short(value)}" for name, value in named.items()])
            warnings.warn(
                f"{' and '.join(named)} should be given by name, as they are easily swapped: write "
                f"{type(self).__name__}({spelled})",
                DeprecationWarning,
                stacklevel=2,
            )
            return function(self, *arguments[:kept], **named, **keywords)

        return call  # type: ignore[return-value]

    return decorate


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, (int, float)) else "..."
