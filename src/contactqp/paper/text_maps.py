"""Contact maps as text, as a line printer made them for Fig. 5 of the paper."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..geometry.lattice import Lattice

FREE, SETTLED = ".", "*"


def text_map(lattice: Lattice, contact: ArrayLike) -> str:
    """Lay the nodes out in rows, a dot for each and a star where the membrane has settled.

    The uppermost row, with the largest y, comes first. A blank stands between neighbours, because letters are about
    twice as high as wide: so 45° stay 45°, and the paper's hexagon takes 125 columns of a printer's 132.

    Parameters
    ----------
    lattice : Lattice
    contact : array of bool, shape (n,)
        Where the membrane has settled.

    Raises
    ------
    TypeError, ValueError
        If ``contact`` is not boolean, or has the wrong shape.

    Examples
    --------
    >>> import contactqp as cq
    >>> lattice = cq.Frame.disk(3.5).lattice(spacing=1.0)
    >>> print(text_map(lattice, np.hypot(lattice.node_x, lattice.node_y - 1) < 1.1))
      . . . .
    . . * * . .
    . . * * . .
    . . . . . .
    . . . . . .
      . . . .
    """
    settled = np.asarray(contact)
    if settled.dtype != np.bool_:
        raise TypeError(f"contact must be boolean, got dtype {settled.dtype}")
    letters = lattice.scatter(settled.astype(np.int64), fill=-1)
    rows, columns = (np.flatnonzero(lattice.mask.any(axis=axis)) for axis in (1, 0))
    letters = letters[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    lines = (" ".join({-1: " ", 0: FREE, 1: SETTLED}[int(state)] for state in row) for row in letters[::-1])
    return "\n".join(line.rstrip() for line in lines)
