"""The best relaxation factor by theory: Young, *Iterative Solution of Large Linear Systems* (1971), ch. 6.

Once the contact set rests, projected over-relaxation is plain over-relaxation on the free nodes F. A lattice swept row
by row is consistently ordered, so that the factor with the best rate in the long run follows from the spectral radius μ
of Jacobi's matrix B = I - D⁻¹G_FF, with D its diagonal:

    β = 2/(1 + √(1 - μ²)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..foundation.loading import load_modules
from ..models.base import split
from ..models.stretched import StretchedModel
from ..problem.contact_qp import ContactQP


def jacobi_radius(problem: ContactQP | StretchedModel, free: ArrayLike) -> float:
    """Return the spectral radius of Jacobi's matrix on the free nodes.

    G is a Z-matrix, so B >= 0, and by Perron and Frobenius its radius is its largest eigenvalue: 1 less the smallest
    one of D^(-1/2) G_FF D^(-1/2).

    Parameters
    ----------
    problem : Membrane, Cable or ContactQP
        With a Z-matrix.
    free : array of bool, shape (n,)
        F; without any node the radius is 0.

    Raises
    ------
    TypeError, ValueError
        If ``free`` is not boolean or has the wrong shape, or G is no Z-matrix.

    Examples
    --------
    On the n nodes of a free cable it is cos(π/(n + 1)).

    >>> import math
    >>> import contactqp as cq
    >>> cable = cq.Cable(nodes=5, spacing=1.0, tension=1.0, load=1.0, support=9.0)
    >>> round(jacobi_radius(cable, np.full(5, True)), 12), round(math.cos(math.pi / 6), 12)
    (0.866025403784, 0.866025403784)
    """
    _, algebra = split(problem)
    chosen = np.asarray(free)
    if chosen.dtype != np.bool_:
        raise TypeError(f"free must be boolean, got dtype {chosen.dtype}")
    if chosen.shape != (algebra.size,):
        raise ValueError(f"free must have shape ({algebra.size},), got {chosen.shape}")
    if not algebra.is_z_matrix:
        raise ValueError("the radius of Jacobi's matrix is computed for Z-matrices only, and G is none")
    nodes = np.flatnonzero(chosen)
    if not nodes.size:
        return 0.0
    load_modules("scipy.sparse", "scipy.sparse.linalg")
    from scipy import sparse
    from scipy.sparse import linalg

    part = algebra.G[nodes][:, nodes]
    scale = sparse.diags_array(1 / np.sqrt(part.diagonal()))
    scaled = (scale @ part @ scale).tocsc()
    if nodes.size <= 2:
        smallest = float(np.linalg.eigvalsh(scaled.toarray())[0])
    else:
        # A start of ones, because a random one would change the last digits from run to run.
        (smallest,) = linalg.eigsh(scaled, k=1, sigma=0.0, v0=np.ones(nodes.size), return_eigenvectors=False)
    return float(1 - smallest)


def optimal_factor(radius: float) -> float:
    """Return 2/(1 + √(1 - μ²)), the factor of the best rate in the long run.

    Parameters
    ----------
    radius : float
        μ, in [0, 1).

    Raises
    ------
    ValueError
        If the radius is out of range.

    Examples
    --------
    >>> optimal_factor(0.0), optimal_factor(0.8)
    (1.0, 1.25)
    """
    if not 0 <= radius < 1:
        raise ValueError(f"radius must lie in [0, 1), got {radius!r}")
    from ..methods.sor.relaxation import young

    return young(radius)
