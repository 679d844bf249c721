"""A comparison as a printed table, and as JSON."""

from __future__ import annotations

from dataclasses import asdict

from ..foundation.json_text import json_of
from ..proof.status import DISCRETE
from .columns import printed_columns
from .compared import Compared
from .rows import records_of


def as_text(compared: Compared) -> str:
    """Return the table with what was asked for above it, remarks and verdict below."""
    columns = printed_columns(compared.answers.problem)
    table = [
        [column.printed for column in columns],
        *([column.text(row) for column in columns] for row in compared.rows),
    ]
    widths = [max(map(len, cells)) for cells in zip(*table, strict=True)]
    lines = [
        "  ".join(
            cell.ljust(width) if column.words else cell.rjust(width)
            for column, cell, width in zip(columns, line, widths, strict=True)
        )
        for line in table
    ]
    return "\n".join(
        [compared.subject, asked_for(compared), "", *(line.rstrip() for line in lines), "", *closing_lines(compared)]
    )


def closing_lines(compared: Compared) -> list[str]:
    """Return remarks and verdict, to be read below the table."""
    return [*compared.conclusion.remarks, compared.conclusion.sentence]


def asked_for(compared: Compared) -> str:
    """Return in words what error was asked for: against what, and relative to what."""
    scale = f"{compared.answers.problem.gap_scale:.3g}"
    return f"gap errors against {DISCRETE}: tol {compared.tolerance} of the error scale, at most {scale}"


def as_json(compared: Compared, indent: int | None) -> str:
    """Return all there is as JSON, with null for infinite and undefined numbers."""
    answers, conclusion = compared.answers, compared.conclusion
    record = {
        "problem": compared.subject,
        "tol": compared.tolerance.tol,
        "setting": compared.tolerance.setting,
        "gap_scale": answers.problem.gap_scale,
        "agree": conclusion.agree,
        "verdict": conclusion.sentence,
        "culprits": conclusion.culprits,
        "false_claims": conclusion.false_claims,
        "findings": conclusion.findings,
        "cautions": conclusion.cautions,
        "left_out": conclusion.left_out,
        "truth": None if answers.truth is None else {"width": answers.truth.width} | answers.decided,
        "backends": records_of(compared.rows, answers.problem),
        "pairs": [asdict(pair) | {"differing_nodes": pair.differing_nodes.tolist()} for pair in compared.pairs],
        "provenance": compared.provenance.to_dict(),
    }
    return json_of(record, indent)
