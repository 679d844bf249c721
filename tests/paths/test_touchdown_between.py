"""Loads at which nodes settle, of all models whose data lie between two others."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import contactqp as cq

LATTICE = cq.Frame.rectangle(1, 1).lattice(1 / 8)
FACTORS = np.linspace(0.2, 2.0, 7)


@settings(max_examples=6)
@given(seed=st.integers(0, 2**32 - 1))
def test_members_settle_within(seed):
    rng = np.random.default_rng(seed)
    size, upwards = LATTICE.size, bool(rng.integers(2))
    sign = -1.0 if upwards else 1.0
    load = rng.uniform(0.5, 1.5, size)
    support = sign * rng.uniform(0.02, 0.05, size)
    wide = rng.uniform(0, 0.1), rng.uniform(0, 0.003)
    family = cq.Membrane(
        LATTICE,
        tension=1.0,
        load=cq.between(load - wide[0], load + wide[0]),
        support=cq.between(support - wide[1], support + wide[1]),
        upwards=upwards,
    )
    found = cq.touchdown_between(family, FACTORS, tol=1e-10)
    assert (found.clear < found.contact).all()
    loads = load + wide[0] * rng.uniform(-1, 1, size)
    supports = support + wide[1] * rng.uniform(-1, 1, size)
    for factor in FACTORS:
        member = cq.Membrane(LATTICE, 1.0, load=factor * loads, support=supports, upwards=upwards)
        answer = cq.solve(member, tol=1e-11, on_failure="ignore")
        assert not answer.certificate.contact[factor <= found.clear].any()
        assert not answer.certificate.clear[factor >= found.contact].any()


def test_without_anything_between_two_brackets_are_those_of_the_path():
    alone = cq.Membrane(LATTICE, 1.0, load=1.0, support=0.03)
    family = cq.Membrane(LATTICE, 1.0, load=cq.between(1.0, 1.0), support=0.03)
    found, known = cq.touchdown_between(family, FACTORS), cq.trace(alone, loads=FACTORS).touchdown()
    assert (found.clear <= known.contact).all()
    assert (known.clear <= found.contact).all()
    assert np.count_nonzero(np.isfinite(found.load)) == np.count_nonzero(np.isfinite(known.load)) > 20


def test_wider_data_have_wider_brackets():
    narrow, wide = (
        cq.touchdown_between(cq.Membrane(LATTICE, 1.0, load=cq.between(1 - part, 1 + part), support=0.03), FACTORS)
        for part in (0.01, 0.3)
    )
    assert (wide.clear <= narrow.clear).all()
    assert (wide.contact >= narrow.contact).all()
    assert (wide.contact > narrow.contact).any()


@pytest.mark.parametrize(
    ("load", "loads", "words"),
    [
        (cq.between(lambda x, y: x, 2.0), [1.0], "may press upwards"),
        (cq.between(0.9, 1.0), [], "factors > 0"),
        (cq.between(0.9, 1.0), [0.0, 1.0], "factors > 0"),
        (1.0, [1.0], "nothing of"),
    ],
)
def test_what_is_refused(load, loads, words):
    with pytest.raises(ValueError, match=words):
        cq.touchdown_between(cq.Membrane(LATTICE, 1.0, load=load, support=0.03), loads)
