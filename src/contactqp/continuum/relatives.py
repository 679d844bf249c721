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
from .plan import CORNERS, Plan


def finer(model: ContactModel) -> Membrane:
    """Return the model on a lattice of half the spacing.

    Numbers, profiles and functions are taken as they were given; arrays as their bilinear interpolants.

    Raises
    ------
    TypeError, ValueError
        If the model is no membrane whose frame runs along lines of its lattice, or diagonals of its squares.
    """
    data = _data_of(model)
    return _made(data, _refined(data.plan), data.plan.spacing / 2, (0, 0), partial(prolonged_in, data.plan))


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
            lattice = _lattice(mask, _doubled(data.plan, mask.shape, row, column), 2 * data.plan.spacing)
            fine = _refined(Plan(lattice))
            same = _same(fine.mask[2 - row :, 2 - column :], nodes)
            if same and _same(_squares(fine)[2 - row :, 2 - column :], data.plan.halved):
                return _made(data, lattice, 2 * data.plan.spacing, (row, column), partial(_thinned, row, column))
    return None


def _doubled(plan: Plan, shape: tuple[int, ...], row: int, column: int) -> Mask:
    """Return which squares of twice the side are halved: those of one node, through whose middle the frame runs."""
    rows, columns = shape[0] + 1, shape[1] + 1
    nodes = np.pad(plan.nodes, 2)[row:, column:]
    own, middles = nodes[::2, ::2].astype(np.int64), nodes[1::2, 1::2][:rows, :columns]
    count = own[:rows, :columns] + own[1:][:rows, :columns] + own[:rows, 1:][:, :columns] + own[1:, 1:][:rows, :columns]
    return np.asarray((count == 1) & ~middles)


def _squares(lattice: Lattice) -> Mask:
    """Return which of the squares between the points of a lattice's own array are halved."""
    rows, columns = lattice.shape
    return np.zeros((rows - 1, columns - 1), dtype=np.bool_) if lattice.halved is None else lattice.halved[1:-1, 1:-1]


def _same(one: Mask, two: Mask) -> bool:
    """Return whether two arrays that begin at the same place have the same points, whatever is beyond either."""
    rows, columns = (min(sizes) for sizes in zip(one.shape, two.shape, strict=True))
    within = np.array_equal(one[:rows, :columns], two[:rows, :columns])
    return bool(within and one.sum() == two.sum() == one[:rows, :columns].sum())


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


def prolonged_in(plan: Plan, points: Grid) -> Grid:
    """Return the interpolant of values at the points of a plan likewise; on halves of squares it is linear."""
    found = prolonged(points)
    for halves in plan.halves:
        # The middle of a square that is halved lies on the frame, between the two corners that do.
        _, at_b, at_c = halves.of(points)
        found[1::2, 1::2][halves.place] = (at_b + at_c) / 2
    return found


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
    if not data.plan.on_lattice:
        raise ValueError(
            f"{model.lattice!r}: a membrane is made again on other lattices only if its frame runs along lines of its "
            "own, or diagonals of its squares; of this one solve models of other spacings, made by Frame.lattice"
        )
    return data


def _lattice(mask: Mask, halved: Mask, spacing: float) -> Lattice:
    some = bool(halved.any())
    return Lattice(mask, spacing, slanted=some, halved=halved if some else None)


def _refined(plan: Plan) -> Lattice:
    """Return the nodes of the same region on a lattice of half the spacing, on an array that begins at its ring."""
    nodes = plan.nodes
    mask = np.zeros((2 * nodes.shape[0] - 1, 2 * nodes.shape[1] - 1), dtype=np.bool_)
    mask[::2, ::2] = nodes
    mask[::2, 1::2] = nodes[:, 1:] | nodes[:, :-1]
    mask[1::2, ::2] = nodes[1:] | nodes[:-1]
    mask[1::2, 1::2] = plan.squares & ~plan.halved
    halved = np.zeros((mask.shape[0] + 1, mask.shape[1] + 1), dtype=np.bool_)
    for corner, (down, right) in enumerate(CORNERS):
        # Beside the corner at the node, two of the four smaller squares are halved.
        halved[1 + down : -1 : 2, 1 + right : -1 : 2] = plan.halved & (
            plan.at_corner(nodes, corner - 1) | plan.at_corner(nodes, (corner + 1) % 4)
        )
    return _lattice(mask, halved, plan.spacing / 2)


def _made(
    data: Data, shape: Lattice, spacing: float, first: tuple[int, int], carry: Callable[[Grid], Grid]
) -> Membrane:
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
    lattice = Lattice(shape.mask, spacing, (float(x), float(y)), slanted=shape.slanted, halved=shape.halved)
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
