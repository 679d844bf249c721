"""Cells certainly in contact and certainly clear, area, force and free boundary, against closed forms."""

import numpy as np
import pytest
from continuous import Posed, bowl, ring, ring_height

import contactqp as cq
from contactqp.continuum.cells import extreme_at_corners
from contactqp.continuum.contact import contact_bounds
from contactqp.continuum.pointwise import pointwise_bounds


def decided(posed, bounds=None):
    problem = posed.problem
    bounds = pointwise_bounds(problem, posed.gap, posed.resolve) if bounds is None else bounds
    least, most = (
        extreme_at_corners(problem.load, extreme) + end
        for extreme, end in zip((np.minimum, np.maximum), problem.load_range, strict=True)
    )
    gap = bounds.lower.on_cells(), bounds.upper.on_cells()
    return contact_bounds(problem.cells, problem.tension, gap, (least, most))


def middles(posed):
    h = posed.lattice.spacing
    return np.hypot(posed.x[:-1, :-1] + h / 2, posed.y[:-1, :-1] + h / 2), h / np.sqrt(2)


def test_the_ring_touches_within_the_unit_disk():
    """Contact r <= 1 of area π, where q = 2 rests on the support; free boundary r = 1."""
    undecided = []
    for squares in (24, 48, 96):
        posed = ring(squares)
        found = decided(posed)
        r, half = middles(posed)
        assert found.contact.any()
        assert (r[found.contact] + half <= 1 + 2 * half).all()
        assert (r[found.contact] <= 1).all()
        assert (r[found.clear] > 1).all()
        assert found.area.lower <= np.pi <= found.area.upper
        assert found.reaction.lower <= 2 * np.pi <= found.reaction.upper
        crossed = (r - half < 1) & (r + half > 1) & posed.problem.cells.inside
        assert found.undecided[crossed & (np.abs(r - 1) < half / 2)].all()
        # Of the free boundary every point is in the strip; the strip's farthest cell is no farther than told.
        assert np.abs(r[found.undecided] - 1).max() <= found.free_boundary_width
        undecided.append(found.undecided.sum() * posed.lattice.spacing**2)
    assert np.log(undecided[0] / undecided[2]) / np.log(4) >= 0.9


def test_the_bowl_is_decided_but_for_a_strip():
    parts = [decided(bowl(squares)) for squares in (32, 128)]
    for found, least, most in zip(parts, (0.1, 0.19), (0.25, 0.055), strict=True):
        cells = found.clear.sum() + found.contact.sum() + found.undecided.sum()
        assert found.contact.sum() / cells >= least
        assert found.undecided.sum() / cells <= most
        assert not (found.clear & found.contact).any()


def test_without_contact_there_is_no_free_boundary():
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 16)
    found = decided(Posed(lattice, lambda x, y: 1.0 + 0 * x, lambda x, y: 1.0 + 0 * x))
    assert found.clear.sum() == 256
    assert found.free_boundary_width == 0.0
    assert found.area == (0.0, 0.0)
    assert found.reaction == (0.0, 0.0)


def test_where_the_load_does_not_press_nothing_is_in_contact():
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 16)
    posed = Posed(lattice, lambda x, y: np.where(x < 0, 1.0, 0.0), lambda x, y: 0.001 + 0 * x, 0.0)
    found = decided(posed)
    h = lattice.spacing
    assert not found.contact[posed.x[:-1, :-1] + h > 0].any()
    assert found.free_boundary_width == np.inf or found.contact.any()


def test_the_ring_by_hand():
    """What is in contact is known from the largest gap on disks that a load of 2 must lift by r²/2."""
    posed = ring(48)
    bounds = pointwise_bounds(posed.problem, posed.gap, posed.resolve)
    found = decided(posed, bounds)
    upper, h = bounds.upper.on_cells(), posed.lattice.spacing
    i, j = np.argwhere(found.contact)[0]
    windows = [upper[i - k : i + k + 1, j - k : j + k + 1].max() <= 2 * (k * h) ** 2 / 4 for k in range(1, 8)]
    assert any(windows)
    assert ring_height(0.0, 0.0) == 0.0
    assert found.reaction.upper - found.reaction.lower == pytest.approx(2 * found.undecided.sum() * h**2, rel=1e-9)
