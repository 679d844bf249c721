"""Where the answers of a comparison lie farthest apart."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.checks import Vector

if TYPE_CHECKING:
    import pandas as pd

    from .comparison import Comparison

_COLUMNS = [
    *("node", "x", "y", "larger", "smaller", "larger_gap", "smaller_gap", "larger_reaction", "smaller_reaction"),
    *("difference", "true_lower", "true_upper"),
]


def spread_of(comparison: Comparison) -> Vector:
    """Return the largest less the smallest gap of all answers at every node (length), shape (n,)."""
    largest = np.full(comparison.problem.size, -np.inf)
    smallest = np.full(comparison.problem.size, np.inf)
    for solution in comparison.usable.values():
        np.maximum(largest, solution.gap, out=largest)
        np.minimum(smallest, solution.gap, out=smallest)
    return largest - smallest if comparison.usable else np.zeros(comparison.problem.size)


def worst_nodes_of(comparison: Comparison, count: int) -> pd.DataFrame:
    """Return the nodes where the answers lie farthest apart, see `Comparison.worst_nodes`."""
    import pandas as pd

    usable = comparison.usable
    if len(usable) < 2:
        return pd.DataFrame(columns=_COLUMNS)
    nodes = np.argsort(-comparison.spread, kind="stable")[:count]
    names = np.array(list(usable))
    gaps = np.array([solution.gap[nodes] for solution in usable.values()])
    reactions = np.array([solution.reaction[nodes] for solution in usable.values()])
    at, nowhere = np.arange(nodes.size), np.full(nodes.size, np.nan)
    columns: dict[str, Any] = {"node": nodes, "x": nowhere, "y": nowhere}
    if comparison.model is not None:
        columns |= {"x": comparison.model.node_x[nodes], "y": comparison.model.node_y[nodes]}
    for side, pick in (("larger", gaps.argmax(axis=0)), ("smaller", gaps.argmin(axis=0))):
        columns[side] = names[pick]
        columns[f"{side}_gap"] = gaps[pick, at]
        columns[f"{side}_reaction"] = reactions[pick, at]
    columns["difference"] = comparison.spread[nodes]
    truth = comparison.truth
    columns["true_lower"] = nowhere if truth is None else truth.lower[nodes]
    columns["true_upper"] = nowhere if truth is None else truth.upper[nodes]
    return pd.DataFrame(columns, columns=_COLUMNS)
