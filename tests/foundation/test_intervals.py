"""Intervals hold what exact arithmetic says."""

import operator
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactqp.foundation.intervals import Interval

numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)


def holds(interval, exact):
    """Python compares a double with a fraction exactly, an infinite one as well."""
    return float(interval.lower) <= exact <= float(interval.upper)


@given(a=numbers, b=numbers, room=st.floats(0, 10), operation=st.sampled_from("+-*/"))
def test_what_is_computed_of_ends_holds_what_is_computed_of_numbers_between(a, b, room, operation):
    act = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}[operation]
    first, second = Interval.between(a - room, a + room), Interval.between(b - room / 2, b + room / 2)
    found = act(first, second)
    for x in (first.lower, a, first.upper):
        for y in (second.lower, b, second.upper):
            if operation != "/" or y != 0:
                assert holds(found, act(Fraction(float(x)), Fraction(float(y))))


@given(a=numbers, room=st.floats(0, 10))
def test_squares_roots_and_moduli(a, room):
    interval = Interval.between(a - room, a + room)
    for x in (interval.lower, a, interval.upper):
        exact = Fraction(float(x))
        assert holds(interval.square(), exact**2)
        assert holds(interval.absolute(), abs(exact))
        root = interval.absolute().sqrt()
        assert Fraction(float(root.lower)) ** 2 <= abs(exact) <= Fraction(float(root.upper)) ** 2


def test_a_divisor_that_may_be_zero_leaves_nothing_known():
    found = Interval.of(1.0) / Interval.between(-1.0, 1.0)
    assert (found.lower, found.upper) == (-np.inf, np.inf)


def test_zero_times_what_has_no_bound_is_zero():
    """An infinite end stands for numbers without a bound, of which none is infinite."""
    found = Interval.of(0.0) * Interval.between(0.0, np.inf)
    assert found.lower == pytest.approx(0.0, abs=1e-300)
    assert found.upper == pytest.approx(0.0, abs=1e-300)


def test_arrays_of_intervals_are_chosen_and_joined():
    first, second = Interval.between([0.0, 1.0], [2.0, 3.0]), Interval.between([-1.0, 2.0], [1.0, 5.0])
    assert first.minimum(second).lower.tolist() == [-1.0, 1.0]
    assert first.maximum(second).upper.tolist() == [2.0, 5.0]
    assert first.hull(second).upper.tolist() == [2.0, 5.0]
    assert first.where(np.array([True, False]), second).lower.tolist() == [0.0, 2.0]
    assert (1.0 / Interval.of([2.0]) - 1).upper[0] >= -0.5
