"""Table 1 of the paper beside ours: as text, as CSV, and on the terminal."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import StringIO

import numpy as np

from .facts import MISPRINTED_LOAD, SURROGATE, TABLE_1, fit_cpu_time
from .reproduction import LONG_RUN_TOLERANCE, Reproduction, TableRow

_COLUMNS = 118
"""Sentences are folded at this width."""

TITLE = "Table 1 of the paper, and the same by contactqp"

RULES = (
    "Projected over-relaxation row by row from ω = 0; N counts the sweep that passes. Step: it changes no ω′ by 0.001 "
    "or more; residual: after it max|min(ω′, R′)| < 0.001; β among 1.00, 1.05, …, 1.95, all ties shown. Long run: step "
    f"{LONG_RUN_TOLERANCE:.0e}, β 0.01 apart. μ: spectral radius of Jacobi's matrix on the final free set. Theory: "
    "β = 2/(1 + √(1 - μ²)) (Young 1971)."
)

HEADINGS = (
    ("", "P′"),
    ("paper", "β₀"),
    ("", "N"),
    ("step", "best β"),
    ("", "N"),
    ("residual", "best β"),
    ("", "N"),
    ("Jacobi", "μ"),
    ("theory", "β"),
    ("long run", "best β"),
)
"""Two lines above each column: the group it begins, and what it holds."""


def cells(row: TableRow) -> tuple[str, ...]:
    """Return a row of the table as text, a column for each of `HEADINGS`."""
    doubt = "?" if row.paper.load == MISPRINTED_LOAD else ""
    return (
        f"{row.paper.load:.2f}",
        f"{row.paper.factor:.2f}",
        f"{row.paper.sweeps}{doubt}",
        listed(row.step.best),
        str(row.step.least),
        listed(row.residual.best),
        str(row.residual.least),
        f"{row.radius:.4f}",
        f"{row.optimal:.3f}",
        listed(row.long_run.best),
    )


def listed(factors: Sequence[float]) -> str:
    """Return relaxation factors as text.

    Examples
    --------
    >>> listed((1.35, 1.4))
    '1.35 1.40'
    """
    return " ".join(f"{factor:.2f}" for factor in factors)


def remarks(found: Reproduction) -> list[str]:
    """Return what the table shows, and what was verified, one sentence each."""
    fit = fit_cpu_time()
    (doubtful,) = (row for row in TABLE_1 if row.load == MISPRINTED_LOAD)
    rows = found.rows
    close = [row for row in rows if abs(row.step.least - row.paper.sweeps) <= 1]
    among = [row for row in rows if row.paper.factor in row.residual.best]
    below = [row for row in rows if max(row.step.best) < row.optimal]
    others = ", ".join(
        f"{row.paper.load:.2f}: {row.step.least} against {row.paper.sweeps}" for row in rows if row not in close
    )
    return [
        f"? N = {doubtful.sweeps} at P′ = {doubtful.load:.2f} is probably a misprint: the other nine loads fit CPU "
        f"seconds = {fit.at_start:.3f} + {fit.a_sweep:.3f} N to within {fit.deviation:.2f} s, and "
        f"the {doubtful.cpu_seconds:.2f} s of this one then give N = {fit.sweeps:.0f} or so.",
        f"Step rule: N is within 1 of the paper's at {len(close)} of {len(rows)} loads"
        + (f" (not at P′ = {others})." if others else "."),
        f"Residual rule: the paper's β₀ is among the best at {len(among)} of {len(rows)} loads.",
        f"Theory's β is the best in the long run. ε = 0.001 is met before the long run begins, and smaller factors win "
        f"there, at {len(below)} of {len(rows)} loads.",
        _on_contact_sets(found),
        _on_backends(found),
    ]


def _on_contact_sets(found: Reproduction) -> str:
    counts = " ⊂ ".join(str(int(np.count_nonzero(solution.contact))) for solution in found.path.solutions)
    if found.nested:
        return (
            f"Contact sets grow with the load, {counts} nodes: proven, certificates decide every node at every load, "
            "and none lifts off."
        )
    reasons = "; ".join(found.path.findings) or "certificates leave nodes undecided"
    return f"That contact sets grow with the load is NOT proven: {reasons}."


def _on_backends(found: Reproduction) -> str:
    if found.identical:
        return f"All {len(found.backends)} backends are certified at every load, and their contact sets are identical."
    verdicts = [
        f"at P′ = {row.paper.load:.2f}: {comparison.verdict()}"
        for row, comparison in zip(found.rows, found.comparisons, strict=True)
        if not comparison.agree
    ]
    return f"The backends' contact sets are NOT identical, or not certified. {' '.join(verdicts)}".rstrip()


def as_text(found: Reproduction) -> str:
    """Return the table with its rules above and remarks below, as lines of 120 characters at most."""
    from textwrap import fill

    body = [tuple(head for head, _ in HEADINGS), tuple(name for _, name in HEADINGS), *map(cells, found.rows)]
    widths = [max(len(line[k]) for line in body) for k in range(len(HEADINGS))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in body]
    lines.insert(2, "  ".join("-" * width for width in widths))
    notes = [fill(remark, _COLUMNS) for remark in remarks(found)]
    return "\n".join([TITLE, SURROGATE, "", fill(RULES, _COLUMNS), "", *lines, "", *notes])


def as_csv(found: Reproduction) -> str:
    """Return the table as CSV, a row for each load; several best factors of one load are separated by blanks."""
    fit = fit_cpu_time()
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(
        (
            "load", "paper_factor", "paper_sweeps", "paper_cpu_seconds", "step_best_factors", "step_sweeps",
            "residual_best_factors", "residual_sweeps", "jacobi_radius", "theory_factor", "long_run_best_factors",
            "sweeps_from_cpu_seconds", "contact_nodes",
        )
    )  # fmt: skip
    for row, solution in zip(found.rows, found.path.solutions, strict=True):
        writer.writerow(
            (
                row.paper.load,
                row.paper.factor,
                row.paper.sweeps,
                row.paper.cpu_seconds,
                listed(row.step.best),
                row.step.least,
                listed(row.residual.best),
                row.residual.least,
                f"{row.radius:.6f}",
                f"{row.optimal:.6f}",
                listed(row.long_run.best),
                f"{(row.paper.cpu_seconds - fit.at_start) / fit.a_sweep:.1f}",
                int(np.count_nonzero(solution.contact)),
            )
        )
    return stream.getvalue()


def print_table(found: Reproduction) -> None:
    """Print the table with its rules and remarks on the terminal."""
    from rich.table import Table
    from rich.text import Text

    from ..foundation.terminal import table_console

    console = table_console()
    width = min(console.width, _COLUMNS)
    console.print(Text(TITLE, style="bold"))
    console.print(Text(SURROGATE, style="yellow"))
    table = Table(box=None, header_style="bold", pad_edge=False, padding=(0, 1))
    for head, name in HEADINGS:
        table.add_column(f"{head}\n{name}", no_wrap=True)
    for row in found.rows:
        table.add_row(*cells(row))
    console.print()
    console.print(table)
    console.print()
    console.print(Text(RULES, style="dim"), width=width)
    console.print()
    colours = ["", "", "", "", "green" if found.nested else "red", "green" if found.identical else "red"]
    for remark, colour in zip(remarks(found), colours, strict=True):
        console.print(Text(remark, style=colour), width=width)
