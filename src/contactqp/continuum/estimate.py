"""Discretisation estimates: what the answers of lattices of several spacings say of the error, by extrapolation.

Where an answer u(h) is u* + Ch^p + ..., two of them tell C, and three tell p as well (Richardson 1911):

    u(h) - u* ≈ (u(h) - u(h/2)) 2^p/(2^p - 1),   p = log2(|u(2h) - u(h)| / |u(h) - u(h/2)|).

Of five-point differences p is 2. At a free boundary the error depends on where between two nodes it lies, so that the
observed p scatters: the error is estimated with p = 2, and the *grid convergence index*, 1.25 times the estimate with
the observed order where that is less (Roache, *Perspective: a method for uniform reporting of grid refinement studies*,
J. Fluids Eng. 116, 1994), leaves room for it. An estimate is no bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Vector
from ..models.base import ContactModel
from ..models.membrane import Membrane
from .relatives import coarser, finer, place_in

Solve = Callable[[Membrane], Vector]
"""Returns the gap of a model (length), solved as accurately as the answer whose error is estimated."""

SAFETY = 1.25
"""Roache's factor for three lattices."""

_FORMAL_ORDER = 2.0

_ROUNDING = 1e-13


@dataclass(frozen=True, eq=False)
class DiscretisationEstimate:
    """How far the lattice's deflections are from the membrane's, estimated from lattices of other spacings; no bound.

    Attributes
    ----------
    spacings : tuple of float
        Of the lattices that were compared, from fine to coarse (length).
    errors : array, shape (n,)
        Estimated error of the deflection at each node, positive as the model's heights (length).
    error : float
        The largest of them in size (length).
    mean_error : float
        Their root mean square (length).
    order : float or None
        Observed order of convergence, in the root mean square; None where only two lattices could be compared.
    grid_convergence_index : float
        1.25 times the largest error, by the observed order where that is below 2 (length).

    Examples
    --------
    >>> import contactqp as cq
    >>> known = cq.gallery.load("ring", n=63)
    >>> solution = cq.solve(known.model, tol=1e-9)
    >>> estimate = solution.discretisation_estimate("pointwise")
    >>> true_error = abs(solution.deflection - known.deflection).max()
    >>> 0.7 < estimate.error / true_error < 1.5
    np.True_
    """

    spacings: tuple[float, ...]
    errors: Vector
    order: float | None

    @property
    def error(self) -> float:
        """The largest estimated error (length)."""
        return float(np.abs(self.errors).max())

    @property
    def mean_error(self) -> float:
        """Root mean square of the estimated errors (length)."""
        return _mean(self.errors)

    @property
    def grid_convergence_index(self) -> float:
        """See the class."""
        order = _FORMAL_ORDER if self.order is None else min(max(self.order, 0.5), _FORMAL_ORDER)
        return SAFETY * self.error * _share(order) / _share(_FORMAL_ORDER)

    def __str__(self) -> str:
        spacings = ", ".join(f"{spacing:g}" for spacing in self.spacings)
        order = "unknown" if self.order is None else f"{self.order:.2f}"
        rows = {
            "largest error": f"about {self.error:.2g}",
            "mean error": f"about {self.mean_error:.2g} (root mean square)",
            "observed order": order,
            "grid convergence": f"index {self.grid_convergence_index:.2g}",
            "spacings": spacings,
        }
        head = "Discretisation error of the deflection: an estimate, no bound"
        return "\n".join([head, *(f"  {name:<17}{told}" for name, told in rows.items())])

    def __repr__(self) -> str:
        return f"DiscretisationEstimate(error about {self.error:.2g}, spacing={self.spacings[1]:g})"


def discretisation_estimate(model: ContactModel, gap: Vector, solve: Solve) -> DiscretisationEstimate:
    """Return the estimate for an answer of a model; see `Solution.discretisation_estimate`.

    Parameters
    ----------
    model : Membrane
    gap : array, shape (n,)
        The answer's (length).
    solve : callable
        Solves the model on other lattices.
    """
    fine, coarse = finer(model), coarser(model)
    assert isinstance(model, Membrane)
    own = model.padded_below(gap)
    errors = (own - fine.padded_below(solve(fine))[1:-1, 1:-1][::2, ::2]) * _share(_FORMAL_ORDER)
    at_nodes = model.lattice.numbering.to_vector(errors, ring=1)
    spacings = fine.lattice.spacing, model.lattice.spacing
    if coarse is None:
        return DiscretisationEstimate(spacings, -at_nodes if model.upwards else at_nodes, None)
    there = _at_nodes_of(coarse, model, own)
    known = coarse.lattice.numbering.to_vector(coarse.padded_below(solve(coarse)), ring=1)
    far, near = _mean(known - there), _mean(_at_nodes_of(coarse, model, errors)) / _share(_FORMAL_ORDER)
    # Differences that are no more than rounding, of an answer that is exact at its nodes, have no order.
    told = min(far, near) > _ROUNDING * max(float(np.abs(own).max()), model.height_scale)
    found = -at_nodes if model.upwards else at_nodes
    order = float(np.log2(far / near)) if told else None
    return DiscretisationEstimate((*spacings, coarse.lattice.spacing), found, order)


def _share(order: float) -> float:
    return 2**order / (2**order - 1)


def _mean(errors: Vector) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


def _at_nodes_of(coarse: Membrane, model: Membrane, points: Vector) -> Vector:
    """Return what points of a model have at the nodes of a coarser one."""
    first = place_in(model.lattice, coarse.lattice)
    rows, columns = coarse.lattice.shape
    grid = points[first[0] :: 2, first[1] :: 2][:rows, :columns]
    return coarse.lattice.numbering.to_vector(grid)
