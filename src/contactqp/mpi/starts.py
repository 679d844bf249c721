"""Starts: earlier answers that a solve goes on from, each process by its own rows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ..foundation.checks import Vector, real_array
from ..foundation.text import shortened
from .answer import AnswerByRows
from .membrane import MembraneByRows
from .posed import PosedByRows
from .ranks import Ranks
from .store import opened

WarmStart: TypeAlias = "AnswerByRows | str | PathLike[str] | None"
"""An answer of the same rows, or the path of a store that `AnswerByRows.to_zarr` has written."""

_PLACED = 1e-6
"""Part of the spacing by which places in a store may be off: they are rounded."""


class Start(ABC):
    """The gap of an earlier answer.

    Attributes
    ----------
    told : str
        What it is, for messages.
    gap : array, shape (n,)
        At the nodes that the process holds (length), once it has been read.
    """

    told: str
    gap: Vector

    @abstractmethod
    def require(self, membrane: MembraneByRows) -> None:
        """Raise an error where this belongs to another lattice; no row is read for that."""

    def read(self, posed: PosedByRows) -> None:
        """Read what belongs to the rows that the process holds; all processes must call it.

        Raises
        ------
        OSError, TypeError, ValueError
            If it does not suit these rows; in every process, in the same words.
        """
        self.gap = posed.ranks.agreed(lambda: self._gap_on(posed))

    @abstractmethod
    def _gap_on(self, posed: PosedByRows) -> Vector: ...


class _FromAnswer(Start):
    """An answer in memory: each process has the rows of it that it had when that was computed."""

    def __init__(self, answer: AnswerByRows) -> None:
        self._answer = answer
        self.told = "an answer in memory"

    def require(self, membrane: MembraneByRows) -> None:
        """See `Start`."""
        own = self._answer.membrane
        _require_lattice("the answer", own.shape, own.x, own.y, membrane)

    def _gap_on(self, posed: PosedByRows) -> Vector:
        before = self._answer.posed
        ranks, had = posed.ranks, before.ranks
        if (had.size, had.rank, before.rows_of_nodes) != (ranks.size, ranks.rank, posed.rows_of_nodes):
            (first, last), (begin, end) = before.rows_of_nodes, posed.rows_of_nodes
            raise ValueError(
                f"warm_start must have the rows that each process holds now, but process {ranks.rank} of {ranks.size} "
                f"holds rows {begin} to {end}, and has those of {first} to {last}, as process {had.rank} of "
                f"{had.size}; write it by to_zarr, and hand over the store's path"
            )
        nodes, own = before.numbering.mask, posed.numbering.mask
        if (before.left, nodes.shape) != (posed.left, own.shape) or not np.array_equal(nodes, own):
            raise ValueError("warm_start must have the same nodes as the membrane, but that is of another mask")
        gap = self._answer.measures.gap
        _require_finite(gap, posed)
        return gap


class _FromStore(Start):
    """A store: each process reads its own rows of it, and those that it holds of its neighbours."""

    def __init__(self, path: Path) -> None:
        self._store = opened(path)
        self.told = f"the store {path}"

    def require(self, membrane: MembraneByRows) -> None:
        """See `Start`."""
        missing = [name for name in ("gap", "x", "y") if name not in self._store]
        if missing:
            raise ValueError(f"{self.told} holds no {missing[0]!r}; hand over one that answer.to_zarr has written")
        x, y = (real_array(self._store[name][:], name) for name in "xy")
        _require_lattice(self.told, self._store["gap"].shape, x, lambda first, last: y[first:last], membrane)

    def _gap_on(self, posed: PosedByRows) -> Vector:
        first, last = posed.rows_of_nodes
        try:
            rows = real_array(self._store["gap"][first:last, posed.columns], "gap")
        except Exception as error:  # whatever a decoder says of a damaged chunk
            raise OSError(f"{self.told} cannot be read: {error}") from None
        mask = posed.numbering.mask
        surplus = np.isfinite(rows) & ~mask
        if surplus.any():
            row, column = np.argwhere(surplus)[0]
            raise ValueError(
                f"{self.told} has a gap {_place(posed, row, column)}, where the membrane has no node: it is of another "
                "mask"
            )
        gap = posed.numbering.to_vector(rows)
        _require_finite(gap, posed)
        return gap


def start_of(
    value: WarmStart, membrane: MembraneByRows, ranks: Ranks, otherwise: str = "no warm start"
) -> Start | None:
    """Return what a warm start stands for, checked as far as it can be before rows are read; all must call it.

    Parameters
    ----------
    value : AnswerByRows, path or None
    membrane : MembraneByRows
    ranks : Ranks
    otherwise : str
        What is started from where the value is None, for messages.

    Raises
    ------
    ImportError, OSError, TypeError, ValueError
        If it is none of the lattice, or not the same in every process; in every process, in the same words.
    """
    start = ranks.agreed(lambda: _checked(value, membrane))
    told = ranks.everyones([otherwise if start is None else start.told])
    other = next((rank for rank, each in enumerate(told) if each != told[0]), None)
    if other is not None:
        raise ValueError(
            f"warm_start must be the same in every process, but process 0 has {told[0]}, and process {other} "
            f"{told[other]}"
        )
    return start


def gap_of_store(path: Path, posed: PosedByRows) -> Vector:
    """Return the gap (length) that a store has at the nodes that the process holds; all must call it.

    Raises
    ------
    ImportError, OSError, TypeError, ValueError
        See `Start.read`; or if there is no store.
    """
    start = posed.ranks.agreed(lambda: _FromStore(path))
    start.read(posed)
    return start.gap


def _checked(value: WarmStart, membrane: MembraneByRows) -> Start | None:
    if value is None:
        return None
    start: Start
    if isinstance(value, AnswerByRows):
        start = _FromAnswer(value)
    elif isinstance(value, (str, PathLike)):
        start = _FromStore(Path(value))
    else:
        raise TypeError(
            "warm_start must be an AnswerByRows, or the path of a store that its to_zarr has written, got "
            f"{shortened(value)}"
        )
    start.require(membrane)
    return start


def _require_lattice(
    told: str, shape: tuple[int, ...], x: Vector, y: Callable[[int, int], Vector], membrane: MembraneByRows
) -> None:
    if tuple(shape) != membrane.shape:
        lattice = " x ".join(map(str, shape))
        raise ValueError(
            f"warm_start must be of the membrane's lattice, {' x '.join(map(str, membrane.shape))}, but {told} is of "
            f"{lattice}"
        )
    rows = membrane.shape[0]
    for axis, found, wanted in (("x", x, membrane.x), ("y", y(0, rows), membrane.y(0, rows))):
        if found.shape != wanted.shape or np.abs(found - wanted).max() > _PLACED * membrane.spacing:
            raise ValueError(
                f"warm_start must be of the membrane's lattice, whose {axis} goes from {wanted[0]:g} to "
                f"{wanted[-1]:g}, but that of {told} goes from {found[0]:g} to {found[-1]:g}"
            )


def _require_finite(gap: Vector, posed: PosedByRows) -> None:
    finite = np.isfinite(gap)
    if not finite.all():
        row, column = np.argwhere(posed.numbering.to_grid(~finite, fill=False))[0]
        value = gap[np.argmin(finite)]
        raise ValueError(
            f"warm_start must have a finite gap at every node of the membrane, but it is {value:g} "
            f"{_place(posed, row, column)}"
        )


def _place(posed: PosedByRows, row: int, column: int) -> str:
    first = posed.rows_of_nodes[0] + row
    y, x = posed.membrane.y(first, first + 1)[0], posed.membrane.x[posed.left + column]
    return f"at x={x:g}, y={y:g}"
