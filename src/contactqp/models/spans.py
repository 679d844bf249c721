"""Spans: the free spans of a cable or a beam and the stretches where it lies on the ground."""

from __future__ import annotations

from math import fsum
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from ..foundation.brackets import Bracket, sum_between
from ..foundation.checks import Mask, Vector
from ..foundation.loading import load_modules

if TYPE_CHECKING:
    import pandas as pd

    from ..geometry.lattice import Lattice
    from .records import Answered, Enclosed


class Line(Protocol):
    """What is read of a model along x, see `LineModel`."""

    noun: ClassVar[str]
    lattice: Lattice

    @property
    def point_x(self) -> Vector: ...  # noqa: D102
    @property
    def node_x(self) -> Vector: ...  # noqa: D102
    @property
    def reference(self) -> Vector: ...  # noqa: D102
    def along_points(self, below: Vector) -> Vector: ...  # noqa: D102
    def clearance(self, gap: Vector) -> Vector: ...  # noqa: D102
    def facts_of_span(self, solution: Answered, nodes: slice) -> dict[str, float]: ...  # noqa: D102


def spans_of(line: Line, solution: Answered) -> pd.DataFrame:
    """Return the rows of `LineModel.spans`."""
    load_modules("pandas")
    import pandas as pd

    _check(line, solution)
    contact = solution.contact
    changes = np.flatnonzero(contact[1:] != contact[:-1]) + 1
    first, last = np.concatenate([[0], changes]), np.concatenate([changes - 1, [contact.size - 1]])
    points, below = line.point_x, line.along_points(line.reference - solution.gap)
    clearance, node_x = line.clearance(solution.gap), line.node_x
    before = int(points[0] != node_x[0])
    certificate = solution.certificate
    decided = np.pad(_as_told(solution), 1, constant_values=certificate is not None)
    rows = []
    for one, other in zip(first.tolist(), last.tolist(), strict=True):
        nodes, in_contact = slice(one, other + 1), bool(contact[one])
        # Points are counted from the line's end; a free span goes on to the points beside its nodes, if there are any.
        first_point, last_point = one + before, other + before
        stretch = slice(first_point, last_point + 1)
        if not in_contact:
            stretch = slice(max(first_point - 1, 0), last_point + 2)
        x, w = points[stretch], below[stretch]
        gap, gap_at = (np.nan, np.nan) if in_contact else _largest_gap(clearance[nodes], node_x[nodes])
        bounds = Bracket(np.nan, np.nan)
        if certificate is not None:
            bounds = sum_between(*(bound[nodes] for bound in certificate.reaction))
        rows.append(
            {
                "kind": "contact" if in_contact else "free",
                "start": x[0],
                "end": x[-1],
                "length": x[-1] - x[0],
                "nodes": other + 1 - one,
                "largest_gap": gap,
                "largest_gap_at": gap_at,
                "sag": np.nan if in_contact else _sag(x, w),
                "largest_slope": np.abs(np.diff(w)).max() / line.lattice.spacing if x.size > 1 else np.nan,
                "reaction": fsum(solution.reaction[nodes]) if in_contact else 0.0,
                "reaction_lower": bounds.lower,
                "reaction_upper": bounds.upper,
                "certain": bool(decided[[one, one + 1, other + 1, other + 2]].all()),
                "undecided": _undecided(certificate, nodes),
                **line.facts_of_span(solution, nodes),
            }
        )
    return pd.DataFrame(rows, columns=list(rows[0]))


def _as_told(solution: Answered) -> Mask:
    """Return where the certificate proves what the answer says of a node."""
    certificate = solution.certificate
    if certificate is None:
        return np.zeros(solution.contact.size, dtype=np.bool_)
    held = np.where(solution.contact_upper, certificate.contact_upper, certificate.contact_lower)
    return np.where(solution.contact, held, certificate.clear)


def _undecided(certificate: Enclosed | None, nodes: slice) -> int:
    return nodes.stop - nodes.start if certificate is None else int(np.count_nonzero(certificate.undecided[nodes]))


def _largest_gap(clearance: Vector, x: Vector) -> tuple[float, float]:
    over_support = np.isfinite(clearance)
    if not over_support.any():
        return np.nan, np.nan
    largest = int(np.argmax(np.where(over_support, clearance, -np.inf)))
    return float(clearance[largest]), float(x[largest])


def _sag(x: Vector, w: Vector) -> float:
    """Return how far a span hangs below the chord of its ends."""
    along = (x - x[0]) / (x[-1] - x[0])
    return float((w - ((1 - along) * w[0] + along * w[-1])).max())


def _check(line: Line, solution: Any) -> None:
    """Raise unless ``solution`` is a finite answer for this very model."""
    if not hasattr(solution, "model"):
        raise TypeError(
            f"solution must be a Solution, got {type(solution).__name__}; take what contactqp.solve returns"
        )
    if solution.model is not line:
        other = solution.problem if solution.model is None else solution.model
        raise ValueError(
            f"solution must be of this {line.noun}, got one of {other!r}; use solution.model.spans(solution)"
        )
    if not solution.finite:
        raise ValueError(f"solution holds no finite answer: {solution.backend} said {solution.termination!r}")
