"""Data that leave no membrane, between the points of a lattice: room for the frame, signs of foundations, units."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.continuum.data import Data
from contactqp.continuum.frame_room import require_room
from contactqp.profiles import Hemisphere, Paraboloid, Plane, Uppermost

UNIT = cq.Frame.rectangle(1, 1, center=(0.5, 0.5))
SPACING = 1 / 8


def wave(most, spacing=SPACING):
    """Return a function that is 0 at the points of a lattice, and ``most`` halfway between them, along x."""
    bend = abs(most) * 2 * (np.pi / spacing) ** 2
    return cq.Smooth(lambda x, y: most * np.sin(np.pi * x / spacing) ** 2 + 0 * y, second_derivative=bend)


def plus(number, function):
    return cq.Smooth(lambda x, y: number + function(x, y), second_derivative=function.second_derivative)


def solved(**data):
    model = cq.Membrane(UNIT.lattice(SPACING), **({"tension": 1.0, "load": 1.0, "support": 0.03} | data))
    return cq.solve(model, tol=1e-9)


ABOVE = {
    "support": {"support": plus(0.01, wave(-0.02))},
    "frame": {"frame_height": plus(0.0, wave(0.05))},
    "both": {"support": plus(0.02, wave(-0.02)), "frame_height": plus(0.01, wave(0.02))},
    "ceiling": {"ceiling": plus(-0.01, wave(0.02))},
    "heights": {"support": plus(-0.01, wave(0.02)), "upwards": True, "load": 1.0},
}


@pytest.mark.parametrize("name", ABOVE)
@pytest.mark.parametrize("effort", ["energy", "pointwise"])
def test_a_surface_beyond_the_frame_between_points_is_refused_by_either_effort(name, effort):
    solution = solved(**ABOVE[name])
    with pytest.raises(ValueError, match=r"beyond the (support|ceiling), by 0.0[0-9]*: no membrane can be held there"):
        solution.continuum(effort)


@pytest.mark.parametrize("effort", ["energy", "pointwise"])
def test_what_may_lie_beyond_the_frame_is_refused(effort):
    """It touches the frame at its points, and its declared constant leaves open what it does between them."""
    flat = cq.Smooth(lambda x, y: 0.03 * np.sin(np.pi * x) * np.sin(np.pi * y), second_derivative=0.6)
    with pytest.raises(ValueError, match="support is not known to leave room for the frame near"):
        solved(support=flat, load=0.1).continuum(effort)


@pytest.mark.parametrize(
    "data",
    [
        {"support": plus(0.03, wave(-0.02))},
        {"support": plus(0.0301, wave(-0.03))},
        {"support": plus(0.03, wave(-0.02)), "frame_height": plus(0.0, wave(-0.02))},
        {"support": Paraboloid(0.3, -5.0 / 6, (0.5, 0.5))},
        {"support": Uppermost(Plane(0.0, 1.0), Plane(1.0, -1.0), Plane(0.0, 0.0, 1.0), Plane(1.0, 0.0, -1.0))},
        {"support": Hemisphere(0.02, 0.3, (0.5, 0.5))},
        {"support": 0.03, "frame_height": plus(0.0, wave(0.0299))},
        {"support": (hill := plus(0.02, wave(0.01))), "frame_height": hill},
    ],
)
def test_what_leaves_room_is_accepted(data):
    model = cq.Membrane(UNIT.lattice(SPACING), **({"tension": 1.0, "load": 1.0, "support": 0.03} | data))
    require_room(Data.of(model))


@pytest.mark.parametrize("depth", np.linspace(0.001, 0.04, 7))
@pytest.mark.parametrize("dip", [0.0, 0.01, 0.02])
def test_room_is_told_as_finer_points_have_it(depth, dip):
    """Halved often enough, every case is decided but those that all but touch."""
    support, frame = plus(depth, wave(-dip)), plus(0.0, wave(dip / 2, SPACING / 2))
    model = cq.Membrane(UNIT.lattice(SPACING), 1.0, load=1.0, support=support, frame_height=frame)
    along = np.linspace(0, 1, 4097)
    least = min(float((support(x, y) - frame(x, y)).min()) for x, y in ((along, 0 * along), (0 * along, along)))
    if least < 0:
        with pytest.raises(ValueError, match="beyond the support"):
            require_room(Data.of(model))
    else:
        require_room(Data.of(model))


def test_a_foundation_that_is_negative_between_points_is_refused():
    pulls = plus(1.0, wave(-1.5))
    with pytest.raises(ValueError, match=r"foundation is -0.5 at x=0.[0-9]*, y=[0-9.]*, between the points"):
        solved(foundation=pulls).continuum()
    cable = cq.Cable(1.0, spacing=SPACING, tension=1.0, load=1.0, support=0.03, foundation=pulls)
    with pytest.raises(ValueError, match=r"foundation is -0.5 at x=0.[0-9]*, y=0, between the points"):
        cq.solve(cable).continuum()


def test_a_foundation_that_comes_down_to_zero_is_accepted():
    found = solved(foundation=plus(1.0, wave(-1.0))).continuum()
    assert found.proven
    assert np.isfinite(found.energy_error)


def membrane_of(length, height, tension):
    lattice = cq.Frame.rectangle(length, length).lattice(length / 8)
    return cq.Membrane(lattice, tension, load=tension * (height / length) / length, support=0.03 * height)


def cable_of(length, height, tension):
    load = tension * (height / length) / length
    return cq.Cable(length, spacing=length / 8, tension=tension, load=load, support=0.03 * height)


@pytest.mark.parametrize("make", [membrane_of, cable_of])
@pytest.mark.parametrize("length", [1e-150, 1e-60, 1.0, 1e60, 1e150])
@pytest.mark.parametrize("height", [1e-100, 1.0, 1e100, 1e150])
@pytest.mark.parametrize("tension", [1e-60, 1.0, 1e60, 1e150])
def test_extreme_units_give_right_figures_or_words(make, length, height, tension):
    """The unit of the energy is T height², for a cable T height²/length; what is no double is refused in words."""
    try:
        found = cq.solve(make(length, height, tension), tol=1e-9).continuum()
    except ValueError as refused:
        # Either outcome is right, of the lattice's problem as well.
        assert any(word in str(refused) for word in ("unit", "overflow", "range", "double", "finite"))  # noqa: PT017
        return
    usual = cq.solve(make(1.0, 1.0, 1.0), tol=1e-9).continuum().energy
    unit = tension * height * (height / length if make is cable_of else height)
    assert found.energy.lower <= usual.upper * unit + 1e-290
    assert usual.lower * unit - 1e-290 <= found.energy.upper
