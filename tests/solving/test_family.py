"""Data between two others: two answers enclose those of all."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq

LATTICE = cq.Frame.rectangle(1, 1, center=(0.5, 0.5)).lattice(1 / 8)


@settings(max_examples=12)
@given(seed=st.integers(0, 2**32 - 1))
def test_members_lie_within_and_contact_is_common(seed):
    """Members may take any value between at any node."""
    rng = np.random.default_rng(seed)
    size, upwards = LATTICE.size, bool(rng.integers(2))
    sign = -1.0 if upwards else 1.0

    def known(values, wide):
        ends = values - wide, values + wide
        return cq.between(*ends), ends

    data, ends = {}, {}
    data["load"], ends["load"] = known(rng.uniform(-0.5, 2.0, size), rng.uniform(0, 0.1))
    data["support"], ends["support"] = known(sign * rng.uniform(0.02, 0.06, size), rng.uniform(0, 0.003))
    if rng.integers(2):
        data["ceiling"], ends["ceiling"] = known(-sign * rng.uniform(0.005, 0.02, size), 0.002)
    data["frame_height"] = cq.between(-0.002, 0.001)
    uncertain_tension = rng.integers(2)
    data["tension"] = cq.between(0.9, 1.2) if uncertain_tension else 1.0
    family = cq.solve_between(cq.Membrane(LATTICE, **data, upwards=upwards), tol=1e-9)
    low, high = family.deflection
    assert (low <= high).all()
    for _ in range(3):
        member = {name: rng.uniform(*pair) for name, pair in ends.items()}
        tension = rng.uniform(0.9, 1.2) if uncertain_tension else 1.0
        frame = rng.uniform(-0.002, 0.001)
        model = cq.Membrane(LATTICE, tension, frame_height=frame, upwards=upwards, **member)
        one = cq.solve(model, tol=1e-11, on_failure="ignore")
        bound = one.certificate.gap_bound
        assert (low - bound <= one.deflection).all()
        assert (one.deflection <= high + bound).all()
        assert not one.certificate.clear[family.contact].any()
        assert not (one.certificate.contact & ~one.certificate.contact_upper)[family.clear].any()


def test_without_anything_between_two_bounds_are_those_of_one_answer():
    family = cq.solve_between(cq.Membrane(LATTICE, 1.0, load=cq.between(1.0, 1.0), support=0.03), tol=1e-10)
    assert family.spread < 1e-11
    alone = cq.solve(cq.Membrane(LATTICE, 1.0, load=1.0, support=0.03), tol=1e-10)
    assert np.array_equal(family.contact, alone.certificate.contact)
    assert family.contact_area.lower == pytest.approx(alone.contact_area.lower)


def test_cables_and_functions_of_x():
    cable = cq.Cable(
        10.0,
        spacing=0.5,
        tension=cq.between(0.95, 1.05),
        load=cq.between(lambda x: 0.9 + 0 * x, lambda x: 1.1 + 0 * x),
        support=cq.between(2.0, 2.1),
    )
    family = cq.solve_between(cable)
    one = cq.solve(cq.Cable(10.0, spacing=0.5, tension=1.02, load=1.0, support=2.05))
    assert (family.deflection[0] <= one.deflection).all()
    assert (one.deflection <= family.deflection[1]).all()
    assert "Family of cables: load, support, tension between two" in str(family)


def test_models_stand_for_the_middle():
    profile = cq.between(cq.profiles.Plane(1.0), cq.profiles.Plane(2.0))
    model = cq.Membrane(LATTICE, tension=cq.between(1.0, 3.0), load=cq.between(np.ones(49), 2.0), support=profile)
    assert model.tension == 2.0
    assert model.load == pytest.approx(1.5)
    assert model.support == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: cq.Membrane(LATTICE, 1.0, load=1.0, support=0.03), "nothing of"),
        (
            lambda: cq.Membrane(LATTICE, 1.0, load=1.0, support=0.03, foundation=cq.between(0.0, 1.0)),
            "answers do not grow with its stiffness",
        ),
        (
            lambda: cq.Membrane(LATTICE, cq.between(1, 2), load=1.0, support=0.03, foundation=1.0),
            "uncertain tension beside it",
        ),
        (
            lambda: cq.Beam(4.0, spacing=0.5, bending_stiffness=1.0, load=cq.between(1, 2), support=1.0),
            "no M-matrix",
        ),
        (
            lambda: cq.Membrane(LATTICE, 1.0, load=cq.between(np.ones(49), lambda x, y: x), support=0.03),
            "the lower one is above the upper one at node 0",
        ),
        (lambda: cq.between(2.0, 1.0), "lower <= upper"),
    ],
)
def test_what_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        cq.solve_between(make())


def test_what_is_on_no_lattice_is_refused():
    with pytest.raises(TypeError, match="a Membrane or a Cable"):
        cq.solve_between(cq.ContactQP([[2.0]], [1.0]))
