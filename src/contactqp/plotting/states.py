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


def draw_legend_of_states(axes: Axes, state: NDArray[np.int64], proven: str, more: Sequence[Any] = ()) -> None:
    """Write below the axes what the colours of the states mean and how many nodes there are of each."""
    from matplotlib.patches import Patch

    labels = [f"{proven}clear", f"{proven}in contact", "undecided"]
    handles: list[Any] = [
        Patch(color=colour, label=f"{label} ({np.count_nonzero(state == k)})")
        for k, (colour, label) in enumerate(zip((CLEAR, CONTACT, UNDECIDED), labels, strict=True))
        if k < 2 or (state == 2).any()
    ]
    figure: Any = axes.get_figure(root=False)
    figure.legend(
        handles=[*handles, *more], loc="outside lower center", ncols=3 + len(more), frameon=False, fontsize="small"
    )


def seen(solution: Answered) -> tuple[NDArray[np.int64], str]:
    """Return the nodes' states and how sure they are: by the certificate, or else in the backend's own view."""
    if solution.certificate is None:
        return solution.contact.astype(int), ""
    return states_of(solution.certificate), "certainly "


def states_of(certificate: Enclosed) -> NDArray[np.int64]:
    """Return 1 in contact, 0 clear, 2 undecided."""
    return np.where(certificate.contact, 1, np.where(certificate.clear, 0, 2))
