"""A comparison as a printed table, as the same in a notebook, and as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from html import escape
from typing import TYPE_CHECKING, Any

from .columns import COLUMNS

if TYPE_CHECKING:
    from .comparison import Comparison


def table_cells(comparison: Comparison) -> tuple[list[str], list[list[str]]]:
    """Return the headings of a comparison's table and its rows, as text."""
    return list(COLUMNS), [[cell(row) for cell in COLUMNS.values()] for row in comparison.rows]


def as_text(comparison: Comparison) -> str:
    """Return the table with what was asked for above it, remarks and verdict below."""
    headings, body = table_cells(comparison)
    table = [headings, *body]
    widths = [max(len(line[k]) for line in table) for k in range(len(headings))]
    lines = [
        "  ".join(
            cell.ljust(width) if k < 2 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in table
    ]
    head = f"{comparison.subject}, tol {comparison.tolerance} of the gap scale {comparison.problem.gap_scale:.3g}"
    return "\n".join([head, "", *(line.rstrip() for line in lines), "", *comparison.remarks(), comparison.verdict()])


def as_html(comparison: Comparison) -> str:
    """Return the same as a table for notebooks."""
    headings, rows = table_cells(comparison)
    head = "".join(f"<th>{escape(heading)}</th>" for heading in headings)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    lines = [*comparison.remarks(), comparison.verdict()]
    return (
        f"<p>{escape(comparison.subject)}, tol {escape(str(comparison.tolerance))}</p>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        + "".join(f"<p>{escape(line)}</p>" for line in lines)
    )


def as_json(comparison: Comparison, indent: int | None) -> str:
    """Return all there is as JSON, with null for infinite and undefined numbers."""
    truth = comparison.truth
    record = {
        "problem": comparison.subject,
        "tol": comparison.tol,
        "setting": comparison.setting,
        "gap_scale": comparison.problem.gap_scale,
        "agree": comparison.agree,
        "verdict": comparison.verdict(),
        "culprits": comparison.culprits,
        "false_claims": comparison.false_claims,
        "findings": comparison.findings,
        "truth": None if truth is None else {"width": truth.width} | comparison.decided,
        "backends": [asdict(row) for row in comparison.rows],
        "pairs": [asdict(pair) | {"differing_nodes": pair.differing_nodes.tolist()} for pair in comparison.pairs],
        "provenance": comparison.provenance.to_dict(),
    }
    return json.dumps(_plain(record), indent=indent, allow_nan=False)


def _plain(value: Any) -> Any:
    """Return ``value`` with every float that JSON lacks replaced by None."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
