"""Samples in two columns of a CSV file: read fast, and where something is wrong, told by line and column."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import nearest
from ..foundation.text import counted, shortened

Column = str | int
"""A column by its name, or by its position, which counts from 0."""


@dataclass(frozen=True)
class Samples:
    """Numbers from two columns.

    Attributes
    ----------
    values : array, shape (m, 2)
        Abscissae and depths as they stand in the file.
    line_of : callable
        Returns the number of the line that a row of ``values`` comes from.
    names : tuple of str
        What the two columns are called, for messages.
    """

    values: NDArray[np.float64]
    line_of: Callable[[int], int]
    names: tuple[str, str]


def read_samples(path: Path, x: Column, depth: Column, *, delimiter: str, decimal: str) -> Samples:
    """Read the columns of abscissae and depths; see `Sampled.from_csv`.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If a column is missing, or a cell is no finite number.
    """
    if x == depth:
        raise ValueError(f"x and depth must be different columns, got {x!r} for both")
    check_separators(delimiter, decimal)
    table = _Table(path, delimiter, decimal)
    line, first = next(table.rows(), (0, []))
    if not first:
        raise ValueError(f"{path}: it has no rows")
    places = _place(first, x, path), _place(first, depth, path)
    named = isinstance(x, str) or isinstance(depth, str)
    header = named or not any(place < len(first) and table.number(first[place]) is not None for place in places)
    names = _name("x", x, first if header else []), _name("depth", depth, first if header else [])
    samples = table.samples(line if header else 0, places, names)
    bad = np.argwhere(~np.isfinite(samples.values))
    if bad.size:
        row, k = map(int, bad[0])
        raise ValueError(
            f"{path}, line {samples.line_of(row)}: {names[k]} must be finite, got {samples.values[row, k]}"
        )
    return samples


def check_separators(delimiter: str, decimal: str) -> None:
    """Raise a ValueError, if a table cannot be divided by such a delimiter, or its numbers by such a decimal sign.

    Examples
    --------
    >>> check_separators(",", ",")
    Traceback (most recent call last):
    ...
    ValueError: delimiter and decimal must differ, got ',' for both
    """
    if decimal not in (".", ","):
        raise ValueError(f"decimal must be '.' or ',', got {decimal!r}")
    if not isinstance(delimiter, str) or len(delimiter) != 1 or delimiter in '"#\r\n+-eE_' or delimiter.isalnum():
        raise ValueError(f"delimiter must be one character that is in no number, such as ',' or ';', got {delimiter!r}")
    if delimiter == decimal:
        raise ValueError(f"delimiter and decimal must differ, got {delimiter!r} for both")


@dataclass(frozen=True)
class _Table:
    path: Path
    delimiter: str
    decimal: str

    def number(self, cell: str) -> float | None:
        """Return what a cell holds, None if that is no number."""
        try:
            return float(cell.replace(self.decimal, ".") if self.decimal != "." else cell)
        except ValueError:
            return None

    def rows(self, passed_over: int = 0) -> Iterator[tuple[int, list[str]]]:
        """Yield the rows that hold something and are no comments, each with the number of its line."""
        with self.path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(islice(file, passed_over, None), delimiter=self.delimiter, skipinitialspace=True)
            try:
                for cells in reader:
                    row = [cell.strip() for cell in cells]
                    if any(row) and not row[0].startswith("#"):
                        yield passed_over + reader.line_num, row
            except (UnicodeDecodeError, csv.Error) as error:
                raise ValueError(f"{self.path}: not a table in UTF-8: {error}") from None

    def samples(self, header: int, places: tuple[int, int], names: tuple[str, str]) -> Samples:
        """Return the numbers in two columns below a line."""
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

    def _numbers(self, lines: Iterator[str], places: tuple[int, int]) -> NDArray[np.float64]:
        if self.decimal != ".":
            lines = (line.replace(self.decimal, ".") for line in lines)
        begun = next((line for line in lines if not _passed_over(line)), None)
        if begun is None:
            return np.empty((0, 2))

        def all_lines() -> Iterator[str]:
            yield begun
            yield from lines

        return np.loadtxt(all_lines(), delimiter=self.delimiter, usecols=places, ndmin=2, quotechar='"')

    def _cell_by_cell(
        self, header: int, places: tuple[int, int], names: tuple[str, str], rows: int | None = None
    ) -> Samples:
        values: list[tuple[float, float]] = []
        lines: list[int] = []
        for line, cells in islice(self.rows(header), rows):
            where = f"{self.path}, line {line}"
            first, second = (self._cell(cells, place, name, where) for place, name in zip(places, names, strict=True))
            values.append((first, second))
            lines.append(line)
        return Samples(np.array(values, dtype=np.float64).reshape(-1, 2), lines.__getitem__, names)

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
