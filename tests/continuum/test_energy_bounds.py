"""Bounds of a membrane's energy contain the membrane: against closed forms, finer lattices, and exact arithmetic."""

import warnings
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.continuum import energy as energies
from contactqp.continuum.data import Data
from contactqp.continuum.energy import energy_bounds, points_of
from contactqp.continuum.majorant import balanced_flux, misfit_in_squares, norm_over, stretch_of
from contactqp.continuum.plan import CORNERS
from contactqp.gallery.bent import CappedBall, DentedBowl
from contactqp.gallery.radial import _ball_height
from contactqp.profiles import Cone, Cylinder, Hemisphere, Paraboloid, Plane, Uppermost

UNIT = cq.Frame.rectangle(1, 1, center=(0.5, 0.5))


def solved(lattice, tol=1e-9, **data):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        return cq.solve(cq.Membrane(lattice, **{"tension": 1.0, "load": 1.0, **data}), tol=tol)


def meet(first, second):
    return first.lower <= second.upper and second.lower <= first.upper


def half_width(bracket):
    return (bracket.upper - bracket.lower) / 2


SMOOTH = {
    "floor": {"support": 0.03},
    "two tensions": {"support": 0.03, "tension": (2.0, 1.0)},
    "tension that varies": {
        "support": 0.03,
        "tension": cq.Smooth(lambda x, y: 1 + x**2, lipschitz=2.0, second_derivative=2.0),
    },
    "load that varies": {
        "support": 0.03,
        "load": cq.Smooth(lambda x, y: 1.5 + np.sin(3 * x) * np.cos(2 * y), second_derivative=9.0),
    },
    "suction under a ceiling": {
        "support": 0.03,
        "ceiling": -0.02,
        "load": cq.Smooth(lambda x, y: 2 * np.cos(3 * x), second_derivative=18.0),
    },
    "springs": {"support": 0.03, "foundation": 5.0},
    "springs that vary": {"support": 0.03, "foundation": cq.Smooth(lambda x, y: 3 * x * x, second_derivative=6.0)},
    "frame": {"support": 0.04, "frame_height": cq.Smooth(lambda x, y: 0.02 * x * x, second_derivative=0.04)},
    "upwards": {
        "support": -0.03,
        "frame_height": cq.Smooth(lambda x, y: 0.01 * x * x, second_derivative=0.02),
        "upwards": True,
    },
    "hill": {"support": Paraboloid(0.02, 2.0, (0.5, 0.4))},
    "bowl": {"support": Paraboloid(0.06, -5.0, (0.5, 0.5))},
    "dents": {
        "load": 8.0,
        "support": cq.Smooth(DentedBowl(), second_derivative=4.6),
    },
}


@pytest.mark.parametrize("name", SMOOTH)
def test_brackets_of_all_spacings_meet_and_shrink_at_second_order(name):
    found = [solved(UNIT.lattice(1 / n), **SMOOTH[name]).continuum() for n in (16, 32, 64)]
    assert all(one.proven for one in found)
    assert all(meet(one.energy, two.energy) for one, two in pairwise(found))
    assert half_width(found[0].energy) / half_width(found[2].energy) > 2 ** (2 * 1.8)
    assert found[0].energy_error / found[2].energy_error > 2 ** (2 * 0.9)


def apart_of(coarse, fine, times):
    """Return how far the interpolants of two answers are from each other in the energy norm."""
    data = [Data.of(solution.model) for solution in (coarse, fine)]
    own, other = (
        points_of(each, solution.model.padded_below(solution.gap))[1:-1, 1:-1]
        for each, solution in zip(data, (coarse, fine), strict=True)
    )
    return stretch_of(data[1], np.pad(prolonged(own, times) - other, 1)).norm


@pytest.mark.parametrize("name", SMOOTH)
def test_the_norm_is_bounded_within_three_tenths(name):
    """The finer lattice stands for the membrane: its own error is a quarter as large, in a direction of its own.

    Of the dents nothing is told but the largest second derivative, which counts as if it were so everywhere.
    """
    coarse, fine = (solved(UNIT.lattice(1 / n), **SMOOTH[name]) for n in (32, 128))
    one, two, apart = coarse.continuum(), fine.continuum(), apart_of(coarse, fine, 4)
    assert apart <= one.energy_error + two.energy_error
    assert 0.98 * apart < one.energy_error < (1.7 if name == "dents" else 1.3) * apart


def test_the_bound_is_close_to_the_error():
    """Over a flat floor the interpolant is admissible and touches where the membrane does: the rest is the error."""
    coarse, fine = (solved(UNIT.lattice(1 / n), support=0.03) for n in (32, 128))
    found = coarse.continuum()
    # J(v) - J(w*) = ½‖v - w*‖² there, and the finer lattice knows J(w*) much better.
    true_error = np.sqrt(2 * (found.energy.upper - fine.continuum().energy.upper))
    assert true_error < found.energy_error < 1.1 * true_error
    assert half_width(found.energy) < 1.2e-3 * abs(found.energy.lower)


def test_curved_supports_cost_little():
    """Over a hill most of the interpolant's error is in contact, where it is known; truth from a finer lattice."""
    hill = {"support": Paraboloid(0.02, 2.0, (0.5, 0.4))}
    coarse, fine = (solved(UNIT.lattice(1 / n), **hill) for n in (32, 256))
    below = [solution.model.padded_below(solution.gap)[1:-1, 1:-1] for solution in (coarse, fine)]
    true_error = stretch_of(Data.of(fine.model), np.pad(prolonged(below[0], 8) - below[1], 1)).norm
    assert true_error < coarse.continuum().energy_error < 1.2 * true_error


KINKED = {
    "cone": {"support": Cone(0.02, 0.1, (0.52, 0.5))},
    "cylinder": {"support": Cylinder(0.02, 0.3, (0.5, 0.5))},
    "ball and floor": {"support": Uppermost(Plane(0.04), Hemisphere(0.02, 0.2, (0.51, 0.5)))},
    "ball alone": {"support": Hemisphere(0.02, 0.2, (0.51, 0.5))},
    "torsion": {
        "load": 20.0,
        "support": Uppermost(Plane(0.0, 1.0), Plane(1.0, -1.0), Plane(0.0, 0.0, 1.0), Plane(1.0, 0.0, -1.0)),
    },
    "load with a kink": {"support": 0.03, "load": cq.Smooth(lambda x, y: 1 + np.abs(x - 0.4), lipschitz=1.0)},
}


@pytest.mark.parametrize("name", KINKED)
def test_kinked_supports_are_enclosed(name):
    found = [solved(UNIT.lattice(1 / n), **KINKED[name]).continuum() for n in (16, 32, 64)]
    assert all(one.proven for one in found)
    assert all(meet(one.energy, two.energy) for one, two in pairwise(found))
    assert half_width(found[2].energy) < 0.6 * half_width(found[1].energy)


@pytest.mark.parametrize(("west", "south", "h"), [(0.1, -0.3, 0.013), (-1.7, 2.3, 0.1 / 3), (0.7, 0.9, 0.1)])
def test_a_roof_that_is_rounded_to_the_other_side_of_the_frame_is_enclosed(west, south, h):
    east, north = west + 14 * h, south + 11 * h
    flanks = [(-west, 1.0, 0.0), (east, -1.0, 0.0), (-south, 0.0, 1.0), (north, 0.0, -1.0)]
    roof = Uppermost(*(Plane(*flank) for flank in flanks))
    found = []
    for finer in (1, 4):
        mask = np.ones((11 * finer - 1, 14 * finer - 1), dtype=bool)
        lattice = cq.Lattice.from_mask(mask, h / finer, (west + h / finer, south + h / finer))
        found.append(solved(lattice, load=0.8 / h, support=roof).continuum())
    assert all(one.proven for one in found)
    assert meet(found[0].energy, found[1].energy)
    assert half_width(found[1].energy) < 0.6 * half_width(found[0].energy)


def integral_of_density(density, side, count=800):
    """Integrate over a square about zero by the midpoint rule."""
    middles = (np.arange(count) + 0.5) / count * side - side / 2
    x, y = np.meshgrid(middles, middles)
    return float(density(x, y).mean()) * side**2


CLOSED_FORMS: dict[str, Any] = {
    # u(x, y) upwards, |∇u|², p upwards so that J = ∫ ½|∇u|² - p u with p = -(downward load)
    "ring": (
        3.0,
        lambda x, y: np.maximum(np.hypot(x, y), 1.0) ** 2 / 2 - np.log(np.maximum(np.hypot(x, y), 1.0)) - 0.5,
        lambda r: np.where(r > 1, r - 1 / np.maximum(r, 1), 0.0),
        lambda x, y: 2.0 + 0 * x,
        {"load": 2.0, "support": 0.0, "upwards": True},
        *(2.0, 30.0, 2),
    ),
    "constant-obstacle": (
        2.0,
        lambda x, y: np.maximum(x**2 + y**2 - 0.49, 0.0) ** 2,
        lambda r: 4 * r * np.maximum(r**2 - 0.49, 0.0),
        lambda x, y: np.where(x**2 + y**2 <= 0.49, 3.92 * (1.49 - x**2 - y**2), 4 * (4 * (x**2 + y**2) - 0.98)),
        {
            "load": cq.Smooth(
                lambda x, y: np.where(x**2 + y**2 <= 0.49, 3.92 * (1.49 - x**2 - y**2), 4 * (4 * (x**2 + y**2) - 0.98)),
                lipschitz=46.0,
            ),
            "support": 0.0,
            "upwards": True,
        },
        *(23.0, 30.0, 1),  # of a load with a kink nothing but its slope is known
    ),
    "ball": (
        4.0,
        lambda x, y: _ball_height(x, y),
        lambda r: np.where(r <= 0.697965148223374, r / np.sqrt(np.maximum(1 - r**2, 0.01)), 0.680259411891719 / r),
        lambda x, y: 0 * x,
        {"load": 0.0, "support": cq.Smooth(CappedBall(0.9), second_derivative=12.2)},
        *(2.8, 300.0, 2),  # the sharpest bend of the ball stands for all of it
    ),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_forms_lie_within(name):
    side, height, slope, load, data, bend, width, order = CLOSED_FORMS[name]
    sign = 1.0 if data.get("upwards") else -1.0
    frame = cq.Smooth(lambda x, y: sign * height(x, y), second_derivative=bend)
    exact = integral_of_density(lambda x, y: slope(np.hypot(x, y)) ** 2 / 2 + load(x, y) * height(x, y), side)
    for n in (30, 61):
        solution = solved(cq.Frame.rectangle(side, side).lattice(side / n), frame_height=frame, **data)
        found = solution.continuum()
        assert found.proven
        assert found.energy.lower < exact + 1e-4 * abs(exact)
        assert exact - 1e-4 * abs(exact) < found.energy.upper
        assert half_width(found.energy) < width / n**order * abs(exact)


L_SHAPE = np.ones((15, 15), dtype=bool)
L_SHAPE[7:, 7:] = False


def finer(mask):
    """Return the mask of the same region on a lattice of half the spacing."""
    plan = np.pad(mask, 1)
    squares = plan[:-1, :-1] | plan[1:, :-1] | plan[:-1, 1:] | plan[1:, 1:]
    doubled = np.repeat(np.repeat(squares, 2, axis=0), 2, axis=1)
    inner = doubled[:-1, :-1] & doubled[1:, :-1] & doubled[:-1, 1:] & doubled[1:, 1:]
    # A slit, an edge between two frame points inside the region, stays one.
    frame = ~plan
    for axis in (0, 1):
        along = frame[:-1] & frame[1:] if axis == 0 else frame[:, :-1] & frame[:, 1:]
        for i, j in np.argwhere(along):
            for step in range(3):
                row, column = 2 * i + step * (axis == 0) - 1, 2 * j + step * (axis == 1) - 1
                if 0 <= row < inner.shape[0] and 0 <= column < inner.shape[1]:
                    inner[row, column] = False
    return inner


SLIT = np.ones((11, 11), dtype=bool)
SLIT[5, :6] = False
STEPS = np.array([[abs(i - 6) + abs(j - 6) < 6 for j in range(13)] for i in range(13)])
HOLE = np.ones((12, 14), dtype=bool)
HOLE[4:7, 5:9] = False


@pytest.mark.parametrize("mask", [L_SHAPE, SLIT, STEPS, HOLE], ids=["L", "slit", "steps", "hole"])
def test_any_frame_along_lines_of_the_lattice(mask):
    masks = [mask, finer(mask), finer(finer(mask))]
    found = [
        solved(cq.Lattice.from_mask(one, spacing=1 / 2**k, origin=(2.0**-k, 2.0**-k)), support=3.0).continuum()
        for k, one in enumerate(masks)
    ]
    assert all(meet(one.energy, two.energy) for one, two in pairwise(found))
    assert half_width(found[2].energy) < 0.5 * half_width(found[0].energy)


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_membranes_are_where_their_finer_lattices_are(seed):
    """Brackets meet, and the interpolants of two lattices are no farther apart than both bounds say."""
    rng = np.random.default_rng(seed)
    sides = rng.integers(2, 6, 2)
    waves, phases = rng.uniform(0, 3, (2, 2)), rng.uniform(0, 6, 2)

    def wavy(k, size):
        a, b = waves[k]
        return cq.Smooth(
            lambda x, y: size * np.sin(a * x + b * y + phases[k]), second_derivative=size * float(a**2 + b**2)
        )

    rising = rng.uniform(-1, 1, 3)
    deep = 0.3 * rng.uniform(0.02, 1) * float(sides.min()) ** 2
    supports = [
        deep,
        Uppermost(Plane(deep, *(0.1 * deep * rising[:2])), Paraboloid(0.8 * deep, 5.0, tuple(sides / 2))),
        cq.Smooth(lambda x, y: deep * (1.5 + 0.3 * wavy(1, 1.0)(x, y)), second_derivative=deep * 0.3 * 18),
        cq.profiles.Hemisphere(0.5 * deep, float(sides.min()) / 3, tuple(sides / 2 + 0.1)),
    ]
    data = {
        "load": [1.0, wavy(0, 2.0)][rng.integers(2)],
        "support": supports[rng.integers(4)],
        "tension": [1.0, (1.0, 0.4), 1.0 + rng.uniform(0, 2)][rng.integers(3)],
        "foundation": [None, 0.7][rng.integers(2)],
        "ceiling": [None, -0.4 * deep][rng.integers(2)],
    }
    h = float(rng.choice([0.5, 0.25]))
    frame = cq.Frame.rectangle(*map(float, sides), center=tuple(sides / 2))
    coarse, fine = (solved(frame.lattice(spacing), **data) for spacing in (h, h / 4))
    one, two = coarse.continuum(), fine.continuum()
    assert meet(one.energy, two.energy)
    below = [solution.model.padded_below(solution.gap) for solution in (coarse, fine)]
    inside = prolonged(below[0][1:-1, 1:-1], 4)  # without the ring about the frame's points
    apart = stretch_of(Data.of(fine.model), np.pad(inside - below[1][1:-1, 1:-1], 1)).norm
    assert apart <= one.energy_error + two.energy_error


def prolonged(points, times):
    """Return the bilinear interpolant of values on a lattice on one that is so many times as fine."""
    for axis in (0, 1):
        places = np.linspace(0, points.shape[axis] - 1, times * (points.shape[axis] - 1) + 1)
        low = np.minimum(places.astype(int), points.shape[axis] - 2)
        shape = [-1 if k == axis else 1 for k in (0, 1)]
        share = (places - low).reshape(shape)
        points = points.take(low, axis) * (1 - share) + points.take(low + 1, axis) * share
    return points


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_any_heights_at_the_nodes_give_bounds(seed):
    """Nothing is assumed of how an answer was found: wrong ones give wide bounds that hold."""
    rng = np.random.default_rng(seed)
    lattice = cq.Frame.rectangle(4, 3).lattice(0.5)
    data = {"support": 0.5, "ceiling": [None, -0.1][rng.integers(2)], "foundation": [None, 1.0][rng.integers(2)]}
    solution = solved(lattice, **data)
    right = solution.continuum().energy
    wrong = solution.gap + 10.0 ** rng.uniform(-12, 0) * rng.normal(size=solution.gap.size)
    found = energy_bounds(Data.of(solution.model), solution.model.padded_below(wrong))
    assert meet(found.energy, right)
    apart = stretch_of(
        Data.of(solution.model), solution.model.padded_below(wrong) - solution.model.padded_below(solution.gap)
    ).norm
    assert apart <= found.error + solution.continuum().energy_error


def exactly(number):
    return Fraction(float(number))


def simpson(function):
    """Integrate a polynomial of at most third degree over [0, ½]."""
    return (function(Fraction(0)) + 4 * function(Fraction(1, 4)) + function(Fraction(1, 2))) / 12


@settings(max_examples=5)
@given(seed=st.integers(0, 2**32 - 1))
def test_energy_and_misfit_in_rational_numbers(seed):
    """The parts of the bound, and the identity that they come from, in exact arithmetic on small lattices.

    J(v) + ∫|y|²/2T + ∫λf is ½η² + ∫λ(f - v) where the frame is at height zero: Gauss's theorem holds of the fluxes.
    """
    rng = np.random.default_rng(seed)
    mask = np.ones((3, 4), dtype=bool)
    mask[: rng.integers(3), : rng.integers(4)] = False
    spacing, load = float(10.0 ** rng.uniform(-3, 3)), float(rng.normal() * 10.0 ** rng.uniform(-3, 3))
    tension = tuple(10.0 ** rng.uniform(-3, 3, 2))
    lattice = cq.Lattice.from_mask(mask, spacing=spacing)
    size = abs(load) * spacing**2
    model = cq.Membrane(lattice, tension=tension, load=load, support=np.inf)
    data = Data.of(model)
    heights = np.zeros(data.plan.nodes.shape)
    heights[data.plan.nodes] = size * rng.normal(size=lattice.size)
    flux, _ = balanced_flux(data, heights, heights)
    h, p, t = exactly(spacing), exactly(load), [exactly(each) for each in tension]
    stored = work = misfit = dual = left = Fraction(0)
    for i, j in np.argwhere(data.plan.squares):
        v = {(d, r): exactly(heights[i + d, j + r]) for d in (0, 1) for r in (0, 1)}
        for corner, (down, right) in enumerate(CORNERS):
            out_x, out_y = (-1 if right else 1), (-1 if down else 1)
            ends = {(a, b): v[down ^ a, right ^ b] for a in (0, 1) for b in (0, 1)}

            def value(s, r, ends=ends):
                return (1 - r) * ((1 - s) * ends[0, 0] + s * ends[0, 1]) + r * ((1 - s) * ends[1, 0] + s * ends[1, 1])

            def slope_x(s, r, ends=ends):
                return (1 - r) * (ends[0, 1] - ends[0, 0]) + r * (ends[1, 1] - ends[1, 0])

            def slope_y(s, r, ends=ends):
                return (1 - s) * (ends[1, 0] - ends[0, 0]) + s * (ends[1, 1] - ends[0, 1])

            near_x, near_y = (exactly(part[i, j]) for part in flux.at_corners[corner])
            far_x, far_y = (exactly(flux.in_quarters(axis, corner)[0][i, j]) for axis in (1, 0))

            node = i + down, j + right
            # Either quarter beside a line has what flows through it, but for lines of the frame.
            for which, around in enumerate((near_x, near_y)):
                beyond = CORNERS.index((down, 1 - right) if which == 0 else (1 - down, right))
                assert flux.in_quarters(1 - which, beyond)[0] is flux.in_quarters(1 - which, corner)[0]
                step = (i, j - 1 + 2 * right) if which == 0 else (i - 1 + 2 * down, j)
                ahead = (i + 1 - down, j + right) if which == 0 else (i + down, j + 1 - right)
                if data.plan.nodes[node] or data.plan.nodes[ahead]:
                    assert exactly(flux.at_corners[beyond][which][step]) == around

            def flux_x(s, near=near_x, far=far_x, sign=out_x):
                return sign * (near + 2 * s * (far - near))

            def flux_y(r, near=near_y, far=far_y, sign=out_y):
                return sign * (near + 2 * r * (far - near))

            divergence = 2 * (out_x * (far_x - near_x) + out_y * (far_y - near_y)) / h**2
            multiplier = p + divergence
            if data.plan.nodes[node]:  # λ is the lattice's own reaction in all four quarters
                assert abs(multiplier * h**2 - exactly(flux.reaction[node])) <= exactly(flux.rounding[node])

            def both(function):
                return simpson(lambda s: simpson(partial(function, s)))

            stored += both(lambda s, r: t[0] * slope_x(s, r) ** 2 + t[1] * slope_y(s, r) ** 2) / 2
            work += p * h**2 * both(value)
            misfit += both(
                lambda s, r: (
                    (t[0] * slope_x(s, r) - flux_x(s)) ** 2 / t[0] + (t[1] * slope_y(s, r) - flux_y(r)) ** 2 / t[1]
                )
            )
            dual += both(lambda s, r: flux_x(s) ** 2 / t[0] + flux_y(r) ** 2 / t[1])
            left += multiplier * h**2 * both(value)
    # The identity, with f = 0 for a moment: J(v) = ½η² - ½∫|y|²/T - ∫λv but for rounding in nothing.
    assert stored - work == misfit / 2 - dual / 2 - left
    bracket = energies._energy(data, heights, stretch_of(data, heights), 0.0)
    assert exactly(bracket.lower) <= stored - work <= exactly(bracket.upper)
    assert misfit <= exactly(norm_over(misfit_in_squares(data, heights, flux))) ** 2
    assert (
        exactly(norm_over(misfit_in_squares(data, heights, flux))) ** 2
        <= misfit * (1 + Fraction(1, 10**9)) + Fraction(size) ** 2 / 10**20
    )


def test_data_between_the_nodes_are_told_as_they_are_known():
    lattice = UNIT.lattice(1 / 8)
    sampled = solved(lattice, load=lambda x, y: 1 + x, support=0.03).continuum()
    assert not sampled.proven
    assert sampled.sampled == ("load",)
    assert "not proven" in str(sampled)
    assert "sampled data: load" in str(sampled)
    assert max(map(len, str(sampled).splitlines())) <= 80
    own = solved(lattice, load=np.ones(lattice.size), support=0.03)
    assert own.continuum().proven
    assert "proven of the continuum itself" in str(own.continuum())
    varied = cq.Solver(own.model).solve(load=1 + lattice.node_x)
    assert varied.continuum().sampled == ("load",)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: solved(cq.Frame.disk(1.0).lattice(0.25), support=0.1), "lies beside the lattice's points"),
        (
            lambda: solved(cq.Frame.polygon([(0, 0), (8, 0), (0, 8)]).lattice(1.0), support=0.1),
            "has slanted sides that cut squares, and only a frame that runs along lines",
        ),
        (lambda: solved(cq.Frame.disk(1.0).lattice(0.25, fitted=True), support=0.1), "cuts squares anywhere"),
        (lambda: solved(UNIT.lattice(0.25), support=-0.1), "frame at x=0, y=0 lies beyond the support, by 0.1"),
    ],
)
def test_what_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make().continuum()


def test_models_of_other_kinds_and_bare_problems_are_refused():
    with pytest.raises(AttributeError, match="continuum needs a model"):
        cq.solve(cq.ContactQP([[2.0]], [-1.0])).continuum()
    with pytest.raises(TypeError, match="of a Membrane or a Cable"):
        cq.solve(cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=1.0, support=1.0)).continuum()
    with pytest.raises(ValueError, match="effort must be"):
        solved(UNIT.lattice(0.25), support=0.03).continuum("all")


# What is even at the points of a lattice, and is not between them.


def _between_points(most, spacing):
    """Return a function that is 0 at all points and middles of a lattice, and ``most`` between these."""
    bend = most * 2 * (2 * np.pi / spacing) ** 2
    return cq.Smooth(lambda x, y: most * np.sin(2 * np.pi * x / spacing) ** 2 + 0 * y, second_derivative=bend)


def test_a_tension_that_varies_between_points_is_no_number():
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 8)
    wave = _between_points(0.05, 1 / 8)
    tension = cq.Smooth(lambda x, y: 1 + wave(x, y), second_derivative=wave.second_derivative)
    solution = cq.solve(cq.Membrane(lattice, tension, load=1.0, support=3.0))
    assert solution.continuum().proven
    with pytest.raises(ValueError, match="a tension that varies"):
        solution.continuum("pointwise")
    cable = cq.solve(cq.Cable(1.0, spacing=1 / 8, tension=tension, load=1.0, support=3.0)).continuum()
    with pytest.raises(AttributeError):
        _ = cable.lower


def test_a_foundation_between_points_counts():
    """Its mean is 50, under which the membrane stores much less energy than without."""
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 8)
    springs = _between_points(100.0, 1 / 8)
    told = cq.solve(cq.Membrane(lattice, 1.0, load=1.0, support=3.0, foundation=springs)).continuum()
    fine = cq.Frame.rectangle(1, 1).lattice(1 / 16)
    mean = cq.solve(cq.Membrane(fine, 1.0, load=1.0, support=3.0, foundation=50.0)).continuum()
    assert told.energy.upper > mean.energy.lower


@pytest.mark.parametrize("constant", ["lipschitz", "second_derivative"])
def test_a_tension_that_may_vanish_between_points_is_refused(constant):
    lattice = cq.Frame.rectangle(1, 1).lattice(1 / 8)
    tension = cq.Smooth(lambda x, y: 1 + 0.9 * np.sin(9 * x) + 0 * y, **{constant: 1000.0})
    solution = cq.solve(cq.Membrane(lattice, tension, load=1.0, support=0.03))
    with pytest.raises(ValueError, match="tension is known to be no less than"):
        solution.continuum()
    cable = cq.solve(cq.Cable(1.0, spacing=1 / 8, tension=tension, load=1.0, support=0.03))
    with pytest.raises(ValueError, match="tension is known to be no less than"):
        cable.continuum()
