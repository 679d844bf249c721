"""The columns of what is shown of a comparison's rows, in the printed table and on the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ..foundation.text import at_least, at_most, count, known_number, number, seconds
from ..problem.contact_problem import ContactProblem
from .rows import Row


@dataclass(frozen=True)
class Column:
    """What is shown of every row under one heading.

    Attributes
    ----------
    text : callable
        Returns what a row shows, ``-`` where the row has nothing.
    printed : str
        Heading in the printed table; empty if the column is not in it.
    group, heading : str
        Which of `GROUPS` the column belongs to on the page, and its heading there; empty if it is not on the page.
    words : bool
        Whether it shows words, which are aligned to the left, and not a number.
    between : str
        Heading in the printed table where the problem has an upper bound, if it is another one there.
    upper_bound : bool
        Whether it is shown only where the problem has an upper bound.
    beyond : bool
        Whether it is shown only where the matrix is no M-matrix, so that an answer may be without a bound.
    rank : int
        Where the table is narrow, columns of a smaller rank are shown before those of a larger one; those of rank 0
        always are.
    """

    text: Callable[[Row], str]
    printed: str = ""
    group: str = ""
    heading: str = ""
    words: bool = False
    between: str = ""
    upper_bound: bool = False
    beyond: bool = False
    rank: int = 0


_ERROR, _OPTIMALITY, _CONTACT, _WORK = "Error of the gap", "Optimality conditions", "Contact", "Work and time"

GROUPS = (_ERROR, _OPTIMALITY, _CONTACT, _WORK)
"""The page has a table for each of these, in this order."""

COLUMNS = (
    Column(lambda row: row.backend, "backend", words=True),
    Column(lambda row: row.status.replace("_", " "), "status", _ERROR, "status", words=True),
    Column(lambda row: _yes_or_no(row.claimed), "", _ERROR, "said to be solved", words=True),
    Column(lambda row: count(row.iterations), "iterations", _WORK, "iterations", rank=2),
    Column(lambda row: seconds(_first_run_seconds(row)), "seconds"),
    Column(lambda row: seconds(row.loading_seconds), "", _WORK, "loading (s)"),
    Column(lambda row: seconds(row.cold_seconds), "", _WORK, "cold (s)"),
    Column(lambda row: seconds(row.setup_seconds), "", _WORK, "set-up (s)"),
    Column(lambda row: seconds(row.solve_seconds), "", _WORK, "solve (s)"),
    Column(lambda row: seconds(row.warm_seconds), "", _WORK, "warm (s)"),
    Column(lambda row: number(row.relative_bound), "bound/scale", _ERROR, "bound / scale"),
    Column(
        lambda row: number(row.relative_residual),
        "residual/scale",
        _OPTIMALITY,
        "residual / scale",
        beyond=True,
        rank=1,
    ),
    Column(lambda row: number(row.relative_true_error), "true error", _ERROR, "true error / scale", rank=1),
    Column(lambda row: number(row.gap_bound), "", _ERROR, "bound"),
    Column(lambda row: _true_error(row), "", _ERROR, "true error"),
    Column(lambda row: known_number(row.min_gap), "min gap", rank=5, between="min slack"),
    Column(lambda row: known_number(row.min_reaction), "min R", rank=6, between="min push"),
    Column(lambda row: number(row.primal_residual), "", _OPTIMALITY, "primal residual"),
    Column(lambda row: number(row.dual_residual), "", _OPTIMALITY, "dual residual"),
    Column(lambda row: number(row.complementarity), "gap·R", _OPTIMALITY, "duality gap", rank=4, between="slack·R"),
    Column(lambda row: number(row.natural_residual), "", _OPTIMALITY, "natural residual"),
    Column(lambda row: number(row.objective, 8), "", _OPTIMALITY, "objective"),
    Column(lambda row: count(row.contact), "contact", _CONTACT, "in contact"),
    Column(lambda row: count(row.contact_upper), "at upper", _CONTACT, "at the upper bound", upper_bound=True),
    Column(lambda row: count(row.undecided), "undecided", _CONTACT, "undecided", rank=3),
    Column(lambda row: number(row.contact_jaccard), "", _CONTACT, "Jaccard distance"),
    Column(lambda row: number(row.boundary_distance), "", _CONTACT, "boundary distance"),
)
"""All columns, in the order of the printed table.

The true error that the printed table shows is its upper bound, relative to the same scale as the certified bound.
"""


def printed_columns(problem: ContactProblem) -> list[Column]:
    """Return the columns of the printed table for the answers to a problem."""
    shown = [column for column in _suitable(problem) if column.printed]
    if problem.one_sided:
        return shown
    return [replace(column, printed=column.between or column.printed) for column in shown]


BETWEEN = 2
"""Blanks between the columns of the printed table."""


def width_of(cells: Mapping[Column, list[str]], columns: Sequence[Column], length: Callable[[str], int] = len) -> int:
    """Return the width of a table of some columns, by what stands in them below each other."""
    return sum(max(map(length, cells[column])) for column in columns) + BETWEEN * (len(columns) - 1)


def fitting(cells: Mapping[Column, list[str]], room: int, length: Callable[[str], int] = len) -> list[Column]:
    """Return the columns that a line has room for, those of low rank first, in their order."""
    chosen = [column for column in cells if not column.rank]
    for column in sorted((column for column in cells if column.rank), key=lambda column: column.rank):
        if width_of(cells, [*chosen, column], length) > room:
            break
        chosen.append(column)
    return [column for column in cells if column in chosen]


def cells_of(columns: Sequence[Column], rows: Sequence[Row]) -> dict[Column, list[str]]:
    """Return what stands in each column of the printed table, its heading first."""
    return {column: [column.printed, *(column.text(row) for row in rows)] for column in columns}


def columns_of(group: str, problem: ContactProblem) -> list[Column]:
    """Return the columns of one of the `GROUPS` for the answers to a problem."""
    return [column for column in _suitable(problem) if column.group == group]


def _suitable(problem: ContactProblem) -> list[Column]:
    shown = [column for column in COLUMNS if not (column.upper_bound and problem.one_sided)]
    return [column for column in shown if not (column.beyond and problem.is_m_matrix)]


def _first_run_seconds(row: Row) -> float | None:
    """Return the time that the first run took for set-up and iterations together."""
    if row.setup_seconds is None or row.solve_seconds is None:
        return None
    return row.setup_seconds + row.solve_seconds


def _yes_or_no(value: bool | None) -> str:
    return "-" if value is None else "yes" if value else "no"


def _true_error(row: Row) -> str:
    """Return the two lengths between which the true error lies; one of them if both are written alike."""
    if row.true_error_lower is None or row.true_error_upper is None:
        return "-"
    about = number(row.true_error_lower)
    if about == number(row.true_error_upper):
        return about
    return f"{at_least(row.true_error_lower)} to {at_most(row.true_error_upper)}"
