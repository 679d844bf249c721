"""A comparison as a printed table, and as JSON."""

from __future__ import annotations

from dataclasses import asdict

from ..foundation.json_text import json_of
from ..foundation.text import folded
from ..proof.status import DISCRETE
from .columns import BETWEEN, cells_of, fitting, printed_columns
from .compared import Compared
from .rows import records_of


def as_text(compared: Compared, room: int | None = None) -> str:
    """Return the table with what was asked for above it, remarks and verdict below.

    Parameters
    ----------
    compared : Compared
    room : int, optional
        Characters of a line: other lines go on below, and columns that there is no room for are left out. By default
        lines are as long as they are.
    """
    columns = printed_columns(compared.answers.problem)
    cells = cells_of(columns, compared.rows)
    shown = columns if room is None else fitting(cells, room)
    widths = {column: max(map(len, cells[column])) for column in shown}
    lines = [
        (" " * BETWEEN).join(
            cells[column][k].ljust(widths[column]) if column.words else cells[column][k].rjust(widths[column])
            for column in shown
        )
        for k in range(len(compared.rows) + 1)
    ]
    left_out = [column.printed for column in columns if column not in shown]
    more = [f"Left out for want of room: {', '.join(left_out)}; to_frame() has all."] if left_out else []
    head, closing = [compared.subject, asked_for(compared)], [*closing_lines(compared), *more]
    if room is not None:
        head, closing = ([folded(line, room, 0) for line in part] for part in (head, closing))
    return "\n".join([*head, "", *(line.rstrip() for line in lines), "", *closing])


def closing_lines(compared: Compared) -> list[str]:
    """Return remarks and verdict, to be read below the table."""
    return [*compared.conclusion.remarks, compared.conclusion.sentence]


def asked_for(compared: Compared) -> str:
    """Return in words what error was asked for: against what, and relative to what."""
    scale = f"{compared.answers.problem.gap_scale:.3g}"
    return f"gap errors against {DISCRETE}: tol {compared.tolerance} of the error scale, which is at most {scale}"


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
        "unproven_claims": conclusion.unproven_claims,
        "findings": conclusion.findings,
        "cautions": conclusion.cautions,
        "left_out": conclusion.left_out,
        "truth": None if answers.truth is None else {"width": answers.truth.width} | answers.decided,
        "backends": records_of(compared.rows, answers.problem),
        "pairs": [asdict(pair) | {"differing_nodes": pair.differing_nodes.tolist()} for pair in compared.pairs],
        "provenance": compared.provenance.to_dict(),
    }
    return json_of(record, indent)
