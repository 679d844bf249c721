"""Foundations, ceilings and tension that varies against closed forms, by every backend that can."""

import numpy as np
import pytest
from strategies import BACKENDS

import contactqp as cq

TWO_SIDED = tuple(name for name in BACKENDS if name != "mangasarian")  # which refuses upper bounds
FINE = {"psor": {"stopping": "step", "stopping_length": 1e-13}}


def solved(model, backend, tol=1e-9):
    solution = cq.solve(model, backend, tol=tol, **FINE.get(backend, {}))
    assert solution.status == "certified"
    return solution


def error(made, backend):
    model, exact = made
    return np.abs(solved(model, backend).deflection - exact).max()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("make", [cq.gallery.cable_on_foundation, cq.gallery.cable_of_varying_tension])
def test_cables_converge_with_second_order(make, backend):
    coarse, fine = (error(make(5 * count - 1, 2 * count), backend) for count in (4, 16))
    assert np.log(coarse / fine) / np.log(4) == pytest.approx(2.0, abs=0.06)
    assert fine < 2e-5


@pytest.mark.parametrize("backend", BACKENDS)
def test_contact_of_cables_is_where_it_is(backend):
    for make in (cq.gallery.cable_on_foundation, cq.gallery.cable_of_varying_tension):
        cable, _ = make(79, 24)
        solution = solved(cable, backend)
        # What the discretisation moves is less than a spacing.
        assert abs(np.flatnonzero(solution.contact)[0] + 1 - 24) <= 1
        assert abs(80 - (np.flatnonzero(solution.contact)[-1] + 1) - 24) <= 1


@pytest.mark.parametrize("backend", TWO_SIDED)
@pytest.mark.parametrize(("half", "count"), [(5, 2), (20, 7), (16, 6)])
def test_between_floor_and_ceiling_the_discrete_answer_is_exact(half, count, backend):
    cable, exact = cq.gallery.cable_between_floor_and_ceiling(half, count)
    solution = solved(cable, backend)
    assert np.abs(solution.deflection - exact).max() <= 1e-9 * exact.max()
    node = np.arange(1, 2 * half)
    certain = solution.certificate
    inside = slice(count, half - count - 1)  # without the touchdown nodes, where half a load is left
    assert certain.contact_lower[inside].all()
    assert certain.contact_upper[::-1][inside].all()
    assert certain.clear[(np.minimum(node, 2 * half - node) < count) | (np.abs(node - half) < count)].all()
    balance = solution.force_balance
    assert balance.reaction == pytest.approx(balance.ceiling, rel=1e-7)
    assert balance.reaction == pytest.approx(half - 1 - (2 * count - 1), rel=1e-6)
    assert abs(balance.imbalance) < 1e-9


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_orthotropic_ellipse_is_exact_but_for_its_frame(backend):
    assert error(cq.gallery.orthotropic_ellipse(0.1), backend) < 1e-9
    coarse, fine = (error(cq.gallery.orthotropic_ellipse(spacing, fitted=False), backend) for spacing in (0.08, 0.04))
    assert 0.6 < np.log2(coarse / fine) < 1.4


SECOND_ORDER_ON_DISKS = 0.25
"""Error over the square of the spacing, or of the edges: it depends on how the contact's rim lies between the nodes."""


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_disk_on_a_floor_is_exact_to_second_order_on_a_fitted_lattice(backend):
    for nodes in (10, 20):
        for contact_radius in (0.4, 0.5, 0.6):
            made = cq.gallery.disk_on_floor(1 / nodes, contact_radius)
            assert error(made, backend) < SECOND_ORDER_ON_DISKS / nodes**2


@pytest.mark.parametrize("backend", [name for name in BACKENDS if name != "multigrid"])  # which refuses meshes
def test_a_disk_on_a_floor_is_exact_to_second_order_on_a_mesh(backend):
    for refinements in (3, 4):
        for contact_radius in (0.4, 0.5, 0.6):
            made = cq.gallery.meshed_disk_on_floor(refinements, contact_radius)
            assert error(made, backend) < SECOND_ORDER_ON_DISKS / 4**refinements


def test_disks_converge_with_second_order():
    """The largest error of several floors, as that of one goes up and down with the place of the contact's rim."""

    def largest(make, size):
        return max(error(make(size, a), "active-set") for a in (0.35, 0.4, 0.45, 0.5, 0.55, 0.6))

    for make, sizes in ((cq.gallery.disk_on_floor, (1 / 8, 1 / 64)), (cq.gallery.meshed_disk_on_floor, (3, 6))):
        coarse, fine = (largest(make, size) for size in sizes)
        assert np.log2(coarse / fine) / 3 >= 1.8


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_ellipse_with_two_tensions_is_exact_to_second_order_on_a_fitted_lattice(backend):
    """w = p(1 - x²/a² - y²/b²)/(2(T_x/a² + T_y/b²))."""
    from shapely import Point, affinity

    frame = cq.Frame.from_shapely(affinity.scale(Point(0, 0).buffer(1, quad_segs=2000), 1.5, 1.0))
    for spacing in (0.2, 0.1):
        model = cq.Membrane(frame.lattice(spacing, fitted=True), (2.0, 1.0), load=1.0, support=np.inf)
        shape = 1 - (model.node_x / 1.5) ** 2 - model.node_y**2
        assert error((model, shape / (2 * (2 / 1.5**2 + 1))), backend) < 0.1 * spacing**2


def everything():
    """A fabric of tension that varies, between two surfaces, on a foundation under a part of it."""
    lattice = cq.Frame.disk(2.0).lattice(0.16)
    return cq.Membrane(
        lattice,
        tension=(lambda x, y: 2 + x / 2, lambda x, y: np.where(y > 0.3, 3.0, 0.5)),
        load=lambda x, y: np.where(x < 0, 1.0, -1.0),
        support=0.1,
        ceiling=lambda x, y: -0.06 - 0.02 * y,
        foundation=lambda x, y: np.where(x > 0.5, 1.0, 0.0),
        frame_height=lambda x, y: 0.02 * y,
    )


def test_backends_agree_on_all_at_once():
    model = everything()
    comparison = cq.compare(model, list(TWO_SIDED), tol=1e-8)
    assert comparison.agree
    assert [row.status for row in comparison.rows] == ["certified"] * len(TWO_SIDED)
    best = comparison.best
    assert best.contact_lower.sum() > 20
    assert best.contact_upper.sum() > 20
    balance = best.force_balance
    assert min(balance.reaction, balance.ceiling, abs(balance.foundation), abs(balance.frame)) > 0.01
    assert abs(balance.imbalance) < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("nodes", [127, 383])
def test_multigrid_solves_large_ones(nodes):
    """The proof there is one of a barrier, which the foundation leaves one."""
    lattice = cq.Frame.rectangle(1.0, 1.0, center=(0.5, 0.5)).lattice(1 / (nodes + 1))
    model = cq.Membrane(
        lattice,
        tension=(2.0, 1.0),
        load=lambda x, y: 20 * np.sin(2 * np.pi * x) * np.sin(np.pi * y) + 8,
        support=0.2,
        ceiling=-0.02,
        foundation=lambda x, y: 30 * (x > 0.5),
    )
    solution = cq.solve(model, "multigrid", tol=1e-8)
    assert solution.status == "certified"
    assert solution.iterations < 30
    assert solution.certificate.barrier != "linear solve"
    assert solution.contact_lower.any()
    assert solution.contact_upper.any()
