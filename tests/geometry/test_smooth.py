"""Functions with declared constants."""

import numpy as np
import pytest

import contactqp as cq
from contactqp.foundation.intervals import Interval

SIDES = (
    Interval.between([[0.1, 0.4]], [[0.4, 0.9]]),
    Interval.between(
        [[-0.3], [0.0]],
        [
            [
                0.0,
            ],
            [0.2],
        ],
    ),
)


@pytest.mark.parametrize(
    "constants", [{"lipschitz": 1.5}, {"second_derivative": 2.5}, {"lipschitz": 1.5, "second_derivative": 2.5}]
)
def test_ranges_hold_the_function(constants):
    smooth = cq.Smooth(lambda x, y: np.sin(x) * np.cos(y) + 0.5 * y**2, **constants)
    found = smooth.range(*SIDES)
    assert found.lower.shape == (2, 2)
    for s in np.linspace(0, 1, 9):
        for t in np.linspace(0, 1, 9):
            x = SIDES[0].lower + s * (SIDES[0].upper - SIDES[0].lower)
            y = SIDES[1].lower + t * (SIDES[1].upper - SIDES[1].lower)
            values = smooth(x, y)
            assert (found.lower <= values).all()
            assert (values <= found.upper).all()


def test_second_derivatives_are_known_if_declared():
    assert cq.Smooth(np.sin, lipschitz=1.0).curvature(*SIDES) is None
    bends = cq.Smooth(np.sin, second_derivative=1.0).curvature(*SIDES)
    assert bends.xx.upper.shape == (2, 2)
    assert (bends.xy.lower <= -1.0).all()
    assert cq.Smooth(np.sin, second_derivative=1.0)(0.5) == np.sin(0.5)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (({"function": np.sin}), "nothing is known"),
        (({"function": 3.0, "lipschitz": 1.0}), "function must be"),
        (({"function": np.sin, "lipschitz": -1.0}), "lipschitz must be >= 0"),
        (({"function": np.sin, "second_derivative": np.inf}), "second_derivative must be finite"),
    ],
)
def test_what_is_refused(arguments, words):
    with pytest.raises((TypeError, ValueError), match=words):
        cq.Smooth(**arguments)
