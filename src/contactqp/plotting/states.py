"""What a picture shows of each node: in contact, clear or undecided."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .style import CLEAR, CONTACT, UNDECIDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..models.records import Answered, Enclosed

STATE_COLOURS = (CLEAR, CONTACT, UNDECIDED)
"""The colours of states 0, 1 and 2."""


def states_of(certificate: Enclosed) -> NDArray[np.int64]:
    """Return 1 in contact, 0 clear, 2 undecided."""
    return np.where(certificate.contact, 1, np.where(certificate.clear, 0, 2))


def seen(solution: Answered) -> tuple[NDArray[np.int64], str]:
    """Return the nodes' states and how sure they are: by the certificate, or else in the backend's own view."""
    if solution.certificate is None:
        return solution.contact.astype(int), ""
    return states_of(solution.certificate), "certainly "


def labels_of_states(state: NDArray[np.int64], proven: str) -> dict[int, str]:
    """Return what a legend writes of each state, with the number of such nodes; of rare states only if there are any.

    Parameters
    ----------
    state : array of int, shape (n,)
    proven : str
        ``"certainly "`` where a certificate tells the states, ``""`` where it is the backend's own view.
    """
    names = {0: f"{proven}clear" if proven else "free", 1: f"{proven}in contact", 2: "undecided"}
    counts = {k: np.count_nonzero(state == k) for k in names}
    return {k: f"{name} ({counts[k]})" for k, name in names.items() if k < 2 or counts[k]}


def draw_legend_of_states(axes: Axes, state: NDArray[np.int64], proven: str, more: Sequence[Any] = ()) -> None:
    """Write below the axes what the colours of the states mean and how many nodes there are of each."""
    from matplotlib.patches import Patch

    labels = labels_of_states(state, proven)
    handles: list[Any] = [Patch(color=STATE_COLOURS[k], label=label) for k, label in labels.items()]
    figure: Any = axes.get_figure(root=False)
    figure.legend(
        handles=[*handles, *more], loc="outside lower center", ncols=3 + len(more), frameon=False, fontsize="small"
    )
