"""What a picture shows of each node: in contact, with which bound, clear or undecided."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation.loading import load_modules
from ..models.records import NodeState, states_of
from .style import CLEAR, CONTACT, CONTACT_UPPER, INK, UNDECIDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import ListedColormap

    from ..models.base import ContactModel
    from ..models.records import Answered

STATE_COLOURS: dict[int, str] = {
    NodeState.CLEAR: CLEAR,
    NodeState.CONTACT: CONTACT,
    NodeState.CONTACT_UPPER: CONTACT_UPPER,
    NodeState.UNDECIDED: UNDECIDED,
}
"""The colours of states, in the order of a legend."""


def colours_by_number() -> tuple[ListedColormap, float, float]:
    """Return a colour map of states' numbers, and the lowest and highest number that it is stretched over."""
    load_modules("matplotlib.colors")
    from matplotlib.colors import ListedColormap

    numbers = sorted(STATE_COLOURS)
    return ListedColormap([STATE_COLOURS[k] for k in numbers]), numbers[0] - 0.5, numbers[-1] + 0.5


def seen(solution: Answered) -> tuple[NDArray[np.int64], str]:
    """Return the nodes' states and how sure they are: by the certificate, or else in the backend's own view."""
    if solution.certificate is not None:
        return states_of(solution.certificate), "certainly "
    contact = np.where(solution.contact, NodeState.CONTACT.value, NodeState.CLEAR.value)
    return np.where(solution.contact_upper, NodeState.CONTACT_UPPER.value, contact), ""


def labels_of_states(state: NDArray[np.int64], proven: str) -> dict[int, str]:
    """Return what a legend writes of each state, with the number of such nodes; of rare states only if there are any.

    Parameters
    ----------
    state : array of int, shape (n,)
        Numbers of `NodeState`.
    proven : str
        ``"certainly "`` where a certificate tells the states, ``""`` where it is the backend's own view.
    """
    names = {
        NodeState.CLEAR: f"{proven}clear" if proven else "free",
        NodeState.CONTACT: f"{proven}in contact",
        NodeState.CONTACT_UPPER: f"{proven}at the upper bound",
        NodeState.UNDECIDED: "undecided",
    }
    counts = {k: np.count_nonzero(state == k) for k in names}
    common = (NodeState.CLEAR, NodeState.CONTACT)
    return {k: f"{name} ({counts[k]})" for k, name in names.items() if k in common or counts[k]}


def mark_unsupported(axes: Axes, model: ContactModel) -> list[Any]:
    """Mark the nodes below which there is no support, and return what a legend needs, if there are any."""
    pits = ~model.supported
    if not pits.any():
        return []
    size = float(np.clip(4000 / model.size, 1, 20))
    places = model.node_x[pits], model.node_y[pits]
    crosses = axes.scatter(*places, s=size, marker="x", lw=0.6, color=INK, zorder=3)
    crosses.set_label(f"no support ({np.count_nonzero(pits)})")
    return [crosses]


def draw_legend_of_states(axes: Axes, state: NDArray[np.int64], proven: str, more: Sequence[Any] = ()) -> None:
    """Write below the axes what the colours of the states mean and how many nodes there are of each."""
    load_modules("matplotlib.patches")
    from matplotlib.patches import Patch

    labels = labels_of_states(state, proven)
    handles: list[Any] = [Patch(color=STATE_COLOURS[k], label=label) for k, label in labels.items()]
    # Four states with their names take more than the width of a map.
    columns = 2 if NodeState.CONTACT_UPPER in labels else 3 + len(more)
    figure: Any = axes.get_figure(root=False)
    figure.legend(handles=[*handles, *more], loc="outside lower center", ncols=columns, frameon=False, fontsize="small")
