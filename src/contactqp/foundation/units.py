"""Units: numbers that bring one are checked and converted to the unit that a model has been told."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from .loading import needed
from .text import shortened

INSTALL = "contactqp[units]"

_PARTS = {
    "length": (1, 0),
    "length squared": (2, 0),
    "force": (0, 1),
    "force per length": (-1, 1),
    "force per area": (-2, 1),
    "force per length and length": (-2, 1),
    "force per area and length": (-3, 1),
    "force times length": (1, 1),
    "force times length squared": (2, 1),
    "1": (0, 0),
}
"""Quantities as powers of length and force."""


def checked_units(units: Any) -> dict[str, str]:
    """Return units by ``"length"`` and ``"force"``, given as such, or as the unit of length alone.

    Units are free text: names for labels and files, as people write them (``"m"``, ``"Å"``, ``"pixel"``). What a name
    means is asked, of pint, only where a value brings a unit of its own, which must then be converted.

    Examples
    --------
    >>> checked_units("m"), checked_units({"length": "m", "force": "kN"}), checked_units(None)
    ({'length': 'm'}, {'length': 'm', 'force': 'kN'}, {})
    >>> checked_units({"mass": "kg"})
    Traceback (most recent call last):
    ...
    ValueError: units must be of 'length' and 'force', got 'mass'
    """
    if units is None or units == "":
        return {}
    told = {"length": units} if isinstance(units, str) else units
    if not isinstance(told, Mapping):
        raise TypeError(f"units must be a unit of length, or a mapping of 'length' and 'force', got {units!r}")
    for name, unit in told.items():
        if name not in ("length", "force"):
            raise ValueError(f"units must be of 'length' and 'force', got {name!r}")
        if not isinstance(unit, str):
            raise TypeError(f"units[{name!r}] must be text, as 'm' or 'kN', got {unit!r}")
    return dict(told)


def unit_of(quantity: str, units: Mapping[str, str]) -> str:
    """Return the unit of a quantity as CF writes it, ``""`` where it is not known.

    Examples
    --------
    >>> unit_of("force per area", {"length": "m", "force": "kN"}), unit_of("force", {"length": "m"})
    ('kN m-2', '')
    """
    length, force = _PARTS.get(quantity, (0, 0))
    if (length and "length" not in units) or (force and "force" not in units) or not (length or force):
        return ""
    parts = [units["force"]] if force else []
    if length:
        parts.append(units["length"] + ("" if length == 1 else str(length)))
    return " ".join(parts)


def is_quantity(value: Any) -> bool:
    """Whether a value is a number or an array with a unit, as pint has them."""
    return hasattr(value, "magnitude") and hasattr(value, "units") and hasattr(value, "to")


def plain(value: Any, name: str, quantity: str, units: Mapping[str, str]) -> Any:
    """Return a value without its unit, as a number or an array in a model's unit; what has none as it is.

    Parameters
    ----------
    value : object
        A pint quantity, or an array, a series or a table whose ``attrs["units"]`` tells its unit.
    name : str
        The argument's name, for messages.
    quantity : str
        What it must be: length, force, force per length, or force per area.
    units : mapping of str to str
        The model's units of length and force.

    Raises
    ------
    ValueError
        If it is another quantity, or has a unit while the model has been told none.
    ImportError
        If units must be compared and pint is not installed.

    Examples
    --------
    >>> import pint
    >>> plain(pint.Quantity(300.0, "N/m**2"), "load", "force per area", {"length": "m", "force": "kN"})
    0.3
    """
    if is_quantity(value):
        wanted = unit_of(quantity, units)
        if not wanted:
            raise ValueError(
                f"{name} has the unit {value.units:~}, and the model has not been told its own: say "
                "units={'length': 'm', 'force': 'kN'}, or whichever the other numbers are in"
            )
        return _converted(value, name, quantity, wanted)
    told = getattr(value, "attrs", None)
    text = str(told.get("units", "")).strip() if isinstance(told, Mapping) else ""
    if not text or text == unit_of(quantity, units) or text == quantity:
        return _same_as_places(value, name, quantity, units, text)
    if text in _PARTS:
        raise ValueError(f"{name} must be a {quantity}, but its units say {text}")
    wanted = unit_of(quantity, units)
    if not wanted:
        _check_kind(text, name, quantity)
        return _same_as_places(value, name, quantity, units, text)
    pint = needed("pint", f"{name}, whose units are {text!r} and not {wanted!r},", INSTALL)
    factor = _converted(_parsed(pint, text, name), name, quantity, wanted)
    return value if factor == 1 else value * factor


def _same_as_places(value: Any, name: str, quantity: str, units: Mapping[str, str], text: str) -> Any:
    """Return a value, if it is no length in another unit than the places that it comes with."""
    if quantity != "length" or units or not text:
        return value
    for axis in ("x", "y"):
        places = getattr(value, "coords", {})
        other = str(places[axis].attrs.get("units", "")) if axis in places else ""
        if other not in ("", "length", text):
            raise ValueError(
                f"{name} is in {text} and its {axis} in {other}; bring them to one unit, or say units={{'length': "
                f"{other!r}}}: it is then converted"
            )
    return value


def _check_kind(text: str, name: str, quantity: str) -> None:
    """Refuse a unit of another quantity, where pint is there to tell; the numbers are taken as they are."""
    try:
        pint = needed("pint", name)
    except ImportError:
        return
    found = _parsed(pint, text, name)
    _converted(found, name, quantity, unit_of(quantity, {"length": "m", "force": "N"}))


def _parsed(pint: Any, text: str, name: str) -> Any:
    """Return the quantity of 1 of a unit that is written as pint or as CF writes it (``kN m-2``)."""
    try:
        return pint.Quantity(1.0, _as_pint_writes(text))
    except Exception as error:  # of a text that is no unit pint may say anything
        raise ValueError(f"{name} has the units {shortened(repr(text), 60)}, which are none: {error}") from None


def _converted(value: Any, name: str, quantity: str, wanted: str) -> Any:
    pint = needed("pint", f"{name}, which has a unit,", INSTALL)
    try:
        return value.to(value._REGISTRY.Unit(_as_pint_writes(wanted))).magnitude  # a registry knows its own units only
    except pint.DimensionalityError:
        raise ValueError(f"{name} must be a {quantity} ({wanted}), but its unit is {value.units:~}") from None


def _as_pint_writes(text: str) -> str:
    """Return a unit as CF writes it with powers as pint reads them: ``kN m**-2``."""
    return re.sub(r"(?<=[A-Za-z])([-+]?\d+)", r"**\1", text)
