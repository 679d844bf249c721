"""A sample of the random rectangles of ``benchmarks/continuum.py``: no two enclosures contradict each other."""

import pytest
from random_rectangles import contradictions, enclosed, random_rectangle, refined

from contactqp.models.varied import with_load

FEW, MORE = range(6), range(6, 50)


@pytest.mark.filterwarnings("ignore:load nowhere presses")  # one that lifts the membrane off is drawn as well
@pytest.mark.parametrize("seed", [*FEW, *(pytest.param(seed, marks=pytest.mark.slow) for seed in MORE)])
def test_bounds_on_two_lattices_hold_one_membrane(seed):
    membrane = random_rectangle(seed)
    assert contradictions(enclosed(membrane), enclosed(refined(membrane))) == []


@pytest.mark.parametrize("seed", [8, 13, 25])
def test_enclosures_of_membranes_that_differ_contradict_each_other(seed):
    """What holds two against each other is able to tell: of the same under three times the load."""
    membrane = random_rectangle(seed)
    told = contradictions(enclosed(membrane), enclosed(refined(with_load(membrane, 3.0))))
    assert {"deflection", "gap", "potential energy"} <= set(told)
