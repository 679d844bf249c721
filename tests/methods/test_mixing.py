"""Anderson's acceleration of fixed-point iterations."""

import numpy as np

from contactqp.methods.mixing import Mixing


def iterations(depth, residual, start, tolerance=1e-10):
    mixing, place = Mixing(depth), start
    for done in range(1000):
        left = residual(place)
        if np.abs(left).max() <= tolerance:
            return done, place
        place = mixing.next(place, left)
    raise AssertionError("it does not end")


def test_linear_iterations_end_after_as_many_steps_as_there_are_modes():
    rates = np.array([0.1, 0.35, 0.7, 0.97])
    wanted = np.array([1.0, -2.0, 0.5, 3.0])

    def residual(place):
        return (1 - rates) * (wanted - place)

    plain, _ = iterations(1, residual, np.zeros(4))
    mixed, found = iterations(6, residual, np.zeros(4))
    assert plain > 500
    assert mixed <= 7
    np.testing.assert_allclose(found, wanted, atol=1e-8)


def test_curved_ones_are_faster_too():
    def residual(place):
        return 0.2 * (np.cos(place) - place)

    plain, _ = iterations(1, residual, np.array([0.3, -1.0, 2.0]))
    mixed, found = iterations(5, residual, np.array([0.3, -1.0, 2.0]))
    assert mixed < plain / 3
    np.testing.assert_allclose(found, 0.7390851332151607, atol=1e-9)
