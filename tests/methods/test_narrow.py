"""Active sets on narrow bands in twice the precision: the interior point, its kernels, and the exchanges."""

from typing import Any

import numpy as np
import pytest
from meshes import beam_on_floor, beam_over_floor
from rational import exact_solution
from scipy import sparse

import contactqp as cq
from contactqp.algebra.band import Band
from contactqp.algebra.narrow_band import NarrowBand
from contactqp.methods.active_set import interior_point_kernels
from contactqp.methods.active_set.interior_point import InteriorPoint
from contactqp.methods.active_set.narrow import NarrowActiveSet

kernels: Any = interior_point_kernels


def banded(rng, size, width):
    lower = np.tril(np.triu(rng.normal(size=(size, size)), -width))
    matrix = lower @ lower.T + 10.0 ** rng.uniform(-6, 0) * np.eye(size)
    matrix = (matrix + matrix.T) / 2
    return matrix / matrix.diagonal().max()


def bounds(rng, size, kind):
    """Return bounds below and above zero, or at it: from below alone, on both sides, or of every sort."""
    if kind == "one":
        return np.zeros(size), np.zeros(0)
    lower, upper = -rng.uniform(0.0, 1.0, size), rng.uniform(0.0, 1.0, size)
    if kind == "mixed":
        lower[rng.uniform(size=size) < 0.3] = -np.inf
        upper[rng.uniform(size=size) < 0.3] = np.inf
        fixed = rng.uniform(size=size) < 0.1
        lower[fixed] = upper[fixed] = 0.0
    return lower, upper


def iteration(matrix, q, lower, upper):
    band = Band(sparse.csr_array(matrix))
    return NarrowActiveSet(band, NarrowBand.of(band), q, lower, upper)


def solved(active_set, most=80):
    for steps in range(1, most + 1):
        if active_set.step().finished:
            return active_set.feasible(), steps
    raise AssertionError(f"no end after {most} steps")


@pytest.mark.parametrize("kind", ["one", "both", "mixed"])
@pytest.mark.parametrize("seed", range(25))
def test_random_bands_are_solved_as_in_rational_numbers(seed, kind):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(2, 11))
    matrix = banded(rng, size, int(rng.integers(1, min(size, 9))))
    lower, upper = bounds(rng, size, kind)
    q = rng.normal(size=size) * 10.0 ** rng.uniform(-6, 2)
    gap, _ = solved(iteration(matrix, q, lower, upper))
    exact, _ = exact_solution(cq.ContactQP(matrix, q, lower, upper if upper.size else np.inf))
    wanted = np.array([float(x) for x in exact])
    np.testing.assert_allclose(gap, wanted, rtol=1e-9, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("kind", ["one", "both", "mixed"])
def test_a_warm_start_and_other_forces_lead_to_the_same(kind):
    rng = np.random.default_rng(5)
    matrix = banded(rng, 60, 3)
    lower, upper = bounds(rng, 60, kind)
    q = rng.normal(size=60)
    active_set = iteration(matrix, q, lower, upper)
    gap, _ = solved(active_set)
    active_set.restart(q, lower, upper)
    active_set.start_from(gap)
    again, steps = solved(active_set)
    np.testing.assert_array_equal(again, gap)
    assert steps == 1
    active_set.restart(-q, lower, upper)
    active_set.start_from(gap)
    other, _ = solved(active_set)
    np.testing.assert_allclose(other, solved(iteration(matrix, -q, lower, upper))[0], atol=1e-14)


def test_where_gap_and_reaction_vanish_together_it_comes_to_an_end():
    """Nothing pushes and nothing pulls: each set is a right one."""
    matrix = banded(np.random.default_rng(0), 12, 2)
    gap, _ = solved(iteration(matrix, np.zeros(12), np.zeros(12), np.zeros(0)))
    assert not gap.any()
    held = np.zeros(12)
    held[3:7] = 1.0
    gap, _ = solved(iteration(matrix, -matrix @ held, np.zeros(12), np.zeros(0)))
    np.testing.assert_allclose(gap, held, atol=1e-12)


@pytest.mark.parametrize("clamped", [False, True])
def test_a_long_beam_comes_to_rest_in_few_steps_where_it_should(clamped):
    nodes = 10_000
    matrix, q, spacing = beam_on_floor(nodes, clamped=clamped)
    scale = np.ldexp(1.0, int(np.log2(matrix[5, 5])))
    gap, steps = solved(iteration(matrix / scale, q / scale, np.zeros(nodes), np.zeros(0)))
    assert steps < 30
    touchdown = spacing * (1 + np.flatnonzero(gap == 0)[0])
    assert abs(touchdown - ((72 if clamped else 24) * 0.5) ** 0.25) <= spacing
    assert np.abs(gap - beam_over_floor(nodes, clamped=clamped)).max() < 0.3 * spacing**2


def random_state(rng, size=20):
    """Return a gap, bounds, reactions and their distances, some bounds missing."""
    high, low = rng.normal(size=size), 1e-17 * rng.normal(size=size)
    lower = np.where(rng.uniform(size=size) < 0.7, high - rng.uniform(0.1, 1, size), -np.inf)
    upper = np.where(rng.uniform(size=size) < 0.5, high + rng.uniform(0.1, 1, size), np.inf)
    press = np.where(np.isfinite(lower), rng.uniform(0.1, 1, size), 0.0)
    pull = np.where(np.isfinite(upper), rng.uniform(0.1, 1, size), 0.0)
    return (high, low), (lower, upper), (press, pull)


def twin_changes(way, distances, reactions, aims):
    above, below = distances
    press, pull = reactions
    return (aims[0] - press * way) / above - press, (aims[1] + pull * way) / below - pull


@pytest.mark.parametrize("seed", range(10))
def test_passes_match_their_twins(seed):
    rng = np.random.default_rng(seed)
    omega, limits, reactions = random_state(rng)
    size = omega[0].size
    distances, springs = (np.empty(size), np.empty(size)), np.empty(size)
    total = kernels.measure(*omega, *limits, *reactions, *distances, springs)
    above, below = omega[0] - limits[0], limits[1] - omega[0]
    there = np.isfinite(above), np.isfinite(below)
    np.testing.assert_allclose(distances, (above, below), atol=1e-15)
    np.testing.assert_allclose(springs, reactions[0] / above + reactions[1] / below, rtol=1e-12)
    products = [
        (reaction[at] * distance[at]).sum() for reaction, distance, at in zip(reactions, distances, there, strict=True)
    ]
    assert total == pytest.approx(sum(products))

    way, none = rng.normal(size=size), np.zeros(size)
    first, second = twin_changes(way, distances, reactions, (none, none))
    length = 0.3
    after = (above + length * way)[there[0]] * (reactions[0] + length * first)[there[0]]
    after_above = (below - length * way)[there[1]] * (reactions[1] + length * second)[there[1]]
    left = kernels.left(length, way, *distances, *reactions)
    assert left == pytest.approx(after.sum() + after_above.sum())

    aims, force = (np.empty(size), np.empty(size)), np.empty(size)
    kernels.aim_at(0.1, way, *distances, *reactions, *aims, force)
    np.testing.assert_allclose(aims[0], np.where(there[0], 0.1 - way * first, 0.0), rtol=1e-12)
    np.testing.assert_allclose(aims[1], np.where(there[1], 0.1 + way * second, 0.0), rtol=1e-12)
    np.testing.assert_allclose(force, aims[0] / above - aims[1] / below, rtol=1e-10, atol=1e-14)

    first, second = twin_changes(way, distances, reactions, aims)
    shares = [-way / above, way / below, -first[there[0]] / reactions[0][there[0]]]
    shares.append(-second[there[1]] / reactions[1][there[1]])
    fastest = kernels.fastest(way, *distances, *reactions, *aims)
    assert fastest == pytest.approx(max(0.0, *(share.max(initial=0.0) for share in shares)))

    length = 0.9 / max(1.0, fastest)
    before = [array.copy() for array in (*omega, *reactions)]
    held = np.empty(size, dtype=bool), np.empty(size, dtype=bool)
    kernels.go(length, way, none, *omega, *limits, *distances, *reactions, *aims, *held)
    np.testing.assert_allclose(omega[0], before[0] + length * way, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(reactions[0], before[2] + length * first, rtol=1e-12)
    np.testing.assert_allclose(reactions[1], before[3] + length * second, rtol=1e-12)
    shrinks = np.full((2, size), False)
    for k, (gap, distance) in enumerate(((omega[0] - limits[0], above), (limits[1] - omega[0], below))):
        at = there[k]
        shrinks[k, at] = gap[at] / distance[at] < reactions[k][at] / before[2 + k][at]
    np.testing.assert_array_equal(held[0], shrinks[0])
    np.testing.assert_array_equal(held[1], shrinks[1] & ~shrinks[0])


def test_an_interior_point_keeps_off_its_bounds_and_lets_its_products_fall():
    rng = np.random.default_rng(3)
    matrix = banded(rng, 30, 2)
    lower, upper = bounds(rng, 30, "both")
    point = InteriorPoint(NarrowBand.of(Band(sparse.csr_array(matrix))), rng.normal(size=30), lower, upper)
    for _ in range(15):
        point.step()
        high, low = point.omega
        assert ((high - lower) + low > 0).all()
        assert ((upper - high) - low > 0).all()
    assert point.reduction < 1e-8
    assert (point.held[0] | point.held[1]).any()


def test_an_interior_point_at_rest_goes_nowhere():
    """Without bounds no product of distance and reaction is left to be reduced."""
    band = NarrowBand(np.array([[2.0, -1.0], [2.0, -1.0], [2.0, 0.0]]))
    point = InteriorPoint(band, np.ones(3), np.full(3, -np.inf), np.full(3, np.inf))
    before = point.omega[0].copy()
    assert point.at_rest
    point.step()
    assert point.omega[0].tolist() == before.tolist()
