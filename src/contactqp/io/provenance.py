"""Where a file comes from: what was solved, by whom, how well, with which versions, and when."""

from __future__ import annotations

import platform
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__

if TYPE_CHECKING:
    from ..models.base import ContactModel
    from ..models.records import Answered


def facts_of(solution: Answered, model: ContactModel) -> dict[str, Any]:
    """Return the numbers and words that hold for a whole solution, by name."""
    facts: dict[str, Any] = {
        "model": repr(model),
        "backend": solution.backend,
        "status": str(solution.status),
        "tol": solution.tol,
        "relative_bound": solution.relative_bound,
        "relative_residual": solution.relative_residual,
        "iterations": solution.iterations,
        "seconds": solution.seconds,
        "cautions": "; ".join(solution.cautions),
    }
    return facts | model.parameters


def provenance_of(solution: Answered, model: ContactModel) -> dict[str, Any]:
    """Return these facts, versions, and the time."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    versions = f"contactqp {__version__}, Python {platform.python_version()}, numpy {np.__version__}"
    found = {
        "title": f"Contact of {model!r}",
        "source": f"{versions}; backend {solution.backend}",
        "history": f"{now} written by contactqp {__version__}",
        "date_created": now,
        "contactqp_version": __version__,
    }
    return found | facts_of(solution, model) | ({"crs": model.crs} if model.crs else {})
