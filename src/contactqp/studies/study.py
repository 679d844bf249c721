"""study(): errors of discrete answers against a closed form over several spacings, and the orders that they show."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..backends.base import Backend
from ..foundation.checks import integers_at_least
from ..foundation.files import path_of, replaced_as_a_whole, require_writable
from ..foundation.json_text import json_of
from ..foundation.loading import load_modules
from ..foundation.progress import Progress
from ..gallery.catalogue import entry_of, load
from ..gallery.known import Known
from ..solving.solution import OnFailure, Solution
from ..solving.solve import solve
from .errors import QUANTITIES, Errors, StudyRow

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SUFFIXES = (".json", ".csv")
"""Of files that a study is written to."""

_TOL = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Study(Errors):
    """Errors of a problem of the gallery over several spacings, as table, file and picture; see `study`.

    Its attributes and its orders are those of `contactqp.studies.errors.Errors`: ``rows``, ``order(quantity)``,
    ``orders(quantity)``, ``certified``, ``name``, ``title``, ``source``, ``exact``, ``backend``.
    """

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each spacing: errors, and the order from the row before under ``order of ...``.

        Returns
        -------
        pandas.DataFrame
        """
        load_modules("pandas")
        import pandas as pd

        frame = pd.DataFrame([asdict(row) for row in self.rows])
        for quantity in QUANTITIES:
            place = frame.columns.get_loc(quantity)
            frame.insert(place + 1, f"order of {quantity}", [math.nan, *self.orders(quantity)])
        return frame

    def to_dict(self) -> dict[str, Any]:
        """Return everything as what JSON has: rows with their orders, and the orders over all spacings."""
        rows = [asdict(row) for row in self.rows]
        for quantity in QUANTITIES:
            for row, order in zip(rows, (math.nan, *self.orders(quantity)), strict=True):
                row[f"order_of_{quantity}"] = order
        overall = {quantity: self.order(quantity) for quantity in QUANTITIES}
        told = {"name": self.name, "title": self.title, "source": self.source, "exact": self.exact}
        return told | {"backend": self.backend, "certified": self.certified, "orders": overall, "rows": rows}

    def write(self, path: str | Path) -> Path:
        """Write the study as JSON or CSV, by the suffix, replacing a file of that name as a whole.

        Raises
        ------
        ValueError
            If the suffix is another, or the file cannot be written.
        """
        path = path_of(path)
        require_writable(path, SUFFIXES, "study")
        with replaced_as_a_whole(path) as unfinished:
            if path.suffix.lower() == ".json":
                unfinished.write_text(json_of(self.to_dict()) + "\n", encoding="utf-8")
            else:
                self.to_frame().to_csv(unfinished, index=False)
        return path

    def plot(self) -> Figure:
        """Draw all errors over the spacing, both logarithmic, with lines of first and second order beside them."""
        from .pictures import study_figure

        return study_figure(self)

    def __str__(self) -> str:
        from .text import study_text

        return study_text(self)

    def __repr__(self) -> str:
        told = ", ".join(
            f"{quantity.replace('_', ' ')} {order:.2f}"
            for quantity in QUANTITIES
            if math.isfinite(order := self.order(quantity))
        )
        orders = f"orders: {told}" if told else "no order"
        seen = f"exact to rounding at the nodes, {orders}" if self.exact else orders
        return f"Study({self.name!r}, {len(self.rows)} spacings, {seen})"


def study(
    name: str,
    sizes: Sequence[int] | int | None = None,
    *,
    backend: str | Backend = "auto",
    tol: float | str = _TOL,
    time_limit: float | None = None,
    on_failure: OnFailure = "warn",
) -> Study:
    """Solve a problem of the gallery at several spacings, and compare with its closed form.

    Parameters
    ----------
    name : str
        One of `contactqp.gallery.names`, of which a closed form is known.
    sizes : sequence of int, or int, optional
        Nodes along a side, in any order; by default four spacings, each half the one before, from the entry's own.
    backend : str or Backend
        See `contactqp.solve`.
    tol : float or str
        See `contactqp.solve`; so small that errors are those of the discretisation.
    time_limit : float, optional
        Seconds for each spacing.
    on_failure : {"warn", "raise", "ignore"}
        See `contactqp.solve`.

    Returns
    -------
    Study

    Raises
    ------
    TypeError
        If the sizes are no integers.
    ValueError
        If the name is unknown, no closed form is known, or there are no sizes, or one that the entry does not have.

    Examples
    --------
    >>> import contactqp as cq
    >>> print(cq.study("cable-on-foundation", [9, 19, 39]))
    cable-on-foundation: a cable on springs over a flat floor: T = p = L = 1, k = 4,
    a = 2/5; the floor bears ρ = p - kf
    the equation of a cable, T w″ = ρ - p, solved piece by piece
    <BLANKLINE>
        n  spacing deflection order  reaction order      area order  boundary order
        9   0.1000   5.09e-05        6.68e-03        5.00e-01        5.00e-02
       19   0.0500   1.28e-05  1.99  1.67e-03  2.00  2.50e-01  1.00  2.50e-02  1.00
       39   0.0250   3.20e-06  2.00  4.17e-04  2.00  1.25e-01  1.00  1.25e-02  1.00
      all                      2.00            2.00            1.00            1.00
    <BLANKLINE>
    deflection: largest error (length); reaction: sum of moduli, of the whole; area:
    in contact, of it; boundary: largest distance from the free boundary (length)
    """
    entry = entry_of(name)
    wanted = _sizes_from(entry.nodes) if sizes is None else sorted(set(integers_at_least(sizes, 1, "sizes")))
    if not wanted:
        raise ValueError("sizes must hold one number of nodes or more")
    rows, backends = [], set()
    with Progress(f"studying {name}") as progress:
        for n in wanted:
            progress.update(f"n = {n}")
            known = load(name, n)
            if known.deflection is None:
                raise ValueError(
                    f"no closed form is known of {name!r}, so that there is nothing to compare with; "
                    "contactqp.gallery.load(name).deflection says whether there is one, as of 'ball'"
                )
            started = time.perf_counter()
            solution = solve(known.model, backend, tol=tol, time_limit=time_limit, on_failure=on_failure)
            backends.add(solution.backend)
            rows.append(_row(known, n, solution, time.perf_counter() - started))
    return Study(name, entry.title, known.source, ", ".join(sorted(backends)), tuple(rows))


def _sizes_from(nodes: int) -> list[int]:
    """Return four sizes, the given one first, whose spacings are halved from one to the next."""
    return [(nodes + 1) * 2**k - 1 for k in range(4)]


def _row(known: Known, n: int, solution: Solution, seconds: float) -> StudyRow:
    deflection = reaction = area = edge = bound = math.nan
    if solution.finite:
        assert known.deflection is not None
        deflection = float(np.abs(known.found(solution) - known.deflection).max())
        bound = math.inf if solution.certificate is None else solution.certificate.gap_bound
        if known.reaction is not None and (whole := float(np.abs(known.reaction).sum())):
            reaction = float(np.abs(solution.reaction - known.reaction).sum()) / whole
        if known.contact_area:
            covered = float(known.node_area[solution.contact].sum())
            area = abs(covered - known.contact_area) / known.contact_area
        if known.distance is not None and len(middles := known.free_boundary(solution.contact)):
            edge = float(known.distance(*middles.T).max())
    errors = deflection, reaction, area, edge, bound
    return StudyRow(n, known.size, known.spacing, *errors, solution.status.value, seconds, known.exact)
