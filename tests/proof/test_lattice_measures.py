"""The compiled passes of judge and certificate say what the passes in numpy say."""

from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import bounds, lattice_masks

import contactqp as cq
from contactqp.algebra.stencil import Stencil
from contactqp.proof import lattice_measures
from contactqp.proof.judge import judge
from contactqp.proof.measure import measure


def both(problem, gap, monkeypatch):
    found = []
    for least in (0, 10**9):
        monkeypatch.setattr(lattice_measures, "_WORTH_COMPILED_PASSES", least)
        measures = measure(problem, gap)
        found.append((measures.certificate(), asdict(measures.residuals), measures.relative_bound))
    return found


@settings(max_examples=60)
@given(
    mask=lattice_masks(9, 9),
    arms=st.tuples(st.floats(0.01, 10), st.floats(0.01, 10)),
    seed=st.integers(0, 999),
    noise=st.sampled_from([0.0, 1e-9, 1e-3]),
    everywhere=st.booleans(),
    one_sided=st.booleans(),
    data=st.data(),
)
def test_compiled_bounds_are_those_of_numpy(mask, arms, seed, noise, everywhere, one_sided, data):
    rng = np.random.default_rng(seed)
    size = int(mask.sum())
    supported = None if everywhere else rng.uniform(size=size) < 0.8
    lower, upper = (0.0, np.inf) if one_sided else data.draw(bounds(size))
    problem = cq.ContactQP(
        Stencil(mask, *arms), rng.normal(size=size), lower, upper, supported=supported, reference=rng.normal(size=size)
    )
    gap = cq.solve(problem, "clarabel", on_failure="ignore").gap + noise * rng.normal(size=size)
    with pytest.MonkeyPatch.context() as monkeypatch:
        (fast, measures, bound), (slow, residuals, slow_bound) = both(problem, gap, monkeypatch)
    # Beside the frame the compiled pass proves less contact, which closes the enclosure from the other side.
    same, same_above = fast.contact_lower == slow.contact_lower, fast.contact_upper == slow.contact_upper
    assert (fast.contact <= slow.contact).mean() > 0.99 or noise == 0
    np.testing.assert_allclose(fast.lower[same_above], slow.lower[same_above], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(fast.upper[same], slow.upper[same], rtol=1e-9, atol=1e-12)
    assert fast.gap_bound == pytest.approx(slow.gap_bound, rel=1e-6, abs=1e-13)
    assert (fast.clear == slow.clear).mean() > 0.99 or noise == 0
    assert not (fast.contact & slow.clear).any()
    assert (fast.contact_upper <= fast.contact).all()
    assert not (fast.contact_upper & slow.contact_lower).any()
    assert measures == pytest.approx(residuals, rel=1e-9, abs=1e-11)
    assert slow_bound * (1 - 1e-6) <= bound <= 2.1 * slow_bound + 1e-13


def test_numbers_that_overflow_prove_nothing(monkeypatch):
    problem = cq.ContactQP(Stencil(np.ones((3, 3), dtype=bool), 1.0, 1.0), np.full(9, -1.0))
    with np.errstate(over="ignore", invalid="ignore"):
        found = both(problem, np.array([1e308, -1e308, *[0.0] * 7]), monkeypatch)
    for certificate, _, bound in found:
        assert certificate.gap_bound == np.inf
        assert not certificate.contact.any()
        assert not certificate.clear.any()
        assert bound == np.inf


@pytest.mark.parametrize("arms", [(1e308, 1e308), (4.6e307, 4.6e307), (1e308, 0.0)])
def test_arms_that_overflow_together_are_refused(arms):
    with pytest.raises(ValueError, match=r"arms together overflows: .* values up to [14].*take larger units"):
        Stencil(np.ones((1, 2), dtype=bool), *arms)


def test_scales_keep_their_ratio_to_the_edge_of_the_range():
    scales = [
        cq.ContactQP(Stencil(np.ones((30, 30), dtype=bool), arm, arm), np.full(900, -1e-5 * arm)).gap_scale
        for arm in (1.0, 1e-290, 1e300, 1e307)
    ]
    np.testing.assert_allclose(scales, scales[0], rtol=1e-12)
    nothing = cq.ContactQP(Stencil(np.ones((1, 2), dtype=bool), 1.0, 1.0), [-1e-319, -1e-319])
    assert judge(nothing, np.zeros(2), 1e-6).status == cq.Status.INACCURATE


def test_large_numbers_overflow_in_both_or_in_neither(monkeypatch):
    x = np.arange(1.0, 100.0)
    problem = cq.ContactQP(Stencil(np.ones((1, 99), dtype=bool), 4e303, 0.0), np.full(99, -40 * 4e303), gap_scale=1e5)
    with np.errstate(over="ignore", invalid="ignore"):
        found = both(problem, 20 * x * (100 - x), monkeypatch)
    for certificate, _, bound in found:
        assert certificate.gap_bound < 1e-7
        assert bound < 1e-12


def test_any_kind_of_gap_is_taken(monkeypatch):
    monkeypatch.setattr(lattice_measures, "_WORTH_COMPILED_PASSES", 0)
    problem = cq.ContactQP(Stencil(np.ones((3, 3), dtype=bool), 1.0, 1.0), np.full(9, -1.0))
    for gap in (np.zeros(18)[::2], np.zeros(9, dtype=np.float32), np.zeros(9, dtype=int)):
        assert measure(problem, gap).relative_bound == measure(problem, np.zeros(9)).relative_bound
        assert judge(problem, gap, 1e-6).certificate is not None


def test_the_bound_that_stops_is_that_of_the_judge_on_a_ring(monkeypatch):
    radius = np.hypot(*np.mgrid[-40:41, -40:41])
    mask = (radius < 40) & (radius > 36)
    problem = cq.ContactQP(Stencil(mask, 1.0, 1.0), np.full(mask.sum(), -1.0))
    for certificate, _, bound in both(problem, np.full(mask.sum(), 1e-3), monkeypatch):
        assert bound * measure(problem, np.full(mask.sum(), 1e-3)).scale == pytest.approx(
            certificate.gap_bound, rel=0.01
        )
