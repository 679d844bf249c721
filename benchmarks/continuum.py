"""What an answer on a lattice proves of the membrane at every point, against the spacing, and what that costs.

    contactqp bench run benchmarks/continuum.py continuum       # up to 512² squares
    contactqp bench run benchmarks/continuum.py continuum --largest 128
    contactqp bench run benchmarks/continuum.py corners         # those that point inwards
    contactqp bench run benchmarks/continuum.py rectangles --points 0,1,2,3

``continuum``: a flat floor below a unit square, T = p = 1, depth 0.03. The true error of the lattice's answer is taken
against a lattice of 1024² squares. Ratios are over a cold solve by multigrid to 1e-6 on the same lattice.

``corners``: a flat floor below frames in a unit square with a corner that points inwards, T = p = 1, depth 0.015. The
true error is taken against a lattice of 512² squares, whose own error at the corner is not small beside it.

``rectangles``: a thousand random rectangles, each enclosed on a lattice of 2 to 16 squares along a side and on one that
is 8 times as fine, with random loads, supports, frames, tensions, ceilings and foundations. Either enclosure is of the
membrane itself: no lower bound of one may lie above an upper bound of the other. Contradictions are counted, and bounds
told over the distance of both answers, which is the error of the coarse one but for that of the fine one.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import contactqp as cq
from contactqp.benchmark import Phase, Spec
from contactqp.continuum.data import Data
from contactqp.continuum.membrane import MembraneBounds, membrane_bounds
from contactqp.solving.resolved import Resolved

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from random_rectangles import (
    Enclosed,
    at_nodes_of,
    contradictions,
    enclosed,
    energy_distance,
    random_rectangle,
    refined,
)

FINEST = 1024
"""Squares along a side of the lattice that counts as true."""


class Answered(NamedTuple):
    """A membrane, the answer of its lattice, and the gap at its nodes on the finest lattice."""

    membrane: cq.Membrane
    solution: cq.Solution
    exact: np.ndarray

    def enclosed(self) -> MembraneBounds:
        """Return bounds of the membrane."""
        membrane, gap = self.membrane, self.solution.gap
        again = Resolved(membrane, gap)
        return membrane_bounds(Data.of(membrane), membrane.padded_below(gap), gap, again)


def floor(squares: int) -> cq.Membrane:
    """Return the membrane on a lattice of so many squares along a side."""
    return cq.Membrane(cq.Frame.rectangle(1, 1).lattice(1 / squares), tension=1.0, load=1.0, support=0.03)


def answer(membrane: cq.Membrane) -> cq.Solution:
    """Return the answer of a lattice, as near as rounding allows."""
    return cq.solve(membrane, "multigrid", tol=1e-9, on_failure="ignore")


@cache
def truth() -> np.ndarray:
    """Return the gap on the finest lattice, shape (rows, columns)."""
    return answer(floor(FINEST)).gap.reshape(FINEST - 1, FINEST - 1)


def answered(squares: int) -> Answered:
    """Return the case of so many squares along a side, a power of two."""
    membrane, every = floor(squares), FINEST // squares
    return Answered(membrane, answer(membrane), truth()[every - 1 :: every, every - 1 :: every].ravel())


def facts(case: Answered, found: object) -> dict[str, float | str]:
    """Return how far the bounds are from the answer, over its true error, and the parts of the area."""
    if not isinstance(found, MembraneBounds):
        return {}
    gap, exact, contact = case.solution.gap, case.exact, found.contact
    if (found.gap_lower > exact + 1e-9).any() or (exact > found.gap_upper + 1e-9).any():
        raise AssertionError("the finest lattice's answer lies outside the bounds")
    error = np.abs(gap - exact).max()
    squares = sum(state.sum() for state in (contact.clear, contact.contact, contact.undecided))
    above, below = (found.gap_upper - gap).max(), (gap - found.gap_lower).max()
    return {
        "true error": float(error),
        "above": float(above),
        "above/true": float(above / error),
        "below": float(below),
        "below/true": float(below / error),
        "clear": contact.clear.sum() / squares,
        "touching": contact.contact.sum() / squares,
        "undecided": contact.undecided.sum() / squares,
    }


CORNERS = {
    "225°": [(0, 0), (1, 0), (1, 1 / 4), (1 / 2, 3 / 4), (1 / 2, 1), (0, 1)],
    "270°": [(0, 0), (1, 0), (1, 1 / 2), (1 / 2, 1 / 2), (1 / 2, 1), (0, 1)],
    "270°, turned": [(0, 0), (1, 0), (1, 1), (3 / 4, 1), (1 / 2, 3 / 4), (1 / 4, 1), (0, 1)],
    "315°": [(0, 0), (1, 0), (1, 1), (7 / 8, 1), (1 / 2, 5 / 8), (1 / 2, 1), (0, 1)],
}

FINEST_CORNERED = 512


def with_corner(name: str, squares: int) -> cq.Membrane:
    """Return a membrane in a frame with one of the corners, on a lattice of so many squares along a side."""
    lattice = cq.Frame.polygon(CORNERS[name]).lattice(1 / squares)
    return cq.Membrane(lattice, tension=1.0, load=1.0, support=0.015)


@cache
def finest_with_corner(name: str) -> Answered:
    """Return the finest lattice's answer."""
    membrane = with_corner(name, FINEST_CORNERED)
    solution = answer(membrane)
    return Answered(membrane, solution, solution.gap)


def answered_with_corner(point: str) -> Answered:
    """Return the case of a corner and of so many squares along a side, both told in a line."""
    name, squares = point.rsplit(" ", 1)
    membrane, finest = with_corner(name, int(squares)), finest_with_corner(name)
    return Answered(membrane, answer(membrane), at_nodes_of(membrane, finest.membrane, finest.solution.gap))


def facts_with_corner(case: Answered, found: object) -> dict[str, float | str]:
    """Return how far the bounds are from the answer, at most and in the mean, and the true error."""
    assert isinstance(found, MembraneBounds)
    gap, exact = case.solution.gap, case.exact
    above, below = found.gap_upper - gap, gap - found.gap_lower
    return {
        "true error": float(np.abs(gap - exact).max()),
        "above": float(above.max()),
        "above in the mean": float(above.mean()),
        "below": float(below.max()),
        "below in the mean": float(below.mean()),
        "undecided": found.part_undecided,
        "rounds": f"{found.rounds[0]}, {found.rounds[1]}",
    }


RECTANGLES = 1000

KNOWN_WELL = 0.2
"""The finer lattice tells an error where its own bound is no more than this part of it."""


class Pair(NamedTuple):
    """A membrane, enclosed on two lattices."""

    coarse: Enclosed
    fine: Enclosed


def pair(membrane: cq.Membrane) -> Pair | None:
    """Enclose a membrane on its lattice, and on the finer one; None where it is refused."""
    try:
        return Pair(enclosed(membrane), enclosed(refined(membrane)))
    except ValueError as refusal:
        if "not known to leave room for the frame" in str(refusal):
            return None  # little is known of a random support between two points of the frame
        raise


def held_against(membrane: cq.Membrane, found: object) -> dict[str, float | str]:
    """Return what contradicts, and bounds over true errors where these are known."""
    if found is None:
        return {"said": "refused", "refused": 1}
    assert isinstance(found, Pair)
    coarse, fine = found
    wrong = contradictions(coarse, fine)
    told: dict[str, float | str] = {"said": ", ".join(wrong) or "no contradiction", "contradictions": len(wrong)}
    told["refused"] = 0
    away = energy_distance(coarse, fine)
    if away > 0 and fine.found.energy_error <= KNOWN_WELL * away:
        told["energy norm/true"] = coarse.found.energy_error / away
    if coarse.pointwise:
        there = at_nodes_of(coarse.model, fine.model, fine.solution.deflection)
        error = float(np.abs(coarse.solution.deflection - there).max())
        if error > 0 and fine.found.error_bound <= KNOWN_WELL * error:
            told["at nodes/true"] = coarse.found.error_bound / error
    return told


SPECS = (
    Spec(
        "continuum",
        "the membrane enclosed at every point, beside a cold solve of its lattice",
        answered,
        (16, 32, 64, 128, 256, 512),
        {
            "solve": lambda case: cq.solve(case.membrane, "multigrid", tol=1e-6),
            "pointwise": lambda case: case.enclosed(),
        },
        point="squares along a side",
        tell=facts,
    ),
    Spec(
        "corners",
        "membranes in frames with a corner that points inwards, enclosed at every point",
        answered_with_corner,
        tuple(f"{name} {squares}" for name in CORNERS for squares in (16, 32, 64, 128, 256)),
        {"pointwise": lambda case: case.enclosed()},
        point="corner and squares along a side",
        tell=facts_with_corner,
    ),
    Spec(
        "rectangles",
        "random rectangles enclosed on two lattices, held against each other",
        random_rectangle,
        tuple(range(RECTANGLES)),
        {"both": Phase(pair, once=True)},
        point="seed",
        size=lambda membrane: membrane.size,
        tell=held_against,
        largest_facts=("contradictions", "refused", "energy norm/true", "at nodes/true"),
    ),
)
