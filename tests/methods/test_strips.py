"""A lattice whose rows are divided: what each process holds, and the same bits as on the whole lattice."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from peers import by_peers

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.foundation.threads import Team
from contactqp.geometry.numbering import Layout
from contactqp.geometry.runs import SUPPORTED
from contactqp.methods.multigrid.arms import Arms, arms_of
from contactqp.methods.multigrid.contact import NO_LIMITS
from contactqp.methods.multigrid.nested import nested_start
from contactqp.methods.multigrid.rows import BLOCK, HALO, Rows
from contactqp.methods.multigrid.strips import Idle, Merged, Strip, divided, merged, merging


def cycled(lattice, q, height, limits, cycles=3, threads=1):
    """Return gap, estimates, changes and cut corrections of some cycles from a nested start."""
    facts = []
    with Team(threads) as team:
        solver = nested_start(lattice, q, height, team, limits=limits)
        for _ in range(cycles):
            solver.relax()
            solver.correct()
            facts.append((solver.estimate, solver.changes, solver.cut, solver.damping, solver.rest(), solver.work))
        solver.relax()
    return solver.omega, facts


def window(array, part):
    return np.ascontiguousarray(array[part.offset : part.offset + part.height])


def divided_cycles(lattice, q, height, limits, peer, least):
    """Return the own rows of what `cycled` returns, of one of several peers."""
    edges = divided(lattice.rows, peer.size, least)
    part = Strip(peer, tuple(edges), least)
    whole = lattice.layout
    kinds = np.full(whole.mask.shape, SUPPORTED, dtype=np.uint8) if whole.kinds is None else whole.kinds
    mask, kinds = (window(np.pad(points, 1), part)[1:-1, 1:-1] for points in (whole.mask, kinds))
    layout = Layout(np.ascontiguousarray(mask), np.ascontiguousarray(kinds))

    def held(arms, more):
        # An array of arms along columns has one row more than the mask.
        return arms if isinstance(arms, float) else np.ascontiguousarray(arms[part.offset :][: part.height - 2 + more])

    arms = held(lattice.across, 0), held(lattice.along, 1), held(lattice.ground, 0)
    own = Arms(layout, *arms, part=part)
    bounds = tuple(window(bound, part) for bound in limits) if limits[0].size else NO_LIMITS
    omega, facts = cycled(own, window(q, part), window(height, part), bounds)
    first = 0 if peer.rank == 0 else part.first
    last = part.height if peer.rank == peer.size - 1 else part.last
    return omega[first:last], facts


def stiffness(rng, kind, rows, columns) -> tuple[Any, Any, Any]:
    """Return arms along rows and along columns, and to the ground: jumping by blocks where they vary."""
    if kind == "strong":
        return 0.02, 0.48, 0.0
    arms: tuple[Any, Any, Any] = 0.25, 0.25, 0.0
    if "varying" in kind:
        blocks = 10.0 ** rng.integers(-1, 2, (9, 9))
        across, along = (
            blocks[np.ix_(*(np.arange(count) * 9 // count for count in shape))] * rng.uniform(0.5, 1.0, shape)
            for shape in ((rows, columns + 1), (rows + 1, columns))
        )
        arms = across, along, 0.0
    if "foundation" in kind:
        arms = *arms[:2], np.where(rng.uniform(size=(rows, columns)) < 0.4, rng.uniform(0.0, 0.1, (rows, columns)), 0.0)
    return arms


KINDS = (
    "rectangle",
    "masked",
    "two-sided",
    "strong",
    "masked foundation",
    "varying",
    "masked varying",
    "two-sided varying foundation",
)


@given(st.integers(0, 9999), st.sampled_from([2, 3, 5, 9]), st.sampled_from(KINDS))
@settings(max_examples=20)
def test_divided_rows_give_the_same_bits(seed, size, kind):
    rng = np.random.default_rng(seed)
    rows, columns = int(rng.integers(BLOCK * size, BLOCK * (size + 5))), int(rng.integers(7, 60))
    mask = np.ones((rows, columns), dtype=bool)
    if "masked" in kind:
        mask = rng.uniform(size=(rows, columns)) < 0.9
    stencil = Stencil(mask, *stiffness(rng, kind, rows, columns))
    lower: Any = 0.0
    upper: Any = np.inf
    if "two-sided" in kind:
        lower = np.where(rng.uniform(size=stencil.size) < 0.2, -np.inf, 0.0)
        upper = np.where(rng.uniform(size=stencil.size) < 0.5, rng.uniform(0.0, 2.0, stencil.size), np.inf)
    problem = cq.ContactQP(stencil, rng.normal(size=stencil.size), lower, upper)
    lattice = arms_of(stencil, problem.layout)
    q, height = lattice.layout.grid(problem.q), lattice.layout.grid(rng.uniform(size=stencil.size))
    limits = problem.bound_grids()
    expected, facts = cycled(lattice, q, height, limits)
    found = by_peers(size, lambda peer: divided_cycles(lattice, q, height, limits, peer, BLOCK))
    np.testing.assert_array_equal(np.concatenate([own for own, _ in found]), expected)
    assert all(told == facts for _, told in found)


def test_no_number_depends_on_threads():
    """Where arms differ, every cycle goes by sums over all nodes."""
    rng = np.random.default_rng(5)
    arms = rng.uniform(0.1, 1.0, (400, 701)), rng.uniform(0.1, 1.0, (401, 700))
    stencil = Stencil(np.ones((400, 700), dtype=bool), *arms)
    problem = cq.ContactQP(stencil, rng.normal(size=stencil.size))
    lattice = arms_of(stencil, problem.layout)
    q, height = lattice.layout.grid(problem.q), lattice.layout.zeros()
    found = [cycled(lattice, q, height, NO_LIMITS, threads=threads) for threads in (1, 3)]
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert found[0][1] == found[1][1]


def test_strips_begin_where_blocks_do_and_hold_a_halo():
    edges = divided(511, 3)
    assert edges == [1, 160, 352, 512]

    def told(peer):
        part = Strip(peer, tuple(edges))
        below = part.coarser(255, 255, 2)
        return part.offset, part.height, part.first, part.last, part.near(5), below.own, type(below), part.blocks

    first, middle, last = by_peers(3, told)
    assert first[:5] == (0, 160 + HALO, 1, 160, (1, 165))
    assert middle[:5] == (152, 192 + 2 * HALO, 8, 200, (3, 205))
    assert last[:5] == (344, 513 - 344, 8, 168, (3, 168))
    assert [one[5] for one in (first, middle, last)] == [(1, 80), (80, 176), (176, 256)]
    assert {one[6] for one in (first, middle, last)} == {Strip}
    assert first[7][:2] == [(1, 16), (16, 32)]
    assert middle[7][0] == (8, 24)


def test_blocks_are_the_same_whoever_holds_them():
    whole = Rows(131).blocks
    edges = divided(131, 4, BLOCK)

    def told(peer):
        part = Strip(peer, tuple(edges), BLOCK)
        return part.everyones([(low + part.offset, high + part.offset) for low, high in part.blocks])

    assert by_peers(4, told) == [whole] * 4


def test_strips_of_few_rows_are_merged_and_come_back():
    """Five strips of 16 rows are two of 16 and 24 on the next level, and one on the level after that."""
    grid = np.arange(82.0)[:, None] * np.ones(3)

    def told(peer):
        part = Strip(peer, tuple(divided(80, 5, BLOCK)), BLOCK)
        below = part.coarser(40, 10, 2)
        planes = np.zeros((2, below.height, 3))
        first, last = (row - below.offset for row in below.own_with_ring)
        planes[:, first:last] = 1 + peer.rank
        below.share(planes, axis=1)
        picked = below.picked(window(grid, part), part, 2)[:, 0]
        worked_on = below.alone
        assert (worked_on.offset, worked_on.height) == (below.offset, below.height)
        answer = np.zeros((below.height, 1))
        if not worked_on.idle:
            answer[...] = np.arange(below.offset, below.offset + below.height)[:, None]
        below.hand_back(answer, 2)
        mine = range(max(0, below.own[0] - 2), min(42, below.own[1] + 2))
        assert answer[mine.start - below.offset : mine.stop - below.offset, 0].tolist() == list(mine)
        return type(worked_on), worked_on.own, picked.tolist(), planes[1, :, 2].tolist()

    first, second, third, fourth, fifth = by_peers(5, told)
    assert [one[0] for one in (first, second, third, fourth, fifth)] == [Strip, Idle, Strip, Idle, Idle]
    assert (first[1], third[1]) == ((1, 16), (16, 41))
    assert first[2] == [*range(0, 48, 2)]
    assert third[2] == [*range(16, 82, 2), 81]
    assert first[3] == [1.0] * 8 + [2.0] * 8 + [3.0] * 8
    assert third[3] == [2.0] * 8 + [3.0] * 8 + [4.0] * 8 + [5.0] * 10


@given(st.integers(1, 200), st.integers(0, 10_000), st.sampled_from([1, 16, 17, 32, 64]))
@settings(max_examples=100)
def test_strips_are_merged_in_pairs_and_never_have_fewer_rows_than_a_block(size, more, least):
    rows = BLOCK * size + more
    edges = tuple(divided(rows, size, least))
    enough = rows >= max(least, BLOCK) * size
    while size > 1:
        heights = np.diff([0, *edges[1:]])
        assert heights.min() >= BLOCK
        assert not any(edge % BLOCK for edge in edges[1:-1])
        rows //= 2
        below = (1, *(edge // 2 for edge in edges[1:-1]), rows + 1)
        step = merging(below, least)
        assert step <= 2 or not enough
        edges, size = merged(below, step), size // step
        assert len(edges) == size + 1


@pytest.mark.parametrize(("rows", "size", "least", "most"), [(9882 * 32, 9882, 64, 1.51), (316_227, 1000, 64, 1.25)])
def test_strips_are_of_about_equal_height(rows, size, least, most):
    assert np.diff(divided(rows, size, least)).max() * size / rows < most


def test_a_level_of_few_points_is_held_by_the_first():
    def told(peer):
        below = Strip(peer, tuple(divided(400, 3, BLOCK)), BLOCK).coarser(200, 1, 2)
        assert isinstance(below, Merged)
        return below.alone.height, below.alone.idle

    assert by_peers(3, told) == [(202, False), (80, True), (82, True)]


def test_too_many_processes_for_so_few_rows_are_refused():
    with pytest.raises(ValueError, match="40 rows of nodes are too few for 3 processes"):
        divided(40, 3)
