"""What answers and certificates tell of themselves in a notebook."""

from __future__ import annotations

from functools import singledispatch
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..foundation.cards import card, pixels
from ..foundation.text import at_most
from ..models.base import ContactModel
from ..models.on_lattice import LatticeModel
from ..models.records import NodeState, states_of, subject_of
from .states import STATE_COLOURS, labels_of_states, seen

if TYPE_CHECKING:
    from ..models.records import Answered, Enclosed
    from ..problem.contact_problem import ContactProblem

_OUTSIDE = 255, 255, 255


def solution_card(solution: Answered, facts: dict[str, str]) -> str:
    """Return a solution's facts as HTML, on a membrane beside the map of what is known of the nodes."""
    state = str(solution.status).replace("_", " ")
    title = f"Solution by {solution.backend}: {state}"
    if not solution.finite:
        return card(title, facts)
    states, proven = seen(solution)
    facts = facts | {"nodes": ", ".join(labels_of_states(states, proven).values())}
    return card(title, facts, state_map(subject_of(solution), states))


def certificate_card(certificate: Enclosed, model: ContactModel | None) -> str:
    """Return as HTML what a certificate proves, on a membrane beside the map of that."""
    states = states_of(certificate)
    facts = {
        "gap error": f"<= {at_most(certificate.gap_bound)}",
        "nodes": ", ".join(labels_of_states(states, "certainly ").values()),
        "barrier": certificate.barrier,
        "model": "" if model is None else repr(model),
    }
    return card("Certificate", facts, "" if model is None else state_map(model, states))


@singledispatch
def state_map(model: ContactModel | ContactProblem, states: NDArray[np.int64]) -> str:
    """Return a small map of the nodes' states as HTML; none but where they lie on a lattice of more than one row."""
    return ""


@state_map.register(LatticeModel)
def _map_of_lattice(model: LatticeModel, states: NDArray[np.int64]) -> str:
    lattice = model.lattice
    if min(lattice.shape) == 1:
        return ""
    numbers = sorted(STATE_COLOURS)
    palette = np.array([_OUTSIDE, *(_rgb(STATE_COLOURS[NodeState(k)]) for k in numbers)], dtype=np.uint8)
    place = lattice.scatter(np.searchsorted(numbers, states) + 1, fill=0).astype(np.intp)
    return pixels(palette[place[::-1]], "Contact map, y upwards")


def _rgb(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))
