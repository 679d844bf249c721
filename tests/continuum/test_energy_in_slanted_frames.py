"""Bounds of energies where the frame halves squares: against exact solutions, finer lattices and exact arithmetic."""

import warnings
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from quadratics import Quadratic

import contactqp as cq
from contactqp.continuum import energy as energies
from contactqp.continuum.data import Data
from contactqp.continuum.energy import energy_bounds, points_of
from contactqp.continuum.frame_room import require_room
from contactqp.continuum.majorant import balanced_flux, leaves_of, misfit_in_squares, rim_in_squares, stretch_of
from contactqp.continuum.majorant_on_halves import (
    BENT_MEAN,
    apart_on_halves,
    fall_on_halves,
    unevenness_of_triangles,
)
from contactqp.continuum.plan import CORNERS, Plan
from contactqp.continuum.relatives import finer
from contactqp.profiles import HillAndFloor, Paraboloid, Plane, Uppermost

HEXAGON = [(32, 0), (8, 24), (-8, 24), (-32, 0), (-8, -24), (8, -24)]
DIAMOND = [(32, 0), (0, 32), (-32, 0), (0, -32)]
PENTAGON = [(-32, -24), (32, -24), (32, 0), (8, 24), (-32, 24)]
HOUSE = [(-16, -16), (16, -16), (16, 16), (0, 32), (-16, 16)]
INWARDS = [(-32, -24), (32, -24), (32, 24), (16, 24), (0, 8), (-16, 24), (-32, 24)]
CROSS = [(0, -16), (16, -32), (32, -16), (16, 0), (32, 16), (16, 32), (0, 16), (-16, 32), (-32, 16), (-16, 0)]
CROSS += [(-32, -16), (-16, -32)]


def membrane(corners, spacing, **changes):
    lattice = cq.Frame.polygon(corners).lattice(spacing)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        return cq.Membrane(lattice, **({"tension": 1.0, "load": 0.03, "support": 1.25} | changes))


def solved(model, tol=1e-10):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        return cq.solve(model, tol=tol)


def half_width(bracket):
    return (bracket.upper - bracket.lower) / 2


def meet(first, second):
    return first.lower <= second.upper and second.lower <= first.upper


def interpolant(solution):
    """Return the answer's values at the points, the frame's among them, and the plan of these."""
    data = Data.of(solution.model)
    return points_of(data, solution.model.padded_below(solution.gap)), data.plan


def prolonged(points, plan):
    """Return values on a lattice of half the spacing: bilinear in squares, and linear on halves, on its whole array."""
    rows, columns = points.shape
    found = np.zeros((2 * rows - 1, 2 * columns - 1))
    found[::2, ::2] = points
    found[1::2, ::2] = (points[1:] + points[:-1]) / 2
    found[::2, 1::2] = (points[:, 1:] + points[:, :-1]) / 2
    found[1::2, 1::2] = (points[1:, 1:] + points[1:, :-1] + points[:-1, 1:] + points[:-1, :-1]) / 4
    for row, column in np.argwhere(plan.halved):
        falling = plan.nodes[row, column] or plan.nodes[row + 1, column + 1]
        ends = ((row, column + 1), (row + 1, column)) if falling else ((row, column), (row + 1, column + 1))
        found[2 * row + 1, 2 * column + 1] = (points[ends[0]] + points[ends[1]]) / 2
    return found


def distance(coarse, fine, halvings):
    """Return the energy norm of the difference of two answers' interpolants, the second of a finer lattice."""
    points, plan = interpolant(coarse)
    other, last = interpolant(fine)
    model = coarse.model
    for _ in range(halvings):
        points, model = prolonged(points, plan), finer(model)
        plan = Data.of(model).plan
        # The finer lattice's array is that of the points, with a ring of its own.
        points = np.pad(points, 1)
    held, own = (np.argwhere(each.points).min(axis=0) for each in (plan, last))
    size = np.argwhere(last.points).max(axis=0) - own + 1
    first, second = (
        np.where(each.points, values, 0.0)[at[0] : at[0] + size[0], at[1] : at[1] + size[1]]
        for each, values, at in ((plan, points, held), (last, other, own))
    )
    apart = np.zeros(last.nodes.shape)
    apart[own[0] : own[0] + size[0], own[1] : own[1] + size[1]] = first - second
    return stretch_of(Data.of(fine.model), apart).norm


WAVY = cq.Smooth(
    lambda x, y: 0.03 + 0.02 * np.sin(x / 20) * np.cos(y / 25), second_derivative=0.02 * (1 / 20**2 + 1 / 25**2)
)
VARIED = cq.Smooth(
    lambda x, y: 1 + 0.3 * np.sin(x / 20) * np.cos(y / 25), second_derivative=0.3 * (1 / 20**2 + 1 / 25**2)
)
SPRINGS = cq.Smooth(lambda x, y: 0.01 + 1e-5 * x * x, second_derivative=2e-5)
HANGING = cq.Smooth(lambda x, y: 2e-4 * (x * x + y * y), second_derivative=4e-4)

SMOOTH = {
    "floor": {},
    "nothing": {"support": np.inf},
    "plane": {"support": Plane(1.5, 0.005, -0.003)},
    "hill": {"support": Paraboloid(1.25, 1000.0)},
    "bowl": {"support": Paraboloid(1.5, -1000.0)},
    "two tensions": {"tension": (1.6, 0.8)},
    "tension that varies": {"tension": VARIED},
    "two that vary": {"tension": (VARIED, 1.3)},
    "load that varies": {"load": WAVY},
    "suction under a ceiling": {
        "ceiling": -0.6,
        "load": cq.Smooth(lambda x, y: 0.04 * np.cos(x / 16), second_derivative=0.04 / 256),
    },
    "springs": {"foundation": 0.003},
    "springs that vary": {"foundation": SPRINGS, "load": 0.06},
    "tilted": {"frame_height": Plane(0.0, 0.004, 0.002)},
    "frame": {"frame_height": HANGING, "support": 1.5},
    "upwards": {"support": -1.25, "frame_height": HANGING, "upwards": True},
}
FRAMES = {"hexagon": HEXAGON, "diamond": DIAMOND, "pentagon": PENTAGON, "house": HOUSE}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", SMOOTH)
def test_brackets_of_all_spacings_meet_and_shrink_at_second_order(frame, name):
    found = [solved(membrane(FRAMES[frame], h, **SMOOTH[name])).continuum() for h in (2.0, 1.0, 0.5)]
    assert all(one.proven for one in found)
    assert all(meet(one.energy, two.energy) for one, two in pairwise(found))
    # Each lies within the one before but for a little.
    for wide, narrow in pairwise(found):
        slack = 0.3 * half_width(wide.energy)
        assert wide.energy.lower - slack <= narrow.energy.lower <= narrow.energy.upper <= wide.energy.upper + slack
    order = np.log2(half_width(found[0].energy) / half_width(found[2].energy)) / 2
    assert order >= 1.9
    # So does what upper ends tell, of second order.
    upper = [one.energy.upper for one in found]
    extrapolated = upper[2] + (upper[2] - upper[1]) / 3
    assert found[1].energy.lower <= extrapolated <= found[1].energy.upper
    assert found[0].contact_error < 8 * half_width(found[0].energy)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", SMOOTH)
def test_the_norm_is_bounded_within_half(frame, name):
    """A lattice of an eighth of the spacing stands for the membrane, within its own bound."""
    coarse, fine = (solved(membrane(FRAMES[frame], h, **SMOOTH[name])) for h in (2.0, 0.25))
    one, two, apart = coarse.continuum(), fine.continuum(), distance(coarse, fine, 3)
    assert apart <= one.energy_error + two.energy_error
    assert 0.98 * apart < one.energy_error < 1.5 * apart
    assert one.energy.lower <= two.energy.upper <= one.energy.upper


@pytest.mark.parametrize("corners", [INWARDS, CROSS], ids=["inwards", "cross"])
@pytest.mark.parametrize("name", ["floor", "nothing", "hill", "two tensions", "load that varies", "springs", "frame"])
def test_corners_may_point_inwards(corners, name):
    """There the membrane has no second derivatives, and all is of a lower order."""
    solutions = [solved(membrane(corners, h, **SMOOTH[name])) for h in (4.0, 2.0, 1.0, 0.5)]
    found = [solution.continuum() for solution in solutions]
    assert all(one.proven for one in found)
    for k, wide in enumerate(found):
        for narrow in found[k + 1 :]:
            assert meet(wide.energy, narrow.energy)
    assert half_width(found[3].energy) < 0.15 * half_width(found[1].energy)
    apart = distance(solutions[1], solutions[3], 2)
    assert apart <= found[1].energy_error + found[3].energy_error
    assert found[1].energy_error < 1.7 * apart  # the finest lattice's own error is not small


def test_arrays_are_linear_on_halves():
    """Numbers at the points stand for planes, whose brackets those of the functions themselves meet."""
    places = {}
    for h in (4.0, 2.0):
        lattice = membrane(HEXAGON, h).lattice
        row, column = np.indices(lattice.shape)
        x, y = lattice.ring_coordinates(row + 1, column + 1)
        places[h] = x, y
    planes = {"load": (0.03, 2e-4, -1e-4), "support": (1.5, 0.005, -0.003), "foundation": (1e-3, 1e-5, 5e-6)}
    planes["tension"] = (1.0, 0.004, 0.002)
    for h, (x, y) in places.items():
        arrays = {name: a + b * x + c * y for name, (a, b, c) in planes.items()}
        functions = {name: Plane(*plane) for name, plane in planes.items()}
        del functions["tension"]
        tension = arrays.pop("tension")
        one = solved(membrane(HEXAGON, h, tension=tension, **arrays)).continuum()
        two = solved(membrane(HEXAGON, h, tension=tension, **functions)).continuum()
        assert one.proven
        assert two.proven
        assert meet(one.energy, two.energy)
        assert half_width(one.energy) == pytest.approx(half_width(two.energy), rel=0.05)


# Exact solutions.


def integral_over(corners, density):
    """Integrate a polynomial of degree at most 8 over a polygon that is star-shaped about zero."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    r, s = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2)
    weight = np.outer(weights, weights) / 4 * r
    total = 0.0
    for k, (x, y) in enumerate(corners):
        last_x, last_y = corners[k - 1]
        at_x, at_y = r * (last_x + s * (x - last_x)), r * (last_y + s * (y - last_y))
        total += (weight * density(at_x, at_y)).sum() * (last_x * y - x * last_y)
    return total


POLYNOMIALS = {
    # w with Δw = -p, its gradient, a bound of its second derivatives within the frame, and p
    "saddle": (
        lambda x, y: 2e-3 * (x * x - y * y) - 0.03 / 4 * (x * x + y * y),
        lambda x, y: (4e-3 * x - 0.015 * x, -4e-3 * y - 0.015 * y),
        0.019,
        0.03,
    ),
    "twist": (lambda x, y: 3e-3 * x * y + 0.1 * x, lambda x, y: (3e-3 * y + 0.1, 3e-3 * x), 3e-3, 0.0),
    "cubic": (
        lambda x, y: 1e-4 * (x**3 - 3 * x * y * y) - 0.01 * y * y,
        lambda x, y: (3e-4 * (x * x - y * y), -6e-4 * x * y - 0.02 * y),
        0.0412,
        0.02,
    ),
}


@pytest.mark.parametrize("corners", [HEXAGON, DIAMOND, HOUSE, INWARDS], ids=["hexagon", "diamond", "house", "inwards"])
@pytest.mark.parametrize("name", POLYNOMIALS)
def test_polynomials_lie_within(corners, name):
    """The frame is held at the height of the solution, which bends along diagonals as well."""
    height, slope, bend, load = POLYNOMIALS[name]
    exact = integral_over(corners, lambda x, y: (slope(x, y)[0] ** 2 + slope(x, y)[1] ** 2) / 2 - load * height(x, y))
    frame = cq.Smooth(height, second_derivative=bend)
    found = [
        solved(membrane(corners, h, load=load, support=np.inf, frame_height=frame)).continuum() for h in (2.0, 1.0, 0.5)
    ]
    for one in found:
        assert one.energy.lower <= exact + 1e-9 * abs(exact)
        assert exact - 1e-9 * abs(exact) <= one.energy.upper
    assert half_width(found[1].energy) / half_width(found[2].energy) > 2**1.6
    # v is not w alone: its error is known, too.
    solution = solved(membrane(corners, 2.0, load=load, support=np.inf, frame_height=frame))
    points, plan = interpolant(solution)
    x, y = plan.places
    worst = np.abs(points - height(x, y))[plan.points].max()
    assert worst < 0.1


def torsion_energy(side, load):
    """Return J of a free membrane of tension 1 over a square, by its double series."""
    m = np.arange(1, 4001, 2, dtype=float)
    first, second = m[:, None], m[None, :]
    volume = 64 * load * side**4 / np.pi**6 * (1 / (first**2 * second**2 * (first**2 + second**2))).sum()
    return -load * volume / 2


def test_the_diamond_is_a_square_turned():
    exact = torsion_energy(32 * np.sqrt(2), 0.03)
    for h in (4.0, 2.0, 1.0, 0.5):
        found = solved(membrane(DIAMOND, h, support=np.inf)).continuum()
        assert found.energy.lower <= exact * (1 - 1e-9)
        assert exact * (1 + 1e-9) <= found.energy.upper
    side = 32 * np.sqrt(2)
    for data in ({}, {"foundation": 0.003}, {"support": 0.9, "load": 0.05}, {"ceiling": -0.5, "load": -0.03}):
        straight = cq.Membrane(
            cq.Frame.rectangle(side, side).lattice(side / 128),
            **({"tension": 1.0, "load": 0.03, "support": 1.25} | data),
        )
        turned, square = solved(membrane(DIAMOND, 0.5, **data)).continuum(), solved(straight).continuum()
        assert meet(turned.energy, square.energy)
        assert half_width(turned.energy) < 2 * half_width(square.energy)


# The parts of the bounds, evaluated as they are defined.


def random_region(rng, most=5):
    """Return a lattice of any squares, some of which with one node are halved; None if it holds lone points."""
    mask = rng.uniform(size=rng.integers(1, most, 2)) < rng.uniform(0.4, 1.0)
    if not mask.any():
        return None
    mask = np.pad(mask, 1)  # arrays then tell what there is on the frame
    nodes = np.pad(mask, 1).astype(int)
    count = nodes[:-1, :-1] + nodes[1:, :-1] + nodes[:-1, 1:] + nodes[1:, 1:]
    halved = (count == 1) & (rng.uniform(size=count.shape) < rng.uniform(0.3, 1.0))
    spacing = float(10.0 ** rng.uniform(-1, 1))
    lattice = cq.Lattice(mask, spacing, tuple(rng.uniform(-1, 1, 2)), slanted=bool(halved.any()), halved=halved)
    try:
        _ = Plan(lattice).chains
    except ValueError:
        return None
    return lattice


class Part:
    """The part of a square that belongs to one of its corners: a quarter, or a triangle of a half; in units of h.

    Attributes
    ----------
    s, t, weight : array
        Quadrature points, as distances from the corner along x and y, and weights, exact for degree 6.
    """

    def __init__(self, plan, row, column, corner):
        self.plan, self.place, self.corner = plan, (row, column), corner
        self.down, self.right = CORNERS[corner]
        self.point = row + self.down, column + self.right
        self.out_x, self.out_y = 1 - 2 * self.right, 1 - 2 * self.down
        self.beside, self.above = (
            (self.point[0], self.point[1] + self.out_x),
            (self.point[0] + self.out_y, self.point[1]),
        )
        self.across = self.above[0], self.beside[1]
        self.halved = bool(plan.halved[row, column])
        nodes, weights = np.polynomial.legendre.leggauss(4)
        a, b = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2)
        weight = np.outer(weights, weights) / 4
        self.s, self.t, self.weight = a / 2, b / 2, weight / 4
        self.towards = None
        if self.halved and not plan.nodes[self.point]:
            # Of the triangle with a corner here, its right angle half the way to the node, and the square's centre.
            self.towards = "x" if plan.nodes[self.beside] else "y"
            along, across = 0.5 * a, 0.5 * a * b
            self.s, self.t = (along, across) if self.towards == "x" else (across, along)
            self.weight = weight * a / 4

    @classmethod
    def all_of(cls, plan):
        return [
            cls(plan, row, column, corner)
            for row, column in np.argwhere(plan.squares)
            for corner in range(4)
            if plan.having(corner)[row, column]
        ]

    def value(self, points):
        """Return a field that is bilinear, or linear on a half, and its derivatives along x and y, at the places."""
        own, beside, above, across = (points[at] for at in (self.point, self.beside, self.above, self.across))
        if self.halved:
            if self.towards == "x":
                above = own + across - beside
            elif self.towards == "y":
                beside = own + across - above
            across = beside + above - own
        twist = own - beside - above + across
        found = own + (beside - own) * self.s + (above - own) * self.t + twist * self.s * self.t
        along_x, along_y = (beside - own) + twist * self.t, (above - own) + twist * self.s
        return found, self.out_x * along_x + 0 * found, self.out_y * along_y + 0 * found

    def flux(self, flux, s, t):
        """Return y times h at distances from the corner, and h² div y."""
        lines = flux.through[0][self.down][self.place], flux.through[1][self.right][self.place]
        at = [part[self.place] for part in flux.at_corners[self.corner]]
        if self.towards is not None:
            rate = -flux.force[self.point] * self.plan.spacing**2 / 2
            # From the right angle, in the middle of the leg towards the node.
            x, y = (s - 0.5, t) if self.towards == "x" else (s, t - 0.5)
            start = (lines[0], at[1]) if self.towards == "x" else (at[0], lines[1])
            return start[0] + rate * self.out_x * x, start[1] + rate * self.out_y * y, 2 * rate + 0 * x
        bow = [part[self.point] if self.plan.nodes[self.point] else 0.0 for part in flux.bow]
        y_x = at[0] + (lines[0] - at[0]) * 2 * s + bow[0] * (1 - 4 * s * s)
        y_y = at[1] + (lines[1] - at[1]) * 2 * t + bow[1] * (1 - 4 * t * t)
        rate = 2 * self.out_x * (lines[0] - at[0]) + 2 * self.out_y * (lines[1] - at[1])
        return y_x, y_y, rate - 8 * self.out_x * bow[0] * s - 8 * self.out_y * bow[1] * t

    @property
    def edges(self):
        """Edges along lines: their middles in quarters of h, the normal's axis, a place, and if the frame is there."""
        x, y = 4 * self.point[1], 4 * self.point[0]
        held = not self.plan.nodes[self.point]
        upright = (x, y + self.out_y), 0, (0.0, 0.25), held and not self.plan.nodes[self.above]
        level = (x + self.out_x, y), 1, (0.25, 0.0), held and not self.plan.nodes[self.beside]
        far_upright = (x + 2 * self.out_x, y + self.out_y), 0, (0.5, 0.25), False
        far_level = (x + self.out_x, y + 2 * self.out_y), 1, (0.25, 0.5), False
        if self.towards is None:
            return [upright, level, far_upright, far_level]
        return [level, far_upright] if self.towards == "x" else [upright, far_level]


def random_data(rng, lattice):
    """Return a membrane with arrays for data, all of which are linear on halves, and any heights of its nodes."""
    size, shape = float(10.0 ** rng.uniform(-1, 1)), lattice.shape

    def array(least, most):
        return rng.uniform(least, most, shape)

    data = {"load": [size, size * array(-1, 1)][rng.integers(2)]}
    if rng.integers(2):
        data["foundation"] = array(0, 1) / lattice.spacing**2
    if rng.integers(2):
        data["tension"] = [(1.5, 0.5), array(0.5, 2), (array(0.5, 2), 0.7)][rng.integers(3)]
    if rng.integers(2):
        data["frame_height"] = array(-1, 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        return cq.Membrane(lattice, **({"tension": 1.0, "support": np.inf} | data))


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_fluxes_are_admissible_and_integrals_are_what_they_are_told_to_be(seed):
    rng = np.random.default_rng(seed)
    lattice = random_region(rng)
    assume(lattice is not None)
    data = Data.of(random_data(rng, lattice))
    plan, square = data.plan, lattice.spacing**2
    own = points_of(data, np.where(np.pad(lattice.mask, 1), rng.normal(size=data.plan.nodes.shape), 0.0))
    flux, force = balanced_flux(data, own, own)
    load = np.where(plan.points, np.broadcast_to(data.load.values, own.shape), 0.0)
    springs = 0.0 * load if data.foundation is None else np.where(plan.points, data.foundation.values, 0.0)
    energy = norm = 0.0
    misfit, area = np.zeros(plan.squares.shape), 0.0
    seen: dict[tuple[int, int], list[float]] = {}
    for part in Part.all_of(plan):
        v, v_x, v_y = part.value(own)
        y_x, y_y, divergence = part.flux(flux, part.s, part.t)
        # div y is what the node's reaction leaves, or -(p - kv) at the frame.
        if plan.nodes[part.point]:
            bows = [each[part.point] for each in flux.bow]
            mean = -8 * part.out_x * bows[0] * part.s - 8 * part.out_y * bows[1] * part.t
            wanted = flux.reaction[part.point] - force[part.point] * square + mean
            room = flux.rounding[part.point] + 1e-12 * np.abs(bows).max()
        else:
            wanted = -force[part.point] * square
            room = 1e-12 * (np.abs([*y_x.ravel(), *y_y.ravel()]).max() + abs(wanted))
        assert (np.abs(divergence - wanted) <= room).all()
        for edge, axis, at, on_frame in part.edges:
            if not on_frame:
                seen.setdefault(edge, []).append(float(part.flux(flux, *np.array(at))[axis]))
        tensions = [float(np.broadcast_to(_tension_at(data, axis, part), ())) for axis in (1, 0)]
        p, k = part.value(load)[0], part.value(springs)[0]
        stretch = tensions[0] * v_x**2 + tensions[1] * v_y**2
        energy += (part.weight * (stretch / 2 + square * (k * v * v / 2 - p * v))).sum()
        norm += (part.weight * (stretch + square * k * v * v)).sum()
        off = (tensions[0] * v_x - y_x) ** 2 / tensions[0] + (tensions[1] * v_y - y_y) ** 2 / tensions[1]
        misfit[part.place] += (part.weight * off).sum()
        area += part.weight.sum()
    assert area == pytest.approx(plan.whole.sum() + plan.halved.sum() / 2)
    # Off the frame, on which slits are as well, either side of each edge has one number.
    assert all(len(sides) == 2 for sides in seen.values())
    for one, two in seen.values():
        assert one == pytest.approx(two, rel=1e-12, abs=1e-12 * (1 + abs(one)))
    bracket = energies._energy(data, own, stretch_of(data, own), 0.0)
    size = abs(energy) + 1e-9 * norm
    assert bracket.lower - 1e-12 * size <= energy <= bracket.upper + 1e-12 * size
    if data.foundation is None:  # the product of springs and heights is no array
        assert half_width(bracket) <= 1e-9 * (
            norm + square * np.abs(load).max() * np.abs(own).max() * plan.squares.sum()
        )
        assert stretch_of(data, own).norm == pytest.approx(np.sqrt(norm), rel=1e-9)
    assert np.sqrt(norm) <= stretch_of(data, own).norm * (1 + 1e-12)
    with np.errstate(invalid="ignore", divide="ignore"):  # where no square is, there is no tension
        told = misfit_in_squares(data, own, flux)
    np.testing.assert_allclose(told, np.sqrt(misfit), rtol=1e-9, atol=1e-9 * np.sqrt(misfit.max()))


def _tension_at(data, axis, part):
    """Return the tension in a part, by the model's own array at the point to which it belongs."""
    kept = data._tension_fields[0 if axis == 1 else -1]
    return kept if isinstance(kept, float) else kept[part.point]


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_energy_in_rational_numbers(seed):
    """What is stored less the load's work, of numbers as they are in memory, lies within its bracket."""
    rng = np.random.default_rng(seed)
    lattice = random_region(rng)
    assume(lattice is not None)
    tension = tuple(float(part) for part in 10.0 ** rng.uniform(-3, 3, 2))
    load = 10.0 ** rng.uniform(-3, 3) * rng.normal(size=lattice.shape)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        data = Data.of(cq.Membrane(lattice, tension, load=load, support=np.inf))
    plan = data.plan
    heights = points_of(data, 10.0 ** rng.uniform(-3, 3) * rng.normal(size=plan.nodes.shape))
    square = Fraction(lattice.spacing) ** 2
    t_x, t_y = map(Fraction, tension)
    stored = work = Fraction(0)
    for row, column in np.argwhere(plan.squares):
        corners = [k for k in range(4) if plan.having(k)[row, column]]
        places = [(row + CORNERS[k][0], column + CORNERS[k][1]) for k in corners]
        v, p = ([Fraction(float(each[place])) for place in places] for each in (heights, data.load.values))
        near = {k: i for i, k in enumerate(corners)}
        if len(corners) == 3:
            node = next(k for k in corners if (k + 2) % 4 not in corners)
            along_x = v[near[CORNERS.index((CORNERS[node][0], 1 - CORNERS[node][1]))]] - v[near[node]]
            along_y = v[near[CORNERS.index((1 - CORNERS[node][0], CORNERS[node][1]))]] - v[near[node]]
            stored += (t_x * along_x**2 + t_y * along_y**2) / 4
            work += square * sum((1 + (i == j)) * p[i] * v[j] for i in range(3) for j in range(3)) / 24
            continue
        for tense, (one, two) in ((t_x, ((0, 1), (3, 2))), (t_y, ((0, 3), (1, 2)))):
            a, b = (v[near[end]] - v[near[start]] for start, end in (one, two))
            stored += tense * (a * a + a * b + b * b) / 6
        weights = {0: 4, 1: 2, 2: 1, 3: 2}
        work += square * sum(weights[(i - j) % 4] * p[i] * v[j] for i in range(4) for j in range(4)) / 36
    bracket = energies._energy(data, heights, stretch_of(data, heights), 0.0)
    assert Fraction(bracket.lower) <= stored - work <= Fraction(bracket.upper)
    assert Fraction(stretch_of(data, heights).norm) ** 2 >= 2 * stored


# Random membranes.


def random_membrane(rng, lattice):
    """Return a membrane whose support leaves room for its frame, of any data that energies know."""
    x, y = lattice.origin[0] + lattice.spacing, lattice.origin[1] + lattice.spacing
    width = lattice.spacing * max(lattice.shape)
    deep = float(10.0 ** rng.uniform(-1, 1))
    sign = float(rng.choice([-1.0, 1.0]))

    def wavy(mean, part):
        a, b, phase = rng.uniform(-2, 2, 3)
        a, b = a / width, b / width
        return cq.Smooth(
            lambda x, y: mean + part * np.sin(a * x + b * y + phase), second_derivative=abs(part) * (a * a + b * b)
        )

    def sometimes(*choices):
        return choices[rng.integers(len(choices))]

    push = deep / width**2 * rng.uniform(5, 60)
    data = {
        "tension": sometimes(1.0, (1.0, 0.4), wavy(1.0, 0.4), (wavy(1.0, 0.3), 1.5)),
        "load": sometimes(push, sign * push, wavy(push, 2 * push), push * rng.uniform(-1, 2, lattice.shape)),
        "foundation": sometimes(None, None, 3.0 / width**2, wavy(2.0 / width**2, 1.0 / width**2)),
        "frame_height": sometimes(0.0, 0.0, wavy(0.0, 0.2 * deep), Plane(0.05 * deep, 0.05 * deep / width)),
        "support": sometimes(
            deep,
            np.inf,
            wavy(deep, 0.3 * deep),
            Paraboloid(0.7 * deep, sign * width**2 / (0.2 * deep), (x, y)),
            Uppermost(Plane(deep, 0.1 * deep / width), Plane(0.8 * deep, 0.0, -0.2 * deep / width)),
            HillAndFloor(),
            deep * rng.uniform(0.7, 1.3, lattice.shape),
        ),
        "ceiling": sometimes(None, None, -0.7 * deep, wavy(-deep, 0.2 * deep)),
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        return cq.Membrane(lattice, **data)


@settings(max_examples=12)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_unions_do_not_contradict_their_finer_lattices(seed):
    rng = np.random.default_rng(seed)
    lattice = random_region(rng, most=7)
    assume(lattice is not None)
    models = [random_membrane(rng, lattice)]
    try:
        for _ in range(2):
            models.append(finer(models[-1]))
        solutions = [solved(model, tol=1e-9) for model in models]
        found = [solution.continuum() for solution in solutions]
    except ValueError as refused:
        if "leave room for the frame" not in str(refused):
            raise
        assume(False)  # a support of random heights, or a hill of its own
    for k, wide in enumerate(found):
        for narrow in found[k + 1 :]:
            assert meet(wide.energy, narrow.energy)
    for k in (0, 1):
        if np.isfinite(found[k].energy_error) and np.isfinite(found[2].energy_error):
            apart = distance(solutions[k], solutions[2], 2 - k)
            assert apart * (1 - 1e-9) <= found[k].energy_error + found[2].energy_error


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_any_heights_at_the_nodes_give_bounds(seed):
    """Nothing is assumed of how an answer was found: wrong ones give wide bounds that hold."""
    rng = np.random.default_rng(seed)
    data = {"support": 0.9, "ceiling": [None, -0.3][rng.integers(2)], "foundation": [None, 0.003][rng.integers(2)]}
    model = membrane([HEXAGON, DIAMOND, INWARDS][rng.integers(3)], 4.0, **data)
    solution = solved(model)
    right = solution.continuum()
    wrong = solution.gap + 10.0 ** rng.uniform(-12, 0) * rng.normal(size=solution.gap.size)
    found = energy_bounds(Data.of(model), model.padded_below(wrong))
    assert meet(found.energy, right.energy)
    apart = stretch_of(Data.of(model), model.padded_below(wrong) - model.padded_below(solution.gap)).norm
    assert apart <= found.error + right.energy_error


# What touches the frame along diagonals.

BOWL = cq.Smooth(lambda x, y: 1 - 5e-4 * (x * x + y * y) + 2e-4 * x * y, second_derivative=1.3e-3)
TOUCHING = {
    "bowl": {"support": BOWL, "frame_height": BOWL, "load": 0.01},
    "hill": {"support": Paraboloid(0.5, 1000.0), "load": 0.01},
    "under a hill": {"support": 3.0, "ceiling": Paraboloid(0.5, -1000.0), "load": -0.01},
}


@pytest.mark.parametrize("corners", [HEXAGON, DIAMOND], ids=["hexagon", "diamond"])
@pytest.mark.parametrize("name", TOUCHING)
def test_supports_may_touch_a_bent_frame_all_along_diagonals(corners, name):
    """The frame is on the surface, which bends away from chords in some direction: it is held by no other one."""
    data = dict(TOUCHING[name])
    data.setdefault("frame_height", data["ceiling" if "ceiling" in data else "support"])
    found = [solved(membrane(corners, h, **data)).continuum() for h in (4.0, 2.0, 1.0, 0.5)]
    for k, wide in enumerate(found):
        assert wide.proven
        for narrow in found[k + 1 :]:
            assert meet(wide.energy, narrow.energy)
    assert half_width(found[3].energy) < 0.1 * half_width(found[1].energy)


def test_roofs_may_begin_at_diagonals():
    """The membrane under the steepest roof over a diamond; torsion of a bar that yields."""
    roof = Uppermost(*(Plane(32.0, a, b) for a in (1.0, -1.0) for b in (1.0, -1.0)))
    found = [solved(membrane(DIAMOND, h, support=roof, load=0.5)).continuum() for h in (4.0, 2.0, 1.0, 0.5)]
    assert all(meet(one.energy, two.energy) for one, two in pairwise(found))
    assert half_width(found[3].energy) < 2e-4 * abs(found[3].energy.upper)
    side = 32 * np.sqrt(2)
    flanks = [(side / 2, 1.0, 0.0), (side / 2, -1.0, 0.0), (side / 2, 0.0, 1.0), (side / 2, 0.0, -1.0)]
    straight = Uppermost(*(Plane(np.sqrt(2) * a, np.sqrt(2) * b, np.sqrt(2) * c) for a, b, c in flanks))
    lattice = cq.Frame.rectangle(side, side).lattice(side / 64)
    turned = solved(cq.Membrane(lattice, 1.0, load=0.5, support=straight)).continuum()
    assert meet(turned.energy, found[3].energy)


def dent(middle, least, most):
    return cq.Smooth(
        lambda x, y: middle + most * np.exp(-((x - least) ** 2 + (y - 32 + least) ** 2) / 4),
        second_derivative=abs(most) / 2,
    )


@pytest.mark.parametrize("h", [4.0, 2.0])
def test_what_lies_beyond_the_frame_between_its_points_is_refused(h):
    """On the side from (32, 0) to (0, 32), in the middle of a diagonal."""
    middle = 18.0 if h == 4.0 else 17.0
    with pytest.raises(ValueError, match=r"x=1[78], y=1[45] lies beyond the support, by 0\.1"):
        solved(membrane(DIAMOND, h, support=dent(0.5, middle, -0.6))).continuum()
    with pytest.raises(ValueError, match=r"x=1[78], y=1[45] lies beyond the ceiling, by 0\.1"):
        solved(membrane(DIAMOND, h, ceiling=dent(-0.5, middle, 0.6))).continuum()


def test_where_room_is_not_known_nothing_is_told():
    near = cq.Smooth(lambda x, y: 1e-9 + 0 * x, second_derivative=1.0)
    found = solved(membrane(DIAMOND, 4.0, support=near)).continuum()
    assert found.energy == (-np.inf, np.inf)
    assert found.energy_error == np.inf


# With the bounds at every point.


@pytest.mark.parametrize("corners", [HEXAGON, DIAMOND, PENTAGON], ids=["hexagon", "diamond", "pentagon"])
def test_pointwise_bounds_carry_energies(corners):
    solution = solved(membrane(corners, 4.0, support=Plane(1.5, 0.005, -0.003)))
    both, energy = solution.continuum("pointwise"), solution.continuum()
    assert both.energy == energy.energy
    assert (both.energy_error, both.contact_error) == (energy.energy_error, energy.contact_error)
    assert np.isfinite(both.energy_error)
    assert np.isfinite(both.error_bound)
    assert "potential energy" in str(both)
    assert "error at nodes" in str(both)
    assert float(both.to_dataset()["energy_error"]) == energy.energy_error


# Pieces of the bounds that answers hardly depend on.


def test_what_a_bent_frame_adds_on_halves():
    """Of a frame of one second derivative all is known, and nine tenths of what is told of it are true."""
    gamma, h = 2e-3, 4.0
    frame = cq.Smooth(lambda x, y: gamma / 4 * (x - y) * (x - y), second_derivative=gamma)
    data = Data.of(membrane(DIAMOND, h, frame_height=frame, support=np.inf, tension=3.0, foundation=0.1))
    falling = np.zeros_like(data.plan.halved)
    for halves in data.plan.halves:
        falling[halves.place] = halves.step == (-1, 1)
    assert 0 < falling.sum() == data.plan.halved.sum() / 2
    # From the node outwards, and along the diagonal from its middle, where the frame leaves it by e.
    length, far = h * np.sqrt(2), h / np.sqrt(2)
    r, s = (part.ravel() for part in np.meshgrid((np.arange(200) + 0.5) / 200, (np.arange(400) + 0.5) / 400 - 0.5))
    s = length * s
    e, slope = gamma / 2 * (length**2 / 4 - s * s), -gamma * s
    stretch = (far * r * (slope**2 + ((e - s * slope) / far) ** 2)).mean() * length
    springs = (far * r * (r * e) ** 2).mean() * length
    true, told = np.sqrt(3.0 * stretch + 0.1 * springs), rim_in_squares(data)[falling]
    assert (0.9 * told < true).all()
    assert (true <= told).all()
    np.testing.assert_allclose(leaves_of(data)[falling], e.max(), rtol=1e-4)
    assert (leaves_of(data)[falling] >= e.max()).all()
    assert (far * r * r * e).mean() * length <= BENT_MEAN * gamma * h**4 <= 1.001 * (far * r * r * e).mean() * length


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_what_load_leaves_in_triangles(seed):
    rng = np.random.default_rng(seed)
    lattice = random_region(rng)
    assume(lattice is not None)
    plan = Plan(lattice)
    force = rng.normal(size=plan.nodes.shape)
    exact = 0.0
    for part in Part.all_of(plan):
        if part.towards is not None:
            exact += lattice.spacing**2 * (part.weight * (part.value(force)[0] - force[part.point]) ** 2).sum()
    assert exact * (1 - 1e-12) <= unevenness_of_triangles(plan, force, np.zeros(plan.squares.shape)) <= exact * 1.000001


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_trial_functions_stay_between_surfaces_on_halves(seed):
    """On rays from a node v goes straight to the frame's height, whatever that is along the diagonal."""
    rng = np.random.default_rng(seed)
    lattice = random_region(rng, most=6)
    assume(lattice is not None)
    model = random_membrane(rng, lattice)
    data, plan = Data.of(model), Data.of(model).plan
    own = points_of(data, rng.normal(size=plan.nodes.shape) * 3 * np.abs(model.load).max() * 1e2)
    try:
        require_room(data)
        v = energies._admissible(data, own)
    except ValueError as refused:
        if "leave room for the frame" not in str(refused):
            raise
        assume(False)
    assume(v is not None)
    assert v is not None
    x, y = (np.broadcast_to(part, plan.nodes.shape) for part in plan.places)
    r, q = (part.ravel() for part in np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 21)))
    for halves in plan.halves:
        points = zip(halves.of(x), halves.of(y), halves.of(v), strict=True)
        (a_x, a_y, at_a), (b_x, b_y, at_b), (c_x, c_y, at_c) = (tuple(map(_column, point)) for point in points)
        end_x, end_y = b_x + q * (c_x - b_x), b_y + q * (c_y - b_y)
        frame = at_b + q * (at_c - at_b)
        if callable(model.given["frame_height"]):
            frame = np.asarray(model.given["frame_height"](end_x, end_y))
        depth = at_a + r * (frame - at_a)
        for surface, sign in data.surfaces:
            given = model.given["support" if sign > 0 else "ceiling"]
            at = [_column(part) for part in halves.of(surface.values)]
            with np.errstate(invalid="ignore"):
                level = at[0] + r * (1 - q) * (at[1] - at[0]) + r * q * (at[2] - at[0])
            if callable(given):
                level = sign * np.asarray(given(a_x + r * (end_x - a_x), a_y + r * (end_y - a_y)))
            level = np.where(np.isnan(level), np.inf, level)
            assert (sign * depth <= level + 1e-12 * (1 + np.abs(depth))).all()


def _column(values):
    return np.asarray(values)[:, None]


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_trial_functions_stay_between_surfaces_that_touch_the_frame(seed):
    """Nodes are pushed onto a surface on which the frame lies all along diagonals, however that bends."""
    rng = np.random.default_rng(seed)
    lattice = random_region(rng, most=6)
    assume(lattice is not None)
    surface, sign = Quadratic(rng.normal(), *rng.normal(size=3)), float(rng.choice([-1.0, 1.0]))
    data = {"support": surface} if sign > 0 else {"support": np.inf, "ceiling": surface}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        model = cq.Membrane(lattice, 1.0, load=1.0, frame_height=surface, **data)
    told = Data.of(model)
    plan = told.plan
    # Squares that belong to the frame as a whole tell nothing when it bends; the halves are looked at alone.
    found = np.full(plan.squares.shape, 0.0)
    for field, counted in told.surfaces:
        if counted == sign:
            fall_on_halves(told, field, sign, found)
    x, y = (np.broadcast_to(part, plan.nodes.shape) for part in plan.places)
    r, q = (part.ravel() for part in np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41)))
    for halves in plan.halves:
        (a_x, b_x, c_x), (a_y, b_y, c_y) = (map(_column, halves.of(each)) for each in (x, y))
        end_x, end_y = b_x + q * (c_x - b_x), b_y + q * (c_y - b_y)
        lowered = surface(a_x, a_y) - sign * _column(found[halves.place])
        v = lowered + r * (surface(end_x, end_y) - lowered)
        off = sign * (surface(a_x + r * (end_x - a_x), a_y + r * (end_y - a_y)) - v)
        assert (off >= -1e-12 * (1 + np.abs(v))).all()
        # It is no more than what the surface bends by along an edge, or the twist of it between both.
        a, b, d = (sign * part for part in surface.parts)
        b *= halves.outwards[0] * halves.outwards[1]
        assert found[halves.place] == pytest.approx(lattice.spacing**2 * max(a, b / 2, d, 0.0), abs=1e-9)


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_products_leave_their_interpolants_on_halves_by_no_more_than_is_told(seed):
    rng = np.random.default_rng(seed)
    lattice = random_region(rng)
    assume(lattice is not None)
    plan = Plan(lattice)
    one, two = rng.normal(size=(2, *plan.nodes.shape))
    told = np.zeros(plan.squares.shape)
    apart_on_halves(plan, one, two, told)
    weights = rng.dirichlet(np.full(3, 0.7), 500)
    for halves in plan.halves:
        own, other = (np.stack(halves.of(each)) for each in (one, two))
        off = np.abs((weights @ own) * (weights @ other) - weights @ (own * other))
        assert (off <= told[halves.place] * (1 + 1e-12)).all()
