"""Beams against closed forms, by every backend that can, and what cannot says why."""

import numpy as np
import pytest
from strategies import BACKENDS

import contactqp as cq

CAPABLE = ("active-set", "clarabel", "osqp")
ITERATING = ("psor", "mprgp")
Z_MATRIX = tuple(name for name in BACKENDS if name in ("mangasarian", "multigrid"))


@pytest.mark.parametrize("backend", CAPABLE)
@pytest.mark.parametrize(("end", "share"), [("pinned", 1 / 2), ("clamped", 1 / 3)])
def test_a_heavy_beam_comes_down_where_it_should(backend, end, share):
    beam, exact = cq.gallery.beam_on_floor(49, 13, end)
    solution = cq.solve(beam, backend, tol=1e-6)
    assert solution.status == cq.Status.CERTIFIED
    assert np.abs(solution.deflection - exact).max() < 1e-2 * exact.max()
    spans = beam.spans(solution)
    spacing, a = beam.lattice.spacing, 13 / 50
    assert abs(spans["start"][1] - a) <= 1.001 * spacing
    assert spans["force_at_start"][1] == pytest.approx(share * a, abs=2 * spacing)
    assert abs(solution.force_balance.imbalance) < 1e-12


def error(made, backend):
    model, exact = made
    solution = cq.solve(model, backend, tol=1e-6)
    assert solution.status == cq.Status.CERTIFIED
    return np.abs(solution.deflection - exact).max()


@pytest.mark.parametrize("backend", CAPABLE)
@pytest.mark.parametrize("end", ["pinned", "clamped"])
@pytest.mark.parametrize("make", [cq.gallery.beam_on_floor, cq.gallery.beam_on_foundation])
def test_beams_converge_with_second_order(make, end, backend):
    coarse, fine = (error(make(20 * k - 1, 6 * k, end), backend) for k in (1, 4))
    assert np.log2(coarse / fine) / 2 >= 1.8


@pytest.mark.parametrize("backend", CAPABLE)
def test_a_beam_between_floor_and_ceiling_converges_with_second_order(backend):
    coarse, fine = (error(cq.gallery.beam_between_floor_and_ceiling(10 * k, 4 * k), backend) for k in (1, 2))
    assert np.log2(coarse / fine) >= 1.8


@pytest.mark.parametrize("backend", ITERATING)
def test_what_relaxes_takes_short_beams(backend):
    """The condition of a beam's matrix grows with the fourth power of its nodes, and so do sweeps."""
    makes = cq.gallery.beam_on_floor, cq.gallery.beam_on_foundation
    beams = [make(11, 4, end) for make in makes for end in ("pinned", "clamped")]
    for made in (*beams, cq.gallery.beam_between_floor_and_ceiling(8, 3)):
        assert error(made, backend) < 0.1 * made[1].max()


def test_beams_whose_foundation_carries_all_are_refused():
    with pytest.raises(ValueError, match=r"contact_starts_after must be < 15\.14, got 16: .* so stiff a foundation"):
        cq.gallery.beam_on_foundation(39, 16, stiffness=6000.0)


@pytest.mark.parametrize("backend", CAPABLE)
def test_between_two_surfaces_on_springs(backend):
    beam = cq.Beam(
        4.0,
        spacing=0.1,
        bending_stiffness=0.05,
        tension=0.2,
        load=lambda x: np.where(x < 2, 1.0, -1.0),
        support=0.1,
        ceiling=-0.1,
        foundation=0.3,
        ends=("clamped", "pinned"),
    )
    solution = cq.solve(beam, backend, tol=1e-6)
    best = cq.solve(beam, tol=1e-9)
    assert solution.status == cq.Status.CERTIFIED
    assert np.abs(solution.gap - best.gap).max() < 1e-6
    assert solution.contact_lower.any()
    assert solution.contact_upper.any()


@pytest.mark.parametrize("backend", Z_MATRIX)
def test_what_needs_an_m_matrix_refuses_in_words(backend):
    beam, _ = cq.gallery.beam_on_floor(19, 5)
    with pytest.raises(cq.UnsuitableProblemError, match=r"positive off-diagonal|Z-matrix|lattice"):
        cq.solve(beam, backend)


@pytest.mark.parametrize("backend", CAPABLE)
def test_a_plate_converges_to_naviers_series(backend):
    found = []
    for nodes in (7, 15):
        plate, exact = cq.gallery.plate_under_load(nodes)
        found.append(np.abs(cq.solve(plate, backend).deflection - exact).max())
    assert np.log2(found[0] / found[1]) >= 1.9


def test_backends_agree_on_a_plate_in_contact():
    plate = cq.Plate(cq.Frame.rectangle(1.0, 1.0).lattice(0.1), 1.0, load=3000.0, support=lambda x, y: 0.5 + x**2)
    comparison = cq.compare(plate, list(CAPABLE), tol=1e-6)
    assert comparison.agree
    assert comparison.best.contact.any()
