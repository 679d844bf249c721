"""What the gallery's surfaces tell of rectangles holds in high precision and exact arithmetic; its data are proven."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.foundation.intervals import Interval
from contactqp.foundation.waves import cosine, logarithm, sine
from contactqp.gallery.bent import CappedBall, DamHead, DentedBowl, HalfPower, Logarithmic, Mirrored, Quartic
from contactqp.gallery.spiral_ridge import SpiralRidge
from contactqp.profiles import Paraboloid, Uppermost

SURFACES = [
    CappedBall(0.9),
    Logarithmic(0.68, 0.0, -0.47, 0.7),
    Logarithmic(1.0, -0.5, 0.5, 1.0),
    Quartic(-1.0, 0.7),
    HalfPower(12.0, 2),
    HalfPower(-1.0, 4),
    DentedBowl(),
    DamHead(16.0, 24.0, 4.0),
    SpiralRidge(),
    Mirrored(Uppermost(Paraboloid(-0.4, 0.5), Paraboloid(-0.1, -1.0))),
]
places, sides = st.floats(-1.6, 1.6), st.floats(0, 0.6)


@pytest.mark.parametrize("surface", SURFACES, ids=repr)
@settings(max_examples=40)
@given(x=places, y=places, width=sides, height=sides, seed=st.integers(0, 2**16))
def test_ranges_and_curvatures_hold(surface, x, y, width, height, seed):
    """Second derivatives are no less, and no more, than differences over steps within a rectangle say."""
    around = Interval.between([x], [x + width]), Interval.between([y], [y + height])
    whole, bends = surface.range(*around), surface.curvature(*around)
    at = np.random.default_rng(seed).uniform(size=(2, 60))
    across, along = x + width * at[0], y + height * at[1]
    if isinstance(surface, Logarithmic) and np.hypot(*np.meshgrid([x, x + width, 0], [y, y + height, 0])).min() == 0:
        across, along = (part[np.hypot(across, along) > surface.least] for part in (across, along))
    depths = surface(across, along)
    assert (whole.lower - 1e-12 <= depths).all()
    assert (depths <= whole.upper + 1e-12).all()
    step = 0.02 * min(width, height)
    if step < 1e-4:
        return
    inner = x + step + (width - 2 * step) * at[0], y + step + (height - 2 * step) * at[1]
    if isinstance(surface, Logarithmic):
        inner = tuple(part[np.hypot(*inner) > surface.least + 2 * step] for part in inner)
    for held, one, two in ((bends.xx, (1, 0), (1, 0)), (bends.yy, (0, 1), (0, 1)), (bends.xy, (1, 0), (0, 1))):
        a, b = step * np.array(one), step * np.array(two)
        corners = [
            i * j * surface(inner[0] + (i * a[0] + j * b[0]) / 2, inner[1] + (i * a[1] + j * b[1]) / 2)
            for i in (-1, 1)
            for j in (-1, 1)
        ]
        quotients = sum(corners) / step**2
        assert (held.lower - 1e-12 / step**2 <= quotients).all()
        assert (quotients <= held.upper + 1e-12 / step**2).all()


@pytest.mark.parametrize("surface", SURFACES, ids=repr)
def test_ranges_of_small_rectangles_are_narrow(surface):
    x, y = Interval.between([0.8], [0.8 + 1e-6]), Interval.between([0.7], [0.7 + 1e-6])
    whole, bends = surface.range(x, y), surface.curvature(x, y)
    assert float(whole.upper[0] - whole.lower[0]) < 1e-3
    for part in bends:
        assert float(part.upper[0] - part.lower[0]) < 1e-2


def exact_quartic(x, y):
    return -((Fraction(x) ** 2 + Fraction(y) ** 2 - Fraction(0.7) ** 2) ** 2)


@settings(max_examples=60)
@given(x=places, y=places, width=sides, height=sides, s=st.floats(0, 1), t=st.floats(0, 1))
def test_polynomials_in_rational_numbers(x, y, width, height, s, t):
    ends = x + width, y + height
    around = Interval.between([x], [ends[0]]), Interval.between([y], [ends[1]])
    p, q = (min(max(a + u * b, a), e) for a, b, e, u in ((x, width, ends[0], s), (y, height, ends[1], t)))
    whole, bends = Quartic(-1.0, 0.7).range(*around), Quartic(-1.0, 0.7).curvature(*around)
    square = Fraction(p) ** 2 + Fraction(q) ** 2 - Fraction(0.7) ** 2
    for held, value in (
        (whole, exact_quartic(p, q)),
        (bends.xx, -(8 * Fraction(p) ** 2 + 4 * square)),
        (bends.xy, -8 * Fraction(p) * Fraction(q)),
        (bends.yy, -(8 * Fraction(q) ** 2 + 4 * square)),
    ):
        assert Fraction(float(held.lower[0])) <= value <= Fraction(float(held.upper[0]))


@settings(max_examples=100)
@given(start=st.floats(-40, 40), width=st.floats(0, 7), s=st.floats(0, 1))
def test_waves_of_intervals(start, width, s):
    held, angle = Interval.between([start], [start + width]), min(start + s * width, start + width)
    for wave, value in ((sine, np.sin(angle)), (cosine, np.cos(angle))):
        found = wave(held)
        assert found.lower[0] <= value <= found.upper[0]
        if width < 1e-3:
            assert found.upper[0] - found.lower[0] <= width + 1e-13
    positive = Interval(np.abs(held.lower), np.abs(held.lower) + width)
    logs = logarithm(positive)
    with np.errstate(divide="ignore"):
        assert logs.lower[0] <= np.log(abs(start) + s * width) <= logs.upper[0]


ON_A_LINE = ["cable-in-bowl", "cable-of-varying-tension", "cable-on-hill"]
IN_PLAN = [
    "ball",
    "biactive-half",
    "bowl",
    "constant-obstacle",
    "dam",
    "ring",
    "spiral",
    "TORSIONA",
    "TORSIONC",
    "TORSIONF",
]


@pytest.mark.parametrize("name", ON_A_LINE + IN_PLAN)
def test_what_is_said_of_the_gallery_is_proven(name):
    known = cq.gallery.load(name)
    found = cq.solve(known.model, tol=1e-9).continuum()
    assert found.proven
    assert np.isfinite(found.energy_error)


@pytest.mark.parametrize("name", ["ball", "ring", "constant-obstacle", "biactive-half"])
def test_closed_forms_lie_within_the_norm(name):
    """The interpolant of the exact deflection lies as far from the answer's as both are from the membrane, at most."""
    from contactqp.continuum.data import Data
    from contactqp.continuum.energy import energy_norm, points_of

    coarse, fine = (cq.gallery.load(name, n=n) for n in (31, 127))
    answer = cq.solve(coarse.model, tol=1e-9)
    data = Data.of(fine.model)
    depths = data.plan.lattice.numbering.to_grid(fine.deflection, ring=1) * (-1 if fine.model.upwards else 1)
    exact = points_of(data, depths)[1:-1, 1:-1]
    own = points_of(Data.of(coarse.model), coarse.model.padded_below(answer.gap))[1:-1, 1:-1]
    for axis in (0, 1):
        places = np.arange(4 * (own.shape[axis] - 1) + 1) / 4
        low = np.minimum(places.astype(int), own.shape[axis] - 2)
        share = (places - low).reshape(-1, 1) if axis == 0 else places - low
        own = own.take(low, axis) * (1 - share) + own.take(low + 1, axis) * share
    # The exact one's interpolant is a quarter as far away, in a direction of its own.
    apart = energy_norm(data, np.pad(own - exact, 1))
    assert apart < answer.continuum().energy_error * np.sqrt(1 + 1 / 16)
