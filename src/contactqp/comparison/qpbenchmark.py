"""A test set for qpbenchmark: the gallery's problems in several sizes, as a folder that needs nothing of this package.

Caron et al., *qpbenchmark: benchmark for quadratic programming solvers available in Python*.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from .._version import __version__
from ..foundation.checks import integer_at_least
from ..foundation.files import made_folder
from ..gallery.families import FAMILIES
from ..models.base import split

__all__ = ["MODULE", "PROBLEMS", "SIZES", "write_test_set"]

MODULE = "contactqp_obstacles.py"
"""The module of the test set; qpbenchmark derives from its name that of the class in it."""

PROBLEMS = "problems"
"""The folder of the problems, beside the module."""

_SIDES, _NODES = (15, 31, 63, 127), (99, 999, 9999)

SIZES: Mapping[str, tuple[int, ...]] = {
    "hexagon": tuple(range(1, 11)),
    "bowl": _SIDES,
    "spiral": _SIDES,
    "ball": _SIDES,
    "cable": _NODES,
    "channel": _NODES,
    "beam": _NODES[:2],
}
"""By family of `contactqp.gallery.families`, the numbers that its problems are made by."""

_TEXT = f'''"""Obstacle problems as a test set of qpbenchmark, written by contactqp {__version__}.

    qpbenchmark {MODULE} run

Each problem is min 1/2 x'Px + q'x subject to lb <= x <= ub: the gap of a membrane, cable or beam above an obstacle,
without dimensions, so that the largest entry on the diagonal of P, and a typical gap, are 1. "channel" has two bounds.
"""

from pathlib import Path

import numpy as np
import qpbenchmark
import scipy.sparse as spa


class ContactqpObstacles(qpbenchmark.TestSet):
    @property
    def description(self):
        return "Membranes, cables and beams over rigid obstacles, in several sizes."

    @property
    def title(self):
        return "Obstacle problems of contactqp"

    @property
    def sparse_only(self):
        return True

    def __iter__(self):
        for path in sorted((Path(__file__).parent / "{PROBLEMS}").glob("*.npz")):
            with np.load(path) as parts:
                size = parts["q"].size
                # The matrix is symmetric, so that its rows are its columns.
                matrix = spa.csc_matrix((parts["data"], parts["indices"], parts["indptr"]), shape=(size, size))
                yield qpbenchmark.Problem(
                    matrix, parts["q"], None, None, None, None, parts["lower"], parts["upper"], name=path.stem
                )
'''


def write_test_set(folder: Path, largest: int = 20_000) -> list[str]:
    """Write a test set for qpbenchmark into a folder, and return the names of its problems.

    Parameters
    ----------
    folder : Path
        It is made if it is missing; problems of an earlier test set in it are removed.
    largest : int
        Unknowns of the largest problem.

    Raises
    ------
    ValueError
        If the folder cannot be made, or no problem is as small.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     write_test_set(Path(folder), largest=100)
    ['beam_099', 'cable_0099', 'channel_0099']
    """
    integer_at_least(largest, 1, "largest")
    problems = {}
    for family, sizes in SIZES.items():
        for size in sizes:
            problem = split(FAMILIES[family].make(size))[1]
            if problem.size > largest:
                break
            problems[f"{family}_{size:0{len(str(sizes[-1]))}}"] = problem
    if not problems:
        raise ValueError(f"largest must be at least 99, the unknowns of the smallest problem, got {largest}")
    made_folder(folder)
    made_folder(folder / PROBLEMS)
    for earlier in (folder / PROBLEMS).glob("*.npz"):
        earlier.unlink()
    for name, problem in problems.items():
        problem.scaled()[0].write(folder / PROBLEMS / f"{name}.npz")
    (folder / MODULE).write_text(_TEXT, encoding="utf-8")
    return sorted(problems)
