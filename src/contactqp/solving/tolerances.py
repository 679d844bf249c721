"""Tolerance levels by name, and the libraries' own defaults, so that a table of results can name its setting."""

from __future__ import annotations

from dataclasses import dataclass

from ..foundation.checks import nearest, one_of, open_interval

LEVELS = {"low": 1e-3, "mid": 1e-6, "high": 1e-9}
"""Named tolerances, as benchmarks of QP solvers name their settings."""

OWN_DEFAULTS = "default"
"""The setting in which each library runs once, as its authors ship it."""

_LEVEL_NAMES = (*LEVELS, OWN_DEFAULTS)

DEFAULT_TOL = 1e-6
"""What every answer is judged by if nothing else is asked for."""


@dataclass(frozen=True)
class Tolerance:
    """What an answer is asked for.

    Attributes
    ----------
    tol : float
        Wanted bound of max|ω_i - ω*_i| relative to the error scale, see `contactqp.solve`.
    setting : str
        The name that it was asked for by, ``""`` for a number.
    """

    tol: float
    setting: str = ""

    @property
    def own_defaults(self) -> bool:
        """Whether each library is to run once with its own default settings."""
        return self.setting == OWN_DEFAULTS

    def __str__(self) -> str:
        return f"{self.tol:g}" + (f" ({self.setting})" if self.setting else "")


def level_of(value: object, name: str) -> str:
    """Return the name of a level, which ``name`` holds.

    Examples
    --------
    >>> level_of("mdi", "levels")
    Traceback (most recent call last):
    ...
    ValueError: levels must be one of 'low', 'mid', 'high', 'default', got 'mdi'; did you mean 'mid'?
    """
    return one_of(value, _LEVEL_NAMES, name)


def tolerance_of(value: object) -> Tolerance:
    """Return the `Tolerance` that a number or the name of a level stands for.

    Parameters
    ----------
    value : float or str
        A number in (0, 1), ``"low"`` (1e-3), ``"mid"`` (1e-6), ``"high"`` (1e-9), or ``"default"``: each library runs
        once as its authors ship it, and is judged by 1e-6.

    Raises
    ------
    TypeError, ValueError
        If it is neither; the message lists the levels.

    Examples
    --------
    >>> tolerance_of("high").tol
    1e-09
    >>> tolerance_of(1e-4)
    Tolerance(tol=0.0001, setting='')
    """
    if not isinstance(value, str):
        return Tolerance(open_interval(value, 0.0, 1.0, "tol"))
    if value not in _LEVEL_NAMES:
        listed, meant = ", ".join(map(repr, _LEVEL_NAMES)), nearest(value, _LEVEL_NAMES)
        raise ValueError(f"tol must be a number in (0, 1) or one of {listed}, got {value!r}{meant}")
    return Tolerance(LEVELS.get(value, DEFAULT_TOL), value)
