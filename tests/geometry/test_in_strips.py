"""Functions of (x, y) on large lattices, which are evaluated for some rows at a time."""

import threading

import numpy as np
import pytest

import contactqp as cq
from contactqp.foundation import threads
from contactqp.geometry import fields
from contactqp.geometry.fields import in_strips, sample

PICTURE = np.array([[(i + 2 * j) % 7 > 0 for j in range(50)] for i in range(40)])
PICTURE[17:23] = False
LATTICE = cq.Lattice.from_mask(PICTURE, 0.25, (3.0, -2.0))


@pytest.fixture(autouse=True)
def few_points(monkeypatch):
    monkeypatch.setattr(fields, "_POINTS_OF_STRIP", 150)
    monkeypatch.setattr(fields, "_WORTH_STRIPS", 1000)
    monkeypatch.setattr(fields, "Team", lambda: threads.Team(3))
    monkeypatch.setattr(threads, "_POINTS_WORTH_A_THREAD", 100)


def wavy(x, y):
    return np.sin(3 * x) * y + np.where(x > 5, np.inf, 0.0)


def number_by_number(x, y):
    return x if x > y else y


@pytest.mark.parametrize("function", [wavy, number_by_number, lambda x, y: np.full(x.shape, np.nan)])
def test_strips_give_what_all_nodes_at_once_give(function):
    x, y = LATTICE.node_x, LATTICE.node_y
    whole = np.array([function(a, b) for a, b in zip(x, y, strict=True)]).ravel()
    assert np.array_equal(in_strips(LATTICE, function, "load"), whole, equal_nan=True)


def test_a_function_sees_vectors_of_some_rows_only():
    sizes = []

    def told(x, y):
        sizes.append((x.shape, y.shape))
        return x * y

    found = sample(LATTICE, told, "load")
    assert np.array_equal(found, LATTICE.node_x * LATTICE.node_y)
    assert all(one == other and len(one) == 1 for one, other in sizes)
    assert max(one[0] for one, _ in sizes[1:]) <= 150  # the first one are those that all others are compared with


def shifted(x, y):
    return y - y.mean()


def seeded(x, y):
    return np.random.default_rng(1).normal(size=x.shape)


def in_order(x, y):
    return np.arange(x.size) + 0.0


def rough(x, y):
    return np.gradient(x * y)


@pytest.mark.parametrize("function", [shifted, seeded, in_order, rough])
def test_a_function_of_all_nodes_together_is_given_them_all_at_once(function):
    assert in_strips(LATTICE, function, "load") is None
    assert np.array_equal(sample(LATTICE, function, "load"), function(LATTICE.node_x, LATTICE.node_y))


def test_a_number_stays_one_number():
    assert in_strips(LATTICE, lambda x, y: 2.0, "load") is None
    assert sample(LATTICE, lambda x, y: 2.0, "load").strides == (0,)


def test_next_to_no_rows_are_not_divided():
    line = cq.Lattice.from_mask(np.ones((1, 2000), dtype=bool), 1.0)
    assert in_strips(line, lambda x, y: x, "load") is None
    assert np.array_equal(sample(line, lambda x, y: x, "load"), line.node_x)


def test_what_fails_tells_of_all_nodes():
    def fails(x, y):
        raise RuntimeError("no data here")

    with pytest.raises(RuntimeError, match="no data here") as raised:
        sample(LATTICE, fails, "support")
    assert raised.value.__notes__ == [
        f"raised by the function that was given as support, called with x and y of {LATTICE.size} points"
    ]


def test_what_is_not_finite_is_told_of_by_its_node():
    with pytest.raises(ValueError, match="load must be finite, but is inf at node"):
        sample(LATTICE, wavy, "load")


def test_threads_do_with_numbers_that_overflow_what_the_caller_has_said():
    workers = set()

    def overflowing(x, y):
        workers.add(threading.get_ident())
        return np.exp(1000 * x) * np.exp(-1000 * x)

    with np.errstate(over="ignore", invalid="ignore"):
        assert np.isnan(in_strips(LATTICE, overflowing, "load")).any()
    assert len(workers) > 1
