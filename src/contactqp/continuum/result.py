"""Continuum: what is proven of the membrane itself by an answer of its lattice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..foundation.brackets import Bracket
from ..foundation.checks import Vector
from ..foundation.text import at_most, folded, rounded_outwards

EXACT, SAMPLED = "exact", "sampled data"


@dataclass(frozen=True, eq=False)
class Continuum:
    """What an answer of the lattice tells of the continuous membrane, its distance from the lattice included.

    Attributes
    ----------
    effort : {"energy", "pointwise"}
        How much was asked for.
    data : {"exact", "sampled data"}
        Whether load, support, frame and tension are known between the points of the lattice: as numbers, arrays (which
        are meant as their bilinear interpolants), profiles, and `contactqp.Smooth` functions are. All bounds are proven
        then. Of other functions nothing is known but their values at points: the bounds then hold for the membrane
        whose data are the interpolants of these, and nothing is proven of the one that was meant.
    sampled : tuple of str
        Names of the data of which the latter is true.
    energy : Bracket
        Of the membrane's potential energy ∫ ½T|∇w|² + ½kw² - pw (force times length), of depths w, positive downwards.
    energy_error : float
        Bound of the energy norm, (∫ T|∇u|² + ku²)^½, of u = Iw - w*: how far the bilinear interpolant of the answer is
        from the membrane (square root of force times length).
    energy_norm : float
        Energy norm of the interpolant itself, which the error is to be compared with.
    contact_error : float
        Bound of ∫R*(f - v), the work of the membrane's reaction on what is left of a gap where it touches (force times
        length); v is the interpolant, lowered where it would cross a curved support between the nodes.

    lower, upper : array, shape (n,), or None
        Bounds of the continuous deflection at the nodes, positive as the model's heights (length); None where only
        energies were asked for. Of a cable of one tension, without foundation and ceiling, they come with these.
    error_bound : float or None
        No less than the distance of the answer's deflections from them (length).

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.rectangle(1, 1).lattice(spacing=1 / 32)
    >>> found = cq.solve(cq.Membrane(lattice, tension=1.0, load=1.0, support=0.03), tol=1e-9).continuum("energy")
    >>> print(found)
    Continuum(energy): proven of the continuum itself
      data               exact
      potential energy   -0.01358923 to -0.01355716 (force times length)
      energy-norm error  <= 0.0081, 7 % of the norm
      contact error      <= 3.3e-05 (force times length)
    """

    effort: str
    data: str
    energy: Bracket
    energy_error: float
    energy_norm: float
    contact_error: float
    sampled: tuple[str, ...] = ()
    lower: Vector | None = None
    upper: Vector | None = None
    error_bound: float | None = None

    @property
    def proven(self) -> bool:
        """Whether the bounds are proven of the data that were given."""
        return self.data == EXACT

    @property
    def relative_energy_error(self) -> float:
        """`energy_error` over the norm of the interpolant; infinite if that is zero."""
        return self.energy_error / self.energy_norm if self.energy_norm else np.inf

    def _facts(self) -> Iterator[tuple[str, str]]:
        lower, upper = rounded_outwards(*self.energy, digits=7)
        yield "data", self.data + (f": {', '.join(self.sampled)}" if self.sampled else "")
        yield "potential energy", f"{lower!r} to {upper!r} (force times length)"
        share = f", {at_most(100 * self.relative_energy_error)} % of the norm" if self.energy_norm else ""
        yield "energy-norm error", f"<= {at_most(self.energy_error)}{share}"
        if self.error_bound is not None:
            yield "deflection error", f"<= {at_most(self.error_bound)} at the nodes"
        yield "contact error", f"<= {at_most(self.contact_error)} (force times length)"

    def __str__(self) -> str:
        words = "proven of the continuum itself" if self.proven else "computed of the continuum, not proven"
        rows = [f"Continuum({self.effort}): {words}"]
        rows += [folded(f"  {name:<19}{told}", 80, 21) for name, told in self._facts()]
        if not self.proven:
            rows.append(folded("  the bounds hold for the interpolants of the sampled data", 80, 2))
        return "\n".join(rows)

    def __repr__(self) -> str:
        return f"Continuum({self.effort!r}, {self.data}, energy_error <= {at_most(self.energy_error)})"
