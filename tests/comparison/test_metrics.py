"""Truth, true errors, and distances of contact sets, against plain formulas and exact numbers."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import enumerate_solution, lattice_masks, problems

import contactqp as cq
from contactqp.comparison.metrics import Truth, boundary_distance, contact_jaccard, intersection


@given(problems(), st.integers(0, 2**32 - 1))
def test_the_truth_of_several_answers_encloses_the_solution(problem, seed):
    """Each true error's bracket holds the distance from a solution found by trying every contact set."""
    rng = np.random.default_rng(seed)
    exact = enumerate_solution(problem)
    answers = [exact + 10.0 ** rng.uniform(-8, 0) * rng.normal(size=exact.size) for _ in range(3)]
    truth = intersection(cq.certify(problem, answer) for answer in answers)
    assert truth is not None
    slack = 1e-12 * (1 + np.abs(exact))
    assert (truth.lower <= exact + slack).all()
    assert (exact - slack <= truth.upper).all()
    for answer in answers:
        low, high = truth.error(answer)
        assert low - slack.max() <= np.abs(answer - exact).max() <= high + slack.max()
        assert high <= cq.certify(problem, answer).gap_bound * (1 + 1e-12) + slack.max()


@given(st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 3), min_size=1, max_size=5))
def test_true_errors_are_rounded_outwards(triples):
    numbers = np.array(triples)
    lower, upper, gap = (
        np.minimum(numbers[:, 0], numbers[:, 1]),
        np.maximum(numbers[:, 0], numbers[:, 1]),
        numbers[:, 2],
    )
    low, high = Truth(lower, upper).error(gap)
    exact = [(Fraction(a), Fraction(b), Fraction(g)) for a, b, g in zip(lower, upper, gap, strict=True)]
    assert Fraction(low) <= max(max(a - g, g - b, Fraction(0)) for a, b, g in exact)
    assert Fraction(high) >= max(max(abs(g - a), abs(b - g)) for a, b, g in exact)
    assert high == pytest.approx(float(max(max(abs(g - a), abs(b - g)) for a, b, g in exact)), rel=1e-12, abs=1e-300)


def test_an_unbounded_enclosure_says_nothing():
    low, high = Truth(np.array([0.0, -np.inf]), np.array([np.inf, np.inf])).error(np.array([1.0, 2.0]))
    assert (low, high) == (0.0, np.inf)


def test_contradicting_enclosures_have_no_intersection():
    problem = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 3.0]))
    other = cq.ContactQP(np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.1, 3.0]))
    first, second = cq.certify(problem, [0.5, 0.0]), cq.certify(other, [0.55, 0.0])
    assert intersection([first, second]) is None
    assert intersection([]) is None
    assert intersection([first]).width == (first.upper - first.lower).max()


def test_jaccard_distances():
    none, left, all_ = np.zeros(4, bool), np.array([True, True, False, False]), np.ones(4, bool)
    assert contact_jaccard(none, none) == 0.0
    assert contact_jaccard(none, left) == 1.0
    assert contact_jaccard(left, all_) == 0.5
    assert contact_jaccard(left, ~left) == 1.0


@given(lattice_masks(), st.integers(0, 2**32 - 1))
def test_the_free_boundary_against_plain_loops(mask, seed):
    lattice = cq.Lattice(mask, 0.5, origin=(1.0, -2.0))
    contact = np.random.default_rng(seed).uniform(size=lattice.size) < 0.5
    place = {(x, y): k for k, (x, y) in enumerate(zip(lattice.node_x, lattice.node_y, strict=True))}
    expected = set()
    for (x, y), k in place.items():
        for neighbour in ((x + 0.5, y), (x, y + 0.5)):
            if neighbour in place and contact[k] != contact[place[neighbour]]:
                expected.add(((x + neighbour[0]) / 2, (y + neighbour[1]) / 2))
    found = lattice.free_boundary(contact)
    assert found.shape == (len(expected), 2)
    assert set(map(tuple, found)) == expected


@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 12))
def test_the_boundary_distance_against_all_distances(seed, first_size, second_size):
    rng = np.random.default_rng(seed)
    first, second = rng.normal(size=(first_size, 2)), rng.normal(size=(second_size, 2))
    apart = np.hypot(*(first[:, None] - second[None]).transpose(2, 0, 1))
    expected = max(apart.min(axis=0).max(), apart.min(axis=1).max())
    assert boundary_distance(first, second) == pytest.approx(expected)
    assert boundary_distance(second, first) == pytest.approx(expected)


def test_boundaries_that_do_not_exist():
    nothing, point = np.empty((0, 2)), np.array([[1.0, 2.0]])
    assert boundary_distance(nothing, nothing) == 0.0
    assert boundary_distance(nothing, point) == np.inf
    assert boundary_distance(point, nothing) == np.inf
    assert boundary_distance(point, point) == 0.0
