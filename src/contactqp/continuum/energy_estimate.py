r"""Estimates of the error in the energy norm, from the same membrane on lattices of twice and four times the spacing.

Where the interpolant u(h) of a lattice's answer were the best one of its kind, what that of twice the spacing misses
beyond would be orthogonal to what both miss (Galerkin), so that with an error of order p

    \|u(2h) - u*\|² = \|u(2h) - u(h)\|² + \|u(h) - u*\|²  and  \|u(2h) - u*\| = 2^p \|u(h) - u*\|,

    \|u(h) - u*\| = \|u(2h) - u(h)\| / (4^p - 1)^½.

Bilinear interpolants have p = 1. The error in the norm is that of interpolation nearly everywhere, and hardly feels
where between two nodes the free boundary lies, on which the largest error of the deflection depends. The *grid
convergence index* is 1.25 times the estimate, by the observed order where that is less than 1 (Roache, *Perspective: a
method for uniform reporting of grid refinement studies*, J. Fluids Eng. 116, 1994). An estimate is no bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..foundation.checks import Vector
from ..geometry.numbering import Grid
from ..models.base import ContactModel
from ..models.membrane import Membrane
from .data import Data
from .energy import energy_norm, points_of
from .estimate import SAFETY, Solve
from .relatives import coarser, place_in, prolonged_in

_FORMAL_ORDER, _LEAST_ORDER = 1.0, 0.5

_ROUNDING = 1e-12


@dataclass(frozen=True)
class EnergyEstimate:
    """How far the interpolated answer is from the membrane in the energy norm, estimated; no bound.

    Attributes
    ----------
    spacings : tuple of float
        Of the lattices that were compared, from fine to coarse (length).
    error : float
        Estimated energy norm of u = Iw - w*, as `Continuum.energy_error` bounds it (square root of force times length).
    norm : float
        Energy norm of the interpolant itself.
    order : float or None
        Observed order of convergence; None where only two lattices could be compared.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(1, 1).lattice(spacing=1 / 32)
    >>> solution = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.0, support=0.03))
    >>> estimate = solution.discretisation_estimate()
    >>> estimate.error < solution.continuum().energy_error < 1.25 * estimate.error
    True
    """

    spacings: tuple[float, ...]
    error: float
    norm: float
    order: float | None

    @property
    def relative_error(self) -> float:
        """The error over the norm of the interpolant; infinite if that is zero."""
        return self.error / self.norm if self.norm else np.inf

    @property
    def grid_convergence_index(self) -> float:
        """1.25 times the error, by the observed order where that is below 1 (square root of force times length)."""
        order = _FORMAL_ORDER if self.order is None else min(max(self.order, _LEAST_ORDER), _FORMAL_ORDER)
        return SAFETY * self.error * _share(_FORMAL_ORDER) / _share(order)

    def __str__(self) -> str:
        rows = {
            "energy-norm error": f"about {self.error:.2g}, {100 * self.relative_error:.2g} % of the norm",
            "observed order": "unknown" if self.order is None else f"{self.order:.2f}",
            "grid convergence": f"index {self.grid_convergence_index:.2g}",
            "spacings": ", ".join(f"{spacing:g}" for spacing in self.spacings),
        }
        head = "Discretisation error in the energy norm: an estimate, no bound"
        return "\n".join([head, *(f"  {name:<19}{told}" for name, told in rows.items())])

    def __repr__(self) -> str:
        return f"EnergyEstimate(error about {self.error:.2g}, spacing={self.spacings[0]:g})"


def energy_estimate(model: ContactModel, gap: Vector, solve: Solve) -> EnergyEstimate:
    """Return the estimate for an answer of a model; see `Solution.discretisation_estimate`.

    Parameters
    ----------
    model : Membrane
    gap : array, shape (n,)
        The answer's (length).
    solve : callable
        Solves the model on other lattices.

    Raises
    ------
    ValueError
        If the frame runs along the lines of no lattice of twice the spacing.
    """
    double = coarser(model)
    if double is None:
        raise ValueError(
            f"{model!r}: no lattice of twice its spacing has the frame on its lines; take an even number of squares "
            "along each side, or effort='pointwise', which solves on one of half the spacing"
        )
    assert isinstance(model, Membrane)
    data, beyond = Data.of(model), Data.of(double)
    own, far = points_of(data, model.padded_below(gap)), points_of(beyond, double.padded_below(solve(double)))
    apart, norm = _apart(data, own, double, far), energy_norm(data, own)
    spacings: tuple[float, ...] = model.lattice.spacing, double.lattice.spacing
    fourfold, order = coarser(double), None
    if fourfold is not None:
        farther = points_of(Data.of(fourfold), fourfold.padded_below(solve(fourfold)))
        before = _apart(beyond, far, fourfold, farther)
        spacings = (*spacings, fourfold.lattice.spacing)
        # Differences that are no more than rounding have no order.
        order = float(np.log2(before / apart)) if min(before, apart) > _ROUNDING * norm else None
    return EnergyEstimate(spacings, apart / _share(_FORMAL_ORDER), norm, order)


def _share(order: float) -> float:
    return float(np.sqrt(4**order - 1))


def _apart(data: Data, points: Grid, coarse: Membrane, far: Grid) -> float:
    """Return the energy norm of the difference of two interpolants, the second one of twice the spacing."""
    finer_points = prolonged_in(Data.of(coarse).plan, far)
    # The coarser array, with its ring, may begin and end beyond the finer one.
    first = [place - 2 for place in place_in(data.plan.lattice, coarse.lattice)]
    here = tuple(slice(max(k, 0), k + n) for k, n in zip(first, finer_points.shape, strict=True))
    there = tuple(slice(max(-k, 0), max(-k, 0) + part) for k, part in zip(first, points[here].shape, strict=True))
    apart = np.zeros_like(points)
    apart[here] = (points[here] - finer_points[there]) * data.plan.points[here]
    return energy_norm(data, apart)
