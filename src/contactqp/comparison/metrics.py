"""Distances of an answer from the enclosed truth, of two contact sets, and of two free boundaries."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules
from ..proof.certificate import Certificate


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the exact solution lies, by all certificates together.

    Attributes
    ----------
    lower, upper : array, shape (n,)
        lower ≤ ω* ≤ upper (length): the largest lower and the least upper bound of all answers.
    """

    lower: Vector
    upper: Vector

    @property
    def width(self) -> float:
        """Largest upper - lower over the nodes (length)."""
        return float((self.upper - self.lower).max())

    @np.errstate(over="ignore", invalid="ignore")
    def error(self, gap: Vector) -> tuple[float, float]:
        """Return two lengths between which max|ω_i - ω*_i| of an answer certainly lies.

        Parameters
        ----------
        gap : array, shape (n,)
            The answer ω (length), finite.

        Examples
        --------
        >>> import numpy as np
        >>> low, high = Truth(np.array([0.0, 1.0]), np.array([0.0, 1.5])).error(np.array([0.0, 2.0]))
        >>> bool(low <= 0.5 <= low + 1e-15), bool(1.0 <= high <= 1.0 + 1e-15)
        (True, True)
        """
        below, above = self.lower - gap, gap - self.upper
        least = float(np.maximum(below, above).max())
        most = float(np.maximum(-below, -above).max())
        # A difference of two numbers is off by half a unit in its last place at most.
        return float(np.nextafter(least, 0.0)) if least > 0 else 0.0, float(np.nextafter(max(most, 0.0), np.inf))


def intersection(certificates: Iterable[Certificate]) -> Truth | None:
    """Return what all certificates say together; None if there is none, or if they contradict each other."""
    found: Truth | None = None
    for certificate in certificates:
        if found is None:
            found = Truth(certificate.lower, certificate.upper)
        else:
            found = Truth(np.maximum(found.lower, certificate.lower), np.minimum(found.upper, certificate.upper))
    return None if found is None or (found.lower > found.upper).any() else found


def contact_jaccard(first: Mask, second: Mask) -> float:
    """Return 1 - |intersection| / |union| of two contact sets: 0 if they are equal, 1 if they have nothing in common.

    Parameters
    ----------
    first, second : array of bool, shape (n,) or (k, n)
        Nodes in contact; with k bounds one row for each, so that a contact is a node and the bound that holds it.

    Examples
    --------
    >>> import numpy as np
    >>> contact_jaccard(np.array([True, True, False]), np.array([True, False, False]))
    0.5
    >>> contact_jaccard(np.array([[True], [False]]), np.array([[False], [True]]))  # below, and above
    1.0
    """
    union = int(np.count_nonzero(first | second))
    return int(np.count_nonzero(first != second)) / union if union else 0.0


def boundary_distance(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Return the Hausdorff distance of two free boundaries (length): 0 if both are empty, infinite if only one is.

    Parameters
    ----------
    first, second : array, shape (k, 2)
        Points, see `ContactModel.free_boundary`.

    Examples
    --------
    >>> import numpy as np
    >>> boundary_distance(np.array([[0.0, 0.0]]), np.array([[0.0, 0.0], [3.0, 4.0]]))
    5.0
    """
    load_modules("scipy.spatial")
    from scipy.spatial import cKDTree

    if not len(first) or not len(second):
        return 0.0 if len(first) == len(second) else np.inf
    there, back = cKDTree(second).query(first)[0].max(), cKDTree(first).query(second)[0].max()
    return float(max(there, back))
