"""The nodes where answers lie farthest apart, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..foundation.loading import load_modules
from .answers import Answers

if TYPE_CHECKING:
    import pandas as pd

_COLUMNS = [
    *("node", "x", "y", "larger", "smaller", "larger_gap", "smaller_gap", "larger_reaction", "smaller_reaction"),
    *("difference", "true_lower", "true_upper"),
]


def worst_nodes(answers: Answers, count: int) -> pd.DataFrame:
    """Return at most ``count`` nodes where the finite answers lie farthest apart, see `Comparison.worst_nodes`."""
    load_modules("pandas")
    import pandas as pd

    if len(answers.finite) < 2:
        return pd.DataFrame(columns=_COLUMNS)
    nodes = np.argsort(-answers.spread, kind="stable")[:count]
    names = np.array(list(answers.finite))
    gaps = np.array([solution.gap[nodes] for solution in answers.finite.values()])
    reactions = np.array([solution.reaction[nodes] for solution in answers.finite.values()])
    at, nowhere = np.arange(nodes.size), np.full(nodes.size, np.nan)
    columns: dict[str, Any] = {"node": nodes, "x": nowhere, "y": nowhere}
    if answers.model is not None:
        columns |= {"x": answers.model.node_x[nodes], "y": answers.model.node_y[nodes]}
    for side, pick in (("larger", gaps.argmax(axis=0)), ("smaller", gaps.argmin(axis=0))):
        columns[side] = names[pick]
        columns[f"{side}_gap"] = gaps[pick, at]
        columns[f"{side}_reaction"] = reactions[pick, at]
    columns["difference"] = answers.spread[nodes]
    truth = answers.truth
    columns["true_lower"] = nowhere if truth is None else truth.lower[nodes]
    columns["true_upper"] = nowhere if truth is None else truth.upper[nodes]
    return pd.DataFrame(columns, columns=_COLUMNS)
