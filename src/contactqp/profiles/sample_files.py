"""Samples in columns of a text file: read fast, and where something is wrong, told by line and column."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import nearest
from ..foundation.files import require_file
from ..foundation.text import counted, shortened

Column = str | int
"""A column by its name, or by its position, which counts from 0."""


@dataclass(frozen=True)
class Samples:
    """Numbers from several columns.

    Attributes
    ----------
    values : array, shape (m, columns)
        Abscissae and depths, or places and depths, as they stand in the file.
    line_of : callable
        Returns the number of the line that a row of ``values`` comes from.
    names : tuple of str
        What the columns are called, for messages.
    """

    values: NDArray[np.float64]
    line_of: Callable[[int], int]
    names: tuple[str, ...]


def read_samples(
    path: Path, columns: Mapping[str, Column], *, delimiter: str | None, decimal: str, unchecked: str = ""
) -> Samples:
    """Read columns of numbers; see `Sampled.from_csv`.

    Parameters
    ----------
    path : Path
    columns : dict
        The columns, by what they mean.
    delimiter : str or None
        What separates the columns; None for blanks.
    decimal : str
        What begins the decimals of a number.
    unchecked : str
        The meaning of a column that may hold nan and inf.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If a column is missing, or a cell is no finite number.
    """
    chosen = list(columns.values())
    if len(set(chosen)) < len(chosen):
        *others, last = columns
        twice = next(column for column in chosen if chosen.count(column) > 1)
        both = "both" if not others[1:] else "several"
        raise ValueError(f"{', '.join(others)} and {last} must be different columns, got {twice!r} for {both}")
    check_separators(delimiter, decimal)
    require_file(path)
    table = _Table(path, delimiter, decimal)
    line, first = table.first_row()
    places = tuple(_place(first, column, path) for column in chosen)
    named = any(isinstance(column, str) for column in chosen)
    header = named or not any(place < len(first) and table.number(first[place]) is not None for place in places)
    names = tuple(_name(meaning, column, first if header else []) for meaning, column in columns.items())
    samples = table.samples(line if header else 0, places, names)
    checked = [meaning != unchecked for meaning in columns]
    bad = np.argwhere(~np.isfinite(samples.values) & checked)
    if bad.size:
        row, k = map(int, bad[0])
        raise ValueError(
            f"{path}, line {samples.line_of(row)}: {names[k]} must be finite, got {samples.values[row, k]}"
        )
    return samples


def read_points(
    path: Path,
    x: Column | None = None,
    y: Column | None = None,
    depth: Column | None = None,
    *,
    delimiter: str | None,
    decimal: str,
    called: str = "depth",
    unchecked: bool = False,
) -> Samples:
    """Read places and what is known there, shape (m, 3); see `Scattered.from_file`.

    Parameters
    ----------
    path : Path
    x, y, depth : str, int or None
        The columns; names may differ from the header's in capitals.
    delimiter : str or None
        What separates the columns, if the first row has it; otherwise blanks do. None for what the first row has.
    decimal : str
        What begins the decimals of a number.
    called : str
        The argument by which a user chooses the third column, for messages.
    unchecked : bool
        Whether the third column may hold nan and inf.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        See `read_samples`.
    """
    check_separators(delimiter, decimal)
    require_file(path)
    found = _delimiter_in(path, delimiter, decimal)
    table = _Table(path, found, decimal)
    _, first = table.first_row()
    given = (x, y, depth)
    if any(isinstance(column, str) for column in given) or all(table.number(cell) is None for cell in first):
        places = [_spelled(name if column is None else column, first) for column, name in ((x, "x"), (y, "y"))]
        others = [name for k, name in enumerate(first) if name not in places and k not in places]
        if depth is None and len(others) != 1:
            raise ValueError(
                f"{path}: choose one of its columns by {called}: {', '.join(others) or 'there is no other'}"
            )
        chosen = [*places, others[0] if depth is None else _spelled(depth, first)]
    else:
        chosen = [k if column is None else column for k, column in enumerate(given)]
    columns = dict(zip(("x", "y", "depth"), chosen, strict=True))
    return read_samples(path, columns, delimiter=found, decimal=decimal, unchecked="depth" if unchecked else "")


def first_cells(path: Path, delimiter: str | None, decimal: str) -> list[float | None]:
    """Return the numbers in the first row of a file of points, None for a cell that holds none; see `read_points`."""
    table = _Table(path, _delimiter_in(path, delimiter, decimal), decimal)
    return [table.number(cell) for cell in table.first_row()[1]]


def _delimiter_in(path: Path, delimiter: str | None, decimal: str) -> str | None:
    """Return what separates the columns of a file's first row, None for blanks."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        first = next((line for line in file if not _passed_over(line)), "")
    known = [each for each in (";", "\t", ",") if each != decimal] if delimiter is None else [delimiter]
    return next((each for each in known if each in first.strip()), None)


def _spelled(column: Column, header: list[str]) -> Column:
    """Return a column's name as the header writes it, if that differs in capitals only."""
    if not isinstance(column, str) or column in header:
        return column
    return next((name for name in header if name.lower() == column.lower()), column)


def check_separators(delimiter: str | None, decimal: str) -> None:
    """Raise a ValueError, if a table cannot be divided by such a delimiter, or its numbers by such a decimal sign.

    None stands for blanks.

    Examples
    --------
    >>> check_separators(",", ",")
    Traceback (most recent call last):
    ...
    ValueError: delimiter and decimal must differ, got ',' for both
    """
    if decimal not in (".", ","):
        raise ValueError(f"decimal must be '.' or ',', got {decimal!r}")
    if delimiter is None:
        return
    if not isinstance(delimiter, str) or len(delimiter) != 1 or delimiter in '"#\r\n+-eE_' or delimiter.isalnum():
        raise ValueError(f"delimiter must be one character that is in no number, such as ',' or ';', got {delimiter!r}")
    if delimiter == decimal:
        raise ValueError(f"delimiter and decimal must differ, got {delimiter!r} for both")


@dataclass(frozen=True)
class _Table:
    path: Path
    delimiter: str | None
    decimal: str

    def number(self, cell: str) -> float | None:
        """Return what a cell holds, None if that is no number."""
        try:
            return float(cell.replace(self.decimal, ".") if self.decimal != "." else cell)
        except ValueError:
            return None

    def first_row(self) -> tuple[int, list[str]]:
        """Return the first row that `rows` yields."""
        found = next(self.rows(), None)
        if found is None:
            raise ValueError(f"{self.path}: it has no rows")
        return found

    def rows(self, passed_over: int = 0) -> Iterator[tuple[int, list[str]]]:
        """Yield the rows that hold something and are no comments, each with the number of its line."""
        with self.path.open(encoding="utf-8-sig", newline="") as file:
            try:
                for line, cells in self._cells(islice(file, passed_over, None)):
                    row = [cell.strip() for cell in cells]
                    if any(row) and not row[0].startswith("#"):
                        yield passed_over + line, row
            except (UnicodeDecodeError, csv.Error) as error:
                raise ValueError(f"{self.path}: not a table in UTF-8: {error}") from None

    def _cells(self, lines: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
        if self.delimiter is None:
            yield from enumerate((line.split() for line in lines), 1)
            return
        reader = csv.reader(lines, delimiter=self.delimiter, skipinitialspace=True)
        for cells in reader:
            yield reader.line_num, cells

    def samples(self, header: int, places: tuple[int, ...], names: tuple[str, ...]) -> Samples:
        """Return the numbers in some columns below a line."""
        try:
            with self.path.open(encoding="utf-8-sig") as file:
                values = self._numbers(islice(file, header, None), places)
        except ValueError as error:
            # Where it failed, most files have an error to be told; the others are read cell by cell.
            near = re.search(r"at row (\d+)", str(error))
            if near is not None:
                self._cell_by_cell(self._line_of(max(0, int(near[1]) - 1), header) - 1, places, names, rows=3)
            return self._cell_by_cell(header, places, names)
        return Samples(values, lambda row: self._line_of(row, header), names)

    def _numbers(self, lines: Iterator[str], places: tuple[int, ...]) -> NDArray[np.float64]:
        if self.decimal != ".":
            lines = (line.replace(self.decimal, ".") for line in lines)
        begun = next((line for line in lines if not _passed_over(line)), None)
        if begun is None:
            return np.empty((0, len(places)))

        def all_lines() -> Iterator[str]:
            yield begun
            yield from lines

        return np.loadtxt(all_lines(), delimiter=self.delimiter, usecols=places, ndmin=2, quotechar='"')

    def _cell_by_cell(
        self, header: int, places: tuple[int, ...], names: tuple[str, ...], rows: int | None = None
    ) -> Samples:
        values: list[list[float]] = []
        lines: list[int] = []
        for line, cells in islice(self.rows(header), rows):
            where = f"{self.path}, line {line}"
            values.append([self._cell(cells, place, name, where) for place, name in zip(places, names, strict=True)])
            lines.append(line)
        return Samples(np.array(values, dtype=np.float64).reshape(-1, len(places)), lines.__getitem__, names)

    def _cell(self, cells: list[str], place: int, name: str, where: str) -> float:
        if not 0 <= place < len(cells):
            columns = counted(len(cells), "column")
            raise ValueError(f"{where}: no column {place}, it has {columns}, counted from 0")
        value = self.number(cells[place])
        if value is None:
            hint = "; decimal=',' reads it" if self.decimal == "." and _with_comma(cells[place]) else ""
            raise ValueError(f"{where}: {name} is {shortened(cells[place])!r}, which is no number{hint}")
        return value

    def _line_of(self, row: int, header: int) -> int:
        with self.path.open(encoding="utf-8-sig") as file:
            lines = (number for number, line in enumerate(file, 1) if number > header and not _passed_over(line))
            return next(islice(lines, row, None), header + 1 + row)


def _passed_over(line: str) -> bool:
    text = line.strip()
    return not text or text.startswith("#")


def _with_comma(cell: str) -> bool:
    return re.fullmatch(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", cell) is not None


def _place(header: list[str], column: Column, path: Path) -> int:
    if not isinstance(column, str):
        return column
    if column not in header:
        found = shortened(", ".join(header), 200)
        raise ValueError(f"{path}: no column {column!r}; it has {found}{nearest(column, header)}")
    if header.count(column) > 1:
        raise ValueError(f"{path}: {header.count(column)} columns are called {column!r}; choose one by position")
    return header.index(column)


def _name(meaning: str, column: Column, header: list[str]) -> str:
    """Return what messages call a column: what it means, and its name in the file where that is another."""
    found = column
    if not isinstance(column, str) and 0 <= column < len(header):
        found = header[column]
    return meaning if found == meaning else f"{meaning} (column {found!r})"
