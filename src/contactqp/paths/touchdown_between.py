"""touchdown_between(): the loads at which nodes settle, in all models whose data lie between two others.

Where no load presses upwards, the deflection of every member grows with the factor of its load, and a node that has
settled stays. At a factor at which the answer for the greatest data is certainly clear of the highest support, all
members are; at one at which the support presses in the answer for the least data as `contactqp.solving.family` has it,
it does so in all. So each member's node touches down between the largest of the former and the least of the latter.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..backends.base import Backend
from ..foundation.checks import Vector, finite_number
from ..foundation.progress import Progress
from ..models.base import ContactModel
from ..models.varied import with_load
from ..solving.family import enclosed_between, uncertain_model
from .touchdown import Touchdown


def touchdown_between(
    model: ContactModel,
    loads: Iterable[float],
    backend: str | Backend = "auto",
    *,
    tol: float | str = 1e-6,
    **options: Any,
) -> Touchdown:
    """Enclose the load factors at which nodes settle, of all models whose data lie between what `between` says.

    Parameters
    ----------
    model : Membrane or Cable
        Made with `contactqp.between`, see `contactqp.solve_between`; the loads of all members are multiplied by the
        factors.
    loads : iterable of float
        Load factors > 0. For each of them two problems are solved, starting from the one before.
    backend, tol, **options
        As for `contactqp.solve`.

    Returns
    -------
    Touchdown
        ``clear`` is the largest factor at which the node is certainly clear in every member, ``contact`` the least at
        which the support certainly holds it in every member. Those of one member lie between them, and so between the
        factors of the two ends of the family.

    Raises
    ------
    TypeError, UnsuitableProblemError
        See `contactqp.solve_between`.
    ValueError
        See there; if no factor is given, one is not > 0, or a load may press upwards: nodes would come loose again.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(1, 1).lattice(spacing=1 / 16)
    >>> membrane = cq.Membrane(lattice, tension=1.0, load=cq.between(0.95, 1.05), support=0.03)
    >>> found = cq.touchdown_between(membrane, [0.35, 0.4, 0.45, 0.5, 0.6])
    >>> middle = lattice.size // 2
    >>> float(found.clear[middle]), float(found.contact[middle])
    (0.35, 0.45)
    """
    ends = uncertain_model(model).extremes()
    factors = sorted({finite_number(load, "load factor") for load in loads})
    if not factors or factors[0] <= 0:
        raise ValueError(f"loads must be factors > 0, got {factors if factors else 'none'}")
    if (ends[0].nodal_load < 0).any():
        node = int(np.argmin(ends[0].nodal_load))
        raise ValueError(
            f"the load of {model!r} may press upwards, as at node {node}: nodes would come loose again when it grows, "
            "and have no load at which they settle; solve_between() encloses the answers for one load"
        )
    clear, contact = np.full(model.size, -np.inf), np.full(model.size, np.inf)
    starts: tuple[Vector | None, Vector | None] = (None, None)
    with Progress(f"touchdown between two · {model.size} nodes") as progress:
        for done, factor in enumerate(factors):
            progress.update(f"load {done + 1} of {len(factors)}")
            pair = with_load(ends[0], factor), with_load(ends[1], factor)
            found = enclosed_between(pair, backend, starts=starts, tol=tol, **options)
            starts = found.solutions[0].gap, found.solutions[1].gap
            clear[found.clear] = factor
            contact[found.contact & np.isinf(contact)] = factor
    return Touchdown(model, clear, contact, np.array(factors))
