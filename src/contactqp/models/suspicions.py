"""Suspicions: what a model's data probably do not mean, in words.

A height of the wrong sign, or a number that stands for a missing value, makes a well-posed problem with a certified
answer; nothing but its strangeness tells that another one was meant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..foundation.checks import Vector, repeated
from ..foundation.text import counted, span_of

_NEARLY_ALL = 0.9
"""Part of the places at the frame at which the support must stand above it for a wrong sign to be suspected."""

_JUMP = 3.0
"""So many times as far as it bends nearly everywhere must the support, carried on to the frame, stand above it."""

_SLOPE_LIMIT = 0.2
"""Above this slope the hypothesis of small deformations, (c) of the paper, is worth a remark."""

_FEWEST = 4
"""Bends of the support that it takes to tell a step at the frame from them."""

_ROUNDING = 1e-9
"""Part of the heights by which they may differ without a meaning."""

_STRANGE = 1000.0
"""So many times as high as all others are in size must a height stand out to be taken for no height at all."""

_NO_DATA_STRANGE = 10.0
"""The same for a number by which files mark missing values."""

_NO_DATA = (99.0, 999.0, 9999.0, 99999.0, 999999.0, 9999999.0, 32767.0, 32768.0, 1e10, 1e20, 1e30)


_NEARER = 3.0
"""So many times as near to the frame a support is with the other sign, if that was meant."""


class Joints(NamedTuple):
    """The support at the places where nodes are joined to the frame.

    Attributes
    ----------
    node : array of int, shape (m,)
        The node of each place.
    above : array, shape (m,)
        By how much the support, carried on from the nodes to the frame, and the node's own, stand above the frame, the
        lower of the two (length); -inf where there is no support.
    bends : array, shape (k,)
        By how much the support misses what is carried on from node to node elsewhere, without sign (length).
    """

    node: NDArray[np.int64]
    above: Vector
    bends: Vector


class Heights(NamedTuple):
    """The heights of a model and its load.

    Attributes
    ----------
    depth : array, shape (n,)
        Of the support at the nodes (length), positive downwards; inf where there is none.
    frame : (float, float)
        Depths between which the frame lies (length).
    load : array, shape (n,)
        Active force on each node, positive downwards (force).
    ceiling : bool
        Whether there is a ceiling.
    upwards : bool
        Whether the model's own heights are positive upwards.
    of_profile : bool
        Whether one of the heights was given as a profile, which returns depths whichever way heights are positive.
    joints : callable
        Returns the support at the frame, or None where that is not known.
    describe : callable
        Names a node by its number.
    """

    depth: Vector
    frame: tuple[float, float]
    load: Vector
    ceiling: bool
    upwards: bool
    of_profile: bool
    joints: Callable[[], Joints | None]
    describe: Callable[[int], str]

    @property
    def sense(self) -> str:
        """Which way heights are positive, in words."""
        return f"heights are positive {'upwards in this model' if self.upwards else 'downwards'}"

    def told(self, depth: float) -> float:
        """Return a depth as a height of the model's own sign."""
        return -depth if self.upwards else depth

    def span(self, depths: Vector) -> str:
        """Return the range of some depths, as heights of the model's own sign."""
        return span_of(-depths if self.upwards else depths)


def suspicions_of(heights: Heights) -> Iterator[str]:
    """Return a sentence for each thing that is strange about heights and load."""
    depth = _distinct(heights.depth)
    highest = float(depth.min())
    upper, lower = heights.frame
    if highest < upper:
        yield from _missing_values(heights, depth, highest)
    if highest < lower:
        yield from _pierced_frame(heights)
    elif lower < highest < np.inf and not heights.ceiling:
        yield from _no_contact(heights)
    if heights.upwards and heights.of_profile:
        yield from _other_side(heights, depth)


def _distinct(vector: Vector) -> Vector:
    return vector[:1] if repeated(vector) else vector


def _missing_values(heights: Heights, depth: Vector, highest: float) -> Iterator[str]:
    others = depth[np.isfinite(depth) & (depth != highest)]
    if not others.size:
        return
    factor = _NO_DATA_STRANGE if -highest in _NO_DATA else _STRANGE
    if -highest > factor * float(np.abs(others).max()):
        strange = np.flatnonzero(depth == highest)
        more = f" and {counted(strange.size - 1, 'more node')}" if strange.size > 1 else ""
        yield (
            f"support is {heights.told(highest):g} at {heights.describe(int(strange[0]))}{more}, and "
            f"{heights.span(others)} elsewhere: a number that stands for missing data is no height; give "
            f"{heights.told(np.inf):g} where there is no support"
        )


def _pierced_frame(heights: Heights) -> Iterator[str]:
    """Tell of a support above the frame: the frame is taken as it is given there, and the nodes beside it touch."""
    joints = heights.joints()
    if joints is None or joints.bends.size < _FEWEST:
        return
    rounding = _ROUNDING * float(np.abs(heights.depth[np.isfinite(heights.depth)]).max(initial=0.0))
    pierced = np.flatnonzero(joints.above > max(_JUMP * float(np.quantile(joints.bends, 0.95)), rounding))
    if not pierced.size:
        return
    places, first = joints.above.size, heights.describe(int(joints.node[pierced].min()))
    told = (
        f"support stands above the frame at {pierced.size} of the {places} places where nodes are joined to it, by "
        f"{float(joints.above[pierced].max()):.3g} at most, first at {first}, so that"
    )
    if pierced.size >= _NEARLY_ALL * places:
        told += " nearly all nodes may be in contact from the frame on"
        yield f"{told}; {heights.sense}: check the signs of support and frame"
    else:
        told += " nodes there may be in contact from the frame on"
        yield f"{told}; {heights.sense}: check the heights of support and frame"


def _no_contact(heights: Heights) -> Iterator[str]:
    load = _distinct(heights.load)
    if load.min() < 0 >= load.max():
        yield (
            "load nowhere presses downwards and the support lies below the frame, so nothing can touch; "
            f"{heights.sense}, and a load is positive downwards: check the signs of load and support"
        )


def _other_side(heights: Heights, depth: Vector) -> Iterator[str]:
    """Tell of a support that would lie next to the frame with the other sign: a depth where an elevation was meant."""
    known = depth[np.isfinite(depth)]
    frame = sum(heights.frame) / 2
    if not known.size or not frame or not (known * frame < 0).all():
        return
    if _NEARER * float(np.median(np.abs(known + frame))) > float(np.median(np.abs(known - frame))):
        return
    yield (
        f"support lies at {heights.span(known)} and the frame at {heights.told(frame):.4g}, on the other side of "
        f"height zero; {heights.sense}, but the depth of a profile is positive downwards in any model: check the signs"
    )


def steep(slope: float) -> tuple[str, ...]:
    """Return a caution about the largest slope of a deflection, none where it is small.

    Examples
    --------
    >>> steep(0.1), steep(0.23)
    ((), ('largest slope 0.23: the theory assumes small slopes',))
    """
    if slope <= _SLOPE_LIMIT:
        return ()
    return (f"largest slope {slope:.{2 if slope < 100 else 3}g}: the theory assumes small slopes",)
