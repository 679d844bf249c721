"""A study as the table that papers print, eighty columns wide."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

from .errors import AT_NODES

if TYPE_CHECKING:
    from .errors import Errors

_WIDTH = 80
_COLUMNS = {"deflection": ("deflection", 11), "reaction": ("reaction", 10), "contact_area": ("area", 10)}
_COLUMNS |= {"free_boundary": ("boundary", 10)}

_LEGEND = {
    "deflection": "largest error (length)",
    "reaction": "sum of moduli, of the whole",
    "contact_area": "in contact, of it",
    "free_boundary": "largest distance from the free boundary (length)",
}


def study_text(study: Errors) -> str:
    """Return title, source, a line for each spacing, the orders over all of them, and what the columns are."""
    shown = [name for name in _COLUMNS if any(math.isfinite(getattr(row, name)) for row in study.rows)]
    orders = {name: (math.nan, *study.orders(name)) for name in shown}
    lines = [*textwrap.wrap(f"{study.name}: {study.title}", _WIDTH)]
    lines += [*textwrap.wrap(study.source, _WIDTH), ""]
    heads = "".join(f"{_COLUMNS[name][0]:>{_COLUMNS[name][1]}} order" for name in shown)
    lines.append(f"{'n':>5}{'spacing':>9}{heads}")
    for k, row in enumerate(study.rows):
        cells = "".join(_error(getattr(row, name), _COLUMNS[name][1]) + _order(orders[name][k]) for name in shown)
        status = "" if row.status == "certified" else f" {row.status}"
        lines.append(f"{row.n:>5}{row.spacing:>9.4f}{cells}".rstrip() + status)
    overall = [study.order(name) for name in shown]
    if any(map(math.isfinite, overall)):
        cells = "".join(" " * _COLUMNS[name][1] + _order(order) for name, order in zip(shown, overall, strict=True))
        lines.append(f"{'all':>5}{'':>9}{cells}".rstrip())
    lines.append("")
    lines += textwrap.wrap(_exactness(study, shown), _WIDTH)
    told = "; ".join(f"{_COLUMNS[name][0]}: {_LEGEND[name]}" for name in shown)
    return "\n".join(lines + textwrap.wrap(told, _WIDTH))


def _exactness(study: Errors, shown: list[str]) -> str:
    """Return what is exact, and what is not for all that; nothing where nothing is."""
    exact = [str(row.n) for row in study.rows if row.exact]
    if not exact:
        return ""
    where = "" if study.exact else f" of n = {', '.join(exact)}"
    at_nodes = " and ".join(_COLUMNS[name][0] for name in shown if name in AT_NODES)
    told = f"At the nodes{where} the discrete answer is the continuous one: errors of {at_nodes} are rounding."
    between = " and ".join(_COLUMNS[name][0] for name in shown if name not in AT_NODES)
    return (
        f"{told} Where contact ends between two nodes no discrete answer tells; hence {between}." if between else told
    )


def _error(value: float, width: int) -> str:
    return f"{value:>{width}.2e}" if math.isfinite(value) else f"{'-':>{width}}"


def _order(value: float) -> str:
    """Return an order in six columns, the first of them blank: large ones have fewer decimals."""
    decimals = 2 if abs(value) < 9.995 else 1 if abs(value) < 99.95 else 0
    value = round(value, decimals) + 0.0 if math.isfinite(value) else value  # no minus before zero
    return f"{value:>6.{decimals}f}" if math.isfinite(value) else " " * 6
