"""Table 1 of the paper beside ours as LaTeX, which needs no package."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .facts import SURROGATE
from .table import HEADINGS, TITLE, cells

if TYPE_CHECKING:
    from .reproduction import Reproduction

_SYMBOLS = {"P′": "$P'$", "β₀": r"$\beta_0$", "β": r"$\beta$", "μ": r"$\mu$", "N": "$N$"}


def as_latex(found: Reproduction) -> str:
    r"""Return the table as a ``table`` environment, to be read by ``\input``."""
    groups: list[list[str]] = []
    for head, name in HEADINGS:
        # A column without a group of its own stands below the one before, but for the first.
        if head or not groups:
            groups.append([head])
        groups[-1].append(name)
    over = " & ".join(rf"\multicolumn{{{len(names)}}}{{l}}{{{head}}}" for head, *names in groups)
    names = " & ".join(_in_symbols(name) for _, name in HEADINGS)
    rows = [" & ".join(cells(row)) + r" \\" for row in found.rows]
    return "\n".join(
        [
            r"\begin{table}",
            r"  \centering",
            rf"  \caption{{{TITLE}. {SURROGATE} A question mark: probably a misprint.}}",
            rf"  \begin{{tabular}}{{{'l' * len(HEADINGS)}}}",
            r"    \hline",
            rf"    {over} \\",
            rf"    {names} \\",
            r"    \hline",
            *(f"    {row}" for row in rows),
            r"    \hline",
            r"  \end{tabular}",
            r"\end{table}",
            "",
        ]
    )


def _in_symbols(name: str) -> str:
    r"""Return a heading with its symbols as formulas.

    Examples
    --------
    >>> _in_symbols("best β")
    'best $\\beta$'
    """
    return " ".join(_SYMBOLS.get(word, word) for word in name.split())
