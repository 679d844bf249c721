"""Numbers and values as short text."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

import contactqp as cq
from contactqp.foundation.brackets import Bracket
from contactqp.foundation.text import at_most, folded, known_number, rounded_outwards

NUMBERS = st.floats(-1e300, 1e300)


@given(NUMBERS, NUMBERS)
def test_brackets_are_told_by_few_digits_that_enclose_them(one, other):
    lower, upper = sorted([one, other])
    low, high = rounded_outwards(lower, upper)
    assert low <= lower
    assert high >= upper
    assert Fraction(lower) - Fraction(low) <= abs(Fraction(lower)) / 10**11


def test_a_bracket_shows_no_digits_of_rounding():
    assert repr(Bracket(1.0100000000000002, 1.0100000000000007)) == "Bracket(lower=1.01, upper=1.01000000001)"
    assert repr(Bracket(-math.inf, 0.0)) == "Bracket(lower=-inf, upper=0.0)"


def test_bounds_at_the_end_of_doubles_are_told_by_a_round_number_that_is_true():
    assert at_most(5e-324) == "1e-300"
    assert at_most(0.0) == "0"


def test_long_lines_go_on_below_what_they_tell():
    text = folded("problem   a " + "long " * 30 + "\nnote      short", 40, 10)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 40
    assert all(line.startswith(" " * 10) for line in lines[1:-1])
    assert " ".join(text.split()) == "problem a " + "long " * 30 + "note short"


def test_the_least_of_nothing_is_no_number():
    assert known_number(math.inf) == "-"
    assert known_number(None) == "-"
    assert known_number(0.25) == "0.25"


def test_misspelt_arguments_are_told_what_was_meant():
    lattice = cq.Frame.rectangle(4, 4).lattice(1.0)
    for name, meant in (("upward", "upwards"), ("tensions", "tension")):
        given = {"load": 1.0, "support": 1.0, name: True}
        with pytest.raises(TypeError, match=f"Membrane has no argument '{name}'; did you mean '{meant}'"):
            cq.Membrane(lattice, **given)
        with pytest.raises(TypeError, match=f"Cable has no argument '{name}'; did you mean '{meant}'"):
            cq.Cable(10, spacing=1.0, **given)
    misspelt = {"upward": True}
    with pytest.raises(TypeError, match="CableNet has no argument 'upward'; did you mean 'upwards'"):
        cq.CableNet([[0, 0], [1, 0]], [[0, 1]], tension=1.0, load=1.0, support=1.0, fixed=[0], **misspelt)
    with pytest.raises(TypeError, match="has no option 'maxiter'; did you mean 'max_iter'"):
        cq.solve(cq.gallery.islands(), "active-set", maxiter=3)
