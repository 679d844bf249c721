"""The enclosure of an answer, as text, JSON and NetCDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..foundation.files import replaced_as_a_whole
from ..foundation.json_text import json_of
from ..foundation.terminal import table_console
from ..foundation.text import at_most, folded, known_number
from ..io.writers import write_solution
from ..proof.status import DISCRETE

if TYPE_CHECKING:
    from ..solving.solution import Solution


JSON = ".json"
"""Suffix of a file for the numbers that hold for the whole."""


def print_enclosure(judged: Solution, case: Path, answer: Path) -> None:
    """Print status, bound, contact counts and residuals."""
    from rich.text import Text

    record = enclosure_of(judged, case, answer)
    console = table_console()
    colour = "bold green" if judged.status.ok else "bold red"
    console.print(Text(f"{answer}: {judged.status.value}", style=colour))
    bound = f"<= {at_most(judged.relative_bound)} of the error scale {judged.verdict.scale:.3g}; tol {judged.tol:g}"
    lines = [("case", f"{case} · {record['model']}"), ("gap error", bound), ("against", DISCRETE)]
    if judged.certificate is not None:
        contact = record["contact"]
        told = (
            f"{contact['certain']} of {judged.problem.size} nodes certainly in contact, {contact['clear']} clear, "
            f"{contact['undecided']} undecided"
        )
        lines.append(("contact", told))
    if judged.residuals is not None:
        residuals = judged.residuals
        told = (
            f"min gap {known_number(residuals.min_gap)}, min reaction {known_number(residuals.min_reaction)}, "
            f"gap·R {residuals.complementarity:.2g}, natural residual {residuals.natural_residual:.2g}"
        )
        lines.append(("conditions", told))
    lines += [("caution", caution) for caution in judged.cautions]
    for name, text in lines:
        console.print(Text(folded(f"{name:<11} {text}", console.width, 12)), soft_wrap=True)


def write_enclosure(judged: Solution, case: Path, answer: Path, path: Path) -> None:
    """Write it: the numbers that hold for the whole as JSON, or all fields in a format of solutions, by the suffix."""
    if path.suffix.lower() != JSON:
        assert judged.model is not None
        write_solution(judged, judged.model, path)
        return
    with replaced_as_a_whole(path) as unfinished:
        unfinished.write_text(json_of(enclosure_of(judged, case, answer)) + "\n", encoding="utf-8")


def enclosure_of(judged: Solution, case: Path, answer: Path) -> dict[str, Any]:
    """Return what is known of an answer: status, bounds, counts of nodes, residuals, brackets."""
    record: dict[str, Any] = {
        "case": str(case),
        "answer": str(answer),
        "model": repr(judged.model),
        "contactqp": __version__,
        "status": judged.status.value,
        "tol": judged.tol,
        "gap_scale": judged.problem.gap_scale,
        "error_scale": judged.verdict.scale,
        "relative_bound": judged.relative_bound,
        "cautions": judged.cautions,
    }
    if judged.certificate is not None:
        certificate = judged.certificate
        masks = {"certain": certificate.contact, "clear": certificate.clear, "undecided": certificate.undecided}
        record |= {
            "gap_bound": certificate.gap_bound,
            "contact": {name: int(np.count_nonzero(mask)) for name, mask in masks.items()},
            "contact_area": list(judged.contact_area),
            "total_reaction": list(judged.total_reaction),
        }
    if judged.residuals is not None:
        names = ("min_gap", "min_reaction", "complementarity", "natural_residual")
        record["residuals"] = {name: getattr(judged.residuals, name) for name in names}
        record["max_slope"] = judged.max_slope
    return record
