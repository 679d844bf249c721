"""Sums in brackets: against exact rational arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from contactqp.foundation.brackets import Bracket, sum_within


@given(st.lists(st.floats(-1e100, 1e100), max_size=60), st.integers(0, 2**32 - 1))
def test_a_sum_lies_within(numbers: list[float], seed: int) -> None:
    drawn = np.random.default_rng(seed)
    array = np.concatenate([numbers, drawn.normal(size=200) * 10.0 ** drawn.integers(-20, 20, size=200)])
    found = sum_within(array)
    exact = sum(map(Fraction, array.tolist()))
    assert Fraction(found.lower) <= exact <= Fraction(found.upper)


def test_it_is_near_and_takes_the_smallest_numbers() -> None:
    assert sum_within(np.zeros(0)).lower <= 0.0 <= sum_within(np.zeros(0)).upper
    tiny = sum_within(np.full(7, 5e-324))
    assert tiny.lower <= 35e-324 <= tiny.upper
    tenths = sum_within(np.full((300, 300), 0.1))
    assert tenths.upper - tenths.lower < 1e-6


def test_what_overflows_bounds_nothing() -> None:
    endless = Bracket(-math.inf, math.inf)
    assert sum_within(np.array([1e308, 1e308])) == endless == sum_within(np.array([np.inf, -np.inf]))
