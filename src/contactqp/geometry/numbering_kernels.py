"""Compiled copies between vectors in node order and a `Layout`."""

from __future__ import annotations

from numba import njit

from .runs import FIRST, LAST, NODE, ROW

GRID = "float64[:, ::1]"
RUNS = "int64[:, ::1]"
READ_ONLY_VECTOR = "Array(float64, 1, 'C', readonly=True)"
"""What a kernel reads in node order: problems hand out arrays that cannot be written."""


@njit(f"void({READ_ONLY_VECTOR}, {GRID}, {RUNS})", cache=True, nogil=True)
def lay_out(vector, grid, runs):  # type: ignore[no-untyped-def]
    """Write a vector in node order on the grid."""
    for run in range(runs.shape[0]):
        i, first, last, node = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, NODE]
        row = grid[i, first:last]
        for k in range(last - first):
            row[k] = vector[node + k]


@njit(f"void({GRID}, float64[::1], {RUNS})", cache=True, nogil=True)
def take_nodes(grid, vector, runs):  # type: ignore[no-untyped-def]
    """Write the nodes' values into a vector in node order."""
    for run in range(runs.shape[0]):
        i, first, last, node = runs[run, ROW], runs[run, FIRST], runs[run, LAST], runs[run, NODE]
        row = grid[i, first:last]
        for k in range(last - first):
            vector[node + k] = row[k]
