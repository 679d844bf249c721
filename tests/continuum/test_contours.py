"""Contours on lattices: pieces, the squares they cut, splines along them, and functions about their corners."""

import itertools
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.continuum.background import Background
from contactqp.continuum.cells import Cells
from contactqp.continuum.contour import Contour
from contactqp.continuum.contour_cells import outline_of
from contactqp.continuum.contour_rim import ContourRim
from contactqp.continuum.corner_functions import corner_functions
from contactqp.geometry.outline import Outline, circle

L_SHAPE = [(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)]


def turned(corners, angle, move=(0.0, 0.0)):
    c, s = np.cos(angle), np.sin(angle)
    return [(c * x - s * y + move[0], s * x + c * y + move[1]) for x, y in corners]


def on_lattice(frame, spacing):
    lattice = frame.lattice(spacing, fitted=True)
    return lattice, Contour.of(lattice, lattice.outline)


def star(rng, corners):
    """Return a polygon about (0, 0), convex or not."""
    angles = (np.arange(corners) + rng.uniform(-0.4, 0.4, corners)) * (2 * np.pi / corners)
    radius = rng.uniform(0.5, 1.2, corners)
    return [(r * np.cos(a), r * np.sin(a)) for r, a in zip(radius, angles, strict=True)]


@pytest.mark.parametrize(
    "frame",
    [
        cq.Frame.disk(1.0, center=(0.1, -0.2)),
        cq.Frame.disk(1.0) - cq.Frame.disk(0.4),
        cq.Frame.polygon(turned(L_SHAPE, 0.3)),
        cq.Frame.polygon(L_SHAPE),
        cq.Frame.hexagon(1.0, center=(100.0, 3.0)),
        cq.Frame.rectangle(2, 1) - cq.Frame.polygon(turned([(-0.3, -0.2), (0.3, -0.2), (0, 0.3)], 0.2)),
    ],
    ids=["disk", "ring", "turned L", "L", "hexagon", "plate with a hole"],
)
def test_squares_cover_the_region_and_pieces_its_contour(frame):
    lattice, contour = on_lattice(frame, 0.11)
    first, spacing = np.array(contour.first), contour.spacing
    rng = np.random.default_rng(0)
    x, y = (rng.uniform(low, high, 40_000) for low, high in np.reshape(frame.geometry.bounds, (2, 2)).T)
    inside = lattice.outline.holds(x, y)
    column, row = ((np.stack([x, y]) - first[:, None]) / spacing).astype(int)
    assert contour.inside[row, column][inside].all()
    whole = contour.inside & ~contour.cut
    assert inside[whole[row, column]].all()
    # What the pieces enclose is the region: Green's formula.
    corner = np.stack([contour.column, contour.row])
    start, end = (first[:, None] + spacing * (corner + part) for part in (contour.start, contour.end))
    area = 0.5 * (start[0] * end[1] - start[1] * end[0]).sum()
    assert area == pytest.approx(lattice.outline.geometry.area, rel=1e-9)
    assert ((contour.start >= -1e-9) & (contour.end <= 1 + 1e-9)).all()


def test_sides_on_lines_cut_nothing_and_belong_to_squares_within():
    _, contour = on_lattice(cq.Frame.rectangle(2, 1), 0.25)
    assert not contour.cut.any()
    assert contour.inside.sum() == 8 * 4
    assert contour.inside[contour.row, contour.column].all()


def test_circles_lie_within_the_sagitta_of_their_chords():
    outline = circle(2.0, (1.0, -1.0), spacing=0.2)
    middles = (outline.rings[0] + np.roll(outline.rings[0], -1, axis=0)) / 2
    away = 2.0 - np.hypot(*(middles - (1.0, -1.0)).T)
    assert 0 < away.max() <= outline.sagitta <= away.max() * (1 + 1e-9) + 1e-14
    joined = (cq.Frame.disk(1.0) & cq.Frame.rectangle(2, 1)).outline(0.1)
    assert joined.sagitta == 0.0  # the chords meet the rectangle, and are the contour themselves
    apart = (cq.Frame.disk(1.0) - cq.Frame.disk(0.3)).outline(0.1)
    assert apart.sagitta > 0.0


def test_outlines_of_cells_follow_lines_and_diagonals():
    frame = cq.Frame.polygon([(0, 0), (8, 0), (8, 4), (4, 4), (4, 8), (0, 8)])
    lattice = frame.lattice(1.0)
    found = outline_of(Cells(lattice.mask, 1.0, lattice.halved), lattice)
    assert found.geometry.equals(frame.geometry)
    assert len(found.rings[0]) == 6
    assert found.inward_corners == [(4.0, 4.0)]
    assert not found.convex
    octagon = cq.Frame.polygon([(2, 0), (6, 0), (8, 2), (8, 6), (6, 8), (2, 8), (0, 6), (0, 2)])
    lattice = octagon.lattice(1.0)
    found = outline_of(Cells(lattice.mask, 1.0, lattice.halved), lattice)
    assert found.geometry.equals(octagon.geometry)
    assert found.convex
    # Two squares that touch at a point have a ring each.
    mask = np.zeros((3, 3), dtype=bool)
    mask[0, 0] = mask[2, 2] = True
    pair = cq.Lattice.from_mask(mask, 1.0)
    assert sorted(len(ring) for ring in outline_of(Cells(mask, 1.0), pair).rings) == [4, 4]


def exactly(coefficients, row, column, x, y):
    """Return a bicubic spline in a square, in rational numbers."""

    def basis(t):
        s = 1 - t
        return [s**3 / 6, (4 - 6 * t**2 + 3 * t**3) / 6, (4 - 6 * s**2 + 3 * s**3) / 6, t**3 / 6]

    along_x, along_y = basis(x), basis(y)
    return sum(
        along_y[i] * along_x[j] * Fraction(float(coefficients[row + i, column + j]))
        for i, j in itertools.product(range(4), range(4))
    )


@pytest.mark.parametrize("seed", range(8))
def test_splines_along_contours_are_enclosed_exactly(seed):
    """On pieces as they are kept, by rational numbers."""
    rng = np.random.default_rng(seed)
    _, contour = on_lattice(cq.Frame.polygon(star(rng, 7)), 0.3)
    coefficients = rng.normal(size=tuple(np.array(contour.inside.shape) + 3)) * 10.0 ** rng.integers(-3, 4)
    low, high = np.sort(rng.normal(size=(2, 3, contour.size)), axis=0)
    least, most = ContourRim(contour, low, high).excess(coefficients)
    for piece in rng.permutation(contour.size)[:6]:
        start, end = ([Fraction(float(v)) for v in ends[:, piece]] for ends in (contour.start, contour.end))
        for t in map(Fraction, (0, "1/7", "1/2", "5/6", 1)):
            x, y = ((1 - t) * a + t * b for a, b in zip(start, end, strict=True))
            value = exactly(coefficients, contour.row[piece], contour.column[piece], x, y)
            weights = (1 - t) ** 2, 2 * t * (1 - t), t**2
            below, above = (
                sum(w * Fraction(float(h)) for w, h in zip(weights, side[:, piece], strict=True))
                for side in (low, high)
            )
            assert Fraction(float(least[piece])) <= value - above
            assert value - below <= Fraction(float(most[piece]))
    assert (most - least).max() < 10 * sum(np.abs(part).max() for part in (coefficients, low, high))


def test_bounds_along_contours_are_of_second_order():
    """A spline is as near to its heights along a circle as the parabolas of its pieces are."""
    off = []
    for spacing in (0.1, 0.05):
        lattice, contour = on_lattice(cq.Frame.disk(1.0), spacing)
        x, y = lattice.ring_coordinates(np.arange(-1, lattice.shape[0] + 3), np.arange(-1, lattice.shape[1] + 3))
        values = np.zeros((3, contour.size))
        least, most = ContourRim(contour, values, values).excess(x[None, :] ** 2 + y[:, None] ** 2 - 1.0)
        # The spline through the values of r² - 1 is higher by 2h²/3; on the circle it is that.
        off.append(max(np.abs(least - 2 * spacing**2 / 3).max(), np.abs(most - 2 * spacing**2 / 3).max()))
    assert off[1] < 0.3 * off[0]
    assert off[0] < 0.1**2


CORNERED = {
    "L": cq.Frame.polygon(turned(L_SHAPE, 0.3, (0.05, 0.02))),
    "hexagon": cq.Frame.hexagon(1.0),
    "kite": cq.Frame.polygon([(0, 0), (1.5, 0.2), (1.6, 1.4), (0.3, 1.1)]),
    "arrow": cq.Frame.polygon([(-1, -0.8), (0.9, 0), (-1, 0.8), (-0.4, 0)]),
}


@pytest.mark.parametrize("frame", CORNERED.values(), ids=CORNERED)
def test_functions_about_corners_are_harmonic_and_vanish_along_their_sides(frame):
    mpmath.mp.dps = 40
    outline = frame.outline(0.05)
    functions = corner_functions(outline, 0.05)
    assert functions
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1.5, 1.7, (2, 400))
    inside = outline.holds(x, y)
    x, y = x[inside][:6], y[inside][:6]
    first, last = outline.segments
    for function in functions:
        way = mpmath.expjpi(-mpmath.mpf(function.direction) / mpmath.pi)
        low = mpmath.mpf(function.jump) - 2 * mpmath.pi

        def exact(px, py, function=function, way=way, low=low):
            z = mpmath.mpc(px - mpmath.mpf(function.corner[0]), py - mpmath.mpf(function.corner[1])) * way
            rho, theta = abs(z) / mpmath.mpf(function.scale), mpmath.arg(z)
            theta += 2 * mpmath.pi * mpmath.ceil((low - theta) / (2 * mpmath.pi))
            if function.logarithmic:
                return rho**2 * (mpmath.log(rho) * mpmath.sin(2 * theta) + theta * mpmath.cos(2 * theta))
            return rho ** mpmath.mpf(function.exponent) * mpmath.sin(mpmath.mpf(function.exponent) * theta)

        for px, py in zip(map(mpmath.mpf, x.tolist()), map(mpmath.mpf, y.tolist()), strict=True):
            value = exact(px, py)
            distance = np.array([float(mpmath.hypot(px - function.corner[0], py - function.corner[1]))])
            room = function.rounding(distance, distance, 1e-15)[0]
            assert abs(float(value) - float(function(np.float64(px), np.float64(py)))) <= room < 1e-11
            step = mpmath.mpf("1e-10")
            across = (exact(px + step, py) - 2 * value + exact(px - step, py)) / step**2
            along = (exact(px, py + step) - 2 * value + exact(px, py - step)) / step**2
            size = function.size(2, distance, distance)[0]
            assert abs(across + along) <= 1e-9 * size
            assert float(across) == pytest.approx(float(function.bend(np.float64(px), np.float64(py))), abs=1e-7 * size)
            assert abs(across) <= size * (1 + 1e-9)
            slope = (exact(px + step, py) - exact(px - step, py)) / (2 * step)
            assert abs(slope) <= function.size(1, distance, distance)[0] * (1 + 1e-9)
        for side, share in itertools.product(function.sides[:1], (0.1, 0.9)):
            assert abs(function(*(first[side] + share * (last[side] - first[side])))) < 1e-12
        if not function.logarithmic:
            side = function.sides[1]
            assert abs(function(*(last[side] + 0.3 * (first[side] - last[side])))) < 1e-12


@pytest.mark.parametrize("frame", CORNERED.values(), ids=CORNERED)
def test_sums_of_functions_are_enclosed_in_squares_and_along_the_contour(frame):
    lattice, contour = on_lattice(frame, 0.07)
    background = Background.nothing_of(contour, corner_functions(lattice.outline, 0.07))
    rng = np.random.default_rng(2)
    background = background.with_factors(rng.normal(size=len(background.parts)))
    spline = rng.normal(size=background.coefficients.shape)
    x, y = rng.uniform(-1.5, 1.7, (2, 60_000))
    inside = lattice.outline.holds(x, y)
    x, y = x[inside], y[inside]
    place = (np.stack([x, y]) - np.array(contour.first)[:, None]) / contour.spacing
    column, row = place.astype(int)
    part = place - [column, row]

    def basis(t):
        s = 1 - t
        return np.stack([s**3, 4 - 6 * t**2 + 3 * t**3, 4 - 6 * s**2 + 3 * s**3, t**3]) / 6

    def value(coefficients):
        weights = basis(part[1])[:, None] * basis(part[0])[None, :]
        return sum(weights[i, j] * coefficients[row + i, column + j] for i, j in itertools.product(range(4), range(4)))

    true = sum(factor * one.function(x, y) for factor, one in zip(background.factors, background.parts, strict=True))
    off = np.abs(true - value(background.coefficients))
    assert (off <= background.beside[row, column] + 1e-13).all()
    far = np.isfinite(background.beside[row, column])
    assert far.mean() > 0.9
    assert np.median(background.beside[row, column][far]) < 1e-2
    low, high = (np.full(contour.inside.shape, -end) for end in (np.inf, -np.inf))
    low[background.hidden], high[background.hidden] = background.ranges_in_hidden(spline)
    both = true + value(spline)
    assert (low[row, column] <= both).all()
    assert (both <= high[row, column]).all()
    along = background.along
    for t in np.linspace(0, 1, 7):
        ends = contour.places((1 - t) * contour.start + t * contour.end)
        on_contour = sum(
            factor * one.function(*ends) for factor, one in zip(background.factors, background.parts, strict=True)
        )
        weights = np.array([(1 - t) ** 2, 2 * t * (1 - t), t**2])
        assert (weights @ along.lower <= on_contour + 1e-13).all()
        assert (on_contour <= weights @ along.upper + 1e-13).all()
    assert np.median(along.upper - along.lower) < 1e-3


@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_rays_on_which_angles_jump_do_not_meet_the_region(seed):
    rng = np.random.default_rng(seed)
    frame = cq.Frame.polygon(star(rng, int(rng.integers(4, 9))))
    outline = frame.outline(0.02)
    x, y = rng.uniform(-1.2, 1.2, (2, 3000))
    inside = outline.holds(x, y)
    for function in corner_functions(outline, 0.02):
        way = function.direction + function.jump
        across, up = x[inside] - function.corner[0], y[inside] - function.corner[1]
        beside = np.abs(up * np.cos(way) - across * np.sin(way))
        ahead = across * np.cos(way) + up * np.sin(way) > 1e-5
        assert not (ahead & (beside < 1e-9)).any()


def test_outlines_say_what_is_convex():
    assert Outline.of(cq.Frame.hexagon(1.0).geometry).convex
    assert not Outline.of((cq.Frame.hexagon(1.0) - cq.Frame.hexagon(0.3)).geometry).convex
    assert cq.Frame.disk(1.0).outline(0.1).convex
