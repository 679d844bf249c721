r"""Exact events along a load path: at which load which node settles on the support, or lifts off it.

Under the load λP the forces are q(λ) = q₀ + λq₁, and as long as the contact set stays the same, the solution is
linear in λ as well: with the free nodes F and the contact nodes C

.. math:: ω_F(λ) = -G_{FF}^{-1}q_F(λ), \qquad R_C(λ) = q_C(λ) + G_{CF}ω_F(λ).

The next event is at the least λ for which an ω_i of F, with a support, or an R_i of C comes to zero. Which of the
nodes that are at zero there settle, lift or stay is decided by the derivative, which solves a contact problem of
its own: ω′ = 0 on C, R′ = 0 on F, and ω′ ≥ 0, R′ ≥ 0, ω′ᵀR′ = 0 at the nodes where both vanish. This is the
parametric method for linear complementarity (Cottle, Pang and Stone, *The Linear Complementarity Problem*, 1992,
ch. 4). For an M-matrix and a load P ≥ 0 nodes only settle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.cards import card
from ..foundation.checks import Mask, Vector, finite_number
from ..foundation.loading import load_modules
from ..foundation.progress import Progress
from ..foundation.rounding import UNIT_ROUNDOFF
from ..models.base import ContactModel
from ..models.varied import reachable, with_load
from .follower import Follower

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Events:
    """What happens at which load.

    Attributes
    ----------
    model : ContactModel
        `Membrane`, `MeshMembrane`, `Cable`, `CableNet`, `Beam`, `Plate`, or one of your own.
        Its load is multiplied by the factors below.
    start, stop : float
        Range of load factors that was followed.
    load : array, shape (k,)
        Load factors of the events, ascending.
    node : array of int, shape (k,)
        Node of each event.
    settles : array of bool, shape (k,)
        True where the node settles on the support, False where it lifts off.
    contact_at_start : array of bool, shape (n,)
        Nodes in contact just after ``start``.
    """

    model: ContactModel
    start: float
    stop: float
    load: Vector
    node: NDArray[np.int64]
    settles: Mask
    contact_at_start: Mask

    @property
    def first_touch(self) -> float:
        """Least load factor at which a node is in contact; nan if none is up to ``stop``."""
        if self.contact_at_start.any():
            return self.start
        return float(self.load[self.settles][0]) if self.settles.any() else float("nan")

    @property
    def full_contact(self) -> float:
        """Least load factor from which all nodes with a support are in contact at ``stop``; nan if they are not."""
        final = self.contact_at(self.stop)
        if not final[self.model.supported].all() or not self.model.supported.any():
            return float("nan")
        return float(self.load[-1]) if self.load.size else self.start

    @property
    def touchdown(self) -> Vector:
        """Load factor at which each node settles for the last time, shape (n,); nan where it never does.

        Nodes that are in contact from the start on have ``start``.
        """
        found = np.where(self.contact_at_start, self.start, np.nan)
        found[self.node[self.settles]] = self.load[self.settles]
        return np.where(self.contact_at(self.stop), found, np.nan)

    def contact_at(self, load: float) -> Mask:
        """Return the nodes in contact at a load factor between ``start`` and ``stop``, events at it included."""
        load = finite_number(load, "load")
        if not self.start <= load <= self.stop:
            raise ValueError(f"load must lie between {self.start:g} and {self.stop:g}, got {load:g}")
        contact = self.contact_at_start.copy()
        until = int(np.searchsorted(self.load, load, side="right"))
        for node, settles in zip(self.node[:until], self.settles[:until], strict=True):
            contact[node] = settles
        return contact

    def to_frame(self) -> pd.DataFrame:
        """Return the events in order, as a pandas.DataFrame with load, node, x, y and event ("settles" or "lifts")."""
        load_modules("pandas")
        import pandas as pd

        return pd.DataFrame(
            {
                "load": self.load,
                "node": self.node,
                "x": self.model.node_x[self.node],
                "y": self.model.node_y[self.node],
                "event": np.where(self.settles, "settles", "lifts"),
            }
        )

    def _repr_html_(self) -> str:
        lifts = int(np.count_nonzero(~self.settles))
        facts = {
            "model": repr(self.model),
            "load factors": f"{self.start:g} to {self.stop:g}",
            "settle": f"{self.load.size - lifts} nodes",
            "lift": f"{lifts} nodes" if lifts else "",
            "first touch": f"{self.first_touch:.6g}",
            "all in contact": f"{self.full_contact:.6g}" if np.isfinite(self.full_contact) else "",
        }
        return card("Events", facts)

    def __repr__(self) -> str:
        lifts = int(np.count_nonzero(~self.settles))
        lifting = f", {lifts} lifts" if lifts else ""
        return (
            f"Events({self.model!r}, load factors {self.start:g} to {self.stop:g}: "
            f"{self.load.size - lifts} nodes settle{lifting})"
        )


def events(model: ContactModel, stop: float, *, start: float = 0.0) -> Events:
    """Follow the solution under a growing load exactly, from one change of the contact set to the next.

    Practical up to some 10,000 nodes; a step takes a solve with the factors of G.

    Parameters
    ----------
    model : ContactModel
        `Membrane`, `MeshMembrane`, `Cable`, `CableNet`, `Beam`, `Plate`, or one of your own.
        The load that is multiplied.
    stop : float
        Load factor at which to stop, > start.
    start : float
        Load factor at which to begin.

    Returns
    -------
    Events

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong kind or range, or the model has a ceiling.
    RuntimeError
        If rounding errors hide which of many nodes that touch at once come into contact.

    Examples
    --------
    A cable with two nodes over a step: the lower support is touched by the second node only.

    >>> import contactqp as cq
    >>> cable = cq.Cable(nodes=2, spacing=1.0, tension=1.0, load=1.0, support=[1.0, 2.0])
    >>> events(cable, stop=4.0).to_frame()[["load", "node", "event"]]
       load  node    event
    0   1.0     0  settles
    1   3.0     1  settles
    """
    if not isinstance(model, ContactModel):
        raise TypeError(f"model must be a model, as Membrane, Cable or Beam, got {type(model).__name__}")
    start, stop = finite_number(start, "start"), finite_number(stop, "stop")
    if not start < stop:
        raise ValueError(f"stop must be > start, got start={start:g}, stop={stop:g}")
    if not model.problem.one_sided:
        raise ValueError(
            f"events follows contact with a support alone, but {model!r} has a ceiling; use contactqp.trace, whose "
            "paths bracket where nodes settle"
        )
    model = reachable(model, [with_load(model, start), with_load(model, stop)])
    with Progress(f"events · {model.size} nodes") as progress:
        follower = Follower.of(model, start, stop)
        contact_at_start = ~follower.free
        found: list[tuple[float, int, bool]] = []
        while True:
            load, nodes = follower.next_event()
            if not load <= stop:
                break
            before = follower.free.copy()
            follower.pass_event(load, nodes)
            changed = np.flatnonzero(before != follower.free)
            found += [(load, int(node), bool(before[node])) for node in changed]
            progress.update(f"load factor {load:.4g}, {np.count_nonzero(~follower.free)} nodes in contact")
    columns: Any = list(zip(*_lasting(found), strict=True)) or [[], [], []]
    return Events(
        model,
        start,
        stop,
        np.array(columns[0], dtype=np.float64),
        np.array(columns[1], dtype=np.int64),
        np.array(columns[2], dtype=np.bool_),
        contact_at_start,
    )


def _lasting(found: list[tuple[float, int, bool]]) -> list[tuple[float, int, bool]]:
    """Leave out what a node does and undoes at one and the same load, up to rounding."""
    rounding = 64 * UNIT_ROUNDOFF * max((abs(load) for load, _, _ in found), default=0.0)
    undone: set[int] = set()
    latest: dict[int, int] = {}
    for k, (load, node, _) in enumerate(found):
        before = latest.get(node)
        if before is not None and load - found[before][0] <= rounding:
            undone |= {before, k}
            del latest[node]
        else:
            latest[node] = k
    return [event for k, event in enumerate(found) if k not in undone]
