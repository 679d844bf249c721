"""All backends on the same problems: certified, and in agreement."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import BACKENDS, enumerate_solution, lattice_masks, problems

import contactqp as cq
from contactqp import profiles
from contactqp.gallery import PAPER_LOADS
from contactqp.testing import assert_backends_agree


def channel():
    """A one-node-wide channel with bends and a dead end."""
    picture = ["#######", "#.....#", "#.###.#", "#.#...#", "#.#####", "#......"]
    return cq.Lattice.from_mask([[point == "#" for point in row] for row in picture], 1.0)


def free_shape(lattice, load):
    problem = cq.Membrane(lattice, 1.0, load=load, support=0.0).problem
    return np.linalg.solve(problem.G.toarray(), np.full(lattice.size, load * lattice.spacing**2))


def cases():
    square = cq.Frame.rectangle(10, 8).lattice(1.0)
    disk = cq.Frame.disk(1.0).lattice(0.08)
    one = cq.Lattice.from_mask(np.ones((1, 1), dtype=bool), 1.0)
    yield from ((f"hexagon {load:g}", cq.gallery.paper_hexagon(load)) for load in PAPER_LOADS)
    yield "rectangle", cq.Membrane(square, 2.0, load=0.1, support=0.25)
    yield "disk over a dome", cq.Membrane(disk, 1.0, load=1.0, support=profiles.Hemisphere(0.02, 0.5))
    yield "disk over a cone", cq.Membrane(disk, 1.0, load=1.0, support=profiles.Cone(-0.2, 1.0))
    yield "L with a hole", cq.gallery.l_shape_with_hole()
    yield "islands", cq.gallery.islands()
    yield "channel", cq.Membrane(channel(), 1.0, load=0.3, support=0.2)
    yield "one node, contact", cq.Membrane(one, 1.0, load=8.0, support=1.0)
    yield "one node, clear", cq.Membrane(one, 1.0, load=2.0, support=1.0)
    yield "one node, biactive", cq.Membrane(one, 1.0, load=4.0, support=1.0)
    yield "no contact", cq.Membrane(square, 1.0, load=0.1, support=100.0)
    yield "full contact", cq.Membrane(square, 1.0, load=9.0, support=0.0)
    yield (
        "full contact under a hill",
        cq.Membrane(square, 1.0, load=0.01, support=lambda x, y: -0.2 + 0.001 * (x**2 + y**2)),
    )
    yield "biactive", cq.Membrane(square, 1.0, load=0.25, support=free_shape(square, 0.25))
    yield "suction", cq.Membrane(square, 1.0, load=-0.2, support=0.1)
    yield "suction with a support above the frame", cq.Membrane(square, 1.0, load=-0.2, support=-0.5)
    yield "load of both signs", cq.Membrane(square, 1.0, load=lambda x, y: 0.3 * np.sign(x), support=0.4)
    yield "no load, no gap", cq.Membrane(square, 1.0, load=0.0, support=0.0)
    yield "raised frame", cq.Membrane(square, 1.0, load=0.1, support=1.0, frame_height=lambda x, y: 0.1 * x)
    yield "ball", cq.gallery.ball(31)[0]
    yield "bowl", cq.gallery.bowl(31)
    yield "cable", cq.gallery.cable_on_floor(nodes=79, contact_starts_after=25)[0]
    yield "cable over bumps", cq.Cable(span=50, spacing=1, tension=3, load=0.05, support=lambda x: 1 + np.sin(x / 3))


with warnings.catch_warnings():
    warnings.simplefilter("ignore", cq.ContactWarning)  # loads and heights of either sign are what is tried here
    CASES = dict(cases())


@pytest.mark.parametrize("name", list(CASES))
def test_all_backends_are_certified_and_agree(name):
    comparison = assert_backends_agree(CASES[name])
    assert [row.backend for row in comparison.rows] == list(BACKENDS)
    if "biactive" not in name and name != "no load, no gap":
        assert all(pair.contact_jaccard == 0 for pair in comparison.pairs)
        assert all(row.undecided == 0 for row in comparison.rows)


@pytest.mark.parametrize(("nodes", "start"), [(19, 6), (9, 4), (79, 25)])
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_cable_over_a_flat_floor_is_exact(nodes, start, backend):
    """Contact starts a = √(2Tf/p) from each end; the three-point scheme is exact for the parabola."""
    cable, exact = cq.gallery.cable_on_floor(nodes, start)
    options = {"stopping": "step", "stopping_length": 1e-15 * exact.max()} if backend == "psor" else {}
    solution = cq.solve(cable, backend, tol=1e-9, **options)
    np.testing.assert_allclose(solution.deflection, exact, atol=1e-12 * exact.max())
    touching = np.flatnonzero(solution.contact) + 1
    assert (touching[0], touching[-1]) == (start, nodes + 1 - start)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("force", "length"), [(1e12, 1.0), (1e-12, 1.0), (1.0, 1e9), (1.0, 1e-9), (1e-12, 1e9), (3e7, 7e-5)]
)
def test_units_change_neither_the_relative_answer_nor_the_iterations(backend, force, length):
    def model(force, length):
        lattice = cq.Frame.polygon(length * np.array(cq.gallery.PAPER_CORNERS)).lattice(length)
        surface = profiles.HillAndFloor()
        return cq.Membrane(
            lattice, tension=force, load=0.03 * force / length,
            support=lambda x, y: length * surface(np.round(x / length), np.round(y / length)),
        )  # fmt: skip

    reference, scaled = cq.solve(model(1.0, 1.0), backend), cq.solve(model(force, length), backend)
    assert scaled.status == "certified"
    assert scaled.iterations == pytest.approx(reference.iterations, rel=0.1)
    np.testing.assert_allclose(scaled.gap / length, reference.gap, atol=2e-6 * reference.problem.gap_scale)
    np.testing.assert_array_equal(scaled.contact, reference.contact)
    assert scaled.relative_bound < 1e-6


@given(problem=problems(max_size=8, spread=2.0))
def test_random_m_matrices(problem):
    exact = enumerate_solution(problem)
    comparison = assert_backends_agree(problem)
    for solution in comparison.solutions.values():
        certificate = solution.certificate
        room = 1e-11 * (1 + np.abs(exact))
        assert (certificate.lower <= exact + room).all()
        assert (exact - room <= certificate.upper).all()
        assert np.abs(solution.gap - exact).max() <= 1e-6 * problem.gap_scale + room.max()


@settings(max_examples=15)
@given(problem=problems(min_size=20, max_size=60, spread=3.0))
def test_larger_random_m_matrices(problem):
    assert_backends_agree(problem)


@settings(max_examples=30)
@given(mask=lattice_masks(), seed=st.integers(0, 999), holes=st.booleans())
@pytest.mark.filterwarnings("ignore::contactqp.ContactWarning")
def test_random_lattices(mask, seed, holes):
    rng = np.random.default_rng(seed)
    lattice = cq.Lattice.from_mask(mask, spacing=float(10 ** rng.uniform(-3, 3)))
    support = rng.uniform(-0.2, 1.0, lattice.size)
    if holes:
        support[rng.uniform(size=lattice.size) < 0.3] = np.inf
    load = rng.normal(size=lattice.size) / lattice.spacing**2
    assert_backends_agree(cq.Membrane(lattice, 1.0, load=load, support=support))


@given(problem=problems(max_size=8), seed=st.integers(0, 999))
def test_renumbering_the_nodes_renumbers_the_answer(problem, seed):
    order = np.random.default_rng(seed).permutation(problem.size)
    renumbered = cq.ContactQP(
        problem.G.toarray()[np.ix_(order, order)], problem.q[order], supported=problem.supported[order]
    )
    one, other = cq.solve(problem, "clarabel", tol=1e-8), cq.solve(renumbered, "clarabel", tol=1e-8)
    np.testing.assert_allclose(other.gap, one.gap[order], atol=3e-8 * problem.gap_scale)


@given(mask=lattice_masks(), seed=st.integers(0, 999), backend=st.sampled_from(BACKENDS))
def test_more_load_presses_the_membrane_down_and_contact_only_grows(mask, seed, backend):
    """The paper's monotonicity: p ≤ p' gives w ≤ w', and under proportional loading contact is never lost."""
    rng = np.random.default_rng(seed)
    lattice = cq.Lattice.from_mask(mask, 1.0)
    shape, support = rng.uniform(0.0, 1.0, lattice.size), rng.uniform(0.1, 1.0, lattice.size)
    less, more = (cq.solve(cq.Membrane(lattice, 1.0, load=k * shape, support=support), backend) for k in (1.0, 1.6))
    margin = less.certificate.gap_bound + more.certificate.gap_bound
    assert (more.deflection >= less.deflection - margin).all()
    assert not (less.certificate.contact & more.certificate.clear).any()


@given(problem=problems(max_size=8), factor=st.floats(-6, 6))
def test_forces_and_stiffness_scale_out(problem, factor):
    scale = 10.0**factor
    scaled = cq.ContactQP(problem.G * scale, problem.q * scale, supported=problem.supported)
    one, other = cq.solve(problem, "clarabel", tol=1e-8), cq.solve(scaled, "clarabel", tol=1e-8)
    np.testing.assert_allclose(other.gap, one.gap, atol=3e-8 * problem.gap_scale)


def test_the_answer_has_the_hexagons_symmetry():
    membrane = cq.gallery.paper_hexagon()
    solution = cq.solve(membrane, "psor")
    grid = membrane.lattice.scatter(solution.gap, fill=0.0)
    for mirrored in (grid[::-1], grid[:, ::-1]):
        np.testing.assert_allclose(mirrored, grid, atol=2e-6 * solution.problem.gap_scale)


@pytest.mark.parametrize(("nodes", "error"), [(31, 5.75e-3)])
def test_the_exact_ball(nodes, error):
    """Bueler (2021), ch. 12: the maximal error of the five-point scheme on 33 x 33 points is 5.75e-3."""
    model, exact = cq.gallery.ball(nodes)
    solution = cq.solve(model, "clarabel", tol=1e-8)
    assert np.abs(solution.deflection - exact).max() == pytest.approx(error, rel=2e-3)
