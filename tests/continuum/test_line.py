"""Bounds of cables themselves, held against closed forms and finer spacings."""

import warnings
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq
from contactqp.continuum.line import Line, cable_heights
from contactqp.continuum.line_energy import _norm, cable_energy

HILL = cq.profiles.Paraboloid(0.03, 1.0, (0.5, 0.0))


def cable_of(cells, **data):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", cq.ContactWarning)
        return cq.Cable(1.0, spacing=1 / cells, **{"tension": 1.0, "load": 1.0, "support": 0.045, **data})


def found(cells, tol=1e-10, **data):
    return cq.solve(cable_of(cells, **data), tol=tol).continuum()


CASES = {
    "floor": {},
    "hill": {"support": HILL},
    "bowl": {"support": cq.profiles.Paraboloid(0.1, -2.0, (0.5, 0.0))},
    "load": {"load": cq.Smooth(lambda x: 1 + x * x, second_derivative=2.0)},
    "ceiling": {"ceiling": -0.03, "load": cq.Smooth(lambda x: 2 * np.cos(6 * x), second_derivative=72.0)},
    "springs": {"foundation": 3.0},
    "springs that vary": {"foundation": cq.Smooth(lambda x: 3 * x, second_derivative=0.0)},
    "tension": {"tension": cq.Smooth(lambda x: 1 + x, lipschitz=1.0, second_derivative=0.0)},
    "ends": {"frame_height": 0.01, "upwards": True, "support": -0.03},
    "steps": {"tension": np.repeat([1.0, 2.0], [15, 16])},
}


@pytest.mark.parametrize("name", [name for name in CASES if name != "steps"])
def test_energies_of_all_spacings_meet_and_shrink_at_second_order(name):
    results = [found(cells, **CASES[name]) for cells in (32, 64, 128)]
    assert all(one.proven for one in results)
    widths = [one.energy.upper - one.energy.lower for one in results]
    for one, two in pairwise(results):
        assert one.energy.lower <= two.energy.upper
        assert two.energy.lower <= one.energy.upper
    assert widths[0] / widths[2] > 2 ** (2 * 1.8)
    assert results[0].energy_error / results[2].energy_error > 2 ** (2 * 0.9)


def test_tension_by_nodes_is_constant_about_them():
    assert found(32, **CASES["steps"]).proven


def test_the_energy_over_a_floor_is_that_of_the_formula():
    """w = ax - x²/2 up to a = 0.3, where it touches f = a²/2."""
    a = 0.3
    exact = 2 * (a**3 / 6 - (a**3 / 2 - a**3 / 6)) - 0.045 * 0.4
    for cells in (20, 47, 80):
        energy = found(cells).energy
        assert energy.lower <= exact <= energy.upper


@pytest.mark.parametrize("name", ["cable-on-floor", "cable-on-hill", "cable-in-bowl"])
@pytest.mark.parametrize("nodes", [39, 50])
def test_heights_hold_the_closed_form(name, nodes):
    known = cq.gallery.load(name, n=nodes if name == "cable-on-floor" else 39)
    solution = cq.solve(known.model, tol=1e-10)
    bounds = cable_heights(Line(known.model), known.model.padded_below(solution.gap)[1, 1:-1])
    assert bounds is not None
    lower, upper = bounds
    h = known.spacing
    if name == "cable-on-floor":  # the others' ground is a function, of which nothing is known between the nodes
        assert (lower <= known.deflection).all()
    assert (known.deflection <= upper).all()
    assert (upper - lower).max() < 0.2501 * h**2


@settings(max_examples=12)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_cables_lie_where_finer_ones_do(seed):
    """Heights and energies of several spacings meet, of answers that are wrong by any amount as well."""
    rng = np.random.default_rng(seed)
    wave, size = rng.uniform(0, 8), rng.uniform(0, 2)
    data = {
        "load": cq.Smooth(lambda x: 1 + size * np.sin(wave * x), second_derivative=float(size * wave**2)),
        "support": [
            0.03,
            HILL,
            cq.profiles.Uppermost(cq.profiles.Plane(0.05), cq.profiles.Cone(0.02, 0.3, (0.4, 0.0))),
            cq.profiles.Hemisphere(0.01, 0.2, (0.53, 0.0)),
        ][rng.integers(4)],
        "frame_height": 0.004,
        "upwards": False,
    }
    bounds = []
    for cells in (16, 64):
        cable = cable_of(cells, **data)
        gap = cq.solve(cable, tol=1e-10).gap + 10.0 ** rng.uniform(-14, -2) * rng.normal(size=cable.size)
        below = cable.padded_below(gap)[1, 1:-1]
        heights = cable_heights(Line(cable), below)
        assert heights is not None
        bounds.append((*heights, cable_energy(Line(cable), below).energy))
    (low, high, energy), (finer_low, finer_high, finer_energy) = bounds
    assert (low <= finer_high[3::4]).all()
    assert (finer_low[3::4] <= high).all()
    assert energy.lower <= finer_energy.upper
    assert finer_energy.lower <= energy.upper


def test_what_is_told_of_a_cable():
    result = found(40)
    assert result.lower is not None
    assert "error at nodes" in str(result)
    assert result.error_bound < 0.126 / 40**2
    turned = found(40, **CASES["ends"])
    assert turned.lower is not None
    assert (turned.lower <= turned.upper).all()
    assert found(32, **CASES["springs"]).at_nodes is None


def test_what_is_refused_and_what_is_sampled():
    with pytest.raises(ValueError, match="the end at x=0 lies beyond the support"):
        found(8, support=-0.1)
    assert found(8, support=lambda x: 0.05 + 0 * x).sampled == ("support",)
    assert found(8, support=np.full(7, -0.1)).energy.lower > -np.inf


@pytest.mark.parametrize(("name", "bends"), [("cable-on-floor", 0.6), ("cable-on-hill", 1.0), ("cable-in-bowl", 0.7)])
def test_the_norm_of_cables_is_bounded_within_three_tenths(name, bends):
    """The answer is exact at the nodes, so that the error is that of interpolation: h²/12 ∫w″², with w″ = -1 or f″."""
    known = cq.gallery.load(name, n=39)
    true = known.spacing * np.sqrt(bends / 12)
    assert true < cq.solve(known.model, tol=1e-12).continuum().energy_error < 1.3 * true


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_cables_over_curved_ground_are_where_their_finer_lattices_are(seed):
    rng = np.random.default_rng(seed)
    deep, middle = rng.uniform(0.005, 0.1), float(rng.uniform(0.2, 0.8))
    ground: Any = [
        cq.profiles.Paraboloid(deep, float(rng.choice([-1, 1]) * rng.uniform(1.2, 5)), (middle, 0.0)),
        cq.Smooth(lambda x, y: deep * (2 + np.sin(9 * x)), second_derivative=81 * deep),
        cq.profiles.Hemisphere(deep, 0.4, (middle, 0.0)),
    ][rng.integers(3)]
    ends = min(0.0, float(ground(0.0, 0.0)), float(ground(1.0, 0.0)))
    data = {"support": ground, "foundation": [None, 2.0][rng.integers(2)], "frame_height": ends}
    if rng.integers(2):
        data["ceiling"] = ends - 0.02
    cables = [cable_of(cells, **data) for cells in (12, 48)]
    solutions = [cq.solve(cable, tol=1e-10) for cable in cables]
    coarse, fine = (solution.continuum() for solution in solutions)
    assert coarse.energy.lower <= fine.energy.upper
    assert fine.energy.lower <= coarse.energy.upper
    lines = [Line(cable) for cable in cables]
    heights = [
        np.concatenate([line.ends[:1], cable.padded_below(solution.gap)[1, 1:-1], line.ends[1:]])
        for line, cable, solution in zip(lines, cables, solutions, strict=True)
    ]
    apart = _norm(lines[1], np.interp(lines[1].x, lines[0].x, heights[0]) - heights[1])
    assert apart <= coarse.energy_error + fine.energy_error
