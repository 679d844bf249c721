"""Follower: the solution under a growing load, from one change of the contact set to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..models.base import ContactModel
from ..models.varied import with_load
from ..solving.solution import Solution
from ..solving.solve import solve
from .bordered import Bordered

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_TIED = 1e-10
"""Events closer than this part of the load at which they happen (or of the range, if that is less) count as one."""

_ZERO = 1e-11
"""Gaps and reactions of a start below this part of the largest count as zero."""

_MOST_EXCHANGES = 100


class Follower:
    """The linear pieces of ω and R between events; see `contactqp.paths.events`.

    Parameters
    ----------
    matrix : csr_array, shape (n, n)
        G.
    forces : array, shape (n, 2)
        Constant and slope of q in the load factor.
    supported : array of bool, shape (n,)
    extent : float
        Range of load factors to follow.
    """

    def __init__(self, matrix: csr_array, forces: Vector, supported: Mask, extent: float) -> None:
        self._matrix, self._forces, self._supported, self._extent = matrix, forces, supported, extent
        self._diagonal = matrix.diagonal()
        self.free: Mask = ~supported
        self._load = 0.0
        self._known: tuple[Vector, Vector] | None = None

    @classmethod
    def of(cls, model: ContactModel, start: float, stop: float) -> Follower:
        """Return the follower of a model's solutions from one load factor to another, at its beginning."""
        unloaded = with_load(model, 0.0).problem
        forces = np.column_stack([unloaded.q, np.asarray(model.nodal_load)])
        follower = cls(unloaded.G, forces, model.supported, stop - start)
        follower.begin(start, solve(with_load(model, start), "active-set", tol=1e-12, on_failure="ignore"))
        return follower

    def begin(self, load: float, solution: Solution) -> None:
        """Take the side of each node from a solution; where gap and reaction both vanish, from the derivative."""
        self._load = load
        gap, certificate = solution.gap, solution.certificate
        reaction = (self._matrix @ gap + self._forces @ [1.0, load]) / self._diagonal
        size = float(max(np.abs(gap).max(), np.abs(reaction).max()))
        touching = self._supported & (np.abs(gap) <= _ZERO * size) & (np.abs(reaction) <= _ZERO * size)
        self.free = ~self._supported | (~touching & (gap > reaction))
        if certificate is not None:
            touching &= certificate.undecided
            self.free = (self.free & ~certificate.contact) | certificate.clear
        self._solver = Bordered(self._matrix, self._forces, self.free)
        self._settle(touching)

    def next_event(self) -> tuple[float, NDArray[np.int64]]:
        """Return the next load at which gaps or reactions vanish, infinite if none, and their nodes."""
        at_zero, rate = self._moving()
        with np.errstate(divide="ignore", invalid="ignore"):
            load = np.where(rate < 0, -at_zero / rate, np.inf)
        load[~np.isfinite(load)] = np.inf
        load = np.maximum(load, self._load)
        nearest = float(load.min())
        if not np.isfinite(nearest):
            return nearest, np.flatnonzero(load <= nearest)
        held = self._supported
        own = abs(nearest) + float(np.abs(at_zero[held]).max() / np.abs(rate[held]).max())
        return nearest, np.flatnonzero(load <= nearest + _TIED * min(self._extent, own))

    def pass_event(self, load: float, nodes: NDArray[np.int64]) -> None:
        """Go past a load at which gaps or reactions vanish at some nodes."""
        self._load = load
        self._toggle(nodes)
        touching = np.zeros(self.free.size, dtype=np.bool_)
        touching[nodes] = True
        self._settle(touching)

    def gap(self, load: float) -> Vector:
        """Return ω at a load factor of the present piece (length), shape (n,)."""
        gap = self._solver.gap()
        return np.asarray(gap[:, 0] + load * gap[:, 1])

    def _moving(self) -> tuple[Vector, Vector]:
        """Return constant and slope in the load of what must stay >= 0: ω at free nodes, R/G_ii at contact nodes."""
        if self._known is None:
            self._known = self._constant_and_slope()
        return self._known

    def _toggle(self, nodes: NDArray[np.int64]) -> None:
        self._solver.toggle(nodes)
        self.free, self._known = self._solver.free, None

    def _constant_and_slope(self) -> tuple[Vector, Vector]:
        gap = self._solver.gap()
        reaction = (self._matrix @ gap + self._forces) / self._diagonal[:, None]
        chosen = np.where(self.free[:, None], gap, reaction)
        slope = np.where(self.free & ~self._supported, 0.0, chosen[:, 1])
        noise = 1e-13 * float(np.abs(chosen[:, 1]).max())
        return chosen[:, 0], np.where(np.abs(slope) <= noise, 0.0, slope)

    def _settle(self, touching: Mask) -> None:
        """Let the nodes at which gap and reaction vanish exchange sides until their rates point inwards."""
        for _ in range(_MOST_EXCHANGES + int(np.count_nonzero(touching))):
            _, rate = self._moving()
            wrong = np.flatnonzero(touching & (rate < 0))
            if not wrong.size:
                return
            self._toggle(wrong)
        raise RuntimeError(
            f"events: {int(touching.sum())} nodes touch at load factor {self._load:g}, and rounding errors hide which "
            "of them come into contact; change the load's range or the spacing a little"
        )
