"""The compiled passes of judge and certificate say what the passes in numpy say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import lattice_masks

import contactqp as cq
from contactqp import lattice_bounds
from contactqp.judge import compute_residuals, relative_bound
from contactqp.stencil import Stencil


def both(problem, gap, monkeypatch):
    found = []
    for least in (0, 10**9):
        monkeypatch.setattr(lattice_bounds, "_WORTH_COMPILED_PASSES", least)
        found.append((cq.certify(problem, gap), compute_residuals(problem, gap), relative_bound(problem, gap)))
    return found


@settings(max_examples=60)
@given(
    mask=lattice_masks(9, 9),
    arms=st.tuples(st.floats(0.01, 10), st.floats(0.01, 10)),
    seed=st.integers(0, 999),
    noise=st.sampled_from([0.0, 1e-9, 1e-3]),
    everywhere=st.booleans(),
)
def test_compiled_bounds_are_those_of_numpy(mask, arms, seed, noise, everywhere):
    rng = np.random.default_rng(seed)
    size = int(mask.sum())
    supported = None if everywhere else rng.uniform(size=size) < 0.8
    problem = cq.ContactQP(Stencil(mask, *arms), rng.normal(size=size), supported=supported)
    problem.reference = rng.normal(size=size)
    gap = cq.solve(problem, "clarabel", on_failure="ignore").gap + noise * rng.normal(size=size)
    with pytest.MonkeyPatch.context() as monkeypatch:
        (fast, measures, bound), (slow, residuals, slow_bound) = both(problem, gap, monkeypatch)
    np.testing.assert_allclose(fast.lower, slow.lower, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(fast.upper, slow.upper, rtol=1e-9, atol=1e-12)
    assert fast.gap_bound == pytest.approx(slow.gap_bound, rel=1e-6, abs=1e-13)
    assert (fast.clear == slow.clear).mean() > 0.99 or noise == 0
    assert not (fast.contact & slow.clear).any()
    assert measures.to_dict() == pytest.approx(residuals.to_dict(), rel=1e-9, abs=1e-11)
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
