"""Relatives of a model: the same membrane on a lattice of half, or of twice, the spacing."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..errors import ContactWarning
from ..foundation.checks import Mask
from ..geometry.fields import OnFrame
from ..geometry.lattice import Lattice
from ..geometry.numbering import Grid
from ..models.base import ContactModel
from ..models.membrane import Membrane
from .data import Data
from .plan import Plan


def finer(model: ContactModel) -> Membrane:
    """Return the model on a lattice of half the spacing.

    Numbers, profiles and functions are taken as they were given; arrays as their bilinear interpolants.

    Raises
    ------
    TypeError, ValueError
        If the model is no membrane whose frame runs along lines of its lattice.
    """
    data = _data_of(model)
    mask = _refined(data.plan)
    return _made(data, mask, data.plan.spacing / 2, (0, 0), prolonged)


def coarser(model: ContactModel) -> Membrane | None:
    """Return the model on a lattice of twice the spacing, None if its frame does not run along lines of any.

    Raises
    ------
    TypeError, ValueError
        See `finer`.
    """
    data = _data_of(model)
    nodes = data.plan.nodes
    for row in (0, 1):
        for column in (0, 1):
            mask = nodes[row::2, column::2]
            if not mask.any():
                continue
            lattice = Lattice.from_mask(mask, 2 * data.plan.spacing)
            again = _refined(Plan(lattice))[2 - row :, 2 - column :]
            wanted = np.zeros_like(again)
            known = nodes[: again.shape[0], : again.shape[1]]
            wanted[: known.shape[0], : known.shape[1]] = known
            if np.array_equal(again, wanted) and wanted.sum() == nodes.sum():
                return _made(data, mask, 2 * data.plan.spacing, (row, column), partial(_thinned, row, column))
    return None


def _thinned(row: int, column: int, points: Grid) -> Grid:
    return points[row::2, column::2]


def prolonged(points: Grid) -> Grid:
    """Return the bilinear interpolant of values at the points of a lattice on one of half the spacing.

    Examples
    --------
    >>> prolonged(np.array([[0.0, 2.0], [4.0, 10.0]]))
    array([[ 0.,  1.,  2.],
           [ 2.,  4.,  6.],
           [ 4.,  7., 10.]])
    """
    for axis in (0, 1):
        points = np.moveaxis(points, axis, 0)
        finer_points = np.empty((2 * len(points) - 1, *points.shape[1:]))
        finer_points[::2] = points
        finer_points[1::2] = (points[1:] + points[:-1]) / 2
        points = np.moveaxis(finer_points, 0, axis)
    return points


def place_in(fine: Lattice, coarse: Lattice) -> tuple[int, int]:
    """Return row and column, in a finer lattice's array with its ring, of the first point of a coarser one."""
    row, column = (
        round((far - near) / fine.spacing) + 1 for far, near in zip(coarse.origin[::-1], fine.origin[::-1], strict=True)
    )
    return row, column


def _data_of(model: ContactModel) -> Data:
    if not isinstance(model, Membrane):
        raise TypeError(f"a Membrane can be made again on other lattices, not {model!r}")
    data = Data.of(model)
    data.require_whole_squares("errors are estimated")
    return data


def _refined(plan: Plan) -> Mask:
    """Return the nodes of the same region on a lattice of half the spacing, on an array that begins at its ring."""
    nodes = plan.nodes
    mask = np.zeros((2 * nodes.shape[0] - 1, 2 * nodes.shape[1] - 1), dtype=np.bool_)
    mask[::2, ::2] = nodes
    mask[::2, 1::2] = nodes[:, 1:] | nodes[:, :-1]
    mask[1::2, ::2] = nodes[1:] | nodes[:-1]
    mask[1::2, 1::2] = plan.squares
    return mask


def _made(data: Data, mask: Mask, spacing: float, first: tuple[int, int], carry: Callable[[Grid], Grid]) -> Membrane:
    """Return a model of the same data on another lattice, to which ``carry`` brings values at the points."""
    model, plan = data.model, data.plan
    sign = -1.0 if model.upwards else 1.0
    fields = {"load": (data.load, 1.0), "support": (data.support, sign), "ceiling": (data.ceiling, sign)}
    fields |= {"foundation": (data.foundation, 1.0), "frame_height": (data.frame, sign)}
    made: dict[str, Any] = {}
    for name, (field, turn) in fields.items():
        if field is None:
            continue
        given = model.given.get(name)
        whole = given is not None and not isinstance(given, OnFrame)
        made[name] = given if whole else turn * _infinite_kept(carry, field.values)
    x, y = plan.lattice.ring_coordinates(np.array(first[0]), np.array(first[1]))
    tensions = tuple(_tension(data, k, carry) for k in range(len(model.tension_of_arms.fields)))
    lattice = Lattice.from_mask(mask, spacing, (float(x), float(y)))
    tension = tensions[0] if model.tension_of_arms.same else tensions
    with warnings.catch_warnings():
        # What is strange about the data was told when the model was made.
        warnings.simplefilter("ignore", ContactWarning)
        return Membrane(lattice, tension, upwards=model.upwards, **made)


def _infinite_kept(carry: Any, values: Grid) -> Grid:
    with np.errstate(invalid="ignore"):
        return np.asarray(carry(values))


def _tension(data: Data, axis: int, carry: Callable[[Grid], Grid]) -> Any:
    tension = data.model.tension_of_arms
    if tension.source and not isinstance(tension.source[axis], OnFrame):
        return tension.source[axis]
    nodes = tension.fields[axis].nodes
    return nodes if isinstance(nodes, float) else carry(data.tension_at_points(axis))
