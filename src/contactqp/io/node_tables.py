"""Tables of nodes: a line for each node below a line of names, as ``contactqp solve --out x.csv`` writes them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from ..errors import CaseFileError
from ..foundation.checks import Vector

NODE = "node"
"""Name of the column with the nodes' numbers, which tells such a table from an array."""


def is_node_table(path: Path) -> bool:
    """Whether the first line of a .csv file has names, and ``node`` among them."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as lines:
        return NODE in _names(lines.readline(_LONGEST))


_LONGEST = 100_000
"""Characters of a line of names."""


def read_node_table(path: Path, size: int) -> dict[str, Vector]:
    """Return the columns of a table in node order, by their names.

    Parameters
    ----------
    path : Path
    size : int
        Number of nodes; each must have one line, wherever it stands.

    Raises
    ------
    CaseFileError
        If a line has too few entries or one that is no number, or nodes are missing or repeated.
    """
    with path.open(encoding="utf-8-sig", newline="") as lines:
        names = _names(lines.readline(_LONGEST))
        table = np.array([_numbers(line, number, names) for number, line in enumerate(csv.reader(lines), 2) if line])
    table = table.reshape(-1, len(names))
    order = np.argsort(table[:, names.index(NODE)], kind="stable")
    if len(table) != size or (table[order, names.index(NODE)] != np.arange(size)).any():
        raise CaseFileError(
            f"its column {NODE} must hold each of 0, ..., {size - 1} once, got {len(table)} lines; "
            "is it the answer to another case?"
        )
    return {name: table[order, k] for k, name in enumerate(names)}


def _names(line: str) -> list[str]:
    return [name.strip() for name in line.split(",")]


def _numbers(line: list[str], number: int, names: list[str]) -> list[float]:
    if len(line) != len(names):
        raise CaseFileError(f"line {number} has {len(line)} entries, and the line of names {len(names)}")
    try:
        return [float(entry) for entry in line]
    except ValueError as error:
        raise CaseFileError(f"line {number}: {error}; write numbers only") from None
