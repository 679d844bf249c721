"""Pictures that objects can be asked for, although what draws them stands on a floor above theirs.

`contactqp.plotting` registers how each kind of object is drawn, when the package is imported.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import singledispatch
from typing import Any, TypeAlias

UnitNames: TypeAlias = str | Mapping[str, str]

_FORCE = "force"


@dataclass(frozen=True)
class Wanted:
    """How a picture is wanted.

    Attributes
    ----------
    ax : Axes or None
        The axes to draw into, which are those of the user's own figure; by default a new figure is made.
    section : float or None
        Ordinate y of the section (length); the row of nodes nearest to it is drawn. By default the middle one.
    title : str or None
        Headline in place of the own one; an empty one is none.
    units : str or mapping of str to str
        Unit of length, or units by ``"length"`` and ``"force"``, that axes are labelled with.
    """

    ax: Any = None
    section: float | None = None
    title: str | None = None
    units: UnitNames = ""

    def __post_init__(self) -> None:
        """Refuse what are no axes, and units of other quantities."""
        if self.ax is not None and not hasattr(self.ax, "get_figure"):
            raise TypeError(f"ax must be axes of matplotlib, got {self.ax!r}; plot().savefig(path) writes a file")
        if isinstance(self.units, str):
            return
        for name in self.units:
            if name not in ("length", _FORCE):
                raise ValueError(f"units must be of 'length' and 'force', got {name!r}")

    def unit(self, quantity: str) -> str:
        """Return the unit of a quantity in symbols, ``""`` where none is known.

        Parameters
        ----------
        quantity : str
            ``"length"``, ``"force"``, ``"force times length"``, ``"force per length"`` or ``"force per area"``.

        Examples
        --------
        >>> Wanted(units={"length": "m", "force": "kN"}).unit("force per area")
        'kN/m²'
        >>> Wanted(units="mm").unit("length"), Wanted(units="mm").unit("force")
        ('mm', '')
        """
        known = {"length": self.units} if isinstance(self.units, str) else self.units
        length, force = known.get("length", ""), known.get(_FORCE, "")
        if quantity == "length":
            return length
        if quantity == _FORCE:
            return force
        if quantity == "force times length":
            return f"{force} {length}" if length and force else ""
        power = {"force per length": "", "force per area": "²"}.get(quantity)
        return f"{force}/{length}{power}" if length and force and power is not None else ""

    def label(self, text: str, quantity: str = "length") -> str:
        """Return an axis' label with its unit, where that is known."""
        unit = self.unit(quantity)
        return f"{text} ({unit})" if unit else text


PLAIN = Wanted()
"""A picture as it comes."""


@singledispatch
def drawn(subject: Any, wanted: Wanted) -> Any:
    """Return a picture of an object, a matplotlib.figure.Figure."""
    raise TypeError(f"there is no picture of a {type(subject).__name__}")


@singledispatch
def drawn_in_space(subject: Any, wanted: Wanted) -> Any:
    """Return a picture of an object in space, a matplotlib.figure.Figure."""
    raise TypeError(f"there is no picture in space of a {type(subject).__name__}; use plot()")
